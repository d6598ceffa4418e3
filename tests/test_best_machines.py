"""The best machines: closed forms, brute force by an independent oracle, limits, ranking."""

from __future__ import annotations

import dataclasses
import math

import naive
import numpy as np
import pytest

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InfeasibleSizeError, InputError, UnknownNameError
from fivebar_atlas.synthesis.best_machines import RankedMachine, best_machines
from fivebar_atlas.synthesis.containment import INSIDE, ActuatorRange
from fivebar_atlas.synthesis.link_limits import LinkLimit
from fivebar_atlas.synthesis.machine_goals import GOALS, goal_named
from fivebar_atlas.synthesis.machine_search import MachineTask
from fivebar_atlas.synthesis.placement import FREE
from fivebar_atlas.synthesis.shapes import Shape

FIVE_BAR = mechanisms.get("five-bar")
RECTANGLE = Shape.rectangle(300.0, 200.0)
SIGNS = {"+": 1, "-": -1, "up": 1, "down": -1}


def task(**changes: object) -> MachineTask:
    whole = MachineTask(FIVE_BAR, RECTANGLE, goal_named("links"), FIVE_BAR.modes)
    return dataclasses.replace(whole, **changes)  # type: ignore[arg-type]


def signs_of(mode: str) -> tuple[int, int, int]:
    working, assembly = mode.split("/")
    return SIGNS[working[0]], SIGNS[working[1]], SIGNS[assembly]


def naive_margins(
    lengths: np.ndarray, mode: str, threshold: float, points: np.ndarray
) -> np.ndarray:
    """LCI less its threshold in a mode pair; -threshold where there is none."""
    s1, s2, assembly = signs_of(mode)
    x, y = points[..., 0].ravel(), points[..., 1].ravel()
    with np.errstate(all="ignore"):
        lci = naive.lci(*lengths, x, y, s1, s2)
        sign = naive.det_b(*lengths, x, y, s1, s2) * assembly
    good = np.isfinite(lci) & (sign > 0.0)
    return (np.where(good, lci, 0.0) - threshold).reshape(points.shape[:-1])


@pytest.fixture(scope="module")
def smallest() -> list[RankedMachine]:
    return best_machines(task())


def test_the_best_machine_of_all_has_a_closed_form(smallest: list[RankedMachine]) -> None:
    # r3 = 0, and the ring of least LCI at the radius sqrt(r2^2 - r1^2) has just the threshold
    best = smallest[0]
    r1, r2, r3 = (length / best.machine.factor for length in best.machine.lengths.values())
    assert r3 == 0.0
    assert r1 / r2 == pytest.approx(2.0 / math.sqrt(5.0), rel=1e-8)
    ratio = 2.0 / math.sqrt(5.0)
    r2 = 3.0 / (1.0 + ratio)
    r1 = ratio * r2
    middle, half = 2.0 * r2 / math.sqrt(5.0), math.sqrt(r1 * r1 - 0.2 * r2 * r2)
    inner, outer = middle - half, middle + half
    # upper corners on the outer circle, the lower side touches the inner one
    scale = np.roots([150.0**2 + 200.0**2, 400.0 * inner, inner**2 - outer**2]).max()
    assert best.value == pytest.approx(2.0 * (r1 + r2) / scale, rel=5e-9)
    assert abs(best.machine.position[1]) == pytest.approx(inner / scale + 100.0, rel=1e-7)  # type: ignore[index]
    assert "r3 = 0" in best.active
    assert "LCI inside" in best.active


def test_machines_are_ranked_distinct_and_proved(smallest: list[RankedMachine]) -> None:
    values = [each.value for each in smallest]
    assert len(values) == 3
    assert values == sorted(values)
    lengths = [np.array([*each.machine.lengths.values()]) for each in smallest]
    for place, one in enumerate(lengths):
        for other in lengths[place + 1 :]:
            assert np.abs(one - other).max() > 0.01 * max(one.max(), other.max()) / 3.0
    for each in smallest:
        fit = each.machine.fit
        assert fit is not None
        assert fit.proof.verdict == INSIDE
        assert 0.0 <= each.margins["LCI"] < 1e-8
        position = np.array(each.machine.position) / each.machine.factor
        x, y = np.meshgrid(np.linspace(-150, 150, 201), np.linspace(-100, 100, 201))
        points = position + np.stack([x, y], axis=-1) / each.machine.factor
        shares = np.array([*each.machine.lengths.values()]) / each.machine.factor
        assert naive_margins(shares, each.machine.good.mode, 0.5, points).min() >= 0.0


def test_no_random_design_is_better(smallest: list[RankedMachine]) -> None:
    best = smallest[0]
    own = np.array([*best.machine.lengths.values()]) / best.machine.factor
    rng = np.random.default_rng(71)
    r3 = 1.5 * rng.random(300)
    r1 = 3.0 * rng.random(300)
    designs = np.column_stack([r1, 3.0 - r1 - r3, r3])
    steps = rng.normal(size=(200, 2)) * 10.0 ** rng.uniform(-4.0, -1.0, (200, 1))
    near = own + np.column_stack([steps[:, 0], -steps.sum(axis=1), steps[:, 1]])
    designs = np.concatenate([designs, near])
    designs = designs[(designs[:, 1] > 0.0) & (designs[:, 0] > 0.0) & (designs[:, 2] >= 0.0)]
    assert len(designs) > 250
    few = np.concatenate([RECTANGLE.corners, RECTANGLE.boundary(RECTANGLE.boundary_samples(24))])
    many = np.concatenate(
        [RECTANGLE.boundary(RECTANGLE.boundary_samples(600)), RECTANGLE.interior_samples(3000)]
    )
    for design in designs:
        # the scale at which it would be better by a millionth
        scale = 2.0 * (design[0] + design[1]) / (best.value * (1.0 - 1e-6))
        reach = design[0] + design[1]
        centres = np.column_stack([np.zeros(160), np.linspace(-reach, reach, 160)])
        for mode in ("+-/up", "+-/down", "++/up"):
            margins = naive_margins(design, mode, 0.5, centres[:, None] + scale * few)
            for centre in centres[np.all(margins >= 0.0, axis=1)]:
                assert np.any(naive_margins(design, mode, 0.5, centre + scale * many) < 0.0)


@pytest.mark.parametrize("name", [goal for goal in GOALS if goal != "links"])
def test_other_goals_are_what_they_say_and_no_worse_than_the_best_of_links(
    name: str, smallest: list[RankedMachine]
) -> None:
    goal = goal_named(name)
    found = best_machines(task(goal=goal, modes=("+-/up", "+-/down")), 1)[0]

    def value(ranked: RankedMachine) -> float:
        """Return the goal by finite differences and elbows of the oracle, on a grid."""
        machine = ranked.machine
        lengths = np.array([*machine.lengths.values()])
        s1, s2, _ = signs_of(machine.good.mode)
        x, y = np.meshgrid(np.linspace(-150, 150, 241), np.linspace(-100, 100, 161))
        points = np.column_stack([x.ravel(), y.ravel()]) + machine.position
        thetas = np.stack(naive.inverse_kinematics(*lengths, *points.T, s1, s2))
        if name == "actuated-link":
            return float(lengths[0])
        if name == "footprint":
            elbows = lengths[0] * np.stack([np.cos(thetas), np.sin(thetas)])
            base = np.array([[-lengths[2]], [lengths[2]]])
            xs = np.concatenate([(elbows[0] + base).ravel(), points[:, 0], base.ravel()])
            ys = np.concatenate([elbows[1].ravel(), points[:, 1], [0.0]])
            return float(np.ptp(xs) * np.ptp(ys))
        step = 1e-5
        rates = []
        for move in ((step, 0.0), (0.0, step)):
            after = np.stack(naive.inverse_kinematics(*lengths, *(points + move).T, s1, s2))
            before = np.stack(naive.inverse_kinematics(*lengths, *(points - move).T, s1, s2))
            turn = np.remainder(after - before + np.pi, 2.0 * np.pi) - np.pi
            rates.append(turn / (2.0 * step))
        moves = np.linalg.inv(np.stack(rates, axis=-1).transpose(1, 0, 2))
        if name == "error":
            signs = 1e-4 * np.array([[1.0, 1.0], [1.0, -1.0]])
            return float(np.linalg.norm(moves @ signs, axis=1).max())
        return float(np.linalg.norm(moves, axis=1).max())

    assert found.value == pytest.approx(value(found), rel=2e-4)
    assert found.value <= value(smallest[0]) * (1.0 + 1e-4)
    assert found.machine.fit is not None
    assert found.machine.fit.proof.verdict == INSIDE


def test_limits_are_kept_and_named() -> None:
    ranges = (
        ActuatorRange(1, math.radians(60.0), math.radians(200.0)),
        ActuatorRange(2, math.radians(-20.0), math.radians(120.0)),
    )
    limits = (LinkLimit("R3", 40.0, math.inf), LinkLimit("R2", 0.0, 300.0))
    free = best_machines(task(limits=limits), 1)[0]
    found = best_machines(task(ranges=ranges, limits=limits), 1)[0]
    assert found.value >= free.value * (1.0 - 1e-7)
    machine = found.machine
    lengths = machine.lengths
    assert lengths["R3"] >= 40.0 * (1.0 - 1e-12)
    assert lengths["R2"] <= 300.0 * (1.0 + 1e-8)
    assert "R3 least" in found.active
    s1, s2, _ = signs_of(machine.good.mode)
    x, y = np.meshgrid(np.linspace(-150, 150, 241), np.linspace(-100, 100, 161))
    points = np.column_stack([x.ravel(), y.ravel()]) + machine.position
    angles = np.degrees(naive.inverse_kinematics(*lengths.values(), *points.T, s1, s2))
    for row, (least, greatest) in zip(angles, ((60.0, 200.0), (-20.0, 120.0)), strict=True):
        middle = 0.5 * (least + greatest)
        off = np.remainder(row - middle + 180.0, 360.0) - 180.0
        assert off.min() >= least - middle - 1e-6
        assert off.max() <= greatest - middle + 1e-6
    for name, margin in found.margins.items():
        assert margin >= -1e-6, name


def test_a_free_placement_is_no_worse_and_a_polygon_is_placed() -> None:
    triangle = Shape.polygon([[0.0, 0.0], [200.0, 0.0], [40.0, 160.0]], 5.0)
    on_axis = best_machines(task(shape=triangle, modes=("+-/up",)), 1)[0]
    free = best_machines(task(shape=triangle, modes=("+-/up",), placement=FREE), 1)[0]
    assert free.value <= on_axis.value * (1.0 + 1e-7)
    assert free.value < 0.999 * on_axis.value
    assert on_axis.machine.position is not None
    assert on_axis.machine.position[0] == 0.0


def test_the_same_task_gives_the_same_machines(smallest: list[RankedMachine]) -> None:
    again = best_machines(task())
    assert [each.document() for each in again] == [each.document() for each in smallest]


def test_what_excludes_all_machines_is_named() -> None:
    with pytest.raises(InfeasibleSizeError, match="one is found without R1 from 0 to 20 mm"):
        best_machines(task(limits=(LinkLimit("R1", 0.0, 20.0),)))
    ranges = (
        ActuatorRange(1, 0.0, math.radians(2.0)),
        ActuatorRange(2, 0.0, math.radians(2.0)),
    )
    with pytest.raises(InfeasibleSizeError, match="one is found without the actuator ranges"):
        best_machines(task(ranges=ranges, modes=("++/up",)))


def test_wrong_tasks_are_refused() -> None:
    with pytest.raises(InputError, match="actuator range: 3"):
        task(ranges=(ActuatorRange(3, 0.0, 1.0),))
    with pytest.raises(InputError, match="lci"):
        task(lci_threshold=1.0)
    with pytest.raises(UnknownNameError, match="link limit: 'R9'"):
        task(limits=(LinkLimit("R9", 0.0, 1.0),))
    with pytest.raises(UnknownNameError, match="placement"):
        task(placement="somewhere")
    with pytest.raises(UnknownNameError, match="mode"):
        task(modes=("sideways",))
    with pytest.raises(InputError, match="at least one mode pair"):
        task(modes=())
    with pytest.raises(UnknownNameError, match="space"):
        task(space="outer")
    with pytest.raises(UnknownNameError, match="goal: 'mass'"):
        goal_named("mass")
