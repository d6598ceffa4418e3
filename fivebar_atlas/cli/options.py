"""The options and arguments that several commands share, each defined once."""

from __future__ import annotations

import contextlib
import difflib
import functools
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import click

from fivebar_atlas.errors import InputError

if TYPE_CHECKING:
    from fivebar_atlas.config import Overrides
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.mechanisms.planar import PlanarDesign
    from fivebar_atlas.mechanisms.settings import Options

#: Settings of a command that takes numbers as arguments: negative ones look like options.
NEGATIVE_NUMBERS = {"ignore_unknown_options": True}

# Room in axis labels and file headers.
_LONGEST_UNIT = 16

Function = TypeVar("Function", bound=Callable[..., Any])


def together(*decorators: Callable[[Any], Any]) -> Callable[[Function], Function]:
    """Return one decorator that adds several options, in the order of the help."""
    return lambda function: functools.reduce(
        lambda decorated, decorator: decorator(decorated), reversed(decorators), function
    )


def _at_least_one(
    ctx: click.Context,  # noqa: ARG001
    parameter: click.Parameter,  # noqa: ARG001
    values: tuple[Any, ...],
) -> tuple[Any, ...] | None:
    """Return the values of a repeatable option, None where it is not given."""
    return values or None


def _numbers(
    ctx: click.Context,
    parameter: click.Parameter,  # noqa: ARG001
    texts: tuple[str, ...],
) -> list[float]:
    """Return arguments as numbers; an unknown option is among them and refused as one."""
    numbers = []
    for text in texts:
        try:
            numbers.append(float(text))
        except ValueError:
            if text.startswith("-"):
                raise no_such_option(ctx, text) from None
            raise click.BadParameter(f"{text!r} is not a number.") from None
    return numbers


def _assignments(
    ctx: click.Context,  # noqa: ARG001
    parameter: click.Parameter,  # noqa: ARG001
    texts: tuple[str, ...],
) -> dict[str, object]:
    """Return NAME=VALUE texts by name; a value that is no number and not true or false is text."""
    values: dict[str, object] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InputError("--set", text, "NAME=VALUE")
        if name in values:
            raise InputError("--set", text, f"no second value of {name}")
        values[name] = _literal(value)
    return values


def _literal(text: str) -> object:
    """Return what a text says: yes or no, a number, or the text itself."""
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text


def no_such_option(ctx: click.Context, text: str) -> click.NoSuchOption:
    """Return the error for an option that came through as an argument."""
    known = [name for option in ctx.command.params for name in option.opts]
    return click.NoSuchOption(text, possibilities=difflib.get_close_matches(text, known), ctx=ctx)


class LengthsArgument(click.Argument):
    """The lengths of one design, named as those of its mechanism once that is known."""

    def make_metavar(self, ctx: click.Context) -> str:
        """Return the lengths of the mechanism of a command line, ``LENGTHS...`` in usage."""
        if self.name not in ctx.params:
            return "LENGTHS..."
        from fivebar_atlas import mechanisms

        mechanism = mechanisms.get(ctx.params.get("mechanism") or mechanisms.names()[0])
        return " ".join(each.name for each in mechanism.lengths)


config_argument = click.argument(
    "config_path", metavar="[CONFIG.toml]", required=False, type=click.Path()
)
file_argument = click.argument("file", metavar="FILE.h5", type=click.Path())
#: The lengths of one design; its command needs ``NEGATIVE_NUMBERS``.
lengths_argument = click.argument("lengths", cls=LengthsArgument, nargs=-1, callback=_numbers)
mechanism_option = click.option(
    "--mechanism",
    metavar="NAME",
    help="Mechanism: 'atlas mechanisms' lists them with their lengths, the default first.",
)
space_option = click.option(
    "--space", metavar="NAME", help="Design space of the mechanism; its first if not given."
)
mode_option = click.option(
    "--mode",
    multiple=True,
    callback=_at_least_one,
    metavar="MODE",
    help="Mode pair such as +-/up or pm/up; repeatable; 'all' for all.",
)
one_mode_option = click.option(
    "--mode", metavar="MODE", help="Mode pair such as +-/up or pm/up; the first if not given."
)
lci_option = click.option(
    "--lci",
    multiple=True,
    type=float,
    callback=_at_least_one,
    metavar="VALUE",
    help="LCI threshold of the good-condition workspace, above 0 and below 1; repeatable.",
)
tolerance_option = click.option(
    "--tolerance",
    type=float,
    metavar="VALUE",
    help="Relative tolerance; that of the mechanism if not given: 1e-6 for five-bars.",
)
#: Options of the mechanism, for ``options_of``.
set_option = click.option(
    "--set",
    "set_options",
    multiple=True,
    callback=_assignments,
    metavar="NAME=VALUE",
    help="Option of the mechanism; repeatable.",
)
sweep_options = together(
    mechanism_option,
    click.option(
        "--resolution", type=int, metavar="N", help="Lattice steps from end to end of the space."
    ),
    space_option,
    mode_option,
    lci_option,
    tolerance_option,
    set_option,
    click.option(
        "--threads",
        type=int,
        metavar="N",
        help="Threads, or processes of a cluster here; one for each core if not given.",
    ),
    click.option(
        "--executor", metavar="NAME", help="Where to compute: threads, or dask for a cluster."
    ),
    click.option(
        "--scheduler",
        metavar="ADDRESS",
        help="Running Dask scheduler, such as tcp://10.0.0.1:8786.",
    ),
    click.option(
        "--scheduler-file", metavar="FILE", help="File that a Dask scheduler wrote its address to."
    ),
    click.option("-o", "--output", metavar="FILE.h5", help="Result file."),
)
#: One design in the plane; ``planar_design`` takes what they give.
design_options = together(
    lengths_argument,
    mechanism_option,
    click.option(
        "--unit",
        metavar="UNIT",
        help="Unit of the lengths; mm if not given, none where D = 1.",
    ),
    click.option(
        "--non-dimensional", is_flag=True, help="Scale the lengths to those of a design, D = 1."
    ),
    set_option,
)
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace an existing output.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
quiet_option = click.option(
    "-q", "--quiet", is_flag=True, help="Say nothing on standard error but errors."
)


def overrides(set_options: Mapping[str, object], **options: Any) -> Overrides:
    """Return the values of ``sweep_options`` as overrides of a configuration."""
    from fivebar_atlas.config import Overrides

    return Overrides(options=set_options, **options)


def options_of(mechanism: Mechanism, set_options: Mapping[str, object]) -> Options:
    """Return the values of ``set_option``, and defaults, as options of a mechanism.

    Raises
    ------
    InputError
        If there is no such option, or its value is not allowed.
    """
    return mechanism.complete_options(set_options, "--set {}".format)


def planar_design(
    lengths: list[float],
    mechanism: str | None,
    unit: str | None,
    non_dimensional: bool,
    set_options: Mapping[str, object],
) -> PlanarDesign:
    """Return the design that the values of ``design_options`` stand for.

    Raises
    ------
    click.UsageError
        If a unit is given for non-dimensional lengths.
    InputError
        If the lengths make no mechanism that moves in a plane, or an option is not allowed.
    """
    from fivebar_atlas import mechanisms

    if non_dimensional and unit:
        raise click.UsageError("--unit and --non-dimensional exclude each other")
    check_unit(unit)
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    set_values = options_of(chosen, set_options)
    return chosen.planar_design(lengths, "" if non_dimensional else unit, set_values)


def check_unit(unit: str | None) -> None:
    """Raise InputError unless a unit, if one is given, has a name that can be printed."""
    if unit is not None and not (unit.isprintable() and 0 < len(unit.strip()) <= _LONGEST_UNIT):
        allowed = f"the name of a unit, of 1 to {_LONGEST_UNIT} printable characters"
        raise InputError("--unit", unit, allowed)


def mode_pair(design: PlanarDesign, mode: str | None) -> str:
    """Return the value of ``one_mode_option`` as a mode pair of the design's mechanism.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    """
    from fivebar_atlas import mechanisms

    mechanism = mechanisms.get(design.mechanism)
    with as_typed({"mode": ("--mode", None)}):
        return mechanism.modes[0] if mode is None else mechanism.parse_mode(mode)


@contextlib.contextmanager
def as_typed(options: Mapping[str, tuple[str, str | None]]) -> Iterator[None]:
    """Name options, and their values, as they were typed where they are refused.

    Parameters
    ----------
    options
        By the name of an input within: the option, and its value as it was typed; None
        where the error has it.
    """
    try:
        yield
    except InputError as error:
        if error.name not in options:
            raise
        option, text = options[error.name]
        raise error.renamed(option, error.value if text is None else text) from None


@contextlib.contextmanager
def asked_to_choose() -> Iterator[None]:
    """Name the option where a file holds several mode pairs or thresholds and none is chosen."""
    try:
        yield
    except InputError as error:
        if error.value is not None:
            raise
        raise click.UsageError(f"--{error.name} must be given: {error.allowed}") from None


def typed(values: Iterable[object]) -> str:
    """Return the values of an option as they may have been typed."""
    shown = (f"{value:g}" if isinstance(value, float) else str(value) for value in values)
    return " ".join(shown)
