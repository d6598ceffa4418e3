"""The finished blocks of a sweep that is not complete, in a folder beside its output.

``FILE.h5.partial/`` holds a manifest that says what is computed, and one file a finished
block. Each appears by a rename, with a checksum inside over its data and the manifest, so that
whatever ends the process (an interrupt, a kill, the power) leaves every finished block whole or
recognisably not, and a block of another sweep is never taken for one of this. A lock that dies
with the process keeps two sweeps from writing to one output, where the folder has locks.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import FileError, FileUsageError
from fivebar_atlas.output_file import flush_folder, of_this_process, unwritable

#: Version of the layout of the folder.
LAYOUT = 2

_FOLDER = ".partial"
_MANIFEST = "manifest.json"
_LOCK = "lock"
_BLOCK = "block-"
_ASSEMBLED = "assembled-"
_UNFINISHED = ".new"
_CHECKSUM_BYTES = 4
# A lock file that its owner removed just then is looked for again so many times.
_TRIES = 100


class UnfinishedSweep:
    """The folder of finished blocks; locked from construction until :meth:`close`.

    Parameters
    ----------
    output
        The result file that the sweep is for.
    manifest
        Everything that must be the same for blocks to belong together: texts and numbers.
    ranges
        First design and the one after the last of every block.
    columns
        Type of a design's record: one field for each result array.
    resume
        Whether to go on with the blocks that are there.
    restart
        Whether to discard blocks that are there (unless ``resume``).

    Attributes
    ----------
    path
        The folder.
    finished
        Indices of the blocks that are there and whole.

    Raises
    ------
    FileUsageError
        If there are blocks but neither ``resume`` nor ``restart``; if ``resume`` and they
        belong to another sweep; or if another process is at work on them.
    FileError
        If the folder cannot be written.
    """

    def __init__(
        self,
        output: Path,
        manifest: Mapping[str, Any],
        ranges: Sequence[tuple[int, int]],
        columns: np.dtype[Any],
        *,
        resume: bool,
        restart: bool,
    ) -> None:
        self.path = output.with_name(output.name + _FOLDER)
        self.finished: set[int] = set()
        self._ranges = ranges
        self._columns = columns
        self._lock: io.IOBase | None = None
        self._accepted = False
        wanted = {"layout": LAYOUT, **manifest, "blocks": len(ranges), "columns": str(columns)}
        text = json.dumps(wanted, indent=2).encode()
        self._seed = zlib.crc32(text)
        with self._writing():
            self.path.mkdir(exist_ok=True)
            self._lock = _locked(self.path)
        try:
            if self._lock is None:
                raise FileUsageError(self.path, "another sweep is at work on this output")
            found = None
            if resume or not restart:
                with self._writing():
                    found = _manifest(self.path)
            if found is not None and not (resume or restart) and self._has_blocks():
                raise FileUsageError(
                    self.path,
                    "holds an interrupted sweep; --resume goes on with it, "
                    "--overwrite starts again",
                )
            if found is not None and resume:
                _check_manifest(self.path, found, wanted)
                self.finished = set(self._whole_blocks())
                self._accepted = True
            else:
                self._accepted = True
                with self._writing():
                    _clear(self.path)
                    self._write(_MANIFEST, text)
        except BaseException:
            self.close()
            raise

    @property
    def assembled(self) -> Path:
        """A name for the result file while it is assembled, of this process alone."""
        return self.path / f"{_ASSEMBLED}{of_this_process()}.h5"

    def add(self, index: int, arrays: Mapping[str, npt.NDArray[Any]], processor: str) -> None:
        """Keep a finished block.

        Parameters
        ----------
        index
            Number of the block.
        arrays
            One array for each column, the design axis first.
        processor
            What computed it.

        Raises
        ------
        FileError
            If the disk is full or fails; the finished blocks stay.
        """
        start, stop = self._ranges[index]
        records = np.empty(stop - start, dtype=self._columns)
        for name in self._columns.names or ():
            records[name] = arrays[name]
        data = records.tobytes() + processor.encode()
        with self._writing():
            self._write(f"{_BLOCK}{index:06d}", data + self._checksum(data))
        self.finished.add(index)

    def read(self, index: int) -> tuple[npt.NDArray[Any], str] | None:
        """Return the records of a finished block, and what computed it.

        None stands for a block that is not there, not whole, or of another sweep.
        """
        start, stop = self._ranges[index]
        try:
            content = (self.path / f"{_BLOCK}{index:06d}").read_bytes()
        except FileNotFoundError:
            return None
        data, checksum = content[:-_CHECKSUM_BYTES], content[-_CHECKSUM_BYTES:]
        size = (stop - start) * self._columns.itemsize
        if len(data) < size or self._checksum(data) != checksum:
            return None
        return np.frombuffer(data[:size], dtype=self._columns), data[size:].decode()

    def _checksum(self, data: bytes) -> bytes:
        """Return the checksum of a block's data: of this sweep, and of no other."""
        return zlib.crc32(data, self._seed).to_bytes(_CHECKSUM_BYTES, "little")

    def remove(self) -> None:
        """Remove the folder and everything in it that a sweep has put there."""
        self.finished.clear()
        self.close()

    def close(self) -> None:
        """Release the lock; the blocks stay. A folder without any is removed."""
        if self._lock is None:
            return
        # Never on the way out of a refusal: then what is there belongs to another sweep.
        if self._accepted and not self.finished:
            # What cannot be removed, or is the user's own, stays.
            with contextlib.suppress(OSError):
                _clear(self.path)
                (self.path / _LOCK).unlink(missing_ok=True)
                self.path.rmdir()
        self._lock.close()
        self._lock = None

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn a fault of the disk into an error that says what is kept."""
        try:
            yield
        except OSError as error:
            count = len(self.finished)
            kept = f"the {count} finished blocks are kept, --resume goes on with them"
            raise unwritable(self.path, error, kept if count else "") from None

    def _write(self, name: str, data: bytes) -> None:
        """Write a file of the folder; it has its name only when it is complete."""
        new = self.path / (name + _UNFINISHED)
        try:
            with new.open("wb") as file:
                file.write(data)
                if name == _MANIFEST:
                    # Blocks that the power took are computed again; without a manifest all are.
                    file.flush()
                    os.fsync(file.fileno())
            new.replace(self.path / name)
            if name == _MANIFEST:
                flush_folder(self.path)
        except OSError:
            with contextlib.suppress(OSError):
                new.unlink(missing_ok=True)
            raise

    def _has_blocks(self) -> bool:
        """Return whether there is a block, whole or not."""
        return any(entry.name.startswith(_BLOCK) for entry in self.path.iterdir())

    def _whole_blocks(self) -> Iterator[int]:
        """Yield the indices of the blocks that are there and whole."""
        for index in range(len(self._ranges)):
            if self.read(index) is not None:
                yield index


def remove_leftover(output: Path, own: Mapping[str, str]) -> None:
    """Remove the blocks of a sweep that ended between giving its file the name and removing them.

    Parameters
    ----------
    output
        The result file, which is complete.
    own
        What the manifest must say, lest the blocks of another sweep are lost.
    """
    path = output.with_name(output.name + _FOLDER)
    # A folder that is not there, or cannot be removed, is nobody's loss.
    with contextlib.suppress(OSError, FileError):
        manifest = _manifest(path)
        if manifest is not None and any(manifest.get(name) != own[name] for name in own):
            return
        lock = _locked(path)
        if lock is not None:
            with lock:
                _clear(path)
                (path / _LOCK).unlink(missing_ok=True)
                path.rmdir()


def _manifest(path: Path) -> dict[str, Any] | None:
    """Return the manifest in a folder, None if there is none and no block either.

    Raises
    ------
    FileError
        If it is damaged, or missing beside blocks: it was on the disk before the first of them,
        so no interruption does that.
    """
    try:
        found = json.loads((path / _MANIFEST).read_bytes())
    except FileNotFoundError:
        if not path.is_dir() or not any(e.name.startswith(_BLOCK) for e in path.iterdir()):
            return None
        found = None
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise FileError(
            path,
            f"its {_MANIFEST} is missing or damaged, so nobody knows what its blocks are of; "
            "--overwrite without --resume starts again",
        )
    return found


def _locked(path: Path) -> io.IOBase | None:
    """Lock a folder, where the platform has locks that die with their process.

    Returns the lock, None if somebody else has it.
    """
    name = path / _LOCK
    for _ in range(_TRIES):
        lock = name.open("ab")
        if sys.platform == "win32":
            return lock
        import fcntl

        try:
            fcntl.flock(lock.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            return None
        except OSError:
            # A network folder without locks: then nobody can be kept out.
            return lock
        # Whoever had it before may have removed it in the meantime, and a third made a new one.
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(lock.fileno()), name.stat()):
                return lock
        lock.close()
    return None


def _clear(path: Path) -> None:
    """Remove what a sweep has put into its folder, except the lock; the manifest goes last."""
    for entry in sorted(path.iterdir(), key=lambda entry: entry.name.startswith(_MANIFEST)):
        if entry.name.startswith((_MANIFEST, _BLOCK, _ASSEMBLED)):
            entry.unlink(missing_ok=True)


def _check_manifest(path: Path, found: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Refuse to go on with blocks of another configuration or other kernels."""
    if found.get("configuration") != wanted["configuration"]:
        before = str(found.get("configuration")).splitlines()
        now = str(wanted["configuration"]).splitlines()
        removed = ", ".join(line for line in before if line not in now)
        added = ", ".join(line for line in now if line not in before)
        raise FileUsageError(
            path,
            f"was begun with another configuration ({removed or 'less'}; now "
            f"{added or 'without that'}); "
            "--overwrite without --resume starts again",
        )
    if found.get("part") != wanted.get("part"):
        theirs, ours = (
            f"part {each['part']}" if each.get("part") else "a whole sweep"
            for each in (found, wanted)
        )
        raise FileUsageError(
            path, f"holds blocks of {theirs}, not of {ours}; give each a file of its own"
        )
    different = [key for key in wanted if found.get(key) != wanted[key]]
    if different:
        changes = ", ".join(
            f"{key} {found.get(key)!r}, now {wanted[key]!r}"
            for key in different
            if len(str(wanted[key])) < 80
        )
        raise FileUsageError(
            path,
            "was begun with other kernels or another version of this program"
            + (f" ({changes})" if changes else "")
            + "; --overwrite without --resume starts again",
        )
