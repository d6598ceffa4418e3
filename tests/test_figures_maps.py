"""What the figures show, against the numbers it is made from.

Areas of what is drawn are compared with clipping by shapely; text is drawn alone, piece by
piece, to see that none covers another or leaves the figure.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import closed_form_atlas
import matplotlib as mpl
import numpy as np
import pytest
import shapely
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from matplotlib.text import Text

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.atlas_figures import (
    charted_designs,
    condition_text,
    quantity_figure,
    region_figure,
    surface_figure,
)
from fivebar_atlas.figures.category_map import category_map, magnitude_map
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.contour_map import contour_map
from fivebar_atlas.figures.design_space import (
    constant_line,
    design_space_figure,
    region_loops,
)
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.mechanisms.quantities import Flags
from fivebar_atlas.store import Atlas, open_atlas
from fivebar_atlas.synthesis.conditions import parse_condition
from fivebar_atlas.synthesis.optimum_region import optimum_region

SPACES = ("surrounded", "assemblable")
FIRST, WITH_EMPTY = "+-/up", "++/up"


@pytest.fixture(scope="module", params=SPACES)
def atlas(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Atlas]:
    path = tmp_path_factory.mktemp("figures") / "closed_form.h5"
    with open_atlas(closed_form_atlas.write(path, request.param)) as opened:
        yield opened


@pytest.fixture(autouse=True)
def _settings_of_matplotlib_stay() -> Iterator[None]:
    before = dict(mpl.rcParams)
    yield
    assert dict(mpl.rcParams) == before


def artist(figure: Figure, name: str) -> Artist:
    (found,) = [each for each in figure.axes[0].get_children() if each.get_gid() == name]
    return found


def names(figure: Figure) -> set[str]:
    return {gid for each in figure.axes[0].get_children() if (gid := each.get_gid())}


def drawn_area(path: Outline) -> float:
    """Signed area of all loops of a path: holes run the other way and subtract."""
    total = 0.0
    for ring in path.to_polygons(closed_only=True):
        x, y = ring.T
        total += float(0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    return abs(total)


def band_area(designs: ChartedDesigns, values: np.ndarray, low: float, high: float) -> float:
    """Area between two levels, every triangle clipped by two half-planes with shapely."""
    total = 0.0
    for triangle in designs.triangles:
        if not np.isfinite(values[triangle]).all():
            continue
        piece: shapely.Geometry = shapely.Polygon(designs.points[triangle])
        gradient = np.linalg.solve(
            np.column_stack([designs.points[triangle], np.ones(3)]), values[triangle]
        )
        steepness = np.hypot(*gradient[:2])
        if steepness < 1e-9:
            total += piece.area * (low <= values[triangle[0]] < high)
            continue
        normal = gradient[:2] / steepness
        along = 50.0 * np.array([-normal[1], normal[0]])
        for level, inward in ((low, normal), (high, -normal)):
            foot = normal * (level - gradient[2]) / steepness
            piece = shapely.intersection(
                piece,
                shapely.Polygon(
                    [
                        foot - along,
                        foot + along,
                        foot + along + 100 * inward,
                        foot - along + 100 * inward,
                    ]
                ),
            )
        total += piece.area
    return total


def texts(figure: Figure) -> list[Text]:
    return [each for each in figure.findobj(Text) if each.get_visible() and each.get_text()]


def written(figure: Figure) -> list[str]:
    return [each.get_text() for each in texts(figure)]


def level_lines(figure: Figure, name: str = "levels") -> dict[float, np.ndarray]:
    """Return the points of the drawn lines, by level."""
    contours = artist(figure, name)
    lines = {}
    for level, path in zip(contours.levels, contours.get_paths(), strict=True):  # type: ignore[attr-defined]
        lines[float(level)] = np.concatenate(path.to_polygons(closed_only=False))
    return lines


def test_bands_of_a_contour_map_have_the_areas_of_the_interpolated_values(atlas: Atlas) -> None:
    designs = charted_designs(atlas)
    values = atlas.select("usable_workspace_area", FIRST)

    figure = quantity_figure(atlas, "usable_workspace_area", FIRST)

    bands = artist(figure, "bands")
    levels = np.arange(2.0 * np.floor(values.min() / 2.0), values.max() + 2.0, 2.0)
    np.testing.assert_allclose(bands.levels, levels, atol=1e-6)  # type: ignore[attr-defined]
    areas = [drawn_area(path) for path in bands.get_paths()]  # type: ignore[attr-defined]
    expected = [band_area(designs, values, low, high) for low, high in itertools.pairwise(levels)]
    np.testing.assert_allclose(areas, expected, rtol=1e-6, atol=1e-9)
    assert sum(areas) == pytest.approx(shapely.MultiPoint(designs.points).convex_hull.area)


def test_lines_of_a_contour_map_lie_where_the_stored_values_have_their_level(atlas: Atlas) -> None:
    designs = charted_designs(atlas)
    values = atlas.select("gci", FIRST)

    figure = quantity_figure(atlas, "gci", FIRST)

    lines = level_lines(figure)
    inner = np.arange(np.ceil(values.min() / 0.05), np.ceil(values.max() / 0.05)) * 0.05
    np.testing.assert_allclose(sorted(lines), inner, rtol=1e-9)
    corners = designs.points[designs.triangles]
    inverse = np.linalg.inv(np.concatenate([corners, np.ones((*corners.shape[:2], 1))], axis=2))
    for level, points in lines.items():
        homogeneous = np.column_stack([points, np.ones(len(points))])
        weights = np.einsum("pk,tkv->ptv", homogeneous, inverse)
        home = weights.min(axis=2).argmax(axis=1)
        own = weights[np.arange(len(points)), home]
        assert own.min() > -1e-9
        interpolated = (own * values[designs.triangles[home]]).sum(axis=1)
        np.testing.assert_allclose(interpolated, level, rtol=1e-9)


def test_every_level_that_is_written_is_a_level_and_stands_on_its_line(atlas: Atlas) -> None:
    figure = quantity_figure(atlas, "usable_workspace_area", FIRST)
    lines = level_lines(figure)
    labels = [each for each in texts(figure) if each.get_fontsize() == style.LEVEL_SIZE]

    assert len(labels) >= 0.6 * len(lines)
    for label in labels:
        points = lines[float(label.get_text())]
        distance = np.hypot(*(points - label.get_position()).T).min()
        # From the start of the text to its line: half its width at most.
        assert distance < 0.12


def test_an_empty_workspace_is_hatched_and_explained(atlas: Atlas) -> None:
    designs = charted_designs(atlas)
    empty = closed_form_atlas.empty_designs(designs.parameters)
    touched = empty[designs.triangles].any(axis=1)
    hatched = sum(shapely.Polygon(designs.points[t]).area for t in designs.triangles[touched])

    for name in ("gci", "usable_workspace_area", "usable_workspace_area_error", "max_lci"):
        figure = quantity_figure(atlas, name, WITH_EMPTY)
        missing = artist(figure, "missing")
        assert missing.get_hatch()  # type: ignore[attr-defined]
        assert "empty usable workspace" in written(figure)
        if name.endswith("_error"):
            continue
        assert drawn_area(missing.get_path()) == pytest.approx(hatched, rel=1e-9)  # type: ignore[attr-defined]
    assert "missing" not in names(quantity_figure(atlas, "gci", FIRST))
    figure = quantity_figure(atlas, "good_condition_gci", WITH_EMPTY, 0.5)
    assert "no workspace with LCI \u2265 0.5" in written(figure)


def test_a_quantity_without_any_value_is_all_hatched(atlas: Atlas) -> None:
    figure = quantity_figure(atlas, "mic_lower_radius", FIRST)

    hull = shapely.MultiPoint(charted_designs(atlas).points).convex_hull
    missing = artist(figure, "missing")
    assert drawn_area(missing.get_path()) == pytest.approx(hull.area, rel=1e-9)  # type: ignore[attr-defined]
    assert "no lower inscribed circle" in written(figure)
    assert "bands" not in names(figure)


def test_a_constant_quantity_has_one_colour_and_its_value_in_the_key(atlas: Atlas) -> None:
    figure = quantity_figure(atlas, "mic_upper_y", FIRST)

    hull = shapely.MultiPoint(charted_designs(atlas).points).convex_hull
    assert drawn_area(artist(figure, "bands").get_path()) == pytest.approx(hull.area, rel=1e-9)  # type: ignore[attr-defined]
    assert "0 everywhere" in " ".join(written(figure))
    assert "levels" not in names(figure)


def test_a_plateau_at_the_highest_level_is_filled_and_has_no_line() -> None:
    designs = ChartedDesigns.of_lattice(mechanisms.get("five-bar"), "assemblable", 20)
    values = np.minimum(1.0, 2.0 - designs.parameters[:, 2])
    values[::3] += 1e-16 * np.arange(len(values[::3]))

    figure = contour_map(designs, values, "Plateau", "plateau")

    bands = artist(figure, "bands")
    areas = [drawn_area(path) for path in bands.get_paths()]  # type: ignore[attr-defined]
    hull = shapely.MultiPoint(designs.points).convex_hull
    assert sum(areas) == pytest.approx(hull.area, rel=1e-9)
    assert max(level_lines(figure)) < 0.99


def test_categories_fill_the_cells_of_their_designs(atlas: Atlas) -> None:
    designs = charted_designs(atlas)
    status = atlas.select("status", WITH_EMPTY)
    thirds = np.bincount(
        designs.triangles.ravel(),
        weights=np.repeat(
            [shapely.Polygon(designs.points[t]).area / 3 for t in designs.triangles], 3
        ),
    )

    figure = quantity_figure(atlas, "status", WITH_EMPTY)

    for value in np.unique(status):
        patch = artist(figure, f"category-{value}")
        area = drawn_area(patch.get_path())  # type: ignore[attr-defined]
        assert area == pytest.approx(thirds[status == value].sum(), rel=1e-9)
    assert {
        "no lower inscribed circle",
        "empty usable workspace, no lower inscribed circle",
    } <= set(written(figure))


def test_errors_are_drawn_by_magnitude_design_by_design(atlas: Atlas) -> None:
    designs = charted_designs(atlas)
    errors = atlas.select("usable_workspace_area_error", FIRST)
    thirds = np.bincount(
        designs.triangles.ravel(),
        weights=np.repeat(
            [shapely.Polygon(designs.points[t]).area / 3 for t in designs.triangles], 3
        ),
    )

    figure = quantity_figure(atlas, "usable_workspace_area_error", FIRST)

    for band, power in enumerate((-9, -8, -7)):
        inside = (errors >= 10.0**power) & (errors < 10.0 ** (power + 1))
        area = drawn_area(artist(figure, f"band-{band}").get_path())  # type: ignore[attr-defined]
        assert area == pytest.approx(thirds[inside].sum(), rel=1e-9)
    assert {"$10^{-9}$", "$10^{-8}$", "$10^{-7}$", "$10^{-6}$"} <= set(written(figure))


def test_errors_of_zero_are_exact_and_not_the_smallest_magnitude() -> None:
    designs = ChartedDesigns.of_lattice(mechanisms.get("five-bar"), "surrounded", 20)
    errors = np.full(len(designs.points), 1e-8)
    errors[:5] = 0.0

    figure = magnitude_map(designs, errors, "Errors", "error")

    assert {"exact", "band-0"} <= names(figure)
    assert "0 (exact)" in written(figure)
    only_zero = magnitude_map(designs, np.zeros(len(designs.points)), "Errors", "error")
    assert "band-0" not in names(only_zero)


def test_wide_ticks_of_a_colour_bar_stay_in_the_figure() -> None:
    designs = ChartedDesigns.of_lattice(mechanisms.get("five-bar"), "surrounded", 12)
    errors = np.geomspace(2e-15, 1.9e-13, len(designs.points))
    figure = magnitude_map(designs, errors, "Errors", "error", width=60.0)

    (bar,) = [axes for axes in figure.axes if axes.get_label() == "colour bar"]
    with style.styled():
        figure.draw_without_rendering()
        extents = [label.get_window_extent() for label in bar.get_xticklabels()]
    assert r"$2\!\times\!10^{-15}$" in written(figure)
    assert min(extent.x0 for extent in extents) > 0.0
    assert max(extent.x1 for extent in extents) < figure.bbox.width


def test_the_region_is_that_of_the_conditions_and_its_outline_is_drawn(atlas: Atlas) -> None:
    texts_given = ("gci>=0.45", "usable_workspace_area>=20", "r1<=1.6")
    conditions = [parse_condition(text) for text in texts_given]
    found = optimum_region(atlas, conditions, FIRST)
    bounds = [(each.quantity, each.operator, each.bound) for each in conditions]

    figure = region_figure(atlas, found.region, bounds, FIRST)

    designs = charted_designs(atlas)
    gci, area = atlas.select("gci", FIRST), atlas.select("usable_workspace_area", FIRST)
    smallest = np.min([gci - 0.45, area - 20.0, 1.6 - designs.parameters[:, 0]], axis=0)
    assert (smallest > 0).any()
    patch = artist(figure, "region")
    drawn = drawn_area(patch.get_path())  # type: ignore[attr-defined]
    # Independent: a fine raster of every triangle, each point tested against all conditions.
    steps = 40
    grid = [(i + 1 / 3, j + 1 / 3) for i in range(steps) for j in range(steps - i)]
    grid += [(i + 2 / 3, j + 2 / 3) for i in range(steps) for j in range(steps - i - 1)]
    weights = np.array([(i, j, steps - i - j) for i, j in grid]) / steps
    fulfilled = np.ones((len(designs.triangles), len(weights)), dtype=bool)
    for margin in (gci - 0.45, area - 20.0, 1.6 - designs.parameters[:, 0]):
        fulfilled &= margin[designs.triangles] @ weights.T >= 0.0
    sizes = np.array([shapely.Polygon(designs.points[t]).area for t in designs.triangles])
    assert drawn == pytest.approx(float((fulfilled.mean(axis=1) * sizes).sum()), rel=3e-3)
    assert patch.get_linewidth() > 0  # type: ignore[attr-defined]
    assert "GCI \u2265 0.45, $W$ \u2265 20, $r_1$ \u2264 1.6" in written(figure)
    assert {"bands", "levels", "dashed-levels"} <= names(figure)


def test_an_empty_region_is_not_drawn_and_said_to_be_empty(atlas: Atlas) -> None:
    conditions = [parse_condition("gci>0.9")]
    found = optimum_region(atlas, conditions, FIRST)

    figure = region_figure(atlas, found.region, [("gci", ">", 0.9)], FIRST)

    assert "region" not in names(figure)
    assert "no design fulfils GCI > 0.9" in written(figure)


def test_titles_name_quantity_mode_pair_and_threshold(atlas: Atlas) -> None:
    assert "Usable workspace area, mode +\u2212/up" in written(
        quantity_figure(atlas, "usable_workspace_area", "pm/up")
    )
    title = written(quantity_figure(atlas, "good_condition_workspace_area", WITH_EMPTY, 0.3))
    assert "Good-condition workspace area, mode ++/up, LCI \u2265 0.3" in title
    assert "Theoretical workspace area" in written(
        quantity_figure(atlas, "theoretical_workspace_area")
    )
    assert "y where the local conditioning index is largest, mode ++/up" in written(
        quantity_figure(atlas, "max_lci_y", WITH_EMPTY)
    )


def test_the_colour_bar_has_every_level_name_and_unit(atlas: Atlas) -> None:
    figure = quantity_figure(atlas, "usable_workspace_area", FIRST)
    (bar,) = [axes for axes in figure.axes if axes.get_label() == "colour bar"]

    ticks = [label.get_text() for label in bar.get_xticklabels()]
    least = atlas.select("usable_workspace_area", FIRST).min()
    assert ticks == [str(level) for level in range(2 * int(least // 2), 29, 2)]
    assert "usable workspace area $W$ (in units of $D^2$)" in written(figure)
    colours = {patch.get_facecolor() for patch in bar.patches}
    bands = artist(figure, "bands")
    assert colours == {tuple(colour) for colour in bands.get_facecolor()}  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        (("gci", ">=", 0.62), "GCI \u2265 0.62"),
        (("usable_workspace_area", "<", 24.0), "$W$ < 24"),
        (("max_lci_y", "<=", -0.5), r"$y(\mathrm{LCI}_{\max})$ " + "\u2264 \u22120.5"),
        (("gci_error", ">", 1e-7), "error of GCI > 1e\u221207"),
        (("r3", "<=", 0.131), "$r_3$ \u2264 0.131"),
    ],
)
def test_conditions_are_written_with_symbols(
    atlas: Atlas, condition: tuple[str, str, float], expected: str
) -> None:
    assert condition_text(atlas, *condition) == expected


@pytest.mark.parametrize("space", SPACES)
def test_sub_regions_are_bounded_by_the_borders(space: str) -> None:
    mechanism = mechanisms.get("five-bar")
    chart = mechanism.chart(space)
    corners = {
        "IVa": [(0, 3, 0), (1.5, 1.5, 0), (0.75, 1.5, 0.75)],
        "Va": [(1.5, 1.5, 0), (1, 1, 1), (0.75, 1.5, 0.75)],
        "Vb": [(1.5, 1.5, 0), (1.5, 0.75, 0.75), (1, 1, 1)],
        "IVb": [(3, 0, 0), (1.5, 0.75, 0.75), (1.5, 1.5, 0)],
    }

    for region in chart.regions:
        (loop,) = region_loops(chart, region)
        expected = shapely.Polygon(mechanism.project(np.array(corners[region.name]), space))
        assert shapely.symmetric_difference(shapely.Polygon(loop), expected).area < 1e-12


@pytest.mark.parametrize("space", SPACES)
def test_lines_of_constant_parameters_keep_their_parameter(space: str) -> None:
    chart = mechanisms.get("five-bar").chart(space)
    lines = 0
    for parameter, axis in enumerate(chart.axes):
        for tick in axis.ticks:
            line = constant_line(chart, tick)
            if line is None:
                continue
            x, r3 = line.T
            r1 = (np.sqrt(3) * x - r3) / 2
            lengths = np.column_stack([r1, 3 - r1 - r3, r3])
            np.testing.assert_allclose(lengths[:, parameter], float(tick.label), atol=1e-9)
            assert lengths.min() > -1e-9
            lines += 1
    assert lines >= 10


def varied_figures(atlas: Atlas, width: float) -> Iterator[tuple[str, Figure]]:
    """Every kind of figure, with long titles, long keys, dense and upright contours."""
    for name in (
        "usable_workspace_area",
        "usable_workspace_area_error",
        "good_condition_workspace_area",
        "max_lci_y",
        "mic_upper_y",
        "status",
    ):
        yield name, quantity_figure(atlas, name, WITH_EMPTY, 0.5, width=width)
    for elevation, azimuth in ((25.0, -65.0), (10.0, -100.0), (60.0, 35.0), (25.0, 180.0)):
        view = {"elevation": elevation, "azimuth": azimuth, "width": width}
        for name in ("usable_workspace_area", "gci_error", "good_condition_gci"):
            yield f"{name}, {view}", surface_figure(atlas, name, WITH_EMPTY, 0.5, **view)
    for text in ("gci>=0.45", "good_condition_gci>0.9"):
        condition = parse_condition(text)
        found = optimum_region(atlas, [condition], WITH_EMPTY, 0.5)
        bounds = [(condition.quantity, condition.operator, condition.bound)]
        yield text, region_figure(atlas, found.region, bounds, WITH_EMPTY, 0.5, width=width)
    chart = atlas.mechanism.chart(atlas.settings.space)
    yield "design space", design_space_figure(chart, "Design space", width=width)


@pytest.mark.parametrize("width", [60.0, 85.0, 180.0])
def test_no_text_covers_another_leaves_the_figure_or_is_too_small(
    atlas: Atlas, width: float
) -> None:
    resolution = 100
    for name, figure in varied_figures(atlas, width):
        assert figure.get_figwidth() * 25.4 == pytest.approx(width)
        columns, rows = (figure.get_size_inches() * resolution).astype(int)
        figure.set_dpi(resolution)
        covered = np.zeros((rows, columns), dtype=bool)
        renderer = RendererAgg(columns, rows, resolution)
        for text in texts(figure):
            assert text.get_fontsize() >= 6.0, (name, text.get_text())
            renderer.clear()
            text.set_path_effects([])
            with style.styled():
                text.draw(renderer)
            ink = np.asarray(renderer.buffer_rgba())[:, :, 3] > 40
            assert ink.any(), (name, text.get_text())
            edge = ink[0].any() or ink[-1].any() or ink[:, 0].any() or ink[:, -1].any()
            assert not edge, (name, text.get_text())
            assert not (ink & covered).any(), (name, text.get_text())
            covered |= ink


def test_settings_of_the_user_do_not_reach_the_figures(atlas: Atlas) -> None:
    plain = np.asarray(drawn(quantity_figure(atlas, "gci", FIRST)))
    with mpl.rc_context({"font.family": "monospace", "font.size": 20, "hatch.linewidth": 3}):
        figure = quantity_figure(atlas, "gci", FIRST)
        np.testing.assert_array_equal(np.asarray(drawn(figure)), plain)


def drawn(figure: Figure) -> memoryview:
    from fivebar_atlas.figures.saving import rendered

    return memoryview(rendered(figure, "png", 60.0))


@pytest.mark.parametrize("width", [0.0, -85.0, 59.9, 401.0, float("nan"), float("inf")])
def test_a_width_that_no_page_has_is_refused(atlas: Atlas, width: float) -> None:
    with pytest.raises(InputError, match="millimetres from 60 to 400"):
        quantity_figure(atlas, "gci", FIRST, width=width)


def test_values_must_be_one_for_each_design() -> None:
    designs = ChartedDesigns.of_lattice(mechanisms.get("five-bar"), "surrounded", 12)
    with pytest.raises(InputError, match="one value for each"):
        contour_map(designs, np.zeros(3), "", "")


def test_what_is_not_in_the_file_is_refused(atlas: Atlas) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'gci'"):
        quantity_figure(atlas, "gcj", FIRST)
    with pytest.raises(InputError, match=r"\+-/up, \+\+/up"):
        quantity_figure(atlas, "gci", "--/down")
    with pytest.raises(InputError, match=r"\+-/up, \+\+/up"):
        quantity_figure(atlas, "gci")
    with pytest.raises(InputError, match=r"0\.3, 0\.5"):
        quantity_figure(atlas, "good_condition_gci", FIRST, 0.7)


def test_pictures_are_as_wide_as_asked_for(atlas: Atlas, tmp_path: Path) -> None:
    from PIL import Image

    from fivebar_atlas.figures.saving import save_figure

    save_figure(quantity_figure(atlas, "gci", FIRST), tmp_path / "gci.png")
    with Image.open(tmp_path / "gci.png") as picture:
        assert picture.width == int(85 / 25.4 * 300)


def test_a_chart_without_axes_borders_and_names_is_enough() -> None:
    """Draw for a mechanism that declares the least there can be."""
    chart = DesignChart(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), (), (), ())
    designs = ChartedDesigns(
        parameters=chart.outline, points=chart.outline, triangles=np.array([[0, 1, 2]]), chart=chart
    )

    figure = contour_map(designs, np.array([0.0, 1.0, 2.0]), "Two links", "span")

    assert sum(drawn_area(path) for path in artist(figure, "bands").get_paths()) == pytest.approx(  # type: ignore[attr-defined]
        0.5
    )
    for other in (
        category_map(designs, np.array([0, 1, 1]), Flags((0, 1), ("left", "right")), "Side"),
        magnitude_map(designs, np.array([1e-9, 1e-8, 0.0]), "Error", "error"),
        design_space_figure(chart, "Design space"),
    ):
        assert len(drawn(other)) > 1000
