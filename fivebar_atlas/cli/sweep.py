"""``atlas sweep``: compute an atlas."""

from __future__ import annotations

import functools
import shlex
import sys
import time
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import Progress, note_compilation
from fivebar_atlas.errors import ClusterError, LostBlocksError

if TYPE_CHECKING:
    from fivebar_atlas.config import Configuration
    from fivebar_atlas.executors import Executor
    from fivebar_atlas.store import AtlasWriter
    from fivebar_atlas.sweep import Sweep


@click.command()
@options.config_argument
@options.sweep_options
@click.option(
    "--shard",
    metavar="I/N",
    help="Compute only the I-th of N parts, such as 2/3; 'atlas merge' puts all together.",
)
@click.option("--resume", is_flag=True, help="Go on with an interrupted sweep, if there is one.")
@options.overwrite_option
@options.quiet_option
def sweep(
    config_path: str | None,
    shard: str | None,
    resume: bool,
    overwrite: bool,
    quiet: bool,
    **given: Any,
) -> None:
    """Compute an atlas: every design of a design space, for some modes.

    Options may also stand in CONFIG.toml; the command line wins. An interrupted sweep
    keeps its finished blocks in FILE.h5.partial, and --resume goes on with them.

    With --shard I/N each of N runs, on whatever machines, computes a part of its own, into a
    file of its own: -o PART-I.h5.
    """
    from fivebar_atlas import config, mechanisms
    from fivebar_atlas.store import AtlasWriter, is_complete
    from fivebar_atlas.sweep import Shard, Sweep

    chosen = None if shard is None else Shard.parse(shard, "--shard")
    if chosen is not None and given["output"] is None:
        raise click.UsageError("A part needs a file of its own: give -o FILE.h5 with --shard.")
    configuration = config.resolve(config_path, options.overrides(**given))
    output, settings = configuration.output, configuration.settings
    if output is None:
        raise click.UsageError("No output is named: give -o FILE.h5, or 'output' under [run].")
    part = None if chosen is None else str(chosen)
    if resume and is_complete(output, settings, part):
        _say(f"{output} is complete already", quiet)
        return
    began = time.monotonic()
    with options.as_typed({"shard": ("--shard", shard)}):
        work = Sweep(settings, chosen)
    with AtlasWriter(
        output,
        settings,
        work.designs,
        [(block.start, block.stop) for block in work.blocks],
        part=part,
        resume=resume,
        overwrite=overwrite,
        command_line=shlex.join(["atlas", *sys.argv[1:]]),
    ) as writer:
        try:
            with _executor(configuration) as executor:
                _run(work, writer, executor, quiet)
            writer.assemble()
        except (ClusterError, LostBlocksError) as error:
            kept = _kept(work, writer)
            raise type(error)(f"{error}; {kept}" if kept else str(error)) from None
        except KeyboardInterrupt:
            raise click.Abort(_kept(work, writer)) from None
    said = [f"{work.count:,} designs"]
    if part is not None:
        said = [f"part {part}", f"{work.count:,} of {len(work.designs):,} designs"]
    if mechanisms.get(settings.mechanism).has_modes:
        said += settings.modes
    _say(f"{output}: {', '.join(said)}, {time.monotonic() - began:.1f} s", quiet)


def _executor(configuration: Configuration) -> Executor:
    """Return where the blocks are computed."""
    from fivebar_atlas.executors import ThreadExecutor

    if configuration.executor == "threads":
        return ThreadExecutor(configuration.threads)
    from fivebar_atlas.dask_executor import DaskExecutor
    from fivebar_atlas.versions import computing_versions

    return DaskExecutor(
        functools.partial(computing_versions, configuration.settings.mechanism),
        scheduler=configuration.scheduler,
        scheduler_file=configuration.scheduler_file,
        workers=configuration.threads,
    )


def _run(work: Sweep, writer: AtlasWriter, executor: Executor, quiet: bool) -> None:
    """Compute the blocks that are missing."""
    total, done = work.count, _designs(work, writer)
    if done:
        _say(f"{done:,} of {total:,} designs were finished before", quiet)
    if not quiet:
        note_compilation()
    with Progress(total, done, quiet) as progress:
        for results in work.run(executor, writer.finished):
            writer.add(results.block.index, results.arrays, results.processor)
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
    return f"{done:,} of {work.count:,} designs are kept, --resume goes on with them"


def _say(text: str, quiet: bool) -> None:
    """Write a line to standard error unless quiet."""
    if not quiet:
        click.echo(text, err=True)
