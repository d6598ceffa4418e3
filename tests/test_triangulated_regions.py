"""Regions of a triangulated plane against shapely, which knows nothing of our clipping."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from scipy.spatial import Delaunay

from fivebar_atlas.triangulated_regions import (
    FloatArray,
    IntArray,
    Region,
    outline_of_cells,
    outline_of_triangles,
    region_where,
)


def scattered(count: int, seed: int) -> tuple[FloatArray, IntArray]:
    points = np.random.default_rng(seed).uniform(size=(count, 2))
    return points, Delaunay(points).simplices.astype(np.int64)


def polygon_of(loops: tuple[FloatArray, ...]) -> shapely.Geometry:
    """Outer loops minus holes, told apart by the sense they run in."""
    rings = [shapely.LinearRing(loop) for loop in loops]
    outer = shapely.union_all([shapely.Polygon(ring) for ring in rings if ring.is_ccw])
    holes = shapely.union_all([shapely.Polygon(ring) for ring in rings if not ring.is_ccw])
    return shapely.difference(outer, holes)


def clipped_by_shapely(points: FloatArray, triangles: IntArray, margins: FloatArray) -> float:
    """Area of the region: every triangle cut by large polygons for the half-planes."""
    total = 0.0
    for triangle in triangles:
        piece: shapely.Geometry = shapely.Polygon(points[triangle])
        system = np.column_stack([points[triangle], np.ones(3)])
        for values in margins[:, triangle]:
            a, b, c = np.linalg.solve(system, values)
            normal = np.array([a, b])
            size = np.hypot(a, b)
            foot = -c * normal / size**2
            along = 50.0 * np.array([-b, a]) / size
            inward = 100.0 * normal / size
            half_plane = shapely.Polygon(
                [foot - along, foot + along, foot + along + inward, foot - along + inward]
            )
            piece = shapely.intersection(piece, half_plane)
        total += piece.area
    return total


def assert_consistent(region: Region) -> None:
    polygon = polygon_of(region.loops)
    assert polygon.is_valid
    assert polygon.area == pytest.approx(region.area, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("functions", [1, 2, 3])
@pytest.mark.parametrize("seed", range(6))
def test_region_is_every_triangle_clipped_by_the_half_planes(functions: int, seed: int) -> None:
    points, triangles = scattered(120, seed)
    margins = np.random.default_rng(seed + 100).normal(0.4, 1.0, (functions, len(points)))

    region = region_where(points, triangles, margins)

    assert region.area == pytest.approx(clipped_by_shapely(points, triangles, margins), rel=1e-9)
    assert_consistent(region)


def test_functions_that_are_linear_everywhere_cut_out_their_polygon() -> None:
    points, triangles = scattered(300, 7)
    x, y = points.T
    margins = np.stack([x - 0.25, 0.75 - x, y - 0.25, 0.75 - y, 1.2 - x - y])

    region = region_where(points, triangles, margins)

    assert region.area == pytest.approx(0.25 - 0.5 * 0.3**2, rel=1e-12)
    (loop,) = region.loops
    assert len(loop) == 5
    least, greatest = region.extent(triangles, points)
    np.testing.assert_allclose(least, [0.25, 0.25], rtol=1e-12)
    np.testing.assert_allclose(greatest, [0.75, 0.75], rtol=1e-12)


def test_extent_of_a_quantity_is_taken_inside_triangles_too() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    triangles = np.array([[0, 1, 2]])
    margins = np.array([[0.0, 1.0, 0.0]]) - 0.25  # x >= 0.25

    region = region_where(points, triangles, margins)
    least, greatest = region.extent(triangles, np.array([3.0, 7.0, 3.0]))

    assert float(least) == pytest.approx(4.0)
    assert float(greatest) == pytest.approx(7.0)


def test_a_region_with_a_hole_has_two_loops_of_opposite_sense() -> None:
    grid = np.linspace(-1.0, 1.0, 21)
    points = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    triangles = Delaunay(points).simplices.astype(np.int64)
    radius = np.hypot(*points.T)

    region = region_where(points, triangles, np.stack([radius - 0.4, 0.9 - radius]))

    senses = sorted(shapely.LinearRing(loop).is_ccw for loop in region.loops)
    assert senses == [False, True]
    assert_consistent(region)


def test_repeated_and_touching_conditions_change_nothing() -> None:
    points, triangles = scattered(200, 3)
    margins = np.random.default_rng(5).normal(0.2, 1.0, (1, len(points)))

    once = region_where(points, triangles, margins)
    thrice = region_where(points, triangles, np.repeat(margins, 3, axis=0))

    assert thrice.area == once.area
    for loop, again in zip(once.loops, thrice.loops, strict=True):
        np.testing.assert_array_equal(loop, again)


def test_a_level_that_runs_along_lattice_lines_leaves_a_clean_outline() -> None:
    # 0.1 * 3 is not 0.3: round-off at the vertices must not leave slivers behind.
    steps = np.arange(11) * 0.1
    points = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    triangles = Delaunay(points).simplices.astype(np.int64)

    region = region_where(points, triangles, np.stack([points[:, 0] - 0.3, 0.7 - points[:, 1]]))

    (loop,) = region.loops
    assert len(loop) == 4
    assert region.area == pytest.approx(0.49, rel=1e-12)


def test_a_vertex_without_a_value_takes_its_triangles_out() -> None:
    points, triangles = scattered(80, 11)
    margins = np.ones((1, len(points)))
    margins[0, 17] = np.nan

    region = region_where(points, triangles, margins)

    without = [shapely.Polygon(points[t]).area for t in triangles if 17 not in t]
    assert region.area == pytest.approx(sum(without), rel=1e-12)
    assert_consistent(region)


@pytest.mark.parametrize("margin", [-1.0, np.nan])
def test_an_empty_region_says_so(margin: float) -> None:
    points, triangles = scattered(30, 1)

    region = region_where(points, triangles, np.full((1, len(points)), margin))

    assert region.is_empty
    assert region.area == 0.0
    least, greatest = region.extent(triangles, points)
    assert np.isnan(least).all()
    assert np.isnan(greatest).all()


def test_a_region_that_is_only_a_line_or_a_point_is_empty() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    triangles = np.array([[0, 1, 2], [1, 3, 2]])
    along_the_bottom = -points[:, 1]
    at_the_corner = -points.sum(axis=1)

    assert region_where(points, triangles, along_the_bottom[np.newaxis]).is_empty
    assert region_where(points, triangles, at_the_corner[np.newaxis]).is_empty


@pytest.mark.parametrize("seed", range(4))
def test_outline_of_triangles_encloses_exactly_them(seed: int) -> None:
    points, triangles = scattered(90, seed)
    chosen = np.random.default_rng(seed).uniform(size=len(triangles)) < 0.5

    loops = outline_of_triangles(points, triangles, chosen)

    expected = shapely.union_all([shapely.Polygon(points[t]) for t in triangles[chosen]])
    assert shapely.symmetric_difference(polygon_of(loops), expected).area < 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_cells_of_all_vertices_fill_the_plane_without_overlap(seed: int) -> None:
    points, triangles = scattered(90, seed)
    chosen = np.random.default_rng(seed).uniform(size=len(points)) < 0.4

    ours = polygon_of(outline_of_cells(points, triangles, chosen))
    others = polygon_of(outline_of_cells(points, triangles, ~chosen))

    hull = shapely.MultiPoint(points).convex_hull
    assert ours.area + others.area == pytest.approx(hull.area, rel=1e-9)
    assert shapely.intersection(ours, others).area < 1e-12
    thirds = np.bincount(
        triangles.ravel(),
        weights=np.repeat([shapely.Polygon(points[t]).area / 3 for t in triangles], 3),
        minlength=len(points),
    )
    assert ours.area == pytest.approx(thirds[chosen].sum(), rel=1e-9)
