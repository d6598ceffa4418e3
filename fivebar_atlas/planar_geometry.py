"""Plane curves as exact arcs, and the closed outlines and regions that arcs make.

An arc is a curve in closed form, not a row of points: it gives any number of exact points,
its own swept area, its nearest point to any other. Lengths are in any one unit, angles in
radians. Regions lie on the left of their outlines: these run counter-clockwise, holes
clockwise.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float]

#: Kind of a curve on which nothing is singular: there a limit is met.
LIMIT = "limit"
#: Which side of an arc, seen along it, something lies on.
LEFT, RIGHT, BOTH = "left", "right", "both"
#: What there is at the end of an arc: another arc goes on in the same direction, in the
#: opposite one, or in some other; or the arc is a closed curve.
TANGENCY, CUSP, INTERSECTION, CLOSED = "tangency", "cusp", "intersection", "closed"

# Points of a curve that bracket the nearest one; brackets that are narrowed; steps.
_SAMPLES = 129
_CANDIDATES = 3
_GOLDEN_STEPS = 48
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_MOST_CHORDS = 1 << 16
# Chords that a length starts from; its error relative to the length and to the coordinates.
_LENGTH_CHORDS = 32
_LENGTH_TOLERANCE, _ROUNDING = 1e-13, 1e-15
# No share of an arc is halved to less than this, so that corners end the search.
_LEAST_SHARE = 1e-13
# Share of an arc whose chord stands for the tangent at its end.
_SHORT = 1e-4
# Directions closer than this (sine of the angle) are taken for one.
_SMOOTH = 1e-3


class Arc(ABC):
    """A piece of a smooth plane curve, run through from start to end.

    Attributes
    ----------
    start, end
        End points; equal for a closed curve.
    """

    start: Point
    end: Point

    @abstractmethod
    def points(self, shares: FloatArray) -> FloatArray:
        """Return exact points, shape (n, 2), at shares of the way from 0 to 1, shape (n,).

        Shares grow along the arc, but not in proportion to its length.
        """

    @abstractmethod
    def swept_area(self) -> float:
        """Return ½ ∫ (x dy - y dx) along the arc, in closed form (Green's theorem)."""

    @abstractmethod
    def reversed(self) -> Arc:
        """Return the arc run through the other way."""

    @abstractmethod
    def scaled(self, factor: float) -> Arc:
        """Return the arc with all lengths times a positive factor."""

    @abstractmethod
    def mirrored(self, x: bool, y: bool) -> Arc:
        """Return the image under x → -x and (or) y → -y, run through the same way."""

    def polyline(self, deviation: float) -> FloatArray:
        """Return exact points, shape (n, 2), whose chords leave the arc by no more than asked.

        Parameters
        ----------
        deviation
            Largest distance of a chord from the arc, positive.
        """
        chords = 8
        while True:
            line = self.points(np.linspace(0.0, 1.0, 2 * chords + 1))
            ends, middles = line[::2], line[1::2]
            along = np.diff(ends, axis=0)
            off = middles - ends[:-1]
            lengths = np.maximum(np.hypot(*along.T), 1e-300)
            gaps = np.abs(along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) / lengths
            if gaps.max() <= deviation or chords >= _MOST_CHORDS:
                return self._with_exact_ends(line)
            chords *= 2

    def length(self) -> float:
        """Return the length of the arc, to about 1e-11 of it.

        Each of its parts is cut into one, two and four chords. Their sums tend to the length
        with the square of the chord; where the two extrapolations differ the part is halved.
        """
        low = np.linspace(0.0, 1.0, _LENGTH_CHORDS + 1)[:-1]
        width = 1.0 / _LENGTH_CHORDS
        total, slack = 0.0, 0.0
        while len(low) and width > _LEAST_SHARE:
            shares = low[:, None] + width * np.linspace(0.0, 1.0, 5)
            line = self.points(shares.ravel()).reshape(-1, 5, 2)
            line[shares == 0.0], line[shares == 1.0] = self.start, self.end
            one, two, four = (
                np.hypot(*np.diff(line[:, ::step], axis=1).transpose(2, 0, 1)).sum(axis=1)
                for step in (4, 2, 1)
            )
            if not slack:
                slack = _LENGTH_TOLERANCE * float(four.sum()) + _ROUNDING * np.abs(line).max()
            coarse, fine = (4.0 * two - one) / 3.0, (4.0 * four - two) / 3.0
            is_done = np.abs(fine - coarse) <= slack
            total += math.fsum(fine[is_done])
            width *= 0.5
            rest = low[~is_done]
            low = np.concatenate([rest, rest + width])
        return total

    def nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distances of points from the arc and the points of the arc next to them.

        Parameters
        ----------
        points
            Shape (n, 2).

        Returns
        -------
        distances : ndarray
            Shape (n,).
        feet : ndarray
            Shape (n, 2).
        """
        shares = np.linspace(0.0, 1.0, _SAMPLES)
        samples = self._with_exact_ends(self.points(shares))
        gaps = np.hypot(*(points[:, None, :] - samples[None]).transpose(2, 0, 1))
        # the ends are candidates as they are; between samples a local minimum is closed in on
        padded = np.pad(gaps, ((0, 0), (1, 1)), constant_values=np.inf)
        is_low = (gaps <= padded[:, :-2]) & (gaps <= padded[:, 2:])
        order = np.argsort(np.where(is_low, gaps, np.inf), axis=1)[:, :_CANDIDATES]
        rows = np.arange(len(points))
        best = gaps[rows, order[:, 0]]
        feet = samples[order[:, 0]]
        for column in range(_CANDIDATES):
            place = order[:, column]
            low = shares[np.maximum(place - 1, 0)]
            high = shares[np.minimum(place + 1, _SAMPLES - 1)]
            distances, found = self._closed_in(points, low, high)
            nearer = distances < best
            best = np.where(nearer, distances, best)
            feet = np.where(nearer[:, None], found, feet)
        return best, feet

    def direction(self, at_end: bool) -> Point:
        """Return the direction of motion at the start or at the end, a unit vector.

        That of a very short chord: enough to tell a tangency from a cusp or an intersection.
        """
        share = np.array([1.0 - _SHORT if at_end else _SHORT])
        (x, y), (x0, y0) = self.points(share)[0], self.end if at_end else self.start
        dx, dy = (x0 - x, y0 - y) if at_end else (x - x0, y - y0)
        length = math.hypot(dx, dy)
        return (dx / length, dy / length) if length > 0.0 else (0.0, 0.0)

    def _closed_in(
        self, points: FloatArray, low: FloatArray, high: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Narrow brackets of shares around nearest points by golden sections."""
        left = high - _GOLDEN * (high - low)
        right = low + _GOLDEN * (high - low)
        at_left, at_right = self.points(left), self.points(right)
        gap_left = np.hypot(*(points - at_left).T)
        gap_right = np.hypot(*(points - at_right).T)
        for _ in range(_GOLDEN_STEPS):
            leftward = gap_left < gap_right
            high = np.where(leftward, right, high)
            low = np.where(leftward, low, left)
            fresh = np.where(leftward, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
            at_fresh = self.points(fresh)
            gap_fresh = np.hypot(*(points - at_fresh).T)
            left, right = np.where(leftward, fresh, right), np.where(leftward, left, fresh)
            gap_left, gap_right = (
                np.where(leftward, gap_fresh, gap_right),
                np.where(leftward, gap_left, gap_fresh),
            )
        middle = self.points(0.5 * (low + high))
        distances: FloatArray = np.hypot(*(points - middle).T)
        return distances, middle

    def _with_exact_ends(self, line: FloatArray) -> FloatArray:
        line[0], line[-1] = self.start, self.end
        return line


@dataclasses.dataclass(frozen=True, slots=True)
class CircleArc(Arc):
    """An arc of a circle.

    Attributes
    ----------
    centre, radius
        The circle.
    start_angle
        Angle about the centre where the arc starts.
    sweep
        Angle run through, positive counter-clockwise; ±2π for the whole circle.
    start, end
        End points; other arcs that meet this one there have the very same.
    """

    centre: Point
    radius: float
    start_angle: float
    sweep: float
    start: Point
    end: Point

    @classmethod
    def of_angles(cls, centre: Point, radius: float, start_angle: float, sweep: float) -> CircleArc:
        """Return the arc with end points computed from its angles."""
        ends = [
            (centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle))
            for angle in (start_angle, start_angle + sweep)
        ]
        if abs(sweep) == 2.0 * math.pi:
            ends[1] = ends[0]
        return cls(centre, radius, start_angle, sweep, ends[0], ends[1])

    @classmethod
    def whole(cls, centre: Point, radius: float) -> CircleArc:
        """Return a circle, counter-clockwise from its rightmost point."""
        return cls.of_angles(centre, radius, 0.0, 2.0 * math.pi)

    def points(self, shares: FloatArray) -> FloatArray:
        """Return points at shares of the sweep."""
        angles = self.start_angle + self.sweep * np.asarray(shares)
        return np.column_stack(
            [
                self.centre[0] + self.radius * np.cos(angles),
                self.centre[1] + self.radius * np.sin(angles),
            ]
        )

    def swept_area(self) -> float:
        """Return ½ (radius² sweep + a Δy - b Δx), (a, b) the centre."""
        dx, dy = self.end[0] - self.start[0], self.end[1] - self.start[1]
        return 0.5 * (
            self.radius * self.radius * self.sweep + self.centre[0] * dy - self.centre[1] * dx
        )

    def length(self) -> float:
        """Return radius · |sweep|."""
        return self.radius * abs(self.sweep)

    def reversed(self) -> CircleArc:
        """Return the arc run through the other way."""
        return CircleArc(
            self.centre,
            self.radius,
            self.start_angle + self.sweep,
            -self.sweep,
            self.end,
            self.start,
        )

    def scaled(self, factor: float) -> CircleArc:
        """Return the arc with all lengths times a positive factor."""
        return CircleArc(
            _times(self.centre, factor),
            self.radius * factor,
            self.start_angle,
            self.sweep,
            _times(self.start, factor),
            _times(self.end, factor),
        )

    def mirrored(self, x: bool, y: bool) -> CircleArc:
        """Return the image under x → -x and (or) y → -y."""
        angle = math.pi - self.start_angle if x else self.start_angle
        return CircleArc(
            mirror(self.centre, x, y),
            self.radius,
            -angle if y else angle,
            self.sweep if x == y else -self.sweep,
            mirror(self.start, x, y),
            mirror(self.end, x, y),
        )

    def polyline(self, deviation: float) -> FloatArray:
        """Return exact points whose chords leave the arc by no more than asked."""
        chords = 1
        if deviation < self.radius:
            # below some 1e-9 of the radius the number of chords is at its limit
            share = max(deviation / self.radius, 1e-12)
            chords = math.ceil(abs(self.sweep) / (2.0 * math.acos(1.0 - share)))
        chords = min(max(chords, math.ceil(abs(self.sweep) / 2.0), 1), _MOST_CHORDS)
        return self._with_exact_ends(self.points(np.linspace(0.0, 1.0, chords + 1)))

    def nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distances of points from the arc and the points next to them."""
        offsets = points - np.array(self.centre)
        angles = np.arctan2(offsets[:, 1], offsets[:, 0])
        sign = 1.0 if self.sweep >= 0.0 else -1.0
        turn = np.mod(sign * (angles - self.start_angle), 2.0 * np.pi)
        share = np.where(turn <= abs(self.sweep), turn / max(abs(self.sweep), 1e-300), 0.0)
        feet = self.points(share)
        distances = np.hypot(*(points - feet).T)
        for end in (self.start, self.end):
            gap = np.hypot(*(points - np.array(end)).T)
            nearer = gap < distances
            distances = np.where(nearer, gap, distances)
            feet = np.where(nearer[:, None], np.array(end), feet)
        return distances, feet

    def direction(self, at_end: bool) -> Point:
        """Return the direction of motion at the start or at the end, a unit vector."""
        angle = self.start_angle + (self.sweep if at_end else 0.0)
        sign = math.copysign(1.0, self.sweep)
        return -sign * math.sin(angle), sign * math.cos(angle)


@dataclasses.dataclass(frozen=True, eq=False)
class PolylineArc(Arc):
    """Straight segments between points that lie on a curve, where it has no closed form.

    Attributes
    ----------
    corners
        Shape (n, 2), n at least 2; the last repeats the first where the arc is closed.
    """

    corners: FloatArray

    @property
    def start(self) -> Point:  # type: ignore[override]
        """First point."""
        return float(self.corners[0, 0]), float(self.corners[0, 1])

    @property
    def end(self) -> Point:  # type: ignore[override]
        """Last point."""
        return float(self.corners[-1, 0]), float(self.corners[-1, 1])

    def points(self, shares: FloatArray) -> FloatArray:
        """Return points of the segments; every segment has the same share."""
        places = np.linspace(0.0, 1.0, len(self.corners))
        return np.column_stack([np.interp(shares, places, column) for column in self.corners.T])

    def swept_area(self) -> float:
        """Return ½ Σ cross(P_k, P_k+1)."""
        x, y = self.corners.T
        return 0.5 * math.fsum(x[:-1] * y[1:] - x[1:] * y[:-1])

    def length(self) -> float:
        """Return the sum of the segments."""
        return math.fsum(np.hypot(*np.diff(self.corners, axis=0).T))

    def reversed(self) -> PolylineArc:
        """Return the arc run through the other way."""
        return PolylineArc(self.corners[::-1])

    def scaled(self, factor: float) -> PolylineArc:
        """Return the arc with all lengths times a positive factor."""
        return PolylineArc(factor * self.corners)

    def mirrored(self, x: bool, y: bool) -> PolylineArc:
        """Return the image under x → -x and (or) y → -y."""
        return PolylineArc(self.corners * np.array([-1.0 if x else 1.0, -1.0 if y else 1.0]))

    def polyline(self, deviation: float) -> FloatArray:  # noqa: ARG002
        """Return the corners: all that is known of the curve."""
        return self.corners.copy()

    def nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distances of points from the segments and the points next to them."""
        starts, along = self.corners[:-1], np.diff(self.corners, axis=0)
        squares = np.maximum((along**2).sum(axis=1), 1e-300)
        shares = ((points[:, None] - starts) * along).sum(axis=2) / squares
        feet = starts + np.clip(shares, 0.0, 1.0)[:, :, None] * along
        gaps = np.hypot(*(points[:, None] - feet).transpose(2, 0, 1))
        best = np.argmin(gaps, axis=1)
        rows = np.arange(len(points))
        return gaps[rows, best], feet[rows, best]


@dataclasses.dataclass(frozen=True, slots=True)
class NamedArc:
    """An arc with what it is: which curve, and what is special there.

    Attributes
    ----------
    name
        Name of the curve in plain letters, ``"C_1o"``.
    symbol
        The field's notation as mathtext, ``"$C_{1o}$"``.
    kind
        What happens on it, ``"serial"``, ``"parallel, folded"`` or ``LIMIT``.
    arc
        The arc itself.
    ends
        What there is at its start and at its end, such as ``TANGENCY``.
    sides
        For every mode pair whose workspace borders on the arc, the side that it lies on.
    """

    name: str
    symbol: str
    kind: str
    arc: Arc
    ends: tuple[str, str] = (INTERSECTION, INTERSECTION)
    sides: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def scaled(self, factor: float) -> NamedArc:
        """Return the same with all lengths times a positive factor."""
        return dataclasses.replace(self, arc=self.arc.scaled(factor))


@dataclasses.dataclass(frozen=True, slots=True)
class Loop:
    """A closed outline: arcs, each of which starts where the one before ends.

    Attributes
    ----------
    arcs
        The arcs in order, the region on their left.
    """

    arcs: tuple[NamedArc, ...]

    @property
    def area(self) -> float:
        """Area enclosed by Green's theorem: positive if counter-clockwise."""
        return math.fsum(each.arc.swept_area() for each in self.arcs)

    def polyline(self, deviation: float) -> FloatArray:
        """Return a closed polygon, shape (n, 2), first point not repeated, near the outline.

        Parameters
        ----------
        deviation
            Largest distance of a chord from the outline.
        """
        return np.concatenate([each.arc.polyline(deviation)[:-1] for each in self.arcs])

    def scaled(self, factor: float) -> Loop:
        """Return the same with all lengths times a positive factor."""
        return Loop(tuple(each.scaled(factor) for each in self.arcs))


@dataclasses.dataclass(frozen=True, slots=True)
class Region:
    """A connected region of the plane: its outline and its holes.

    Attributes
    ----------
    outline
        The outer boundary, counter-clockwise.
    holes
        The inner boundaries, clockwise.
    """

    outline: Loop
    holes: tuple[Loop, ...] = ()

    @property
    def loops(self) -> tuple[Loop, ...]:
        """All boundaries, the outline first."""
        return (self.outline, *self.holes)

    @property
    def arcs(self) -> tuple[NamedArc, ...]:
        """All boundary arcs, those of the outline first."""
        return tuple(each for loop in self.loops for each in loop.arcs)

    @property
    def area(self) -> float:
        """Area by Green's theorem: that of the outline less those of the holes."""
        return math.fsum(loop.area for loop in self.loops)

    def polygons(self, deviation: float) -> tuple[FloatArray, ...]:
        """Return one closed polygon for each boundary; see :meth:`Loop.polyline`."""
        return tuple(loop.polyline(deviation) for loop in self.loops)

    def scaled(self, factor: float) -> Region:
        """Return the same with all lengths times a positive factor."""
        return Region(
            self.outline.scaled(factor), tuple(hole.scaled(factor) for hole in self.holes)
        )

    def boundary_distance(self, points: FloatArray) -> tuple[FloatArray, list[NamedArc]]:
        """Return how far points are from the boundary, and the arc next to each.

        Parameters
        ----------
        points
            Shape (n, 2); on either side of the boundary.
        """
        gaps = np.stack([each.arc.nearest(points)[0] for each in self.arcs])
        nearest = np.argmin(gaps, axis=0)
        return gaps[nearest, np.arange(len(points))], [self.arcs[place] for place in nearest]


def mirror(point: Point, x: bool, y: bool) -> Point:
    """Return the image of a point under x → -x and (or) y → -y."""
    return (-point[0] if x else point[0]), (-point[1] if y else point[1])


def region_of(loops: Sequence[Loop]) -> Region:
    """Return the one connected region that closed boundaries enclose.

    Parameters
    ----------
    loops
        One loop that runs counter-clockwise, around all others, which run clockwise.

    Raises
    ------
    InputError
        If not exactly one loop runs counter-clockwise.
    """
    outer = [loop for loop in loops if loop.area > 0.0]
    if len(outer) != 1:
        raise InputError("loops", len(outer), "exactly one that runs counter-clockwise")
    return Region(outer[0], tuple(loop for loop in loops if loop is not outer[0]))


def meeting(before: Arc, after: Arc) -> str:
    """Return what happens where one arc goes over into another."""
    ax, ay = before.direction(at_end=True)
    bx, by = after.direction(at_end=False)
    if abs(ax * by - ay * bx) > _SMOOTH:
        return INTERSECTION
    return TANGENCY if ax * bx + ay * by > 0.0 else CUSP


def closed_loop(arcs: Sequence[NamedArc]) -> Loop:
    """Return a loop of arcs in order, each told what there is at its ends."""
    if len(arcs) == 1 and arcs[0].ends == (CLOSED, CLOSED):
        return Loop(tuple(arcs))
    kinds = [meeting(one.arc, two.arc) for one, two in zip(arcs, [*arcs[1:], arcs[0]], strict=True)]
    return Loop(
        tuple(
            dataclasses.replace(each, ends=(kinds[place - 1], kinds[place]))
            for place, each in enumerate(arcs)
        )
    )


def _times(point: Point, factor: float) -> Point:
    return factor * point[0], factor * point[1]
