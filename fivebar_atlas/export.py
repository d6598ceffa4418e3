"""Result files as tidy tables: comma-separated text, one row a design and mode."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.quantities import DESIGN, MODE, Axis, Flags
from fivebar_atlas.output_file import atomic_output, check_is_no_input
from fivebar_atlas.store import Atlas

#: Designs read at a time; the whole table never has to fit into memory.
_DESIGNS_AT_A_TIME = 8192

#: Takes a range of designs; returns the texts of one column, one for each row.
_Column = Callable[[int, int], Sequence[str]]


def export_csv(atlas: Atlas, path: str | os.PathLike[str], overwrite: bool = False) -> int:
    """Write an atlas as comma-separated text.

    Parameters
    ----------
    atlas
        The open result file.
    path
        The file to be written.
    overwrite
        Whether a file of this name may be replaced.

    Returns
    -------
    int
        Number of rows below the header.

    Raises
    ------
    FileUsageError
        If the file exists already (without ``overwrite``), its folder does not, or it is
        the atlas itself.
    FileError
        If it cannot be written, or the atlas is damaged; nothing is written then.

    Notes
    -----
    One row for each design and mode pair, designs in the order of the lattice and the mode
    pairs of a design below each other. Parameters come first, then the mode pair, then
    the quantities, each with its error estimate. What depends on a threshold has a column
    for each, named like ``good_condition_gci_lci_threshold_0.5``. Numbers have as many
    digits as tell them apart from every other; what does not exist is ``nan``. Flags are
    written as their meanings; several meanings are separated by blanks, none is ``ok``.
    """
    check_is_no_input(Path(path), atlas.path)
    columns = dict(_columns(atlas))
    rows = 0
    with (
        atomic_output(Path(path), overwrite) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for start in range(0, len(atlas), _DESIGNS_AT_A_TIME):
            stop = min(start + _DESIGNS_AT_A_TIME, len(atlas))
            texts = [column(start, stop) for column in columns.values()]
            writer.writerows(zip(*texts, strict=True))
            rows += len(texts[0])
    return rows


def _columns(atlas: Atlas) -> Iterator[tuple[str, _Column]]:
    """Yield the name of every column and what reads its part."""
    axes = {axis.name: axis for axis in atlas.mechanism.axes(atlas.settings)}
    modes = axes.get(MODE)
    repeat = 1 if modes is None else len(modes)
    for parameter in atlas.mechanism.parameters:
        yield parameter.name, _reader(atlas, parameter.name, (), repeat, None)
    if modes is not None:
        for column in modes.columns:
            yield column.name, _repeated(_texts(column.values, column.flags))
    for array in atlas.mechanism.stored_arrays(atlas.settings):
        dimensions = array.quantity.dimensions
        flags = None if array.is_error else array.quantity.flags
        expand = 1 if MODE in dimensions else repeat
        others = [axes[name] for name in dimensions if name not in (DESIGN, MODE)]
        for suffix, places in _entries(others):
            # All mode pairs, and one entry of every other axis.
            index = tuple(places.get(name, slice(None)) for name in dimensions[1:])
            yield array.name + suffix, _reader(atlas, array.name, index, expand, flags)


def _entries(axes: Sequence[Axis]) -> Iterator[tuple[str, dict[str, int]]]:
    """Yield a column suffix and the places on the axes for each combination of entries."""
    if not axes:
        yield "", {}
        return
    first, *rest = axes
    for number, label in enumerate(first.labels):
        for suffix, places in _entries(rest):
            yield f"_{first.columns[0].name}_{label}{suffix}", {first.name: number, **places}


def _reader(
    atlas: Atlas, name: str, index: tuple[Any, ...], repeat: int, flags: Flags | None
) -> _Column:
    """Return what reads a part of a dataset and repeats each entry for every mode pair."""

    def read(start: int, stop: int) -> Sequence[str]:
        values = atlas.read(name, (slice(start, stop), *index))
        return np.repeat(np.array(_texts(values.ravel(), flags)), repeat).tolist()

    return read


def _repeated(texts: Sequence[str]) -> _Column:
    """Return a column that repeats the same texts for every design."""
    return lambda start, stop: list(texts) * (stop - start)


def _texts(values: npt.NDArray[Any], flags: Flags | None) -> list[str]:
    """Return values as texts: shortest exact numbers, meanings of flags."""
    if flags is None:
        return [repr(value) for value in values.tolist()]
    codes, places = np.unique(values, return_inverse=True)
    meanings = [flags.describe(int(code)).replace(", ", " ") for code in codes]
    return [meanings[place] for place in places]
