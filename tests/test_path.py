"""Feasibility of paths of the five-bar, between their corners too.

Compared with dense samples of an independent model (``naive``), and with paths laid exactly
beside and through singular loci by plain geometry.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator
from decimal import Decimal, localcontext

import naive
import numpy as np
import pytest
from designs import MODES, random_cases, random_design
from scipy import ndimage

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.five_bar.loci import vertices
from fivebar_atlas.mechanisms.five_bar.path import check_path
from fivebar_atlas.mechanisms.planar import PathReport

Lengths = tuple[float, float, float]
Signs = tuple[int, int, int]
Array = naive.Array

SAMPLES = 100_000


def works(lengths: Lengths, signs: Signs, points: Array) -> naive.Mask:
    """Tell where both legs reach and det B has the sign of the assembly mode."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # out of reach
        determinant = naive.det_b(*lengths, points[..., 0], points[..., 1], *signs[:2])
    return np.asarray(signs[2] * determinant > 0.0)


def components(
    lengths: Lengths, signs: Signs, cells_across: int = 121
) -> tuple[Array, naive.Mask, naive.Mask]:
    """Return cell centres, shape (n, 2), well inside the usable workspace, and inside others.

    Nothing is returned where two components are mirror images, or about as large, and nothing
    of others that come so close that a neck thinner than a cell may lead there.
    """
    x, y = np.meshgrid(*naive.grid(*lengths, cells_across))
    cells = np.stack([x, y], axis=-1)
    labels, count = ndimage.label(works(lengths, signs, cells))
    sizes = np.bincount(labels.ravel())[1:]
    usable, other = np.zeros_like(labels, dtype=bool), np.zeros_like(labels, dtype=bool)
    if count and sorted([0, *sizes])[-2] < 0.9 * sizes.max():
        inner = ndimage.minimum_filter(labels, 5) == ndimage.maximum_filter(labels, 5)
        best = 1 + int(np.argmax(sizes))
        near = np.unique(labels[ndimage.binary_dilation(labels == best, iterations=6)])
        usable = inner & (labels == best)
        other = inner & ~np.isin(labels, [0, *near])
    return cells, usable, other


def random_paths(seed: int, count: int) -> Iterator[tuple[Lengths, Signs, Array]]:
    """Yield designs of all sub-regions, mode pairs, and paths that begin in the workspace."""
    rng = np.random.default_rng(seed)
    for lengths, signs in random_cases(seed, count):
        cells, usable, _ = components(lengths, signs)
        inside = cells[usable]
        if len(inside) < 2:
            continue
        yield lengths, signs, inside[rng.integers(len(inside), size=rng.integers(2, 4))]
        steps = rng.normal(size=(3, 2)) * 10.0 ** rng.uniform(-3.0, 0.0)
        yield (
            lengths,
            signs,
            inside[rng.integers(len(inside))] + np.cumsum(steps, axis=0) - steps[0],
        )


def distance_from_curve(lengths: Lengths, curve: str, x: float, y: float) -> float:
    """Return how far a point is from fulfilling the equation of a locus."""
    r1, r2, r3 = lengths
    height = math.sqrt(max(r1 * r1 - r3 * r3, 0.0))
    if curve == "C_col":
        rho2 = x * x + y * y
        rest = r1 * r1 + r3 * r3 - r2 * r2 - rho2
        return abs(rest * rest * rho2 - 4.0 * r3 * r3 * y * y * (r1 * r1 - rho2))
    centre, radius = {
        "C_1o": ((-r3, 0.0), r1 + r2),
        "C_1i": ((-r3, 0.0), abs(r1 - r2)),
        "C_2o": ((r3, 0.0), r1 + r2),
        "C_2i": ((r3, 0.0), abs(r1 - r2)),
        "C_coin_up": ((0.0, height), r2),
        "C_coin_down": ((0.0, -height), r2),
    }[curve]
    return abs(math.dist((x, y), centre) - radius)


def four_bar(lengths: Lengths, angle: float, side: int) -> tuple[Array, Array, Array]:
    """Return P, B1, B2 with P in the middle of the coupler B1B2; NaN if it cannot be closed."""
    r1, r2, r3 = lengths
    b1 = np.array([-r3 + r1 * math.cos(angle), r1 * math.sin(angle)])
    across = np.array([r3, 0.0]) - b1
    span = float(np.hypot(*across))
    along = (span * span + 4.0 * r2 * r2 - r1 * r1) / (2.0 * span)
    height2 = 4.0 * r2 * r2 - along * along
    height = side * math.sqrt(height2) if height2 >= 0.0 else math.nan
    b2 = b1 + (along * across + height * np.array([-across[1], across[0]])) / span
    return 0.5 * (b1 + b2), b1, b2


def side_of(one: Array, two: Array) -> int:
    return int(np.sign(one[0] * two[1] - one[1] * two[0]))


def test_agrees_with_dense_samples() -> None:
    """Verdict, first fault, angles and LCI, on paths in designs of all sub-regions."""
    shares = np.linspace(0.0, 1.0, SAMPLES)
    feasible = faulty = 0
    for lengths, signs, path in random_paths(20_060_301, 120):
        report = check_path(lengths, signs, path)
        fault = report.fault
        angles = [np.array(naive.inverse_kinematics(*lengths, *path[0], *signs[:2]))]
        for k in range(len(path) - 1):
            line = path[k] + shares[:, None] * (path[k + 1] - path[k])
            run = np.stack(
                naive.inverse_kinematics(*lengths, line[:, 0], line[:, 1], *signs[:2]), axis=1
            )
            b1, b2 = naive.elbows_of_angles(lengths[0], lengths[2], *run.T)
            good = signs[2] * naive.cross(line - b1, line - b2) > 0.0
            if fault is not None and fault.segment == k:
                faulty += 1
                bad = int(np.argmin(good)) if not good.all() else SAMPLES
                # samples may step over a sliver, never find one that is not there
                assert fault.share <= shares[min(bad, SAMPLES - 1)] + 1e-9
                step = fault.share * (SAMPLES - 1)
                if bad < SAMPLES and step < bad - 1.0:
                    assert good[math.ceil(step)]
                position = path[k] + fault.share * (path[k + 1] - path[k])
                np.testing.assert_allclose(fault.position, position, atol=1e-12)
                assert distance_from_curve(lengths, fault.curve, *fault.position) < 1e-11
                break
            assert good.all(), (lengths, signs, path, k)
            angles.append(angles[-1] + np.unwrap(run, axis=0)[-1] - run[0])
        else:
            assert fault is None
            feasible += 1
        followed = len(angles)
        turn = 2.0 * math.pi * np.round((report.inputs[0] - angles[0]) / (2.0 * math.pi))
        np.testing.assert_allclose(report.inputs[:followed], angles + turn, atol=1e-9)
        assert np.all((report.inputs[0] > -math.pi) & (report.inputs[0] <= math.pi))
        expected = naive.lci(*lengths, path[:followed, 0], path[:followed, 1], *signs[:2])
        np.testing.assert_allclose(report.lci[:followed], expected, atol=1e-9)
        for values in (report.inputs, report.lci, report.distances):
            assert np.isfinite(values[:followed]).all()
            assert np.isnan(values[followed:]).all()
        assert all(report.nearest[:followed])
        assert not any(report.nearest[followed:])
    assert feasible > 80
    assert faulty > 50


def test_start_outside_is_refused_with_the_reason() -> None:
    rng = np.random.default_rng(7)
    seen = {"other assembly": 0, "another part": 0, "out of reach": 0}
    for lengths, signs in random_cases(8, 90):
        r1, r2, r3 = lengths
        cells, usable, other = components(lengths, signs, 301)
        if not usable.any() or min(r1, r2) < 0.3:  # rings as thin as a few cells
            continue
        flipped = components(lengths, (signs[0], signs[1], -signs[2]), 301)[1]
        for mask, reason in ((other, "another part"), (flipped, "other assembly")):
            for start in cells[mask][rng.permutation(int(mask.sum()))[:3]]:
                report = check_path(lengths, signs, [start, cells[usable][0]])
                assert report.fault is not None
                assert reason in report.fault.reason, (lengths, signs, start, report.fault)
                assert (report.fault.segment, report.fault.share) == (0, 0.0)
                assert report.fault.position == tuple(start)
                assert report.fault.curve == report.fault.symbol == report.fault.kind == ""
                assert np.isnan(report.inputs).all()
                seen[reason] += 1
        x, y = rng.uniform(-3.0, 3.0, 2)
        reaches = [math.hypot(x + r3, y), math.hypot(x - r3, y)]
        gaps = [max(reach - r1 - r2, abs(r1 - r2) - reach) for reach in reaches]
        if max(gaps) > 0.0:
            report = check_path(lengths, signs, [(x, y)])
            assert report.fault is not None
            worst = int(np.argmax(gaps))
            near = f", too near to A{worst + 1}" if reaches[worst] < abs(r1 - r2) else ""
            beyond = f"{gaps[worst]:.6g}"
            expected = f"P is out of reach of leg {worst + 1}{near}, by {beyond}"
            assert report.fault.reason == expected
            seen["out of reach"] += 1
    assert min(seen.values()) > 20, seen


@pytest.mark.parametrize("depth", [1e-6, 1e-8, 1e-9, 1e-10, 1e-11])
def test_chords_beside_and_through_fold_circles(depth: float) -> None:
    """A tangent of a fold circle, moved by very little to either side of it."""
    rng = np.random.default_rng(11)
    tried = 0
    while tried < 25:
        r1, r2, r3 = lengths = random_design(rng, surrounded=True)
        height, angle = math.sqrt(r1 * r1 - r3 * r3), rng.uniform(-math.pi, math.pi)
        normal = np.array([math.cos(angle), math.sin(angle)])
        tangent = np.array([-normal[1], normal[0]])
        point = np.array([0.0, height]) + r2 * normal
        elbow = np.array([0.0, height])
        bases = np.array([[-r3, 0.0], [r3, 0.0]])
        s1, s2 = (side_of(point - base, elbow - base) for base in bases)
        for assembly in (1, -1):
            signs = (s1, s2, assembly)
            if not works(lengths, signs, point + 1e-3 * normal):
                continue
            line = np.array([point - 0.02 * tangent, point + 0.02 * tangent])
            if not works(lengths, signs, np.linspace(*(line + depth * normal), 2001)).all():
                continue
            beside = check_path(lengths, signs, line + depth * normal)
            if beside.fault is not None and beside.fault.curve == "":
                continue  # in another part of the workspace
            assert beside.feasible
            through = check_path(lengths, signs, line - depth * normal)
            assert through.fault is not None
            assert (through.fault.curve, through.fault.kind) == ("C_coin_up", "parallel, folded")
            assert "B1 and B2 coincide" in through.fault.reason
            half = math.sqrt(depth * (2.0 * r2 - depth))
            # as well as the depth is known
            error = 5e-14 * r2 / half
            assert through.fault.share * 0.04 == pytest.approx(0.02 - half, abs=error)
            tried += 1


@pytest.mark.parametrize("depth", [1e-6, 1e-9, 1e-10])
def test_chords_beside_and_through_coupler_curves(depth: float) -> None:
    """The same for C_col, drawn by a four-bar, also where its two branches nearly coincide."""
    rng = np.random.default_rng(12)
    tried = near_double = 0
    while tried < 40:
        r1, r2, r3 = random_design(rng)
        if tried % 2:
            r3 = 10.0 ** rng.uniform(-8.0, -3.0)
        size = (r1 + r2 + r3) / 3.0
        lengths = (r1 / size, r2 / size, r3 / size)
        angle, side = rng.uniform(-math.pi, math.pi), int(rng.choice([-1, 1]))
        point, b1, b2 = four_bar(lengths, angle, side)
        ahead, behind = (four_bar(lengths, angle + e, side)[0] for e in (1e-5, -1e-5))
        tangent = ahead - behind
        if not np.hypot(*tangent) > 1e-6:
            continue
        tangent /= np.hypot(*tangent)
        normal = np.array([-tangent[1], tangent[0]])
        base = np.array([lengths[2], 0.0])
        s1, s2 = side_of(point + base, b1 + base), side_of(point - base, b2 - base)
        for assembly, away in ((1, normal), (1, -normal), (-1, normal), (-1, -normal)):
            signs = (s1, s2, assembly)
            if 0 in signs or not works(lengths, signs, point + 1e-3 * away):
                continue
            line = np.array([point - 0.02 * tangent, point + 0.02 * tangent])
            if not works(lengths, signs, np.linspace(*(line + depth * away), 2001)).all():
                continue  # it crosses the curve where it bends the other way
            beside = check_path(lengths, signs, line + depth * away)
            if beside.fault is not None and beside.fault.curve == "":
                continue
            assert beside.feasible, (lengths, signs, line)
            through = check_path(lengths, signs, line - depth * away)
            assert through.fault is not None
            assert (through.fault.curve, through.fault.kind) == ("C_col", "parallel, extended")
            assert distance_from_curve(lengths, "C_col", *through.fault.position) < 1e-11
            assert not works(lengths, signs, point - depth * away)
            tried += 1
            near_double += lengths[2] < 1e-3
    assert near_double > 5


def test_chords_through_nodes_of_the_coupler_curve() -> None:
    """Where the two branches of C_col cross, roots of three kinds nearly coincide.

    A chord of the one branch, 1e-6 long, next to a crossing with the other, which is singular
    in other modes only: rounding scatters the roots farther than the chord is long.
    """
    rng = np.random.default_rng(13)
    tried = 0
    while tried < 250:
        r1, r2, r3 = lengths = random_design(rng)
        x2 = r1 * r1 + r3 * r3 - r2 * r2
        if not 0.0 < x2 < r1 * r1:
            continue
        # at a node crank A1B1 is (x, ±√(r1² - x²))
        turn = rng.choice([-1.0, 1.0]) * math.acos(rng.choice([-1.0, 1.0]) * math.sqrt(x2) / r1)
        side = min((-1, 1), key=lambda s: abs(four_bar(lengths, turn, s)[0][1]))
        turn += rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-7.5, -4.5)
        point, b1, b2 = four_bar(lengths, turn, side)
        tangent = four_bar(lengths, turn + 1e-5, side)[0] - four_bar(lengths, turn - 1e-5, side)[0]
        if not np.hypot(*tangent) > 1e-6:
            continue
        tangent /= np.hypot(*tangent)
        normal = np.array([-tangent[1], tangent[0]])
        base = np.array([r3, 0.0])
        s1, s2 = side_of(point + base, b1 + base), side_of(point - base, b2 - base)
        for assembly, away in ((1, normal), (1, -normal), (-1, normal), (-1, -normal)):
            signs = (s1, s2, assembly)
            if 0 in signs or not works(lengths, signs, point + 1e-3 * away):
                continue
            reach = rng.uniform(0.004, 0.02, size=(2, 1)) * [[-1.0], [1.0]]
            line = point + reach * tangent
            if not works(lengths, signs, np.linspace(*(line + 1e-11 * away), 1001)).all():
                continue  # it crosses the curve where it bends the other way
            beside = check_path(lengths, signs, line + 1e-11 * away)
            if beside.fault is not None and beside.fault.curve == "":
                continue
            assert beside.feasible
            depth = rng.uniform(1.2e-12, 2e-12)
            assert not check_path(lengths, signs, line - depth * away).feasible
            tried += 1


def test_crossings_of_the_coupler_curve_are_exact() -> None:
    """Newton's method with fifty digits finds the roots of the polynomial again.

    Also at small angles, where a root is known to rounding over the angle, and where both
    branches nearly coincide, so that the roots of the polynomial are known to half the digits.
    """
    rng = np.random.default_rng(14)
    found = 0
    while found < 120:
        r1, r2, r3 = random_design(rng)
        if found % 2:
            r3 = 10.0 ** rng.uniform(-7.0, -2.0)
        size = (r1 + r2 + r3) / 3.0
        lengths = (r1 / size, r2 / size, r3 / size)
        turn, side = rng.uniform(-math.pi, math.pi), int(rng.choice([-1, 1]))
        point, b1, b2 = four_bar(lengths, turn, side)
        tangent = four_bar(lengths, turn + 1e-5, side)[0] - four_bar(lengths, turn - 1e-5, side)[0]
        if not np.hypot(*tangent) > 1e-6:
            continue
        tangent /= np.hypot(*tangent)
        normal = np.array([-tangent[1], tangent[0]])
        angle = 10.0 ** rng.uniform(-3.0, 0.0)
        along = math.cos(angle) * tangent + math.sin(angle) * rng.choice([-1.0, 1.0]) * normal
        line = point + rng.uniform(0.004, 0.02, size=(2, 1)) * [[-1.0], [1.0]] * along
        base = np.array([lengths[2], 0.0])
        for assembly in (1, -1):
            signs = (side_of(point + base, b1 + base), side_of(point - base, b2 - base), assembly)
            fault = check_path(lengths, signs, line).fault if 0 not in signs else None
            if fault is None or fault.curve != "C_col":
                continue
            error = share_error(lengths, line, fault.share) * math.dist(*line)
            assert error < 2e-15 / math.sin(angle)
            found += 1


def share_error(lengths: Lengths, line: Array, share: float) -> float:
    """Return how far on a segment the root of the equation of C_col is from a share."""
    r1, r2, r3 = (Decimal(length) for length in lengths)
    (x0, y0), (x1, y1) = ((Decimal(float(x)), Decimal(float(y))) for x, y in line)

    def equation(at: Decimal) -> Decimal:
        x, y = x0 + at * (x1 - x0), y0 + at * (y1 - y0)
        rho2 = x * x + y * y
        rest = r1 * r1 + r3 * r3 - r2 * r2 - rho2
        return rest * rest * rho2 - 4 * r3 * r3 * y * y * (r1 * r1 - rho2)

    with localcontext(prec=50):
        root, nearby = Decimal(share), Decimal("1e-20")
        for _ in range(40):
            high, low = equation(root + nearby), equation(root - nearby)
            root -= nearby * (high + low) / (high - low)
        return abs(float(root - Decimal(share)))


@pytest.mark.parametrize("gap", [1e-6, 1e-10])
def test_reach_circles_within_a_hair(gap: float) -> None:
    lengths, signs = (1.3, 1.6, 0.1), (1, -1, 1)
    centre, inner, outer = np.array([-0.1, 0.0]), 0.3, 2.9
    # a tangent of the inner circle of leg 1, away from that of leg 2
    normal = np.array([-0.8, 0.6])
    tangent = np.array([0.6, 0.8])
    line = centre + np.array([[-0.1], [0.1]]) * tangent
    assert check_path(lengths, signs, line + (inner + gap) * normal).feasible
    fault = check_path(lengths, signs, line + (inner - gap) * normal).fault
    assert fault is not None
    assert (fault.segment, fault.curve, fault.kind) == (0, "C_1i", "serial")
    assert fault.reason == "meets C_1i: leg 1 is folded"
    assert math.dist(fault.position, centre) == pytest.approx(inner, abs=1e-13)
    # corners next to the outer circle of leg 1, which lies within that of leg 2 on the right
    normal = np.array([0.8, 0.6])
    start, end = centre + 2.0 * normal, centre + (outer - gap) * normal
    report = check_path(lengths, signs, [start, end])
    assert report.feasible
    assert report.distances[1] == pytest.approx(gap, rel=1e-5)
    assert report.nearest[1] == "C_1o"
    fault = check_path(lengths, signs, [start, centre + (outer + gap) * normal]).fault
    assert fault is not None
    assert (fault.curve, fault.reason) == ("C_1o", "meets C_1o: leg 1 is stretched")
    np.testing.assert_allclose(fault.position, centre + outer * normal, atol=1e-13)


def test_first_of_two_loci_a_hair_apart() -> None:
    """Next to their tangency a fold circle runs within 1e-9 of a reach circle."""
    found = 0
    for lengths in ((1.2, 1.0, 0.8), (1.4, 1.0, 0.6), (1.1, 1.2, 0.7)):
        r1, r2, r3 = lengths
        height = math.sqrt(r1 * r1 - r3 * r3)
        fold, base = np.array([0.0, height]), np.array([r3, 0.0])
        for leg, outer in ((1, True), (2, True), (1, False), (2, False)):
            joint = -base if leg == 1 else base
            way = (fold - joint) / r1
            corner = math.atan2(*((way if outer else -way)[::-1]))
            gap = 1e-9
            reach = r1 + r2 if outer else abs(r1 - r2)
            curvature = abs(1.0 / r2 - (1.0 if outer or r2 > r1 else -1.0) / reach)
            turn = math.sqrt(2.0 * gap / curvature) / r2
            for angle in (corner + turn, corner - turn):
                normal = np.array([math.cos(angle), math.sin(angle)])
                point = fold + r2 * normal
                s1, s2 = (side_of(point - b, fold - b) for b in (-base, base))
                for assembly in (1, -1):
                    signs = (s1, s2, assembly)
                    for direction in (normal, -normal):
                        path = np.array([point - 0.05 * direction, point + 1e-7 * direction])
                        line = path[0] + np.linspace(0.0, 0.99, 1000)[:, None] * (path[1] - path[0])
                        if not works(lengths, signs, line).all():
                            continue
                        fault = check_path(lengths, signs, path).fault
                        assert fault is not None
                        if fault.curve == "":
                            continue  # in another part of the workspace
                        assert fault.curve == "C_coin_up", (lengths, signs, leg, outer)
                        np.testing.assert_allclose(fault.position, point, atol=1e-12)
                        found += 1
    assert found >= 6


@pytest.mark.parametrize("lengths", [(1.0, 1.0, 1.0), (0.9, 1.2, 0.9), (0.7, 1.6, 0.7)])
def test_fold_circles_in_one_stop_a_path(lengths: Lengths) -> None:
    """Where r1 = r3, det B is zero on the circle about the origin but keeps its sign."""
    _, r2, _ = lengths
    stopped = 0
    for signs in MODES:
        for angle in np.linspace(0.05, 2.0 * math.pi, 40):
            ray = np.array([math.cos(angle), math.sin(angle)])
            line = r2 * np.linspace(0.9, 1.1, 1000)[:, None] * ray
            point = r2 * ray
            near = naive.det_b(*lengths, *point, *signs[:2]) if works_all(lengths, point) else 1.0
            if abs(near) > 1e-9 or not works(lengths, signs, line).all():
                continue
            fault = check_path(lengths, signs, line[[0, -1]]).fault
            assert fault is not None
            if fault.curve == "":
                continue
            assert (fault.curve, fault.kind) == ("C_coin_up", "parallel, folded")
            np.testing.assert_allclose(fault.position, point, atol=1e-12)
            stopped += 1
    assert stopped > 10


def works_all(lengths: Lengths, point: Array) -> bool:
    """Tell whether both legs reach a point."""
    r1, r2, r3 = lengths
    reaches = np.hypot(point[0] + np.array([r3, -r3]), point[1])
    return bool(np.all((reaches > abs(r1 - r2)) & (reaches < r1 + r2)))


def test_base_joints_are_singular_points_where_cranks_equal_distal_links() -> None:
    fault = check_path((1.5, 1.5, 0.0), (1, -1, 1), [(1.0, 1.0), (-2.0, -2.0)]).fault
    assert fault is not None
    assert (fault.curve, fault.kind) == ("C_1i", "serial")
    np.testing.assert_allclose(fault.position, 0.0, atol=1e-12)
    assert fault.share == pytest.approx(1.0 / 3.0, abs=1e-12)
    # past it, however closely, both cranks turn about with P
    for offset, turn in ((1e-9, math.pi), (-1e-9, -math.pi)):
        report = check_path((1.5, 1.5, 0.0), (1, -1, 1), [(1.0, -offset), (-1.0, -offset)])
        assert report.feasible
        np.testing.assert_allclose(report.inputs[1] - report.inputs[0], -turn, atol=1e-8)
        assert report.nearest[0] == "C_1i"
        assert report.distances[0] == pytest.approx(1.0)
    # a joint that no more than one leg starts from
    fault = check_path((1.4, 1.4, 0.2), (1, -1, -1), [(0.2, 0.5), (0.2, -0.5)]).fault
    assert fault is not None
    assert (fault.curve, fault.reason) == ("C_2i", "meets C_2i: leg 2 is folded")
    np.testing.assert_allclose(fault.position, (0.2, 0.0), atol=1e-12)
    # past it crank 2 turns so far, one way or the other, that the distal links get in line;
    # closer than the tolerance it is the joint that is met
    for x, curve in (
        (0.2 + 1e-3, "C_col"),
        (0.2 + 2e-12, "C_col"),
        (0.2 + 5e-13, "C_2i"),
        (0.2 - 5e-13, "C_2i"),
        (0.2 - 2e-12, "C_coin_up"),
        (0.2 - 1e-3, "C_coin_up"),
    ):
        fault = check_path((1.4, 1.4, 0.2), (1, -1, -1), [(x, 0.5), (x, -0.5)]).fault
        assert fault is not None
        assert fault.curve == curve


@pytest.mark.parametrize("corners", [3, 4, 5, 60])
@pytest.mark.parametrize("direction", [1, -1])
def test_inputs_turn_with_p_about_a_common_base_joint(corners: int, direction: int) -> None:
    turns = 3
    angles = direction * np.linspace(0.0, 2.0 * math.pi * turns, turns * corners + 1) + 0.1
    path = 2.5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    report = check_path((1.28, 1.72, 0.0), (1, -1, 1), path)
    assert report.feasible
    change = report.inputs - report.inputs[0]
    np.testing.assert_allclose(change, (angles - angles[0])[:, None] * [1.0, 1.0], atol=1e-12)


def mirrored(name: str, x: bool, y: bool) -> str:
    if x and name[2] in "12":
        name = f"C_{3 - int(name[2])}{name[3]}"
    if y:
        swap = {"C_coin_up": "C_coin_down", "C_coin_down": "C_coin_up"}
        name = swap.get(name, name)
    return name


@pytest.mark.parametrize(("x", "y"), [(True, False), (False, True), (True, True)])
def test_mirrored_paths_get_mirrored_reports(x: bool, y: bool) -> None:
    """The symmetries that take every mode pair to three others."""
    compared = faulty = named = 0
    for lengths, signs, path in random_paths(31, 60):
        one = check_path(lengths, signs, path)
        s1, s2, assembly = signs
        if x:
            s1, s2 = -s2, -s1
        if y:
            s1, s2, assembly = -s1, -s2, -assembly
        image = path * [-1.0 if x else 1.0, -1.0 if y else 1.0]
        two = check_path(lengths, (s1, s2, assembly), image)
        assert two.feasible == one.feasible
        if one.fault is not None and two.fault is not None:
            assert two.fault.segment == one.fault.segment
            assert two.fault.share == pytest.approx(one.fault.share, abs=1e-9)
            assert two.fault.curve == mirrored(one.fault.curve, x, y)
            assert two.fault.kind == one.fault.kind
            faulty += 1
        np.testing.assert_allclose(two.lci, one.lci, atol=1e-12)
        np.testing.assert_allclose(two.distances, one.distances, atol=1e-9)
        for k, near in enumerate(one.nearest):
            # where two arcs meet, or on the axis of symmetry, either of two may be named
            ends = [abs(math.dist(path[k], end) - one.distances[k]) for end in vertices(lengths)]
            if not min(*ends, abs(path[k, 0])) < 1e-9:
                assert two.nearest[k] == (mirrored(near, x, y) if near else "")
                named += near != ""
        changes = one.inputs - one.inputs[0]
        if x:
            changes = -changes[:, ::-1]
        if y:
            changes = -changes
        np.testing.assert_allclose(two.inputs - two.inputs[0], changes, atol=1e-9)
        compared += 1
    assert compared > 60
    assert faulty > 15
    assert named > 100


def test_corners_within_segments_change_nothing() -> None:
    """Many short segments, most of which are seen to be regular without any roots."""
    for lengths, signs, path in random_paths(41, 60):
        one = check_path(lengths, signs, path)
        pieces = 200
        shares = np.arange(pieces)[:, None] / pieces
        fine = np.concatenate(
            [start + shares * (end - start) for start, end in itertools.pairwise(path)]
            + [path[-1:]]
        )
        two = check_path(lengths, signs, fine)
        assert two.feasible == one.feasible
        if one.fault is not None and two.fault is not None:
            assert two.fault.curve == one.fault.curve
            np.testing.assert_allclose(two.fault.position, one.fault.position, atol=1e-9)
            place = (two.fault.segment + two.fault.share) / pieces
            assert place == pytest.approx(one.fault.segment + one.fault.share, abs=1e-6)
        np.testing.assert_allclose(two.inputs[::pieces], one.inputs, atol=1e-9)


def test_distances_are_those_of_the_nearest_singular_point() -> None:
    """Within the distance all is regular; a little beyond it, not all."""
    rng = np.random.default_rng(51)
    angles = np.linspace(0.0, 2.0 * math.pi, 20_001)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for lengths, signs in [*random_cases(52, 40), ((1.4, 1.4, 0.2), (1, -1, 1))]:
        cells, usable, _ = components(lengths, signs)
        for point in cells[usable][rng.permutation(int(usable.sum()))[:3]]:
            report = check_path(lengths, signs, [point])
            distance = report.distances[0]
            for share in (0.3, 0.8, 1.0 - 1e-6):
                assert works(lengths, signs, point + share * distance * ring).all()
            if math.dist(point, (math.copysign(lengths[2], point[0]), 0.0)) > distance + 1e-9:
                assert not works(lengths, signs, point + (1.0 + 1e-4) * distance * ring).all()
            else:
                assert lengths[0] == lengths[1]


def test_corners_may_repeat_and_lie_on_the_boundary() -> None:
    lengths, signs = (1.28, 1.72, 0.0), (1, -1, 1)
    one = check_path(lengths, signs, [(0.0, 2.0)] * 3)
    assert one.feasible
    np.testing.assert_array_equal(one.inputs, one.inputs[[0, 0, 0]])
    fault = check_path(lengths, signs, [(0.0, 2.0), (0.0, 2.0), (0.0, 3.0), (0.0, 2.0)]).fault
    assert fault is not None
    assert (fault.segment, fault.share, fault.position) == (1, 1.0, (0.0, 3.0))
    fault = check_path(lengths, signs, [(3.0, 0.0), (2.0, 0.0)]).fault
    assert fault is not None
    assert (fault.segment, fault.share, fault.curve) == (0, 0.0, "C_1o")


def test_the_origin_may_be_a_start() -> None:
    """The middle of the base lies on every ray that the workspace is described by."""
    lengths, signs = (1.333625, 0.98255, 0.683825), (1, -1, 1)
    assert check_path(lengths, signs, [(0.0, 0.0), (0.0, -0.01)]).feasible
    assert check_path(lengths, signs, [(0.0, -0.01), (0.0, 0.0)]).feasible


def test_empty_workspace_is_a_fault() -> None:
    report: PathReport = check_path((1.28, 1.72, 0.0), (1, 1, 1), [(0.0, 2.0)])
    assert report.fault is not None
    assert report.fault.reason == "the usable workspace of ++/up is empty"
    assert report.nearest == ("",)


@pytest.mark.parametrize(
    ("points", "name"),
    [
        (np.empty((0, 2)), "points"),
        ([], "points"),
        ([1.0, 2.0], "points"),
        ([(1.0, 2.0, 3.0)], "points"),
        ([(0.0, 2.0), (0.0, math.nan)], "points[1]"),
        ([(0.0, 2.0), (0.0, 2.0), (-math.inf, 0.0)], "points[2]"),
    ],
)
def test_points_that_are_none_are_refused(points: Array, name: str) -> None:
    with pytest.raises(InputError) as caught:
        check_path((1.28, 1.72, 0.0), (1, -1, 1), points)
    assert caught.value.name == name


def test_far_corners_are_met_on_the_way() -> None:
    fault = check_path((1.28, 1.72, 0.0), (1, -1, 1), [(0.0, 2.0), (1e50, 2.0)]).fault
    assert fault is not None
    np.testing.assert_allclose(fault.position, (math.sqrt(5.0), 2.0), atol=1e-12)
