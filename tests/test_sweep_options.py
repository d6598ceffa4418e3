"""What a mechanism leaves to a sweep to choose: from table and command line to file and numbers."""

from __future__ import annotations

import dataclasses
import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Command

from fivebar_atlas import config, mechanisms, planar_design
from fivebar_atlas.config import Overrides
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.settings import SweepOption
from fivebar_atlas.store import is_complete, open_atlas

TEXT = """mechanism = "sliced"
[sweep]
resolution = 4
[sweep.options]
gain = 3
"""


@pytest.fixture
def path(sliced: str, tmp_path: Path) -> Path:  # noqa: ARG001
    path = tmp_path / "sliced.toml"
    path.write_text(TEXT)
    return path


def test_options_of_file_and_command_line_and_defaults_are_merged(path: Path) -> None:
    assert config.resolve(path).settings.options == (("gain", 3.0), ("is_mirrored", False))
    both = Overrides(options={"is_mirrored": True, "gain": 4})
    assert config.resolve(path, both).settings.options == (("gain", 4.0), ("is_mirrored", True))
    one = Overrides(options={"is_mirrored": True})
    assert config.resolve(path, one).settings.options == (("gain", 3.0), ("is_mirrored", True))
    none = Overrides("sliced")
    assert config.resolve(None, none).settings.options == (("gain", 1.0), ("is_mirrored", False))


def test_the_default_on_the_command_line_wins_over_the_file(path: Path) -> None:
    assert dict(config.resolve(path, Overrides(options={"gain": 1.0})).settings.options) == {
        "gain": 1.0,
        "is_mirrored": False,
    }


def test_stored_text_has_all_options_and_reads_back(path: Path) -> None:
    settings = config.resolve(path, Overrides(options={"gain": 0.1 + 0.7})).settings
    text = config.render_settings(settings)
    assert tomllib.loads(text)["sweep"]["options"] == {"gain": 0.1 + 0.7, "is_mirrored": False}
    assert config.settings_from_text(text, "stored") == settings
    shown = config.render(config.Configuration(settings, 3))
    assert tomllib.loads(shown)["run"] == {"threads": 3}


def test_options_left_out_are_those_that_a_file_without_them_has(path: Path) -> None:
    settings = config.resolve(path, Overrides(options={"gain": 1})).settings
    bare = dataclasses.replace(settings, options=())
    assert config.render_settings(bare) == config.render_settings(settings)
    old = config.render_settings(settings).partition("[sweep.options]")[0]
    assert config.settings_from_text(old, "old") == settings


def test_a_mechanism_without_options_has_no_table() -> None:
    assert config.render_settings(config.resolve().settings) == (
        'mechanism = "five-bar"\n\n[sweep]\nresolution = 300\nspace = "surrounded"\n'
        'mode = ["+-/up"]\nlci = [0.5]\ntolerance = 1e-06\n'
    )


@pytest.mark.parametrize(
    ("table", "name", "allowed"),
    [
        ("gain = 9", "sweep.options.gain", "a number from 0.5 to 8 deg"),
        ("gain = '2'", "sweep.options.gain", "a number from 0.5 to 8 deg"),
        ("gain = true", "sweep.options.gain", "a number from 0.5 to 8 deg"),
        ("gain = nan", "sweep.options.gain", "a number from 0.5 to 8 deg"),
        ("is_mirrored = 1", "sweep.options.is_mirrored", "true or false"),
        ("gian = 2", "sweep.options.gian", "did you mean 'gain'"),
    ],
)
def test_wrong_values_in_a_file_are_named(path: Path, table: str, name: str, allowed: str) -> None:
    path.write_text(TEXT.replace("gain = 3", table))
    with pytest.raises(InputError) as caught:
        config.resolve(path)
    assert caught.value.name == f"{name} in {path}"
    assert allowed in str(caught.value)


def test_options_are_a_table(path: Path) -> None:
    path.write_text('mechanism = "sliced"\n[sweep]\noptions = 3\n')
    with pytest.raises(InputError, match=r"^sweep\.options in .* expected a table"):
        config.resolve(path)


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (("gain=9",), "--set gain: 9.0 is not allowed; expected a number from 0.5 to 8 deg"),
        (("gain=true",), "--set gain: True is not allowed; expected a number from 0.5 to 8 deg"),
        (("gain=x",), "--set gain: 'x' is not allowed; expected a number from 0.5 to 8 deg"),
        (("is_mirrored=yes",), "--set is_mirrored: 'yes' is not allowed; expected true or false"),
        (("reach=1",), "--set reach: 'reach' is not allowed; expected one of gain, is_mirrored"),
        (("gain",), "--set: 'gain' is not allowed; expected NAME=VALUE"),
        (("=2",), "--set: '=2' is not allowed; expected NAME=VALUE"),
        (("gain=1", "gain=2"), "--set: 'gain=2' is not allowed; expected no second value of gain"),
    ],
)
def test_wrong_values_on_the_command_line_are_named(
    sliced: str, refused: Callable[..., str], typed: tuple[str, ...], message: str
) -> None:
    pairs = [part for text in typed for part in ("--set", text)]
    assert refused("evaluate", 1, 0.1, 0.2, 0.3, "--mechanism", sliced, *pairs) == message
    assert refused("config", "show", "--mechanism", sliced, *pairs) == message


@pytest.mark.parametrize(
    "command",
    [
        ("sweep", "-o", "never.h5"),
        ("config", "show"),
        ("evaluate", 26, 30, 16),
        ("geometry", "loci", 26, 30, 16),
        ("size", 26, 30, 16, "--circle", 3),
        ("design", "--circle", 3),
        ("plot", "lci", 26, 30, 16, "-o", "never.pdf"),
        ("plot", "shape-atlas", "-o", "never.pdf"),
    ],
    ids=lambda command: " ".join(map(str, command[:2])),
)
def test_a_mechanism_without_options_says_so(
    refused: Callable[..., str], command: tuple[object, ...]
) -> None:
    assert refused(*command, "--set", "theta_limit=60") == (
        "--set theta_limit: 'theta_limit' is not allowed; "
        "expected no option: the mechanism five-bar has none"
    )
    assert not Path("never.h5").exists()


def test_options_go_from_sweep_to_file_info_and_numbers(
    path: Path, tmp_path: Path, atlas: Command
) -> None:
    output = tmp_path / "sliced.h5"
    assert atlas("sweep", path, "--set", "is_mirrored=true", "-q", "-o", output).code == 0
    with open_atlas(output) as opened:
        a, b, c = opened.designs.T
        np.testing.assert_array_equal(opened["stretch"][:, 0], -3.0 * (a + b**2 + 3.0 * c))
        settings = opened.settings
    assert is_complete(output, settings)
    other = tuple({**dict(settings.options), "gain": 2.0}.items())
    assert not is_complete(output, dataclasses.replace(settings, options=other))
    document = json.loads(atlas("info", output, "--json").out)
    assert document["options"] == {"gain": 3.0, "is_mirrored": True}
    assert "options         gain = 3 deg, is_mirrored = true\n" in atlas("info", output).out
    found = json.loads(atlas("lookup", 1, 0.1, 0.5, 0.3, output, "--json").out)
    assert found["values"][0]["exact"] == pytest.approx(-3.0 * (0.1 + 0.25 + 0.9))


def test_options_of_one_design_are_shown_with_its_values(sliced: str, atlas: Command) -> None:
    command = ("evaluate", 1, 0.1, 0.2, 0.3, "--mechanism", sliced, "--set", "gain=2")
    document = json.loads(atlas(*command, "--json").out)
    assert document["options"] == {"gain": 2.0, "is_mirrored": False}
    assert document["stretch"] == [pytest.approx(2.0 * (0.1 + 0.04 + 0.9))]
    assert "gain = 2 deg, is_mirrored = false\n" in atlas(*command).out


def test_a_design_of_a_mechanism_without_options_takes_none() -> None:
    assert planar_design(26, 30, 16).options == ()
    with pytest.raises(InputError, match="five-bar has none"):
        planar_design(26, 30, 16, options={"theta_limit": 60.0})
    with pytest.raises(InputError, match="five-bar has none"):
        mechanisms.get("five-bar").planar_design([26, 30, 16], None, (("theta_limit", 60.0),))


def test_ranges_are_closed_and_may_be_open_to_one_side(sliced: str) -> None:
    mechanism = mechanisms.get(sliced)
    assert dict(mechanism.complete_options({"gain": 8}))["gain"] == 8.0
    with pytest.raises(InputError):
        mechanism.complete_options({"gain": np.nextafter(8.0, 9.0)})
    with pytest.raises(UnknownNameError, match=r"^gian: 'gian' .* \(did you mean 'gain'\?\)"):
        mechanism.complete_options({"gian": 1.0})
    assert SweepOption("x", "1", "x", 1.0, least=0.0).allowed == "a number of 0 or more"
    assert SweepOption("x", "mm", "x", 1.0, greatest=2.5).allowed == "a number up to 2.5 mm"
    assert SweepOption("x", "1", "x", 1.0).allowed == "a finite number"
    assert SweepOption("x", "1", "x", 1.0).check(-3, "x") == -3.0
