"""Paths of straight segments: their corners, and where functions are least along them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.planar import PathLeast
from fivebar_atlas.planar_geometry import NamedArc, Point

# How far the polyline that stands for an arc in bounding boxes may leave it, and points that are
# looked at together.
_DEVIATION, _BLOCK = 1e-2, 4096
# Points farther off than this are mistakes; their squares are still numbers.
_FARTHEST = 1e60
_GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))
# Way between samples where least values are looked for, and how many there are at most; the
# lowest ones that are closed in on; steps.
_SPACING, _MOST_SAMPLES = 5e-3, 100_000
_LOWS, _LEAST_STEPS = 8, 48


def columns(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the coordinates of points, shape (..., 2), as two flat arrays."""
    flat = points.reshape(-1, 2)
    return np.ascontiguousarray(flat[:, 0]), np.ascontiguousarray(flat[:, 1])


def nearest_of(
    arcs: Sequence[NamedArc], isolated: Sequence[tuple[str, Point]], points: FloatArray
) -> tuple[FloatArray, list[str]]:
    """Return how far points are from arcs and isolated points, and the name of what is next.

    Parameters
    ----------
    arcs
        The arcs, those last whose nearest points are slow to find: points are compared with one
        only where its bounding box is closer than all before.
    isolated
        Isolated points and their names.
    points
        Shape (n, 2).
    """
    gaps = np.full(len(points), np.inf)
    places = np.full(len(points), -1)
    names = [*(name for name, _ in isolated), *(each.name for each in arcs)]
    for place, (_, point) in enumerate(isolated):
        _keep_nearer(gaps, places, slice(None), np.hypot(*(points - np.array(point)).T), place)
    for place, each in enumerate(arcs, start=len(isolated)):
        line = each.arc.polyline(_DEVIATION)
        outside = np.maximum(line.min(axis=0) - points, points - line.max(axis=0))
        close = np.flatnonzero(np.hypot(*np.maximum(outside, 0.0).T) - _DEVIATION < gaps)
        for first in range(0, len(close), _BLOCK):
            part = close[first : first + _BLOCK]
            _keep_nearer(gaps, places, part, each.arc.nearest(points[part])[0], place)
    return gaps, [names[place] for place in places]


def _keep_nearer(
    gaps: FloatArray,
    places: npt.NDArray[np.int64],
    part: npt.NDArray[np.int64] | slice,
    found: FloatArray,
    place: int,
) -> None:
    """Replace distances, and what they are to, where others are less."""
    nearer = found < gaps[part]
    gaps[part] = np.where(nearer, found, gaps[part])
    places[part] = np.where(nearer, place, places[part])


def checked_corners(points: npt.ArrayLike) -> FloatArray:
    """Return the corners of a path as an array, shape (n, 2)."""
    corners = np.array(points, dtype=np.float64)
    if corners.ndim != 2 or corners.shape[1] != 2 or not len(corners):
        raise InputError(
            "points", corners.shape, "an array of shape (n, 2) with at least one point"
        )
    bad = np.flatnonzero(~(np.abs(corners) < _FARTHEST).all(axis=1))
    if bad.size:
        x, y = corners[bad[0]].tolist()
        raise InputError(f"points[{bad[0]}]", (x, y), "two finite numbers")
    return corners


def least_along(corners: FloatArray, function: Callable[[FloatArray], FloatArray]) -> PathLeast:
    """Return where a continuous function is least on a path, between its corners too.

    The path is sampled; next to every sample that is lower than its neighbours, and among the
    lowest, golden sections close in on the least value.
    """
    run = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    spacing = max(_SPACING, float(run[-1]) / _MOST_SAMPLES)
    inner = np.linspace(0.0, run[-1], int(run[-1] / spacing) + 2)[1:-1]
    samples = np.union1d(run, inner)

    def at(places: FloatArray) -> FloatArray:
        return np.column_stack([np.interp(places, run, column) for column in corners.T])

    values = function(at(samples))
    padded = np.pad(values, 1, constant_values=np.inf)
    lows = np.flatnonzero((values <= padded[:-2]) & (values <= padded[2:]))
    lows = lows[np.argsort(values[lows], kind="stable")][:_LOWS]
    low, high = samples[np.maximum(lows - 1, 0)], samples[np.minimum(lows + 1, len(samples) - 1)]
    left, right = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    at_left, at_right = function(at(left)), function(at(right))
    for _ in range(_LEAST_STEPS):
        leftward = at_left < at_right
        low, high = np.where(leftward, low, left), np.where(leftward, right, high)
        fresh = np.where(leftward, low + _GOLDEN * (high - low), high - _GOLDEN * (high - low))
        at_fresh = function(at(fresh))
        left, right = np.where(leftward, fresh, right), np.where(leftward, left, fresh)
        at_left, at_right = (
            np.where(leftward, at_fresh, at_right),
            np.where(leftward, at_left, at_fresh),
        )
    places = np.concatenate([samples[lows], left])
    found = np.concatenate([values[lows], at_left])
    best = int(np.argmin(found))
    place = float(places[best])
    segment = min(int(np.searchsorted(run, place, side="right")) - 1, max(len(corners) - 2, 0))
    length = float(run[segment + 1] - run[segment]) if len(corners) > 1 else 0.0
    share = min(max((place - float(run[segment])) / length, 0.0), 1.0) if length > 0.0 else 0.0
    x, y = at(np.array([place]))[0]
    return PathLeast(float(found[best]), segment, share, (float(x), float(y)))
