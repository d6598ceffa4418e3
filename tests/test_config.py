"""Configurations: files, overrides, canonical text, and every fault by its name."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st

from fivebar_atlas import config, mechanisms
from fivebar_atlas.config import Configuration, Overrides
from fivebar_atlas.errors import AtlasError, FileUsageError, InputError, UnknownNameError
from fivebar_atlas.mechanisms.five_bar.mechanism import FiveBarMechanism
from fivebar_atlas.mechanisms.settings import SweepSettings

DEFAULT = SweepSettings("five-bar", "surrounded", 300, ("+-/up",), (0.5,), 1e-6)


def write(folder: Path, text: str) -> Path:
    path = folder / "sweep.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_nothing_given_is_the_paper_atlas() -> None:
    assert config.resolve() == Configuration(DEFAULT)


def test_file_wins_over_defaults(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        """
        mechanism = "five-bar"
        [sweep]
        resolution = 40
        space = "assemblable"
        mode = ["pm/up", "--/down"]
        lci = [0.25, 0.5]
        tolerance = 1e-4
        [run]
        threads = 3
        output = "here.h5"
        """,
    )
    expected = SweepSettings("five-bar", "assemblable", 40, ("+-/up", "--/down"), (0.25, 0.5), 1e-4)
    assert config.resolve(path) == Configuration(expected, 3, Path("here.h5"))


def test_command_line_wins_over_file(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "[sweep]\nresolution = 40\nmode = ['+-/up']\nlci = [0.2]\ntolerance = 1e-4\n"
        "[run]\nthreads = 3\noutput = 'a.h5'",
    )
    given_options = Overrides(
        resolution=50,
        space="assemblable",
        mode=("mp/up",),
        lci=(0.7, 0.3),
        tolerance=1e-5,
        threads=1,
        output="b.h5",
    )
    expected = SweepSettings("five-bar", "assemblable", 50, ("-+/up",), (0.7, 0.3), 1e-5)
    assert config.resolve(path, given_options) == Configuration(expected, 1, Path("b.h5"))
    partly = config.resolve(path, Overrides(resolution=50))
    assert partly.settings.tolerance == 1e-4
    assert partly.settings.resolution == 50
    assert partly.threads == 3


@pytest.mark.parametrize(
    ("overrides", "expected"),
    [
        (Overrides(), ("dask", "tcp://one:8786", None)),
        (Overrides(executor="threads"), ("threads", None, None)),
        (Overrides(scheduler="tcp://two:8786"), ("dask", "tcp://two:8786", None)),
        (Overrides(scheduler_file="two.json"), ("dask", None, "two.json")),
        (Overrides(executor="dask"), ("dask", "tcp://one:8786", None)),
    ],
)
def test_a_cluster_on_the_command_line_replaces_that_of_the_file(
    tmp_path: Path, overrides: Overrides, expected: tuple[str | None, ...]
) -> None:
    file = write(tmp_path, '[run]\nexecutor = "dask"\nscheduler = "tcp://one:8786"\n')
    found = config.resolve(file, overrides)
    assert (found.executor, found.scheduler, found.scheduler_file) == expected


@pytest.mark.parametrize(
    ("text", "key", "nearest"),
    [
        ("[sweep]\nresolutoin = 5", "sweep.resolutoin", "sweep.resolution"),
        ("[sweep]\nmodes = []", "sweep.modes", "sweep.mode"),
        ("[run]\nthread = 1", "run.thread", "run.threads"),
        ("mechansim = 'five-bar'", "mechansim", "mechanism"),
        ("[swep]\nresolution = 5", "swep", "sweep"),
        ("[swep]", "swep", "sweep"),
        ("resolution = 5", "resolution", "sweep.resolution"),
        ("[sweep.mode]\nfirst = 1", "", ""),
    ],
)
def test_unknown_keys_are_named_with_the_nearest(
    tmp_path: Path, text: str, key: str, nearest: str
) -> None:
    path = write(tmp_path, text)
    with pytest.raises(InputError) as caught:
        config.load(path)
    assert caught.value.exit_code == 2
    assert str(path) in str(caught.value)
    if key:
        assert isinstance(caught.value, UnknownNameError)
        assert caught.value.value == key
        assert f"did you mean {nearest!r}?" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        ("[sweep]\nresolution = '300'", "sweep.resolution", "an integer"),
        ("[sweep]\nresolution = 300.0", "sweep.resolution", "an integer"),
        ("[sweep]\nresolution = true", "sweep.resolution", "an integer"),
        ("[sweep]\nmode = '+-/up'", "sweep.mode", "a list"),
        ("[sweep]\nmode = ['+-/up', 3]", "sweep.mode.1", "a text"),
        ("[sweep]\nmode = {first = 1}", "sweep.mode", "a list"),
        ("[sweep]\nlci = 0.5", "sweep.lci", "a list"),
        ("[sweep]\nlci = [0.5, '0.6']", "sweep.lci.1", "a number"),
        ("[sweep]\ntolerance = 'small'", "sweep.tolerance", "a number"),
        ("[sweep]\nspace = 1979-05-27", "sweep.space", "a text"),
        ("sweep = 3", "sweep", "a table"),
        ("mechanism = 5", "mechanism", "a text"),
        ("[run]\nthreads = 1.5", "run.threads", "an integer"),
        ("[run]\noutput = 1", "run.output", "a text"),
    ],
)
def test_wrong_types_are_named(tmp_path: Path, text: str, key: str, expected: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(InputError) as caught:
        config.load(path)
    assert caught.value.name == f"{key} in {path}"
    assert caught.value.allowed.startswith(expected)
    assert caught.value.exit_code == 2


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("[sweep]\nresolution = 2", "sweep.resolution"),
        ("[sweep]\nresolution = -300", "sweep.resolution"),
        ("[sweep]\nresolution = 1000000", "sweep.resolution"),
        ("[sweep]\nspace = 'all'", "sweep.space"),
        ("[sweep]\nmode = []", "sweep.mode"),
        ("[sweep]\nmode = ['+-/up', 'up']", "sweep.mode"),
        ("[sweep]\nlci = [0.0]", "sweep.lci"),
        ("[sweep]\nlci = [1]", "sweep.lci"),
        ("[sweep]\nlci = [nan]", "sweep.lci"),
        ("[sweep]\nlci = [0.5, 0.3, 0.5]", "sweep.lci"),
        ("[sweep]\ntolerance = 0.01", "sweep.tolerance"),
        ("[sweep]\ntolerance = 1e-11", "sweep.tolerance"),
        ("[sweep]\ntolerance = nan", "sweep.tolerance"),
        ("mechanism = 'hexapod'", "mechanism"),
        ("[run]\nthreads = 0", "run.threads"),
        ("[run]\nthreads = 100000", "run.threads"),
        ("[run]\noutput = ' '", "run.output"),
    ],
)
def test_values_out_of_range_are_named_by_key_and_file(tmp_path: Path, text: str, key: str) -> None:
    path = write(tmp_path, text)
    config.load(path)  # the types are right
    with pytest.raises(InputError) as caught:
        config.resolve(path)
    assert caught.value.name == f"{key} in {path}"


@pytest.mark.parametrize(
    ("given_options", "name"),
    [
        (Overrides(resolution=0), "--resolution"),
        (Overrides(space="x"), "--space"),
        (Overrides(mode=("x",)), "--mode"),
        (Overrides(lci=(2.0,)), "--lci"),
        (Overrides(tolerance=1.0), "--tolerance"),
        (Overrides(threads=-1), "--threads"),
        (Overrides(output=""), "--output"),
        (Overrides(mechanism="x"), "--mechanism"),
    ],
)
def test_values_of_options_are_named_by_option(given_options: Overrides, name: str) -> None:
    with pytest.raises(InputError) as caught:
        config.resolve(None, given_options)
    assert caught.value.name == name


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("[sweep]\nresolution = \nspace = 'surrounded'", r"line 2, column 14"),
        ("[sweep\n", r"line 1, column 7"),
        ("[run]\na = 1\na = 2\n", "line 3, column 6"),
    ],
)
def test_broken_toml_is_placed(tmp_path: Path, text: str, place: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(FileUsageError, match=place):
        config.load(path)


def test_files_that_cannot_be_configurations(tmp_path: Path) -> None:
    with pytest.raises(FileUsageError, match="no such file"):
        config.load(tmp_path / "missing.toml")
    with pytest.raises(FileUsageError, match="folder"):
        config.load(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileUsageError, match="not TOML"):
        config.load(binary)
    below_file = binary / "x.toml"
    with pytest.raises(AtlasError, match="cannot be read"):
        config.load(below_file)


def test_no_threshold_is_a_choice(tmp_path: Path) -> None:
    settings = config.resolve(write(tmp_path, "[sweep]\nlci = []")).settings
    assert settings.lci_thresholds == ()
    assert config.settings_from_text(config.render_settings(settings), "x") == settings


def test_rendering_reads_back(tmp_path: Path) -> None:
    wanted = Configuration(DEFAULT, 7, Path('odd "name" \\ with\ttab.h5'))
    assert config.resolve(write(tmp_path, config.render(wanted))) == wanted
    assert config.resolve(write(tmp_path, config.render(Configuration(DEFAULT)))) == Configuration(
        DEFAULT
    )


@given(
    st.sampled_from(["surrounded", "assemblable"]),
    st.integers(3, 5000),
    st.lists(st.sampled_from(FiveBarMechanism.modes), min_size=1, unique=True),
    st.lists(st.floats(1e-9, 0.999), max_size=5, unique=True),
    st.floats(1e-10, 1e-3),
)
def test_stored_settings_read_back_to_the_last_bit(
    space: str, resolution: int, modes: list[str], thresholds: list[float], tolerance: float
) -> None:
    settings = SweepSettings(
        "five-bar", space, resolution, tuple(modes), tuple(thresholds), tolerance
    )
    text = config.render_settings(settings)
    tomllib.loads(text)
    assert config.settings_from_text(text, "stored") == settings


def test_ways_of_writing_make_no_difference_to_the_stored_text(tmp_path: Path) -> None:
    text = "[sweep]\nmode = ['PM/up', '+-/up']\nlci = [5e-1]\ntolerance = 0.000001"
    assert config.render_settings(config.resolve(write(tmp_path, text)).settings) == (
        config.render_settings(DEFAULT)
    )


@pytest.mark.parametrize("path", sorted((ROOT / "configs").glob("*.toml")), ids=lambda p: p.stem)
def test_ready_made_configurations_resolve(path: Path) -> None:
    configuration = config.resolve(path)
    named = [name for name in mechanisms.names() if path.stem.startswith(name)]
    expected = named[0] if named else "five-bar"
    assert configuration.settings.mechanism == expected
    # The output is for the user to name, the threads for the machine.
    assert configuration.output is None
    assert configuration.threads is None


def test_ready_made_configurations_are_those_promised() -> None:
    settings = {
        path.stem: config.resolve(path).settings for path in (ROOT / "configs").glob("*.toml")
    }
    assert settings["paper"] == DEFAULT
    assert settings["eight-modes"].modes == FiveBarMechanism.modes
    assert settings["preview"].resolution < 100
    assert settings["high-resolution"].resolution >= 1000
    assert settings["assemblable"].space == "assemblable"
