"""Levels of contour maps: they enclose the values, are round, and are written exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fivebar_atlas.figures.contour_levels import (
    ROUND_STEPS,
    level_text,
    magnitude_levels,
    magnitude_text,
    round_levels,
)


@pytest.mark.parametrize(
    ("least", "greatest", "bands", "expected"),
    [
        (0.0, 28.2743, 15, np.arange(0.0, 31.0, 2.0)),
        (0.0, 28.2743, 12, np.arange(0.0, 30.1, 2.5)),
        (0.11, 0.6741, 12, np.arange(0.10, 0.71, 0.05)),
        (-1.2, 0.9, 6, np.arange(-1.5, 1.1, 0.5)),
        (0.3, 0.3 + 3e-16 + 0.1, 5, np.arange(0.30, 0.401, 0.02)),
        (12345.0, 12346.0, 10, np.arange(12345.0, 12346.01, 0.1)),
    ],
)
def test_levels_a_person_would_choose(
    least: float, greatest: float, bands: int, expected: np.ndarray
) -> None:
    np.testing.assert_allclose(round_levels(least, greatest, bands), expected, rtol=1e-14)


@given(
    least=st.floats(-1e4, 1e4),
    spread=st.floats(1e-2, 1e6),
    bands=st.integers(4, 20),
)
def test_levels_are_round_few_and_enclose_the_values(
    least: float, spread: float, bands: int
) -> None:
    greatest = least + spread
    levels = round_levels(least, greatest, bands)
    step = levels[1] - levels[0]

    assert levels[0] <= least + 1e-6 * step
    assert levels[-1] >= greatest - 1e-6 * step
    assert levels[1] > least
    assert levels[-2] < greatest
    assert 1 <= len(levels) - 1 <= bands
    np.testing.assert_allclose(np.diff(levels), step, rtol=0.0, atol=1e-9 * abs(levels).max())
    mantissa = step / 10.0 ** np.floor(np.log10(step * (1 + 1e-4)))
    assert min(abs(mantissa - known) for known in ROUND_STEPS) < 1e-4


@given(least=st.floats(-100.0, 100.0), spread=st.floats(1e-3, 100.0))
def test_written_levels_are_the_levels(least: float, spread: float) -> None:
    levels = round_levels(least, least + spread)
    texts = [level_text(level, levels) for level in levels]

    assert len(set(texts)) == len(texts)
    for text, level in zip(texts, levels, strict=True):
        read = float(text.replace("\N{MINUS SIGN}", "-"))
        assert read == pytest.approx(level, rel=1e-9, abs=1e-9 * spread)


def test_zero_is_written_without_a_sign() -> None:
    levels = np.array([-0.5, -0.0, 0.5])
    assert [level_text(level, levels) for level in levels] == ["\N{MINUS SIGN}0.5", "0.0", "0.5"]


@pytest.mark.parametrize(
    ("least", "greatest", "expected"),
    [
        (3e-10, 4e-7, [1e-10, 1e-9, 1e-8, 1e-7, 1e-6]),
        (1e-9, 1e-7, [1e-9, 2e-9, 5e-9, 1e-8, 2e-8, 5e-8, 1e-7]),
        (1.3e-8, 4e-8, [1e-8, 2e-8, 5e-8]),
        (2e-8, 2e-8, [2e-8, 5e-8]),
        (1e-16, 1e-1, [1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0]),
    ],
)
def test_levels_of_magnitude(least: float, greatest: float, expected: list[float]) -> None:
    np.testing.assert_allclose(magnitude_levels(least, greatest), expected, rtol=1e-12)


@given(exponent=st.floats(-300.0, 2.0), decades=st.floats(0.0, 250.0))
def test_levels_of_magnitude_enclose_the_values(exponent: float, decades: float) -> None:
    least, greatest = 10.0**exponent, 10.0 ** min(exponent + decades, 300.0)
    levels = magnitude_levels(least, greatest)

    assert levels[0] <= least * (1 + 1e-8)
    assert levels[-1] >= greatest * (1 - 1e-8)
    assert (np.diff(levels) > 0).all()
    assert 2 <= len(levels) <= 13


def test_magnitudes_are_written_as_powers() -> None:
    assert magnitude_text(1e-10) == "$10^{-10}$"
    assert magnitude_text(1.0) == "$10^{0}$"
    assert magnitude_text(5e-8) == r"$5\!\times\!10^{-8}$"
