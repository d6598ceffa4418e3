"""Design spaces that are slices of a larger one: a mechanism has more than it can list."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Command

from fivebar_atlas import mechanisms
from fivebar_atlas.config import Overrides, render_settings, resolve
from fivebar_atlas.store import open_atlas
from fivebar_atlas.synthesis.design_polygon import DesignPolygon


@pytest.fixture
def file(sliced: str, tmp_path: Path, atlas: Command) -> Path:
    path = tmp_path / "slice.h5"
    options = ("--mechanism", sliced, "--space", "b=.250", "--resolution", 8, "-q", "-o", path)
    outcome = atlas("sweep", *options)
    assert outcome.code == 0, outcome.err
    return path


def test_a_slice_is_written_in_one_way_only(sliced: str, file: Path) -> None:
    ways = ("b=0.25", "b=.25", "b=0.250")
    texts = {render_settings(resolve(None, Overrides(sliced, space=way)).settings) for way in ways}
    (text,) = texts
    assert 'space = "b=0.25"' in text
    with open_atlas(file) as opened:
        assert opened.settings.space == "b=0.25"
        assert len(opened) == 81
        assert set(opened["b"]) == {0.25}


def test_a_space_that_is_none_is_refused_with_those_there_are(
    sliced: str, tmp_path: Path, refused: Callable[..., str]
) -> None:
    output = tmp_path / "none.h5"
    line = refused("sweep", "--mechanism", sliced, "--space", "b=2", "-o", output)
    assert line.startswith("--space: ")
    assert "b=VALUE" in line
    assert "'b=2'" in line
    assert not output.exists()


def test_points_and_designs_of_every_slice_are_inverse(sliced: str) -> None:
    mechanism = mechanisms.get(sliced)
    points = np.random.default_rng(3).random((20, 2))
    for space, column in (("a=0.1", 0), ("b=0.2", 1), ("c=0.3", 2)):
        designs = mechanism.unproject(points, space)
        np.testing.assert_array_equal(mechanism.project(designs, space), points)
        assert mechanism.are_in_space(designs, space).all()
        designs[:5, column] += 0.01
        assert mechanism.are_in_space(designs, space).tolist() == [False] * 5 + [True] * 15


def test_sides_are_named_by_parameters_that_are_free(sliced: str) -> None:
    mechanism = mechanisms.get(sliced)
    polygon = DesignPolygon.of_space(mechanism, "b=0.25")
    assert sorted(polygon.names(mechanism, "b=0.25")) == ["a = 0", "a = 1", "c = 0", "c = 1"]


def test_designs_of_the_slice_are_looked_up_and_no_others(
    atlas: Command, file: Path, refused: Callable[..., str]
) -> None:
    found = json.loads(atlas("lookup", 1, 0.3, 0.25, 0.7, file, "--json").out)
    (value,) = found["values"]
    assert value["exact"] == pytest.approx(0.3 + 0.0625 + 2.1, rel=1e-14)
    assert value["interpolated"] == pytest.approx(value["exact"], rel=1e-14)
    line = refused("lookup", 1, 0.3, 0.26, 0.7, file)
    assert line.startswith("design: ")
    assert "b=0.25 space" in line
    assert "beyond c = 1" in refused("lookup", 1, 0.3, 0.25, 1.7, file)


def test_the_best_design_of_a_slice_keeps_its_fixed_parameter(atlas: Command, file: Path) -> None:
    where = ("--where", "a<=0.55", "--where", "stretch>=0.5")
    outcome = atlas("optimum", file, *where, "--maximise", "stretch", "--json")
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    design = document["maximum"]["design"]
    assert design == {"a": pytest.approx(0.55), "b": 0.25, "c": pytest.approx(1.0)}
    assert document["region"]["extent"]["b"] == [0.25, 0.25]
    assert all(corner[1] == 0.25 for loop in document["region"]["outline"] for corner in loop)
