"""The smallest machine around a shape, and where the shape is placed in it.

In non-dimensional lengths a shape S of a machine with dimensional factor D lies at p + s S with
s = 1/D: the smallest machine has the largest scale s at which all of p + s S is good. A point b
of S that is not good at a scale excludes that scale and those below it, down to the next one at
which b is good. From a scale that is too large those exclusions, each by the worst points of
the boundary at the scale that the ones before have left, come down to the largest scale of a
position, quadratically. What the boundary cannot see, a hole within the shape, is excluded by a
point of every hole of the good-condition workspace and by the points that a proof of
containment stumbles on.

Positions are scanned, and the best ones improved by a sequence of optimisations with one
constraint for every contact. A position is not proved to be the best one of all; that the shape
fits there is proved.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InfeasibleSizeError
from fivebar_atlas.planar_geometry import FloatArray, Point
from fivebar_atlas.synthesis.containment import INSIDE, OUTSIDE, GoodCondition, Proof, prove
from fivebar_atlas.synthesis.shapes import Shape

#: Where the centre of a shape may be: x = 0, anywhere, or at an offset in machine lengths.
ON_AXIS, FREE = "axis", "free"

#: By which share the machine is larger than the one that the shape touches, for the proof;
#: ten or a hundred times that in the rare case that the proof would take too long.
ALLOWANCE = 1e-9

# Allowances that are tried, and the squares of one size that their proofs may take.
_PATIENCE = ((ALLOWANCE, 400_000), (10.0 * ALLOWANCE, 400_000), (100.0 * ALLOWANCE, 6_000_000))
# Positions along the axis, and about so many in the plane.
_AXIS_POSITIONS, _FREE_POSITIONS = 401, 1200
# Samples of a shape in a scan of positions, ratio and number of scales, and halvings.
_SCAN_BOUNDARY, _SCAN_INTERIOR, _SCAN_RATIO, _SCAN_SCALES, _SCAN_HALVINGS = 64, 16, 1.25, 30, 8
# The same along the one line of scales that belongs to an offset.
_OFFSET_SCALES = 2000
# Positions of a scan that are improved, how many steps they are apart.
_AXIS_STARTS, _FREE_STARTS, _APART = 4, 10, 2.5
# Rounds for all of them, and for the best ones.
_FEW_ROUNDS, _ROUNDS, _FINALISTS = 6, 40, 2
# A start that is worse than this share of the best one of a scan is not worth it.
_WORTHWHILE = 0.8
# How far positions move at first in such a round, how that gets less, and what is no gain.
_FIRST_REACH, _LAST_REACH, _LENGTHENING, _SHORTENING, _NO_GAIN = 0.05, 1e-8, 2.0, 0.15, 1e-12
_MOST_CONTACTS = 40
# Samples of a boundary where the worst points are looked for, and how they are closed in on.
_BOUNDARY, _WORST, _ZOOM, _ZOOM_ROUNDS = 360, 10, 13, 8
# A margin that is nothing but rounding, and what is a contact.
_ROUNDING, _CONTACT = 2e-14, 0.05
_CUTS, _MARCH, _HALVINGS = 80, 96, 52
# Share of the largest scale that could be at which a shape is not worth a machine.
_LEAST_SCALE = 1e-6
_GRADIENT_STEP = 1e-6
_PROOFS = 12
_MOST_POSITIONS = 400_000
# A margin at a contact; chords of polylines, which have none in between.
_TOUCHING, _ANY_DEVIATION = 1e-6, 1.0

BoolArray = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, slots=True)
class Fit:
    """A shape in a machine as small as can be.

    Attributes
    ----------
    factor
        Dimensional factor D.
    allowance
        By which share D is larger than the factor at which the shape touches, for the proof; 0
        where a limit on lengths decides.
    position
        Centre of the shape in non-dimensional lengths.
    contacts
        Points of the shape next to what is not good, relative to its centre and in its
        lengths, shape (n, 2); empty where a limit on lengths, not the shape, decides.
    proof
        Proof that all of it is good.
    """

    factor: float
    allowance: float
    position: Point
    contacts: FloatArray
    proof: Proof


@dataclasses.dataclass(frozen=True)
class _Search:
    """A shape to be placed, and what is known of where it may not be."""

    good: GoodCondition
    shape: Shape
    offset: FloatArray | None
    limit: float
    holes: list[FloatArray]

    @functools.cached_property
    def places(self) -> FloatArray:
        """Samples along the boundary."""
        return self.shape.boundary_samples(_BOUNDARY)

    @functools.cached_property
    def boundary(self) -> FloatArray:
        return self.shape.boundary(self.places)

    @functools.cached_property
    def samples(self) -> FloatArray:
        """Few points of boundary and interior, for scans."""
        few = self.shape.boundary(self.shape.boundary_samples(_SCAN_BOUNDARY))
        return np.concatenate([few, self.shape.interior_samples(_SCAN_INTERIOR)])

    def position(self, anchor: FloatArray, scale: float) -> FloatArray:
        """Return the centre of the shape: the anchor, or where an offset takes it."""
        return anchor if self.offset is None else scale * self.offset

    def points(
        self, anchor: FloatArray, scales: FloatArray, shape_points: FloatArray
    ) -> FloatArray:
        """Return points of the shape in the plane, one for each scale."""
        if self.offset is None:
            return np.asarray(anchor + scales[..., None] * shape_points)
        return np.asarray(scales[..., None] * (shape_points + self.offset))

    def scan(self, anchors: FloatArray) -> FloatArray:
        """Return about the largest scale at every anchor, shape (n,); 0 where it is tiny."""
        steps = self.limit * _SCAN_RATIO ** np.arange(1.0 - _SCAN_SCALES, 1.0)
        found = np.empty(len(anchors))
        block = max(1_000_000 // (_SCAN_SCALES * len(self.samples)), 1)
        for start in range(0, len(anchors), block):
            part = anchors[start : start + block]
            fits = self._fit(part[:, None], np.broadcast_to(steps, (len(part), len(steps))))
            last = _SCAN_SCALES - 1 - np.argmax(fits[:, ::-1], axis=1)
            lower = np.where(fits.any(axis=1), steps[last], 0.0)
            upper = np.where(lower > 0.0, np.minimum(lower * _SCAN_RATIO, self.limit), steps[0])
            for _ in range(_SCAN_HALVINGS):
                middle = 0.5 * (lower + upper)
                good = self._fit(part, middle)
                lower, upper = np.where(good, middle, lower), np.where(good, upper, middle)
            found[start : start + block] = lower
        return found

    def _fit(self, anchors: FloatArray, scales: FloatArray) -> BoolArray:
        """Tell whether the samples of the shape are good and no hole is in it."""
        points = self.points(anchors[..., None, :], scales[..., None], self.samples)
        fits = np.all(self.good.margins(points) >= 0.0, axis=-1)
        for hole in self.holes:
            centres = anchors if self.offset is None else scales[..., None] * self.offset
            relative = (hole - centres) / scales[..., None]
            inside = self.shape.contains(relative.reshape(-1, 2)).reshape(fits.shape)
            fits &= ~inside
        return np.asarray(fits)

    def worst(self, anchor: FloatArray, scale: float) -> tuple[FloatArray, FloatArray]:
        """Return the points of the shape with locally least margins, and these."""
        position = self.position(anchor, scale)

        def margins(shape_points: FloatArray) -> FloatArray:
            return self.good.margins(position + scale * shape_points)

        values = margins(self.boundary)
        least = (values <= np.roll(values, 1)) & (values <= np.roll(values, -1))
        picked = np.flatnonzero(least)
        picked = picked[np.argsort(values[picked])][:_WORST]
        middle = self.places[picked]
        before = np.mod(middle - np.roll(self.places, 1)[picked], self.shape.pieces)
        after = np.mod(np.roll(self.places, -1)[picked] - middle, self.shape.pieces)
        width = np.maximum(before, after)
        best = values[picked]
        for _ in range(_ZOOM_ROUNDS):
            trial = middle[:, None] + width[:, None] * np.linspace(-1.0, 1.0, _ZOOM)
            trial_values = margins(self.shape.boundary(trial.ravel())).reshape(trial.shape)
            place = np.argmin(trial_values, axis=1)
            rows = np.arange(len(trial))
            # the middle itself is kept where nothing is less: corners stay corners
            better = trial_values[rows, place] < best
            middle = np.where(better, trial[rows, place], middle)
            best = np.where(better, trial_values[rows, place], best)
            width = width * (2.0 / (_ZOOM - 1))
        points = self.shape.boundary(middle)
        if self.holes:
            relative = (np.array(self.holes) - position) / scale
            points = np.concatenate([points, relative[self.shape.contains(relative)]])
        return points, np.concatenate([best, margins(points[len(best) :])])

    def largest_scale(self, anchor: FloatArray, start: float) -> float:
        """Return the largest scale up to a start at which the shape is good, 0 if there is none.

        But for holes that are not known yet.
        """
        scale = start
        for _ in range(_CUTS):
            points, values = self.worst(anchor, scale)
            bad = points[values < -_ROUNDING]
            if not len(bad):
                return scale
            cut = self._cut(anchor, scale, bad)
            if cut <= _LEAST_SCALE * self.limit:
                return 0.0
            if cut >= scale * (1.0 - 1e-15):
                return cut
            scale = cut
        return scale

    def largest_at_offset(self) -> float:
        """Return the largest scale of a shape at an offset, 0 if there is none.

        Scales at which it is good may be a narrow window: where all samples come closest to
        being good, the window is looked for, and its upper end is closed in on.
        """
        anchor = np.zeros(2)
        steps = self.limit * np.arange(1, _OFFSET_SCALES + 1) / _OFFSET_SCALES
        values = np.full(_OFFSET_SCALES + 2, -np.inf)
        points = self.points(anchor, steps[:, None], self.samples)
        values[1:-1] = self.good.margins(points).min(axis=1)
        peaks = (values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])
        peaks &= values[1:-1] >= -_CONTACT
        fits = np.flatnonzero(values[1:-1] >= 0.0)[::-1]
        tops = np.flatnonzero(peaks)[::-1]
        best = 0.0
        if len(fits):
            best = self.largest_scale(anchor, float(steps[min(fits[0] + 1, len(steps) - 1)]))
        for top in tops[steps[tops] > best][:_AXIS_STARTS]:
            best = max(best, self._window(float(steps[top]), float(steps[0])))
        return best

    def _window(self, middle: float, width: float) -> float:
        """Return the upper end of a window of scales near one, 0 if there is none."""

        def least(scale: float) -> float:
            return float(self.worst(np.zeros(2), scale)[1].min())

        upper = min(middle + width, self.limit)
        for _ in range(_ZOOM_ROUNDS):
            trial = np.clip(
                middle + width * np.linspace(-1.0, 1.0, _ZOOM), width * 1e-3, self.limit
            )
            values = [least(float(scale)) for scale in trial]
            place = int(np.argmax(values))
            middle = float(trial[place])
            if values[place] >= 0.0:
                break
            width *= 2.0 / (_ZOOM - 1)
        else:
            return 0.0
        lower = middle
        if least(upper) >= -_ROUNDING:
            return upper
        for _ in range(_HALVINGS):
            middle = 0.5 * (lower + upper)
            lower, upper = (middle, upper) if least(middle) >= -_ROUNDING else (lower, middle)
        return lower

    def _cut(self, anchor: FloatArray, scale: float, bad: FloatArray) -> float:
        """Return the least of the largest scales below one at which bad points are good."""
        # close steps first, for the cuts become small, then even ones, and geometric ones down
        # to scales that are tiny beside the first one
        near = 2.0 ** -np.arange(45.0, 5.0, -1.0)
        even = np.linspace(near[-1], 1.0, _MARCH * (8 if self.offset is not None else 1))[1:-1]
        tiny = 1.0 - _SCAN_RATIO ** np.arange(-12.0, -60.0, -1.0)
        steps = scale * (1.0 - np.concatenate([[0.0], near, np.sort(np.append(even, tiny))]))
        values = self.good.margins(
            self.points(anchor, np.broadcast_to(steps, (len(bad), len(steps))), bad[:, None])
        )
        fits = values >= 0.0
        if not np.all(fits.any(axis=1)):
            return 0.0
        place = np.argmax(fits, axis=1)
        lower, upper = steps[place], steps[np.maximum(place - 1, 0)]
        for _ in range(_HALVINGS):
            middle = 0.5 * (lower + upper)
            good = self.good.margins(self.points(anchor, middle, bad)) >= 0.0
            lower, upper = np.where(good, middle, lower), np.where(good, upper, middle)
        return float(lower.min())

    def improve(self, anchor: FloatArray, free: bool, rounds: int) -> tuple[FloatArray, float]:
        """Move a position to where the scale has a local maximum; return it and the scale."""
        axes = [0, 1] if free else [1]
        scale = self.largest_scale(anchor, self.limit)
        contacts = np.empty((0, 2))
        reach = _FIRST_REACH
        for _ in range(rounds):
            if not 0.0 < scale < self.limit or reach < _LAST_REACH:
                break
            points, values = self.worst(anchor, scale)
            contacts = np.concatenate([points[values < _CONTACT], contacts])[:_MOST_CONTACTS]
            trial = self._optimised(anchor, scale, contacts, axes, reach)
            trial_scale = self.largest_scale(trial, self.limit)
            if trial_scale > scale * (1.0 + _NO_GAIN):
                anchor, scale = trial, trial_scale
                contacts = np.empty((0, 2))
                reach *= _LENGTHENING
            else:
                # what was not a contact before is one there, or it went too far
                if trial_scale > 0.0:
                    points, values = self.worst(trial, trial_scale)
                    contacts = np.concatenate([points[values < _CONTACT], contacts])
                reach *= _SHORTENING
        return anchor, scale

    def _optimised(
        self,
        anchor: FloatArray,
        scale: float,
        contacts: FloatArray,
        axes: Sequence[int],
        reach: float,
    ) -> FloatArray:
        """Return the position near one with the largest scale at which contacts are good.

        Parameters
        ----------
        anchor, scale
            Position to start from, shape (2,), and its scale.
        contacts
            Points of the shape, shape (n, 2).
        axes
            Coordinates of the position that are free.
        reach
            How far either may move.
        """
        from scipy.optimize import minimize

        # The scale times the size of the shape is a length of the design, like the position.
        size = float(np.abs(np.concatenate(self.shape.extent)).max())
        shape_points = contacts / size

        def placed(variables: FloatArray) -> FloatArray:
            centre = anchor.copy()
            centre[axes] = variables[:-1]
            return np.asarray(centre + variables[-1] * shape_points)

        def margins(variables: FloatArray) -> FloatArray:
            return self.good.margins(placed(variables))

        def slopes(variables: FloatArray) -> FloatArray:
            at = placed(variables)
            steps = _GRADIENT_STEP * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
            right, left, above, below = self.good.margins(at + steps[:, None])
            rise = np.column_stack([right - left, above - below]) / (2.0 * _GRADIENT_STEP)
            return np.column_stack([rise[:, axes], np.sum(rise * shape_points, axis=1)])

        start = np.append(anchor[axes], scale * size)
        result = minimize(
            lambda variables: -float(variables[-1]),
            start,
            jac=lambda variables: -np.eye(len(variables))[-1],
            bounds=[*((value - reach, value + reach) for value in start[:-1]), (0.0, None)],
            constraints={"type": "ineq", "fun": margins, "jac": slopes},
            method="SLSQP",
            options={"ftol": 1e-15, "maxiter": 60},
        )
        trial = anchor.copy()
        if np.all(np.isfinite(result.x)):
            trial[axes] = np.clip(result.x[:-1], start[:-1] - reach, start[:-1] + reach)
        return trial

    def polish(self, anchor: FloatArray, scale: float, free: bool) -> tuple[FloatArray, float]:
        """Try positions around one, closer and closer, and go on from those that are better."""
        directions = np.array([[0.0, 1.0], [0.0, -1.0]])
        if free:
            angles = 0.25 * math.pi * np.arange(8)
            directions = np.column_stack([np.cos(angles), np.sin(angles)])
        for step in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
            for direction in directions:
                trial = anchor + step * direction
                trial_scale = self.largest_scale(trial, min(self.limit, scale * (1.0 + 100 * step)))
                if trial_scale > scale * (1.0 + 1e-10):
                    anchor, scale = self.improve(trial, free, _ROUNDS)
        return anchor, scale


def fit_shape(
    good: GoodCondition,
    shape: Shape,
    placement: str | Point = ON_AXIS,
    least_factor: float = 0.0,
) -> Fit:
    """Return the smallest machine in which a whole shape is in good condition.

    Parameters
    ----------
    good
        What is asked of every point of it.
    shape
        The shape, in lengths of the machine.
    placement
        ``ON_AXIS``: its centre is on the y axis. ``FREE``: it is anywhere. A point: it is
        there, in lengths of the machine.
    least_factor
        Least dimensional factor that is allowed.

    Returns
    -------
    Fit
        It fits, and it does not at D (1 - 1e-6), where limits on lengths do not decide.

    Raises
    ------
    InfeasibleSizeError
        If it fits at no size; says why and what comes closest.
    """
    parts = good.design.good_condition_workspace(good.lci_threshold, good.mode)
    if not parts:
        raise InfeasibleSizeError(empty_reason(good))
    polygons = [part.polygons(_ANY_DEVIATION) for part in parts]
    corners = np.concatenate([part[0] for part in polygons])
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    sides = np.subtract(*reversed(shape.extent))
    limit = 1.001 * float(np.min((upper - lower) / sides))
    if not isinstance(placement, str) and any(placement):
        # its centre lies within the box around the good-condition workspace
        limit = min(limit, float(np.hypot(*corners.T).max() / np.hypot(*placement)) + 1e-300)
    is_limited = least_factor > 0.0 and 1.0 / least_factor < limit
    search = _Search(
        good,
        shape,
        None if isinstance(placement, str) else np.array(placement, dtype=np.float64),
        1.0 / least_factor if is_limited else limit,
        _points_of_holes(good, [hole for part in polygons for hole in part[1:]]),
    )
    for _ in range(_PROOFS):
        anchor, scale = _best(search, placement, lower, upper)
        if scale == 0.0:
            raise InfeasibleSizeError(_why_not(search, placement, lower, upper))
        decides = scale < search.limit
        # Where squares do not suffice next to contacts, some more room does.
        for allowance, most in _PATIENCE:
            factor = (1.0 + allowance) / scale if decides else least_factor
            position = search.position(anchor, 1.0 / factor)
            proof = prove(good, shape, position, 1.0 / factor, most)
            if proof.witness is not None:
                search.holes.append(position + proof.witness / factor)
            if proof.verdict in (INSIDE, OUTSIDE) or not decides:
                break
        if proof.verdict != OUTSIDE:
            points, values = search.worst(anchor, scale)
            contacts = points[values < _TOUCHING] if decides else np.empty((0, 2))
            place = float(position[0]), float(position[1])
            return Fit(factor, allowance if decides else 0.0, place, contacts, proof)
    raise InfeasibleSizeError(
        f"the {shape.name} could not be placed: a proof of its containment still finds points "
        f"of too low LCI after {_PROOFS} corrections"
    )


def _best(
    search: _Search, placement: str | Point, lower: FloatArray, upper: FloatArray
) -> tuple[FloatArray, float]:
    """Return the anchor with the largest scale that was found, and that scale, or 0."""
    if search.offset is not None:
        return np.zeros(2), search.largest_at_offset()
    free = placement == FREE
    anchors, step = _anchors(search, lower, upper, free)
    best = np.zeros(2), 0.0
    if not len(anchors):
        return best
    scales = search.scan(anchors)
    most = _FREE_STARTS if free else _AXIS_STARTS
    improved = [
        search.improve(anchors[start], free, _FEW_ROUNDS)
        for start in _starts(anchors, scales, _APART * step, most)
    ]
    improved.sort(key=lambda each: -each[1])
    for anchor, scale in improved[:_FINALISTS]:
        if scale > 0.0:
            best = max(best, search.improve(anchor, free, _ROUNDS), key=lambda each: each[1])
    if 0.0 < best[1] < search.limit:
        best = search.polish(*best, free)
    return best


def _anchors(
    search: _Search, lower: FloatArray, upper: FloatArray, free: bool
) -> tuple[FloatArray, float]:
    """Return the positions of a scan, shape (n, 2), and how far they are apart.

    Of a shape that its centre belongs to, this must be good. A narrow workspace then has as
    many positions as a wide one.
    """
    is_centred = bool(search.shape.contains(np.zeros((1, 2)))[0])
    if not free:
        y = np.linspace(lower[1], upper[1], _AXIS_POSITIONS + 2)
        return np.column_stack([np.zeros(len(y)), y])[1:-1], float(y[1] - y[0])
    step = math.sqrt(float(np.prod(upper - lower)) / _FREE_POSITIONS)
    while True:
        lines = [
            np.linspace(low, high, math.ceil((high - low) / step) + 2)[1:-1]
            for low, high in zip(lower, upper, strict=True)
        ]
        x, y = np.meshgrid(*lines)
        anchors = np.column_stack([x.ravel(), y.ravel()])
        if not is_centred:
            return anchors, step
        count = len(anchors)
        anchors = anchors[search.good.margins(anchors) >= 0.0]
        if 2 * len(anchors) > _FREE_POSITIONS or count > _MOST_POSITIONS:
            return anchors, step
        step *= 0.7


def _starts(anchors: FloatArray, scales: FloatArray, apart: float, most: int) -> list[int]:
    """Return the places of the best scales that are not too near to better ones."""
    left = np.argsort(-scales, kind="stable")
    left = left[scales[left] > _WORTHWHILE * scales.max()]
    starts: list[int] = []
    while len(left) and len(starts) < most:
        starts.append(int(left[0]))
        left = left[np.hypot(*(anchors[left] - anchors[left[0]]).T) >= apart]
    return starts


def _points_of_holes(good: GoodCondition, holes: Sequence[FloatArray]) -> list[FloatArray]:
    """Return a point of every hole that is not good itself."""
    import shapely

    points = []
    for hole in holes:
        inner = shapely.Polygon(hole).representative_point()
        point = np.array([inner.x, inner.y])
        if good.margins(point) < 0.0:
            points.append(point)
    return points


def empty_reason(good: GoodCondition) -> str:
    """Return why there is no good-condition workspace."""
    what = f"no size: the good-condition workspace of {good.mode} is empty"
    largest = good.design.largest_lci(good.mode)
    if largest is None:
        return f"{what}, for its usable workspace is"
    value, (x, y) = largest
    return (
        f"{what} at LCI {good.lci_threshold:g}; the largest LCI is {value:.6g}, at "
        f"({x + 0.0:.4g}, {y + 0.0:.4g}) of the non-dimensional design"
    )


def _why_not(search: _Search, placement: str | Point, lower: FloatArray, upper: FloatArray) -> str:
    """Return why a shape fits at no size, and what comes closest."""
    good, shape = search.good, search.shape
    without = dataclasses.replace(search, good=dataclasses.replace(good, ranges=()))
    if search.offset is not None:
        steps = search.limit * np.arange(1, _OFFSET_SCALES + 1) / _OFFSET_SCALES
        points = search.points(np.zeros(2), steps[:, None], search.samples)
        margins = without.good.margins(points)
        least = margins.min(axis=1)
        closest = int(np.argmax(least))
        if least[closest] < 0.0 or not any(each.is_limiting for each in good.ranges):
            x, y = (float(part) for part in search.offset)
            value = max(float(least[closest]) + good.lci_threshold, 0.0)
            known = "" if least[closest] < 0.0 else ", but there are holes in it"
            if value == 0.0:
                shares = np.mean(margins >= 0.0, axis=1)
                best = int(np.argmax(shares))
                return (
                    f"the {shape.name} fits at no size with its centre at ({x:g}, {y:g}); closest "
                    f"comes D = {1.0 / steps[best]:.6g}, where about {100 * shares[best]:.0f} % of "
                    f"it is in good condition and some is outside the usable workspace"
                )
            return (
                f"the {shape.name} fits at no size with its centre at ({x:g}, {y:g}); closest "
                f"comes D = {1.0 / steps[closest]:.6g}, where the least LCI of its points is "
                f"{value:.4g} and {good.lci_threshold:g} is asked for{known}"
            )
        candidates = points[least >= 0.0].reshape(-1, 2)
        where = "of the shape"
    else:
        anchors, _ = _anchors(without, lower, upper, placement == FREE)
        margins = without.good.margins(anchors)
        where = "on the y axis" if placement == ON_AXIS else "of the good-condition workspace"
        if np.all(margins < 0.0):
            best = int(np.argmax(margins))
            value = float(margins[best]) + good.lci_threshold
            return (
                f"the {shape.name} fits at no size with its centre on the y axis: no point "
                f"there has an LCI of {good.lci_threshold:g} in {good.mode}; the largest is "
                f"{value:.4g}, at y = {anchors[best, 1] + 0.0:.4g} of the non-dimensional design"
            )
        candidates = anchors[margins >= 0.0]
    inputs = good.design.inputs(candidates[:, 0], candidates[:, 1], good.mode)
    reasons = []
    for each in good.ranges:
        room = each.margins(inputs[:, each.number - 1])
        if each.is_limiting and np.all(room < 0.0):
            best = int(np.argmax(room))
            x, y = candidates[best] + 0.0
            reasons.append(
                f"none of {len(room)} points {where} has {each}; closest comes "
                f"({x:.4g}, {y:.4g}) of the non-dimensional design, "
                f"{math.degrees(-room[best]):.4g} deg outside"
            )
    if not reasons:
        limits = " and ".join(str(each) for each in good.ranges if each.is_limiting)
        reasons = [f"no place has {limits} throughout" if limits else f"no place {where} holds it"]
    return f"the {shape.name} fits at no size: {'; '.join(reasons)}"
