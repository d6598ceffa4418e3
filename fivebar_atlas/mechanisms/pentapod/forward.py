"""Forward displacement of the pentapod: poses for given limb lengths.

The paper has no closed form for it, and there is none. Poses are found from a start by the
method of Levenberg and Marquardt on the five lengths and the constraint, with G (Wang et al. 2017,
Eq. 10) for its matrix: near a solution this is Newton's method, which is quadratic there.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.jacobian import jacobian_of, without_unit
from fivebar_atlas.mechanisms.pentapod.kinematics import (
    checked,
    checked_lengths,
    limbs,
    residual,
)
from fivebar_atlas.mechanisms.pentapod.rotations import (
    euler_angles,
    rotation_matrices,
    turned_by,
)

# Steps that a start may take; residuals, as a share of the size of the geometry, at which a pose
# is a solution and at which no step can make it better.
_STEPS, _CLOSED, _ROUNDING = 200, 1e-12, 2e-16
# The damping at the start, what a step that failed multiplies it by, and where it is given up.
_DAMPING, _HARDER, _STUCK = 1e-3, 8.0, 1e12
# Farthest that one step may go: share of the size, which is also what a radian is worth.
_FARTHEST = 0.5
# Poses nearer to each other than this, as a share of the size and in radians, are one.
_SAME = 1e-7


@dataclasses.dataclass(frozen=True, eq=False)
class ForwardDisplacement:
    """Poses found from starts.

    Attributes
    ----------
    poses
        Shape (..., 6), with angles next to those of the starts. Where not converged, the best
        that was met.
    residuals
        Largest error of a limb length or of the constraint, shape (...).
    converged
        Where the residual is rounding, shape (...).
    """

    poses: FloatArray
    residuals: FloatArray
    converged: BoolArray


def forward_displacement(
    geometry: PentapodGeometry, limb_lengths: npt.ArrayLike, starts: npt.ArrayLike
) -> ForwardDisplacement:
    """Return the poses with given limb lengths that are found from start poses.

    Parameters
    ----------
    geometry
        The joints.
    limb_lengths
        l_i, shape (..., 5).
    starts
        Poses to start from, shape (..., 6), to go with the lengths; the revolute joint need not
        allow them.

    Returns
    -------
    ForwardDisplacement
        One pose for each; it is usually, not always, the solution next to its start. Where there
        is none, or none is found, ``converged`` is false. Close to a singular pose two solutions
        are next to each other, and each is as precise as the square root of the rounding.

    Raises
    ------
    InputError
        If something is not finite or of another shape, or a length is not above 0.
    """
    starts = checked("start", starts, (6,))
    lengths = checked_lengths(limb_lengths)
    try:
        shape = np.broadcast_shapes(lengths.shape[:-1], starts.shape[:-1])
    except ValueError:
        raise InputError(
            "limb_lengths", lengths.shape, f"as many as starts, {starts.shape}"
        ) from None
    flat_lengths = np.broadcast_to(lengths, (*shape, 5)).reshape(-1, 5)
    flat = np.broadcast_to(starts, (*shape, 6)).reshape(-1, 6)
    positions, rotations, errors = _search(geometry, flat_lengths, flat)
    poses = np.concatenate([positions, euler_angles(rotations, flat[:, 3:])], axis=-1)
    return ForwardDisplacement(
        poses.reshape(*shape, 6),
        errors.reshape(shape),
        (errors <= _CLOSED * _scale(geometry, flat_lengths)).reshape(shape),
    )


def assemblies_near(
    geometry: PentapodGeometry,
    limb_lengths: npt.ArrayLike,
    start: npt.ArrayLike,
    *,
    starts: int = 100,
    position_spread: float | None = None,
    angle_spread: float = 0.5,
    seed: int = 0,
) -> FloatArray:
    """Return the assemblies found from a start pose and from random ones about it.

    It is a search: that an assembly is not found does not prove that there is none.

    Parameters
    ----------
    geometry
        The joints.
    limb_lengths
        l_i, shape (5,).
    start
        Pose, shape (6,).
    starts
        Number of starts, the given one among them, at least 1.
    position_spread
        Standard deviation of each coordinate of p of the random starts; by default a fifth of the
        size of the geometry.
    angle_spread
        Standard deviation of the turn about each axis, in radians.
    seed
        Of the random starts.

    Returns
    -------
    ndarray
        Different poses, shape (n, 6), the nearest to the start first; near is a small
        |Δp|² + L² θ², with θ the angle of the rotation and L the radius of the platform.

    Raises
    ------
    InputError
        If something is not finite or of another shape, a length is not above 0, the number of
        starts is below 1 or a spread is negative.
    """
    lengths = checked_lengths(limb_lengths)
    start = checked("start", start, (6,))
    if lengths.ndim != 1:
        raise InputError("limb_lengths", lengths.shape, "an array of shape (5,)")
    if start.ndim != 1:
        raise InputError("start", start.shape, "an array of shape (6,)")
    if starts < 1:
        raise InputError("starts", starts, "a number from 1")
    spread = 0.2 * geometry.size if position_spread is None else position_spread
    for name, value in (("position_spread", spread), ("angle_spread", angle_spread)):
        if not (math.isfinite(value) and value >= 0.0):
            raise InputError(name, value, "a number from 0")
    random = np.random.default_rng(seed)
    moves = random.normal(size=(starts, 6)) * np.repeat([spread, angle_spread], 3)
    moves[0] = 0.0
    own = rotation_matrices(start[3:])
    turned = turned_by(np.broadcast_to(own, (starts, 3, 3)), moves[:, 3:])
    tries = np.concatenate([start[:3] + moves[:, :3], euler_angles(turned, start[3:])], axis=-1)
    found = forward_displacement(geometry, lengths, tries)
    poses = found.poses[found.converged]
    poses[:, 3:] = euler_angles(rotation_matrices(poses[:, 3:]), start[3:])
    rotations = rotation_matrices(poses[:, 3:])
    away = np.hypot(
        np.linalg.norm(poses[:, :3] - start[:3], axis=-1),
        geometry.platform_radius * _angle(rotations, own),
    )
    kept: list[int] = []
    for each in np.argsort(away, kind="stable"):
        others = np.array(kept, dtype=np.int64)
        apart = np.linalg.norm(poses[each, :3] - poses[others, :3], axis=-1) / geometry.size
        turns = _angle(rotations[each], rotations[others])
        if not np.any((apart <= _SAME) & (turns <= _SAME)):
            kept.append(int(each))
    return poses[kept]


def _angle(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the angle of the rotation between two orientations, precise for small ones too."""
    chord = np.linalg.norm(one - other, axis=(-2, -1))
    angle: FloatArray = 2.0 * np.arcsin(np.minimum(1.0, chord / math.sqrt(8.0)))
    return angle


def _scale(geometry: PentapodGeometry, lengths: FloatArray) -> FloatArray:
    """Return the length by which rounding is judged, shape (n,)."""
    scale: FloatArray = geometry.size + lengths.max(axis=-1)
    return scale


def _gaps(
    geometry: PentapodGeometry, lengths: FloatArray, positions: FloatArray, rotations: FloatArray
) -> FloatArray:
    """Return the errors of the lengths and of the constraint, of the sign of G, shape (n, 6)."""
    found = limbs(geometry, positions, rotations)
    torn = -residual(geometry, positions, rotations)
    return np.concatenate([found.lengths - lengths, torn[:, None]], axis=-1)


def _search(
    geometry: PentapodGeometry, lengths: FloatArray, starts: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return p, R and the largest error after the search, shape (n, ...)."""
    positions, rotations = starts[:, :3].copy(), rotation_matrices(starts[:, 3:])
    gaps = _gaps(geometry, lengths, positions, rotations)
    scale = _scale(geometry, lengths)
    damping = np.full(len(starts), _DAMPING)
    radian = geometry.size
    busy = np.arange(len(starts))
    for _ in range(_STEPS):
        if not len(busy):
            break
        p, r, gap = positions[busy], rotations[busy], gaps[busy]
        matrix = without_unit(jacobian_of(geometry, p, r, limbs(geometry, p, r)), radian)
        left, sizes, right = np.linalg.svd(matrix)
        weights = sizes / (sizes * sizes + damping[busy, None])
        step = -np.squeeze(
            np.swapaxes(right, -1, -2)
            @ (weights[..., None] * (np.swapaxes(left, -1, -2) @ gap[..., None])),
            axis=-1,
        )
        far = np.linalg.norm(step, axis=-1)
        step *= np.minimum(1.0, _FARTHEST * radian / np.where(far > 0.0, far, 1.0))[:, None]
        new_p, new_r = p + step[:, :3], turned_by(r, step[:, 3:] / radian)
        new_gap = _gaps(geometry, lengths[busy], new_p, new_r)
        before, after = np.linalg.norm(gap, axis=-1), np.linalg.norm(new_gap, axis=-1)
        better = after < before
        taken = busy[better]
        positions[taken], rotations[taken], gaps[taken] = (
            new_p[better],
            new_r[better],
            new_gap[better],
        )
        # towards 0 with the error, so that the last steps are Newton's
        relative = (after / scale[busy]) ** 2
        eased = np.minimum(damping[busy] / _HARDER, relative)
        damping[busy] = np.where(better, np.maximum(eased, 1e-40), damping[busy] * _HARDER)
        # in rounding a step that is no better ends it
        closed = np.minimum(before, after) <= _CLOSED * scale[busy]
        done = (after <= _ROUNDING * scale[busy]) | (closed & ~better) | (damping[busy] > _STUCK)
        busy = busy[~done]
    return positions, rotations, np.abs(gaps).max(axis=-1, initial=0.0)
