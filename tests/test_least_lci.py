"""The least LCI of a whole shape, against dense samples of the naive oracle."""

from __future__ import annotations

import math

import naive
import numpy as np
import pytest
import shapely
from designs import random_cases

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.synthesis.least_lci import LeastLci, least_lci
from fivebar_atlas.synthesis.shapes import Shape

FIRST = "+-/up"
TOLERANCE = 1.1e-9
#: A triangle with a notch, for a shape that is not convex.
NOTCHED = [(-1.0, -0.6), (0.0, -0.1), (1.0, -0.6), (0.1, 1.0)]

Signs = tuple[int, int, int]


def design_of(lengths: tuple[float, float, float]) -> PlanarDesign:
    return mechanisms.get("five-bar").planar_design(lengths, "")


def label(signs: Signs) -> str:
    one, two, assembly = signs
    names = {1: "+", -1: "-"}
    return f"{names[one]}{names[two]}/{'up' if assembly > 0 else 'down'}"


def outline_of(kind: str, size: float) -> tuple[Shape, shapely.Polygon]:
    """Return a shape, and the same made of corners only; a circle by a polygon within it."""
    if kind == "rectangle":
        return Shape.rectangle(1.6 * size, size), shapely.box(
            -0.8 * size, -0.5 * size, 0.8 * size, 0.5 * size
        )
    if kind == "circle":
        turn = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
        corners = 0.5 * size * np.column_stack([np.cos(turn), np.sin(turn)])
        return Shape.circle(size), shapely.Polygon(corners)
    plain = shapely.Polygon(size * np.array(NOTCHED))
    shape = Shape.polygon(size * np.array(NOTCHED))
    return shape, shapely.affinity.translate(plain, -plain.centroid.x, -plain.centroid.y)


def naive_least(
    lengths: tuple[float, float, float], signs: Signs, outline: shapely.Polygon
) -> float:
    """Return the least LCI of samples of a polygon, closer and closer around the least one."""

    def values(points: np.ndarray) -> np.ndarray:
        x, y = points.T
        index = naive.lci(*lengths, x, y, *signs[:2])
        with np.errstate(invalid="ignore"):
            inside = signs[2] * naive.det_b(*lengths, x, y, *signs[:2]) > 0.0
        return np.where(inside, index, 0.0)

    left, low, right, high = outline.bounds
    x, y = np.meshgrid(np.linspace(left, right, 161), np.linspace(low, high, 161))
    grid = np.column_stack([x.ravel(), y.ravel()])
    ring = outline.exterior
    edge = shapely.get_coordinates(
        shapely.line_interpolate_point(ring, np.linspace(0.0, 1.0, 4001), normalized=True)
    )
    points = np.vstack([grid[shapely.contains_xy(outline, grid)], edge])
    index = values(points)
    step = max(right - left, high - low) / 160.0
    for _ in range(12):
        best = points[np.argmin(index)]
        x, y = np.meshgrid(*2 * [np.linspace(-step, step, 21)])
        around = best + np.column_stack([x.ravel(), y.ravel()])
        station = shapely.line_locate_point(ring, shapely.Point(best))
        along = station + np.linspace(-step, step, 101)
        edge = shapely.get_coordinates(
            shapely.line_interpolate_point(ring, np.mod(along, ring.length))
        )
        points = np.vstack([best, around[shapely.contains_xy(outline, around)], edge])
        index = values(points)
        step *= 0.2
    return float(index.min())


def check(found: LeastLci, ref: float, lengths: tuple[float, float, float], signs: Signs) -> None:
    """Compare with samples: no sample is below the bound, and the value is one that is taken."""
    assert found.value <= ref + 1e-12
    assert found.bound <= ref
    assert found.bound <= found.value
    if found.value > 0.0:
        assert found.value - found.bound <= TOLERANCE
        taken = float(naive.lci(*lengths, *found.position, *signs[:2]))
        assert taken == pytest.approx(found.value, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("kind", ["rectangle", "circle", "polygon"])
def test_least_of_shapes_in_random_designs(kind: str) -> None:
    rng = np.random.default_rng(31)
    sizes = (0.1, 0.3, 0.6)
    count = 0
    for lengths, signs in random_cases(17, 200):
        design, mode = design_of(lengths), label(signs)
        workspace = design.usable_workspace(mode)
        if workspace is None or workspace.area < 0.5:
            continue
        # around the best point, where some shapes fit in and others do not
        largest = design.largest_lci(mode)
        assert largest is not None
        position = tuple(float(part) for part in largest[1] + rng.uniform(-0.15, 0.15, 2))
        shape, outline = outline_of(kind, sizes[count % 3])
        placed = shapely.affinity.translate(outline, *position)
        found = least_lci(design, mode, shape, position, 1.0)
        ref = naive_least(lengths, signs, placed)
        if found.value == 0.0:
            # a workspace may be one of several parts, of which samples know nothing
            continue
        check(found, ref, lengths, signs)
        assert shapely.distance(placed, shapely.Point(found.position)) < 1e-4
        assert ref - found.value < (1e-5 if kind == "circle" else 1e-8)
        count += 1
        if count == 12:
            break
    assert count == 12


def test_scale_and_position_are_those_of_the_machine() -> None:
    lengths = (1.0, 1.6, 0.4)
    design = design_of(lengths)
    factor = design.parameters[0][1]
    big = least_lci(design, FIRST, Shape.rectangle(100.0, 60.0), (0.0, 1.5), 0.01)
    small = least_lci(design, FIRST, Shape.rectangle(1.0, 0.6), (0.0, 1.5), 1.0)
    assert big.value == pytest.approx(small.value, rel=1e-12)
    scaled = tuple(factor * length for length in lengths)
    ref = naive_least(scaled, (1, -1, 1), shapely.box(-0.5, 1.2, 0.5, 1.8))
    check(small, ref, scaled, (1, -1, 1))


def test_a_least_value_in_the_interior() -> None:
    # without a base the LCI is min(tan, cot) of an angle whose sine is at most r1/r2, on a ring
    r1, r2 = 1.45, 1.55
    radius, ref = math.sqrt(r2**2 - r1**2), math.sqrt(r2**2 - r1**2) / r1
    assert r1 / r2 > 2.0 / math.sqrt(5.0)
    design = design_of((r1, r2, 0.0))
    for shape in (Shape.rectangle(0.2, 0.3), Shape.circle(0.3)):
        found = least_lci(design, FIRST, shape, (0.0, radius), 1.0)
        assert found.value == pytest.approx(ref, rel=1e-12)
        assert ref - TOLERANCE <= found.bound <= ref
        assert math.hypot(*found.position) == pytest.approx(radius, abs=1e-5)
        # on the edges but those that the ring crosses it is larger
        x, y = np.linspace(-0.1, 0.1, 101), radius + np.array([[-0.15], [0.15]])
        assert naive.lci(r1, r2, 0.0, x + 0.0 * y, y + 0.0 * x, 1, -1).min() > ref + 1e-3


def test_isotropic_points_inside_do_not_mislead() -> None:
    lengths = (1.0, 1.6, 0.6 * math.sqrt(0.5))
    design = design_of(lengths)
    factor = design.parameters[0][1]
    scaled = tuple(factor * length for length in lengths)
    y = factor * 2.6 * math.sqrt(0.5)
    assert float(naive.lci(*scaled, 0.0, y, 1, -1)) == pytest.approx(1.0)
    for size in (1e-3, 0.1, 0.5):
        found = least_lci(design, FIRST, Shape.rectangle(size, size), (0.0, y), 1.0)
        half = 0.5 * size
        ref = naive_least(scaled, (1, -1, 1), shapely.box(-half, y - half, half, y + half))
        check(found, ref, scaled, (1, -1, 1))
        assert found.value < 1.0 - 0.3 * size


@pytest.mark.parametrize(
    ("shape", "position"),
    [
        # the centre is out of reach, a corner is, and a hole around a base joint is inside
        (Shape.rectangle(0.2, 0.2), (0.0, 5.0)),
        (Shape.rectangle(2.4, 2.4), (0.0, 1.6)),
        (Shape.circle(6.0), (0.0, 0.0)),
        (Shape.polygon(NOTCHED), (0.0, -1.5)),
    ],
)
def test_shapes_that_leave_the_workspace_have_none(
    shape: Shape, position: tuple[float, float]
) -> None:
    found = least_lci(design_of((1.0, 1.6, 0.4)), FIRST, shape, position, 1.0)
    assert (found.value, found.bound) == (0.0, 0.0)
