"""A panel with one value over another, each with a scale of its own: ticks, labels, title."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fivebar_atlas.figures import style
from fivebar_atlas.figures.contour_levels import level_text
from fivebar_atlas.figures.drawing_area import DrawingArea
from fivebar_atlas.figures.text_placement import text_size, wrapped
from fivebar_atlas.planar_geometry import FloatArray

# Millimetres on paper.
_PADDING = 1.0
_LINE = 3.5
_LABEL_LINE = 3.9
_TICK = 0.7
_TICK_GAP = 0.6
_LABEL_GAP = 1.3
# Height of the panel as a share of its width.
_ASPECT = 0.72
_MARGIN = 0.04


def value_panel(
    values: FloatArray, labels: tuple[str, str], title: str, width: float, below: float
) -> DrawingArea:
    """Make a figure with one panel around values, and room below it.

    Parameters
    ----------
    values
        Abscissas and ordinates of what is to be shown, shape (2, n).
    labels
        Labels of both axes.
    title
        Title; broken into lines where it is wider than the figure.
    width
        Width of the figure in millimetres.
    below
        Room to leave below the panel and its axis label, in millimetres.
    """
    spans = [_range(row) for row in values]
    ticks = [_ticks(low, high) for low, high in spans]
    texts = [[level_text(tick, each) for tick in each] for each in ticks]
    widest = max(text_size(text, style.TICK_SIZE)[0] for text in texts[1])
    tick_height = text_size("0", style.TICK_SIZE)[1]
    right = _PADDING + text_size(texts[0][-1], style.TICK_SIZE)[0] / 2
    room = width - 30.0
    y_lines = wrapped(labels[1], style.AXIS_LABEL_SIZE, _ASPECT * room)
    left = _PADDING + _LABEL_LINE * len(y_lines) + _LABEL_GAP + widest + _TICK_GAP + _TICK
    panel = width - left - right
    height = _ASPECT * panel
    x_lines = wrapped(labels[0], style.AXIS_LABEL_SIZE, panel)
    under = _TICK + _TICK_GAP + tick_height + _LABEL_GAP + _LABEL_LINE * len(x_lines) + _PADDING
    lines = wrapped(title, style.TITLE_SIZE, width - 2 * _PADDING)
    top = 2 * _PADDING + _LINE * len(lines)
    total = below + under + height + top
    figure = Figure(figsize=(width / style.MM_PER_INCH, total / style.MM_PER_INCH))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((left / width, (below + under) / total, panel / width, height / total))
    axes.set_xlim(*spans[0])
    axes.set_ylim(*spans[1])
    axes.set_xticks(ticks[0], texts[0])
    axes.set_yticks(ticks[1], texts[1])
    axes.tick_params(
        length=_TICK * style.POINTS_PER_MM,
        pad=_TICK_GAP * style.POINTS_PER_MM,
        labelsize=style.TICK_SIZE,
        labelcolor=style.INK,
        color=style.INK,
    )
    look: dict[str, Any] = {"fontsize": style.AXIS_LABEL_SIZE, "color": style.INK, "ha": "center"}
    for number, line in enumerate(x_lines):
        down = below + _PADDING + _LABEL_LINE * (len(x_lines) - number - 0.75)
        figure.text((left + panel / 2) / width, down / total, line, va="baseline", **look)
    for number, line in enumerate(y_lines):
        across = _PADDING + _LABEL_LINE * (number + 0.75)
        figure.text(
            across / width,
            (below + under + height / 2) / total,
            line,
            va="baseline",
            rotation=90.0,
            rotation_mode="anchor",
            **look,
        )
    for number, line in enumerate(lines):
        baseline = total - _PADDING - _LINE * (number + 0.8)
        figure.text(
            0.5,
            baseline / total,
            line,
            fontsize=style.TITLE_SIZE,
            ha="center",
            va="baseline",
            color=style.INK,
        )
    return DrawingArea(figure, axes, 1.0, [], width, below)


def _range(row: FloatArray) -> tuple[float, float]:
    """Return the ends of an axis: those of the values and some room."""
    if not len(row):
        return 0.0, 1.0
    low, high = float(row.min()), float(row.max())
    room = _MARGIN * (high - low) or _MARGIN * abs(high) or 1.0
    return low - room, high + room


def _ticks(low: float, high: float) -> FloatArray:
    ticks = np.asarray(MaxNLocator(6).tick_values(low, high))
    inside = ticks[(ticks >= low) & (ticks <= high)]
    return inside if len(inside) else np.array([(low + high) / 2.0])
