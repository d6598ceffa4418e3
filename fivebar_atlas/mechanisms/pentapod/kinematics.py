"""Poses and limb lengths of the pentapod (Wang et al. 2017, Sec. 2).

A pose is (X_o, Y_o, Z_o, α, β, γ): the origin p of the platform in base axes and the angles of
:mod:`rotations` in radians. The platform has five freedoms, so six coordinates are not free: the
fifth limb is perpendicular to the axis of its revolute joint,

    c = (A_5 - B_5)·n6 = 0.

The paper does not write this condition down; its Eq. 9 is the derivative of it. All functions
take any number of poses at once, shape (..., 6).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, InvalidPoseError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS, PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.rotations import (
    euler_angles,
    rotation_matrices,
    turned_by,
    wrapped,
)

#: Names of the coordinates of a pose, in their order.
COORDINATES = ("x", "y", "z", "alpha", "beta", "gamma")
#: Residual of the constraint, as a share of the size of the geometry, that a pose may have.
TOLERANCE = 1e-9

# What is rounding, as a share of the size or of 1.
_ROUNDING = 1e-13
# Samples of the turn of the nearest valid pose, and bisections of the step between two of them.
_SAMPLES, _BISECTIONS = 361, 50


@dataclasses.dataclass(frozen=True, eq=False)
class Limbs:
    """The limbs in poses.

    Attributes
    ----------
    lengths
        l_i, shape (..., 5).
    directions
        Unit vectors n_i from A_i to B_i in base axes, shape (..., 5, 3).
    arms
        r_i = B_i - p in base axes, shape (..., 5, 3).
    """

    lengths: FloatArray
    directions: FloatArray
    arms: FloatArray


@dataclasses.dataclass(frozen=True, eq=False)
class ConstraintSolutions:
    """Poses that the revolute joint allows, for five given coordinates.

    Attributes
    ----------
    poses
        Up to two poses, the one nearest the given coordinate first, shape (..., 2, 6); the sixth
        coordinate of those there are not is NaN.
    count
        How many there are, shape (...).
    free
        Where every value of the coordinate solves it, shape (...); the only pose is then the
        given one.
    """

    poses: FloatArray
    count: IntArray
    free: BoolArray


def checked(
    name: str, values: npt.ArrayLike, last: tuple[int, ...], like: FloatArray | None = None
) -> FloatArray:
    """Return finite numbers whose last dimensions are these.

    Parameters
    ----------
    name
        Name of the input in the error.
    values
        The numbers.
    last
        Last dimensions that they must have.
    like
        Poses whose other dimensions they must go with, shape (..., 6).

    Raises
    ------
    InputError
        If they have other dimensions or are not finite.
    """
    shape = "(" + ", ".join(["...", *map(str, last)]) + ")"
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(name, values, f"numbers, shape {shape}") from None
    if array.shape[-len(last) :] != last:
        raise InputError(name, array.shape, f"an array of shape {shape}")
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        first = tuple(int(part) for part in bad[0])
        raise InputError(f"{name}{list(first)}", float(array[first]), "a finite number")
    if like is not None:
        try:
            np.broadcast_shapes(array.shape[: -len(last)], like.shape[:-1])
        except ValueError:
            raise InputError(name, array.shape, f"as many as poses, {like.shape[:-1]}") from None
    return array


def inverse_displacement(geometry: PentapodGeometry, poses: npt.ArrayLike) -> Limbs:
    """Return the lengths and the directions of the limbs (Eqs. 3-5).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6). They need not be such that the revolute joint allows them; see
        :func:`check_poses`.

    Returns
    -------
    Limbs
        Lengths, unit vectors and arms.

    Raises
    ------
    InputError
        If poses are not finite or of another shape, or a limb has no length and so no direction.
    """
    poses = checked("pose", poses, (6,))
    found = limbs(geometry, poses[..., :3], rotation_matrices(poses[..., 3:]))
    short = np.argwhere(found.lengths <= _ROUNDING * geometry.size)
    if len(short):
        *index, limb = (int(part) for part in short[0])
        where = f"pose{index}" if index else "pose"
        pose = tuple(poses[tuple(index)].tolist())
        raise InputError(where, pose, f"a pose in which limb {limb + 1} has a length")
    return found


def limbs(geometry: PentapodGeometry, positions: FloatArray, rotations: FloatArray) -> Limbs:
    """Return the limbs for p, shape (..., 3), and R, shape (..., 3, 3); unchecked.

    A limb without length has the direction 0.
    """
    arms = geometry.platform @ np.swapaxes(rotations, -1, -2)
    vectors = positions[..., None, :] + arms - geometry.base
    lengths = np.linalg.norm(vectors, axis=-1)
    divisors = np.where(lengths > 0.0, lengths, 1.0)
    return Limbs(lengths, vectors / divisors[..., None], arms)


def constraint_residual(geometry: PentapodGeometry, poses: npt.ArrayLike) -> FloatArray:
    """Return c = (A_5 - B_5)·n6, which is 0 in the poses that the revolute joint allows.

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6).

    Returns
    -------
    ndarray
        A length, shape (...). Its derivative by time is less the sixth row of G times the twist.

    Raises
    ------
    InputError
        If poses are not finite or of another shape.
    """
    poses = checked("pose", poses, (6,))
    return residual(geometry, poses[..., :3], rotation_matrices(poses[..., 3:]))


def residual(
    geometry: PentapodGeometry, positions: FloatArray, rotations: FloatArray
) -> FloatArray:
    """Return the residual for p, shape (..., 3), and R, shape (..., 3, 3); unchecked."""
    axes = rotations @ geometry.axis
    product: FloatArray = np.sum((geometry.base[-1] - positions) * axes, axis=-1)
    # B_5 is fixed in the platform, as the axis is
    return product - float(geometry.platform[-1] @ geometry.axis)


def check_poses(
    geometry: PentapodGeometry, poses: npt.ArrayLike, tolerance: float = TOLERANCE
) -> FloatArray:
    """Return poses if the revolute joint allows them all.

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6).
    tolerance
        Residual, as a share of the size of the geometry, that a pose may have.

    Raises
    ------
    InvalidPoseError
        If it does not; the error has the residual and the index of the first one.
    InputError
        If poses are not finite or of another shape.
    """
    poses = checked("pose", poses, (6,))
    gaps = constraint_residual(geometry, poses)
    torn = np.argwhere(np.abs(gaps) > tolerance * geometry.size)
    if len(torn):
        index = tuple(int(part) for part in torn[0])
        raise InvalidPoseError("pose", tuple(poses[index].tolist()), float(gaps[index]), index)
    return poses


def solve_constraint(
    geometry: PentapodGeometry, poses: npt.ArrayLike, coordinate: str
) -> ConstraintSolutions:
    """Return all poses that the revolute joint allows and that differ in one coordinate only.

    In a coordinate of p the residual is linear: one solution at most. In an angle λ it is
    P cos λ + Q sin λ + C: two at most, given within half a turn of the given angle.

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6); of the coordinate solved for, only which solution comes first
        depends, and the turn that angles are on.
    coordinate
        Name of the coordinate, one of :data:`COORDINATES`.

    Returns
    -------
    ConstraintSolutions
        The poses and how many there are.

    Raises
    ------
    UnknownNameError
        If there is no such coordinate.
    InputError
        If poses are not finite or of another shape.
    """
    if coordinate not in COORDINATES:
        raise UnknownNameError("coordinate", coordinate, COORDINATES)
    poses = checked("pose", poses, (6,))
    column = COORDINATES.index(coordinate)
    if column < 3:
        solved, free = _solve_position(geometry, poses, column)
    else:
        solved, free = _solve_angle(geometry, poses, column)
    solved[free] = [0.0, math.nan]
    order = np.argsort(np.abs(solved), axis=-1)  # NaN last
    solved = np.take_along_axis(solved, order, axis=-1)
    found = np.repeat(poses[..., None, :], 2, axis=-2)
    found[..., column] += solved
    return ConstraintSolutions(found, np.sum(~np.isnan(solved), axis=-1), free)


def _solve_position(
    geometry: PentapodGeometry, poses: FloatArray, column: int
) -> tuple[FloatArray, BoolArray]:
    """Return steps of a coordinate of p, shape (..., 2), and where every step will do."""
    gaps = constraint_residual(geometry, poses)
    slopes = (rotation_matrices(poses[..., 3:]) @ geometry.axis)[..., column]
    level = np.abs(slopes) <= _ROUNDING
    steps = np.full((*gaps.shape, 2), math.nan)
    steps[..., 0] = np.where(level, math.nan, gaps / np.where(level, 1.0, slopes))
    return steps, level & (np.abs(gaps) <= _ROUNDING * geometry.size)


def _solve_angle(
    geometry: PentapodGeometry, poses: FloatArray, column: int
) -> tuple[FloatArray, BoolArray]:
    """Return steps of an angle, shape (..., 2), and where every step will do."""

    def at(step: float) -> FloatArray:
        moved = poses.copy()
        moved[..., column] += step
        return constraint_residual(geometry, moved)

    here, quarter, half = at(0.0), at(0.5 * math.pi), at(math.pi)
    middle = 0.5 * (here + half)
    cosine, sine = 0.5 * (here - half), quarter - middle
    amplitude = np.hypot(cosine, sine)
    reach = geometry.size + np.linalg.norm(poses[..., :3] - geometry.base[-1], axis=-1)
    level = amplitude <= _ROUNDING * reach
    share = -middle / np.where(level, 1.0, amplitude)
    none = level | (np.abs(share) > 1.0 + _ROUNDING)
    turn = np.arccos(np.where(none, math.nan, np.clip(share, -1.0, 1.0)))
    phase = np.arctan2(sine, cosine)
    steps = wrapped(np.stack([phase + turn, phase - turn], axis=-1))
    steps[turn == 0.0, 1] = math.nan  # one double solution
    steps[turn == math.pi, 1] = math.nan
    return steps, level & (np.abs(middle) <= _ROUNDING * reach)


def nearest_valid_pose(
    geometry: PentapodGeometry, poses: npt.ArrayLike, characteristic_length: float
) -> FloatArray:
    """Return the nearest poses that the revolute joint allows.

    Near is a small |Δp|² + L² θ², with θ the angle of the rotation between the two orientations.
    For a given direction m of the axis the nearest p is off by ((A_5 - p)·m - k) m, k = B_5·n6 in
    platform axes, and the least rotation turns n6 in the plane of n6 and m. The best m is in the
    plane of n6 and A_5 - p, so that a search in one angle is left.

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6).
    characteristic_length
        L, above 0: the length that is as far as a turn of one radian.

    Returns
    -------
    ndarray
        Poses, shape (..., 6), with angles next to the given ones.

    Raises
    ------
    InputError
        If L is not above 0, or poses are not finite or of another shape.
    """
    poses = checked("pose", poses, (6,))
    length = checked_length(characteristic_length)
    rotations = rotation_matrices(poses[..., 3:])
    axes = rotations @ geometry.axis
    reach = geometry.base[-1] - poses[..., :3]
    offset = float(geometry.platform[-1] @ geometry.axis)
    along = np.sum(reach * axes, axis=-1)
    across = np.cross(axes, reach)
    aside = np.linalg.norm(across, axis=-1)
    # any plane will do where A_5 - p is along n6
    least = np.eye(3)[np.argmin(np.abs(axes), axis=-1)]
    across = np.where((aside > _ROUNDING * geometry.size)[..., None], across, np.cross(axes, least))
    across /= np.linalg.norm(across, axis=-1)[..., None]

    def gap(turn: FloatArray) -> FloatArray:
        """Return (A_5 - p)·m - k with n6 turned by this angle."""
        value: FloatArray = (
            along[..., None] * np.cos(turn) + aside[..., None] * np.sin(turn) - offset
        )
        return value

    def slope(turn: FloatArray) -> FloatArray:
        """Return half of the derivative of the squared distance."""
        change = aside[..., None] * np.cos(turn) - along[..., None] * np.sin(turn)
        value: FloatArray = gap(turn) * change + length * length * turn
        return value

    turns = np.linspace(-math.pi, math.pi, _SAMPLES)
    best = np.argmin(gap(turns) ** 2 + (length * turns) ** 2, axis=-1)[..., None]
    step = turns[1] - turns[0]
    low, high = turns[best] - step, turns[best] + step
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        rising = slope(middle) > 0.0
        low, high = np.where(rising, low, middle), np.where(rising, middle, high)
    turn = 0.5 * (low + high)
    turned = turned_by(rotations, turn * across)
    found = poses.copy()
    found[..., 3:] = euler_angles(turned, poses[..., 3:])
    # the angles are rounded, and p is what makes up for it
    moved = rotation_matrices(found[..., 3:]) @ geometry.axis
    found[..., :3] += (np.sum(reach * moved, axis=-1) - offset)[..., None] * moved
    return found


def checked_length(characteristic_length: float) -> float:
    """Return the characteristic length.

    Raises
    ------
    InputError
        If it is not finite and above 0.
    """
    if not (math.isfinite(characteristic_length) and characteristic_length > 0.0):
        raise InputError("characteristic_length", characteristic_length, "a length above 0")
    return float(characteristic_length)


def checked_lengths(lengths: npt.ArrayLike) -> FloatArray:
    """Return limb lengths, shape (..., 5).

    Raises
    ------
    InputError
        If they are not finite, or of another shape, or not all above 0.
    """
    lengths = checked("limb_lengths", lengths, (LIMBS,))
    short = np.argwhere(lengths <= 0.0)
    if len(short):
        first = tuple(int(part) for part in short[0])
        raise InputError(f"limb_lengths{list(first)}", float(lengths[first]), "a length above 0")
    return lengths
