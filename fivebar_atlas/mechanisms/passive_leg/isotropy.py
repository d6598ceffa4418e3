"""Isotropic points of the manipulator with a passive leg, where the LCI is 1.

There both rows of J are of one length and perpendicular: with their squared lengths S_1, S_2 and
their product P, g = (S_1 - S_2, 2 P)/(S_1 + S_2) vanishes. g is smooth, so Newton's method finds
the points; the LCI, a function of |g|, has a corner there like the tip of a cone.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.columns import PASSIVE_JOINTS
from fivebar_atlas.mechanisms.passive_leg.jacobian import TINY, scaled_matrices
from fivebar_atlas.mechanisms.passive_leg.kinematics import reaches_at
from fivebar_atlas.mechanisms.passive_leg.singularity import conditions_at

#: Most isotropic points kept; more than three have not been seen.
MAX_ISOTROPIC = 8
# Starts along θ (to either side) and along l; steps; step of differences; |g| of a point; two
# points are one if they are this close.
_ANGLES, _LENGTHS = 8, 6
_STEPS, _DIFFERENCE, _FOUND, _SAME = 12, 1e-6, 1e-10, 1e-5


@kernel
def distance_from_isotropy(
    r: float, l_a: float, l_b: float, length: float, theta: float, elbow1: float, elbow2: float
) -> tuple[float, float]:
    """Return the two components of g, R = 1."""
    c, s = math.cos(theta), math.sin(theta)
    j1, j2, m11, m12, m21, m22 = scaled_matrices(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
    row1 = j2 * j2 * (m11 * m11 + m12 * m12)
    row2 = j1 * j1 * (m21 * m21 + m22 * m22)
    total = row1 + row2 + TINY
    return (row1 - row2) / total, 2.0 * j1 * j2 * (m11 * m21 + m12 * m22) / total


@kernel
def isotropic_points(
    r: float, l_a: float, l_b: float, theta_limit: float, elbow1: float, elbow2: float,
    sign: float, conditions: int, out: FloatArray,
) -> int:  # fmt: skip
    """Find the isotropic points of a mode pair, those of all parts of its workspace.

    Parameters
    ----------
    r, l_a, l_b, elbow1, elbow2, sign, conditions
        As for :func:`columns.find_column`.
    theta_limit
        Largest angle of the passive leg. Where the elbows are symmetric only angles of at
        least 0 are looked at.
    out
        Receives l and θ, by rising |θ| of where they were found from, shape (MAX_ISOTROPIC, 2).

    Returns
    -------
    int
        Their number.
    """
    is_half = elbow1 == -elbow2
    largest = l_a + l_b
    count = 0
    for place in range(_ANGLES if is_half else 2 * _ANGLES):
        middle = (place if is_half else place // 2) + 0.02
        start = middle * theta_limit / _ANGLES * (1.0 if is_half or place % 2 == 0 else -1.0)
        for step in range(_LENGTHS):
            length, theta = largest * (step + 0.5) / _LENGTHS, start
            is_found = False
            for _ in range(_STEPS):
                if not reaches_at(1.0, r, l_a, l_b, length, math.cos(theta), math.sin(theta)):
                    break
                g1, g2 = distance_from_isotropy(r, l_a, l_b, length, theta, elbow1, elbow2)
                if abs(g1) + abs(g2) < _FOUND:
                    is_found = True
                    break
                h1, h2 = distance_from_isotropy(
                    r, l_a, l_b, length + _DIFFERENCE, theta, elbow1, elbow2
                )
                k1, k2 = distance_from_isotropy(
                    r, l_a, l_b, length, theta + _DIFFERENCE, elbow1, elbow2
                )
                a, b = (h1 - g1) / _DIFFERENCE, (k1 - g1) / _DIFFERENCE
                c, d = (h2 - g2) / _DIFFERENCE, (k2 - g2) / _DIFFERENCE
                det = a * d - b * c
                if det == 0.0:
                    break
                by_length, by_theta = (d * g1 - b * g2) / det, (a * g2 - c * g1) / det
                size = max(abs(by_length) / largest, abs(by_theta))
                share = min(1.0, 0.15 / size) if size > 0.0 else 1.0
                length -= share * by_length
                theta -= share * by_theta
                if length <= 0.0 or abs(theta) > theta_limit:
                    break
            if not is_found:
                continue
            if is_half:
                theta = abs(theta) if abs(theta) > _SAME else 0.0
            f, q1, q2 = conditions_at(
                1.0, r, l_a, l_b, length, math.cos(theta), math.sin(theta), elbow1, elbow2
            )
            if sign * f <= 0.0 or (conditions & PASSIVE_JOINTS and (q1 <= 0.0 or q2 <= 0.0)):
                continue
            is_new = True
            for k in range(count):
                if abs(out[k, 0] - length) + abs(out[k, 1] - theta) < _SAME:
                    is_new = False
            if is_new and count < MAX_ISOTROPIC:
                out[count, 0], out[count, 1] = length, theta
                count += 1
    return count
