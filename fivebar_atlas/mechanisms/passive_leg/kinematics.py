"""Inverse kinematics of the manipulator with a passive leg (Nam and Park 2006, Sec. 3.1).

The passive leg stands on the middle O of the base, has the length l = l_c and makes the angle θ
with the y axis; the platform is perpendicular to it at its end C (Eqs. 1, 7):

    C = l w,   b1 = C + r u,   b2 = C - r u,   u = (cos θ, sin θ),   w = (-sin θ, cos θ)

Leg i runs from B_i = (±R, 0) over the elbow d_i to b_i, with links l_a and l_b. In the axes u and
w of the platform the vector from B_i to b_i is

    leg 1: (r - R cos θ, l + R sin θ),   leg 2: (R cos θ - r, l - R sin θ),

and nothing here calls a trigonometric function but for u and w themselves. Scalar kernels,
arguments in the fixed order ``R, r, l_a, l_b, l, theta``, then elbows as ±1. Lengths in any
one unit, angles in radians.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel


@kernel
def squared_four_areas(l_a: float, l_b: float, reach2: float) -> float:
    """Return (2 l_a l_b sin β)², β the elbow angle, from the squared length of a leg.

    Factored, so that it is accurate up to the serial singularities, where it is zero;
    negative where the leg does not reach.
    """
    outer = l_a + l_b
    inner = l_a - l_b
    return (outer * outer - reach2) * (reach2 - inner * inner)


@kernel
def leg_vector(
    base: float, platform: float, length: float, c: float, s: float, leg: float
) -> tuple[float, float]:
    """Return the vector from B_i to b_i in the axes u and w of the platform.

    Parameters
    ----------
    base, platform
        R and r.
    length, c, s
        Length of the passive leg; cosine and sine of its angle.
    leg
        +1 for leg 1, -1 for leg 2.
    """
    return leg * (platform - base * c), length + leg * base * s


@kernel
def reaches_at(
    base: float, platform: float, l_a: float, l_b: float, length: float, c: float, s: float
) -> bool:
    """Tell whether both legs reach a pose, borders included, from cosine and sine of its angle."""
    e1, f1 = leg_vector(base, platform, length, c, s, 1.0)
    e2, f2 = leg_vector(base, platform, length, c, s, -1.0)
    return (
        squared_four_areas(l_a, l_b, e1 * e1 + f1 * f1) >= 0.0
        and squared_four_areas(l_a, l_b, e2 * e2 + f2 * f2) >= 0.0
    )


@kernel
def reaches(
    base: float, platform: float, l_a: float, l_b: float, length: float, theta: float
) -> bool:
    """Tell whether both legs reach a pose: the workspace without limits, borders included."""
    return reaches_at(base, platform, l_a, l_b, length, math.cos(theta), math.sin(theta))


@kernel
def lower_link(l_a: float, l_b: float, e: float, f: float, elbow: float) -> tuple[float, float]:
    """Return the vector of the lower link, from B_i to d_i, in the axes of the leg's vector.

    Parameters
    ----------
    l_a, l_b
        Lower and upper link.
    e, f
        Vector from B_i to b_i.
    elbow
        +1 for the elbow counter-clockwise of the leg, -1 for the other one. With the elbows
        outward (Fig. 1) it is -1 for leg 1, at +R, and +1 for leg 2.

    Returns
    -------
    tuple of float
        Components on the axes that e and f are on. Beyond reach that of the stretched or the
        folded leg's direction; for a leg of no length (l_a = l_b), which may point anywhere,
        zero.
    """
    reach2 = e * e + f * f
    if reach2 == 0.0:
        return 0.0, 0.0
    along = 0.5 * (reach2 + (l_a - l_b) * (l_a + l_b)) / reach2
    across = 0.5 * elbow * math.sqrt(max(squared_four_areas(l_a, l_b, reach2), 0.0)) / reach2
    return along * e - across * f, along * f + across * e


@kernel
def inverse(
    base: float, platform: float, l_a: float, l_b: float, length: float, theta: float,
    elbow1: float, elbow2: float,
) -> tuple[float, float]:  # fmt: skip
    """Return the input angles φ1, φ2 in (-π, π] of a pose (Eqs. 2 to 6).

    Parameters
    ----------
    base, platform, l_a, l_b
        R, r and the lengths of the lower and the upper links.
    length, theta
        Pose: length and angle of the passive leg.
    elbow1, elbow2
        Elbows as for :func:`lower_link`; the paper's "+" in Eq. 6 is -1 for leg 1, its "-" is
        +1 for leg 2.
    """
    c, s = math.cos(theta), math.sin(theta)
    e1, f1 = leg_vector(base, platform, length, c, s, 1.0)
    e2, f2 = leg_vector(base, platform, length, c, s, -1.0)
    p1, q1 = lower_link(l_a, l_b, e1, f1, elbow1)
    p2, q2 = lower_link(l_a, l_b, e2, f2, elbow2)
    # from the axes u and w to x and y
    return (
        math.atan2(p1 * s + q1 * c, p1 * c - q1 * s),
        math.atan2(p2 * s + q2 * c, p2 * c - q2 * s),
    )
