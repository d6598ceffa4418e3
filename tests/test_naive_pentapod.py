"""The oracle of the pentapod agrees with itself, with SciPy's rotations and with differences."""

from __future__ import annotations

import math

import numpy as np
import pytest
from naive_pentapod import (
    CASES,
    HOME,
    THRESHOLDS,
    Array,
    Found,
    Machine,
    Task,
    box_indices,
    conditioning,
    constraint,
    derivatives,
    extremes,
    home_indices,
    home_side,
    homogeneous,
    jacobian,
    kronecker,
    limb_lengths,
    mapped,
    poses_of,
    read_reference_file,
    rotation,
    solved_alpha,
    workspace_volume,
)
from scipy import integrate
from scipy.spatial.transform import Rotation

REFERENCE = read_reference_file()


def random_machine(random: np.random.Generator) -> Machine:
    axis = random.normal(size=3)
    return Machine(
        random.normal(size=(5, 3)), random.normal(size=(5, 3)), axis / np.linalg.norm(axis)
    )


def test_rotations_are_those_of_scipy() -> None:
    angles = np.random.default_rng(1).uniform(-4.0, 4.0, (100, 3))
    ours = rotation(*angles.T)
    assert np.abs(ours - Rotation.from_euler("ZYX", angles).as_matrix()).max() < 1e-14


@pytest.mark.parametrize("task", [Task(**each[2]) for each in CASES.values()], ids=list(CASES))
def test_home_keeps_the_constraint_with_alpha_0(task: Task) -> None:
    m = task.machine(0.9, 0.4)
    assert abs(constraint(m, HOME, np.eye(3))) < 1e-15
    assert np.linalg.norm(m.axis) == pytest.approx(1.0, abs=1e-14)
    alpha, exists = solved_alpha(m, HOME, 0.0, 0.0, home_side(m))
    assert abs(alpha) < 1e-14
    assert exists > 0.0


def test_alpha_is_one_of_two_roots_that_a_scan_finds() -> None:
    random = np.random.default_rng(2)
    turns = np.linspace(-math.pi, math.pi, 4001)
    met = 0
    for _ in range(100):
        m = random_machine(random)
        position, beta, gamma = random.normal(size=3), *random.uniform(-1.5, 1.5, 2)
        values = constraint(m, position, rotation(turns, beta, gamma))
        places = np.flatnonzero(np.diff(np.sign(values)))
        roots = []
        for side in (1.0, -1.0):
            alpha, exists = solved_alpha(m, position, beta, gamma, side)
            assert (exists > 0.0) == (len(places) == 2)
            if exists > 0.0:
                roots.append(float(alpha))
                # the constraint falls through the root on the side +1
                at = float(np.interp(alpha, turns, np.gradient(values, turns)))
                assert np.sign(at) == -side or exists < 1e-3
        scanned = turns[places] - values[places] * np.diff(turns)[0] / np.diff(values)[places]
        assert np.allclose(np.sort(roots), scanned, atol=1e-3)
        met += len(roots) // 2
    assert 20 < met < 100


def test_rows_of_the_jacobian_are_rates_of_lengths_and_of_the_constraint() -> None:
    random = np.random.default_rng(3)
    m = random_machine(random)
    position, angles = random.normal(size=3), random.normal(size=3)
    matrix = rotation(*angles)
    rows = jacobian(m, position, matrix)
    for column in range(6):
        move = np.eye(6)[column]

        def moved(time: Array, move: Array = move) -> Array:
            turn = Rotation.from_rotvec(time[:, None] * move[3:]).as_matrix()
            place = position + time[:, None] * move[:3], turn @ matrix
            return np.column_stack([limb_lengths(m, *place), -constraint(m, *place)])

        rates = derivatives(moved, np.array([1e-2]))[0][0]
        assert np.abs(rates - rows[:, column]).max() < 1e-10


def test_largest_force_is_that_of_the_worst_unit_wrench() -> None:
    random = np.random.default_rng(4)
    matrices = random.normal(size=(20, 6, 6))
    wrenches = random.normal(size=(2000, 6))
    wrenches /= np.linalg.norm(wrenches, axis=1, keepdims=True)
    found = conditioning(matrices)
    for matrix, force, least in zip(matrices, found.force, found.least, strict=True):
        forces = np.abs(np.linalg.solve(matrix.T, -wrenches.T))[:5].max()
        assert forces <= force
        assert forces > 0.7 * force
        assert force <= 1.0 / least


def test_means_along_a_line_are_those_of_a_plain_rule() -> None:
    task = Task(
        x_min=0.1, x_max=0.1, y_min=-0.05, y_max=-0.05, beta_min=5.0, beta_max=5.0,
        gamma_min=-8.0, gamma_max=-8.0, z_min=0.9, z_max=1.1,
    )  # fmt: skip
    m, length = task.machine(0.8, 0.5), task.length(0.5)

    def lci(z: float) -> float:
        place = np.array([[0.1, -0.05, z, math.radians(5.0), math.radians(-8.0)]])
        poses = poses_of(task, m, place)
        assert np.all(poses.margins >= 0.0)
        lines = homogeneous(jacobian(m, poses.position, poses.matrix), length)
        return float(conditioning(lines).lci[0])

    mean = integrate.quad(lci, 0.9, 1.1)[0] / 0.2
    found = box_indices(task, 0.8, 0.5, points=256, shifts=8)
    assert found["usable_share"] == (1.0, 0.0)
    assert found["gci"][0] == pytest.approx(mean, abs=5.0 * found["gci"][1] + 1e-12)
    assert found["gci"][1] < 1e-3 * mean


def test_points_are_spread_evenly() -> None:
    for dimension in (3, 5):
        points = kronecker(4096, dimension, np.full(dimension, 0.3))
        assert points.min() >= 0.0
        assert points.max() < 1.0
        assert np.abs(points.mean(axis=0) - 0.5).max() < 2e-3
        # a fourteenth of what is at random in an eighth or a 32nd of the cube
        share = np.mean(np.all(points < 0.5, axis=1))
        assert share == pytest.approx(0.5**dimension, abs=3e-3)
    corner = mapped(Task(x_min=-0.5), np.zeros((1, 5)))[0]
    assert np.allclose(corner, [-0.5, -0.25, 0.85, -math.radians(20.0), -math.radians(20.0)])


@pytest.mark.parametrize("case", ["standard", "narrow limits", "tilted axis", "offset"])
def test_reference_values_are_what_fewer_points_give(case: str) -> None:
    r_a, r_b, options = CASES[case]
    task = Task(**options)  # type: ignore[arg-type]
    rough: Found = box_indices(task, r_a, r_b, THRESHOLDS, points=2048, shifts=12, seed=9)
    rough["workspace_volume"] = workspace_volume(task, r_a, r_b, points=4096, shifts=12, seed=9)
    for name, (value, error) in rough.items():
        exact, doubt = REFERENCE[case][name]
        assert doubt < 0.5 * error
        assert value == pytest.approx(exact, abs=5.0 * math.hypot(error, doubt)), name


def test_extremes_are_worse_than_any_other_pose_and_home() -> None:
    r_a, r_b, options = CASES["narrow limits"]
    task = Task(**options)  # type: ignore[arg-type]
    found = extremes(task, r_a, r_b, points=5000, starts=3)
    reference = REFERENCE["narrow limits"]
    for name, value in found._asdict().items():
        assert value == pytest.approx(reference[name][0], rel=1e-3)
    home = home_indices(task, r_a, r_b)
    assert 0.0 < found.least_singular_value < float(home.least)
    assert found.largest_limb_force > float(home.force)
    m = task.machine(r_a, r_b)
    poses = poses_of(task, m, mapped(task, kronecker(50000, 5, np.full(5, 0.7))))
    within = np.all(poses.margins >= 0.0, axis=1)
    lines = homogeneous(jacobian(m, poses.position, poses.matrix)[within], task.length(r_b))
    values = conditioning(lines)
    assert found.least_singular_value <= values.least.min()
    assert found.largest_limb_force >= values.force.max()
