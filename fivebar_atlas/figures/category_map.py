"""Maps of what belongs to single designs: categories, and errors by order of magnitude.

Nothing is interpolated here: every design colours its own cell, a third of each triangle
around it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.chart_frame import chart_frame, draw_sub_regions
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.colour_bar import (
    KeyEntry,
    bar_height,
    draw_bar,
    draw_key,
    key_height,
    missing_entry,
    missing_look,
)
from fivebar_atlas.figures.contour_levels import magnitude_levels, magnitude_text
from fivebar_atlas.figures.drawing_area import FILL_LEVEL, MISSING_LEVEL
from fivebar_atlas.figures.style import styled
from fivebar_atlas.mechanisms.quantities import Flags
from fivebar_atlas.triangulated_regions import outline_of_cells

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_EXACT = {"facecolor": "white", "edgecolor": style.INK, "linewidth": 0.3}


def category_map(
    designs: ChartedDesigns,
    values: IntArray,
    flags: Flags,
    title: str,
    *,
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw an integer quantity over the design space, one colour for each of its values.

    Parameters
    ----------
    designs
        The designs and the chart.
    values
        One value for each design, shape (n,).
    flags
        What the values mean; bits set together are one category.
    title
        Title of the figure.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, with a key of the categories that occur.

    Raises
    ------
    InputError
        If the width is out of range, or the values are not one for each design.
    """
    designs.check(values)
    present = [int(value) for value in np.unique(values)]
    colours = style.category_colours(len(present))
    entries = [
        KeyEntry(
            flags.describe(value).replace("_", " "),
            {"facecolor": colour, "edgecolor": style.INK, "linewidth": 0.3},
        )
        for value, colour in zip(present, colours, strict=True)
    ]
    with styled():
        frame = chart_frame(designs.chart, title, width, key_height(entries, width))
        for value, colour in zip(present, colours, strict=True):
            loops = outline_of_cells(designs.points, designs.triangles, values == value)
            look = {"facecolor": colour, "edgecolor": style.INK, "linewidth": 0.2}
            frame.fill(f"category-{value}", loops, FILL_LEVEL, **look)
        draw_key(frame, entries, 0.0)
        draw_sub_regions(frame)
        return frame.figure


def magnitude_map(
    designs: ChartedDesigns,
    values: FloatArray,
    title: str,
    label: str,
    *,
    missing: str = "no value",
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw positive values of many magnitudes, such as error estimates, on a log scale.

    Parameters
    ----------
    designs
        The designs and the chart.
    values
        One value for each design, shape (n,), not negative; 0 means exact, NaN none.
    title, label
        Title of the figure, and name and unit for the colour bar.
    missing
        What the hatched area means, for the key.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure: bands between levels that rise by factors, no contour lines, since
        errors scatter from design to design.

    Raises
    ------
    InputError
        If the width is out of range, or the values are not one for each design.
    """
    designs.check(values)
    positive = values > 0.0
    levels = np.empty(0)
    if positive.any():
        levels = magnitude_levels(float(values[positive].min()), float(values[positive].max()))
    colours = style.colour_map()(np.linspace(0.0, 1.0, max(len(levels) - 1, 0)))
    entries = []
    if (values == 0.0).any():
        entries.append(KeyEntry("0 (exact)", _EXACT))
    if np.isnan(values).any():
        entries.append(missing_entry(missing))
    with styled():
        below = key_height(entries, width)
        below += bar_height(label, width) if len(levels) else 0.0
        frame = chart_frame(designs.chart, title, width, below)
        # The last band holds its upper level too.
        bands = np.clip(np.searchsorted(levels, values, side="right") - 1, 0, len(levels) - 2)
        for band, colour in enumerate(colours):
            loops = outline_of_cells(designs.points, designs.triangles, positive & (bands == band))
            look = {"facecolor": colour, "edgecolor": colour, "linewidth": 0.1}
            frame.fill(f"band-{band}", loops, FILL_LEVEL, **look)
        for name, chosen, look in (
            ("exact", values == 0.0, _EXACT),
            ("missing", np.isnan(values), missing_look()),
        ):
            loops = outline_of_cells(designs.points, designs.triangles, chosen)
            frame.fill(name, loops, MISSING_LEVEL, **look)
        used = 0.0
        if len(levels):
            used = draw_bar(frame, list(colours), [magnitude_text(one) for one in levels], label)
        draw_key(frame, entries, used)
        draw_sub_regions(frame)
        return frame.figure
