"""What Nam and Park (2006), Sec. 6.2, say of their atlas, evaluated on ours.

The verdicts are those of the table in docs/passive_leg.md, which these tests hold to its numbers.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy import stats

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.settings import SweepSettings

MECHANISM = mechanisms.get("passive-leg")
STEPS = 60
VALUES = np.linspace(0.5, 2.0, STEPS + 1)
NAMES = ("gci", "gmi", "space_utilisation")
#: (r, l_b) of Fig. 8.
SHOWN = ((0.9, 1.2), (1.2, 0.9), (1.2, 1.2))

Table = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def atlas() -> dict[str, Table]:
    """Quantities of the conditioned space, l_b along rows and r along columns."""
    settings = SweepSettings("passive-leg", "conditioned", STEPS, ("+-/up",), (), 1e-5)
    results = MECHANISM.evaluate(MECHANISM.lattice("conditioned", STEPS), settings)
    tables = {}
    for name in (*NAMES, *(f"{name}_l_theta" for name in NAMES)):
        # the corner where l_a = 0 is no design
        tables[name] = np.concatenate([[np.nan], results[name][:, 0]]).reshape(STEPS + 1, -1)
    return tables


def normalised(table: Table) -> Table:
    return (table - np.nanmin(table)) / (np.nanmax(table) - np.nanmin(table))


def composed(atlas: dict[str, Table], suffix: str = "") -> Table:
    return np.prod([normalised(atlas[name + suffix]) for name in NAMES], axis=0)


def row(table: Table, l_b: float, least_r: float = 1.0) -> Table:
    """Return a row of a table from some r on."""
    (at,) = np.flatnonzero(np.isclose(VALUES, l_b))
    return table[at, least_r - 1e-9 <= VALUES]


def share(conditions: npt.NDArray[np.bool_], exist: npt.NDArray[np.bool_]) -> float:
    return float(conditions[exist].mean())


def rising(table: Table, axis: int) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return which lattice steps rise, and which there are."""
    steps = np.diff(table, axis=axis)
    return steps > 0.0, np.isfinite(steps)


def gradients(table: Table) -> tuple[float, float]:
    """Return mean gradients where both ratios are small, and where both are large."""
    along = np.hypot(*np.gradient(table, VALUES[1] - VALUES[0]))
    small, large = VALUES <= 0.8 + 1e-9, VALUES >= 1.2 - 1e-9
    means = (np.nanmean(along[np.ix_(part, part)]) for part in (small, large))
    return next(means), next(means)


def test_gci_varies_little_with_r_beyond_1_2(atlas: dict[str, Table]) -> None:
    far = atlas["gci"][:, VALUES >= 1.2 - 1e-9]
    spans = np.ptp(far, axis=1)
    assert np.max(spans / far.mean(axis=1)) == pytest.approx(0.082, abs=0.001)
    assert np.max(spans) / np.ptp(atlas["gci"][np.isfinite(atlas["gci"])]) == pytest.approx(
        0.058, abs=0.001
    )


def test_gci_increases_with_l_b(atlas: dict[str, Table]) -> None:
    rises, exist = rising(atlas["gci"], 0)
    assert share(rises[:, VALUES >= 1.0], exist[:, VALUES >= 1.0]) == 1.0
    assert share(rises, exist) == pytest.approx(0.987, abs=0.001)


def test_gci_is_sensitive_for_small_ratios(atlas: dict[str, Table]) -> None:
    assert gradients(atlas["gci"]) == pytest.approx((0.65, 0.08), abs=0.01)


def test_manipulability_depends_on_r(atlas: dict[str, Table]) -> None:
    """The paper says that it hardly does."""
    at_two = row(atlas["gmi"], 2.0)
    assert (at_two[0], at_two[-1]) == pytest.approx((1.759, 3.527), abs=0.001)
    ratios = at_two / row(atlas["gmi"], 1.2)
    assert (ratios.min(), ratios.max()) == pytest.approx((2.5, 3.6), abs=0.1)


def test_manipulability_increases_with_l_b(atlas: dict[str, Table]) -> None:
    rises, exist = rising(atlas["gmi"], 0)
    assert share(rises, exist) == 1.0
    assert exist[:, VALUES >= 1.0].mean() > 0.8


def test_manipulability_is_not_sensitive_for_small_ratios(atlas: dict[str, Table]) -> None:
    """The paper says that it is; there it is small, or infinite."""
    small, large = gradients(atlas["gmi"])
    assert (small, large) == pytest.approx((0.31, 2.6), abs=0.05)


def test_space_utilisation_increases_with_l_b(atlas: dict[str, Table]) -> None:
    rises, exist = rising(atlas["space_utilisation"], 0)
    assert share(rises, exist) == 1.0


def test_space_utilisation_turns_with_r_near_1_2(atlas: dict[str, Table]) -> None:
    rises, exist = rising(atlas["space_utilisation"], 1)
    wide = VALUES[:-1] >= 1.0
    low, high = VALUES < 1.2 - 1e-9, VALUES > 1.2 + 1e-9
    assert share(rises[low][:, wide], exist[low][:, wide]) == pytest.approx(0.95, abs=0.01)
    assert share(~rises[high][:, wide], exist[high][:, wide]) == pytest.approx(0.97, abs=0.01)
    narrow = VALUES[1:] <= 0.9
    up_to = VALUES <= 1.6
    assert share(rises[up_to][:, narrow], exist[up_to][:, narrow]) == 1.0


def test_in_the_l_theta_measure_space_utilisation_behaves_otherwise(
    atlas: dict[str, Table],
) -> None:
    rises, exist = rising(atlas["space_utilisation_l_theta"], 1)
    wide, low = VALUES[:-1] >= 1.0, VALUES < 1.2 - 1e-9
    assert share(rises[low][:, wide], exist[low][:, wide]) == pytest.approx(0.15, abs=0.01)


def test_composed_index_increases_with_l_b(atlas: dict[str, Table]) -> None:
    for suffix in ("", "_l_theta"):
        rises, exist = rising(composed(atlas, suffix), 0)
        assert share(rises, exist) == 1.0


def test_composed_index_depends_on_r(atlas: dict[str, Table]) -> None:
    """The paper says that it hardly does."""
    for l_b, ends in ((2.0, (0.49, 0.83)), (1.2, (0.05, 0.15))):
        along = row(composed(atlas), l_b)
        assert (along.min(), along.max()) == pytest.approx(ends, abs=0.005)


def test_singularities_are_inside_where_the_paper_has_none(atlas: dict[str, Table]) -> None:
    """For r > R exactly where the curve det J_x = 0 leaves O at an angle within reach."""
    wide = VALUES > 1.0
    r, l_b = np.meshgrid(VALUES[wide], VALUES)
    bounded = np.isfinite(atlas["gmi"][:, wide])
    assert (~bounded).mean() == pytest.approx(0.19, abs=0.01)
    clear = np.abs(l_b - r / (2.0 * r - 1.0)) > 1e-9
    np.testing.assert_array_equal(bounded[clear], (l_b > r / (2.0 * r - 1.0))[clear])


@pytest.mark.parametrize(("r", "l_b"), [(2.0, 0.5), (1.5, 0.6), (1.2, 0.7)])
def test_the_angle_at_which_the_singular_curve_leaves_the_origin(r: float, l_b: float) -> None:
    start = np.arccos((r + l_b - 2.0 * r * l_b) / (r - l_b))
    design = MECHANISM.planar_design((1.0, r, l_b - 1.0 + r, l_b), "", ())
    near = 1e-4
    signs = []
    for theta in (start - 1e-3, start + 1e-3):
        matrix = design.jacobian(
            np.array([-near * np.sin(theta)]), np.array([near * np.cos(theta)]), "+-"
        )
        signs.append(np.sign(np.linalg.det(matrix[0])))
    assert signs[0] == -signs[1]


@pytest.fixture(scope="module", params=SHOWN, ids=str)
def shown(request: pytest.FixtureRequest) -> tuple[float, float]:
    chosen: tuple[float, float] = request.param
    return chosen


def test_areas_of_fig_8() -> None:
    areas = [
        MECHANISM.planar_design((1.0, r, l_b - 1.0 + r, l_b)).usable_workspace("+-/up")
        for r, l_b in SHOWN
    ]
    assert [each.area for each in areas if each is not None] == pytest.approx(
        [4.150, 2.726, 5.785], abs=0.001
    )


def test_lci_grows_outward_but_not_to_the_boundary(shown: tuple[float, float]) -> None:
    r, l_b = shown
    l_a = l_b - 1.0 + r
    design = MECHANISM.planar_design((1.0, r, l_a, l_b))
    x, y = (
        each.ravel() for each in np.meshgrid(np.linspace(-2, 2, 201), np.linspace(0.01, 3, 150))
    )
    lci = design.lci_inside(x, y, "+-/up")
    theta, length = np.arctan2(-x, y), np.hypot(x, y)
    largest = -np.abs(np.sin(theta)) + np.sqrt((l_a + l_b) ** 2 - (np.cos(theta) - r) ** 2)
    out = length / largest
    inner = (lci > 0.0) & (out < 0.9)
    assert 0.83 < stats.spearmanr(out[inner], lci[inner]).statistic < 0.91
    rim = (lci > 0.0) & (out > 0.98)
    below = (lci > 0.0) & (out > 0.8) & (out < 0.9)
    assert lci[rim].mean() < 0.6 * lci[below].mean()


def test_greatest_input_is_on_the_outer_boundary(shown: tuple[float, float]) -> None:
    r, l_b = shown
    l_a = l_b - 1.0 + r
    design = MECHANISM.planar_design((1.0, r, l_a, l_b))
    limits = design.operating_limits("+-/up", 37)
    for theta, greatest in zip(limits.places, limits.greatest, strict=True):
        if theta < 0.01 or np.isnan(greatest).any():
            continue
        # there leg 1 is stretched: both links point from B_1 to b_1
        length = -np.sin(theta) + np.sqrt((l_a + l_b) ** 2 - (np.cos(theta) - r) ** 2)
        tip = length * np.array([-np.sin(theta), np.cos(theta)]) + r * np.array(
            [np.cos(theta), np.sin(theta)]
        )
        assert greatest[0] == pytest.approx(np.arctan2(tip[1], tip[0] - 1.0), abs=1e-6)
