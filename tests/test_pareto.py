"""Pareto fronts: against pairwise comparison, and moved to the true front."""

from __future__ import annotations

from pathlib import Path

import closed_form_atlas
import numpy as np
import numpy.typing as npt
import pytest

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.store import Atlas, open_atlas
from fivebar_atlas.synthesis.candidates import Candidates
from fivebar_atlas.synthesis.conditions import parse_condition
from fivebar_atlas.synthesis.objectives import parse_directions
from fivebar_atlas.synthesis.pareto import non_dominated, pareto_front, polished_front

FloatArray = npt.NDArray[np.float64]
KNOWN = ("r1", "r2", "r3", "gci", "usable_workspace_area", "max_lci")


def compared_in_pairs(gains: FloatArray) -> set[int]:
    """Return the points that no other dominates, by comparing every two."""
    points = gains.T.tolist()
    return {
        i
        for i, point in enumerate(points)
        if not any(
            all(a >= b for a, b in zip(other, point, strict=True)) and other != point
            for other in points
        )
    }


@pytest.mark.parametrize("quantities", [2, 3])
def test_rounding_does_not_keep_a_point_on_the_front(quantities: int) -> None:
    rng = np.random.default_rng(quantities)
    gains = rng.integers(1, 9, (quantities, 300)) / 7.0
    noisy = gains * (1.0 + rng.uniform(-1e-15, 1e-15, gains.shape))
    assert set(non_dominated(noisy).tolist()) == compared_in_pairs(gains)


@pytest.mark.parametrize("quantities", [2, 3, 4])
@pytest.mark.parametrize("values", [3, 12, 10**6])
def test_the_front_is_that_of_comparing_every_two(quantities: int, values: int) -> None:
    rng = np.random.default_rng(10 * quantities + values)
    for count in (1, 2, 5, 60, 250):
        gains = rng.integers(0, values, (quantities, count)) / 7.0
        found = non_dominated(gains)
        assert set(found.tolist()) == compared_in_pairs(gains)
        assert len(set(found.tolist())) == len(found)
        assert (np.diff(gains[0, found]) >= 0.0).all()


def test_nothing_has_no_front() -> None:
    for quantities in (2, 3):
        assert len(non_dominated(np.empty((quantities, 0)))) == 0


def test_a_front_of_an_atlas_respects_conditions_and_directions(closed_form: Atlas) -> None:
    conditions = [parse_condition("gci>=0.3"), parse_condition("r1<=2")]
    candidates = Candidates(closed_form, conditions)
    front = pareto_front(candidates, parse_directions("usable_workspace_area,gci,r1:min", KNOWN))
    designs = closed_form.designs
    inside = (closed_form_atlas.conditioning(designs) >= 0.3) & (designs[:, 0] <= 2.0)
    gains = np.array(
        [closed_form_atlas.area(designs), closed_form_atlas.conditioning(designs), -designs[:, 0]]
    )[:, inside]
    expected = designs[inside][sorted(compared_in_pairs(gains))]
    assert front.candidates == np.count_nonzero(inside)
    assert {tuple(each) for each in front.designs} == {tuple(each) for each in expected}
    np.testing.assert_allclose(front.values[0], closed_form_atlas.area(front.designs))
    assert front.signs == (1.0, 1.0, -1.0)


def test_designs_without_values_are_not_on_a_front(tmp_path: Path) -> None:
    with open_atlas(closed_form_atlas.write(tmp_path / "several.h5")) as several:
        candidates = Candidates(several, [], "++/up")
        front = pareto_front(candidates, parse_directions("r1,gci", KNOWN))
        assert len(front.designs)
        assert not closed_form_atlas.empty_designs(front.designs).any()


def test_a_polished_front_cannot_be_beaten(closed_form: Atlas) -> None:
    candidates = Candidates(closed_form, [parse_condition("gci>=0.55")])
    front = pareto_front(candidates, parse_directions("usable_workspace_area,gci", KNOWN))
    polished = polished_front(candidates, front)
    assert len(polished.designs) > 3
    area, gci = polished.values
    np.testing.assert_allclose(area, closed_form_atlas.area(polished.designs), rtol=1e-12)
    np.testing.assert_allclose(gci, closed_form_atlas.conditioning(polished.designs), rtol=1e-12)
    assert (gci >= 0.55 - 1e-12).all()
    # On r3 = 0, where both are largest, the true front runs from r1 = 1.3 to r1 = 1.5.
    r1 = np.linspace(1.3, 1.5, 20001)
    edge = np.column_stack([r1, 3.0 - r1, np.zeros_like(r1)])
    reachable = np.interp(area, closed_form_atlas.area(edge), closed_form_atlas.conditioning(edge))
    np.testing.assert_allclose(gci, reachable, atol=1e-8)
    # none is worse than what it came from
    assert (polished.values >= polished.lattice_values - 1e-9).all()


def test_directions_are_read() -> None:
    expected = (("usable_workspace_area", 1.0), ("gci", 1.0), ("r3", -1.0))
    assert parse_directions("usable_workspace_area,gci,r3:min", KNOWN) == expected
    assert parse_directions(" usable_workspace_area , gci:max, -r3", KNOWN) == expected


@pytest.mark.parametrize("text", ["", "gci", "gci,gci", "gci,-gci", "gci,r3:least", "gci,-r3:min"])
def test_other_directions_are_refused(text: str) -> None:
    with pytest.raises(InputError):
        parse_directions(text, KNOWN)


def test_unknown_quantities_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'gci'"):
        parse_directions("r3,gcj", KNOWN)
