"""The least LCI of a whole shape, found exactly: edges and interior, kinks included.

Samples closed in on give a value that is taken. Branch and bound then proves that no smaller
one is: the shape is covered with squares, a square is done with where the bound of
:meth:`PlanarDesign.bounds_on_discs` on the disc around it is above the least value known less
a tolerance, and cut into four otherwise. Points that the squares come upon lower that value.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import FloatArray, Point
from fivebar_atlas.synthesis.containment import covering_squares, quartered
from fivebar_atlas.synthesis.practical_workspace import PracticalWorkspace
from fivebar_atlas.synthesis.shapes import Shape

# By how much the bound may be below the value that is taken.
_TOLERANCE = 1e-9
_MOST_SQUARES = 2_000_000


@dataclasses.dataclass(frozen=True, slots=True)
class LeastLci:
    """The least LCI of a shape.

    Attributes
    ----------
    value
        The LCI at the position; 0 where the shape is not within the usable workspace.
    position
        Where it is, in non-dimensional lengths.
    bound
        No point of the shape has a smaller LCI; 0 where that could not be shown.
    squares
        Squares looked at for that.
    """

    value: float
    position: Point
    bound: float
    squares: int


def least_lci(
    design: PlanarDesign, mode: str, shape: Shape, position: Point, scale: float
) -> LeastLci:
    """Return the least LCI of a shape in the usable workspace, with a bound of it.

    Parameters
    ----------
    design
        The non-dimensional design.
    mode
        Mode pair.
    shape
        The shape, in lengths of a machine.
    position
        Its centre in non-dimensional lengths.
    scale
        Non-dimensional length for the unit of the shape, 1/D.
    """

    def lci(points: FloatArray) -> FloatArray:
        x, y = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
        return design.lci_inside(x, y, mode)

    workspace = PracticalWorkspace.of_shape(shape, position, scale)
    negative, where = workspace.greatest(lambda points: -lci(points))
    value = 0.0 - negative
    place = np.array(position)
    centres, half = covering_squares(shape)
    bound, count = value - _TOLERANCE, 0
    while len(centres) and value > 0.0:
        count += len(centres)
        if len(centres) > _MOST_SQUARES:
            bound = 0.0
            break
        reach = math.sqrt(2.0) * half
        at = place + scale * centres
        least, _ = design.bounds_on_discs(
            at[:, 0].copy(), at[:, 1].copy(), np.full(len(at), scale * reach), mode
        )
        gaps = shape.gaps(centres)
        left = (least < bound) & (gaps <= reach)
        inside = centres[left & (gaps <= 0.0)]
        if len(inside):
            values = lci(place + scale * inside)
            lowest = int(np.argmin(values))
            if values[lowest] < value:
                value, bound = float(values[lowest]), float(values[lowest]) - _TOLERANCE
                x, y = place + scale * inside[lowest]
                where = float(x), float(y)
        centres, half = quartered(centres[left], half)
    return LeastLci(value, where, max(bound, 0.0) if value > 0.0 else 0.0, count)
