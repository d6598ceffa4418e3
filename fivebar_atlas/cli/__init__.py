"""The command line. Errors become messages and exit codes here and nowhere else."""

from __future__ import annotations

import contextlib
import functools
import importlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

import click

from fivebar_atlas import __version__
from fivebar_atlas.errors import AtlasError

#: Every command is the object of its name in the module of its name; its help stands here
#: so that ``atlas --help`` need not import them.
_COMMANDS = {
    "sweep": "Compute an atlas: every design of a design space.",
    "plot": "Draw a figure from an atlas.",
    "evaluate": "Evaluate one design.",
    "size": "Size a machine for a practical workspace.",
    "report": "Write a run of another command as one HTML page.",
    "square": "Find the largest square workspace, after Le, Kang and Doan.",
    "design": "Find the best machines for a practical workspace.",
    "optimum": "Find the region where conditions hold, and the best designs in it.",
    "lookup": "Look up one machine in an atlas.",
    "animate": "Show a linkage that follows a path.",
    "path": "Tell whether a linkage can follow a path.",
    "merge": "Write the atlas that the parts of a sweep make up.",
    "trajectory": "Solve a motion: limb lengths, velocities, accelerations, forces.",
    "info": "Say what is in a result file and how it was made.",
    "export": "Write a result file as a table.",
    "geometry": "List or write loci, workspaces and circles of one design as exact arcs.",
    "config": "Look at configurations.",
    "mechanisms": "List the mechanisms, and what each takes and computes.",
}

_FAILED = 1
_INTERRUPTED = 130


class AtlasGroup(click.Group):
    """A group whose commands are imported when they are run."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        """Return the names of all commands."""
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Import a command."""
        if cmd_name not in _COMMANDS:
            return None
        command = getattr(importlib.import_module(f"fivebar_atlas.cli.{cmd_name}"), cmd_name)
        return command if isinstance(command, click.Command) else None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """Write the list of commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(_COMMANDS.items()))

    def main(self, *args: Any, **options: Any) -> Any:
        """Run a command; end the process with its exit code unless ``standalone_mode=False``."""
        options.setdefault("prog_name", "atlas")
        standalone = options.pop("standalone_mode", True)
        group_main: Callable[..., Any] = super().main
        run = functools.partial(group_main, *args, standalone_mode=False, **options)
        if not standalone:
            return run()
        with _terminate_as_interrupt():
            code = _exit_code(run)
            if code == _INTERRUPTED and threading.active_count() > 1:
                # Threads at work on a block, or on compiling, cannot be stopped and would
                # be waited for; what they would finish is not wanted any more.
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
            sys.exit(code)


def _exit_code(run: Callable[[], Any]) -> int:
    """Run a command and return its exit code; whatever goes wrong becomes one line."""
    try:
        code = run()
        if sys.stdout is not None:  # closed by whoever started the process
            sys.stdout.flush()
    except click.Abort as abort:
        click.echo("; ".join(["atlas: interrupted", *filter(None, [str(abort)])]), err=True)
        return _INTERRUPTED
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return error.exit_code
    except click.UsageError as error:
        where = f" (see '{error.ctx.command_path} --help')" if error.ctx else ""
        return _fail(error.format_message() + where, error.exit_code)
    except click.ClickException as error:
        return _fail(error.format_message(), error.exit_code)
    except AtlasError as error:
        return _fail(str(error), error.exit_code)
    except BrokenPipeError:
        # Whoever read the output has enough.
        _discard_output()
        return _FAILED
    except OSError as error:
        name = error.filename or "standard output"
        _discard_output()
        return _fail(f"{name}: {error.strerror or error}", _FAILED)
    except MemoryError:
        return _fail("there is not enough memory", _FAILED)
    return code if isinstance(code, int) else 0


def _discard_output() -> None:
    """Drop what is still to be written to standard output, which has failed.

    Python would complain once more on its way out, when it flushes.
    """
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str, code: int) -> int:
    """Write an error message, on one line, and return the exit code."""
    click.echo(f"atlas: error: {' '.join(message.split())}", err=True)
    return code


@contextlib.contextmanager
def _terminate_as_interrupt() -> Iterator[None]:
    """Let SIGTERM end a command like an interrupt: in order, finished work kept."""

    def interrupt(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


@click.group(cls=AtlasGroup, invoke_without_command=True)
@click.version_option(__version__, prog_name="atlas")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Design atlases of parallel manipulators: every design, how good, and how sure.

    Results go to standard output, everything else to standard error. Exit codes: 0 done,
    1 failed, 2 wrong usage, 130 interrupted.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())
