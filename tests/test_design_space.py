"""Design space: lattice, triangulation, sub-regions, drawing, scaling of lengths."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.five_bar import design_space

RESOLUTIONS = [3, 4, 5, 6, 7, 8, 13, 30, 31, 32, 100]


def triples_one_by_one(space: str, resolution: int) -> list[tuple[int, int, int]]:
    """All triples of a space, tried one by one: k slowest, then i."""
    found = []
    for k in range(resolution + 1):
        for i in range(1, resolution + 1):
            j = resolution - i - k
            if j < 1:
                continue
            if space == "surrounded" and i >= k and j >= k:
                found.append((i, j, k))
            if space == "assemblable" and 2 * k <= resolution:
                found.append((i, j, k))
    return found


def sub_region_by_fractions(r1: Fraction, r2: Fraction, r3: Fraction) -> str:
    """Decide by the definition of the paper, in exact numbers."""
    if r1 < r3 or r2 < r3:
        return "outside"
    if r2 > r1 + r3:
        return "IVa"
    if r1 > r2 + r3:
        return "IVb"
    return "Va" if r1 <= r2 else "Vb"


@pytest.mark.parametrize("space", design_space.SPACES)
@pytest.mark.parametrize("resolution", RESOLUTIONS)
def test_lattice_holds_every_triple_of_the_space_in_order(space: str, resolution: int) -> None:
    expected = triples_one_by_one(space, resolution)
    assert design_space.lattice_triples(space, resolution).tolist() == [list(t) for t in expected]


@pytest.mark.parametrize("space", design_space.SPACES)
def test_lattice_lengths_are_the_nearest_doubles(space: str) -> None:
    triples = triples_one_by_one(space, 31)
    exact = [[float(Fraction(3 * number, 31)) for number in triple] for triple in triples]
    assert design_space.lattice(space, 31).tolist() == exact


def test_paper_lattice_holds_the_designs_of_the_paper() -> None:
    designs = {tuple(design) for design in design_space.lattice("surrounded", 300).tolist()}
    assert {(1.28, 1.72, 0.0), (1.3, 1.6, 0.1), (1.5, 1.5, 0.0), (1.0, 1.0, 1.0)} <= designs
    assert 15_200 < len(designs) < 15_300


def test_border_designs_belong_to_the_space() -> None:
    surrounded = set(map(tuple, design_space.lattice_triples("surrounded", 12).tolist()))
    assert {(2, 8, 2), (8, 2, 2), (4, 4, 4), (1, 11, 0)} <= surrounded
    assemblable = set(map(tuple, design_space.lattice_triples("assemblable", 12).tolist()))
    assert {(1, 5, 6), (5, 1, 6), (1, 11, 0)} <= assemblable
    assert surrounded < assemblable


def test_unknown_space_is_refused() -> None:
    for function in (design_space.lattice, design_space.triangles, design_space.rows):
        with pytest.raises(UnknownNameError, match="did you mean 'surrounded'"):
            function("surounded", 10)
    with pytest.raises(UnknownNameError):
        design_space.chart("all")


@pytest.mark.parametrize("space", design_space.SPACES)
@pytest.mark.parametrize("resolution", RESOLUTIONS)
def test_triangles_tile_the_convex_hull_of_the_designs(space: str, resolution: int) -> None:
    triples = design_space.lattice_triples(space, resolution)
    triangles = design_space.triangles(space, resolution)
    # Twice the areas in lattice units are integers: no rounding in what follows.
    i, k = triples[:, 0], triples[:, 2]
    a, b, c = triangles.T
    doubled = (i[b] - i[a]) * (k[c] - k[a]) - (i[c] - i[a]) * (k[b] - k[a])
    assert np.all(doubled == 1)
    assert set(triangles.ravel().tolist()) == set(range(len(triples)))
    hull = ConvexHull(np.column_stack([i, k]))
    assert doubled.sum() == round(2.0 * hull.volume)
    # Positive areas that sum to the hull, edges met by two triangles or on the hull: a tiling.
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    )
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert counts.max() <= 2


@pytest.mark.parametrize("space", design_space.SPACES)
@pytest.mark.parametrize("resolution", [6, 7, 31])
def test_triangles_reach_the_borders_that_hold_designs(space: str, resolution: int) -> None:
    designs = design_space.lattice(space, resolution)
    points = design_space.project(designs)
    union = shapely.union_all(
        [shapely.Polygon(points[t]) for t in design_space.triangles(space, resolution)]
    )
    outline = shapely.Polygon(design_space.chart(space).outline)
    assert outline.buffer(1e-9).contains(union)
    on_border = designs[:, 2] == 0.0
    if space == "surrounded":
        triples = design_space.lattice_triples(space, resolution)
        on_border |= (triples[:, 0] == triples[:, 2]) | (triples[:, 1] == triples[:, 2])
    elif resolution % 2 == 0:
        on_border |= designs[:, 2] == 1.5
    assert on_border.sum() > 3
    # Along the borders no gap is left: the border from the first to the last design on it.
    assert all(union.boundary.distance(shapely.Point(p)) < 1e-9 for p in points[on_border])
    for first, second in [(0, 2), (1, 2)] if space == "surrounded" else []:
        triples = design_space.lattice_triples(space, resolution)
        line = points[(triples[:, first] == triples[:, second]) & (triples[:, 2] > 0)]
        if len(line) > 1:
            assert shapely.LineString(line).difference(union.buffer(1e-9)).is_empty


@pytest.mark.parametrize("resolution", [3, 4, 7, 12, 30, 300])
def test_sub_region_of_integers_and_of_floats_agree_with_exact_numbers(resolution: int) -> None:
    triples = design_space.lattice_triples("assemblable", resolution)
    expected = [
        sub_region_by_fractions(*(Fraction(3 * int(n), resolution) for n in triple))
        for triple in triples
    ]
    for lengths in (triples, design_space.lattice("assemblable", resolution), triples * 7.1e-5):
        codes = design_space.sub_region(lengths)
        assert [design_space.SUB_REGIONS.describe(int(code)) for code in codes] == expected


@given(st.integers(1, 5000), st.integers(1, 5000), st.integers(0, 5000), st.floats(1e-50, 1e50))
def test_sub_region_does_not_depend_on_the_scale(i: int, j: int, k: int, scale: float) -> None:
    lengths = np.array([i, j, k])
    assert design_space.sub_region(lengths * scale) == design_space.sub_region(lengths)


@pytest.mark.parametrize(
    ("lengths", "name"),
    [
        ((1.28, 1.72, 0.0), "IVa"),
        ((1.5, 1.5, 0.0), "Va"),
        ((1.0, 1.0, 1.0), "Va"),
        ((26.0, 30.0, 16.0), "Va"),
        ((0.1 + 0.2, 0.3, 0.3), "Va"),
        ((1.4, 1.1, 0.5), "Vb"),
        ((2.0, 0.6, 0.4), "IVb"),
        ((0.5, 1.5, 1.0), "outside"),
        ((1.5, 0.5, 1.0), "outside"),
        # r2 = r1 + r3, r1 = r2 + r3 and r1 = r3 in decimals that are not exact.
        ((0.9, 1.5, 0.6), "Va"),
        ((1.5, 1.1, 0.4), "Vb"),
        ((0.7, 1.6, 0.7), "IVa"),
    ],
)
def test_sub_region_of_known_designs(lengths: tuple[float, float, float], name: str) -> None:
    assert (
        design_space.SUB_REGIONS.describe(int(design_space.sub_region(np.array(lengths)))) == name
    )


def test_projection_is_equilateral() -> None:
    corners = design_space.project(np.array([[3.0, 0, 0], [0, 3.0, 0], [0, 0, 3.0]]))
    sides = [math.dist(corners[a], corners[b]) for a, b in [(0, 1), (1, 2), (2, 0)]]
    assert sides == pytest.approx([2 * math.sqrt(3)] * 3)
    rng = np.random.default_rng(1)
    designs = 3 * rng.dirichlet([1, 1, 1], 50)
    points = design_space.project(designs)
    for parameter, (a, b) in enumerate([(1, 2), (0, 2), (0, 1)]):
        side = shapely.LineString([corners[a], corners[b]])
        distances = [side.distance(shapely.Point(point)) for point in points]
        assert distances == pytest.approx(designs[:, parameter])


def test_charts_have_the_outline_of_their_space() -> None:
    triangle = shapely.Polygon(design_space.chart("surrounded").outline)
    assert triangle.area == pytest.approx(math.sqrt(3))
    trapezium = shapely.Polygon(design_space.chart("assemblable").outline)
    assert trapezium.area == pytest.approx(3 * math.sqrt(3) * 3 / 4)
    assert triangle.exterior.is_ccw
    assert trapezium.exterior.is_ccw


def unproject(point: tuple[float, float]) -> tuple[float, float, float]:
    """Return the design at a point of the chart."""
    x, y = point
    r1 = (math.sqrt(3) * x - y) / 2
    return r1, 3 - r1 - y, y


@pytest.mark.parametrize("space", design_space.SPACES)
def test_chart_borders_are_the_borders_clipped_to_the_space(space: str) -> None:
    chart = design_space.chart(space)
    outline = shapely.Polygon(chart.outline)
    equalities = [
        lambda r1, r2, _: r1 - r2,
        lambda r1, r2, r3: r2 - r1 - r3,
        lambda r1, r2, r3: r1 - r2 - r3,
        lambda r1, _, r3: r1 - r3,
        lambda _, r2, r3: r2 - r3,
    ]
    assert len(chart.borders) == (3 if space == "surrounded" else 5)
    for border, residual in zip(chart.borders, equalities, strict=False):
        assert border.shape == (2, 2)
        assert math.dist(*border) > 0.5
        for end in border:
            assert residual(*unproject(tuple(end))) == pytest.approx(0.0, abs=1e-12)
            assert outline.boundary.distance(shapely.Point(end)) < 1e-12


@pytest.mark.parametrize("space", design_space.SPACES)
def test_chart_names_stand_in_their_sub_regions(space: str) -> None:
    regions = design_space.chart(space).regions
    assert [region.name for region in regions] == ["IVa", "Va", "Vb", "IVb"]
    for region in regions:
        design = np.array(unproject((region.x, region.y)))
        code = int(design_space.sub_region(design))
        assert design_space.SUB_REGIONS.describe(code) == region.name


@pytest.mark.parametrize("space", design_space.SPACES)
def test_chart_ticks_stand_on_the_outline_at_their_value(space: str) -> None:
    chart = design_space.chart(space)
    outline = shapely.Polygon(chart.outline)
    assert [axis.label for axis in chart.axes] == ["$r_1$", "$r_2$", "$r_3$"]
    for parameter, axis in enumerate(chart.axes):
        values = [float(tick.label) for tick in axis.ticks]
        assert len(set(values)) == len(values) >= 4
        for tick, value in zip(axis.ticks, values, strict=True):
            assert unproject((tick.x, tick.y))[parameter] == pytest.approx(value)
            assert outline.boundary.distance(shapely.Point(tick.x, tick.y)) < 1e-12
            assert math.hypot(tick.dx, tick.dy) == pytest.approx(1.0)
            # Outward, and along the line on which the parameter is constant.
            ahead = tick.x + 0.01 * tick.dx, tick.y + 0.01 * tick.dy
            assert not outline.contains(shapely.Point(ahead))
            assert unproject(ahead)[parameter] == pytest.approx(value)
        assert not outline.contains(shapely.Point(axis.label_x, axis.label_y))
        assert abs(axis.rotation) <= 90.0


def test_dimensional_lengths_are_scaled_by_their_mean() -> None:
    design, factor = design_space.normalise((26.0, 30.0, 16.0))
    assert factor == 24.0
    assert design == pytest.approx([26 / 24, 30 / 24, 16 / 24], rel=1e-15)


@pytest.mark.parametrize("lengths", [(1.28, 1.72, 0.0), (1.3, 1.6, 0.1), (0.7, 1.6, 0.7)])
def test_nondimensional_lengths_stay_as_they_are(lengths: tuple[float, float, float]) -> None:
    design, factor = design_space.normalise(lengths)
    assert (tuple(design), factor) == (lengths, 1.0)


@given(
    st.floats(1e-3, 1e3),
    st.floats(1e-3, 1e3),
    st.floats(0.0, 1.0),
    st.floats(1e-90, 1e90),
)
def test_scaling_is_undone_by_the_factor(r1: float, r2: float, share: float, unit: float) -> None:
    lengths = (r1 * unit, r2 * unit, share * (r1 + r2) * unit)
    design, factor = design_space.normalise(lengths)
    assert design.sum() == pytest.approx(3.0, rel=1e-14)
    assert design * factor == pytest.approx(lengths, rel=1e-14)


def test_minus_zero_is_zero() -> None:
    design, _ = design_space.normalise((10.0, 20.0, -0.0))
    assert math.copysign(1.0, design[2]) == 1.0


@pytest.mark.parametrize(
    ("lengths", "name"),
    [
        ((-1.0, 1.0, 1.0), "R1"),
        ((0.0, 1.0, 1.0), "R1"),
        ((1.0, 0.0, 1.0), "R2"),
        ((1.0, 1.0, -0.1), "R3"),
        ((math.nan, 1.0, 1.0), "R1"),
        ((1.0, math.inf, 1.0), "R2"),
        ((1.0, 1.0, math.nan), "R3"),
        ((1.0, 1.0, math.inf), "R3"),
        ((1.0, 1.0, 2.1), "R1 R2 R3"),
        ((1e300, 1e300, 1e300), "R1 R2 R3"),
        ((1e-300, 1e-300, 0.0), "R1 R2 R3"),
    ],
)
def test_lengths_that_make_no_machine_are_refused(
    lengths: tuple[float, float, float], name: str
) -> None:
    with pytest.raises(InputError) as caught:
        design_space.normalise(lengths)
    assert caught.value.name == name
    assert caught.value.exit_code == 2


def test_stretched_machine_is_at_the_limit_of_assembly() -> None:
    design, _ = design_space.normalise((0.1, 0.2, 0.1 + 0.2))
    assert design[2] == pytest.approx(1.5)
