"""Quadrature rules, root brackets, circle arcs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from shapely import Point

from fivebar_atlas.numerics.arcs import (
    circle_discriminant,
    circle_radius,
    circle_swept_area,
    lens_area,
)
from fivebar_atlas.numerics.quadrature import (
    cluster,
    cluster_inverse,
    cluster_slope,
    clustered_gauss_kronrod,
    gauss_kronrod,
    kronrod_error,
)
from fivebar_atlas.numerics.roots import (
    FOUND,
    first_sections,
    first_share,
    next_section,
    next_share,
)

pytestmark = pytest.mark.nojit


@pytest.mark.parametrize("n", [3, 7, 11, 15, 23, 31])
def test_gauss_kronrod_is_exact_for_polynomials(n: int) -> None:
    rule = gauss_kronrod(n)
    assert len(rule.nodes) == 2 * n + 1
    assert np.all(rule.weights > 0.0)
    assert np.all(np.diff(rule.nodes) > 0.0)
    for degree in range(3 * n + 2):
        assert rule.weights @ rule.nodes**degree == pytest.approx(1.0 / (degree + 1), abs=5e-15)
    for degree in range(2 * n):
        exact = 1.0 / (degree + 1)
        assert rule.gauss_weights @ rule.nodes**degree == pytest.approx(exact, abs=5e-15)


def test_seven_fifteen_pair_has_the_published_nodes() -> None:
    # Piessens et al., QUADPACK (1983), the (7, 15) pair
    rule = gauss_kronrod(7)
    assert 2.0 * rule.nodes[-1] - 1.0 == pytest.approx(0.991455371120812639206854697526329)
    assert 2.0 * rule.weights[7] == pytest.approx(0.209482141084727828012999174891714)


def test_clustered_rule_integrates_square_root_ends() -> None:
    errors = []
    for n in (3, 7, 11):
        rule = clustered_gauss_kronrod(n)
        value = rule.weights @ np.sqrt(rule.nodes * (1.0 - rule.nodes))
        errors.append(abs(value - math.pi / 8.0))
    assert errors[0] < 1e-4
    assert errors[1] < 1e-8
    assert errors[2] < 1e-12


def test_cluster_slope_is_the_derivative_of_cluster() -> None:
    for v in np.linspace(0.0, 1.0, 11):
        difference = (cluster(v + 1e-6) - cluster(v - 1e-6)) / 2e-6
        assert cluster_inverse(cluster(v)) == pytest.approx(v, abs=1e-7)
        assert cluster_slope(v) == pytest.approx(difference, abs=1e-9)


def test_kronrod_error_lies_between_its_bounds() -> None:
    assert kronrod_error(0.0, 1.0, 0.1) == 0.0
    assert kronrod_error(1e-2, 1.0, 0.1) == 1e-2  # no gain while the rule is coarse
    assert kronrod_error(1e-12, 1.0, 0.1) == pytest.approx(1e-13)
    assert kronrod_error(1e-12, 1.0, 1.0) == 1e-12
    assert kronrod_error(1e-4, 1.0, 0.1) == pytest.approx(20.0 * 1e-6)


@pytest.mark.parametrize(
    ("function", "root"),
    [
        (lambda x: x**3 - 0.2, 0.2 ** (1.0 / 3.0)),
        (lambda x: math.cos(3.0 * x), math.pi / 6.0),
        (lambda x: 1e-4 - x * x, 1e-2),  # next to a turning point, where secants stall
        (lambda x: math.copysign(abs(x - 0.7) ** 0.2, x - 0.7), 0.7),
    ],
)
def test_bracket_steps_find_the_root(function: Callable[[float], float], root: float) -> None:
    x1, x2 = 0.0, 1.0
    f1, f2 = function(x1), function(x2)
    share = first_share(f1, f2)
    steps = 0
    while share != FOUND:
        x = x1 + share * (x2 - x1)
        f = function(x)
        if (f > 0.0) == (f1 > 0.0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = x, f
        share = next_share(x1, f1, x2, f2, x3, f3, 1e-13)
        steps += 1
    assert x1 == pytest.approx(root, abs=1e-12)
    assert steps <= 50


@pytest.mark.parametrize("turning", [0.05, 0.37, 0.5, 0.93])
def test_golden_sections_walk_down_to_a_turning_point(turning: float) -> None:
    def function(x: float) -> float:
        return (x - turning) ** 2 - 1e-9

    left, right = 0.0, 1.0
    x1, x2 = first_sections(left, right)
    assert right - x2 == pytest.approx(x1 - left, rel=1e-12)
    y1 = y2 = math.nan
    for step in range(30):
        wide = right - left
        left, right, x1, y1, x2, y2, trial = next_section(step, left, right, x1, y1, x2, y2)
        assert left < x1 < x2 < right
        assert left < turning < right
        assert (right - left) / wide == pytest.approx(1.0 if step < 2 else 0.618034, rel=1e-2)
        assert trial in (x1, x2)
        if trial == x1:
            y1 = function(trial)
        else:
            y2 = function(trial)
    # low enough to show the two roots beside it
    assert min(y1, y2) < 0.0


def test_circle_radius_lies_on_the_circle() -> None:
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(200):
        a, b, radius = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.1, 2.0)
        phi = rng.uniform(-math.pi, math.pi)
        c, s = math.cos(phi), math.sin(phi)
        if circle_discriminant(a, b, radius, c, s) < 0.0:
            continue
        for sheet in (1.0, -1.0):
            rho = circle_radius(a, b, radius, sheet, c, s)
            assert math.hypot(rho * c - a, rho * s - b) == pytest.approx(radius, rel=1e-13)
            hits += 1
    assert hits > 200


def test_swept_area_of_a_whole_circle_around_the_origin() -> None:
    a, radius = 0.3, 1.2
    total = 0.0
    angles = np.linspace(-math.pi, math.pi, 8)
    for phi0, phi1 in itertools.pairwise(angles):
        rho0 = circle_radius(a, 0.0, radius, 1.0, math.cos(phi0), math.sin(phi0))
        rho1 = circle_radius(a, 0.0, radius, 1.0, math.cos(phi1), math.sin(phi1))
        total += circle_swept_area(
            a, 0.0, radius, 1.0,
            rho0 * math.cos(phi0), rho0 * math.sin(phi0),
            rho1 * math.cos(phi1), rho1 * math.sin(phi1),
        )  # fmt: skip
    assert total == pytest.approx(math.pi * radius**2, rel=1e-14)


def test_lens_area_against_polygons() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        r0, r1, distance = rng.uniform(0.2, 2.0), rng.uniform(0.2, 2.0), rng.uniform(0.0, 3.0)
        first = Point(0.0, 0.0).buffer(r0, quad_segs=2000)
        second = Point(distance, 0.0).buffer(r1, quad_segs=2000)
        assert lens_area(r0, r1, distance) == pytest.approx(
            first.intersection(second).area, abs=1e-5
        )
    assert lens_area(0.0, 1.0, 0.5) == 0.0
    assert lens_area(1.0, 1.0, 0.0) == pytest.approx(math.pi)
