"""The largest scale of a shape in many designs, from samples of the shape; and what it brings.

For searches over whole design spaces: one compiled loop, no outline of any workspace. A
shape is connected, so that where the LCI of all of it is above a threshold and det B has one
sign, one of its points tells whether it lies in the usable workspace. What holds between
samples is for those to check who use a result.
"""

from __future__ import annotations

import math

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.jacobian import distal_products, matrices, threshold_ratio
from fivebar_atlas.mechanisms.five_bar.kinematics import elbow, inverse, reaches
from fivebar_atlas.mechanisms.five_bar.mirror import CLASS_SIGNS, canonical_class
from fivebar_atlas.mechanisms.five_bar.workspace import (
    DECOMPOSITION,
    Decomposition,
    contains,
    is_degenerate,
    usable_workspace,
)
from fivebar_atlas.mechanisms.planar import PlacedExtremes, PlacementScan
from fivebar_atlas.numerics.records import allocate_record

# Columns of a row of :func:`scan_placements`, one row for each half plane.
SCALE, X, Y, COLUMNS = 0, 1, 2, 3
#: Half planes above and below the base, which have a best placement each.
HALVES = 2
# Columns of :func:`extremes_on_samples`.
MOVE, TORQUE, LEAST_X, GREATEST_X, LEAST_Y, GREATEST_Y, EXTREMES = 0, 1, 2, 3, 4, 5, 6
# How much larger a scale must be to be worth another look, and halvings of a step.
_BETTER, _HALVINGS, _GROWTH = 1.001, 12, 1.5


@kernel
def _fits(
    r1: float, r2: float, r3: float, x: float, y: float, scale: float, samples: FloatArray,
    s1: float, s2: float, assembly: float, ratio: float, limits: FloatArray,
) -> bool:  # fmt: skip
    """Tell whether all samples of a shape are good, in whatever component of the mode pair."""
    for k in range(len(samples)):
        px = x + scale * samples[k, 0]
        py = y + scale * samples[k, 1]
        w1, w2, cross, _, size = distal_products(r1, r2, r3, px, py, s1, s2)
        if not (cross * assembly > 0.0 and w1 * w2 > 0.0):
            return False
        if 2.0 * w1 * w2 * abs(cross) < ratio * size * (w1 * w1 + w2 * w2):
            return False
    if len(limits):
        for k in range(len(samples)):
            theta1, theta2 = inverse(
                r1, r2, r3, x + scale * samples[k, 0], y + scale * samples[k, 1], s1, s2
            )
            for row in range(len(limits)):
                off = (theta1 if limits[row, 0] == 0.0 else theta2) - limits[row, 1]
                off -= 2.0 * math.pi * math.floor(off / (2.0 * math.pi) + 0.5)
                if abs(off) > limits[row, 2]:
                    return False
    return True


@kernel
def _is_inside(
    d: Decomposition, r1: float, r2: float, r3: float, strips: int, symmetric: bool,
    x: float, y: float,
) -> bool:  # fmt: skip
    """Tell whether a point, mirrored into the class that is decomposed, is in its workspace."""
    if symmetric:
        x = abs(x)
    phi = math.atan2(y, x)
    if phi < -0.5 * math.pi:
        phi += 2.0 * math.pi
    return contains(d, r1, r2, r3, strips, phi, math.sqrt(x * x + y * y))


@kernel
def _scan_design(
    d: Decomposition, r1: float, r2: float, r3: float, floor: float, cap: float,
    kind: int, x_sign: float, y_sign: float, s1: float, s2: float, assembly: float,
    ratio: float, samples: FloatArray, anchors: FloatArray, limits: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill in the best placement of either half plane, shape (HALVES, COLUMNS)."""
    out[:, :] = 0.0
    reach_y2 = (r1 + r2) * (r1 + r2) - r3 * r3
    if not floor < cap or reach_y2 <= 0.0 or is_degenerate(r1, r2, r3, s1, s2):
        return
    reach_x, reach_y = r1 + r2 - r3, math.sqrt(reach_y2)
    strips, symmetric, is_known = 0, False, False
    for a in range(len(anchors)):
        x, y = anchors[a, 0] * reach_x, anchors[a, 1] * reach_y
        half = 0 if y >= 0.0 else 1
        lower = max(floor, _BETTER * out[half, SCALE])
        if not lower < cap:
            continue
        if not _fits(r1, r2, r3, x, y, lower, samples, s1, s2, assembly, ratio, limits):
            continue
        if not is_known:
            c1, c2, c_assembly = CLASS_SIGNS[kind]
            _, component, strips, copies, _, _ = usable_workspace(r1, r2, r3, c1, c2, c_assembly, d)
            if component < 0:
                return
            symmetric, is_known = c1 != c2 and copies == 2.0, True
        px, py = x_sign * (x + lower * samples[0, 0]), y_sign * (y + lower * samples[0, 1])
        if not _is_inside(d, r1, r2, r3, strips, symmetric, px, py):
            continue
        upper = lower
        while upper < cap:
            upper = min(_GROWTH * upper, cap)
            if not _fits(r1, r2, r3, x, y, upper, samples, s1, s2, assembly, ratio, limits):
                break
            lower = upper
        if lower < upper:
            for _ in range(_HALVINGS):
                middle = 0.5 * (lower + upper)
                if _fits(r1, r2, r3, x, y, middle, samples, s1, s2, assembly, ratio, limits):
                    lower = middle
                else:
                    upper = middle
        out[half, SCALE] = lower
        out[half, X], out[half, Y] = x, y


@kernel
def scan_placements(
    d: Decomposition, designs: FloatArray, floors: FloatArray, caps: FloatArray,
    kind: int, x_sign: float, y_sign: float, s1: float, s2: float, assembly: float,
    ratio: float, samples: FloatArray, anchors: FloatArray, limits: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Find the largest scale of a shape, and where, for many designs and one mode pair.

    Parameters
    ----------
    d
        Work arrays.
    designs
        r1, r2, r3 with sum 3, shape (n, 3).
    floors, caps
        Least and greatest scale that is wanted, shape (n,).
    kind, x_sign, y_sign
        Class of the mode pair, and -1 where points are mirrored into it; see :mod:`mirror`.
    s1, s2, assembly
        The mode pair as ±1.
    ratio
        :func:`threshold_ratio` of the LCI threshold.
    samples
        Points of the shape relative to its centre, shape (k, 2).
    anchors
        Positions of its centre as shares of the reach along x and y, shape (m, 2).
    limits
        For each limited input its number from 0, the middle and half the width of its range
        in radians, shape (j, 3).
    out
        Receives scale and position of the best placement with y >= 0 and of that with y < 0,
        shape (n, HALVES, COLUMNS); scale 0 where there is none.
    """
    for n in range(len(designs)):
        _scan_design(
            d, designs[n, 0], designs[n, 1], designs[n, 2], floors[n], caps[n], kind,
            x_sign, y_sign, s1, s2, assembly, ratio, samples, anchors, limits, out[n],
        )  # fmt: skip


@kernel
def extremes_on_samples(
    designs: FloatArray, positions: FloatArray, scales: FloatArray, samples: FloatArray,
    s1: float, s2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Find how far the output moves, what it weighs on, and how far joints go, on samples.

    Parameters
    ----------
    designs, positions, scales
        Placements, shapes (n, 3), (n, 2) and (n,).
    samples
        Points of the shape, shape (k, 2).
    s1, s2
        Working mode as ±1.
    out
        Receives the largest |J⁻¹ (±1, ±1)|, the largest column of J⁻¹ (torque for a unit
        force), and least and greatest coordinates of all joints and the output, shape
        (n, EXTREMES); infinite where a sample is singular or out of reach.
    """
    for n in range(len(designs)):
        r1, r2, r3 = designs[n, 0], designs[n, 1], designs[n, 2]
        row = out[n]
        row[:] = 0.0
        row[LEAST_X], row[GREATEST_X] = -r3, r3
        for k in range(len(samples)):
            x = positions[n, 0] + scales[n] * samples[k, 0]
            y = positions[n, 1] + scales[n] * samples[k, 1]
            a1, a2, b11, b12, b21, b22 = matrices(r1, r2, r3, x, y, s1, s2)
            det = b11 * b22 - b12 * b21
            if det == 0.0 or not reaches(r1, r2, r3, x, y):
                row[:] = math.inf
                break
            u1, v1 = a1 * b22 / det, -a1 * b21 / det
            u2, v2 = -a2 * b12 / det, a2 * b11 / det
            together = (u1 + u2) * (u1 + u2) + (v1 + v2) * (v1 + v2)
            against = (u1 - u2) * (u1 - u2) + (v1 - v2) * (v1 - v2)
            row[MOVE] = max(row[MOVE], math.sqrt(max(together, against)))
            row[TORQUE] = max(row[TORQUE], math.sqrt(max(u1 * u1 + v1 * v1, u2 * u2 + v2 * v2)))
            e1x, e1y = elbow(r1, r2, -r3, x, y, s1)
            e2x, e2y = elbow(r1, r2, r3, x, y, s2)
            row[LEAST_X] = min(row[LEAST_X], e1x, e2x, x)
            row[GREATEST_X] = max(row[GREATEST_X], e1x, e2x, x)
            row[LEAST_Y] = min(row[LEAST_Y], e1y, e2y, y)
            row[GREATEST_Y] = max(row[GREATEST_Y], e1y, e2y, y)


def largest_placements(
    designs: FloatArray,
    least: FloatArray,
    greatest: FloatArray,
    signs: tuple[int, int, int],
    scan: PlacementScan,
) -> FloatArray:
    """Return scale and position of the best placement in either half plane.

    Parameters
    ----------
    designs
        r1, r2, r3 with sum 3, shape (n, 3).
    least, greatest
        Range of scales, shape (n,).
    signs
        Mode pair.
    scan
        The shape, the threshold, the anchors and the limits of inputs.

    Returns
    -------
    ndarray
        Shape (n, HALVES, COLUMNS).
    """
    kind, mirror_x, mirror_y = canonical_class(*signs)
    s1, s2, assembly = (float(sign) for sign in signs)
    decomposition: Decomposition = allocate_record(DECOMPOSITION)
    out = np.empty((len(designs), HALVES, COLUMNS))
    scan_placements(
        decomposition,
        np.ascontiguousarray(designs, dtype=np.float64),
        np.ascontiguousarray(least, dtype=np.float64),
        np.ascontiguousarray(greatest, dtype=np.float64),
        kind,
        -1.0 if mirror_x else 1.0,
        -1.0 if mirror_y else 1.0,
        s1,
        s2,
        assembly,
        threshold_ratio(scan.lci_threshold),
        np.ascontiguousarray(scan.samples),
        np.ascontiguousarray(scan.anchors),
        np.ascontiguousarray(scan.limits),
        out,
    )
    return out


def placed_extremes(
    designs: FloatArray,
    positions: FloatArray,
    scales: FloatArray,
    signs: tuple[int, int, int],
    scan: PlacementScan,
) -> PlacedExtremes:
    """Return the extremes of :func:`extremes_on_samples` for placements."""
    out = np.empty((len(designs), EXTREMES))
    extremes_on_samples(
        np.ascontiguousarray(designs, dtype=np.float64),
        np.ascontiguousarray(positions, dtype=np.float64),
        np.ascontiguousarray(scales, dtype=np.float64),
        np.ascontiguousarray(scan.samples),
        float(signs[0]),
        float(signs[1]),
        out,
    )
    return PlacedExtremes(
        moves=out[:, MOVE],
        torques=out[:, TORQUE],
        lower=out[:, [LEAST_X, LEAST_Y]],
        upper=out[:, [GREATEST_X, GREATEST_Y]],
    )
