"""``atlas design``: what it prints and writes, and what it refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Command

RUN = ("design", "--rectangle", "300x200", "--mode", "+-/up", "--count", "1", "-q")


def test_the_report_and_the_json_say_the_same(atlas: Command, tmp_path: Path) -> None:
    file = tmp_path / "machine.json"
    outcome = atlas(*RUN, "--link-range", "R3", "30", "inf", "-o", file)
    assert outcome.code == 0, outcome.err
    assert outcome.err == ""
    document = json.loads(file.read_text())
    (machine,) = document["machines"]
    assert document["minimised"] == "links"
    assert document["minimised_unit"] == "mm"
    assert machine["value"] == pytest.approx(2.0 * (machine["R1"] + machine["R2"]), rel=1e-12)
    assert machine["R3"] == pytest.approx(30.0, rel=1e-8)
    assert machine["margins"]["R3 least"] >= 0.0
    assert machine["shape"]["is_proved"]
    assert f"{machine['value']:.10g} mm" in outcome.out
    assert f"{machine['dimensional_factor']:.10g} mm" in outcome.out
    assert "machine 1 in full" in outcome.out
    assert ", ".join(machine["active"]) in outcome.out
    # the machine is what sizing the same design gives, for it is the smallest of its proportions
    lengths = [str(machine[name]) for name in ("R1", "R2", "R3")]
    sized = atlas("size", *lengths, "--rectangle", "300x200", "--json")
    factor = json.loads(sized.out)["dimensional_factor"]
    assert factor == pytest.approx(machine["dimensional_factor"], rel=1e-7)


def test_units_and_goals_are_those_given(atlas: Command) -> None:
    outcome = atlas(
        "design", "--circle", "10cm", "--minimise", "torque", "--force", "10", "--mode", "pm/up",
        "--count", "1", "--json", "-q",
    )  # fmt: skip
    document = json.loads(outcome.out)
    (machine,) = document["machines"]
    assert document["unit"] == "cm"
    assert document["minimised_unit"] == "N cm"
    assert machine["joint_torque"]["value"] == pytest.approx(machine["value"], rel=1e-9)


def test_a_report_of_a_design(atlas: Command, tmp_path: Path) -> None:
    page = tmp_path / "design.html"
    outcome = atlas("report", *RUN, "-o", page)
    assert outcome.code == 0, outcome.err
    text = page.read_text(encoding="utf-8")
    for words in ("Machines for a rectangle 300 x 200 mm", "active: ", "<svg"):
        assert words in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "give one of --rectangle, --circle, --polygon, not 0 of them"),
        (("--circle", "5", "--rectangle", "2x3"), "not 2 of them"),
        (("--rectangle", "300x-2"), "--rectangle: '300x-2'"),
        (("--circle", "5mm", "--clearance", "1cm"), "one unit for all lengths"),
        (("--circle", "5", "--lci", "1"), "--lci: 1.0"),
        (("--circle", "5", "--minimise", "mass"), "one of links, footprint, error, torque"),
        (("--circle", "5", "--mode", "updown"), "--mode: 'updown'"),
        (("--circle", "5", "--space", "outer"), "--space: 'outer'"),
        (("--circle", "5", "--count", "0"), "--count: 0"),
        (("--circle", "5", "--force", "-1"), "--force: -1.0"),
        (("--circle", "5", "--actuator-range", "1", "50", "20"), "a least angle below"),
        (("--circle", "5", "--actuator-range", "3", "0", "20"), "an actuator from 1 to 2"),
        (("--circle", "5", "--link-range", "R4", "0", "20"), "one of R1, R2, R3"),
        (("--circle", "5", "--link-range", "R1", "30", "20"), "a least length that is not above"),
        (("--polygon", "nowhere.csv"), "nowhere.csv"),
        (("--circle", "5", "-o", "machine.txt"), "ends in one of .json"),
    ],
)
def test_wrong_input_is_one_line(
    arguments: tuple[str, ...], message: str, refused: Callable[..., str], tmp_path: Path
) -> None:
    assert message in refused("design", *arguments, "-q")
    assert not any(tmp_path.iterdir())


def test_what_is_infeasible_is_explained(refused: Callable[..., str], tmp_path: Path) -> None:
    file = tmp_path / "machine.json"
    said = refused(
        "design", "--rectangle", "300x200", "--link-range", "R1", "0", "20", "-q", "-o", file,
        code=1,
    )  # fmt: skip
    assert "one is found without R1 from 0 to 20 mm (best with about R1 = " in said
    assert not file.exists()


def test_lengths_that_are_bought_are_kept(atlas: Command) -> None:
    outcome = atlas(
        "design", "--circle", "200", "--link-range", "R3", "150", "150", "--link-range", "R2",
        "400", "400", "--mode", "+-/up", "--count", "1", "--json", "-q",
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    (machine,) = json.loads(outcome.out)["machines"]
    assert machine["R2"] == pytest.approx(400.0, rel=1e-9)
    assert machine["R3"] == pytest.approx(150.0, rel=1e-9)
    # not worse than a machine of these lengths that is known to do
    assert machine["value"] <= 2.0 * (120.0 + 400.0)
    sized = atlas("size", "120", "400", "150", "--circle", "200", "--json")
    assert json.loads(sized.out)["dimensional_factor"] <= 670.0 / 3.0


@pytest.mark.parametrize(
    "arguments",
    [
        ("--rectangle", "300x200", "--lci", "0.2"),
        ("--circle", "150", "--actuator-range", "2", "170", "215", "--minimise", "footprint"),
    ],
)
def test_low_thresholds_and_ranges_across_half_a_turn(
    arguments: tuple[str, ...], atlas: Command
) -> None:
    outcome = atlas("design", *arguments, "--mode", "+-/up", "--count", "1", "--json", "-q")
    assert outcome.code == 0, outcome.err
    (machine,) = json.loads(outcome.out)["machines"]
    assert machine["shape"]["is_proved"]
    assert all(margin >= -1e-9 for margin in machine["margins"].values())


def test_an_output_is_not_replaced(refused: Callable[..., str], tmp_path: Path) -> None:
    file = tmp_path / "machine.json"
    file.write_text("kept")
    assert "--overwrite" in refused(*RUN, "-o", file)
    assert file.read_text() == "kept"
