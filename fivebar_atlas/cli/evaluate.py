"""``atlas evaluate``: one design."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import note_compilation

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.base import (
        Axis,
        FloatArray,
        Mechanism,
        Quantity,
        Results,
        SweepSettings,
    )

# Wide enough for every name, and the whole line for a terminal of 80 columns.
_LABEL_WIDTH = 40


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@options.lengths_argument
@options.mechanism_option
@options.mode_option
@options.lci_option
@options.tolerance_option
@options.json_option
def evaluate(
    lengths: list[float],
    mechanism: str | None,
    mode: tuple[str, ...] | None,
    lci: tuple[float, ...] | None,
    tolerance: float | None,
    as_json: bool,
) -> None:
    """Evaluate one design, dimensional or not: workspaces, indices, circles.

    Lengths are scaled to a non-dimensional design by D = (R1 + R2 + R3)/3; both are
    reported. Lengths scale back with D, areas with its square.
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.mechanisms.base import (
        DEFAULT_LCI_THRESHOLDS,
        DEFAULT_TOLERANCE,
        SweepSettings,
    )

    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    parameters, factor = chosen.from_lengths(lengths)
    settings = SweepSettings(
        mechanism=chosen.name,
        space=chosen.spaces[0],
        resolution=chosen.resolution_range[0],
        modes=chosen.parse_modes(mode or chosen.modes[:1], "--mode"),
        lci_thresholds=DEFAULT_LCI_THRESHOLDS if lci is None else lci,
        tolerance=DEFAULT_TOLERANCE if tolerance is None else tolerance,
    )
    chosen.check_thresholds(settings.lci_thresholds, "--lci")
    chosen.check_tolerance(settings.tolerance, "--tolerance")
    note_compilation()
    results = chosen.evaluate(parameters[None, :], settings)
    if as_json:
        document = chosen.document(parameters, factor, settings, results)
        click.echo(json.dumps(document, indent=2, allow_nan=False))
    else:
        click.echo("\n".join(_table(chosen, parameters, factor, settings, results)))


def _table(
    mechanism: Mechanism,
    parameters: FloatArray,
    factor: float,
    settings: SweepSettings,
    results: Results,
) -> Iterator[str]:
    """Yield the lines of a readable table."""
    from fivebar_atlas.mechanisms.base import MODE

    axes = {axis.name: axis for axis in mechanism.axes(settings)}
    shared = [q for q in mechanism.quantities if MODE not in q.dimensions]
    of_mode = [q for q in mechanism.quantities if MODE in q.dimensions]
    yield mechanism.title
    yield ""
    yield _line("", "value", "± error", "" if factor == 1.0 else "scaled by D")
    yield _line("dimensional factor D", f"{factor:.8g}")
    for parameter, value in zip(mechanism.parameters, parameters, strict=True):
        length = "" if factor == 1.0 else f"{factor * value:.8g}"
        yield _line(parameter.name, f"{value:.8g}", "", length)
    for quantity in shared:
        yield from _quantity_lines(quantity, axes, {}, factor, results)
    for number, label in enumerate(axes[MODE].labels if MODE in axes else ()):
        yield ""
        yield label
        for quantity in of_mode:
            yield from _quantity_lines(quantity, axes, {MODE: number}, factor, results)


def _quantity_lines(
    quantity: Quantity,
    axes: Mapping[str, Axis],
    places: Mapping[str, int],
    factor: float,
    results: Results,
) -> Iterator[str]:
    """Yield a line for each entry of the axes of a quantity that have no place yet."""
    free = [axes[name] for name in quantity.dimensions[1:] if name not in places]
    for numbers in itertools.product(*(range(len(axis)) for axis in free)):
        chosen = dict(zip((axis.name for axis in free), numbers, strict=True))
        index = (0, *({**places, **chosen}[name] for name in quantity.dimensions[1:]))
        label = quantity.name + "".join(f" at {axis.labels[chosen[axis.name]]}" for axis in free)
        value = results[quantity.name][index]
        if quantity.flags is not None:
            yield f"{label:{_LABEL_WIDTH}}  {quantity.flags.describe(int(value))}"
            continue
        error = f"± {results[quantity.error_name][index]:.1e}" if quantity.has_error else ""
        scaled = ""
        if quantity.length_power and factor != 1.0:
            scaled = f"{factor**quantity.length_power * value + 0.0:.8g}"
        exists = math.isfinite(value)
        yield _line(label, f"{value + 0.0:.8g}", error, scaled) if exists else _line(label, "none")


def _line(label: str, value: str, error: str = "", scaled: str = "") -> str:
    """Return a line of the table."""
    return f"{label:{_LABEL_WIDTH}}{value:>14}{error:>12}{scaled:>13}".rstrip()
