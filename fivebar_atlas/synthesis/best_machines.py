"""Which machine for this practical workspace: the best ones over all designs and mode pairs.

A lattice of designs gives starts, these are polished to local optima, and what is left of
them when equal machines count once is verified: containment is proved, and the goal, margins
and active constraints are those of the machine that was proved.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from fivebar_atlas.errors import InfeasibleSizeError
from fivebar_atlas.synthesis.active_constraints import active_constraints
from fivebar_atlas.synthesis.containment import OUTSIDE, UNDECIDED, GoodCondition, prove
from fivebar_atlas.synthesis.design_polygon import DesignPolygon
from fivebar_atlas.synthesis.least_lci import least_lci
from fivebar_atlas.synthesis.link_limits import length_name
from fivebar_atlas.synthesis.machine_polish import MachinePolish, Polished
from fivebar_atlas.synthesis.machine_search import MachineTask, find_starts
from fivebar_atlas.synthesis.placement import Fit
from fivebar_atlas.synthesis.practical_workspace import PracticalWorkspace
from fivebar_atlas.synthesis.scale_search import PATIENCE, TOUCHING, ScaleSearch
from fivebar_atlas.synthesis.sizing import Machine, parameters_of

# Rounds of polishing for all starts.
_FEW_ROUNDS = 6
# Machines that are polished beyond those asked for.
_SPARE = 2
# Machines whose lengths differ by less than this share of D are one machine.
_SAME = 0.01
# Squares of one size that a proof may take: contacts may lie all along a curve.
_MOST_SQUARES = 4_000_000
# Lattice steps where it only matters whether there is a machine, and halvings of a threshold.
_CLOSER, _HALVINGS = 48, 10
# Threshold that stands for none.
_LOWEST = 0.01
# Margins of LCI and inputs, and of lengths as a share, that count as active.
_ACTIVE = 1e-6


@dataclasses.dataclass(frozen=True)
class RankedMachine:
    """One of the best machines.

    Attributes
    ----------
    machine
        The machine, its containment proved.
    value
        The goal.
    active
        Constraints that hold with equality.
    margins
        What is left to each limit: of the LCI, of inputs in degrees, of lengths.
    """

    machine: Machine
    value: float
    active: tuple[str, ...]
    margins: dict[str, float]

    def document(
        self, resolution: float | None = None, force: float | None = None
    ) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON."""
        return {
            "value": self.value,
            "active": list(self.active),
            "margins": self.margins,
            **self.machine.document(resolution, force),
        }


def best_machines(
    task: MachineTask,
    count: int = 3,
    progress: Callable[[str, int, int], None] | None = None,
) -> list[RankedMachine]:
    """Return the best machines for a practical workspace, distinct from one another.

    Parameters
    ----------
    task
        What is asked, and what is to be smallest.
    count
        How many machines at most.
    progress
        Called with what is counted ("designs", then "starts"), how many are done, and all.

    Returns
    -------
    list of RankedMachine
        The best one first. That it is the best of all is not proved; its containment is.

    Raises
    ------
    InfeasibleSizeError
        If no machine fulfils all constraints; says what comes closest.
    """
    said = progress or (lambda things, done, total: None)  # noqa: ARG005
    starts = find_starts(task, lambda done, total: said("designs", done, total))
    polish = MachinePolish(task)
    placed = [each for each in map(polish.placed, starts) if each is not None]
    if not placed:
        raise InfeasibleSizeError(_why_none(task))
    found = []
    for number, each in enumerate(placed, start=1):
        found.append(polish.polish(each, _FEW_ROUNDS))
        said("starts", number, len(placed))
    # some more than are asked for, since some may turn out to be one, or to be around a hole
    found = _distinct(task, found, count + _SPARE)
    found = _distinct(task, [polish.polish(each) for each in found], count + _SPARE)
    verified = [_verified(task, each) for each in found]
    ranked = [each for each in verified if each is not None]
    if not ranked:
        raise InfeasibleSizeError(_why_none(task))
    return sorted(ranked, key=lambda each: each.value)[:count]


def _distinct(task: MachineTask, found: Sequence[Polished], count: int) -> list[Polished]:
    """Return the best placements whose machines have different lengths."""
    kept: list[Polished] = []
    for each in sorted(found, key=lambda each: each.value):
        lengths = task.lengths(each.parameters, each.scale)
        if len(kept) < count and all(
            np.abs(lengths - task.lengths(other.parameters, other.scale)).max() > _SAME / each.scale
            for other in kept
        ):
            kept.append(each)
    return kept


def _verified(task: MachineTask, placed: Polished) -> RankedMachine | None:
    """Return a machine with the proof of its containment, and what limits it.

    None where a proof finds a point that is not good, in a hole that no sample was in.
    """
    mechanism = task.mechanism
    design = task.design(placed.parameters)
    good = GoodCondition(design, placed.mode, task.lci_threshold, task.ranges)
    # no longer than the limits on lengths allow
    longest = 1.0 / float(task.scales(placed.parameters[None])[0][0])
    scale = placed.scale
    for allowance, _ in PATIENCE:
        factor = min((1.0 + allowance) / scale, longest)
        proof = prove(good, task.shape, placed.centre, 1.0 / factor, _MOST_SQUARES)
        if proof.verdict != UNDECIDED:
            break
    if proof.verdict == OUTSIDE:
        return None
    search = ScaleSearch(good, task.shape, None, scale, [])
    points, values = search.worst(placed.centre, scale)
    centre = float(placed.centre[0]), float(placed.centre[1])
    fit = Fit(factor, allowance, centre, points[values < TOUCHING], proof)
    machine = Machine(
        good=good,
        unit=task.unit,
        factor=factor,
        factor_error=allowance * factor,
        workspace=PracticalWorkspace.of_shape(task.shape, centre, 1.0 / factor),
        shape=task.shape,
        fit=fit,
        parts=len(design.good_condition_workspace(task.lci_threshold, good.mode)),
    )
    margins = _margins(task, machine)
    if margins["LCI"] < -_ACTIVE:
        return None
    polygon = DesignPolygon.of_space(mechanism, task.space)
    borders = [
        name
        for name, gap in zip(
            polygon.names(mechanism, task.space),
            polygon.distances(placed.point[None])[0],
            strict=True,
        )
        if abs(gap) < _ACTIVE
    ]
    inner, inner_values = search.worst_inside(placed.centre, scale)
    active = [
        *active_constraints(good, task.shape, centre, scale, fit.contacts, _ACTIVE),
        *active_constraints(
            good, task.shape, centre, scale, inner[inner_values < _ACTIVE], _ACTIVE, inside=True
        ),
    ]
    limits = [name for name, margin in margins.items() if name[0] == "R" and margin < _ACTIVE]
    return RankedMachine(machine, _value(task, machine), (*active, *limits, *borders), margins)


def _value(task: MachineTask, machine: Machine) -> float:
    """Return the goal of a machine, its extremes over the whole practical workspace."""
    goal, good = task.goal, machine.good
    extremes = np.full(goal.extremes, -math.inf)
    for row, number in enumerate(goal.bounded):
        function = functools.partial(goal.function, row, good.design, good.mode)
        greatest, _ = machine.workspace.greatest(function)
        extremes[number] = max(extremes[number], greatest)
    return goal.value(task.mechanism, parameters_of(good.design), 1.0 / machine.factor, extremes)


def _margins(task: MachineTask, machine: Machine) -> dict[str, float]:
    """Return what is left to each limit."""
    good, fit = machine.good, machine.fit
    assert fit is not None
    least = least_lci(good.design, good.mode, task.shape, fit.position, 1.0 / machine.factor)
    margins = {"LCI": least.value - good.lci_threshold}
    for limit in good.ranges:
        if limit.is_limiting:
            found = machine.input_ranges[limit.number - 1]
            middle = 0.5 * (limit.least + limit.greatest)
            own = 0.5 * (found.least + found.greatest)
            turn = 2.0 * math.pi * round((middle - own) / (2.0 * math.pi))
            name = task.mechanism.input_text(limit.number)
            margins[f"least {name}"] = math.degrees(found.least + turn - limit.least)
            margins[f"greatest {name}"] = math.degrees(limit.greatest - found.greatest - turn)
    for link in task.limits:
        name = length_name(link.name, machine.lengths)
        length = machine.lengths[name]
        if link.least > 0.0:
            margins[f"{name} least"] = length - link.least
        if math.isfinite(link.greatest):
            margins[f"{name} greatest"] = link.greatest - length
    return margins


def _why_none(task: MachineTask) -> str:
    """Return what excludes all machines, and how far each limit alone would have to give."""
    what = f"no machine for the {task.shape.name} {task.unit}"
    relaxed = [
        (
            f"{each.name} from {each.least:g} to {each.greatest:g} {task.unit}",
            dataclasses.replace(
                task, limits=tuple(other for other in task.limits if other is not each)
            ),
        )
        for each in task.limits
    ]
    relaxed += [
        (
            each.text(task.mechanism),
            dataclasses.replace(
                task, ranges=tuple(other for other in task.ranges if other is not each)
            ),
        )
        for each in task.ranges
        if each.is_limiting
    ]
    groups = [
        ("the limits on lengths", dataclasses.replace(task, limits=())),
        ("the actuator ranges", dataclasses.replace(task, ranges=())),
        (
            f"the LCI threshold {task.lci_threshold:g}",
            dataclasses.replace(task, lci_threshold=_LOWEST),
        ),
    ]
    helps = _helps(relaxed) or _helps(groups)
    if not helps:
        return f"{what}: none is found without any one of its limits, either"
    text = f"{what} keeps all limits; one is found {' or '.join(helps)}"
    threshold = _largest_threshold(task)
    if threshold is not None:
        text += f"; with the other limits kept the LCI is at most about {threshold:.3g}"
    return text


def _helps(relaxed: Sequence[tuple[str, MachineTask]]) -> list[str]:
    """Return what can be left out so that there is a machine, and about which one."""
    helps = []
    for name, task in relaxed:
        starts = find_starts(task, resolution=_CLOSER)
        if starts:
            lengths = task.lengths(starts[0].parameters, starts[0].scale)
            about = ", ".join(
                f"{each.name} = {length:.4g}"
                for each, length in zip(task.mechanism.lengths, lengths, strict=True)
            )
            helps.append(f"without {name} (best with about {about} {task.unit})")
    return helps


def _largest_threshold(task: MachineTask) -> float | None:
    """Return about the largest LCI threshold at which there is a machine; None if none."""
    lower, upper = 0.0, task.lci_threshold
    for _ in range(_HALVINGS):
        middle = 0.5 * (lower + upper)
        other = dataclasses.replace(task, lci_threshold=middle)
        if find_starts(other, resolution=_CLOSER):
            lower = middle
        else:
            upper = middle
    return lower or None
