"""Motion files: what is read from them, and that each fault is named with its place."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from motions import EXAMPLE, PLAIN, ROOT, smooth_poses, write_poses
from scipy.interpolate import PPoly

from fivebar_atlas.errors import (
    FileUsageError,
    InputError,
    MissingInputError,
    MotionError,
    UnknownNameError,
)
from fivebar_atlas.trajectories import motion_file, smooth_functions
from fivebar_atlas.trajectories.motion_problem import solve_motion
from fivebar_atlas.trajectories.sampled_functions import FEWEST, through_samples
from fivebar_atlas.trajectories.trajectory_file import write_trajectory

MACHINE: dict[str, Any] = {"geometry.r_a": 400.0, "geometry.r_b": 100.0}


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    file = tmp_path / "plain.toml"
    file.write_text(PLAIN, encoding="utf-8")
    return file


def test_polynomials_and_pieces_have_their_values() -> None:
    t = np.linspace(0.0, 2.0, 9)
    polynomial = smooth_functions.polynomial([1.0, -2.0, 0.5, 3.0], 2.0)
    np.testing.assert_allclose(polynomial(t), 1.0 - 2.0 * t + 0.5 * t**2 + 3.0 * t**3)
    pieces = smooth_functions.pieces([0.0, 0.5, 2.0], [[4.0], [1.0, 0.0, 2.0]])
    np.testing.assert_allclose(pieces(t), np.where(t < 0.5, 4.0, 1.0 + 2.0 * (t - 0.5) ** 2))
    np.testing.assert_array_equal(smooth_functions.constant(7.0, 2.0)(t), 7.0)


def test_stops_have_the_least_jerk_and_their_extremes_at_the_points() -> None:
    function = smooth_functions.stops([0.0, 2.0, 3.0], [1.0, 5.0, 4.0])
    share = np.linspace(0.0, 1.0, 21)
    least_jerk = 10.0 * share**3 - 15.0 * share**4 + 6.0 * share**5
    np.testing.assert_allclose(function(2.0 * share), 1.0 + 4.0 * least_jerk, atol=1e-12)
    for order in (1, 2):
        np.testing.assert_allclose(function([0.0, 2.0, 3.0], order), 0.0, atol=1e-12)
    values = function(np.linspace(0.0, 3.0, 3001))
    assert values.max() == pytest.approx(5.0, abs=1e-12)


def test_piecewise_polynomials_are_those_of_scipy() -> None:
    random = np.random.default_rng(11)
    breaks = np.concatenate([[0.0], np.cumsum(random.uniform(0.2, 2.0, 6))])
    table = random.normal(size=(5, 6))
    ours = smooth_functions.PiecewisePolynomial(breaks, table)
    theirs = PPoly(table, breaks)
    times = np.concatenate([breaks, np.linspace(-0.5, breaks[-1] + 0.5, 101)])
    for order in range(6):
        np.testing.assert_allclose(ours(times, order), theirs(times, order), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("degree", smooth_functions.DEGREES)
@pytest.mark.parametrize("ends", ["not-a-knot", "natural", "clamped"])
def test_splines_go_through_their_points(degree: int, ends: Any) -> None:
    times, values = [0.0, 1.0, 1.5, 3.0, 4.0, 4.5, 6.0], [1.0, 3.0, -2.0, 0.0, 1.0, 5.0, 5.0]
    function = smooth_functions.spline(times, values, degree, ends)
    np.testing.assert_allclose(function(times), values, atol=1e-12)
    zero = {"natural": {3: (2,), 5: (3, 4)}, "clamped": {3: (1,), 5: (1, 2)}}
    for order in zero.get(ends, {}).get(degree, ()):
        np.testing.assert_allclose(function([0.0, 6.0], order), 0.0, atol=1e-9)


def test_quintic_through_samples_of_a_quintic_is_it() -> None:
    t = np.linspace(0.0, 3.0, 20)
    found = through_samples(t, (t**5 - 2.0 * t**2)[:, None], ["x"], ["mm"], "s")
    np.testing.assert_allclose(found.spline(t, 2)[:, 0], 20.0 * t**3 - 4.0, atol=1e-8)
    assert found.acceleration_errors[0] < 1e-8
    assert found.velocity_errors[0] < 1e-8


def test_estimates_are_above_the_errors_of_derivatives() -> None:
    for count in (25, 60, 150, 400):
        t = np.linspace(0.0, 4.0, count)
        values = np.column_stack([np.sin(2.0 * t), np.exp(-t)])
        found = through_samples(t, values, ["x", "y"], ["mm", "mm"], "s", 0.5)
        true = np.column_stack([-4.0 * np.sin(2.0 * t), np.exp(-t)])
        assert np.all(np.abs(found.spline(t, 2) - true).max(axis=0) < found.acceleration_errors)


@pytest.mark.parametrize(
    ("function", "what", "time", "from_to"),
    [
        (smooth_functions.pieces([0.0, 1.0, 4.0], [[0.0, 2.0], [3.0]]), "value", 1.0, (2, 3)),
        (smooth_functions.pieces([0.0, 1.0, 4.0], [[0.0, 2.0], [2.0]]), "velocity", 1.0, (2, 0)),
        (
            smooth_functions.pieces([0.0, 2.0, 4.0], [[0.0, 0.0, 1.0], [4.0, 4.0]]),
            "acceleration",
            2.0,
            (2, 0),
        ),
        (smooth_functions.spline([0.0, 3.0, 4.0], [0.0, 6.0, 0.0], 1), "velocity", 3.0, (2, -6)),
    ],
)
def test_functions_without_accelerations_say_where_they_break(
    function: Any, what: str, time: float, from_to: tuple[float, float]
) -> None:
    with pytest.raises(MotionError) as caught:
        smooth_functions.check_smooth("x", function, 4.0, "mm", "s")
    assert f"its {what} jumps from {from_to[0]} to {from_to[1]} mm" in str(caught.value)
    assert caught.value.time == time
    # after the end of the motion it does not matter
    smooth_functions.check_smooth("x", function, time, "mm", "s")


def test_smooth_functions_are_taken() -> None:
    random = np.random.default_rng(3)
    for _ in range(50):
        times = np.concatenate([[0.0], np.cumsum(random.uniform(0.05, 3.0, 9))])
        values = random.normal(size=10) * 10.0 ** random.integers(-3, 4)
        for function in (
            smooth_functions.spline(list(times), list(values), 3),
            smooth_functions.spline(list(times), list(values), 5, "natural"),
            smooth_functions.stops(list(times), list(values)),
        ):
            smooth_functions.check_smooth("x", function, float(times[-1]), "mm", "s")


@pytest.mark.parametrize(
    ("settings", "kind", "message"),
    [
        ({"geometry.r_c": 1.0}, UnknownNameError, r"geometry\.r_c in .*did you mean 'r_"),
        ({"geometry": {"r_a": 400.0}}, MissingInputError, r"geometry\.r_b in .* is missing"),
        ({"geometry.r_a": "4"}, InputError, r"geometry\.r_a in .*'4'.*a number"),
        ({"geometry.r_a": -4.0}, InputError, r"geometry\.r_a in .*-4\.0.*above 0"),
        ({"geometry.base": [[0, 0, 0]]}, InputError, r"geometry\.r_a in .*not both"),
        ({"geometry.axis": [1, 2]}, InputError, r"geometry\.axis in .*three numbers"),
        ({"geometry.base_angle": 0.0}, InputError, "joints A_1 and A_2 in different places"),
        (
            {"geometry": {"base": [[0, 0, 0]] * 5, "platform": [[0, 0, 0]] * 5}},
            MissingInputError,
            r"geometry\.axis in .* is missing",
        ),
        (
            {"geometry": {"base": [[0, 0, 0]] * 5, "platform": [[0, 0]] * 5, "axis": [1, 0, 0]}},
            InputError,
            r"geometry\.platform in .*five lists of three",
        ),
        ({"mechanism": "five-bar"}, InputError, "mechanism in .*whose platform moves in space"),
        ({"mechanism": "pentapods"}, UnknownNameError, "did you mean 'pentapod'"),
        ({"characteristic_length": 0.0}, InputError, "characteristic_length in .*above 0"),
        (
            {"characteristic_length": 1e9},
            InputError,
            r"characteristic_length in .*to 1e\+08",
        ),
        ({"motion.coordinates.x": 1e200}, InputError, r"coordinates\.x in .*up to 1e\+30"),
        ({"load.force": [0, 1e308, 0]}, InputError, r"load\.force\.1 in .*up to 1e\+30"),
        ({"motion.duration": 1e-300}, InputError, r"motion\.duration in .*above 0"),
        ({"units.lengths": "m"}, UnknownNameError, r"units\.lengths in .*'length'"),
        ({"units.length": ""}, InputError, r"units\.length in .*name of a unit"),
        ({"motion.duration": 0.0}, InputError, r"motion\.duration in .*above 0"),
        ({"motion.duration": math.inf}, InputError, r"motion\.duration in .*a finite number"),
        ({"motion.samples": 1}, InputError, r"motion\.samples in .*from 2 to"),
        ({"motion.samples": 2.5}, InputError, r"motion\.samples in .*an integer"),
        ({"motion.solve": "w"}, UnknownNameError, r"motion\.solve in .*one of x, y, z"),
        ({"motion.solve": "x"}, InputError, r"motion\.coordinates\.x in .*solved for"),
        ({"motion.coordinates.w": 1.0}, UnknownNameError, r"motion\.coordinates\.w in"),
        ({"motion.coordinates.x": "1"}, InputError, r"motion\.coordinates\.x in .*table with a"),
        ({"motion.coordinates.x": math.nan}, InputError, r"coordinates\.x in .*a finite number"),
        ({"motion.coordinates.x": {}}, MissingInputError, r"coordinates\.x\.kind in .*missing"),
        ({"motion.coordinates.x": {"kind": "line"}}, UnknownNameError, r"x\.kind in .*'line'"),
        ({"motion.coordinates.x.degree": 3}, UnknownNameError, r"x\.degree in .*coefficients"),
        ({"motion.coordinates.x.coefficients": []}, InputError, r"x\.coefficients in .*at least"),
        ({"motion.coordinates.x.coefficients": ["a"]}, InputError, r"x\.coefficients\.0 in"),
        ({"motion.coordinates.z.times": [0, 2]}, InputError, r"z\.values in .*as many.*2"),
        ({"motion.coordinates.z.times": [0, 4, 2]}, InputError, r"z\.times in .*2 does not come"),
        ({"motion.coordinates.z.times": [0, 2, 3]}, InputError, r"z in .*from 0 to the duration"),
        ({"motion.coordinates.beta.degree": 4}, InputError, r"beta\.degree in .*1, 2, 3, 5"),
        ({"motion.coordinates.beta.ends": "free"}, InputError, r"beta\.ends in .*natural"),
        (
            {"motion.coordinates.alpha.ends": "not-a-knot"},
            InputError,
            r"alpha\.times in .*at least 6",
        ),
        ({"motion.coordinates.beta.degree": 1}, MotionError, "beta is not smooth enough"),
        ({"load.force": [1.0]}, InputError, r"load\.force in .*three components"),
        ({"load.force": [1.0, True, 0.0]}, InputError, r"load\.force\.1 in"),
        ({"load.point": [1.0]}, InputError, r"load\.point in .*three coordinates"),
        ({"load.axes": "world"}, InputError, r"load\.axes in .*'base' or 'platform'"),
        ({"limits.least_length": [1.0, 2.0]}, InputError, r"limits\.least_length in .*list of 5"),
        ({"limits.least_length": -1.0}, InputError, r"limits\.least_length in .*from 0"),
        (
            {"limits.least_length": 2.0, "limits.greatest_length": 1.0},
            InputError,
            r"limits\.least_length in .*1 of limb 1",
        ),
        ({"limits.base_joint_limit": 200.0}, InputError, r"base_joint_limit in .*180 degrees"),
        ({"motion.constraint_tolerance": 0.0}, InputError, r"constraint_tolerance in .*above 0"),
    ],
)
def test_faults_are_named_by_their_keys(
    plain: Path, settings: dict[str, Any], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        solve_motion(plain, settings)


def test_missing_coordinate_duration_and_motion(plain: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    for line, message in (
        ("gamma = -3.0", r"motion\.coordinates\.gamma in .* is missing"),
        ("duration = 4.0", r"motion\.duration in .* is missing"),
    ):
        other.write_text(PLAIN.replace(line, ""), encoding="utf-8")
        with pytest.raises(MissingInputError, match=message):
            solve_motion(other)
    other.write_text("[geometry]\nr_a = 1.0\n", encoding="utf-8")
    with pytest.raises(MissingInputError, match=r"motion in .* is missing"):
        solve_motion(other)
    assert solve_motion(plain).solution.times[-1] == 4.0


def test_files_that_are_none(tmp_path: Path) -> None:
    for name in ("none.toml", "none.csv"):
        with pytest.raises(FileUsageError, match="no such file"):
            solve_motion(tmp_path / name, MACHINE)
    text = tmp_path / "text.toml"
    text.write_text("a = ", encoding="utf-8")
    with pytest.raises(FileUsageError, match="is not TOML"):
        solve_motion(text)
    text.write_bytes(b"\xff")
    with pytest.raises(FileUsageError, match="is not TOML"):
        solve_motion(text)
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(FileUsageError, match="is a folder"):
        solve_motion(tmp_path / "folder.toml")
    with pytest.raises(FileUsageError, match=r"neither a \.toml"):
        solve_motion(tmp_path / "motion.txt")


def test_settings_are_put_into_tables_and_back_as_toml(plain: Path) -> None:
    settings = {"geometry.axis": [0.0, 1.0, 0.5], "load.point": [1, 2, 3], "mechanism": "pentapod"}
    settings["motion.coordinates.x"] = {"kind": "polynomial", "coefficients": [1.0]}
    _, values = motion_file.read_motion_file(plain, settings)
    text = motion_file.rendered(values)
    again = plain.with_name("again.toml")
    again.write_text(text, encoding="utf-8")
    assert motion_file.read_motion_file(again, {})[1] == values
    assert values["geometry"]["axis"] == [0.0, 1.0, 0.5]
    with pytest.raises(InputError, match="a key of a table; samples is a value"):
        motion_file.read_motion_file(plain, {"motion.samples.more": 1})


def test_poses_with_units_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    columns = smooth_poses(40)
    file = write_poses(tmp_path / "poses.csv", columns)
    known = solve_motion(file, MACHINE).solution
    names = {name: f"{name}_{'deg' if len(name) > 1 else 'mm'}" for name in columns} | {"t": "T_s"}
    header = ";".join(names[name] for name in columns)
    lines = file.read_text(encoding="utf-8").splitlines()[1:]
    rows = [line.replace(",", ";").replace(".", ",") for line in lines]
    other = tmp_path / "other.csv"
    other.write_text("\n".join(["note;" + header, *("a;" + row for row in rows)]), encoding="utf-8")
    found = solve_motion(other, MACHINE).solution
    np.testing.assert_array_equal(found["a3"], known["a3"])
    # named in a motion file, from its folder
    motion = tmp_path / "motion.toml"
    motion.write_text('[motion]\nfile = "other.csv"\n', encoding="utf-8")
    np.testing.assert_array_equal(solve_motion(motion, MACHINE).solution["a3"], known["a3"])


def test_angles_may_go_on_after_a_turn(tmp_path: Path) -> None:
    columns = smooth_poses(40)
    known = solve_motion(write_poses(tmp_path / "poses.csv", columns), MACHINE).solution
    columns["alpha"] = np.where(columns["alpha"] < 0.0, columns["alpha"] + 360.0, columns["alpha"])
    found = solve_motion(write_poses(tmp_path / "turned.csv", columns), MACHINE).solution
    np.testing.assert_allclose(found["a3"], known["a3"], atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gamma": None}, "has no column gamma or gamma_deg; its columns are t, x"),
        ({"gamma": "gamma_rad"}, "has no column gamma or gamma_deg"),
        ({"x": "z_mm"}, "has no column x"),
        ({"alpha": "x_mm"}, "more than one column x"),
    ],
)
def test_missing_columns_are_named(
    tmp_path: Path, change: dict[str, str | None], message: str
) -> None:
    columns = {}
    for name, values in smooth_poses(20).items():
        other = change.get(name, name)
        if other is not None:
            columns[other] = values
    with pytest.raises(FileUsageError, match=message):
        solve_motion(write_poses(tmp_path / "poses.csv", columns), MACHINE)


def test_faults_of_tables_have_row_and_column(tmp_path: Path) -> None:
    columns = smooth_poses(20)
    file = write_poses(tmp_path / "poses.csv", columns)
    lines = file.read_text(encoding="utf-8").splitlines()
    bad = tmp_path / "bad.csv"
    for cell, fault in (
        ("", "there is no number"),
        ("a", "'a' is not a number"),
        ("inf", "finite"),
    ):
        cells = lines[5].split(",")
        cells[2] = cell
        text = "\n".join([*lines[:5], ",".join(cells), *lines[6:]])
        bad.write_text(text, encoding="utf-8")
        with pytest.raises(FileUsageError, match=rf"row 5 \(line 6\), column z: .*{fault}"):
            solve_motion(bad, MACHINE)
    bad.write_text("\n".join([*lines[:7], lines[5], *lines[7:]]), encoding="utf-8")
    with pytest.raises(FileUsageError, match=r"row 7 \(line 8\), column t: the time .* after"):
        solve_motion(bad, MACHINE)
    bad.write_text(lines[0], encoding="utf-8")
    with pytest.raises(FileUsageError, match="no poses below its header"):
        solve_motion(bad, MACHINE)


def test_motions_that_are_too_short_or_jump(tmp_path: Path) -> None:
    short = write_poses(tmp_path / "short.csv", smooth_poses(FEWEST - 1))
    with pytest.raises(MotionError, match=f"has {FEWEST - 1} samples.* at least {FEWEST}"):
        solve_motion(short, MACHINE)
    columns = smooth_poses(101)
    del columns["y"]
    solve = {**MACHINE, "motion.solve": "y"}
    assert solve_motion(write_poses(tmp_path / "good.csv", columns), solve).solution["l1"].size
    for name, change in (
        ("jump", np.where(columns["t"] > 2.01, 3.0, 0.0)),
        ("kink", 20.0 * np.abs(columns["t"] - 2.01)),
    ):
        bad = {**columns, "x": columns["x"] + change}
        with pytest.raises(MotionError, match=r"x is not smooth enough") as caught:
            solve_motion(write_poses(tmp_path / f"{name}.csv", bad), solve)
        assert caught.value.time == pytest.approx(2.01, abs=0.1)
    digits = write_poses(tmp_path / "digits.csv", columns, "%.2f")
    with pytest.raises(MotionError, match="not smooth enough, or has too few samples or digits"):
        solve_motion(digits, solve)


def test_table_and_functions_exclude_each_other(tmp_path: Path) -> None:
    columns = smooth_poses(60)
    columns["Fx"] = columns["t"]
    file = write_poses(tmp_path / "poses.csv", columns)
    for settings, message in (
        ({"motion.duration": 4.0}, r"motion\.duration.*its times count"),
        ({"motion.samples": 4}, r"motion\.samples.*its times count"),
        ({"motion.coordinates.x": 4.0}, r"motion\.coordinates.*no functions"),
        ({"load.force": [1.0, 0.0, 0.0]}, r"load\.force.*has columns of the load"),
    ):
        with pytest.raises(InputError, match=message):
            solve_motion(file, {**MACHINE, **settings})
    columns["Fx_kN"] = columns.pop("Fx")
    with pytest.raises(FileUsageError, match="has the column Fx_kN; expected Fx or Fx_N"):
        solve_motion(write_poses(tmp_path / "other.csv", columns), MACHINE)


PAGE = (ROOT / "docs" / "trajectory.md").read_text(encoding="utf-8")


def rows_of(heading: str) -> list[list[str]]:
    """Return the cells of a table of the page, by the first cell of its header."""
    lines = PAGE.split(f"| {heading} |", 1)[1].split("\n")[2:]
    cells = []
    for line in lines:
        if not line.startswith("|"):
            break
        cells.append([cell.strip() for cell in line.strip("|").split("|")])
    return cells


def test_page_lists_every_key_and_only_those() -> None:
    keys = set()
    for name, field in motion_file.MotionFile.model_fields.items():
        inner = getattr(field.annotation, "model_fields", None)
        keys |= {name} if inner is None else {f"{name}.{key}" for key in inner}
    assert {row[0].strip("`") for row in rows_of("key")} == keys


def test_example_of_the_page_can_be_solved(tmp_path: Path) -> None:
    (text,) = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    file = tmp_path / "motion.toml"
    file.write_text(text, encoding="utf-8")
    solution = solve_motion(file).solution
    assert len(solution.times) == 401
    np.testing.assert_allclose(solution["Tz"], 10.0 + 2.0 * solution.times)


def test_page_lists_every_dataset_and_attribute(tmp_path: Path) -> None:
    solved = solve_motion(EXAMPLE)
    write_trajectory(solved, tmp_path / "motion.h5")
    described = {
        name.strip("` "): unit for names, unit, _ in rows_of("dataset") for name in names.split(",")
    }
    with h5py.File(tmp_path / "motion.h5") as file:
        assert {name: each.attrs["units"] for name, each in file.items()} == described
        assert {row[0].strip("`") for row in rows_of("attribute of the root")} == set(file.attrs)


def test_page_gives_the_limb_lengths_of_the_example() -> None:
    solution = solve_motion(EXAMPLE).solution
    rows = rows_of("| printed")
    assert len(rows) == 5
    for limb, (_, _, shown) in enumerate(rows, start=1):
        values = solution[f"l{limb}"]
        assert shown == f"{values.min():.1f} to {values.max():.1f}"
