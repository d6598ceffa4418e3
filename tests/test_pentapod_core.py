"""The core of the pentapod against finite differences, virtual work and SciPy's rotations."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from fivebar_atlas.errors import (
    InputError,
    InvalidPoseError,
    SingularPoseError,
    UnknownNameError,
)
from fivebar_atlas.mechanisms.pentapod import (
    forward,
    geometry,
    jacobian,
    kinematics,
    rotations,
    singularity,
    statics,
)
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.singularity import Dependency, FreeMotion

Array = npt.NDArray[np.float64]

COUNT = 1000
# Central differences of sixth order: steps, and weights of the first and the second derivative.
STEPS = np.arange(-3, 4)
FIRST = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60.0
SECOND = np.array([2, -27, 270, -490, 270, -27, 2]) / 180.0


def turn(angles: Array) -> Array:
    """Return SciPy's matrices of α about Z, β about the turned Y and γ about the turned X."""
    return Rotation.from_euler("ZYX", angles).as_matrix()


def dot(one: Array, other: Array) -> Array:
    return np.sum(one * other, axis=-1)


@dataclasses.dataclass
class Motions:
    """Random geometries, each with a motion in which the fifth limb is always perpendicular.

    The orientation is exp(t ω + t² ε / 2) R_0, and p = q + s n6 with q a parabola in t and s
    such that (A_5 - p)·n6 = B_5·n6; the derivatives at t = 0 are exact.
    """

    base: Array
    platform: Array
    axis: Array
    start: Array
    angles: Array
    linear: Array
    bend: Array
    angular: Array
    angular_bend: Array

    def pose(self, time: float) -> tuple[Array, Array]:
        """Return p and R of all motions."""
        vectors = time * self.angular + 0.5 * time**2 * self.angular_bend
        matrices = Rotation.from_rotvec(vectors).as_matrix() @ turn(self.angles)
        axes = np.einsum("nij,nj->ni", matrices, self.axis)
        free = self.start + time * self.linear + 0.5 * time**2 * self.bend
        slide = dot(self.base[:, 4] - free, axes) - dot(self.platform[:, 4], self.axis)
        return free + slide[:, None] * axes, matrices

    def lengths(self, time: float) -> Array:
        """Return the limb lengths of all motions."""
        position, matrices = self.pose(time)
        ends = position[:, None] + np.einsum("nij,nkj->nki", matrices, self.platform)
        return np.linalg.norm(ends - self.base, axis=-1)

    def derivatives(self) -> tuple[Array, Array]:
        """Return the twists and the accelerations at t = 0."""
        axes = np.einsum("nij,nj->ni", turn(self.angles), self.axis)
        first = np.cross(self.angular, axes)
        second = np.cross(self.angular_bend, axes) + np.cross(self.angular, first)
        reach = self.base[:, 4] - self.start
        slide = dot(reach, axes) - dot(self.platform[:, 4], self.axis)
        slide1 = dot(reach, first) - dot(self.linear, axes)
        slide2 = dot(reach, second) - 2.0 * dot(self.linear, first) - dot(self.bend, axes)
        v = self.linear + slide1[:, None] * axes + slide[:, None] * first
        a = self.bend + slide2[:, None] * axes + slide[:, None] * second
        a += 2.0 * slide1[:, None] * first
        return np.hstack([v, self.angular]), np.hstack([a, self.angular_bend])

    def poses(self) -> Array:
        """Return the poses at t = 0."""
        return np.hstack([self.pose(0.0)[0], self.angles])

    def geometries(self) -> list[PentapodGeometry]:
        """Return the geometries."""
        parts = zip(self.base, self.platform, self.axis, strict=True)
        return [PentapodGeometry(*each) for each in parts]


@pytest.fixture(scope="module")
def motions() -> Motions:
    random = np.random.default_rng(7)
    found = Motions(
        base=random.normal(size=(COUNT, 5, 3)),
        platform=0.5 * random.normal(size=(COUNT, 5, 3)),
        axis=Rotation.random(COUNT, random_state=3).as_matrix()[:, 0],
        start=random.normal((0.0, 0.0, 4.0), 1.0, (COUNT, 3)),
        angles=random.uniform(-1.2, 1.2, (COUNT, 3)),
        linear=0.3 * random.normal(size=(COUNT, 3)),
        bend=0.3 * random.normal(size=(COUNT, 3)),
        angular=0.3 * random.normal(size=(COUNT, 3)),
        angular_bend=0.3 * random.normal(size=(COUNT, 3)),
    )
    # a difference quotient is good only where limbs are not short
    assert np.mean(found.lengths(0.0).min(axis=1) > 0.5) > 0.95
    return found


@pytest.fixture(scope="module")
def geometries(motions: Motions) -> list[PentapodGeometry]:
    return motions.geometries()


@pytest.fixture(scope="module")
def jacobians(motions: Motions, geometries: list[PentapodGeometry]) -> Array:
    return each(jacobian.jacobian, geometries, motions.poses())


def each(
    function: Callable[..., Array], geometries: list[PentapodGeometry], *arrays: Array
) -> Array:
    """Return a function of one geometry and its rows, for all of them."""
    return np.array([function(*one) for one in zip(geometries, *arrays, strict=True)])


def tangents(motions: Motions) -> Array:
    """Return a basis of the allowed twists, by the constraint's differences, shape (n, 6, 5)."""
    step = 1e-3
    position, matrices = motions.pose(0.0)
    gradient = np.zeros((COUNT, 6))
    for column in range(6):
        for k, weight in zip(STEPS, FIRST, strict=True):
            move = np.zeros(6)
            move[column] = k * step
            moved = Rotation.from_rotvec(move[3:]).as_matrix() @ matrices
            axes = np.einsum("nij,nj->ni", moved, motions.axis)
            ends = position + move[:3] + np.einsum("nij,nj->ni", moved, motions.platform[:, 4])
            gradient[:, column] += weight / step * dot(motions.base[:, 4] - ends, axes)
    return np.linalg.svd(gradient[:, None, :])[2].transpose(0, 2, 1)[:, :, 1:]


def assert_close(ours: Array, theirs: Array, tolerance: float) -> None:
    """Assert equality to a tolerance relative to each row, and absolute below 1."""
    size = np.maximum(1.0, np.abs(theirs).max(axis=-1, keepdims=True))
    assert np.max(np.abs(ours - theirs) / size) < tolerance


# Geometry


def test_mobility_is_that_of_eq_1_and_the_number_of_motions_that_all_joints_allow() -> None:
    assert geometry.mobility() == 5
    # a Gough-Stewart platform of six SPS limbs, and a planar five-bar
    assert geometry.mobility(14, (1,) * 6 + (3,) * 12, redundant_freedoms=6) == 6
    assert geometry.mobility(5, (1,) * 5, common_constraints=3, redundant_freedoms=0) == 2
    # the platform has five, and the four SPS limbs spin
    joints = (1,) * 5 + (3,) * 9 + (1,)
    assert geometry.mobility(12, joints, redundant_freedoms=0) == 5 + 4


def test_default_geometry_is_on_circles_and_starts_in_a_regular_allowed_pose() -> None:
    ours = PentapodGeometry.from_radii(400.0, 100.0)
    assert np.allclose(np.linalg.norm(ours.base, axis=1), 400.0, rtol=1e-14)
    assert np.allclose(np.linalg.norm(ours.platform, axis=1), 100.0, rtol=1e-14)
    assert ours.base[0].tolist() == [400.0, 0.0, 0.0]
    # four a quarter turn, five a fifth of a turn apart
    sides = np.linalg.norm(ours.base[1:] - np.roll(ours.base[1:], 1, axis=0), axis=1)
    assert np.allclose(sides, 400.0 * math.sqrt(2.0), rtol=1e-14)
    sides = np.linalg.norm(ours.platform - np.roll(ours.platform, 1, axis=0), axis=1)
    assert np.allclose(sides, 200.0 * math.sin(math.pi / 5.0), rtol=1e-14)
    assert math.isclose(math.atan2(*ours.platform[0, 1::-1]), math.pi / 5.0)
    home = np.zeros((3, 6))
    home[:, 2] = [460.0, 520.0, 580.0]
    kinematics.check_poses(ours, home, 1e-14)
    near = singularity.singularity(ours, home, ours.platform_radius)
    assert near.inverse_condition_number.min() > 0.01
    assert not singularity.is_always_singular(ours)
    assert math.isclose(ours.platform_radius, 100.0)
    assert math.isclose(PentapodGeometry.from_radii(400.0, 100.0, offset=-250.0).base[0, 0], -250.0)


@pytest.mark.parametrize("position_angle", [0.0, 0.3, math.pi / 5.0, 1.0])
def test_five_joints_uniform_on_both_circles_are_singular_at_the_start(
    position_angle: float,
) -> None:
    fifths = 2.0 * math.pi / 5.0 * np.arange(5)
    base = 4.0 * np.column_stack([np.cos(fifths), np.sin(fifths), 0.0 * fifths])
    ours = PentapodGeometry.from_radii(4.0, 1.0, position_angle)
    gap = base[4] - ours.platform[4]
    pentagon = PentapodGeometry(base, ours.platform, np.array([-gap[1], gap[0], 0.0]))
    at = singularity.singularity(pentagon, [0.0, 0.0, 5.0, 0.0, 0.0, 0.0], 1.0)
    assert at.rank == 4
    assert at.dependency == Dependency.LIMBS
    assert at.free_motion == FreeMotion.SEVERAL
    assert abs(at.determinant) < 1e-14
    assert not singularity.is_always_singular(pentagon)


def test_axis_where_the_last_joints_coincide_is_the_tangent() -> None:
    ours = PentapodGeometry.from_radii(1.0, 1.0, 7.0 * math.pi / 4.0 - 8.0 * math.pi / 5.0)
    assert np.allclose(ours.base[4], ours.platform[4], atol=1e-14)
    assert abs(ours.axis @ ours.platform[4]) < 1e-15
    assert abs(ours.axis[2]) < 1e-15


def test_geometry_keeps_its_own_numbers() -> None:
    source = PentapodGeometry.from_radii(4.0, 1.0)
    base, axis = source.base.copy(), np.array([0.0, 3e200, 4e200])
    ours = PentapodGeometry(base, source.platform, axis)
    base[0] = 0.0
    assert np.array_equal(ours.base, source.base)
    assert np.allclose(ours.axis, [0.0, 0.6, 0.8], rtol=1e-15)
    with pytest.raises(ValueError, match="read-only"):
        ours.base[0, 0] = 1.0
    doubled = source.scaled(2.0)
    assert np.array_equal(doubled.base, 2.0 * source.base)
    assert np.array_equal(doubled.platform, 2.0 * source.platform)
    assert doubled.size == 2.0 * source.size


LINE = np.outer(np.arange(5.0), [1.0, 2.0, -1.0])


@pytest.mark.parametrize(
    ("part", "value", "message"),
    [
        ("base", np.zeros((4, 3)), r"base: .*shape \(5, 3\)"),
        ("base", "five", r"base: 'five' .*shape \(5, 3\)"),
        ("platform", np.full((5, 3), math.nan), "platform: .*finite numbers"),
        ("base", np.vstack([np.eye(4, 3), [0.0, 1.0, 0.0]]), "A_2 and A_5 in different places"),
        ("platform", np.ones((5, 3)), "B_1 and B_2 in different places"),
        ("base", LINE + 3.0, "base: .*not all in one line$"),
        ("axis", np.zeros(3), "axis: .*a vector that has a length"),
        ("axis", [1.0, math.inf, 0.0], r"axis: .*finite numbers, shape \(3,\)"),
    ],
)
def test_bad_geometries_are_named(part: str, value: npt.ArrayLike, message: str) -> None:
    source = PentapodGeometry.from_radii(4.0, 1.0)
    parts = {"base": source.base, "platform": source.platform, "axis": source.axis, part: value}
    with pytest.raises(InputError, match=message):
        PentapodGeometry(**parts)


def test_platform_in_a_line_is_refused_only_along_the_axis() -> None:
    base = PentapodGeometry.from_radii(4.0, 1.0).base
    with pytest.raises(InputError, match=r"platform: .*not all in one line along n6"):
        PentapodGeometry(base, LINE, np.array([-1.0, -2.0, 1.0]))
    line = PentapodGeometry(base, LINE, np.array([-1.0, -2.0, 2.0]))
    assert not singularity.is_always_singular(line)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"r_a": 0.0}, "r_a"),
        ({"r_b": -1.0}, "r_b"),
        ({"r_b": math.nan}, "r_b"),
        ({"position_angle": math.inf}, "position_angle"),
        ({"offset": math.nan}, "offset"),
        ({"base_angle": math.nan}, "base_angle"),
        ({"base_angle": 0.0}, "base"),
        ({"axis": [0.0, 0.0, 0.0]}, "axis"),
    ],
)
def test_bad_radii_are_named(arguments: dict[str, float], name: str) -> None:
    with pytest.raises(InputError) as caught:
        PentapodGeometry.from_radii(**{"r_a": 4.0, "r_b": 1.0, **arguments})
    assert caught.value.name == name


@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan])
def test_a_scale_is_above_0(factor: float) -> None:
    with pytest.raises(InputError, match="factor"):
        PentapodGeometry.from_radii(4.0, 1.0).scaled(factor)


# Rotations


def test_rotations_are_those_of_scipy() -> None:
    random = np.random.default_rng(1)
    angles = random.uniform(-math.pi, math.pi, (COUNT, 3))
    matrices = rotations.rotation_matrices(angles)
    assert np.max(np.abs(matrices - turn(angles))) < 1e-14
    canonical = rotations.euler_angles(matrices)
    assert np.abs(canonical[:, 1]).max() <= math.pi / 2.0
    assert np.max(np.abs(turn(canonical) - matrices)) < 1e-14
    assert np.max(np.abs(rotations.euler_angles(matrices, angles) - angles)) < 1e-11
    more = angles + 2.0 * math.pi * random.integers(-3, 4, (COUNT, 3))
    assert np.max(np.abs(rotations.euler_angles(matrices, more) - more)) < 1e-11
    vectors = random.normal(size=(COUNT, 3)) * 10.0 ** random.uniform(-9, 0.5, (COUNT, 1))
    turned = rotations.turned_by(matrices, vectors)
    assert np.max(np.abs(turned - Rotation.from_rotvec(vectors).as_matrix() @ matrices)) < 1e-14


def test_angles_at_gimbal_lock_give_the_rotation_back() -> None:
    angles = np.array([[0.3, math.pi / 2.0, 0.5], [0.3, -math.pi / 2.0, 0.5]])
    matrices = rotations.rotation_matrices(angles)
    free = rotations.euler_angles(matrices)
    assert free[:, 0].tolist() == [0.0, 0.0]
    assert np.max(np.abs(turn(free) - matrices)) < 1e-15
    assert np.max(np.abs(rotations.euler_angles(matrices, angles) - angles)) < 1e-15
    with pytest.raises(InputError, match=r"beta: .*±90 degrees"):
        rotations.euler_rates(angles, np.ones((2, 3)))


def test_angular_velocity_and_acceleration_are_those_of_the_matrices() -> None:
    random = np.random.default_rng(2)
    angles = random.uniform(-math.pi, math.pi, (COUNT, 3))
    rates, accelerations = random.normal(size=(2, COUNT, 3))
    step = 1e-2

    def matrix(time: float) -> Array:
        return turn(angles + time * rates + 0.5 * time**2 * accelerations)

    samples = [matrix(step * k) for k in STEPS]
    first = sum(w * s for w, s in zip(FIRST, samples, strict=True)) / step
    second = sum(w * s for w, s in zip(SECOND, samples, strict=True)) / step**2
    transposed = samples[3].transpose(0, 2, 1)
    # Ṙ Rᵀ = ω̂ and R̈ Rᵀ = ε̂ + ω̂²
    spin = first @ transposed
    bend = second @ transposed - spin @ spin
    omega = rotations.angular_velocity(angles, rates)
    epsilon = rotations.angular_acceleration(angles, rates, accelerations)
    assert_close(omega, np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1), 1e-8)
    assert_close(epsilon, np.stack([bend[:, 2, 1], bend[:, 0, 2], bend[:, 1, 0]], axis=1), 1e-6)
    back = rotations.euler_rates(angles, omega)
    assert np.max(np.abs(back - rates) * np.abs(np.cos(angles[:, 1:2]))) < 1e-13


# Poses


def test_lengths_directions_and_residuals(
    motions: Motions, geometries: list[PentapodGeometry]
) -> None:
    poses = motions.poses()
    found = [kinematics.inverse_displacement(*one) for one in zip(geometries, poses, strict=True)]
    lengths = np.array([one.lengths for one in found])
    assert_close(lengths, motions.lengths(0.0), 1e-14)
    directions = np.array([one.directions for one in found])
    arms = np.array([one.arms for one in found])
    ends = motions.base + lengths[..., None] * directions
    assert np.max(np.abs(ends - poses[:, None, :3] - arms)) < 1e-13
    residuals = each(kinematics.constraint_residual, geometries, poses)
    assert np.abs(residuals).max() < 1e-13
    # the fifth limb is perpendicular to the axis
    axes = np.einsum("nij,nj->ni", turn(motions.angles), motions.axis)
    assert np.abs(dot(directions[:, 4], axes)).max() < 1e-12


def test_solving_the_constraint_finds_all_solutions_and_no_others() -> None:
    random = np.random.default_rng(4)
    counts = {name: set() for name in kinematics.COORDINATES}
    for _ in range(40):
        ours = PentapodGeometry(*random.normal(size=(2, 5, 3)), random.normal(size=3))
        poses = random.normal(size=(5, 6))
        for column, name in enumerate(kinematics.COORDINATES):
            found = kinematics.solve_constraint(ours, poses, name)
            counts[name] |= set(found.count.tolist())
            assert not found.free.any()
            for pose, solved, count in zip(poses, found.poses, found.count, strict=True):
                assert np.isnan(solved[count:, column]).all()
                good = solved[:count]
                others = np.arange(6) != column
                assert np.array_equal(good[:, others], np.tile(pose[others], (count, 1)))
                assert np.abs(kinematics.constraint_residual(ours, good)).max(initial=0.0) < 1e-12
                steps = np.abs(good[:, column] - pose[column])
                assert np.array_equal(steps, np.sort(steps))
                if column < 3:
                    continue
                assert steps.max(initial=0.0) <= math.pi
                # sign changes over a turn, counted on a grid
                turned = np.tile(pose, (2001, 1))
                turned[:, column] += np.linspace(-math.pi, math.pi, 2001)
                signs = np.sign(kinematics.constraint_residual(ours, turned))
                changes = np.count_nonzero(np.diff(signs))
                assert changes == count or (count == 2 and abs(np.diff(good[:, column])) < 0.01)
    assert counts["x"] == counts["z"] == {1}
    assert counts["alpha"] == counts["beta"] == counts["gamma"] == {0, 2}


def test_coordinates_that_the_constraint_does_not_see() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    home = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])
    free = kinematics.solve_constraint(ours, home, "z")
    assert bool(free.free)
    assert free.count == 1
    assert np.array_equal(free.poses[0], home)
    torn = home + 0.1 * np.eye(6)[0]
    none = kinematics.solve_constraint(ours, torn, "z")
    assert not bool(none.free)
    assert none.count == 0
    assert np.isnan(none.poses[:, 2]).all()
    # at the largest residual over a turn, two solutions are one
    upright = PentapodGeometry(ours.base, ours.platform + 3.0 * np.eye(3)[1], np.eye(3)[1])
    pose = np.zeros(6)
    pose[:3] = upright.base[4] - upright.platform[4, 1] * np.eye(3)[0] - 3.0 * np.eye(3)[2]
    double = kinematics.solve_constraint(upright, pose, "alpha")
    assert double.count == 1
    assert abs(kinematics.constraint_residual(upright, double.poses[0])) < 1e-13


def distance(pose: Array, positions: Array, turned: Rotation, length: float) -> Array:
    """Return how far others are from a pose, a radian being as far as this length."""
    angles = (turned * Rotation.from_euler("ZYX", pose[3:]).inv()).magnitude()
    return np.hypot(np.linalg.norm(positions - pose[:3], axis=-1), length * angles)


def test_nearest_valid_pose_is_valid_and_nearer_than_any_other() -> None:
    random = np.random.default_rng(5)
    for _ in range(60):
        ours = PentapodGeometry(*random.normal(size=(2, 5, 3)), random.normal(size=3))
        poses = random.uniform(-2.0, 2.0, (3, 6))
        length = float(random.uniform(0.2, 3.0))
        nearest = kinematics.nearest_valid_pose(ours, poses, length)
        assert np.abs(kinematics.constraint_residual(ours, nearest)).max() < 1e-13
        for index in range(3):
            pose, turned = poses[index], Rotation.from_euler("ZYX", nearest[index, 3:])
            best = distance(pose, nearest[index, :3], turned, length)
            # valid poses all over, and close to the one found
            close = Rotation.from_rotvec(1e-2 * random.normal(size=(200, 3))) * turned
            far = Rotation.random(200, random_state=int(random.integers(1000)))
            for others in (close, far):
                axes = others.apply(ours.axis.copy())
                gap = (ours.base[4] - pose[:3]) @ axes.T - ours.platform[4] @ ours.axis
                positions = pose[:3] + gap[:, None] * axes
                assert distance(pose, positions, others, length).min() >= best - 1e-12
    kept = kinematics.nearest_valid_pose(ours, nearest, length)
    assert np.max(np.abs(kept - nearest)) < 1e-12


def test_nearest_valid_pose_along_the_axis() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0, axis=[1.0, 0.0, 0.0])
    pose = np.concatenate([ours.base[4] - [3.0, 0.0, 0.0], np.zeros(3)])
    for length in (0.01, 1.0, 100.0):
        nearest = kinematics.nearest_valid_pose(ours, pose, length)
        assert abs(kinematics.constraint_residual(ours, nearest)) < 1e-14
        # moving alone is off by 3 - B_5x
        away = np.linalg.norm(nearest[:3] - pose[:3])
        assert away <= 3.0 - ours.platform[4, 0] + 1e-12


def test_poses_that_are_not_allowed() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    poses = np.zeros((2, 3, 6))
    poses[..., 2] = 5.0
    poses[1, 2, :2] += 0.1 * ours.axis[:2]
    with pytest.raises(InvalidPoseError, match=r"pose\[1, 2\]: .* -0\.1 apart") as caught:
        kinematics.check_poses(ours, poses)
    assert caught.value.index == (1, 2)
    assert math.isclose(caught.value.residual, -0.1)
    for function, rows in (
        (jacobian.forward_velocity, 5),
        (jacobian.inverse_velocity, 6),
        (statics.joint_forces, 6),
        (statics.balanced_load, 6),
    ):
        with pytest.raises(InvalidPoseError):
            function(ours, poses, np.zeros(rows))
    assert kinematics.check_poses(ours, poses, 0.1).shape == (2, 3, 6)


def test_bad_poses_and_inputs_are_named() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    home = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"pose: \(5,\) .*shape \(\.\.\., 6\)"):
        kinematics.inverse_displacement(ours, np.zeros(5))
    with pytest.raises(InputError, match="pose: 'home'"):
        jacobian.jacobian(ours, "home")
    with pytest.raises(InputError, match=r"pose\[1, 4\]: nan .*a finite number"):
        kinematics.constraint_residual(ours, [home, [0.0, 0.0, 1.0, 0.0, math.nan, 0.0]])
    with pytest.raises(InputError, match=r"limb_rates: \(3, 5\) .*as many as poses, \(2,\)"):
        jacobian.forward_velocity(ours, [home, home], np.zeros((3, 5)))
    with pytest.raises(UnknownNameError, match="did you mean 'beta'"):
        kinematics.solve_constraint(ours, home, "betta")
    for length in (0.0, -1.0, math.nan):
        with pytest.raises(InputError, match="characteristic_length"):
            singularity.singularity(ours, home, length)
    with pytest.raises(InputError, match="tolerance"):
        singularity.singularity(ours, home, 1.0, 1.0)
    # B_2 on A_2
    on = np.concatenate([ours.base[1] - ours.platform[1], np.zeros(3)])
    with pytest.raises(InputError, match=r"pose\[1\]: .*in which limb 2 has a length"):
        kinematics.inverse_displacement(ours, [home, on])
    for function, name in (
        (jacobian.inverse_velocity, "twist"),
        (lambda *a: jacobian.inverse_acceleration(a[0], a[1], np.zeros(6), a[2]), "acceleration"),
    ):
        along = np.concatenate([0.5 * ours.axis, np.zeros(3)])
        with pytest.raises(InputError, match=f"{name}: 0.5"):
            function(ours, home, along)


# Velocities and accelerations


def test_jacobian_is_the_derivative_of_the_lengths_in_allowed_motions(
    motions: Motions, geometries: list[PentapodGeometry], jacobians: Array
) -> None:
    step = 2e-3
    samples = [motions.lengths(step * k) for k in STEPS]
    rates = sum(w * s for w, s in zip(FIRST, samples, strict=True)) / step
    twists, _ = motions.derivatives()
    poses = motions.poses()
    ours = np.einsum("nij,nj->ni", jacobians, twists)
    far = motions.lengths(0.0).min(axis=1) > 0.3
    assert np.count_nonzero(far) > 0.97 * COUNT
    assert_close(ours[far, :5], rates[far], 1e-8)
    assert np.max(np.abs(ours[:, 5])) < 1e-12
    again = each(jacobian.inverse_velocity, geometries[:300], poses[:300], twists[:300])
    assert np.max(np.abs(again - ours[:300, :5])) < 1e-13


def test_sixth_row_annihilates_exactly_the_allowed_velocities(
    motions: Motions, geometries: list[PentapodGeometry], jacobians: Array
) -> None:
    rows = jacobians[:, 5]
    sizes = np.linalg.norm(rows, axis=1)
    assert sizes.min() >= 1.0
    products = np.einsum("ni,nij->nj", rows / sizes[:, None], tangents(motions))
    assert np.abs(products).max() < 1e-9
    # with the arm to B_5, or the sign of Eq. 9, it does not
    arms = np.array(
        [
            kinematics.inverse_displacement(*one).arms[4]
            for one in zip(geometries, motions.poses(), strict=True)
        ]
    )
    for moment in (np.cross(arms, rows[:, :3]), -rows[:, 3:]):
        wrong = np.einsum("ni,nij->nj", np.hstack([rows[:, :3], moment]), tangents(motions))
        assert np.median(np.abs(wrong).max(axis=1)) > 0.1


def test_hessians_are_the_second_derivative_of_the_lengths_in_allowed_motions(
    motions: Motions, geometries: list[PentapodGeometry], jacobians: Array
) -> None:
    step = 1e-2
    samples = [motions.lengths(step * k) for k in STEPS]
    seconds = sum(w * s for w, s in zip(SECOND, samples, strict=True)) / step**2
    twists, accelerations = motions.derivatives()
    poses = motions.poses()
    found = each(jacobian.hessians, geometries, poses)
    assert np.array_equal(found, found.swapaxes(-1, -2))
    ours = np.einsum("nij,nj->ni", jacobians, accelerations)
    ours += np.einsum("na,niab,nb->ni", twists, found, twists)
    far = motions.lengths(0.0).min(axis=1) > 0.5
    assert_close(ours[far, :5], seconds[far], 1e-6)
    assert np.max(np.abs(ours[:, 5])) < 1e-12
    some = (array[:200] for array in (poses, twists, accelerations))
    inverse = each(jacobian.inverse_acceleration, geometries[:200], *some)
    assert np.max(np.abs(inverse - ours[:200, :5])) < 1e-12


def test_forward_velocities_and_accelerations_undo_the_inverse_ones(
    motions: Motions, geometries: list[PentapodGeometry], jacobians: Array
) -> None:
    geometries = geometries[:300]
    twists, accelerations, poses = (
        array[:300] for array in (*motions.derivatives(), motions.poses())
    )
    rates = each(jacobian.inverse_velocity, geometries, poses, twists)
    inputs = each(jacobian.inverse_acceleration, geometries, poses, twists, accelerations)
    conditions = np.linalg.cond(jacobians[:300])[:, None]
    back = each(jacobian.forward_velocity, geometries, poses, rates)
    assert np.max(np.abs(back - twists) / conditions) < 1e-13
    back = each(jacobian.forward_acceleration, geometries, poses, twists, inputs)
    assert np.max(np.abs(back - accelerations) / conditions) < 1e-12


def test_allowed_twist_is_the_nearest() -> None:
    random = np.random.default_rng(6)
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    poses = kinematics.nearest_valid_pose(ours, random.normal(size=(50, 6)) + 1.0, 1.0)
    twists = random.normal(size=(50, 6))
    for length in (0.5, 4.0):
        allowed = jacobian.allowed_twist(ours, poses, twists, length)
        rows = jacobian.jacobian(ours, poses)[:, 5]
        assert np.abs(dot(rows, allowed)).max() < 1e-13
        # what was taken away is perpendicular, in (v, L ω), to all allowed twists
        units = np.repeat([1.0, length], 3)
        taken = (twists - allowed) * units**2
        basis = np.linalg.svd(rows[:, None])[2][:, 1:]
        assert np.abs(np.einsum("ni,nki->nk", taken, basis)).max() < 1e-12
        jacobian.inverse_velocity(ours, poses, allowed)


# Forward displacement


def test_forward_displacement_undoes_the_inverse_one() -> None:
    random = np.random.default_rng(8)
    apart, converged, total = 0, 0, 0
    for _ in range(100):
        ours = PentapodGeometry(
            random.normal(size=(5, 3)), 0.5 * random.normal(size=(5, 3)), random.normal(size=3)
        )
        poses = random.uniform(-1.0, 1.0, (10, 6)) + 4.0 * np.eye(6)[2]
        poses = kinematics.nearest_valid_pose(ours, poses, 1.0)
        lengths = kinematics.inverse_displacement(ours, poses).lengths
        starts = poses + 0.02 * random.uniform(-1.0, 1.0, (10, 6))
        found = forward.forward_displacement(ours, lengths, starts)
        good = found.converged
        total += len(good)
        converged += np.count_nonzero(good)
        # whatever was found has these lengths
        again = kinematics.inverse_displacement(ours, found.poses[good])
        assert np.abs(again.lengths - lengths[good]).max() < 1e-11
        assert np.abs(kinematics.constraint_residual(ours, found.poses[good])).max() < 1e-11
        # and well away from a singular pose it is the one it was
        near = singularity.singularity(ours, poses, 1.0)
        regular = near.inverse_condition_number > 0.01
        assert good[regular].all()
        errors = np.abs(found.poses - poses)[regular]
        assert errors.max(initial=0.0) < 1e-10
        apart += np.count_nonzero(regular)
    assert total == 1000
    assert apart > 400
    assert converged > 990


def test_forward_displacement_without_a_solution_says_so() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    home = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])
    lengths = kinematics.inverse_displacement(ours, home).lengths
    both = forward.forward_displacement(ours, [lengths, [5.0, 5.0, 5.0, 5.0, 40.0]], home)
    assert both.converged.tolist() == [True, False]
    assert both.residuals[1] > 1.0
    one = forward.forward_displacement(ours, lengths, home)
    assert bool(one.converged)
    assert np.max(np.abs(one.poses - home)) < 1e-13


def test_assemblies_have_the_lengths_and_are_different() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    home = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])
    lengths = kinematics.inverse_displacement(ours, home).lengths
    found = forward.assemblies_near(ours, lengths, home, starts=60, angle_spread=1.5)
    assert np.max(np.abs(found[0] - home)) < 1e-10
    assert len(found) > 2
    assert np.abs(kinematics.inverse_displacement(ours, found).lengths - lengths).max() < 1e-10
    assert np.abs(kinematics.constraint_residual(ours, found)).max() < 1e-10
    # below the base, by a mirror of the plane in which everything starts
    mirrored = found * [1.0, 1.0, -1.0, 1.0, -1.0, -1.0]
    again = kinematics.inverse_displacement(ours, mirrored).lengths
    assert np.abs(again - lengths).max() < 1e-10
    positions = np.linalg.norm(found[:, None] - found[None], axis=-1)
    assert positions[~np.eye(len(found), dtype=bool)].min() > 1e-6
    alone = forward.assemblies_near(
        ours, lengths, home, starts=3, position_spread=0.0, angle_spread=0.0
    )
    assert len(alone) == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"starts": 0}, "starts: 0"),
        ({"angle_spread": -1.0}, "angle_spread"),
        ({"position_spread": math.nan}, "position_spread"),
        ({"start": np.zeros((2, 6))}, r"start: \(2, 6\)"),
        ({"limb_lengths": np.ones((2, 5))}, r"limb_lengths: \(2, 5\)"),
        ({"limb_lengths": [1.0, 1.0, 0.0, 1.0, 1.0]}, r"limb_lengths\[2\]: 0.0 .*above 0"),
    ],
)
def test_bad_searches_are_named(change: dict[str, object], message: str) -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    arguments = {"limb_lengths": np.full(5, 5.0), "start": np.zeros(6), **change}
    with pytest.raises(InputError, match=message):
        forward.assemblies_near(ours, **arguments)
    with pytest.raises(InputError, match="as many as starts"):
        forward.forward_displacement(ours, np.ones((2, 5)), np.zeros((3, 6)))


# Statics


def test_joint_forces_do_no_work_with_the_load_in_any_allowed_motion(
    motions: Motions, geometries: list[PentapodGeometry]
) -> None:
    random = np.random.default_rng(9)
    loads = random.normal(size=(COUNT, 6))
    poses = motions.poses()
    forces = each(statics.joint_forces, geometries, poses, loads)
    size = np.abs(forces).max(axis=1)
    # virtual work in one motion, with the rates of the lengths by differences
    step = 2e-3
    samples = [motions.lengths(step * k) for k in STEPS]
    rates = sum(w * s for w, s in zip(FIRST, samples, strict=True)) / step
    far = motions.lengths(0.0).min(axis=1) > 0.5
    twists, _ = motions.derivatives()
    work = dot(forces[:, :5], rates) + dot(loads, twists)
    assert np.max(np.abs(work / np.maximum(1.0, size))[far]) < 1e-10


def test_joint_forces_balance_the_load_on_the_platform_and_on_the_whole_machine(
    motions: Motions, geometries: list[PentapodGeometry]
) -> None:
    random = np.random.default_rng(10)
    loads = random.normal(size=(COUNT, 6))
    poses = motions.poses()
    forces = each(statics.joint_forces, geometries, poses, loads)
    size = np.maximum(1.0, np.abs(forces).max(axis=1))
    position, matrices = motions.pose(0.0)
    ends = position[:, None] + np.einsum("nij,nkj->nki", matrices, motions.platform)
    along = (ends - motions.base) / np.linalg.norm(ends - motions.base, axis=-1)[..., None]
    pushes = forces[:, :5, None] * along
    aside = forces[:, 5:] * np.einsum("nij,nj->ni", matrices, motions.axis)
    # the platform: limbs at B_i; the constraint force at B_5, with its moment about it
    torque = np.cross(motions.base[:, 4] - ends[:, 4], aside)
    force = pushes.sum(axis=1) + aside + loads[:, :3]
    moment = np.cross(ends, pushes).sum(axis=1) + np.cross(ends[:, 4], aside) + torque
    moment += np.cross(position, loads[:, :3]) + loads[:, 3:]
    # the whole machine, about O: reactions of the base at A_i, none of them a moment
    reactions = pushes.copy()
    reactions[:, 4] += aside
    whole = np.cross(motions.base, reactions).sum(axis=1)
    whole += np.cross(position, loads[:, :3]) + loads[:, 3:]
    for rest in (force, moment, whole):
        assert np.max(np.abs(rest) / size[:, None]) < 1e-10
    # the revolute joint carries no moment about its own axis
    axes = np.einsum("nij,nj->ni", matrices, motions.axis)
    assert np.max(np.abs(dot(torque, axes)) / size) < 1e-12
    back = each(statics.balanced_load, geometries, poses, forces)
    assert np.max(np.abs(back - loads) / size[:, None]) < 1e-12


def test_forces_of_three_limbs_up_two_across_and_the_constraint_along_are_those_by_hand() -> None:
    half, deep = math.sqrt(0.75), 3.0
    platform = np.array(
        [[1.0, 0.0, 0.0], [-0.5, half, 0.0], [-0.5, -half, 0.0], [-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]
    )
    base = platform.copy()
    base[:3, 2] -= 2.0
    base[3:, 1] -= deep
    ours = PentapodGeometry(base, platform, np.array([1.0, 0.0, 0.0]))
    fx, fy, fz, tx, ty, tz = load = np.array([3.0, 5.0, -12.0, 0.7, -0.4, 1.1])
    forces = statics.joint_forces(ours, np.zeros(6), load)
    assert math.isclose(forces[5], -fx)
    # across: the constraint force is in A_5, as deep as the limb is long
    assert math.isclose(forces[3] + forces[4], -fy)
    assert math.isclose(0.5 * (forces[4] - forces[3]) + deep * forces[5], -tz)
    assert math.isclose(forces[:3].sum(), -fz)
    assert math.isclose(half * (forces[1] - forces[2]), -tx)
    assert math.isclose(0.5 * (forces[1] + forces[2]) - forces[0], -ty)


# Singular poses


def test_kinds_of_singular_poses() -> None:
    base = PentapodGeometry.from_radii(4.0, 1.0).base
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    # all limbs along z and the axis across: the platform moves sideways, two ways less one
    platform = base.copy()
    across = PentapodGeometry(base, platform, np.array([1.0, 0.0, 0.0]))
    home = np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0])
    parallel = singularity.singularity(across, home, 1.0)
    assert parallel.rank == 4
    assert parallel.free_motion == FreeMotion.SEVERAL
    assert parallel.dependency == Dependency.LIMBS
    with pytest.raises(SingularPoseError, match="the pose is singular") as caught:
        statics.joint_forces(across, home, np.zeros(6))
    assert caught.value.index == ()
    assert caught.value.ratio < 1e-15
    with pytest.raises(SingularPoseError, match=r"pose \[1\] is singular"):
        forward_velocity_of_one_regular_and_one_singular_pose(across)
    # a regular one
    regular = singularity.singularity(ours, home, 1.0)
    assert regular.rank == 6
    assert regular.dependency == Dependency.NONE
    assert regular.free_motion == FreeMotion.NONE


def forward_velocity_of_one_regular_and_one_singular_pose(ours: PentapodGeometry) -> None:
    poses = np.array([[0.0, 0.0, 5.0, 0.3, 0.2, 0.4], [0.0, 0.0, 5.0, 0.0, 0.0, 0.0]])
    poses = kinematics.nearest_valid_pose(ours, poses, 1.0)
    jacobian.forward_velocity(ours, poses[:1], np.ones(5))
    jacobian.forward_velocity(ours, poses, np.ones(5))


def assert_free_motion(
    base: Array, platform: Array, axis: Array, motion: FreeMotion, dependency: Dependency
) -> Array:
    """Return the free twist of a pose with p in O and no rotation, of which it asserts the kind."""
    ours = PentapodGeometry(base, platform, axis)
    found = singularity.singularity(ours, np.zeros(6), 1.0)
    assert found.rank == 5
    assert found.free_motion == motion
    assert found.dependency == dependency
    assert np.abs(jacobian.jacobian(ours, np.zeros(6)) @ found.free_twist).max() < 1e-13
    assert abs(found.determinant) < 1e-13
    return found.free_twist


def lines_against(twist: Array, points: Array, seed: int) -> Array:
    """Return directions at points of lines along which a rigid motion does no work."""
    velocities = twist[:3] + np.cross(twist[3:], points)
    return np.cross(velocities, np.random.default_rng(seed).normal(size=points.shape))


@pytest.mark.parametrize(
    ("twist", "motion"),
    [
        ([0.0, 0.0, 0.0, 0.0, 0.0, 1.0], FreeMotion.ROTATION),
        ([0.3, -0.4, 0.0, 0.0, 0.0, 1.0], FreeMotion.ROTATION),
        ([0.6, 0.0, 0.8, 0.0, 0.0, 0.0], FreeMotion.TRANSLATION),
        ([0.3, -0.4, 0.2, 0.0, 0.0, 1.0], FreeMotion.SCREW),
    ],
)
def test_free_motion_is_that_which_all_lines_were_built_against(
    twist: list[float], motion: FreeMotion
) -> None:
    given = np.array(twist)
    platform = np.random.default_rng(11).normal(size=(5, 3))
    base = platform - lines_against(given, platform, 12)
    axis = lines_against(given, base[4:], 13)[0]
    found = assert_free_motion(base, platform, axis, motion, Dependency.CONSTRAINT)
    given /= np.linalg.norm(given)
    assert min(np.abs(found - given).max(), np.abs(found + given).max()) < 1e-12


def test_limbs_that_depend_on_each_other_whatever_the_constraint() -> None:
    # three of four limbs in a plane would do; it may turn about a line of that plane
    random = np.random.default_rng(14)
    platform = random.normal(size=(5, 3))
    platform[:4, 2] = 0.0
    base = 3.0 * random.normal(size=(5, 3))
    base[:4, 2] = 0.0
    axis = random.normal(size=3)
    twist = assert_free_motion(base, platform, axis, FreeMotion.ROTATION, Dependency.LIMBS)
    assert np.abs(twist[[0, 1, 5]]).max() < 1e-14


def test_geometry_singular_everywhere_is_told() -> None:
    random = np.random.default_rng(15)
    sixth = 2.0 * math.pi / 6.0 * np.arange(5)
    ring = np.column_stack([np.cos(sixth), np.sin(sixth), 0.0 * sixth])
    line = np.outer([0.0, 1.0, 2.5, 4.0], [1.0, 0.0, 0.0])
    # four limbs from a line to a line in proportion: lines of one regulus in every pose
    base = np.vstack([2.0 * line, [0.0, 3.0, 1.0]])
    platform = np.vstack([line, [0.0, 1.0, 0.5]])
    affine = PentapodGeometry(base, platform, random.normal(size=3))
    assert singularity.is_always_singular(affine)
    moved = platform.copy()
    moved[0] += [0.4, 0.0, 0.0]
    assert not singularity.is_always_singular(PentapodGeometry(base, moved, affine.axis))
    assert not singularity.is_always_singular(PentapodGeometry(3.0 * ring, ring, affine.axis))


def test_determinant_changes_its_sign_at_a_singular_pose_and_values_follow_the_length() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    poses = np.zeros((2001, 6))
    poses[:, 2] = 5.0
    poses[:, 3] = np.linspace(-math.pi, math.pi, 2001)
    for length in (0.5, 2.0):
        found = singularity.singularity(ours, poses, length)
        signs = np.sign(found.determinant)
        assert np.any(np.diff(signs))
        products = np.prod(found.singular_values, axis=1)
        assert np.allclose(products, np.abs(found.determinant), rtol=1e-9, atol=1e-14)
        unscaled = np.linalg.det(jacobian.jacobian(ours, poses))
        assert np.allclose(found.determinant * length**3, unscaled, rtol=1e-9, atol=1e-13)
        turns = np.flatnonzero(np.diff(signs))
        assert found.inverse_condition_number[turns].max() < 1e-3


# Invariances


def test_a_rigid_motion_of_everything_changes_nothing_but_the_axes(
    motions: Motions, geometries: list[PentapodGeometry]
) -> None:
    random = np.random.default_rng(16)
    spin = Rotation.random(random_state=17).as_matrix()
    shift = random.normal(size=3)
    poses = motions.poses()[:100]
    loads = random.normal(size=(100, 6))
    moved_poses = np.hstack(
        [
            poses[:, :3] @ spin.T + shift,
            Rotation.from_matrix(spin @ turn(poses[:, 3:])).as_euler("ZYX"),
        ]
    )
    for ours, pose, moved_pose, load in zip(
        geometries[:100], poses, moved_poses, loads, strict=True
    ):
        moved = PentapodGeometry(ours.base @ spin.T + shift, ours.platform, ours.axis)
        lengths = kinematics.inverse_displacement(ours, pose).lengths
        again = kinematics.inverse_displacement(moved, moved_pose).lengths
        assert np.abs(again - lengths).max() < 1e-13
        matrix = jacobian.jacobian(ours, pose).reshape(6, 2, 3) @ spin.T
        assert np.abs(jacobian.jacobian(moved, moved_pose) - matrix.reshape(6, 6)).max() < 1e-12
        one = singularity.singularity(ours, pose, 0.7)
        other = singularity.singularity(moved, moved_pose, 0.7)
        assert np.abs(one.singular_values - other.singular_values).max() < 1e-12
        forces = statics.joint_forces(ours, pose, load)
        turned_load = (load.reshape(2, 3) @ spin.T).ravel()
        turned_forces = statics.joint_forces(moved, moved_pose, turned_load)
        assert np.abs(turned_forces - forces).max() < 1e-12 * np.abs(forces).max() / (
            one.inverse_condition_number
        )


def test_other_axes_of_the_platform_change_only_the_reference_point(
    motions: Motions, geometries: list[PentapodGeometry]
) -> None:
    random = np.random.default_rng(18)
    spin = Rotation.random(random_state=19).as_matrix()
    shift = random.normal(size=3)
    for ours, pose in zip(geometries[:100], motions.poses()[:100], strict=True):
        # platform points b = S b' + shift, so that R' = R S and p' = p + R shift
        other = PentapodGeometry(ours.base, (ours.platform - shift) @ spin, ours.axis @ spin)
        matrix = turn(pose[3:])
        angles = Rotation.from_matrix(matrix @ spin).as_euler("ZYX")
        other_pose = np.concatenate([pose[:3] + matrix @ shift, angles])
        assert abs(kinematics.constraint_residual(other, other_pose)) < 1e-12
        load = random.normal(size=6)
        at_other = load.copy()
        at_other[3:] -= np.cross(matrix @ shift, load[:3])
        forces = statics.joint_forces(ours, pose, load)
        again = statics.joint_forces(other, other_pose, at_other)
        condition = np.linalg.cond(jacobian.jacobian(ours, pose))
        assert np.abs(forces - again).max() < 1e-13 * condition * np.abs(forces).max()


@pytest.mark.parametrize("factor", [1e-6, 1000.0])
def test_scale_changes_only_the_unit_of_length(
    factor: float, motions: Motions, geometries: list[PentapodGeometry]
) -> None:
    units = np.repeat([factor, 1.0], 3)
    twists, accelerations = motions.derivatives()
    chosen = zip(geometries[:30], motions.poses(), twists, accelerations, strict=False)
    for ours, pose, twist, acceleration in chosen:
        scaled, scaled_pose = ours.scaled(factor), pose * units
        lengths = kinematics.inverse_displacement(ours, pose).lengths
        again = kinematics.inverse_displacement(scaled, scaled_pose).lengths
        assert np.allclose(again, factor * lengths, rtol=1e-13)
        one = singularity.singularity(ours, pose, 0.7)
        other = singularity.singularity(scaled, scaled_pose, 0.7 * factor)
        assert np.allclose(one.singular_values, other.singular_values, rtol=1e-9, atol=1e-13)
        assert one.rank == other.rank
        load = np.arange(1.0, 7.0)
        forces = statics.joint_forces(ours, pose, load)
        again = statics.joint_forces(scaled, scaled_pose, load * units[::-1])
        assert np.abs(again - forces).max() < 1e-9 * np.abs(forces).max()
        inputs = jacobian.inverse_acceleration(ours, pose, twist, acceleration)
        scaled_inputs = jacobian.inverse_acceleration(
            scaled, scaled_pose, twist * units, acceleration * units
        )
        assert np.allclose(scaled_inputs, factor * inputs, rtol=1e-9, atol=1e-12 * factor)
        found = forward.forward_displacement(scaled, factor * lengths, scaled_pose)
        assert bool(found.converged)
        nearest = kinematics.nearest_valid_pose(ours, pose + 0.1, 0.7)
        again = kinematics.nearest_valid_pose(scaled, (pose + 0.1) * units, 0.7 * factor)
        assert np.allclose(again, nearest * units, rtol=1e-6, atol=1e-7 * min(1.0, factor))


def test_poses_may_have_any_number_of_dimensions() -> None:
    ours = PentapodGeometry.from_radii(4.0, 1.0)
    random = np.random.default_rng(20)
    poses = random.uniform(-0.4, 0.4, (2, 3, 6)) + 5.0 * np.eye(6)[2]
    poses = kinematics.nearest_valid_pose(ours, poses, 1.0)
    twists = jacobian.allowed_twist(ours, poses, random.normal(size=(2, 3, 6)), 1.0)
    forces = statics.joint_forces(ours, poses, np.arange(6.0))
    inputs = jacobian.inverse_acceleration(
        ours, poses, twists, jacobian.forward_acceleration(ours, poses, twists, np.ones(5))
    )
    assert np.abs(inputs - 1.0).max() < 1e-10
    solved = kinematics.solve_constraint(ours, poses, "gamma")
    assert solved.poses.shape == (2, 3, 2, 6)
    found = forward.forward_displacement(
        ours, kinematics.inverse_displacement(ours, poses).lengths, poses + 0.01
    )
    assert found.converged.all()
    for index in np.ndindex(2, 3):
        pose = poses[index]
        assert np.allclose(forces[index], statics.joint_forces(ours, pose, np.arange(6.0)))
        assert np.allclose(jacobian.hessians(ours, poses)[index], jacobian.hessians(ours, pose))
        assert np.abs(found.poses[index] - pose).max() < 1e-10
        alone = kinematics.solve_constraint(ours, pose, "gamma")
        assert np.array_equal(alone.poses, solved.poses[index], equal_nan=True)
    # one pose and many loads or motions of it
    pose, loads = poses[0, 0], random.normal(size=(4, 6))
    for load, force in zip(loads, statics.joint_forces(ours, pose, loads), strict=True):
        assert np.allclose(force, statics.joint_forces(ours, pose, load), rtol=1e-12)
    motions = jacobian.forward_velocity(ours, pose, loads[:, :5])
    assert np.abs(jacobian.inverse_velocity(ours, pose, motions) - loads[:, :5]).max() < 1e-12
    empty = np.empty((0, 6))
    assert jacobian.hessians(ours, empty).shape == (0, 6, 6, 6)
    assert forward.forward_displacement(ours, np.empty((0, 5)), empty).poses.shape == (0, 6)
    assert kinematics.nearest_valid_pose(ours, empty, 1.0).shape == (0, 6)
