"""``atlas animate``: what frames show, files as Pillow reads them, refused paths."""

from __future__ import annotations

import csv
import math
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import naive
import numpy as np
import pytest
from conftest import Command
from PIL import Image, ImageSequence

from fivebar_atlas import mechanisms
from fivebar_atlas.checked_paths import CheckedPath, usable_region
from fivebar_atlas.closed_paths import circle_path, closed, inset_path, path_lengths
from fivebar_atlas.errors import InfeasiblePathError, InputError
from fivebar_atlas.figures.animation import PathAnimation, path_animation
from fivebar_atlas.figures.saving import rendered
from fivebar_atlas.mechanisms.planar import PlanarDesign

MACHINE = (26.0, 30.0, 16.0)
RING = (1.28, 1.72, 0.0)


def design_of(lengths: tuple[float, float, float]) -> PlanarDesign:
    mechanism = mechanisms.get("five-bar")
    return mechanism.planar_design(list(lengths))


def animation_of(
    lengths: tuple[float, float, float],
    corners: np.ndarray,
    frames: int,
    mode: str = "+-/up",
    close: bool = True,
) -> PathAnimation:
    return path_animation(CheckedPath.of(design_of(lengths), corners, mode, close), frames)


def test_links_keep_their_lengths_and_the_output_point_its_path() -> None:
    """Read from the artists, frame by frame."""
    path = inset_path(usable_region(design_of(MACHINE), "+-/up"), 2.0)
    animation = animation_of(MACHINE, path, 24)
    total = path_lengths(closed(path))[-1]
    r1, r2, r3 = MACHINE
    for number in range(24):
        animation.show(number)
        lines = [np.column_stack(line.get_data()) for line in animation.linkage.links]
        lengths = [float(np.hypot(*(end - start))) for start, end in lines]
        assert lengths == pytest.approx([2 * r3, r1, r1, r2, r2])
        marks = [np.column_stack(joint.get_data())[0] for joint in animation.linkage.joints]
        np.testing.assert_allclose(marks[:2], [[-r3, 0.0], [r3, 0.0]])
        trace = np.column_stack(animation.trace.get_data())
        np.testing.assert_allclose(trace[0], path[0])
        np.testing.assert_allclose(trace[-1], marks[-1], atol=1e-9)
        assert path_lengths(trace)[-1] == pytest.approx(number * total / 24, abs=1e-9)
        (where,), (lci,) = animation.marker.get_data()
        assert where == pytest.approx(number * total / 24)
        x, y = marks[-1] / 24.0
        assert lci == pytest.approx(naive.lci(26 / 24, 30 / 24, 16 / 24, x, y, 1, -1))
        shown = [text.get_text() for text in animation.readout]
        assert shown[0] == f"{lci:.3f}"
        for text, angle, base in zip(shown[1:], lines[1:3], (-r3, r3), strict=True):
            (start, end) = angle
            assert start[0] == base
            turned = math.degrees(math.atan2(end[1] - start[1], end[0] - start[0]))
            value = float(text.removesuffix("°").replace("−", "-"))
            assert abs(math.remainder(value - turned, 360.0)) < 0.051


def test_inputs_are_continuous_and_the_lci_curve_is_that_of_the_closed_form() -> None:
    animation = animation_of(RING, circle_path(0.0, 0.0, 1.5), 12)
    np.testing.assert_allclose(
        np.degrees(animation.inputs - animation.inputs[0]),
        30.0 * np.arange(12)[:, None] * np.ones(2),
        atol=1e-4,
    )
    (curve,) = [
        line
        for axes in animation.figure.axes
        for line in axes.get_lines()
        if line.get_gid() == "lci"
    ]
    rho, r1, r2 = 1.5, 1.28, 1.72
    psi = math.acos((rho**2 + r2**2 - r1**2) / (2 * rho * r2))
    lengths, values = curve.get_data()
    np.testing.assert_allclose(values, min(math.tan(psi), 1.0 / math.tan(psi)), rtol=1e-5)
    assert (lengths[0], lengths[-1]) == (0.0, pytest.approx(3.0 * math.pi, rel=1e-5))


def test_open_path_is_shown_from_end_to_end() -> None:
    corners = np.array([[0.0, 40.0], [10.0, 40.0], [10.0, 30.0]])
    animation = animation_of(MACHINE, corners, 5, close=False)
    outputs = np.array([pose.output for pose in animation.poses])
    np.testing.assert_allclose(
        outputs, [[0, 40], [5, 40], [10, 40], [10, 35], [10, 30]], atol=1e-12
    )


def test_workspace_and_loci_are_the_exact_ones() -> None:
    animation = animation_of(RING, circle_path(0.0, 0.0, 1.5), 4)
    panel = animation.figure.axes[0]
    lines = {line.get_gid(): np.column_stack(line.get_data()) for line in panel.get_lines()}
    radii = {
        name: np.hypot(*points.T)
        for name, points in lines.items()
        if name is not None and name.startswith("C_")
    }
    for name, radius in (("C_1o-1", 3.0), ("C_2i-1", 0.44)):
        np.testing.assert_allclose(radii[name], radius, rtol=1e-9)
    (patch,) = panel.patches
    distances = np.hypot(*np.asarray(patch.get_path().vertices).T)
    assert distances.min() == pytest.approx(0.44)
    assert distances.max() == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("lengths", "mode"),
    [
        (MACHINE, "+-/up"),
        (RING, "+-/up"),
        ((1.2, 1.0, 0.8), "++/up"),
        ((1.3, 1.6, 0.1), "--/down"),
        ((2600.0, 3000.0, 1600.0), "-+/down"),
    ],
)
@pytest.mark.parametrize("width", [60.0, 85.0, 170.0])
def test_text_is_inside_the_figure_and_does_not_overlap(
    lengths: tuple[float, float, float], mode: str, width: float
) -> None:
    design = design_of(lengths)
    path = inset_path(usable_region(design, mode), 0.02 * design.factor)
    animation = path_animation(CheckedPath.of(design, path, mode, close=True), 7, width)
    figure = animation.figure
    for number in (0, 3, 6):
        animation.show(number)
        figure.canvas.draw()
        boxes = []
        for axes in (figure, *figure.axes):
            texts = list(axes.texts)
            if axes is not figure and axes.axison:
                texts += [*axes.get_xticklabels(), *axes.get_yticklabels()]
            boxes += [text.get_window_extent() for text in texts if text.get_text()]
        assert len(boxes) > 15
        for place, box in enumerate(boxes):
            assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
            assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
            for other in boxes[:place]:
                overlap = (
                    min(box.x1, other.x1) - max(box.x0, other.x0),
                    min(box.y1, other.y1) - max(box.y0, other.y0),
                )
                assert min(overlap) < 0.5, (box, other)  # pixels at 100 dpi


@pytest.mark.parametrize("width", [60.0, 170.0])
def test_everything_that_moves_and_the_ground_stay_in_the_panel(width: float) -> None:
    """The base joints of this design are the lowest points of its workspace."""
    design = design_of((1.0, 1.0, 1.0))
    path = inset_path(usable_region(design, "+-/up"), 0.05)
    animation = path_animation(CheckedPath.of(design, path, "+-/up", close=True), 30, width)
    panel = animation.figure.axes[0]
    animation.figure.canvas.draw()
    (ground,) = [each for each in panel.collections if each.get_gid() == "ground"]
    marks = np.concatenate([line.vertices for line in ground.get_paths()])
    joints = [joint.position for pose in animation.poses for joint in pose.joints]
    shown = np.concatenate([marks, joints, animation.way])
    (left, right), (low, high) = panel.get_xlim(), panel.get_ylim()
    assert np.all((shown > (left, low)) & (shown < (right, high)))


def test_gif_has_the_frames_and_the_speed_asked_for(atlas: Command, tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    outcome = atlas("animate", *MACHINE, "-o", path, "--frames", 9, "--fps", 25, "--width", 60)
    assert outcome.code == 0
    assert outcome.out == ""
    assert outcome.err.splitlines()[-1] == f"{path}: 9 frames, 0.36 s"
    with Image.open(path) as picture:
        assert picture.format == "GIF"
        assert picture.n_frames == 9
        assert picture.info["loop"] == 0
        assert picture.width == round(60 / 25.4 * 200 / 2) * 2
        assert [frame.info["duration"] for frame in ImageSequence.Iterator(picture)] == [40] * 9


@pytest.mark.parametrize(
    ("arguments", "frames", "milliseconds"),
    [
        (("--seconds", 0.5), 10, 50),
        (("--seconds", 0.2, "--fps", 50), 10, 20),
        (("--frames", 4, "--fps", 30), 4, 30),
        (("--frames", 2, "--fps", 1), 2, 1000),
    ],
)
def test_speed_and_duration(
    atlas: Command,
    tmp_path: Path,
    arguments: tuple[object, ...],
    frames: int,
    milliseconds: int,
) -> None:
    path = tmp_path / "a.gif"
    circle = ("--circle", 0, 1.5, 0.5)
    assert atlas("animate", *RING, *circle, "-o", path, *arguments, "-q", "--width", 60).err == ""
    with Image.open(path) as picture:
        assert picture.n_frames == frames
        assert {frame.info["duration"] for frame in ImageSequence.Iterator(picture)} == {
            milliseconds
        }


def test_same_command_writes_the_same_bytes(atlas: Command, tmp_path: Path) -> None:
    for name in ("a.gif", "b.gif"):
        assert atlas("animate", *MACHINE, "-o", tmp_path / name, "--frames", 4).code == 0
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


def test_frames_of_the_file_are_those_of_the_figure(atlas: Command, tmp_path: Path) -> None:
    """What is drawn once and what is drawn over it give the picture drawn in one go."""
    path = tmp_path / "a.gif"
    assert atlas("animate", *MACHINE, "--inset", 2, "-o", path, "--frames", 6).code == 0
    corners = inset_path(usable_region(design_of(MACHINE), "+-/up"), 2.0)
    animation = animation_of(MACHINE, corners, 6)
    with Image.open(path) as picture:
        for number, frame in enumerate(ImageSequence.Iterator(picture)):
            animation.show(number)
            (tmp_path / "whole.png").write_bytes(rendered(animation.figure, "png", 200))
            with Image.open(tmp_path / "whole.png") as whole:
                box = (0, 0, frame.width, frame.height)
                expected = np.asarray(whole.convert("RGB").crop(box), dtype=float)
            found = np.asarray(frame.convert("RGB"), dtype=float)
            gaps = np.abs(found - expected).max(axis=2)
            assert np.mean(gaps > 40.0) < 2e-4
            assert np.mean(gaps) < 0.5
            np.testing.assert_array_equal(found[:3, :3], 255.0)


def test_numbers_of_the_frames(atlas: Command, tmp_path: Path) -> None:
    data = tmp_path / "frames.csv"
    arguments = ("--frames", 6, "--fps", 10, "--data", data, "-o", tmp_path / "a.gif")
    assert atlas("animate", *MACHINE, *arguments, "--circle", 0, 36, 8).code == 0
    with data.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [
        *("frame", "time_s", "path_length_mm"),
        *(f"{joint}_{axis}_mm" for joint in ("A_1", "A_2", "B_1", "B_2", "P") for axis in "xy"),
        *("theta1_deg", "theta2_deg", "lci"),
    ]
    for number, row in enumerate(rows):
        value = {name: float(text) for name, text in row.items()}
        assert (value["frame"], value["time_s"]) == (number + 1, pytest.approx(0.1 * number))
        turn = math.tau * number / 6
        place = (8 * math.cos(turn), 36 + 8 * math.sin(turn))
        assert (value["P_x_mm"], value["P_y_mm"]) == pytest.approx(place, abs=1e-4)
        assert value["path_length_mm"] == pytest.approx(8 * turn, rel=1e-5)
        for leg, base in ((1, -16), (2, 16)):
            b = (value[f"B_{leg}_x_mm"], value[f"B_{leg}_y_mm"])
            angle = math.radians(value[f"theta{leg}_deg"])
            assert b == pytest.approx((base + 26 * math.cos(angle), 26 * math.sin(angle)))
            assert math.dist(b, (value["P_x_mm"], value["P_y_mm"])) == pytest.approx(30)
        x, y = value["P_x_mm"] / 24, value["P_y_mm"] / 24
        assert value["lci"] == pytest.approx(naive.lci(26 / 24, 30 / 24, 16 / 24, x, y, 1, -1))


def test_points_from_a_file(atlas: Command, tmp_path: Path) -> None:
    points, data = tmp_path / "points.csv", tmp_path / "frames.csv"
    points.write_text("x_mm,y_mm\n0,40\n10,40\n10,30\n")
    arguments = ("--points", points, "--data", data, "-o", tmp_path / "a.gif", "--overwrite")

    def outputs(*more: object) -> np.ndarray:
        assert atlas("animate", *MACHINE, *arguments, *more).code == 0
        with data.open(newline="") as file:
            rows = list(csv.DictReader(file))
        return np.array([[float(row["P_x_mm"]), float(row["P_y_mm"])] for row in rows])

    np.testing.assert_allclose(outputs("--frames", 3), [[0, 40], [10, 40], [10, 30]], atol=1e-12)
    half = (20 + math.hypot(10, 10)) / 2
    np.testing.assert_allclose(
        outputs("--frames", 2, "--closed"), [[0, 40], [10, 40 - (half - 10)]], atol=1e-12
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("--circle", 0, 1.5, 1.2),
            r"the path is not feasible at \(.*\): meets C_[12]i: leg [12] is folded "
            r"\(singularity: serial\)",
        ),
        (("--circle", 2.0, 0, 1.01), r"at \(3.01, 0\): P is out of reach of leg ., by 0\.01"),
        (
            ("--points", "points.csv"),
            r"not feasible between point 1 and point 2, at \(0.44, 0\): meets C_",
        ),
        (
            ("--points", "round.csv", "--closed"),
            r"not feasible between point 3 and point 1, at .*: meets C_",
        ),
        (("--mode", "++/up"), r"the usable workspace of \+\+/up is empty"),
        (("--mode", "++/up", "--circle", 0, 1.5, 0.1), r"usable workspace of \+\+/up is empty"),
    ],
)
def test_paths_that_cannot_be_followed_write_nothing(
    refused: Callable[..., str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[object, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "points.csv").write_text("x,y\n1.5,0\n-1.5,0\n")
    (tmp_path / "round.csv").write_text("x,y\n1.5,0\n0,1.5\n-1.5,0.1\n")
    before = sorted(tmp_path.iterdir())
    said = refused(
        "animate", *RING, *arguments, "-o", "a.gif", "--data", "frames.csv", "-q", code=1
    )
    assert re.search(message, said), said
    assert sorted(tmp_path.iterdir()) == before


def test_parallel_singularity_is_named(refused: Callable[..., str], tmp_path: Path) -> None:
    """Down the y axis the machine folds where B1 and B2 coincide."""
    points = tmp_path / "points.csv"
    points.write_text("x,y\n0,-30\n0,-52\n")
    said = refused("animate", *MACHINE, "--points", points, "-o", tmp_path / "a.gif", "-q", code=1)
    y = -(math.sqrt(26**2 - 16**2) + 30)
    assert f"at (0, {y:.9g}) mm: meets C_coin_down: B1 and B2 coincide" in said
    assert said.endswith("(singularity: parallel, folded)")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-o", "a.png"), "a file name that ends in one of .gif, .mp4"),
        (("-o", "there.gif"), "there.gif: exists already; --overwrite replaces it"),
        (("-o", "a.gif", "--data", "there.gif"), "there.gif: exists already"),
        (("-o", "no/a.gif"), "the folder no does not exist"),
        ((), "Missing option '-o'"),
        (("-o", "a.gif", "--fps", 51), "fps: 51 is not allowed; expected frames a second from 1"),
        (("-o", "a.gif", "--fps", 0), "fps: 0"),
        (("-o", "a.gif", "--frames", 1), "frames: 1 is not allowed; expected an integer from 2"),
        (("-o", "a.gif", "--frames", 1001), "frames: 1001"),
        (("-o", "a.gif", "--seconds", 0), "seconds: 0.0 is not allowed"),
        (("-o", "a.gif", "--seconds", "nan"), "seconds: nan"),
        (("-o", "a.gif", "--seconds", 1e9), "frames: "),
        (("-o", "a.gif", "--width", 300, "--frames", 1000), "at most 2"),
        (("-o", "a.gif", "--width", 20), "width: 20.0 is not allowed"),
        (("-o", "a.gif", "--inset", 30), "margin: 30.0 is not allowed; expected a length of at mo"),
        (("-o", "a.gif", "--inset", 0), "margin: 0.0"),
        (("-o", "a.gif", "--hole", 3), "hole: 3 is not allowed; expected a number from 1 to 1"),
        (("-o", "a.gif", "--circle", 0, 40, 0), "circle radius: 0.0"),
        (("-o", "a.gif", "--circle", 0, 40), "Option '--circle' requires 3 arguments"),
        (("-o", "a.gif", "--points", "other.csv"), "other.csv: there is no such file"),
        (("-o", "a.gif", "--points", "one.csv"), "path: 0.0 is not allowed"),
        (("-o", "a.gif", "--inset", 1, "--circle", 0, 40, 1), "exclude each other"),
        (("-o", "a.gif", "--hole", 1, "--circle", 0, 40, 1), "--hole goes with --inset only"),
        (("-o", "a.gif", "--closed"), "--closed goes with --points only"),
        (("-o", "a.gif", "--frames", 5, "--seconds", 1), "exclude each other"),
        (("-o", "a.gif", "--mode", "up"), "'up' is not allowed; expected one of"),
        (("-o", "a.gif", "--frmes", 5), "No such option '--frmes'"),
    ],
)
def test_wrong_inputs_are_named(
    refused: Callable[..., str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[object, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.gif").write_text("kept")
    (tmp_path / "one.csv").write_text("x,y\n0,40\n")
    before = sorted(tmp_path.iterdir())
    assert message in refused("animate", *MACHINE, *arguments)
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "there.gif").read_text() == "kept"


def test_mp4_without_ffmpeg_is_refused_before_any_work(
    refused: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    # even before the lengths are looked at
    said = refused("animate", 1, 1, 100, "-o", tmp_path / "a.mp4", code=1)
    assert said.endswith("MP4 needs ffmpeg, which is not found; install it, or write a .gif")
    assert list(tmp_path.iterdir()) == []


def test_what_ffmpeg_complains_of_is_passed_on(
    refused: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\ncat > /dev/null\necho 'Unknown encoder' >&2\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    said = refused("animate", *RING, "-o", tmp_path / "a.mp4", "--frames", 3, "-q", code=1)
    assert said.endswith("a.mp4: cannot be written by ffmpeg: Unknown encoder")
    assert list(tmp_path.iterdir()) == [program]


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_mp4_is_a_video_of_the_same_size(atlas: Command, tmp_path: Path) -> None:
    for name in ("a.mp4", "a.gif"):
        outcome = atlas("animate", *RING, "-o", tmp_path / name, "--frames", 10, "--fps", 10)
        assert outcome.code == 0, outcome
    told = subprocess.run(
        ["ffmpeg", "-hide_banner", "-i", tmp_path / "a.mp4", "-f", "null", "-"],
        capture_output=True,
        text=True,
        check=True,
    ).stderr
    with Image.open(tmp_path / "a.gif") as picture:
        assert f"{picture.width}x{picture.height}" in told
    assert "10 fps" in told
    assert "frame=   10" in told


def test_animation_of_an_infeasible_path_is_refused_in_python_too() -> None:
    design = design_of(RING)
    with pytest.raises(InfeasiblePathError, match="between point 1 and point 2"):
        path_animation(
            CheckedPath.of(design, np.array([[1.5, 0.0], [-1.5, 0.0]]), "+-/up", close=False), 5
        )
    with pytest.raises(InputError, match="frames: 1"):
        animation_of(RING, circle_path(0.0, 0.0, 1.5), 1)
