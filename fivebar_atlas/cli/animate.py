"""``atlas animate``: a linkage that follows a path."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import Progress, note_compilation
from fivebar_atlas.errors import InputError

if TYPE_CHECKING:
    from fivebar_atlas.checked_paths import CheckedPath
    from fivebar_atlas.mechanisms.planar import PlanarDesign

_FRAMES = 120
# A share of D.
_INSET = 0.05


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@options.design_options
@options.one_mode_option
@click.option("--circle", type=float, nargs=3, metavar="X Y RADIUS", help="Follow a circle.")
@click.option(
    "--inset",
    type=float,
    metavar="MARGIN",
    help="Follow the boundary of the usable workspace inset by a margin; 0.05 D if no path is "
    "given.",
)
@click.option(
    "--hole", type=int, metavar="N", help="Go around a hole instead of the outline; 1 the largest."
)
@click.option(
    "--points",
    metavar="FILE.csv",
    type=click.Path(path_type=Path),
    help="Follow points, columns x and y, in straight segments.",
)
@click.option("--closed", is_flag=True, help="With --points: go back to the first point.")
@click.option("--frames", type=int, metavar="N", help=f"Number of frames.  [default: {_FRAMES}]")
@click.option("--seconds", type=float, metavar="S", help="Duration, instead of --frames.")
@click.option(
    "--fps", type=int, default=20, show_default=True, metavar="N", help="Frames a second, 1 to 50."
)
@click.option(
    "--width", type=float, default=85.0, show_default=True, metavar="MM", help="Width, at 200 dpi."
)
@click.option(
    "--data",
    metavar="FILE.csv",
    type=click.Path(path_type=Path),
    help="Write what the frames show as numbers, too.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE.(gif|mp4)",
    help="Animation; the ending decides the format. MP4 needs ffmpeg.",
)
@options.overwrite_option
@options.quiet_option
def animate(
    mode: str | None,
    circle: tuple[float, float, float] | None,
    inset: float | None,
    hole: int | None,
    points: Path | None,
    closed: bool,
    frames: int | None,
    seconds: float | None,
    fps: int,
    width: float,
    data: Path | None,
    output: Path,
    overwrite: bool,
    quiet: bool,
    **design: Any,
) -> None:
    """Show a linkage that follows a path inside its usable workspace, and its LCI.

    The path is a circle, points from a file, or the boundary of the usable workspace inset by
    a margin. Frames are equally spaced along it. A path that leaves the usable workspace
    anywhere, between its points too, is refused: the locus that is met first is named.
    """
    if sum(each is not None for each in (circle, inset, points)) > 1:
        raise click.UsageError("--circle, --inset and --points exclude each other")
    if hole is not None and (circle or points):
        raise click.UsageError("--hole goes with --inset only")
    if closed and points is None:
        raise click.UsageError("--closed goes with --points only")
    if frames is not None and seconds is not None:
        raise click.UsageError("--frames and --seconds exclude each other")

    from fivebar_atlas.figures.animation import path_animation
    from fivebar_atlas.figures.animation_files import (
        check_animation_output,
        frame_seconds,
        save_animation,
        save_frames,
    )
    from fivebar_atlas.output_file import check_is_no_input, check_output

    for written in filter(None, (output, data) if points is not None else ()):
        check_is_no_input(written, cast("Path", points))
    check_animation_output(output, fps, overwrite)
    if data is not None:
        check_output(data, overwrite)
    if seconds is not None:
        if not (math.isfinite(seconds) and seconds > 0.0):
            raise InputError("seconds", seconds, "a duration above 0")
        frames = round(seconds * fps)
    machine = options.planar_design(**design)
    note_compilation()
    checked = _path(machine, options.mode_pair(machine, mode), circle, inset, hole, points, closed)
    animation = path_animation(checked, _FRAMES if frames is None else frames, width)
    with Progress(len(animation), quiet=quiet, things="frames") as progress:
        save_animation(animation, output, fps, overwrite, progress.advance)
    shown = frame_seconds(output, fps)
    if data is not None:
        save_frames(animation, data, shown, machine.unit, overwrite)
    if not quiet:
        total = len(animation) * shown
        click.echo(f"{output}: {len(animation)} frames, {total:.3g} s", err=True)


def _path(
    design: PlanarDesign,
    mode: str,
    circle: tuple[float, float, float] | None,
    inset: float | None,
    hole: int | None,
    points: Path | None,
    closed: bool,
) -> CheckedPath:
    """Return the path that was asked for, which can be followed.

    Raises
    ------
    InfeasiblePathError
        If it cannot be followed.
    InputError, FileError
        If there is no such path.
    """
    from fivebar_atlas.checked_paths import CheckedPath, usable_region
    from fivebar_atlas.closed_paths import circle_path, inset_path
    from fivebar_atlas.point_files import read_points

    if points is not None:
        corners = read_points(points, design.unit)
    elif circle is not None:
        corners = circle_path(*circle)
    else:
        margin = _INSET * design.factor if inset is None else inset
        corners = inset_path(usable_region(design, mode), margin, hole)
    checked = CheckedPath.of(design, corners, mode, close=closed or points is None)
    checked.require_feasible(numbered=points is not None)
    return checked
