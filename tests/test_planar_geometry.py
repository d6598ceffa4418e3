"""Arcs, outlines and regions against dense samples, quadrature and shapely."""

from __future__ import annotations

import math
from collections.abc import Sequence

import naive
import numpy as np
import numpy.typing as npt
import pytest
import shapely
from designs import MODES, random_design

from fivebar_atlas import InputError
from fivebar_atlas.mechanisms.five_bar.coupler_curve import CouplerArc
from fivebar_atlas.mechanisms.five_bar.loci import singular_arcs
from fivebar_atlas.planar_geometry import (
    CLOSED,
    CUSP,
    INTERSECTION,
    TANGENCY,
    Arc,
    CircleArc,
    Loop,
    NamedArc,
    PolylineArc,
    Region,
    closed_loop,
    meeting,
    mirror,
    region_of,
)

FloatArray = npt.NDArray[np.float64]


def coupler_arcs(seed: int, count: int, turning: bool = False) -> list[CouplerArc]:
    """Return arcs of C_col of random designs; only those over several pieces if so asked."""
    rng = np.random.default_rng(seed)
    found: list[CouplerArc] = []
    while len(found) < count:
        design = random_design(rng)
        for each in singular_arcs(design, MODES):
            arc = each.arc
            if not isinstance(arc, CouplerArc) or arc.length() < 0.2:
                continue
            if len(arc.pieces) > 1 or not turning:
                found.append(arc)
    return found[:count]


def circle_arcs(seed: int, count: int) -> list[CircleArc]:
    """Return random arcs of circles, run through either way."""
    rng = np.random.default_rng(seed)
    return [
        CircleArc.of_angles(
            (float(rng.uniform(-2.0, 2.0)), float(rng.uniform(-2.0, 2.0))),
            float(rng.uniform(0.1, 3.0)),
            float(rng.uniform(-7.0, 7.0)),
            float(rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 2.0 * math.pi)),
        )
        for _ in range(count)
    ]


CIRCLES = [*circle_arcs(70, 12), CircleArc.whole((0.3, -0.2), 1.5)]
COUPLERS = [*coupler_arcs(71, 12), *coupler_arcs(72, 8, turning=True)]
ZIGZAG = PolylineArc(np.random.default_rng(73).uniform(-1.0, 1.0, (9, 2)))
ARCS: list[Arc] = [*CIRCLES, *COUPLERS, ZIGZAG]
DENSE = np.linspace(0.0, 1.0, 40_001)


def names(arcs: Sequence[Arc]) -> list[str]:
    """Return names for the cases of a test."""
    return [f"{type(arc).__name__}{place}" for place, arc in enumerate(arcs)]


every_arc = pytest.mark.parametrize("arc", ARCS, ids=names(ARCS))


def shoelace(line: FloatArray) -> float:
    """Return ½ ∫ (x dy - y dx) along a polyline."""
    x, y = line.T
    return 0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))


@every_arc
def test_area_and_length_against_dense_chords(arc: Arc) -> None:
    """Both errors of chords fall with their square: two samples extrapolate to the limit."""
    coarse, fine = arc.points(DENSE[::2]), arc.points(DENSE)
    lengths = [float(np.hypot(*np.diff(line, axis=0).T).sum()) for line in (coarse, fine)]
    areas = [shoelace(line) for line in (coarse, fine)]
    length, area = ((4.0 * two - one) / 3.0 for one, two in (lengths, areas))
    if arc is ZIGZAG:  # 40,000 is a multiple of its 8 segments
        length, area = lengths[1], areas[1]
    assert arc.swept_area() == pytest.approx(area, abs=1e-10)
    assert arc.length() == pytest.approx(length, rel=1e-10)


@every_arc
def test_ends(arc: Arc) -> None:
    first, last = arc.points(np.array([0.0, 1.0]))
    np.testing.assert_allclose(first, arc.start, atol=1e-13)
    np.testing.assert_allclose(last, arc.end, atol=1e-13)
    for at_end, places in ((False, [0.0, 1e-3]), (True, [1.0 - 1e-3, 1.0])):
        along = np.diff(arc.points(np.array(places)), axis=0)[0]
        np.testing.assert_allclose(
            arc.direction(at_end), along / np.hypot(*along), atol=0.05, err_msg=str(at_end)
        )


@every_arc
def test_reversed(arc: Arc) -> None:
    back = arc.reversed()
    assert (back.start, back.end) == (arc.end, arc.start)
    # at the origin, and on a ray that it touches, C_col is as good as the root of a rounded angle
    np.testing.assert_allclose(back.points(DENSE[::500]), arc.points(DENSE[::500])[::-1], atol=1e-6)
    assert back.swept_area() == pytest.approx(-arc.swept_area(), abs=1e-14)
    assert back.length() == pytest.approx(arc.length(), rel=1e-12)
    assert type(back.reversed()) is type(arc)


@every_arc
def test_scaled(arc: Arc) -> None:
    large = arc.scaled(7.3).scaled(10.0)
    np.testing.assert_allclose(large.points(DENSE[::500]), 73.0 * arc.points(DENSE[::500]))
    np.testing.assert_allclose([large.start, large.end], 73.0 * np.array([arc.start, arc.end]))
    assert large.swept_area() == pytest.approx(73.0**2 * arc.swept_area(), rel=1e-12, abs=1e-12)
    assert large.length() == pytest.approx(73.0 * arc.length(), rel=1e-11)
    points = np.array([[0.2, 0.1], [-1.0, 2.0]])
    np.testing.assert_allclose(large.nearest(73.0 * points)[0], 73.0 * arc.nearest(points)[0])


@every_arc
@pytest.mark.parametrize("flip", [(True, False), (False, True), (True, True)])
def test_mirrored(arc: Arc, flip: tuple[bool, bool]) -> None:
    image = arc.mirrored(*flip)
    signs = np.array([-1.0 if each else 1.0 for each in flip])
    np.testing.assert_allclose(
        image.points(DENSE[::500]), signs * arc.points(DENSE[::500]), atol=1e-6
    )
    assert image.start == mirror(arc.start, *flip)
    assert image.end == mirror(arc.end, *flip)
    assert image.swept_area() == pytest.approx(signs.prod() * arc.swept_area(), abs=1e-14)


@every_arc
@pytest.mark.parametrize("deviation", [math.inf, 1.0, 0.1, 1e-2, 1e-4, 1e-6])
def test_chords_leave_the_arc_by_no_more_than_asked(arc: Arc, deviation: float) -> None:
    line = arc.polyline(deviation)
    assert tuple(line[0]) == arc.start
    assert tuple(line[-1]) == arc.end
    assert len(line) >= 2
    if deviation < 1e-5:  # so many chords; look at a part of the arc
        sample = arc.points(0.35 + 0.02 * DENSE[::200])
    else:
        sample = arc.points(DENSE[::100])
    assert naive.distance_to_polyline(sample, line).max() <= min(deviation, 20.0) + 1e-13
    # and corners are points of it, no more of them than a few times what is needed
    assert naive.distance_to_polyline(line[::7], arc.points(DENSE[::10])).max() < 1e-5
    if isinstance(arc, CircleArc) and deviation <= 1e-2:
        least = abs(arc.sweep) / (2.0 * math.acos(1.0 - deviation / arc.radius))
        assert len(line) - 1 <= math.ceil(least) + 1


@every_arc
def test_nearest_against_a_dense_sample(arc: Arc) -> None:
    rng = np.random.default_rng(74)
    low, high = (extreme(arc.points(DENSE[::100]), axis=0) for extreme in (np.min, np.max))
    size = float(np.hypot(*(high - low)))
    points = rng.uniform(low - 0.3 * size, high + 0.3 * size, (60, 2))
    distances, feet = arc.nearest(points)
    np.testing.assert_allclose(distances, np.hypot(*(points - feet).T), atol=1e-14)
    dense = arc.points(DENSE[::10])
    expected = naive.distance_to_polyline(points, dense)
    np.testing.assert_allclose(distances, expected, atol=1e-6 * size)
    assert naive.distance_to_polyline(feet, dense).max() < 1e-6 * size
    # points of the arc are their own feet
    on_it = arc.points(rng.uniform(0.0, 1.0, 60))
    distances, _ = arc.nearest(on_it)
    assert distances.max() < 1e-7 * size


@pytest.mark.parametrize("arc", coupler_arcs(75, 30, turning=True))
def test_pieces_of_c_col_make_one_smooth_curve(arc: CouplerArc) -> None:
    """Halving the shares halves steps and turning angles: there is no gap and no corner."""
    largest = []
    for chords in (2000, 8000):
        along = np.diff(arc.points(np.linspace(0.0, 1.0, chords + 1)), axis=0)
        lengths = np.hypot(*along.T)
        along = along[lengths > 1e-6 * lengths.max()]
        turns = np.arctan2(
            along[:-1, 0] * along[1:, 1] - along[:-1, 1] * along[1:, 0],
            (along[:-1] * along[1:]).sum(axis=1),
        )
        largest.append((lengths.max(), np.abs(turns).max()))
    (coarse_step, coarse_turn), (fine_step, fine_turn) = largest
    assert fine_step < 0.27 * coarse_step
    assert fine_turn < max(0.4 * coarse_turn, 1e-3)


def test_c_col_passes_through_the_origin() -> None:
    """For |r1 - r3| < r2 < r1 + r3 a linkage with P at the origin can be stretched."""
    for design in ((1.0, 1.1, 0.9), (0.9, 0.85, 1.25), (1.2, 1.0, 0.8)):
        through = [
            each.arc
            for each in singular_arcs(design, MODES)
            if isinstance(each.arc, CouplerArc) and each.arc.nearest(np.zeros((1, 2)))[0][0] < 1e-6
        ]
        assert len(through) == 2, design
        for arc in through:
            assert len(arc.pieces) > 1
            line = arc.points(np.linspace(0.0, 1.0, 4001))
            place = int(np.argmin(np.hypot(*line.T)))
            before, after = line[place] - line[place - 20], line[place + 20] - line[place]
            cosine = before @ after / np.hypot(*before) / np.hypot(*after)
            assert cosine > 0.999


def test_points_of_a_circle_are_those_of_its_angles() -> None:
    arc = CircleArc.of_angles((1.0, 2.0), 3.0, math.pi / 2.0, -math.pi)
    np.testing.assert_allclose(
        arc.points(np.array([0.0, 0.5, 1.0])), [[1.0, 5.0], [4.0, 2.0], [1.0, -1.0]], atol=1e-15
    )
    assert arc.direction(at_end=False) == pytest.approx((1.0, 0.0))
    assert arc.direction(at_end=True) == pytest.approx((-1.0, 0.0))
    assert CircleArc.whole((1.0, 2.0), 3.0).start == CircleArc.whole((1.0, 2.0), 3.0).end
    # the centre is as far from all of it
    assert arc.nearest(np.array([[1.0, 2.0]]))[0][0] == pytest.approx(3.0)


def named(arc: Arc, name: str = "side", ends: tuple[str, str] = (INTERSECTION,) * 2) -> NamedArc:
    """Return an arc with a name."""
    return NamedArc(name, f"${name}$", "kind", arc, ends)


def polygon(*corners: tuple[float, float]) -> Loop:
    """Return a closed polygon, one arc a side."""
    return closed_loop(
        [
            named(PolylineArc(np.array([one, two])), f"side {place}")
            for place, (one, two) in enumerate(
                zip(corners, (*corners[1:], corners[0]), strict=True)
            )
        ]
    )


def test_region_of_loops() -> None:
    square = polygon((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    hole = Loop((named(CircleArc.whole((2.0, 2.0), 1.0).reversed(), "hole", (CLOSED, CLOSED)),))
    region = region_of([hole, square])
    assert region.outline is square
    assert region.holes == (hole,)
    assert region.area == pytest.approx(16.0 - math.pi, rel=1e-15)
    assert [each.name for each in region.arcs] == ["side 0", "side 1", "side 2", "side 3", "hole"]
    large = region.scaled(10.0)
    assert large.area == pytest.approx(100.0 * region.area)
    assert [each.name for each in large.arcs] == [each.name for each in region.arcs]
    outline, inner = region.polygons(1e-4)
    assert outline.shape == (4, 2)
    shape = shapely.Polygon(outline, [inner])
    assert shape.is_valid
    assert shape.area == pytest.approx(region.area, abs=1e-3)
    points = np.random.default_rng(76).uniform(-1.0, 5.0, (200, 2))
    distances, nearest = region.boundary_distance(points)
    np.testing.assert_allclose(
        distances, shapely.distance(shape.boundary, shapely.points(points)), atol=1e-4
    )
    for point, distance, each in zip(points, distances, nearest, strict=True):
        assert each.arc.nearest(point[None])[0][0] == distance
    for loops in ([hole], [square, square]):
        with pytest.raises(InputError, match="loops"):
            region_of(loops)


def test_kinds_of_meeting() -> None:
    right = CircleArc.of_angles((0.0, 1.0), 1.0, -math.pi / 2.0, 1.0)  # from the origin to +x
    for after, kind in (
        (right, TANGENCY),
        (CircleArc.of_angles((0.0, -1.0), 1.0, math.pi / 2.0, -1.0), TANGENCY),
        (right.mirrored(True, False), CUSP),
        (CircleArc.of_angles((0.0, -2.0), 2.0, math.pi / 2.0, 1.0), CUSP),
        (PolylineArc(np.array([[0.0, 0.0], [1.0, 1.0]])), INTERSECTION),
        (PolylineArc(np.array([[0.0, 0.0], [0.0, -1.0]])), INTERSECTION),
    ):
        before = PolylineArc(np.array([[-1.0, 0.0], [0.0, 0.0]]))
        assert meeting(before, after) == kind
        assert meeting(after.reversed(), before.reversed()) == kind
    assert {each.ends for each in polygon((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)).arcs} == {
        (INTERSECTION, INTERSECTION)
    }


def test_a_loop_runs_through_its_arcs_once() -> None:
    half = CircleArc.of_angles((0.0, 0.0), 1.0, 0.0, math.pi)
    base = PolylineArc(np.array([half.end, half.start]))
    loop = closed_loop([named(half, "arc"), named(base, "chord")])
    assert loop.area == pytest.approx(0.5 * math.pi)
    line = loop.polyline(1e-3)
    assert len(np.unique(line, axis=0)) == len(line)
    assert shapely.Polygon(line).exterior.is_ccw
    assert shapely.Polygon(line).area == pytest.approx(0.5 * math.pi, abs=3e-3)
    region = Region(loop)
    assert region.loops == (loop,)
    assert region.area == loop.area
