"""Where text goes: boxes of text on paper, and places along lines that are still free.

All lengths are millimetres on paper. Placement depends on nothing but its input, so the
same data always gives the same figure.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import re
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.textpath import TextPath

from fivebar_atlas.figures.style import POINTS_PER_MM, styled

FloatArray = npt.NDArray[np.float64]

# Words, and what stands in parentheses as one of them.
_UNBROKEN = re.compile(r"(?:\([^)]*\)|[^ ])+")


@dataclasses.dataclass(frozen=True, slots=True)
class Box:
    """A rotated rectangle: centre, width, height and angle in degrees."""

    x: float
    y: float
    width: float
    height: float
    angle: float = 0.0

    def corners(self, gap: float = 0.0) -> FloatArray:
        """Return the four corners, shape (4, 2), of the box widened by ``gap``."""
        half_width, half_height = self.width / 2 + gap, self.height / 2 + gap
        turn = math.radians(self.angle)
        along = np.array([math.cos(turn), math.sin(turn)])
        across = np.array([-along[1], along[0]])
        signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        offsets: FloatArray = (
            signs[:, :1] * half_width * along + signs[:, 1:] * half_height * across
        )
        return np.array([self.x, self.y]) + offsets

    def overlaps(self, other: Box, gap: float = 0.0) -> bool:
        """Return whether two boxes come closer than ``gap``."""
        reach = math.hypot(self.width, self.height) + math.hypot(other.width, other.height)
        if math.hypot(self.x - other.x, self.y - other.y) > reach / 2 + 2 * gap:
            return False
        ours, theirs = self.corners(gap), other.corners()
        for box in (self, other):
            turn = math.radians(box.angle)
            for axis in ((math.cos(turn), math.sin(turn)), (-math.sin(turn), math.cos(turn))):
                one, two = ours @ np.array(axis), theirs @ np.array(axis)
                if one.max() <= two.min() or two.max() <= one.min():
                    return False
        return True

    def contains(self, points: FloatArray, gap: float = 0.0) -> npt.NDArray[np.bool_]:
        """Return which of ``points``, shape (k, 2), lie in the box widened by ``gap``."""
        turn = math.radians(self.angle)
        offset = points - np.array([self.x, self.y])
        along = offset @ np.array([math.cos(turn), math.sin(turn)])
        across = offset @ np.array([-math.sin(turn), math.cos(turn)])
        inside: npt.NDArray[np.bool_] = (np.abs(along) <= self.width / 2 + gap) & (
            np.abs(across) <= self.height / 2 + gap
        )
        return inside


@functools.lru_cache(maxsize=512)
def text_ink(text: str, size: float) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of the ink of one line of text, in millimetres.

    Parameters
    ----------
    text
        The text, mathtext between dollar signs.
    size
        Font size in points.

    Returns
    -------
    tuple of float
        Measured from where the text starts on its baseline.
    """
    with styled():
        # Many times larger, so that hinting and rounding do not matter.
        path = TextPath((0, 0), text, size=100.0, prop=FontProperties())
    left, bottom, right, top = (size / 100.0 / POINTS_PER_MM * part for part in _extents(path))
    return left, bottom, right, top


def _extents(path: Path) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of a path, as ``Path.get_extents`` but at once.

    Letters are made of lines and parabolas; an extremum of p(t) = (1-t)² a + 2 t (1-t) b + t² c
    inside lies at t = (a - b) / (a - 2 b + c).
    """
    codes = np.asarray(path.codes)
    corners = np.asarray(path.vertices, dtype=np.float64)
    if path.codes is None or (codes == Path.CURVE4).any():
        box = path.get_extents()
        return float(box.x0), float(box.y0), float(box.x1), float(box.y1)
    # the first of the two points of a parabola is off the curve, unlike that of all else
    curved = codes == Path.CURVE3
    first = np.flatnonzero(curved)[::2]
    is_end = codes != Path.CLOSEPOLY
    is_end[first] = False
    a, b, c = corners[first - 1], corners[first], corners[first + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.clip(np.nan_to_num((a - b) / (a - 2.0 * b + c)), 0.0, 1.0)
    turning = (1.0 - t) ** 2 * a + 2.0 * t * (1.0 - t) * b + t**2 * c
    points = np.concatenate([corners[is_end], turning])
    (left, bottom), (right, top) = points.min(axis=0), points.max(axis=0)
    return float(left), float(bottom), float(right), float(top)


def text_size(text: str, size: float) -> tuple[float, float]:
    """Return width and height in millimetres of the ink of one line of text."""
    left, bottom, right, top = text_ink(text, size)
    return right - left, top - bottom


def text_origin(text: str, size: float, box: Box) -> tuple[float, float]:
    """Return where a text has to start for its ink to be centred in a box."""
    left, bottom, right, top = text_ink(text, size)
    turn = math.radians(box.angle)
    along, across = (left + right) / 2.0, (bottom + top) / 2.0
    return (
        box.x - along * math.cos(turn) + across * math.sin(turn),
        box.y - along * math.sin(turn) - across * math.cos(turn),
    )


def wrapped(text: str, size: float, width: float) -> list[str]:
    """Break a text into as few lines as there must be, all about equally long.

    Parameters
    ----------
    text
        The text. It is broken at spaces, but not in parentheses and not at a no-break
        space, unless there is no other way.
    size
        Font size in points.
    width
        Greatest width of a line in millimetres.

    Returns
    -------
    list of str
        The lines, with ordinary spaces; none for an empty text.
    """
    # On a screen letters are moved to whole pixels, which makes a line a little longer.
    width *= 0.97
    whole = text.replace("\N{NO-BREAK SPACE}", " ")
    if not whole.strip():
        return []
    if text_size(whole, size)[0] <= width:
        return [whole]
    pieces = _UNBROKEN.findall(text)
    if any(text_size(piece, size)[0] > width for piece in pieces):
        pieces = text.split(" ")
    lines = _filled(pieces, size, width)
    narrower = width
    while len(lines) > 1 and narrower > 0.0:
        narrower -= 0.5
        balanced = _filled(pieces, size, narrower)
        if len(balanced) > len(lines) or any(text_size(x, size)[0] > width for x in balanced):
            break
        lines = balanced
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def _filled(pieces: Sequence[str], size: float, width: float) -> list[str]:
    lines: list[str] = []
    for piece in pieces:
        longer = f"{lines[-1]} {piece}" if lines else piece
        if lines and text_size(longer.replace("\N{NO-BREAK SPACE}", " "), size)[0] <= width:
            lines[-1] = longer
        else:
            lines.append(piece)
    return lines


@dataclasses.dataclass(frozen=True, slots=True)
class _Candidate:
    box: Box
    cost: float


def place_along_lines(
    lines: Sequence[FloatArray],
    width: float,
    height: float,
    outline: FloatArray,
    occupied: list[Box],
    avoid: FloatArray,
    shun: FloatArray,
    repeat: float = math.inf,
) -> list[Box]:
    """Find places for the label of one contour level on its lines.

    Parameters
    ----------
    lines
        The lines of the level, each of shape (k, 2).
    width, height
        Size of the label.
    outline
        Polygon the labels must stay in, shape (k, 2).
    occupied
        Boxes that must not be touched; the boxes found are added.
    avoid
        Points on other lines, shape (k, 2), that are better not covered.
    shun
        Points, shape (k, 2), that are covered only if there is no other place.
    repeat
        A line longer than this gets a second label, and so on.

    Returns
    -------
    list of Box
        At most one box for every ``repeat`` of each line; none where there is no room.
    """
    found: list[Box] = []
    for line in sorted(lines, key=_length, reverse=True):
        length = _length(line)
        if length < 1.6 * width:
            continue
        wanted = 1 + int(length / repeat)
        candidates = sorted(
            _candidates(line, width, height, outline, avoid, shun), key=lambda each: each.cost
        )
        for candidate in candidates:
            if wanted == 0:
                break
            if any(candidate.box.overlaps(box, gap=0.6) for box in occupied):
                continue
            near = min(length / 3, repeat / 2)
            if any(math.hypot(candidate.box.x - b.x, candidate.box.y - b.y) < near for b in found):
                continue
            found.append(candidate.box)
            occupied.append(candidate.box)
            wanted -= 1
    return found


def points_along(line: FloatArray, spacing: float = 0.5) -> FloatArray:
    """Return points on a line, shape (k, 2), no further apart than a spacing."""
    run = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    stations = np.linspace(0.0, run[-1], max(2, int(run[-1] / spacing) + 1))
    return np.column_stack([np.interp(stations, run, line[:, axis]) for axis in range(2)])


def _length(line: FloatArray) -> float:
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def _candidates(
    line: FloatArray,
    width: float,
    height: float,
    outline: FloatArray,
    avoid: FloatArray,
    shun: FloatArray,
) -> Iterable[_Candidate]:
    """Yield every place on a line where the label fits, with what speaks against it."""
    run = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    length = float(run[-1])
    for middle in np.arange(0.55 * width, length - 0.55 * width, 0.4):
        stations = np.array([middle - width / 2, middle, middle + width / 2])
        x = np.interp(stations, run, line[:, 0])
        y = np.interp(stations, run, line[:, 1])
        chord = math.hypot(x[2] - x[0], y[2] - y[0])
        if chord < 0.93 * width:
            continue
        angle = math.degrees(math.atan2(y[2] - y[0], x[2] - x[0]))
        if angle > 90.0 or angle <= -90.0:
            angle += 180.0 if angle <= -90.0 else -180.0
        box = Box(float(x.mean()), float(y.mean()), width, height, angle)
        room = _distance_inside(outline, box.corners())
        if room < 0.3:
            continue
        covered = int(box.contains(avoid, gap=0.25).sum())
        shunned = int(box.contains(shun, gap=0.7).sum())
        off_centre = abs(middle - length / 2) / length
        steep = abs(angle) / 90.0
        bend = 1.0 - chord / width
        cost = 0.15 * covered + 1.5 * shunned + 1.0 * off_centre + 0.6 * steep + 20.0 * bend
        yield _Candidate(box, cost)


def _distance_inside(outline: FloatArray, points: FloatArray) -> float:
    """Return the least distance of points to the sides of an outline; negative if outside."""
    ends = np.roll(outline, -1, axis=0)
    sides = ends - outline
    offset = points[:, np.newaxis, :] - outline
    share = np.clip(np.einsum("psk,sk->ps", offset, sides) / (sides**2).sum(axis=1), 0.0, 1.0)
    gaps = offset - share[:, :, np.newaxis] * sides
    distance = float(np.sqrt((gaps**2).sum(axis=2)).min())
    return distance if Path(outline).contains_points(points).all() else -distance
