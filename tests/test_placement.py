"""Placed shapes fit and would not fit a machine any smaller, both by brute force.

The oracle is ``naive``: Jacobian matrices by angles, nothing of the package. Its largest
search looks for a placement at D (1 - 1e-6), coarse to fine; there must be none.
"""

from __future__ import annotations

import dataclasses

import naive
import numpy as np
import numpy.typing as npt
import pytest
from designs import random_cases

from fivebar_atlas import FiveBar, planar_design
from fivebar_atlas.errors import InfeasibleSizeError
from fivebar_atlas.mechanisms.mode_pairs import mode_label
from fivebar_atlas.synthesis.containment import INSIDE, GoodCondition
from fivebar_atlas.synthesis.placement import FREE, ON_AXIS, Fit, fit_shape
from fivebar_atlas.synthesis.scale_search import ALLOWANCE, contacts_of
from fivebar_atlas.synthesis.shapes import Shape

Array = npt.NDArray[np.float64]
SMALLER = 1e-6


@dataclasses.dataclass(frozen=True)
class Case:
    """A design and mode pair, a threshold, and a shape to be placed."""

    lengths: tuple[float, float, float]
    signs: tuple[int, int, int]
    threshold: float
    shape: Shape
    placement: str | tuple[float, float]

    def margins(self, points: Array) -> Array:
        """LCI less its threshold in the mode pair, -threshold in the other or out of reach."""
        x, y = points[..., 0].ravel(), points[..., 1].ravel()
        s1, s2, assembly = self.signs
        j = naive.jacobian(*self.lengths, x, y, s1, s2).reshape(-1, 2, 2)
        with np.errstate(all="ignore"):
            squares = (j**2).sum(axis=(1, 2))
            det = j[:, 0, 0] * j[:, 1, 1] - j[:, 0, 1] * j[:, 1, 0]
            ratio = np.minimum(2.0 * np.abs(det) / squares, 1.0)
            lci = ratio / (1.0 + np.sqrt(1.0 - ratio * ratio))
            sign = naive.det_b(*self.lengths, x, y, s1, s2) * assembly
        good = np.isfinite(lci) & (sign > 0.0)
        return (np.where(good, lci, 0.0) - self.threshold).reshape(points.shape[:-1])

    def place(self, centres: Array, scale: float) -> Array:
        """Centres of the shape at a scale: given, or at its offset."""
        if isinstance(self.placement, str):
            return centres
        return np.broadcast_to(scale * np.array(self.placement), centres.shape)

    def least(self, centre: Array, scale: float) -> tuple[float, Array]:
        """Least margin along the boundary of the shape, to rounding, and where."""
        places = self.shape.boundary_samples(1500)
        values = self.margins(centre + scale * self.shape.boundary(places))
        best, at = np.inf, places[:1]
        minima = np.flatnonzero((values <= np.roll(values, 1)) & (values <= np.roll(values, -1)))
        for start in minima[np.argsort(values[minima])][:6]:
            middle = places[start]
            before = (middle - np.roll(places, 1)[start]) % self.shape.pieces
            after = (np.roll(places, -1)[start] - middle) % self.shape.pieces
            width = max(before, after)
            for _ in range(8):
                trial = middle + width * np.linspace(-1.0, 1.0, 21)
                margins = self.margins(centre + scale * self.shape.boundary(trial))
                middle, width = trial[np.argmin(margins)], 0.2 * width
                if margins.min() < best:
                    best, at = float(margins.min()), self.shape.boundary(np.array([middle]))[0]
        return best, at


def random_shape(rng: np.random.Generator) -> Shape:
    """Return a rectangle, a circle, a convex polygon or a star, with a clearance or none."""
    clearance = 0.0 if rng.random() < 0.6 else float(rng.uniform(0.5, 4.0))
    kind = rng.integers(4)
    if kind == 0:
        return Shape.rectangle(*rng.uniform(4.0, 40.0, 2), clearance)
    if kind == 1:
        return Shape.circle(float(rng.uniform(4.0, 40.0)), clearance)
    count = int(rng.integers(3, 9))
    if kind == 2:
        # on an ellipse: convex
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, count))
        while np.diff(np.append(angles, angles[0] + 2.0 * np.pi)).max() > 3.0:
            angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, count))
        radii = np.ones(count)
    else:
        angles = 2.0 * np.pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count
        radii = rng.uniform(0.3, 1.0, count)
    axes = rng.uniform(5.0, 25.0, 2)
    corners = np.column_stack([np.cos(angles), np.sin(angles)]) * radii[:, None] * axes
    return Shape.polygon(corners, clearance)


def random_case(seed: int) -> tuple[Case, GoodCondition]:
    rng = np.random.default_rng(seed)
    while True:
        lengths, signs = next(iter(random_cases(int(rng.integers(2**31)), 1)))
        robot, mode = FiveBar(*lengths), mode_label(signs)
        largest = robot.largest_lci(mode)
        if largest is None:
            continue
        threshold = float(rng.uniform(0.1, 0.8) * largest[0])
        parts = robot.good_condition_workspace(threshold, mode)
        # what is smaller is too small for the cells of the oracle
        if parts and parts[0].area > 0.05:
            break
    shape = random_shape(rng)
    good = GoodCondition(robot, mode, threshold)
    placement: str | tuple[float, float] = (ON_AXIS, FREE, "offset")[rng.integers(3)]
    if placement == "offset":
        fit = fit_shape(good, shape, FREE)
        x, y = fit.factor * np.array(fit.position) + rng.uniform(-3.0, 3.0, 2)
        placement = float(x), float(y)
    return Case(lengths, signs, threshold, shape, placement), good


def in_usable_workspace(case: Case, points: Array) -> bool:
    """Whether most points lie in the largest component of cells."""
    mask = naive.usable_workspace_mask(*case.lengths, *case.signs, 500)
    xs, ys = naive.grid(*case.lengths, 500)
    column = np.clip(np.round(np.interp(points[:, 0], xs, np.arange(500))).astype(int), 0, 499)
    row = np.clip(np.round(np.interp(points[:, 1], ys, np.arange(500))).astype(int), 0, 499)
    return bool(np.mean(mask[row, column]) > 0.5)


def assert_it_fits(case: Case, fit: Fit) -> None:
    scale, centre = 1.0 / fit.factor, np.array(fit.position)
    assert fit.proof.verdict == INSIDE
    least, _ = case.least(centre, scale)
    assert least >= 0.0
    interior = centre + scale * case.shape.interior_samples(4000)
    assert np.all(case.margins(interior) >= 0.0)
    assert in_usable_workspace(case, interior)


def fits_in_the_whole(case: Case, centre: Array, scale: float) -> bool:
    """Whether a shape with a good boundary is good inside, in the usable workspace."""
    interior = centre + scale * case.shape.interior_samples(4000)
    return bool(np.all(case.margins(interior) >= 0.0)) and in_usable_workspace(case, interior)


def a_smaller_machine(case: Case, fit: Fit, factor: float) -> Array | None:
    """Search for a placement at a smaller factor, coarse to fine; None where there is none."""
    scale = 1.0 / factor
    if not isinstance(case.placement, str):
        centre = scale * np.array(case.placement)
        return centre if case.least(centre, scale)[0] >= 0.0 else None
    samples = case.shape.boundary(case.shape.boundary_samples(160))
    reach = case.lengths[0] + case.lengths[1]
    if case.placement == ON_AXIS:
        starts = np.column_stack([np.zeros(600), np.linspace(-reach, reach, 600)])
        step = 2.0 * reach / 599
        pattern = np.column_stack([np.zeros(9), np.linspace(-1.0, 1.0, 9)])
    else:
        line = np.linspace(-reach, reach, 45)
        x, y = np.meshgrid(line, line)
        starts, step = np.column_stack([x.ravel(), y.ravel()]), float(line[1] - line[0])
        unit = np.linspace(-1.0, 1.0, 7)
        x, y = np.meshgrid(unit, unit)
        pattern = np.column_stack([x.ravel(), y.ravel()])
    # at first with few samples, and next to the placement that was found
    few = samples[:: max(len(samples) // 40, 1)]
    values = case.margins(starts[:, None] + scale * few).min(axis=1)
    tops = [*starts[np.argsort(-values)][:6], np.array(fit.position)]
    for middle in tops:
        width = step
        points = samples
        for _ in range(26):
            trial = middle + width * pattern
            least = case.margins(trial[:, None] + scale * points).min(axis=1)
            middle = trial[np.argmax(least)]
            worst = case.least(middle, scale) if width < 0.02 * step else (0.0, samples[0])
            points = np.concatenate([points, worst[1][None]]) if worst[0] < 0.0 else points
            if least.max() < -5.0 * width or (width < 0.02 * step and worst[0] < -2e-3):
                break
            width *= 0.5
        if case.least(middle, scale)[0] >= 0.0 and fits_in_the_whole(case, middle, scale):
            return np.asarray(middle)
    return None


def check(seed: int) -> str:
    """Check one random case; return what it was."""
    case, good = random_case(seed)
    try:
        fit = fit_shape(good, case.shape, case.placement)
    except InfeasibleSizeError:
        if case.placement == ON_AXIS:
            y = np.linspace(-3.0, 3.0, 20_001)
            points = np.column_stack([np.zeros(len(y)), y])
            inside = case.margins(points) >= 0.0
            assert not np.any(good.margins(points[inside]) >= 0.0)
        else:
            assert not isinstance(case.placement, str)
            for factor in np.geomspace(1.0, 1e4, 4000):
                centre = np.array(case.placement) / factor
                points = centre + case.shape.boundary(case.shape.boundary_samples(60)) / factor
                if np.all(case.margins(points) >= 0.0):
                    assert not fits_in_the_whole(case, centre, 1.0 / factor)
        return "infeasible"
    assert ALLOWANCE <= fit.allowance <= 100.0 * ALLOWANCE
    assert_it_fits(case, fit)
    found = a_smaller_machine(case, fit, fit.factor * (1.0 - SMALLER))
    assert found is None, f"{seed}: {case} fits at {found}, not only at {fit}"
    return case.placement if isinstance(case.placement, str) else "offset"


@pytest.mark.parametrize("seed", range(12))
def test_shapes_fit_and_not_in_a_machine_that_is_any_smaller(seed: int) -> None:
    check(seed)


PAPER = FiveBar(1.28, 1.72, 0.0)
# Where r3 = 0 the good-condition workspace for 0.5 is a ring around the origin.
INNER, OUTER = (
    2.0 * 1.72 / np.sqrt(5.0) + side * np.sqrt(1.28**2 - 1.72**2 / 5.0) for side in (-1.0, 1.0)
)


@pytest.mark.parametrize("placement", [ON_AXIS, FREE])
@pytest.mark.parametrize("clearance", [0.0, 3.0])
def test_a_circle_in_a_ring_is_as_wide_as_that(placement: str, clearance: float) -> None:
    good = GoodCondition(PAPER, "+-/up", 0.5)
    fit = fit_shape(good, Shape.circle(100.0, clearance), placement)
    exact = (100.0 + 2.0 * clearance) / (OUTER - INNER)
    assert fit.factor == pytest.approx(exact * (1.0 + fit.allowance), rel=1e-13)
    assert np.hypot(*fit.position) == pytest.approx(0.5 * (INNER + OUTER), abs=1e-7)
    assert len(fit.contacts) == 2


@pytest.mark.parametrize("placement", [ON_AXIS, FREE])
def test_a_rectangle_in_a_ring_touches_both_circles(placement: str) -> None:
    fit = fit_shape(GoodCondition(PAPER, "+-/up", 0.5), Shape.rectangle(300.0, 200.0), placement)
    # (150 s)² + (INNER + 200 s)² = OUTER²: upper corners and the middle of the lower side
    roots = np.roots([150.0**2 + 200.0**2, 400.0 * INNER, INNER**2 - OUTER**2])
    assert fit.factor * float(roots.max()) == pytest.approx(1.0 + fit.allowance, rel=1e-12)
    assert len(fit.contacts) == 3  # each once


def test_a_contact_that_is_found_twice_is_one() -> None:
    points = np.array([[50.0, 30.0], [1e-7, -30.0], [-1e-7, -30.0], [0.0, 30.0], [-50.0, 30.0]])
    values = np.array([0.0, 0.0, 0.0, 1.0, 0.0])
    assert contacts_of(points, values).tolist() in (
        [[x, -30.0], [-50.0, 30.0], [50.0, 30.0]] for x in (1e-7, -1e-7)
    )


def test_a_shape_around_the_hole_of_a_ring_is_not_taken_for_one_in_it() -> None:
    # The boundary of a circle about the origin is good at D = 50, and for one about (0, 60)
    # the hole is too wide at every size that the outer circle has room for.
    good = GoodCondition(PAPER, "+-/up", 0.5)
    shape = Shape.circle(100.0)
    assert np.all(good.margins(shape.boundary(shape.boundary_samples(500)) / 50.0) > 0.0)
    for offset in ((0.0, 0.0), (0.0, 60.0)):
        with pytest.raises(InfeasibleSizeError, match="fits at no size"):
            fit_shape(good, shape, offset)


@pytest.mark.parametrize("offset", [(0.0, 90.0), (-30.0, 85.0), (50.0, -80.0)])
def test_a_circle_at_an_offset_in_a_ring(offset: tuple[float, float]) -> None:
    away = float(np.hypot(*offset))
    fit = fit_shape(GoodCondition(PAPER, "+-/up", 0.5), Shape.circle(100.0), offset)
    exact = (away + 50.0) / OUTER
    assert (away - 50.0) / exact > INNER
    assert fit.factor == pytest.approx(exact * (1.0 + fit.allowance), rel=1e-13)
    assert np.multiply(fit.factor, fit.position) == pytest.approx(offset, rel=1e-12)


@pytest.mark.parametrize("placement", [ON_AXIS, FREE])
def test_a_shape_is_placed_in_however_small_a_part(placement: str) -> None:
    # around an isotropic point LCI = 1 - slope * distance, so that D (1 - LCI) goes to a limit
    design = planar_design(26, 30, 16, unit="")
    products = []
    for gap in (1e-4, 1e-5, 1e-6):
        good = GoodCondition(design, "+-/up", 1.0 - gap)
        fit = fit_shape(good, Shape.circle(10.0), placement)
        products.append(fit.factor * gap)
        angles = np.linspace(0.0, 2.0 * np.pi, 400)
        circle = 5.0 * np.column_stack([np.cos(angles), np.sin(angles)])
        for larger, is_good in ((1.001, True), (0.999, False)):
            points = np.array(fit.position) + circle / (larger * fit.factor)
            values = design.lci_inside(points[:, 0].copy(), points[:, 1].copy(), "+-/up")
            assert np.all(values >= 1.0 - gap) == is_good
    assert products == pytest.approx(3 * products[:1], rel=1e-3)
