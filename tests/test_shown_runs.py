"""The runs that pages show print what the pages show, number by number."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from conftest import ROOT, Command

BLOCK = re.compile(r"^```console\n\$ atlas (.*?[^\\])\n(.*?)^```", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d+(\.\d+)?(e[+-]\d+)?")
# Squares that a proof took, and margins that are what a proof leaves.
INCIDENTAL = re.compile(r"^(containment|margin of (LCI|R3 least)) .*$", re.MULTILINE)


def same(shown: str, printed: str) -> bool:
    """Return whether two words are alike, numbers to the digits that do not depend on luck."""
    shown, printed = shown.strip("(),"), printed.strip("(),")
    if not (NUMBER.fullmatch(shown) and NUMBER.fullmatch(printed)):
        return shown == printed
    if "e" in shown or "e" in printed:  # an error or a difference: its size
        return abs(float(shown) - float(printed)) <= 1e-9 + 0.9 * abs(float(shown))
    # a place may be the mirror image of another one
    return abs(float(printed)) == pytest.approx(abs(float(shown)), rel=2e-6, abs=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "count"), [("optimum", 7), ("square", 3), ("machines", 1), ("trajectory", 1)]
)
def test_runs_print_what_is_shown(
    page: str, count: int, atlas: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    shown = BLOCK.findall(text)
    assert len(shown) == count
    for command, expected in shown:
        outcome = atlas(*shlex.split(command.replace("\\\n", " ")))
        assert outcome.code == 0, outcome.err
        if not expected:
            continue
        words = INCIDENTAL.sub("", expected).split()
        printed = INCIDENTAL.sub("", outcome.out).split()
        # a page may show the beginning or the end of what is printed
        ends = (printed[: len(words)], printed[-len(words) :])
        different = [
            [pair for pair in zip(words, end, strict=True) if not same(*pair)] for end in ends
        ]
        assert not min(different, key=len), command
