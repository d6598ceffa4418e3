"""``atlas report``: a run of another command as one HTML page."""

from __future__ import annotations

import datetime
import functools
import importlib
import inspect
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli.presentation import Captioned, ReportSink, Row, Run, Section, json_text
from fivebar_atlas.errors import UnknownNameError

if TYPE_CHECKING:
    from fivebar_atlas.report.content import Picture

#: The commands whose runs can be reported: they end in ``present``.
REPORTABLE = ("evaluate", "optimum", "size", "square", "design")

#: Parameters of a command that say where its results go, with what they are in a report.
_OUTPUTS: dict[str, Any] = {"as_json": False, "output": None, "overwrite": False}
#: Parameters that change nothing of what is reported.
_UNSAID = ("quiet",)
_ENDING = "html"


class _Reports(click.Group):
    """The commands that can be reported, imported when they are run."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002
        return list(REPORTABLE)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        return _reported(cmd_name) if cmd_name in REPORTABLE else None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and args[0] not in REPORTABLE:
            raise UnknownNameError("COMMAND", args[0], REPORTABLE)
        return super().resolve_command(ctx, args)


class _Reported(click.Command):
    """A command whose run becomes a report; it keeps its arguments as they were written."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.meta[__name__] = shlex.join([*ctx.command_path.split(), *args])
        return super().parse_args(ctx, args)


@click.group(cls=_Reports)
def report() -> None:
    """Write a run of another command as one HTML page.

    The page has what was asked for, the figures, the numbers with their errors, and the
    versions that made them. It is one file that needs no network: for a screen or a phone, for
    a mail, and for printing to PDF. The commands take the arguments that they take without
    'report':

    \b
      atlas report size 26 30 16 --rectangle 300x200 -o machine.html
      atlas report evaluate 26 30 16 --mode all -o design.html
      atlas report optimum paper.h5 --where 'gci>=0.62' -o region.html
    """  # noqa: D301 - click reads the character


@functools.cache
def _reported(name: str) -> click.Command:
    """Return the command that reports what another one computes."""
    original = getattr(importlib.import_module(f"fivebar_atlas.cli.{name}"), name)
    own = [each for each in original.params if each.name not in _OUTPUTS]
    hidden = {each.name: _OUTPUTS[each.name] for each in original.params if each.name in _OUTPUTS}

    def run(output: Path, overwrite: bool, **values: Any) -> None:
        from fivebar_atlas.output_file import check_output, checked_ending

        checked_ending(output, (_ENDING,))
        check_output(output, overwrite)
        context = click.get_current_context()
        context.obj = ReportSink(lambda found: _write(found, context, own, output, overwrite))
        original.callback(**values, **hidden)

    return _Reported(
        name,
        params=[*own, _output_option(), _overwrite_option()],
        callback=run,
        help=f"{inspect.cleandoc(original.help)}\n\nWrites that as one HTML page.",
        context_settings=original.context_settings,
    )


def _output_option() -> click.Option:
    return click.Option(
        ["-o", "--output"],
        type=click.Path(path_type=Path),
        required=True,
        metavar=f"FILE.{_ENDING}",
        help="The page, one file.",
    )


def _overwrite_option() -> click.Option:
    return click.Option(["--overwrite"], is_flag=True, help="Replace an existing output.")


def _write(
    run: Run,
    context: click.Context,
    parameters: list[click.Parameter],
    output: Path,
    overwrite: bool,
) -> None:
    """Write the page of a run."""
    from fivebar_atlas.output_file import atomic_output
    from fivebar_atlas.report.content import Report
    from fivebar_atlas.report.page import page
    from fivebar_atlas.report.provenance import provenance

    choices, *sections = run.sections()
    content = Report(
        title=run.title,
        summary=run.summary,
        command_line=context.meta[__name__],
        inputs=Section("Inputs", rows=tuple(_inputs(context, parameters))),
        choices=choices,
        pictures=tuple(map(_picture, run.figures())),
        sections=tuple(sections),
        provenance=provenance(datetime.datetime.now(datetime.UTC)),
        document=json_text(run.document()),
    )
    with atomic_output(output, overwrite) as temporary:
        temporary.write_text(page(content), encoding="utf-8")


def _inputs(context: click.Context, parameters: list[click.Parameter]) -> Iterator[Row]:
    """Yield what was given, option by option, with what the help says of it."""
    for each in parameters:
        value = context.params[str(each.name)]
        source = context.get_parameter_source(str(each.name))
        if source is click.core.ParameterSource.DEFAULT or each.name in _UNSAID:
            continue
        text = _value_text(value, is_repeated=each.multiple)
        if isinstance(each, click.Option):
            name = next(name for name in each.opts if name.startswith("--"))
            yield Row(name, text, note=each.help or "")
        else:
            yield Row(each.make_metavar(context), text)


def _value_text(value: Any, is_repeated: bool) -> str:
    """Return a value as it would be written."""
    if isinstance(value, dict):
        return ", ".join(
            f"{name}={_value_text(each, is_repeated=False)}" for name, each in value.items()
        )
    if is_repeated:
        return ", ".join(_value_text(each, is_repeated=False) for each in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return " ".join(_value_text(each, is_repeated=False) for each in value)
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _picture(captioned: Captioned) -> Picture:
    """Return a figure as SVG."""
    from fivebar_atlas.figures.saving import rendered
    from fivebar_atlas.report.content import Picture

    return Picture(captioned.caption, rendered(captioned.draw(), "svg").decode())
