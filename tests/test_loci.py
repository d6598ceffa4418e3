"""Singular loci as arcs, against conditions that are checked from scratch.

On which side of an arc which mode pair lies is read off the sign of det B of
:mod:`naive` on both sides, and completeness off a dense scan for changes of that sign.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import naive
import numpy as np
import numpy.typing as npt
import pytest
from designs import MODES, random_design
from special_designs import label, special_designs

from fivebar_atlas import FiveBar, UnknownNameError
from fivebar_atlas.mechanisms.five_bar.loci import isolated_points, singular_arcs
from fivebar_atlas.planar_geometry import (
    BOTH,
    CLOSED,
    INTERSECTION,
    LEFT,
    RIGHT,
    TANGENCY,
    Arc,
    NamedArc,
)

Design = tuple[float, float, float]
FloatArray = npt.NDArray[np.float64]

WORKING_MODES = [(1, -1), (-1, 1), (1, 1), (-1, -1)]
SERIAL_NAMES = {"C_1o", "C_1i", "C_2o", "C_2i"}
FOLD_NAMES = {"C_coin_up", "C_coin_down"}
KINDS = {
    **dict.fromkeys(SERIAL_NAMES, "serial"),
    **dict.fromkeys(FOLD_NAMES, "parallel, folded"),
    "C_col": "parallel, extended",
}


#: Half of C_col lies on C_1i and C_2i: det B vanishes all along, and signs say nothing.
TRIPLE = (1.5, 0.75, 0.75)
#: Arcs shorter than this are the rounding of points where square roots vanish.
ROUNDING = 1e-6

RANDOM = [random_design(rng) for rng in [np.random.default_rng(51)] for _ in range(1000)]
SPECIAL = special_designs()


def normals(arc: Arc, shares: FloatArray) -> FloatArray:
    """Return unit vectors to the left of an arc, shape (n, 2), by differences."""
    along = arc.points(shares + 1e-5) - arc.points(shares - 1e-5)
    along /= np.hypot(*along.T)[:, None]
    return np.column_stack([-along[:, 1], along[:, 0]])


def length_of(arc: Arc) -> float:
    """Return the length of an arc, roughly."""
    return float(np.hypot(*np.diff(arc.points(np.linspace(0.0, 1.0, 33)), axis=0).T).sum())


def singular_error(design: Design, each: NamedArc, points: FloatArray) -> FloatArray:
    """Return by how much points of an arc miss its condition, in units of length."""
    r1, r2, r3 = design
    x, y = points.T
    if each.name in SERIAL_NAMES:
        base = -r3 if each.name[2] == "1" else r3
        radius = r1 + r2 if each.name[3] == "o" else abs(r1 - r2)
        return np.abs(np.hypot(x - base, y) - radius)
    if each.name in FOLD_NAMES:
        height = math.sqrt(r1**2 - r3**2) * (1.0 if each.name == "C_coin_up" else -1.0)
        return np.abs(np.hypot(x, y - height) - r2)
    assert each.name == "C_col"
    return naive.coupler_error(r1, r2, r3, x, y)


@pytest.mark.parametrize("designs", [RANDOM, SPECIAL], ids=["random", "special"])
def test_every_point_is_singular(designs: list[Design]) -> None:
    shares = np.array([0.0, 0.003, 0.21, 0.5, 0.83, 1.0])
    for design in designs:
        for each in singular_arcs(design, MODES):
            points = np.vstack([each.arc.points(shares), [each.arc.start, each.arc.end]])
            assert singular_error(design, each, points).max() < 1e-13, (design, each.name)


def clearances(design: Design, points: FloatArray) -> FloatArray:
    """Return how far points are from the nearest reach circle."""
    r1, r2, r3 = design
    reaches = np.array([np.hypot(points[:, 0] - base, points[:, 1]) for base in (-r3, r3)])
    gaps: FloatArray = np.abs(reaches[:, None] - np.array([[r1 + r2], [abs(r1 - r2)]]))
    return gaps.min(axis=(0, 1))


def sides_by_sign(
    design: Design, arcs: Sequence[NamedArc], shares: FloatArray
) -> Iterator[tuple[NamedArc, dict[str, str], float]]:
    """Yield for every arc and share the sides of the mode pairs as the sign of det B has them.

    With each comes the least det B, over r2², that a side of it, or its being regular for a
    working mode, was concluded from.
    """
    feet = np.array([each.arc.points(shares) for each in arcs]).reshape(-1, 2)
    # at a reach circle the elbows turn like the square root of the distance from it
    offsets = np.repeat([1e-7 * length_of(each.arc) for each in arcs], len(shares))
    offsets = np.minimum(offsets, 1e-2 * clearances(design, feet))
    offsets[np.repeat([each.kind == "serial" for each in arcs], len(shares))] = 1e-12
    left = np.array([normals(each.arc, shares) for each in arcs]).reshape(-1, 2)
    left *= offsets[:, None]
    # without a base B1 = B2 throughout in ++ and --
    modes = WORKING_MODES if design[2] > 0.0 else WORKING_MODES[:2]
    sines = np.array(
        [
            [naive.det_b(*design, *points.T, s1, s2) for points in (feet + left, feet - left, feet)]
            for s1, s2 in modes
        ]
    )
    sines /= design[1] ** 2
    for place, each in enumerate(arcs):
        for number in range(len(shares)):
            found = {}
            least = math.inf
            for (s1, s2), of_mode in zip(modes, sines, strict=True):
                on_left, on_right, on_arc = of_mode[:, place * len(shares) + number]
                if each.kind == "serial":
                    outer = each.name in {"C_1o", "C_2o"}
                    inside, outside = (on_left, on_right) if outer else (on_right, on_left)
                    assert math.isnan(outside), (design, each.name)
                    found[label(s1, s2, 1 if inside > 0.0 else -1)] = LEFT if outer else RIGHT
                    least = min(least, abs(inside))
                elif on_left * on_right < 0.0:
                    up_left = on_left > 0.0
                    found[label(s1, s2, 1)] = LEFT if up_left else RIGHT
                    found[label(s1, s2, -1)] = RIGHT if up_left else LEFT
                elif on_left * on_right > 0.0 and abs(on_arc) < 1e-12:
                    found[label(s1, s2, 1 if on_left > 0.0 else -1)] = BOTH
                else:
                    assert on_left * on_right > 0.0, (design, each.name)
                    least = min(least, abs(on_arc))
            yield each, found, least


@pytest.mark.parametrize("designs", [RANDOM, SPECIAL], ids=["random", "special"])
def test_sides_are_those_of_the_sign_of_det_b(designs: list[Design]) -> None:
    # none is in the middle, where arcs of designs with a symmetry may cross
    shares = np.array([0.04, 0.24, 0.52, 0.77])
    least, checked = math.inf, 0
    for design in designs:
        arcs = [each for each in singular_arcs(design, MODES) if length_of(each.arc) > ROUNDING]
        if design == TRIPLE:
            continue
        for each, found, clear in sides_by_sign(design, arcs, shares):
            sides = dict(each.sides)
            if design[2] == 0.0 or design == (1.0, 1.0, 1.0):  # two arcs, of other modes each
                found = {mode: side for mode, side in found.items() if mode in sides}
            assert sides, (design, each.name)
            assert sides == found, (design, each.name)
            checked += 1
            least = min(least, clear)
    assert checked > 60 * len(designs)
    assert least > 1e-8  # else the signs would say nothing


def test_parallel_arcs_end_where_serial_arcs_end() -> None:
    checked = 0
    for design in RANDOM:
        arcs = singular_arcs(design, MODES)
        serial_ends = {
            end for each in arcs for end in (each.arc.start, each.arc.end) if each.kind == "serial"
        }
        for each in arcs:
            ends = {each.arc.start, each.arc.end}
            if each.ends == (CLOSED, CLOSED):
                assert len(ends) == 1
            elif each.kind != "serial":
                assert ends <= serial_ends, (design, each.name)
                checked += 1
    assert checked > 5000


def test_parallel_arcs_of_special_designs_end_on_serial_arcs() -> None:
    for design in SPECIAL:
        arcs = singular_arcs(design, MODES)
        serial = [each.arc for each in arcs if each.kind == "serial"]
        joints = isolated_points(design)
        for each in arcs:
            if each.kind == "serial" or each.ends == (CLOSED, CLOSED):
                continue
            ends = np.array([each.arc.start, each.arc.end])
            gaps = [arc.nearest(ends)[0] for arc in serial]
            gaps += [np.hypot(*(ends - np.array(joint)).T) for joint in joints]
            assert np.min(gaps, axis=0).max() < 1e-12, (design, each.name)


def test_parallel_arcs_touch_a_reach_circle_at_their_ends() -> None:
    touching = 0
    for design in RANDOM[:300]:
        r1, r2, r3 = design
        for each in singular_arcs(design, MODES):
            if each.kind == "serial" or each.ends == (CLOSED, CLOSED):
                continue
            assert each.ends == (TANGENCY, TANGENCY)
            for x, y in (each.arc.start, each.arc.end):
                gaps = {
                    name: abs(math.hypot(x - base, y) - radius)
                    for leg, base in (("1", -r3), ("2", r3))
                    for name, radius in ((f"C_{leg}o", r1 + r2), (f"C_{leg}i", abs(r1 - r2)))
                }
                circle = min(gaps, key=gaps.__getitem__)
                assert gaps[circle] < 1e-14
                along = naive.locus_tangent(*design, each.name, x, y)
                beside = naive.locus_tangent(*design, circle, x, y)
                assert abs(along[0] * beside[1] - along[1] * beside[0]) < 1e-6, (design, each)
                touching += 1
    assert touching > 1000


def test_serial_arcs_end_where_both_legs_are_straight_or_a_parallel_arc_touches() -> None:
    counts = {INTERSECTION: 0, TANGENCY: 0}
    for design in RANDOM[:300]:
        r1, r2, r3 = design
        for each in singular_arcs(design, MODES):
            if each.kind != "serial" or each.ends == (CLOSED, CLOSED):
                continue
            for (x, y), kind in zip((each.arc.start, each.arc.end), each.ends, strict=True):
                straight = [
                    any(abs(math.hypot(x - base, y) - reach) < 1e-12 for reach in reaches)
                    for base in (-r3, r3)
                    for reaches in ((r1 + r2, abs(r1 - r2)),)
                ]
                assert any(straight), (design, each.name)
                assert kind == (INTERSECTION if all(straight) else TANGENCY), (design, each.name)
                counts[kind] += 1
    assert min(counts.values()) > 1000


def test_ends_are_points_of_the_arcs() -> None:
    shares = np.array([0.0, 1.0])
    for design in RANDOM:
        for each in singular_arcs(design, MODES):
            gaps = each.arc.points(shares) - np.array([each.arc.start, each.arc.end])
            assert np.abs(gaps).max() < 1e-13, (design, each.name)


def test_every_parallel_singular_point_lies_on_an_arc_of_its_mode() -> None:
    found = 0
    for design in RANDOM[:15] + SPECIAL:
        arcs = [each for each in singular_arcs(design, MODES) if each.kind != "serial"]
        for s1, s2 in WORKING_MODES if design[2] > 0.0 else WORKING_MODES[:2]:
            points = np.column_stack(naive.parallel_singular_points(*design, s1, s2, 70))[::3]
            if len(points) == 0:
                continue
            gaps = [
                each.arc.nearest(points)[0]
                for each in arcs
                if {label(s1, s2, 1), label(s1, s2, -1)} & set(each.sides)
            ]
            assert np.min(gaps, axis=0).max() < 1e-8, (design, s1, s2)
            found += len(points)
    assert found > 10_000


def test_the_boundary_of_the_theoretical_workspace_is_serial_arcs_of_every_working_mode() -> None:
    checked = 0
    for design in RANDOM[:100] + SPECIAL:
        r1, r2, r3 = design
        points = np.column_stack(naive.theoretical_boundary(*design, 360))
        at_joint = np.minimum(*(np.hypot(points[:, 0] - b, points[:, 1]) for b in (-r3, r3))) < 1e-9
        if np.any(at_joint):
            assert r1 == r2
            assert isolated_points(design) or r1 + r2 == 2.0 * r3  # outer circles pass there
        points = points[~at_joint]
        if len(points) == 0:
            continue
        checked += len(points)
        arcs = [each for each in singular_arcs(design, MODES) if each.kind == "serial"]
        for mode in ("+-", "-+", "++", "--") if r3 > 0.0 else ("+-", "-+"):
            gaps = [
                each.arc.nearest(points)[0]
                for each in arcs
                if any(pair.startswith(mode) for pair in each.sides)
            ]
            assert np.min(gaps, axis=0).max() < 1e-12, (design, mode)
        # and no serial arc lies beyond the reach of the other leg
        middles = np.array([each.arc.points(np.array([0.5]))[0] for each in arcs])
        reaches = np.array([np.hypot(middles[:, 0] - b, middles[:, 1]) for b in (-r3, r3)])
        assert reaches.max() < r1 + r2 + 1e-12
        assert reaches.min() > abs(r1 - r2) - 1e-12
    assert checked > 50_000


def test_base_joints_are_isolated_singular_points_where_both_links_are_equal() -> None:
    for design in RANDOM + SPECIAL:
        points = isolated_points(design)
        if abs(design[0] - design[1]) > 1e-9:
            assert points == ()
    assert set(isolated_points((1.25, 1.25, 0.5))) == {(-0.5, 0.0), (0.5, 0.0)}
    assert isolated_points((1.5, 1.5, 0.0)) == ((0.0, 0.0),)
    # 2 r3 > r1 + r2: the other leg does not reach that far; or just so, on its outer circle
    assert isolated_points((0.8, 0.8, 1.4)) == ()
    assert isolated_points((1.0, 1.0, 1.0)) == ()


def test_a_design_that_reaches_one_point_has_no_arcs() -> None:
    for r1 in (0.25, 0.75, 1.0):
        assert singular_arcs((r1, 1.5 - r1, 1.5), MODES) == ()


def test_arcs_of_some_modes_are_those_of_all_modes() -> None:
    """Asking for fewer modes leaves the same points and the same sides, joined otherwise."""
    shares = np.array([0.04, 0.52, 0.9])
    for design in RANDOM[:15]:
        every = singular_arcs(design, MODES)
        for s1, s2, assembly in MODES:
            pair = label(s1, s2, assembly)
            alone = singular_arcs(design, [(s1, s2, assembly)])
            for some, others in ((alone, every), (every, alone)):
                for each in some:
                    if pair not in each.sides:
                        assert some is every
                        continue
                    if some is alone:
                        assert set(each.sides) == {pair}
                    gaps = [
                        other.arc.nearest(each.arc.points(shares))[0]
                        for other in others
                        if other.name == each.name and other.sides.get(pair) == each.sides[pair]
                    ]
                    assert np.min(gaps, axis=0).max() < 1e-11, (design, pair, each.name)


def test_loci_of_a_manipulator_are_named_by_modes() -> None:
    robot = FiveBar(1.2, 1.0, 0.8)
    assert {each.name for each in robot.singular_loci()} == set(KINDS)
    for each in robot.singular_loci("pm"):
        assert set(each.sides) <= {"+-/up", "+-/down"}
    for each in robot.singular_loci("+-/up"):
        assert set(each.sides) == {"+-/up"}
        assert each.symbol.startswith("$C_{")
        assert each.kind == KINDS[each.name]
    with pytest.raises(UnknownNameError, match="mode"):
        robot.singular_loci("+?")
    with pytest.raises(UnknownNameError, match="mode"):
        robot.singular_loci("+-/left")


def test_curves_that_a_design_has_not() -> None:
    names = {each.name for each in singular_arcs((0.9, 1.2, 0.9 + 1e-3), MODES)}
    assert not names & FOLD_NAMES  # r1 < r3: B1 and B2 cannot meet
    names = {each.name for each in singular_arcs((1.2, 1.8, 0.0), MODES)}
    assert names == SERIAL_NAMES  # r2 > r1 without a base: no parallel singularity
    arcs = singular_arcs((1.8, 1.2, 0.0), MODES)
    extended = [each for each in arcs if each.name == "C_col"]
    assert {pair for each in extended for pair in each.sides} == {
        "+-/up", "+-/down", "-+/up", "-+/down",
    }  # fmt: skip
    for each in extended:  # ρ² = r1² - r2²
        radii = np.hypot(*each.arc.points(np.linspace(0.0, 1.0, 50)).T)
        np.testing.assert_allclose(radii, math.sqrt(1.8), rtol=1e-15)


def test_sides_where_half_of_c_col_lies_on_reach_circles() -> None:
    """R = 2 : 1 : 1. Of C_col the circle of radius r1 is left, one half for +- and one for -+."""
    halves = [each for each in singular_arcs(TRIPLE, MODES) if each.name == "C_col"]
    assert len(halves) == 2
    shares = np.array([0.24, 0.52, 0.77])
    for each, found, _ in sides_by_sign(TRIPLE, halves, shares):
        assert dict(each.sides) == found
        np.testing.assert_allclose(np.hypot(*each.arc.points(shares).T), 1.5, rtol=1e-15)
        assert each.arc.length() == pytest.approx(1.5 * math.pi)


def test_c_col_goes_on_through_the_origin() -> None:
    """Where r3² = r1² + r2² or r2² = r1² + r3², rounded angles leave C_col apart at the origin."""
    for design in (
        (1.0, 0.75, 1.25),
        (0.75, 1.25, 1.0),
        (1.1911145038199178, 1.2966396379669818, 0.5122458582131004),
    ):
        for each in singular_arcs(design, MODES):
            if each.name == "C_col" and each.ends != (CLOSED, CLOSED):
                for end in (each.arc.start, each.arc.end):
                    assert math.hypot(*end) > 1e-3, design
