"""Jacobian matrices and LCI of the five-bar."""

from __future__ import annotations

import math

import naive
import numpy as np
import pytest
from designs import random_cases, random_design, random_reachable_point

from fivebar_atlas.mechanisms.five_bar.jacobian import (
    conditioning_ratio,
    conditioning_with_slope,
    lci,
    matrices,
    signed_det_b,
    threshold_ratio,
)
from fivebar_atlas.mechanisms.five_bar.kinematics import inverse

pytestmark = pytest.mark.nojit


def test_matrices_agree_with_the_printed_ones() -> None:
    rng = np.random.default_rng(0)
    for (r1, r2, r3), (s1, s2, _) in random_cases(20, 200):
        x, y = random_reachable_point(rng, r1, r2, r3)
        a11, a22, *b = matrices(r1, r2, r3, x, y, float(s1), float(s2))
        theta = naive.inverse_kinematics(r1, r2, r3, x, y, s1, s2)
        np.testing.assert_allclose(
            np.diag([a11, a22]), naive.matrix_a(r1, r3, x, y, *theta), atol=1e-7
        )
        np.testing.assert_allclose(
            np.reshape(b, (2, 2)), naive.matrix_b(r1, r3, x, y, *theta), atol=1e-7
        )


def test_jacobian_by_finite_differences() -> None:
    rng = np.random.default_rng(1)
    step = 1e-6
    for (r1, r2, r3), (s1, s2, _) in random_cases(21, 200):
        x, y = random_reachable_point(rng, r1, r2, r3)
        a11, a22, *b = matrices(r1, r2, r3, x, y, float(s1), float(s2))
        if min(abs(a11), abs(a22)) < 0.05 * r1 * r2:
            continue  # differences fail at serial singularities, where J is infinite
        jacobian = np.reshape(b, (2, 2)) / np.array([[a11], [a22]])
        numeric = np.empty((2, 2))
        for column, (dx, dy) in enumerate([(step, 0.0), (0.0, step)]):
            ahead = np.array(inverse(r1, r2, r3, x + dx, y + dy, float(s1), float(s2)))
            behind = np.array(inverse(r1, r2, r3, x - dx, y - dy, float(s1), float(s2)))
            turned = (ahead - behind + math.pi) % (2.0 * math.pi) - math.pi
            numeric[:, column] = turned / (2.0 * step)
        np.testing.assert_allclose(jacobian, numeric, rtol=1e-4, atol=1e-4)


def test_lci_is_the_inverse_condition_number() -> None:
    rng = np.random.default_rng(2)
    for (r1, r2, r3), (s1, s2, _) in random_cases(22, 300):
        x, y = random_reachable_point(rng, r1, r2, r3)
        ours = lci(r1, r2, r3, x, y, float(s1), float(s2))
        assert ours == pytest.approx(float(naive.lci(r1, r2, r3, x, y, s1, s2)), abs=1e-8)
        assert 0.0 <= ours <= 1.0


def test_lci_does_not_depend_on_scale() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        r1, r2, r3 = random_design(rng)
        x, y = random_reachable_point(rng, r1, r2, r3)
        small = lci(r1, r2, r3, x, y, 1.0, -1.0)
        for factor in (1e-6, 24.0, 1e6):
            scaled = (factor * value for value in (r1, r2, r3, x, y))
            assert lci(*scaled, 1.0, -1.0) == pytest.approx(small, rel=1e-7, abs=1e-12)


def test_lci_at_singular_and_isotropic_points() -> None:
    assert lci(1.0, 1.0, 0.5, 1.5, 0.0, 1.0, -1.0) == 0.0  # leg 1 stretched
    assert lci(1.5, 1.5, 0.0, 3.0, 0.0, 1.0, -1.0) == 0.0  # both legs stretched
    assert lci(1.0, 1.0, 0.5, 5.0, 5.0, 1.0, -1.0) == 0.0  # beyond reach
    # isotropic configuration of Le, Kang and Doan, Eqs. 21 and 22
    r1, r2 = 1.0, 2.0
    r3 = math.sqrt(0.5) * (r2 - r1)
    assert lci(r1, r2, r3, 0.0, math.sqrt(0.5) * (r1 + r2), 1.0, -1.0) == pytest.approx(1.0)


def test_ratio_belongs_to_lci() -> None:
    rng = np.random.default_rng(4)
    for (r1, r2, r3), (s1, s2, _) in random_cases(23, 100):
        x, y = random_reachable_point(rng, r1, r2, r3)
        index = lci(r1, r2, r3, x, y, float(s1), float(s2))
        ratio = conditioning_ratio(r1, r2, r3, x, y, float(s1), float(s2))
        assert ratio == pytest.approx(threshold_ratio(index), abs=1e-12)


def test_slope_is_the_derivative() -> None:
    rng = np.random.default_rng(5)
    checked = 0
    for (r1, r2, r3), (s1, s2, _) in random_cases(24, 300):
        x, y = random_reachable_point(rng, r1, r2, r3)
        angle = rng.uniform(-math.pi, math.pi)
        dx, dy = math.cos(angle), math.sin(angle)
        modes = float(s1), float(s2)
        assembly = math.copysign(1.0, signed_det_b(r1, r2, r3, x, y, *modes))
        q, slope = conditioning_with_slope(r1, r2, r3, x, y, dx, dy, *modes, assembly)
        assert q == pytest.approx(conditioning_ratio(r1, r2, r3, x, y, *modes), abs=1e-14)
        if abs(slope) > 10.0 or q < 0.01:
            continue  # a singularity is near
        h = 1e-6
        ahead = conditioning_ratio(r1, r2, r3, x + h * dx, y + h * dy, *modes)
        behind = conditioning_ratio(r1, r2, r3, x - h * dx, y - h * dy, *modes)
        assert slope == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-5)
        checked += 1
    assert checked > 100


def test_sign_of_det_b_tells_the_assembly_mode() -> None:
    rng = np.random.default_rng(6)
    for (r1, r2, r3), (s1, s2, _) in random_cases(25, 200):
        x, y = random_reachable_point(rng, r1, r2, r3)
        ours = signed_det_b(r1, r2, r3, x, y, float(s1), float(s2))
        assert np.sign(ours) == np.sign(naive.det_b(r1, r2, r3, x, y, s1, s2))
