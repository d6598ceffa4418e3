"""Atlases of small drawings all over the design space: singular loci, usable workspaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.plot.group import (
    Command,
    check_outputs,
    data_option,
    plot,
    sized_figure_options,
)

if TYPE_CHECKING:
    from fivebar_atlas.figures.design_cells import DesignCell
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.mechanisms.settings import Options

#: Takes a mechanism, a design space, a number and options; returns drawings and the title.
_Maker = Callable[["Mechanism", str, int, "Options"], tuple[Sequence["DesignCell"], str]]

# Two journal columns: the drawings are small.
_WIDTH = 170.0


def cell_options(command: Command) -> Command:
    """Add the design space, the number of drawings and what every figure has."""
    for option in (
        sized_figure_options(_WIDTH),
        data_option,
        options.mechanism_option,
        click.option(
            "--cells",
            type=int,
            metavar="N",
            help="About how many drawings, 12 to 400; 50 if not given.",
        ),
        options.space_option,
        options.set_option,
    ):
        command = option(command)
    return command


@plot.command("loci-atlas", short_help="Draw singular loci all over the design space.")
@click.option("--mode", metavar="MODE", help="Mode pair such as +-/up, or working mode such as +-.")
@cell_options
def loci_atlas(mode: str | None, **choices: Any) -> None:
    """Draw the singular loci of representative designs at their places in the design space.

    With --mode only the loci of that mode pair or working mode, otherwise those of all.
    """
    from fivebar_atlas.figures.design_cells import loci_cells, locus_mode
    from fivebar_atlas.figures.wording import mode_text

    def make(
        mechanism: Mechanism, space: str, cells: int, set_values: Options
    ) -> tuple[Sequence[DesignCell], str]:
        label = None if mode is None else locus_mode(mechanism, mode)
        modes = "all modes" if label is None else mode_text(label)
        return loci_cells(mechanism, space, label, cells, set_values), f"Singular loci, {modes}"

    _draw(make, **choices)


@plot.command("shape-atlas", short_help="Draw usable workspaces all over the design space.")
@options.one_mode_option
@cell_options
def shape_atlas(mode: str | None, **choices: Any) -> None:
    """Draw the usable workspaces of representative designs at their places in the design space."""
    from fivebar_atlas.figures.design_cells import shape_cells
    from fivebar_atlas.figures.wording import mode_text

    def make(
        mechanism: Mechanism, space: str, cells: int, set_values: Options
    ) -> tuple[Sequence[DesignCell], str]:
        label = mechanism.modes[0] if mode is None else mechanism.parse_mode(mode)
        title = f"Usable workspaces, {mode_text(label)}"
        return shape_cells(mechanism, space, label, cells, set_values), title

    _draw(make, **choices)


def _draw(
    make: _Maker,
    mechanism: str | None,
    space: str | None,
    cells: int | None,
    set_options: dict[str, object],
    output: Path,
    data: Path | None,
    width: float,
    overwrite: bool,
) -> None:
    """Draw and save one atlas and the coordinates in it."""
    from fivebar_atlas import mechanisms
    from fivebar_atlas.figures.cell_atlas import cell_atlas
    from fivebar_atlas.figures.design_cells import DEFAULT_CELLS, write_cells
    from fivebar_atlas.figures.drawing_area import check_width
    from fivebar_atlas.figures.saving import save_figure

    check_outputs(output, data, overwrite)
    check_width(width)
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    chosen_space = chosen.spaces[0] if space is None else chosen.parse_space(space)
    set_values = options.options_of(chosen, set_options)
    count = DEFAULT_CELLS if cells is None else cells
    drawn, title = make(chosen, chosen_space, count, set_values)
    if unusual := chosen.options_text(set_values, but_defaults=True):
        title = f"{title}, {unusual}"
    figure = cell_atlas(chosen.chart(chosen_space), drawn, title, width=width)
    save_figure(figure, output, overwrite)
    if data is not None:
        write_cells(data, chosen, drawn, overwrite)
    if cells not in (None, len(drawn)):
        click.echo(
            f"{len(drawn)} designs are drawn: the lattice nearest to {cells} that represents "
            "every sub-region",
            err=True,
        )
