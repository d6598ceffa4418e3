"""The boundary of a usable workspace as closed outlines of exact arcs.

The strips that areas and indices are integrated over (:mod:`workspace`) lie between a lower
and an upper curve. Those edges are joined to closed loops, ray by ray: at a critical angle
the strips that end and those that begin cover the same part of the ray, so their edges end
in pairs. Neighbouring edges on one circle, or on C_col, are then made one arc.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.five_bar.coupler_curve import CouplerArc
from fivebar_atlas.mechanisms.five_bar.loci import (
    COUPLER,
    CURVE_OF,
    CURVES,
    FOLD_DOWN,
    FOLD_UP,
    REACH_1I,
    REACH_1O,
    REACH_2I,
    REACH_2O,
    Lengths,
    polar_point,
    snapped,
    snapped_end,
    vertices,
)
from fivebar_atlas.mechanisms.five_bar.mirror import CLASS_SIGNS, canonical_class
from fivebar_atlas.mechanisms.five_bar.points import contained_at, lci_inside_at
from fivebar_atlas.mechanisms.five_bar.singularity import ORIGIN, circle_of
from fivebar_atlas.mechanisms.five_bar.workspace import (
    DECOMPOSITION,
    Decomposition,
    usable_workspace,
)
from fivebar_atlas.mechanisms.mode_pairs import Signs
from fivebar_atlas.mechanisms.two_legged_design import ConditionedWorkspace
from fivebar_atlas.numerics.records import allocate_record
from fivebar_atlas.planar_geometry import (
    CLOSED,
    Arc,
    CircleArc,
    FloatArray,
    NamedArc,
    Point,
    closed_loop,
    region_of,
)

_MIRRORED_X = {REACH_1O: REACH_2O, REACH_2O: REACH_1O, REACH_1I: REACH_2I, REACH_2I: REACH_1I}
_MIRRORED_Y = {FOLD_UP: FOLD_DOWN, FOLD_DOWN: FOLD_UP}
_HALF = 0.5 * math.pi
# An arc shorter than this (lengths sum to 3) is the rounding of a vertex.
_SHORTEST = 1e-9
# Edges that meet on a ray meet this closely, and closed arcs close, but for a square root.
_SAME, _JOINED = 1e-9, 1e-6


@dataclasses.dataclass(frozen=True, slots=True)
class UsableWorkspace(ConditionedWorkspace):
    """The usable workspace of one design and mode pair, in non-dimensional lengths.

    Attributes
    ----------
    region
        Its outline and holes.
    area
        Its area as it is integrated, strip by strip.
    """

    _lengths: Lengths
    _decomposition: Decomposition
    _strips: int
    _class: int
    _symmetric: bool
    _mirror: tuple[bool, bool]

    def contains(self, x: npt.ArrayLike, y: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Tell which points lie inside, exactly; the boundary does not belong to it.

        Parameters
        ----------
        x, y
            Coordinates, scalars or arrays, which broadcast.
        """
        xs, ys, shape = self._decomposed(x, y)
        out = np.empty(len(xs), dtype=np.bool_)
        contained_at(self._decomposition, self._strips, *self._lengths, xs, ys, out)
        return out.reshape(shape)

    def lci(self, x: npt.ArrayLike, y: npt.ArrayLike) -> FloatArray:
        """Return the LCI at points inside, 0 elsewhere: a continuous function of the plane.

        Parameters
        ----------
        x, y
            Coordinates, scalars or arrays, which broadcast.
        """
        xs, ys, shape = self._decomposed(x, y)
        s1, s2, _ = CLASS_SIGNS[self._class]
        out = np.empty(len(xs))
        lci_inside_at(self._decomposition, self._strips, *self._lengths, xs, ys, s1, s2, out)
        return out.reshape(shape)

    def _decomposed(
        self, x: npt.ArrayLike, y: npt.ArrayLike
    ) -> tuple[FloatArray, FloatArray, tuple[int, ...]]:
        """Return points mirrored into the part that is decomposed, flat, and their shape."""
        wide = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        mirror_x, mirror_y = self._mirror
        xs = np.ravel(wide[0]) * (-1.0 if mirror_x else 1.0)
        ys = np.ravel(wide[1]) * (-1.0 if mirror_y else 1.0)
        return np.abs(xs) if self._symmetric else xs, ys, wide[0].shape


def usable_workspace_of(lengths: Lengths, signs: Signs) -> UsableWorkspace | None:
    """Return the usable workspace of a mode pair, None where it is empty.

    Parameters
    ----------
    lengths
        r1, r2, r3, non-dimensional.
    signs
        Working mode and assembly mode as ±1.
    """
    kind, mirror_x, mirror_y = canonical_class(*signs)
    d: Decomposition = allocate_record(DECOMPOSITION)
    s1, s2, assembly = CLASS_SIGNS[kind]
    _, component, strips, copies, area, _ = usable_workspace(*lengths, s1, s2, assembly, d)
    if component < 0:
        return None
    corners = vertices(lengths)
    loops = []
    for chain in _chains(lengths, d, strips, s1 != s2):
        arcs = _arcs_of(lengths, chain.edges, corners)
        if not chain.closed:  # from the y axis to the y axis: its image is the other half
            arcs += [_image(each, True, False) for each in reversed(arcs)]
        arcs = _smooth(arcs)
        if mirror_x or mirror_y:
            ordered = arcs if mirror_x == mirror_y else list(reversed(arcs))
            arcs = [_image(each, mirror_x, mirror_y) for each in ordered]
        if arcs:
            loops.append(closed_loop(arcs))
    if not loops:  # no larger than rounding
        return None
    region = region_of(loops)
    symmetric = s1 != s2 and copies == 2.0
    return UsableWorkspace(
        region, copies * area, lengths, d, strips, kind, symmetric, (mirror_x, mirror_y)
    )


@dataclasses.dataclass(frozen=True, slots=True)
class _Edge:
    """The upper or the lower curve of a strip, run through with the strip on its left."""

    curve: int
    start: float
    end: float


@dataclasses.dataclass(frozen=True, slots=True)
class _End:
    """Where an edge begins or ends, on a ray on which its strip begins or ends."""

    edge: int
    rho: float
    curve: int


@dataclasses.dataclass(frozen=True, slots=True)
class _Chain:
    """Edges in order; closed, or from the y axis to the y axis."""

    edges: tuple[_Edge, ...]
    closed: bool


def _chains(lengths: Lengths, d: Decomposition, strips: int, symmetric: bool) -> list[_Chain]:
    """Join the edges of the strips to chains."""
    edges: list[_Edge] = []
    for strip in range(strips):
        start, end = float(d.strip_from[strip]), float(d.strip_to[strip])
        edges.append(_Edge(int(d.strip_upper[strip]), start, end))
        edges.append(_Edge(int(d.strip_lower[strip]), end, start))
    starts: dict[float, list[_End]] = {}
    ends: dict[float, list[_End]] = {}
    for number, edge in enumerate(edges):
        for phi, found in ((edge.start, starts), (edge.end, ends)):
            rho = math.hypot(*polar_point(lengths, edge.curve, phi))
            found.setdefault(_ray(phi, symmetric), []).append(_End(number, rho, edge.curve))
    following: dict[int, int] = {}
    for phi, arriving in ends.items():
        if symmetric and abs(phi) == _HALF:
            continue
        leaving = starts[phi]
        # on one curve first, then wherever the next edge is nearest
        pairs = sorted(
            (gap >= _SAME or one.curve != two.curve, gap, i, k)
            for i, one in enumerate(arriving)
            for k, two in enumerate(leaving)
            for gap in (abs(one.rho - two.rho),)
        )
        used_in: set[int] = set()
        used_out: set[int] = set()
        for _, _, i, k in pairs:
            if i not in used_in and k not in used_out:
                following[arriving[i].edge] = leaving[k].edge
                used_in.add(i)
                used_out.add(k)
    chains = []
    remaining = set(range(len(edges)))
    heads = sorted(remaining - set(following.values()))
    for closed, firsts in ((False, heads), (True, range(len(edges)))):
        for first in firsts:
            if first not in remaining:
                continue
            run = []
            place: int | None = first
            while place is not None and place in remaining:
                remaining.discard(place)
                run.append(edges[place])
                place = following.get(place)
            chains.append(_Chain(tuple(run), closed))
    return chains


def _ray(phi: float, symmetric: bool) -> float:
    """Return an angle that is the same for the first and the last ray of a full turn."""
    return -_HALF if not symmetric and phi == 3.0 * _HALF else phi


def _arcs_of(lengths: Lengths, edges: Sequence[_Edge], corners: Sequence[Point]) -> list[NamedArc]:
    """Return one arc for each edge, without those at the origin."""
    arcs = []
    for edge in edges:
        if edge.curve == ORIGIN:
            continue
        curve = CURVE_OF[edge.curve]
        if curve is COUPLER:
            start, first = snapped_end(lengths, edge.curve, edge.start, corners)
            end, last = snapped_end(lengths, edge.curve, edge.end, corners)
            arc: Arc = CouplerArc(lengths, ((edge.curve, first, last),), start, end)
        else:
            arc = _circle_arc(lengths, edge, corners)
        arcs.append(NamedArc(curve.name, curve.symbol, curve.kind, arc))
    return arcs


def _circle_arc(lengths: Lengths, edge: _Edge, corners: Sequence[Point]) -> CircleArc:
    """Return the arc of an edge that lies on a circle."""
    a, b, radius, sheet = circle_of(edge.curve, *lengths)
    start = snapped(polar_point(lengths, edge.curve, edge.start), corners)
    end = snapped(polar_point(lengths, edge.curve, edge.end), corners)
    # with α = asin(distance of the centre from the ray / radius) the far sheet lies at φ + α
    # about the centre, the near one at φ + π - α
    first, last = (
        math.asin(max(-1.0, min(1.0, (a * math.sin(phi) - b * math.cos(phi)) / radius)))
        for phi in (edge.start, edge.end)
    )
    sweep = edge.end - edge.start + sheet * (last - first)
    start_angle = math.atan2(start[1] - b, start[0] - a)
    return CircleArc((a, b), radius, start_angle, sweep, start, end)


def _smooth(arcs: Sequence[NamedArc]) -> list[NamedArc]:
    """Make neighbouring arcs of one curve one arc; drop what is no longer than rounding."""
    joined: list[NamedArc] = []
    for each in arcs:
        if _is_short(each.arc):
            continue
        if joined and _on_one_curve(joined[-1], each):
            joined[-1] = dataclasses.replace(joined[-1], arc=_joined(joined[-1].arc, each.arc))
        else:
            joined.append(each)
    if len(joined) > 1 and _on_one_curve(joined[-1], joined[0]):
        last = joined.pop()
        joined[0] = dataclasses.replace(joined[0], arc=_joined(last.arc, joined[0].arc))
    return _meeting_exactly(joined)


def _on_one_curve(one: NamedArc, two: NamedArc) -> bool:
    """Tell whether two arcs lie on one curve; at r3 = 0 circles of both legs are the same."""
    if isinstance(one.arc, CircleArc) and isinstance(two.arc, CircleArc):
        return (one.arc.centre, one.arc.radius) == (two.arc.centre, two.arc.radius)
    return one.name == two.name


def _is_short(arc: Arc) -> bool:
    """Tell whether an arc has no length but for rounding."""
    if isinstance(arc, CircleArc):
        return abs(arc.sweep) * arc.radius < _SHORTEST
    return bool(np.ptp(arc.polyline(math.inf), axis=0).max() < _SHORTEST)


def _joined(one: Arc, two: Arc) -> Arc:
    """Return two arcs of one curve, which follow each other, as one."""
    if isinstance(one, CircleArc) and isinstance(two, CircleArc):
        return dataclasses.replace(one, sweep=one.sweep + two.sweep, end=two.end)
    assert isinstance(one, CouplerArc)
    assert isinstance(two, CouplerArc)
    return one.followed_by(two)


def _meeting_exactly(arcs: Sequence[NamedArc]) -> list[NamedArc]:
    """Return arcs that end in the very points where the next ones start."""
    if arcs and max(np.ptp(each.arc.polyline(math.inf), axis=0).max() for each in arcs) < _JOINED:
        return []
    if len(arcs) == 1 and math.dist(arcs[0].arc.start, arcs[0].arc.end) < _JOINED:
        return [dataclasses.replace(arcs[0], arc=_closed(arcs[0].arc), ends=(CLOSED, CLOSED))]
    return [
        dataclasses.replace(each, arc=_with_ends(each.arc, arcs[place - 1].arc.end, each.arc.end))
        for place, each in enumerate(arcs)
    ]


def _closed(arc: Arc) -> Arc:
    """Return an arc that is a closed curve but for rounding as one."""
    if isinstance(arc, CircleArc):
        sweep = math.copysign(2.0 * math.pi, arc.sweep)
        return CircleArc.of_angles(arc.centre, arc.radius, arc.start_angle, sweep)
    return _with_ends(arc, arc.start, arc.start)


def _with_ends(arc: Arc, start: Point, end: Point) -> Arc:
    """Return an arc with end points that differ from its own by rounding."""
    if isinstance(arc, CouplerArc):
        return dataclasses.replace(arc, start=start, end=end)
    assert isinstance(arc, CircleArc)
    first, last = (
        math.atan2(point[1] - arc.centre[1], point[0] - arc.centre[0]) for point in (start, end)
    )
    turns = round((arc.sweep - (last - first)) / (2.0 * math.pi))
    return CircleArc(
        arc.centre, arc.radius, first, last - first + 2.0 * math.pi * turns, start, end
    )


def _image(each: NamedArc, x: bool, y: bool) -> NamedArc:
    """Return the mirror image of a boundary arc, the workspace on its left again."""
    curve = CURVES[each.name]
    if x:
        curve = _MIRRORED_X.get(curve, curve)
    if y:
        curve = _MIRRORED_Y.get(curve, curve)
    arc = each.arc.mirrored(x, y)
    return NamedArc(curve.name, curve.symbol, curve.kind, arc if x == y else arc.reversed())
