"""Level curves of a function of the plane, with corners that lie on them exactly.

contourpy finds the curves on a grid, to the accuracy of a linear interpolation. Each corner it
gives lies on an edge of the grid, between a point where the function is above the level and
one where it is not: there the true crossing is closed in on by bisection, for all corners
together.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Sequence

import contourpy
import numpy as np

from fivebar_atlas.planar_geometry import (
    CLOSED,
    FloatArray,
    Loop,
    NamedArc,
    Point,
    PolylineArc,
    Region,
)

#: Takes abscissas and ordinates, shape (n,); returns the function there, shape (n,).
Field = Callable[[FloatArray, FloatArray], FloatArray]

# Halvings of a grid edge; the last is far below rounding.
_HALVINGS = 48
# Times that sides of a polygon are halved at most.
_ROUNDS = 10
# Half sides that a level curve may be away from the middle of a side.
_STRIDES = 12
# Where a part falls into pieces, how much finer the grid is made.
_FINER = 4
# Finer and finer grids around a peak, and their cells.
_ZOOMS, _ZOOM_CELLS = 5, 64
# In steps of the grid, how close to a grid point is on it.
_ON_POINT = 1e-12


@dataclasses.dataclass(frozen=True)
class SampledField:
    """A continuous function sampled on a grid that covers where it is above zero.

    Attributes
    ----------
    function
        The function.
    x, y
        Lines of the grid, shapes (nx,) and (ny,).
    values
        The function on the grid, shape (ny, nx).
    """

    function: Field
    x: FloatArray
    y: FloatArray
    values: FloatArray

    @classmethod
    def over(
        cls, function: Field, lower: FloatArray, upper: FloatArray, cells: int
    ) -> SampledField:
        """Sample a function on a box and half a cell around it.

        Parameters
        ----------
        function
            Continuous, and zero or less outside the box.
        lower, upper
            Corners of the box, shape (2,).
        cells
            Cells along its longer side.
        """
        step = float((upper - lower).max()) / cells
        lines = [
            low + step * (np.arange(int(np.ceil((high - low) / step)) + 2) - 0.5)
            for low, high in zip(lower, upper, strict=True)
        ]
        x, y = np.meshgrid(*lines)
        values = function(x.ravel(), y.ravel()).reshape(x.shape)
        return cls(function, lines[0], lines[1], values)

    def finer(self, times: int) -> SampledField:
        """Return the field on a grid with so many times the cells each way."""
        lower, upper = np.array([self.x[0], self.y[0]]), np.array([self.x[-1], self.y[-1]])
        cells = times * (max(len(self.x), len(self.y)) - 1)
        return SampledField.over(self.function, lower, upper, cells)

    @functools.cached_property
    def _generator(self) -> contourpy.ContourGenerator:
        return contourpy.contour_generator(
            self.x,
            self.y,
            self.values,
            line_type=contourpy.LineType.Separate,
            fill_type=contourpy.FillType.OuterOffset,
        )

    def polygons(self, level: float, deviation: float = math.inf) -> list[list[FloatArray]]:
        """Return the parts of the plane where the function is at least a level.

        Parameters
        ----------
        level
            The level, above zero.
        deviation
            Sides whose middle is farther than this from the level curve are halved, with
            the new corner on the curve.

        Returns
        -------
        list of list of ndarray
            For each connected part its outline, counter-clockwise, then its holes,
            clockwise; closed polygons of shape (n, 2), the first corner not repeated.
        """
        points, offsets = self._generator.filled(level, np.inf)[:2]
        parts = []
        for corners, places in zip(points, offsets, strict=True):
            assert corners is not None
            assert places is not None
            exact = self._exact(np.asarray(corners), level)
            loops = [
                _without_repetition(exact[start : stop - 1])
                for start, stop in itertools.pairwise(places)
            ]
            outline, *holes = (loop for loop in loops if len(loop) >= 3)
            turned = [_turned(outline, True), *(_turned(hole, False) for hole in holes)]
            parts.append([self._halved(loop, level, deviation) for loop in turned])
        return parts

    def lines(self, level: float) -> list[FloatArray]:
        """Return the curves on which the function has a value, shape (n, 2) each."""
        return [self._exact(np.asarray(line), level) for line in self._generator.lines(level)]

    def settled(self, loop: FloatArray, level: float, deviation: float) -> FloatArray:
        """Move corners of a polygon that are within a deviation of the level curve onto it."""
        along = np.roll(loop, -1, axis=0) - np.roll(loop, 1, axis=0)
        lengths = np.maximum(np.hypot(*along.T), 1e-300)
        outward = deviation * np.column_stack([along[:, 1], -along[:, 0]]) / lengths[:, None]
        return self._crossed(loop, outward, level)

    def _halved(self, loop: FloatArray, level: float, deviation: float) -> FloatArray:
        """Halve the sides of a closed polygon that leave the level curve by too much.

        What is above the level lies on the left of the polygon.
        """
        fresh = np.ones(len(loop), dtype=np.bool_)  # sides not looked at yet, by first corner
        for _ in range(_ROUNDS):
            sides = np.flatnonzero(fresh)
            if not len(sides) or not math.isfinite(deviation):
                break
            along = np.roll(loop, -1, axis=0)[sides] - loop[sides]
            middles = loop[sides] + 0.5 * along
            found = self._crossed(middles, np.column_stack([along[:, 1], -along[:, 0]]), level)
            split = np.hypot(*(found - middles).T) > deviation
            loop = np.insert(loop, sides[split] + 1, found[split], axis=0)
            marks = np.zeros(len(fresh), dtype=np.bool_)
            marks[sides[split]] = True
            fresh = np.repeat(marks, np.where(marks, 2, 1))
        return loop

    def _crossed(self, points: FloatArray, outward: FloatArray, level: float) -> FloatArray:
        """Return where the level is crossed next to points, along given directions.

        Outward from points above the level, inward from those below, no farther than a few
        times the direction's length: a tip thinner than the grid is longer than its base.
        Points next to which it is not crossed are returned themselves.
        """
        above = self.function(points[:, 0], points[:, 1]) >= level
        step = np.where(above[:, None], 0.5 * outward, -0.5 * outward)
        near, far = points, points + step
        pending = np.ones(len(points), dtype=np.bool_)
        for _ in range(_STRIDES):
            pending &= (self.function(far[:, 0], far[:, 1]) >= level) == above
            near = np.where(pending[:, None], far, near)
            far = np.where(pending[:, None], far + step, far)
        near = np.where(pending[:, None], points, near)
        far = np.where(pending[:, None], points, far)
        inside, outside = (
            np.where(above[:, None], near, far),
            np.where(above[:, None], far, near),
        )
        return self._bisected(inside, outside, level)

    def _bisected(self, inside: FloatArray, outside: FloatArray, level: float) -> FloatArray:
        """Return where the level is crossed between points above it and points below."""
        for _ in range(_HALVINGS):
            middle = 0.5 * (inside + outside)
            above = self.function(middle[:, 0], middle[:, 1]) >= level
            inside = np.where(above[:, None], middle, inside)
            outside = np.where(above[:, None], outside, middle)
        return inside

    def _exact(self, corners: FloatArray, level: float) -> FloatArray:
        """Move corners along the grid edges they lie on to where the level is crossed."""
        columns = np.interp(corners[:, 0], self.x, np.arange(len(self.x)))
        rows = np.interp(corners[:, 1], self.y, np.arange(len(self.y)))
        off_column = np.abs(columns - np.round(columns))
        off_row = np.abs(rows - np.round(rows))
        on_point = np.maximum(off_column, off_row) < _ON_POINT  # which then is on the level
        along_x = off_column > off_row
        column = np.where(along_x, np.floor(columns), np.round(columns)).astype(np.int64)
        row = np.where(along_x, np.round(rows), np.floor(rows)).astype(np.int64)
        column = np.clip(column, 0, len(self.x) - 1 - along_x)
        row = np.clip(row, 0, len(self.y) - 1 - ~along_x)
        next_column, next_row = column + along_x, row + ~along_x
        is_high = self.values[row, column] >= level
        inside = np.column_stack([self.x[column], self.y[row]])
        outside = np.column_stack([self.x[next_column], self.y[next_row]])
        inside, outside = (
            np.where(is_high[:, None], inside, outside),
            np.where(is_high[:, None], outside, inside),
        )
        exact = self._bisected(inside, outside, level)
        return np.where(on_point[:, None], corners, exact)


def level_regions(
    field: SampledField,
    level: float,
    name: str,
    symbol: str,
    peaks: Sequence[Point] = (),
    deviation: float = math.inf,
) -> tuple[Region, ...]:
    """Return the parts of the plane where a function is at least a level, largest first.

    Parameters
    ----------
    field
        The function.
    level
        The level, above zero.
    name, symbol
        What the function is, for the names of the boundaries: ``"LCI"`` becomes
        ``"LCI = 0.5"``.
    peaks
        Points where the function is largest, for parts that are smaller than the grid.
    deviation
        How far the middle of a side may be from the curve; see :meth:`SampledField.polygons`.
    """
    found, field = separate_polygons(field, level, deviation)
    for peak in peaks:
        if not any(_is_within(peak, outline) for outline, *_ in found):
            found.extend(_small_parts(field, level, peak, deviation))

    def loop(corners: FloatArray) -> Loop:
        arc = PolylineArc(np.vstack([corners, corners[:1]]))
        title = f"{symbol} $= {level:g}$"
        return Loop((NamedArc(f"{name} = {level:g}", title, "level", arc, (CLOSED, CLOSED)),))

    parts = [
        Region(loop(outline), tuple(loop(hole) for hole in holes)) for outline, *holes in found
    ]
    return tuple(sorted(parts, key=lambda part: -part.area))


def separate_polygons(
    field: SampledField, level: float, deviation: float
) -> tuple[list[list[FloatArray]], SampledField]:
    """Return the parts where a function is at least a level, none of which overlap.

    Also the field that they are from: a finer one where a part is thinner than the grid, which
    shows it as pieces.
    """
    found = field.polygons(level, deviation)
    if _merged(found) is not found:
        field = field.finer(_FINER)
        found = [
            [field.settled(loop, level, deviation) for loop in part]
            for part in _merged(field.polygons(level, deviation))
        ]
    return found, field


def _merged(parts: list[list[FloatArray]]) -> list[list[FloatArray]]:
    """Return parts that do not overlap: those that do are made one."""
    if len(parts) < 2:
        return parts
    import shapely

    shapes = [shapely.make_valid(shapely.Polygon(outline, holes)) for outline, *holes in parts]
    tree = shapely.STRtree(shapes)
    one, two = tree.query(shapes, predicate="intersects")
    if not np.any(one != two):
        return parts
    whole = shapely.union_all(shapes)
    return [
        [
            _turned(np.array(part.exterior.coords)[:-1], True),
            *(_turned(np.array(hole.coords)[:-1], False) for hole in part.interiors),
        ]
        for part in shapely.get_parts(whole)
        if part.geom_type == "Polygon"
    ]


def _small_parts(
    field: SampledField, level: float, peak: Point, deviation: float
) -> list[list[FloatArray]]:
    """Return the part around a peak, looked for on finer and finer grids."""
    half = 2.0 * float(field.x[1] - field.x[0])
    for _ in range(_ZOOMS):
        box = np.array(peak) + half * np.array([[-1.0, -1.0], [1.0, 1.0]])
        near = SampledField.over(field.function, box[0], box[1], _ZOOM_CELLS)
        parts = [part for part in near.polygons(level, deviation) if _reaches(peak, part, half)]
        if parts:
            return parts[:1]
        half *= 4.0 / _ZOOM_CELLS
    return []


def _reaches(peak: Point, part: list[FloatArray], half: float) -> bool:
    """Tell whether a part is that around a peak and ends inside the box about it."""
    gaps = np.hypot(*(part[0] - np.array(peak)).T)
    spread = np.abs(part[0] - np.array(peak)).max()
    close = gaps.min() <= 4.0 * half / _ZOOM_CELLS or _is_within(peak, part[0])
    return bool(close and spread < half)


def _is_within(point: Point, outline: FloatArray) -> bool:
    """Tell whether a point is inside a polygon, by the number of sides above it."""
    (x, y), (xs, ys) = point, outline.T
    next_x, next_y = np.roll(xs, -1), np.roll(ys, -1)
    spans = (xs > x) != (next_x > x)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = ys + (x - xs) * (next_y - ys) / (next_x - xs)
    return bool(np.count_nonzero(spans & (height > y)) % 2)


def _without_repetition(loop: FloatArray) -> FloatArray:
    """Drop corners that are the same as the ones before them."""
    return loop[np.any(loop != np.roll(loop, 1, axis=0), axis=1)]


def _turned(loop: FloatArray, counter_clockwise: bool) -> FloatArray:
    """Return a polygon run through in the sense asked for."""
    x, y = loop.T
    area = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    return loop if (area > 0.0) == counter_clockwise else loop[::-1]
