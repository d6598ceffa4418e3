"""Files that hold a part of an atlas, read block by block."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import FileError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.store.assembly import Range, record_type
from fivebar_atlas.store.opening import open_hdf5, reading
from fivebar_atlas.store.provenance import PART_FORMAT, interpret
from fivebar_atlas.store.schema import RANGES, check_datasets


class Part:
    """A part of an atlas, opened for reading.

    Parameters
    ----------
    path
        The file.
    stays_open
        Whether it is held open between one reading and the next.

    Attributes
    ----------
    path
        The file.
    mechanism, settings
        What was computed.
    attributes
        Root attributes of the file: how it was made.
    number, count
        Which part it is, from 1, and of how many.
    designs
        Number of designs of the whole sweep.
    ranges
        First design and the one after the last of each of its blocks, in the whole sweep.

    Raises
    ------
    FileUsageError
        If there is no such file.
    FileError
        If it is no part of an atlas, is damaged, or of a newer format.
    """

    def __init__(self, path: Path, *, stays_open: bool = True) -> None:
        self.path = path
        self._stays_open = stays_open
        self._file, self.attributes = open_hdf5(path)
        try:
            self.mechanism, self.settings = interpret(path, self.attributes, PART_FORMAT)
            self._type = record_type(self.mechanism, self.settings)
            with reading(path):
                arrays = self.mechanism.result_arrays(self.settings)
                check_datasets(path, self._file, self.mechanism, arrays, self.settings)
                for name in ("part", "sweep_designs", "package_version", "processor"):
                    if name not in self.attributes:
                        raise FileError(path, f"is damaged: it does not say its {name}")
                self.number, self.count = map(int, str(self.attributes["part"]).split("/"))
                self.designs = int(self.attributes["sweep_designs"])
                starts, stops = (self._file[name][...].tolist() for name in RANGES)
                self.ranges: tuple[Range, ...] = tuple(zip(starts, stops, strict=True))
            if not 1 <= self.number <= self.count:
                said = self.attributes["part"]
                raise FileError(path, f"is damaged: it says that it is part {said}")
            # where the designs of each block begin in the file
            lengths = [stop - start for start, stop in self.ranges]
            self._places = np.concatenate([[0], np.cumsum(lengths)]).tolist()
            if self._places[-1] != len(self._file[self.mechanism.parameters[0].name]):
                raise FileError(path, "is damaged: its blocks are not its designs")
        except BaseException:
            self.close()
            raise
        if not stays_open:
            self.close()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def parameters(self, block: int) -> FloatArray:
        """Return the designs of a block, shape (designs, parameters)."""
        names = [each.name for each in self.mechanism.parameters]
        return np.column_stack(list(self._read(names, block)))

    def records(self, block: int) -> npt.NDArray[Any]:
        """Return the records of a block."""
        start, stop = self.ranges[block]
        records = np.empty(stop - start, dtype=self._type)
        names = self._type.names or ()
        for name, values in zip(names, self._read(names, block), strict=True):
            records[name] = values
        return records

    def _read(self, names: Sequence[str], block: int) -> Iterator[npt.NDArray[Any]]:
        """Yield what datasets hold of a block."""
        places = slice(self._places[block], self._places[block + 1])
        if not self._file:
            self._file, _ = open_hdf5(self.path)
        for name in names:
            with reading(self.path):
                values: npt.NDArray[Any] = self._file[name][places]
            yield values
        if not self._stays_open:
            self.close()
