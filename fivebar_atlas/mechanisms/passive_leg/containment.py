"""What holds on discs and segments, not only at points: bounds of the LCI and of the inputs.

With m_i row i of J_x in platform axes, η_i its direction and j_i = l_a l_b sin β_i the entry of
J_q, the rows of J are m_i / j_i and

    q = 2 / (κ + 1/κ) = |sin γ| / cosh w,   γ = η2 - η1,   w = ln |m1/j1| - ln |m2/j2|.

Over a disc of radius h about C, ln q falls by no more than h times the largest |∇ ln q|,

    ∇ ln q = cot γ ∇γ - tanh w ∇w.

That is bounded by arithmetic with midpoints and radii: every term is its value at C and a radius
that holds on the disc. All radii shrink like h, so the bound differs from the least value by
terms in h². Gradients have the components ∂/∂l and (∂/∂θ)/l. In platform axes, with the leg
vector (e, f) = (a, b) + (p, q), lower and upper link, and its derivative (e', f'),

    ψ' = (e' p + f' q) / j,   χ' = -(e' a + f' b) / j,   j = a q - b p = ½ √W,

ψ and χ the directions of the links and W the function of the squared length of a leg that vanishes
where it is stretched or folded; and with k = r/l, σ = ±1, m = (p - σ k q, q)

    |m|² η' = l_b² χ' + σ q² k',
    |m|² (ln |m|)' = χ' σ k (k σ p q - p² + q²) - σ k' q (p - σ k q).

On a segment only the derivative along it counts, and legs change by less: next to a boundary that
it does not come nearer to it may be much longer than a disc is wide.

Nothing is said where a leg may be straight, γ may be zero or the passive leg may have no length,
nor where it may leave its limit or, if they count, an upper link may rise above the platform: the
disc then may reach over the boundary of a workspace. Bounds hold but for rounding.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.jacobian import TINY
from fivebar_atlas.mechanisms.passive_leg.kinematics import (
    leg_vector,
    lower_link,
    squared_four_areas,
)

# Rounding of an angle of the passive leg at its limit.
_ROUNDING = 1e-12


@kernel
def _product(m1: float, r1: float, m2: float, r2: float) -> tuple[float, float]:
    """Return midpoint and radius of the product of two ranges."""
    return m1 * m2, abs(m1) * r2 + r1 * (abs(m2) + r2)


@kernel
def _inverse(middle: float, radius: float) -> tuple[float, float]:
    """Return midpoint and radius of 1/x over a range that does not hold zero."""
    low = abs(middle) - radius
    return 1.0 / middle, radius / (abs(middle) * low)


@kernel
def _turned(length: float, cosine: float, sine: float, turn: float) -> tuple[float, float]:
    """Return by how much both components of a link change when it turns by ``turn`` at most."""
    # |cos(χ + t) - cos χ| ≤ |sin χ| t + t²/2, and no more than a chord
    chord = min(turn, 2.0)
    return (
        length * min(abs(sine) * turn + 0.5 * turn * turn, chord),
        length * min(abs(cosine) * turn + 0.5 * turn * turn, chord),
    )


@kernel
def _change(radius: float, by_length: float, by_theta: float, along: float, across: float) -> float:
    """Bound the change of a function within a radius by its derivatives by l and by θ over l.

    ``along`` and ``across`` are the largest components of the direction of motion on w and on u.
    """
    norm = math.sqrt(by_length * by_length + by_theta * by_theta)
    return radius * min(norm, by_length * along + by_theta * across)


@kernel
def _leg_bounds(
    base: float, platform: float, l_a: float, l_b: float, length: float, theta: float,
    radius: float, stretch: float, sway: float, along: float, across: float,
    leg: float, elbow: float,
) -> tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float
]:  # fmt: skip
    """Return what a disc or a segment says of one leg.

    Parameters
    ----------
    base, platform, l_a, l_b, length, theta
        Design and centre.
    radius
        Radius of the disc or half the segment, less than the length.
    stretch, sway
        Largest changes of l and of θ.
    along, across
        As for :func:`_change`.
    leg, elbow
        +1 for leg 1, -1 for leg 2, and its elbow.

    Returns
    -------
    tuple of float
        Least q on the disc; NaN where nothing can be said, and the rest then is 0. The row m_i at
        the centre; |j| there; the most that the input turns; and midpoint and radius of ∂/∂l and
        (∂/∂θ)/l of the direction of the row, then of the logarithm of its length over |j|.
    """
    nothing = (math.nan, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    c, s = math.cos(theta), math.sin(theta)
    e, f = leg_vector(base, platform, length, c, s, leg)
    c_r = min(abs(s) * sway + 0.5 * sway * sway, sway)
    s_r = min(abs(c) * sway + 0.5 * sway * sway, sway)
    e_r, f_r = base * c_r, stretch + base * s_r
    e2, e2_r = _product(e, e_r, e, e_r)
    f2, f2_r = _product(f, f_r, f, f_r)
    reach2, reach2_r = e2 + f2, e2_r + f2_r
    outer, inner = (l_a + l_b) * (l_a + l_b), (l_a - l_b) * (l_a - l_b)
    if not (reach2 + reach2_r < outer and reach2 - reach2_r > inner):
        return nothing
    # W is concave in the squared length: least at one of the ends
    areas2 = squared_four_areas(l_a, l_b, reach2)
    least2 = min(
        squared_four_areas(l_a, l_b, reach2 - reach2_r),
        squared_four_areas(l_a, l_b, reach2 + reach2_r),
    )
    # and most at one of them or between
    top = 0.5 * (outer + inner)
    nearest = min(max(top, reach2 - reach2_r), reach2 + reach2_r)
    most2 = squared_four_areas(l_a, l_b, nearest)
    least_j, j, most_j = 0.5 * math.sqrt(least2), 0.5 * math.sqrt(areas2), 0.5 * math.sqrt(most2)
    a, b = lower_link(l_a, l_b, e, f, elbow)
    p, q = e - a, f - b
    side = 1.0 if a * q - b * p >= 0.0 else -1.0

    # the links turn by no more than this, first roughly
    inv_l, inv_l_r = _inverse(length, stretch)
    way = _change(radius, 1.0, base * (inv_l + inv_l_r), along, across) / least_j
    turn_a, turn_b = l_b * way, l_a * way
    a_r, b_r = _turned(l_a, a / l_a, b / l_a, turn_a)
    p_r, q_r = _turned(l_b, p / l_b, q / l_b, turn_b)

    inv_j = side / j
    inv_j_r = max(1.0 / least_j - 1.0 / j, 1.0 / j - 1.0 / most_j)
    # e' and f' by l are 0 and 1, by θ over l they are σ R s / l and σ R c / l
    es, es_r = _product(leg * base * s, base * s_r, inv_l, inv_l_r)
    fc, fc_r = _product(leg * base * c, base * c_r, inv_l, inv_l_r)
    chi_l, chi_l_r = _product(-b, b_r, inv_j, inv_j_r)
    t1, t1_r = _product(es, es_r, a, a_r)
    t2, t2_r = _product(fc, fc_r, b, b_r)
    chi_t, chi_t_r = _product(-t1 - t2, t1_r + t2_r, inv_j, inv_j_r)

    k, k_r = platform * inv_l, platform * inv_l_r
    k_l, k_l_r = _product(-k, k_r, inv_l, inv_l_r)
    kq, kq_r = _product(leg * k, k_r, q, q_r)
    m, m_r = p - kq, p_r + kq_r
    m2, m2_r = _product(m, m_r, m, m_r)
    q2, q2_r = _product(q, q_r, q, q_r)
    size2, size2_r = m2 + q2, m2_r + q2_r
    if not size2 - size2_r > 0.0:
        return nothing
    inv_s, inv_s_r = _inverse(size2, size2_r)
    # the direction of the row
    u, u_r = _product(q2, q2_r, leg * k_l, k_l_r)
    eta_l, eta_l_r = _product(l_b * l_b * chi_l + u, l_b * l_b * chi_l_r + u_r, inv_s, inv_s_r)
    eta_t, eta_t_r = _product(l_b * l_b * chi_t, l_b * l_b * chi_t_r, inv_s, inv_s_r)
    # the logarithm of its length
    pq, pq_r = _product(p, p_r, q, q_r)
    p2, p2_r = _product(p, p_r, p, p_r)
    v, v_r = _product(leg * k, k_r, pq, pq_r)
    v, v_r = _product(v + q2 - p2, v_r + q2_r + p2_r, leg * k, k_r)
    w_l, w_l_r = _product(v, v_r, chi_l, chi_l_r)
    w_t, w_t_r = _product(v, v_r, chi_t, chi_t_r)
    qm, qm_r = _product(q, q_r, m, m_r)
    z, z_r = _product(leg * k_l, k_l_r, qm, qm_r)
    w_l, w_l_r = _product(w_l - z, w_l_r + z_r, inv_s, inv_s_r)
    w_t, w_t_r = _product(w_t, w_t_r, inv_s, inv_s_r)
    # less that of |j|: ½ (ln W)' is ((top - D) / W) D', D the squared length of the leg
    low2, high2 = reach2 - reach2_r, reach2 + reach2_r
    slope = 1.0 / (low2 - inner) - 1.0 / (outer - low2)
    slope_high = 1.0 / (high2 - inner) - 1.0 / (outer - high2)
    g = 0.5 * (1.0 / (reach2 - inner) - 1.0 / (outer - reach2))
    g_r = max(abs(0.5 * slope - g), abs(0.5 * slope_high - g))
    d_l, d_l_r = _product(g, g_r, 2.0 * f, 2.0 * f_r)
    x1, x1_r = _product(es, es_r, 2.0 * e, 2.0 * e_r)
    x2, x2_r = _product(fc, fc_r, 2.0 * f, 2.0 * f_r)
    d_t, d_t_r = _product(g, g_r, x1 + x2, x1_r + x2_r)
    most_turn = radius * math.sqrt(size2 + size2_r) / least_j
    return (
        q - q_r, m, q, j, most_turn,
        eta_l, eta_l_r, eta_t, eta_t_r,
        w_l - d_l, w_l_r + d_l_r, w_t - d_t, w_t_r + d_t_r,
    )  # fmt: skip


@kernel
def _least_lci(
    base: float, platform: float, l_a: float, l_b: float, limit: float, below: bool,
    length: float, theta: float, radius: float, stretch: float, sway: float,
    along: float, across: float, elbow1: float, elbow2: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Bound LCI and turns; arguments as for :func:`_leg_bounds` and :func:`least_lci_on_disc`."""
    if not abs(theta) + sway <= limit + _ROUNDING:
        return 0.0, math.inf, math.inf
    (
        q1, mx1, my1, j1, turn1, el1, el1_r, et1, et1_r, wl1, wl1_r, wt1, wt1_r,
    ) = _leg_bounds(
        base, platform, l_a, l_b, length, theta, radius, stretch, sway, along, across, 1.0, elbow1
    )  # fmt: skip
    (
        q2, mx2, my2, j2, turn2, el2, el2_r, et2, et2_r, wl2, wl2_r, wt2, wt2_r,
    ) = _leg_bounds(
        base, platform, l_a, l_b, length, theta, radius, stretch, sway, along, across, -1.0, elbow2
    )  # fmt: skip
    if math.isnan(q1) or math.isnan(q2) or (below and not min(q1, q2) > 0.0):
        return 0.0, math.inf, math.inf
    cross = mx1 * my2 - my1 * mx2
    dot = mx1 * mx2 + my1 * my2
    gamma = math.atan2(cross, dot)
    gl, gl_r, gt, gt_r = el2 - el1, el1_r + el2_r, et2 - et1, et1_r + et2_r
    gamma_r = _change(radius, abs(gl) + gl_r, abs(gt) + gt_r, along, across)
    # of γ folded into [0, π/2]: sin |γ| grows there, and the fold itself does not matter
    folded = math.atan2(abs(cross), abs(dot))
    if not folded - gamma_r > 0.0:
        return 0.0, math.inf, math.inf
    cot = dot / cross
    # (cot γ)' = -1/sin² γ, largest where sin γ is least
    least_sine = math.sin(folded - gamma_r)
    cot_r = gamma_r / (least_sine * least_sine)
    wl, wl_r, wt, wt_r = wl1 - wl2, wl1_r + wl2_r, wt1 - wt2, wt1_r + wt2_r
    big1 = (mx1 * mx1 + my1 * my1) * j2 * j2
    big2 = (mx2 * mx2 + my2 * my2) * j1 * j1
    tanh = (big1 - big2) / (big1 + big2)
    w_r = _change(radius, abs(wl) + wl_r, abs(wt) + wt_r, along, across)
    tanh_r = min(w_r, 2.0)
    a, a_r = _product(cot, cot_r, gl, gl_r)
    b, b_r = _product(tanh, tanh_r, wl, wl_r)
    by_length = abs(a - b) + a_r + b_r
    a, a_r = _product(cot, cot_r, gt, gt_r)
    b, b_r = _product(tanh, tanh_r, wt, wt_r)
    by_theta = abs(a - b) + a_r + b_r
    fall = _change(radius, by_length, by_theta, along, across)
    sine = abs(math.sin(gamma))
    ratio = 2.0 * math.sqrt(big1 * big2) / (big1 + big2) * sine * math.exp(-fall)
    return (
        # c of 2 c / (1 + c²), in the form that loses no digits
        ratio / (1.0 + math.sqrt(max((1.0 - ratio) * (1.0 + ratio), 0.0))),
        turn1,
        turn2,
    )


@kernel
def least_lci_on_disc(
    base: float, platform: float, l_a: float, l_b: float, limit: float, below: bool,
    x: float, y: float, radius: float, elbow1: float, elbow2: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Return a lower bound of the LCI on a disc, and how far the inputs turn at most.

    Parameters
    ----------
    base, platform, l_a, l_b
        Design.
    limit
        Largest angle of the passive leg.
    below
        Whether upper links must stay below the platform.
    x, y, radius
        The disc.
    elbow1, elbow2
        Elbows as ±1.

    Returns
    -------
    tuple of float
        No point of the disc has a smaller LCI; 0 where nothing can be said. Then the largest
        differences of φ1 and φ2, in radians, between a point of the disc and its centre;
        infinite where nothing can be said.
    """
    length = math.sqrt(x * x + y * y)
    if not radius < length:
        return 0.0, math.inf, math.inf
    return _least_lci(
        base, platform, l_a, l_b, limit, below, length, math.atan2(-x, y), radius, radius,
        math.asin(radius / length), 1.0, 1.0, elbow1, elbow2,
    )  # fmt: skip


@kernel
def bounds_on_discs(
    base: float, platform: float, l_a: float, l_b: float, limit: float, below: bool,
    x: FloatArray, y: FloatArray, radius: FloatArray, elbow1: float, elbow2: float,
    least: FloatArray, turns: FloatArray,
) -> None:  # fmt: skip
    """Fill in least LCI and largest turns over discs, shapes (n,) and (n, 2)."""
    for k in range(len(x)):
        least[k], turns[k, 0], turns[k, 1] = least_lci_on_disc(
            base, platform, l_a, l_b, limit, below, x[k], y[k], radius[k], elbow1, elbow2
        )


@kernel
def bounds_on_segments(
    base: float, platform: float, l_a: float, l_b: float, limit: float, below: bool,
    x: FloatArray, y: FloatArray, dx: FloatArray, dy: FloatArray, elbow1: float, elbow2: float,
    least: FloatArray, turns: FloatArray,
) -> None:  # fmt: skip
    """Fill in least LCI and largest turns on segments, shapes (n,) and (n, 2).

    Parameters
    ----------
    base, platform, l_a, l_b, limit, below, elbow1, elbow2
        As for :func:`least_lci_on_disc`.
    x, y, dx, dy
        Middles of the segments, and from there to one of their ends, shape (n,) each.
    least, turns
        As those of :func:`bounds_on_discs`; turns are those from the middle.
    """
    for k in range(len(x)):
        length = math.sqrt(x[k] * x[k] + y[k] * y[k])
        half = math.sqrt(dx[k] * dx[k] + dy[k] * dy[k])
        least[k], turns[k, 0], turns[k, 1] = 0.0, math.inf, math.inf
        if half < length:
            # components on w, which points from O to C, and on u
            on_w = abs(dx[k] * x[k] + dy[k] * y[k]) / length
            on_u = abs(dx[k] * y[k] - dy[k] * x[k]) / length
            sway = math.atan2(on_u, length - on_w)
            stretch = on_w + 0.5 * on_u * on_u / (length - on_w)
            along = min(on_w / (half + TINY) + sway, 1.0)
            across = min(on_u / (half + TINY) + sway, 1.0)
            least[k], turns[k, 0], turns[k, 1] = _least_lci(
                base, platform, l_a, l_b, limit, below, length, math.atan2(-x[k], y[k]),
                half, stretch, sway, along, across, elbow1, elbow2,
            )  # fmt: skip
