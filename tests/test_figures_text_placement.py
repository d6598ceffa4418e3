"""Boxes of text against shapely, and labels that stay on their lines and apart."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from fivebar_atlas.figures.text_placement import (
    Box,
    place_along_lines,
    text_ink,
    text_origin,
    text_size,
    wrapped,
)

boxes = st.builds(
    Box,
    x=st.floats(-5, 5),
    y=st.floats(-5, 5),
    width=st.floats(0.5, 6),
    height=st.floats(0.5, 6),
    angle=st.floats(-90, 90),
)


def polygon(box: Box) -> shapely.Polygon:
    rectangle = shapely.box(-box.width / 2, -box.height / 2, box.width / 2, box.height / 2)
    turned = shapely.affinity.rotate(rectangle, box.angle, origin=(0, 0))
    return shapely.affinity.translate(turned, box.x, box.y)


@given(one=boxes, other=boxes)
@settings(max_examples=300)
def test_boxes_overlap_where_their_polygons_do(one: Box, other: Box) -> None:
    shared = shapely.intersection(polygon(one), polygon(other)).area
    if shared > 1e-6:
        assert one.overlaps(other)
    elif shapely.distance(polygon(one), polygon(other)) > 1e-6:
        assert not one.overlaps(other)


@given(one=boxes, other=boxes, gap=st.floats(0.1, 2.0))
@settings(max_examples=300)
def test_a_gap_widens_the_box_on_every_side(one: Box, other: Box, gap: float) -> None:
    wider = Box(one.x, one.y, one.width + 2 * gap, one.height + 2 * gap, one.angle)
    shared = shapely.intersection(polygon(wider), polygon(other)).area
    apart = shapely.distance(polygon(wider), polygon(other))
    if shared > 1e-6 or apart > 1e-6:
        assert one.overlaps(other, gap) == (shared > 1e-6)


@given(box=boxes, x=st.floats(-8, 8), y=st.floats(-8, 8))
def test_a_box_contains_what_its_polygon_contains(box: Box, x: float, y: float) -> None:
    point = shapely.Point(x, y)
    if shapely.distance(polygon(box).exterior, point) > 1e-6:
        inside = bool(box.contains(np.array([[x, y]]))[0])
        assert inside == polygon(box).contains(point)


def test_text_is_as_large_as_its_font_size_says() -> None:
    # A capital letter of Times is about two thirds of the font size high.
    _, height = text_size("H", 10.0)
    assert height == pytest.approx(0.66 * 10.0 * 25.4 / 72.0, rel=0.03)
    assert text_size("HH", 20.0)[1] == pytest.approx(2 * height, rel=1e-9)
    assert text_size("0.62", 6.5)[0] == pytest.approx(4 * text_size("0.62", 6.5 / 4)[0], rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 33.0, -90.0])
def test_the_ink_of_a_text_is_centred_in_its_box(angle: float) -> None:
    box = Box(3.0, 4.0, *text_size("pq", 8.0), angle)
    left, bottom, right, top = text_ink("pq", 8.0)
    origin = text_origin("pq", 8.0, box)

    middle = shapely.affinity.rotate(
        shapely.Point((left + right) / 2, (bottom + top) / 2), angle, origin=(0, 0)
    )
    assert origin[0] + middle.x == pytest.approx(3.0)
    assert origin[1] + middle.y == pytest.approx(4.0)


def test_long_text_is_broken_and_nothing_lost() -> None:
    text = "global conditioning index of the good-condition workspace GCI (dimensionless)"
    lines = wrapped(text, 8.0, 40.0)

    assert " ".join(lines) == text
    assert len(lines) > 1
    sizes = [text_size(line, 8.0)[0] for line in lines]
    assert max(sizes) <= 40.0
    assert min(sizes) > 0.5 * max(sizes)


def test_what_belongs_together_is_not_broken_where_it_need_not_be() -> None:
    assert wrapped("an area that is large (in units of $D^2$)", 8.0, 36.0) == [
        "an area that is large",
        "(in units of $D^2$)",
    ]
    assert wrapped("gci, mode\N{NO-BREAK SPACE}++/up", 8.0, 17.0) == ["gci,", "mode ++/up"]
    assert len(wrapped("(one two three four five six)", 8.0, 20.0)) > 1


def circle(radius: float) -> np.ndarray:
    angles = np.linspace(0.0, np.pi, 200)
    return np.column_stack([30.0 + radius * np.cos(angles), 2.0 + radius * np.sin(angles)])


OUTLINE = np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 40.0], [0.0, 40.0]])
NOTHING = np.empty((0, 2))


def test_labels_lie_on_their_lines_inside_and_apart() -> None:
    occupied = [Box(30.0, 20.0, 12.0, 6.0)]
    placed = []
    for radius in (6.0, 9.0, 12.0, 15.0, 18.0, 21.0):
        found = place_along_lines([circle(radius)], 5.0, 2.0, OUTLINE, occupied, NOTHING, NOTHING)
        assert len(found) == 1
        (box,) = found
        # The middle of the chord, below the arc by its sagitta at most.
        sagitta = radius - np.sqrt(radius**2 - 2.5**2)
        assert radius - sagitta <= np.hypot(box.x - 30.0, box.y - 2.0) + 1e-3 <= radius + 2e-3
        assert polygon(box).within(shapely.Polygon(OUTLINE))
        placed.append(box)
    everything = [Box(30.0, 20.0, 12.0, 6.0), *placed]
    assert occupied == everything
    for index, one in enumerate(everything):
        for other in everything[:index]:
            assert shapely.distance(polygon(one), polygon(other)) > 0.4


def test_a_long_line_gets_a_second_label_and_a_short_one_none() -> None:
    long = np.array([[2.0, 10.0], [58.0, 10.0]])
    short = np.array([[10.0, 30.0], [14.0, 30.0]])

    found = place_along_lines([long, short], 5.0, 2.0, OUTLINE, [], NOTHING, NOTHING, repeat=30.0)

    assert len(found) == 2
    assert all(box.y == pytest.approx(10.0) for box in found)
    assert abs(found[0].x - found[1].x) >= 15.0


def test_a_label_keeps_off_other_lines_where_it_can() -> None:
    line = np.array([[2.0, 10.0], [58.0, 10.0]])
    border = np.column_stack([np.full(40, 30.0), np.linspace(0.0, 40.0, 40)])

    (free,) = place_along_lines([line], 5.0, 2.0, OUTLINE, [], NOTHING, NOTHING)
    (moved,) = place_along_lines([line], 5.0, 2.0, OUTLINE, [], NOTHING, border)

    assert free.x == pytest.approx(30.0, abs=0.3)
    assert abs(moved.x - 30.0) > 2.5


def test_no_label_where_there_is_no_room() -> None:
    line = np.array([[2.0, 10.0], [58.0, 10.0]])
    full = [Box(30.0, 20.0, 60.0, 40.0)]

    assert place_along_lines([line], 5.0, 2.0, OUTLINE, full, NOTHING, NOTHING) == []
    assert len(full) == 1


def test_text_is_never_upside_down() -> None:
    for direction in (1, -1):
        for angle in np.linspace(0.0, 2 * np.pi, 17):
            line = np.array([30.0, 20.0]) + direction * np.linspace(-15, 15, 50)[:, None] * [
                np.cos(angle),
                np.sin(angle),
            ]
            (box,) = place_along_lines([line], 5.0, 2.0, OUTLINE, [], NOTHING, NOTHING)
            assert -90.0 < box.angle <= 90.0
            assert np.sin(np.radians(box.angle) - angle) == pytest.approx(0.0, abs=1e-9)
