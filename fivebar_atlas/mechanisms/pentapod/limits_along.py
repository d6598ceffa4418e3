"""Where limbs keep their limits while the platform moves along a line without turning.

The vector of a limb is l(t) = l + t d with a unit vector d. Its length is limited by spheres and
its direction by cones, so all limits are at roots of quadratic equations in t.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel


@kernel
def inside_sphere(along: float, square: float, limit: float) -> tuple[float, float]:
    """Return where |l + t d|² <= limit, from and to; from above to where it nowhere is.

    Parameters
    ----------
    along, square
        l·d and l·l.
    limit
        Square of the radius.
    """
    radicand = along * along - (square - limit)
    if radicand < 0.0:
        return math.inf, -math.inf
    root = math.sqrt(radicand)
    return -along - root, -along + root


@kernel
def inside_cone(
    along: float, square: float, height: float, rise: float, cosine: float
) -> tuple[float, float]:
    """Return where l + t d is in a cone that is not wider than a half space.

    Parameters
    ----------
    along, square
        l·d and l·l.
    height, rise
        l·m and d·m with the unit vector m along the axis of the cone.
    cosine
        Cosine of the half angle, not negative.

    Returns
    -------
    float, float
        From and to, where (l + t d)·m >= cosine |l + t d|: it is one interval, a half-line or
        nothing (from above to), since such cones are convex.
    """
    c2 = cosine * cosine
    a = rise * rise - c2
    b = height * rise - c2 * along
    c = height * height - c2 * square
    if a == 0.0:
        # d is along a side of the cone, and the equation is linear
        if b == 0.0:
            inside = c >= 0.0 and height >= 0.0
            return (-math.inf, math.inf) if inside else (math.inf, -math.inf)
        only = -0.5 * c / b
        if b * rise < 0.0:
            # on the image of the cone beyond the tip
            return math.inf, -math.inf
        return (only, math.inf) if rise > 0.0 else (-math.inf, only)
    radicand = b * b - a * c
    if radicand <= 0.0:
        if a < 0.0:
            return math.inf, -math.inf
        # through the tip, but for rounding
        radicand = 0.0
    q = -(b + math.copysign(math.sqrt(radicand), b))
    one, other = q / a, (c / q if q != 0.0 else 0.0)
    low, high = min(one, other), max(one, other)
    if a > 0.0:
        # one root is on the cone, the other on its image beyond the tip
        return (high, math.inf) if rise > 0.0 else (-math.inf, low)
    middle = 0.5 * (low + high)
    return (low, high) if height + middle * rise > 0.0 else (math.inf, -math.inf)
