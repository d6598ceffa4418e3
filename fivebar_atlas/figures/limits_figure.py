"""The operating limits of the actuators: what each input runs over, along a coordinate."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key_rows, key_rows_height
from fivebar_atlas.figures.drawing_area import FILL_LEVEL, LINE_LEVEL, check_width
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.value_panel import value_panel
from fivebar_atlas.figures.wording import coordinate_label, title_text
from fivebar_atlas.mechanisms.planar import RADIANS, OperatingLimits, PlanarDesign
from fivebar_atlas.planar_geometry import FloatArray

# Colours that the colour-blind tell apart, after Okabe and Ito.
_COLOURS = ("#0072b2", "#d55e00", "#007a5a", "#7b3294", "#b58900")
_BAND = 0.16
_LINE_WIDTH = 1.2
_DASHES = {"greatest": "solid", "least": (0.0, (4.0, 1.4))}
_DEGREES = "deg"


def limits_figure(
    design: PlanarDesign,
    mode: str,
    count: int = 361,
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the least and the greatest value of each input over the usable workspace.

    Parameters
    ----------
    design
        The design.
    mode
        Mode pair.
    count
        Number of values of the coordinate.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted: the coordinate as x, inputs in degrees as y.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, angles in degrees; after Nam and Park 2006, Fig. 9.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    InputError
        If the mechanism has no such limits, the usable workspace is empty, or the width is out
        of range.
    """
    check_width(width)
    limits = design.operating_limits(mode, count)
    extremes = {"greatest": np.degrees(limits.greatest), "least": np.degrees(limits.least)}
    if not np.isfinite(extremes["greatest"]).any():
        raise InputError("--mode", mode, "a mode pair that has a usable workspace")
    is_angle = limits.unit == RADIANS
    places = np.degrees(limits.places) if is_angle else limits.places
    rows = [
        [KeyEntry(f"{which} {symbol}", _look(number, which)) for which in extremes]
        for number, symbol in enumerate(limits.input_symbols)
    ]
    labels = (_coordinate_label(limits), f"inputs {', '.join(limits.input_symbols)} (degrees)")
    if data is not None:
        data.units = (_DEGREES if is_angle else limits.unit, _DEGREES)
    with styled():
        frame = value_panel(
            _shown(places, extremes),
            labels,
            title_text("Operating limits", design, mode),
            width,
            key_rows_height(rows, width),
        )
        for number, symbol in enumerate(limits.input_symbols):
            frame.axes.fill_between(
                places,
                extremes["least"][:, number],
                extremes["greatest"][:, number],
                facecolor=_COLOURS[number % len(_COLOURS)],
                alpha=_BAND,
                linewidth=0.0,
                zorder=FILL_LEVEL,
                gid=f"band-{number + 1}",
            )
            for which, values in extremes.items():
                line = np.column_stack([places, values[:, number]])
                frame.axes.plot(
                    *line.T, zorder=LINE_LEVEL, gid=f"{which}-{number + 1}", **_look(number, which)
                )
                if data is not None:
                    exists = np.isfinite(line[:, 1])
                    data.add(f"{which} input", line[exists], symbol.strip("$"))
        draw_key_rows(frame, rows)
        return frame.figure


def _look(number: int, which: str) -> dict[str, Any]:
    """Return the look of a curve of an input, counted from 0."""
    return {
        "color": _COLOURS[number % len(_COLOURS)],
        "linestyle": _DASHES[which],
        "linewidth": _LINE_WIDTH,
    }


def _coordinate_label(limits: OperatingLimits) -> str:
    name = f"{limits.coordinate_name} {limits.coordinate}"
    return f"{name} (degrees)" if limits.unit == RADIANS else coordinate_label(name, limits.unit)


def _shown(places: FloatArray, extremes: dict[str, FloatArray]) -> FloatArray:
    """Return coordinates and inputs that are to be in the panel, shape (2, n)."""
    points = [
        np.stack(np.broadcast_arrays(places[:, np.newaxis], values), axis=-1).reshape(-1, 2)
        for values in extremes.values()
    ]
    every = np.concatenate(points)
    return np.asarray(every[np.isfinite(every[:, 1])].T)
