"""Optimum regions on true level sets, the best designs in them, and why some are empty.

Most of it on a mechanism with quantities in closed form, whose regions and optima are known
or found by brute force in NumPy; some of it on the five-bar itself.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import closed_form_atlas
import closed_form_mechanism
import numpy as np
import numpy.typing as npt
import pytest

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.five_bar import design_space
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import Atlas, AtlasWriter, open_atlas
from fivebar_atlas.synthesis import maximise as maximise_module
from fivebar_atlas.synthesis.candidates import Candidates
from fivebar_atlas.synthesis.conditions import Condition, check_contradictions, parse_condition
from fivebar_atlas.synthesis.design_polygon import DesignPolygon
from fivebar_atlas.synthesis.empty_region import explain_emptiness
from fivebar_atlas.synthesis.exact_values import ExactValues
from fivebar_atlas.synthesis.maximise import local_maxima, maximise
from fivebar_atlas.synthesis.objectives import Objective, parse_objective

FloatArray = npt.NDArray[np.float64]

SPACE_AREA = 3.0**2 / math.sqrt(3.0) / 3.0
KNOWN = ("r1", "r2", "r3", "gci", "usable_workspace_area")


@pytest.fixture(scope="module")
def five_bar(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Atlas]:
    path = tmp_path_factory.mktemp("optimum") / "small.h5"
    with open_atlas(closed_form_mechanism.write(path, "five-bar")) as opened:
        yield opened


def under(atlas: Atlas, *texts: str) -> Candidates:
    return Candidates(atlas, [parse_condition(text) for text in texts])


def test_a_condition_is_active_within_the_error_of_its_value(
    five_bar: Atlas, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where values hold to a tolerance only; where they are exact, within rounding."""
    exact = ExactValues.of_atlas(five_bar, ["gci"], tolerance=1e-3)
    point = exact.polygon.corners.mean(axis=0)
    values, errors = exact.values_and_errors(exact.designs(point[np.newaxis]))
    assert 0.5 * errors[0, 0] > maximise_module.ACTIVE
    condition = Condition("gci", ">=", float(values[0, 0] - 0.5 * errors[0, 0]))
    objective = Objective(("gci",), (1.0,))
    search = maximise_module._Search(exact, objective, [condition], np.ones(1), 1.0)
    assert maximise_module._optimum(search, objective, point, True).active == ()
    monkeypatch.setattr(type(exact.mechanism), "exact_tolerance", None)
    assert maximise_module._optimum(search, objective, point, True).active == (condition,)


def random_designs(count: int, seed: int) -> FloatArray:
    """Return designs of the surrounded space, uniform in the chart."""
    shares = np.random.default_rng(seed).dirichlet((1.0, 1.0, 1.0), count)
    return shares @ np.array([[3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [1.0, 1.0, 1.0]])


def test_designs_come_back_from_the_chart() -> None:
    designs = random_designs(1000, 1)
    designs[0] = 1.2, 1.8, 0.0
    back = design_space.unproject(design_space.project(designs))
    assert np.abs(back - designs).max() < 4e-15
    assert back[0, 2] == 0.0
    lattice = design_space.lattice("surrounded", 90)
    back = design_space.unproject(design_space.project(lattice))
    assert np.abs(back - lattice).max() < 4e-15
    for first, second in ((0, 2), (1, 2)):
        touching = np.abs(lattice[:, first] - lattice[:, second]) < 1e-9
        assert np.array_equal(back[touching, first], back[touching, second])


def test_the_design_space_is_a_polygon_with_named_sides() -> None:
    mechanism = mechanisms.get("five-bar")
    polygon = DesignPolygon.of_space(mechanism, "surrounded")
    assert sorted(polygon.names(mechanism, "surrounded")) == ["r1 = r3", "r2 = r3", "r3 = 0"]
    assert polygon.area == pytest.approx(SPACE_AREA, rel=1e-14)
    names = DesignPolygon.of_space(mechanism, "assemblable").names(mechanism, "assemblable")
    assert sorted(names) == ["r1 = 0", "r2 = 0", "r3 = 0", "r3 = 1.5"]


def test_points_are_clipped_to_the_polygon() -> None:
    polygon = DesignPolygon.of_space(mechanisms.get("five-bar"), "surrounded")
    points = np.random.default_rng(2).uniform(-2.0, 5.0, (500, 2))
    clipped = polygon.clip(points)
    assert polygon.contains(clipped).all()
    inside = polygon.contains(points)
    assert inside.any()
    assert (~inside).any()
    np.testing.assert_allclose(clipped[inside], points[inside], atol=1e-9)


def test_differences_are_exact_for_parabolas_also_at_borders_and_corners(
    closed_form: Atlas,
) -> None:
    polygon = DesignPolygon.of_space(closed_form.mechanism, "surrounded")
    exact = under(closed_form).exact(["usable_workspace_area"])
    middles = (polygon.corners + np.roll(polygon.corners, -1, axis=0)) / 2.0
    inner = polygon.corners.mean(axis=0)[np.newaxis]
    points = np.vstack([middles, inner, polygon.corners])
    found = exact.gradients(points, exact.values(points))[0]
    # area = 12 r1 r2 (1 - r3/2) with r1 = (sqrt(3) x - y)/2, r2 = 3 - r1 - y, r3 = y
    r1, r2, r3 = design_space.unproject(points).T
    along_r1, along_r2, along_r3 = (
        12.0 * r2 * (1.0 - r3 / 2.0),
        12.0 * r1 * (1.0 - r3 / 2.0),
        -6.0 * r1 * r2,
    )
    expected = np.column_stack(
        [
            math.sqrt(3.0) / 2.0 * (along_r1 - along_r2),
            -0.5 * along_r1 - 0.5 * along_r2 + along_r3,
        ]
    )
    np.testing.assert_allclose(found, expected, atol=2e-6)


@pytest.mark.parametrize("bound", [0.5, 0.6, 0.62, 0.66])
def test_a_refined_region_is_the_closed_form_one(closed_form: Atlas, bound: float) -> None:
    # 0.67 exp(-(r1 - 1.3)^2 - 1.5 r3) >= bound below a parabola over r1
    half_width = math.sqrt(math.log(0.67 / bound))
    height = half_width**2 / 1.5
    candidates = under(closed_form, f"gci>={bound}")
    refined = candidates.refined()
    least, greatest = candidates.refined_extent(refined.loops)

    assert refined.unmoved == 0
    assert refined.residual <= 1e-8
    (loop,) = refined.loops
    designs = design_space.unproject(loop)
    on_border = designs[:, 2] < 1e-9
    values = closed_form_atlas.conditioning(designs)
    np.testing.assert_allclose(values[~on_border], bound, rtol=1e-8)
    assert np.count_nonzero(on_border) == 2
    np.testing.assert_allclose(values[on_border], bound, rtol=1e-8)
    if bound >= 0.6:  # further down the parabola meets the border r1 = r3
        area = 2.0 / math.sqrt(3.0) * 4.0 / 3.0 * half_width * height
        assert refined.area == pytest.approx(area, abs=max(refined.area_error, 1e-12))
        assert refined.area_error < 1e-2 * area
        np.testing.assert_allclose(least[[0, 2]], [1.3 - half_width, 0.0], atol=1e-9)
        np.testing.assert_allclose(greatest[[0, 2]], [1.3 + half_width, height], atol=1e-9)


def test_corners_between_two_conditions_fulfil_both(closed_form: Atlas) -> None:
    candidates = under(closed_form, "gci>=0.6", "usable_workspace_area>=24", "r3<=0.02")
    refined = candidates.refined()
    designs = design_space.unproject(np.concatenate(refined.loops))
    gaps = np.array(
        [
            closed_form_atlas.conditioning(designs) / 0.6 - 1.0,
            closed_form_atlas.area(designs) / 24.0 - 1.0,
            -(designs[:, 2] / 0.02 - 1.0),
        ]
    )
    assert gaps.min() >= -1e-8
    touched = np.abs(gaps) <= 1e-8
    assert (touched.any(axis=0) | (designs[:, 2] < 1e-9)).all()
    assert np.count_nonzero(np.count_nonzero(touched, axis=0) == 2) >= 2


def test_the_interpolation_error_is_that_of_the_outline(closed_form: Atlas) -> None:
    candidates = under(closed_form, "gci>=0.62")
    (loop,) = candidates.region.region.loops
    designs = design_space.unproject(loop)
    values = closed_form_atlas.conditioning(designs)
    expected = np.abs(values / 0.62 - 1.0).max()
    assert candidates.interpolation_error() == pytest.approx(expected, rel=1e-6)
    assert candidates.refined().interpolation_error == candidates.interpolation_error()


def test_a_region_bounded_by_parameters_is_exact_before(closed_form: Atlas) -> None:
    candidates = under(closed_form, "r1>=1.01", "r1<=1.52", "r3<=0.203")
    refined = candidates.refined()
    assert refined.interpolation_error < 1e-12
    assert refined.area == pytest.approx(candidates.region.region.area, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "conditions"),
    [
        ("gci", ()),
        ("gci", ("usable_workspace_area>=24",)),
        ("usable_workspace_area", ("gci>=0.6",)),
        ("-usable_workspace_area", ("gci>=0.6", "r2<=1.7")),
        ("gci:1,usable_workspace_area:0.5", ("r3>=0.05",)),
        ("gci:1,usable_workspace_area:3", ("gci>=0.5", "r1<=1.45")),
        ("r3", ("gci>=0.4", "usable_workspace_area>=15")),
        ("max_lci", ()),
        ("max_lci:2,gci:1", ("usable_workspace_area>=20",)),
    ],
)
def test_the_maximum_beats_random_designs(
    closed_form: Atlas, text: str, conditions: tuple[str, ...]
) -> None:
    known = (*KNOWN, "max_lci")
    candidates = under(closed_form, *conditions)
    objective = candidates.normalised(parse_objective(text, known))
    found = candidates.maximise(objective)
    assert found is not None
    designs = np.vstack(
        [random_designs(200_000, 3), design_space.unproject(found.point[np.newaxis])]
    )
    columns = dict(zip(("r1", "r2", "r3"), designs.T, strict=True)) | {
        "gci": closed_form_atlas.conditioning(designs),
        "usable_workspace_area": closed_form_atlas.area(designs),
        "max_lci": closed_form_mechanism.kink(designs),
    }
    margins = [
        (columns[each.quantity] - each.bound) * (1.0 if each.operator == ">=" else -1.0)
        for each in candidates.conditions
    ]
    feasible = np.all(np.array(margins).reshape(-1, len(designs)) >= -1e-10, axis=0)
    values = objective.value(np.array([columns[name] for name in objective.names]))
    assert feasible[-1]
    assert values[-1] == pytest.approx(found.value, rel=1e-12)
    assert np.count_nonzero(feasible) > 100
    assert values[-1] >= values[feasible].max()
    again = candidates.maximise(objective)
    assert again is not None
    assert np.array_equal(again.point, found.point)


def test_known_maxima_and_what_is_active_there(closed_form: Atlas) -> None:
    summit = under(closed_form).maximise(Objective(("gci",), (1.0,)))
    assert summit is not None
    assert summit.borders == ("r3 = 0",)
    assert summit.active == ()
    np.testing.assert_allclose(design_space.unproject(summit.point), [1.3, 1.7, 0.0], atol=1e-5)
    assert summit.value == pytest.approx(0.67, abs=1e-10)

    top = under(closed_form).maximise(Objective(("max_lci",), (1.0,)))
    assert top is not None  # a kink where no gradient exists
    assert top.value == pytest.approx(1.0, abs=1e-7)

    # the highest point of a parabola: r3 = log(0.67/0.6)/1.5
    candidates = under(closed_form, "gci>=0.6")
    highest = candidates.maximise(Objective(("r3",), (1.0,)))
    assert highest is not None
    assert [str(condition) for condition in highest.active] == ["gci>=0.6"]
    assert highest.value == pytest.approx(math.log(0.67 / 0.6) / 1.5, abs=1e-9)


def test_local_maxima_are_those_that_a_loop_finds(closed_form: Atlas) -> None:
    candidates = under(closed_form)
    rng = np.random.default_rng(4)
    values = rng.normal(size=len(closed_form))
    values[rng.random(len(values)) < 0.1] = np.nan
    feasible = rng.random(len(values)) < 0.7
    neighbours: dict[int, set[int]] = {}
    for triangle in candidates.triangles.tolist():
        for place in triangle:
            neighbours.setdefault(place, set()).update(triangle)
    usable = {i for i in range(len(values)) if feasible[i] and np.isfinite(values[i])}
    expected = {i for i in usable if all(values[i] >= values[j] for j in neighbours[i] & usable)}
    found = local_maxima(values, feasible, candidates.triangles, len(values))
    assert set(found.tolist()) == expected
    assert (np.diff(values[found]) <= 0.0).all()


def test_emptiness_names_the_conditions_that_exclude_each_other(closed_form: Atlas) -> None:
    alone = under(closed_form, "usable_workspace_area>=20", "gci>=0.7", "r1<=2")
    assert alone.is_empty
    conflict = explain_emptiness(alone)
    assert [str(condition) for condition in conflict.conditions] == ["gci>=0.7"]
    area, gci, r1 = conflict.reaches
    assert area.among is None
    assert area.alone == pytest.approx(27.0, abs=1e-9)  # 12 r1 r2 at r1 = r2 = 1.5
    assert r1.among is None
    assert gci.among == pytest.approx(0.67, abs=1e-9)
    assert not conflict.is_met

    pair = under(closed_form, "r3<=1", "usable_workspace_area>=26.9", "gci>=0.665")
    assert pair.is_empty
    conflict = explain_emptiness(pair)
    assert [str(each) for each in conflict.conditions] == [
        "usable_workspace_area>=26.9",
        "gci>=0.665",
    ]
    _, area, gci = conflict.reaches
    designs = random_designs(400_000, 5)
    designs[:, 2] *= 1e-2  # both are largest near r3 = 0
    designs[:, :2] *= ((3.0 - designs[:, 2]) / designs[:, :2].sum(axis=1))[:, np.newaxis]
    areas, indices = closed_form_atlas.area(designs), closed_form_atlas.conditioning(designs)
    assert area.among is not None
    assert gci.among is not None
    assert areas[indices >= 0.665].max() <= area.among < areas[indices >= 0.665].max() + 0.05
    assert indices[areas >= 26.9].max() <= gci.among < indices[areas >= 26.9].max() + 0.01


def test_three_conditions_may_exclude_each_other_only_together(closed_form: Atlas) -> None:
    three = under(closed_form, "r1>=1", "r2>=1", "r3>=0.5", "gci>=0.3", "r1>=1.2", "r2>=1.4")
    assert three.is_empty
    conflict = explain_emptiness(three)
    assert [str(each) for each in conflict.conditions] == ["r3>=0.5", "r1>=1.2", "r2>=1.4"]


def test_exact_values_may_reach_what_the_lattice_misses(closed_form: Atlas) -> None:
    sharp = under(closed_form, "max_lci>=0.9999")
    assert sharp.is_empty
    conflict = explain_emptiness(sharp)
    assert conflict.is_met
    found = sharp.maximise(Objective(("max_lci",), (1.0,)), near=conflict.met_designs)
    assert found is not None
    assert found.value == pytest.approx(1.0, abs=1e-7)


def test_a_search_leaves_the_summit_of_a_bounded_quantity(closed_form: Atlas) -> None:
    bound = 0.67 - 1e-6
    found = maximise(
        under(closed_form).exact(["gci", "r1"]),
        Objective(("r1",), (1.0,)),
        [parse_condition(f"gci>={bound!r}")],
        np.array([bound]),
        design_space.project(np.array([[1.3, 1.7, 0.0]])),
    )
    assert found is not None
    assert found.value == pytest.approx(1.3 + math.sqrt(math.log(0.67 / bound)), abs=1e-7)
    assert [str(condition) for condition in found.active] == [f"gci>={bound:.12g}"]


def test_the_best_gci_of_the_five_bar(five_bar: Atlas) -> None:
    found = under(five_bar).maximise(Objective(("gci",), (1.0,)))
    assert found is not None
    assert found.value == pytest.approx(0.67415286, abs=1e-8)
    np.testing.assert_allclose(
        design_space.unproject(found.point), [1.288, 1.687, 0.025], atol=1e-3
    )
    on_axis = under(five_bar, "r3<=0").maximise(Objective(("gci",), (1.0,)))
    assert on_axis is not None
    assert on_axis.value == pytest.approx(0.67120723, abs=1e-8)


def test_the_five_bar_beats_random_designs(five_bar: Atlas) -> None:
    candidates = under(five_bar, "usable_workspace_area>=20", "gci>=0.55")
    objective = candidates.normalised(
        parse_objective("good_condition_workspace_area:1,gci:0.3", [*five_bar.names])
    )
    found = candidates.maximise(objective)
    assert found is not None
    designs = random_designs(1500, 6)
    exact = candidates.exact(objective.names)
    values = exact.values(design_space.project(designs))
    rows = {name: values[exact.names.index(name)] for name in exact.names}
    feasible = (rows["usable_workspace_area"] >= 20.0) & (rows["gci"] >= 0.55)
    totals = objective.value(np.array([rows[name] for name in objective.names]))
    assert feasible.sum() > 10
    assert found.value > totals[feasible].max()


@pytest.fixture(scope="module")
def coarse(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Atlas]:
    """Return a five-bar atlas of a coarse lattice in two mode pairs."""
    settings = SweepSettings("five-bar", "surrounded", 24, ("+-/down", "++/up"), (0.3, 0.5), 1e-6)
    mechanism = mechanisms.get(settings.mechanism)
    designs = mechanism.lattice(settings.space, settings.resolution)
    path = tmp_path_factory.mktemp("optimum") / "coarse.h5"
    with AtlasWriter(path, settings, designs, [(0, len(designs))]) as writer:
        writer.add(0, mechanism.evaluate(designs, settings))
        writer.assemble()
    with open_atlas(path) as opened:
        yield opened


@pytest.mark.parametrize(
    ("mode", "conditions", "text"),
    [
        ("+-/down", ("r1<=1.4",), "mic_upper_radius:1,gci:1"),
        ("+-/down", ("gci>=0.2", "r2<=1.3"), "mic_upper_radius"),
        ("++/up", ("usable_workspace_area>=3",), "gci"),
        ("++/up", ("r3>=0.3",), "good_condition_workspace_area:1,-r1:0.5"),
    ],
)
def test_a_coarse_lattice_hides_no_optimum(
    coarse: Atlas, mode: str, conditions: tuple[str, ...], text: str
) -> None:
    candidates = Candidates(coarse, [parse_condition(each) for each in conditions], mode, 0.5)
    objective = candidates.normalised(parse_objective(text, coarse.names))
    found = candidates.maximise(objective)
    assert found is not None
    near_border = random_designs(2000, 8)
    near_border[:1000, 2] = near_border[:1000, 1]  # r2 = r3, or almost
    near_border[500:1000, 2] -= np.random.default_rng(9).exponential(1e-3, 500)
    near_border[1000:, 2] *= 0.1
    near_border *= 3.0 / near_border.sum(axis=1, keepdims=True)
    around = design_space.unproject(
        found.point + np.random.default_rng(10).normal(0.0, 3e-3, (1000, 2))
    )
    designs = np.vstack([random_designs(2000, 7), near_border, around])
    r1, r2, r3 = designs.T
    designs = designs[(r1 > 0.0) & (r2 > 0.0) & (r3 >= 0.0) & (r1 >= r3) & (r2 >= r3)]
    settings = dataclasses.replace(coarse.settings, modes=(mode,), lci_thresholds=(0.5,))
    results = coarse.mechanism.evaluate(designs, settings)
    columns = {name: np.reshape(each, len(designs)) for name, each in results.items()}
    columns |= dict(zip(("r1", "r2", "r3"), designs.T, strict=True))
    feasible = np.ones(len(designs), dtype=np.bool_)
    for each in candidates.conditions:
        sign = 1.0 if each.operator == ">=" else -1.0
        feasible &= sign * (columns[each.quantity] - each.bound) >= 0.0
    totals = objective.value(np.array([columns[name] for name in objective.names]))
    assert np.count_nonzero(feasible) > 100
    # the values compared are those of a tolerance of 1e-6
    assert found.value >= np.nanmax(totals[feasible]) - 1e-6


@pytest.mark.parametrize(
    ("texts", "objective"),
    [
        ((), Objective(("gci",), (-1.0,))),
        ((), Objective(("max_lci",), (-1.0,))),
        ((), Objective(("r1",), (1.0,))),
        ((), Objective(("usable_workspace_area",), (-1.0,))),
        (("r2<=0.8",), Objective(("max_lci_y",), (1.0,))),
    ],
)
def test_what_is_no_design_is_no_optimum(
    five_bar: Atlas, texts: tuple[str, ...], objective: Objective
) -> None:
    found = under(five_bar, *texts).maximise(objective)
    assert found is not None
    assert not found.is_attained
    assert math.isfinite(found.value)
    design = design_space.unproject(found.point)
    normalised, _ = design_space.normalise(design.tolist())
    assert normalised == pytest.approx(design)
    # it is closer to the corner than all of the lattice
    assert min(design[:2]) < 1e-5
    stored = five_bar.select(objective.names[0])
    assert found.value > np.max(objective.value(stored[np.newaxis]))


def test_a_design_that_was_found_fulfils_conditions_to_the_last_digit(five_bar: Atlas) -> None:
    for texts, text in (
        (("usable_workspace_area<=20", "r1>=1.31"), "gci"),
        (("gci>=0.6", "r1<=1.37"), "usable_workspace_area"),
        (("mic_upper_radius<=1.1", "r3>=0.07"), "r1"),
        (("usable_workspace_area<20", "r1>1.01"), "usable_workspace_area"),
    ):
        candidates = under(five_bar, *texts)
        found = candidates.maximise(parse_objective(text, five_bar.names))
        assert found is not None
        assert found.active
        exact = candidates.exact()
        values = exact.values(found.point[np.newaxis])[:, 0]
        for condition in candidates.conditions:
            value = values[exact.names.index(condition.quantity)]
            above, is_equal = value > condition.bound, value == condition.bound
            assert above == (condition.operator[0] == ">") or (
                is_equal and condition.operator.endswith("=")
            )


def test_a_refined_outline_of_the_five_bar_lies_on_level_sets(five_bar: Atlas) -> None:
    candidates = under(five_bar, "gci>=0.62", "usable_workspace_area>=24")
    refined = candidates.refined()
    assert refined.unmoved == 0
    (loop,) = refined.loops
    designs = design_space.unproject(loop)
    results = five_bar.mechanism.evaluate(designs, five_bar.settings)  # at its own tolerance
    gci, area = (
        results["gci"][:, 0] / 0.62 - 1.0,
        results["usable_workspace_area"][:, 0] / 24.0 - 1.0,
    )
    error = results["gci_error"][:, 0] / 0.62 + 1e-8
    touched = (np.abs(gci) <= error) | (np.abs(area) <= 1e-8) | (designs[:, 2] == 0.0)
    assert touched.all()
    assert (gci >= -error).all()
    assert (area >= -1e-8).all()


@pytest.mark.parametrize(
    ("texts", "contradict"),
    [
        (("gci>0.7", "gci<0.6"), True),
        (("gci>0.6", "gci<0.6"), True),
        (("gci>=0.6", "gci<0.6"), True),
        (("gci>=0.6", "gci<=0.6"), False),
        (("gci>=0.6", "r3<=0.1", "gci>0.9"), False),
        (("r1<=1", "gci>=0.5", "r1>=1.5"), True),
    ],
)
def test_contradictory_conditions_are_found(texts: tuple[str, ...], contradict: bool) -> None:
    conditions = [parse_condition(text) for text in texts]
    if contradict:
        with pytest.raises(InputError, match="contradict"):
            check_contradictions(conditions)
    else:
        check_contradictions(conditions)


def test_objectives_are_read() -> None:
    assert parse_objective("gci", KNOWN) == Objective(("gci",), (1.0,))
    assert parse_objective(" gci:1 , usable_workspace_area: 0.5", KNOWN) == Objective(
        ("gci", "usable_workspace_area"), (1.0, 0.5)
    )
    assert parse_objective("-r3:2,gci", KNOWN).weights == (-2.0, 1.0)


@pytest.mark.parametrize(
    "text", ["", "gci:", "gci:x", "gci:nan", "gci:0", "gci:inf", "gci,gci", "gci;r3", "2*gci", ":1"]
)
def test_other_objectives_are_refused(text: str) -> None:
    with pytest.raises(InputError):
        parse_objective(text, KNOWN)


def test_an_unknown_objective_lists_what_there_is() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'gci'"):
        parse_objective("gcii", KNOWN)


def test_a_sum_is_normalised_by_what_fulfils_the_conditions(closed_form: Atlas) -> None:
    candidates = under(closed_form, "gci>=0.6")
    objective = candidates.normalised(parse_objective("gci:1,usable_workspace_area:2", KNOWN))
    chosen = closed_form_atlas.conditioning(closed_form.designs) >= 0.6
    designs = closed_form.designs[chosen]
    expected = 0.0
    for weight, values in (
        (1.0, closed_form_atlas.conditioning(designs)),
        (2.0, closed_form_atlas.area(designs)),
    ):
        expected = expected + weight * (values - values.min()) / (values.max() - values.min())
    found = objective.value(candidates.values(objective.names)[:, chosen])
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert candidates.best_designs(objective, 1)[0] == np.flatnonzero(chosen)[expected.argmax()]


def test_rounding_is_no_range_to_normalise_by() -> None:
    objective = Objective(("max_lci", "r3"), (1.0, 1.0))
    values = np.array([[1.0, 1.0 - 3e-16, 1.0 + 2e-16], [0.0, 0.5, 0.25]])
    totals = objective.normalised(values).value(values)
    np.testing.assert_allclose(totals, [0.0, 1.0, 0.5], atol=1e-15)


def test_error_estimates_have_no_exact_values(closed_form: Atlas) -> None:
    candidates = under(closed_form, "gci_error<=1e-5")
    assert math.isnan(candidates.interpolation_error())
    with pytest.raises(InputError, match="error estimates belong to the file"):
        candidates.exact()
