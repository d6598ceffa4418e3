"""Arcs as a table of points: comma-separated text, one row a point.

The columns are

``arc``
    Number of the arc, from 1; all rows of an arc follow each other, in order along it.
``curve``, ``kind``
    Name of the curve and what happens on it.
``region``, ``boundary``
    For boundaries of regions: number of the region, from 1, and ``outline`` or ``hole 1`` and
    so on. The arcs of a boundary follow each other, end to start, the region on their left.
``start``, ``end``
    What there is at the ends of the arc: ``tangency``, ``cusp``, ``intersection``, ``closed``.
``modes``
    Mode pairs whose workspaces border on the arc, by the side on which they lie.
``centre_x``, ``centre_y``, ``radius``
    The circle that the arc is part of; ``nan`` for other curves.
``x``, ``y``
    The point.

Names of lengths end in the unit, ``x_mm``; without one they are non-dimensional. Numbers have
as many digits as tell them apart from every other.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from fivebar_atlas.geometry_files.design_geometry import DesignGeometry, sides_text
from fivebar_atlas.planar_geometry import CircleArc

_NAMES = ("arc", "curve", "kind", "region", "boundary", "start", "end", "modes")
_LENGTHS = ("centre_x", "centre_y", "radius", "x", "y")


def csv_text(geometry: DesignGeometry, deviation: float) -> str:
    """Return the points of all arcs as comma-separated text.

    Parameters
    ----------
    geometry
        What is written.
    deviation
        Largest distance of a chord between neighbouring points from the arc, in the unit of
        the geometry. Level curves are given by the points that are known of them.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    unit = geometry.design.unit
    writer.writerow([*_NAMES, *(f"{name}_{unit}" if unit else name for name in _LENGTHS)])
    writer.writerows(_rows(geometry, deviation))
    return stream.getvalue()


def _rows(geometry: DesignGeometry, deviation: float) -> Iterator[list[object]]:
    placed_arcs = geometry.placed_arcs()
    for placed in placed_arcs:
        named = placed.named
        region = "" if placed.region is None else placed.region
        circle: list[object] = ["nan"] * 3
        if isinstance(named.arc, CircleArc):
            circle = _texts(*named.arc.centre, named.arc.radius)
        about = [placed.number, named.name, named.kind, region, placed.boundary, *named.ends]
        for x, y in named.arc.polyline(deviation).tolist():
            yield [*about, sides_text(named.sides), *circle, *_texts(x, y)]
    for number, point in enumerate(geometry.isolated_points, len(placed_arcs) + 1):
        about = [number, "isolated point", "singular point", "", "", "", ""]
        yield [*about, "", *["nan"] * 3, *_texts(*point)]


def _texts(*lengths: float) -> list[object]:
    """Return numbers as their shortest exact texts; -0.0 is 0.0."""
    return [repr(length + 0.0) for length in lengths]
