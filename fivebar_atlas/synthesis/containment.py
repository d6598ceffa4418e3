"""Whether a whole shape lies where a mechanism is in good condition, proved and not sampled.

A point is good where the LCI in the usable workspace is at least a threshold and every input
is in the range of its actuator. A shape is connected: if all of it is good it lies in one
connected part of the good-condition workspace.

The proof covers the shape with squares. Where the bound of :meth:`PlanarDesign.bounds_on_discs`
says that a disc around a square is good it is done with, otherwise it is cut into four, until
all are or a point of the shape is found that is not good.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.shapes import Shape

# Squares along the longer side of a shape to begin with.
_FIRST_SQUARES = 24
# Least side of a square as a share of the shape, and squares that are looked at together.
_LEAST_SIDE, _BLOCK = 1e-12, 100_000


def check_positive(name: str, value: float) -> None:
    """Raise InputError unless a number is positive and finite."""
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(name, value, "a finite number above 0")


#: What a proof came to.
INSIDE, OUTSIDE, UNDECIDED = "inside", "outside", "undecided"


@dataclasses.dataclass(frozen=True, slots=True)
class ActuatorRange:
    """The range that one actuator has.

    Attributes
    ----------
    number
        Which input, from 1.
    least, greatest
        Input angles in radians; what matters is where they point, not the turns between
        them and (-π, π].

    Raises
    ------
    InputError
        If they are not finite, or the greatest is not above the least.
    """

    number: int
    least: float
    greatest: float

    def __post_init__(self) -> None:
        limits = (math.degrees(self.least), math.degrees(self.greatest))
        if not all(map(math.isfinite, limits)):
            raise InputError("actuator range", limits, "finite angles")
        if not self.least < self.greatest:
            raise InputError("actuator range", limits, "a least angle below the greatest")

    def text(self, mechanism: Mechanism) -> str:
        """Return the range with the name that the mechanism has for the input."""
        least, greatest = math.degrees(self.least), math.degrees(self.greatest)
        return f"{mechanism.input_text(self.number)} from {least:g} to {greatest:g} deg"

    @property
    def is_limiting(self) -> bool:
        """Whether it is less than a full turn."""
        return self.greatest - self.least < 2.0 * math.pi

    def margins(self, inputs: FloatArray) -> FloatArray:
        """Return by how many radians angles are inside; negative outside; NaN for NaN."""
        middle, half = 0.5 * (self.least + self.greatest), 0.5 * (self.greatest - self.least)
        off = np.remainder(inputs - middle + math.pi, 2.0 * math.pi) - math.pi
        return np.asarray(half - np.abs(off))


def check_ranges(ranges: Sequence[ActuatorRange], design: PlanarDesign, mode: str) -> None:
    """Raise InputError unless ranges are of inputs that there are, one for each at most."""
    if not ranges:
        return
    inputs = design.inputs(np.zeros(1), np.zeros(1), mode).shape[1]
    for each in ranges:
        if not 1 <= each.number <= inputs:
            raise InputError("actuator range", each.number, f"an actuator from 1 to {inputs}")
    numbers = [each.number for each in ranges]
    if len(set(numbers)) < len(numbers):
        raise InputError("actuator range", numbers, "one range for each actuator")


@dataclasses.dataclass(frozen=True)
class GoodCondition:
    """What is asked of every point of a practical workspace.

    Attributes
    ----------
    design
        The non-dimensional design.
    mode
        Mode pair.
    lci_threshold
        Least LCI, in (0, 1).
    ranges
        Ranges of actuators.

    Raises
    ------
    InputError
        If there is no such actuator, or an actuator has two ranges.
    """

    design: PlanarDesign
    mode: str
    lci_threshold: float
    ranges: tuple[ActuatorRange, ...] = ()

    def __post_init__(self) -> None:
        check_ranges(self.ranges, self.design, self.mode)

    def margins(self, points: FloatArray) -> FloatArray:
        """Return how far points are from not being good; negative where they are not.

        Parameters
        ----------
        points
            Points of the design, shape (..., 2).

        Returns
        -------
        ndarray
            Shape (...,): the least of the LCI less its threshold and of the margins of the
            inputs in radians. Continuous where the LCI margin is positive.
        """
        flat = points.reshape(-1, 2)
        x, y = np.ascontiguousarray(flat[:, 0]), np.ascontiguousarray(flat[:, 1])
        margins = self.design.lci_inside(x, y, self.mode) - self.lci_threshold
        limiting = [each for each in self.ranges if each.is_limiting]
        if limiting:
            inputs = self.design.inputs(x, y, self.mode)
            for each in limiting:
                margins = np.fmin(margins, each.margins(inputs[:, each.number - 1]))
        return np.asarray(margins.reshape(points.shape[:-1]))

    def least_margins(self, points: FloatArray, radius: float) -> FloatArray:
        """Return lower bounds of :meth:`margins` over discs around points of shape (n, 2)."""
        x, y = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
        least, turns = self.design.bounds_on_discs(x, y, np.full(len(x), radius), self.mode)
        margins = least - self.lci_threshold
        limiting = [each for each in self.ranges if each.is_limiting]
        if limiting:
            inputs = self.design.inputs(x, y, self.mode)
            for each in limiting:
                column = each.number - 1
                margins = np.fmin(margins, each.margins(inputs[:, column]) - turns[:, column])
        return np.asarray(margins)


@dataclasses.dataclass(frozen=True, slots=True)
class Proof:
    """What a proof of containment came to.

    Attributes
    ----------
    verdict
        ``INSIDE``: every point of the shape is good. ``OUTSIDE``: one is not. ``UNDECIDED``:
        neither was shown within the squares that a proof may take.
    squares
        Number of squares looked at.
    witness
        A point of the shape that is not good, relative to the centre of the shape and in its
        lengths; None where there is none.
    """

    verdict: str
    squares: int
    witness: FloatArray | None = None


def prove(
    good: GoodCondition,
    shape: Shape,
    position: Sequence[float] | FloatArray,
    scale: float,
    most_squares: int = 400_000,
) -> Proof:
    """Tell whether all of a shape is good, proved but for rounding.

    Parameters
    ----------
    good
        What is asked of its points.
    shape
        The shape, in lengths of the machine.
    position
        Where its centre is, in non-dimensional lengths.
    scale
        Non-dimensional length for the unit of the shape, 1/D.
    most_squares
        Squares of one size that it may take.
    """
    place = np.asarray(position, dtype=np.float64)
    centres, half = covering_squares(shape)
    least_half = half * _FIRST_SQUARES * _LEAST_SIDE
    count = 0
    while len(centres):
        count += len(centres)
        if len(centres) > most_squares or half < least_half:
            return Proof(UNDECIDED, count)
        left = []
        for start in range(0, len(centres), _BLOCK):
            open_ones, witness = _open_squares(
                good, shape, place, scale, centres[start : start + _BLOCK], half
            )
            if witness is not None:
                return Proof(OUTSIDE, count, witness)
            left.append(open_ones)
        centres, half = quartered(np.concatenate(left), half)
    # One point of a connected shape tells on which side of the singular loci all of it is.
    inner = place + scale * shape.boundary(np.zeros(1))
    if good.design.lci_inside(inner[:, 0], inner[:, 1], good.mode)[0] > 0.0:
        return Proof(INSIDE, count)
    return Proof(OUTSIDE, count, shape.boundary(np.zeros(1))[0])


def covering_squares(shape: Shape) -> tuple[FloatArray, float]:
    """Return the centres of squares that cover a shape, shape (n, 2), and half their side."""
    lower, upper = shape.extent
    half = 0.5 * float((upper - lower).max()) / _FIRST_SQUARES
    numbers = [max(math.ceil(side / (2.0 * half) - 1e-9), 1) for side in upper - lower]
    lines = [
        0.5 * (low + high) + half * (2.0 * np.arange(number) + 1.0 - number)
        for low, high, number in zip(lower, upper, numbers, strict=True)
    ]
    x, y = np.meshgrid(*lines)
    return np.column_stack([x.ravel(), y.ravel()]), half


def quartered(centres: FloatArray, half: float) -> tuple[FloatArray, float]:
    """Return the centres of the quarters of squares, and half the side of a quarter."""
    half *= 0.5
    quarters = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return (centres[:, None] + quarters).reshape(-1, 2), half


def _open_squares(
    good: GoodCondition,
    shape: Shape,
    place: FloatArray,
    scale: float,
    centres: FloatArray,
    half: float,
) -> tuple[FloatArray, FloatArray | None]:
    """Return the centres of squares that are still to be cut, or a point that is not good."""
    reach = math.sqrt(2.0) * half
    centres = centres[good.least_margins(place + scale * centres, scale * reach) < 0.0]
    gaps = shape.gaps(centres)
    centres, gaps = centres[gaps <= reach], gaps[gaps <= reach]
    inside = centres[gaps <= 0.0]
    margins = good.margins(place + scale * inside)
    if np.any(margins < 0.0):
        return centres, inside[int(np.argmin(margins))]
    return centres, None
