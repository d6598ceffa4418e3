"""Figures of Pareto fronts: what is drawn where, what the key says, and the command."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import closed_form_atlas
import closed_form_mechanism
import numpy as np
import pytest
from conftest import Command
from matplotlib.figure import Figure

from fivebar_atlas.errors import InputError
from fivebar_atlas.figures.atlas_figures import front_figure
from fivebar_atlas.store import Atlas, open_atlas
from fivebar_atlas.synthesis.candidates import Candidates
from fivebar_atlas.synthesis.conditions import parse_condition
from fivebar_atlas.synthesis.pareto import ParetoFront, pareto_front

QUANTITIES = ("usable_workspace_area", "gci")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Atlas]:
    path = tmp_path_factory.mktemp("figures_pareto") / "closed_form.h5"
    with open_atlas(closed_form_atlas.write(path)) as opened:
        yield opened


def drawn(figure: Figure, gid: str) -> np.ndarray:
    """Return the points of a line by its name, shape (2, n)."""
    (line,) = [each for each in figure.axes[0].lines if each.get_gid() == gid]
    return np.array(line.get_data())


def texts(figure: Figure) -> str:
    written = [text.get_text() for axes in figure.axes for text in axes.texts]
    return " | ".join([*written, *(text.get_text() for text in figure.texts)])


def draw(atlas: Atlas, *wheres: str, designs: bool = False) -> tuple[Figure, ParetoFront]:
    conditions = [parse_condition(where) for where in wheres]
    candidates = Candidates(atlas, conditions, "+-/up")
    front = pareto_front(candidates, [(name, 1.0) for name in QUANTITIES])
    members = (
        atlas.mechanism.project(front.designs, atlas.settings.space).T if designs else front.values
    )
    figure = front_figure(
        atlas,
        QUANTITIES,
        candidates.fulfilled,
        members,
        [(each.quantity, each.operator, each.bound) for each in conditions],
        candidates.region.region if conditions else None,
        "+-/up",
        in_design_space=designs,
    )
    return figure, front


def test_every_design_is_a_dot_and_the_front_stands_out(small: Atlas) -> None:
    figure, front = draw(small, "gci>=0.5")
    values = np.array([small.select(name, "+-/up") for name in QUANTITIES])
    inside = values[1] >= 0.5
    np.testing.assert_array_equal(drawn(figure, "designs"), values[:, inside])
    np.testing.assert_array_equal(drawn(figure, "other designs"), values[:, ~inside])
    np.testing.assert_array_equal(drawn(figure, "pareto front"), front.values)
    axes = figure.axes[0]
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    assert (values.min(axis=1) > low).all()
    assert (values.max(axis=1) < high).all()
    written = texts(figure)
    assert f"Pareto front, {len(front.designs)} designs" in written
    assert "usable workspace area $W$ (in units of $D^2$)" in written
    assert "mode" in written


def test_in_the_design_space_members_and_ends_are_marked(small: Atlas) -> None:
    figure, front = draw(small, "r1<=1.6", designs=True)
    places = small.mechanism.project(front.designs, small.settings.space)
    np.testing.assert_array_equal(drawn(figure, "pareto front"), places.T)
    np.testing.assert_array_equal(drawn(figure, "best GCI")[:, 0], places[0])
    np.testing.assert_array_equal(drawn(figure, "best $W$")[:, 0], places[-1])
    assert "$r_1$ \N{LESS-THAN OR EQUAL TO} 1.6" in texts(figure)


def test_an_empty_front_is_said_to_be_empty(small: Atlas) -> None:
    for designs in (False, True):
        figure, front = draw(small, "gci>=0.9", designs=designs)
        assert len(front.designs) == 0
        assert "no design fulfils GCI" in texts(figure)


def test_the_width_is_checked(small: Atlas) -> None:
    empty = np.empty((2, 0))
    with pytest.raises(InputError, match="millimetres"):
        front_figure(
            small, QUANTITIES, np.ones(len(small), dtype=bool), empty, [], None, "+-/up", width=1.0
        )


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_the_command_writes_a_figure(atlas: Command, tmp_path: Path, ending: str) -> None:
    file = closed_form_atlas.write(tmp_path / "file.h5")
    output = tmp_path / f"front.{ending}"
    arguments = ("plot", "pareto", file, "--pareto", "usable_workspace_area,gci", "-o")
    outcome = atlas(*arguments, output, "--mode", "pm/up", "--where", "r1<=1.6")
    assert outcome.code == 0, outcome.err
    assert "designs are on the front" in outcome.out
    assert output.stat().st_size > 5000
    first = output.read_bytes()
    atlas(*arguments, output, "--mode", "pm/up", "--where", "r1<=1.6", "--overwrite")
    assert output.read_bytes() == first


def test_the_command_polishes_and_draws_the_design_space(atlas: Command, tmp_path: Path) -> None:
    file = closed_form_mechanism.write(tmp_path / "file.h5", "five-bar", 24)
    output = tmp_path / "front.png"
    quantities = "usable_workspace_area,r3:min"
    arguments = ("--pareto", quantities, "--designs", "--polish", "-o", output)
    outcome = atlas("plot", "pareto", file, *arguments)
    assert outcome.code == 0, outcome.err
    # on r3 = 0, r1 = r2 both are best
    assert outcome.out.startswith("1 of ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--pareto", "gci"), "at least two"),
        (("--pareto", "gci,r3,r1"), "two quantities, the axes"),
        (("--pareto", "gci,speed"), "one of r1"),
        (("--pareto", "gci,r3"), "--mode must be given"),
        (("--pareto", "gci,r3", "--where", "r3>1", "--where", "r3<0.5"), "contradict"),
    ],
)
def test_wrong_input_is_refused(
    refused: Callable[..., str], tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    file = closed_form_atlas.write(tmp_path / "file.h5")
    output = tmp_path / "front.png"
    assert message in refused("plot", "pareto", file, *arguments, "-o", output)
    assert not output.exists()
