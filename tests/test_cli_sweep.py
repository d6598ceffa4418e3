"""``atlas sweep``: from options to a result file, and every wrong input."""

from __future__ import annotations

import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, Command

from fivebar_atlas import config, mechanisms, open_atlas
from fivebar_atlas.mechanisms.settings import SweepSettings

Start = Callable[..., subprocess.Popen[str]]

TOY = ("--mechanism", "toy", "--resolution", 200, "--mode", "all")

SCRIPT = """
import sys
from fivebar_atlas import mechanisms
from fivebar_atlas.cli import main
mechanisms._REGISTRY["toy"] = "toy_mechanism:ToyMechanism"
sys.argv[0] = "atlas"
main()
"""


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """Return a folder on a disk of 96 KiB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=96k", "tmpfs", str(folder)],
        capture_output=True,
        check=False,
    )
    if mounted.returncode:
        pytest.skip("disks cannot be mounted here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.slow
def test_sweep_of_the_five_bar(atlas: Command, tmp_path: Path) -> None:
    output = tmp_path / "atlas.h5"
    outcome = atlas(
        "sweep",
        *("--resolution", 15, "--mode", "pm/up", "--mode", "pp/up"),
        *("--lci", 0.3, "--lci", 0.5, "--tolerance", 1e-4, "--threads", 2),
        *("-o", output),
    )
    assert outcome.code == 0
    assert outcome.out == ""
    assert f"{output}: 49 designs, +-/up, ++/up" in outcome.err
    expected = SweepSettings("five-bar", "surrounded", 15, ("+-/up", "++/up"), (0.3, 0.5), 1e-4)
    mechanism = mechanisms.get("five-bar")
    designs = mechanism.lattice("surrounded", 15)
    with open_atlas(output) as opened:
        assert opened.settings == expected
        np.testing.assert_array_equal(opened.designs, designs)
        for name, values in mechanism.evaluate(designs, expected).items():
            np.testing.assert_array_equal(opened[name], values, err_msg=name)
        assert opened.attributes["command_line"].startswith("atlas")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["atlas.h5"]


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted((ROOT / "configs").glob("*.toml")), ids=lambda p: p.stem)
def test_ready_made_configurations_run(atlas: Command, tmp_path: Path, path: Path) -> None:
    """Each at a coarse resolution; everything else as it stands."""
    output = tmp_path / "atlas.h5"
    assert atlas("sweep", path, "--resolution", 9, "-o", output, "--quiet").code == 0
    wanted = config.resolve(path, config.Overrides(resolution=9)).settings
    with open_atlas(output) as opened:
        assert opened.settings == wanted
        name = opened.mechanism.region_quantities[0]
        assert np.isfinite(opened.select(name, opened.modes[0])).all()


@pytest.mark.usefixtures("toy")
def test_output_may_stand_in_the_file(atlas: Command, tmp_path: Path) -> None:
    output = tmp_path / "named.h5"
    path = tmp_path / "sweep.toml"
    path.write_text(f"mechanism = 'toy'\n[sweep]\nresolution = 20\n[run]\noutput = '{output}'\n")
    assert atlas("sweep", path).code == 0
    assert len(open_atlas(output)) == 21
    other = tmp_path / "other.h5"
    assert atlas("sweep", path, "-o", other).code == 0
    assert other.exists()


@pytest.mark.usefixtures("toy")
def test_quiet_says_nothing(atlas: Command, tmp_path: Path) -> None:
    outcome = atlas("sweep", *TOY, "-o", tmp_path / "a.h5", "--quiet")
    assert (outcome.code, outcome.out, outcome.err) == (0, "", "")


@pytest.mark.usefixtures("toy")
def test_existing_output_needs_overwrite(
    atlas: Command, refused: Callable[..., str], tmp_path: Path
) -> None:
    output = tmp_path / "a.h5"
    output.write_text("mine")
    assert refused("sweep", *TOY, "-o", output) == (
        f"{output}: exists already; --overwrite replaces it"
    )
    assert output.read_text() == "mine"
    assert atlas("sweep", *TOY, "-o", output, "--overwrite").code == 0
    assert len(open_atlas(output)) == 201


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "No output is named"),
        (("-o", "{}/no/a.h5"), "the folder {}/no does not exist"),
        (("-o", "{}/file/a.h5"), "the folder {}/file does not exist"),
        (("-o", "{}"), "is a folder"),
        (("-o", "{}/a.h5", "--resolution", 2), "expected an integer from 3 to 5000"),
        (("-o", "{}/a.h5", "--resolution", 10**9), "expected an integer from 3 to 5000"),
        (("-o", "{}/a.h5", "--mode", "+-/sideways"), "expected one of +-/up"),
        (("-o", "{}/a.h5", "--tolerance", 0), "expected a number from 1e-10 to 0.001"),
        (("-o", "{}/a.h5", "--tolerance", "inf"), "expected a number from 1e-10 to 0.001"),
        (("-o", "{}/a.h5", "--lci", 1.0), "expected a number above 0 and below 1"),
        (("-o", "{}/a.h5", "--threads", -2), "expected an integer from 1"),
        (("{}/unknown.toml", "-o", "{}/a.h5"), "did you mean 'sweep.tolerance'"),
        (("{}/type.toml", "-o", "{}/a.h5"), "expected an integer"),
        (("{}/broken.toml", "-o", "{}/a.h5"), "is not TOML"),
        (("{}/missing.toml", "-o", "{}/a.h5"), "there is no such file"),
    ],
)
def test_wrong_inputs_change_nothing(
    refused: Callable[..., str], tmp_path: Path, options: tuple[object, ...], message: str
) -> None:
    (tmp_path / "file").write_text("mine")
    (tmp_path / "unknown.toml").write_text("[sweep]\ntolerence = 1e-6\n")
    (tmp_path / "type.toml").write_text("[sweep]\nresolution = 'fine'\n")
    (tmp_path / "broken.toml").write_text("[sweep\n")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    line = refused("sweep", *(str(option).format(tmp_path) for option in options))
    assert message.format(tmp_path) in line
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no folder that refuses everybody")
def test_folder_that_cannot_be_written(refused: Callable[..., str]) -> None:
    """Not even the superuser makes a file there."""
    line = refused("sweep", "-o", "/proc/a.h5", code=1)
    assert "cannot be written" in line or "not writable" in line


@pytest.mark.usefixtures("toy")
def test_full_disk_keeps_the_finished_blocks(
    atlas: Command, refused: Callable[..., str], small_disk: Path, tmp_path: Path
) -> None:
    output = small_disk / "a.h5"
    line = refused("sweep", *TOY, "-o", output, "--quiet", code=1)
    assert "there is no space left on the disk" in line
    assert "--resume goes on with them" in line
    assert not output.exists()
    partial = small_disk / "a.h5.partial"
    kept = {path.name for path in partial.glob("block-??????")}
    assert kept
    assert not (partial / "assembled.h5").exists()
    subprocess.run(["mount", "-o", "remount,size=10m", str(small_disk)], check=True)
    assert atlas("sweep", *TOY, "-o", output, "--resume", "--quiet").code == 0
    whole = tmp_path / "whole.h5"
    assert atlas("sweep", *TOY, "-o", whole, "--quiet").code == 0
    with open_atlas(output) as one, open_atlas(whole) as other:
        for name in one.names:
            assert one[name].tobytes() == other[name].tobytes()


@pytest.mark.parametrize("size", [100, 1500, 4000, 12_000])
def test_file_size_limit_is_one_line(start: Start, tmp_path: Path, size: int) -> None:
    """At whatever point the limit strikes: manifest, blocks, result file."""
    output = tmp_path / "a.h5"
    process = start(
        SCRIPT,
        *("sweep", *TOY, "-o", output, "--quiet"),
        before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )
    _, message = process.communicate(timeout=120)
    assert process.returncode == 1, message
    assert len(message.splitlines()) == 1
    assert message.startswith(f"atlas: error: {output}")
    assert "the file would exceed the size limit" in message
    assert not output.exists()
    partial = tmp_path / "a.h5.partial"
    if partial.exists():
        assert "--resume" in message
        assert all(path.name != "assembled.h5" for path in partial.iterdir())


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
@pytest.mark.usefixtures("toy")
def test_memory_stays_small(start: Start, tmp_path: Path) -> None:
    """Sweep 1.5 million designs, 27 numbers each, in less than 1 GiB of memory."""
    script = SCRIPT.replace(
        "main()\n",
        # not ru_maxrss, which a process inherits from the one that starts it
        "import atexit, pathlib\n"
        "status = lambda: pathlib.Path('/proc/self/status').read_text()\n"
        "atexit.register(lambda: print(status().split('VmHWM:')[1].split()[0]))\n"
        "main()\n",
    )
    output = tmp_path / "a.h5"
    process = start(
        script,
        *("sweep", "--mechanism", "toy", "--resolution", 1_500_000, "--mode", "all"),
        *("--lci", 0.2, "--lci", 0.4, "--lci", 0.6, "--lci", 0.8),
        *("-o", output, "--quiet"),
    )
    out, message = process.communicate(timeout=500)
    assert process.returncode == 0, message
    assert int(out) * 1024 < 1 << 30
    with open_atlas(output) as opened:
        assert len(opened) == 1_500_001
