"""The design space of the pentapod: its lattice, triangulation and chart.

Designs are pairs (r_a, r_b), the radii of base and platform in units of the home height H (Wang
et al. 2017, Sec. 4, varies these two).
"""

from __future__ import annotations

import numpy as np

from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.charts import ChartAxis, ChartTick, DesignChart

#: Name of the only design space.
RADII = "radii"
#: Range of both radii, in units of H.
LEAST, GREATEST = 0.1, 2.1

_TICKS = (0.1, 0.6, 1.1, 1.6, 2.1)
# How far axis labels stand from the chart: below, and left of it, where ticks are wider than high.
_BELOW, _LEFT = 0.27, 0.36


def lattice(resolution: int) -> FloatArray:
    """Return every design of the lattice.

    Parameters
    ----------
    resolution
        Number of steps N from 0.1 to 2.1 along both axes.

    Returns
    -------
    ndarray
        Designs (r_a, r_b), shape ((N + 1)², 2), by r_b and then by r_a, both rising. Each is the
        double nearest to its exact value.
    """
    radii = (resolution + 20 * np.arange(resolution + 1, dtype=np.int64)) / float(10 * resolution)
    r_b, r_a = (each.ravel() for each in np.meshgrid(radii, radii, indexing="ij"))
    return np.column_stack([r_a, r_b])


def triangles(resolution: int) -> IntArray:
    """Return a triangulation of the lattice.

    Returns
    -------
    ndarray
        Indices into the lattice, shape (2 N², 3), counter-clockwise in the chart. Diagonals run
        along r_a - r_b = const., as the crease of most indices next to r_a = r_b does.
    """
    row = np.arange(resolution, dtype=np.int64)
    corner = (row[:, None] * (resolution + 1) + row).ravel()
    above = corner + resolution + 1
    return np.concatenate(
        [
            np.column_stack([corner, corner + 1, above + 1]),
            np.column_stack([corner, above + 1, above]),
        ]
    )


def chart() -> DesignChart:
    """Return how the design space is drawn: a square, with the line r_a = r_b."""
    middle = 0.5 * (LEAST + GREATEST)
    bottom = ChartAxis(
        "$r_a$",
        middle,
        LEAST - _BELOW,
        0.0,
        tuple(ChartTick(f"{value:g}", value, LEAST, 0.0, -1.0) for value in _TICKS),
    )
    left = ChartAxis(
        "$r_b$",
        LEAST - _LEFT,
        middle,
        90.0,
        tuple(ChartTick(f"{value:g}", LEAST, value, -1.0, 0.0) for value in _TICKS),
    )
    outline = np.array([[LEAST, LEAST], [GREATEST, LEAST], [GREATEST, GREATEST], [LEAST, GREATEST]])
    equal = np.array([[LEAST, LEAST], [GREATEST, GREATEST]])
    return DesignChart(outline, (bottom, left), (equal,), ())
