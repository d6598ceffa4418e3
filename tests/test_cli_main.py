"""The command line as a whole: help, errors on one line, exit codes, closed outputs."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest
from conftest import Command

from fivebar_atlas import __version__, cli
from fivebar_atlas.errors import FileError

ATLAS = "import sys; from fivebar_atlas.cli import main; sys.argv[0] = 'atlas'; main()"

Start = Callable[..., subprocess.Popen[str]]


@pytest.mark.parametrize("arguments", [(), ("--help",)])
def test_help_lists_the_commands(atlas: Command, arguments: tuple[str, ...]) -> None:
    outcome = atlas(*arguments)
    assert outcome.code == 0
    for command in ("sweep", "plot", "evaluate", "info", "export", "config"):
        assert f"  {command} " in outcome.out


def test_version(atlas: Command) -> None:
    assert atlas("--version").out == f"atlas, version {__version__}\n"


@pytest.mark.parametrize("command", ["sweep", "evaluate", "info", "export", "config"])
def test_every_command_has_the_help_it_is_listed_with(atlas: Command, command: str) -> None:
    outcome = atlas(command, "--help")
    assert outcome.code == 0
    assert outcome.out.startswith(f"Usage: atlas {command}")
    found = cli.main.get_command(click.Context(cli.main), command)
    assert found is not None
    assert found.help
    assert found.name == command


def test_group_without_subcommand_shows_help(atlas: Command) -> None:
    outcome = atlas("config")
    assert outcome.code == 0
    assert "show" in outcome.out


def test_help_imports_nothing_heavy(start: Start) -> None:
    script = (
        "import sys\nfrom fivebar_atlas.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "heavy = {'numpy', 'numba', 'scipy', 'h5py', 'matplotlib', 'pydantic'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    out, _ = start(script).communicate()
    assert out.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [
        (["sweep", "--help"], set()),
        (["evaluate", "--help"], set()),
        (["config", "show"], {"numpy", "pydantic"}),
        (["evaluate", "1", "1", "nan"], {"numpy"}),
    ],
)
def test_commands_import_what_they_need(start: Start, arguments: list[str], allowed: set) -> None:
    script = (
        "import sys\nfrom fivebar_atlas.cli import main\n"
        "try:\n    main(sys.argv[1:])\nexcept SystemExit:\n    pass\n"
        "heavy = {'numpy', 'numba', 'scipy', 'h5py', 'matplotlib', 'pydantic'}\n"
        "print(*sorted(heavy & set(sys.modules)))"
    )
    out, _ = start(script, *arguments).communicate()
    assert set(out.splitlines()[-1].split()) == allowed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("swep",), "No such command 'swep'"),
        (("sweep", "--resolutoin", "5"), "--resolution"),
        (("sweep", "--resolution"), "requires an argument"),
        (("sweep", "--resolution", "many"), "'many' is not a valid integer"),
        (("sweep", "a.toml", "b.toml"), "unexpected extra argument"),
        (("info",), "Missing argument 'FILE.h5'"),
        (("export", "a.h5"), "Missing option"),
        (("config", "sho"), "No such command 'sho'"),
    ],
)
def test_wrong_usage_is_one_line(
    refused: Callable[..., str], arguments: tuple[str, ...], message: str
) -> None:
    assert message in refused(*arguments)


def test_errors_keep_their_exit_code_and_lose_their_line_breaks(
    refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise FileError("a.h5", "is\n  broken")

    monkeypatch.setattr("fivebar_atlas.store.open_atlas", fail)
    assert refused("info", "a.h5", code=1) == "a.h5: is broken"


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (OSError(errno.EIO, "Input/output error", "a.h5"), "a.h5: Input/output error"),
        (MemoryError(), "there is not enough memory"),
    ],
)
def test_faults_of_the_machine_are_one_line(
    refused: Callable[..., str],
    monkeypatch: pytest.MonkeyPatch,
    error: Exception,
    message: str,
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("fivebar_atlas.store.open_atlas", fail)
    # In this process standard output is not ours to discard.
    monkeypatch.setattr(cli, "_discard_output", lambda: None)
    assert refused("info", "a.h5", code=1) == message


def test_interrupt_is_130(atlas: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("fivebar_atlas.store.open_atlas", interrupt)
    outcome = atlas("info", "a.h5")
    assert outcome.code == 130
    assert outcome.err.splitlines()[-1] == "atlas: interrupted"


def test_bugs_are_not_hidden(atlas: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def bug(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("fivebar_atlas.store.open_atlas", bug)
    with pytest.raises(ZeroDivisionError):
        atlas("info", "a.h5")


def test_standalone_mode_is_respected() -> None:
    with pytest.raises(click.UsageError):
        cli.main(["swep"], standalone_mode=False)


def test_reader_that_has_enough_is_no_error(tmp_path: Path) -> None:
    """A closed pipe ends the command without a word, whatever it still had to say."""
    environment = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parents[2])}
    read, write = os.pipe()
    os.close(read)
    try:
        done = subprocess.run(
            [sys.executable, "-c", ATLAS, "config", "show"],
            stdout=write,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            env=environment,
            check=False,
        )
    finally:
        os.close(write)
    assert done.returncode == 1
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the platform has no /dev/full")
def test_full_standard_output_is_one_line(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(cli.__file__).parents[2])}
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-c", ATLAS, "config", "show"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            env=environment,
            check=False,
        )
    assert done.returncode == 1
    assert done.stderr == "atlas: error: standard output: No space left on device\n"


def test_a_process_without_standard_output_ends_in_order() -> None:
    """Whoever closes standard output gets no traceback."""
    script = "from fivebar_atlas.cli import main; main(['evaluate', '26', '30', '16'])"
    process = subprocess.run(
        ["sh", "-c", '"$0" -c "$1" >&-', sys.executable, script],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Traceback" not in process.stderr
    assert process.returncode in (0, 1)
