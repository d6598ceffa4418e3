"""Bounds on discs, and the proof that a whole shape lies in a good-condition workspace."""

from __future__ import annotations

import naive
import numpy as np
from designs import random_cases, random_reachable_point

from fivebar_atlas import FiveBar, planar_design
from fivebar_atlas.synthesis.containment import (
    INSIDE,
    OUTSIDE,
    UNDECIDED,
    ActuatorRange,
    GoodCondition,
    prove,
)
from fivebar_atlas.synthesis.shapes import Shape

# Its LCI is at least 0.5 between two circles around the origin.
RING = GoodCondition(FiveBar(1.28, 1.72, 0.0), "+-/up", 0.5)
INNER, OUTER = (
    2.0 * 1.72 / np.sqrt(5.0) + side * np.sqrt(1.28**2 - 1.72**2 / 5.0) for side in (-1.0, 1.0)
)


def test_no_point_of_a_disc_is_worse_than_its_bound() -> None:
    rng = np.random.default_rng(20)
    angles = 2.0 * np.pi * np.arange(48) / 48
    certain = 0
    for lengths, (s1, s2, _) in random_cases(21, 400):
        robot, mode = FiveBar(*lengths), "".join("+" if s > 0 else "-" for s in (s1, s2))
        x, y = random_reachable_point(rng, *lengths)
        radius = 10.0 ** rng.uniform(-4.0, -0.5)
        least, turns = robot.bounds_on_discs(x, y, radius, mode)
        if least[0] == 0.0:
            assert np.all(np.isinf(turns) | (turns >= 0.0))
            continue
        certain += 1
        for share in (1.0, 0.7, 0.3):
            xs = x + share * radius * np.cos(angles)
            ys = y + share * radius * np.sin(angles)
            values = naive.lci(*lengths, xs, ys, s1, s2)
            assert np.all(values >= least[0] - 1e-12)
            inputs = naive.inverse_kinematics(*lengths, xs, ys, s1, s2)
            centre = naive.inverse_kinematics(*lengths, x, y, s1, s2)
            for number in range(2):
                moved = np.remainder(inputs[number] - centre[number] + np.pi, 2 * np.pi) - np.pi
                assert np.all(np.abs(moved) <= turns[0, number] + 1e-12)
            signs = np.sign(naive.det_b(*lengths, xs, ys, s1, s2))
            assert np.all(signs == np.sign(naive.det_b(*lengths, x, y, s1, s2)))
    assert certain > 150


def test_bounds_close_in_on_the_values_of_small_discs() -> None:
    robot = FiveBar(1.2, 1.3, 0.5)
    for radius in (1e-3, 1e-5, 1e-7):
        least, turns = robot.bounds_on_discs(0.2, 1.6, radius, "+-")
        value = float(robot.lci(0.2, 1.6, "+-"))
        assert value - 20.0 * radius < least[0] <= value
        assert np.all(turns < 5.0 * radius)


def test_nothing_is_said_of_discs_that_meet_a_singularity() -> None:
    robot = FiveBar(1.2, 1.3, 0.5)
    for x, y, radius in ((0.0, 2.4, 0.1), (0.0, 3.0, 0.1), (0.0, 0.0, 0.5)):
        least, turns = robot.bounds_on_discs(x, y, radius, "+-")
        assert least[0] == 0.0
        assert np.all(np.isinf(turns))


def test_a_machine_has_the_values_of_its_design_in_its_own_lengths() -> None:
    machine, robot = planar_design(36.0, 39.0, 15.0), FiveBar(1.2, 1.3, 0.5)
    x, y = np.array([6.0, 12.0]), np.array([48.0, 45.0])
    assert np.array_equal(machine.inputs(x, y, "+-"), robot.inputs(x / 30, y / 30, "+-"))
    least, turns = machine.bounds_on_discs(x, y, np.full(2, 0.3), "+-")
    expected = robot.bounds_on_discs(x / 30, y / 30, 0.01, "+-")
    assert np.allclose(least, expected[0], rtol=1e-12)
    assert np.allclose(turns, expected[1], rtol=1e-12)
    step = 1e-6
    rates = (machine.inputs(x + step, y, "+-") - machine.inputs(x - step, y, "+-")) / (2 * step)
    assert np.allclose(machine.jacobian(x, y, "+-")[:, :, 0], rates, rtol=1e-6)


def test_a_circle_is_proved_to_fit_into_a_ring_and_not_when_larger() -> None:
    width = OUTER - INNER
    centre = (0.0, 0.5 * (INNER + OUTER))
    for excess, verdict in ((-1e-8, INSIDE), (-1e-3, INSIDE), (1e-8, OUTSIDE), (1e-3, OUTSIDE)):
        shape = Shape.circle(width)
        proof = prove(RING, shape, centre, 1.0 + excess)
        assert proof.verdict == verdict
        assert (proof.witness is None) == (verdict == INSIDE)
        if proof.witness is not None:
            assert np.hypot(*proof.witness) <= 0.5 * width * (1.0 + 1e-12)
            point = np.array(centre) + (1.0 + excess) * proof.witness
            assert not INNER <= np.hypot(*point) <= OUTER
    # where it touches neither can be shown
    assert prove(RING, Shape.circle(width), centre, 1.0).verdict in (UNDECIDED, OUTSIDE)


def test_a_hole_within_a_shape_is_found() -> None:
    shape = Shape.circle(3.0)
    assert np.all(RING.margins(shape.boundary(shape.boundary_samples(1000))) > 0.0)
    proof = prove(RING, shape, (0.0, 0.0), 1.0)
    assert proof.verdict == OUTSIDE
    assert proof.witness is not None
    assert np.hypot(*proof.witness) < INNER


def test_the_other_side_of_a_singular_locus_is_not_inside() -> None:
    # the same points are as good in the other assembly mode, which is another workspace
    robot = FiveBar(1.2, 1.3, 0.5)
    shape = Shape.circle(0.1)
    y = robot.largest_lci("+-/up")[1][1]  # type: ignore[index]
    assert prove(GoodCondition(robot, "+-/up", 0.5), shape, (0.0, y), 1.0).verdict == INSIDE
    proof = prove(GoodCondition(robot, "+-/down", 0.5), shape, (0.0, y), 1.0)
    assert proof.verdict == OUTSIDE


def test_actuator_ranges_hold_throughout_a_shape() -> None:
    robot, shape = FiveBar(1.2, 1.3, 0.5), Shape.rectangle(0.3, 0.2)
    points = np.array([0.2, 1.5]) + shape.boundary(shape.boundary_samples(4000))
    theta = naive.inverse_kinematics(1.2, 1.3, 0.5, *points.T, 1, -1)[0]
    least, greatest = float(theta.min()), float(theta.max())
    for room, verdict in ((1e-6, INSIDE), (-1e-6, OUTSIDE)):
        ranges = (ActuatorRange(1, least - room, greatest + 1.0),)
        good = GoodCondition(robot, "+-/up", 0.1, ranges)
        assert prove(good, shape, (0.2, 1.5), 1.0).verdict == verdict
        ranges = (ActuatorRange(1, least - 1.0, greatest + room),)
        good = GoodCondition(robot, "+-/up", 0.1, ranges)
        assert prove(good, shape, (0.2, 1.5), 1.0).verdict == verdict


def test_margins_of_a_range_are_those_of_directions() -> None:
    limit = ActuatorRange(1, np.radians(170.0), np.radians(200.0))
    angles = np.radians([170.0, 180.0, -170.0, -160.0, 165.0, -150.0])
    assert np.allclose(np.degrees(limit.margins(angles)), [0.0, 10.0, 10.0, 0.0, -5.0, -10.0])
    assert not ActuatorRange(1, 0.0, 2.0 * np.pi).is_limiting
