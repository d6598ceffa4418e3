"""Circles, inset outlines and places along paths, against closed forms and exact distances."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from fivebar_atlas import FiveBar
from fivebar_atlas.closed_paths import (
    circle_path,
    closed,
    inset_path,
    path_lengths,
    places_along,
)
from fivebar_atlas.errors import InputError
from fivebar_atlas.planar_geometry import FloatArray, NamedArc, PolylineArc, Region, closed_loop


def workspace_of(lengths: tuple[float, float, float], mode: str = "+-/up") -> Region:
    workspace = FiveBar(*lengths).usable_workspace(mode)
    assert workspace is not None
    return workspace.region


def region_of_corners(corners: FloatArray) -> Region:
    arc = PolylineArc(np.concatenate([corners, corners[:1]]))
    return Region(closed_loop([NamedArc("edge", "", "", arc)]))


def test_circle_has_exact_corners_and_fine_chords() -> None:
    path = circle_path(1.5, -0.5, 2.0)
    offsets = path - np.array([1.5, -0.5])
    np.testing.assert_allclose(np.hypot(*offsets.T), 2.0, rtol=1e-14)
    np.testing.assert_array_equal(path[0], [3.5, -0.5])
    assert shapely.is_ccw(shapely.LinearRing(path))
    chords = np.hypot(*np.diff(closed(path), axis=0).T)
    sagitta = 2.0 - math.sqrt(4.0 - (chords.max() / 2.0) ** 2)
    assert 0.5e-6 * 2.0 < sagitta <= 1e-6 * 2.0 * (1 + 1e-6)


@pytest.mark.parametrize(
    ("circle", "message"),
    [
        ((math.nan, 0.0, 1.0), "circle x"),
        ((0.0, math.inf, 1.0), "circle y"),
        ((0.0, 0.0, 0.0), "circle radius"),
        ((0.0, 0.0, -1.0), "circle radius"),
        ((0.0, 0.0, math.inf), "circle radius"),
    ],
)
def test_circles_that_are_none(circle: tuple[float, float, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        circle_path(*circle)


def test_inset_annulus_is_an_annulus() -> None:
    region, margin = workspace_of((1.28, 1.72, 0.0)), 0.15
    for path, radius in (
        (inset_path(region, margin), 3.0 - margin),
        (inset_path(region, margin, hole=1), 0.44 + margin),
    ):
        np.testing.assert_allclose(np.hypot(*path.T), radius, atol=0.02 * margin)
        assert shapely.is_ccw(shapely.LinearRing(path))
        assert shapely.Polygon(path).area == pytest.approx(math.pi * radius**2, rel=1e-3)
        assert np.argmax(path[:, 0]) == 0


@pytest.mark.parametrize("margin", [0.002, 0.05, 0.2])
@pytest.mark.parametrize("mode", ["+-/up", "++/up", "-+/up"])
def test_inset_outline_keeps_its_distance(mode: str, margin: float) -> None:
    """Exactly measured to the arcs themselves, cusps and corners included."""
    robot = FiveBar.from_lengths(26, 30, 16)
    workspace = robot.usable_workspace(mode)
    assert workspace is not None
    path = inset_path(workspace.region, margin)
    assert np.all(workspace.contains(*path.T))
    distances, _ = workspace.region.boundary_distance(path)
    np.testing.assert_allclose(distances, margin, rtol=0.02)
    assert robot.check_path(closed(path), mode).feasible


def test_largest_margin_is_that_of_the_largest_circle_inside() -> None:
    region = workspace_of((1.28, 1.72, 0.0))  # between radii 0.44 and 3
    with pytest.raises(InputError, match=r"margin: 1.3 .* at most 1\.(279|28), which leaves a"):
        inset_path(region, 1.3)
    assert len(inset_path(region, 1.279)) > 8


@pytest.mark.parametrize("margin", [0.0, -0.1, math.nan, 1e-9])
def test_margin_must_be_a_length(margin: float) -> None:
    with pytest.raises(InputError, match="expected a length of at least"):
        inset_path(workspace_of((1.28, 1.72, 0.0)), margin)


def test_hole_must_be_there() -> None:
    region = workspace_of((1.28, 1.72, 0.0))
    for hole in (0, 2, -1):
        with pytest.raises(InputError, match=r"hole: .* a number from 1 to 1"):
            inset_path(region, 0.1, hole)
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    with pytest.raises(InputError, match="there are no holes"):
        inset_path(region_of_corners(square), 0.1, 1)


def test_largest_part_counts_where_the_margin_cuts_a_neck() -> None:
    corners = np.array(
        [
            *([0, 0], [2, 0], [2, 0.9], [3, 0.9], [3, 0], [6, 0]),
            *([6, 3], [3, 3], [3, 1.1], [2, 1.1], [2, 2], [0, 2]),
        ],
        dtype=float,
    )
    path = inset_path(region_of_corners(corners), 0.25)
    # into the neck as far as its corners (3, 1 ± 0.1) let it
    beyond = 3.0 + math.sqrt(0.25**2 - 0.1**2)
    np.testing.assert_allclose(path.min(axis=0), [beyond, 0.25], atol=1e-3)
    np.testing.assert_allclose(path.max(axis=0), [5.75, 2.75])
    joined = inset_path(region_of_corners(corners), 0.05)
    np.testing.assert_allclose(joined.min(axis=0), [0.05, 0.05])


def test_closing_and_places_along_a_path() -> None:
    corners = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]])
    around = closed(corners)
    np.testing.assert_array_equal(around, [*corners, corners[0]])
    assert closed(around) is around
    np.testing.assert_array_equal(path_lengths(around), [0.0, 3.0, 7.0, 12.0])
    np.testing.assert_allclose(
        places_along(around, np.array([0.0, 1.5, 3.0, 5.0, 9.5, 12.0])),
        [[0, 0], [1.5, 0], [3, 0], [3, 2], [1.5, 2], [0, 0]],
    )
    point = np.array([[1.0, 2.0]])
    assert closed(point) is point
    np.testing.assert_array_equal(path_lengths(point), [0.0])
