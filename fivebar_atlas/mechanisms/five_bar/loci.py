"""Singular loci of a five-bar as geometry: exact arcs, and what each is singular for.

Liu, Wang and Zheng 2006, Sec. 4 and 6. Every locus is cut where it meets another one: at the
intersections of reach circles, and at the tangency points of parallel loci with reach circles,
where a parallel locus passes from one working mode to another.

Which side of an arc is up or down follows in closed form. On a reach circle the leg is
straight, and det B does not depend on its elbow. At a parallel locus det B changes sign;
with q_i the direction of crank A_iB_i and u that of the distal links,

- det B inside a fold circle about (0, ±h) has the sign of ± s1 s2;
- the gradient of det B at C_col is along 2 u⊥ - (tan α1 + tan α2) u, where tan α_i is
  (u · q_i) / cross(q_i, u), u the direction from B1 to B2.

Both follow from the turning rates of the distal links when P moves.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np

from fivebar_atlas.mechanisms.five_bar.coupler_curve import CouplerArc, Piece, without_cuts
from fivebar_atlas.mechanisms.five_bar.jacobian import signed_det_b
from fivebar_atlas.mechanisms.five_bar.kinematics import squared_four_areas
from fivebar_atlas.mechanisms.five_bar.singularity import (
    C_1I_FAR,
    C_1I_NEAR,
    C_1O,
    C_2I_FAR,
    C_2I_NEAR,
    C_2O,
    COUPLER_MINUS,
    COUPLER_PLUS,
    FOLD_DOWN_FAR,
    FOLD_DOWN_NEAR,
    FOLD_UP_FAR,
    FOLD_UP_NEAR,
    MAX_CRITICAL,
    SLACK,
    belongs_to_mode,
    coupler_root,
    coupler_tangency,
    critical_angles,
    exists,
    fold_height,
    radius_along,
)
from fivebar_atlas.mechanisms.five_bar.workspace import POINT_RADIUS, is_degenerate
from fivebar_atlas.mechanisms.mode_pairs import Signs, mode_label
from fivebar_atlas.planar_geometry import (
    BOTH,
    CLOSED,
    INTERSECTION,
    LEFT,
    RIGHT,
    TANGENCY,
    CircleArc,
    NamedArc,
    Point,
)

SERIAL = "serial"
FOLDED = "parallel, folded"
EXTENDED = "parallel, extended"


@dataclasses.dataclass(frozen=True, slots=True)
class Curve:
    """A singular locus: name, notation of the paper and kind of singularity."""

    name: str
    symbol: str
    kind: str


REACH_1O = Curve("C_1o", "$C_{1o}$", SERIAL)
REACH_1I = Curve("C_1i", "$C_{1i}$", SERIAL)
REACH_2O = Curve("C_2o", "$C_{2o}$", SERIAL)
REACH_2I = Curve("C_2i", "$C_{2i}$", SERIAL)
FOLD_UP = Curve("C_coin_up", r"$C_{\mathrm{coin},U}$", FOLDED)
FOLD_DOWN = Curve("C_coin_down", r"$C_{\mathrm{coin},D}$", FOLDED)
COUPLER = Curve("C_col", r"$C_{\mathrm{col}}$", EXTENDED)

CURVES = {
    curve.name: curve
    for curve in (REACH_1O, REACH_1I, REACH_2O, REACH_2I, FOLD_UP, FOLD_DOWN, COUPLER)
}

#: The curve that each curve of :mod:`singularity`, a sheet or a branch, is part of.
CURVE_OF = {
    C_1O: REACH_1O,
    C_2O: REACH_2O,
    C_1I_FAR: REACH_1I,
    C_1I_NEAR: REACH_1I,
    C_2I_FAR: REACH_2I,
    C_2I_NEAR: REACH_2I,
    FOLD_UP_FAR: FOLD_UP,
    FOLD_UP_NEAR: FOLD_UP,
    FOLD_DOWN_FAR: FOLD_DOWN,
    FOLD_DOWN_NEAR: FOLD_DOWN,
    COUPLER_PLUS: COUPLER,
    COUPLER_MINUS: COUPLER,
}

Lengths = tuple[float, float, float]

# Points closer than this are one (lengths sum to 3).
_SAME = 1e-9
# Free ends of one curve that are closer than this are joined; exact but for a square root.
_JOINED = 1e-6
# The same at the origin, where it is a fourth root.
_AT_ORIGIN = 1e-3
# How far beside an arc det B is looked at where it has no slope across it.
_ASIDE = 1e-3
_WORKING_MODES = ((1, -1), (-1, 1), (1, 1), (-1, -1))


def singular_arcs(lengths: Lengths, pairs: Collection[Signs]) -> tuple[NamedArc, ...]:
    """Return all singular loci of a design that border on workspaces of some mode pairs.

    Parameters
    ----------
    lengths
        r1, r2, r3, non-dimensional.
    pairs
        Mode pairs as ±1; all eight for all loci (Fig. 3), the two of a working mode for one
        cell of Fig. 5.

    Returns
    -------
    tuple of NamedArc
        Reach circles, fold circles, C_col, each cut into arcs between its vertices. ``sides``
        names the mode pairs, among those asked for, that border on an arc. Parts of reach
        circles that the other leg does not reach are left out, and so are working modes for
        which the design is degenerate (B1 = B2 throughout).
    """
    allowed = [signs for signs in pairs if not is_degenerate(*lengths, *signs[:2])]
    corners = vertices(lengths)
    found: list[NamedArc] = []
    for leg in (1, 2):
        for outer in (True, False):
            found.extend(_reach_arcs(lengths, leg, outer, allowed, corners))
    for up in (True, False):
        found.extend(_fold_arcs(lengths, up, allowed, corners))
    found.extend(_coupler_arcs(lengths, allowed, corners))
    return tuple(found)


def isolated_points(lengths: Lengths) -> tuple[Point, ...]:
    """Return the base joints where r1 = r2: inner reach circles of no radius, singular points.

    Those that the other leg reaches, and not just so: there its outer circle passes.
    """
    r1, r2, r3 = lengths
    if abs(r1 - r2) >= POINT_RADIUS or 2.0 * r3 > r1 + r2 - _SAME:
        return ()
    return ((-r3, 0.0), (r3, 0.0)) if r3 > 0.0 else ((0.0, 0.0),)


def vertices(lengths: Lengths) -> tuple[Point, ...]:
    """Return all points where loci end or meet on a reach circle, in closed form.

    Intersections of reach circles, and tangency points of fold circles and of C_col with
    reach circles; points that coincide are given once. Not all of them are reachable.
    """
    r1, r2, r3 = lengths
    outer, inner = r1 + r2, abs(r1 - r2)
    half: list[Point] = []  # in the quadrant x, y ≥ 0 or mirrored into the others below
    half.extend(
        (0.0, math.sqrt((radius - r3) * (radius + r3))) for radius in (outer, inner) if radius >= r3
    )
    if r3 > 0.0:
        x = r1 * r2 / r3
        y2 = (inner - (x - r3)) * (inner + (x - r3))
        if y2 >= 0.0:
            half.append((x, math.sqrt(y2)))
    if r1 >= r3:
        height = fold_height(r1, r3)
        half.extend((share * r3, height * (1.0 + share)) for share in (r2 / r1, -r2 / r1))
    for outside, reach in ((True, r1 + r2), (False, r1 - r2)):
        cosine, sine, possible = coupler_tangency(r1, r2, r3, outside)
        if possible:
            half.append((reach * cosine - r3, reach * sine))
    points: list[Point] = []
    for x, y in half:
        for point in ((x, y), (-x, y), (x, -y), (-x, -y)):
            if all(math.dist(point, other) > _SAME for other in points):
                points.append((point[0] + 0.0, point[1] + 0.0))
    return tuple(points)


def snapped(point: Point, corners: Sequence[Point]) -> Point:
    """Return the vertex that a point is one of but for rounding, or the point itself."""
    nearest = min(corners, key=lambda corner: math.dist(corner, point), default=point)
    return nearest if math.dist(nearest, point) < _JOINED else point


def _reach_arcs(
    lengths: Lengths, leg: int, outer: bool, pairs: Sequence[Signs], corners: Sequence[Point]
) -> Iterator[NamedArc]:
    """Yield the arcs of C_1o, C_1i, C_2o or C_2i that the other leg reaches."""
    r1, r2, r3 = lengths
    radius = r1 + r2 if outer else abs(r1 - r2)
    if radius < POINT_RADIUS:
        return
    curve = {
        (1, True): REACH_1O, (1, False): REACH_1I, (2, True): REACH_2O, (2, False): REACH_2I,
    }[leg, outer]  # fmt: skip
    base = -r3 if leg == 1 else r3
    side = LEFT if outer else RIGHT

    def sides(x: float, y: float) -> dict[str, str]:
        reach2 = (x + base) ** 2 + y * y  # of the other leg, from -base
        if squared_four_areas(r1, r2, reach2) < -1e-13:
            return {}
        return {
            mode_label(signs): side
            for signs in pairs
            if signs[2] * _sign_beside_circle(lengths, leg, outer, signs, x, y) > 0.0
        }

    yield from _circle_arcs(lengths, curve, (base, 0.0), radius, corners, sides)


def _sign_beside_circle(
    lengths: Lengths, leg: int, outer: bool, signs: Signs, x: float, y: float
) -> float:
    """Return a number with the sign of det B next to a point of a reach circle."""
    r3 = lengths[2]
    # the leg is straight: its elbow is in the middle of both modes
    straight = (0.0, float(signs[1])) if leg == 1 else (float(signs[0]), 0.0)
    value = signed_det_b(*lengths, x, y, *straight)
    size = max(abs(value), 1e-300)
    if size > 1e-12:
        return value
    base = -r3 if leg == 1 else r3
    inward = 1.0 - _ASIDE if outer else 1.0 + _ASIDE
    x, y = base + inward * (x - base), inward * y
    return signed_det_b(*lengths, x, y, float(signs[0]), float(signs[1]))


def _fold_arcs(
    lengths: Lengths, up: bool, pairs: Sequence[Signs], corners: Sequence[Point]
) -> Iterator[NamedArc]:
    """Yield the arcs of a fold circle, one for each working mode; both coincide if r1 = r3."""
    r1, r2, r3 = lengths
    if r1 < r3 or r3 == 0.0 or (r1 == r3 and not up):
        return
    height = fold_height(r1, r3) if up else -fold_height(r1, r3)

    def sides(x: float, y: float) -> dict[str, str]:
        # sides of the common elbow F = (0, height) as seen from each leg
        turns = ((x + r3) * height - y * r3, (x - r3) * height + y * r3)
        found: dict[str, str] = {}
        for signs in pairs:
            if signs[0] * turns[0] <= 0.0 or signs[1] * turns[1] <= 0.0:
                continue
            if height == 0.0:  # det B touches zero and keeps its sign
                x_in, y_in = (1.0 - _ASIDE) * x, (1.0 - _ASIDE) * y
                if signs[2] * signed_det_b(*lengths, x_in, y_in, signs[0], signs[1]) > 0.0:
                    found[mode_label(signs)] = BOTH
                continue
            inside = signs[0] * signs[1] * (1 if up else -1)
            found[mode_label(signs)] = LEFT if signs[2] == inside else RIGHT
        return found

    curve = FOLD_UP if up else FOLD_DOWN
    yield from _circle_arcs(lengths, curve, (0.0, height), r2, corners, sides)


@dataclasses.dataclass(frozen=True, slots=True)
class _Piece:
    """A piece of a circle between two vertices, and what it borders on."""

    start_angle: float
    sweep: float
    start: Point
    end: Point
    sides: dict[str, str]


def _circle_arcs(
    lengths: Lengths,
    curve: Curve,
    centre: Point,
    radius: float,
    corners: Sequence[Point],
    sides: Callable[[float, float], dict[str, str]],
) -> Iterator[NamedArc]:
    """Cut a circle at the vertices on it; yield the arcs that border on something."""

    def sides_at(angle: float) -> dict[str, str]:
        return sides(centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle))

    on_it = [corner for corner in corners if abs(math.dist(corner, centre) - radius) <= _SAME]
    turns = sorted((math.atan2(y - centre[1], x - centre[0]), (x, y)) for x, y in on_it)
    pieces = []
    for place, (angle, corner) in enumerate(turns):
        next_angle, following = turns[(place + 1) % len(turns)]
        sweep = next_angle - angle
        if place + 1 == len(turns):
            sweep += 2.0 * math.pi
        pieces.append(_Piece(angle, sweep, corner, following, sides_at(angle + 0.5 * sweep)))
    # neighbours that border on the same are one arc; begin after a change
    first = next(
        (place for place in range(len(pieces)) if pieces[place].sides != pieces[place - 1].sides),
        None,
    )
    if first is None:
        whole = pieces[0].sides if pieces else sides_at(0.0)
        if whole:
            arc = CircleArc.whole(centre, radius)
            yield NamedArc(curve.name, curve.symbol, curve.kind, arc, (CLOSED, CLOSED), whole)
        return
    merged: list[_Piece] = []
    for piece in pieces[first:] + pieces[:first]:
        if merged and merged[-1].sides == piece.sides:
            sweep = merged[-1].sweep + piece.sweep
            merged[-1] = dataclasses.replace(merged[-1], sweep=sweep, end=piece.end)
        else:
            merged.append(piece)
    for piece in merged:
        if piece.sides:
            arc = CircleArc(centre, radius, piece.start_angle, piece.sweep, piece.start, piece.end)
            ends = (_kind_of_vertex(lengths, piece.start), _kind_of_vertex(lengths, piece.end))
            yield NamedArc(curve.name, curve.symbol, curve.kind, arc, ends, piece.sides)


def _kind_of_vertex(lengths: Lengths, vertex: Point) -> str:
    """Return whether reach circles cross at a vertex, or a parallel locus touches one."""
    r1, r2, r3 = lengths
    crossed = all(
        min(abs(reach - r1 - r2), abs(reach - abs(r1 - r2))) < _SAME
        for reach in (math.dist(vertex, (-r3, 0.0)), math.dist(vertex, (r3, 0.0)))
    )
    return INTERSECTION if crossed else TANGENCY


def _coupler_arcs(
    lengths: Lengths, pairs: Sequence[Signs], corners: Sequence[Point]
) -> Iterator[NamedArc]:
    """Yield the arcs of C_col, each between two tangency points or closed."""
    for s1, s2 in _WORKING_MODES:
        assemblies = [signs for signs in pairs if signs[:2] == (s1, s2)]
        if not assemblies:
            continue
        for chain in _coupler_chains(lengths, s1, s2):
            curve, start, end = chain[0]
            forward = end > start
            up_left = _up_is_inside(lengths, curve, 0.5 * (start + end)) == forward
            sides = {
                mode_label(signs): LEFT if (signs[2] > 0) == up_left else RIGHT
                for signs in assemblies
            }
            arc, closed = coupler_arc(lengths, chain, corners)
            ends = (CLOSED, CLOSED) if closed else (TANGENCY, TANGENCY)
            yield NamedArc(COUPLER.name, COUPLER.symbol, COUPLER.kind, arc, ends, sides)


def coupler_arc(
    lengths: Lengths, pieces: Sequence[Piece], corners: Sequence[Point]
) -> tuple[CouplerArc, bool]:
    """Return the arc over pieces in order, ends on vertices, and whether it is closed."""
    first, last = pieces[0], pieces[-1]
    start, first_angle = snapped_end(lengths, first[0], first[1], corners)
    end, last_angle = snapped_end(lengths, last[0], last[2], corners)
    closed = start not in corners and (
        math.dist(start, end) < _JOINED or max(math.hypot(*start), math.hypot(*end)) < _AT_ORIGIN
    )
    if len(pieces) == 1:
        ended = [(first[0], first_angle, last_angle)]
    else:
        ended = [
            (first[0], first_angle, first[2]), *pieces[1:-1], (last[0], last[1], last_angle),
        ]  # fmt: skip
    return CouplerArc(lengths, tuple(ended), start, start if closed else end), closed


def snapped_end(
    lengths: Lengths, curve: int, phi: float, corners: Sequence[Point]
) -> tuple[Point, float]:
    """Return the end of a curve on a ray, a vertex if it is one but for rounding, and its angle."""
    point = polar_point(lengths, curve, phi)
    vertex = snapped(point, corners)
    if vertex is point or math.hypot(*vertex) < _AT_ORIGIN:
        return vertex, phi
    turn = math.atan2(vertex[1], vertex[0]) - phi
    return vertex, phi + math.remainder(turn, 2.0 * math.pi)


def polar_point(lengths: Lengths, curve: int, phi: float) -> Point:
    """Return the point of a curve on the ray at an angle."""
    c, s = math.cos(phi), math.sin(phi)
    rho = radius_along(curve, *lengths, c, s)
    return rho * c, rho * s


def _coupler_chains(lengths: Lengths, s1: int, s2: int) -> list[list[Piece]]:
    """Return the pieces of C_col that are singular for a working mode, joined in order."""
    angles = np.empty(MAX_CRITICAL)
    count = critical_angles(*lengths, -0.5 * math.pi, 1.5 * math.pi, angles)
    chains: list[list[Piece]] = []
    for curve in (COUPLER_PLUS, COUPLER_MINUS):
        run: list[Piece] = []
        for start, end in itertools.pairwise(angles[:count]):
            middle = 0.5 * (start + end)
            c, s = math.cos(middle), math.sin(middle)
            if (
                exists(curve, *lengths, c, s)
                and belongs_to_mode(curve, *lengths, c, s, s1, s2)
                and not _is_on_reach_circle(lengths, *polar_point(lengths, curve, middle))
            ):
                run.append((curve, float(start), float(end)))
            elif run:
                chains.append(run)
                run = []
        if run:
            chains.append(run)
    chains = [without_cuts(chain) for chain in chains]
    return joined_chains(lengths, chains)


def _is_on_reach_circle(lengths: Lengths, x: float, y: float) -> bool:
    """Tell whether a leg is straight; for R = 2 : 1 : 1 it is on a part of C_col."""
    r1, r2, r3 = lengths
    return any(
        abs(squared_four_areas(r1, r2, (x - base) ** 2 + y * y)) < SLACK for base in (-r3, r3)
    )


def joined_chains(lengths: Lengths, chains: list[list[Piece]]) -> list[list[Piece]]:
    """Join chains that go on in one another.

    They do where φ begins anew, where the curve touches a ray, and at the origin. Where it
    touches a ray there, ρ grows like the fourth root of the angle, and so does its rounding.
    """
    for slack, around in ((_JOINED, math.inf), (_AT_ORIGIN, _AT_ORIGIN)):
        for one, two in itertools.combinations(chains, 2):
            for first, second in itertools.product((one, _turned(one)), (two, _turned(two))):
                end = polar_point(lengths, first[-1][0], first[-1][2])
                start = polar_point(lengths, second[0][0], second[0][1])
                if math.dist(end, start) < slack and math.hypot(*end) < around:
                    rest = [chain for chain in chains if chain is not one and chain is not two]
                    return joined_chains(lengths, [*rest, without_cuts([*first, *second])])
    return chains


def _turned(chain: list[Piece]) -> list[Piece]:
    """Return a chain run through the other way."""
    return [(curve, end, start) for curve, start, end in reversed(chain)]


def _up_is_inside(lengths: Lengths, curve: int, phi: float) -> bool:
    """Tell whether det B falls outwards along a ray where it meets C_col."""
    _, r2, r3 = lengths
    c, s = math.cos(phi), math.sin(phi)
    branch = 1.0 if curve == COUPLER_PLUS else -1.0
    rho = radius_along(curve, *lengths, c, s)
    x, y = rho * c, rho * s
    along = r3 * c / r2
    across = -branch * math.sqrt(max(coupler_root(r2, r3, c), 0.0)) / r2
    ux, uy = along * c - across * s, along * s + across * c
    (dot_1, cross_1), (dot_2, cross_2) = (
        (ux * qx + uy * qy, qx * uy - qy * ux)
        for qx, qy in (
            (x - r2 * ux + r3, y - r2 * uy),
            (x + r2 * ux - r3, y + r2 * uy),
        )
    )
    # times cross_1 cross_2, which is positive or negative as the sides of the elbows are
    slope = 2.0 * cross_1 * cross_2 * (ux * s - uy * c)
    slope -= (dot_1 * cross_2 + dot_2 * cross_1) * (ux * c + uy * s)
    return slope * cross_1 * cross_2 < 0.0
