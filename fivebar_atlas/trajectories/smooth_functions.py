"""Functions of time as piecewise polynomials, and how smooth they are."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from fivebar_atlas.errors import InputError, MotionError
from fivebar_atlas.mechanisms.arrays import FloatArray

#: What a spline does at its ends: nothing more than that its outermost pieces are one polynomial;
#: its highest derivatives are 0; or it is at rest.
Ends = Literal["not-a-knot", "natural", "clamped"]
#: Degrees of splines through points.
DEGREES = (1, 2, 3, 5)

# Jumps of a derivative below this share of its size are rounding, and so are those below this
# share of the function over the square of a piece.
_ROUNDING, _FLOOR = 1e-7, 1e-9
_ORDERS = ("value", "velocity", "acceleration")


@dataclasses.dataclass(frozen=True, eq=False)
class PiecewisePolynomial:
    """A function of time, a polynomial from each break to the next.

    Attributes
    ----------
    breaks
        Rising, shape (pieces + 1,). Beyond the first and the last the outermost pieces go on.
    coefficients
        Of the powers of t - t_k, the highest first, shape (degree + 1, pieces).
    """

    breaks: FloatArray
    coefficients: FloatArray

    @property
    def degree(self) -> int:
        """Degree of the pieces."""
        return len(self.coefficients) - 1

    def __call__(self, times: FloatArray | Sequence[float], order: int = 0) -> FloatArray:
        """Return the function, or a derivative of it; at a break that of the piece after it."""
        moments = np.asarray(times, dtype=np.float64)
        piece = np.searchsorted(self.breaks[1:-1], moments, side="right")
        rows = self.derivative(order)[:, piece]
        steps = moments - self.breaks[piece]
        values = np.zeros_like(moments)
        for row in rows:
            values = values * steps + row
        return values

    def derivative(self, order: int) -> FloatArray:
        """Return the coefficients of a derivative, shape (degree + 1 - order, pieces)."""
        powers = range(self.degree, order - 1, -1)
        factors = np.array([math.perm(power, order) for power in powers], dtype=np.float64)
        kept: FloatArray = self.coefficients[: len(factors)] * factors[:, None]
        return kept


def constant(value: float, duration: float) -> PiecewisePolynomial:
    """Return a function that is the same all the time."""
    return polynomial([value], duration)


def polynomial(coefficients: Sequence[float], duration: float) -> PiecewisePolynomial:
    """Return c0 + c1 t + c2 t² + ... from its coefficients."""
    column = np.array(coefficients, dtype=np.float64)[::-1, None]
    return PiecewisePolynomial(np.array([0.0, duration]), column)


def pieces(breaks: Sequence[float], coefficients: Sequence[Sequence[float]]) -> PiecewisePolynomial:
    """Return a function that is c0 + c1 (t - t_k) + ... from each break t_k to the next.

    Raises
    ------
    InputError
        If breaks do not rise, or there is not a list of coefficients for each piece.
    """
    places = rising("breaks", breaks, 2)
    if len(coefficients) != len(places) - 1:
        allowed = f"a list of coefficients for each of {len(places) - 1} pieces"
        raise InputError("coefficients", [list(each) for each in coefficients], allowed)
    if not all(len(each) for each in coefficients):
        raise InputError("coefficients", [list(each) for each in coefficients], "no empty list")
    order = max(len(each) for each in coefficients)
    table = np.zeros((order, len(coefficients)))
    for number, each in enumerate(coefficients):
        table[order - len(each) :, number] = each[::-1]
    return PiecewisePolynomial(places, table)


def stops(times: Sequence[float], values: Sequence[float]) -> PiecewisePolynomial:
    """Return a function that comes to rest at each point, with the least jerk between two.

    Between two points it rises or falls all the way: its extremes are at the points.

    Raises
    ------
    InputError
        If times do not rise, or there are not as many values.
    """
    places = rising("times", times, 2)
    heights = _as_many(values, places)
    widths, steps = np.diff(places), np.diff(heights)
    table = np.zeros((6, len(widths)))
    for row, factor in enumerate((6.0, -15.0, 10.0)):  # of the powers 5, 4 and 3
        table[row] = factor * steps / widths ** (5 - row)
    table[5] = heights[:-1]
    return PiecewisePolynomial(places, table)


def spline(
    times: Sequence[float], values: Sequence[float], degree: int = 5, ends: Ends = "clamped"
) -> PiecewisePolynomial:
    """Return the spline through points.

    Parameters
    ----------
    times, values
        The points, times rising.
    degree
        One of :data:`DEGREES`. Accelerations exist from degree 3 on.
    ends
        What it does at its ends; ``"not-a-knot"`` needs one point more than its degree, and is
        the only way for the degrees 1 and 2.

    Raises
    ------
    InputError
        If an argument is not as above.
    """
    if degree not in DEGREES:
        allowed = f"one of {', '.join(map(str, DEGREES))}"
        raise InputError("degree", degree, allowed)
    places = rising("times", times, degree + 1 if ends == "not-a-knot" or degree < 3 else 2)
    heights = _as_many(values, places)
    # Imported where it is needed: motions without splines do not wait for it.
    from scipy.interpolate import CubicSpline, PPoly, make_interp_spline

    if degree == 3:
        cubic = CubicSpline(places, heights, bc_type=ends)
        return PiecewisePolynomial(cubic.x, cubic.c)
    conditions: Any = None
    if degree == 5 and ends != "not-a-knot":
        orders = (1, 2) if ends == "clamped" else (3, 4)
        side = [(order, 0.0) for order in orders]
        conditions = (side, side)
    found = PPoly.from_spline(make_interp_spline(places, heights, k=degree, bc_type=conditions))
    # the knots at the ends are there several times, with nothing between them
    wide = np.diff(found.x) > 0.0
    breaks = np.append(found.x[:-1][wide], found.x[-1])
    return PiecewisePolynomial(breaks, np.ascontiguousarray(found.c[:, wide]))


def rising(name: str, values: Sequence[float], least: int) -> FloatArray:
    """Return numbers that rise, at least so many.

    Raises
    ------
    InputError
        If they are fewer or do not rise.
    """
    array = np.array(values, dtype=np.float64)
    if len(array) < least:
        raise InputError(name, list(values), f"at least {least} numbers")
    still = np.flatnonzero(np.diff(array) <= 0.0)
    if len(still):
        after = (
            f"numbers that rise: {array[still[0] + 1]:g} does not come after {array[still[0]]:g}"
        )
        raise InputError(name, list(values), after)
    return array


def _as_many(values: Sequence[float], places: FloatArray) -> FloatArray:
    if len(values) != len(places):
        raise InputError("values", list(values), f"as many numbers as times, {len(places)}")
    return np.array(values, dtype=np.float64)


def check_covers(name: str, function: PiecewisePolynomial, duration: float) -> None:
    """Raise InputError unless a function is given from 0 to the duration."""
    first, last = float(function.breaks[0]), float(function.breaks[-1])
    slack = _FLOOR * duration
    if first > slack or last < duration - slack:
        raise InputError(
            name, f"{first:g} to {last:g}", f"a function from 0 to the duration, {duration:g}"
        )


def check_smooth(
    name: str, function: PiecewisePolynomial, duration: float, unit: str, time_unit: str
) -> None:
    """Refuse a function whose second derivative does not exist or jumps.

    Parameters
    ----------
    name
        What it is a function for.
    function
        The function.
    duration
        Only what is before it is looked at.
    unit, time_unit
        Units of its values and of the time, for the message.

    Raises
    ------
    MotionError
        If there is a jump of the value, the velocity or the acceleration; it says where, and how
        large.
    """
    breaks = function.breaks
    inner = np.flatnonzero((breaks > 0.0) & (breaks < duration))
    inner = inner[(inner > 0) & (inner < len(breaks) - 1)]
    places = breaks[inner]
    if not len(places):
        return
    widths = np.diff(breaks)
    steps, shortest = widths[inner - 1], float(widths.min())
    size = float(np.abs(function(breaks)).max())
    for order, what in enumerate(_ORDERS):
        left, right = np.zeros(len(places)), np.zeros(len(places))
        for row in function.derivative(order):
            left = left * steps + row[inner - 1]
            right = row[inner]  # of the power 0 at last
        jumps = np.abs(right - left)
        scale = max(float(np.abs(left).max()), float(np.abs(right).max()))
        allowed = _ROUNDING * scale + _FLOOR * size / shortest**order
        bad = np.flatnonzero(jumps > allowed)
        if len(bad):
            first = int(bad[0])
            by = ("", f"/{time_unit}", f"/{time_unit}²")[order]
            more = f" and at {len(bad) - 1} other times" if len(bad) > 1 else ""
            raise MotionError(
                f"{name} is not smooth enough: its {what} jumps from {left[first]:.6g} to "
                f"{right[first]:.6g} {unit}{by} at t = {places[first]:.6g} {time_unit}{more}; "
                "accelerations need functions that are twice continuously differentiable, such as "
                'a spline of degree 3 or 5, or "stops"',
                float(places[first]),
            )
