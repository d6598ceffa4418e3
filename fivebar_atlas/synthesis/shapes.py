"""Shapes of practical workspaces: rectangles, circles and polygons, with a clearance.

Every shape is a polygon and all points within a distance of it: a circle is that about one
corner, a clearance makes the distance larger. Lengths are in any one unit.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import FileError, FileUsageError, InputError
from fivebar_atlas.planar_geometry import FloatArray, Point
from fivebar_atlas.point_files import read_points

BoolArray = npt.NDArray[np.bool_]

#: Range of lengths; areas, which go with their squares, stay finite.
LENGTH_RANGE = (1e-100, 1e100)

_MOST_CORNERS = 10_000
# How many times as long as wide the box around a shape may be.
_MOST_SLENDER = 1e6
# How well-known text begins, and no heading of a column does.
_WELL_KNOWN = re.compile(r"[A-Za-z]{4,}\s*(?:ZM?|M)?\s*\(\s*[-+.(\d]")
# Products of points and edges that are formed at once.
_BLOCK = 2_000_000
# Samples of the shortest piece of a boundary.
_LEAST_SAMPLES = 4


@dataclasses.dataclass(frozen=True, eq=False)
class Shape:
    """A polygon and all points within a distance of it, about a centre.

    Attributes
    ----------
    name
        What it is, in words: ``"rectangle 300 x 200"``.
    corners
        Corners of the polygon, counter-clockwise and relative to the centre, shape (n, 2);
        one corner for a circle.
    radius
        The distance: the radius of a circle, the clearance, or their sum.
    clearance
        Which part of that is clearance.
    centre
        Centre in the coordinates that a polygon was given in; (0, 0) for other shapes.
    """

    name: str
    corners: FloatArray
    radius: float
    clearance: float = 0.0
    centre: Point = (0.0, 0.0)

    @classmethod
    def rectangle(cls, width: float, height: float, clearance: float = 0.0) -> Shape:
        """Return a rectangle with sides parallel to the axes, about its centre.

        Raises
        ------
        InputError
            If a side or the clearance is out of the range of lengths, or the shape too slender.
        """
        for side in (width, height):
            _check_length("rectangle", side)
        _check_clearance(clearance)
        signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        corners = 0.5 * signs * (width, height)
        _check_box("rectangle", width + 2.0 * clearance, height + 2.0 * clearance)
        return cls(f"rectangle {width:g} x {height:g}", corners, clearance, clearance)

    @classmethod
    def circle(cls, diameter: float, clearance: float = 0.0) -> Shape:
        """Return a circle about its centre.

        Raises
        ------
        InputError
            If the diameter or the clearance is out of the range of lengths.
        """
        _check_length("circle", diameter)
        _check_clearance(clearance)
        radius = 0.5 * diameter + clearance
        return cls(f"circle of diameter {diameter:g}", np.zeros((1, 2)), radius, clearance)

    @classmethod
    def polygon(cls, corners: npt.ArrayLike, clearance: float = 0.0) -> Shape:
        """Return a simple polygon about its centroid.

        Parameters
        ----------
        corners
            Corners in order, either way round, shape (n, 2), the first one repeated or not.
        clearance
            Distance around it that belongs to the shape.

        Raises
        ------
        InputError
            If there are fewer than three corners or more than 10 000, one is not finite, the
            polygon meets itself or has no area, or is too slender, or not in the range of
            lengths; if the clearance is not.
        """
        import shapely

        _check_clearance(clearance)
        points = np.array(corners, dtype=np.float64)
        if points.ndim != 2 or points.shape[1:] != (2,):
            raise InputError("polygon", points.shape, "corners of shape (n, 2)")
        if not np.all(np.isfinite(points)):
            raise InputError("polygon", "a corner that is not finite", "finite coordinates")
        least, greatest = LENGTH_RANGE
        largest = float(np.max(np.abs(points), initial=0.0))
        if largest > greatest:
            raise InputError("polygon", largest, f"coordinates up to {greatest:g}")
        points = points[np.any(points != np.roll(points, 1, axis=0), axis=1)]
        if not 3 <= len(points) <= _MOST_CORNERS:
            allowed = f"3 to {_MOST_CORNERS} different corners"
            raise InputError("polygon", f"{len(points)} corners", allowed)
        width, height = (float(side) for side in np.ptp(points, axis=0))
        if max(width, height) < least:
            raise InputError("polygon", max(width, height), f"a width of at least {least:g}")
        if _is_straight(points):
            raise InputError("polygon", "corners on one line", "a polygon with an area above 0")
        outline = shapely.Polygon(points)
        if not outline.is_valid:
            reason = str(shapely.is_valid_reason(outline))
            raise InputError("polygon", reason, "a polygon that does not meet itself")
        if not outline.area > 0.0:
            raise InputError("polygon", outline.area, "a polygon with an area above 0")
        _check_box("polygon", width + 2.0 * clearance, height + 2.0 * clearance)
        if not outline.exterior.is_ccw:
            points = points[::-1]
        middle = np.array([outline.centroid.x, outline.centroid.y])
        centre = float(middle[0]), float(middle[1])
        name = f"polygon of {len(points)} corners"
        return cls(name, points - middle, clearance, clearance, centre)

    def name_in(self, unit: str) -> str:
        """Return what it is, its lengths in a unit; that of a polygon says none."""
        return self.name if self.name.startswith("polygon") else f"{self.name} {unit}"

    @property
    def pieces(self) -> int:
        """Number of smooth pieces of the boundary, k at u from k to k + 1."""
        return len(self._pieces[2])

    @functools.cached_property
    def _pieces(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Start, run, angle of the normal and its turn, for every piece of the boundary.

        The sides of the polygon moved outwards, and arcs about the corners that point
        outwards. Next to a corner that points inwards moved sides go on beyond where they
        meet; there they run within the shape, so that nothing is asked too much of them.
        """
        if len(self.corners) == 1:
            turns = np.full(4, 0.5 * math.pi)
            return np.zeros((4, 2)) + self.corners, np.zeros((4, 2)), np.arange(4) * turns, turns
        along = np.roll(self.corners, -1, axis=0) - self.corners
        normals = np.arctan2(-along[:, 0], along[:, 1])
        sides = (self.corners, along, normals, np.zeros(len(along)))
        turns = np.remainder(normals - np.roll(normals, 1) + math.pi, 2.0 * math.pi) - math.pi
        outward = turns > 0.0
        if self.radius == 0.0 or not np.any(outward):
            return sides
        arcs = (
            self.corners[outward],
            np.zeros((int(outward.sum()), 2)),
            np.roll(normals, 1)[outward],
            turns[outward],
        )
        # each arc before the side that starts in its corner
        places = np.concatenate([np.flatnonzero(outward) - 0.5, np.arange(len(along))])
        order = np.argsort(places, kind="stable")
        joined = [np.concatenate([arc, side])[order] for arc, side in zip(arcs, sides, strict=True)]
        return joined[0], joined[1], joined[2], joined[3]

    def boundary(self, u: FloatArray) -> FloatArray:
        """Return points of the boundary, shape (n, 2), at u from 0 to ``pieces``."""
        starts, runs, angles, turns = self._pieces
        u = np.mod(u, self.pieces)
        piece = np.minimum(u.astype(np.int64), self.pieces - 1)
        share = u - piece
        angle = angles[piece] + share * turns[piece]
        normal = np.column_stack([np.cos(angle), np.sin(angle)])
        return np.asarray(
            starts[piece] + share[:, None] * runs[piece] + self.radius * normal, dtype=np.float64
        )

    def boundary_samples(self, count: int) -> FloatArray:
        """Return about so many places u along the boundary, the ends of all pieces with them."""
        _, runs, _, turns = self._pieces
        lengths = np.hypot(*runs.T) + self.radius * np.abs(turns)
        counts = np.ceil(count * lengths / lengths.sum()).astype(np.int64)
        least = _LEAST_SAMPLES if self.pieces < count else 1
        return np.concatenate(
            [
                place + np.arange(number) / number
                for place, number in enumerate(np.maximum(counts, least))
            ]
        )

    @property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lower left and upper right corner of the box around it, relative to the centre."""
        return self.corners.min(axis=0) - self.radius, self.corners.max(axis=0) + self.radius

    def interior_samples(self, count: int) -> FloatArray:
        """Return points of the shape on a grid of about so many over its box, shape (n, 2)."""
        lower, upper = self.extent
        width, height = upper - lower
        step = math.sqrt(width * height / count)
        lines = [
            low + size * (np.arange(number) + 0.5) / number
            for low, size in ((lower[0], width), (lower[1], height))
            for number in (max(round(size / step), 1),)
        ]
        x, y = np.meshgrid(*lines)
        points = np.column_stack([x.ravel(), y.ravel()])
        return points[self.contains(points)]

    def contains(self, points: FloatArray) -> BoolArray:
        """Tell which points, relative to the centre and of shape (n, 2), belong to it."""
        return self.gaps(points) <= 0.0

    def gaps(self, points: FloatArray) -> FloatArray:
        """Return how far points, relative to the centre, are outside; 0 or less inside."""
        block = max(_BLOCK // len(self.corners), 1)
        parts = [self._gaps(points[at : at + block]) for at in range(0, len(points), block)]
        return np.concatenate(parts) if parts else np.empty(0)

    def _gaps(self, points: FloatArray) -> FloatArray:
        """Return the distances of points from the polygon, 0 inside, less the radius."""
        starts = self.corners
        if len(starts) == 1:
            return np.asarray(np.hypot(*(points - starts[0]).T) - self.radius)
        along = np.roll(starts, -1, axis=0) - starts
        x = points[:, :1] - starts[:, 0]
        y = points[:, 1:] - starts[:, 1]
        squares = along[:, 0] ** 2 + along[:, 1] ** 2
        share = np.clip((x * along[:, 0] + y * along[:, 1]) / squares, 0.0, 1.0)
        gaps = np.hypot(x - share * along[:, 0], y - share * along[:, 1]).min(axis=1)
        # rightward rays cross the boundary of the polygon an odd number of times from inside
        end_y = np.roll(y, -1, axis=1)
        turn = along[:, 0] * y - along[:, 1] * x
        crosses = np.where(y <= 0.0, (end_y > 0.0) & (turn < 0.0), (end_y <= 0.0) & (turn > 0.0))
        inside = crosses.sum(axis=1) % 2 == 1
        return np.asarray(np.where(inside, 0.0, gaps) - self.radius)


def read_polygon(path: str | os.PathLike[str], unit: str, clearance: float = 0.0) -> Shape:
    """Read a polygon from a table of its corners or from well-known text.

    Parameters
    ----------
    path
        Comma-separated text with columns x and y (or x_mm and y_mm with the unit), or
        well-known text of one ``POLYGON`` without holes.
    unit
        Unit that lengths are in.
    clearance
        Distance around it that belongs to the shape.

    Raises
    ------
    FileUsageError
        If there is no such file, or it is neither such text nor such a table.
    FileError
        If the file cannot be read.
    InputError
        If the corners make no simple polygon, or the clearance is negative.
    """
    _check_clearance(clearance)
    path = Path(path)
    text = _beginning(path)
    if _WELL_KNOWN.match(text):
        corners = _from_text(path)
    elif text.upper().startswith("POLYGON"):
        raise FileUsageError(path, "holds an empty polygon")
    else:
        corners = read_points(path, unit)
    try:
        return Shape.polygon(corners, clearance)
    except InputError as error:
        raise InputError(f"polygon of {path}", error.value, error.allowed) from None


def _beginning(path: Path) -> str:
    """Return the first line with anything in it, or nothing where the file cannot be read.

    What is wrong with such a file is said where it is read as a table.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return ""
    return next((line.strip() for line in text.splitlines() if line.strip()), "")


def _from_text(path: Path) -> FloatArray:
    """Return the corners of a polygon in well-known text."""
    import shapely

    try:
        outline = shapely.from_wkt(path.read_text(encoding="utf-8-sig").strip())
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from None
    except shapely.errors.GEOSException as error:
        reason = str(error).removeprefix("ParseException: ")
        raise FileUsageError(path, f"is not well-known text: {reason}") from None
    if not isinstance(outline, shapely.Polygon):
        raise FileUsageError(path, f"holds a {outline.geom_type}, not one POLYGON")
    if outline.is_empty:
        raise FileUsageError(path, "holds an empty polygon")
    if len(outline.interiors):
        raise FileUsageError(path, "holds a polygon with holes; a shape has none")
    corners: FloatArray = shapely.get_coordinates(outline.exterior)[:-1]
    return corners


def _is_straight(points: FloatArray) -> bool:
    """Return whether all points, shape (n, 2), lie on a line but for rounding."""
    from_first = points - points[0]
    lengths = np.hypot(*from_first.T)
    along = from_first[int(np.argmax(lengths))] / lengths.max()
    across = np.abs(from_first[:, 0] * along[1] - from_first[:, 1] * along[0])
    rounding = 8.0 * np.finfo(np.float64).eps * float(np.abs(points).max())
    return bool(across.max() <= rounding)


def _check_length(name: str, length: float) -> None:
    least, greatest = LENGTH_RANGE
    if not length > 0.0 or math.isinf(length):
        raise InputError(name, length, "a finite length above 0")
    if not least <= length <= greatest:
        raise InputError(name, length, f"lengths from {least:g} to {greatest:g}")


def _check_clearance(clearance: float) -> None:
    least, greatest = LENGTH_RANGE
    if not (math.isfinite(clearance) and clearance >= 0.0):
        raise InputError("clearance", clearance, "a finite length of 0 or more")
    if clearance and not least <= clearance <= greatest:
        raise InputError("clearance", clearance, f"0 or a length from {least:g} to {greatest:g}")


def _check_box(name: str, width: float, height: float) -> None:
    if max(width, height) > _MOST_SLENDER * min(width, height):
        allowed = f"a shape whose box is at most {_MOST_SLENDER:g} times as long as wide"
        raise InputError(name, f"{width:g} x {height:g}", allowed)
