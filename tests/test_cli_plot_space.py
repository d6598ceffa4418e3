"""``atlas plot mechanism`` and ``workspace`` in space: what is drawn, and what is refused."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Command
from matplotlib.text import Text

from fivebar_atlas import Pentapod
from fivebar_atlas.figures.spatial_linkage_figure import spatial_linkage_figure

PENTAPOD = ("459.1", "400", "100", "--mechanism", "pentapod")
MACHINE = Pentapod.from_radii(459.1, 400.0, 100.0, unit="mm")

Refused = Callable[..., str]


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def points_of(rows: list[dict[str, str]], element: str) -> np.ndarray:
    chosen = [row for row in rows if row["element"] == element]
    return np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in chosen])


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_mechanism_is_drawn_at_home(atlas: Command, tmp_path: Path, ending: str) -> None:
    output, data = tmp_path / f"m.{ending}", tmp_path / "m.csv"
    atlas("plot", "mechanism", *PENTAPOD, "-o", output, "--data", data)
    assert output.stat().st_size > 5000
    rows = rows_of(data)
    joints = points_of(rows, "joint")
    raised = MACHINE.geometry.platform + np.array([0.0, 0.0, 459.1])
    expected = np.vstack([MACHINE.geometry.base, raised])
    np.testing.assert_allclose(joints, expected, atol=1e-9)
    limbs = points_of(rows, "limb").reshape(5, 2, 3)
    lengths = [float(row["value"]) for row in rows if row["element"] == "limb"][::2]
    np.testing.assert_allclose(np.linalg.norm(limbs[:, 1] - limbs[:, 0], axis=1), lengths)


def test_indices_of_a_pose_are_drawn_with_their_length() -> None:
    figure = spatial_linkage_figure(MACHINE, MACHINE.pose(MACHINE.home))
    said = " ".join(text.get_text() for text in figure.findobj(Text))
    length = f"{MACHINE.characteristic_length:.5g}"
    assert re.search(rf"LCI = .*\$L\$ =\s{length}", said)


def test_coordinate_that_is_solved_for_completes_a_pose(atlas: Command, tmp_path: Path) -> None:
    data = tmp_path / "m.csv"
    pose = ("--pose", "30", "20", "480", "0", "5", "-6", "--solve", "alpha")
    atlas("plot", "mechanism", *PENTAPOD, *pose, "-o", tmp_path / "m.svg", "--data", data)
    limb = points_of(rows_of(data), "joint")[[4, 9]]
    axis = np.diff(points_of(rows_of(data), "revolute axis"), axis=0)[0]
    assert abs((limb[1] - limb[0]) @ axis) < 1e-6


def test_sections_are_drawn_with_their_limits(atlas: Command, tmp_path: Path) -> None:
    data = tmp_path / "w.csv"
    sections = ("--section", "z=430", "--section", "z=500")
    atlas("plot", "workspace", *PENTAPOD, *sections, "-o", tmp_path / "w.png", "--data", data)
    rows = rows_of(data)
    points = points_of(rows, "boundary")
    assert set(points[:, 2]) == {430.0, 500.0}
    assert np.abs(MACHINE.slacks(points, (0.0, 0.0)).min(axis=-1)).max() < 1e-9
    assert {row["curve"] for row in rows} <= {limit.name for limit in MACHINE.limits}


def test_surface_is_drawn_at_an_orientation(atlas: Command, tmp_path: Path) -> None:
    data = tmp_path / "w.csv"
    choice = ("--surface", "--orientation", "8", "-5", "--view", "20", "30")
    atlas("plot", "workspace", *PENTAPOD, *choice, "-o", tmp_path / "w.png", "--data", data)
    points = points_of(rows_of(data), "workspace surface")
    assert len(points) > 3000
    slack = MACHINE.slacks(points, (np.radians(8.0), np.radians(-5.0))).min(axis=-1)
    assert np.mean(np.abs(slack) < 1e-6) > 0.98


def test_same_figure_byte_for_byte(atlas: Command, tmp_path: Path) -> None:
    for kind in (("mechanism",), ("workspace", "--surface")):
        for name in ("one.png", "two.png"):
            atlas("plot", kind[0], *PENTAPOD, *kind[1:], "-o", tmp_path / name, "--overwrite")
        assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("mechanism", "--at", "1", "2"), "--at is for mechanisms that move in a plane"),
        (("mechanism", "--all"), "--all is for mechanisms that move in a plane"),
        (("mechanism", "--solve", "x"), "--solve completes a --pose"),
        (
            ("mechanism", "--pose", "30", "20", "480", "0", "5", "5"),
            "--pose: '30 20 480 0 5 5' is not allowed; expected a pose that the revolute joint "
            "allows: it is 31.1569 mm apart",
        ),
        (
            ("mechanism", "--pose", "0", "0", "459.1", "0", "0", "0", "--solve", "delta"),
            "--solve: 'delta' is not allowed; expected one of x, y, z, alpha, beta, gamma",
        ),
        (("mechanism", "--view", "0", "99"), "--view: '0 99' is not allowed; expected degrees"),
        (("mechanism", "--pose", *["nan"] * 6), "a finite number"),
        (("workspace", "--mode", "home"), "--mode is for mechanisms that move in a plane"),
        (("workspace", "--section", "q=1"), "x, y or z and a value"),
        (("workspace", "--section", "z=up"), "x, y or z and a value"),
        (("workspace", "--section", "z=1", "--section", "x=1"), "sections across one axis only"),
        (("workspace", "--surface", "--section", "z=1"), "exclude each other"),
        (("workspace", "--view", "0", "20"), "--view is for --surface"),
        (("workspace", "--surface", "--orientation", "85", "85"), "there is a workspace"),
        (("workspace", "--orientation", "100", "0"), "there is a workspace"),
    ],
)
def test_what_cannot_be_drawn_is_refused(
    refused: Refused, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    said = refused("plot", arguments[0], *PENTAPOD, *arguments[1:], "-o", tmp_path / "f.png")
    assert message in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", [("--pose", *"123456"), ("--view", "0", "20")])
def test_options_of_space_are_refused_in_the_plane(
    refused: Refused, tmp_path: Path, option: tuple[str, ...]
) -> None:
    said = refused("plot", "mechanism", "1.3", "1.6", "0.1", *option, "-o", tmp_path / "f.png")
    assert f"{option[0]} is for mechanisms that move in space" in said
