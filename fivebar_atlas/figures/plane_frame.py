"""The frame of a figure of the plane: axes in one scale, ticks, title; one panel or several."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fivebar_atlas.figures import style
from fivebar_atlas.figures.contour_levels import level_text
from fivebar_atlas.figures.drawing_area import LINE_LEVEL, DrawingArea, check_width
from fivebar_atlas.figures.text_placement import Box, points_along, text_size, wrapped
from fivebar_atlas.figures.wording import coordinate_label
from fivebar_atlas.planar_geometry import FloatArray, NamedArc, Region

# Millimetres on paper.
_PADDING = 1.0
_LINE = 3.5
_TICK = 0.7
_TICK_GAP = 0.6
_LABEL_GAP = 1.3
_PANEL_GAP = 4.0
_TICK_SPACING = 9.0
# Share of the extent that is left free on each side.
_MARGIN = 0.06
# Bounds of height over width of a panel.
_LOWEST, _HIGHEST = 0.4, 1.3
# Chords leave curves by no more than this share of what is drawn.
_FLATNESS = 2e-5


@dataclasses.dataclass(slots=True)
class PlaneFrame(DrawingArea):
    """A panel with axes x and y in one scale.

    Attributes
    ----------
    unit
        Unit of the coordinates; empty where they are non-dimensional.
    """

    unit: str

    @property
    def corners(self) -> FloatArray:
        """Lower left and upper right corner of the panel, shape (2, 2)."""
        return np.array([self.axes.get_xlim(), self.axes.get_ylim()]).T

    @property
    def outline(self) -> FloatArray:
        """The panel's outline in millimetres from the origin, shape (4, 2)."""
        (left, low), (right, high) = self.corners * self.scale
        return np.array([[left, low], [right, low], [right, high], [left, high]])

    @property
    def cross(self) -> FloatArray:
        """Points of the lines x = 0 and y = 0 in millimetres from the origin, shape (n, 2)."""
        (left, low), _, (right, high), _ = self.outline
        ends = (((left, 0.0), (right, 0.0)), ((0.0, low), (0.0, high)))
        return np.concatenate([points_along(np.array(pair)) for pair in ends])

    def line(self, points: FloatArray, name: str, **look: Any) -> Line2D:
        """Draw a line through points, shape (n, 2); the name becomes its ``gid``."""
        look = {"zorder": LINE_LEVEL, "solid_capstyle": "round", **look}
        (drawn,) = self.axes.plot(points[:, 0], points[:, 1], gid=name, **look)
        return drawn


def flatness(lower: FloatArray, upper: FloatArray) -> float:
    """Return how far chords may leave the curves of a drawing with these bounds."""
    return _FLATNESS * float(np.max(upper - lower))


def bounds_of(points: Iterable[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the lower left and upper right corner of the box around points.

    The points have the shape (2,) or (n, 2) each.
    """
    together = np.vstack(list(points))
    return together.min(axis=0), together.max(axis=0)


def bounds_of_arcs(arcs: Iterable[NamedArc]) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box around arcs, to a fraction of a line's width."""
    curves = [each.arc for each in arcs]
    fine = flatness(*bounds_of(curve.polyline(math.inf) for curve in curves))
    return bounds_of(curve.polyline(fine) for curve in curves)


def bounds_of_region(region: Region) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box around a region."""
    return bounds_of_arcs(region.outline.arcs)


def plane_frame(
    bounds: tuple[FloatArray, FloatArray],
    unit: str,
    title: str,
    width: float,
    below: float,
    labels: tuple[str, str] | None = None,
) -> PlaneFrame:
    """Make a figure with one panel.

    Parameters
    ----------
    bounds
        Lower left and upper right corner of what is to be shown; some room is left around.
    unit
        Unit of the coordinates; empty where they are non-dimensional.
    title
        Title; broken into lines where it is wider than the figure.
    width
        Width of the figure in millimetres.
    below
        Room to leave below the panel and its axis label, in millimetres.
    labels
        Labels of the axes; x and y in their unit if not given.

    Raises
    ------
    InputError
        If the width is not a number in the range of figure widths.
    """
    return plane_frames(bounds, unit, title, [()], 1, width, below, labels)[0]


def plane_frames(
    bounds: tuple[FloatArray, FloatArray],
    unit: str,
    title: str,
    captions: Sequence[Sequence[str]],
    columns: int,
    width: float,
    below: float,
    labels: tuple[str, str] | None = None,
) -> list[PlaneFrame]:
    """Make a figure with panels of one size that show the same part of the plane.

    Parameters
    ----------
    bounds, unit, title, width, below, labels
        As in :func:`plane_frame`.
    captions
        For each panel the lines written above it; all have as many.
    columns
        Panels side by side.

    Returns
    -------
    list of PlaneFrame
        The panels, row by row.

    Raises
    ------
    InputError
        If the width is not a number in the range of figure widths.
    """
    check_width(width)
    rows = math.ceil(len(captions) / columns)
    x_label, y_label = labels or (coordinate_label("$x$", unit), coordinate_label("$y$", unit))
    label_height = text_size(x_label, style.AXIS_LABEL_SIZE)[1]
    right = _PADDING + 1.5
    widest = 4.0
    for _ in range(3):  # ticks have a width of their own, so the scale follows from it
        left = _PADDING + label_height + _LABEL_GAP + widest + _TICK_GAP + _TICK
        panel = (width - left - right - _PANEL_GAP * (columns - 1)) / columns
        lower, upper, scale = _fitted(*bounds, panel)
        step = _tick_step(scale)
        ticks = [_multiples(step, *ends) for ends in zip(lower, upper, strict=True)]
        texts = [[_tick_text(tick, step) for tick in each] for each in ticks]
        widest = max(text_size(text, style.TICK_SIZE)[0] for text in texts[1])
    height = float(scale * (upper[1] - lower[1]))
    lines = wrapped(title, style.TITLE_SIZE, width - 2 * _PADDING)
    caption = _LINE * len(captions[0]) + (0.4 if captions[0] else 0.0)
    tick_room = _TICK + _TICK_GAP + text_size("0", style.TICK_SIZE)[1]
    bottom = below + _PADDING + label_height + _LABEL_GAP + tick_room
    row_height = caption + height + tick_room + _PANEL_GAP / 2
    top = _PADDING + _LINE * len(lines) + _PADDING
    total = bottom - tick_room + rows * row_height - _PANEL_GAP / 2 + top

    figure = Figure(figsize=(width / style.MM_PER_INCH, total / style.MM_PER_INCH))
    FigureCanvasAgg(figure)
    for number, line in enumerate(lines):
        _centred(figure, line, width / 2, total - _PADDING - _LINE * (number + 0.8), width, total)
    frames = []
    for place, texts_above in enumerate(captions):
        row, column = divmod(place, columns)
        x = left + column * (panel + _PANEL_GAP)
        y = total - top - row * row_height - caption - height
        axes = figure.add_axes((x / width, y / total, panel / width, height / total))
        axes.set_xlim(lower[0], upper[0])
        axes.set_ylim(lower[1], upper[1])
        is_lowest = place + columns >= len(captions)
        _set_ticks(axes, ticks, texts, with_y=column == 0)
        for number, line in enumerate(texts_above):
            baseline = y + height + caption - _LINE * (number + 0.8)
            _centred(figure, line, x + panel / 2, baseline, width, total, style.NOTE_SIZE)
        frame = PlaneFrame(figure, axes, scale, [], width, below, unit)
        if is_lowest:
            down = tick_room + _LABEL_GAP + label_height / 2
            _label(frame, x_label, (panel / 2, -down), 0.0)
        if column == 0:
            aside = _TICK + _TICK_GAP + widest + _LABEL_GAP + label_height / 2
            _label(frame, y_label, (-aside, height / 2), 90.0)
        frames.append(frame)
    return frames


def draw_origin(frame: PlaneFrame) -> None:
    """Draw the lines x = 0 and y = 0, faint and below everything else."""
    look = {"color": style.FAINT, "linewidth": 0.35, "zorder": LINE_LEVEL - 0.5}
    (left, low), (right, high) = frame.corners
    frame.line(np.array([[left, 0.0], [right, 0.0]]), "x-axis", **look)
    frame.line(np.array([[0.0, low], [0.0, high]]), "y-axis", **look)


def _fitted(
    lower: FloatArray, upper: FloatArray, panel: float
) -> tuple[FloatArray, FloatArray, float]:
    """Return corners with some room around and the scale; the panel is neither low nor high."""
    middle, extent = (lower + upper) / 2.0, (1.0 + 2.0 * _MARGIN) * (upper - lower)
    extent[0] = max(extent[0], extent[1] / _HIGHEST)
    extent[1] = max(extent[1], _LOWEST * extent[0])
    return middle - extent / 2.0, middle + extent / 2.0, panel / float(extent[0])


def _tick_step(scale: float) -> float:
    """Return the round step between ticks that are far enough apart to be read."""
    least = _TICK_SPACING / scale
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least)


def _multiples(step: float, low: float, high: float) -> FloatArray:
    return step * np.arange(math.ceil(low / step), math.floor(high / step) + 1, dtype=np.float64)


def _tick_text(tick: float, step: float) -> str:
    return level_text(tick, np.array([0.0, step]))


def _set_ticks(
    axes: Axes, ticks: Sequence[FloatArray], texts: Sequence[Sequence[str]], with_y: bool
) -> None:
    look: dict[str, Any] = {
        "labelsize": style.TICK_SIZE,
        "labelcolor": style.INK,
        "color": style.INK,
    }
    axes.tick_params(
        length=_TICK * style.POINTS_PER_MM, pad=_TICK_GAP * style.POINTS_PER_MM, **look
    )
    axes.set_xticks(ticks[0], list(texts[0]))
    axes.set_yticks(ticks[1], list(texts[1]) if with_y else [""] * len(ticks[1]))


def _centred(
    figure: Figure,
    text: str,
    x: float,
    y: float,
    width: float,
    height: float,
    size: float = style.TITLE_SIZE,
) -> None:
    """Write a line of text around a place in millimetres from the figure's lower left corner."""
    look: dict[str, Any] = {"fontsize": size, "ha": "center", "va": "baseline", "color": style.INK}
    figure.text(x / width, y / height, text, **look)


def _label(frame: PlaneFrame, text: str, place: tuple[float, float], angle: float) -> None:
    """Write an axis label around a place in millimetres from the panel's lower left corner."""
    left, low = frame.outline[0]
    size = text_size(text, style.AXIS_LABEL_SIZE)
    frame.write(text, Box(left + place[0], low + place[1], *size, angle), style.AXIS_LABEL_SIZE)
