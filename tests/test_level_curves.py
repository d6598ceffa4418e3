"""Level curves against functions with known ones, and good-condition workspaces."""

from __future__ import annotations

import math

import naive
import numpy as np
import numpy.typing as npt
import pytest
import shapely
from designs import MODES, random_cases
from special_designs import label

from fivebar_atlas import FiveBar, InputError
from fivebar_atlas.level_curves import SampledField, level_regions
from fivebar_atlas.planar_geometry import CLOSED, Region

FloatArray = npt.NDArray[np.float64]
BOX = (np.array([-3.0, -3.0]), np.array([3.0, 3.0]))


def hill(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return 1 - (x - 0.3)²/4 - y²: ellipses, elongated along x."""
    return 1.0 - (x - 0.3) ** 2 / 4.0 - y**2


def ring(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return a hill in the middle of a ring wall: cos(3 ρ), 0 from ρ = 5π/6 outwards."""
    rho = np.hypot(x, y)
    return np.where(rho < 5.0 * math.pi / 6.0, np.cos(3.0 * rho), 0.0)


def two_hills(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the higher of two cones, of radii 1 and 0.5 at level 0."""
    return np.maximum(1.0 - np.hypot(x - 1.2, y), 0.5 - np.hypot(x + 1.2, y - 0.4))


def area(corners: FloatArray) -> float:
    """Return the area of a polygon, positive if counter-clockwise."""
    x, y = corners.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_corners_lie_on_the_level() -> None:
    for function in (hill, ring, two_hills):
        field = SampledField.over(function, *BOX, cells=57)
        for level in (0.05, 0.31, 0.47):
            loops = [loop for part in field.polygons(level) for loop in part]
            assert loops
            for line in [*loops, *field.lines(level)]:
                np.testing.assert_allclose(function(*line.T), level, atol=1e-14)
                assert np.all(np.hypot(*np.diff(line, axis=0).T) < 2.0 * 6.0 / 57)


def test_polygons_of_an_ellipse_tend_to_it() -> None:
    exact = math.pi * 1.2 * 0.6
    errors = []
    for cells in (40, 160, 640):
        ((outline,),) = SampledField.over(hill, *BOX, cells=cells).polygons(0.64)
        errors.append(exact - area(outline))
        assert len(np.unique(outline, axis=0)) == len(outline)
    # inscribed in a convex region, and of second order
    assert min(errors) > 0.0
    assert errors[1] / errors[0] == pytest.approx(1.0 / 16.0, rel=0.3)
    assert errors[2] / errors[1] == pytest.approx(1.0 / 16.0, rel=0.3)
    assert errors[2] < 1e-4


def test_outlines_run_counter_clockwise_and_holes_clockwise() -> None:
    # cos 3ρ ≥ 1/2 up to ρ = π/9 and from 5π/9 to 7π/9
    parts = SampledField.over(ring, *BOX, cells=150).polygons(0.5)
    assert sorted(len(part) for part in parts) == [1, 2]
    (disc,), (outer, hole) = sorted(parts, key=len)
    for loop, radius, turn in ((disc, 1.0, 1.0), (outer, 7.0, 1.0), (hole, 5.0, -1.0)):
        np.testing.assert_allclose(np.hypot(*loop.T), radius * math.pi / 9.0, rtol=1e-14)
        assert area(loop) == pytest.approx(turn * math.pi * (radius * math.pi / 9.0) ** 2, rel=3e-3)


def test_regions_are_sorted_by_area_and_named() -> None:
    field = SampledField.over(two_hills, *BOX, cells=200)
    large, small = level_regions(field, 0.25, "LCI", r"$1/\kappa_J$")
    assert large.area == pytest.approx(math.pi * 0.75**2, rel=1e-3)
    assert small.area == pytest.approx(math.pi * 0.25**2, rel=1e-2)
    (each,) = large.arcs
    assert (each.name, each.symbol) == ("LCI = 0.25", r"$1/\kappa_J$ $= 0.25$")
    assert each.ends == (CLOSED, CLOSED)
    assert each.arc.start == each.arc.end
    (alone,) = level_regions(field, 0.75, "LCI", "L")
    assert alone.area == pytest.approx(math.pi * 0.25**2, rel=1e-2)
    assert level_regions(field, 1.5, "LCI", "L") == ()


def test_lines_that_leave_the_box_are_open() -> None:
    field = SampledField.over(lambda x, y: x + 0.1 * y, *BOX, cells=40)
    (line,) = field.lines(0.237)
    assert not np.array_equal(line[0], line[-1])
    np.testing.assert_allclose(line[:, 0] + 0.1 * line[:, 1], 0.237, atol=1e-14)
    (closed,) = SampledField.over(hill, *BOX, cells=40).lines(0.5)
    np.testing.assert_array_equal(closed[0], closed[-1])


def test_the_grid_covers_the_box() -> None:
    field = SampledField.over(hill, np.array([-1.7, 0.0]), np.array([2.3, 1.0]), cells=8)
    steps = np.concatenate([np.diff(field.x), np.diff(field.y)])
    np.testing.assert_allclose(steps, 0.5)
    assert field.x[0] == pytest.approx(-1.95)
    assert field.x[-1] >= 2.3 + 0.2
    assert field.y[-1] >= 1.0 + 0.2
    assert field.values.shape == (len(field.y), len(field.x))
    np.testing.assert_array_equal(field.values[2, 3], hill(field.x[3], field.y[2]))


def good_condition_area(robot: FiveBar, threshold: float, pair: str) -> float:
    """Return the area of the good-condition workspace as it is integrated."""
    (entry,) = robot.evaluate(pair, (threshold,), 1e-8)["good_condition"]
    found: float = entry["area"]
    return found


@pytest.mark.parametrize(
    ("lengths", "threshold"),
    [((1.28, 1.72, 0.0), 0.5), ((1.28, 1.72, 0.0), 0.2), ((1.3, 1.6, 0.1), 0.5)],
)
def test_area_of_a_smooth_good_condition_workspace(
    lengths: tuple[float, float, float], threshold: float
) -> None:
    robot = FiveBar(*lengths)
    regions = robot.good_condition_workspace(threshold, "+-/up")
    expected = good_condition_area(robot, threshold, "+-/up")
    assert sum(region.area for region in regions) == pytest.approx(expected, rel=1e-6)
    if lengths[2] == 0.0:
        (region,) = regions
        (hole,) = region.holes
        radii = np.hypot(*np.concatenate([region.outline.polyline(1.0), hole.polyline(1.0)]).T)
        # LCI = min(tan ψ, cot ψ), cos ψ = (ρ² + r2² - r1²) / (2 ρ r2)
        cosines = (radii**2 + 1.72**2 - 1.28**2) / (2.0 * radii * 1.72)
        tangents = np.sqrt(1.0 - cosines**2) / cosines
        np.testing.assert_allclose(np.minimum(tangents, 1.0 / tangents), threshold, rtol=1e-11)


def test_good_condition_workspaces_of_random_designs() -> None:
    """Corners have the LCI of the threshold; areas are right but for tips cut by the grid."""
    rng = np.random.default_rng(80)
    several, with_holes, found = 0, 0, 0
    for design, mode in random_cases(81, 120):
        if min(design[:2]) < 0.05:
            continue
        threshold = float(rng.choice([0.1, 0.3, 0.5, 0.7, 0.9]))
        robot = FiveBar(*design)
        regions = robot.good_condition_workspace(threshold, label(*mode))
        assert [region.area for region in regions] == sorted(
            (region.area for region in regions), reverse=True
        )
        perimeter = 0.0
        for region in regions:
            assert region.outline.area > 0.0
            assert all(hole.area < 0.0 for hole in region.holes)
            for each in region.arcs:
                corners = each.arc.polyline(1.0)
                # in corners between reach circles it is steep beyond all rounding
                around = [
                    np.nan_to_num(naive.lci(*design, *(corners + aside).T, *mode[:2]))
                    for aside in 1e-8 * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
                ]
                low, high = np.min(around, axis=0), np.max(around, axis=0)
                met = (low <= threshold + 1e-9) & (high >= threshold - 1e-9)
                # where pieces of a thin part are joined a few corners are 1e-6 aside
                assert np.mean(met) > 0.99, design
                perimeter += each.arc.length()
        workspace = robot.usable_workspace(label(*mode))
        assert workspace is not None
        outline = workspace.region.outline.polyline(1e-2)
        step = float(np.ptp(outline, axis=0).max()) / 400.0
        total = sum(region.area for region in regions)
        expected = good_condition_area(robot, threshold, label(*mode))
        assert abs(total - expected) < 0.1 * step * (perimeter + step), (design, mode)
        found += total > 0.0
        several += len(regions) > 1
        with_holes += any(region.holes for region in regions)
    assert found > 60
    assert several > 10
    assert with_holes > 5


def test_areas_tend_to_the_integrated_one_with_the_square_of_the_step() -> None:
    robot = FiveBar(1.2, 1.0, 0.8)
    workspace = robot.usable_workspace("+-/up")
    assert workspace is not None
    expected = good_condition_area(robot, 0.5, "+-/up")
    outline = workspace.region.outline.polyline(1e-3)
    errors = []
    for cells in (200, 800):
        field = SampledField.over(workspace.lci, outline.min(axis=0), outline.max(axis=0), cells)
        regions = level_regions(field, 0.5, "LCI", "L")
        assert len(regions) == 3
        errors.append(abs(sum(region.area for region in regions) / expected - 1.0))
    assert errors[0] < 2e-3
    assert errors[1] < 0.1 * errors[0]


def test_parts_of_a_good_condition_workspace_do_not_overlap() -> None:
    robot = FiveBar(1.2, 1.0, 0.8)
    for mode in MODES:
        regions = robot.good_condition_workspace(0.6, label(*mode))
        shapes = [as_shape(region) for region in regions]
        union = shapely.union_all(shapes)
        assert union.area == pytest.approx(sum(region.area for region in regions))


def as_shape(region: Region) -> shapely.Polygon:
    """Return a region of polylines for shapely, which checks that it is valid."""
    outline, *holes = region.polygons(1.0)
    shape = shapely.Polygon(outline, holes)
    assert shape.is_valid
    return shape


@pytest.mark.parametrize("threshold", [0.0, 1.0, -0.5, math.nan, 2.0])
def test_thresholds_out_of_range_are_refused(threshold: float) -> None:
    with pytest.raises(InputError, match="lci_threshold"):
        FiveBar(1.2, 1.0, 0.8).good_condition_workspace(threshold)


def test_grid_points_that_lie_on_the_level() -> None:
    def pyramid(x: FloatArray, y: FloatArray) -> FloatArray:
        return 1.0 - np.abs(x) - np.abs(y)

    one = np.array([1.0, 1.0])
    ((outline,),) = SampledField.over(pyramid, -one, one, cells=8).polygons(0.5)
    np.testing.assert_allclose(pyramid(*outline.T), 0.5, atol=1e-14)
