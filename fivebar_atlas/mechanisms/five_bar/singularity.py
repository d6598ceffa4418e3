"""Singular loci of the symmetric 5R manipulator in polar form (Liu et al. 2006, Sec. 4).

Every curve that can bound a usable workspace is closed form in polar coordinates ρ(φ)
about the origin O, the middle of the base:

- serial (first kind, A singular): the reach circles C_1o, C_1i, C_2o, C_2i, Eqs. 21 to 24;
- parallel (second kind, B singular), B1 and B2 coincident: the fold circles C_coin about
  F = (0, ±√(r1² - r3²)) with radius r2, Eq. 25;
- parallel, B1 P B2 stretched: C_col, Eq. 27 (whose second "a =" is "c ="), the curve of the
  middle of the coupler of a four-bar. With e the direction from B1 to B2 its distance from
  O obeys

      ρ² = r1² - r2² - r3² + 2 r3² cos² φ ± 2 r3 sin φ √(r2² - r3² cos² φ),
      e = (r3 cos φ / r2) e_ρ ∓ √(1 - r3² cos² φ / r2²) e_φ,

  from |P - r2 e - A1| = |P + r2 e - A2| = r1.

Each parallel locus belongs to a working mode piece by piece; the pieces join where the
locus touches a reach circle. A third kind (A and B singular) occurs only there.

Kernels take the direction of the ray as ``c, s`` = cos φ, sin φ. A circle that a ray can
meet twice is two curves, a far and a near sheet.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.jacobian import distal_products
from fivebar_atlas.numerics.arcs import circle_discriminant, circle_radius, circle_swept_area

# Curves, in an order that the functions below rely on.
ORIGIN = 0  #: the origin, lower end of a ray
C_1O = 1
C_2O = 2
C_1I_FAR = 3
C_1I_NEAR = 4
C_2I_FAR = 5
C_2I_NEAR = 6
FOLD_UP_FAR = 7
FOLD_UP_NEAR = 8
FOLD_DOWN_FAR = 9
FOLD_DOWN_NEAR = 10
COUPLER_PLUS = 11
COUPLER_MINUS = 12
CURVES = 13

#: Room for the critical angles of one design (at most 39 occur).
MAX_CRITICAL = 48
#: Designs this close to one at which curves begin to meet or to touch rays count as it: one
#: angle too many does no harm, one too few would.
SLACK = 1e-12
#: Critical angles closer than this are one: nothing fits between them.
LEAST_SECTOR = 1e-12

# Bits of a point's kind of singularity (Liu et al. 2006, Sec. 4).
SERIAL_LEG_1 = 1  #: leg 1 stretched or folded, A11 = 0 (first kind)
SERIAL_LEG_2 = 2  #: leg 2 stretched or folded, A22 = 0 (first kind)
PARALLEL_FOLDED = 4  #: B1 and B2 coincide, B P B folded (second kind)
PARALLEL_EXTENDED = 8  #: B1, P, B2 in line with P between (second kind)


@kernel
def fold_height(r1: float, r3: float) -> float:
    """Return √(r1² - r3²), the height of a fold circle's centre; NaN-free: 0 if r1 < r3."""
    return math.sqrt(max((r1 - r3) * (r1 + r3), 0.0))


@kernel
def circle_of(curve: int, r1: float, r2: float, r3: float) -> tuple[float, float, float, float]:
    """Return centre abscissa, centre ordinate, radius and sheet (±1) of a circle curve."""
    if curve <= C_2O:
        return (-r3 if curve == C_1O else r3), 0.0, r1 + r2, 1.0
    sheet = 1.0 if curve % 2 == 1 else -1.0
    if curve <= C_2I_NEAR:
        return (-r3 if curve <= C_1I_NEAR else r3), 0.0, abs(r1 - r2), sheet
    height = fold_height(r1, r3)
    return 0.0, (height if curve <= FOLD_UP_NEAR else -height), r2, sheet


@kernel
def coupler_root(r2: float, r3: float, c: float) -> float:
    """Return r2² - r3² cos² φ, which is not negative where C_col has points."""
    return (r2 - r3 * c) * (r2 + r3 * c)


@kernel
def coupler_squared_radius(
    r1: float, r2: float, r3: float, branch: float, c: float, s: float
) -> float:
    """Return ρ² of C_col on branch ±1; negative where the branch has no point.

    Written as r1² - (r3 s ∓ √(r2² - r3² c²))², which loses no digits near the origin.
    """
    root = math.sqrt(max(coupler_root(r2, r3, c), 0.0))
    lever = r3 * s - branch * root
    return (r1 - lever) * (r1 + lever)


@kernel
def coupler_radius_rate(curve: int, r2: float, r3: float, c: float, s: float) -> float:
    """Return d(ρ²)/dφ along a branch of C_col."""
    branch = 1.0 if curve == COUPLER_PLUS else -1.0
    root = math.sqrt(max(coupler_root(r2, r3, c), 1e-300))
    lever = r3 * s - branch * root
    return -2.0 * lever * (r3 * c - branch * r3 * r3 * c * s / root)


@kernel
def exists(curve: int, r1: float, r2: float, r3: float, c: float, s: float) -> bool:
    """Tell whether a ray meets a curve at a positive distance."""
    if curve >= COUPLER_PLUS:
        branch = 1.0 if curve == COUPLER_PLUS else -1.0
        return (
            coupler_root(r2, r3, c) >= 0.0
            and coupler_squared_radius(r1, r2, r3, branch, c, s) > 0.0
        )
    if curve >= FOLD_UP_FAR and r1 < r3:
        return False
    a, b, radius, sheet = circle_of(curve, r1, r2, r3)
    return (
        circle_discriminant(a, b, radius, c, s) >= 0.0
        and circle_radius(a, b, radius, sheet, c, s) > 0.0
    )


@kernel
def radius_along(curve: int, r1: float, r2: float, r3: float, c: float, s: float) -> float:
    """Return the distance ρ at which a ray meets a curve that exists there."""
    if curve == ORIGIN:
        return 0.0
    if curve >= COUPLER_PLUS:
        branch = 1.0 if curve == COUPLER_PLUS else -1.0
        return math.sqrt(max(coupler_squared_radius(r1, r2, r3, branch, c, s), 0.0))
    a, b, radius, sheet = circle_of(curve, r1, r2, r3)
    return max(circle_radius(a, b, radius, sheet, c, s), 0.0)


@kernel
def belongs_to_mode(
    curve: int, r1: float, r2: float, r3: float, c: float, s: float, s1: float, s2: float
) -> bool:
    """Tell whether a parallel locus, where a ray meets it, is singular for a working mode.

    Parameters
    ----------
    curve
        A fold circle or a branch of C_col.
    r1, r2, r3, c, s
        Design and direction of the ray.
    s1, s2
        Working mode as ±1.
    """
    rho = radius_along(curve, r1, r2, r3, c, s)
    x, y = rho * c, rho * s
    if curve >= COUPLER_PLUS:
        branch = 1.0 if curve == COUPLER_PLUS else -1.0
        along = r3 * c
        across = -branch * math.sqrt(max(coupler_root(r2, r3, c), 0.0))
        ex, ey = along * c - across * s, along * s + across * c  # r2 e
        side_1 = -((x + r3) * ey - y * ex)
        side_2 = (x - r3) * ey - y * ex
    else:
        height = fold_height(r1, r3)
        if curve >= FOLD_DOWN_FAR:
            height = -height
        side_1 = (x + r3) * height - y * r3
        side_2 = (x - r3) * height + y * r3
    return side_1 * s1 > 0.0 and side_2 * s2 > 0.0


@kernel
def coupler_antiderivative(
    r1: float, r2: float, r3: float, branch: float, phi: float, c: float, s: float
) -> float:
    """Return an antiderivative in φ of ρ²/2 along a branch of C_col (elementary).

    The angle with sine r3 cos φ / r2 is formed from the same root as the rest, so that
    rounding cancels where the curve turns back (root → 0).
    """
    root = math.sqrt(max(coupler_root(r2, r3, c), 0.0))
    wave = 0.5 * (r3 * c * root + r2 * r2 * math.atan2(r3 * c, root))
    even = ((r1 - r2) * (r1 + r2) - r3 * r3) * phi + r3 * r3 * (phi + s * c)
    return 0.5 * even - branch * wave


@kernel
def swept_area(curve: int, r1: float, r2: float, r3: float, phi0: float, phi1: float) -> float:
    """Return ½ ∫ ρ² dφ along a curve from phi0 to phi1, in closed form."""
    if curve == ORIGIN:
        return 0.0
    c0, s0 = math.cos(phi0), math.sin(phi0)
    c1, s1 = math.cos(phi1), math.sin(phi1)
    if curve >= COUPLER_PLUS:
        branch = 1.0 if curve == COUPLER_PLUS else -1.0
        return coupler_antiderivative(r1, r2, r3, branch, phi1, c1, s1) - coupler_antiderivative(
            r1, r2, r3, branch, phi0, c0, s0
        )
    a, b, radius, sheet = circle_of(curve, r1, r2, r3)
    rho0 = circle_radius(a, b, radius, sheet, c0, s0)
    rho1 = circle_radius(a, b, radius, sheet, c1, s1)
    return circle_swept_area(a, b, radius, sheet, rho0 * c0, rho0 * s0, rho1 * c1, rho1 * s1)


@kernel
def _note_angle(angle: float, least: float, greatest: float, out: FloatArray, count: int) -> int:
    """Append an angle, taken into [least, least + 2π), if it lies inside the sector."""
    if angle < least:
        angle += 2.0 * math.pi
    elif angle >= least + 2.0 * math.pi:
        angle -= 2.0 * math.pi
    if least < angle < greatest and count < len(out):
        out[count] = angle
        return count + 1
    return count


@kernel
def coupler_tangency(r1: float, r2: float, r3: float, outer: bool) -> tuple[float, float, bool]:
    """Return the direction from A1 to where C_col touches a reach circle of leg 1.

    There A1, B1, P and B2 are in line, B2 at r1 ± 2 r2 from A1 and at r1 from A2.

    Parameters
    ----------
    r1, r2, r3
        Lengths.
    outer
        Whether the circle is C_1o, the leg stretched, or C_1i.

    Returns
    -------
    tuple
        Cosine, sine (not negative) and whether there is such a point.
    """
    twist = r2 if outer else -r2
    scale = 4.0 * r3 * (r1 + 2.0 * twist)
    if scale == 0.0:
        return 0.0, 0.0, False
    # 1 ∓ cosine, factored: exact where the point comes to lie on the x axis
    below = 4.0 * (r3 - twist) * (r1 + twist - r3) / scale
    above = 4.0 * (r3 + twist) * (r1 + twist + r3) / scale
    if below < -SLACK or above < -SLACK:
        return 0.0, 0.0, False
    return 0.5 * (above - below), math.sqrt(max(below * above, 0.0)), True


@kernel
def critical_angles(
    r1: float, r2: float, r3: float, least: float, greatest: float, out: FloatArray
) -> int:
    """Collect the angles between which the order of the curves along a ray is constant.

    These are rays tangent to a curve or through a point where two curves meet; all in
    closed form. Angles that do not matter for a mode do no harm.

    Parameters
    ----------
    r1, r2, r3
        Lengths.
    least, greatest
        The sector of interest, at most a full turn.
    out
        Receives the sorted angles, both ends included, shape (MAX_CRITICAL,).

    Returns
    -------
    int
        Number of angles.
    """
    out[0] = least
    out[1] = greatest
    n = 2
    n = _note_angle(0.5 * math.pi, least, greatest, out, n)  # C_1o and C_2o, C_1i and C_2i meet
    inner = abs(r1 - r2)
    height = fold_height(r1, r3)
    for mirror in range(2):
        # each point or tangent ray of the right half has an image in the left one
        side = 1.0 if mirror == 0 else -1.0
        for flip in range(2):
            up = 1.0 if flip == 0 else -1.0
            if inner <= r3 + SLACK:  # rays tangent to an inner reach circle
                x = math.sqrt(max((r3 - inner) * (r3 + inner), 0.0))
                n = _note_angle(math.atan2(up * inner, side * x), least, greatest, out, n)
            if r3 > 0.0:  # an outer circle meets the inner circle of the other leg
                x = r1 * r2 / r3
                y2 = (inner - (x - r3)) * (inner + (x - r3))
                if y2 >= -SLACK:
                    y = up * math.sqrt(max(y2, 0.0))
                    n = _note_angle(math.atan2(y, side * x), least, greatest, out, n)
            if r1 >= r3:
                # C_coin touches a reach circle where P is in line with A2 and F
                for sign in range(2):
                    t = (r2 if sign == 0 else -r2) / r1
                    x, y = -side * t * r3, up * height * (1.0 + t)
                    n = _note_angle(math.atan2(y, x), least, greatest, out, n)
                if height >= r2 - SLACK:  # rays tangent to a fold circle
                    y = up * math.sqrt(max((height - r2) * (height + r2), 0.0))
                    n = _note_angle(math.atan2(y, side * r2), least, greatest, out, n)
            # C_col touches a reach circle of leg 1 (2): A, B, P and the other elbow in line
            for sign in range(2):
                c, s, possible = coupler_tangency(r1, r2, r3, sign == 0)
                if possible:
                    p_reach = r1 + (r2 if sign == 0 else -r2)
                    x, y = side * (p_reach * c - r3), up * p_reach * s
                    n = _note_angle(math.atan2(y, x), least, greatest, out, n)
            if r2 <= r3 + SLACK:  # rays tangent to C_col, or its branches cross
                x = math.sqrt(max((r3 - r2) * (r3 + r2), 0.0))
                n = _note_angle(math.atan2(up * x, side * r2), least, greatest, out, n)
            if r3 > 0.0:  # C_col passes through the origin
                gap = r2 * r2 + r3 * r3 - r1 * r1
                cos2 = (2.0 * r2 * r3 - gap) * (2.0 * r2 * r3 + gap)
                whole = 4.0 * r1 * r1 * r3 * r3
                if -SLACK <= cos2 <= whole + SLACK:
                    x = side * math.sqrt(max(cos2, 0.0))
                    y = up * math.sqrt(max(whole - cos2, 0.0))
                    n = _note_angle(math.atan2(y, x), least, greatest, out, n)
    angles = out[:n]
    angles.sort()
    kept = 1
    for k in range(1, n):
        if angles[k] - angles[kept - 1] > LEAST_SECTOR:
            angles[kept] = angles[k]
            kept += 1
    angles[kept - 1] = greatest
    return kept


@kernel
def singularity_kind(
    r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float, tolerance: float
) -> int:
    """Return the kinds of singularity of a reachable point in a working mode, as bits.

    Serial bits with a parallel one are a singularity of the third kind.

    Parameters
    ----------
    r1, r2, r3, x, y, s1, s2
        Design, point and working mode.
    tolerance
        Largest |sin β_i| and |sin γ| that count as zero.
    """
    w1, w2, cross, dot, scale = distal_products(r1, r2, r3, x, y, s1, s2)
    kind = 0
    if w1 <= tolerance * 2.0 * r1 * r2:
        kind |= SERIAL_LEG_1
    if w2 <= tolerance * 2.0 * r1 * r2:
        kind |= SERIAL_LEG_2
    if abs(cross) <= tolerance * scale:
        kind |= PARALLEL_FOLDED if dot > 0.0 else PARALLEL_EXTENDED
    return kind


def change_point_cases(r1: float, r2: float, r3: float) -> str:
    """Return which conditions of the third kind of singularity a design fulfils.

    Parameters
    ----------
    r1, r2, r3
        Lengths in any one unit.

    Returns
    -------
    str
        Letters of Liu et al. 2006, Sec. 4: (a) r1 = r3, (b) r2 = r3, (c) r3 = r1 + r2,
        (d) r2 = r1 + r3, (e) r1 = r3 + r2, (f) r3 = 0, to 1e-12 relative; designs with one
        of (a) to (e) are change-point manipulators.
    """
    slack = 1e-12 * (r1 + r2 + r3)
    gaps = {
        "a": r1 - r3,
        "b": r2 - r3,
        "c": r3 - r1 - r2,
        "d": r2 - r1 - r3,
        "e": r1 - r3 - r2,
        "f": r3,
    }
    return "".join(letter for letter, gap in gaps.items() if abs(gap) <= slack)
