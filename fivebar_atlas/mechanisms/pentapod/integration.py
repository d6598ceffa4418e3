"""Sums over points of the pose box, for kernels: shares, means and the workspace volume."""

from __future__ import annotations

from typing import Any

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.pentapod.conditioning import (
    POSES,
    Poses,
    add_pose,
    find_singular_values,
)
from fivebar_atlas.mechanisms.pentapod.drawn_lines import draw_line
from fivebar_atlas.mechanisms.pentapod.extremes import WORST, Worst, note_worst
from fivebar_atlas.mechanisms.pentapod.fibre import (
    FIBRE,
    NOTHING,
    ONLY_SINGULAR,
    SOMETHING_SINGULAR,
    Fibre,
    find_through,
)
from fivebar_atlas.numerics.extreme_eigenvalues import LANES
from fivebar_atlas.numerics.interval_sets import point_at, total_length
from fivebar_atlas.numerics.records import record_type

#: Work space of a thread.
WORK = record_type(("fibre", FIBRE, ()), ("poses", POSES, ()), ("worst", WORST, ()))

#: Sums over points: how many have usable poses on their line, how many have poses there that only
#: det G excludes, the largest share that a line can stand for (no sum), usable shares, and shares
#: times LCI and times the least singular value. Shares with an LCI of at least each threshold
#: follow, and these times LCI.
HITS, SINGULAR, LARGEST, SHARE, SHARE_LCI, SHARE_VALUE, SUMS = range(7)

Work = Any


@kernel
def _add_up(w: Poses, worst: Worst, thresholds: FloatArray, sums: FloatArray) -> None:
    """Add the poses that wait to the sums."""
    find_singular_values(w)
    note_worst(worst, w, -1)
    for k in range(w.count[0]):
        weight, lci = w.weight[k], w.lci[k]
        sums[SHARE_LCI] += weight * lci
        sums[SHARE_VALUE] += weight * w.least_singular_value[k]
        for t in range(len(thresholds)):
            if lci >= thresholds[t]:
                sums[SUMS + 2 * t] += weight
                sums[SUMS + 2 * t + 1] += weight * lci
    w.count[0] = 0


@kernel
def _integrate(
    w: Work, box: int, points: FloatArray, thresholds: FloatArray, sums: FloatArray
) -> None:
    """Add points to one row of sums."""
    f: Fibre = w.fibre
    least, greatest = f.design.boxes[box, 0], f.design.boxes[box, 1]
    # means gain little from a second pose of a line, shares above a threshold do
    parts = 2 if len(thresholds) > 0 else 1
    is_flat = not f.design.box_volume[box] > 0.0
    w.poses.count[0] = 0
    for n in range(len(points)):
        u = points[n]
        beta = least[4] + u[2] * (greatest[4] - least[4])
        gamma = least[5] + u[3] * (greatest[5] - least[5])
        if is_flat:
            x = least[0] + u[0] * (greatest[0] - least[0])
            y = least[1] + u[1] * (greatest[1] - least[1])
            z = least[2] + u[5] * (greatest[2] - least[2])
            state, length = find_through(f, box, x, y, z, beta, gamma)
            weight = 1.0 / length if length > 0.0 else 1.0
            sums[LARGEST] = 1.0
        else:
            state, weight, length = draw_line(f, box, u[0], u[1], beta, gamma)
            sums[LARGEST] = max(sums[LARGEST], weight * length)
        if state == NOTHING:
            continue
        if state in (SOMETHING_SINGULAR, ONLY_SINGULAR):
            sums[SINGULAR] += 1.0
            if state == ONLY_SINGULAR:
                continue
        usable = total_length(f.usable)
        share = weight * usable if length > 0.0 else weight
        sums[HITS] += 1.0
        sums[SHARE] += share
        if box == 0:
            # one pose of each of equal parts of the line
            for part in range(parts):
                way = point_at(f.usable, (part + u[4]) * usable / parts)
                add_pose(w.poses, f, way, beta, gamma, share / parts)
                if w.poses.count[0] == LANES:
                    _add_up(w.poses, w.worst, thresholds, sums)
    if w.poses.count[0] > 0:
        _add_up(w.poses, w.worst, thresholds, sums)


@kernel
def integrate(
    w: Work, box: int, points: FloatArray, thresholds: FloatArray, sums: FloatArray,
    values: FloatArray, coordinates: FloatArray,
) -> None:  # fmt: skip
    """Add points to sums, each scrambling to its own.

    Parameters
    ----------
    w
        Work space with the design.
    box
        0, the box of the indices, or 1, that of the workspace volume, for which nothing is summed
        but how many points and which share.
    points
        Points of the unit cube, shape (r, n, 6): two for the line, β, γ, one for the pose on it,
        and one for boxes that are flat.
    thresholds
        Least LCI of good condition, shape (k,).
    sums
        Receives the sums named above, shape (r, SUMS + 2 k).
    values, coordinates
        Worst poses so far of each scrambling as in :data:`extremes.WORST`, shapes (r, 2) and
        (r, 2, 5).
    """
    for r in range(len(points)):
        for which in range(2):
            w.worst.value[which] = values[r, which]
            for c in range(5):
                w.worst.coordinates[which, c] = coordinates[r, which, c]
        _integrate(w, box, points[r], thresholds, sums[r])
        for which in range(2):
            values[r, which] = w.worst.value[which]
            for c in range(5):
                coordinates[r, which, c] = w.worst.coordinates[which, c]
