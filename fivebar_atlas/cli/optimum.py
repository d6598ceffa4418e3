"""``atlas optimum``: the designs of an atlas that fulfil conditions, and the best of them."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.optimum_text import OptimumText
from fivebar_atlas.cli.presentation import Run, present
from fivebar_atlas.cli.progress import note_compilation


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
    help="Find the Pareto front: 'usable_workspace_area,gci'; '-NAME' or 'NAME:min' for less.",
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
        objective = (
            None if maximise is None else parse_objective(maximise, known, unknown=atlas.unknown)
        )
        directions = (
            () if pareto is None else parse_directions(pareto, known, unknown=atlas.unknown)
        )
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
        text = OptimumText(study)
        run = Run(
            title=text.title,
            summary=text.summary,
            document=lambda: text.document,
            lines=text.lines,
            sections=text.sections,
            figures=text.figures,
        )
        present(run, as_json)


def _write(table: Sequence[Sequence[Any]], output: Path, overwrite: bool) -> None:
    from fivebar_atlas.output_file import atomic_output

    with (
        atomic_output(output, overwrite) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as stream,
    ):
        csv.writer(stream, lineterminator="\n").writerows(table)
