"""Optimum regions with their outlines moved from the lattice onto the true level sets.

The outline of a region of the lattice has corners where a bound is reached by linear
interpolation. Newton's method moves each of them to where the bound is reached by the
quantity itself: along its gradient, along the border of the design space where it lies on
one, and to the common point of both bounds where two meet. The first gradients are those of
the interpolation, and every step corrects them by what it found (Broyden's method).
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
# Gradients are computed by differences where a step leaves more than this share of a residual.
_FAST = 0.3
# From residuals below this one a step leads to where values of the full accuracy are needed.
_CLOSE = 1e-5
# Below this share of its scale an interpolated margin is zero.
_AT_BOUND = 1e-11
# Singular values below this share of the largest belong to directions that stay as they are.
_DEPENDENT = 1e-3
# Steps below this length teach nothing about gradients.
_STILL = 1e-9
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
    slopes: FloatArray  # gradients of scaled margins, (corners, conditions, 2)
    margins: FloatArray  # scaled, NaN where not computed yet, (corners, conditions)

    def joined(self, other: _Corners) -> _Corners:
        pairs = (
            (getattr(self, field.name), getattr(other, field.name))
            for field in dataclasses.fields(self)
        )
        return _Corners(*map(np.concatenate, pairs))

    def residuals(self) -> FloatArray:
        """Return the largest relative distance of each corner from the bounds it lies on."""
        largest = np.max(np.abs(self.margins), axis=1, initial=0.0, where=self.active)
        return np.asarray(largest)


def outline_error(
    region: Region,
    conditions: Sequence[Condition],
    triangles: IntArray,
    points: FloatArray,
    margins: FloatArray,
    scales: FloatArray,
    exact: ExactValues,
) -> float:
    """Return the largest relative error of interpolated bounds at corners of an outline.

    Parameters are as for :func:`refine`; 0 where no corner lies on a bound.
    """
    polygon = DesignPolygon.of_lattice(points, triangles)
    corners = _corners_of(region, region.loops, triangles, points, margins, scales, polygon)
    corners.margins[:] = _margins(corners.points, conditions, scales, exact.for_search())
    residuals = corners.residuals()
    return float(np.max(residuals, initial=0.0, where=np.isfinite(residuals)))


def refine(
    region: Region,
    conditions: Sequence[Condition],
    triangles: IntArray,
    points: FloatArray,
    margins: FloatArray,
    scales: FloatArray,
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
    scales
        What residuals are relative to, shape (conditions,).
    exact
        Values of the conditions' quantities, and others, anywhere.

    Returns
    -------
    RefinedRegion
        The region; corners on the border of the lattice stay on it. Sides between corners
        on one bound get a further corner in the middle.
    """
    polygon = DesignPolygon.of_lattice(points, triangles)
    reach = 2.0 * float(np.max(np.linalg.norm(points[triangles[:1, 1]] - points[triangles[:1, 0]])))
    loops = []
    residual, before, unmoved, area, coarse_area = 0.0, 0.0, 0, 0.0, 0.0
    for outline in region.loops:
        corners = _corners_of(region, (outline,), triangles, points, margins, scales, polygon)
        reached, start = _move(corners, conditions, scales, exact, polygon, reach)
        before = max(before, float(np.max(start, initial=0.0, where=np.isfinite(start))))
        coarse_area += _area(corners.points)
        following = np.roll(np.arange(len(corners.points)), -1)
        shared = corners.active & corners.active[following]
        straight = (corners.sides & corners.sides[following]).any(axis=1)
        curved = np.flatnonzero(shared.any(axis=1) & ~straight & reached & reached[following])
        middles = _Corners(
            (corners.points[curved] + corners.points[following[curved]]) / 2.0,
            shared[curved],
            np.zeros((len(curved), len(polygon.corners)), dtype=np.bool_),
            (corners.slopes[curved] + corners.slopes[following[curved]]) / 2.0,
            np.full((len(curved), len(conditions)), np.nan),
        )
        reached_middles, _ = _move(middles, conditions, scales, exact, polygon, reach)
        together = corners.joined(middles)
        arrived = np.concatenate([reached, reached_middles])
        order = np.argsort(
            np.concatenate([np.arange(len(corners.points)), curved + 0.5]), kind="stable"
        )
        # Corners near a meeting point of two bounds may have moved beyond the other bound.
        kept = [place for place in order if arrived[place] or place < len(corners.points)]
        beyond = np.any((together.margins < -RESIDUAL) & ~together.active, axis=1) & arrived
        loop = [place for place in kept if not beyond[place]]
        counted = together.residuals()[arrived]
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
    at_vertices = margins[:, corners] / scales[:, np.newaxis, np.newaxis]
    at_corners = np.einsum("cv,kcv->ck", weights, at_vertices)
    along = points[corners[:, 1:]] - points[corners[:, :1]]
    rises = (at_vertices[:, :, 1:] - at_vertices[:, :, :1]).transpose(1, 2, 0)
    return _Corners(
        points=outline.copy(),
        active=np.abs(at_corners) <= _AT_BOUND,
        sides=np.abs(polygon.distances(outline)) <= 1e-9,
        slopes=np.asarray(np.linalg.solve(along, rises).transpose(0, 2, 1), dtype=np.float64),
        margins=np.full((len(outline), len(scales)), np.nan),
    )


def _margins(
    points: FloatArray, conditions: Sequence[Condition], scales: FloatArray, exact: ExactValues
) -> FloatArray:
    """Return exact margins, scaled, shape (n, conditions)."""
    if not len(points):
        return np.empty((0, len(conditions)))
    values = exact.values(points)
    rows = [exact.names.index(condition.quantity) for condition in conditions]
    margins = [each.margin(values[row]) for each, row in zip(conditions, rows, strict=True)]
    return np.array(margins).reshape(len(conditions), len(points)).T / scales


def _gradients(
    points: FloatArray, conditions: Sequence[Condition], scales: FloatArray, exact: ExactValues
) -> FloatArray:
    """Return gradients of scaled margins by differences, shape (n, conditions, 2)."""
    rows = [exact.names.index(condition.quantity) for condition in conditions]
    signs = np.array([1.0 if condition.operator[0] == ">" else -1.0 for condition in conditions])
    gradients = exact.gradients(points, exact.values(points))[rows]
    return np.asarray(gradients.transpose(1, 0, 2) * (signs / scales)[:, np.newaxis])


def _move(
    corners: _Corners,
    conditions: Sequence[Condition],
    scales: FloatArray,
    exact: ExactValues,
    polygon: DesignPolygon,
    reach: float,
) -> tuple[BoolArray, FloatArray]:
    """Move corners to their bounds, all at once.

    A step is the shortest one that meets all bounds of a corner and stays on its sides; a
    corner that does not arrive within ``reach`` goes back to where it was.

    Returns
    -------
    arrived : ndarray
        Which corners lie on their bounds now, shape (corners,).
    residuals : ndarray
        How far each was from them, shape (corners,).
    """
    start = corners.points.copy()
    search = exact.for_search()
    movable = corners.active.any(axis=1) & (np.count_nonzero(corners.sides, axis=1) < 2)
    still = np.flatnonzero(~movable)
    corners.margins[still] = _margins(start[still], conditions, scales, exact)
    at_start = corners.residuals()
    best, before = np.full((2, len(start)), np.inf)
    best_points, best_margins = start.copy(), corners.margins.copy()
    points_before, margins_before = start.copy(), corners.margins.copy()
    is_close = np.zeros(len(start), dtype=np.bool_)
    moving = np.flatnonzero(movable)
    for iteration in range(_ITERATIONS):
        if not len(moving):
            break
        for part, values in (
            (moving[~is_close[moving]], search),
            (moving[is_close[moving]], exact),
        ):
            corners.margins[part] = _margins(corners.points[part], conditions, scales, values)
        points, margins = corners.points[moving], corners.margins[moving]
        worst = corners.residuals()[moving]
        worst = np.where(np.isnan(margins).any(axis=1), np.inf, worst)
        if iteration == 0:
            at_start[moving] = worst
        improved = moving[is_close[moving] & (worst < best[moving])]
        best[improved] = corners.residuals()[improved]
        best_points[improved] = corners.points[improved]
        best_margins[improved] = corners.margins[improved]
        _learn(corners, moving, points_before, margins_before)
        points_before[moving], margins_before[moving] = points, margins
        gone = np.linalg.norm(points - start[moving], axis=1) > reach
        going = (worst > _AIM) & np.isfinite(worst) & ~gone
        # What seems to be there already is looked at once more, as it is.
        going |= ~is_close[moving] & (worst <= _AIM)
        moving, worst = moving[going], worst[going]
        slow = ~(worst <= _FAST * before[moving]) & (worst > _CLOSE * _FAST)
        slow &= np.isfinite(before[moving])
        slow |= ~np.isfinite(corners.slopes[moving]).all(axis=(1, 2))
        before[moving] = worst
        again = moving[slow]
        if len(again):
            corners.slopes[again] = _gradients(corners.points[again], conditions, scales, search)
        steps = _steps(corners, moving, polygon)
        lengths = np.linalg.norm(steps, axis=1)
        shares = np.minimum(1.0, reach / np.maximum(lengths, 1e-300))
        corners.points[moving] = polygon.clip(
            corners.points[moving] + shares[:, np.newaxis] * steps
        )
        is_close[moving] |= worst <= _CLOSE
    arrived = movable & (best <= RESIDUAL)
    failed = movable & ~arrived
    corners.points[arrived], corners.margins[arrived] = best_points[arrived], best_margins[arrived]
    corners.points[failed] = start[failed]
    fixed = ~movable & (corners.sides.any(axis=1) | corners.active.any(axis=1))
    return np.asarray(arrived | fixed), at_start


def _learn(
    corners: _Corners, moving: IntArray, points_before: FloatArray, margins_before: FloatArray
) -> None:
    """Correct gradients so that they explain what the last step changed (Broyden)."""
    steps = corners.points[moving] - points_before[moving]
    squares = np.sum(steps**2, axis=1)
    changes = corners.margins[moving] - margins_before[moving]
    with np.errstate(invalid="ignore", divide="ignore"):
        missed = changes - np.einsum("ckx,cx->ck", corners.slopes[moving], steps)
        corrections = np.einsum("ck,cx->ckx", missed, steps) / squares[:, None, None]
    usable = np.isfinite(corrections) & (squares > _STILL**2)[:, None, None]
    corners.slopes[moving] += np.where(usable, corrections, 0.0)


def _steps(corners: _Corners, moving: IntArray, polygon: DesignPolygon) -> FloatArray:
    """Return the step of each corner to its bounds, shape (moving, 2)."""
    steps = np.zeros((len(moving), 2))
    active, margins = corners.active[moving], corners.margins[moving]
    simple = (np.count_nonzero(active, axis=1) == 1) & ~corners.sides[moving].any(axis=1)
    rows = np.flatnonzero(simple)
    conditions = np.argmax(active[rows], axis=1)
    slopes = corners.slopes[moving[rows], conditions]
    squares = np.maximum(np.sum(slopes**2, axis=1), 1e-300)
    steps[rows] = -(margins[rows, conditions] / squares)[:, np.newaxis] * slopes
    for row in np.flatnonzero(~simple):
        steps[row] = _step(
            margins[row],
            corners.slopes[moving[row]],
            active[row],
            polygon.normals[corners.sides[moving[row]]],
        )
    return steps


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
