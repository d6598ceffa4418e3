"""``atlas size``: what it prints and writes, and what it refuses."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Command

from fivebar_atlas import planar_design
from fivebar_atlas.synthesis.shapes import Shape
from fivebar_atlas.synthesis.sizing import size_for_shape

PAPER = ("size", "1.28", "1.72", "0")
SMALL = ("size", "26", "30", "16")


def value_of(out: str, label: str) -> str:
    return next(line for line in out.splitlines() if line.startswith(f"{label} "))[32:]


def test_the_example_of_the_paper(atlas: Command) -> None:
    outcome = atlas(*PAPER, "--area", "400", "--lci", "0.5")
    assert outcome.code == 0
    assert outcome.err == ""
    assert value_of(outcome.out, "dimensional factor D").startswith("4.497081029 mm")
    assert value_of(outcome.out, "R1") == "5.756263717 mm"
    assert value_of(outcome.out, "R2") == "7.73497937 mm"
    assert value_of(outcome.out, "R3") == "0 mm"
    assert value_of(outcome.out, "good_condition_workspace_area") == "400 mm²"
    assert value_of(outcome.out, "θ1") == "0 to 360 deg, full turns"
    assert "good-condition workspace of 400 mm²" in outcome.out


def test_the_command_for_the_lci_map_runs(atlas: Command, tmp_path: Path) -> None:
    outcome = atlas(*SMALL, "--rectangle", "300x200")
    line = next(line for line in outcome.out.splitlines() if line.startswith("Its LCI map: "))
    words = shlex.split(line.removeprefix("Its LCI map: "))
    assert words[:3] == ["atlas", "plot", "lci"]
    figure = tmp_path / "lci.svg"
    assert atlas(*words[1:-1], figure).code == 0
    assert figure.stat().st_size > 1000


def test_json_holds_what_python_finds(atlas: Command, tmp_path: Path) -> None:
    file = tmp_path / "machine.json"
    outcome = atlas(
        *SMALL, "--rectangle", "300x200mm", "--clearance", "10", "--encoder-resolution", "0.01",
        "--force", "10", "--json", "-o", file,
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    assert json.loads(file.read_text()) == document
    design = planar_design(26, 30, 16, unit="")
    machine = size_for_shape(design, Shape.rectangle(300.0, 200.0, 10.0), "+-/up")
    assert document["dimensional_factor"] == machine.factor
    assert document["R2"] == machine.lengths["R2"]
    assert document["shape"]["centre"] == pytest.approx(machine.position)
    assert document["shape"]["clearance"] == 10.0
    assert document["shape"]["is_proved"]
    error = machine.positioning_error(math.radians(0.01))
    assert document["positioning_error"]["value"] == error.value
    torque = machine.joint_torque(10.0)
    assert document["joint_torque"]["value"] == torque.value
    assert document["joint_torque"]["unit"] == "N mm"
    assert document["inputs"][0]["least_deg"] == math.degrees(machine.input_ranges[0].least)
    table = atlas(
        *SMALL, "--rectangle", "300x200", "--clearance", "10mm",
        "--encoder-resolution", "0.01", "--force", "10",
    )  # fmt: skip
    assert value_of(table.out, "positioning error").startswith(f"{error.value:.6g} mm at most")
    assert value_of(table.out, "joint torque").startswith(f"{torque.value:.6g} N mm at most")
    assert value_of(table.out, "containment").startswith("proved with")


def test_polygons_units_and_placements(atlas: Command, tmp_path: Path) -> None:
    file = tmp_path / "shape.wkt"
    file.write_text("POLYGON ((0 0, 30 0, 30 20, 0 20, 0 0))")
    table = tmp_path / "shape.csv"
    table.write_text("x_cm,y_cm\n0,0\n30,0\n30,20\n0,20\n")
    rectangle = ("--rectangle", "30x20", "--unit", "cm")
    first = json.loads(atlas(*SMALL, *rectangle, "--json").out)
    for shape in (
        ("--rectangle", "30cm x 20cm"),
        ("--polygon", file, "--clearance", "0cm"),
        ("--polygon", table, "--unit", "cm"),
        (*rectangle, "--free"),
        # in a very narrow window of sizes
        (*rectangle, "--offset", 0.0, first["shape"]["centre"][1] * (1.0 + 1e-7)),
    ):
        document = json.loads(atlas(*SMALL, *shape, "--json").out)
        assert document["unit"] == "cm"
        assert document["dimensional_factor"] == pytest.approx(
            first["dimensional_factor"], rel=2e-7
        )


def test_limits(atlas: Command, refused: Callable[..., str]) -> None:
    outcome = atlas(*SMALL, "--circle", "100", "--link-range", "r1", "400", "inf")
    assert value_of(outcome.out, "R1") == "400 mm"
    text = refused(*SMALL, "--circle", "100", "--link-range", "R1", "0", "50", code=1)
    assert "is above 50 mm; within them a workspace" in text
    text = refused(*SMALL, "--circle", "100", "--actuator-range", "1", "-20", "-10", code=1)
    assert "points on the y axis has θ1 from -20 to -10 deg; closest comes (0, " in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "give one of --area, --rectangle, --circle, --polygon, not 0"),
        (("--area", "4", "--circle", "2"), "not 2 of them"),
        (("--area", "-4"), "--area: '-4' is not allowed"),
        (("--area", "four"), "--area: 'four' is not allowed"),
        (("--area", "400", "--free"), "go with a shape"),
        (("--circle", "0"), "--circle: '0' is not allowed; expected a diameter above 0"),
        (("--circle", "-5"), "--circle"),
        (("--circle", "1e999"), "--circle"),
        (("--rectangle", "3"), "two lengths above 0"),
        (("--rectangle", "3x-2"), "two lengths above 0"),
        (("--rectangle", "3cmx2mm"), "one unit for all lengths, and --rectangle says cm"),
        (("--rectangle", "3x2cm", "--unit", "mm"), "--unit says mm"),
        (("--circle", "3cm", "--clearance", "2mm"), "one unit for all lengths"),
        (("--circle", "3", "--clearance", "-1"), "--clearance"),
        (("--circle", "3", "--free", "--offset", "1", "2"), "exclude each other"),
        (("--circle", "3", "--offset", "nan", "2"), "two finite lengths"),
        (("--circle", "3", "--lci", "1"), "--lci: 1.0 is not allowed"),
        (("--circle", "3", "--lci", "0"), "--lci: 0.0 is not allowed"),
        (("--circle", "3", "--mode", "up"), "mode: 'up' is not allowed"),
        (("--circle", "3", "--actuator-range", "1", "90", "-90"), "below the greatest"),
        (("--circle", "3", "--actuator-range", "4", "-90", "90"), "an actuator from 1 to 2"),
        (("--circle", "3", "--link-range", "R1", "9", "5"), "not above the greatest"),
        (("--circle", "3", "--link-range", "L", "1", "5"), "one of R1, R2, R3"),
        (("--circle", "3", "--force", "-1"), "--force: -1.0"),
        (("--circle", "3", "--encoder-resolution", "0"), "--encoder-resolution: 0.0"),
        (("--circle", "3", "--unit", ""), "--unit"),
        (("--polygon", "nowhere.csv"), "there is no such file"),
        (("--rectangle", "1e200x1e200"), "--rectangle: '1e200x1e200' is not allowed"),
        (("--rectangle", "1e-200x1e-200"), "lengths from 1e-100 to 1e+100"),
        (("--rectangle", "1e154x1e154"), "lengths from 1e-100 to 1e+100"),
        (("--rectangle", "1e-9x1e9"), "at most 1e+06 times as long as wide"),
        (("--circle", "1e200"), "--circle: '1e200' is not allowed; expected lengths from 1e-100"),
        (("--circle", "1e-200"), "lengths from 1e-100"),
        (("--circle", "3", "--clearance", "1e200"), "--clearance: '1e200' is not allowed"),
        (("--circle", "3", "--offset", "1e200", "1e200"), "--offset: '1e+200 1e+200'"),
        (("--circle", "3", "--offset", "nan", "50"), "--offset: 'nan 50' is not allowed"),
        (("--circle", "3", "--factor-step", "1e-300"), "--factor-step: '1e-300'"),
        (("--area", "5e-324"), "--area: '5e-324' is not allowed; expected an area from 1e-200"),
        (("--area", "1e201"), "--area: '1e201'"),
        (("--circle", "3", "--actuator-range", "1", "200", "-30"), "--actuator-range: '1 200 -30'"),
        (("--circle", "3", "--link-range", "R2", "9", "5"), "--link-range: 'R2 9 5' is not"),
        (("--circle", "3", "--link-range", "R1", "0", "0"), "and a greatest above 0"),
        (("--circle", "3", "--link-range", "L", "1", "5"), "--link-range: 'L' is not allowed"),
        (("--circle", "3", "--mode", "up"), "--mode: 'up' is not allowed"),
        (("--circle", "3", "--shape", "x"), "No such option"),
    ],
)
def test_wrong_input_is_refused(
    refused: Callable[..., str], arguments: tuple[str, ...], message: str
) -> None:
    assert message in refused(*SMALL, *arguments)


@pytest.mark.parametrize(
    ("shape", "text"),
    [
        (("--area", "400cm2"), "good-condition workspace of 400 cm²"),
        (("--area", "400 mm^2"), "good-condition workspace of 400 mm²"),
        (("--circle", "3 cm"), "circle of diameter 3 cm"),
    ],
)
def test_units_are_said_once(atlas: Command, shape: tuple[str, ...], text: str) -> None:
    outcome = atlas(*PAPER, *shape)
    assert value_of(outcome.out, "practical workspace") == text


def test_a_polygon_is_said_without_a_unit(atlas: Command, tmp_path: Path) -> None:
    file = tmp_path / "shape.wkt"
    file.write_text("POLYGON ((0 0, 30 0, 30 20, 0 20, 0 0))")
    outcome = atlas(*PAPER, "--polygon", file)
    assert value_of(outcome.out, "practical workspace") == "polygon of 4 corners"


def test_nothing_is_written_where_nothing_fits(
    refused: Callable[..., str], atlas: Command, tmp_path: Path
) -> None:
    file = tmp_path / "machine.json"
    text = refused(*SMALL, "--circle", "3", "--offset", "0", "0.1", "-o", file, code=1)
    assert "fits at no size with its centre at (0, 0.1); closest comes D =" in text
    assert not file.exists()
    assert atlas(*SMALL, "--circle", "3", "-o", file).code == 0
    before = file.read_bytes()
    assert "--overwrite" in refused(*SMALL, "--circle", "4", "-o", file)
    assert file.read_bytes() == before


def test_a_machine_is_written_to_json_and_never_over_its_polygon(
    refused: Callable[..., str], tmp_path: Path
) -> None:
    file = tmp_path / "shape.json"
    file.write_text("x,y\n0,0\n30,0\n30,20\n")
    arguments = (*SMALL, "--polygon", file, "--overwrite")
    assert "ends in one of .json" in refused(*arguments, "-o", tmp_path / "machine.csv")
    assert "is the input" in refused(*arguments, "-o", file)
    assert file.read_text().startswith("x,y")


def test_self_intersecting_and_empty_polygons_are_refused(
    refused: Callable[..., str], tmp_path: Path
) -> None:
    file = tmp_path / "shape.wkt"
    file.write_text("POLYGON ((0 0, 1 1, 1 0, 0 1, 0 0))")
    assert "does not meet itself" in refused(*SMALL, "--polygon", file)
    file.write_text("POLYGON EMPTY")
    assert "empty polygon" in refused(*SMALL, "--polygon", file)
