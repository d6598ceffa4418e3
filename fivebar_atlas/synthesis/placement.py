"""The smallest machine around a shape, and where the shape is placed in it.

In non-dimensional lengths a shape S of a machine with dimensional factor D lies at p + s S with
s = 1/D: the smallest machine has the largest scale s at which all of p + s S is good (see
:mod:`scale_search`). Positions are scanned, and the best ones improved by a sequence of
optimisations with one constraint for every contact. A position is not proved to be the best one
of all; that the shape fits there is proved.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InfeasibleSizeError
from fivebar_atlas.planar_geometry import FloatArray, Point
from fivebar_atlas.synthesis.containment import INSIDE, OUTSIDE, GoodCondition, Proof, prove
from fivebar_atlas.synthesis.scale_search import (
    OFFSET_SCALES,
    PATIENCE,
    PROOFS,
    ROUNDS,
    ScaleSearch,
    contacts_of,
)
from fivebar_atlas.synthesis.shapes import Shape

#: Where the centre of a shape may be: x = 0, anywhere, or at an offset in machine lengths.
ON_AXIS, FREE = "axis", "free"

# Positions along the axis, and about so many in the plane.
_AXIS_POSITIONS, _FREE_POSITIONS = 401, 1200
# Positions of a scan that are improved, how many steps they are apart.
_AXIS_STARTS, _FREE_STARTS, _APART = 4, 10, 2.5
# Rounds for all of them, and number of the best ones that have more.
_FEW_ROUNDS, _FINALISTS = 6, 2
# A start that is worse than this share of the best one of a scan is not worth it.
_WORTHWHILE = 0.8
_MOST_POSITIONS = 400_000
# Share of the width of a polygon of n corners that its chords cut off, times n squared: of a
# regular one 5, more where corners are closer in some places than in others.
_CUT_OFF = 60.0
# Chords of polylines, which have none in between.
_ANY_DEVIATION = 1.0


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
    boxes = [Box.around(part) for part in polygons]
    # A shape is connected, so it lies in one part.
    limit = max(box.limit(shape) for box in boxes)
    if not isinstance(placement, str) and any(placement):
        # its centre lies within the box around the good-condition workspace
        limit = min(limit, float(np.hypot(*corners.T).max() / np.hypot(*placement)) + 1e-300)
    is_limited = least_factor > 0.0 and 1.0 / least_factor < limit
    search = ScaleSearch(
        good,
        shape,
        None if isinstance(placement, str) else np.array(placement, dtype=np.float64),
        1.0 / least_factor if is_limited else limit,
        _points_of_holes(good, [hole for part in polygons for hole in part[1:]]),
    )
    for _ in range(PROOFS):
        anchor, scale = _best_of_parts(search, placement, boxes)
        if scale == 0.0:
            raise InfeasibleSizeError(_why_not(search, placement, boxes))
        decides = scale < search.limit
        # Where squares do not suffice next to contacts, some more room does.
        for allowance, most in PATIENCE:
            factor = (1.0 + allowance) / scale if decides else least_factor
            position = search.position(anchor, 1.0 / factor)
            proof = prove(good, shape, position, 1.0 / factor, most)
            if proof.witness is not None:
                search.holes.append(position + proof.witness / factor)
            if proof.verdict in (INSIDE, OUTSIDE) or not decides:
                break
        if proof.verdict != OUTSIDE:
            points, values = search.worst(anchor, scale)
            contacts = contacts_of(points, values) if decides else np.empty((0, 2))
            place = float(position[0]), float(position[1])
            return Fit(factor, allowance if decides else 0.0, place, contacts, proof)
    raise InfeasibleSizeError(
        f"the {shape.name} could not be placed: a proof of its containment still finds points "
        f"of too low LCI after {PROOFS} corrections"
    )


@dataclasses.dataclass(frozen=True, slots=True)
class Box:
    """The box around a part of a good-condition workspace.

    Attributes
    ----------
    lower, upper
        Its corners, shape (2,).
    points
        Points of the part, shape (n, 2).
    """

    lower: FloatArray
    upper: FloatArray
    points: FloatArray

    @classmethod
    def around(cls, polygon: Sequence[FloatArray]) -> Box:
        """Return the box around a part, given as corners of its outline and of its holes.

        The part is larger than its polygon by what chords cut off, more so the fewer there are.
        """
        outline = polygon[0]
        lower, upper = outline.min(axis=0), outline.max(axis=0)
        beyond = 0.5 * max(_CUT_OFF / len(outline) ** 2 - 1e-3, 0.0) * (upper - lower)
        return cls(lower - beyond, upper + beyond, _points_in(polygon))

    def limit(self, shape: Shape) -> float:
        """Return a scale at which a shape is larger than the box."""
        sides = np.subtract(*reversed(shape.extent))
        return 1.001 * float(np.min((self.upper - self.lower) / sides))


def _best_of_parts(
    search: ScaleSearch, placement: str | Point, boxes: Sequence[Box]
) -> tuple[FloatArray, float]:
    """Return where a shape has the largest scale that is found in any part."""
    if search.offset is not None:
        return best_position(search, placement, boxes[0].lower, boxes[0].upper)
    best = np.zeros(2), 0.0
    for box in sorted(boxes, key=lambda each: -each.limit(search.shape)):
        limit = min(search.limit, box.limit(search.shape))
        if limit > best[1] and _is_open_to(box, placement):
            inside = dataclasses.replace(search, limit=limit)
            found = best_position(inside, placement, box.lower, box.upper, box.points)
            best = max(best, found, key=lambda each: each[1])
    return best


def _is_open_to(box: Box, placement: str | Point) -> bool:
    """Return whether the centre of a shape may be in a box."""
    return placement != ON_AXIS or bool(box.lower[0] <= 0.0 <= box.upper[0])


def best_position(
    search: ScaleSearch,
    placement: str | Point,
    lower: FloatArray,
    upper: FloatArray,
    points: FloatArray | None = None,
) -> tuple[FloatArray, float]:
    """Return where a shape has the largest scale that is found.

    Parameters
    ----------
    search
        The shape, and what is asked of it.
    placement
        As for :func:`fit_shape`.
    lower, upper
        Corners of a box that its centre lies in, in non-dimensional lengths, shape (2,).
    points
        Positions that are looked at in any case, shape (n, 2).

    Returns
    -------
    position : ndarray
        Shape (2,); at an offset, which depends on the scale, the origin.
    scale : float
        The scale, 0 where there is none.
    """
    if search.offset is not None:
        return np.zeros(2), search.largest_at_offset()
    free = placement == FREE
    anchors, step = _anchors(search, lower, upper, free, points)
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
            best = max(best, search.improve(anchor, free, ROUNDS), key=lambda each: each[1])
    if 0.0 < best[1] < search.limit:
        best = search.polish(*best, free)
    return best


def _anchors(
    search: ScaleSearch,
    lower: FloatArray,
    upper: FloatArray,
    free: bool,
    points: FloatArray | None = None,
) -> tuple[FloatArray, float]:
    """Return the positions of a scan, shape (n, 2), and how far they are apart.

    Of a shape that its centre belongs to, this must be good. A narrow workspace then has as
    many positions as a wide one. Given points come last, those on the y axis where all are.
    """
    more = np.empty((0, 2)) if points is None else points
    if not free:
        y = np.linspace(lower[1], upper[1], _AXIS_POSITIONS + 2)
        along = np.column_stack([np.zeros(len(y)), y])[1:-1]
        return np.concatenate([along, more[more[:, 0] == 0.0]]), float(y[1] - y[0])
    grid, step = _grid(search, lower, upper)
    return np.concatenate([grid, more]), step


def _grid(search: ScaleSearch, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, float]:
    """Return positions of a grid over a box, shape (n, 2), and their distance."""
    is_centred = bool(search.shape.contains(np.zeros((1, 2)))[0])
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


def _points_in(loops: Sequence[FloatArray]) -> FloatArray:
    """Return a point of a part between its outline and its holes, which tells it from others."""
    import shapely

    part = shapely.Polygon(loops[0], loops[1:])
    points = [part.representative_point()] if part.is_valid else [shapely.Point(loops[0][0])]
    return np.array([(point.x, point.y) for point in points])


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


def _why_not(search: ScaleSearch, placement: str | Point, boxes: Sequence[Box]) -> str:
    """Return why a shape fits at no size, and what comes closest."""
    good, shape = search.good, search.shape
    without = dataclasses.replace(search, good=dataclasses.replace(good, ranges=()))
    if search.offset is not None:
        steps = search.limit * np.arange(1, OFFSET_SCALES + 1) / OFFSET_SCALES
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
        open_boxes = [box for box in boxes if _is_open_to(box, placement)] or boxes
        anchors = np.concatenate(
            [
                _anchors(without, box.lower, box.upper, placement == FREE, box.points)[0]
                for box in open_boxes
            ]
        )
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
    mechanism = mechanisms.get(good.design.mechanism)
    reasons = []
    for each in good.ranges:
        room = each.margins(inputs[:, each.number - 1])
        if each.is_limiting and np.all(room < 0.0):
            best = int(np.argmax(room))
            x, y = candidates[best] + 0.0
            reasons.append(
                f"none of {len(room)} points {where} has {each.text(mechanism)}; closest "
                f"comes ({x:.4g}, {y:.4g}) of the non-dimensional design, "
                f"{math.degrees(-room[best]):.4g} deg outside"
            )
    if not reasons:
        limits = " and ".join(each.text(mechanism) for each in good.ranges if each.is_limiting)
        reasons = [f"no place has {limits} throughout" if limits else f"no place {where} holds it"]
    return f"the {shape.name} fits at no size: {'; '.join(reasons)}"
