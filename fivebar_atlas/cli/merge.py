"""``atlas merge``: the parts of a sweep as one atlas."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import Progress


@click.command()
@click.argument("parts", metavar="PART.h5...", nargs=-1, required=True, type=click.Path())
@click.option(
    "-o", "--output", required=True, metavar="FILE.h5", type=click.Path(path_type=Path),
    help="Result file.",
)  # fmt: skip
@options.overwrite_option
@options.quiet_option
def merge(parts: tuple[str, ...], output: Path, overwrite: bool, quiet: bool) -> None:
    """Write the atlas that the parts of a sweep make up.

    The parts, from 'atlas sweep --shard', must be all there and belong together; the data are
    then those of the sweep in one run, bit for bit.
    """
    from fivebar_atlas.store import merge as merge_parts
    from fivebar_atlas.store import open_atlas

    command_line = shlex.join(["atlas", *sys.argv[1:]])
    with Progress(0, quiet=quiet) as progress:
        count = merge_parts(
            parts, output, overwrite=overwrite, command_line=command_line, report=progress.reach
        )
    if quiet:
        return
    click.echo(f"{output}: {count:,} designs from {_parts(len(parts))}", err=True)
    with open_atlas(output) as atlas:
        processors = str(atlas.attributes["processor"])
    if ", " in processors:
        click.echo(
            f"the parts were computed on several kinds of processors ({processors}): the last "
            "digits may differ from those of a run on one kind",
            err=True,
        )


def _parts(count: int) -> str:
    """Return how many parts there are, in words."""
    return "1 part" if count == 1 else f"{count:,} parts"
