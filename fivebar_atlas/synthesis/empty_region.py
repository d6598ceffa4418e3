"""Why no design fulfils all conditions, and what comes closest."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import NoDesignError
from fivebar_atlas.synthesis.candidates import Candidates
from fivebar_atlas.synthesis.conditions import Condition
from fivebar_atlas.synthesis.exact_values import has_exact_values
from fivebar_atlas.synthesis.objectives import Objective

FloatArray = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class Reach:
    """The best value that the quantity of a condition reaches.

    Attributes
    ----------
    condition
        The condition.
    alone, alone_design, alone_is_attained
        The best value over the whole design space, and where; not attained where it is next to
        what is no design, and better ones may be closer to it.
    among, among_design, among_is_attained
        The same over the designs that fulfil all other conditions; None where there are
        none, too.
    scale
        The scale of the condition's margin.
    """

    condition: Condition
    alone: float | None
    alone_design: FloatArray | None
    alone_is_attained: bool
    among: float | None
    among_design: FloatArray | None
    among_is_attained: bool
    scale: float

    @property
    def is_met(self) -> bool:
        """Whether a design fulfils the condition together with all others after all.

        Exact values may reach a bound between designs of the lattice that all miss it.
        """
        if self.among is None:
            return False
        margin = self.condition.margin(np.array(self.among))
        return bool(self.condition.is_met(margin, self.scale))


@dataclasses.dataclass(frozen=True, slots=True)
class Conflict:
    """Conditions that no design fulfils.

    Attributes
    ----------
    conditions
        Conditions of which each can be left out to get designs that fulfil the rest.
    reaches
        What the quantity of each condition given reaches, in their order.
    """

    conditions: tuple[Condition, ...]
    reaches: tuple[Reach, ...]

    @property
    def met_designs(self) -> list[FloatArray]:
        """Designs, none of the lattice, that fulfil all conditions after all."""
        return [
            reach.among_design
            for reach in self.reaches
            if reach.is_met and reach.among_design is not None
        ]

    @property
    def is_met(self) -> bool:
        """Whether there are such designs."""
        return bool(self.met_designs)


def explain_emptiness(empty: Candidates) -> Conflict:
    """Return which conditions empty a region and how far each quantity gets.

    Parameters
    ----------
    empty
        Conditions that no design of the lattice or between fulfils.

    Returns
    -------
    Conflict
        The best values are exact where the quantity has values anywhere, and otherwise
        (error estimates) those of the lattice.
    """
    conditions = empty.conditions
    reaches = []
    for place, condition in enumerate(conditions):
        others = conditions[:place] + conditions[place + 1 :]
        alone = _best(empty, condition, ())
        among = _best(empty, condition, others) if others else alone
        reaches.append(Reach(condition, *alone, *among, float(empty.scales[place])))
    return Conflict(_smallest_conflict(empty), tuple(reaches))


def _under(candidates: Candidates, conditions: Sequence[Condition]) -> Candidates:
    return Candidates(candidates.atlas, conditions, candidates.mode, candidates.lci)


def check_not_empty(candidates: Candidates) -> None:
    """Raise NoDesignError where no design of the lattice or between fulfils the conditions."""
    if not candidates.is_empty:
        return
    together = [str(condition) for condition in _smallest_conflict(candidates)]
    if len(together) == 1:
        raise NoDesignError(f"the region is empty: no design has {together[0]}")
    raise NoDesignError(f"the region is empty: {', '.join(together)} exclude each other")


def _smallest_conflict(empty: Candidates) -> tuple[Condition, ...]:
    """Return one or two conditions in conflict; otherwise some of which none can be missed."""
    for size in (1, 2):
        for chosen in itertools.combinations(empty.conditions, size):
            if _under(empty, chosen).is_empty:
                return chosen
    needed = list(empty.conditions)
    for condition in empty.conditions:
        rest = [other for other in needed if other is not condition]
        if _under(empty, rest).is_empty:
            needed = rest
    return tuple(needed)


def _best(
    empty: Candidates, condition: Condition, others: Sequence[Condition]
) -> tuple[float | None, FloatArray | None, bool]:
    """Return the best value of a condition's quantity under others, the design, if attained."""
    candidates = _under(empty, others)
    sign = 1.0 if condition.operator[0] == ">" else -1.0
    objective = Objective((condition.quantity,), (sign,))
    if candidates.is_empty:
        return None, None, True
    if not has_exact_values(empty.atlas, [each.quantity for each in (condition, *others)]):
        best = candidates.best_designs(objective, 1)
        if not len(best):
            return None, None, True
        value = candidates.values(objective.names)[0, best[0]]
        return float(value), candidates.atlas.designs[best[0]], True
    found = candidates.maximise(objective, trials=False)
    if found is None:
        return None, None, True
    design = candidates.uncharted(found.point[np.newaxis])[0]
    return sign * found.value, design, found.is_attained
