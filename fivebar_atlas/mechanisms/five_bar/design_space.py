"""The design space of the symmetric five-bar: lattice, triangulation, sub-regions, chart.

Designs are triples (r1, r2, r3) with r1 + r2 + r3 = 3 (Liu, Wang and Zheng 2006,
Eqs. 28-32). Lattice designs are triples (i, j, k) of integers with i + j + k = N, and
whatever has to be decided about them is decided in those integers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.charts import ChartAxis, ChartRegion, ChartTick, DesignChart
from fivebar_atlas.mechanisms.quantities import Flags

#: Designs whose base joints are surrounded by workspace, and all that can be assembled.
SURROUNDED = "surrounded"
ASSEMBLABLE = "assemblable"
SPACES = (SURROUNDED, ASSEMBLABLE)

#: Codes of the sub-regions of the surrounded space.
SUB_REGIONS = Flags(values=(0, 1, 2, 3, 4), meanings=("outside", "IVa", "Va", "Vb", "IVb"))
OUTSIDE, IVA, VA, VB, IVB = SUB_REGIONS.values

#: Relative slack within which a design given in floating point lies on a border.
BORDER_SLACK = 1e-12

#: Range of the dimensional factor D; areas, which scale with its square, stay finite.
FACTOR_RANGE = (1e-100, 1e100)

_SQRT3 = math.sqrt(3.0)

# Corners of the two spaces as (r1, r2, r3), counter-clockwise in the chart.
_CORNERS: dict[str, FloatArray] = {
    SURROUNDED: np.array([[0.0, 3.0, 0.0], [3.0, 0.0, 0.0], [1.0, 1.0, 1.0]]),
    ASSEMBLABLE: np.array([[0.0, 3.0, 0.0], [3.0, 0.0, 0.0], [1.5, 0.0, 1.5], [0.0, 1.5, 1.5]]),
}

# Borders between sub-regions as coefficients c of c . (r1, r2, r3) = 0.
_BORDERS: dict[str, tuple[tuple[float, float, float], ...]] = {
    SURROUNDED: (
        (1.0, -1.0, 0.0),  # r1 = r2
        (1.0, -1.0, 1.0),  # r2 = r1 + r3
        (1.0, -1.0, -1.0),  # r1 = r2 + r3
    ),
    ASSEMBLABLE: (
        (1.0, -1.0, 0.0),
        (1.0, -1.0, 1.0),
        (1.0, -1.0, -1.0),
        (1.0, 0.0, -1.0),  # r1 = r3
        (0.0, 1.0, -1.0),  # r2 = r3
    ),
}

# Triangles that the borders cut the surrounded space into; names stand at the centroids.
_REGION_CORNERS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "IVa": ((0.0, 3.0, 0.0), (1.5, 1.5, 0.0), (0.75, 1.5, 0.75)),
    "Va": ((1.5, 1.5, 0.0), (1.0, 1.0, 1.0), (0.75, 1.5, 0.75)),
    "Vb": ((1.5, 1.5, 0.0), (1.5, 0.75, 0.75), (1.0, 1.0, 1.0)),
    "IVb": ((3.0, 0.0, 0.0), (1.5, 0.75, 0.75), (1.5, 1.5, 0.0)),
}


def check_space(space: str) -> None:
    """Raise UnknownNameError unless there is a design space of this name."""
    if space not in SPACES:
        raise UnknownNameError("space", space, SPACES)


def rows(space: str, resolution: int) -> IntArray:
    """Return the rows of the lattice: for each k the least and the greatest i.

    Parameters
    ----------
    space
        ``"surrounded"`` (i >= k and j >= k) or ``"assemblable"`` (2 k <= N).
    resolution
        N, the sum of i, j and k.

    Returns
    -------
    ndarray
        Shape (rows, 2); row k holds the designs with r3 = 3 k / N. In both spaces i >= 1
        and j >= 1. No row is empty.

    Raises
    ------
    UnknownNameError
        If there is no such space.
    """
    check_space(space)
    k = np.arange(resolution // 2 + 1, dtype=np.int64)
    least = np.maximum(1, k) if space == SURROUNDED else np.ones_like(k)
    # j has the same least value as i, so i is at most N - k - least.
    greatest = resolution - k - least
    kept = greatest >= least
    return np.column_stack([least[kept], greatest[kept]])


def lattice_triples(space: str, resolution: int) -> IntArray:
    """Return the integer triples of the lattice.

    Parameters
    ----------
    space
        Name of the design space.
    resolution
        Number of lattice steps N.

    Returns
    -------
    ndarray
        Triples (i, j, k), shape (designs, 3), ordered by k and then by i, both rising.

    Raises
    ------
    UnknownNameError
        If there is no such space.
    """
    bounds = rows(space, resolution)
    counts = bounds[:, 1] - bounds[:, 0] + 1
    k = np.repeat(np.arange(len(bounds), dtype=np.int64), counts)
    first = np.repeat(np.cumsum(counts) - counts, counts)
    i = bounds[k, 0] + np.arange(len(k), dtype=np.int64) - first
    return np.column_stack([i, resolution - i - k, k])


def lattice(space: str, resolution: int) -> FloatArray:
    """Return the designs of the lattice, (i, j, k) * 3 / N.

    Parameters
    ----------
    space
        Name of the design space.
    resolution
        Number of lattice steps N.

    Returns
    -------
    ndarray
        Designs (r1, r2, r3), shape (designs, 3), in the order of :func:`lattice_triples`.
        Each length is the double nearest to its exact value.

    Raises
    ------
    UnknownNameError
        If there is no such space.
    """
    return 3 * lattice_triples(space, resolution) / float(resolution)


def triangles(space: str, resolution: int) -> IntArray:
    """Return a triangulation of the lattice that fills the convex hull of its designs.

    Between two neighbouring rows lie lattice triangles. The borders r1 = r3 and r2 = r3
    run through lattice designs but cut lattice triangles; there, the designs of the lower
    row are joined to the first (last) design of the upper one. What remains of the design
    space holds no lattice design: strips narrower than one step at r1 = 0 and r2 = 0, and
    at the top where N is not divisible by 3 (surrounded) or 2 (assemblable).

    Parameters
    ----------
    space
        Name of the design space.
    resolution
        Number of lattice steps N.

    Returns
    -------
    ndarray
        Indices into the lattice, shape (triangles, 3), counter-clockwise in the chart.

    Raises
    ------
    UnknownNameError
        If there is no such space.
    """
    bounds = rows(space, resolution)
    counts = bounds[:, 1] - bounds[:, 0] + 1
    # Index of a design: offsets[k] + i.
    offsets = np.cumsum(counts) - counts - bounds[:, 0]
    parts: list[IntArray] = []
    for k in range(len(bounds) - 1):
        least, greatest = (int(bound) for bound in bounds[k])
        upper_least, upper_greatest = (int(bound) for bound in bounds[k + 1])
        # Lower edges (i, i + 1) and the upper design each of them is joined to.
        i = np.arange(least, greatest, dtype=np.int64)
        apex = np.clip(i, upper_least, upper_greatest)
        lower = offsets[k] + i
        parts.append(np.column_stack([lower, lower + 1, offsets[k + 1] + apex]))
        # Upper edges (i, i + 1) and the lower design between them.
        i = np.arange(upper_least, upper_greatest, dtype=np.int64)
        upper = offsets[k + 1] + i
        parts.append(np.column_stack([offsets[k] + i + 1, upper + 1, upper]))
    return np.concatenate(parts) if parts else np.empty((0, 3), dtype=np.int64)


def sub_region(lengths: npt.NDArray[Any]) -> npt.NDArray[np.int8]:
    """Return the sub-region of the surrounded space that each design lies in.

    Parameters
    ----------
    lengths
        Lengths (r1, r2, r3) to any common scale, shape (..., 3). Integers are compared
        exactly; floating-point lengths with a slack of 1e-12 of their sum, far below the
        step of any lattice, so that both decide a lattice design alike.

    Returns
    -------
    ndarray
        Codes of ``SUB_REGIONS``, shape (...): IVa r2 > r1 + r3, Va r1 <= r2 <= r1 + r3,
        Vb r2 < r1 <= r2 + r3, IVb r1 > r2 + r3; outside where r1 < r3 or r2 < r3. A
        design on r3 = 0 and r1 = r2 belongs to Va.

    Notes
    -----
    Liu, Wang and Zheng 2006, Section 5 and Fig. 2(b).
    """
    r1, r2, r3 = lengths[..., 0], lengths[..., 1], lengths[..., 2]
    exact = np.issubdtype(lengths.dtype, np.integer)
    slack = 0 if exact else BORDER_SLACK * (r1 + r2 + r3)
    conditions = [
        (r3 - r1 > slack) | (r3 - r2 > slack),
        r2 - (r1 + r3) > slack,
        r1 - (r2 + r3) > slack,
        r1 - r2 > slack,
    ]
    return np.select(conditions, [OUTSIDE, IVA, IVB, VB], default=VA).astype(np.int8)


def normalise(lengths: Sequence[float]) -> tuple[FloatArray, float]:
    """Scale the lengths of one machine to a design.

    Parameters
    ----------
    lengths
        R1, R2, R3, in any unit of length.

    Returns
    -------
    design : ndarray
        r_j = R_j / D, shape (3,) (Liu, Wang and Zheng 2006, Eqs. 28 and 29).
    factor : float
        D = (R1 + R2 + R3) / 3, in the unit of the lengths; exactly 1, and the lengths
        unchanged, where they sum to 3 within rounding.

    Raises
    ------
    InputError
        If a length is not finite, R1 or R2 is not positive, R3 is negative, the three
        cannot be assembled (R3 > R1 + R2), or D is so large or small that areas overflow.
    """
    r1, r2, r3 = (float(length) for length in lengths)
    for name, value in (("R1", r1), ("R2", r2)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "a finite length above 0")
    if not (math.isfinite(r3) and r3 >= 0.0):
        raise InputError("R3", r3, "a finite length of at least 0")
    factor = (r1 + r2 + r3) / 3.0
    least, greatest = FACTOR_RANGE
    if not least <= factor <= greatest:
        raise InputError(
            "R1 R2 R3", (r1, r2, r3), f"lengths with a mean from {least:g} to {greatest:g}"
        )
    if r3 - (r1 + r2) > BORDER_SLACK * 3.0 * factor:
        raise InputError(
            "R1 R2 R3", (r1, r2, r3), "lengths that can be assembled: R3 at most R1 + R2"
        )
    if abs(factor - 1.0) <= 4.0 * np.finfo(np.float64).eps:
        return np.array([r1, r2, r3]), 1.0
    # Adding 0.0 turns -0.0, which is an ordinary zero here, into 0.0.
    return np.array([r1, r2, r3]) / factor + 0.0, factor


def project(designs: FloatArray) -> FloatArray:
    """Return where designs lie in the planar-closed drawing of the design space.

    Parameters
    ----------
    designs
        Designs (r1, r2, r3), shape (..., 3).

    Returns
    -------
    ndarray
        x = (2 r1 + r3) / sqrt(3), y = r3, shape (..., 2): equilateral, so that the
        distance to a side of the triangle r1 + r2 + r3 = 3 is the parameter itself.
    """
    r1, r3 = designs[..., 0], designs[..., 2]
    return np.stack([(2.0 * r1 + r3) / _SQRT3, r3], axis=-1)


def unproject(points: FloatArray) -> FloatArray:
    """Return the designs at places in the planar-closed drawing of the design space.

    Parameters
    ----------
    points
        Chart coordinates, shape (..., 2).

    Returns
    -------
    ndarray
        Designs (r1, r2, r3) with sum 3, shape (..., 3). A length that is zero but for
        rounding is zero, and one that equals r3 but for rounding is r3: what lies on a
        border, where some workspaces are others than beside it, stays there.
    """
    slack = 3.0 * BORDER_SLACK
    r3 = np.where(np.abs(points[..., 1]) <= slack, 0.0, points[..., 1])
    r1 = (_SQRT3 * points[..., 0] - r3) / 2.0
    r1 = np.where(np.abs(r1) <= slack, 0.0, np.where(np.abs(r1 - r3) <= slack, r3, r1))
    r2 = 3.0 - r1 - r3
    r2 = np.where(np.abs(r2) <= slack, 0.0, r2)
    on_right = np.abs(r2 - r3) <= slack
    return np.stack([np.where(on_right, 3.0 - 2.0 * r3, r1), np.where(on_right, r3, r2), r3], -1)


def chart(space: str) -> DesignChart:
    """Return how a design space is drawn: outline, axes, borders and sub-region names.

    The r1 axis runs along the bottom, the r2 axis along the left side (and, in the
    assemblable space, on along the top), the r3 axis along the right side. Each tick
    points along the line on which its parameter is constant, so the line is found by
    extending the tick into the drawing.

    Parameters
    ----------
    space
        Name of the design space.

    Raises
    ------
    UnknownNameError
        If there is no such space.
    """
    check_space(space)
    regions = tuple(
        ChartRegion(name, *(float(value) for value in project(np.array(corners)).mean(axis=0)))
        for name, corners in _REGION_CORNERS.items()
    )
    return DesignChart(
        outline=project(_CORNERS[space]),
        axes=_chart_axes(space),
        borders=tuple(project(_clip(np.array(form), _CORNERS[space])) for form in _BORDERS[space]),
        regions=regions,
    )


def _clip(form: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the two ends of the line form . r = 0 in a convex polygon, shape (2, 3)."""
    ends: list[FloatArray] = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        at_start, at_end = float(form @ start), float(form @ end)
        if at_start == 0.0:
            ends.append(start)
        elif at_start * at_end < 0.0:
            share = at_start / (at_start - at_end)
            ends.append(start + share * (end - start))
    return np.array(ends)


def _ticks(
    parameter: int, values: Sequence[float], start: FloatArray, end: FloatArray, angle: float
) -> tuple[ChartTick, ...]:
    """Return ticks at values of one parameter along a side, pointing outward at an angle."""
    ticks = []
    for value in values:
        share = (value - start[parameter]) / (end[parameter] - start[parameter])
        x, y = project(start + share * (end - start))
        ticks.append(
            ChartTick(
                label=f"{value:g}",
                x=float(x),
                y=float(y),
                dx=math.cos(math.radians(angle)),
                dy=math.sin(math.radians(angle)),
            )
        )
    return tuple(ticks)


def _label(symbol: str, start: FloatArray, end: FloatArray, offset: float) -> dict[str, Any]:
    """Return label, place and rotation of an axis label, outside a side by an offset.

    The side runs with the drawing on its left; the text reads from left to right.
    """
    foot, head = project(start), project(end)
    along = (head - foot) / np.hypot(*(head - foot))
    place = (foot + head) / 2.0 + offset * np.array([along[1], -along[0]])
    rotation = math.degrees(math.atan2(along[1], along[0]))
    if abs(rotation) > 90.0:
        rotation -= math.copysign(180.0, rotation)
    return {
        "label": symbol,
        "label_x": float(place[0]),
        "label_y": float(place[1]),
        "rotation": rotation,
    }


def _chart_axes(space: str) -> tuple[ChartAxis, ...]:
    """Return the r1, r2 and r3 axes of a chart."""
    corners = _CORNERS[space]
    left, right, last = corners[0], corners[1], corners[-1]
    bottom = ChartAxis(
        **_label("$r_1$", left, right, 0.30),
        ticks=_ticks(0, (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0), left, right, -120.0),
    )
    if space == SURROUNDED:
        r2_ticks = _ticks(1, (1.0, 1.5, 2.0, 2.5, 3.0), last, left, 120.0)
        r3_ticks = _ticks(2, (0.0, 0.2, 0.4, 0.6, 0.8, 1.0), right, last, 0.0)
    else:
        r2_ticks = _ticks(1, (2.0, 2.5, 3.0), last, left, 120.0) + _ticks(
            1, (0.0, 0.5, 1.0, 1.5), corners[2], last, 120.0
        )
        r3_ticks = _ticks(2, (0.0, 0.5, 1.0, 1.5), right, corners[2], 0.0)
    r2_axis = ChartAxis(**_label("$r_2$", last, left, 0.30), ticks=r2_ticks)
    r3_axis = ChartAxis(**_label("$r_3$", right, corners[2], 0.30), ticks=r3_ticks)
    return bottom, r2_axis, r3_axis
