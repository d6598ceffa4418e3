"""The datasets of a result file: dimensions, types, units, meanings, compression."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fivebar_atlas.errors import (
    FileError,
)
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.normalisation import Extremes
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    Flags,
    NormalisedProduct,
    ResultArray,
)
from fivebar_atlas.mechanisms.settings import SweepSettings

if TYPE_CHECKING:
    import h5py

# A chunk holds at most so many bytes, and so many designs.
_CHUNK_BYTES = 1 << 20
_CHUNK_DESIGNS = 16384

#: The dimension of the blocks of a part, and what says where they are.
BLOCK = "block"
RANGES = {
    "block_start": "first design of the block, counted from 0 in the whole sweep",
    "block_stop": "design after the last of the block",
}


def create_datasets(
    target: h5py.File,
    mechanism: Mechanism,
    settings: SweepSettings,
    designs: FloatArray,
    arrays: Sequence[ResultArray],
) -> dict[str, h5py.Dataset]:
    """Create all datasets; return those of results, which are to be filled.

    Parameters
    ----------
    target
        The file.
    mechanism, settings
        What was computed.
    designs
        Every design of the file, shape (designs, parameters).
    arrays
        The arrays of results that are stored.
    """
    axes = mechanism.axes(settings)
    count = len(designs)
    lengths = {DESIGN: count, **{axis.name: len(axis) for axis in axes}}
    for name, length in lengths.items():
        scale = target.create_dataset(name, (length,), np.dtype(">f4"), track_times=False)
        _mark_dimension(scale)
    for number, parameter in enumerate(mechanism.parameters):
        dataset = _create(target, parameter.name, (DESIGN,), np.dtype(np.float64), lengths)
        _describe(dataset, parameter.unit, parameter.long_name)
        dataset[...] = designs[:, number]
    for axis in axes:
        for column in axis.columns:
            dataset = _create(target, column.name, (axis.name,), column.values.dtype, lengths)
            _describe(dataset, column.unit, column.long_name, column.flags)
            if len(axis):
                dataset[...] = column.values
    filled: dict[str, h5py.Dataset] = {}
    for array in arrays:
        quantity = array.quantity
        dataset = _create(target, array.name, quantity.dimensions, array.dtype, lengths)
        flags = None if array.is_error else quantity.flags
        _describe(dataset, quantity.unit, array.long_name, flags)
        if quantity.has_error and not array.is_error:
            dataset.attrs["ancillary_variables"] = quantity.error_name
        coordinates = [
            *(parameter.name for parameter in mechanism.parameters),
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


def create_ranges(target: h5py.File, ranges: Sequence[tuple[int, int]]) -> None:
    """Add the blocks of a part: ``block_start`` and ``block_stop``, counted in the whole sweep."""
    lengths = {BLOCK: len(ranges)}
    scale = target.create_dataset(BLOCK, (len(ranges),), np.dtype(">f4"), track_times=False)
    _mark_dimension(scale)
    for name, values in zip(RANGES, np.array(ranges, dtype=np.int64).T, strict=True):
        dataset = _create(target, name, (BLOCK,), np.dtype(np.int64), lengths)
        _describe(dataset, "1", RANGES[name])
        dataset[...] = values


def _mark_dimension(scale: h5py.Dataset) -> None:
    """Mark a dataset as a dimension without coordinate, as the netCDF-4 library does."""
    scale.make_scale(f"This is a netCDF dimension but not a netCDF variable.{len(scale):10d}")


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


def normalisation_attributes(
    product: NormalisedProduct, extremes: Sequence[Extremes]
) -> dict[str, Any]:
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


def check_datasets(
    path: Path,
    file: h5py.File,
    mechanism: Mechanism,
    arrays: Sequence[ResultArray],
    settings: SweepSettings,
) -> None:
    """Raise FileError unless every declared dataset is there, in type and shape."""
    count = file[mechanism.parameters[0].name].shape[0]
    expected: dict[str, tuple[tuple[int, ...], np.dtype[Any]]] = {
        parameter.name: ((count,), np.dtype(np.float64)) for parameter in mechanism.parameters
    }
    for axis in mechanism.axes(settings):
        for column in axis.columns:
            expected[column.name] = (len(axis),), column.values.dtype
    for array in arrays:
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
