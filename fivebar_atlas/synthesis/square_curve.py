"""The side of the largest square over the ratio of links: pieces, kinks, largest value.

Le, Kang and Doan (2013), Sec. III and IV: l0 follows from ρ = l2/l1 by Eq. 21, so that the side
is a function of ρ alone (Fig. 5). It has kinks where another constraint becomes the active one.
Those are bracketed here, and the largest value is looked for on every smooth piece.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Sequence

from fivebar_atlas.errors import InputError
from fivebar_atlas.synthesis.largest_square import ACTIVE, CLOSE, Square, SquareTask, largest_square

# Width of the bracket of a kink, halvings at most, and the narrowest piece that is looked for.
_BRACKET, _HALVINGS, _NARROWEST = 1e-10, 60, 1e-6
# Accuracy of a largest value within a piece, in ρ.
_ACCURACY = 1e-9
_MOST_RATIOS, _LARGEST_RATIO = 10_000, 1e6


@dataclasses.dataclass(frozen=True, slots=True)
class Piece:
    """A range of ratios over which the same constraints are active.

    Attributes
    ----------
    start, end
        The range.
    active
        The constraints; none where there is no square.
    """

    start: float
    end: float
    active: tuple[str, ...]


@dataclasses.dataclass(frozen=True)
class SquareCurve:
    """Largest squares for ratios of links.

    Attributes
    ----------
    squares
        One for each ratio, in rising order, without proofs.
    pieces
        Ranges with the same active constraints, in order and without gaps.
    largest
        The largest square over the whole range, proved; None where there is none.
    is_kink
        Whether the largest one is where two pieces meet.
    """

    squares: tuple[Square, ...]
    pieces: tuple[Piece, ...]
    largest: Square | None
    is_kink: bool


def ratios_between(least: float, greatest: float, step: float) -> list[float]:
    """Return ratios from the least to the greatest, this one too.

    Raises
    ------
    InputError
        If the least is below 1, where l0 would be negative, the range is empty or the wrong
        way round, or the step not positive.
    """
    for value in (least, greatest, step):
        if not math.isfinite(value):
            raise InputError("ρ", value, "a finite number")
    if least < 1.0:
        raise InputError("ρ", least, "ratios l2/l1 of at least 1, for l0 = (l2 - l1)/√2")
    if not least < greatest <= _LARGEST_RATIO:
        allowed = f"a least ratio below the greatest, and this at most {_LARGEST_RATIO:g}"
        raise InputError("ρ", (least, greatest), allowed)
    if not step > 0.0:
        raise InputError("step of ρ", step, "a number above 0")
    count = math.floor((greatest - least) / step * (1.0 + 1e-12))
    if count > _MOST_RATIOS:
        raise InputError("step of ρ", step, f"at most {_MOST_RATIOS} ratios")
    ratios = [round(least + step * number, 12) for number in range(count + 1)]
    return ratios if greatest - ratios[-1] < 1e-9 * greatest else [*ratios, greatest]


def square_curve(
    task: SquareTask,
    ratios: Sequence[float],
    progress: Callable[[int, int], None] | None = None,
) -> SquareCurve:
    """Return the largest squares for ratios, where constraints change, and the largest of all.

    Parameters
    ----------
    task
        What is asked of the squares.
    ratios
        At least two ratios ρ, rising; features narrower than a step are not seen.
    progress
        Called with the ratios done and all ratios.
    """

    def at(ratio: float) -> Square:
        return tied_square(task, ratio, is_proved=False)

    squares = []
    for number, ratio in enumerate(ratios, start=1):
        squares.append(at(ratio))
        if progress is not None:
            progress(number, len(ratios))
    pieces = _pieces(at, squares)
    largest, is_kink = _largest(at, squares, pieces)
    if largest is not None:
        # next to a kink the constraints of both sides are met but for rounding
        largest = tied_square(task, largest.ratio, tolerance=CLOSE if is_kink else ACTIVE)
    return SquareCurve(tuple(squares), pieces, largest, is_kink)


def tied_square(
    task: SquareTask, ratio: float, is_proved: bool = True, tolerance: float = ACTIVE
) -> Square:
    """Return the largest square where l0 follows from the ratio of links by Eq. 21."""
    lengths = task.mechanism.optimal_configuration(ratio).lengths
    return largest_square(task, lengths, is_proved, tolerance)


def _pieces(at: Callable[[float], Square], squares: Sequence[Square]) -> tuple[Piece, ...]:
    """Return the ranges with the same active constraints."""
    ends: list[tuple[float, tuple[str, ...]]] = []
    for left, right in itertools.pairwise(squares):
        ends += _changes(at, left, right)
    pieces: list[Piece] = []
    start = squares[0].ratio
    for end, active in [*ends, (squares[-1].ratio, squares[-1].active)]:
        if pieces and pieces[-1].active == active:
            start = pieces.pop().start
        pieces.append(Piece(start, end, active))
        start = end
    return tuple(pieces)


def _changes(
    at: Callable[[float], Square], left: Square, right: Square
) -> list[tuple[float, tuple[str, ...]]]:
    """Return where constraints change between two squares, each with those to its left."""
    if left.active == right.active:
        return []
    lower, upper = left, right
    for _ in range(_HALVINGS):
        if upper.ratio - lower.ratio < _BRACKET:
            break
        middle = at(0.5 * (lower.ratio + upper.ratio))
        active, before, after = (set(each.active) for each in (middle, lower, upper))
        if not active <= before | after and upper.ratio - lower.ratio > _NARROWEST:
            return [*_changes(at, left, middle), *_changes(at, middle, right)]
        # next to a kink constraints of both sides are active but for rounding
        if len(active ^ before) <= len(active ^ after):
            lower = middle
        else:
            upper = middle
    return [(0.5 * (lower.ratio + upper.ratio), left.active)]


def _largest(
    at: Callable[[float], Square], squares: Sequence[Square], pieces: Sequence[Piece]
) -> tuple[Square | None, bool]:
    """Return the largest square of all, and whether it is where two pieces meet."""
    from scipy.optimize import minimize_scalar

    kinks = [at(piece.end) for piece in pieces[:-1]]
    known = sorted([*squares, *kinks], key=lambda square: square.ratio)
    best = max(known, key=lambda square: square.side)
    if best.side == 0.0:
        return None, False
    place = known.index(best)
    is_kink = any(best is kink for kink in kinks)
    for low, high in ((place - 1, place), (place, place + 1)):
        if low < 0 or high >= len(known):
            continue
        found = minimize_scalar(
            lambda ratio: -at(float(ratio)).side,
            bounds=(known[low].ratio, known[high].ratio),
            method="bounded",
            options={"xatol": _ACCURACY},
        )
        square = at(float(found.x))
        if square.side > best.side * (1.0 + 1e-15):
            inner = (
                known[low].ratio + 1e2 * _ACCURACY
                < square.ratio
                < known[high].ratio - (1e2 * _ACCURACY)
            )
            best, is_kink = square, is_kink and not inner
    return best, is_kink
