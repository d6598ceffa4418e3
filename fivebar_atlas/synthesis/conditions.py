"""Conditions on designs, such as ``gci>=0.62``, read by a small grammar.

A condition is a name, one of ``>= <= > <`` and a number, and nothing else; it is never
evaluated as code. Applied to values it gives signed margins, positive where it holds
with room to spare, which is what contour and region algorithms need.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.base import MODE, THRESHOLD, Mechanism, Quantity

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_GRAMMAR = re.compile(
    r"""\s* (?P<quantity> [A-Za-z_][A-Za-z0-9_]* )
        \s* (?P<operator> >= | <= | > | < )
        \s* (?P<bound> [+-]? (?: \d+ (?: \.\d* )? | \.\d+ ) (?: [eE][+-]?\d+ )? ) \s*""",
    re.VERBOSE | re.ASCII,
)
_ALLOWED = "a quantity, one of >= <= > <, and a number, such as 'gci>=0.62'"


class Designs(Protocol):
    """What conditions need of a result file."""

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""

    @property
    def designs(self) -> FloatArray:
        """The designs, shape (designs, parameters)."""

    def select(self, name: str, mode: str | None = None, lci: float | None = None) -> FloatArray:
        """Return the values of one quantity, shape (designs,)."""


@dataclasses.dataclass(frozen=True, slots=True)
class Condition:
    """One condition on one quantity.

    Attributes
    ----------
    quantity
        Name of a quantity, of an error companion or of a design parameter.
    operator
        ``">="``, ``"<="``, ``">"`` or ``"<"``.
    bound
        The number it is compared with.
    """

    quantity: str
    operator: str
    bound: float

    def __str__(self) -> str:
        return f"{self.quantity}{self.operator}{self.bound:.12g}"

    def margin(self, values: FloatArray) -> FloatArray:
        """Return how far values are on the right side of the bound.

        Parameters
        ----------
        values
            Values of the quantity, any shape.

        Returns
        -------
        ndarray
            Positive where the condition holds, negative where it does not, zero at the
            bound, NaN where there is no value; in the unit of the quantity.
        """
        return values - self.bound if self.operator[0] == ">" else self.bound - values

    def holds(self, values: FloatArray) -> BoolArray:
        """Return where the condition holds; a missing value (NaN) never does."""
        margin = self.margin(values)
        return margin >= 0.0 if self.operator.endswith("=") else margin > 0.0


def parse_condition(text: str, name: str = "--where") -> Condition:
    """Read one condition.

    Parameters
    ----------
    text
        A name, an operator and a number; spaces between them are allowed.
    name
        What to call the input in an error message.

    Returns
    -------
    Condition
        The condition; whether its quantity exists is not known yet.

    Raises
    ------
    InputError
        If the text has another form or the number is not finite.
    """
    match = _GRAMMAR.fullmatch(text)
    if match is None:
        raise InputError(name, text, _ALLOWED)
    bound = float(match["bound"])
    if not math.isfinite(bound):
        raise InputError(name, text, "a finite number after the operator")
    return Condition(match["quantity"], match["operator"], bound)


def condition_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Return every name a condition may use, parameters first.

    Categories such as ``status`` are left out: they are not ordered and cannot be
    interpolated between designs.
    """
    names = [parameter.name for parameter in mechanism.parameters]
    for quantity in mechanism.quantities:
        if quantity.flags is None:
            names.append(quantity.name)
            if quantity.has_error:
                names.append(quantity.error_name)
    return tuple(names)


def condition_quantity(mechanism: Mechanism, name: str) -> Quantity | None:
    """Return the quantity behind a name, or None for a design parameter.

    An error companion leads to the quantity it belongs to.

    Raises
    ------
    UnknownNameError
        If conditions cannot use the name; it lists those there are and the nearest.
    """
    if name not in condition_names(mechanism):
        raise UnknownNameError("quantity in a condition", name, condition_names(mechanism))
    for quantity in mechanism.quantities:
        if name in (quantity.name, quantity.error_name):
            return quantity
    return None


def condition_values(
    name: str, atlas: Designs, mode: str | None = None, lci: float | None = None
) -> FloatArray:
    """Return the values of a quantity or parameter, one for each design.

    Parameters
    ----------
    name
        Name of a quantity, of an error companion or of a design parameter.
    atlas
        The results.
    mode
        Canonical label of the mode pair, for quantities that depend on it.
    lci
        LCI threshold, for quantities that depend on it.

    Returns
    -------
    ndarray
        Shape (designs,).

    Raises
    ------
    UnknownNameError
        If there is no such quantity or parameter.
    """
    quantity = condition_quantity(atlas.mechanism, name)
    if quantity is None:
        column = [parameter.name for parameter in atlas.mechanism.parameters].index(name)
        return np.asarray(atlas.designs[:, column], dtype=np.float64)
    values = atlas.select(
        name,
        mode=mode if MODE in quantity.dimensions else None,
        lci=lci if THRESHOLD in quantity.dimensions else None,
    )
    return np.asarray(values, dtype=np.float64)


def condition_margins(
    conditions: Sequence[Condition],
    atlas: Designs,
    mode: str | None = None,
    lci: float | None = None,
) -> FloatArray:
    """Return the signed margins of several conditions at every design.

    Parameters
    ----------
    conditions
        The conditions, all of which are to hold.
    atlas
        The results.
    mode, lci
        Mode pair and LCI threshold of the quantities that depend on them.

    Returns
    -------
    ndarray
        Shape (conditions, designs); see :meth:`Condition.margin`.

    Raises
    ------
    UnknownNameError
        If a condition names something that is neither a quantity nor a parameter.
    """
    margins = np.empty((len(conditions), len(atlas.designs)))
    for row, condition in enumerate(conditions):
        values = condition_values(condition.quantity, atlas, mode, lci)
        margins[row] = condition.margin(values)
    return margins
