"""``atlas optimum``: what it prints and writes, and what it refuses."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import closed_form_atlas
import closed_form_mechanism
import numpy as np
import pytest
from conftest import Command

from fivebar_atlas.store import open_atlas

Refused = Callable[..., str]
CONDITIONS = ("--where", "usable_workspace_area>=24", "--where", "gci>=0.62")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a small atlas of the five-bar."""
    return closed_form_mechanism.write(
        tmp_path_factory.mktemp("cli_optimum") / "small.h5", "five-bar"
    )


@pytest.fixture
def several(tmp_path: Path) -> Path:
    """Return a file with two mode pairs and two thresholds."""
    return closed_form_atlas.write(tmp_path / "several.h5")


def read(outcome: Any) -> dict[str, Any]:
    assert outcome.code == 0, outcome.err
    document: dict[str, Any] = json.loads(outcome.out)
    return document


def test_the_region_has_what_its_conditions_ask_for(atlas: Command, file: Path) -> None:
    document = read(atlas("optimum", file, *CONDITIONS, "--json"))
    with open_atlas(file) as opened:
        designs = opened.designs
        inside = (opened.select("usable_workspace_area") >= 24) & (opened.select("gci") >= 0.62)
        best = designs[inside][opened.select("gci")[inside].argmax()]
    assert document["conditions"] == ["usable_workspace_area>=24", "gci>=0.62"]
    assert document["lattice_designs"] == np.count_nonzero(inside)
    assert document["mode"] == "+-/up"
    assert document["lci_threshold"] is None
    assert 0.017 < document["region"]["share"] < 0.019
    assert 1e-5 < document["region"]["interpolation_error"] < 1e-2
    for column, name in enumerate(("r1", "r2", "r3")):
        low, high = document["region"]["extent"][name]
        assert low <= designs[inside, column].min() + 1e-12
        assert high >= designs[inside, column].max() - 1e-12
    by_gci = [row for row in document["best"] if row["for"] == "gci"]
    assert list(by_gci[0]["design"].values()) == pytest.approx(best)
    assert all(error is not None for row in by_gci for error in row["errors"].values())


def test_a_refined_region_and_a_maximum(atlas: Command, file: Path) -> None:
    document = read(atlas("optimum", file, *CONDITIONS, "--refine", "--maximise", "gci", "--json"))
    refined, maximum = document["refined"], document["maximum"]
    assert refined["residual"] <= 1e-8
    assert refined["unmoved"] == 0
    # found with another lattice, five times as fine
    assert refined["extent"]["r1"] == pytest.approx([1.181492465, 1.430014023], abs=1e-8)
    assert refined["extent"]["r3"] == pytest.approx([0.0, 0.139076057], abs=1e-8)
    assert refined["share"] == pytest.approx(0.01801047, abs=refined["share_error"] + 1e-6)
    assert maximum["value"] == pytest.approx(0.67415286, abs=1e-8)
    assert maximum["value"] > maximum["lattice_value"]
    assert maximum["active"] == []
    assert maximum["errors"]["gci"] < 1e-8


def test_the_report_says_what_the_document_says(atlas: Command, file: Path) -> None:
    outcome = atlas("optimum", file, *CONDITIONS, "--refine", "--maximize", "gci")
    assert outcome.code == 0
    assert outcome.err == ""
    text = " ".join(outcome.out.split())
    assert "conditions usable_workspace_area>=24, gci>=0.62" in text
    assert "interpolation error" in text
    assert "1.181492465 1.430014023" in text
    assert "active no condition" in text


def test_the_empty_region_of_the_paper_says_why(atlas: Command, file: Path) -> None:
    wheres = ("--where", "usable_workspace_area>24", "--where", "gci>0.7")
    outcome = atlas("optimum", file, *wheres)
    assert outcome.code == 0
    assert "empty: no design has gci>0.7" in outcome.out
    assert "0.67415286 at r1 1.288" in outcome.out
    conflict = read(atlas("optimum", file, *wheres, "--json", "--maximise", "gci"))["conflict"]
    assert conflict["conditions"] == ["gci>0.7"]
    area, gci = conflict["reaches"]
    assert area["among"] is None
    assert area["alone"] == pytest.approx(9.0 * np.pi, rel=1e-9)
    assert gci["among"] == pytest.approx(0.67415286, abs=1e-8)


def test_conditions_that_exclude_each_other(atlas: Command, file: Path) -> None:
    wheres = ("--where", "usable_workspace_area>=28.2", "--where", "gci>=0.65")
    outcome = atlas("optimum", file, *wheres)
    assert "usable_workspace_area>=28.2, gci>=0.65 exclude each other" in outcome.out
    conflict = read(atlas("optimum", file, *wheres, "--json"))["conflict"]
    area, gci = conflict["reaches"]
    # on r3 = 0 the area is pi (9 - (r2 - r1)^2)
    design = area["among_design"]
    assert area["among"] == pytest.approx(np.pi * (9 - (design["r2"] - design["r1"]) ** 2))
    assert gci["among_design"]["r3"] == 0.0


def test_tables_are_written(atlas: Command, file: Path, tmp_path: Path) -> None:
    output = tmp_path / "inside.csv"
    document = read(atlas("optimum", file, *CONDITIONS, "--json", "-o", output))
    rows = list(csv.DictReader(output.read_text(encoding="utf-8").splitlines()))
    assert len(rows) == document["lattice_designs"]
    assert all(float(row["gci"]) >= 0.62 for row in rows)
    assert "usable_workspace_area_error" in rows[0]

    bare = tmp_path / "bare.csv"
    read(atlas("optimum", file, "--where", "r1>=2", "--maximise", "r3", "--json", "-o", bare))
    header, *rows = bare.read_text(encoding="utf-8").splitlines()
    assert header == "r1,r2,r3"
    assert rows
    assert all(float(row.split(",")[0]) >= 2.0 for row in rows)

    front = tmp_path / "front.csv"
    document = read(
        atlas("optimum", file, "--pareto", "usable_workspace_area,gci", "--json", "-o", front)
    )
    rows = list(csv.DictReader(front.read_text(encoding="utf-8").splitlines()))
    members = document["pareto"]["members"]
    assert [float(row["gci"]) for row in rows] == [m["values"]["gci"] for m in members]


def test_a_front_is_polished_on_request(atlas: Command, file: Path) -> None:
    arguments = ("optimum", file, *CONDITIONS, "--pareto", "usable_workspace_area,gci", "--json")
    plain, polished = read(atlas(*arguments)), read(atlas(*arguments, "--polish"))
    assert not plain["pareto"]["polished"]
    assert polished["pareto"]["polished"]
    assert plain["pareto"]["directions"] == {"usable_workspace_area": "large", "gci": "large"}
    for member in plain["pareto"]["members"]:
        assert any(
            other["values"]["gci"] >= member["values"]["gci"] - 1e-6
            and other["values"]["usable_workspace_area"]
            >= member["values"]["usable_workspace_area"] - 1e-6
            for other in polished["pareto"]["members"]
        )


def test_quantities_of_several_modes_and_thresholds_must_be_chosen(
    atlas: Command, refused: Refused, several: Path
) -> None:
    assert "--mode must be given" in refused("optimum", several, "--where", "gci>=0.5")
    where = ("--where", "good_condition_gci>=0.5", "--mode", "pp/up")
    assert "--lci must be given" in refused("optimum", several, *where)
    outcome = atlas("optimum", several, *where, "--lci", "0.3", "--json")
    assert read(outcome)["lci_threshold"] == 0.3
    assert read(outcome)["mode"] == "++/up"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--where", "gcii>=0.6"), "did you mean 'gci'"),
        (("--where", "gci=0.6"), "one of >= <= > <"),
        (("--where", "gci>0.7", "--where", "gci<0.6"), "contradict"),
        (("--maximise", "speed"), "one of r1, r2, r3"),
        (("--maximise", "gci:heavy"), "a finite number other than 0 as weight"),
        (("--pareto", "gci"), "at least two quantities"),
        (("--pareto", "gci,status"), "one of r1"),
        (("--polish",), "--polish needs --pareto"),
        (("--where", "gci_error<=1e-6", "--refine"), "error estimates belong to the file"),
        (("--best", "-1"), "at least 0"),
        (("--lci", "0.3"), "lci: 0.3 is not allowed; expected one of those in"),
        (("--lci", "1.3"), "lci: 1.3 is not allowed; expected a number above 0 and below 1"),
        (("--mode", "+-/down"), "mode: '+-/down' is not allowed; expected one of those in"),
    ],
)
def test_wrong_input_is_refused_and_nothing_written(
    refused: Refused, file: Path, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    output = tmp_path / "out.csv"
    assert message in refused("optimum", file, *arguments, "-o", output)
    assert not output.exists()


def test_an_existing_table_is_kept(refused: Refused, file: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.csv"
    output.write_text("mine", encoding="utf-8")
    assert "--overwrite" in refused("optimum", file, "-o", output)
    assert output.read_text(encoding="utf-8") == "mine"
    assert "there is no such file" in refused("optimum", tmp_path / "none.h5")


def test_an_atlas_is_never_replaced_by_a_table(
    refused: Refused, several: Path, tmp_path: Path
) -> None:
    before = several.read_bytes()
    where = ("--where", "r1>=1", "--overwrite")
    assert "ends in one of .csv" in refused("optimum", several, *where, "-o", several)
    assert "ends in one of .csv" in refused("optimum", several, *where, "-o", tmp_path / "out")
    disguised = tmp_path / "atlas.csv"
    disguised.symlink_to(several)
    for output in (disguised, tmp_path / "." / "atlas.csv"):
        assert "is the input" in refused("optimum", disguised, *where, "-o", output)
        assert "is the input" in refused("export", disguised, "--overwrite", "-o", output)
    picture = tmp_path / "atlas.svg"
    picture.symlink_to(several)
    for kind in (
        ("region", "--where", "r1>=1"),
        ("pareto", "--pareto", "r1,r2"),
        ("gci", "--mode", "pp/up"),
        ("design-space",),
    ):
        assert "is the input" in refused("plot", *kind, picture, "--overwrite", "-o", picture)
    assert several.read_bytes() == before


@pytest.mark.parametrize("kind", [("region",), ("pareto", "--pareto", "r1,gci")])
@pytest.mark.parametrize(
    ("wheres", "code", "message"),
    [
        (("gci>0.7", "gci<0.6"), 2, "contradict"),
        (("gci>0.7",), 1, "the region is empty: no design has gci>0.7"),
        (("usable_workspace_area>=28.2", "r1>=0.5", "gci>=0.65"), 1, "exclude each other"),
    ],
)
def test_nothing_is_drawn_of_no_design(
    refused: Refused,
    file: Path,
    tmp_path: Path,
    kind: tuple[str, ...],
    wheres: tuple[str, ...],
    code: int,
    message: str,
) -> None:
    output = tmp_path / "figure.svg"
    conditions = [word for where in wheres for word in ("--where", where)]
    assert message in refused("plot", *kind, file, *conditions, "-o", output, code=code)
    assert not output.exists()


def test_a_line_of_designs_is_no_region_but_has_a_maximum(atlas: Command, file: Path) -> None:
    document = read(atlas("optimum", file, "--where", "r3<=0", "--maximise", "gci", "--json"))
    assert document["region"]["is_empty"]
    assert document["conflict"] is None
    assert document["maximum"]["value"] == pytest.approx(0.67120723, abs=1e-8)
    assert document["maximum"]["borders"] == ["r3 = 0"]
    outcome = atlas("optimum", file, "--where", "r3<=0", "--refine")
    assert "none between these designs" in outcome.out


def test_searches_next_to_what_is_no_design_say_so(atlas: Command, file: Path) -> None:
    for objective in ("-gci", "gci:-1", "max_lci:-1", "r1"):
        outcome = atlas("optimum", file, f"--maximise={objective}")
        assert outcome.code == 0
        assert "the best design evaluated; better ones are closer to the border" in outcome.out
    maximum = read(atlas("optimum", file, "--maximise=r1", "--json"))["maximum"]
    assert not maximum["is_attained"]
    assert 2.9999 < maximum["design"]["r1"] < 3.0
    outcome = atlas("optimum", file, "--where", "gci<0")
    assert outcome.out.count(", the best design evaluated\n") == 2
    (reach,) = read(atlas("optimum", file, "--where", "gci<0", "--json"))["conflict"]["reaches"]
    assert 0.0 < reach["alone"] < 1e-5
    assert not reach["alone_is_attained"]


def test_an_error_estimate_may_bound_a_region(atlas: Command, file: Path) -> None:
    outcome = atlas("optimum", file, "--where", "gci_error<=1e-7")
    assert outcome.code == 0
    assert "unknown: error estimates have no exact values" in outcome.out
