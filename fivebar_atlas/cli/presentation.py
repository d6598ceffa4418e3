"""How what a command has computed is presented: as lines, as JSON, or as a report.

A command that can be reported hands a :class:`Run` to :func:`present` and prints nothing
itself. Lines and sections are made from the same rows wherever they say the same.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import click

from fivebar_atlas.report.content import Row, Section, Table

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.mechanisms.settings import Options

__all__ = [
    "Captioned",
    "ReportSink",
    "Row",
    "Run",
    "Section",
    "Table",
    "capitalised",
    "json_text",
    "option_rows",
    "present",
    "raised",
    "titled",
]


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def raised(unit: str, power: int) -> str:
    """Return a power of a unit: ``"mm²"``, ``"mm"``, ``"mm⁻¹"``; nothing for the power 0."""
    if power == 0:
        return ""
    return unit if power == 1 else unit + str(power).translate(_SUPERSCRIPTS)


@dataclasses.dataclass(frozen=True, slots=True)
class Captioned:
    """A figure that is drawn only where it is wanted.

    Attributes
    ----------
    caption
        What it shows.
    draw
        Returns it as a matplotlib figure; imports matplotlib, which nobody else should wait for.
    """

    caption: str
    draw: Callable[[], Any]


class Written(Protocol):
    """A result as it is written down, in every way that a run is presented."""

    @property
    def title(self) -> str: ...
    @property
    def summary(self) -> str: ...
    def document(self) -> dict[str, Any]: ...
    def lines(self) -> Iterable[str]: ...
    def sections(self) -> Sequence[Section]: ...
    def figures(self) -> Sequence[Captioned]: ...


@dataclasses.dataclass(frozen=True, slots=True)
class Run:
    """What a command has computed, and every way to present it.

    Attributes
    ----------
    title
        What was found, as a heading: ``"Machine for a rectangle 300 x 200 mm"``.
    summary
        The result in one sentence.
    document
        Returns everything as nested dictionaries, ready for JSON.
    lines
        Returns the lines of the readable table for a terminal.
    sections
        Returns the same for a report, at least one section: the first one says what was
        chosen, and the figures come after it.
    figures
        Returns the figures of a report.
    """

    title: str
    summary: str
    document: Callable[[], dict[str, Any]]
    lines: Callable[[], Iterable[str]]
    sections: Callable[[], Sequence[Section]]
    figures: Callable[[], Sequence[Captioned]] = tuple

    @classmethod
    def of(cls, text: Written) -> Run:
        """Return the run of a result that is written down."""
        return cls(
            title=text.title,
            summary=text.summary,
            document=text.document,
            lines=text.lines,
            sections=text.sections,
            figures=text.figures,
        )


@dataclasses.dataclass(frozen=True, slots=True)
class ReportSink:
    """The object of a click context under which runs are not printed but taken.

    Attributes
    ----------
    take
        Takes the run while everything it needs is still open.
    """

    take: Callable[[Run], None]


def present(
    run: Run, as_json: bool = False, output: Path | None = None, overwrite: bool = False
) -> None:
    """Print what a command has computed, or hand it to whoever makes a report of it.

    Parameters
    ----------
    run
        What was computed.
    as_json
        Whether to print JSON instead of lines.
    output
        File that takes the JSON as well; None for none.
    overwrite
        Whether an existing file may be replaced.

    Raises
    ------
    FileUsageError, FileError
        If the file cannot be written or exists already; nothing is printed.
    """
    context = click.get_current_context(silent=True)
    sink = None if context is None else context.find_object(ReportSink)
    if sink is not None:
        sink.take(run)
        return
    text = json_text(run.document()) if as_json or output is not None else ""
    if output is not None:
        from fivebar_atlas.output_file import atomic_output

        with atomic_output(output, overwrite) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")
    click.echo(text if as_json else "\n".join(run.lines()))


def json_text(document: dict[str, Any]) -> str:
    """Return a document as it is printed and written; what does not exist is null."""
    return json.dumps(document, indent=2, allow_nan=False)


def titled(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Return rows as a report shows them, whose labels begin with a capital letter."""
    return tuple(dataclasses.replace(row, label=capitalised(row.label)) for row in rows)


def option_rows(mechanism: Mechanism, options: Options) -> Iterator[Row]:
    """Yield what a report says of every sweep option of a mechanism."""
    values = dict(mechanism.complete_options(options))
    for each in mechanism.options:
        yield Row(capitalised(each.long_name), each.shown(values[each.name]))


def capitalised(label: str) -> str:
    """Return a label with a capital letter; a symbol such as ``r1`` or ``θ1`` is as it is."""
    return label[:1].upper() + label[1:] if label[1:2].isalpha() else label
