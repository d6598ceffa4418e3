"""Bad days of disks and processes: a clear error, finished work kept, no damaged file in place."""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from conftest import Command
from test_merge import write_part
from test_resume import STALLING, TOY, Start, assert_same_data, blocks, wait_for
from test_store import write

from fivebar_atlas import open_atlas
from fivebar_atlas.errors import AtlasError, FileError
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store.parts import Part
from fivebar_atlas.sweep import Shard
from fivebar_atlas.unfinished_sweep import UnfinishedSweep


def mounted(folder: Path, options: str) -> bool:
    """Mount a small file system of its own on a folder; return whether that is possible."""
    if sys.platform != "linux" or os.geteuid() != 0 or shutil.which("mount") is None:
        return False
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Callable[[int], Path]]:
    """Return a function that mounts a disk of so many kilobytes and returns its folder."""
    folder = tmp_path / "disk"
    folder.mkdir()

    def mount(kilobytes: int) -> Path:
        if not mounted(folder, f"size={kilobytes}k"):
            pytest.skip("only the superuser of Linux can mount a disk")
        return folder

    yield mount
    subprocess.run(["umount", str(folder)], capture_output=True, check=False)


@pytest.mark.parametrize("kilobytes", [16, 32, 48, 64, 96])
def test_full_disk_keeps_what_is_finished(
    small_disk: Callable[[int], Path], tmp_path: Path, toy_settings: SweepSettings, kilobytes: int
) -> None:
    """The disk fills up while blocks are written, or while the file is assembled."""
    disk = small_disk(kilobytes)
    output = disk / "toy.h5"
    with pytest.raises(FileError, match="there is no space left on the disk") as caught:
        write(output, toy_settings)
    assert caught.value.exit_code == 1
    assert not output.exists()
    kept = len(blocks(output))
    # on more room what is finished is gone on with
    roomy = tmp_path / "roomy"
    shutil.copytree(disk, roomy)
    if kept:
        assert "--resume goes on with them" in str(caught.value)
        assert len(blocks(roomy / "toy.h5")) == kept
    write(roomy / "toy.h5", toy_settings, resume=True)
    assert_same_data(roomy / "toy.h5", write(tmp_path / "reference.h5", toy_settings))


def test_full_disk_leaves_the_old_file(
    small_disk: Callable[[int], Path], toy_settings: SweepSettings
) -> None:
    disk = small_disk(160)
    output = write(disk / "toy.h5", toy_settings)
    before = output.read_bytes()
    filler = disk / "filler"
    filler.write_bytes(bytes(os.statvfs(disk).f_bavail * os.statvfs(disk).f_frsize - 24_000))
    with pytest.raises(FileError, match="there is no space left on the disk"):
        write(output, toy_settings, overwrite=True)
    assert output.read_bytes() == before
    with open_atlas(output) as atlas:
        assert atlas.settings == toy_settings


def test_read_only_folder_is_refused_before_any_work(
    small_disk: Callable[[int], Path], toy_settings: SweepSettings
) -> None:
    disk = small_disk(64)
    remount = ["mount", "-o", "remount,ro", str(disk)]
    subprocess.run(remount, check=True, capture_output=True)
    with pytest.raises(FileError, match=r"is not writable|Read-only file system"):
        write(disk / "toy.h5", toy_settings)
    assert list(disk.iterdir()) == []


def test_hundred_kills_at_random_moments(tmp_path: Path) -> None:
    """Moments before the work, within it, while the file is assembled, and after all that."""
    script = Path(__file__).with_name("kill_sweeps.py")
    command = [sys.executable, str(script), str(tmp_path), "100"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    found = json.loads(run.stdout)
    assert found["same"] == 100
    # all kinds of moments were among them
    assert found["killed"] > 50
    assert found["kept_blocks"] > 25
    assert found["had_result"] > 0


def write_toy(output: Path) -> Path:
    """Write what ``TOY`` is without interruption."""
    return write(output, SweepSettings("toy", "whole", 200, ("left", "right"), (0.25, 0.5), 1e-6))


@pytest.mark.parametrize("seed", range(3))
def test_flipped_bit_in_a_finished_block_is_computed_again(
    toy: str, start: Start, atlas: Command, tmp_path: Path, seed: int
) -> None:
    output, go = tmp_path / "atlas.h5", tmp_path / "go"
    process = start(STALLING, toy, 6, go, "sweep", *TOY, "-o", output, "--threads", 2)
    wait_for(lambda: len(blocks(output)) >= 6, process)
    process.send_signal(signal.SIGKILL)
    process.wait()
    places = random.Random(seed)
    for block in blocks(output)[:3]:
        data = bytearray(block.read_bytes())
        data[places.randrange(len(data))] ^= 1 << places.randrange(8)
        block.write_bytes(data)
    atlas("sweep", *TOY, "-o", output, "--resume")
    assert_same_data(output, write_toy(tmp_path / "reference.h5"))


def contents(path: Path) -> dict[str, object]:
    """Return everything in an atlas: values, and how it was made."""
    with open_atlas(path) as atlas:
        return {**atlas.attributes, **{name: atlas[name].tobytes() for name in atlas.names}}


def part_contents(path: Path) -> dict[str, object]:
    """Return everything in a part of one."""
    with contextlib.closing(Part(path)) as part:
        records = [part.records(block).tobytes() for block in range(len(part.ranges))]
        return {**part.attributes, "records": records, "ranges": part.ranges}


Written = tuple[Path, Callable[[Path], dict[str, object]]]


@pytest.fixture(params=["atlas", "part"])
def written(request: pytest.FixtureRequest, tmp_path: Path, toy_settings: SweepSettings) -> Written:
    """Return a file of either kind, and what reads everything in it."""
    if request.param == "atlas":
        return write(tmp_path / "toy.h5", toy_settings), contents
    return write_part(tmp_path / "1.h5", toy_settings, Shard(1, 2)), part_contents


def test_flipped_bits_in_a_file_never_pass_unnoticed(tmp_path: Path, written: Written) -> None:
    """Whatever bit flips: either all is as it was written, or there is an error."""
    output, read = written
    expected = read(output)
    data, places, noticed = output.read_bytes(), random.Random(1), 0
    flipped = tmp_path / "flipped.h5"
    for _ in range(1000):
        damaged = bytearray(data)
        damaged[places.randrange(len(data))] ^= 1 << places.randrange(8)
        flipped.write_bytes(damaged)
        try:
            found = read(flipped)
        except AtlasError:
            noticed += 1
        else:
            assert found == expected
    assert noticed > 950


def test_truncated_files_never_pass_unnoticed(written: Written) -> None:
    output, read = written
    expected = read(output)
    data, lengths = output.read_bytes(), random.Random(2)
    for length in [0, 1, len(data) - 1, *(lengths.randrange(len(data)) for _ in range(100))]:
        output.write_bytes(data[:length])
        try:
            found = read(output)
        except AtlasError:
            continue
        # nothing but the line with the checksum was cut
        assert length > len(data) - 40
        assert found == expected


def test_reader_during_the_write_sees_the_old_file_and_then_the_new_one(
    tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = write(tmp_path / "toy.h5", toy_settings)
    new = SweepSettings(**{**_fields(toy_settings), "tolerance": 1e-5})
    seen = []
    honest = UnfinishedSweep.read

    def reading(self: UnfinishedSweep, index: int) -> object:
        with open_atlas(output) as atlas:
            seen.append((atlas.settings.tolerance, len(atlas["span"])))
        return honest(self, index)

    monkeypatch.setattr(UnfinishedSweep, "read", reading)
    with open_atlas(output) as before:
        write(output, new, overwrite=True)
        # what was opened stays what it was
        assert before.settings.tolerance == toy_settings.tolerance
        assert len(before["span"]) == 201
    assert set(seen) == {(toy_settings.tolerance, 201)}
    with open_atlas(output) as after:
        assert after.settings.tolerance == 1e-5


def _fields(settings: SweepSettings) -> dict[str, object]:
    return {name: getattr(settings, name) for name in settings.__slots__}
