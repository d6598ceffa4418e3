"""Singular loci, critical angles and isotropic points of the five-bar."""

from __future__ import annotations

import itertools
import math

import naive
import numpy as np
import pytest
from designs import random_cases, random_design

from fivebar_atlas.mechanisms.five_bar import singularity as loci
from fivebar_atlas.mechanisms.five_bar.isotropy import MAX_ISOTROPIC, isotropic_points
from fivebar_atlas.mechanisms.five_bar.jacobian import lci
from fivebar_atlas.mechanisms.five_bar.workspace import (
    DECOMPOSITION,
    collect_strips,
    decompose,
    largest_component,
)
from fivebar_atlas.numerics.records import allocate_record

pytestmark = pytest.mark.nojit

REACH = range(loci.C_1O, loci.FOLD_UP_FAR)
FOLD = range(loci.FOLD_UP_FAR, loci.COUPLER_PLUS)
COUPLER = range(loci.COUPLER_PLUS, loci.CURVES)


def boundary_arcs(
    design: tuple[float, float, float], mode: tuple[int, int, int]
) -> list[tuple[int, float, float]]:
    """Return (curve, start, end) of the arcs that bound a usable workspace."""
    d = allocate_record(DECOMPOSITION)
    s1, s2, assembly = (float(sign) for sign in mode)
    sectors = decompose(*design, s1, s2, assembly, d)
    component, _ = largest_component(d, *design, s1 != s2, sectors)
    if component < 0:
        return []
    strips = collect_strips(d, *design, sectors, component)
    return [
        (int(curves[k]), float(d.strip_from[k]), float(d.strip_to[k]))
        for k in range(strips)
        for curves in (d.strip_lower, d.strip_upper)
        if curves[k] != loci.ORIGIN
    ]


def test_every_boundary_arc_is_singular() -> None:
    kinds = set()
    for design, mode in random_cases(30, 60):
        r1, r2, r3 = design
        for curve, start, end in boundary_arcs(design, mode):
            for phi in np.linspace(start, end, 7)[1:-1]:
                rho = loci.radius_along(curve, r1, r2, r3, math.cos(phi), math.sin(phi))
                x, y = rho * math.cos(phi), rho * math.sin(phi)
                if curve in REACH:
                    base = -r3 if curve in (loci.C_1O, loci.C_1I_FAR, loci.C_1I_NEAR) else r3
                    reach = r1 + r2 if curve <= loci.C_2O else abs(r1 - r2)
                    assert math.hypot(x - base, y) == pytest.approx(reach, abs=1e-12)
                    kinds.add("serial")
                    continue
                # measured with the independent elbows, whose square root halves the digits
                b1, b2 = naive.elbows(r1, r2, r3, x, y, mode[0], mode[1])
                if np.any(np.isnan(b1)) or np.any(np.isnan(b2)):
                    continue  # at a tangency with a reach circle, beyond reach by rounding
                if curve in FOLD:
                    assert np.hypot(*(b1 - b2)) < 1e-6
                    kinds.add("fold")
                else:
                    np.testing.assert_allclose((b1 + b2) / 2.0, [x, y], atol=1e-6)
                    kinds.add("coupler")
    assert kinds == {"serial", "fold", "coupler"}


def test_coupler_curve_is_the_middle_of_a_four_bar() -> None:
    rng = np.random.default_rng(1)
    points = 0
    for _ in range(100):
        r1, r2, r3 = random_design(rng)
        for curve in COUPLER:
            phi = rng.uniform(-math.pi, math.pi)
            c, s = math.cos(phi), math.sin(phi)
            if not loci.exists(curve, r1, r2, r3, c, s):
                continue
            rho = loci.radius_along(curve, r1, r2, r3, c, s)
            branch = 1.0 if curve == loci.COUPLER_PLUS else -1.0
            along, across = r3 * c, -branch * math.sqrt(loci.coupler_root(r2, r3, c))
            ex, ey = along * c - across * s, along * s + across * c
            # B1 and B2 lie r2 to either side of P and r1 from their base joints
            b1, b2 = (rho * c - ex, rho * s - ey), (rho * c + ex, rho * s + ey)
            assert math.hypot(b1[0] + r3, b1[1]) == pytest.approx(r1, abs=1e-12)
            assert math.hypot(b2[0] - r3, b2[1]) == pytest.approx(r1, abs=1e-12)
            points += 1
    assert points > 50


def test_rate_of_the_coupler_curve() -> None:
    rng = np.random.default_rng(2)
    checked = 0
    for _ in range(100):
        r1, r2, r3 = random_design(rng)
        phi = rng.uniform(-math.pi, math.pi)
        for curve, branch in ((loci.COUPLER_PLUS, 1.0), (loci.COUPLER_MINUS, -1.0)):
            c, s = math.cos(phi), math.sin(phi)
            if loci.coupler_root(r2, r3, c) < 1e-2:
                continue
            h = 1e-6
            ahead, behind = (
                loci.coupler_squared_radius(r1, r2, r3, branch, math.cos(a), math.sin(a))
                for a in (phi + h, phi - h)
            )
            rate = loci.coupler_radius_rate(curve, r2, r3, c, s)
            assert rate == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-6)
            checked += 1
    assert checked > 50


def test_swept_areas_by_quadrature() -> None:
    rng = np.random.default_rng(3)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    checked = set()
    for _ in range(60):
        r1, r2, r3 = random_design(rng)
        start = rng.uniform(-math.pi, math.pi)
        end = start + rng.uniform(0.0, 0.3)
        angles = 0.5 * (start + end) + 0.5 * (end - start) * nodes
        for curve in range(loci.C_1O, loci.CURVES):
            if not all(
                loci.exists(curve, r1, r2, r3, math.cos(a), math.sin(a))
                for a in np.linspace(start - 0.1, end + 0.1, 40)
            ):
                continue
            radii = np.array(
                [loci.radius_along(curve, r1, r2, r3, math.cos(a), math.sin(a)) for a in angles]
            )
            numeric = 0.25 * (end - start) * (weights @ radii**2)
            area = loci.swept_area(curve, r1, r2, r3, start, end)
            assert area == pytest.approx(numeric, rel=1e-9, abs=1e-12)
            checked.add(curve)
    assert checked == set(range(loci.C_1O, loci.CURVES))


def test_order_of_curves_is_constant_between_critical_angles() -> None:
    rng = np.random.default_rng(4)
    out = np.zeros(loci.MAX_CRITICAL)
    for (r1, r2, r3), (s1, s2, _) in random_cases(31, 30):
        count = loci.critical_angles(r1, r2, r3, -0.5 * math.pi, 1.5 * math.pi, out)
        assert count <= loci.MAX_CRITICAL - 4
        assert np.all(np.diff(out[:count]) > 0.0)
        for start, end in itertools.pairwise(out[:count]):
            if end - start < 1e-6:
                continue
            orders = set()
            for share in (0.02, *rng.uniform(0.02, 0.98, 4), 0.98):
                phi = start + share * (end - start)
                c, s = math.cos(phi), math.sin(phi)
                met = [
                    curve
                    for curve in range(loci.C_1O, loci.CURVES)
                    if loci.exists(curve, r1, r2, r3, c, s)
                    and (
                        curve in REACH
                        or loci.belongs_to_mode(curve, r1, r2, r3, c, s, float(s1), float(s2))
                    )
                ]
                radii = {k: loci.radius_along(k, r1, r2, r3, c, s) for k in met}
                orders.add(tuple(sorted(met, key=radii.__getitem__)))
            assert len(orders) == 1


def test_isotropic_points_have_index_one() -> None:
    out = np.zeros((MAX_ISOTROPIC, 2))
    found = 0
    for (r1, r2, r3), (s1, s2, _) in random_cases(32, 200):
        count = isotropic_points(r1, r2, r3, float(s1), float(s2), out)
        for x, y in out[:count]:
            assert lci(r1, r2, r3, x, y, float(s1), float(s2)) == pytest.approx(1.0, abs=1e-6)
            on_axis = x == 0.0
            on_circle = math.isclose(x * x + y * y, r1 * r1 + r2 * r2 - r3 * r3, abs_tol=1e-9)
            assert on_axis or on_circle
            found += 1
    assert found > 100


def test_no_isotropic_point_is_missed() -> None:
    out = np.zeros((MAX_ISOTROPIC, 2))
    seen = 0
    for design, (s1, s2, assembly) in random_cases(33, 40):
        values = naive.evaluate(*design, s1, s2, assembly, n=251)
        if not values["max_lci"] > 0.985 or design[2] < 0.05:
            continue  # near r3 = 0 isotropic points come close to a ring
        count = isotropic_points(*design, float(s1), float(s2), out)
        distance = np.hypot(
            out[:count, 0] - values["max_lci_x"], out[:count, 1] - values["max_lci_y"]
        )
        assert count > 0
        assert distance.min() < 0.1
        seen += 1
    assert seen >= 4


def test_kinds_of_singularity() -> None:
    def kind(design: tuple[float, float, float], x: float, y: float, s1: float, s2: float) -> int:
        return loci.singularity_kind(*design, x, y, s1, s2, 1e-7)

    design = (1.2, 1.0, 0.8)
    assert kind(design, 0.0, 1.0, 1.0, -1.0) == 0
    # leg 1 stretched along 60 degrees
    x, y = 2.2 * 0.5 - 0.8, 2.2 * math.sqrt(0.75)
    assert kind(design, x, y, 1.0, -1.0) & loci.SERIAL_LEG_1
    # elbows together above the base, P to the side
    height = math.sqrt(1.2**2 - 0.8**2)
    x, y = math.cos(0.5), height + math.sin(0.5)
    folded = [
        (s1, s2)
        for s1 in (1.0, -1.0)
        for s2 in (1.0, -1.0)
        if kind(design, x, y, s1, s2) & loci.PARALLEL_FOLDED
    ]
    assert len(folded) == 1  # each locus belongs to one working mode at a time
    rho = loci.radius_along(loci.COUPLER_PLUS, *design, math.cos(1.0), math.sin(1.0))
    extended = [
        (s1, s2)
        for s1 in (1.0, -1.0)
        for s2 in (1.0, -1.0)
        if kind(design, rho * math.cos(1.0), rho * math.sin(1.0), s1, s2) == loci.PARALLEL_EXTENDED
    ]
    assert len(extended) == 1
    # change point r1 = r2 + r3 ... all in line: the third kind
    third = kind((1.5, 0.75, 0.75), 1.5, 0.0, 1.0, -1.0)
    assert third & (loci.SERIAL_LEG_1 | loci.SERIAL_LEG_2)
    assert third & (loci.PARALLEL_FOLDED | loci.PARALLEL_EXTENDED)


@pytest.mark.parametrize(
    ("lengths", "letters"),
    [
        ((1.2, 1.0, 0.8), ""),
        ((1.0, 1.2, 1.0), "a"),
        ((1.2, 1.0, 1.0), "b"),
        ((0.9, 0.6, 1.5), "c"),
        ((1.0, 1.5, 0.5), "d"),
        ((1.5, 1.0, 0.5), "e"),
        ((1.28, 1.72, 0.0), "f"),
        ((1.0, 1.0, 1.0), "ab"),
        ((26.0, 26.0, 0.0), "def"),
    ],
)
def test_change_point_cases(lengths: tuple[float, float, float], letters: str) -> None:
    assert loci.change_point_cases(*lengths) == letters
