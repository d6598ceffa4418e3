"""Figures of a result file: maps of stored quantities, optimum regions, the design space."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.optimum_figures import draw_front, draw_region
from fivebar_atlas.cli.plot.group import Command, figure_options, plot
from fivebar_atlas.errors import InputError

#: Kinds that show one quantity of a file: name, the quantity, and what it is.
_QUANTITY_KINDS = {
    "area": ("usable_workspace_area", "Atlas of the usable workspace area."),
    "gci": ("gci", "Atlas of the global conditioning index (GCI)."),
    "share": ("usable_share", "Atlas of the usable share of the pose box."),
    "volume": ("workspace_volume", "Atlas of the workspace volume at a fixed orientation."),
}


def file_options(command: Command) -> Command:
    """Add the result file and the choice of mode pair and threshold."""
    for option in (
        click.option(
            "--lci",
            type=float,
            metavar="THRESHOLD",
            help="LCI threshold, where the file holds several.",
        ),
        click.option(
            "--mode", metavar="MODE", help="Mode pair, such as +-/up, where the file holds several."
        ),
        options.file_argument,
    ):
        command = option(command)
    return command


@plot.command("design-space")
@click.argument("file", metavar="[FILE.h5]", required=False, type=click.Path())
@options.mechanism_option
@options.space_option
@figure_options
def design_space(
    file: str | None,
    mechanism: str | None,
    space: str | None,
    output: Path,
    width: float,
    overwrite: bool,
) -> None:
    """Draw the design space with its sub-regions.

    The design space is that of FILE, or the one named by --mechanism and --space.
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.figures.design_space import design_space_figure
    from fivebar_atlas.figures.saving import check_figure_output, save_figure
    from fivebar_atlas.output_file import check_is_no_input
    from fivebar_atlas.store import open_atlas

    check_figure_output(output, overwrite)
    if file is not None:
        check_is_no_input(output, Path(file))
    if file is not None:
        with open_atlas(file) as atlas:
            stored = atlas.settings
        if mechanism not in (None, stored.mechanism):
            raise InputError("--mechanism", mechanism, f"{stored.mechanism!r}, that of {file}")
        mechanism = stored.mechanism
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    drawn = None if space is None else chosen.parse_space(space, "--space")
    if file is not None:
        if drawn not in (None, stored.space):
            raise InputError("--space", space, f"{stored.space!r}, that of {file}")
        drawn = stored.space
    drawn = drawn or chosen.spaces[0]
    name = f" ({drawn})" if drawn in chosen.spaces else ""
    title = f"Design space of {chosen.name}{name}"
    figure = design_space_figure(chosen.chart(drawn), title, width=width)
    save_figure(figure, output, overwrite)


def _draw_quantity(name: str, **choices: Any) -> None:
    from fivebar_atlas.figures.atlas_figures import quantity_figure

    _draw(quantity_figure, name, **choices)


def _draw(
    make: Callable[..., Any],
    name: str,
    file: str,
    mode: str | None,
    lci: float | None,
    output: Path,
    width: float,
    overwrite: bool,
    **drawing: Any,
) -> None:
    """Draw and save a figure of one stored quantity; ``make`` takes atlas, name and choices."""
    from fivebar_atlas.figures.saving import check_figure_output, save_figure
    from fivebar_atlas.output_file import check_is_no_input
    from fivebar_atlas.store import open_atlas

    check_figure_output(output, overwrite)
    check_is_no_input(output, Path(file))
    with open_atlas(file) as atlas, options.asked_to_choose():
        figure = make(atlas, name, mode, lci, width=width, **drawing)
    save_figure(figure, output, overwrite)


@plot.command("quantity", short_help="Draw any stored quantity.")
@click.argument("name")
@file_options
@figure_options
def quantity(name: str, **choices: Any) -> None:
    """Draw any stored quantity NAME, an error estimate or a category.

    Errors are drawn on a logarithmic scale, categories such as status in colours of their
    own.
    """
    _draw_quantity(name, **choices)


@plot.command("surface", short_help="Draw any stored quantity as a surface.")
@click.argument("name")
@file_options
@click.option(
    "--elevation",
    type=float,
    default=25.0,
    show_default=True,
    metavar="DEG",
    help="Angle of the line of sight above the plane of the design space, from 5 to 80.",
)
@click.option(
    "--azimuth",
    type=float,
    default=-65.0,
    show_default=True,
    metavar="DEG",
    help="Where the viewer stands, counter-clockwise from the right; -90 is in front.",
)
@figure_options
def surface(name: str, **choices: Any) -> None:
    """Draw any stored quantity NAME as a surface above the design space.

    Its contours are drawn on the floor below. Errors are drawn on a logarithmic scale.
    """
    from fivebar_atlas.figures.atlas_figures import surface_figure

    _draw(surface_figure, name, **choices)


def _add_quantity_kind(kind: str, name: str, meaning: str) -> None:
    @plot.command(kind, help=meaning)
    @file_options
    @figure_options
    def _command(**choices: Any) -> None:
        _draw_quantity(name, **choices)


for _kind, (_name, _meaning) in _QUANTITY_KINDS.items():
    _add_quantity_kind(_kind, _name, _meaning)


@plot.command("region")
@click.option(
    "--where",
    "wheres",
    multiple=True,
    required=True,
    metavar="CONDITION",
    help="A condition such as 'gci>=0.62'; all that are given must hold.",
)
@file_options
@figure_options
def region(
    wheres: tuple[str, ...],
    file: str,
    mode: str | None,
    lci: float | None,
    output: Path,
    width: float,
    overwrite: bool,
) -> None:
    """Draw the optimum region of any conditions over contours of two quantities.

    They are how large usable workspaces are and how good, such as area and GCI.

    Prints the range of every parameter in the region.
    """
    from fivebar_atlas.figures.saving import check_figure_output, save_figure
    from fivebar_atlas.output_file import check_is_no_input
    from fivebar_atlas.store import open_atlas
    from fivebar_atlas.synthesis.candidates import Candidates
    from fivebar_atlas.synthesis.conditions import (
        check_conditions,
        check_contradictions,
        parse_condition,
    )
    from fivebar_atlas.synthesis.empty_region import check_not_empty

    check_figure_output(output, overwrite)
    check_is_no_input(output, Path(file))
    conditions = [parse_condition(where) for where in wheres]
    with open_atlas(file) as atlas, options.asked_to_choose():
        check_conditions(conditions, atlas)
        check_contradictions(conditions)
        candidates = Candidates(atlas, conditions, mode, lci)
        check_not_empty(candidates)
        found = candidates.region
        figure = draw_region(atlas, found.region, conditions, mode, lci, width=width)
        parameters = atlas.mechanism.parameters
    save_figure(figure, output, overwrite)
    together = ", ".join(str(condition) for condition in conditions)
    if found.region.is_empty:
        click.echo(
            f"the region {together} is empty: {found.lattice_designs} designs of the lattice "
            "fulfil it, and nothing between them",
            err=True,
        )
        return
    click.echo(f"{together}: {100.0 * found.share:.3g} % of the design space")
    for parameter, least, greatest in zip(parameters, found.least, found.greatest, strict=True):
        click.echo(f"{parameter.name} from {least:.4f} to {greatest:.4f}")


@plot.command("pareto")
@click.option(
    "--pareto",
    "quantities",
    required=True,
    metavar="A,B",
    help="Two quantities, such as 'usable_workspace_area,gci'; '-NAME' or 'NAME:min' for less.",
)
@click.option(
    "--where", "wheres", multiple=True, metavar="CONDITION", help="A condition; repeatable."
)
@click.option("--polish", is_flag=True, help="Move the members onto the true front.")
@click.option("--designs", is_flag=True, help="Draw where the members lie in the design space.")
@file_options
@figure_options
def pareto(
    quantities: str,
    wheres: tuple[str, ...],
    polish: bool,
    designs: bool,
    file: str,
    mode: str | None,
    lci: float | None,
    output: Path,
    width: float,
    overwrite: bool,
) -> None:
    """Draw the Pareto front of two quantities over the values of all designs.

    With --designs, where its members lie in the design space.
    """
    from fivebar_atlas.figures.saving import check_figure_output, save_figure
    from fivebar_atlas.output_file import check_is_no_input
    from fivebar_atlas.store import open_atlas
    from fivebar_atlas.synthesis.candidates import Candidates
    from fivebar_atlas.synthesis.conditions import (
        check_conditions,
        check_contradictions,
        condition_names,
        parse_condition,
    )
    from fivebar_atlas.synthesis.empty_region import check_not_empty
    from fivebar_atlas.synthesis.objectives import parse_directions
    from fivebar_atlas.synthesis.pareto import pareto_front, polished_front

    check_figure_output(output, overwrite)
    check_is_no_input(output, Path(file))
    conditions = [parse_condition(where) for where in wheres]
    with open_atlas(file) as atlas, options.asked_to_choose():
        check_conditions(conditions, atlas)
        check_contradictions(conditions)
        known = condition_names(atlas)
        directions = parse_directions(quantities, known, "--pareto", atlas.unknown)
        if len(directions) != 2:
            raise InputError("--pareto", quantities, "two quantities, the axes of the figure")
        candidates = Candidates(atlas, conditions, mode, lci)
        check_not_empty(candidates)
        front = pareto_front(candidates, directions)
        if polish:
            front = polished_front(candidates, front)
        figure = draw_front(candidates, front, designs, width=width)
    save_figure(figure, output, overwrite)
    click.echo(f"{len(front.designs)} of {front.candidates} designs are on the front")
