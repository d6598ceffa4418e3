"""One design of the manipulator with a passive leg: poses, loci, workspaces, paths.

Compared with the oracle of :mod:`naive_passive_leg`, with dense samples and with differences.
"""

from __future__ import annotations

import itertools
import math

import naive_passive_leg as naive
import numpy as np
import pytest
import shapely

from fivebar_atlas.errors import InputError, OutOfReachError, UnknownNameError
from fivebar_atlas.figures.linkage_figure import linkage_figure
from fivebar_atlas.mechanisms import planar_design
from fivebar_atlas.mechanisms.mode_pairs import MODE_PAIRS
from fivebar_atlas.mechanisms.passive_leg.forward_arc import ForwardArc
from fivebar_atlas.mechanisms.passive_leg.passive_leg import PassiveLeg
from fivebar_atlas.mechanisms.passive_leg.reach_arc import ReachArc, ReachCurve
from fivebar_atlas.mechanisms.planar import PLATFORM, TELESCOPE
from fivebar_atlas.planar_geometry import LEFT, RIGHT

Array = np.ndarray

#: Conditioned with r > R, with folded legs inside, with an inner boundary and narrower, and with
#: inner boundaries of limits of the passive joints.
DESIGNS = (
    PassiveLeg(1.2, 1.2, 1.0),
    PassiveLeg(0.8, 1.0, 1.2),
    PassiveLeg(0.6, 0.8, 1.4, theta_limit=math.radians(70.0)),
    PassiveLeg(1.7, 1.9, 1.1),
    PassiveLeg(0.7, 1.6, 1.5, passive_joint_limits=False),
)


def machine(design: PassiveLeg, mode: str) -> naive.Machine:
    return naive.machine(design.r, design.l_a, design.l_b, mode, design.passive_joint_limits)


def polar(points: Array) -> tuple[Array, Array]:
    """Return l and θ."""
    return np.hypot(points[:, 0], points[:, 1]), np.arctan2(-points[:, 0], points[:, 1])


def random_points(rng: np.random.Generator, design: PassiveLeg, number: int) -> Array:
    """Points of the upper half plane, most of them not far beyond reach."""
    size = design.l_a + design.l_b
    return np.column_stack([rng.uniform(-size, size, number), rng.uniform(0.0, size, number)])


def test_poses_close_and_say_their_mode_and_lci() -> None:
    rng = np.random.default_rng(51)
    checked = 0
    for design in DESIGNS:
        lengths = {"$l_a$": design.l_a, "$l_b$": design.l_b, "$R$": 1.0, "$r$": design.r}
        for x, y in random_points(rng, design, 40):
            if np.isnan(design.lci(x, y)):
                continue
            for pose in design.inverse_poses(x, y):
                checked += 1
                at = [joint.position for joint in pose.joints]
                for link in pose.links:
                    if link.symbol in lengths:
                        length = math.dist(at[link.start], at[link.end])
                        assert length == pytest.approx(lengths[link.symbol], abs=1e-12)
                assert pose.output == pytest.approx((x, y), abs=1e-14)
                m = machine(design, pose.mode)
                length, theta = math.hypot(x, y), math.atan2(-x, y)
                phi = [float(each) for each in naive.inverse_kinematics(m, length, theta)]
                assert np.cos(np.subtract(phi, pose.inputs)) == pytest.approx([1.0, 1.0])
                assert -m.assembly * naive.pose(m, length, theta).det_x > 0.0
                assert pose.lci == pytest.approx(
                    float(naive.conditioning(m, length, theta)[0]), rel=1e-9
                )
                positions = design.joint_positions(x, y, pose.mode)
                assert positions == pytest.approx(np.array(at[:-1]), abs=1e-12)
    assert checked > 200


def test_forward_poses_are_all_assemblies_with_the_passive_leg_on_its_side() -> None:
    rng = np.random.default_rng(52)
    counts = set()
    for design in DESIGNS:
        for x, y in random_points(rng, design, 60):
            if np.isnan(design.lci(x, y)):
                continue
            for pose in design.inverse_poses(x, y)[:2]:
                found = design.forward_poses(pose.inputs)
                counts.add(len(found))
                near = min(found, key=lambda each: math.dist(each.output, (x, y)))
                assert near.output == pytest.approx((x, y), abs=1e-5)
                assert near.mode == pose.mode
                for each in found:
                    assert each.output[1] >= 0.0
                    again = design.inputs(*each.output, each.mode)
                    assert np.cos(again - each.inputs) == pytest.approx([1.0, 1.0], abs=1e-10)
    assert {1, 2, 3} <= counts


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda d: d.pose(0.0, 0.0), InputError, "lengths of the passive leg above 0"),
        (lambda d: d.pose(1.0, -0.1), InputError, "within 90 deg of the y axis"),
        (lambda d: d.pose(0.0, 5.0), OutOfReachError, "the stretched leg 1 reaches"),
        (lambda d: d.pose(0.2, 0.3), OutOfReachError, "nearer to B_1 than the folded leg 1 comes"),
        (lambda d: d.pose(math.nan, 1.0), InputError, "two numbers"),
        (lambda d: d.pose(0.0, 1.0, "+-/down"), InputError, "it is +-/up"),
        (lambda d: d.pose(0.0, 1.0, "+/up"), UnknownNameError, "did you mean"),
        (lambda d: d.forward_poses((0.0,)), InputError, "two finite angles"),
        (lambda d: d.forward_poses((0.0, math.pi)), InputError, "passive leg above the base"),
        (lambda d: d.usable_workspace("up"), UnknownNameError, "+-/up"),
        (lambda d: d.good_condition_area(1.0), InputError, "lci_threshold"),
        (lambda d: d.check_path([[0.0, math.inf]]), InputError, "two finite numbers"),
    ],
)  # fmt: skip
def test_what_is_not_possible_is_refused_in_words(call, error, text) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(error) as caught:
        call(PassiveLeg(0.8, 1.0, 1.2))
    assert text in str(caught.value)


def test_lengths_and_limits_that_make_no_manipulator_are_named() -> None:
    with pytest.raises(InputError, match=r"l_a: 0\.0"):
        PassiveLeg(0.8, 0.0, 1.2)
    with pytest.raises(InputError, match=r"l_a \+ l_b above \|R - r\|"):
        PassiveLeg(3.0, 0.5, 0.6)
    with pytest.raises(InputError, match="up to 90 deg"):
        PassiveLeg(0.8, 1.0, 1.2, theta_limit=2.0)
    with pytest.raises(InputError, match=r"R: -1\.0"):
        PassiveLeg.from_lengths(-1.0, 0.8, 1.0, 1.2)
    with pytest.raises(OutOfReachError, match=r"d_1 and d_2 are 3\.8 too far apart"):
        PassiveLeg(0.5, 2.0, 0.6).forward_poses((0.0, math.pi))


def test_the_gap_to_reach_is_what_is_missing() -> None:
    design = PassiveLeg(0.8, 1.0, 1.2)
    with pytest.raises(OutOfReachError) as caught:
        design.pose(0.0, 5.0)
    assert caught.value.gap == pytest.approx(math.hypot(5.0, 0.2) - 2.2)
    with pytest.raises(OutOfReachError) as scaled:
        planar_design(100, 80, 100, 120, mechanism="passive-leg").pose(0.0, 500.0, "+-")
    assert scaled.value.gap == pytest.approx(100.0 * caught.value.gap)
    assert "(0.0, 500.0)" in str(scaled.value)


def test_the_jacobian_is_that_of_finite_differences() -> None:
    rng = np.random.default_rng(53)
    step = 1e-5
    for design in DESIGNS:
        points = random_points(rng, design, 100)
        for mode in ("+-", "-+", "++", "--"):
            j = design.jacobian(*points.T, mode)
            moved = [
                [design.inputs(*(points + sign * step * way).T, mode) for sign in (1.0, -1.0)]
                for way in np.eye(2)
            ]
            rates = np.stack(
                [
                    (np.remainder(more - less + math.pi, 2.0 * math.pi) - math.pi) / (2.0 * step)
                    for more, less in moved
                ],
                axis=-1,
            )
            smooth = np.abs(j).max(axis=(1, 2)) < 20.0
            assert smooth.sum() > 10
            assert rates[smooth] == pytest.approx(j[smooth], abs=1e-5, rel=1e-5)
            m = machine(design, f"{mode}/up")
            assert j[smooth] == pytest.approx(naive.jacobian(m, *polar(points[smooth])), abs=1e-10)


def test_bounds_hold_on_discs_and_segments_and_close_quadratically() -> None:
    rng = np.random.default_rng(54)
    shares = np.linspace(-1.0, 1.0, 41)
    gaps: dict[float, list[float]] = {0.02: [], 0.01: []}
    tighter = 0
    for design in DESIGNS:
        points = random_points(rng, design, 150)
        for mode in ("+-", "++"):
            for radius, found in gaps.items():
                least, turns = design.bounds_on_discs(*points.T, radius, mode)
                ways = rng.normal(size=points.shape)
                ways *= radius / np.hypot(*ways.T)[:, None]
                on_line, on_line_turns = design.bounds_on_segments(
                    points - ways, points + ways, mode
                )
                for place in np.flatnonzero(on_line > 0.0):
                    line = points[place] + shares[:, None] * ways[place]
                    values = design.lci(*line.T, mode)
                    assert values.min() >= on_line[place] * (1.0 - 1e-12)
                    turn = np.abs(
                        np.unwrap(design.inputs(*line.T, mode), axis=0)
                        - np.unwrap(design.inputs(*line.T, mode), axis=0)[20]
                    ).max(axis=0)
                    assert np.all(turn <= on_line_turns[place] + 1e-12)
                    tighter += int(least[place] == 0.0)
                for place in np.flatnonzero(least > 0.0)[:25]:
                    angle = rng.uniform(0.0, 2.0 * math.pi, 200)
                    reach = radius * np.sqrt(rng.random(200))
                    reach[:100] = radius
                    x = points[place, 0] + reach * np.cos(angle)
                    y = points[place, 1] + reach * np.sin(angle)
                    values = design.lci(x, y, mode)
                    assert values.min() >= least[place] * (1.0 - 1e-12)
                    if design.passive_joint_limits:
                        assert design.upper_links(x, y, mode)[:, [1, 3]].min() > 0.0
                    here = design.inputs(*points[place], mode)
                    turn = np.remainder(design.inputs(x, y, mode) - here + np.pi, 2 * np.pi) - np.pi
                    assert np.all(np.abs(turn).max(axis=0) <= turns[place] + 1e-12)
                    found.append(math.log(values.min() / least[place]))
    assert tighter > 0
    coarse, fine = (float(np.median(found)) for found in gaps.values())
    assert 0.0 < fine < 0.35 * coarse


def test_points_of_reach_arcs_keep_their_distance_and_sweep_the_area_of_fine_polygons() -> None:
    rng = np.random.default_rng(55)
    shares = np.linspace(0.0, 1.0, 2001)
    for _ in range(12):
        leg = float(rng.choice([-1.0, 1.0]))
        curve = ReachCurve(1.0, float(rng.uniform(0.3, 2.0)), float(rng.uniform(0.1, 2.5)), leg)
        for start, end in curve.ranges(1.5):
            for sheet in (1.0, -1.0):
                arc = ReachArc.of_pieces(curve, ((sheet, start, end),))
                line = arc.points(shares)
                # signed lengths: the direction of the platform is that of the angle
                theta = start + (end - start) * shares**2 * (3.0 - 2.0 * shares)
                u = np.column_stack([np.cos(theta), np.sin(theta)])
                ends = line + leg * curve.arm * u
                gap = np.hypot(ends[:, 0] - leg, ends[:, 1]) - curve.reach
                assert np.abs(gap).max() < 1e-7  # a square root where the curve turns back
                assert np.abs(gap[100:-100]).max() < 1e-12
                areas = [
                    0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) for x, y in (line.T, line[::2].T)
                ]
                assert arc.swept_area() == pytest.approx((4 * areas[0] - areas[1]) / 3, abs=1e-8)
                for mirror, factors in (((True, False), (-1, 1)), ((False, True), (1, -1))):
                    image = arc.mirrored(*mirror)
                    assert image.points(shares) == pytest.approx(line * factors, abs=1e-12)
                back = arc.reversed()
                assert back.points(shares) == pytest.approx(line[::-1], abs=1e-12)
                assert back.scaled(2.0).swept_area() == pytest.approx(-4.0 * arc.swept_area())


@pytest.mark.parametrize("design", DESIGNS)
def test_singular_loci_are_singular_and_border_on_the_modes_they_say(design: PassiveLeg) -> None:
    seen = set()
    for named in design.singular_loci():
        points = named.arc.points(np.linspace(0.02, 0.98, 25))
        length, theta = polar(points)
        for mode, side in named.sides.items():
            m = machine(design, mode)
            seen.add(named.kind)
            p = naive.pose(m, length, theta)
            if named.kind == "parallel":
                assert isinstance(named.arc, ForwardArc)
                # l det J_x relative to its terms; l may be small
                size = design.l_b**2 * (length + 2.0 * design.r)
                assert np.abs(p.det_x / size).max() < 1e-12
                j_x = np.stack(p.rows, axis=-2)
                values = np.linalg.svd(j_x, compute_uv=False)
                assert values[..., 1].max() < 1e-10
            else:
                leg = int(named.name[2]) - 1
                straight = design.l_a + design.l_b
                if named.name.endswith("i"):
                    straight = abs(design.l_a - design.l_b)
                b = naive.platform_joints(design.r, length, theta)[leg]
                reach = np.hypot(*(b - naive.base_joints()[leg]).T)
                assert reach == pytest.approx(np.full(len(points), straight), abs=1e-12)
            # a step aside: the pair lies on the side it says, on the other the other one or nothing
            along = np.gradient(points, axis=0)[12]
            aside = 1e-5 * np.array([-along[1], along[0]]) / math.hypot(*along)
            inner, outer = points[12] + aside, points[12] - aside
            if side == RIGHT:
                inner, outer = outer, inner
            belongs = [
                bool(naive.reached(m, *at) and naive.permitted(m, *at))
                for at in (tuple(each[0] for each in polar(q[None])) for q in (inner, outer))
            ]
            assert belongs == [True, False], (named.name, mode)
            assert side in (LEFT, RIGHT)
    assert "serial" in seen


def test_folds_of_the_forward_singularity_pass_from_mode_to_mode_on_reach_curves() -> None:
    design = PassiveLeg(0.7, 1.6, 1.5, passive_joint_limits=False)
    ends = [
        point
        for named in design.singular_loci()
        if named.kind == "parallel"
        for kind, point in zip(named.ends, (named.arc.start, named.arc.end), strict=True)
        if kind == "tangency"
    ]
    assert len(ends) >= 8
    length, theta = polar(np.array(ends))
    reach = np.stack(
        [
            np.hypot(*(b - foot).T)
            for b, foot in zip(
                naive.platform_joints(0.7, length, theta), naive.base_joints(), strict=True
            )
        ]
    )
    gaps = np.minimum(np.abs(reach - 3.1), np.abs(reach - 0.1)).min(axis=0)
    assert gaps.max() < 1e-12
    # another arc ends in the same point
    for place, point in enumerate(ends):
        others = ends[:place] + ends[place + 1 :]
        assert min(math.dist(point, other) for other in others) < 1e-9


def test_the_middle_of_the_base_is_a_singular_point_where_it_is_reached() -> None:
    assert PassiveLeg(1.2, 1.2, 1.0).isolated_singular_points() == ((0.0, 0.0),)
    assert PassiveLeg(0.6, 0.8, 1.4, theta_limit=0.4).isolated_singular_points() == ()
    # legs of equal links: b_i may come to B_i
    points = PassiveLeg(0.8, 1.0, 1.0).isolated_singular_points()
    assert points[0] == (0.0, 0.0)
    for x, y in points[1:]:
        length, theta = math.hypot(x, y), math.atan2(-x, y)
        ends = naive.platform_joints(0.8, length, theta)
        gaps = [math.dist(b, foot) for b, foot in zip(ends, naive.base_joints(), strict=True)]
        assert min(gaps) < 1e-12
    assert len(points) == 3
    assert PassiveLeg(0.8, 1.0, 1.2).remarks()[0] == "architecture singularity at O"


@pytest.mark.parametrize(
    ("design", "mode", "is_integrated"),
    [
        (DESIGNS[0], "+-/up", True),
        (DESIGNS[1], "+-/up", True),
        (DESIGNS[1], "-+/down", False),
        (DESIGNS[2], "++/up", True),
        (DESIGNS[3], "+-/up", True),
        (DESIGNS[3], "--/down", False),
        (DESIGNS[4], "-+/up", False),
    ],
)
def test_the_usable_workspace_is_that_of_the_oracle(
    design: PassiveLeg, mode: str, is_integrated: bool
) -> None:
    workspace = design.usable_workspace(mode)
    assert workspace is not None
    expected = workspace.area
    if is_integrated:
        expected = naive.reference_indices(
            design.r,
            design.l_a,
            design.l_b,
            mode,
            theta_limit=math.degrees(design.theta_limit),
            passive_joint_limits=design.passive_joint_limits,
            rtol=1e-5,
        )["usable_workspace_area"]
    assert workspace.region.area == pytest.approx(expected, rel=2e-6)
    assert workspace.area == pytest.approx(expected, rel=2e-6)
    for loop in workspace.region.loops:
        for one, two in zip(loop.arcs, [*loop.arcs[1:], loop.arcs[0]], strict=True):
            assert one.arc.end == two.arc.start
    # membership by polygon and by columns
    outline, *holes = workspace.region.polygons(1e-5)
    # outlines may touch themselves in O, and chords cross next to tangent arcs
    shape = shapely.make_valid(shapely.Polygon(outline, holes))
    assert shape.area == pytest.approx(workspace.area, rel=1e-4)
    rng = np.random.default_rng(56)
    x, y = random_points(rng, design, 4000).T
    near = shapely.distance(shape.boundary, shapely.points(x, y)) < 1e-4
    inside = workspace.contains(x, y)
    assert np.array_equal(inside[~near], shapely.contains_xy(shape, x, y)[~near])
    assert 50 < inside.sum() < 3500
    values = workspace.lci(x, y)
    m = machine(design, mode)
    length, theta = np.hypot(x, y), np.arctan2(-x, y)
    possible = naive.reached(m, length, theta) & (np.abs(theta) < design.theta_limit)
    possible[possible] = naive.permitted(m, length[possible], theta[possible])
    assert not np.any(inside & ~possible)
    lci = naive.conditioning(m, length, theta)[0]
    assert values == pytest.approx(np.where(inside, lci, 0.0), abs=1e-10)


def test_boundaries_are_of_arcs_that_end_where_something_changes() -> None:
    design = PassiveLeg(0.9, 1.1, 1.2)  # next to O no column tells its folded legs from O
    workspace = design.usable_workspace("+-/up")
    assert workspace is not None
    names = [arc.name for arc in workspace.region.outline.arcs]
    right = ["C_x", "theta_max", "C_2o"]
    assert sorted(names) == sorted([*right, "C_1o", "theta_max", "C_x", "C_2i", "C_1i"])
    ends = np.array([end for arc in design.singular_loci() for end in (arc.arc.start, arc.arc.end)])
    away = np.hypot(*ends.T)
    assert np.count_nonzero(away == 0.0) == 4  # of C_1i, C_2i and twice of C_x
    assert away[away > 0.0].min() > 0.1


def test_mirror_images_of_mode_pairs_have_mirrored_workspaces() -> None:
    design = PassiveLeg(0.7, 1.6, 1.5)
    for mode, image in (("++/up", "--/up"), ("++/down", "--/down"), ("+-/up", "+-/up")):
        one, other = design.usable_workspace(mode), design.usable_workspace(image)
        assert one is not None
        assert other is not None
        assert one.region.area == pytest.approx(other.region.area, rel=1e-9)
        rng = np.random.default_rng(57)
        x, y = random_points(rng, design, 2000).T
        assert one.lci(x, y) == pytest.approx(other.lci(-x, y), abs=1e-12)
    assert set(MODE_PAIRS) >= {"++/up"}


def test_the_good_condition_workspace_has_its_area_and_its_boundary_on_the_level() -> None:
    design = DESIGNS[1]
    parts = design.good_condition_workspace(0.5)
    area, error = design.good_condition_area(0.5)
    assert sum(part.area for part in parts) == pytest.approx(area, abs=1e-5 + error)
    corners = np.concatenate([line for part in parts for line in part.polygons(1.0)])
    assert design.lci(*corners.T) == pytest.approx(np.full(len(corners), 0.5), abs=1e-9)
    largest = design.largest_lci()
    assert largest is not None
    assert float(design.lci(*largest[1])) == pytest.approx(largest[0], abs=1e-9)
    rng = np.random.default_rng(58)
    assert design.lci_inside(*random_points(rng, design, 4000).T).max() <= largest[0]


def test_the_inscribed_circle_touches_the_boundary_and_no_other_on_the_axis_is_larger() -> None:
    for design in DESIGNS[:4]:
        (circle,) = design.inscribed_circles("+-/up")
        workspace = design.usable_workspace("+-/up")
        assert workspace is not None
        edge = circle.points(np.linspace(0.0, 1.0, 400))
        inner = np.array(circle.centre) + 0.999999 * (edge - np.array(circle.centre))
        assert workspace.contains(*inner.T).all()
        y = np.linspace(0.0, 4.0, 1501)
        axis = np.column_stack([np.zeros_like(y), y])
        gaps = workspace.region.boundary_distance(axis)[0][workspace.contains(*axis.T)]
        assert gaps.max() <= circle.radius + 1e-12
        assert gaps.max() == pytest.approx(circle.radius, abs=3e-3)
    assert design.inscribed_circles("++/up") == ()


PATHS = (
    (DESIGNS[0], "+-/up", [(0.0, 1.0), (0.5, 1.2), (-0.5, 1.2), (0.0, 1.0)], ""),
    (DESIGNS[1], "+-/up", [(0.0, 1.0), (2.0, 1.0)], "C_2o"),
    (DESIGNS[1], "+-/up", [(0.0, 1.0), (0.6, 0.6)], "C_1i"),
    (DESIGNS[1], "+-/up", [(0.9, 0.4), (0.2, 0.2)], "C_x"),
    (DESIGNS[2], "+-/up", [(0.0, 1.3), (0.7, 1.3), (1.3, 1.0)], "C_2o"),
    (DESIGNS[3], "+-/up", [(0.0, 1.5), (0.3, 1.0), (0.1, 0.4)], "q_1"),
    (PassiveLeg(1.2, 1.2, 1.0, theta_limit=0.5), "+-/up", [(0.0, 1.0), (0.9, 1.0)], "theta_max"),
)


@pytest.mark.parametrize(("design", "mode", "points", "curve"), PATHS)
def test_paths_are_followed_up_to_the_first_locus_or_limit(
    design: PassiveLeg, mode: str, points: list[tuple[float, float]], curve: str
) -> None:
    report = design.check_path(points, mode)
    assert (report.fault.curve if report.fault else "") == curve
    workspace = design.usable_workspace(mode)
    assert workspace is not None
    corners = np.array(points)
    if report.fault is None:
        stop, share = len(points) - 2, 1.0
    else:
        stop, share = report.fault.segment, report.fault.share
    # up to there all is inside, by dense samples, and inputs are continuous
    shares = np.linspace(0.0, 1.0, 2001)
    lines = []
    for k in range(stop + 1):
        end = (share - 1e-6 if k == stop and report.fault else 1.0) * shares
        lines.append(corners[k] + end[:, None] * (corners[k + 1] - corners[k]))
    line = np.concatenate(lines)
    assert workspace.contains(*line.T).all()
    angles = np.unwrap(design.inputs(*line.T, mode), axis=0)
    count = len(points) if report.fault is None else stop + 1
    at_corners = np.vstack([angles[:: len(shares)], angles[-1:]])[:count]
    assert report.inputs[:count] == pytest.approx(at_corners, abs=1e-5)
    assert np.isnan(report.inputs[count:]).all()
    if report.fault is not None:
        position = np.array(report.fault.position)
        way = corners[stop + 1] - corners[stop]
        beyond = position + 1e-6 * way / np.hypot(*way)
        assert not workspace.contains(*beyond)
        gap, (nearest,) = workspace.region.boundary_distance(position[None])
        assert gap[0] < 1e-9
        assert nearest.name == curve
        assert report.fault.kind == ("" if nearest.kind == "limit" else nearest.kind)


def test_what_keeps_a_path_from_beginning_is_said() -> None:
    design = DESIGNS[1]
    for point, text in (
        ((0.0, 5.0), "C is out of reach of leg 1, by 2.804 "),
        ((0.2, 0.4), "b1 too near to B1"),
        ((1.0, -0.2), "the passive leg is beyond its limit"),
    ):
        fault = design.check_path([point, (0.0, 1.0)]).fault
        assert fault is not None
        assert text.rstrip() in fault.reason
    assert "other assembly mode" in str(design.check_path([(0.0, 1.0)], "+-/down").fault)
    above = DESIGNS[3].check_path([(0.17, 0.69)]).fault
    assert above is not None
    assert "above the platform" in above.reason


def test_least_values_on_a_path_are_those_of_dense_samples() -> None:
    design = DESIGNS[0]
    corners = np.array([(0.0, 1.0), (0.5, 1.2), (-0.7, 1.2)])
    lci, distance = design.least_on_path(corners)
    shares = np.linspace(0.0, 1.0, 2001)[:, None]
    line = np.concatenate([a + shares * (b - a) for a, b in itertools.pairwise(corners)])
    workspace = design.usable_workspace()
    assert workspace is not None
    assert lci.value == pytest.approx(design.lci(*line.T).min(), abs=1e-6)
    gaps = workspace.region.boundary_distance(line[::20])[0]
    assert distance.value == pytest.approx(gaps.min(), abs=1e-3)
    with pytest.raises(InputError, match="can follow"):
        design.least_on_path([(0.0, 1.0), (3.0, 1.0)])


def test_operating_limits_are_those_of_dense_columns() -> None:
    for design, mode in ((DESIGNS[1], "+-/up"), (DESIGNS[4], "++/down")):
        workspace = design.usable_workspace(mode)
        assert workspace is not None
        found = design.operating_limits(mode, 25)
        for place, theta in enumerate(found.places):
            length = np.linspace(1e-4, 4.0, 3000)
            x, y = -length * math.sin(theta), length * math.cos(theta)
            inside = workspace.contains(x, y)
            if inside.sum() < 50:
                continue
            angles = design.inputs(x[inside], y[inside], mode)
            middle = 0.5 * (found.least[place] + found.greatest[place])
            half = 0.5 * (found.greatest[place] - found.least[place])
            off = np.abs(np.remainder(angles - middle + math.pi, 2.0 * math.pi) - math.pi)
            assert np.all(off <= half + 1e-12)
            assert off.max(axis=0) == pytest.approx(half, abs=0.05)


def test_operating_limits_have_no_gaps_where_intervals_are_narrow() -> None:
    limits = PassiveLeg(1.2, 1.4, 1.2).operating_limits("-+/up", 3601)
    (reached,) = np.nonzero(~np.isnan(limits.least[:, 0]))
    assert len(reached) == reached[-1] - reached[0] + 1
    assert np.degrees(limits.places[reached[-1]]) == pytest.approx(12.7243394, abs=0.05)


def test_a_machine_is_the_design_times_its_base() -> None:
    robot = planar_design(250, 200, 250, 300, mechanism="passive-leg")
    design = PassiveLeg.from_lengths(250, 200, 250, 300)
    assert robot.parameters == (
        ("$R$", 250.0), ("$r$", 200.0), ("$l_a$", 250.0), ("$l_b$", 300.0),
    )  # fmt: skip
    assert design.parameters[1:] == (("$r$", 0.8), ("$l_a$", 1.0), ("$l_b$", 1.2))
    one, other = robot.usable_workspace("+-/up"), design.usable_workspace("+-/up")
    assert one is not None
    assert other is not None
    assert one.area == pytest.approx(250.0**2 * other.area)
    pose = robot.pose(0.0, 250.0, "+-/up")
    assert {link.symbol for link in pose.links} == {"$R$", "$r$", "$l_a$", "$l_b$", "$l_c$", ""}
    report = robot.check_path(np.array([(0.0, 250.0), (500.0, 250.0)]), "+-/up")
    assert report.fault is not None
    assert report.fault.position[0] == pytest.approx(
        250.0 * design.check_path([(0.0, 1.0), (2.0, 1.0)]).fault.position[0]  # type: ignore[union-attr]
    )


def test_the_passive_leg_is_drawn_in_a_sleeve_and_the_platform_as_a_bar() -> None:
    design = DESIGNS[1]
    pose = design.pose(0.3, 1.2, "+-/up")
    figure = linkage_figure(design, [pose])
    lines = {line.get_gid(): line for line in figure.axes[0].lines}
    (leg,) = (k for k, link in enumerate(pose.links, start=1) if link.kind == TELESCOPE)
    sleeve, rod = lines[f"sleeve-{leg}"], lines[f"link-{leg}"]
    assert pytest.approx(np.array([(0.0, 0.0), (0.3, 1.2)])) == np.array(rod.get_data()).T
    x, y = sleeve.get_data()
    assert (x[0], y[0]) == (0.0, 0.0)
    assert x[1] / y[1] == pytest.approx(0.25)
    assert 0.0 < y[1] <= 0.6 * 1.2
    assert sleeve.get_linewidth() > 2.0 * rod.get_linewidth()
    bars = [k for k, link in enumerate(pose.links, start=1) if link.kind == PLATFORM]
    assert len(bars) == 2
    assert all(lines[f"link-{k}"].get_linewidth() > rod.get_linewidth() for k in bars)
    written = [text.get_text() for text in figure.findobj(match=lambda a: hasattr(a, "get_text"))]
    assert any(r"$\phi_1$ = " in text for text in written)
    assert written.count("$O$") == 1


@pytest.mark.parametrize("place", [(0.0, 1.2), (0.3, 1.2), (0.9, 0.1)])
def test_the_name_of_the_passive_leg_is_beside_its_sleeve(place: tuple[float, float]) -> None:
    figure = linkage_figure(DESIGNS[0], [DESIGNS[0].pose(*place, "+-/up")])
    texts = (text for axes in figure.axes for text in axes.texts)
    (name,) = (text for text in texts if text.get_text() == "$l_c$")
    lines = (line for axes in figure.axes for line in axes.lines)
    (sleeve,) = (line for line in lines if str(line.get_gid()).startswith("sleeve"))
    start, end = sleeve.get_transform().transform(np.transpose(sleeve.get_data()))
    along = (end - start) / np.hypot(*(end - start))
    corners = name.get_window_extent().corners() - start
    across = np.abs(corners @ np.array([-along[1], along[0]]))
    half = 0.5 * sleeve.get_linewidth() * figure.dpi / 72.0
    is_beyond = corners @ along > np.hypot(*(end - start))
    assert across.min() > half or is_beyond.all()
