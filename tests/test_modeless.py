"""A mechanism without modes: files, tables, figures and optima have no mode axis and no mode."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
import pytest
from conftest import Command
from matplotlib.figure import Figure
from matplotlib.text import Text
from modeless_mechanism import ModelessMechanism
from report_page import read_page

from fivebar_atlas import mechanisms
from fivebar_atlas.figures.atlas_figures import quantity_figure, region_figure
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import open_atlas
from fivebar_atlas.synthesis.candidates import Candidates
from fivebar_atlas.synthesis.conditions import parse_condition


@pytest.fixture
def file(modeless: str, tmp_path: Path, atlas: Command) -> Path:
    path = tmp_path / "modeless.h5"
    levels = ("--lci", 0.25, "--lci", 0.5)
    outcome = atlas("sweep", "--mechanism", modeless, *levels, "-o", path)
    assert outcome.code == 0
    assert ": 81 designs, " in outcome.err
    assert "only" not in outcome.err
    return path


def said(figure: Figure) -> str:
    """Return everything that is written in a figure."""
    return " ".join(labels_of(figure))


def labels_of(figure: Figure) -> list[str]:
    """Return every text in a figure."""
    return [text.get_text() for text in figure.findobj(Text)]


def test_the_file_has_no_mode_dimension(file: Path) -> None:
    with h5py.File(file) as opened:
        assert "mode" not in opened
        assert opened["room"].shape == (81,)
        assert opened["good_room"].shape == (81, 2)
    with open_atlas(file) as opened:
        assert opened.select("good_room", lci=0.5) == pytest.approx(0.5 * opened["room"])
        # a mode is of no use, and the only one is no error
        assert opened.select("merit", "only") == pytest.approx(opened["merit"])


def test_info_export_and_lookup_name_no_mode(file: Path, tmp_path: Path, atlas: Command) -> None:
    summary = atlas("info", file).out.split("made by")[0]
    assert "mode" not in summary.replace("modeless", "").replace("Modeless", "")
    table = tmp_path / "table.csv"
    assert atlas("export", file, "-o", table).err == f"{table}: 81 rows\n"
    with table.open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0])[:2] == ["a", "b"]
    assert len(rows) == 81
    assert all(float(row["good_room_level_0.5"]) == 0.5 * float(row["room"]) for row in rows)
    found = json.loads(atlas("lookup", 2, 0.62, 0.41, file, "--json").out)["values"]
    assert all("mode" not in entry for entry in found)
    rooms = [entry for entry in found if entry["quantity"] == "room"]
    assert [each["scaled_exact"] for each in rooms] == pytest.approx([8.0 * 1.515])


def test_one_design_is_summed_up_without_a_mode(
    modeless: str, tmp_path: Path, atlas: Command
) -> None:
    design = ("--mechanism", modeless, 2, 0.6, 0.4)
    rows = [line.split() for line in atlas("evaluate", *design).out.splitlines()]
    assert ["room", "1.5", "±", "1.5e-06", "12"] in rows
    assert ["good_room", "at", "0.25", "1.125", "±", "1.5e-06"] in rows  # its own threshold
    page = tmp_path / "design.html"
    assert atlas("report", "evaluate", *design, "-o", page).code == 0
    text = read_page(page.read_text(encoding="utf-8")).text
    assert "Modeless: room 1.5 ± 1.5e-06 D³ and merit 0.8, with D = 2." in text
    assert "lengths times D, volumes times D³" in text
    assert "of good-condition places" in text
    assert "Mode pair" not in text


def test_optima_are_those_of_the_closed_forms(file: Path, atlas: Command) -> None:
    found = json.loads(
        atlas(
            "optimum", file, "--where", "room>=1.8", "--refine", "--maximise", "merit", "--json"
        ).out
    )
    assert found["mode"] is None
    assert found["refined"]["share"] == pytest.approx(1.0 - 0.5 * 0.8**2, abs=1e-9)
    assert found["maximum"]["design"] == pytest.approx({"a": 0.7, "b": 0.4}, abs=1e-6)
    front = json.loads(atlas("optimum", file, "--pareto", "room,merit", "--polish", "--json").out)
    for member in front["pareto"]["members"]:
        design = member["design"]
        # between both optima both parameters grow alike, until a is at its end
        grown = design["a"] - 0.7
        if design["a"] < 1.0:
            assert design["b"] - 0.4 == pytest.approx(grown, abs=1e-6)


def test_errors_of_values_do_not_mislead_a_search(
    file: Path, atlas: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    exact, seen = ModelessMechanism.evaluate, []

    def sampled(
        self: ModelessMechanism, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        seen.append((len(parameters), settings.tolerance))
        results = exact(self, parameters, settings)
        # jumps from design to design that are far below the tolerance
        results["merit"] = results["merit"] + 1e-5 * np.sin(1e7 * parameters.sum(axis=1))
        return results

    monkeypatch.setattr(ModelessMechanism, "evaluate", sampled)
    monkeypatch.setattr(ModelessMechanism, "exact_tolerance", None)
    monkeypatch.setattr(ModelessMechanism, "exact_step", 1e-2)
    found = json.loads(atlas("optimum", file, "--maximise", "merit", "--json").out)["maximum"]
    # where the exact merit is within the jumps of its maximum
    assert found["design"] == pytest.approx({"a": 0.7, "b": 0.4}, abs=0.005)
    assert found["value"] == pytest.approx(1.0, abs=1.1e-5)
    # nothing tighter than the file is asked for, and the survey is looser
    assert sorted({tolerance for _, tolerance in seen}) == pytest.approx([1e-6, 1e-5])
    assert sum(designs for designs, _ in seen) < 4000
    text = atlas("optimum", file, "--where", "merit>=0.9", "--refine").out
    assert "errors of the values themselves not included" in text


def test_figures_are_drawn_over_what_the_mechanism_declares(file: Path) -> None:
    with open_atlas(file) as opened:
        text = said(quantity_figure(opened, "good_room", lci=0.5))
        assert "LCI" in text
        assert "mode" not in text
        found = Candidates(opened, [parse_condition("merit>=0.9")], None, None).region
        text = said(region_figure(opened, found.region, [("merit", ">=", 0.9)]))
        assert "Optimum region" in text
        assert "mode" not in text
        assert {"room $v$ (in units of $D^{3}$)", "merit $m$ (dimensionless)"} <= set(
            labels_of(region_figure(opened, found.region, [("merit", ">=", 0.9)]))
        )


def test_a_threshold_must_be_chosen_but_no_mode(
    file: Path, tmp_path: Path, refused: Callable[..., str]
) -> None:
    line = refused("optimum", file, "--where", "good_room>=1")
    assert line.startswith("--lci must be given: one of those in ")
    line = refused("plot", "quantity", "room", "--mode", "up", file, "-o", tmp_path / "a.pdf")
    assert "'up'" in line
    assert "only" in line


def test_it_has_modes_only_if_a_quantity_depends_on_them(modeless: str, toy: str) -> None:
    assert [mechanisms.get(name).has_modes for name in (modeless, toy, "five-bar")] == [
        False,
        True,
        True,
    ]
