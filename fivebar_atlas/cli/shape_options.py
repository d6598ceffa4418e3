"""The options of commands that make a machine for a practical workspace, each defined once.

Lengths may name their unit ("300x200mm"), which then is that of everything given.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

import click

from fivebar_atlas.cli.options import as_typed, together, typed
from fivebar_atlas.errors import InputError

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.containment import ActuatorRange
    from fivebar_atlas.synthesis.link_limits import LinkLimit
    from fivebar_atlas.synthesis.shapes import Shape

#: LCI threshold and unit where nothing is said.
DEFAULT_LCI, DEFAULT_UNIT = 0.5, "mm"

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([^\W\d_]*)\s*")
_AREA = re.compile(rf"\s*({_NUMBER})\s*(?:([^\W\d_]+)(?:\^?2|²))?\s*")
_SIDES = re.compile(rf"\s*({_NUMBER})\s*([^\W\d_]*?)\s*[x×X]\s*({_NUMBER})\s*([^\W\d_]*)\s*")

shape_options = together(
    click.option("--rectangle", metavar="WxH", help="Rectangle with sides parallel to the axes."),
    click.option("--circle", metavar="DIAMETER", help="Circle."),
    click.option(
        "--polygon", metavar="FILE", help="Polygon: a CSV table of corners, or WKT; no holes."
    ),
    click.option("--clearance", metavar="C", help="Distance kept around the shape."),
)
unit_option = click.option(
    "--unit", metavar="UNIT", help=f"Unit of all lengths; {DEFAULT_UNIT} if none is named."
)
threshold_option = click.option(
    "--lci",
    type=float,
    metavar="VALUE",
    help=f"LCI threshold, above 0 and below 1; {DEFAULT_LCI:g} if not given.",
)
load_options = together(
    click.option(
        "--encoder-resolution",
        type=float,
        metavar="DEG",
        help="Error of the encoders, either way, in degrees: reports the worst positioning error.",
    ),
    click.option(
        "--force",
        type=float,
        metavar="N",
        help="Force on the output point in newtons: reports the worst joint torque.",
    ),
)
actuator_range_option = click.option(
    "--actuator-range",
    "actuator_ranges",
    nargs=3,
    type=(int, float, float),
    multiple=True,
    metavar="I MIN MAX",
    help="Range of input I, from 1, in degrees; repeatable.",
)
limit_options = together(
    actuator_range_option,
    click.option(
        "--link-range",
        "link_ranges",
        nargs=3,
        type=(str, float, float),
        multiple=True,
        metavar="NAME MIN MAX",
        help="Limits of a length of the machine; repeatable; 'inf' is no limit.",
    ),
)


class Units:
    """The one unit of everything given, which any of it may name."""

    def __init__(self, unit: str | None) -> None:
        self._unit, self._source = unit, "--unit"

    @property
    def unit(self) -> str:
        """The unit."""
        return self._unit or DEFAULT_UNIT

    def note(self, option: str, text: str, unit: str | None) -> None:
        """Take note of a unit, if there is one."""
        if unit and self._unit and unit != self._unit:
            allowed = f"one unit for all lengths, and {self._source} says {self._unit}"
            raise InputError(option, text, allowed)
        if unit and not self._unit:
            self._unit, self._source = unit, option


def practical_shape(
    rectangle: str | None,
    circle: str | None,
    polygon: str | None,
    clearance: str | None,
    units: Units,
) -> Shape:
    """Return the shape that the values of ``shape_options``, of which one is given, stand for.

    Raises
    ------
    InputError
        If a length is not one, or names another unit than others do.
    FileUsageError, FileError
        If there is no such polygon.
    """
    from fivebar_atlas.synthesis.shapes import Shape, read_polygon

    gap = 0.0
    if clearance is not None:
        gap = length_in("--clearance", clearance, units)
        if not gap >= 0.0:
            raise InputError("--clearance", clearance, "a length of 0 or more")
    names = {
        "rectangle": ("--rectangle", rectangle),
        "circle": ("--circle", circle),
        "clearance": ("--clearance", clearance),
    }
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
        with as_typed(names):
            return Shape.rectangle(float(width), float(height), gap)
    if circle is not None:
        diameter = length_in("--circle", circle, units)
        if not diameter > 0.0:
            raise InputError("--circle", circle, "a diameter above 0")
        with as_typed(names):
            return Shape.circle(diameter, gap)
    assert polygon is not None
    with as_typed(names):
        return read_polygon(polygon, units.unit, gap)


def length_in(option: str, text: str, units: Units) -> float:
    """Return a length, and take note of its unit."""
    found = _LENGTH.fullmatch(text)
    if found is None or not math.isfinite(float(found[1])):
        raise InputError(option, text, "a length such as 20 or 20mm")
    units.note(option, text, found[2])
    return float(found[1])


def area_in(text: str, units: Units) -> tuple[float, str]:
    """Return an area and its digits, and take note of the unit that it is in squares of."""
    found = _AREA.fullmatch(text)
    if found is None or not 0.0 < float(found[1]) < math.inf:
        raise InputError("--area", text, "an area above 0 such as 400 or 400mm2")
    units.note("--area", text, found[2])
    return float(found[1]), found[1]


def check_loads(resolution: float | None, force: float | None) -> None:
    """Raise InputError unless the values of ``load_options`` are positive and finite."""
    for name, value in (("--encoder-resolution", resolution), ("--force", force)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "a finite number above 0")


def limits_given(
    actuator_ranges: tuple[tuple[int, float, float], ...],
    link_ranges: tuple[tuple[str, float, float], ...],
) -> tuple[list[ActuatorRange], list[LinkLimit]]:
    """Return the values of ``limit_options`` as ranges and limits.

    Raises
    ------
    InputError
        If a range is the wrong way round or not finite, or a length negative.
    """
    from fivebar_atlas.synthesis.containment import ActuatorRange
    from fivebar_atlas.synthesis.link_limits import LinkLimit

    ranges = []
    for number, *angles in actuator_ranges:
        with as_typed({"actuator range": ("--actuator-range", typed((number, *angles)))}):
            ranges.append(ActuatorRange(number, *map(math.radians, angles)))
    with as_typed(limit_names(link_ranges)):
        return ranges, [LinkLimit(*limit) for limit in link_ranges]


def limit_names(
    link_ranges: tuple[tuple[str, float, float], ...],
) -> dict[str, tuple[str, str | None]]:
    """Return how the values of ``limit_options`` were typed, for :func:`options.as_typed`."""
    names: dict[str, tuple[str, str | None]] = {
        "actuator range": ("--actuator-range", None),
        "link limit": ("--link-range", None),
    }
    for limit in link_ranges:
        names[f"limits of {limit[0]}"] = ("--link-range", typed(limit))
    return names
