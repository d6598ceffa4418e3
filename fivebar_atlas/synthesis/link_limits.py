"""Limits on the lengths of links."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence

from fivebar_atlas.errors import InputError, UnknownNameError


@dataclasses.dataclass(frozen=True, slots=True)
class LinkLimit:
    """Least and greatest length of a link.

    Attributes
    ----------
    name
        Name of the length: ``"R1"``.
    least, greatest
        Limits in lengths of the machine, ``inf`` where there is no greatest.

    Raises
    ------
    InputError
        If a limit is negative or not a number, or the greatest is below the least.
    """

    name: str
    least: float
    greatest: float

    def __post_init__(self) -> None:
        limits = (self.least, self.greatest)
        if not (self.least >= 0.0 and math.isfinite(self.least) and self.greatest > 0.0):
            allowed = "a least length of 0 or more and a greatest above 0"
            raise InputError(f"limits of {self.name}", limits, allowed)
        if not self.least <= self.greatest:
            allowed = "a least length that is not above the greatest"
            raise InputError(f"limits of {self.name}", limits, allowed)


def length_name(text: str, names: Iterable[str]) -> str:
    """Return the name of a length, whose letters may be of the other case where that is clear.

    Raises
    ------
    UnknownNameError
        If there is no such length.
    """
    known = list(names)
    found = [name for name in known if name.lower() == text.lower()]
    if text in known or len(found) == 1:
        return text if text in known else found[0]
    raise UnknownNameError("link limit", text, known)


def check_limits(lengths: Mapping[str, float], limits: Sequence[LinkLimit]) -> None:
    """Check the limits on the lengths of one design, given by their names.

    Raises
    ------
    UnknownNameError
        If a limit is on a length that there is not.
    InputError
        If a least length is asked for of one that is 0 at every size.
    """
    for each in limits:
        length = lengths[length_name(each.name, lengths)]
        if each.least > 0.0 and length == 0.0:
            allowed = f"no least length, for {each.name} is 0 at every size"
            raise InputError(f"limits of {each.name}", (each.least, each.greatest), allowed)
