"""What a report is made of: sections of rows and tables whose numbers are text already."""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True, slots=True)
class Row:
    """One value with what it is.

    Attributes
    ----------
    label
        What it is.
    value
        The value with its unit.
    error
        Its error with the sign, ``"± 2e-08 mm"``; empty where there is none.
    note
        What else there is to say: where, for what, how it was found.
    """

    label: str
    value: str
    error: str = ""
    note: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class Table:
    """A table with a header.

    Attributes
    ----------
    header
        Heads of the columns.
    rows
        Cells, as many in each row as there are heads; the first one says what the row is.
    caption
        What the table shows; empty where the section says it.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class Section:
    """A part of a report under a heading.

    Attributes
    ----------
    heading
        The heading.
    sentences
        What is to be said before the numbers, one paragraph each.
    rows
        Values, one below the other.
    tables
        Tables, after them.
    """

    heading: str
    sentences: tuple[str, ...] = ()
    rows: tuple[Row, ...] = ()
    tables: tuple[Table, ...] = ()


@dataclasses.dataclass(frozen=True, slots=True)
class Picture:
    """A figure as it is put into a page.

    Attributes
    ----------
    caption
        What it shows.
    svg
        The figure as the text of an SVG file.
    """

    caption: str
    svg: str


@dataclasses.dataclass(frozen=True, slots=True)
class Report:
    """Everything a page shows, in the order in which it shows it.

    Attributes
    ----------
    title
        What was found.
    summary
        The result in one sentence.
    command_line
        The command that made the report.
    inputs
        What was given to it.
    choices
        What was chosen where nothing was given.
    pictures
        The figures.
    sections
        The results.
    provenance
        What the numbers depend on, and when they were computed.
    document
        The results as JSON.
    """

    title: str
    summary: str
    command_line: str
    inputs: Section
    choices: Section
    pictures: tuple[Picture, ...]
    sections: tuple[Section, ...]
    provenance: Section
    document: str
