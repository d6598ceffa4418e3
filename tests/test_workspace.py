"""The usable workspace: its area, its pieces, its inscribed circles."""

from __future__ import annotations

import math

import naive
import numpy as np
import pytest
from designs import random_cases, random_design

from fivebar_atlas.mechanisms.five_bar.workspace import (
    DECOMPOSITION,
    Decomposition,
    collect_strips,
    contains,
    decompose,
    largest_component,
    strips_area,
    theoretical_area,
)
from fivebar_atlas.numerics.records import allocate_record

pytestmark = pytest.mark.nojit

Design = tuple[float, float, float]


def usable(design: Design, mode: tuple[int, int, int]) -> tuple[float, Decomposition, int]:
    """Return area, decomposition and number of strips of a usable workspace."""
    d: Decomposition = allocate_record(DECOMPOSITION)
    s1, s2, assembly = (float(sign) for sign in mode)
    sectors = decompose(*design, s1, s2, assembly, d)
    component, copies = largest_component(d, *design, s1 != s2, sectors)
    if component < 0:
        return 0.0, d, 0
    strips = collect_strips(d, *design, sectors, component)
    area, error = strips_area(d, *design, strips)
    assert 0.0 < error < 1e-12
    return copies * area, d, strips


def test_theoretical_area_against_a_grid() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        design = random_design(rng)
        x, y = naive.grid(*design, 800)
        mask = naive.theoretical_workspace_mask(*design, 800)
        cell = (x[1] - x[0]) * (y[1] - y[0])
        assert theoretical_area(*design) == pytest.approx(mask.sum() * cell, abs=0.02)


def test_theoretical_area_in_closed_cases() -> None:
    assert theoretical_area(1.5, 1.5, 0.0) == pytest.approx(9.0 * math.pi, rel=1e-15)
    assert theoretical_area(1.28, 1.72, 0.0) == pytest.approx(math.pi * (9.0 - 0.44**2), rel=1e-15)
    assert theoretical_area(1.0, 0.5, 1.5) == 0.0  # a single point
    # r1 = r2: two discs of radius 2 r1, a lens
    half = math.acos(0.5)
    lens = 2.0 * 4.0 * half - 2.0 * math.sqrt(3.0)
    assert theoretical_area(1.0, 1.0, 1.0) == pytest.approx(lens, rel=1e-14)


def test_usable_area_against_a_grid() -> None:
    for design, mode in random_cases(40, 80):
        n = 600
        mask = naive.usable_workspace_mask(*design, *mode, n)
        x, y = naive.grid(*design, n)
        cell = (x[1] - x[0]) * (y[1] - y[0])
        area, _, _ = usable(design, mode)
        # a component that only touches another, or is as large, may be taken by the grid
        assert area == pytest.approx(mask.sum() * cell, abs=0.03 + 0.005 * area), (design, mode)


def test_points_of_the_strips_are_those_of_the_workspace() -> None:
    rng = np.random.default_rng(1)
    for design, mode in random_cases(41, 30):
        _, d, strips = usable(design, mode)
        if not strips:
            continue
        n = 400
        mask = naive.usable_workspace_mask(*design, *mode, n)
        x, y = naive.grid(*design, n)
        agree = 0
        for _ in range(200):
            iy, ix = rng.integers(n, size=2)
            # the right half stands for a symmetric workspace, or for one of two images
            px = abs(x[ix]) if mode[0] != mode[1] else x[ix]
            phi = math.atan2(y[iy], px)
            if phi < -0.5 * math.pi:
                phi += 2.0 * math.pi
            inside = contains(d, *design, strips, phi, math.hypot(px, y[iy]))
            agree += inside == mask[iy, ix] or (
                mode[0] != mode[1] and inside == mask[iy, n - 1 - ix]
            )
        assert agree >= 195, (design, mode)


def test_strips_of_r3_zero_are_the_whole_annulus() -> None:
    area, _, strips = usable((1.28, 1.72, 0.0), (1, -1, 1))
    assert strips == 1
    assert area == pytest.approx(math.pi * (9.0 - 0.44**2), rel=1e-14)
    # r1 > r2: det B changes its sign on ρ² = r1² - r2²
    area, _, _ = usable((1.8, 1.2, 0.0), (1, -1, 1))
    assert area == pytest.approx(math.pi * (9.0 - (1.8**2 - 1.2**2)), rel=1e-14)
    area, _, _ = usable((1.8, 1.2, 0.0), (1, -1, -1))
    assert area == pytest.approx(math.pi * (1.8**2 - 1.2**2 - 0.6**2), rel=1e-13)


@pytest.mark.parametrize(
    "design",
    [
        (1.0, 1.0, 1.0),
        (1.5, 1.5, 0.0),
        (1.0, 1.5, 0.5),  # r2 = r1 + r3
        (1.5, 1.0, 0.5),  # r1 = r2 + r3
        (1.5, 0.75, 0.75),  # also r2 = r3 and r1 = 2 r2
        (0.75, 1.5, 0.75),
        (1.2, 1.2, 0.6),
        (1.3, 1.7 - 1e-9, 1e-9),
        (1.3, 1.7 - 1e-5, 1e-5),
        (0.01, 1.51, 1.48),
        (1.51, 0.01, 1.48),
        (0.02, 2.97, 0.01),
        (2.97, 0.02, 0.01),
    ],
)
def test_degenerate_designs_are_ordinary(design: Design) -> None:
    for mode in [(1, -1, 1), (1, -1, -1), (1, 1, 1)]:
        if design[2] == 0.0 and mode[0] == mode[1]:
            continue  # B1 = B2 for every P; the evaluation calls such designs degenerate
        n = 900
        mask = naive.usable_workspace_mask(*design, *mode, n)
        x, y = naive.grid(*design, n)
        cell = (x[1] - x[0]) * (y[1] - y[0])
        area, _, _ = usable(design, mode)
        assert area <= theoretical_area(*design) * (1.0 + 1e-12)
        # thin workspaces fall apart on the grid; they never come out larger
        rough = 0.02 + 0.02 * area
        if design[0] == design[2]:
            # both fold circles are one, where det B touches zero without changing its sign:
            # a singular locus that cuts the workspace and that no grid can see
            assert 0.0 < area < mask.sum() * cell + rough
        elif min(design[:2]) > 0.1:
            assert area == pytest.approx(mask.sum() * cell, abs=rough), mode
        else:
            assert area > mask.sum() * cell - rough, mode


def test_area_is_continuous_towards_the_edge() -> None:
    edge, _, _ = usable((1.3, 1.7, 0.0), (1, -1, 1))
    previous = math.inf
    for r3 in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10):
        area, _, _ = usable((1.3, 1.7 - r3, r3), (1, -1, 1))
        assert abs(area - edge) < 40.0 * r3 + 1e-12
        assert abs(area - edge) <= previous
        previous = abs(area - edge) + 1e-12
