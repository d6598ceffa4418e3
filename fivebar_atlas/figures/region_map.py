"""The optimum region of several conditions, over the contours of two quantities."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb
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
)
from fivebar_atlas.figures.contour_levels import level_text
from fivebar_atlas.figures.contour_map import (
    absent_triangles,
    draw_levels,
    draw_missing,
    fill_between_levels,
    levels_of,
)
from fivebar_atlas.figures.drawing_area import REGION_LEVEL
from fivebar_atlas.figures.style import styled
from fivebar_atlas.triangulated_regions import Region

FloatArray = npt.NDArray[np.float64]

_LINES = "#8a1500"
_DASHES = (0.0, (5.0, 1.6))
# Share of white in the colours below the region, which is to stand out.
_PALE = 0.5
# Two quantities share the chart, so each gets fewer levels than one alone.
_BANDS = 8


@dataclasses.dataclass(frozen=True, slots=True)
class Layer:
    """A quantity drawn below the region.

    Attributes
    ----------
    values
        One value for each design, shape (n,); NaN where there is none.
    label
        Name and unit.
    """

    values: FloatArray
    label: str


def region_map(
    designs: ChartedDesigns,
    filled: Layer,
    lined: Layer,
    region: Region,
    conditions: Sequence[str],
    title: str,
    *,
    missing: str = "no value",
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw an optimum region over two quantities.

    Parameters
    ----------
    designs
        The designs and the chart.
    filled
        The quantity shown by colours and by black lines.
    lined
        The quantity shown by dashed lines.
    region
        The region, in chart coordinates.
    conditions
        The conditions that bound it, as they are to be written in the key.
    title
        Title of the figure.
    missing
        What the hatched area means, for the key.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Fig. 10. An empty region is said to
        be empty in the key.

    Raises
    ------
    InputError
        If the width is out of range, or values are not one for each design.
    """
    for layer in (filled, lined):
        designs.check(layer.values)
    absent, absent_lines = (absent_triangles(designs, each.values) for each in (filled, lined))
    levels, line_levels = (
        levels_of(layer.values[np.unique(designs.triangles[~gone])], _BANDS)
        for layer, gone in ((filled, absent), (lined, absent_lines))
    )
    region_look = {
        "facecolor": (*to_rgb(style.REGION), 0.45),
        "edgecolor": style.REGION,
        "linewidth": 1.0,
    }
    together = ", ".join(conditions)
    key = []
    if region.is_empty:
        key.append(KeyEntry(f"no design fulfils {together}", {}))
    else:
        key.append(KeyEntry(together, region_look))
    if len(line_levels):
        dashes = {"color": _LINES, "linestyle": _DASHES, "linewidth": 0.7}
        key.append(KeyEntry(lined.label, dashes))
    if absent.any():
        key.append(missing_entry(missing))
    with styled():
        below = key_height(key, width)
        below += bar_height(filled.label, width) if len(levels) else 0.0
        frame = chart_frame(designs.chart, title, width, below)
        draw_missing(frame, designs, absent)
        frame.fill("region", region.loops, REGION_LEVEL, **region_look)
        used = 0.0
        if len(levels):
            strong = style.colour_map()(np.linspace(0.0, 1.0, len(levels) - 1))
            colours = [style.mixed_with_white(colour, _PALE) for colour in strong]
            fill_between_levels(frame, designs, filled.values, absent, levels, colours)
            draw_levels(frame, designs, filled.values, absent, levels, clear=region.loops)
            ticks = [level_text(level, levels) for level in levels]
            used = draw_bar(frame, colours, ticks, filled.label)
        if len(line_levels):
            draw_levels(
                frame,
                designs,
                lined.values,
                absent_lines,
                line_levels,
                name="dashed-levels",
                colour=_LINES,
                width=0.6,
                dashes=_DASHES,
                clear=region.loops,
            )
        draw_key(frame, key, used)
        draw_sub_regions(frame)
        return frame.figure
