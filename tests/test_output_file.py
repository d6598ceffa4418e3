"""Files get their final name in one step, and take no name that somebody else has taken."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fivebar_atlas.errors import FileUsageError
from fivebar_atlas.output_file import put_in_place


def without_links(source: Path, target: Path) -> None:  # noqa: ARG001
    raise PermissionError(1, "Operation not permitted")


@pytest.mark.parametrize("links", [True, False])
def test_a_free_name_is_taken_and_a_taken_one_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    """On file systems with links and on those without."""
    if not links:
        monkeypatch.setattr(os, "link", without_links)
    temporary, output = tmp_path / "temporary", tmp_path / "output"
    temporary.write_text("first")
    put_in_place(temporary, output, overwrite=False)
    assert output.read_text() == "first"
    assert not temporary.exists()
    temporary.write_text("second")
    with pytest.raises(FileUsageError, match="exists already"):
        put_in_place(temporary, output, overwrite=False)
    assert output.read_text() == "first"
    assert temporary.read_text() == "second"
    put_in_place(temporary, output, overwrite=True)
    assert output.read_text() == "second"
    assert [path.name for path in tmp_path.iterdir()] == ["output"]
