"""The linkage in a position: joints and links for a given C or for given inputs.

Nam and Park 2006, Fig. 1: the passive leg O C, the platform b_1 b_2 across its end, and the legs
B_i d_i b_i. Limits of the passive joints are not looked at here: these are all solutions of the
kinematic problems with the passive leg on its side of the base.
"""

from __future__ import annotations

import math

import numpy as np

from fivebar_atlas.errors import InputError, OutOfReachError
from fivebar_atlas.mechanisms.mode_pairs import Signs, mode_label
from fivebar_atlas.mechanisms.passive_leg import forward
from fivebar_atlas.mechanisms.passive_leg.jacobian import lci, matrices_in_platform_axes
from fivebar_atlas.mechanisms.passive_leg.kinematics import inverse, leg_vector
from fivebar_atlas.mechanisms.passive_leg.points import Lengths, pose_of
from fivebar_atlas.mechanisms.planar import (
    ACTUATED,
    BASE,
    CRANK,
    DISTAL,
    OUTPUT,
    PASSIVE,
    PLATFORM,
    TELESCOPE,
    Joint,
    Link,
    Pose,
)
from fivebar_atlas.planar_geometry import Point

#: Notation of the inputs.
INPUT_SYMBOLS = (r"$\phi_1$", r"$\phi_2$")

# A distance or an angle beyond a limit that is no more than rounding (R = 1).
_ROUNDING = 1e-12
_LINKS = (
    Link("$R$", 2, 0, BASE),
    Link("", 2, 1, BASE),
    Link("$l_c$", 2, 7, TELESCOPE),
    Link("$r$", 7, 5, PLATFORM),
    Link("", 7, 6, PLATFORM),
    Link("$l_a$", 0, 3, CRANK),
    Link("$l_a$", 1, 4, CRANK),
    Link("$l_b$", 3, 5, DISTAL),
    Link("$l_b$", 4, 6, DISTAL),
)
_WORKING_MODES = ((1, -1), (-1, 1), (1, 1), (-1, -1))


def leg_ends(lengths: Lengths, length: float, theta: float) -> tuple[Point, Point]:
    """Return the vectors from B_i to b_i in the axes of the platform."""
    base, platform, _, _ = lengths
    c, s = math.cos(theta), math.sin(theta)
    return (
        leg_vector(base, platform, length, c, s, 1.0),
        leg_vector(base, platform, length, c, s, -1.0),
    )


def check_reach(lengths: Lengths, theta_limit: float, x: float, y: float) -> None:
    """Raise InputError unless C is the end of a pose; it says why not and by how much."""
    if math.isnan(x) or math.isnan(y):
        raise InputError("P", (x, y), "two numbers")
    length, theta = pose_of(x, y)
    if length <= _ROUNDING:
        raise InputError("P", (x, y), "a point other than O: lengths of the passive leg above 0")
    if abs(theta) > theta_limit + _ROUNDING:
        limit, angle = math.degrees(theta_limit), math.degrees(theta)
        raise InputError(
            "P",
            (x, y),
            f"a point with the passive leg within {limit:.6g} deg of the y axis; there it is at "
            f"{angle:.6g} deg",
        )
    _, _, l_a, l_b = lengths
    worst, allowed = _ROUNDING, ""
    for leg, end in enumerate(leg_ends(lengths, length, theta), start=1):
        reach = math.hypot(*end)
        for gap, fault in (
            (reach - (l_a + l_b), "farther from B_{leg} than the stretched leg {leg} reaches"),
            (abs(l_a - l_b) - reach, "nearer to B_{leg} than the folded leg {leg} comes"),
        ):
            if gap > worst:
                worst = gap
                allowed = f"a point within reach; there b_{leg} is {{gap}} {fault.format(leg=leg)}"
        if reach <= _ROUNDING and abs(l_a - l_b) <= _ROUNDING:
            raise InputError(
                "P", (x, y), f"a point at which b_{leg} is not on B_{leg}, where leg {leg} may turn"
            )
    if allowed:
        raise OutOfReachError("P", (x, y), allowed, worst)


def pose_at(lengths: Lengths, theta_limit: float, x: float, y: float, s1: int, s2: int) -> Pose:
    """Return the linkage with the middle of its platform at C in a working mode.

    Raises
    ------
    InputError
        If C is not two numbers, or the passive leg has no length or is beyond its limit, or a
        folded leg may turn freely.
    OutOfReachError
        If a leg does not reach.
    """
    check_reach(lengths, theta_limit, x, y)
    length, theta = pose_of(x, y)
    elbows = (-float(s1), -float(s2))
    return _pose(lengths, length, theta, inverse(*lengths, length, theta, *elbows), (s1, s2))


def inverse_poses(lengths: Lengths, theta_limit: float, x: float, y: float) -> tuple[Pose, ...]:
    """Return the linkage with the middle of its platform at C in all four working modes (Eq. 6)."""
    return tuple(pose_at(lengths, theta_limit, x, y, s1, s2) for s1, s2 in _WORKING_MODES)


def forward_poses(
    lengths: Lengths, theta_limit: float, phi1: float, phi2: float
) -> tuple[Pose, ...]:
    """Return the linkage for given inputs in every assembly, by rising length of the passive leg.

    Those with the passive leg above the base and within its limit; without these conditions
    there are up to six (Eq. 11).

    Raises
    ------
    OutOfReachError
        If d_1 and d_2 are farther apart than the upper links and the platform reach.
    InputError
        If there is no assembly, or none with the passive leg where it may be.
    """
    base, platform, l_a, l_b = lengths
    angles = (phi1, phi2)
    elbows = [
        (side * base + l_a * math.cos(phi), l_a * math.sin(phi))
        for side, phi in zip((1.0, -1.0), angles, strict=True)
    ]
    gap = math.dist(*elbows) - 2.0 * (platform + l_b)
    if gap > _ROUNDING:
        allowed = "inputs that can be assembled; d_1 and d_2 are {gap} too far apart"
        raise OutOfReachError("inputs", angles, allowed, gap)
    found = forward.forward_poses(*lengths, phi1, phi2)
    if not len(found):
        raise InputError("inputs", angles, "inputs for which the linkage can be assembled")
    allowed_ones = found[
        (found[:, 0] > _ROUNDING) & (np.abs(found[:, 1]) <= theta_limit + _ROUNDING)
    ]
    if not len(allowed_ones):
        raise InputError(
            "inputs",
            angles,
            "inputs of a pose with the passive leg above the base, within "
            f"{math.degrees(theta_limit):.6g} deg of the y axis",
        )
    wrapped = (_principal(phi1), _principal(phi2))
    return tuple(
        _pose(lengths, float(length), float(theta), wrapped, None) for length, theta in allowed_ones
    )


def _principal(angle: float) -> float:
    """Return an angle in (-π, π]."""
    turned = math.remainder(angle, 2.0 * math.pi)
    return math.pi if turned == -math.pi else turned


def _pose(
    lengths: Lengths,
    length: float,
    theta: float,
    inputs: tuple[float, float],
    signs: tuple[int, int] | None,
) -> Pose:
    """Return a pose; without signs the working mode is read from the inputs."""
    base, platform, l_a, _ = lengths
    c, s = math.cos(theta), math.sin(theta)
    middle = (-length * s, length * c)
    arm = (platform * c, platform * s)
    ends = (
        (middle[0] + arm[0], middle[1] + arm[1]),
        (middle[0] - arm[0], middle[1] - arm[1]),
    )
    feet = ((base, 0.0), (0.0 - base, 0.0))
    elbows = tuple(
        (foot[0] + l_a * math.cos(phi), l_a * math.sin(phi))
        for foot, phi in zip(feet, inputs, strict=True)
    )
    if signs is None:
        s1, s2 = (
            # counter-clockwise of its leg is the elbow of "-"
            -1 if _cross(foot, end, elbow) >= 0.0 else 1
            for foot, end, elbow in zip(feet, ends, elbows, strict=True)
        )
        signs = s1, s2
    bends = (-float(signs[0]), -float(signs[1]))
    joints = (
        Joint("$B_1$", feet[0], ACTUATED),
        Joint("$B_2$", feet[1], ACTUATED),
        Joint("$O$", (0.0, 0.0), PASSIVE),
        Joint("$d_1$", elbows[0], PASSIVE),
        Joint("$d_2$", elbows[1], PASSIVE),
        Joint("$b_1$", ends[0], PASSIVE),
        Joint("$b_2$", ends[1], PASSIVE),
        Joint("$C$", middle, OUTPUT),
    )
    mode = mode_of(lengths, length, theta, signs)
    index = lci(*lengths, length, theta, *bends)
    return Pose(joints, _LINKS, inputs, INPUT_SYMBOLS, mode, index)


def _cross(foot: Point, end: Point, elbow: Point) -> float:
    """Return the cross product of a leg and its lower link."""
    return (end[0] - foot[0]) * (elbow[1] - foot[1]) - (end[1] - foot[1]) * (elbow[0] - foot[0])


def mode_of(lengths: Lengths, length: float, theta: float, signs: tuple[int, int]) -> str:
    """Return the mode pair of a pose; the working mode alone at a parallel singularity."""
    _, _, m11, m12, m21, m22 = matrices_in_platform_axes(
        *lengths, length, theta, -float(signs[0]), -float(signs[1])
    )
    det = m11 * m22 - m12 * m21
    scale = math.hypot(m11, m12) * math.hypot(m21, m22)
    pair: Signs = (*signs, 1 if det < 0.0 else -1)
    label = mode_label(pair)
    return label.partition("/")[0] if abs(det) <= _ROUNDING * scale else label
