"""Points of the plane read from tables in text: columns x and y, other columns left alone."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from fivebar_atlas.errors import FileError, FileUsageError
from fivebar_atlas.planar_geometry import FloatArray

# What may separate columns; beside a semicolon or a tab, a comma is a decimal comma.
_SEPARATORS = (";", "\t", ",")


def read_points(path: str | os.PathLike[str], unit: str = "") -> FloatArray:
    """Read points from comma-separated text.

    Parameters
    ----------
    path
        A file whose first line names its columns, in any order and number: ``x`` and ``y``,
        or ``x_mm`` and ``y_mm`` with the unit. Columns are separated by commas, semicolons
        or tabs; numbers may have decimal commas where commas do not separate them. Blank
        lines are skipped.
    unit
        Unit that the points are wanted in; empty where lengths are non-dimensional.

    Returns
    -------
    ndarray
        Shape (n, 2), n at least 1.

    Raises
    ------
    FileUsageError
        If there is no such file; if a column is missing, there twice or in another unit; if
        a value is missing, not a number or not finite (its row and column are named); or if
        there are no points.
    FileError
        If the file cannot be read.
    """
    path = Path(path)
    lines = _text(path).split("\n")
    first = next((line for line in lines if line.strip()), "")
    separator = next((each for each in _SEPARATORS if each in first), ",")
    try:
        rows = list(_rows(lines, separator))
    except csv.Error as error:
        raise FileUsageError(path, f"is not a table in text: {error}") from None
    if not rows:
        raise FileUsageError(path, "is empty; its first line must name the columns x and y")
    _, header = rows[0]
    places = [_place(path, header, axis, unit) for axis in ("x", "y")]
    if len(rows) == 1:
        raise FileUsageError(path, "has no points below its header")
    points = np.empty((len(rows) - 1, 2))
    for number, (line, cells) in enumerate(rows[1:]):
        row = f"row {number + 1} (line {line})"
        if any(cells[len(header) :]):
            raise FileUsageError(path, f"{row}: has {len(cells)} values for {len(header)} columns")
        for axis, place in enumerate(places):
            where = f"{row}, column {header[place]}"
            text = cells[place] if place < len(cells) else ""
            value = _number(text, separator)
            if value is None:
                fault = f"{text!r} is not a number" if text else "there is no number"
                raise FileUsageError(path, f"{where}: {fault}")
            if not math.isfinite(value):
                raise FileUsageError(path, f"{where}: {text!r} is not finite")
            points[number, axis] = value
    return points


def _text(path: Path) -> str:
    """Return the text of a file, with line ends of one kind and no byte order mark."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (FileNotFoundError, NotADirectoryError):
        raise FileUsageError(path, "there is no such file") from None
    except IsADirectoryError:
        raise FileUsageError(path, "is a folder, not a table of points") from None
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


def _place(path: Path, header: Sequence[str], axis: str, unit: str) -> int:
    """Return the place of the column of a coordinate."""
    accepted = (axis, f"{axis}_{unit}") if unit else (axis,)
    wanted = " or ".join(accepted)
    there = ", ".join(name or "(no name)" for name in header)
    names = [name.casefold() for name in header]
    found = [place for place, name in enumerate(names) if name in map(str.casefold, accepted)]
    if len(found) == 1:
        return found[0]
    if found:
        raise FileUsageError(path, f"has more than one column {wanted}: {there}")
    reason = f"has no column {wanted}; its columns are {there}, x and y are needed"
    if any(name.startswith(f"{axis}_") for name in names):
        lengths = f"in {unit}" if unit else "non-dimensional"
        reason += f", and lengths are {lengths} here"
    raise FileUsageError(path, reason)


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
