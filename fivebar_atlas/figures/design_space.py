"""The design space itself: its outline, its parameters' lines and its sub-regions."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.chart_frame import chart_frame, draw_sub_regions
from fivebar_atlas.figures.drawing_area import FILL_LEVEL, LINE_LEVEL
from fivebar_atlas.figures.style import styled
from fivebar_atlas.mechanisms.charts import ChartRegion, ChartTick, DesignChart
from fivebar_atlas.triangulated_regions import region_where

FloatArray = npt.NDArray[np.float64]

_GRID = "#8c8c8c"
_BOTTOM = 1.0


def design_space_figure(
    chart: DesignChart, title: str, *, width: float = style.COLUMN_WIDTH
) -> Figure:
    """Draw a design space with the lines of constant parameters and its sub-regions.

    Parameters
    ----------
    chart
        How the design space is drawn.
    title
        Title of the figure.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Fig. 2(b).

    Raises
    ------
    InputError
        If the width is out of range.
    """
    with styled():
        frame = chart_frame(chart, title, width, _BOTTOM)
        colours = style.category_colours(len(chart.regions))
        for region, colour in zip(chart.regions, colours, strict=True):
            loops = region_loops(chart, region)
            frame.fill(region.name, loops, FILL_LEVEL, facecolor=colour, linewidth=0.0)
        lines = [
            line
            for axis in chart.axes
            for tick in axis.ticks
            if (line := constant_line(chart, tick)) is not None
        ]
        frame.axes.add_collection(
            LineCollection(lines, colors=_GRID, linewidths=0.35, zorder=LINE_LEVEL),
            autolim=False,
        )
        draw_sub_regions(frame)
        return frame.figure


def constant_line(chart: DesignChart, tick: ChartTick) -> FloatArray | None:
    """Return the line on which a tick's parameter is constant, shape (2, 2).

    It runs from the tick's foot against the tick's direction to the other side of the
    outline; None where it only touches the outline.
    """
    foot = np.array([tick.x, tick.y])
    inward = -np.array([tick.dx, tick.dy])
    starts = chart.outline
    sides = np.roll(starts, -1, axis=0) - starts
    # foot + t inward = start + u side, solved for t and u by cross products.
    determinant = inward[0] * sides[:, 1] - inward[1] * sides[:, 0]
    offset = starts - foot
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (offset[:, 0] * sides[:, 1] - offset[:, 1] * sides[:, 0]) / determinant
        u = (offset[:, 0] * inward[1] - offset[:, 1] * inward[0]) / determinant
    slack = 1e-9
    crossed = (np.abs(determinant) > slack) & (u > -slack) & (u < 1.0 + slack) & (t > slack)
    if not crossed.any():
        return None
    return np.stack([foot, foot + t[crossed].max() * inward])


def region_loops(chart: DesignChart, region: ChartRegion) -> tuple[FloatArray, ...]:
    """Return the outline of a sub-region: the side of every straight border its name is on.

    A border of several pieces does not bound a region here; the outline is convex.
    """
    corners = chart.outline
    fan = np.array([[0, index, index + 1] for index in range(1, len(corners) - 1)])
    name = np.array([region.x, region.y])
    margins = []
    for border in chart.borders:
        if len(border) != 2:
            continue
        start, along = border[0], border[1] - border[0]
        sides = [
            along[0] * (point[1] - start[1]) - along[1] * (point[0] - start[0])
            for point in (*corners, name)
        ]
        margins.append(np.sign(sides[-1]) * np.array(sides[:-1]))
    return region_where(corners, fan, np.array(margins).reshape(-1, len(corners))).loops
