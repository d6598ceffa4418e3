"""Operating limits: drawn from what a design says, refused where it says nothing.

The design here has the limits of the passive-leg manipulator's first actuator in a closed form
of its own: curves that cross, and a gap.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from conftest import Command
from test_figures_maps import artist, names, written

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError
from fivebar_atlas.figures.limits_figure import limits_figure
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.mechanisms.five_bar.five_bar import FiveBar
from fivebar_atlas.mechanisms.five_bar.mechanism import FiveBarMechanism
from fivebar_atlas.mechanisms.planar import RADIANS, OperatingLimits, PlanarDesign
from fivebar_atlas.mechanisms.scaled_design import ScaledDesign
from fivebar_atlas.mechanisms.settings import Options

Refused = Callable[..., str]
GAP = 0.2


class LimitedDesign(FiveBar):
    """A five-bar with made-up limits over an angle, or over x in another mode pair."""

    def operating_limits(self, mode: str, count: int) -> OperatingLimits:
        """Return limits with a gap around 0; none at all in ``--/down``."""
        places = np.linspace(-1.5, 1.5, count)
        turned = np.stack([places, -places], axis=1)
        greatest = 1.0 + 0.8 * np.sin(turned)
        least = -0.5 + 0.3 * np.cos(turned + 0.2)
        gone = np.abs(places) < (9.0 if mode == "--/down" else GAP)
        greatest[gone] = least[gone] = np.nan
        symbol, name, unit = (r"$\theta$", "angle of the leg", RADIANS)
        if mode == "++/up":
            symbol, name, unit = "$x$", "position", ""
        inputs = (r"$\phi_1$", r"$\phi_2$")
        return OperatingLimits(symbol, name, unit, places, least, greatest, inputs)


class LimitedMechanism(FiveBarMechanism):
    """A mechanism of such designs."""

    name = "limited"

    def planar_design(
        self,
        lengths: Sequence[float],
        unit: str | None = None,
        options: Options = (),  # noqa: ARG002
    ) -> PlanarDesign:
        """Return one design as a machine, or non-dimensional."""
        design = LimitedDesign.from_lengths(*lengths)
        if unit == "":
            return design
        return ScaledDesign(design, design.dimensional_factor, unit or "mm")


@pytest.fixture
def limited(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    monkeypatch.setitem(mechanisms._REGISTRY, "limited", "test_figures_limits:LimitedMechanism")
    yield "limited"
    mechanisms.get.cache_clear()


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_curves_are_the_limits_in_degrees() -> None:
    design = LimitedDesign.from_lengths(26, 30, 16)
    limits = design.operating_limits("+-/up", 61)
    data = PlottedData()
    figure = limits_figure(design, "+-/up", 61, data=data)
    for number in range(2):
        for which in ("least", "greatest"):
            x, y = artist(figure, f"{which}-{number + 1}").get_data()  # type: ignore[attr-defined]
            np.testing.assert_allclose(x, np.degrees(limits.places))
            np.testing.assert_allclose(y, np.degrees(getattr(limits, which)[:, number]))
    # a band on each side of the gap, between its curves
    bands = artist(figure, "band-1").get_paths()  # type: ignore[attr-defined]
    assert len(bands) == 2
    for band, side in zip(bands, (limits.places < -GAP, limits.places > GAP), strict=True):
        x, y = band.vertices.T
        assert (x.min(), x.max()) == pytest.approx(tuple(np.degrees(limits.places[side][[0, -1]])))
        assert y.max() == pytest.approx(np.degrees(limits.greatest[side, 0].max()))
        assert y.min() == pytest.approx(np.degrees(limits.least[side, 0].min()))
    assert {"greatest-1", "least-2", "band-2"} <= names(figure)
    texts = written(figure)
    assert r"angle of the leg $\theta$ (degrees)" in texts
    assert r"inputs $\phi_1$, $\phi_2$ (degrees)" in texts
    for number in (1, 2):
        for which in ("least", "greatest"):
            assert rf"{which} $\phi_{number}$" in texts
    assert [part.element for part in data.parts] == 2 * ["greatest input", "least input"]
    assert all(np.isfinite(part.points).all() for part in data.parts)


def test_every_curve_is_in_the_panel() -> None:
    axes = limits_figure(LimitedDesign.from_lengths(26, 30, 16), "+-/up").axes[0]
    for line in axes.get_lines():
        x, y = line.get_data()
        low, high = axes.get_ylim()
        assert low < np.nanmin(y) < np.nanmax(y) < high
        low, high = axes.get_xlim()
        assert low < np.nanmin(x) < np.nanmax(x) < high


def test_the_command_draws_a_machine_and_writes_its_numbers(
    limited: str, atlas: Command, tmp_path: Path
) -> None:
    output, data = tmp_path / "limits.svg", tmp_path / "limits.csv"
    command = (
        *("plot", "limits", 26, 30, 16, "--mechanism", limited, "-o", output),
        *("--data", data, "--count", 31, "--overwrite"),
    )
    outcome = atlas(*command)
    assert outcome.code == 0, outcome
    assert (outcome.out, outcome.err) == ("", "")
    assert 'id="greatest-1"' in output.read_text()
    rows = table(data)
    assert list(rows[0]) == ["element", "part", "curve", "kind", "x_deg", "y_deg", "value"]
    limits = LimitedDesign.from_lengths(26, 30, 16).operating_limits("+-/up", 31)
    found = [float(row["y_deg"]) for row in rows if row["part"] == "2"]
    expected = np.degrees(limits.least[:, 0])
    np.testing.assert_allclose(found, expected[np.isfinite(expected)])
    first = output.read_bytes()
    assert atlas(*command).code == 0
    assert output.read_bytes() == first
    # a coordinate that is a length has the unit of the machine
    assert atlas(*command, "--mode", "pp/up", "--unit", "cm").code == 0
    rows = table(data)
    assert list(rows[0])[4:6] == ["x_cm", "y_deg"]
    assert float(rows[0]["x_cm"]) == pytest.approx(-1.5 * 24.0)
    assert atlas(*command, "--mode", "pp/up", "--non-dimensional").code == 0
    assert list(table(data)[0])[4:6] == ["x", "y_deg"]


def test_what_has_no_limits_is_refused(limited: str, refused: Refused, tmp_path: Path) -> None:
    output = tmp_path / "limits.png"
    command = ("plot", "limits", 26, 30, 16, "-o", output)
    message = refused(*command)
    assert message.startswith("mechanism: 'five-bar'")
    assert "a mechanism with operating limits over a coordinate" in message
    command = (*command, "--mechanism", limited)
    assert "a mode pair that has a usable workspace" in refused(*command, "--mode", "mm/down")
    assert "+-/up, +-/down" in refused(*command, "--mode", "+-")
    assert "--count" in refused(*command, "--count", 1)
    assert "millimetres from 60 to 400" in refused(*command, "--width", 9)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match="operating limits"):
        FiveBar.from_lengths(26, 30, 16).operating_limits("+-/up", 3)
