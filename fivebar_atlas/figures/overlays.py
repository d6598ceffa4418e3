"""What is drawn into a figure of a design: a practical workspace and where it touches."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry
from fivebar_atlas.figures.drawing_area import REGION_LEVEL
from fivebar_atlas.figures.plane_frame import PlaneFrame
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.planar_geometry import FloatArray, Point

_OUTLINE: dict[str, Any] = {"color": style.REGION, "linewidth": 1.1, "linestyle": "solid"}
_DASHES = (0.0, (3.0, 1.5))
_POINTS: dict[str, Any] = {
    "linestyle": "none",
    "color": style.REGION,
    "marker": "o",
    "markersize": 3.4,
    "markeredgewidth": 0.6,
    "markeredgecolor": "white",
}


@dataclasses.dataclass(frozen=True, slots=True)
class Overlay:
    """A closed outline, and points to be marked, in the lengths of a design.

    Attributes
    ----------
    label
        What it is, for the key: ``"rectangle 300 x 200 mm"``.
    outline
        Points of the outline, shape (n, 2), without repeating the first one.
    points
        Points on it that are marked.
    points_label
        What they are, for the key.
    dashed
        Whether the outline is dashed.
    """

    label: str
    outline: FloatArray
    points: tuple[Point, ...] = ()
    points_label: str = ""
    dashed: bool = False

    @property
    def closed(self) -> FloatArray:
        """The outline with its first point at the end as well, shape (n + 1, 2)."""
        return np.vstack([self.outline, self.outline[:1]])

    @property
    def look(self) -> dict[str, Any]:
        """The look of the outline."""
        return {**_OUTLINE, "linestyle": _DASHES} if self.dashed else _OUTLINE

    @property
    def entries(self) -> list[KeyEntry]:
        """The entries of the key."""
        entries = [KeyEntry(self.label, self.look)]
        if self.points:
            entries.append(KeyEntry(self.points_label, {**_POINTS, "markevery": [1]}))
        return entries


def overlay_rows(overlays: Sequence[Overlay]) -> list[list[KeyEntry]]:
    """Return the rows of the key for overlays, one for each."""
    return [overlay.entries for overlay in overlays]


def draw_overlays(
    frame: PlaneFrame, overlays: Sequence[Overlay], data: PlottedData | None = None
) -> None:
    """Draw overlays above curves and below text; the ``gid`` of the first is ``overlay-1``."""
    for number, overlay in enumerate(overlays, start=1):
        look = {**overlay.look, "path_effects": style.halo(2.0), "zorder": REGION_LEVEL}
        frame.line(overlay.closed, f"overlay-{number}", **look)
        if data is not None:
            data.add(overlay.label, overlay.closed)
        if overlay.points:
            points = np.array(overlay.points)
            frame.line(points, f"overlay-points-{number}", **_POINTS, zorder=REGION_LEVEL + 0.1)
            if data is not None:
                data.add(overlay.points_label, points)
