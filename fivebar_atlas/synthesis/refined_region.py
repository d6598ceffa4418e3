"""Optimum regions with their outlines moved from the lattice onto the true level sets.

The outline of a region of the lattice has corners where a bound is reached by linear
interpolation. Newton's method moves each of them to where the bound is reached by the
quantity itself: along its gradient, along the border of the design space where it lies on
one, and to the common point of both bounds where two meet.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.synthesis.conditions import Condition
from fivebar_atlas.synthesis.design_polygon import DesignPolygon
from fivebar_atlas.synthesis.exact_values import ExactValues
from fivebar_atlas.triangulated_regions import IntArray, Region

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

#: Residuals, relative to the scale of a condition, that count as reached.
RESIDUAL = 1e-8

# Newton's method goes on below that bound, as far as the values are exact.
_AIM = 1e-10
_ITERATIONS = 20
# Gradients are computed again where a step leaves more than this share of a residual.
_FAST = 0.05
# Below this share of its scale an interpolated margin is zero.
_AT_BOUND = 1e-11
# Singular values below this share of the largest belong to directions that stay as they are.
_DEPENDENT = 1e-3
# A relative change per unit of the chart below this one is none.
_FLAT = 1e-6


@dataclasses.dataclass(frozen=True, slots=True)
class RefinedRegion:
    """A region between true level sets.

    Attributes
    ----------
    loops
        Its outline in chart coordinates, each loop of shape (k, 2).
    residual
        Largest distance of a quantity from the bound it is to have at a corner of the
        outline, relative to the bound (or to the range of the quantity where it is 0).
    interpolation_error
        The same before corners were moved: the error of linear interpolation there.
    unmoved
        Corners that bound nothing but the designs that have values, or where the bound
        was not reached.
    area, area_error
        Area in the chart; the error is that of sides taken to be straight.
    """

    loops: tuple[FloatArray, ...]
    residual: float
    interpolation_error: float
    unmoved: int
    area: float
    area_error: float


@dataclasses.dataclass(slots=True)
class _Corners:
    """Corners of an outline: where they are and what they lie on."""

    points: FloatArray
    active: BoolArray  # (corners, conditions)
    sides: BoolArray  # (corners, sides of the polygon)

    def joined(self, other: _Corners) -> _Corners:
        return _Corners(
            np.vstack([self.points, other.points]),
            np.vstack([self.active, other.active]),
            np.vstack([self.sides, other.sides]),
        )


def condition_scales(conditions: Sequence[Condition], margins: FloatArray) -> FloatArray:
    """Return what residuals are relative to: the bound, or the range where it is 0."""
    scales = []
    for condition, row in zip(conditions, margins, strict=True):
        finite = row[np.isfinite(row)]
        width = float(np.ptp(finite)) if len(finite) else 0.0
        scales.append(abs(condition.bound) or width or 1.0)
    return np.array(scales)


def outline_error(
    region: Region,
    conditions: Sequence[Condition],
    triangles: IntArray,
    points: FloatArray,
    margins: FloatArray,
    exact: ExactValues,
) -> float:
    """Return the largest relative error of interpolated bounds at corners of an outline.

    Parameters are as for :func:`refine`; 0 where no corner lies on a bound.
    """
    polygon = DesignPolygon.of_lattice(points, triangles)
    scales = condition_scales(conditions, margins)
    corners = _corners_of(region, region.loops, triangles, points, margins, scales, polygon)
    residuals = _residuals(corners, conditions, scales, exact)
    return float(np.max(residuals, initial=0.0, where=np.isfinite(residuals)))


def refine(
    region: Region,
    conditions: Sequence[Condition],
    triangles: IntArray,
    points: FloatArray,
    margins: FloatArray,
    exact: ExactValues,
) -> RefinedRegion:
    """Move the corners of a region's outline onto the true level sets.

    Parameters
    ----------
    region
        The region of the lattice.
    conditions
        The conditions that bound it.
    triangles, points
        The triangulated lattice in the chart.
    margins
        Margins of the conditions at the designs of the lattice, shape (conditions, n).
    exact
        Values of the conditions' quantities, and others, anywhere.

    Returns
    -------
    RefinedRegion
        The region; corners on the border of the lattice stay on it. Sides between corners
        on one bound get a further corner in the middle.
    """
    polygon = DesignPolygon.of_lattice(points, triangles)
    scales = condition_scales(conditions, margins)
    reach = 2.0 * float(np.max(np.linalg.norm(points[triangles[:1, 1]] - points[triangles[:1, 0]])))
    loops = []
    residual, before, unmoved, area, coarse_area = 0.0, 0.0, 0, 0.0, 0.0
    for outline in region.loops:
        corners = _corners_of(region, (outline,), triangles, points, margins, scales, polygon)
        start = _residuals(corners, conditions, scales, exact)
        before = max(before, float(np.max(start, initial=0.0, where=np.isfinite(start))))
        reached = _move(corners, conditions, scales, exact, polygon, reach)
        coarse_area += _area(corners.points)
        following = np.roll(np.arange(len(corners.points)), -1)
        shared = corners.active & corners.active[following]
        straight = (corners.sides & corners.sides[following]).any(axis=1)
        curved = np.flatnonzero(shared.any(axis=1) & ~straight & reached & reached[following])
        middles = _Corners(
            (corners.points[curved] + corners.points[following[curved]]) / 2.0,
            shared[curved],
            np.zeros((len(curved), len(polygon.corners)), dtype=np.bool_),
        )
        reached_middles = _move(middles, conditions, scales, exact, polygon, reach)
        together = corners.joined(middles)
        arrived = np.concatenate([reached, reached_middles])
        order = np.argsort(
            np.concatenate([np.arange(len(corners.points)), curved + 0.5]), kind="stable"
        )
        # Corners near a meeting point of two bounds may have moved beyond the other bound.
        kept = [place for place in order if arrived[place] or place < len(corners.points)]
        beyond = _beyond(together, conditions, scales, exact) & arrived
        loop = [place for place in kept if not beyond[place]]
        final = _residuals(together, conditions, scales, exact)
        counted = final[arrived]
        residual = max(residual, float(np.max(counted, initial=0.0, where=np.isfinite(counted))))
        unmoved += int(np.count_nonzero(~reached))
        area += _area(together.points[loop])
        loops.append(together.points[loop])
    # A side's sagitta falls by four when the side is halved.
    correction = (area - coarse_area) / 3.0
    return RefinedRegion(
        loops=tuple(loops),
        residual=residual,
        interpolation_error=before,
        unmoved=unmoved,
        area=area + correction,
        area_error=abs(correction),
    )


def _corners_of(
    region: Region,
    loops: Sequence[FloatArray],
    triangles: IntArray,
    points: FloatArray,
    margins: FloatArray,
    scales: FloatArray,
    polygon: DesignPolygon,
) -> _Corners:
    """Return the corners of loops with the conditions and sides that they lie on."""
    from scipy.spatial import cKDTree

    vertices = triangles[region.corner_triangles]
    places = np.einsum("cv,cvx->cx", region.corner_weights, points[vertices])
    outline = np.concatenate([np.empty((0, 2)), *loops])
    if not len(places):
        nearest = np.empty(0, dtype=np.int64)
    else:
        nearest = cKDTree(places).query(outline)[1]
    weights, corners = region.corner_weights[nearest], vertices[nearest]
    at_corners = np.einsum("cv,kcv->ck", weights, margins[:, corners])
    return _Corners(
        points=outline.copy(),
        active=np.abs(at_corners) <= _AT_BOUND * np.maximum(scales, 1e-300),
        sides=np.abs(polygon.distances(outline)) <= 1e-9,
    )


def _residuals(
    corners: _Corners, conditions: Sequence[Condition], scales: FloatArray, exact: ExactValues
) -> FloatArray:
    """Return the largest relative distance of each corner from the bounds it lies on."""
    margins = _margins(corners.points, conditions, exact)
    relative = np.abs(margins) / scales[:, np.newaxis]
    return np.asarray(np.max(relative, axis=0, initial=0.0, where=corners.active.T))


def _beyond(
    corners: _Corners, conditions: Sequence[Condition], scales: FloatArray, exact: ExactValues
) -> BoolArray:
    """Return which corners break a condition that they do not lie on."""
    margins = _margins(corners.points, conditions, exact) / scales[:, np.newaxis]
    return np.asarray(np.any((margins < -RESIDUAL) & ~corners.active.T, axis=0))


def _margins(points: FloatArray, conditions: Sequence[Condition], exact: ExactValues) -> FloatArray:
    """Return exact margins, shape (conditions, n)."""
    if not len(points):
        return np.empty((len(conditions), 0))
    values = exact.values(points)
    rows = [exact.names.index(condition.quantity) for condition in conditions]
    margins = [each.margin(values[row]) for each, row in zip(conditions, rows, strict=True)]
    return np.array(margins).reshape(len(conditions), len(points))


def _move(
    corners: _Corners,
    conditions: Sequence[Condition],
    scales: FloatArray,
    exact: ExactValues,
    polygon: DesignPolygon,
    reach: float,
) -> BoolArray:
    """Move corners to their bounds by Newton's method, all at once; return which arrived.

    A step is the shortest one that meets all bounds of a corner and stays on its sides; a
    corner that does not arrive within ``reach`` goes back to where it was. Gradients are
    kept as long as the residual falls fast with them.
    """
    start = corners.points.copy()
    best = np.full(len(start), np.inf)
    best_points = start.copy()
    before = np.full(len(start), np.inf)
    slopes = np.full((len(conditions), len(start), 2), np.nan)
    movable = corners.active.any(axis=1) & (np.count_nonzero(corners.sides, axis=1) < 2)
    moving = np.flatnonzero(movable)
    rows = [exact.names.index(condition.quantity) for condition in conditions]
    signs = np.array([1.0 if condition.operator[0] == ">" else -1.0 for condition in conditions])
    bounds = np.array([condition.bound for condition in conditions])
    for _ in range(_ITERATIONS):
        if not len(moving):
            break
        points = corners.points[moving]
        values = exact.values(points)
        residuals = (signs * (values[rows].T - bounds)) / scales  # (moving, conditions)
        active = corners.active[moving]
        worst = np.max(np.abs(residuals), axis=1, initial=0.0, where=active)
        worst = np.where(np.isnan(residuals).any(axis=1), np.inf, worst)
        improved = worst < best[moving]
        best[moving[improved]] = worst[improved]
        best_points[moving[improved]] = points[improved]
        gone = np.linalg.norm(points - start[moving], axis=1) > reach
        going = (worst > _AIM) & np.isfinite(worst) & ~gone
        moving, points, worst = moving[going], points[going], worst[going]
        values, residuals = values[:, going], residuals[going]
        slow = ~(worst <= _FAST * before[moving]) | np.isinf(before[moving])
        before[moving] = worst
        if slow.any():
            gradients = exact.gradients(points[slow], values[:, slow])[rows]
            slopes[:, moving[slow]] = (signs / scales)[:, np.newaxis, np.newaxis] * gradients
        for number, corner in enumerate(moving):
            step = _step(
                residuals[number],
                slopes[:, corner],
                corners.active[corner],
                polygon.normals[corners.sides[corner]],
            )
            length = float(np.linalg.norm(step))
            corners.points[corner] += step * min(1.0, reach / max(length, 1e-300))
        corners.points[moving] = polygon.clip(corners.points[moving])
    corners.points[movable] = best_points[movable]
    failed = movable & (best > RESIDUAL)
    corners.points[failed] = start[failed]
    fixed = ~movable & (corners.sides.any(axis=1) | corners.active.any(axis=1))
    return np.asarray((movable & ~failed) | fixed)


def _step(
    residuals: FloatArray, gradients: FloatArray, active: BoolArray, normals: FloatArray
) -> FloatArray:
    """Return the shortest step to all active bounds, along a side where there is one."""
    matrix, wanted = gradients[active], -residuals[active]
    if len(normals):
        along = np.array([-normals[0, 1], normals[0, 0]])
        slopes = matrix @ along
        # Bounds that do not change along the side hold there, or cannot be met. What happens
        # across it does not count: on some borders values jump.
        used = np.abs(slopes) > _FLAT
        if not used.any():
            return np.zeros(2)
        share = float(slopes[used] @ wanted[used]) / float(slopes[used] @ slopes[used])
        return share * along
    return np.asarray(np.linalg.lstsq(matrix, wanted, rcond=_DEPENDENT)[0], dtype=np.float64)


def _area(loop: FloatArray) -> float:
    if len(loop) < 3:
        return 0.0
    x, y = loop.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
