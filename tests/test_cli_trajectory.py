"""``atlas trajectory`` as a user meets it: what it prints, writes and refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from motions import EXAMPLE, PLAIN, named, smooth_poses, vectors, write_poses

from fivebar_atlas.cli import _exit_code, main
from fivebar_atlas.errors import UnknownNameError
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.trajectory_figure import trajectory_figure
from fivebar_atlas.trajectories.motion_problem import Trajectory, solve_motion
from fivebar_atlas.trajectories.trajectory_file import read_trajectory


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, list(arguments), standalone_mode=False)


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that must be refused; return its message."""
    code = _exit_code(lambda: main(list(arguments), standalone_mode=False))
    shown = capsys.readouterr()
    assert code == 2
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert shown.err.startswith("atlas: error: ")
    return shown.err


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    file = tmp_path / "plain.toml"
    file.write_text(PLAIN, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def example() -> Trajectory:
    return solve_motion(EXAMPLE)


def test_summary_has_ranges_with_units_and_what_is_worst(example: Trajectory) -> None:
    result = run("trajectory", str(EXAMPLE))
    lines = result.output.splitlines()
    assert "lengths in mm, forces in N, moments in N·mm" in lines[2]
    rows = {line.split()[0]: line.split()[1:] for line in lines if line.startswith("  ")}
    assert rows["x"] == ["mm", "-169.2", "4.02", "74.5", "6"]
    assert rows["gamma"][:2] == ["deg", "-39.4"]
    assert rows["a5"][0] == "mm/s²"
    assert rows["Tx"][0] == "N·mm"
    assert set(rows) >= {column.name for column in example.solution}
    forces = named("F", example.solution)
    when, limb = np.unravel_index(int(np.abs(forces).argmax()), forces.shape)
    expected = (
        f"F{limb + 1} = {forces[when, limb]:.6g} N at t = {example.solution.times[when]:.5g} s"
    )
    assert f"largest active force   {expected}" in result.output


def test_motion_in_the_help_can_be_solved(tmp_path: Path) -> None:
    text = run("trajectory", "--help").output
    block = text[text.index("  [geometry]") : text.index("  POSES.csv")]
    file = tmp_path / "motion.toml"
    file.write_text(block, encoding="utf-8")
    assert len(solve_motion(file).solution.times) == 401


def test_json_and_lines_say_the_same(plain: Path, example: Trajectory) -> None:
    document = json.loads(run("trajectory", str(EXAMPLE), "--json").output)
    quantities = {each["name"]: each for each in document["quantities"]}
    for column in example.solution:
        each = quantities[column.name]
        assert each["unit"] == column.unit
        assert each["least"] == column.values.min()
        at = int(np.flatnonzero(example.solution.times == each["greatest_at"])[0])
        assert column.values[at] == each["greatest"] == column.values.max()
    assert document["units"]["moment"] == "N·mm"
    assert document["samples"] == 1001
    assert document["least_lci"] == example.solution.facts["least_lci"]
    assert document["estimated_errors"] == {}
    changed = run("trajectory", str(plain), "--json", "--set", "units.length=m").output
    assert json.loads(changed)["quantities"][0]["unit"] == "m"


def test_settings_win_over_the_file(plain: Path) -> None:
    document = json.loads(
        run(
            "trajectory",
            str(plain),
            *("--set", "motion.samples=51"),
            *("--set", "load.force=[0, 0, -20.5]"),
            *("--set", "motion.solve=y"),
            "--json",
        ).output
    )
    assert document["samples"] == 51
    quantities = {each["name"]: each for each in document["quantities"]}
    assert quantities["Fz"]["least"] == quantities["Fz"]["greatest"] == -20.5


def test_outputs_hold_the_same_numbers(plain: Path, tmp_path: Path) -> None:
    stored, table = tmp_path / "motion.h5", tmp_path / "motion.csv"
    arguments = ["trajectory", str(plain), "-o", str(stored), "--csv", str(table)]
    assert run(*arguments).exception is None
    trajectory = read_trajectory(stored)
    with table.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    values = np.array(rows, dtype=np.float64)
    assert [name.split("_")[0] for name in header[1:6]] == ["x", "y", "z", "alpha", "beta"]
    for number, column in enumerate(trajectory.columns, start=1):
        np.testing.assert_array_equal(values[:, number], column.values)
    np.testing.assert_array_equal(values[:, 0], trajectory.times)
    limbs, _ = vectors(trajectory)
    np.testing.assert_allclose(named("l", trajectory), np.linalg.norm(limbs, axis=-1))


def test_poses_alone_with_a_machine_from_the_command_line(tmp_path: Path) -> None:
    file = write_poses(tmp_path / "poses.csv", smooth_poses(101))
    result = run(
        *("trajectory", str(file), "--set", "geometry.r_a=400", "--set", "geometry.r_b=100")
    )
    assert result.exception is None
    assert "101 samples from t = 0 to 4 s" in result.output
    assert "acceleration of gamma" in result.output


def test_keys_that_a_table_of_poses_cannot_have_are_named_as_they_are_set(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    poses = write_poses(tmp_path / "poses.csv", smooth_poses(101))
    said = refused(capsys, "trajectory", str(poses), "--set", "geometry.r_b=100")
    assert "error: --set geometry.r_a is missing; expected a number, a length" in said
    said = refused(capsys, "trajectory", str(tmp_path / "none.csv"))
    assert "none.csv: there is no such file" in said


def test_info_says_what_a_trajectory_file_is(plain: Path, tmp_path: Path) -> None:
    stored = tmp_path / "motion.h5"
    run("trajectory", str(plain), "-o", str(stored))
    text = run("info", str(stored)).output
    assert "trajectory of a pentapod" in text
    assert "201 samples from t = 0 to 4 s" in text
    assert "limb velocities" in text
    document = json.loads(run("info", str(stored), "--json").output)
    assert document["trajectory_of"] == "pentapod"
    assert document["made"]["format"] == "fivebar-atlas-trajectory"
    assert {each["name"] for each in document["quantities"]} >= {"l1", "F_tau", "lci"}


def test_figure_shows_the_solution_in_six_panels(example: Trajectory) -> None:
    data = PlottedData()
    figure = trajectory_figure(example.solution, "A title", data=data)
    assert len(figure.axes) == 6
    shown = {
        letter: [line.get_label() for line in axes.lines if str(line.get_gid()).startswith("line-")]
        for letter, axes in zip("abcdef", figure.axes, strict=True)
    }
    assert [len(each) for each in shown.values()] == [3, 3, 5, 5, 5, 6]
    assert shown["f"][-1] == r"$F_\tau$"
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert texts[0] == "(a) displacements"
    labels = [text.get_text() for text in figure.texts]
    assert {"displacement (mm)", "angle (deg)", "velocity (mm/s)", "acceleration (mm/s²)"} <= set(
        labels
    )
    assert {"force (N)", "length (mm)", "$t$ (s)", "A title"} <= set(labels)
    parts = {part.element: part for part in data.parts}
    np.testing.assert_array_equal(parts["a3"].points[:, 1], example.solution["a3"])
    np.testing.assert_array_equal(parts["a3"].points[:, 0], example.solution.times)
    for axes in figure.axes:
        assert axes.get_xlim() == (0.0, 10.0)


def test_figure_of_many_samples_keeps_the_extremes() -> None:
    solution = solve_motion(EXAMPLE, {"motion.samples": 9001}).solution
    data = PlottedData()
    trajectory_figure(solution, panels=["f"], data=data)
    assert {part.curve for part in data.parts} == {"panel f"}
    for part in data.parts:
        values = solution[part.element]
        assert len(part.points) < 5000
        assert part.points[:, 1].min() == values.min()
        assert part.points[:, 1].max() == values.max()


def test_figures_are_written_in_all_formats(plain: Path, tmp_path: Path) -> None:
    for ending, start in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")):
        file = tmp_path / f"motion.{ending}"
        data = tmp_path / f"{ending}.csv"
        result = run(
            *("trajectory", str(plain), "--figure", str(file), "--data", str(data)),
            *("--panel", "c", "--panel", "d", "--width", "90", "--title", "Limbs"),
        )
        assert result.exception is None
        assert file.read_bytes().startswith(start)
        rows = data.read_text(encoding="utf-8").splitlines()
        assert rows[0] == "element,part,curve,kind,x_s,y,value"
        assert len(rows) == 1 + 10 * 201


def test_unknown_panel(example: Trajectory) -> None:
    with pytest.raises(UnknownNameError, match="panel: 'z'"):
        trajectory_figure(example.solution, panels=["z"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "geometry.r_d=1"], "geometry.r_d"),
        (["--set", "limits.greatest_length=620"], "is longer than its greatest length 620 mm"),
        (["--set", "geometry"], "is not KEY=VALUE"),
        (["--panel", "a"], "need --figure"),
        (["--figure", "motion.jpg"], "ends in one of .png, .pdf, .svg"),
        (["--figure", "motion.png", "--panel", "g"], "'g'"),
        (["--figure", "motion.png", "--width", "5"], "width"),
        (["-o", "same.h5", "--csv", "same.h5"], "two outputs have the same name"),
        (["-o", "none/motion.h5"], "the folder none does not exist"),
        (["--csv", "plain.toml", "--overwrite"], "is the input"),
        (["--csv", "there.csv"], "exists already"),
    ],
)
def test_wrong_input_is_refused_and_nothing_written(
    plain: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(plain.parent)
    Path("there.csv").write_text("x", encoding="utf-8")
    outputs: list[Any] = [] if {"-o", "--csv"} & set(arguments) else ["-o", "motion.h5"]
    assert message in refused(capsys, "trajectory", "plain.toml", *outputs, *arguments)
    assert sorted(path.name for path in Path().iterdir()) == ["plain.toml", "there.csv"]
    assert Path("plain.toml").read_text(encoding="utf-8") == PLAIN


def test_overwriting_a_table_of_poses_that_is_read_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    poses = write_poses(tmp_path / "poses.csv", smooth_poses(60))
    before = poses.read_bytes()
    motion = tmp_path / "motion.toml"
    motion.write_text('[motion]\nfile = "poses.csv"\n[geometry]\nr_a = 400.0\nr_b = 100.0\n')
    text = refused(capsys, "trajectory", str(motion), "--csv", str(poses), "--overwrite")
    assert "is the input" in text
    assert poses.read_bytes() == before
