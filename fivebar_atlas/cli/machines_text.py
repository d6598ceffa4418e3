"""The best machines for a practical workspace as text, as sections of a report and as JSON."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from fivebar_atlas.cli.machine_text import MachineText, text_line
from fivebar_atlas.cli.presentation import Captioned, Row, Section, option_rows

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.best_machines import RankedMachine
    from fivebar_atlas.synthesis.machine_search import MachineTask

# Links so many times as long as the practical workspace are worth a word.
_LARGE = 5.0


@dataclasses.dataclass(frozen=True)
class MachinesText:
    """Ranked machines as they are written down.

    Attributes
    ----------
    task
        What was asked.
    machines
        The machines, the best one first; at least one.
    resolution
        Encoder resolution in radians, None where nothing is asked for it.
    force
        Force on the output point in newtons, None where nothing is asked for it.
    """

    task: MachineTask
    machines: list[RankedMachine]
    resolution: float | None = None
    force: float | None = None

    @property
    def title(self) -> str:
        """What the machines are for."""
        return f"Machines for a {self.task.shape.name_in(self.task.unit)}"

    @property
    def summary(self) -> str:
        """The best one in a sentence."""
        best = self.machines[0]
        return (
            f"The smallest {self.task.goal.long_name} is {self._value(best)}, with "
            f"{self._lengths(best)} in the mode pair {best.machine.good.mode}."
        )

    def document(self) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON."""
        task = self.task
        return {
            "mechanism": task.mechanism.name,
            "shape": task.shape.name,
            "clearance": task.shape.clearance,
            "unit": task.unit,
            "lci_threshold": task.lci_threshold,
            "placement": task.placement,
            "modes": list(task.modes),
            "space": task.space,
            **({"options": dict(task.options)} if task.options else {}),
            "minimised": task.goal.name,
            "minimised_unit": task.goal.unit(task.unit),
            "machines": [each.document(self.resolution, self.force) for each in self.machines],
        }

    def lines(self) -> Iterator[str]:
        """Yield the lines of a readable report: all machines, then the best one whole."""
        task = self.task
        yield text_line("practical workspace", self._workspace)
        yield text_line("minimised", f"{task.goal.long_name}")
        yield text_line("searched", self._searched)
        count = len(self.machines)
        yield text_line("found", f"{count} distinct machine{'' if count == 1 else 's'}")
        for number, ranked in enumerate(self.machines, start=1):
            yield ""
            yield f"machine {number}"
            for row in self._rows(ranked):
                yield text_line(row.label, row.value, row.error)
        if note := self._note:
            yield ""
            yield note
        yield ""
        yield "machine 1 in full"
        yield from self._best.lines()

    def sections(self) -> list[Section]:
        """Return choices, the ranking and the best machine as sections of a report."""
        task = self.task
        choices = (
            Row("Mechanism", task.mechanism.title, note=task.mechanism.source),
            Row("Practical workspace", self._workspace),
            Row("LCI threshold", f"{task.lci_threshold:g}", note="reached in the whole workspace"),
            Row("Minimised", task.goal.long_name),
            Row("Searched", self._searched),
            *option_rows(task.mechanism, task.options),
            *(Row("Actuator range", each.text(task.mechanism)) for each in task.ranges),
            *(
                Row(f"Limits of {each.name}", f"{each.least:g} to {each.greatest:g} {task.unit}")
                for each in task.limits
            ),
        )
        ranking = tuple(
            Row(
                f"Machine {number}",
                self._value(ranked),
                note=f"{ranked.machine.good.mode}; {self._lengths(ranked)}; active: "
                + (", ".join(ranked.active) or "none"),
            )
            for number, ranked in enumerate(self.machines, start=1)
        )
        best, *rest = self._best.sections()
        margins = tuple(Row(name, text) for name, text in self._margins(self.machines[0]))
        return [
            Section("Choices", rows=choices),
            Section("Machines", (f"By {task.goal.long_name}, the smallest first.",), ranking),
            Section("The best machine", rows=best.rows),
            *rest,
            Section("Margins of the best machine", rows=margins),
        ]

    def figures(self) -> list[Captioned]:
        """Return the figures of the best machine."""
        return self._best.figures()

    @property
    def _best(self) -> MachineText:
        return MachineText(self.machines[0].machine, self.resolution, self.force)

    @property
    def _workspace(self) -> str:
        """The practical workspace, and what is kept clear around it."""
        shape, unit = self.task.shape, self.task.unit
        clear = f" and {shape.clearance:g} {unit} around it" if shape.clearance else ""
        return f"{shape.name_in(unit)}{clear}"

    @property
    def _note(self) -> str:
        """What to mind of a machine that is much larger than what it is for."""
        longest = max(self.machines[0].machine.lengths.values())
        times = longest / (2.0 * self.task.size)
        if times < _LARGE:
            return ""
        return (
            f"note: the longest link is {times:.0f} times as long as the practical workspace; "
            "--link-range limits lengths"
        )

    @property
    def _searched(self) -> str:
        task = self.task
        every = set(task.modes) == set(task.mechanism.modes)
        modes = "all mode pairs" if every else ", ".join(task.modes)
        where = "on the y axis" if task.placement == "axis" else "anywhere"
        return f"{modes}; {task.space} design space; centre {where}"

    def _rows(self, ranked: RankedMachine) -> Iterator[Row]:
        """Yield what tells one machine from others."""
        machine, unit = ranked.machine, self.task.unit
        yield Row(self.task.goal.long_name, self._value(ranked))
        yield Row("mode pair", machine.good.mode)
        yield Row("dimensional factor D", f"{machine.factor:.10g} {unit}")
        for name, length in machine.lengths.items():
            yield Row(name, f"{length:.10g} {unit}")
        position = machine.position
        if position is not None:
            x, y = (0.0 if abs(part) < 1e-7 * machine.factor else part for part in position)
            yield Row("centre", f"({x:.8g}, {y:.8g}) {unit}")
        yield Row("active", ", ".join(ranked.active) or "none")
        for name, text in self._margins(ranked):
            yield Row(f"margin of {name}", text)
        fit = machine.fit
        if fit is not None:
            shown = f"proved with {fit.proof.squares} squares"
            yield Row("containment", shown if fit.proof.verdict == "inside" else "not proved")

    def _margins(self, ranked: RankedMachine) -> Iterator[tuple[str, str]]:
        """Yield what is left to each limit, with its unit."""
        mechanism = self.task.mechanism
        inputs = [mechanism.input_text(each.number) for each in self.task.ranges]
        for name, margin in ranked.margins.items():
            is_angle = name.rpartition(" ")[2] in inputs
            unit = "" if name == "LCI" else " deg" if is_angle else f" {self.task.unit}"
            yield name, f"{margin:.4g}{unit}"

    def _lengths(self, ranked: RankedMachine) -> str:
        return ", ".join(
            f"{name} = {length:.6g} {self.task.unit}"
            for name, length in ranked.machine.lengths.items()
        )

    def _value(self, ranked: RankedMachine) -> str:
        return f"{ranked.value:.10g} {self.task.goal.unit(self.task.unit)}"
