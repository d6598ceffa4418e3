"""Points along the side of the largest square over the ratio of links, piece by piece."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.largest_square import SquareTask, largest_square
from fivebar_atlas.synthesis.square_curve import Piece, SquareCurve

# Points that the whole curve and every piece of it have at least.
_POINTS, _POINTS_OF_PIECE = 48, 8
# How far inside of a piece its ends are taken, where constraints change within rounding.
_INSIDE = 1e-9


@dataclasses.dataclass(frozen=True, slots=True)
class CurveLine:
    """A piece of the curve.

    Attributes
    ----------
    active
        Its active constraints; none where there is no square.
    points
        Ratios, rising from its start to its end, and sides, shape (n, 2).
    """

    active: tuple[str, ...]
    points: FloatArray


def curve_lines(task: SquareTask, curve: SquareCurve) -> tuple[CurveLine, ...]:
    """Return points along every piece of a curve, closer than its ratios where these are few.

    Both ends of a piece are among its points, with the side on its own side of a kink.

    Parameters
    ----------
    task
        What is asked of the squares.
    curve
        The curve for this task.
    """
    known = {square.ratio: square.side for square in curve.squares}

    def side(ratio: float) -> float:
        if ratio not in known:
            lengths = task.mechanism.optimal_configuration(ratio).lengths
            known[ratio] = largest_square(task, lengths).side
        return known[ratio]

    step = (curve.pieces[-1].end - curve.pieces[0].start) / _POINTS
    lines = []
    for piece in curve.pieces:
        ratios = _ratios(piece, [square.ratio for square in curve.squares], step)
        inside = np.clip(ratios, *_inside(piece, curve))
        sides = [side(float(ratio)) for ratio in inside]
        lines.append(CurveLine(piece.active, np.column_stack([ratios, sides])))
    return tuple(lines)


def _ratios(piece: Piece, known: list[float], step: float) -> FloatArray:
    """Return ratios over a piece: known ones, its ends, and more where these are far apart."""
    ends = [
        piece.start,
        *(ratio for ratio in known if piece.start < ratio < piece.end),
        piece.end,
    ]
    step = min(step, (piece.end - piece.start) / _POINTS_OF_PIECE)
    ratios = [piece.start]
    for low, high in itertools.pairwise(ends):
        # a step that is about the one between known ratios needs none in between
        count = max(round((high - low) / step), 1)
        ratios += [low + (high - low) * number / count for number in range(1, count)]
        ratios.append(high)
    return np.array(ratios)


def _inside(piece: Piece, curve: SquareCurve) -> tuple[float, float]:
    """Return the ends of a piece, those next to another one moved inwards."""
    gap = min(_INSIDE, 0.25 * (piece.end - piece.start))
    is_first, is_last = piece is curve.pieces[0], piece is curve.pieces[-1]
    return piece.start + (0.0 if is_first else gap), piece.end - (0.0 if is_last else gap)
