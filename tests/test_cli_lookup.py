"""``atlas lookup``: what it prints, and what it refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import closed_form_mechanism
import pytest
from conftest import Command

from fivebar_atlas import FiveBar


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a small atlas of the five-bar."""
    return closed_form_mechanism.write(
        tmp_path_factory.mktemp("cli_lookup") / "small.h5", "five-bar"
    )


def test_the_table_has_interpolated_exact_and_scaled_values(atlas: Command, file: Path) -> None:
    outcome = atlas("lookup", "26", "30", "16", file)
    assert outcome.code == 0
    assert outcome.err == ""
    rows = {line.split()[0]: line.split()[1:] for line in outcome.out.splitlines() if line}
    assert rows["r1"] == ["1.0833333", "26"]
    assert rows["sub_region"] == ["Va"]
    interpolated, exact, error, difference, scaled, scaled_exact = (
        float(cell) for cell in rows["usable_workspace_area"]
    )
    assert exact == 9.3252745
    assert error < 1e-6
    assert difference == pytest.approx(interpolated - exact, rel=0.06, abs=1e-7)
    assert scaled == pytest.approx(576.0 * interpolated, rel=1e-7)
    assert scaled_exact == pytest.approx(5371.3581, abs=1e-3)
    assert len(rows["gci"]) == 4


def test_the_document_is_that_of_the_design(atlas: Command, file: Path) -> None:
    outcome = atlas("lookup", "26", "30", "16", file, "--json")
    document = json.loads(outcome.out)
    assert document["dimensional_factor"] == 24.0
    assert document["lengths"] == pytest.approx({"r1": 26.0, "r2": 30.0, "r3": 16.0})
    by_name = {value["quantity"]: value for value in document["values"]}
    expected = FiveBar.from_lengths(26, 30, 16).evaluate("+-/up")
    gci = by_name["gci"]
    assert gci["mode"] == "+-/up"
    assert gci["exact"] == pytest.approx(expected["gci"], rel=1e-12)
    assert gci["interpolation_error"] == gci["interpolated"] - gci["exact"]
    assert gci["scaled_exact"] is None
    assert by_name["good_condition_gci"]["threshold"] == "0.5"


def test_non_dimensional_lengths_are_not_scaled(atlas: Command, file: Path) -> None:
    outcome = atlas("lookup", "1.3", "1.6", "0.1", file)
    assert "scaled" not in outcome.out


@pytest.mark.parametrize(
    ("lengths", "message"),
    [
        (("1", "1", "1.1"), "beyond"),
        (("1", "2"), "3 numbers"),
        (("-1", "2", "1"), "above 0"),
        (("1", "x", "1"), "not a number"),
        (("1", "--deep", "1"), "No such option"),
    ],
)
def test_wrong_input_is_refused(
    refused: Callable[..., str], file: Path, lengths: tuple[str, ...], message: str
) -> None:
    assert message in refused("lookup", *lengths, file)


def test_a_missing_file_is_refused(refused: Callable[..., str], tmp_path: Path) -> None:
    assert "there is no such file" in refused("lookup", "1", "1", "1", tmp_path / "none.h5")
    assert "Missing argument" in refused("lookup")
