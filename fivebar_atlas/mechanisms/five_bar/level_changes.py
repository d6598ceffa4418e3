"""Where to cut a panel: angles at which rays begin or cease to cross a level of LCI.

The integrals over the rays have square-root ends there.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.panels import MAX_LEVEL_CUTS, Panels
from fivebar_atlas.mechanisms.five_bar.rays import ACROSS_NODES, ROWS, place_ray, scan_rays
from fivebar_atlas.numerics.roots import FOUND, first_share, next_share

#: Angle to which a level change is located.
ANGLE_TOLERANCE = 1e-14


@kernel
def scan_single(
    p: Panels, phi: float, lower: int, upper: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> int:  # fmt: skip
    """Place one ray in the spare row and scan it; return that row."""
    spare = ROWS - 1
    place_ray(p.rays, spare, phi, lower, upper, r1, r2, r3)
    scan_rays(p.rays, spare, spare + 1, lower, ratios, r1, r2, r3, s1, s2, assembly)
    return spare


@kernel
def _passing_value(p: Panels, ratio: float, count: int) -> int:
    """Return the one stationary value that passes a level between the two rays whose values
    are in ``p.saved_q``, or -1 where there is none or more than one.
    """  # noqa: D205
    which = -1
    for j in range(count):
        if (p.saved_q[0, j] > ratio) != (p.saved_q[1, j] > ratio):
            if which >= 0:
                return -1
            which = j
    return which


@kernel
def _locate_change(
    p: Panels, row0: int, row1: int, kind: int, lower: int, upper: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> float:  # fmt: skip
    """Return the angle between two rays where the number of level crossings changes.

    At that angle the level curve is tangent to the ray: a stationary value of q passes
    through the level. The number of crossings is bisected until one such value can be
    followed from end to end; its height above the level is then brought to zero.
    """
    rays = p.rays
    ratio = ratios[kind]
    x1: float = rays.phi[row0]
    x2: float = rays.phi[row1]
    crossings1 = rays.crossing_count[row0, kind]
    count1, count2 = rays.stationary_count[row0], rays.stationary_count[row1]
    p.saved_q[0] = rays.stationary_q[row0]
    p.saved_q[1] = rays.stationary_q[row1]
    which, share = -1, FOUND
    f1, f2 = 0.0, 0.0
    while abs(x2 - x1) > ANGLE_TOLERANCE:
        if which < 0:
            which = _passing_value(p, ratio, count1) if count1 == count2 else -1
            f1, f2 = p.saved_q[0, which] - ratio, p.saved_q[1, which] - ratio
            share = first_share(f1, f2) if which >= 0 else 0.5
        x = x1 + share * (x2 - x1)
        row = scan_single(p, x, lower, upper, ratios, r1, r2, r3, s1, s2, assembly)
        crossings = rays.crossing_count[row, kind]
        if which >= 0 and rays.stationary_count[row] == count1:
            f = rays.stationary_q[row, which] - ratio
            if (f > 0.0) == (f1 > 0.0):
                x3, f3 = x1, f1
            else:
                x3, f3, x2, f2 = x2, f2, x1, f1
            x1, f1, crossings1 = x, f, crossings
            share = next_share(x1, f1, x2, f2, x3, f3, ANGLE_TOLERANCE)
            if share == FOUND:
                return x1
            continue
        # nothing to follow yet, or a pair of stationary points is born in between: bisect
        if which >= 0:
            which, count1, count2 = -1, -1, -1
        if crossings == crossings1:
            x1, count1 = x, rays.stationary_count[row]
            p.saved_q[0] = rays.stationary_q[row]
        else:
            x2, count2 = x, rays.stationary_count[row]
            p.saved_q[1] = rays.stationary_q[row]
    return 0.5 * (x1 + x2)


@kernel
def _hidden_vertex(p: Panels, row: int, which: int, ratio: float) -> float:
    """Return where a stationary value may pass a level and come back between rays, or NaN.

    That may be if of three neighbouring rays the middle one is nearest to the level, and a
    parabola through the three reaches it or nearly so; its vertex is returned.
    """
    rays = p.rays
    f0 = rays.stationary_q[row - 1, which] - ratio
    f1 = rays.stationary_q[row, which] - ratio
    f2 = rays.stationary_q[row + 1, which] - ratio
    if f1 > 0.0:
        f0, f1, f2 = -f0, -f1, -f2
    if f1 <= f0 or f1 <= f2:
        return math.nan
    h0 = rays.phi[row] - rays.phi[row - 1]
    h2 = rays.phi[row + 1] - rays.phi[row]
    slope0, slope2 = (f1 - f0) / h0, (f2 - f1) / h2
    bend = (slope2 - slope0) / (h0 + h2)
    tilt = (slope0 * h2 + slope2 * h0) / (h0 + h2)
    if f1 - 0.25 * tilt * tilt / bend < -0.1 * (2.0 * f1 - f0 - f2):
        return math.nan
    middle: float = rays.phi[row]
    vertex: float = middle - 0.5 * tilt / bend
    return vertex


@kernel
def _corner_change(
    p: Panels, row: int, corner: float, kind: int, lower: int, upper: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> float:  # fmt: skip
    """Return the angle of a level change between a strip's end and the ray next to it, or NaN.

    LCI may have any limit in a corner of the workspace, so a level curve may end in one.
    """
    rays = p.rays
    x2: float = rays.phi[row]
    x1 = corner + 1e-7 * (x2 - corner)
    x, crossings = x1, 0
    for step in range(31):
        spare = scan_single(p, x, lower, upper, ratios, r1, r2, r3, s1, s2, assembly)
        if step == 0:
            crossings = rays.crossing_count[spare, kind]
            if crossings == rays.crossing_count[row, kind]:
                return math.nan
        elif rays.crossing_count[spare, kind] == crossings:
            x1 = x
        else:
            x2 = x
        x = 0.5 * (x1 + x2)
    return x


@kernel
def level_changes(
    p: Panels, corner_start: bool, corner_end: bool, start: float, end: float,
    lower: int, upper: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> int:  # fmt: skip
    """Collect in ``p.level_cuts`` the angles at which to cut a panel; return their number.

    Neighbouring rays that cross a level a different number of times have such an angle
    between them; neighbours that do not may hide two. Next to the end of a strip the level
    is followed into the corner.
    """
    rays = p.rays
    cuts = 0
    for kind in range(len(ratios)):
        for side in range(2):
            if not (corner_start if side == 0 else corner_end) or cuts >= MAX_LEVEL_CUTS:
                continue
            row, corner = (0, start) if side == 0 else (ACROSS_NODES - 1, end)
            x = _corner_change(
                p, row, corner, kind, lower, upper, ratios, r1, r2, r3, s1, s2, assembly
            )
            if not math.isnan(x):
                p.level_cuts[cuts] = x
                cuts += 1
        for row in range(ACROSS_NODES - 1):
            if (
                rays.crossing_count[row, kind] != rays.crossing_count[row + 1, kind]
                and cuts < MAX_LEVEL_CUTS
            ):
                p.level_cuts[cuts] = _locate_change(
                    p, row, row + 1, kind, lower, upper, ratios, r1, r2, r3, s1, s2, assembly
                )
                cuts += 1
        for row in range(1, ACROSS_NODES - 1):
            count = rays.stationary_count[row]
            if count != rays.stationary_count[row - 1] or count != rays.stationary_count[row + 1]:
                continue
            for which in range(count):
                x = _hidden_vertex(p, row, which, ratios[kind])
                if not math.isnan(x) and cuts < MAX_LEVEL_CUTS:
                    spare = scan_single(p, x, lower, upper, ratios, r1, r2, r3, s1, s2, assembly)
                    if rays.crossing_count[spare, kind] != rays.crossing_count[row, kind]:
                        p.level_cuts[cuts] = x
                        cuts += 1
    p.level_cuts[:cuts].sort()
    return cuts
