"""Maximal inscribed circles of a usable workspace, centred on the y axis.

The distance from a point of the axis to the boundary of the usable workspace is the least
distance to its boundary arcs, the lower and upper curves of the strips. Along the axis that
distance is sampled; next to the largest samples its maximum is closed in on.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.singularity import (
    COUPLER_PLUS,
    ORIGIN,
    circle_of,
    coupler_radius_rate,
    radius_along,
)
from fivebar_atlas.mechanisms.five_bar.workspace import (
    LEAST_WIDTH,
    MAX_CELLS,
    POINT_RADIUS,
    Decomposition,
)
from fivebar_atlas.numerics.records import record_type
from fivebar_atlas.numerics.roots import FOUND, first_share, next_share

#: Points of the axis, per interval inside the workspace, where the distance is sampled.
AXIS_SAMPLES = 24
#: Points of a coupler arc that bracket its nearest point.
ARC_SAMPLES = 12
MAX_ARCS = 2 * MAX_CELLS
#: Angle to which the nearest point of a coupler arc is found.
ANGLE_TOLERANCE = 1e-13
#: The centre is found to this accuracy (lengths sum to 3).
CENTRE_TOLERANCE = 1e-12


class Arcs(Protocol):
    """Boundary arcs of a usable workspace.

    Attributes
    ----------
    curve
        Curve of each arc, shape (MAX_ARCS,).
    start, end
        Angles where it begins and ends, shape (MAX_ARCS,).
    x0, y0, x1, y1
        End points, shape (MAX_ARCS,).
    sample_x, sample_y
        Points of the coupler arcs, shape (MAX_ARCS, ARC_SAMPLES).
    """

    curve: npt.NDArray[np.int64]
    start: FloatArray
    end: FloatArray
    x0: FloatArray
    y0: FloatArray
    x1: FloatArray
    y1: FloatArray
    sample_x: FloatArray
    sample_y: FloatArray


ARCS = record_type(
    ("curve", np.int64, (MAX_ARCS,)),
    *((name, np.float64, (MAX_ARCS,)) for name in ("start", "end", "x0", "y0", "x1", "y1")),
    *((name, np.float64, (MAX_ARCS, ARC_SAMPLES)) for name in ("sample_x", "sample_y")),
)


@kernel
def collect_arcs(arcs: Arcs, d: Decomposition, r1: float, r2: float, r3: float, strips: int) -> int:
    """Gather the boundary arcs of the strips; return their number."""
    count = 0
    for strip in range(strips):
        for side in range(2):
            curve = d.strip_lower[strip] if side == 0 else d.strip_upper[strip]
            if curve == ORIGIN:
                continue
            start, end = d.strip_from[strip], d.strip_to[strip]
            arcs.curve[count] = curve
            arcs.start[count] = start
            arcs.end[count] = end
            c, s = math.cos(start), math.sin(start)
            rho = radius_along(curve, r1, r2, r3, c, s)
            arcs.x0[count], arcs.y0[count] = rho * c, rho * s
            c, s = math.cos(end), math.sin(end)
            rho = radius_along(curve, r1, r2, r3, c, s)
            arcs.x1[count], arcs.y1[count] = rho * c, rho * s
            if curve >= COUPLER_PLUS:
                for k in range(ARC_SAMPLES):
                    phi = start + (end - start) * (k + 0.5) / ARC_SAMPLES
                    c, s = math.cos(phi), math.sin(phi)
                    rho = radius_along(curve, r1, r2, r3, c, s)
                    arcs.sample_x[count, k] = rho * c
                    arcs.sample_y[count, k] = rho * s
            count += 1
    return count


@kernel
def _coupler_distance(
    arcs: Arcs, k: int, phi: float, centre: float, r1: float, r2: float, r3: float
) -> tuple[float, float, float]:
    """Return the squared distance from (0, centre) to a coupler arc's point, half its
    derivative in φ, and the point's ordinate.
    """  # noqa: D205
    c, s = math.cos(phi), math.sin(phi)
    rho = radius_along(arcs.curve[k], r1, r2, r3, c, s)
    rate = coupler_radius_rate(arcs.curve[k], r2, r3, c, s)
    x, y = rho * c, rho * s
    half_slope = 0.5 * rate - centre * (0.5 * rate / max(rho, 1e-12) * s + x)
    return x * x + (y - centre) * (y - centre), half_slope, y


@kernel
def _sample_distance(arcs: Arcs, k: int, j: int, centre: float) -> float:
    """Return the squared distance from (0, centre) to a sample of a coupler arc."""
    if j < 0 or j >= ARC_SAMPLES:
        return math.inf
    return float(arcs.sample_x[k, j] ** 2 + (arcs.sample_y[k, j] - centre) ** 2)


@kernel
def _nearest_on_coupler(
    arcs: Arcs, k: int, centre: float, best2: float, exact: bool, r1: float, r2: float, r3: float
) -> tuple[float, float]:
    """Return the squared distance from (0, centre) to a coupler arc and the ordinate there.

    Samples nearer than both neighbours bracket points that are nearest around, zeros of the
    derivative; there may be several. Where that is not to be ``exact``, or a sample is too far
    to beat ``best2``, it is left at that.
    """
    near2, near_y = math.inf, 0.0
    before, here = math.inf, _sample_distance(arcs, k, 0, centre)
    for j in range(ARC_SAMPLES):
        after = _sample_distance(arcs, k, j + 1, centre)
        if here <= before and here <= after:
            if here < near2:
                near2, near_y = here, arcs.sample_y[k, j]
            # between samples the arc is nearer by no more than the chord to a neighbour
            other = j + 1 if j + 1 < ARC_SAMPLES else j - 1
            gap_x = arcs.sample_x[k, j] - arcs.sample_x[k, other]
            gap_y = arcs.sample_y[k, j] - arcs.sample_y[k, other]
            gap = 1.5 * math.sqrt(gap_x * gap_x + gap_y * gap_y)
            if exact and math.sqrt(here) - gap <= math.sqrt(min(best2, near2)):
                distance2, y = _nearest_around(arcs, k, j, centre, r1, r2, r3)
                if distance2 < near2:
                    near2, near_y = distance2, y
        before, here = here, after
    return near2, near_y


@kernel
def _nearest_around(
    arcs: Arcs, k: int, near: int, centre: float, r1: float, r2: float, r3: float
) -> tuple[float, float]:
    """Return the same between the neighbours of a sample; (inf, 0) if that is an end of the arc."""
    near2, near_y = math.inf, 0.0
    step = (arcs.end[k] - arcs.start[k]) / ARC_SAMPLES
    middle = arcs.start[k] + (near + 0.5) * step
    x1, x2 = max(middle - step, arcs.start[k]), min(middle + step, arcs.end[k])
    _, f1, _ = _coupler_distance(arcs, k, x1, centre, r1, r2, r3)
    _, f2, _ = _coupler_distance(arcs, k, x2, centre, r1, r2, r3)
    if f1 >= 0.0 or f2 <= 0.0:  # the nearest point is an end, which is looked at elsewhere
        return near2, near_y
    share = first_share(f1, f2)
    while share != FOUND:
        phi = x1 + share * (x2 - x1)
        distance2, f, y = _coupler_distance(arcs, k, phi, centre, r1, r2, r3)
        if distance2 < near2:
            near2, near_y = distance2, y
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = phi, f
        share = next_share(x1, f1, x2, f2, x3, f3, ANGLE_TOLERANCE)
    return near2, near_y


@kernel
def _nearest_on_circle(
    arcs: Arcs, k: int, centre: float, r1: float, r2: float, r3: float
) -> tuple[float, float]:
    """Return the squared distance from (0, centre) to a circle and the ordinate there.

    Returns (inf, 0) where the circle's nearest point is not on the arc.
    """
    a, b, radius, sheet = circle_of(arcs.curve[k], r1, r2, r3)
    gx, gy = -a, centre - b
    span = math.sqrt(gx * gx + gy * gy)
    if span == 0.0:
        x, y = arcs.x0[k], arcs.y0[k]
    else:
        x, y = a + radius * gx / span, b + radius * gy / span
        if ((x - a) * x + (y - b) * y) * sheet < 0.0:
            return math.inf, 0.0
        # inside the angle from start to end: left of the one ray and right of the other
        after = arcs.x0[k] * y - arcs.y0[k] * x >= 0.0
        before = x * arcs.y1[k] - y * arcs.x1[k] >= 0.0
        wide = arcs.end[k] - arcs.start[k] > math.pi
        if not ((after or before) if wide else (after and before)):
            return math.inf, 0.0
    return x * x + (y - centre) * (y - centre), y


@kernel
def clearance(
    arcs: Arcs, count: int, centre: float, exact: bool, r1: float, r2: float, r3: float
) -> tuple[float, float]:
    """Return the distance from (0, centre) to the nearest boundary arc and its slope.

    The slope is the derivative with respect to ``centre``, -1 to 1. Distances to arcs of
    C_col may be a little too large where they are not to be ``exact``.
    """
    best2, best_y = math.inf, 0.0
    if abs(r1 - r2) < POINT_RADIUS:  # C_1i and C_2i are points, singular ones: A1 and A2
        best2 = r3 * r3 + centre * centre
    for k in range(count):
        for end in range(2):
            x = arcs.x0[k] if end == 0 else arcs.x1[k]
            y = arcs.y0[k] if end == 0 else arcs.y1[k]
            distance2 = x * x + (y - centre) * (y - centre)
            if distance2 < best2:
                best2, best_y = distance2, y
        if arcs.curve[k] < COUPLER_PLUS:
            distance2, y = _nearest_on_circle(arcs, k, centre, r1, r2, r3)
            if distance2 < best2:
                best2, best_y = distance2, y
    for k in range(count):  # last, when most of them can be passed over
        if arcs.curve[k] >= COUPLER_PLUS:
            distance2, y = _nearest_on_coupler(arcs, k, centre, best2, exact, r1, r2, r3)
            if distance2 < best2:
                best2, best_y = distance2, y
    distance = math.sqrt(best2)
    return distance, (centre - best_y) / distance if distance > 0.0 else 0.0


@kernel
def _close_in(
    arcs: Arcs, count: int, left: float, right: float, r1: float, r2: float, r3: float
) -> tuple[float, float]:
    """Return the largest clearance between two points of the axis, and its centre.

    Where the nearest arc changes, the clearance has a ridge: the tangents at both ends
    meet near it. Steps that cut too little off are followed by a bisection.
    """
    f0, slope0 = clearance(arcs, count, left, True, r1, r2, r3)
    f1, slope1 = clearance(arcs, count, right, True, r1, r2, r3)
    best, centre = (f0, left) if f0 >= f1 else (f1, right)
    bisect = False
    for _ in range(80):
        width = right - left
        if width < CENTRE_TOLERANCE or slope0 <= 0.0 or slope1 >= 0.0:
            break
        x = left + (f1 - f0 - slope1 * width) / (slope0 - slope1)
        if bisect or not left < x < right:
            x = 0.5 * (left + right)
        f, slope = clearance(arcs, count, x, True, r1, r2, r3)
        if f > best:
            best, centre = f, x
        if slope > 0.0:
            left, f0, slope0 = x, f, slope
        else:
            right, f1, slope1 = x, f, slope
        bisect = not bisect and right - left > 0.5 * width
    return best, centre


@kernel
def _largest_between(
    arcs: Arcs, count: int, low: float, high: float, r1: float, r2: float, r3: float
) -> tuple[float, float]:
    """Return the largest clearance on an interval of the axis, and its centre."""
    best, centre = -1.0, low
    step = (high - low) / (AXIS_SAMPLES - 1)
    before, _ = clearance(arcs, count, low, False, r1, r2, r3)
    here, _ = clearance(arcs, count, low + step, False, r1, r2, r3)
    if before > best:
        best, centre = before, low
    for k in range(1, AXIS_SAMPLES):
        y = low + k * step if k < AXIS_SAMPLES - 1 else high
        after = -1.0
        if k < AXIS_SAMPLES - 1:
            after, _ = clearance(arcs, count, y + step, False, r1, r2, r3)
        # the clearance changes by no more than the step
        if here >= before and here >= after and here + step > best:
            f, x = _close_in(arcs, count, y - step, min(y + step, high), r1, r2, r3)
            if f > best:
                best, centre = f, x
        before, here = here, after
    return best, centre


@kernel
def maximal_inscribed_circle(
    arcs: Arcs, count: int, d: Decomposition, r1: float, r2: float, r3: float,
    sectors: int, component: int, upper_half: bool,
) -> tuple[float, float]:  # fmt: skip
    """Return radius and centre ordinate of the largest circle inside the usable workspace.

    Its centre lies on the y axis, in the upper half (y ≥ 0) or the lower one (y ≤ 0).

    Parameters
    ----------
    arcs, count
        Boundary arcs of the usable workspace and their number.
    d, sectors, component
        Decomposition and the component that is the usable workspace.
    r1, r2, r3
        Lengths.
    upper_half
        Which half of the axis the centre may lie on.

    Returns
    -------
    tuple of float
        (-1, 0) where the workspace does not meet that half of the axis.
    """
    best, centre = -1.0, 0.0
    phi = 0.5 * math.pi if upper_half else -0.5 * math.pi
    sign = 1.0 if upper_half else -1.0
    c, s = math.cos(phi), math.sin(phi)
    for k in range(sectors):
        starts = abs(d.angles[k] - phi) < 1e-9
        ends = abs(d.angles[k + 1] - phi) < 1e-9
        if not starts and not ends:
            continue
        for cell in range(d.first[k], d.first[k + 1]):
            if d.component[cell] != component:
                continue
            low = radius_along(d.lower[cell], r1, r2, r3, c, s)
            high = radius_along(d.upper[cell], r1, r2, r3, c, s)
            if high - low > LEAST_WIDTH:
                a, b = (low, high) if upper_half else (-high, -low)
                radius, y = _largest_between(arcs, count, a, b, r1, r2, r3)
                if radius > best and y * sign >= 0.0:
                    best, centre = radius, y
    return best, centre
