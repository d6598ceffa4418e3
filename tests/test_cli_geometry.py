"""``atlas geometry``: what it lists, what it writes, and what it refuses."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import pytest
from conftest import Command

KINDS = ("loci", "workspace", "good-condition", "circles")
REFUSED: list[tuple[tuple[object, ...], str]] = [
    (("locus", 26, 30, 16), "KIND: 'locus' is not allowed; expected one of loci, workspace"),
    (("--jsn", "loci", 26, 30, 16), "No such option '--jsn'"),
    (("loci", 26, 30, 16, "--mod", "+-"), "No such option '--mod'"),
    (("loci",), "expected 3 numbers: r1 r2 r3"),
    (("loci", 26, 30), "expected 3 numbers: r1 r2 r3"),
    (("loci", 26, "x", 16), "'x' is not a number"),
    (("loci", -26, 30, 16), "R1: -26.0 is not allowed"),
    (("loci", 1, 1, 2.5), "R3 at most R1 + R2"),
    (("loci", 26, 30, 16, "--mode", "+*"), "mode: '+*' is not allowed; expected one of +-, -+"),
    (("workspace", 26, 30, 16, "--mode", "+-"), "'+-' is not allowed; expected one of +-/up"),
    (("workspace", 26, 30, 16, "--mode", "all"), "'all' is not allowed; expected one of +-/up"),
    (("workspace", 26, 30, 16, "--lci", 0.5), "--lci belongs to good-condition, not to workspace"),
    (("good-condition", 26, 30, 16, "--lci", 1.5), "1.5 is not allowed; expected a number above 0"),
    (("loci", 26, 30, 16, "--deviation", 1), "--deviation: 1.0 is not allowed; expected a number"),
    (("loci", 26, 30, 16, "--unit", "cm", "--non-dimensional"), "exclude each other"),
    (("loci", 26, 30, 16, "--mechanism", "hexapod"), "'hexapod' is not allowed"),
]


def document(atlas: Command, *arguments: object) -> dict[str, Any]:
    outcome = atlas("geometry", *arguments, "--json")
    assert outcome.code == 0, outcome
    parsed: dict[str, Any] = json.loads(outcome.out)
    return parsed


def rows_of(text: str) -> list[list[str]]:
    """Return the cells of the lines of a table that begin with the name of a curve."""
    return [
        re.split(r" {2,}", line)
        for line in text.splitlines()
        if re.match(r"(C_|MIC_|LCI)\S* ", line) or line.startswith("LCI = ")
    ]


def test_table_of_loci_has_a_line_for_each_arc(atlas: Command) -> None:
    outcome = atlas("geometry", "loci", 26, 30, 16)
    assert (outcome.code, outcome.err) == (0, "")
    head = outcome.out.splitlines()[:2]
    assert head[0] == "singular loci: five-bar R1 = 26 mm, R2 = 30 mm, R3 = 16 mm"
    assert head[1] == "D = 24 mm; sub-region Va"
    rows = rows_of(outcome.out)
    arcs = document(atlas, "loci", 26, 30, 16)["arcs"]
    assert len(rows) == len(arcs) == 26
    for row, arc in zip(rows, arcs, strict=True):
        assert row[:2] == [arc["curve"], arc["kind"]]
        for cell, point in zip(row[2:4], (arc["start"], arc["end"]), strict=True):
            numbers = [float(part) for part in cell.strip("()").split(", ")]
            assert numbers == pytest.approx(point, rel=1e-6, abs=1e-12)
        assert float(row[4]) == pytest.approx(arc["length"], rel=1e-6)
        assert row[5] == ", ".join(arc["ends"])
        if arc["circle"] is not None:
            assert float(row[7]) == pytest.approx(arc["circle"]["radius"], rel=1e-6)
        for pair, side in arc["modes"].items():
            assert re.search(rf"{side}: [^;]*{re.escape(pair)}", row[-1])


def test_table_of_a_workspace_has_both_areas(atlas: Command) -> None:
    outcome = atlas("geometry", "workspace", 1.2, 1.0, 0.8)
    assert outcome.code == 0
    assert [row[0] for row in rows_of(outcome.out)] == [
        *("C_coin_down", "C_1o", "C_2o"),
        *("C_col", "C_2i", "C_coin_up", "C_1i"),
    ]
    assert "outline, counter-clockwise: length 10.434" in outcome.out
    assert "hole 1, clockwise: length 6.7437" in outcome.out
    areas = re.findall(r"^area \S+.*?([\d.]+)$", outcome.out, re.MULTILINE)
    values = json.loads(atlas("evaluate", 1.2, 1.0, 0.8, "--json").out)["modes"][0]
    assert [float(area) for area in areas] == [
        pytest.approx(values["usable_workspace_area"], rel=1e-8)
    ] * 2


def test_tables_show_units_modes_and_errors(atlas: Command) -> None:
    machine = atlas("geometry", "workspace", 26, 30, 16, "--unit", "cm").out
    assert "area 5371.3581 cm²" in machine
    scaled = atlas("geometry", "workspace", 26, 30, 16, "--non-dimensional").out
    assert float(re.findall(r"area ([\d.]+)", scaled)[0]) == pytest.approx(5371.35809952 / 576.0)
    assert scaled.splitlines()[1] == "sub-region Va"
    assert "mm" not in scaled
    good = atlas("geometry", "good-condition", 1.28, 1.72, 0).out
    areas = re.findall(r"^(?:region: )?area\D+([\d.]+)$", good, re.MULTILINE)
    assert [float(area) for area in areas] == [pytest.approx(19.77874, abs=5e-5)] * 3
    circles = atlas("geometry", "circles", 1.28, 1.72, 0, "--mode", "mp/down").out
    assert [(row[0], row[-2], row[-1]) for row in rows_of(circles)] == [
        ("MIC_upper", "(0, 1.72)", "1.28"),
        ("MIC_lower", "(0, -1.72)", "1.28"),
    ]
    assert "-0" not in circles


@pytest.mark.parametrize(
    ("mode", "label", "pairs"),
    [
        ("+-/up", "+-/up", {"+-/up"}),
        ("pm", "+-", {"+-/up", "+-/down"}),
        ("--", "--", {"--/up", "--/down"}),
    ],
)
def test_loci_of_modes(atlas: Command, mode: str, label: str, pairs: set[str]) -> None:
    found = document(atlas, "loci", 26, 30, 16, "--mode", mode)
    assert found["mode"] == label
    assert {pair for arc in found["arcs"] for pair in arc["modes"]} == pairs


def test_change_points_are_remarked(atlas: Command) -> None:
    outcome = atlas("geometry", "loci", 1, 1, 1)
    assert "change-point manipulator (a, b)" in outcome.out
    outcome = atlas("geometry", "loci", 1.2, 1.2, 0.6)
    assert "isolated singular points: (-0.6, 0), (0.6, 0)" in outcome.out


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_written_in_every_format(atlas: Command, kind: str, tmp_path: Path) -> None:
    for form in ("csv", "svg", "dxf"):
        path = tmp_path / f"{kind}.{form}"
        outcome = atlas("geometry", kind, 26, 30, 16, "-o", path)
        assert (outcome.code, outcome.out) == (0, "")
        arcs = re.search(r"(\d+) arcs?\b", outcome.err)
        assert arcs is not None
        if form == "csv":
            with path.open(newline="") as file:
                numbers = {row["arc"] for row in csv.DictReader(file)}
            assert len(numbers) == int(arcs[1])
        elif form == "svg":
            assert len(re.findall(r'id="arc_\d+"', path.read_text())) == int(arcs[1])
        else:
            entities = ezdxf.readfile(path).modelspace().query("ARC CIRCLE LWPOLYLINE")
            assert len(entities) == int(arcs[1])


def test_deviation_sets_how_many_points_there_are(atlas: Command, tmp_path: Path) -> None:
    counts = []
    for share in (1e-2, 1e-4):
        path = tmp_path / f"{share}.csv"
        atlas("geometry", "loci", 1.28, 1.72, 0, "-o", path, "--deviation", share)
        with path.open(newline="") as file:
            lines = [row for row in csv.DictReader(file) if row["arc"] == "1"]
        counts.append(len(lines))
        half_angle = math.pi / (len(lines) - 1)
        assert 3.0 * (1.0 - math.cos(half_angle)) == pytest.approx(share, rel=0.1)
    assert counts[1] > 9 * counts[0]


def test_json_and_a_file_at_once_and_quietly(atlas: Command, tmp_path: Path) -> None:
    path = tmp_path / "loci.svg"
    outcome = atlas("geometry", "loci", 26, 30, 16, "-o", path, "--json", "--quiet")
    assert outcome.err == ""
    assert json.loads(outcome.out)["kind"] == "loci"
    assert path.exists()


def test_an_empty_workspace_is_said_to_be_empty(
    atlas: Command, refused: Callable[..., str], tmp_path: Path
) -> None:
    arguments = ("workspace", 1.28, 1.72, 0, "--mode", "++/up")
    outcome = atlas("geometry", *arguments)
    assert outcome.code == 0
    assert outcome.out.splitlines()[-1] == "the usable workspace of ++/up is empty"
    assert document(atlas, *arguments)["absence"] == "the usable workspace of ++/up is empty"
    path = tmp_path / "empty.dxf"
    message = refused("geometry", *arguments, "-o", path, code=1)
    assert message.endswith("there is nothing to write: the usable workspace of ++/up is empty")
    assert not list(tmp_path.iterdir())


def test_a_threshold_that_is_not_reached(
    atlas: Command, refused: Callable[..., str], tmp_path: Path
) -> None:
    arguments = ("good-condition", 1.0, 0.7, 1.3, "--mode", "++/down", "--lci", 0.9)
    last = atlas("geometry", *arguments).out.splitlines()[-1]
    assert last.startswith("LCI reaches 0.9 nowhere in the usable workspace of ++/down; the larg")
    assert last in refused("geometry", *arguments, "-o", tmp_path / "good.svg", code=1)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("arguments", "message"), REFUSED)
def test_wrong_inputs_are_named(
    refused: Callable[..., str], arguments: tuple[object, ...], message: str, tmp_path: Path
) -> None:
    assert message in refused("geometry", *arguments)
    if "--jsn" not in arguments:
        assert message in refused("geometry", *arguments, "-o", tmp_path / "out.csv")
    assert not list(tmp_path.iterdir())


def test_wrong_files_are_named(refused: Callable[..., str], tmp_path: Path) -> None:
    command = ("geometry", "loci", 26, 30, 16, "-o")
    assert "one of .csv, .svg, .dxf" in refused(*command, tmp_path / "loci.stl")
    assert "one of .csv, .svg, .dxf" in refused(*command, tmp_path / "loci")
    assert "does not exist" in refused(*command, tmp_path / "nowhere" / "loci.csv")
    taken = tmp_path / "loci.csv"
    taken.write_text("mine")
    assert "--overwrite" in refused(*command, taken)
    assert taken.read_text() == "mine"


def test_isolated_singular_points_of_a_workspace_are_listed(atlas: Command) -> None:
    outcome = atlas("geometry", "workspace", 1.5, 1.5, 0)
    assert "isolated singular points: (0, 0)" in outcome.out
