"""Round levels for contour maps, and how they are written."""

from __future__ import annotations

import math
from decimal import Decimal

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

#: Steps between levels, times a power of ten.
ROUND_STEPS = (1.0, 2.0, 2.5, 5.0)


def round_levels(least: float, greatest: float, bands: int = 15) -> FloatArray:
    """Return equally spaced round levels that enclose a range of values.

    Parameters
    ----------
    least, greatest
        Range of the values, both finite, the second greater.
    bands
        Greatest number of bands between levels.

    Returns
    -------
    ndarray
        Ascending multiples of 1, 2, 2.5 or 5 times a power of ten, the first at or below
        ``least``, the last at or above ``greatest``, at least two. The finest step is
        taken that needs no more than ``bands`` bands.
    """
    exponent = math.floor(math.log10((greatest - least) / bands)) - 1
    while True:
        for step in ROUND_STEPS:
            levels = _multiples(least, greatest, step, exponent)
            if len(levels) - 1 <= bands:
                return levels
        exponent += 1


def _multiples(least: float, greatest: float, step: float, exponent: int) -> FloatArray:
    # In decimals, so that each level is the double nearest to what is written.
    width = Decimal(str(step)).scaleb(exponent)
    # Values a rounding error beyond a level belong to it, not to a band of their own.
    slack = 1e-6
    first = math.floor(least / float(width) + slack)
    last = max(math.ceil(greatest / float(width) - slack), first + 1)
    return np.array([float(count * width) for count in range(first, last + 1)])


def magnitude_levels(least: float, greatest: float, bands: int = 12) -> FloatArray:
    """Return levels that rise by round factors and enclose a range of positive values.

    Parameters
    ----------
    least, greatest
        Range of the values, both positive and finite.
    bands
        Greatest number of bands between levels.

    Returns
    -------
    ndarray
        Ascending, at least two: 1, 2 and 5 times powers of ten where those are few
        enough, else powers of ten, else every k-th of them.
    """
    first = math.floor(math.log10(least) + 1e-9)
    last = max(math.ceil(math.log10(greatest) - 1e-9), first + 1)
    fine = [float(f"{digit}e{power}") for power in range(first, last) for digit in (1, 2, 5)]
    fine.append(float(f"1e{last}"))
    # Of the fine levels, only those around the values.
    below = max(index for index, level in enumerate(fine[:-1]) if level <= least * (1 + 1e-9))
    above = min(index for index, level in enumerate(fine) if level >= greatest * (1 - 1e-9))
    fine = fine[below : max(above, below + 1) + 1]
    if len(fine) - 1 <= min(bands, 6):
        return np.array(fine)
    step = math.ceil((last - first) / bands)
    count = math.ceil((last - first) / step)
    return np.array([float(f"1e{first + index * step:d}") for index in range(count + 1)])


def magnitude_text(level: float) -> str:
    """Return a level of :func:`magnitude_levels` as mathtext."""
    digit, _, power = f"{level:.0e}".partition("e")
    factor = "" if digit == "1" else rf"{digit}\!\times\!"
    return rf"${factor}10^{{{int(power)}}}$"


def level_text(level: float, levels: FloatArray) -> str:
    """Return a level as text, with the decimals its neighbours need.

    Parameters
    ----------
    level
        One of ``levels``.
    levels
        All levels of the map, equally spaced.
    """
    step = float(np.min(np.diff(levels)))
    decimals = next(
        places for places in range(13) if abs(round(step, places) - step) <= 1e-6 * step
    )
    text = f"{level:.{decimals}f}"
    # A zero without a sign, and the typographic minus.
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "\N{MINUS SIGN}")
