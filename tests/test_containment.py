"""Bounds on discs, and the proof that a whole shape lies in a good-condition workspace."""

from __future__ import annotations

import naive
import numpy as np
from designs import random_cases, random_reachable_point

from fivebar_atlas import FiveBar, planar_design


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
