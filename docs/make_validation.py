"""Write the tables of published values, one a paper: printed, ours, verdict.

The values and their computation are those of the test suite, so the tables cannot say
anything that the tests do not check.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterable
from pathlib import Path

_TESTS = Path(__file__).parent.parent / "tests"
sys.path.insert(0, str(_TESTS))

from published_values import PublishedValue, load  # noqa: E402

_VERDICTS = {
    "reproduced": "reproduced",
    "last_digit_differs": "last digit differs",
    "not_reproduced": "**not reproduced**",
}


def make(page: Path) -> None:
    """Compute every published value and write the tables.

    Parameters
    ----------
    page
        Markdown file to write; its folder is made if it is missing.
    """
    page.parent.mkdir(parents=True, exist_ok=True)
    text = []
    for paper, values in itertools.groupby(load(), lambda value: value.paper):
        text += [f"### {paper}", "", *_table(values)]
    page.write_text("\n".join(text), encoding="utf-8")


def _table(values: Iterable[PublishedValue]) -> list[str]:
    """Return the lines of the table of a paper, and the remarks below it."""
    lines = ["| what | where | printed | ours | verdict |", "|---|---|---|---|---|"]
    notes: dict[str, list[str]] = {}
    for value in values:
        ours = value.compute()
        lines.append(
            f"| {value.says} | {value.where} | {_printed(value)} "
            f"| {'does not exist' if math.isnan(ours) else f'{ours:.6g}'} "
            f"| {_VERDICTS[value.verdict]} |"
        )
        if value.explanation:
            notes.setdefault(value.explanation, []).append(value.says)
    remarks = [f"- *{'; '.join(rows)}*: {text}" for text, rows in notes.items()]
    return [*lines, "", "Remarks:", "", *remarks, ""]


def _printed(value: PublishedValue) -> str:
    if value.claim is not None:
        return value.claim
    if isinstance(value.printed, str):
        return value.printed
    return " to ".join(value.printed)


if __name__ == "__main__":
    make(Path(__file__).parent / "_generated" / "validation.md")
