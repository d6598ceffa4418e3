"""GCI, good-condition workspace and largest LCI over the strips of a usable workspace.

Liu et al. 2006, Eq. 33 and Sec. 9.2; all averages run over planar area.

A strip is cut into *panels* in φ: at isotropic points, and wherever the number of times
that the rays cross a level LCI = threshold changes (there the integrals over the rays have
square-root ends). In a panel, every ray is cut at its stationary points and level crossings
and each piece is integrated by a Gauss-Kronrod pair; a second pair runs across the rays.
Both use nodes clustered at both ends, which undoes the square roots at serial singularities
and tangent rays and weakens what is left at cones. Each panel returns integrals and error
estimates; the worst panel is halved until the sums meet the tolerance.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.base import FloatArray
from fivebar_atlas.mechanisms.five_bar.isotropy import MAX_ISOTROPIC
from fivebar_atlas.mechanisms.five_bar.jacobian import (
    conditioning_ratio,
    conditioning_with_slope,
    lci,
)
from fivebar_atlas.mechanisms.five_bar.rays import (
    ACROSS_NODES,
    ACROSS_ORDER,
    MAX_CROSSINGS,
    MAX_STATIONARY,
    MAX_THRESHOLDS,
    RAYS,
    ROWS,
    Rays,
    highest_on_ray,
    place_ray,
    scan_rays,
    set_samples,
)
from fivebar_atlas.mechanisms.five_bar.workspace import Decomposition, contains
from fivebar_atlas.numerics.quadrature import cluster, clustered_gauss_kronrod, kronrod_error
from fivebar_atlas.numerics.records import record_type
from fivebar_atlas.numerics.roots import FOUND, first_share, next_share

IndexArray = npt.NDArray[np.int64]

MAX_PANELS = 400
#: Orders of the Gauss rules along a ray; a piece takes the lowest that meets the tolerance.
#: With their Kronrod nodes and one more they fill whole SIMD registers.
ALONG_ORDERS = (7, 11, 15, 23, 31)
#: Columns of integrals: LCI, then areas and LCI for each threshold.
COLUMNS = 2 * MAX_THRESHOLDS + 1
#: Stated errors are this many times the summed estimates.
SAFETY = 2.0
#: The integrals are refined at least to this tolerance: rougher panels may step over a
#: turn of a level curve that none of their estimates sees.
COARSEST = 1e-5
#: Share of the tolerance that is left to errors along rays.
ALONG_SHARE = 0.3
#: A panel narrower than this is not cut at level changes any more.
LEAST_PANEL = 1e-9
#: A panel wider than this (radians) would nearly always be halved.
WIDEST_PANEL = 1.0
#: Most cuts of a panel made at once; its parts are looked at again.
MAX_LEVEL_CUTS = 32
#: Angle to which a level change is located.
ANGLE_TOLERANCE = 1e-14
#: Least shares of Kronrod minus Gauss that count as error: along rays; across rays, of
#: ∫ LCI dW; and of integrals over good-condition workspaces, whose level curves may turn
#: close to a panel's end.
ALONG_GAIN = 0.1
LCI_GAIN = 0.1
LEVEL_GAIN = 1.0
#: Panels whose whole area is below this share of the tolerance are bounded, not integrated.
NEGLIGIBLE_SHARE = 1e-4


class Panels(Protocol):
    """Panels of one usable workspace and their integrals.

    Column 0 of ``value`` and ``error`` is ∫ LCI dW; columns 1 ... k are the areas with LCI at
    or above each of k thresholds; columns k + 1 ... 2k are ∫ LCI dW over those parts.

    Attributes
    ----------
    count, pending_count
        Number of panels and of those still to be looked at, shape (1,).
    start, end
        Angles, shape (MAX_PANELS,).
    strip
        Strip that each lies in, shape (MAX_PANELS,).
    value, error
        Integrals and absolute error estimates, shape (MAX_PANELS, COLUMNS).
    pending_start, pending_end, pending_strip
        Stack of panels still to be looked at, shape (MAX_PANELS,).
    total, total_error
        Sums over the panels, shape (COLUMNS,).
    gauss
        Sums with the embedded Gauss rule, of one panel, shape (COLUMNS,).
    row, row_error
        Integrals along one ray and their error estimates, shape (COLUMNS,).
    along_error
        Errors along the rays of one panel, shape (COLUMNS,).
    cuts
        Sorted cut positions of one ray, shape (cuts,).
    piece_level
        Level of the rule for each piece of a ray, shape (cuts,).
    level_cuts
        Angles at which to cut a panel, shape (MAX_LEVEL_CUTS,).
    isotropic
        Isotropic points of the working mode, shape (MAX_ISOTROPIC, 2).
    saved_q
        Stationary values at the two ends of a bracket, shape (2, MAX_STATIONARY).
    rays
        The rays of one panel.
    along_count
        Number of nodes of the rules along rays, of growing order, shape (levels,).
    along_nodes, along_weights, along_gauss
        These rules, see :class:`quadrature.Rule`, shape (levels, nodes).
    across_nodes, across_weights, across_gauss
        The rule across rays, shape (ACROSS_NODES,).
    best
        The largest q seen on a ray, its angle, its distance, the neighbouring angles and
        the strip, shape (6,).
    """

    count: IndexArray
    pending_count: IndexArray
    start: FloatArray
    end: FloatArray
    strip: IndexArray
    value: FloatArray
    error: FloatArray
    pending_start: FloatArray
    pending_end: FloatArray
    pending_strip: IndexArray
    total: FloatArray
    total_error: FloatArray
    gauss: FloatArray
    row: FloatArray
    row_error: FloatArray
    along_error: FloatArray
    cuts: FloatArray
    piece_level: IndexArray
    level_cuts: FloatArray
    isotropic: FloatArray
    saved_q: FloatArray
    rays: Rays
    best: FloatArray
    along_count: IndexArray
    along_nodes: FloatArray
    along_weights: FloatArray
    along_gauss: FloatArray
    across_nodes: FloatArray
    across_weights: FloatArray
    across_gauss: FloatArray


PANELS = record_type(
    *((name, np.int64, (1,)) for name in ("count", "pending_count")),
    *((name, np.float64, (MAX_PANELS,)) for name in ("start", "end")),
    ("strip", np.int64, (MAX_PANELS,)),
    *((name, np.float64, (MAX_PANELS, COLUMNS)) for name in ("value", "error")),
    *((name, np.float64, (MAX_PANELS,)) for name in ("pending_start", "pending_end")),
    ("pending_strip", np.int64, (MAX_PANELS,)),
    *(
        (name, np.float64, (COLUMNS,))
        for name in ("total", "total_error", "gauss", "row", "row_error", "along_error")
    ),
    ("cuts", np.float64, (MAX_STATIONARY + MAX_CROSSINGS * MAX_THRESHOLDS + 2,)),
    ("piece_level", np.int64, (MAX_STATIONARY + MAX_CROSSINGS * MAX_THRESHOLDS + 2,)),
    ("level_cuts", np.float64, (MAX_LEVEL_CUTS,)),
    ("isotropic", np.float64, (MAX_ISOTROPIC, 2)),
    ("saved_q", np.float64, (2, MAX_STATIONARY)),
    ("best", np.float64, (6,)),
    ("along_count", np.int64, (len(ALONG_ORDERS),)),
    *(
        (name, np.float64, (len(ALONG_ORDERS), 2 * max(ALONG_ORDERS) + 2))
        for name in ("along_nodes", "along_weights", "along_gauss")
    ),
    *(
        (name, np.float64, (ACROSS_NODES,))
        for name in ("across_nodes", "across_weights", "across_gauss")
    ),
    ("rays", RAYS, ()),
)


def set_rules(p: Panels) -> None:
    """Set the quadrature rules and sample positions of a new record."""
    for level, order in enumerate(ALONG_ORDERS):
        rule = clustered_gauss_kronrod(order)
        n = len(rule.nodes)
        # a node of no weight makes whole vectors of the 2 order + 1 nodes
        p.along_count[level] = n + 1
        p.along_nodes[level] = 0.5
        p.along_nodes[level, :n] = rule.nodes
        p.along_weights[level, :n] = rule.weights
        p.along_gauss[level, :n] = rule.gauss_weights
    across = clustered_gauss_kronrod(ACROSS_ORDER)
    p.across_nodes[:], p.across_weights[:], p.across_gauss[:] = across
    set_samples(p.rays)


@kernel
def _piece(
    r1: float, r2: float, r3: float, c: float, s: float, start: float, end: float,
    s1: float, s2: float,
    count: int, nodes: FloatArray, weights: FloatArray, gauss_weights: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Return the Kronrod and Gauss sums of ∫ LCI ρ dρ between two distances on a ray."""
    length = end - start
    kronrod, gauss = 0.0, 0.0
    for j in range(count):
        rho = start + length * nodes[j]
        f = rho * lci(r1, r2, r3, rho * c, rho * s, s1, s2)
        kronrod += weights[j] * f
        gauss += gauss_weights[j] * f
    return kronrod * length, gauss * length


@kernel
def _cut_ray(p: Panels, row: int, thresholds: int) -> int:
    """Put the ends of a ray's pieces into ``p.cuts``, sorted; return the number of pieces."""
    rays, cuts = p.rays, p.cuts
    cuts[0] = 0.0
    n = 1
    for j in range(rays.stationary_count[row]):
        cuts[n] = rays.stationary_v[row, j]
        n += 1
    for kind in range(thresholds):
        for j in range(rays.crossing_count[row, kind]):
            cuts[n] = rays.crossing_v[row, kind, j]
            n += 1
    for j in range(1, n):  # insertion sort of a few numbers
        v = cuts[j]
        k = j
        while k > 0 and cuts[k - 1] > v:
            cuts[k] = cuts[k - 1]
            k -= 1
        cuts[k] = v
    cuts[n] = 1.0
    return n


@kernel
def _integrate_piece(
    p: Panels, row: int, piece: int, level: int,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> tuple[float, float]:  # fmt: skip
    """Return ∫ LCI ρ dρ over a piece of a ray and its error estimate, by a level's rule."""
    rays = p.rays
    start = rays.low[row] + rays.length[row] * cluster(p.cuts[piece])
    end = rays.low[row] + rays.length[row] * cluster(p.cuts[piece + 1])
    if end <= start:
        return 0.0, 0.0
    kronrod, gauss = _piece(
        r1, r2, r3, rays.c[row], rays.s[row], start, end, s1, s2,
        p.along_count[level], p.along_nodes[level], p.along_weights[level], p.along_gauss[level],
    )  # fmt: skip
    return kronrod, kronrod_error(abs(kronrod - gauss), kronrod, ALONG_GAIN)


@kernel
def _integrate_ray(
    p: Panels, row: int, raised: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> None:  # fmt: skip
    """Integrate along one ray into ``p.row`` and ``p.row_error``.

    Every piece takes the level of its number in ``p.piece_level``, ``raised`` by so much.
    """
    rays = p.rays
    thresholds = len(ratios)
    pieces = _cut_ray(p, row, thresholds)
    c, s, low, length = rays.c[row], rays.s[row], rays.low[row], rays.length[row]
    p.row[:] = 0.0
    p.row_error[:] = 0.0
    for piece in range(pieces):
        level = min(p.piece_level[piece] + raised, len(ALONG_ORDERS) - 1)
        kronrod, error = _integrate_piece(p, row, piece, level, r1, r2, r3, s1, s2)
        p.row[0] += kronrod
        p.row_error[0] += error
        if thresholds > 0:
            start = low + length * cluster(p.cuts[piece])
            end = low + length * cluster(p.cuts[piece + 1])
            middle = 0.5 * (start + end)
            q = conditioning_ratio(r1, r2, r3, middle * c, middle * s, s1, s2)
            for kind in range(thresholds):
                if q >= ratios[kind]:
                    p.row[1 + kind] += middle * (end - start)
                    p.row[1 + thresholds + kind] += kronrod
                    p.row_error[1 + thresholds + kind] += error


@kernel
def _choose_levels(
    p: Panels, share: float, thresholds: int,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> None:  # fmt: skip
    """Set in ``p.piece_level`` the levels that the pieces of a panel's middle ray need.

    The panels are cut so that their rays have, almost always, the same pieces.
    """
    row = ACROSS_NODES // 2
    pieces = _cut_ray(p, row, thresholds)
    total = 0.0
    for piece in range(pieces):
        total += _integrate_piece(p, row, piece, 0, r1, r2, r3, s1, s2)[0]
    p.piece_level[:] = 0
    for piece in range(pieces):
        level = 0
        while level < len(ALONG_ORDERS) - 1:
            _, error = _integrate_piece(p, row, piece, level, r1, r2, r3, s1, s2)
            if error * pieces <= share * total:
                break
            level += 1
        p.piece_level[piece] = level


@kernel
def _integrate_panel(
    p: Panels, panel: int, raised: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> float:  # fmt: skip
    """Integrate over a panel whose rays are in ``p.rays``; set its value and error.

    Returns the share of the error of ∫ LCI dW that comes from along the rays, relative to
    the integral: higher levels of the rules lower it, halving the panel does not.
    """
    columns = 2 * len(ratios) + 1
    width = p.end[panel] - p.start[panel]
    weights, gauss_weights = p.across_weights, p.across_gauss
    value, gauss = p.value[panel], p.gauss
    value[:] = 0.0
    gauss[:] = 0.0
    p.along_error[:] = 0.0
    for row in range(ACROSS_NODES):
        _integrate_ray(p, row, raised, ratios, r1, r2, r3, s1, s2)
        for m in range(columns):
            value[m] += weights[row] * p.row[m]
            gauss[m] += gauss_weights[row] * p.row[m]
            p.along_error[m] += weights[row] * p.row_error[m]
    along: float = p.along_error[0] / (value[0] + 1e-300)
    for m in range(columns):
        gain = LCI_GAIN if m == 0 else LEVEL_GAIN
        error = kronrod_error(abs(value[m] - gauss[m]), value[m], gain) + p.along_error[m]
        p.error[panel, m] = (error + 1e-15 * abs(value[m])) * width
        value[m] *= width
    return along


@kernel
def _scan_single(
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
        row = _scan_single(p, x, lower, upper, ratios, r1, r2, r3, s1, s2, assembly)
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
        spare = _scan_single(p, x, lower, upper, ratios, r1, r2, r3, s1, s2, assembly)
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
def _level_changes(
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
                    spare = _scan_single(p, x, lower, upper, ratios, r1, r2, r3, s1, s2, assembly)
                    if rays.crossing_count[spare, kind] != rays.crossing_count[row, kind]:
                        p.level_cuts[cuts] = x
                        cuts += 1
    p.level_cuts[:cuts].sort()
    return cuts


@kernel
def _push(p: Panels, start: float, end: float, strip: int) -> None:
    """Put a panel on the stack of pending ones."""
    pending = p.pending_count[0]
    if end > start and pending < MAX_PANELS:
        p.pending_start[pending] = start
        p.pending_end[pending] = end
        p.pending_strip[pending] = strip
        p.pending_count[0] = pending + 1


@kernel
def _settle(
    p: Panels, d: Decomposition, tolerance: float, negligible: float,
    ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> None:  # fmt: skip
    """Integrate all pending panels, cutting them at level changes."""
    outer2 = (r1 + r2) * (r1 + r2)
    while p.pending_count[0] > 0 and p.count[0] < MAX_PANELS:
        p.pending_count[0] -= 1
        pending, panels = p.pending_count[0], p.count[0]
        start, end, strip = (
            p.pending_start[pending], p.pending_end[pending], p.pending_strip[pending],
        )  # fmt: skip
        lower, upper = d.strip_lower[strip], d.strip_upper[strip]
        p.start[panels] = start
        p.end[panels] = end
        p.strip[panels] = strip
        bound = 0.5 * outer2 * (end - start)
        if bound < negligible:
            p.value[panels] = 0.0
            p.error[panels] = bound
            p.count[0] += 1
            continue
        for row in range(ACROSS_NODES):
            phi = start + (end - start) * p.across_nodes[row]
            place_ray(p.rays, row, phi, lower, upper, r1, r2, r3)
        scan_rays(p.rays, 0, ACROSS_NODES, lower, ratios, r1, r2, r3, s1, s2, assembly)
        for row in range(ACROSS_NODES):
            q, rho = highest_on_ray(p.rays, row)
            if q > p.best[0]:
                p.best[0] = q
                p.best[1] = p.rays.phi[row]
                p.best[2] = rho
                p.best[3] = p.rays.phi[row - 1] if row > 0 else start
                p.best[4] = p.rays.phi[row + 1] if row < ACROSS_NODES - 1 else end
                p.best[5] = strip
        if end - start > LEAST_PANEL:
            cuts = _level_changes(
                p, start == d.strip_from[strip], end == d.strip_to[strip], start, end,
                lower, upper, ratios, r1, r2, r3, s1, s2, assembly,
            )  # fmt: skip
            margin = 1e-8 * (end - start)
            left = start
            for k in range(cuts):
                if left + margin < p.level_cuts[k] < end - margin:
                    _push(p, left, p.level_cuts[k], strip)
                    left = p.level_cuts[k]
            if left > start:
                _push(p, left, end, strip)
                continue
        _choose_levels(p, ALONG_SHARE * tolerance, len(ratios), r1, r2, r3, s1, s2)
        for raised in range(len(ALONG_ORDERS)):
            along = _integrate_panel(p, panels, raised, ratios, r1, r2, r3, s1, s2)
            if along <= ALONG_SHARE * tolerance:
                break
        p.count[0] += 1


@kernel
def _sum_panels(p: Panels, columns: int) -> None:
    """Add up the panels' integrals and errors."""
    p.total[:] = 0.0
    p.total_error[:] = 0.0
    for k in range(p.count[0]):
        for m in range(columns):
            p.total[m] += p.value[k, m]
            p.total_error[m] += p.error[k, m]


@kernel
def _excess(p: Panels, error: FloatArray, columns: int, tolerance: float, floor: float) -> float:
    """Return the largest ratio of an error to what the tolerance allows it."""
    worst = 0.0
    for m in range(columns):
        worst = max(worst, error[m] / (tolerance * abs(p.total[m]) + floor))
    return worst


@kernel
def _cut_at_isotropic_points(
    p: Panels, d: Decomposition, strip: int, isotropic: int, r1: float, r2: float
) -> None:  # fmt: skip
    """Push a strip's panels, cut at the angles of isotropic points and of a base joint.

    A base joint lies inside the workspace only for r1 = r2, where the inner reach circles
    are points; LCI has a cone there too, with its tip at zero.
    """
    start, end = d.strip_from[strip], d.strip_to[strip]
    while start < end:
        cut = end
        for k in range(isotropic + 2):
            if k < isotropic:
                angle = math.atan2(p.isotropic[k, 1], p.isotropic[k, 0])
                if angle < -0.5 * math.pi:
                    angle += 2.0 * math.pi
            elif abs(r1 - r2) < 1e-9:
                angle = 0.0 if k == isotropic else math.pi
            else:
                continue
            if start + LEAST_PANEL < angle < cut - LEAST_PANEL:
                cut = angle
        parts = int((cut - start) / WIDEST_PANEL) + 1
        for k in range(parts):
            left, right = start + (cut - start) * k / parts, start + (cut - start) * (k + 1) / parts
            _push(p, left, right, strip)
        start = cut


@kernel
def integrate_strips(
    p: Panels, d: Decomposition, strips: int, isotropic: int, ratios: FloatArray,
    tolerance: float, area: float,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> bool:  # fmt: skip
    """Integrate LCI and the good-condition workspace over all strips.

    Parameters
    ----------
    p
        Receives ``total`` and ``total_error``; ``isotropic`` holds the isotropic points.
    d
        Decomposition with the strips of the usable workspace.
    strips, isotropic
        Number of strips and of isotropic points.
    ratios
        Threshold ratios, shape (k,).
    tolerance
        Relative tolerance of every integral.
    area
        Area of the strips.
    r1, r2, r3, s1, s2, assembly
        Design and mode pair.

    Returns
    -------
    bool
        Whether the tolerance was reached.
    """
    tolerance = min(tolerance, COARSEST) / SAFETY
    negligible = NEGLIGIBLE_SHARE * tolerance * area
    floor = 1e-13 * area
    columns = 2 * len(ratios) + 1
    p.best[:] = 0.0
    p.count[0] = p.pending_count[0] = 0
    for strip in range(strips):
        _cut_at_isotropic_points(p, d, strip, isotropic, r1, r2)
    while True:
        _settle(p, d, tolerance, negligible, ratios, r1, r2, r3, s1, s2, assembly)
        _sum_panels(p, columns)
        reached = _excess(p, p.total_error, columns, tolerance, floor) <= 1.0
        if reached or p.count[0] >= MAX_PANELS - 4:
            break
        worst, worst_panel = 0.0, 0
        for k in range(p.count[0]):
            excess = _excess(p, p.error[k], columns, tolerance, floor)
            if excess > worst:
                worst, worst_panel = excess, k
        start, end, strip = p.start[worst_panel], p.end[worst_panel], p.strip[worst_panel]
        middle = 0.5 * (start + end)
        if not start < middle < end:
            break
        p.count[0] -= 1  # the last panel takes the place of the one that is halved
        last = p.count[0]
        p.start[worst_panel] = p.start[last]
        p.end[worst_panel] = p.end[last]
        p.strip[worst_panel] = p.strip[last]
        p.value[worst_panel] = p.value[last]
        p.error[worst_panel] = p.error[last]
        _push(p, start, middle, strip)
        _push(p, middle, end, strip)
    # room for panels ran out: what was not integrated is bounded by its sector
    missing = 0.0
    for k in range(p.pending_count[0]):
        missing += 0.5 * (r1 + r2) * (r1 + r2) * (p.pending_end[k] - p.pending_start[k])
    for m in range(columns):
        p.total_error[m] = SAFETY * p.total_error[m] + missing
    return reached and missing == 0.0


@kernel
def largest_lci(
    p: Panels, d: Decomposition, strips: int, isotropic: int,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Return the largest LCI of the usable workspace and where (x, y) it occurs.

    At an isotropic point it is 1 (of several, the one of largest y, then of largest x, is
    returned). Otherwise the rays next to the best one seen bracket it. It may also lie on a
    panel's end, such as the y axis or a corner of the workspace.
    """
    found = -1
    for k in range(isotropic):
        x, y = p.isotropic[k, 0], p.isotropic[k, 1]
        phi = math.atan2(y, x)
        if phi < -0.5 * math.pi:
            phi += 2.0 * math.pi
        if not contains(d, r1, r2, r3, strips, phi, math.sqrt(x * x + y * y)):
            continue
        if (
            found < 0
            or y > p.isotropic[found, 1]
            or (y == p.isotropic[found, 1] and x > p.isotropic[found, 0])
        ):
            found = k
    if found >= 0:
        x, y = p.isotropic[found, 0], p.isotropic[found, 1]
        return lci(r1, r2, r3, x, y, s1, s2), x, y
    # The largest q of a ray, m(φ), has the derivative ∂q/∂φ at that point: find its zero.
    strip = int(p.best[5])
    lower, upper = d.strip_lower[strip], d.strip_upper[strip]
    none = p.level_cuts[:0]  # no thresholds
    x1, x2 = p.best[3], p.best[4]
    f1, f2, x3, f3 = 0.0, 0.0, 0.0, 0.0
    share = 0.0
    for step in range(50):
        phi = x1 if step == 0 else x2 if step == 1 else x1 + share * (x2 - x1)
        row = _scan_single(p, phi, lower, upper, none, r1, r2, r3, s1, s2, assembly)
        q, rho = highest_on_ray(p.rays, row)
        if q > p.best[0]:
            p.best[0], p.best[1], p.best[2] = q, phi, rho
        c, s = p.rays.c[row], p.rays.s[row]
        _, f = conditioning_with_slope(r1, r2, r3, rho * c, rho * s, -s, c, s1, s2, assembly)
        if step == 0:
            f1 = f
            continue
        if step == 1:
            f2 = f
            if f1 <= 0.0 or f2 >= 0.0:  # m falls from the one end or rises to the other
                break
            share = first_share(f1, f2)
            continue
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = phi, f
        share = next_share(x1, f1, x2, f2, x3, f3, 1e-9)
        if share == FOUND:
            break
    x, y = p.best[2] * math.cos(p.best[1]), p.best[2] * math.sin(p.best[1])
    return lci(r1, r2, r3, x, y, s1, s2), x, y
