"""What LCI does along rays from the origin: its stationary points and level crossings.

Rays are kept in rows of arrays, many at a time. Whatever costs square roots and divisions
is evaluated in plain loops over arrays of points, which LLVM vectorises; the bookkeeping of
the brackets runs between them.

A position on a ray is v in [0, 1], with ρ = ρ_low + (ρ_high - ρ_low)(3 v² - 2 v³): in v
everything is analytic up to serial singularities. Thresholds are given as ratios q = T/S
(:func:`jacobian.threshold_ratio`); q is smooth and grows with LCI.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.jacobian import (
    conditioning_ratio,
    conditioning_with_slope,
)
from fivebar_atlas.mechanisms.five_bar.singularity import ORIGIN, radius_along
from fivebar_atlas.numerics.quadrature import cluster, cluster_slope
from fivebar_atlas.numerics.records import record_type
from fivebar_atlas.numerics.roots import FOUND, first_share, next_share

IndexArray = npt.NDArray[np.int64]

#: Positions at which a ray is sampled to find stationary points.
SAMPLES = 16
#: Order of the Gauss rule across the rays of a panel, and number of its Kronrod nodes.
ACROSS_ORDER = 7
ACROSS_NODES = 2 * ACROSS_ORDER + 1
#: Rays of a panel, and a spare one for single rays.
ROWS = ACROSS_NODES + 1
#: Most thresholds treated together.
MAX_THRESHOLDS = 16
#: Most stationary points kept on a ray; more than five have not been seen.
MAX_STATIONARY = 8
#: Most crossings of one threshold kept on a ray.
MAX_CROSSINGS = MAX_STATIONARY + 2
#: A stationary point is found when its bracket in v is this short: q is then exact.
STATIONARY_TOLERANCE = 1e-7
#: A crossing is found when its bracket in v is this short.
CROSSING_TOLERANCE = 1e-12
#: Points are evaluated in multiples of this; what lies beyond the last one is not used.
LANES = 8
#: No root takes as many steps; Chandrupatla's rule needs about six.
MAX_STEPS = 60


class Brackets(Protocol):
    """Brackets being narrowed, structure of arrays, each of shape (brackets,).

    Attributes
    ----------
    row, kind, slot
        Ray, threshold and place among its crossings that the root belongs to.
    x1, f1, x2, f2
        Points and values as in :func:`roots.next_share`.
    trial
        Position v where the function is evaluated next.
    c, s, rho
        The same point in polar form.
    q, value
        q and the function value at the trial points.
    """

    row: IndexArray
    kind: IndexArray
    slot: IndexArray
    x1: FloatArray
    f1: FloatArray
    x2: FloatArray
    f2: FloatArray
    trial: FloatArray
    c: FloatArray
    s: FloatArray
    rho: FloatArray
    q: FloatArray
    value: FloatArray


class Rays(Protocol):
    """Rays of one panel, one a row; the last row is spare, for single rays.

    Attributes
    ----------
    phi, c, s
        Angle, cosine, sine, shape (ROWS,).
    low, length
        Distance where the ray enters the strip and the length inside, shape (ROWS,).
    sample_v
        Positions where q and its slope are sampled, shape (SAMPLES,).
    sample_q, sample_slope
        q and dq/dv there, shape (ROWS, SAMPLES).
    sample_c, sample_s, sample_rho
        Points of one ray's samples, shape (SAMPLES,).
    stationary_count
        Number of stationary points of q, shape (ROWS,).
    stationary_sample
        The sample just before each, shape (ROWS, MAX_STATIONARY).
    stationary_v, stationary_q
        Their positions and values, shape (ROWS, MAX_STATIONARY).
    crossing_count
        Number of crossings of each threshold, shape (ROWS, MAX_THRESHOLDS).
    crossing_v
        Their positions, shape (ROWS, MAX_THRESHOLDS, MAX_CROSSINGS).
    brackets
        Work space.
    """

    phi: FloatArray
    c: FloatArray
    s: FloatArray
    low: FloatArray
    length: FloatArray
    sample_v: FloatArray
    sample_q: FloatArray
    sample_slope: FloatArray
    sample_c: FloatArray
    sample_s: FloatArray
    sample_rho: FloatArray
    stationary_count: IndexArray
    stationary_sample: IndexArray
    stationary_v: FloatArray
    stationary_q: FloatArray
    crossing_count: IndexArray
    crossing_v: FloatArray
    brackets: Brackets


_ROOM = ROWS * MAX_CROSSINGS * MAX_THRESHOLDS  # a multiple of LANES
BRACKETS = record_type(
    *((name, np.int64, (_ROOM,)) for name in ("row", "kind", "slot")),
    *(
        (name, np.float64, (_ROOM,))
        for name in ("x1", "f1", "x2", "f2", "trial", "c", "s", "rho", "q", "value")
    ),
)
RAYS = record_type(
    *((name, np.float64, (ROWS,)) for name in ("phi", "c", "s", "low", "length")),
    ("sample_v", np.float64, (SAMPLES,)),
    ("sample_q", np.float64, (ROWS, SAMPLES)),
    ("sample_slope", np.float64, (ROWS, SAMPLES)),
    *((name, np.float64, (SAMPLES,)) for name in ("sample_c", "sample_s", "sample_rho")),
    ("stationary_count", np.int64, (ROWS,)),
    ("stationary_sample", np.int64, (ROWS, MAX_STATIONARY)),
    ("stationary_v", np.float64, (ROWS, MAX_STATIONARY)),
    ("stationary_q", np.float64, (ROWS, MAX_STATIONARY)),
    ("crossing_count", np.int64, (ROWS, MAX_THRESHOLDS)),
    ("crossing_v", np.float64, (ROWS, MAX_THRESHOLDS, MAX_CROSSINGS)),
    ("brackets", BRACKETS, ()),
)


def set_samples(rays: Rays) -> None:
    """Set the sample positions: Chebyshev points in v.

    The map from v to ρ gathers them once more at the ends.
    """
    rays.sample_v[:] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(SAMPLES) + 0.5) / SAMPLES)


@kernel
def place_ray(
    rays: Rays, row: int, phi: float, lower: int, upper: int, r1: float, r2: float, r3: float
) -> None:
    """Put the ray at angle φ, between two curves, into a row."""
    c, s = math.cos(phi), math.sin(phi)
    low = radius_along(lower, r1, r2, r3, c, s)
    rays.phi[row] = phi
    rays.c[row] = c
    rays.s[row] = s
    rays.low[row] = low
    rays.length[row] = max(radius_along(upper, r1, r2, r3, c, s) - low, 0.0)


@kernel
def _ratios_at(
    c: FloatArray, s: FloatArray, rho: FloatArray, out: FloatArray, count: int,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> None:  # fmt: skip
    """Evaluate q at ``count`` points given in polar form, in whole SIMD registers."""
    for k in range((count + LANES - 1) // LANES * LANES):
        out[k] = conditioning_ratio(r1, r2, r3, rho[k] * c[k], rho[k] * s[k], s1, s2)


@kernel
def _slopes_at(
    c: FloatArray, s: FloatArray, rho: FloatArray, q: FloatArray, slope: FloatArray, count: int,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> None:  # fmt: skip
    """Evaluate q and dq/dρ at ``count`` points, in whole SIMD registers."""
    for k in range((count + LANES - 1) // LANES * LANES):
        q[k], slope[k] = conditioning_with_slope(
            r1, r2, r3, rho[k] * c[k], rho[k] * s[k], c[k], s[k], s1, s2, assembly
        )


@kernel
def _hidden_turn(v0: float, q0: float, g0: float, v1: float, q1: float, g1: float) -> float:
    """Return where q may turn twice between two samples with slopes of one sign, or NaN.

    The slope of the cubic through both values and slopes is a parabola; where it comes
    below a quarter of the lesser end slope, its lowest place is returned.
    """
    h = v1 - v0
    sign = 1.0 if g0 > 0.0 else -1.0
    g0, g1, rise = sign * g0, sign * g1, sign * (q1 - q0) / h
    bend = 3.0 * (g0 + g1 - 2.0 * rise)
    if bend <= 0.0:
        return math.nan
    t = (2.0 * g0 + g1 - 3.0 * rise) / bend
    if not 0.0 < t < 1.0 or g0 - bend * t * t > 0.25 * min(g0, g1):
        return math.nan
    return v0 + t * h


@kernel
def _open_bracket(
    b: Brackets, k: int, row: int, kind: int, slot: int,
    x1: float, f1: float, x2: float, f2: float,
) -> int:  # fmt: skip
    """Enter a bracket and its first trial point; return the number of brackets."""
    b.row[k] = row
    b.kind[k] = kind
    b.slot[k] = slot
    b.x1[k], b.f1[k] = x1, f1
    b.x2[k], b.f2[k] = x2, f2
    b.trial[k] = x1 + first_share(f1, f2) * (x2 - x1)
    return k + 1


@kernel
def _place_trials(rays: Rays, count: int) -> None:
    """Turn the trial positions v into points."""
    b = rays.brackets
    for k in range(count):
        row = b.row[k]
        b.c[k] = rays.c[row]
        b.s[k] = rays.s[row]
        b.rho[k] = rays.low[row] + rays.length[row] * cluster(b.trial[k])


@kernel
def _narrow(b: Brackets, k: int, f: float, tolerance: float) -> float:
    """Take in the value at bracket k's trial point; return the next share or FOUND."""
    x = b.trial[k]
    if (f > 0.0) == (b.f1[k] > 0.0):
        x3, f3 = b.x1[k], b.f1[k]
    else:
        x3, f3 = b.x2[k], b.f2[k]
        b.x2[k], b.f2[k] = b.x1[k], b.f1[k]
    b.x1[k], b.f1[k] = x, f
    return next_share(x, f, b.x2[k], b.f2[k], x3, f3, tolerance)


@kernel
def _keep(b: Brackets, k: int, kept: int, trial: float) -> int:
    """Move bracket k to place ``kept`` with its next trial point."""
    b.row[kept], b.kind[kept], b.slot[kept] = b.row[k], b.kind[k], b.slot[k]
    b.x1[kept], b.f1[kept] = b.x1[k], b.f1[k]
    b.x2[kept], b.f2[kept] = b.x2[k], b.f2[k]
    b.trial[kept] = trial
    return kept + 1


@kernel
def find_stationary_points(
    rays: Rays, first: int, last: int,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> None:  # fmt: skip
    """Find the stationary points of q on the rays of rows first ... last - 1.

    q and its slope are sampled along each ray; every change of the slope's sign is narrowed
    to a point. Where two may hide between samples, one more sample decides.
    """
    b = rays.brackets
    count = 0
    for row in range(first, last):
        length = rays.length[row]
        for j in range(SAMPLES):
            rays.sample_c[j] = rays.c[row]
            rays.sample_s[j] = rays.s[row]
            rays.sample_rho[j] = rays.low[row] + length * cluster(rays.sample_v[j])
        slope, q = rays.sample_slope[row], rays.sample_q[row]
        _slopes_at(
            rays.sample_c, rays.sample_s, rays.sample_rho, q, slope, SAMPLES,
            r1, r2, r3, s1, s2, assembly,
        )  # fmt: skip
        for j in range(SAMPLES):  # dq/dv
            slope[j] *= length * cluster_slope(rays.sample_v[j])
        found = 0
        for j in range(SAMPLES - 1):
            if found > MAX_STATIONARY - 2:
                break
            v0, v1 = rays.sample_v[j], rays.sample_v[j + 1]
            if (slope[j] > 0.0) != (slope[j + 1] > 0.0):
                rays.stationary_sample[row, found] = j
                count = _open_bracket(b, count, row, 0, found, v0, slope[j], v1, slope[j + 1])
                found += 1
                continue
            v = _hidden_turn(v0, q[j], slope[j], v1, q[j + 1], slope[j + 1])
            if math.isnan(v):
                continue
            rho = rays.low[row] + length * cluster(v)
            _, g = conditioning_with_slope(
                r1, r2, r3, rho * rays.c[row], rho * rays.s[row], rays.c[row], rays.s[row],
                s1, s2, assembly,
            )  # fmt: skip
            if (g > 0.0) != (slope[j] > 0.0):
                g *= length * cluster_slope(v)
                rays.stationary_sample[row, found] = j
                rays.stationary_sample[row, found + 1] = j
                count = _open_bracket(b, count, row, 0, found, v0, slope[j], v, g)
                count = _open_bracket(b, count, row, 0, found + 1, v, g, v1, slope[j + 1])
                found += 2
        rays.stationary_count[row] = found
    for _ in range(MAX_STEPS):
        if count == 0:
            break
        _place_trials(rays, count)
        _slopes_at(b.c, b.s, b.rho, b.q, b.value, count, r1, r2, r3, s1, s2, assembly)
        kept = 0
        for k in range(count):
            row, v = b.row[k], b.trial[k]
            f = b.value[k] * rays.length[row] * cluster_slope(v)
            share = _narrow(b, k, f, STATIONARY_TOLERANCE)
            if share == FOUND:
                rays.stationary_v[row, b.slot[k]] = v
                rays.stationary_q[row, b.slot[k]] = b.q[k]
            else:
                kept = _keep(b, k, kept, v + share * (b.x2[k] - v))
        count = kept


@kernel
def find_crossings(
    rays: Rays, first: int, last: int, lower: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float,
) -> None:  # fmt: skip
    """Find where q crosses each threshold ratio on the rays of rows first ... last - 1.

    The samples and the stationary points between them, which must have been found, bracket
    the crossings.
    """
    b = rays.brackets
    count = 0
    # q is zero on every boundary arc, but the origin may lie inside the workspace
    q_start = conditioning_ratio(r1, r2, r3, 0.0, 0.0, s1, s2) if lower == ORIGIN else 0.0
    for row in range(first, last):
        stationary = rays.stationary_count[row]
        for kind in range(len(ratios)):
            found, turn = 0, 0
            v0, f0 = 0.0, q_start - ratios[kind]
            j = 0
            while j <= SAMPLES:
                if turn < stationary and rays.stationary_sample[row, turn] < j:
                    v1 = rays.stationary_v[row, turn]
                    f1 = rays.stationary_q[row, turn] - ratios[kind]
                    turn += 1
                elif j < SAMPLES:
                    v1, f1 = rays.sample_v[j], rays.sample_q[row, j] - ratios[kind]
                    j += 1
                else:
                    v1, f1 = 1.0, -ratios[kind]
                    j += 1
                if (f0 > 0.0) != (f1 > 0.0) and found < MAX_CROSSINGS:
                    count = _open_bracket(b, count, row, kind, found, v0, f0, v1, f1)
                    found += 1
                v0, f0 = v1, f1
            rays.crossing_count[row, kind] = found
    for _ in range(MAX_STEPS):
        if count == 0:
            break
        _place_trials(rays, count)
        _ratios_at(b.c, b.s, b.rho, b.value, count, r1, r2, r3, s1, s2)
        kept = 0
        for k in range(count):
            share = _narrow(b, k, b.value[k] - ratios[b.kind[k]], CROSSING_TOLERANCE)
            if share == FOUND:
                rays.crossing_v[b.row[k], b.kind[k], b.slot[k]] = b.x1[k]
            else:
                kept = _keep(b, k, kept, b.x1[k] + share * (b.x2[k] - b.x1[k]))
        count = kept


@kernel
def scan_rays(
    rays: Rays, first: int, last: int, lower: int, ratios: FloatArray,
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
) -> None:  # fmt: skip
    """Find stationary points and crossings on the placed rays of rows first ... last - 1."""
    find_stationary_points(rays, first, last, r1, r2, r3, s1, s2, assembly)
    find_crossings(rays, first, last, lower, ratios, r1, r2, r3, s1, s2)


@kernel
def highest_on_ray(rays: Rays, row: int) -> tuple[float, float]:
    """Return the largest stationary q of a ray and its distance ρ; (0, low) if there is none."""
    best, v = 0.0, 0.0
    for j in range(rays.stationary_count[row]):
        if rays.stationary_q[row, j] > best:
            best, v = rays.stationary_q[row, j], rays.stationary_v[row, j]
    return best, rays.low[row] + rays.length[row] * cluster(v)
