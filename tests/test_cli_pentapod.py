"""What the commands say of a mechanism that does not move in a plane, in its own words."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import ROOT, Command
from report_page import read_page

CHOSEN = ("--mechanism", "pentapod")
DESIGN = (*CHOSEN, 500, 400, 100)
PLANAR = "a mechanism whose output point moves in a plane: five-bar, passive-leg"
COARSE = ("--resolution", 2, "--tolerance", 0.1, "-q")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from fivebar_atlas.cli import main

    path = tmp_path_factory.mktemp("pentapod") / "atlas.h5"
    levels = ("--lci", "0.005", "--lci", "0.02")
    arguments = ("sweep", *CHOSEN, *COARSE, *levels, "--set", "beta_max=10", "-o", path)
    main([str(argument) for argument in arguments], standalone_mode=False)
    return path


@pytest.mark.parametrize(
    ("command", "needed"),
    [
        (("plot", "loci", *DESIGN, "-o", "{}/a.png"), PLANAR),
        (("plot", "good-condition", *DESIGN, "-o", "{}/a.png"), PLANAR),
        (("plot", "lci", *DESIGN, "-o", "{}/a.png"), PLANAR),
        (("plot", "limits", *DESIGN, "-o", "{}/a.png"), PLANAR),
        (("plot", "loci-atlas", *CHOSEN, "-o", "{}/a.png"), PLANAR),
        (("plot", "shape-atlas", *CHOSEN, "-o", "{}/a.png"), PLANAR),
        (("geometry", "loci", *DESIGN, "-o", "{}/a.svg"), PLANAR),
        (("size", *DESIGN, "--area", "100mm2"), PLANAR),
        (("design", *CHOSEN, "--rectangle", "300x200"), PLANAR),
        (("animate", *DESIGN, "--inset", 3, "-o", "{}/a.gif"), PLANAR),
        (("report", "size", *DESIGN, "--area", "100mm2", "-o", "{}/a.html"), PLANAR),
        (("square", *CHOSEN), "an optimal configuration in closed form: five-bar"),
        (
            ("plot", "optimal-configuration", *CHOSEN, "--rho", 1.5, "-o", "{}/a.png"),
            "an optimal configuration in closed form: five-bar",
        ),
    ],
)
def test_planar_commands_say_what_they_need_and_who_has_it(
    command: tuple[object, ...], needed: str, refused: Callable[..., str], tmp_path: Path
) -> None:
    line = refused(*(str(each).replace("{}", str(tmp_path)) for each in command))
    assert line.startswith("mechanism: 'pentapod' is not allowed; expected a")
    assert line.endswith(needed)
    assert not list(tmp_path.iterdir())


def test_a_path_is_refused_as_well(refused: Callable[..., str], tmp_path: Path) -> None:
    points = tmp_path / "points.csv"
    points.write_text("x,y\n0,1\n")
    assert refused("path", *DESIGN, points).endswith(PLANAR)


@pytest.mark.parametrize(
    ("given", "line"),
    [
        (
            ("x_min=0.4", "x_max=0.1"),
            "--set x_min: 0.4 is not allowed; expected a number up to x_max, 0.1",
        ),
        (
            ("z_max=0.5",),
            "--set z_max: 0.5 is not allowed; expected a number of z_min, 0.85, or more",
        ),
        (("beta_min=30",), "--set beta_min: 30.0 is not allowed; expected a number up to beta_max"),
        (("beta_max=95",), "--set beta_max: 95.0 is not allowed; expected a number from -89 to 89"),
        (("xmin=0",), "--set xmin: 'xmin' is not allowed; expected one of x_min, "),
    ],
)
def test_ranges_in_wrong_order_are_named_by_what_was_given(
    given: tuple[str, ...], line: str, refused: Callable[..., str], tmp_path: Path
) -> None:
    options = [part for each in given for part in ("--set", each)]
    for command in (("sweep", *CHOSEN, "-o", tmp_path / "a.h5"), ("evaluate", *DESIGN)):
        assert refused(*command, *options).startswith(line)
    assert not list(tmp_path.iterdir())


def test_the_ends_of_a_range_may_come_from_file_and_command_line(
    atlas: Command, refused: Callable[..., str], tmp_path: Path
) -> None:
    configuration = tmp_path / "a.toml"
    configuration.write_text('mechanism = "pentapod"\n[sweep.options]\nx_min = 0.3\n')
    line = refused("config", "show", configuration)
    assert "x_min" in line
    assert "a.toml" in line
    shown = atlas("config", "show", configuration, "--set", "x_max=0.5").out
    assert "x_min = 0.3\nx_max = 0.5\n" in shown
    line = refused("config", "show", configuration, "--set", "x_max=0.2")
    assert line.startswith("sweep.options.x_min in ")
    assert line.endswith("a.toml: 0.3 is not allowed; expected a number up to x_max, 0.2")


def test_a_design_is_evaluated_in_the_unit_of_its_machine(atlas: Command) -> None:
    loose = ("--tolerance", 0.1, "--lci", 0.01)
    machine = json.loads(atlas("evaluate", *DESIGN, *loose, "--json").out)
    design = json.loads(atlas("evaluate", *CHOSEN, 1, 0.8, 0.2, *loose, "--json").out)
    assert machine["dimensional_factor"] == 500.0
    assert machine["workspace_volume"] == design["workspace_volume"]
    assert machine["dimensional"]["workspace_volume"] == pytest.approx(
        500.0**3 * design["workspace_volume"], rel=1e-12
    )
    assert machine["dimensional"]["r_b"] == pytest.approx(100.0)
    assert "mode" not in machine
    text = atlas("evaluate", *DESIGN, *loose, "--set", "beta_max=10").out
    assert "\nbeta_max = 10 deg, all other options by default\n" in text


def test_summary_and_table_of_a_file_name_no_mode(
    file: Path, atlas: Command, tmp_path: Path
) -> None:
    summary = atlas("info", file).out.split("made by")[0]
    assert "designs         9 of the radii design space, N = 2\n" in summary
    assert "options         beta_max = 10 deg, all other options by default\n" in summary
    assert "mode" not in summary
    table = tmp_path / "a.csv"
    assert atlas("export", file, "-o", table, "-q").code == 0
    with table.open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 9
    assert "good_condition_share_lci_threshold_0.02" in rows[0]
    for row in rows:
        shares = [float(row[f"good_condition_share_lci_threshold_{t}"]) for t in (0.005, 0.02)]
        assert float(row["usable_share"]) >= shares[0] >= shares[1] >= 0.0


def test_lookup_on_a_design_of_the_lattice_finds_what_is_stored(file: Path, atlas: Command) -> None:
    found = json.loads(atlas("lookup", 200, 220, 20, file, "--json").out)["values"]
    for entry in found:
        assert "mode" not in entry
        if isinstance(entry["exact"], float) and isinstance(entry["interpolated"], float):
            assert entry["exact"] == pytest.approx(entry["interpolated"], rel=1e-9)
    (volume,) = (entry for entry in found if entry["quantity"] == "workspace_volume")
    assert volume["scaled_exact"] == pytest.approx(200.0**3 * volume["exact"])


def test_conditions_and_region_are_on_share_and_gci(
    file: Path, atlas: Command, refused: Callable[..., str], tmp_path: Path
) -> None:
    figure = tmp_path / "region.svg"
    where = ("--where", "usable_share>=0.3", "--where", "gci>=0.005")
    outcome = atlas("plot", "region", file, *where, "-o", figure)
    assert "% of the design space" in outcome.out
    assert figure.exists()
    page = tmp_path / "region.html"
    assert atlas("report", "optimum", file, *where, "-o", page).code == 0
    text = read_page(page.read_text(encoding="utf-8")).text
    contours = "contours of the usable share of the pose box and of the global conditioning index"
    assert contours in text
    line = refused("plot", "area", file, "-o", tmp_path / "area.png")
    assert "is a quantity of five-bar, passive-leg; this file is of pentapod" in line
    assert "'atlas mechanisms pentapod' lists" in line
    assert len(line) < 300


def test_the_validation_page_has_the_values_of_the_designs_that_it_compares(atlas: Command) -> None:
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    table = page.split("## Is the geometry of the pentapod good?\n")[1].split("|---", 1)
    names = re.findall(r"`(\w+)`", table[0])
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in table[1].splitlines()[1:]
        if line.startswith("|")
    ]
    assert len(rows) == 6
    found = []
    for height, r_a, r_b, *printed in rows:
        outcome = atlas("evaluate", *CHOSEN, height, r_a, r_b, "--tolerance", 1e-3, "--json")
        values = json.loads(outcome.out)
        assert values["status"] == "singular_poses"
        for name, text in zip(names, printed, strict=True):
            half = 0.51 * 10.0 ** -len(text.partition(".")[2]) + values.get(f"{name}_error", 0.0)
            assert values[name] == pytest.approx(float(text), abs=half), (height, name)
        found.append([values[name] for name in names])
    # the others are better in all
    for paper, other in zip(found[:3], found[3:], strict=True):
        assert all(theirs > ours for ours, theirs in zip(paper[:3], other[:3], strict=True))
        assert other[3] < paper[3]


def test_an_atlas_without_values_has_no_optimum(tmp_path: Path, atlas: Command) -> None:
    # with A_2 at 90 degrees A_5 is in the place of A_1
    file = tmp_path / "degenerate.h5"
    options = ("--set", "base_angle=90", "--resolution", 2)
    assert atlas("sweep", *CHOSEN, *options, "-o", file).code == 0
    outcome = atlas("optimum", file, "--maximise", "gci")
    assert outcome.code == 1
    assert "no design of the file has a value of gci" in outcome.err


def test_a_front_that_nothing_is_on_is_polished_to_none(file: Path, atlas: Command) -> None:
    front = ("--pareto", "gci,usable_share", "--polish", "--where", "usable_share>=2")
    outcome = atlas("optimum", file, "--lci", 0.02, *front)
    assert outcome.code == 0
    assert "best values and where" in outcome.out
