"""The LCI inside the largest square of one design, in its maximal inscribed circle."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from matplotlib.figure import Figure
from shapely.geometry.polygon import orient

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import (
    KeyEntry,
    bar_height,
    draw_bar,
    draw_key_rows,
    key_rows_height,
)
from fivebar_atlas.figures.curves import MarkedPoints
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL, FILL_LEVEL, REGION_LEVEL, check_width
from fivebar_atlas.figures.lci_figure import band_edges, edge_texts, label_contours
from fivebar_atlas.figures.overlays import Overlay, draw_overlays
from fivebar_atlas.figures.plane_frame import PlaneFrame, bounds_of, flatness, plane_frame
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.text_placement import Box
from fivebar_atlas.figures.wording import number_text
from fivebar_atlas.figures.workspace_figure import OUTLINE, draw_outline, fill_region
from fivebar_atlas.level_curves import SampledField
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import CircleArc, FloatArray, Point

# Samples along the longer side of the panel, from which contours start.
_CELLS = 400
_AXES = ("$x/l_1$", "$y/l_1$")
# An LCI that is 1 but for rounding.
_ISOTROPIC = 1.0 - 1e-9

_WORKSPACE: dict[str, Any] = {"facecolor": style.WORKSPACE, "edgecolor": "none"}
_THRESHOLD: dict[str, Any] = {
    "color": style.INK,
    "linewidth": 0.7,
    "linestyle": (0.0, (4.0, 1.4)),
}
_CIRCLE: dict[str, Any] = {
    "color": style.INK,
    "linestyle": (0.0, (0.6, 1.6)),
    "linewidth": 0.9,
    "dash_capstyle": "round",
}
_CENTRE: dict[str, Any] = {"marker": "+", "markersize": 4.5, "markeredgewidth": 0.7}
_POINT: dict[str, Any] = {
    "linestyle": "none",
    "color": style.INK,
    "markeredgecolor": style.INK,
    "markeredgewidth": 0.6,
    "markerfacecolor": "white",
    "zorder": BORDER_LEVEL,
}
_PEAK: dict[str, Any] = {**_POINT, "marker": "*", "markersize": 6.0}
_MIDDLE: dict[str, Any] = {**_POINT, "marker": "x", "markersize": 3.6, "markeredgewidth": 0.8}


@dataclasses.dataclass(frozen=True, slots=True)
class SquareDrawing:
    """What is drawn of a square, in lengths of the actuated link.

    Attributes
    ----------
    name
        What it is: ``"square"``.
    width, height
        Its sides.
    centre
        Its centre.
    contacts
        Its points that touch what limits it.
    active
        What that is, in words.
    circle
        The maximal inscribed circle, None where there is none.
    """

    name: str
    width: float
    height: float
    centre: Point
    contacts: tuple[Point, ...]
    active: str
    circle: CircleArc | None

    @property
    def corners(self) -> FloatArray:
        """The corners, counter-clockwise from the lower left one, shape (4, 2)."""
        signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        return np.asarray(self.centre + 0.5 * signs * [self.width, self.height])

    @property
    def sides_text(self) -> str:
        """Its sides in words."""
        if self.width == self.height:
            return f"$a/l_1$ = {number_text(self.width, 5)}"
        width, height = (number_text(side, 5) for side in (self.width, self.height))
        return f"$w/l_1$ = {width}, $h/l_1$ = {height}"


def square_figure(
    design: PlanarDesign,
    mode: str,
    lci_threshold: float,
    square: SquareDrawing,
    title: str,
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the LCI inside the largest square, and the workspace around it.

    Parameters
    ----------
    design
        The design, with an actuated link of the length 1.
    mode
        The mode pair; it has a usable workspace.
    lci_threshold
        The least LCI in the square, above 0 and below 1.
    square
        The square.
    title
        Title of the figure.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Le, Kang and Doan 2013, Fig. 6. Contours are drawn in the square, that
        of the threshold all over the workspace.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    check_width(width)
    workspace = design.usable_workspace(mode)
    assert workspace is not None
    overlay = Overlay(
        f"largest {square.name}, {square.sides_text}",
        square.corners,
        square.contacts,
        f"contact: {square.active}",
    )
    marks = _marks(design, mode, square)
    rows = [
        *([entry] for entry in overlay.entries),
        *_circle_rows(square.circle),
        [KeyEntry("boundary of the usable workspace", OUTLINE)],
        [
            KeyEntry(f"LCI = {number_text(lci_threshold)}", _THRESHOLD),
            *(mark.entry for mark in marks),
        ],
    ]
    shown = [square.corners]
    if square.circle is not None:
        shown.append(square.circle.polyline(0.01 * square.circle.radius))
    label = rf"LCI $1/\kappa_J$ in the {square.name}"
    edges = band_edges(lci_threshold, 1.0, None)
    with styled():
        below = key_rows_height(rows, width) + bar_height(label, width)
        frame = plane_frame(bounds_of(shown), design.unit, title, width, below, _AXES)
        lower, upper = frame.corners
        field = SampledField.over(
            functools.partial(design.lci_inside, mode=mode), lower, upper, _CELLS
        )
        colours = list(style.colour_map()(np.linspace(0.0, 1.0, len(edges) - 1)))
        fill_region(frame, workspace.region, "usable-workspace", **_WORKSPACE)
        for number, line in enumerate(field.lines(lci_threshold), start=1):
            frame.line(line, f"threshold-{number}", **_THRESHOLD)
            if data is not None:
                data.add("contour", line, "LCI", "threshold", lci_threshold)
        draw_outline(frame, workspace.region.arcs, data)
        if square.circle is not None:
            _draw_circle(frame, square.circle, data)
        draw_overlays(frame, [overlay], data)
        for mark in marks:
            mark.draw(frame, data)
        # last, for labels keep off the marks
        _draw_bands(frame, field, square, edges, colours, data)
        used = draw_bar(frame, colours, edge_texts(edges), label)
        draw_key_rows(frame, rows, used)
        return frame.figure


def _marks(design: PlanarDesign, mode: str, square: SquareDrawing) -> list[MarkedPoints]:
    """Return the points that are marked: the largest LCI, and a centre beside the circle's."""
    marks = []
    found = design.largest_lci(mode)
    if found is not None:
        value, (x, y) = found
        offset = np.abs([x - square.centre[0], y - square.centre[1]])
        if np.all(offset <= 0.5 * np.array([square.width, square.height])):
            name = "isotropic point" if value > _ISOTROPIC else f"LCI = {number_text(value, 4)}"
            marks.append(MarkedPoints(name, ((x, y),), _PEAK))
    circle = square.circle
    if circle is None or circle.centre != square.centre:
        marks.append(MarkedPoints(f"centre of the {square.name}", (square.centre,), _MIDDLE))
    return marks


def _circle_rows(circle: CircleArc | None) -> list[list[KeyEntry]]:
    """Return the rows of the key for the maximal inscribed circle."""
    if circle is None:
        return []
    radius, y = (number_text(part, 5) for part in (circle.radius, circle.centre[1]))
    text = f"maximal inscribed circle, $r/l_1$ = {radius}, centre at $y/l_1$ = {y}"
    return [[KeyEntry(text, {**_CIRCLE, **_CENTRE, "markevery": [1]})]]


def _draw_circle(frame: PlaneFrame, circle: CircleArc, data: PlottedData | None) -> None:
    """Draw the maximal inscribed circle with its centre."""
    points = circle.polyline(flatness(*frame.corners))
    frame.line(points, "inscribed-circle", **_CIRCLE)
    centre = np.array([circle.centre])
    frame.line(centre, "inscribed-circle-centre", color=style.INK, zorder=REGION_LEVEL, **_CENTRE)
    size = _CENTRE["markersize"] / style.POINTS_PER_MM
    x, y = (frame.scale * part for part in circle.centre)
    frame.occupied.append(Box(x, y, size, size))
    if data is not None:
        data.add("maximal inscribed circle", points, values=circle.radius)
        data.add("centre of the maximal inscribed circle", centre, values=circle.radius)


def _draw_bands(
    frame: PlaneFrame,
    field: SampledField,
    square: SquareDrawing,
    edges: FloatArray,
    colours: Sequence[Any],
    data: PlottedData | None,
) -> None:
    """Fill what reaches an edge in the square, edge by edge; draw contours and label them."""
    inside = shapely.Polygon(square.corners)
    frame.fill("band-1", [square.corners], FILL_LEVEL, facecolor=colours[0], edgecolor="none")
    texts = edge_texts(edges)
    labelled: dict[str, list[FloatArray]] = {}
    for number in range(1, len(colours)):
        edge = float(edges[number])
        loops = [
            loop
            for outline, *holes in field.polygons(edge)
            for loop in _loops(
                shapely.make_valid(shapely.Polygon(outline, holes)).intersection(inside)
            )
        ]
        look = {"facecolor": colours[number], "edgecolor": "none"}
        frame.fill(f"band-{number + 1}", loops, FILL_LEVEL, **look)
        lines = [
            np.asarray(part.coords)
            for line in field.lines(edge)
            for part in shapely.get_parts(shapely.LineString(line).intersection(inside))
            if isinstance(part, shapely.LineString) and not part.is_empty
        ]
        for place, line in enumerate(lines, start=1):
            look = {"color": style.INK, "linewidth": style.LEVEL_WIDTH}
            frame.line(line, f"contour-{texts[number]}-{place}", **look)
            if data is not None:
                data.add("contour", line, "LCI", "level", edge)
        labelled[texts[number]] = [np.vstack([loop, loop[:1]]) * frame.scale for loop in loops]
    label_contours(frame, labelled, [np.vstack([square.corners, square.corners[:1]]) * frame.scale])


def _loops(shape: shapely.Geometry) -> list[FloatArray]:
    """Return outlines and holes of all polygons of a shape, the first corner not repeated."""
    parts = [part for part in shapely.get_parts(shape) if not part.is_empty]
    polygons = [orient(part) for part in parts if isinstance(part, shapely.Polygon)]
    rings = [ring for polygon in polygons for ring in (polygon.exterior, *polygon.interiors)]
    return [np.asarray(ring.coords)[:-1] for ring in rings]
