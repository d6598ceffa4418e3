"""The region in which a machine works, and the extremes of functions over it.

Two kinds: a shape placed in a design, and a whole part of a good-condition workspace. Both are
non-dimensional regions with boundaries that are run through by a parameter.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.planar_geometry import FloatArray, Point, Region
from fivebar_atlas.synthesis.containment import GoodCondition
from fivebar_atlas.synthesis.shapes import Shape

BoolArray = npt.NDArray[np.bool_]
#: A function of points of shape (n, 2), of which it returns one value each.
Field = Callable[[FloatArray], FloatArray]

# Samples of a boundary, and of a box around a region along its longer side.
_BOUNDARY, _GRID = 2000, 160
# Local extremes that are closed in on, trial points of a round and number of rounds.
_EXTREMES, _ZOOM, _ZOOM_ROUNDS = 12, 13, 12
_HALVINGS = 50
# A step of a search in the interior that ends it, as a share of the first one.
_LAST_STEP = 1e-10
_LEAST_SEGMENT = 200


@dataclasses.dataclass(frozen=True)
class Boundary:
    """A closed curve.

    Attributes
    ----------
    at
        Returns the points, shape (n, 2), at places u along it, shape (n,).
    places
        Increasing samples of u, all corners with them, shape (n,).
    period
        u at which the curve is closed.
    """

    at: Field
    places: FloatArray
    period: float

    def close_in(self, function: Field, starts: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Return the places of local maxima near samples, and the values there.

        Parameters
        ----------
        function
            Of points of the curve.
        starts
            Samples with local maxima among the samples.
        """
        picked = np.asarray(starts, dtype=np.int64)
        middle = self.places[picked]
        before = np.mod(middle - np.roll(self.places, 1)[picked], self.period)
        after = np.mod(np.roll(self.places, -1)[picked] - middle, self.period)
        width = np.maximum(before, after)
        best = function(self.at(middle))
        rows = np.arange(len(picked))
        for _ in range(_ZOOM_ROUNDS):
            trial = middle[:, None] + width[:, None] * np.linspace(-1.0, 1.0, _ZOOM)
            values = function(self.at(np.mod(trial.ravel(), self.period))).reshape(trial.shape)
            place = np.argmax(values, axis=1)
            better = values[rows, place] > best
            middle = np.where(better, trial[rows, place], middle)
            best = np.where(better, values[rows, place], best)
            width = width * (2.0 / (_ZOOM - 1))
        return np.mod(middle, self.period), best


@dataclasses.dataclass(frozen=True)
class PracticalWorkspace:
    """A connected region of the plane of a non-dimensional design.

    Attributes
    ----------
    boundaries
        The outline, then the boundaries of holes.
    contains
        Tells which points, shape (n, 2), lie in it.
    """

    boundaries: tuple[Boundary, ...]
    contains: Callable[[FloatArray], BoolArray]

    @classmethod
    def of_shape(cls, shape: Shape, position: Point, scale: float) -> PracticalWorkspace:
        """Return a shape whose centre is at a position, its lengths times a scale."""
        place = np.array(position)

        def at(u: FloatArray) -> FloatArray:
            return np.asarray(place + scale * shape.boundary(u))

        def contains(points: FloatArray) -> BoolArray:
            return shape.contains((points - place) / scale)

        places = shape.boundary_samples(_BOUNDARY)
        return cls((Boundary(at, places, float(shape.pieces)),), contains)

    @classmethod
    def of_region(cls, good: GoodCondition, part: Region) -> PracticalWorkspace:
        """Return a part of a good-condition workspace."""
        import shapely

        polygons = [each[:-1] for each in part.polygons(1.0)]
        outline = shapely.Polygon(polygons[0], polygons[1:])
        shapely.prepare(outline)

        def contains(points: FloatArray) -> BoolArray:
            # The polygon tells this part from others, but for what its chords cut off.
            near = shapely.contains_xy(outline, points[:, 0], points[:, 1])
            return np.asarray(near & (good.margins(points) >= 0.0))

        return cls(tuple(_level_boundary(good, corners) for corners in polygons), contains)

    def greatest(self, function: Field) -> tuple[float, Point]:
        """Return the largest value of a continuous function, and where it is.

        Dense samples of boundary and interior, closed in on where they have local maxima.
        """
        best = -math.inf, (math.nan, math.nan)
        for boundary in self.boundaries:
            values = function(boundary.at(boundary.places))
            places, values = boundary.close_in(function, peaks(values))
            top = int(np.argmax(values))
            if values[top] > best[0]:
                x, y = boundary.at(places[top : top + 1])[0]
                best = float(values[top]), (float(x), float(y))
        for start, step in self._interior_peaks(function):
            value, point = self._climb(function, start, step)
            if value > best[0]:
                best = value, point
        return best

    def _interior_peaks(self, function: Field) -> list[tuple[FloatArray, float]]:
        """Return grid points in the region with locally greatest values, and the grid's step."""
        outline = self.boundaries[0].at(self.boundaries[0].places)
        lower, upper = outline.min(axis=0), outline.max(axis=0)
        step = float((upper - lower).max()) / _GRID
        lines = [np.arange(low, high + step, step) for low, high in zip(lower, upper, strict=True)]
        x, y = np.meshgrid(*lines)
        points = np.column_stack([x.ravel(), y.ravel()])
        inside = self.contains(points)
        values = np.full(len(points), -np.inf)
        values[inside] = function(points[inside])
        wide = np.pad(values.reshape(x.shape), 1, constant_values=-np.inf)
        around = [
            wide[1 + i : 1 + i + x.shape[0], 1 + j : 1 + j + x.shape[1]]
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
        ]
        tops = np.flatnonzero(inside & (values >= np.max(around, axis=0).ravel()))
        tops = tops[np.argsort(-values[tops], kind="stable")][:_EXTREMES]
        return [(points[top], step) for top in tops]

    def _climb(self, function: Field, start: FloatArray, step: float) -> tuple[float, Point]:
        """Return a local maximum in the region by steps in all directions, ever smaller."""
        angles = 0.25 * math.pi * np.arange(8)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        point, value = start, float(function(start[None])[0])
        last = step * _LAST_STEP
        while step > last:
            trial = point + step * directions
            trial = trial[self.contains(trial)]
            values = function(trial) if len(trial) else np.array([-np.inf])
            top = int(np.argmax(values))
            if values[top] > value:
                point, value = trial[top], float(values[top])
            else:
                step *= 0.5
        return value, (float(point[0]), float(point[1]))


def _level_boundary(good: GoodCondition, corners: FloatArray) -> Boundary:
    """Return the boundary through corners on it, at the threshold between them too.

    Parameters
    ----------
    good
        What its points are on the border of.
    corners
        Corners in order, the region on the left, shape (n, 2).
    """
    following = np.roll(corners, -1, axis=0)
    count = len(corners)

    def at(u: FloatArray) -> FloatArray:
        piece = np.minimum(u.astype(np.int64), count - 1)
        share = (u - piece)[:, None]
        chord = following[piece] - corners[piece]
        on_chord = corners[piece] + share * chord
        inward = np.column_stack([-chord[:, 1], chord[:, 0]])
        # a curve leaves its chord by less at its ends; corners themselves are exact
        bulge = 2.0 * share * (1.0 - share) * inward
        inside, outside = on_chord + bulge, on_chord - bulge
        crosses = (good.margins(inside) >= 0.0) & (good.margins(outside) < 0.0)
        for _ in range(_HALVINGS):
            middle = 0.5 * (inside + outside)
            fits = (good.margins(middle) >= 0.0)[:, None]
            inside, outside = np.where(fits, middle, inside), np.where(fits, outside, middle)
        return np.where(crosses[:, None], inside, on_chord)

    return Boundary(at, np.arange(count, dtype=np.float64), float(count))


def peaks(values: FloatArray) -> list[int]:
    """Return the places of local maxima along a closed curve, the highest first."""
    tops = np.flatnonzero((values >= np.roll(values, 1)) & (values >= np.roll(values, -1)))
    return [int(top) for top in tops[np.argsort(-values[tops], kind="stable")][:_EXTREMES]]


@dataclasses.dataclass(frozen=True, slots=True)
class InputRange:
    """The angles that one input runs over, continuous throughout a practical workspace.

    Attributes
    ----------
    number
        Which input, from 1.
    least, greatest
        In radians; from 0 to 2π where it turns fully.
    at_least, at_greatest
        Where they are taken; None where it turns fully.
    """

    number: int
    least: float
    greatest: float
    at_least: Point | None
    at_greatest: Point | None

    @property
    def is_full_turn(self) -> bool:
        """Whether a way around a hole of the workspace turns the input around."""
        return self.at_least is None


def input_ranges(good: GoodCondition, workspace: PracticalWorkspace) -> tuple[InputRange, ...]:
    """Return the ranges of all inputs over a practical workspace, unwrapped.

    Inputs have no extremes inside a region without singularities, for the rows of the Jacobian
    are not zero there: they are on its boundary. Where a way around a hole turns an input
    around it comes to every angle.

    Parameters
    ----------
    good
        Design and mode.
    workspace
        A region without singularities.
    """
    inputs = [_unwrapped(good, boundary) for boundary in workspace.boundaries]
    shifts = _shifts(good, workspace, inputs)
    ranges = []
    for column in range(inputs[0].shape[1]):
        if any(_turns(angles[:, column]) for angles in inputs):
            ranges.append(InputRange(column + 1, 0.0, 2.0 * math.pi, None, None))
            continue
        ends = []
        for sign in (-1.0, 1.0):
            found = []
            for boundary, angles, shift in zip(workspace.boundaries, inputs, shifts, strict=True):
                values = angles[:-1, column]
                for start in peaks(sign * values)[:2]:
                    place, angle = _extreme(good, boundary, column, sign, start, values[start])
                    found.append((sign * (angle + shift[column]), place))
            value, point = max(found)
            ends.append((sign * value, point))
        (least, at_least), (greatest, at_greatest) = ends
        turn = 2.0 * math.pi * math.floor(0.5 * (least + greatest) / (2.0 * math.pi) + 0.5)
        ends_of_range = float(least - turn), float(greatest - turn)
        ranges.append(InputRange(column + 1, *ends_of_range, at_least, at_greatest))
    return tuple(ranges)


def _extreme(
    good: GoodCondition, boundary: Boundary, column: int, sign: float, start: int, near: float
) -> tuple[Point, float]:
    """Return an extreme of an input along a boundary, next to a sample with a known angle."""

    def signed(points: FloatArray) -> FloatArray:
        angles = good.design.inputs(points[:, 0], points[:, 1], good.mode)[:, column]
        return np.asarray(sign * (near + _principal(angles - near)))

    places, values = boundary.close_in(signed, [start])
    x, y = boundary.at(places)[0]
    return (float(x), float(y)), sign * float(values[0])


def _unwrapped(good: GoodCondition, boundary: Boundary) -> FloatArray:
    """Return continuous inputs along a boundary and back at its start, shape (n + 1, inputs)."""
    points = boundary.at(boundary.places)
    closed = np.concatenate([points, points[:1]])
    return _along(good, closed)


def _along(good: GoodCondition, points: FloatArray) -> FloatArray:
    """Return continuous inputs at points of a path, shape (n, inputs)."""
    inputs = good.design.inputs(points[:, 0].copy(), points[:, 1].copy(), good.mode)
    return np.asarray(np.unwrap(inputs, axis=0))


def _turns(angles: FloatArray) -> int:
    """Return how many turns angles along a closed boundary make."""
    return round(float(angles[-1] - angles[0]) / (2.0 * math.pi))


def _shifts(
    good: GoodCondition, workspace: PracticalWorkspace, inputs: Sequence[FloatArray]
) -> list[FloatArray]:
    """Return what to add to the inputs along each boundary to make them continuous.

    The nearest of the boundaries still apart is joined to those that are not, each time; the
    straight way between them meets no other and lies in the region.
    """
    points = [boundary.at(boundary.places) for boundary in workspace.boundaries]
    shifts: dict[int, FloatArray] = {0: np.zeros(inputs[0].shape[1])}
    while len(shifts) < len(points):
        nearest = math.inf, 0, 0, 0, 0
        for one in shifts:
            for other in set(range(len(points))) - set(shifts):
                gaps = np.hypot(*(points[one][:, None] - points[other]).transpose(2, 0, 1))
                row, column = (int(k) for k in np.unravel_index(np.argmin(gaps), gaps.shape))
                nearest = min(nearest, (float(gaps[row, column]), one, other, row, column))
        _, one, other, row, column = nearest
        share = np.linspace(0.0, 1.0, _LEAST_SEGMENT)[:, None]
        way = _along(good, points[one][row] + share * (points[other][column] - points[one][row]))
        gain = way[-1] - way[0]
        shifts[other] = shifts[one] + inputs[one][row] + gain - inputs[other][column]
    return [shifts[place] for place in range(len(points))]


def _principal(angles: FloatArray) -> FloatArray:
    """Return angles in [-π, π)."""
    return np.asarray(np.remainder(angles + math.pi, 2.0 * math.pi) - math.pi)
