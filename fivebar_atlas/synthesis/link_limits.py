"""Limits on the lengths of links."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence

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


def check_names(names: Sequence[str], limits: Sequence[LinkLimit]) -> None:
    """Raise UnknownNameError unless limits are on lengths that there are, in small letters."""
    for each in limits:
        if each.name.lower() not in names:
            raise UnknownNameError("link limit", each.name, [name.upper() for name in names])


def check_limits(lengths: Mapping[str, float], limits: Sequence[LinkLimit]) -> None:
    """Check the limits on the lengths of one design, given by name in small letters.

    Raises
    ------
    UnknownNameError
        If a limit is on a length that there is not.
    InputError
        If a least length is asked for of one that is 0 at every size.
    """
    check_names(tuple(lengths), limits)
    for each in limits:
        if each.least > 0.0 and lengths[each.name.lower()] == 0.0:
            allowed = f"no least length, for {each.name} is 0 at every size"
            raise InputError(f"limits of {each.name}", (each.least, each.greatest), allowed)
