"""The sign of det G while the platform moves along a line without turning.

A change of the point that moments are about does not change det G, so let it be A_5: then the
lines of limb 5 and of the constraint force have no moment, and in axes along n6, l_5 and n6 × l_5

    det G Π|l_i| = |l_5| det [n6 × l_5·l_i / |l_5|,  (A_i - A_5) × l_i],   i = 1 ... 4,

but for a sign that is the same in all poses. Limb vectors are linear in the way t. In the six
rows of (l_i, A_i × l_i) the terms with t have rank 3, so the determinant is a cubic polynomial of
t, and four values of it tell everything.
"""

from __future__ import annotations

from typing import Any

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS
from fivebar_atlas.mechanisms.pentapod.pose import Design, Pose
from fivebar_atlas.numerics.interval_sets import Intervals, remove_interval

# Halvings of an interval in which the determinant changes its sign.
_HALVINGS = 50


@kernel
def _row(
    design: Design, pose: Pose, direction: Any, way: float, i: int,
    u0: float, u1: float, u2: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return u·l_i and the moment of l_i about A_5, after a way."""
    l0 = pose.vectors[i, 0] + way * direction[0]
    l1 = pose.vectors[i, 1] + way * direction[1]
    l2 = pose.vectors[i, 2] + way * direction[2]
    a0 = design.base_joints[i, 0] - design.base_joints[LIMBS - 1, 0]
    a1 = design.base_joints[i, 1] - design.base_joints[LIMBS - 1, 1]
    a2 = design.base_joints[i, 2] - design.base_joints[LIMBS - 1, 2]
    return (
        u0 * l0 + u1 * l1 + u2 * l2,
        a1 * l2 - a2 * l1,
        a2 * l0 - a0 * l2,
        a0 * l1 - a1 * l0,
    )


@kernel
def determinant_at(design: Design, pose: Pose, direction: Any, way: float) -> float:
    """Return det G times all limb lengths but for a sign, after a way along a direction.

    Parameters
    ----------
    design, pose
        The design and the pose that the way begins in.
    direction
        Unit vector, shape (3,).
    way
        t.
    """
    n = pose.axis
    l0 = pose.vectors[LIMBS - 1, 0] + way * direction[0]
    l1 = pose.vectors[LIMBS - 1, 1] + way * direction[1]
    l2 = pose.vectors[LIMBS - 1, 2] + way * direction[2]
    u0, u1, u2 = n[1] * l2 - n[2] * l1, n[2] * l0 - n[0] * l2, n[0] * l1 - n[1] * l0
    a0, a1, a2, a3 = _row(design, pose, direction, way, 0, u0, u1, u2)
    b0, b1, b2, b3 = _row(design, pose, direction, way, 1, u0, u1, u2)
    c0, c1, c2, c3 = _row(design, pose, direction, way, 2, u0, u1, u2)
    d0, d1, d2, d3 = _row(design, pose, direction, way, 3, u0, u1, u2)
    # minors of the first two rows by those of the others (Laplace)
    return (
        (a0 * b1 - a1 * b0) * (c2 * d3 - c3 * d2)
        - (a0 * b2 - a2 * b0) * (c1 * d3 - c3 * d1)
        + (a0 * b3 - a3 * b0) * (c1 * d2 - c2 * d1)
        + (a1 * b2 - a2 * b1) * (c0 * d3 - c3 * d0)
        - (a1 * b3 - a3 * b1) * (c0 * d2 - c2 * d0)
        + (a2 * b3 - a3 * b2) * (c0 * d1 - c1 * d0)
    )


@kernel
def _cubic(f0: float, f1: float, f2: float, f3: float, s: float) -> float:
    """Return a cubic polynomial from its Bernstein coefficients, at s from 0 to 1."""
    r = 1.0 - s
    return r * r * (r * f0 + 3.0 * s * f1) + s * s * (3.0 * r * f2 + s * f3)


@kernel
def remove_other_sign(s: Intervals, design: Design, pose: Pose, direction: Any) -> bool:
    """Leave of a set of ways those on which det G has the sign it has at home.

    Parameters
    ----------
    s
        Ways along the direction; some are taken away.
    design, pose, direction
        As for :func:`determinant_at`.

    Returns
    -------
    bool
        Whether something was taken away.
    """
    if s.count[0] == 0:
        return False
    start, stop = float(s.start[0]), float(s.stop[s.count[0] - 1])
    sign, step = float(design.determinant_sign[0]), (stop - start) / 3.0
    f0 = sign * determinant_at(design, pose, direction, start)
    if not step > 0.0:
        s.count[0] = 1 if f0 > 0.0 else 0
        return not f0 > 0.0
    v1 = sign * determinant_at(design, pose, direction, start + step)
    v2 = sign * determinant_at(design, pose, direction, start + 2.0 * step)
    f3 = sign * determinant_at(design, pose, direction, stop)
    f1 = (-5.0 * f0 + 18.0 * v1 - 9.0 * v2 + 2.0 * f3) / 6.0
    f2 = (2.0 * f0 - 9.0 * v1 + 18.0 * v2 - 5.0 * f3) / 6.0
    # a Bernstein polynomial is between its coefficients
    if min(min(f0, f1), min(f2, f3)) > 0.0:
        return False
    before = 0.0
    for i in range(s.count[0]):
        before += s.stop[i] - s.start[i]
    # between its turning points the cubic has a root at most
    e0, e1, e2 = f1 - f0, f2 - f1, f3 - f2
    a, b = e0 - 2.0 * e1 + e2, e1 - e0
    radicand = b * b - a * e0
    root = radicand**0.5 if radicand > 0.0 else 0.0
    q = -(b + root) if b >= 0.0 else -(b - root)
    one = q / a if a != 0.0 else 2.0
    other = e0 / q if q != 0.0 else 2.0
    one = one if 0.0 < one < 1.0 else 1.0
    other = other if 0.0 < other < 1.0 else 1.0
    low = 0.0
    bad_since = 0.0 if not f0 > 0.0 else -1.0
    value = f0
    for piece in range(3):
        high = min(one, other) if piece == 0 else (max(one, other) if piece == 1 else 1.0)
        end = _cubic(f0, f1, f2, f3, high)
        if (value > 0.0) != (end > 0.0):
            left, right = low, high
            for _ in range(_HALVINGS):
                middle = 0.5 * (left + right)
                if (_cubic(f0, f1, f2, f3, middle) > 0.0) == (value > 0.0):
                    left = middle
                else:
                    right = middle
            if value > 0.0:
                bad_since = left
            else:
                remove_interval(
                    s,
                    start + 3.0 * step * bad_since - (step if bad_since == 0.0 else 0.0),
                    start + 3.0 * step * right,
                )
                bad_since = -1.0
        low, value = high, end
    if bad_since >= 0.0:
        remove_interval(
            s, start + 3.0 * step * bad_since - (step if bad_since == 0.0 else 0.0), stop + step
        )
    after = 0.0
    for i in range(s.count[0]):
        after += s.stop[i] - s.start[i]
    return after < before
