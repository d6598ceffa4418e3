"""The group of ``atlas plot``: its commands are the registry of kinds of figures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

from fivebar_atlas.cli import options
from fivebar_atlas.errors import UnknownNameError

Command = Callable[..., None]


class _Kinds(click.Group):
    """The kinds of figures; an unknown one is answered with those there are."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            raise UnknownNameError("KIND", args[0], self.list_commands(ctx))
        return super().resolve_command(ctx, args)


@click.group(cls=_Kinds, subcommand_metavar="KIND [ARGS]...")
def plot() -> None:
    """Draw a figure as PNG, PDF or SVG, by the ending of the file name.

    The same result file always gives the same figure, byte for byte.
    """


def figure_options(command: Command) -> Command:
    """Add the options that every kind of figure has."""
    for option in (
        options.overwrite_option,
        click.option(
            "--width",
            type=float,
            default=85.0,
            show_default=True,
            metavar="MM",
            help="Width of the figure; the font sizes stay.",
        ),
        click.option(
            "-o",
            "--output",
            type=click.Path(path_type=Path),
            required=True,
            metavar="FIGURE.(png|pdf|svg)",
            help="Figure; the ending decides the format.",
        ),
    ):
        command = option(command)
    return command
