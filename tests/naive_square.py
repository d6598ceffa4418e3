"""The largest square workspace in obvious NumPy, independent of the package.

A rectangle about a centre is star-shaped, so the largest one whose points are all good is where
the first ray from its centre meets a point that is not. Rays are followed in steps, and closed in
on by bisection; the least one is closed in on by golden section along each side of the rectangle.

A point is good where the mechanism reaches it in the wanted assembly mode, the LCI is at least a
threshold, and the input angles are in their ranges. Lengths are those of the actuated link.

References
----------
Le, Kang, Doan, "A method for optimal kinematic design of five-bar planar parallel manipulators",
ICCAIS 2013.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping

import naive
import numpy as np
from naive import Array, Mask

Good = Callable[[Array, Array], Mask]

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclasses.dataclass(frozen=True)
class Wanted:
    """A machine, a mode pair and what is asked of its points; ranges in radians by number."""

    lengths: tuple[float, float, float]
    signs: tuple[int, int] = (1, -1)
    assembly: int = 1
    lci_threshold: float = 0.5
    ranges: Mapping[int, tuple[float, float]] = dataclasses.field(default_factory=dict)

    def reached(self, x: Array, y: Array) -> Mask:
        """Tell which points the machine reaches in its assembly mode."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.assembly * naive.det_b(*self.lengths, x, y, *self.signs) > 0.0)

    def good(self, x: Array, y: Array) -> Mask:
        """Tell which points are good."""
        good = self.reached(x, y) & (lci(*self.lengths, x, y, *self.signs) >= self.lci_threshold)
        angles = naive.inverse_kinematics(*self.lengths, x, y, *self.signs)
        for number, (least, greatest) in self.ranges.items():
            # the turn that begins at the least angle
            good &= np.mod(angles[number - 1] - least, 2.0 * np.pi) <= greatest - least
        return good


def optimal_lengths(ratio: float) -> tuple[float, float, float]:
    """Return l1, l2, l0 of Eq. 21 for l1 = 1."""
    return 1.0, ratio, (ratio - 1.0) * math.sqrt(2.0) / 2.0


def lci(r1: float, r2: float, r3: float, x: Array, y: Array, s1: int, s2: int) -> Array:
    """LCI from the Frobenius norm and the determinant of J, for κ + 1/κ is their ratio."""
    j = naive.jacobian(r1, r2, r3, x, y, s1, s2)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        total = (j**2).sum(axis=(-2, -1)) / np.abs(
            j[..., 0, 0] * j[..., 1, 1] - j[..., 0, 1] * j[..., 1, 0]
        )
        # the smaller root of c^2 - total c + 1 = 0
        return np.asarray(2.0 / (total + np.sqrt(np.maximum(total**2 - 4.0, 0.0))))


def first_bad(
    good: Good, centre: Array, directions: Array, farthest: float, halvings: int = 48
) -> Array:
    """Return at which multiple of directions, shape (n, 2), a point is first not good, shape (n,).

    At most the farthest one; infinite if all are good up to it.
    """
    s = np.linspace(0.0, farthest, 241)
    points = centre + s[:, None, None] * directions
    inside = good(points[..., 0], points[..., 1])
    place = np.argmin(inside, axis=0)
    always = inside.all(axis=0)
    low, high = s[np.maximum(place - 1, 0)], s[place]
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        points = centre + middle[:, None] * directions
        fits = good(points[:, 0], points[:, 1])
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return np.where(always, np.inf, np.where(place == 0, 0.0, low))


def least_over_sides(
    good: Good, centre: Array, corners: Array, farthest: float, samples: int = 100
) -> float:
    """Return the least of :func:`first_bad` over the sides of a polygon, corners (k, 2)."""
    shares = np.linspace(0.0, 1.0, samples + 1)

    def at(side: int, share: Array, halvings: int = 48) -> Array:
        start, end = corners[side], corners[(side + 1) % len(corners)]
        directions = start + share[:, None] * (end - start)
        return first_bad(good, centre, directions, farthest, halvings)

    values = np.array([at(side, shares, 12) for side in range(len(corners))])
    best = float(values.min())
    if not 0.0 < best < np.inf:
        return best
    best = min(float(at(side, np.array([0.0]))[0]) for side in range(len(corners)))
    for side in np.flatnonzero(values.min(axis=1) < 1.05 * values.min()):
        lowest = int(np.argmin(values[side]))
        low, high = shares[max(lowest - 1, 0)], shares[min(lowest + 1, samples)]

        def less(share: float, side: int = side) -> float:
            return -float(at(side, np.array([share]))[0])

        best = min(best, -maximum(less, low, high)[1])
    return best


def maximum(
    value: Callable[[float], float], low: float, high: float, accuracy: float = 1e-9
) -> tuple[float, float]:
    """Return where a function with one local maximum is largest, and its value."""
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_left, at_right = value(left), value(right)
    while high - low > accuracy:
        if at_left >= at_right:
            high, right, at_right = right, left, at_left
            left = high - _GOLDEN * (high - low)
            at_left = value(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + _GOLDEN * (high - low)
            at_right = value(right)
    return (left, at_left) if at_left >= at_right else (right, at_right)


def largest_side(wanted: Wanted, centre_y: float, aspect: float = 1.0, limit: float = 3.0) -> float:
    """Return the root of the area of the largest good rectangle about (0, y), up to a limit."""
    half = 0.5 * np.array([math.sqrt(aspect), 1.0 / math.sqrt(aspect)])
    corners = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return min(least_over_sides(wanted.good, np.array([0.0, centre_y]), corners, limit), limit)


def circle_between_reach_circles(
    lengths: tuple[float, float, float],
) -> tuple[float, float]:
    """Return radius and height of the largest circle on the upper axis between all reach circles.

    The distance from the inner ones grows with the height and that from the outer ones falls, so
    that bisection finds where they are equal.
    """
    r1, r2, r3 = lengths
    low, high = math.sqrt(max((r1 - r2) ** 2 - r3**2, 0.0)), math.sqrt((r1 + r2) ** 2 - r3**2)
    for _ in range(200):
        middle = 0.5 * (low + high)
        distance = math.hypot(r3, middle)
        if distance - abs(r1 - r2) < r1 + r2 - distance:
            low = middle
        else:
            high = middle
    return math.hypot(r3, low) - abs(r1 - r2), low


def reach_of_circle(wanted: Wanted, centre_y: float, farthest: float = 3.0) -> float:
    """Return the radius of the largest circle about (0, y) that the machine reaches all of."""

    def at(turn: Array) -> Array:
        directions = np.column_stack([np.cos(turn), np.sin(turn)])
        return first_bad(wanted.reached, np.array([0.0, centre_y]), directions, farthest)

    turns = np.linspace(-np.pi, np.pi, 721)
    values = at(turns)
    lowest = int(np.argmin(values))
    step = float(turns[1] - turns[0])
    low, high = turns[lowest] - step, turns[lowest] + step
    return -maximum(lambda turn: -float(at(np.array([turn]))[0]), low, high)[1]
