"""Figures of one design: the linkage, its singular loci, its workspaces, its conditioning."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.plot import space
from fivebar_atlas.cli.plot.group import Command, check_outputs, data_option, figure_options, plot
from fivebar_atlas.cli.progress import note_compilation
from fivebar_atlas.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.planar import PlanarDesign, Pose

Pair = tuple[float, float]


def _one_design(command: Command) -> Command:
    """Add what every figure of one design has: the design, the outputs, the width."""
    return options.design_options(data_option(figure_options(command)))


def _levels(
    ctx: click.Context,  # noqa: ARG001
    parameter: click.Parameter,  # noqa: ARG001
    text: str | None,
) -> list[float] | None:
    """Return numbers separated by commas."""
    if text is None:
        return None
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise click.BadParameter(f"{text!r} is not numbers separated by commas.") from None


def _check_threshold(design: PlanarDesign, lci: float) -> None:
    """Refuse a threshold out of range under the name it was given by."""
    from fivebar_atlas import mechanisms

    mechanisms.get(design.mechanism).check_thresholds([lci], "--lci")


def _note_what_is_empty(design: PlanarDesign, mode: str, lci: float | None = None) -> None:
    """Say on standard error where there is no usable or no good-condition workspace."""
    from fivebar_atlas.figures.workspace_figure import below_threshold

    if design.usable_workspace(mode) is None:
        click.echo(f"the usable workspace of {mode} is empty; singular loci are drawn", err=True)
    elif lci is not None and not design.good_condition_workspace(lci, mode):
        click.echo(below_threshold(design, mode, lci), err=True)


@contextlib.contextmanager
def _under_the_name_of(option: str, value: Any) -> Iterator[None]:
    """Refuse a position or inputs by the option and in the numbers that the user gave."""
    try:
        yield
    except UnknownNameError:
        raise
    except InputError as error:
        raise InputError(option, value, error.allowed) from None


def _poses(
    design: PlanarDesign,
    mode: str | None,
    at: Pair | None,
    inputs: Pair | None,
    all_solutions: bool,
) -> Sequence[Pose]:
    """Return the poses to draw."""
    from fivebar_atlas.figures.linkage import sample_pose

    if inputs is not None:
        with _under_the_name_of("--inputs", inputs):
            poses = design.forward_poses([math.radians(angle) for angle in inputs])
        return poses if all_solutions else [_in_mode(design, poses, mode)]
    if at is None:
        pair = options.mode_pair(design, mode)
        workspace = design.usable_workspace(pair)
        if workspace is None:
            allowed = "a mode pair that has a usable workspace, or --at X Y for a pose elsewhere"
            raise InputError("--mode", pair, allowed)
        pose = sample_pose(design, workspace.region, pair)
        return design.inverse_poses(*pose.output) if all_solutions else [pose]
    if not all(math.isfinite(part) for part in at):
        raise InputError("--at", at, "two finite numbers")
    with _under_the_name_of("--at", at):
        if all_solutions or mode is None:
            poses = design.inverse_poses(*at)
            return poses if all_solutions else poses[:1]
        return [design.pose(*at, mode)]


def _in_mode(design: PlanarDesign, poses: Sequence[Pose], mode: str | None) -> Pose:
    """Return the pose in a mode pair, the first if none is named."""
    if mode is None:
        return poses[0]
    pair = options.mode_pair(design, mode)
    for pose in poses:
        if pose.mode == pair:
            return pose
    raise InputError("--mode", mode, f"one of {', '.join(pose.mode for pose in poses)}")


@plot.command("mechanism", context_settings=options.NEGATIVE_NUMBERS)
@_one_design
@click.option("--at", nargs=2, type=float, metavar="X Y", help="Position of the output point.")
@click.option(
    "--inputs", nargs=2, type=float, metavar="ANGLE ANGLE", help="Input angles in degrees."
)
@click.option("--mode", metavar="MODE", help="Mode pair, or with --at a working mode alone.")
@click.option("--all", "all_solutions", is_flag=True, help="Draw all solutions side by side.")
@space.pose_option
@space.solve_option
@space.view_option
def mechanism(
    at: Pair | None,
    inputs: Pair | None,
    mode: str | None,
    all_solutions: bool,
    pose: tuple[float, ...] | None,
    solve: str | None,
    view: Pair | None,
    **choices: Any,
) -> None:
    """Draw the linkage in a pose, with joints, links and input angles named.

    Its output point is in the middle of the largest inscribed circle unless --at or --inputs
    say where. With --all all solutions of the inverse kinematics are drawn, or with --inputs
    of the forward kinematics.

    A mechanism whose platform moves in space is drawn obliquely, at home unless --pose says
    otherwise; its limb lengths and indices are below.
    """
    from fivebar_atlas.figures.linkage_figure import linkage_figure

    if space.is_spatial(choices["mechanism"]):
        planar = {"--at": at, "--inputs": inputs, "--mode": mode, "--all": all_solutions}
        space.refuse(planar, "a plane")
        space.draw_pose(pose, solve, view, **choices)
        return
    space.refuse({"--pose": pose, "--solve": solve, "--view": view}, "space")
    if at is not None and inputs is not None:
        raise click.UsageError("--at and --inputs exclude each other")
    if all_solutions and mode is not None and (at is not None or inputs is not None):
        raise click.UsageError("--all draws every mode; --mode excludes it")

    def make(design: PlanarDesign, **drawing: Any) -> Any:
        return linkage_figure(design, _poses(design, mode, at, inputs, all_solutions), **drawing)

    _draw(make, **choices)


@plot.command("loci", context_settings=options.NEGATIVE_NUMBERS)
@_one_design
@click.option("--mode", metavar="MODE", help="Mode pair or working mode, for its loci only.")
def loci(mode: str | None, **choices: Any) -> None:
    """Draw the singular loci of a design, all or those of one mode."""
    from fivebar_atlas.figures.loci_figure import loci_figure

    def make(design: PlanarDesign, **drawing: Any) -> Any:
        return loci_figure(design, mode, **drawing)

    _draw(make, **choices)


@plot.command("workspace", context_settings=options.NEGATIVE_NUMBERS)
@_one_design
@options.one_mode_option
@space.section_option
@space.surface_option
@space.orientation_option
@space.view_option
def workspace(
    mode: str | None,
    sections: tuple[str, ...],
    surface: bool,
    orientation: Pair | None,
    view: Pair | None,
    **choices: Any,
) -> None:
    """Draw the usable workspace, what bounds it, and the linkage in it.

    Boundary arcs are named and drawn by kind of singularity; maximal inscribed circles are
    dotted.

    Of a mechanism whose platform moves in space the workspace at a fixed orientation is drawn, as
    plane sections or as a surface, in the colours of the limits that bound it.
    """
    from fivebar_atlas.figures.workspace_figure import workspace_figure

    if space.is_spatial(choices["mechanism"]):
        space.refuse({"--mode": mode}, "a plane")
        space.draw_workspace(sections, surface, orientation, view, **choices)
        return
    spatial = {"--section": sections, "--surface": surface, "--orientation": orientation}
    space.refuse({**spatial, "--view": view}, "space")

    def make(design: PlanarDesign, **drawing: Any) -> Any:
        pair = options.mode_pair(design, mode)
        figure = workspace_figure(design, pair, **drawing)
        _note_what_is_empty(design, pair)
        return figure

    _draw(make, **choices)


@plot.command("good-condition", context_settings=options.NEGATIVE_NUMBERS)
@_one_design
@options.one_mode_option
@click.option(
    "--lci",
    type=float,
    default=0.5,
    show_default=True,
    metavar="THRESHOLD",
    help="LCI threshold, above 0 and below 1.",
)
def good_condition(mode: str | None, lci: float, **choices: Any) -> None:
    """Draw the part of the usable workspace where the LCI reaches a threshold."""
    from fivebar_atlas.figures.workspace_figure import good_condition_figure

    def make(design: PlanarDesign, **drawing: Any) -> Any:
        pair = options.mode_pair(design, mode)
        _check_threshold(design, lci)
        figure = good_condition_figure(design, pair, lci, **drawing)
        _note_what_is_empty(design, pair, lci)
        return figure

    _draw(make, **choices)


@plot.command("lci", context_settings=options.NEGATIVE_NUMBERS)
@_one_design
@options.one_mode_option
@click.option(
    "--lci",
    type=float,
    metavar="THRESHOLD",
    help="Only where the LCI reaches this, above 0 and below 1.",
)
@click.option(
    "--levels",
    callback=_levels,
    metavar="VALUES",
    help="Contours, such as 0.25,0.5,0.75; round ones if not given.",
)
def lci_map(
    mode: str | None, lci: float | None, levels: list[float] | None, **choices: Any
) -> None:
    """Draw the local conditioning index (LCI) over the usable workspace.

    With --lci over the good-condition workspace.
    """
    from fivebar_atlas.figures.lci_figure import lci_figure

    def make(design: PlanarDesign, **drawing: Any) -> Any:
        pair = options.mode_pair(design, mode)
        if lci is not None:
            _check_threshold(design, lci)
        figure = lci_figure(design, pair, lci, levels, **drawing)
        _note_what_is_empty(design, pair, lci)
        return figure

    _draw(make, **choices)


@plot.command("limits", context_settings=options.NEGATIVE_NUMBERS)
@_one_design
@options.one_mode_option
@click.option(
    "--count",
    type=click.IntRange(2, 100_000),
    default=361,
    show_default=True,
    metavar="N",
    help="Values of the coordinate.",
)
def limits(mode: str | None, count: int, **choices: Any) -> None:
    """Draw the operating limits of the actuators.

    For each input its least and its greatest value over the usable workspace, as functions of
    a coordinate of the mechanism.
    """
    from fivebar_atlas.figures.limits_figure import limits_figure

    def make(design: PlanarDesign, **drawing: Any) -> Any:
        return limits_figure(design, options.mode_pair(design, mode), count, **drawing)

    _draw(make, **choices)


def _draw(
    make: Callable[..., Any],
    output: Path,
    data: Path | None,
    width: float,
    overwrite: bool,
    **design_choices: Any,
) -> None:
    """Draw and save one figure and the coordinates in it.

    ``make`` takes the design, the width and what plotted data are added to, and returns the
    figure.
    """
    from fivebar_atlas.figures.drawing_area import check_width
    from fivebar_atlas.figures.plotted_data import PlottedData, save_outputs

    check_outputs(output, data, overwrite)
    check_width(width)
    design = options.planar_design(**design_choices)
    note_compilation()
    plotted = PlottedData()
    figure = make(design, width=width, data=plotted)
    save_outputs(figure, output, plotted, data, design.unit, overwrite)
