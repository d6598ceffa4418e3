"""Jacobian matrices and conditioning of the symmetric 5R manipulator (Liu et al. 2006, Sec. 3, 8).

A θ' = B p' (Eq. 15) and J = A⁻¹ B (Eq. 20), which maps platform to joint velocities. The
condition number κ is that of J in the 2-norm; LCI = 1/κ = σ_min / σ_max.

With β_i the elbow angle at B_i and γ the angle B1 P B2, the rows of J are unit vectors
along B_i P divided by r1 sin β_i, so that

    LCI + 1/LCI = (sin β1 / sin β2 + sin β2 / sin β1) / |sin γ|.

Every sine follows from side lengths by one square root, and no quotient is formed that is
not needed: the kernels vectorise.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.five_bar.kinematics import elbow, squared_four_areas

#: Keeps 0/0 at twofold singular points at zero without touching any other value.
TINY = 1e-290


@kernel
def matrices(
    r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float
) -> tuple[float, float, float, float, float, float]:
    """Return A11, A22 (Eq. 18) and B11, B12, B21, B22 (Eq. 19); A is diagonal.

    A11 = cross(P - A1, B1 - A1) up to sign: y r1 cos θ1 - (x + r3) r1 sin θ1; it is zero at
    a serial singularity of leg 1. The rows of B are P - B1 and P - B2.
    """
    b1x, b1y = elbow(r1, r2, -r3, x, y, s1)
    b2x, b2y = elbow(r1, r2, r3, x, y, s2)
    a11 = y * (b1x + r3) - (x + r3) * b1y
    a22 = y * (b2x - r3) - (x - r3) * b2y
    return a11, a22, x - b1x, y - b1y, x - b2x, y - b2y


@kernel
def distal_products(
    r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float
) -> tuple[float, float, float, float, float]:
    """Return what all conditioning kernels share.

    Returns
    -------
    tuple of float
        ``four_areas`` of both legs (2 r1 r2 sin β_i, zero beyond reach); cross and dot
        product of the distal links B1 P and B2 P, each link scaled by its squared reach
        d_i²; and the scale d1² d2² r2² that turns the products into sin γ and cos γ.
    """
    y2 = y * y
    u1 = x + r3
    u2 = x - r3
    reach2_1 = u1 * u1 + y2
    reach2_2 = u2 * u2 + y2
    four_areas_1 = math.sqrt(max(squared_four_areas(r1, r2, reach2_1), 0.0))
    four_areas_2 = math.sqrt(max(squared_four_areas(r1, r2, reach2_2), 0.0))
    shift = (r2 - r1) * (r2 + r1)
    along_1 = 0.5 * (reach2_1 + shift)
    along_2 = 0.5 * (reach2_2 + shift)
    across_1 = 0.5 * s1 * four_areas_1
    across_2 = 0.5 * s2 * four_areas_2
    v1x = along_1 * u1 + across_1 * y
    v1y = along_1 * y - across_1 * u1
    v2x = along_2 * u2 + across_2 * y
    v2y = along_2 * y - across_2 * u2
    return (
        four_areas_1,
        four_areas_2,
        v1x * v2y - v1y * v2x,
        v1x * v2x + v1y * v2y,
        reach2_1 * reach2_2 * r2 * r2,
    )


@kernel
def signed_det_b(
    r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float
) -> float:
    """Return det B d1² d2²: positive in the up-, negative in the down-configuration.

    Zero at parallel singularities, where B1, P and B2 are in line.
    """
    _, _, cross, _, _ = distal_products(r1, r2, r3, x, y, s1, s2)
    return cross


@kernel
def lci(r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float) -> float:
    """Return the local conditioning index σ_min/σ_max of J = A⁻¹B (Eq. 20, Sec. 8).

    With T = 2 sin β1 sin β2 |sin γ| and S = sin² β1 + sin² β2 it is T / (S + √(S² - T²)).
    S - T is formed as (sin β1 - sin β2)² + 2 sin β1 sin β2 cos² γ / (1 + |sin γ|), which
    keeps all digits at isotropic points; the fraction is expanded by 1 + |sin γ|, which
    leaves three square roots and one division.

    Returns
    -------
    float
        In [0, 1], non-dimensional; 0 at every singularity, serial or parallel, and beyond
        reach; 1 at isotropic points.
    """
    w1, w2, cross, dot, scale = distal_products(r1, r2, r3, x, y, s1, s2)
    cross = abs(cross)
    twice = 2.0 * w1 * w2
    t = twice * cross
    total = scale * (w1 * w1 + w2 * w2)
    expansion = scale + cross
    gap = scale * expansion * (w1 - w2) * (w1 - w2) + twice * dot * dot
    return t * expansion / (total * expansion + math.sqrt(gap * (total + t) * expansion) + TINY)


@kernel
def threshold_ratio(lci_threshold: float) -> float:
    """Return T/S = 2 / (κ + 1/κ) that belongs to an LCI: 2 c / (1 + c²), monotone in c."""
    return 2.0 * lci_threshold / (1.0 + lci_threshold * lci_threshold)


@kernel
def conditioning_ratio(
    r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float
) -> float:
    """Return q = T/S = 2 / (κ + 1/κ), smooth also at isotropic points, where it is 1."""
    w1, w2, cross, _, scale = distal_products(r1, r2, r3, x, y, s1, s2)
    return 2.0 * w1 * w2 * abs(cross) / (scale * (w1 * w1 + w2 * w2) + TINY)


@kernel
def conditioning_with_slope(
    r1: float, r2: float, r3: float, x: float, y: float, dx: float, dy: float,
    s1: float, s2: float, assembly: float,
) -> tuple[float, float]:  # fmt: skip
    """Return q and its derivative in the direction (dx, dy).

    q is the ratio of :func:`conditioning_ratio`. With W_i = (2 r1 r2 sin β_i)², the
    direction δ_i of the distal link and γ = δ2 - δ1,

        q'/q = ½ (W2 - W1)(W1' W2 - W2' W1) / (W1 W2 (W1 + W2)) + cot γ γ',

    where δ_i' = (arg(P - A_i))' + s_i (d_i² + r1² - r2²)(d_i²)' / (2 d_i² √W_i).

    Parameters
    ----------
    r1, r2, r3, x, y
        Design and point.
    dx, dy
        Direction, a unit vector.
    s1, s2, assembly
        Working mode and assembly mode as ±1.

    Returns
    -------
    tuple of float
        q and q'; at serial singularities, where q' is infinite, some finite number.
    """
    w1, w2, cross, dot, scale = distal_products(r1, r2, r3, x, y, s1, s2)
    u1 = x + r3
    u2 = x - r3
    y2 = y * y
    reach2_1 = u1 * u1 + y2
    reach2_2 = u2 * u2 + y2
    rate_1 = 2.0 * (u1 * dx + y * dy)
    rate_2 = 2.0 * (u2 * dx + y * dy)
    sides = 2.0 * (r1 * r1 + r2 * r2)
    shift = (r1 - r2) * (r1 + r2)
    big1 = w1 * w1
    big2 = w2 * w2
    big1_rate = (sides - 2.0 * reach2_1) * rate_1
    big2_rate = (sides - 2.0 * reach2_2) * rate_2
    # w_i times the turning rate of distal link i
    turn_1 = (w1 * (u1 * dy - y * dx) + 0.5 * s1 * (reach2_1 + shift) * rate_1) / (reach2_1 + TINY)
    turn_2 = (w2 * (u2 * dy - y * dx) + 0.5 * s2 * (reach2_2 + shift) * rate_2) / (reach2_2 + TINY)
    # q' w1 w2 (W1 + W2)² scale / 2, in which nothing is divided by a sine
    rise = assembly * (
        0.5 * (big2 - big1) * (big1_rate * big2 - big2_rate * big1) * cross
        + w1 * w2 * (big1 + big2) * dot * (w1 * turn_2 - w2 * turn_1)
    )
    both = w1 * w2
    inverse = 1.0 / (scale * (big1 + big2) + TINY)
    return (
        2.0 * both * abs(cross) * inverse,
        2.0 * rise * inverse / (both * (big1 + big2) + TINY),
    )
