"""Points of the pose box and their scramblings: the same ones in every process.

Sobol points (Sobol 1967) with independent random scramblings (Matoušek 1998, as SciPy has them):
each scrambling gives an unbiased estimate, and the scatter of these tells the error (Owen 1997).
"""

from __future__ import annotations

import math
import threading

import numpy as np

from fivebar_atlas.mechanisms.arrays import FloatArray

#: Independent scramblings.
SCRAMBLINGS = 16
#: Coordinates of a point: the five free ones of a pose, and one that chooses a pose on its line.
DIMENSIONS = 6
#: Points of each scrambling at level 0.
FIRST_POINTS = 256

_SEED = 20170125
_LOCK = threading.Lock()
_LEVELS: list[FloatArray] = []
_DEVIATES: list[FloatArray] = []


def points_up_to(level: int) -> int:
    """Return how many points of a scrambling there are up to a level, that level included.

    256 times 1, 2, 3, 4, 6, 8, 12, 16, ...: powers of two, at which Sobol points are balanced best,
    and one number between two of them, lest the last doubling be for nothing.
    """
    if level < 2:
        return FIRST_POINTS << level
    power, is_power = divmod(level, 2)
    return FIRST_POINTS * ((2 << power) if is_power else (3 << (power - 1)))


def points_of_level(level: int) -> FloatArray:
    """Return the points that a level adds to those of all levels before.

    Parameters
    ----------
    level
        From 0.

    Returns
    -------
    ndarray
        In the unit cube, shape (SCRAMBLINGS, n, DIMENSIONS), read-only, kept for the process.
    """
    with _LOCK:
        if level >= len(_LEVELS):
            # scipy.stats takes a second to import, which only those who compute should wait for
            from scipy.stats import qmc

            streams = np.random.SeedSequence(_SEED).spawn(SCRAMBLINGS)
            # powers of two, as SciPy wants them
            total = 1 << math.ceil(math.log2(points_up_to(level)))
            # the argument is named rng since SciPy 1.15, and seed goes on to be taken
            samples = np.stack(
                [
                    qmc.Sobol(DIMENSIONS, seed=np.random.default_rng(stream)).random(total)
                    for stream in streams
                ]
            )
            for each in range(len(_LEVELS), level + 1):
                start = 0 if each == 0 else points_up_to(each - 1)
                part = np.ascontiguousarray(samples[:, start : points_up_to(each)])
                part.flags.writeable = False
                _LEVELS.append(part)
        return _LEVELS[level]


def deviates() -> FloatArray:
    """Return random numbers for searches, shape (997, 5), read-only, kept for the process."""
    with _LOCK:
        if not _DEVIATES:
            made = np.random.default_rng(_SEED).normal(size=(997, 5))
            made.flags.writeable = False
            _DEVIATES.append(made)
        return _DEVIATES[0]
