"""``atlas plot`` of one design: every kind, the data beside it, and every wrong input."""

from __future__ import annotations

import csv
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import naive
import numpy as np
import pytest
from conftest import Command
from PIL import Image

Refused = Callable[..., str]

KINDS = [
    ("mechanism",),
    ("mechanism", "--all"),
    ("mechanism", "--at", "-5", "38", "--mode", "+-"),
    ("mechanism", "--inputs", "-70", "-20", "--all"),
    ("loci",),
    ("loci", "--mode", "-+"),
    ("loci", "--mode", "mp/down"),
    ("workspace", "--mode", "-+/down"),
    ("good-condition", "--lci", "0.3"),
    ("lci",),
    ("lci", "--lci", "0.3", "--levels", "0.4,0.6"),
]


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("kind", KINDS, ids=" ".join)
def test_every_kind_becomes_a_picture_and_a_table(
    atlas: Command, tmp_path: Path, kind: tuple[str, ...]
) -> None:
    output, data = tmp_path / "figure.png", tmp_path / "data.csv"

    outcome = atlas("plot", kind[0], 26, 30, 16, *kind[1:], "-o", output, "--data", data)

    assert outcome.code == 0, outcome
    assert (outcome.out, outcome.err) == ("", "")
    with Image.open(output) as picture:
        assert picture.width == int(85 / 25.4 * 300)
        assert np.asarray(picture.convert("L"), float).std() > 20.0
    rows = table(data)
    assert list(rows[0]) == ["element", "part", "curve", "kind", "x_mm", "y_mm", "value"]
    reach = max(math.hypot(float(row["x_mm"]), float(row["y_mm"])) for row in rows)
    assert 16.0 < reach <= 26.0 + 30.0 + 16.0
    assert sorted(tmp_path.iterdir()) == [data, output]


@pytest.mark.parametrize(("ending", "start"), [("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_vector_formats_and_overwriting(
    atlas: Command, refused: Refused, tmp_path: Path, ending: str, start: bytes
) -> None:
    output, data = tmp_path / f"loci.{ending}", tmp_path / "loci.csv"
    command = ("plot", "loci", 1.2, 1.0, 0.8, "-o", output, "--data", data)
    assert atlas(*command).code == 0
    first = output.read_bytes(), data.read_bytes()
    assert first[0].startswith(start)

    assert "exists already; --overwrite replaces it" in refused(*command)
    assert atlas(*command, "--overwrite").code == 0
    assert (output.read_bytes(), data.read_bytes()) == first
    output.unlink()
    assert "loci.csv: exists already" in refused(*command)
    assert not output.exists()


def test_non_dimensional_lengths_have_no_unit(atlas: Command, tmp_path: Path) -> None:
    data = tmp_path / "data.csv"
    for number, options in enumerate(((), ("--non-dimensional",), ("--unit", "cm"))):
        lengths = (1.2, 1.0, 0.8) if number == 0 else (12, 10, 8)
        output = tmp_path / f"{number}.svg"
        command = ("plot", "loci", *lengths, *options, "-o", output, "--data", data)
        assert atlas(*command, "--overwrite").code == 0
        names = list(table(data)[0])[4:6]
        assert names == (["x_cm", "y_cm"] if number == 2 else ["x", "y"])
    pictures = [(tmp_path / f"{number}.svg").read_bytes() for number in range(3)]
    assert pictures[0] == pictures[1] != pictures[2]


def test_the_position_and_the_inputs_are_those_asked_for(atlas: Command, tmp_path: Path) -> None:
    output, data = tmp_path / "figure.svg", tmp_path / "data.csv"
    command = ("plot", "mechanism", 26, 30, 16, "-o", output, "--data", data, "--overwrite")

    def joint(name: str, part: int = 0) -> tuple[float, float]:
        rows = [row for row in table(data) if row["element"] == "joint" and row["curve"] == name]
        return float(rows[part]["x_mm"]), float(rows[part]["y_mm"])

    assert atlas(*command, "--at", -5, 38, "--mode", "-+/down").code == 0
    assert joint("P") == pytest.approx((-5.0, 38.0))
    elbow = naive.elbows(26, 30, 16, -5, 38, -1, 1)[0]
    assert joint("B_1") == pytest.approx(tuple(elbow))
    assert atlas(*command, "--inputs", -70, -20).code == 0
    angles = np.radians([-70, -20])
    assert joint("P") == pytest.approx(naive.forward_kinematics(26, 30, 16, *angles, 1))
    assert atlas(*command, "--inputs", -70, -20, "--all").code == 0
    assert joint("P", 1) == pytest.approx(naive.forward_kinematics(26, 30, 16, *angles, -1))
    assert atlas(*command).code == 0
    assert joint("P")[0] == pytest.approx(0.0)
    # the first working mode is taken where none is named, whatever the assembly mode
    assert atlas(*command, "--at", 0, -40).code == 0
    elbow = naive.elbows(26, 30, 16, 0, -40, 1, -1)[0]
    assert joint("B_1") == pytest.approx(tuple(elbow))


@pytest.mark.parametrize("kind", ["workspace", "good-condition", "lci"])
def test_an_empty_workspace_is_drawn_as_loci_and_reported(
    atlas: Command, tmp_path: Path, kind: str
) -> None:
    output = tmp_path / "figure.png"
    outcome = atlas("plot", kind, 1.28, 1.72, 0, "--mode", "++/up", "-o", output)
    assert outcome.code == 0
    assert outcome.out == ""
    assert outcome.err == "the usable workspace of ++/up is empty; singular loci are drawn\n"
    assert output.exists()


@pytest.mark.parametrize("kind", ["good-condition", "lci"])
def test_a_threshold_that_nothing_reaches_is_reported(
    atlas: Command, tmp_path: Path, kind: str
) -> None:
    output = tmp_path / "figure.png"
    outcome = atlas("plot", kind, 0.76, 1.98, 0.26, "--lci", 0.7, "-o", output)
    assert outcome.code == 0
    text = outcome.err.replace("\N{NO-BREAK SPACE}", " ")
    start, _, value = text.partition("the largest LCI is ")
    assert start == "no point has LCI \N{GREATER-THAN OR EQUAL TO} 0.7; "
    assert 0.55 < float(value) < 0.65
    assert output.exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("mechanism", 26, 30, 16, "--at", 100, 100),
            "it is 97.1535 mm farther than the stretched",
        ),
        (("mechanism", 26, 30, 16, "--at", "nan", 1), "two finite numbers"),
        (("mechanism", 26, 30, 16, "--at", 1), "--at"),
        (("mechanism", 26, 30, 16, "--at", 0, 20, "--mode", "-+/up"), "a point of -+/up"),
        (("mechanism", 26, 30, 16, "--inputs", 170, 10), "23.21 mm too far apart"),
        (("mechanism", 26, 30, 16, "--inputs", 70, 20, "--mode", "++/up"), "--mode: '++/up'"),
        (("mechanism", 26, 30, 16, "--inputs", 9, 9, "--at", 1, 1), "exclude each other"),
        (("mechanism", 26, 30, 16, "--at", 5, 38, "--all", "--mode", "+-"), "--mode excludes it"),
        (("mechanism", 1.28, 1.72, 0, "--mode", "++/up"), "that has a usable workspace"),
        (("mechanism", 26, 30, 16, "--mode", "+-"), "mode: '+-'"),
        (("loci", 26, 30, 16, "--mode", "zz"), "one of +-, -+, ++, --"),
        (("workspace", 26, 30, 16, "--mode", "+-"), "+-/up, +-/down"),
        (("loci", 26, 30), "3 numbers: r1 r2 r3"),
        (("loci", 26, 30, 16, 4), "3 numbers: r1 r2 r3"),
        (("loci", 26, 30, "x"), "'x' is not a number"),
        (("loci", 26, 30, -5), "R3: -5.0"),
        (("loci", 26, 30, 90), "R3 at most R1 + R2"),
        (("workspace", 0.75, 0.75, 1.5), "lengths with which the linkage can move"),
        (("loci", 26, 30, 16, "--widht", 90), "--width"),
        (("loci", 26, 30, 16, "--width", 9), "millimetres from 60 to 400"),
        (("loci", 26, 30, 16, "--mechanism", "six-bar"), "five-bar"),
        (("loci", 26, 30, 16, "--unit", "mm", "--non-dimensional"), "exclude each other"),
        (("good-condition", 26, 30, 16, "--lci", 1), "--lci: 1.0"),
        (("lci", 26, 30, 16, "--lci", -0.5), "--lci: -0.5"),
        (("lci", 26, 30, 16, "--levels", "0.5,x"), "numbers separated by commas"),
        (("lci", 26, 30, 16, "--levels", "0.5,2"), "levels: 2.0"),
        (("lci", 26, 30, 16, "--lci", 0.5, "--levels", 0.4), "above 0.5 and below 1"),
        (("locus", 26, 30, 16), "loci"),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(map(str, value)),
)
def test_wrong_input_is_refused_and_nothing_is_written(
    refused: Refused, tmp_path: Path, arguments: tuple[object, ...], message: str
) -> None:
    output, data = tmp_path / "figure.png", tmp_path / "data.csv"
    assert message in refused("plot", *arguments, "-o", output, "--data", data)
    assert list(tmp_path.iterdir()) == []


def test_outputs_are_checked_before_any_work(refused: Refused, tmp_path: Path) -> None:
    output = tmp_path / "figure.png"
    command = ("plot", "loci", "these are", "not", "lengths")
    wrong = ("plot", "loci", 1, 1, 9)
    assert "not a number" in refused(*command, "-o", output)
    assert ".png, .pdf, .svg" in refused(*wrong, "-o", tmp_path / "figure.txt")
    assert "another file" in refused(*wrong, "-o", output, "--data", output)
    absent = tmp_path / "absent"
    assert "does not exist" in refused(*wrong, "-o", output, "--data", absent / "data.csv")
    assert "does not exist" in refused(*wrong, "-o", absent / "figure.png")
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_kind_is_answered_with_all_there_are(
    atlas: Command, refused: Refused, tmp_path: Path
) -> None:
    kinds = ("mechanism", "loci", "workspace", "good-condition", "lci", "area", "region")
    message = refused("plot", "picture", 1, 1, 1, "-o", tmp_path / "figure.png")
    listed = atlas("plot", "--help").out
    for kind in kinds:
        assert kind in message
        assert f"  {kind} " in listed


def test_the_help_of_a_kind_imports_nothing_heavy() -> None:
    script = (
        "import sys\n"
        "from fivebar_atlas.cli import main\n"
        "main(['plot', 'lci', '--help'], standalone_mode=False)\n"
        "heavy = {'numpy', 'numba', 'matplotlib', 'h5py', 'contourpy'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "--levels" in done.stdout
