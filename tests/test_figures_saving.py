"""Figures as files: the same bytes every time, whole or not at all."""

from __future__ import annotations

import hashlib
import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import FileError, FileUsageError, InputError
from fivebar_atlas.figures import saving
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.contour_map import contour_map
from fivebar_atlas.figures.design_space import design_space_figure
from fivebar_atlas.figures.saving import FORMATS, rendered, save_figure

SCRIPT = """
import hashlib
import closed_form_atlas
from fivebar_atlas.figures.atlas_figures import quantity_figure, region_figure
from fivebar_atlas.figures.design_space import design_space_figure
from fivebar_atlas.figures.saving import FORMATS, rendered
from fivebar_atlas.store import open_atlas
from fivebar_atlas.synthesis.conditions import parse_condition
from fivebar_atlas.synthesis.optimum_region import optimum_region

with open_atlas({path!r}) as atlas:
    figures = [
        quantity_figure(atlas, name, "++/up", 0.5)
        for name in ("gci", "usable_workspace_area_error")
    ]
    found = optimum_region(atlas, [parse_condition("gci>=0.45")], "++/up")
    figures.append(region_figure(atlas, found.region, [("gci", ">=", 0.45)], "++/up"))
    chart = atlas.mechanism.chart("surrounded")
    figures.append(design_space_figure(chart, "Design space"))
for figure in figures:
    for form in FORMATS:
        print(form, hashlib.sha256(rendered(figure, form, 60.0)).hexdigest())
"""


@pytest.fixture
def figure() -> Figure:
    return design_space_figure(mechanisms.get("five-bar").chart("surrounded"), "Design space")


def test_files_are_the_same_byte_for_byte_in_every_process(tmp_path: Path) -> None:
    import closed_form_atlas

    path = closed_form_atlas.write(tmp_path / "closed_form.h5", resolution=12)
    outputs = []
    for seed, epoch in (("1", None), ("2", None), ("3", "1000000000")):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        environment["PYTHONPATH"] = str(Path(__file__).parent)
        environment.pop("SOURCE_DATE_EPOCH", None)
        if epoch is not None:
            environment["SOURCE_DATE_EPOCH"] = epoch
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT.format(path=str(path))],
            env=environment,
            cwd=Path(__file__).parent.parent,
            capture_output=True,
            text=True,
            check=True,
        )
        outputs.append(done.stdout)
    assert len(outputs[0].splitlines()) == 4 * len(FORMATS)
    assert outputs[1:] == [outputs[0]] * 2


@pytest.mark.parametrize("form", FORMATS)
def test_a_figure_drawn_twice_gives_the_same_bytes(figure: Figure, form: str) -> None:
    first = rendered(figure, form)
    assert rendered(figure, form) == first
    other = design_space_figure(mechanisms.get("five-bar").chart("assemblable"), "Design space")
    assert rendered(other, form) != first


def test_no_file_carries_a_date(figure: Figure) -> None:
    assert b"CreationDate" not in rendered(figure, "pdf")
    assert b"dc:date" not in rendered(figure, "svg")
    assert b"tIME" not in rendered(figure, "png")


def test_vector_files_hold_text_and_named_groups(figure: Figure) -> None:
    picture = rendered(figure, "svg").decode()
    assert 'id="outline"' in picture
    assert 'id="IVa"' in picture
    # Letters are outlines: the figure looks the same wherever it is opened.
    assert "<text" not in picture
    assert b"/FontFile2" in rendered(figure, "pdf")


@pytest.mark.parametrize("ending", [*FORMATS, "PNG", "Svg"])
def test_the_ending_decides_the_format(figure: Figure, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"figure.{ending}"
    save_figure(figure, path)

    starts = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}
    assert path.read_bytes().startswith(starts[ending.lower()])
    assert path.read_bytes() == rendered(figure, ending.lower())
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["figure", "figure.jpg", "figure.pdf.txt", ".png"])
def test_another_ending_is_refused(figure: Figure, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"\.png, \.pdf, \.svg") as caught:
        save_figure(figure, tmp_path / name)
    assert caught.value.exit_code == 2
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_stays_unless_it_may_be_replaced(figure: Figure, tmp_path: Path) -> None:
    path = tmp_path / "figure.svg"
    path.write_text("mine")

    with pytest.raises(FileUsageError, match="--overwrite"):
        save_figure(figure, path)
    assert path.read_text() == "mine"

    save_figure(figure, path, overwrite=True)
    assert path.read_bytes() == rendered(figure, "svg")


def test_a_failure_while_writing_leaves_what_was_there(
    figure: Figure, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "figure.png"
    path.write_text("mine")

    def full(self: Path, data: bytes) -> int:
        with self.open("wb") as file:
            file.write(data[:100])
        raise OSError(28, "No space left on device", str(self))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(FileError, match="no space left"):
        save_figure(figure, path, overwrite=True)
    assert path.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [path]


def test_a_failure_while_drawing_leaves_nothing(
    figure: Figure, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> bytes:
        raise RuntimeError("no picture")

    monkeypatch.setattr(saving, "rendered", broken)
    with pytest.raises(RuntimeError):
        save_figure(figure, tmp_path / "figure.png")
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_named(figure: Figure, tmp_path: Path) -> None:
    with pytest.raises(FileUsageError, match="missing"):
        save_figure(figure, tmp_path / "missing" / "figure.png")


BASELINES = Path(__file__).parent / "baselines"


def baseline_figures() -> dict[str, Figure]:
    mechanism = mechanisms.get("five-bar")
    designs = ChartedDesigns.of_lattice(mechanism, "surrounded", 60)
    r1, r2, r3 = designs.parameters.T
    values = np.where(r1 > 2.2, np.nan, 12.0 * r1 * r2 * (1.0 - 0.5 * r3))
    return {
        "design_space": design_space_figure(mechanism.chart("assemblable"), "Design space"),
        "contour_map": contour_map(designs, values, "Closed form", "value", missing="none"),
    }


def block_means(picture: Image.Image, size: int) -> np.ndarray:
    """Return the mean colours of square blocks of a picture."""
    pixels = np.asarray(picture.convert("RGB"), float)
    rows, columns = (length // size for length in pixels.shape[:2])
    blocks = pixels[: rows * size, : columns * size].reshape(rows, size, columns, size, 3)
    return blocks.mean(axis=(1, 3))


@pytest.mark.parametrize("name", ["design_space", "contour_map"])
def test_figures_look_as_they_did(name: str) -> None:
    """Compare with a stored picture; ``make_baselines`` draws them anew after a change."""
    picture = Image.open(io.BytesIO(rendered(baseline_figures()[name], "png", 80.0)))
    with Image.open(BASELINES / f"{name}.png") as stored:
        assert picture.size == stored.size
        ours, theirs = (block_means(each, 4) for each in (picture, stored))
    # Other versions of matplotlib and FreeType shift letters by parts of a pixel, which
    # comes to about 4; without its text or its colours a figure is 9 or more away.
    assert np.sqrt(((ours - theirs) ** 2).mean()) < 6.0
    # What is compared is not an empty page.
    assert theirs.std() > 20.0


def make_baselines() -> None:
    """Draw the stored pictures anew: ``python tests/test_figures_saving.py``."""
    BASELINES.mkdir(exist_ok=True)
    for name, figure in baseline_figures().items():
        path = BASELINES / f"{name}.png"
        path.write_bytes(rendered(figure, "png", 80.0))
        print(path, hashlib.sha256(path.read_bytes()).hexdigest())


if __name__ == "__main__":
    make_baselines()
