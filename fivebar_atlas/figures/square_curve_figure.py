"""The side of the largest square over the ratio of links, by what limits it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key_rows, key_rows_height
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL, LINE_LEVEL, TEXT_LEVEL, check_width
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.value_panel import value_panel
from fivebar_atlas.planar_geometry import FloatArray, Point

_X_LABEL = r"ratio of links $\rho = l_2/l_1$"

# Colours that the colour-blind tell apart, after Okabe and Ito, and dashes that print in grey.
_COLOURS = ("#0072b2", "#d55e00", "#007a5a", "#7b3294", "#b58900", "#56b4e9", style.INK)
_DASHES: tuple[Any, ...] = (
    "solid",
    (0.0, (5.0, 1.4)),
    (0.0, (2.2, 1.2)),
    (0.0, (6.0, 1.4, 1.2, 1.4)),
    (0.0, (1.0, 1.2)),
)
_LINE_WIDTH = 1.3
_KINK: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 5.4,
    "markerfacecolor": "white",
    "markeredgecolor": style.INK,
    "markeredgewidth": 0.7,
}
_LARGEST: dict[str, Any] = {
    "linestyle": "none",
    "marker": "D",
    "markersize": 2.8,
    "color": style.REGION,
    "markeredgewidth": 0.0,
}
# Room above the largest value for its label, as a share of the range of values; and how near
# to a side, as a share of the width, it is not written around its place.
_HEADROOM, _NEAR = 0.09, 0.2


def square_curve_figure(
    lines: Sequence[tuple[str, FloatArray]],
    kinks: Sequence[Point],
    largest: Point,
    title: str,
    side_label: str,
    remarks: Sequence[str] = (),
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the side of the largest square over the ratio of links, piece by piece.

    Parameters
    ----------
    lines
        For each piece what limits the square, and ratios and sides, shape (n, 2); pieces
        that one thing limits have one look. Where there is no square there is no piece.
    kinks
        Ratio and side where two pieces meet.
    largest
        Ratio and side of the largest square.
    title
        Title of the figure.
    side_label
        Label of the sides.
    remarks
        What else is to be said in the key.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted: ratios as x, sides as y.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Le, Kang and Doan 2013, Fig. 5.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    check_width(width)
    looks = _looks([name for name, _ in lines])
    rows = [[KeyEntry(name, look)] for name, look in looks.items()]
    rows.append(_marks(kinks))
    rows += [[KeyEntry(remark, {})] for remark in remarks]
    values = np.concatenate([points for _, points in lines]).T
    top = values[1].max() + _HEADROOM * np.ptp(values[1])
    shown = np.column_stack([values, [largest[0], top]])
    with styled():
        labels = (_X_LABEL, side_label)
        frame = value_panel(shown, labels, title, width, key_rows_height(rows, width))
        for number, (name, points) in enumerate(lines, start=1):
            frame.axes.plot(*points.T, gid=f"piece-{number}", zorder=LINE_LEVEL, **looks[name])
            if data is not None:
                data.add("side of the largest square", points, name)
        if kinks:
            frame.axes.plot(*np.array(kinks).T, gid="kinks", zorder=BORDER_LEVEL, **_KINK)
        frame.axes.plot(*largest, gid="largest", zorder=BORDER_LEVEL + 0.1, **_LARGEST)
        _label_largest(frame.axes, largest)
        if data is not None:
            data.add("kink", kinks)
            data.add("largest side", [largest])
        draw_key_rows(frame, rows)
        return frame.figure


def _looks(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return a look for each different name, in the order in which they come."""
    return {
        name: {
            "color": _COLOURS[number % len(_COLOURS)],
            "linestyle": _DASHES[number % len(_DASHES)],
            "linewidth": _LINE_WIDTH,
        }
        for number, name in enumerate(dict.fromkeys(names))
    }


def _marks(kinks: Sequence[Point]) -> list[KeyEntry]:
    """Return the entries of the key for marked points."""
    entries = []
    if kinks:
        places = ", ".join(f"{ratio:.4f}" for ratio, _ in kinks)
        text = rf"kink{'s' * (len(kinks) > 1)} at $\rho$ = {places}"
        entries.append(KeyEntry(text, {**_KINK, "markevery": [1]}))
    entries.append(KeyEntry(r"largest side, at $(\rho, a/l_1)$", {**_LARGEST, "markevery": [1]}))
    return entries


def _label_largest(axes: Axes, largest: Point) -> None:
    """Write ratio and side above the largest value, within the panel."""
    low, high = axes.get_xlim()
    share = (largest[0] - low) / (high - low)
    side = "left" if share < _NEAR else "right" if share > 1.0 - _NEAR else "center"
    axes.annotate(
        f"({largest[0]:.4f}, {largest[1]:.4f})",
        largest,
        (0.0, 4.5),
        textcoords="offset points",
        ha=side,
        va="bottom",
        fontsize=style.NOTE_SIZE,
        color=style.INK,
        zorder=TEXT_LEVEL,
        path_effects=style.halo(1.4),
    )
