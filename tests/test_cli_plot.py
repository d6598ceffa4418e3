"""``atlas plot``: every kind of figure, and every wrong input with nothing written."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import closed_form_atlas
import numpy as np
import pytest
import shapely
from conftest import Command
from PIL import Image

from fivebar_atlas.mechanisms.five_bar import design_space
from fivebar_atlas.store import open_atlas

Refused = Callable[..., str]


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return closed_form_atlas.write(tmp_path_factory.mktemp("plot") / "closed_form.h5")


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a file with one mode pair and one threshold, which need not be chosen."""
    path = tmp_path_factory.mktemp("plot") / "single.h5"
    return closed_form_atlas.write(path, modes=("+-/up",), lci_thresholds=(0.5,))


KINDS = [
    ("area",),
    ("gci",),
    ("region", "--where", "gci>=0.45", "--where", "r3<=0.2"),
    ("quantity", "max_lci_y"),
    ("quantity", "status"),
    ("quantity", "gci_error"),
    ("quantity", "sub_region"),
    ("quantity", "good_condition_gci", "--lci", "0.3"),
    ("surface", "gci"),
    ("surface", "usable_workspace_area_error", "--elevation", "40", "--azimuth", "30"),
    ("design-space",),
]


@pytest.mark.parametrize("kind", KINDS, ids=" ".join)
def test_every_kind_becomes_a_picture(
    atlas: Command, stored: Path, tmp_path: Path, kind: tuple[str, ...]
) -> None:
    output = tmp_path / "figure.png"
    mode = () if kind[0] == "design-space" else ("--mode", "pm/up")

    outcome = atlas("plot", *kind, stored, *mode, "-o", output)

    assert outcome.code == 0, outcome
    assert outcome.err == ""
    with Image.open(output) as picture:
        assert picture.width == int(85 / 25.4 * 300)
        assert np.asarray(picture.convert("L"), float).std() > 20.0
    assert list(tmp_path.iterdir()) == [output]


@pytest.mark.parametrize(("ending", "start"), [("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_vector_formats(
    atlas: Command, single: Path, tmp_path: Path, ending: str, start: bytes
) -> None:
    output = tmp_path / f"gci.{ending}"
    assert atlas("plot", "gci", single, "-o", output).code == 0
    first = output.read_bytes()
    assert first.startswith(start)

    assert atlas("plot", "gci", single, "-o", output, "--overwrite").code == 0
    assert output.read_bytes() == first
    assert atlas("plot", "area", single, "-o", output, "--overwrite").code == 0
    assert output.read_bytes() != first


@pytest.mark.parametrize("space", ["surrounded", "assemblable"])
def test_the_design_space_needs_no_file(atlas: Command, tmp_path: Path, space: str) -> None:
    output = tmp_path / "space.svg"
    assert atlas("plot", "design-space", "--space", space, "-o", output).code == 0
    stored = closed_form_atlas.write(tmp_path / "closed_form.h5", space, 9)
    again = tmp_path / "again.svg"
    assert atlas("plot", "design-space", stored, "-o", again).code == 0
    assert again.read_bytes() == output.read_bytes()


def test_the_width_is_that_asked_for(atlas: Command, single: Path, tmp_path: Path) -> None:
    output = tmp_path / "gci.png"
    assert atlas("plot", "gci", single, "--width", "120", "-o", output).code == 0
    with Image.open(output) as picture:
        assert picture.width == int(120 / 25.4 * 300)


def test_the_region_is_reported(atlas: Command, single: Path, tmp_path: Path) -> None:
    outcome = atlas(
        "plot", "region", single, "-o", tmp_path / "region.png",
        "--where", "r1>=1.2", "--where", "r1<=1.5", "--where", "r3<0.3",
    )  # fmt: skip

    corners = design_space.project(
        np.array([[1.2, 1.8, 0.0], [1.5, 1.5, 0.0], [1.5, 1.2, 0.3], [1.2, 1.5, 0.3]])
    )
    share = 100.0 * shapely.Polygon(corners).area / np.sqrt(3.0)
    assert outcome.code == 0
    assert outcome.err == ""
    assert outcome.out.splitlines() == [
        f"r1>=1.2, r1<=1.5, r3<0.3: {share:.3g} % of the design space",
        "r1 from 1.2000 to 1.5000",
        "r2 from 1.2000 to 1.8000",
        "r3 from 0.0000 to 0.3000",
    ]


def test_an_empty_region_is_refused(refused: Refused, single: Path, tmp_path: Path) -> None:
    output = tmp_path / "region.png"
    text = refused("plot", "region", single, "-o", output, "--where", "gci>=0.99", code=1)
    assert text == "the region is empty: no design has gci>=0.99"
    assert not output.exists()


def test_a_line_of_designs_is_drawn_and_reported(
    atlas: Command, single: Path, tmp_path: Path
) -> None:
    output = tmp_path / "region.png"
    outcome = atlas("plot", "region", single, "-o", output, "--where", "r3<=0")
    assert outcome.code == 0
    assert output.exists()
    assert "r3<=0 is empty" in outcome.err


def test_help_lists_the_kinds_with_what_they_are(atlas: Command) -> None:
    outcome = atlas("plot", "--help")
    assert outcome.code == 0
    for kind in ("area", "design-space", "gci", "quantity", "region", "surface"):
        assert f"  {kind} " in outcome.out
    for kind in ("area", "design-space", "gci", "quantity", "region", "surface"):
        text = atlas("plot", kind, "--help").out
        assert text.startswith(f"Usage: atlas plot {kind} [OPTIONS]")
        assert "--overwrite" in text


def test_help_imports_nothing_heavy() -> None:
    script = (
        "import sys\nfrom fivebar_atlas.cli import main\n"
        "try:\n    main(['plot', 'region', '--help'])\nexcept SystemExit:\n    pass\n"
        "heavy = {'numpy', 'numba', 'scipy', 'h5py', 'matplotlib', 'pydantic'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_figure_needs_no_kernels_and_no_display(single: Path, tmp_path: Path) -> None:
    output = tmp_path / "gci.png"
    script = (
        "import sys\nfrom fivebar_atlas.cli import main\n"
        f"try:\n    main(['plot', 'gci', {str(single)!r}, '-o', {str(output)!r}])\n"
        "except SystemExit as end:\n    assert not end.code\n"
        "print(sorted({'numba', 'scipy', 'matplotlib.pyplot'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"
    assert output.exists()


@pytest.mark.parametrize(
    ("arguments", "code", "expected"),
    [
        (("plot", "gcl", "FILE", "-o", "x.png"), 2, ["KIND: 'gcl'", "area", "mean 'gci'"]),
        (("plot", "gci", "FILE"), 2, ["-o"]),
        (("plot", "gci", "-o", "x.png"), 2, ["FILE.h5"]),
        (("plot", "gci", "FILE", "-o", "x.jpg"), 2, ["x.jpg", ".png, .pdf, .svg"]),
        (("plot", "gci", "FILE", "-o", "x"), 2, [".png, .pdf, .svg"]),
        (("plot", "gci", "FILE", "-o", "nowhere/x.png"), 2, ["nowhere", "does not exist"]),
        (("plot", "gci", "FILE", "-o", "taken.png"), 2, ["taken.png", "--overwrite"]),
        (("plot", "gci", "FILE", "-o", "x.png", "--mode", "--/down"), 2, ["+-/up, ++/up"]),
        (("plot", "gci", "FILE", "-o", "x.png", "--mode", "upward"), 2, ["mode: 'upward'"]),
        (("plot", "gci", "FILE", "-o", "x.png"), 2, ["--mode", "+-/up, ++/up"]),
        (
            ("plot", "quantity", "good_condition_gci", "FILE", "-o", "x.png", "--mode", "+-/up"),
            2,
            ["--lci", "0.3, 0.5"],
        ),
        (
            ("plot", "quantity", "good_condition_gci", "FILE", "-o", "x.png", "--mode", "+-/up",
             "--lci", "0.7"),
            2,
            ["0.7", "0.3, 0.5"],
        ),
        (("plot", "gci", "FILE", "-o", "x.png", "--lci", "half"), 2, ["half"]),
        (("plot", "quantity", "gcj", "FILE", "-o", "x.png"), 2, ["'gcj'", "did you mean 'gci'"]),
        (("plot", "quantity", "r1", "FILE", "-o", "x.png"), 2, ["quantity: 'r1'"]),
        (
            ("plot", "surface", "status", "FILE", "-o", "x.png", "--mode", "+-/up"),
            2,
            ["'status'", "a category has no height"],
        ),
        (("plot", "surface", "gcj", "FILE", "-o", "x.png"), 2, ["'gcj'", "did you mean 'gci'"]),
        (
            ("plot", "surface", "gci", "FILE", "-o", "x.png", "--elevation", "90"),
            2,
            ["elevation: 90", "from 5 to 80"],
        ),
        (
            ("plot", "surface", "gci", "FILE", "-o", "x.png", "--azimuth", "nan"),
            2,
            ["azimuth: nan", "from -360 to 360"],
        ),
        (("plot", "region", "FILE", "-o", "x.png", "--mode", "+-/up"), 2, ["--where"]),
        (
            ("plot", "region", "FILE", "-o", "x.png", "--mode", "+-/up", "--where", "gci=0.6"),
            2,
            ["--where: 'gci=0.6'", "gci>=0.62"],
        ),
        (
            ("plot", "region", "FILE", "-o", "x.png", "--mode", "+-/up", "--where", "gcl>0.6"),
            2,
            ["--where: 'gcl'", "did you mean 'gci'"],
        ),
        (("plot", "gci", "FILE", "-o", "x.png", "--mode", "+-/up", "--width", "10"), 2, ["60"]),
        (("plot", "gci", "FILE", "-o", "x.png", "--width", "wide"), 2, ["wide"]),
        (("plot", "gci", "missing.h5", "-o", "x.png"), 2, ["missing.h5", "no such file"]),
        (("plot", "gci", "foreign.h5", "-o", "x.png"), 1, ["foreign.h5", "not an HDF5 file"]),
        (("plot", "design-space", "-o", "x.png", "--space", "square"), 2, ["surrounded"]),
        (("plot", "design-space", "FILE", "-o", "x.png", "--space", "assemblable"), 2,
         ["assemblable", "surrounded"]),
        (("plot", "design-space", "missing.h5", "-o", "x.png"), 2, ["missing.h5"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)  # fmt: skip
def test_a_wrong_input_is_one_clear_error_and_writes_nothing(
    refused: Refused,
    stored: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    code: int,
    expected: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("taken.png").write_text("mine")
    Path("foreign.h5").write_text("not HDF5")
    before = sorted(tmp_path.iterdir())
    filled = [str(stored) if argument == "FILE" else argument for argument in arguments]

    message = refused(*filled, code=code)

    for part in expected:
        assert part in message
    assert sorted(tmp_path.iterdir()) == before
    assert Path("taken.png").read_text() == "mine"


def test_a_damaged_file_is_said_to_be_damaged(
    refused: Refused, single: Path, tmp_path: Path
) -> None:
    damaged = tmp_path / "damaged.h5"
    content = single.read_bytes()
    damaged.write_bytes(content[: len(content) // 2])
    output = tmp_path / "gci.png"

    message = refused("plot", "gci", damaged, "-o", output, code=1)

    assert "damaged" in message
    assert not output.exists()


def test_the_figure_of_a_real_sweep(atlas: Command, tmp_path: Path) -> None:
    """End to end: what a sweep stores is what the region is made of."""
    results, output = tmp_path / "coarse.h5", tmp_path / "region.svg"
    assert atlas("sweep", "--resolution", "12", "-o", results, "--quiet").code == 0

    outcome = atlas("plot", "region", results, "--where", "gci>=0.5", "-o", output)

    assert outcome.code == 0, outcome
    with open_atlas(results) as opened:
        gci, designs = opened.select("gci"), opened.designs
    assert (gci >= 0.5).any()
    limits = [line.split() for line in outcome.out.splitlines()[1:]]
    for column, (name, _, least, _, greatest) in enumerate(limits):
        assert name == ("r1", "r2", "r3")[column]
        inside = designs[gci >= 0.5, column]
        # The region reaches beyond its designs, but not to the next ones.
        assert inside.min() - 0.25 <= float(least) <= inside.min() + 1e-4
        assert inside.max() - 1e-4 <= float(greatest) <= inside.max() + 0.25
    assert 'id="region"' in output.read_text()


def test_no_kind_shows_the_kinds_there_are(atlas: Command) -> None:
    outcome = atlas("plot")
    assert outcome.code == 2
    assert outcome.err.startswith("Usage: atlas plot")
    assert "shape-atlas" in outcome.err
