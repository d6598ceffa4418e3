"""The pentapod over 1,000 random geometries and poses, against differences and balances.

The machines, their motions and all that is expected come from ``naive_pentapod``. Half of the
geometries are joints anywhere with an axis in any direction, half have joints on circles.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from naive_pentapod import (
    Machine,
    Motions,
    derivatives,
    dot,
    limb_lengths,
    limb_vectors,
    rotation,
    turned,
)
from naive_pentapod import constraint as naive_constraint
from naive_pentapod import jacobian as naive_jacobian

from fivebar_atlas.mechanisms.pentapod import (
    forward,
    jacobian,
    kinematics,
    statics,
)
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry

Array = npt.NDArray[np.float64]

COUNT = 1000
# Motions of each machine through its pose; five span what the constraint allows.
MOTIONS = 5


@dataclasses.dataclass(frozen=True)
class Cases:
    """Machines with a pose each, motions through it, and loads on the platform.

    Attributes
    ----------
    machines
        Joints, first axis 1,000.
    geometries
        The same for the package.
    motions
        Motions, shape (5, 1000), all of a column through one pose.
    positions, matrices, poses
        That pose: p, R and (p, α, β, γ).
    lengths
        Limb lengths, shape (1000, 5).
    loads
        Forces and moments on the platform, about p, shape (1000, 6).
    """

    machines: Machine
    geometries: list[PentapodGeometry]
    motions: Motions
    positions: Array
    matrices: Array
    poses: Array
    lengths: Array
    loads: Array

    def each(self, function: Callable[..., Array], *arrays: Array) -> Array:
        """Return a function of a geometry, its pose and rows of arrays, for all of them."""
        rows = zip(self.geometries, self.poses, *arrays, strict=True)
        return np.array([function(*row) for row in rows])


def random_machines(random: np.random.Generator) -> tuple[list[PentapodGeometry], Machine]:
    """Return machines of both kinds."""
    geometries = []
    for number in range(COUNT):
        if number % 2:
            base = random.normal(size=(5, 3))
            platform = 0.5 * random.normal(size=(5, 3))
            geometries.append(PentapodGeometry(base, platform, random.normal(size=3)))
        else:
            r_a, r_b = random.uniform(0.2, 2.0, 2)
            turns = random.uniform(-math.pi, math.pi, 2)
            offset = r_a * random.uniform(-1.5, 1.5)
            axis = random.normal(size=3) if number % 4 else None
            geometries.append(
                PentapodGeometry.from_radii(
                    r_a, r_b, turns[0], offset, base_angle=turns[1], axis=axis
                )
            )
    parts = ("base", "platform", "axis")
    return geometries, Machine(
        *(np.array([getattr(g, part) for g in geometries]) for part in parts)
    )


@pytest.fixture(scope="module")
def cases() -> Cases:
    random = np.random.default_rng(2017)
    geometries, machines = random_machines(random)
    points = 0.5 * random.normal(size=(3, MOTIONS, COUNT, 3))
    points[0] = random.normal((0.0, 0.0, 1.5), 0.7, (COUNT, 3))
    angles = 0.5 * random.normal(size=(3, MOTIONS, COUNT, 3))
    angles[0] = random.uniform(-1.2, 1.2, (COUNT, 3))
    motions = Motions(machines, points, angles)
    positions, matrices = (each[0] for each in motions.pose(np.zeros((MOTIONS, COUNT))))
    return Cases(
        machines,
        geometries,
        motions,
        positions,
        matrices,
        np.hstack([positions, angles[0, 0]]),
        limb_lengths(machines, positions, matrices),
        random.normal(size=(COUNT, 6)),
    )


@pytest.fixture(scope="module")
def jacobians(cases: Cases) -> Array:
    return cases.each(jacobian.jacobian)


@dataclasses.dataclass(frozen=True)
class Differences:
    """Time derivatives of the motions by differences of positions; first axes (5, 1000).

    Attributes
    ----------
    twists, accelerations
        Of the platform, shape (5, 1000, 6).
    rates, second
        Of the limb lengths, shape (5, 1000, 5).
    speeds
        Speed of every B_i, shape (5, 1000, 5).
    """

    twists: Array
    accelerations: Array
    rates: Array
    second: Array
    speeds: Array


@pytest.fixture(scope="module")
def differences(cases: Cases) -> Differences:
    steps = cases.motions.steps()
    vectors = derivatives(
        lambda time: limb_vectors(cases.machines, *cases.motions.pose(time)), steps
    )[0]
    return Differences(
        *cases.motions.twists(),
        *derivatives(cases.motions.lengths, steps),
        np.linalg.norm(vectors, axis=-1),
    )


def test_motions_keep_the_constraint_and_span_all_that_it_allows(
    cases: Cases, differences: Differences
) -> None:
    for time in (-0.1, 0.0, 0.1):
        pose = cases.motions.pose(np.full((MOTIONS, COUNT), time))
        assert np.abs(naive_constraint(cases.machines, *pose)).max() < 1e-13
    residuals = cases.each(kinematics.constraint_residual)
    assert np.abs(residuals).max() < 1e-13
    twists = differences.twists.swapaxes(0, 1)
    assert np.linalg.svd(twists, compute_uv=False)[:, -1].min() > 1e-5
    lengths = np.array(
        [
            kinematics.inverse_displacement(*each).lengths
            for each in zip(cases.geometries, cases.poses, strict=True)
        ]
    )
    assert np.abs(lengths - cases.lengths).max() < 1e-14


def test_jacobian_against_differences_of_limb_lengths(
    jacobians: Array, differences: Differences
) -> None:
    """To 1e-8, absolute and as a share of the speed of B_i; no case is left out."""
    ours = np.einsum("nij,mnj->mni", jacobians, differences.twists)
    errors = np.abs(ours[..., :5] - differences.rates)
    assert errors.max() < 1e-8
    assert np.max(errors / differences.speeds) < 1e-8
    # and nothing along the constraint
    assert np.abs(ours[..., 5]).max() < 1e-8


def test_jacobian_has_the_lines_of_the_forces(cases: Cases, jacobians: Array) -> None:
    lines = naive_jacobian(cases.machines, cases.positions, cases.matrices)
    assert np.abs(jacobians - lines).max() < 1e-13


def test_hessian_term_against_second_differences(cases: Cases, differences: Differences) -> None:
    """To 1e-6, absolute and as a share of v²/l of the limb; no case is left out."""
    twists = differences.twists
    lines = naive_jacobian(cases.machines, cases.positions, cases.matrices)
    linear = np.einsum("nij,mnj->mni", lines, differences.accelerations)
    expected = np.concatenate([differences.second, np.zeros((MOTIONS, COUNT, 1))], axis=-1) - linear
    found = np.einsum("mna,niab,mnb->mni", twists, cases.each(jacobian.hessians), twists)
    errors = np.abs(found - expected)
    assert errors.max() < 1e-6
    assert np.max(errors[..., :5] / (differences.speeds**2 / cases.lengths)) < 1e-6


def test_forward_displacement_undoes_the_inverse_one(cases: Cases) -> None:
    """To 1e-10 in every case, nearly singular ones included.

    Where the least singular value σ of G is small another assembly is as near as σ is small, so the
    search starts as much nearer: at a distance of σ/50, and 0.01 at most. From 0.01 throughout it
    finds another assembly, or none, in four cases of the thousand, all with σ below 5e-4.
    """
    random = np.random.default_rng(11)
    lines = naive_jacobian(cases.machines, cases.positions, cases.matrices)
    least = np.linalg.svd(lines, compute_uv=False)[:, -1]
    assert 0.0 < least.min() < 1e-5
    away = random.normal(size=(COUNT, 6))
    away *= (np.minimum(0.01, 0.02 * least) / np.linalg.norm(away, axis=1))[:, None]
    rows = zip(cases.geometries, cases.lengths, cases.poses + away, strict=True)
    found = [forward.forward_displacement(*row) for row in rows]
    assert all(bool(each.converged) for each in found)
    poses = np.array([each.poses for each in found])
    assert np.abs(poses - cases.poses).max() < 1e-10
    # lengths and the constraint come back whatever σ
    there = poses[:, :3], rotation(*poses[:, 3:].T)
    assert np.abs(limb_lengths(cases.machines, *there) - cases.lengths).max() < 1e-10
    assert np.abs(naive_constraint(cases.machines, *there)).max() < 1e-10


def test_joint_forces_against_virtual_work(cases: Cases, differences: Differences) -> None:
    """To 1e-10 of the largest force times the greatest speed; no case is left out."""
    forces = cases.each(statics.joint_forces, cases.loads)
    work = dot(forces[:, :5], differences.rates) + dot(cases.loads, differences.twists)
    size = np.maximum(1.0, np.abs(forces).max(axis=1))
    assert np.max(np.abs(work) / size) < 1e-10


def test_joint_forces_balance_the_platform_and_the_whole_machine(cases: Cases) -> None:
    """To 1e-10, absolute, although forces reach 40,000 times the load; no case is left out."""
    forces = cases.each(statics.joint_forces, cases.loads)
    assert np.abs(forces).max() > 4e4
    limbs = limb_vectors(cases.machines, cases.positions, cases.matrices)
    pushes = forces[:, :5, None] * limbs / cases.lengths[..., None]
    across = forces[:, 5:] * turned(cases.matrices, cases.machines.axis)
    load, moment = cases.loads[:, :3], cases.loads[:, 3:]
    # the platform, about O: pushes in B_i, the constraint force in B_5 with a moment
    ends = cases.machines.base + limbs
    torque = np.cross(-limbs[:, 4], across)
    assert np.abs(pushes.sum(axis=1) + across + load).max() < 1e-10
    about = np.cross(ends, pushes).sum(axis=1) + np.cross(ends[:, 4], across) + torque
    assert np.abs(about + np.cross(cases.positions, load) + moment).max() < 1e-10
    # which the revolute joint can carry, for it is not about its axis
    axes = turned(cases.matrices, cases.machines.axis)
    assert np.abs(dot(torque, axes)).max() < 1e-10
    # the whole machine, about a point off it: the base holds it in A_i, spherical joints all
    point = np.array([0.3, -0.7, 0.4])
    held = pushes.copy()
    held[:, 4] += across
    about = np.cross(cases.machines.base - point, held).sum(axis=1)
    assert np.abs(about + np.cross(cases.positions - point, load) + moment).max() < 1e-10
    # the fifth limb alone: what comes in through A_5 goes out through B_5
    assert np.abs(np.cross(limbs[:, 4], held[:, 4]) + torque).max() < 1e-10
