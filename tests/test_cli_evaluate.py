"""``atlas evaluate``: the values of single designs, their keys, and wrong lengths."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import Any

import pytest
from conftest import Command

from fivebar_atlas.cli.evaluation_text import _line

MODE_KEYS = {
    "working_mode",
    "assembly_mode",
    "usable_workspace_area",
    "usable_workspace_area_error",
    "gci",
    "gci_error",
    "max_lci",
    "max_lci_x",
    "max_lci_y",
    "good_condition",
    "mic_upper",
    "mic_lower",
    "status",
}


def document(atlas: Command, *arguments: object) -> dict[str, Any]:
    """Run the command for JSON, in which NaN and infinity must not occur."""
    outcome = atlas("evaluate", *arguments, "--json")
    assert outcome.code == 0, outcome
    assert outcome.err == ""

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    parsed: dict[str, Any] = json.loads(outcome.out, parse_constant=refuse)
    return parsed


def test_keys_are_those_promised(atlas: Command) -> None:
    found = document(atlas, 26, 30, 16, "--mode", "all", "--lci", 0.3, "--lci", 0.5)
    assert set(found) == {
        *("r1", "r2", "r3", "dimensional_factor", "sub_region"),
        *("theoretical_workspace_area", "theoretical_workspace_area_error"),
        *("modes", "dimensional"),
    }
    assert [f"{mode['working_mode']}/{mode['assembly_mode']}" for mode in found["modes"]] == [
        *("+-/up", "+-/down", "-+/up", "-+/down", "++/up", "++/down", "--/up", "--/down")
    ]
    for mode in found["modes"]:
        assert set(mode) == MODE_KEYS
        assert set(mode["mic_upper"]) == set(mode["mic_lower"]) == {"radius", "x", "y"}
        assert [entry["lci_threshold"] for entry in mode["good_condition"]] == [0.3, 0.5]
        for entry in mode["good_condition"]:
            assert set(entry) == {"lci_threshold", "area", "area_error", "gci", "gci_error"}


@pytest.mark.parametrize(
    ("design", "area", "gci", "good_area"),
    [
        ((1.28, 1.72, 0), math.pi * (9 - 0.44**2), 0.66976944, 19.77874),
        ((1.3, 1.6, 0.1), 24.858663, 0.6604264, 19.082389),
        ((1.08, 1.25, 0.67), 9.24141, 0.371362, 2.35743),
    ],
)
def test_known_designs(
    atlas: Command, design: tuple[float, float, float], area: float, gci: float, good_area: float
) -> None:
    """Every value stands under its own key; the last digits are for the tests of the kernels."""
    found = document(atlas, *design)
    (mode,) = found["modes"]
    assert found["dimensional_factor"] == 1.0
    assert (found["r1"], found["r2"], found["r3"]) == design
    assert mode["usable_workspace_area"] == pytest.approx(area, rel=1e-5)
    assert mode["gci"] == pytest.approx(gci, rel=1e-5)
    assert mode["good_condition"][0]["area"] == pytest.approx(good_area, rel=1e-5)
    assert mode["status"] == "ok"


def test_dimensional_lengths_scale_back(atlas: Command) -> None:
    found = document(atlas, 26, 30, 16)
    assert found["dimensional_factor"] == 24.0
    assert found["sub_region"] == "Va"
    machine = found["dimensional"]
    assert (machine["R1"], machine["R2"], machine["R3"]) == pytest.approx((26, 30, 16))
    assert machine["theoretical_workspace_area"] == pytest.approx(
        found["theoretical_workspace_area"] * 24**2
    )
    (mode,), (scaled,) = found["modes"], machine["modes"]
    for key in ("usable_workspace_area", "usable_workspace_area_error"):
        assert scaled[key] == pytest.approx(mode[key] * 24**2)
    assert scaled["max_lci_y"] == pytest.approx(mode["max_lci_y"] * 24)
    for key in ("radius", "x", "y"):
        assert scaled["mic_upper"][key] == pytest.approx(mode["mic_upper"][key] * 24)
    assert scaled["good_condition"][0]["area"] == pytest.approx(
        mode["good_condition"][0]["area"] * 24**2
    )
    assert "gci" not in scaled
    # The paper places the area of this machine between 9 and 10, its GCI near 0.4.
    assert 9.0 < mode["usable_workspace_area"] < 10.0


def test_long_numbers_of_the_table_stay_apart() -> None:
    words = _line("workspace_volume", "20.784546", "± 2.2e-02", "2.5980683e+09").split()
    assert words == ["workspace_volume", "20.784546", "±", "2.2e-02", "2.5980683e+09"]


def test_lengths_of_any_scale_are_the_same_design(atlas: Command) -> None:
    one = document(atlas, 26, 30, 16)
    other = document(atlas, 26e-3, 30e-3, 16e-3)
    assert other["modes"][0]["gci"] == pytest.approx(one["modes"][0]["gci"], rel=1e-12)


def test_what_does_not_exist_is_null(atlas: Command) -> None:
    """The modes with both elbows on one side are empty where the base joints coincide."""
    (mode,) = document(atlas, 1.28, 1.72, 0, "--mode", "++/up")["modes"]
    assert mode["usable_workspace_area"] == 0.0
    assert mode["gci"] is None
    assert mode["max_lci"] is None
    assert mode["mic_upper"] == {"radius": None, "x": None, "y": None}
    assert mode["good_condition"][0]["area"] == 0.0
    assert mode["good_condition"][0]["gci"] is None
    assert "empty_usable_workspace" in mode["status"]


def test_table_says_the_same(atlas: Command) -> None:
    (mode,) = document(atlas, 26, 30, 16)["modes"]
    outcome = atlas("evaluate", 26, 30, 16)
    assert outcome.code == 0
    assert max(len(line) for line in outcome.out.splitlines()) <= 80
    lines = {
        line.split("  ")[0]: re.findall(r"-?\d\S*", line[40:])
        for line in outcome.out.splitlines()
        if line
    }
    area, error, scaled = (float(text) for text in lines["usable_workspace_area"])
    assert area == pytest.approx(mode["usable_workspace_area"], rel=1e-7)
    assert error == pytest.approx(mode["usable_workspace_area_error"], rel=0.05)
    assert scaled == pytest.approx(mode["usable_workspace_area"] * 24**2, rel=1e-7)
    assert float(lines["gci"][0]) == pytest.approx(mode["gci"], rel=1e-7)
    assert float(lines["good_condition_gci at 0.5"][0]) == pytest.approx(
        mode["good_condition"][0]["gci"], rel=1e-7
    )
    assert [float(text) for text in lines["r1"]] == pytest.approx([26 / 24, 26])


def test_table_of_several_modes_names_them_and_what_is_missing(atlas: Command) -> None:
    outcome = atlas("evaluate", 1.28, 1.72, 0, "--mode", "+-/up", "--mode", "pp/up")
    sections = outcome.out.split("\n\n")
    assert [section.splitlines()[0] for section in sections[2:]] == ["+-/up", "++/up"]
    empty = sections[3]
    assert re.search(r"^gci +none$", empty, re.MULTILINE)
    assert "empty_usable_workspace" in empty
    assert "nan" not in outcome.out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1, 1, 1), "R1: -1.0 is not allowed; expected a finite length above 0"),
        ((1, -0.5, 1), "R2: -0.5 is not allowed"),
        ((1, 1, "-1e-3"), "R3: -0.001 is not allowed; expected a finite length of at least 0"),
        ((1, 1, "-inf"), "R3: -inf is not allowed"),
        ((0, 1, 1), "R1: 0.0 is not allowed"),
        ((1, 0, 1), "R2: 0.0 is not allowed"),
        (("nan", 1, 1), "R1: nan is not allowed"),
        ((1, "inf", 1), "R2: inf is not allowed"),
        ((1, 1, 2.5), "R3 at most R1 + R2"),
        ((1e200, 1e200, 1e200), "expected lengths with a mean from"),
        ((1, 1), "expected 3 numbers: r1 r2 r3"),
        ((), "expected 3 numbers"),
        ((1, 1, 1, 1), "expected 3 numbers"),
        (("one", 1, 1), "'one' is not a number"),
        ((1, 1, 1, "--jsn"), "No such option '--jsn'"),
        ((1, 1, 1, "--mode", "+/up"), "--mode: '+/up' is not allowed"),
        ((1, 1, 1, "--lci", -1), "--lci: -1.0 is not allowed"),
        ((1, 1, 1, "--lci", 0.5, "--lci", 0.5), "none is given twice"),
        ((1, 1, 1, "--tolerance", 1), "--tolerance: 1.0 is not allowed"),
        ((1, 1, 1, "--tolerance", "x"), "'x' is not a valid float"),
        ((1, 1, 1, "--mechanism", "hexapod"), "'hexapod' is not allowed; expected one of"),
    ],
)
def test_wrong_inputs_are_named(
    refused: Callable[..., str], arguments: tuple[object, ...], message: str
) -> None:
    assert message in refused("evaluate", *arguments)
