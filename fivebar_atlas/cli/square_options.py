"""The options of everything about the largest square, and the task that they stand for."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.shape_options import actuator_range_option, limits_given
from fivebar_atlas.errors import InputError

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.synthesis.largest_square import SquareTask

Function = TypeVar("Function", bound=Callable[..., Any])

# Inputs of a task, which are named as options where they are refused.
_NAMES = ("actuator range", "mode", "centre", "half")
# Largest ratio of the sides of a rectangle.
_MOST_ASPECT = 1e3

#: Range of the ratio of links; :func:`parse_ratios` takes its text.
ratio_range_option = click.option(
    "--rho",
    metavar="A:B:STEP",
    required=True,
    help="Ratios l2/l1 from A to B, such as 1.2:4:0.05; 1 or more.",
)

#: One ratio of links; :func:`check_ratio` checks it.
ratio_option = click.option(
    "--rho", type=float, required=True, metavar="RHO", help="Ratio l2/l1, 1 or more."
)


def square_options(command: Function) -> Function:
    """Add what is asked of a square; :func:`square_task` takes what they give."""
    for option in (
        click.option(
            "--aspect",
            metavar="W:H",
            help="Width to height of a rectangle, such as 2:1; a square if not given.",
        ),
        click.option(
            "--centre",
            default="mic",
            show_default=True,
            metavar="mic|axis",
            help="At the centre of the maximal inscribed circle, or where it is best on the axis.",
        ),
        click.option(
            "--half",
            default="upper",
            show_default=True,
            metavar="upper|lower",
            help="On which side of the base the centre is.",
        ),
        actuator_range_option,
        click.option(
            "--lci",
            type=float,
            default=0.5,
            show_default=True,
            metavar="THRESHOLD",
            help="Least LCI in the square, above 0 and below 1.",
        ),
        options.one_mode_option,
        options.mechanism_option,
    ):
        command = option(command)
    return command


def ratio_or_lengths_options(command: Function) -> Function:
    """Add the choice of one machine; :func:`machine_lengths` takes what they give."""
    for option in (
        click.option(
            "--lengths",
            nargs=3,
            type=float,
            metavar="L1 L2 L0",
            help="Lengths of any design in place of a ratio; L0 is half the base.",
        ),
        click.option("--rho", type=float, metavar="RHO", help="Ratio l2/l1, 1 or more."),
    ):
        command = option(command)
    return command


def square_task(
    mechanism: str | None,
    mode: str | None,
    lci: float,
    actuator_ranges: tuple[tuple[int, float, float], ...],
    half: str,
    centre: str,
    aspect: str | None,
) -> SquareTask:
    """Return the task that the values of :func:`square_options` stand for.

    Raises
    ------
    InputError
        If one of them is out of range.
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.synthesis.largest_square import SquareTask

    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    chosen.check_thresholds([lci], "--lci")
    names = {name: (f"--{name.replace(' ', '-')}", None) for name in _NAMES}
    with options.as_typed(names):
        return SquareTask(
            mechanism=chosen,
            mode=chosen.modes[0] if mode is None else chosen.parse_mode(mode),
            lci_threshold=lci,
            ranges=tuple(limits_given(actuator_ranges, ())[0]),
            aspect=1.0 if aspect is None else parse_aspect(aspect),
            centre=centre,
            half=half,
        )


def parse_aspect(text: str) -> float:
    """Return width over height from ``"W:H"``.

    Raises
    ------
    InputError
        If the text is not two numbers above 0.
    """
    allowed = f"width and height such as 2:1, neither more than {_MOST_ASPECT:g} times the other"
    width, height = _numbers("--aspect", text, 2, allowed)
    if not (0.0 < width < math.inf and 0.0 < height < math.inf):
        raise InputError("--aspect", text, allowed)
    if not width / _MOST_ASPECT <= height <= width * _MOST_ASPECT:
        raise InputError("--aspect", text, allowed)
    return width / height


def parse_ratios(text: str) -> list[float]:
    """Return the ratios of links of ``"A:B:STEP"``, rising, both ends among them.

    Raises
    ------
    InputError
        If the text is not three numbers, or they make no range of ratios of at least 1.
    """
    from fivebar_atlas.synthesis.square_curve import ratios_between

    allowed = "three numbers A:B:STEP such as 1.2:4:0.05"
    least, greatest, step = _numbers("--rho", text, 3, allowed)
    try:
        return ratios_between(least, greatest, step)
    except InputError as error:
        raise InputError("--rho", text, error.allowed) from None


def check_ratio(mechanism: Mechanism, ratio: float) -> None:
    """Raise InputError unless a ratio of links has an optimal configuration."""
    try:
        mechanism.optimal_configuration(ratio)
    except InputError as error:
        if error.name == "mechanism":
            raise
        raise InputError("--rho", ratio, error.allowed) from None


def machine_lengths(
    mechanism: Mechanism, rho: float | None, lengths: tuple[float, ...] | None
) -> tuple[float, ...]:
    """Return lengths, the first one 1, from the values of :func:`ratio_or_lengths_options`.

    Raises
    ------
    click.UsageError
        If none or both are given.
    InputError
        If they make no mechanism.
    """
    if (rho is None) == (lengths is None):
        raise click.UsageError("give either --rho or --lengths")
    if rho is not None:
        check_ratio(mechanism, rho)
        return mechanism.optimal_configuration(rho).lengths
    assert lengths is not None
    if not lengths[0] > 0.0:
        raise InputError("--lengths", lengths, "an actuated link L1 longer than 0")
    mechanism.from_lengths(lengths)
    return tuple(length / lengths[0] for length in lengths)


def _numbers(option: str, text: str, count: int, allowed: str) -> list[float]:
    """Return numbers separated by colons."""
    parts = text.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise InputError(option, text, allowed) from None
    if len(numbers) != count:
        raise InputError(option, text, allowed)
    return numbers
