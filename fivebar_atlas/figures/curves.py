"""Named arcs in a figure: lines by kind, symbols on them, marks where they meet, the key."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry
from fivebar_atlas.figures.drawing_area import BORDER_LEVEL, LINE_LEVEL
from fivebar_atlas.figures.label_boxes import SPACING, beside_curve, best_box
from fivebar_atlas.figures.plane_frame import PlaneFrame, flatness
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.text_placement import Box, points_along, text_size
from fivebar_atlas.planar_geometry import (
    CUSP,
    INTERSECTION,
    TANGENCY,
    FloatArray,
    NamedArc,
    Point,
)

#: Order of drawing of curves that are not the subject.
BACKGROUND_LEVEL = LINE_LEVEL - 0.2

# Ends of arcs closer than this share of their distance from the origin are one.
_SAME = 1e-7

_VERTEX: dict[str, Any] = {
    "linestyle": "none",
    "color": style.INK,
    "markeredgecolor": style.INK,
    "markeredgewidth": 0.5,
    "markerfacecolor": "white",
    "zorder": BORDER_LEVEL,
}
_VERTICES: dict[str, dict[str, Any]] = {
    TANGENCY: {**_VERTEX, "marker": "o", "markersize": 2.6},
    CUSP: {**_VERTEX, "marker": "D", "markersize": 2.4, "markerfacecolor": style.INK},
    INTERSECTION: {**_VERTEX, "marker": "s", "markersize": 2.4},
}
_ISOLATED: dict[str, Any] = {
    **_VERTEX,
    "marker": "o",
    "markersize": 2.6,
    **{"markerfacecolor": style.curve_look("serial")["color"], "markeredgewidth": 0.0},
}


def draw_arcs(
    frame: PlaneFrame,
    arcs: Sequence[NamedArc],
    element: str,
    data: PlottedData | None = None,
    **look: Any,
) -> None:
    """Draw arcs in the look of their kind; whatever ``look`` says comes first.

    The ``gid`` of the first arc of a curve is its name and 1, ``"C_1o-1"``.
    """
    deviation = flatness(*frame.corners)
    seen: dict[str, int] = {}
    for each in arcs:
        points = each.arc.polyline(deviation)
        number = seen[each.name] = seen.get(each.name, 0) + 1
        frame.line(points, f"{each.name}-{number}", **{**style.curve_look(each.kind), **look})
        if data is not None:
            data.add(element, points, each.name, each.kind)


@dataclasses.dataclass(frozen=True, slots=True)
class MarkedPoints:
    """Points of one kind, as they are marked.

    Attributes
    ----------
    name
        Their ``gid`` and their element in the plotted data.
    points
        The points, at least one.
    look
        Look of the marks.
    """

    name: str
    points: tuple[Point, ...]
    look: dict[str, Any]

    @property
    def entry(self) -> KeyEntry:
        """The entry of the key."""
        return KeyEntry(self.name, {**self.look, "markevery": [1]})

    def draw(self, frame: PlaneFrame, data: PlottedData | None = None) -> None:
        """Draw the marks; labels keep off them."""
        frame.line(np.array(self.points), self.name, **self.look)
        size = self.look["markersize"] / style.POINTS_PER_MM
        for x, y in self.points:
            frame.occupied.append(Box(x * frame.scale, y * frame.scale, size, size))
        if data is not None:
            data.add(self.name, self.points)


def marked_points(arcs: Sequence[NamedArc], isolated: Sequence[Point] = ()) -> list[MarkedPoints]:
    """Return where arcs touch, turn back or cross, and singular points on no arc."""
    found: list[MarkedPoints] = []
    for kind, look in _VERTICES.items():
        points: list[Point] = []
        for each in arcs:
            for end, point in zip(each.ends, (each.arc.start, each.arc.end), strict=True):
                near = _SAME * math.hypot(*point)
                if end == kind and all(math.dist(point, other) > near for other in points):
                    points.append(point)
        if points:
            found.append(MarkedPoints(kind, tuple(points), look))
    if isolated:
        found.append(MarkedPoints("isolated singular point", tuple(isolated), _ISOLATED))
    return found


def kind_entries(arcs: Iterable[NamedArc]) -> list[KeyEntry]:
    """Return one entry of the key for each kind of curve, with the symbols of its curves."""
    symbols: dict[str, dict[str, None]] = {}
    for each in sorted(arcs, key=lambda each: each.name):
        symbols.setdefault(each.kind, {})[each.symbol] = None
    return [
        KeyEntry(f"{kind}: {', '.join(of_kind)}", style.curve_look(kind))
        for kind, of_kind in symbols.items()
    ]


def label_curves(
    frame: PlaneFrame, arcs: Sequence[NamedArc], lines: Sequence[FloatArray] = ()
) -> None:
    """Write the symbol of every curve beside it, where it covers nothing.

    Lines to keep off, besides the arcs, are in the units of the plane, shape (n, 2) each.
    """
    deviation = flatness(*frame.corners)
    curves = [
        (each, points_along(each.arc.polyline(deviation) * frame.scale, SPACING)) for each in arcs
    ]
    nothing = np.empty((0, 2))
    more = [nothing, *(points_along(frame.scale * line, SPACING) for line in lines)]
    covered = np.concatenate([*more, *(points for _, points in curves)])
    for symbol, kind in {each.symbol: each.kind for each in arcs}.items():
        size = text_size(symbol, style.REGION_SIZE)
        own = [points for each, points in curves if each.symbol == symbol]
        others = [points for each, points in curves if each.symbol != symbol]
        places = (
            place
            for points in own
            for place in beside_curve(points, np.concatenate([*more, *others]), *size)
        )
        box = best_box(places, frame.outline, covered, frame.cross, frame.occupied)
        if box is not None:
            frame.occupied.append(box)
            colour = style.curve_look(kind)["color"]
            frame.write(symbol, box, style.REGION_SIZE, halo=1.2, color=colour)
