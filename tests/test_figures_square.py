"""Figures of the largest square: what is drawn where, against the oracle, and what is written."""

from __future__ import annotations

import itertools
import math

import naive
import naive_square
import numpy as np
import pytest
import shapely
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.text import Text
from naive_square import optimal_lengths

from fivebar_atlas import mechanisms
from fivebar_atlas.cli.square_figures import draw_curve, draw_optimal_configuration, draw_square
from fivebar_atlas.errors import InfeasibleSizeError, InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.square_curve_figure import square_curve_figure
from fivebar_atlas.figures.value_panel import value_panel
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.synthesis.containment import ActuatorRange
from fivebar_atlas.synthesis.largest_square import AXIS, Square, SquareTask, largest_square
from fivebar_atlas.synthesis.square_curve import SquareCurve, ratios_between, square_curve

FIRST = "+-/up"


@pytest.fixture(scope="module")
def five_bar() -> Mechanism:
    return mechanisms.get("five-bar")


@pytest.fixture(scope="module")
def curve(five_bar: Mechanism) -> SquareCurve:
    return square_curve(SquareTask(five_bar, FIRST), ratios_between(1.2, 4.0, 0.1))


def line(figure: Figure, gid: str) -> np.ndarray:
    """Return the points of a line by its name, shape (n, 2)."""
    (found,) = [each for each in figure.findobj(Line2D) if each.get_gid() == gid]
    return np.asarray(found.get_xydata())


def gids(figure: Figure, start: str) -> list[str]:
    names = [each.get_gid() or "" for each in figure.findobj()]
    return sorted({name for name in names if name.startswith(start)})


def filled(figure: Figure, gid: str) -> shapely.Geometry:
    (patch,) = [each for each in figure.findobj(PathPatch) if each.get_gid() == gid]
    rings = patch.get_path().to_polygons(closed_only=True)
    inside: shapely.Geometry = shapely.Polygon()
    for ring in rings:
        inside = inside.symmetric_difference(shapely.Polygon(ring))
    return inside


def written(figure: Figure) -> str:
    texts = [each.get_text() for each in figure.findobj(Text) if each.get_visible()]
    return "\n".join(texts).replace("\N{NO-BREAK SPACE}", " ")


def parts(data: PlottedData, element: str) -> list[np.ndarray]:
    return [part.points for part in data.parts if part.element == element]


# --- the curve


def test_the_curve_is_drawn_piece_by_piece(curve: SquareCurve) -> None:
    data = PlottedData()
    figure = draw_curve(curve.squares[0].task, curve, data=data)
    pieces = [line(figure, f"piece-{number}") for number in (1, 2, 3)]
    assert gids(figure, "piece-") == ["piece-1", "piece-2", "piece-3"]
    ends = [(piece[0, 0], piece[-1, 0]) for piece in pieces]
    assert ends == [(piece.start, piece.end) for piece in curve.pieces]
    for points, part in zip(pieces, parts(data, "side of the largest square"), strict=True):
        np.testing.assert_array_equal(points, part)
        for ratio, side in points[:: len(points) // 2]:
            lengths = optimal_lengths(ratio)
            radius, y = naive_square.circle_between_reach_circles(lengths)
            limit = radius * math.sqrt(2.0)
            ref = naive_square.largest_side(naive_square.Wanted(lengths), y, 1.0, limit)
            assert side == pytest.approx(ref, rel=0.0, abs=2e-8)
    kinks = line(figure, "kinks")
    assert kinks[:, 0] == pytest.approx([1.5260005739, 1.9655999229], abs=1e-9)
    np.testing.assert_allclose(kinks[0], pieces[1][0], rtol=1e-7)
    (largest,) = line(figure, "largest")
    assert largest == pytest.approx([1.5260005739, 1.3322459135], abs=1e-8)
    np.testing.assert_array_equal(parts(data, "largest side"), [[largest]])
    names = [part.curve for part in data.parts if part.curve]
    assert names == [piece.active[0] for piece in curve.pieces]


def test_every_piece_has_a_look_and_a_name(curve: SquareCurve) -> None:
    figure = draw_curve(curve.squares[0].task, curve)
    text = written(figure)
    for piece in curve.pieces:
        assert piece.active[0] in text.splitlines()
    assert r"kinks at $\rho$ = 1.5260, 1.9656" in text
    assert "(1.5260, 1.3322)" in text
    assert r"ratio of links $\rho = l_2/l_1$" in text
    assert "side of the largest square $a/l_1$" in text
    assert "Largest square, LCI \N{GREATER-THAN OR EQUAL TO} 0.5, mode +\N{MINUS SIGN}/up" in text
    looks = set()
    for each in figure.axes[0].lines:
        if (each.get_gid() or "").startswith("piece-"):
            looks.add((each.get_color(), str(each._dash_pattern)))
    assert len(looks) == 3


def test_pieces_limited_by_one_thing_have_one_entry() -> None:
    x = np.array([1.0, 2.0])
    lines = [
        (name, np.column_stack([x + 2.0 * number, x]))
        for number, name in enumerate(("one", "two", "one"))
    ]
    figure = square_curve_figure(lines, [(3.0, 2.0)], (2.0, 2.0), "Title", "$a$", ["remark"])
    assert written(figure).splitlines().count("one") == 1
    assert r"kink at $\rho$ = 3.0000" in written(figure)
    assert "remark" in written(figure)
    looks = [each.get_color() for each in figure.axes[0].lines if "piece" in (each.get_gid() or "")]
    assert looks[0] == looks[2] != looks[1]


def test_where_there_is_no_square_nothing_is_drawn_and_it_is_said(five_bar: Mechanism) -> None:
    task = SquareTask(five_bar, "++/up", 0.3)
    figure = draw_curve(task, square_curve(task, ratios_between(1.2, 4.0, 0.4)))
    assert gids(figure, "piece-") == ["piece-1"]
    assert gids(figure, "kinks") == []
    assert line(figure, "piece-1")[0, 0] == pytest.approx(1.684556, abs=1e-5)
    assert r"no square for $\rho$ from 1.2 to 1.68456" in written(figure)


def test_no_square_at_all_is_refused(five_bar: Mechanism) -> None:
    task = SquareTask(five_bar, "++/up", 0.99)
    with pytest.raises(InfeasibleSizeError, match="for no ratio of links: no square"):
        draw_curve(task, square_curve(task, [1.2, 1.3]))


def test_inputs_and_shape_are_named_in_the_field_s_notation(five_bar: Mechanism) -> None:
    ranges = (ActuatorRange(2, math.radians(20.0), math.radians(240.0)),)
    task = SquareTask(five_bar, FIRST, 0.4, ranges, 2.0)
    figure = draw_curve(task, square_curve(task, [1.5, 2.0]))
    text = written(figure).replace("\n", " ")
    assert r"least $\theta_{2}$ at the lower right corner" in text
    assert r"$\theta_{2}$ from 20° to 240°" in text
    assert "Largest rectangle of aspect 2" in text
    assert "root of the area of the largest rectangle" in text


def test_values_that_are_one_have_an_axis() -> None:
    values = np.array([[1.0, 2.0, 3.0], [math.sqrt(2.0), 1.4142135623730951, math.sqrt(2.0)]])
    values[1, 1] += 1e-15
    with style.styled():
        panel = value_panel(values, ("x", "y"), "Title", 85.0, 5.0)
    low, high = panel.axes.get_ylim()
    assert high - low > 0.01
    assert len(panel.axes.get_yticks()) > 1


# --- the square


@pytest.fixture(scope="module")
def square(five_bar: Mechanism) -> Square:
    return largest_square(SquareTask(five_bar, FIRST), optimal_lengths(1.6))


def test_contours_lie_in_the_square_on_their_level(square: Square) -> None:
    data = PlottedData()
    figure = draw_square(square, data=data)
    inside = shapely.box(*(-0.5 * square.side + np.array(square.centre)),
                         *(0.5 * square.side + np.array(square.centre)))  # fmt: skip
    levels = set()
    for part in data.parts:
        if part.element != "contour":
            continue
        lci = naive.lci(*square.lengths, *part.points.T, 1, -1)
        level = float(part.values[0])
        within = shapely.covers(inside.buffer(1e-9), shapely.LineString(part.points))
        assert within == (part.kind == "level")
        # where a contour is cut off at the square it ends on a chord
        np.testing.assert_allclose(lci[1:-1], level, rtol=1e-9)
        np.testing.assert_allclose(lci, level, rtol=1e-4)
        levels.add(round(level, 12))
        assert any(
            np.array_equal(part.points, each.get_xydata()) for each in figure.findobj(Line2D)
        )
    assert levels == {0.5, 0.6, 0.7, 0.8, 0.9}


def test_bands_fill_the_square(square: Square) -> None:
    figure = draw_square(square)
    bands = [filled(figure, f"band-{number}") for number in range(1, 6)]
    assert bands[0].area == pytest.approx(square.side**2, rel=1e-12)
    for outer, inner in itertools.pairwise(bands):
        assert outer.buffer(1e-9).contains(inner)
    x, y = (middle + square.side * ((np.arange(800) + 0.5) / 800 - 0.5) for middle in square.centre)
    lci = naive.lci(*square.lengths, *np.meshgrid(x, y), 1, -1)
    for level, band in zip((0.6, 0.7, 0.8, 0.9), bands[1:], strict=True):
        assert band.area / square.side**2 == pytest.approx(np.mean(lci >= level), abs=1e-3)


def test_circle_contacts_and_points_are_marked(square: Square) -> None:
    data = PlottedData()
    figure = draw_square(square, data=data)
    radius, y = naive_square.circle_between_reach_circles(square.lengths)
    circle = line(figure, "inscribed-circle")
    np.testing.assert_allclose(np.hypot(circle[:, 0], circle[:, 1] - y), radius, rtol=1e-9)
    assert line(figure, "inscribed-circle-centre")[0] == pytest.approx((0.0, y))
    contacts = line(figure, "overlay-points-1")
    half = 0.5 * square.side
    np.testing.assert_allclose(contacts, [[-half, y + half], [half, y + half]], rtol=1e-9)
    outline = line(figure, "overlay-1")
    assert np.abs(outline - [0.0, y]).max() == pytest.approx(half)
    assert line(figure, "isotropic point")[0] == pytest.approx((0.0, 2.6 * math.sqrt(0.5)))
    elements = {part.element for part in data.parts}
    assert {
        "boundary of the usable workspace",
        "maximal inscribed circle",
        "centre of the maximal inscribed circle",
        "isotropic point",
    } <= elements
    text = written(figure)
    for said in (
        "largest square, $a/l_1$ = 1.3293",
        "contact: LCI at the upper corners",
        "maximal inscribed circle, $r/l_1$ = 1, centre at $y/l_1$ = 1.5427",
        "LCI = 0.5",
        r"$\rho = l_2/l_1$ = 1.6, $l_0/l_1$ = 0.42426",
        "$x/l_1$",
    ):
        assert said in text


def test_boundary_arcs_are_those_of_the_usable_workspace(square: Square) -> None:
    data = PlottedData()
    draw_square(square, data=data)
    found = parts(data, "boundary of the usable workspace")
    r1, r2, r3 = square.lengths
    assert len(found) > 3
    for points in found:
        legs = [np.hypot(points[:, 0] - base, points[:, 1]) for base in (-r3, r3)]
        gaps = [np.abs(leg - reach).max() for leg in legs for reach in (r1 + r2, abs(r1 - r2))]
        height = math.sqrt(r1**2 - r3**2)
        gaps += [
            np.abs(np.hypot(points[:, 0], points[:, 1] - sign * height) - r2).max()
            for sign in (1, -1)
        ]
        gaps.append(naive.coupler_error(r1, r2, r3, *points.T).max())
        assert min(gaps) < 1e-6


def test_another_centre_a_rectangle_and_no_isotropic_point(five_bar: Mechanism) -> None:
    task = SquareTask(five_bar, FIRST, 0.75, aspect=2.0, centre=AXIS)
    found = largest_square(task, optimal_lengths(4.0))
    figure = draw_square(found)
    assert line(figure, "centre of the rectangle")[0] == pytest.approx(found.centre)
    outline = line(figure, "overlay-1")
    width, height = np.ptp(outline, axis=0)
    assert width == pytest.approx(2.0 * height)
    assert f"$w/l_1$ = {width:.5g}, $h/l_1$ = {height:.5g}" in written(figure)
    assert "in the rectangle" in written(figure)
    assert "centre anywhere on the axis" in written(figure)
    low = largest_square(SquareTask(five_bar, "++/up", 0.3), (1.0, 2.5, 0.8))
    assert gids(draw_square(low), "isotropic") == []


# --- the configuration


@pytest.mark.parametrize("ratio", [1.0, 1.6, 4.0])
def test_the_optimal_configuration_is_eqs_21_and_22(five_bar: Mechanism, ratio: float) -> None:
    data = PlottedData()
    figure = draw_optimal_configuration(five_bar, ratio, data=data)
    places = {part.curve: part.points[0] for part in data.parts if part.element == "joint"}
    half = (ratio - 1.0) / math.sqrt(2.0)
    expected = {
        "A_1": (-half, 0.0),
        "A_2": (half, 0.0),
        "B_1": (-half - math.sqrt(0.5), math.sqrt(0.5)),
        "B_2": (half + math.sqrt(0.5), math.sqrt(0.5)),
        "P": (0.0, (1.0 + ratio) / math.sqrt(2.0)),
    }
    for name, place in expected.items():
        assert places[name] == pytest.approx(place, abs=1e-12), name
    text = written(figure)
    for symbol in ("$l_1$", "$l_2$", "$P$"):
        assert symbol in text.splitlines()
    assert ("$l_0$" in text.splitlines()) == (ratio > 1.0)
    assert rf"$P = (0, (l_1+l_2)/\sqrt{{2}})$ = (0, {expected['P'][1]:.5g}) $l_1$" in text
    assert r"$\theta_{1}$ = 135°, $\theta_{2}$ = 45°, LCI = 1.0000" in text


# --- all of them


@pytest.mark.parametrize("width", [60.0, 85.0, 170.0])
def test_no_text_covers_another_or_leaves_the_figure(
    five_bar: Mechanism, curve: SquareCurve, square: Square, width: float
) -> None:
    narrow = SquareTask(
        five_bar,
        FIRST,
        ranges=(ActuatorRange(1, -1.0, 2.7), ActuatorRange(2, 0.5, 4.1)),
    )
    figures = [
        draw_curve(curve.squares[0].task, curve, width=width),
        draw_curve(narrow, square_curve(narrow, [1.5, 2.0]), width=width),
        draw_square(square, width=width),
        draw_optimal_configuration(five_bar, 1.6, width=width),
    ]
    for figure in figures:
        assert figure.get_figwidth() * style.MM_PER_INCH == pytest.approx(width)
        covered: np.ndarray | bool = False
        for text in figure.findobj(Text):
            if not text.get_text() or not text.get_visible():
                continue
            ink = ink_of(text, figure)
            assert not np.any(ink[[0, -1]]), text
            assert not np.any(ink[:, [0, -1]]), text
            assert not np.any(covered & ink), text
            covered = ink | covered


def ink_of(text: Text, figure: Figure, resolution: int = 80) -> np.ndarray:
    """Return which pixels a text covers that is drawn alone."""
    columns, rows = (figure.get_size_inches() * resolution).astype(int)
    figure.set_dpi(resolution)
    renderer = RendererAgg(columns, rows, resolution)
    with style.styled():
        text.set_path_effects([])
        text.draw(renderer)
    return np.asarray(renderer.buffer_rgba())[:, :, 3] > 40


def test_the_width_is_checked(five_bar: Mechanism, curve: SquareCurve, square: Square) -> None:
    with pytest.raises(InputError, match="millimetres"):
        draw_curve(curve.squares[0].task, curve, width=1.0)
    with pytest.raises(InputError, match="millimetres"):
        draw_square(square, width=1.0)
    with pytest.raises(InputError, match="millimetres"):
        draw_optimal_configuration(five_bar, 1.6, width=1.0)
