"""The file that HDF5 writes to, on disks that may fail."""

from __future__ import annotations

import io
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any


class GuardedFile(io.RawIOBase):
    """The file that HDF5 writes to, which never tells HDF5 of a fault.

    HDF5 cannot close a file whose disk is full, and ends the process when it tries again
    on the way out. So a fault is kept here, everything after it is swallowed, and whoever
    uses the file asks with :meth:`check` whether there was one. An interrupt is such a fault,
    too, and must not reach the callbacks of HDF5: hence :meth:`run`.
    """

    def __init__(self, file: io.FileIO) -> None:
        self._file = file
        self._fault: BaseException | None = None

    def run(self, write: Callable[[], None]) -> None:
        """Call a function that writes with HDF5, in a thread of its own.

        Interrupts come to the main thread only. There one ends the writing, and is raised when
        HDF5 has let go of the file.
        """
        with ThreadPoolExecutor(1, thread_name_prefix="write") as pool:
            writing = pool.submit(write)
            try:
                writing.result()
            except BaseException as fault:
                if self._fault is None:
                    self._fault = fault
                raise

    def check(self) -> None:
        """Raise the first fault, if there was one."""
        if self._fault is not None:
            raise self._fault

    def write(self, data: Any) -> int:
        """Write all of the data."""
        view = memoryview(data).cast("B")
        size = view.nbytes
        if self._fault is None:
            try:
                while view.nbytes:
                    view = view[self._file.write(view) :]
            except OSError as fault:
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
