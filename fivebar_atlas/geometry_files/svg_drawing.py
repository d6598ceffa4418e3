"""Arcs as a drawing in SVG, to size: circle arcs are arcs, other curves are cubic splines.

Coordinates in the file are those of the geometry, y upwards: one transformation turns the
whole drawing over. Every curve is a group with its name as ``id`` and its kind as ``class``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from xml.etree import ElementTree

import numpy as np

from fivebar_atlas.geometry_files.curve_styles import identifier, style_of
from fivebar_atlas.geometry_files.design_geometry import (
    DesignGeometry,
    PlacedArc,
    sides_text,
)
from fivebar_atlas.planar_geometry import (
    Arc,
    CircleArc,
    FloatArray,
    Point,
    PolylineArc,
    Region,
)

#: Millimetres of the units that drawings know.
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
#: Size of D on paper where lengths are non-dimensional, or in a unit not known, in mm.
D_ON_PAPER = 50.0

_REGION_COLOUR = "#dce9f2"
_INK = "#111111"
# Shares of the longer side of the drawing.
_MARGIN, _LINE, _DOT = 0.04, 0.0025, 0.005
# A circle arc is written in parts of no more than a quarter: their centre is well defined.
_LARGEST_SWEEP = 0.5 * math.pi
# Where a cubic is compared with the arc: between its four points and near their middles.
_CHECKS = np.array([0.06, 0.13, 0.24, 0.41, 0.5, 0.59, 0.76, 0.87, 0.94])
_LEAST_SHARE = 1e-9
# Control points of the cubic through points at 0, 1/3, 2/3 and 1.
_CONTROLS = (
    np.array([[6.0, 0.0, 0.0, 0.0], [-5.0, 18.0, -9.0, 2.0], [2.0, -9.0, 18.0, -5.0], [0, 0, 0, 6]])
    / 6.0
)
_BERNSTEIN = np.column_stack(
    [math.comb(3, k) * _CHECKS**k * (1.0 - _CHECKS) ** (3 - k) for k in range(4)]
)


def svg_text(geometry: DesignGeometry, deviation: float) -> str:
    """Return a drawing as SVG.

    Parameters
    ----------
    geometry
        What is drawn.
    deviation
        Largest distance of a spline from its curve, in the unit of the geometry. Circle arcs
        are exact; level curves are given by the points that are known of them.
    """
    design = geometry.design
    is_known = design.unit in UNITS
    scale = UNITS[design.unit] if is_known else D_ON_PAPER / design.factor
    low, high = geometry.extent()
    side = float((high - low).max())
    margin = _MARGIN * side
    width, height = (float(part) for part in high - low + 2.0 * margin)
    view = (float(low[0]) - margin, -float(high[1]) - margin, width, height)
    root = ElementTree.Element(
        "svg",
        {
            "xmlns": "http://www.w3.org/2000/svg",
            "version": "1.1",
            "width": f"{scale * width:.9g}mm",
            "height": f"{scale * height:.9g}mm",
            "viewBox": " ".join(f"{part:.12g}" for part in view),
        },
    )
    title = f"{geometry.title[0].upper()}{geometry.title[1:]}: {geometry.subject}"
    ElementTree.SubElement(root, "title").text = title
    ElementTree.SubElement(root, "desc").text = _description(geometry, is_known)
    sheet = _group(
        root,
        "geometry",
        transform="scale(1,-1)",
        fill="none",
        stroke=_INK,
        **{
            "stroke-width": f"{_LINE * side:.4g}",
            "stroke-linecap": "butt",
            "stroke-linejoin": "round",
        },
    )
    if geometry.regions:
        group = _group(sheet, "regions", fill=_REGION_COLOUR, stroke="none")
        group.set("fill-rule", "evenodd")
        for number, region in enumerate(geometry.regions, 1):
            path = _region_path(region, deviation)
            ElementTree.SubElement(group, "path", {"id": f"region_{number}", "d": path})
    _add_curves(sheet, geometry.placed_arcs(), side, deviation)
    _add_dots(sheet, "isolated_points", geometry.isolated_points, _DOT * side, _INK)
    _add_dots(sheet, "base_joints", geometry.base_joints, _DOT * side, "white")
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _description(geometry: DesignGeometry, is_known: bool) -> str:
    """Return what a reader of the file must know: unit, size on paper, remarks."""
    unit = geometry.design.unit
    size = f"The drawing has the size of the machine; coordinates are in {unit}."
    if not is_known:
        lengths = f"in {unit}" if unit else "non-dimensional"
        factor = f"D = {geometry.design.factor:.8g}" if unit else "D"
        size = f"Coordinates are {lengths}; {factor} is {D_ON_PAPER:g} mm on paper."
    return f"{size} Remarks: {'; '.join(geometry.design.remarks())}."


def _add_curves(
    sheet: ElementTree.Element, placed: Iterable[PlacedArc], side: float, deviation: float
) -> None:
    """Add a group for each curve, in the order in which curves first occur."""
    curves: dict[str, list[PlacedArc]] = {}
    for each in placed:
        curves.setdefault(each.named.name, []).append(each)
    for name, arcs in curves.items():
        kind = arcs[0].named.kind
        style = style_of(kind)
        group = _group(sheet, identifier(name), stroke=style.colour)
        group.set("class", kind.replace(",", ""))
        if style.dashes:
            dashes = (f"{1e-3 * side * length:.4g}" for length in style.dashes)
            group.set("stroke-dasharray", " ".join(dashes))
        ElementTree.SubElement(group, "title").text = f"{name} ({kind})"
        for each in arcs:
            named = each.named
            attributes = {"id": f"arc_{each.number}", "d": _arc_path(named.arc, deviation)}
            if each.region is not None:
                attributes["data-boundary"] = f"region {each.region}, {each.boundary}"
            attributes["data-start"], attributes["data-end"] = named.ends
            attributes["data-modes"] = sides_text(named.sides)
            ElementTree.SubElement(group, "path", attributes)


def _add_dots(
    sheet: ElementTree.Element, name: str, points: Sequence[Point], radius: float, fill: str
) -> None:
    if not points:
        return
    group = _group(sheet, name, fill=fill)
    for x, y in points:
        circle = {"cx": _number(x), "cy": _number(y), "r": f"{radius:.4g}"}
        ElementTree.SubElement(group, "circle", circle)


def _group(parent: ElementTree.Element, name: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, "g", {"id": name, **attributes})


def _region_path(region: Region, deviation: float) -> str:
    parts = []
    for loop in region.loops:
        arcs = [each.arc for each in loop.arcs]
        pieces = (" ".join(_commands(arc, deviation)) for arc in arcs)
        parts.append(f"M {_pair(arcs[0].start)} {' '.join(pieces)} Z")
    return " ".join(parts)


def _arc_path(arc: Arc, deviation: float) -> str:
    path = f"M {_pair(arc.start)} {' '.join(_commands(arc, deviation))}"
    return f"{path} Z" if arc.start == arc.end else path


def _commands(arc: Arc, deviation: float) -> Iterator[str]:
    """Yield the path commands that go along an arc from its start to its end."""
    if isinstance(arc, CircleArc):
        count = max(1, math.ceil(abs(arc.sweep) / _LARGEST_SWEEP - 1e-9))
        points = arc.points(np.arange(1, count + 1) / count).tolist()
        points[-1] = arc.end
        turn = 1 if arc.sweep > 0.0 else 0
        radius = _number(arc.radius)
        for point in points:
            yield f"A {radius} {radius} 0 0 {turn} {_pair(point)}"
    elif isinstance(arc, PolylineArc):
        for point in arc.corners[1:].tolist():
            yield f"L {_pair(point)}"
    else:
        for controls in cubics(arc, deviation):
            yield f"C {' '.join(_pair(point) for point in controls[1:].tolist())}"


def cubics(arc: Arc, deviation: float) -> list[FloatArray]:
    """Return Bézier cubics that follow an arc, control points of shape (4, 2) each.

    Each passes through four exact points of the arc and leaves it nowhere by more than the
    deviation; where it would, the part is halved. End points are those of the arc.
    """
    found: list[FloatArray] = []
    parts = [(0.25 * k, 0.25) for k in reversed(range(4))]
    while parts:
        low, width = parts.pop()
        shares = low + width * np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])
        points = arc.points(np.concatenate([shares, low + width * _CHECKS]))
        exact, between = points[:4], points[4:]
        if low == 0.0:
            exact[0] = arc.start
        if low + width == 1.0:
            exact[3] = arc.end
        controls = _CONTROLS @ exact
        off = np.hypot(*(_BERNSTEIN @ controls - between).T).max()
        if off <= deviation or width < _LEAST_SHARE:
            found.append(controls)
        else:
            parts += [(low + 0.5 * width, 0.5 * width), (low, 0.5 * width)]
    for one, two in itertools.pairwise(found):
        two[0] = one[3]
    return found


def _pair(point: Sequence[float]) -> str:
    return f"{_number(point[0])} {_number(point[1])}"


def _number(value: float) -> str:
    """Return the shortest exact text of a number; -0.0 is 0.0."""
    return repr(float(value) + 0.0)
