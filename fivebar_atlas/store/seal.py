"""A checksum over a whole file, in one line behind the HDF5 data, which HDF5 does not read.

HDF5 checks the chunks of datasets, but neither their index nor attributes: a bit that flips there
can have a dataset decoded wrongly, or change a threshold, and no reader would notice.
"""

from __future__ import annotations

import os
import zlib
from pathlib import Path
from typing import IO

from fivebar_atlas.errors import FileError

_MARK = b"\nfivebar-atlas crc32 "
_LENGTH = len(_MARK) + len("89abcdef\n")
_PIECE = 1 << 20


def seal(file: IO[bytes]) -> None:
    """Append its checksum to a finished file.

    Parameters
    ----------
    file
        The file, open for reading and writing.
    """
    size = file.seek(0, os.SEEK_END)
    line = _line(file, size)
    file.seek(size)
    while line:
        line = line[file.write(line) :]


def check_seal(path: Path) -> None:
    """Raise FileError if a file is not what its checksum says.

    A file without one is not checked: other programs drop it when they write to the file.

    Raises
    ------
    FileError
        If the file is damaged.
    OSError
        If it cannot be read.
    """
    with path.open("rb", buffering=0) as file:
        size = file.seek(0, os.SEEK_END) - _LENGTH
        if size < 0:
            return
        file.seek(size)
        found = file.read(_LENGTH)
        if found.startswith(_MARK) and found != _line(file, size):
            raise FileError(path, "is damaged: its data are not those of its checksum")


def _line(file: IO[bytes], size: int) -> bytes:
    """Return the last line of a file with so many bytes before it."""
    file.seek(0)
    checksum = 0
    while size and (piece := file.read(min(size, _PIECE))):
        checksum = zlib.crc32(piece, checksum)
        size -= len(piece)
    return _MARK + f"{checksum:08x}\n".encode()
