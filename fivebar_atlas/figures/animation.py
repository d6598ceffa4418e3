"""A linkage that follows a path: a figure that shows one place of it after the other."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from fivebar_atlas import mechanisms
from fivebar_atlas.checked_paths import CheckedPath, usable_region
from fivebar_atlas.closed_paths import places_along
from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key, key_height
from fivebar_atlas.figures.contour_levels import level_text, round_levels
from fivebar_atlas.figures.curves import BACKGROUND_LEVEL, draw_arcs, kind_entries
from fivebar_atlas.figures.drawing_area import FILL_LEVEL, REGION_LEVEL
from fivebar_atlas.figures.linkage import LinkageArtists, draw_linkage
from fivebar_atlas.figures.plane_frame import (
    PlaneFrame,
    bounds_of,
    bounds_of_arcs,
    draw_origin,
    flatness,
    plane_frame,
)
from fivebar_atlas.figures.text_placement import text_size
from fivebar_atlas.figures.wording import MINUS, coordinate_label, title_text
from fivebar_atlas.mechanisms.planar import PlanarDesign, Pose
from fivebar_atlas.planar_geometry import FloatArray

#: Width of the figure if nothing is said, in millimetres.
WIDTH = style.COLUMN_WIDTH
FRAMES_RANGE = (2, 1000)

# Millimetres on paper.
_GAP = 1.2
_READOUT = 4.4
_STRIP = 15.0
_STRIP_TICKS = 3.5
_STRIP_LABEL = 4.4
_COLUMN_GAP = 4.0
# Parts of the path between which the LCI and the trace are drawn, besides its corners.
_PARTS = 600
_MOST_TICKS = 8
# Share of the extent that is left free below a linkage for the ground it stands on.
_GROUND = 0.06
# Points.
_TICK_PAD = 2.4

_WORKSPACE_LOOK: dict[str, Any] = {"facecolor": style.WORKSPACE, "edgecolor": "none"}
_TRACE_LOOK: dict[str, Any] = {"color": style.REGION, "linewidth": 1.4}


@dataclasses.dataclass(frozen=True)
class PathAnimation:
    """A figure that shows a linkage at equally spaced places of a path, one at a time.

    Attributes
    ----------
    figure
        The figure.
    poses
        The linkage in every frame.
    lengths
        Length of the way to the place of every frame, shape (frames,).
    inputs, input_names
        Input angles in every frame in radians, continuous, shape (frames, inputs), and what they
        are called in files.
    lci
        Local conditioning index in every frame, shape (frames,).
    way, way_lengths
        Corners of the path and of all that is drawn of it, shape (n, 2), and the length of
        the way to each, shape (n,).
    linkage, trace, marker, readout
        What moves: the linkage, the way so far, the place on the LCI curve, and the texts of
        the LCI and of the input angles in degrees.
    """

    figure: Figure
    poses: tuple[Pose, ...]
    lengths: FloatArray
    inputs: FloatArray
    input_names: tuple[str, ...]
    lci: FloatArray
    way: FloatArray
    way_lengths: FloatArray
    linkage: LinkageArtists
    trace: Line2D
    marker: Line2D
    readout: tuple[Text, ...]

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def moving(self) -> tuple[Artist, ...]:
        """What differs from frame to frame, in the order of drawing."""
        return (
            self.trace,
            *self.linkage.links,
            *(drawn for _, drawn, _ in self.linkage.sleeves),
            *self.linkage.joints,
            self.marker,
            *self.readout,
        )

    def show(self, number: int) -> None:
        """Let the figure show a frame, counted from 0."""
        here = self.lengths[number]
        passed = int(np.searchsorted(self.way_lengths, here, "right"))
        self.linkage.move(self.poses[number])
        self.trace.set_data(*self.way[:passed].T)
        self.marker.set_data([here], [self.lci[number]])
        values = [_lci_text(self.lci[number]), *map(_angle_text, self.inputs[number])]
        for text, value in zip(self.readout, values, strict=True):
            text.set_text(value)


def path_animation(checked: CheckedPath, frames: int, width: float = WIDTH) -> PathAnimation:
    """Draw a linkage that follows a path inside its usable workspace.

    Parameters
    ----------
    checked
        The path; the last frame of a closed one is the last before the first again.
    frames
        Number of frames, equally spaced along the path.
    width
        Width of the figure in millimetres.

    Returns
    -------
    PathAnimation
        The figure, showing the first frame.

    Raises
    ------
    InfeasiblePathError
        If the path cannot be followed; it says where and why.
    InputError
        If the path has no length, or a number is out of range.
    """
    least, most = FRAMES_RANGE
    if not least <= frames <= most:
        raise InputError("frames", frames, f"an integer from {least} to {most}")
    checked.require_feasible()
    total = float(checked.lengths[-1])
    if not total > 0.0:
        raise InputError("path", total, "a path of a length above 0")
    design, mode = checked.design, checked.report.mode
    stations = np.linspace(0.0, total, frames, endpoint=not checked.is_closed)
    parts = np.linspace(0.0, total, _PARTS + 1)
    lengths = np.unique(np.concatenate([stations, checked.lengths, parts]))
    way = places_along(checked.report.points, lengths)
    # More corners on the same path: what is known at corners is known there too.
    fine = CheckedPath.of(design, way, mode, close=False)
    fine.require_feasible()
    at_frames = np.searchsorted(lengths, stations)
    poses = tuple(design.pose(x, y, mode) for x, y in way[at_frames].tolist())
    inputs = fine.report.inputs[at_frames]
    with style.styled():
        frame = _draw_plane(design, mode, way, poses, width)
        marker = _draw_strip(frame, lengths, fine.report.lci)
        readout = _draw_readout(frame, inputs, poses[0].input_symbols)
        trace = frame.line(way[:1], "trace", zorder=REGION_LEVEL + 0.1, **_TRACE_LOOK)
        animation = PathAnimation(
            figure=frame.figure,
            poses=poses,
            lengths=stations,
            inputs=inputs,
            input_names=mechanisms.get(checked.design.mechanism).input_names,
            lci=fine.report.lci[at_frames],
            way=way,
            way_lengths=lengths,
            linkage=draw_linkage(frame, poses[0]),
            trace=trace,
            marker=marker,
            readout=readout,
        )
        animation.show(0)
    return animation


def _draw_plane(
    design: PlanarDesign, mode: str, way: FloatArray, poses: Sequence[Pose], width: float
) -> PlaneFrame:
    """Draw usable workspace, loci of the mode pair and path, with room below for the rest."""
    region = usable_region(design, mode)
    loci = design.singular_loci(mode)
    joints = np.array([joint.position for pose in poses for joint in pose.joints])
    lower, upper = bounds_of([np.stack(bounds_of_arcs([*region.arcs, *loci])), joints])
    ground = joints[:, 1].min() - _GROUND * (upper[0] - lower[0])
    bounds = np.array([lower[0], min(lower[1], ground)]), upper
    entries = [
        KeyEntry("usable workspace", _WORKSPACE_LOOK),
        KeyEntry("path so far", _TRACE_LOOK),
        *kind_entries([*region.arcs, *loci]),
    ]
    below = _GAP + _READOUT + _STRIP + _STRIP_TICKS + _STRIP_LABEL
    title = title_text("Path", design, mode)
    frame = plane_frame(bounds, design.unit, title, width, below + key_height(entries, width))
    draw_key(frame, entries, below)
    draw_origin(frame)
    frame.fill(
        "usable-workspace", region.polygons(flatness(*bounds)), FILL_LEVEL, **_WORKSPACE_LOOK
    )
    draw_arcs(frame, loci, "locus", zorder=BACKGROUND_LEVEL, linewidth=0.5, alpha=0.6)
    draw_arcs(frame, region.arcs, "boundary")
    frame.line(way, "path", color=style.FAINT, linewidth=0.6, zorder=REGION_LEVEL)
    return frame


def _draw_strip(frame: PlaneFrame, lengths: FloatArray, lci: FloatArray) -> Line2D:
    """Draw the LCI along the path below the panel; return the marker of a place on it."""
    left, width = _strip_extent(frame)
    axes = frame.add_strip(left, _GAP + _READOUT, width, _STRIP)
    axes.set_label("LCI along the path")
    total = float(lengths[-1])
    axes.set_xlim(0.0, total)
    axes.set_ylim(0.0, 1.0)
    axes.grid(color=style.FAINT, linewidth=0.3, alpha=0.5)
    levels = round_levels(0.0, total, _MOST_TICKS)
    ticks = levels[levels <= total]
    axes.set_xticks(ticks, [level_text(tick, levels) for tick in ticks])
    axes.set_yticks([0.0, 0.5, 1.0], ["0", "0.5", "1"])
    axes.tick_params(labelsize=style.TICK_SIZE, labelcolor=style.INK, color=style.INK)
    # clear of the lowest label of the other axis
    axes.tick_params(axis="x", pad=_TICK_PAD)
    axes.plot(lengths, lci, color=style.INK, linewidth=0.9, gid="lci")
    (marker,) = axes.plot(
        lengths[:1],
        lci[:1],
        marker="o",
        markersize=4.5,
        markerfacecolor=style.REGION,
        markeredgecolor="white",
        markeredgewidth=0.6,
        linestyle="none",
        clip_on=False,
        zorder=REGION_LEVEL,
        gid="marker",
    )
    axes.text(
        0.5,
        -(_STRIP_TICKS + _STRIP_LABEL - 1.2) / _STRIP,
        coordinate_label("path length", frame.unit),
        transform=axes.transAxes,
        fontsize=style.AXIS_LABEL_SIZE,
        ha="center",
        va="baseline",
        color=style.INK,
    )
    return marker


def _draw_readout(
    frame: PlaneFrame, inputs: FloatArray, symbols: Sequence[str]
) -> tuple[Text, ...]:
    """Write the names of LCI and input angles above the strip; return their texts, empty."""
    left, width = _strip_extent(frame)
    axes = frame.add_strip(left, _GAP, width, _READOUT)
    axes.set_label("readout")
    axes.set_axis_off()
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, _READOUT)
    names = ["LCI", *symbols]
    # Each as wide as the widest of its values, so that nothing moves but the digits.
    values = [[_lci_text(1.0)], *(map(_angle_text, angles) for angles in inputs.T)]
    texts = []
    x = 0.0
    for name, shown in zip(names, values, strict=True):
        ends = x + text_size(f"{name} =", style.NOTE_SIZE)[0] + 1.0
        ends += max(text_size(text, style.NOTE_SIZE)[0] for text in set(shown))
        look: dict[str, Any] = {"fontsize": style.NOTE_SIZE, "va": "baseline", "color": style.INK}
        axes.text(x, 1.4, f"{name} =", ha="left", **look)
        texts.append(axes.text(ends, 1.4, "", ha="right", **look))
        x = ends + _COLUMN_GAP
    return tuple(texts)


def _strip_extent(frame: PlaneFrame) -> tuple[float, float]:
    """Return left end and width in millimetres of what is below the panel and as wide."""
    panel = frame.axes.get_position()
    return panel.x0 * frame.width, panel.width * frame.width


def _lci_text(lci: float) -> str:
    return f"{lci:.3f}"


def _angle_text(angle: float) -> str:
    return f"{round(math.degrees(angle), 1) + 0.0:.1f}\N{DEGREE SIGN}".replace("-", MINUS)
