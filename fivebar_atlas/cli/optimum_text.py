"""An optimum study as text: the lines of a terminal and the sections of a report."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from fivebar_atlas.cli.optimum_figures import draw_front, draw_region
from fivebar_atlas.cli.presentation import Captioned, Row, Section, Table, capitalised, titled

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.optimum_study import OptimumStudy

# Rows of a front that are shown; a file has all.
_ROWS = 24
_WIDTH = 26
# Maps of quantities that a report draws where there is no region.
_MAPS = 4
_SIGNS = {">=": "\N{GREATER-THAN OR EQUAL TO}", "<=": "\N{LESS-THAN OR EQUAL TO}"}
_NOT_FOUND = "not found: no design evaluated exactly fulfils the conditions"


@dataclasses.dataclass(frozen=True)
class OptimumText:
    """A study as it is written down.

    Attributes
    ----------
    study
        The study, its result file open.
    """

    study: OptimumStudy

    @functools.cached_property
    def document(self) -> dict[str, Any]:
        """Everything as nested dictionaries."""
        return self.study.document()

    @property
    def title(self) -> str:
        """What was looked for."""
        if self.study.candidates.conditions:
            return f"Designs with {self._spelled_conditions}"
        return f"Best designs of the {self.study.atlas.mechanism.name}"

    @property
    def summary(self) -> str:
        """How many designs there are, and the best of them, in a sentence."""
        document = self.document
        count = f"{document['lattice_designs']} of {document['designs']} designs of the lattice"
        text = f"{count} fulfil the conditions"
        if document["conflict"] is not None:
            text += f"; the region is {_empty_text(document['conflict'])}"
        elif not document["region"]["is_empty"]:
            text += f", {100.0 * document['region']['share']:.4g} % of the design space"
        maximum = document["maximum"]
        if maximum is None or maximum["design"] is None:
            return f"{text}."
        design = ", ".join(f"{name} = {value:.6g}" for name, value in maximum["design"].items())
        return f"{text}; the best by {maximum['objective']} is {design}."

    def lines(self) -> Iterator[str]:
        """Yield the lines of a readable report."""
        document = self.document
        yield from _row_lines(self._choices())
        yield from _row_lines(self._region())
        if document["conflict"] is not None:
            yield ""
            yield "best values and where"
            for condition, rows in self._reaches():
                yield condition
                yield from _row_lines(rows, "  ")
        elif not document["region"]["is_empty"]:
            yield ""
            heads, extent = self._extent()
            yield f"{'':<10}" + "".join(f"{head:>14}" for head in heads)
            for name, cells in extent:
                yield f"{name:<10}" + "".join(f"{cell:>14}" for cell in cells)
        if document["best"]:
            yield ""
            yield "best designs of the lattice"
            for purpose, designs in self._best():
                yield f"by {purpose}"
                yield self._value_heads(designs[0])
                yield from map(self._value_line, designs)
        if document["maximum"] is not None and self._is_met:
            yield ""
            yield from _row_lines(self._maximised())
            yield from _row_lines(self._maximum(), "  ")
        if document["pareto"] is not None and self._is_met:
            yield ""
            yield from self._front_lines()

    def sections(self) -> list[Section]:
        """Return choices, region, best designs, maximum and front as sections of a report."""
        document = self.document
        mechanism = self.study.atlas.mechanism
        space = Row("mechanism", f"{mechanism.title}, {document['space']} designs")
        found = [
            Section("Choices", rows=titled([space, *self._choices()])),
            Section("Region", rows=titled(self._region()), tables=self._region_tables()),
        ]
        if document["best"]:
            tables = tuple(self._designs(rows, f"By {purpose}") for purpose, rows in self._best())
            found.append(Section("Best designs of the lattice", tables=tables))
        if document["maximum"] is not None and self._is_met:
            rows = [
                dataclasses.replace(row, label=self._long_name(row.label))
                for row in (*self._maximised(), *self._maximum())
            ]
            found.append(Section("Best design", rows=titled(rows)))
        if document["pareto"] is not None and self._is_met:
            members = document["pareto"]["members"]
            shown = self._shown_members()
            sentences = [f"{self._front_title()}."]
            if len(shown) < len(members):
                sentences.append(f"{len(shown)} of {len(members)} are listed; the data have all.")
            tables = (self._designs(shown),) if shown else ()
            found.append(Section("Pareto front", tuple(sentences), tables=tables))
        return found

    def figures(self) -> list[Captioned]:
        """Return the region, or maps of what was looked at, and the front of two quantities."""
        study = self.study
        candidates, front = study.candidates, study.front
        figures = []
        if candidates.conditions:
            if self._has_region_figure:
                where = f"Designs with {self._spelled_conditions}"
                size, quality = map(self._long_name, study.atlas.mechanism.region_quantities)
                text = f"{where}, over contours of the {size} and of the {quality}."
                figures.append(Captioned(text, self._draw_region))
        else:
            for name in study.shown[:_MAPS]:
                text = f"Atlas of the {self._long_name(name)}."
                figures.append(Captioned(text, functools.partial(self._draw_quantity, name)))
        if front is not None and len(front.names) == 2 and self._is_met:
            names = " and ".join(map(self._long_name, front.names))
            for is_map, where in ((False, "over the values of all designs"), (True, "as designs")):
                draw = functools.partial(draw_front, candidates, front, is_map)
                figures.append(Captioned(f"Pareto front of {names}, {where}.", draw))
        return figures

    @property
    def _conditions(self) -> str:
        return ", ".join(self.document["conditions"])

    @property
    def _spelled_conditions(self) -> str:
        """The conditions, quantities by what they are."""
        return " and ".join(
            f"{self._long_name(each.quantity)} {_SIGNS.get(each.operator, each.operator)} "
            f"{each.bound:.10g}"
            for each in self.study.candidates.conditions
        )

    @property
    def _is_met(self) -> bool:
        """Whether any design, of the lattice or between, fulfils the conditions."""
        conflict = self.document["conflict"]
        return conflict is None or bool(conflict["is_met"])

    @property
    def _has_region_figure(self) -> bool:
        """Whether the file has the two quantities that a region is drawn over."""
        atlas = self.study.atlas
        return set(atlas.mechanism.region_quantities) <= set(atlas.names)

    def _draw_region(self) -> Any:
        found = self.study.candidates
        return draw_region(
            found.atlas, found.region.region, found.conditions, found.mode, found.lci
        )

    def _draw_quantity(self, name: str) -> Any:
        from fivebar_atlas.figures.atlas_figures import quantity_figure

        candidates = self.study.candidates
        return quantity_figure(candidates.atlas, name, candidates.mode, candidates.lci)

    def _long_name(self, name: str) -> str:
        """Return what a quantity or parameter is; any other label as it is."""
        study = self.study
        for parameter in study.atlas.mechanism.parameters:
            if parameter.name == name:
                return f"{parameter.long_name} {name}"
        for array in study.atlas.mechanism.stored_arrays(study.atlas.settings):
            if array.name == name:
                return array.long_name
        return name

    def _choices(self) -> Iterator[Row]:
        """Yield options, mode pair, threshold and conditions."""
        document, atlas = self.document, self.study.atlas
        if options := atlas.mechanism.options_text(atlas.settings.options):
            yield Row("options", options)
        chosen = ((atlas.mechanism.mode_phrase, "mode"), ("LCI threshold", "lci_threshold"))
        for label, key in chosen:
            if document[key] is not None:
                yield Row(label, str(document[key]))
        yield Row("conditions", self._conditions or "none")

    def _region(self) -> Iterator[Row]:
        """Yield the size of the region and its errors, or that it is empty."""
        document = self.document
        region, refined, conflict = document["region"], document["refined"], document["conflict"]
        yield Row("designs of the lattice", "{lattice_designs} of {designs}".format(**document))
        if conflict is not None:
            yield Row("region", _empty_text(conflict))
            return
        if region["is_empty"]:
            text = "none between these designs: no triangle of the lattice has any"
            yield Row("region", text)
            return
        yield Row("share of the space", f"{100.0 * region['share']:.4g} %")
        error = region["interpolation_error"]
        if error is None:
            text = "unknown: error estimates have no exact values"
            yield Row("interpolation error", text)
        elif document["conditions"]:
            text = f"{error:.1e} of the bounds, largest on the outline"
            yield Row("interpolation error", text)
        if refined is not None:
            share, share_error = 100.0 * refined["share"], 100.0 * refined["share_error"]
            yield Row("refined share", f"{share:.7g} %", f"± {share_error:.1e} %")
            yield Row("largest residual", f"{refined['residual']:.1e} of the bounds")
            if self.study.atlas.mechanism.exact_tolerance is None:
                yield Row("", "errors of the values themselves not included")
            if refined["unmoved"]:
                text = "where values end or jump from design to design"
                yield Row("corners not moved", f"{refined['unmoved']}, {text}")

    def _extent(self) -> tuple[list[str], list[tuple[str, list[str]]]]:
        """Return heads and rows of the table of what every parameter runs over."""
        region, refined = self.document["region"], self.document["refined"]
        heads = ["least", "greatest", *(["refined", "refined"] if refined else [])]
        rows = []
        for name, bounds in region["extent"].items():
            cells = [f"{bound:.4f}" for bound in bounds]
            if refined is not None:
                cells += [_number(bound, ".9f") for bound in refined["extent"][name]]
            rows.append((name, cells))
        return heads, rows

    def _region_tables(self) -> tuple[Table, ...]:
        """Return what parameters run over, or in an empty region what each condition reaches."""
        if self.document["conflict"] is not None:
            rows = tuple(
                (f"{condition}, {row.label}", row.value)
                for condition, reached in self._reaches()
                for row in reached
            )
            return (Table(("Condition", "Best value and where"), rows),)
        if self.document["region"]["is_empty"]:
            return ()
        heads, extent = self._extent()
        names = ["Least", "Greatest", "Least, refined", "Greatest, refined"][: len(heads)]
        return (Table(("Parameter", *names), tuple((name, *cells) for name, cells in extent)),)

    def _reaches(self) -> Iterator[tuple[str, list[Row]]]:
        """Yield every condition that excludes others, and how far its quantity gets."""
        for reach in self.document["conflict"]["reaches"]:
            rows = []
            for label, key in (("in the whole space", "alone"), ("under the others", "among")):
                value, design = reach[key], reach[f"{key}_design"]
                if value is None:
                    rows.append(Row(label, "nothing fulfils the others"))
                    continue
                place = ", ".join(f"{name} {design[name]:.6f}" for name in self.study.parameters)
                limit = "" if reach[f"{key}_is_attained"] else ", the best design evaluated"
                rows.append(Row(label, f"{value:.8g} at {place}{limit}"))
            yield reach["condition"], rows

    def _best(self) -> list[tuple[str, list[dict[str, Any]]]]:
        """Return the best designs of the lattice by what they are best at."""
        best = self.document["best"]
        purposes = dict.fromkeys(row["for"] for row in best)
        return [(purpose, [row for row in best if row["for"] == purpose]) for purpose in purposes]

    def _maximised(self) -> Iterator[Row]:
        """Yield the objective and what its parts count."""
        maximum = self.document["maximum"]
        yield Row("maximised", maximum["objective"])
        if maximum["design"] is None:
            yield Row("", _NOT_FOUND)
            return
        for name, (low, high) in maximum["normalised_by"].items():
            yield Row("", f"{name} from {low:.7g} to {high:.7g} counts as 0 to 1")

    def _maximum(self) -> Iterator[Row]:
        """Yield the best design, its values, and what holds it where it is."""
        maximum = self.document["maximum"]
        if maximum["design"] is None:
            return
        for name, value in maximum["design"].items():
            yield Row(name, f"{value:.8f}")
        for name, value in maximum["values"].items():
            error = maximum["errors"][name]
            yield Row(name, f"{value:.10g}", "" if error is None else f"± {error:.1e}")
        lattice = maximum["lattice_value"]
        if lattice is not None:
            gain = maximum["value"] - lattice
            yield Row("objective", f"{maximum['value']:.10g}, {gain:.2e} above the lattice")
        if not maximum["is_attained"]:
            yield Row("", "the best design evaluated; better ones are closer to the border")
        active = ", ".join([*maximum["active"], *maximum["borders"]])
        yield Row("active", active or "no condition")

    def _front_title(self) -> str:
        front = self.document["pareto"]
        ways = ", ".join(f"{way} {name}" for name, way in front["directions"].items())
        kind = "polished, exact values" if front["polished"] else "of the lattice"
        count = f"{len(front['members'])} of {front['candidates']} designs"
        return f"Pareto front ({ways}), {kind}: {count}"

    def _shown_members(self) -> list[dict[str, Any]]:
        """Return some members of the front, evenly from one end to the other."""
        members: list[dict[str, Any]] = self.document["pareto"]["members"]
        last = len(members) - 1
        count = min(len(members), _ROWS)
        places = {round(number * last / max(count - 1, 1)) for number in range(count)}
        return [members[place] for place in sorted(places)]

    def _front_lines(self) -> Iterator[str]:
        """Yield the members of the front, or some of many."""
        yield self._front_title()
        members, shown = self.document["pareto"]["members"], self._shown_members()
        if not members:
            return
        yield self._value_heads(members[0])
        yield from map(self._value_line, shown)
        if len(members) > len(shown):
            count = f"{len(shown)} of {len(members)}"
            yield f"  {count} are listed; -o FILE.csv and --json have all"

    def _value_heads(self, row: dict[str, Any]) -> str:
        heads = "".join(f"{name:>12}" for name in self.study.parameters)
        return "  " + heads + "".join(f"  {name:>20}" for name in row["values"])

    def _value_line(self, row: dict[str, Any]) -> str:
        design, values = self._cells(row)
        return (
            "  "
            + "".join(f"{cell:>12}" for cell in design)
            + "".join(
                f"  {cell:>{max(len(name), 20)}}"
                for name, cell in zip(row["values"], values, strict=True)
            )
        )

    def _cells(self, row: dict[str, Any]) -> tuple[list[str], list[str]]:
        """Return the parameters of a design, and its values with their errors."""
        values = []
        for name, value in row["values"].items():
            error = row["errors"][name]
            text = _number(value, ".9g")
            values.append(f"{text} ± {error:.0e}" if error is not None else text)
        return [f"{row['design'][name]:.8f}" for name in self.study.parameters], values

    def _designs(self, rows: Sequence[dict[str, Any]], caption: str = "") -> Table:
        """Return designs with their values as a table."""
        quantities = (capitalised(self._long_name(name)) for name in rows[0]["values"])
        cells = []
        for number, row in enumerate(rows, start=1):
            design, values = self._cells(row)
            cells.append((str(number), *design, *values))
        return Table(("No.", *self.study.parameters, *quantities), tuple(cells), caption)


def _empty_text(conflict: dict[str, Any]) -> str:
    """Return why a region is empty."""
    together = conflict["conditions"]
    if conflict["is_met"]:
        return "smaller than a triangle of the lattice"
    if len(together) == 1:
        return f"empty: no design has {together[0]}"
    return f"empty: {', '.join(together)} exclude each other"


def _row_lines(rows: Iterable[Row], before: str = "") -> Iterator[str]:
    """Yield the line of every row, its label after what stands before it."""
    for row in rows:
        yield _line(f"{before}{row.label}", f"{row.value} {row.error}" if row.error else row.value)


def _line(label: str, value: str) -> str:
    return f"{label:<{_WIDTH}}  {value}"


def _number(value: float | None, form: str) -> str:
    return "none" if value is None or not math.isfinite(value) else format(value, form)
