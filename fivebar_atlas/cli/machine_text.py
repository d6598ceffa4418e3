"""A machine of some size as text: the lines of a terminal and the sections of a report."""

from __future__ import annotations

import dataclasses
import math
import shlex
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from fivebar_atlas.cli.design_figures import lci_map, linkage, workspace
from fivebar_atlas.cli.presentation import (
    Captioned,
    Row,
    Section,
    Table,
    capitalised,
    option_rows,
    raised,
    titled,
)

if TYPE_CHECKING:
    from fivebar_atlas.figures.overlays import Overlay
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.mechanisms.planar import PlanarDesign
    from fivebar_atlas.mechanisms.quantities import Quantity
    from fivebar_atlas.planar_geometry import Point
    from fivebar_atlas.synthesis.sizing import Machine

_LABEL_WIDTH = 32
# A coordinate that is nothing but rounding, as a share of D: where something has a flat extreme
# is known to the square root of that of its value.
_ROUNDING = 1e-7
# Points of the outline of a shape in a figure.
_OUTLINE_POINTS = 400


@dataclasses.dataclass(frozen=True, slots=True)
class MachineText:
    """A machine as it is written down.

    Attributes
    ----------
    machine
        The machine.
    resolution
        Encoder resolution in radians, None where nothing is asked for it.
    force
        Force on the output point in newtons, None where nothing is asked for it.
    area
        The digits of the area that was asked for, None where a shape was.
    """

    machine: Machine
    resolution: float | None = None
    force: float | None = None
    area: str | None = None

    @property
    def title(self) -> str:
        """What the machine is for."""
        shape, unit = self.machine.shape, self.machine.unit
        if shape is None:
            return f"Machine with a good-condition workspace of {self.area} {unit}²"
        return f"Machine for a {shape.name_in(unit)}"

    @property
    def summary(self) -> str:
        """The lengths, and what is true of a machine that has them, in a sentence."""
        machine, good = self.machine, self.machine.good
        lengths = ", ".join(
            f"{name} = {length:.6g} {machine.unit}" for name, length in machine.lengths.items()
        )
        least = f"the LCI is at least {good.lci_threshold:g}"
        if machine.shape is None:
            return f"With {lengths} {least} in such an area, in the mode pair {good.mode}."
        return (
            f"With {lengths} {least} in the whole of it, in the mode pair {good.mode}. "
            "It is the smallest such machine of these proportions."
        )

    def document(self) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON."""
        return self.machine.document(self.resolution, self.force)

    def lines(self) -> Iterator[str]:
        """Yield the lines of a readable report."""
        machine, good = self.machine, self.machine.good
        yield self._mechanism.title
        yield f"{self._proportions}; {self._remarks}"
        yield f"{good.mode}; LCI at least {good.lci_threshold:g}"
        if options := self._mechanism.options_text(good.design.options):
            yield options
        yield ""
        yield from _row_lines(self._lengths())
        yield from _row_lines(self._practical_workspace())
        yield ""
        for quantity, value, _ in self._indices():
            yield text_line(quantity.name, value)
        yield ""
        yield from _row_lines([*self._inputs(), *self._worst_cases()])
        yield ""
        lengths = " ".join(f"{length:.10g}" for length in machine.lengths.values())
        names = (
            f"--mode {shlex.quote(good.mode)} --lci {good.lci_threshold:g} "
            f"--unit {shlex.quote(machine.unit)}{_choices(good.design)}"
        )
        yield f"Its LCI map: atlas plot lci {lengths} {names} -o lci.pdf"

    def sections(self) -> list[Section]:
        """Return choices, machine, workspace, indices and inputs as sections of a report."""
        good, mechanism = self.machine.good, self._mechanism
        choices = (
            Row("Mechanism", mechanism.title, note=mechanism.source),
            Row("Proportions", self._proportions, note=self._remarks),
            Row("Mode pair", good.mode),
            Row("LCI threshold", f"{good.lci_threshold:g}", note="reached in the whole workspace"),
            *option_rows(mechanism, good.design.options),
        )
        meanings = {each.name: each.long_name for each in mechanism.lengths}
        lengths = [
            dataclasses.replace(
                row,
                error=f"{row.error} {self.machine.unit}" if row.error else "",
                note=meanings.get(row.label, row.note),
            )
            for row in self._lengths()
        ]
        indices = Table(
            ("Quantity", "Value", "± Error"),
            tuple(
                (capitalised(quantity.long_name), value, error)
                for quantity, value, error in self._indices()
            ),
        )
        found = [
            Section("Choices", rows=choices),
            Section("Machine", rows=titled(lengths)),
            Section("Practical workspace", rows=titled(self._practical_workspace())),
            Section("Indices and areas", tables=(indices,)),
            Section(
                "Actuators",
                ("The range of each input over the practical workspace.",),
                titled(self._inputs()),
            ),
        ]
        if worst := titled(self._worst_cases()):
            found.append(Section("Errors and loads", rows=worst))
        return found

    def figures(self) -> list[Captioned]:
        """Return workspace and LCI map with the shape in them, and the linkage."""
        machine, good = self.machine, self.machine.good
        design, overlays = machine.design, self._overlays()
        return [
            workspace(design, good.mode, overlays),
            lci_map(design, good.mode, good.lci_threshold, overlays),
            linkage(design, good.mode, machine.position),
        ]

    @property
    def _mechanism(self) -> Mechanism:
        from fivebar_atlas import mechanisms

        return mechanisms.get(self.machine.good.design.mechanism)

    @property
    def _proportions(self) -> str:
        return ", ".join(
            f"{name} = {length:.8g}"
            for name, length in self.machine.good.design.named_lengths.items()
        )

    @property
    def _remarks(self) -> str:
        return "; ".join(self.machine.good.design.remarks())

    def _lengths(self) -> Iterator[Row]:
        """Yield the dimensional factor and the lengths."""
        machine = self.machine
        factor = f"{machine.factor:.10g} {machine.unit}"
        yield Row("dimensional factor D", factor, f"± {machine.factor_error:.0e}")
        for name, length in machine.lengths.items():
            yield Row(name, f"{length:.10g} {machine.unit}")

    def _practical_workspace(self) -> Iterator[Row]:
        """Yield what the machine is for, and where the shape lies in it."""
        from fivebar_atlas.synthesis.containment import INSIDE

        machine, unit = self.machine, self.machine.unit
        shape, fit, position = machine.shape, machine.fit, machine.position
        if shape is None or fit is None or position is None:
            parts = "" if machine.parts == 1 else f" (the largest of its {machine.parts} parts)"
            text = f"good-condition workspace{parts} of {self.area} {unit}²"
            yield Row("practical workspace", text)
            return
        clear = f" and {shape.clearance:g} {unit} around it" if shape.clearance else ""
        yield Row("practical workspace", f"{shape.name_in(unit)}{clear}")
        yield Row("centre", self._place(position))
        proof = fit.proof
        shown = f"proved with {proof.squares} squares" if proof.verdict == INSIDE else "not proved"
        yield Row("containment", shown)
        for contact in machine.contacts:
            yield Row("contact", self._place(contact))

    def _indices(self) -> Iterator[tuple[Quantity, str, str]]:
        """Yield the quantities that exist with value and error in the unit of the machine."""
        machine, unit = self.machine, self.machine.unit
        _, results = machine.evaluation
        for quantity in self._mechanism.quantities:
            if quantity.flags is not None or len(quantity.dimensions) < 2:
                continue
            value = float(results[quantity.name].ravel()[0])
            if not math.isfinite(value):
                continue
            power = quantity.length_power
            scale = machine.factor**power
            suffix = f" {raised(unit, power)}".rstrip()
            error = ""
            if quantity.has_error:
                error = f"± {scale * float(results[quantity.error_name].ravel()[0]):.1e}{suffix}"
            yield quantity, f"{scale * value + 0.0:.8g}{suffix}", error

    def _inputs(self) -> Iterator[Row]:
        """Yield what the inputs run over."""
        for each in self.machine.input_ranges:
            name = self._mechanism.input_text(each.number)
            if each.is_full_turn:
                yield Row(name, "0 to 360 deg, full turns")
                continue
            assert each.at_least is not None
            assert each.at_greatest is not None
            least, greatest = math.degrees(each.least), math.degrees(each.greatest)
            places = f"at {self._place(each.at_least)} and {self._place(each.at_greatest)}"
            yield Row(name, f"{least:.4f} to {greatest:.4f} deg", note=places)

    def _worst_cases(self) -> Iterator[Row]:
        """Yield the largest error and torque, as far as they are asked for."""
        machine, unit = self.machine, self.machine.unit
        if self.resolution is not None:
            error = machine.positioning_error(self.resolution)
            at = self._place(error.position)
            yield Row(
                "positioning error",
                f"{error.value:.6g} {unit} at most, at {at}",
                note=f"for encoders that are off by ±{math.degrees(self.resolution):g} deg each",
            )
        if self.force is not None:
            torque = machine.joint_torque(self.force)
            at = self._place(torque.position)
            yield Row(
                "joint torque",
                f"{torque.value:.6g} N {unit} at most, at {at}",
                note=f"for {self.force:g} N in any direction, without weight and friction",
            )

    def _overlays(self) -> list[Overlay]:
        """Return the shape, and around it its clearance, as they are drawn into figures."""
        from fivebar_atlas.figures.overlays import Overlay

        machine, shape, position = self.machine, self.machine.shape, self.machine.position
        if shape is None or position is None:
            return []
        touching = (machine.contacts, "points of contact")
        name = shape.name_in(machine.unit)
        outline = shape.boundary(shape.boundary_samples(_OUTLINE_POINTS)) + position
        if not shape.clearance:
            return [Overlay(name, outline, *touching)]
        bare = dataclasses.replace(shape, radius=shape.radius - shape.clearance, clearance=0.0)
        inner = bare.boundary(bare.boundary_samples(_OUTLINE_POINTS)) + position
        clearance = f"clearance of {shape.clearance:g} {machine.unit}"
        return [Overlay(name, inner), Overlay(clearance, outline, *touching, dashed=True)]

    def _place(self, point: Point) -> str:
        """Return coordinates; what is nothing but rounding is 0."""
        machine = self.machine
        x, y = (0.0 if abs(part) < _ROUNDING * machine.factor else part for part in point)
        return f"({x:.6g}, {y:.6g}) {machine.unit}"


def _choices(design: PlanarDesign) -> str:
    """Return what a command line needs besides lengths, beginning with a space; often nothing."""
    from fivebar_atlas import mechanisms

    mechanism = mechanisms.get(design.mechanism)
    words = []
    if mechanism.name != mechanisms.names()[0]:
        words.append(f" --mechanism {mechanism.name}")
    for option, (name, value) in zip(mechanism.options, design.options, strict=True):
        if value != option.default:
            text = str(value).lower() if isinstance(value, bool) else f"{value:.10g}"
            words.append(f" --set {name}={text}")
    return "".join(words)


def _row_lines(rows: Iterable[Row]) -> Iterator[str]:
    """Yield the line of every row, and its note below it."""
    for row in rows:
        yield text_line(row.label, row.value, row.error)
        if row.note:
            yield text_line("", row.note)


def text_line(label: str, value: str, more: str = "") -> str:
    """Return a line of the report."""
    padded = f"{label:{_LABEL_WIDTH}}" if len(label) < _LABEL_WIDTH else f"{label}  "
    return f"{padded}{value}{'  ' + more if more else ''}".rstrip()
