"""Whether a five-bar can follow a path of straight segments in one mode pair.

A path that begins in the usable workspace leaves it at the first point where a leg is straight
(A singular) or the distal links are in line (B singular), and nowhere else: the workspace is
a connected component of what is left without those points (Liu, Wang and Zheng 2006, Sec. 4
and 7). So nothing is sampled. A segment P(s) = P0 + s u, u a unit vector, has

- the points where it meets the four reach circles and the two fold circles, by square roots;
- those where it meets C_col among the roots of a polynomial of degree six. With w the vector
  from B1 to P less (r3, 0), C_col means |P - w| = |P + w| = r1 and |w + (r3, 0)| = r2: w is
  normal to P, |w|² = r1² - ρ², and 2 r3 w_x = ρ² - (r1² + r3² - r2²), so that

      (r1² + r3² - r2² - ρ²)² ρ² = 4 r3² y² (r1² - ρ²).

The roots belong to any working mode. Which of them are singular for this one is read from
sin γ, γ the angle from B1P to B2P, which vanishes with det B: its sign between neighbouring
roots, and its least value next to them, which finds also what roots lose that nearly coincide.

Most segments need none of that: sin γ cannot vanish on a segment that is too short for its
bounded rate. When P moves, a distal link turns by no more than 1 / (r2 sin β_i) of the way.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.coupler_curve import CouplerArc
from fivebar_atlas.mechanisms.five_bar.loci import (
    COUPLER,
    FOLD_DOWN,
    FOLD_UP,
    REACH_1I,
    REACH_1O,
    REACH_2I,
    REACH_2O,
    Curve,
    Lengths,
    isolated_points,
)
from fivebar_atlas.mechanisms.five_bar.outline import UsableWorkspace, usable_workspace_of
from fivebar_atlas.mechanisms.five_bar.points import elbows_at, inverse_at, lci_at
from fivebar_atlas.mechanisms.five_bar.singularity import fold_height
from fivebar_atlas.mechanisms.mode_pairs import Signs, mode_label
from fivebar_atlas.mechanisms.paths import checked_corners, columns, nearest_of
from fivebar_atlas.mechanisms.planar import PathFault, PathReport
from fivebar_atlas.planar_geometry import Point

#: What comes closer than this to a singular point (lengths sum to 3) counts as on it.
TOUCH = 1e-12

# That of sin γ, where its slope is moderate.
_ROUNDING = 2e-15
# Segments that are looked at together.
_BLOCK = 4096
# Golden sections, with which the least value of sin γ is closed in on.
_GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))
_GOLDEN_STEPS = 80

_REACH_CURVES = (REACH_1O, REACH_1I, REACH_2O, REACH_2I)
_WHY = {
    REACH_1O: "leg 1 is stretched",
    REACH_1I: "leg 1 is folded",
    REACH_2O: "leg 2 is stretched",
    REACH_2I: "leg 2 is folded",
    FOLD_UP: "B1 and B2 coincide",
    FOLD_DOWN: "B1 and B2 coincide",
    COUPLER: "B1, P and B2 are in line",
}

BoolArray = npt.NDArray[np.bool_]


def check_path(lengths: Lengths, signs: Signs, points: npt.ArrayLike) -> PathReport:
    """Tell whether a path can be followed in a mode pair, exactly between its corners too.

    A path is feasible if all its points lie in the usable workspace, farther than ``TOUCH``
    from its boundary. Corners may repeat.

    Parameters
    ----------
    lengths
        r1, r2, r3, non-dimensional.
    signs
        Working mode and assembly mode as ±1.
    points
        Corners, shape (n, 2), non-dimensional, joined by straight segments.

    Returns
    -------
    PathReport
        Input angles in radians: in (-π, π] at the first corner, and continuous along the
        path from there. Distances are those from the boundary of the usable workspace,
        isolated singular points included.

    Raises
    ------
    InputError
        If there are no points, or not two finite coordinates for each.
    """
    corners = checked_corners(points)
    workspace = usable_workspace_of(lengths, signs)
    fault = _fault_at_start(lengths, signs, workspace, corners[0])
    if fault is not None:
        followed = 0
    else:
        fault = _first_fault(lengths, signs, corners)
        followed = len(corners) if fault is None else fault.segment + (fault.share > 0.0)
    inputs = np.full((len(corners), 2), np.nan)
    lci, distances = np.full(len(corners), np.nan), np.full(len(corners), np.nan)
    nearest = [""] * len(corners)
    if workspace is not None and followed > 0:
        reached = corners[:followed]
        inputs[:followed] = _input_angles(lengths, signs, reached)
        lci_at(*lengths, *columns(reached), float(signs[0]), float(signs[1]), lci[:followed])
        distances[:followed], nearest[:followed] = boundary_distances(lengths, workspace, reached)
    return PathReport(mode_label(signs), corners, inputs, lci, distances, tuple(nearest), fault)


@dataclasses.dataclass(frozen=True, slots=True)
class _Regularity:
    """How far points are from being singular in a mode pair.

    Attributes
    ----------
    slack
        Distance from the reach circles, that within which a leg does not reach negative,
        shape (..., 4) in the order of ``_REACH_CURVES``.
    sine, cosine
        Those of γ, the sine positive in the assembly mode; infinite and NaN beyond reach.
    least_sine
        Sine that a singular point at a distance of ``TOUCH``, or rounding, may account for.
    """

    slack: FloatArray
    sine: FloatArray
    cosine: FloatArray
    least_sine: FloatArray

    @property
    def on_locus(self) -> BoolArray:
        """Whether points are singular, or beyond a singular locus."""
        return np.asarray((self.slack.min(axis=-1) <= TOUCH) | (self.sine <= self.least_sine))


def _regularity(lengths: Lengths, signs: Signs, points: FloatArray) -> _Regularity:
    """Return how far points, shape (..., 2), are from being singular.

    A distal link turns by the way of P along its crank over r2 sin β_i, so that γ has the
    gradient 2 s2 A2B2 / w2 - 2 s1 A1B1 / w1, up to sign, with w_i = 2 r1 r2 sin β_i.
    """
    r1, r2, r3 = lengths
    x, y = points[..., 0], points[..., 1]
    elbows = np.empty((x.size, 4))
    elbows_at(*lengths, *columns(points), float(signs[0]), float(signs[1]), elbows)
    b1x, b1y, b2x, b2y = elbows.T.reshape(4, *x.shape)
    slack = []
    slope_x, slope_y, rounding = np.zeros(x.shape), np.zeros(x.shape), np.ones(x.shape)
    for side, base, bx, by in ((-signs[0], -r3, b1x, b1y), (signs[1], r3, b2x, b2y)):
        reach = np.hypot(x - base, y)
        slack += [r1 + r2 - reach, reach - abs(r1 - r2)]
        four_areas = np.sqrt(np.maximum(_squared_four_areas(lengths, reach**2), 1e-300))
        slope_x = slope_x + 2.0 * side * (bx - base) / four_areas
        slope_y = slope_y + 2.0 * side * by / four_areas
        rounding = rounding + 2.0 * r1 * reach / four_areas
    sine = signs[2] * ((x - b1x) * (y - b2y) - (y - b1y) * (x - b2x)) / (r2 * r2)
    cosine = ((x - b1x) * (x - b2x) + (y - b1y) * (y - b2y)) / (r2 * r2)
    return _Regularity(
        np.stack(slack, axis=-1),
        np.where(np.isnan(sine), np.inf, sine),
        cosine,
        TOUCH * np.hypot(slope_x, slope_y) + _ROUNDING * rounding,
    )


def _squared_four_areas(lengths: Lengths, reach2: FloatArray) -> FloatArray:
    """Return (2 r1 r2 sin β)² for squared distances of P from a base joint."""
    outer, inner = lengths[0] + lengths[1], lengths[0] - lengths[1]
    return (outer * outer - reach2) * (reach2 - inner * inner)


def _fault_at_start(
    lengths: Lengths, signs: Signs, workspace: UsableWorkspace | None, start: FloatArray
) -> PathFault | None:
    """Return why a path cannot begin at a point, None if it can."""
    x, y = (float(each) for each in start)

    def fault(phrase: str, gap: float = 0.0) -> PathFault:
        return PathFault(0, 0.0, (x, y), "", "", "", phrase, gap)

    if workspace is None:
        return fault(f"the usable workspace of {mode_label(signs)} is empty")
    state = _regularity(lengths, signs, start)
    worst = int(np.argmin(state.slack))
    if state.slack[worst] < -TOUCH:
        leg = 1 if worst < 2 else 2
        near = f", too near to A{leg}" if worst % 2 else ""
        gap = -float(state.slack[worst])
        return fault(f"P is out of reach of leg {leg}{near}, by {{gap}}", gap)
    if state.sine < -state.least_sine:
        return fault("P lies in the other assembly mode")
    if state.on_locus:
        return _fault(lengths, signs, 0, 0.0, (x, y))
    if not workspace.contains(x, y):
        return fault(
            "P lies in another part of the workspace, not connected with the usable workspace"
        )
    return None


def _first_fault(lengths: Lengths, signs: Signs, corners: FloatArray) -> PathFault | None:
    """Return the first singular point of a path that begins in the usable workspace."""
    for first in range(0, len(corners) - 1, _BLOCK):
        starts = corners[first : first + _BLOCK]
        ends = corners[first + 1 : first + _BLOCK + 1]
        starts = starts[: len(ends)]
        # nothing matters after the first corner on a locus, and all before are regular
        bad = np.flatnonzero(_regularity(lengths, signs, ends).on_locus)
        if bad.size:
            starts, ends = starts[: bad[0] + 1], ends[: bad[0] + 1]
        unsure = np.flatnonzero(~_surely_regular(lengths, signs, starts, ends))
        if unsure.size:
            fault = _fault_on(lengths, signs, starts[unsure], ends[unsure], first + unsure)
            if fault is not None:
                return fault
        if bad.size:
            end = (float(ends[-1, 0]), float(ends[-1, 1]))
            return _fault(lengths, signs, first + int(bad[0]), 1.0, end)
    return None


def _surely_regular(
    lengths: Lengths, signs: Signs, starts: FloatArray, ends: FloatArray
) -> BoolArray:
    """Tell which segments between regular points are too short to meet a singular point."""
    r1, _, r3 = lengths
    along = ends - starts
    length2 = np.maximum((along**2).sum(axis=1), 1e-300)
    rate = np.zeros(len(starts))
    inside = np.ones(len(starts), dtype=bool)
    for base in (-r3, r3):
        from_base = starts - np.array([base, 0.0])
        share = np.clip(-(from_base * along).sum(axis=1) / length2, 0.0, 1.0)
        least2 = ((from_base + share[:, None] * along) ** 2).sum(axis=1)
        most2 = np.maximum((from_base**2).sum(axis=1), ((from_base + along) ** 2).sum(axis=1))
        # concave in the squared distance: least at one of the ends
        areas2 = np.minimum(
            _squared_four_areas(lengths, least2), _squared_four_areas(lengths, most2)
        )
        inside &= areas2 > 0.0
        rate += 2.0 * r1 / np.sqrt(np.maximum(areas2, 1e-300))
    way = np.zeros(len(starts))
    for points in (starts, ends):
        state = _regularity(lengths, signs, points)
        # γ may go to 0 or to π
        way += np.arctan2(np.maximum(state.sine, 0.0), np.abs(state.cosine))
    return np.asarray(inside & (way > (1.0 + 1e-9) * rate * np.sqrt(length2)))


def _fault_on(
    lengths: Lengths,
    signs: Signs,
    starts: FloatArray,
    ends: FloatArray,
    numbers: npt.NDArray[np.int64],
) -> PathFault | None:
    """Return the first singular point on segments that begin at regular points.

    Parameters
    ----------
    lengths, signs
        Design and mode pair.
    starts, ends
        Segments in the order of the path, shape (n, 2).
    numbers
        Their numbers in the path, shape (n,).
    """
    along = ends - starts
    length = np.hypot(along[:, 0], along[:, 1])
    unit = along / np.maximum(length, 1e-300)[:, None]
    serial, curves = _reach_crossings(lengths, starts, unit, length)
    before, after = _parallel_crossings(lengths, signs, starts, unit, np.minimum(serial, length))
    hits = np.flatnonzero(np.isfinite(before) | (serial <= length))
    if not hits.size:
        return None
    hit = int(hits[0])
    curve: Curve | None = None
    if np.isfinite(before[hit]):
        s = _closed_in(lengths, signs, starts[hit], unit[hit], before[hit], after[hit])
    else:
        s, curve = float(serial[hit]), _REACH_CURVES[int(curves[hit])]
    position = starts[hit] + s * unit[hit]
    return _fault(
        lengths,
        signs,
        int(numbers[hit]),
        min(s / float(length[hit]), 1.0),
        (float(position[0]), float(position[1])),
        curve,
    )


def _reach_crossings(
    lengths: Lengths, starts: FloatArray, unit: FloatArray, length: FloatArray
) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """Return where segments first meet a reach circle, infinite if nowhere, and which."""
    r1, r2, r3 = lengths
    firsts = []
    for base in (-r3, r3):
        for radius in (r1 + r2, abs(r1 - r2)):
            roots = _circle_crossings((base, 0.0), radius, starts, unit)
            roots[~((roots >= 0.0) & (roots <= length[:, None]))] = np.inf
            firsts.append(roots.min(axis=1))
    found = np.stack(firsts)
    curves = np.argmin(found, axis=0)
    return found[curves, np.arange(len(starts))], curves


def _circle_crossings(
    centre: Point, radius: float, starts: FloatArray, unit: FloatArray
) -> FloatArray:
    """Return where lines meet a circle, shape (n, 2); NaN where they pass it.

    A line that passes no farther than ``TOUCH`` outside meets it where it comes closest.
    """
    to_centre = np.array(centre) - starts
    middle = (to_centre * unit).sum(axis=1)
    gap = np.abs(to_centre[:, 0] * unit[:, 1] - to_centre[:, 1] * unit[:, 0])
    half = np.sqrt(np.maximum((radius - gap) * (radius + gap), 0.0))
    half[gap > radius + TOUCH] = np.nan
    return np.stack([middle - half, middle + half], axis=1)


def _parallel_crossings(
    lengths: Lengths, signs: Signs, starts: FloatArray, unit: FloatArray, length: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return brackets of the first parallel singularities along reachable segments.

    Returns
    -------
    before, after : ndarray
        Shape (n,): sin γ has the right sign before and the wrong one after; equal where it
        only touches zero; infinite where there is no singularity.
    """
    r1, r2, r3 = lengths
    height = fold_height(r1, r3)  # for r1 < r3, where it is 0, no more than useless places
    places = [
        np.zeros((len(starts), 1)),
        length[:, None],
        np.nan_to_num(_circle_crossings((0.0, height), r2, starts, unit)),
        np.nan_to_num(_circle_crossings((0.0, -height), r2, starts, unit)),
        _coupler_places(lengths, starts, unit),
    ]
    ends = np.sort(np.clip(np.concatenate(places, axis=1), 0.0, length[:, None]), axis=1)
    s = np.empty((len(starts), 2 * ends.shape[1] - 1))
    s[:, ::2] = ends
    s[:, 1::2] = 0.5 * (ends[:, :-1] + ends[:, 1:])
    state = _along(lengths, signs, starts, unit, s)
    rows = np.arange(len(starts))
    wrong = state.sine <= state.least_sine
    wrong[:, 0] = False  # known to be regular
    first = np.where(wrong.any(axis=1), wrong.argmax(axis=1), s.shape[1])

    before, after = np.full(len(starts), np.inf), np.full(len(starts), np.inf)
    hit = rows[first < s.shape[1]]
    at = first[hit]
    before[hit], after[hit] = s[hit, at - 1], s[hit, at]
    # where sin γ is zero but for rounding, it changes sign there or goes on as before
    following = np.minimum(at + 1, s.shape[1] - 1)
    zero = state.sine[hit, at] >= -state.least_sine[hit, at]
    changes = state.sine[hit, following] < -state.least_sine[hit, following]
    after[hit] = np.where(zero & changes, s[hit, following], after[hit])
    before[hit] = np.where(zero & ~changes, after[hit], before[hit])

    # before that, where it is least among neighbours and may be zero between them
    low = (state.sine[:, 1:-1] <= state.sine[:, :-2]) & (state.sine[:, 1:-1] <= state.sine[:, 2:])
    low &= np.arange(1, s.shape[1] - 1) < first[:, None]
    row, column = np.nonzero(low)
    around = starts[row, None] + s[row[:, None], column[:, None] + [0, 2], None] * unit[row, None]
    unsure = ~_surely_regular(lengths, signs, around[:, 0], around[:, 1])
    row, column = row[unsure], column[unsure]
    least = _least_sines(
        lengths,
        signs,
        starts[row],
        unit[row],
        s[row, column],
        s[row, column + 1],
        s[row, column + 2],
    )
    state = _along(lengths, signs, starts[row], unit[row], least[:, None])
    sine, least_sine = state.sine[:, 0], state.least_sine[:, 0]
    for k in np.flatnonzero(sine <= least_sine)[::-1]:  # the first one of a segment stays
        after[row[k]] = least[k]
        before[row[k]] = s[row[k], column[k]] if sine[k] < -least_sine[k] else least[k]
    return before, after


def _coupler_places(lengths: Lengths, starts: FloatArray, unit: FloatArray) -> FloatArray:
    """Return the real parts of all points where lines meet C_col, shape (n, 6).

    In t, counted along the line from the point closest to the origin, at p from it,
    ρ² = p² + t² and y is linear: the polynomial is monic and its roots are no larger than
    the links, however long the segment is.
    """
    r1, r2, r3 = lengths
    foot = -(starts * unit).sum(axis=1)
    closest = starts + foot[:, None] * unit
    p2 = (closest**2).sum(axis=1)
    lever = r1 * r1 + r3 * r3 - r2 * r2 - p2
    rest = r1 * r1 - p2
    wide = 4.0 * r3 * r3
    y0, y1 = closest[:, 1], unit[:, 1]
    companion = np.zeros((len(starts), 6, 6))
    companion[:, np.arange(1, 6), np.arange(5)] = 1.0
    coefficients = (
        lever**2 * p2 - wide * y0**2 * rest,
        -2.0 * wide * y0 * y1 * rest,
        lever**2 - 2.0 * lever * p2 + wide * (y0**2 - y1**2 * rest),
        2.0 * wide * y0 * y1,
        p2 - 2.0 * lever + wide * y1**2,
    )
    for power, coefficient in enumerate(coefficients):
        companion[:, power, 5] = -coefficient
    return np.asarray(np.linalg.eigvals(companion).real + foot[:, None])


def _least_sines(
    lengths: Lengths,
    signs: Signs,
    starts: FloatArray,
    unit: FloatArray,
    low: FloatArray,
    middle: FloatArray,
    high: FloatArray,
) -> FloatArray:
    """Return where sin γ is least between low and high, by golden sections from a middle.

    All of shape (n,); sin γ in the middle is no larger than at the ends.
    """
    rightward = high - middle > middle - low
    left = np.where(rightward, middle, middle - _GOLDEN * (middle - low))
    right = np.where(rightward, middle + _GOLDEN * (high - middle), middle)
    at_left = _along(lengths, signs, starts, unit, left[:, None]).sine[:, 0]
    at_right = _along(lengths, signs, starts, unit, right[:, None]).sine[:, 0]
    for _ in range(_GOLDEN_STEPS):
        leftward = at_left < at_right
        # stays in order also while the sections are not golden yet
        fresh = np.where(leftward, left - _GOLDEN * (left - low), right + _GOLDEN * (high - right))
        low, high = np.where(leftward, low, left), np.where(leftward, right, high)
        at_fresh = _along(lengths, signs, starts, unit, fresh[:, None]).sine[:, 0]
        left, right = np.where(leftward, fresh, right), np.where(leftward, left, fresh)
        at_left, at_right = (
            np.where(leftward, at_fresh, at_right),
            np.where(leftward, at_left, at_fresh),
        )
    return np.where(at_left < at_right, left, right)


def _closed_in(
    lengths: Lengths, signs: Signs, start: FloatArray, unit: FloatArray, low: float, high: float
) -> float:
    """Return where sin γ changes sign between low and high, by bisection."""
    low, high = float(low), float(high)
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return high
        if _along(lengths, signs, start[None], unit[None], np.array([[middle]])).sine[0, 0] > 0.0:
            low = middle
        else:
            high = middle


def _along(
    lengths: Lengths, signs: Signs, starts: FloatArray, unit: FloatArray, s: FloatArray
) -> _Regularity:
    """Return the regularity at distances s, shape (n, m), along n lines."""
    return _regularity(lengths, signs, starts[:, None] + s[..., None] * unit[:, None])


def _fault(
    lengths: Lengths,
    signs: Signs,
    segment: int,
    share: float,
    position: Point,
    curve: Curve | None = None,
) -> PathFault:
    """Return the fault at a singular point, on a known curve or whichever it lies on."""
    state = _regularity(lengths, signs, np.array(position))
    if curve is None:
        worst = int(np.argmin(state.slack))
        if state.slack[worst] <= TOUCH:
            curve = _REACH_CURVES[worst]
        elif state.cosine <= 0.0:
            curve = COUPLER
        else:
            elbows = np.empty((1, 4))
            s1, s2, _ = signs
            elbows_at(*lengths, *columns(np.array([position])), float(s1), float(s2), elbows)
            # where r1 = r3 both are one
            low = elbows[0, 1] < 0.0 and lengths[0] > lengths[2]
            curve = FOLD_DOWN if low else FOLD_UP
    phrase = f"meets {curve.name}: {_WHY[curve]}"
    return PathFault(segment, share, position, curve.name, curve.symbol, curve.kind, phrase)


def _input_angles(lengths: Lengths, signs: Signs, corners: FloatArray) -> FloatArray:
    """Return input angles, shape (n, 2), continuous along a path that is regular all along.

    An input angle is that of P about the base joint and s_i times the angle between crank
    and A_iP. The first turns by less than π on a straight segment that does not meet the
    joint, so that its turn is known from the ends; the second stays between 0 and π.
    """
    r1, r2, r3 = lengths
    principal = np.empty((2, len(corners)))
    inverse_at(*lengths, *columns(corners), float(signs[0]), float(signs[1]), *principal)
    for leg, base in enumerate((-r3, r3)):
        x, y = corners[:, 0] - base, corners[:, 1]
        turns = np.arctan2(x[:-1] * y[1:] - y[:-1] * x[1:], x[:-1] * x[1:] + y[:-1] * y[1:])
        reach2 = x * x + y * y
        opening = np.arctan2(
            np.sqrt(np.maximum(_squared_four_areas(lengths, reach2), 0.0)),
            reach2 + (r1 - r2) * (r1 + r2),
        )
        change = np.concatenate([[0.0], np.cumsum(turns)]) + signs[leg] * (opening - opening[0])
        # whole turns are all that the principal angles lack
        lacking = (principal[leg, 0] + change - principal[leg]) / (2.0 * math.pi)
        principal[leg] += 2.0 * math.pi * np.round(lacking)
    return principal.T


def boundary_distances(
    lengths: Lengths, workspace: UsableWorkspace, points: FloatArray
) -> tuple[FloatArray, list[str]]:
    """Return how far points of a workspace are from its boundary, and the name of what is next.

    Isolated singular points count as boundary. C_col, whose nearest point is iterated for, comes
    last.
    """
    arcs = sorted(workspace.region.arcs, key=lambda each: isinstance(each.arc, CouplerArc))
    isolated = zip((REACH_1I.name, REACH_2I.name), isolated_points(lengths), strict=False)
    return nearest_of(arcs, list(isolated), points)
