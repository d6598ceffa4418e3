"""The workspace of a design in space at a fixed orientation: plane sections, and its surface.

A workspace is where no limit of the design is passed, so its boundary is the level 0 of the least
slack, a continuous function that is smooth but where two limits meet.
"""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np

from fivebar_atlas.errors import InputError
from fivebar_atlas.level_curves import SampledField, separate_polygons
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray
from fivebar_atlas.mechanisms.spatial import SpatialDesign
from fivebar_atlas.surface_creases import cut_at_creases

#: Names of the coordinates of a position, in their order.
AXES = ("x", "y", "z")

Orientation = tuple[float, float]

# Samples along each axis that say in which box the workspace is.
_COARSE = 25
# Where they see nothing, so many of them are looked around, ever more closely so many times.
_BEST, _ZOOMS = 64, 6
# Cells of a section along its longer side, and how far its outline may leave the boundary, as a
# share of that.
_SECTION_CELLS, _DEVIATION = 96, 2e-4
# Cells of the grid of a surface along its longest side. Steps that bring its corners to the
# boundary, then halvings of what is left, and the slack at which they are there.
_SURFACE_CELLS, _CLOSINGS, _HALVINGS, _CLOSED = 44, 10, 40, 1e-10
# Share of its width that a box is widened by.
_WIDER = 0.05
# Least slacks are moved up by this, since outlines are sought at levels above 0.
_RAISED = 1.0


@dataclasses.dataclass(frozen=True, eq=False)
class Outline:
    """A closed outline of a section.

    Attributes
    ----------
    corners
        Shape (n, 2), counter-clockwise around the workspace, clockwise around a hole.
    limits
        Which limit bounds each side, from a corner to the next, shape (n,).
    """

    corners: FloatArray
    limits: IntArray


@dataclasses.dataclass(frozen=True, eq=False)
class Section:
    """A plane section of a workspace.

    Attributes
    ----------
    axis, value
        Number of the coordinate that is constant, and its value.
    outlines
        Outlines of all parts and holes; none where the section is empty.
    area
        Area of the section.
    """

    axis: int
    value: float
    outlines: tuple[Outline, ...]
    area: float

    @property
    def plane(self) -> tuple[int, int]:
        """Numbers of the two other coordinates, those of the corners."""
        first, second = (axis for axis in range(3) if axis != self.axis)
        return first, second


@dataclasses.dataclass(frozen=True, eq=False)
class Surface:
    """The boundary of a workspace as triangles.

    Attributes
    ----------
    vertices
        Shape (n, 3), on the boundary.
    faces
        Vertices of triangles, shape (m, 3), counter-clockwise as seen from outside.
    limits
        Which limit bounds each of them, shape (m,).
    volume
        Of the polyhedron.
    """

    vertices: FloatArray
    faces: IntArray
    limits: IntArray
    volume: float


def section_of(
    design: SpatialDesign, axis: int, value: float, orientation: Orientation = (0.0, 0.0)
) -> Section:
    """Return a plane section of the workspace at an orientation.

    Parameters
    ----------
    design
        The design.
    axis, value
        Number of the coordinate that is constant, and its value.
    orientation
        The two angles that are fixed, in radians.

    Returns
    -------
    Section
        Corners of outlines are on the boundary; sides leave it by no more than 2e-4 of the
        section's length. Parts smaller than a grid of 96 cells shows may be missing.

    Raises
    ------
    InputError
        If the value is not finite.
    """
    if not np.isfinite(value):
        raise InputError(AXES[axis], value, "a finite length")
    section = Section(axis, value, (), 0.0)
    first, second = section.plane

    def raised(x: FloatArray, y: FloatArray) -> FloatArray:
        positions = np.empty((len(x), 3))
        positions[:, axis], positions[:, first], positions[:, second] = value, x, y
        slack: FloatArray = design.slacks(positions, orientation).min(axis=-1)
        return np.maximum(_RAISED + slack, 0.0)

    box = _box(design, orientation, axis, value)
    if box is None:
        return section
    lower, upper = (corner[[first, second]] for corner in box)
    field = SampledField.over(raised, lower, upper, _SECTION_CELLS)
    while _widen(field.values.T > _RAISED, lower, upper):
        field = SampledField.over(raised, lower, upper, _SECTION_CELLS)
    deviation = _DEVIATION * float((upper - lower).max())
    parts, _ = separate_polygons(field, _RAISED, deviation)
    loops = [loop for part in parts for loop in part]
    outlines = []
    for loop in loops:
        corners = loop[:-1] if np.array_equal(loop[0], loop[-1]) else loop
        positions = np.empty((len(corners), 3))
        positions[:, axis] = value
        positions[:, [first, second]] = 0.5 * (corners + np.roll(corners, -1, axis=0))
        limits = np.argmin(design.slacks(positions, orientation), axis=-1)
        outlines.append(Outline(corners, limits))
    area = sum(_signed_area(each.corners) for each in outlines)
    return dataclasses.replace(section, outlines=tuple(outlines), area=area)


def surface_of(design: SpatialDesign, orientation: Orientation = (0.0, 0.0)) -> Surface | None:
    """Return the boundary of the workspace at an orientation as triangles; None if it is empty.

    Parameters
    ----------
    design
        The design.
    orientation
        The two angles that are fixed, in radians.

    Returns
    -------
    Surface or None
        Vertices are on the boundary but for rounding, and triangles are cut along creases,
        where limits meet. A few vertices may be off, by less than a cell of a grid of 44 cells:
        of creases that are not found, and where α or det G jumps. The volume is too small by up
        to a fifth where a workspace is no thicker than a cell; smaller parts may be missing.
    """
    from skimage.measure import marching_cubes

    box = _box(design, orientation)
    if box is None:
        return None
    lower, upper = box
    while True:
        step = float((upper - lower).max()) / _SURFACE_CELLS
        lines = [
            low + step * (np.arange(int(np.ceil((high - low) / step)) + 3) - 1.0)
            for low, high in zip(lower, upper, strict=True)
        ]
        grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        slack = _least(design, grid, orientation)
        if not _widen(slack > 0.0, lower, upper):
            break
    find: Any = marching_cubes  # has no types
    found, faces, _, _ = find(slack, 0.0, gradient_direction="ascent")
    vertices = _closed_in(design, orientation, grid, slack, found.astype(np.float64))
    vertices, faces, limits, _ = cut_at_creases(
        lambda points: design.slacks(points, orientation, complete=True),
        vertices,
        faces.astype(np.int64),
        2.0 * step,
    )
    corners = vertices[faces]
    volume = float(np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])))
    if volume < 0.0:
        faces, volume = faces[:, ::-1], -volume
    return Surface(vertices, faces, limits, volume / 6.0)


def _closed_in(
    design: SpatialDesign,
    orientation: Orientation,
    grid: FloatArray,
    slack: FloatArray,
    places: FloatArray,
) -> FloatArray:
    """Return where edges of the grid cross the boundary, near places counted in steps.

    By the method of false position in the variant of Illinois, then by halving, all edges at once.
    """
    low, high = np.floor(places).astype(np.int64), np.ceil(places).astype(np.int64)
    one, other = grid[tuple(low.T)], grid[tuple(high.T)]
    at_one, at_other = slack[tuple(low.T)], slack[tuple(high.T)]
    found: FloatArray = one + (places - low) * (other - one)
    value = np.full(len(found), np.inf)
    busy = np.arange(len(found))
    for step in range(_CLOSINGS + _HALVINGS):
        gap = at_one[busy] - at_other[busy]
        share = np.where(gap == 0.0, 0.5, at_one[busy] / np.where(gap == 0.0, 1.0, gap))
        if step >= _CLOSINGS:  # where limits meet, halving is what is sure
            share = np.full(len(busy), 0.5)
        found[busy] = one[busy] + np.clip(share, 0.0, 1.0)[:, None] * (other[busy] - one[busy])
        value[busy] = _least(design, found[busy], orientation)
        same = (value[busy] > 0.0) == (at_one[busy] > 0.0)
        ours, theirs = busy[same], busy[~same]
        # what stays put counts half, so that it moves next time
        one[ours], at_one[ours] = found[ours], value[ours]
        at_other[ours] *= 0.5
        other[theirs], at_other[theirs] = found[theirs], value[theirs]
        at_one[theirs] *= 0.5
        busy = busy[np.abs(value[busy]) > _CLOSED]
        if not len(busy):
            break
    return found


def _least(design: SpatialDesign, positions: FloatArray, orientation: Orientation) -> FloatArray:
    """Return the least slack at positions, shape (...)."""
    least: FloatArray = design.slacks(positions, orientation).min(axis=-1)
    return least


def _box(
    design: SpatialDesign,
    orientation: Orientation,
    axis: int | None = None,
    value: float = 0.0,
) -> tuple[FloatArray, FloatArray] | None:
    """Return a box around the workspace, or around a section; None where nothing is seen."""
    lower, upper = (corner.copy() for corner in design.reach())
    if np.any(upper <= lower):
        return None
    lines = [np.linspace(*ends, _COARSE) for ends in zip(lower, upper, strict=True)]
    if axis is not None:
        lines[axis] = np.array([value])
        others = [each for each in range(3) if each != axis]
        for each in others:
            lines[each] = np.linspace(lower[each], upper[each], _COARSE**2 // 6)
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    if axis is None:
        grid = np.vstack([grid, np.array(design.home[:3])])
    room = np.array([line[1] - line[0] if len(line) > 1 else 0.0 for line in lines])
    slack = _least(design, grid, orientation)
    inside = grid[slack > 0.0]
    spacing = room
    for _ in range(_ZOOMS):  # a workspace between the samples is next to the best of them
        if len(inside):
            break
        best = grid[np.argsort(-slack, kind="stable")[:_BEST]]
        spacing = 0.5 * spacing
        around = spacing * np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
        grid = np.unique((best[:, None] + around).reshape(-1, 3), axis=0)
        grid = grid[np.all((grid >= lower) & (grid <= upper) | (room == 0.0), axis=-1)]
        slack = _least(design, grid, orientation)
        inside = grid[slack > 0.0]
    if not len(inside):
        return None
    return (
        np.maximum(inside.min(axis=0) - room, lower),
        np.minimum(inside.max(axis=0) + room, upper),
    )


def _widen(inside: BoolArray, lower: FloatArray, upper: FloatArray) -> bool:
    """Widen a box where its grid has points of the workspace on a side; return whether it did."""
    widened = False
    for axis, (end, corner) in itertools.product(range(inside.ndim), ((0, lower), (-1, upper))):
        if np.moveaxis(inside, axis, 0)[end].any():
            corner[axis] += _WIDER * (upper - lower)[axis] * (1.0 if end else -1.0)
            widened = True
    return widened


def _signed_area(corners: FloatArray) -> float:
    x, y = corners.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
