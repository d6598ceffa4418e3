"""Hashes and versions that tell whether two runs give the same numbers."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import fivebar_atlas
from fivebar_atlas import mechanisms, versions

PROGRAM = "from fivebar_atlas import versions as v; print(v.computing_versions({!r}))"


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the package that may be changed."""
    copy = tmp_path_factory.mktemp("copy") / "fivebar_atlas"
    shutil.copytree(Path(fivebar_atlas.__file__).parent, copy)
    return copy


def versions_of(package: Path, mechanism: str) -> dict[str, str]:
    """Return what a copy of the package says of itself."""
    command = [sys.executable, "-c", PROGRAM.format(mechanism)]
    folder = package.parent  # of the work, and so first on the path
    run = subprocess.run(command, capture_output=True, text=True, check=True, cwd=folder)
    found: dict[str, str] = eval(run.stdout)
    return found


def test_a_copy_has_the_same_hashes(package: Path) -> None:
    for name in mechanisms.names():
        assert versions_of(package, name) == versions.computing_versions(name)


@pytest.mark.parametrize(
    ("changed", "of_pentapod", "of_five_bar"),
    [
        ("mechanisms/pentapod/sampling.py", True, False),
        ("mechanisms/five_bar/workspace.py", True, True),  # through the hash of all kernels
        ("mechanisms/normalisation.py", True, True),
        ("numerics/records.py", True, True),
        ("figures/wording.py", False, False),
    ],
)
def test_any_source_that_numbers_depend_on_counts(
    package: Path, changed: str, of_pentapod: bool, of_five_bar: bool
) -> None:
    source = package / changed
    before = source.read_text()
    source.write_text(before + "\n# a change\n")
    try:
        for name, differs in (("pentapod", of_pentapod), ("five-bar", of_five_bar)):
            assert (versions_of(package, name) != versions.computing_versions(name)) is differs
    finally:
        source.write_text(before)


def test_packages_that_numbers_depend_on_are_named() -> None:
    assert set(versions.computing_versions("five-bar")) == {
        "kernel_hash", "source_hash", "numba_version", "numpy_version",
    }  # fmt: skip
    assert "scipy_version" in versions.computing_versions("pentapod")
