"""What the figures of one design show, against closed forms and the naive oracle.

Plotted data come first: the lines of a figure are read back from its axes. Text is drawn alone,
piece by piece, to see that none covers another, leaves the figure, or stands on a link.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
import naive
import numpy as np
import pytest
import shapely
from designs import random_design, random_reachable_point
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.text import Text
from matplotlib.textpath import TextPath

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.label_boxes import around, beside, beside_arc, beside_curve, best_box
from fivebar_atlas.figures.lci_figure import lci_figure
from fivebar_atlas.figures.linkage import draw_linkage, sample_pose
from fivebar_atlas.figures.linkage_figure import linkage_figure
from fivebar_atlas.figures.loci_figure import loci_figure
from fivebar_atlas.figures.overlays import Overlay
from fivebar_atlas.figures.plane_frame import plane_frame
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.saving import rendered
from fivebar_atlas.figures.text_placement import Box, points_along, text_ink
from fivebar_atlas.figures.workspace_figure import good_condition_figure, workspace_figure
from fivebar_atlas.mechanisms.planar import PlanarDesign

FIRST = "+-/up"
#: A mode pair without a workspace for designs with r3 = 0.
EMPTY = "++/up"
SIGNS = {
    f"{one}{two}": (1 if one == "+" else -1, 1 if two == "+" else -1)
    for one, two in itertools.product("+-", repeat=2)
}


@pytest.fixture(autouse=True)
def _settings_of_matplotlib_stay() -> Iterator[None]:
    before = dict(mpl.rcParams)
    yield
    assert dict(mpl.rcParams) == before


def design_of(*lengths: float, unit: str | None = None) -> PlanarDesign:
    return mechanisms.get("five-bar").planar_design(lengths, unit)


def artists(figure: Figure, start: str) -> list[Artist]:
    """Return what is drawn under a name that starts so, in all panels."""
    return [
        each
        for axes in figure.axes
        for each in axes.get_children()
        if (each.get_gid() or "").startswith(start)
    ]


def lines(figure: Figure, start: str) -> list[np.ndarray]:
    """Return the points of lines, shape (n, 2) each."""
    return [each.get_xydata() for each in artists(figure, start) if isinstance(each, Line2D)]


def filled(figure: Figure, name: str) -> shapely.Geometry:
    """Return a filled region as shapely sees it, holes left out."""
    (patch,) = [each for each in artists(figure, name) if each.get_gid() == name]
    assert isinstance(patch, PathPatch)
    rings = patch.get_path().to_polygons(closed_only=True)
    inside: shapely.Geometry = shapely.Polygon()
    for ring in rings:
        inside = inside.symmetric_difference(shapely.Polygon(ring))
    return inside


def texts(figure: Figure) -> list[Text]:
    return [each for each in figure.findobj(Text) if each.get_visible() and each.get_text()]


def written(figure: Figure) -> str:
    """Return everything that is written, line by line, with ordinary spaces."""
    return "\n".join(each.get_text() for each in texts(figure)).replace("\N{NO-BREAK SPACE}", " ")


def panels(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if not axes.get_label()]


# --- the frame


@pytest.mark.parametrize("width", [60.0, 85.0, 180.0])
@pytest.mark.parametrize("extent", [(1.0, 1.0), (1.0, 9.0), (30.0, 1.0), (2e4, 3e4), (2e-5, 1e-5)])
def test_both_axes_have_one_scale_and_everything_is_in_the_panel(
    width: float, extent: tuple[float, float]
) -> None:
    lower, upper = np.array([-0.2, 0.5]) * extent, np.array([0.8, 1.5]) * extent
    with style.styled():
        frame = plane_frame((lower, upper), "mm", "Title", width, 5.0)
    axes, figure = frame.axes, frame.figure
    box = axes.get_position()
    size = figure.get_size_inches() * style.MM_PER_INCH
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()

    assert box.width * size[0] / (right - left) == pytest.approx(frame.scale, rel=1e-9)
    assert box.height * size[1] / (high - low) == pytest.approx(frame.scale, rel=1e-9)
    assert size[0] == pytest.approx(width)
    assert 0.39 <= box.height * size[1] / (box.width * size[0]) <= 1.31
    assert (left, low) < tuple(lower)
    assert left < lower[0] < upper[0] < right
    assert low < lower[1] < upper[1] < high
    assert 2 <= len(axes.get_xticks()) <= 25
    steps = [*np.diff(axes.get_xticks()), *np.diff(axes.get_yticks())]
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)


@pytest.mark.parametrize("width", [0.0, 59.9, 401.0, math.nan, math.inf])
def test_a_width_that_no_page_has_is_refused(width: float) -> None:
    with pytest.raises(InputError, match="millimetres from 60 to 400"):
        loci_figure(design_of(1.2, 1.0, 0.8), width=width)


@pytest.mark.parametrize(
    ("lengths", "unit", "label", "title"),
    [
        ((1.2, 1.0, 0.8), None, "$x$ (in units of $D$)", "$r_1$ = 1.2, $r_2$ = 1, $r_3$ = 0.8"),
        ((26, 30, 16), None, "$x$ (mm)", "$R_1$ = 26 mm, $R_2$ = 30 mm, $R_3$ = 16 mm"),
        ((26, 30, 16), "", "$x$ (in units of $D$)", "$r_2$ = 1.25"),
        ((2.6, 3, 1.6), "in", "$x$ (in)", "$R_1$ = 2.6 in"),
        ((2.6, 3, 1.6), "$", r"$x$ (\$)", r"$R_1$ = 2.6 \$"),
    ],
)
def test_title_and_axes_tell_lengths_and_unit(
    lengths: tuple[float, float, float], unit: str | None, label: str, title: str
) -> None:
    text = written(loci_figure(design_of(*lengths, unit=unit), "+-"))
    assert label in text.splitlines()
    assert label.replace("$x$", "$y$") in text.splitlines()
    assert title in text.replace(",\n", ", ")
    assert "mode +\N{MINUS SIGN}" in text


# --- the linkage


def test_drawn_links_have_the_lengths_of_the_design_and_elbows_of_the_oracle() -> None:
    rng = np.random.default_rng(7)
    for _ in range(5):
        r1, r2, r3 = random_design(rng)
        x, y = random_reachable_point(rng, r1, r2, r3)
        factor = rng.uniform(0.1, 50.0)
        design = design_of(factor * r1, factor * r2, factor * r3, unit="mm")

        figure = linkage_figure(design, design.inverse_poses(factor * x, factor * y))

        drawn = [np.hypot(*np.diff(line, axis=0)[0]) for line in lines(figure, "link-")]
        expected = factor * np.array([2 * r3, r1, r1, r2, r2])
        np.testing.assert_allclose(drawn, np.tile(expected, 4), rtol=1e-9)
        assert len(panels(figure)) == 4
        for axes in panels(figure):
            markers = {each.get_gid(): each.get_xydata()[0] for each in axes.lines}
            np.testing.assert_allclose(markers["joint-5"], [factor * x, factor * y], rtol=1e-12)
            elbows = np.array([markers["joint-3"], markers["joint-4"]])
            modes = [naive.elbows(r1, r2, r3, x, y, *signs) for signs in SIGNS.values()]
            gaps = [np.abs(elbows / factor - np.array(pair)).max() for pair in modes]
            assert min(gaps) < 1e-7


def test_all_inverse_solutions_are_told_with_mode_angles_and_lci() -> None:
    r1, r2, r3 = lengths = (26.0, 30.0, 16.0)
    x, y = 5.0, 38.0
    design = design_of(*lengths)

    text = written(linkage_figure(design, design.inverse_poses(x, y)))

    assert "$P$ = (5, 38) mm" in text
    for working, signs in SIGNS.items():
        lci = float(naive.lci(r1, r2, r3, x, y, *signs))
        up = naive.det_b(r1, r2, r3, x, y, *signs) > 0.0
        mode = f"{working}/{'up' if up else 'down'}".replace("-", "\N{MINUS SIGN}")
        assert f"mode {mode}, LCI = {lci:.4f}" in text
        angles = [
            math.degrees(float(a)) for a in naive.inverse_kinematics(r1, r2, r3, x, y, *signs)
        ]
        wrapped = [math.remainder(angle, 360.0) for angle in angles]
        one, two = (f"{round(angle, 2):.6g}".replace("-", "\N{MINUS SIGN}") for angle in wrapped)
        assert rf"$\theta_{{1}}$ = {one}°, $\theta_{{2}}$ = {two}°" in text


def test_both_forward_solutions_are_drawn_from_the_same_cranks() -> None:
    r1, r2, r3 = lengths = (26.0, 30.0, 16.0)
    angles = np.radians([110.0, 50.0])
    design = design_of(*lengths)

    figure = linkage_figure(design, design.forward_poses(angles))

    outputs = np.array(lines(figure, "joint-5"))[:, 0]
    expected = [
        np.array(naive.forward_kinematics(r1, r2, r3, *angles, assembly)) for assembly in (1, -1)
    ]
    np.testing.assert_allclose(outputs, expected, rtol=1e-9)
    cranks = lines(figure, "link-2")
    np.testing.assert_array_equal(cranks[0], cranks[1])
    assert "mode +\N{MINUS SIGN}/up" in written(figure)
    assert r"$\theta_{1}$ = 110°, $\theta_{2}$ = 50°" in written(figure)


def test_angle_arcs_run_from_the_direction_of_x_to_the_cranks() -> None:
    design = design_of(26, 30, 16)
    pose = design.pose(10.0, -5.0, "-+")
    figure = linkage_figure(design, [pose])
    for number, base in ((1, -16.0), (2, 16.0)):
        (arc,) = lines(figure, f"angle-{number}")
        turns = np.arctan2(arc[:, 1], arc[:, 0] - base)
        np.testing.assert_allclose(turns[0], 0.0, atol=1e-12)
        np.testing.assert_allclose(turns[-1], pose.inputs[number - 1], rtol=1e-9)
        assert np.ptp(np.hypot(arc[:, 1], arc[:, 0] - base)) < 1e-9


def test_every_part_of_the_linkage_is_named() -> None:
    design = design_of(26, 30, 16)
    figure = linkage_figure(design, [design.pose(5.0, 38.0, FIRST)])
    symbols = [
        each.get_text() for each in texts(figure) if each.get_fontsize() == style.REGION_SIZE
    ]
    expected = ["$A_1$", "$A_2$", "$B_1$", "$B_2$", "$P$", "$O$", "$R_3$"]
    expected += ["$R_1$", "$R_2$"] * 2 + [r"$\theta_{1}$", r"$\theta_{2}$"]
    assert sorted(symbols) == sorted([*expected, *(s for s in symbols if "mm" in s)])


def test_joints_at_one_place_share_a_label() -> None:
    design = design_of(1.28, 1.72, 0.0)
    figure = linkage_figure(design, [design.pose(0.0, 1.72, FIRST)])
    assert "$A_1$, $A_2$" in written(figure)
    assert "$r_3$" not in [each.get_text() for each in texts(figure)]


def test_a_linkage_moves_with_its_artists() -> None:
    design = design_of(26, 30, 16)
    first, second = design.pose(5.0, 38.0, FIRST), design.pose(-8.0, 30.0, FIRST)
    with style.styled():
        frame = plane_frame((np.full(2, -60.0), np.full(2, 60.0)), "mm", "", 85.0, 0.0)
        drawn = draw_linkage(frame, first)
    drawn.move(second)
    for link, line in zip(second.links, drawn.links, strict=True):
        ends = [second.joints[link.start].position, second.joints[link.end].position]
        np.testing.assert_array_equal(line.get_xydata(), ends)
    for joint, line in zip(second.joints, drawn.joints, strict=True):
        np.testing.assert_array_equal(line.get_xydata(), [joint.position])


@pytest.mark.parametrize("lengths", [(1.2, 1.0, 0.8), (1.28, 1.72, 0.0), (0.2, 2.0, 0.8)])
def test_the_sample_pose_is_inside_the_workspace_in_its_mode(
    lengths: tuple[float, float, float],
) -> None:
    design = design_of(*lengths)
    modes = 0
    for mode in mechanisms.get("five-bar").modes:
        workspace = design.usable_workspace(mode)
        if workspace is None:
            continue
        modes += 1
        pose = sample_pose(design, workspace.region, mode)
        assert pose.mode == mode
        outline, *holes = workspace.region.polygons(1e-4)
        shape = shapely.Polygon(outline, holes)
        point = shapely.Point(pose.output)
        assert shape.contains(point)
        assert point.distance(shape.boundary) > 0.02
    assert modes >= 2


# --- loci


def locus_errors(lengths: tuple[float, float, float], name: str, points: np.ndarray) -> np.ndarray:
    """Return how far points are from the condition of a locus, by its defining equation."""
    r1, r2, r3 = lengths
    x, y = points.T
    if name.startswith("C_coin"):
        height = math.sqrt(r1**2 - r3**2) * (1 if name.endswith("up") else -1)
        return np.hypot(x, y - height) - r2
    if name == "C_col":
        return naive.coupler_error(r1, r2, r3, x, y)
    base = -r3 if name[2] == "1" else r3
    radius = r1 + r2 if name.endswith("o") else abs(r1 - r2)
    return np.hypot(x - base, y) - radius


@pytest.mark.parametrize("mode", [None, "+-", "--/down"])
@pytest.mark.parametrize(
    "lengths", [(1.2, 1.0, 0.8), (1.3, 1.6, 0.1), (1.08, 1.25, 0.67), (1.6, 0.9, 0.5)]
)
def test_all_drawn_loci_satisfy_their_condition_and_are_named(
    lengths: tuple[float, float, float], mode: str | None
) -> None:
    data = PlottedData()
    figure = loci_figure(design_of(*lengths), mode, data=data)

    loci = [part for part in data.parts if part.element == "locus"]
    for part in loci:
        assert np.abs(locus_errors(lengths, part.curve, part.points)).max() < 1e-7
        assert any(np.array_equal(part.points, line) for line in lines(figure, part.curve))
    drawn = [line for name in {part.curve for part in loci} for line in lines(figure, f"{name}-")]
    assert len(drawn) == len(loci)
    symbols = {each.symbol: each for each in design_of(*lengths).singular_loci(mode)}
    key = [line for line in written(figure).splitlines() if ": $C" in line]
    for symbol, arc in symbols.items():
        beside_it = [each for each in texts(figure) if each.get_text() == symbol]
        assert len(beside_it) == 1
        assert beside_it[0].get_color() == style.curve_look(arc.kind)["color"]
        assert any(line.startswith(f"{arc.kind}: ") and symbol in line for line in key)


def test_tangency_points_and_intersections_are_marked() -> None:
    r1, r2, r3 = lengths = (1.2, 1.0, 0.8)
    figure = loci_figure(design_of(*lengths))

    (crossings,) = lines(figure, "intersection")
    top = math.sqrt((r1 + r2) ** 2 - r3**2)
    np.testing.assert_allclose(sorted(crossings.tolist()), [[0.0, -top], [0.0, top]], atol=1e-12)
    (tangencies,) = lines(figure, "tangency")
    # P on the line from A_i through F = (0, h), beyond F and before it, at r2
    height = math.sqrt(r1**2 - r3**2)
    folds = [
        (base * -side * r2 / r1, up * height * (1.0 + side * r2 / r1))
        for base in (-r3, r3)
        for up in (1, -1)
        for side in (1, -1)
    ]
    for fold in folds:
        assert np.hypot(*(tangencies - fold).T).min() < 1e-9
    assert "tangency" in written(figure)
    assert "intersection" in written(figure)


def test_a_mode_shows_the_arcs_that_belong_to_it_and_no_others() -> None:
    lengths = (1.2, 1.0, 0.8)
    design = design_of(*lengths)
    shown = {mode: PlottedData() for mode in SIGNS}
    for mode, data in shown.items():
        loci_figure(design, mode, data=data)
        middles = [
            (part.curve, part.points[len(part.points) // 2])
            for part in data.parts
            if part.kind.startswith("parallel")
        ]
        assert middles
        for _, (x, y) in middles:
            assert abs(naive.det_b(*lengths, x, y, *SIGNS[mode])) < 1e-7
    # a working mode shows a part of what all show
    everything = PlottedData()
    loci_figure(design, data=everything)
    length = {
        key: sum(
            np.hypot(*np.diff(part.points, axis=0).T).sum()
            for part in data.parts
            if part.kind.startswith("parallel")
        )
        for key, data in {**shown, "all": everything}.items()
    }
    assert sum(length[mode] for mode in SIGNS) == pytest.approx(length["all"], rel=1e-3)


def test_change_points_and_isolated_points_are_told() -> None:
    assert "change-point manipulator (a, b)" in written(loci_figure(design_of(1, 1, 1)))
    figure = loci_figure(design_of(1.3, 1.3, 0.4))
    (points,) = lines(figure, "isolated singular point")
    np.testing.assert_allclose(sorted(points[:, 0]), [-0.4, 0.4])
    assert "isolated singular point" in written(figure)


def test_a_mode_that_is_singular_throughout_has_no_loci_and_says_so() -> None:
    text = written(loci_figure(design_of(1.28, 1.72, 0.0), "++"))
    assert "no arcs of singular loci in mode ++" in text
    assert "singular throughout in ++" in text


def test_unknown_modes_and_linkages_that_cannot_move_are_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"\+-, -\+, \+\+, --"):
        loci_figure(design_of(1.2, 1.0, 0.8), "+")
    with pytest.raises(InputError, match="can move"):
        loci_figure(design_of(0.75, 0.75, 1.5))


# --- workspaces


@pytest.mark.parametrize(
    ("lengths", "area"),
    [((1.3, 1.6, 0.1), 24.858663), ((1.28, 1.72, 0.0), math.pi * (3.0**2 - 0.44**2))],
)
def test_the_shaded_workspace_has_the_area_that_is_written(
    lengths: tuple[float, float, float], area: float
) -> None:
    figure = workspace_figure(design_of(*lengths), FIRST)
    assert filled(figure, "usable-workspace").area == pytest.approx(area, rel=2e-4)
    assert f"area {area:.5g} $D^2$" in written(figure)


def test_boundary_arcs_have_the_look_of_their_kind_and_close_around_the_shaded_region() -> None:
    lengths = (1.2, 1.0, 0.8)
    data = PlottedData()
    figure = workspace_figure(design_of(*lengths), FIRST, data=data)
    arcs = [part for part in data.parts if part.element == "boundary of the usable workspace"]

    names = [part.curve for part in arcs]
    assert sorted(set(names)) == [
        "C_1i", "C_1o", "C_2i", "C_2o", "C_coin_down", "C_coin_up", "C_col",
    ]  # fmt: skip
    for part in arcs:
        assert np.abs(locus_errors(lengths, part.curve, part.points)).max() < 1e-7
        drawn = [
            each
            for each in artists(figure, f"{part.curve}-")
            if np.array_equal(each.get_xydata(), part.points)  # type: ignore[attr-defined]
        ]
        look = style.curve_look(part.kind)
        assert [each.get_color() for each in drawn] == [look["color"]]  # type: ignore[attr-defined]
    rings = shapely.polygonize([shapely.LineString(part.points) for part in arcs])
    outer = max(rings.geoms, key=lambda ring: ring.area)
    assert shapely.symmetric_difference(outer, filled(figure, "usable-workspace")).area < 1e-9
    styles = {part.kind: str(style.curve_look(part.kind)["linestyle"]) for part in arcs}
    assert len(set(styles.values())) == len(styles) == 3
    key = written(figure)
    assert "serial: $C_{1i}$, $C_{1o}$, $C_{2i}$, $C_{2o}$" in key
    assert r"parallel, extended: $C_{\mathrm{col}}$" in key


def test_inscribed_circles_touch_the_boundary_and_their_radii_are_told() -> None:
    design = design_of(26, 30, 16)
    figure = workspace_figure(design, FIRST)
    region = filled(figure, "usable-workspace")
    circles = lines(figure, "inscribed-circle-")
    rings = [line for line in circles if len(line) > 1]
    centres = [line[0] for line in circles if len(line) == 1]
    assert len(rings) == len(centres) == 2
    for ring, centre in zip(rings, centres, strict=True):
        radius = shapely.Point(centre).distance(region.boundary)
        np.testing.assert_allclose(np.hypot(*(ring - centre).T), radius, rtol=1e-3)
        told = re.findall(r"radius ([\d.]+) mm", written(figure))
        assert min(abs(float(number) - radius) for number in told) < 1e-3 * radius


def test_lengths_scale_with_the_unit() -> None:
    small, large = PlottedData(), PlottedData()
    workspace_figure(design_of(26, 30, 16, unit=""), FIRST, data=small)
    workspace_figure(design_of(26, 30, 16), FIRST, data=large)
    for one, two in zip(small.parts, large.parts, strict=True):
        assert one.element == two.element
        # symbols of dimensional lengths are capital letters
        assert one.curve.upper() == two.curve.upper()
        np.testing.assert_allclose(24.0 * one.points, two.points, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "draw",
    [
        workspace_figure,
        lambda design, mode, **more: good_condition_figure(design, mode, 0.5, **more),
        lci_figure,
    ],
)
def test_an_empty_workspace_is_said_to_be_empty_and_the_loci_are_drawn(
    draw: Callable[..., Figure],
) -> None:
    data = PlottedData()
    figure = draw(design_of(1.28, 1.72, 0.0), EMPTY, data=data)
    assert "empty usable workspace in mode ++/up" in written(figure)
    assert {part.element for part in data.parts} == {"locus"}
    assert {part.curve for part in data.parts} == {"C_1o", "C_1i", "C_2o", "C_2i"}
    assert not artists(figure, "usable-workspace")


# --- practical workspaces in figures


@pytest.mark.parametrize(
    "draw", [workspace_figure, lambda design, mode, **more: lci_figure(design, mode, 0.5, **more)]
)
def test_overlays_are_drawn_where_they_lie_and_named(draw: Callable[..., Figure]) -> None:
    outline = np.array([[-1.0, 44.0], [1.0, 44.0], [1.0, 46.0], [-1.0, 46.0]])
    overlays = [
        Overlay("a square", outline, ((1.0, 46.0),), "where it touches"),
        Overlay("more", 2.0 * outline - [0.0, 45.0], dashed=True),
    ]
    data = PlottedData()
    figure = draw(design_of(26.0, 30.0, 16.0), FIRST, overlays=overlays, data=data)
    for number, overlay in enumerate(overlays, start=1):
        (line,) = artists(figure, f"overlay-{number}")
        assert isinstance(line, Line2D)
        np.testing.assert_array_equal(line.get_xydata(), [*overlay.outline, overlay.outline[0]])
        assert line.is_dashed() == overlay.dashed
    (mark,) = artists(figure, "overlay-points-1")
    assert isinstance(mark, Line2D)
    np.testing.assert_array_equal(mark.get_xydata(), [(1.0, 46.0)])
    for text in ("a square", "where it touches", "more"):
        assert text in written(figure)
    recorded = {part.element: part.points for part in data.parts}
    np.testing.assert_array_equal(recorded["a square"][:-1], outline)
    np.testing.assert_array_equal(recorded["where it touches"], [(1.0, 46.0)])


def test_a_figure_is_wide_enough_for_what_is_drawn_into_it() -> None:
    far = Overlay("far away", np.array([[90.0, 0.0], [100.0, 0.0], [95.0, 5.0]]))
    for draw in (workspace_figure, lci_figure):
        figure = draw(design_of(26.0, 30.0, 16.0), FIRST, overlays=[far])
        assert figure.axes[0].get_xlim()[1] > 100.0


# --- conditioning


def test_the_good_condition_workspace_of_the_paper_lies_between_two_circles() -> None:
    """Liu, Wang and Zheng 2006, Sec. 9.2: radii 0.5154 and 2.5614, area 19.78."""
    r1, r2 = 1.28, 1.72
    figure = good_condition_figure(design_of(r1, r2, 0.0), FIRST, 0.5)

    outer, inner = lines(figure, "LCI = 0.5-")
    middle, half = 2.0 * r2 / math.sqrt(5.0), math.sqrt(r1**2 - r2**2 / 5.0)
    np.testing.assert_allclose(np.hypot(*outer.T), middle + half, rtol=1e-12)
    np.testing.assert_allclose(np.hypot(*inner.T), middle - half, rtol=1e-12)
    assert [middle - half, middle + half] == pytest.approx([0.5154, 2.5614], abs=1.5e-4)
    area = math.pi * ((middle + half) ** 2 - (middle - half) ** 2)
    assert filled(figure, "good-condition-1").area == pytest.approx(area, rel=1e-4)
    assert "LCI \N{GREATER-THAN OR EQUAL TO} 0.5, area 19.779 $D^2$" in written(figure)


def test_the_boundary_of_a_good_condition_workspace_has_the_threshold_as_its_lci() -> None:
    lengths = (26.0, 30.0, 16.0)
    figure = good_condition_figure(design_of(*lengths), FIRST, 0.45)
    found = lines(figure, "LCI = 0.45-")
    assert found
    for line in found:
        np.testing.assert_allclose(naive.lci(*lengths, *line.T, 1, -1), 0.45, rtol=1e-9)


def test_a_threshold_that_nothing_reaches_is_told_with_the_largest_lci() -> None:
    lengths = (0.76, 1.98, 0.26)
    x, y = naive.grid(*lengths, 801)
    mask = naive.usable_workspace_mask(*lengths, 1, -1, 1, 801)
    points = [axis[mask] for axis in np.meshgrid(x, y)]
    largest = np.nanmax(naive.lci(*lengths, *points, 1, -1))
    for figure in (
        good_condition_figure(design_of(*lengths), FIRST, 0.7),
        lci_figure(design_of(*lengths), FIRST, 0.7),
    ):
        text = written(figure)
        start = "no point has LCI \N{GREATER-THAN OR EQUAL TO} 0.7; the largest LCI is "
        told = float(text.partition(start)[2].split()[0])
        assert told == pytest.approx(largest, rel=1e-2)
        assert told >= largest - 1e-6
        assert not artists(figure, "good-condition")
        assert not artists(figure, "band")


@pytest.mark.parametrize("lengths", [(5.76, 7.74, 0.0), (26.0, 30.0, 16.0)])
def test_contours_of_the_map_lie_where_the_lci_has_their_level(
    lengths: tuple[float, float, float],
) -> None:
    data = PlottedData()
    figure = lci_figure(design_of(*lengths), FIRST, data=data)

    contours = [part for part in data.parts if part.element == "contour"]
    assert sorted({float(part.values[0]) for part in contours}) == pytest.approx(
        np.arange(1, 10) / 10.0
    )
    for part in contours:
        level = part.values[0]
        lci = naive.lci(*lengths, *part.points.T, 1, -1)
        np.testing.assert_allclose(lci, level, rtol=1e-9)
        np.testing.assert_array_equal(part.points[0], part.points[-1])
        assert any(np.array_equal(part.points, line) for line in lines(figure, "contour-"))
    (samples,) = [part for part in data.parts if part.element == "sample"]
    lci = naive.lci(*lengths, *samples.points.T, 1, -1)
    np.testing.assert_allclose(samples.values, lci, rtol=1e-9)
    assert len(samples.points) > 40_000


def test_bands_of_the_map_have_the_areas_of_rings_at_r3_0() -> None:
    """At r3 = 0 LCI = min(tan ψ, cot ψ), cos ψ = (ρ² + r2² - r1²)/(2 ρ r2)."""
    r1, r2 = 1.28, 1.72
    figure = lci_figure(design_of(r1, r2, 0.0), FIRST)
    for number, level in enumerate(np.arange(10) / 10.0, start=1):
        # the outer and the inner radius for tan ψ = level, then the hole for cot ψ = level
        area = 0.0
        for sign, psi in ((1, math.atan(level)), (-1, math.pi / 2 - math.atan(level))):
            root = r1**2 - (r2 * math.sin(psi)) ** 2
            if root > 0.0:
                both = [r2 * math.cos(psi) + side * math.sqrt(root) for side in (1, -1)]
                area += sign * math.pi * (both[0] ** 2 - both[1] ** 2)
        assert filled(figure, f"band-{number}").area == pytest.approx(area, rel=1e-3)


def test_a_map_above_a_threshold_begins_with_it() -> None:
    figure = lci_figure(design_of(26, 30, 16), FIRST, 0.55, [0.6, 0.85])
    (bar,) = [axes for axes in figure.axes if axes.get_label() == "colour bar"]
    assert [label.get_text() for label in bar.get_xticklabels()] == ["0.55", "0.60", "0.85", "1.00"]
    assert {each.get_gid().split("-")[1] for each in artists(figure, "contour-")} == {
        "0.55", "0.60", "0.85",
    }  # fmt: skip
    title = "LCI \N{GREATER-THAN OR EQUAL TO} 0.55"
    assert title in written(figure)
    bands = [filled(figure, f"band-{number}") for number in (1, 2, 3)]
    assert bands[0].area > bands[1].area > bands[2].area > 0.0
    assert bands[0].contains(bands[1])


@pytest.mark.parametrize(
    ("threshold", "levels", "message"),
    [
        (1.0, None, "above 0 and below 1"),
        (0.0, None, "above 0 and below 1"),
        (math.nan, None, "above 0 and below 1"),
        (None, [0.5, 1.0], "above 0 and below 1"),
        (0.5, [0.5], "above 0.5 and below 1"),
        (None, [math.nan], "above 0 and below 1"),
    ],
)
def test_thresholds_and_levels_out_of_range_are_refused(
    threshold: float | None, levels: Sequence[float] | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        lci_figure(design_of(1.2, 1.0, 0.8), FIRST, threshold, levels)


# --- text


def varied_figures(
    width: float, designs: Sequence[tuple[float, float, float]]
) -> Iterator[tuple[str, Figure]]:
    """Every kind of figure."""
    for lengths in designs:
        design = design_of(*lengths)
        for mode in (None, "--/down"):
            yield f"loci {lengths} {mode}", loci_figure(design, mode, width=width)
        for mode in (FIRST, "++/down"):
            yield f"workspace {lengths} {mode}", workspace_figure(design, mode, width=width)
        yield f"good-condition {lengths}", good_condition_figure(design, FIRST, 0.5, width=width)
        yield f"lci {lengths}", lci_figure(design, FIRST, 0.4, width=width)
        workspace = design.usable_workspace(FIRST)
        assert workspace is not None
        pose = sample_pose(design, workspace.region, FIRST)
        yield f"linkage {lengths}", linkage_figure(design, [pose], width=width)
        every = design.inverse_poses(*pose.output)
        yield f"all {lengths}", linkage_figure(design, every, width=width)


def ink_of(drawn: Sequence[Artist], figure: Figure, resolution: int = 80) -> np.ndarray:
    """Return which pixels some artists cover that are drawn alone."""
    columns, rows = (figure.get_size_inches() * resolution).astype(int)
    figure.set_dpi(resolution)
    renderer = RendererAgg(columns, rows, resolution)
    with style.styled():
        for each in drawn:
            each.set_path_effects([])
            each.draw(renderer)
    return np.asarray(renderer.buffer_rgba())[:, :, 3] > 40


FEW_CURVES, MANY_CURVES = (1.28, 1.72, 0.0), (1.2, 1.0, 0.8)
CROWDED, DIMENSIONAL = (1.3, 1.6, 0.1), (26.0, 30.0, 16.0)


@pytest.mark.parametrize(
    ("width", "designs"),
    [
        (60.0, [MANY_CURVES]),
        (85.0, [FEW_CURVES, MANY_CURVES, CROWDED, DIMENSIONAL]),
        (170.0, [DIMENSIONAL]),
    ],
)
def test_no_text_covers_another_or_a_line_leaves_the_figure_or_is_too_small(
    width: float, designs: Sequence[tuple[float, float, float]]
) -> None:
    for name, figure in varied_figures(width, designs):
        assert figure.get_figwidth() * 25.4 == pytest.approx(width)
        below = [each for start in ("link-", "joint-", "C_") for each in artists(figure, start)]
        if name.startswith(("lci", "all")):
            below = []  # levels stand on their lines, and joints are named in any case
        covered = ink_of(below, figure)
        for text in texts(figure):
            assert text.get_fontsize() >= 6.0, (name, text.get_text())
            ink = ink_of([text], figure)
            assert ink.any(), (name, text.get_text())
            edge = ink[0].any() or ink[-1].any() or ink[:, 0].any() or ink[:, -1].any()
            assert not edge, (name, text.get_text())
            assert not (ink & covered).any(), (name, text.get_text())
            covered |= ink


def test_sizes_of_text_are_those_of_its_outlines() -> None:
    samples = ["0.55", "Usable workspace, $r_1$ = 1.2", r"$C_{\mathrm{coin},U}$", "gQ8&%@éß−"]
    for text in samples:
        with style.styled():
            box = TextPath((0, 0), text, size=100.0, prop=FontProperties()).get_extents()
        scale = 7.0 / 100.0 / style.POINTS_PER_MM
        expected = np.array([box.x0, box.y0, box.x1, box.y1]) * scale
        np.testing.assert_allclose(text_ink(text, 7.0), expected, atol=1e-12)


def test_labels_take_the_free_place_and_may_be_left_out() -> None:
    outline = np.array([[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]])
    nothing = np.empty((0, 2))
    place = np.zeros(2)
    wall = points_along(np.array([[0.8, -20.0], [0.8, 20.0]]), 0.4)
    floor = points_along(np.array([[-20.0, -0.8], [20.0, -0.8]]), 0.4)
    lines_there = np.concatenate([wall, floor])

    box = best_box(around(place, 0.5, 9.0, 3.0, 2.0), outline, lines_there, nothing, [])
    assert box is not None
    assert box.x < 0.0 < box.y
    taken = [Box(-5.0, 5.0, 8.0, 8.0)]
    second = best_box(around(place, 0.5, 9.0, 3.0, 2.0), outline, lines_there, nothing, taken)
    assert second is not None
    assert box.overlaps(taken[0])
    full = points_along(np.array([[-15.0, 0.0], [15.0, 0.0]]), 0.1)
    crowd = np.concatenate([full + np.array([0.0, shift]) for shift in np.arange(-15.0, 15.0, 0.5)])
    assert (
        best_box(around(place, 0.5, 9.0, 3.0, 2.0), outline, crowd, nothing, [], must=False) is None
    )
    assert best_box(around(place, 0.5, 9.0, 3.0, 2.0), outline, crowd, nothing, []) is not None
    tiny = 0.1 * outline
    assert best_box(around(place, 0.5, 9.0, 3.0, 2.0), tiny, nothing, nothing, []) is None


def test_places_keep_their_distance() -> None:
    line = np.array([[0.0, 0.0], [30.0, 10.0]])
    segment = shapely.LineString(line)
    for places in (beside(line, 0.5, 3.0, 2.0), beside_curve(line, np.empty((0, 2)), 3.0, 2.0)):
        for box, _ in places:
            assert shapely.Polygon(box.corners()).distance(segment) > 0.0
    centre = np.array([3.0, 4.0])
    for box, _ in around(centre, 0.5, 9.0, 3.0, 2.0):
        assert shapely.Polygon(box.corners()).distance(shapely.Point(centre)) >= 0.7
    circle = shapely.Point(centre).buffer(5.0, quad_segs=256).boundary
    outside = [box for box, _ in beside_arc(centre, 5.0, 0.3, 1.0, 1.0)]
    gaps = [shapely.Polygon(box.corners()).distance(circle) for box in outside]
    assert max(gaps) < 2.3
    assert np.mean(np.array(gaps) > 0.0) > 0.9


# --- the plotted data and the files


def test_data_are_written_with_units_and_all_digits(tmp_path: Path) -> None:
    data = PlottedData()
    points = np.array([[0.1, 1.0 / 3.0], [-2.0, 5e-17]])
    data.add("locus", points, "C_1o", "parallel, folded")
    data.add("sample", points, values=np.array([0.25, math.nan]))
    data.add("circle", [(1.0, 2.0)], values=7.0)
    path = tmp_path / "data.csv"
    data.write(path, "mm")

    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    assert header == ["element", "part", "curve", "kind", "x_mm", "y_mm", "value"]
    assert [row[:4] for row in rows[:2]] == [["locus", "1", "C_1o", "parallel, folded"]] * 2
    assert [(float(row[4]), float(row[5])) for row in rows[:2]] == [
        tuple(p) for p in points.tolist()
    ]
    assert [row[6] for row in rows] == ["", "", "0.25", "", "7.0"]
    assert [row[1] for row in rows] == ["1", "1", "2", "2", "3"]
    data.write(path, "", overwrite=True)
    assert path.read_text().splitlines()[0] == "element,part,curve,kind,x,y,value"


def test_every_line_of_a_curve_is_among_the_data() -> None:
    design = design_of(26, 30, 16)
    draws: list[Callable[..., Figure]] = [loci_figure, workspace_figure, lci_figure]
    for draw in draws:
        data = PlottedData()
        figure = draw(design, FIRST, data=data)
        for start in ("C_", "LCI", "contour-", "link-", "joint-", "inscribed-circle-", "tangency"):
            for line in lines(figure, start):
                known = any(np.array_equal(line, part.points) for part in data.parts)
                assert known, (draw, start)


@pytest.mark.parametrize(
    ("form", "draw"),
    [
        ("svg", lambda design: linkage_figure(design, design.inverse_poses(5.0, 38.0))),
        ("svg", lambda design: lci_figure(design, FIRST)),
        ("pdf", loci_figure),
        ("pdf", lambda design: workspace_figure(design, FIRST)),
        ("png", lambda design: good_condition_figure(design, FIRST, 0.4)),
    ],
)
def test_the_same_design_gives_the_same_bytes(
    form: str, draw: Callable[[PlanarDesign], Figure]
) -> None:
    first = rendered(draw(design_of(26, 30, 16)), form, 60.0)
    with mpl.rc_context({"font.family": "monospace", "lines.linewidth": 9.0}):
        assert rendered(draw(design_of(26, 30, 16)), form, 60.0) == first
    assert rendered(draw(design_of(26, 30, 15)), form, 60.0) != first
