"""Machines for practical workspaces: the paper's example, worst cases, what is refused."""

from __future__ import annotations

import math

import naive
import numpy as np
import pytest
from scipy import ndimage

from fivebar_atlas import planar_design
from fivebar_atlas.errors import InfeasibleSizeError, InputError, UnknownNameError
from fivebar_atlas.synthesis.containment import INSIDE, ActuatorRange
from fivebar_atlas.synthesis.link_limits import LinkLimit
from fivebar_atlas.synthesis.shapes import Shape
from fivebar_atlas.synthesis.sizing import Machine, size_for_area, size_for_shape

PAPER = (1.28, 1.72, 0.0)
SMALL = (1.08, 1.25, 0.67)


def degrees(least: float, greatest: float) -> tuple[float, float]:
    return math.radians(least), math.radians(greatest)


@pytest.fixture(scope="module")
def rectangle() -> Machine:
    return size_for_shape(planar_design(*SMALL, unit=""), Shape.rectangle(300.0, 200.0), "+-/up")


def naive_moves(machine: Machine, points: np.ndarray) -> np.ndarray:
    """Inverse Jacobian matrices of the machine by finite differences of inputs."""
    r1, r2, r3 = machine.lengths.values()
    step = 1e-6 * machine.factor
    columns = []
    for dx, dy in ((step, 0.0), (0.0, step)):
        after = naive.inverse_kinematics(r1, r2, r3, points[:, 0] + dx, points[:, 1] + dy, 1, -1)
        before = naive.inverse_kinematics(r1, r2, r3, points[:, 0] - dx, points[:, 1] - dy, 1, -1)
        rate = (np.stack(after) - np.stack(before)) / (2.0 * step)
        columns.append(rate)
    return np.linalg.inv(np.stack(columns, axis=-1).transpose(1, 0, 2))


def shape_grid(machine: Machine, width: float, height: float, count: int) -> np.ndarray:
    """Points of a rectangle in lengths of the machine, its boundary with them."""
    assert machine.position is not None
    x, y = np.meshgrid(
        np.linspace(-0.5, 0.5, count) * width, np.linspace(-0.5, 0.5, count) * height
    )
    return np.column_stack([x.ravel(), y.ravel()]) + machine.position


def test_the_example_of_the_paper() -> None:
    machine = size_for_area(planar_design(*PAPER, unit=""), 400.0, "+-/up", 0.5)
    # between circles of radii 2 r2/sqrt(5) -+ sqrt(r1^2 - r2^2/5)
    middle, half = 2.0 * 1.72 / math.sqrt(5.0), math.sqrt(1.28**2 - 1.72**2 / 5.0)
    area = math.pi * ((middle + half) ** 2 - (middle - half) ** 2)
    assert area == pytest.approx(19.7787, abs=5e-5)
    assert machine.factor == pytest.approx(math.sqrt(400.0 / area), rel=1e-9)
    assert abs(machine.factor - math.sqrt(400.0 / area)) <= machine.factor_error + 1e-15
    # printed 4.5, 5.76, 7.74 and 0: the lengths there are those of the rounded factor
    assert round(machine.factor, 1) == 4.5
    assert [round(4.5 * r, 2) for r in PAPER] == [5.76, 7.74, 0.0]
    assert list(machine.lengths.values()) == pytest.approx([5.7562637, 7.7349794, 0.0], abs=1e-7)
    for each in machine.input_ranges:
        assert each.is_full_turn
        assert (math.degrees(each.least), math.degrees(each.greatest)) == (0.0, 360.0)
    settings, results = machine.evaluation
    assert settings.lci_thresholds == (0.5,)
    assert results["good_condition_workspace_area"][0, 0, 0] == pytest.approx(area, rel=1e-9)


def test_a_rounded_factor_gives_the_printed_lengths() -> None:
    design = planar_design(*PAPER, unit="")
    machine = size_for_area(design, 400.0, "+-/up", 0.5, factor_step=0.1)
    assert machine.factor == 4.5
    assert list(machine.lengths.values()) == pytest.approx([5.76, 7.74, 0.0], abs=1e-12)
    shape = Shape.rectangle(300.0, 200.0)
    exact = size_for_shape(design, shape, "+-/up")
    machine = size_for_shape(design, shape, "+-/up", factor_step=5.0)
    assert machine.factor == 5.0 * math.ceil(exact.factor / 5.0)
    assert machine.fit is not None
    assert machine.fit.proof.verdict == INSIDE
    with pytest.raises(InputError, match="factor step"):
        size_for_area(design, 400.0, "+-/up", 0.5, factor_step=0.0)


@pytest.mark.parametrize(("mode", "signs"), [("+-/up", (1, -1)), ("-+/down", (-1, 1))])
def test_input_ranges_over_a_good_condition_workspace(mode: str, signs: tuple[int, int]) -> None:
    machine = size_for_area(planar_design(*SMALL, unit=""), 400.0, mode, 0.5)
    lines = np.linspace(-2.5, 2.5, 1201)
    x, y = (each.ravel() for each in np.meshgrid(lines, lines))
    inside = machine.good.margins(np.column_stack([x, y])) >= 0.0
    inputs = naive.inverse_kinematics(*SMALL, x[inside], y[inside], *signs)
    for each, angles in zip(machine.input_ranges, inputs, strict=True):
        # the largest gap between sorted angles is what is left out of a full turn
        turned = np.sort(np.mod(angles, 2.0 * math.pi))
        gaps = np.diff(np.append(turned, turned[0] + 2.0 * math.pi))
        span = 2.0 * math.pi - gaps.max()
        assert each.greatest - each.least == pytest.approx(span, abs=0.02)
        assert each.greatest - each.least >= span
        assert each.at_least is not None
        assert each.at_greatest is not None
        for angle, place in ((each.least, each.at_least), (each.greatest, each.at_greatest)):
            point = np.array(place) / machine.factor
            index = naive.lci(*SMALL, *point, *signs)
            assert float(index) == pytest.approx(0.5, abs=1e-6)
            there = naive.inverse_kinematics(*SMALL, *point, *signs)[each.number - 1]
            assert math.cos(float(there) - angle) == pytest.approx(1.0, abs=1e-12)


def test_indices_scale_with_the_machine(rectangle: Machine) -> None:
    document = rectangle.document()
    factor = rectangle.factor
    plain, scaled = document["indices"]["modes"][0], document["indices"]["dimensional"]["modes"][0]
    area = plain["good_condition"][0]["area"]
    assert scaled["good_condition"][0]["area"] == pytest.approx(factor**2 * area, rel=1e-12)
    assert document["R1"] == pytest.approx(factor * 1.08, rel=1e-12)
    assert document["shape"]["is_proved"]
    assert rectangle.design.parameters[1] == ("$R_2$", pytest.approx(factor * 1.25, rel=1e-12))


def test_input_ranges_over_a_rectangle(rectangle: Machine) -> None:
    points = shape_grid(rectangle, 300.0, 200.0, 401)
    inputs = naive.inverse_kinematics(*rectangle.lengths.values(), *points.T, 1, -1)
    for each, angles in zip(rectangle.input_ranges, inputs, strict=True):
        middle = 0.5 * (each.least + each.greatest)
        off = np.remainder(angles - middle + math.pi, 2.0 * math.pi) - math.pi
        assert not each.is_full_turn
        assert middle + off.min() == pytest.approx(each.least, abs=1e-5)
        assert middle + off.max() == pytest.approx(each.greatest, abs=1e-5)
        assert middle + off.min() >= each.least - 1e-12
        assert middle + off.max() <= each.greatest + 1e-12


def test_the_largest_positioning_error_is_found(rectangle: Machine) -> None:
    resolution = math.radians(0.01)
    found = rectangle.positioning_error(resolution)
    points = shape_grid(rectangle, 300.0, 200.0, 401)
    corners = resolution * np.array([[1.0, 1.0], [1.0, -1.0]])
    errors = np.linalg.norm(naive_moves(rectangle, points) @ corners.T, axis=1).max(axis=1)
    assert errors.max() <= found.value * (1.0 + 1e-6)
    assert errors.max() == pytest.approx(found.value, rel=1e-5)
    at = naive_moves(rectangle, np.array([found.position])) @ corners.T
    assert np.linalg.norm(at, axis=1).max() == pytest.approx(found.value, rel=1e-6)


def test_small_errors_of_encoders_move_the_output_point_no_farther(rectangle: Machine) -> None:
    resolution = 1e-7
    found = rectangle.positioning_error(resolution)
    lengths = tuple(rectangle.lengths.values())
    inputs = naive.inverse_kinematics(*lengths, *found.position, 1, -1)
    moved = []
    for one in (-resolution, resolution):
        for two in (-resolution, resolution):
            x, y = naive.forward_kinematics(*lengths, inputs[0] + one, inputs[1] + two, 1)
            moved.append(math.hypot(x - found.position[0], y - found.position[1]))
    assert max(moved) == pytest.approx(found.value, rel=1e-5)


def test_the_largest_torque_balances_virtual_work(rectangle: Machine) -> None:
    force = 10.0
    found = rectangle.joint_torque(force)
    points = shape_grid(rectangle, 300.0, 200.0, 401)
    moves = naive_moves(rectangle, points)
    directions = np.linspace(0.0, math.pi, 721)
    forces = force * np.stack([np.cos(directions), np.sin(directions)])
    # the work of a torque on a small turn is that of the force on the way of the point
    torques = np.abs(moves.transpose(0, 2, 1)[::40] @ forces)
    exact = force * np.linalg.norm(moves, axis=1).max(axis=1)
    assert torques.max(axis=(1, 2)) == pytest.approx(exact[::40], rel=1e-5)
    assert exact.max() <= found.value * (1.0 + 1e-6)
    assert exact.max() == pytest.approx(found.value, rel=1e-5)


def test_worst_cases_over_a_good_condition_workspace() -> None:
    machine = size_for_area(planar_design(*SMALL, unit=""), 400.0, "+-/up", 0.5)
    found = machine.joint_torque(1.0)
    lines = np.linspace(-2.5, 2.5, 901)
    x, y = np.meshgrid(lines, lines)
    points = np.column_stack([x.ravel(), y.ravel()])
    points = points[machine.good.margins(points) >= 0.0] * machine.factor
    values = np.linalg.norm(naive_moves(machine, points), axis=1).max(axis=1)
    assert values.max() <= found.value * (1.0 + 1e-6)
    assert values.max() > 0.98 * found.value


def test_actuator_ranges_are_kept() -> None:
    design, shape = planar_design(*SMALL, unit=""), Shape.rectangle(300.0, 200.0)
    free = size_for_shape(design, shape, "+-/up")
    least, greatest = degrees(100.0, 190.0)
    held = size_for_shape(design, shape, "+-/up", ranges=[ActuatorRange(1, least, greatest)])
    assert held.factor > free.factor
    assert held.input_ranges[0].least == pytest.approx(least, abs=1e-7)
    assert held.input_ranges[0].greatest <= greatest + 1e-9
    # whole turns make no difference, and a range of a full turn is none
    turned = ActuatorRange(1, least - 2.0 * math.pi, greatest - 2.0 * math.pi)
    again = size_for_shape(design, shape, "+-/up", ranges=[turned])
    assert again.factor == pytest.approx(held.factor, rel=1e-9)
    whole = ActuatorRange(1, *degrees(0.0, 360.0))
    assert size_for_shape(design, shape, "+-/up", ranges=[whole]).factor == free.factor


def test_least_lengths_make_the_machine_larger() -> None:
    design, shape = planar_design(*SMALL, unit=""), Shape.rectangle(300.0, 200.0)
    machine = size_for_shape(design, shape, "+-/up", limits=[LinkLimit("R2", 600.0, 700.0)])
    assert machine.lengths["R2"] == pytest.approx(600.0, rel=1e-12)
    assert machine.fit is not None
    assert machine.fit.proof.verdict == INSIDE
    assert machine.contacts == ()


def test_what_is_infeasible_says_why_and_what_comes_closest() -> None:
    design, shape = planar_design(*SMALL, unit=""), Shape.rectangle(300.0, 200.0)
    cases = [
        ({"limits": [LinkLimit("R2", 0.0, 500.0)]}, r"R2 = 522\.\d+ mm is above 500 mm; within"),
        (
            {"ranges": [ActuatorRange(1, *degrees(-30.0, -20.0))]},
            r"none of \d+ points on the y axis has θ1 from -30 to",
        ),
        (
            {"placement": "free", "ranges": [ActuatorRange(2, *degrees(178.0, 179.0))]},
            r"none of \d+ points of the good-condition workspace has θ2 from 178 to 179 deg",
        ),
        ({"placement": (0.0, 200.0)}, r"no size with its centre at \(0, 200\); closest comes D ="),
    ]
    for extra, message in cases:
        with pytest.raises(InfeasibleSizeError, match=message):
            size_for_shape(design, shape, "+-/up", **extra)  # type: ignore[arg-type]
    slow = planar_design(3.0, 26.0, 1.0, unit="")
    with pytest.raises(InfeasibleSizeError, match=r"at LCI 0\.5; the largest LCI is 0\.1557"):
        size_for_shape(slow, shape, "+-/up")
    with pytest.raises(InfeasibleSizeError, match="θ1 turns fully"):
        size_for_area(
            planar_design(*PAPER, unit=""),
            400.0,
            "+-/up",
            ranges=[ActuatorRange(1, *degrees(0.0, 300.0))],
        )
    with pytest.raises(InfeasibleSizeError, match=r"is empty at LCI 0\.99; the largest LCI is 0"):
        size_for_shape(planar_design(0.4, 1.3, 1.3, unit=""), shape, "+-/up", 0.99)


def test_wrong_input_is_refused() -> None:
    design, shape = planar_design(*SMALL, unit=""), Shape.circle(1.0)
    with pytest.raises(InputError, match="area: -1"):
        size_for_area(design, -1.0, "+-/up")
    for threshold in (0.0, 1.0, -0.5, math.nan):
        with pytest.raises(InputError, match="above 0 and below 1"):
            size_for_shape(design, shape, "+-/up", threshold)
    with pytest.raises(UnknownNameError, match="mode"):
        size_for_shape(design, shape, "+*/up")
    with pytest.raises(InputError, match="non-dimensional design"):
        size_for_shape(planar_design(26, 30, 16), shape, "+-/up")
    with pytest.raises(InputError, match="a least angle below the greatest"):
        ActuatorRange(1, *degrees(90.0, -90.0))
    with pytest.raises(InputError, match="actuator from 1 to 2"):
        size_for_shape(design, shape, "+-/up", ranges=[ActuatorRange(3, -1.0, 1.0)])
    with pytest.raises(UnknownNameError, match=r"placement: 'ax' .* mean 'axis'"):
        size_for_shape(design, shape, "+-/up", placement="ax")
    with pytest.raises(InputError, match="offset"):
        size_for_shape(design, shape, "+-/up", placement=(0.0, math.inf))
    with pytest.raises(InputError, match="one range for each actuator"):
        size_for_shape(design, shape, "+-/up", ranges=[ActuatorRange(1, -1.0, 1.0)] * 2)
    flat, limits = planar_design(*PAPER, unit=""), [LinkLimit("R3", 1.0, 2.0)]
    with pytest.raises(InputError, match="R3 is 0 at every size"):
        size_for_shape(flat, shape, "+-/up", limits=limits)
    with pytest.raises(UnknownNameError, match="R4"):
        size_for_shape(design, shape, "+-/up", limits=[LinkLimit("R4", 0.0, 1.0)])
    with pytest.raises(InputError, match="not above the greatest"):
        LinkLimit("R1", 2.0, 1.0)
    with pytest.raises(InputError, match="limits of R1"):
        LinkLimit("R1", -2.0, 1.0)
    machine = size_for_shape(design, shape, "+-/up")
    with pytest.raises(InputError, match="encoder resolution"):
        machine.positioning_error(0.0)
    with pytest.raises(InputError, match="force"):
        machine.joint_torque(-1.0)


def test_the_largest_of_several_parts_has_the_area() -> None:
    lengths, threshold = (0.934, 2.029, 0.037), 0.026
    machine = size_for_area(planar_design(*lengths, unit=""), 400.0, "--/down", threshold)
    assert machine.parts == 2
    x, y = naive.grid(*lengths, 1500)
    inside = naive.usable_workspace_mask(*lengths, -1, -1, -1, 1500)
    columns, rows = np.meshgrid(x, y)
    inside[inside] = naive.lci(*lengths, columns[inside], rows[inside], -1, -1) >= threshold
    labels, _ = ndimage.label(inside)
    largest = np.bincount(labels.ravel())[1:].max() * (x[1] - x[0]) * (y[1] - y[0])
    assert machine.factor**2 * largest == pytest.approx(400.0, rel=5e-3)
    assert machine.factor_error < 1e-4 * machine.factor
