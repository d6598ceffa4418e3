"""``atlas config show``."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import ROOT, Command


def test_defaults_are_shown(atlas: Command) -> None:
    outcome = atlas("config", "show")
    assert outcome.code == 0
    assert tomllib.loads(outcome.out) == {
        "mechanism": "five-bar",
        "sweep": {
            "resolution": 300,
            "space": "surrounded",
            "mode": ["+-/up"],
            "lci": [0.5],
            "tolerance": 1e-6,
        },
        "run": {},
    }


def test_file_and_command_line_are_merged(atlas: Command) -> None:
    outcome = atlas(
        "config",
        "show",
        ROOT / "configs" / "eight-modes.toml",
        *("--resolution", 20),
        *("--mode", "pm/up", "--mode", "mm/down"),
        *("--lci", "0.4"),
        *("--threads", 2),
        *("-o", "x.h5"),
    )
    shown = tomllib.loads(outcome.out)
    assert shown["sweep"]["resolution"] == 20
    assert shown["sweep"]["mode"] == ["+-/up", "--/down"]
    assert shown["sweep"]["lci"] == [0.4]
    assert shown["sweep"]["tolerance"] == 1e-6
    assert shown["run"] == {"threads": 2, "output": "x.h5"}


def test_all_modes_are_spelled_out(atlas: Command) -> None:
    shown = tomllib.loads(atlas("config", "show", "--mode", "all").out)
    assert len(shown["sweep"]["mode"]) == 8


def test_what_is_shown_can_be_swept_again(atlas: Command, tmp_path: Path) -> None:
    first = atlas("config", "show", "--resolution", 77, "--tolerance", 2e-7, "--threads", 3).out
    path = tmp_path / "shown.toml"
    path.write_text(first, encoding="utf-8")
    assert atlas("config", "show", path).out == first


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("missing.toml",), "missing.toml: there is no such file"),
        (("--mode", "up"), "--mode: 'up' is not allowed; expected one of +-/up"),
        (("--space", "surounded"), "did you mean 'surrounded'?"),
        (("--resolution", -1), "--resolution: -1 is not allowed; expected an integer from 3"),
        (("--tolerance", "nan"), "--tolerance: nan is not allowed; expected a number from 1e-10"),
        (("--lci", -0.5), "--lci: -0.5 is not allowed"),
        (("--lci", 0.5, "--lci", 0.5), "none is given twice"),
        (("--threads", 0), "--threads: 0 is not allowed; expected an integer from 1"),
        (("--mechanism", "fivebar"), "did you mean 'five-bar'?"),
    ],
)
def test_wrong_values_are_named(
    refused: Callable[..., str], arguments: tuple[object, ...], message: str
) -> None:
    assert message in refused("config", "show", *arguments)
