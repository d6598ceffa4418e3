"""Circles seen from the origin: where a ray meets them, what area their arcs sweep."""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel


@kernel
def circle_discriminant(a: float, b: float, radius: float, c: float, s: float) -> float:
    """Return radius² minus the squared distance of the centre (a, b) from a ray's line.

    The ray from the origin has the direction (c, s); it meets the circle where the value
    is positive and touches it where it is zero.
    """
    offset = a * s - b * c
    return (radius - offset) * (radius + offset)


@kernel
def circle_radius(a: float, b: float, radius: float, sheet: float, c: float, s: float) -> float:
    """Return where a ray from the origin meets a circle.

    Parameters
    ----------
    a, b, radius
        Centre and radius.
    sheet
        +1 for the far, -1 for the near intersection.
    c, s
        Direction of the ray, a unit vector.

    Returns
    -------
    float
        Signed distance along the ray; where the ray misses the circle, that of the point
        nearest to it (rounding at a tangent ray must not matter).
    """
    discriminant = circle_discriminant(a, b, radius, c, s)
    return a * c + b * s + sheet * math.sqrt(max(discriminant, 0.0))


@kernel
def circle_swept_area(
    a: float, b: float, radius: float, sheet: float,
    x0: float, y0: float, x1: float, y1: float,
) -> float:  # fmt: skip
    """Return ½ ∫ ρ² dφ along a circle arc, the area between it and the origin.

    Green's theorem: ½ (radius² Δψ + a Δy - b Δx), ψ the angle about the centre, which grows
    along the far sheet and falls along the near one.

    Parameters
    ----------
    a, b, radius
        Centre and radius.
    sheet
        +1 for the far, -1 for the near sheet.
    x0, y0, x1, y1
        End points, in the sense of growing φ.
    """
    turn = math.atan2(y1 - b, x1 - a) - math.atan2(y0 - b, x0 - a)
    # an arc of no length may turn backwards by a rounding error: that is no full circle
    if sheet > 0.0 and turn < -1e-7:
        turn += 2.0 * math.pi
    elif sheet < 0.0 and turn > 1e-7:
        turn -= 2.0 * math.pi
    return 0.5 * (radius * radius * turn + a * (y1 - y0) - b * (x1 - x0))


@kernel
def lens_area(radius0: float, radius1: float, distance: float) -> float:
    """Return the area common to two discs, by closed form.

    Parameters
    ----------
    radius0, radius1
        Radii of the discs, not negative.
    distance
        Distance of the centres, not negative.
    """
    if distance >= radius0 + radius1:
        return 0.0
    small = min(radius0, radius1)
    if distance <= abs(radius0 - radius1):
        return math.pi * small * small
    along0 = 0.5 * (distance + (radius0 - radius1) * (radius0 + radius1) / distance)
    along1 = distance - along0
    half_chord = math.sqrt(max((radius0 - along0) * (radius0 + along0), 0.0))
    return (
        radius0 * radius0 * math.atan2(half_chord, along0)
        + radius1 * radius1 * math.atan2(half_chord, along1)
        - distance * half_chord
    )
