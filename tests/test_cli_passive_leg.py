"""What the commands say of the manipulator with a passive leg, in its own words."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from conftest import Command
from matplotlib.figure import Figure

from fivebar_atlas.figures.atlas_figures import quantity_figure, surface_figure
from fivebar_atlas.store import open_atlas

CHOSEN = ("--mechanism", "passive-leg")
DESIGN = (*CHOSEN, 1, 1.2, 1.4, 1.2)


def written(path: Path, points: Sequence[tuple[float, float]]) -> Path:
    path.write_text("\n".join(["x,y", *(f"{x!r},{y!r}" for x, y in points)]) + "\n")
    return path


def said(figure: Figure) -> str:
    """Return everything that is written in a figure."""
    return " ".join(text.get_text() for axes in figure.axes for text in axes.texts)


@pytest.mark.parametrize(
    ("points", "end"),
    [
        # straight down past O, through y = 0 at x = 0.1
        ([(-0.3, 1.0), (0.3, -0.5)], "(0.1, 0): meets theta_max: the passive leg is at its limit"),
        ([(0.0, 5.0)], "(0, 5): C is out of reach of leg 1, by 2.404"),
        (
            [(0.0, 1.0), (0.0, 3.0)],
            "meets C_1o: leg 1 is stretched (singularity: serial)",
        ),
    ],
)
def test_faults_of_a_path_name_its_own_point_and_call_no_limit_singular(
    points: list[tuple[float, float]], end: str, atlas: Command, tmp_path: Path
) -> None:
    outcome = atlas("path", *DESIGN, written(tmp_path / "points.csv", points))
    assert outcome.code == 1
    assert outcome.out.rstrip().endswith(end)


def test_an_empty_workspace_has_no_size_and_no_indices(atlas: Command) -> None:
    # with elbows outward and upper links below the platform det J_x is nowhere positive
    outcome = atlas("evaluate", *CHOSEN, 1, 2, 3, 2, "--mode", "+-/down")
    rows = {
        line.split()[0]: line.split()[1]
        for line in outcome.out.splitlines()
        if len(line.split()) > 1
    }
    assert rows["status"] == "empty_usable_workspace"
    for name in ("usable_workspace_area", "space_utilisation", "space_utilisation_l_theta"):
        assert rows[name] == "0"
    assert rows["gci"] == rows["gmi"] == rows["max_lci"] == "none"


def test_sizes_have_the_unit_of_their_power(atlas: Command) -> None:
    outcome = atlas("size", *DESIGN, "--area", "100mm2")
    rows = {line.split()[0]: line.split()[1:] for line in outcome.out.splitlines() if line}
    assert [row[1:] for name, row in rows.items() if name.startswith(("gci", "gmi", "max_"))] == [
        *([], ["mm²"], [], ["mm²"]),
        *([], ["mm"], ["mm"]),
    ]
    value, unit = rows["space_utilisation_l_theta"]
    assert unit == "mm⁻¹"
    designs = atlas("evaluate", *DESIGN).out.split("space_utilisation_l_theta")[1].split()[0]
    factor = float(rows["dimensional"][2])
    assert float(value) * factor == pytest.approx(float(designs), rel=1e-7)


def test_slices_are_listed_with_the_design_spaces(atlas: Command) -> None:
    outcome = atlas("mechanisms", "passive-leg")
    assert "design spaces   conditioned, r=VALUE, l_a=VALUE, l_b=VALUE\n" in outcome.out


def test_figures_and_tables_of_an_atlas_say_what_is_fixed_and_chosen(
    atlas: Command, tmp_path: Path
) -> None:
    file = tmp_path / "slice.h5"
    choices = ("--space", "l_a=0.8", "--set", "theta_limit=60", "--resolution", 4)
    assert atlas("sweep", *CHOSEN, *choices, "-q", "-o", file).code == 0
    with open_atlas(file) as opened:
        for draw in (quantity_figure, surface_figure):
            text = said(draw(opened, "gci"))
            assert "theta_limit = 60 deg" in text.replace("\n", " ")
            assert "$l_a$ = 0.8" in text
            assert "passive_joint_limits" not in text  # as where nothing is said
    options = "theta_limit = 60 deg, passive_joint_limits = true"
    assert options in atlas("optimum", file, "--where", "gci>=0.3").out
    assert options in atlas("lookup", 1, 1.2, 0.8, 1.3, file).out
