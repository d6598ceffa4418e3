"""Surfaces above the design space: what is cut, what hides what, and what is left free.

Areas are compared with clipping by shapely, and what is seen with rays that are met with
every triangle in turn.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import closed_form_atlas
import numpy as np
import numpy.typing as npt
import pytest
import shapely
from test_figures_maps import artist, band_area, names, written

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.atlas_figures import surface_figure
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.oblique_view import ObliqueView
from fivebar_atlas.figures.saving import rendered
from fivebar_atlas.figures.surface_map import surface_map
from fivebar_atlas.figures.surface_pieces import cut_at_levels
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.store import Atlas, open_atlas

FloatArray = npt.NDArray[np.float64]
VIEWS = [(25.0, -65.0), (10.0, 20.0), (60.0, 130.0), (35.0, -150.0), (25.0, -90.0)]


@pytest.fixture(scope="module")
def atlas(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Atlas]:
    path = tmp_path_factory.mktemp("surface") / "closed_form.h5"
    with open_atlas(closed_form_atlas.write(path)) as opened:
        yield opened


def hilly() -> tuple[ChartedDesigns, FloatArray]:
    """Return a square lattice with two hills, one behind the other, and a hole."""
    steps = 24
    side = np.linspace(0.5, 2.0, steps + 1)
    points = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    first = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    lower = np.column_stack([first, first + 1, first + steps + 2])
    upper = np.column_stack([first, first + steps + 2, first + steps + 1])
    chart = DesignChart(np.array([[0.5, 0.5], [2.0, 0.5], [2.0, 2.0], [0.5, 2.0]]), (), (), ())
    x, y = points.T
    values = np.exp(-8.0 * ((x - 0.9) ** 2 + (y - 0.9) ** 2))
    values += 0.9 * np.exp(-12.0 * ((x - 1.6) ** 2 + (y - 1.7) ** 2)) + 0.1 * x
    values[(x - 1.5) ** 2 + (y - 0.9) ** 2 < 0.04] = np.nan
    return ChartedDesigns(points, points, np.concatenate([lower, upper]), chart), values


# Cutting


def test_pieces_tile_the_triangles_and_lie_in_their_bands() -> None:
    rng = np.random.default_rng(4)
    designs, values = hilly()
    values = np.where(np.isnan(values), 0.2, values) + rng.uniform(0.0, 0.05, len(values))
    values[rng.random(len(values)) < 0.2] = 0.5  # some corners on a level, some sides level
    levels = np.array([0.25, 0.5, 0.75, 1.0])  # what is beyond is in the outermost bands
    corners = values[designs.triangles]
    pieces = cut_at_levels(corners, levels)
    assert np.all(pieces.weights >= 0.0)
    np.testing.assert_allclose(pieces.weights.sum(axis=2), 1.0, atol=1e-12)
    heights = np.einsum("kpc,kc->kp", pieces.weights, corners[pieces.triangles])
    low, high = levels[pieces.bands], levels[pieces.bands + 1]
    low, high = np.where(pieces.bands == 0, -9.0, low), np.where(pieces.bands == 2, 9.0, high)
    assert np.all(heights >= low[:, None] - 1e-12)
    assert np.all(heights <= high[:, None] + 1e-12)
    at_level = heights[pieces.is_cut][:, 3:]
    np.testing.assert_allclose(at_level, np.stack([high[pieces.is_cut]] * 2, axis=1))
    places = np.einsum(
        "kpc,kcx->kpx", pieces.weights, designs.points[designs.triangles[pieces.triangles]]
    )
    areas = shapely.area(shapely.polygons(places))
    whole = shapely.area(shapely.polygons(designs.points[designs.triangles]))
    np.testing.assert_allclose(np.bincount(pieces.triangles, areas), whole, rtol=1e-9)
    for band, (least, most) in enumerate([(0.0, 0.5), (0.5, 0.75), (0.75, 1.5)]):
        expected = band_area(designs, values, least, most)
        assert areas[pieces.bands == band].sum() == pytest.approx(expected, rel=1e-9)


# What is seen


def surface_polygons(figure: object) -> tuple[list[FloatArray], FloatArray, FloatArray]:
    """Return shape, colour and line width of what is drawn, the last in front."""
    found = artist(figure, "surface")  # type: ignore[arg-type]
    paths = [path.vertices for path in found.get_paths()]  # type: ignore[attr-defined]
    return paths, found.get_facecolors(), np.asarray(found.get_linewidths())  # type: ignore[attr-defined]


def nearest_value(
    designs: ChartedDesigns, values: FloatArray, view: ObliqueView, rise: float, base: float
) -> tuple[FloatArray, FloatArray]:
    """Return points on paper and the value that is seen there, NaN where there is none.

    A ray through a point of the paper meets a triangle where it meets its projection; of all
    that it meets the nearest is seen.
    """
    turn = np.radians(view.azimuth)
    towards = np.array([np.cos(turn), np.sin(turn)])
    across = np.array([-towards[1], towards[0]])
    up = base + rise * values - np.sin(np.radians(view.elevation)) * (designs.points @ towards)
    paper = np.column_stack([designs.points @ across, up])
    triangles = designs.triangles[np.isfinite(values[designs.triangles]).all(axis=1)]
    rng = np.random.default_rng(8)
    low, high = np.nanmin(paper, axis=0), np.nanmax(paper, axis=0)
    rays = rng.uniform(low, high, (3000, 2))
    a, b, c = (paper[triangles[:, corner]] for corner in range(3))
    area = np.cross(b - a, c - a)
    best, seen = np.full(len(rays), -np.inf), np.full(len(rays), np.nan)
    for number, ray in enumerate(rays):
        one, other = np.cross(ray - a, c - a) / area, np.cross(b - a, ray - a) / area
        weights = np.column_stack([1.0 - one - other, one, other])
        met = np.flatnonzero(weights.min(axis=1) >= 0.0)
        if len(met):
            corners = triangles[met]
            nearness = (weights[met] * (designs.points[corners] @ towards)).sum(axis=1)
            nearest = int(np.argmax(nearness))
            best[number] = nearness[nearest]
            seen[number] = weights[met][nearest] @ values[corners[nearest]]
    return rays, seen


@pytest.mark.filterwarnings("ignore:Arrays of 2-dimensional vectors:DeprecationWarning")
@pytest.mark.parametrize(("elevation", "azimuth"), VIEWS)
def test_what_is_nearer_hides_what_is_behind(elevation: float, azimuth: float) -> None:
    """The colour that is drawn last is that of the value which a ray meets first."""
    designs, values = hilly()
    view = ObliqueView(elevation, azimuth)
    figure = surface_map(designs, values, "Hills", "height", "$h$", view=view)
    shapes, colours, widths = surface_polygons(figure)
    is_piece = widths < 0.4
    pieces = [shape for shape, kept in zip(shapes, is_piece, strict=True) if kept]
    # the scale of heights, from the two points of the post
    floor = view.place(designs.chart.outline)
    (post,) = artist(figure, "upright").get_segments()  # type: ignore[attr-defined]
    levels = 0.1 * np.arange(np.floor(10 * np.nanmin(values)), np.ceil(10 * np.nanmax(values)) + 1)
    rise = (post[1, 1] - post[0, 1]) / (levels[-1] - levels[0])
    foot = floor[np.argmin(np.abs(floor[:, 0] - post[0, 0]) + 1e-6 * floor[:, 1])]
    rays, seen = nearest_value(designs, values, view, rise, post[0, 1] - foot[1])
    expected = style.colour_map()(np.linspace(0.0, 1.0, len(levels) - 1))
    tree = shapely.STRtree(shapely.polygons([shape[:5] for shape in pieces]))
    ray, piece = tree.query(shapely.points(rays), predicate="intersects")
    last = np.full(len(rays), -1)
    np.maximum.at(last, ray, piece)
    # of a hole, and beside the surface, there is nothing to see
    assert np.count_nonzero((last < 0) != np.isnan(seen)) <= 2
    both = (last >= 0) & np.isfinite(seen)
    assert np.count_nonzero(both) > 500
    found = colours[is_piece][last[both]]
    bands = np.searchsorted(levels, seen[both], side="right") - 1
    wrong = np.abs(found - expected[bands]).max(axis=1) > 1e-6
    assert wrong.mean() < 0.004


@pytest.mark.parametrize(("elevation", "azimuth"), VIEWS)
def test_the_floor_is_hidden_nowhere(elevation: float, azimuth: float) -> None:
    designs, values = hilly()
    view = ObliqueView(elevation, azimuth)
    figure = surface_map(designs, values, "Hills", "height", "$h$", view=view)
    shapes, _, _ = surface_polygons(figure)
    floor = shapely.Polygon(view.place(designs.chart.outline))
    assert not any(floor.intersects(shapely.LineString(shape)) for shape in shapes)
    bands = artist(figure, "bands").get_paths()  # type: ignore[attr-defined]
    for path in bands:
        assert floor.buffer(1e-9).covers(shapely.MultiPoint(path.vertices))


def test_nothing_is_drawn_across_a_hole(atlas: Atlas) -> None:
    designs, values = hilly()
    figure = surface_map(designs, values, "Hills", "height", "$h$", missing="no hill")
    shapes, _, widths = surface_polygons(figure)
    present = np.isfinite(values[designs.triangles]).all(axis=1)
    assert 0 < np.count_nonzero(~present) < len(present) / 4
    # heights do not change a width on paper, so the pieces are as wide as their triangles
    assert "no hill" in written(figure)
    border = [shape for shape, width in zip(shapes, widths, strict=True) if width == 0.7]
    sides = np.sort(designs.triangles[present][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, counts = np.unique(sides, axis=0, return_counts=True)
    assert len(border) == np.count_nonzero(counts == 1)
    figure = surface_figure(atlas, "gci", "++/up")
    assert {"surface", "missing", "bands", "levels", "walls", "upright"} <= names(figure)
    assert "empty usable workspace" in written(figure)


def test_axes_are_those_of_the_chart(atlas: Atlas) -> None:
    texts = written(surface_figure(atlas, "usable_workspace_area", "+-/up"))
    assert {"$r_1$", "$r_2$", "$r_3$", "$W$", "2.5", "0.6"} <= set(texts)
    assert any("in units of $D^2$" in text for text in texts)
    assert any(text.startswith("Usable workspace area, mode") for text in texts)


def test_errors_are_heights_of_their_magnitudes(atlas: Atlas) -> None:
    figure = surface_figure(atlas, "usable_workspace_area_error", "+-/up")
    assert {"$10^{-9}$", "$10^{-7}$"} <= set(written(figure))
    assert "levels" not in names(figure)
    designs, _ = hilly()
    errors = np.where(designs.points[:, 0] < 1.0, 0.0, 1e-9 * designs.points[:, 1])
    figure = surface_map(designs, errors, "E", "error", "$e$", magnitudes=True)
    assert "0 (exact)" in written(figure)
    errors[0] = np.nan
    figure = surface_map(designs, errors, "E", "error", "$e$", magnitudes=True)
    assert "no value, or 0 (exact)" in written(figure)


def test_a_plane_and_nothing_at_all_are_drawn() -> None:
    designs, values = hilly()
    for constant in (0.25, 0.0, -3.0):
        figure = surface_map(designs, np.full_like(values, constant), "Plane", "height", "$h$")
        number = f"{constant:g}".replace("-", "\N{MINUS SIGN}")
        assert {f"height: {number} everywhere", number} <= set(written(figure))
        assert "surface" in names(figure)
    for magnitudes in (False, True):
        empty = np.full_like(values, np.nan)
        figure = surface_map(designs, empty, "None", "height", "$h$", magnitudes=magnitudes)
        assert "no value" in written(figure)
        assert "surface" not in names(figure)
        assert len(rendered(figure, "png")) > 1000


def test_large_surfaces_are_images_in_vector_files(monkeypatch: pytest.MonkeyPatch) -> None:
    designs, values = hilly()
    small = rendered(surface_map(designs, values, "Hills", "height", "$h$"), "svg")
    assert b"<image" not in small
    monkeypatch.setattr("fivebar_atlas.figures.surface_map._MOST_PIECES", 500)
    large = rendered(surface_map(designs, values, "Hills", "height", "$h$"), "svg")
    assert b"<image" in large
    assert large == rendered(surface_map(designs, values, "Hills", "height", "$h$"), "svg")


def test_angles_and_values_are_checked(atlas: Atlas) -> None:
    for elevation, azimuth in ((4.9, 0.0), (81.0, 0.0), (float("nan"), 0.0), (30.0, 361.0)):
        with pytest.raises(InputError, match="degrees from"):
            surface_figure(atlas, "gci", "+-/up", elevation=elevation, azimuth=azimuth)
    with pytest.raises(InputError, match="a category has no height"):
        surface_figure(atlas, "status", "+-/up")
    designs = ChartedDesigns.of_lattice(mechanisms.get("five-bar"), "surrounded", 12)
    with pytest.raises(InputError, match="one value for each"):
        surface_map(designs, np.zeros(3), "", "", "")


def test_a_full_turn_changes_nothing_and_the_chart_may_run_either_way() -> None:
    designs, values = hilly()
    clockwise = dataclasses.replace(
        designs, chart=dataclasses.replace(designs.chart, outline=designs.chart.outline[::-1])
    )
    pictures = {
        rendered(surface_map(each, values, "Hills", "height", "$h$", view=view), "png")
        for each in (designs, clockwise)
        for view in (ObliqueView(25.0, -65.0), ObliqueView(25.0, 295.0))
    }
    assert len(pictures) == 1


def test_the_command_and_the_figure_have_one_default() -> None:
    from fivebar_atlas.cli.plot.stored import surface
    from fivebar_atlas.figures.surface_map import DEFAULT_AZIMUTH, DEFAULT_ELEVATION

    defaults = {each.name: each.default for each in surface.params}  # type: ignore[attr-defined]
    assert (defaults["elevation"], defaults["azimuth"]) == (DEFAULT_ELEVATION, DEFAULT_AZIMUTH)
