"""``atlas design``: which machine for this practical workspace."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.machines_text import MachinesText
from fivebar_atlas.cli.presentation import Run, present
from fivebar_atlas.cli.progress import Progress, note_compilation
from fivebar_atlas.cli.shape_options import (
    DEFAULT_LCI,
    Units,
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

_SHAPES = ("--rectangle", "--circle", "--polygon")
_MOST_MACHINES = 20


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@options.mechanism_option
@shape_options
@threshold_option
@click.option(
    "--minimise",
    "--minimize",
    default="links",
    show_default=True,
    metavar="GOAL",
    help="What is to be smallest: links, footprint, error, torque or actuated-link.",
)
@options.mode_option
@click.option("--free", is_flag=True, help="Place the shape anywhere, not on the y axis only.")
@limit_options
@load_options
@click.option("--space", metavar="NAME", help="Design space that is searched; the largest one.")
@click.option(
    "--count",
    type=int,
    default=3,
    show_default=True,
    metavar="N",
    help="Machines to report, distinct from one another.",
)
@unit_option
@options.set_option
@options.json_option
@click.option(
    "-o", "--output", metavar="FILE.json", type=click.Path(path_type=Path), help="Write the JSON."
)
@options.overwrite_option
@options.quiet_option
def design(
    mechanism: str | None,
    rectangle: str | None,
    circle: str | None,
    polygon: str | None,
    clearance: str | None,
    lci: float | None,
    minimise: str,
    mode: tuple[str, ...] | None,
    free: bool,
    actuator_ranges: tuple[tuple[int, float, float], ...],
    link_ranges: tuple[tuple[str, float, float], ...],
    encoder_resolution: float | None,
    force: float | None,
    space: str | None,
    count: int,
    unit: str | None,
    set_options: dict[str, object],
    as_json: bool,
    output: Path | None,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Find the best machines for a practical workspace, over all designs and mode pairs.

    One of --rectangle, --circle and --polygon says what the machine is for; its LCI is nowhere
    in it below --lci. Reported are the best machines by --minimise: the sum of the moving
    links, the area of the box around linkage and workspace, the worst positioning error or
    joint torque over the workspace (--encoder-resolution and --force scale them), or the length
    of the actuated link. Containment is proved for every one of them.

    Exit codes: 0 done, 1 no machine keeps all limits, 2 wrong usage or wrong input.
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.output_file import check_output, checked_ending
    from fivebar_atlas.synthesis.best_machines import best_machines
    from fivebar_atlas.synthesis.machine_goals import (
        DEFAULT_FORCE,
        DEFAULT_RESOLUTION,
        goal_named,
    )
    from fivebar_atlas.synthesis.machine_search import MachineTask
    from fivebar_atlas.synthesis.placement import FREE, ON_AXIS

    if output is not None:
        checked_ending(output, ("json",))
        check_output(output, overwrite)
    given = [
        name
        for name, text in zip(_SHAPES, (rectangle, circle, polygon), strict=True)
        if text is not None
    ]
    if len(given) != 1:
        raise click.UsageError(f"give one of {', '.join(_SHAPES)}, not {len(given)} of them")
    if not 1 <= count <= _MOST_MACHINES:
        raise InputError("--count", count, f"a number from 1 to {_MOST_MACHINES}")
    check_loads(encoder_resolution, force)
    options.check_unit(unit)
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    threshold = DEFAULT_LCI if lci is None else lci
    chosen.check_thresholds([threshold], "--lci")
    resolution = None if encoder_resolution is None else math.radians(encoder_resolution)
    goal = goal_named(
        minimise,
        DEFAULT_RESOLUTION if resolution is None else resolution,
        DEFAULT_FORCE if force is None else force,
        "--minimise",
    )
    modes = chosen.parse_modes(mode or ("all",), "--mode")
    if space is not None:
        space = chosen.parse_space(space, "--space")
    set_values = options.options_of(chosen, set_options)
    ranges, limits = limits_given(actuator_ranges, link_ranges)
    units = Units(unit)
    shape = practical_shape(rectangle, circle, polygon, clearance, units)
    with options.as_typed(limit_names(link_ranges)):
        task = MachineTask(
            mechanism=chosen,
            shape=shape,
            goal=goal,
            modes=modes,
            lci_threshold=threshold,
            placement=FREE if free else ON_AXIS,
            ranges=tuple(ranges),
            limits=tuple(limits),
            unit=units.unit,
            space=space or "",
            options=set_values,
        )
    note_compilation()
    with _progress(quiet) as said:
        machines = best_machines(task, count, said)
    text = MachinesText(task, machines, resolution, force)
    present(Run.of(text), as_json, output, overwrite)


@contextlib.contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[str, int, int], None]]:
    """Give what takes note of progress, with a bar for every kind of things that are counted."""
    with contextlib.ExitStack() as stack:
        bars: dict[str, tuple[Progress, int]] = {}

        def said(things: str, done: int, total: int) -> None:
            if things not in bars:
                stack.close()
                bar = stack.enter_context(Progress(total, quiet=quiet, things=things))
                bars[things] = bar, 0
            bar, before = bars[things]
            bar.advance(done - before)
            bars[things] = bar, done

        yield said
