"""How drawings tell kinds of curves apart: by colour, and by the pattern of the line."""

from __future__ import annotations

import dataclasses
import re

from fivebar_atlas.curve_colours import CURVE_COLOURS


@dataclasses.dataclass(frozen=True, slots=True)
class CurveStyle:
    """The look of one kind of curve.

    Attributes
    ----------
    colour
        Red, green, blue as ``"#rrggbb"``.
    colour_index
        A numbered colour of CAD programs that is like it, legible on black and on white.
    dashes
        Lengths of strokes and gaps in turn, in thousandths of a drawing; empty if solid.
    line_type
        Name of the pattern in CAD programs.
    """

    colour: str
    colour_index: int
    dashes: tuple[float, ...] = ()
    line_type: str = "CONTINUOUS"


_COLOUR_INDICES = {
    "serial": 150,
    "parallel, folded": 30,
    "parallel, extended": 92,
    "parallel": 30,
    "limit": 8,
    "level": 6,
}
# Patterns that print in grey.
_DASHES = {
    "parallel, folded": ((10.0, 5.0), "DASHED"),
    "parallel, extended": ((12.0, 4.0, 2.0, 4.0), "DASHDOT2"),
    "parallel": ((10.0, 5.0), "DASHED"),
    "limit": ((2.0, 3.0), "DOT2"),
}
_STYLES = {
    kind: CurveStyle(colour, _COLOUR_INDICES[kind], *_DASHES.get(kind, ()))
    for kind, colour in CURVE_COLOURS.items()
}
_OTHER = CurveStyle("#000000", 7)


def style_of(kind: str) -> CurveStyle:
    """Return the look of a kind of curve."""
    return _STYLES.get(kind, _OTHER)


def identifier(name: str) -> str:
    """Return a name as layers and XML identifiers may have it: ``"LCI_0.5"``."""
    return re.sub(r"[^A-Za-z0-9.-]+", "_", name).strip("_")
