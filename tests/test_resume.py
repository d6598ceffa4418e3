"""Interrupted sweeps: whatever ends one, the rest completes it, and the data are the same."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Command
from toy_mechanism import ToyMechanism

from fivebar_atlas import jit, open_atlas, store
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.settings import SweepSettings

# Runs the command line. From the given call on, evaluating a block waits until a file
# named "go" appears, which makes "in the middle of a sweep" a place and not a time.
STALLING = """
import itertools, pathlib, sys, time
from fivebar_atlas import mechanisms
from fivebar_atlas.cli import main

mechanisms._REGISTRY["toy"] = "toy_mechanism:ToyMechanism"
name, first, go = sys.argv[1], int(sys.argv[2]), pathlib.Path(sys.argv[3])
mechanism = mechanisms.get(name)
honest, calls = mechanism.evaluate, itertools.count()

def stalling(parameters, settings):
    if next(calls) >= first:
        while not go.exists():
            time.sleep(0.01)
    return honest(parameters, settings)

mechanism.evaluate = stalling
sys.argv = ["atlas", *sys.argv[4:]]
main()
"""

# Runs the command line and stops for a while in the middle of assembling the result file.
STALLING_ASSEMBLY = """
import sys, time
from fivebar_atlas import mechanisms, unfinished_sweep
from fivebar_atlas.cli import main

mechanisms._REGISTRY["toy"] = "toy_mechanism:ToyMechanism"
honest = unfinished_sweep.UnfinishedSweep.read

def stalling(self, index):
    if index == 5 and any(self.path.glob("assembled-*")):
        (self.path / "stalled").touch()
        time.sleep(3)  # the writing, which is to end, waits for nothing longer
    return honest(self, index)

unfinished_sweep.UnfinishedSweep.read = stalling
sys.argv = ["atlas", *sys.argv[1:]]
main()
"""

TOY = ("--mechanism", "toy", "--resolution", 200, "--mode", "all", "--lci", 0.25, "--lci", 0.5)
FIVE_BAR = ("--resolution", 30, "--mode", "+-/up", "--mode", "++/down", "--tolerance", 1e-4)

Start = Callable[..., subprocess.Popen[str]]


def wait_for(condition: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    """Wait until something has happened, as long as the process lives."""
    for _ in range(30_000):
        if condition():
            return
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    raise AssertionError("it did not happen")


def blocks(output: Path) -> list[Path]:
    """Return the finished blocks of an unfinished sweep."""
    return sorted(output.with_name(output.name + ".partial").glob("block-??????"))


def assert_same_data(one: Path, other: Path) -> None:
    """Compare two result files bit for bit, NaN and all."""
    with open_atlas(one) as first, open_atlas(other) as second:
        assert first.settings == second.settings
        assert first.names == second.names
        for name in first.names:
            assert first[name].dtype == second[name].dtype
            assert first[name].tobytes() == second[name].tobytes(), name


def end_in_the_middle(
    start: Start, folder: Path, mechanism: str, options: tuple[Any, ...], number: int
) -> tuple[Path, int, str]:
    """Start a sweep, send it a signal in the middle; return output, exit code and message."""
    output, go = folder / "atlas.h5", folder / "go"
    process = start(STALLING, mechanism, 6, go, "sweep", *options, "-o", output, "--threads", 2)
    wait_for(lambda: len(blocks(output)) >= 6, process)
    process.send_signal(number)
    # The blocks at work never end; they are not waited for.
    _, message = process.communicate(timeout=120)
    assert not go.exists()
    assert not output.exists()
    assert len(blocks(output)) >= 6
    return output, process.returncode, message


SIGNALS = [
    pytest.param(signal.SIGKILL, -signal.SIGKILL, id="kill"),
    pytest.param(signal.SIGTERM, 130, id="terminate"),
    pytest.param(signal.SIGINT, 130, id="interrupt"),
]


@pytest.mark.parametrize(("number", "code"), SIGNALS)
def test_interrupted_sweep_is_completed(
    toy: str,
    start: Start,
    atlas: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    number: int,
    code: int,
) -> None:
    output, returned, message = end_in_the_middle(start, tmp_path, toy, TOY, number)
    assert returned == code
    if code == 130:
        last = message.splitlines()[-1]
        assert last.startswith("atlas: interrupted; ")
        assert last.endswith(" of 201 designs are kept, --resume goes on with them")
        assert "Traceback" not in message
    kept = len(blocks(output))
    evaluated = 0
    honest = ToyMechanism.evaluate

    def counting(self: ToyMechanism, parameters: FloatArray, settings: SweepSettings) -> Any:
        nonlocal evaluated
        evaluated += 1
        return honest(self, parameters, settings)

    monkeypatch.setattr(ToyMechanism, "evaluate", counting)
    assert atlas("sweep", *TOY, "-o", output, "--resume", "--threads", 1).code == 0
    assert evaluated == 13 - kept
    assert not output.with_name("atlas.h5.partial").exists()
    whole = tmp_path / "whole.h5"
    assert atlas("sweep", *TOY, "-o", whole).code == 0
    assert evaluated == 13 - kept + 13
    assert_same_data(output, whole)


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), SIGNALS)
def test_interrupted_five_bar_sweep_is_completed(
    start: Start, atlas: Command, tmp_path: Path, number: int, code: int
) -> None:
    output, returned, _ = end_in_the_middle(start, tmp_path, "five-bar", FIVE_BAR, number)
    assert returned == code
    assert atlas("sweep", *FIVE_BAR, "-o", output, "--resume", "--threads", 3).code == 0
    whole = tmp_path / "whole.h5"
    assert atlas("sweep", *FIVE_BAR, "-o", whole, "--threads", 1).code == 0
    assert_same_data(output, whole)


@pytest.mark.usefixtures("toy")
@pytest.mark.parametrize(("number", "code"), SIGNALS)
def test_ended_while_the_file_is_assembled(
    start: Start, atlas: Command, tmp_path: Path, number: int, code: int
) -> None:
    output = tmp_path / "atlas.h5"
    partial = tmp_path / "atlas.h5.partial"
    process = start(STALLING_ASSEMBLY, "sweep", *TOY, "-o", output)
    wait_for((partial / "stalled").exists, process)
    process.send_signal(number)
    _, message = process.communicate()
    assert process.returncode == code
    assert not output.exists()
    # Half a result file is there only after a kill, and never under the final name.
    assert any(partial.glob("assembled-*.h5")) == (number == signal.SIGKILL)
    assert (code == 130) == ("201 of 201 designs are kept" in message)
    (partial / "stalled").unlink()
    assert atlas("sweep", *TOY, "-o", output, "--resume").code == 0
    assert not partial.exists()
    whole = tmp_path / "whole.h5"
    assert atlas("sweep", *TOY, "-o", whole).code == 0
    assert_same_data(output, whole)


@pytest.fixture
def interrupted(toy: str, start: Start, tmp_path: Path) -> Path:
    """Return the output of a toy sweep that was killed in the middle."""
    return end_in_the_middle(start, tmp_path, toy, TOY, signal.SIGKILL)[0]


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[: len(data) // 2],
        lambda _: b"",
        lambda data: bytes(len(data)),
        lambda data: data[:100] + bytes([data[100] ^ 1]) + data[101:],
    ],
    ids=["half", "empty", "zeros", "bit"],
)
def test_blocks_that_are_not_whole_are_computed_again(
    interrupted: Path, atlas: Command, tmp_path: Path, damage: Callable[[bytes], bytes]
) -> None:
    victim = blocks(interrupted)[2]
    victim.write_bytes(damage(victim.read_bytes()))
    victim.with_name("block-000011.new").write_bytes(b"never finished")
    assert atlas("sweep", *TOY, "-o", interrupted, "--resume").code == 0
    whole = tmp_path / "whole.h5"
    assert atlas("sweep", *TOY, "-o", whole).code == 0
    assert_same_data(interrupted, whole)
    assert not interrupted.with_name("atlas.h5.partial").exists()


def test_what_is_the_users_own_in_the_folder_stays(interrupted: Path, atlas: Command) -> None:
    note = interrupted.with_name("atlas.h5.partial") / "note.txt"
    note.write_text("mine")
    assert atlas("sweep", *TOY, "-o", interrupted, "--resume").code == 0
    assert [path.name for path in note.parent.iterdir()] == ["note.txt"]


@pytest.mark.parametrize(
    ("options", "difference"),
    [
        (("--resolution", 201), "resolution = 200; now resolution = 201"),
        (("--tolerance", 1e-5), "tolerance = 1e-06; now tolerance = 1e-05"),
        (("--lci", 0.75), "now lci = [0.75]"),
        (("--space", "half"), 'now space = "half"'),
    ],
)
def test_resuming_with_another_configuration_is_refused(
    interrupted: Path,
    refused: Callable[..., str],
    options: tuple[Any, ...],
    difference: str,
) -> None:
    before = [path.read_bytes() for path in blocks(interrupted)]
    given = TOY if options[0] != "--lci" else TOY[:6]
    message = refused("sweep", *given, *options, "-o", interrupted, "--resume")
    assert "another configuration" in message
    assert difference in message
    assert [path.read_bytes() for path in blocks(interrupted)] == before
    assert not interrupted.exists()


@pytest.mark.parametrize("key", ["kernel_hash", "numba_version", "columns", "blocks", "layout"])
def test_resuming_with_other_kernels_is_refused(
    interrupted: Path, refused: Callable[..., str], key: str
) -> None:
    manifest = interrupted.with_name("atlas.h5.partial") / "manifest.json"
    content = json.loads(manifest.read_text())
    manifest.write_text(json.dumps({**content, key: "other"}))
    message = refused("sweep", *TOY, "-o", interrupted, "--resume")
    assert "other kernels or another version" in message
    assert "--overwrite" in message


@pytest.mark.parametrize("damage", [b"", b"{", b"[]", b"\xff", None])
def test_resuming_with_a_damaged_manifest_is_refused(
    interrupted: Path, refused: Callable[..., str], damage: bytes | None
) -> None:
    before = [path.read_bytes() for path in blocks(interrupted)]
    manifest = interrupted.with_name("atlas.h5.partial") / "manifest.json"
    if damage is None:
        manifest.unlink()
    else:
        manifest.write_bytes(damage)
    for resume in ((), ("--resume",)):
        message = refused("sweep", *TOY, "-o", interrupted, *resume, code=1)
        assert "manifest.json is missing or damaged" in message
        assert "--overwrite without --resume starts again" in message
    assert [path.read_bytes() for path in blocks(interrupted)] == before


def test_blocks_of_a_whole_sweep_are_not_those_of_a_part(
    interrupted: Path, refused: Callable[..., str]
) -> None:
    before = blocks(interrupted)
    message = refused("sweep", *TOY, "-o", interrupted, "--shard", "1/2", "--resume")
    assert "holds blocks of a whole sweep, not of part 1/2" in message
    assert blocks(interrupted) == before


def test_kernels_that_changed_are_noticed(
    interrupted: Path, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jit, "kernel_hash", lambda: "0123456789abcdef")
    message = refused("sweep", *TOY, "-o", interrupted, "--resume")
    assert "now '0123456789abcdef'" in message


def test_interrupted_sweep_is_not_forgotten(interrupted: Path, refused: Callable[..., str]) -> None:
    before = blocks(interrupted)
    message = refused("sweep", *TOY, "-o", interrupted)
    assert "--resume" in message
    assert "--overwrite" in message
    assert blocks(interrupted) == before


def test_interrupted_sweep_is_discarded_on_demand(
    interrupted: Path, atlas: Command, tmp_path: Path
) -> None:
    other = (*TOY[:2], "--resolution", 100, *TOY[4:])
    assert atlas("sweep", *other, "-o", interrupted, "--overwrite").code == 0
    whole = tmp_path / "whole.h5"
    assert atlas("sweep", *other, "-o", whole).code == 0
    assert_same_data(interrupted, whole)


def test_resuming_nothing_is_beginning(toy: str, atlas: Command, tmp_path: Path) -> None:
    output = tmp_path / "atlas.h5"
    assert atlas("sweep", "--mechanism", toy, "-o", output, "--resume").code == 0
    assert len(open_atlas(output)) == 301


@pytest.mark.usefixtures("toy")
def test_resuming_what_is_complete_changes_nothing(
    atlas: Command, refused: Callable[..., str], tmp_path: Path
) -> None:
    output = tmp_path / "atlas.h5"
    assert atlas("sweep", *TOY, "-o", output).code == 0
    before = output.read_bytes()
    again = atlas("sweep", *TOY, "-o", output, "--resume")
    assert again.code == 0
    assert "complete already" in again.err
    assert output.read_bytes() == before
    other = (*TOY[:2], "--resolution", 100, *TOY[4:])
    assert "exists already" in refused("sweep", *other, "-o", output, "--resume")
    assert output.read_bytes() == before


@pytest.mark.parametrize("resolution", [200, 100])
def test_blocks_beside_a_complete_file(
    interrupted: Path, atlas: Command, tmp_path: Path, resolution: int
) -> None:
    """Those that a kill has left of the same sweep go; those of another one are work to keep."""
    other = (*TOY[:2], "--resolution", resolution, *TOY[4:])
    output = tmp_path / "complete.h5"
    assert atlas("sweep", *other, "-o", output).code == 0
    left = shutil.copytree(
        interrupted.with_name("atlas.h5.partial"), tmp_path / "complete.h5.partial"
    )
    assert "complete already" in atlas("sweep", *other, "-o", output, "--resume").err
    assert left.exists() == (resolution != 200)


def test_interrupted_overwriting_leaves_the_old_file(
    toy: str, start: Start, atlas: Command, tmp_path: Path
) -> None:
    output, go = tmp_path / "atlas.h5", tmp_path / "go"
    assert atlas("sweep", "--mechanism", toy, "--resolution", 20, "-o", output).code == 0
    before = output.read_bytes()
    process = start(STALLING, toy, 6, go, "sweep", *TOY, "-o", output, "--overwrite")
    wait_for(lambda: len(blocks(output)) >= 6, process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert output.read_bytes() == before
    assert atlas("sweep", *TOY, "-o", output, "--resume", "--overwrite").code == 0
    with open_atlas(output) as opened:
        np.testing.assert_array_equal(opened["a"], np.arange(201) / 200)


def test_blocks_of_another_sweep_are_never_taken_for_own(
    interrupted: Path, toy: str, start: Start, atlas: Command, tmp_path: Path
) -> None:
    """As two sweeps on one output would mix theirs in a folder without locks."""
    other = tmp_path / "other"
    other.mkdir()
    options = (*TOY[:2], "--resolution", 200, "--mode", "all", "--lci", 0.3, "--lci", 0.6)
    strange = end_in_the_middle(start, other, toy, options, signal.SIGKILL)[0]
    for block in blocks(strange):
        shutil.copy(block, interrupted.with_name("atlas.h5.partial"))
    assert atlas("sweep", *TOY, "-o", interrupted, "--resume").code == 0
    whole = tmp_path / "whole.h5"
    assert atlas("sweep", *TOY, "-o", whole).code == 0
    assert_same_data(interrupted, whole)


def test_second_sweep_on_the_same_output_is_kept_out(
    toy: str, start: Start, refused: Callable[..., str], tmp_path: Path
) -> None:
    output, go = tmp_path / "atlas.h5", tmp_path / "go"
    process = start(STALLING, toy, 6, go, "sweep", *TOY, "-o", output)
    wait_for(lambda: len(blocks(output)) >= 6, process)
    for option in ("--resume", "--overwrite"):
        message = refused("sweep", *TOY, "-o", output, option)
        assert "another sweep is at work" in message
    go.touch()
    assert process.wait(120) == 0
    assert store.is_complete(
        output, SweepSettings("toy", "whole", 200, ("left", "right"), (0.25, 0.5), 1e-6)
    )
