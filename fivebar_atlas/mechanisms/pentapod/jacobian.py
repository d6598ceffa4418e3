"""Velocities and accelerations of the pentapod (Wang et al. 2017, Sec. 3.1 and 3.2).

Twists (v, ω) and accelerations (a, ε) are those of the platform at p, in base axes, shape
(..., 6). With r_i = B_i - p and r6 = A_5 - p,

    G = [n_iᵀ (r_i × n_i)ᵀ], sixth row [n6ᵀ (r6 × n6)ᵀ],     G (v, ω) = (l̇_1, ..., l̇_5, 0).

The sixth row is less the gradient of the constraint (A_5 - B_5)·n6 = 0 and the line of the
constraint force, through A_5 along n6. The paper has r6 × n6 in Eq. 10 and, with the other
sign, in Eq. 9; only the former annihilates the motions that the joint allows.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, SingularPoseError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS, PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.kinematics import (
    TOLERANCE,
    Limbs,
    check_poses,
    checked,
    checked_length,
    inverse_displacement,
)
from fivebar_atlas.mechanisms.pentapod.rotations import rotation_matrices, skew

#: Smallest over largest singular value of G, with the platform's radius for length, below which
#: nothing is solved.
SINGULAR = 1e-13


def jacobian(geometry: PentapodGeometry, poses: npt.ArrayLike) -> FloatArray:
    """Return G (Eq. 10).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6). It is not looked at whether the revolute joint allows them.

    Returns
    -------
    ndarray
        Shape (..., 6, 6); the first three columns are pure numbers, the others lengths.

    Raises
    ------
    InputError
        If poses are not finite or of another shape, or a limb has no length.
    """
    poses = checked("pose", poses, (6,))
    rotations = rotation_matrices(poses[..., 3:])
    found = inverse_displacement(geometry, poses)
    return jacobian_of(geometry, poses[..., :3], rotations, found)


def jacobian_of(
    geometry: PentapodGeometry, positions: FloatArray, rotations: FloatArray, limbs: Limbs
) -> FloatArray:
    """Return G for p, shape (..., 3), R, shape (..., 3, 3), and their limbs; unchecked."""
    axis, arm = _constraint_line(geometry, positions, rotations)
    forces = np.concatenate([limbs.directions, axis[..., None, :]], axis=-2)
    arms = np.concatenate([limbs.arms, arm[..., None, :]], axis=-2)
    rows: FloatArray = np.concatenate([forces, np.cross(arms, forces)], axis=-1)
    return rows


def without_unit(jacobians: FloatArray, characteristic_length: float) -> FloatArray:
    """Return G for twists (v, L ω): its last three columns over L."""
    scaled: FloatArray = jacobians / _units(characteristic_length)
    return scaled


def hessians(geometry: PentapodGeometry, poses: npt.ArrayLike) -> FloatArray:
    """Return H_1 ... H_6, such that the inputs' accelerations are G (a, ε) + (Vᵀ H_i V)_i.

    From l² = L·L with L̇ = v + ω × r and L̈ = a + ε × r + ω × (ω × r),

        Vᵀ H_i V = (|v + ω × r_i|² - l̇_i²) / l_i + n_i·(ω × (ω × r_i)),

    and from the sixth row with ṅ6 = ω × n6 and ṙ6 = -v,

        Vᵀ H_6 V = 2 ω·(n6 × v) - ω·(r6 × (n6 × ω)).

    These are Eqs. 13 and 14, except that the lower right block of the first term of H_i is
    -r̂_i², not r̂_i² as printed: it comes from |ω × r_i|², which is not negative.

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6). It is not looked at whether the revolute joint allows them.

    Returns
    -------
    ndarray
        Symmetric matrices, shape (..., 6, 6, 6), the limb first. The paper's are the same
        quadratic forms, not symmetric: r̂ n̂ stands for its symmetric part.

    Raises
    ------
    InputError
        If poses are not finite or of another shape, or a limb has no length.
    """
    poses = checked("pose", poses, (6,))
    rotations = rotation_matrices(poses[..., 3:])
    limbs = inverse_displacement(geometry, poses)
    rows = jacobian_of(geometry, poses[..., :3], rotations, limbs)[..., :LIMBS, :]
    arms, directions = skew(limbs.arms), skew(limbs.directions)
    found = np.zeros((*poses.shape[:-1], 6, 6, 6))
    ours = found[..., :LIMBS, :, :]
    ours[..., :3, :3] = np.eye(3)
    ours[..., :3, 3:] = -arms
    ours[..., 3:, :3] = arms
    ours[..., 3:, 3:] = -arms @ arms
    ours -= rows[..., :, None] * rows[..., None, :]
    ours /= limbs.lengths[..., None, None]
    ours[..., 3:, 3:] += _symmetric(arms @ directions)
    axis, arm = (skew(each) for each in _constraint_line(geometry, poses[..., :3], rotations))
    found[..., LIMBS, :3, 3:] = -axis
    found[..., LIMBS, 3:, :3] = axis
    found[..., LIMBS, 3:, 3:] = -_symmetric(arm @ axis)
    return found


def inverse_velocity(
    geometry: PentapodGeometry,
    poses: npt.ArrayLike,
    twists: npt.ArrayLike,
    tolerance: float = TOLERANCE,
) -> FloatArray:
    """Return the rates of the limb lengths (Eq. 8).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses that the revolute joint allows, shape (..., 6).
    twists
        (v, ω), shape (..., 6), such as the revolute joint allows; :func:`allowed_twist` makes
        them of others.
    tolerance
        Velocity along the revolute joint's axis that is taken for rounding, as a share of the
        twist's size, with the radius of the platform for length.

    Returns
    -------
    ndarray
        l̇_i, shape (..., 5).

    Raises
    ------
    InvalidPoseError
        If the revolute joint does not allow a pose.
    InputError
        If it does not allow a twist, or something is not finite or of another shape.
    """
    poses = check_poses(geometry, poses)
    twists = checked("twist", twists, (6,), like=poses)
    rates = _times(jacobian(geometry, poses), twists)
    _check_last("twist", rates, tolerance * _speed(twists, _reach(geometry, poses)))
    return rates[..., :LIMBS]


def forward_velocity(
    geometry: PentapodGeometry, poses: npt.ArrayLike, limb_rates: npt.ArrayLike
) -> FloatArray:
    """Return the twist of the platform for rates of the limb lengths (Eq. 10).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses that the revolute joint allows, shape (..., 6).
    limb_rates
        l̇_i, shape (..., 5).

    Returns
    -------
    ndarray
        (v, ω), shape (..., 6).

    Raises
    ------
    SingularPoseError
        If a pose is singular.
    InvalidPoseError
        If the revolute joint does not allow a pose.
    InputError
        If something is not finite or of another shape.
    """
    poses = check_poses(geometry, poses)
    rates = checked("limb_rates", limb_rates, (LIMBS,), like=poses)
    return solved(geometry, jacobian(geometry, poses), _with_zero(rates))


def allowed_twist(
    geometry: PentapodGeometry,
    poses: npt.ArrayLike,
    twists: npt.ArrayLike,
    characteristic_length: float,
) -> FloatArray:
    """Return the nearest twists that the revolute joint allows.

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6).
    twists
        (v, ω), shape (..., 6).
    characteristic_length
        L, above 0: near is a small |Δv|² + L² |Δω|².

    Returns
    -------
    ndarray
        (v, ω), shape (..., 6).

    Raises
    ------
    InputError
        If L is not above 0, or something is not finite or of another shape.
    """
    poses = checked("pose", poses, (6,))
    twists = checked("twist", twists, (6,), like=poses)
    units = _units(checked_length(characteristic_length))
    axis, arm = _constraint_line(geometry, poses[..., :3], rotation_matrices(poses[..., 3:]))
    row = np.concatenate([axis, np.cross(arm, axis)], axis=-1) / units
    excess = np.sum(row * units * twists, axis=-1) / np.sum(row * row, axis=-1)
    nearest: FloatArray = twists - excess[..., None] * row / units
    return nearest


def inverse_acceleration(
    geometry: PentapodGeometry,
    poses: npt.ArrayLike,
    twists: npt.ArrayLike,
    accelerations: npt.ArrayLike,
    tolerance: float = TOLERANCE,
) -> FloatArray:
    """Return the second derivatives of the limb lengths (Eqs. 13-15).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses that the revolute joint allows, shape (..., 6).
    twists, accelerations
        (v, ω) and (a, ε) such as the revolute joint allows, shape (..., 6).
    tolerance
        As for :func:`inverse_velocity`; of the acceleration it is a share of the size of all its
        terms.

    Returns
    -------
    ndarray
        l̈_i, shape (..., 5).

    Raises
    ------
    InvalidPoseError
        If the revolute joint does not allow a pose.
    InputError
        If it does not allow a twist or an acceleration, or something is not finite or of another
        shape.
    """
    poses = check_poses(geometry, poses)
    inverse_velocity(geometry, poses, twists, tolerance)
    twists = checked("twist", twists, (6,), like=poses)
    accelerations = checked("acceleration", accelerations, (6,), like=poses)
    found = _times(jacobian(geometry, poses), accelerations)
    found = found + quadratic_terms(geometry, poses, twists)
    reach = _reach(geometry, poses)
    sizes = _speed(accelerations, reach) + _speed(twists, reach) ** 2 / reach
    _check_last("acceleration", found, tolerance * sizes)
    return found[..., :LIMBS]


def forward_acceleration(
    geometry: PentapodGeometry,
    poses: npt.ArrayLike,
    twists: npt.ArrayLike,
    limb_accelerations: npt.ArrayLike,
) -> FloatArray:
    """Return the acceleration of the platform for those of the limb lengths (Eq. 15).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses that the revolute joint allows, shape (..., 6).
    twists
        (v, ω) such as the revolute joint allows, shape (..., 6).
    limb_accelerations
        l̈_i, shape (..., 5).

    Returns
    -------
    ndarray
        (a, ε), shape (..., 6).

    Raises
    ------
    SingularPoseError
        If a pose is singular.
    InvalidPoseError
        If the revolute joint does not allow a pose.
    InputError
        If it does not allow a twist, or something is not finite or of another shape.
    """
    poses = check_poses(geometry, poses)
    inverse_velocity(geometry, poses, twists)
    twists = checked("twist", twists, (6,), like=poses)
    inputs = checked("limb_accelerations", limb_accelerations, (LIMBS,), like=poses)
    right = _with_zero(inputs) - quadratic_terms(geometry, poses, twists)
    return solved(geometry, jacobian(geometry, poses), right)


def quadratic_terms(
    geometry: PentapodGeometry, poses: FloatArray, twists: FloatArray
) -> FloatArray:
    """Return Vᵀ H_i V, shape (..., 6)."""
    terms: FloatArray = np.einsum(
        "...a,...iab,...b->...i", twists, hessians(geometry, poses), twists
    )
    return terms


def quadratic_terms_of(
    geometry: PentapodGeometry,
    positions: FloatArray,
    rotations: FloatArray,
    limbs: Limbs,
    twists: FloatArray,
) -> FloatArray:
    """Return Vᵀ H_i V without the matrices, by the formulas of :func:`hessians`; unchecked.

    The value of a limb without length means nothing; callers refuse such limbs.

    Parameters
    ----------
    geometry
        The joints.
    positions, rotations, limbs
        p, shape (..., 3), R, shape (..., 3, 3), and their limbs.
    twists
        (v, ω), shape (..., 6).

    Returns
    -------
    ndarray
        Shape (..., 6).
    """
    linear, turn = twists[..., None, :3], twists[..., None, 3:]
    swing = np.cross(turn, limbs.arms)
    speeds = linear + swing
    along = np.sum(speeds * limbs.directions, axis=-1)
    inward = np.sum(np.cross(turn, swing) * limbs.directions, axis=-1)
    lengths = np.where(limbs.lengths > 0.0, limbs.lengths, 1.0)
    ours = (np.sum(speeds * speeds, axis=-1) - along**2) / lengths + inward
    axis, arm = _constraint_line(geometry, positions, rotations)
    v, w = twists[..., :3], twists[..., 3:]
    spin = 2.0 * np.cross(axis, v) - np.cross(arm, np.cross(axis, w))
    last = np.sum(w * spin, axis=-1)
    return np.concatenate([ours, last[..., None]], axis=-1)


def solved(geometry: PentapodGeometry, jacobians: FloatArray, right: FloatArray) -> FloatArray:
    """Return x with G x = b, shape (..., 6).

    Raises
    ------
    SingularPoseError
        If G is singular but for rounding.
    """
    length = geometry.platform_radius
    scaled = without_unit(jacobians, length)
    check_regular(scaled)
    columns: FloatArray = np.linalg.solve(scaled, right[..., None]) / _units(length)[:, None]
    return columns[..., 0]


def check_regular(jacobians: FloatArray) -> None:
    """Raise SingularPoseError if one of these matrices without unit is singular."""
    sizes = np.linalg.svd(jacobians, compute_uv=False)
    ratios = sizes[..., -1] / sizes[..., 0]
    singular = np.argwhere(ratios <= SINGULAR)
    if len(singular):
        index = tuple(int(part) for part in singular[0])
        raise SingularPoseError(index, float(ratios[index]))


def _constraint_line(
    geometry: PentapodGeometry, positions: FloatArray, rotations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return n6 and r6 = A_5 - p in base axes, shapes (..., 3)."""
    return rotations @ geometry.axis, geometry.base[-1] - positions


def _reach(geometry: PentapodGeometry, poses: FloatArray) -> FloatArray:
    """Return the length by which turns of the platform are judged: how far A_5 is from p."""
    away = np.linalg.norm(geometry.base[-1] - poses[..., :3], axis=-1)
    reach: FloatArray = np.maximum(away, geometry.platform_radius)
    return reach


def _speed(twists: FloatArray, length: FloatArray) -> FloatArray:
    """Return |v| + L |ω|."""
    linear: FloatArray = np.linalg.norm(twists[..., :3], axis=-1)
    angular: FloatArray = np.linalg.norm(twists[..., 3:], axis=-1)
    speed: FloatArray = linear + length * angular
    return speed


def _check_last(name: str, rows: FloatArray, allowed: FloatArray) -> None:
    """Raise InputError unless the last component is 0 but for rounding."""
    torn = np.argwhere(np.abs(rows[..., -1]) > allowed)
    if len(torn):
        index = tuple(int(part) for part in torn[0])
        where = f"{name}{list(index)}" if index else name
        expected = "one that the revolute joint allows: nothing of this along its axis"
        raise InputError(where, float(rows[index][-1]), expected)


def _units(length: float) -> FloatArray:
    """Return 1 for coordinates of lengths and L for those of turns, shape (6,)."""
    units: FloatArray = np.repeat(np.array([1.0, length]), 3)
    return units


def _with_zero(inputs: FloatArray) -> FloatArray:
    return np.concatenate([inputs, np.zeros((*inputs.shape[:-1], 1))], axis=-1)


def _symmetric(matrices: FloatArray) -> FloatArray:
    symmetric: FloatArray = 0.5 * (matrices + np.swapaxes(matrices, -1, -2))
    return symmetric


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    product: FloatArray = (matrices @ vectors[..., None])[..., 0]
    return product
