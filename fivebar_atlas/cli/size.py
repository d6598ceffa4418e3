"""``atlas size``: from a non-dimensional design and a practical workspace to a machine."""

from __future__ import annotations

import math
from pathlib import Path

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.machine_text import MachineText
from fivebar_atlas.cli.presentation import Run, present
from fivebar_atlas.cli.progress import note_compilation
from fivebar_atlas.cli.shape_options import (
    DEFAULT_LCI,
    Units,
    area_in,
    check_loads,
    limit_names,
    limit_options,
    limits_given,
    load_options,
    practical_shape,
    shape_options,
    threshold_option,
    unit_option,
)
from fivebar_atlas.errors import InputError

_SHAPES = ("--area", "--rectangle", "--circle", "--polygon")


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@options.lengths_argument
@options.mechanism_option
@options.one_mode_option
@threshold_option
@click.option("--area", metavar="AREA", help="Area of the good-condition workspace.")
@shape_options
@click.option("--free", is_flag=True, help="Place the shape anywhere, not on the y axis only.")
@click.option(
    "--offset", nargs=2, type=float, metavar="X Y", help="Place its centre there, in lengths."
)
@unit_option
@load_options
@limit_options
@click.option(
    "--factor-step", type=float, metavar="STEP", help="Round D up to a multiple of this length."
)
@options.set_option
@options.json_option
@click.option(
    "-o", "--output", metavar="FILE.json", type=click.Path(path_type=Path), help="Write the JSON."
)
@options.overwrite_option
def size(
    lengths: list[float],
    mechanism: str | None,
    mode: str | None,
    lci: float | None,
    area: str | None,
    rectangle: str | None,
    circle: str | None,
    polygon: str | None,
    clearance: str | None,
    free: bool,
    offset: tuple[float, float] | None,
    unit: str | None,
    encoder_resolution: float | None,
    force: float | None,
    actuator_ranges: tuple[tuple[int, float, float], ...],
    link_ranges: tuple[tuple[str, float, float], ...],
    factor_step: float | None,
    set_options: dict[str, object],
    as_json: bool,
    output: Path | None,
    overwrite: bool,
) -> None:
    """Size a machine for a practical workspace in which the LCI is nowhere too low.

    LENGTHS give a design by its proportions. One of --area, --rectangle, --circle and
    --polygon says what the machine is for; reported are the smallest machine, where the shape
    lies in it, and what inputs, errors and torques come to over the whole of it. Lengths may
    name their unit ("300x200mm"), which then is that of all.

    Exit codes: 0 done, 1 no size is possible, 2 wrong usage or wrong input.
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.output_file import check_is_no_input, check_output, checked_ending
    from fivebar_atlas.synthesis.placement import FREE, ON_AXIS
    from fivebar_atlas.synthesis.sizing import size_for_area, size_for_shape

    if output is not None:
        checked_ending(output, ("json",))
        if polygon is not None:
            check_is_no_input(output, Path(polygon))
        check_output(output, overwrite)
    given = [
        name
        for name, text in zip(_SHAPES, (area, rectangle, circle, polygon), strict=True)
        if text is not None
    ]
    if len(given) != 1:
        raise click.UsageError(f"give one of {', '.join(_SHAPES)}, not {len(given)} of them")
    if free and offset:
        raise click.UsageError("--free and --offset exclude each other")
    if area is not None and (free or offset or clearance is not None):
        raise click.UsageError("--free, --offset and --clearance go with a shape, not with --area")
    check_loads(encoder_resolution, force)
    if factor_step is not None and not (math.isfinite(factor_step) and factor_step > 0.0):
        raise InputError("--factor-step", factor_step, "a finite number above 0")
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    options.check_unit(unit)
    design = chosen.planar_design(lengths, "", options.options_of(chosen, set_options))
    pair = options.mode_pair(design, mode)
    threshold = DEFAULT_LCI if lci is None else lci
    chosen.check_thresholds([threshold], "--lci")
    ranges, limits = limits_given(actuator_ranges, link_ranges)
    units = Units(unit)
    digits = None
    typed = {
        "area": ("--area", area),
        "offset": ("--offset", options.typed(offset or ())),
        "factor step": ("--factor-step", options.typed([factor_step])),
        **limit_names(link_ranges),
    }
    with options.as_typed(typed):
        if area is not None:
            squares, digits = area_in(area, units)
            note_compilation()
            machine = size_for_area(
                design,
                squares,
                pair,
                threshold,
                unit=units.unit,
                ranges=ranges,
                limits=limits,
                factor_step=factor_step,
            )
        else:
            shape = practical_shape(rectangle, circle, polygon, clearance, units)
            note_compilation()
            machine = size_for_shape(
                design,
                shape,
                pair,
                threshold,
                unit=units.unit,
                placement=offset or (FREE if free else ON_AXIS),
                ranges=ranges,
                limits=limits,
                factor_step=factor_step,
            )
    resolution = None if encoder_resolution is None else math.radians(encoder_resolution)
    text = MachineText(machine, resolution, force, digits)
    present(Run.of(text), as_json, output, overwrite)
