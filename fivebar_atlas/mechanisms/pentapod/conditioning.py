"""Singular values of G and the largest limb force of many poses at once, for kernels.

G_h is G with its last three columns over the characteristic length L, so of twists (v, L ω), the
row of the constraint among its six. The squares of its singular values are the eigenvalues of
G_hᵀ G_h. What that costs in digits is told in :mod:`extreme_eigenvalues`: an LCI of 1e-3 has a
relative error of about 1e-9, and one of 1e-7 about 10 %.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.pentapod.fibre import Fibre
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS
from fivebar_atlas.numerics.extreme_eigenvalues import (
    EIGENVALUES,
    LANES,
    find_extreme_eigenvalues,
)
from fivebar_atlas.numerics.records import record_type

_ORDER = 6

#: Poses that wait for their singular values, at most LANES: G_h, a weight, X, Y, Z, β, γ, and the
#: results.
POSES = record_type(
    ("count", np.int64, (1,)),
    ("g", np.float64, (_ORDER, _ORDER, LANES)),
    ("weight", np.float64, (LANES,)),
    ("coordinates", np.float64, (LANES, 5)),
    ("eigenvalues", EIGENVALUES, ()),
    ("least_singular_value", np.float64, (LANES,)),
    ("lci", np.float64, (LANES,)),
    ("inverse", np.float64, (_ORDER, 2 * _ORDER)),
)

Poses = Any


@kernel
def add_pose(
    w: Poses, f: Fibre, way: float, beta: float, gamma: float, weight: float
) -> None:  # fmt: skip
    """Put G_h of a pose of a line behind those that wait.

    Parameters
    ----------
    w
        Poses, fewer than LANES.
    f
        The line.
    way
        How far along it from its pose the pose is.
    beta, gamma
        Its angles, to be kept.
    weight
        Its weight, to be kept.
    """
    k = w.count[0]
    pose, d = f.pose, f.direction
    scale = 1.0 / f.design.characteristic_length[0]
    for i in range(LIMBS):
        l0 = pose.vectors[i, 0] + way * d[0]
        l1 = pose.vectors[i, 1] + way * d[1]
        l2 = pose.vectors[i, 2] + way * d[2]
        factor = 1.0 / math.sqrt(l0 * l0 + l1 * l1 + l2 * l2)
        l0, l1, l2 = factor * l0, factor * l1, factor * l2
        r0, r1, r2 = scale * pose.arms[i, 0], scale * pose.arms[i, 1], scale * pose.arms[i, 2]
        w.g[i, 0, k], w.g[i, 1, k], w.g[i, 2, k] = l0, l1, l2
        w.g[i, 3, k] = r1 * l2 - r2 * l1
        w.g[i, 4, k] = r2 * l0 - r0 * l2
        w.g[i, 5, k] = r0 * l1 - r1 * l0
    n, last = pose.axis, f.design.base_joints[LIMBS - 1]
    x = pose.position[0] + way * d[0]
    y = pose.position[1] + way * d[1]
    z = pose.position[2] + way * d[2]
    r0, r1, r2 = scale * (last[0] - x), scale * (last[1] - y), scale * (last[2] - z)
    w.g[5, 0, k], w.g[5, 1, k], w.g[5, 2, k] = n[0], n[1], n[2]
    w.g[5, 3, k] = r1 * n[2] - r2 * n[1]
    w.g[5, 4, k] = r2 * n[0] - r0 * n[2]
    w.g[5, 5, k] = r0 * n[1] - r1 * n[0]
    w.weight[k] = weight
    c = w.coordinates
    c[k, 0], c[k, 1], c[k, 2], c[k, 3], c[k, 4] = x, y, z, beta, gamma
    w.count[0] = k + 1


@kernel
def find_singular_values(w: Poses) -> None:
    """Find least singular value and LCI of the poses that wait."""
    a = w.eigenvalues.matrix
    for i in range(_ORDER):
        for j in range(i + 1):
            for k in range(LANES):
                a[i, j, k] = (
                    w.g[0, i, k] * w.g[0, j, k]
                    + w.g[1, i, k] * w.g[1, j, k]
                    + w.g[2, i, k] * w.g[2, j, k]
                    + w.g[3, i, k] * w.g[3, j, k]
                    + w.g[4, i, k] * w.g[4, j, k]
                    + w.g[5, i, k] * w.g[5, j, k]
                )
    find_extreme_eigenvalues(w.eigenvalues, w.count[0])
    for k in range(w.count[0]):
        least = max(w.eigenvalues.least[k], 0.0)
        w.least_singular_value[k] = math.sqrt(least)
        w.lci[k] = math.sqrt(least / w.eigenvalues.greatest[k])


@kernel
def largest_limb_force(w: Poses, k: int) -> float:
    """Return the largest force in a limb for a unit wrench (F, T / L), of a pose that waits.

    Returns
    -------
    float
        The largest length of the first five columns of G_h⁻¹ (Eq. 16: the forces are less its
        transpose times the wrench); infinite where G_h is singular.
    """
    m = w.inverse
    for i in range(_ORDER):
        for j in range(_ORDER):
            m[i, j] = w.g[i, j, k]
            m[i, _ORDER + j] = 1.0 if i == j else 0.0
    for c in range(_ORDER):
        pivot = c
        for i in range(c + 1, _ORDER):
            if abs(m[i, c]) > abs(m[pivot, c]):
                pivot = i
        if m[pivot, c] == 0.0:
            return math.inf
        factor = 1.0 / m[pivot, c]
        for j in range(c, 2 * _ORDER):
            kept = m[c, j]
            m[c, j] = factor * m[pivot, j]
            if pivot != c:
                m[pivot, j] = kept
        for i in range(_ORDER):
            if i != c:
                factor = m[i, c]
                for j in range(c, 2 * _ORDER):
                    m[i, j] -= factor * m[c, j]
    largest = 0.0
    for j in range(_ORDER, _ORDER + LIMBS):
        square = 0.0
        for i in range(_ORDER):
            square += m[i, j] * m[i, j]
        largest = max(largest, square)
    return math.sqrt(largest)
