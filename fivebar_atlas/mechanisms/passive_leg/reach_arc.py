"""Curves of C on which a point of the platform keeps its distance from a base joint.

The point σ a on the u axis of the platform, a its arm and σ = ±1 for leg 1 or 2, has the distance
ρ from B_i on the two sheets

    l = -σ R sin θ ± √(ρ² - (a - R cos θ)²).

With the arm r of the platform and ρ = l_a + l_b or |l_a - l_b| leg i is stretched or folded
(Eqs. 12, 22). With the arm r + l_b or r - l_b and ρ = l_a its upper link is parallel to the
platform: the limit of the passive joint b_i (Eq. 13). Seen from O an arc on the sheet + runs
counter-clockwise where θ grows.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fivebar_atlas.planar_geometry import Arc, FloatArray, Point, mirror

#: Sheet ±1, first and last angle of the passive leg.
Piece = tuple[float, float, float]


@dataclasses.dataclass(frozen=True, slots=True)
class ReachCurve:
    """All of such a curve.

    Attributes
    ----------
    base
        R.
    arm
        Arm a of the point on the platform.
    reach
        Its distance ρ from the base joint.
    leg
        +1 for leg 1, -1 for leg 2.
    """

    base: float
    arm: float
    reach: float
    leg: float

    def lengths(self, theta: FloatArray, sheet: float) -> FloatArray:
        """Return l at angles, shape (n,); where there is none, that of the nearest pose."""
        gap = self.arm - self.base * np.cos(theta)
        half = np.sqrt(np.maximum((self.reach - gap) * (self.reach + gap), 0.0))
        return np.asarray(-self.leg * self.base * np.sin(theta) + sheet * half)

    def point(self, theta: float, sheet: float) -> Point:
        """Return C at an angle."""
        length = float(self.lengths(np.array([theta]), sheet)[0])
        return -length * math.sin(theta), length * math.cos(theta)

    def ranges(self, limit: float) -> list[tuple[float, float]]:
        """Return the ranges of θ within a limit over which the curve goes, by rising θ."""
        least = (self.arm - self.reach) / self.base
        most = (self.arm + self.reach) / self.base
        if least >= 1.0 or most <= -1.0:
            return []
        inner = math.acos(most) if most < 1.0 else 0.0
        outer = min(math.acos(max(least, -1.0)), limit)
        if inner >= outer:
            return []
        return [(-outer, -inner), (inner, outer)] if inner > 0.0 else [(-outer, outer)]

    def angles_at_no_length(self) -> tuple[float, ...]:
        """Return the angles at which l = 0 on one of the sheets, or on both."""
        if self.arm == 0.0:  # C itself: none, or all angles
            return ()
        cosine = (self.base**2 + self.arm**2 - self.reach**2) / (2.0 * self.base * self.arm)
        if abs(cosine) > 1.0:
            return ()
        angle = math.acos(cosine)
        return (-angle, angle) if angle > 0.0 else (0.0,)

    def swept_area(self, theta: float, sheet: float) -> float:
        """Return an antiderivative of ½ l² by θ."""
        base, arm, reach = self.base, self.arm, self.reach
        c, s = math.cos(theta), math.sin(theta)
        gap = max(-reach, min(reach, arm - base * c))
        half = math.sqrt((reach - gap) * (reach + gap))
        # ∫ 2 R sin θ √(ρ² - v²) dθ with v = a - R cos θ
        lens = gap * half + reach * reach * math.atan2(gap, half)
        even = (reach * reach - arm * arm) * theta + base * s * (2.0 * arm - base * c)
        return 0.5 * (even - self.leg * sheet * lens)


@dataclasses.dataclass(frozen=True, slots=True)
class ReachArc(Arc):
    """An arc of a :class:`ReachCurve`.

    Attributes
    ----------
    curve
        The curve.
    pieces
        What is run through, in order: sheet, first and last angle.
    start, end
        End points; other arcs that meet this one there have the very same.
    factor
        What the curve is multiplied by.
    """

    curve: ReachCurve
    pieces: tuple[Piece, ...]
    start: Point
    end: Point
    factor: float = 1.0

    @classmethod
    def of_pieces(cls, curve: ReachCurve, pieces: tuple[Piece, ...]) -> ReachArc:
        """Return the arc with end points computed from its angles."""
        (first, start, _), (last, _, end) = pieces[0], pieces[-1]
        return cls(curve, pieces, curve.point(start, first), curve.point(end, last))

    def points(self, shares: FloatArray) -> FloatArray:
        """Return exact points at shares of the arc; the pieces have equal shares.

        Within a piece the angle moves slowly at both ends, 3 v² - 2 v³: so the curve is smooth
        in the share also where it touches a ray from O.
        """
        position = np.clip(np.asarray(shares, dtype=np.float64), 0.0, 1.0) * len(self.pieces)
        number = np.minimum(position.astype(np.int64), len(self.pieces) - 1)
        v = position - number
        line = np.empty((len(position), 2))
        for place, (sheet, start, end) in enumerate(self.pieces):
            here = number == place
            theta = start + (end - start) * v[here] ** 2 * (3.0 - 2.0 * v[here])
            length = self.factor * self.curve.lengths(theta, sheet)
            line[here, 0], line[here, 1] = -length * np.sin(theta), length * np.cos(theta)
        return line

    def swept_area(self) -> float:
        """Return the sum over the pieces of ½ ∫ l² dθ, an elementary integral."""
        return self.factor**2 * math.fsum(
            sign * self.curve.swept_area(theta, sheet)
            for sheet, start, end in self.pieces
            for sign, theta in ((1.0, end), (-1.0, start))
        )

    def followed_by(self, other: ReachArc) -> ReachArc:
        """Return this arc and the one of the same curve that goes on where it ends as one."""
        joined = list(self.pieces)
        for sheet, start, end in other.pieces:
            if joined[-1][0] == sheet and joined[-1][2] == start:
                joined[-1] = (sheet, joined[-1][1], end)
            else:
                joined.append((sheet, start, end))
        return dataclasses.replace(self, pieces=tuple(joined), end=other.end)

    def reversed(self) -> ReachArc:
        """Return the arc run through the other way."""
        pieces = tuple((sheet, end, start) for sheet, start, end in reversed(self.pieces))
        return dataclasses.replace(self, pieces=pieces, start=self.end, end=self.start)

    def scaled(self, factor: float) -> ReachArc:
        """Return the arc with all lengths times a positive factor."""
        return dataclasses.replace(
            self,
            start=(factor * self.start[0], factor * self.start[1]),
            end=(factor * self.end[0], factor * self.end[1]),
            factor=factor * self.factor,
        )

    def mirrored(self, x: bool, y: bool) -> ReachArc:
        """Return the image: x → -x exchanges the legs, y → -y the sheets, with -l for l."""
        turn = 1.0 if x == y else -1.0
        pieces = tuple(
            (-sheet if y else sheet, turn * start, turn * end) for sheet, start, end in self.pieces
        )
        curve = dataclasses.replace(self.curve, leg=-self.curve.leg) if x else self.curve
        return dataclasses.replace(
            self,
            curve=curve,
            pieces=pieces,
            start=mirror(self.start, x, y),
            end=mirror(self.end, x, y),
        )
