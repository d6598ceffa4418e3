"""The best design under conditions: ever finer lattices, SLSQP, then a search by trial.

Objective and conditions are exact values of the mechanism. Whatever is returned was
evaluated and fulfils all conditions; the search by trial at the end needs no gradients, so
that kinks of a quantity do no harm. All but the end is done with a looser tolerance.

Values that only hold to a tolerance, such as means over sampled poses, jump by less than it from
design to design. The steps of the mechanism are so wide that these jumps do not mislead; what is
returned is then an optimum to within the errors of its values.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.synthesis.conditions import SLACK, Condition
from fivebar_atlas.synthesis.exact_values import LEAST_MARGIN, ExactValues
from fivebar_atlas.synthesis.local_lattices import explored
from fivebar_atlas.synthesis.objectives import Objective

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

#: A condition is active where its margin is below this share of its scale, or below the error of
#: a value that is not as good as exact.
ACTIVE = 1e-7

# Stands for values that do not exist; far below any scaled margin or objective.
_NOTHING = -1e3
# What a scaled margin that is missed counts in the ranking of places to start from.
_PENALTY = 10.0
_ROUNDS = 4
# Evaluations that SLSQP may take at kinks, its iterations, and a gain that ends it.
_EVALUATIONS, _ITERATIONS, _GAIN_OF_CLIMB = 200, 60, 1e-13
_FEW_EVALUATIONS, _FEW_ITERATIONS, _GAIN_OF_SEARCH = 60, 30, 1e-9
# Trials are within this share of the step of differences, the last of them: of exact values, and
# of those that hold to a tolerance of which a climb need not gain less than a share.
_LAST_EXACT_TRIAL, _LAST_TRIAL, _LEAST_GAIN = 2e-5, 1e-2, 1e-2
_TRIAL_DIRECTIONS = 12
_TRIALS_EACH = 8
# How much further a trial that was better leads.
_FURTHER = 2.0 ** np.arange(1.0, 9.0)[:, np.newaxis]
# Trials that gain less than this share of the objective's scale have found the optimum, and a
# gain of less than this is rounding.
_GAIN, _NO_GAIN = 1e-8, 1e-11
# How far a point is moved to fulfil conditions that it misses by rounding.
_NUDGES = 10.0 ** np.arange(-15.0, -9.0)
# Within this distance of a border without values nothing is attained.
_NEAR = 10.0 * LEAST_MARGIN


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
    is_attained
        False next to a border without values: better designs may lie closer to it.
    """

    point: FloatArray
    value: float
    active: tuple[Condition, ...]
    borders: tuple[str, ...]
    is_attained: bool


class _Exhausted(Exception):  # noqa: N818
    """SLSQP has taken as many evaluations as it may."""


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
        # The least scaled margins: what is strict must be exceeded by more than rounding.
        self.limits = np.array([2.0 * SLACK if each.is_strict else -SLACK for each in conditions])
        self._objective = objective
        self._scales = scales
        self._span = span
        self._places = [exact.names.index(name) for name in objective.names]
        self._rows = [exact.names.index(condition.quantity) for condition in conditions]
        #: Evaluations at single points that are left.
        self.left = 0
        self._last = np.full(2, np.nan)
        self._last_values = np.empty(0)

    def rows(self, values: FloatArray) -> FloatArray:
        """Return objective and margins, scaled, for values of shape (names, n)."""
        rows = [self._objective.value(values[self._places]) / self._span]
        for condition, row, scale in zip(self.conditions, self._rows, self._scales, strict=True):
            rows.append(condition.margin(values[row]) / scale)
        return np.array(rows)

    def margin_errors(self, errors: FloatArray) -> FloatArray:
        """Return the errors of scaled margins, for errors of values, shape (names,)."""
        return np.nan_to_num(errors[self._rows]) / self._scales

    def evaluate(self, points: FloatArray) -> FloatArray:
        """Return the rows at points of the design space; take note of the best of them."""
        rows = self.rows(self.exact.values(points))
        feasible = np.isfinite(rows[0]) & np.all(rows[1:] >= self.limits[:, np.newaxis], axis=0)
        if feasible.any():
            place = int(np.argmax(np.where(feasible, rows[0], -np.inf)))
            if rows[0, place] > self.best_value:
                self.best, self.best_value = points[place].copy(), float(rows[0, place])
        return rows

    def try_points(self, points: FloatArray) -> bool:
        """Evaluate points; return whether one is better than all before, beyond rounding."""
        before = self.best_value
        self.evaluate(self.polygon.clip(points))
        return self.best_value > before + _NO_GAIN

    def scores(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how good points are if they are feasible, and with penalties if they are not."""
        rows = self.evaluate(points)
        missed = np.maximum(self.limits[:, np.newaxis] - rows[1:], 0.0).sum(axis=0)
        objective = np.where(np.isfinite(rows[0]) & np.isfinite(missed), rows[0], -np.inf)
        return np.where(missed > 0.0, -np.inf, objective), objective - _PENALTY * missed

    def at(self, point: FloatArray) -> FloatArray:
        """Return objective and margins at one point; remembers the last one."""
        if not np.array_equal(point, self._last):
            if not self.left:
                raise _Exhausted
            self.left -= 1
            self._last = point.copy()
            self._last_values = self.exact.values(point[np.newaxis])
            rows = self.rows(self._last_values)[:, 0]
            inside = self.polygon.contains(point[np.newaxis])[0]
            if inside and np.all(rows[1:] >= self.limits) and rows[0] > self.best_value:
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
    spacing: float = 0.0,
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
        Conditions; what is strict must be exceeded by more than rounding.
    scales
        The scale of each condition's margin, shape (conditions,).
    starts
        Points of the chart to start from, best first, shape (n, 2).
    span
        The scale of the objective.
    spacing
        How far apart in the chart starts may be from better places: so far around them, and
        along the border of the design space, these are looked for. 0 for not at all.
    trials
        Whether to search around the best point by trial at the end.

    Returns
    -------
    Optimum or None
        None where no start leads to a design that fulfils the conditions. The same inputs
        give the same design.
    """
    whole, exact = exact, exact.inside()
    if spacing > 0.0 and len(starts):
        survey = _Search(exact.for_survey(), objective, conditions, scales, span)
        finest = exact.mechanism.exact_step
        starts = explored(survey.scores, exact.polygon, starts, spacing, finest)
    rough = _Search(exact.for_search(), objective, conditions, scales, span)
    if len(starts):
        rough.try_points(starts)
    least = 0.0 if exact.is_exact else _LEAST_GAIN * exact.settings.tolerance
    few = _FEW_EVALUATIONS, _FEW_ITERATIONS, max(_GAIN_OF_SEARCH, least)
    many = _EVALUATIONS, _ITERATIONS, max(_GAIN_OF_CLIMB, least)
    ends = [_climb(rough, start, *few) for start in starts]
    if rough.best is not None:
        ends.append(rough.best)
    search = _Search(exact, objective, conditions, scales, span)
    places = np.array([*ends, *starts]).reshape(-1, 2)
    if len(places):
        search.try_points(places)
    is_open = search.best is not None and not _is_attained(whole, exact, objective, search.best)
    if not is_open:
        for end in ends if search.best is None else [search.best]:
            _climb(search, end, *many)
    if search.best is None:
        return None
    for _ in range(_ROUNDS if trials and not is_open else 0):
        before = search.best_value
        _try_around(search)
        if search.best_value - before <= max(_GAIN, least):
            break
        # Where no gradient led on at first (at a summit of a bounded quantity), one may now.
        _climb(search, search.best, *many)
    point = _nudged(search)
    return _optimum(search, objective, point, _is_attained(whole, exact, objective, point))


def _climb(
    search: _Search, start: FloatArray, evaluations: int, iterations: int, gain: float
) -> FloatArray:
    """Run SLSQP; where it ends beyond a bound, again with bounds moved inward.

    Returns
    -------
    ndarray
        Where it ends, which need not fulfil all conditions.
    """
    from scipy.optimize import minimize

    polygon = search.polygon
    search.left = evaluations
    point: FloatArray = start
    limits = search.limits + SLACK
    for _ in range(_ROUNDS):
        constraints = [
            {
                "type": "ineq",
                "fun": lambda p: polygon.distances(p[np.newaxis])[0],
                "jac": lambda p: polygon.normals,  # noqa: ARG005
            }
        ]
        if len(limits):
            constraints.append(
                {
                    "type": "ineq",
                    "fun": lambda p, limits=limits: search.at(p)[1:] - limits,
                    "jac": lambda p: search.slopes_at(p)[1:],
                }
            )
        try:
            result = minimize(
                lambda p: -search.at(p)[0],
                point,
                jac=lambda p: -search.slopes_at(p)[0],
                method="SLSQP",
                constraints=constraints,
                options={"maxiter": iterations, "ftol": gain},
            )
        except _Exhausted:
            return point
        if not np.all(np.isfinite(result.x)):
            return point
        point = np.array(polygon.clip(np.asarray(result.x)[np.newaxis])[0], dtype=np.float64)
        margins = search.rows(search.exact.values(point[np.newaxis]))[1:, 0]
        missed = float(np.max(search.limits - margins, initial=0.0))
        if missed <= 0.0:
            search.try_points(point[np.newaxis])
            return point
        if not missed <= 1e-3:
            return point
        limits = limits + 2.0 * missed + 1e-12
    return point


def _try_around(search: _Search) -> None:
    """Try points around the best one, ever closer, and the nearest ones on the border.

    Where one is better, those further on in the same direction, too: along a ridge they are.
    """
    exact = search.exact
    step, turn = exact.mechanism.exact_step, 0.0
    last = step * (_LAST_EXACT_TRIAL if exact.is_exact else _LAST_TRIAL)
    while step >= last:
        for _ in range(_TRIALS_EACH):
            before = search.best
            assert before is not None
            angles = turn + np.linspace(0.0, 2.0 * np.pi, _TRIAL_DIRECTIONS, endpoint=False)
            ring = before + step * np.column_stack([np.cos(angles), np.sin(angles)])
            if not search.try_points(np.vstack([ring, search.polygon.feet(before, step)])):
                break
            assert search.best is not None
            search.try_points(search.best + _FURTHER * (search.best - before))
        step *= 0.4
        turn += 0.4


def _nudged(search: _Search) -> FloatArray:
    """Return the best point, or where it misses a condition by rounding one next to it.

    That fulfils all conditions to the last digit and is worse by rounding only; where there
    is none (a bound from both sides), the best point itself.
    """
    best = search.best
    assert best is not None
    margins = search.rows(search.exact.values(best[np.newaxis]))[1:, 0]
    if bool(np.all(margins >= 0.0)):
        return best
    angles = np.linspace(0.0, 2.0 * np.pi, _TRIAL_DIRECTIONS, endpoint=False)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    points = search.polygon.clip((best + _NUDGES[:, None, None] * ring).reshape(-1, 2))
    rows = search.rows(search.exact.values(points))
    limits = np.maximum(search.limits, 0.0)[:, np.newaxis]
    fulfils = np.isfinite(rows[0]) & np.all(rows[1:] >= limits, axis=0)
    values = np.where(fulfils, rows[0], -np.inf)
    place = int(np.argmax(values))
    is_as_good = bool(values[place] >= search.best_value - _GAIN)
    return np.array(points[place]) if is_as_good else best


def _optimum(
    search: _Search, objective: Objective, point: FloatArray, is_attained: bool
) -> Optimum:
    exact, polygon = search.exact, search.polygon
    values, errors = exact.values_and_errors(exact.designs(point[np.newaxis]))
    margins = search.rows(values)[1:, 0]
    allowed = ACTIVE + (0.0 if exact.is_exact else search.margin_errors(errors[:, 0]))
    touched = np.abs(polygon.distances(point[np.newaxis])[0]) <= 1e-8
    pairs = zip(polygon.names(exact.mechanism, exact.settings.space), touched, strict=True)
    places = [exact.names.index(name) for name in objective.names]
    return Optimum(
        point=point,
        value=float(objective.value(values[places])[0]),
        active=tuple(
            condition
            for condition, margin, enough in zip(
                search.conditions, margins, np.broadcast_to(allowed, margins.shape), strict=True
            )
            if margin <= enough
        ),
        borders=tuple(name for name, touches in pairs if touches),
        is_attained=is_attained,
    )


def _is_attained(
    whole: ExactValues, exact: ExactValues, objective: Objective, point: FloatArray
) -> bool:
    """Return whether the objective has values on all of the border next to a point.

    Parameters
    ----------
    whole, exact
        Values in the whole design space, and where they are searched for.
    objective
        The objective.
    point
        The point, shape (2,).
    """
    touches = np.abs(exact.polygon.distances(point[np.newaxis])[0]) <= _NEAR
    if np.any(touches & (whole.polygon.offsets != exact.polygon.offsets)):
        return False
    ends = whole.values(whole.polygon.feet(point, _NEAR))
    places = [whole.names.index(name) for name in objective.names]
    return bool(np.isfinite(ends[places]).all())


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
