"""Singularities of the manipulator with a passive leg, and what bounds its workspace (Sec. 4, 5.2).

With n_i = (p_i, q_i) the upper link of leg i in the axes u and w of the platform:

- first kind (serial): a leg stretched or folded, (2 l_a l_b sin β_i)² = 0 (Eq. 22);
- second kind (parallel): f = l (p1 q2 - p2 q1) - 2 r q1 q2 = l det J_x = 0 (Eq. 24), where the
  upper links and the perpendicular to the passive leg through O meet in one point;
- third kind: both at once.

The passive joints b_i are at their limit where q_i = 0: the upper link is parallel to the platform
(Eq. 13). With both elbows outward and q_1, q_2 > 0 Eq. 25 holds and f < 0.
"""

from __future__ import annotations

import math

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.kinematics import (
    leg_vector,
    lower_link,
    squared_four_areas,
)

#: What ends an interval of lengths of the passive leg, and bounds a workspace.
NO_LENGTH, OUTER_1, OUTER_2, INNER_1, INNER_2, FORWARD, LIMIT_1, LIMIT_2 = range(8)
#: Bits of :func:`singularity_kind`.
LEG_1, LEG_2, PARALLEL = 1, 2, 4


@kernel
def conditions_at(
    base: float, platform: float, l_a: float, l_b: float, length: float, c: float, s: float,
    elbow1: float, elbow2: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Return f, q_1 and q_2 of a pose within reach.

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
    return length * (p1 * q2 - p2 * q1) - 2.0 * platform * q1 * q2, q1, q2


def singularity_kind(
    base: float, platform: float, l_a: float, l_b: float, length: float, theta: float,
    elbow1: float, elbow2: float, tolerance: float = 1e-9,
) -> int:  # fmt: skip
    """Return the kinds of singularity of a pose as bits.

    Parameters
    ----------
    base, platform, l_a, l_b, length, theta, elbow1, elbow2
        As for :func:`kinematics.inverse`.
    tolerance
        Bound of |sin β_i| and of |f| over l l_b² + 2 r l_b².

    Returns
    -------
    int
        1 and 2: leg 1 or 2 stretched or folded (first kind); 4: second kind; a sum of both is of
        the third kind. 0 where regular, -1 where a leg does not reach or l is not above 0.
    """
    c, s = math.cos(theta), math.sin(theta)
    if not length > 0.0:
        return -1
    found = 0
    for bit, leg in ((LEG_1, 1.0), (LEG_2, -1.0)):
        e, f = leg_vector(base, platform, length, c, s, leg)
        areas = squared_four_areas(l_a, l_b, e * e + f * f)
        largest = (2.0 * l_a * l_b * tolerance) ** 2
        if areas < -largest:
            return -1
        if areas <= largest:
            found |= bit
    f, _, _ = conditions_at(base, platform, l_a, l_b, length, c, s, elbow1, elbow2)
    if abs(f) <= tolerance * (length + 2.0 * platform) * l_b * l_b:
        found |= PARALLEL
    return found


def stretch_lengths(
    base: float, platform: float, reach: float, theta: FloatArray, leg: float
) -> tuple[FloatArray, FloatArray]:
    """Return the two lengths of the passive leg at which a leg spans a distance (Eq. 12).

    Parameters
    ----------
    base, platform
        R and r.
    reach
        l_a + l_b for the stretched leg, |l_a - l_b| for the folded one.
    theta
        Angles of the passive leg, shape (n,).
    leg
        +1 for leg 1, -1 for leg 2.

    Returns
    -------
    tuple of ndarray
        The smaller and the larger length, shape (n,) each; NaN where there is none. Eq. 12 is the
        larger one of the leg on the platform's lower side, without the paper's division by 2.
    """
    gap = platform - base * np.cos(theta)
    with np.errstate(invalid="ignore"):
        half = np.sqrt((reach - gap) * (reach + gap))
    middle = -leg * base * np.sin(theta)
    return middle - half, middle + half
