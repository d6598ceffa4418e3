"""A placed design to the nearest optimum: design, placement and size at once.

What is asked holds at all points of the practical workspace, which is one constraint for each
of infinitely many. As in :mod:`scale_search` those at its worst points are taken: a problem
with finitely many constraints is solved (SLSQP of SciPy) within a trust region, the largest
scale that really fits is found at its solution, and what is worst there comes in addition.
"""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.containment import GoodCondition
from fivebar_atlas.synthesis.design_polygon import DesignPolygon
from fivebar_atlas.synthesis.machine_search import MachineTask, Start
from fivebar_atlas.synthesis.placement import FREE
from fivebar_atlas.synthesis.practical_workspace import Boundary, Field, peaks
from fivebar_atlas.synthesis.scale_search import ScaleSearch

# Rounds, how far design and placement move in the first one, how that changes, what ends it.
_ROUNDS, _FIRST_REACH, _LAST_REACH, _LENGTHENING, _SHORTENING = 60, 0.05, 1e-9, 2.0, 0.25
# A gain below this share is none.
_NO_GAIN = 1e-10
# Times that contacts are exchanged in a round, and the share of a scale that is as good as met.
_EXCHANGES, _MET = 6, 1e-7
# Margins below this may become zero within a round; contacts that are kept.
_CONTACT, _MOST_CONTACTS = 0.1, 80
# A scale below this share of what was expected is not worth finding; a margin that is rounding.
_COLLAPSE, _ROUNDING = 0.5, 2e-14
# By which share limits on lengths may be missed by rounding.
_ROUNDED = 1e-9
# Margin that is asked for at contacts, so that what is between them is good, too.
_MARGIN = 1e-9
# Shares of the scale of a start, which was found on samples, that are tried.
_FIRST_SCALES = (1.0, 0.97, 0.9, 0.75)
# By how much larger a scale is tried than the one before.
_GROWTH = 1.3
# Steps of differences.
_STEP = 1e-6
# Samples of boundary and interior for the extremes of a goal, and peaks that are closed in on.
_BOUNDARY, _INTERIOR, _PEAKS = 360, 100, 4


@dataclasses.dataclass(frozen=True)
class DesignLine:
    """A line of the chart that designs are kept on.

    Attributes
    ----------
    normal
        Unit normal, shape (2,).
    offset
        A point p is on it where ``normal @ p == offset``.
    """

    normal: FloatArray
    offset: float

    @classmethod
    def through(cls, one: FloatArray, other: FloatArray) -> DesignLine:
        """Return the line through two points of the chart, shape (2,)."""
        along = (other - one) / np.hypot(*(other - one))
        normal = np.array([-along[1], along[0]])
        return cls(normal, float(normal @ one))

    def foot(self, point: FloatArray) -> FloatArray:
        """Return the nearest point of the line."""
        return np.asarray(point - (self.normal @ point - self.offset) * self.normal)


@dataclasses.dataclass(frozen=True)
class Polished:
    """A design with a placement in which the shape is good and cannot be any larger.

    Attributes
    ----------
    mode
        Mode pair.
    point
        The design in the chart, shape (2,).
    parameters
        The non-dimensional design, shape (parameters,).
    centre
        Centre of the shape in it, shape (2,).
    scale
        1/D.
    value
        The goal.
    """

    mode: str
    point: FloatArray
    parameters: FloatArray
    centre: FloatArray
    scale: float
    value: float


class MachinePolish:
    """Moves placed designs to local optima of a task.

    Parameters
    ----------
    task
        What is asked.
    line
        Line of the chart that designs are kept on; None for the whole design space.
    """

    def __init__(self, task: MachineTask, line: DesignLine | None = None) -> None:
        self._task = task
        self._line = line
        self._polygon = DesignPolygon.of_space(task.mechanism, task.space)
        self._axes = [0, 1] if task.placement == FREE else [1]
        shape = task.shape
        self._interior = shape.interior_samples(_INTERIOR)
        self._limits = [(task.length_place(each), each) for each in task.limits]
        self._limiting = [each for each in task.ranges if each.is_limiting]

    def placed(self, start: Start) -> Polished | None:
        """Return a start whose shape is good throughout; None where none is about that large."""
        point = self._moved(
            self._task.mechanism.project(start.parameters[None], self._task.space)[0]
        )
        for share in _FIRST_SCALES:
            design, scale = self._within_limits(point, share * start.scale)
            now = self._evaluated(start.mode, design, start.centre, scale)
            if now is not None:
                return now
        return None

    def _within_limits(self, point: FloatArray, scale: float) -> tuple[FloatArray, float]:
        """Return the nearest design and scale whose lengths keep to the limits."""
        from scipy.optimize import minimize

        size = self._task.size
        start = np.array([*point, scale * size])
        linear, offsets = self._linear(3, 2)
        if not self._limits or np.all(linear @ start >= offsets):
            return point, scale
        found = minimize(
            lambda variables: float(np.sum((variables - start) ** 2)),
            start,
            jac=lambda variables: 2.0 * (variables - start),
            constraints={
                "type": "ineq",
                "fun": lambda variables: linear @ variables - offsets,
                "jac": lambda variables: linear,  # noqa: ARG005
            },
            method="SLSQP",
            options={"ftol": 1e-16},
        ).x
        return self._moved(found[:2]), float(found[2]) / size

    def polish(self, now: Polished, rounds: int = _ROUNDS) -> Polished:
        """Return the local optimum near a placement, or how far so many rounds have come."""
        contacts = self._worst(now.mode, now.point, now.centre, now.scale)
        reach = _FIRST_REACH
        for _ in range(rounds):
            trial, contacts, promise = self._round(now, contacts, reach)
            enough = now.value * (1.0 - _NO_GAIN)
            if trial is not None and trial.value < enough:
                now, reach = trial, reach * _LENGTHENING
            else:
                reach *= _SHORTENING
            if promise > enough or reach < _LAST_REACH:
                break
        return now

    def _round(
        self, now: Polished, contacts: FloatArray, reach: float
    ) -> tuple[Polished | None, FloatArray, float]:
        """Return the best placement within reach, the contacts met, and what these would allow.

        Where the solution for some contacts is spoilt by points between them, these are added
        and it is solved again.
        """
        best, promise = None, -math.inf
        for _ in range(_EXCHANGES):
            try:
                solved = self._solved(now, contacts, reach)
            except InputError:  # it wandered off to where there is no design
                break
            if solved is None:
                break
            point, centre, scale, promise = solved
            trial = self._evaluated(now.mode, point, centre, scale)
            if trial is not None and (best is None or trial.value < best.value):
                best = trial
            worst = self._worst(now.mode, point, centre, scale)
            contacts = np.concatenate([worst, contacts])[:_MOST_CONTACTS]
            if trial is not None and trial.scale >= scale * (1.0 - _MET):
                break
        return best, contacts, promise

    def _moved(self, point: FloatArray) -> FloatArray:
        """Return a point of the chart moved into the design space, and onto the line."""
        if self._line is not None:
            point = self._line.foot(point)
        return np.asarray(self._polygon.clip(point[None])[0])

    def _parameters(self, point: FloatArray) -> FloatArray:
        return np.asarray(self._task.mechanism.unproject(point[None], self._task.space)[0])

    def _design(self, point: FloatArray) -> PlanarDesign:
        return self._task.design(self._parameters(point))

    def _good(self, mode: str, point: FloatArray) -> GoodCondition:
        task = self._task
        return GoodCondition(self._design(point), mode, task.lci_threshold, task.ranges)

    def _evaluated(
        self, mode: str, point: FloatArray, centre: FloatArray, scale: float
    ) -> Polished | None:
        """Return a placement with about the scale that is given; None where that does not fit.

        A goal without extremes gains from every larger scale, others have the scale that
        was asked for if it fits.
        """
        task = self._task
        parameters = self._parameters(point)
        least, greatest = (float(each[0]) for each in task.scales(parameters[None]))
        least *= 1.0 - _ROUNDED
        wanted = scale if task.goal.extremes else _GROWTH * scale
        limit = min(wanted, greatest)
        if limit < least:
            return None
        try:
            good = self._good(mode, point)
        except InputError:  # the end of a design space that is no design
            return None
        search = ScaleSearch(good, task.shape, None, limit, [])
        fits = search.largest_scale(centre, limit, max(least, _COLLAPSE * scale))
        if fits == 0.0:
            return None
        _, values = search.worst_inside(centre, fits)
        if len(values) and values.min() < -_ROUNDING:
            return None
        extremes = self._extremes(good.design, mode, centre, fits)[0]
        value = task.goal.value(task.mechanism, parameters, fits, extremes)
        if not math.isfinite(value):
            return None
        return Polished(mode, point, parameters, centre, fits, value)

    def _worst(self, mode: str, point: FloatArray, centre: FloatArray, scale: float) -> FloatArray:
        """Return the points of the shape that may decide, relative to its centre, (n, 2)."""
        good = self._good(mode, point)
        search = ScaleSearch(good, self._task.shape, None, scale, [])
        points, values = search.worst(centre, scale)
        inner, inner_values = search.worst_inside(centre, scale)
        _, places = self._extremes(good.design, mode, centre, scale)
        return np.concatenate([points[values < _CONTACT], inner[inner_values < _CONTACT], places])

    def _extremes(
        self, design: PlanarDesign, mode: str, centre: FloatArray, scale: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the extremes of the goal, and the points of the shape where they are taken."""
        goal, shape = self._task.goal, self._task.shape
        if not goal.extremes:
            return np.empty(0), np.empty((0, 2))

        def functions(points: FloatArray) -> FloatArray:
            return goal.functions(design, mode, centre + scale * points)

        places = shape.boundary_samples(_BOUNDARY)
        boundary = Boundary(shape.boundary, places, float(shape.pieces))
        on_boundary, inside = functions(boundary.at(places)), functions(self._interior)
        extremes = np.full(goal.extremes, -np.inf)
        found = []
        for row, number in enumerate(goal.bounded):
            function = functools.partial(_row, functions, row)
            # where a leg does not reach nothing is known
            known = np.nan_to_num(on_boundary[row], nan=-np.inf)
            tops, values = boundary.close_in(function, peaks(known)[:_PEAKS])
            points, greatest = boundary.at(tops), float(values.max())
            if len(self._interior) and inside[row].max() > greatest:
                place = int(np.argmax(inside[row]))
                points = np.concatenate([points, self._interior[place : place + 1]])
                greatest = float(inside[row, place])
            found.append(points)
            extremes[number] = max(extremes[number], greatest)
        return extremes, np.concatenate(found)

    def _fields(
        self, mode: str, point: FloatArray, points: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return margins, shape (m, n), and functions of the goal, (k, n), at output points."""
        design = self._design(point)
        x, y = points[:, 0].copy(), points[:, 1].copy()
        rows = [np.nan_to_num(design.lci(x, y, mode)) - self._task.lci_threshold - _MARGIN]
        if self._limiting:
            inputs = np.nan_to_num(design.inputs(x, y, mode))
            rows += [each.margins(inputs[:, each.number - 1]) for each in self._limiting]
        return np.array(rows), self._task.goal.functions(design, mode, points)

    def _solved(
        self, placed: Polished, contacts: FloatArray, reach: float
    ) -> tuple[FloatArray, FloatArray, float, float] | None:
        """Return design, centre and scale that are best as far as contacts tell, and the goal.

        Variables are the design in the chart, the free coordinates of the centre, the scale
        times the size of the shape, and the extremes of the goal.
        """
        from scipy.optimize import minimize

        task, goal, mode = self._task, self._task.goal, placed.mode
        size, axes = task.size, self._axes
        shape_points = contacts / size
        extremes = self._extremes(self._design(placed.point), mode, placed.centre, placed.scale)[0]
        start = np.concatenate([placed.point, placed.centre[axes], [placed.scale * size], extremes])
        after_scale = 3 + len(axes)
        across, is_central = self._polygon.directions(placed.point, _STEP)
        # derivatives along those two directions to derivatives by the chart's coordinates
        turn = np.linalg.inv(across)
        bounded = np.array(goal.bounded, dtype=np.int64)
        scale_of = placed.value

        def placed_points(variables: FloatArray) -> FloatArray:
            centre = placed.centre.copy()
            centre[axes] = variables[2 : 2 + len(axes)]
            return np.asarray(centre + variables[after_scale - 1] * shape_points)

        def inside(point: FloatArray) -> FloatArray:
            return np.asarray(self._polygon.clip(point[None])[0])

        def by_design(function: functools.partial[FloatArray], point: FloatArray) -> FloatArray:
            """Return derivatives by the chart's coordinates along the last axis."""
            slopes = []
            for direction, central in zip(across, is_central, strict=True):
                ends = (point + _STEP * direction, point - _STEP * direction if central else point)
                steps = np.hypot(*(inside(ends[0]) - inside(ends[1])))
                rise = function(inside(ends[0])) - function(inside(ends[1]))
                slopes.append(rise / max(float(steps), 1e-300))
            return np.stack(slopes, axis=-1) @ turn.T

        def rows(variables: FloatArray, margins: FloatArray, values: FloatArray) -> FloatArray:
            over = variables[after_scale:][bounded][:, None] - values if len(bounded) else values
            return np.concatenate([margins.ravel(), over.ravel()])

        def constraints(variables: FloatArray) -> FloatArray:
            point = inside(variables[:2])
            return rows(variables, *self._fields(mode, point, placed_points(variables)))

        def slopes(variables: FloatArray) -> FloatArray:
            point, at = inside(variables[:2]), placed_points(variables)

            def stacked(where: FloatArray, points: FloatArray) -> FloatArray:
                margins, values = self._fields(mode, where, points)
                return np.concatenate([margins, -values])

            design = by_design(functools.partial(stacked, points=at), point)
            steps = _STEP * np.eye(2)
            right, above = (
                (stacked(point, at + step) - stacked(point, at - step)) / (2.0 * _STEP)
                for step in steps
            )
            result = np.zeros((*right.shape, len(variables)))
            result[..., :2] = design
            result[..., 2 : 2 + len(axes)] = np.stack([right, above], axis=-1)[..., axes]
            result[..., after_scale - 1] = right * shape_points[:, 0] + above * shape_points[:, 1]
            first = right.shape[0] - len(bounded)
            for row, number in enumerate(bounded):
                result[first + row, :, after_scale + number] = 1.0
            return np.asarray(result.reshape(-1, len(variables)))

        def value(variables: FloatArray) -> float:
            parameters = self._parameters(variables[:2])
            scale = variables[after_scale - 1] / size
            found = goal.value(task.mechanism, parameters, scale, variables[after_scale:])
            return found / scale_of

        def value_slopes(variables: FloatArray) -> FloatArray:
            found = np.empty(len(variables))
            for number in range(len(variables)):
                step = np.zeros(len(variables))
                step[number] = _STEP * max(1.0, abs(variables[number]))
                rise = value(variables + step) - value(variables - step)
                found[number] = rise / (2.0 * step[number])
            return found

        linear, offsets = self._linear(len(start), after_scale - 1)
        all_constraints = [
            {"type": "ineq", "fun": constraints, "jac": slopes},
            {"type": "ineq", "fun": lambda v: linear @ v - offsets, "jac": lambda v: linear},  # noqa: ARG005
        ]
        if self._line is not None:
            normal = np.zeros(len(start))
            normal[:2] = self._line.normal
            offset = self._line.offset
            all_constraints.append(
                {"type": "eq", "fun": lambda v: normal @ v - offset, "jac": lambda v: normal}  # noqa: ARG005
            )
        near = [(each - reach, each + reach) for each in start[: after_scale - 1]]
        least = 0.3 * start[after_scale - 1]
        result = minimize(
            value,
            start,
            jac=value_slopes,
            bounds=[*near, (least, None), *([(None, None)] * len(extremes))],
            constraints=all_constraints,
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 50},
        )
        if not np.all(np.isfinite(result.x)):
            return None
        centre = placed.centre.copy()
        found = result.x
        centre[axes] = found[2 : 2 + len(axes)]
        scale = float(found[after_scale - 1]) / size
        return self._moved(found[:2]), centre, scale, float(result.fun) * scale_of

    def _linear(self, count: int, scale: int) -> tuple[FloatArray, FloatArray]:
        """Return rows a and numbers b of linear constraints a @ variables >= b.

        Sides of the design space, and limits on lengths: r_j >= least / D and so on, which
        are linear in design and scale, for proportions are linear in the chart.
        """
        rows = [np.concatenate([each, np.zeros(count - 2)]) for each in self._polygon.normals]
        offsets = [*self._polygon.offsets]
        mechanism, space = self._task.mechanism, self._task.space
        places = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        origin, *ends = mechanism.proportions_of(mechanism.unproject(places, space))
        slopes = np.array(ends) - origin
        size = self._task.size
        for place, limit in self._limits:
            row = np.zeros(count)
            row[:2] = slopes[:, place]
            for sign, bound in ((1.0, limit.least), (-1.0, limit.greatest)):
                if bound > 0.0 and math.isfinite(bound):
                    limited = sign * row
                    limited[scale] = -sign * bound / size
                    rows.append(limited)
                    offsets.append(-sign * origin[place])
        return np.array(rows), np.array(offsets)


def _row(functions: Field, row: int, points: FloatArray) -> FloatArray:
    """Return one of several functions of points."""
    return np.asarray(functions(points)[row])
