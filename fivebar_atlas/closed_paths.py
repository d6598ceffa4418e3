"""Closed paths in the plane, circles and outlines inset by a margin, and places along paths.

Paths are the corners of straight segments. A closed path does not repeat its first corner.
"""

from __future__ import annotations

import math

import numpy as np
import shapely

from fivebar_atlas.errors import InputError
from fivebar_atlas.planar_geometry import CircleArc, FloatArray, Region

# How far chords leave a circle, as a share of its radius.
_CIRCLE_DEVIATION = 1e-6
# How far chords leave an outline that is inset: shares of its extent and of the margin.
_OUTLINE_DEVIATION, _MARGIN_DEVIATION = 2e-5, 0.02
# Segments of a quarter of a circle around a corner that points inwards.
_QUARTER_SEGMENTS = 32
# Least margin, and accuracy of the largest one, as shares of the extent.
_LEAST_MARGIN, _LARGEST_ACCURACY = 1e-5, 1e-6


def circle_path(x: float, y: float, radius: float) -> FloatArray:
    """Return a circle as a closed path, counter-clockwise from its rightmost point.

    Parameters
    ----------
    x, y
        Centre.
    radius
        Radius.

    Returns
    -------
    ndarray
        Corners, shape (n, 2), on the circle, which the chords leave by 1e-6 of the radius.

    Raises
    ------
    InputError
        If a coordinate is not finite, or the radius not positive and finite.
    """
    for name, value in (("x", x), ("y", y)):
        if not math.isfinite(value):
            raise InputError(f"circle {name}", value, "a finite coordinate")
    if not (math.isfinite(radius) and radius > 0.0):
        raise InputError("circle radius", radius, "a finite length above 0")
    return CircleArc.whole((x, y), radius).polyline(_CIRCLE_DEVIATION * radius)[:-1]


def inset_path(region: Region, margin: float, hole: int | None = None) -> FloatArray:
    """Return the boundary of what is left of a region inside a margin, as a closed path.

    Where the margin cuts the region into several parts, that of the largest area counts.

    Parameters
    ----------
    region
        The region.
    margin
        Distance from the whole boundary of the region, holes included.
    hole
        Which hole of the part is gone around, from 1, the largest first; its outline if None.

    Returns
    -------
    ndarray
        Corners, shape (n, 2), counter-clockwise from the rightmost one; their distance from
        the boundary differs from the margin by no more than 2 % of it.

    Raises
    ------
    InputError
        If the margin is not positive, or too large for the region (the largest one that is
        possible is named), or the part has no such hole.
    """
    outer = region.outline.polyline(1e-2 * math.sqrt(region.outline.area))
    extent = float(np.ptp(outer, axis=0).max())
    least = _LEAST_MARGIN * extent
    if not margin >= least:
        raise InputError("margin", margin, f"a length of at least {least:.4g}")
    deviation = min(_OUTLINE_DEVIATION * extent, _MARGIN_DEVIATION * margin)
    outer, *holes = region.polygons(deviation)
    # Where arcs meet in a cusp, their chords may cross.
    whole = shapely.make_valid(shapely.Polygon(outer, holes))
    inset = whole.buffer(-margin, quad_segs=_QUARTER_SEGMENTS)
    if inset.is_empty:
        circle = shapely.maximum_inscribed_circle(whole, tolerance=_LARGEST_ACCURACY * extent)
        largest = _rounded_down(float(shapely.length(circle)))
        raise InputError("margin", margin, f"a length of at most {largest:g}, which leaves a point")
    part = max(shapely.get_parts(inset), key=shapely.area)
    ring = part.exterior
    if hole is not None:
        rings = sorted(
            part.interiors, key=lambda each: shapely.area(shapely.Polygon(each)), reverse=True
        )
        if not 1 <= hole <= len(rings):
            there = f"a number from 1 to {len(rings)}" if rings else "none, as there are no holes"
            raise InputError("hole", hole, there)
        ring = rings[hole - 1]
    corners: FloatArray = shapely.get_coordinates(ring)[:-1]
    if not shapely.is_ccw(ring):
        corners = corners[::-1]
    return np.roll(corners, -int(np.argmax(corners[:, 0])), axis=0)


def closed(corners: FloatArray) -> FloatArray:
    """Return a path that ends where it begins, shape (n + 1, 2), or (n, 2) if it does already."""
    if np.array_equal(corners[0], corners[-1]):
        return corners
    return np.concatenate([corners, corners[:1]])


def path_lengths(corners: FloatArray) -> FloatArray:
    """Return the length of the way from the first corner to each, shape (n,)."""
    steps = np.hypot(*np.diff(corners, axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def places_along(corners: FloatArray, lengths: FloatArray) -> FloatArray:
    """Return points of a path at lengths of the way from its first corner.

    Parameters
    ----------
    corners
        Shape (n, 2).
    lengths
        Shape (k,), from 0 to the length of the path.

    Returns
    -------
    ndarray
        Shape (k, 2).
    """
    at_corners = path_lengths(corners)
    return np.column_stack([np.interp(lengths, at_corners, column) for column in corners.T])


def _rounded_down(value: float) -> float:
    """Return a positive number rounded down to four digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return math.floor(value / step) * step
