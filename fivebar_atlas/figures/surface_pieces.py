"""A surface over triangles, cut at levels into pieces that lie in one band each."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, slots=True)
class SurfacePieces:
    """Pieces of triangles between levels.

    Attributes
    ----------
    triangles
        Which triangle each is a part of, ascending, shape (k,).
    bands
        The band it lies in, from the lowest level, shape (k,).
    weights
        Barycentric weights of its five corners in the triangle, shape (k, 5, 3); corners may
        coincide. The last two are the ends of the line at its upper level.
    is_cut
        Whether its upper level cuts the triangle, shape (k,).
    """

    triangles: IntArray
    bands: IntArray
    weights: FloatArray
    is_cut: BoolArray


def cut_at_levels(values: FloatArray, levels: FloatArray) -> SurfacePieces:
    """Cut triangles on which a value is linear at levels.

    Parameters
    ----------
    values
        Values at the corners of each triangle, finite, shape (m, 3).
    levels
        Ascending levels, at least two. What is beyond them belongs to the outermost band.
    """
    order = np.argsort(values, axis=1, kind="stable")
    least, middle, greatest = np.take_along_axis(values, order, axis=1).T
    last = len(levels) - 2
    first_band = np.clip(np.searchsorted(levels, least, side="right") - 1, 0, last)
    last_band = np.clip(np.searchsorted(levels, greatest, side="left") - 1, first_band, last)
    counts = last_band - first_band + 1
    triangles = np.repeat(np.arange(len(values)), counts)
    ends = np.cumsum(counts)
    bands = np.arange(len(triangles)) - np.repeat(ends - counts - first_band, counts)
    least, middle, greatest = least[triangles], middle[triangles], greatest[triangles]
    is_first, is_last = bands == first_band[triangles], bands == last_band[triangles]
    lower = np.where(is_first, least, levels[bands])
    upper = np.where(is_last, greatest, levels[bands + 1])
    # A triangle of one value is one piece: its long side from one end to the other.
    at_lower = _along(lower, least, greatest, 0.0), _around(lower, least, middle, greatest)
    at_upper = _along(upper, least, greatest, 1.0), _around(upper, least, middle, greatest)
    has_corner = (lower < middle) & (middle < upper)
    corner = np.where(has_corner[:, np.newaxis], [0.0, 1.0, 0.0], at_lower[1])
    weights = np.stack([at_lower[0], at_lower[1], corner, at_upper[1], at_upper[0]], axis=1)
    places = np.argsort(order, axis=1)[triangles]
    weights = np.take_along_axis(weights, places[:, np.newaxis, :], axis=2)
    return SurfacePieces(triangles, bands, weights, ~is_last)


def _share(value: FloatArray, low: FloatArray, high: FloatArray, of_one: float) -> FloatArray:
    """Return where between two values a third lies; ``of_one`` where both are one."""
    span = high - low
    return np.where(span > 0.0, (value - low) / np.where(span > 0.0, span, 1.0), of_one)


def _along(value: FloatArray, least: FloatArray, greatest: FloatArray, of_one: float) -> FloatArray:
    """Return weights, shape (k, 3), of the point with a value between first and last corner."""
    share = _share(value, least, greatest, of_one)
    return np.stack([1.0 - share, np.zeros_like(share), share], axis=1)


def _around(
    value: FloatArray, least: FloatArray, middle: FloatArray, greatest: FloatArray
) -> FloatArray:
    """Return those of the point on the other two sides."""
    before = _share(value, least, middle, 1.0)
    after = _share(value, middle, greatest, 0.0)
    nothing = np.zeros_like(before)
    return np.where(
        (value <= middle)[:, np.newaxis],
        np.stack([1.0 - before, before, nothing], axis=1),
        np.stack([nothing, 1.0 - after, after], axis=1),
    )
