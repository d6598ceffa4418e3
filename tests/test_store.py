"""The result file: its format, how it is written, and what is said of files that are not one."""

from __future__ import annotations

import dataclasses
import errno
import gc
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray
from toy_mechanism import ToyMechanism

from fivebar_atlas import config, open_atlas, store
from fivebar_atlas.errors import FileError, FileUsageError, InputError, UnknownNameError
from fivebar_atlas.executors import ThreadExecutor
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import assembly, guarded_file, provenance
from fivebar_atlas.sweep import Sweep


def write(output: Path, settings: SweepSettings, **options: Any) -> Path:
    """Run a sweep into a file."""
    work = Sweep(settings)
    ranges = [(block.start, block.stop) for block in work.blocks]
    with store.AtlasWriter(output, settings, work.designs, ranges, **options) as writer:
        for results in work.run(ThreadExecutor(2), writer.finished):
            writer.add(results.block.index, results.arrays)
        writer.assemble()
    return output


@pytest.fixture
def output(tmp_path: Path, toy_settings: SweepSettings) -> Path:
    return write(tmp_path / "toy.h5", toy_settings, command_line="atlas sweep 'a b.toml'")


@pytest.fixture
def file(output: Path) -> Iterator[h5py.File]:
    with h5py.File(output) as opened:
        yield opened


@pytest.fixture
def expected(toy_settings: SweepSettings) -> dict[str, Any]:
    toy = ToyMechanism()
    return toy.evaluate(toy.lattice("whole", 200), toy_settings)


# The format


def test_file_holds_the_declared_datasets_and_nothing_else(file: h5py.File) -> None:
    assert set(file) == {
        *("design", "mode", "threshold"),
        *("a", "b", "side", "level"),
        *("span", "span_error", "sweep_area", "share", "share_error", "status"),
        *("normalised_span", "normalised_span_error", "composed", "composed_error", "relative"),
    }


def test_datasets_hold_what_was_computed(file: h5py.File, expected: dict[str, Any]) -> None:
    for name, values in expected.items():
        np.testing.assert_array_equal(file[name][...], values)
    np.testing.assert_array_equal(file["a"][...], np.arange(201) / 200)
    assert file["side"][...].tolist() == [1, 0]
    assert file["level"][...].tolist() == [0.25, 0.5, 0.75]


def test_datasets_have_units_meanings_and_scales(file: h5py.File) -> None:
    assert dict(file["span"].attrs)["units"] == "m"
    assert file["span"].attrs["long_name"] == "span"
    assert file["span"].attrs["ancillary_variables"] == "span_error"
    assert file["span_error"].attrs["units"] == "m"
    assert file["span_error"].attrs["long_name"] == "absolute error estimate of the span"
    assert file["a"].attrs["long_name"] == "first link"
    scales = [[scale.name for scale in dim.values()] for dim in file["share"].dims]
    assert scales == [["/design"], ["/mode"], ["/threshold"]]
    for name in ("design", "mode", "threshold"):
        assert file[name].is_scale
        # A dimension without values takes no room.
        assert file[name].id.get_storage_size() == 0


def test_flags_are_integers_with_meanings(file: h5py.File) -> None:
    side, status = file["side"], file["status"]
    assert side.dtype == side.attrs["flag_values"].dtype == np.int8
    assert side.attrs["flag_values"].tolist() == [0, 1]
    assert side.attrs["flag_meanings"] == "left right"
    assert status.dtype == status.attrs["flag_masks"].dtype == np.int16
    assert status.attrs["flag_masks"].tolist() == [1, 2]
    assert status.attrs["flag_meanings"] == "no_span short_link"


def test_datasets_are_compressed_and_checked(file: h5py.File) -> None:
    for name in ("a", "span", "sweep_area", "share", "share_error", "status", "side"):
        dataset = file[name]
        assert (dataset.compression, dataset.shuffle, dataset.fletcher32) == ("gzip", True, True)


def test_root_attributes_say_how_it_was_made(file: h5py.File, toy_settings: SweepSettings) -> None:
    attributes = dict(file.attrs)
    assert attributes["format"] == "fivebar-atlas"
    assert attributes["format_version"] == 1
    assert attributes["mechanism"] == "toy"
    assert config.settings_from_text(attributes["configuration"], "file") == toy_settings
    assert attributes["command_line"] == "atlas sweep 'a b.toml'"
    assert len(attributes["kernel_hash"]) == 16
    assert attributes["created"].endswith("Z")
    assert {"package_version", "numba_version", "numpy_version"} <= set(attributes)


def test_xarray_opens_it_as_it_is(output: Path, expected: dict[str, Any]) -> None:
    with xarray.open_dataset(output, engine="h5netcdf") as dataset:
        assert dict(dataset.sizes) == {"design": 201, "mode": 2, "threshold": 3}
        assert dataset["share"].dims == ("design", "mode", "threshold")
        np.testing.assert_array_equal(dataset["share"].values, expected["share"])
        assert set(dataset.coords) == {"a", "b", "side", "level"}
        assert dataset["span"].attrs["units"] == "m"
        assert dataset["status"].dtype == np.int16
        assert dataset.attrs["format"] == "fivebar-atlas"


def test_h5netcdf_sees_dimensions_of_its_own_kind(output: Path) -> None:
    h5netcdf = pytest.importorskip("h5netcdf")
    with h5netcdf.File(output, "r") as file:
        assert {name: len(dim) for name, dim in file.dimensions.items()} == {
            "design": 201,
            "mode": 2,
            "threshold": 3,
        }
        assert file.variables["share"].dimensions == ("design", "mode", "threshold")
        assert "design" not in file.variables


def test_no_threshold_at_all_is_stored_and_read(
    tmp_path: Path, toy_settings: SweepSettings
) -> None:
    settings = dataclasses.replace(toy_settings, lci_thresholds=())
    output = write(tmp_path / "none.h5", settings)
    with open_atlas(output) as opened:
        assert opened["share"].shape == (201, 2, 0)
        assert opened.lci_thresholds == ()
        with pytest.raises(InputError, match="none"):
            opened.select("share", "left")
    with xarray.open_dataset(output, engine="h5netcdf") as dataset:
        assert dataset.sizes["threshold"] == 0


def test_many_designs_fill_several_chunks(tmp_path: Path, toy: str) -> None:
    settings = SweepSettings(toy, "whole", 40_000, ("left",), (0.5,), 1e-6)
    output = write(tmp_path / "long.h5", settings)
    with h5py.File(output) as file:
        assert file["span"].chunks[0] < 40_001
    toy_mechanism = ToyMechanism()
    values = toy_mechanism.evaluate(toy_mechanism.lattice("whole", 40_000), settings)
    with open_atlas(output) as opened:
        for name, expected in values.items():
            np.testing.assert_array_equal(opened[name], expected)


def test_data_of_two_runs_are_the_same_byte_for_byte(
    tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the time of making differs, so with that fixed the files are equal."""

    class Fixed(provenance.datetime.datetime):  # type: ignore[name-defined, misc]
        @classmethod
        def now(cls, tz: Any = None) -> Any:
            return cls(2024, 1, 1, tzinfo=tz)

    monkeypatch.setattr(provenance.datetime, "datetime", Fixed)
    first = write(tmp_path / "first.h5", toy_settings)
    second = write(tmp_path / "second.h5", toy_settings)
    assert first.read_bytes() == second.read_bytes()


# Writing


def test_nothing_is_left_beside_the_result(output: Path) -> None:
    assert list(output.parent.iterdir()) == [output]


def test_existing_output_is_refused(output: Path, toy_settings: SweepSettings) -> None:
    before = output.read_bytes()
    with pytest.raises(FileUsageError, match="--overwrite"):
        write(output, toy_settings)
    assert output.read_bytes() == before
    assert list(output.parent.iterdir()) == [output]


def test_overwriting_replaces_at_the_end(output: Path, toy_settings: SweepSettings) -> None:
    settings = dataclasses.replace(toy_settings, resolution=60)
    work = Sweep(settings)
    ranges = [(block.start, block.stop) for block in work.blocks]
    with store.AtlasWriter(output, settings, work.designs, ranges, overwrite=True) as writer:
        for results in work.run(ThreadExecutor(1)):
            writer.add(results.block.index, results.arrays)
        with open_atlas(output) as opened:
            assert opened.settings == toy_settings
        writer.assemble()
    with open_atlas(output) as opened:
        assert opened.settings == settings


@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO])
@pytest.mark.parametrize("after", [0, 1, 5, 40])
def test_disk_that_fills_up_while_the_file_is_written(
    output: Path,
    toy_settings: SweepSettings,
    monkeypatch: pytest.MonkeyPatch,
    fault: int,
    after: int,
) -> None:
    """HDF5 must not see the fault; the old file and the blocks stay; resuming completes."""
    before = output.read_bytes()
    writes = 0
    honest = guarded_file.GuardedFile

    class Failing:
        def __init__(self, file: Any) -> None:
            self.file = file

        def write(self, data: Any) -> int:
            nonlocal writes
            writes += 1
            if writes > after:
                raise OSError(fault, "as if")
            return int(self.file.write(data))

        def __getattr__(self, name: str) -> Any:
            return getattr(self.file, name)

    monkeypatch.setattr(assembly, "GuardedFile", lambda file: honest(Failing(file)))  # type: ignore[arg-type]
    with pytest.raises(FileError, match="finished blocks are kept") as caught:
        write(output, toy_settings, overwrite=True)
    assert caught.value.exit_code == 1
    assert output.read_bytes() == before
    partial = output.with_name("toy.h5.partial")
    assert not list(partial.glob("*.h5"))
    monkeypatch.undo()


def test_disk_that_fills_up_while_a_block_is_written(
    tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    honest = Path.replace

    def full(self: Path, target: Path) -> Path:
        if "block-000009" in str(target):
            raise OSError(errno.ENOSPC, "as if")
        return honest(self, target)

    output = tmp_path / "toy.h5"
    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(FileError, match=r"no space left on the disk; the \d+ finished blocks"):
        write(output, toy_settings)
    assert not output.exists()
    kept = sorted(path.name for path in output.with_name("toy.h5.partial").glob("block-*"))
    assert kept
    assert "block-000009" not in "".join(kept)
    monkeypatch.setattr(Path, "replace", honest)
    write(output, toy_settings, resume=True)
    reference = write(tmp_path / "reference.h5", toy_settings)
    with open_atlas(output) as one, open_atlas(reference) as other:
        for name in one.names:
            assert one[name].tobytes() == other[name].tobytes()


def test_disk_full_from_the_start_leaves_nothing(
    tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: Path, target: Path) -> Path:
        raise OSError(errno.ENOSPC, "as if", str(self), None, str(target))

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(FileError, match="no space left"):
        write(tmp_path / "toy.h5", toy_settings)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        ("missing/toy.h5", FileUsageError, "folder .* does not exist"),
        ("taken.txt/toy.h5", FileUsageError, "folder .* does not exist"),
        ("folder", FileUsageError, "is a folder"),
    ],
)
def test_outputs_that_cannot_be(
    tmp_path: Path, toy_settings: SweepSettings, name: str, error: type, message: str
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "taken.txt").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    for overwrite in (False, True):
        with pytest.raises(error, match=message):
            write(tmp_path / name, toy_settings, overwrite=overwrite)
    assert sorted(tmp_path.rglob("*")) == before
    assert (tmp_path / "taken.txt").read_text() == "mine"


def test_device_is_never_replaced(toy_settings: SweepSettings) -> None:
    with pytest.raises(FileUsageError, match="not an ordinary file"):
        write(Path("/dev/null"), toy_settings, overwrite=True)
    assert Path("/dev/null").is_char_device()


# Reading


def test_reading_finds_what_was_stored(
    output: Path, toy_settings: SweepSettings, expected: dict[str, Any]
) -> None:
    opened = open_atlas(output)
    assert opened.path == output
    assert opened.mechanism.name == "toy"
    assert opened.settings == toy_settings
    assert opened.modes == ("right", "left")
    assert opened.lci_thresholds == (0.25, 0.5, 0.75)
    assert len(opened) == 201
    assert opened.designs.shape == (201, 2)
    assert opened.quantity("span").unit == "m"
    assert opened.attributes["format_version"] == 1
    assert opened["side"].tolist() == [1, 0]
    assert "toy.h5" in repr(opened)
    np.testing.assert_array_equal(opened.select("a"), np.arange(201) / 200)
    np.testing.assert_array_equal(opened.select("span_error"), expected["span_error"])
    np.testing.assert_array_equal(
        opened.select("sweep_area", mode="left"), expected["sweep_area"][:, 1]
    )
    np.testing.assert_array_equal(
        opened.select("share_error", "right", 0.5), expected["share_error"][:, 0, 1]
    )
    # What a quantity does not depend on does not matter.
    np.testing.assert_array_equal(opened.select("span", "left", 0.5), expected["span"])
    opened.close()


def test_choice_is_not_needed_where_there_is_none(
    tmp_path: Path, toy_settings: SweepSettings
) -> None:
    settings = dataclasses.replace(toy_settings, modes=("left",), lci_thresholds=(0.1,))
    with open_atlas(write(tmp_path / "one.h5", settings)) as opened:
        np.testing.assert_array_equal(opened.select("share"), opened["share"][:, 0, 0])


def test_threshold_is_found_despite_the_last_digit(
    tmp_path: Path, toy_settings: SweepSettings
) -> None:
    settings = dataclasses.replace(toy_settings, lci_thresholds=(0.1 + 0.2, 0.5))
    with open_atlas(write(tmp_path / "digits.h5", settings)) as opened:
        np.testing.assert_array_equal(opened.select("share", "left", 0.3), opened["share"][:, 1, 0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("shar", "left", 0.5), "did you mean 'share'"),
        (("side",), "one of a, b, span"),
        (("share", "up", 0.5), "one of left, right"),
        (("share", "left", 0.6), "0.25, 0.5, 0.75"),
        (("share", None, 0.5), "right, left"),
        (("share", "left", None), "0.25, 0.5, 0.75"),
    ],
)
def test_what_is_not_in_the_file_is_named(
    output: Path, arguments: tuple[Any, ...], message: str
) -> None:
    with open_atlas(output) as opened, pytest.raises(InputError, match=message):
        opened.select(*arguments)


def test_mode_that_exists_but_is_not_stored_is_named(
    tmp_path: Path, toy_settings: SweepSettings
) -> None:
    settings = dataclasses.replace(toy_settings, modes=("left",))
    path = write(tmp_path / "left.h5", settings)
    with open_atlas(path) as opened:
        with pytest.raises(InputError, match=r"mode: 'right' .* one of those in .*left\.h5: left"):
            opened.select("sweep_area", "right")
        with pytest.raises(UnknownNameError, match="side, level"):
            opened["nothing"]


def test_atlas_is_closed_with_its_last_reference(output: Path) -> None:
    opened = open_atlas(output)
    opened["span"]
    del opened
    gc.collect()
    with h5py.File(output, "r+") as file:
        assert "span" in file


# Files that are not result files


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileUsageError, match="no such file"):
        open_atlas(tmp_path / "missing.h5")
    (tmp_path / "file").write_text("x")
    with pytest.raises(FileUsageError, match="no such file"):
        open_atlas(tmp_path / "file" / "below.h5")
    with pytest.raises(FileUsageError, match="folder"):
        open_atlas(tmp_path)


@pytest.mark.parametrize("content", [b"", b"hello", b"\x00" * 5000])
def test_file_that_is_not_hdf5(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "text.h5"
    path.write_bytes(content)
    with pytest.raises(FileError, match="not an HDF5 file"):
        open_atlas(path)


def test_hdf5_file_of_something_else(tmp_path: Path) -> None:
    path = tmp_path / "other.h5"
    with h5py.File(path, "w") as file:
        file["gci"] = np.ones(3)
    with pytest.raises(FileError, match="not one written by atlas sweep"):
        open_atlas(path)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.3, 0.6, 0.9, 0.999])
def test_truncated_file(output: Path, share: float) -> None:
    data = output.read_bytes()
    output.write_bytes(data[: int(share * len(data))])
    with pytest.raises(FileError, match="is damaged"):
        open_atlas(output)


def test_flipped_bit_in_the_data_is_noticed(output: Path) -> None:
    """By the checksum of the file, and by those of HDF5 where other programs dropped that."""
    with h5py.File(output) as file:
        place = file["share"].id.get_chunk_info(0)
    data = bytearray(output.read_bytes())
    data[place.byte_offset + place.size // 2] ^= 1
    output.write_bytes(data)
    with pytest.raises(FileError, match="is damaged: its data are not those of its checksum"):
        open_atlas(output)
    with h5py.File(output, "r+"):
        pass
    with open_atlas(output) as opened:
        opened["span"]
        with pytest.raises(FileError, match="is damaged"):
            opened["share"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda file: file.attrs.modify("format_version", 2), "format version 2.*reads up to 1"),
        (lambda file: file.attrs.update(format_version="x"), "does not say its format version"),
        (lambda file: file.attrs.pop("configuration"), "configuration that cannot be read"),
        (
            lambda file: file.attrs.modify("configuration", 'mechanism = "hexapod"'),
            "configuration that cannot be read: .*hexapod",
        ),
        (lambda file: file.pop("share"), "'share' is missing"),
        (lambda file: file.pop("a"), "is damaged"),
        (lambda file: file.move("share_error", "span_error2"), "'share_error' is missing"),
        (
            lambda file: (file.pop("span"), file.create_dataset("span", data=np.ones(3))),
            "'span' has shape",
        ),
        (lambda file: (file.pop("level"), file.create_group("level")), "is damaged"),
    ],
)
def test_file_with_something_wrong_in_it(output: Path, change: Any, message: str) -> None:
    with h5py.File(output, "r+") as file:
        change(file)
    with pytest.raises(FileError, match=message) as caught:
        open_atlas(output)
    assert caught.value.exit_code == 1
    assert str(output) in str(caught.value)
