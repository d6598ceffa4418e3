"""The largest square of one machine, against rays followed in NumPy, and where there is none."""

from __future__ import annotations

import math

import naive
import naive_square
import numpy as np
import pytest
from naive_square import Wanted, optimal_lengths

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InfeasibleSizeError, InputError, UnknownNameError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.synthesis.containment import INSIDE, ActuatorRange
from fivebar_atlas.synthesis.largest_square import (
    AXIS,
    HALVES,
    IN_CIRCLE,
    LOWER,
    Square,
    SquareTask,
    check_ranges_allow,
    largest_square,
    why_none,
)

FIRST = "+-/up"
FIRST_KINK, SECOND_KINK = 1.526000573858619, 1.9655999229
RATIOS = (1.2, 1.5, FIRST_KINK, 1.6, 1.9721, 3.0, 4.0)
#: Limits of Le, Kang and Doan, and others that keep the square small.
WIDE = {1: (-math.pi / 3, 4 * math.pi / 3), 2: (-math.pi / 3, 4 * math.pi / 3)}
NARROW = {1: (-math.pi / 3, math.radians(170)), 2: (math.radians(20), 4 * math.pi / 3)}

Ranges = dict[int, tuple[float, float]]


@pytest.fixture(scope="module")
def five_bar() -> Mechanism:
    return mechanisms.get("five-bar")


def actuator_ranges(ranges: Ranges) -> tuple[ActuatorRange, ...]:
    return tuple(ActuatorRange(number, *ends) for number, ends in ranges.items())


def wanted(square: Square) -> Wanted:
    """Return what was asked of a square, for the oracle."""
    task = square.task
    working, assembly = task.mode.split("/")
    one, two = (1 if sign == "+" else -1 for sign in working)
    return Wanted(
        square.lengths,
        (one, two),
        1 if assembly == "up" else -1,
        task.lci_threshold,
        {each.number: (each.least, each.greatest) for each in task.ranges},
    )


def corner_distance(aspect: float) -> float:
    """Return how far corners are from the centre of a rectangle of the area 1."""
    return 0.5 * math.hypot(math.sqrt(aspect), 1.0 / math.sqrt(aspect))


# --- the side


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(
    ("ranges", "aspect"), [({}, 1.0), (WIDE, 1.0), (NARROW, 1.0), ({}, 2.0), (NARROW, 2.0)]
)
def test_side_is_that_of_rays_followed_from_the_centre(
    five_bar: Mechanism, ratio: float, ranges: Ranges, aspect: float
) -> None:
    lengths = optimal_lengths(ratio)
    radius, y = naive_square.circle_between_reach_circles(lengths)
    limit = radius / corner_distance(aspect)
    ref = naive_square.largest_side(Wanted(lengths, ranges=ranges), y, aspect, limit)

    task = SquareTask(five_bar, FIRST, ranges=actuator_ranges(ranges), aspect=aspect)
    comp = largest_square(task, lengths)

    assert comp.side == pytest.approx(ref, rel=0.0, abs=1e-9)
    assert comp.circle is not None
    assert comp.circle.radius == pytest.approx(radius, rel=0.0, abs=1e-12)
    assert comp.centre == pytest.approx((0.0, y), rel=0.0, abs=1e-12)
    assert (comp.width / comp.height, comp.ratio) == pytest.approx((aspect, ratio))
    assert comp.width * comp.height == pytest.approx(comp.side**2)
    assert comp.proof is not None
    assert comp.proof.verdict == INSIDE
    if ranges is NARROW:
        assert comp.active == ("least θ2 at the lower right corner",)


@pytest.mark.parametrize(
    ("ratio", "side", "active"),
    [
        (1.6, 1.3293069197, {"LCI at the upper corners"}),
        # printed as the largest one, 1.3142
        (1.9721, 1.3126667364, {"LCI at the lower corners"}),
        (FIRST_KINK, 1.3322459135, {"LCI at the upper corners", "LCI at the lower side"}),
    ],
)
def test_known_sides(five_bar: Mechanism, ratio: float, side: float, active: set[str]) -> None:
    square = largest_square(SquareTask(five_bar, FIRST), optimal_lengths(ratio))
    assert square.side == pytest.approx(side, rel=0.0, abs=1e-10)
    assert set(square.active) == active


@pytest.mark.parametrize("mode", ["+-/up", "+-/down", "-+/up", "++/up", "--/up", "++/down"])
@pytest.mark.parametrize(("ratio", "half"), [(1.2, "lower"), (2.5, "upper"), (2.5, "lower")])
def test_other_modes_and_halves(five_bar: Mechanism, mode: str, ratio: float, half: str) -> None:
    task = SquareTask(five_bar, mode, 0.3, half=half)
    square = largest_square(task, optimal_lengths(ratio))
    if square.circle is None:
        assert square.side == 0.0
        return
    ask = wanted(square)
    radius = naive_square.reach_of_circle(ask, square.centre[1])
    ref = naive_square.largest_side(ask, square.centre[1], 1.0, radius * math.sqrt(2.0))

    assert (square.centre[1] > 0.0) == (half == "upper")
    assert square.circle.radius == pytest.approx(radius, rel=0.0, abs=1e-9)
    assert square.side == pytest.approx(ref, rel=0.0, abs=1e-9)
    others = [
        naive_square.reach_of_circle(ask, y) for y in square.centre[1] + np.array([-1e-4, 1e-4])
    ]
    assert max(others) < radius


def test_the_inscribed_circle_is_the_largest_on_a_grid(five_bar: Mechanism) -> None:
    lengths = optimal_lengths(1.6)
    n = 401
    mask = naive.usable_workspace_mask(*lengths, 1, -1, 1, n)
    x, y = naive.grid(*lengths, n)
    for half, sign in zip(HALVES, (1, -1), strict=True):
        radius, centre = naive.maximal_inscribed_circle(x, y, mask, sign)
        circle = largest_square(SquareTask(five_bar, FIRST, half=half), lengths).circle
        assert circle is not None
        assert (circle.radius, circle.centre[1]) == pytest.approx((radius, centre), abs=0.02)


def test_random_machines(five_bar: Mechanism) -> None:
    rng = np.random.default_rng(20131125)
    count = 0
    while count < 12:
        ranges = {}
        for number in (1, 2):
            least = rng.uniform(-np.pi, np.pi)
            if rng.random() < 0.4:
                ranges[number] = (least, least + rng.uniform(1.0, 6.2))
        task = SquareTask(
            five_bar,
            five_bar.modes[rng.integers(len(five_bar.modes))],
            rng.uniform(0.1, 0.7),
            actuator_ranges(ranges),
            float(np.exp(rng.uniform(-1.0, 1.0))),
            half=HALVES[rng.integers(2)],
        )
        lengths = (1.0, float(rng.uniform(0.6, 2.5)), float(rng.uniform(0.0, 0.75)))
        square = largest_square(task, lengths)
        if square.circle is None:
            continue
        count += 1
        ask = wanted(square)
        radius = naive_square.reach_of_circle(ask, square.centre[1])
        limit = square.circle.radius / corner_distance(task.aspect)
        ref = naive_square.largest_side(ask, square.centre[1], task.aspect, limit)
        assert square.circle.radius == pytest.approx(radius, rel=0.0, abs=1e-8), square
        assert square.side == pytest.approx(ref, rel=0.0, abs=1e-9), square
        assert bool(square.active) == (square.side > 0.0)


def test_mirrored_modes_have_mirrored_squares(five_bar: Mechanism) -> None:
    lengths = optimal_lengths(2.5)
    squares = {
        mode: largest_square(SquareTask(five_bar, mode, 0.3, half=half), lengths)
        for mode, half in (("++/up", "upper"), ("--/up", "upper"), ("++/down", "lower"))
    }
    sides = [square.side for square in squares.values()]
    np.testing.assert_allclose(sides, sides[0], rtol=1e-12)
    assert squares["++/up"].active == ("LCI at the upper right corner",)
    assert squares["--/up"].active == ("LCI at the upper left corner",)
    assert squares["++/down"].active == ("LCI at the lower left corner",)


def test_a_square_that_only_the_circle_limits(five_bar: Mechanism) -> None:
    square = largest_square(SquareTask(five_bar, FIRST, 0.3), optimal_lengths(1.6))
    assert square.active == (IN_CIRCLE,)
    # l1 is the radius for every ratio
    assert square.side == pytest.approx(math.sqrt(2.0), rel=1e-12)
    assert square.contacts == ()


def test_contacts_are_on_the_boundary_and_at_the_limit(five_bar: Mechanism) -> None:
    rng = np.random.default_rng(5)
    for ratio in RATIOS:
        lengths = optimal_lengths(ratio)
        square = largest_square(SquareTask(five_bar, FIRST), lengths)
        contacts = np.array(square.contacts)
        offset = np.abs(contacts - square.centre).max(axis=1)
        np.testing.assert_allclose(offset, 0.5 * square.side, rtol=1e-9)
        index = naive.lci(*lengths, *contacts.T, 1, -1)
        # that of the lower side is near the kink only
        assert index.min() == pytest.approx(0.5, abs=1e-9)
        inside = square.centre + (rng.random((2000, 2)) - 0.5) * square.side
        assert naive.lci(*lengths, *inside.T, 1, -1).min() >= 0.5


def test_the_best_centre_on_the_axis(five_bar: Mechanism) -> None:
    lengths = optimal_lengths(1.62837)
    square = largest_square(SquareTask(five_bar, FIRST, centre=AXIS), lengths)
    y = square.centre[1]

    def side(centre: float) -> float:
        return naive_square.largest_side(Wanted(lengths), centre)

    assert square.side == pytest.approx(side(y), rel=0.0, abs=1e-8)
    assert square.side == pytest.approx(1.3518666, rel=0.0, abs=1e-7)
    others = [*np.linspace(0.8, 2.2, 8), *(y + np.array([-1e-3, -1e-6, 1e-6, 1e-3]))]
    assert max(side(other) for other in others) < square.side
    assert square.side > largest_square(SquareTask(five_bar, FIRST), lengths).side


# --- where there is none


def test_why_there_is_no_square_for_the_lci(five_bar: Mechanism) -> None:
    lengths = optimal_lengths(1.6)
    _, y = naive_square.circle_between_reach_circles(lengths)
    lci = float(naive.lci(*lengths, 0.0, y, 1, -1))
    task = SquareTask(five_bar, FIRST, 0.9)
    square = largest_square(task, lengths)
    assert (square.side, square.active, square.contacts, square.proof) == (0.0, (), (), None)
    assert lci < 0.9
    assert why_none(square) == (
        f"no square: its centre (0, {y:.6g}) is not allowed, for the LCI is {lci:.6g} there "
        "and 0.9 is asked for"
    )


def test_why_there_is_no_square_for_ranges(five_bar: Mechanism) -> None:
    lengths = optimal_lengths(1.6)
    _, y = naive_square.circle_between_reach_circles(lengths)
    angle = math.degrees(float(naive.inverse_kinematics(*lengths, 0.0, y, 1, -1)[0]))
    task = SquareTask(five_bar, FIRST, ranges=(ActuatorRange(1, 0.0, 1.0),), aspect=0.5)
    square = largest_square(task, lengths)
    assert square.side == 0.0
    reason = why_none(square)
    assert reason.startswith("no rectangle: its centre")
    gap = angle - math.degrees(1.0)
    assert f"θ1 is {angle:.6g} deg there, {gap:.4g} deg outside of θ1 from 0 to" in reason


def test_why_there_is_no_circle_and_no_good_point(five_bar: Mechanism) -> None:
    square = largest_square(SquareTask(five_bar, "++/up"), (1.0, 1.0, 0.0))
    assert why_none(square).endswith("++/up has no inscribed circle centred on the upper half axis")
    assert math.isnan(square.centre[0])
    task = SquareTask(five_bar, "++/up", 0.99, centre=AXIS, half=LOWER)
    square = largest_square(task, optimal_lengths(1.2))
    assert square.side == 0.0
    assert why_none(square) == "no square: no point of the lower half axis is good in ++/up"


def test_ranges_that_exclude_the_optimal_configuration(five_bar: Mechanism) -> None:
    check_ranges_allow(SquareTask(five_bar, FIRST, ranges=actuator_ranges(WIDE)), 1.6)
    # 135 and 45 degrees, whatever the ratio
    allowed = {1: (math.radians(134), math.radians(136)), 2: (0.0, 2.0 * math.pi)}
    check_ranges_allow(SquareTask(five_bar, FIRST, ranges=actuator_ranges(allowed)), 3.0)
    task = SquareTask(five_bar, FIRST, ranges=(ActuatorRange(2, 1.0, 2.0),))
    with pytest.raises(InfeasibleSizeError, match="θ2 = 45 deg and θ2 from 57"):
        check_ranges_allow(task, 1.6)


# --- wrong input


@pytest.mark.parametrize("threshold", [0.0, 1.0, -0.1, math.nan])
def test_a_threshold_out_of_range_is_refused(five_bar: Mechanism, threshold: float) -> None:
    with pytest.raises(InputError, match="above 0 and below 1"):
        SquareTask(five_bar, FIRST, threshold)


@pytest.mark.parametrize("aspect", [0.0, -1.0, math.inf, math.nan])
def test_an_aspect_that_is_none_is_refused(five_bar: Mechanism, aspect: float) -> None:
    with pytest.raises(InputError, match="ratio of width to height above 0"):
        SquareTask(five_bar, FIRST, aspect=aspect)


@pytest.mark.parametrize(
    "choice", [{"mode": "+-"}, {"mode": FIRST, "centre": "y"}, {"mode": FIRST, "half": "left"}]
)
def test_unknown_names_are_refused(five_bar: Mechanism, choice: dict[str, str]) -> None:
    with pytest.raises(UnknownNameError, match="one of"):
        SquareTask(five_bar, **choice)


@pytest.mark.parametrize(
    ("numbers", "message"), [((3,), "an actuator from 1 to 2"), ((1, 1), "one range for each")]
)
def test_ranges_of_no_actuator_are_refused(
    five_bar: Mechanism, numbers: tuple[int, ...], message: str
) -> None:
    ranges = tuple(ActuatorRange(number, 0.0, 3.0) for number in numbers)
    with pytest.raises(InputError, match=message):
        SquareTask(five_bar, FIRST, ranges=ranges)


def test_lengths_that_make_no_machine_are_refused(five_bar: Mechanism) -> None:
    with pytest.raises(InputError):
        largest_square(SquareTask(five_bar, FIRST), (1.0, 1.0, 2.5))
