"""``atlas info``: what is in a result file, and how it was made."""

from __future__ import annotations

import contextlib
import json
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.mechanisms.quantities import Quantity
    from fivebar_atlas.mechanisms.settings import Options
    from fivebar_atlas.store import Atlas

_WIDTH = 16


@click.command()
@options.file_argument
@options.json_option
def info(file: str, as_json: bool) -> None:
    """Say what is in a result file and how it was made."""
    from fivebar_atlas.store import open_atlas
    from fivebar_atlas.store.opening import format_of
    from fivebar_atlas.store.provenance import PART_FORMAT
    from fivebar_atlas.trajectories.trajectory_file import FORMAT as TRAJECTORY_FORMAT

    others = {TRAJECTORY_FORMAT: _say_of_trajectory, PART_FORMAT: _say_of_part}
    if (say := others.get(format_of(file))) is not None:
        say(file, as_json)
        return
    with open_atlas(file) as atlas:
        document = _document(atlas)
        text = "" if as_json else _text(document, atlas.mechanism, atlas.settings.options)
    click.echo(json.dumps(document, indent=2) if as_json else text)


def _say_of_trajectory(file: str, as_json: bool) -> None:
    """Say what is in the file of a trajectory."""
    from fivebar_atlas.cli.trajectory_text import stored_document, stored_lines
    from fivebar_atlas.trajectories.trajectory_file import read_trajectory

    stored = read_trajectory(file)
    if as_json:
        click.echo(json.dumps(stored_document(stored), indent=2))
    else:
        click.echo("\n".join(stored_lines(stored)))


def _say_of_part(file: str, as_json: bool) -> None:
    """Say what is in a file with a part of an atlas."""
    from pathlib import Path

    from fivebar_atlas.store.parts import Part

    with contextlib.closing(Part(Path(file))) as part:
        own = sum(stop - start for start, stop in part.ranges)
        document = {
            "file": file,
            "bytes": Path(file).stat().st_size,
            "mechanism": part.settings.mechanism,
            "part": f"{part.number}/{part.count}",
            "designs": own,
            "sweep_designs": part.designs,
            "made": part.attributes,
        }
    if as_json:
        click.echo(json.dumps(document, indent=2))
        return
    click.echo(f"{file} ({document['bytes']:,} bytes)")
    click.echo(part.mechanism.title)
    click.echo(
        f"part {document['part']} of an atlas: {own:,} of {part.designs:,} designs; "
        "'atlas merge' puts all parts together"
    )
    for name, value in part.attributes.items():
        click.echo(f"  {name:16} {value}" if "\n" not in str(value) else f"  {name}:\n{value}")


def _document(atlas: Atlas) -> dict[str, Any]:
    """Return everything there is to say of an atlas."""
    settings = atlas.settings
    return {
        "file": str(atlas.path),
        "bytes": atlas.path.stat().st_size,
        "mechanism": settings.mechanism,
        "title": atlas.mechanism.title,
        "source": atlas.mechanism.source,
        "designs": len(atlas),
        "space": settings.space,
        "resolution": settings.resolution,
        "modes": list(settings.modes),
        "lci_thresholds": list(settings.lci_thresholds),
        "tolerance": settings.tolerance,
        **({"options": dict(settings.options)} if settings.options else {}),
        "quantities": [
            _quantity(atlas, quantity) for quantity in atlas.mechanism.stored_quantities
        ],
        "made": atlas.attributes,
    }


def _quantity(atlas: Atlas, quantity: Quantity) -> dict[str, Any]:
    """Return meaning and range of a quantity; of flags, how often each occurs."""
    import numpy as np

    values = atlas[quantity.name]
    entry: dict[str, Any] = {
        "name": quantity.name,
        "long_name": quantity.long_name,
        "unit": quantity.unit,
        "dimensions": list(quantity.dimensions),
    }
    for product in atlas.mechanism.normalised:
        if product.quantity.name == quantity.name:
            entry["normalisation"] = product.normalisation
            entry["factors"] = list(product.factors)
    if quantity.flags is not None:
        codes, counts = np.unique(values, return_counts=True)
        entry["counts"] = {
            quantity.flags.describe(int(code)): int(count)
            for code, count in zip(codes, counts, strict=True)
        }
        return entry
    exists = values[np.isfinite(values)]
    entry["missing"] = int(values.size - exists.size)
    entry["least"] = float(exists.min()) + 0.0 if exists.size else None
    entry["greatest"] = float(exists.max()) + 0.0 if exists.size else None
    if quantity.has_error:
        errors = atlas[quantity.error_name]
        errors = errors[np.isfinite(errors)]
        entry["greatest_error"] = float(errors.max()) if errors.size else None
    return entry


def _text(document: dict[str, Any], mechanism: Mechanism, options: Options) -> str:
    """Return the document as lines for a reader, with the options of the mechanism, if any."""
    options_text = mechanism.options_text(options)
    modes = f"{mechanism.mode_phrase}s"
    lines = [
        f"{document['file']} ({document['bytes']:,} bytes)",
        f"{document['title']}; {document['source']}",
        "",
        f"{'designs':{_WIDTH}}{document['designs']:,} of the {document['space']} design space, "
        f"N = {document['resolution']}",
        *([f"{modes:{_WIDTH}}{', '.join(document['modes'])}"] if mechanism.has_modes else []),
        f"{'LCI thresholds':{_WIDTH}}"
        f"{', '.join(f'{v!r}' for v in document['lci_thresholds']) or 'none'}",
        f"{'tolerance':{_WIDTH}}{document['tolerance']:g}",
        *([f"{'options':{_WIDTH}}{options_text}"] if options_text else []),
        "",
    ]
    width = max(len(entry["name"]) for entry in document["quantities"])
    lines += [f"{entry['name']:{width}}  {_range(entry)}" for entry in document["quantities"]]
    lines += ["", "made by"]
    for name, value in document["made"].items():
        first, *rest = str(value).strip().splitlines() or [""]
        lines.append(f"  {name:15}  {first}")
        lines += [f"  {'':15}  {line}" for line in rest]
    return "\n".join(lines)


def _range(entry: dict[str, Any]) -> str:
    """Return the range of a quantity, or how often each of its meanings occurs."""
    if "counts" in entry:
        return "; ".join(f"{meaning}: {count:,}" for meaning, count in entry["counts"].items())
    if entry["least"] is None:
        return "exists nowhere"
    text = f"{entry['least']:.6g} to {entry['greatest']:.6g}"
    if "greatest_error" in entry and entry["greatest_error"] is not None:
        text += f", error at most {entry['greatest_error']:.1e}"
    return text + (f", missing {entry['missing']:,} times" if entry["missing"] else "")
