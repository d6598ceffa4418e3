"""Which lengths the passive leg can have at one angle θ: a column of the workspace.

In (l, θ) both legs reach a few intervals of l, with ends in closed form (Eq. 12). In a mode pair
only those parts of them are left where f = l det J_x has one sign and, if the passive joints are
limited, q_1 and q_2 are positive. Their ends are roots, bracketed by samples along the interval
and at the turning points in between.

Positions on an interval are v in [0, 1], with l = low + (high - low)(3 v² - 2 v³): in v everything
is analytic up to its ends, where legs are stretched or folded.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.singularity import (
    FORWARD,
    INNER_1,
    INNER_2,
    LIMIT_1,
    LIMIT_2,
    NO_LENGTH,
    OUTER_1,
    OUTER_2,
    conditions_at,
)
from fivebar_atlas.numerics.quadrature import cluster
from fivebar_atlas.numerics.records import record_type
from fivebar_atlas.numerics.roots import (
    FOUND,
    first_sections,
    first_share,
    next_section,
    next_share,
)

IndexArray = npt.NDArray[np.int64]

#: Bits of what holds in a workspace besides reach: the sign of det J_x, and the passive joints.
ONE_SIGN, PASSIVE_JOINTS = 1, 2
#: Most intervals in a column; more than five have not been seen.
MAX_INTERVALS = 8
#: Samples along an interval: evenly, and one next to either end, so that a turning point between it
#: and the end is seen.
SAMPLES, _NEXT_TO_END = 22, 0.005
# Most roots along an interval.
_MAX_ROOTS = 24
# Bracket in v at which a root is found; steps of a root and of a turning point.
_ROOT, _MAX_STEPS, _TURNING_STEPS = 1e-14, 60, 30
# The search for a turning point is over where the parabola through its samples, bent so many times
# as much, does not come to zero any more.
_BENT = 50.0
# Roots closer to an end in v than this, some 1e-11 of the interval in l, are rounding at the end.
_AT_END = 2e-6
# Closer to O columns are rounding where R - r = l_b - l_a: there legs are folded in all poses.
_AT_O = 1e-6
# Holes whose half height squared is less than this are rounding.
_NO_HOLE = 1e-13


class Column(Protocol):
    """Intervals of l at one angle.

    Attributes
    ----------
    count
        Number of intervals, shape (1,).
    low, high
        Their ends, rising, shape (MAX_INTERVALS,).
    low_kind, high_kind
        What is there, see :mod:`singularity`.
    reach_low, reach_high, reach_low_kind, reach_high_kind
        The intervals that both legs reach, shape (4,).
    sample_v, samples
        Positions, shape (SAMPLES,), and the conditions there, shape (3, SAMPLES).
    root_v, root_kind
        Roots along an interval, shape (_MAX_ROOTS + 2,).
    bracket
        Condition, v1, f1, v2, f2 of the roots to find, shape (_MAX_ROOTS, 5).
    """

    count: IndexArray
    low: FloatArray
    high: FloatArray
    low_kind: IndexArray
    high_kind: IndexArray
    reach_low: FloatArray
    reach_high: FloatArray
    reach_low_kind: IndexArray
    reach_high_kind: IndexArray
    sample_v: FloatArray
    samples: FloatArray
    root_v: FloatArray
    root_kind: IndexArray
    bracket: FloatArray


COLUMN = record_type(
    ("count", np.int64, (1,)),
    ("low", np.float64, (MAX_INTERVALS,)),
    ("high", np.float64, (MAX_INTERVALS,)),
    ("low_kind", np.int64, (MAX_INTERVALS,)),
    ("high_kind", np.int64, (MAX_INTERVALS,)),
    ("reach_low", np.float64, (4,)),
    ("reach_high", np.float64, (4,)),
    ("reach_low_kind", np.int64, (4,)),
    ("reach_high_kind", np.int64, (4,)),
    ("sample_v", np.float64, (SAMPLES,)),
    ("samples", np.float64, (3, SAMPLES)),
    ("root_v", np.float64, (_MAX_ROOTS + 2,)),
    ("root_kind", np.int64, (_MAX_ROOTS + 2,)),
    ("bracket", np.float64, (_MAX_ROOTS, 5)),
)


def set_samples(column: Column) -> None:
    """Fill in where intervals are sampled: at their ends, next to them and evenly in between."""
    even = np.linspace(0.0, 1.0, SAMPLES - 2)
    column.sample_v[:] = np.sort([*even, _NEXT_TO_END, 1.0 - _NEXT_TO_END])


@kernel
def reach_intervals(col: Column, r: float, l_a: float, l_b: float, c: float, s: float) -> int:
    """Find the intervals of positive l that both legs reach; return their number.

    Leg i reaches where |l ± R sin θ| is between the half heights of its two reach circles.
    """
    gap = r - c
    outer = l_a + l_b
    inner = abs(l_a - l_b)
    outer2 = (outer - gap) * (outer + gap)
    inner2 = (inner - gap) * (inner + gap)
    if outer2 <= 0.0:
        return 0
    high = math.sqrt(outer2)
    has_hole = inner2 > _NO_HOLE
    low = math.sqrt(inner2) if has_hole else 0.0
    count = 0
    for one in range(2 if has_hole else 1):
        # interval of leg 1, whose middle is at -sin θ
        low1 = -s - high if one == 0 else -s + low
        high1 = -s - low if one == 0 and has_hole else -s + high
        low1_kind = OUTER_1 if one == 0 else INNER_1
        high1_kind = INNER_1 if one == 0 and has_hole else OUTER_1
        for other in range(2 if has_hole else 1):
            low2 = s - high if other == 0 else s + low
            high2 = s - low if other == 0 and has_hole else s + high
            low2_kind = OUTER_2 if other == 0 else INNER_2
            high2_kind = INNER_2 if other == 0 and has_hole else OUTER_2
            start, start_kind = 0.0, NO_LENGTH
            if low1 > start:
                start, start_kind = low1, low1_kind
            if low2 > start:
                start, start_kind = low2, low2_kind
            end, end_kind = high1, high1_kind
            if high2 < end:
                end, end_kind = high2, high2_kind
            if end > start:
                col.reach_low[count], col.reach_high[count] = start, end
                col.reach_low_kind[count], col.reach_high_kind[count] = start_kind, end_kind
                count += 1
    # by rising l; at most four, already nearly in order
    for i in range(1, count):
        for j in range(i, 0, -1):
            if col.reach_low[j] >= col.reach_low[j - 1]:
                break
            for ends in (col.reach_low, col.reach_high):
                ends[j], ends[j - 1] = ends[j - 1], ends[j]
            for kinds in (col.reach_low_kind, col.reach_high_kind):
                kinds[j], kinds[j - 1] = kinds[j - 1], kinds[j]
    return count


@kernel
def _bracket_roots(
    col: Column, r: float, l_a: float, l_b: float, c: float, s: float,
    elbow1: float, elbow2: float, low: float, width: float, conditions: int,
) -> int:  # fmt: skip
    """Bracket the roots of the conditions along an interval; return their number."""
    for j in range(SAMPLES):
        length = low + width * cluster(col.sample_v[j])
        f, q1, q2 = conditions_at(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
        col.samples[0, j], col.samples[1, j], col.samples[2, j] = f, q1, q2
    count = 0
    for which in range(3):
        if conditions & (ONE_SIGN if which == 0 else PASSIVE_JOINTS) == 0:
            continue
        row = col.samples[which]
        # what vanishes at an end has the sign that it has next to it
        if row[0] == 0.0:
            row[0] = row[1]
        if row[SAMPLES - 1] == 0.0:
            row[SAMPLES - 1] = row[SAMPLES - 2]
        for j in range(SAMPLES - 1):
            if (row[j] > 0.0) != (row[j + 1] > 0.0) and count < _MAX_ROOTS:
                col.bracket[count, 0] = which
                col.bracket[count, 1], col.bracket[count, 2] = col.sample_v[j], row[j]
                col.bracket[count, 3], col.bracket[count, 4] = col.sample_v[j + 1], row[j + 1]
                count += 1
        for j in range(1, SAMPLES - 1):
            before, here, after = row[j - 1], row[j], row[j + 1]
            sign = 1.0 if here > 0.0 else -1.0
            before, here, after = sign * before, sign * here, sign * after
            if before < here or after < here or min(before, after) <= 0.0:
                continue
            left, right = col.sample_v[j - 1], col.sample_v[j + 1]
            one = (here - before) / (col.sample_v[j] - left)
            other = (after - here) / (right - col.sample_v[j])
            bend = (other - one) / (right - left)
            if bend <= 0.0:
                continue
            # walk down to the turning point, until below zero or sure not to be
            x1, x2 = first_sections(left, right)
            y1, y2 = 0.0, 0.0
            for step in range(_TURNING_STEPS + 2):
                left, right, x1, y1, x2, y2, trial = next_section(step, left, right, x1, y1, x2, y2)
                length = low + width * cluster(trial)
                f, q1, q2 = conditions_at(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
                value = sign * (f if which == 0 else (q1 if which == 1 else q2))
                if trial == x1:
                    y1 = value
                else:
                    y2 = value
                if value < 0.0:
                    if count + 1 < _MAX_ROOTS:
                        for end in range(2):
                            v, at = (
                                (col.sample_v[j - 1], before)
                                if end == 0
                                else (col.sample_v[j + 1], after)
                            )
                            col.bracket[count, 0] = which
                            col.bracket[count, 1], col.bracket[count, 2] = v, sign * at
                            col.bracket[count, 3], col.bracket[count, 4] = trial, sign * value
                            count += 1
                    break
                if step > 0 and min(y1, y2) > _BENT * bend * (right - left) ** 2:
                    break
    return count


@kernel
def find_column(
    col: Column, r: float, l_a: float, l_b: float, theta: float, elbow1: float, elbow2: float,
    sign: float, conditions: int,
) -> None:  # fmt: skip
    """Find the intervals of l at an angle.

    Parameters
    ----------
    col
        Receives them.
    r, l_a, l_b
        Design, R = 1.
    theta
        Angle of the passive leg.
    elbow1, elbow2
        Elbows as for :func:`kinematics.lower_link`.
    sign
        Sign that det J_x has in the mode pair.
    conditions
        What is to hold besides reach: a sum of ONE_SIGN and PASSIVE_JOINTS.
    """
    c, s = math.cos(theta), math.sin(theta)
    found = 0
    for number in range(reach_intervals(col, r, l_a, l_b, c, s)):
        low = col.reach_low[number]
        width = col.reach_high[number] - low
        roots = 0
        if conditions != 0:
            brackets = _bracket_roots(
                col, r, l_a, l_b, c, s, elbow1, elbow2, low, width, conditions
            )
            for k in range(brackets):
                which = int(col.bracket[k, 0])
                x1, f1 = col.bracket[k, 1], col.bracket[k, 2]
                x2, f2 = col.bracket[k, 3], col.bracket[k, 4]
                x3, f3 = x2, f2
                share = first_share(f1, f2)
                for _ in range(_MAX_STEPS):
                    trial = x1 + share * (x2 - x1)
                    length = low + width * cluster(trial)
                    f, q1, q2 = conditions_at(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
                    value = f if which == 0 else (q1 if which == 1 else q2)
                    if (value > 0.0) == (f1 > 0.0):
                        x3, f3 = x1, f1
                    else:
                        x3, f3, x2, f2 = x2, f2, x1, f1
                    x1, f1 = trial, value
                    share = next_share(x1, f1, x2, f2, x3, f3, _ROOT)
                    if share == FOUND:
                        break
                if x1 < _AT_END or x1 > 1.0 - _AT_END or low + width * cluster(x1) < _AT_O:
                    continue
                kind = FORWARD if which == 0 else (LIMIT_1 if which == 1 else LIMIT_2)
                place = roots
                while place > 0 and col.root_v[place - 1] > x1:
                    col.root_v[place] = col.root_v[place - 1]
                    col.root_kind[place] = col.root_kind[place - 1]
                    place -= 1
                col.root_v[place], col.root_kind[place] = x1, kind
                roots += 1
        for k in range(roots + 1):
            v1 = 0.0 if k == 0 else col.root_v[k - 1]
            v2 = 1.0 if k == roots else col.root_v[k]
            if v2 <= v1:
                continue
            if conditions != 0:
                length = low + width * cluster(0.5 * (v1 + v2))
                f, q1, q2 = conditions_at(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
                if conditions & ONE_SIGN and sign * f <= 0.0:
                    continue
                if conditions & PASSIVE_JOINTS and (q1 <= 0.0 or q2 <= 0.0):
                    continue
            if found == MAX_INTERVALS:
                break
            col.low[found] = low + width * cluster(v1)
            col.high[found] = col.reach_high[number] if k == roots else low + width * cluster(v2)
            col.low_kind[found] = col.reach_low_kind[number] if k == 0 else col.root_kind[k - 1]
            col.high_kind[found] = col.reach_high_kind[number] if k == roots else col.root_kind[k]
            found += 1
    col.count[0] = found
