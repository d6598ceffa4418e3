"""How far the inputs turn over a usable workspace, for every angle of the passive leg (Fig. 9).

Along the passive leg an input changes by ∂φ_i/∂l = q_i / j_i: its extremes are at the ends of the
usable intervals of l and where an upper link is level with the platform, q_i = 0, both of which are
known in closed form or to rounding.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.passive_leg.outline import UsableWorkspace, level_curves
from fivebar_atlas.mechanisms.passive_leg.poses import INPUT_SYMBOLS
from fivebar_atlas.mechanisms.planar import RADIANS, OperatingLimits

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.passive_leg.passive_leg import PassiveLeg

# Angles from one to the next of which inputs turn by less than half a turn, and points along an
# interval of l with the same property.
_ANGLES, _POINTS = 240, 25
# Share of its largest length by which the ends of an interval are moved inward, more than what they
# are rounded by, so that both legs reach; 4e-7 of an input where a leg is stretched.
_INWARD = 1e-13
# Closer to O rounding takes legs that are folded in all poses there out of reach.
_AT_O = 1e-6


def operating_limits(design: PassiveLeg, mode: str, count: int) -> OperatingLimits:
    """Return the least and the greatest inputs for angles of the passive leg.

    Parameters
    ----------
    design
        The design.
    mode
        Canonical label of a mode pair.
    count
        Number of angles, at least 2.

    Returns
    -------
    OperatingLimits
        Inputs are continuous in θ; those at the middle angle are in about (-π, π].
    """
    places = np.linspace(-design.theta_limit, design.theta_limit, count)
    least, greatest = np.full((count, 2), np.nan), np.full((count, 2), np.nan)
    workspace = design.usable_workspace(mode)
    if workspace is not None:
        steps = np.linspace(-design.theta_limit, design.theta_limit, _ANGLES + 1)
        before: list[_Interval] = []
        for theta in np.union1d(places, steps).tolist():
            here = [
                interval.continuing(before)
                for interval in _intervals(design, workspace, mode, theta)
            ]
            before = here
            place = int(np.searchsorted(places, theta))
            if here and place < count and places[place] == theta:
                together = np.concatenate([interval.inputs for interval in here])
                least[place], greatest[place] = together.min(axis=0), together.max(axis=0)
        _bring_back(least, greatest)
    return OperatingLimits(
        r"$\theta$", "angle of the passive leg", RADIANS, places, least, greatest, INPUT_SYMBOLS
    )


def _bring_back(least: FloatArray, greatest: FloatArray) -> None:
    """Turn the inputs by full turns, so that in the middle they are about those in (-π, π]."""
    reached = np.flatnonzero(~np.isnan(least[:, 0]))
    if len(reached):
        middle = reached[len(reached) // 2]
        turns = np.round(0.5 * (least[middle] + greatest[middle]) / (2.0 * math.pi))
        least -= 2.0 * math.pi * turns
        greatest -= 2.0 * math.pi * turns


@dataclasses.dataclass(frozen=True, eq=False)
class _Interval:
    """An interval of l at one angle: lengths, shape (n,), and continuous inputs, shape (n, 2)."""

    lengths: FloatArray
    inputs: FloatArray

    def overlap(self, other: _Interval) -> tuple[float, float]:
        """Return the lengths that two intervals have in common."""
        return (
            max(float(self.lengths[0]), float(other.lengths[0])),
            min(float(self.lengths[-1]), float(other.lengths[-1])),
        )

    def at(self, length: float) -> FloatArray:
        """Return about the inputs at a length."""
        return np.array([np.interp(length, self.lengths, column) for column in self.inputs.T])

    def continuing(self, before: list[_Interval]) -> _Interval:
        """Return the interval with inputs that go on from the nearest one of the angle before."""
        if not before:
            return self
        nearest = max(before, key=lambda other: np.subtract(*self.overlap(other)[::-1]))
        middle = 0.5 * sum(self.overlap(nearest))
        turns = np.round((nearest.at(middle) - self.at(middle)) / (2.0 * math.pi))
        return _Interval(self.lengths, self.inputs + 2.0 * math.pi * turns)


def _intervals(
    design: PassiveLeg, workspace: UsableWorkspace, mode: str, theta: float
) -> list[_Interval]:
    """Return the usable intervals at an angle."""
    levels = np.array(
        [
            float(curve.lengths(np.array([theta]), sheet)[0])
            for curve in level_curves(workspace.part.lengths)
            for sheet in (1.0, -1.0)
        ]
    )
    found = []
    for low, high in workspace.part.intervals(theta):
        inward = min(_INWARD * high, 0.25 * (high - low))
        start, end = max(low + inward, _AT_O), high - inward
        share = np.linspace(0.0, 1.0, _POINTS)
        evenly = start + (end - start) * share**2 * (3.0 - 2.0 * share)
        if not start < end:
            continue
        lengths = np.union1d(evenly, levels[(levels > evenly[0]) & (levels < evenly[-1])])
        angles = design.inputs(-lengths * math.sin(theta), lengths * math.cos(theta), mode)
        is_there = ~np.isnan(angles[:, 0])
        if np.count_nonzero(is_there) > 1:
            found.append(_Interval(lengths[is_there], np.unwrap(angles[is_there], axis=0)))
    return found
