"""What stands below a drawing: the colour bar, and the key to what has no colour."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from matplotlib.patches import Rectangle

from fivebar_atlas.figures import style
from fivebar_atlas.figures.drawing_area import DrawingArea
from fivebar_atlas.figures.text_placement import text_size, wrapped

# Millimetres on paper.
_MARGIN = 4.0
_GAP = 2.2
_KEY_GAP = 0.6
_BAR = 2.4
_TICKS = 3.6
_LINE = 3.5
_PADDING = 0.4
_SWATCH = 5.0
_COLUMN_GAP = 3.0


@dataclasses.dataclass(frozen=True, slots=True)
class KeyEntry:
    """One entry of the key: the look of a rectangle or line, and what it stands for.

    A look with a ``facecolor`` is a rectangle's, an empty one is nothing but the text. A line has
    three points: ``markevery=[1]`` marks its middle.
    """

    text: str
    look: dict[str, Any]


def missing_entry(text: str) -> KeyEntry:
    """Return the entry for the hatched area where there is no value."""
    return KeyEntry(text, missing_look())


def missing_look() -> dict[str, Any]:
    """Return the look of the area where there is no value."""
    return {
        "facecolor": style.MISSING,
        "edgecolor": style.MISSING_HATCH,
        "hatch": "//////",
        "linewidth": 0.0,
    }


def bar_height(label: str, width: float) -> float:
    """Return the height in millimetres that a colour bar with this label needs."""
    lines = wrapped(label, style.NOTE_SIZE, width - 2 * _MARGIN)
    return _GAP + _BAR + _TICKS + _LINE * len(lines) + _PADDING


def draw_bar(
    frame: DrawingArea, colours: Sequence[Any], ticks: Sequence[str], label: str, below: float = 0.0
) -> float:
    """Draw a horizontal colour bar of equal bands with a tick at every level.

    Parameters
    ----------
    frame
        The figure.
    colours
        One colour for each band.
    ticks
        One text for each level, one more than there are bands; where they are too wide
        to stand side by side, every second (third, ...) is written.
    label
        Name and unit, below the bar.
    below
        Where to begin, in millimetres below the drawing.

    Returns
    -------
    float
        Where the room it takes ends, in millimetres below the drawing.
    """
    widest = max(text_size(text, style.TICK_SIZE)[0] for text in ticks)
    margin = max(_MARGIN, widest / 2 + 1.0)
    width = frame.width - 2 * margin
    axes = frame.add_strip(margin, below + _GAP, width, _BAR)
    axes.set_label("colour bar")
    bands = len(colours)
    axes.set_xlim(0, bands)
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    for band, colour in enumerate(colours):
        axes.add_patch(
            Rectangle((band, 0), 1, 1, facecolor=colour, edgecolor=style.INK, linewidth=0.3)
        )
    step = next(n for n in range(1, bands + 2) if n * width / bands >= widest + 1 or n > bands)
    marked = list(range(0, bands + 1, step))
    axes.set_xticks(marked, [ticks[index] for index in marked], fontsize=style.TICK_SIZE)
    axes.tick_params(colors=style.INK)
    lines = wrapped(label, style.NOTE_SIZE, frame.width - 2 * _MARGIN)
    for number, line in enumerate(lines):
        down = _BAR + _TICKS + _LINE * (number + 0.75)
        axes.text(
            bands / 2,
            1.0 - down / _BAR,
            line,
            fontsize=style.NOTE_SIZE,
            ha="center",
            va="baseline",
            color=style.INK,
        )
    return below + bar_height(label, frame.width)


def key_height(entries: Sequence[KeyEntry], width: float) -> float:
    """Return the height in millimetres that a key needs; 0 without entries."""
    lines = sum(_row_lines(row, width) for row in _rows(entries, width))
    return (_KEY_GAP + _PADDING) * bool(entries) + _LINE * lines


def draw_key(frame: DrawingArea, entries: Sequence[KeyEntry], below: float) -> None:
    """Draw a key, its entries side by side as far as there is room.

    Parameters
    ----------
    frame
        The figure.
    entries
        The entries; a text wider than the figure is broken into lines.
    below
        Where to begin, in millimetres below the drawing.
    """
    if not entries:
        return
    rows = _rows(entries, frame.width)
    height = _LINE * sum(_row_lines(row, frame.width) for row in rows)
    axes = frame.add_strip(0.0, below + _KEY_GAP, frame.width, height)
    axes.set_label("key")
    axes.set_axis_off()
    axes.set_xlim(0, frame.width)
    axes.set_ylim(-height, 0)
    top = 0.0
    for row in rows:
        used = sum(_entry_width(each, frame.width) for each in row) + _COLUMN_GAP * (len(row) - 1)
        x = (frame.width - used) / 2
        for entry in row:
            middle = top - 0.5 * _LINE
            if "facecolor" in entry.look:
                axes.add_patch(Rectangle((x, middle - 1.1), _SWATCH, 2.2, **entry.look))
            elif entry.look:
                axes.plot([x, x + _SWATCH / 2, x + _SWATCH], [middle] * 3, **entry.look)
            for number, line in enumerate(_lines(entry, frame.width)):
                axes.text(
                    x + _swatch_width(entry),
                    middle - 0.85 - _LINE * number,
                    line,
                    fontsize=style.NOTE_SIZE,
                    ha="left",
                    va="baseline",
                    color=style.INK,
                )
            x += _entry_width(entry, frame.width) + _COLUMN_GAP
        top -= _LINE * _row_lines(row, frame.width)


def key_rows_height(rows: Sequence[Sequence[KeyEntry]], width: float) -> float:
    """Return the height in millimetres that keys one below the other need."""
    return sum(key_height(row, width) for row in rows)


def draw_key_rows(
    frame: DrawingArea, rows: Sequence[Sequence[KeyEntry]], below: float = 0.0
) -> None:
    """Draw keys one below the other, from ``below`` millimetres below the drawing."""
    for row in rows:
        draw_key(frame, row, below)
        below += key_height(row, frame.width)


def _swatch_width(entry: KeyEntry) -> float:
    return _SWATCH + 1.0 if entry.look else 0.0


def _lines(entry: KeyEntry, width: float) -> list[str]:
    return wrapped(entry.text, style.NOTE_SIZE, width - 2 * _MARGIN - _swatch_width(entry))


def _entry_width(entry: KeyEntry, width: float) -> float:
    widest = max(text_size(line, style.NOTE_SIZE)[0] for line in _lines(entry, width))
    return _swatch_width(entry) + widest


def _row_lines(row: Sequence[KeyEntry], width: float) -> int:
    return max(len(_lines(entry, width)) for entry in row)


def _rows(entries: Sequence[KeyEntry], width: float) -> list[list[KeyEntry]]:
    rows: list[list[KeyEntry]] = []
    room = 0.0
    for entry in entries:
        needed = _entry_width(entry, width)
        if not rows or needed > room:
            rows.append([])
            room = width - 2 * _MARGIN
        rows[-1].append(entry)
        room -= needed + _COLUMN_GAP
    return rows
