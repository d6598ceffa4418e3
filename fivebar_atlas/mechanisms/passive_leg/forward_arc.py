"""The curve of C where J_x is singular: the second kind of singularity (Sec. 5.2, Eq. 24).

With χ_i the direction of the upper link of leg i in platform axes, it is where

    f / l_b² = l sin(χ2 - χ1) - 2 r sin χ1 sin χ2 = 0,
    g_i = (e_i - l_b cos χ_i)² + (f_i - l_b sin χ_i)² - l_a² = 0,

(e_i, f_i) = (σ (r - R cos θ), l + σ R sin θ): three equations for (l, θ, χ1, χ2), smooth also
where a leg is stretched or folded and the curve passes from one working mode to another. It has no
closed form. It is followed from point to point along its tangent; every point, and every one asked
for between them, is moved onto it by Newton's method.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable

import numpy as np

from fivebar_atlas.mechanisms.passive_leg.points import Lengths
from fivebar_atlas.planar_geometry import Arc, FloatArray, Point, mirror

# Newton steps, and the residual, for R = 1, from which the next step leads to rounding.
_STEPS, _RESIDUAL = 12, 1e-9
# Damping of Newton's method, nothing but where derivatives vanish: R = r = l_a = l_b.
_DAMPING = 1e-14
# Poses closer than this are one: next to a fold columns miss what is between its branches.
_SAME_POSE = 0.1
# Distance from which on an end is extended, up to which it is; how near is on the curve.
_APART, _NEXT_TO, _ON_CURVE = 1e-8, 1.0, 1e-6
# Chords of a stretch between two nodes from which its swept area is extrapolated.
_CHORDS = 8


def residuals(lengths: Lengths, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return f / l_b², g_1 and g_2, and their derivatives by l, θ, χ1 and χ2.

    Parameters
    ----------
    lengths
        R, r, l_a, l_b.
    nodes
        l, θ, χ1, χ2, shape (n, 4).

    Returns
    -------
    values : ndarray
        Shape (n, 3).
    slopes : ndarray
        Shape (n, 3, 4).
    """
    base, platform, l_a, l_b = lengths
    length, theta, *chi = nodes.T
    values, slopes = np.empty((len(nodes), 3)), np.zeros((len(nodes), 3, 4))
    sines, cosines = np.sin(chi), np.cos(chi)
    turn = chi[1] - chi[0]
    values[:, 0] = length * np.sin(turn) - 2.0 * platform * sines[0] * sines[1]
    slopes[:, 0, 0] = np.sin(turn)
    slopes[:, 0, 2] = -length * np.cos(turn) - 2.0 * platform * cosines[0] * sines[1]
    slopes[:, 0, 3] = length * np.cos(turn) - 2.0 * platform * sines[0] * cosines[1]
    for place, (e, f) in enumerate(leg_vectors(lengths, length, theta)):
        leg = 1.0 - 2.0 * place
        a, b = e - l_b * cosines[place], f - l_b * sines[place]
        values[:, 1 + place] = a * a + b * b - l_a * l_a
        slopes[:, 1 + place, 0] = 2.0 * b
        slopes[:, 1 + place, 1] = 2.0 * leg * base * (a * np.sin(theta) + b * np.cos(theta))
        slopes[:, 1 + place, 2 + place] = 2.0 * l_b * (a * sines[place] - b * cosines[place])
    return values, slopes


def leg_vectors(
    lengths: Lengths, length: FloatArray, theta: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """Return the vectors from B_i to b_i of both legs in the axes of the platform."""
    base, platform, _, _ = lengths
    return [
        (leg * (platform - base * np.cos(theta)), length + leg * base * np.sin(theta))
        for leg in (1.0, -1.0)
    ]


def upper_directions(
    lengths: Lengths, length: FloatArray, theta: FloatArray, elbows: tuple[float, float]
) -> list[FloatArray]:
    """Return χ1 and χ2 of poses; beyond reach those of straight legs."""
    _, _, l_a, l_b = lengths
    found = []
    for (e, f), elbow in zip(leg_vectors(lengths, length, theta), elbows, strict=True):
        reach2 = e * e + f * f
        areas2 = ((l_a + l_b) ** 2 - reach2) * (reach2 - (l_a - l_b) ** 2)
        across = -elbow * np.sqrt(np.maximum(areas2, 0.0))
        along = reach2 + (l_b - l_a) * (l_b + l_a)
        found.append(np.arctan2(along * f + across * e, along * e - across * f))
    return found


def elbow_sides(lengths: Lengths, nodes: FloatArray) -> FloatArray:
    """Return f_i cos χ_i - e_i sin χ_i, positive for elbows as +1, zero for straight legs."""
    length, theta, *chi = nodes.T
    legs = leg_vectors(lengths, length, theta)
    return np.stack(
        [f * np.cos(angle) - e * np.sin(angle) for (e, f), angle in zip(legs, chi, strict=True)],
        axis=1,
    )


def moved_onto(lengths: Lengths, nodes: FloatArray) -> FloatArray:
    """Return the points of the curve that Newton's method of least steps finds, shape (n, 4)."""
    for _ in range(_STEPS):
        values, slopes = residuals(lengths, nodes)
        squares = slopes @ slopes.transpose(0, 2, 1) + _DAMPING * np.eye(3)
        shares = np.linalg.solve(squares, values[:, :, None])
        nodes = nodes - (slopes.transpose(0, 2, 1) @ shares)[:, :, 0]
        if np.max(np.abs(values), initial=0.0) <= _RESIDUAL:
            break
    return nodes


def solved(
    lengths: Lengths, node: FloatArray, condition: Callable[[FloatArray], tuple[float, FloatArray]]
) -> FloatArray:
    """Return the point of the curve next to a node at which a fourth condition holds.

    Parameters
    ----------
    lengths
        R, r, l_a, l_b.
    node
        Where to start, shape (4,).
    condition
        Takes a node; returns what is to vanish, and its derivatives, shape (4,).
    """
    for _ in range(_STEPS):
        values, slopes = residuals(lengths, node[None])
        value, slope = condition(node)
        right = np.append(values[0], value)
        node = node - np.linalg.solve(np.vstack([slopes[0], slope]), right)
        if np.max(np.abs(right)) <= _RESIDUAL:
            break
    return node


def tangent(slopes: FloatArray) -> FloatArray:
    """Return the unit vector that all derivatives, shape (3, 4), are normal to."""
    signs = (1.0, -1.0, 1.0, -1.0)
    minors = [np.linalg.det(np.delete(slopes, column, axis=1)) for column in range(4)]
    vector = np.array(signs) * np.array(minors)
    return np.asarray(vector / np.linalg.norm(vector))


def plane_points(nodes: FloatArray) -> FloatArray:
    """Return C, shape (n, 2), of nodes, shape (n, 4)."""
    length, theta = nodes[:, 0], nodes[:, 1]
    return np.column_stack([-length * np.sin(theta), length * np.cos(theta)])


@dataclasses.dataclass(frozen=True, eq=False)
class ForwardArc(Arc):
    """An arc of the curve where J_x is singular.

    Attributes
    ----------
    lengths
        R, r, l_a, l_b.
    nodes
        Points on the curve in order, l, θ, χ1, χ2, the angles continuous, shape (n, 4), n at
        least 2; close enough that a cubic spline tells the curve between them.
    start, end
        End points; other arcs that meet this one there have the very same.
    factor
        What the curve is multiplied by.
    """

    lengths: Lengths
    nodes: FloatArray
    start: Point
    end: Point
    factor: float = 1.0

    @classmethod
    def through(cls, lengths: Lengths, nodes: FloatArray) -> ForwardArc:
        """Return the arc through nodes on the curve."""
        ends = plane_points(nodes[[0, -1]])
        start, end = ((float(x), float(y)) for x, y in ends)
        return cls(lengths, nodes, start, end)

    def at(self, shares: FloatArray) -> FloatArray:
        """Return l, θ, χ1, χ2 at shares of the arc, shape (n, 4)."""
        return moved_onto(self.lengths, self._spline(np.clip(shares, 0.0, 1.0)))

    @functools.cached_property
    def _spline(self) -> Callable[[FloatArray], FloatArray]:
        """The cubic spline through the nodes."""
        from scipy.interpolate import CubicSpline

        spline: Callable[[FloatArray], FloatArray] = CubicSpline(self._places, self.nodes)
        return spline

    @functools.cached_property
    def _places(self) -> FloatArray:
        """Shares of the nodes: of the chords between them."""
        chords = np.linalg.norm(np.diff(self.nodes, axis=0), axis=1)
        places = np.concatenate([[0.0], np.cumsum(chords)])
        return np.asarray(places / places[-1])

    def points(self, shares: FloatArray) -> FloatArray:
        """Return exact points at shares of the arc."""
        return np.asarray(self.factor * plane_points(self.at(np.asarray(shares))))

    def swept_area(self) -> float:
        """Return ½ ∫ (x dy - y dx), to some 1e-12 of the squared lengths.

        Between nodes it is extrapolated from those of one, two, four and eight chords, whose
        differences from it are series in the squared chord (Romberg).
        """
        start, end = self._places[:-1, None], self._places[1:, None]
        shares = start + (end - start) * np.linspace(0.0, 1.0, _CHORDS + 1)
        line = self._with_exact_ends(self.points(shares.ravel()))
        x, y = line.reshape(*shares.shape, 2).transpose(2, 0, 1)
        areas = []
        for step in (8, 4, 2, 1):
            u, v = x[:, ::step], y[:, ::step]
            areas.append(0.5 * (u[:, :-1] * v[:, 1:] - u[:, 1:] * v[:, :-1]).sum(axis=1))
        for order in (4.0, 16.0, 64.0):
            areas = [
                (order * fine - coarse) / (order - 1.0)
                for coarse, fine in itertools.pairwise(areas)
            ]
        return math.fsum(areas[0])

    def extended(self, point: Point, at_end: bool) -> ForwardArc:
        """Return the arc up to a point next to one of its ends, which becomes that end.

        It is extended along the curve where the point lies on it, but not to O.
        """
        node = self.nodes[-1 if at_end else 0]
        sides = elbow_sides(self.lengths, self.nodes[len(self.nodes) // 2][None])[0]
        elbows = (math.copysign(1.0, sides[0]), math.copysign(1.0, sides[1]))
        pose = np.array([math.hypot(*point), math.atan2(-point[0], point[1])])
        chi = upper_directions(self.lengths, pose[:1], pose[1:], elbows)
        fresh = np.concatenate([pose, *chi])
        fresh[2:] += 2.0 * math.pi * np.round((node - fresh)[2:] / (2.0 * math.pi))
        nodes = self.nodes
        if pose[0] > 0.0 and np.abs(fresh - node)[:2].max() > _APART:
            fresh = moved_onto(self.lengths, fresh[None])[0]
            is_near = np.abs(fresh - node).max() < _NEXT_TO
            if is_near and np.abs(fresh[:2] - pose).max() < _ON_CURVE:
                nodes = np.vstack([nodes, fresh] if at_end else [fresh, nodes])
        start, end = (self.start, point) if at_end else (point, self.end)
        return dataclasses.replace(self, nodes=nodes, start=start, end=end)

    def goes_on_in(self, other: ForwardArc) -> bool:
        """Tell whether another arc begins in the pose in which this one ends."""
        return bool(np.abs(self.nodes[-1] - self._turned(other)[0]).max() < _SAME_POSE)

    def followed_by(self, other: ForwardArc) -> ForwardArc:
        """Return this arc and the one that goes on where it ends as one."""
        nodes = np.vstack([self.nodes, self._turned(other)[1:]])
        return dataclasses.replace(self, nodes=nodes, end=other.end)

    def _turned(self, other: ForwardArc) -> FloatArray:
        """Return the nodes of another arc with angles that go on from those of this one."""
        turns = np.round((self.nodes[-1] - other.nodes[0]) / (2.0 * math.pi))
        turns[:2] = 0.0  # only the directions of links know whole turns
        return np.asarray(other.nodes + 2.0 * math.pi * turns)

    def reversed(self) -> ForwardArc:
        """Return the arc run through the other way."""
        return dataclasses.replace(self, nodes=self.nodes[::-1], start=self.end, end=self.start)

    def scaled(self, factor: float) -> ForwardArc:
        """Return the arc with all lengths times a positive factor."""
        return dataclasses.replace(
            self,
            start=(factor * self.start[0], factor * self.start[1]),
            end=(factor * self.end[0], factor * self.end[1]),
            factor=factor * self.factor,
        )

    def mirrored(self, x: bool, y: bool) -> ForwardArc:
        """Return the image: x → -x exchanges the legs; y → -y takes l to -l."""
        length, theta, chi1, chi2 = self.nodes.T
        if x:
            theta, chi1, chi2 = -theta, math.pi - chi2, math.pi - chi1
        if y:
            length, theta, chi1, chi2 = -length, -theta, -chi1, -chi2
        return dataclasses.replace(
            self,
            nodes=np.column_stack([length, theta, chi1, chi2]),
            start=mirror(self.start, x, y),
            end=mirror(self.end, x, y),
        )
