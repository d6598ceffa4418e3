"""Parts of a sweep: disjoint, balanced, merged bit for bit, refused where they do not fit."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner
from test_store import write

from fivebar_atlas import jit, open_atlas, versions
from fivebar_atlas.cli import main
from fivebar_atlas.errors import FileError, FileUsageError, InputError
from fivebar_atlas.executors import ThreadExecutor
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import AtlasWriter, is_complete, merge, merging
from fivebar_atlas.store import parts as parts_module
from fivebar_atlas.sweep import Shard, Sweep


def write_part(output: Path, settings: SweepSettings, shard: Shard) -> Path:
    """Run a part of a sweep into a file."""
    work = Sweep(settings, shard)
    ranges = [(block.start, block.stop) for block in work.blocks]
    with AtlasWriter(output, settings, work.designs, ranges, part=str(shard)) as writer:
        for results in work.run(ThreadExecutor(1)):
            writer.add(results.block.index, results.arrays)
        writer.assemble()
    return output


@pytest.fixture
def parts(tmp_path: Path, toy_settings: SweepSettings) -> list[Path]:
    return [
        write_part(tmp_path / f"part-{number}.h5", toy_settings, Shard(number, 3))
        for number in (1, 2, 3)
    ]


def assert_same_data(one: Path, other: Path) -> None:
    """Compare everything but who wrote the files, and when."""
    with h5py.File(one) as a, h5py.File(other) as b:
        assert list(a) == list(b)
        for name in a:
            assert a[name][...].tobytes() == b[name][...].tobytes(), name
            assert a[name].dtype == b[name].dtype
            assert a[name].chunks == b[name].chunks
            assert set(a[name].attrs) == set(b[name].attrs)
        differ = {key for key in {*a.attrs, *b.attrs} if a.attrs.get(key) != b.attrs.get(key)}
        assert differ <= {"command_line", "created"}


@pytest.mark.parametrize("count", [1, 2, 3, 7, 13])
def test_shards_are_disjoint_balanced_and_everything(toy: str, count: int) -> None:
    settings = SweepSettings(toy, "whole", 1000, ("left",), (), 1e-6)
    whole = Sweep(settings)
    found = [Sweep(settings, Shard(number, count)) for number in range(1, count + 1)]
    ranges = sorted((block.start, block.stop) for part in found for block in part.blocks)
    assert ranges == [(block.start, block.stop) for block in whole.blocks]
    sizes = [part.count for part in found]
    assert sum(sizes) == len(whole.designs)
    largest = max(block.stop - block.start for block in whole.blocks)
    assert max(sizes) - min(sizes) <= largest


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
def test_merged_parts_are_the_sweep_bit_for_bit(
    tmp_path: Path, toy_settings: SweepSettings, parts: list[Path], order: tuple[int, ...]
) -> None:
    whole = write(tmp_path / "whole.h5", toy_settings)
    merged = tmp_path / "merged.h5"
    assert merge([parts[number] for number in order], merged) == 201
    assert_same_data(whole, merged)
    assert is_complete(merged, toy_settings)
    with open_atlas(merged) as atlas:
        assert len(atlas) == 201


def test_one_part_of_one_is_all(tmp_path: Path, toy_settings: SweepSettings) -> None:
    part = write_part(tmp_path / "part.h5", toy_settings, Shard(1, 1))
    merge([part], tmp_path / "merged.h5")
    assert_same_data(write(tmp_path / "whole.h5", toy_settings), tmp_path / "merged.h5")


def test_part_is_known_as_complete(parts: list[Path], toy_settings: SweepSettings) -> None:
    assert is_complete(parts[1], toy_settings, "2/3")
    assert not is_complete(parts[1], toy_settings, "1/3")
    assert not is_complete(parts[1], toy_settings)
    assert not is_complete(parts[1], dataclasses.replace(toy_settings, tolerance=1e-5), "2/3")


def test_part_is_not_taken_for_an_atlas(parts: list[Path]) -> None:
    with pytest.raises(FileError, match="holds part 2/3 of an atlas; atlas merge puts all parts"):
        open_atlas(parts[1])


def test_missing_parts_are_named(tmp_path: Path, parts: list[Path]) -> None:
    with pytest.raises(FileUsageError, match="needs parts 1/3, 3/3 of its sweep"):
        merge(parts[1:2], tmp_path / "merged.h5")
    assert not (tmp_path / "merged.h5").exists()


def test_part_that_is_there_twice_is_named(tmp_path: Path, parts: list[Path]) -> None:
    copy = shutil.copy(parts[0], tmp_path / "copy.h5")
    with pytest.raises(FileUsageError, match=r"copy\.h5.*is part 1/3, and so is .*part-1\.h5"):
        merge([*parts, copy], tmp_path / "merged.h5")


def test_parts_of_other_runs_are_refused(
    tmp_path: Path, toy_settings: SweepSettings, parts: list[Path]
) -> None:
    other = dataclasses.replace(toy_settings, tolerance=1e-5)
    stranger = write_part(tmp_path / "stranger.h5", other, Shard(3, 3))
    message = r"stranger\.h5.*is of another sweep than .*part-1\.h5: its configuration is 'tol"
    with pytest.raises(FileUsageError, match=message):
        merge([*parts[:2], stranger], tmp_path / "merged.h5")
    of_four = write_part(tmp_path / "of-four.h5", toy_settings, Shard(3, 4))
    with pytest.raises(FileUsageError, match=r"is part 3/4, but .* is part 1/3"):
        merge([*parts[:2], of_four], tmp_path / "merged.h5")


def test_parts_of_other_kernels_are_refused(tmp_path: Path, parts: list[Path]) -> None:
    with h5py.File(parts[2], "r+") as file:
        file.attrs["kernel_hash"] = "0123456789abcdef"
    with pytest.raises(FileUsageError, match="its kernel_hash is '0123456789abcdef', not"):
        merge(parts, tmp_path / "merged.h5")


def test_blocks_that_overlap_are_refused(tmp_path: Path, parts: list[Path]) -> None:
    with h5py.File(parts[2], "r+") as file:
        file["block_start"][...] -= 1
        file["block_stop"][...] -= 1
    with pytest.raises(FileError, match="is damaged: a block begins at design"):
        merge(parts, tmp_path / "merged.h5")


def test_designs_of_another_lattice_are_refused(tmp_path: Path, parts: list[Path]) -> None:
    with h5py.File(parts[1], "r+") as file:
        file["a"][[0, 1]] = file["a"][...][[1, 0]]
    with pytest.raises(FileError, match=r"part-2\.h5.*are not those of its configuration"):
        merge(parts, tmp_path / "merged.h5")
    assert not (tmp_path / "merged.h5").exists()


@pytest.mark.parametrize("label", ["0/3", "5/3", "x", "1/2/3"])
def test_labels_that_are_none_are_refused(tmp_path: Path, parts: list[Path], label: str) -> None:
    with h5py.File(parts[1], "r+") as file:
        file.attrs["part"] = label
    with pytest.raises(FileError, match=r"part-2\.h5: is damaged"):
        merge(parts, tmp_path / "merged.h5")


def test_ranges_that_are_none_are_refused(tmp_path: Path, parts: list[Path]) -> None:
    with h5py.File(parts[1], "r+") as file:
        del file["block_start"]
        file["block_start"] = 3
    with pytest.raises(FileError, match=r"part-2\.h5: is damaged"):
        merge(parts, tmp_path / "merged.h5")


def test_attributes_of_others_are_ignored(
    tmp_path: Path, toy_settings: SweepSettings, parts: list[Path]
) -> None:
    with h5py.File(parts[0], "r+") as file:
        file.attrs["note"] = "mine"
    with h5py.File(parts[1], "r+") as file:
        file.attrs["numbers"] = [1.0, 2.0]
    merge(parts, tmp_path / "merged.h5")
    assert_same_data(write(tmp_path / "whole.h5", toy_settings), tmp_path / "merged.h5")


@pytest.mark.parametrize("name", ["source_hash", "sweep_designs", "package_version", "processor"])
def test_attributes_that_must_be_there_are_named(
    tmp_path: Path, parts: list[Path], name: str
) -> None:
    with h5py.File(parts[1], "r+") as file:
        del file.attrs[name]
    with pytest.raises(FileError, match=rf"part-2\.h5: is damaged: it does not say its {name}"):
        merge(parts, tmp_path / "merged.h5")


def test_parts_are_normalised_only_by_what_computed_them(
    tmp_path: Path, parts: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(versions, "source_hash", lambda _: "0123456789abcdef")
    with pytest.raises(FileUsageError, match="this program 0123456789abcdef: it would normalise"):
        merge(parts, tmp_path / "merged.h5")


def test_processors_of_all_parts_are_named(
    tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = []
    for number, name in ((1, "old-1"), (2, "new-2")):
        monkeypatch.setattr(jit, "processor", lambda name=name: name)
        shard = Shard(number, 2)
        paths.append(write_part(tmp_path / f"{number}.h5", toy_settings, shard))
    merge(paths, tmp_path / "merged.h5")
    with open_atlas(tmp_path / "merged.h5") as atlas:
        assert atlas.attributes["processor"] == "new-2, old-1"
    command = ["merge", *map(str, paths), "-o", str(tmp_path / "again.h5")]
    said = CliRunner().invoke(main, command, catch_exceptions=False).output
    assert "several kinds of processors (new-2, old-1)" in said


def test_more_parts_than_files_may_be_open(
    tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(merging, "_MOST_OPEN", 2)
    paths = [write_part(tmp_path / f"{n}.h5", toy_settings, Shard(n, 7)) for n in range(1, 8)]
    opened = []
    honest = parts_module.open_hdf5

    def counting(path: Path) -> object:
        found = honest(path)
        opened.append(found[0])
        assert sum(map(bool, opened)) <= 3
        return found

    monkeypatch.setattr(parts_module, "open_hdf5", counting)
    merge(paths, tmp_path / "merged.h5")
    assert_same_data(write(tmp_path / "whole.h5", toy_settings), tmp_path / "merged.h5")


@pytest.mark.parametrize("damage", ["span", "block_start", "truncated"])
def test_damaged_parts_are_refused(tmp_path: Path, parts: list[Path], damage: str) -> None:
    if damage == "truncated":
        data = parts[2].read_bytes()
        parts[2].write_bytes(data[: len(data) // 2])
    else:
        with h5py.File(parts[2], "r+") as file:
            del file[damage]
    with pytest.raises(FileError, match=r"part-3\.h5.*is damaged"):
        merge(parts, tmp_path / "merged.h5")
    assert not (tmp_path / "merged.h5").exists()


def test_atlas_among_the_parts_is_refused(
    tmp_path: Path, toy_settings: SweepSettings, parts: list[Path]
) -> None:
    whole = write(tmp_path / "whole.h5", toy_settings)
    with pytest.raises(FileError, match="holds a whole atlas, not a part"):
        merge([*parts[:2], whole], tmp_path / "merged.h5")


def test_output_is_never_a_part(parts: list[Path]) -> None:
    before = parts[0].read_bytes()
    with pytest.raises(FileUsageError, match="is the input"):
        merge(parts, parts[0], overwrite=True)
    assert parts[0].read_bytes() == before


def test_existing_output_stays(tmp_path: Path, parts: list[Path]) -> None:
    output = tmp_path / "merged.h5"
    output.write_text("mine")
    with pytest.raises(FileUsageError, match="exists already"):
        merge(parts, output)
    assert output.read_text() == "mine"


@pytest.mark.parametrize(
    "text", ["0/3", "4/3", "1/0", "1", "a/b", "1/2/3", "-1/3", "1.5/3", "", "1/" + 5000 * "9"]
)
def test_shard_out_of_range_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="the i-th of n parts"):
        Shard.parse(text)


def test_more_shards_than_blocks_are_refused(toy_settings: SweepSettings) -> None:
    blocks = len(Sweep(toy_settings).blocks)
    assert len(Sweep(toy_settings, Shard(blocks, blocks)).blocks) == 1
    with pytest.raises(InputError, match=f"at most {blocks} parts"):
        Sweep(toy_settings, Shard(1, blocks + 1))


def test_commands_sweep_parts_and_merge_them(tmp_path: Path) -> None:
    def atlas(*arguments: object) -> str:
        found = CliRunner().invoke(main, [str(each) for each in arguments], catch_exceptions=False)
        assert found.exit_code == 0, found.output
        return found.output

    choice = ("--resolution", 24, "--tolerance", 1e-3)
    names = [tmp_path / f"part-{number}.h5" for number in (1, 2)]
    for number, name in enumerate(names, start=1):
        said = atlas("sweep", *choice, "--shard", f"{number}/2", "-o", name)
        assert f"part {number}/2, " in said
        assert "is complete already" in atlas(
            "sweep", *choice, "--shard", f"{number}/2", "-o", name, "--resume"
        )
    said = atlas("info", names[0])
    assert "part 1/2 of an atlas: " in said
    assert json.loads(atlas("info", names[1], "--json"))["part"] == "2/2"
    atlas("sweep", *choice, "-o", tmp_path / "whole.h5")
    said = atlas("merge", *reversed(names), "-o", tmp_path / "merged.h5")
    assert "from 2 parts" in said
    assert_same_data(tmp_path / "whole.h5", tmp_path / "merged.h5")
    with h5py.File(tmp_path / "merged.h5") as file:
        assert np.isfinite(file["gci"][...]).any()


def test_part_needs_an_output_of_its_own(tmp_path: Path) -> None:
    config = tmp_path / "c.toml"
    config.write_text('[run]\noutput = "atlas.h5"\n')
    result = CliRunner().invoke(
        main, ["sweep", str(config), "--shard", "1/2"], standalone_mode=False
    )
    assert result.exception is not None
    assert "A part needs a file of its own" in result.exception.format_message()  # type: ignore[attr-defined]
