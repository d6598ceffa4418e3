"""Contour maps: filled colours between round levels, and lines with their levels on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from fivebar_atlas.figures import style
from fivebar_atlas.figures.chart_frame import ChartFrame, chart_frame, draw_sub_regions
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.colour_bar import (
    KeyEntry,
    bar_height,
    draw_bar,
    draw_key,
    key_height,
    missing_entry,
    missing_look,
)
from fivebar_atlas.figures.contour_levels import level_text, round_levels
from fivebar_atlas.figures.drawing_area import FILL_LEVEL, LINE_LEVEL, MISSING_LEVEL
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.text_placement import place_along_lines, points_along, text_size
from fivebar_atlas.triangulated_regions import outline_of_triangles

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

#: A line longer than this many millimetres carries a second label.
_LABEL_REPEAT = 55.0
#: Values closer than this, relative to their size, are one value.
_ONE_VALUE = 1e-9


def contour_map(
    designs: ChartedDesigns,
    values: FloatArray,
    title: str,
    label: str,
    *,
    missing: str = "no value",
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw a quantity over the design space as labelled contours above filled colours.

    Parameters
    ----------
    designs
        The designs and the chart.
    values
        One value for each design, shape (n,); NaN where there is none.
    title, label
        Title of the figure, and name and unit for the colour bar.
    missing
        What the hatched area means, for the key.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; its first axes are in chart coordinates.

    Raises
    ------
    InputError
        If the width is out of range, or the values are not one for each design.
    """
    designs.check(values)
    absent = absent_triangles(designs, values)
    shown = values[np.unique(designs.triangles[~absent])]
    levels = levels_of(shown)
    key = []
    if len(shown) and not len(levels):
        text = f"{label}: {shown[0]:.6g} everywhere".replace("-", "\N{MINUS SIGN}")
        key.append(KeyEntry(text, {"facecolor": style.colour_map()(0.5), "linewidth": 0.0}))
    if absent.any():
        key.append(missing_entry(missing))
    with styled():
        below = key_height(key, width) + (bar_height(label, width) if len(levels) else 0.0)
        frame = chart_frame(designs.chart, title, width, below)
        draw_missing(frame, designs, absent)
        used = 0.0
        if len(shown) and not len(levels):
            loops = outline_of_triangles(designs.points, designs.triangles, ~absent)
            frame.fill("bands", loops, FILL_LEVEL, **key[0].look)
        if len(levels):
            colours = list(style.colour_map()(np.linspace(0.0, 1.0, len(levels) - 1)))
            fill_between_levels(frame, designs, values, absent, levels, colours)
            draw_levels(frame, designs, values, absent, levels)
            ticks = [level_text(level, levels) for level in levels]
            used = draw_bar(frame, colours, ticks, label)
        draw_key(frame, key, used)
        draw_sub_regions(frame)
        return frame.figure


def absent_triangles(designs: ChartedDesigns, values: FloatArray) -> BoolArray:
    """Return the triangles with a missing value at a vertex, shape (m,)."""
    return np.asarray(~np.isfinite(values[designs.triangles]).all(axis=1))


def levels_of(shown: FloatArray, bands: int = 15) -> FloatArray:
    """Return round levels around values; none where they are all one, or there are none."""
    if len(shown) == 0:
        return np.empty(0)
    least, greatest = float(shown.min()), float(shown.max())
    if greatest - least <= _ONE_VALUE * max(abs(least), abs(greatest)):
        return np.empty(0)
    return round_levels(least, greatest, bands)


def draw_missing(frame: ChartFrame, designs: ChartedDesigns, absent: BoolArray) -> None:
    """Hatch triangles that have no value."""
    loops = outline_of_triangles(designs.points, designs.triangles, absent)
    frame.fill("missing", loops, MISSING_LEVEL, **missing_look())


def fill_between_levels(
    frame: ChartFrame,
    designs: ChartedDesigns,
    values: FloatArray,
    absent: BoolArray,
    levels: FloatArray,
    colours: Sequence[Any],
) -> None:
    """Fill the bands between levels, exact for values linear on the triangles."""
    # A band does not include its upper level, and a rounding error may lead beyond either
    # end: neither must leave a hole.
    inside = np.clip(values, levels[0], levels[-1])
    slack = 1e-9 * (levels[-1] - levels[0])
    edges = np.concatenate([[levels[0] - slack], levels[1:-1], [levels[-1] + slack]])
    filled = frame.axes.tricontourf(
        _triangulation(designs, absent), inside, levels=edges, colors=colours
    )
    filled.set(zorder=FILL_LEVEL, gid="bands")


def draw_levels(
    frame: ChartFrame,
    designs: ChartedDesigns,
    values: FloatArray,
    absent: BoolArray,
    levels: FloatArray,
    name: str = "levels",
    colour: str = style.INK,
    width: float = style.LEVEL_WIDTH,
    dashes: str | tuple[float, tuple[float, ...]] = "solid",
    clear: Sequence[FloatArray] = (),
) -> None:
    """Draw the lines at levels and write the level on each where there is room.

    The lines at the ends of the range of values are left out: on a plateau they would
    only trace rounding errors. The name becomes the ``gid`` of the lines. Labels keep off
    the borders of sub-regions and the closed loops ``clear`` where they can.
    """
    shown = values[np.unique(designs.triangles[~absent])]
    slack = 1e-6 * (levels[-1] - levels[0])
    drawn = levels[(levels > shown.min() + slack) & (levels < shown.max() - slack)]
    if len(drawn) == 0:
        return
    contours = frame.axes.tricontour(
        _triangulation(designs, absent),
        values,
        levels=drawn,
        colors=colour,
        linewidths=width,
        linestyles=[dashes],
    )
    contours.set(zorder=LINE_LEVEL, gid=name)
    lines = [
        [np.asarray(line) * frame.scale for line in path.to_polygons(closed_only=False)]
        for path in contours.get_paths()
    ]
    loops = [np.vstack([loop, loop[:1]]) for loop in clear]
    borders = [points_along(line * frame.scale) for line in (*frame.chart.borders, *loops)]
    for index, level in enumerate(drawn):
        text = level_text(level, levels)
        others = [
            points_along(line) for at, some in enumerate(lines) if at != index for line in some
        ]
        boxes = place_along_lines(
            lines[index],
            *text_size(text, style.LEVEL_SIZE),
            outline=frame.chart.outline * frame.scale,
            occupied=frame.occupied,
            avoid=np.concatenate([*others, np.empty((0, 2))]),
            shun=np.concatenate([*borders, np.empty((0, 2))]),
            repeat=_LABEL_REPEAT,
        )
        for box in boxes:
            frame.write(text, box, style.LEVEL_SIZE, halo=1.4, color=colour)


def _triangulation(designs: ChartedDesigns, absent: BoolArray) -> Triangulation:
    return Triangulation(designs.points[:, 0], designs.points[:, 1], designs.triangles, mask=absent)
