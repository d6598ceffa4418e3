"""Isotropic points of the symmetric 5R manipulator: LCI = 1, in closed form.

LCI has a cone there, its gradient jumps; quadrature must not step over one.

LCI = 1 needs sin β1 = sin β2 and |sin γ| = 1. The first holds on the y axis (β1 = β2) and on
the circle x² + y² = r1² + r2² - r3² (β1 + β2 = π); the second then fixes the point, by closing
the loop A1 B1 P B2 A2 with the distal links at a right angle.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.jacobian import lci
from fivebar_atlas.mechanisms.five_bar.kinematics import reaches

#: Most isotropic points that the closed forms can give, all sign choices counted.
MAX_ISOTROPIC = 24


@kernel
def _note_point(
    r1: float, r2: float, r3: float, x: float, y: float, s1: float, s2: float,
    out: FloatArray, count: int,
) -> int:  # fmt: skip
    """Append (x, y) if it is isotropic in this working mode; return the number of points."""
    if not reaches(r1, r2, r3, x, y) or lci(r1, r2, r3, x, y, s1, s2) < 1.0 - 1e-6:
        return count
    out[count, 0] = x
    out[count, 1] = y
    return count + 1


@kernel
def isotropic_points(r1: float, r2: float, r3: float, s1: float, s2: float, out: FloatArray) -> int:
    """Collect the isotropic points of a working mode, both assembly modes.

    On the axis: y = ±r2/√2 ± √(r1² - (r3 ∓ r2/√2)²) where the elbows are mirrored ("+-",
    "-+"), y = ±r3 where they are not. Off the axis: x = ∓ r1 r2 cos β / r3 with
    sin β = (r1² + r2² - 2 r3²) / (2 r1 r2), which exists only for |r1 - r2| ≤ √2 r3, and
    |sin 2β| = 1 + (r2² - 2 r3²) / r1² respectively.

    Parameters
    ----------
    r1, r2, r3, s1, s2
        Design and working mode.
    out
        Receives the points, shape (MAX_ISOTROPIC, 2).

    Returns
    -------
    int
        Number of points.
    """
    n = 0
    diagonal = r2 * math.sqrt(0.5)
    if s1 != s2:
        for inside in range(2):
            offset = r3 - diagonal if inside == 0 else r3 + diagonal
            rest = (r1 - offset) * (r1 + offset)
            if rest >= 0.0:
                for flip in range(4):
                    y = diagonal if flip < 2 else -diagonal
                    y += math.sqrt(rest) if flip % 2 == 0 else -math.sqrt(rest)
                    n = _note_point(r1, r2, r3, 0.0, y, s1, s2, out, n)
    else:
        n = _note_point(r1, r2, r3, 0.0, r3, s1, s2, out, n)
        n = _note_point(r1, r2, r3, 0.0, -r3, s1, s2, out, n)
    if r3 == 0.0:
        return n
    for root in range(2):
        if s1 != s2:
            sine = 0.5 * (r1 * r1 + r2 * r2 - 2.0 * r3 * r3) / (r1 * r2)
            if sine > 1.0 or root > 0:
                continue
            cosine = math.sqrt((1.0 - sine) * (1.0 + sine)) if sine > -1.0 else -1.0
        else:
            sine = 1.0 + (r2 * r2 - 2.0 * r3 * r3) / (r1 * r1)
            if sine > 1.0 or sine < -1.0:
                continue
            double = math.sqrt((1.0 - sine) * (1.0 + sine))
            cosine = math.sqrt(max(0.5 * (1.0 + (double if root == 0 else -double)), 0.0))
        if cosine < 0.0:
            continue
        x = r1 * r2 * cosine / r3
        y2 = r1 * r1 + r2 * r2 - r3 * r3 - x * x
        if y2 < 0.0:
            continue
        y = math.sqrt(y2)
        for flip in range(4):
            n = _note_point(
                r1, r2, r3,
                x if flip < 2 else -x, y if flip % 2 == 0 else -y,
                s1, s2, out, n,
            )  # fmt: skip
    return n
