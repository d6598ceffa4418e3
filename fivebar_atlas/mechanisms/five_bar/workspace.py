"""Theoretical and usable workspace of the symmetric 5R manipulator (Liu et al. 2006, Sec. 7).

The usable workspace of a working and an assembly mode is the connected component of
largest area of {interior of the theoretical workspace, det B of the right sign}. It is
found exactly, as a cylindrical decomposition in polar coordinates: between neighbouring
critical angles the curves of :mod:`singularity` cut every ray in the same order, so a
sector falls into *cells* between two named curves. Cells of neighbouring sectors are
joined where they share part of their common ray. Cells in a row between the same two
curves make a *strip*; the strips are what areas and indices are integrated over, and their
lower and upper curves are the boundary arcs.

Symmetry about the y axis ("+-", "-+"): only the right half, φ from -π/2 to π/2, is
decomposed. Otherwise φ runs from -π/2 to 3π/2.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.jit import kernel
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.jacobian import signed_det_b
from fivebar_atlas.mechanisms.five_bar.singularity import (
    C_1I_FAR,
    C_1O,
    C_2O,
    COUPLER_MINUS,
    CURVES,
    FOLD_UP_FAR,
    LEAST_SECTOR,
    MAX_CRITICAL,
    ORIGIN,
    belongs_to_mode,
    critical_angles,
    exists,
    radius_along,
    swept_area,
)
from fivebar_atlas.numerics.arcs import lens_area
from fivebar_atlas.numerics.records import record_type

IndexArray = npt.NDArray[np.int64]

#: Cells or necks narrower than this (lengths sum to 3) are rounding, not workspace.
LEAST_WIDTH = 1e-10
#: Inner reach circles smaller than this are points, the base joints.
POINT_RADIUS = 1e-9
#: Bases shorter than this are none: with them det B of "++" is nothing but rounding.
LEAST_BASE = 1e-12
MAX_CELLS = 8 * MAX_CRITICAL
#: Rounding of a closed-form area, relative to the number of arcs times (r1 + r2)²: each
#: is a difference of terms that large, however small it is itself.
AREA_ROUNDING = 1e-15


class Decomposition(Protocol):
    """The cells of one design and mode pair, and the strips of its usable workspace.

    Attributes
    ----------
    angles
        Critical angles, ends of the sectors, shape (MAX_CRITICAL,).
    turn
        Angle between the first and the last ray, π or 2π, shape (1,).
    first
        Index of the first cell of each sector, shape (MAX_CRITICAL + 1,).
    lower, upper
        Curves below and above each cell, shape (MAX_CELLS,).
    component
        First cell of the connected component that a cell belongs to, shape (MAX_CELLS,).
    area
        Area of the component, kept at its first cell, shape (MAX_CELLS,).
    strip_from, strip_to
        Angles where each strip of the usable workspace begins and ends, shape (MAX_CELLS,).
    strip_lower, strip_upper
        Curves below and above each strip, shape (MAX_CELLS,).
    sorted_radius, sorted_curve
        Work space of one ray, shape (CURVES,).
    """

    angles: FloatArray
    turn: FloatArray
    first: IndexArray
    lower: IndexArray
    upper: IndexArray
    component: IndexArray
    area: FloatArray
    strip_from: FloatArray
    strip_to: FloatArray
    strip_lower: IndexArray
    strip_upper: IndexArray
    sorted_radius: FloatArray
    sorted_curve: IndexArray


DECOMPOSITION = record_type(
    ("angles", np.float64, (MAX_CRITICAL,)),
    ("turn", np.float64, (1,)),
    ("first", np.int64, (MAX_CRITICAL + 1,)),
    ("lower", np.int64, (MAX_CELLS,)),
    ("upper", np.int64, (MAX_CELLS,)),
    ("component", np.int64, (MAX_CELLS,)),
    ("area", np.float64, (MAX_CELLS,)),
    ("strip_from", np.float64, (MAX_CELLS,)),
    ("strip_to", np.float64, (MAX_CELLS,)),
    ("strip_lower", np.int64, (MAX_CELLS,)),
    ("strip_upper", np.int64, (MAX_CELLS,)),
    ("sorted_radius", np.float64, (CURVES,)),
    ("sorted_curve", np.int64, (CURVES,)),
)


@kernel
def theoretical_area(r1: float, r2: float, r3: float) -> float:
    """Return the area of {|r1 - r2| ≤ |P - A_i| ≤ r1 + r2 for both legs}, by closed form.

    Inclusion and exclusion of discs; each inner disc lies in its own outer one, so no more
    than two discs ever matter together.
    """
    outer, inner, base = r1 + r2, abs(r1 - r2), 2.0 * r3
    return (
        lens_area(outer, outer, base)
        - 2.0 * lens_area(inner, outer, base)
        + lens_area(inner, inner, base)
    )


@kernel
def _insert(d: Decomposition, count: int, radius: float, curve: int) -> int:
    """Insert a crossing into the sorted crossings of a ray; return their number."""
    k = count
    while k > 0 and d.sorted_radius[k - 1] > radius:
        d.sorted_radius[k] = d.sorted_radius[k - 1]
        d.sorted_curve[k] = d.sorted_curve[k - 1]
        k -= 1
    d.sorted_radius[k] = radius
    d.sorted_curve[k] = curve
    return count + 1


@kernel
def _cells_along(
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float,
    phi: float, count: int, d: Decomposition,
) -> int:  # fmt: skip
    """Append the cells that a ray in the middle of a sector meets; return the cell count."""
    c, s = math.cos(phi), math.sin(phi)
    end_1 = radius_along(C_1O, r1, r2, r3, c, s)
    end_2 = radius_along(C_2O, r1, r2, r3, c, s)
    end = min(end_1, end_2)
    crossings = _insert(d, 0, 0.0, ORIGIN)
    crossings = _insert(d, crossings, end, C_1O if end_1 <= end_2 else C_2O)
    for curve in range(C_1I_FAR, COUPLER_MINUS + 1):
        if exists(curve, r1, r2, r3, c, s) and (
            curve < FOLD_UP_FAR or belongs_to_mode(curve, r1, r2, r3, c, s, s1, s2)
        ):
            radius = radius_along(curve, r1, r2, r3, c, s)
            if radius < end:
                crossings = _insert(d, crossings, radius, curve)
    inner2 = (r1 - r2) * (r1 - r2)
    for k in range(crossings - 1):
        low, high = d.sorted_radius[k], d.sorted_radius[k + 1]
        if high - low < 1e-13 or high > end:
            continue
        middle = 0.5 * (low + high)
        x, y = middle * c, middle * s
        y2 = y * y
        if (x + r3) * (x + r3) + y2 < inner2 or (x - r3) * (x - r3) + y2 < inner2:
            continue
        if assembly * signed_det_b(r1, r2, r3, x, y, s1, s2) > 0.0:
            d.lower[count] = d.sorted_curve[k]
            d.upper[count] = d.sorted_curve[k + 1]
            d.component[count] = count
            count += 1
    return count


@kernel
def _root(d: Decomposition, cell: int) -> int:
    """Return the first cell of a cell's component."""
    while d.component[cell] != cell:
        cell = d.component[cell]
    return cell


@kernel
def _shared_width(
    d: Decomposition, r1: float, r2: float, r3: float, phi: float, cell: int, other: int
) -> float:
    """Return the length that two cells have in common on the ray between them."""
    c, s = math.cos(phi), math.sin(phi)
    low = max(
        radius_along(d.lower[cell], r1, r2, r3, c, s),
        radius_along(d.lower[other], r1, r2, r3, c, s),
    )
    high = min(
        radius_along(d.upper[cell], r1, r2, r3, c, s),
        radius_along(d.upper[other], r1, r2, r3, c, s),
    )
    return high - low


@kernel
def _join_across(
    d: Decomposition, r1: float, r2: float, r3: float, phi: float,
    from_0: int, to_0: int, from_1: int, to_1: int,
) -> None:  # fmt: skip
    """Join the cells of two neighbouring sectors that share part of their common ray."""
    for cell in range(from_0, to_0):
        for other in range(from_1, to_1):
            if _shared_width(d, r1, r2, r3, phi, cell, other) > LEAST_WIDTH:
                a, b = _root(d, cell), _root(d, other)
                d.component[max(a, b)] = min(a, b)


@kernel
def decompose(
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float, d: Decomposition
) -> int:
    """Cut the workspace of a mode pair into cells and join them to components.

    Parameters
    ----------
    r1, r2, r3
        Non-dimensional lengths (sum 3; the tolerances are absolute).
    s1, s2, assembly
        Working and assembly mode as ±1.
    d
        Receives angles, turn, first, lower, upper and component.

    Returns
    -------
    int
        Number of sectors.
    """
    symmetric = s1 != s2
    least = -0.5 * math.pi
    greatest = 0.5 * math.pi if symmetric else 1.5 * math.pi
    d.turn[0] = greatest - least
    sectors = critical_angles(r1, r2, r3, least, greatest, d.angles) - 1
    count = 0
    for k in range(sectors):
        d.first[k] = count
        middle = 0.5 * (d.angles[k] + d.angles[k + 1])
        count = _cells_along(r1, r2, r3, s1, s2, assembly, middle, count, d)
    d.first[sectors] = count
    for k in range(1, sectors):
        _join_across(
            d, r1, r2, r3, d.angles[k], d.first[k - 1], d.first[k], d.first[k], d.first[k + 1]
        )
    if not symmetric:
        last = sectors - 1
        _join_across(d, r1, r2, r3, least, d.first[last], d.first[sectors], d.first[0], d.first[1])
    for cell in range(count):
        d.component[cell] = _root(d, cell)
    return sectors


@kernel
def is_degenerate(r1: float, r2: float, r3: float, s1: float, s2: float) -> bool:
    """Tell whether a design has no workspace to speak of in a working mode.

    Only a point can be reached, or B1 = B2 for every P and det B vanishes identically.
    """
    return r1 + r2 <= r3 or (r3 <= LEAST_BASE and s1 == s2)


@kernel
def touches_axis(
    d: Decomposition, r1: float, r2: float, r3: float, sectors: int, component: int
) -> bool:
    """Tell whether a component of a decomposed right half borders on the y axis."""
    for end in range(2):
        sector = 0 if end == 0 else sectors - 1
        phi = d.angles[0] if end == 0 else d.angles[sectors]
        for cell in range(d.first[sector], d.first[sector + 1]):
            if (
                d.component[cell] == component
                and _shared_width(d, r1, r2, r3, phi, cell, cell) > LEAST_WIDTH
            ):
                return True
    return False


@kernel
def largest_component(
    d: Decomposition, r1: float, r2: float, r3: float, symmetric: bool, sectors: int
) -> tuple[int, float]:
    """Return the component of largest area and its multiplicity (2 if it crosses the axis).

    A component of the right half that touches the y axis is half of a symmetric one; one
    that does not is one of a mirrored pair, of which the right one stands for both.
    Returns (-1, 0) where there is no cell.
    """
    count = d.first[sectors]
    for cell in range(count):
        d.area[cell] = 0.0
    for k in range(sectors):
        for cell in range(d.first[k], d.first[k + 1]):
            d.area[d.component[cell]] += swept_area(
                d.upper[cell], r1, r2, r3, d.angles[k], d.angles[k + 1]
            ) - swept_area(d.lower[cell], r1, r2, r3, d.angles[k], d.angles[k + 1])
    best, best_area, best_copies = -1, 0.0, 0.0
    for cell in range(count):
        if d.component[cell] == cell:
            copies = 2.0 if symmetric and touches_axis(d, r1, r2, r3, sectors, cell) else 1.0
            if copies * d.area[cell] > best_area:
                best, best_area, best_copies = cell, copies * d.area[cell], copies
    return best, best_copies


@kernel
def collect_strips(
    d: Decomposition, r1: float, r2: float, r3: float, sectors: int, component: int
) -> int:
    """Gather a component's cells, sector by sector, into strips; return their number.

    A strip goes on into the next sector where a cell lies between the same two curves and
    shares their common ray.
    """
    strips = 0
    for k in range(sectors):
        for cell in range(d.first[k], d.first[k + 1]):
            if d.component[cell] != component:
                continue
            continued = False
            for strip in range(strips):
                if (
                    d.strip_to[strip] == d.angles[k]
                    and d.strip_lower[strip] == d.lower[cell]
                    and d.strip_upper[strip] == d.upper[cell]
                    and _shared_width(d, r1, r2, r3, d.angles[k], cell, cell) > LEAST_WIDTH
                ):
                    d.strip_to[strip] = d.angles[k + 1]
                    continued = True
                    break
            if not continued:
                d.strip_from[strips] = d.angles[k]
                d.strip_to[strips] = d.angles[k + 1]
                d.strip_lower[strips] = d.lower[cell]
                d.strip_upper[strips] = d.upper[cell]
                strips += 1
    return strips


@kernel
def strips_area(
    d: Decomposition, r1: float, r2: float, r3: float, strips: int
) -> tuple[float, float]:
    """Return the area of the strips in closed form and its rounding error."""
    area = 0.0
    for strip in range(strips):
        start, end = d.strip_from[strip], d.strip_to[strip]
        area += swept_area(d.strip_upper[strip], r1, r2, r3, start, end)
        area -= swept_area(d.strip_lower[strip], r1, r2, r3, start, end)
    return area, AREA_ROUNDING * 2.0 * strips * (r1 + r2) * (r1 + r2)


@kernel
def usable_workspace(
    r1: float, r2: float, r3: float, s1: float, s2: float, assembly: float, d: Decomposition
) -> tuple[int, int, int, float, float, float]:
    """Find the usable workspace of a mode pair and gather its strips.

    Parameters
    ----------
    r1, r2, r3, s1, s2, assembly
        Non-dimensional lengths and mode pair, as for :func:`decompose`.
    d
        Receives the decomposition and the strips.

    Returns
    -------
    tuple
        Number of sectors, component, number of strips; copies (2 where the strips are the
        right half of a symmetric workspace), area of the strips and its rounding error. The
        component is -1 where there is no workspace.
    """
    if is_degenerate(r1, r2, r3, s1, s2):
        return 0, -1, 0, 0.0, 0.0, 0.0
    sectors = decompose(r1, r2, r3, s1, s2, assembly, d)
    component, copies = largest_component(d, r1, r2, r3, s1 != s2, sectors)
    if component < 0:
        return sectors, -1, 0, 0.0, 0.0, 0.0
    strips = collect_strips(d, r1, r2, r3, sectors, component)
    area, area_error = strips_area(d, r1, r2, r3, strips)
    if area <= area_error:
        return sectors, -1, 0, 0.0, 0.0, 0.0
    return sectors, component, strips, copies, area, area_error


@kernel
def contains(
    d: Decomposition, r1: float, r2: float, r3: float, strips: int, phi: float, rho: float
) -> bool:
    """Tell whether a point (ρ, φ), φ in the decomposed range, lies in the strips.

    The origin does where strips begin at it all around.
    """
    if rho == 0.0:
        around = 0.0
        for strip in range(strips):
            if d.strip_lower[strip] == ORIGIN:
                around += d.strip_to[strip] - d.strip_from[strip]
        least = d.turn[0] - LEAST_SECTOR * MAX_CRITICAL
        return bool(around > least)
    c, s = math.cos(phi), math.sin(phi)
    for strip in range(strips):
        if (
            d.strip_from[strip] <= phi <= d.strip_to[strip]
            and radius_along(d.strip_lower[strip], r1, r2, r3, c, s) < rho
            and rho < radius_along(d.strip_upper[strip], r1, r2, r3, c, s)
        ):
            return True
    return False
