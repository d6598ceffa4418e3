"""Kinematics and Jacobian matrices of the manipulator with a passive leg.

Everything is compared with the loop closure written out here in x and y, its finite
differences, and the roots of the sextic in forty digits.
"""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from fivebar_atlas.mechanisms.passive_leg.forward import forward_poses
from fivebar_atlas.mechanisms.passive_leg.jacobian import (
    lci,
    manipulability,
    matrices_in_platform_axes,
)
from fivebar_atlas.mechanisms.passive_leg.kinematics import inverse, reaches

Design = tuple[float, float, float, float]
OUTWARD = (-1.0, 1.0)
STEP = 1e-4


def random_design(rng: np.random.Generator) -> Design:
    """R = 1, r and l_b in [0.5, 2], and in half of the cases l_a = l_b - R + r."""
    while True:
        platform, upper = rng.uniform(0.5, 2.0, 2)
        lower = upper - 1.0 + platform if rng.random() < 0.5 else rng.uniform(0.3, 2.5)
        if lower > 0.05:
            return 1.0, float(platform), float(lower), float(upper)


def random_pose(rng: np.random.Generator, design: Design) -> tuple[float, float]:
    while True:
        length = float(rng.uniform(0.05, design[2] + design[3] + 1.0))
        theta = float(rng.uniform(-0.5 * math.pi, 0.5 * math.pi))
        if reaches(*design, length, theta):
            return length, theta


def joints(design: Design, length: float, theta: float) -> tuple[np.ndarray, np.ndarray]:
    """Return b1, b2 and B1, B2."""
    base, platform, _, _ = design
    middle = length * np.array([-math.sin(theta), math.cos(theta)])
    along = platform * np.array([math.cos(theta), math.sin(theta)])
    return np.array([middle + along, middle - along]), np.array([[base, 0.0], [-base, 0.0]])


def elbows(design: Design, phi: tuple[float, float]) -> np.ndarray:
    base, _, lower, _ = design
    return np.array(
        [
            [base + lower * math.cos(phi[0]), lower * math.sin(phi[0])],
            [-base + lower * math.cos(phi[1]), lower * math.sin(phi[1])],
        ]
    )


@pytest.mark.nojit
def test_all_branches_close_both_legs_with_the_elbows_asked_for() -> None:
    rng = np.random.default_rng(31)
    for _ in range(300):
        design = random_design(rng)
        pose = random_pose(rng, design)
        ends, bases = joints(design, *pose)
        for signs in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
            bends = elbows(design, inverse(*design, *pose, *signs))
            upper = np.linalg.norm(ends - bends, axis=1)
            assert upper == pytest.approx([design[3]] * 2, abs=1e-12)
            for end, bend, foot, sign in zip(ends, bends, bases, signs, strict=True):
                leg, lower = end - foot, bend - foot
                turn = leg[0] * lower[1] - leg[1] * lower[0]
                assert turn * sign >= -1e-12


def test_the_signs_of_the_paper_put_both_elbows_outward() -> None:
    # Eq. 6 with "+" for leg 1 and "-" for leg 2, by two-argument arcs
    design = (1.0, 0.8, 1.1, 1.3)
    for length, theta in ((1.4, 0.0), (1.2, 0.3), (1.5, -0.4)):
        base, platform, lower, upper = design
        x, y = -length * math.sin(theta), length * math.cos(theta)
        phi = []
        for side, root in ((1.0, 1.0), (-1.0, -1.0)):
            alpha = 2.0 * lower * (x + side * (platform * math.cos(theta) - base))
            beta = 2.0 * lower * (y + side * platform * math.sin(theta))
            gamma = -(alpha**2 + beta**2) / (4.0 * lower**2) + upper**2 - lower**2
            square = math.sqrt(alpha**2 + beta**2 - gamma**2)
            phi.append(2.0 * math.atan2(-beta + root * square, gamma - alpha))
        found = inverse(*design, length, theta, *OUTWARD)
        for ours, printed in zip(found, phi, strict=True):
            assert math.cos(ours - printed) == pytest.approx(1.0, abs=1e-14)
        bends = elbows(design, found)
        assert bends[0, 0] > 1.0
        assert bends[1, 0] < -1.0


def test_a_pose_is_reached_where_both_legs_are_long_and_short_enough() -> None:
    rng = np.random.default_rng(32)
    inside = 0
    for _ in range(2000):
        design = random_design(rng)
        length, theta = float(rng.uniform(0.0, 4.0)), float(rng.uniform(-1.57, 1.57))
        ends, bases = joints(design, length, theta)
        reach = np.linalg.norm(ends - bases, axis=1)
        expected = np.all(reach <= design[2] + design[3]) and np.all(
            reach >= abs(design[2] - design[3])
        )
        assert reaches(*design, length, theta) == expected
        inside += int(expected)
    assert 300 < inside < 1900


def test_the_outer_boundary_is_a_stretched_leg() -> None:
    # Eq. 12 without the paper's "/2"
    rng = np.random.default_rng(33)
    for _ in range(500):
        base, platform, lower, upper = random_design(rng)
        theta = float(rng.uniform(-1.5, 1.5))
        inner = (
            (base * math.sin(theta)) ** 2 - base**2 - platform**2
            + 2.0 * platform * base * math.cos(theta) + (lower + upper) ** 2
        )  # fmt: skip
        if inner <= 0.0:
            continue
        length = -base * abs(math.sin(theta)) + math.sqrt(inner)
        if length < 0.1:
            continue
        ends, bases = joints((base, platform, lower, upper), length, theta)
        reach = np.linalg.norm(ends - bases, axis=1)
        assert reach.max() == pytest.approx(lower + upper, abs=1e-12)


def closure(design: Design, phi: tuple[float, float], length: float, theta: float) -> np.ndarray:
    ends, _ = joints(design, length, theta)
    return np.linalg.norm(ends - elbows(design, phi), axis=1) - design[3]


@pytest.mark.slow
def test_forward_after_inverse_finds_the_pose() -> None:
    rng = np.random.default_rng(34)
    for _ in range(4000):
        design = random_design(rng)
        pose = random_pose(rng, design)
        elbow = (float(rng.choice([-1.0, 1.0])), float(rng.choice([-1.0, 1.0])))
        phi = inverse(*design, *pose, *elbow)
        found = forward_poses(*design, *phi)
        assert 1 <= len(found) <= 6
        near = np.min(np.abs(found - pose).max(axis=1))
        # next to a parallel singularity two poses come together, and rounding grows
        _, _, m11, m12, m21, m22 = matrices_in_platform_axes(*design, *pose, *elbow)
        det = abs(m11 * m22 - m12 * m21)
        assert near <= 1e-9 + 1e-13 / max(det, 1e-12) ** 2
        for length, theta in found:
            assert np.abs(closure(design, phi, length, theta)).max() < 1e-10


def assemblies_in_high_precision(design: Design, phi: tuple[float, float]) -> list[float]:
    """Return the real lengths of the passive leg, by the resultant in forty digits."""
    with mpmath.workdps(40):
        base, platform, lower, upper = (mpmath.mpf(each) for each in design)
        bends = [
            (side * base + lower * mpmath.cos(angle), lower * mpmath.sin(angle), side)
            for side, angle in zip((1, -1), (mpmath.mpf(phi[0]), mpmath.mpf(phi[1])), strict=True)
        ]

        def value(length: mpmath.mpf) -> mpmath.mpf:
            rows = []
            for x, y, side in bends:
                constant = length**2 + platform**2 + x**2 + y**2 - upper**2
                rows.append(
                    (constant, length * y + side * platform * x, length * x - side * platform * y)
                )
            (a1, b1, c1), (a2, b2, c2) = rows
            return (
                (a1 * b2 - a2 * b1) ** 2 + (a2 * c1 - a1 * c2) ** 2 - 4 * (b2 * c1 - b1 * c2) ** 2
            )

        # the sextic from seven of its values
        places = [mpmath.mpf(k) / 2 for k in range(-3, 4)]
        system = mpmath.matrix([[place**power for power in range(7)] for place in places])
        coefficients = mpmath.lu_solve(system, mpmath.matrix([value(place) for place in places]))
        rising = [coefficients[k] for k in range(7)]
        roots = mpmath.polyroots(rising, maxsteps=500, extraprec=400, asc=True)
        return sorted(float(root.real) for root in roots if abs(root.imag) < mpmath.mpf(10) ** -15)


def test_all_real_assemblies_are_found() -> None:
    rng = np.random.default_rng(35)
    counts: dict[int, int] = {}
    for _ in range(150):
        design = random_design(rng)
        phi = inverse(*design, *random_pose(rng, design), *OUTWARD)
        expected = assemblies_in_high_precision(design, phi)
        found = forward_poses(*design, *phi)
        assert len(found) == len(expected), (design, phi)
        assert found[:, 0] == pytest.approx(expected, abs=1e-7)
        counts[len(found)] = counts.get(len(found), 0) + 1
    assert max(counts) == 6
    assert set(counts) == {2, 4, 6}


def test_inputs_that_no_pose_has_have_no_assembly() -> None:
    # elbows so far apart that no platform joins them
    assert forward_poses(1.0, 0.5, 2.0, 0.6, 0.0, math.pi).shape == (0, 2)


@pytest.mark.nojit
def test_rates_of_inputs_are_those_of_finite_differences() -> None:
    rng = np.random.default_rng(36)
    checked = 0
    while checked < 200:
        design = random_design(rng)
        length, theta = random_pose(rng, design)
        signs = (float(rng.choice([-1.0, 1.0])), float(rng.choice([-1.0, 1.0])))
        j1, j2, *entries = matrices_in_platform_axes(*design, length, theta, *signs)
        if length < 0.2 or min(abs(j1), abs(j2)) < 0.1:
            continue
        checked += 1
        jacobian = np.array(entries).reshape(2, 2) / np.array([[j1], [j2]])
        x, y = -length * math.sin(theta), length * math.cos(theta)
        here = np.array(inverse(*design, length, theta, *signs))
        rates = []
        for way in ((1.0, 0.0), (0.0, 1.0)):
            turns = []
            for steps in (2.0, 1.0, -1.0, -2.0):
                px, py = x + steps * STEP * way[0], y + steps * STEP * way[1]
                moved = math.hypot(px, py), math.atan2(-px, py)
                turn = np.array(inverse(*design, *moved, *signs)) - here
                turns.append(np.remainder(turn + math.pi, 2.0 * math.pi) - math.pi)
            # of fourth order
            rates.append((8.0 * (turns[1] - turns[2]) - (turns[0] - turns[3])) / (12.0 * STEP))
        in_xy = np.stack(rates, axis=1)
        axes = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
        assert in_xy @ axes == pytest.approx(jacobian, rel=1e-7, abs=1e-7)
        values = np.linalg.svd(in_xy, compute_uv=False)
        assert lci(*design, length, theta, *signs) == pytest.approx(
            values[1] / values[0], rel=1e-6, abs=1e-9
        )
        assert manipulability(*design, length, theta, *signs) == pytest.approx(
            1.0 / abs(np.linalg.det(in_xy)), rel=1e-6
        )


@pytest.mark.nojit
def test_jacobian_matrices_are_those_of_the_paper_turned_into_the_platform() -> None:
    rng = np.random.default_rng(37)
    for _ in range(200):
        design = random_design(rng)
        base, platform, lower, _ = design
        length, theta = random_pose(rng, design)
        phi = inverse(*design, length, theta, *OUTWARD)
        x, y = -length * math.sin(theta), length * math.cos(theta)
        c, s = math.cos(theta), math.sin(theta)
        rows, diagonal = [], []
        for side, angle in zip((1.0, -1.0), phi, strict=True):
            # X_i, Y_i, Z_i and Eqs. 19, 20
            big_x = x + side * (platform * c - base) - lower * math.cos(angle)
            big_y = y + side * platform * s - lower * math.sin(angle)
            big_z = platform * (-big_x * s + big_y * c) / (x * s - y * c)
            rows.append([big_x + side * big_z * c, big_y + side * big_z * s])
            diagonal.append(lower * (-big_x * math.sin(angle) + big_y * math.cos(angle)))
        j1, j2, *entries = matrices_in_platform_axes(*design, length, theta, *OUTWARD)
        axes = np.array([[c, -s], [s, c]])
        assert np.array(rows) @ axes == pytest.approx(np.array(entries).reshape(2, 2), abs=1e-12)
        assert diagonal == pytest.approx([j1, j2], abs=1e-12)


@pytest.mark.nojit
def test_stretched_legs_and_parallel_links_are_singular() -> None:
    design = (1.0, 0.7, 1.2, 1.5)
    # one leg stretched: the first kind
    theta = 0.3
    length = -math.sin(theta) + math.sqrt(2.7**2 - (math.cos(theta) - 0.7) ** 2)
    j1, j2 = matrices_in_platform_axes(*design, length, theta, *OUTWARD)[:2]
    assert abs(j1) < 1e-7
    assert abs(j2) > 0.1
    assert lci(*design, length, theta, *OUTWARD) < 1e-6
    # upper links along the platform: the second kind (Fig. 3a); with theta = 0 both elbows are
    # as high as the platform, at a distance of l_b from its ends
    reach = 0.7 + 1.5 - 1.0
    design = (1.0, 0.7, 1.6, 1.5)
    height = math.sqrt(1.6**2 - reach**2)
    j1, j2, m11, m12, m21, m22 = matrices_in_platform_axes(*design, height, 0.0, *OUTWARD)
    assert abs(m11 * m22 - m12 * m21) < 1e-12
    assert lci(*design, height, 0.0, *OUTWARD) < 1e-10
    assert min(abs(j1), abs(j2)) > 0.1


def test_mirrored_poses_have_one_lci() -> None:
    rng = np.random.default_rng(38)
    for _ in range(200):
        design = random_design(rng)
        length, theta = random_pose(rng, design)
        value = lci(*design, length, theta, *OUTWARD)
        assert 0.0 <= value <= 1.0
        assert lci(*design, length, -theta, *OUTWARD) == pytest.approx(value, abs=1e-12)
