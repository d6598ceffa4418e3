"""Least and greatest eigenvalue of symmetric 6 x 6 matrices, many at once, for kernels.

Householder's reflections make the matrices tridiagonal, and Laguerre's iteration goes from
bounds of the spectrum to its ends: monotonically, since all zeros of the characteristic
polynomial are real, and with cubic order where they are simple (Wilkinson, The Algebraic
Eigenvalue Problem, Oxford 1965, ch. 5 and 7). Every step is a loop over matrices, which
vectorises.

Errors are of the order of 1e-15 times the greatest eigenvalue. Of the square root of a least
eigenvalue, a share s of that of the greatest, the relative error is thus of the order of
1e-15 / s².
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.numerics.records import record_type

#: Matrices treated together.
LANES = 64
#: Order of the matrices.
ORDER = 6

# Laguerre's steps at most; where zeros are double each takes away three quarters of the error.
_STEPS = 30
# Where a step is less than this share of the one before, order three makes the next one rounding.
_CUBIC = 1e-4
# Share of the trace below which a step is rounding.
_ROUNDING = 1e-15

#: Work space: matrices in ``matrix`` (lower triangle, overwritten), results in ``least`` and
#: ``greatest``.
EIGENVALUES = record_type(
    ("matrix", np.float64, (ORDER, ORDER, LANES)),
    ("vector", np.float64, (ORDER, LANES)),
    ("product", np.float64, (ORDER, LANES)),
    ("factor", np.float64, (LANES,)),
    ("main_diagonal", np.float64, (ORDER, LANES)),
    ("off_diagonal", np.float64, (ORDER, LANES)),
    ("least", np.float64, (LANES,)),
    ("greatest", np.float64, (LANES,)),
)

Eigenvalues = Any


@kernel
def reduce_to_tridiagonal(w: Eigenvalues) -> None:
    """Make the matrices tridiagonal; ``off_diagonal`` receives the squares of its entries."""
    a, v, p, f = w.matrix, w.vector, w.product, w.factor
    for c in range(ORDER - 2):
        for k in range(LANES):
            f[k] = 0.0
        for i in range(c + 1, ORDER):
            for k in range(LANES):
                v[i, k] = a[i, c, k]
                f[k] += v[i, k] * v[i, k]
        for k in range(LANES):
            w.off_diagonal[c, k] = f[k]
            first = v[c + 1, k]
            v[c + 1, k] = first + math.copysign(math.sqrt(f[k]), first)
            # half of v·v; nothing is to be done where the column is 0
            half = f[k] + abs(first) * math.sqrt(f[k])
            f[k] = 1.0 / half if half > 0.0 else 0.0
        for i in range(c + 1, ORDER):
            for k in range(LANES):
                p[i, k] = 0.0
            for j in range(c + 1, ORDER):
                row, column = max(i, j), min(i, j)
                for k in range(LANES):
                    p[i, k] += a[row, column, k] * v[j, k]
        for k in range(LANES):
            total = 0.0
            for i in range(c + 1, ORDER):
                total += p[i, k] * v[i, k]
            w.least[k] = 0.5 * f[k] * total
        for i in range(c + 1, ORDER):
            for k in range(LANES):
                p[i, k] = f[k] * (p[i, k] - w.least[k] * v[i, k])
        for i in range(c + 1, ORDER):
            for j in range(c + 1, i + 1):
                for k in range(LANES):
                    a[i, j, k] -= v[i, k] * p[j, k] + p[i, k] * v[j, k]
    for i in range(ORDER):
        for k in range(LANES):
            w.main_diagonal[i, k] = a[i, i, k]
    for k in range(LANES):
        w.off_diagonal[ORDER - 2, k] = a[ORDER - 1, ORDER - 2, k] ** 2
        w.off_diagonal[ORDER - 1, k] = 0.0


@kernel
def laguerre_step(
    x: float, side: float, d0: float, d1: float, d2: float, d3: float, d4: float, d5: float,
    e0: float, e1: float, e2: float, e3: float, e4: float,
) -> float:  # fmt: skip
    """Return how far Laguerre's step goes from x, a bound of the spectrum, towards it.

    Parameters
    ----------
    x
        A bound of the spectrum.
    side
        1 for a bound below, -1 for one above.
    d0, d1, d2, d3, d4, d5
        Diagonal.
    e0, e1, e2, e3, e4
        Squares of the entries next to it.

    Returns
    -------
    float
        The length of the step; 0 where x is an eigenvalue, or between two by rounding: from there
        steps would lead away.
    """
    # p_k = (d_k - x) p_(k-1) - e_(k-1) p_(k-2), its derivative f and half of its second one s
    p0, f0, s0 = 1.0, 0.0, 0.0
    p1, f1, s1 = d0 - x, -1.0, 0.0
    g = d1 - x
    p2, f2, s2 = g * p1 - e0 * p0, g * f1 - p1 - e0 * f0, g * s1 - f1 - e0 * s0
    g = d2 - x
    p3, f3, s3 = g * p2 - e1 * p1, g * f2 - p2 - e1 * f1, g * s2 - f2 - e1 * s1
    g = d3 - x
    p4, f4, s4 = g * p3 - e2 * p2, g * f3 - p3 - e2 * f2, g * s3 - f3 - e2 * s2
    g = d4 - x
    p5, f5, s5 = g * p4 - e3 * p3, g * f4 - p4 - e3 * f3, g * s4 - f4 - e3 * s3
    g = d5 - x
    p6, f6, s6 = g * p5 - e4 * p4, g * f5 - p5 - e4 * f4, g * s5 - f5 - e4 * s4
    radicand = 5.0 * (5.0 * f6 * f6 - 12.0 * p6 * s6)
    below = abs(f6) + math.sqrt(max(radicand, 0.0))
    return 6.0 * p6 / below if p6 > 0.0 and side * f6 < 0.0 else 0.0


@kernel
def find_extreme_eigenvalues(w: Eigenvalues, count: int) -> None:
    """Find the ends of the spectra of the first ``count`` positive semidefinite matrices.

    Parameters
    ----------
    w
        Work space with the matrices; receives ``least`` and ``greatest``. A lane does not depend
        on the other lanes but for the number of steps, and not on lanes from ``count`` on.
    count
        How many lanes hold matrices, at most LANES.
    """
    reduce_to_tridiagonal(w)
    d, e = w.main_diagonal, w.off_diagonal
    for k in range(LANES):
        trace = d[0, k] + d[1, k] + d[2, k] + d[3, k] + d[4, k] + d[5, k]
        squares = 2.0 * (e[0, k] + e[1, k] + e[2, k] + e[3, k] + e[4, k])
        for i in range(ORDER):
            squares += d[i, k] * d[i, k]
        # Samuelson's bound of the greatest of numbers by their sum and that of their squares
        excess = max(squares - trace * trace / 6.0, 0.0)
        w.least[k] = 0.0
        w.greatest[k] = (trace / 6.0 + math.sqrt(5.0 / 6.0 * excess)) * (1.0 + _ROUNDING)
        w.factor[k] = _ROUNDING * trace
    for side in range(2):
        x = w.least if side == 0 else w.greatest
        sign = 1.0 if side == 0 else -1.0
        step, before = w.product[0], w.product[1]
        for k in range(LANES):
            before[k] = 0.0
        for _ in range(_STEPS):
            for k in range(LANES):
                step[k] = laguerre_step(
                    x[k], sign, d[0, k], d[1, k], d[2, k], d[3, k], d[4, k], d[5, k],
                    e[0, k], e[1, k], e[2, k], e[3, k], e[4, k],
                )  # fmt: skip
                x[k] += sign * step[k]
            moved = False
            for k in range(count):
                moved |= step[k] > max(_CUBIC * before[k], w.factor[k])
                before[k] = step[k]
            if not moved:
                break
