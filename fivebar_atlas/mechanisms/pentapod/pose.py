"""Poses of a design with home height 1, for kernels: the angle solved for, and the limbs.

The joint axis n6 of limb 5 keeps five coordinates free. With X, Y, Z, β, γ given, the constraint
(A_5 - B_5)·n6 = 0 is

    P cos α + Q sin α + C = 0,   P = q_x w_x + q_y w_y,   Q = q_y w_x - q_x w_y,
    C = q_z w_z - B_5·n6,

with q = A_5 - p, and w = Ry(β) Rx(γ) n6 in platform axes. It has two roots, on which its
derivative by α is ±√(P² + Q² - C²); the one with the sign at home goes on from home without a
jump.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS
from fivebar_atlas.numerics.records import record_type

#: A design and its limits; those of limbs are squares of lengths. Boxes have the least and the
#: greatest X, Y, Z, α, β, γ. There are two, that of the indices, and that of the workspace volume,
#: in which X, Y and Z have no greatest values. For both, ``alpha_range`` has the diamond angles of
#: the ends of α; ``nearest_square`` is the square of the least distance of a position from the
#: vertical through A_5, negative where there is no look for it; ``box_volume`` is what volumes of
#: positions are divided by, 0 where the box is flat.
DESIGN = record_type(
    ("base_joints", np.float64, (LIMBS, 3)),
    ("platform_joints", np.float64, (LIMBS, 3)),
    ("axis", np.float64, (3,)),
    ("axis_offset", np.float64, (1,)),
    ("home_directions", np.float64, (LIMBS, 3)),
    ("least_square", np.float64, (LIMBS,)),
    ("greatest_square", np.float64, (LIMBS,)),
    ("base_cosine", np.float64, (1,)),
    ("platform_cosine", np.float64, (1,)),
    ("branch", np.float64, (1,)),
    ("determinant_sign", np.float64, (1,)),
    ("characteristic_length", np.float64, (1,)),
    ("boxes", np.float64, (2, 2, 6)),
    ("alpha_range", np.float64, (2,)),
    ("nearest_square", np.float64, (2,)),
    ("box_volume", np.float64, (2,)),
)

#: A pose: p, R, n6, and for each limb r_i = R B_i and the vector from A_i to B_i.
POSE = record_type(
    ("position", np.float64, (3,)),
    ("rotation", np.float64, (3, 3)),
    ("axis", np.float64, (3,)),
    ("arms", np.float64, (LIMBS, 3)),
    ("vectors", np.float64, (LIMBS, 3)),
)

Design = Any
Pose = Any


@kernel
def solve_alpha(
    design: Design, x: float, y: float, z: float, sb: float, cb: float, sg: float, cg: float
) -> tuple[float, float, bool]:
    """Return the angle α that the constraint leaves, on the branch of home.

    Parameters
    ----------
    design
        The design.
    x, y, z
        p.
    sb, cb, sg, cg
        Sines and cosines of β and γ.

    Returns
    -------
    sine, cosine
        Those of α.
    exists
        Whether there is such an angle; not where the constraint touches 0 only.
    """
    n = design.axis
    wx = cb * n[0] + sb * (sg * n[1] + cg * n[2])
    wy = cg * n[1] - sg * n[2]
    wz = -sb * n[0] + cb * (sg * n[1] + cg * n[2])
    qx, qy, qz = (
        design.base_joints[LIMBS - 1, 0] - x,
        design.base_joints[LIMBS - 1, 1] - y,
        design.base_joints[LIMBS - 1, 2] - z,
    )
    p = qx * wx + qy * wy
    q = qy * wx - qx * wy
    c = qz * wz - design.axis_offset[0]
    square = p * p + q * q
    radicand = square - c * c
    if not radicand > 0.0:
        return 0.0, 1.0, False
    root = design.branch[0] * math.sqrt(radicand)
    return (-c * q - root * p) / square, (-c * p + root * q) / square, True


@kernel
def set_orientation(
    pose: Pose, design: Design, sa: float, ca: float, sb: float, cb: float, sg: float, cg: float
) -> None:  # fmt: skip
    """Set R, n6 and the arms of a pose (Eqs. 2 and 3).

    Parameters
    ----------
    pose
        Receives them.
    design
        The design.
    sa, ca, sb, cb, sg, cg
        Sines and cosines of α, β and γ.
    """
    r = pose.rotation
    r[0, 0], r[0, 1], r[0, 2] = ca * cb, ca * sb * sg - sa * cg, ca * sb * cg + sa * sg
    r[1, 0], r[1, 1], r[1, 2] = sa * cb, sa * sb * sg + ca * cg, sa * sb * cg - ca * sg
    r[2, 0], r[2, 1], r[2, 2] = -sb, cb * sg, cb * cg
    n = design.axis
    for j in range(3):
        pose.axis[j] = r[j, 0] * n[0] + r[j, 1] * n[1] + r[j, 2] * n[2]
    for i in range(LIMBS):
        b = design.platform_joints[i]
        for j in range(3):
            pose.arms[i, j] = r[j, 0] * b[0] + r[j, 1] * b[1] + r[j, 2] * b[2]


@kernel
def set_position(pose: Pose, design: Design, x: float, y: float, z: float) -> None:
    """Set p of a pose with an orientation, and the vectors of the limbs (Eq. 4)."""
    pose.position[0], pose.position[1], pose.position[2] = x, y, z
    for i in range(LIMBS):
        for j in range(3):
            arm = pose.arms[i, j]
            pose.vectors[i, j] = pose.position[j] + arm - design.base_joints[i, j]
