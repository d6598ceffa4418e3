"""Stated errors and tolerances against a thousand independent reference values.

``published/reference_cases.json`` was made by ``benchmarks/make_reference_cases.py`` with
``reference.py``, which integrates over Cartesian columns and shares nothing with the package.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fivebar_atlas.mechanisms.five_bar.evaluation import TOLERANCE_NOT_REACHED, evaluate_designs

CASES = json.loads((Path(__file__).parent / "published" / "reference_cases.json").read_text())[
    "cases"
]
NAMES = {
    "usable_workspace_area": "usable_workspace_area",
    "gci": "gci",
    "good_condition_workspace_area": "good_condition_area",
    "good_condition_gci": "good_condition_gci",
}


def evaluate(case: dict[str, Any], tolerance: float) -> dict[str, float]:
    values = evaluate_designs(
        np.array([[case["r1"], case["r2"], case["r3"]]]),
        np.array([[case["s1"], case["s2"], case["assembly"]]]),
        np.array([case["threshold"]]),
        tolerance,
    )
    return {name: float(value.ravel()[0]) for name, value in values.items()}


def test_there_are_a_thousand_cases_of_every_mode() -> None:
    assert len(CASES) == 1000
    assert len({(c["s1"], c["s2"], c["assembly"]) for c in CASES}) == 8


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_stated_errors_hold(tolerance: float) -> None:
    exceeded, beyond, compared = set(), set(), 0
    for case in CASES:
        values = evaluate(case, tolerance)
        reached = not int(values["status"]) & TOLERANCE_NOT_REACHED
        for ours, theirs in NAMES.items():
            assert np.isnan(values[ours]) == (case[theirs] is None), (case["case"], ours)
            if case[theirs] is None:
                continue
            compared += 1
            # the reference has an error of its own, and both round
            doubt = case[f"{theirs}_error"] + 1e-13
            difference = abs(values[ours] - case[theirs])
            if difference > values[f"{ours}_error"] + doubt:
                exceeded.add(case["case"])
            if reached and difference > tolerance * abs(case[theirs]) + doubt:
                beyond.add(case["case"])
    assert compared > 3000
    assert len(exceeded) <= 1, exceeded  # 99.9 % of the cases
    assert not beyond
