"""Points along the side of the largest square over the ratio of links, piece by piece."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.largest_square import SquareTask
from fivebar_atlas.synthesis.square_curve import Piece, SquareCurve, tied_square

# Points that a piece has at least, and times that its steps are halved at most.
_POINTS, _HALVINGS = 8, 4
# How far a point may be from the chord past it, as a share of the range of sides.
_BEND = 2e-3
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
    """Return points along every piece of a curve, so close that chords show no corners.

    Both ends of a piece are among its points, with the side on its own side of a kink.

    Parameters
    ----------
    task
        What is asked of the squares.
    curve
        The curve for this task.
    """
    known = {square.ratio: square.side for square in curve.squares}
    extent = max(known.values()) - min(known.values())

    def side(ratio: float) -> float:
        if ratio not in known:
            known[ratio] = tied_square(task, ratio, is_proved=False).side
        return known[ratio]

    lines = []
    for piece in curve.pieces:
        low, high = _inside(piece, curve)
        ratios = _ratios(low, high, [square.ratio for square in curve.squares])
        points = np.array([(ratio, side(ratio)) for ratio in ratios])
        if piece.active:
            points = _refined(side, points, _BEND * extent)
        points[0, 0], points[-1, 0] = piece.start, piece.end
        lines.append(CurveLine(piece.active, points))
    return tuple(lines)


def _inside(piece: Piece, curve: SquareCurve) -> tuple[float, float]:
    """Return the ends of a piece, those next to another one moved inwards."""
    gap = min(_INSIDE, 0.25 * (piece.end - piece.start))
    is_first, is_last = piece is curve.pieces[0], piece is curve.pieces[-1]
    return piece.start + (0.0 if is_first else gap), piece.end - (0.0 if is_last else gap)


def _ratios(low: float, high: float, known: list[float]) -> list[float]:
    """Return both ends, ratios between that are known, and more where these are few."""
    between = [ratio for ratio in known if low < ratio < high]
    if len(between) < _POINTS - 2:
        between = [low + (high - low) * number / _POINTS for number in range(1, _POINTS)]
    return [low, *between, high]


def _refined(side: Callable[[float], float], points: FloatArray, bend: float) -> FloatArray:
    """Return points with more between where the line through them bends by too much."""
    for _ in range(_HALVINGS):
        x, y = points.T
        share = (x[1:-1] - x[:-2]) / (x[2:] - x[:-2])
        is_bent = np.abs(y[1:-1] - y[:-2] - share * (y[2:] - y[:-2])) > bend
        split = np.flatnonzero(np.append(is_bent, False) | np.insert(is_bent, 0, False))
        if not len(split):
            break
        ratios = 0.5 * (x[split] + x[split + 1])
        new = [(ratio, side(float(ratio))) for ratio in ratios]
        points = np.insert(points, split + 1, new, axis=0)
    return points
