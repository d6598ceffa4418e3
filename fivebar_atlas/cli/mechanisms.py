"""``atlas mechanisms``: which mechanisms there are, and what each of them takes and computes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.base import Mechanism

_WIDTH = 16


@click.command()
@click.argument("name", metavar="[NAME]", required=False)
@options.json_option
def mechanisms(name: str | None, as_json: bool) -> None:
    """List the mechanisms, or everything that one of them takes and computes."""
    from fivebar_atlas import mechanisms as registry

    names = registry.names() if name is None else [name]
    documents = [_document(registry.get(each)) for each in names]
    if as_json:
        click.echo(json.dumps(documents if name is None else documents[0], indent=2))
    else:
        click.echo("\n".join(_list(documents) if name is None else _details(documents[0])))


def _document(mechanism: Mechanism) -> dict[str, Any]:
    """Return everything there is to say of a mechanism."""
    least, greatest = mechanism.resolution_range
    tightest, loosest = mechanism.tolerance_range
    return {
        "mechanism": mechanism.name,
        "title": mechanism.title,
        "source": mechanism.source,
        "lengths": {each.name: each.long_name for each in mechanism.lengths},
        "dimensional_factor": mechanism.factor_phrase,
        "parameters": {each.name: each.long_name for each in mechanism.parameters},
        "design": mechanism.design_phrase,
        "spaces": list(mechanism.spaces),
        "slices": list(mechanism.slices),
        "modes": list(mechanism.modes),
        "mode_phrase": mechanism.mode_phrase,
        "resolution_range": [least, greatest],
        "tolerance_range": [tightest, loosest],
        "options": [
            {
                "name": each.name,
                "long_name": each.long_name,
                "default": each.default,
                "allowed": each.allowed,
            }
            for each in mechanism.options
        ],
        "quantities": [
            {
                "name": each.name,
                "long_name": each.long_name,
                "unit": each.unit,
                "dimensions": list(each.dimensions),
                "error": each.error_name if each.has_error else None,
            }
            for each in mechanism.stored_quantities
        ],
    }


def _list(documents: list[dict[str, Any]]) -> Iterator[str]:
    """Yield two lines for every mechanism."""
    for document in documents:
        yield f"{document['mechanism']:{_WIDTH}}{document['title']}"
        yield f"{'':{_WIDTH}}{_lengths(document)}"


def _details(document: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of everything there is to say of a mechanism."""
    yield f"{document['title']}; {document['source']}"
    yield ""
    yield f"{'lengths':{_WIDTH}}{_lengths(document)}"
    yield from _table(document["lengths"])
    scaled = f", {document['design']}" if document["design"] else ""
    yield f"{'parameters':{_WIDTH}}{' '.join(document['parameters'])}{scaled}"
    yield from _table(document["parameters"])
    yield f"{'design spaces':{_WIDTH}}{', '.join(document['spaces'] + document['slices'])}"
    modes = f"{document['mode_phrase']}s"
    yield f"{modes:{_WIDTH}}{', '.join(document['modes'])}"
    for label, key in (("resolution", "resolution_range"), ("tolerance", "tolerance_range")):
        least, greatest = document[key]
        yield f"{label:{_WIDTH}}{least:g} to {greatest:g}"
    yield "options" if document["options"] else f"{'options':{_WIDTH}}none"
    for each in document["options"]:
        default = json.dumps(each["default"])
        yield f"  {each['name']}: {each['long_name']}; {each['allowed']}, {default} if not given"
    yield "quantities"
    quantities = document["quantities"]
    yield from _table({each["name"]: each["long_name"] for each in quantities})
    errors = ", ".join(each["error"] for each in quantities if each["error"])
    yield f"{'error estimates':{_WIDTH}}{errors or 'none'}"


def _lengths(document: dict[str, Any]) -> str:
    """Return the lengths, and what D is of them."""
    factor = document["dimensional_factor"]
    return " ".join(document["lengths"]) + (f", D = {factor}" if factor else "")


def _table(meanings: dict[str, str]) -> Iterator[str]:
    """Yield names and meanings in two columns."""
    width = max(map(len, meanings)) + 2
    for name, meaning in meanings.items():
        yield f"  {name:{width}}{meaning}"
