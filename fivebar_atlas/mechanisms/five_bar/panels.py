"""Integrals over one panel: a piece of a strip in φ, by Gauss-Kronrod pairs both ways.

In a panel, every ray is cut at its stationary points and level crossings and each piece is
integrated by a Gauss-Kronrod pair; a second pair runs across the rays. Both use nodes
clustered at both ends, which undoes the square roots at serial singularities and tangent
rays and weakens what is left at cones.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.isotropy import MAX_ISOTROPIC
from fivebar_atlas.mechanisms.five_bar.jacobian import conditioning_ratio, lci
from fivebar_atlas.mechanisms.five_bar.rays import (
    ACROSS_NODES,
    ACROSS_ORDER,
    MAX_CROSSINGS,
    MAX_STATIONARY,
    MAX_THRESHOLDS,
    RAYS,
    Rays,
    set_samples,
)
from fivebar_atlas.numerics.quadrature import (
    cluster,
    cluster_inverse,
    clustered_gauss_kronrod,
    kronrod_error,
)
from fivebar_atlas.numerics.records import record_type

IndexArray = npt.NDArray[np.int64]

MAX_PANELS = 400
#: Orders of the Gauss rules along a ray; a piece takes the lowest that meets the tolerance.
#: With their Kronrod nodes and one more they fill whole SIMD registers.
ALONG_ORDERS = (7, 11, 15, 23, 31)
#: Columns of integrals: LCI, then areas and LCI for each threshold.
COLUMNS = 2 * MAX_THRESHOLDS + 1
#: Most cuts of a panel made at once; its parts are looked at again.
MAX_LEVEL_CUTS = 32
#: Most ends of pieces of one ray.
MAX_CUTS = MAX_STATIONARY + MAX_CROSSINGS * MAX_THRESHOLDS + MAX_ISOTROPIC + 2
#: A ray that passes an isotropic point within this share of its length is cut there,
NEAR_CONE = 0.05
#: unless it is cut at a stationary point that is as near in v.
CONE_APART = 0.02
#: Least shares of Kronrod minus Gauss that count as error: along rays; across rays, of
#: ∫ LCI dW; and of integrals over good-condition workspaces, whose level curves may turn
#: close to a panel's end.
ALONG_GAIN = 0.1
LCI_GAIN = 0.1
LEVEL_GAIN = 1.0


class Panels(Protocol):
    """Panels of one usable workspace and their integrals.

    Column 0 of ``value`` and ``error`` is ∫ LCI dW; columns 1 ... k are the areas with LCI at
    or above each of k thresholds; columns k + 1 ... 2k are ∫ LCI dW over those parts.

    Attributes
    ----------
    count, pending_count
        Number of panels and of those still to be looked at, shape (1,).
    start, end
        Angles, shape (MAX_PANELS,).
    strip
        Strip that each lies in, shape (MAX_PANELS,).
    value, error
        Integrals and absolute error estimates, shape (MAX_PANELS, COLUMNS).
    pending_start, pending_end, pending_strip
        Stack of panels still to be looked at, shape (MAX_PANELS,).
    total, total_error
        Sums over the panels, shape (COLUMNS,).
    gauss
        Sums with the embedded Gauss rule, of one panel, shape (COLUMNS,).
    row, row_error
        Integrals along one ray and their error estimates, shape (COLUMNS,).
    along_error
        Errors along the rays of one panel, shape (COLUMNS,).
    cuts
        Sorted cut positions of one ray, shape (cuts,).
    piece_level
        Level of the rule for each piece of a ray, shape (cuts,).
    level_cuts
        Angles at which to cut a panel, shape (MAX_LEVEL_CUTS,).
    isotropic_count
        Number of isotropic points, shape (1,).
    isotropic
        Isotropic points of the working mode, shape (MAX_ISOTROPIC, 2).
    saved_q
        Stationary values at the two ends of a bracket, shape (2, MAX_STATIONARY).
    rays
        The rays of one panel.
    along_count
        Number of nodes of the rules along rays, of growing order, shape (levels,).
    along_nodes, along_weights, along_gauss
        These rules, see :class:`quadrature.Rule`, shape (levels, nodes).
    across_nodes, across_weights, across_gauss
        The rule across rays, shape (ACROSS_NODES,).
    best
        The largest q seen on a ray, its angle, its distance, the neighbouring angles and
        the strip, shape (6,).
    """

    count: IndexArray
    pending_count: IndexArray
    start: FloatArray
    end: FloatArray
    strip: IndexArray
    value: FloatArray
    error: FloatArray
    pending_start: FloatArray
    pending_end: FloatArray
    pending_strip: IndexArray
    total: FloatArray
    total_error: FloatArray
    gauss: FloatArray
    row: FloatArray
    row_error: FloatArray
    along_error: FloatArray
    cuts: FloatArray
    piece_level: IndexArray
    level_cuts: FloatArray
    isotropic_count: IndexArray
    isotropic: FloatArray
    saved_q: FloatArray
    rays: Rays
    best: FloatArray
    along_count: IndexArray
    along_nodes: FloatArray
    along_weights: FloatArray
    along_gauss: FloatArray
    across_nodes: FloatArray
    across_weights: FloatArray
    across_gauss: FloatArray


PANELS = record_type(
    *((name, np.int64, (1,)) for name in ("count", "pending_count")),
    *((name, np.float64, (MAX_PANELS,)) for name in ("start", "end")),
    ("strip", np.int64, (MAX_PANELS,)),
    *((name, np.float64, (MAX_PANELS, COLUMNS)) for name in ("value", "error")),
    *((name, np.float64, (MAX_PANELS,)) for name in ("pending_start", "pending_end")),
    ("pending_strip", np.int64, (MAX_PANELS,)),
    *(
        (name, np.float64, (COLUMNS,))
        for name in ("total", "total_error", "gauss", "row", "row_error", "along_error")
    ),
    ("cuts", np.float64, (MAX_CUTS,)),
    ("piece_level", np.int64, (MAX_CUTS,)),
    ("level_cuts", np.float64, (MAX_LEVEL_CUTS,)),
    ("isotropic_count", np.int64, (1,)),
    ("isotropic", np.float64, (MAX_ISOTROPIC, 2)),
    ("saved_q", np.float64, (2, MAX_STATIONARY)),
    ("best", np.float64, (6,)),
    ("along_count", np.int64, (len(ALONG_ORDERS),)),
    *(
        (name, np.float64, (len(ALONG_ORDERS), 2 * max(ALONG_ORDERS) + 2))
        for name in ("along_nodes", "along_weights", "along_gauss")
    ),
    *(
        (name, np.float64, (ACROSS_NODES,))
        for name in ("across_nodes", "across_weights", "across_gauss")
    ),
    ("rays", RAYS, ()),
)


def set_rules(p: Panels) -> None:
    """Set the quadrature rules and sample positions of a new record."""
    for level, order in enumerate(ALONG_ORDERS):
        rule = clustered_gauss_kronrod(order)
        n = len(rule.nodes)
        # a node of no weight makes whole vectors of the 2 order + 1 nodes
        p.along_count[level] = n + 1
        p.along_nodes[level] = 0.5
        p.along_nodes[level, :n] = rule.nodes
        p.along_weights[level, :n] = rule.weights
        p.along_gauss[level, :n] = rule.gauss_weights
    across = clustered_gauss_kronrod(ACROSS_ORDER)
    p.across_nodes[:], p.across_weights[:], p.across_gauss[:] = across
    set_samples(p.rays)


@kernel
def _piece(
    r1: float, r2: float, r3: float, c: float, s: float, start: float, end: float,
    s1: float, s2: float,
    count: int, nodes: FloatArray, weights: FloatArray, gauss_weights: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Return the Kronrod and Gauss sums of ∫ LCI ρ dρ between two distances on a ray."""
    length = end - start
    kronrod, gauss = 0.0, 0.0
    for j in range(count):
        rho = start + length * nodes[j]
        f = rho * lci(r1, r2, r3, rho * c, rho * s, s1, s2)
        kronrod += weights[j] * f
        gauss += gauss_weights[j] * f
    return kronrod * length, gauss * length


@kernel
def _cut_ray(p: Panels, row: int, thresholds: int) -> int:
    """Put the ends of a ray's pieces into ``p.cuts``, sorted; return the number of pieces."""
    rays, cuts = p.rays, p.cuts
    cuts[0] = 0.0
    n = 1
    for j in range(rays.stationary_count[row]):
        cuts[n] = rays.stationary_v[row, j]
        n += 1
    for kind in range(thresholds):
        for j in range(rays.crossing_count[row, kind]):
            cuts[n] = rays.crossing_v[row, kind, j]
            n += 1
    low, length = rays.low[row], rays.length[row]
    for k in range(p.isotropic_count[0]):
        # a cone that the ray passes closely; where several are near each other, samples of q
        # may see one stationary point for all of them
        x, y = p.isotropic[k, 0], p.isotropic[k, 1]
        along = x * rays.c[row] + y * rays.s[row]
        across = y * rays.c[row] - x * rays.s[row]
        if abs(across) > NEAR_CONE * length or not low < along < low + length:
            continue
        v = cluster_inverse((along - low) / length)
        apart = True
        for j in range(rays.stationary_count[row]):
            apart = apart and abs(v - rays.stationary_v[row, j]) > CONE_APART
        if apart:
            cuts[n] = v
            n += 1
    for j in range(1, n):  # insertion sort of a few numbers
        v = cuts[j]
        k = j
        while k > 0 and cuts[k - 1] > v:
            cuts[k] = cuts[k - 1]
            k -= 1
        cuts[k] = v
    cuts[n] = 1.0
    return n


@kernel
def _integrate_piece(
    p: Panels, row: int, piece: int, level: int,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> tuple[float, float]:  # fmt: skip
    """Return ∫ LCI ρ dρ over a piece of a ray and its error estimate, by a level's rule."""
    rays = p.rays
    start = rays.low[row] + rays.length[row] * cluster(p.cuts[piece])
    end = rays.low[row] + rays.length[row] * cluster(p.cuts[piece + 1])
    if end <= start:
        return 0.0, 0.0
    kronrod, gauss = _piece(
        r1, r2, r3, rays.c[row], rays.s[row], start, end, s1, s2,
        p.along_count[level], p.along_nodes[level], p.along_weights[level], p.along_gauss[level],
    )  # fmt: skip
    return kronrod, kronrod_error(abs(kronrod - gauss), kronrod, ALONG_GAIN)


@kernel
def _integrate_ray(
    p: Panels, row: int, raised: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> None:  # fmt: skip
    """Integrate along one ray into ``p.row`` and ``p.row_error``.

    Every piece takes the level of its number in ``p.piece_level``, ``raised`` by so much.
    """
    rays = p.rays
    thresholds = len(ratios)
    pieces = _cut_ray(p, row, thresholds)
    c, s, low, length = rays.c[row], rays.s[row], rays.low[row], rays.length[row]
    p.row[:] = 0.0
    p.row_error[:] = 0.0
    for piece in range(pieces):
        level = min(p.piece_level[piece] + raised, len(ALONG_ORDERS) - 1)
        kronrod, error = _integrate_piece(p, row, piece, level, r1, r2, r3, s1, s2)
        p.row[0] += kronrod
        p.row_error[0] += error
        if thresholds > 0:
            start = low + length * cluster(p.cuts[piece])
            end = low + length * cluster(p.cuts[piece + 1])
            middle = 0.5 * (start + end)
            q = conditioning_ratio(r1, r2, r3, middle * c, middle * s, s1, s2)
            for kind in range(thresholds):
                if q >= ratios[kind]:
                    p.row[1 + kind] += middle * (end - start)
                    p.row[1 + thresholds + kind] += kronrod
                    p.row_error[1 + thresholds + kind] += error


@kernel
def choose_levels(
    p: Panels, share: float, thresholds: int,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> None:  # fmt: skip
    """Set in ``p.piece_level`` the levels that the pieces of a panel's middle ray need.

    The panels are cut so that their rays have, almost always, the same pieces.
    """
    row = ACROSS_NODES // 2
    pieces = _cut_ray(p, row, thresholds)
    total = 0.0
    for piece in range(pieces):
        total += _integrate_piece(p, row, piece, 0, r1, r2, r3, s1, s2)[0]
    p.piece_level[:] = 0
    for piece in range(pieces):
        level = 0
        while level < len(ALONG_ORDERS) - 1:
            _, error = _integrate_piece(p, row, piece, level, r1, r2, r3, s1, s2)
            if error * pieces <= share * total:
                break
            level += 1
        p.piece_level[piece] = level


@kernel
def integrate_panel(
    p: Panels, panel: int, raised: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> float:  # fmt: skip
    """Integrate over a panel whose rays are in ``p.rays``; set its value and error.

    Returns the share of the error of ∫ LCI dW that comes from along the rays, relative to
    the integral: higher levels of the rules lower it, halving the panel does not.
    """
    columns = 2 * len(ratios) + 1
    width = p.end[panel] - p.start[panel]
    weights, gauss_weights = p.across_weights, p.across_gauss
    value, gauss = p.value[panel], p.gauss
    value[:] = 0.0
    gauss[:] = 0.0
    p.along_error[:] = 0.0
    for row in range(ACROSS_NODES):
        _integrate_ray(p, row, raised, ratios, r1, r2, r3, s1, s2)
        for m in range(columns):
            value[m] += weights[row] * p.row[m]
            gauss[m] += gauss_weights[row] * p.row[m]
            p.along_error[m] += weights[row] * p.row_error[m]
    along: float = p.along_error[0] / (value[0] + 1e-300)
    for m in range(columns):
        gain = LCI_GAIN if m == 0 else LEVEL_GAIN
        error = kronrod_error(abs(value[m] - gauss[m]), value[m], gain) + p.along_error[m]
        p.error[panel, m] = (error + 1e-15 * abs(value[m])) * width
        value[m] *= width
    return along
