"""Evaluate designs: every quantity of every mode pair, in one compiled loop.

Mirror symmetry reduces the eight mode pairs to three computations; see :mod:`mirror`.
"""

from __future__ import annotations

import math
import threading
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.five_bar.indices import integrate_strips, largest_lci
from fivebar_atlas.mechanisms.five_bar.inscribed_circle import (
    ARCS,
    Arcs,
    collect_arcs,
    maximal_inscribed_circle,
)
from fivebar_atlas.mechanisms.five_bar.isotropy import isotropic_points
from fivebar_atlas.mechanisms.five_bar.jacobian import threshold_ratio
from fivebar_atlas.mechanisms.five_bar.mirror import CLASS_SIGNS, CLASSES, canonical_class
from fivebar_atlas.mechanisms.five_bar.panels import PANELS, Panels, set_rules
from fivebar_atlas.mechanisms.five_bar.rays import MAX_THRESHOLDS
from fivebar_atlas.mechanisms.five_bar.workspace import (
    AREA_ROUNDING,
    DECOMPOSITION,
    Decomposition,
    is_degenerate,
    theoretical_area,
    usable_workspace,
)
from fivebar_atlas.numerics.records import allocate_record, record_type

# Bits of ``status``.
EMPTY_USABLE_WORKSPACE = 1
DEGENERATE_DESIGN = 2
TOLERANCE_NOT_REACHED = 4
NO_UPPER_INSCRIBED_CIRCLE = 8
NO_LOWER_INSCRIBED_CIRCLE = 16

# Columns of one computation's result, before the thresholds' four columns each.
AREA, AREA_ERROR, GCI, GCI_ERROR, MAX_LCI, MAX_X, MAX_Y = 0, 1, 2, 3, 4, 5, 6
UPPER_RADIUS, UPPER_Y, LOWER_RADIUS, LOWER_Y, STATUS, FIXED = 7, 8, 9, 10, 11, 12


class Scratch(Protocol):
    """Everything a thread needs to evaluate one design after another."""

    decomposition: Decomposition
    panels: Panels
    arcs: Arcs


SCRATCH = record_type(
    ("decomposition", DECOMPOSITION, ()), ("panels", PANELS, ()), ("arcs", ARCS, ())
)


def allocate_scratch() -> Scratch:
    """Return the work space of one thread."""
    scratch: Scratch = allocate_record(SCRATCH)
    set_rules(scratch.panels)
    return scratch


class _Kept(threading.local):
    """The work space of each thread, kept from call to call."""

    scratch: Scratch | None = None


_KEPT = _Kept()


def _scratch() -> Scratch:
    """Return the work space of this thread."""
    if _KEPT.scratch is None:
        _KEPT.scratch = allocate_scratch()
    return _KEPT.scratch


@kernel
def evaluate_class(
    w: Scratch, r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
    ratios: FloatArray, tolerance: float, out: FloatArray,
) -> None:  # fmt: skip
    """Compute all quantities of one mode pair of one non-dimensional design into a row.

    Parameters
    ----------
    w
        Work arrays.
    r1, r2, r3
        Non-dimensional lengths, sum 3.
    s1, s2, assembly
        Working and assembly mode as ±1.
    ratios
        Threshold ratios, shape (k,).
    tolerance
        Relative tolerance.
    out
        Receives the columns named above, then area, its error, GCI, its error for each
        threshold, shape (FIXED + 4 k,).
    """
    d, p = w.decomposition, w.panels
    thresholds = len(ratios)
    out[:] = math.nan
    out[AREA] = 0.0
    out[AREA_ERROR] = 0.0
    for kind in range(thresholds):
        out[FIXED + 4 * kind] = 0.0
        out[FIXED + 4 * kind + 1] = 0.0
    empty = EMPTY_USABLE_WORKSPACE | NO_UPPER_INSCRIBED_CIRCLE | NO_LOWER_INSCRIBED_CIRCLE
    if is_degenerate(r1, r2, r3, s1, s2):
        out[STATUS] = empty | DEGENERATE_DESIGN
        return
    sectors, component, strips, copies, area, area_error = usable_workspace(
        r1, r2, r3, s1, s2, assembly, d
    )
    if component < 0:
        out[STATUS] = empty
        return
    status = 0
    isotropic = isotropic_points(r1, r2, r3, s1, s2, p.isotropic)
    reached = integrate_strips(
        p, d, strips, isotropic, ratios, tolerance, area, r1, r2, r3, s1, s2, assembly
    )
    if not reached or area_error > tolerance * area:
        status |= TOLERANCE_NOT_REACHED
    gci = p.total[0] / area
    out[AREA] = copies * area
    out[AREA_ERROR] = copies * area_error
    out[GCI] = gci
    out[GCI_ERROR] = (p.total_error[0] + gci * area_error) / area
    for kind in range(thresholds):
        good, good_error = p.total[1 + kind], p.total_error[1 + kind]
        column = FIXED + 4 * kind
        out[column] = copies * good
        out[column + 1] = copies * (good_error + area_error)
        if good > 0.0:
            good_gci = p.total[1 + thresholds + kind] / good
            out[column + 2] = good_gci
            out[column + 3] = (p.total_error[1 + thresholds + kind] + good_gci * good_error) / good
    out[MAX_LCI], out[MAX_X], out[MAX_Y] = largest_lci(
        p, d, strips, isotropic, r1, r2, r3, s1, s2, assembly
    )
    arcs = collect_arcs(w.arcs, d, r1, r2, r3, strips)
    for half in range(2):
        radius, y = maximal_inscribed_circle(
            w.arcs, arcs, d, r1, r2, r3, sectors, component, half == 0
        )
        if radius > 0.0:
            out[UPPER_RADIUS if half == 0 else LOWER_RADIUS] = radius
            out[UPPER_Y if half == 0 else LOWER_Y] = y
        else:
            status |= NO_UPPER_INSCRIBED_CIRCLE if half == 0 else NO_LOWER_INSCRIBED_CIRCLE
    out[STATUS] = status


@kernel
def evaluate_rows(
    w: Scratch, designs: FloatArray, classes: IntArray, ratios: FloatArray, tolerance: float,
    theoretical: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Evaluate designs, shape (n, 3), in those of the three classes that are asked for.

    Parameters
    ----------
    w, designs, ratios, tolerance
        As for :func:`evaluate_class`.
    classes
        The classes to compute, 0: "+-"/up, 1: "+-"/down, 2: "++"/up, shape (m,).
    theoretical
        Receives the theoretical workspace area, shape (n,).
    out
        Receives a row for each design and class, shape (n, CLASSES, columns).
    """
    for n in range(len(designs)):
        r1, r2, r3 = designs[n, 0], designs[n, 1], designs[n, 2]
        theoretical[n] = theoretical_area(r1, r2, r3)
        for kind in classes:
            s1, s2, assembly = CLASS_SIGNS[kind]
            evaluate_class(w, r1, r2, r3, s1, s2, assembly, ratios, tolerance, out[n, kind])


def evaluate_designs(
    designs: FloatArray, modes: IntArray, lci_thresholds: FloatArray, tolerance: float
) -> dict[str, npt.NDArray[Any]]:
    """Evaluate non-dimensional designs; the GIL is released in the compiled loop.

    Parameters
    ----------
    designs
        r1, r2, r3 with sum 3, shape (n, 3).
    modes
        s1, s2 and the sign of det B as ±1, shape (m, 3).
    lci_thresholds
        Thresholds in (0, 1), shape (k,).
    tolerance
        Relative tolerance of every integrated quantity.

    Returns
    -------
    dict
        Arrays by dataset name, shapes (n,), (n, m) or (n, m, k). Areas are 0 where the
        workspace is empty; what does not exist is NaN, explained by ``status``.
    """
    designs = np.ascontiguousarray(designs, dtype=np.float64)
    mapped = [canonical_class(*(int(v) for v in mode)) for mode in modes]
    classes = np.array(sorted({kind for kind, _, _ in mapped}), dtype=np.int64)
    theoretical = np.empty(len(designs))
    scratch = _scratch()
    # the kernels treat so many thresholds together; the rest take further passes
    parts = []
    for start in range(0, max(len(lci_thresholds), 1), MAX_THRESHOLDS):
        part = lci_thresholds[start : start + MAX_THRESHOLDS]
        ratios = np.array([threshold_ratio(float(t)) for t in part], dtype=np.float64)
        rows = np.empty((len(designs), CLASSES, FIXED + 4 * len(part)))
        evaluate_rows(scratch, designs, classes, ratios, tolerance, theoretical, rows)
        parts.append(rows)
    rows = np.concatenate([parts[0], *(part[:, :, FIXED:] for part in parts[1:])], axis=2)

    kinds = [kind for kind, _, _ in mapped]
    x_sign = np.array([-1.0 if mirror_x else 1.0 for _, mirror_x, _ in mapped])
    y_sign = np.array([-1.0 if mirror_y else 1.0 for _, _, mirror_y in mapped])
    picked = rows[:, kinds, :]
    upside_down = y_sign < 0.0
    status = picked[:, :, STATUS].astype(np.int16)
    no_upper = (status & NO_UPPER_INSCRIBED_CIRCLE) != 0
    no_lower = (status & NO_LOWER_INSCRIBED_CIRCLE) != 0
    swapped = status & ~(NO_UPPER_INSCRIBED_CIRCLE | NO_LOWER_INSCRIBED_CIRCLE)
    swapped = swapped | no_lower * NO_UPPER_INSCRIBED_CIRCLE | no_upper * NO_LOWER_INSCRIBED_CIRCLE
    good = picked[:, :, FIXED:].reshape(len(designs), len(mapped), len(lci_thresholds), 4)
    return {
        "theoretical_workspace_area": theoretical,
        "theoretical_workspace_area_error": AREA_ROUNDING
        * 4.0
        * (designs[:, 0] + designs[:, 1]) ** 2,
        "usable_workspace_area": picked[:, :, AREA],
        "usable_workspace_area_error": picked[:, :, AREA_ERROR],
        "gci": picked[:, :, GCI],
        "gci_error": picked[:, :, GCI_ERROR],
        "max_lci": picked[:, :, MAX_LCI],
        "max_lci_x": picked[:, :, MAX_X] * x_sign,
        "max_lci_y": picked[:, :, MAX_Y] * y_sign,
        "mic_upper_radius": np.where(
            upside_down, picked[:, :, LOWER_RADIUS], picked[:, :, UPPER_RADIUS]
        ),
        "mic_upper_y": np.where(upside_down, -picked[:, :, LOWER_Y], picked[:, :, UPPER_Y]),
        "mic_lower_radius": np.where(
            upside_down, picked[:, :, UPPER_RADIUS], picked[:, :, LOWER_RADIUS]
        ),
        "mic_lower_y": np.where(upside_down, -picked[:, :, UPPER_Y], picked[:, :, LOWER_Y]),
        "status": np.where(upside_down, swapped, status).astype(np.int16),
        "good_condition_workspace_area": good[..., 0],
        "good_condition_workspace_area_error": good[..., 1],
        "good_condition_gci": good[..., 2],
        "good_condition_gci_error": good[..., 3],
    }
