"""Which poses belong to a usable workspace, and the LCI there.

A pose belongs to it if both legs reach, no condition is violated, and its interval of l is of the
part that is usable: that is looked up in the runs of :mod:`workspace`.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.columns import PASSIVE_JOINTS, Column, find_column
from fivebar_atlas.mechanisms.passive_leg.jacobian import local_indices
from fivebar_atlas.mechanisms.passive_leg.kinematics import reaches_at
from fivebar_atlas.mechanisms.passive_leg.points import pose_of
from fivebar_atlas.mechanisms.passive_leg.singularity import conditions_at
from fivebar_atlas.mechanisms.passive_leg.workspace import Runs

BoolArray = npt.NDArray[np.bool_]


@kernel
def _interval_is_of_part(
    runs: Runs, col: Column, part: int, r: float, l_a: float, l_b: float, length: float,
    theta: float, elbow1: float, elbow2: float, sign: float, conditions: int,
) -> bool:  # fmt: skip
    """Tell whether the interval of l that a pose is in belongs to a part."""
    run = 0
    while run + 1 < runs.count[0] and runs.start[run + 1] <= theta:
        run += 1
    of_part = 0
    for i in range(runs.intervals[run]):
        if runs.part[run, i] == part:
            of_part += 1
    if of_part == 0:
        return False
    if of_part == runs.intervals[run]:
        return True
    find_column(col, r, l_a, l_b, theta, elbow1, elbow2, sign, conditions)
    if col.count[0] != runs.intervals[run]:
        return False
    for i in range(col.count[0]):
        if col.low[i] <= length <= col.high[i]:
            return bool(runs.part[run, i] == part)
    return False


@kernel
def is_inside(
    runs: Runs, col: Column, part: int, r: float, l_a: float, l_b: float, limit: float,
    length: float, theta: float, elbow1: float, elbow2: float, sign: float, conditions: int,
) -> bool:  # fmt: skip
    """Tell whether a pose is inside a part of a workspace; borders are not.

    Parameters
    ----------
    runs, part
        Runs of columns with their parts, and the number of the part.
    col
        Work space.
    r, l_a, l_b, elbow1, elbow2, sign, conditions
        As for :func:`columns.find_column`.
    limit
        Largest angle of the passive leg.
    length, theta
        The pose.
    """
    if not (length > 0.0 and abs(theta) < limit):
        return False
    c, s = math.cos(theta), math.sin(theta)
    if not reaches_at(1.0, r, l_a, l_b, length, c, s):
        return False
    f, q1, q2 = conditions_at(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
    if sign * f <= 0.0:
        return False
    if conditions & PASSIVE_JOINTS and (q1 <= 0.0 or q2 <= 0.0):
        return False
    return _interval_is_of_part(
        runs, col, part, r, l_a, l_b, length, theta, elbow1, elbow2, sign, conditions
    )


@kernel
def inside_at(
    runs: Runs, col: Column, part: int, r: float, l_a: float, l_b: float, limit: float,
    x: FloatArray, y: FloatArray, elbow1: float, elbow2: float, sign: float, conditions: int,
    out: BoolArray,
) -> None:  # fmt: skip
    """Tell which points are inside a part of a workspace."""
    for k in range(len(x)):
        length, theta = pose_of(x[k], y[k])
        out[k] = is_inside(
            runs, col, part, r, l_a, l_b, limit, length, theta, elbow1, elbow2, sign, conditions
        )


@kernel
def lci_inside_at(
    runs: Runs, col: Column, part: int, r: float, l_a: float, l_b: float, limit: float,
    x: FloatArray, y: FloatArray, elbow1: float, elbow2: float, sign: float, conditions: int,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill in LCI at points inside a part of a workspace, 0 elsewhere."""
    for k in range(len(x)):
        length, theta = pose_of(x[k], y[k])
        out[k] = 0.0
        if is_inside(
            runs, col, part, r, l_a, l_b, limit, length, theta, elbow1, elbow2, sign, conditions
        ):
            c, s = math.cos(theta), math.sin(theta)
            out[k] = local_indices(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)[0]
