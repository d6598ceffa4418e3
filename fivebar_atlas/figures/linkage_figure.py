"""The linkage itself, in one pose or in all that solve a kinematic problem."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key, key_height
from fivebar_atlas.figures.linkage import BOLD, MEDIUM, draw_linkage, label_linkage
from fivebar_atlas.figures.plane_frame import bounds_of, draw_origin, plane_frames
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.wording import (
    design_text,
    mode_text,
    number_text,
    point_text,
    title_text,
)
from fivebar_atlas.mechanisms.planar import OUTPUT, PlanarDesign, Pose

# Share of a linkage's extent that is left for labels around it.
_ROOM = 0.06
# A panel narrower than this, in millimetres, is hard to read.
_NARROWEST = 36.0


def linkage_figure(
    design: PlanarDesign,
    poses: Sequence[Pose],
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw a linkage in one pose, or in several side by side, joints and links labelled.

    Parameters
    ----------
    design
        The design.
    poses
        One pose, or all that solve an inverse or a forward kinematic problem.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Fig. 1(b), and Le, Kang and Doan 2013,
        Fig. 2. Modes, LCI and input angles are written with each pose.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    lower, upper = bounds_of(np.array([joint.position for joint in pose.joints]) for pose in poses)
    room = _ROOM * float(np.max(upper - lower))
    bounds = (lower - room, upper + room)
    single = len(poses) == 1
    look = BOLD if single else MEDIUM
    with styled():
        if single:
            title = title_text("Linkage", design, poses[0].mode)
            entries = [KeyEntry(text, {}) for text in _facts(design, poses[0])]
            captions: list[list[str]] = [[]]
            columns = 1
        else:
            title = f"{design_text(design)}: {_problem(design, poses)}"
            entries = []
            captions = [_caption(design, pose, poses) for pose in poses]
            columns = max(1, min(len(poses), int((width - 12.0) / _NARROWEST)))
            # rows of one length
            columns = math.ceil(len(poses) / math.ceil(len(poses) / columns))
        below = key_height(entries, width)
        frames = plane_frames(bounds, design.unit, title, captions, columns, width, below)
        for frame, pose in zip(frames, poses, strict=True):
            draw_origin(frame)
            draw_linkage(frame, pose, look, data)
            label_linkage(frame, pose, look)
        draw_key(frames[0], entries, 0.0)
        return frames[0].figure


def _facts(design: PlanarDesign, pose: Pose) -> list[str]:
    """Return position, input angles and index of a pose."""
    return [_output(design, pose), _inputs(pose), _index(pose)]


def _caption(design: PlanarDesign, pose: Pose, poses: Sequence[Pose]) -> list[str]:
    """Return mode and index of a pose, and what the others do not share with it."""
    shared = all(other.output == pose.output for other in poses)
    fact = _inputs(pose) if shared else _output(design, pose)
    return [f"{mode_text(pose.mode)}, {_index(pose)}", fact]


def _problem(design: PlanarDesign, poses: Sequence[Pose]) -> str:
    """Return what all poses have in common."""
    if all(pose.output == poses[0].output for pose in poses):
        return _output(design, poses[0])
    return _inputs(poses[0])


def _output(design: PlanarDesign, pose: Pose) -> str:
    """Return the position of the output point."""
    symbol = next(joint.symbol for joint in pose.joints if joint.kind == OUTPUT)
    return f"{symbol} = {point_text(pose.output, design.unit)}"


def _inputs(pose: Pose) -> str:
    """Return the input angles in degrees."""
    return ", ".join(
        f"{symbol} = {number_text(round(math.degrees(angle), 2))}°".replace(
            " ", "\N{NO-BREAK SPACE}"
        )
        for symbol, angle in zip(pose.input_symbols, pose.inputs, strict=True)
    )


def _index(pose: Pose) -> str:
    return f"LCI = {pose.lci:.4f}".replace(" ", "\N{NO-BREAK SPACE}")
