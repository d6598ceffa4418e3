"""Solved motions against finite differences, virtual work and a balance of forces."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray
from motions import (
    EXAMPLE,
    PLAIN,
    differences,
    gaps,
    joints,
    named,
    positions,
    smooth_poses,
    turned,
    vectors,
    write_poses,
)

from fivebar_atlas.errors import FileError, FileUsageError, InputError, MotionError
from fivebar_atlas.mechanisms.pentapod import jacobian, kinematics, singularity
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.store import open_atlas
from fivebar_atlas.store.opening import format_of
from fivebar_atlas.trajectories.motion_problem import Trajectory, solve_motion
from fivebar_atlas.trajectories.trajectory_file import (
    FORMAT,
    read_trajectory,
    write_table,
    write_trajectory,
)

MACHINE: dict[str, Any] = {"geometry.r_a": 400.0, "geometry.r_b": 100.0}


@pytest.fixture(scope="module")
def example() -> Trajectory:
    return solve_motion(EXAMPLE)


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    file = tmp_path / "plain.toml"
    file.write_text(PLAIN, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("name", "least", "greatest"),
    [
        ("x", -169.2, 74.5),
        ("y", 0.0, 535.0),
        ("z", 459.1, 580.2),
        ("alpha", 0.0, 52.5),
        ("beta", 0.0, 35.0),
        ("gamma", -39.4, 0.0),
    ],
)
def test_example_sweeps_the_printed_ranges(
    example: Trajectory, name: str, least: float, greatest: float
) -> None:
    values = example.solution[name]
    assert round(float(values.min()), 1) + 0.0 == least
    assert round(float(values.max()), 1) + 0.0 == greatest


def test_example_begins_at_home_and_keeps_the_constraint(example: Trajectory) -> None:
    solution = example.solution
    first = [solution[name][0] for name in ("x", "y", "alpha", "beta", "gamma")]
    np.testing.assert_allclose(first, 0.0, atol=1e-12)
    assert np.abs(gaps(solution)).max() < 1e-10
    assert np.all(solution["Fy"] == 10.0)
    assert np.all(solution["Tz"] == 10.0)


def test_limb_lengths_and_their_derivatives_are_those_of_differences(plain: Path) -> None:
    # the step is such that neither rounding nor the order of differences is seen
    solution = solve_motion(plain, {"motion.samples": 1601}).solution
    step = float(solution.times[1])
    lengths = np.linalg.norm(vectors(solution)[0], axis=-1)
    np.testing.assert_allclose(named("l", solution), lengths, rtol=1e-13)
    first, second = differences(lengths, step)
    inner = slice(3, -3)
    # functions are twice differentiable where pieces meet, and no more
    smooth = np.min(np.abs(solution.times[inner, None] - [1.0, 2.0]), axis=1) > 4.0 * step
    scale = np.abs(first).max(), np.abs(second).max()
    assert np.abs(named("v", solution)[inner] - first)[smooth].max() < 1e-8 * scale[0]
    assert np.abs(named("a", solution)[inner] - second)[smooth].max() < 1e-6 * scale[1]


def test_solved_coordinate_has_the_derivatives_that_the_limbs_show(tmp_path: Path) -> None:
    # in an angle the constraint has two solutions, of which one is followed
    file = tmp_path / "motion.toml"
    text = PLAIN.replace('solve = "y"', 'solve = "alpha"').replace("\nalpha =", "\n#")
    file.write_text(text.replace("gamma = -3.0", "gamma = 0.0\ny = 30.0"), encoding="utf-8")
    solution = solve_motion(file, {"motion.samples": 1601, "motion.start": 5.0}).solution
    assert np.abs(gaps(solution)).max() < 1e-10
    assert np.abs(np.diff(solution["alpha"])).max() < 0.1
    first, second = differences(np.linalg.norm(vectors(solution)[0], axis=-1), solution.times[1])
    far = np.min(np.abs(solution.times[3:-3, None] - [1.0, 2.0]), axis=1) > 0.02
    assert np.abs(named("v", solution)[3:-3] - first)[far].max() < 1e-8 * np.abs(first).max()
    assert np.abs(named("a", solution)[3:-3] - second)[far].max() < 1e-6 * np.abs(second).max()


def test_forces_balance_the_load(example: Trajectory) -> None:
    solution = example.solution
    limbs, arms = vectors(solution)
    directions = limbs / np.linalg.norm(limbs, axis=-1, keepdims=True)
    pushes = named("F", solution)[..., None] * directions
    constraint = solution["F_tau"][:, None] * (turned(solution) @ joints()[2])
    force = pushes.sum(axis=1) + constraint + [0.0, 10.0, -10.0]
    # the constraint force is on a line through A_5
    lever = joints()[0][4] - positions(solution)
    moment = np.cross(arms, pushes).sum(axis=1) + np.cross(lever, constraint) + [10.0, 0.0, 10.0]
    size = np.abs(pushes).max()
    assert np.abs(force).max() < 1e-10 * size
    assert np.abs(moment).max() < 1e-10 * size * 600.0


def test_work_of_the_limbs_is_that_against_the_load(plain: Path) -> None:
    # a force only: its work is F·Δp, whatever the way
    solution = solve_motion(
        plain, {"motion.samples": 2001, "load.moment": [0.0, 0.0, 0.0]}
    ).solution
    power = np.sum(named("F", solution) * named("v", solution), axis=1)
    moved = positions(solution) - positions(solution)[0]
    given = moved @ np.array([0.0, 10.0, -10.0])
    step = solution.times[1]
    work = np.concatenate([[0.0], np.cumsum(0.5 * step * (power[1:] + power[:-1]))])
    np.testing.assert_allclose(work, -given, atol=2e-5 * np.abs(given).max())


def test_loads_at_another_point_and_in_the_axes_of_the_platform(plain: Path) -> None:
    turning = {"load.axes": "platform", "load.point": [10.0, -20.0, 30.0]}
    solution = solve_motion(plain, turning).solution
    rotations = turned(solution)
    force = rotations @ np.array([0.0, 10.0, -10.0])
    arm = rotations @ np.array([10.0, -20.0, 30.0])
    moment = rotations @ np.array([10.0, 0.0, 10.0]) + np.cross(arm, force)
    found = np.column_stack([solution[n] for n in ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")])
    np.testing.assert_allclose(found, np.column_stack([force, moment]), atol=1e-12)


def test_indices_are_those_of_the_core(example: Trajectory) -> None:
    solution = example.solution
    geometry = PentapodGeometry.from_radii(400.0, 100.0)
    angles = np.radians(np.column_stack([solution[n] for n in ("alpha", "beta", "gamma")]))
    poses = np.column_stack([positions(solution), angles])[::50]
    known = singularity.singularity(geometry, poses, 100.0)
    np.testing.assert_allclose(solution["lci"][::50], known.inverse_condition_number, rtol=1e-9)
    least = solution["least_singular_value"][::50]
    np.testing.assert_allclose(least, known.singular_values[:, -1], rtol=1e-9)
    assert np.all(np.sign(known.determinant) == solution.facts["determinant_sign"])
    assert solution.facts["least_lci"] <= solution["lci"].min()


def test_terms_of_the_accelerations_are_those_of_the_hessians() -> None:
    random = np.random.default_rng(7)
    geometry = PentapodGeometry.from_radii(3.0, 1.0, 0.2, axis=[0.3, 0.5, 0.7])
    poses = random.normal(size=(50, 6))
    poses[:, 2] += 5.0
    twists = random.normal(size=(50, 6))
    rotations = kinematics.rotation_matrices(poses[:, 3:])
    limbs = kinematics.limbs(geometry, poses[:, :3], rotations)
    found = jacobian.quadratic_terms_of(geometry, poses[:, :3], rotations, limbs, twists)
    np.testing.assert_allclose(
        found, jacobian.quadratic_terms(geometry, poses, twists), rtol=1e-11, atol=1e-11
    )


def test_sampled_poses_give_what_the_functions_give(tmp_path: Path) -> None:
    columns = smooth_poses(401)
    file = write_poses(tmp_path / "poses.csv", columns)
    solved = solve_motion(file, MACHINE)
    solution = solved.solution
    first, second = differences(np.linalg.norm(vectors(columns)[0], axis=-1), columns["t"][1])
    assert np.abs(named("v", solution)[3:-3] - first).max() < 1e-7 * np.abs(first).max()
    assert np.abs(named("a", solution)[3:-3] - second).max() < 1e-5 * np.abs(second).max()
    # the estimated errors of coordinates are above the true ones
    phase = 2.0 * np.pi / 4.0
    rates = 40.0 * phase * np.cos(phase * columns["t"])
    assert 0.0 < solved.errors["velocity of x"] < 1e-5 * np.abs(rates).max()
    assert solved.errors["acceleration of x"] < 1e-3 * 40.0 * phase**2


def test_sampled_poses_and_a_coordinate_solved_for_are_the_same_motion(tmp_path: Path) -> None:
    columns = smooth_poses(201)
    full = solve_motion(write_poses(tmp_path / "full.csv", columns), MACHINE).solution
    del columns["y"]
    file = write_poses(tmp_path / "five.csv", columns)
    five = solve_motion(file, {**MACHINE, "motion.solve": "y"}).solution
    np.testing.assert_allclose(five["y"], full["y"], atol=1e-10)
    np.testing.assert_allclose(named("l", five), named("l", full), atol=1e-9)
    np.testing.assert_allclose(named("a", five), named("a", full), atol=1e-3)


def test_sampled_loads_balance(tmp_path: Path) -> None:
    columns = smooth_poses(101)
    columns |= {"Fx": np.sin(columns["t"]), "Tz": columns["t"]}
    solution = solve_motion(write_poses(tmp_path / "poses.csv", columns), MACHINE).solution
    np.testing.assert_array_equal(solution["Fx"], columns["Fx"])
    np.testing.assert_array_equal(solution["Tz"], columns["t"])
    limbs, _ = vectors(solution)
    directions = limbs / np.linalg.norm(limbs, axis=-1, keepdims=True)
    constraint = solution["F_tau"][:, None] * (turned(solution) @ joints()[2])
    total = (named("F", solution)[..., None] * directions).sum(axis=1) + constraint
    np.testing.assert_allclose(total[:, 0], -columns["Fx"], atol=1e-11)
    np.testing.assert_allclose(total[:, 1:], 0.0, atol=1e-11)


def test_file_is_opened_by_xarray_with_units(example: Trajectory, tmp_path: Path) -> None:
    file = tmp_path / "motion.h5"
    write_trajectory(example, file, command_line="atlas trajectory")
    with xarray.open_dataset(file, engine="h5netcdf") as data:
        assert dict(data.sizes) == {"t": 1001}
        units = {
            name: data[name].attrs["units"]
            for name in ("x", "beta", "l1", "v2", "a3", "F_tau", "Tx")
        }
        assert list(units.values()) == ["mm", "deg", "mm", "mm/s", "mm/s2", "N", "N mm"]
        for column in example.solution:
            np.testing.assert_array_equal(data[column.name].values, column.values)
            assert data[column.name].attrs["long_name"] == column.long_name
        assert data["t"].attrs["units"] == "s"
    stored = read_trajectory(file)
    assert [column.name for column in stored.columns] == [c.name for c in example.solution]
    assert stored.attributes["command_line"] == "atlas trajectory"
    np.testing.assert_array_equal(stored["F3"], example.solution["F3"])


def test_configuration_in_the_file_gives_the_same_motion(
    example: Trajectory, tmp_path: Path
) -> None:
    file = tmp_path / "again.toml"
    file.write_text(example.configuration, encoding="utf-8")
    again = solve_motion(file).solution
    np.testing.assert_array_equal(again["a4"], example.solution["a4"])


def test_table_can_be_read_again_as_poses(plain: Path, tmp_path: Path) -> None:
    solved = solve_motion(plain)
    table = tmp_path / "table.csv"
    write_table(solved, table)
    header, first, *rest = table.read_text(encoding="utf-8").splitlines()
    assert header.startswith("t_s,x_mm,y_mm,z_mm,alpha_deg,beta_deg,gamma_deg,l1_mm,")
    assert "a1_mm/s2" in header.split(",")
    assert "Tx_N.mm" in header.split(",")
    assert len(first.split(",")) == len(header.split(","))
    assert len(rest) == 200
    # a kink of the third derivative is where samples tell least
    again = solve_motion(table, {**MACHINE, "motion.acceleration_tolerance": 0.3}).solution
    for name in ("l1", "F2", "F_tau", "lci"):
        np.testing.assert_allclose(again[name], solved.solution[name], rtol=1e-9, atol=1e-9)


def test_files_of_trajectories_and_of_atlases_are_told_apart(
    example: Trajectory, tmp_path: Path
) -> None:
    file = tmp_path / "motion.h5"
    write_trajectory(example, file)
    assert format_of(file) == FORMAT
    with pytest.raises(FileError, match="is a trajectory, not an atlas"):
        open_atlas(file)
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as target:
        target.attrs["format"] = "fivebar-atlas"
    assert format_of(other) != FORMAT
    assert format_of(EXAMPLE) == ""
    with pytest.raises(FileError, match="no file written by atlas trajectory"):
        read_trajectory(other)
    with h5py.File(file, "r+") as target:
        del target["F3"]
    with pytest.raises(FileError, match="damaged"):
        read_trajectory(file)
    with h5py.File(file, "r+") as target:
        target.attrs["format_version"] = 99
    with pytest.raises(FileError, match="format version 99"):
        read_trajectory(file)
    with pytest.raises(FileUsageError, match="no such file"):
        read_trajectory(tmp_path / "none.h5")


def test_singular_pose_between_samples_is_found(plain: Path) -> None:
    # with n6 along y the motion crosses det G = 0
    settings = {"geometry.axis": [0.0, 1.0, 0.0], "motion.coordinates.beta": 6.0}
    settings["motion.coordinates.gamma"] = {
        "kind": "stops",
        "times": [0.0, 4.0],
        "values": [0.0, -9.0],
    }
    times = []
    for samples in (60, 600):
        with pytest.raises(
            MotionError, match=r"singular pose at t = .* \(between samples"
        ) as caught:
            solve_motion(plain, {**settings, "motion.samples": samples})
        assert caught.value.time is not None
        times.append(caught.value.time)
    # found where it is, however far samples are apart
    assert times[0] == pytest.approx(times[1], abs=1e-9)


def test_machine_that_is_singular_in_all_poses_is_refused(plain: Path) -> None:
    # four limbs from a line to a line in proportion are lines of one regulus in every pose
    settings: dict[str, Any] = {
        "geometry": {
            "base": [[0, 0, 0], [200, 0, 0], [500, 0, 0], [800, 0, 0], [0, 300, 100]],
            "platform": [[0, 0, 0], [100, 0, 0], [250, 0, 0], [400, 0, 0], [0, 100, 50]],
            "axis": [0.3, 0.5, 0.7],
        }
    }
    with pytest.raises(InputError, match=r"geometry\.base in .* every pose singular"):
        solve_motion(plain, settings)


def test_strokes_say_which_limb_when_and_how_much(example: Trajectory) -> None:
    lengths = named("l", example.solution)
    first = int(np.argmax(lengths[:, 4] > 1000.0))
    limits = {"limits.greatest_length": [1000.0] * 5}
    with pytest.raises(MotionError) as caught:
        solve_motion(EXAMPLE, limits)
    text = str(caught.value)
    assert "limb 5 is longer than its greatest length 1000 mm" in text
    assert f"first at t = {example.solution.times[first]:.6g} s (sample {first})" in text
    assert f"worst {lengths[:, 4].max():.6g} mm" in text
    assert "limb 4" not in text
    assert caught.value.time == example.solution.times[first]
    inside = {"limits.least_length": 400.0, "limits.greatest_length": 1020.0}
    assert solve_motion(EXAMPLE, inside).solution["l5"].max() == lengths[:, 4].max()


def test_joint_limits_say_which_limb_and_when(example: Trajectory) -> None:
    limbs, _ = vectors(example.solution)
    directions = limbs / np.linalg.norm(limbs, axis=-1, keepdims=True)
    own = np.einsum("nkj,nji->nki", directions, turned(example.solution))
    for name, each in (("base", directions), ("platform", own)):
        angles = np.degrees(np.arccos(np.clip(np.sum(each * each[0], axis=-1), -1.0, 1.0)))
        worst = float(angles.max())
        limb = int(np.argmax(angles.max(axis=0))) + 1
        with pytest.raises(MotionError, match=rf"limb {limb} .* in the {name} by more") as caught:
            solve_motion(EXAMPLE, {f"limits.{name}_joint_limit": worst - 1e-3})
        assert f"worst {worst:.6g} deg" in str(caught.value)
        solve_motion(EXAMPLE, {f"limits.{name}_joint_limit": worst + 1e-3})


def test_rounding_in_a_singular_pose_is_shown_as_0(plain: Path) -> None:
    stops = {"kind": "stops", "times": [0, 4], "values": [500, -500]}
    settings = {f"motion.coordinates.{name}": 0.0 for name in ("x", "alpha", "beta", "gamma")}
    with pytest.raises(MotionError, match=r"singular .* x = 0 mm, y = 0 mm, z = 0 mm, alpha"):
        solve_motion(plain, {**settings, "motion.coordinates.z": stops})


@pytest.mark.filterwarnings("error")
def test_limb_without_length_is_named(plain: Path) -> None:
    radii = {"r_a": 100.0, "r_b": 100.0, "position_angle": 0.0}
    settings = {f"motion.coordinates.{name}": 0.0 for name in ("x", "z", "alpha", "beta", "gamma")}
    with pytest.raises(MotionError, match="limb 1 has no length"):
        solve_motion(plain, {**settings, "geometry": radii})


def test_broken_constraint_says_by_how_much_and_what_is_near(tmp_path: Path) -> None:
    columns = smooth_poses(101)
    columns["x"] = columns["x"] + 1.5
    with pytest.raises(MotionError, match="breaks the constraint of limb 5") as caught:
        solve_motion(write_poses(tmp_path / "poses.csv", columns), MACHINE)
    text = str(caught.value)
    assert f"= {gaps(columns)[0]:.6g} mm" in text
    assert f"by {np.abs(gaps(columns)).max():.6g} mm" in text
    shown = text.split("keeps it is ")[1].split(";")[0]
    near = {
        name: np.array([float(value.split()[0])])
        for name, value in (part.split(" = ") for part in shown.split(", "))
    }
    assert abs(gaps(near)[0]) < 1e-4
    # p alone, moved along n6, would keep it at this distance
    moved = np.hypot(near["x"][0] - columns["x"][0], near["y"][0] - columns["y"][0])
    assert moved <= abs(gaps(columns)[0]) + 1e-6
    tolerant = {**MACHINE, "motion.constraint_tolerance": 2.0}
    assert len(solve_motion(tmp_path / "poses.csv", tolerant).solution.times) == 101


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"geometry.axis": [1.0, 0.0, 0.0], "motion.coordinates.beta": 0.0}, "no y keeps the"),
        ({"geometry.axis": [0.0, 0.0, 1.0]}, "no y keeps the constraint"),
    ],
)
def test_coordinate_that_cannot_be_solved_for(
    plain: Path, settings: dict[str, Any], message: str
) -> None:
    still = {"motion.coordinates.gamma": 0.0, "motion.coordinates.alpha": 0.0}
    with pytest.raises(MotionError, match=message):
        solve_motion(plain, {**still, "motion.coordinates.beta": 0.0, **settings})


def test_angle_whose_solutions_meet_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "motion.toml"
    text = PLAIN.replace('solve = "y"', 'solve = "alpha"').replace("\nalpha =", "\n#")
    text = text.replace("\nx =", "\n#").replace("gamma = -3.0", "gamma = 30.0")
    # p moves to above A_5, where no turn about Z makes limb 5 perpendicular to n6
    way = """
x = { kind = "stops", times = [0, 4], values = [0, 283] }
y = { kind = "stops", times = [0, 4], values = [0, -283] }

[load]"""
    file.write_text(text.replace("\n[load]", way), encoding="utf-8")
    with pytest.raises(
        MotionError, match=r"at t = .*no alpha keeps the constraint of limb 5"
    ) as caught:
        solve_motion(file)
    assert caught.value.time is not None
    assert 0.0 < caught.value.time < 4.0
