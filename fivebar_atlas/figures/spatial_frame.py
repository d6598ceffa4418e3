"""The frame of a picture of space: a drawing to scale without axes around it."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.drawing_area import check_width
from fivebar_atlas.figures.plane_frame import PlaneFrame
from fivebar_atlas.figures.text_placement import wrapped
from fivebar_atlas.planar_geometry import FloatArray

# Millimetres on paper.
_PADDING, _LINE = 1.0, 3.5
# Share of the extent that is left free on each side; bounds of height over width.
_MARGIN, _LOWEST, _HIGHEST = 0.07, 0.4, 1.15


def spatial_frame(
    bounds: tuple[FloatArray, FloatArray], unit: str, title: str, width: float, below: float
) -> PlaneFrame:
    """Make a figure with one panel for what is projected.

    Parameters
    ----------
    bounds
        Lower left and upper right corner of what is to be shown; some room is left around.
    unit
        Unit of lengths; empty where they are non-dimensional.
    title
        Title; broken into lines where it is wider than the figure.
    width
        Width of the figure in millimetres.
    below
        Room to leave below the panel, in millimetres.

    Raises
    ------
    InputError
        If the width is not a number in the range of figure widths.
    """
    check_width(width)
    lower, upper = bounds
    middle, extent = 0.5 * (lower + upper), (1.0 + 2.0 * _MARGIN) * (upper - lower)
    extent[0] = max(extent[0], extent[1] / _HIGHEST)
    extent[1] = max(extent[1], _LOWEST * extent[0])
    panel = width - 2.0 * _PADDING
    scale = panel / float(extent[0])
    height = scale * float(extent[1])
    lines = wrapped(title, style.TITLE_SIZE, panel)
    bottom = below + _PADDING
    total = bottom + height + _LINE * len(lines) + 2.0 * _PADDING
    figure = Figure(figsize=(width / style.MM_PER_INCH, total / style.MM_PER_INCH))
    FigureCanvasAgg(figure)
    for number, line in enumerate(lines):
        figure.text(
            0.5,
            (total - _PADDING - _LINE * (number + 0.8)) / total,
            line,
            fontsize=style.TITLE_SIZE,
            ha="center",
            va="baseline",
            color=style.INK,
        )
    axes = figure.add_axes((_PADDING / width, bottom / total, panel / width, height / total))
    axes.set_axis_off()
    low, high = middle - extent / 2.0, middle + extent / 2.0
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    return PlaneFrame(figure, axes, scale, [], width, bottom, unit)


def bounds_on_paper(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box around projected points, shape (n, 2)."""
    return np.min(points, axis=0), np.max(points, axis=0)
