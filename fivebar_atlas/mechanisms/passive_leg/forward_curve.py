"""All of the curve where J_x is singular, followed from point to point.

Points to begin with are looked for at many angles of the passive leg and in all working modes.
From each the curve is followed both ways, until it closes, or leaves l > 0 or the range of θ. It
passes from one working mode to another where a leg is straight: there it is cut.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.passive_leg.forward_arc import (
    elbow_sides,
    leg_vectors,
    moved_onto,
    residuals,
    solved,
    tangent,
    upper_directions,
)
from fivebar_atlas.mechanisms.passive_leg.points import Lengths
from fivebar_atlas.planar_geometry import FloatArray

BoolArray = npt.NDArray[np.bool_]

#: Why a stretch of the curve ends: a leg is straight, both upper links lie along the platform, the
#: passive leg is at its limit or has no length, or the curve closes.
STRAIGHT, ALONG, LIMIT, NO_LENGTH, CLOSED = "straight", "along", "limit", "no length", "closed"

# Angles and lengths at which points to begin with are looked for; halvings.
_ANGLES, _PLACES, _HALVINGS = 241, 60, 50
# Step along the curve: first, least, largest; largest turn of its tangent in a step; most steps.
_STEP, _LEAST_STEP, _LARGEST_STEP, _TURN, _MOST_STEPS = 0.02, 1e-5, 0.05, 0.12, 6000
# How near to a stretch that is known a point is on it, in l, θ and χ.
_ON_IT = 1.5e-3
# Where the passive leg is no longer than this it has no length, and one upper link alone may lie
# along the platform.
_NO_LENGTH = 1e-7


@dataclasses.dataclass(frozen=True, eq=False)
class Stretch:
    """A stretch of the curve in one working mode.

    Attributes
    ----------
    nodes
        Points in order, l, θ, χ1, χ2, shape (n, 4).
    elbows
        Elbows of both legs as ±1.
    below
        Whether both upper links are below the platform.
    ends
        Why it ends, at the start and at the end.
    """

    nodes: FloatArray
    elbows: tuple[int, int]
    below: bool
    ends: tuple[str, str]


@functools.lru_cache(maxsize=64)
def forward_curve(lengths: Lengths, theta_limit: float) -> tuple[Stretch, ...]:
    """Return all stretches of the curve in l > 0 and |θ| within a limit.

    Closed parts that are smaller than the distance of the angles that are looked at, some 0.01
    rad, may be missed.
    """
    seeds = _seeds(lengths, theta_limit)
    found: list[Stretch] = []
    known = np.empty((0, 2, 4))
    for seed in seeds:
        if _is_on(known, seed):
            continue
        chain, ends = _followed(lengths, theta_limit, seed)
        known = np.concatenate([known, np.stack([chain[:-1], chain[1:]], axis=1)])
        found.extend(_cut(lengths, chain, ends))
    return tuple(found)


def _seeds(lengths: Lengths, theta_limit: float) -> FloatArray:
    """Return points on the curve in every working mode, shape (n, 4)."""
    base, platform, l_a, l_b = lengths
    theta = theta_limit * (2.0 * np.arange(_ANGLES) + 1.0 - _ANGLES + 0.137) / (_ANGLES + 1.0)
    # lengths at which a leg is straight cut the column
    gap = platform - base * np.cos(theta)
    cuts = [np.zeros(_ANGLES)]
    for reach in (l_a + l_b, abs(l_a - l_b)):
        half = np.sqrt(np.maximum((reach - gap) * (reach + gap), 0.0))
        cuts += [
            side * base * np.sin(theta) + sheet * half for side in (-1, 1) for sheet in (-1, 1)
        ]
    ends = np.sort(np.maximum(np.stack(cuts), 0.0), axis=0)
    v = np.linspace(0.0, 1.0, _PLACES + 1)
    share = 0.5 * (1.0 - np.cos(math.pi * v))
    length = ends[:-1, None] + (ends[1:] - ends[:-1])[:, None] * share[:, None]
    angles = np.broadcast_to(theta, length.shape)
    inside = _are_reached(
        lengths, 0.5 * (ends[1:] + ends[:-1]), np.broadcast_to(theta, ends[1:].shape)
    )
    seeds = []
    for elbow1 in (-1.0, 1.0):
        for elbow2 in (-1.0, 1.0):
            value = functools.partial(_value, lengths, elbows=(elbow1, elbow2))
            f = value(length, angles)
            change = (f[:, :-1] * f[:, 1:] < 0.0) & inside[:, None]
            where = np.nonzero(change)
            low, high = length[:, :-1][where], length[:, 1:][where]
            at, f_low = angles[:, 1:][where], f[:, :-1][where]
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                same = value(middle, at) * f_low > 0.0
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            chi = upper_directions(lengths, low, at, (elbow1, elbow2))
            seeds.append(np.column_stack([low, at, *chi]))
    return moved_onto(lengths, np.concatenate(seeds))


def _value(
    lengths: Lengths, length: FloatArray, theta: FloatArray, elbows: tuple[float, float]
) -> FloatArray:
    """Return f / l_b²; beyond reach that of straight legs."""
    chi1, chi2 = upper_directions(lengths, length, theta, elbows)
    crossed = length * np.sin(chi2 - chi1)
    return np.asarray(crossed - 2.0 * lengths[1] * np.sin(chi1) * np.sin(chi2))


def _are_reached(lengths: Lengths, length: FloatArray, theta: FloatArray) -> BoolArray:
    """Tell which poses both legs reach."""
    _, _, l_a, l_b = lengths
    reached = np.ones(length.shape, dtype=np.bool_)
    for e, f in leg_vectors(lengths, length, theta):
        reach2 = e * e + f * f
        reached &= (reach2 <= (l_a + l_b) ** 2) & (reach2 >= (l_a - l_b) ** 2)
    return reached


def _is_on(known: FloatArray, point: FloatArray) -> bool:
    """Tell whether a point lies on stretches between known points, shape (n, 2, 4)."""
    if not len(known):
        return False
    along = known[:, 1] - known[:, 0]
    off = point - known[:, 0]
    off[:, 2:] = np.remainder(off[:, 2:] + math.pi, 2.0 * math.pi) - math.pi
    share = np.clip((off * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300), 0, 1)
    return bool(np.min(np.abs(off - share[:, None] * along).max(axis=1)) < _ON_IT)


def _followed(
    lengths: Lengths, theta_limit: float, seed: FloatArray
) -> tuple[FloatArray, tuple[str, str]]:
    """Follow the curve both ways from a point; return its points and why it ends."""
    ahead, end = _one_way(lengths, theta_limit, seed, 1.0)
    if end == CLOSED:
        return ahead, (CLOSED, CLOSED)
    back, start = _one_way(lengths, theta_limit, seed, -1.0)
    return np.vstack([back[:0:-1], ahead]), (start, end)


def _one_way(
    lengths: Lengths, theta_limit: float, seed: FloatArray, way: float
) -> tuple[FloatArray, str]:
    """Follow the curve one way; return its points from the seed on, and why it ends."""
    nodes = [seed]
    heading = way * tangent(residuals(lengths, seed[None])[1][0])
    step, is_away = _STEP, False
    for _ in range(_MOST_STEPS):
        here = nodes[-1]
        ahead = here + step * heading
        fresh = solved(lengths, ahead, _plane(ahead, heading))
        values, slopes = residuals(lengths, fresh[None])
        turned = tangent(slopes[0])
        turned *= 1.0 if turned @ heading > 0.0 else -1.0
        turn = math.acos(min(1.0, float(turned @ heading)))
        is_on = np.max(np.abs(values)) < 1e-11
        strays = np.linalg.norm(fresh - ahead) > 0.3 * step
        if (not is_on or strays or turn > _TURN) and step > _LEAST_STEP:
            step *= 0.5
            continue
        if not fresh[0] > 0.0:
            return np.array([*nodes, solved(lengths, here, _coordinate(0, 0.0))]), NO_LENGTH
        if abs(fresh[1]) > theta_limit:
            bound = math.copysign(theta_limit, fresh[1])
            return np.array([*nodes, solved(lengths, here, _coordinate(1, bound))]), LIMIT
        if is_away and _passes(here, fresh, seed):
            last = seed.copy()
            last[2:] += 2.0 * math.pi * np.round((here[2:] - seed[2:]) / (2.0 * math.pi))
            return np.array([*nodes, last]), CLOSED
        nodes.append(fresh)
        is_away = is_away or bool(np.linalg.norm(fresh - seed) > 2.0 * _LARGEST_STEP)
        heading = turned
        if turn < 0.5 * _TURN:
            step = min(1.4 * step, _LARGEST_STEP)
    return np.array(nodes), CLOSED


def _passes(here: FloatArray, fresh: FloatArray, seed: FloatArray) -> bool:
    """Tell whether a step passes a point."""
    return _is_on(np.stack([here, fresh])[None], seed)


def _plane(
    point: FloatArray, normal: FloatArray
) -> Callable[[FloatArray], tuple[float, FloatArray]]:
    """Return the condition to lie on a plane."""

    def condition(node: FloatArray) -> tuple[float, FloatArray]:
        return float((node - point) @ normal), normal

    return condition


def _coordinate(place: int, value: float) -> Callable[[FloatArray], tuple[float, FloatArray]]:
    """Return the condition that a coordinate has a value."""
    return _plane(np.full(4, value), np.eye(4)[place])


def _straight(lengths: Lengths, leg: int) -> Callable[[FloatArray], tuple[float, FloatArray]]:
    """Return the condition that a leg is straight: f_i cos χ_i = e_i sin χ_i."""
    base, platform, _, _ = lengths
    side = 1.0 if leg == 0 else -1.0

    def condition(node: FloatArray) -> tuple[float, FloatArray]:
        length, theta, chi = node[0], node[1], node[2 + leg]
        c, s = math.cos(theta), math.sin(theta)
        e, f = side * (platform - base * c), length + side * base * s
        slope = np.zeros(4)
        slope[0] = math.cos(chi)
        slope[1] = side * base * (c * math.cos(chi) - s * math.sin(chi))
        slope[2 + leg] = -f * math.sin(chi) - e * math.cos(chi)
        return f * math.cos(chi) - e * math.sin(chi), slope

    return condition


def _along_platform(node: FloatArray) -> tuple[float, FloatArray]:
    """Give sin χ1, which on the curve vanishes together with sin χ2, and its derivatives."""
    return math.sin(node[2]), np.array([0.0, 0.0, math.cos(node[2]), 0.0])


def _cut(lengths: Lengths, chain: FloatArray, ends: tuple[str, str]) -> list[Stretch]:
    """Cut a chain of points where a leg is straight or the upper links lie along the platform."""
    tests = np.column_stack([elbow_sides(lengths, chain), np.sin(chain[:, 2])])
    # what vanishes in a node belongs to the node's other side
    signs: BoolArray = tests > 0.0
    conditions = (_straight(lengths, 0), _straight(lengths, 1), _along_platform)
    reasons = (STRAIGHT, STRAIGHT, ALONG)
    pieces: list[tuple[FloatArray, tuple[str, str]]] = []
    current = [chain[0]]
    begun = ends[0]
    for place in range(len(chain) - 1):
        one, two = chain[place], chain[place + 1]
        crossings = []
        for which in np.flatnonzero(signs[place] != signs[place + 1]):
            before, after = tests[place, which], tests[place + 1, which]
            guess = one + before / (before - after) * (two - one)
            node = solved(lengths, moved_onto(lengths, guess[None])[0], conditions[which])
            if node[0] > _NO_LENGTH:
                crossings.append((float((node - one) @ (two - one)), node, reasons[which]))
        for _, node, reason in sorted(crossings, key=lambda each: each[0]):
            pieces.append((np.array([*current, node]), (begun, reason)))
            current, begun = [node], reason
        current.append(two)
    pieces.append((np.array(current), (begun, ends[1])))
    if ends == (CLOSED, CLOSED) and len(pieces) > 1:
        # the first and the last piece are one
        (last, (start, _)), (first, (_, end)) = pieces.pop(), pieces.pop(0)
        pieces.append((np.vstack([last, first[1:] + last[-1] - first[0]]), (start, end)))
    return [_stretch(lengths, nodes, both) for nodes, both in pieces]


def _stretch(lengths: Lengths, nodes: FloatArray, ends: tuple[str, str]) -> Stretch:
    """Return a stretch with the working mode of its middle."""
    middle = nodes[len(nodes) // 2] if len(nodes) > 2 else nodes.mean(axis=0)
    sides = elbow_sides(lengths, middle[None])[0]
    below = bool(np.sin(middle[2]) > 0.0 and np.sin(middle[3]) > 0.0)
    return Stretch(nodes, (_sign(sides[0]), _sign(sides[1])), below, ends)


def _sign(value: float) -> int:
    return 1 if value > 0.0 else -1
