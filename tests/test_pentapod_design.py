"""One pentapod: slacks, usable poses and indices against formulae written out here."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fivebar_atlas import Pentapod, mechanisms
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.settings import SweepSettings

MACHINE = Pentapod.from_radii(459.1, 400.0, 100.0, unit="mm")
DESIGN = Pentapod.from_radii(1.0, 400.0 / 459.1, 100.0 / 459.1)


def random_poses(count: int, seed: int = 1) -> np.ndarray:
    random = np.random.default_rng(seed)
    least = np.array([-0.3, -0.3, 0.7, 0.0, -0.4, -0.4])
    greatest = np.array([0.3, 0.3, 1.3, 0.0, 0.4, 0.4])
    return random.uniform(least, greatest, (count, 6))


def rotation(alpha: float, beta: float, gamma: float) -> np.ndarray:
    ca, sa = math.cos(alpha), math.sin(alpha)
    cb, sb = math.cos(beta), math.sin(beta)
    cg, sg = math.cos(gamma), math.sin(gamma)
    about_z = np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]])
    about_y = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    about_x = np.array([[1, 0, 0], [0, cg, -sg], [0, sg, cg]])
    return about_z @ about_y @ about_x


def plain_limbs(pose: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return lengths, directions in the base and in the platform, by the paper's equations."""
    turned = rotation(*pose[3:])
    vectors = pose[:3] + DESIGN.geometry.platform @ turned.T - DESIGN.geometry.base
    lengths = np.sqrt((vectors**2).sum(axis=1))
    directions = vectors / lengths[:, None]
    return lengths, directions, directions @ turned


def plain_determinant(pose: np.ndarray) -> float:
    turned = rotation(*pose[3:])
    _, directions, _ = plain_limbs(pose)
    arms = DESIGN.geometry.platform @ turned.T
    axis = turned @ DESIGN.geometry.axis
    rows = [np.concatenate([n, np.cross(r, n)]) for n, r in zip(directions, arms, strict=True)]
    rows.append(np.concatenate([axis, np.cross(DESIGN.geometry.base[4] - pose[:3], axis)]))
    return float(np.linalg.det(rows))


def plain_is_usable(pose: np.ndarray) -> bool:
    """Tell what the definition says of a pose whose α is known."""
    home = np.array(DESIGN.home)
    lengths, outer, inner = plain_limbs(pose)
    home_lengths, home_directions, _ = plain_limbs(home)
    shares = lengths / home_lengths
    turns = np.degrees(
        [
            np.arccos(np.clip((each * home_directions).sum(axis=1), -1.0, 1.0))
            for each in (outer, inner)
        ]
    )
    sign = plain_determinant(pose) * plain_determinant(home)
    return bool(
        (shares >= 0.7).all()
        and (shares <= 1.3).all()
        and (turns <= 45.0).all()
        and abs(pose[3]) <= math.radians(30.0)
        and sign > 0.0
    )


def test_alpha_is_solved_on_the_branch_of_home() -> None:
    poses = DESIGN.solve_alpha(random_poses(300))
    there = np.isfinite(poses[:, 3])
    assert there.sum() > 200
    assert np.abs(DESIGN.constraint_residual(poses[there])).max() < 1e-13

    def slope(pose: np.ndarray) -> float:
        ends = np.array([pose, pose])
        ends[:, 3] += [-1e-6, 1e-6]
        before, after = DESIGN.constraint_residual(ends)
        return float(after - before)

    home = slope(np.array(DESIGN.home))
    assert all(slope(pose) * home >= 0.0 for pose in poses[there])
    # where there is none, no α of a fine scan closes the joint
    for pose in random_poses(300)[~there][:20]:
        scan = np.repeat(pose[None], 721, axis=0)
        scan[:, 3] = np.linspace(-math.pi, math.pi, 721)
        residuals = DESIGN.constraint_residual(scan)
        assert (residuals > 0.0).all() or (residuals < 0.0).all()


def test_usable_poses_are_those_of_the_definition() -> None:
    poses = DESIGN.solve_alpha(random_poses(2000, seed=2))
    poses = poses[np.isfinite(poses[:, 3])]
    expected = [plain_is_usable(pose) for pose in poses]
    assert 100 < sum(expected) < len(poses) - 100
    assert DESIGN.is_usable(poses).tolist() == expected


def test_slacks_say_which_limit_is_passed() -> None:
    assert len(DESIGN.limits) == DESIGN.slacks(np.array([0.0, 0.0, 1.0]), (0.0, 0.0)).shape[-1]
    names = [limit.name for limit in DESIGN.limits]

    def passed(*position: float) -> set[str]:
        slacks = DESIGN.slacks(np.array(position), (0.0, 0.0))
        return {name for name, slack in zip(names, slacks, strict=True) if slack < 0.0}

    assert passed(0.0, 0.0, 1.0) == set()
    assert {"longest l_1", "longest l_5"} <= passed(0.0, 0.0, 1.6)
    assert {"shortest l_1"} <= passed(0.0, 0.0, 0.3)
    assert "base plane" in passed(0.0, 0.0, -0.1)


def test_volume_of_the_atlas_is_where_slacks_are_positive() -> None:
    """The evaluator's kernels against these formulae in NumPy."""
    settings = SweepSettings("pentapod", "radii", 2, ("home",), (), 1e-2)
    mechanism = mechanisms.get("pentapod")
    results = mechanism.evaluate(np.array([[400.0, 100.0]]) / 459.1, settings)
    lower, upper = DESIGN.reach()
    points = lower + (upper - lower) * np.random.default_rng(4).random((60_000, 3))
    share = np.mean(DESIGN.slacks(points, (0.0, 0.0)).min(axis=-1) >= 0.0)
    box = float(np.prod(upper - lower))
    deviation = 4.0 * box * math.sqrt(share * (1.0 - share) / len(points))
    volume, error = results["workspace_volume"][0], results["workspace_volume_error"][0]
    assert abs(volume - share * box) < deviation + error


def test_indices_are_those_of_the_definition_and_scale() -> None:
    poses = DESIGN.solve_alpha(random_poses(50, seed=3))
    poses = poses[np.isfinite(poses[:, 3])]
    g = DESIGN.jacobian(poses)
    sizes = np.sqrt(np.linalg.eigvalsh(np.swapaxes(g, -1, -2) @ g))
    np.testing.assert_allclose(DESIGN.least_singular_value(poses), sizes[:, 0], rtol=1e-8)
    np.testing.assert_allclose(DESIGN.lci(poses), sizes[:, 0] / sizes[:, -1], rtol=1e-8)
    columns = np.linalg.norm(np.linalg.inv(g), axis=1)[:, :5]
    np.testing.assert_allclose(DESIGN.largest_limb_force(poses), columns.max(axis=1), rtol=1e-9)
    scaled = poses * [459.1, 459.1, 459.1, 1.0, 1.0, 1.0]
    np.testing.assert_allclose(MACHINE.lci(scaled), DESIGN.lci(poses), rtol=1e-9)
    np.testing.assert_allclose(
        MACHINE.inverse_displacement(scaled).lengths,
        459.1 * DESIGN.inverse_displacement(poses).lengths,
    )
    # no wrench of size one asks for more
    random = np.random.default_rng(5)
    wrenches = random.normal(size=(400, 6))
    wrenches /= np.linalg.norm(wrenches, axis=1)[:, None]
    loads = wrenches * np.repeat([1.0, DESIGN.characteristic_length], 3)
    for pose in poses[:5]:
        forces = np.abs(DESIGN.joint_forces(np.tile(pose, (400, 1)), loads)[:, :5])
        largest = float(DESIGN.largest_limb_force(pose))
        assert forces.max() <= largest * (1.0 + 1e-12)
        assert forces.max() > 0.5 * largest


def test_singular_pose_has_no_finite_force() -> None:
    even = Pentapod.from_radii(1.0, 1.0, 0.5, options=(("base_angle", 72.0),))
    assert math.isfinite(float(even.largest_limb_force(even.home)))
    from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry

    angles = 2.0 * math.pi / 5.0 * np.arange(5)
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(5)])
    turned = np.column_stack([np.cos(angles + 0.6), np.sin(angles + 0.6), np.zeros(5)])
    gap = circle[4] - 0.5 * turned[4]
    geometry = PentapodGeometry(circle, 0.5 * turned, np.array([-gap[1], gap[0], 0.0]))
    singular = Pentapod(geometry)
    assert math.isinf(float(singular.largest_limb_force(singular.home)))
    assert singular.pose(singular.home).largest_limb_force == math.inf


def test_pose_that_the_joint_does_not_allow_is_refused_with_the_nearest() -> None:
    torn = (30.0, 20.0, 480.0, 0.0, 0.1, 0.1)
    residual = abs(float(MACHINE.constraint_residual(torn)))
    with pytest.raises(InputError) as caught:
        MACHINE.pose(torn)
    message = str(caught.value)
    assert f"{residual:.6g} mm apart" in message
    assert "the nearest pose is" in message
    nearest = message.split("the nearest pose is ")[1]
    lengths, angles = nearest.removesuffix(" deg").split(" mm, ")
    pose = [float(each) for each in lengths.split()]
    pose += [math.radians(float(each)) for each in angles.split()]
    assert abs(float(MACHINE.constraint_residual(pose))) < 1e-5


def test_coordinate_is_solved_for_near_its_value() -> None:
    for name in ("x", "z", "alpha", "beta"):
        solved = MACHINE.solved((30.0, 20.0, 480.0, 0.0, 0.05, 0.05), name)
        assert abs(float(MACHINE.constraint_residual(solved))) < 1e-10
        MACHINE.pose(solved)
    with pytest.raises(UnknownNameError):
        MACHINE.solved(MACHINE.home, "delta")
    with pytest.raises(InputError, match="the revolute joint allows none"):
        MACHINE.solved((30.0, 20.0, 480.0, 0.0, 0.0, 0.0), "z")


@pytest.mark.parametrize(
    ("lengths", "name"), [((0.0, 1, 1), "H"), ((1, -1, 1), "r_a"), ((1, 1, math.nan), "r_b")]
)
def test_lengths_that_make_no_machine(lengths: tuple[float, ...], name: str) -> None:
    with pytest.raises(InputError, match=f"^{name}: "):
        Pentapod.from_radii(*lengths)


def test_joints_that_do_not_allow_home_are_refused() -> None:
    from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry

    tilted = PentapodGeometry(DESIGN.geometry.base, DESIGN.geometry.platform, np.array([1.0, 0, 1]))
    with pytest.raises(InputError, match="joints that allow the home pose"):
        Pentapod(tilted)
