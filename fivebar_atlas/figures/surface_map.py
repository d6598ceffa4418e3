"""Surface maps: a quantity as heights above the design space, its contours on the floor below.

The floor is the contour map, seen obliquely. The surface floats above it, so far up that it
hides nothing of it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba_array
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.chart_frame import ChartFrame, chart_frame, draw_sub_regions
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.colour_bar import (
    KeyEntry,
    bar_height,
    draw_bar,
    draw_key,
    key_height,
    missing_entry,
)
from fivebar_atlas.figures.contour_levels import (
    level_text,
    magnitude_levels,
    magnitude_text,
    round_levels,
)
from fivebar_atlas.figures.contour_map import (
    absent_triangles,
    draw_levels,
    draw_missing,
    fill_between_levels,
    levels_of,
)
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL, FILL_LEVEL
from fivebar_atlas.figures.oblique_view import ObliqueView
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.surface_pieces import cut_at_levels
from fivebar_atlas.mechanisms.charts import ChartAxis, ChartTick, DesignChart

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

#: From where a surface is seen if nothing is said, in degrees.
DEFAULT_ELEVATION, DEFAULT_AZIMUTH = 25.0, -65.0

# Above everything but text: nothing of the floor is in front of the surface.
_SURFACE_LEVEL = BORDER_LEVEL + 0.5
# As shares of the width of the floor: height of the surface, room for labels below it.
_HEIGHT, _ROOM = 0.42, 0.1
# Lines in points. Pieces are widened by half of theirs, lest white shows between them.
_SEAM, _FOLD, _EDGE, _GRID = 0.3, 0.5, 0.7, 0.3
# A surface of more pieces than this is stored as an image in PDF and SVG files.
_MOST_PIECES = 20_000
_MOST_TICKS = 5


@dataclasses.dataclass(frozen=True, slots=True)
class _Heights:
    """What is drawn as heights, and its scale.

    Attributes
    ----------
    values
        Heights of the designs, NaN where there are none.
    levels, texts
        Levels between colours, at least two, and how they are written; no texts where all
        heights are one.
    ticks, tick_texts
        Ticks of the upright axis.
    has_lines
        Whether lines are drawn at levels.
    """

    values: FloatArray
    levels: FloatArray
    texts: list[str]
    ticks: FloatArray
    tick_texts: list[str]
    has_lines: bool


def surface_map(
    designs: ChartedDesigns,
    values: FloatArray,
    title: str,
    label: str,
    symbol: str,
    *,
    view: ObliqueView | None = None,
    magnitudes: bool = False,
    missing: str = "no value",
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw a quantity as a surface above the design space, with its contours on the floor.

    Parameters
    ----------
    designs
        The designs and the chart.
    values
        One value for each design, shape (n,); NaN where there is none.
    title, label, symbol
        Title of the figure, name and unit for the colour bar, and symbol for the upright axis.
    view
        From where it is seen.
    magnitudes
        Whether heights are logarithms of positive values, such as error estimates.
    missing
        What the hatched area means, for the key.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Nam and Park 2006, Figs. 4 to 7. The surface has holes where a
        design has no value.

    Raises
    ------
    InputError
        If the width is out of range, or the values are not one for each design.
    """
    designs.check(values)
    view = ObliqueView(DEFAULT_ELEVATION, DEFAULT_AZIMUTH) if view is None else view
    heights = _magnitudes(designs, values) if magnitudes else _heights(designs, values)
    absent = absent_triangles(designs, heights.values)
    colours = list(style.colour_map()(np.linspace(0.0, 1.0, len(heights.levels) - 1)))
    key = []
    if not heights.texts:
        colours = [style.colour_map()(0.5)]
    if not heights.texts and not absent.all():
        text = f"{label}: {heights.tick_texts[0]} everywhere"
        key.append(KeyEntry(text, {"facecolor": colours[0], "linewidth": 0.0}))
    if absent.any():
        key.append(missing_entry(_why_missing(values, missing) if magnitudes else missing))
    scene = _Scene.of_chart(designs.chart, view, heights.levels)
    floor = dataclasses.replace(designs, points=view.place(designs.points), chart=scene.chart)
    with styled():
        below = key_height(key, width) + (bar_height(label, width) if heights.texts else 0.0)
        reach = np.concatenate([scene.corners(level) for level in heights.levels[[0, -1]]])
        frame = chart_frame(scene.chart, title, width, below, scene.axis(heights, symbol), reach)
        _draw_walls(frame, scene, heights)
        draw_missing(frame, floor, absent)
        if not absent.all():
            fill_between_levels(frame, floor, heights.values, absent, heights.levels, colours)
            _draw_surface(frame, scene, designs, heights, absent, colours)
        used = 0.0
        if heights.has_lines:
            draw_levels(frame, floor, heights.values, absent, heights.levels)
        if heights.texts:
            used = draw_bar(frame, colours, heights.texts, label)
        draw_key(frame, key, used)
        draw_sub_regions(frame)
        return frame.figure


def _heights(designs: ChartedDesigns, values: FloatArray) -> _Heights:
    """Return values as they are, between the levels of a contour map."""
    values = np.where(np.isfinite(values), values, np.nan)
    shown = values[np.unique(designs.triangles[~absent_triangles(designs, values)])]
    levels = levels_of(shown)
    if len(levels):
        texts = [level_text(level, levels) for level in levels]
        ticks = round_levels(levels[0], levels[-1], _MOST_TICKS)
        ticks = ticks[(ticks >= levels[0]) & (ticks <= levels[-1])]
        tick_texts = [level_text(tick, ticks) for tick in ticks]
        return _Heights(values, levels, texts, ticks, tick_texts, has_lines=True)
    middle = shown[:1]
    around = np.array([-1.0, 1.0]) * (np.abs(middle).max(initial=0.0) or 1.0)
    text = [f"{value:.6g}".replace("-", "\N{MINUS SIGN}") for value in middle]
    return _Heights(values, middle.sum() + around, [], middle, text, has_lines=False)


def _magnitudes(designs: ChartedDesigns, values: FloatArray) -> _Heights:
    """Return the decimal logarithms of positive values, between round levels of these.

    Without lines: errors scatter from design to design.
    """
    positive = np.where(np.isfinite(values) & (values > 0.0), values, np.nan)
    shown = positive[np.unique(designs.triangles[~absent_triangles(designs, positive)])]
    logarithms = np.log10(positive)
    if not len(shown):
        return _heights(designs, logarithms)
    levels = magnitude_levels(float(shown.min()), float(shown.max()))
    texts = [magnitude_text(level) for level in levels]
    places = np.log10(levels)
    chosen = slice(None, None, -(-len(levels) // (_MOST_TICKS + 1)))
    return _Heights(logarithms, places, texts, places[chosen], texts[chosen], has_lines=False)


def _why_missing(values: FloatArray, missing: str) -> str:
    """Return why there are holes in a surface of magnitudes."""
    if not (values == 0.0).any():
        return missing
    return f"{missing}, or 0 (exact)" if np.isnan(values).any() else "0 (exact)"


@dataclasses.dataclass(frozen=True, slots=True)
class _Scene:
    """Where on paper the floor is, and heights above it, in units of the chart.

    Attributes
    ----------
    view
        From where it is seen.
    plan
        The chart.
    chart
        The chart as it is seen: the floor.
    least, base, slope
        A value is drawn ``base + slope (value - least)`` above its place on the floor.
    """

    view: ObliqueView
    plan: DesignChart
    chart: DesignChart
    least: float
    base: float
    slope: float

    @classmethod
    def of_chart(cls, plan: DesignChart, view: ObliqueView, levels: FloatArray) -> _Scene:
        """Return the scene in which the surface between two levels hides nothing of the floor."""
        chart = view.chart(plan)
        across = float(np.ptp(chart.outline[:, 0]))
        return cls(
            view=view,
            plan=plan,
            chart=chart,
            least=float(levels[0]),
            base=_longest_chord(chart.outline) + _ROOM * across,
            slope=_HEIGHT * across / float(levels[-1] - levels[0]),
        )

    def place(self, points: FloatArray, values: FloatArray | float) -> FloatArray:
        """Return where points of the chart are seen if they are raised to values."""
        return self.view.place(points, self.base + self.slope * (values - self.least))

    def corners(self, value: float) -> FloatArray:
        """Return the corners of the chart raised to a value, shape (k, 2)."""
        return self.place(self.plan.outline, value)

    @property
    def post(self) -> FloatArray:
        """The corner of the chart that is seen leftmost, shape (2,)."""
        left = self.chart.outline.min(axis=0)[0]
        is_left = self.chart.outline[:, 0] <= left + 1e-9 * np.ptp(self.chart.outline[:, 0])
        corners = self.plan.outline[is_left]
        nearest: FloatArray = corners[np.argmax(self.view.nearness(corners))]
        return nearest

    @property
    def back_sides(self) -> FloatArray:
        """Sides of the chart that face away from the viewer, shape (k, 2, 2)."""
        outline = self.plan.outline
        sides = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)
        x, y = self.chart.outline.T
        # Twice the area: positive if the outline runs counter-clockwise, its back leftward.
        turn = np.sign(x @ np.roll(y, -1) - y @ np.roll(x, -1))
        return np.asarray(sides[turn * (np.roll(x, -1) - x) < -1e-9 * np.ptp(x)])

    def axis(self, heights: _Heights, symbol: str) -> ChartAxis:
        """Return the upright axis."""
        ticks = []
        for tick, text in zip(heights.ticks, heights.tick_texts, strict=True):
            x, y = self.place(self.post, float(tick)).tolist()
            ticks.append(ChartTick(text, x, y, -1.0, 0.0))
        x, y = self.place(self.post, float(heights.levels[-1])).tolist()
        return ChartAxis(symbol, x, y, 0.0, tuple(ticks))


def _longest_chord(outline: FloatArray) -> float:
    """Return the length of the longest vertical chord of a convex polygon.

    The longest of all passes through a corner.
    """
    longest = 0.0
    sides = np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)
    for x in outline[:, 0]:
        heights = [
            np.interp(x, *(side[np.argsort(side[:, 0])].T))
            for side in sides
            if side[:, 0].min() <= x <= side[:, 0].max()
        ]
        longest = max(longest, float(np.ptp(heights)))
    return longest


def _draw_walls(frame: ChartFrame, scene: _Scene, heights: _Heights) -> None:
    """Draw lines at the ticks behind the surface, and what carries it."""
    low, high = heights.levels[[0, -1]]
    lines = [scene.place(side, tick) for side in scene.back_sides for tick in heights.ticks]
    lines += [
        np.stack([scene.view.place(corner), scene.place(corner, high)])
        for corner in np.unique(scene.back_sides.reshape(-1, 2), axis=0)
    ]
    frame.axes.add_collection(
        LineCollection(
            lines, gid="walls", linewidths=_GRID, colors=style.FAINT, zorder=FILL_LEVEL - 0.5
        ),
        autolim=False,
    )
    post = [scene.place(scene.post, low), scene.place(scene.post, high)]
    frame.axes.add_collection(
        LineCollection(
            [post],
            gid="upright",
            linewidths=style.OUTLINE_WIDTH,
            colors=style.INK,
            zorder=_SURFACE_LEVEL,
        ),
        autolim=False,
    )


def _draw_surface(
    frame: ChartFrame,
    scene: _Scene,
    designs: ChartedDesigns,
    heights: _Heights,
    absent: BoolArray,
    colours: list[tuple[float, ...]],
) -> None:
    """Draw the surface from far to near, with lines at levels, around it and at its folds."""
    triangles = designs.triangles[~absent]
    corners = scene.place(designs.points[triangles], heights.values[triangles])
    pieces = cut_at_levels(heights.values[triangles], heights.levels)
    shapes = np.einsum("kpc,kcx->kpx", pieces.weights, corners[pieces.triangles])
    rank = np.argsort(np.argsort(scene.view.nearness(designs.points[triangles].mean(axis=1))))
    sides = _Sides.of_triangles(triangles)
    is_turned = np.sign(_areas(corners)) * np.sign(_areas(designs.points[triangles])) < 0.0
    is_fold = is_turned[sides.first] != is_turned[sides.second]
    # What is drawn on a triangle comes after its neighbours, whose seams would cover parts of
    # it, unless the surface is folded between them.
    after = rank.copy()
    for one, other in ((sides.first, sides.second), (sides.second, sides.first)):
        np.maximum.at(after, one, np.where(is_fold, 0, rank[other]))
    is_drawn = is_fold | (sides.first == sides.second)
    edges = corners[sides.first[:, np.newaxis], sides.ends][is_drawn]
    is_line = pieces.is_cut & heights.has_lines
    parts = (
        (shapes, rank[pieces.triangles], to_rgba_array(colours)[pieces.bands], _SEAM),
        (
            shapes[is_line][:, [3, 4, 4, 4, 4]],
            after[pieces.triangles[is_line]] + 0.25,
            to_rgba_array(style.INK),
            style.LEVEL_WIDTH,
        ),
        (
            edges[:, [0, 1, 1, 1, 1]],
            np.maximum(after[sides.first], after[sides.second])[is_drawn] + 0.5,
            to_rgba_array(style.INK),
            np.where(is_fold[is_drawn], _FOLD, _EDGE),
        ),
    )
    order = np.argsort(np.concatenate([each[1] for each in parts]), kind="stable")
    drawn = np.concatenate([np.broadcast_to(each[2], (len(each[0]), 4)) for each in parts])
    widths = np.concatenate([np.broadcast_to(each[3], len(each[0])) for each in parts])
    frame.axes.add_collection(
        PolyCollection(
            list(np.concatenate([each[0] for each in parts])[order]),
            facecolors=drawn[order],
            edgecolors=drawn[order],
            linewidths=widths[order],
            joinstyle="round",
            capstyle="round",
            zorder=_SURFACE_LEVEL,
            gid="surface",
            rasterized=len(order) > _MOST_PIECES,
        ),
        autolim=False,
    )


@dataclasses.dataclass(frozen=True, slots=True)
class _Sides:
    """Sides of triangles.

    Attributes
    ----------
    first, second
        The two triangles of each side, the same one where there is no other, shape (k,).
    ends
        Which corners of the first triangle it joins, shape (k, 2).
    """

    first: IntArray
    second: IntArray
    ends: IntArray

    @classmethod
    def of_triangles(cls, triangles: IntArray) -> _Sides:
        """Return every side of triangles, indices of shape (m, 3), once."""
        corners = np.array([[0, 1], [1, 2], [2, 0]])
        pairs = np.sort(triangles[:, corners].reshape(-1, 2), axis=1)
        _, number = np.unique(pairs, axis=0, return_inverse=True)
        order = np.argsort(number.ravel(), kind="stable")
        counts = np.bincount(number.ravel())
        last = np.cumsum(counts) - 1
        first, second = order[last - counts + 1], order[last]
        return cls(first // 3, second // 3, corners[first % 3])


def _areas(corners: FloatArray) -> FloatArray:
    """Return twice the signed areas of triangles, shape (m, 3, 2)."""
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
