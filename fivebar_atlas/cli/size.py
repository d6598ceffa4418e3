"""``atlas size``: from a non-dimensional design and a practical workspace to a machine."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.machine_text import MachineText
from fivebar_atlas.cli.presentation import Run, present
from fivebar_atlas.cli.progress import note_compilation
from fivebar_atlas.errors import InputError

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.shapes import Shape

_DEFAULT_LCI, _DEFAULT_UNIT = 0.5, "mm"
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([^\W\d_]*)\s*")
_AREA = re.compile(rf"\s*({_NUMBER})\s*(?:([^\W\d_]+)(?:\^?2|²))?\s*")
_SIDES = re.compile(rf"\s*({_NUMBER})\s*([^\W\d_]*?)\s*[x×X]\s*({_NUMBER})\s*([^\W\d_]*)\s*")
_SHAPES = ("--area", "--rectangle", "--circle", "--polygon")


class _Units:
    """The one unit of everything given, which any of it may name."""

    def __init__(self, unit: str | None) -> None:
        self._unit, self._source = unit, "--unit"

    @property
    def unit(self) -> str:
        return self._unit or _DEFAULT_UNIT

    def note(self, option: str, text: str, unit: str | None) -> None:
        """Take note of a unit, if there is one."""
        if unit and self._unit and unit != self._unit:
            allowed = f"one unit for all lengths, and {self._source} says {self._unit}"
            raise InputError(option, text, allowed)
        if unit and not self._unit:
            self._unit, self._source = unit, option


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@options.lengths_argument
@options.mechanism_option
@options.one_mode_option
@click.option(
    "--lci",
    type=float,
    metavar="VALUE",
    help=f"LCI threshold, above 0 and below 1; {_DEFAULT_LCI:g} if not given.",
)
@click.option("--area", metavar="AREA", help="Area of the good-condition workspace.")
@click.option("--rectangle", metavar="WxH", help="Rectangle with sides parallel to the axes.")
@click.option("--circle", metavar="DIAMETER", help="Circle.")
@click.option(
    "--polygon", metavar="FILE", help="Polygon: a CSV table of corners, or WKT; no holes."
)
@click.option("--clearance", metavar="C", help="Distance kept around the shape.")
@click.option("--free", is_flag=True, help="Place the shape anywhere, not on the y axis only.")
@click.option(
    "--offset", nargs=2, type=float, metavar="X Y", help="Place its centre there, in lengths."
)
@click.option(
    "--unit", metavar="UNIT", help=f"Unit of all lengths; {_DEFAULT_UNIT} if none is named."
)
@click.option(
    "--encoder-resolution",
    type=float,
    metavar="DEG",
    help="Error of the encoders, either way, in degrees: reports the worst positioning error.",
)
@click.option(
    "--force",
    type=float,
    metavar="N",
    help="Force on the output point in newtons: reports the worst joint torque.",
)
@click.option(
    "--actuator-range",
    "actuator_ranges",
    nargs=3,
    type=(int, float, float),
    multiple=True,
    metavar="I MIN MAX",
    help="Range of θI in degrees; repeatable.",
)
@click.option(
    "--link-range",
    "link_ranges",
    nargs=3,
    type=(str, float, float),
    multiple=True,
    metavar="NAME MIN MAX",
    help="Limits of a length, such as R2 100 250; repeatable; 'inf' is no limit.",
)
@click.option(
    "--factor-step", type=float, metavar="STEP", help="Round D up to a multiple of this length."
)
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
    as_json: bool,
    output: Path | None,
    overwrite: bool,
) -> None:
    """Size a machine for a practical workspace in which the LCI is nowhere too low.

    R1 R2 R3 give a design by its proportions. One of --area, --rectangle, --circle and
    --polygon says what the machine is for; reported are the smallest machine, where the shape
    lies in it, and what inputs, errors and torques come to over the whole of it. Lengths may
    name their unit ("300x200mm"), which then is that of all.

    Exit codes: 0 done, 1 no size is possible, 2 wrong usage or wrong input.
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.output_file import check_is_no_input, check_output, checked_ending
    from fivebar_atlas.synthesis.containment import ActuatorRange
    from fivebar_atlas.synthesis.link_limits import LinkLimit
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
    for name, value in (
        ("--encoder-resolution", encoder_resolution),
        ("--force", force),
        ("--factor-step", factor_step),
    ):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "a finite number above 0")
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    options.check_unit(unit)
    design = chosen.planar_design(lengths, "")
    pair = options.mode_pair(design, mode)
    threshold = _DEFAULT_LCI if lci is None else lci
    chosen.check_thresholds([threshold], "--lci")
    ranges, limits = [], []
    typed: dict[str, tuple[str, str | None]] = {
        "area": ("--area", area),
        "rectangle": ("--rectangle", rectangle),
        "circle": ("--circle", circle),
        "clearance": ("--clearance", clearance),
        "offset": ("--offset", _typed(offset or ())),
        "factor step": ("--factor-step", _typed([factor_step])),
        "actuator range": ("--actuator-range", None),
        "link limit": ("--link-range", None),
    }
    for number, *angles in actuator_ranges:
        one = {"actuator range": ("--actuator-range", _typed((number, *angles)))}
        with options.as_typed(one):
            ranges.append(ActuatorRange(number, *map(math.radians, angles)))
    for limit in link_ranges:
        typed[f"limits of {limit[0]}"] = ("--link-range", _typed(limit))
        with options.as_typed(typed):
            limits.append(LinkLimit(*limit))
    units = _Units(unit)
    shown = None
    with options.as_typed(typed):
        if area is not None:
            squares, shown = _area(area, units)
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
            shape = _shape(rectangle, circle, polygon, clearance, units)
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
    text = MachineText(machine, resolution, force, shown)
    run = Run(
        title=text.title,
        summary=text.summary,
        document=lambda: machine.document(resolution, force),
        lines=text.lines,
        sections=text.sections,
        figures=text.figures,
    )
    present(run, as_json, output, overwrite)


def _shape(
    rectangle: str | None,
    circle: str | None,
    polygon: str | None,
    clearance: str | None,
    units: _Units,
) -> Shape:
    """Return the shape that is asked for."""
    from fivebar_atlas.synthesis.shapes import Shape, read_polygon

    gap = 0.0
    if clearance is not None:
        gap = _length("--clearance", clearance, units)
        if not gap >= 0.0:
            raise InputError("--clearance", clearance, "a length of 0 or more")
    if rectangle is not None:
        sides = _SIDES.fullmatch(rectangle)
        allowed = "two lengths above 0 such as 300x200 or 300x200mm"
        if sides is None:
            raise InputError("--rectangle", rectangle, allowed)
        width, width_unit, height, height_unit = sides.groups()
        units.note("--rectangle", rectangle, width_unit)
        units.note("--rectangle", rectangle, height_unit)
        if not (0.0 < float(width) < math.inf and 0.0 < float(height) < math.inf):
            raise InputError("--rectangle", rectangle, allowed)
        return Shape.rectangle(float(width), float(height), gap)
    if circle is not None:
        diameter = _length("--circle", circle, units)
        if not diameter > 0.0:
            raise InputError("--circle", circle, "a diameter above 0")
        return Shape.circle(diameter, gap)
    assert polygon is not None
    return read_polygon(polygon, units.unit, gap)


def _length(option: str, text: str, units: _Units) -> float:
    """Return a length, and take note of its unit."""
    found = _LENGTH.fullmatch(text)
    if found is None or not math.isfinite(float(found[1])):
        raise InputError(option, text, "a length such as 20 or 20mm")
    units.note(option, text, found[2])
    return float(found[1])


def _typed(values: Iterable[object]) -> str:
    """Return the values of an option as they may have been typed."""
    shown = (f"{value:g}" if isinstance(value, float) else str(value) for value in values)
    return " ".join(shown)


def _area(text: str, units: _Units) -> tuple[float, str]:
    """Return an area and its digits, and take note of the unit that it is in squares of."""
    found = _AREA.fullmatch(text)
    if found is None or not 0.0 < float(found[1]) < math.inf:
        raise InputError("--area", text, "an area above 0 such as 400 or 400mm2")
    units.note("--area", text, found[2])
    return float(found[1]), found[1]
