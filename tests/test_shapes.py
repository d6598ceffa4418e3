"""Shapes of practical workspaces, compared with shapely."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from fivebar_atlas.errors import FileUsageError, InputError
from fivebar_atlas.synthesis.shapes import Shape, read_polygon

ARROW = [(0.0, 0.0), (4.0, 1.0), (5.0, 5.0), (2.0, 2.0), (-1.0, 3.0)]
SHAPES = {
    "rectangle": Shape.rectangle(3.0, 2.0),
    "rounded": Shape.rectangle(3.0, 2.0, 0.25),
    "circle": Shape.circle(2.0, 0.5),
    "arrow": Shape.polygon(ARROW),
    "clear arrow": Shape.polygon(ARROW[::-1], 0.4),
}


def outline_of(shape: Shape) -> shapely.Geometry:
    """Return the same shape as shapely makes it, arcs as chords of 1e-6."""
    if len(shape.corners) == 1:
        polygon = shapely.Point(*shape.corners[0])
    else:
        polygon = shapely.Polygon(shape.corners)
    return polygon.buffer(shape.radius, quad_segs=1000) if shape.radius else polygon


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
def test_gaps_and_containment_are_those_of_shapely(shape: Shape) -> None:
    lower, upper = shape.extent
    points = np.random.default_rng(3).uniform(1.5 * lower, 1.5 * upper, (3000, 2))
    expected = shapely.distance(outline_of(shape), shapely.points(points))
    assert np.allclose(np.maximum(shape.gaps(points), 0.0), expected, atol=1e-5)
    assert np.mean(shape.contains(points)) == pytest.approx(np.mean(expected == 0.0), abs=2e-3)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
def test_boundary_pieces_cover_the_boundary_and_stay_in_the_shape(shape: Shape) -> None:
    points = shape.boundary(shape.boundary_samples(20_000))
    assert np.all(shape.gaps(points) <= 1e-12)
    outline = outline_of(shape).boundary
    along = shapely.line_interpolate_point(outline, np.linspace(0.0, 1.0, 500), normalized=True)
    gaps = shapely.distance(shapely.MultiPoint(points), along)
    assert np.all(gaps < outline.length / 10_000)


def test_boundary_samples_hold_all_corners() -> None:
    shape = SHAPES["arrow"]
    points = shape.boundary(shape.boundary_samples(50))
    for corner in shape.corners:
        assert np.any(np.all(points == corner, axis=1))


def test_a_polygon_has_its_centroid_for_centre() -> None:
    shape = SHAPES["arrow"]
    centroid = shapely.Polygon(ARROW).centroid
    assert shape.centre == pytest.approx((centroid.x, centroid.y), rel=1e-14)
    assert shapely.Polygon(shape.corners).exterior.is_ccw
    turned = SHAPES["clear arrow"]
    assert np.allclose(sorted(turned.corners.tolist()), sorted(shape.corners.tolist()))


def test_interior_samples_lie_in_the_shape() -> None:
    shape = SHAPES["arrow"]
    points = shape.interior_samples(400)
    assert 100 < len(points) < 400
    assert np.all(shapely.contains_xy(shapely.Polygon(shape.corners), *points.T))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x,y\n0,0\n1,1\n1,0\n0,1\n", "Self-intersection"),
        ("x,y\n0,0\n1,1\n", "3 to 10000 different corners"),
        ("x,y\n0,0\n1,1\n2,2\n", "an area above 0"),
        ("x,y\n0.1,0.3\n1.1,3.3\n2.3,6.9\n", "an area above 0"),
        ("x (cm),y (cm)\n0,0\n1,0\n0,1\n", "has no column x or x_mm"),
        ("x,y\n0,0\n1e200,0\n0,1e200\n", r"coordinates up to 1e\+100"),
        ("x,y\n0,0\n1e-200,0\n0,1e-200\n", "a width of at least 1e-100"),
        ("x,y\n0,0\n1e8,0\n0,1\n", "times as long as wide"),
        ("x_cm,y_cm\n0,0\n1,0\n0,1\n", "lengths are in mm"),
        ("", "is empty"),
        ("POLYGON EMPTY", "empty polygon"),
        ("POLYGON ((0 0, 1 0, 0 1", "not well-known text"),
        ("POINT (1 2)", "holds a Point"),
        ("POLYGON ((0 0, 9 0, 0 9, 0 0), (1 1, 2 1, 1 2, 1 1))", "with holes"),
        ("POLYGON ((0 0, 1 1, 1 0, 0 1, 0 0))", "Self-intersection"),
    ],
)
def test_what_is_no_polygon_is_refused(tmp_path: Path, text: str, reason: str) -> None:
    file = tmp_path / "shape.txt"
    file.write_text(text)
    with pytest.raises((InputError, FileUsageError), match=reason):
        read_polygon(file, "mm")


@pytest.mark.parametrize("text", ["x,y\n0,0\n4,0\n0,3\n", "POLYGON ((0 0, 4 0, 0 3, 0 0))\n"])
def test_polygons_are_read_from_tables_and_from_text(tmp_path: Path, text: str) -> None:
    file = tmp_path / "shape.txt"
    file.write_text(text)
    shape = read_polygon(file, "mm", 0.5)
    assert np.allclose(shape.corners + shape.centre, [[0, 0], [4, 0], [0, 3]])
    assert (shape.radius, shape.clearance) == (0.5, 0.5)


def test_lengths_out_of_range_are_refused() -> None:
    for width, height in ((0.0, 1.0), (1.0, -2.0), (np.inf, 1.0)):
        with pytest.raises(InputError, match=r"rectangle: .* a finite length above 0"):
            Shape.rectangle(width, height)
    with pytest.raises(InputError, match="circle"):
        Shape.circle(-1.0)
    with pytest.raises(InputError, match="clearance"):
        Shape.circle(1.0, -0.1)
    with pytest.raises(InputError, match="finite coordinates"):
        Shape.polygon([(0.0, 0.0), (1.0, np.nan), (0.0, 1.0)])
    with pytest.raises(InputError, match=r"shape \(n, 2\)"):
        Shape.polygon([1.0, 2.0])
