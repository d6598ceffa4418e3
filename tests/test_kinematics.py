"""Inverse and forward kinematics of the five-bar."""

from __future__ import annotations

import math

import naive
import numpy as np
import pytest
from designs import random_cases, random_reachable_point

from fivebar_atlas.mechanisms.five_bar.kinematics import (
    elbow,
    forward,
    inverse,
    reaches,
    squared_four_areas,
)

pytestmark = pytest.mark.nojit


def test_inverse_agrees_with_trigonometry() -> None:
    rng = np.random.default_rng(0)
    for (r1, r2, r3), (s1, s2, _) in random_cases(10, 200):
        x, y = random_reachable_point(rng, r1, r2, r3)
        ours = np.array(inverse(r1, r2, r3, x, y, float(s1), float(s2)))
        theirs = np.array(naive.inverse_kinematics(r1, r2, r3, x, y, s1, s2))
        turn = (ours - theirs) / (2.0 * math.pi)
        np.testing.assert_allclose(turn, np.round(turn), atol=1e-7)


def test_forward_undoes_inverse() -> None:
    rng = np.random.default_rng(1)
    for (r1, r2, r3), (s1, s2, _) in random_cases(11, 200):
        x, y = random_reachable_point(rng, r1, r2, r3)
        det_b = float(naive.det_b(r1, r2, r3, x, y, s1, s2))
        theta1, theta2 = inverse(r1, r2, r3, x, y, float(s1), float(s2))
        back_x, back_y, possible = forward(r1, r2, r3, theta1, theta2, math.copysign(1.0, det_b))
        assert possible
        # near a parallel singularity P moves fast with the inputs
        assert math.hypot(back_x - x, back_y - y) < 1e-12 / min(abs(det_b) / r2**2, 1.0) + 1e-7


def test_forward_agrees_with_circle_intersection() -> None:
    rng = np.random.default_rng(2)
    assembled = 0
    for (r1, r2, r3), (_, _, assembly) in random_cases(12, 200):
        theta1, theta2 = rng.uniform(-math.pi, math.pi, 2)
        x, y, possible = forward(r1, r2, r3, theta1, theta2, float(assembly))
        theirs = np.asarray(
            naive.forward_kinematics(r1, r2, r3, theta1, theta2, assembly), dtype=float
        ).ravel()
        assert possible == bool(np.all(np.isfinite(theirs)))
        if possible:
            assembled += 1
            np.testing.assert_allclose([x, y], theirs, atol=1e-10)
    assert assembled > 50


def test_elbow_keeps_both_link_lengths() -> None:
    rng = np.random.default_rng(3)
    for (r1, r2, r3), (s1, _, _) in random_cases(13, 200):
        x, y = random_reachable_point(rng, r1, r2, r3)
        bx, by = elbow(r1, r2, -r3, x, y, float(s1))
        assert math.hypot(bx + r3, by) == pytest.approx(r1, rel=1e-10)
        assert math.hypot(x - bx, y - by) == pytest.approx(r2, rel=1e-10)
        side = (x + r3) * by - y * (bx + r3)
        assert side * s1 > 0.0


def test_singular_cases_of_the_leg() -> None:
    assert squared_four_areas(1.2, 0.8, 4.0) == 0.0  # stretched
    assert squared_four_areas(1.25, 0.75, 0.25) == 0.0  # folded
    assert squared_four_areas(1.2, 0.8, 4.1) < 0.0
    assert elbow(1.0, 1.0, 0.5, 0.5, 0.0, 1.0) == (0.5, 0.0)  # P on the base joint, r1 = r2
    assert elbow(1.0, 0.5, 0.0, 1.5, 0.0, 1.0) == pytest.approx((1.0, 0.0))
    assert reaches(1.0, 1.0, 0.5, 0.0, 1.0)
    assert not reaches(1.0, 1.0, 0.5, 1.6, 0.0)


def test_forward_refuses_what_cannot_be_assembled() -> None:
    _, _, possible = forward(1.0, 0.5, 1.0, math.pi, 0.0, 1.0)
    assert not possible  # elbows 4 apart, links 0.5 each
    _, _, possible = forward(1.0, 1.0, 0.0, 0.3, 0.3, 1.0)
    assert not possible  # B1 = B2: P is free on a circle
