"""Fixtures that more than one test module uses."""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import closed_form_mechanism
import pytest
from click.testing import CliRunner

from fivebar_atlas import mechanisms
from fivebar_atlas.cli import main
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import Atlas, open_atlas

ROOT = Path(__file__).parent.parent


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What a command did: exit code, standard output and standard error."""

    code: int
    out: str
    err: str


Command = Callable[..., Outcome]


@pytest.fixture
def atlas() -> Command:
    """Run the command line in this process; an exception that it lets through fails the test."""

    def run(*arguments: object) -> Outcome:
        result = CliRunner().invoke(
            main, [str(argument) for argument in arguments], prog_name="atlas"
        )
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return Outcome(result.exit_code, result.stdout, result.stderr)

    return run


@pytest.fixture
def refused(atlas: Command) -> Callable[..., str]:
    """Run a command that must fail with one line and nothing else; return the line."""

    def run(*arguments: object, code: int = 2) -> str:
        outcome = atlas(*arguments)
        assert outcome.code == code, outcome
        assert outcome.out == ""
        lines = outcome.err.splitlines()
        assert len(lines) == 1, outcome.err
        assert lines[0].startswith("atlas: error: ")
        return lines[0].removeprefix("atlas: error: ")

    return run


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Register the mechanism of ``toy_mechanism``; returns its name."""
    monkeypatch.setitem(mechanisms._REGISTRY, "toy", "toy_mechanism:ToyMechanism")
    yield "toy"
    mechanisms.get.cache_clear()


@pytest.fixture
def sliced(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Register the mechanism of ``sliced_mechanism``; returns its name."""
    monkeypatch.setitem(mechanisms._REGISTRY, "sliced", "sliced_mechanism:SlicedMechanism")
    yield "sliced"
    mechanisms.get.cache_clear()


@pytest.fixture
def modeless(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Register the mechanism of ``modeless_mechanism``; returns its name."""
    monkeypatch.setitem(mechanisms._REGISTRY, "modeless", "modeless_mechanism:ModelessMechanism")
    yield "modeless"
    mechanisms.get.cache_clear()


@pytest.fixture
def toy_settings(toy: str) -> SweepSettings:
    """Return a sweep of the toy mechanism in several blocks."""
    return SweepSettings(toy, "whole", 200, ("right", "left"), (0.25, 0.5, 0.75), 1e-6)


@pytest.fixture
def closed_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Atlas]:
    """Register the mechanism of ``closed_form_mechanism``; returns an atlas of it."""
    monkeypatch.setitem(
        mechanisms._REGISTRY, "closed-form", "closed_form_mechanism:ClosedFormMechanism"
    )
    with open_atlas(closed_form_mechanism.write(tmp_path / "closed_form.h5")) as opened:
        yield opened
    mechanisms.get.cache_clear()


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Start a Python script as a process that can import the package and the tests."""
    processes: list[subprocess.Popen[str]] = []

    def run(
        script: str,
        *arguments: object,
        before: Callable[[], None] | None = None,
        **options: object,
    ) -> subprocess.Popen[str]:
        def prepare() -> None:
            # a shell starts background jobs with interrupts ignored, and that is inherited
            signal.signal(signal.SIGINT, signal.default_int_handler)
            if before is not None:
                before()

        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")]),
        }
        process = subprocess.Popen(
            [sys.executable, "-c", script, *(str(argument) for argument in arguments)],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=prepare,
            **options,  # type: ignore[call-overload]
        )
        processes.append(process)
        return process

    yield run
    for process in processes:
        process.kill()
        process.communicate()
