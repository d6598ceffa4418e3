"""Evaluate designs: every quantity of every mode pair, in one compiled loop.

Mirror symmetry makes "--" the image of "++", and of "+-" and "-+" half the angles will do.
"""

from __future__ import annotations

import math
import threading
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.passive_leg.columns import ONE_SIGN, PASSIVE_JOINTS, set_samples
from fivebar_atlas.mechanisms.passive_leg.indices import (
    AREA,
    FIXED,
    INTEGRALS,
    LCI,
    LCI_WIDTH,
    MANIPULABILITY,
    MANIPULABILITY_WIDTH,
    MAX_THRESHOLDS,
    UNSEEN_SHARE,
    WIDTH,
    Integrals,
    integrate_part,
    largest_lci,
    set_rule,
)
from fivebar_atlas.mechanisms.passive_leg.workspace import (
    GRID_STEPS,
    add_angle,
    add_known_angles,
    find_runs,
    largest_part,
)
from fivebar_atlas.numerics.records import allocate_record

# Bits of ``status``.
EMPTY_USABLE_WORKSPACE = 1
DEGENERATE_DESIGN = 2
TOLERANCE_NOT_REACHED = 4
UNBOUNDED_MANIPULABILITY = 8

# Columns of a result, before the thresholds' six columns each.
REACHED, REACHED_ERROR, FREE, FREE_ERROR, USABLE, USABLE_ERROR = range(6)
GCI, GCI_ERROR, GMI, GMI_ERROR = range(6, 10)
GCI_L_THETA, GCI_L_THETA_ERROR, GMI_L_THETA, GMI_L_THETA_ERROR = range(10, 14)
L_THETA, L_THETA_ERROR, MAX_LCI, MAX_X, MAX_Y, STATUS, COLUMNS = range(14, 21)

# What is smooth is integrated to rounding, relative to itself.
_ROUNDING = 1e-14


class _Kept(threading.local):
    """The work space of each thread, kept from call to call."""

    integrals: Integrals | None = None


_KEPT = _Kept()


def work_space() -> Integrals:
    """Return the work space of this thread."""
    if _KEPT.integrals is None:
        made: Integrals = allocate_record(INTEGRALS)
        set_rule(made)
        set_samples(made.runs.column)
        _KEPT.integrals = made
    return _KEPT.integrals


@kernel
def integrate_workspace(
    w: Integrals, r: float, l_a: float, l_b: float, theta_limit: float,
    elbow1: float, elbow2: float, sign: float, conditions: int, thresholds: FloatArray,
    tolerance: float, has_indices: bool,
) -> tuple[int, bool]:  # fmt: skip
    """Find the largest part of the workspace and integrate over it.

    Parameters
    ----------
    w
        Work space; receives ``total`` and ``total_error``, those of the whole part.
    r, l_a, l_b, elbow1, elbow2, sign
        As for :func:`columns.find_column`.
    theta_limit
        Largest angle of the passive leg, at most π/2.
    conditions
        As for :func:`columns.find_column`; with none all parts count together.
    thresholds, tolerance, has_indices
        As for :func:`indices.integrate_part`.

    Returns
    -------
    state : int
        -1: empty, 0: done, 1: tolerance not reached.
    has_forward : bool
        Whether a forward singularity bounds it, so that the manipulability is unbounded.
    """
    is_half = elbow1 == -elbow2
    start = 0.0 if is_half else -theta_limit
    steps = GRID_STEPS if is_half else 2 * GRID_STEPS
    if conditions == 0:  # columns in closed form
        steps *= 4
    state, is_mirrored, has_forward = 1, False, False
    add_known_angles(w.runs, r, l_a, l_b, start, theta_limit, conditions)
    while True:
        has_room = find_runs(
            w.runs, r, l_a, l_b, start, theta_limit, elbow1, elbow2, sign, conditions, steps
        )
        part, is_mirrored, has_forward = largest_part(w.runs, is_half)
        if part < 0:
            w.total[:] = 0.0
            w.total_error[:] = 0.0
            return -1, False
        state = integrate_part(
            w, part if conditions != 0 else -1, r, l_a, l_b, elbow1, elbow2, sign, conditions,
            thresholds, tolerance, has_indices, not has_forward,
        )  # fmt: skip
        if not has_room:
            state = 1
        # a kind of column between two of the grid is looked for again where it was met
        if state != 2 or not add_angle(w.runs, w.missed[0]):
            break
    if state == 2 or not has_room:
        # columns are rounding, as about O for R = r = l_a = l_b: nothing but the size is known
        w.total[:] = math.nan
        w.total_error[:] = math.nan
        w.total[AREA] = w.total_error[AREA] = w.runs.part_area[part]
    copies = 2.0 if is_half and (is_mirrored or conditions == 0) else 1.0
    for k in range(len(w.total)):
        w.total[k] *= copies
        w.total_error[k] = copies * w.total_error[k] + _ROUNDING * abs(w.total[k])
    return min(state, 1), has_forward


@kernel
def _mean(w: Integrals, k: int, over: int) -> tuple[float, float]:
    """Return the mean of an integral over the workspace, and its error."""
    mean = w.total[k] / w.total[over]
    return mean, (w.total_error[k] + mean * w.total_error[over]) / w.total[over]


@kernel
def evaluate_design(
    w: Integrals, r: float, l_a: float, l_b: float, theta_limit: float,
    elbow1: float, elbow2: float, sign: float, has_limits: bool, thresholds: FloatArray,
    tolerance: float, out: FloatArray,
) -> None:  # fmt: skip
    """Compute all quantities of one mode pair of one design into a row.

    Parameters
    ----------
    w
        Work space.
    r, l_a, l_b
        Design, R = 1.
    theta_limit
        Largest angle of the passive leg in radians, at most π/2.
    elbow1, elbow2
        Elbows as for :func:`kinematics.lower_link`.
    sign
        Sign of det J_x in the mode pair.
    has_limits
        Whether the passive joints are limited.
    thresholds
        LCI thresholds, at most MAX_THRESHOLDS.
    tolerance
        Relative tolerance.
    out
        Receives the columns named above, then area, GCI, manipulability, each with its error,
        for each threshold, shape (COLUMNS + 6 k,).
    """
    out[:] = math.nan
    for k in range(6):
        out[k] = 0.0
    out[L_THETA], out[L_THETA_ERROR] = 0.0, 0.0
    for kind in range(len(thresholds)):
        out[COLUMNS + 6 * kind] = 0.0
        out[COLUMNS + 6 * kind + 1] = 0.0
    if not (r > 0.0 and l_a > 0.0 and l_b > 0.0):
        out[STATUS] = EMPTY_USABLE_WORKSPACE | DEGENERATE_DESIGN
        return
    status = 0
    usable = ONE_SIGN | PASSIVE_JOINTS if has_limits else ONE_SIGN
    has_forward = False
    for stage in range(3):
        # all that is reached, then free of singularities, then within all limits
        if stage == 1 and not has_limits:
            continue
        conditions = 0 if stage == 0 else (ONE_SIGN if stage == 1 else usable)
        state, has_forward = integrate_workspace(
            w, r, l_a, l_b, theta_limit, elbow1, elbow2, sign, conditions, thresholds,
            tolerance, stage == 2,
        )  # fmt: skip
        out[2 * stage], out[2 * stage + 1] = w.total[AREA], w.total_error[AREA]
        if state == 1:
            status |= TOLERANCE_NOT_REACHED
        if state < 0 and stage != 1:
            out[STATUS] = status | EMPTY_USABLE_WORKSPACE
            return
    if not has_limits:
        out[FREE], out[FREE_ERROR] = out[USABLE], out[USABLE_ERROR]
    out[L_THETA], out[L_THETA_ERROR] = w.total[WIDTH], w.total_error[WIDTH]
    out[GCI], out[GCI_ERROR] = _mean(w, LCI, AREA)
    out[GCI_L_THETA], out[GCI_L_THETA_ERROR] = _mean(w, LCI_WIDTH, WIDTH)
    if has_forward:
        status |= UNBOUNDED_MANIPULABILITY
    else:
        out[GMI], out[GMI_ERROR] = _mean(w, MANIPULABILITY, AREA)
        out[GMI_L_THETA], out[GMI_L_THETA_ERROR] = _mean(w, MANIPULABILITY_WIDTH, WIDTH)
    lci, length, theta = largest_lci(w, r, l_a, l_b, theta_limit, elbow1, elbow2, sign, usable)
    for kind in range(len(thresholds)):
        at, column = FIXED + 3 * kind, COLUMNS + 6 * kind
        area, threshold = w.total[at], thresholds[kind]
        unseen = UNSEEN_SHARE * tolerance * w.total[AREA] if lci > threshold else 0.0
        out[column], out[column + 1] = area, w.total_error[at] + unseen
        if area > 0.0:
            for which in range(2):
                mean = w.total[at + 1 + which] / area
                error = w.total_error[at + 1 + which] + mean * w.total_error[at]
                # the LCI of what is unseen is near the threshold
                error += unseen * (mean - threshold if which == 0 else mean)
                out[column + 2 + 2 * which], out[column + 3 + 2 * which] = mean, error / area
            # the LCI lies between the threshold and 1
            out[column + 3] = min(out[column + 3], 1.0 - threshold)
    # of mirror images the one at positive x
    if elbow1 == -elbow2:
        theta = -abs(theta)
    out[MAX_LCI], out[MAX_X], out[MAX_Y] = lci, -length * math.sin(theta), length * math.cos(theta)
    out[STATUS] = status


@kernel
def evaluate_rows(
    w: Integrals, designs: FloatArray, modes: FloatArray, theta_limit: float, has_limits: bool,
    thresholds: FloatArray, tolerance: float, out: FloatArray,
) -> None:  # fmt: skip
    """Evaluate designs, shape (n, 3), in mode pairs given by elbow1, elbow2 and sign, shape (m, 3).

    Parameters
    ----------
    w, theta_limit, has_limits, thresholds, tolerance
        As for :func:`evaluate_design`.
    designs, modes
        What is evaluated.
    out
        Receives the rows, shape (n, m, columns).
    """
    for n in range(len(designs)):
        for m in range(len(modes)):
            evaluate_design(
                w, designs[n, 0], designs[n, 1], designs[n, 2], theta_limit,
                modes[m, 0], modes[m, 1], modes[m, 2], has_limits, thresholds, tolerance,
                out[n, m],
            )  # fmt: skip


def evaluate_designs(
    designs: FloatArray, modes: IntArray, theta_limit: float, has_limits: bool,
    lci_thresholds: FloatArray, tolerance: float,
) -> dict[str, npt.NDArray[Any]]:  # fmt: skip
    """Evaluate designs; the GIL is released in the compiled loop.

    Parameters
    ----------
    designs
        r, l_a, l_b with R = 1, shape (n, 3).
    modes
        elbow1, elbow2 and the sign of det J_x as ±1, shape (m, 3).
    theta_limit
        Largest angle of the passive leg in radians, at most π/2.
    has_limits
        Whether the passive joints are limited.
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
    # "--" is the mirror image of "++"
    is_image = (modes[:, 0] > 0) & (modes[:, 1] > 0)
    signs = np.where(is_image[:, None], modes * [-1, -1, 1], modes).astype(np.float64)
    kinds, places = np.unique(signs, axis=0, return_inverse=True)
    places = places.reshape(-1)
    w = work_space()
    # the kernels treat so many thresholds together; the rest take further passes
    parts = []
    for start in range(0, max(len(lci_thresholds), 1), MAX_THRESHOLDS):
        some = np.ascontiguousarray(lci_thresholds[start : start + MAX_THRESHOLDS])
        rows = np.empty((len(designs), len(kinds), COLUMNS + 6 * len(some)))
        evaluate_rows(w, designs, kinds, theta_limit, has_limits, some, tolerance, rows)
        parts.append(rows)
    rows = np.concatenate([parts[0], *(part[:, :, COLUMNS:] for part in parts[1:])], axis=2)
    picked = rows[:, places, :]
    good = picked[:, :, COLUMNS:].reshape(len(designs), len(modes), len(lci_thresholds), 6)
    r, l_a, l_b = designs.T
    # where the legs cannot be stretched at θ = 0 there is no such size
    with np.errstate(invalid="ignore"):
        size = (r + 1.0) * np.sqrt((l_a + l_b) ** 2 - (1.0 - r) ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        utilisation = picked[:, :, [USABLE, USABLE_ERROR, L_THETA, L_THETA_ERROR]]
        utilisation = utilisation / size[:, None, None]
    return {
        "workspace_area": rows[:, 0, REACHED],
        "workspace_area_error": rows[:, 0, REACHED_ERROR],
        "singularity_free_workspace_area": picked[:, :, FREE],
        "singularity_free_workspace_area_error": picked[:, :, FREE_ERROR],
        "usable_workspace_area": picked[:, :, USABLE],
        "usable_workspace_area_error": picked[:, :, USABLE_ERROR],
        "gci": picked[:, :, GCI],
        "gci_error": picked[:, :, GCI_ERROR],
        "gmi": picked[:, :, GMI],
        "gmi_error": picked[:, :, GMI_ERROR],
        "space_utilisation": utilisation[..., 0],
        "space_utilisation_error": utilisation[..., 1],
        "space_utilisation_l_theta": utilisation[..., 2],
        "space_utilisation_l_theta_error": utilisation[..., 3],
        "gci_l_theta": picked[:, :, GCI_L_THETA],
        "gci_l_theta_error": picked[:, :, GCI_L_THETA_ERROR],
        "gmi_l_theta": picked[:, :, GMI_L_THETA],
        "gmi_l_theta_error": picked[:, :, GMI_L_THETA_ERROR],
        "max_lci": picked[:, :, MAX_LCI],
        "max_lci_x": np.where(is_image, -1.0, 1.0) * picked[:, :, MAX_X],
        "max_lci_y": picked[:, :, MAX_Y],
        "status": picked[:, :, STATUS].astype(np.int16),
        "good_condition_workspace_area": good[..., 0],
        "good_condition_workspace_area_error": good[..., 1],
        "good_condition_gci": good[..., 2],
        "good_condition_gci_error": good[..., 3],
        "good_condition_gmi": good[..., 4],
        "good_condition_gmi_error": good[..., 5],
    }
