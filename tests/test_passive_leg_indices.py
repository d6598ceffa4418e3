"""Indices of the manipulator with a passive leg: against reference values, and how they behave."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from naive_passive_leg import MODE_PAIRS, read_reference_file

from fivebar_atlas.mechanisms.passive_leg.evaluation import (
    TOLERANCE_NOT_REACHED,
    UNBOUNDED_MANIPULABILITY,
)
from fivebar_atlas.mechanisms.passive_leg.mechanism import PassiveLegMechanism
from fivebar_atlas.mechanisms.passive_leg.passive_leg import PassiveLeg
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.numerics.quadrature import gauss_kronrod, null_rules

MECHANISM = PassiveLegMechanism()
CASES = read_reference_file()
#: Dataset names of the indices of the whole workspace, as the reference names them, too.
WHOLE = (
    "usable_workspace_area",
    "gci",
    "gmi",
    "space_utilisation",
    "gci_l_theta",
    "gmi_l_theta",
    "space_utilisation_l_theta",
)
GOOD = {
    "good_condition_workspace_area": "good_condition_area",
    "good_condition_gci": "good_condition_gci",
    "good_condition_gmi": "good_condition_gmi",
}


def evaluate(
    designs: Any,
    modes: tuple[str, ...] = ("+-/up",),
    thresholds: tuple[float, ...] = (),
    tolerance: float = 1e-4,
    theta_limit: float = 90.0,
    passive_joint_limits: bool = True,
) -> dict[str, Any]:
    settings = SweepSettings(
        mechanism="passive-leg",
        space="conditioned",
        resolution=10,
        modes=modes,
        lci_thresholds=thresholds,
        tolerance=tolerance,
        options=(
            ("theta_limit", theta_limit),
            ("passive_joint_limits", passive_joint_limits),
        ),
    )
    return MECHANISM.evaluate(np.asarray(designs, dtype=np.float64), settings)


def random_designs(seed: int, count: int) -> Any:
    """Conditioned designs, and as many free ones that can be assembled."""
    rng = np.random.default_rng(seed)
    found: list[tuple[float, float, float]] = []
    while len(found) < 2 * count:
        r, l_a, l_b = rng.uniform(0.5, 2.0, 3)
        if len(found) < count:
            l_a = l_b - 1.0 + r
        if l_a > 0.05 and l_a + l_b > abs(1.0 - r) + 0.05:
            found.append((r, l_a, l_b))
    return np.array(found)


def describe(case: dict[str, Any]) -> str:
    limited = "limits" if case["passive_joint_limits"] else "free"
    return " ".join([*map(str, case["design"]), case["mode"], f"{case['theta_limit']:g}", limited])


@pytest.mark.parametrize("case", CASES, ids=describe)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_agreement_with_the_reference(case: dict[str, Any], tolerance: float) -> None:
    thresholds = tuple(case["thresholds"])
    found = evaluate(
        [case["design"]],
        (case["mode"],),
        thresholds,
        tolerance,
        case["theta_limit"],
        case["passive_joint_limits"],
    )
    reference = case["values"]
    assert not found["status"][0, 0] & TOLERANCE_NOT_REACHED

    def compare(value: float, error: float, name: str, size: float) -> None:
        expected = reference[name]
        if np.isnan(value):
            assert expected is None or not np.isfinite(expected), name
            return
        doubt = max(reference[f"{name}_error"], 3e-12 * abs(expected))
        assert abs(value - expected) <= error + doubt, name
        assert error <= 1.3 * tolerance * size, name

    compare(
        found["workspace_area"][0],
        found["workspace_area_error"][0],
        "workspace_area",
        reference["workspace_area"],
    )
    for name in WHOLE:
        value, error = found[name][0, 0], found[f"{name}_error"][0, 0]
        # a mean has the errors of two integrals
        compare(value, error, name, 2.0 * abs(value))
    for k, threshold in enumerate(thresholds):
        for name, other in GOOD.items():
            value, error = found[name][0, 0, k], found[f"{name}_error"][0, 0, k]
            size = reference["usable_workspace_area"] if name.endswith("area") else np.inf
            compare(value, error, f"{other}_{threshold:g}", size)
    unbounded = bool(found["status"][0, 0] & UNBOUNDED_MANIPULABILITY)
    assert unbounded == np.isinf(reference["gmi"] or 0.0)


@pytest.mark.parametrize("limits", [True, False])
def test_errors_hold_but_for_rare_ones(limits: bool) -> None:
    designs = random_designs(3, 8)
    close = evaluate(designs, MODE_PAIRS, (0.2, 0.5), 1e-8, passive_joint_limits=limits)
    for tolerance in (1e-3, 1e-5):
        rough = evaluate(designs, MODE_PAIRS, (0.2, 0.5), tolerance, passive_joint_limits=limits)
        for name in (*WHOLE, *GOOD):
            value, other = rough[name], close[name]
            is_there = ~np.isnan(other) & ~np.isnan(value)
            off = np.abs(value - other)[is_there]
            allowed = (rough[f"{name}_error"] + close[f"{name}_error"])[is_there]
            fails = np.mean(off > allowed + 1e-14 * np.abs(other[is_there]))
            assert fails <= 0.01, (name, tolerance)
            if name in ("usable_workspace_area", "gci"):
                assert np.all(off <= 2.0 * tolerance * other[is_there]), (name, tolerance)


def test_parts_that_touch_in_the_middle_of_the_base_are_two() -> None:
    """In "++/down" the forward singularity passes through O twice; the reference agrees."""
    found = evaluate([(1.9049647, 0.7326954, 1.2716995)], ("++/down",), passive_joint_limits=False)
    finer = evaluate(
        [(1.9049647, 0.7326954, 1.2716995)],
        ("++/down",),
        tolerance=1e-8,
        passive_joint_limits=False,
    )
    assert found["usable_workspace_area"][0, 0] == pytest.approx(0.8039716, abs=2e-6)
    assert finer["usable_workspace_area"][0, 0] == pytest.approx(
        found["usable_workspace_area"][0, 0], abs=1e-6
    )


def test_slivers_beside_straight_legs_belong_to_the_workspace() -> None:
    """A forward singularity that turns back next to the stretched leg, or next to O, is seen."""
    for design, area in (
        ((1.084854948078973, 0.8319771256059578, 0.7471221775269847), 1.3523175627877),
        ((0.7860404080324349, 1.9560619079980575, 2.1700214999656224), 18.6112489487982),
    ):
        found = evaluate([design], tolerance=1e-8, passive_joint_limits=False)
        assert found["usable_workspace_area"][0, 0] == pytest.approx(area, abs=1e-9)


def test_nothing_is_claimed_where_columns_are_rounding() -> None:
    """With R = r = l_a = l_b and elbows to one side J_x is singular all about O."""
    found = evaluate([(1.0, 1.0, 1.0)], ("++/up",), (0.5,))
    assert found["status"][0, 0] & TOLERANCE_NOT_REACHED
    assert found["usable_workspace_area_error"][0, 0] >= 0.5
    assert np.isnan(found["gci"][0, 0])
    assert np.isnan(found["max_lci"][0, 0])


def test_mirrored_modes_have_the_same_values() -> None:
    designs = random_designs(4, 4)
    for assembly in ("up", "down"):
        found = evaluate(designs, (f"++/{assembly}", f"--/{assembly}"), (0.3,))
        for name, values in found.items():
            if values.ndim > 1:
                turned = -1.0 if name == "max_lci_x" else 1.0
                np.testing.assert_array_equal(values[:, 0], turned * values[:, 1], err_msg=name)


def test_scaling() -> None:
    """Indices are those of a machine; areas and manipulability go with the square of its size."""
    lengths = (2.5, 3.0, 3.0, 2.5)
    designs, factor = MECHANISM.from_lengths(lengths)
    assert factor == 2.5
    whole = evaluate([designs], thresholds=(0.5,))
    plane = MECHANISM.planar_design(lengths, "mm")
    workspace = plane.usable_workspace("+-/up")
    assert workspace is not None
    area = float(whole["usable_workspace_area"][0, 0])
    assert workspace.region.area == pytest.approx(factor**2 * area, rel=1e-9)
    value, error = plane.good_condition_area(0.5, "+-/up")
    expected = factor**2 * float(whole["good_condition_workspace_area"][0, 0, 0])
    allowed = factor**2 * float(whole["good_condition_workspace_area_error"][0, 0, 0])
    assert abs(value - expected) <= error + allowed


def test_the_same_bytes_in_one_batch_in_pieces_and_in_threads() -> None:
    designs = random_designs(5, 6)

    def rows(some: Any) -> dict[str, Any]:
        return evaluate(some, ("+-/up", "++/down"), (0.2, 0.5, 0.7))

    together = rows(designs)
    pieces = [rows(designs[k : k + 1]) for k in range(len(designs))]
    with ThreadPoolExecutor(2) as pool:
        threads = list(pool.map(rows, [designs[:5], designs[5:]]))
    for name, values in together.items():
        for parts in (pieces, threads):
            joined = np.concatenate([part[name] for part in parts])
            assert joined.tobytes() == values.tobytes(), name


def test_other_orders_of_the_thresholds_give_the_same_bytes() -> None:
    designs = random_designs(6, 4)
    one = evaluate(designs, ("+-/up", "-+/down"), (0.2, 0.5, 0.7))
    other = evaluate(designs, ("+-/up", "-+/down"), (0.7, 0.2, 0.5))
    for name, values in one.items():
        picked = other[name][..., [1, 2, 0]] if values.ndim == 3 else other[name]
        assert picked.tobytes() == values.tobytes(), name


def test_null_rules_vanish_for_polynomials() -> None:
    nodes = gauss_kronrod(7).nodes
    rules = null_rules(7, 2)
    powers = nodes[:, None] ** np.arange(15)
    for k, rule in enumerate(rules):
        np.testing.assert_allclose(rule @ powers[:, : 13 - k], 0.0, atol=1e-14)
        assert abs(rule @ powers[:, 13 - k]) > 1e-9
    difference = gauss_kronrod(7).weights - gauss_kronrod(7).gauss_weights
    np.testing.assert_allclose(np.linalg.norm(rules, axis=1), np.linalg.norm(difference))


@pytest.mark.parametrize("l_a", [1.2819054, 1.6247049])
def test_outlines_past_a_leg_of_no_length(l_a: float) -> None:
    """With l_a = l_b the forward singularity passes through points at which b_i is on B_i."""
    design = PassiveLeg(0.9485073, l_a, l_a, passive_joint_limits=False)
    workspace = design.usable_workspace("+-/up")
    assert workspace is not None
    assert workspace.region.area == pytest.approx(workspace.area, abs=1e-9)


def test_outline_with_upper_links_as_long_as_the_platform() -> None:
    """With l_b = r the platform's middle is where upper links are level on a circle about B_i."""
    design = PassiveLeg(1.0, 1.1049067, 1.0, np.radians(10.8))
    workspace = design.usable_workspace("--/down")
    assert workspace is not None
    assert workspace.region.area == pytest.approx(workspace.area, abs=1e-9)


def test_outline_next_to_columns_of_another_kind() -> None:
    """A node that is missing from a forward singularity leaves the others as they are."""
    design = PassiveLeg(1.0, 1.5776903578193844, 1.4630375866443814, passive_joint_limits=False)
    workspace = design.usable_workspace("-+/down")
    assert workspace is not None
    assert workspace.region.area == pytest.approx(workspace.area, abs=1e-9)


def test_operating_limits_where_legs_are_folded_next_to_the_middle_of_the_base() -> None:
    """With l_a = l_b - R + r both legs are folded at O, and limits at θ = 0 are those beside it."""
    design = PassiveLeg(0.9246246, 1.7900010, 1.8653764, passive_joint_limits=False)
    limits = design.operating_limits("+-/up", 61)
    middle = len(limits.places) // 2
    for extremes in (limits.least, limits.greatest):
        beside = 0.5 * (extremes[middle - 1] + extremes[middle + 1])
        assert np.all(np.abs(extremes[middle] - beside) < 0.2)
