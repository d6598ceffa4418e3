"""The linkage in a position: joints and links for a given P or for given inputs.

Liu, Wang and Zheng 2006, Fig. 1(b), Eqs. 2 to 12; all solutions as in Le, Kang and Doan 2013,
Fig. 2.
"""

from __future__ import annotations

import math

from fivebar_atlas.errors import InputError, OutOfReachError
from fivebar_atlas.mechanisms.five_bar.jacobian import distal_products, lci
from fivebar_atlas.mechanisms.five_bar.kinematics import elbow, forward, inverse
from fivebar_atlas.mechanisms.five_bar.loci import Lengths
from fivebar_atlas.mechanisms.mode_pairs import mode_label
from fivebar_atlas.mechanisms.planar import (
    ACTUATED,
    BASE,
    CRANK,
    DISTAL,
    OUTPUT,
    PASSIVE,
    Joint,
    Link,
    Pose,
)
from fivebar_atlas.planar_geometry import Point

# A distance beyond reach that is no more than rounding (lengths sum to 3).
_ROUNDING = 1e-12
_INPUT_SYMBOLS = (r"$\theta_{1}$", r"$\theta_{2}$")
_LINKS = (
    Link("$r_3$", 0, 1, BASE),
    Link("$r_1$", 0, 2, CRANK),
    Link("$r_1$", 1, 3, CRANK),
    Link("$r_2$", 2, 4, DISTAL),
    Link("$r_2$", 3, 4, DISTAL),
)


def check_reach(lengths: Lengths, x: float, y: float) -> None:
    """Raise InputError unless both legs reach P; it says which does not and by how much."""
    r1, r2, r3 = lengths
    if math.isnan(x) or math.isnan(y):
        raise InputError("P", (x, y), "two numbers")
    worst, allowed = _ROUNDING, ""
    for leg, base in ((1, -r3), (2, r3)):
        reach = math.hypot(x - base, y)
        for gap, fault in (
            (reach - (r1 + r2), "farther than the stretched leg {leg} reaches"),
            (abs(r1 - r2) - reach, "nearer to A_{leg} than the folded leg {leg} comes"),
        ):
            if gap > worst:
                worst, allowed = gap, "a point within reach; it is {gap} " + fault.format(leg=leg)
        if reach <= _ROUNDING and abs(r1 - r2) <= _ROUNDING:
            raise InputError("P", (x, y), f"a point other than A_{leg}, where leg {leg} may turn")
    if allowed:
        raise OutOfReachError("P", (x, y), allowed, worst)


def pose_at(lengths: Lengths, x: float, y: float, s1: int, s2: int) -> Pose:
    """Return the linkage with its output point at P in a working mode.

    Raises
    ------
    InputError
        If P is not two numbers, or is a base joint about which a folded leg turns freely.
    OutOfReachError
        If P cannot be reached.
    """
    check_reach(lengths, x, y)
    r1, r2, r3 = lengths
    b1 = elbow(r1, r2, -r3, x, y, s1)
    b2 = elbow(r1, r2, r3, x, y, s2)
    _, _, det, _, scale = distal_products(*lengths, x, y, s1, s2)
    mode = mode_label((s1, s2, 1 if det > 0.0 else -1))
    if abs(det) <= _ROUNDING * scale:
        mode = mode.partition("/")[0]
    inputs = inverse(*lengths, x, y, s1, s2)
    return _pose(lengths, b1, b2, (x, y), inputs, mode, lci(*lengths, x, y, s1, s2))


def inverse_poses(lengths: Lengths, x: float, y: float) -> tuple[Pose, ...]:
    """Return the linkage with its output point at P in all four working modes (Eq. 7)."""
    return tuple(pose_at(lengths, x, y, s1, s2) for s1, s2 in ((1, -1), (-1, 1), (1, 1), (-1, -1)))


def forward_poses(lengths: Lengths, theta1: float, theta2: float) -> tuple[Pose, ...]:
    """Return the linkage for given inputs, assembled up and down (Eq. 12).

    Raises
    ------
    OutOfReachError
        If B1 and B2 are farther apart than both distal links reach, or coincide.
    """
    r1, r2, r3 = lengths
    b1 = (r1 * math.cos(theta1) - r3, r1 * math.sin(theta1))
    b2 = (r1 * math.cos(theta2) + r3, r1 * math.sin(theta2))
    span = math.dist(b1, b2)
    angles = (theta1, theta2)
    if span - 2.0 * r2 > _ROUNDING:
        allowed = "inputs that can be assembled; B_1 and B_2 are {gap} too far apart"
        raise OutOfReachError("inputs", angles, allowed, span - 2.0 * r2)
    if span <= _ROUNDING:
        allowed = "inputs for which B_1 and B_2 differ; they are {gap} apart, and P is free"
        raise OutOfReachError("inputs", angles, allowed, span)
    poses = []
    for assembly in (1, -1):
        x, y, possible = forward(*lengths, theta1, theta2, assembly)
        if not possible:  # stretched to within rounding
            x, y = 0.5 * (b1[0] + b2[0]), 0.5 * (b1[1] + b2[1])
        s1, s2 = (
            1 if (x - base) * b[1] - y * (b[0] - base) >= 0.0 else -1
            for base, b in ((-r3, b1), (r3, b2))
        )
        mode = mode_label((s1, s2, assembly))
        wrapped = (_principal(theta1), _principal(theta2))
        poses.append(_pose(lengths, b1, b2, (x, y), wrapped, mode, lci(*lengths, x, y, s1, s2)))
    return tuple(poses)


def _principal(angle: float) -> float:
    """Return an angle in (-π, π]."""
    turned = math.remainder(angle, 2.0 * math.pi)
    return math.pi if turned == -math.pi else turned


def _pose(
    lengths: Lengths,
    b1: Point,
    b2: Point,
    p: Point,
    inputs: tuple[float, float],
    mode: str,
    index: float,
) -> Pose:
    r3 = lengths[2]
    joints = (
        Joint("$A_1$", (0.0 - r3, 0.0), ACTUATED),
        Joint("$A_2$", (r3, 0.0), ACTUATED),
        Joint("$B_1$", b1, PASSIVE),
        Joint("$B_2$", b2, PASSIVE),
        Joint("$P$", p, OUTPUT),
    )
    return Pose(joints, _LINKS, inputs, _INPUT_SYMBOLS, mode, index)
