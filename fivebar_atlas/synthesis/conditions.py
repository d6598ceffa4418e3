"""Conditions on designs, such as ``gci>=0.62``, read by a small grammar.

A condition is a name, one of ``>= <= > <`` and a number, and nothing else; it is never
evaluated as code. Applied to values it gives signed margins, positive where it holds
with room to spare, which is what contour and region algorithms need. What is at the bound
but for rounding counts as at the bound, everywhere: there ``>=`` and ``<=`` hold and ``>``
and ``<`` do not.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.store import Atlas

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_GRAMMAR = re.compile(
    r"""\s* (?P<quantity> [A-Za-z_][A-Za-z0-9_]* )
        \s* (?P<operator> >= | <= | > | < )
        \s* (?P<bound> [+-]? (?: \d+ (?: \.\d* )? | \.\d+ ) (?: [eE][+-]?\d+ )? ) \s*""",
    re.VERBOSE | re.ASCII,
)
#: Margins up to this share of a condition's scale are nothing but rounding.
SLACK = 1e-12

_ALLOWED = "a quantity, one of >= <= > <, and a number, such as 'gci>=0.62'"


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

    @property
    def is_strict(self) -> bool:
        """Whether the bound itself does not fulfil it."""
        return not self.operator.endswith("=")

    def scale(self, values: FloatArray) -> float:
        """Return what margins are relative to: the bound, or the range of values where it is 0."""
        finite = values[np.isfinite(values)]
        width = float(np.ptp(finite)) if len(finite) else 0.0
        return abs(self.bound) or width or 1.0

    def is_met(self, margins: FloatArray, scale: float) -> BoolArray:
        """Return which margins fulfil it, rounding aside; a missing one (NaN) never does."""
        slack = SLACK * scale
        return margins > slack if self.is_strict else margins >= -slack

    def holds(self, values: FloatArray) -> BoolArray:
        """Return where the condition holds; a missing value (NaN) never does.

        Parameters
        ----------
        values
            Values of the quantity at all designs that there are, shape (n,).
        """
        return self.is_met(self.margin(values), self.scale(values))


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


def condition_names(atlas: Atlas) -> tuple[str, ...]:
    """Return every name a condition on the designs of a file may use, parameters first.

    Categories such as ``status`` are left out: they are not ordered and cannot be
    interpolated between designs.
    """
    parameters = (parameter.name for parameter in atlas.mechanism.parameters)
    arrays = atlas.mechanism.stored_arrays(atlas.settings)
    return (*parameters, *(array.name for array in arrays if array.quantity.flags is None))


def check_conditions(conditions: Sequence[Condition], atlas: Atlas, name: str = "--where") -> None:
    """Raise UnknownNameError unless every condition is on something the file holds."""
    known = condition_names(atlas)
    for condition in conditions:
        if condition.quantity not in known:
            raise atlas.unknown(name, condition.quantity, known)


def condition_margins(
    conditions: Sequence[Condition],
    atlas: Atlas,
    mode: str | None = None,
    lci: float | None = None,
) -> FloatArray:
    """Return the signed margins of several conditions at every design.

    Parameters
    ----------
    conditions
        The conditions, all of which are to hold.
    atlas
        The open result file.
    mode, lci
        Mode pair and LCI threshold of the quantities that depend on them; needed only
        where the file holds several.

    Returns
    -------
    ndarray
        Shape (conditions, designs); see :meth:`Condition.margin`. A margin that is nothing
        but rounding is 0, and just below where the condition is strict.

    Raises
    ------
    UnknownNameError
        If a condition names something that is neither a quantity nor a parameter.
    InputError
        If a mode pair or threshold is not in the file or must be chosen.
    """
    check_conditions(conditions, atlas)
    margins = np.empty((len(conditions), len(atlas.designs)))
    for row, condition in enumerate(conditions):
        values = atlas.select(condition.quantity, mode, lci)
        margins[row] = rounded_margins(condition, values)
    return margins


def rounded_margins(condition: Condition, values: FloatArray) -> FloatArray:
    """Return margins at all designs, shape (n,), so that rounding does not count.

    A margin within the slack is 0; where the condition is strict it is negative, so that a
    plateau at the bound is outside, by no more than tells it from 0.
    """
    margins = np.asarray(condition.margin(values), dtype=np.float64)
    slack = SLACK * condition.scale(values)
    largest = float(np.max(np.abs(margins), initial=0.0, where=np.isfinite(margins)))
    at_bound = -max(slack, SLACK * largest) if condition.is_strict else 0.0
    return np.where(np.abs(margins) <= slack, at_bound, margins)


def check_contradictions(conditions: Sequence[Condition], name: str = "--where") -> None:
    """Raise InputError where no value at all fulfils all conditions on one quantity."""
    for above in conditions:
        for below in conditions:
            if above.quantity != below.quantity or above.operator[0] + below.operator[0] != "><":
                continue
            strict = len(above.operator + below.operator) < 4
            if above.bound > below.bound or (strict and above.bound == below.bound):
                raise InputError(
                    name, f"{above}, {below}", "conditions that do not contradict each other"
                )
