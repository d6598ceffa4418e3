"""Conditions: the grammar, the margins, and the regions that follow from them."""

from __future__ import annotations

from collections.abc import Iterator

import closed_form_atlas
import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.store import Atlas, open_atlas
from fivebar_atlas.synthesis.conditions import (
    Condition,
    condition_margins,
    condition_names,
    parse_condition,
    rounded_margins,
)
from fivebar_atlas.synthesis.optimum_region import optimum_region
from fivebar_atlas.triangulated_regions import region_where


@pytest.fixture(scope="module")
def atlas(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Atlas]:
    folder = tmp_path_factory.mktemp("conditions")
    with open_atlas(closed_form_atlas.write(folder / "closed_form.h5")) as opened:
        yield opened


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("gci>=0.62", Condition("gci", ">=", 0.62)),
        ("  gci  >=  0.62 ", Condition("gci", ">=", 0.62)),
        ("usable_workspace_area<24", Condition("usable_workspace_area", "<", 24.0)),
        ("r3<=.131", Condition("r3", "<=", 0.131)),
        ("gci_error>1e-7", Condition("gci_error", ">", 1e-7)),
        ("max_lci_y>=-1.5E+0", Condition("max_lci_y", ">=", -1.5)),
        ("r1>+2.", Condition("r1", ">", 2.0)),
    ],
)
def test_conditions_are_read(text: str, expected: Condition) -> None:
    assert parse_condition(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        "",
        "gci",
        "gci>=",
        ">=0.62",
        "gci=0.62",
        "gci==0.62",
        "gci=>0.62",
        "gci>>0.62",
        "0.62<=gci",
        "gci>=0.62 and r1>1",
        "gci>=0.6;r1>1",
        "gci>=nan",
        "gci>=inf",
        "gci>=1e999",
        "gci>=0x10",
        "gci>=1_000",
        "gci>=0,62",
        "gci>=r1",
        "gci>=\N{ARABIC-INDIC DIGIT ONE}",
        "__import__('os')>=1",
        "gci>=0.62\n>=1",
    ],
)
def test_anything_else_is_refused_with_what_is_allowed(text: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_condition(text)
    assert caught.value.exit_code == 2
    assert caught.value.value == text
    assert "number" in caught.value.allowed


@given(
    operator=st.sampled_from([">=", "<=", ">", "<"]),
    bound=st.floats(-1e6, 1e6),
    value=st.floats(-1e6, 1e6),
)
def test_margin_and_truth_agree_with_python(operator: str, bound: float, value: float) -> None:
    condition = parse_condition(f"gci{operator}{bound!r}")
    assume(value == bound or abs(value - bound) > 2e-12 * (abs(bound) or 1.0))
    truth = {
        ">=": value >= bound,
        "<=": value <= bound,
        ">": value > bound,
        "<": value < bound,
    }[operator]

    assert condition.bound == bound
    assert bool(condition.holds(np.array([value]))[0]) is truth
    margin = float(condition.margin(np.array([value]))[0])
    assert abs(margin) == abs(value - bound)
    assert (margin > 0) == (truth and value != bound)


@pytest.mark.parametrize("bound", [0.0, 1e-3, 1.0, -24.0])
def test_what_is_at_the_bound_but_for_rounding_is_at_the_bound(bound: float) -> None:
    scale = abs(bound) or 2.0  # the bound, or the range of the values
    values = bound + scale * np.array([-0.6, -1e-11, -1e-13, 0.0, 1e-13, 1e-11, 0.4])
    expected = {">=": 2, ">": 5, "<=": 5, "<": 2}  # where the conditions change
    for operator, change in expected.items():
        condition = Condition("gci", operator, bound)
        is_above = np.arange(len(values)) >= change
        truth = is_above if operator[0] == ">" else ~is_above
        np.testing.assert_array_equal(condition.holds(values), truth)
        margins = rounded_margins(condition, values)
        np.testing.assert_array_equal(margins >= 0.0, truth)
        np.testing.assert_allclose(margins, condition.margin(values), atol=2e-12 * 30.0)


def test_a_plateau_at_the_bound_is_in_the_region_or_not() -> None:
    points = np.array([(x, y) for y in range(3) for x in range(5)], dtype=np.float64)
    places = [(5 * y + x, 5 * y + x + 1, 5 * y + x + 5) for y in range(2) for x in range(4)]
    places += [(5 * y + x + 1, 5 * y + x + 6, 5 * y + x + 5) for y in range(2) for x in range(4)]
    # 1 but for rounding left of x = 2, then falling
    noise = np.random.default_rng(1).uniform(-1e-15, 1e-15, len(points))
    values = 1.0 + noise - np.maximum(points[:, 0] - 2.0, 0.0)
    for text, area in (("q>=1", 4.0), ("q>1", 0.0), ("q<1", 4.0), ("q<=1", 8.0)):
        margins = rounded_margins(parse_condition(text), values)
        region = region_where(points, np.array(places), margins[np.newaxis])
        assert region.area == pytest.approx(area, abs=1e-10)


def test_a_missing_value_fulfils_nothing() -> None:
    for operator in (">=", "<=", ">", "<"):
        condition = Condition("gci", operator, 0.5)
        assert not condition.holds(np.array([np.nan]))[0]
        assert np.isnan(condition.margin(np.array([np.nan]))[0])


def test_written_conditions_read_back() -> None:
    for condition in (Condition("gci", ">=", 0.62), Condition("r3", "<", 1e-9)):
        assert parse_condition(str(condition)) == condition


def test_names_are_parameters_and_quantities_but_no_categories(atlas: Atlas) -> None:
    names = condition_names(atlas)

    assert names[:3] == ("r1", "r2", "r3")
    assert {"gci", "gci_error", "usable_workspace_area", "max_lci"} <= set(names)
    assert not {"status", "sub_region"} & set(names)


def test_an_unknown_quantity_names_the_nearest(atlas: Atlas) -> None:
    with pytest.raises(UnknownNameError) as caught:
        condition_margins([parse_condition("usable_workspce_area>=24")], atlas, "+-/up")
    assert caught.value.exit_code == 2
    assert "did you mean 'usable_workspace_area'?" in str(caught.value)
    assert "expected one of usable_workspace_area, usable_workspace_area_error, " in str(
        caught.value
    )
    assert " more that 'atlas mechanisms five-bar' lists" in str(caught.value)

    with pytest.raises(UnknownNameError):
        condition_margins([parse_condition("status>=1")], atlas, "+-/up")


def test_margins_are_those_of_the_stored_values(atlas: Atlas) -> None:
    conditions = [parse_condition(text) for text in ("gci>=0.5", "r3<0.2", "gci_error<=1e-6")]

    margins = condition_margins(conditions, atlas, "+-/up")

    assert margins.shape == (3, len(atlas.designs))
    np.testing.assert_array_equal(margins[0], closed_form_atlas.conditioning(atlas.designs) - 0.5)
    np.testing.assert_allclose(margins[1], 0.2 - atlas.designs[:, 2], atol=1e-12)
    at_bound = np.abs(atlas.designs[:, 2] - 0.2) < 1e-9
    assert at_bound.any()
    assert (margins[1][at_bound] < 0.0).all()
    np.testing.assert_array_equal(margins[2], np.full(len(atlas.designs), 1e-6 - 1e-9))


def test_mode_and_threshold_reach_the_quantities_that_have_them(atlas: Atlas) -> None:
    condition = [parse_condition("good_condition_workspace_area>=1")]
    area = closed_form_atlas.area(atlas.designs)

    at_03 = condition_margins(condition, atlas, "+-/up", 0.3)[0]
    at_05 = condition_margins(condition, atlas, "+-/up", 0.5)[0]

    np.testing.assert_allclose(at_03, 0.7 * area - 1.0, rtol=1e-12)
    np.testing.assert_allclose(at_05, 0.5 * area - 1.0, rtol=1e-12)
    with pytest.raises(InputError, match=r"0\.3, 0\.5"):
        condition_margins(condition, atlas, "+-/up", 0.4)
    with pytest.raises(InputError, match=r"\+-/up"):
        condition_margins(condition, atlas, "--/down", 0.3)


def test_the_region_of_conditions_on_parameters_is_their_polygon(atlas: Atlas) -> None:
    texts = ("r1>=1.2", "r1<=1.55", "r3<=0.37")
    found = optimum_region(atlas, [parse_condition(text) for text in texts])

    # Corners of the parallelogram 1.2 <= r1 <= 1.55, 0 <= r3 <= 0.37 in the chart.
    corners = [(1.2, 0.0), (1.55, 0.0), (1.55, 0.37), (1.2, 0.37)]
    polygon = shapely.Polygon([((2 * r1 + r3) / np.sqrt(3), r3) for r1, r3 in corners])
    assert found.region.area == pytest.approx(polygon.area, rel=1e-12)
    assert found.share == pytest.approx(polygon.area / np.sqrt(3), rel=1e-12)
    np.testing.assert_allclose(found.least, [1.2, 3 - 1.55 - 0.37, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.greatest, [1.55, 1.8, 0.37], rtol=1e-12)
    r1, _, r3 = atlas.designs.T
    inside = (r1 >= 1.2) & (r1 <= 1.55) & (r3 <= 0.37)
    assert found.lattice_designs == int(inside.sum()) > 0


def test_an_impossible_condition_leaves_an_empty_region(atlas: Atlas) -> None:
    found = optimum_region(atlas, [parse_condition("gci>0.9")], "+-/up")

    assert found.region.is_empty
    assert found.share == 0.0
    assert found.lattice_designs == 0
    assert np.isnan(found.least).all()


def test_a_condition_that_only_an_edge_fulfils_has_designs_but_no_interior(atlas: Atlas) -> None:
    found = optimum_region(atlas, [parse_condition("r3<=0")])

    assert found.region.is_empty
    assert found.lattice_designs == 29
