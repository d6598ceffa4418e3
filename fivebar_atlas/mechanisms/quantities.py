"""What a mechanism computes: parameters, quantities with units, and the axes they run over."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

#: Arrays by the name of their quantity or error companion.
Results = Mapping[str, npt.NDArray[Any]]
DESIGN = "design"
MODE = "mode"
THRESHOLD = "threshold"


@dataclasses.dataclass(frozen=True, slots=True)
class Parameter:
    """One design parameter, an axis of the design space.

    Attributes
    ----------
    name
        Name of the dataset and in conditions, e.g. ``"r1"``.
    symbol
        The field's notation as mathtext, e.g. ``"$r_1$"``.
    unit
        Unit, ``"1"`` where non-dimensional.
    long_name
        What it is, in a phrase.
    """

    name: str
    symbol: str
    unit: str
    long_name: str


@dataclasses.dataclass(frozen=True, slots=True)
class Flags:
    """Meanings of an integer quantity, as CF ``flag_values`` or ``flag_masks``.

    Attributes
    ----------
    values
        The integers.
    meanings
        One identifier for each of ``values``.
    masks
        True where the values are bits that may be set together.
    """

    values: tuple[int, ...]
    meanings: tuple[str, ...]
    masks: bool = False

    def describe(self, value: int) -> str:
        """Return the meaning of a stored value; several bits are joined by ``", "``."""
        if not self.masks:
            return self.meanings[self.values.index(value)]
        if value == 0:
            return "ok"
        pairs = zip(self.values, self.meanings, strict=True)
        return ", ".join(meaning for bit, meaning in pairs if value & bit)


@dataclasses.dataclass(frozen=True, slots=True)
class Quantity:
    """One computed quantity.

    Attributes
    ----------
    name
        Name of the dataset, a standard term of the field.
    symbol
        Notation as mathtext, for colour bars.
    unit
        Unit, ``"1"`` where non-dimensional.
    long_name
        What it is, in a phrase.
    dimensions
        The axes it runs over, the design axis first.
    has_error
        Whether a companion ``<name>_error`` (absolute error estimate) exists.
    length_power
        Power of the dimensional factor D that scales it to a machine (areas: 2).
    flags
        Meanings, for an integer quantity; None for a floating-point one.
    ignores_tolerance
        Whether its values are the same at every tolerance.
    """

    name: str
    symbol: str
    unit: str
    long_name: str
    dimensions: tuple[str, ...] = (DESIGN,)
    has_error: bool = False
    length_power: int = 0
    flags: Flags | None = None
    ignores_tolerance: bool = False

    @property
    def error_name(self) -> str:
        """Name of the companion dataset with the absolute error estimate."""
        return f"{self.name}_error"

    @property
    def dtype(self) -> np.dtype[Any]:
        """Stored type: float64; for flags int8, or int16 where they are bits of a mask."""
        if self.flags is None:
            return np.dtype(np.float64)
        return np.dtype(np.int16 if self.flags.masks else np.int8)


@dataclasses.dataclass(frozen=True, slots=True)
class NormalisedProduct:
    """A quantity that is the product of others, each normalised over all designs of an atlas.

    Nam and Park (2006), Sec. 6.1: with one factor a normalised index, with several a composed
    design index (Eq. 31). It exists in an atlas only: a design alone has no extremes.

    Attributes
    ----------
    quantity
        What the product is; it runs over the axes of its factors, and has an error if every
        factor has one.
    factors
        Names of the mechanism's floating-point quantities that are multiplied.
    normalisation
        What f is divided by: ``"range"`` is (f - min f)/(max f - min f), ``"largest"`` is
        f/max f, with the extremes over the designs at the same place of the other axes.
    """

    quantity: Quantity
    factors: tuple[str, ...]
    normalisation: Literal["range", "largest"]


@dataclasses.dataclass(frozen=True, slots=True)
class ResultArray:
    """One array of results: a quantity, or the error companion of one.

    Attributes
    ----------
    name
        Name of the array.
    quantity
        The quantity it belongs to.
    lengths
        Lengths of its axes after the design axis.
    dtype
        Stored type.
    long_name
        What it is, in a phrase.
    """

    name: str
    quantity: Quantity
    lengths: tuple[int, ...]
    dtype: np.dtype[Any]
    long_name: str

    @property
    def is_error(self) -> bool:
        """Whether it is the error companion of its quantity."""
        return self.name != self.quantity.name


@dataclasses.dataclass(frozen=True, slots=True)
class AxisColumn:
    """One labelled column along a non-design axis (``working_mode`` along ``mode``)."""

    name: str
    values: npt.NDArray[Any]
    unit: str
    long_name: str
    flags: Flags | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class Axis:
    """A non-design axis of the results.

    Attributes
    ----------
    name
        Name of the dimension: ``"mode"``, ``"threshold"``.
    labels
        One text for each entry, as the user writes it: ``"+-/up"``, ``"0.5"``.
    columns
        The datasets that describe the entries.
    """

    name: str
    labels: tuple[str, ...]
    columns: tuple[AxisColumn, ...]

    def __len__(self) -> int:
        return len(self.labels)


def plain(value: Any, flags: Flags | None = None) -> Any:
    """Return a value or an array as JSON knows it: NaN is None, a flag is its meaning."""
    if np.ndim(value):
        return [plain(entry, flags) for entry in value]
    if flags is not None:
        return flags.describe(int(value))
    # Adding 0.0 turns -0.0 into 0.0.
    return float(value) + 0.0 if np.isfinite(value) else None
