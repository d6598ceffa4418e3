"""Places to start a search from: ever finer lattices around the best of a coarse one.

A lattice may be coarse beside a ridge or the corner of a region, so what is best on it need
not lie next to the optimum. Around many good places that are apart, and along the border of
the design space, where values may jump, finer lattices tell which are worth a search.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from fivebar_atlas.synthesis.design_polygon import DesignPolygon

FloatArray = npt.NDArray[np.float64]

#: Takes points of the chart; returns how good they are as they are, -inf where they are not
#: allowed, and how good they would be next to where they are allowed.
Scores = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

# Pitch that the first finer lattice need not be below, and rings of points around a place;
# and how many times the distance in which errors hide what is better.
_PITCH, _PITCHES, _FEWEST_RINGS, _MOST_RINGS = 0.005, 5.0, 2, 6
# Radii of the lattices in spacings, and around how many places of each ranking they are.
_LEVELS = ((1.0, (16, 8)), (0.3, (6, 3)), (0.06, (4, 2)))
# How far apart places are, in radii of the lattices around them.
_APART = 0.7
# Distance from the border of what lies beside it, in radii: where values jump at a border they
# may cost a lot to compute very close to it.
_BESIDE = 0.25
# Rays from a corner, by the share of the second side, and distances along them in spacings.
_FAN = np.linspace(0.05, 0.95, 10)
_CLOSER = 2.0 ** -np.arange(7.0)
# Places to start from, of each ranking.
_STARTS = (4, 2)


def explored(
    scores: Scores,
    polygon: DesignPolygon,
    starts: FloatArray,
    spacing: float,
    finest: float = 0.0,
) -> FloatArray:
    """Return the best places, which are apart, around places to start from.

    Parameters
    ----------
    scores
        How good places are.
    polygon
        The design space.
    starts
        Places to start from, shape (n, 2).
    spacing
        How far around them to look.
    finest
        Distance of places below which errors of values hide which is better.

    Returns
    -------
    ndarray
        Shape (m, 2), the best of those that are allowed first.
    """
    points = np.vstack([starts, _along_sides(polygon, spacing), _near_corners(polygon, spacing)])
    as_they_are, nearly = scores(points)
    rings = int(
        np.clip(np.ceil(spacing / max(_PITCH, _PITCHES * finest)), _FEWEST_RINGS, _MOST_RINGS)
    )
    for radius, counts in _LEVELS:
        apart = _APART * radius * spacing
        chosen = _best_apart(points, (as_they_are, nearly), counts, apart)
        pattern = radius * spacing * _hexagon(rings)
        rings = _FEWEST_RINGS
        around = (points[chosen][:, np.newaxis, :] + pattern).reshape(-1, 2)
        fresh = _unique(_with_border(polygon, around, _BESIDE * radius * spacing))
        found = scores(fresh)
        points = np.vstack([points[chosen], fresh])
        as_they_are = np.concatenate([as_they_are[chosen], found[0]])
        nearly = np.concatenate([nearly[chosen], found[1]])
    return points[_best_apart(points, (as_they_are, nearly), _STARTS, apart)]


def _hexagon(rings: int) -> FloatArray:
    """Return a triangular lattice within a hexagon of radius 1 about 0, shape (n, 2)."""
    steps = np.arange(-rings, rings + 1)
    one, other = (each.ravel() for each in np.meshgrid(steps, steps))
    kept = np.abs(one + other) <= rings
    one, other = one[kept] / rings, other[kept] / rings
    return np.column_stack([one + 0.5 * other, np.sqrt(0.75) * other])


def _with_border(polygon: DesignPolygon, points: FloatArray, beside: float) -> FloatArray:
    """Return points, those outside moved onto the border and also to a place beside it."""
    inside = polygon.clip(points)
    moved = np.any(inside != points, axis=1)
    return np.vstack([inside, _inward(polygon, inside[moved], beside)])


def _inward(polygon: DesignPolygon, points: FloatArray, distance: float) -> FloatArray:
    """Return points moved by a distance towards the middle of the polygon."""
    along = polygon.corners.mean(axis=0) - points
    lengths = np.linalg.norm(along, axis=1, keepdims=True)
    return np.asarray(points + distance * along / lengths, dtype=np.float64)


def _along_sides(polygon: DesignPolygon, spacing: float) -> FloatArray:
    """Return points next to the sides of the polygon, so far apart."""
    parts = []
    for start, end in zip(polygon.corners, np.roll(polygon.corners, -1, axis=0), strict=True):
        count = int(np.ceil(np.linalg.norm(end - start) / spacing))
        shares = (np.arange(count) + 0.5)[:, np.newaxis] / count
        parts.append(start + shares * (end - start))
    sides = np.vstack(parts)
    return np.vstack([sides, _inward(polygon, sides, _BESIDE * spacing)])


def _near_corners(polygon: DesignPolygon, spacing: float) -> FloatArray:
    """Return points ever closer to the corners of the polygon, where values change fast."""
    after = np.roll(polygon.corners, -1, axis=0) - polygon.corners
    before = np.roll(polygon.corners, 1, axis=0) - polygon.corners
    sides = [each / np.linalg.norm(each, axis=1, keepdims=True) for each in (after, before)]
    fan = [(1.0 - share) * sides[0] + share * sides[1] for share in _FAN]
    return np.concatenate(
        [polygon.corners + spacing * distance * ray for distance in _CLOSER for ray in fan]
    )


def _unique(points: FloatArray) -> FloatArray:
    return np.unique(points, axis=0)


def _best_apart(
    points: FloatArray,
    rankings: tuple[FloatArray, FloatArray],
    counts: tuple[int, int],
    apart: float,
) -> list[int]:
    """Return the best points of two rankings, none of them too near to a better one."""
    chosen: list[int] = []
    for scores, count in zip(rankings, counts, strict=True):
        left = np.argsort(-scores, kind="stable")
        left = left[scores[left] > -np.inf]
        for place in chosen:
            left = left[np.linalg.norm(points[left] - points[place], axis=1) >= apart]
        for _ in range(count):
            if not len(left):
                break
            place = int(left[0])
            chosen.append(place)
            left = left[np.linalg.norm(points[left] - points[place], axis=1) >= apart]
    return chosen
