"""Progress: a bar on a terminal, lines elsewhere, speed and time left from a given clock."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from fivebar_atlas import jit
from fivebar_atlas.cli import progress
from fivebar_atlas.cli.progress import Progress, duration, note_compilation


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        """Return that it is one."""
        return True


class Clock:
    """A clock that the test moves."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        """Return the time."""
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Replace the clock of the progress."""
    made = Clock()
    monkeypatch.setattr(progress, "time", made)
    return made


def test_lines_come_now_and_then(clock: Clock) -> None:
    stream = io.StringIO()
    with Progress(1000, stream=stream) as shown:
        for _ in range(10):
            clock.now += 4.0
            shown.advance(100)
    # The first block ends at 4 s; from then on 100 designs take 4 s.
    assert stream.getvalue().splitlines() == [
        " 30 %  300 of 1,000 designs  25 designs/s  28 s left",
        " 60 %  600 of 1,000 designs  25 designs/s  16 s left",
        " 90 %  900 of 1,000 designs  25 designs/s  4 s left",
    ]


def test_bar_is_drawn_over_itself_and_ended(clock: Clock) -> None:
    stream = Terminal()
    with Progress(200, stream=stream) as shown:
        for _ in range(2):
            clock.now += 1.0
            shown.advance(100)
    states = stream.getvalue().split("\r")[1:]
    assert states[0].startswith("[" + 30 * "." + "]   0 %  0 of 200 designs")
    assert states[1].startswith("[" + 15 * "#" + 15 * "." + "]  50 %")
    assert states[2].startswith("[" + 30 * "#" + "] 100 %")
    assert "100 designs/s  0 s left" in states[2]
    assert stream.getvalue().endswith("\n")
    assert stream.getvalue().count("\n") == 1


def test_bar_is_not_drawn_more_often_than_one_can_see(clock: Clock) -> None:
    stream = Terminal()
    with Progress(1000, stream=stream) as shown:
        for _ in range(1000):
            clock.now += 0.001
            shown.advance(1)
    assert stream.getvalue().count("\r") <= 13


def test_designs_finished_before_do_not_count_for_the_speed(clock: Clock) -> None:
    stream = io.StringIO()
    with Progress(1000, finished=700, stream=stream) as shown:
        shown.advance(100)
        clock.now += 20.0
        shown.advance(100)
    assert stream.getvalue() == " 90 %  900 of 1,000 designs  5 designs/s  20 s left\n"


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["file", "terminal"])
def test_quiet_writes_nothing(clock: Clock, stream: io.StringIO) -> None:
    with Progress(1000, quiet=True, stream=stream) as shown:
        for _ in range(10):
            clock.now += 60.0
            shown.advance(100)
    assert stream.getvalue() == ""


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (59.4, "59 s"), (59.6, "1 min 0 s"), (3599, "59 min 59 s"), (7321, "2 h 2 min")],
)
def test_durations_are_read_easily(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_compilation_is_announced_at_a_terminal_only(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    jit.cache_folder.cache_clear()
    try:
        for stream, said in ((Terminal(), True), (io.StringIO(), False)):
            monkeypatch.setattr(sys, "stderr", stream)
            note_compilation()
            assert ("once" in stream.getvalue()) == said
        folder = jit.cache_folder()
        assert folder is not None
        (folder / "kernels.nbi").touch()
        stream = Terminal()
        monkeypatch.setattr(sys, "stderr", stream)
        note_compilation()
        assert stream.getvalue() == ""
    finally:
        jit.cache_folder.cache_clear()
