"""Rotations by the three angles of Wang et al. 2017, Sec. 2, and what their rates mean.

R = Rz(α) Ry(β) Rx(γ): α about Z, then β about the turned Y, then γ about the twice turned X. In
the paper's matrix the "cλ" of the upper right entry is cos γ.
"""

from __future__ import annotations

import math

import numpy as np

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray

# Where |cos β| is smaller, α and γ turn about one axis.
_LOCKED = 1e-12


def rotation_matrices(angles: FloatArray) -> FloatArray:
    """Return the matrices that take platform axes to base axes (Eq. 2).

    Parameters
    ----------
    angles
        α, β, γ in radians, shape (..., 3).

    Returns
    -------
    ndarray
        R, shape (..., 3, 3).
    """
    ca, cb, cg = np.moveaxis(np.cos(angles), -1, 0)
    sa, sb, sg = np.moveaxis(np.sin(angles), -1, 0)
    rows = [
        [ca * cb, ca * sb * sg - sa * cg, ca * sb * cg + sa * sg],
        [sa * cb, sa * sb * sg + ca * cg, sa * sb * cg - ca * sg],
        [-sb, cb * sg, cb * cg],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def euler_angles(rotations: FloatArray, near: FloatArray | None = None) -> FloatArray:
    """Return the angles α, β, γ of rotation matrices.

    Every rotation has two sets of angles but for full turns, (α, β, γ) and (α + π, π - β, γ + π).

    Parameters
    ----------
    rotations
        R, shape (..., 3, 3).
    near
        Angles that the result shall be next to, shape (..., 3); without them β is from -π/2 to
        π/2, and α and γ from -π to π.

    Returns
    -------
    ndarray
        Angles in radians, shape (..., 3). Where cos β = 0, only α - γ or α + γ is determined: α
        is then that of ``near``, or 0.
    """
    cos_beta = np.hypot(rotations[..., 0, 0], rotations[..., 1, 0])
    locked = cos_beta <= _LOCKED
    free = 0.0 if near is None else near[..., 0]
    alpha = np.where(locked, free, np.arctan2(rotations[..., 1, 0], rotations[..., 0, 0]))
    beta = np.arctan2(-rotations[..., 2, 0], cos_beta)
    # γ from the rows of Rz(α)ᵀ R, which is well determined where α alone is not
    c, s = np.cos(alpha), np.sin(alpha)
    gamma = np.arctan2(
        s * rotations[..., 0, 2] - c * rotations[..., 1, 2],
        c * rotations[..., 1, 1] - s * rotations[..., 0, 1],
    )
    angles: FloatArray = np.stack([alpha, beta, gamma], axis=-1)
    if near is None:
        return angles
    other = np.stack([alpha + math.pi, math.pi - beta, gamma + math.pi], axis=-1)
    choices = [near + wrapped(each - near) for each in (angles, other)]
    distances = [np.linalg.norm(each - near, axis=-1) for each in choices]
    nearest: FloatArray = np.where((distances[1] < distances[0])[..., None], choices[1], choices[0])
    return nearest


def wrapped(angles: FloatArray) -> FloatArray:
    """Return angles less full turns, from -π to π."""
    turned: FloatArray = angles - 2.0 * math.pi * np.round(angles / (2.0 * math.pi))
    return turned


def turned_by(rotations: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return rotation matrices turned further about vectors in base axes, by their lengths.

    Parameters
    ----------
    rotations
        R, shape (..., 3, 3).
    vectors
        Rotation vectors δ in radians, shape (..., 3).

    Returns
    -------
    ndarray
        exp(δ̂) R, shape (..., 3, 3), by Rodrigues' formula.
    """
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    matrix = skew(vectors)
    # np.sinc(x) = sin(πx)/(πx): no division at angle 0
    first = np.sinc(angle / math.pi)
    second = 0.5 * np.sinc(0.5 * angle / math.pi) ** 2
    turned: FloatArray = rotations + (first * matrix + second * (matrix @ matrix)) @ rotations
    return turned


def skew(vectors: FloatArray) -> FloatArray:
    """Return the matrices η̂ with η̂ ζ = η × ζ (Eq. 12), shape (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def angular_velocity(angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the angular velocity of the platform from the rates of its angles.

    Parameters
    ----------
    angles, rates
        α, β, γ in radians and their rates, shape (..., 3).

    Returns
    -------
    ndarray
        ω in base axes, shape (..., 3): α̇ e_z + β̇ Rz(α) e_y + γ̇ R e_x.
    """
    matrix, _ = _rate_matrices(angles, rates)
    return _times(matrix, rates)


def angular_acceleration(
    angles: FloatArray, rates: FloatArray, accelerations: FloatArray
) -> FloatArray:
    """Return the angular acceleration of the platform from its angles' second derivatives.

    Parameters
    ----------
    angles, rates, accelerations
        α, β, γ in radians and their first and second derivatives, shape (..., 3).

    Returns
    -------
    ndarray
        ε in base axes, shape (..., 3).
    """
    matrix, derivative = _rate_matrices(angles, rates)
    return _times(matrix, accelerations) + _times(derivative, rates)


def euler_rates(angles: FloatArray, velocities: FloatArray) -> FloatArray:
    """Return the rates of the angles from the angular velocity of the platform.

    Parameters
    ----------
    angles
        α, β, γ in radians, shape (..., 3).
    velocities
        ω in base axes, shape (..., 3).

    Returns
    -------
    ndarray
        Rates of α, β, γ, shape (..., 3).

    Raises
    ------
    InputError
        Where cos β = 0: there the angles have no rates for some ω.
    """
    ca, cb, _ = np.moveaxis(np.cos(angles), -1, 0)
    sa, sb, _ = np.moveaxis(np.sin(angles), -1, 0)
    locked = np.abs(cb) <= _LOCKED
    if np.any(locked):
        beta = float(np.asarray(angles[..., 1])[locked].flat[0])
        raise InputError("beta", beta, "an angle other than ±90 degrees, where α and γ are one")
    x, y, z = np.moveaxis(velocities, -1, 0)
    gamma = (ca * x + sa * y) / cb
    return np.stack([z + sb * gamma, ca * y - sa * x, gamma], axis=-1)


def _rate_matrices(angles: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return E with ω = E (α̇, β̇, γ̇), and its derivative by time, shapes (..., 3, 3)."""
    ca, cb, _ = np.moveaxis(np.cos(angles), -1, 0)
    sa, sb, _ = np.moveaxis(np.sin(angles), -1, 0)
    a, b, _ = np.moveaxis(rates, -1, 0)
    zero, one = np.zeros_like(ca), np.ones_like(ca)
    rows = [[zero, -sa, ca * cb], [zero, ca, sa * cb], [one, zero, -sb]]
    changes = [
        [zero, -ca * a, -sa * cb * a - ca * sb * b],
        [zero, -sa * a, ca * cb * a - sa * sb * b],
        [zero, zero, -cb * b],
    ]
    matrix = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return matrix, np.stack(
        [np.stack(np.broadcast_arrays(*row), axis=-1) for row in changes], axis=-2
    )


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    product: FloatArray = np.squeeze(matrices @ vectors[..., None], axis=-1)
    return product
