"""The Pareto front of two quantities: over the cloud of all designs, and in the design space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fivebar_atlas.figures import style
from fivebar_atlas.figures.chart_frame import chart_frame, draw_sub_regions
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key, key_height
from fivebar_atlas.figures.contour_levels import level_text
from fivebar_atlas.figures.drawing_area import (
    LINE_LEVEL,
    REGION_LEVEL,
    TEXT_LEVEL,
    DrawingArea,
    check_width,
)
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.text_placement import text_size, wrapped
from fivebar_atlas.triangulated_regions import Region

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

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

_CLOUD = "#c9ced3"
_CANDIDATES = "#5b86a8"
_DOT = 1.1
_FRONT = 2.6


def pareto_figure(
    values: FloatArray,
    fulfilled: BoolArray,
    front: FloatArray,
    labels: tuple[str, str],
    conditions: Sequence[str],
    title: str,
    *,
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw the front of two quantities over the values of all designs.

    Parameters
    ----------
    values
        Both quantities of every design, shape (2, n); NaN where there is no value.
    fulfilled
        Which designs fulfil the conditions, shape (n,).
    front
        Both quantities of the members, shape (2, members).
    labels
        Name and unit of both.
    conditions
        The conditions as they are to be written in the key.
    title
        Title of the figure.
    width
        Width of the figure in millimetres.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    check_width(width)
    key = _key(front.shape[1], conditions, with_others=bool(conditions))
    exists = np.isfinite(values).all(axis=0)
    with styled():
        frame = _panel(values[:, exists], labels, title, width, key_height(key, width))
        groups = (
            ("other designs", exists & ~fulfilled, _CLOUD),
            ("designs", exists & fulfilled, _CANDIDATES),
        )
        for name, chosen, colour in groups:
            frame.axes.plot(
                *values[:, chosen],
                linestyle="none",
                marker="o",
                markersize=_DOT,
                markeredgewidth=0.0,
                color=colour,
                zorder=LINE_LEVEL - 1,
                gid=name,
                # As many dots as designs would make a vector file of megabytes.
                rasterized=True,
            )
        frame.axes.plot(*front, gid="pareto front", zorder=REGION_LEVEL, **_front_look())
        draw_key(frame, key, 0.0)
        return frame.figure


def pareto_designs_figure(
    designs: ChartedDesigns,
    region: Region | None,
    front: FloatArray,
    symbols: tuple[str, str],
    conditions: Sequence[str],
    title: str,
    *,
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw where the members of a front lie in the design space.

    Parameters
    ----------
    designs
        The designs and the chart.
    region
        Where the conditions hold, in chart coordinates; None without conditions.
    front
        The members in the chart, the first quantity rising, shape (members, 2).
    symbols
        The symbols of both quantities; the ends of the front are marked with them.
    conditions
        The conditions as they are to be written in the key.
    title
        Title of the figure.
    width
        Width of the figure in millimetres.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    entries = _key(len(front), conditions, with_others=False)[:1]
    region_look = {
        "facecolor": (*to_rgb(_CANDIDATES), 0.35),
        "edgecolor": _CANDIDATES,
        "linewidth": 0.8,
    }
    if region is not None and len(front):
        entries.append(KeyEntry(", ".join(conditions), region_look))
    ends = ((0, "s", symbols[1]), (-1, "^", symbols[0])) if len(front) else ()
    looks: list[dict[str, Any]] = [
        {
            "linestyle": "none",
            "marker": marker,
            "markersize": 5.0,
            "markeredgewidth": 0.9,
            "markerfacecolor": "none",
            "markeredgecolor": style.INK,
            "markevery": [1],
        }
        for _, marker, _ in ends
    ]
    for look, (_, _, symbol) in zip(looks, ends, strict=True):
        entries.append(KeyEntry(f"best {symbol} of the front", look))
    with styled():
        frame = chart_frame(designs.chart, title, width, key_height(entries, width))
        if region is not None:
            frame.fill("region", region.loops, LINE_LEVEL, **region_look)
        draw_sub_regions(frame)
        frame.axes.plot(*front.T, gid="pareto front", zorder=TEXT_LEVEL, **_front_look())
        for look, (place, _, symbol) in zip(looks, ends, strict=True):
            shown = {name: value for name, value in look.items() if name != "markevery"}
            frame.axes.plot(
                *front[place : place + 1 or None].T,
                gid=f"best {symbol}",
                zorder=TEXT_LEVEL + 1,
                **shown,
            )
        draw_key(frame, entries, 0.0)
        return frame.figure


def _front_look() -> dict[str, Any]:
    return {
        "color": style.REGION,
        # No line: between two members there need not be others.
        "linestyle": "none",
        "marker": "o",
        "markersize": _FRONT,
        "markeredgewidth": 0.0,
    }


def _key(members: int, conditions: Sequence[str], *, with_others: bool) -> list[KeyEntry]:
    """Return the key: the front, the designs that count and the others."""

    def dots(colour: str) -> dict[str, Any]:
        look = _front_look()
        return {**look, "color": colour, "markersize": 2.2, "markevery": [1]}

    if not members:
        entries = [KeyEntry(f"no design fulfils {', '.join(conditions)}", {})]
    else:
        plural = "" if members == 1 else "s"
        look = {**_front_look(), "markevery": [1]}
        entries = [KeyEntry(f"Pareto front, {members} design{plural}", look)]
        text = ", ".join(conditions) or "all designs of the lattice"
        entries.append(KeyEntry(text, dots(_CANDIDATES)))
    if with_others:
        entries.append(KeyEntry("other designs", dots(_CLOUD)))
    return entries


def _panel(
    values: FloatArray, labels: tuple[str, str], title: str, width: float, below: float
) -> DrawingArea:
    """Return a figure with one panel around values, shape (2, n), and room below it."""
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
