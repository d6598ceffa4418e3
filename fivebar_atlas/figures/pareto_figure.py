"""The Pareto front of two quantities: over the cloud of all designs, and in the design space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.chart_frame import chart_frame, draw_sub_regions
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key, key_height
from fivebar_atlas.figures.drawing_area import (
    LINE_LEVEL,
    REGION_LEVEL,
    TEXT_LEVEL,
    check_width,
)
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.value_panel import value_panel
from fivebar_atlas.triangulated_regions import Region

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

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
        frame = value_panel(values[:, exists], labels, title, width, key_height(key, width))
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
