"""The oracle of the manipulator with a passive leg agrees with itself.

Its vector equations with closure and with finite differences, its two evaluations with each other
and, where the region is as simple as the paper has it, with a plain rule over Eq. 12.
"""

import math
from typing import Any

import numpy as np
import pytest
from naive_passive_leg import (
    CASES,
    MODE_PAIRS,
    Array,
    Machine,
    angles_to_look_at,
    base_joints,
    columns,
    components,
    conditioning,
    cross,
    dot,
    grid_indices,
    inverse_kinematics,
    jacobian,
    machine,
    options_of,
    physical_size,
    pinches,
    platform_axes,
    platform_joints,
    pose,
    reached,
    read_reference_file,
    reference_indices,
    strips_of,
)
from scipy import integrate


def describe(case: dict[str, Any]) -> str:
    limited = "limits" if case["passive_joint_limits"] else "free"
    return " ".join([*map(str, case["design"]), case["mode"], f"{case['theta_limit']:g}", limited])


def random_poses(m: Machine, rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Poses well within reach."""
    length = rng.uniform(0.1, m.longest, 40 * n)
    theta = rng.uniform(-1.5, 1.5, length.size)
    tighter = m._replace(l_a=m.l_a - 0.02, l_b=m.l_b - 0.02), m._replace(l_a=m.l_a + 0.02)
    inside = reached(m, length, theta)
    for other in tighter:
        inside &= reached(other, length, theta)
    return length[inside][:n], theta[inside][:n]


def random_machines(seed: int, n: int) -> list[tuple[Machine, Array, Array]]:
    rng = np.random.default_rng(seed)
    result = []
    while len(result) < n:
        r, l_a, l_b = rng.uniform(0.5, 2.0, 3)
        m = machine(r, l_a, l_b, str(rng.choice(MODE_PAIRS)), False)
        length, theta = random_poses(m, rng, 20)
        if length.size == 20:
            result.append((m, length, theta))
    return result


def test_legs_close_with_the_elbows_asked_for() -> None:
    for m, length, theta in random_machines(1, 40):
        angles = inverse_kinematics(m, length, theta)
        joints = platform_joints(m.r, length, theta)
        for b, foot, phi, sign in zip(joints, base_joints(), angles, m.signs, strict=True):
            d = foot + m.l_a * np.stack([np.cos(phi), np.sin(phi)], axis=-1)
            assert np.hypot(*(b - d).T) == pytest.approx(m.l_b, abs=1e-12)
            # "+" is clockwise of the line from B to b
            assert np.all(sign * cross(b - foot, d - foot) < 0.0)


def test_signs_of_the_standard_configuration() -> None:
    m = machine(0.8, 1.1, 1.3, "+-/up", False)
    phi1, phi2 = inverse_kinematics(m, 1.4, 0.1)
    assert m.l_a * math.cos(phi1) > 0.1
    assert m.l_a * math.cos(phi2) < -0.1
    p = pose(m, 1.4, 0.1)
    assert p.q1 > 0.0
    assert p.q2 > 0.0
    assert p.det_x < 0.0


def test_jacobian_is_that_of_finite_differences() -> None:
    step = 1e-4
    for m, length, theta in random_machines(2, 40):
        x, y = -length * np.sin(theta), length * np.cos(theta)

        def angles(x: Array, y: Array, m: Machine = m) -> Array:
            found = inverse_kinematics(m, np.hypot(x, y), np.arctan2(-x, y))
            return np.stack(found, axis=-1)

        rates = []
        for dx, dy in ((step, 0.0), (0.0, step)):
            turns = [
                np.remainder(angles(x + k * dx, y + k * dy) - angles(x, y) + np.pi, 2 * np.pi)
                for k in (-2, -1, 1, 2)
            ]
            # of fourth order
            rates.append((turns[0] - 8.0 * turns[1] + 8.0 * turns[2] - turns[3]) / (12.0 * step))
        differences = np.stack(rates, axis=-1)
        j = jacobian(m, length, theta)
        size = np.abs(j).max(axis=(1, 2), keepdims=True)
        assert np.abs((differences - j) / size).max() < 1e-4
        assert np.median(np.abs((differences - j) / size)) < 1e-9


def test_conditioning_is_that_of_singular_values() -> None:
    for m, length, theta in random_machines(3, 40):
        j = jacobian(m, length, theta)
        sigma = np.linalg.svd(j, compute_uv=False)
        lci, manipulability = conditioning(m, length, theta)
        assert lci == pytest.approx(sigma[:, 1] / sigma[:, 0], rel=1e-9, abs=1e-12)
        assert manipulability == pytest.approx(1.0 / np.abs(np.linalg.det(j)), rel=1e-8)


def test_determinant_is_that_of_the_matrix_printed() -> None:
    # Eq. 20 by its entries, and Eq. 24, whose first term has a factor 2 too many
    for m, length, theta in random_machines(4, 40):
        u, w = platform_axes(theta)
        links, rows = [], []
        joints = zip(
            platform_joints(m.r, length, theta),
            base_joints(),
            inverse_kinematics(m, length, theta),
            (1.0, -1.0),
            strict=True,
        )
        c = length[:, None] * w
        for b, foot, phi, side in joints:
            n = b - foot - m.l_a * np.stack([np.cos(phi), np.sin(phi)], axis=-1)
            z = m.r * dot(n, w) / (c[:, 0] * np.sin(theta) - c[:, 1] * np.cos(theta))
            links.append(n)
            rows.append(n + side * z[:, None] * u)
        det = np.linalg.det(np.stack(rows, axis=1))
        p = pose(m, length, theta)
        assert p.det_x == pytest.approx(length * det, abs=1e-11)
        first, second = (n[:, 0] * np.sin(theta) - n[:, 1] * np.cos(theta) for n in links)
        printed = -length * cross(*links) + 2.0 * m.r * first * second
        assert p.det_x == pytest.approx(-printed, abs=1e-11)


def longest(r: float, l_a: float, l_b: float, theta: Array) -> Array:
    """Eq. 12 without the "/2"."""
    s = np.abs(np.sin(theta))
    return -s + np.sqrt(s**2 - 1.0 - r**2 + 2.0 * r * np.cos(theta) + (l_a + l_b) ** 2)


def test_reference_is_a_plain_rule_where_the_region_is_simple() -> None:
    design = (1.2, 1.4, 1.2)
    found = reference_indices(*design)
    area, _ = integrate.quad(lambda x: float(longest(*design, np.array(x))) ** 2, 0.0, np.pi / 2)
    assert found["usable_workspace_area"] == pytest.approx(area, rel=1e-12)
    assert found["workspace_area"] == pytest.approx(area, rel=1e-12)
    assert found["space_utilisation"] == pytest.approx(area / physical_size(*design), rel=1e-12)

    node, weight = np.polynomial.legendre.leggauss(300)
    t = (node + 1.0) / 2.0
    theta = np.pi / 2 * t[:, None] ** 2
    top = longest(*design, theta)
    length = top * (1.0 - t**2)  # the square root at the stretched leg
    share = np.pi / 2 * t[:, None] * weight[:, None] * top * t * weight
    lci, manipulability = conditioning(machine(*design, "+-/up", True), length, theta)
    for suffix, measure in (("", share * length), ("_l_theta", share)):
        total = measure.sum()
        assert found[f"gci{suffix}"] == pytest.approx((measure * lci).sum() / total, rel=1e-5)
        mean = (measure * manipulability).sum() / total
        assert found[f"gmi{suffix}"] == pytest.approx(mean, rel=1e-9)


@pytest.mark.parametrize("case", read_reference_file(), ids=describe)
def test_grid_agrees_with_the_reference_on_file(case: dict[str, Any]) -> None:
    exact = case["values"]
    rough = grid_indices(*case["design"], **options_of(case), n=200)
    assert exact["usable_workspace_area"] > 0.1
    for name, value in rough.items():
        if name.endswith("_error"):
            continue
        assert exact[f"{name}_error"] <= 1e-8
        if math.isinf(value):
            assert exact[name] == value, name
        else:
            assert abs(value - exact[name]) <= rough[f"{name}_error"] + 1e-9, name
            assert rough[f"{name}_error"] < (0.4 if name == "max_lci" else 0.05), name


@pytest.mark.parametrize("number", [1, 7])
def test_reference_is_that_on_file(number: int) -> None:
    case = read_reference_file()[number]
    found = reference_indices(*case["design"], **options_of(case), rtol=1e-7)
    assert found.keys() == case["values"].keys()
    for name, value in case["values"].items():
        if not name.endswith("_error"):
            doubt = found.get(f"{name}_error", 1e-8)
            assert found[name] == pytest.approx(value, abs=doubt + 1e-9), name
            assert doubt < 1e-5, name


def test_file_holds_the_cases() -> None:
    for case, on_file in zip(CASES, read_reference_file(), strict=True):
        assert list(case["design"]) == on_file["design"]
        assert {**options_of(case), "thresholds": list(case.get("thresholds", ()))} == (
            options_of(on_file)
        )


@pytest.mark.parametrize("assembly", ["up", "down"])
def test_mirrored_working_modes_have_mirrored_parts(assembly: str) -> None:
    found = []
    for working in ("++", "--"):
        m = machine(1.2, 1.0, 0.8, f"{working}/{assembly}", False)
        strips = strips_of(m, np.pi / 2, angles_to_look_at(m, np.pi / 2, 200), 64)
        found.append([part for part in components(strips, m, 64) if part.area > 1e-6])
    assert found[0]
    for one, other in zip(*found, strict=True):
        assert one.area == pytest.approx(other.area, abs=1e-8)
        assert one.turned == pytest.approx(-other.turned, abs=1e-8)


def test_parts_that_touch_in_a_point_are_two() -> None:
    # at l = 0 and θ = 60 degrees both upper links are along the platform; the part beyond, next to
    # l = 0, does not count
    m = machine(0.7, 1.4, 0.9, "++/down", False)
    p = pose(m, 0.0, math.pi / 3.0)
    assert abs(p.q1) < 1e-15
    assert abs(p.q2) < 1e-15
    at = pose(m, 1e-3, np.radians([58.0, 62.0]))
    assert np.all(at.det_x > 0.0)
    theta = math.pi / 3.0 + np.array([-0.02, 0.001, 0.02])
    found = pinches(m, theta, columns(m, theta, 64), 64)
    assert found == pytest.approx([math.pi / 3.0], abs=1e-9)


def test_unknown_modes_are_refused() -> None:
    with pytest.raises(ValueError, match="mode is '\\+-', must be one of \\+-/up"):
        reference_indices(1.2, 1.4, 1.2, "+-")
