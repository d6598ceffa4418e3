"""The frame of every atlas figure: outline, axes with ticks, title, room for what is below.

The drawing area covers the whole figure; its coordinates are those of the chart, so a
design is marked at ``mechanism.project(design, space)``. Everything that has a size on paper is
computed in millimetres first: a wider figure gets a larger chart and the same text.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.path import Path

from fivebar_atlas.figures import style
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL, TEXT_LEVEL, DrawingArea, check_width
from fivebar_atlas.figures.text_placement import Box, text_size, wrapped
from fivebar_atlas.mechanisms.base import ChartAxis, DesignChart

FloatArray = npt.NDArray[np.float64]

# Millimetres on paper.
_PADDING = 1.0
_TICK = 1.0
_TICK_GAP = 0.6
_LABEL_GAP = 0.9
_LINE = 3.5
_PHRASE = 8.0


@dataclasses.dataclass(frozen=True, slots=True)
class _Label:
    text: str
    box: Box
    size: float


@dataclasses.dataclass(slots=True)
class ChartFrame(DrawingArea):
    """A figure with the frame of a chart in it; its coordinates are those of the chart.

    Attributes
    ----------
    chart
        The chart.
    """

    chart: DesignChart


def chart_frame(chart: DesignChart, title: str, width: float, below: float) -> ChartFrame:
    """Make a figure with the frame of a chart: outline, axes, ticks and title.

    Parameters
    ----------
    chart
        How the design space is drawn.
    title
        Title; broken into lines where it is wider than the figure.
    width
        Width of the figure in millimetres.
    below
        Room to leave below the chart, in millimetres.

    Returns
    -------
    ChartFrame
        The frame; sub-regions are drawn last, by :func:`draw_sub_regions`.

    Raises
    ------
    InputError
        If the width is not a number in the range of figure widths.
    """
    check_width(width)
    lower, upper = chart.outline.min(axis=0), chart.outline.max(axis=0)
    scale = (width - 10.0) / (upper[0] - lower[0])
    # The text beside the chart has a size of its own, so the scale follows from it.
    for _ in range(4):
        labels = _axis_labels(chart, scale)
        bounds = _bounds(chart, labels, scale)
        overhang = (bounds[2] - bounds[0]) - scale * (upper[0] - lower[0])
        scale = (width - 2 * _PADDING - overhang) / (upper[0] - lower[0])
    labels = _axis_labels(chart, scale)
    left, low, right, high = _bounds(chart, labels, scale)
    lines = wrapped(title, style.TITLE_SIZE, width - 2 * _PADDING)
    height = (high - low) + below + _PADDING + _LINE * len(lines) + _PADDING

    figure = Figure(figsize=(width / style.MM_PER_INCH, height / style.MM_PER_INCH))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    middle = (left + right) / 2.0
    axes.set_xlim((middle - width / 2) / scale, (middle + width / 2) / scale)
    axes.set_ylim((low - below) / scale, (low - below + height) / scale)
    frame = ChartFrame(figure, axes, scale, [], width, below, chart)

    axes.add_patch(
        Polygon(
            chart.outline,
            closed=True,
            fill=False,
            edgecolor=style.INK,
            linewidth=style.OUTLINE_WIDTH,
            joinstyle="round",
            zorder=BORDER_LEVEL,
            gid="outline",
        )
    )
    ticks = [
        [(tick.x, tick.y), (tick.x + tick.dx * _TICK / scale, tick.y + tick.dy * _TICK / scale)]
        for axis in chart.axes
        for tick in axis.ticks
    ]
    axes.add_collection(
        LineCollection(ticks, colors=style.INK, linewidths=0.6, zorder=BORDER_LEVEL),
        autolim=False,
    )
    for label in labels:
        frame.write(label.text, label.box, label.size)
    for number, line in enumerate(lines):
        baseline = low - below + height - _PADDING - _LINE * (number + 0.8)
        axes.text(
            middle / scale,
            baseline / scale,
            line,
            fontsize=style.TITLE_SIZE,
            ha="center",
            va="baseline",
            color=style.INK,
            zorder=TEXT_LEVEL,
        )
    # Names of sub-regions come first; whatever else is written makes way for them.
    frame.occupied.extend(_region_boxes(chart, scale))
    return frame


def draw_sub_regions(frame: ChartFrame) -> None:
    """Draw the borders between sub-regions and their names, on top of everything else."""
    for width, colour, dashes in (
        (style.BORDER_WIDTH + 1.1, "white", "solid"),
        (style.BORDER_WIDTH, style.INK, (0, (4.0, 2.0))),
    ):
        frame.axes.add_collection(
            LineCollection(
                list(frame.chart.borders),
                colors=colour,
                linewidths=width,
                linestyles=[dashes],
                zorder=BORDER_LEVEL,
            ),
            autolim=False,
        )
    for region, box in zip(
        frame.chart.regions, _region_boxes(frame.chart, frame.scale), strict=True
    ):
        frame.write(region.name, box, style.REGION_SIZE, halo=2.2, fontweight="bold")


def _region_boxes(chart: DesignChart, scale: float) -> list[Box]:
    return [
        Box(region.x * scale, region.y * scale, *text_size(region.name, style.REGION_SIZE))
        for region in chart.regions
    ]


def _axis_labels(chart: DesignChart, scale: float) -> list[_Label]:
    """Return tick labels and axis labels, none touching another."""
    outline = chart.outline * scale
    labels: list[_Label] = []
    for axis in chart.axes:
        for tick in axis.ticks:
            width, height = text_size(tick.label, style.TICK_SIZE)
            # Far enough along the tick for the box to clear its end.
            reach = abs(tick.dx) * width / 2 + abs(tick.dy) * height / 2
            distance = _TICK + _TICK_GAP + reach
            x, y = tick.x * scale + tick.dx * distance, tick.y * scale + tick.dy * distance
            labels.append(_Label(tick.label, Box(x, y, width, height), style.TICK_SIZE))
    taken = [label.box for label in labels]
    for axis in chart.axes:
        box = _axis_label_box(axis, scale, outline, taken)
        taken.append(box)
        labels.append(_Label(axis.label, box, style.AXIS_LABEL_SIZE))
    return labels


def _axis_label_box(
    axis: ChartAxis, scale: float, outline: FloatArray, taken: Sequence[Box]
) -> Box:
    """Return the place of an axis label: where the chart says, but just clear of ticks."""
    width, height = text_size(axis.label, style.AXIS_LABEL_SIZE)
    # A symbol is easier to read upright; a phrase runs along its side.
    angle = axis.rotation if width > _PHRASE else 0.0
    place = np.array([axis.label_x, axis.label_y]) * scale
    foot = _nearest_point(outline, place)
    outward = (place - foot) / np.hypot(*(place - foot))
    inside = Path(outline)
    distance = _TICK + height / 2
    while True:
        x, y = foot + distance * outward
        box = Box(float(x), float(y), width, height, angle)
        clear = not any(box.overlaps(other, gap=_LABEL_GAP) for other in taken)
        if clear and not inside.intersects_path(Path(box.corners(_LABEL_GAP)), filled=True):
            return box
        distance += 0.1


def _nearest_point(outline: FloatArray, place: FloatArray) -> FloatArray:
    sides = np.roll(outline, -1, axis=0) - outline
    share = np.clip(((place - outline) * sides).sum(axis=1) / (sides**2).sum(axis=1), 0.0, 1.0)
    feet = outline + share[:, np.newaxis] * sides
    nearest: FloatArray = feet[np.argmin(np.hypot(*(place - feet).T))]
    return nearest


def _bounds(
    chart: DesignChart, labels: Sequence[_Label], scale: float
) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of chart and labels in millimetres."""
    points = np.concatenate([chart.outline * scale, *(label.box.corners() for label in labels)])
    left, low = points.min(axis=0)
    right, high = points.max(axis=0)
    return float(left), float(low), float(right), float(high)
