"""Usable workspace of the manipulator with a passive leg: its columns put together over θ.

Angles at which columns change, because intervals appear, vanish, merge or are ended by something
else, are found by bisection between columns of a grid, to which those known in closed form are
added. Between them, in a run, every interval has ends that are smooth functions of θ. Intervals of
neighbouring runs that overlap are connected; the usable workspace is the connected part with the
largest planar area ∫∫ l dl dθ.

Working modes "+-" and "-+" are symmetric about θ = 0: there half of the angles will do.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.columns import (
    COLUMN,
    MAX_INTERVALS,
    Column,
    find_column,
    set_samples,
)
from fivebar_atlas.mechanisms.passive_leg.singularity import FORWARD
from fivebar_atlas.numerics.records import allocate_record, record_type

IndexArray = npt.NDArray[np.int64]

#: Most runs of columns of one kind.
MAX_RUNS = 96
#: Steps of the grid of angles, and the most angles that may be added to it.
GRID_STEPS, MAX_ADDED = 24, 80
#: Angles between which columns change are no farther apart than this.
EVENT = 1e-11
# Columns are looked at this far to either side of changes in closed form.
_BESIDE = 0.4 * EVENT
# Intervals that overlap by less than this are not connected.
_TOUCH = 1e-5
# Angles over which a forward singularity bounds a part are more than this; where the folded legs
# of r < R meet at O the holes are less than rounding over some 1e-6.
_LEAST_SPAN = 1e-5


class Runs(Protocol):
    """Runs of columns with the same kinds of ends, by rising angle.

    Attributes
    ----------
    column
        Work space.
    added, added_count
        Angles besides the grid at which columns are looked at, rising, shape (MAX_ADDED,), and
        their number, shape (1,).
    count
        Number of runs, shape (1,).
    start, end
        First and last angle, shape (MAX_RUNS,).
    intervals
        Number of intervals, shape (MAX_RUNS,).
    low_kind, high_kind
        What ends them, shape (MAX_RUNS, MAX_INTERVALS).
    first_low, first_high, last_low, last_high
        Ends of the intervals at the first and the last angle, shape (MAX_RUNS, MAX_INTERVALS).
    area
        Areas by the trapezoidal rule, shape (MAX_RUNS, MAX_INTERVALS).
    part
        Which intervals are connected: number of the part, shape (MAX_RUNS, MAX_INTERVALS).
    part_area
        Areas of the parts, shape (MAX_RUNS * MAX_INTERVALS,).
    """

    column: Column
    added: FloatArray
    added_count: IndexArray
    count: IndexArray
    start: FloatArray
    end: FloatArray
    intervals: IndexArray
    low_kind: IndexArray
    high_kind: IndexArray
    first_low: FloatArray
    first_high: FloatArray
    last_low: FloatArray
    last_high: FloatArray
    area: FloatArray
    part: IndexArray
    part_area: FloatArray


_ENDS = (MAX_RUNS, MAX_INTERVALS)
RUNS = record_type(
    ("column", COLUMN, ()),
    ("added", np.float64, (MAX_ADDED,)),
    ("added_count", np.int64, (1,)),
    ("count", np.int64, (1,)),
    ("start", np.float64, (MAX_RUNS,)),
    ("end", np.float64, (MAX_RUNS,)),
    ("intervals", np.int64, (MAX_RUNS,)),
    ("low_kind", np.int64, _ENDS),
    ("high_kind", np.int64, _ENDS),
    ("first_low", np.float64, _ENDS),
    ("first_high", np.float64, _ENDS),
    ("last_low", np.float64, _ENDS),
    ("last_high", np.float64, _ENDS),
    ("area", np.float64, _ENDS),
    ("part", np.int64, _ENDS),
    ("part_area", np.float64, (MAX_RUNS * MAX_INTERVALS,)),
)


def allocate_runs() -> Runs:
    """Return work space for the runs of one design."""
    runs: Runs = allocate_record(RUNS)
    set_samples(runs.column)
    return runs


@kernel
def is_of_run(runs: Runs, run: int) -> bool:
    """Tell whether the column that was found has the kinds of ends of a run."""
    col = runs.column
    if col.count[0] != runs.intervals[run]:
        return False
    for i in range(col.count[0]):
        if col.low_kind[i] != runs.low_kind[run, i] or col.high_kind[i] != runs.high_kind[run, i]:
            return False
    return True


@kernel
def _begin_run(runs: Runs, run: int, theta: float) -> None:
    """Begin a run with the column that was found."""
    col = runs.column
    runs.start[run] = runs.end[run] = theta
    runs.intervals[run] = col.count[0]
    for i in range(col.count[0]):
        runs.low_kind[run, i], runs.high_kind[run, i] = col.low_kind[i], col.high_kind[i]
        runs.first_low[run, i] = runs.last_low[run, i] = col.low[i]
        runs.first_high[run, i] = runs.last_high[run, i] = col.high[i]
        runs.area[run, i] = 0.0


@kernel
def _extend_run(runs: Runs, run: int, theta: float) -> None:
    """Add the column that was found to a run."""
    col = runs.column
    step = theta - runs.end[run]
    for i in range(col.count[0]):
        one = runs.last_high[run, i] ** 2 - runs.last_low[run, i] ** 2
        other = col.high[i] ** 2 - col.low[i] ** 2
        runs.area[run, i] += 0.25 * step * (one + other)
        runs.last_low[run, i], runs.last_high[run, i] = col.low[i], col.high[i]
    runs.end[run] = theta


@kernel
def find_runs(
    runs: Runs, r: float, l_a: float, l_b: float, start: float, end: float,
    elbow1: float, elbow2: float, sign: float, conditions: int, steps: int,
) -> bool:  # fmt: skip
    """Find the runs between two angles from a grid of so many steps.

    Parameters
    ----------
    runs
        Receives them.
    r, l_a, l_b, elbow1, elbow2, sign, conditions
        As for :func:`columns.find_column`.
    start, end
        The angles.
    steps
        Steps of the grid.

    Returns
    -------
    bool
        Whether there was room for all.
    """
    col = runs.column
    find_column(col, r, l_a, l_b, start, elbow1, elbow2, sign, conditions)
    run = 0
    _begin_run(runs, 0, start)
    step, added = 1, 0
    while step <= steps:
        target = end if step == steps else start + (end - start) * step / steps
        if added < runs.added_count[0] and runs.added[added] < target:
            target = runs.added[added]
            added += 1
        else:
            step += 1
        # the angle where a column is looked for, and one beyond the change that is closed in on
        theta, beyond, is_closing = target, target, False
        while True:
            find_column(col, r, l_a, l_b, theta, elbow1, elbow2, sign, conditions)
            if is_of_run(runs, run):
                _extend_run(runs, run, theta)
                if theta == target:
                    break
            else:
                beyond, is_closing = theta, True
            if is_closing and beyond - runs.end[run] > EVENT:
                theta = 0.5 * (runs.end[run] + beyond)
                continue
            if is_closing:
                if run + 1 == MAX_RUNS:
                    runs.count[0] = run + 1
                    return False
                find_column(col, r, l_a, l_b, beyond, elbow1, elbow2, sign, conditions)
                run += 1
                _begin_run(runs, run, beyond)
                is_closing = False
                if beyond == target:
                    break
            theta = target
    runs.count[0] = run + 1
    return True


@kernel
def add_angle(runs: Runs, theta: float) -> bool:
    """Add an angle to those at which columns are looked at; return whether there was room."""
    count = runs.added_count[0]
    if count == MAX_ADDED:
        return False
    place = count
    while place > 0 and runs.added[place - 1] > theta:
        runs.added[place] = runs.added[place - 1]
        place -= 1
    runs.added[place] = theta
    runs.added_count[0] = count + 1
    return True


@kernel
def add_known_angles(
    runs: Runs, r: float, l_a: float, l_b: float, start: float, end: float, conditions: int
) -> None:
    """Add the angles to either side of those at which columns change in closed form.

    A curve on which a point of the platform with the arm a keeps the distance ρ from a base joint
    turns back at cos θ = a ± ρ, and is at l = 0 where cos θ = (1 + a² - ρ²)/(2 a). There two
    intervals may touch in O, which is no connection of the parts that they belong to.

    Parameters
    ----------
    runs
        Receives the angles, and loses those that it has.
    r, l_a, l_b, conditions
        As for :func:`columns.find_column`.
    start, end
        The first and the last angle.
    """
    runs.added_count[0] = 0
    if start < 0.0 < end:
        add_angle(runs, -_BESIDE)
    if start <= 0.0 < end:
        add_angle(runs, _BESIDE)
    # legs stretched and folded, upper links level with the platform
    for curve in range(4 if conditions != 0 else 2):
        arm = r if curve < 2 else (r + l_b if curve == 2 else r - l_b)
        reach = l_a + l_b if curve == 0 else (abs(l_a - l_b) if curve == 1 else l_a)
        for place in range(3):
            if place == 0:
                if arm == 0.0:
                    continue
                cosine = (1.0 + (arm - reach) * (arm + reach)) / (2.0 * arm)
            else:
                cosine = arm - reach if place == 1 else arm + reach
            if not abs(cosine) < 1.0:
                continue
            angle = math.acos(cosine)
            for side in range(4):
                theta = (angle if side < 2 else -angle) + (_BESIDE if side % 2 else -_BESIDE)
                if start < theta < end:
                    add_angle(runs, theta)


@kernel
def _replace_part(runs: Runs, old: int, new: int) -> None:
    """Give the intervals of one part the number of another."""
    for run in range(runs.count[0]):
        for i in range(runs.intervals[run]):
            if runs.part[run, i] == old:
                runs.part[run, i] = new


@kernel
def largest_part(runs: Runs, is_half: bool) -> tuple[int, bool, bool]:
    """Connect the intervals of all runs and return the part with the largest area.

    Parameters
    ----------
    runs
        The runs; their ``part`` is filled in.
    is_half
        Whether the runs begin on the axis of symmetry and stand for their mirror image, too. Of
        a mirrored pair of parts one counts.

    Returns
    -------
    part : int
        Its number, -1 where there is none.
    is_mirrored : bool
        Whether it goes on beyond the axis of symmetry.
    has_forward : bool
        Whether a forward singularity bounds it.
    """
    count = runs.count[0]
    parts = 0
    for run in range(count):
        for i in range(runs.intervals[run]):
            runs.part[run, i] = parts
            parts += 1
    for run in range(1, count):
        for i in range(runs.intervals[run]):
            for j in range(runs.intervals[run - 1]):
                low = max(runs.first_low[run, i], runs.last_low[run - 1, j])
                high = min(runs.first_high[run, i], runs.last_high[run - 1, j])
                if high - low > _TOUCH and runs.part[run, i] != runs.part[run - 1, j]:
                    _replace_part(runs, runs.part[run, i], runs.part[run - 1, j])
    for part in range(parts):
        runs.part_area[part] = 0.0
    for run in range(count):
        for i in range(runs.intervals[run]):
            runs.part_area[runs.part[run, i]] += runs.area[run, i]
    best, best_area, best_mirrored = -1, 0.0, False
    for part in range(parts):
        area, is_mirrored = runs.part_area[part], False
        if is_half:
            for i in range(runs.intervals[0]):
                if runs.part[0, i] == part:
                    is_mirrored = True
        if is_mirrored:
            area *= 2.0
        if area > best_area:
            best, best_area, best_mirrored = part, area, is_mirrored
    span = 0.0
    for run in range(count):
        for i in range(runs.intervals[run]):
            if runs.part[run, i] == best and (
                runs.low_kind[run, i] == FORWARD or runs.high_kind[run, i] == FORWARD
            ):
                span += runs.end[run] - runs.start[run]
    return best, best_mirrored, span > _LEAST_SPAN
