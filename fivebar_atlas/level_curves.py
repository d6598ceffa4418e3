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
from collections.abc import Callable

import contourpy
import numpy as np

from fivebar_atlas.planar_geometry import (
    CLOSED,
    FloatArray,
    Loop,
    NamedArc,
    PolylineArc,
    Region,
)

#: Takes abscissas and ordinates, shape (n,); returns the function there, shape (n,).
Field = Callable[[FloatArray, FloatArray], FloatArray]

# Halvings of a grid edge; the last is far below rounding.
_HALVINGS = 48
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

    @functools.cached_property
    def _generator(self) -> contourpy.ContourGenerator:
        return contourpy.contour_generator(
            self.x,
            self.y,
            self.values,
            line_type=contourpy.LineType.Separate,
            fill_type=contourpy.FillType.OuterOffset,
        )

    def polygons(self, level: float) -> list[list[FloatArray]]:
        """Return the parts of the plane where the function is at least a level.

        Parameters
        ----------
        level
            The level, above zero.

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
            parts.append([_turned(outline, True), *(_turned(hole, False) for hole in holes)])
        return parts

    def lines(self, level: float) -> list[FloatArray]:
        """Return the curves on which the function has a value, shape (n, 2) each."""
        return [self._exact(np.asarray(line), level) for line in self._generator.lines(level)]

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
        for _ in range(_HALVINGS):
            middle = 0.5 * (inside + outside)
            above = self.function(middle[:, 0], middle[:, 1]) >= level
            inside = np.where(above[:, None], middle, inside)
            outside = np.where(above[:, None], outside, middle)
        return np.where(on_point[:, None], corners, inside)


def level_regions(field: SampledField, level: float, name: str, symbol: str) -> tuple[Region, ...]:
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
    """

    def loop(corners: FloatArray) -> Loop:
        arc = PolylineArc(np.vstack([corners, corners[:1]]))
        title = f"{symbol} $= {level:g}$"
        return Loop((NamedArc(f"{name} = {level:g}", title, "level", arc, (CLOSED, CLOSED)),))

    parts = [
        Region(loop(outline), tuple(loop(hole) for hole in holes))
        for outline, *holes in field.polygons(level)
    ]
    return tuple(sorted(parts, key=lambda part: -part.area))


def _without_repetition(loop: FloatArray) -> FloatArray:
    """Drop corners that are the same as the ones before them."""
    return loop[np.any(loop != np.roll(loop, 1, axis=0), axis=1)]


def _turned(loop: FloatArray, counter_clockwise: bool) -> FloatArray:
    """Return a polygon run through in the sense asked for."""
    x, y = loop.T
    area = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    return loop if (area > 0.0) == counter_clockwise else loop[::-1]
