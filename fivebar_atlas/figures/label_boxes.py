"""Upright labels beside points, lines and arcs: where they could stand, and where best.

All lengths are millimetres on paper, measured from the origin of the plane. A place is a box
and what speaks against it before it is known what is there.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence

import numpy as np

from fivebar_atlas.figures.text_placement import Box, points_along
from fivebar_atlas.planar_geometry import FloatArray

Place = tuple[Box, float]

#: Spacing of points that stand for the lines a label must not cover.
SPACING = 0.4

# What speaks against covering a point of a line, and a box; both more than all else.
_COVERED_POINT, _COVERED_BOX = 20.0, 80.0
# The same for a faint line, and for being farther than need be by a millimetre.
_FAINT_POINT, _FAR = 0.5, 3.0
# A label of a curve within this many millimetres of other lines could belong to them.
_ALONE = 8.0
# What speaks against a label on another line, and against one at the end of its own.
_MISTAKEN, _OFF_CENTRE = 8.0, 1.5
# Room between a label and what is around it.
_GAP, _BOX_GAP = 0.5, 0.3
_DIRECTIONS = 16


def best_box(
    places: Iterable[Place],
    outline: FloatArray,
    lines: FloatArray,
    faint: FloatArray,
    occupied: Sequence[Box],
    must: bool = True,
) -> Box | None:
    """Return the place where a label covers least, near what it belongs to.

    Parameters
    ----------
    places
        The places to choose from.
    outline
        Rectangle that the label must stay in, its first and third corner opposite ones.
    lines
        Points of lines that are not to be covered, shape (n, 2), no more than ``SPACING``
        apart.
    faint
        Points of faint lines that are better not covered, shape (n, 2).
    occupied
        Boxes that are not to be covered.
    must
        Whether the label has to stand somewhere, even if it covers something.

    Returns
    -------
    Box or None
        None if there is no place at all, or none that is free and there need not be one.
    """
    best: tuple[float, Box] | None = None
    for box, cost in places:
        if best is not None and cost >= best[0]:
            continue
        corners = box.corners(_GAP)
        if np.any(corners < outline[0]) or np.any(corners > outline[2]):
            continue
        cost += _FAINT_POINT * float(box.contains(faint, 0.2).sum())
        if best is not None and cost >= best[0]:
            continue
        cost += _COVERED_POINT * float(box.contains(lines, _GAP).sum())
        cost += _COVERED_BOX * sum(box.overlaps(other, _BOX_GAP) for other in occupied)
        if best is None or cost < best[0]:
            best = cost, box
    if best is None or (best[0] >= _COVERED_POINT and not must):
        return None
    return best[1]


def around(
    place: FloatArray, clearance: float, farthest: float, width: float, height: float
) -> Iterable[Place]:
    """Yield places around a point that keep clear of it, up to a distance."""
    distances = [each for each in (0.5, 1.0, 1.7, 2.6, 4.0, 6.0, 9.0) if each <= farthest]
    for distance, turn in itertools.product(distances, range(_DIRECTIONS)):
        angle = math.tau * turn / _DIRECTIONS
        yield _towards(place, angle, clearance + distance, width, height), _FAR * distance


def beside(line: FloatArray, clearance: float, width: float, height: float) -> Iterable[Place]:
    """Yield places on both sides of a straight line, shape (2, 2), near its middle first."""
    dx, dy = line[1] - line[0]
    normal = math.atan2(dx, -dy)
    for share, side, distance in itertools.product(
        (0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74), (0.0, math.pi), (0.7, 1.4, 2.4)
    ):
        foot = line[0] + share * (line[1] - line[0])
        box = _towards(foot, normal + side, clearance + distance, width, height)
        yield box, 6.0 * abs(share - 0.5) + _FAR * distance


def beside_arc(
    centre: FloatArray, radius: float, middle: float, width: float, height: float
) -> Iterable[Place]:
    """Yield places outside and inside of a circular arc, near its middle direction first."""
    turns = (0.0, 0.25, -0.25, 0.5, -0.5, 0.8, -0.8)
    for turn, distance in itertools.product(turns, (0.5, 1.2, 2.2)):
        cost = 2.0 * abs(turn) + _FAR * distance
        yield _towards(centre, middle + turn, radius + distance, width, height), cost
        foot = centre + radius * np.array([math.cos(middle + turn), math.sin(middle + turn)])
        yield _towards(foot, middle + turn + math.pi, distance, width, height), cost


def beside_curve(
    line: FloatArray, others: FloatArray, width: float, height: float
) -> Iterable[Place]:
    """Yield places on both sides of a curve, far from its ends and from other lines first.

    Parameters
    ----------
    line
        The curve, shape (n, 2).
    others
        Points of all lines it could be mistaken for, shape (m, 2).
    width, height
        Size of the label.
    """
    run = points_along(line, 2.0)
    before, after = np.roll(run, 1, axis=0), np.roll(run, -1, axis=0)
    before[0], after[-1] = run[0], run[-1]
    (x, y), (other_x, other_y) = run.T, others.T
    squares = (x[:, None] - other_x) ** 2 + (y[:, None] - other_y) ** 2
    gaps = np.sqrt(squares.min(axis=1, initial=_ALONE**2))
    doubt = _MISTAKEN * (1.0 - gaps / _ALONE) + _OFF_CENTRE * np.abs(np.linspace(-1, 1, len(run)))
    for foot, (dx, dy), cost in zip(run, after - before, doubt, strict=True):
        normal = math.atan2(dx, -dy)
        for side, distance in itertools.product((0.0, math.pi), (0.8, 1.4, 2.2)):
            box = _towards(foot, normal + side, distance, width, height)
            yield box, float(cost) + _FAR * distance


def _towards(place: FloatArray, angle: float, distance: float, width: float, height: float) -> Box:
    """Return the box in some direction whose edge is at a distance from a point."""
    c, s = math.cos(angle), math.sin(angle)
    reach = distance + min(width / (2.0 * max(abs(c), 1e-9)), height / (2.0 * max(abs(s), 1e-9)))
    return Box(float(place[0] + reach * c), float(place[1] + reach * s), width, height)
