"""Usable poses on a line through a pose, for kernels: the fibres of the pose box.

Through every pose goes a line along which p moves while the platform does not turn: in the
plane across n6, as the joint asks, and across the horizontal direction of that plane, so that it
is vertical where n6 is horizontal. On it

- α, β, γ are constant, and so is the derivative of the constraint by α, which depends on
  A_5 - p by its component across this plane of motion only;
- the limits of the limbs and of their joints are roots of quadratic equations, and the sign of
  det G that of a cubic (:mod:`limits_along`, :mod:`determinant_along`).

Poses with uniform X, Y, Z, β, γ are uniform on each line, since that derivative is constant on
it. So of a pose drawn from the box, the share of its line that is usable is known without drawing
more, and a usable pose of the line is one drawn from the usable poses.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.pentapod.determinant_along import remove_other_sign
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS
from fivebar_atlas.mechanisms.pentapod.limits_along import inside_cone, inside_sphere
from fivebar_atlas.mechanisms.pentapod.pose import (
    DESIGN,
    POSE,
    set_orientation,
    set_position,
    solve_alpha,
)
from fivebar_atlas.numerics.interval_sets import (
    INTERVALS,
    remove_interval,
    set_interval,
)
from fivebar_atlas.numerics.records import record_type

#: A line: the pose that it was drawn through, its direction, and what of it is usable.
FIBRE = record_type(
    ("design", DESIGN, ()),
    ("pose", POSE, ()),
    ("direction", np.float64, (3,)),
    ("along", np.float64, (LIMBS,)),
    ("square", np.float64, (LIMBS,)),
    ("usable", INTERVALS, ()),
)

#: Results of :func:`find_usable`.
NOTHING, SOMETHING, SOMETHING_SINGULAR, ONLY_SINGULAR = range(4)

# Cosines of directions, and lengths in units of H, that count as 0.
_FLAT, _SHORT = 1e-9, 1e-9
# By how much α may leave its range, in radians.
_ANGLE_SLACK = 1e-12

Fibre = Any


@kernel
def find_through(
    f: Fibre, box: int, x: float, y: float, z: float, beta: float, gamma: float
) -> tuple[int, float]:
    """Find what is usable on the line through a pose of a box.

    Parameters
    ----------
    f
        Work space with the design; receives the pose, the direction of the line and the usable
        ways along it from the pose.
    box
        Which of the boxes of the design.
    x, y, z, beta, gamma
        The pose.

    Returns
    -------
    state
        Whether something is usable, and whether something would be but for the sign of det G.
    length
        Length of the line in the box; 0 where it is only a point, since the box is flat.
    """
    design = f.design
    sb, cb, sg, cg = math.sin(beta), math.cos(beta), math.sin(gamma), math.cos(gamma)
    sa, ca, exists = solve_alpha(design, x, y, z, sb, cb, sg, cg)
    if not exists:
        return NOTHING, 0.0
    alpha = math.atan2(sa, ca)
    least, greatest = design.boxes[box, 0, 3], design.boxes[box, 1, 3]
    if alpha < least - _ANGLE_SLACK or alpha > greatest + _ANGLE_SLACK:
        return NOTHING, 0.0
    set_orientation(f.pose, design, sa, ca, sb, cb, sg, cg)
    set_position(f.pose, design, x, y, z)
    set_direction(f)
    low, high = ways_in_box(f, box)
    length = high - low
    if not length > _SHORT:
        low, high, length = 0.0, 0.0, 0.0
    state, _reached = find_usable(f, low, high)
    return state, length


@kernel
def set_direction(f: Fibre) -> float:
    """Set the direction of the line through a pose; return the length of n6 in plan."""
    n = f.pose.axis
    level = math.sqrt(n[0] * n[0] + n[1] * n[1])
    f.direction[0] = -n[0] * n[2] / level
    f.direction[1] = -n[1] * n[2] / level
    f.direction[2] = level
    return level


@kernel
def ways_in_box(f: Fibre, box: int) -> tuple[float, float]:
    """Return where the line through a pose is in a box, from and to."""
    low, high = -math.inf, math.inf
    for j in range(3):
        if abs(f.direction[j]) > _FLAT:
            one = (f.design.boxes[box, 0, j] - f.pose.position[j]) / f.direction[j]
            other = (f.design.boxes[box, 1, j] - f.pose.position[j]) / f.direction[j]
            low, high = max(low, min(one, other)), min(high, max(one, other))
    return low, high


@kernel
def find_usable(f: Fibre, low: float, high: float) -> tuple[int, float]:
    """Find what is usable of a part of the line through a pose.

    Parameters
    ----------
    f
        Work space with design, pose and direction; receives the usable ways.
    low, high
        The part.

    Returns
    -------
    state
        Whether something is usable, and whether something would be but for the sign of det G.
    reached
        The length that no limb is too short for.
    """
    design, pose, direction = f.design, f.pose, f.direction
    f.usable.count[0] = 0
    if not low <= high:
        return NOTHING, 0.0
    for i in range(LIMBS):
        l0, l1, l2 = pose.vectors[i, 0], pose.vectors[i, 1], pose.vectors[i, 2]
        f.along[i] = l0 * direction[0] + l1 * direction[1] + l2 * direction[2]
        f.square[i] = l0 * l0 + l1 * l1 + l2 * l2
        one, other = inside_sphere(f.along[i], f.square[i], design.greatest_square[i])
        low, high = max(low, one), min(high, other)
        if not low <= high:
            return NOTHING, 0.0
    reached = high - low
    # wider cones than a half space are what is left without a narrower one
    for side in range(2):
        cosine = design.base_cosine[0] if side == 0 else design.platform_cosine[0]
        if cosine < 0.0:
            continue
        for i in range(LIMBS):
            height, rise = _against_home(f, i, side)
            one, other = inside_cone(f.along[i], f.square[i], height, rise, cosine)
            low, high = max(low, one), min(high, other)
            if not low <= high:
                return NOTHING, reached
    set_interval(f.usable, low, high)
    for i in range(LIMBS):
        one, other = inside_sphere(f.along[i], f.square[i], design.least_square[i])
        remove_interval(f.usable, one, other)
    for side in range(2):
        cosine = design.base_cosine[0] if side == 0 else design.platform_cosine[0]
        if -1.0 < cosine < 0.0:
            for i in range(LIMBS):
                height, rise = _against_home(f, i, side)
                one, other = inside_cone(f.along[i], f.square[i], -height, -rise, -cosine)
                remove_interval(f.usable, one, other)
    if f.usable.count[0] == 0:
        return NOTHING, reached
    is_singular = remove_other_sign(f.usable, design, pose, direction)
    if f.usable.count[0] == 0:
        return ONLY_SINGULAR, reached
    return (SOMETHING_SINGULAR if is_singular else SOMETHING), reached


@kernel
def _against_home(f: Fibre, i: int, side: int) -> tuple[float, float]:
    """Return l_i·m and d·m, with m the direction of limb i at home.

    It is fixed in the base (side 0) or in the platform (side 1).
    """
    m0, m1, m2 = (
        f.design.home_directions[i, 0],
        f.design.home_directions[i, 1],
        f.design.home_directions[i, 2],
    )
    if side == 1:
        r = f.pose.rotation
        m0, m1, m2 = (
            r[0, 0] * m0 + r[0, 1] * m1 + r[0, 2] * m2,
            r[1, 0] * m0 + r[1, 1] * m1 + r[1, 2] * m2,
            r[2, 0] * m0 + r[2, 1] * m1 + r[2, 2] * m2,
        )
    v, d = f.pose.vectors, f.direction
    return (
        v[i, 0] * m0 + v[i, 1] * m1 + v[i, 2] * m2,
        d[0] * m0 + d[1] * m1 + d[2] * m2,
    )
