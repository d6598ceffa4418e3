"""The Python interface to one manipulator."""

from __future__ import annotations

import dataclasses
import doctest
import math

import naive
import numpy as np
import pytest
from designs import MODES, random_cases

from fivebar_atlas import FiveBar, InputError, UnknownNameError
from fivebar_atlas.mechanisms.five_bar import five_bar
from fivebar_atlas.mechanisms.five_bar.outline import usable_workspace_of

ROBOT = FiveBar(1.2, 1.0, 0.8)


def test_examples_of_the_documentation() -> None:
    failed, attempted = doctest.testmod(five_bar)
    assert failed == 0
    assert attempted > 4


def test_from_lengths_scales() -> None:
    robot = FiveBar.from_lengths(26, 30, 16)
    assert robot.dimensional_factor == 24.0
    assert (robot.r1, robot.r2, robot.r3) == pytest.approx((26 / 24, 30 / 24, 16 / 24))
    assert robot.lengths == pytest.approx((26.0, 30.0, 16.0))
    assert robot.sub_region == "Va"
    same = FiveBar.from_lengths(2.6e-3, 3.0e-3, 1.6e-3)
    assert same.evaluate()["gci"] == pytest.approx(robot.evaluate()["gci"], rel=1e-9)


def test_is_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        ROBOT.r1 = 2.0  # type: ignore[misc]


@pytest.mark.parametrize(
    "lengths",
    [
        (0.0, 2.0, 1.0), (-1.0, 3.0, 1.0), (2.0, 0.0, 1.0), (2.0, 2.0, -1.0),
        (math.nan, 1.0, 1.0), (math.inf, 1.0, 1.0), (0.5, 0.5, 2.0), (26.0, 30.0, 16.0),
    ],
)  # fmt: skip
def test_bad_lengths_are_refused(lengths: tuple[float, float, float]) -> None:
    with pytest.raises(InputError):
        FiveBar(*lengths)


def test_arrays_in_arrays_out() -> None:
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 5), np.linspace(0.5, 1.5, 4))
    assert ROBOT.lci(x, y).shape == (4, 5)
    assert ROBOT.jacobian(x, y).shape == (4, 5, 2, 2)
    assert ROBOT.elbows(x, y)[0].shape == (4, 5, 2)
    assert ROBOT.lci(0.0, 1.0).shape == ()
    assert ROBOT.lci(0.0, np.array([1.0, 1.2])).shape == (2,)


def test_points_agree_with_the_oracle_and_nan_is_out_of_reach() -> None:
    x, y = np.meshgrid(np.linspace(-2.5, 2.5, 21), np.linspace(-2.5, 2.5, 22))
    for mode, (s1, s2) in {"+-": (1, -1), "mp/down": (-1, 1), "++": (1, 1)}.items():
        theirs = naive.lci(1.2, 1.0, 0.8, x, y, s1, s2)
        ours = ROBOT.lci(x, y, mode)
        reached = ~np.isnan(naive.det_b(1.2, 1.0, 0.8, x, y, s1, s2))
        assert 50 < reached.sum() < reached.size
        np.testing.assert_array_equal(np.isnan(ours), ~reached)
        np.testing.assert_allclose(ours[reached], theirs[reached], atol=1e-8)
        b1, b2 = ROBOT.elbows(x, y, mode)
        n1, n2 = naive.elbows(1.2, 1.0, 0.8, x, y, s1, s2)
        np.testing.assert_allclose(b1[reached], n1[reached], atol=1e-10)
        np.testing.assert_allclose(b2[reached], n2[reached], atol=1e-10)
        jacobian = naive.jacobian(1.2, 1.0, 0.8, x, y, s1, s2)
        np.testing.assert_allclose(
            ROBOT.jacobian(x, y, mode)[reached], jacobian[reached], rtol=1e-6, atol=1e-9
        )
        signs = np.sign(naive.det_b(1.2, 1.0, 0.8, x, y, s1, s2))
        np.testing.assert_array_equal(ROBOT.assembly_mode(x, y, mode)[reached], signs[reached])


def test_forward_undoes_inverse() -> None:
    x, y = np.linspace(-0.8, 0.8, 9), np.full(9, 1.3)
    theta1, theta2 = ROBOT.inverse_kinematics(x, y, "+-")
    back_x, back_y = ROBOT.forward_kinematics(theta1, theta2, "up")
    np.testing.assert_allclose(back_x, x, atol=1e-12)
    np.testing.assert_allclose(back_y, y, atol=1e-12)
    assert np.isnan(ROBOT.forward_kinematics(math.pi, 0.0)[0])


def test_singular_points_are_named() -> None:
    kinds = ROBOT.singularity([0.0, 1.4, 9.0], [1.3, 0.0, 9.0])
    assert list(kinds) == [0, 1, -1]


def test_evaluate_has_the_keys_of_the_command() -> None:
    values = ROBOT.evaluate("pm/up", lci_thresholds=[0.3, 0.6])
    assert values["working_mode"] == "+-"
    assert values["usable_workspace_area"] == pytest.approx(5.970548942261283, abs=1e-12)
    assert [entry["lci_threshold"] for entry in values["good_condition"]] == [0.3, 0.6]
    assert values["status"] == "no_lower_inscribed_circle" or values["mic_lower"]["radius"] > 0.0


def test_unknown_names_and_values_are_refused() -> None:
    with pytest.raises(UnknownNameError):
        ROBOT.lci(0.0, 1.0, "+?")
    with pytest.raises(UnknownNameError):
        ROBOT.evaluate("+-/left")
    with pytest.raises(UnknownNameError):
        ROBOT.forward_kinematics(0.0, 1.0, "sideways")
    with pytest.raises(InputError):
        ROBOT.evaluate(tolerance=1.0)
    with pytest.raises(InputError):
        ROBOT.evaluate(lci_thresholds=[1.5])


def test_change_point_cases() -> None:
    assert FiveBar(1.0, 1.0, 1.0).change_point_cases == "ab"
    assert ROBOT.change_point_cases == ""


def test_the_origin_is_inside_where_everything_around_it_is() -> None:
    turns = np.linspace(0.0, 2.0 * math.pi, 64)
    inside = 0
    for design, mode in random_cases(77, 400):
        workspace = usable_workspace_of(design, mode)
        if workspace is not None:
            around = workspace.contains(1e-8 * np.cos(turns), 1e-8 * np.sin(turns))
            assert bool(workspace.contains(0.0, 0.0)) == around.all()
            inside += int(around.all())
    assert inside > 10
    # a fold circle passes through it
    for mode in MODES:
        workspace = usable_workspace_of((1.25, 1.0, 0.75), mode)
        assert workspace is not None
        assert not workspace.contains(0.0, 0.0)
