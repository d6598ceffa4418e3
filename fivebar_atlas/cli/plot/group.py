"""The group of ``atlas plot``: its commands are the registry of kinds of figures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

from fivebar_atlas.cli import options
from fivebar_atlas.errors import InputError, UnknownNameError

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

    Kinds of one design take LENGTHS, maps of stored quantities take FILE.h5, and atlases of
    small drawings take neither. The same input always gives the same figure, byte for byte.
    """


def sized_figure_options(width: float) -> Callable[[Command], Command]:
    """Return what adds the options of every kind of figure, with a width in millimetres."""

    def add(command: Command) -> Command:
        for option in (
            options.overwrite_option,
            click.option(
                "--width",
                type=float,
                default=width,
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

    return add


#: The options that every kind of figure for one journal column has.
figure_options = sized_figure_options(85.0)
data_option = click.option(
    "--data",
    type=click.Path(path_type=Path),
    metavar="DATA.csv",
    help="Every plotted coordinate as comma-separated text.",
)


def check_outputs(figure: Path, data: Path | None, overwrite: bool) -> None:
    """Refuse a figure or a file of its coordinates that cannot be written, before any work.

    Raises
    ------
    InputError
        If the ending of the figure is not that of a format, or both are one file.
    FileUsageError, FileError
        If a folder is missing or not writable, or a file exists already.
    """
    from fivebar_atlas.figures.saving import check_figure_output
    from fivebar_atlas.output_file import check_output

    check_figure_output(figure, overwrite)
    if data is not None:
        if data.resolve() == figure.resolve():
            raise InputError("data", str(data), "another file than the figure")
        check_output(data, overwrite)
