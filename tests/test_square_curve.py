"""The side of the largest square over the ratio of links: pieces, kinks and the largest value."""

from __future__ import annotations

import itertools
import math

import naive_square
import numpy as np
import pytest
from naive_square import Wanted, optimal_lengths

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.synthesis.containment import ActuatorRange
from fivebar_atlas.synthesis.largest_square import AXIS, IN_CIRCLE, SquareTask, largest_square
from fivebar_atlas.synthesis.square_curve import (
    SquareCurve,
    ratios_between,
    square_curve,
)
from fivebar_atlas.synthesis.square_curve_lines import curve_lines

FIRST = "+-/up"
LOWER_SIDE, UPPER_CORNERS, LOWER_CORNERS = (
    f"LCI at the {place}" for place in ("lower side", "upper corners", "lower corners")
)


@pytest.fixture(scope="module")
def five_bar() -> Mechanism:
    return mechanisms.get("five-bar")


@pytest.fixture(scope="module")
def task(five_bar: Mechanism) -> SquareTask:
    return SquareTask(five_bar, FIRST)


@pytest.fixture(scope="module")
def curve(task: SquareTask) -> SquareCurve:
    return square_curve(task, ratios_between(1.2, 4.0, 0.05))


def side(ratio: float, lci_threshold: float = 0.5) -> float:
    """Return the side of the oracle."""
    lengths = optimal_lengths(ratio)
    radius, y = naive_square.circle_between_reach_circles(lengths)
    wanted = Wanted(lengths, lci_threshold=lci_threshold)
    return naive_square.largest_side(wanted, y, 1.0, radius * math.sqrt(2.0))


def test_pieces_cover_the_range_and_are_named_by_what_limits_them(curve: SquareCurve) -> None:
    assert [piece.active for piece in curve.pieces] == [
        (LOWER_SIDE,),
        (UPPER_CORNERS,),
        (LOWER_CORNERS,),
    ]
    assert (curve.pieces[0].start, curve.pieces[-1].end) == (1.2, 4.0)
    for before, after in itertools.pairwise(curve.pieces):
        assert before.end == after.start
    kinks = [piece.end for piece in curve.pieces[:-1]]
    assert kinks == pytest.approx([1.5260005739, 1.9655999229], rel=0.0, abs=1e-9)
    for square in curve.squares:
        (piece,) = [each for each in curve.pieces if each.start < square.ratio <= each.end] or [
            curve.pieces[0]
        ]
        assert square.active == piece.active


def test_the_curve_is_continuous_at_kinks_and_its_slope_jumps(curve: SquareCurve) -> None:
    step = 1e-4
    for piece in curve.pieces[:-1]:
        at = side(piece.end)
        left, right = side(piece.end - step), side(piece.end + step)
        # no farther from each other than the steepest slope allows
        assert abs(left - at) < 4.0 * step
        assert abs(right - at) < 4.0 * step
        before, after = (at - left) / step, (right - at) / step
        further = (left - side(piece.end - 2.0 * step)) / step
        # the jump is far above what a smooth curve would do over the same step
        assert abs(after - before) > 20.0 * abs(before - further)


def test_the_largest_value_is_that_of_a_scan(curve: SquareCurve) -> None:
    assert curve.largest is not None
    ratio = curve.largest.ratio
    assert ratio == pytest.approx(1.526000573858619, rel=0.0, abs=1e-9)
    assert curve.largest.side == pytest.approx(1.3322459135, rel=0.0, abs=1e-9)
    assert curve.largest.side == pytest.approx(side(ratio), rel=0.0, abs=1e-9)
    scan = [*np.linspace(1.2, 4.0, 15), *(ratio + np.array([-1e-3, -1e-6, 1e-6, 1e-3]))]
    assert max(side(other) for other in scan) < side(ratio) - 1e-8
    assert curve.is_kink
    assert set(curve.largest.active) == {LOWER_SIDE, UPPER_CORNERS}
    assert curve.largest.side >= max(square.side for square in curve.squares)


def test_a_largest_value_where_a_range_begins_to_limit(five_bar: Mechanism) -> None:
    ranges = (ActuatorRange(1, math.radians(97.0), math.radians(300.0)),)
    found = square_curve(SquareTask(five_bar, FIRST, 0.5, ranges), ratios_between(1.2, 4.0, 0.1))
    assert found.largest is not None

    def at(ratio: float) -> float:
        lengths = optimal_lengths(ratio)
        radius, y = naive_square.circle_between_reach_circles(lengths)
        wanted = Wanted(lengths, ranges={1: (math.radians(97.0), math.radians(300.0))})
        return naive_square.largest_side(wanted, y, 1.0, radius * math.sqrt(2.0))

    best = found.largest.ratio
    assert found.largest.side == pytest.approx(at(best), rel=0.0, abs=1e-9)
    others = [*np.linspace(1.2, 4.0, 5), best - 1e-3, best + 1e-3]
    assert max(at(ratio) for ratio in others) <= found.largest.side + 1e-12


def test_a_largest_value_within_a_piece(five_bar: Mechanism) -> None:
    found = square_curve(SquareTask(five_bar, FIRST, centre=AXIS), [1.6, 1.62, 1.64, 1.66])
    assert found.largest is not None
    assert len(found.pieces) == 1
    assert not found.is_kink
    assert found.largest.ratio == pytest.approx(1.62837, rel=0.0, abs=1e-5)
    ratio, y = found.largest.ratio, found.largest.centre[1]
    ref = naive_square.largest_side(Wanted(optimal_lengths(ratio)), y)
    assert found.largest.side == pytest.approx(ref, rel=0.0, abs=1e-8)
    assert found.largest.side == pytest.approx(1.3518666, rel=0.0, abs=1e-7)


def test_where_there_is_no_square_is_a_piece_of_its_own(five_bar: Mechanism) -> None:
    task = SquareTask(five_bar, "++/up", 0.3)
    found = square_curve(task, ratios_between(1.2, 4.0, 0.4))
    assert [piece.active for piece in found.pieces] == [(), ("LCI at the upper right corner",)]
    start = found.pieces[0].end
    for ratio, exists in ((start - 1e-5, False), (start + 1e-5, True)):
        lengths = optimal_lengths(ratio)
        _, y = naive_square.circle_between_reach_circles(lengths)
        good = Wanted(lengths, (1, 1), 1, 0.3).good(np.zeros(1), np.array([y]))
        assert bool(good[0]) == exists


def test_nowhere_a_square_is_no_largest_one(five_bar: Mechanism) -> None:
    task = SquareTask(five_bar, "++/up", 0.99)
    found = square_curve(task, [1.2, 1.3, 1.4])
    assert found.largest is None
    assert not found.is_kink
    assert [piece.active for piece in found.pieces] == [()]


def test_progress_counts_the_ratios(task: SquareTask) -> None:
    steps: list[tuple[int, int]] = []
    square_curve(task, [2.0, 2.1, 2.2], lambda done, total: steps.append((done, total)))
    assert steps == [(1, 3), (2, 3), (3, 3)]


# --- points along it


def test_lines_hold_their_ends_and_bend_little_between(
    task: SquareTask, curve: SquareCurve
) -> None:
    lines = curve_lines(task, curve)
    assert [line.active for line in lines] == [piece.active for piece in curve.pieces]
    for line, piece in zip(lines, curve.pieces, strict=True):
        ratios, sides = line.points.T
        assert (ratios[0], ratios[-1]) == (piece.start, piece.end)
        assert np.all(np.diff(ratios) > 0.0)
        middle = int(len(ratios) // 2)
        between = 0.5 * (ratios[middle] + ratios[middle + 1])
        chord = 0.5 * (sides[middle] + sides[middle + 1])
        assert chord == pytest.approx(side(between), rel=0.0, abs=2e-3)
        for place in (0, middle, -1):
            assert sides[place] == pytest.approx(side(ratios[place]), rel=0.0, abs=2e-8)
    for before, after in itertools.pairwise(lines):
        assert before.points[-1] == pytest.approx(after.points[0], rel=0.0, abs=2e-8)


def test_lines_of_few_ratios_have_points_between(five_bar: Mechanism) -> None:
    task = SquareTask(five_bar, FIRST, 0.3)
    (line,) = curve_lines(task, square_curve(task, [1.5, 2.5]))
    assert line.active == (IN_CIRCLE,)
    assert len(line.points) >= 8
    np.testing.assert_allclose(line.points[:, 1], math.sqrt(2.0), rtol=1e-12)


def test_a_piece_without_squares_has_zeros(five_bar: Mechanism) -> None:
    task = SquareTask(five_bar, "++/up", 0.3)
    empty, line = curve_lines(task, square_curve(task, ratios_between(1.2, 4.0, 0.4)))
    assert not empty.points[:, 1].any()
    assert (line.points[1:, 1] > 0.0).all()
    assert largest_square(task, optimal_lengths(empty.points[-1, 0] - 1e-6)).side == 0.0


# --- ratios


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ((1.2, 1.5, 0.1), [1.2, 1.3, 1.4, 1.5]),
        ((1.0, 2.0, 0.4), [1.0, 1.4, 1.8, 2.0]),
        ((1.0, 2.0, 5.0), [1.0, 2.0]),
    ],
)
def test_ratios_between_hold_both_ends(
    limits: tuple[float, float, float], expected: list[float]
) -> None:
    assert ratios_between(*limits) == pytest.approx(expected, rel=1e-12)


def test_rounding_adds_no_ratio() -> None:
    ratios = ratios_between(1.2, 4.0, 0.05)
    assert len(ratios) == 57
    assert (ratios[0], ratios[-1]) == (1.2, 4.0)
    assert len(ratios_between(1.0, 2.0, 1e-3)) == 1001


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ((0.9, 2.0, 0.1), "of at least 1"),
        ((2.0, 1.5, 0.1), "below the greatest"),
        ((1.5, 1.5, 0.1), "below the greatest"),
        ((1.5, 2.0, 0.0), "above 0"),
        ((1.5, 2.0, -0.1), "above 0"),
        ((1.5, 2.0, 1e-9), "at most 10000 ratios"),
        ((math.nan, 2.0, 0.1), "finite"),
        ((1.5, math.inf, 0.1), "finite"),
        ((1.5, 2.0, math.nan), "finite"),
    ],
)
def test_wrong_ranges_are_refused(limits: tuple[float, float, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ratios_between(*limits)
