"""``atlas info`` and ``atlas export``: what they say is what is stored."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from pathlib import Path

import closed_form_atlas
import numpy as np
import pytest
from conftest import Command

from fivebar_atlas import open_atlas


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    """Return a five-bar result file of two modes and two thresholds."""
    return closed_form_atlas.write(tmp_path / "stored.h5", resolution=12)


def read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_info_says_what_is_stored(atlas: Command, stored: Path) -> None:
    outcome = atlas("info", stored)
    assert outcome.code == 0
    assert str(stored) in outcome.out
    assert "33 of the surrounded design space, N = 12" in outcome.out
    assert "+-/up, ++/up" in outcome.out
    assert "0.3, 0.5" in outcome.out
    assert "kernel_hash" in outcome.out


def test_info_as_json_has_the_ranges(atlas: Command, stored: Path) -> None:
    document = json.loads(atlas("info", stored, "--json").out)
    with open_atlas(stored) as opened:
        quantities = {entry["name"]: entry for entry in document["quantities"]}
        assert list(quantities) == [q.name for q in opened.mechanism.quantities]
        area = opened["usable_workspace_area"]
        entry = quantities["usable_workspace_area"]
        assert (entry["least"], entry["greatest"]) == (area.min(), area.max())
        gci = opened["gci"]
        assert quantities["gci"]["missing"] == np.isnan(gci).sum() > 0
        assert quantities["gci"]["greatest"] == np.nanmax(gci)
        assert quantities["gci"]["greatest_error"] == np.nanmax(opened["gci_error"])
        status = opened["status"]

        codes, counts = np.unique(status, return_counts=True)
        flags = opened.quantity("status").flags
        assert flags is not None
        assert quantities["status"]["counts"] == {
            flags.describe(int(code)): int(count) for code, count in zip(codes, counts, strict=True)
        }
        assert document["designs"] == len(opened)
        assert document["made"]["kernel_hash"] == opened.attributes["kernel_hash"]


def test_export_has_one_row_a_design_and_mode_pair(
    atlas: Command, stored: Path, tmp_path: Path
) -> None:
    table = tmp_path / "table.csv"
    outcome = atlas("export", stored, "-o", table)
    assert outcome.code == 0
    assert outcome.out == ""
    rows = read_csv(table)
    with open_atlas(stored) as opened:
        assert len(rows) == 2 * len(opened)
        labels = [f"{row['working_mode']}/{row['assembly_mode']}" for row in rows]
        assert labels == list(opened.modes) * len(opened)
        for number, label in enumerate(opened.modes):
            of_mode = rows[number::2]
            for name in opened.names:
                array = opened[name]
                if array.ndim == 3:
                    for place, lci in enumerate(opened.lci_thresholds):
                        column = [float(row[f"{name}_lci_threshold_{lci}"]) for row in of_mode]
                        np.testing.assert_array_equal(column, array[:, number, place])
                elif array.dtype == np.float64:
                    column = [float(row[name]) for row in of_mode]
                    np.testing.assert_array_equal(column, opened.select(name, label))
                else:
                    flags = opened.quantity(name).flags
                    assert flags is not None
                    expected = [flags.describe(int(v)) for v in opened.select(name, label)]
                    assert [row[name] for row in of_mode] == [
                        text.replace(", ", " ") for text in expected
                    ]


def test_export_in_several_parts_is_the_same(
    atlas: Command, stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert atlas("export", stored, "-o", tmp_path / "whole.csv").code == 0
    monkeypatch.setattr("fivebar_atlas.export._DESIGNS_AT_A_TIME", 7)
    assert atlas("export", stored, "-o", tmp_path / "parts.csv").code == 0
    assert (tmp_path / "parts.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_missing_values_are_nan(atlas: Command, stored: Path, tmp_path: Path) -> None:
    atlas("export", stored, "-o", tmp_path / "table.csv")
    rows = read_csv(tmp_path / "table.csv")
    empty = [row for row in rows if "empty_usable_workspace" in row["status"]]
    assert empty
    assert all(math.isnan(float(row["gci"])) for row in empty)
    assert all(row["gci"] == "nan" for row in empty)


def test_existing_table_needs_overwrite(
    atlas: Command, refused: Callable[..., str], stored: Path, tmp_path: Path
) -> None:
    table = tmp_path / "table.csv"
    table.write_text("mine")
    assert "exists already" in refused("export", stored, "-o", table)
    assert table.read_text() == "mine"
    assert atlas("export", stored, "-o", table, "--overwrite", "--quiet").err == ""
    assert len(read_csv(table)) == 66


def test_damage_found_on_the_way_leaves_the_old_table(
    refused: Callable[..., str], stored: Path, tmp_path: Path
) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(stored) as file:
        place = file["good_condition_gci_error"].id.get_chunk_info(0)
    data = bytearray(stored.read_bytes())
    data[place.byte_offset + place.size // 2] ^= 1
    stored.write_bytes(data)
    table = tmp_path / "table.csv"
    table.write_text("mine")
    message = refused("export", stored, "-o", table, "--overwrite", code=1)
    assert "is damaged" in message
    assert table.read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["stored.h5", "table.csv"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the platform has no /dev/full")
def test_full_disk_leaves_the_old_table(
    refused: Callable[..., str], stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = tmp_path / "table.csv"
    table.write_text("mine")
    honest = Path.open

    def full(self: Path, *arguments: object, **options: object) -> object:
        target = Path("/dev/full") if self.name.startswith(".table") else self
        return honest(target, *arguments, **options)  # type: ignore[call-overload]

    monkeypatch.setattr(Path, "open", full)
    message = refused("export", stored, "-o", table, "--overwrite", code=1)
    assert "there is no space left on the disk" in message
    assert table.read_text() == "mine"


@pytest.mark.parametrize(("command", "code"), [("info", 2), ("export", 2)], ids=["info", "export"])
def test_files_that_are_not_result_files(
    refused: Callable[..., str], tmp_path: Path, command: str, code: int
) -> None:
    options = ["-o", tmp_path / "table.csv"] if command == "export" else []
    missing = tmp_path / "missing.h5"
    assert "no such file" in refused(command, missing, *options, code=code)
    foreign = tmp_path / "foreign.h5"
    foreign.write_text("hello")
    assert "not an HDF5 file" in refused(command, foreign, *options, code=1)
    assert not (tmp_path / "table.csv").exists()


def test_truncated_result_file(refused: Callable[..., str], stored: Path) -> None:
    data = stored.read_bytes()
    stored.write_bytes(data[: len(data) // 2])
    assert "is damaged" in refused("info", stored, code=1)


def test_table_in_a_missing_folder(
    refused: Callable[..., str], stored: Path, tmp_path: Path
) -> None:
    message = refused("export", stored, "-o", tmp_path / "no" / "table.csv")
    assert "does not exist" in message
