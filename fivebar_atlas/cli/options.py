"""The options and arguments that several commands share, each defined once."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from fivebar_atlas.config import Overrides

Function = TypeVar("Function", bound=Callable[..., Any])


def _together(*decorators: Callable[[Any], Any]) -> Callable[[Function], Function]:
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


config_argument = click.argument(
    "config_path", metavar="[CONFIG.toml]", required=False, type=click.Path()
)
file_argument = click.argument("file", metavar="FILE.h5", type=click.Path())
mechanism_option = click.option("--mechanism", metavar="NAME", help="Mechanism.")
mode_option = click.option(
    "--mode",
    multiple=True,
    callback=_at_least_one,
    metavar="MODE",
    help="Mode pair such as +-/up or pm/up; repeatable; 'all' for all.",
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
    "--tolerance", type=float, metavar="VALUE", help="Relative tolerance, 1e-10 to 1e-3."
)
sweep_options = _together(
    mechanism_option,
    click.option(
        "--resolution", type=int, metavar="N", help="Lattice steps; designs are (i, j, k)·3/N."
    ),
    click.option("--space", metavar="NAME", help="Design space: surrounded or assemblable."),
    mode_option,
    lci_option,
    tolerance_option,
    click.option(
        "--threads", type=int, metavar="N", help="Threads; one for each core if not given."
    ),
    click.option("-o", "--output", metavar="FILE.h5", help="Result file."),
)
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace an existing output.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
quiet_option = click.option(
    "-q", "--quiet", is_flag=True, help="Say nothing on standard error but errors."
)


def overrides(**options: Any) -> Overrides:
    """Return the values of ``sweep_options`` as overrides of a configuration."""
    from fivebar_atlas.config import Overrides

    return Overrides(**options)
