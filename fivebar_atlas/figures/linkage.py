"""A linkage in a pose: links, joints, ground, and the labels of Fig. 1(b) of Liu et al."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from fivebar_atlas.figures import style
from fivebar_atlas.figures.drawing_area import FILL_LEVEL, REGION_LEVEL, TEXT_LEVEL
from fivebar_atlas.figures.label_boxes import (
    SPACING,
    Place,
    around,
    beside,
    beside_arc,
    best_box,
)
from fivebar_atlas.figures.plane_frame import PlaneFrame
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.text_placement import Box, points_along, text_size
from fivebar_atlas.mechanisms.planar import (
    ACTUATED,
    BASE,
    CRANK,
    OUTPUT,
    PASSIVE,
    PLATFORM,
    TELESCOPE,
    Link,
    PlanarDesign,
    Pose,
)
from fivebar_atlas.planar_geometry import FloatArray, Point, Region

#: Order of drawing: above all curves, below all text.
LINKAGE_LEVEL = 0.5 * (TEXT_LEVEL + REGION_LEVEL) + 0.2

_FACES = {ACTUATED: style.INK, PASSIVE: "white", OUTPUT: style.REGION}
_LINKS = {BASE: style.FAINT}

# The ground below a base joint, in millimetres: a triangle on a hatched line.
_GROUND_HEIGHT, _GROUND_WIDTH, _HATCH, _STROKES = 2.0, 3.6, 0.9, 5
# Angle arcs and what belongs to them, in millimetres.
_ARC_RADIUS, _ARC_STEP, _ARC_HEAD = 5.0, 2.0, 1.1
# Links shorter than this on paper, in millimetres, have no label.
_SHORTEST_LABELLED = 2.0
# Joints closer than this on paper have one label.
_SAME_PLACE = 0.3
# Sleeve of a leg of variable length: its length in millimetres, at most this share of the leg, and
# how much wider than the leg it is.
_SLEEVE, _SLEEVE_SHARE, _SLEEVE_WIDTH = 9.0, 0.6, 3.2
# Points across a workspace among which the one farthest from the boundary is looked for.
_RASTER = 40


@dataclasses.dataclass(frozen=True, slots=True)
class LinkageLook:
    """Sizes of a linkage in points; ``ground`` multiplies the size of the ground marks."""

    base: float
    crank: float
    distal: float
    joint: float
    edge: float
    ground: float


#: The subject of a figure, one of several, and an addition to another subject.
BOLD = LinkageLook(base=0.9, crank=2.6, distal=1.8, joint=4.8, edge=0.8, ground=1.0)
MEDIUM = LinkageLook(base=0.7, crank=1.9, distal=1.3, joint=3.8, edge=0.6, ground=0.8)
FINE = LinkageLook(base=0.5, crank=1.3, distal=0.9, joint=2.8, edge=0.5, ground=0.6)


@dataclasses.dataclass(frozen=True, slots=True)
class LinkageArtists:
    """What a linkage is drawn with.

    Attributes
    ----------
    links, joints
        One line for each link, and one marker for each joint, in the order of the pose.
    sleeves
        Sleeves of the legs of variable length, by the place of the link, and their length.
    """

    links: tuple[Line2D, ...]
    joints: tuple[Line2D, ...]
    sleeves: tuple[tuple[int, Line2D, float], ...]

    def move(self, pose: Pose) -> None:
        """Show another pose of the same linkage."""
        for drawn, link in zip(self.links, pose.links, strict=True):
            drawn.set_data(*link_points(pose, link.start, link.end).T)
        for place, drawn, length in self.sleeves:
            drawn.set_data(*_sleeve_points(pose, pose.links[place], length).T)
        for drawn, joint in zip(self.joints, pose.joints, strict=True):
            drawn.set_data([joint.position[0]], [joint.position[1]])


def draw_linkage(
    frame: PlaneFrame,
    pose: Pose,
    look: LinkageLook = BOLD,
    data: PlottedData | None = None,
) -> LinkageArtists:
    """Draw a linkage: actuated joints filled, passive ones open, the base on the ground.

    A platform is as thick as a crank, and a leg of variable length slides in a sleeve.

    Parameters
    ----------
    frame
        The panel.
    pose
        The linkage.
    look
        Its sizes.
    data
        Takes what is plotted.

    Returns
    -------
    LinkageArtists
        What it is drawn with; the ``gid`` of a link is ``link-1``, of a joint ``joint-1``.
    """
    _draw_ground(frame, pose, look)
    frame.occupied.extend(_ground_boxes(frame, pose, look))
    widths = {BASE: look.base, CRANK: look.crank, PLATFORM: look.crank}
    links, sleeves = [], []
    for number, link in enumerate(pose.links, start=1):
        points = link_points(pose, link.start, link.end)
        links.append(
            frame.line(
                points,
                f"link-{number}",
                color=_LINKS.get(link.kind, style.INK),
                linewidth=widths.get(link.kind, look.distal),
                zorder=LINKAGE_LEVEL - (0.05 if link.kind == BASE else 0.0),
            )
        )
        if data is not None:
            data.add("link", points, plain(link.symbol), link.kind)
        if link.kind == TELESCOPE:
            sleeves.append((number - 1, *_draw_sleeve(frame, pose, number, look)))
    joints = []
    for number, joint in enumerate(pose.joints, start=1):
        joints.append(
            frame.line(
                np.array([joint.position]),
                f"joint-{number}",
                marker="o",
                markersize=look.joint,
                markerfacecolor=_FACES[joint.kind],
                markeredgecolor=style.INK,
                markeredgewidth=look.edge,
                linestyle="none",
                zorder=LINKAGE_LEVEL + 0.1,
            )
        )
        if data is not None:
            data.add("joint", [joint.position], plain(joint.symbol), joint.kind)
    return LinkageArtists(tuple(links), tuple(joints), tuple(sleeves))


def _draw_sleeve(
    frame: PlaneFrame, pose: Pose, number: int, look: LinkageLook
) -> tuple[Line2D, float]:
    """Draw the sleeve in which a link slides; return it and its length in the plane."""
    length = look.ground * _SLEEVE / frame.scale
    width = _SLEEVE_WIDTH * look.distal
    drawn = frame.line(
        _sleeve_points(pose, pose.links[number - 1], length),
        f"sleeve-{number}",
        color=style.SLEEVE,
        linewidth=width,
        solid_capstyle="butt",
        path_effects=style.outlined(width + 2.0 * look.edge),
        zorder=LINKAGE_LEVEL + 0.02,
    )
    return drawn, length


def _sleeve_points(pose: Pose, link: Link, length: float) -> FloatArray:
    """Return the ends of the sleeve of a link, shape (2, 2): from its start, never all of it."""
    start, end = link_points(pose, link.start, link.end)
    reach = float(np.hypot(*(end - start)))
    share = min(length / reach, _SLEEVE_SHARE) if reach > 0.0 else 0.0
    return np.array([start, start + share * (end - start)])


def _sleeve_sides(
    frame: PlaneFrame, pose: Pose, link: Link, look: LinkageLook
) -> tuple[FloatArray, ...]:
    """Return both sides of the sleeve of a link on paper; none where there is no sleeve."""
    if link.kind != TELESCOPE:
        return ()
    ends = frame.scale * _sleeve_points(pose, link, look.ground * _SLEEVE / frame.scale)
    dx, dy = ends[1] - ends[0]
    reach = math.hypot(dx, dy)
    across = np.array([-dy, dx]) * (_half_sleeve(look) / reach) if reach > 0.0 else np.zeros(2)
    return ends + across, ends - across


def _half_sleeve(look: LinkageLook) -> float:
    """Return half the width of a sleeve and its outline on paper, in millimetres."""
    return (0.5 * _SLEEVE_WIDTH * look.distal + look.edge) / style.POINTS_PER_MM


def link_points(pose: Pose, start: int, end: int) -> FloatArray:
    """Return the positions of two joints, shape (2, 2)."""
    return np.array([pose.joints[start].position, pose.joints[end].position])


def plain(symbol: str) -> str:
    """Return a symbol without the signs of mathtext around it, ``"A_1"``."""
    return symbol.strip("$")


def sample_pose(design: PlanarDesign, region: Region, mode: str) -> Pose:
    """Return a pose well inside a usable workspace.

    The output point is the centre of the first maximal inscribed circle or, where there is
    none, the point of a raster that is farthest from the boundary.
    """
    circles = design.inscribed_circles(mode)
    place = circles[0].centre if circles else _innermost(design, region, mode)
    return design.pose(*place, mode)


def _innermost(design: PlanarDesign, region: Region, mode: str) -> Point:
    """Return the point of a raster over a region that is farthest from its boundary."""
    corners = region.outline.polyline(math.inf)
    cells = _RASTER
    while True:  # a sliver may pass between the points of a raster
        shares = (np.arange(cells) + 0.5) / cells
        lines = corners.min(axis=0) + shares[:, None] * np.ptp(corners, axis=0)
        x, y = (each.ravel() for each in np.meshgrid(*lines.T))
        inside = design.lci_inside(x, y, mode) > 0.0
        if inside.any():
            points = np.column_stack([x, y])[inside]
            best = points[np.argmax(region.boundary_distance(points)[0])]
            return float(best[0]), float(best[1])
        cells *= 2


def label_linkage(frame: PlaneFrame, pose: Pose, look: LinkageLook = BOLD) -> None:
    """Write symbols of joints, and of links and input angles where they cover nothing.

    Angles are drawn from the direction of the x axis to the cranks. The symbol of the base
    stands for the distance of its joints from the origin O.
    """
    lines = [frame.scale * link_points(pose, link.start, link.end) for link in pose.links]
    sides = [side for link in pose.links for side in _sleeve_sides(frame, pose, link, look)]
    angles = _draw_angles(frame, pose)
    faint = [points_along(line, SPACING) for angle in angles for line in angle.lines]
    labels = PanelLabels(
        frame,
        np.concatenate([points_along(line, SPACING) for line in (*lines, *sides)]),
        np.concatenate([frame.cross, *faint]),
    )
    joints = _joint_texts(frame, pose)
    for place, _ in joints:
        # a joint covers a little more than the ends of its links
        frame.occupied.append(Box(place[0], place[1], look.joint / 4.0, look.joint / 4.0))
    for place, text in joints:
        labels.write(text, functools.partial(around, place, look.joint / 4.0, math.inf))
    for angle in angles:
        places = functools.partial(beside_arc, angle.centre, angle.radius, angle.middle)
        labels.write(angle.symbol, places, must=False)
    origin = np.zeros(2)
    if all(np.hypot(*(place - origin)) > _SAME_PLACE for place, _ in joints):
        labels.write("$O$", functools.partial(around, origin, 0.6, 2.0), must=False)
    # the base last: it needs its label least
    for link, line in sorted(
        zip(pose.links, lines, strict=True), key=lambda each: each[0].kind == BASE
    ):
        start = origin if link.kind == BASE else line[0]
        if link.symbol and np.hypot(*(line[1] - start)) > _SHORTEST_LABELLED:
            clearance = _half_sleeve(look) if link.kind == TELESCOPE else look.crank / 5.0
            places = functools.partial(beside, np.array([start, line[1]]), clearance)
            labels.write(link.symbol, places, must=False)


@dataclasses.dataclass(slots=True)
class PanelLabels:
    """Labels of a panel, and points of lines that they must not and better not cover."""

    frame: PlaneFrame
    lines: FloatArray
    faint: FloatArray

    def write(
        self, text: str, places: Callable[[float, float], Iterable[Place]], must: bool = True
    ) -> None:
        """Write a text at the best of the places for its width and height."""
        frame = self.frame
        candidates = places(*text_size(text, style.REGION_SIZE))
        box = best_box(candidates, frame.outline, self.lines, self.faint, frame.occupied, must)
        if box is not None:
            frame.occupied.append(box)
            frame.write(text, box, style.REGION_SIZE, halo=1.2)


def _joint_texts(frame: PlaneFrame, pose: Pose) -> list[tuple[FloatArray, str]]:
    """Return positions on paper and labels of joints; joints at one place share a label."""
    found: list[tuple[FloatArray, str]] = []
    for joint in pose.joints:
        place = np.array(joint.position) * frame.scale
        for number, (other, text) in enumerate(found):
            if np.hypot(*(place - other)) < _SAME_PLACE:
                found[number] = (other, f"{text}, {joint.symbol}")
                break
        else:
            found.append((place, joint.symbol))
    return found


@dataclasses.dataclass(frozen=True, slots=True)
class _Angle:
    """An input angle on paper: its symbol, its arc, and the lines it is drawn with."""

    symbol: str
    centre: FloatArray
    radius: float
    middle: float
    lines: tuple[FloatArray, ...]


def _draw_angles(frame: PlaneFrame, pose: Pose) -> list[_Angle]:
    """Draw an arc from the direction of x to every crank."""
    found: list[_Angle] = []
    cranks = [link for link in pose.links if link.kind == CRANK]
    for number, link in enumerate(cranks, start=1):
        start, end = link_points(pose, link.start, link.end) * frame.scale
        near = [each for each in found if np.hypot(*(start - each.centre)) < 2.0 * _ARC_RADIUS]
        radius = _ARC_RADIUS + _ARC_STEP * len(near)
        radius = min(radius, 0.7 * float(np.hypot(*(end - start))))
        angle = math.atan2(end[1] - start[1], end[0] - start[0])
        turns = np.linspace(0.0, angle, 49)
        arc = start + radius * np.column_stack([np.cos(turns), np.sin(turns)])
        ray = np.array([start, start + np.array([radius + 1.5, 0.0])])
        thin = {"color": style.INK, "linewidth": 0.5, "zorder": LINKAGE_LEVEL - 0.1}
        frame.line(ray / frame.scale, f"angle-ray-{number}", linestyle=(0.0, (3.0, 2.0)), **thin)
        frame.line(arc / frame.scale, f"angle-{number}", **thin)
        if abs(angle) * radius > 2.0 * _ARC_HEAD:
            _draw_head(frame, arc[-1], angle + math.copysign(0.5 * math.pi, angle), number)
        symbol = pose.input_symbols[number - 1]
        found.append(_Angle(symbol, start, radius, 0.5 * angle, (arc, ray)))
    return found


def _draw_head(frame: PlaneFrame, tip: FloatArray, heading: float, number: int) -> None:
    """Draw the head of an arrow."""
    back = np.array([math.cos(heading), math.sin(heading)])
    across = np.array([-back[1], back[0]])
    foot = tip - _ARC_HEAD * back
    corners = np.array([tip, foot + 0.32 * across, foot - 0.32 * across]) / frame.scale
    frame.fill(f"angle-head-{number}", [corners], FILL_LEVEL, facecolor=style.INK, edgecolor="none")


def _base_joints(pose: Pose) -> Sequence[Point]:
    places = {place for link in pose.links if link.kind == BASE for place in (link.start, link.end)}
    return [pose.joints[place].position for place in sorted(places)]


def _draw_ground(frame: PlaneFrame, pose: Pose, look: LinkageLook) -> None:
    """Draw a triangle on a hatched line below every base joint."""
    size = look.ground / frame.scale
    half, height, hatch = size * _GROUND_WIDTH / 2, size * _GROUND_HEIGHT, size * _HATCH
    lines: list[FloatArray] = []
    for x, y in _base_joints(pose):
        floor = y - height
        foot = 0.6 * half
        lines.append(np.array([[x, y], [x - foot, floor], [x + foot, floor], [x, y]]))
        lines.append(np.array([[x - half, floor], [x + half, floor]]))
        lines.extend(
            np.array([[x + stroke, floor - hatch], [x + stroke + hatch, floor]])
            for stroke in np.linspace(-half, half - hatch, _STROKES)
        )
    marks = LineCollection(
        lines, colors=style.INK, linewidths=0.6 * look.ground, zorder=LINKAGE_LEVEL - 0.1
    )
    marks.set_gid("ground")
    frame.axes.add_collection(marks, autolim=False)


def _ground_boxes(frame: PlaneFrame, pose: Pose, look: LinkageLook) -> list[Box]:
    """Return the boxes on paper that ground marks take."""
    height = look.ground * (_GROUND_HEIGHT + _HATCH)
    return [
        Box(
            frame.scale * x,
            frame.scale * y - height / 2 - 0.5,
            look.ground * _GROUND_WIDTH,
            height - 1.0,
        )
        for x, y in _base_joints(pose)
    ]
