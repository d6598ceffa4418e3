"""``atlas path``: whether a linkage can follow a path."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import note_compilation

if TYPE_CHECKING:
    from fivebar_atlas.checked_paths import CheckedPath
    from fivebar_atlas.mechanisms.planar import PathLeast

# A longer table is printed only where it is asked for.
_MOST_ROWS = 40
# A share of D.
_ROUNDING = 1e-9
_INFEASIBLE = 1


def _points_file(ctx: click.Context, parameter: click.Parameter, text: str) -> Path:
    """Return the last argument as a file, unless it is the last length or an unknown option."""
    try:
        float(text)
    except ValueError:
        if text.startswith("-"):
            raise options.no_such_option(ctx, text) from None
        return Path(text)
    raise click.MissingParameter(ctx=ctx, param=parameter)


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@options.design_options
@click.argument("file", metavar="POINTS.csv", is_eager=True, callback=_points_file)
@options.one_mode_option
@click.option("--closed", is_flag=True, help="Go back from the last point to the first.")
@click.option(
    "--all-points", is_flag=True, help=f"Print the table for more than {_MOST_ROWS} points too."
)
@options.json_option
@click.option(
    "-o",
    "--output",
    metavar="REPORT.csv",
    type=click.Path(path_type=Path),
    help="Write the table with all digits.",
)
@options.overwrite_option
def path(
    file: Path,
    mode: str | None,
    closed: bool,
    all_points: bool,
    as_json: bool,
    output: Path | None,
    overwrite: bool,
    **design: Any,
) -> int:
    """Tell whether a path can be followed in one mode pair, between its points too.

    POINTS.csv has columns x and y (or x_mm and y_mm with the unit of the lengths); straight
    segments join the points. Reported are input angles, continuous along the path, the LCI,
    the distance to the nearest singular locus, and a verdict: feasible, or the first fault
    with the locus that is met there. Points are numbered from 1. Least LCI and distance are
    those of the whole path, between its points too; ranges of inputs those at the points.

    Exit codes: 0 feasible, 1 not feasible, 2 wrong usage or wrong input.
    """
    from fivebar_atlas.checked_paths import CheckedPath
    from fivebar_atlas.output_file import check_is_no_input, check_output
    from fivebar_atlas.point_files import read_points

    if output is not None:
        check_is_no_input(output, file)
        check_output(output, overwrite)
    machine = options.planar_design(**design)
    pair = options.mode_pair(machine, mode)
    points = read_points(file, machine.unit)
    note_compilation()
    checked = CheckedPath.of(machine, points, pair, closed)
    if output is not None:
        checked.write_csv(output, overwrite)
    if as_json:
        click.echo(json.dumps(checked.document(), indent=2, allow_nan=False))
    else:
        shown = all_points or len(checked.report.points) <= _MOST_ROWS
        click.echo("\n".join(_lines(checked, shown)))
    return 0 if checked.report.feasible else _INFEASIBLE


def _lines(checked: CheckedPath, shown: bool) -> Iterator[str]:
    """Yield the lines of a readable report."""
    from fivebar_atlas import mechanisms

    design, report = checked.design, checked.report
    unit = f" {design.unit}" if design.unit else ""
    lengths = ", ".join(
        f"{name} = {value:.8g}{unit}" for name, value in design.named_lengths.items()
    )
    yield mechanisms.get(design.mechanism).title
    yield f"{lengths}; {'; '.join(design.remarks())}"
    count = max(len(report.points) - checked.is_closed, 1)
    closed = ", closed" if checked.is_closed else ""
    points = f"{count} point{'s' if count > 1 else ''}{closed}"
    yield f"{report.mode}; {points}; path length {checked.lengths[-1]:.6g}{unit}"
    yield ""
    if shown:
        yield from _table(checked)
        yield ""
    yield from _summary(checked)
    yield checked.verdict


def _table(checked: CheckedPath) -> Iterator[str]:
    """Yield a line for every point."""
    import numpy as np

    report, unit = checked.report, checked.design.unit
    angles = [*checked.input_texts]
    yield _row("point", ["x", "y"], angles, "LCI", "distance", "nearest")
    lengths = f"({unit})" if unit else ""
    yield _row("", [lengths] * 2, ["(deg)"] * len(angles), "", lengths, "locus")
    for corner, (x, y) in enumerate(report.points):
        yield _row(
            str(checked.number(corner)),
            [_length(x, checked), _length(y, checked)],
            [_text(angle, ".2f") for angle in np.degrees(report.inputs[corner])],
            _text(report.lci[corner], ".4f"),
            _text(report.distances[corner], ".5g"),
            report.nearest[corner],
        )


def _row(
    number: str, position: list[str], angles: list[str], lci: str, distance: str, nearest: str
) -> str:
    """Return a line of the table."""
    cells = [f"{number:>5}", *(f"{each:>13}" for each in position)]
    cells += [*(f"{each:>9}" for each in angles), f"{lci:>7}", f"{distance:>11}", f"  {nearest}"]
    return "".join(cells).rstrip()


def _summary(checked: CheckedPath) -> Iterator[str]:
    """Yield the ranges of the inputs, and where LCI and distance are least."""
    import numpy as np

    report = checked.report
    unit = f" {checked.design.unit}" if checked.design.unit else ""
    turns = checked.turns()
    if not np.all(np.isnan(report.lci)):
        yield f"inputs at the points{'' if report.feasible else ' before the fault'}:"
    for number, name in enumerate(checked.input_texts):
        angles = np.degrees(report.inputs[:, number])
        low, high = checked.least(angles), checked.least(-angles)
        if low is None or high is None:
            continue
        gain = f", {_turned(turns[number])}" if turns is not None else ""
        yield (
            f"{name:<10} {angles[low] + 0.0:.2f} deg ({_point(checked, low)}) to "
            f"{angles[high] + 0.0:.2f} deg ({_point(checked, high)}){gain}"
        )
    if checked.extremes is not None:
        yield "on the whole path:"
        for label, least, form in zip(
            ("LCI", "distance"), checked.extremes, (".4f", ".5g"), strict=True
        ):
            what = f"{least.value:{form}}" + (unit if label == "distance" else "")
            place = ", ".join(_length(each, checked) for each in least.position)
            yield f"{label:<10} least {what} ({_whereabouts(checked, least)}, ({place}){unit})"
    if not np.all(np.isnan(report.lci)):
        yield ""


def _whereabouts(checked: CheckedPath, least: PathLeast) -> str:
    """Return on which point, or between which points, something is least."""
    start, end = checked.number(least.segment), checked.number(least.segment + 1)
    if least.share in (0.0, 1.0) or len(checked.report.points) == 1:
        return f"point {end if least.share == 1.0 else start}"
    return f"between point {start} and point {end}"


def _point(checked: CheckedPath, corner: int) -> str:
    """Return which point a corner is, in words."""
    again = " again" if corner and checked.number(corner) == 1 else ""
    return f"point {checked.number(corner)}{again}"


def _turned(turns: int) -> str:
    """Return full turns in words, positive if counter-clockwise."""
    return f"{turns:+d} full turn{'s' if abs(turns) > 1 else ''}" if turns else "no full turn"


def _length(value: float, checked: CheckedPath) -> str:
    """Return a coordinate; what is nothing but rounding is 0."""
    return f"{0.0 if abs(value) < _ROUNDING * checked.design.factor else value:.6g}"


def _text(value: float, form: str) -> str:
    """Return a number, nothing where it does not exist."""
    # Adding 0.0 turns -0.0 into 0.0.
    return f"{value + 0.0:{form}}" if math.isfinite(value) else "-"
