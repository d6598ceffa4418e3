"""Gauss-Kronrod rules and the variable change that clusters their nodes at both ends.

The rules are made here in NumPy and handed to the kernels as arguments.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from fivebar_atlas.jit import kernel

FloatArray = npt.NDArray[np.float64]


class Rule(NamedTuple):
    """A Gauss-Kronrod pair on [0, 1].

    Attributes
    ----------
    nodes
        Nodes in (0, 1), ascending, shape (n,).
    weights
        Kronrod weights, sum 1, shape (n,).
    gauss_weights
        Weights of the embedded Gauss rule, zero at the nodes that it lacks, shape (n,).
    """

    nodes: FloatArray
    weights: FloatArray
    gauss_weights: FloatArray


def _stieltjes_roots(n: int) -> FloatArray:
    """Return the n + 1 nodes that Kronrod adds to the n Gauss nodes on [-1, 1].

    They are the roots of the Stieltjes polynomial E of degree n + 1, defined by
    ∫ P_n P_j E dx = 0 for j = 0 ... n. Its Legendre coefficients solve a linear system whose
    entries ∫ P_n P_j P_k dx a Gauss rule gives exactly.
    """
    x, w = legendre.leggauss(2 * n + 2)
    values = legendre.legvander(x, n + 1)
    triple = np.einsum("q,qj,qk->jk", w * values[:, n], values[:, : n + 1], values)
    # the highest coefficient is one; only j = 0 ... n with k = 0 ... n + 1 - parity matter
    coefficients, *_ = np.linalg.lstsq(triple[:, : n + 1], -triple[:, n + 1], rcond=None)
    series = np.concatenate((coefficients, [1.0]))
    roots = np.sort(legendre.legroots(series).real)
    for _ in range(2):  # Newton, to the last digits
        roots -= legendre.legval(roots, series) / legendre.legval(roots, legendre.legder(series))
    return 0.5 * (roots - roots[::-1])


@functools.cache
def gauss_kronrod(n: int) -> Rule:
    """Return the (n, 2n + 1) Gauss-Kronrod pair on [0, 1].

    Parameters
    ----------
    n
        Number of nodes of the Gauss rule, at least 2.
    """
    gauss_nodes, gauss_weights = legendre.leggauss(n)
    nodes = np.empty(2 * n + 1)
    nodes[1::2], nodes[::2] = gauss_nodes, _stieltjes_roots(n)
    moments = np.zeros(2 * n + 1)
    moments[0] = 2.0
    weights = np.linalg.solve(legendre.legvander(nodes, 2 * n).T, moments)
    embedded = np.zeros(2 * n + 1)
    embedded[1::2] = gauss_weights
    return Rule(0.5 * (1.0 + nodes), 0.25 * (weights + weights[::-1]), 0.5 * embedded)


@functools.cache
def null_rules(n: int, count: int) -> FloatArray:
    """Return sums of node values that vanish for all polynomials but those of the highest degrees.

    The difference of a Gauss-Kronrod pair with 2n + 1 nodes is the one that vanishes for degrees
    below 2n. These are the next ones: row k vanishes for degrees below 2n - 1 - k. What is not
    smooth may have a small difference by chance, but not small values of all (Berntsen and
    Espelid 1991).

    Parameters
    ----------
    n
        Number of nodes of the Gauss rule.
    count
        Number of rules.

    Returns
    -------
    ndarray
        Shape (count, 2n + 1). Squares of the weights add up to the same as those of the difference.
    """
    rule = gauss_kronrod(n)
    values = legendre.legvander(2.0 * rule.nodes - 1.0, 2 * n)
    orthonormal, _ = np.linalg.qr(values)
    size = np.linalg.norm(rule.weights - rule.gauss_weights)
    return np.asarray(size * orthonormal[:, 2 * n - 1 : 2 * n - 1 - count : -1].T)


@functools.cache
def clustered_gauss_kronrod(n: int) -> Rule:
    """Return the Gauss-Kronrod pair under the variable change of :func:`cluster`.

    It integrates functions that behave like a square root at either end as well as the
    plain rule integrates smooth ones.
    """
    rule = gauss_kronrod(n)
    slope = 6.0 * rule.nodes * (1.0 - rule.nodes)
    nodes = rule.nodes**2 * (3.0 - 2.0 * rule.nodes)
    return Rule(nodes, rule.weights * slope, rule.gauss_weights * slope)


@kernel
def cluster(v: float) -> float:
    """Map [0, 1] onto itself with vanishing slope at both ends: 3 v² - 2 v³.

    A square root at an end becomes linear there, and nodes gather at the ends.
    """
    return v * v * (3.0 - 2.0 * v)


@kernel
def cluster_inverse(t: float) -> float:
    """Return v in [0, 1] with 3 v² - 2 v³ = t, by the trigonometric formula for cubics."""
    return 0.5 - math.sin(math.asin(min(max(1.0 - 2.0 * t, -1.0), 1.0)) / 3.0)


@kernel
def cluster_slope(v: float) -> float:
    """Return the derivative 6 v (1 - v) of :func:`cluster`."""
    return 6.0 * v * (1.0 - v)


@kernel
def kronrod_error(difference: float, scale: float, least_gain: float) -> float:
    """Return the error estimate of a Kronrod sum from its distance to the Gauss sum.

    Where both converge geometrically the Kronrod error is about the 3/2 power of the
    difference. That is used with a factor of 20 in hand, and only down to ``least_gain``
    times the difference, because convergence is algebraic at weak singularities.

    Parameters
    ----------
    difference
        Absolute difference of the two sums.
    scale
        Size of the integral (its absolute value or more).
    least_gain
        Smallest share of the difference that is returned; 1 for the difference itself.
    """
    if difference == 0.0 or scale <= 0.0:
        return difference
    gain = 20.0 * math.sqrt(difference / scale)
    return difference * min(1.0, max(least_gain, gain))
