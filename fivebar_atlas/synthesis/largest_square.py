"""The largest square workspace of one design (Le, Kang and Doan 2013, Sec. III).

The square has sides parallel to the axes and is centred in the maximal inscribed circle (MIC)
of the usable workspace, which it lies in. The LCI is nowhere in it below a threshold, and the
inputs keep to the ranges of their actuators. The paper shrinks a square until samples of it
fulfil all that; here the side is where the square first touches what is not allowed, closed in
on to rounding, and that the whole square is good is proved. Lengths are in those of the
actuated link.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fivebar_atlas.errors import InfeasibleSizeError, InputError, UnknownNameError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import CircleArc, FloatArray, Point
from fivebar_atlas.synthesis.active_constraints import active_constraints
from fivebar_atlas.synthesis.containment import ActuatorRange, GoodCondition, Proof, check_ranges
from fivebar_atlas.synthesis.scale_search import ROUNDS, ScaleSearch, Touch, largest_at
from fivebar_atlas.synthesis.shapes import Shape

#: Where the centre is: that of the maximal inscribed circle, or wherever on the y axis it is best.
MIC, AXIS = "mic", "axis"
CENTRES = (MIC, AXIS)
#: Which maximal inscribed circle: its centre above or below the base.
UPPER, LOWER = "upper", "lower"
HALVES = (UPPER, LOWER)

#: Name of the constraint that the square lies in the maximal inscribed circle.
IN_CIRCLE = "maximal inscribed circle"

#: Margins up to this hold with equality.
ACTIVE = 1e-10
#: The same where a design or a centre is known to no more than that.
CLOSE = 1e-7
# Chords of an outline whose extent is all that matters may leave it by so much.
_ANY_DEVIATION = 1e-3
# Positions of a scan of the axis, and local maxima among them that are closed in on.
_POSITIONS, _STARTS = 101, 4


@dataclasses.dataclass(frozen=True)
class SquareTask:
    """What is asked of a square.

    Attributes
    ----------
    mechanism
        The mechanism.
    mode
        Mode pair.
    lci_threshold
        γ, the least LCI, in (0, 1).
    ranges
        Ranges of actuators.
    aspect
        Width over height; 1 for a square.
    centre
        ``"mic"`` or ``"axis"``.
    half
        ``"upper"`` or ``"lower"``: on which side of the base the centre is.

    Raises
    ------
    InputError
        If the threshold is not in (0, 1), or the aspect not positive and finite.
    UnknownNameError
        If there is no such mode pair, centre or half.
    """

    mechanism: Mechanism
    mode: str
    lci_threshold: float = 0.5
    ranges: tuple[ActuatorRange, ...] = ()
    aspect: float = 1.0
    centre: str = MIC
    half: str = UPPER

    def __post_init__(self) -> None:
        self.mechanism.check_thresholds([self.lci_threshold], "γ")
        self.mechanism.parse_mode(self.mode)
        if not (math.isfinite(self.aspect) and self.aspect > 0.0):
            raise InputError("aspect", self.aspect, "a finite ratio of width to height above 0")
        some = self.mechanism.planar_design(self.mechanism.optimal_configuration(2.0).lengths, "")
        check_ranges(self.ranges, some, self.mode)
        for name, value, known in (
            ("centre", self.centre, CENTRES),
            ("half", self.half, HALVES),
        ):
            if value not in known:
                raise UnknownNameError(name, value, known)

    @property
    def shape(self) -> Shape:
        """The rectangle whose area is 1."""
        root = math.sqrt(self.aspect)
        return Shape.rectangle(root, 1.0 / root)


@dataclasses.dataclass(frozen=True)
class Square:
    """The largest square of a design, or the largest rectangle of an aspect.

    Lengths are those of a machine whose actuated link has the length 1.

    Attributes
    ----------
    task
        What was asked.
    lengths
        Lengths of the machine, the first one 1.
    side
        Side of the square; of a rectangle the side of the square of its area. 0 where there is
        none.
    centre
        Its centre.
    circle
        The maximal inscribed circle of the half; None where there is none.
    active
        The limits that keep it from being larger.
    contacts
        Its points that touch, in the plane.
    proof
        Proof that all of it is good; None where there is no square or none was asked for.
    """

    task: SquareTask
    lengths: tuple[float, ...]
    side: float
    centre: Point
    circle: CircleArc | None
    active: tuple[str, ...]
    contacts: tuple[Point, ...]
    proof: Proof | None

    @property
    def width(self) -> float:
        """Length of the sides along x."""
        return self.side * math.sqrt(self.task.aspect)

    @property
    def height(self) -> float:
        """Length of the sides along y."""
        return self.side / math.sqrt(self.task.aspect)

    @property
    def ratio(self) -> float:
        """ρ, the second length over the first."""
        return self.lengths[1] / self.lengths[0]


def unit_design(mechanism: Mechanism, lengths: tuple[float, ...]) -> tuple[PlanarDesign, float]:
    """Return the non-dimensional design of lengths, and its dimensional factor D."""
    return mechanism.planar_design(lengths, ""), mechanism.from_lengths(lengths)[1]


def largest_square(
    task: SquareTask,
    lengths: tuple[float, ...],
    is_proved: bool = True,
    tolerance: float = ACTIVE,
) -> Square:
    """Return the largest square of a machine.

    Parameters
    ----------
    task
        What is asked of it.
    lengths
        Lengths of the machine, the first one 1.
    is_proved
        Whether it is proved that all of it is good.
    tolerance
        Margins up to this count as none, for active constraints and contacts.

    Returns
    -------
    Square
        Of side 0 where there is none: no inscribed circle, or its centre is not good itself.

    Raises
    ------
    InputError
        If the lengths make no mechanism.
    """
    design, factor = unit_design(task.mechanism, lengths)
    good = GoodCondition(design, task.mode, task.lci_threshold, task.ranges)
    circle = _circle(design, task)
    scaled = None if circle is None else circle.scaled(factor)
    shape = task.shape
    if task.centre == AXIS:
        centre, touch = _largest_on_axis(good, shape, task.half, is_proved)
        limit = math.inf
    elif circle is not None:
        centre = np.array(circle.centre)
        limit = circle.radius / float(np.hypot(*shape.corners[0]))
        touch = largest_at(good, shape, centre, limit, is_proved)
    else:
        return Square(task, lengths, 0.0, (math.nan, math.nan), None, (), (), None)
    square = _square(task, lengths, good, factor, centre, scaled, touch, tolerance)
    if touch.scale == limit:
        return dataclasses.replace(square, active=(IN_CIRCLE, *square.active))
    return square


def square_at(
    task: SquareTask,
    lengths: tuple[float, ...],
    good: GoodCondition,
    factor: float,
    centre: FloatArray,
    scale: float,
) -> Square:
    """Return the square at a centre that is given, no larger than at a scale.

    Parameters
    ----------
    task
        What is asked of it.
    lengths
        Lengths of the machine, the first one 1.
    good
        The same for the points of the non-dimensional design.
    factor
        Dimensional factor of the machine.
    centre
        Centre in the non-dimensional design, shape (2,).
    scale
        Side in it.
    """
    touch = largest_at(good, task.shape, centre, scale)
    circle = _circle(good.design, task)
    scaled = None if circle is None else circle.scaled(factor)
    return _square(task, lengths, good, factor, centre, scaled, touch, CLOSE)


def _square(
    task: SquareTask,
    lengths: tuple[float, ...],
    good: GoodCondition,
    factor: float,
    centre: FloatArray,
    circle: CircleArc | None,
    touch: Touch,
    tolerance: float,
) -> Square:
    """Return a square from what is known of it in the non-dimensional design.

    Contacts are points whose margin is within a tolerance of zero.
    """
    margins = good.margins(centre + touch.scale * touch.contacts)
    contacts = touch.contacts[margins <= tolerance]
    points = factor * (centre + touch.scale * contacts)
    return Square(
        task=task,
        lengths=lengths,
        side=factor * touch.scale,
        centre=(factor * float(centre[0]), factor * float(centre[1])),
        circle=circle,
        active=active_constraints(good, task.shape, centre, touch.scale, contacts, tolerance),
        contacts=tuple((float(x), float(y)) for x, y in points),
        proof=touch.proof,
    )


def why_none(square: Square) -> str:
    """Return why there is no square, and which limit to relax."""
    task = square.task
    what = "square" if task.aspect == 1.0 else "rectangle"
    if task.centre == MIC and square.circle is None:
        return (
            f"no {what}: {task.mode} has no inscribed circle centred on the {task.half} half axis"
        )
    design, factor = unit_design(task.mechanism, square.lengths)
    if task.centre == AXIS:
        return f"no {what}: no point of the {task.half} half axis is good in {task.mode}"
    good = GoodCondition(design, task.mode, task.lci_threshold, task.ranges)
    x, y = (np.array([part / factor]) for part in square.centre)
    lci = float(design.lci_inside(x, y, task.mode)[0])
    reasons = []
    if lci < task.lci_threshold:
        reasons.append(f"the LCI is {lci:.6g} there and {task.lci_threshold:.12g} is asked for")
    inputs = design.inputs(x, y, task.mode)[0]
    for each in good.ranges:
        room = float(each.margins(inputs[each.number - 1 : each.number])[0])
        if each.is_limiting and room < 0.0:
            angle = math.degrees(inputs[each.number - 1])
            name = task.mechanism.input_text(each.number)
            reasons.append(
                f"{name} is {angle:.6g} deg there, {math.degrees(-room):.4g} deg outside of "
                f"{each.text(task.mechanism)}"
            )
    place = f"({square.centre[0] + 0.0:.6g}, {square.centre[1]:.6g})"
    return f"no {what}: its centre {place} is not allowed, for {' and '.join(reasons)}"


def check_ranges_allow(task: SquareTask, ratio: float) -> None:
    """Raise InfeasibleSizeError if a range excludes the optimal configuration of a ratio."""
    optimal = task.mechanism.optimal_configuration(ratio)
    design, factor = unit_design(task.mechanism, optimal.lengths)
    x, y = (np.array([part / factor]) for part in optimal.output)
    inputs = design.inputs(x, y, optimal.mode)[0]
    reasons = []
    for each in GoodCondition(design, optimal.mode, task.lci_threshold, task.ranges).ranges:
        angle = inputs[each.number - 1]
        room = float(each.margins(np.array([angle]))[0])
        if each.is_limiting and room < 0.0:
            name = task.mechanism.input_text(each.number)
            asked = each.text(task.mechanism)
            reasons.append(f"{name} = {math.degrees(angle):g} deg and {asked}")
    if reasons:
        raise InfeasibleSizeError(
            f"limits exclude the optimal configuration: it has {' and '.join(reasons)} is asked for"
        )


def _circle(design: PlanarDesign, task: SquareTask) -> CircleArc | None:
    """Return the maximal inscribed circle of the half that is asked for."""
    sign = 1.0 if task.half == UPPER else -1.0
    circles = [each for each in design.inscribed_circles(task.mode) if sign * each.centre[1] > 0.0]
    return max(circles, key=lambda each: each.radius, default=None)


def _largest_on_axis(
    good: GoodCondition, shape: Shape, half: str, is_proved: bool
) -> tuple[FloatArray, Touch]:
    """Return the centre on a half of the y axis with the largest scale, and that scale."""
    workspace = good.design.usable_workspace(good.mode)
    if workspace is None:
        return np.zeros(2), Touch(0.0, np.empty((0, 2)), None)
    corners = np.concatenate(workspace.region.polygons(_ANY_DEVIATION))
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    if half == UPPER:
        lower[1] = max(lower[1], 0.0)
    else:
        upper[1] = min(upper[1], 0.0)
    if not lower[1] < upper[1]:
        return np.zeros(2), Touch(0.0, np.empty((0, 2)), None)
    limit = float(
        np.min((corners.max(axis=0) - corners.min(axis=0)) / np.subtract(*reversed(shape.extent)))
    )
    search = ScaleSearch(good, shape, None, limit, [])
    best = np.zeros(2), Touch(0.0, np.empty((0, 2)), None)
    for centre, scale in _best_on_axis(search, float(lower[1]), float(upper[1])):
        if scale <= best[1].scale:
            break
        # smaller than that where it is around a hole that its boundary cannot see
        touch = largest_at(good, shape, centre, scale, is_proved)
        best = max(best, (centre, touch), key=lambda each: each[1].scale)
    return best


def _best_on_axis(
    search: ScaleSearch, lower: float, upper: float
) -> list[tuple[FloatArray, float]]:
    """Return centres on a part of the y axis with locally largest scales, the best first."""
    y = np.linspace(lower, upper, _POSITIONS + 2)[1:-1]
    anchors = np.column_stack([np.zeros(len(y)), y])
    scales = search.scan(anchors)
    padded = np.pad(scales, 1, constant_values=-np.inf)
    tops = np.flatnonzero((scales >= padded[:-2]) & (scales >= padded[2:]) & (scales > 0.0))
    tops = tops[np.argsort(-scales[tops], kind="stable")][:_STARTS]
    found = [search.improve(anchors[top], False, ROUNDS) for top in tops]
    return sorted(found, key=lambda each: -each[1])
