"""``atlas square``: what it prints and writes, and what it refuses."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Command

LARGEST, AT = 1.3322459135, 1.5260005739


def test_the_example_of_the_paper(atlas: Command) -> None:
    outcome = atlas("square", "-q")
    assert outcome.code == 0, outcome.err
    assert "not reproduced: there are larger squares at smaller ratios" in outcome.out
    document = json.loads(atlas("square", "-q", "--json").out)
    assert [piece["active"] for piece in document["pieces"]] == [
        ["LCI at the lower side"],
        ["LCI at the upper corners"],
        ["LCI at the lower corners"],
    ]
    assert document["pieces"][0]["to"] == pytest.approx(AT, abs=1e-9)
    assert document["largest"]["side"] == pytest.approx(LARGEST, abs=1e-9)
    assert document["largest"]["ratio"] == pytest.approx(AT, abs=1e-6)
    assert document["largest"]["is_kink"]
    assert document["largest"]["is_proved"]
    assert document["largest"]["active"] == ["LCI at the upper corners", "LCI at the lower side"]
    assert 0.5 - 1e-9 <= document["largest"]["least_lci_bound"] <= 0.5 + 1e-8
    assert document["printed"] == {
        "ratio": 1.9721,
        "side": 1.3142,
        "own_side_at_that_ratio": pytest.approx(1.3126667, abs=1e-7),
        "is_reproduced": False,
    }
    assert len(document["ratios"]) == len(document["sides"]) == 57


def test_the_ranges_of_the_paper_are_not_active_and_others_are(atlas: Command) -> None:
    ranges = ("--actuator-range", "1", "-60", "240", "--actuator-range", "2", "-60", "240")
    document = json.loads(atlas("square", "--rho", "1.4:2:0.1", *ranges, "-q", "--json").out)
    assert document["largest"]["side"] == pytest.approx(LARGEST, abs=1e-9)
    assert document["printed"] is not None
    narrow = ("--actuator-range", "1", "60", "170", "--actuator-range", "2", "10", "120")
    document = json.loads(atlas("square", "--rho", "1.4:2:0.1", *narrow, "-q", "--json").out)
    assert document["largest"]["side"] < LARGEST
    assert document["printed"] is None
    assert any("θ" in name for piece in document["pieces"] for name in piece["active"])


def test_one_machine_has_lengths_in_its_unit(atlas: Command) -> None:
    plain = json.loads(atlas("square", "--rho", "1.6", "--json").out)
    sized = json.loads(atlas("square", "--rho", "1.6", "--l1", "250mm", "--json").out)
    assert plain["side"] == pytest.approx(1.3293069197, abs=1e-9)
    assert sized["side"] == pytest.approx(250.0 * plain["side"], rel=1e-14)
    assert sized["unit"] == "mm"
    assert sized["l0"] == pytest.approx(250.0 * 0.6 / 2.0**0.5, rel=1e-12)
    given = ("--lengths", "250", "400", str(sized["l0"]))
    assert json.loads(atlas("square", *given, "--json").out)["side"] == pytest.approx(
        plain["side"], rel=1e-9
    )
    wide = json.loads(atlas("square", "--rho", "1.6", "--aspect", "3:2", "--json").out)
    assert wide["width"] == pytest.approx(1.5 * wide["height"], rel=1e-12)
    assert wide["active"] == ["maximal inscribed circle"]
    assert (0.5 * wide["width"]) ** 2 + (0.5 * wide["height"]) ** 2 == pytest.approx(1.0, rel=1e-9)


def test_the_table_holds_the_curve(atlas: Command, tmp_path: Path) -> None:
    file = tmp_path / "curve.csv"
    outcome = atlas("square", "--rho", "1.4:2:0.2", "-o", file, "--l1", "2mm", "-q", "--json")
    document = json.loads(outcome.out)
    with file.open(encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    assert head == ["ratio", "side_mm", "centre_y_mm", "active"]
    assert [float(row[0]) for row in rows] == document["ratios"] == [1.4, 1.6, 1.8, 2.0]
    assert [float(row[1]) for row in rows] == document["sides"]


@pytest.mark.slow
def test_freedom_gains_what_it_gains(atlas: Command) -> None:
    document = json.loads(atlas("square", "--rho", "1.4:1.8:0.2", "--gains", "-q", "--json").out)
    gains = {gain["free"]: gain for gain in document["gains"]}
    assert all(gain["gain"] >= 0.0 for gain in gains.values())
    centre = gains["centre free on the y axis"]
    assert centre["side"] == pytest.approx(1.3518666, abs=1e-6)
    assert centre["ratio"] == pytest.approx(1.62837, abs=1e-4)
    assert centre["l0"] == pytest.approx((centre["l2"] - 1.0) / 2.0**0.5, abs=1e-9)
    both = gains["l0 free and centre free"]
    assert gains["l0, centre and mode pair free"]["side"] >= both["side"] * (1.0 - 1e-7)
    assert both["side"] == pytest.approx(1.5726616, abs=1e-6)
    assert all(gain["is_proved"] for gain in gains.values())


def test_a_report_of_the_curve(atlas: Command, tmp_path: Path) -> None:
    page = tmp_path / "square.html"
    outcome = atlas("report", "square", "--rho", "1.4:2:0.2", "-q", "-o", page)
    assert outcome.code == 0, outcome.err
    text = page.read_text(encoding="utf-8")
    assert text.count("<svg") == 3
    assert "not reproduced" in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--rho", "0.8"), "--rho: 0.8"),
        (("--rho", "0.9:2:0.1"), "at least 1"),
        (("--rho", "2:1.5:0.1"), "below the greatest"),
        (("--rho", "1.2:4:0"), "above 0"),
        (("--rho", "1.2:4"), "--rho: '1.2:4'"),
        (("--rho", "wide"), "--rho: 'wide'"),
        (("--rho", "1.6", "--lengths", "1", "2", "0.5"), "give either --rho or --lengths"),
        (("--rho", "1.6", "--gains"), "--gains goes with a range of ratios"),
        (("--gains", "--centre", "axis"), "--gains are measured from --centre mic"),
        (("--rho", "1.6", "-o", "curve.csv"), "goes with a range of ratios"),
        (("--lci", "1.5"), "--lci: 1.5"),
        (("--l1", "-3mm"), "--l1: '-3mm'"),
        (("--aspect", "2"), "--aspect: '2'"),
        (("--aspect", "1:1e300"), "neither more than 1000 times the other"),
        (("--rho", "1e300"), "--rho: 1e+300"),
        (("--centre", "middle"), "--centre: 'middle'"),
        (("--half", "left"), "--half: 'left'"),
        (("--mode", "updown"), "'updown'"),
        (("--actuator-range", "3", "0", "90"), "an actuator from 1 to 2"),
        (("-o", "square.txt"), "ends in one of .json, .csv"),
    ],
)
def test_wrong_input_is_one_line(
    arguments: tuple[str, ...], message: str, refused: Callable[..., str]
) -> None:
    assert message in refused("square", *arguments, "-q")


def test_ranges_that_exclude_the_optimal_configuration_are_named(
    refused: Callable[..., str],
) -> None:
    said = refused("square", "--rho", "1.6", "--actuator-range", "1", "0", "90", code=1)
    assert "limits exclude the optimal configuration" in said
    assert "θ1 = 135 deg and θ1 from 0 to 90 deg" in said


def test_no_square_says_what_to_relax(refused: Callable[..., str]) -> None:
    said = refused("square", "--lengths", "1", "1.6", "0.42", "--lci", "0.99", code=1)
    assert "0.99 is asked for" in said


def test_an_output_is_not_replaced(refused: Callable[..., str], tmp_path: Path) -> None:
    file = tmp_path / "square.json"
    file.write_text("kept")
    assert "--overwrite" in refused("square", "-o", file, "-q")
    assert file.read_text() == "kept"
