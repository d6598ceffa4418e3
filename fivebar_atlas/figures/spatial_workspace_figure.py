"""The workspace of a mechanism in space at a fixed orientation: plane sections, or its surface."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key_rows, key_rows_height
from fivebar_atlas.figures.curves import draw_arcs, kind_entries, label_curves
from fivebar_atlas.figures.drawing_area import FILL_LEVEL
from fivebar_atlas.figures.linkage import LINKAGE_LEVEL
from fivebar_atlas.figures.oblique_view import ObliqueView
from fivebar_atlas.figures.plane_frame import PlaneFrame, bounds_of, draw_origin, plane_frames
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.spatial_frame import bounds_on_paper, spatial_frame
from fivebar_atlas.figures.spatial_linkage_figure import (
    DEFAULT_AZIMUTH,
    DEFAULT_ELEVATION,
    draw_mechanism,
    title_of,
)
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.wording import coordinate_label, escaped, number_text, scientific_text
from fivebar_atlas.mechanisms.spatial import Limit, SpatialDesign
from fivebar_atlas.planar_geometry import FloatArray, NamedArc, PolylineArc
from fivebar_atlas.spatial_workspace import AXES, Orientation, Outline, Section, Surface

_REGION: dict[str, Any] = {"facecolor": style.WORKSPACE, "edgecolor": "none"}
# Panels side by side, and the narrowest one in millimetres.
_MOST_COLUMNS, _NARROWEST = 3, 38.0
# From where light falls, in the axes of the base, and how dark the far side is.
_LIGHT, _SHADE = np.array([-0.4, -0.5, 0.77]), 0.55
# A surface of more triangles than this is stored as an image in PDF and SVG files.
_MOST_TRIANGLES = 20_000


def section_figure(
    design: SpatialDesign,
    sections: Sequence[Section],
    orientation: Orientation = (0.0, 0.0),
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw plane sections of a workspace side by side, and what bounds them.

    Parameters
    ----------
    design
        The design.
    sections
        Sections across one axis, at least one.
    orientation
        The two angles that are fixed, in radians.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted; points of space.

    Returns
    -------
    matplotlib.figure.Figure
        The figure. The outline has a colour for each kind of limit.

    Raises
    ------
    InputError
        If the width is out of range, there is no section, or they are across several axes.
    """
    axes = sorted({section.axis for section in sections})
    if len(axes) != 1:
        names = ", ".join(AXES[axis] for axis in axes) or "none"
        raise InputError("section", names, "sections across one axis: x, y or z")
    first, second = sections[0].plane
    corners = [each.corners for section in sections for each in section.outlines]
    home = np.array([[design.home[first], design.home[second]]])
    bounds = bounds_of([*corners, home] if corners else [_empty_bounds(design, first, second)])
    arcs = [_arcs(design.limits, section.outlines) for section in sections]
    together = [arc for each in arcs for arc in each]
    rows = [[entry] for entry in kind_entries(together)]
    rows.append([KeyEntry(_orientation_text(design, orientation), {})])
    columns = max(1, min(len(sections), _MOST_COLUMNS, int((width - 12.0) / _NARROWEST)))
    symbols = [coordinate.symbol for coordinate in design.coordinates]
    labels = (
        coordinate_label(symbols[first], design.unit),
        coordinate_label(symbols[second], design.unit),
    )
    with styled():
        frames = plane_frames(
            bounds,
            design.unit,
            title_of(design, "Workspace sections"),
            [_caption(design, section) for section in sections],
            columns,
            width,
            key_rows_height(rows, width),
            _with_units(labels, design),
        )
        for frame, section, bounding in zip(frames, sections, arcs, strict=True):
            draw_origin(frame)
            frame.fill(
                "workspace", [each.corners for each in section.outlines], FILL_LEVEL, **_REGION
            )
            _record(data, section, bounding)
            draw_arcs(frame, bounding, "boundary")
            label_curves(frame, bounding)
        draw_key_rows(frames[0], rows)
        return frames[0].figure


def surface_figure(
    design: SpatialDesign,
    surface: Surface,
    orientation: Orientation = (0.0, 0.0),
    *,
    view: ObliqueView | None = None,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the boundary of a workspace as a surface above the mechanism's base.

    Parameters
    ----------
    design
        The design.
    surface
        The surface, in the positions of the platform's origin.
    orientation
        The two angles that are fixed, in radians.
    view
        From where it is seen.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted: the corners of every triangle, points of space.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, in parallel projection. Triangles have the colour of the limit that bounds the
        workspace there.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    view = view or ObliqueView(DEFAULT_ELEVATION, DEFAULT_AZIMUTH)
    pose = design.pose(design.home)
    corners = surface.vertices[surface.faces]
    limits = [design.limits[number] for number in np.unique(surface.limits).tolist()]
    shown = np.vstack([surface.vertices, pose.points])
    rows = [[entry] for entry in _limit_entries(limits)]
    rows.append([KeyEntry(_orientation_text(design, orientation), {})])
    cube = f"{escaped(design.unit)}$^3$" if design.unit else "$H^3$"
    volume = f"volume of the polyhedron {scientific_text(surface.volume)} {cube}"
    rows.append([KeyEntry(volume.replace(" ", "\N{NO-BREAK SPACE}"), {})])
    with styled():
        frame = spatial_frame(
            bounds_on_paper(view.project(shown)),
            design.unit,
            title_of(design, "Workspace"),
            width,
            key_rows_height(rows, width),
        )
        draw_mechanism(frame, view, pose, data)
        _draw_triangles(frame, view, design.limits, surface, corners)
        if data is not None:
            for triangle, limit in zip(corners, surface.limits.tolist(), strict=True):
                each = design.limits[limit]
                data.add("workspace surface", triangle, each.name, each.kind)
        draw_key_rows(frame, rows)
        return frame.figure


def _draw_triangles(
    frame: PlaneFrame,
    view: ObliqueView,
    limits: Sequence[Limit],
    surface: Surface,
    corners: FloatArray,
) -> None:
    """Draw the triangles that face the viewer, those behind first."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    is_seen = (view.depth(normals) > 0.0) & (lengths > 0.0)
    order = np.flatnonzero(is_seen)
    order = order[np.argsort(view.depth(corners[order].mean(axis=1)), kind="stable")]
    light = _LIGHT / np.linalg.norm(_LIGHT)
    brightness = 0.5 + 0.5 * (normals[order] / lengths[order, None]) @ light
    colours = np.array([to_rgb(_colour(limits[k].kind)) for k in surface.limits[order].tolist()])
    # towards white in the light, towards the colour itself in the shade
    share = (_SHADE * brightness + 0.15)[:, None]
    faces = colours + share * (1.0 - colours)
    drawn = PolyCollection(
        list(view.project(corners[order])),
        facecolors=faces,
        edgecolors=faces,
        linewidths=0.3,
        zorder=LINKAGE_LEVEL + 0.9,
        rasterized=len(order) > _MOST_TRIANGLES,
    )
    drawn.set_gid("workspace-surface")
    frame.axes.add_collection(drawn, autolim=False)


def _arcs(limits: Sequence[Limit], outlines: Iterable[Outline]) -> list[NamedArc]:
    """Return outlines as arcs, one for each run of sides with the same limit."""
    found = []
    for outline in outlines:
        count = len(outline.corners)
        changes = np.flatnonzero(outline.limits != np.roll(outline.limits, 1))
        starts = changes.tolist() or [0]
        for start, stop in zip(starts, [*starts[1:], starts[0] + count], strict=True):
            places = np.arange(start, stop + 1) % count
            limit = limits[int(outline.limits[start])]
            arc = PolylineArc(outline.corners[places])
            found.append(NamedArc(limit.name, limit.symbol, limit.kind, arc))
    return found


def _limit_entries(limits: Sequence[Limit]) -> list[KeyEntry]:
    """Return one entry of the key for each kind of limit."""
    symbols: dict[str, list[str]] = {}
    for limit in limits:
        symbols.setdefault(limit.kind, []).append(limit.symbol)
    return [
        KeyEntry(
            f"{kind}: {', '.join(of_kind)}",
            {"facecolor": style.mixed_with_white(_colour(kind), 0.4), "edgecolor": "none"},
        )
        for kind, of_kind in symbols.items()
    ]


def _colour(kind: str) -> Any:
    return style.curve_look(kind)["color"]


def _record(data: PlottedData | None, section: Section, arcs: Sequence[NamedArc]) -> None:
    """Record the outlines of a section as points of space."""
    if data is None:
        return
    for each in arcs:
        flat = each.arc.polyline(math.inf)
        points = np.full((len(flat), 3), section.value)
        points[:, list(section.plane)] = flat
        data.add("boundary", points, each.name, each.kind)


def _caption(design: SpatialDesign, section: Section) -> list[str]:
    """Return where a section is, and its area."""
    symbol = design.coordinates[section.axis].symbol
    unit = f" {escaped(design.unit)}" if design.unit else ""
    place = f"{symbol} = {number_text(section.value)}{unit}"
    if not section.outlines:
        return [place, "empty"]
    square = f" {escaped(design.unit)}$^2$" if design.unit else " $H^2$"
    return [place, f"area {scientific_text(section.area)}{square}"]


def _orientation_text(design: SpatialDesign, orientation: Orientation) -> str:
    """Return which angles are fixed and which follows."""
    free, *fixed = (each.symbol for each in design.coordinates if each.is_angle)
    angles = ", ".join(
        f"{symbol} = {number_text(math.degrees(angle))}°".replace(" ", "\N{NO-BREAK SPACE}")
        for symbol, angle in zip(fixed, orientation, strict=True)
    )
    return f"{angles}; {free} follows from the revolute joint"


def _with_units(labels: tuple[str, str], design: SpatialDesign) -> tuple[str, str]:
    """Return axis labels, in units of H where they are non-dimensional."""
    if design.unit:
        return labels
    first, second = (label.replace("$D$", "$H$") for label in labels)
    return first, second


def _empty_bounds(design: SpatialDesign, first: int, second: int) -> FloatArray:
    """Return the corners of a box to draw where every section is empty."""
    lower, upper = design.reach()
    return np.array([lower[[first, second]], upper[[first, second]]])
