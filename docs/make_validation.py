"""Write the table of published values: printed, ours, verdict.

The values and their computation are those of the test suite, so the table cannot say
anything that the tests do not check.
"""

from __future__ import annotations

import math
import sys
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
    """Compute every published value and write the table.

    Parameters
    ----------
    page
        Markdown file to write; its folder is made if it is missing.
    """
    page.parent.mkdir(parents=True, exist_ok=True)
    lines = ["| what | where | printed | ours | verdict |", "|---|---|---|---|---|"]
    notes: dict[str, list[str]] = {}
    for value in load():
        ours = value.compute()
        lines.append(
            f"| {value.says} | {value.where} | {_printed(value)} "
            f"| {'does not exist' if math.isnan(ours) else f'{ours:.6g}'} "
            f"| {_VERDICTS[value.verdict]} |"
        )
        if value.explanation:
            notes.setdefault(value.explanation, []).append(value.says)
    remarks = [f"- *{'; '.join(rows)}*: {text}" for text, rows in notes.items()]
    page.write_text("\n".join([*lines, "", "Remarks:", "", *remarks, ""]), encoding="utf-8")


def _printed(value: PublishedValue) -> str:
    if value.claim is not None:
        return value.claim
    if isinstance(value.printed, str):
        return value.printed
    return " to ".join(value.printed)


if __name__ == "__main__":
    make(Path(__file__).parent / "_generated" / "validation.md")
