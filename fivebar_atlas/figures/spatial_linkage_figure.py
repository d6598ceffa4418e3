"""A mechanism in space, in one pose, seen obliquely."""

from __future__ import annotations

import functools
import math

import numpy as np
from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key_rows, key_rows_height
from fivebar_atlas.figures.drawing_area import FILL_LEVEL
from fivebar_atlas.figures.label_boxes import SPACING, around
from fivebar_atlas.figures.linkage import LINKAGE_LEVEL, PanelLabels, plain
from fivebar_atlas.figures.oblique_view import ObliqueView
from fivebar_atlas.figures.plane_frame import PlaneFrame
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.spatial_frame import bounds_on_paper, spatial_frame
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.text_placement import Box, points_along
from fivebar_atlas.figures.wording import escaped, length_text, number_text
from fivebar_atlas.mechanisms.spatial import REVOLUTE, Frame, SpatialDesign, SpatialPose
from fivebar_atlas.planar_geometry import FloatArray

#: From where a mechanism is seen if nothing is said, in degrees.
DEFAULT_ELEVATION, DEFAULT_AZIMUTH = 18.0, -60.0

# Axes of coordinates and the axis of the revolute joint, as shares of the extent of the joints.
_AXES, _JOINT_AXIS = 0.26, 0.16
# Share of a limb that its cylinder takes; the rod slides in it.
_CYLINDER = 0.55
# Points and millimetres.
_ROD, _CYLINDER_WIDTH, _JOINT, _EDGE = 1.6, 3.4, 4.2, 0.7
_HEAD, _TEXT_ROOM = 1.7, 1.1
_BASE = {"facecolor": "#ececec", "edgecolor": style.FAINT, "linewidth": 0.7}
_PLATFORM = {"facecolor": style.WORKSPACE, "edgecolor": style.INK, "linewidth": 1.0, "alpha": 0.85}
_PLATFORM_LEVEL = LINKAGE_LEVEL + 0.3
# Digits of coordinates and lengths.
_DIGITS = 5


def spatial_linkage_figure(
    design: SpatialDesign,
    pose: SpatialPose,
    *,
    view: ObliqueView | None = None,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw a mechanism in space: base, platform, limbs, joints, axes of coordinates.

    Parameters
    ----------
    design
        The design.
    pose
        The pose.
    view
        From where it is seen.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted; points of space.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, in parallel projection; after Wang et al. 2017, Fig. 1(b). Limbs are
        cylinders with a rod, spherical joints are open circles and the revolute joint is a
        filled square with its axis. Pose, limb lengths and indices are in the key.

    Raises
    ------
    InputError
        If the width is out of range.
    """
    view = view or ObliqueView(DEFAULT_ELEVATION, DEFAULT_AZIMUTH)
    points = pose.points
    extent = float(np.ptp(points, axis=0).max())
    arrows = [
        (frame, frame.origin + _AXES * extent * direction, label)
        for frame in pose.frames
        for direction, label in zip(frame.directions, frame.axes, strict=True)
    ]
    shown = np.vstack([points, *(tip for _, tip, _ in arrows)])
    rows = [
        [KeyEntry(text, {})] for text in (_pose_text(design, pose), _lengths_text(design, pose))
    ]
    rows.append([KeyEntry(text, {}) for text in _index_texts(design, pose)])
    with styled():
        frame = spatial_frame(
            bounds_on_paper(view.project(shown)),
            design.unit,
            title_of(design, "Mechanism"),
            width,
            key_rows_height(rows, width),
        )
        levels = (LINKAGE_LEVEL - 0.3, _PLATFORM_LEVEL + 0.1)
        lines = [
            _draw_arrow(frame, view, origin.origin, tip, levels[number >= 3])
            for number, (origin, tip, _) in enumerate(arrows)
        ]
        lines += draw_mechanism(frame, view, pose, data)
        axis_end = _draw_joint_axis(frame, view, pose, extent, data)
        _write_labels(frame, view, pose, arrows, axis_end, lines)
        draw_key_rows(frame, rows)
        return frame.figure


def draw_mechanism(
    frame: PlaneFrame, view: ObliqueView, pose: SpatialPose, data: PlottedData | None = None
) -> list[FloatArray]:
    """Draw bodies, limbs and joints; return their lines on paper, shape (n, 2) each."""
    base = _draw_body(frame, view, pose, pose.base, "base", FILL_LEVEL, _BASE, data)
    limbs = _draw_limbs(frame, view, pose, data)
    level = _PLATFORM_LEVEL
    platform = _draw_body(frame, view, pose, pose.platform, "platform", level, _PLATFORM, data)
    _draw_joints(frame, view, pose, _PLATFORM_LEVEL + 0.2, data)
    return [base, *limbs, platform]


def title_of(design: SpatialDesign, subject: str) -> str:
    """Return the title of a figure of a design in space."""
    unit = f" {escaped(design.unit)}" if design.unit else ""
    parts = [
        f"{symbol} = {number_text(value)}{unit}".replace(" ", "\N{NO-BREAK SPACE}")
        for symbol, value in design.parameters
    ]
    return ", ".join([subject, *parts])


def _draw_body(
    frame: PlaneFrame,
    view: ObliqueView,
    pose: SpatialPose,
    corners: tuple[int, ...],
    name: str,
    level: float,
    look: dict[str, object],
    data: PlottedData | None,
) -> FloatArray:
    """Draw a body as the polygon of its joints; return its outline on paper."""
    points = pose.points[list(corners)]
    seen = view.project(points)
    frame.fill(name, [seen], level, **look)
    closed = np.vstack([points, points[:1]])
    if data is not None:
        data.add(name, closed)
    return view.project(closed)


def _draw_limbs(
    frame: PlaneFrame, view: ObliqueView, pose: SpatialPose, data: PlottedData | None
) -> list[FloatArray]:
    """Draw limbs, those behind first; return them on paper."""
    points = pose.points
    middles = np.array([points[[limb.start, limb.end]].mean(axis=0) for limb in pose.limbs])
    drawn = []
    for order, place in enumerate(np.argsort(view.depth(middles), kind="stable").tolist()):
        limb = pose.limbs[place]
        start, end = points[limb.start], points[limb.end]
        inner = start + _CYLINDER * (end - start)
        level = LINKAGE_LEVEL + 0.02 * order
        rod, cylinder = view.project(np.array([start, end])), view.project(np.array([start, inner]))
        frame.line(
            rod,
            f"limb-{place + 1}",
            color=style.INK,
            linewidth=_ROD,
            path_effects=style.halo(_ROD + 1.4),
            zorder=level,
        )
        frame.line(
            cylinder,
            f"cylinder-{place + 1}",
            color=style.SLEEVE,
            linewidth=_CYLINDER_WIDTH,
            solid_capstyle="butt",
            path_effects=[*style.halo(_CYLINDER_WIDTH + 3.0), *style.outlined(_CYLINDER_WIDTH + 1)],
            zorder=level + 0.01,
        )
        drawn.append(rod)
        if data is not None:
            data.add("limb", np.array([start, end]), plain(limb.symbol), "", limb.length)
    return drawn


def _draw_joints(
    frame: PlaneFrame, view: ObliqueView, pose: SpatialPose, level: float, data: PlottedData | None
) -> None:
    """Draw joints, those behind first: the base joints below everything of the platform."""
    ends = {limb.end for limb in pose.limbs}
    for place, joint in enumerate(pose.joints):
        is_revolute = joint.kind == REVOLUTE
        frame.line(
            view.project(joint.position[None]),
            f"joint-{place + 1}",
            marker="s" if is_revolute else "o",
            markersize=_JOINT,
            markerfacecolor=style.INK if is_revolute else "white",
            markeredgecolor=style.INK,
            markeredgewidth=_EDGE,
            linestyle="none",
            zorder=level if place in ends else LINKAGE_LEVEL + 0.2,
        )
        if data is not None:
            data.add("joint", joint.position[None], plain(joint.symbol), joint.kind)


def _draw_joint_axis(
    frame: PlaneFrame,
    view: ObliqueView,
    pose: SpatialPose,
    extent: float,
    data: PlottedData | None,
) -> FloatArray:
    """Draw the axis of the revolute joint; return its end in space."""
    middle = pose.joints[pose.axis_joint].position
    ends = middle + extent * _JOINT_AXIS * np.array([-0.6, 1.0])[:, None] * pose.axis
    look = {"color": style.REGION, "linewidth": 0.9, "linestyle": (0.0, (6.0, 1.5, 1.0, 1.5))}
    frame.line(view.project(ends), "revolute-axis", zorder=LINKAGE_LEVEL + 0.45, **look)
    if data is not None:
        data.add("revolute axis", ends, plain(pose.axis_symbol))
    end: FloatArray = ends[1]
    return end


def _draw_arrow(
    frame: PlaneFrame, view: ObliqueView, start: FloatArray, tip: FloatArray, level: float
) -> FloatArray:
    """Draw an axis of coordinates as an arrow; return it on paper."""
    line = view.project(np.array([start, tip]))
    look = {"color": "#3a3a3a", "linewidth": 0.7, "zorder": level}
    frame.line(line, "axis", **look)
    along = line[1] - line[0]
    length = math.hypot(*along) * frame.scale
    if length > _HEAD:
        back = -along / math.hypot(*along) * (_HEAD / frame.scale)
        across = 0.3 * np.array([-back[1], back[0]])
        head = np.array([line[1], line[1] + back + across, line[1] + back - across])
        frame.fill("axis-head", [head], level, facecolor="#3a3a3a", edgecolor="none")
    return line


def _write_labels(
    frame: PlaneFrame,
    view: ObliqueView,
    pose: SpatialPose,
    arrows: list[tuple[Frame, FloatArray, str]],
    axis_end: FloatArray,
    lines: list[FloatArray],
) -> None:
    """Write symbols of joints, axes and origins where they cover as little as can be."""
    drawn = np.concatenate([points_along(frame.scale * line, SPACING) for line in lines])
    labels = PanelLabels(frame, drawn, np.empty((0, 2)))
    texts = [(joint.position, joint.symbol, _JOINT / 4.0, True) for joint in pose.joints]
    texts += [(tip, label, 0.6, True) for _, tip, label in arrows]
    texts.append((axis_end, pose.axis_symbol, 0.6, True))
    texts += [(each.origin, each.symbol, 0.8, False) for each in pose.frames]
    places = [view.project(position[None])[0] * frame.scale for position, *_ in texts]
    for place, (_, _, room, _) in zip(places, texts, strict=True):
        frame.occupied.append(Box(place[0], place[1], room, room))
    for place, (_, text, room, must) in zip(places, texts, strict=True):
        candidates = functools.partial(around, place, room, math.inf if must else 3.0)
        labels.write(text, candidates, must=must)


def _pose_text(design: SpatialDesign, pose: SpatialPose) -> str:
    """Return the coordinates of a pose with their units."""
    lengths, angles = [], []
    for coordinate, value in zip(design.coordinates, pose.coordinates, strict=True):
        if coordinate.is_angle:
            angles.append(f"{coordinate.symbol} = {_number(math.degrees(value), 90.0)}°")
        else:
            unit = f" {escaped(design.unit)}" if design.unit else ""
            scale = max(map(abs, design.home))
            lengths.append(f"{coordinate.symbol} = {_number(value, scale)}{unit}")
    parts = (text.replace(" ", "\N{NO-BREAK SPACE}") for text in (*lengths, *angles))
    return ", ".join(parts)


def _number(value: float, scale: float) -> str:
    """Return a number; what is rounding beside a scale is 0."""
    return number_text(value if abs(value) > 1e-9 * scale else 0.0, _DIGITS)


def _lengths_text(design: SpatialDesign, pose: SpatialPose) -> str:
    """Return the lengths of all limbs."""
    return ", ".join(_length_of(limb.symbol, limb.length, design) for limb in pose.limbs)


def _length_of(symbol: str, length: float, design: SpatialDesign) -> str:
    """Return a length with its notation and unit, never broken into lines."""
    value = (
        length_text(length, design.unit, _DIGITS) if design.unit else number_text(length, _DIGITS)
    )
    return f"{symbol} = {value}".replace(" ", "\N{NO-BREAK SPACE}")


def _index_texts(design: SpatialDesign, pose: SpatialPose) -> list[str]:
    """Return the indices of a pose and their L; a singular one is said to be singular."""
    if math.isinf(pose.largest_limb_force):
        return ["singular pose"]
    return [
        f"LCI = {pose.lci:.4g}",
        rf"least singular value {pose.least_singular_value:.4g}",
        f"largest limb force {pose.largest_limb_force:.4g} for a unit wrench",
        _length_of("$L$", pose.characteristic_length, design),
    ]
