"""What the ranges that Wang et al. (2017) print say about the geometry that they do not print.

The paper's motion is only in a figure, and W, φ and n6 are not given. Section 4, (1) prints the
ranges that the pose and the limb lengths sweep, with r_a = 400 mm and r_b = 100 mm.
"""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
from naive_pentapod import Machine as NaiveMachine
from naive_pentapod import home_side, solved_alpha

from fivebar_atlas.mechanisms.pentapod import jacobian, kinematics
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry

Array = npt.NDArray[np.float64]

# mm and degrees
POSES = np.array(
    [[-169.2, 74.5], [0.0, 535.0], [459.1, 580.2], [0.0, 52.5], [0.0, 35.0], [-39.4, 0.0]]
)
LIMBS = np.array([[670.4, 951.3], [587.9, 859.0], [520.0, 646.1], [627.3, 933.7], [633.4, 1020.8]])
MOTION = Path(__file__).parent / "baselines" / "pentapod_printed_motion.json"


def sampled(pentapod: PentapodGeometry, nodes: Array) -> Array:
    """Return poses along straight lines between nodes X, Y, Z, β, γ, in mm and radians."""
    share = np.linspace(0.0, 1.0, 101)[:, None]
    parts = [(1.0 - share) * one + share * other for one, other in pairwise(nodes)]
    found = np.vstack(parts)
    found[:, 3:] *= math.pi / 180.0
    m = NaiveMachine(pentapod.base, pentapod.platform, pentapod.axis)
    alpha, exists = solved_alpha(m, found[:, :3], found[:, 3], found[:, 4], home_side(m))
    assert exists.min() > 0.0
    return np.insert(found, 3, alpha, axis=1)


def test_one_motion_of_a_machine_sweeps_all_printed_ranges_and_nothing_more() -> None:
    """There is such a machine, with A_1 off the circle: the printed numbers can all be true.

    They do not tell the geometry: other W, φ and turns of the base do as well.
    """
    data = json.loads(MOTION.read_text(encoding="utf-8"))
    pentapod = PentapodGeometry.from_radii(
        400.0,
        100.0,
        math.radians(data["position_angle"]),
        data["W"],
        base_angle=math.radians(data["base_angle"]),
    )
    poses = sampled(pentapod, np.array(data["nodes"]))
    # it begins on the Z axis with parallel axes
    assert np.abs(poses[0, [0, 1, 3, 4, 5]]).max() < 1e-6
    assert np.abs(kinematics.constraint_residual(pentapod, poses)).max() < 1e-9
    shown = poses * np.repeat([1.0, 180.0 / math.pi], 3)
    lengths = kinematics.inverse_displacement(pentapod, poses).lengths
    for values, printed in ((shown, POSES), (lengths, LIMBS)):
        # to half of the last digit printed
        assert np.abs(values.min(axis=0) - printed[:, 0]).max() < 0.01
        assert np.abs(values.max(axis=0) - printed[:, 1]).max() < 0.01
    # no pose on the way is singular
    signs = np.sign(np.linalg.det(jacobian.jacobian(pentapod, poses)))
    assert np.all(signs == signs[0])
    assert signs[0] != 0.0


def test_the_start_excludes_an_a_1_on_the_circle_unless_b_1_is_far_round() -> None:
    """At the start limb 1 has at least 670.4 mm, at most 580.2 mm of them upward."""
    needed = LIMBS[0, 0] ** 2 - POSES[2, 1] ** 2
    limit = math.degrees(math.acos((400.0**2 + 100.0**2 - needed) / (2.0 * 400.0 * 100.0)))
    assert abs(limit - 44.36) < 0.005
    for angle, possible in ((limit - 0.01, False), (limit + 0.01, True), (36.0, False)):
        pentapod = PentapodGeometry.from_radii(400.0, 100.0, math.radians(angle))
        highest = np.array([0.0, 0.0, POSES[2, 1], 0.0, 0.0, 0.0])
        length = kinematics.inverse_displacement(pentapod, highest).lengths[0]
        assert (length >= LIMBS[0, 0]) == possible
