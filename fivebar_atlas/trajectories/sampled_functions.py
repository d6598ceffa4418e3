"""Functions of time through samples: quintic splines, and how well samples determine them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from fivebar_atlas.errors import MotionError
from fivebar_atlas.mechanisms.arrays import FloatArray

#: Fewest samples: every other one must still make a quintic spline.
FEWEST = 12
#: Difference of accelerations, as a share of the largest, that samples may leave open.
ACCELERATION_TOLERANCE = 0.05

_DEGREE = 5
# Accelerations below this share of the values over the square of a step are rounding.
_ROUNDING = 1e-12


@dataclasses.dataclass(frozen=True, eq=False)
class SampledFunctions:
    """Functions of time through samples.

    Attributes
    ----------
    spline
        The quintic spline, of several values.
    velocity_errors, acceleration_errors
        By how much first and second derivatives differ from those of the spline through every
        other sample, at most, shape (functions,): an estimate of their errors on the safe side,
        since the finer spline is nearer.
    """

    spline: Any
    velocity_errors: FloatArray
    acceleration_errors: FloatArray


def through_samples(
    times: FloatArray,
    values: FloatArray,
    names: Sequence[str],
    units: Sequence[str],
    time_unit: str,
    tolerance: float = ACCELERATION_TOLERANCE,
) -> SampledFunctions:
    """Return smooth functions through samples.

    Parameters
    ----------
    times, values
        Rising, shape (n,), and shape (n, functions).
    names, units, time_unit
        What the functions are called, for messages.
    tolerance
        Difference of accelerations, as a share of the largest, that samples may leave open.

    Raises
    ------
    MotionError
        If there are too few samples, or they do not determine accelerations to the tolerance: a
        jump, a kink, too few digits or too long steps.
    """
    # Imported where it is needed: motions by functions do not wait for it.
    from scipy.interpolate import make_interp_spline

    if len(times) < FEWEST:
        raise MotionError(
            f"the motion is too short: it has {len(times)} samples, and accelerations need at "
            f"least {FEWEST}"
        )
    fine = make_interp_spline(times, values, k=_DEGREE)
    coarse = make_interp_spline(times[::2], values[::2], k=_DEGREE)
    inside = times <= times[::2][-1]
    seen = times[inside]
    accelerations = fine(seen, 2)
    halved = coarse(seen, 2)
    change = np.abs(accelerations - halved)
    size = np.abs(values).max(axis=0) / float(np.diff(times).min()) ** 2
    allowed = tolerance * np.abs(accelerations).max(axis=0) + _ROUNDING * size
    worst = change.max(axis=0)
    bad = np.flatnonzero(worst > allowed)
    if len(bad):
        column = int(bad[np.argmax(worst[bad] / allowed[bad])])
        place = int(np.argmax(change[:, column]))
        unit = f"{units[column]}/{time_unit}²"
        raise MotionError(
            f"{names[column]} is not smooth enough, or has too few samples or digits, for "
            f"accelerations: near t = {seen[place]:.6g} {time_unit} (sample {place}) they are "
            f"{accelerations[place, column]:.6g} {unit} by all samples and "
            f"{halved[place, column]:.6g} {unit} by every other one; at most "
            f"{100.0 * tolerance:g} % of the largest is tolerated (motion.acceleration_tolerance)",
            float(seen[place]),
        )
    velocities = np.abs(fine(seen, 1) - coarse(seen, 1)).max(axis=0)
    return SampledFunctions(fine, velocities, worst)
