"""Singular loci of a manipulator with a passive leg as geometry, and what each is singular for.

Nam and Park 2006, Sec. 5.2. First kind: a leg stretched or folded, four curves in closed form
(:mod:`reach_arc`). Second kind: one curve that is followed numerically (:mod:`forward_arc`).
Curves are cut where they meet, where a limit is met, and where l = 0. What no usable workspace may
border on is left out: parts that the other leg does not reach, that lie beyond the limit of the
passive leg or, if they count, those of the passive joints b_i.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Collection, Iterator, Sequence
from typing import TypeVar

import numpy as np

from fivebar_atlas.mechanisms.mode_pairs import Signs, mode_label
from fivebar_atlas.mechanisms.passive_leg import forward_curve
from fivebar_atlas.mechanisms.passive_leg.forward_arc import ForwardArc, residuals
from fivebar_atlas.mechanisms.passive_leg.forward_curve import Stretch
from fivebar_atlas.mechanisms.passive_leg.points import Lengths
from fivebar_atlas.mechanisms.passive_leg.reach_arc import ReachArc, ReachCurve
from fivebar_atlas.planar_geometry import (
    CLOSED,
    INTERSECTION,
    LEFT,
    LIMIT,
    RIGHT,
    TANGENCY,
    FloatArray,
    NamedArc,
    Point,
)

Locus = TypeVar("Locus", ReachArc, ForwardArc)

SERIAL = "serial"
PARALLEL = "parallel"

# Parts of a sheet between whose ends conditions may change sign, an odd number, for at θ = 0 some
# vanish; and halvings.
_SAMPLES, _HALVINGS = 401, 60
# Ranges of θ shorter than this are rounding, as are lengths of the passive leg.
_SHORTEST = 1e-12
# A folded leg shorter than this is a point.
_POINT = 1e-9
# An end of an arc that is closer to O than this is O: there l is the root of a rounding error.
_AT_O = 1e-7
_ENDS = {
    forward_curve.STRAIGHT: TANGENCY,
    forward_curve.ALONG: INTERSECTION,
    forward_curve.LIMIT: INTERSECTION,
    forward_curve.NO_LENGTH: INTERSECTION,
    forward_curve.CLOSED: CLOSED,
}


@dataclasses.dataclass(frozen=True, slots=True)
class Curve:
    """What bounds a workspace: name, notation, kind, and why nothing goes beyond it."""

    name: str
    symbol: str
    kind: str
    reason: str


STRETCHED = (
    Curve("C_1o", "$C_{1o}$", SERIAL, "leg 1 is stretched"),
    Curve("C_2o", "$C_{2o}$", SERIAL, "leg 2 is stretched"),
)
FOLDED = (
    Curve("C_1i", "$C_{1i}$", SERIAL, "leg 1 is folded"),
    Curve("C_2i", "$C_{2i}$", SERIAL, "leg 2 is folded"),
)
SINGULAR_PLATFORM = Curve("C_x", "$C_x$", PARALLEL, "the platform moves with both inputs at rest")
LEVEL_LINKS = (
    Curve("q_1", "$q_1 = 0$", LIMIT, "the upper link of leg 1 is level with the platform"),
    Curve("q_2", "$q_2 = 0$", LIMIT, "the upper link of leg 2 is level with the platform"),
)
PASSIVE_LEG = Curve(
    "theta_max", r"$|\theta| = \theta_{\max}$", LIMIT, "the passive leg is at its limit"
)


@dataclasses.dataclass(frozen=True, slots=True)
class Limits:
    """Limits of the passive joints.

    Attributes
    ----------
    theta
        Largest angle of the passive leg from the y axis, in radians.
    joints
        Whether upper links must stay below the platform.
    """

    theta: float
    joints: bool


def singular_arcs(
    lengths: Lengths, limits: Limits, pairs: Collection[Signs]
) -> tuple[NamedArc, ...]:
    """Return all singular loci that border on workspaces of some mode pairs.

    Parameters
    ----------
    lengths
        R, r, l_a, l_b.
    limits
        Limits of the passive joints.
    pairs
        Mode pairs as ±1.

    Returns
    -------
    tuple of NamedArc
        ``sides`` names the mode pairs, among those asked for, that border on an arc.
    """
    found: list[NamedArc] = []
    for leg in (0, 1):
        for outer in (True, False):
            found.extend(_reach_arcs(lengths, limits, leg, outer, pairs))
    found.extend(_forward_arcs(lengths, limits, pairs))
    return tuple(found)


def reach_curve(lengths: Lengths, leg: int, outer: bool) -> ReachCurve:
    """Return the curve on which leg 0 or 1 is stretched (outer) or folded."""
    base, platform, l_a, l_b = lengths
    reach = l_a + l_b if outer else abs(l_a - l_b)
    return ReachCurve(base, platform, reach, 1.0 if leg == 0 else -1.0)


def isolated_points(lengths: Lengths, limits: Limits) -> tuple[Point, ...]:
    """Return singular points that no arc passes through.

    O, if both legs reach it with the passive leg within its limit: there that leg has no length,
    and C cannot move across it. And, where l_a = l_b, the points at which b_i is on B_i: there a
    folded leg turns freely.
    """
    base, platform, l_a, l_b = lengths
    points: list[Point] = []
    # squared length of both legs at l = 0, for the angles within the limit
    least = (platform - base) ** 2
    most = base**2 + platform**2 - 2.0 * base * platform * math.cos(limits.theta)
    if least < (l_a + l_b) ** 2 and most > (l_a - l_b) ** 2:
        points.append((0.0, 0.0))
    if abs(l_a - l_b) < _POINT and platform < base:
        theta = math.acos(platform / base)
        length = math.sqrt((base - platform) * (base + platform))
        other = 2.0 * length  # its height in the axes of the platform, the other leg's length
        if theta < limits.theta and other < l_a + l_b - _POINT:
            x, y = length * math.sin(theta), length * math.cos(theta)
            points += [(x, y), (-x, y)]
    return tuple(points)


def _reach_arcs(
    lengths: Lengths, limits: Limits, leg: int, outer: bool, pairs: Collection[Signs]
) -> Iterator[NamedArc]:
    """Yield the arcs on which a leg is stretched or folded and the other one reaches."""
    curve = reach_curve(lengths, leg, outer)
    if curve.reach < _POINT:
        return
    straight = _StraightLeg(lengths, limits, leg, outer, curve)
    pieces: list[_Piece] = []
    # in the order in which the sheets go on in each other where the curve turns back
    for between in curve.ranges(limits.theta):
        pieces.extend(straight.pieces(1.0, between, pairs))
        pieces.extend(each.backward() for each in reversed(straight.pieces(-1.0, between, pairs)))
    what = (STRETCHED if outer else FOLDED)[leg]
    for run in _runs(curve, pieces):
        arc = ReachArc.of_pieces(curve, tuple((each.sheet, each.start, each.end) for each in run))
        arc = _ending_at_o(arc)
        ends = (run[0].ends[0], run[-1].ends[1])
        if len(run) > 1 and _goes_on(curve, run[-1], run[0]):
            ends = (CLOSED, CLOSED)
            arc = dataclasses.replace(arc, end=arc.start)
        side = LEFT if outer else RIGHT
        sides = {mode_label(signs): side for signs in run[0].borders}
        yield NamedArc(what.name, what.symbol, what.kind, arc, ends, sides)


@dataclasses.dataclass(frozen=True, slots=True)
class _Piece:
    """A part of a sheet, the mode pairs that border on it, and what is at its ends."""

    sheet: float
    start: float
    end: float
    borders: tuple[Signs, ...]
    ends: tuple[str, str]

    def backward(self) -> _Piece:
        return dataclasses.replace(
            self, start=self.end, end=self.start, ends=(self.ends[1], self.ends[0])
        )


def _runs(curve: ReachCurve, pieces: Sequence[_Piece]) -> list[list[_Piece]]:
    """Join pieces that follow each other and border on the same."""
    runs: list[list[_Piece]] = []
    for piece in pieces:
        if not piece.borders:
            continue
        if runs and _goes_on(curve, runs[-1][-1], piece):
            runs[-1].append(piece)
        else:
            runs.append([piece])
    # the last one may go on in the first one of the same range
    for place, run in enumerate(runs):
        for other in runs[:place]:
            if other and _goes_on(curve, run[-1], other[0]):
                other[:0] = run
                runs[place] = []
                break
    return [run for run in runs if run]


def _goes_on(curve: ReachCurve, one: _Piece, two: _Piece) -> bool:
    """Tell whether a piece goes on in another one that borders on the same."""
    if one.end != two.start or one.borders != two.borders:
        return False
    if one.sheet == two.sheet:
        return True
    # the sheets meet where the curve turns back
    gap = curve.arm - curve.base * math.cos(one.end)
    return abs(abs(gap) - curve.reach) <= _POINT


# Conditions on a reach curve: l; how far the other leg is from being stretched and folded; f and q
# of the other leg for its elbow +1 and -1; q of this leg.
_LENGTH, _OUTER, _INNER, _F_UP, _F_DOWN, _Q_UP, _Q_DOWN, _Q = range(8)


@dataclasses.dataclass(frozen=True, slots=True)
class _StraightLeg:
    """Poses in which leg 0 or 1 is stretched or folded.

    Attributes
    ----------
    lengths, limits
        The design.
    leg, outer
        Which leg, and whether it is stretched.
    curve
        Where that is.
    """

    lengths: Lengths
    limits: Limits
    leg: int
    outer: bool
    curve: ReachCurve

    def pieces(
        self, sheet: float, between: tuple[float, float], pairs: Collection[Signs]
    ) -> list[_Piece]:
        """Cut a sheet over a range of θ where what borders on it changes; return its parts."""
        cuts = dict.fromkeys(between, INTERSECTION)
        for angle in self.curve.angles_at_no_length():
            if between[0] < angle < between[1]:
                cuts[angle] = INTERSECTION
        share = np.linspace(0.0, 1.0, _SAMPLES + 1)
        theta = between[0] + (between[1] - between[0]) * share**2 * (3.0 - 2.0 * share)
        values = self.conditions(theta, sheet)
        with np.errstate(invalid="ignore"):
            which, place = np.nonzero(values[:, :-1] * values[:, 1:] < 0.0)
        low, high, at_low = theta[place], theta[place + 1], values[which, place]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            here = self.conditions(middle, sheet)[which, np.arange(len(which))]
            same = here * at_low > 0.0
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        for angle, condition in zip(low.tolist(), which.tolist(), strict=True):
            cuts[angle] = TANGENCY if condition in (_F_UP, _F_DOWN) else INTERSECTION
        found: list[_Piece] = []
        for start, end in itertools.pairwise(sorted(cuts)):
            if end - start < _SHORTEST:
                continue
            borders = self.borders(0.5 * (start + end), sheet, pairs)
            first, begun = cuts[start], start
            if found and found[-1].borders == borders and found[-1].end == start:
                before = found.pop()
                first, begun = before.ends[0], before.start
            found.append(_Piece(sheet, begun, end, borders, (first, cuts[end])))
        return found

    def conditions(self, theta: FloatArray, sheet: float) -> FloatArray:
        """Return the conditions at angles, shape (8, n); NaN where the other leg cannot be."""
        base, platform, l_a, l_b = self.lengths
        c, s = np.cos(theta), np.sin(theta)
        length = self.curve.lengths(theta, sheet)
        own, side = self.curve.leg, -self.curve.leg
        share = (l_b if self.outer else math.copysign(l_b, l_b - l_a)) / self.curve.reach
        p, q = share * own * (platform - base * c), share * (length + own * base * s)
        e, f = side * (platform - base * c), length + side * base * s
        reach2 = e * e + f * f
        values = np.empty((8, len(theta)))
        values[_LENGTH], values[_Q] = length, q
        values[_OUTER], values[_INNER] = (l_a + l_b) ** 2 - reach2, reach2 - (l_a - l_b) ** 2
        with np.errstate(invalid="ignore", divide="ignore"):
            root = np.sqrt(values[_OUTER] * values[_INNER])
            along = 0.5 * (reach2 + (l_b - l_a) * (l_b + l_a)) / reach2
            for elbow, row_f, row_q in ((1.0, _F_UP, _Q_UP), (-1.0, _F_DOWN, _Q_DOWN)):
                across = -0.5 * elbow * root / reach2
                p_other, q_other = along * e - across * f, along * f + across * e
                crossed = own * (p * q_other - p_other * q)
                values[row_f] = length * crossed - 2.0 * platform * q * q_other
                values[row_q] = q_other
        return values

    def borders(self, theta: float, sheet: float, pairs: Collection[Signs]) -> tuple[Signs, ...]:
        """Return the mode pairs that border on a point."""
        values = self.conditions(np.array([theta]), sheet)[:, 0]
        if not min(values[_LENGTH], values[_OUTER], values[_INNER]) > 0.0:
            return ()
        if self.limits.joints and not values[_Q] > 0.0:
            return ()
        found = []
        for signs in pairs:
            is_up = signs[1 - self.leg] < 0  # the elbow of the other leg
            f, q = values[[_F_UP, _Q_UP] if is_up else [_F_DOWN, _Q_DOWN]]
            if signs[2] * f < 0.0 and (q > 0.0 or not self.limits.joints):
                found.append(signs)
        return tuple(found)


def _forward_arcs(lengths: Lengths, limits: Limits, pairs: Collection[Signs]) -> Iterator[NamedArc]:
    """Yield the arcs on which J_x is singular, one working mode each."""
    what = SINGULAR_PLATFORM
    for stretch in forward_curve.forward_curve(lengths, limits.theta):
        if limits.joints and not stretch.below:
            continue
        borders = [signs for signs in pairs if (-signs[0], -signs[1]) == stretch.elbows]
        if not borders:
            continue
        arc = _ending_at_o(ForwardArc.through(lengths, stretch.nodes))
        ends = (_ENDS[stretch.ends[0]], _ENDS[stretch.ends[1]])
        if ends == (CLOSED, CLOSED):
            arc = dataclasses.replace(arc, end=arc.start)
        up = LEFT if _up_is_left(lengths, stretch) else RIGHT
        down = RIGHT if up == LEFT else LEFT
        sides = {mode_label(signs): up if signs[2] > 0 else down for signs in borders}
        yield NamedArc(what.name, what.symbol, what.kind, arc, ends, sides)


def _ending_at_o(arc: Locus) -> Locus:
    """Return an arc that ends at O itself where rounding is all that is between O and its end."""
    start, end = ((0.0, 0.0) if math.hypot(*at) < _AT_O else at for at in (arc.start, arc.end))
    return dataclasses.replace(arc, start=start, end=end)


def _up_is_left(lengths: Lengths, stretch: Stretch) -> bool:
    """Tell whether det J_x is negative on the left of a stretch."""
    place = len(stretch.nodes) // 2
    before = stretch.nodes[place - 1]
    node = ForwardArc.through(lengths, stretch.nodes[place - 1 : place + 1]).at(np.array([0.5]))[0]
    change = stretch.nodes[place] - before
    _, slopes = residuals(lengths, node[None])
    # χ follows l and θ so that the legs stay closed
    f_pose, f_chi = slopes[0, 0, :2], slopes[0, 0, 2:]
    chi_pose = -slopes[0, 1:, :2] / np.diagonal(slopes[0, 1:, 2:])[:, None]
    by_length, by_theta = f_pose + f_chi @ chi_pose
    # a step to the left of (δl, δθ) in the plane is (-l δθ, δl / l)
    return bool(-node[0] * change[1] * by_length + change[0] / node[0] * by_theta < 0.0)
