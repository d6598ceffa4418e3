"""Workspaces in space: sections and surfaces on the true boundary, their sizes, their limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.path import Path as Outline

from fivebar_atlas import Pentapod
from fivebar_atlas.spatial_workspace import section_of, surface_of

DESIGN = Pentapod.from_radii(1.0, 0.9, 0.25)


def least_slack(positions: np.ndarray, orientation: tuple[float, float]) -> np.ndarray:
    found: np.ndarray = DESIGN.slacks(positions, orientation).min(axis=-1)
    return found


@pytest.mark.parametrize(("axis", "value"), [(2, 1.0), (2, 0.8), (0, 0.0), (1, 0.15)])
@pytest.mark.parametrize("orientation", [(0.0, 0.0), (math.radians(12.0), math.radians(-8.0))])
def test_outline_of_a_section_is_the_boundary(
    axis: int, value: float, orientation: tuple[float, float]
) -> None:
    section = section_of(DESIGN, axis, value, orientation)
    assert section.outlines
    plane = list(section.plane)
    for outline in section.outlines:
        positions = np.full((len(outline.corners), 3), value)
        positions[:, plane] = outline.corners
        assert np.abs(least_slack(positions, orientation)).max() < 1e-9
        # each side is bounded by its limit
        middles = np.full((len(outline.corners), 3), value)
        middles[:, plane] = 0.5 * (outline.corners + np.roll(outline.corners, -1, axis=0))
        slacks = DESIGN.slacks(middles, orientation)
        own = np.take_along_axis(slacks, outline.limits[:, None], axis=-1)[:, 0]
        assert np.abs(own).max() < 2e-3
    # inside and outside are told apart by points all over the plane
    lower, upper = (corner[plane] for corner in DESIGN.reach())
    points = lower + (upper - lower) * np.random.default_rng(0).random((3000, 2))
    inside = np.zeros(len(points), dtype=int)
    for outline in section.outlines:
        inside += Outline(outline.corners).contains_points(points)
    positions = np.full((len(points), 3), value)
    positions[:, plane] = points
    slack = least_slack(positions, orientation)
    clear = np.abs(slack) > 1e-3
    assert ((inside % 2 == 1) == (slack > 0.0))[clear].all()
    share = np.mean(slack > 0.0)
    deviation = 4.0 * math.sqrt(share * (1.0 - share) / len(points))
    assert abs(section.area / np.prod(upper - lower) - share) < deviation


def test_section_beyond_the_workspace_is_empty() -> None:
    section = section_of(DESIGN, 2, 5.0)
    assert section.outlines == ()
    assert section.area == 0.0


def test_parts_of_a_section_do_not_overlap_where_it_is_thin() -> None:
    options = {"axis_angle": 36.15, "offset": -0.7, "base_angle": 8.47, "position_angle": 30.32}
    design = Pentapod.from_radii(1.0, 0.3084, 0.5881, options=tuple(options.items()))
    section = section_of(design, 0, -0.1361)
    corners = np.vstack([outline.corners for outline in section.outlines])
    lower, upper = corners.min(axis=0) - 0.01, corners.max(axis=0) + 0.01
    lines = [np.linspace(*ends, 401) for ends in zip(lower, upper, strict=True)]
    grid = np.stack(np.meshgrid([-0.1361], *lines, indexing="ij"), axis=-1).reshape(-1, 3)
    share = np.mean(design.slacks(grid, (0.0, 0.0)).min(axis=-1) > 0.0)
    assert section.area == pytest.approx(share * np.prod(upper - lower), rel=0.015)


def test_surface_smaller_than_the_samples_is_found() -> None:
    options = (("offset", -0.7), ("base_angle", 16.88), ("position_angle", 10.381))
    design = Pentapod.from_radii(1.0, 1.09655, 0.7724, options=options)
    orientation = (-0.48785, 0.35215)
    surface = surface_of(design, orientation)
    assert surface is not None
    lower, upper = surface.vertices.min(axis=0) - 0.02, surface.vertices.max(axis=0) + 0.02
    points = lower + (upper - lower) * np.random.default_rng(0).random((40000, 3))
    share = np.mean(design.slacks(points, orientation).min(axis=-1) > 0.0)
    assert surface.volume == pytest.approx(share * np.prod(upper - lower), rel=0.3)


def test_surface_is_the_boundary_and_holds_the_volume() -> None:
    surface = surface_of(DESIGN)
    assert surface is not None
    slack = np.abs(least_slack(surface.vertices, (0.0, 0.0)))
    # but for a few where limits hardly meet
    assert np.mean(slack < 1e-8) > 0.98
    assert slack.max() < 0.02
    # the middle of a triangle is next to its limit
    middles = DESIGN.slacks(surface.vertices[surface.faces].mean(axis=1), (0.0, 0.0), True)
    own = np.take_along_axis(middles, surface.limits[:, None], axis=1)
    assert np.quantile(np.abs(own), 0.99) < 5e-3
    # every edge belongs to two triangles, once each way: the surface is closed
    ends = np.concatenate([surface.faces[:, [k, (k + 1) % 3]] for k in range(3)])
    forward = {tuple(edge) for edge in ends.tolist()}
    assert len(forward) == len(ends)
    assert {edge[::-1] for edge in forward} == forward
    lower, upper = DESIGN.reach()
    points = lower + (upper - lower) * np.random.default_rng(1).random((60_000, 3))
    share = float(np.mean(least_slack(points, (0.0, 0.0)) > 0.0))
    box = float(np.prod(upper - lower))
    deviation = 4.0 * box * math.sqrt(share * (1.0 - share) / len(points))
    assert abs(surface.volume - share * box) < deviation + 0.002 * surface.volume


def test_surface_is_that_of_the_sections() -> None:
    """Volume as the integral of areas, by the rule of Simpson."""
    surface = surface_of(DESIGN)
    assert surface is not None
    low, high = surface.vertices[:, 2].min(), surface.vertices[:, 2].max()
    heights = np.linspace(low, high, 9)
    areas = np.array([section_of(DESIGN, 2, float(z)).area for z in heights])
    weights = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) * (high - low) / 24.0
    assert weights @ areas == pytest.approx(surface.volume, rel=0.03)


def test_no_workspace_at_an_orientation_out_of_reach() -> None:
    narrow = Pentapod.from_radii(1.0, 0.9, 0.25, options=(("platform_joint_limit", 5.0),))
    assert surface_of(narrow, (math.radians(60.0), 0.0)) is None
    assert section_of(narrow, 2, 1.0, (math.radians(60.0), 0.0)).outlines == ()
