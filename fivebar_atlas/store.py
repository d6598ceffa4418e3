"""The result file: its HDF5 format, written whole or not at all, and read lazily.

The format is described in ``docs/format.md``; this is the only module that knows HDF5.
"""

from __future__ import annotations

import contextlib
import datetime
import functools
import importlib.metadata
import io
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from fivebar_atlas import __version__, mechanisms
from fivebar_atlas.errors import (
    AtlasError,
    FileError,
    FileUsageError,
    InputError,
    UnknownNameError,
)
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.normalisation import Extremes, NormalisedFunction
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    MODE,
    THRESHOLD,
    Flags,
    NormalisedProduct,
    Quantity,
)
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.output_file import check_output, put_in_place, unwritable
from fivebar_atlas.unfinished_sweep import ASSEMBLED, UnfinishedSweep

if TYPE_CHECKING:
    import h5py

FORMAT = "fivebar-atlas"
FORMAT_VERSION = 1

# A chunk holds at most so many bytes, and so many designs.
_CHUNK_BYTES = 1 << 20
_CHUNK_DESIGNS = 16384

# Blocks are written so many designs at a time, because each write to a dataset costs.
_SLAB_DESIGNS = 4096

# A stored threshold is found again by a number that differs in the last digits.
_SAME_THRESHOLD = 1e-12


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
        Every design, shape (designs, parameters).
    ranges
        First design and the one after the last of every block.
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
        ranges: Sequence[tuple[int, int]],
        *,
        resume: bool = False,
        overwrite: bool = False,
        command_line: str = "",
    ) -> None:
        self.output = Path(output)
        self._settings = settings
        self._mechanism = mechanisms.get(settings.mechanism)
        self._designs = designs
        self._ranges = ranges
        self._overwrite = overwrite
        self._command_line = command_line
        check_output(self.output, overwrite)
        self._blocks = UnfinishedSweep(
            self.output,
            _identity(settings),
            ranges,
            np.dtype(
                [
                    (array.name, array.dtype, array.lengths)
                    for array in self._mechanism.result_arrays(settings)
                ]
            ),
            resume=resume,
            restart=overwrite,
        )

    @property
    def finished(self) -> frozenset[int]:
        """Indices of the blocks that need not be computed again."""
        return frozenset(self._blocks.finished)

    def add(self, index: int, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Keep the results of a block; they survive whatever ends the process.

        Parameters
        ----------
        index
            Number of the block.
        arrays
            One array for every quantity and error companion.

        Raises
        ------
        FileError
            If the disk is full or fails; the finished blocks are kept.
        """
        self._blocks.add(index, arrays)

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
        temporary = self._blocks.path / ASSEMBLED
        try:
            with temporary.open("w+b", buffering=0) as file:
                guarded = _GuardedFile(file)
                self._write_hdf5(guarded)
                guarded.check()
                os.fsync(file.fileno())
            put_in_place(temporary, self.output, self._overwrite)
        except OSError as error:
            kept = "all finished blocks are kept, --resume goes on with them"
            raise unwritable(self.output, error, kept) from None
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)
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

    def _write_hdf5(self, file: _GuardedFile) -> None:
        """Write all of the file, block by block; the caller checks for faults of the disk."""
        import h5py

        with h5py.File(file, "w") as target:
            target.attrs.update(_provenance(self._settings, self._command_line))
            datasets = self._create_datasets(target)
            for start, records in self._slabs():
                # Checked here and not only at the end, lest HDF5 reads back what is not there.
                file.check()
                for name in records.dtype.names or ():
                    if datasets[name].size:
                        datasets[name][start : start + len(records)] = records[name]
            for product in self._mechanism.normalised:
                self._write_normalised(file, product, datasets)

    def _write_normalised(
        self, file: _GuardedFile, product: NormalisedProduct, datasets: Mapping[str, h5py.Dataset]
    ) -> None:
        """Write a normalised product: the extremes of its factors, then its values."""
        factors = tuple(self._mechanism.quantity(name) for name in product.factors)
        extremes = tuple(
            Extremes.of_parts(
                (part[factor.name], part.get(factor.error_name, np.zeros(1)))
                for _, part in self._read_back(file, [factor], datasets)
            )
            for factor in factors
        )
        target = datasets[product.quantity.name]
        target.attrs.update(_normalisation(product, extremes))
        if not target.size:
            return
        function = NormalisedFunction(product, factors, extremes)
        for designs, part in self._read_back(file, factors, datasets):
            for name, values in function.arrays(part).items():
                datasets[name][designs] = values

    def _read_back(
        self,
        file: _GuardedFile,
        quantities: Sequence[Quantity],
        datasets: Mapping[str, h5py.Dataset],
    ) -> Iterator[tuple[slice, dict[str, FloatArray]]]:
        """Yield designs and what was written for them, not too many at a time."""
        names = [quantity.name for quantity in quantities]
        names += [quantity.error_name for quantity in quantities if quantity.has_error]
        for start in range(0, len(self._designs), _SLAB_DESIGNS):
            designs = slice(start, min(start + _SLAB_DESIGNS, len(self._designs)))
            # Nothing of it may still wait to be written, and then fail.
            datasets[names[0]].file.flush()
            file.check()
            yield designs, {name: datasets[name][designs] for name in names}

    def _slabs(self) -> Iterator[tuple[int, npt.NDArray[Any]]]:
        """Yield first design and records of several blocks at a time, in their order."""
        first, waiting, count = 0, [], 0
        for index, (_, stop) in enumerate(self._ranges):
            records = self._blocks.read(index)
            if records is None:
                raise FileError(
                    self._blocks.path,
                    f"block {index} is missing or damaged; --resume computes it again",
                )
            waiting.append(records)
            count += len(records)
            if count >= _SLAB_DESIGNS or index == len(self._ranges) - 1:
                yield first, np.concatenate(waiting)
                first, waiting, count = stop, [], 0

    def _create_datasets(self, target: h5py.File) -> dict[str, h5py.Dataset]:
        """Create all datasets; return those of results, which are to be filled."""
        axes = self._mechanism.axes(self._settings)
        count = len(self._designs)
        lengths = {DESIGN: count, **{axis.name: len(axis) for axis in axes}}
        for name, length in lengths.items():
            scale = target.create_dataset(name, (length,), np.dtype(">f4"), track_times=False)
            # As the netCDF-4 library marks a dimension that has no coordinate.
            scale.make_scale(f"This is a netCDF dimension but not a netCDF variable.{length:10d}")
        for number, parameter in enumerate(self._mechanism.parameters):
            dataset = _create(target, parameter.name, (DESIGN,), np.dtype(np.float64), lengths)
            _describe(dataset, parameter.unit, parameter.long_name)
            dataset[...] = self._designs[:, number]
        for axis in axes:
            for column in axis.columns:
                dataset = _create(target, column.name, (axis.name,), column.values.dtype, lengths)
                _describe(dataset, column.unit, column.long_name, column.flags)
                if len(axis):
                    dataset[...] = column.values
        filled: dict[str, h5py.Dataset] = {}
        for array in self._mechanism.stored_arrays(self._settings):
            quantity = array.quantity
            dataset = _create(target, array.name, quantity.dimensions, array.dtype, lengths)
            flags = None if array.is_error else quantity.flags
            _describe(dataset, quantity.unit, array.long_name, flags)
            if quantity.has_error and not array.is_error:
                dataset.attrs["ancillary_variables"] = quantity.error_name
            coordinates = [
                *(parameter.name for parameter in self._mechanism.parameters),
                *(
                    column.name
                    for axis in axes
                    if axis.name in quantity.dimensions
                    for column in axis.columns
                ),
            ]
            dataset.attrs["coordinates"] = " ".join(coordinates)
            filled[array.name] = dataset
        return filled


class _GuardedFile(io.RawIOBase):
    """The file that HDF5 writes to, which never tells HDF5 of a fault.

    HDF5 cannot close a file whose disk is full, and ends the process when it tries again
    on the way out. So a fault is kept here, everything after it is swallowed, and whoever
    uses the file asks with :meth:`check` whether there was one.
    """

    def __init__(self, file: io.FileIO) -> None:
        self._file = file
        self._fault: BaseException | None = None

    def check(self) -> None:
        """Raise the first fault, if there was one."""
        if self._fault is not None:
            raise self._fault

    def write(self, data: Any) -> int:
        """Write all of the data."""
        view = memoryview(data).cast("B")
        size = view.nbytes
        if self._fault is None:
            # Not only OSError: an interrupt must not end up in the HDF5 library either.
            try:
                while view.nbytes:
                    view = view[self._file.write(view) :]
            except BaseException as fault:
                self._fault = fault
        return size

    def readinto(self, buffer: Any) -> int:
        """Read into the buffer; after a fault, zeros stand for what was never written."""
        view = memoryview(buffer).cast("B")
        if self._fault is None:
            return self._file.readinto(view)
        view[:] = bytes(view.nbytes)
        return view.nbytes

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move to a position."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """Return the position."""
        return self._file.tell()

    def truncate(self, size: int | None = None) -> int:
        """Set the size."""
        if self._fault is None:
            try:
                return self._file.truncate(size)
            except OSError as fault:
                self._fault = fault
        return size or 0

    def readable(self) -> bool:
        """Return that HDF5 may read back what it wrote."""
        return True

    def writable(self) -> bool:
        """Return that HDF5 may write."""
        return True

    def seekable(self) -> bool:
        """Return that HDF5 may move."""
        return True


class Atlas:
    """A result file opened for reading; made by :func:`open_atlas`.

    Arrays are read when they are asked for. It may be used as a context manager, which
    closes the file; otherwise the file is closed with the last reference to the atlas.

    Attributes
    ----------
    path
        The file.
    mechanism
        The mechanism that was swept.
    settings
        What was computed.
    attributes
        Root attributes of the file: how it was made.
    """

    def __init__(
        self,
        path: Path,
        file: h5py.File,
        mechanism: Mechanism,
        settings: SweepSettings,
        attributes: dict[str, Any],
    ) -> None:
        self.path = path
        self.mechanism = mechanism
        self.settings = settings
        self.attributes = attributes
        self._file = file

    def __repr__(self) -> str:
        return (
            f"<Atlas {str(self.path)!r}: {self.mechanism.name}, {len(self)} designs, "
            f"{', '.join(self.modes)}>"
        )

    def __len__(self) -> int:
        return int(self._file[self.mechanism.parameters[0].name].shape[0])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; arrays that were read stay valid."""
        self._file.close()

    @property
    def modes(self) -> tuple[str, ...]:
        """Canonical labels of the stored mode pairs, in the order of the mode axis."""
        return self.settings.modes

    @property
    def lci_thresholds(self) -> tuple[float, ...]:
        """LCI thresholds, in the order of the threshold axis."""
        return self.settings.lci_thresholds

    @property
    def names(self) -> tuple[str, ...]:
        """Names of everything that has a value for each design."""
        parameters = (parameter.name for parameter in self.mechanism.parameters)
        arrays = self.mechanism.stored_arrays(self.settings)
        return (*parameters, *(array.name for array in arrays))

    @functools.cached_property
    def designs(self) -> FloatArray:
        """Every design, shape (designs, parameters)."""
        return np.column_stack([self[parameter.name] for parameter in self.mechanism.parameters])

    def quantity(self, name: str) -> Quantity:
        """Return unit, meaning and axes of a quantity; raise UnknownNameError."""
        try:
            return self.mechanism.quantity(name)
        except UnknownNameError as error:
            raise self.unknown("quantity", name, error.known) from None

    def unknown(self, name: str, value: str, known: Iterable[str]) -> UnknownNameError:
        """Return the error for a name that the file does not have, but maybe another's has.

        Parameters
        ----------
        name
            Name of the input.
        value
            What is not known.
        known
            What the file has.
        """
        return mechanisms.unknown_name(self.mechanism, name, value, known)

    def normalised(self, name: str) -> NormalisedFunction:
        """Return a normalised product as a function, with the extremes of this atlas.

        Raises
        ------
        UnknownNameError
            If the mechanism has no such normalised product.
        FileError
            If the extremes are damaged.
        """
        products = {each.quantity.name: each for each in self.mechanism.normalised}
        if name not in products:
            raise UnknownNameError("normalised quantity", name, products)
        product = products[name]
        lengths = {
            array.name: array.lengths for array in self.mechanism.result_arrays(self.settings)
        }
        with _reading(self.path):
            attributes = self._file[name].attrs
            extremes = tuple(
                Extremes(
                    *(np.asarray(attributes[f"{factor}_{each}"]) for each in Extremes._fields)
                ).shaped(lengths[factor])
                for factor in product.factors
            )
        factors = tuple(self.quantity(factor) for factor in product.factors)
        return NormalisedFunction(product, factors, extremes)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return a whole dataset.

        Parameters
        ----------
        name
            A parameter, a quantity, an error companion or a column of an axis.

        Raises
        ------
        UnknownNameError
            If there is no such dataset.
        FileError
            If it is damaged.
        """
        columns = [
            column.name for axis in self.mechanism.axes(self.settings) for column in axis.columns
        ]
        known = [*self.names, *columns]
        if name not in known:
            raise self.unknown("quantity", name, known)
        return self.read(name, ...)

    def read(self, name: str, selection: Any) -> npt.NDArray[Any]:
        """Return a part of a dataset, given as an index; raise FileError if it is damaged."""
        with _reading(self.path):
            values: npt.NDArray[Any] = self._file[name][selection]
        return values

    def select(
        self, name: str, mode: str | None = None, lci: float | None = None
    ) -> npt.NDArray[Any]:
        """Return one value for each design.

        Parameters
        ----------
        name
            A parameter, a quantity or an error companion.
        mode
            Mode pair; needed only where the file holds several.
        lci
            LCI threshold; needed only where the file holds several.

        Returns
        -------
        ndarray
            Shape (designs,). What the quantity does not depend on is ignored.

        Raises
        ------
        UnknownNameError
            If there is no such quantity or mode pair.
        InputError
            If the mode pair or threshold is not in the file, or must be chosen.
        FileError
            If the dataset is damaged.
        """
        if name not in self.names:
            raise self.unknown("quantity", name, self.names)
        return self.read(name, (slice(None), *self._indices(name, mode, lci)))

    def _indices(self, name: str, mode: str | None, lci: float | None) -> tuple[int, ...]:
        """Return the index along every axis of a quantity but the design axis."""
        for array in self.mechanism.stored_arrays(self.settings):
            if array.name == name:
                dimensions = array.quantity.dimensions[1:]
                break
        else:
            return ()
        find = {MODE: lambda: self.mode_index(mode), THRESHOLD: lambda: self.lci_index(lci)}
        return tuple(find[dimension]() for dimension in dimensions)

    def mode_index(self, mode: str | None) -> int:
        """Return the place of a mode pair on the mode axis; raise as :meth:`select` does."""
        try:
            label = mode if mode is None else self.mechanism.parse_mode(mode)
        except UnknownNameError as error:
            raise self.unknown(error.name, error.value, error.known) from None
        if label is None and len(self.modes) == 1:
            return 0
        if label not in self.modes:
            raise InputError("mode", mode, f"one of those in {self.path}: {', '.join(self.modes)}")
        return self.modes.index(label)

    def lci_index(self, lci: float | None) -> int:
        """Return the place of a threshold on its axis; raise as :meth:`select` does."""
        if lci is None and len(self.lci_thresholds) == 1:
            return 0
        for index, threshold in enumerate(self.lci_thresholds):
            if lci is not None and abs(lci - threshold) <= _SAME_THRESHOLD:
                return index
        stored = ", ".join(f"{value!r}" for value in self.lci_thresholds) or "none"
        raise InputError("lci", lci, f"one of those in {self.path}: {stored}")


def open_atlas(path: str | os.PathLike[str]) -> Atlas:
    """Open a result file for reading.

    Parameters
    ----------
    path
        A file written by ``atlas sweep``.

    Returns
    -------
    Atlas
        The open file.

    Raises
    ------
    FileUsageError
        If there is no such file.
    FileError
        If it is not a result file, is damaged, or of a newer format.

    Examples
    --------
    >>> atlas = open_atlas("paper.h5")  # doctest: +SKIP
    >>> gci = atlas.select("gci", mode="+-/up")  # doctest: +SKIP
    """
    import h5py

    path = Path(path)
    try:
        with path.open("rb"):
            pass
    except (FileNotFoundError, NotADirectoryError):
        raise FileUsageError(path, "there is no such file") from None
    except IsADirectoryError:
        raise FileUsageError(path, "is a folder, not a result file") from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from None
    if not h5py.is_hdf5(path):
        raise FileError(path, "is not an HDF5 file")
    with _reading(path):
        # Result files never change once they have their name, so no lock is needed.
        file = h5py.File(path, "r", locking=False)
    try:
        with _reading(path):
            attributes = {name: _python(value) for name, value in file.attrs.items()}
        mechanism, settings = _interpret(path, attributes)
        with _reading(path):
            _check_datasets(path, file, mechanism, settings)
    except BaseException:
        file.close()
        raise
    return Atlas(path, file, mechanism, settings, attributes)


def is_complete(output: str | os.PathLike[str], settings: SweepSettings) -> bool:
    """Return whether a file holds the result of these settings by these kernels."""
    try:
        with open_atlas(output) as atlas:
            identity = _identity(settings)
            return all(atlas.attributes.get(name) == value for name, value in identity.items())
    except AtlasError:
        return False


def _identity(settings: SweepSettings) -> dict[str, str]:
    """Return what must be the same for numbers to be the same, bit for bit."""
    from fivebar_atlas import config, jit

    return {
        "configuration": config.render_settings(settings),
        "kernel_hash": jit.kernel_hash(),
        "numba_version": importlib.metadata.version("numba"),
        "numpy_version": importlib.metadata.version("numpy"),
    }


def _provenance(settings: SweepSettings, command_line: str) -> dict[str, Any]:
    """Return the root attributes."""
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "mechanism": settings.mechanism,
        "package_version": __version__,
        **_identity(settings),
        "command_line": command_line,
        "created": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
    }


def _create(
    target: h5py.File,
    name: str,
    dimensions: Sequence[str],
    dtype: np.dtype[Any],
    lengths: Mapping[str, int],
) -> h5py.Dataset:
    """Create a dataset along named dimensions."""
    shape = tuple(lengths[dimension] for dimension in dimensions)
    options: dict[str, Any] = {}
    if all(shape):
        row_bytes = dtype.itemsize * int(np.prod(shape[1:], dtype=np.int64))
        rows = max(1, min(shape[0], _CHUNK_DESIGNS, _CHUNK_BYTES // row_bytes))
        options = {
            "chunks": (rows, *shape[1:]),
            "compression": "gzip",
            "compression_opts": 1,
            "shuffle": True,
            "fletcher32": True,
            # A chunk is filled by several blocks; it must stay in memory until it is full.
            "rdcc_nbytes": max(_CHUNK_BYTES, 2 * rows * row_bytes),
        }
    dataset = target.create_dataset(name, shape, dtype, track_times=False, **options)
    for axis, dimension in enumerate(dimensions):
        dataset.dims[axis].attach_scale(target[dimension])
    return dataset


def _describe(dataset: h5py.Dataset, unit: str, long_name: str, flags: Flags | None = None) -> None:
    """Attach unit, meaning and flag meanings to a dataset."""
    dataset.attrs["units"] = unit
    dataset.attrs["long_name"] = long_name
    if flags is not None:
        kind = "flag_masks" if flags.masks else "flag_values"
        dataset.attrs[kind] = np.array(flags.values, dtype=dataset.dtype)
        dataset.attrs["flag_meanings"] = " ".join(flags.meanings)


def _normalisation(product: NormalisedProduct, extremes: Sequence[Extremes]) -> dict[str, Any]:
    """Return the attributes that say how a product is normalised."""
    attributes: dict[str, Any] = {
        "normalisation": product.normalisation,
        "factors": " ".join(product.factors),
    }
    for factor, found in zip(product.factors, extremes, strict=True):
        for name, values in zip(Extremes._fields, found, strict=True):
            # The netCDF data model has no attributes of more than one dimension.
            attributes[f"{factor}_{name}"] = values.ravel()
    return attributes


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Turn whatever h5py raises on a damaged file into one error."""
    try:
        yield
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError) as error:
        detail = " ".join(str(error).split())
        raise FileError(path, f"is damaged: {detail}") from None


def _python(value: Any) -> Any:
    """Return an attribute as a plain Python value."""
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    return value.item() if isinstance(value, np.generic) else value


def _interpret(path: Path, attributes: Mapping[str, Any]) -> tuple[Mechanism, SweepSettings]:
    """Return mechanism and settings of a file from its root attributes."""
    from fivebar_atlas import config

    if attributes.get("format") == f"{FORMAT}-trajectory":
        raise FileError(path, "is a trajectory, not an atlas; 'atlas info' says what is in it")
    if attributes.get("format") != FORMAT:
        raise FileError(path, "is an HDF5 file, but not one written by atlas sweep")
    version = attributes.get("format_version")
    if not isinstance(version, int):
        raise FileError(path, "is damaged: it does not say its format version")
    if version > FORMAT_VERSION:
        raise FileError(
            path,
            f"has format version {version}; this program ({__version__}) reads up to "
            f"{FORMAT_VERSION}, a newer one is needed",
        )
    try:
        settings = config.settings_from_text(str(attributes.get("configuration")), str(path))
        return mechanisms.get(settings.mechanism), settings
    except AtlasError as error:
        raise FileError(path, f"holds a configuration that cannot be read: {error}") from None


def _check_datasets(
    path: Path, file: h5py.File, mechanism: Mechanism, settings: SweepSettings
) -> None:
    """Raise FileError unless every declared dataset is there, in type and shape."""
    count = file[mechanism.parameters[0].name].shape[0]
    expected: dict[str, tuple[tuple[int, ...], np.dtype[Any]]] = {
        parameter.name: ((count,), np.dtype(np.float64)) for parameter in mechanism.parameters
    }
    for axis in mechanism.axes(settings):
        for column in axis.columns:
            expected[column.name] = (len(axis),), column.values.dtype
    for array in mechanism.stored_arrays(settings):
        expected[array.name] = (count, *array.lengths), array.dtype
    for name, (shape, dtype) in expected.items():
        if name not in file:
            raise FileError(path, f"is damaged: {name!r} is missing")
        if file[name].shape != shape or file[name].dtype != dtype:
            raise FileError(
                path,
                f"is damaged: {name!r} has shape {file[name].shape} and type "
                f"{file[name].dtype}, not {shape} and {dtype}",
            )
