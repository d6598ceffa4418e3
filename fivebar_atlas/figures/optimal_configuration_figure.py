"""The linkage in its optimal configuration, in the notation of Le, Kang and Doan."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key_rows, key_rows_height
from fivebar_atlas.figures.linkage import draw_linkage, label_linkage
from fivebar_atlas.figures.plane_frame import bounds_of, draw_origin, plane_frame
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.wording import mode_text, number_text
from fivebar_atlas.mechanisms.planar import BASE, CRANK, DISTAL, Pose

_SYMBOLS = {BASE: "$l_0$", CRANK: "$l_1$", DISTAL: "$l_2$"}
_AXES = ("$x/l_1$", "$y/l_1$")
# Share of the linkage's extent that is left for labels around it.
_ROOM = 0.06


def optimal_configuration_figure(
    pose: Pose,
    ratio: float,
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw a linkage in its optimal configuration, joints, links and input angles named.

    Parameters
    ----------
    pose
        The configuration, in lengths of the actuated link.
    ratio
        ρ = l2/l1.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Le, Kang and Doan 2013, Fig. 3.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    named = dataclasses.replace(
        pose,
        links=tuple(dataclasses.replace(link, symbol=_SYMBOLS[link.kind]) for link in pose.links),
    )
    lower, upper = bounds_of(np.array([joint.position]) for joint in pose.joints)
    room = _ROOM * float(np.max(upper - lower))
    rows = [[KeyEntry(text, {})] for text in _facts(pose, ratio)]
    title = rf"Optimal configuration, $\rho = l_2/l_1$ = {number_text(ratio)}, "
    title += mode_text(pose.mode)
    with styled():
        below = key_rows_height(rows, width)
        frame = plane_frame((lower - room, upper + room), "", title, width, below, _AXES)
        draw_origin(frame)
        draw_linkage(frame, named, data=data)
        label_linkage(frame, named)
        draw_key_rows(frame, rows)
        return frame.figure


def _facts(pose: Pose, ratio: float) -> list[str]:
    """Return base, position, input angles and index, with the equations of the first two."""
    base = number_text(math.sqrt(0.5) * (ratio - 1.0), 5)
    height = number_text(pose.output[1], 5)
    angles = ", ".join(
        f"{symbol} = {number_text(round(math.degrees(angle), 2))}°"
        for symbol, angle in zip(pose.input_symbols, pose.inputs, strict=True)
    )
    return [
        rf"$l_0 = (l_2-l_1)/\sqrt{{2}}$ = {base} $l_1$",
        rf"$P = (0, (l_1+l_2)/\sqrt{{2}})$ = (0, {height}) $l_1$",
        f"{angles}, LCI = {pose.lci:.4f}",
    ]
