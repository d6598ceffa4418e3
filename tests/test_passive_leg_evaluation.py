"""How evaluations of the passive-leg manipulator hold what they state."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.settings import SweepSettings

MECHANISM = mechanisms.get("passive-leg")
INTEGRATED = [quantity for quantity in MECHANISM.quantities if quantity.has_error]

Results = dict[str, npt.NDArray[Any]]


def evaluated(
    designs: npt.ArrayLike,
    mode: str = "+-/up",
    thresholds: tuple[float, ...] = (0.5,),
    tolerance: float = 1e-8,
    **options: float | bool,
) -> Results:
    settings = SweepSettings(
        "passive-leg", "conditioned", 2, (mode,), thresholds, tolerance, tuple(options.items())
    )
    return MECHANISM.evaluate(np.atleast_2d(designs), settings)


def random_designs(count: int, seed: int) -> npt.NDArray[np.float64]:
    """Return designs of the conditioned space."""
    points = 0.5 + 1.5 * np.random.default_rng(seed).random((count, 2))
    return MECHANISM.unproject(points, "conditioned")


def doubts(results: Results, name: str) -> npt.NDArray[np.float64]:
    return np.asarray(results[f"{name}_error"]).ravel()


@pytest.mark.parametrize("mode", ["+-/up", "-+/down", "++/up"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_stated_errors_hold(mode: str, tolerance: float) -> None:
    designs = random_designs(40, 31)
    rough, fine = evaluated(designs, mode, tolerance=tolerance), evaluated(designs, mode)
    wrong, count = 0, 0
    for quantity in INTEGRATED:
        name = quantity.name
        differences = np.abs(rough[name] - fine[name]).ravel()
        exist = np.isfinite(differences)
        allowed = doubts(rough, name) + doubts(fine, name) + 1e-13
        wrong += int(np.sum(differences[exist] > allowed[exist]))
        count += int(exist.sum())
    assert count > 200
    assert wrong <= 0.005 * count


def test_tolerances_are_kept() -> None:
    designs = random_designs(60, 8)
    for tolerance in (1e-4, 1e-6):
        results = evaluated(designs, tolerance=tolerance)
        reached = results["status"][:, 0] & 4 == 0
        assert reached.mean() > 0.95
        for name in ("usable_workspace_area", "gci"):
            share = results[f"{name}_error"][:, 0] / results[name][:, 0]
            assert np.all(share[reached] <= 2.0 * tolerance)


def test_up_and_down_fill_the_workspace_of_symmetric_modes() -> None:
    """Where there are just two parts, one of each sign."""
    results = [
        evaluated((1.2, 0.9, 1.3), f"-+/{name}", passive_joint_limits=False)
        for name in ("up", "down")
    ]
    parts = sum(float(each["usable_workspace_area"][0, 0]) for each in results)
    assert parts <= float(results[0]["workspace_area"][0]) * (1.0 + 1e-9)


def test_an_angle_limit_shrinks_the_workspace() -> None:
    areas = [
        float(evaluated((1.2, 1.4, 1.2), theta_limit=limit)["usable_workspace_area"][0, 0])
        for limit in (10.0, 45.0, 90.0)
    ]
    assert areas == sorted(areas)
    # a narrow wedge: half the square of the length times its angle
    width = np.radians(2.0)
    narrow = float(evaluated((1.2, 1.4, 1.2), theta_limit=1.0)["usable_workspace_area"][0, 0])
    assert narrow == pytest.approx(0.5 * (2.6**2 - 0.2**2) * width, rel=0.02)


def test_what_does_not_exist_is_explained() -> None:
    results = evaluated([[0.9, 1.1, 1.2], [1.2, 1.4, 1.2]])
    assert results["status"][:, 0].tolist() == [8, 0]
    assert np.isnan(results["gmi"][0, 0])
    assert np.isfinite(results["good_condition_gmi"]).all()
    empty = evaluated((2.0, 0.02, 0.5), "+-/up")
    assert empty["status"][0, 0] & 1
    assert empty["usable_workspace_area"][0, 0] == 0.0
