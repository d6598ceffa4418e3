"""Values printed in papers, with the verdict on each (see ``published/*.yaml``)."""

from __future__ import annotations

import dataclasses
from decimal import Decimal

import pytest
from published_values import (
    LAST_DIGIT_DIFFERS,
    NOT_REPRODUCED,
    REPRODUCED,
    PublishedValue,
    load,
)

VALUES = load()


@pytest.mark.parametrize("value", VALUES, ids=lambda value: value.identity)
def test_verdict_holds(value: PublishedValue) -> None:
    ours = value.compute()
    assert value.judge(ours) == value.verdict, f"printed {value.printed}, ours {ours!r}"
    if value.exact is not None:
        unit = float(Decimal(1).scaleb(int(Decimal(value.exact).as_tuple().exponent)))
        assert ours == pytest.approx(float(value.exact), rel=0.0, abs=0.6 * unit)


def test_what_is_not_reproduced_is_explained() -> None:
    assert len(VALUES) == len({value.identity for value in VALUES})
    for value in VALUES:
        assert value.verdict in {REPRODUCED, LAST_DIGIT_DIFFERS, NOT_REPRODUCED}
        assert value.explanation or value.verdict == REPRODUCED, value.identity


@pytest.mark.parametrize(
    ("printed", "ours", "verdict"),
    [
        ("0.5", 0.5499, REPRODUCED),
        ("0.5", 0.56, LAST_DIGIT_DIFFERS),
        ("0.5", 0.66, NOT_REPRODUCED),
        (["0.5", "0.6"], 0.6, REPRODUCED),
        (["0.5", "0.6"], 0.61, NOT_REPRODUCED),
        ("0.5", float("nan"), NOT_REPRODUCED),
    ],
)
def test_verdicts_are_what_they_are_called(
    printed: str | list[str], ours: float, verdict: str
) -> None:
    value = PublishedValue("", "", "", printed, verdict, "", None, {}, "+-/up")
    assert value.judge(ours) == verdict


def test_the_two_printed_gci_of_one_design_contradict_each_other() -> None:
    printed = {v.identity: float(v.printed) for v in VALUES if isinstance(v.printed, str)}
    rest = printed["area_without_base"] * printed["gci_without_base"]
    rest -= printed["good_condition_area"] * printed["good_condition_gci"]
    rest /= printed["area_without_base"] - printed["good_condition_area"]
    # The LCI is below 0.5 there, and so is its mean.
    assert rest == pytest.approx(0.707, abs=5e-4)


def test_a_lower_bound_of_the_gci_gives_a_region_like_the_printed_one() -> None:
    template = next(value for value in VALUES if value.identity == "region_least_r1")
    bounds = {"r1": (1.19, 1.43), "r2": (1.50, 1.78), "r3": (0.0, 0.13)}
    for length, expected in bounds.items():
        for bound, edge in zip(("least", "greatest"), expected, strict=True):
            changed = {"region_bound": bound, "length": length, "gci": 0.62, "resolution": 300}
            value = dataclasses.replace(
                template, computation={**template.computation, **changed}
            ).compute()
            assert value == pytest.approx(edge, abs=1e-9)
