"""``atlas sweep``: compute an atlas."""

from __future__ import annotations

import shlex
import sys
import time
from typing import Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import Progress


@click.command()
@options.config_argument
@options.sweep_options
@click.option("--resume", is_flag=True, help="Go on with an interrupted sweep, if there is one.")
@options.overwrite_option
@options.quiet_option
def sweep(
    config_path: str | None, resume: bool, overwrite: bool, quiet: bool, **given: Any
) -> None:
    """Compute an atlas: every design of a design space, for some mode pairs.

    Options may also stand in CONFIG.toml; the command line wins. An interrupted sweep
    keeps its finished blocks in FILE.h5.partial, and --resume goes on with them.
    """
    from fivebar_atlas import config
    from fivebar_atlas.executors import ThreadExecutor
    from fivebar_atlas.store import AtlasWriter, is_complete
    from fivebar_atlas.sweep import Sweep

    configuration = config.resolve(config_path, options.overrides(**given))
    output, settings = configuration.output, configuration.settings
    if output is None:
        raise click.UsageError("No output is named: give -o FILE.h5, or 'output' under [run].")
    if resume and is_complete(output, settings):
        _say(f"{output} is complete already", quiet)
        return
    began = time.monotonic()
    work = Sweep(settings)
    total = len(work.designs)
    with AtlasWriter(
        output,
        settings,
        work.designs,
        [(block.start, block.stop) for block in work.blocks],
        resume=resume,
        overwrite=overwrite,
        command_line=shlex.join(["atlas", *sys.argv[1:]]),
    ) as writer:
        done = sum(
            block.stop - block.start for block in work.blocks if block.index in writer.finished
        )
        if done:
            _say(f"{done:,} of {total:,} designs were finished before", quiet)
        with Progress(total, done, quiet) as progress:
            for results in work.run(ThreadExecutor(configuration.threads), writer.finished):
                writer.add(results.block.index, results.arrays)
                progress.advance(results.block.stop - results.block.start)
        writer.assemble()
    pairs = ", ".join(settings.modes)
    _say(f"{output}: {total:,} designs, {pairs}, {time.monotonic() - began:.1f} s", quiet)


def _say(text: str, quiet: bool) -> None:
    """Write a line to standard error unless quiet."""
    if not quiet:
        click.echo(text, err=True)
