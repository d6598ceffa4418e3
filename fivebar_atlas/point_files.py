"""Points of the plane read from tables in text: columns x and y, other columns left alone."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from fivebar_atlas.errors import FileUsageError
from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.text_tables import read_table


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
    table = read_table(path, "points", "the columns x and y")
    places = [_place(table.path, table.header, axis, unit) for axis in ("x", "y")]
    if len(table.rows) == 1:
        raise FileUsageError(table.path, "has no points below its header")
    return table.numbers(places)


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
