"""What is to be made as large as possible: quantities and weights, read by a small grammar."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.synthesis.conditions import SLACK

FloatArray = npt.NDArray[np.float64]

#: Makes an error of the name of an input, its value and what there is.
Unknown = Callable[[str, str, Sequence[str]], UnknownNameError]

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_ALLOWED = "quantities separated by commas, each with a weight where it is not 1, such as 'gci:2'"
_DIRECTIONS = "quantities separated by commas, '-' before or ':min' after those to be small"


@dataclasses.dataclass(frozen=True, slots=True)
class Objective:
    """A weighted sum of normalised quantities, or one quantity.

    Attributes
    ----------
    names
        The quantities.
    weights
        Their weights; negative where less is better.
    least, greatest
        The range by which each is normalised to 0..1; one quantity alone is not.
    """

    names: tuple[str, ...]
    weights: tuple[float, ...]
    least: tuple[float, ...] = ()
    greatest: tuple[float, ...] = ()

    @property
    def is_sum(self) -> bool:
        """Whether it is a sum, for which the quantities are normalised."""
        return len(self.names) > 1

    def normalised(self, values: FloatArray) -> Objective:
        """Return the objective with the ranges of values, shape (names, n)."""
        least = tuple(float(row.min()) for row in values)
        greatest = tuple(float(row.max()) for row in values)
        return dataclasses.replace(self, least=least, greatest=greatest)

    def value(self, values: FloatArray) -> FloatArray:
        """Return the objective for values of the quantities, shape (names, ...).

        A quantity with a range of no width, but for rounding, counts with its distance from
        the one value.
        """
        if not self.is_sum:
            return np.asarray(math.copysign(1.0, self.weights[0]) * values[0])
        total = np.zeros(values.shape[1:])
        for row, weight, low, high in zip(
            values, self.weights, self.least, self.greatest, strict=True
        ):
            is_wide = high - low > SLACK * max(abs(low), abs(high))
            total = total + weight * (row - low) / (high - low if is_wide else 1.0)
        return total

    def __str__(self) -> str:
        if not self.is_sum:
            return self.names[0] if self.weights[0] > 0.0 else f"-{self.names[0]}"
        pairs = zip(self.names, self.weights, strict=True)
        return ",".join(f"{name}:{weight:g}" for name, weight in pairs)


def parse_objective(
    text: str,
    known: Sequence[str],
    name: str = "--maximise",
    unknown: Unknown = UnknownNameError,
) -> Objective:
    """Read an objective such as ``gci`` or ``gci:1,usable_workspace_area:0.5``.

    Parameters
    ----------
    text
        Quantities, each with a weight where it is not 1.
    known
        What there is.
    name
        What to call the input in an error message.
    unknown
        Makes the error for what there is not, such as :meth:`Atlas.unknown`.

    Raises
    ------
    InputError
        If the text has another form, a weight is 0, not a number or not finite, or a
        quantity is given twice.
    UnknownNameError
        If there is no such quantity.
    """
    names, weights = [], []
    for part in text.split(","):
        quantity, colon, weight = (piece.strip() for piece in part.partition(":"))
        sign = -1.0 if quantity.startswith("-") else 1.0
        quantity = quantity.removeprefix("-").strip()
        if not _NAME.fullmatch(quantity):
            raise InputError(name, text, _ALLOWED)
        if quantity not in known:
            raise unknown(name, quantity, known)
        names.append(quantity)
        weights.append(sign * (_weight(weight, name) if colon else 1.0))
    if len(set(names)) < len(names):
        raise InputError(name, text, "quantities of which none is given twice")
    return Objective(tuple(names), tuple(weights))


def _weight(text: str, name: str) -> float:
    try:
        weight = float(text)
    except ValueError:
        weight = math.nan
    if not math.isfinite(weight) or weight == 0.0:
        raise InputError(name, text, "a finite number other than 0 as weight")
    return weight


def parse_directions(
    text: str,
    known: Sequence[str],
    name: str = "--pareto",
    unknown: Unknown = UnknownNameError,
) -> tuple[tuple[str, float], ...]:
    """Read the quantities of a front, such as ``usable_workspace_area,gci`` or ``-r3,gci``.

    Parameters
    ----------
    text
        At least two quantities, ``-`` before or ``:min`` after those that are to be small.
    known
        What there is.
    name
        What to call the input in an error message.
    unknown
        Makes the error for what there is not, such as :meth:`Atlas.unknown`.

    Returns
    -------
    tuple
        Pairs of a name and 1 (the larger the better) or -1.

    Raises
    ------
    InputError
        If the text has another form, or names less than two or one quantity twice.
    UnknownNameError
        If there is no such quantity.
    """
    pairs = []
    for part in text.split(","):
        quantity, colon, way = (piece.strip() for piece in part.partition(":"))
        minus = quantity.startswith("-")
        quantity = quantity.removeprefix("-").strip()
        if not _NAME.fullmatch(quantity) or (colon and (minus or way not in ("min", "max"))):
            raise InputError(name, text, _DIRECTIONS)
        if quantity not in known:
            raise unknown(name, quantity, known)
        pairs.append((quantity, -1.0 if minus or way == "min" else 1.0))
    if len({quantity for quantity, _ in pairs}) < max(len(pairs), 2):
        raise InputError(name, text, "at least two quantities, none of them twice")
    return tuple(pairs)
