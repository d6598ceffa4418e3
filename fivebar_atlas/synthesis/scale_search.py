"""The largest scale at which a shape is good where it is, and where it is largest.

A point b of a shape S that is not good at a scale s, so that p + s b has too low an LCI,
excludes that scale and those below it, down to the next one at which b is good. From a scale
that is too large those exclusions, each by the worst points of the boundary at the scale that
the ones before have left, come down to the largest scale of a position, quadratically. What the
boundary cannot see, a hole within the shape, is excluded by points of holes and by the points
that a proof of containment stumbles on.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.containment import GoodCondition, Proof, prove
from fivebar_atlas.synthesis.shapes import Shape

#: By which share the machine is larger than the one that the shape touches, for the proof;
#: ten or a hundred times that in the rare case that the proof would take too long.
ALLOWANCE = 1e-9
#: Allowances that are tried, and the squares of one size that their proofs may take.
PATIENCE = ((ALLOWANCE, 400_000), (10.0 * ALLOWANCE, 400_000), (100.0 * ALLOWANCE, 6_000_000))
#: Proofs that may stumble on a hole before a search is given up.
PROOFS = 12
#: Rounds of a search that is to end at a local maximum.
ROUNDS = 40
#: Scales that are looked at along the one line of them that belongs to an offset.
OFFSET_SCALES = 2000
#: A margin at a contact.
TOUCHING = 1e-6

# Samples of a shape in a scan of positions, ratio and number of scales, and halvings.
_SCAN_BOUNDARY, _SCAN_INTERIOR, _SCAN_RATIO, _SCAN_SCALES, _SCAN_HALVINGS = 64, 16, 1.25, 30, 8
# Windows of scales that are closed in on.
_WINDOWS = 4
# How far positions move at first in such a round, how that gets less, and what is no gain.
_FIRST_REACH, _LAST_REACH, _LENGTHENING, _SHORTENING, _NO_GAIN = 0.05, 1e-8, 2.0, 0.15, 1e-12
_MOST_CONTACTS = 40
# Samples of a boundary where the worst points are looked for, and how they are closed in on.
_BOUNDARY, _WORST, _ZOOM, _ZOOM_ROUNDS = 360, 10, 41, 5
# Samples of the interior, points of it that are closed in on, a square of trials and rounds.
_INTERIOR, _WORST_INSIDE, _INSIDE_ZOOM, _INSIDE_ROUNDS = 200, 4, 7, 10
# A margin that is nothing but rounding, and what may become a contact.
_ROUNDING, _CONTACT = 2e-14, 0.05
_CUTS, _MARCH, _HALVINGS = 80, 96, 52
# Parts that a step of scales is cut into at a time, and how often: 52 halvings in fewer calls.
_PARTS, _PARTINGS = 16, 13
# Share of the largest scale that could be at which a shape is not worth a machine.
_LEAST_SCALE = 1e-6
_GRADIENT_STEP = 1e-6
# Decimals of coordinates, as shares of the largest one, that order contacts and tell them apart.
_SAME_PLACE = 6

BoolArray = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True)
class ScaleSearch:
    """A shape to be placed, and what is known of where it may not be."""

    good: GoodCondition
    shape: Shape
    offset: FloatArray | None
    limit: float
    holes: list[FloatArray]

    @functools.cached_property
    def size(self) -> float:
        """About the size of where it is to lie, at most 1: lengths of steps go by it."""
        return min(1.0, self.limit * float(np.abs(np.concatenate(self.shape.extent)).max()))

    @functools.cached_property
    def places(self) -> FloatArray:
        """Samples along the boundary."""
        return self.shape.boundary_samples(_BOUNDARY)

    @functools.cached_property
    def boundary(self) -> FloatArray:
        """The points of these samples, shape (n, 2)."""
        return self.shape.boundary(self.places)

    @functools.cached_property
    def interior(self) -> FloatArray:
        """Samples of the interior, shape (n, 2)."""
        return self.shape.interior_samples(_INTERIOR)

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

    def worst_inside(self, anchor: FloatArray, scale: float) -> tuple[FloatArray, FloatArray]:
        """Return interior points of the shape with locally least margins, and these."""
        position = self.position(anchor, scale)
        samples = self.interior
        if not len(samples):
            return np.empty((0, 2)), np.empty(0)
        values = self.good.margins(position + scale * samples)
        lower, upper = self.shape.extent
        step = math.sqrt(float(np.prod(upper - lower)) / _INTERIOR)
        left = np.argsort(values, kind="stable")
        picked: list[int] = []
        while len(left) and len(picked) < _WORST_INSIDE:
            picked.append(int(left[0]))
            left = left[np.hypot(*(samples[left] - samples[left[0]]).T) > 2.0 * step]
        middle, best = samples[picked], values[picked]
        x, y = np.meshgrid(*2 * [np.linspace(-1.0, 1.0, _INSIDE_ZOOM)])
        pattern = np.column_stack([x.ravel(), y.ravel()])
        rows = np.arange(len(picked))
        for _ in range(_INSIDE_ROUNDS):
            trial = middle[:, None] + step * pattern
            flat = trial.reshape(-1, 2)
            margins = self.good.margins(position + scale * flat)
            margins = np.where(self.shape.contains(flat), margins, np.inf).reshape(len(rows), -1)
            place = np.argmin(margins, axis=1)
            better = margins[rows, place] < best
            middle = np.where(better[:, None], trial[rows, place], middle)
            best = np.where(better, margins[rows, place], best)
            step *= 2.0 / (_INSIDE_ZOOM - 1)
        return middle, best

    def largest_scale(self, anchor: FloatArray, start: float, least: float = 0.0) -> float:
        """Return the largest scale up to a start at which the shape is good, 0 if there is none.

        But for holes that are not known yet. Scales below the least one are none.
        """
        scale = start
        for _ in range(_CUTS):
            points, values = self.worst(anchor, scale)
            bad = points[values < -_ROUNDING]
            if not len(bad):
                return scale
            cut = self._cut(anchor, scale, bad)
            if cut <= max(_LEAST_SCALE * self.limit, least):
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
        steps = self.limit * np.arange(1, OFFSET_SCALES + 1) / OFFSET_SCALES
        values = np.full(OFFSET_SCALES + 2, -np.inf)
        points = self.points(anchor, steps[:, None], self.samples)
        values[1:-1] = self.good.margins(points).min(axis=1)
        peaks = (values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])
        peaks &= values[1:-1] >= -_CONTACT
        fits = np.flatnonzero(values[1:-1] >= 0.0)[::-1]
        tops = np.flatnonzero(peaks)[::-1]
        best = 0.0
        if len(fits):
            best = self.largest_scale(anchor, float(steps[min(fits[0] + 1, len(steps) - 1)]))
        for top in tops[steps[tops] > best][:_WINDOWS]:
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
        shares = np.linspace(0.0, 1.0, _PARTS + 1)[:-1]
        rows = np.arange(len(bad))
        for _ in range(_PARTINGS):
            trial = lower[:, None] + shares * (upper - lower)[:, None]
            good = self.good.margins(self.points(anchor, trial, bad[:, None])) >= 0.0
            # the lower end is good; the first one that is not ends the part
            good[:, 0] = True
            last = np.where(good.all(axis=1), _PARTS, np.argmin(good, axis=1)) - 1
            upper = np.where(
                last + 1 < _PARTS, trial[rows, np.minimum(last + 1, _PARTS - 1)], upper
            )
            lower = trial[rows, last]
        return float(lower.min())

    def improve(self, anchor: FloatArray, free: bool, rounds: int) -> tuple[FloatArray, float]:
        """Move a position to where the scale has a local maximum; return it and the scale."""
        axes = [0, 1] if free else [1]
        scale = self.largest_scale(anchor, self.limit)
        contacts = np.empty((0, 2))
        reach = _FIRST_REACH * self.size
        for _ in range(rounds):
            if not 0.0 < scale < self.limit or reach < _LAST_REACH * self.size:
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
            step = _GRADIENT_STEP * self.size
            steps = step * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
            right, left, above, below = self.good.margins(at + steps[:, None])
            rise = np.column_stack([right - left, above - below]) / (2.0 * step)
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
                trial = anchor + step * self.size * direction
                trial_scale = self.largest_scale(trial, min(self.limit, scale * (1.0 + 100 * step)))
                if trial_scale > scale * (1.0 + 1e-10):
                    anchor, scale = self.improve(trial, free, ROUNDS)
        return anchor, scale


@dataclasses.dataclass(frozen=True, slots=True)
class Touch:
    """The largest scale of a shape whose centre stays where it is.

    Attributes
    ----------
    scale
        The scale at which it touches what is not good, or the limit; 0 where there is none.
    contacts
        Points of the shape that touch, relative to its centre and in its lengths, shape (n, 2).
    proof
        Proof that all of it is good at the scale less the allowance; None where that was not
        asked for.
    """

    scale: float
    contacts: FloatArray
    proof: Proof | None


def largest_at(
    good: GoodCondition,
    shape: Shape,
    position: FloatArray,
    limit: float,
    is_proved: bool = True,
) -> Touch:
    """Return the largest scale of a shape about a point that is good up to it.

    Parameters
    ----------
    good
        What is asked of every point of it.
    shape
        The shape; all smaller ones about its centre lie in it.
    position
        Its centre in non-dimensional lengths, shape (2,).
    limit
        Largest scale that is asked for.
    is_proved
        Whether that is proved; otherwise holes are looked for on samples.
    """
    search = ScaleSearch(good, shape, None, limit, [])
    scale, proof = 0.0, None
    for _ in range(PROOFS):
        scale = search.largest_scale(position, limit)
        if scale == 0.0:
            return Touch(0.0, np.empty((0, 2)), None)
        within = scale * (1.0 - ALLOWANCE)
        if is_proved:
            proof = prove(good, shape, position, within)
            witness = proof.witness
        else:
            points, values = search.worst_inside(position, within)
            lowest = int(np.argmin(values)) if len(values) else 0
            witness = points[lowest] if len(values) and values[lowest] < 0.0 else None
        if witness is None:
            break
        search.holes.append(position + within * witness)
    points, values = search.worst(position, scale)
    return Touch(scale, contacts_of(points, values), proof)


def contacts_of(points: FloatArray, values: FloatArray) -> FloatArray:
    """Return the points of a shape whose margins are none, each once, from below and the left.

    A least margin halfway between two samples of the boundary is found from both of them.
    """
    found = points[values < TOUCHING]
    if not len(found):
        return found
    places = np.round(found / np.abs(found).max(), _SAME_PLACE) + 0.0
    return found[np.unique(places[:, ::-1], axis=0, return_index=True)[1]]
