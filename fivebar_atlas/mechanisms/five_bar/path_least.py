"""Where LCI and the distance from singular loci are least on a path, between its corners too."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.base import FloatArray
from fivebar_atlas.mechanisms.five_bar.loci import Lengths
from fivebar_atlas.mechanisms.five_bar.outline import usable_workspace_of
from fivebar_atlas.mechanisms.five_bar.path import (
    boundary_distances,
    check_path,
    checked_corners,
    columns,
)
from fivebar_atlas.mechanisms.five_bar.points import lci_at
from fivebar_atlas.mechanisms.mode_pairs import Signs, mode_label
from fivebar_atlas.mechanisms.planar import PathLeast

_GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))
# Way between samples where least values are looked for, and how many there are at most; the
# lowest ones that are closed in on; steps.
_SPACING, _MOST_SAMPLES = 5e-3, 100_000
_LOWS, _LEAST_STEPS = 8, 48


def least_on_path(
    lengths: Lengths, signs: Signs, points: npt.ArrayLike
) -> tuple[PathLeast, PathLeast]:
    """Return the least LCI and the least distance from a singular locus on a path.

    Between its corners too; parameters and exceptions are those of :func:`check_path`.

    Raises
    ------
    InputError
        If the path cannot be followed: there both go to 0.
    """
    corners = checked_corners(points)
    workspace = usable_workspace_of(lengths, signs)
    if workspace is None or check_path(lengths, signs, corners).fault is not None:
        raise InputError("points", len(corners), f"a path that {mode_label(signs)} can follow")
    return (
        _least_along(corners, lambda places: _lci(lengths, signs, places)),
        _least_along(corners, lambda places: boundary_distances(lengths, workspace, places)[0]),
    )


def _lci(lengths: Lengths, signs: Signs, points: FloatArray) -> FloatArray:
    """Return the LCI at points, shape (n, 2)."""
    values = np.empty(len(points))
    lci_at(*lengths, *columns(points), float(signs[0]), float(signs[1]), values)
    return values


def _least_along(corners: FloatArray, function: Callable[[FloatArray], FloatArray]) -> PathLeast:
    """Return where a continuous function is least on a path, between its corners too.

    The path is sampled; next to every sample that is lower than its neighbours, and among the
    lowest, golden sections close in on the least value.
    """
    run = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    spacing = max(_SPACING, float(run[-1]) / _MOST_SAMPLES)
    inner = np.linspace(0.0, run[-1], int(run[-1] / spacing) + 2)[1:-1]
    samples = np.union1d(run, inner)

    def at(places: FloatArray) -> FloatArray:
        return np.column_stack([np.interp(places, run, column) for column in corners.T])

    values = function(at(samples))
    padded = np.pad(values, 1, constant_values=np.inf)
    lows = np.flatnonzero((values <= padded[:-2]) & (values <= padded[2:]))
    lows = lows[np.argsort(values[lows], kind="stable")][:_LOWS]
    low, high = samples[np.maximum(lows - 1, 0)], samples[np.minimum(lows + 1, len(samples) - 1)]
    left, right = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    at_left, at_right = function(at(left)), function(at(right))
    for _ in range(_LEAST_STEPS):
        leftward = at_left < at_right
        low, high = np.where(leftward, low, left), np.where(leftward, right, high)
        fresh = np.where(leftward, low + _GOLDEN * (high - low), high - _GOLDEN * (high - low))
        at_fresh = function(at(fresh))
        left, right = np.where(leftward, fresh, right), np.where(leftward, left, fresh)
        at_left, at_right = (
            np.where(leftward, at_fresh, at_right),
            np.where(leftward, at_left, at_fresh),
        )
    places = np.concatenate([samples[lows], left])
    found = np.concatenate([values[lows], at_left])
    best = int(np.argmin(found))
    place = float(places[best])
    segment = min(int(np.searchsorted(run, place, side="right")) - 1, max(len(corners) - 2, 0))
    length = float(run[segment + 1] - run[segment]) if len(corners) > 1 else 0.0
    share = min(max((place - float(run[segment])) / length, 0.0), 1.0) if length > 0.0 else 0.0
    x, y = at(np.array([place]))[0]
    return PathLeast(float(found[best]), segment, share, (float(x), float(y)))
