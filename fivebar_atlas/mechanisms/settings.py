"""What a sweep computes: its settings, and the options that a mechanism leaves to it."""

from __future__ import annotations

import dataclasses
import math

from fivebar_atlas.errors import InputError

#: Sweep options of a mechanism by name, in the order the mechanism declares them.
Options = tuple[tuple[str, float | bool], ...]
#: Thresholds and tolerance where nothing is said.
DEFAULT_LCI_THRESHOLDS = (0.5,)
DEFAULT_TOLERANCE = 1e-6


@dataclasses.dataclass(frozen=True, slots=True)
class SweepOption:
    """A choice that a mechanism leaves to a sweep, a number or yes or no.

    Attributes
    ----------
    name
        Key in ``[sweep.options]`` and name on the command line, ``"theta_limit"``.
    unit
        Unit, ``"1"`` where non-dimensional or yes or no.
    long_name
        What it says, in a phrase.
    default
        The value where nothing is said; a bool where it is yes or no.
    least, greatest
        Range of a number, ends included.
    """

    name: str
    unit: str
    long_name: str
    default: float | bool
    least: float = -math.inf
    greatest: float = math.inf

    @property
    def allowed(self) -> str:
        """Which values there are, in a phrase."""
        if isinstance(self.default, bool):
            return "true or false"
        unit = "" if self.unit == "1" else f" {self.unit}"
        least, greatest = math.isfinite(self.least), math.isfinite(self.greatest)
        if least and greatest:
            return f"a number from {self.least:g} to {self.greatest:g}{unit}"
        if least or greatest:
            bound = f"of {self.least:g} or more" if least else f"up to {self.greatest:g}"
            return f"a number {bound}{unit}"
        return "a finite number"

    def check(self, value: object, name: str) -> float | bool:
        """Return a value as it is stored; raise InputError, under a name, if it is none."""
        if isinstance(self.default, bool):
            if isinstance(value, bool):
                return value
        elif isinstance(value, int | float) and not isinstance(value, bool):
            number = float(value)
            if math.isfinite(number) and self.least <= number <= self.greatest:
                return number + 0.0  # -0.0 is 0.0
        raise InputError(name, value, self.allowed)

    def shown(self, value: float | bool) -> str:
        """Return a value as text with its unit: ``"60 deg"``, ``"true"``."""
        if isinstance(value, bool):
            return "true" if value else "false"
        return f"{value:.8g}" if self.unit == "1" else f"{value:.8g} {self.unit}"


@dataclasses.dataclass(frozen=True, slots=True)
class SweepSettings:
    """What a sweep computes; it, and nothing else, determines the numbers.

    Attributes
    ----------
    mechanism
        Name of the mechanism.
    space
        Canonical text of the design space.
    resolution
        Number of lattice steps N.
    modes
        Canonical labels of the mode pairs, in the order asked for.
    lci_thresholds
        Thresholds of the good-condition workspace, each in (0, 1).
    tolerance
        Relative tolerance of every integrated quantity.
    options
        Sweep options of the mechanism; those that are not among them have their defaults.
        In the settings of a configuration or a file all are there, in the mechanism's order.
    """

    mechanism: str
    space: str
    resolution: int
    modes: tuple[str, ...]
    lci_thresholds: tuple[float, ...]
    tolerance: float
    options: Options = ()
