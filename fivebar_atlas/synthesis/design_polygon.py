"""The outline of a design space in its chart: a convex polygon with named sides."""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.triangulated_regions import outline_of_triangles

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

#: Up to this distance in the chart a point lies on a side.
ON_SIDE = 1e-10

# Below this difference parameters count as equal when a side is named.
_SAME = 1e-9


@dataclasses.dataclass(frozen=True, slots=True)
class DesignPolygon:
    """A convex polygon in the chart.

    Attributes
    ----------
    corners
        Its corners, counter-clockwise, shape (k, 2); side i runs from corner i to i + 1.
    normals
        Inward unit normals of the sides, shape (k, 2).
    offsets
        A point p is inside where ``normals @ p >= offsets``, shape (k,).
    """

    corners: FloatArray
    normals: FloatArray
    offsets: FloatArray

    @classmethod
    def from_corners(cls, corners: FloatArray) -> Self:
        """Return the polygon with these corners, in either direction, shape (k, 2)."""
        x, y = corners.T
        if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) < 0.0:
            corners = corners[::-1]
        along = np.roll(corners, -1, axis=0) - corners
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        normals = np.column_stack([-along[:, 1], along[:, 0]])
        return cls(corners, normals, np.sum(normals * corners, axis=1))

    @classmethod
    def of_space(cls, mechanism: Mechanism, space: str) -> Self:
        """Return the outline of a design space."""
        return cls.from_corners(mechanism.chart(space).outline)

    @classmethod
    def of_lattice(cls, points: FloatArray, triangles: IntArray) -> Self:
        """Return the outline of a triangulated lattice, which is convex."""
        (loop,) = outline_of_triangles(points, triangles, np.ones(len(triangles), dtype=np.bool_))
        return cls.from_corners(loop)

    def moved_inward(self, distances: FloatArray) -> Self:
        """Return the polygon with sides moved inward, by a small distance for each."""
        offsets = self.offsets + distances
        before = np.roll(self.normals, 1, axis=0), np.roll(offsets, 1)
        matrices = np.stack([before[0], self.normals], axis=1)
        bounds = np.stack([before[1], offsets], axis=1)[..., np.newaxis]
        corners = np.linalg.solve(matrices, bounds)[..., 0]
        return self.from_corners(np.asarray(corners, dtype=np.float64))

    @property
    def area(self) -> float:
        """Its area in the chart."""
        x, y = self.corners.T
        return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2.0)

    def distances(self, points: FloatArray) -> FloatArray:
        """Return the distances from the sides, positive inside, shape (n, k)."""
        return points @ self.normals.T - self.offsets

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which points, shape (n, 2), lie in the polygon or on a side of it."""
        return np.asarray(np.all(self.distances(points) >= -ON_SIDE, axis=1))

    def clip(self, points: FloatArray) -> FloatArray:
        """Return points, shape (n, 2), those outside moved onto the polygon.

        A point within rounding of a side comes to lie on it.
        """
        moved = points.copy()
        for _ in range(2):
            for normal, offset in zip(self.normals, self.offsets, strict=True):
                distance = moved @ normal - offset
                short = distance < ON_SIDE
                moved[short] -= distance[short, np.newaxis] * normal
        outside = ~self.contains(moved)
        if outside.any():
            # Beyond a sharp corner, pushing from side to side ends there only in the limit.
            gaps = moved[outside, np.newaxis, :] - self.corners
            moved[outside] = self.corners[np.argmin(np.sum(gaps**2, axis=2), axis=1)]
        return moved

    def feet(self, point: FloatArray, reach: float) -> FloatArray:
        """Return the feet of a point on the sides within reach, and corners, shape (n, 2)."""
        distance = self.distances(point[np.newaxis])[0]
        near = np.abs(distance) <= reach
        feet = point - distance[near, np.newaxis] * self.normals[near]
        close = np.linalg.norm(self.corners - point, axis=1) <= reach
        return np.vstack([feet, self.corners[close]])

    def directions(self, point: FloatArray, step: float) -> tuple[FloatArray, BoolArray]:
        """Return two directions for differences that stay in the polygon.

        Parameters
        ----------
        point
            A point in the polygon, shape (2,).
        step
            Length of a step.

        Returns
        -------
        directions : ndarray
            Two unit vectors at an angle of at least 25 degrees, shape (2, 2).
        central : ndarray
            For each whether a step back stays in the polygon, too; otherwise two steps
            forward do.
        """
        sides = np.column_stack([self.normals[:, 1], -self.normals[:, 0]])
        near = np.abs(self.distances(point[np.newaxis])[0]) <= 3.0 * step
        angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
        rose = np.column_stack([np.cos(angles), np.sin(angles)])
        tried = np.vstack([sides[near], -sides[near], rose])
        forward, further, back = (
            self.contains(point + length * step * tried) for length in (1.0, 2.0, -1.0)
        )
        chosen: list[tuple[FloatArray, bool]] = []
        for is_central, usable in ((True, forward & back), (False, forward & further)):
            for direction in tried[usable]:
                across = [
                    abs(direction[0] * other[1] - direction[1] * other[0]) for other, _ in chosen
                ]
                if len(chosen) < 2 and all(size >= 0.42 for size in across):
                    chosen.append((direction, is_central))
        if len(chosen) < 2:  # a polygon hardly larger than the step
            return np.eye(2), np.array([True, True])
        return np.array([each for each, _ in chosen]), np.array([each for _, each in chosen])

    def names(self, mechanism: Mechanism, space: str) -> tuple[str, ...]:
        """Return what each side says of the parameters of a space, such as ``"r3 = 0"``."""
        ends = mechanism.unproject(self.corners, space)
        # A parameter that is fixed in the whole space says nothing of its sides.
        free = np.flatnonzero(np.ptp(ends, axis=0) > _SAME)
        names = [mechanism.parameters[column].name for column in free]
        ends = ends[:, free]
        return tuple(
            _side_name(names, *pair) for pair in zip(ends, np.roll(ends, -1, axis=0), strict=True)
        )


def _side_name(names: list[str], start: FloatArray, end: FloatArray) -> str:
    """Return the one relation between parameters that holds along a side."""
    for name, at_start, at_end in zip(names, start, end, strict=True):
        if abs(at_start - at_end) <= _SAME:
            return f"{name} = {round(float(at_start), 9) + 0.0:g}"
    for first in range(len(names)):
        for second in range(first + 1, len(names)):
            gaps = (start[first] - start[second], end[first] - end[second])
            if max(abs(gap) for gap in gaps) <= _SAME:
                return f"{names[first]} = {names[second]}"
    return "border of the design space"
