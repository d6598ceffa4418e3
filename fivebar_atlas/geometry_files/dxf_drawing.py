"""Arcs as a drawing in DXF: CIRCLE and ARC where they are, LWPOLYLINE for other curves.

Every curve is a layer with its name, in the colour and the line type of its kind. The arcs of
each boundary are a group, ``OUTLINE_1`` or ``HOLE_1_1``, in order. The number of an arc, what
it is, what there is at its ends and which mode pairs border on it stand in its extended data.
Arcs run counter-clockwise in DXF: sides and ends are given for that sense.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from fivebar_atlas.geometry_files.curve_styles import identifier, style_of
from fivebar_atlas.geometry_files.design_geometry import (
    DesignGeometry,
    PlacedArc,
    sides_text,
)
from fivebar_atlas.planar_geometry import LEFT, RIGHT, CircleArc, NamedArc

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities import DXFGraphic
    from ezdxf.layouts import Modelspace

#: Codes of $INSUNITS of the units that drawings know; every other is "unitless".
UNITS = {"in": 1, "mm": 4, "cm": 5, "m": 6}
#: Name under which entities have extended data.
APPLICATION = "FIVEBAR_ATLAS"
ISOLATED_POINTS, BASE_JOINTS = "ISOLATED_POINTS", "BASE_JOINTS"

_VERSION = "R2010"
# Points are drawn as a cross in a circle; their size, and that of dashes, in D.
_POINT_MODE, _POINT_SIZE, _DASH_SIZE = 34, 0.04, 0.05
_DASHED_THROUGHOUT = 128
_FULL_TURN = 2.0 * math.pi * (1.0 - 1e-12)


def dxf_text(geometry: DesignGeometry, deviation: float) -> str:
    """Return a drawing as DXF.

    Parameters
    ----------
    geometry
        What is drawn.
    deviation
        Largest distance of a polyline from its curve, in the unit of the geometry. Circle
        arcs are exact; level curves are given by the points that are known of them.

    Raises
    ------
    ImportError
        If ezdxf is not installed.
    """
    import ezdxf

    with _same_bytes_every_time():
        document = ezdxf.new(_VERSION, setup=["linetypes"])
        _describe(document, geometry)
        space = document.modelspace()
        groups: dict[str, list[DXFGraphic]] = {}
        for placed in geometry.placed_arcs():
            entity = _add_arc(document, space, placed, deviation)
            if placed.region is not None:
                groups.setdefault(_group_name(placed), []).append(entity)
        for name, entities in groups.items():
            document.groups.new(name).extend(entities)
        for layer, points in (
            (ISOLATED_POINTS, geometry.isolated_points),
            (BASE_JOINTS, geometry.base_joints),
        ):
            for point in points:
                _add_layer(document, layer, layer.replace("_", " ").lower())
                space.add_point(point, dxfattribs={"layer": layer})
        stream = io.StringIO()
        document.write(stream)
    return stream.getvalue()


@contextlib.contextmanager
def _same_bytes_every_time() -> Iterator[None]:
    """Let ezdxf write a fixed date and identifier instead of today's and a random one."""
    import ezdxf

    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def _describe(document: Drawing, geometry: DesignGeometry) -> None:
    """Set the header: units, what the drawing is, and where it is looked at."""
    design = geometry.design
    header = document.header
    header["$INSUNITS"] = UNITS.get(design.unit, 0)
    header["$MEASUREMENT"] = 0 if design.unit == "in" else 1
    header["$LTSCALE"] = _DASH_SIZE * design.factor
    header["$PDMODE"] = _POINT_MODE
    header["$PDSIZE"] = _POINT_SIZE * design.factor
    properties = {
        "Title": geometry.title,
        "Design": geometry.subject,
        "Unit": design.unit or "non-dimensional",
        "D": f"{design.factor:.17g}",
        "Remarks": "; ".join(design.remarks()),
    }
    for name, value in properties.items():
        header.custom_vars.append(name, value)
    document.appids.new(APPLICATION)
    (left, low), (right, high) = (corner.tolist() for corner in geometry.extent())
    document.modelspace().reset_extents((left, low, 0.0), (right, high, 0.0))
    height = 1.1 * max(high - low, right - left)
    document.set_modelspace_vport(height, (0.5 * (left + right), 0.5 * (low + high)))


def _group_name(placed: PlacedArc) -> str:
    """Return the name of the group of a boundary: ``OUTLINE_1``, ``HOLE_1_2``."""
    role, *number = placed.boundary.upper().split()
    return "_".join([role, str(placed.region), *number])


def _add_layer(document: Drawing, name: str, kind: str) -> None:
    """Add the layer of a curve unless it is there."""
    if name in document.layers:
        return
    style = style_of(kind)
    layer = document.layers.add(name, color=style.colour_index, linetype=style.line_type)
    layer.description = kind


def _add_arc(
    document: Drawing, space: Modelspace, placed: PlacedArc, deviation: float
) -> DXFGraphic:
    """Add one arc as an entity that says what it is."""
    named = placed.named
    layer = identifier(named.name)
    _add_layer(document, layer, named.kind)
    attributes = {"layer": layer}
    entity: DXFGraphic
    if isinstance(named.arc, CircleArc):
        if named.arc.sweep < 0.0:
            named = _turned(named)
        arc = named.arc
        assert isinstance(arc, CircleArc)
        if arc.sweep >= _FULL_TURN:
            entity = space.add_circle(arc.centre, arc.radius, dxfattribs=attributes)
        else:
            start = math.degrees(arc.start_angle) % 360.0
            end = math.degrees(arc.start_angle + arc.sweep) % 360.0
            entity = space.add_arc(arc.centre, arc.radius, start, end, dxfattribs=attributes)
    else:
        corners = [(x, y) for x, y in named.arc.polyline(deviation).tolist()]
        closed = corners[0] == corners[-1]
        entity = space.add_lwpolyline(
            corners[:-1] if closed else corners, close=closed, dxfattribs=attributes
        )
        # dashes run on over the corners
        entity.dxf.flags |= _DASHED_THROUGHOUT
    tags = {
        "arc": placed.number,
        "curve": named.name,
        "kind": named.kind,
        "start": named.ends[0],
        "end": named.ends[1],
        "modes": sides_text(named.sides),
    }
    entity.set_xdata(APPLICATION, [(1000, f"{name}={value}") for name, value in tags.items()])
    return entity


def _turned(named: NamedArc) -> NamedArc:
    """Return an arc run through the other way: ends and sides change places."""
    other = {LEFT: RIGHT, RIGHT: LEFT}
    start, end = named.ends
    return dataclasses.replace(
        named,
        arc=named.arc.reversed(),
        ends=(end, start),
        sides={pair: other.get(side, side) for pair, side in named.sides.items()},
    )
