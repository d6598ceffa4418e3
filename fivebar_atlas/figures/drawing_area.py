"""The drawing area of a figure: a plane to scale, text in boxes, room below it.

Everything that has a size on paper is computed in millimetres first: a wider figure gets a
larger drawing and the same text.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.text_placement import Box, text_origin

FloatArray = npt.NDArray[np.float64]

#: Order of drawing.
FILL_LEVEL, MISSING_LEVEL, LINE_LEVEL, REGION_LEVEL, BORDER_LEVEL, TEXT_LEVEL = range(1, 7)


@dataclasses.dataclass(slots=True)
class DrawingArea:
    """A part of a figure in which a plane is drawn to scale.

    Attributes
    ----------
    figure
        The figure.
    axes
        The drawing area, in the coordinates of the plane.
    scale
        Millimetres per unit of the plane.
    occupied
        Boxes of the text in the drawing, millimetres from the plane's origin.
    width, bottom
        Width of the figure and height of the room below the drawing, in millimetres.
    """

    figure: Figure
    axes: Axes
    scale: float
    occupied: list[Box]
    width: float
    bottom: float

    def write(self, text: str, box: Box, size: float, halo: float = 0.0, **look: Any) -> None:
        """Write one line of text with its ink centred in a box (millimetres)."""
        x, y = text_origin(text, size, box)
        self.axes.text(
            x / self.scale,
            y / self.scale,
            text,
            fontsize=size,
            rotation=box.angle,
            rotation_mode="anchor",
            ha="left",
            va="baseline",
            path_effects=style.halo(halo) if halo else [],
            **{"zorder": TEXT_LEVEL, "color": style.INK, **look},
        )

    def fill(
        self, name: str, loops: Sequence[FloatArray], level: float, **look: Any
    ) -> PathPatch | None:
        """Fill a region given by closed loops, holes running the other way round.

        The name becomes the ``gid`` of the patch: the id of its group in an SVG file.
        """
        if not loops:
            return None
        vertices = np.concatenate([np.vstack([loop, loop[:1]]) for loop in loops])
        codes = np.concatenate(
            [[Path.MOVETO, *[Path.LINETO] * (len(loop) - 1), Path.CLOSEPOLY] for loop in loops]
        )
        patch = PathPatch(Path(vertices, codes), zorder=level, gid=name, **look)
        # not as a patch, whose limits would be looked for curve by curve
        self.axes.add_artist(patch)
        return patch

    def add_strip(self, left: float, below: float, width: float, height: float) -> Axes:
        """Add an empty drawing area; millimetres from left, and down from this one."""
        figure_height = self.figure.get_figheight() * style.MM_PER_INCH
        return self.figure.add_axes(
            (
                left / self.width,
                (self.bottom - below - height) / figure_height,
                width / self.width,
                height / figure_height,
            )
        )


def check_width(width: float) -> None:
    """Raise InputError unless a width is in the range of figure widths."""
    least, greatest = style.WIDTH_RANGE
    if not least <= width <= greatest:
        raise InputError("width", width, f"millimetres from {least:g} to {greatest:g}")
