"""``atlas square``: the largest square workspace of Le, Kang and Doan."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.presentation import Run, present
from fivebar_atlas.cli.progress import Progress, note_compilation
from fivebar_atlas.cli.square_options import (
    machine_lengths,
    parse_ratios,
    square_options,
    square_task,
)
from fivebar_atlas.cli.square_text import SquareCurveText, SquareText
from fivebar_atlas.errors import InfeasibleSizeError, InputError

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.largest_square import SquareTask
    from fivebar_atlas.synthesis.square_curve import SquareCurve
    from fivebar_atlas.synthesis.square_gains import Gain

_RANGE = "1.2:4:0.05"
_LENGTH = re.compile(r"\s*([+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\W\d_]*)\s*")


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@square_options
@click.option(
    "--rho",
    metavar="RHO|A:B:STEP",
    help=f"Ratio l2/l1, 1 or more, or ratios from A to B; {_RANGE} if nothing is given.",
)
@click.option(
    "--lengths",
    nargs=3,
    type=float,
    metavar="L1 L2 L0",
    help="Lengths of any design in place of a ratio; L0 is half the base.",
)
@click.option(
    "--l1",
    metavar="LENGTH",
    help="Length of the actuated link, such as 250mm; 1 without a unit if not given.",
)
@click.option(
    "--gains",
    is_flag=True,
    help="Also say how much larger it is with centre, l0 and mode pair free.",
)
@options.json_option
@click.option(
    "-o",
    "--output",
    metavar="FILE.(json|csv)",
    type=click.Path(path_type=Path),
    help="Write the JSON, or the curve as a table.",
)
@options.overwrite_option
@options.quiet_option
def square(
    rho: str | None,
    lengths: tuple[float, float, float] | None,
    l1: str | None,
    gains: bool,
    as_json: bool,
    output: Path | None,
    overwrite: bool,
    quiet: bool,
    **choices: Any,
) -> None:
    """Find the largest square workspace, after Le, Kang and Doan (2013).

    The square is centred in the maximal inscribed circle of the usable workspace; its LCI is
    nowhere below --lci. Over a range of ratios of links, with l0 = (l2 - l1)/√2 (Eq. 21), the
    side has kinks where another constraint becomes the active one: the pieces are listed, and
    the ratio with the largest square is found. A single ratio or --lengths gives one square.

    Exit codes: 0 done, 1 there is no square, 2 wrong usage or wrong input.
    """
    from fivebar_atlas.output_file import check_output, checked_ending
    from fivebar_atlas.synthesis.largest_square import check_ranges_allow, largest_square, why_none
    from fivebar_atlas.synthesis.square_curve import square_curve

    ending = "" if output is None else checked_ending(output, ("json", "csv"))
    if output is not None:
        check_output(output, overwrite)
    if rho is not None and lengths is not None:
        raise click.UsageError("give either --rho or --lengths")
    text = rho or _RANGE
    is_curve = lengths is None and ":" in text
    if ending == "csv" and not is_curve:
        raise click.UsageError("a table (.csv) goes with a range of ratios; write .json instead")
    if gains and not is_curve:
        raise click.UsageError("--gains goes with a range of ratios")
    length, unit = _actuated_link(l1)
    task = square_task(**choices)
    if gains and task.centre != "mic":
        raise click.UsageError("--gains are measured from --centre mic")
    if is_curve:
        ratios = parse_ratios(text)
        note_compilation()
        check_ranges_allow(task, ratios[0])
        with Progress(len(ratios), quiet=quiet, things="ratios") as bar:
            curve = square_curve(task, ratios, lambda done, total: bar.advance(1))  # noqa: ARG005
        if curve.largest is None:
            some = curve.squares[len(curve.squares) // 2]
            where = f"for no ratio from {ratios[0]:g} to {ratios[-1]:g}; at ρ = {some.ratio:g}"
            raise InfeasibleSizeError(f"{where} {why_none(some)}")
        found = _gains(task, curve, quiet) if gains else []
        shown: SquareText | SquareCurveText = SquareCurveText(curve, found, length, unit)
    else:
        ratio = None if lengths is not None else _ratio(text)
        machine = machine_lengths(task.mechanism, ratio, lengths)
        note_compilation()
        if ratio is not None:
            check_ranges_allow(task, ratio)
        one = largest_square(task, machine)
        if one.side == 0.0:
            raise InfeasibleSizeError(why_none(one))
        shown = SquareText(one, length, unit)
    if ending == "csv" and isinstance(shown, SquareCurveText):
        _write_table(shown.table(), output, overwrite)
    present(Run.of(shown), as_json, output if ending == "json" else None, overwrite)


def _gains(task: SquareTask, curve: SquareCurve, quiet: bool) -> list[Gain]:
    """Return what is gained by freedom, with progress."""
    from fivebar_atlas.synthesis.square_gains import CASES, square_gains

    with Progress(CASES, quiet=quiet, things="cases") as bar:
        return square_gains(task, curve, lambda done, total: bar.advance(1))  # noqa: ARG005


def _ratio(text: str) -> float:
    """Return one ratio of links."""
    try:
        return float(text)
    except ValueError:
        allowed = "a ratio such as 1.6, or ratios A:B:STEP such as 1.2:4:0.05"
        raise InputError("--rho", text, allowed) from None


def _actuated_link(text: str | None) -> tuple[float, str]:
    """Return the length of the actuated link and its unit; 1 without one if nothing is said."""
    if text is None:
        return 1.0, ""
    found = _LENGTH.fullmatch(text)
    if found is None or not 0.0 < float(found[1]) < math.inf:
        raise InputError("--l1", text, "a length above 0 such as 250 or 250mm")
    options.check_unit(found[2] or None)
    return float(found[1]), found[2]


def _write_table(rows: list[list[Any]], output: Path | None, overwrite: bool) -> None:
    from fivebar_atlas.output_file import atomic_output

    assert output is not None
    with (
        atomic_output(output, overwrite) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as stream,
    ):
        csv.writer(stream, lineterminator="\n").writerows(rows)
