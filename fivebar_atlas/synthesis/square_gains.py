"""How much larger a square is when what Le, Kang and Doan (2013) fix is let free.

Their square is centred in the maximal inscribed circle, l0 follows from the ratio of links by
Eq. 21, and the mode pair is "+-"/up. Here each of these is free alone, and all of them together,
and the square may be a rectangle, which then counts as the square of its area. Sides are in
lengths of the actuated link. A largest square with a free centre is the smallest machine, by its
actuated link, for a given square: :mod:`machine_polish` finds it.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence

import numpy as np

from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.synthesis.containment import GoodCondition
from fivebar_atlas.synthesis.largest_square import (
    AXIS,
    HALVES,
    MIC,
    Square,
    SquareTask,
    largest_square,
    square_at,
)
from fivebar_atlas.synthesis.machine_goals import ActuatedLink
from fivebar_atlas.synthesis.machine_polish import DesignLine, MachinePolish, Polished
from fivebar_atlas.synthesis.machine_search import MachineTask, Start, find_starts
from fivebar_atlas.synthesis.square_curve import SquareCurve, tied_square

#: Number of cases.
CASES = 6
# Ratios of links, and of l0 to l2, of a coarse search with l0 free; accuracy of a search for one
# number, and of that for another number around it.
_RATIOS, _BASES, _ACCURACY, _OUTER_ACCURACY = 14, 13, 1e-8, 1e-6
# Logarithm of the largest ratio of sides of a rectangle, and number of aspects tried.
_ASPECT, _ASPECTS = math.log(3.0), 9
# Best starts on a curve.
_CURVE_STARTS = 4


@dataclasses.dataclass(frozen=True, slots=True)
class Gain:
    """The largest square with something let free.

    Attributes
    ----------
    name
        What is free.
    square
        The square.
    gain
        By which share its side is larger than that of the paper's problem.
    """

    name: str
    square: Square
    gain: float


def square_gains(
    task: SquareTask, curve: SquareCurve, progress: Callable[[int, int], None] | None = None
) -> list[Gain]:
    """Return what is gained where centre, l0, aspect and mode pair are free, and some together.

    Parameters
    ----------
    task
        The problem that gains are measured from: centred in the inscribed circle.
    curve
        Its squares over the ratio of links, with the largest one.
    progress
        Called with the number of cases done and of all.

    Returns
    -------
    list of Gain
        None where the problem itself has no square.
    """
    first = curve.largest
    if first is None:
        return []
    cases: tuple[tuple[str, Callable[[], Square | None]], ...] = (
        ("centre free on the y axis", lambda: _free_centre(task, curve, (task.mode,))),
        ("l0 free", lambda: _free_base(task)),
        ("aspect free", lambda: _free_aspect(task, curve)),
        ("l0 free and centre free", lambda: _all_free(task, (task.mode,))),
        ("every mode pair", lambda: _every_mode(task, curve)),
        ("l0, centre and mode pair free", lambda: _all_free(task, task.mechanism.modes)),
    )
    assert len(cases) == CASES
    gains = []
    for number, (name, search) in enumerate(cases, start=1):
        square = search()
        # what is free may stay as it was
        best = first if square is None or square.side < first.side else square
        gains.append(Gain(name, best, best.side / first.side - 1.0))
        if progress is not None:
            progress(number, len(cases))
    return gains


def tied_line(mechanism: Mechanism, space: str) -> DesignLine:
    """Return the line of the chart on which l0 follows from the ratio by Eq. 21."""
    ends = [
        mechanism.from_lengths(mechanism.optimal_configuration(ratio).lengths)[0]
        for ratio in (1.0, 3.0)
    ]
    one, other = mechanism.project(np.array(ends), space)
    return DesignLine.through(one, other)


def _machine_task(task: SquareTask, modes: Sequence[str]) -> MachineTask:
    """Return the search for the machine with the shortest actuated link for the shape."""
    return MachineTask(
        mechanism=task.mechanism,
        shape=task.shape,
        goal=ActuatedLink(),
        modes=tuple(modes),
        lci_threshold=task.lci_threshold,
        ranges=task.ranges,
        unit="",
    )


def _free_centre(task: SquareTask, curve: SquareCurve, modes: Sequence[str]) -> Square | None:
    """Return the largest square with its centre free and l0 tied."""
    search = _machine_task(task, modes)
    polish = MachinePolish(search, tied_line(task.mechanism, search.space))
    best = sorted(curve.squares, key=lambda square: -square.side)[:_CURVE_STARTS]
    starts = [_start(task, square) for square in best if square.side > 0.0]
    return _polished(task, polish, starts)


def _all_free(task: SquareTask, modes: Sequence[str]) -> Square | None:
    """Return the largest square with centre, l0 and one of some mode pairs free."""
    search = _machine_task(task, modes)
    return _polished(task, MachinePolish(search), find_starts(search))


def _polished(task: SquareTask, polish: MachinePolish, starts: Sequence[Start]) -> Square | None:
    """Return the best square that starts lead to."""
    placed = [each for each in map(polish.placed, starts) if each is not None]
    found = [polish.polish(each) for each in placed]
    best = min(found, key=lambda each: each.value, default=None)
    return None if best is None else _square(task, best)


def _start(task: SquareTask, square: Square) -> Start:
    """Return a square as a placement to start from."""
    parameters, factor = task.mechanism.from_lengths(square.lengths)
    centre = np.array(square.centre) / factor
    return Start(task.mode, parameters, centre, square.side / factor, 1.0 / square.side)


def _square(task: SquareTask, placed: Polished) -> Square:
    """Return a placement of the shape, whose area is 1, as a square with its proof."""
    lengths = tuple(float(each) for each in placed.parameters / placed.parameters[0])
    free = dataclasses.replace(task, mode=placed.mode, centre=AXIS)
    design = task.mechanism.design_of(placed.parameters)
    good = GoodCondition(design, placed.mode, task.lci_threshold, task.ranges)
    factor = 1.0 / float(placed.parameters[0])
    return square_at(free, lengths, good, factor, placed.centre, placed.scale)


def _every_mode(task: SquareTask, curve: SquareCurve) -> Square | None:
    """Return the largest square of any mode pair and half, centred in its inscribed circle."""
    ratios = [square.ratio for square in curve.squares]
    best: tuple[float, SquareTask, float] | None = None
    for mode in task.mechanism.modes:
        for half in HALVES:
            other = dataclasses.replace(task, mode=mode, half=half, centre=MIC)
            side = functools.partial(_tied_side, other)
            ratio, value = _best_between(side, ratios)
            if value > 0.0 and (best is None or value > best[2] * (1.0 + _ACCURACY)):
                best = ratio, other, value
    return None if best is None else tied_square(best[1], best[0])


def _tied_side(task: SquareTask, ratio: float) -> float:
    return tied_square(task, ratio, is_proved=False).side


def _free_base(task: SquareTask) -> Square | None:
    """Return the largest square with l0 free, centred in the inscribed circle.

    The side has kinks in both variables: for each share of l0 the best ratio, and the share
    at which that is best.
    """
    ratios = [float(each) for each in np.linspace(0.6, 4.0, _RATIOS)]

    def best_ratio(share: float) -> tuple[float, float]:
        def side(ratio: float) -> float:
            lengths = (1.0, ratio, share * ratio)
            return largest_square(task, lengths, is_proved=False).side

        return _best_between(side, ratios)

    shares = [float(each) for each in np.linspace(0.0, 0.9, _BASES)]
    share, value = _best_between(lambda share: best_ratio(share)[1], shares, _OUTER_ACCURACY)
    if value == 0.0:
        return None
    ratio, _ = best_ratio(share)
    return largest_square(task, (1.0, ratio, share * ratio))


def _free_aspect(task: SquareTask, curve: SquareCurve) -> Square | None:
    """Return the largest rectangle of any aspect, by its area, with l0 tied."""
    ratios = [square.ratio for square in curve.squares]
    ratios = [*ratios[:: max(len(ratios) // _RATIOS, 1)], ratios[-1]]

    def best_ratio(aspect: float) -> tuple[float, float]:
        other = dataclasses.replace(task, aspect=math.exp(aspect))
        return _best_between(functools.partial(_tied_side, other), ratios)

    aspects = [float(each) for each in np.linspace(-_ASPECT, _ASPECT, _ASPECTS)]
    aspect, value = _best_between(lambda aspect: best_ratio(aspect)[1], aspects, _OUTER_ACCURACY)
    if value == 0.0:
        return None
    ratio, _ = best_ratio(aspect)
    return tied_square(dataclasses.replace(task, aspect=math.exp(aspect)), ratio)


def _best_between(
    function: Callable[[float], float], places: Sequence[float], accuracy: float = _ACCURACY
) -> tuple[float, float]:
    """Return where a function is largest next to its largest sample, and the value there."""
    from scipy.optimize import minimize_scalar

    values = [function(place) for place in places]
    top = max(range(len(values)), key=lambda k: values[k])
    if values[top] == 0.0:
        return places[top], 0.0
    found = minimize_scalar(
        lambda place: -function(float(place)),
        bounds=(places[max(top - 1, 0)], places[min(top + 1, len(places) - 1)]),
        method="bounded",
        options={"xatol": accuracy},
    )
    if -found.fun > values[top]:
        return float(found.x), float(-found.fun)
    return places[top], values[top]
