"""The runs on the page about optima print what the page shows, number by number."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from conftest import ROOT, Command

PAGE = ROOT / "docs" / "optimum.md"
BLOCK = re.compile(r"^```console\n\$ atlas (.*?[^\\])\n(.*?)^```", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d+(\.\d+)?(e[+-]\d+)?")


def same(shown: str, printed: str) -> bool:
    """Return whether two words are alike, numbers to the digits that do not depend on luck."""
    shown, printed = shown.rstrip(","), printed.rstrip(",")
    if not (NUMBER.fullmatch(shown) and NUMBER.fullmatch(printed)):
        return shown == printed
    if "e" in shown or "e" in printed:  # an error or a difference: its size
        return abs(float(shown) - float(printed)) <= 1e-9 + 0.9 * abs(float(shown))
    return float(printed) == pytest.approx(float(shown), rel=2e-6, abs=2e-6)


@pytest.mark.slow
def test_runs_print_what_is_shown(
    atlas: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    shown = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    assert len(shown) == 7
    for command, expected in shown:
        outcome = atlas(*shlex.split(command.replace("\\\n", " ")))
        assert outcome.code == 0, outcome.err
        if not expected:
            continue
        printed = outcome.out.split()
        words = expected.split()
        assert len(printed) == len(words), outcome.out
        different = [pair for pair in zip(words, printed, strict=True) if not same(*pair)]
        assert not different, command
