"""The Pareto front: designs of which none is better in one quantity and no worse in others."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.synthesis.candidates import Candidates
from fivebar_atlas.synthesis.conditions import SLACK, Condition
from fivebar_atlas.synthesis.maximise import maximise
from fivebar_atlas.synthesis.objectives import Objective

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

#: Quantities of a front with 1 where the larger is the better, -1 where the smaller is.
Directions = Sequence[tuple[str, float]]


@dataclasses.dataclass(frozen=True, slots=True)
class ParetoFront:
    """The front of several quantities.

    Attributes
    ----------
    names
        The quantities.
    signs
        1 where the larger is the better, -1 where the smaller is.
    designs
        Members of the front, shape (members, parameters), by the first quantity, best
        last.
    values, errors
        The quantities there and their error estimates, shape (names, members).
    candidates
        Number of designs that fulfil the conditions and have values.
    lattice_values
        Values on the lattice before members were moved to the true front, shape (names,
        members); where they were not moved, the values.
    """

    names: tuple[str, ...]
    signs: tuple[float, ...]
    designs: FloatArray
    values: FloatArray
    errors: FloatArray
    candidates: int
    lattice_values: FloatArray


def non_dominated(gains: FloatArray) -> IntArray:
    """Return which points no other point dominates, by more than rounding.

    Parameters
    ----------
    gains
        Finite numbers, the larger the better, shape (quantities, n).

    Returns
    -------
    ndarray
        Indices, rising in the first quantity. A point dominates another where it is
        nowhere less and somewhere greater, so equal points stay together. Values that are
        the same but for rounding count as equal.
    """
    gains = np.array([_without_rounding(row) for row in gains]).reshape(gains.shape)
    order = np.lexsort(gains[::-1])[::-1]
    if len(gains) == 2:
        return _two_quantities(gains, order)[::-1]
    # Whatever dominates a point comes before it in this order.
    remaining = gains[:, order]
    kept = []
    while len(order):
        first = remaining[:, :1]
        kept.append(order[0])
        dominated = np.all(remaining <= first, axis=0) & np.any(remaining < first, axis=0)
        dominated[0] = True
        remaining, order = remaining[:, ~dominated], order[~dominated]
    return np.array(kept[::-1], dtype=np.int64)


def _without_rounding(values: FloatArray) -> FloatArray:
    """Return values, each run of them that rounding alone keeps apart replaced by its least."""
    if not len(values):
        return values
    order = np.argsort(values, kind="stable")
    steps = np.diff(values[order]) > SLACK * float(np.max(np.abs(values)))
    starts = np.concatenate([[0], np.flatnonzero(steps) + 1])
    runs = np.concatenate([[0], np.cumsum(steps)])
    alike = np.empty_like(values)
    alike[order] = values[order][starts][runs]
    return alike


def _two_quantities(gains: FloatArray, order: IntArray) -> IntArray:
    """Return the front of two quantities from the points in falling order of the first."""
    first, second = gains[:, order]
    before = np.concatenate([[-np.inf], np.maximum.accumulate(second)[:-1]])
    better = second > before
    # Equal to the last better one, in both quantities.
    last = np.maximum.accumulate(np.where(better, np.arange(len(order)), 0))
    equal = (first == first[last]) & (second == second[last])
    return np.asarray(order[better | equal])


def pareto_front(candidates: Candidates, directions: Directions) -> ParetoFront:
    """Return the exact front of the designs of a lattice that fulfil conditions.

    Parameters
    ----------
    candidates
        The designs and the conditions.
    directions
        The quantities and which way is better.

    Returns
    -------
    ParetoFront
        Empty where no design fulfils the conditions and has all values.
    """
    names = tuple(name for name, _ in directions)
    signs = np.array([sign for _, sign in directions])
    values = candidates.values(names)
    usable = np.flatnonzero(candidates.fulfilled & np.isfinite(values).all(axis=0))
    front = usable[non_dominated(signs[:, np.newaxis] * values[:, usable])]
    return ParetoFront(
        names=names,
        signs=tuple(float(sign) for sign in signs),
        designs=candidates.atlas.designs[front],
        values=values[:, front],
        errors=candidates.errors(names)[:, front],
        candidates=len(usable),
        lattice_values=values[:, front],
    )


def polished_front(candidates: Candidates, front: ParetoFront) -> ParetoFront:
    """Move each member of a front onto the true front, by exact values.

    Parameters
    ----------
    candidates
        The designs and the conditions.
    front
        The front of the lattice.

    Returns
    -------
    ParetoFront
        For each member the design with the best last quantity among those that are no
        worse in the others (the epsilon-constraint method) and fulfil the conditions;
        members that others dominate then are left out.
    """
    if not len(front.designs):
        return front
    exact = candidates.exact(front.names)
    atlas = candidates.atlas
    names, signs = front.names, np.array(front.signs)
    points = atlas.mechanism.project(front.designs, atlas.settings.space)
    spans = np.array([float(np.ptp(row)) or 1.0 for row in front.values])
    objective = Objective(names[-1:], front.signs[-1:])
    rows = [exact.names.index(name) for name in names]
    starting = exact.values(points)[rows]
    moved = points.copy()
    for member, start in enumerate(points):
        bounds = [
            Condition(name, ">=" if sign > 0.0 else "<=", float(value))
            for name, sign, value in zip(names[:-1], signs[:-1], starting[:-1, member], strict=True)
        ]
        found = maximise(
            exact,
            objective,
            (*candidates.conditions, *bounds),
            np.concatenate([candidates.scales, spans[:-1]]),
            start[np.newaxis],
            spans[-1],
            trials=False,
        )
        if found is not None:
            moved[member] = found.point
    designs = exact.designs(moved)
    values, errors = exact.values_and_errors(designs)
    values, errors = values[rows], errors[rows]
    kept = non_dominated(signs[:, np.newaxis] * values)
    return dataclasses.replace(
        front,
        designs=designs[kept],
        values=values[:, kept],
        errors=errors[:, kept],
        lattice_values=front.values[:, kept],
    )
