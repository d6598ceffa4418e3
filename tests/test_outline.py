"""Outlines of usable workspaces against areas, polygons, signs and grids made independently."""

from __future__ import annotations

import math

import naive
import numpy as np
import numpy.typing as npt
import pytest
import shapely
from designs import MODES, random_cases, random_design
from special_designs import label, special_designs

from fivebar_atlas import FiveBar, UnknownNameError
from fivebar_atlas.mechanisms.five_bar.loci import singular_arcs
from fivebar_atlas.mechanisms.five_bar.outline import UsableWorkspace, usable_workspace_of
from fivebar_atlas.planar_geometry import CLOSED, CUSP, INTERSECTION, LEFT, TANGENCY, Arc, Region

Design = tuple[float, float, float]
Mode = tuple[int, int, int]
FloatArray = npt.NDArray[np.float64]

RANDOM = [random_design(rng) for rng in [np.random.default_rng(60)] for _ in range(1000)]
SPECIAL = special_designs()
#: Half of C_col lies on C_1i and C_2i.
TRIPLE = (1.5, 0.75, 0.75)


def workspaces(
    designs: list[Design], each_design: int = len(MODES)
) -> list[tuple[Design, Mode, UsableWorkspace]]:
    """Return the usable workspaces of designs in so many mode pairs each, in turn all eight."""
    found = []
    for place, design in enumerate(designs):
        for turn in range(each_design):
            mode = MODES[(place + 3 * turn) % len(MODES)]
            workspace = usable_workspace_of(design, mode)
            if workspace is not None:
                found.append((design, mode, workspace))
    return found


def normals(arc: Arc, shares: FloatArray) -> FloatArray:
    """Return unit vectors to the left of an arc, shape (n, 2), by differences."""
    along = arc.points(shares + 1e-5) - arc.points(shares - 1e-5)
    along /= np.hypot(*along.T)[:, None]
    return np.column_stack([-along[:, 1], along[:, 0]])


@pytest.mark.parametrize("designs", [RANDOM, SPECIAL], ids=["random", "special"])
def test_green_area_is_the_integrated_area_and_arcs_meet(designs: list[Design]) -> None:
    found = workspaces(designs)
    assert len(found) > 7 * len(designs)
    for design, mode, workspace in found:
        area = workspace.area
        assert area > 0.0
        # areas below 1e-6 are differences of terms of order 1
        assert workspace.region.area == pytest.approx(area, rel=1e-9, abs=5e-15), (design, mode)
        assert workspace.region.outline.area > 0.0
        assert all(hole.area < 0.0 for hole in workspace.region.holes)
        for loop in workspace.region.loops:
            for place, each in enumerate(loop.arcs):
                assert loop.arcs[place - 1].arc.end == each.arc.start, (design, mode, each.name)


def test_arcs_begin_and_end_where_they_meet() -> None:
    shares = np.array([0.0, 1.0])
    for design, mode, workspace in workspaces(RANDOM, 2):
        for each in workspace.region.arcs:
            gaps = each.arc.points(shares) - np.array([each.arc.start, each.arc.end])
            assert np.abs(gaps).max() < 1e-11, (design, mode, each.name)


@pytest.mark.parametrize("designs", [RANDOM, SPECIAL], ids=["random", "special"])
def test_polygons_along_the_outline_enclose_the_area(designs: list[Design]) -> None:
    deviation = 1e-4
    with_holes = 0
    for design, mode, workspace in workspaces(designs, 2):
        outline, *holes = workspace.region.polygons(deviation)
        polygon = shapely.Polygon(outline, holes)
        # at cusps chords may cross; a true crossing of arcs would change the area
        if not polygon.is_valid:
            polygon = shapely.make_valid(polygon)
        slack = deviation * (shapely.Polygon(outline, holes).length)
        assert polygon.area == pytest.approx(workspace.area, abs=slack), (design, mode)
        with_holes += len(holes) > 0
    assert with_holes > 20


def test_area_is_that_of_a_grid() -> None:
    for design, mode in random_cases(61, 30):
        workspace = usable_workspace_of(design, mode)
        assert workspace is not None
        n = 500
        mask = naive.usable_workspace_mask(*design, *mode, n)
        x, y = naive.grid(*design, n)
        cell = (x[1] - x[0]) * (y[1] - y[0])
        area = workspace.region.area
        assert area == pytest.approx(mask.sum() * cell, abs=0.02 + 0.005 * area), (design, mode)


def test_a_ring_is_two_whole_circles() -> None:
    workspace = usable_workspace_of((1.28, 1.72, 0.0), (1, -1, 1))
    assert workspace is not None
    (outer,), ((inner,),) = (
        workspace.region.outline.arcs,
        (hole.arcs for hole in workspace.region.holes),
    )
    assert outer.ends == inner.ends == (CLOSED, CLOSED)
    assert (outer.arc.swept_area(), inner.arc.swept_area()) == pytest.approx(
        (9.0 * math.pi, -(0.44**2) * math.pi)
    )


def test_no_workspace_has_no_outline() -> None:
    assert usable_workspace_of((1.28, 1.72, 0.0), (1, 1, 1)) is None
    assert usable_workspace_of((1.28, 1.72, 0.0), (1, -1, -1)) is None
    assert usable_workspace_of((0.5, 1.0, 1.5), (1, -1, 1)) is None
    robot = FiveBar(1.28, 1.72, 0.0)
    assert robot.usable_workspace("++/up") is None
    assert robot.good_condition_workspace(0.5, "++/up") == ()
    np.testing.assert_array_equal(robot.lci_inside([0.0, 1.0], [1.0, 1.0], "++/up"), 0.0)
    with pytest.raises(UnknownNameError, match="mode"):
        robot.usable_workspace("+-")


@pytest.mark.parametrize("designs", [RANDOM, SPECIAL], ids=["random", "special"])
def test_the_workspace_is_on_the_left_and_ends_at_its_outline(designs: list[Design]) -> None:
    shares = np.array([0.13, 0.48, 0.86])
    for design, mode, workspace in workspaces(designs, 1):
        s1, s2, assembly = mode
        for each in workspace.region.arcs:
            length = each.arc.length()
            if length < 1e-6 or design == TRIPLE:
                continue
            feet, offset = each.arc.points(shares), 1e-7 * length * normals(each.arc, shares)
            inside, outside = (
                assembly * naive.det_b(*design, *points.T, s1, s2)
                for points in (feet + offset, feet - offset)
            )
            assert np.all(inside > 0.0), (design, mode, each.name)
            if each.kind == "serial":
                assert np.all(np.isnan(outside)), (design, mode, each.name)
            elif each.kind == "parallel, folded" and design[0] == design[2]:
                # both fold circles are one, on which det B touches zero
                on_arc = naive.det_b(*design, *feet.T, s1, s2)
                np.testing.assert_allclose(on_arc, 0.0, atol=1e-14)
            else:
                assert np.all(outside < 0.0), (design, mode, each.name)


def test_outlines_are_pieces_of_the_loci_of_their_mode() -> None:
    shares = np.array([0.0, 0.21, 0.5, 0.9, 1.0])
    checked = 0
    for design, mode, workspace in workspaces(RANDOM[:60], 4):
        pair = label(*mode)
        loci = [each for each in singular_arcs(design, MODES) if pair in each.sides]
        for each in workspace.region.arcs:
            points = each.arc.points(shares)
            same = [locus for locus in loci if locus.name == each.name]
            gaps = np.array([locus.arc.nearest(points)[0] for locus in same])
            # where C_col touches a ray, rounding of the angle moves points along it
            assert gaps.min(axis=0).max() < 1e-7, (design, mode, each.name)
            # and the locus lies along the outline such that its side is the left of that
            locus = same[int(np.argmin(gaps[:, 2]))]
            corners = locus.arc.points(np.linspace(0.0, 1.0, 2001))
            nearest = int(np.argmin(np.hypot(*(corners[:-1] - points[2]).T)))
            along = corners[nearest + 1] - corners[nearest]
            left = normals(each.arc, shares[2:3])[0]
            is_left = along[0] * left[1] - along[1] * left[0] > 0.0
            assert is_left == (locus.sides[pair] == LEFT), (design, mode, each.name)
            checked += 1
    assert checked > 1000


def test_kinds_of_ends_against_tangents_of_implicit_equations() -> None:
    counts = {TANGENCY: 0, CUSP: 0, INTERSECTION: 0}
    for design, mode, workspace in workspaces(RANDOM[:300], 3):
        for loop in workspace.region.loops:
            for place, each in enumerate(loop.arcs):
                before = loop.arcs[place - 1]
                assert before.ends[1] == each.ends[0]
                if each.ends == (CLOSED, CLOSED):
                    continue
                vertex = np.array(each.arc.start)
                arriving, leaving = (
                    naive.locus_tangent(*design, arc.name, *vertex) for arc in (before, each)
                )
                last = vertex - before.arc.points(np.array([0.99]))[0]
                first = each.arc.points(np.array([0.01]))[0] - vertex
                if min(np.hypot(*last), np.hypot(*first)) < 1e-6:
                    continue  # an arc too short to tell its direction
                arriving = arriving * np.sign(arriving @ last)
                leaving = leaving * np.sign(leaving @ first)
                sine = abs(arriving[0] * leaving[1] - arriving[1] * leaving[0])
                if sine > 1e-2:
                    expected = INTERSECTION
                elif sine < 1e-5:
                    expected = TANGENCY if arriving @ leaving > 0.0 else CUSP
                else:
                    continue
                assert each.ends[0] == expected, (design, mode, before.name, each.name)
                counts[expected] += 1
    assert min(counts.values()) > 200


def test_points_inside_are_those_of_the_largest_component() -> None:
    rng = np.random.default_rng(62)
    inside = 0
    for design, mode in random_cases(63, 40):
        workspace = usable_workspace_of(design, mode)
        assert workspace is not None
        n = 300
        x, y = naive.grid(*design, n)
        mask = naive.usable_workspace_mask(*design, *mode, n)
        cell = math.hypot(x[1] - x[0], y[1] - y[0])
        iy, ix = rng.integers(n, size=(2, 400))
        points = np.column_stack([x[ix], y[iy]])
        found = workspace.contains(*points.T)
        # next to the boundary, and in necks and slivers thinner than a cell, a grid is wrong
        gaps, _ = workspace.region.boundary_distance(points)
        clear = gaps > 2.0 * cell
        np.testing.assert_array_equal(found[clear], mask[iy, ix][clear], str((design, mode)))
        outline, *holes = workspace.region.polygons(1e-5)
        polygon = shapely.make_valid(shapely.Polygon(outline, holes))
        clear = gaps > 1e-5
        np.testing.assert_array_equal(
            found[clear], shapely.contains_xy(polygon, points[clear]), str((design, mode))
        )
        inside += int(np.count_nonzero(found))
    assert inside > 2000


def test_lci_inside_is_that_of_the_singular_values_and_zero_outside() -> None:
    rng = np.random.default_rng(64)
    for design, mode in random_cases(65, 40):
        workspace = usable_workspace_of(design, mode)
        assert workspace is not None
        points = rng.uniform(-1.0, 1.0, (300, 2)) * (design[0] + design[1])
        inside = workspace.contains(*points.T)
        expected = np.zeros(len(points))
        expected[inside] = naive.lci(*design, *points[inside].T, *mode[:2])
        np.testing.assert_allclose(workspace.lci(*points.T), expected, atol=1e-8)
        robot = FiveBar(*design)
        np.testing.assert_array_equal(
            robot.lci_inside(*points.T, label(*mode)), workspace.lci(*points.T)
        )


def test_shapes_of_points_are_kept() -> None:
    workspace = FiveBar(1.2, 1.0, 0.8).usable_workspace("+-/up")
    assert workspace is not None
    x = np.linspace(-1.0, 1.0, 5)
    assert workspace.contains(x[:, None], x).shape == (5, 5)
    assert workspace.lci(0.0, 1.5).shape == ()
    assert bool(workspace.contains(0.0, 1.5))
    assert float(workspace.lci(0.0, 1.5)) == pytest.approx(
        float(naive.lci(1.2, 1.0, 0.8, 0.0, 1.5, 1, -1))
    )


def test_distance_from_the_boundary_against_polylines() -> None:
    rng = np.random.default_rng(66)
    for design, mode in random_cases(67, 40):
        workspace = usable_workspace_of(design, mode)
        assert workspace is not None
        region: Region = workspace.region
        low, high = (extreme(region.polygons(1e-2)[0], axis=0) for extreme in (np.min, np.max))
        points = rng.uniform(low, high, (25, 2))
        distances, nearest = region.boundary_distance(points)
        lines = [each.arc.points(np.linspace(0.0, 1.0, 3001)) for each in region.arcs]
        gaps = np.array([naive.distance_to_polyline(points, line) for line in lines])
        # chords of 1/3000 of an arc leave it by about 1e-6
        np.testing.assert_allclose(distances, gaps.min(axis=0), atol=3e-6, err_msg=str(design))
        places = [region.arcs.index(each) for each in nearest]
        of_nearest = gaps[places, np.arange(len(points))]
        np.testing.assert_allclose(of_nearest, gaps.min(axis=0), atol=3e-6)


def test_mirror_images() -> None:
    """Under y → -y +-/up becomes -+/down, under x → -x ++/up becomes --/up, legs exchanged."""
    exchanged = {"C_1o": "C_2o", "C_2o": "C_1o", "C_1i": "C_2i", "C_2i": "C_1i"}
    turned = {"C_coin_up": "C_coin_down", "C_coin_down": "C_coin_up"}
    for design in RANDOM[:40]:
        for mode, image, names, flip in (
            ((1, -1, 1), (-1, 1, -1), turned, np.array([1.0, -1.0])),
            ((1, 1, 1), (-1, -1, 1), exchanged, np.array([-1.0, 1.0])),
            ((1, 1, -1), (-1, -1, 1), turned, np.array([1.0, -1.0])),
        ):
            one, two = usable_workspace_of(design, mode), usable_workspace_of(design, image)
            assert one is not None
            assert two is not None
            vertices = {
                (names.get(each.name, each.name), *np.round(np.array(end) * flip + 0.0, 9))
                for each in one.region.arcs
                for end in (each.arc.start, each.arc.end)
            }
            assert vertices == {
                (each.name, *np.round(np.array(end) + 0.0, 9))
                for each in two.region.arcs
                for end in (each.arc.start, each.arc.end)
            }
            assert one.region.area == pytest.approx(two.region.area, rel=1e-12, abs=1e-14)


def test_area_of_designs_next_to_those_where_curves_begin_to_meet() -> None:
    for design, mode in (
        ((0.9752564930454324, 1.0123717534724583, 1.012371753482109), (1, 1, 1)),  # r2 = r3
        ((1.5000000036374097, 0.5000000016371556, 0.9999999947254341), (1, -1, -1)),  # r1 = r2 + r3
    ):
        workspace = usable_workspace_of(design, mode)
        assert workspace is not None
        assert workspace.region.area == pytest.approx(workspace.area, rel=1e-9)


def test_a_base_of_rounding_is_none_or_a_short_one() -> None:
    """3 - 2.01 - 0.99 is 2.2e-16."""
    limit = usable_workspace_of((2.01, 0.99 - 1e-9, 1e-9), (1, 1, 1))
    assert limit is not None
    for r3 in (2.220446049250313e-16, 1e-15):
        workspace = usable_workspace_of((2.01, 0.99 - r3, r3), (1, 1, 1))
        if workspace is None:
            continue
        assert workspace.area == pytest.approx(limit.area, rel=1e-6)
        assert workspace.region.area == pytest.approx(workspace.area, rel=1e-9)


def test_a_workspace_of_rounding_is_empty_or_has_an_outline() -> None:
    """Where r1 - r2 is rounding, +-/down is a disc of radius √(r1² - r2²), here 2e-7."""
    workspace = usable_workspace_of((1.5 + 1e-14, 1.5 - 1e-14, 0.0), (1, -1, -1))
    if workspace is not None:
        assert workspace.region.area == pytest.approx(workspace.area, abs=5e-15)
