"""Figures of the largest square workspace of Le, Kang and Doan: curve, square, configuration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fivebar_atlas.cli import options
from fivebar_atlas.cli.plot.group import check_outputs, data_option, figure_options, plot
from fivebar_atlas.cli.progress import Progress, note_compilation
from fivebar_atlas.cli.square_figures import (
    LINK_UNIT,
    draw_curve,
    draw_optimal_configuration,
    draw_square,
)
from fivebar_atlas.cli.square_options import (
    check_ratio,
    machine_lengths,
    parse_ratios,
    ratio_option,
    ratio_or_lengths_options,
    ratio_range_option,
    square_options,
    square_task,
)


@plot.command("square-curve", short_help="Draw the largest square over the ratio of links.")
@ratio_range_option
@square_options
@data_option
@figure_options
def curve(
    rho: str, output: Path, data: Path | None, width: float, overwrite: bool, **choices: Any
) -> None:
    """Draw the side of the largest square over the ratio of links, by what limits it.

    The links have the lengths l1 and l2, and half the base is l0 = (l2 - l1)/√2, for which
    there is an isotropic configuration. Sides are in lengths of l1.
    """
    from fivebar_atlas.figures.drawing_area import check_width
    from fivebar_atlas.figures.plotted_data import PlottedData, save_outputs
    from fivebar_atlas.synthesis.square_curve import square_curve

    check_outputs(output, data, overwrite)
    check_width(width)
    task = square_task(**choices)
    ratios = parse_ratios(rho)
    note_compilation()
    with Progress(len(ratios), things="ratios") as progress:
        found = square_curve(task, ratios, lambda *_: progress.advance(1))
    plotted = PlottedData()
    figure = draw_curve(task, found, width=width, data=plotted)
    save_outputs(figure, output, plotted, data, "", overwrite)


@plot.command("square", short_help="Draw the LCI in the largest square of a machine.")
@ratio_or_lengths_options
@square_options
@data_option
@figure_options
def square(
    rho: float | None,
    lengths: tuple[float, ...] | None,
    output: Path,
    data: Path | None,
    width: float,
    overwrite: bool,
    **choices: Any,
) -> None:
    """Draw the LCI in the largest square of a machine, with the maximal inscribed circle.

    The machine is given by its ratio of links, l0 = (l2 - l1)/√2, or by any three lengths.
    Exit code 1 where it has no square.
    """
    from fivebar_atlas.errors import InfeasibleSizeError
    from fivebar_atlas.figures.drawing_area import check_width
    from fivebar_atlas.figures.plotted_data import PlottedData, save_outputs
    from fivebar_atlas.synthesis.largest_square import largest_square, why_none

    check_outputs(output, data, overwrite)
    check_width(width)
    task = square_task(**choices)
    chosen = machine_lengths(task.mechanism, rho, lengths)
    note_compilation()
    found = largest_square(task, chosen)
    if found.side == 0.0:
        raise InfeasibleSizeError(why_none(found))
    plotted = PlottedData()
    figure = draw_square(found, width=width, data=plotted)
    save_outputs(figure, output, plotted, data, LINK_UNIT, overwrite)


@plot.command("optimal-configuration", short_help="Draw the linkage where it is isotropic.")
@ratio_option
@options.mechanism_option
@data_option
@figure_options
def optimal_configuration(
    rho: float,
    mechanism: str | None,
    output: Path,
    data: Path | None,
    width: float,
    overwrite: bool,
) -> None:
    """Draw the linkage in its optimal configuration, in which it is isotropic.

    Half the base is l0 = (l2 - l1)/√2, and the output point is at (0, (l1 + l2)/√2).
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.figures.drawing_area import check_width
    from fivebar_atlas.figures.plotted_data import PlottedData, save_outputs

    check_outputs(output, data, overwrite)
    check_width(width)
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    check_ratio(chosen, rho)
    note_compilation()
    plotted = PlottedData()
    figure = draw_optimal_configuration(chosen, rho, width=width, data=plotted)
    save_outputs(figure, output, plotted, data, LINK_UNIT, overwrite)
