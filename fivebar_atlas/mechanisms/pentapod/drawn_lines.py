"""Lines of the pose box drawn by their angles, for kernels.

A line of :mod:`fibre` is given by α, β, γ and s, the position of its plane of motion along the
horizontal direction h of the plane across n6. With t along the line

    dX dY dZ = |∂c/∂α| dα ds dt,   ∂c/∂α = |n6 in plan| (A_5·h - s),

where c is the constraint. Other than for lines through drawn positions, nothing jumps at the
limits of α nor where positions have no α: the integrand only has kinks.

Angles are drawn uniformly in the diamond angle D: the way around the square |x| + |y| = 1, from
-2 to 2, on which dα = (|cos α| + |sin α|)² dD. It rises with α and needs no inverse function.
"""

from __future__ import annotations

import math

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.pentapod.fibre import (
    NOTHING,
    Fibre,
    find_usable,
    set_direction,
    ways_in_box,
)
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS
from fivebar_atlas.mechanisms.pentapod.pose import (
    Design,
    set_orientation,
    set_position,
)

# Components of a horizontal unit vector that count as 0.
_FLAT = 1e-12


@kernel
def diamond_angle(sine: float, cosine: float) -> float:
    """Return the diamond angle of a direction, from -2 to 2."""
    part = abs(sine) / (abs(sine) + abs(cosine))
    return math.copysign(part if cosine >= 0.0 else 2.0 - part, sine)


@kernel
def direction_of(diamond: float) -> tuple[float, float, float]:
    """Return sine and cosine for a diamond angle, and dα/dD."""
    x = 1.0 - abs(diamond)
    y = math.copysign(1.0 - abs(x), diamond)
    square = x * x + y * y
    factor = 1.0 / math.sqrt(square)
    return factor * y, factor * x, 1.0 / square


@kernel
def range_of_alpha(
    design: Design, box: int, sb: float, cb: float, sg: float, cg: float
) -> tuple[float, float]:
    """Return diamond angles between which all α of positions of a box are that are in its range.

    Parameters
    ----------
    design, box
        The design and which of its boxes.
    sb, cb, sg, cg
        Sines and cosines of β and γ.

    Returns
    -------
    float, float
        From and to. α rises or falls along each edge of the box where it exists in all of it, so
        it is between those at the corners; elsewhere this is all of its range.
    """
    least, greatest = design.boxes[box, 0], design.boxes[box, 1]
    first, last = design.alpha_range[0], design.alpha_range[1]
    n = design.axis
    turned = sg * n[1] + cg * n[2]
    wx, wy, wz = cb * n[0] + sb * turned, cg * n[1] - sg * n[2], -sb * n[0] + cb * turned
    height, offset = design.base_joints[LIMBS - 1, 2], design.axis_offset[0]
    one = (height - least[2]) * wz - offset
    other = (height - greatest[2]) * wz - offset
    if not design.nearest_square[box] * (wx * wx + wy * wy) > max(one * one, other * other):
        return first, last
    low, high = 2.0, -2.0
    joint, branch = design.base_joints[LIMBS - 1], design.branch[0]
    for corner in range(4):
        x = joint[0] - (least[0] if corner & 1 else greatest[0])
        y = joint[1] - (least[1] if corner & 2 else greatest[1])
        p, q = x * wx + y * wy, y * wx - x * wy
        square = p * p + q * q
        for end in range(2):
            c = one if end == 0 else other
            root = branch * math.sqrt(max(square - c * c, 0.0))
            # sine and cosine but for a factor, as in :func:`pose.solve_alpha`
            here = diamond_angle(-c * q - root * p, -c * p + root * q)
            low, high = min(low, here), max(high, here)
    if high - low > 2.0:
        # across the half turn
        return first, last
    return max(first, low), min(last, high)


@kernel
def _range_in_plan(
    design: Design, box: int, e0: float, e1: float, first: float, last: float
) -> tuple[float, float]:
    """Return where the strip of a box in plan is, along (-e1, e0), from and to.

    The strip has first <= e·(x, y) <= last, with the unit vector e.
    """
    least, greatest = design.boxes[box, 0], design.boxes[box, 1]
    low, high = math.inf, -math.inf
    for corner in range(4):
        x = least[0] if corner & 1 else greatest[0]
        y = least[1] if corner & 2 else greatest[1]
        if first <= e0 * x + e1 * y <= last:
            s = e0 * y - e1 * x
            low, high = min(low, s), max(high, s)
    for side in range(2):
        w = first if side == 0 else last
        start, stop = -math.inf, math.inf
        if abs(e1) > _FLAT:
            one, other = (w * e0 - least[0]) / e1, (w * e0 - greatest[0]) / e1
            start, stop = max(start, min(one, other)), min(stop, max(one, other))
        if abs(e0) > _FLAT:
            one, other = (least[1] - w * e1) / e0, (greatest[1] - w * e1) / e0
            start, stop = max(start, min(one, other)), min(stop, max(one, other))
        if start <= stop:
            low, high = min(low, start), max(high, stop)
    return low, high


@kernel
def draw_line(
    f: Fibre, box: int, angle: float, place: float, beta: float, gamma: float
) -> tuple[int, float, float]:
    """Find what is usable on a drawn line of a box.

    Parameters
    ----------
    f
        Work space with the design; receives a pose on the line, the direction of the line and the
        usable ways along it from the pose.
    box
        Which of the boxes of the design; it is not flat in X, Y or Z.
    angle, place
        Numbers from 0 to 1 that draw α and s.
    beta, gamma
        The other angles.

    Returns
    -------
    state
        Whether something is usable, and whether something would be but for the sign of det G.
    weight
        What a length of the line stands for, as a share of the volume of the box.
    reached
        The length that no limb is too short for.
    """
    design, pose = f.design, f.pose
    f.usable.count[0] = 0
    sb, cb, sg, cg = math.sin(beta), math.cos(beta), math.sin(gamma), math.cos(gamma)
    first, last = range_of_alpha(design, box, sb, cb, sg, cg)
    if not first < last:
        return NOTHING, 0.0, 0.0
    sa, ca, stretch = direction_of(first + angle * (last - first))
    set_orientation(pose, design, sa, ca, sb, cb, sg, cg)
    n, joint = pose.axis, design.base_joints[LIMBS - 1]
    level = set_direction(f)
    if not level > _FLAT:
        return NOTHING, 0.0, 0.0
    e0, e1 = n[0] / level, n[1] / level
    offset = joint[0] * n[0] + joint[1] * n[1] + joint[2] * n[2] - design.axis_offset[0]
    low, high = -math.inf, math.inf
    if design.nearest_square[box] >= 0.0:
        one = (offset - n[2] * design.boxes[box, 0, 2]) / level
        other = (offset - n[2] * design.boxes[box, 1, 2]) / level
        low, high = _range_in_plan(design, box, e0, e1, min(one, other), max(one, other))
    # the branch of home is on one side of A_5
    middle = e0 * joint[1] - e1 * joint[0]
    if design.branch[0] > 0.0:
        high = min(high, middle)
    else:
        low = max(low, middle)
    for i in range(LIMBS):
        c0 = design.base_joints[i, 0] - pose.arms[i, 0]
        c1 = design.base_joints[i, 1] - pose.arms[i, 1]
        c2 = design.base_joints[i, 2] - pose.arms[i, 2]
        away = c0 * n[0] + c1 * n[1] + c2 * n[2] - offset
        square = design.greatest_square[i] - away * away
        if not square > 0.0:
            return NOTHING, 0.0, 0.0
        root, s = math.sqrt(square), e0 * c1 - e1 * c0
        low, high = max(low, s - root), min(high, s + root)
    if not low < high:
        return NOTHING, 0.0, 0.0
    # s is drawn as |∂c/∂α| weighs it, so uniformly in the square of the distance from A_5
    side = 1.0 if design.branch[0] < 0.0 else -1.0
    one, other = side * (low - middle), side * (high - middle)
    spread = abs(other - one) * (one + other)
    nearer = min(one, other)
    s = middle + side * math.sqrt(nearer * nearer + place * spread)
    set_position(pose, design, offset * n[0] - s * e1, offset * n[1] + s * e0, offset * n[2])
    weight = 0.5 * level * spread * stretch * (last - first)
    start, stop = ways_in_box(f, box)
    state, reached = find_usable(f, start, stop)
    return state, weight / design.box_volume[box], reached
