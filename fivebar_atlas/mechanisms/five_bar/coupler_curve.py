"""Arcs of C_col, where B1, P and B2 are in line (Liu et al. 2006, Eq. 27).

C_col is the curve of the middle of the coupler of a four-bar with cranks r1, coupler 2 r2 and
base 2 r3. In polar form (:mod:`singularity`) it has two branches ρ(φ); an arc runs over
pieces of them, from one to the other where the curve touches a ray or passes through the
origin.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from fivebar_atlas.mechanisms.five_bar.points import radii_along
from fivebar_atlas.mechanisms.five_bar.singularity import (
    COUPLER_MINUS,
    COUPLER_PLUS,
    swept_area,
)
from fivebar_atlas.planar_geometry import Arc, FloatArray, Point, mirror

#: A branch of C_col and the angles from and to which it is run through.
Piece = tuple[int, float, float]


@dataclasses.dataclass(frozen=True, slots=True)
class CouplerArc(Arc):
    """An arc of C_col.

    Attributes
    ----------
    lengths
        r1, r2, r3.
    pieces
        What is run through, in order: branch of :mod:`singularity`, first and last angle.
    start, end
        End points; other arcs that meet this one there have the very same.
    factor
        What the curve of these lengths is multiplied by.
    """

    lengths: tuple[float, float, float]
    pieces: tuple[Piece, ...]
    start: Point
    end: Point
    factor: float = 1.0

    def points(self, shares: FloatArray) -> FloatArray:
        """Return exact points at shares of the arc; the pieces have equal shares.

        Within a piece the angle moves slowly at both ends, 3 v² - 2 v³: so the curve is
        smooth in the share also where it touches a ray.
        """
        position = np.clip(np.asarray(shares, dtype=np.float64), 0.0, 1.0) * len(self.pieces)
        number = np.minimum(position.astype(np.int64), len(self.pieces) - 1)
        v = position - number
        line = np.empty((len(position), 2))
        for place, (curve, start, end) in enumerate(self.pieces):
            here = number == place
            phi = start + (end - start) * v[here] ** 2 * (3.0 - 2.0 * v[here])
            rho = np.empty_like(phi)
            radii_along(curve, *self.lengths, phi, rho)
            line[here, 0] = self.factor * rho * np.cos(phi)
            line[here, 1] = self.factor * rho * np.sin(phi)
        return line

    def swept_area(self) -> float:
        """Return the sum over the pieces of ½ ∫ ρ² dφ, an elementary integral."""
        return self.factor**2 * math.fsum(
            swept_area(curve, *self.lengths, start, end) for curve, start, end in self.pieces
        )

    def followed_by(self, other: CouplerArc) -> CouplerArc:
        """Return this arc and the one that goes on where it ends as one."""
        pieces = tuple(without_cuts([*self.pieces, *other.pieces]))
        return dataclasses.replace(self, pieces=pieces, end=other.end)

    def reversed(self) -> CouplerArc:
        """Return the arc run through the other way."""
        pieces = tuple((curve, end, start) for curve, start, end in reversed(self.pieces))
        return dataclasses.replace(self, pieces=pieces, start=self.end, end=self.start)

    def scaled(self, factor: float) -> CouplerArc:
        """Return the arc with all lengths times a positive factor."""
        return dataclasses.replace(
            self,
            start=(factor * self.start[0], factor * self.start[1]),
            end=(factor * self.end[0], factor * self.end[1]),
            factor=factor * self.factor,
        )

    def mirrored(self, x: bool, y: bool) -> CouplerArc:
        """Return the image, which is an arc of C_col again.

        x → -x keeps the branch, y → -y exchanges the two.
        """
        pieces = []
        for curve, start, end in self.pieces:
            if x:
                start, end = math.pi - start, math.pi - end
            if y:
                start, end = -start, -end
                curve = COUPLER_MINUS if curve == COUPLER_PLUS else COUPLER_PLUS
            pieces.append((curve, start, end))
        return dataclasses.replace(
            self, pieces=tuple(pieces), start=mirror(self.start, x, y), end=mirror(self.end, x, y)
        )


def without_cuts(pieces: Sequence[Piece]) -> list[Piece]:
    """Join neighbouring pieces of one branch where one goes on at the angle of the other."""
    joined: list[Piece] = []
    for curve, start, end in pieces:
        if joined and joined[-1][0] == curve and joined[-1][2] == start:
            joined[-1] = (curve, joined[-1][1], end)
        else:
            joined.append((curve, start, end))
    return joined
