"""Workspaces of one design: the usable workspace, and the part of it in good condition."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.path import Path as MatplotlibPath

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key_rows, key_rows_height
from fivebar_atlas.figures.curves import (
    BACKGROUND_LEVEL,
    draw_arcs,
    kind_entries,
    label_curves,
    marked_points,
)
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL, FILL_LEVEL
from fivebar_atlas.figures.linkage import FINE, draw_linkage, link_points, sample_pose
from fivebar_atlas.figures.loci_figure import empty_workspace_figure
from fivebar_atlas.figures.overlays import Overlay, draw_overlays, overlay_rows
from fivebar_atlas.figures.plane_frame import (
    PlaneFrame,
    bounds_of,
    bounds_of_arcs,
    draw_origin,
    flatness,
    plane_frame,
)
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.wording import (
    area_text,
    length_text,
    point_text,
    threshold_text,
    title_text,
)
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import CircleArc, FloatArray, NamedArc, Point, Region

#: Look of the boundary of a usable workspace where its kinds do not matter.
OUTLINE: dict[str, Any] = {"color": style.INK, "linestyle": "solid", "linewidth": 0.6}

_REGION: dict[str, Any] = {"facecolor": style.WORKSPACE, "edgecolor": "none"}
_GOOD: dict[str, Any] = {"facecolor": style.GOOD_CONDITION, "edgecolor": "none"}
_OTHER_LOCI: dict[str, Any] = {
    "color": style.FAINT,
    "linestyle": (0.0, (1.0, 1.5)),
    "linewidth": 0.6,
}
_CIRCLE: dict[str, Any] = {
    "color": style.INK,
    "linestyle": (0.0, (0.6, 1.6)),
    "linewidth": 0.8,
    "dash_capstyle": "round",
}
_CENTRE: dict[str, Any] = {"marker": "+", "markersize": 4.0, "markeredgewidth": 0.6}
# Points of an arc that tell whether it lies on an outline, and how near is on it.
_SHARES = np.linspace(0.05, 0.95, 7)
_ON_IT = 1e-6


def workspace_figure(
    design: PlanarDesign,
    mode: str,
    *,
    overlays: Sequence[Overlay] = (),
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the usable workspace of a mode pair, what bounds it, and the linkage in it.

    Parameters
    ----------
    design
        The design.
    mode
        The mode pair.
    overlays
        Practical workspaces that are drawn into it.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Figs. 6, 11 and 12(b). Boundary arcs have
        the look of their kind, maximal inscribed circles are dotted; other loci of the mode
        pair are faint. An empty workspace is said to be empty, and the loci are drawn.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    InputError
        If the width is out of range.
    """
    workspace = design.usable_workspace(mode)
    if workspace is None:
        return empty_workspace_figure(design, mode, "Usable workspace", width=width, data=data)
    region = workspace.region
    pose = sample_pose(design, region, mode)
    circles = design.inscribed_circles(mode)
    loci = design.singular_loci(mode)
    others = _off_outline(loci, region)
    area = f"usable workspace, area {area_text(workspace.area, design.unit)}"
    rows = [[KeyEntry(area, {**_REGION, "edgecolor": style.INK, "linewidth": 0.3})]]
    rows += [[entry] for entry in kind_entries(region.arcs)]
    if circles:
        look = {**_CIRCLE, **_CENTRE, "markevery": [1]}
        rows.append([KeyEntry(_circles_text(circles, design.unit), look)])
    if others:
        rows.append([KeyEntry("other singular loci of the mode", _OTHER_LOCI)])
    rows += overlay_rows(overlays)
    marks = marked_points(region.arcs, _points_inside(design, region))
    rows.append([*(mark.entry for mark in marks), KeyEntry(", ".join(design.remarks()), {})])
    joints = np.array([joint.position for joint in pose.joints])
    drawn = [overlay.closed for overlay in overlays]
    bounds = bounds_of([*bounds_of_arcs([*loci, *region.arcs]), joints, *drawn])
    with styled():
        title = title_text("Usable workspace", design, mode)
        frame = plane_frame(bounds, design.unit, title, width, key_rows_height(rows, width))
        draw_origin(frame)
        fill_region(frame, region, "usable-workspace", **_REGION)
        draw_arcs(frame, others, "locus", data, **_OTHER_LOCI, zorder=BACKGROUND_LEVEL)
        draw_arcs(frame, region.arcs, "boundary of the usable workspace", data)
        for mark in marks:
            mark.draw(frame, data)
        lines = [link_points(pose, link.start, link.end) for link in pose.links]
        for number, circle in enumerate(circles, start=1):
            lines.append(_draw_circle(frame, circle, number, data))
        draw_overlays(frame, overlays, data)
        draw_linkage(frame, pose, FINE, data)
        label_curves(frame, region.arcs, [*lines, *drawn])
        draw_key_rows(frame, rows)
        return frame.figure


def good_condition_figure(
    design: PlanarDesign,
    mode: str,
    lci_threshold: float,
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the part of the usable workspace in which the LCI reaches a threshold.

    Parameters
    ----------
    design
        The design.
    mode
        The mode pair.
    lci_threshold
        The threshold, above 0 and below 1.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Fig. 13. Where nothing reaches the
        threshold the key says so, and how large the LCI becomes.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    InputError
        If the threshold or the width is out of range.
    """
    parts = design.good_condition_workspace(lci_threshold, mode)
    workspace = design.usable_workspace(mode)
    subject = "Good-condition workspace"
    if workspace is None:
        return empty_workspace_figure(design, mode, subject, width=width, data=data)
    edge = {"edgecolor": style.INK, "linewidth": 0.3}
    area = f"usable workspace, area {area_text(workspace.area, design.unit)}"
    rows = [[KeyEntry(area, {**_REGION, **edge})]]
    if parts:
        good_area = area_text(sum(part.area for part in parts), design.unit)
        together = f" in {len(parts)} parts" if len(parts) > 1 else ""
        text = f"{threshold_text(lci_threshold)}, area {good_area}{together}"
        rows.append([KeyEntry(text, {**_GOOD, **edge})])
    else:
        rows.append([KeyEntry(below_threshold(design, mode, lci_threshold), {})])
    with styled():
        title = title_text(subject, design, mode)
        bounds = bounds_of_arcs(workspace.region.outline.arcs)
        frame = plane_frame(bounds, design.unit, title, width, key_rows_height(rows, width))
        fill_region(frame, workspace.region, "usable-workspace", **_REGION)
        for number, part in enumerate(parts, start=1):
            fill_region(frame, part, f"good-condition-{number}", **_GOOD)
        draw_origin(frame)
        draw_outline(frame, workspace.region.arcs, data)
        for part in parts:
            name = "boundary of the good-condition workspace"
            draw_arcs(frame, part.arcs, name, data, linewidth=0.7)
        draw_key_rows(frame, rows)
        return frame.figure


def _points_inside(design: PlanarDesign, region: Region) -> list[Point]:
    """Return the isolated singular points that lie in a workspace or on its boundary."""
    points = design.isolated_singular_points()
    if not points:
        return []
    outline, *holes = region.polygons(flatness(*bounds_of_arcs(region.outline.arcs)))
    return [
        point
        for point in points
        if MatplotlibPath(outline).contains_point(point)
        and not any(MatplotlibPath(hole).contains_point(point) for hole in holes)
    ]


def fill_region(frame: PlaneFrame, region: Region, name: str, **look: Any) -> None:
    """Fill a region, its holes left out; the name becomes the ``gid`` of the patch."""
    frame.fill(name, region.polygons(flatness(*frame.corners)), FILL_LEVEL, **look)


def draw_outline(
    frame: PlaneFrame, arcs: Sequence[NamedArc], data: PlottedData | None = None
) -> None:
    """Draw the boundary of a usable workspace as a thin line."""
    name = "boundary of the usable workspace"
    draw_arcs(frame, arcs, name, data, **OUTLINE, zorder=BORDER_LEVEL)


def below_threshold(design: PlanarDesign, mode: str, lci_threshold: float) -> str:
    """Return in words that nothing to draw reaches a threshold, and what the largest LCI is."""
    found = design.largest_lci(mode)
    largest = 0.0 if found is None else found[0]
    condition, value = threshold_text(lci_threshold), f"the largest LCI is {largest:.6g}"
    if largest < lci_threshold:
        return f"no point has {condition}; {value}"
    return f"the parts with {condition} are too small to be drawn; {value}"


def _off_outline(loci: Sequence[NamedArc], region: Region) -> list[NamedArc]:
    """Return the loci that do not lie on the boundary of a region throughout."""
    points = [each.arc.points(_SHARES) for each in loci]
    if not points:
        return []
    gaps = region.boundary_distance(np.concatenate(points))[0].reshape(len(loci), -1)
    near = _ON_IT * float(np.abs(points).max())
    return [each for each, gap in zip(loci, gaps, strict=True) if gap.max() > near]


def _circles_text(circles: Sequence[CircleArc], unit: str) -> str:
    """Return radii and centres of circles in words."""
    single = [
        f"radius {length_text(circle.radius, unit)} at {point_text(circle.centre, unit)}".replace(
            " ", "\N{NO-BREAK SPACE}"
        )
        for circle in circles
    ]
    return f"inscribed circle{'s' * (len(circles) > 1)}: {'; '.join(single)}"


def _draw_circle(
    frame: PlaneFrame, circle: CircleArc, number: int, data: PlottedData | None
) -> FloatArray:
    """Draw a circle with its centre; return its points."""
    points = circle.polyline(flatness(*frame.corners))
    frame.line(points, f"inscribed-circle-{number}", **_CIRCLE)
    frame.line(
        np.array([circle.centre]), f"inscribed-circle-centre-{number}", color=style.INK, **_CENTRE
    )
    if data is not None:
        data.add("maximal inscribed circle", points, values=circle.radius)
        data.add("centre of the maximal inscribed circle", [circle.centre], values=circle.radius)
    return points
