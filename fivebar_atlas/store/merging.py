"""Putting the parts of an atlas together."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import FileError, FileUsageError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.output_file import check_is_no_input, check_output, temporary_name
from fivebar_atlas.store.assembly import ResultFile
from fivebar_atlas.store.parts import Part
from fivebar_atlas.store.provenance import identity, joined, provenance

# Root attributes, besides the identity of a sweep, that parts have in common.
_COMMON = ("format_version", "mechanism", "sweep_designs")
# More parts are not held open: there may be as many as a process may have files.
_MOST_OPEN = 64
# So much of a value is shown where parts differ.
_LONGEST_VALUE = 60


def merge(
    paths: Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    overwrite: bool = False,
    command_line: str = "",
    report: Callable[[int, int], None] | None = None,
) -> int:
    """Write the atlas that parts of a sweep make up.

    Its data are those of the sweep in one run, bit for bit, if all parts were computed on the same
    kind of processor; the attribute ``processor`` says on which.

    Parameters
    ----------
    paths
        The files of all parts, in any order.
    output
        The result file.
    overwrite
        Replace an existing result file, once the new one is complete.
    command_line
        The command, for the record.
    report
        Called again and again with the number of designs put together and of all.

    Returns
    -------
    int
        Number of designs.

    Raises
    ------
    FileUsageError
        If a file is missing or is not part of the same sweep, a part is missing or there twice,
        or the output exists (without ``overwrite``).
    FileError
        If a file is no part of an atlas or damaged, or the output cannot be written.
    """
    output = Path(output)
    check_output(output, overwrite)
    with contextlib.ExitStack() as stack:
        parts: list[Part] = []
        for path in map(Path, paths):
            check_is_no_input(output, path)
            part = Part(path, stays_open=len(parts) < _MOST_OPEN)
            stack.callback(part.close)
            parts.append(part)
        ours = identity(parts[0].settings)
        _check_belonging(parts, (*_COMMON, *ours))
        first = parts[0]
        _check_sources(first, ours)
        order = _order(parts)
        designs = first.mechanism.lattice(first.settings.space, first.settings.resolution)
        _check_designs(order, designs)
        attributes = {
            **provenance(first.settings, command_line),
            # what the numbers were computed with
            **{name: first.attributes[name] for name in ("package_version", *ours)},
            "processor": joined(
                each for part in parts for each in str(part.attributes["processor"]).split(", ")
            ),
        }
        file = ResultFile(first.settings, designs, attributes)
        records = _records(order, len(designs), report)
        file.write(temporary_name(output), output, records, overwrite=overwrite)
    return len(designs)


def _records(
    order: Sequence[tuple[Part, int]], total: int, report: Callable[[int, int], None] | None
) -> Iterator[npt.NDArray[Any]]:
    """Yield the records of blocks of parts, in this order."""
    finished = 0
    for part, block in order:
        records = part.records(block)
        yield records
        finished += len(records)
        if report is not None:
            report(finished, total)


def _check_sources(part: Part, ours: Mapping[str, str]) -> None:
    """Raise FileUsageError if this program would make other values of what parts hold."""
    if not part.mechanism.normalised:
        return
    for name, value in ours.items():
        found = part.attributes[name]
        if name != "configuration" and found != value:
            raise FileUsageError(
                part.path,
                f"has {name} {found}, this program {value}: it would normalise the values of all "
                "parts in another way, so merge them where they were computed",
            )


def _check_designs(order: Sequence[tuple[Part, int]], designs: FloatArray) -> None:
    """Raise FileError unless blocks hold the designs of the lattice, in its order."""
    for part, block in order:
        start, stop = part.ranges[block]
        if not np.array_equal(part.parameters(block), designs[start:stop]):
            raise FileError(
                part.path,
                f"is damaged: its designs {start} to {stop - 1} are not those of its configuration",
            )


def _check_belonging(parts: Sequence[Part], names: Sequence[str]) -> None:
    """Raise FileUsageError unless the parts are all those of one sweep, each there once.

    Parameters
    ----------
    parts
        The parts.
    names
        Root attributes that must be the same.
    """
    first = parts[0]
    for part in parts:
        for name in names:
            if name not in part.attributes:
                raise FileError(part.path, f"is damaged: it does not say its {name}")
            one, other = first.attributes[name], part.attributes[name]
            if str(one) != str(other):
                raise FileUsageError(
                    part.path,
                    f"is of another sweep than {first.path}: its {name} is "
                    f"{_difference(other, one)}",
                )
        if part.count != first.count:
            raise FileUsageError(
                part.path,
                f"is part {part.number}/{part.count}, but {first.path} is part "
                f"{first.number}/{first.count}: all must be of as many",
            )
    found: dict[int, Path] = {}
    for part in parts:
        if part.number in found:
            raise FileUsageError(
                part.path,
                f"is part {part.number}/{part.count}, and so is {found[part.number]}",
            )
        found[part.number] = part.path
    missing = [f"{n}/{first.count}" for n in range(1, first.count + 1) if n not in found]
    if missing:
        word = "part" if len(missing) == 1 else "parts"
        raise FileUsageError(first.path, f"needs {word} {', '.join(missing)} of its sweep, too")


def _difference(value: object, other: object) -> str:
    """Return in what a value differs from another: the lines of a text, or all of it."""
    lines = str(value).splitlines()
    others = str(other).splitlines()
    only = ", ".join(line for line in lines if line not in others)
    rest = ", ".join(line for line in others if line not in lines)
    return f"{only[:_LONGEST_VALUE]!r}, not {rest[:_LONGEST_VALUE]!r}"


def _order(parts: Sequence[Part]) -> list[tuple[Part, int]]:
    """Return all blocks of all parts in the order of their designs.

    Raises
    ------
    FileError
        If blocks overlap or leave designs out.
    """
    blocks = sorted(
        ((part.ranges[block], part, block) for part in parts for block in range(len(part.ranges))),
        key=lambda each: each[0],
    )
    end = 0
    for (start, stop), part, _ in blocks:
        if start != end or stop <= start:
            raise FileError(part.path, f"is damaged: a block begins at design {start}, not {end}")
        end = stop
    if end != parts[0].designs:
        raise FileError(parts[0].path, f"is damaged: blocks end at {end} of {parts[0].designs}")
    return [(part, block) for _, part, block in blocks]
