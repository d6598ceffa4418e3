"""What a mechanism declares, and that nothing above ``mechanisms/`` needs more than that."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import ROOT, Command
from toy_mechanism import ToyMechanism

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.executors import ThreadExecutor
from fivebar_atlas.mechanisms.five_bar.mechanism import STATUS, FiveBarMechanism
from fivebar_atlas.mechanisms.mode_pairs import mode_signs
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import AtlasWriter, open_atlas
from fivebar_atlas.sweep import Sweep

MODES = ("+-/up", "+-/down", "-+/up", "-+/down", "++/up", "++/down", "--/up", "--/down")


@pytest.fixture
def five_bar() -> FiveBarMechanism:
    return FiveBarMechanism()


@pytest.fixture
def all_modes() -> SweepSettings:
    return SweepSettings("five-bar", "surrounded", 10, MODES, (0.3, 0.5), 1e-6)


def test_modes_are_in_their_fixed_order(five_bar: FiveBarMechanism) -> None:
    assert five_bar.modes == MODES


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("+-/up", "+-/up"),
        ("pm/up", "+-/up"),
        ("PM/UP", "+-/up"),
        ("mp/down", "-+/down"),
        ("pp/up", "++/up"),
        ("mm/Down", "--/down"),
        ("+\N{MINUS SIGN}/up", "+-/up"),
        (" +-/up ", "+-/up"),
    ],
)
def test_modes_are_read_in_signs_and_letters(
    five_bar: FiveBarMechanism, text: str, label: str
) -> None:
    assert five_bar.parse_mode(text) == label


@pytest.mark.parametrize("text", ["", "+-", "+-/", "/up", "up", "+-/left", "+0/up", "+-+/up", "x"])
def test_unknown_modes_are_refused(five_bar: FiveBarMechanism, text: str) -> None:
    with pytest.raises(UnknownNameError, match=r"\+-/up, \+-/down"):
        five_bar.parse_mode(text)


def test_all_stands_for_all_modes_and_repetitions_are_dropped(five_bar: FiveBarMechanism) -> None:
    assert five_bar.parse_modes(["all"]) == MODES
    assert five_bar.parse_modes(["--/up", "all"]) == ("--/up", *(m for m in MODES if m != "--/up"))
    assert five_bar.parse_modes(["pm/up", "+-/up"]) == ("+-/up",)
    with pytest.raises(InputError, match="at least one"):
        five_bar.parse_modes([])
    with pytest.raises(UnknownNameError, match=r"^--mode: .*, all"):
        five_bar.parse_modes(["+-/up", "no"], "--mode")


def test_mode_signs_are_elbows_and_sign_of_det_b() -> None:
    assert [mode_signs(label) for label in MODES] == [
        (1, -1, 1),
        (1, -1, -1),
        (-1, 1, 1),
        (-1, 1, -1),
        (1, 1, 1),
        (1, 1, -1),
        (-1, -1, 1),
        (-1, -1, -1),
    ]


def test_declared_arrays_are_those_of_the_format(
    five_bar: FiveBarMechanism, all_modes: SweepSettings
) -> None:
    arrays = {array.name: array for array in five_bar.result_arrays(all_modes)}
    per_design = {"sub_region", "theoretical_workspace_area", "theoretical_workspace_area_error"}
    per_threshold = {
        "good_condition_workspace_area",
        "good_condition_workspace_area_error",
        "good_condition_gci",
        "good_condition_gci_error",
    }
    per_mode = {
        "usable_workspace_area",
        "usable_workspace_area_error",
        "gci",
        "gci_error",
        "max_lci",
        "max_lci_x",
        "max_lci_y",
        "mic_upper_radius",
        "mic_upper_y",
        "mic_lower_radius",
        "mic_lower_y",
        "status",
    }
    assert set(arrays) == per_design | per_mode | per_threshold
    assert all(arrays[name].lengths == () for name in per_design)
    assert all(arrays[name].lengths == (8,) for name in per_mode)
    assert all(arrays[name].lengths == (8, 2) for name in per_threshold)
    assert arrays["sub_region"].dtype == np.int8
    assert arrays["status"].dtype == np.int16
    floats = set(arrays) - {"sub_region", "status"}
    assert all(arrays[name].dtype == np.float64 for name in floats)


def test_status_bits_are_explained_together() -> None:
    assert STATUS.describe(0) == "ok"
    assert STATUS.describe(4) == "tolerance_not_reached"
    assert STATUS.describe(1 + 8 + 16) == (
        "empty_usable_workspace, no_upper_inscribed_circle, no_lower_inscribed_circle"
    )


def test_axis_columns_are_flags(five_bar: FiveBarMechanism, all_modes: SweepSettings) -> None:
    mode, threshold = five_bar.axes(all_modes)
    working, assembly = mode.columns
    assert working.flags is not None
    assert assembly.flags is not None
    labels = [
        f"{working.flags.describe(int(w))}/{assembly.flags.describe(int(a))}"
        for w, a in zip(working.values, assembly.values, strict=True)
    ]
    assert tuple(labels) == mode.labels == MODES
    assert working.values.dtype == assembly.values.dtype == np.int8
    assert threshold.columns[0].values.tolist() == [0.3, 0.5]


@pytest.mark.parametrize("module", ["mechanism", "design_space"], ids=["mechanism", "design_space"])
def test_declarations_import_nothing_heavy(module: str) -> None:
    script = (
        f"import sys; import fivebar_atlas.mechanisms.five_bar.{module}; "
        "print(sorted({'numba', 'pydantic', 'h5py', 'matplotlib', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_no_layer_above_names_a_mechanism() -> None:
    """A new mechanism is a new folder and one registry line."""
    package = ROOT / "fivebar_atlas"
    above = [
        source
        for source in package.rglob("*.py")
        if "mechanisms" not in source.relative_to(package).parts
        # The public interface offers a class of each mechanism.
        and source != package / "__init__.py"
    ]
    assert len(above) > 10
    for source in above:
        text = source.read_text(encoding="utf-8")
        assert "five_bar" not in text, source
        assert '"five-bar"' not in text, source


def test_generic_description_of_one_design(toy_settings: SweepSettings) -> None:
    toy = ToyMechanism()
    parameters, factor = toy.from_lengths([0.0, 1.0])
    document = toy.document(
        parameters, factor, toy_settings, toy.evaluate(parameters[None], toy_settings)
    )
    assert document["a"] == 0.0
    assert document["mode"] == ["right", "left"]
    assert document["sweep_area"] == [None, None]
    assert document["status"] == ["no_span", "no_span"]
    json.dumps(document, allow_nan=False)
    with pytest.raises(InputError, match="2 numbers: a b"):
        toy.from_lengths([1.0])
    with pytest.raises(InputError, match="finite"):
        toy.from_lengths([1.0, float("nan")])


def test_another_mechanism_goes_from_sweep_to_table(
    toy_settings: SweepSettings, tmp_path: Path, atlas: Command
) -> None:
    """Sweep, file, reading, info and export know a mechanism by its declarations only."""
    output = tmp_path / "toy.h5"
    work = Sweep(toy_settings)
    assert len(work.blocks) > 3
    ranges = [(block.start, block.stop) for block in work.blocks]
    with AtlasWriter(output, toy_settings, work.designs, ranges) as writer:
        for results in work.run(ThreadExecutor(2)):
            writer.add(results.block.index, results.arrays)
        writer.assemble()
    toy = mechanisms.get("toy")
    expected = toy.evaluate(toy.lattice("whole", 200), toy_settings)
    with open_atlas(output) as opened:
        assert opened.settings == toy_settings
        assert opened.mechanism.name == "toy"
        assert opened.modes == ("right", "left")
        np.testing.assert_array_equal(opened.designs, toy.lattice("whole", 200))
        for name, values in expected.items():
            np.testing.assert_array_equal(opened[name], values)
        np.testing.assert_array_equal(
            opened.select("share", "left", 0.75), expected["share"][:, 1, 2]
        )
    info = json.loads(atlas("info", output, "--json").out)
    assert (info["mechanism"], info["designs"], info["resolution"]) == ("toy", 201, 200)
    table = tmp_path / "toy.csv"
    assert atlas("export", output, "-o", table).code == 0
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 201
    row = rows[2 * 7 + 1]
    assert (row["side"], row["status"]) == ("left", "ok")
    assert float(row["share_level_0.75"]) == expected["share"][7, 1, 2]
    assert float(row["a"]) == 7 / 200


def test_another_mechanism_goes_through_the_commands(
    toy: str, tmp_path: Path, atlas: Command
) -> None:
    output = tmp_path / "toy.h5"
    options = ["--mechanism", toy, "--resolution", 50, "--mode", "all", "--quiet"]
    assert atlas("sweep", *options, "-o", output).code == 0
    shown = atlas("config", "show", "--mechanism", toy).out
    assert 'mechanism = "toy"' in shown
    assert 'space = "whole"' in shown
    text = atlas("evaluate", "--mechanism", toy, 0.25, 0.75, "--mode", "right").out
    assert "sweep_area" in text
    document: dict[str, Any] = json.loads(
        atlas("evaluate", "--mechanism", toy, 0.25, 0.75, "--json").out
    )
    assert document["span"] == pytest.approx(np.hypot(0.25, 0.75))


def test_unknown_mechanism_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'five-bar'"):
        mechanisms.get("fivebar")
