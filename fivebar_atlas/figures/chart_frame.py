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
from fivebar_atlas.mechanisms.charts import ChartAxis, DesignChart

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
    names
        Where names of sub-regions stand.
    """

    chart: DesignChart
    names: dict[str, Box]


def chart_frame(
    chart: DesignChart,
    title: str,
    width: float,
    below: float,
    upright: ChartAxis | None = None,
    reach: FloatArray | None = None,
) -> ChartFrame:
    """Make a figure with the frame of a chart: outline, axes, ticks and title.

    Parameters
    ----------
    chart
        How the design space is drawn.
    title
        Title; what is fixed in the design space is added to it. Broken into lines where it is
        wider than the figure.
    width
        Width of the figure in millimetres.
    below
        Room to leave below the chart, in millimetres.
    upright
        An axis that rises from the chart; its label stands above the tick labels.
    reach
        Points that are to be in the figure besides the chart, shape (n, 2).

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
    axes_drawn = chart.axes if upright is None else (*chart.axes, upright)
    shape = chart.outline if reach is None else np.concatenate([chart.outline, reach])
    for _ in range(4):
        labels = _axis_labels(chart, upright, scale)
        bounds = _bounds(shape, labels, scale)
        overhang = (bounds[2] - bounds[0]) - scale * (upper[0] - lower[0])
        scale = (width - 2 * _PADDING - overhang) / (upper[0] - lower[0])
    labels = _axis_labels(chart, upright, scale)
    left, low, right, high = _bounds(shape, labels, scale)
    whole = ", ".join(part for part in (title, chart.fixed) if part)
    lines = wrapped(whole, style.TITLE_SIZE, width - 2 * _PADDING)
    height = (high - low) + below + _PADDING + _LINE * len(lines) + _PADDING

    figure = Figure(figsize=(width / style.MM_PER_INCH, height / style.MM_PER_INCH))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    middle = (left + right) / 2.0
    axes.set_xlim((middle - width / 2) / scale, (middle + width / 2) / scale)
    axes.set_ylim((low - below) / scale, (low - below + height) / scale)
    # Names of sub-regions come first; whatever else is written makes way for them.
    names = _region_boxes(chart, labels, scale)
    frame = ChartFrame(figure, axes, scale, list(names.values()), width, below, chart, names)

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
        for axis in axes_drawn
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
    for name, box in frame.names.items():
        frame.write(name, box, style.REGION_SIZE, halo=2.2, fontweight="bold")


def _region_boxes(chart: DesignChart, labels: Sequence[_Label], scale: float) -> dict[str, Box]:
    """Return where names of sub-regions stand; one that would cover text is left out."""
    boxes: dict[str, Box] = {}
    for region in chart.regions:
        size = text_size(region.name, style.REGION_SIZE)
        box = Box(region.x * scale, region.y * scale, *size)
        taken = (*boxes.values(), *(label.box for label in labels))
        # The letters are bold: wider than their box.
        if not any(box.overlaps(other, gap=_TICK_GAP) for other in taken):
            boxes[region.name] = box
    return boxes


def _axis_labels(chart: DesignChart, upright: ChartAxis | None, scale: float) -> list[_Label]:
    """Return tick labels and axis labels, none touching another.

    Where a chart is seen from so low that labels of two axes meet in a corner, the first stays.
    """
    outline = chart.outline * scale
    labels: list[_Label] = []
    for axis in chart.axes if upright is None else (*chart.axes, upright):
        for tick in axis.ticks:
            width, height = text_size(tick.label, style.TICK_SIZE)
            # Far enough along the tick for the box to clear its end.
            reach = abs(tick.dx) * width / 2 + abs(tick.dy) * height / 2
            distance = _TICK + _TICK_GAP + reach
            x, y = tick.x * scale + tick.dx * distance, tick.y * scale + tick.dy * distance
            box = _clear_of(outline, Box(x, y, width, height))
            if not any(box.overlaps(label.box) for label in labels):
                labels.append(_Label(tick.label, box, style.TICK_SIZE))
    taken = [label.box for label in labels]
    for axis in chart.axes:
        box = _axis_label_box(axis, scale, outline, taken)
        taken.append(box)
        labels.append(_Label(axis.label, box, style.AXIS_LABEL_SIZE))
    if upright is not None:
        width, height = text_size(upright.label, style.AXIS_LABEL_SIZE)
        x = scale * upright.label_x - _TICK - _TICK_GAP - width / 2
        box = Box(x, scale * upright.label_y, width, height)
        while any(box.overlaps(other, gap=_LABEL_GAP) for other in taken):
            box = dataclasses.replace(box, y=box.y + 0.1)
        labels.append(_Label(upright.label, box, style.AXIS_LABEL_SIZE))
    return labels


def _clear_of(outline: FloatArray, box: Box) -> Box:
    """Return a box, moved away from an outline that it touches.

    A tick may run along the side that it stands on where the chart is seen obliquely.
    """
    inside = Path(outline)
    while inside.intersects_path(Path(box.corners(_TICK_GAP / 2)), filled=True):
        place = np.array([box.x, box.y])
        foot = _nearest_point(outline, place)
        away = (place - foot) / np.hypot(*(place - foot))
        x, y = place + 0.1 * away
        box = dataclasses.replace(box, x=float(x), y=float(y))
    return box


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
    shape: FloatArray, labels: Sequence[_Label], scale: float
) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of points and labels in millimetres."""
    points = np.concatenate([shape * scale, *(label.box.corners() for label in labels)])
    left, low = points.min(axis=0)
    right, high = points.max(axis=0)
    return float(left), float(low), float(right), float(high)
