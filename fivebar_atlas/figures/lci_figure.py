"""The local conditioning index over a workspace of one design, as labelled contours."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import (
    KeyEntry,
    bar_height,
    draw_bar,
    draw_key_rows,
    key_rows_height,
)
from fivebar_atlas.figures.contour_levels import round_levels
from fivebar_atlas.figures.drawing_area import FILL_LEVEL
from fivebar_atlas.figures.loci_figure import empty_workspace_figure
from fivebar_atlas.figures.overlays import Overlay, draw_overlays, overlay_rows
from fivebar_atlas.figures.plane_frame import (
    PlaneFrame,
    bounds_of,
    bounds_of_arcs,
    flatness,
    plane_frame,
)
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.text_placement import place_along_lines, points_along, text_size
from fivebar_atlas.figures.wording import threshold_text, title_text
from fivebar_atlas.figures.workspace_figure import (
    OUTLINE,
    below_threshold,
    draw_outline,
    fill_region,
)
from fivebar_atlas.level_curves import SampledField
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import FloatArray, Region

# Samples along the longer side of the workspace, from which contours start.
_CELLS = 400
# Bands at most, and those of a map that begins at a threshold.
_BANDS, _BANDS_ABOVE = 10, 6
_LABEL = r"LCI $1/\kappa_J$"
# Labels of one level at most; their distance from other lines, in millimetres; and how far
# apart the points are that stand for those.
_LABELS, _CLEARANCE, _SPACING = 2, 0.5, 1.0


def lci_figure(
    design: PlanarDesign,
    mode: str,
    lci_threshold: float | None = None,
    levels: Sequence[float] | None = None,
    *,
    overlays: Sequence[Overlay] = (),
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the LCI over the usable workspace, or over the part where it reaches a threshold.

    Parameters
    ----------
    design
        The design.
    mode
        The mode pair.
    lci_threshold
        Threshold of the good-condition workspace, above 0 and below 1; None for the whole
        usable workspace.
    levels
        Values of the contours, above 0 and below 1; None for round ones.
    overlays
        Practical workspaces that are drawn into it.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted: contours, boundary, and the samples of the map.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Figs. 14 and 15. Bands end on exact
        points of the level curves and on the exact boundary.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    InputError
        If a threshold, a level or the width is out of range.
    """
    subject = "LCI"
    if lci_threshold is not None and not 0.0 < lci_threshold < 1.0:
        raise InputError("lci_threshold", lci_threshold, "a number above 0 and below 1")
    least = lci_threshold or 0.0
    for level in levels or ():
        if not least < level < 1.0:
            raise InputError("levels", level, f"numbers above {least:g} and below 1")
    workspace = design.usable_workspace(mode)
    if workspace is None:
        return empty_workspace_figure(design, mode, subject, width=width, data=data)
    region = workspace.region
    values = functools.partial(design.lci_inside, mode=mode)
    field = SampledField.over(values, *bounds_of_arcs(region.outline.arcs), _CELLS)
    rows = []
    edges = np.empty(0)
    if field.values.max() <= least:
        rows = [[KeyEntry(below_threshold(design, mode, least), {})]]
    else:
        found = design.largest_lci(mode)
        edges = band_edges(least, 1.0 if found is None else found[0], levels)
    if lci_threshold is not None:
        rows.append([KeyEntry("boundary of the usable workspace", OUTLINE)])
    rows += overlay_rows(overlays)
    drawn = [overlay.closed for overlay in overlays]
    bounds = bounds_of([*bounds_of_arcs(region.outline.arcs), *drawn])
    with styled():
        below = key_rows_height(rows, width) + (bar_height(_LABEL, width) if len(edges) else 0.0)
        parts = [title_text(subject, design, mode)]
        if lci_threshold is not None:
            parts.append(threshold_text(lci_threshold))
        title = ", ".join(parts)
        frame = plane_frame(bounds, design.unit, title, width, below)
        used = 0.0
        if len(edges):
            colours = list(style.colour_map()(np.linspace(0.0, 1.0, len(edges) - 1)))
            if lci_threshold is None:
                fill_region(frame, region, "band-1", facecolor=colours[0], edgecolor="none")
            _draw_bands(frame, field, region, edges, colours, drawn, data)
            used = draw_bar(frame, colours, edge_texts(edges), _LABEL)
        if data is not None:
            _record_samples(field, least, data)
        draw_outline(frame, region.arcs, data)
        draw_overlays(frame, overlays, data)
        draw_key_rows(frame, rows, used)
        return frame.figure


def band_edges(least: float, greatest: float, levels: Sequence[float] | None) -> FloatArray:
    """Return ascending edges of bands that cover the values from the least on."""
    if levels is not None:
        return np.unique([least, *levels, 1.0])
    edges = round_levels(least, greatest, _BANDS_ABOVE if least else _BANDS)
    return np.concatenate([[least], edges[edges > least]])


def edge_texts(edges: FloatArray) -> list[str]:
    """Return edges as text, all with the decimals that one of them needs."""
    decimals = max(len(f"{edge:.6g}".partition(".")[2]) for edge in edges)
    return [f"{edge:.{decimals}f}" for edge in edges]


def _draw_bands(
    frame: PlaneFrame,
    field: SampledField,
    region: Region,
    edges: FloatArray,
    colours: Sequence[Any],
    overlays: Sequence[FloatArray],
    data: PlottedData | None,
) -> None:
    """Fill all that reaches an edge, edge by edge; draw the contours and label them.

    Labels keep off the outlines of overlays.
    """
    texts = edge_texts(edges)
    contours: dict[str, list[FloatArray]] = {}
    for number, (edge, colour) in enumerate(zip(edges, colours, strict=False), start=1):
        if edge == 0.0:  # the whole usable workspace, whose outline is exact
            continue
        loops = [loop for part in field.polygons(edge) for loop in part]
        look = {"facecolor": colour, "edgecolor": "none"}
        frame.fill(f"band-{number}", loops, FILL_LEVEL, **look)
        closed = [np.vstack([loop, loop[:1]]) for loop in loops]
        for place, line in enumerate(closed, start=1):
            look = {"color": style.INK, "linewidth": style.LEVEL_WIDTH}
            frame.line(line, f"contour-{texts[number - 1]}-{place}", **look)
            if data is not None:
                data.add("contour", line, "LCI", "level", edge)
        contours[texts[number - 1]] = [line * frame.scale for line in closed]
    border = [
        np.vstack([loop, loop[:1]]) * frame.scale
        for loop in region.polygons(flatness(*frame.corners))
    ]
    border += [outline * frame.scale for outline in overlays]
    label_contours(frame, contours, border)


def label_contours(
    frame: PlaneFrame, contours: Mapping[str, Sequence[FloatArray]], outline: Sequence[FloatArray]
) -> None:
    """Write the level on its closed contours, where no other contour and no outline is near."""
    dense = {
        text: [points_along(line, _SPACING) for line in lines] for text, lines in contours.items()
    }
    border = [points_along(line, _SPACING) for line in outline]
    for text, lines in dense.items():
        width, height = text_size(text, style.LEVEL_SIZE)
        others = [line for other, some in dense.items() if other != text for line in some]
        near = np.concatenate([*others, *border])
        runs = [run for line in lines for run in _runs_apart(line, near, height / 2.0 + _CLEARANCE)]
        for run in sorted(runs, key=lambda run: -len(run))[:_LABELS]:
            boxes = place_along_lines(
                [run],
                width,
                height,
                outline=frame.outline,
                occupied=frame.occupied,
                avoid=near,
                shun=np.empty((0, 2)),
            )
            for box in boxes:
                frame.write(text, box, style.LEVEL_SIZE, halo=1.4)


def _runs_apart(line: FloatArray, others: FloatArray, distance: float) -> list[FloatArray]:
    """Return the runs of a closed line that keep a distance from other points."""
    (x, y), (other_x, other_y) = line.T, others.T
    squares = (x[:, None] - other_x) ** 2 + (y[:, None] - other_y) ** 2
    apart = squares.min(axis=1) > distance * distance
    if apart.all():
        return [line]
    # begin where a run cannot go on, so that none is cut in two
    start = int(np.argmin(apart))
    line, apart = np.roll(line[:-1], -start, axis=0), np.roll(apart[:-1], -start)
    cuts = np.flatnonzero(np.diff(apart)) + 1
    return [
        run
        for run, is_apart in zip(np.split(line, cuts), np.split(apart, cuts), strict=True)
        if is_apart[0]
    ]


def _record_samples(field: SampledField, least: float, data: PlottedData) -> None:
    """Record the samples that the contours were found from, those above a threshold."""
    x, y = np.meshgrid(field.x, field.y)
    shown = (field.values > 0.0) & (field.values >= least)
    points = np.column_stack([x[shown], y[shown]])
    data.add("sample", points, "LCI", values=field.values[shown])
