"""Evaluations of the pentapod against the oracle, and how they hold what they state."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from naive_pentapod import (
    CASES,
    THRESHOLDS,
    Task,
    box_indices,
    conditioning,
    extremes,
    home_indices,
    homogeneous,
    jacobian,
    mapped,
    poses_of,
    read_reference_file,
    workspace_volume,
)
from scipy import optimize

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.settings import SweepSettings

MECHANISM = mechanisms.get("pentapod")
INTEGRATED = [quantity.name for quantity in MECHANISM.quantities if quantity.has_error]
NO_POSE, DEGENERATE, GCI_ROUGH, SHARE_ROUGH, SINGULAR = 1, 2, 4, 8, 16

REFERENCE = read_reference_file()

Results = dict[str, npt.NDArray[Any]]


def evaluated(
    designs: npt.ArrayLike,
    thresholds: tuple[float, ...] = THRESHOLDS,
    tolerance: float = 1e-3,
    **options: float | bool,
) -> Results:
    settings = SweepSettings(
        "pentapod", "radii", 2, ("home",), thresholds, tolerance, tuple(options.items())
    )
    return MECHANISM.evaluate(np.atleast_2d(np.asarray(designs, float)), settings)


def random_designs(count: int, seed: int) -> npt.NDArray[np.float64]:
    """Return designs of the space."""
    return np.random.default_rng(seed).uniform(0.1, 2.1, (count, 2))


def first(results: Results, name: str) -> float:
    """Return a value of the first design; names of thresholds as the oracle has them."""
    name, _, threshold = name.partition(" ")
    index = (0, THRESHOLDS.index(float(threshold))) if threshold else (0,)
    return float(results[name][index])


def doubt(results: Results, name: str) -> float:
    """Return the stated error of :func:`first`."""
    quantity, _, threshold = name.partition(" ")
    return first(results, f"{quantity}_error {threshold}".rstrip())


def test_options_are_those_of_the_oracle() -> None:
    declared = {option.name: option.default for option in MECHANISM.options}
    assert declared == dataclasses.asdict(Task())


@pytest.mark.parametrize("case", CASES)
def test_agreement_with_the_oracle(case: str) -> None:
    r_a, r_b, options = CASES[case]
    reference = REFERENCE[case]
    results = evaluated((r_a, r_b), **options)
    names = [name for name in reference if name.split(" ")[0] in INTEGRATED]
    assert len(names) == 4 + 2 * len(THRESHOLDS)
    for name in names:
        exact, error = reference[name]
        if math.isnan(exact):
            assert math.isnan(first(results, name)), name
            continue
        # a share of nothing is known to a few points of two million
        allowed = doubt(results, name) + 4.0 * error + 2e-6
        assert first(results, name) == pytest.approx(exact, abs=allowed), name
    status = int(results["status"][0])
    assert status & (NO_POSE | DEGENERATE) == 0
    singular = reference["least_determinant"][0] < 0.0
    assert bool(status & SINGULAR) == singular
    worst = (first(results, "least_singular_value"), first(results, "largest_limb_force"))
    if singular:
        assert worst[0] == 0.0
        assert math.isnan(worst[1])
    else:
        assert worst[0] == pytest.approx(reference["least_singular_value"][0], rel=0.01)
        assert worst[1] == pytest.approx(reference["largest_limb_force"][0], rel=0.01)


def test_worst_poses_of_small_boxes_and_whether_there_are_singular_ones() -> None:
    """The two searches share nothing; the evaluator's must not be the worse by more than 3 %."""
    regular = 0
    for index, (r_a, r_b) in enumerate(random_designs(12, 17)):
        share = (0.3, 0.6)[index % 2]
        box = (
            ("x", 0.0, 0.25),
            ("y", 0.0, 0.25),
            ("z", 1.0, 0.15),
            ("beta", 0.0, 20.0),
            ("gamma", 0.0, 20.0),
        )
        options = {f"{name}_min": middle - share * half for name, middle, half in box}
        options |= {f"{name}_max": middle + share * half for name, middle, half in box}
        found = extremes(Task(**options), r_a, r_b, points=3000, starts=3)
        results = evaluated((r_a, r_b), (), **options)
        singular = found.least_determinant < 0.0
        assert bool(int(results["status"][0]) & SINGULAR) == singular
        if singular:
            continue
        regular += 1
        least, force = (first(results, n) for n in ("least_singular_value", "largest_limb_force"))
        assert least <= 1.03 * found.least_singular_value
        assert force >= found.largest_limb_force / 1.03
        # no force is larger than 1 over the least singular value
        assert force <= 1.02 / least
    assert regular > 4


def test_home_values_are_exact() -> None:
    for task in (Task(), Task(axis_angle=35.0, offset=-0.8), Task(platform_radius_as_length=True)):
        designs = random_designs(20, 12)
        changed = {
            name: value
            for name, value in dataclasses.asdict(task).items()
            if value != getattr(Task(), name)
        }
        results = evaluated(designs, tolerance=0.1, **changed)
        for index, (r_a, r_b) in enumerate(designs):
            home = home_indices(task, r_a, r_b)
            pairs = (
                ("home_lci", home.lci),
                ("home_least_singular_value", home.least),
                ("home_largest_limb_force", home.force),
            )
            for name, value in pairs:
                assert results[name][index] == pytest.approx(float(value), rel=1e-10), name


def test_values_are_unbiased_over_many_designs() -> None:
    designs = random_designs(40, 13)
    results = evaluated(designs, tolerance=1e-2)
    scores: dict[str, list[float]] = {}
    for index, (r_a, r_b) in enumerate(designs):
        found = box_indices(Task(), r_a, r_b, points=512, shifts=8, seed=100 + index)
        found["workspace_volume"] = workspace_volume(
            Task(), r_a, r_b, points=2048, shifts=8, seed=200 + index
        )
        for name, (value, error) in found.items():
            own = float(results[name][index])
            if math.isnan(value) or error == 0.0:
                continue
            allowed = math.hypot(error, float(results[f"{name}_error"][index]))
            scores.setdefault(name, []).append((own - value) / allowed)
    for name, each in scores.items():
        assert len(each) > 20, name
        assert abs(np.mean(each)) < 4.0 / math.sqrt(len(each)), name
        assert np.max(np.abs(each)) < 6.0, name


def test_stated_errors_hold_and_tolerances_are_kept() -> None:
    designs = random_designs(30, 14)
    fine = evaluated(designs, tolerance=1e-3)
    wrong, count, sizes = 0, 0, []
    for tolerance in (0.1, 0.03, 0.01):
        rough = evaluated(designs, tolerance=tolerance)
        for name in INTEGRATED:
            differences = np.abs(rough[name] - fine[name]).ravel()
            exist = np.isfinite(differences)
            allowed = (rough[f"{name}_error"] + fine[f"{name}_error"]).ravel() + 1e-14
            wrong += int(np.sum(differences[exist] > allowed[exist]))
            count += int(exist.sum())
        sizes.append(float(np.nanmean(rough["gci_error"] / rough["gci"])))
        reached = rough["status"] & (GCI_ROUGH | NO_POSE | DEGENERATE) == 0
        assert reached.mean() > 0.9
        for name in ("gci", "mean_least_singular_value"):
            value, error = rough[name][reached], rough[f"{name}_error"][reached]
            assert np.all(error <= 1.001 * tolerance * value), name
        reached = rough["status"] & (SHARE_ROUGH | DEGENERATE) == 0
        assert reached.mean() > 0.7
        for name in ("usable_share", "good_condition_share"):
            # shares have twice the tolerance
            assert np.all(rough[f"{name}_error"][reached] <= 2.001 * tolerance), name
        value, error = (rough[f"workspace_volume{end}"][reached] for end in ("", "_error"))
        assert np.all(error <= 2.001 * tolerance * value)
    assert count > 500
    assert wrong <= 0.01 * count
    assert sizes[0] > sizes[1] > sizes[2]


def test_a_box_of_one_pose_is_that_pose() -> None:
    point = {"x": 0.0, "y": 0.0, "z": 1.0, "beta": 0.0, "gamma": 0.0}
    box = {f"{name}_{end}": value for name, value in point.items() for end in ("min", "max")}
    results = evaluated((0.8, 0.3), **box)
    home = home_indices(Task(), 0.8, 0.3)
    assert results["usable_share"].tolist() == [1.0]
    assert results["gci"][0] == pytest.approx(float(home.lci), rel=1e-10)
    assert results["mean_least_singular_value"][0] == pytest.approx(float(home.least), rel=1e-10)
    assert results["least_singular_value"][0] == pytest.approx(float(home.least), rel=1e-10)
    assert results["largest_limb_force"][0] == pytest.approx(float(home.force), rel=1e-10)
    assert results["good_condition_share"][0].tolist() == [1.0, 0.0]
    for name, most in (
        ("gci", 1e-3),
        ("mean_least_singular_value", 1e-3),
        ("usable_share", 2e-3),
    ):
        assert results[f"{name}_error"][0] <= most, name
    # a volume does not know the box of positions
    whole = evaluated((0.8, 0.3))
    assert results["workspace_volume"][0] == whole["workspace_volume"][0]


def test_a_box_of_two_coordinates_against_gauss_points() -> None:
    options = {
        "x_min": 0.0, "x_max": 0.15, "y_min": 0.05, "y_max": 0.05, "z_min": 0.95, "z_max": 1.1,
        "beta_min": 4.0, "beta_max": 4.0, "gamma_min": -6.0, "gamma_max": -6.0,
    }  # fmt: skip
    task = Task(**options)
    m = task.machine(0.9, 0.5)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    unit = np.full((24, 24, 5), 0.5)
    unit[..., 0], unit[..., 2] = 0.5 * (1.0 + nodes[:, None]), 0.5 * (1.0 + nodes)
    poses = poses_of(task, m, mapped(task, unit.reshape(-1, 5)))
    assert np.all(poses.margins >= 0.0)
    lines = homogeneous(jacobian(m, poses.position, poses.matrix), task.length(0.5))
    values = conditioning(lines)
    weight = 0.25 * np.outer(weights, weights).ravel()
    results = evaluated((0.9, 0.5), **options)
    assert results["usable_share"].tolist() == [1.0]
    for name, each in (("gci", values.lci), ("mean_least_singular_value", values.least)):
        error = float(results[f"{name}_error"][0])
        assert error <= 1e-3 * float(weight @ each)
        assert results[name][0] == pytest.approx(float(weight @ each), abs=error + 1e-12)


def test_a_half_turn_of_everything_about_the_z_axis() -> None:
    """Base, platform and box turned by 180 degrees: X, Y, β and γ change their signs, α stays.

    A mirror image is no machine of the family: the limbs would change their order, with the SPR
    limb at one end of it and A_1 on the X axis at another.
    """
    one = {
        "position_angle": 30.0, "base_angle": 40.0, "offset": 0.8, "axis_angle": 20.0,
        "x_min": -0.1, "x_max": 0.25, "y_min": -0.2, "y_max": 0.3,
        "beta_min": -5.0, "beta_max": 20.0, "gamma_min": -15.0, "gamma_max": 10.0,
    }  # fmt: skip
    other = {
        "position_angle": -150.0, "base_angle": -140.0, "offset": -0.8, "axis_angle": 20.0,
        "x_min": -0.25, "x_max": 0.1, "y_min": -0.3, "y_max": 0.2,
        "beta_min": -20.0, "beta_max": 5.0, "gamma_min": -10.0, "gamma_max": 15.0,
    }  # fmt: skip
    designs = [(0.8, 0.3), (1.3, 0.6), (0.5, 0.9)]
    assert_same(
        evaluated(designs, tolerance=3e-3, **one), evaluated(designs, tolerance=3e-3, **other)
    )


def test_the_sign_of_the_axis_does_not_matter() -> None:
    designs = [(0.8, 0.3), (1.3, 0.6)]
    one, other = (evaluated(designs, tolerance=3e-3, axis_angle=turn) for turn in (25.0, -155.0))
    assert_same(one, other)


def assert_same(one: Results, other: Results) -> None:
    """Assert that two evaluations of one thing agree within their errors."""
    assert np.array_equal(one["status"] & ~12, other["status"] & ~12)
    for name in INTEGRATED:
        allowed = one[f"{name}_error"] + other[f"{name}_error"] + 1e-13
        differences = np.abs(one[name] - other[name])
        exist = np.isfinite(differences)
        assert np.array_equal(np.isfinite(one[name]), np.isfinite(other[name]))
        assert np.all(differences[exist] <= allowed[exist]), name
    for name in ("home_lci", "home_least_singular_value", "home_largest_limb_force"):
        assert np.allclose(one[name], other[name], rtol=1e-10), name
    for name in ("least_singular_value", "largest_limb_force"):
        assert np.allclose(one[name], other[name], rtol=0.02, equal_nan=True), name


def test_a_machine_of_any_size_is_the_same_design() -> None:
    for factor in (1e-3, 1.0, 520.0):
        designs, height = MECHANISM.from_lengths([factor, 0.8 * factor, 0.3 * factor])
        assert height == factor
        assert np.allclose(designs, [0.8, 0.3], rtol=1e-15)
    machine = MECHANISM.from_lengths([520.0, 400.0, 100.0])[0]
    results, direct = evaluated(machine), evaluated((400.0 / 520.0, 100.0 / 520.0))
    for name, values in results.items():
        assert np.array_equal(values, direct[name], equal_nan=True), name


def test_wider_limits_keep_more_poses() -> None:
    designs = random_designs(5, 16)
    sizes = []
    for limit in (20.0, 35.0, 50.0, 180.0):
        each = evaluated(
            designs, tolerance=1e-2, base_joint_limit=limit, platform_joint_limit=limit
        )
        sizes.append((each["usable_share"], each["workspace_volume"]))
        doubts = each["usable_share_error"], each["workspace_volume_error"]
        if len(sizes) > 1:
            for less, more, error in zip(*sizes[-2:], doubts, strict=True):
                assert np.all(more >= less - 2.0 * error)


def test_a_box_without_a_usable_pose_is_told() -> None:
    results = evaluated((0.8, 0.3), x_min=0.5, x_max=0.6, limb_max=1.001, limb_min=0.999)
    assert int(results["status"][0]) & NO_POSE
    assert results["usable_share"].tolist() == [0.0]
    for name in ("gci", "mean_least_singular_value", "least_singular_value", "largest_limb_force"):
        assert math.isnan(first(results, name)), name
    assert results["home_lci"][0] == pytest.approx(float(home_indices(Task(), 0.8, 0.3).lci))


def degenerate_radius(r_a: float) -> float:
    """Return the r_b at which n6 at home points along A_5 - p, so that α turns B_5 past A_5."""
    return r_a / math.cos(math.radians(9.0))


def test_designs_that_are_degenerate_at_home_are_told() -> None:
    def gap(r_b: float) -> float:
        m = Task().machine(0.5, r_b)
        return float(np.linalg.det(jacobian(m, np.array([0.0, 0.0, 1.0]), np.eye(3))))

    radii = np.linspace(0.1, 2.1, 401)
    signs = np.sign([gap(r_b) for r_b in radii])
    places = np.flatnonzero(np.diff(signs))
    designs = [(1.0, degenerate_radius(1.0))]
    for place in places:
        root = optimize.brentq(gap, radii[place], radii[place + 1], xtol=1e-16)
        designs.append((0.5, root))
    results = evaluated([*designs, (0.8, 0.3)])
    assert np.all(results["status"][:-1] & DEGENERATE)
    assert not results["status"][-1] & DEGENERATE
    for name, values in results.items():
        if name != "status":
            assert np.all(np.isnan(values[:-1])), name
    # A_2 in the place of A_1
    together = evaluated((0.8, 0.3), base_angle=0.0)
    assert int(together["status"][0]) & DEGENERATE
