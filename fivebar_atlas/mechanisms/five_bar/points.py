"""Kinematics, Jacobian matrices and LCI at many points: thin loops over the scalar kernels.

All arrays are one-dimensional and of one length. Points beyond reach get NaN.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.five_bar.jacobian import lci, matrices
from fivebar_atlas.mechanisms.five_bar.kinematics import elbow, forward, inverse, reaches
from fivebar_atlas.mechanisms.five_bar.singularity import radius_along, singularity_kind
from fivebar_atlas.mechanisms.five_bar.workspace import Decomposition, contains

BoolArray = npt.NDArray[np.bool_]


@kernel
def inverse_at(
    r1: float, r2: float, r3: float, x: FloatArray, y: FloatArray, s1: float, s2: float,
    theta1: FloatArray, theta2: FloatArray,
) -> None:  # fmt: skip
    """Fill in the input angles at points."""
    for k in range(len(x)):
        theta1[k] = theta2[k] = math.nan
        if reaches(r1, r2, r3, x[k], y[k]):
            theta1[k], theta2[k] = inverse(r1, r2, r3, x[k], y[k], s1, s2)


@kernel
def elbows_at(
    r1: float, r2: float, r3: float, x: FloatArray, y: FloatArray, s1: float, s2: float,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill in B1 and B2 at points, ``out`` of shape (n, 4)."""
    for k in range(len(x)):
        out[k] = math.nan
        if reaches(r1, r2, r3, x[k], y[k]):
            out[k, 0], out[k, 1] = elbow(r1, r2, -r3, x[k], y[k], s1)
            out[k, 2], out[k, 3] = elbow(r1, r2, r3, x[k], y[k], s2)


@kernel
def forward_at(
    r1: float, r2: float, r3: float, theta1: FloatArray, theta2: FloatArray, assembly: float,
    x: FloatArray, y: FloatArray,
) -> None:  # fmt: skip
    """Fill in P for input angles; NaN where the linkage cannot be assembled."""
    for k in range(len(x)):
        x[k], y[k], possible = forward(r1, r2, r3, theta1[k], theta2[k], assembly)
        if not possible:
            x[k] = y[k] = math.nan


@kernel
def matrices_at(
    r1: float, r2: float, r3: float, x: FloatArray, y: FloatArray, s1: float, s2: float,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill in A11, A22, B11, B12, B21, B22 at points, ``out`` of shape (n, 6)."""
    for k in range(len(x)):
        out[k] = math.nan
        if reaches(r1, r2, r3, x[k], y[k]):
            entries = matrices(r1, r2, r3, x[k], y[k], s1, s2)
            out[k, 0], out[k, 1] = entries[0], entries[1]
            out[k, 2], out[k, 3] = entries[2], entries[3]
            out[k, 4], out[k, 5] = entries[4], entries[5]


@kernel
def lci_at(
    r1: float, r2: float, r3: float, x: FloatArray, y: FloatArray, s1: float, s2: float,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill in LCI at points. A first pass vectorises; a second marks what is out of reach."""
    for k in range(len(x)):
        out[k] = lci(r1, r2, r3, x[k], y[k], s1, s2)
    for k in range(len(x)):
        if not reaches(r1, r2, r3, x[k], y[k]):
            out[k] = math.nan


@kernel
def singularity_at(
    r1: float, r2: float, r3: float, x: FloatArray, y: FloatArray, s1: float, s2: float,
    tolerance: float, out: IntArray,
) -> None:  # fmt: skip
    """Fill in the kinds of singularity at points, -1 beyond reach."""
    for k in range(len(x)):
        out[k] = -1
        if reaches(r1, r2, r3, x[k], y[k]):
            out[k] = singularity_kind(r1, r2, r3, x[k], y[k], s1, s2, tolerance)


@kernel
def radii_along(
    curve: int, r1: float, r2: float, r3: float, phi: FloatArray, out: FloatArray
) -> None:
    """Fill in the distances at which rays meet a curve that exists there."""
    for k in range(len(phi)):
        out[k] = radius_along(curve, r1, r2, r3, math.cos(phi[k]), math.sin(phi[k]))


@kernel
def lci_inside_at(
    d: Decomposition, strips: int, r1: float, r2: float, r3: float,
    x: FloatArray, y: FloatArray, s1: float, s2: float, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in LCI at points of a usable workspace, 0 elsewhere.

    Points are those of the decomposed range: of its right half where the strips are that.
    """
    for k in range(len(x)):
        phi = math.atan2(y[k], x[k])
        if phi < -0.5 * math.pi:
            phi += 2.0 * math.pi
        out[k] = 0.0
        if contains(d, r1, r2, r3, strips, phi, math.sqrt(x[k] * x[k] + y[k] * y[k])):
            out[k] = lci(r1, r2, r3, x[k], y[k], s1, s2)


@kernel
def contained_at(
    d: Decomposition, strips: int, r1: float, r2: float, r3: float,
    x: FloatArray, y: FloatArray, out: BoolArray,
) -> None:  # fmt: skip
    """Tell which points of the decomposed range lie in a usable workspace."""
    for k in range(len(x)):
        phi = math.atan2(y[k], x[k])
        if phi < -0.5 * math.pi:
            phi += 2.0 * math.pi
        rho = math.sqrt(x[k] * x[k] + y[k] * y[k])
        out[k] = contains(d, r1, r2, r3, strips, phi, rho)
