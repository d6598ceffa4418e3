"""Reading result files, lazily."""

from __future__ import annotations

import functools
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import (
    InputError,
    UnknownNameError,
)
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.normalisation import Extremes, NormalisedFunction
from fivebar_atlas.mechanisms.quantities import (
    MODE,
    THRESHOLD,
    Quantity,
)
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store.opening import open_hdf5, reading
from fivebar_atlas.store.provenance import interpret
from fivebar_atlas.store.schema import check_datasets

if TYPE_CHECKING:
    import h5py

# A stored threshold is found again by a number that differs in the last digits.
_SAME_THRESHOLD = 1e-12


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
        with reading(self.path):
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
        with reading(self.path):
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
            Shape (designs,). What the quantity does not depend on is ignored, a mode pair that
            the mechanism has not excepted.

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
        self._parse_mode(mode)
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
        label = self._parse_mode(mode)
        if label is None and len(self.modes) == 1:
            return 0
        if label not in self.modes:
            raise InputError("mode", mode, f"one of those in {self.path}: {', '.join(self.modes)}")
        return self.modes.index(label)

    def _parse_mode(self, mode: str | None) -> str | None:
        """Return the canonical label of a mode pair, None for none; raise UnknownNameError."""
        try:
            return mode if mode is None else self.mechanism.parse_mode(mode)
        except UnknownNameError as error:
            raise self.unknown(error.name, error.value, error.known) from None

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
    path = Path(path)
    file, attributes = open_hdf5(path)
    try:
        mechanism, settings = interpret(path, attributes)
        with reading(path):
            check_datasets(path, file, mechanism, mechanism.stored_arrays(settings), settings)
    except BaseException:
        file.close()
        raise
    return Atlas(path, file, mechanism, settings, attributes)
