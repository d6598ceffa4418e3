"""A machine may have more lengths than a design has parameters, with names and scale of its own."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Command

from fivebar_atlas import FiveBar, mechanisms
from fivebar_atlas.checked_paths import CheckedPath
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.five_bar.mechanism import FiveBarMechanism
from fivebar_atlas.mechanisms.scaled_design import ScaledDesign
from fivebar_atlas.synthesis.containment import ActuatorRange
from fivebar_atlas.synthesis.link_limits import LinkLimit, check_limits, length_name


class ForeignDesign(FiveBar):
    """A five-bar that says it has the lengths of the sliced mechanism."""

    @property
    def mechanism(self) -> str:
        """Another than its own."""
        return "sliced"

    @property
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Lengths of the other."""
        return (("$A$", 1.0), ("$a$", 0.5), ("$b$", 0.25), ("$c$", 2.0))


def test_lengths_of_a_five_bar_are_its_parameters_in_capital_letters() -> None:
    five_bar = FiveBarMechanism()
    assert [each.name for each in five_bar.proportions] == ["r1", "r2", "r3"]
    assert [each.name for each in five_bar.lengths] == ["R1", "R2", "R3"]
    assert [each.symbol for each in five_bar.lengths] == ["$R_1$", "$R_2$", "$R_3$"]
    designs = five_bar.lattice("surrounded", 9)
    np.testing.assert_array_equal(five_bar.proportions_of(designs), designs)


@pytest.mark.parametrize("name", ["five-bar", "sliced"])
def test_lengths_of_a_design_lead_back_to_it(sliced: str, name: str) -> None:  # noqa: ARG001
    mechanism = mechanisms.get(name)
    for design in mechanism.lattice(mechanism.spaces[0], 7):
        (proportions,) = mechanism.proportions_of(design[None])
        assert len(proportions) == len(mechanism.lengths) == len(mechanism.proportions)
        parameters, factor = mechanism.from_lengths(20.0 * proportions)
        np.testing.assert_allclose(parameters, design, rtol=1e-14, atol=1e-15)
        assert factor == pytest.approx(20.0, rel=1e-14)


def test_symbols_of_a_machine_are_those_of_its_mechanism(sliced: str) -> None:  # noqa: ARG001
    design = ForeignDesign(1.0, 1.2, 0.8)
    machine = ScaledDesign(design, 20.0, "mm")
    assert machine.parameters == (("$A$", 20.0), ("$a$", 10.0), ("$b$", 5.0), ("$c$", 40.0))
    assert machine.named_lengths == {"A": 20.0, "a": 10.0, "b": 5.0, "c": 40.0}
    assert design.named_lengths == {"A": 1.0, "a": 0.5, "b": 0.25, "c": 2.0}
    # symbols of links that are no lengths of the mechanism stay as they are
    links = machine.pose(0.0, 20.0, "+-/up").links
    assert {link.symbol for link in links} == {"$r_1$", "$r_2$", "$r_3$"}
    own = ScaledDesign(FiveBar(1.0, 1.2, 0.8), 20.0, "mm")
    assert own.named_lengths == pytest.approx({"R1": 20.0, "R2": 24.0, "R3": 16.0})
    links = own.pose(0.0, 20.0, "+-/up").links
    assert {link.symbol for link in links} == {"$R_1$", "$R_2$", "$R_3$"}


def test_inputs_are_written_with_the_letters_of_the_mechanism(sliced: str) -> None:
    assert [mechanisms.get("five-bar").input_text(number) for number in (1, 2)] == ["θ1", "θ2"]
    assert [mechanisms.get("passive-leg").input_text(number) for number in (1, 2)] == ["φ1", "φ2"]
    assert [mechanisms.get(sliced).input_text(number) for number in (1, 2)] == ["q1", "φ2"]
    limit = ActuatorRange(2, 0.0, math.radians(45.0))
    assert limit.text(mechanisms.get(sliced)) == "φ2 from 0 to 45 deg"


def test_a_path_is_reported_with_the_inputs_of_its_mechanism(sliced: str, tmp_path: Path) -> None:  # noqa: ARG001
    design = ForeignDesign(1.0, 1.2, 0.8)
    checked = CheckedPath.of(design, np.array([[0.0, 1.0], [0.1, 1.0]]), "+-/up", close=False)
    assert checked.input_texts == ("q1", "φ2")
    checked.write_csv(tmp_path / "path.csv", False)
    header = (tmp_path / "path.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    assert header[4:6] == ["q1_deg", "phi2_deg"]


def test_names_of_lengths_are_read_in_other_letters_only_where_that_is_clear() -> None:
    names = ("R", "r", "l_a", "l_b")
    assert [length_name(name, names) for name in ("R", "r", "L_A", "l_b")] == list(names)
    assert length_name("r2", ("R1", "R2")) == "R2"
    with pytest.raises(UnknownNameError, match=r"^link limit: 'r3' .* one of R1, R2"):
        length_name("r3", ("R1", "R2"))
    with pytest.raises(UnknownNameError):
        length_name("ABC", ("Abc", "aBC"))


def test_limits_tell_lengths_apart_that_differ_in_case() -> None:
    lengths = {"A": 1.0, "a": 0.0}
    check_limits(lengths, [LinkLimit("A", 1.0, 2.0)])
    with pytest.raises(InputError, match="a is 0 at every size"):
        check_limits(lengths, [LinkLimit("a", 1.0, 2.0)])


def test_one_design_is_given_and_shown_by_its_lengths(sliced: str, atlas: Command) -> None:
    command = ("evaluate", 20, 10, 5, 4, "--mechanism", sliced)
    document = json.loads(atlas(*command, "--json").out)
    assert (document["a"], document["b"], document["c"]) == (0.5, 0.25, 0.2)
    assert document["dimensional_factor"] == 20.0
    assert document["dimensional"] == {
        **{"A": 20.0, "a": 10.0, "b": 5.0, "c": 4.0},
        "stretch": [pytest.approx(20.0 * (0.5 + 0.0625 + 0.6))],
    }
    rows = [line.split() for line in atlas(*command).out.splitlines()]
    assert ["A", "1", "20"] in rows
    assert ["a", "0.5", "10"] in rows


def test_reports_name_lengths_and_scale_as_the_mechanism_does(
    sliced: str, atlas: Command, tmp_path: Path
) -> None:
    page = tmp_path / "page.html"
    options = ("--mechanism", sliced, "--set", "gain=2", "-o", page)
    outcome = atlas("report", "evaluate", 20, 10, 5, 4, *options)
    assert outcome.code == 0, outcome.err
    text = page.read_text(encoding="utf-8")
    assert "Design A = 20, a = 10, b = 5, c = 4" in text
    assert "A a b c" in text
    assert "scaled to A = 1" in text
    assert "gain=2" in text
    assert "How much all is stretched" in text
    assert "2 deg" in text
    assert "r1" not in text


def test_the_wrong_number_of_lengths_is_told_by_their_names(
    sliced: str, refused: Callable[..., str]
) -> None:
    line = refused("evaluate", 20, 10, 5, "--mechanism", sliced)
    assert line.endswith("expected 4 numbers: A a b c")


def test_mechanisms_are_listed_with_lengths_and_everything_else(
    sliced: str, atlas: Command, refused: Callable[..., str]
) -> None:
    listed = atlas("mechanisms").out
    assert "R1 R2 R3, D = (R1 + R2 + R3)/3\n" in listed
    assert "A a b c, D = A\n" in listed
    document = json.loads(atlas("mechanisms", sliced, "--json").out)
    assert document["lengths"] == {
        "A": "frame",
        "a": "first link",
        "b": "second link",
        "c": "third link",
    }
    assert list(document["parameters"]) == ["a", "b", "c"]
    assert [each["name"] for each in document["options"]] == ["gain", "is_mirrored"]
    assert [each["name"] for each in document["quantities"]] == ["stretch"]
    shown = atlas("mechanisms", sliced).out
    assert (
        "  gain: how much all is stretched; a number from 0.5 to 8 deg, 1.0 if not given" in shown
    )
    documents = json.loads(atlas("mechanisms", "--json").out)
    assert [each["mechanism"] for each in documents] == list(mechanisms.names())
    assert documents[0]["spaces"] == ["surrounded", "assemblable"]
    assert "did you mean 'sliced'" in refused("mechanisms", "slice")


def test_help_says_where_lengths_are_listed_and_names_those_of_no_mechanism(atlas: Command) -> None:
    for command in (("evaluate",), ("size",), ("geometry",), ("plot", "lci"), ("animate",)):
        text = " ".join(atlas(*command, "--help").out.split())
        assert "LENGTHS..." in text
        assert "'atlas mechanisms' lists them" in text
        assert "R1" not in text
