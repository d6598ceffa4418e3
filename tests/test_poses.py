"""Poses for given outputs and inputs, and dimensioned machines."""

from __future__ import annotations

import cmath
import math

import naive
import numpy as np
import pytest
from designs import random_design, random_reachable_point
from special_designs import label

from fivebar_atlas import FiveBar, InputError, UnknownNameError, mechanisms
from fivebar_atlas.errors import OutOfReachError
from fivebar_atlas.mechanisms.planar import (
    ACTUATED,
    BASE,
    CRANK,
    DISTAL,
    OUTPUT,
    PASSIVE,
    PlanarDesign,
    Pose,
)

WORKING_MODES = [(1, -1), (-1, 1), (1, 1), (-1, -1)]
LENGTHS = (26.0, 30.0, 16.0)
D = 24.0


def machine(lengths: tuple[float, float, float] = LENGTHS, unit: str = "mm") -> PlanarDesign:
    """Return a dimensioned machine."""
    return mechanisms.get("five-bar").planar_design(lengths, unit)


def turn_between(one: float, two: float) -> float:
    """Return how far two directions are apart."""
    return abs(cmath.phase(cmath.exp(1j * (one - two))))


def assert_is_a_linkage(pose: Pose, r1: float, r2: float, r3: float, slack: float) -> None:
    """Assert that all joints are where links of these lengths and the inputs put them."""
    size = {BASE: 2.0 * r3, CRANK: r1, DISTAL: r2}
    for link in pose.links:
        start, end = pose.joints[link.start].position, pose.joints[link.end].position
        assert math.dist(start, end) == pytest.approx(size[link.kind], abs=slack)
    kinds = [joint.kind for joint in pose.joints]
    assert kinds == [ACTUATED, ACTUATED, PASSIVE, PASSIVE, OUTPUT]
    a1, a2, b1, b2, p = (joint.position for joint in pose.joints)
    assert (a1, a2) == ((-r3, 0.0), (r3, 0.0))
    for a, b, angle in ((a1, b1, pose.inputs[0]), (a2, b2, pose.inputs[1])):
        assert -math.pi <= angle <= math.pi
        assert math.dist(b, (a[0] + r1 * math.cos(angle), a[1] + r1 * math.sin(angle))) < slack
    assert pose.output == p


def sample(seed: int, count: int) -> list[tuple[FiveBar, tuple[float, float]]]:
    """Return random designs, each with a point that both legs reach."""
    rng = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        design = random_design(rng)
        if min(design) > 0.02:
            found.append((FiveBar(*design), random_reachable_point(rng, *design)))
    return found


@pytest.mark.nojit
def test_four_poses_for_a_point() -> None:
    for robot, (x, y) in sample(90, 200):
        lengths = (robot.r1, robot.r2, robot.r3)
        poses = robot.inverse_poses(x, y)
        assert len(poses) == 4
        elbows = set()
        for pose, (s1, s2) in zip(poses, WORKING_MODES, strict=True):
            assert_is_a_linkage(pose, *lengths, slack=1e-13)
            assert pose.output == (x, y)
            sign = 1 if naive.det_b(*lengths, x, y, s1, s2) > 0.0 else -1
            assert pose.mode == label(s1, s2, sign)
            for found, expected in zip(
                pose.inputs, naive.inverse_kinematics(*lengths, x, y, s1, s2), strict=True
            ):
                assert turn_between(found, float(expected)) < 1e-6
            assert pose.lci == pytest.approx(float(naive.lci(*lengths, x, y, s1, s2)), abs=1e-7)
            assert robot.pose(x, y, pose.mode) == robot.pose(x, y, pose.mode[:2]) == pose
            elbows.add(tuple(np.round([joint.position for joint in pose.joints[2:4]], 6).ravel()))
        assert len(elbows) == 4


@pytest.mark.nojit
def test_forward_undoes_inverse() -> None:
    for robot, (x, y) in sample(91, 200):
        for pose in robot.inverse_poses(x, y):
            up, down = robot.forward_poses(pose.inputs)
            assert up.mode.endswith("/up")
            assert down.mode.endswith("/down")
            same, other = (up, down) if pose.mode.endswith("/up") else (down, up)
            span = math.dist(pose.joints[2].position, pose.joints[3].position)
            height = math.sqrt(max(robot.r2**2 - 0.25 * span**2, 0.0))
            # where P is near the line B1 B2 or B1 near B2, it is sensitive to the inputs
            slack = 1e-13 * (1.0 + 1.0 / max(height, 1e-12)) * (1.0 + 1.0 / max(span, 1e-12))
            assert math.dist(same.output, (x, y)) < slack
            assert math.dist(other.output, (x, y)) == pytest.approx(2.0 * height, abs=2.0 * slack)
            for found in (up, down):
                assert_is_a_linkage(found, robot.r1, robot.r2, robot.r3, slack=1e-12)
                assert found.inputs == pytest.approx(pose.inputs, abs=1e-15)


@pytest.mark.nojit
def test_inverse_undoes_forward() -> None:
    rng = np.random.default_rng(92)
    assembled = 0
    for robot, _ in sample(93, 200):
        lengths = (robot.r1, robot.r2, robot.r3)
        theta = tuple(float(angle) for angle in rng.uniform(-9.0, 9.0, 2))
        b1, b2 = naive.elbows_of_angles(robot.r1, robot.r3, *theta)
        gap = float(np.hypot(*(b2 - b1))) - 2.0 * robot.r2
        if gap > 0.0:
            with pytest.raises(OutOfReachError) as caught:
                robot.forward_poses(theta)
            assert caught.value.gap == pytest.approx(gap)
            continue
        assembled += 1
        for pose, sign in zip(robot.forward_poses(theta), (1, -1), strict=True):
            assert_is_a_linkage(pose, *lengths, slack=1e-12)
            x, y = naive.forward_kinematics(*lengths, *theta, sign)
            assert pose.output == pytest.approx((float(x), float(y)), abs=1e-9)
            assert all(
                turn_between(found, given) < 1e-14
                for found, given in zip(pose.inputs, theta, strict=True)
            )
            again = robot.pose(*pose.output, pose.mode[:2])
            near_serial = robot.singularity(*pose.output, pose.mode, tolerance=1e-3)
            if not near_serial:
                assert again.mode == pose.mode
                assert again.inputs == pytest.approx(pose.inputs, abs=1e-9)
    assert 50 < assembled < 190


@pytest.mark.nojit
def test_points_out_of_reach_say_by_how_much() -> None:
    robot = FiveBar(1.2, 1.0, 0.8)
    for (x, y), gap, phrase in (
        ((-1.6, 0.0), 0.2, "farther than the stretched leg 2"),
        ((1.6, 0.0), 0.2, "farther than the stretched leg 1"),
        ((-0.8, 0.15), 0.05, "nearer to A_1 than the folded leg 1"),
        ((0.8, -0.15), 0.05, "nearer to A_2 than the folded leg 2"),
        ((0.0, 3.0), math.hypot(0.8, 3.0) - 2.2, "farther than"),
    ):
        for call in (robot.inverse_poses, lambda x, y: robot.pose(x, y, "+-/up")):
            with pytest.raises(OutOfReachError, match=phrase) as caught:
                call(x, y)
            assert caught.value.gap == pytest.approx(gap)
            assert f"it is {gap:.6g} " in str(caught.value)
            assert caught.value.exit_code == 2


@pytest.mark.nojit
def test_points_on_the_boundary_are_reached() -> None:
    robot = FiveBar(1.2, 1.0, 0.8)
    for angle in np.linspace(-0.9, 0.9, 19):
        for radius in (2.2, 0.2):
            for base, turn in ((-0.8, 0.0), (0.8, math.pi)):
                x = base + radius * math.cos(angle + turn)
                y = radius * math.sin(angle + turn)
                if math.hypot(x + base, y) > 2.2:
                    continue
                for pose in robot.inverse_poses(x, y):
                    assert_is_a_linkage(pose, 1.2, 1.0, 0.8, slack=1e-7)
                    assert pose.lci < 1e-5


@pytest.mark.nojit
def test_inputs_for_which_the_output_is_free_or_missing() -> None:
    robot = FiveBar(1.0, 1.0, 1.0)
    with pytest.raises(OutOfReachError, match="B_1 and B_2 differ"):
        robot.forward_poses((0.0, math.pi))
    # stretched: both assembly modes are one
    up, down = robot.forward_poses((math.pi / 2.0, math.pi / 2.0))
    assert up.output == pytest.approx(down.output, abs=1e-7)
    for bad in ((1.0,), (1.0, 2.0, 3.0), (1.0, math.nan), (math.inf, 0.0)):
        with pytest.raises(InputError, match="inputs"):
            robot.forward_poses(bad)


def test_the_other_assembly_mode_is_refused() -> None:
    robot = FiveBar(1.2, 1.0, 0.8)
    pose = robot.pose(0.0, 1.5, "+-")
    assert pose.mode == "+-/up"
    with pytest.raises(InputError, match=r"\+-/down; it is \+-/up"):
        robot.pose(0.0, 1.5, "+-/down")
    with pytest.raises(UnknownNameError, match="mode"):
        robot.pose(0.0, 1.5, "up")


def test_a_machine_has_its_lengths() -> None:
    robot = machine()
    plain = FiveBar.from_lengths(*LENGTHS)
    assert robot.mechanism == "five-bar"
    assert (robot.unit, robot.factor) == ("mm", D)
    assert robot.parameters == (
        ("$R_1$", pytest.approx(26.0)), ("$R_2$", pytest.approx(30.0)),
        ("$R_3$", pytest.approx(16.0)),
    )  # fmt: skip
    assert (plain.unit, plain.factor, plain.mechanism) == ("", 1.0, "five-bar")
    assert plain.parameters == (
        ("$r_1$", plain.r1), ("$r_2$", plain.r2), ("$r_3$", plain.r3),
    )  # fmt: skip
    assert robot.remarks() == plain.remarks()
    # lengths in millimetres unless told; none that add up to 3
    assert mechanisms.get("five-bar").planar_design(LENGTHS).unit == "mm"
    assert mechanisms.get("five-bar").planar_design((1.2, 1.0, 0.8)).unit == ""
    assert machine((0.026, 0.030, 0.016), "m").factor == pytest.approx(0.024)


def test_everything_of_a_machine_scales() -> None:
    robot, plain = machine(), FiveBar.from_lengths(*LENGTHS)
    shares = np.linspace(0.0, 1.0, 7)
    loci, plain_loci = robot.singular_loci("+-"), plain.singular_loci("+-")
    for large, small in zip(loci, plain_loci, strict=True):
        assert (large.name, large.sides, large.ends) == (small.name, small.sides, small.ends)
        np.testing.assert_allclose(large.arc.points(shares), D * small.arc.points(shares))
    found, expected = robot.usable_workspace("+-/up"), plain.usable_workspace("+-/up")
    assert found is not None
    assert expected is not None
    assert found.area == pytest.approx(D**2 * expected.area)
    assert found.region.area == pytest.approx(D**2 * expected.area)
    for large, small in zip(
        robot.good_condition_workspace(0.5, "+-/up"),
        plain.good_condition_workspace(0.5, "+-/up"),
        strict=True,
    ):
        assert large.area == pytest.approx(D**2 * small.area)
    for circle, small_circle in zip(
        robot.inscribed_circles("+-/up"), plain.inscribed_circles("+-/up"), strict=True
    ):
        assert circle.radius == pytest.approx(D * small_circle.radius)
        assert circle.centre == pytest.approx((0.0, D * small_circle.centre[1]))
    largest, plain_largest = robot.largest_lci("+-/up"), plain.largest_lci("+-/up")
    assert largest is not None
    assert plain_largest is not None
    assert largest[0] == plain_largest[0]
    assert largest[1] == pytest.approx((D * plain_largest[1][0], D * plain_largest[1][1]))
    x, y = np.linspace(-20.0, 20.0, 9), np.full(9, 30.0)
    np.testing.assert_allclose(robot.lci(x, y, "+-"), naive.lci(*LENGTHS, x, y, 1, -1), atol=1e-12)
    np.testing.assert_allclose(robot.lci_inside(x, y, "+-/up"), plain.lci_inside(x / D, y / D))


def test_isolated_points_and_empty_workspaces_of_machines() -> None:
    assert machine((20.0, 20.0, 8.0)).isolated_singular_points() == ((-8.0, 0.0), (8.0, 0.0))
    assert machine().isolated_singular_points() == ()
    assert machine((12.8, 17.2, 0.0)).usable_workspace("++/up") is None


def test_poses_of_a_machine() -> None:
    robot = machine()
    for pose in (*robot.inverse_poses(3.0, 40.0), robot.pose(3.0, 40.0, "+-/up")):
        assert_is_a_linkage(pose, *LENGTHS, slack=1e-12)
        assert pose.output == pytest.approx((3.0, 40.0))
        assert {link.symbol for link in pose.links} == {"$R_1$", "$R_2$", "$R_3$"}
        assert [joint.symbol for joint in pose.joints] == [
            "$A_1$",
            "$A_2$",
            "$B_1$",
            "$B_2$",
            "$P$",
        ]
        for again in robot.forward_poses(pose.inputs):
            assert_is_a_linkage(again, *LENGTHS, slack=1e-12)
    assert {link.symbol for link in FiveBar(1.2, 1.0, 0.8).pose(0.0, 1.5).links} == {
        "$r_1$", "$r_2$", "$r_3$",
    }  # fmt: skip


def test_messages_of_a_machine_are_in_its_unit() -> None:
    robot = machine()
    with pytest.raises(
        OutOfReachError, match=r"\(50\.0, 0\.0\).* 10 mm farther .* leg 1"
    ) as caught:
        robot.pose(50.0, 0.0, "+-")
    assert caught.value.gap == pytest.approx(10.0)
    with pytest.raises(OutOfReachError, match=r"\(-16\.0, 1\.0\).* 3 mm nearer to A_1"):
        robot.inverse_poses(-16.0, 1.0)
    # B1 = (-42, 0) and B2 = (42, 0): 84 apart, of 60
    with pytest.raises(OutOfReachError, match=r"\(3\.14159\d*, 0\.0\).* 24 mm too far apart"):
        robot.forward_poses((math.pi, 0.0))
    with pytest.raises(OutOfReachError, match=r"0\.01 m farther"):
        machine((0.026, 0.030, 0.016), "m").pose(0.05, 0.0, "+-")


def test_outputs_that_are_not_numbers_are_refused() -> None:
    for robot in (machine(), FiveBar(1.2, 1.0, 0.8)):
        with pytest.raises(OutOfReachError):
            robot.pose(math.inf, 0.0, "+-")


def test_points_without_coordinates_are_refused() -> None:
    with pytest.raises(InputError):
        FiveBar(1.2, 1.0, 0.8).pose(math.nan, 0.0, "+-")


def test_the_other_assembly_mode_of_a_machine_is_refused_in_its_unit() -> None:
    with pytest.raises(InputError, match=r"\(0\.0, 36\.0\)"):
        machine().pose(0.0, 36.0, "+-/down")


def test_a_leg_folded_onto_its_base_joint_has_its_lengths_or_is_refused() -> None:
    robot = FiveBar(1.2, 1.2, 0.6)
    try:
        pose = robot.pose(-0.6, 0.0, "+-")
    except InputError:
        return
    assert_is_a_linkage(pose, 1.2, 1.2, 0.6, slack=1e-12)


def test_inputs_are_above_minus_pi() -> None:
    for angle in (-math.pi, 3.0 * math.pi):
        for pose in FiveBar(1.0, 1.5, 0.5).forward_poses((angle, 2.0)):
            assert pose.inputs[0] == math.pi
