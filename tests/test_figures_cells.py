"""Atlases of small drawings: what is drawn, where, how large, and the commands.

Drawings are measured in the figure: their paths are moved back to the designs' own frames with
the scale bar that the figure itself shows, and compared with integrated areas, conditions of
singularity computed from scratch, and polygons of shapely.
"""

from __future__ import annotations

import csv
import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

import naive
import numpy as np
import pytest
import shapely
from conftest import Command
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from matplotlib.text import Text
from PIL import Image
from shapely import affinity

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.cell_atlas import cell_atlas
from fivebar_atlas.figures.design_cells import (
    DesignCell,
    loci_cells,
    locus_mode,
    representative_designs,
    shape_cells,
)
from fivebar_atlas.mechanisms.settings import SweepSettings

Refused = Callable[..., str]

FIVE_BAR = mechanisms.get("five-bar")
SPACES = ("surrounded", "assemblable")
SERIAL, FOLDED, EXTENDED = "serial", "parallel, folded", "parallel, extended"
# Chords leave arcs by no more than this, in units of D.
DEVIATION = 1e-3


def sub_region(design: np.ndarray) -> tuple[bool, ...] | None:
    """Return on which side of every border a design lies, None if it is on one."""
    r1, r2, r3 = design
    margins = np.array([r1 - r2, r2 - r1 - r3, r1 - r2 - r3, r1 - r3, r2 - r3])
    return None if np.abs(margins).min() < 1e-9 else tuple((margins > 0).tolist())


def artists(figure: Figure) -> dict[str, Artist]:
    found = [(each.get_gid(), each) for each in figure.axes[0].get_children()]
    return {gid: each for gid, each in found if gid}


def drawn_scale(figure: Figure) -> float:
    """Return chart units per unit of length in a drawing, by the scale bar."""
    (strip,) = [axes for axes in figure.axes if axes.get_label() == "scale bar"]
    (bar,) = [line for line in strip.lines if line.get_gid() == "scale-bar"]
    millimetres = float(np.ptp(bar.get_xdata()))
    width = figure.get_figwidth() * 25.4
    return millimetres * float(np.ptp(figure.axes[0].get_xlim())) / width


def pieces(path: Outline) -> list[np.ndarray]:
    """Return the lines that a path consists of, closed ones with their first point again."""
    starts = np.flatnonzero(path.codes == Outline.MOVETO)
    parts = np.split(np.arange(len(path.codes)), starts[1:])
    return [path.vertices[part] for part in parts]


def own_frame(figure: Figure, cell: DesignCell, artist: Artist) -> list[np.ndarray]:
    """Return the lines of an artist in the frame of the design it belongs to."""
    place = FIVE_BAR.project(cell.parameters, "surrounded")
    scale = drawn_scale(figure)
    return [(line - place) / scale for line in pieces(artist.get_path())]  # type: ignore[attr-defined]


def drawn_shapes(figure: Figure, cells: tuple[DesignCell, ...]) -> list[shapely.Polygon | None]:
    """Return the shaded areas as polygons in the designs' own frames, None where there is none."""
    found = artists(figure)
    shapes = []
    for number, cell in enumerate(cells, start=1):
        patch = found[f"cell-{number}"]
        if not hasattr(patch, "get_facecolor"):
            shapes.append(None)
            continue
        outline, *holes = own_frame(figure, cell, patch)
        shapes.append(shapely.Polygon(outline, holes))
    return shapes


def drawn_lines(
    figure: Figure, cells: tuple[DesignCell, ...], number: int, kind: str
) -> list[np.ndarray]:
    """Return the lines of one kind of a drawing, counted from 0, in the design's own frame."""
    patch = artists(figure).get(f"cell-{number + 1}-{kind.replace(', ', '-')}")
    return [] if patch is None else own_frame(figure, cells[number], patch)


def hulls(figure: Figure, cells: tuple[DesignCell, ...]) -> list[shapely.Geometry]:
    """Return the convex hulls of all drawings, marks of empty ones too, in the chart."""
    found = artists(figure)
    result = []
    for number, cell in enumerate(cells, start=1):
        parts = [found[name] for name in found if name.split("-")[:2] == ["cell", str(number)]]
        points = [
            each.get_path().vertices if hasattr(each, "get_facecolor") else each.get_xydata()  # type: ignore[attr-defined]
            for each in parts
        ]
        hull = shapely.MultiPoint(np.concatenate(points)).convex_hull
        if not cell.lines:
            (mark,) = parts
            chart_per_point = np.ptp(figure.axes[0].get_xlim()) / (72.0 * figure.get_figwidth())
            hull = hull.buffer(mark.get_markersize() / 2 * chart_per_point, cap_style="square")  # type: ignore[attr-defined]
        result.append(hull)
    return result


def texts(figure: Figure) -> list[Text]:
    return [each for each in figure.findobj(Text) if each.get_visible() and each.get_text()]


def written(figure: Figure) -> list[str]:
    return [each.get_text() for each in texts(figure)]


def draw(cells: tuple[DesignCell, ...], space: str = "surrounded", width: float = 170.0) -> Figure:
    return cell_atlas(FIVE_BAR.chart(space), cells, "Title", width=width)


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("count", [12, 15, 24, 50, 60, 97, 150, 400])
def test_representatives_are_a_staggered_lattice_over_every_sub_region(
    space: str, count: int
) -> None:
    designs = representative_designs(FIVE_BAR, space, count)

    fine = {sub_region(design) for design in FIVE_BAR.lattice(space, 97)}
    assert {sub_region(design) for design in designs} >= fine - {None}
    triples = {tuple(np.round(design, 9)) for design in designs}
    assert {(r2, r1, r3) for r1, r2, r3 in triples} == triples
    assert (designs[:, 2] == 0.0).any()
    np.testing.assert_allclose(designs.sum(axis=1), 3.0, rtol=1e-15)
    points = FIVE_BAR.project(designs, space)
    gaps = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    spacing = np.sort(gaps, axis=1)[:, 1].min()
    neighbours = (np.abs(gaps - spacing) < 1e-9).sum(axis=1)
    assert neighbours.max() <= 6
    # whoever is farther from the edge of the space than its neighbours has all six
    edge = shapely.Polygon(FIVE_BAR.chart(space).outline).exterior
    inner = np.array([edge.distance(shapely.Point(point)) > 1.001 * spacing for point in points])
    assert (neighbours[inner] == 6).all()
    assert inner.sum() > 0.1 * len(designs) or len(designs) < 40


def staggered_lattices(space: str, steps: int) -> Iterator[list[tuple[int, int, int]]]:
    """Yield both lattices of twice the step in whole numbers that sum to twice the steps."""
    total = 2 * steps
    for parity in (0, 1):
        found = []
        for k in range(0, total + 1, 2):
            for i in range(1, total - k):
                j = total - k - i
                inside = min(i, j) >= k if space == "surrounded" else 2 * k <= total
                if inside and i % 2 == parity:
                    found.append((i, j, k))
        yield found


@pytest.mark.parametrize("space", SPACES)
def test_the_number_of_representatives_is_nearest_to_what_was_asked_for(space: str) -> None:
    for count in (12, 20, 33, 50, 54, 60, 68, 111, 150, 260, 400):
        best: tuple[tuple[int, int], list[tuple[int, int, int]]] | None = None
        for steps in range(2, 60):
            for triples in staggered_lattices(space, steps):
                borders = edges = 0
                regions = set()
                for i, j, k in triples:
                    margins = [i - j, j - i - k, i - j - k]
                    sides = [i - k, j - k]
                    edge = [k, *sides] if space == "surrounded" else [k, steps - k]
                    border = margins if space == "surrounded" else [*margins, *sides]
                    borders += 0 in border
                    edges += 0 in edge
                    if 0 not in [*edge, *border]:
                        regions.add(tuple(margin > 0 for margin in (*margins, *sides)))
                cost = (abs(len(triples) - count) + borders, edges)
                complete = len(regions) == (4 if space == "surrounded" else 10)
                if complete and (best is None or cost < best[0]):
                    best = cost, triples
        assert best is not None
        expected = np.array(best[1]) * 3.0 / np.sum(best[1][0])
        designs = representative_designs(FIVE_BAR, space, count)
        np.testing.assert_allclose(np.unique(designs, axis=0), np.unique(expected, axis=0))
        if count >= 30:
            assert abs(len(designs) - count) <= 0.17 * count


@pytest.mark.parametrize("count", [11, 401, -5])
def test_a_number_of_cells_out_of_range_is_refused(count: int) -> None:
    with pytest.raises(InputError, match="expected an integer from 12 to 400"):
        representative_designs(FIVE_BAR, "surrounded", count)


@pytest.mark.parametrize(
    ("space", "mode", "count"),
    [
        ("surrounded", "+-/up", 60),
        ("surrounded", "++/down", 50),
        ("assemblable", "-+/up", 63),
        ("assemblable", "--/up", 40),
    ],
)
def test_shapes_have_the_integrated_areas_at_the_scale_of_the_bar(
    space: str, mode: str, count: int
) -> None:
    cells = shape_cells(FIVE_BAR, space, mode, count)
    figure = draw(cells, space)

    settings = SweepSettings("five-bar", space, 100, (mode,), (), 1e-6)
    designs = np.array([cell.parameters for cell in cells])
    areas = FIVE_BAR.evaluate(designs, settings)["usable_workspace_area"][:, 0]
    shapes = drawn_shapes(figure, cells)
    rng = np.random.default_rng(7)
    s1, s2 = (1 if sign == "+" else -1 for sign in mode[:2])
    for shape, area, design in zip(shapes, areas, designs, strict=True):
        if shape is None:
            assert area == 0.0
            continue
        # what lies between a chord and its arc is narrower than the deviation
        assert abs(shape.area - area) < DEVIATION * shape.length + 1e-5
        left, low, right, high = shape.bounds
        points = rng.uniform((left, low), (right, high), (400, 2))
        inside = shapely.contains_xy(shape.buffer(-0.01), points)
        det_b = naive.det_b(*design, *points[inside].T, s1, s2)
        assert (np.sign(det_b) == (1 if mode.endswith("up") else -1)).all()
    assert sum(shape is not None for shape in shapes) > 0.6 * len(cells)


def test_shapes_of_symmetric_modes_are_mirror_images() -> None:
    for space, mode in itertools.product(SPACES, ("+-/up", "-+/up")):
        cells = shape_cells(FIVE_BAR, space, mode, 40)
        for shape in drawn_shapes(draw(cells, space), cells):
            if shape is None:
                continue
            image = affinity.scale(shape, xfact=-1.0, origin=(0.0, 0.0))
            assert shapely.hausdorff_distance(image.boundary, shape.boundary) < 3.0 * DEVIATION

    cells = [shape_cells(FIVE_BAR, "surrounded", mode, 40) for mode in ("++/up", "--/down")]
    above, below = (drawn_shapes(draw(some), some) for some in cells)
    for one, two in zip(above, below, strict=True):
        assert (one is None) == (two is None)
        if one is None:
            continue
        image = affinity.scale(one, yfact=-1.0, origin=(0.0, 0.0))
        assert shapely.hausdorff_distance(image.boundary, two.boundary) < 3.0 * DEVIATION


@pytest.mark.parametrize("mode", [None, "+-", "++/up"])
def test_every_point_of_the_drawn_loci_is_singular(mode: str | None) -> None:
    cells = loci_cells(FIVE_BAR, "assemblable", mode, 40)
    figure = draw(cells, "assemblable")

    counts = dict.fromkeys((SERIAL, FOLDED, EXTENDED), 0)
    for number, cell in enumerate(cells):
        r1, r2, r3 = cell.parameters
        for kind in counts:
            lines = drawn_lines(figure, cells, number, kind)
            if not lines:
                continue
            x, y = np.concatenate(lines).T
            reaches = np.array([np.hypot(x + r3, y), np.hypot(x - r3, y)])
            assert reaches.max() < r1 + r2 + 1e-9
            assert reaches.min() > abs(r1 - r2) - 1e-9
            if kind == SERIAL:
                error = np.abs(reaches[..., None] - [r1 + r2, abs(r1 - r2)]).min(axis=(0, 2))
            elif kind == FOLDED:
                height = np.sqrt(r1**2 - r3**2)
                error = np.abs(np.hypot(x, np.abs(y) - height) - r2)
                error = np.minimum(error, np.abs(np.hypot(x, np.abs(y) + height) - r2))
            else:
                error = naive.coupler_error(r1, r2, r3, x, y)
            if mode is not None and kind != SERIAL:
                # NaN where rounding puts a point on a reach circle out of reach; at a base
                # joint the direction of the crank is free
                det_b = naive.det_b(r1, r2, r3, x, y, 1, 1 if mode[1] == "+" else -1)
                assert np.nanmax(np.abs(det_b[reaches.min(axis=0) > 1e-9])) < 1e-5
            assert error.max() < 1e-7, (cell.parameters, kind)
            counts[kind] += len(x)
    assert min(counts.values()) > 300


def test_loci_are_as_the_paper_says() -> None:
    """Liu, Wang and Zheng 2006, Sections 6 and 7.1."""
    cells = loci_cells(FIVE_BAR, "surrounded", None, 60)
    figure = draw(cells)
    of_one_mode = loci_cells(FIVE_BAR, "surrounded", "++", 60)
    other = draw(of_one_mode)

    seen = set()
    for number, cell in enumerate(cells):
        r1, r2, r3 = cell.parameters
        lines = [
            line
            for kind in (SERIAL, FOLDED, EXTENDED)
            for line in drawn_lines(figure, cells, number, kind)
        ]
        loci = shapely.MultiLineString(lines)
        for factors in ((-1.0, 1.0), (1.0, -1.0)):
            image = affinity.scale(loci, *factors, origin=(0.0, 0.0))
            assert shapely.hausdorff_distance(loci, image) < 3.0 * DEVIATION
        extended = bool(drawn_lines(figure, cells, number, EXTENDED))
        if r2 > r1 + r3 + 1e-9:
            assert not extended
            seen.add("IVa")
        elif r2 < r1 + r3 - 1e-9:
            assert extended
            seen.add("others")
        if r1 > r2 + r3 + 1e-9 and r3 > 0.0:
            assert not drawn_lines(other, of_one_mode, number, EXTENDED)
            seen.add("IVb")
    assert seen == {"IVa", "others", "IVb"}


@pytest.mark.parametrize(
    ("space", "mode", "count", "width"),
    [
        ("surrounded", None, 50, 170.0),
        ("surrounded", "++/up", 60, 85.0),
        ("assemblable", "+-", 60, 170.0),
        ("assemblable", "shapes", 15, 120.0),
        ("surrounded", "shapes", 150, 400.0),
    ],
)
def test_drawings_keep_apart_in_the_frame_and_could_not_be_larger(
    space: str, mode: str | None, count: int, width: float
) -> None:
    if mode == "shapes":
        cells = shape_cells(FIVE_BAR, space, "+-/down", count)
    else:
        cells = loci_cells(FIVE_BAR, space, mode, count)
    figure = draw(cells, space, width)

    drawings = hulls(figure, cells)
    places = FIVE_BAR.project(np.array([cell.parameters for cell in cells]), space)
    gaps = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    spacing = gaps[gaps > 0.0].min()
    apart = [one.distance(two) for one, two in itertools.combinations(drawings, 2)]
    assert 0.049 * spacing < min(apart) < 0.06 * spacing

    around = shapely.Polygon(artists(figure)["outline"].get_xy())  # type: ignore[attr-defined]
    (left, right), (low, high) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
    assert shapely.box(left, low, right, high).contains(around)
    edge = shapely.Polygon(FIVE_BAR.chart(space).outline)
    for drawing in [*drawings, edge]:
        assert around.contains(drawing)
    # nor is there more room around than the drawings need
    together = shapely.unary_union([*drawings, edge]).convex_hull
    assert around.exterior.distance(together) < 0.1 * spacing


@pytest.mark.parametrize("space", SPACES)
def test_ticks_stay_on_the_lines_on_which_their_parameter_is_constant(space: str) -> None:
    figure = draw(shape_cells(FIVE_BAR, space, "+-/up", 40), space)

    around = shapely.Polygon(artists(figure)["outline"].get_xy())  # type: ignore[attr-defined]
    segments = [
        segment
        for collection in figure.axes[0].collections
        for segment in collection.get_segments()  # type: ignore[attr-defined]
        if len(segment) == 2 and around.exterior.distance(shapely.Point(segment[0])) < 1e-9
    ]
    chart = FIVE_BAR.chart(space)
    expected = [(axis, tick) for axis in range(3) for tick in chart.axes[axis].ticks]
    assert len(segments) == len(expected)
    for axis, tick in expected:
        # r1, r2 and r3 at both ends of a tick, by inverting the projection
        values = [
            (lengths[0], 3.0 - lengths[0] - lengths[1], lengths[1])
            for segment in segments
            for lengths in [((np.sqrt(3.0) * x - y) / 2.0, y) for x, y in segment]
        ]
        ends = np.array(values).reshape(-1, 2, 3)[:, :, axis]
        assert (np.abs(ends - float(tick.label)).max(axis=1) < 1e-9).any()


@pytest.mark.parametrize("count", [15, 50, 60])
def test_names_of_sub_regions_are_in_them_and_cover_no_drawing(count: int) -> None:
    for cells in (
        loci_cells(FIVE_BAR, "surrounded", None, count),
        shape_cells(FIVE_BAR, "surrounded", "++/down", count),
    ):
        figure = draw(cells)
        figure.set_dpi(200)
        drawings = shapely.unary_union(hulls(figure, cells))
        chart = FIVE_BAR.chart("surrounded")
        lines = [shapely.LineString(border) for border in chart.borders]
        found = {}
        with style.styled():
            figure.draw_without_rendering()
            for text in texts(figure):
                if text.get_text() in {region.name for region in chart.regions}:
                    corners = text.get_window_extent().get_points()
                    box = figure.axes[0].transData.inverted().transform(corners).ravel()
                    found[text.get_text()] = shapely.box(*box)
        assert len(found) == 4
        for name, box in found.items():
            x, y = box.centroid.coords[0]
            r1 = (np.sqrt(3.0) * x - y) / 2.0
            r2 = 3.0 - r1 - y
            inside = {
                "IVa": r2 > r1 + y,
                "Va": r1 < r2 < r1 + y,
                "Vb": r2 < r1 < r2 + y,
                "IVb": r1 > r2 + y,
            }
            assert inside[name]
            assert not any(line.intersects(box) for line in lines)
            # the extent holds room for letters that reach lower
            assert drawings.intersection(box).area < 0.12 * box.area


@pytest.mark.parametrize("width", [60.0, 85.0, 170.0])
def test_no_text_covers_another_or_leaves_the_figure(width: float) -> None:
    resolution = 100
    for space, mode in itertools.product(SPACES, (None, "++/up")):
        figure = draw(loci_cells(FIVE_BAR, space, mode, 50), space, width)
        assert figure.get_figwidth() * 25.4 == pytest.approx(width)
        columns, rows = (figure.get_size_inches() * resolution).astype(int)
        figure.set_dpi(resolution)
        covered = np.zeros((rows, columns), dtype=bool)
        renderer = RendererAgg(columns, rows, resolution)
        for text in texts(figure):
            assert text.get_fontsize() >= 6.0
            renderer.clear()
            text.set_path_effects([])
            with style.styled():
                text.draw(renderer)
            ink = np.asarray(renderer.buffer_rgba())[:, :, 3] > 40
            assert ink.any(), text.get_text()
            edge = ink[0].any() or ink[-1].any() or ink[:, 0].any() or ink[:, -1].any()
            assert not edge, text.get_text()
            assert not (ink & covered).any(), text.get_text()
            covered |= ink


def test_empty_workspaces_are_crosses_and_the_key_says_so() -> None:
    cells = shape_cells(FIVE_BAR, "surrounded", "++/up", 50)
    figure = draw(cells)

    empty = [number for number, cell in enumerate(cells, start=1) if cell.parameters[2] == 0.0]
    assert len(empty) > 10
    found = artists(figure)
    for number in range(1, len(cells) + 1):
        is_cross = hasattr(found[f"cell-{number}"], "get_marker")
        assert is_cross == (number in empty)
    assert "usable workspace empty" in written(figure)
    assert "usable workspace empty" not in written(
        draw(shape_cells(FIVE_BAR, "surrounded", "+-/up", 50))
    )
    text = written(draw(loci_cells(FIVE_BAR, "surrounded", "++", 50)))
    assert "no locus bounds a workspace" in text
    assert "usable workspace empty" not in text


def test_base_joints_are_marked_where_the_inner_reach_circles_are_points() -> None:
    cells = loci_cells(FIVE_BAR, "surrounded", "+-", 50)
    figure = draw(cells)

    found = artists(figure)
    marked = 0
    for number, cell in enumerate(cells, start=1):
        r1, r2, r3 = cell.parameters
        assert (f"cell-{number}-isolated" in found) == (abs(r1 - r2) < 1e-12)
        if abs(r1 - r2) < 1e-12:
            points = found[f"cell-{number}-isolated"].get_xydata()  # type: ignore[attr-defined]
            own = (points - FIVE_BAR.project(cell.parameters, "surrounded")) / drawn_scale(figure)
            np.testing.assert_allclose(own, [[-r3, 0.0], [r3, 0.0]], atol=1e-12)
            marked += 1
    assert marked >= 2
    assert "isolated singular point" in written(figure)


def test_the_key_has_the_curves_that_occur_and_the_count_is_written() -> None:
    figure = draw(loci_cells(FIVE_BAR, "surrounded", None, 50))

    entries = [text for text in written(figure) if text.startswith(("serial", "parallel"))]
    assert [entry.partition(":")[0] for entry in entries] == [SERIAL, FOLDED, EXTENDED]
    assert [entry.count("$C_") for entry in entries] == [4, 2, 1]
    assert "length $D$ in every drawing; 51 designs" in written(figure)


@pytest.mark.parametrize(
    ("text", "label"), [("pm/UP", "+-/up"), ("pm", "+-"), ("--", "--"), ("-+/down", "-+/down")]
)
def test_modes_of_loci(text: str, label: str) -> None:
    assert locus_mode(FIVE_BAR, text) == label


@pytest.mark.parametrize("text", ["", "+", "up", "+-/left", "all"])
def test_other_modes_are_refused_with_those_there_are(text: str) -> None:
    with pytest.raises(UnknownNameError) as caught:
        locus_mode(FIVE_BAR, text)
    assert caught.value.known == [*FIVE_BAR.modes, "+-", "-+", "++", "--"]


@pytest.mark.parametrize(("kind", "mode"), [("loci-atlas", "-+"), ("shape-atlas", "++/down")])
def test_data_are_what_is_drawn(atlas: Command, tmp_path: Path, kind: str, mode: str) -> None:
    data = tmp_path / "data.csv"
    arguments = ("plot", kind, "--mode", mode, "--cells", 40, "-o", tmp_path / "figure.pdf")
    outcome = atlas(*arguments, "--data", data)

    assert outcome.code == 0, outcome
    make = loci_cells if kind == "loci-atlas" else shape_cells
    cells = make(FIVE_BAR, "surrounded", mode, 40)
    figure = draw(cells)
    with data.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    header = ["cell", "r1", "r2", "r3", "boundary", "arc", "curve", "kind", "x", "y"]
    assert list(rows[0]) == header
    by_cell = {int(key): list(some) for key, some in itertools.groupby(rows, lambda r: r["cell"])}
    assert list(by_cell) == list(range(1, len(cells) + 1))
    compared = 0
    for number, cell in enumerate(cells):
        of_cell = by_cell[number + 1]
        lengths = np.array([[float(row[name]) for name in ("r1", "r2", "r3")] for row in of_cell])
        assert (lengths == cell.parameters).all()
        if not cell.lines:
            (row,) = of_cell
            assert {row[name] for name in header[4:]} == {""}
            continue
        for curve_kind in (SERIAL, FOLDED, EXTENDED):
            of_kind = [row for row in of_cell if row["kind"] == curve_kind]
            stored = [
                np.array([[float(row["x"]), float(row["y"])] for row in some])
                for _, some in itertools.groupby(of_kind, lambda row: row["arc"])
            ]
            lines = drawn_lines(figure, cells, number, curve_kind)
            assert len(stored) == len(lines)
            for one, two in zip(stored, lines, strict=True):
                np.testing.assert_allclose(one, two, atol=1e-12)
                compared += 1
        loops = {row["boundary"] for row in of_cell}
        expected = {"outline", *(f"hole {place}" for place in range(1, len(cell.loops)))}
        assert loops == (expected if kind == "shape-atlas" else {""})
    assert compared > 100


@pytest.mark.parametrize("kind", ["loci-atlas", "shape-atlas"])
def test_commands_draw_the_same_bytes_every_time(atlas: Command, tmp_path: Path, kind: str) -> None:
    for ending in ("png", "pdf", "svg"):
        first, second = tmp_path / f"first.{ending}", tmp_path / f"second.{ending}"
        for output in (first, second):
            outcome = atlas("plot", kind, "--cells", 30, "-o", output)
            assert (outcome.code, outcome.out, outcome.err) == (0, "", "")
        assert first.read_bytes() == second.read_bytes()
    with Image.open(tmp_path / "first.png") as picture:
        assert picture.width == int(170 / 25.4 * 300)
        assert np.asarray(picture.convert("L"), float).std() > 15.0


def test_titles_name_the_modes_and_another_number_is_told(atlas: Command, tmp_path: Path) -> None:
    for number, (arguments, title) in enumerate(
        [
            (("loci-atlas",), "Singular loci, all modes"),
            (("loci-atlas", "--mode", "pm"), "Singular loci, mode +\N{MINUS SIGN}"),
            (("shape-atlas",), "Usable workspaces, mode +\N{MINUS SIGN}/up"),
            (("shape-atlas", "--mode", "mp/down"), "Usable workspaces, mode \N{MINUS SIGN}+/down"),
        ]
    ):
        output = tmp_path / f"{number}.svg"
        outcome = atlas("plot", *arguments, "--space", "assemblable", "--cells", 55, "-o", output)

        assert outcome.code == 0
        assert outcome.err.startswith("63 designs are drawn")
        # letters are outlines in an SVG file, but each text is there as a comment
        assert f"<!-- {title.replace(' mode ', ' mode ')} -->" in output.read_text("utf-8")


@pytest.mark.parametrize("kind", ["loci-atlas", "shape-atlas"])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--mode", "+-/left"), "mode: '+-/left' is not allowed; expected one of +-/up, "),
        (("--space", "round"), "space: 'round' is not allowed; expected one of surrounded"),
        (("--cells", 5), "cells: 5 is not allowed; expected an integer from 12 to 400"),
        (("--cells", "many"), "Invalid value for '--cells': 'many' is not a valid integer"),
        (("--width", 20), "width: 20.0 is not allowed; expected millimetres from 60 to 400"),
        (("--mechanism", "delta"), "mechanism: 'delta' is not allowed; expected one of five-bar"),
    ],
)
def test_wrong_input_is_told_and_nothing_written(
    refused: Refused, tmp_path: Path, kind: str, arguments: tuple[object, ...], message: str
) -> None:
    data = tmp_path / "data.csv"
    told = refused("plot", kind, *arguments, "-o", tmp_path / "figure.png", "--data", data)

    assert told.startswith(message)
    assert list(tmp_path.iterdir()) == []


def test_outputs_that_cannot_be_meant_are_refused(refused: Refused, tmp_path: Path) -> None:
    figure, data = tmp_path / "figure.svg", tmp_path / "data.csv"
    assert "ends in one of" in refused("plot", "loci-atlas", "-o", tmp_path / "figure.gif")
    told = refused("plot", "shape-atlas", "-o", figure, "--data", tmp_path / "." / "figure.svg")
    assert "another file than the figure" in told
    data.write_text("mine")
    told = refused("plot", "shape-atlas", "-o", figure, "--data", data)
    assert "exists already; --overwrite replaces it" in told
    assert data.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [data]


def test_a_mechanism_that_does_not_move_in_a_plane_is_refused(
    refused: Refused, toy: str, tmp_path: Path
) -> None:
    told = refused("plot", "loci-atlas", "--mechanism", toy, "-o", tmp_path / "figure.png")
    assert told.endswith("whose output point moves in a plane: five-bar, passive-leg")
    assert list(tmp_path.iterdir()) == []
