"""The boundary of a usable workspace as closed outlines of arcs.

The runs of columns that areas and indices are integrated over (:mod:`workspace`) have intervals
of l with ends on one curve each. These ends are edges: the upper ones run with rising θ, the lower
ones back, and at the limit of the passive leg straight lines join them. At an angle between two
runs edges that end go on in those that begin where they meet. Neighbouring edges on one curve are
then made one arc. Lower ends at O, where the passive leg has no length, are one corner.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.mode_pairs import Signs
from fivebar_atlas.mechanisms.passive_leg.columns import (
    COLUMN,
    ONE_SIGN,
    PASSIVE_JOINTS,
    Column,
    find_column,
    set_samples,
)
from fivebar_atlas.mechanisms.passive_leg.evaluation import integrate_workspace
from fivebar_atlas.mechanisms.passive_leg.forward_arc import (
    ForwardArc,
    moved_onto,
    upper_directions,
)
from fivebar_atlas.mechanisms.passive_leg.indices import (
    AREA,
    INTEGRALS,
    Integrals,
    set_rule,
)
from fivebar_atlas.mechanisms.passive_leg.inside import inside_at, lci_inside_at
from fivebar_atlas.mechanisms.passive_leg.loci import (
    FOLDED,
    LEVEL_LINKS,
    PASSIVE_LEG,
    SINGULAR_PLATFORM,
    STRETCHED,
    Curve,
    Limits,
    reach_curve,
)
from fivebar_atlas.mechanisms.passive_leg.points import Lengths
from fivebar_atlas.mechanisms.passive_leg.reach_arc import ReachArc, ReachCurve
from fivebar_atlas.mechanisms.passive_leg.singularity import (
    FORWARD,
    INNER_1,
    INNER_2,
    LIMIT_1,
    LIMIT_2,
    NO_LENGTH,
    OUTER_1,
    OUTER_2,
)
from fivebar_atlas.mechanisms.passive_leg.workspace import Runs, largest_part
from fivebar_atlas.mechanisms.two_legged_design import ConditionedWorkspace
from fivebar_atlas.numerics.records import allocate_record
from fivebar_atlas.planar_geometry import (
    CLOSED,
    Arc,
    FloatArray,
    NamedArc,
    Point,
    PolylineArc,
    closed_loop,
    region_of,
)

# The edge along the limit of the passive leg, besides the kinds of :mod:`singularity`.
_THETA_LIMIT = -1
_MIRRORED = {
    OUTER_1: OUTER_2, OUTER_2: OUTER_1, INNER_1: INNER_2, INNER_2: INNER_1,
    LIMIT_1: LIMIT_2, LIMIT_2: LIMIT_1,
}  # fmt: skip
_CURVES = {
    OUTER_1: STRETCHED[0], OUTER_2: STRETCHED[1], INNER_1: FOLDED[0], INNER_2: FOLDED[1],
    FORWARD: SINGULAR_PLATFORM, LIMIT_1: LEVEL_LINKS[0], LIMIT_2: LEVEL_LINKS[1],
    _THETA_LIMIT: PASSIVE_LEG,
}  # fmt: skip
# Tolerance of the area.
_TOLERANCE = 1e-10
# Angles of columns are this close to those at which curves change in closed form.
_SNAP = 1e-10
# An arc shorter than this is the rounding of a corner.
_SHORTEST = 1e-9
# A corner that is no farther than this from O is O.
_AT_O = 1e-5
# Nodes of an arc of the forward singularity over a run.
_NODES = 41

BoolArray = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, slots=True)
class ModePart:
    """The usable part of a mode pair's workspace, as compiled columns have it.

    Attributes
    ----------
    lengths
        1, r, l_a, l_b.
    limits
        Limits of the passive joints.
    elbows, sign
        Elbows and the sign of det J_x that the columns were made for.
    conditions
        As for :func:`columns.find_column`.
    runs, part
        The runs and the number of the part.
    is_half
        Whether the runs are those of θ ≥ 0 only.
    is_symmetric
        Whether the part goes on in its mirror image beyond θ = 0.
    turn
        -1 where the columns are those of the mirror image, else 1.
    area
        Area of the whole.
    """

    lengths: Lengths
    limits: Limits
    elbows: tuple[float, float]
    sign: float
    conditions: int
    runs: Runs
    part: int
    is_half: bool
    is_symmetric: bool
    turn: float
    area: float

    def column(self, col: Column, theta: float) -> None:
        """Find the column at an angle that the runs cover."""
        _, r, l_a, l_b = self.lengths
        find_column(col, r, l_a, l_b, theta, *self.elbows, self.sign, self.conditions)

    def intervals(self, theta: float) -> list[tuple[float, float]]:
        """Return the intervals of l that are usable at an angle in the plane, by rising l."""
        angle = abs(theta) if self.is_symmetric else self.turn * theta
        runs = self.runs
        last = int(runs.count[0]) - 1
        if not runs.start[0] <= angle <= runs.end[last]:
            return []
        run = max(int(np.searchsorted(runs.start[: last + 1], angle, side="right")) - 1, 0)
        of_part = runs.part[run, : runs.intervals[run]] == self.part
        col = column_space()
        self.column(col, angle)
        count = int(col.count[0])
        if count != len(of_part):  # in a column that runs have missed all is usable or nothing
            of_part = np.full(count, bool(of_part.any()))
        return [(float(col.low[i]), float(col.high[i])) for i in np.flatnonzero(of_part)]


def column_space() -> Column:
    """Return work space for one column."""
    column: Column = allocate_record(COLUMN)
    set_samples(column)
    return column


def mode_part(lengths: Lengths, limits: Limits, signs: Signs) -> ModePart | None:
    """Return the usable part of a mode pair's workspace, None where it is empty."""
    w: Integrals = allocate_record(INTEGRALS)
    set_rule(w)
    set_samples(w.runs.column)
    _, r, l_a, l_b = lengths
    is_half = signs[0] != signs[1]
    # "--" is the mirror image of "++"; of "+-" and "-+" the half at negative x is looked at, and
    # of two mirror images the one at positive x is the usable workspace
    turn = -1.0 if signs[:2] == (-1, -1) else 1.0
    elbows = (-1.0, -1.0) if signs[0] == signs[1] else (-float(signs[0]), -float(signs[1]))
    sign = -float(signs[2])
    conditions = ONE_SIGN | PASSIVE_JOINTS if limits.joints else ONE_SIGN
    state, _ = integrate_workspace(
        w, r, l_a, l_b, limits.theta, *elbows, sign, conditions, np.empty(0), _TOLERANCE, False
    )
    if state < 0:
        return None
    part, is_symmetric, _ = largest_part(w.runs, is_half)
    if is_half and not is_symmetric:
        turn = -turn
    return ModePart(
        lengths, limits, elbows, sign, conditions, w.runs, part, is_half, is_symmetric, turn,
        float(w.total[AREA]),
    )  # fmt: skip


@dataclasses.dataclass(frozen=True, slots=True)
class UsableWorkspace(ConditionedWorkspace):
    """The usable workspace of one design and mode pair, R = 1.

    Attributes
    ----------
    region
        Its outline and holes.
    area
        Its area as it is integrated, column by column.
    part
        What it was made from.
    """

    part: ModePart

    def contains(self, x: npt.ArrayLike, y: npt.ArrayLike) -> BoolArray:
        """Tell which points lie inside; the boundary does not belong to it.

        Parameters
        ----------
        x, y
            Coordinates, scalars or arrays, which broadcast.
        """
        xs, ys, elbows, shape = self._columns_of(x, y)
        out = np.empty(len(xs), dtype=np.bool_)
        part, (_, r, l_a, l_b) = self.part, self.part.lengths
        inside_at(
            part.runs, column_space(), part.part, r, l_a, l_b, part.limits.theta,
            xs, ys, *elbows, part.sign, part.conditions, out,
        )  # fmt: skip
        return out.reshape(shape)

    def lci(self, x: npt.ArrayLike, y: npt.ArrayLike) -> FloatArray:
        """Return the LCI at points inside, 0 elsewhere.

        Parameters
        ----------
        x, y
            Coordinates, scalars or arrays, which broadcast.
        """
        xs, ys, elbows, shape = self._columns_of(x, y)
        out = np.empty(len(xs))
        part, (_, r, l_a, l_b) = self.part, self.part.lengths
        lci_inside_at(
            part.runs, column_space(), part.part, r, l_a, l_b, part.limits.theta,
            xs, ys, *elbows, part.sign, part.conditions, out,
        )  # fmt: skip
        return out.reshape(shape)

    def _columns_of(
        self, x: npt.ArrayLike, y: npt.ArrayLike
    ) -> tuple[FloatArray, FloatArray, tuple[float, float], tuple[int, ...]]:
        """Return points mirrored to where the columns are, flat, the elbows, and their shape."""
        wide = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        xs, ys = self.part.turn * np.ravel(wide[0]), np.ravel(wide[1]).copy()
        if self.part.is_symmetric:
            xs = -np.abs(xs)
        return xs, ys, self.part.elbows, wide[0].shape


def usable_workspace_of(lengths: Lengths, limits: Limits, signs: Signs) -> UsableWorkspace | None:
    """Return the usable workspace of a mode pair, None where it is empty.

    Parameters
    ----------
    lengths
        R, r, l_a, l_b with R = 1.
    limits
        Limits of the passive joints.
    signs
        Working mode and assembly mode as ±1.
    """
    part = mode_part(lengths, limits, signs)
    if part is None:
        return None
    loops = []
    for chain in _chains(part, _runs_of(part)):
        arcs = _meeting_exactly(_smooth([arc for edge in chain for arc in _arcs_of(part, edge)]))
        if arcs:
            loops.append(closed_loop(arcs))
    if not loops:  # no larger than rounding
        return None
    return UsableWorkspace(region_of(loops), part.area, part)


@dataclasses.dataclass(frozen=True, slots=True)
class _Edge:
    """The upper or lower ends of an interval, run through with the workspace on the left.

    Attributes
    ----------
    kind
        Curve they are on, see :mod:`singularity`, or ``_THETA_LIMIT``.
    run, interval, is_high, turn
        Where they come from: run, interval, which end, and -1 for a mirror image.
    start, end
        First and last pose (θ, l).
    """

    kind: int
    run: int
    interval: int
    is_high: bool
    turn: float
    start: tuple[float, float]
    end: tuple[float, float]


@dataclasses.dataclass(frozen=True, slots=True)
class _Run:
    """A run as it is in the plane: its number, ends, and -1 where it is a mirror image."""

    number: int
    start: float
    end: float
    turn: float


def _runs_of(part: ModePart) -> list[_Run]:
    """Return the runs by rising θ in the plane; neighbours have one angle in common."""
    runs = part.runs
    count = int(runs.count[0])
    known = sorted(_special_angles(part))
    angles = [float(runs.start[0])]
    angles += [_snapped(float(runs.start[run]), known) for run in range(1, count)]
    angles.append(float(runs.end[count - 1]))
    plain = [_Run(run, angles[run], angles[run + 1], 1.0) for run in range(count)]
    image = [_Run(run.number, -run.end, -run.start, -1.0) for run in reversed(plain)]
    if part.is_symmetric:
        return image + plain
    return image if part.turn < 0.0 else plain


def _special_angles(part: ModePart) -> list[float]:
    """Return angles at which curves turn back, pass O or, in pairs, cross."""
    found = [0.0]
    for kind in (OUTER_1, INNER_1, LIMIT_1):
        for curve in _curves_of(part.lengths, kind):
            for between in curve.ranges(math.pi):
                found += between
            found += curve.angles_at_no_length()
    return found


def _snapped(theta: float, known: Sequence[float]) -> float:
    """Return the known angle that an angle is but for rounding, or the angle itself."""
    nearest = min(known, key=lambda angle: abs(angle - theta))
    return nearest if abs(nearest - theta) < _SNAP else theta


def level_curves(lengths: Lengths) -> list[ReachCurve]:
    """Return the curves on which an upper link may be level with the platform, leg by leg."""
    base, platform, l_a, l_b = lengths
    arms = (platform + l_b, platform - l_b)
    return [ReachCurve(base, arm, l_a, leg) for leg in (1.0, -1.0) for arm in arms]


def _curves_of(lengths: Lengths, kind: int) -> list[ReachCurve]:
    """Return the curves in closed form that an edge of a kind may be on."""
    leg = 0 if kind in (OUTER_1, INNER_1, LIMIT_1) else 1
    if kind in (LIMIT_1, LIMIT_2):
        return [curve for curve in level_curves(lengths) if curve.leg == 1.0 - 2.0 * leg]
    return [reach_curve(lengths, leg, kind in (OUTER_1, OUTER_2))]


def _chains(part: ModePart, plane_runs: list[_Run]) -> list[list[_Edge]]:
    """Join the edges of the part to closed chains."""
    edges: list[_Edge] = []
    starts: dict[int, list[int]] = {}
    ends: dict[int, list[int]] = {}

    def add(edge: _Edge, first: int, last: int) -> None:
        starts.setdefault(first, []).append(len(edges))
        ends.setdefault(last, []).append(len(edges))
        edges.append(edge)

    runs, limit = part.runs, part.limits.theta
    last_place = len(plane_runs)
    for place, run in enumerate(plane_runs):
        n, turn = run.number, run.turn
        for i in range(int(runs.intervals[n])):
            if runs.part[n, i] != part.part:
                continue
            first = (float(runs.first_low[n, i]), float(runs.first_high[n, i]))
            last = (float(runs.last_low[n, i]), float(runs.last_high[n, i]))
            if turn < 0.0:
                first, last = last, first
            low_kind, high_kind = int(runs.low_kind[n, i]), int(runs.high_kind[n, i])
            high = _Edge(high_kind, n, i, True, turn, (run.start, first[1]), (run.end, last[1]))
            low = _Edge(low_kind, n, i, False, turn, (run.end, last[0]), (run.start, first[0]))
            add(high, place, place + 1)
            add(low, place + 1, place)
            if place == 0 and run.start == -limit:
                add(_Edge(_THETA_LIMIT, n, i, False, turn, low.end, high.start), place, place)
            if place + 1 == last_place and run.end == limit:
                add(
                    _Edge(_THETA_LIMIT, n, i, False, turn, high.end, low.start),
                    last_place,
                    last_place,
                )
    following: dict[int, int] = {}
    for place, arriving in ends.items():
        pairs = sorted(
            (abs(edges[one].end[1] - edges[two].start[1]), edges[one].kind != edges[two].kind,
             one, two)
            for one in arriving
            for two in starts[place]
        )  # fmt: skip
        used_in: set[int] = set()
        used_out: set[int] = set()
        for _, _, one, two in pairs:
            if one not in used_in and two not in used_out:
                following[one] = two
                used_in.add(one)
                used_out.add(two)
    chains = []
    remaining = set(range(len(edges)))
    while remaining:
        place = min(remaining)
        chain = []
        while place in remaining:
            remaining.discard(place)
            chain.append(edges[place])
            place = following[place]
        chains.append(chain)
    return chains


def _arcs_of(part: ModePart, edge: _Edge) -> list[NamedArc]:
    """Return the arcs of an edge; none where there is no angle or length between its ends."""
    if edge.kind == NO_LENGTH:
        return []
    kind = _MIRRORED.get(edge.kind, edge.kind) if edge.turn < 0.0 else edge.kind
    arcs: list[Arc]
    if edge.kind == _THETA_LIMIT:
        arcs = [_straight_arc(edge)]
    elif edge.kind == FORWARD:
        arcs = _forward_arcs(part, edge)
    else:
        arcs = _reach_arcs(part, edge, kind)
    curve: Curve = _CURVES[kind]
    return [NamedArc(curve.name, curve.symbol, curve.kind, arc) for arc in arcs]


def _point(pose: tuple[float, float]) -> Point:
    """Return C of a pose (θ, l)."""
    theta, length = pose
    return -length * math.sin(theta), length * math.cos(theta)


def _straight_arc(edge: _Edge) -> PolylineArc:
    return PolylineArc(np.array([_point(edge.start), _point(edge.end)]))


def _reach_arcs(part: ModePart, edge: _Edge, kind: int) -> list[Arc]:
    """Return the arc of an edge on a curve in closed form."""
    if edge.start[0] == edge.end[0]:
        return []
    theta = 0.5 * (edge.start[0] + edge.end[0])
    length = _column_ends(part, edge, np.array([edge.turn * theta]))[0]
    choices = [
        (abs(float(curve.lengths(np.array([theta]), sheet)[0]) - length), number, sheet)
        for number, curve in enumerate(_curves_of(part.lengths, kind))
        for sheet in (1.0, -1.0)
    ]
    _, number, sheet = min(choices)
    curve = _curves_of(part.lengths, kind)[number]
    return [ReachArc.of_pieces(curve, ((sheet, edge.start[0], edge.end[0]),))]


def _forward_arcs(part: ModePart, edge: _Edge) -> list[Arc]:
    """Return the arc of an edge on the forward singularity, through its ends in many columns.

    Two arcs where it passes through a point at which b_i is on B_i, for there the links of that leg
    turn by half a turn.
    """
    runs = part.runs
    start, end = float(runs.start[edge.run]), float(runs.end[edge.run])
    if not end > start:
        return []
    v = np.linspace(0.0, 1.0, _NODES)
    theta = start + (end - start) * v**2 * (3.0 - 2.0 * v)
    length = _column_ends(part, edge, theta)
    is_there = ~np.isnan(length)
    theta, length = theta[is_there], length[is_there]
    chi = upper_directions(part.lengths, length, theta, part.elbows)
    nodes = np.column_stack([length, theta, *np.unwrap(chi)])
    arcs: list[Arc] = []
    for some in _cut_where_folded(part.lengths, nodes):
        if len(some) < 2 or np.ptp(some[:, :2], axis=0).max() < _SHORTEST:
            continue
        arc = ForwardArc.through(part.lengths, moved_onto(part.lengths, some))
        if edge.turn < 0.0:
            arc = arc.mirrored(True, False).reversed()
        arcs.append(arc if edge.is_high else arc.reversed())
    return arcs if edge.is_high == (edge.turn > 0.0) else arcs[::-1]


def _cut_where_folded(lengths: Lengths, nodes: FloatArray) -> list[FloatArray]:
    """Cut nodes of the forward singularity, by rising θ, where b_1 or b_2 is on its base joint."""
    base, platform, l_a, l_b = lengths
    if abs(l_a - l_b) > _SHORTEST or platform >= base:
        return [nodes]
    folded = math.acos(platform / base)
    length = math.sqrt((base - platform) * (base + platform))
    pieces = []
    for theta in (-folded, folded):
        place = int(np.searchsorted(nodes[:, 1], theta))
        if not 0 < place < len(nodes):
            continue
        before, after = nodes[place - 1], nodes[place]
        turns = np.abs(after - before)[2:]
        leg = int(np.argmax(turns))
        if turns[leg] < 0.5 * math.pi:
            continue
        # the upper link of the folded leg points in the direction for which J_x is singular
        middle = 0.5 * (before + after)
        other, side = middle[3 - leg], 1.0 - 2.0 * leg
        direction = math.atan2(
            length * math.sin(other),
            length * math.cos(other) + side * 2.0 * platform * math.sin(other),
        )
        ends = [middle.copy(), middle.copy()]
        for end, near in zip(ends, (before, after), strict=True):
            half_turns = round((near[2 + leg] - direction) / math.pi)
            end[[0, 1, 2 + leg]] = length, theta, direction + math.pi * half_turns
        pieces.append(np.vstack([nodes[:place], ends[0]]))
        nodes = np.vstack([ends[1], nodes[place:]])
    return [*pieces, nodes]


def _column_ends(part: ModePart, edge: _Edge, theta: FloatArray) -> FloatArray:
    """Return the lengths of an edge at angles of its run; NaN where the column is another one."""
    col = column_space()
    found = np.full(len(theta), np.nan)
    for place, angle in enumerate(theta.tolist()):
        part.column(col, angle)
        if col.count[0] == part.runs.intervals[edge.run]:
            found[place] = (col.high if edge.is_high else col.low)[edge.interval]
    return found


def _smooth(arcs: Sequence[NamedArc]) -> list[NamedArc]:
    """Make neighbouring arcs of one curve one arc; leave out what is a point even then."""
    joined: list[NamedArc] = []
    for each in arcs:
        together = _joined(joined[-1].arc, each.arc) if joined else None
        if together is None:
            joined.append(each)
        else:
            joined[-1] = dataclasses.replace(joined[-1], arc=together)
    if len(joined) > 1:
        together = _joined(joined[-1].arc, joined[0].arc)
        if together is not None:
            joined[0] = dataclasses.replace(joined.pop(), arc=together)
    return [each for each in joined if not _is_point(each.arc)]


def _is_point(arc: Arc) -> bool:
    return bool(np.ptp(arc.polyline(math.inf), axis=0).max() < _SHORTEST)


def _joined(one: Arc, two: Arc) -> Arc | None:
    """Return two arcs as one if one goes on in the other on the same curve, else None."""
    if isinstance(one, ReachArc) and isinstance(two, ReachArc) and one.curve == two.curve:
        return one.followed_by(two) if one.pieces[-1][2] == two.pieces[0][1] else None
    if isinstance(one, ForwardArc) and isinstance(two, ForwardArc):
        return one.followed_by(two) if one.goes_on_in(two) else None
    return None


def _meeting_exactly(arcs: Sequence[NamedArc]) -> list[NamedArc]:
    """Return arcs that end in the very points where the next ones start."""
    if len(arcs) == 1:
        arc = arcs[0].arc
        closed = _with_ends(arc, arc.start, arc.start)
        return [dataclasses.replace(arcs[0], arc=closed, ends=(CLOSED, CLOSED))]
    corners = []
    for before, after in itertools.pairwise([arcs[-1], *arcs] if arcs else []):
        ends = (before.arc.end, after.arc.start)
        # a point in closed form is better; columns do not tell points next to O from it
        corner = ends[1] if isinstance(before.arc, ForwardArc) else ends[0]
        is_at_o = max(math.hypot(*end) for end in ends) < _AT_O
        corners.append((0.0, 0.0) if is_at_o else corner)
    return [
        dataclasses.replace(each, arc=_with_ends(each.arc, start, end))
        for each, start, end in zip(arcs, corners, [*corners[1:], *corners[:1]], strict=True)
    ]


def _with_ends(arc: Arc, start: Point, end: Point) -> Arc:
    """Return an arc with end points that differ from its own by rounding."""
    if isinstance(arc, ForwardArc):
        # columns do not see what is beyond a fold that is close to a corner
        return arc.extended(start, at_end=False).extended(end, at_end=True)
    if isinstance(arc, ReachArc):
        return dataclasses.replace(arc, start=start, end=end)
    return PolylineArc(np.array([start, end]))
