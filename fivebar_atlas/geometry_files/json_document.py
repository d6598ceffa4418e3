"""Geometry as nested dictionaries, ready for JSON.

The keys of the document are

``kind``, ``title``
    What it is, by its name on the command line and in a phrase.
``mechanism``, ``unit``, ``R1`` and so on, ``dimensional_factor``
    The design: the unit of all lengths, its own lengths by their names, and the factor D.
    Where lengths are non-dimensional the unit is empty and the names are those of the design,
    ``r1``.
``remarks``
    What is special about the design: sub-region, conditions of change points.
``mode``, ``lci_threshold``
    Mode pair or working mode, null for all; threshold, null where there is none.
``absence``
    Why there is nothing, null where there is something.
``arcs``
    The arcs that bound no region: loci and circles.
``isolated_points``
    Singular points that no arc passes through.
``regions``
    Each with its ``area``, ``outline`` and ``holes``. A boundary has the signed ``area`` that
    it encloses (Green's theorem: positive counter-clockwise), its ``length`` and its ``arcs``
    in order, the region on their left.
``area``
    ``green``, the sum over the regions, and ``integrated``, what the sweep integrates; null
    where there are no areas.
``base_joints``
    The actuated joints.

An arc has

``number``, ``curve``, ``kind``
    Its number among all arcs, name and kind of its curve.
``start``, ``end``, ``ends``
    Its end points, and what there is at each.
``length``
    Its length.
``modes``
    Mode pairs whose workspaces border on it, each with the side: left, right or both.
``circle``
    ``centre``, ``radius``, ``start_angle`` and ``sweep`` in radians, positive
    counter-clockwise; null for other curves.
``points``
    For other curves, points along it whose chords leave it by no more than the deviation
    asked for; null for circles.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import Any

from fivebar_atlas.geometry_files.design_geometry import (
    CIRCLES,
    LOCI,
    DesignGeometry,
    PlacedArc,
)
from fivebar_atlas.planar_geometry import CircleArc, Region


def json_document(geometry: DesignGeometry, deviation: float) -> dict[str, Any]:
    """Return geometry as nested dictionaries; the keys are those of this module's page.

    Parameters
    ----------
    geometry
        What is described.
    deviation
        Largest distance of a chord between neighbouring ``points`` from the arc, in the unit
        of the geometry.
    """
    design = geometry.design
    placed = geometry.placed_arcs()
    free = [_arc(each, deviation) for each in placed if each.region is None]
    area = None
    if geometry.kind not in (LOCI, CIRCLES):
        green = math.fsum(region.area for region in geometry.regions)
        area = {"green": green, "integrated": geometry.area}
    return {
        "kind": geometry.kind,
        "title": geometry.title,
        "mechanism": design.mechanism,
        "unit": design.unit,
        **design.named_lengths,
        "dimensional_factor": design.factor,
        "remarks": list(design.remarks()),
        "mode": geometry.mode,
        "lci_threshold": geometry.lci_threshold,
        "absence": geometry.absence or None,
        "arcs": free,
        "isolated_points": [_point(point) for point in geometry.isolated_points],
        "regions": [
            _region(region, [each for each in placed if each.region == number], deviation)
            for number, region in enumerate(geometry.regions, 1)
        ],
        "area": area,
        "base_joints": [_point(point) for point in geometry.base_joints],
    }


def _region(region: Region, placed: Iterable[PlacedArc], deviation: float) -> dict[str, Any]:
    arcs_of_loops = itertools.groupby(placed, key=lambda each: each.boundary)
    boundaries = [
        {
            "area": loop.area,
            "length": math.fsum(each.arc.length() for each in loop.arcs),
            "arcs": [_arc(each, deviation) for each in arcs],
        }
        for loop, (_, arcs) in zip(region.loops, arcs_of_loops, strict=True)
    ]
    return {
        "area": region.area,
        "outline": boundaries[0],
        "holes": boundaries[1:],
    }


def _arc(placed: PlacedArc, deviation: float) -> dict[str, Any]:
    named, arc = placed.named, placed.named.arc
    circle = points = None
    if isinstance(arc, CircleArc):
        circle = {
            "centre": _point(arc.centre),
            "radius": arc.radius,
            "start_angle": arc.start_angle,
            "sweep": arc.sweep,
        }
    else:
        points = (arc.polyline(deviation) + 0.0).tolist()
    return {
        "number": placed.number,
        "curve": named.name,
        "kind": named.kind,
        "start": _point(arc.start),
        "end": _point(arc.end),
        "ends": list(named.ends),
        "length": arc.length(),
        "modes": dict(named.sides),
        "circle": circle,
        "points": points,
    }


def _point(point: Iterable[float]) -> list[float]:
    """Return coordinates; -0.0 is 0.0."""
    return [part + 0.0 for part in point]
