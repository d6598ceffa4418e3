"""Collecting the results of a sweep for its result file."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import AtlasError, FileError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.output_file import check_output
from fivebar_atlas.store.assembly import Range, ResultFile, record_type
from fivebar_atlas.store.parts import Part
from fivebar_atlas.store.provenance import identity, joined, part_attributes, provenance
from fivebar_atlas.store.reading import open_atlas
from fivebar_atlas.unfinished_sweep import UnfinishedSweep, remove_leftover


class AtlasWriter:
    """Collects the blocks of a sweep and assembles the result file from them.

    Use it as a context manager: leaving it keeps the finished blocks for a later
    ``resume``, unless :meth:`assemble` has made them into the result file.

    Parameters
    ----------
    output
        The result file.
    settings
        What is computed.
    designs
        Every design of the sweep, shape (designs, parameters).
    ranges
        First design and the one after the last of every block, rising: all designs, or
        those of a part.
    part
        Label of the part, ``"2/3"``, if the file is to hold a part only, which is to be merged
        with the others.
    resume
        Go on with the finished blocks of an interrupted sweep, if there are any.
    overwrite
        Replace an existing result file, once the new one is complete.
    command_line
        The command, for the record.

    Raises
    ------
    FileUsageError
        If the output exists (without ``overwrite``), its folder does not, or there are
        blocks that may not be gone on with.
    FileError
        If the output cannot be written.
    """

    def __init__(
        self,
        output: str | os.PathLike[str],
        settings: SweepSettings,
        designs: FloatArray,
        ranges: Sequence[Range],
        *,
        part: str | None = None,
        resume: bool = False,
        overwrite: bool = False,
        command_line: str = "",
    ) -> None:
        self.output = Path(output)
        self._ranges = ranges
        self._overwrite = overwrite
        own, attributes = identity(settings), provenance(settings, command_line)
        if part is None:
            self._file = ResultFile(settings, designs, attributes)
        else:
            own["part"] = part
            attributes.update(part_attributes(part, len(designs)))
            chosen = np.concatenate([designs[start:stop] for start, stop in ranges])
            self._file = ResultFile(settings, chosen, attributes, ranges)
        check_output(self.output, overwrite)
        self._blocks = UnfinishedSweep(
            self.output,
            own,
            ranges,
            record_type(self._file.mechanism, settings),
            resume=resume,
            restart=overwrite,
        )

    @property
    def finished(self) -> frozenset[int]:
        """Indices of the blocks that need not be computed again."""
        return frozenset(self._blocks.finished)

    def add(
        self,
        index: int,
        arrays: Mapping[str, npt.NDArray[Any]],
        processor: str | None = None,
    ) -> None:
        """Keep the results of a block; they survive whatever ends the process.

        Parameters
        ----------
        index
            Number of the block.
        arrays
            One array for every quantity and error companion.
        processor
            What computed them; that of this machine if None.

        Raises
        ------
        FileError
            If the disk is full or fails; the finished blocks are kept.
        """
        from fivebar_atlas import jit  # which loads numba: reading files must not wait for that

        self._blocks.add(index, arrays, processor or jit.processor())

    def assemble(self) -> None:
        """Write the result file from the blocks, all of which must be finished.

        Raises
        ------
        FileError
            If the disk is full or fails; the blocks are kept, and an existing result file
            is untouched.
        FileUsageError
            If the output has come into existence in the meantime.
        """
        processors = (processor for _, processor in self._finished_blocks())
        attributes = {**self._file.attributes, "processor": joined(processors)}
        dataclasses.replace(self._file, attributes=attributes).write(
            self._blocks.assembled,
            self.output,
            (records for records, _ in self._finished_blocks()),
            overwrite=self._overwrite,
            kept="all finished blocks are kept, --resume goes on with them",
        )
        self._blocks.remove()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._blocks.close()

    def _finished_blocks(self) -> Iterator[tuple[npt.NDArray[Any], str]]:
        """Yield the records of every block, and what computed it, in their order."""
        for index in range(len(self._ranges)):
            found = self._blocks.read(index)
            if found is None:
                raise FileError(
                    self._blocks.path,
                    f"block {index} is missing or damaged; --resume computes it again",
                )
            yield found


def is_complete(
    output: str | os.PathLike[str], settings: SweepSettings, part: str | None = None
) -> bool:
    """Return whether a file holds the result of these settings by these kernels.

    If it does, blocks that a kill has left of the very sweep are removed.

    Parameters
    ----------
    output
        The file.
    settings
        What was to be computed.
    part
        Label of the part that it is to hold; None for all.
    """
    own = identity(settings) if part is None else {**identity(settings), "part": part}
    try:
        found = open_atlas(output) if part is None else Part(Path(output))
        with contextlib.closing(found):
            complete = all(found.attributes.get(name) == value for name, value in own.items())
    except AtlasError:
        return False
    if complete:
        remove_leftover(Path(output), own)
    return complete
