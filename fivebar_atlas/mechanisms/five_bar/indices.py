"""GCI, good-condition workspace and largest LCI over the strips of a usable workspace.

Liu et al. 2006, Eq. 33 and Sec. 9.2; all averages run over planar area.

A strip is cut into *panels* in φ: at isotropic points, and wherever the number of times
that the rays cross a level LCI = threshold changes. Each panel returns integrals and error
estimates; the worst panel is halved until the sums meet the tolerance.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.jacobian import conditioning_with_slope, lci
from fivebar_atlas.mechanisms.five_bar.level_changes import level_changes, scan_single
from fivebar_atlas.mechanisms.five_bar.panels import (
    ALONG_ORDERS,
    MAX_PANELS,
    Panels,
    choose_levels,
    integrate_panel,
)
from fivebar_atlas.mechanisms.five_bar.rays import (
    ACROSS_NODES,
    highest_on_ray,
    place_ray,
    scan_rays,
)
from fivebar_atlas.mechanisms.five_bar.workspace import POINT_RADIUS, Decomposition, contains
from fivebar_atlas.numerics.roots import FOUND, first_share, next_share

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
#: Panels whose whole area is below this share of the tolerance are bounded, not integrated.
NEGLIGIBLE_SHARE = 1e-4
#: How far inside a corner the workspace is looked for.
CORNER_STEP = 1e-7


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
            cuts = level_changes(
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
        choose_levels(p, ALONG_SHARE * tolerance, len(ratios), r1, r2, r3, s1, s2)
        for raised in range(len(ALONG_ORDERS)):
            along = integrate_panel(p, panels, raised, ratios, r1, r2, r3, s1, s2)
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
            elif abs(r1 - r2) < POINT_RADIUS:
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
    p.isotropic_count[0] = isotropic
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
def _corner_limit(
    d: Decomposition, strips: int, r1: float, r2: float, r3: float, symmetric: bool
) -> tuple[float, float, float]:
    """Return the largest limit of the LCI in a corner of the workspace, and the corner.

    In a corner between reach circles of both legs sin β1 and sin β2 go to zero in any ratio,
    so the LCI has the limits of all values below that for equal sines, LCI + 1/LCI =
    2 / |sin γ|, where the legs are straight. Returns (0, 0, 0) where there is no corner.
    """
    outer, inner = r1 + r2, abs(r1 - r2)
    best, best_x, best_y = 0.0, 0.0, 0.0
    for kind in range(3):  # outer and outer, inner and inner, outer of leg 1 and inner of leg 2
        radius_1 = inner if kind == 1 else outer
        radius_2 = outer if kind == 0 else inner
        if radius_2 < POINT_RADIUS or r3 == 0.0:
            continue
        x = r1 * r2 / r3 if kind == 2 else 0.0
        height2 = (radius_2 - (x - r3)) * (radius_2 + (x - r3))
        if height2 <= 0.0:
            continue
        y = math.sqrt(height2)
        sine = 2.0 * r3 * y / (radius_1 * radius_2)
        limit = sine / (1.0 + math.sqrt(max((1.0 - sine) * (1.0 + sine), 0.0)))
        # towards the inside: into an outer circle, away from an inner one
        in_1 = 1.0 if kind == 1 else -1.0
        in_2 = -1.0 if kind == 0 else 1.0
        dx = in_1 * (x + r3) / radius_1 + in_2 * (x - r3) / radius_2
        dy = in_1 * y / radius_1 + in_2 * y / radius_2
        step = CORNER_STEP / math.sqrt(dx * dx + dy * dy)
        for image in range(4):
            x_sign = -1.0 if image % 2 == 1 else 1.0
            y_sign = -1.0 if image >= 2 else 1.0
            if limit <= best or (x_sign < 0.0 and (symmetric or x == 0.0)):
                continue
            px, py = x_sign * (x + step * dx), y_sign * (y + step * dy)
            phi = math.atan2(py, px)
            if phi < -0.5 * math.pi:
                phi += 2.0 * math.pi
            if contains(d, r1, r2, r3, strips, phi, math.sqrt(px * px + py * py)):
                best, best_x, best_y = limit, x_sign * x, y_sign * y
    return best, best_x, best_y


@kernel
def largest_lci(
    p: Panels, d: Decomposition, strips: int, isotropic: int,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Return the largest LCI of the usable workspace and where (x, y) it occurs.

    At an isotropic point it is 1 (of several, the one of largest y, then of largest x, is
    returned). Otherwise the rays next to the best one seen bracket it. It may also lie on a
    panel's end, such as the y axis, or be a limit in a corner of the workspace.
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
        row = scan_single(p, phi, lower, upper, none, r1, r2, r3, s1, s2, assembly)
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
    best = lci(r1, r2, r3, x, y, s1, s2)
    limit, corner_x, corner_y = _corner_limit(d, strips, r1, r2, r3, s1 != s2)
    return (limit, corner_x, corner_y) if limit > best else (best, x, y)
