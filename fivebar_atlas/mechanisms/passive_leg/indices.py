"""Indices of the usable workspace as adaptive integrals over its columns (Eqs. 27, 29).

Across θ every run is cut into panels, whose Gauss-Kronrod nodes are columns; along l every
interval into leaves. Positions are v in [0, 1] with the variable change of :func:`cluster` on the
whole run and on the whole interval: square roots at their ends become smooth. Where the LCI crosses
a threshold leaves are cut at the crossing.

Everything is integrated in the planar measure l dl dθ; indices of the whole workspace in the
(l, θ) measure dl dθ, too.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.columns import PASSIVE_JOINTS, find_column
from fivebar_atlas.mechanisms.passive_leg.isotropy import MAX_ISOTROPIC, isotropic_points
from fivebar_atlas.mechanisms.passive_leg.jacobian import TINY, local_indices
from fivebar_atlas.mechanisms.passive_leg.kinematics import reaches_at
from fivebar_atlas.mechanisms.passive_leg.singularity import FORWARD, conditions_at
from fivebar_atlas.mechanisms.passive_leg.workspace import RUNS, Runs, is_of_run
from fivebar_atlas.numerics.quadrature import (
    cluster,
    cluster_inverse,
    cluster_slope,
    gauss_kronrod,
    kronrod_error,
    null_rules,
)
from fivebar_atlas.numerics.records import record_type
from fivebar_atlas.numerics.roots import (
    FOUND,
    first_sections,
    first_share,
    next_section,
    next_share,
)

IndexArray = npt.NDArray[np.int64]

#: Order of the Gauss rules and number of Kronrod nodes.
ORDER = 7
NODES = 2 * ORDER + 1
# Null rules besides the difference of Gauss and Kronrod sums.
_NULL_RULES = 2
#: Most thresholds treated together.
MAX_THRESHOLDS = 4
#: Integrals: planar area, ∫∫ dl dθ, LCI and manipulability in the planar and in the (l, θ)
#: measure, then area, LCI and manipulability at every threshold.
AREA, WIDTH, LCI, MANIPULABILITY, LCI_WIDTH, MANIPULABILITY_WIDTH, FIXED = range(7)
VALUES = FIXED + 3 * MAX_THRESHOLDS
#: Most panels across θ, and most leaves along an interval.
MAX_PANELS, MAX_LEAVES = 400, 64
# Share of the tolerance that the integrals along l may take; no leaf is shorter than this in v.
_INNER_SHARE, _SHORTEST = 0.1, 1e-4
# The manipulability of a small good-condition workspace counts as if it had this share of the area.
_LEAST_SHARE = 0.1
# Kronrod errors of smooth integrands are at least this share of the Gauss-Kronrod difference. The
# LCI is not smooth at isotropic points, nor are intervals that end at a forward singularity, which
# may bend sharply. Integrals over where the LCI reaches a threshold are not where the level curve
# has a turning point: there columns differ in their number of crossings, and a panel may miss by
# chance what lies between them.
_LEAST_GAIN, _BEND_GAIN, _LEVEL_GAIN, _TURNING_GAIN = 0.3, 4.0, 4.0, 16.0
# With thresholds panels are no wider than this times the root of the tolerance, that what lies
# between their columns is of the size of the tolerance, but they need not be narrower than this.
_SPACING, _NARROW = 150.0, 0.1
#: What none of the columns meets of where the LCI reaches a threshold may have this share of the
#: tolerance.
UNSEEN_SHARE = 0.2
# Intervals are cut at isotropic points from columns no farther than this angle, unless that is as
# near to an end in v.
_NEAR_ANGLE, _AT_END = 0.25, 1e-3
# Of what halving a panel has changed, its halves keep at least this share as their error.
_KEPT_CHANGE = 1.0
# Most places where the LCI crosses a threshold on a leaf; steps and brackets of roots.
_MAX_CUTS = 12
_ROOT, _MAX_STEPS, _TURNING_STEPS = 1e-12, 60, 24
# A turning point counts if the parabola through its points comes this near to the threshold, as a
# share of the middle one, or if that is less than a share of the other two.
_NEAR, _SMALL = 0.5, 0.25
# Pattern search for the largest LCI: first step as a share of the links, and the last one.
_FIRST_STEP, _LAST_STEP = 0.02, 1e-10
# Some node of a workspace with an isotropic point has more than this LCI.
_NEARLY_ISOTROPIC = 0.9


class Integrals(Protocol):
    """Integrals over the usable workspace of one design.

    Attributes
    ----------
    runs
        Its runs.
    nodes, weights, gauss_weights
        The rule on [0, 1], shape (NODES,).
    panel_run, panel_low, panel_high
        Run and ends in v of every panel, shape (MAX_PANELS,).
    panel_values, panel_errors, panel_inner
        Integrals over every panel, their errors across θ and those of the integrals along l, shape
        (MAX_PANELS, VALUES).
    total, total_error
        The sums, shape (VALUES,).
    column_values, column_errors
        Integrals along the intervals of one column, shape (VALUES,).
    column_cuts, most_cuts, fewest_cuts
        How often a column crosses each threshold; most and fewest in a panel, shape
        (MAX_THRESHOLDS,).
    gauss
        Gauss sums of a panel, shape (VALUES,).
    null_weights, null_sums
        Null rules, shape (_NULL_RULES, NODES), and their values for a panel, shape (_NULL_RULES,
        VALUES).
    leaf_low, leaf_high
        Leaves to do, shape (MAX_LEAVES,).
    v, lci, manipulability, length
        Points of a leaf, its ends first and last, shape (NODES + 2,).
    cuts
        Where a threshold is crossed, shape (_MAX_CUTS + 2,).
    best
        Largest LCI of a node, l and θ there, shape (3,).
    halved
        Integrals over the panel that was halved last, shape (VALUES,).
    isotropic, isotropic_count
        Isotropic points, l and θ, shape (MAX_ISOTROPIC, 2), and their number, shape (1,).
    gaps
        Area and ∫∫ dl dθ that are left out between runs, shape (2,).
    missed
        Angle of a column that is not of its run, shape (1,).
    """

    runs: Runs
    nodes: FloatArray
    weights: FloatArray
    gauss_weights: FloatArray
    panel_run: IndexArray
    panel_low: FloatArray
    panel_high: FloatArray
    panel_values: FloatArray
    panel_errors: FloatArray
    panel_inner: FloatArray
    total: FloatArray
    total_error: FloatArray
    column_values: FloatArray
    column_errors: FloatArray
    column_cuts: IndexArray
    most_cuts: IndexArray
    fewest_cuts: IndexArray
    gauss: FloatArray
    null_weights: FloatArray
    null_sums: FloatArray
    leaf_low: FloatArray
    leaf_high: FloatArray
    v: FloatArray
    lci: FloatArray
    manipulability: FloatArray
    length: FloatArray
    cuts: FloatArray
    best: FloatArray
    halved: FloatArray
    isotropic: FloatArray
    isotropic_count: IndexArray
    gaps: FloatArray
    missed: FloatArray


_PANELS = (MAX_PANELS, VALUES)
INTEGRALS = record_type(
    ("runs", RUNS, ()),
    *((name, np.float64, (NODES,)) for name in ("nodes", "weights", "gauss_weights")),
    *((name, np.int64, (MAX_THRESHOLDS,)) for name in ("column_cuts", "most_cuts", "fewest_cuts")),
    ("panel_run", np.int64, (MAX_PANELS,)),
    *((name, np.float64, (MAX_PANELS,)) for name in ("panel_low", "panel_high")),
    *((name, np.float64, _PANELS) for name in ("panel_values", "panel_errors", "panel_inner")),
    *(
        (name, np.float64, (VALUES,))
        for name in ("total", "total_error", "column_values", "column_errors", "gauss", "halved")
    ),
    ("null_weights", np.float64, (_NULL_RULES, NODES)),
    ("null_sums", np.float64, (_NULL_RULES, VALUES)),
    *((name, np.float64, (MAX_LEAVES,)) for name in ("leaf_low", "leaf_high")),
    *((name, np.float64, (NODES + 2,)) for name in ("v", "lci", "manipulability", "length")),
    ("cuts", np.float64, (_MAX_CUTS + 2,)),
    ("best", np.float64, (3,)),
    ("isotropic", np.float64, (MAX_ISOTROPIC, 2)),
    ("isotropic_count", np.int64, (1,)),
    ("gaps", np.float64, (2,)),
    ("missed", np.float64, (1,)),
)


def set_rule(w: Integrals) -> None:
    """Fill in the quadrature rule."""
    w.nodes[:], w.weights[:], w.gauss_weights[:] = gauss_kronrod(ORDER)
    w.null_weights[:] = null_rules(ORDER, _NULL_RULES)


@kernel
def _find_cuts(
    w: Integrals, threshold: float, r: float, l_a: float, l_b: float, c: float, s: float,
    elbow1: float, elbow2: float, low: float, width: float,
) -> int:  # fmt: skip
    """Find where the LCI crosses a threshold on the leaf whose points are filled in."""
    count = 0
    for j in range(NODES + 1):
        f1, f2 = w.lci[j] - threshold, w.lci[j + 1] - threshold
        # brackets of this gap: its ends, or its ends with a turning point between
        middle, f_middle, has_middle = 0.0, 0.0, False
        if (f1 > 0.0) == (f2 > 0.0) and j > 0:
            before, here, after = w.lci[j - 1] - threshold, f1, f2
            sign = 1.0 if here > 0.0 else -1.0
            before, here, after = sign * before, sign * here, sign * after
            # the turning point may be on either side of the point in the middle
            one = (here - before) / (w.v[j] - w.v[j - 1])
            other = (after - here) / (w.v[j + 1] - w.v[j])
            bend = (other - one) / (w.v[j + 1] - w.v[j - 1])
            slope = one + bend * (w.v[j] - w.v[j - 1])
            if (
                here <= before
                and here <= after
                and min(before, after) > 0.0
                and bend > 0.0
                and (
                    here < _SMALL * min(before, after)
                    or here - 0.25 * slope * slope / bend < _NEAR * here
                )
            ):
                left, right = w.v[j - 1], w.v[j + 1]
                x1, x2 = first_sections(left, right)
                y1, y2 = 0.0, 0.0
                for step in range(_TURNING_STEPS + 2):
                    left, right, x1, y1, x2, y2, trial = next_section(
                        step, left, right, x1, y1, x2, y2
                    )
                    length = low + width * cluster(trial)
                    value, _ = local_indices(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
                    value = sign * (value - threshold)
                    if trial == x1:
                        y1 = value
                    else:
                        y2 = value
                    if value < 0.0:
                        middle, f_middle, has_middle = trial, sign * value, True
                        break
                    if value > here and step > 6:
                        break
        elif (f1 > 0.0) == (f2 > 0.0):
            continue
        if (f1 > 0.0) == (f2 > 0.0) and not has_middle:
            continue
        for side in range(2 if has_middle else 1):
            x1, g1 = w.v[j], f1
            x2, g2 = w.v[j + 1], f2
            if has_middle:
                x1, g1 = (w.v[j - 1], w.lci[j - 1] - threshold) if side == 0 else (x2, g2)
                x2, g2 = middle, f_middle
            if count == _MAX_CUTS:
                break
            x3, g3 = x2, g2
            share = first_share(g1, g2)
            for _ in range(_MAX_STEPS):
                trial = x1 + share * (x2 - x1)
                length = low + width * cluster(trial)
                value, _ = local_indices(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
                value -= threshold
                if (value > 0.0) == (g1 > 0.0):
                    x3, g3 = x1, g1
                else:
                    x3, g3, x2, g2 = x2, g2, x1, g1
                x1, g1 = trial, value
                share = next_share(x1, g1, x2, g2, x3, g3, _ROOT)
                if share == FOUND:
                    break
            place = count
            while place > 0 and w.cuts[place - 1] > x1:
                w.cuts[place] = w.cuts[place - 1]
                place -= 1
            w.cuts[place] = x1
            count += 1
    return count


@kernel
def integrate_interval(
    w: Integrals, r: float, l_a: float, l_b: float, theta: float, elbow1: float, elbow2: float,
    low: float, high: float, thresholds: FloatArray, tolerance: float, has_manipulability: bool,
) -> None:  # fmt: skip
    """Add the integrals along an interval of l to those of its column.

    Parameters
    ----------
    w
        Work space.
    r, l_a, l_b, elbow1, elbow2
        Design and elbows.
    theta
        Angle of the passive leg.
    low, high
        The interval.
    thresholds
        LCI thresholds, at most MAX_THRESHOLDS.
    tolerance
        Relative tolerance along l.
    has_manipulability
        Whether that of the whole interval is to be integrated to the tolerance.
    """
    c, s = math.cos(theta), math.sin(theta)
    width = high - low
    kinds = len(thresholds)
    w.column_values[AREA] += 0.5 * (high - low) * (high + low)
    w.column_values[WIDTH] += width
    # leaves end where the tip of a cone is near
    leaves, start_v = 0, 0.0
    while True:
        end_v = 1.0
        for k in range(w.isotropic_count[0]):
            at, off = w.isotropic[k, 0], abs(w.isotropic[k, 1] - theta)
            if off < _NEAR_ANGLE and low < at < high:
                v = cluster_inverse((at - low) / width)
                if start_v + _AT_END < v < end_v - _AT_END:
                    end_v = v
        w.leaf_low[leaves], w.leaf_high[leaves] = start_v, end_v
        leaves += 1
        if end_v == 1.0:
            break
        start_v = end_v
    while leaves > 0:
        leaves -= 1
        a, b = w.leaf_low[leaves], w.leaf_high[leaves]
        for j in range(NODES + 2):
            v = a if j == 0 else (b if j == NODES + 1 else a + (b - a) * w.nodes[j - 1])
            length = low + width * cluster(v)
            w.v[j], w.length[j] = v, length
            w.lci[j], w.manipulability[j] = local_indices(
                1.0, r, l_a, l_b, length, c, s, elbow1, elbow2
            )
        k0, k1, k2, k3, g0, g1, g2, g3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(1, NODES + 1):
            slope = width * cluster_slope(w.v[j]) * (b - a)
            weight, gauss = slope * w.weights[j - 1], slope * w.gauss_weights[j - 1]
            first, second = w.lci[j], w.manipulability[j]
            k0 += weight * w.length[j] * first
            k1 += weight * w.length[j] * second
            k2 += weight * first
            k3 += weight * second
            g0 += gauss * w.length[j] * first
            g1 += gauss * w.length[j] * second
            g2 += gauss * first
            g3 += gauss * second
            if first > w.best[0]:
                w.best[0], w.best[1], w.best[2] = first, w.length[j], theta
        e0, e1 = abs(k0 - g0), 0.0
        e2, e3 = abs(k2 - g2), 0.0
        is_good = e0 <= tolerance * k0 and e2 <= tolerance * k2
        if has_manipulability:
            e1 = kronrod_error(abs(k1 - g1), k1, _LEAST_GAIN)
            e3 = kronrod_error(abs(k3 - g3), k3, _LEAST_GAIN)
            is_good = is_good and e1 <= tolerance * k1 and e3 <= tolerance * k3
        if not is_good and b - a > _SHORTEST and leaves + 2 <= MAX_LEAVES:
            middle = 0.5 * (a + b)
            w.leaf_low[leaves], w.leaf_high[leaves] = middle, b
            w.leaf_low[leaves + 1], w.leaf_high[leaves + 1] = a, middle
            leaves += 2
            continue
        w.column_values[LCI] += k0
        w.column_values[MANIPULABILITY] += k1
        w.column_values[LCI_WIDTH] += k2
        w.column_values[MANIPULABILITY_WIDTH] += k3
        w.column_errors[LCI] += e0
        w.column_errors[MANIPULABILITY] += e1
        w.column_errors[LCI_WIDTH] += e2
        w.column_errors[MANIPULABILITY_WIDTH] += e3
        for kind in range(kinds):
            threshold = thresholds[kind]
            at = FIXED + 3 * kind
            cuts = _find_cuts(w, threshold, r, l_a, l_b, c, s, elbow1, elbow2, low, width)
            w.column_cuts[kind] += cuts
            if cuts == 0:
                if w.lci[NODES // 2 + 1] >= threshold:
                    start, end = w.length[0], w.length[NODES + 1]
                    w.column_values[at] += 0.5 * (end - start) * (end + start)
                    w.column_values[at + 1] += k0
                    w.column_values[at + 2] += k1
                    w.column_errors[at + 1] += e0
                    w.column_errors[at + 2] += e1
                continue
            for piece in range(cuts + 1):
                one = a if piece == 0 else w.cuts[piece - 1]
                other = b if piece == cuts else w.cuts[piece]
                length = low + width * cluster(0.5 * (one + other))
                value, _ = local_indices(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
                if value < threshold:
                    continue
                start, end = low + width * cluster(one), low + width * cluster(other)
                w.column_values[at] += 0.5 * (end - start) * (end + start)
                p0, p1, q0, q1 = 0.0, 0.0, 0.0, 0.0
                for j in range(NODES):
                    v = one + (other - one) * w.nodes[j]
                    length = low + width * cluster(v)
                    first, second = local_indices(1.0, r, l_a, l_b, length, c, s, elbow1, elbow2)
                    slope = length * width * cluster_slope(v) * (other - one)
                    p0 += slope * w.weights[j] * first
                    p1 += slope * w.weights[j] * second
                    q0 += slope * w.gauss_weights[j] * first
                    q1 += slope * w.gauss_weights[j] * second
                w.column_values[at + 1] += p0
                w.column_values[at + 2] += p1
                w.column_errors[at + 1] += abs(p0 - q0)
                w.column_errors[at + 2] += kronrod_error(abs(p1 - q1), p1, _LEAST_GAIN)


@kernel
def _integrate_panel(
    w: Integrals, panel: int, part: int, r: float, l_a: float, l_b: float,
    elbow1: float, elbow2: float, sign: float, conditions: int, thresholds: FloatArray,
    tolerance: float, has_indices: bool, has_manipulability: bool,
) -> bool:  # fmt: skip
    """Integrate one panel; return False where a column is not of its run."""
    runs = w.runs
    run = w.panel_run[panel]
    a, b = w.panel_low[panel], w.panel_high[panel]
    span = runs.end[run] - runs.start[run]
    w.panel_values[panel, :] = 0.0
    w.panel_inner[panel, :] = 0.0
    w.gauss[:] = 0.0
    w.null_sums[:] = 0.0
    is_smooth = True
    for i in range(runs.intervals[run]):
        if (part < 0 or runs.part[run, i] == part) and (
            runs.low_kind[run, i] == FORWARD or runs.high_kind[run, i] == FORWARD
        ):
            is_smooth = False
    for j in range(NODES):
        v = a + (b - a) * w.nodes[j]
        theta = runs.start[run] + span * cluster(v)
        find_column(runs.column, r, l_a, l_b, theta, elbow1, elbow2, sign, conditions)
        if not is_of_run(runs, run):
            w.missed[0] = theta
            return False
        w.column_values[:] = 0.0
        w.column_errors[:] = 0.0
        w.column_cuts[:] = 0
        for i in range(runs.intervals[run]):
            if part >= 0 and runs.part[run, i] != part:
                continue
            low, high = runs.column.low[i], runs.column.high[i]
            if has_indices:
                integrate_interval(
                    w, r, l_a, l_b, theta, elbow1, elbow2, low, high, thresholds,
                    _INNER_SHARE * tolerance, has_manipulability,
                )  # fmt: skip
            else:
                w.column_values[AREA] += 0.5 * (high - low) * (high + low)
        for kind in range(len(thresholds)):
            cuts = w.column_cuts[kind]
            w.most_cuts[kind] = cuts if j == 0 else max(cuts, w.most_cuts[kind])
            w.fewest_cuts[kind] = cuts if j == 0 else min(cuts, w.fewest_cuts[kind])
        slope = span * cluster_slope(v) * (b - a)
        for k in range(VALUES):
            w.panel_values[panel, k] += slope * w.weights[j] * w.column_values[k]
            w.panel_inner[panel, k] += slope * w.weights[j] * w.column_errors[k]
            w.gauss[k] += slope * w.gauss_weights[j] * w.column_values[k]
            for rule in range(_NULL_RULES if k >= FIXED else 0):
                w.null_sums[rule, k] += slope * w.null_weights[rule, j] * w.column_values[k]
    for k in range(VALUES):
        value = w.panel_values[panel, k]
        difference = abs(value - w.gauss[k])
        if k >= FIXED:
            for rule in range(_NULL_RULES):
                difference = max(difference, abs(w.null_sums[rule, k]))
            kind = (k - FIXED) // 3
            turns = kind < len(thresholds) and w.most_cuts[kind] > w.fewest_cuts[kind]
            difference *= _TURNING_GAIN if turns else _LEVEL_GAIN
        elif not is_smooth:
            difference *= _BEND_GAIN
        elif k != LCI and k != LCI_WIDTH:
            difference = kronrod_error(difference, value, _LEAST_GAIN)
        w.panel_errors[panel, k] = difference
    return True


@kernel
def _keep_change(w: Integrals, one: int, other: int) -> None:
    """Raise the errors of two halves to a share of what they changed; see ``_KEPT_CHANGE``."""
    for k in range(VALUES):
        change = abs(w.panel_values[one, k] + w.panel_values[other, k] - w.halved[k])
        errors = w.panel_errors[one, k] + w.panel_errors[other, k]
        if errors < _KEPT_CHANGE * change:
            if errors > 0.0:
                w.panel_errors[one, k] *= _KEPT_CHANGE * change / errors
                w.panel_errors[other, k] *= _KEPT_CHANGE * change / errors
            else:
                w.panel_errors[one, k] = w.panel_errors[other, k] = 0.5 * _KEPT_CHANGE * change


@kernel
def _sum_panels(w: Integrals, panels: int) -> None:
    """Add up the panels and their errors, and what the gaps between runs leave out."""
    w.total[:] = 0.0
    w.total_error[:] = 0.0
    for panel in range(panels):
        for k in range(VALUES):
            w.total[k] += w.panel_values[panel, k]
            w.total_error[k] += w.panel_errors[panel, k] + w.panel_inner[panel, k]
    # there the LCI is 1 at most, and the manipulability about its mean
    area, width = w.gaps[0], w.gaps[1]
    for k in (AREA, LCI):
        w.total_error[k] += area
    for k in (WIDTH, LCI_WIDTH):
        w.total_error[k] += width
    w.total_error[MANIPULABILITY] += area * w.total[MANIPULABILITY] / (w.total[AREA] + TINY)
    w.total_error[MANIPULABILITY_WIDTH] += (
        width * w.total[MANIPULABILITY_WIDTH] / (w.total[WIDTH] + TINY)
    )
    for k in range(FIXED, VALUES, 3):
        w.total_error[k] += area
        w.total_error[k + 1] += area
        w.total_error[k + 2] += area * w.total[k + 2] / (w.total[k] + TINY)


@kernel
def _measure_gaps(w: Integrals, part: int) -> None:
    """Find what is left out between neighbouring runs."""
    runs = w.runs
    w.gaps[:] = 0.0
    for run in range(1, runs.count[0]):
        gap = runs.start[run] - runs.end[run - 1]
        for side in range(2):
            at = run - side
            lows, highs = (
                (runs.first_low[at], runs.first_high[at])
                if side == 0
                else (runs.last_low[at], runs.last_high[at])
            )
            for i in range(runs.intervals[at]):
                if part < 0 or runs.part[at, i] == part:
                    w.gaps[0] += 0.5 * gap * (highs[i] - lows[i]) * (highs[i] + lows[i])
                    w.gaps[1] += gap * (highs[i] - lows[i])


@kernel
def _scale_of(w: Integrals, k: int, has_manipulability: bool) -> float:
    """Return what the error of an integral is measured by; 0 where it does not count."""
    if k in (AREA, WIDTH, LCI, LCI_WIDTH):
        return float(w.total[k])
    if k in (MANIPULABILITY, MANIPULABILITY_WIDTH):
        return float(w.total[k]) if has_manipulability else 0.0
    which = (k - FIXED) % 3
    # a small good-condition workspace counts as a part of the whole
    if which == 0:
        return float(w.total[AREA])
    return float(w.total[LCI] if which == 1 else w.total[k] + _LEAST_SHARE * w.total[AREA])


@kernel
def integrate_part(
    w: Integrals, part: int, r: float, l_a: float, l_b: float, elbow1: float, elbow2: float,
    sign: float, conditions: int, thresholds: FloatArray, tolerance: float, has_indices: bool,
    has_manipulability: bool,
) -> int:  # fmt: skip
    """Integrate over a part of the workspace until every error is within the tolerance.

    Parameters
    ----------
    w
        Work space with the runs; receives ``total`` and ``total_error``.
    part
        Number of the part, -1 for all of them.
    r, l_a, l_b, elbow1, elbow2, sign, conditions
        As for :func:`columns.find_column`.
    thresholds
        LCI thresholds, at most MAX_THRESHOLDS.
    tolerance
        Relative tolerance.
    has_indices
        Whether anything besides the area is wanted.
    has_manipulability
        Whether the manipulability is bounded; if not its integrals are not to be used.

    Returns
    -------
    int
        0: done, 1: tolerance not reached, 2: columns are missing from the runs.
    """
    runs = w.runs
    w.isotropic_count[0] = 0
    if has_indices:
        limit = max(abs(runs.start[0]), abs(runs.end[runs.count[0] - 1]))
        w.isotropic_count[0] = isotropic_points(
            r, l_a, l_b, limit, elbow1, elbow2, sign, conditions, w.isotropic
        )
    values = FIXED + 3 * len(thresholds) if has_indices else 1
    w.best[0] = -1.0
    _measure_gaps(w, part)
    # columns of a panel are closest at its ends
    widest = math.inf
    if has_indices and len(thresholds) > 0:
        widest = max(_SPACING * math.sqrt(tolerance), _NARROW)
    panels = 0
    for run in range(runs.count[0]):
        if runs.end[run] <= runs.start[run]:
            continue
        is_used = False
        for i in range(runs.intervals[run]):
            if part < 0 or runs.part[run, i] == part:
                is_used = True
        if not is_used:
            continue
        # panels end at the angles of isotropic points
        start_v, span = 0.0, runs.end[run] - runs.start[run]
        while True:
            end_v = 1.0
            for k in range(w.isotropic_count[0] if has_indices else 0):
                at = (w.isotropic[k, 1] - runs.start[run]) / span
                if 0.0 < at < 1.0:
                    v = cluster_inverse(at)
                    if start_v + _AT_END < v < end_v - _AT_END:
                        end_v = v
            w.panel_run[panels], w.panel_low[panels], w.panel_high[panels] = run, start_v, end_v
            panels += 1
            if end_v == 1.0:
                break
            start_v = end_v
    done, is_halved = 0, False
    while True:
        while done < panels:
            if not _integrate_panel(
                w, done, part, r, l_a, l_b, elbow1, elbow2, sign, conditions, thresholds,
                tolerance, has_indices, has_manipulability,
            ):  # fmt: skip
                return 2
            done += 1
        if is_halved:
            _keep_change(w, panels - 2, panels - 1)
        _sum_panels(w, panels)
        worst, worst_share, is_reached = -1, 0.0, True
        for k in range(values):
            scale = _scale_of(w, k, has_manipulability) * tolerance
            if scale > 0.0 and w.total_error[k] > scale:
                is_reached = False
        if is_reached:
            for panel in range(panels):
                run = w.panel_run[panel]
                span = cluster(w.panel_high[panel]) - cluster(w.panel_low[panel])
                span *= runs.end[run] - runs.start[run]
                if span > widest and span > worst_share:
                    worst, worst_share = panel, span
            if worst < 0:
                return 0
        if panels + 1 >= MAX_PANELS:
            return 1
        for panel in range(panels if not is_reached else 0):
            share = 0.0
            for k in range(values):
                scale = _scale_of(w, k, has_manipulability) * tolerance
                if scale > 0.0 and w.total_error[k] > scale:
                    share = max(share, w.panel_errors[panel, k] / scale)
            if share > worst_share and w.panel_high[panel] - w.panel_low[panel] > 1e-12:
                worst, worst_share = panel, share
        if worst < 0:
            return 1
        # the half on the right becomes a new panel, that on the left takes the place of the last
        middle = 0.5 * (w.panel_low[worst] + w.panel_high[worst])
        last = panels - 1
        w.halved[:] = w.panel_values[worst, :]
        run, low, high = w.panel_run[worst], w.panel_low[worst], w.panel_high[worst]
        w.panel_run[worst] = w.panel_run[last]
        w.panel_low[worst], w.panel_high[worst] = w.panel_low[last], w.panel_high[last]
        w.panel_values[worst, :] = w.panel_values[last, :]
        w.panel_errors[worst, :] = w.panel_errors[last, :]
        w.panel_inner[worst, :] = w.panel_inner[last, :]
        w.panel_run[last], w.panel_low[last], w.panel_high[last] = run, low, middle
        w.panel_run[panels], w.panel_low[panels], w.panel_high[panels] = run, middle, high
        done, is_halved = last, True
        panels += 1


@kernel
def largest_lci(
    w: Integrals, r: float, l_a: float, l_b: float, theta_limit: float,
    elbow1: float, elbow2: float, sign: float, conditions: int,
) -> tuple[float, float, float]:  # fmt: skip
    """Return the largest LCI, and l and θ there: an isotropic point, or near the best node.

    NaN where there are no nodes.
    """
    best, length, theta = w.best[0], w.best[1], w.best[2]
    step = _FIRST_STEP
    if best < 0.0:
        return math.nan, math.nan, math.nan
    if w.isotropic_count[0] > 0 and best > _NEARLY_ISOTROPIC:
        return 1.0, w.isotropic[0, 0], w.isotropic[0, 1]
    while step > _LAST_STEP:
        is_better = False
        for direction in range(8):
            at_l, at_theta = length, theta
            if direction < 2:
                at_theta = theta + (step if direction == 0 else -step)
            elif direction < 4:
                at_l = length + (step if direction == 2 else -step)
            else:
                at_l = length + (step if direction < 6 else -step)
                at_theta = theta + (step if direction % 2 == 0 else -step)
            if at_l <= 0.0 or abs(at_theta) > theta_limit:
                continue
            c, s = math.cos(at_theta), math.sin(at_theta)
            if not reaches_at(1.0, r, l_a, l_b, at_l, c, s):
                continue
            f, q1, q2 = conditions_at(1.0, r, l_a, l_b, at_l, c, s, elbow1, elbow2)
            if sign * f <= 0.0 or (conditions & PASSIVE_JOINTS and (q1 <= 0.0 or q2 <= 0.0)):
                continue
            value, _ = local_indices(1.0, r, l_a, l_b, at_l, c, s, elbow1, elbow2)
            if value > best:
                best, length, theta, is_better = value, at_l, at_theta, True
        if not is_better:
            step *= 0.5
    return best, length, theta
