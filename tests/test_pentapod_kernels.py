"""Kernels of the pentapod's atlas against NumPy and against the mechanism's own functions."""

from __future__ import annotations

import concurrent.futures
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.pentapod import evaluation, sampling
from fivebar_atlas.mechanisms.pentapod.atlas_options import AtlasOptions, home_pose
from fivebar_atlas.mechanisms.pentapod.conditioning import (
    add_pose,
    find_singular_values,
    largest_limb_force,
)
from fivebar_atlas.mechanisms.pentapod.determinant_along import determinant_at
from fivebar_atlas.mechanisms.pentapod.drawn_lines import (
    diamond_angle,
    direction_of,
    draw_line,
)
from fivebar_atlas.mechanisms.pentapod.fibre import (
    NOTHING,
    ONLY_SINGULAR,
    SOMETHING_SINGULAR,
    find_through,
)
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.integration import HITS, SHARE, SUMS, integrate
from fivebar_atlas.mechanisms.pentapod.jacobian import jacobian, without_unit
from fivebar_atlas.mechanisms.pentapod.kinematics import (
    constraint_residual,
    inverse_displacement,
    solve_constraint,
)
from fivebar_atlas.mechanisms.pentapod.limits_along import inside_cone, inside_sphere
from fivebar_atlas.mechanisms.pentapod.pose import set_orientation, set_position, solve_alpha
from fivebar_atlas.mechanisms.pentapod.rotations import rotation_matrices
from fivebar_atlas.numerics.extreme_eigenvalues import (
    EIGENVALUES,
    LANES,
    find_extreme_eigenvalues,
)
from fivebar_atlas.numerics.interval_sets import (
    INTERVALS,
    nearest_point,
    point_at,
    remove_interval,
    set_interval,
    total_length,
)
from fivebar_atlas.numerics.records import allocate_record

Array = npt.NDArray[np.float64]


def options(**given: object) -> AtlasOptions:
    return AtlasOptions.chosen(mechanisms.get("pentapod").complete_options(given))


def random_designs(count: int, seed: int) -> list[tuple[float, float, AtlasOptions]]:
    """Return designs of many geometries and limits."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        chosen = options(
            axis_angle=random.uniform(-70.0, 70.0),
            position_angle=random.uniform(-60.0, 60.0),
            offset=random.choice([-1.0, 1.0]) * random.uniform(0.5, 1.5),
            base_joint_limit=random.uniform(10.0, 120.0),
            platform_joint_limit=random.uniform(10.0, 120.0),
            limb_min=random.uniform(0.7, 0.98),
            limb_max=random.uniform(1.02, 1.3),
            alpha_min=random.uniform(-180.0, -10.0),
            alpha_max=random.uniform(10.0, 180.0),
        )
        r_a, r_b = 0.1 + 2.0 * random.random(2)
        found.append((r_a, r_b, chosen))
    return found


def random_poses(chosen: AtlasOptions, count: int, seed: int) -> Array:
    least, greatest = np.array(chosen.box_least), np.array(chosen.box_greatest)
    return least + np.random.default_rng(seed).random((count, 6)) * (greatest - least)


def scaled_jacobian(
    geometry: PentapodGeometry, pose: Array, chosen: AtlasOptions, r_b: float
) -> Array:
    return without_unit(jacobian(geometry, pose), chosen.length(r_b))


def trigonometry(pose: Array) -> tuple[float, ...]:
    """Return sines and cosines of α, β and γ in the order of kernels."""
    return tuple(float(f(angle)) for angle in pose[3:] for f in (math.sin, math.cos))


def with_alpha(w: Any, pose: Array) -> Array | None:
    """Return a pose with the α that the kernel finds, None where it finds none."""
    _, _, sb, cb, sg, cg = trigonometry(pose)
    sine, cosine, exists = solve_alpha(w.fibre.design, *pose[:3], sb, cb, sg, cg)
    return np.array([*pose[:3], math.atan2(sine, cosine), *pose[4:]]) if exists else None


def usable_by_definition(
    geometry: PentapodGeometry, pose: Array, chosen: AtlasOptions, slack: float
) -> tuple[bool, bool]:
    """Return if a pose with α is usable but for det G, with limits wider by a slack."""
    home = inverse_displacement(geometry, home_pose())
    now = inverse_displacement(geometry, pose)
    turned = now.directions @ rotation_matrices(pose[3:])
    fits = bool(
        np.all(pose[:3] >= np.array(chosen.box_least[:3]) - slack)
        and np.all(pose[:3] <= np.array(chosen.box_greatest[:3]) + slack)
        and np.all(now.lengths >= chosen.limb_min * home.lengths - slack)
        and np.all(now.lengths <= chosen.limb_max * home.lengths + slack)
    )
    for directions, limit in (
        (now.directions, chosen.base_joint_limit),
        (turned, chosen.platform_joint_limit),
    ):
        cosines = np.sum(directions * home.directions, axis=1)
        fits &= bool(np.all(cosines >= math.cos(limit) - slack))
    signs = np.sign(np.linalg.det(jacobian(geometry, np.stack([pose, home_pose()]))))
    return fits, bool(signs[0] == signs[1])


def test_extreme_eigenvalues_are_those_of_numpy() -> None:
    random = np.random.default_rng(1)
    matrices = random.normal(size=(LANES, 6, 6)) * np.exp(random.normal(size=(LANES, 1, 6)))
    matrices[0] = 0.0
    matrices[1] = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    matrices[2] = np.eye(6)  # one eigenvalue only
    matrices[3] = np.linalg.qr(matrices[4])[0] @ np.diag([1.0, 1.0, 2.0, 3.0, 7.0, 7.0])
    matrices[5, :, 5] = matrices[5, :, 4]  # singular
    squares = np.swapaxes(matrices, 1, 2) @ matrices
    w = allocate_record(EIGENVALUES)
    w.matrix[:] = np.moveaxis(squares, 0, -1)
    find_extreme_eigenvalues(w, LANES)
    exact = np.linalg.eigvalsh(squares)
    scale = 1e-14 * exact[:, -1] + 1e-300
    # double ones converge slowly, and where they do rounding is the square root of it
    scale[2:4] = 1e-7
    assert np.all(np.abs(w.least - exact[:, 0]) <= scale)
    assert np.all(np.abs(w.greatest - exact[:, -1]) <= scale)


def test_eigenvalues_do_not_depend_on_lanes_that_hold_nothing() -> None:
    random = np.random.default_rng(2)
    matrix = random.normal(size=(6, 6, LANES))
    found = []
    for rest in (0.0, 1e3, math.nan):
        w = allocate_record(EIGENVALUES)
        squares = np.einsum("ijk,ilk->jlk", matrix, matrix)
        squares[:, :, 5:] *= rest
        w.matrix[:] = squares
        find_extreme_eigenvalues(w, 5)
        found.append(np.concatenate([w.least[:5], w.greatest[:5]]).tobytes())
    assert len(set(found)) == 1


@pytest.mark.nojit
def test_intervals_are_what_is_left_of_a_line() -> None:
    random = np.random.default_rng(3)
    for _ in range(200):
        s = allocate_record(INTERVALS)
        set_interval(s, 0.0, 1.0)
        x = (np.arange(2000) + 0.5) / 2000
        kept = np.ones(len(x), dtype=bool)
        for _ in range(random.integers(0, 12)):
            a = random.uniform(-0.1, 1.1)
            b = a + random.uniform(-0.05, 0.2)
            remove_interval(s, a, b)
            kept &= ~((x > a) & (x < b))
        n = int(s.count[0])
        starts, stops = s.start[:n], s.stop[:n]
        assert np.all(starts <= stops)
        assert np.all(stops[:-1] <= starts[1:])
        inside = np.any((x[:, None] >= starts) & (x[:, None] <= stops), axis=1)
        assert np.array_equal(inside, kept)
        if n:
            length = total_length(s)
            assert length == pytest.approx(np.sum(stops - starts))
            shares = random.random(5) * length
            below = [np.sum(np.clip(point_at(s, u) - starts, 0.0, stops - starts)) for u in shares]
            assert below == pytest.approx(shares)
            for x0 in random.uniform(-0.5, 1.5, 5):
                found = nearest_point(s, x0)
                distances = np.maximum(np.maximum(starts - x0, x0 - stops), 0.0)
                assert abs(found - x0) == pytest.approx(distances.min(), abs=1e-15)


@pytest.mark.nojit
def test_removing_the_ends_of_a_point_leaves_it() -> None:
    s = allocate_record(INTERVALS)
    set_interval(s, 1.0, 1.0)
    remove_interval(s, 0.0, 1.0)
    remove_interval(s, 1.0, 2.0)
    assert (s.count[0], s.start[0], s.stop[0]) == (1, 1.0, 1.0)
    remove_interval(s, 0.5, 1.5)
    assert s.count[0] == 0
    set_interval(s, 1.0, 0.0)
    assert s.count[0] == 0


@pytest.mark.nojit
def test_limits_along_a_line_are_where_the_limb_keeps_them() -> None:
    random = np.random.default_rng(4)
    t = np.linspace(-6.0, 6.0, 1201)
    for trial in range(400):
        limb, d, m = random.normal(size=(3, 3))
        d /= np.linalg.norm(d)
        m = d if trial % 20 == 0 else m / np.linalg.norm(m)
        cosine = float(random.choice([random.random(), 1e-17, abs(d @ m)]))
        vectors = limb + t[:, None] * d
        lengths = np.linalg.norm(vectors, axis=1)
        along, square = float(limb @ d), float(limb @ limb)
        radius = random.uniform(0.2, 4.0)
        low, high = inside_sphere(along, square, radius**2)
        clear = np.abs(lengths - radius) > 1e-9
        assert np.array_equal(((t >= low) & (t <= high))[clear], (lengths < radius)[clear])
        low, high = inside_cone(along, square, float(limb @ m), float(d @ m), cosine)
        cosines = vectors @ m / lengths
        clear = np.abs(cosines - cosine) > 1e-7
        assert np.array_equal(((t >= low) & (t <= high))[clear], (cosines > cosine)[clear])


@pytest.mark.nojit
def test_diamond_angles_rise_with_the_angle() -> None:
    angles = np.linspace(-math.pi + 1e-9, math.pi - 1e-9, 1001)
    found = np.array([diamond_angle(math.sin(a), math.cos(a)) for a in angles])
    assert np.all(np.diff(found) > 0.0)
    assert (found[0], found[-1]) == pytest.approx((-2.0, 2.0), abs=1e-8)
    for angle, diamond in zip(angles[5:-5], found[5:-5], strict=True):
        sine, cosine, slope = direction_of(diamond)
        assert (sine, cosine) == pytest.approx((math.sin(angle), math.cos(angle)), abs=1e-12)
        if min(abs(diamond % 1.0), 1.0 - abs(diamond % 1.0)) > 1e-3:
            ends = [math.atan2(*direction_of(diamond + h)[:2]) for h in (-1e-6, 1e-6)]
            assert slope == pytest.approx((ends[1] - ends[0]) / 2e-6, rel=1e-7)


@pytest.mark.nojit
def test_poses_are_those_of_the_mechanism() -> None:
    for n, (r_a, r_b, chosen) in enumerate(random_designs(20, 5)):
        w = evaluation.work_space()
        assert evaluation.set_design(w, r_a, r_b, chosen)
        geometry = chosen.geometry(r_a, r_b)
        assert with_alpha(w, home_pose()) == pytest.approx(home_pose(), abs=1e-13)
        for given in random_poses(chosen, 5, n):
            solutions = solve_constraint(geometry, given, "alpha")
            pose = with_alpha(w, given)
            assert (pose is not None) == bool(solutions.count > 0)
            if pose is None:
                continue
            slack = 1e-12 * geometry.size
            assert constraint_residual(geometry, pose) == pytest.approx(0.0, abs=slack)
            turned = solutions.poses[:, 3] - pose[3]
            assert np.min(np.abs(np.sin(0.5 * turned))) == pytest.approx(0.0, abs=1e-7)
            step = np.array([0.0, 0.0, 0.0, 1e-6, 0.0, 0.0])
            ends = np.stack([pose - step, pose + step, home_pose() - step, home_pose() + step])
            residuals = constraint_residual(geometry, ends)
            assert (residuals[1] > residuals[0]) == (residuals[3] > residuals[2])
            set_orientation(w.fibre.pose, w.fibre.design, *trigonometry(pose))
            set_position(w.fibre.pose, w.fibre.design, *pose[:3])
            limbs = inverse_displacement(geometry, pose)
            vectors = limbs.directions * limbs.lengths[:, None]
            assert w.fibre.pose.rotation == pytest.approx(rotation_matrices(pose[3:]), abs=1e-14)
            assert w.fibre.pose.arms == pytest.approx(limbs.arms, abs=1e-13)
            assert w.fibre.pose.vectors == pytest.approx(vectors, abs=1e-13)


@pytest.mark.nojit
def test_the_determinant_is_that_of_g_and_cubic_along_lines() -> None:
    random = np.random.default_rng(6)
    ways = np.array([-1.3, -0.4, 0.2, 0.9, 1.7])
    for n, (r_a, r_b, chosen) in enumerate(random_designs(20, 6)):
        w = evaluation.work_space()
        assert evaluation.set_design(w, r_a, r_b, chosen)
        geometry = chosen.geometry(r_a, r_b)
        poses = [with_alpha(w, each) for each in random_poses(chosen, 8, n)]
        ratios = []
        for pose in poses:
            if pose is None:
                continue
            set_orientation(w.fibre.pose, w.fibre.design, *trigonometry(pose))
            set_position(w.fibre.pose, w.fibre.design, *pose[:3])
            # a direction in the plane across n6 keeps the constraint
            d = np.cross(rotation_matrices(pose[3:]) @ geometry.axis, random.normal(size=3))
            d /= np.linalg.norm(d)
            values = np.array([determinant_at(w.fibre.design, w.fibre.pose, d, t) for t in ways])
            moved = pose + ways[:, None] * np.concatenate([d, np.zeros(3)])
            limbs = inverse_displacement(geometry, moved)
            exact = np.linalg.det(jacobian(geometry, moved)) * np.prod(limbs.lengths, axis=1)
            # |l_5| det [u·l_i / |l_5|, ...] with u = n6 x l_5 is what the kernel has
            size = np.abs(exact).max()
            ratios.append(values @ exact / (exact @ exact))
            assert values == pytest.approx(ratios[-1] * exact, abs=1e-11 * size)
            fitted = np.polynomial.Polynomial.fit(ways[:4], values[:4], 3)
            assert fitted(ways[4]) == pytest.approx(values[4], abs=1e-11 * size)
        assert np.abs(ratios) == pytest.approx(1.0, abs=1e-9)
        assert len({math.copysign(1.0, ratio) for ratio in ratios}) == 1


def test_singular_values_and_forces_are_those_of_numpy() -> None:
    for n, (r_a, r_b, chosen) in enumerate(random_designs(10, 7)):
        w = evaluation.work_space()
        assert evaluation.set_design(w, r_a, r_b, chosen)
        geometry = chosen.geometry(r_a, r_b)
        w.poses.count[0] = 0
        kept = []
        for pose in (with_alpha(w, each) for each in random_poses(chosen, LANES, n)):
            if pose is not None:
                set_orientation(w.fibre.pose, w.fibre.design, *trigonometry(pose))
                set_position(w.fibre.pose, w.fibre.design, *pose[:3])
                add_pose(w.poses, w.fibre, 0.0, pose[4], pose[5], 1.0)
                kept.append(scaled_jacobian(geometry, pose, chosen, r_b))
        find_singular_values(w.poses)
        count = len(kept)
        assert w.poses.count[0] == count
        assert np.moveaxis(w.poses.g[:, :, :count], -1, 0) == pytest.approx(
            np.array(kept), abs=1e-12
        )
        sizes = np.linalg.svd(np.array(kept), compute_uv=False)
        least, lci = sizes[:, -1], sizes[:, -1] / sizes[:, 0]
        # squares cost digits as the module says
        doubt = 1e-14 * sizes[:, 0] / lci
        assert np.all(np.abs(w.poses.least_singular_value[:count] - least) <= doubt)
        assert np.all(np.abs(w.poses.lci[:count] - lci) <= doubt / sizes[:, 0])
        for k in range(count):
            exact = np.linalg.norm(np.linalg.inv(kept[k]), axis=0)[:5].max()
            assert largest_limb_force(w.poses, k) == pytest.approx(exact, rel=1e-12 / lci[k])


@pytest.mark.nojit
def test_the_force_in_a_singular_pose_is_infinite() -> None:
    w = evaluation.work_space()
    w.poses.g[:, :, 0] = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    assert largest_limb_force(w.poses, 0) == math.inf


def test_usable_parts_of_lines_are_usable_and_the_rest_is_not() -> None:
    states = set()
    for n, (r_a, r_b, chosen) in enumerate(random_designs(25, 8)):
        w = evaluation.work_space()
        assert evaluation.set_design(w, r_a, r_b, chosen)
        geometry, f = chosen.geometry(r_a, r_b), w.fibre
        for given in random_poses(chosen, 6, n):
            state, length = find_through(f, 0, *given[:3], *given[4:])
            pose = with_alpha(w, given)
            if pose is None or not chosen.box_least[3] < pose[3] < chosen.box_greatest[3]:
                assert state == NOTHING
                continue
            states.add(state)
            count = int(f.usable.count[0])
            starts, stops = f.usable.start[:count].copy(), f.usable.stop[:count].copy()
            reach = np.concatenate([[-length, length], starts, stops])
            seen_wrong = False
            for way in np.random.default_rng(n).uniform(reach.min(), reach.max(), 10):
                here = pose + way * np.concatenate([f.direction, np.zeros(3)])
                assert constraint_residual(geometry, here) == pytest.approx(0.0, abs=1e-12)
                inside = bool(np.any((starts <= way) & (way <= stops)))
                wide, right = usable_by_definition(geometry, here, chosen, 1e-10)
                narrow, _ = usable_by_definition(geometry, here, chosen, -1e-10)
                if inside:
                    assert wide
                    assert right
                elif narrow:
                    assert not right
                seen_wrong |= narrow and not right
            if seen_wrong:
                assert state in (SOMETHING_SINGULAR, ONLY_SINGULAR)
    assert len(states) == 4


def test_drawn_lines_have_the_measure_of_the_box() -> None:
    # without limits but a wide one of α, every line counts in full and the whole is 1
    for axis_angle, r_a in ((0.0, 1.5), (40.0, 1.5), (0.0, 0.6)):
        chosen = options(
            axis_angle=axis_angle, limb_min=0.0, limb_max=100.0, alpha_min=-180.0, alpha_max=180.0,
            base_joint_limit=180.0, platform_joint_limit=180.0,
        )  # fmt: skip
        w = evaluation.work_space()
        assert evaluation.set_design(w, r_a, 0.3, chosen)
        least, greatest = np.array(chosen.box_least), np.array(chosen.box_greatest)
        random = np.random.default_rng(9)
        given = random_poses(chosen, 2000, 10)
        exists = np.mean([with_alpha(w, pose) is not None for pose in given])
        parts = []
        for u in random.random((8_000, 4)):
            angles = least[4:] + u[2:] * (greatest[4:] - least[4:])
            _, weight, reached = draw_line(w.fibre, 0, u[0], u[1], *angles)
            parts.append(weight * reached)
        error = 4.0 * np.std(parts) / math.sqrt(len(parts))
        error += 4.0 * math.sqrt(exists * (1.0 - exists) / len(given))
        assert np.mean(parts) == pytest.approx(exists, abs=error)


def test_lines_and_points_give_the_same_share() -> None:
    # a box that is barely flat is integrated over points, one that barely is not over lines
    limits = {"limb_max": 1.1, "alpha_min": -12.0, "axis_angle": 20.0}
    for name in ("x", "y", "z"):
        at = 0.95 if name == "z" else 0.05
        shares = []
        for half in (0.0, 1e-6):
            ends = {f"{name}_min": at - half, f"{name}_max": at + half}
            found = evaluate([(0.9, 0.4)], options(**limits, **ends), 1e-2)
            shares.append((found["usable_share"][0], found["usable_share_error"][0]))
            assert found["gci"][0] > 0.0
        assert shares[0][0] == pytest.approx(shares[1][0], abs=shares[0][1] + shares[1][1])
        assert 0.1 < shares[0][0] < 0.9


def evaluate(
    designs: list[tuple[float, float]], chosen: AtlasOptions, tolerance: float
) -> dict[str, npt.NDArray[Any]]:
    return evaluation.evaluate_designs(np.array(designs), chosen, np.array([0.01, 0.02]), tolerance)


@pytest.mark.nojit
def test_points_are_the_same_ones_and_every_level_goes_on() -> None:
    first = sampling.points_of_level(0)
    second = sampling.points_of_level(1)
    assert first.shape == (
        sampling.SCRAMBLINGS, sampling.FIRST_POINTS, sampling.DIMENSIONS
    )  # fmt: skip
    assert second.shape == first.shape
    assert [sampling.points_up_to(n) // 256 for n in range(7)] == [1, 2, 3, 4, 6, 8, 12]
    assert sampling.points_of_level(0) is first
    for each in range(sampling.SCRAMBLINGS):
        both = np.concatenate([first[each], second[each]])
        cells = np.sort((both * 2 * sampling.FIRST_POINTS).astype(int), axis=0)
        # one point in each of equal parts of every coordinate
        assert np.array_equal(cells, np.tile(np.arange(len(both))[:, None], (1, 6)))
    assert len(np.unique(first[:, 0, 0])) == sampling.SCRAMBLINGS


@pytest.mark.nojit
def test_errors_of_means_and_ratios_hold() -> None:
    random = np.random.default_rng(11)
    mean_fails = ratio_fails = 0
    for _ in range(1000):
        below = 2.0 + 0.1 * random.normal(size=16)
        above = 3.0 * below + 0.1 * random.normal(size=16)
        mean, error = evaluation.mean_and_error(below)
        mean_fails += abs(mean - 2.0) > error
        ratio, error = evaluation.ratio_and_error(above, below)
        ratio_fails += abs(ratio - 3.0) > error
        assert error < 0.1
    # 0.2 % are meant to
    assert 0 < mean_fails + ratio_fails < 15


DESIGNS = [(1.0, 0.25), (0.5, 0.25), (0.9, 1.0), (2.0, 0.4)]


def test_designs_do_not_depend_on_each_other_nor_on_threads() -> None:
    chosen = options()
    together = evaluate(DESIGNS, chosen, 1e-2)
    backwards = evaluate(DESIGNS[::-1], chosen, 1e-2)
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        alone = list(pool.map(lambda each: evaluate([each], chosen, 1e-2), DESIGNS))
    for name, values in together.items():
        assert values.tobytes() == backwards[name][::-1].tobytes(), name
        assert values.tobytes() == np.concatenate([each[name] for each in alone]).tobytes(), name


def test_errors_reach_the_tolerance_or_the_status_says_so() -> None:
    found = evaluate(DESIGNS, options(), 1e-2)
    for n, status in enumerate(found["status"]):
        for name in ("gci", "mean_least_singular_value"):
            reached = found[f"{name}_error"][n] <= 1e-2 * found[name][n]
            assert reached or status & evaluation.GCI_TOLERANCE_NOT_REACHED
        errors = [
            found["usable_share_error"][n],
            *found["good_condition_share_error"][n],
            found["workspace_volume_error"][n] / found["workspace_volume"][n],
        ]
        # shares and the volume have twice the tolerance
        assert max(errors) <= 2e-2 or status & evaluation.SHARE_TOLERANCE_NOT_REACHED
    # so few points cannot
    hard = evaluate([(0.9, 1.0)], options(), 1e-5)["status"][0]
    assert hard & evaluation.GCI_TOLERANCE_NOT_REACHED
    assert hard & evaluation.SHARE_TOLERANCE_NOT_REACHED


def test_home_is_what_numpy_finds() -> None:
    chosen = options()
    found = evaluate(DESIGNS, chosen, 1e-1)
    for n, (r_a, r_b) in enumerate(DESIGNS):
        g = scaled_jacobian(chosen.geometry(r_a, r_b), home_pose(), chosen, r_b)
        sizes = np.linalg.svd(g, compute_uv=False)
        force = np.linalg.norm(np.linalg.inv(g), axis=0)[:5].max()
        assert found["home_lci"][n] == pytest.approx(sizes[-1] / sizes[0], rel=1e-12)
        assert found["home_least_singular_value"][n] == pytest.approx(sizes[-1], rel=1e-12)
        assert found["home_largest_limb_force"][n] == pytest.approx(force, rel=1e-9)


def test_extremes_are_beyond_a_large_sample_and_near_each_other() -> None:
    # small boxes, without singular poses
    ends = {
        "x_min": -0.1, "x_max": 0.1, "y_min": -0.1, "y_max": 0.1, "z_min": 0.95, "z_max": 1.05,
        "beta_min": -8.0, "beta_max": 8.0, "gamma_min": -8.0, "gamma_max": 8.0,
    }  # fmt: skip
    chosen = options(**ends)
    for r_a, r_b in ((1.0, 0.25), (0.6, 1.2)):
        found = evaluate([(r_a, r_b)], chosen, 1e-2)
        assert not found["status"][0] & evaluation.SINGULAR_POSES
        geometry, w = chosen.geometry(r_a, r_b), evaluation.work_space()
        least, force = math.inf, 0.0
        for pose in (with_alpha(w, each) for each in random_poses(chosen, 1000, 12)):
            if pose is not None and all(usable_by_definition(geometry, pose, chosen, 0.0)):
                g = scaled_jacobian(geometry, pose, chosen, r_b)
                least = min(least, float(np.linalg.svd(g, compute_uv=False)[-1]))
                force = max(force, float(np.linalg.norm(np.linalg.inv(g), axis=0)[:5].max()))
        searched = found["least_singular_value"][0], found["largest_limb_force"][0]
        assert 0.5 * least < searched[0] < least
        assert force < searched[1] < 2.0 * force
        # no column of the inverse is longer than this
        assert searched[1] <= (1.0 + 1e-9) / searched[0]


def test_singular_poses_within_limits_are_told() -> None:
    found = evaluate([(1.0, 0.25)], options(), 1e-2)
    assert found["status"][0] == evaluation.SINGULAR_POSES
    assert found["least_singular_value"][0] == 0.0
    assert math.isnan(found["largest_limb_force"][0])
    assert found["gci"][0] > 0.0


@pytest.mark.parametrize(
    ("r_a", "r_b", "given"),
    [
        (0.0, 0.3, {}),
        (0.3, -0.1, {}),
        # A_1 at A_2
        (1.0, 0.5, {"base_angle": 0.0}),
        # lines of one regulus at home
        (1.0, 0.5, {"base_angle": 72.0, "offset": 1.0, "position_angle": 0.0}),
    ],
)
def test_designs_that_are_none_have_no_values(
    r_a: float, r_b: float, given: dict[str, float]
) -> None:
    found = evaluate([(r_a, r_b), (1.0, 0.25)], options(**given), 1e-1)
    geometry_fails = found["status"][0] == evaluation.DEGENERATE_DESIGN
    if "offset" in given:
        # whether the home pose is singular is what NumPy says
        chosen = options(**given)
        g = scaled_jacobian(chosen.geometry(r_a, r_b), home_pose(), chosen, r_b)
        sizes = np.linalg.svd(g, compute_uv=False)
        assert geometry_fails == bool(sizes[-1] <= 1e-9 * sizes[0])
        return
    assert geometry_fails
    for name, values in found.items():
        if name != "status":
            assert np.all(np.isnan(values[0])), name


def test_a_box_without_usable_poses_has_none() -> None:
    # far from home with hardly any strokes
    found = evaluate(
        [(1.0, 0.25)], options(z_min=2.0, z_max=2.1, limb_min=0.99, limb_max=1.01), 1e-2
    )
    assert found["status"][0] & evaluation.NO_USABLE_POSE
    assert found["usable_share"][0] == 0.0
    assert found["usable_share_error"][0] <= 1e-2
    assert np.all(found["good_condition_share"] == 0.0)
    for name in ("gci", "mean_least_singular_value", "least_singular_value", "largest_limb_force"):
        assert math.isnan(found[name][0]), name
    # the volume knows no box
    assert found["workspace_volume"][0] > 0.0


def test_a_box_that_is_one_pose_has_the_values_of_that_pose() -> None:
    ends = {f"{name}_{end}": 0.0 for name in ("x", "y", "beta", "gamma") for end in ("min", "max")}
    found = evaluate([(1.0, 0.25)], options(**ends, z_min=1.0, z_max=1.0), 1e-2)
    assert found["usable_share"][0] == 1.0
    assert found["gci"][0] == pytest.approx(found["home_lci"][0], rel=1e-9)
    for name in ("least_singular_value", "largest_limb_force"):
        assert found[name][0] == pytest.approx(found[f"home_{name}"][0], rel=1e-9)


def test_sums_count_lines() -> None:
    w = evaluation.work_space()
    assert evaluation.set_design(w, 1.0, 0.25, options())
    points = sampling.points_of_level(0)
    sums = np.zeros((len(points), SUMS))
    values, coordinates = np.full((len(points), 2), math.inf), np.zeros((len(points), 2, 5))
    integrate(w, 0, points, np.empty(0), sums, values, coordinates)
    assert np.all((sums[:, HITS] > 0) & (sums[:, HITS] <= points.shape[1]))
    assert np.all(sums[:, SHARE] <= points.shape[1])
    # what is kept as worst is a pose with that value
    chosen = options()
    geometry = chosen.geometry(1.0, 0.25)
    for r in range(len(points)):
        x, y, z, beta, gamma = coordinates[r, 0]
        pose = with_alpha(w, np.array([x, y, z, 0.0, beta, gamma]))
        assert pose is not None
        g = scaled_jacobian(geometry, pose, chosen, 0.25)
        sizes = np.linalg.svd(g, compute_uv=False)
        doubt = 1e-14 * sizes[0] ** 2 / sizes[-1]
        assert values[r, 0] == pytest.approx(sizes[-1], abs=doubt)
