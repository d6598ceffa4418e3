"""The one look of all figures: fonts, line widths, colours, and how they are set.

Sizes are those on paper. Figures are made for one journal column (85 mm); a wider figure
keeps its font sizes. All fonts come with matplotlib, so a figure does not depend on what
is installed where it is made.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

import matplotlib as mpl
from matplotlib import patheffects
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_rgb

from fivebar_atlas.curve_colours import CURVE_COLOURS, LIMIT_COLOURS

#: Width of a journal column, and the narrowest and widest figure, in millimetres.
COLUMN_WIDTH = 85.0
WIDTH_RANGE = (60.0, 400.0)
#: Dots per inch of PNG files.
RESOLUTION = 300

MM_PER_INCH = 25.4
POINTS_PER_MM = 72.0 / MM_PER_INCH

TITLE_SIZE = 8.0
AXIS_LABEL_SIZE = 8.5
TICK_SIZE = 7.0
REGION_SIZE = 8.0
LEVEL_SIZE = 6.5
NOTE_SIZE = 7.0

OUTLINE_WIDTH = 0.8
BORDER_WIDTH = 0.7
LEVEL_WIDTH = 0.45

INK = "#111111"
MISSING = "#e4e4e4"
MISSING_HATCH = "#9a9a9a"
REGION = CURVE_COLOURS["level"]
WORKSPACE = "#dce9f2"
GOOD_CONDITION = "#7fb2d3"
FAINT = "#8c8c8c"
SLEEVE = "#f2f2f2"

CURVE_WIDTH = 1.0

_DASHES: dict[str, Any] = {
    "parallel, folded": (0.0, (4.0, 1.4)),
    "parallel, extended": (0.0, (6.0, 1.4, 1.2, 1.4)),
    "parallel": (0.0, (4.0, 1.4)),
    "limit": (0.0, (1.2, 1.0)),
}
_CURVES: dict[str, dict[str, Any]] = {
    kind: {"color": colour, "linestyle": _DASHES.get(kind, "solid")}
    for kind, colour in (CURVE_COLOURS | LIMIT_COLOURS).items()
}

_SETTINGS: dict[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "axes.linewidth": 0.5,
    "xtick.major.width": 0.5,
    "xtick.major.size": 2.0,
    "xtick.major.pad": 1.5,
    "ytick.major.width": 0.5,
    "ytick.major.size": 2.0,
    "ytick.major.pad": 1.5,
    "axes.unicode_minus": True,
    "axes.formatter.use_locale": False,
    "hatch.linewidth": 0.4,
    "text.usetex": False,
    "text.parse_math": True,
    # Hinting moves letters by parts of a pixel; text is placed by its unhinted size.
    "text.hinting": "no_hinting",
    "path.simplify": False,
    "savefig.dpi": RESOLUTION,
    "savefig.bbox": None,
    "savefig.facecolor": "white",
    "savefig.transparent": False,
    "pdf.fonttype": 42,
    "pdf.compression": 6,
    "svg.fonttype": "path",
    "svg.hashsalt": "fivebar-atlas",
}


@contextmanager
def styled() -> Iterator[None]:
    """Set the look for the time of a ``with`` block; what was set before comes back.

    Whatever a user's matplotlibrc says does not reach the figures: they start from
    matplotlib's own defaults.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        cast("dict[str, Any]", mpl.rcParams).update(_SETTINGS)
        yield


def colour_map() -> Colormap:
    """Return the sequential colour map: viridis without its darkest part.

    A part of a perceptually uniform map is perceptually uniform; without the dark end,
    black lines and numbers stay legible everywhere.
    """
    viridis = mpl.colormaps["viridis"]
    colours = viridis([0.22 + 0.78 * step / 255 for step in range(256)])
    return LinearSegmentedColormap.from_list("atlas", colours, N=256)


def category_colours(count: int) -> list[tuple[float, float, float]]:
    """Return light, distinguishable colours for ``count`` categories."""
    colours = mpl.colormaps["Set3"].resampled(12)(range(12))
    order = (4, 5, 3, 7, 0, 6, 2, 1, 9, 11, 10, 8)
    chosen = [colours[order[index % len(order)]] for index in range(count)]
    return [mixed_with_white(colour, 0.25) for colour in chosen]


def curve_look(kind: str) -> dict[str, Any]:
    """Return the look of a line for a kind of curve or of limit."""
    return {"color": INK, "linestyle": "solid", "linewidth": CURVE_WIDTH, **_CURVES.get(kind, {})}


def mixed_with_white(colour: Any, share: float) -> tuple[float, float, float]:
    """Return a colour with a share of white in it."""
    red, green, blue = (part + share * (1.0 - part) for part in to_rgb(colour))
    return red, green, blue


def halo(width: float = 1.6) -> list[patheffects.AbstractPathEffect]:
    """Return the white surround that keeps text legible on colours and lines.

    Parameters
    ----------
    width
        Width of the surround on each side and the line together, in points.
    """
    return [patheffects.withStroke(linewidth=width, foreground="white")]


def outlined(width: float) -> list[patheffects.AbstractPathEffect]:
    """Return the dark outline of a wide line, ``width`` points with the line."""
    return [patheffects.withStroke(linewidth=width, foreground=INK)]
