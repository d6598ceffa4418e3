"""Functions of time as piecewise polynomials, and how smooth they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BPoly, CubicSpline, PPoly, make_interp_spline

from fivebar_atlas.errors import InputError, MotionError

FloatArray = npt.NDArray[np.float64]

#: What a spline does at its ends: nothing more than that its outermost pieces are one polynomial;
#: its highest derivatives are 0; or it is at rest.
Ends = Literal["not-a-knot", "natural", "clamped"]
#: Degrees of splines through points.
DEGREES = (1, 2, 3, 5)

# Jumps of a derivative below this share of its size are rounding, and so are those below this
# share of the function over the square of a piece.
_ROUNDING, _FLOOR = 1e-7, 1e-9
_ORDERS = ("value", "velocity", "acceleration")


def constant(value: float, duration: float) -> Any:
    """Return a function that is the same all the time."""
    return PPoly(np.array([[value]]), np.array([0.0, duration]))


def polynomial(coefficients: Sequence[float], duration: float) -> Any:
    """Return c0 + c1 t + c2 t² + ... from its coefficients."""
    return PPoly(np.array(coefficients, dtype=np.float64)[::-1, None], np.array([0.0, duration]))


def pieces(breaks: Sequence[float], coefficients: Sequence[Sequence[float]]) -> Any:
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
    return PPoly(table, places)


def stops(times: Sequence[float], values: Sequence[float]) -> Any:
    """Return a function that comes to rest at each point, with the least jerk between two.

    Between two points it rises or falls all the way: its extremes are at the points.

    Raises
    ------
    InputError
        If times do not rise, or there are not as many values.
    """
    places = rising("times", times, 2)
    heights = np.zeros((len(places), 3))
    heights[:, 0] = _as_many(values, places)
    return PPoly.from_bernstein_basis(BPoly.from_derivatives(places, heights))


def spline(
    times: Sequence[float], values: Sequence[float], degree: int = 5, ends: Ends = "clamped"
) -> Any:
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
    if degree == 3:
        return CubicSpline(places, heights, bc_type=ends)
    conditions: Any = None
    if degree == 5 and ends != "not-a-knot":
        orders = (1, 2) if ends == "clamped" else (3, 4)
        side = [(order, 0.0) for order in orders]
        conditions = (side, side)
    found = PPoly.from_spline(make_interp_spline(places, heights, k=degree, bc_type=conditions))
    # the knots at the ends are there several times, with nothing between them
    wide = np.diff(found.x) > 0.0
    return PPoly(found.c[:, wide], np.append(found.x[:-1][wide], found.x[-1]))


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


def check_covers(name: str, function: Any, duration: float) -> None:
    """Raise InputError unless a function is given from 0 to the duration."""
    first, last = float(function.x[0]), float(function.x[-1])
    slack = _FLOOR * duration
    if first > slack or last < duration - slack:
        raise InputError(
            name, f"{first:g} to {last:g}", f"a function from 0 to the duration, {duration:g}"
        )


def check_smooth(name: str, function: Any, duration: float, unit: str, time_unit: str) -> None:
    """Refuse a function whose second derivative does not exist or jumps.

    Parameters
    ----------
    name
        What it is a function for.
    function
        A piecewise polynomial.
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
    inner = (function.x[1:-1] > 0.0) & (function.x[1:-1] < duration)
    places = function.x[1:-1][inner]
    if not len(places):
        return
    widths = np.diff(function.x)
    before, after = function.c[:, :-1][:, inner], function.c[:, 1:][:, inner]
    steps = widths[:-1][inner]
    shortest = float(widths.min())
    size = max(float(np.abs(function(function.x)).max()), 0.0)
    degree = len(function.c) - 1
    for order, what in enumerate(_ORDERS):
        left = np.zeros(len(places))
        for power in range(degree, order - 1, -1):
            row = degree - power
            left = left * steps + before[row] * math.perm(power, order)
        right = (
            after[degree - order] * math.factorial(order)
            if order <= degree
            else np.zeros(len(places))
        )
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
