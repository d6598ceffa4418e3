"""``atlas lookup``: one machine in an atlas, interpolated and exact."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import note_compilation

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.lookup import Entry, Lookup

_LABEL_WIDTH = 36
_WIDTHS = (14, 14, 9, 11, 14, 14)


@click.command("lookup", context_settings=options.NEGATIVE_NUMBERS)
@options.lengths_argument
@options.file_argument
@options.json_option
def lookup(lengths: list[float], file: str, as_json: bool) -> None:
    """Look up one machine in an atlas, by the lengths that its mechanism has.

    Shows its dimensional factor D, its non-dimensional design and, for every stored
    quantity, the value interpolated between designs of the lattice, the exact one and the
    difference; lengths, areas and volumes also in the unit of the machine.
    """
    from fivebar_atlas.store import open_atlas
    from fivebar_atlas.synthesis.lookup import look_up

    with open_atlas(file) as atlas:
        note_compilation()
        found = look_up(atlas, lengths)
        if as_json:
            click.echo(json.dumps(found.document(), indent=2, allow_nan=False))
        else:
            if options_text := atlas.mechanism.options_text(atlas.settings.options):
                click.echo(f"{options_text}\n")
            click.echo("\n".join(_table(found)))


def _table(found: Lookup) -> Iterator[str]:
    """Yield the lines of a readable table."""
    yield f"{'dimensional factor D':<{_LABEL_WIDTH}}{found.factor:>14.8g}"
    for name, value in found.proportions.items():
        length = "" if found.factor == 1.0 else f"{found.factor * value:>14.8g}"
        yield f"{name:<{_LABEL_WIDTH}}{value:>14.8g}{length}"
    heads = ["interpolated", "exact", "± error", "difference"]
    if found.factor != 1.0:
        heads += ["scaled", "exact"]
    shown: tuple[str, ...] | None = None
    for entry in found.entries:
        group = tuple(label for axis, label in entry.labels.items() if axis == "mode")
        if group != shown:
            yield ""
            yield f"{''.join(group):<{_LABEL_WIDTH}}" + "".join(
                f"{head:>{width}}" for head, width in zip(heads, _WIDTHS, strict=False)
            )
            shown = group
        yield _line(entry, found.factor)


def _line(entry: Entry, factor: float) -> str:
    places = [f" at {label}" for axis, label in entry.labels.items() if axis != "mode"]
    label = f"{entry.quantity.name + ''.join(places):<{_LABEL_WIDTH}}"
    if isinstance(entry.interpolated, str):
        if entry.interpolated == entry.exact:
            return f"{label}  {entry.exact}"
        return f"{label}  {entry.exact} (lattice: {entry.interpolated})"
    cells = [_number(entry.interpolated), _number(entry.exact)]
    cells.append("" if entry.error is None else f"{entry.error:.1e}")
    cells.append("" if entry.difference is None else f"{entry.difference:.1e}")
    scaled = entry.scaled(factor)
    if scaled is not None:
        cells += [_number(value) for value in scaled]
    columns = zip(cells, _WIDTHS, strict=False)
    return (label + "".join(f"{cell:>{width}}" for cell, width in columns)).rstrip()


def _number(value: float | str | None) -> str:
    return f"{value + 0.0:.8g}" if isinstance(value, float) else "none"
