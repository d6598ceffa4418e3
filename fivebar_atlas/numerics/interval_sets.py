"""Unions of disjoint intervals, in their order, for kernels."""

from __future__ import annotations

from typing import Any

import numpy as np

from fivebar_atlas.jit import kernel
from fivebar_atlas.numerics.records import record_type

#: Most intervals of a set. One that is removed adds at most one to them.
MOST = 32

#: A set of ``count[0]`` intervals from ``start`` to ``stop``, rising.
INTERVALS = record_type(
    ("count", np.int64, (1,)),
    ("start", np.float64, (MOST,)),
    ("stop", np.float64, (MOST,)),
)

Intervals = Any


@kernel
def set_interval(s: Intervals, start: float, stop: float) -> None:
    """Make the set one closed interval, or empty where the start is above the stop."""
    s.count[0] = 1 if start <= stop else 0
    s.start[0], s.stop[0] = start, stop


@kernel
def remove_interval(s: Intervals, start: float, stop: float) -> None:
    """Take an open interval away; what is left of a full set of MOST loses its last interval."""
    if not start < stop:
        return
    kept = 0
    for i in range(s.count[0]):
        a, b = s.start[i], s.stop[i]
        if a <= start and b >= stop:
            # only this one is cut, and those after it move up
            for j in range(min(s.count[0], MOST - 1), i, -1):
                s.start[j], s.stop[j] = s.start[j - 1], s.stop[j - 1]
            s.stop[i] = start
            if i + 1 < MOST:
                s.start[i + 1], s.stop[i + 1] = stop, b
            s.count[0] = min(s.count[0] + 1, MOST)
            return
        if a >= start and b <= stop and a < stop and b > start:
            continue
        if a < start < b:
            b = start
        elif a < stop < b:
            a = stop
        s.start[kept], s.stop[kept] = a, b
        kept += 1
    s.count[0] = kept


@kernel
def total_length(s: Intervals) -> float:
    """Return the length of the set."""
    total = 0.0
    for i in range(s.count[0]):
        total += s.stop[i] - s.start[i]
    return total


@kernel
def point_at(s: Intervals, length: float) -> float:
    """Return the point of a set that is not empty below which this much of its length is."""
    for i in range(s.count[0]):
        piece = s.stop[i] - s.start[i]
        if length <= piece:
            return float(s.start[i] + length)
        length -= piece
    return float(s.stop[s.count[0] - 1])


@kernel
def nearest_point(s: Intervals, x: float) -> float:
    """Return the point nearest to x of a set that is not empty."""
    best = s.start[0]
    for i in range(s.count[0]):
        here = min(max(x, s.start[i]), s.stop[i])
        if abs(here - x) < abs(best - x):
            best = here
    return float(best)
