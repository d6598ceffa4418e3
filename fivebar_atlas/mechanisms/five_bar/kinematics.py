"""Inverse and forward kinematics of the symmetric 5R manipulator (Liu et al. 2006, Sec. 2).

Scalar kernels, arguments in the fixed order ``r1, r2, r3, x, y``, then modes as ±1. Lengths
in any one unit, angles in radians.

Nothing here calls a trigonometric function where the position of P is known: a leg is
described by the squared distance of P from the base joint and by ``four_areas``, four
times the area of the triangle A_i B_i P, which is 2 r1 r2 sin β_i.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel


@kernel
def squared_four_areas(r1: float, r2: float, reach2: float) -> float:
    """Return (4 × area of the triangle A B P)² = (2 r1 r2 sin β)², from its sides.

    Factored, ((r1 + r2)² - d²)(d² - (r1 - r2)²), so that it is accurate up to the serial
    singularities, where it is zero; negative where the leg does not reach.

    Parameters
    ----------
    r1, r2
        Actuated and distal link.
    reach2
        Squared distance d² of P from the base joint A.
    """
    outer = r1 + r2
    inner = r1 - r2
    return (outer * outer - reach2) * (reach2 - inner * inner)


@kernel
def reaches(r1: float, r2: float, r3: float, x: float, y: float) -> bool:
    """Tell whether both legs reach P: the theoretical workspace, borders included."""
    reach2_1 = (x + r3) * (x + r3) + y * y
    reach2_2 = (x - r3) * (x - r3) + y * y
    return (
        squared_four_areas(r1, r2, reach2_1) >= 0.0 and squared_four_areas(r1, r2, reach2_2) >= 0.0
    )


@kernel
def elbow(
    r1: float, r2: float, base_x: float, x: float, y: float, sign: float
) -> tuple[float, float]:
    """Return the elbow B of one leg (Eqs. 3 to 7, solved without angles).

    Parameters
    ----------
    r1, r2
        Actuated and distal link.
    base_x
        Abscissa of the base joint A, -r3 or r3.
    x, y
        Point P.
    sign
        +1 for the counter-clockwise elbow (the "+" root of Eq. 7), -1 for the other.

    Returns
    -------
    tuple of float
        Coordinates of B. Beyond reach, the elbow of the nearest stretched or folded leg's
        direction; at P = A (r1 = r2), where the elbow may point anywhere, A itself.
    """
    u = x - base_x
    reach2 = u * u + y * y
    if reach2 == 0.0:
        return base_x, 0.0
    along = 0.5 * (reach2 + (r1 - r2) * (r1 + r2)) / reach2
    across = 0.5 * sign * math.sqrt(max(squared_four_areas(r1, r2, reach2), 0.0)) / reach2
    return base_x + along * u - across * y, along * y + across * u


@kernel
def inverse(
    r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float
) -> tuple[float, float]:
    """Return the input angles θ1, θ2 in (-π, π] for P in a working mode (Eqs. 6, 7)."""
    b1x, b1y = elbow(r1, r2, -r3, x, y, s1)
    b2x, b2y = elbow(r1, r2, r3, x, y, s2)
    return math.atan2(b1y, b1x + r3), math.atan2(b2y, b2x - r3)


@kernel
def forward(
    r1: float, r2: float, r3: float, theta1: float, theta2: float, assembly: float
) -> tuple[float, float, bool]:
    """Return P for given inputs and assembly mode (Eqs. 8 to 12, as two circles).

    The circles of radius r2 about B1 and B2 meet in two points, one on either side of the
    line B1 B2; the sign of det B = cross(P - B1, P - B2) tells them apart.

    Parameters
    ----------
    r1, r2, r3
        Lengths.
    theta1, theta2
        Input angles.
    assembly
        +1 for the up-configuration (det B > 0), -1 for the down-configuration.

    Returns
    -------
    tuple
        x, y and whether the linkage can be assembled; where it cannot, or where B1 and B2
        coincide and P is free on a circle, the point midway between B1 and B2 and False.
    """
    b1x, b1y = r1 * math.cos(theta1) - r3, r1 * math.sin(theta1)
    b2x, b2y = r1 * math.cos(theta2) + r3, r1 * math.sin(theta2)
    ex, ey = b2x - b1x, b2y - b1y
    span2 = ex * ex + ey * ey
    height2 = r2 * r2 - 0.25 * span2
    mx, my = 0.5 * (b1x + b2x), 0.5 * (b1y + b2y)
    if span2 == 0.0 or height2 < 0.0:
        return mx, my, False
    rise = assembly * math.sqrt(height2 / span2)
    return mx - rise * ey, my + rise * ex, True
