"""One evaluated design as text: the table of a terminal and the sections of a report."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from fivebar_atlas.cli.design_figures import lci_map, linkage, workspace
from fivebar_atlas.cli.presentation import (
    Captioned,
    Row,
    Section,
    Table,
    capitalised,
    option_rows,
    raised,
)
from fivebar_atlas.errors import InputError

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.arrays import FloatArray
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.mechanisms.quantities import Axis, Quantity, Results
    from fivebar_atlas.mechanisms.settings import SweepSettings

# Wide enough for every name, and the whole line for a terminal of 80 columns.
_LABEL_WIDTH = 40
# What scales with a power of D.
_POWERS = {1: "lengths", 2: "areas", 3: "volumes"}
# Mode pairs that a report draws: each takes two figures.
_DRAWN = 4


@dataclasses.dataclass(frozen=True, slots=True)
class _Entry:
    """One value: its name, what it is, and the same times the power of D that is its unit."""

    label: str
    meaning: str
    value: str
    error: str = ""
    scaled: str = ""
    unit: str = ""
    is_word: bool = False

    @property
    def line(self) -> str:
        """The line of the table."""
        if self.is_word:
            return f"{self.label:{_LABEL_WIDTH}}  {self.value}"
        return _line(self.label, self.value, self.error, self.scaled)

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """The row of a report."""
        value = self.value.replace("_", " ") if self.is_word else self.value
        return capitalised(self.meaning), value, self.error, self.scaled


@dataclasses.dataclass(frozen=True, slots=True)
class EvaluationText:
    """One design and its values, as they are written down.

    Attributes
    ----------
    mechanism
        The mechanism.
    lengths
        The design as it was given.
    parameters, factor
        The non-dimensional design, and the dimensional factor D.
    settings
        Mode pairs, thresholds and tolerance.
    results
        What was computed.
    """

    mechanism: Mechanism
    lengths: list[float]
    parameters: FloatArray
    factor: float
    settings: SweepSettings
    results: Results

    @property
    def title(self) -> str:
        """What was evaluated."""
        mechanism = self.mechanism
        named = mechanism.proportions if self.factor == 1.0 else mechanism.lengths
        pairs = zip(named, self.lengths, strict=True)
        return "Design " + ", ".join(f"{each.name} = {length:.8g}" for each, length in pairs)

    @property
    def summary(self) -> str:
        """The first values of the first mode pair, or of the design, in a sentence."""
        modes = self._modes
        found = self._of_mode(0) if modes else self._without_mode()
        entries = [entry for entry in found if not entry.is_word]
        if not entries:
            return f"{self.mechanism.title}."
        values = " and ".join(
            " ".join(filter(None, (entry.meaning, entry.value, entry.error, entry.unit)))
            for entry in entries[:2]
        )
        factor = "" if self.factor == 1.0 else f", with D = {self.factor:.8g}"
        mode = f" in the {self.mechanism.mode_phrase} {modes[0]}" if modes else ""
        return f"{self.mechanism.title}{mode}: {values}{factor}."

    def lines(self) -> Iterator[str]:
        """Yield the lines of a readable table."""
        yield self.mechanism.title
        if options := self.mechanism.options_text(self.settings.options):
            yield options
        yield ""
        yield _line("", "value", "± error", "" if self.factor == 1.0 else "scaled by D")
        for entry in self._of_design():
            yield entry.line
        for number, label in enumerate(self._modes):
            yield ""
            yield label
            for entry in self._of_mode(number):
                yield entry.line

    def sections(self) -> list[Section]:
        """Return choices, design and every mode pair as sections of a report."""
        settings, phrase = self.settings, capitalised(self.mechanism.mode_phrase)
        of_what = f"of good-condition {self.mechanism.usable_phrase}s"
        thresholds = ", ".join(f"{value:g}" for value in settings.lci_thresholds)
        drawn = f"figures of the first {_DRAWN}" if len(self._modes) > _DRAWN else ""
        choices = (
            Row("Mechanism", self.mechanism.title, note=self.mechanism.source),
            *([Row(f"{phrase}s", ", ".join(settings.modes), note=drawn)] if self._modes else []),
            Row("LCI thresholds", thresholds, note=of_what),
            Row("Relative tolerance", f"{settings.tolerance:g}", note="of what is integrated"),
            *option_rows(self.mechanism, settings.options),
        )
        scaled = self.mechanism.design_phrase
        sentence = f"Values are those of the design scaled to {scaled}; what" if scaled else "What"
        sentence += " is integrated has an absolute error estimate."
        if self.factor != 1.0:
            powers = {each.length_power for each in self.mechanism.quantities}
            scaled = ", ".join(
                f"{_POWERS.get(power, 'what is in that power')} times {raised('D', power)}"
                for power in sorted({1, *powers} - {0})
            )
            sentence += f" The last column has {scaled}."
        return [
            Section("Choices", rows=choices),
            Section("Design", (sentence,), tables=(self._table(self._of_design()),)),
            *(
                Section(f"{phrase} {label}", tables=(self._table(self._of_mode(number)),))
                for number, label in enumerate(self._modes)
            ),
        ]

    def figures(self) -> list[Captioned]:
        """Return workspace and LCI map of mode pairs, and the linkage in the first of them."""
        try:
            design = self.mechanism.planar_design(self.lengths, options=self.settings.options)
        except InputError:  # its output does not move in a plane
            return []
        figures = []
        for mode in self._modes[:_DRAWN]:
            figures.append(workspace(design, mode))
            if design.usable_workspace(mode) is not None:
                figures.append(lci_map(design, mode))
        for mode in self._modes:
            if design.usable_workspace(mode) is not None:
                return [*figures, linkage(design, mode)]
        return figures

    @property
    def _modes(self) -> tuple[str, ...]:
        from fivebar_atlas.mechanisms.quantities import MODE

        return self._axes[MODE].labels if MODE in self._axes else ()

    @property
    def _axes(self) -> dict[str, Axis]:
        return {axis.name: axis for axis in self.mechanism.axes(self.settings)}

    def _of_design(self) -> Iterator[_Entry]:
        """Yield D, the lengths, and the quantities that do not depend on the mode pair."""
        yield _Entry("dimensional factor D", "dimensional factor D", f"{self.factor:.8g}")
        (proportions,) = self.mechanism.proportions_of(self.parameters[None])
        for each, value in zip(self.mechanism.proportions, proportions, strict=True):
            length = "" if self.factor == 1.0 else f"{self.factor * value:.8g}"
            yield _Entry(each.name, f"{each.long_name} {each.name}", f"{value:.8g}", "", length)
        yield from self._without_mode()

    def _without_mode(self) -> Iterator[_Entry]:
        """Yield the quantities that do not depend on the mode pair."""
        from fivebar_atlas.mechanisms.quantities import MODE

        for quantity in self.mechanism.quantities:
            if MODE not in quantity.dimensions:
                yield from self._entries(quantity, {})

    def _of_mode(self, number: int) -> Iterator[_Entry]:
        """Yield the quantities of a mode pair."""
        from fivebar_atlas.mechanisms.quantities import MODE

        for quantity in self.mechanism.quantities:
            if MODE in quantity.dimensions:
                yield from self._entries(quantity, {MODE: number})

    def _entries(self, quantity: Quantity, places: Mapping[str, int]) -> Iterator[_Entry]:
        """Yield an entry for each one of the axes of a quantity that have no place yet."""
        axes, factor = self._axes, self.factor
        free = [axes[name] for name in quantity.dimensions[1:] if name not in places]
        for numbers in itertools.product(*(range(len(axis)) for axis in free)):
            chosen = dict(zip((axis.name for axis in free), numbers, strict=True))
            index = (0, *({**places, **chosen}[name] for name in quantity.dimensions[1:]))
            labels = {axis.name: axis.labels[chosen[axis.name]] for axis in free}
            label = quantity.name + "".join(f" at {text}" for text in labels.values())
            meaning = quantity.long_name + "".join(
                f" at {name} {text}" for name, text in labels.items()
            )
            value = self.results[quantity.name][index]
            if quantity.flags is not None:
                word = quantity.flags.describe(int(value))
                yield _Entry(label, meaning, word, is_word=True)
                continue
            if not math.isfinite(value):
                yield _Entry(label, meaning, "none")
                continue
            error, scaled, unit = "", "", ""
            if quantity.has_error:
                error = f"± {self.results[quantity.error_name][index]:.1e}"
            if quantity.length_power and factor != 1.0:
                scaled = f"{factor**quantity.length_power * value + 0.0:.8g}"
                unit = raised("D", quantity.length_power)
            yield _Entry(label, meaning, f"{value + 0.0:.8g}", error, scaled, unit)

    def _table(self, entries: Iterator[_Entry]) -> Table:
        """Return entries as a table; its last column is that of the machine."""
        columns = 3 if self.factor == 1.0 else 4
        heads = ("Quantity", "Value", "± Error", "Scaled by D")
        return Table(heads[:columns], tuple(entry.cells[:columns] for entry in entries))


def _line(label: str, value: str, error: str = "", scaled: str = "") -> str:
    """Return a line of the table."""
    return f"{label:{_LABEL_WIDTH}}{value:>14}{error:>12} {scaled:>12}".rstrip()
