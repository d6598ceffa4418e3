"""One machine in an atlas: interpolated between three designs, exact beside it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import closed_form_atlas
import closed_form_mechanism
import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from fivebar_atlas.errors import InputError
from fivebar_atlas.store import Atlas, open_atlas
from fivebar_atlas.synthesis.lookup import Lookup, look_up


@pytest.fixture(scope="module")
def five_bar(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Atlas]:
    path = tmp_path_factory.mktemp("lookup") / "small.h5"
    with open_atlas(closed_form_mechanism.write(path, "five-bar")) as opened:
        yield opened


def values(found: Lookup, name: str) -> tuple[float, float]:
    (entry,) = [each for each in found.entries if each.quantity.name == name]
    assert isinstance(entry.interpolated, float)
    assert isinstance(entry.exact, float)
    return entry.interpolated, entry.exact


def test_the_machine_of_the_paper(five_bar: Atlas) -> None:
    found = look_up(five_bar, (26.0, 30.0, 16.0))
    assert found.factor == 24.0
    assert list(found.parameters.values()) == pytest.approx([26 / 24, 30 / 24, 16 / 24], rel=1e-15)
    by_name = {entry.quantity.name: entry for entry in found.entries}
    assert by_name["sub_region"].exact == "Va"
    interpolated, exact = values(found, "usable_workspace_area")
    assert exact == pytest.approx(9.325274, abs=1e-6)
    assert interpolated == pytest.approx(exact, rel=5e-3)
    scaled = by_name["usable_workspace_area"].scaled(found.factor)
    assert scaled == pytest.approx((24.0**2 * interpolated, 24.0**2 * exact), rel=1e-14)
    radius = by_name["mic_upper_radius"].scaled(found.factor)
    assert radius is not None
    assert radius[1] == pytest.approx(24.0 * values(found, "mic_upper_radius")[1], rel=1e-14)
    assert by_name["gci"].scaled(found.factor) is None
    assert by_name["gci"].error is not None
    assert by_name["gci"].error < 1e-6


def test_between_designs_values_are_linear_and_beside_them_exact(closed_form: Atlas) -> None:
    """Inside each lattice triangle any triangulation of its three corners interpolates alike."""
    rng = np.random.default_rng(7)
    for _ in range(50):
        shares = rng.dirichlet((1.0, 1.0, 1.0))
        design = shares @ np.array([[2.7, 0.3, 0.0], [0.3, 2.7, 0.0], [1.0, 1.0, 1.0]])
        found = look_up(closed_form, design * 10.0)
        assert found.factor == pytest.approx(10.0)
        corners = found.corners
        assert np.all(found.weights >= 0.0)
        np.testing.assert_allclose(found.weights @ corners, design, atol=1e-12)
        # neighbours on the lattice of step 3/60
        for one, other in itertools.combinations(corners, 2):
            assert np.abs(one - other).max() < 2.01 * 3.0 / 60.0
        at = LinearNDInterpolator(corners[:, [0, 2]], closed_form_atlas.conditioning(corners))
        interpolated, exact = values(found, "gci")
        assert exact == pytest.approx(float(closed_form_atlas.conditioning(design[None])[0]))
        assert interpolated == pytest.approx(float(at(design[[0, 2]])[0]), abs=1e-9)


def test_a_design_of_the_lattice_is_read_as_it_is_stored(closed_form: Atlas) -> None:
    for place in (0, 17, 200, len(closed_form) - 1):
        found = look_up(closed_form, closed_form.designs[place])
        interpolated, exact = values(found, "gci")
        assert interpolated == pytest.approx(closed_form["gci"][place, 0], rel=1e-13)
        assert exact == pytest.approx(interpolated, rel=1e-13)
        by_name = {entry.quantity.name: entry for entry in found.entries}
        assert by_name["gci"].difference == pytest.approx(0.0, abs=1e-12)


def test_every_mode_and_threshold_of_a_file_has_its_entry(tmp_path: Path) -> None:
    with open_atlas(closed_form_atlas.write(tmp_path / "several.h5")) as several:
        found = look_up(several, (2.0, 0.6, 0.4))
        labels = [
            entry.labels for entry in found.entries if entry.quantity.name == "good_condition_gci"
        ]
        assert labels == [
            {"mode": mode, "threshold": threshold}
            for mode, threshold in itertools.product(("+-/up", "++/up"), ("0.3", "0.5"))
        ]
        # in the second mode pair, nothing has values where r1 > 1.9
        first, second = (entry for entry in found.entries if entry.quantity.name == "gci")
        assert isinstance(first.interpolated, float)
        assert second.interpolated is None
        assert second.difference is None


@pytest.mark.parametrize(
    ("lengths", "message"),
    [
        ((1.0, 1.0, 1.1), "beyond"),
        ((0.5, 2.0, 0.6), "beyond r1 = r3"),
        ((0.001, 5.0, 0.0), "between those of the lattice"),
        ((1.0, 2.0), "3 numbers"),
        ((1.0, 1.0, 4.0), "assembled"),
    ],
)
def test_designs_outside_are_refused(
    five_bar: Atlas, lengths: tuple[float, ...], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        look_up(five_bar, lengths)
