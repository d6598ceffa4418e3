"""Result files put together from records of designs, whole or not at all."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.normalisation import Extremes, NormalisedFunction
from fivebar_atlas.mechanisms.quantities import NormalisedProduct, Quantity
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.output_file import put_in_place, unwritable
from fivebar_atlas.store.guarded_file import GuardedFile
from fivebar_atlas.store.schema import (
    create_datasets,
    create_ranges,
    normalisation_attributes,
)
from fivebar_atlas.store.seal import seal

if TYPE_CHECKING:
    import h5py

#: First design and the one after the last of a block.
Range = tuple[int, int]

# Blocks are written so many designs at a time, because each write to a dataset costs.
_SLAB_DESIGNS = 4096


@dataclasses.dataclass(frozen=True, eq=False)
class ResultFile:
    """What a result file, or a file with a part of one, is to hold.

    Attributes
    ----------
    settings
        What was computed.
    designs
        The designs of the file, shape (designs, parameters).
    attributes
        Root attributes.
    ranges
        For a part, first design and the one after the last of each of its blocks, counted in
        the whole sweep; None for a whole atlas.
    """

    settings: SweepSettings
    designs: FloatArray
    attributes: Mapping[str, Any]
    ranges: Sequence[Range] | None = None

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return mechanisms.get(self.settings.mechanism)

    def write(
        self,
        temporary: Path,
        output: Path,
        records: Iterable[npt.NDArray[Any]],
        *,
        overwrite: bool,
        kept: str = "",
    ) -> None:
        """Write the file under a temporary name, and give it its own when it is complete.

        Parameters
        ----------
        temporary, output
            Both names, on one file system.
        records
            Records of :func:`record_type`, of consecutive designs.
        overwrite
            Whether a file of this name may be replaced.
        kept
            What is not lost if the disk fails, as a phrase.

        Raises
        ------
        FileError
            If the disk is full or fails; an existing output is untouched.
        FileUsageError
            If the output has come into existence in the meantime.
        """
        try:
            with temporary.open("w+b", buffering=0) as file:
                guarded = GuardedFile(file)
                guarded.run(lambda: self._write_hdf5(guarded, records))
                guarded.check()
                seal(file)
                os.fsync(file.fileno())
            put_in_place(temporary, output, overwrite)
        except OSError as error:
            raise unwritable(output, error, kept) from None
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)

    def _write_hdf5(self, file: GuardedFile, records: Iterable[npt.NDArray[Any]]) -> None:
        """Write all of the file; the caller checks for faults of the disk."""
        import h5py

        mechanism, settings = self.mechanism, self.settings
        is_whole = self.ranges is None
        arrays = mechanism.stored_arrays if is_whole else mechanism.result_arrays
        with h5py.File(file, "w") as target:
            target.attrs.update(self.attributes)
            datasets = create_datasets(target, mechanism, settings, self.designs, arrays(settings))
            if self.ranges is not None:
                create_ranges(target, self.ranges)
            start = 0
            for slab in _slabs(records):
                # Checked here and not only at the end, lest HDF5 reads back what is not there.
                file.check()
                for name in slab.dtype.names or ():
                    if datasets[name].size:
                        datasets[name][start : start + len(slab)] = slab[name]
                start += len(slab)
            for product in mechanism.normalised if is_whole else ():
                self._write_normalised(file, product, datasets)

    def _write_normalised(
        self, file: GuardedFile, product: NormalisedProduct, datasets: Mapping[str, h5py.Dataset]
    ) -> None:
        """Write a normalised product: the extremes of its factors, then its values."""
        factors = tuple(self.mechanism.quantity(name) for name in product.factors)
        extremes = tuple(
            Extremes.of_parts(
                (part[factor.name], part.get(factor.error_name, np.zeros(1)))
                for _, part in self._read_back(file, [factor], datasets)
            )
            for factor in factors
        )
        target = datasets[product.quantity.name]
        target.attrs.update(normalisation_attributes(product, extremes))
        if not target.size:
            return
        function = NormalisedFunction(product, factors, extremes)
        for designs, part in self._read_back(file, factors, datasets):
            for name, values in function.arrays(part).items():
                datasets[name][designs] = values

    def _read_back(
        self,
        file: GuardedFile,
        quantities: Sequence[Quantity],
        datasets: Mapping[str, h5py.Dataset],
    ) -> Iterator[tuple[slice, dict[str, FloatArray]]]:
        """Yield designs and what was written for them, not too many at a time."""
        names = [quantity.name for quantity in quantities]
        names += [quantity.error_name for quantity in quantities if quantity.has_error]
        for start in range(0, len(self.designs), _SLAB_DESIGNS):
            designs = slice(start, min(start + _SLAB_DESIGNS, len(self.designs)))
            # Nothing of it may still wait to be written, and then fail.
            datasets[names[0]].file.flush()
            file.check()
            yield designs, {name: datasets[name][designs] for name in names}


def record_type(mechanism: Mechanism, settings: SweepSettings) -> np.dtype[Any]:
    """Return the type of a design's record: one field for each result array."""
    return np.dtype(
        [(array.name, array.dtype, array.lengths) for array in mechanism.result_arrays(settings)]
    )


def _slabs(records: Iterable[npt.NDArray[Any]]) -> Iterator[npt.NDArray[Any]]:
    """Yield the records of several blocks at a time, in their order."""
    waiting: list[npt.NDArray[Any]] = []
    for block in records:
        waiting.append(block)
        if sum(map(len, waiting)) >= _SLAB_DESIGNS:
            yield np.concatenate(waiting)
            waiting = []
    if waiting:
        yield np.concatenate(waiting)
