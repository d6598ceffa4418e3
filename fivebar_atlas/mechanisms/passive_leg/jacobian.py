"""Jacobian matrices of the manipulator with a passive leg (Nam and Park 2006, Sec. 5.1).

J_q q' = J_x x' (Eq. 18), with the input rates q' and the velocity x' of the platform's middle C. In
the axes u and w of the platform, n_i = (p_i, q_i) the upper link from d_i to b_i, θ' = -x_u'/l and

    row i of J_x:  (p_i -/+ q_i r/l, q_i),      J_q,ii = ± 2 l_a l_b sin β_i / 2

(upper sign for leg 1). Turned into x and y this is Eqs. 19 and 20; singular values are the same.
J = J_q⁻¹ J_x (Eq. 21) maps velocities of C to input rates: LCI = σ_min/σ_max of it in the 2-norm.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.passive_leg.kinematics import leg_vector, lower_link

#: Keeps 0/0 at twofold singular poses at zero without touching any other value.
TINY = 1e-290


@kernel
def scaled_matrices(
    base: float, platform: float, l_a: float, l_b: float, length: float, c: float, s: float,
    elbow1: float, elbow2: float,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """Return J_q,11, J_q,22 and the rows of l J_x in the axes u and w of the platform.

    Parameters
    ----------
    base, platform, l_a, l_b
        R, r and the lengths of the lower and the upper links.
    length, c, s
        Length of the passive leg; cosine and sine of its angle.
    elbow1, elbow2
        Elbows as for :func:`kinematics.lower_link`.
    """
    e1, f1 = leg_vector(base, platform, length, c, s, 1.0)
    e2, f2 = leg_vector(base, platform, length, c, s, -1.0)
    a1, b1 = lower_link(l_a, l_b, e1, f1, elbow1)
    a2, b2 = lower_link(l_a, l_b, e2, f2, elbow2)
    p1, q1, p2, q2 = e1 - a1, f1 - b1, e2 - a2, f2 - b2
    return (
        a1 * q1 - b1 * p1,
        a2 * q2 - b2 * p2,
        length * p1 - platform * q1,
        length * q1,
        length * p2 + platform * q2,
        length * q2,
    )


@kernel
def matrices_in_platform_axes(
    base: float, platform: float, l_a: float, l_b: float, length: float, theta: float,
    elbow1: float, elbow2: float,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """Return J_q,11, J_q,22 and the rows of J_x in the axes u and w of the platform.

    Parameters
    ----------
    base, platform, l_a, l_b, length, theta, elbow1, elbow2
        As for :func:`kinematics.inverse`; the length of the passive leg is not zero.
    """
    c, s = math.cos(theta), math.sin(theta)
    j1, j2, m11, m12, m21, m22 = scaled_matrices(
        base, platform, l_a, l_b, length, c, s, elbow1, elbow2
    )
    return j1, j2, m11 / length, m12 / length, m21 / length, m22 / length


@kernel
def local_indices(
    base: float, platform: float, l_a: float, l_b: float, length: float, c: float, s: float,
    elbow1: float, elbow2: float,
) -> tuple[float, float]:  # fmt: skip
    """Return LCI = σ_min/σ_max of J = J_q⁻¹ J_x, and the manipulability |det J_q / det J_x|.

    With T = 2 |j11 j22 det J_x| and S the sum of the squares of all entries of J, each times
    (j11 j22)², the LCI is T / (S + √(S² - T²)). The manipulability is that of C for unit input
    rates, in squares of lengths.

    Parameters
    ----------
    base, platform, l_a, l_b, length, c, s, elbow1, elbow2
        As for :func:`scaled_matrices`.

    Returns
    -------
    tuple of float
        LCI in [0, 1], 0 at every singularity. Manipulability, 0 at serial singularities; where
        J_x is singular it is infinite in theory, and larger than any other value here.
    """
    j1, j2, m11, m12, m21, m22 = scaled_matrices(
        base, platform, l_a, l_b, length, c, s, elbow1, elbow2
    )
    row1 = j2 * j2 * (m11 * m11 + m12 * m12)
    row2 = j1 * j1 * (m21 * m21 + m22 * m22)
    det = abs(m11 * m22 - m12 * m21)
    areas = abs(j1 * j2)
    dot = j1 * j2 * (m11 * m21 + m12 * m22)
    # S² - T² is that of rows of different lengths and of rows that are not perpendicular
    rest = (row1 - row2) * (row1 - row2) + 4.0 * dot * dot
    return (
        2.0 * areas * det / (row1 + row2 + math.sqrt(rest) + TINY),
        areas * length * length / (det + TINY),
    )


@kernel
def lci(
    base: float, platform: float, l_a: float, l_b: float, length: float, theta: float,
    elbow1: float, elbow2: float,
) -> float:  # fmt: skip
    """Return the LCI of a pose given by its angle; see :func:`local_indices`."""
    c, s = math.cos(theta), math.sin(theta)
    return local_indices(base, platform, l_a, l_b, length, c, s, elbow1, elbow2)[0]


@kernel
def manipulability(
    base: float, platform: float, l_a: float, l_b: float, length: float, theta: float,
    elbow1: float, elbow2: float,
) -> float:  # fmt: skip
    """Return the manipulability of a pose given by its angle; see :func:`local_indices`."""
    c, s = math.cos(theta), math.sin(theta)
    return local_indices(base, platform, l_a, l_b, length, c, s, elbow1, elbow2)[1]
