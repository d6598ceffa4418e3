"""``atlas optimum``: the designs of an atlas that fulfil conditions, and the best of them."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import note_compilation

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.optimum_study import OptimumStudy

# Rows of a front that a terminal shows; a file has all.
_ROWS = 24
_WIDTH = 26


@click.command("optimum", context_settings={"max_content_width": 100})
@options.file_argument
@click.option(
    "--where",
    "wheres",
    multiple=True,
    metavar="CONDITION",
    help="A condition such as 'gci>=0.62'; all that are given must hold.",
)
@click.option("--mode", metavar="MODE", help="Mode pair, where the file holds several.")
@click.option(
    "--lci", type=float, metavar="THRESHOLD", help="LCI threshold, where the file holds several."
)
@click.option("--refine", is_flag=True, help="Move the region's outline onto true level sets.")
@click.option(
    "--maximise",
    "--maximize",
    metavar="OBJECTIVE",
    help="Find the best design: 'gci', or weighted 'gci:1,usable_workspace_area:0.5'.",
)
@click.option(
    "--pareto",
    metavar="QUANTITIES",
    help="Find the Pareto front: 'usable_workspace_area,gci'; '-r3' or 'r3:min' for less.",
)
@click.option("--polish", is_flag=True, help="Move the members of the front onto the true front.")
@click.option(
    "--best", default=3, show_default=True, metavar="N", help="Designs of the lattice to list."
)
@options.json_option
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE.csv",
    help="Write the front, or else the designs of the lattice that fulfil all, as a table.",
)
@options.overwrite_option
def optimum(
    file: str,
    wheres: tuple[str, ...],
    mode: str | None,
    lci: float | None,
    refine: bool,
    maximise: str | None,
    pareto: str | None,
    polish: bool,
    best: int,
    as_json: bool,
    output: Path | None,
    overwrite: bool,
) -> None:
    """Find the region of an atlas where conditions hold, and the best designs in it.

    Conditions are on stored quantities and on parameters. The region is exact for the
    lattice's linear interpolation, whose error is stated; --refine, --maximise and
    --polish use exact values. Where nothing fulfils the conditions, the answer says which
    of them exclude each other and how far each quantity gets.
    """
    from fivebar_atlas.errors import InputError
    from fivebar_atlas.output_file import check_is_no_input, check_output, checked_ending
    from fivebar_atlas.store import open_atlas
    from fivebar_atlas.synthesis.conditions import (
        check_conditions,
        check_contradictions,
        condition_names,
        parse_condition,
    )
    from fivebar_atlas.synthesis.objectives import parse_directions, parse_objective
    from fivebar_atlas.synthesis.optimum_study import study_optimum

    if output is not None:
        checked_ending(output, ("csv",))
        check_is_no_input(output, Path(file))
        check_output(output, overwrite)
    if polish and pareto is None:
        raise click.UsageError("--polish needs --pareto")
    if best < 0:
        raise InputError("--best", best, "a number of at least 0")
    conditions = [parse_condition(where) for where in wheres]
    with open_atlas(file) as atlas, options.asked_to_choose():
        known = condition_names(atlas)
        check_conditions(conditions, atlas)
        check_contradictions(conditions)
        objective = None if maximise is None else parse_objective(maximise, known)
        directions = () if pareto is None else parse_directions(pareto, known)
        note_compilation()
        study = study_optimum(
            atlas,
            conditions,
            mode,
            lci,
            refine=refine,
            objective=objective,
            directions=directions,
            polish=polish,
            best=best,
        )
        if output is not None:
            _write(study.table(), output, overwrite)
        if as_json:
            click.echo(json.dumps(study.document(), indent=2, allow_nan=False))
        else:
            click.echo("\n".join(_report(study)))


def _write(table: Sequence[Sequence[Any]], output: Path, overwrite: bool) -> None:
    from fivebar_atlas.output_file import atomic_output

    with (
        atomic_output(output, overwrite) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as stream,
    ):
        csv.writer(stream, lineterminator="\n").writerows(table)


def _report(study: OptimumStudy) -> Iterator[str]:
    """Yield the lines of a readable report."""
    document = study.document()
    for label, key in (("mode pair", "mode"), ("LCI threshold", "lci_threshold")):
        if document[key] is not None:
            yield _line(label, document[key])
    yield _line("conditions", ", ".join(document["conditions"]) or "none")
    yield _line("designs of the lattice", "{lattice_designs} of {designs}".format(**document))
    if document["conflict"] is not None:
        yield from _conflict_lines(document["conflict"], study.parameters)
    else:
        yield from _region_lines(document)
    if document["best"]:
        yield ""
        yield from _best_lines(document["best"], study.parameters)
    is_met = document["conflict"] is None or document["conflict"]["is_met"]
    if document["maximum"] is not None and is_met:
        yield ""
        yield from _maximum_lines(document["maximum"])
    if document["pareto"] is not None and is_met:
        yield ""
        yield from _front_lines(document["pareto"], study.parameters)


def _line(label: str, value: object) -> str:
    return f"{label:<{_WIDTH}}  {value}"


def _region_lines(document: dict[str, Any]) -> Iterator[str]:
    region, refined = document["region"], document["refined"]
    if region["is_empty"]:
        yield _line("region", "none between these designs: no triangle of the lattice has any")
        return
    yield _line("share of the space", f"{100.0 * region['share']:.4g} %")
    error = region["interpolation_error"]
    if error is None:
        yield _line("interpolation error", "unknown: error estimates have no exact values")
    elif document["conditions"]:
        yield _line("interpolation error", f"{error:.1e} of the bounds, largest on the outline")
    if refined is not None:
        share, share_error = 100.0 * refined["share"], 100.0 * refined["share_error"]
        yield _line("refined share", f"{share:.7g} % ± {share_error:.1e} %")
        yield _line("largest residual", f"{refined['residual']:.1e} of the bounds")
        if refined["unmoved"]:
            text = "where values end or jump from design to design"
            yield _line("corners not moved", f"{refined['unmoved']}, {text}")
    yield ""
    heads = ["least", "greatest", *(["refined", "refined"] if refined else [])]
    yield f"{'':<10}" + "".join(f"{head:>14}" for head in heads)
    for name, bounds in region["extent"].items():
        cells = [f"{bound:.4f}" for bound in bounds]
        if refined is not None:
            cells += [_number(bound, ".9f") for bound in refined["extent"][name]]
        yield f"{name:<10}" + "".join(f"{cell:>14}" for cell in cells)


def _best_lines(best: list[dict[str, Any]], parameters: Sequence[str]) -> Iterator[str]:
    yield "best designs of the lattice"
    purpose = None
    for row in best:
        if row["for"] != purpose:
            purpose = row["for"]
            yield f"by {purpose}"
            yield from _value_heads(row, parameters)
        yield _value_line(row, parameters)


def _value_heads(row: dict[str, Any], parameters: Sequence[str]) -> Iterator[str]:
    heads = "".join(f"{name:>12}" for name in parameters)
    yield "  " + heads + "".join(f"  {name:>20}" for name in row["values"])


def _value_line(row: dict[str, Any], parameters: Sequence[str]) -> str:
    design = "".join(f"{row['design'][name]:>12.8f}" for name in parameters)
    cells = []
    for name, value in row["values"].items():
        error = row["errors"][name]
        text = _number(value, ".9g")
        cells.append(f"{text} ± {error:.0e}" if error is not None else text)
    heads = row["values"]
    return (
        "  "
        + design
        + "".join(
            f"  {cell:>{max(len(name), 20)}}" for name, cell in zip(heads, cells, strict=True)
        )
    )


def _maximum_lines(maximum: dict[str, Any]) -> Iterator[str]:
    yield _line("maximised", maximum["objective"])
    if maximum["design"] is None:
        yield _line("", "not found: no design evaluated exactly fulfils the conditions")
        return
    for name, (low, high) in maximum["normalised_by"].items():
        yield _line("", f"{name} from {low:.7g} to {high:.7g} counts as 0 to 1")
    for name, value in maximum["design"].items():
        yield _line(f"  {name}", f"{value:.8f}")
    for name, value in maximum["values"].items():
        error = maximum["errors"][name]
        yield _line(f"  {name}", f"{value:.10g}" + ("" if error is None else f" ± {error:.1e}"))
    lattice = maximum["lattice_value"]
    if lattice is not None:
        gain = maximum["value"] - lattice
        yield _line("  objective", f"{maximum['value']:.10g}, {gain:.2e} above the lattice")
    if not maximum["is_attained"]:
        yield _line("", "the best design evaluated; better ones are closer to the border")
    yield _line("  active", ", ".join([*maximum["active"], *maximum["borders"]]) or "no condition")


def _front_lines(front: dict[str, Any], parameters: Sequence[str]) -> Iterator[str]:
    members = front["members"]
    ways = ", ".join(f"{way} {name}" for name, way in front["directions"].items())
    kind = "polished, exact values" if front["polished"] else "of the lattice"
    yield f"Pareto front ({ways}), {kind}: {len(members)} of {front['candidates']} designs"
    if not members:
        return
    yield from _value_heads(members[0], parameters)
    last = len(members) - 1
    count = min(len(members), _ROWS)
    for place in sorted({round(number * last / max(count - 1, 1)) for number in range(count)}):
        yield _value_line(members[place], parameters)
    if len(members) > count:
        yield f"  {count} of {len(members)} are listed; -o FILE.csv and --json have all"


def _conflict_lines(conflict: dict[str, Any], parameters: Sequence[str]) -> Iterator[str]:
    together = conflict["conditions"]
    if conflict["is_met"]:
        yield _line("region", "smaller than a triangle of the lattice")
    elif len(together) == 1:
        yield _line("region", f"empty: no design has {together[0]}")
    else:
        yield _line("region", f"empty: {', '.join(together)} exclude each other")
    yield ""
    yield "best values and where"
    for reach in conflict["reaches"]:
        yield f"{reach['condition']}"
        for label, key in (("in the whole space", "alone"), ("under the others", "among")):
            value, design = reach[key], reach[f"{key}_design"]
            if value is None:
                yield _line(f"  {label}", "nothing fulfils the others")
                continue
            place = ", ".join(f"{name} {design[name]:.6f}" for name in parameters)
            limit = "" if reach[f"{key}_is_attained"] else ", the best design evaluated"
            yield _line(f"  {label}", f"{value:.8g} at {place}{limit}")


def _number(value: float | None, form: str) -> str:
    return "none" if value is None or not math.isfinite(value) else format(value, form)
