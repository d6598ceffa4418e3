"""One colour for each kind of curve, in figures and in files for CAD programs alike.

Colours that the colour-blind tell apart (after Okabe and Ito); dashes, which print in grey,
are set where they are drawn.
"""

from __future__ import annotations

#: Colours as ``"#rrggbb"`` by the kind of :class:`planar_geometry.NamedArc`.
CURVE_COLOURS = {
    "serial": "#0072b2",
    "parallel, folded": "#d55e00",
    "parallel, extended": "#007a5a",
    "parallel": "#d55e00",
    "limit": "#5c5c5c",
    "level": "#d0006f",
}

#: Those of the limits of workspaces in space, by their kind.
LIMIT_COLOURS = {
    "longest limb": "#0072b2",
    "shortest limb": "#56b4e9",
    "base joint": "#b87700",
    "platform joint": "#007a5a",
    "range of α": "#7d4fa3",
    "revolute joint": "#111111",
    "singular": "#d55e00",
    "base plane": "#8c8c8c",
}
