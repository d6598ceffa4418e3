"""Atlases of small drawings: singular loci or usable workspaces all over a design space.

Every drawing has its origin at the place of its design and the same scale, the largest at
which no two touch. Drawings stand on the borders of the sub-regions and reach beyond the edge
of the design space; the outline that bears the ticks goes around them all.

Distances between drawings come from their extents in many directions: two convex sets are
apart if and only if in some direction their extents towards each other sum to less than the
distance between their places.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon
from matplotlib.path import Path

from fivebar_atlas.figures import style
from fivebar_atlas.figures.chart_frame import ChartFrame, chart_frame, draw_sub_regions
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key, key_height
from fivebar_atlas.figures.curves import kind_entries, marked_points
from fivebar_atlas.figures.design_cells import DesignCell
from fivebar_atlas.figures.design_space import region_loops
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.text_placement import Box, text_size
from fivebar_atlas.mechanisms.charts import ChartAxis, ChartRegion, DesignChart

FloatArray = npt.NDArray[np.float64]

#: Width of two journal columns in millimetres.
TWO_COLUMNS = 170.0

# Order of drawing, between the borders of sub-regions and text.
_PAPER, _SHAPE, _CURVE = BORDER_LEVEL + 0.2, BORDER_LEVEL + 0.4, BORDER_LEVEL + 0.6
# Shares of the distance between neighbouring designs: room between drawings, size of the mark
# of an empty one, room between drawings and outline.
_GAP, _MARK, _MARGIN = 0.05, 0.12, 0.08
# A drawing is never larger than the design space is drawn itself.
_LARGEST_SCALE = 1.0
# Directions in which extents are compared; even, so that each has its opposite.
_DIRECTIONS = 180
# Line width in points: a share of the millimetres between designs, and its bounds.
_LINE_SHARE, _LINE_RANGE = 0.05, (0.15, 0.6)
# Millimetres on paper.
_BAR_ROW, _BAR_CAP, _BAR_GAP = 4.0, 0.9, 1.5
_NAME_GAP, _NAME_STEP = 0.5, 0.25
# Font sizes of the names of sub-regions, until there is room.
_NAME_SIZES = (style.REGION_SIZE, 7.0, 6.0)
# What covering a line costs, and a millimetre away from where the name should be, in mm² of a
# drawing covered.
_LINE_COST, _WAY_COST = 0.2, 0.1


def cell_atlas(
    chart: DesignChart,
    cells: Sequence[DesignCell],
    title: str,
    *,
    width: float = TWO_COLUMNS,
) -> Figure:
    """Draw small drawings of designs at their places in the design space.

    Parameters
    ----------
    chart
        How the design space is drawn.
    cells
        The drawings. Closed boundaries are shaded, holes left white; a drawing without lines
        becomes a cross.
    title
        Title of the figure.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Figs. 4, 5 and 7. Below stand the key, the
        scale and the number of designs. The ``gid`` of the shape of a drawing is
        ``"cell-1"`` and so on, that of its lines of one kind ``"cell-1-serial"``.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    layout = _layout(chart, cells)
    entries = _key(cells)
    with styled():
        key = key_height(entries, width)
        frame = chart_frame(layout.chart, title, width, key + _BAR_ROW)
        _draw_edge(frame, chart)
        draw_sub_regions(frame)
        for number, (cell, hull) in enumerate(zip(cells, layout.hulls, strict=True), start=1):
            _draw_cell(frame, number, cell, hull, layout)
        _write_names(frame, chart, cells, layout)
        draw_key(frame, entries, 0.0)
        _draw_scale_bar(frame, key, layout.scale * frame.scale, len(cells))
        return frame.figure


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Layout:
    """Where drawings go: all in chart coordinates.

    Attributes
    ----------
    scale
        Length in the chart that a length of 1 has in a drawing.
    spacing
        Least distance between two designs.
    hulls
        For each drawing a convex polygon around it, shape (k, 2).
    chart
        The chart with an outline, ticks and axis labels that go around all drawings, and
        without names of sub-regions.
    """

    scale: float
    spacing: float
    hulls: tuple[FloatArray, ...]
    chart: DesignChart


def _layout(chart: DesignChart, cells: Sequence[DesignCell]) -> _Layout:
    places = np.array([cell.place for cell in cells])
    turns = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    directions = np.column_stack([np.cos(turns), np.sin(turns)])
    spacing = _least_distance(places)
    extents = np.array([_extents(cell.points, directions) for cell in cells])
    marks = np.array([0.0 if cell.lines else 0.5 * _MARK * spacing for cell in cells])
    scale = _largest_scale(places, extents, marks, _GAP * spacing, directions)
    reaches = scale * extents + marks[:, np.newaxis]
    hulls = tuple(
        place + _polygon(reach, directions) for place, reach in zip(places, reaches, strict=True)
    )
    return _Layout(scale, spacing, hulls, _moved_out(chart, hulls, _MARGIN * spacing))


def _least_distance(places: FloatArray) -> float:
    gaps = np.hypot(*(places[:, np.newaxis] - places[np.newaxis]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)
    return float(gaps.min())


def _extents(points: FloatArray, directions: FloatArray) -> FloatArray:
    """Return how far points reach from the origin in each direction; 0 where there are none."""
    if not len(points):
        return np.zeros(len(directions))
    farthest: FloatArray = (points @ directions.T).max(axis=0)
    return farthest


def _largest_scale(
    places: FloatArray, extents: FloatArray, marks: FloatArray, gap: float, directions: FloatArray
) -> float:
    """Return the largest scale at which all drawings are a gap apart.

    Those at p and q are if (p - q)·u ≥ gap + scale (extent of one along u + extent of the other
    against u) for some direction u; marks of empty drawings do not scale.
    """
    against = np.roll(extents, -(len(directions) // 2), axis=1)
    scale = _LARGEST_SCALE
    for number in range(1, len(places)):
        rooms = (places[:number] - places[number]) @ directions.T
        rooms -= gap + marks[number] + marks[:number, np.newaxis]
        needs = extents[number] + against[:number]
        with np.errstate(divide="ignore", invalid="ignore"):
            possible = np.where(rooms > 0.0, rooms / needs, 0.0)
        scale = min(scale, float(possible.max(axis=1).min()))
    return scale


def _polygon(extents: FloatArray, directions: FloatArray) -> FloatArray:
    """Return the convex polygon with these extents: where neighbouring tangents meet."""
    following, beyond = np.roll(directions, -1, axis=0), np.roll(extents, -1)
    sine = directions[:, 0] * following[:, 1] - directions[:, 1] * following[:, 0]
    return np.column_stack(
        [
            (extents * following[:, 1] - beyond * directions[:, 1]) / sine,
            (beyond * directions[:, 0] - extents * following[:, 0]) / sine,
        ]
    )


def _moved_out(chart: DesignChart, hulls: Sequence[FloatArray], margin: float) -> DesignChart:
    """Return a chart with its outline, ticks and axis labels outside of drawings.

    The sides of the outline move outward, and its corners are cut off. Ticks move along their
    own direction, on which their parameter is constant, labels perpendicular to their side.
    """
    corners = chart.outline
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([sides[:, 1], -sides[:, 0]]) / np.hypot(*sides.T)[:, np.newaxis]
    bisectors = normals + np.roll(normals, 1, axis=0)
    bisectors /= np.hypot(*bisectors.T)[:, np.newaxis]
    directions = np.stack([bisectors, normals], axis=1).reshape(-1, 2)
    around = _extents(np.concatenate([corners, *hulls]), directions) + margin

    def way_out(start: FloatArray, direction: FloatArray) -> FloatArray:
        slope = directions @ direction
        ahead = slope > 0.0
        ways = (around[ahead] - directions[ahead] @ start) / slope[ahead]
        ending: FloatArray = start + ways.min() * direction
        return ending

    def moved(axis: ChartAxis) -> ChartAxis:
        label = np.array([axis.label_x, axis.label_y])
        beyond = ((label - corners) * normals).sum(axis=1)
        side = int(np.argmax(beyond))
        foot = label - beyond[side] * normals[side]
        label = way_out(foot, normals[side]) + beyond[side] * normals[side]
        ticks = []
        for tick in axis.ticks:
            x, y = way_out(np.array([tick.x, tick.y]), np.array([tick.dx, tick.dy]))
            ticks.append(dataclasses.replace(tick, x=float(x), y=float(y)))
        return dataclasses.replace(
            axis, label_x=float(label[0]), label_y=float(label[1]), ticks=tuple(ticks)
        )

    return dataclasses.replace(
        chart,
        outline=_polygon(around, directions),
        axes=tuple(moved(axis) for axis in chart.axes),
        regions=(),
    )


def _key(cells: Sequence[DesignCell]) -> list[KeyEntry]:
    """Return the entries for what occurs in the drawings."""
    arcs = {line.arc.name: line.arc for cell in cells for line in cell.lines if line.arc}
    entries = kind_entries(arcs[name] for name in sorted(arcs))
    if any(cell.loops for cell in cells):
        look = {"facecolor": style.WORKSPACE, "edgecolor": style.INK, "linewidth": 0.3}
        entries.insert(0, KeyEntry("usable workspace", look))
    entries += [mark.entry for mark in marked_points((), _isolated_points(cells))]
    if not all(cell.lines for cell in cells):
        has_workspaces = any(cell.loops for cell in cells)
        text = "usable workspace empty" if has_workspaces else "no locus bounds a workspace"
        entries.append(KeyEntry(text, _cross(3.0) | {"markevery": [1]}))
    return entries


def _isolated_points(cells: Sequence[DesignCell]) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for cell in cells for x, y in cell.isolated_points]


def _cross(size: float) -> dict[str, Any]:
    """Return the look of the mark of an empty workspace."""
    return {
        "linestyle": "none",
        "marker": "x",
        "markersize": size,
        "markeredgewidth": 0.6,
        "color": style.INK,
    }


def _draw_edge(frame: ChartFrame, chart: DesignChart) -> None:
    """Draw the edge of the design space; make the outline that bears the ticks faint."""
    (outline,) = (patch for patch in frame.axes.patches if patch.get_gid() == "outline")
    outline.set(linewidth=0.4, edgecolor=style.FAINT)
    frame.axes.add_patch(
        Polygon(
            chart.outline,
            closed=True,
            fill=False,
            edgecolor=style.INK,
            linewidth=style.OUTLINE_WIDTH,
            joinstyle="round",
            zorder=BORDER_LEVEL,
            gid="edge",
        )
    )


def _draw_cell(
    frame: ChartFrame, number: int, cell: DesignCell, hull: FloatArray, layout: _Layout
) -> None:
    """Draw one cell on white paper of its own, so that borders do not run through it."""
    spacing = layout.spacing * frame.scale
    if not cell.lines:
        frame.fill(f"paper-{number}", [hull], _PAPER, facecolor="white", linewidth=0.0)
        size = _MARK * spacing * style.POINTS_PER_MM
        frame.axes.plot(*cell.place, gid=f"cell-{number}", zorder=_CURVE, **_cross(size))
        return
    loops = [cell.place + layout.scale * loop for loop in cell.loops]
    frame.fill(f"paper-{number}", [*loops, hull][:1], _PAPER, facecolor="white", linewidth=0.0)
    frame.fill(f"cell-{number}", loops, _SHAPE, facecolor=style.WORKSPACE, linewidth=0.0)
    width = float(np.clip(_LINE_SHARE * spacing, *_LINE_RANGE))
    for kind in dict.fromkeys(line.arc.kind for line in cell.lines if line.arc):
        lines = [cell.place + layout.scale * line for line in cell.lines_of(kind)]
        codes = [[Path.MOVETO, *[Path.LINETO] * (len(line) - 1)] for line in lines]
        look = {**style.curve_look(kind), "linewidth": width}
        path = Path(np.concatenate(lines), np.concatenate(codes))
        name = f"cell-{number}-{kind}".replace(", ", "-")
        frame.axes.add_artist(PathPatch(path, fill=False, zorder=_CURVE, gid=name, **look))
    points = cell.place + layout.scale * cell.isolated_points
    for mark in marked_points((), [(float(x), float(y)) for x, y in points]):
        look = {**mark.look, "markersize": 2.5 * width, "zorder": _CURVE}
        frame.axes.plot(*points.T, gid=f"cell-{number}-isolated", **look)


def _write_names(
    frame: ChartFrame, chart: DesignChart, cells: Sequence[DesignCell], layout: _Layout
) -> None:
    """Write the names of sub-regions, if possible between the drawings.

    All have one size: the largest at which none covers anything, or else the smallest.
    """
    corner, taken = _taken(frame, cells, layout)
    for size in _NAME_SIZES:
        found = [_free_box(frame, chart, region, size, corner, taken) for region in chart.regions]
        if all(covered == 0.0 for _, covered in found):
            break
    for region, (box, _) in zip(chart.regions, found, strict=True):
        frame.write(region.name, box, size, halo=2.2, fontweight="bold")


def _taken(
    frame: ChartFrame, cells: Sequence[DesignCell], layout: _Layout
) -> tuple[FloatArray, FloatArray]:
    """Return a grid of what drawings take, in millimetres: its corner and its running sums.

    The entry (i, k) of the sums is what is taken left of column i and below row k.
    """
    outline = layout.chart.outline * frame.scale
    corner = outline.min(axis=0)
    columns, rows = np.ceil((outline.max(axis=0) - corner) / _NAME_STEP).astype(int) + 1
    taken = np.zeros((columns, rows))
    for cell, hull in zip(cells, layout.hulls, strict=True):
        around = (hull * frame.scale - corner) / _NAME_STEP
        (left, low), (right, high) = around.min(axis=0).astype(int), around.max(axis=0).astype(int)
        x, y = np.mgrid[left : right + 1, low : high + 1]
        middles = np.column_stack([x.ravel(), y.ravel()]) + 0.5
        inside = Path(around).contains_points(middles).reshape(x.shape)
        taken[left : right + 1, low : high + 1][inside] = _NAME_STEP**2
        points = (cell.place + layout.scale * cell.points) * frame.scale
        lines = np.unique(((points - corner) / _NAME_STEP).astype(int), axis=0)
        taken[lines[:, 0], lines[:, 1]] += _LINE_COST
    return corner, np.pad(taken.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))


def _free_box(
    frame: ChartFrame,
    chart: DesignChart,
    region: ChartRegion,
    size: float,
    corner: FloatArray,
    taken: FloatArray,
) -> tuple[Box, float]:
    """Return the place in a sub-region where its name covers least, and how much it covers."""
    width, height = text_size(region.name, size)
    place = np.array([region.x, region.y]) * frame.scale
    room = np.ceil((np.array([width, height]) + 2.0 * _NAME_GAP) / _NAME_STEP).astype(int)
    columns, rows = taken.shape
    i, k = np.mgrid[: columns - room[0], : rows - room[1]]
    covered = (
        taken[room[0] :, room[1] :]
        - taken[: -room[0], room[1] :]
        - taken[room[0] :, : -room[1]]
        + taken[: -room[0], : -room[1]]
    ).round(9)
    middles = corner + _NAME_STEP * (np.stack([i, k], axis=-1) + room / 2.0)
    cost = covered + _WAY_COST * np.hypot(*(middles - place).transpose(2, 0, 1))
    (loop,) = region_loops(chart, region)
    within = Path(loop * frame.scale)
    for offset in Box(0.0, 0.0, *(room * _NAME_STEP)).corners():
        inside = within.contains_points((middles + offset).reshape(-1, 2)).reshape(i.shape)
        cost = np.where(inside, cost, np.inf)
    best = np.unravel_index(np.argmin(cost), cost.shape)
    x, y = middles[best] if np.isfinite(cost[best]) else place
    return Box(float(x), float(y), width, height), float(covered[best])


def _draw_scale_bar(frame: ChartFrame, below: float, length: float, count: int) -> None:
    """Draw how long a length of 1 is in every drawing, below the key."""
    axes = frame.add_strip(0.0, below, frame.width, _BAR_ROW)
    axes.set_label("scale bar")
    axes.set_axis_off()
    axes.set_xlim(0, frame.width)
    axes.set_ylim(-_BAR_ROW, 0)
    text = f"length $D$ in every drawing; {count} designs"
    used = length + _BAR_GAP + text_size(text, style.NOTE_SIZE)[0]
    x, y = (frame.width - used) / 2, -0.5 * _BAR_ROW
    axes.plot(
        [x, x, x, x + length, x + length, x + length],
        [y - _BAR_CAP, y + _BAR_CAP, y, y, y + _BAR_CAP, y - _BAR_CAP],
        color=style.INK,
        linewidth=0.6,
        gid="scale-bar",
    )
    axes.text(
        x + length + _BAR_GAP,
        y - 0.85,
        text,
        fontsize=style.NOTE_SIZE,
        ha="left",
        va="baseline",
        color=style.INK,
    )
