"""A report as one HTML page that needs nothing else: no network, no script, no other file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from importlib import resources

from fivebar_atlas.report.content import Picture, Report, Row, Section, Table
from fivebar_atlas.report.inline_svg import inline_svg

# What a page may load: nothing, and of itself its style sheet.
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
_NUMBER = re.compile(r"(± )?[-−]?\d\S*( [^\d\s]+| ± .+)?|none")
# Tables with more columns are scrolled on a narrow screen, others stacked.
_STACKED = 5
# Tables with more rows may go on on the next sheet of paper.
_WHOLE = 20


def page(report: Report) -> str:
    """Return the text of the HTML file of a report."""
    return "\n".join(_lines(report)) + "\n"


def _lines(report: Report) -> Iterator[str]:
    style = resources.files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    title = escape(report.title)
    yield "<!DOCTYPE html>"
    yield '<html lang="en">'
    yield "<head>"
    yield '<meta charset="utf-8">'
    yield f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield '<meta name="generator" content="fivebar-atlas">'
    yield f"<title>{title}</title>"
    yield f"<style>\n{style}</style>"
    yield "</head>"
    yield "<body>"
    yield "<header>"
    yield '<p class="kind">fivebar-atlas report</p>'
    yield f"<h1>{title}</h1>"
    yield f'<p class="summary">{_text(report.summary)}</p>'
    yield "</header>"
    before = [report.inputs, report.choices]
    after = [*report.sections, report.provenance]
    yield from _contents(before, after, has_figures=bool(report.pictures))
    yield "<main>"
    for number, section in enumerate(before, start=1):
        command = report.command_line if section is report.inputs else ""
        yield from _section(section, f"section-{number}", command)
    if report.pictures:
        yield '<section id="figures" class="figures">'
        yield "<h2>Figures</h2>"
        yield '<div class="pictures">'
        for number, picture in enumerate(report.pictures, start=1):
            yield from _figure(picture, number)
        yield "</div>"
        yield "</section>"
    for number, section in enumerate(after, start=len(before) + 1):
        yield from _section(section, f"section-{number}")
    yield '<section id="data" class="data">'
    yield "<h2>Data</h2>"
    yield "<details>"
    yield "<summary>Everything as JSON, with all digits</summary>"
    yield f'<pre tabindex="0">{escape(report.document)}</pre>'
    yield "</details>"
    yield "</section>"
    yield "</main>"
    yield "</body>"
    yield "</html>"


def _text(text: str) -> str:
    """Return text whose lines end where they may.

    Not at the hyphen of a mode, an option or an exponent and not before an error, but within
    long names.
    """
    words = []
    for word in text.replace("± ", "±\N{NO-BREAK SPACE}").split(" "):
        shown = escape(word).replace("_", "_<wbr>")
        words.append(f'<span class="word">{shown}</span>' if "-" in word else shown)
    return " ".join(words)


def _contents(before: list[Section], after: list[Section], has_figures: bool) -> Iterator[str]:
    """Yield the links to all sections."""
    links = [(f"section-{number}", each.heading) for number, each in enumerate(before, start=1)]
    if has_figures:
        links.append(("figures", "Figures"))
    links += [
        (f"section-{number}", each.heading)
        for number, each in enumerate(after, start=len(before) + 1)
    ]
    yield '<nav aria-label="Contents">'
    yield "<ul>"
    for target, heading in [*links, ("data", "Data")]:
        yield f'<li><a href="#{target}">{_text(heading)}</a></li>'
    yield "</ul>"
    yield "</nav>"


def _section(section: Section, identifier: str, command: str = "") -> Iterator[str]:
    """Yield a section: heading, sentences, a command, rows, tables."""
    yield f'<section id="{identifier}">'
    yield f"<h2>{_text(section.heading)}</h2>"
    for sentence in section.sentences:
        yield f"<p>{_text(sentence)}</p>"
    if command:
        yield f'<pre class="command"><code>{_text(command)}</code></pre>'
    if section.rows:
        yield '<table class="rows">'
        yield "<tbody>"
        for row in section.rows:
            yield _row(row)
        yield "</tbody>"
        yield "</table>"
    for table in section.tables:
        yield from _table(table, table.caption or section.heading)
    yield "</section>"


def _row(row: Row) -> str:
    """Return one value with what it is."""
    parts = [f'<span class="value">{_text(row.value)}</span>']
    if row.error:
        parts.append(f'<span class="error">{_text(row.error)}</span>')
    if row.note:
        parts.append(f'<span class="note">{_text(row.note)}</span>')
    head = f'<th scope="row">{_text(row.label)}</th>' if row.label else "<td></td>"
    return f"<tr>{head}<td>{' '.join(parts)}</td></tr>"


def _table(table: Table, name: str) -> Iterator[str]:
    """Yield a table in a box of its own, in which it can be scrolled."""
    stacked = " stacked" if len(table.header) <= _STACKED else ""
    columns = list(zip(*table.rows, strict=True)) or [()] * len(table.header)
    is_numeric = [
        place > 0 and any(cell and _NUMBER.fullmatch(cell) for cell in column)
        for place, column in enumerate(columns)
    ]
    whole = " whole" if len(table.rows) <= _WHOLE else ""
    yield f'<div class="scroll{whole}" tabindex="0" role="group" aria-label="{escape(name)}">'
    yield f'<table class="numbers{stacked}">'
    if table.caption:
        yield f"<caption>{escape(table.caption)}</caption>"
    heads = "".join(
        f'<th scope="col"{_numeric(numeric)}>{escape(head)}</th>'
        for head, numeric in zip(table.header, is_numeric, strict=True)
    )
    yield f"<thead><tr>{heads}</tr></thead>"
    yield "<tbody>"
    for first, *cells in table.rows:
        others = "".join(
            f'<td data-head="{escape(head)}"{_numeric(numeric)}>{_text(cell)}</td>'
            for head, cell, numeric in zip(table.header[1:], cells, is_numeric[1:], strict=True)
        )
        yield f'<tr><th scope="row">{_text(first)}</th>{others}</tr>'
    yield "</tbody>"
    yield "</table>"
    yield "</div>"


def _numeric(is_numeric: bool) -> str:
    return ' class="number"' if is_numeric else ""


def _figure(picture: Picture, number: int) -> Iterator[str]:
    """Yield a figure with its caption."""
    yield f'<figure id="figure-{number}">'
    yield inline_svg(picture.svg, f"figure-{number}-", picture.caption)
    caption = _text(picture.caption)
    yield f"<figcaption><b>Figure {number}.</b> {caption}</figcaption>"
    yield "</figure>"
