"""The quantities of a motion over its time, in panels: after Wang et al. 2017, Fig. 2 (a)-(f)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fivebar_atlas.errors import UnknownNameError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.contour_levels import level_text
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL, LINE_LEVEL, check_width
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.text_placement import text_size, wrapped
from fivebar_atlas.mechanisms.arrays import IntArray
from fivebar_atlas.mechanisms.motions import Column, SolvedMotion

#: Width of a figure over both columns of a page, in millimetres.
PAGE_WIDTH = 178.0
#: Panels that are drawn, by letter: the groups of a motion in their order.
LETTERS = "abcdef"

# Colours that the colour-blind tell apart, after Okabe and Ito, and dashes that print in grey.
_COLOURS = ("#0072b2", "#d55e00", "#007a5a", "#7b3294", "#b58900", style.INK)
_DASHES: tuple[Any, ...] = (
    "solid",
    (0.0, (5.0, 1.4)),
    (0.0, (2.2, 1.2)),
    (0.0, (6.0, 1.4, 1.2, 1.4)),
    (0.0, (1.0, 1.0)),
    (0.0, (8.0, 1.6)),
)
_LINE_WIDTH = 1.0
# Millimetres on paper: sizes of a panel's surroundings, and its height as a share of its width.
_PADDING, _GAP = 1.5, 5.0
_LINE, _KEY, _LABEL = 4.0, 4.2, 4.0
_TICK, _TICK_GAP = 0.7, 0.6
_ASPECT = 0.52
# More points than these a line are not seen; and widths from which there are two panels a row.
_MOST_POINTS, _TWO_FROM = 4000, 130.0
_MARGIN = 0.06


def trajectory_figure(
    solution: SolvedMotion,
    title: str = "",
    *,
    panels: Sequence[str] = (),
    width: float | None = None,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the quantities of a motion over its time.

    Parameters
    ----------
    solution
        The motion.
    title
        Title of the figure; none if empty.
    panels
        Letters of the panels, ``"a"`` to ``"f"``; all if empty. Letters stay with their panels.
    width
        Width of the figure in millimetres; by default :data:`PAGE_WIDTH`, or that of a column
        where there is one panel only.
    data
        Takes what is plotted: times as x, values as y, in the units of the panels.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with two panels a row where it is wide enough.

    Raises
    ------
    UnknownNameError
        If there is no such panel.
    InputError
        If the width is out of range.
    """
    groups = dict(zip(LETTERS, solution.groups, strict=False))
    for letter in panels:
        if letter not in groups:
            raise UnknownNameError("panel", letter, groups)
    chosen = [letter for letter in groups if letter in panels or not panels]
    if width is None:
        width = PAGE_WIDTH if len(chosen) > 1 else style.COLUMN_WIDTH
    check_width(width)
    across = 2 if width >= _TWO_FROM and len(chosen) > 1 else 1
    down = -(-len(chosen) // across)
    with styled():
        lines = wrapped(title, style.TITLE_SIZE, width - 2 * _PADDING) if title else []
        drawn = [(letter, solution.of_group(groups[letter])) for letter in chosen]
        ticks = [_ticks(columns) for _, columns in drawn]
        # panels of one column of the figure begin at one place
        lefts = [
            _PADDING
            + _LABEL
            + _TICK
            + 2 * _TICK_GAP
            + max(
                text_size(text, style.TICK_SIZE)[0]
                for _, texts in ticks[number::across]
                for text in texts
            )
            for number in range(across)
        ]
        right = _PADDING + text_size("00", style.TICK_SIZE)[0] / 2
        panel = (width - sum(lefts) - across * right - (across - 1) * _GAP) / across
        height = _ASPECT * panel
        above = _LINE + _KEY
        below = _TICK + _TICK_GAP + text_size("0", style.TICK_SIZE)[1] + _LABEL + _PADDING
        row = above + height + below
        total = 2 * _PADDING + len(lines) * _LINE + down * row
        figure = Figure(figsize=(width / style.MM_PER_INCH, total / style.MM_PER_INCH))
        FigureCanvasAgg(figure)
        for number, (letter, columns) in enumerate(drawn):
            place, line = number % across, number // across
            left = sum(lefts[: place + 1]) + place * (panel + right + _GAP)
            bottom = total - 2 * _PADDING - len(lines) * _LINE - line * row - above - height
            axes = figure.add_axes((left / width, bottom / total, panel / width, height / total))
            axes.set_gid(f"panel-{letter}")
            _draw_panel(axes, solution, letter, columns, ticks[number], height, data)
            unit = columns[0].unit
            _write(
                figure,
                (_PADDING + (left - lefts[place]) + _LABEL / 2) / width,
                (bottom + height / 2) / total,
                f"{_axis_phrase(columns)} ({unit})",
                90,
            )
            _write(
                figure,
                (left + panel / 2) / width,
                (bottom - below + _PADDING + _LABEL / 2) / total,
                f"$t$ ({solution.units.time})",
                0,
            )
        for number, text in enumerate(lines):
            figure.text(
                0.5,
                1.0 - (_PADDING + (number + 0.5) * _LINE) / total,
                text,
                fontsize=style.TITLE_SIZE,
                color=style.INK,
                ha="center",
                va="center",
            )
        return figure


def _draw_panel(
    axes: Axes,
    solution: SolvedMotion,
    letter: str,
    columns: Sequence[Column],
    ticks: tuple[Sequence[float], Sequence[str]],
    height: float,
    data: PlottedData | None,
) -> None:
    """Draw the lines of a panel, its ticks, its name and its key."""
    shown = _shown(columns)
    times = solution.times[shown]
    axes.axhline(0.0, color=style.FAINT, linewidth=0.4, zorder=LINE_LEVEL - 1)
    for number, column in enumerate(columns):
        axes.plot(
            times,
            column.values[shown],
            color=_COLOURS[number % len(_COLOURS)],
            linestyle=_DASHES[number % len(_DASHES)],
            linewidth=_LINE_WIDTH,
            label=column.symbol,
            gid=f"line-{column.name}",
            zorder=LINE_LEVEL,
        )
        if data is not None:
            points = np.column_stack([times, column.values[shown]])
            data.add(column.name, points, f"panel {letter}", column.unit)
    low = min(float(column.values.min()) for column in columns)
    high = max(float(column.values.max()) for column in columns)
    room = _MARGIN * (high - low) or 1.0
    axes.set_xlim(float(solution.times[0]), float(solution.times[-1]))
    axes.set_ylim(low - room, high + room)
    axes.set_yticks(*ticks)
    first, last = axes.get_xlim()
    stops = [tick for tick in MaxNLocator(6).tick_values(first, last) if first <= tick <= last]
    axes.set_xticks(stops, [level_text(tick, np.array(stops)) for tick in stops])
    axes.tick_params(
        length=_TICK * style.POINTS_PER_MM,
        pad=_TICK_GAP * style.POINTS_PER_MM,
        labelsize=style.TICK_SIZE,
        labelcolor=style.INK,
        color=style.INK,
    )
    for spine in axes.spines.values():
        spine.set_zorder(BORDER_LEVEL)
        spine.set_color(style.INK)
    axes.text(
        0.0,
        1.0 + (_KEY + _LINE / 2) / height,
        f"({letter}) {columns[0].group}",
        transform=axes.transAxes,
        fontsize=style.TITLE_SIZE,
        color=style.INK,
        va="center",
    )
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=len(columns),
        fontsize=style.NOTE_SIZE,
        frameon=False,
        handlelength=2.2,
        handletextpad=0.4,
        columnspacing=0.9,
        borderpad=0.15,
        borderaxespad=0.0,
    )


def _ticks(columns: Sequence[Column]) -> tuple[list[float], list[str]]:
    """Return ticks of the values of a panel, and their texts."""
    low = min(float(column.values.min()) for column in columns)
    high = max(float(column.values.max()) for column in columns)
    room = _MARGIN * (high - low) or 1.0
    low, high = low - room, high + room
    ticks = [float(t) + 0.0 for t in MaxNLocator(6).tick_values(low, high) if low <= t <= high]
    return ticks, [level_text(tick, np.array(ticks)) for tick in ticks]


def _shown(columns: Sequence[Column]) -> IntArray:
    """Return the samples that are drawn: not too many, but the extremes of every line."""
    count = len(columns[0].values)
    if count <= _MOST_POINTS:
        return np.arange(count)
    some = np.linspace(0, count - 1, _MOST_POINTS).round().astype(np.int64)
    extremes = [
        place
        for column in columns
        for place in (int(np.argmin(column.values)), int(np.argmax(column.values)))
    ]
    return np.union1d(some, np.array(extremes, dtype=np.int64))


def _axis_phrase(columns: Sequence[Column]) -> str:
    """Return what the values of a panel are, in a word."""
    word = columns[0].group.rsplit(" ", maxsplit=1)[-1]
    return f"{word.removesuffix('ies')}y" if word.endswith("ies") else word.removesuffix("s")


def _write(figure: Figure, x: float, y: float, text: str, turn: float) -> None:
    figure.text(
        x,
        y,
        text,
        rotation=turn,
        fontsize=style.AXIS_LABEL_SIZE,
        color=style.INK,
        ha="center",
        va="center",
    )
