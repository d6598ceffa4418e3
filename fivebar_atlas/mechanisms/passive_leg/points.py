"""Kinematics, Jacobian matrix and LCI at many points: thin loops over the scalar kernels.

A point C = (x, y) is a pose: the passive leg has the length l = |C| and the angle θ from the
y axis. Arrays are one-dimensional and of one length. Points that a leg does not reach, those with
the passive leg beyond its limit and the middle of the base, where the leg has no direction, get
NaN.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.jacobian import lci, matrices_in_platform_axes
from fivebar_atlas.mechanisms.passive_leg.kinematics import (
    inverse,
    leg_vector,
    lower_link,
    reaches,
)

#: R, r, l_a and l_b.
Lengths = tuple[float, float, float, float]


@kernel
def pose_of(x: float, y: float) -> tuple[float, float]:
    """Return length and angle of the passive leg (Eq. 7)."""
    return math.sqrt(x * x + y * y), math.atan2(-x, y)


@kernel
def is_pose(
    base: float, platform: float, l_a: float, l_b: float, limit: float, length: float, theta: float
) -> bool:
    """Tell whether both legs reach a pose with the passive leg within its limit."""
    return length > 0.0 and abs(theta) <= limit and reaches(base, platform, l_a, l_b, length, theta)


@kernel
def inputs_at(
    base: float, platform: float, l_a: float, l_b: float, limit: float,
    x: FloatArray, y: FloatArray, elbow1: float, elbow2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in the input angles at points, ``out`` of shape (n, 2)."""
    for k in range(len(x)):
        out[k] = math.nan
        length, theta = pose_of(x[k], y[k])
        if is_pose(base, platform, l_a, l_b, limit, length, theta):
            out[k, 0], out[k, 1] = inverse(base, platform, l_a, l_b, length, theta, elbow1, elbow2)


@kernel
def upper_links_at(
    base: float, platform: float, l_a: float, l_b: float, limit: float,
    x: FloatArray, y: FloatArray, elbow1: float, elbow2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in p1, q1, p2, q2, the upper links from d_i to b_i in platform axes, shape (n, 4)."""
    for k in range(len(x)):
        out[k] = math.nan
        length, theta = pose_of(x[k], y[k])
        if is_pose(base, platform, l_a, l_b, limit, length, theta):
            c, s = math.cos(theta), math.sin(theta)
            for leg in range(2):
                side, elbow = (1.0, elbow1) if leg == 0 else (-1.0, elbow2)
                e, f = leg_vector(base, platform, length, c, s, side)
                a, b = lower_link(l_a, l_b, e, f, elbow)
                out[k, 2 * leg], out[k, 2 * leg + 1] = e - a, f - b


@kernel
def joints_at(
    base: float, platform: float, l_a: float, l_b: float, limit: float,
    x: FloatArray, y: FloatArray, elbow1: float, elbow2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in B1, B2, O, d1, d2, b1 and b2 at points, shape (n, 7, 2)."""
    for k in range(len(x)):
        out[k] = math.nan
        length, theta = pose_of(x[k], y[k])
        if is_pose(base, platform, l_a, l_b, limit, length, theta):
            c, s = math.cos(theta), math.sin(theta)
            out[k, 2] = 0.0
            for leg in range(2):
                side, elbow = (1.0, elbow1) if leg == 0 else (-1.0, elbow2)
                e, f = leg_vector(base, platform, length, c, s, side)
                a, b = lower_link(l_a, l_b, e, f, elbow)
                out[k, leg, 0], out[k, leg, 1] = side * base, 0.0
                out[k, 3 + leg, 0], out[k, 3 + leg, 1] = side * base + a * c - b * s, a * s + b * c
                out[k, 5 + leg, 0] = x[k] + side * platform * c
                out[k, 5 + leg, 1] = y[k] + side * platform * s


@kernel
def jacobian_at(
    base: float, platform: float, l_a: float, l_b: float, limit: float,
    x: FloatArray, y: FloatArray, elbow1: float, elbow2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in J of φ' = J C' in x and y (Eq. 21), shape (n, 2, 2)."""
    for k in range(len(x)):
        out[k] = math.nan
        length, theta = pose_of(x[k], y[k])
        if is_pose(base, platform, l_a, l_b, limit, length, theta):
            c, s = math.cos(theta), math.sin(theta)
            j1, j2, m11, m12, m21, m22 = matrices_in_platform_axes(
                base, platform, l_a, l_b, length, theta, elbow1, elbow2
            )
            out[k, 0, 0], out[k, 0, 1] = (m11 * c - m12 * s) / j1, (m11 * s + m12 * c) / j1
            out[k, 1, 0], out[k, 1, 1] = (m21 * c - m22 * s) / j2, (m21 * s + m22 * c) / j2


@kernel
def lci_at(
    base: float, platform: float, l_a: float, l_b: float, limit: float,
    x: FloatArray, y: FloatArray, elbow1: float, elbow2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in LCI at points."""
    for k in range(len(x)):
        out[k] = math.nan
        length, theta = pose_of(x[k], y[k])
        if is_pose(base, platform, l_a, l_b, limit, length, theta):
            out[k] = lci(base, platform, l_a, l_b, length, theta, elbow1, elbow2)
