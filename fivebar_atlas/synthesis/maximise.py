"""The best design under conditions: SLSQP from several starts, then a search by trial.

Objective and conditions are exact values of the mechanism. Whatever is returned was
evaluated and fulfils all conditions; the search by trial at the end needs no gradients, so
that kinks of a quantity do no harm.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.synthesis.conditions import Condition
from fivebar_atlas.synthesis.design_polygon import DesignPolygon
from fivebar_atlas.synthesis.exact_values import ExactValues
from fivebar_atlas.synthesis.objectives import Objective

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

#: A condition may be missed by rounding: this share of its scale.
SLACK = 1e-12

#: A condition is active where its margin is below this share of its scale.
ACTIVE = 1e-7

# Stands for values that do not exist; far below any scaled margin or objective.
_NOTHING = -1e3
_ROUNDS = 4
_ITERATIONS = 60
_FIRST_TRIAL, _LAST_TRIAL = 1e-4, 2e-9
_TRIAL_DIRECTIONS = 12
_TRIALS_EACH = 8
# Trials that gain less than this share of the objective's scale have found the optimum.
_GAIN = 1e-8


@dataclasses.dataclass(frozen=True, slots=True)
class Optimum:
    """The best design found.

    Attributes
    ----------
    point
        Its place in the chart, shape (2,).
    value
        The objective there.
    active
        Conditions that hold with equality.
    borders
        Borders of the design space that it lies on.
    """

    point: FloatArray
    value: float
    active: tuple[Condition, ...]
    borders: tuple[str, ...]


class _Search:
    """Objective and scaled margins at points of the chart; keeps the best point seen."""

    def __init__(
        self,
        exact: ExactValues,
        objective: Objective,
        conditions: Sequence[Condition],
        scales: FloatArray,
        span: float,
    ) -> None:
        self.exact = exact
        self.conditions = conditions
        self.polygon = exact.polygon
        self.best: FloatArray | None = None
        self.best_value = -np.inf
        self._objective = objective
        self._scales = scales
        self._span = span
        self._places = [exact.names.index(name) for name in objective.names]
        self._rows = [exact.names.index(condition.quantity) for condition in conditions]
        self._last = np.full(2, np.nan)
        self._last_values = np.empty(0)

    def rows(self, values: FloatArray) -> FloatArray:
        """Return objective and margins, scaled, for values of shape (names, n)."""
        rows = [self._objective.value(values[self._places]) / self._span]
        for condition, row, scale in zip(self.conditions, self._rows, self._scales, strict=True):
            rows.append(condition.margin(values[row]) / scale)
        return np.array(rows)

    def try_points(self, points: FloatArray) -> bool:
        """Evaluate points of the design space; return whether one is better than all before."""
        points = self.polygon.clip(points)
        rows = self.rows(self.exact.values(points))
        feasible = np.isfinite(rows[0]) & np.all(rows[1:] >= -SLACK, axis=0)
        if not feasible.any():
            return False
        place = int(np.argmax(np.where(feasible, rows[0], -np.inf)))
        if rows[0, place] <= self.best_value:
            return False
        self.best, self.best_value = points[place].copy(), float(rows[0, place])
        return True

    def at(self, point: FloatArray) -> FloatArray:
        """Return objective and margins at one point; remembers the last one."""
        if not np.array_equal(point, self._last):
            self._last = point.copy()
            self._last_values = self.exact.values(point[np.newaxis])
            rows = self.rows(self._last_values)[:, 0]
            inside = self.polygon.contains(point[np.newaxis])[0]
            if inside and np.all(rows[1:] >= -SLACK) and rows[0] > self.best_value:
                self.best = self.polygon.clip(point[np.newaxis])[0]
                self.best_value = float(rows[0])
        rows = self.rows(self._last_values)[:, 0]
        return np.where(np.isfinite(rows), rows, _NOTHING)

    def slopes_at(self, point: FloatArray) -> FloatArray:
        """Return the gradients of objective and margins at one point, shape (rows, 2)."""
        self.at(point)
        inside = self.polygon.clip(point[np.newaxis])
        gradients = self.exact.gradients(inside, self._last_values)[:, 0, :]
        # Objective and margins are linear in the values.
        zero = self.rows(np.zeros((len(gradients), 1)))
        slopes = self.rows(gradients) - zero
        return np.where(np.isfinite(slopes), slopes, 0.0)


def maximise(
    exact: ExactValues,
    objective: Objective,
    conditions: Sequence[Condition],
    scales: FloatArray,
    starts: FloatArray,
    span: float = 1.0,
    *,
    trials: bool = True,
) -> Optimum | None:
    """Return the best design that fulfils conditions, by exact values.

    Parameters
    ----------
    exact
        Values of all quantities in the objective and the conditions.
    objective
        What is to be as large as possible.
    conditions
        Conditions; strict ones are taken as not strict.
    scales
        The scale of each condition's margin, shape (conditions,).
    starts
        Points of the chart to start from, best first, shape (n, 2).
    span
        The scale of the objective.
    trials
        Whether to search around the best point by trial at the end.

    Returns
    -------
    Optimum or None
        None where no start leads to a design that fulfils the conditions. The same inputs
        give the same design.
    """
    search = _Search(exact, objective, conditions, scales, span)
    if len(starts):
        search.try_points(starts)
    for start in starts:
        _climb(search, start)
    if search.best is None:
        return None
    for _ in range(_ROUNDS if trials else 0):
        before = search.best_value
        _try_around(search)
        if search.best_value - before <= _GAIN:
            break
        # Where no gradient led on at first (at a summit of a bounded quantity), one may now.
        _climb(search, search.best)
    return _optimum(search, objective)


def _climb(search: _Search, start: FloatArray) -> None:
    """Run SLSQP; where it ends beyond a bound, again with bounds moved inward."""
    from scipy.optimize import minimize

    polygon, count = search.polygon, len(search.conditions)
    point, inward = start, 0.0
    for _ in range(_ROUNDS):
        shift = np.full(count, inward)
        constraints = [
            {
                "type": "ineq",
                "fun": lambda p: polygon.distances(p[np.newaxis])[0],
                "jac": lambda p: polygon.normals,  # noqa: ARG005
            }
        ]
        if count:
            constraints.append(
                {
                    "type": "ineq",
                    "fun": lambda p, shift=shift: search.at(p)[1:] - shift,
                    "jac": lambda p: search.slopes_at(p)[1:],
                }
            )
        result = minimize(
            lambda p: -search.at(p)[0],
            point,
            jac=lambda p: -search.slopes_at(p)[0],
            method="SLSQP",
            constraints=constraints,
            options={"maxiter": _ITERATIONS, "ftol": 1e-13},
        )
        if not np.all(np.isfinite(result.x)):
            return
        point = polygon.clip(np.asarray(result.x)[np.newaxis])[0]
        missed = float(np.max(-search.at(point)[1:], initial=0.0))
        if missed <= SLACK:
            search.try_points(point[np.newaxis])
            return
        if missed > 1e-3:
            return
        inward += 2.0 * missed + 1e-12


def _try_around(search: _Search) -> None:
    """Try points around the best one, ever closer, and the nearest ones on the border."""
    step, turn = _FIRST_TRIAL, 0.0
    while step >= _LAST_TRIAL:
        for _ in range(_TRIALS_EACH):
            assert search.best is not None
            angles = turn + np.linspace(0.0, 2.0 * np.pi, _TRIAL_DIRECTIONS, endpoint=False)
            ring = search.best + step * np.column_stack([np.cos(angles), np.sin(angles)])
            if not search.try_points(np.vstack([ring, search.polygon.feet(search.best, step)])):
                break
        step *= 0.4
        turn += 0.4


def _optimum(search: _Search, objective: Objective) -> Optimum:
    assert search.best is not None
    exact, point = search.exact, search.best
    values = exact.values(point[np.newaxis])
    margins = search.rows(values)[1:, 0]
    polygon: DesignPolygon = exact.polygon
    touched = np.abs(polygon.distances(point[np.newaxis])[0]) <= 1e-8
    pairs = zip(polygon.names(exact.mechanism), touched, strict=True)
    places = [exact.names.index(name) for name in objective.names]
    return Optimum(
        point=point,
        value=float(objective.value(values[places])[0]),
        active=tuple(
            condition
            for condition, margin in zip(search.conditions, margins, strict=True)
            if margin <= ACTIVE
        ),
        borders=tuple(name for name, touches in pairs if touches),
    )


def local_maxima(
    values: FloatArray, feasible: BoolArray, triangles: npt.NDArray[np.int64], count: int
) -> npt.NDArray[np.int64]:
    """Return the designs of a lattice that no neighbour surpasses, best first.

    Parameters
    ----------
    values
        The objective, shape (n,).
    feasible
        Designs that may be chosen, shape (n,).
    triangles
        The triangulation that says which designs are neighbours, shape (m, 3).
    count
        How many at most.
    """
    usable = np.where(feasible & np.isfinite(values), values, -np.inf)
    highest = usable.copy()
    for first in range(3):
        for second in range(3):
            np.maximum.at(highest, triangles[:, first], usable[triangles[:, second]])
    tops = np.flatnonzero((usable >= highest) & np.isfinite(usable))
    return tops[np.argsort(-usable[tops], kind="stable")][:count]
