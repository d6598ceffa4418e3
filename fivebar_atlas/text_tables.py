"""Tables in text: a header that names columns, and numbers below it, every fault with its place."""

from __future__ import annotations

import csv
import dataclasses
import math
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import FileError, FileUsageError

# What may separate columns; beside a semicolon or a tab, a comma is a decimal comma.
_SEPARATORS = (";", "\t", ",")


@dataclasses.dataclass(frozen=True, slots=True)
class TextTable:
    """The cells of a table in text.

    Attributes
    ----------
    path
        The file.
    separator
        What separates its columns.
    rows
        Line number and cells of every row that is not blank, the header first.
    """

    path: Path
    separator: str
    rows: tuple[tuple[int, list[str]], ...]

    @property
    def header(self) -> list[str]:
        """Names of the columns."""
        return self.rows[0][1]

    def numbers(self, places: Sequence[int]) -> npt.NDArray[np.float64]:
        """Return columns as finite numbers, shape (rows, columns).

        Parameters
        ----------
        places
            Which columns, counted from 0.

        Raises
        ------
        FileUsageError
            If a value is missing, not a number or not finite; row and column are named.
        """
        header = self.header
        numbers = np.empty((len(self.rows) - 1, len(places)))
        for number, (line, cells) in enumerate(self.rows[1:]):
            row = f"row {number + 1} (line {line})"
            if any(cells[len(header) :]):
                fault = f"{row}: has {len(cells)} values for {len(header)} columns"
                raise FileUsageError(self.path, fault)
            for column, place in enumerate(places):
                text = cells[place] if place < len(cells) else ""
                value = _number(text, self.separator)
                if value is None or not math.isfinite(value):
                    where = f"{row}, column {header[place]}"
                    raise FileUsageError(self.path, f"{where}: {_fault(text, value)}")
                numbers[number, column] = value
        return numbers


def read_table(path: str | os.PathLike[str], kind: str, header: str) -> TextTable:
    """Read a table in text.

    Parameters
    ----------
    path
        A file whose first line names its columns. Columns are separated by commas, semicolons
        or tabs; numbers may have decimal commas where commas do not separate them. Blank lines
        are skipped.
    kind
        What it is a table of, for messages: ``"points"``.
    header
        What its first line must name, as a phrase.

    Raises
    ------
    FileUsageError
        If there is no such file, or it is no table, or has no rows.
    FileError
        If the file cannot be read.
    """
    path = Path(path)
    lines = _text(path, kind).split("\n")
    first = next((line for line in lines if line.strip()), "")
    separator = next((each for each in _SEPARATORS if each in first), ",")
    try:
        rows = tuple(_rows(lines, separator))
    except csv.Error as error:
        raise FileUsageError(path, f"is not a table in text: {error}") from None
    if not rows:
        raise FileUsageError(path, f"is empty; its first line must name {header}")
    return TextTable(path, separator, rows)


def _text(path: Path, kind: str) -> str:
    """Return the text of a file, with line ends of one kind and no byte order mark."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (FileNotFoundError, NotADirectoryError):
        raise FileUsageError(path, "there is no such file") from None
    except IsADirectoryError:
        raise FileUsageError(path, f"is a folder, not a table of {kind}") from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise FileUsageError(path, "is not text in UTF-8") from None


def _rows(lines: Sequence[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that are not blank, the header first, with their line numbers."""
    reader = csv.reader(lines, delimiter=separator, strict=True)
    for cells in reader:
        stripped = [cell.strip() for cell in cells]
        if any(stripped):
            yield reader.line_num, stripped


def _number(text: str, separator: str) -> float | None:
    """Return a text as a number, None if it is none."""
    if separator != "," and "." not in text:
        text = text.replace(",", ".", 1)
    if "_" in text:  # Python's own grouping of digits
        return None
    try:
        return float(text)
    except ValueError:
        return None


def _fault(text: str, value: float | None) -> str:
    """Return what is wrong with a cell."""
    if value is not None:
        return f"{text!r} is not finite"
    return f"{text!r} is not a number" if text else "there is no number"
