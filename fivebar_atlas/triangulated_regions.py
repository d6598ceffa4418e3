"""Regions of a triangulated plane, exact for values that are linear on every triangle.

Three kinds of region are outlined: where several such functions are all non-negative, a
set of whole triangles, and the cells that belong to single vertices. Every outline comes
from the same step: the polygons of the region are listed with named corners, sides that
two polygons share cancel, and what is left is chained to closed loops. Corners on a side
of a triangle are computed from that side alone, so neighbours agree to the last bit.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterable

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

#: Below this fraction of its largest value a margin counts as zero.
_ROUND_OFF = 1e-13


@dataclasses.dataclass(frozen=True, slots=True)
class Region:
    """A region of a triangulated plane.

    Attributes
    ----------
    loops
        Closed outlines, each of shape (k, 2) without repeating the first point; outer
        ones run counter-clockwise, holes clockwise.
    area
        Its area in the plane.
    corner_triangles
        Triangle of each corner of the pieces the region consists of, shape (c,).
    corner_weights
        Barycentric weights of those corners, shape (c, 3). The extremes of any function
        that is linear on the triangles are taken at corners.
    """

    loops: tuple[FloatArray, ...]
    area: float
    corner_triangles: IntArray
    corner_weights: FloatArray

    @property
    def is_empty(self) -> bool:
        """Whether the region has no interior."""
        return not self.loops

    def extent(self, triangles: IntArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the least and the greatest value in the region.

        Parameters
        ----------
        triangles
            The triangulation, vertex indices of shape (m, 3).
        values
            Values at the vertices, shape (n,) or (n, p).

        Returns
        -------
        least, greatest
            Each of shape () or (p,); NaN where the region is empty.
        """
        if self.is_empty:
            nothing = np.full(values.shape[1:], np.nan)
            return nothing, nothing.copy()
        at_vertices = values[triangles[self.corner_triangles]]
        at_corners = np.einsum("cv,cv...->c...", self.corner_weights, at_vertices)
        return at_corners.min(axis=0), at_corners.max(axis=0)


def region_where(points: FloatArray, triangles: IntArray, margins: FloatArray) -> Region:
    """Return the region where all functions are non-negative.

    Each function is given at the vertices and is linear on every triangle, so the region
    is the union of the triangles, each clipped by one half-plane for every function.

    Parameters
    ----------
    points
        Vertices, shape (n, 2).
    triangles
        Counter-clockwise or clockwise vertex indices, shape (m, 3).
    margins
        Functions at the vertices, shape (functions, n). A triangle with a NaN at one of
        its vertices does not belong to the region.

    Returns
    -------
    Region
        The region; empty if it has no interior.
    """
    triangles = _counter_clockwise(points, triangles)
    # One scale for the whole plane: neighbours must agree on what counts as zero.
    scales = np.max(np.abs(margins), axis=1, initial=0.0, where=np.isfinite(margins))
    tolerances = _ROUND_OFF * scales
    margins = np.where(np.abs(margins) <= tolerances[:, np.newaxis], 0.0, margins)
    at_vertices = margins[:, triangles]  # (functions, m, 3)
    defined = ~np.isnan(at_vertices).any(axis=(0, 2))
    inside = defined & (at_vertices >= 0.0).all(axis=(0, 2))
    outside = ~defined | (at_vertices <= 0.0).all(axis=2).any(axis=0)
    # A function that is zero on a whole triangle excludes nothing of it.
    outside &= ~inside

    names = _Names(points)
    whole = np.flatnonzero(inside)
    cycles = [triangles[whole]]
    corner_triangles = [np.repeat(whole, 3)]
    corner_weights = [np.tile(np.eye(3), (len(whole), 1))]
    area = float(_signed_areas(points, triangles[whole]).sum())
    for index in np.flatnonzero(~inside & ~outside):
        corners = _clip(triangles[index], at_vertices[:, index, :], tolerances, int(index))
        weights = np.array([corner.weights for corner in corners]).reshape(-1, 3)
        polygon = weights @ points[triangles[index]]
        piece = _polygon_area(polygon)
        if len(corners) < 3 or piece <= 0.0:
            continue
        area += piece
        cycle = names.numbers([corner.name for corner in corners], polygon)
        cycles.append(cycle[np.newaxis, :])
        corner_triangles.append(np.full(len(corners), index))
        corner_weights.append(weights)
    return Region(
        loops=_outline(names.coordinates(), cycles),
        area=area,
        corner_triangles=np.concatenate(corner_triangles),
        corner_weights=np.concatenate(corner_weights),
    )


def outline_of_triangles(
    points: FloatArray, triangles: IntArray, chosen: BoolArray
) -> tuple[FloatArray, ...]:
    """Return the outline of a set of whole triangles as closed loops.

    Parameters
    ----------
    points
        Vertices, shape (n, 2).
    triangles
        Vertex indices, shape (m, 3).
    chosen
        Which triangles belong to the set, shape (m,).

    Returns
    -------
    tuple of ndarray
        Closed loops, each of shape (k, 2); none if nothing is chosen.
    """
    oriented = _counter_clockwise(points, triangles[chosen])
    return _outline(points, [oriented])


def outline_of_cells(
    points: FloatArray, triangles: IntArray, chosen: BoolArray
) -> tuple[FloatArray, ...]:
    """Return the outline of the cells of a set of vertices as closed loops.

    The cell of a vertex is a third of every triangle around it, bounded by the lines from
    the middles of the sides to the centroid. It shows a value that belongs to one design
    and must not be interpolated.

    Parameters
    ----------
    points
        Vertices, shape (n, 2).
    triangles
        Vertex indices, shape (m, 3).
    chosen
        Which vertices belong to the set, shape (n,).

    Returns
    -------
    tuple of ndarray
        Closed loops, each of shape (k, 2); none if nothing is chosen.
    """
    triangles = _counter_clockwise(points, triangles)
    triangles = triangles[chosen[triangles].any(axis=1)]
    sides, side_of = _sides(triangles)
    middles = points[sides].mean(axis=1)
    centroids = points[triangles].mean(axis=1)
    coordinates = np.concatenate([points, middles, centroids])
    first_middle = len(points)
    first_centroid = first_middle + len(middles)
    centroid = first_centroid + np.arange(len(triangles))
    cycles = []
    for corner in range(3):
        vertex = triangles[:, corner]
        after = first_middle + side_of[:, corner]
        before = first_middle + side_of[:, (corner + 2) % 3]
        thirds = np.stack([vertex, after, centroid, before], axis=1)
        cycles.append(thirds[chosen[vertex]])
    return _outline(coordinates, cycles)


@dataclasses.dataclass(frozen=True, slots=True)
class _Corner:
    """A corner of a clipped triangle: who it is, where, and on which sides it lies."""

    name: Hashable
    weights: FloatArray
    margins: FloatArray
    sides: frozenset[int]


class _Names:
    """Numbers for corners: vertices keep their index, others are counted on."""

    def __init__(self, points: FloatArray) -> None:
        self._points = points
        self._numbers: dict[Hashable, int] = {}
        self._added: list[FloatArray] = []

    def numbers(self, names: Iterable[Hashable], places: FloatArray) -> IntArray:
        numbers = []
        for name, place in zip(names, places, strict=True):
            if isinstance(name, int):
                numbers.append(name)
                continue
            if name not in self._numbers:
                self._numbers[name] = len(self._points) + len(self._added)
                self._added.append(place)
            numbers.append(self._numbers[name])
        return np.array(numbers, dtype=np.int64)

    def coordinates(self) -> FloatArray:
        return np.concatenate([self._points, np.array(self._added).reshape(-1, 2)])


def _clip(
    triangle: IntArray, margins: FloatArray, tolerances: FloatArray, index: int
) -> list[_Corner]:
    """Clip one triangle by every half-plane, after Sutherland and Hodgman.

    ``margins`` has shape (functions, 3). Side s runs from vertex s to vertex s + 1.
    """
    corners = [
        _Corner(
            name=int(triangle[vertex]),
            weights=np.eye(3)[vertex],
            margins=margins[:, vertex],
            sides=frozenset({vertex, (vertex + 2) % 3}),
        )
        for vertex in range(3)
    ]
    for function in range(len(margins)):
        kept: list[_Corner] = []
        for position, corner in enumerate(corners):
            following = corners[(position + 1) % len(corners)]
            here = _sign(corner.margins[function], tolerances[function])
            there = _sign(following.margins[function], tolerances[function])
            if here >= 0:
                kept.append(corner)
            if here * there < 0:
                kept.append(_cut(triangle, margins, index, function, corner, following))
        corners = kept
    return corners


def _sign(margin: float, tolerance: float) -> int:
    if abs(margin) <= tolerance:
        return 0
    return 1 if margin > 0.0 else -1


def _cut(
    triangle: IntArray,
    margins: FloatArray,
    index: int,
    function: int,
    start: _Corner,
    end: _Corner,
) -> _Corner:
    """Return the corner where a function changes sign between two corners."""
    shared = start.sides & end.sides
    if shared:
        # On a side of the triangle: from its two vertices, in the order of their indices,
        # so that the neighbouring triangle finds the same point under the same name.
        (side,) = shared
        first, second = side, (side + 1) % 3
        if triangle[first] > triangle[second]:
            first, second = second, first
        share = margins[function, first] / (margins[function, first] - margins[function, second])
        weights = np.zeros(3)
        weights[first], weights[second] = 1.0 - share, share
        at_cut = margins[:, first] + share * (margins[:, second] - margins[:, first])
        name: Hashable = (int(triangle[first]), int(triangle[second]), function)
    else:
        share = start.margins[function] / (start.margins[function] - end.margins[function])
        weights = start.weights + share * (end.weights - start.weights)
        at_cut = start.margins + share * (end.margins - start.margins)
        name = (index, start.name, end.name, function)
    at_cut[function] = 0.0
    return _Corner(name, weights, at_cut, shared)


def _signed_areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    first, second, third = (points[triangles[:, corner]] for corner in range(3))
    one, other = second - first, third - first
    areas: FloatArray = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return areas


def _polygon_area(polygon: FloatArray) -> float:
    x, y = polygon[:, 0], polygon[:, 1]
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _counter_clockwise(points: FloatArray, triangles: IntArray) -> IntArray:
    clockwise = _signed_areas(points, triangles) < 0.0
    return np.where(clockwise[:, np.newaxis], triangles[:, ::-1], triangles)


def _sides(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Return all sides, shape (s, 2), and the side after each corner, shape (m, 3)."""
    following = np.roll(triangles, -1, axis=1)
    low, high = np.minimum(triangles, following), np.maximum(triangles, following)
    base = int(triangles.max(initial=0)) + 1
    keys, inverse = np.unique((low * base + high).ravel(), return_inverse=True)
    return np.column_stack([keys // base, keys % base]), inverse.reshape(triangles.shape)


def _outline(coordinates: FloatArray, cycles: Iterable[IntArray]) -> tuple[FloatArray, ...]:
    """Return the loops that remain when sides run through in both directions cancel.

    ``cycles`` holds arrays of shape (polygons, corners) of indices into ``coordinates``.
    """
    starts = np.concatenate([cycle.ravel() for cycle in cycles])
    ends = np.concatenate([np.roll(cycle, -1, axis=1).ravel() for cycle in cycles])
    if len(starts) == 0:
        return ()
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    _, inverse = np.unique(low * len(coordinates) + high, return_inverse=True)
    balance = np.bincount(inverse, weights=np.where(starts < ends, 1.0, -1.0))
    remaining = balance[inverse] != 0.0
    loops = _chain(starts[remaining].tolist(), ends[remaining].tolist())
    return tuple(_without_straight_corners(coordinates[loop]) for loop in loops)


def _chain(starts: list[int], ends: list[int]) -> list[list[int]]:
    """Join directed sides to closed loops; every corner has as many in as out."""
    leaving: dict[int, list[int]] = {}
    for start, end in zip(starts, ends, strict=True):
        leaving.setdefault(start, []).append(end)
    loops = []
    for first in starts:
        while leaving[first]:
            loop = [first]
            corner = leaving[first].pop()
            while corner != first:
                loop.append(corner)
                corner = leaving[corner].pop()
            loops.append(loop)
    return loops


def _without_straight_corners(loop: FloatArray) -> FloatArray:
    """Drop the corners at which a loop goes straight on."""
    before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    lengths = np.hypot(*before.T) * np.hypot(*after.T)
    straight = (np.abs(turn) <= 1e-10 * lengths) & ((before * after).sum(axis=1) > 0.0)
    corners: FloatArray = loop[~straight]
    return corners
