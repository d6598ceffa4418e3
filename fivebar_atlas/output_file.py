"""Output files that appear whole under their final name, or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
from collections.abc import Collection, Iterator
from pathlib import Path

from fivebar_atlas.errors import FileError, FileUsageError, InputError

#: Faults of a full disk: no space, quota used up, size limit of a file reached.
_FULL = {
    errno.ENOSPC: "there is no space left on the disk",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the file would exceed the size limit",
}


def check_output(path: Path, overwrite: bool) -> None:
    """Refuse an output that cannot be meant, before any work is done for it.

    Parameters
    ----------
    path
        The file to be written.
    overwrite
        Whether a file of this name may be replaced.

    Raises
    ------
    FileUsageError
        If the folder is missing, the name is taken by something other than a file, or by
        a file that may not be replaced.
    FileError
        If the folder cannot be written to.
    """
    folder = path.parent
    try:
        if not folder.is_dir():
            raise FileUsageError(path, f"the folder {folder} does not exist")
        if path.is_dir():
            raise FileUsageError(path, "is a folder, not a file")
        if path.exists() and not path.is_file():
            raise FileUsageError(path, "is not an ordinary file")
        if path.exists() and not overwrite:
            raise FileUsageError(path, "exists already; --overwrite replaces it")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise FileError(path, f"the folder {folder} is not writable")
    except OSError as error:
        raise unwritable(path, error) from None


def checked_ending(path: Path, endings: Collection[str]) -> str:
    """Return the ending of a file name, which decides the format, in small letters.

    Parameters
    ----------
    path
        The file.
    endings
        The endings there are formats for, without the dot.

    Raises
    ------
    InputError
        If the ending is none of them.
    """
    ending = path.suffix.lower().removeprefix(".")
    if ending not in endings:
        known = ", ".join(f".{name}" for name in endings)
        raise InputError("output", str(path), f"a file name that ends in one of {known}")
    return ending


def check_is_no_input(path: Path, source: Path) -> None:
    """Raise FileUsageError if an output is the very file that is read."""
    if path.resolve() == source.resolve():
        raise FileUsageError(path, "is the input; the output needs another name")


def unwritable(path: object, error: OSError, kept: str = "") -> FileError:
    """Return the error that says why a file cannot be written.

    Parameters
    ----------
    path
        The file.
    error
        What the operating system said.
    kept
        What is not lost, and how to go on, as a phrase.
    """
    reason = _FULL.get(error.errno or 0) or error.strerror or str(error)
    return FileError(path, f"cannot be written: {reason}" + (f"; {kept}" if kept else ""))


def of_this_process() -> str:
    """Return a name that no other process has that is at work now, here or on another machine."""
    return f"{socket.gethostname()}-{os.getpid()}"


def temporary_name(path: Path) -> Path:
    """Return the name, of this process alone, that a file has until it is complete."""
    return path.with_name(f".{path.stem}.{of_this_process()}.part{path.suffix}")


def put_in_place(temporary: Path, path: Path, overwrite: bool) -> None:
    """Give a finished and flushed file its final name, in one step.

    Parameters
    ----------
    temporary
        The file, on the same file system.
    path
        Its final name.
    overwrite
        Whether a file of this name may be replaced.

    Raises
    ------
    FileUsageError
        If the name was taken in the meantime.
    OSError
        If the file cannot be renamed.
    """
    if overwrite or not _linked(temporary, path):
        temporary.replace(path)
    # The new name is on the disk only when its folder is.
    flush_folder(path.parent)


def _linked(temporary: Path, path: Path) -> bool:
    """Give a file a second name that must be free; return whether links can do that.

    Raises
    ------
    FileUsageError
        If the name is taken.
    """
    taken = FileUsageError(path, "exists already; --overwrite replaces it")
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise taken from None
    except OSError:
        # A file system without links: then only looking helps.
        if path.exists():
            raise taken from None
        return False
    temporary.unlink(missing_ok=True)
    return True


def flush_folder(folder: Path) -> None:
    """Have the names in a folder on the disk, where the platform can."""
    with contextlib.suppress(OSError):
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


@contextlib.contextmanager
def atomic_output(path: Path, overwrite: bool) -> Iterator[Path]:
    """Give the body a temporary name to write to; rename the file when the body is done.

    Parameters
    ----------
    path
        The file to be written.
    overwrite
        Whether a file of this name may be replaced.

    Yields
    ------
    Path
        A name in the same folder, with the same ending.

    Raises
    ------
    FileUsageError
        As :func:`check_output`.
    FileError
        If the file cannot be written; whatever had the final name is untouched.
    """
    check_output(path, overwrite)
    temporary = temporary_name(path)
    try:
        yield temporary
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        put_in_place(temporary, path, overwrite)
    except OSError as error:
        raise unwritable(path, error) from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
