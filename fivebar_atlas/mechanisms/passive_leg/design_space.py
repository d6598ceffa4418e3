"""The design spaces of the manipulator with a passive leg: lattices, triangulations, charts.

Designs are triples (r, l_a, l_b) with R = 1 (Nam and Park 2006, Eq. 32). The conditioned space has
l_a = l_b - R + r, for which the third singularity is at the origin alone (Sec. 5.2); r and l_b are
free in [0.5, 2]. A slice of the free space fixes one of the three, the other two are free in
[0.5, 2].
"""

from __future__ import annotations

import re

import numpy as np

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.charts import ChartAxis, ChartRegion, ChartTick, DesignChart

#: The space under the condition l_a = l_b - R + r.
CONDITIONED = "conditioned"
#: Names and symbols of the parameters.
NAMES = ("r", "l_a", "l_b")
SYMBOLS = ("$r$", "$l_a$", "$l_b$")
#: How slices of the free space are written.
SLICES = tuple(f"{name}=VALUE" for name in NAMES)
#: Range of every free parameter, in lengths of R.
LEAST, GREATEST = 0.5, 2.0

_SLICE = re.compile(rf"({'|'.join(NAMES)})\s*=\s*(.+)")
_TICKS = (0.5, 1.0, 1.5, 2.0)
# How far tick labels and axis labels stand from the chart.
_AXIS_OFFSET = 0.2


def parse_space(text: str, name: str = "space") -> str:
    """Return the canonical text of a design space: ``"conditioned"`` or ``"l_a=0.8"``.

    Raises
    ------
    UnknownNameError
        If it is neither the conditioned space nor a slice.
    InputError
        If the parameter of a slice is not in its range.
    """
    text = text.strip()
    if text == CONDITIONED:
        return text
    found = _SLICE.fullmatch(text)
    if found is None:
        raise UnknownNameError(name, text, (CONDITIONED, *SLICES))
    allowed = f"a slice at a value from {LEAST:g} to {GREATEST:g}, such as {found[1]}=1.2"
    try:
        value = float(found[2])
    except ValueError:
        raise InputError(name, text, allowed) from None
    if not LEAST <= value <= GREATEST:
        raise InputError(name, text, allowed)
    return f"{found[1]}={value!r}"


def fixed_parameter(space: str) -> tuple[int, float] | None:
    """Return number and value of the parameter that a slice fixes, None for no slice."""
    if space == CONDITIONED:
        return None
    name, _, value = space.partition("=")
    return NAMES.index(name), float(value)


def free_parameters(space: str) -> tuple[int, int]:
    """Return the numbers of the parameters on the axes of the chart."""
    fixed = fixed_parameter(space)
    if fixed is None:
        return NAMES.index("r"), NAMES.index("l_b")
    first, second = (number for number in range(len(NAMES)) if number != fixed[0])
    return first, second


def _grid(space: str, resolution: int) -> IntArray:
    """Return the steps (i, j) of every design of the lattice, j by j, shape (designs, 2)."""
    steps = np.arange(resolution + 1, dtype=np.int64)
    j, i = (each.ravel() for each in np.meshgrid(steps, steps, indexing="ij"))
    # in the conditioned space l_a = 0 in the corner r = l_b = 0.5
    exists = i + j > 0 if space == CONDITIONED else np.ones(len(i), dtype=np.bool_)
    return np.column_stack([i[exists], j[exists]])


def lattice(space: str, resolution: int) -> FloatArray:
    """Return every design of the lattice.

    Parameters
    ----------
    space
        Canonical text of the design space.
    resolution
        Number of steps N from 0.5 to 2 along both axes of the chart.

    Returns
    -------
    ndarray
        Designs (r, l_a, l_b), shape (designs, 3), by the second axis of the chart and then by
        the first, both rising: (N + 1)² of them, but for the corner of the conditioned space,
        where l_a = 0. Each length is the double nearest to its exact value.
    """
    grid = _grid(space, resolution)
    free = (resolution + 3 * grid) / float(2 * resolution)
    if space == CONDITIONED:
        l_a = 3 * grid.sum(axis=1) / float(2 * resolution)
        return np.column_stack([free[:, 0], l_a, free[:, 1]])
    return unproject(free, space)


def triangles(space: str, resolution: int) -> IntArray:
    """Return a triangulation of the lattice.

    Returns
    -------
    ndarray
        Indices into the lattice, shape (triangles, 3), counter-clockwise in the chart.
    """
    row = np.arange(resolution, dtype=np.int64)
    corner = (row[:, None] * (resolution + 1) + row).ravel()
    above = corner + resolution + 1
    # the diagonals run along l_a = const. of the conditioned space
    halves = [
        np.column_stack([corner, corner + 1, above]),
        np.column_stack([corner + 1, above + 1, above]),
    ]
    found = np.concatenate(halves)
    if space == CONDITIONED:
        found = found[found.min(axis=1) > 0] - 1
    return found


def project(designs: FloatArray, space: str) -> FloatArray:
    """Return the two free parameters of designs, shape (n, 2)."""
    return designs[:, list(free_parameters(space))]


def unproject(points: FloatArray, space: str) -> FloatArray:
    """Return the designs at values of the two free parameters, shape (n, 3)."""
    fixed = fixed_parameter(space)
    if fixed is not None:
        return np.insert(points, fixed[0], fixed[1], axis=1)
    r, l_b = points[:, 0], points[:, 1]
    return np.column_stack([r, (r - 1.0) + l_b, l_b])


def chart(space: str) -> DesignChart:
    """Return how a design space is drawn: a square, with the line r = R where it has one."""
    middle = 0.5 * (LEAST + GREATEST)
    columns = free_parameters(space)
    bottom = ChartAxis(
        SYMBOLS[columns[0]],
        middle,
        LEAST - _AXIS_OFFSET,
        0.0,
        tuple(ChartTick(f"{value:g}", value, LEAST, 0.0, -1.0) for value in _TICKS),
    )
    left = ChartAxis(
        SYMBOLS[columns[1]],
        LEAST - _AXIS_OFFSET,
        middle,
        90.0,
        tuple(ChartTick(f"{value:g}", LEAST, value, -1.0, 0.0) for value in _TICKS),
    )
    borders: tuple[FloatArray, ...] = ()
    regions: tuple[ChartRegion, ...] = ()
    if columns[0] == NAMES.index("r"):
        borders = (np.array([[1.0, LEAST], [1.0, GREATEST]]),)
        regions = (
            ChartRegion("$r < R$", 0.5 * (LEAST + 1.0), middle),
            ChartRegion("$r > R$", 0.5 * (GREATEST + 1.0), middle),
        )
    outline = np.array([[LEAST, LEAST], [GREATEST, LEAST], [GREATEST, GREATEST], [LEAST, GREATEST]])
    slice_of = fixed_parameter(space)
    fixed = "" if slice_of is None else f"{SYMBOLS[slice_of[0]]} = {slice_of[1]:.10g}"
    return DesignChart(outline, (bottom, left), borders, regions, fixed)
