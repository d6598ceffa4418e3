"""``atlas sweep``: compute an atlas."""

from __future__ import annotations

import shlex
import sys
import time
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import Progress, note_compilation

if TYPE_CHECKING:
    from fivebar_atlas.executors import Executor
    from fivebar_atlas.store import AtlasWriter
    from fivebar_atlas.sweep import Sweep


@click.command()
@options.config_argument
@options.sweep_options
@click.option("--resume", is_flag=True, help="Go on with an interrupted sweep, if there is one.")
@options.overwrite_option
@options.quiet_option
def sweep(
    config_path: str | None, resume: bool, overwrite: bool, quiet: bool, **given: Any
) -> None:
    """Compute an atlas: every design of a design space, for some modes.

    Options may also stand in CONFIG.toml; the command line wins. An interrupted sweep
    keeps its finished blocks in FILE.h5.partial, and --resume goes on with them.
    """
    from fivebar_atlas import config, mechanisms
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
    with AtlasWriter(
        output,
        settings,
        work.designs,
        [(block.start, block.stop) for block in work.blocks],
        resume=resume,
        overwrite=overwrite,
        command_line=shlex.join(["atlas", *sys.argv[1:]]),
    ) as writer:
        try:
            _run(work, writer, ThreadExecutor(configuration.threads), quiet)
            writer.assemble()
        except KeyboardInterrupt:
            raise click.Abort(_kept(work, writer)) from None
    parts = [f"{len(work.designs):,} designs"]
    if mechanisms.get(settings.mechanism).has_modes:
        parts += settings.modes
    _say(f"{output}: {', '.join(parts)}, {time.monotonic() - began:.1f} s", quiet)


def _run(work: Sweep, writer: AtlasWriter, executor: Executor, quiet: bool) -> None:
    """Compute the blocks that are missing."""
    total, done = len(work.designs), _designs(work, writer)
    if done:
        _say(f"{done:,} of {total:,} designs were finished before", quiet)
    if not quiet:
        note_compilation()
    with Progress(total, done, quiet) as progress:
        for results in work.run(executor, writer.finished):
            writer.add(results.block.index, results.arrays)
            progress.advance(results.block.stop - results.block.start)


def _designs(work: Sweep, writer: AtlasWriter) -> int:
    """Return the number of designs in finished blocks."""
    finished = writer.finished
    return sum(block.stop - block.start for block in work.blocks if block.index in finished)


def _kept(work: Sweep, writer: AtlasWriter) -> str:
    """Return what an interruption has not lost."""
    done = _designs(work, writer)
    if not done:
        return ""
    return f"{done:,} of {len(work.designs):,} designs are kept, --resume goes on with them"


def _say(text: str, quiet: bool) -> None:
    """Write a line to standard error unless quiet."""
    if not quiet:
        click.echo(text, err=True)
