"""All quantities of designs: reference values, closed forms, symmetries, degenerate designs."""

from __future__ import annotations

import itertools
import math
from typing import Any

import naive
import naive_square
import numpy as np
import numpy.typing as npt
import pytest
from designs import MODES, random_cases, random_design
from scipy import integrate

from fivebar_atlas.mechanisms.five_bar import evaluation
from fivebar_atlas.mechanisms.five_bar.mechanism import STATUS

UP = (1, -1, 1)


def evaluate(
    designs: npt.ArrayLike,
    modes: npt.ArrayLike = UP,
    thresholds: tuple[float, ...] = (0.5,),
    tolerance: float = 1e-6,
) -> dict[str, npt.NDArray[Any]]:
    return evaluation.evaluate_designs(
        np.atleast_2d(np.asarray(designs, dtype=float)),
        np.atleast_2d(np.asarray(modes, dtype=np.int64)),
        np.array(thresholds),
        tolerance,
    )


# Two independent methods agree on these: usable area, GCI, area with LCI of at least 0.5.
REFERENCE = [
    ((1.28, 1.72, 0.0), 27.66612154, 0.66976944, 19.77874),
    ((1.3, 1.6, 0.1), 24.858663, 0.6604263, 19.082389),
    ((1.08, 1.25, 0.67), 9.24144, 0.3713606, 2.357436),
]


@pytest.mark.parametrize(("design", "area", "gci", "good"), REFERENCE)
def test_reference_values(
    design: tuple[float, float, float], area: float, gci: float, good: float
) -> None:
    values = evaluate(design, tolerance=1e-9)
    assert values["usable_workspace_area"][0, 0] == pytest.approx(
        area, abs=6e-7 + 4e-6 * (area < 10)
    )
    assert values["gci"][0, 0] == pytest.approx(gci, abs=6e-8)
    assert values["good_condition_workspace_area"][0, 0, 0] == pytest.approx(good, abs=6e-6)
    assert values["status"][0, 0] == 0


def edge_lci(rho: float, r1: float, r2: float) -> float:
    """LCI at r3 = 0, where it depends on the distance from the base alone."""
    cosine = (rho * rho + r2 * r2 - r1 * r1) / (2.0 * rho * r2)
    tangent = math.sqrt(max(1.0 - cosine * cosine, 0.0)) / max(abs(cosine), 1e-300)
    return min(tangent, 1.0 / max(tangent, 1e-300))


@pytest.mark.parametrize("r1", [0.1, 0.4, 0.75, 1.0, 1.2, 1.28, 1.4, 1.5, 1.6, 1.9, 2.3, 2.9])
def test_edge_r3_zero_against_one_dimensional_integrals(r1: float) -> None:
    r2 = 3.0 - r1
    values = evaluate((r1, r2, 0.0), thresholds=(0.3, 0.5, 0.8), tolerance=1e-8)
    low = abs(r1 - r2) if r1 <= r2 else math.sqrt(r1 * r1 - r2 * r2)
    # LCI passes a level where ρ = 2 r2 cos ψ ... ; breaks at ψ = 45 degrees and at the levels
    kinks = []
    for tangent in (1.0, *(t for c in (0.3, 0.5, 0.8) for t in (c, 1.0 / c))):
        cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
        rest = r1 * r1 - r2 * r2 * (1.0 - cosine * cosine)
        if rest >= 0.0:
            kinks += [r2 * cosine + math.sqrt(rest), r2 * cosine - math.sqrt(rest)]
    ends = sorted({low, 3.0, *(rho for rho in kinks if low < rho < 3.0)})

    def integral(least: float, weigh: bool) -> float:
        total = 0.0
        for a, b in itertools.pairwise(ends):
            if edge_lci(0.5 * (a + b), r1, r2) < least:
                continue
            if weigh:
                total += integrate.quad(
                    lambda rho: 2.0 * math.pi * rho * edge_lci(rho, r1, r2),
                    a, b, epsabs=1e-12, epsrel=1e-11, limit=400,
                )[0]  # fmt: skip
            else:
                total += math.pi * (b * b - a * a)
        return total

    area = integral(-1.0, weigh=False)
    assert values["usable_workspace_area"][0, 0] == pytest.approx(area, rel=1e-13)
    assert values["gci"][0, 0] == pytest.approx(integral(-1.0, weigh=True) / area, rel=2e-8)
    for k, threshold in enumerate((0.3, 0.5, 0.8)):
        good = integral(threshold, weigh=False)
        ours = values["good_condition_workspace_area"][0, 0, k]
        assert ours == pytest.approx(good, rel=2e-8)
        if good > 0.0:
            mean = integral(threshold, weigh=True) / good
            assert values["good_condition_gci"][0, 0, k] == pytest.approx(mean, rel=2e-8)


def test_edge_r3_zero_good_condition_radii() -> None:
    # Liu et al. 2006, Sec. 9.2: radii 2 r2/√5 ± √(r1² - r2²/5) for LCI 0.5
    r1, r2 = 1.28, 1.72
    root = math.sqrt(r1 * r1 - r2 * r2 / 5.0)
    radii = 2.0 * r2 / math.sqrt(5.0) + root, 2.0 * r2 / math.sqrt(5.0) - root
    area = math.pi * (radii[0] ** 2 - radii[1] ** 2)
    values = evaluate((r1, r2, 0.0))
    assert values["good_condition_workspace_area"][0, 0, 0] == pytest.approx(area, rel=1e-12)


def test_against_the_dense_grid_in_all_modes() -> None:
    for design, mode in random_cases(50, 40):
        thresholds = (0.25, 0.6)
        theirs = naive.evaluate(*design, *mode, thresholds=thresholds, n=501)
        ours = {k: v[0, ...] for k, v in evaluate(design, mode, thresholds, 1e-4).items()}
        area = theirs["usable_workspace_area"]
        if ours["usable_workspace_area"][0] < 0.3:
            continue  # a few cells of the grid
        rough = 0.03 + 0.01 * area
        assert ours["usable_workspace_area"][0] == pytest.approx(area, abs=rough), (design, mode)
        assert ours["gci"][0] == pytest.approx(theirs["gci"], abs=0.02), (design, mode)
        assert ours["max_lci"][0] >= theirs["max_lci"] - 1e-6
        for k, threshold in enumerate(thresholds):
            good = theirs["good_condition_area"][threshold]
            assert ours["good_condition_workspace_area"][0, k] == pytest.approx(good, abs=rough)
        for half in ("upper", "lower"):
            radius = ours[f"mic_{half}_radius"][0]
            if math.isnan(radius):
                assert theirs[f"mic_{half}_radius"] < 0.02
                continue
            assert radius == pytest.approx(theirs[f"mic_{half}_radius"], abs=0.02), (design, mode)


def test_inscribed_circle_lies_inside_and_cannot_grow() -> None:
    for design, mode in random_cases(51, 25):
        values = evaluate(design, mode, (), 1e-3)
        for half, sign in (("upper", 1), ("lower", -1)):
            radius = values[f"mic_{half}_radius"][0, 0]
            centre = values[f"mic_{half}_y"][0, 0]
            if math.isnan(radius) or radius < 1e-3:
                continue
            assert centre * sign >= 0.0
            angles = np.linspace(0.0, 2.0 * math.pi, 721)
            for share in (0.5, 1.0 - 1e-9):
                x = share * radius * np.cos(angles)
                y = centre + share * radius * np.sin(angles)
                det_b = naive.det_b(*design, x, y, mode[0], mode[1])
                assert np.all(det_b * mode[2] > -1e-9), (design, mode, half)
            # somewhere a slightly larger circle leaves the workspace
            x = (radius + 1e-3) * np.cos(angles)
            y = centre + (radius + 1e-3) * np.sin(angles)
            det_b = naive.det_b(*design, x, y, mode[0], mode[1]) * mode[2]
            assert np.any(np.isnan(det_b)) or np.nanmin(det_b) < 2e-2


@pytest.mark.parametrize(
    ("lengths", "assembly"),
    [
        ((1.0, 1.0245369011257943, 0.040716096374757524), -1),
        ((1.45, 1.475, 0.075), -1),
        ((1.375, 1.475, 0.15), -1),
    ],
)
def test_inscribed_circle_where_the_coupler_curve_is_near_in_two_places(
    lengths: tuple[float, float, float], assembly: int
) -> None:
    # the place that is nearer is not the one with the nearest sample of the curve
    scale = 3.0 / sum(lengths)
    design = tuple(scale * length for length in lengths)
    values = evaluate([design], [(1, -1, assembly)])
    half = "upper" if assembly < 0 else "lower"
    radius, y = (values[f"mic_{half}_{name}"][0, 0] for name in ("radius", "y"))
    ask = naive_square.Wanted(design, (1, -1), assembly)
    assert radius == pytest.approx(naive_square.reach_of_circle(ask, y, 3.0), rel=0.0, abs=1e-9)


def test_inscribed_circles_of_an_annulus() -> None:
    values = evaluate((1.28, 1.72, 0.0))
    # between the circles of radii 0.44 and 3, touching both
    for half, sign in (("upper", 1.0), ("lower", -1.0)):
        assert values[f"mic_{half}_radius"][0, 0] == pytest.approx(1.28, abs=1e-12)
        assert values[f"mic_{half}_y"][0, 0] == pytest.approx(sign * 1.72, abs=1e-12)


def test_inscribed_circle_keeps_off_a_singular_point() -> None:
    # r1 = r2: the inner reach circles are the base joints, where the legs fold
    values = evaluate((1.5, 1.5, 0.0))
    assert values["mic_upper_radius"][0, 0] == pytest.approx(1.5, abs=1e-12)
    near = evaluate((1.5 - 1e-6, 1.5 + 1e-6, 0.0))
    assert near["mic_upper_radius"][0, 0] == pytest.approx(1.5, abs=1e-5)
    values = evaluate((1.45, 1.45, 0.1))
    radius, y = values["mic_upper_radius"][0, 0], values["mic_upper_y"][0, 0]
    assert radius <= math.hypot(0.1, y) + 1e-12


def test_mirror_symmetries_between_all_modes() -> None:
    design = random_design(np.random.default_rng(3))
    values = evaluate(design, MODES, (0.4,), 1e-5)
    index = {mode: k for k, mode in enumerate(MODES)}
    for (s1, s2, assembly), k in index.items():
        upside_down, left_right = index[-s1, -s2, -assembly], index[-s2, -s1, assembly]
        for name in ("usable_workspace_area", "gci", "good_condition_gci"):
            for other in (upside_down, left_right):
                np.testing.assert_array_equal(values[name][0, k], values[name][0, other])
        np.testing.assert_array_equal(
            values["mic_upper_radius"][0, k], values["mic_lower_radius"][0, upside_down]
        )
        np.testing.assert_array_equal(
            values["max_lci_y"][0, k], -values["max_lci_y"][0, upside_down]
        )


def test_symmetries_hold_for_the_grid_too() -> None:
    # the reduction to three computations rests on this
    for design, (s1, s2, assembly) in random_cases(52, 6):
        masks = [
            naive.usable_workspace_mask(*design, *mode, 300)
            for mode in [(s1, s2, assembly), (-s1, -s2, -assembly), (-s2, -s1, assembly)]
        ]
        assert masks[0].sum() == masks[1].sum() == masks[2].sum()


def largest_index_near(
    design: tuple[float, float, float], mode: tuple[int, int, int], x: float, y: float
) -> float:
    """Largest LCI on a small circle about a point, of the points of a mode pair."""
    angles = np.linspace(0.0, 2.0 * math.pi, 20001)
    xs, ys = x + 1e-6 * np.cos(angles), y + 1e-6 * np.sin(angles)
    there = naive.lci(*design, xs, ys, *mode[:2])
    belongs = naive.det_b(*design, xs, ys, *mode[:2]) * mode[2] > 0.0
    return float(np.nanmax(np.where(belongs, there, np.nan)))


def test_where_the_largest_index_occurs() -> None:
    for design, mode in random_cases(53, 30):
        values = evaluate(design, mode, (), 1e-3)
        if values["status"][0, 0] & evaluation.EMPTY_USABLE_WORKSPACE:
            continue
        x, y = values["max_lci_x"][0, 0], values["max_lci_y"][0, 0]
        largest = values["max_lci"][0, 0]
        assert largest_index_near(design, mode, x, y) == pytest.approx(largest, abs=2e-3)


def test_largest_index_as_a_limit_in_a_corner() -> None:
    # both legs stretched at the top, where they enclose the angle γ: LCI = cot(γ/2)
    values = evaluate((1.0, 0.7, 1.3), UP, ())
    height = math.sqrt(1.7**2 - 1.3**2)
    assert values["max_lci"][0, 0] == pytest.approx(height / 1.3, abs=1e-12)
    assert (values["max_lci_x"][0, 0], values["max_lci_y"][0, 0]) == pytest.approx((0.0, height))
    grid = naive.evaluate(1.0, 0.7, 1.3, *UP, n=1501)
    assert grid["max_lci"] <= values["max_lci"][0, 0]
    assert largest_index_near((1.0, 0.7, 1.3), UP, 0.0, height) == pytest.approx(
        values["max_lci"][0, 0], abs=2e-3
    )


def test_good_condition_area_falls_with_the_threshold() -> None:
    thresholds = tuple(np.linspace(0.02, 0.98, 25))  # more than are treated together
    for design, mode in random_cases(54, 5):
        values = evaluate(design, mode, thresholds, 1e-5)
        areas = values["good_condition_workspace_area"][0, 0]
        errors = values["good_condition_workspace_area_error"][0, 0]
        assert np.all(np.diff(areas) <= errors[1:] + errors[:-1])
        assert areas[0] <= values["usable_workspace_area"][0, 0] * (1.0 + 1e-12)
        means = values["good_condition_gci"][0, 0]
        assert np.all(np.isnan(means) == (areas == 0.0))
        assert np.all(means[areas > 0.0] >= np.array(thresholds)[areas > 0.0] - 1e-9)


def test_errors_shrink_with_the_tolerance_and_hold() -> None:
    for design, mode in random_cases(55, 12):
        best = evaluate(design, mode, (0.4,), 1e-10)
        if math.isnan(best["gci"][0, 0]):
            continue
        for tolerance in (1e-3, 1e-5, 1e-7):
            rough = evaluate(design, mode, (0.4,), tolerance)
            for name in ("gci", "good_condition_workspace_area", "good_condition_gci"):
                value, error = rough[name].ravel()[0], rough[f"{name}_error"].ravel()[0]
                if math.isnan(value):
                    continue
                exact = best[name].ravel()[0]
                slack = best[f"{name}_error"].ravel()[0] + 1e-13
                assert abs(value - exact) <= error + slack, (design, mode, tolerance, name)
                if not rough["status"][0, 0] & evaluation.TOLERANCE_NOT_REACHED:
                    assert error <= 2.1 * tolerance * value + 1e-11


def test_degenerate_designs_have_a_status() -> None:
    values = evaluate([(1.28, 1.72, 0.0)], [(1, 1, 1), (-1, -1, 1)])
    for k in range(2):
        assert STATUS.describe(int(values["status"][0, k])).startswith(
            "empty_usable_workspace, degenerate_design"
        )
        assert values["usable_workspace_area"][0, k] == 0.0
        assert math.isnan(values["gci"][0, k])
    point = evaluate((1.0, 0.5, 1.5))
    assert point["status"][0, 0] & evaluation.DEGENERATE_DESIGN
    assert point["theoretical_workspace_area"][0] == 0.0


@pytest.mark.parametrize(
    "design",
    [
        (1.0, 1.0, 1.0), (1.5, 1.5, 0.0), (1.0, 1.5, 0.5), (1.5, 1.0, 0.5), (1.2, 1.2, 0.6),
        (1.5, 0.75, 0.75), (0.75, 1.5, 0.75), (1.3, 1.7 - 1e-9, 1e-9), (1.3, 1.7 - 1e-5, 1e-5),
        (0.01, 2.99, 0.0), (2.99, 0.01, 0.0), (0.01, 1.51, 1.48), (1.51, 0.01, 1.48),
        (0.76, 0.74, 1.5), (1.45, 1.5, 0.05),
    ],
)  # fmt: skip
def test_every_value_is_a_number_or_explained(design: tuple[float, float, float]) -> None:
    values = evaluate(design, MODES, (0.5,), 1e-6)
    for k in range(len(MODES)):
        status = int(values["status"][0, k])
        empty = bool(status & evaluation.EMPTY_USABLE_WORKSPACE)
        for name in ("gci", "gci_error", "max_lci", "max_lci_x", "max_lci_y"):
            assert math.isnan(values[name][0, k]) == empty, name
        for half, bit in (
            ("upper", evaluation.NO_UPPER_INSCRIBED_CIRCLE),
            ("lower", evaluation.NO_LOWER_INSCRIBED_CIRCLE),
        ):
            assert math.isnan(values[f"mic_{half}_radius"][0, k]) == bool(status & bit)
        good = values["good_condition_workspace_area"][0, k, 0]
        assert math.isnan(values["good_condition_gci"][0, k, 0]) == (good == 0.0)
        if not empty:
            assert 0.0 < values["gci"][0, k] <= values["max_lci"][0, k] <= 1.0 + 1e-12


def test_a_block_does_not_change_its_designs() -> None:
    rng = np.random.default_rng(8)
    designs = np.array([random_design(rng) for _ in range(6)])
    together = evaluate(designs, MODES, (0.5,), 1e-4)
    for k in range(len(designs)):
        alone = evaluate(designs[k], MODES, (0.5,), 1e-4)
        for name, values in together.items():
            np.testing.assert_array_equal(values[k], alone[name][0])


@pytest.mark.nojit
def test_as_plain_python() -> None:
    values = evaluate((1.2, 1.0, 0.8), UP, (0.5,), 1e-3)
    assert values["usable_workspace_area"][0, 0] == pytest.approx(5.970548942261, abs=1e-9)
    assert values["gci"][0, 0] == pytest.approx(0.32497812, abs=1e-4)
    values = evaluate((1.2, 1.0, 0.8), (1, 1, 1), (0.3,), 1e-3)
    theirs = naive.evaluate(1.2, 1.0, 0.8, 1, 1, 1, thresholds=(0.3,), n=301)
    assert values["gci"][0, 0] == pytest.approx(theirs["gci"], abs=0.01)


# Designs at which curves begin to meet while no neck of a workspace opens or closes: a fold
# circle or C_col passes through the origin (right angles in r1, r2, r3), reach circles touch.
BORDERLINE = [(1.25, 1.0, 0.75), (1.25, 0.75, 1.0), (0.5, 1.3, 1.2), (1.1, 1.5, 0.4)]


@pytest.mark.parametrize("design", BORDERLINE)
def test_borderline_designs_are_like_their_neighbours(design: tuple[float, float, float]) -> None:
    aside = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [-1.0, 0.0, 1.0]])
    steps = 1e-7 * np.concatenate([aside, -aside])
    here = evaluate(design, MODES, tolerance=1e-5)["usable_workspace_area"]
    around = evaluate(np.array(design) + steps, MODES, tolerance=1e-5)["usable_workspace_area"]
    np.testing.assert_allclose(around, np.broadcast_to(here, around.shape), rtol=0.0, atol=1e-5)


def test_fold_circle_through_the_origin_against_a_grid() -> None:
    ours = evaluate((1.25, 1.0, 0.75))["usable_workspace_area"][0, 0]
    reference = naive.evaluate(1.25, 1.0, 0.75, *UP, n=1500)["usable_workspace_area"]
    assert ours == pytest.approx(reference, rel=1e-3)
