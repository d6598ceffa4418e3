"""Optima of a mechanism whose designs lie on a line: nothing here knows the five-bar."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import Command

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import AtlasWriter


@pytest.fixture
def file(toy: str, tmp_path: Path) -> Path:
    settings = SweepSettings(toy, "whole", 100, ("left",), (0.5,), 1e-6)
    mechanism = mechanisms.get(toy)
    designs = mechanism.lattice(settings.space, settings.resolution)
    path = tmp_path / "toy.h5"
    with AtlasWriter(path, settings, designs, [(0, len(designs))]) as writer:
        writer.add(0, mechanism.evaluate(designs, settings))
        writer.assemble()
    return path


def test_candidates_and_front_of_a_line(atlas: Command, file: Path) -> None:
    outcome = atlas(
        "optimum", file, "--where", "span>=0.8", "--pareto", "sweep_area,a:min", "--json"
    )
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    a = np.arange(101) / 100.0
    fulfilled = np.hypot(a, 1.0 - a) >= 0.8
    assert document["lattice_designs"] == np.count_nonzero(fulfilled)
    assert document["region"]["is_empty"]
    # the area rises with a, so no design dominates another
    assert len(document["pareto"]["members"]) == np.count_nonzero(fulfilled & (a > 0.0))
    assert atlas("optimum", file, "--where", "span>=0.8").code == 0


def test_the_maximum_of_a_line(atlas: Command, file: Path) -> None:
    outcome = atlas("optimum", file, "--maximise", "sweep_area", "--json")
    assert outcome.code == 0, outcome.err
    maximum = json.loads(outcome.out)["maximum"]
    assert maximum["value"] == pytest.approx(1.0)
    assert maximum["design"]["a"] == pytest.approx(1.0)


def test_a_line_has_no_triangle_to_look_up(atlas: Command, file: Path) -> None:
    outcome = atlas("lookup", "0.3", "0.7", file)
    assert outcome.code == 2
    assert "between those of the lattice" in outcome.err
