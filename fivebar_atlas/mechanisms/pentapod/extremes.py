"""The least singular value and the largest limb force that a search finds, for kernels.

The search begins at the worst pose of a sample. In each round it tries poses around the worst one
so far, at distances of several scales, together with the ends of their lines, where extremes on
limits are; the distances grow where that helped and shrink where it did not. A search does not
prove anything: there may be worse poses far from all samples.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.pentapod.conditioning import (
    Poses,
    add_pose,
    find_singular_values,
    largest_limb_force,
)
from fivebar_atlas.mechanisms.pentapod.fibre import (
    NOTHING,
    ONLY_SINGULAR,
    SOMETHING_SINGULAR,
    Fibre,
    find_through,
)
from fivebar_atlas.numerics.extreme_eigenvalues import LANES
from fivebar_atlas.numerics.interval_sets import nearest_point
from fivebar_atlas.numerics.records import record_type

#: What extremes are of: the least singular value, and the largest limb force.
SINGULAR_VALUE, LIMB_FORCE = range(2)

#: For both, the worst value so far as a number that is to be small, and where it is.
WORST = record_type(("value", np.float64, (2,)), ("coordinates", np.float64, (2, 5)))

Worst = Any

# Rounds, the first distance as a share of the box, its factors, and where it ends.
_ROUNDS, _FIRST, _GROWTH, _DECAY, _LAST = 60, 0.2, 1.5, 0.6, 1e-7
# Distances within a round are halved so often, by turns.
_SCALES = 4


@kernel
def note_worst(worst: Worst, w: Poses, which: int) -> int:
    """Compare the poses that wait, with their singular values, to the worst so far.

    Parameters
    ----------
    worst
        The worst so far: the singular value, and the reciprocal of the force.
    w
        The poses.
    which
        SINGULAR_VALUE, LIMB_FORCE, or -1 for both.

    Returns
    -------
    int
        How many of them were worse than all before.
    """
    found = 0
    for k in range(w.count[0]):
        least = w.least_singular_value[k]
        if which != LIMB_FORCE and least < worst.value[SINGULAR_VALUE]:
            worst.value[SINGULAR_VALUE] = least
            for c in range(5):
                worst.coordinates[SINGULAR_VALUE, c] = w.coordinates[k, c]
            found += 1
        # no column of the inverse is longer than the reciprocal of the least singular value
        if which != SINGULAR_VALUE and least < worst.value[LIMB_FORCE]:
            value = 1.0 / largest_limb_force(w, k)
            if value < worst.value[LIMB_FORCE]:
                worst.value[LIMB_FORCE] = value
                for c in range(5):
                    worst.coordinates[LIMB_FORCE, c] = w.coordinates[k, c]
                found += 1
    return found


@kernel
def search_worst(f: Fibre, w: Poses, worst: Worst, which: int, deviates: FloatArray) -> bool:
    """Search for a worse pose than the worst so far, around it.

    Parameters
    ----------
    f, w
        Work space with the design.
    worst
        The worst pose so far; receives a worse one.
    which
        SINGULAR_VALUE or LIMB_FORCE.
    deviates
        Random numbers with mean 0 and variance 1, shape (n, 5), taken by turns.

    Returns
    -------
    bool
        Whether a pose within all other limits was met where det G has not the sign it has at
        home. The search then ends: the extremes are those of a singular pose.
    """
    least, greatest = f.design.boxes[0, 0], f.design.boxes[0, 1]
    distance, used = _FIRST, 0
    center = worst.coordinates[which]
    for _ in range(_ROUNDS):
        w.count[0] = 0
        for j in range(LANES):
            scale = distance * 0.5 ** (j % _SCALES)
            u = deviates[used % len(deviates)]
            used += 1
            x = center[0] + scale * u[0] * (greatest[0] - least[0])
            y = center[1] + scale * u[1] * (greatest[1] - least[1])
            z = center[2] + scale * u[2] * (greatest[2] - least[2])
            beta = center[3] + scale * u[3] * (greatest[4] - least[4])
            gamma = center[4] + scale * u[4] * (greatest[5] - least[5])
            x = min(max(x, least[0]), greatest[0])
            y = min(max(y, least[1]), greatest[1])
            z = min(max(z, least[2]), greatest[2])
            beta = min(max(beta, least[4]), greatest[4])
            gamma = min(max(gamma, least[5]), greatest[5])
            state, _length = find_through(f, 0, x, y, z, beta, gamma)
            if state in (SOMETHING_SINGULAR, ONLY_SINGULAR):
                return True
            if state == NOTHING:
                continue
            way = 0.0
            kind = (j // _SCALES) % 4
            if kind == 2:
                way = -math.inf
            elif kind == 3:
                way = math.inf
            add_pose(w, f, nearest_point(f.usable, way), beta, gamma, 0.0)
        improved = 0
        if w.count[0] > 0:
            find_singular_values(w)
            improved = note_worst(worst, w, which)
        distance *= _GROWTH if improved > 0 else _DECAY
        distance = min(distance, 0.5)
        if distance < _LAST:
            break
    w.count[0] = 0
    return False
