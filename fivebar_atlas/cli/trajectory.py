"""``atlas trajectory``: what the limbs of a machine do and bear in a motion."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path
from typing import Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.trajectory_text import document, lines

_PATH = click.Path(path_type=Path)


def _settings(
    ctx: click.Context,  # noqa: ARG001
    parameter: click.Parameter,  # noqa: ARG001
    texts: tuple[str, ...],
) -> dict[str, Any]:
    """Return KEY=VALUE, values as TOML, by dotted key."""
    values: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        key = key.strip()
        if not equals or not all(key.split(".")):
            raise click.BadParameter(f"{text!r} is not KEY=VALUE, such as geometry.r_a=400.")
        try:
            values[key] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            values[key] = value.strip()  # a text without its quotation marks
    return values


@click.command()
@click.argument("file", metavar="MOTION.toml|POSES.csv", type=_PATH)
@click.option("-o", "--output", metavar="FILE.h5", type=_PATH, help="Write everything as HDF5.")
@click.option("--csv", "table", metavar="FILE.csv", type=_PATH, help="Write everything as a table.")
@click.option(
    "--figure",
    metavar="FIG.(png|pdf|svg)",
    type=_PATH,
    help="Draw displacements, angles, limb lengths, velocities, accelerations and forces.",
)
@click.option(
    "--panel",
    "panels",
    multiple=True,
    metavar="LETTER",
    help="Panel of the figure, a to f; repeatable; all six if not given.",
)
@click.option("--title", metavar="TEXT", help="Title of the figure.")
@click.option("--width", type=float, metavar="MM", help="Width of the figure; 178 if not given.")
@click.option(
    "--data", metavar="FILE.csv", type=_PATH, help="Write what the figure shows as numbers."
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    callback=_settings,
    metavar="KEY=VALUE",
    help="Dotted key of the motion file, such as geometry.r_a=400; wins over it; repeatable.",
)
@options.json_option
@options.overwrite_option
def trajectory(
    file: Path,
    output: Path | None,
    table: Path | None,
    figure: Path | None,
    panels: tuple[str, ...],
    title: str | None,
    width: float | None,
    data: Path | None,
    settings: dict[str, Any],
    as_json: bool,
    overwrite: bool,
) -> None:
    """Solve a motion: limb lengths, velocities, accelerations, forces.

    MOTION.toml has the geometry, the motion as functions of time (polynomials, splines through
    points, stops) or the name of a table of poses, the load, and limits. One coordinate may be
    solved for. A small one, in mm, N, N·mm, s and degrees:

    \b
      [geometry]
      r_a = 400.0
      r_b = 100.0
      [motion]
      duration = 4.0
      samples = 401
      solve = "y"
      [motion.coordinates]
      x = 0.0
      z = { kind = "stops", times = [0, 2, 4], values = [500, 560, 500] }
      alpha = { kind = "spline", times = [0, 2, 4], values = [0, 20, 0] }
      beta = { kind = "polynomial", coefficients = [0.0, 2.0] }
      gamma = 0.0
      [load]
      force = [0.0, 10.0, -10.0]
      moment = [10.0, 0.0, 10.0]

    POSES.csv has columns t, x, y, z, alpha, beta and gamma, with units (t_s, x_mm, alpha_deg) or
    without, and perhaps Fx, Fy, Fz, Tx, Ty, Tz; the rest is given by --set.

    Printed are the range of every quantity, the largest force and the least LCI, and when.
    Positive forces push the platform. A motion that breaks the constraint of a limb, goes through
    a singular pose, exceeds a limit or has no accelerations is refused, with when and by how much.
    """  # noqa: D301
    from fivebar_atlas.output_file import check_is_no_input, check_output, checked_ending

    if figure is None and (panels or data or title or width):
        raise click.UsageError("--panel, --data, --title and --width need --figure")
    outputs = [each for each in (output, table, figure, data) if each is not None]
    for each in outputs:
        check_is_no_input(each, file)
        check_output(each, overwrite)
    if len({each.resolve() for each in outputs}) < len(outputs):
        raise click.UsageError("two outputs have the same name")
    if figure is not None:
        checked_ending(figure, ("png", "pdf", "svg"))
    from fivebar_atlas.trajectories.motion_problem import solve_motion
    from fivebar_atlas.trajectories.trajectory_file import write_table, write_trajectory

    solved = solve_motion(file, settings)
    for each in outputs:
        for source in solved.inputs:
            check_is_no_input(each, source)
    drawn = None
    if figure is not None:
        from fivebar_atlas.figures.plotted_data import PlottedData
        from fivebar_atlas.figures.trajectory_figure import trajectory_figure

        plotted = PlottedData(units=(solved.solution.units.time, ""))
        drawn = trajectory_figure(
            solved.solution, title or "", panels=panels, width=width, data=plotted
        )
    if output is not None:
        write_trajectory(solved, output, overwrite, " ".join(["atlas", *sys.argv[1:]]))
    if table is not None:
        write_table(solved, table, overwrite)
    if drawn is not None and figure is not None:
        from fivebar_atlas.figures.plotted_data import save_outputs

        save_outputs(drawn, figure, plotted, data, "", overwrite)
    if as_json:
        click.echo(json.dumps(document(file, solved), indent=2, allow_nan=False))
    else:
        click.echo("\n".join(lines(file, solved)))
