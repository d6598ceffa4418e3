"""Progress on standard error: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Self, TextIO

_WIDTH = 30
_SECONDS_ON_TERMINAL = 0.1
_SECONDS_ELSEWHERE = 10.0


def note_compilation() -> None:
    """Tell whoever waits at a terminal that kernels are about to be compiled, if they are."""
    from fivebar_atlas.jit import has_compiled_kernels

    if sys.stderr.isatty() and not has_compiled_kernels():
        sys.stderr.write("Compiling the kernels: once, for up to a minute.\n")
        sys.stderr.flush()


class Progress:
    """Counts what is finished, and says how fast it comes and how long the rest takes.

    Parameters
    ----------
    total
        Number of them; 0 if that is told only by :meth:`reach`.
    finished
        Those finished before the start, which do not count for the speed.
    quiet
        Whether nothing is written.
    stream
        Where it is written, standard error if None.
    things
        What is counted.
    """

    def __init__(
        self,
        total: int,
        finished: int = 0,
        quiet: bool = False,
        stream: TextIO | None = None,
        things: str = "designs",
    ) -> None:
        self._total = total
        self._finished = finished
        self._quiet = quiet
        self._things = things
        self._stream = stream or sys.stderr
        self._terminal = self._stream.isatty()
        self._written = time.monotonic()
        # Time and count after the first block: before it lies the loading of the kernels,
        # on their first run their compilation, which says nothing of the speed.
        self._first: tuple[float, int] | None = None
        if self._terminal and total:
            self._write()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._terminal and self._total and not self._quiet:
            self._write()
            self._stream.write("\n")
            self._stream.flush()

    def advance(self, count: int) -> None:
        """Count so many as finished."""
        self._finished += count
        now = time.monotonic()
        if self._first is None:
            self._first = now, self._finished
        pause = _SECONDS_ON_TERMINAL if self._terminal else _SECONDS_ELSEWHERE
        if now - self._written >= pause:
            self._written = now
            self._write()

    def reach(self, finished: int, total: int) -> None:
        """Take note that so many of so many are finished."""
        self._total = total
        self.advance(finished - self._finished)

    def _write(self) -> None:
        """Write the present state."""
        if self._quiet:
            return
        line = self._line(time.monotonic())
        if self._terminal:
            filled = _WIDTH * self._finished // max(self._total, 1)
            bar = "#" * filled + "." * (_WIDTH - filled)
            # The code clears what a longer line has left behind.
            self._stream.write(f"\r[{bar}] {line}\x1b[K")
        else:
            self._stream.write(line + "\n")
        self._stream.flush()

    def _line(self, now: float) -> str:
        """Return count, speed and time left."""
        share = 100 * self._finished // max(self._total, 1)
        parts = [f"{share:3d} %  {self._finished:,} of {self._total:,} {self._things}"]
        if self._first is not None:
            elapsed, done = now - self._first[0], self._finished - self._first[1]
            if elapsed > 0.0 and done > 0:
                speed = done / elapsed
                left = (self._total - self._finished) / speed
                parts += [f"{speed:,.0f} {self._things}/s", f"{duration(left)} left"]
        return "  ".join(parts)


def duration(seconds: float) -> str:
    """Return a time span as a person would say it: ``"42 s"``, ``"3 min 5 s"``."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, whole = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes} min {whole} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min"
