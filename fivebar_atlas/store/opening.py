"""Opening HDF5 files that may be missing, damaged or of another kind."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fivebar_atlas import __version__
from fivebar_atlas.errors import FileError, FileUsageError
from fivebar_atlas.store.seal import check_seal

if TYPE_CHECKING:
    import h5py


def open_hdf5(path: Path) -> tuple[h5py.File, dict[str, Any]]:
    """Open a file for reading; return it and its root attributes.

    Raises
    ------
    FileUsageError
        If there is no such file.
    FileError
        If it cannot be read, is not an HDF5 file or is damaged.
    """
    import h5py

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
    with reading(path):
        check_seal(path)
    with reading(path):
        # Result files never change once they have their name, so no lock is needed.
        file = h5py.File(path, "r", locking=False)
    try:
        with reading(path):
            return file, {name: plain_attribute(value) for name, value in file.attrs.items()}
    except BaseException:
        file.close()
        raise


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the root attribute ``format``, what a file says it is; empty where there is none."""
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            return str(plain_attribute(file.attrs.get("format", "")))
    except (OSError, RuntimeError):
        return ""


def check_version(path: Path, attributes: Mapping[str, Any], newest: int) -> None:
    """Raise FileError unless the format version of a file can be read by this program."""
    version = attributes.get("format_version")
    if not isinstance(version, int):
        raise FileError(path, "is damaged: it does not say its format version")
    if version > newest:
        raise FileError(
            path,
            f"has format version {version}; this program ({__version__}) reads up to "
            f"{newest}, a newer one is needed",
        )


@contextlib.contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn whatever h5py raises on a damaged file into one error."""
    try:
        yield
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError) as error:
        detail = " ".join(str(error).split())
        raise FileError(path, f"is damaged: {detail}") from None


def plain_attribute(value: Any) -> Any:
    """Return an attribute as a plain Python value."""
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    return value.item() if isinstance(value, np.generic) else value
