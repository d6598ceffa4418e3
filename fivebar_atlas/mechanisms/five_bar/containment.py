"""What holds on whole discs, not only at points: bounds of the LCI and of the input angles.

Over a disc of radius h about P every distance d_i = |P - A_i| changes by at most h. With
W_i = (2 r1 r2 sin β_i)² = ((r1 + r2)² - d_i²)(d_i² - (r1 - r2)²), which is concave in d_i²,
that bounds the sines of the elbow angles from below. The component of P' along the crank is
r2 δ_i' sin β_i, and that along the distal link is r1 θ_i' sin β_i, up to signs: a crank turns by
no more than h / (r1 sin β_i), with the least sine of the disc. The LCI is bounded through

    q = 2 / (κ + 1/κ) = |sin γ| / cosh w,   w = ½ ln(W1 / W2),   γ = δ2 - δ1,

to second order: ln q falls by no more than h |∇ ln q(P)| + ½ h² M, where M bounds the second
derivatives on the disc. With the norms of second derivatives

    |∇²w| ≤ ½ Σ (4 d_i² |L_i''| + 2 |L_i'|),        L_i = ln W_i as a function of d_i²,
    |∇²δ_i| ≤ (1 + d_i / (r2 sin β_i)) / (r1 r2 sin² β_i)

and the gradients g on the disc, none larger than at P by more than h times these,

    M = |g_w|² + tanh|w| |∇²w| + |g_γ|² / sin² γ + |cot γ| |∇²γ|.

Where the least sines or the least |sin γ| are zero nothing is said; where they are not the
disc holds no singularity. Bounds hold but for rounding, some 1e-15.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.jacobian import TINY, distal_products
from fivebar_atlas.mechanisms.five_bar.kinematics import squared_four_areas


@kernel
def _leg_on_disc(
    r1: float, r2: float, u: float, y: float, radius: float, sign: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return what a disc says of one leg.

    Parameters
    ----------
    r1, r2
        Actuated and distal link.
    u, y
        Centre of the disc, relative to the base joint.
    radius
        Its radius.
    sign
        Working mode of the leg.

    Returns
    -------
    tuple of float
        Least 2 r1 r2 sin β on the disc, 0 where it may be singular (the rest then is 0);
        gradients of ½ ln W and of the direction δ of the distal link at the centre, and the
        largest norms of their derivatives on the disc.
    """
    reach2 = u * u + y * y
    reach = math.sqrt(reach2)
    near2 = max(reach - radius, 0.0) ** 2
    far2 = (reach + radius) ** 2
    at_near = squared_four_areas(r1, r2, near2)
    at_far = squared_four_areas(r1, r2, far2)
    least2 = min(at_near, at_far)
    if not least2 > 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    sides = 2.0 * (r1 * r1 + r2 * r2)
    here2 = squared_four_areas(r1, r2, reach2)
    slope = (sides - 2.0 * reach2) / here2
    steepest = max(abs(sides - 2.0 * near2) / at_near, abs(sides - 2.0 * far2) / at_far)
    inner, outer = near2 - (r1 - r2) * (r1 - r2), (r1 + r2) * (r1 + r2) - far2
    bend = 1.0 / (inner * inner) + 1.0 / (outer * outer)
    least = math.sqrt(least2)
    # r1 r2 sin² β and r2 sin β are at least least²/(4 r1 r2) and least/(2 r1)
    turn_bend = 4.0 * r1 * r2 / least2 * (1.0 + 2.0 * r1 * (reach + radius) / least)
    across = sign * (reach2 + (r1 - r2) * (r1 + r2)) / (reach2 * math.sqrt(here2))
    return (
        least,
        slope * u,
        slope * y,
        across * u - y / reach2,
        across * y + u / reach2,
        2.0 * far2 * bend + steepest,
        turn_bend,
    )


@kernel
def least_lci_on_disc(
    r1: float, r2: float, r3: float, x: float, y: float, radius: float, s1: float, s2: float
) -> tuple[float, float, float]:
    """Return a lower bound of the LCI on a disc, and how far the cranks turn at most.

    Parameters
    ----------
    r1, r2, r3, x, y
        Design and centre.
    radius
        Radius of the disc.
    s1, s2
        Working mode as ±1.

    Returns
    -------
    tuple of float
        No point of the disc has a smaller LCI; 0 where nothing can be said. Where it is
        positive det B has one sign on the disc. Then the largest differences of θ1 and θ2, in
        radians, between a point of the disc and its centre; infinite where nothing can be said.
    """
    low_1, wx_1, wy_1, tx_1, ty_1, w_bend_1, t_bend_1 = _leg_on_disc(r1, r2, x + r3, y, radius, s1)
    low_2, wx_2, wy_2, tx_2, ty_2, w_bend_2, t_bend_2 = _leg_on_disc(r1, r2, x - r3, y, radius, s2)
    if low_1 == 0.0 or low_2 == 0.0:
        return 0.0, math.inf, math.inf
    w1, w2, cross, dot, _ = distal_products(r1, r2, r3, x, y, s1, s2)
    cross, signed_dot = abs(cross), dot if cross >= 0.0 else -dot
    length = math.sqrt(cross * cross + dot * dot)
    gamma = math.atan2(cross, abs(dot))
    # of γ folded into [0, π/2]; the fold does not matter, for sin γ has its largest value there
    g_bend = t_bend_1 + t_bend_2
    gx, gy = tx_2 - tx_1, ty_2 - ty_1
    g_rate = math.sqrt(gx * gx + gy * gy) + radius * g_bend
    least_gamma = gamma - radius * g_rate
    if not least_gamma > 0.0:
        return 0.0, math.inf, math.inf
    w_bend = w_bend_1 + w_bend_2
    wx, wy = wx_1 - wx_2, wy_1 - wy_2
    w_rate = math.sqrt(wx * wx + wy * wy) + radius * w_bend
    tanh = (w1 - w2) * (w1 + w2) / (w1 * w1 + w2 * w2)
    sine, cotangent = cross / length, signed_dot / (cross + TINY)
    slope_x = cotangent * gx - tanh * wx
    slope_y = cotangent * gy - tanh * wy
    least_sine = math.sin(least_gamma)
    bend = (
        w_rate * w_rate
        + min(abs(tanh) + radius * w_rate, 1.0) * w_bend
        + g_rate * g_rate / (least_sine * least_sine)
        + math.cos(least_gamma) / least_sine * g_bend
    )
    fall = radius * (math.sqrt(slope_x * slope_x + slope_y * slope_y) + 0.5 * radius * bend)
    ratio = 2.0 * w1 * w2 / (w1 * w1 + w2 * w2) * sine * math.exp(-fall)
    return (
        # c of 2 c / (1 + c²), in the form that loses no digits
        ratio / (1.0 + math.sqrt((1.0 - ratio) * (1.0 + ratio))),
        2.0 * r2 * radius / low_1,
        2.0 * r2 * radius / low_2,
    )


@kernel
def bounds_on_discs(
    r1: float, r2: float, r3: float, x: FloatArray, y: FloatArray, radius: FloatArray,
    s1: float, s2: float, least: FloatArray, turns: FloatArray,
) -> None:  # fmt: skip
    """Fill in least LCI and largest turns over discs, shapes (n,) and (n, 2)."""
    for k in range(len(x)):
        least[k], turns[k, 0], turns[k, 1] = least_lci_on_disc(
            r1, r2, r3, x[k], y[k], radius[k], s1, s2
        )
