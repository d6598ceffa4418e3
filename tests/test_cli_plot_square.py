"""``atlas plot`` of the largest square: every kind, the data beside it, and every wrong input."""

from __future__ import annotations

import csv
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Command
from PIL import Image

from fivebar_atlas import mechanisms
from fivebar_atlas.cli.square_options import (
    check_ratio,
    machine_lengths,
    parse_aspect,
    parse_ratios,
    square_task,
)
from fivebar_atlas.errors import InputError

Refused = Callable[..., str]

KINDS = [
    ("square-curve", "--rho", "1.4:2:0.2"),
    ("square-curve", "--rho", "1.4:1.6:0.2", "--actuator-range", "2", "20", "240"),
    ("square-curve", "--rho", "1.6:1.7:0.1", "--centre", "axis", "--aspect", "3:2"),
    ("square-curve", "--rho", "2:3:1", "--lci", "0.3", "--mode", "pp/up"),
    ("square", "--rho", "1.6"),
    ("square", "--lengths", "50", "80", "21", "--lci", "0.3", "--half", "lower"),
    ("square", "--rho", "2", "--actuator-range", "1", "-60", "170"),
    ("optimal-configuration", "--rho", "1.6"),
]


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("kind", KINDS, ids=" ".join)
def test_every_kind_becomes_a_picture_and_a_table(
    atlas: Command, tmp_path: Path, kind: tuple[str, ...]
) -> None:
    output, data = tmp_path / "figure.png", tmp_path / "data.csv"

    outcome = atlas("plot", *kind, "-o", output, "--data", data)

    assert outcome.code == 0, outcome
    assert outcome.out == ""
    with Image.open(output) as picture:
        assert picture.width == int(85 / 25.4 * 300)
        assert np.asarray(picture.convert("L"), float).std() > 20.0
    unit = "" if kind[0] == "square-curve" else "_l1"
    names = list(table(data)[0])
    assert names == ["element", "part", "curve", "kind", f"x{unit}", f"y{unit}", "value"]


def test_the_table_of_a_curve_holds_its_pieces_and_its_largest_side(
    atlas: Command, tmp_path: Path
) -> None:
    output, data = tmp_path / "figure.svg", tmp_path / "data.csv"
    outcome = atlas("plot", "square-curve", "--rho", "1.2:4:0.2", "-o", output, "--data", data)
    assert outcome.code == 0, outcome
    rows = table(data)
    pieces = list(dict.fromkeys(row["curve"] for row in rows if row["curve"]))
    assert pieces == [
        "LCI at the lower side", "LCI at the upper corners", "LCI at the lower corners",
    ]  # fmt: skip
    (largest,) = [row for row in rows if row["element"] == "largest side"]
    assert float(largest["x"]) == pytest.approx(1.5260005739, abs=1e-8)
    assert float(largest["y"]) == pytest.approx(1.3322459135, abs=1e-8)


def test_lengths_and_a_ratio_give_the_same_square(atlas: Command, tmp_path: Path) -> None:
    half = 30.0 * math.sqrt(0.5)
    tables = []
    for number, machine in enumerate((("--rho", 1.6), ("--lengths", 50, 80, half))):
        data = tmp_path / f"{number}.csv"
        outcome = atlas(
            "plot", "square", *machine, "-o", tmp_path / f"{number}.png", "--data", data
        )
        assert outcome.code == 0, outcome
        tables.append(
            np.array(
                [
                    (float(row["x_l1"]), float(row["y_l1"]))
                    for row in table(data)
                    if row["element"].startswith("largest square")
                ]
            )
        )
    assert len(tables[0]) == 5
    np.testing.assert_allclose(tables[0], tables[1], rtol=0.0, atol=1e-12)
    assert np.ptp(tables[0][:, 0]) == pytest.approx(1.3293069197, abs=1e-9)


@pytest.mark.parametrize("kind", [KINDS[0], KINDS[4], KINDS[7]], ids=" ".join)
@pytest.mark.parametrize(("ending", "start"), [("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_vector_formats_and_overwriting(
    atlas: Command,
    refused: Refused,
    tmp_path: Path,
    kind: tuple[str, ...],
    ending: str,
    start: bytes,
) -> None:
    output, data = tmp_path / f"figure.{ending}", tmp_path / "data.csv"
    command = ("plot", *kind, "-o", output, "--data", data)
    assert atlas(*command).code == 0
    first = output.read_bytes(), data.read_bytes()
    assert first[0].startswith(start)

    assert "exists already; --overwrite replaces it" in refused(*command)
    assert atlas(*command, "--overwrite").code == 0
    assert (output.read_bytes(), data.read_bytes()) == first


CURVE, SQUARE, OPTIMAL = ("square-curve", "--rho"), ("square", "--rho"), ("optimal-configuration",)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((*CURVE, "0.9:2:0.1"), "--rho: '0.9:2:0.1' is not allowed; expected ratios l2/l1 of at"),
        ((*CURVE, "2:1.5:0.1"), "a least ratio below the greatest"),
        ((*CURVE, "1.5:1.5:0.1"), "a least ratio below the greatest"),
        ((*CURVE, "1.5:2:0"), "a number above 0"),
        ((*CURVE, "1.5:2:-1"), "a number above 0"),
        ((*CURVE, "1.5:2:1e-9"), "at most 10000 ratios"),
        ((*CURVE, "1.5:inf:1"), "a finite number"),
        ((*CURVE, "1.5:2"), "three numbers A:B:STEP such as 1.2:4:0.05"),
        ((*CURVE, "1.5"), "three numbers A:B:STEP"),
        ((*CURVE, "a:b:c"), "three numbers A:B:STEP"),
        (("square-curve",), "--rho"),
        ((*CURVE, "1.5:2:0.1", "--lci", 1), "--lci: 1.0"),
        ((*CURVE, "1.5:2:0.1", "--lci", 0), "--lci: 0.0"),
        ((*SQUARE, 1.6, "--lci", -0.5), "--lci: -0.5"),
        ((*SQUARE, 0.9), "--rho: 0.9"),
        ((*SQUARE, "nan"), "--rho: nan"),
        ((*SQUARE, "1.2:4:0.1"), "is not a valid float"),
        (("square",), "either --rho or --lengths"),
        ((*SQUARE, 1.6, "--lengths", 1, 1, 1), "either --rho or --lengths"),
        (("square", "--lengths", 0, 1, 1), "longer than 0"),
        (("square", "--lengths", 1, 1), "--lengths"),
        (("square", "--lengths", 1, 1, 9), "R3 at most R1 + R2"),
        (("square", "--lengths", 1, -1, 0.1), "R2: -1.0"),
        (("square", "--lengths", 1, "nan", 0.1), "R2: nan"),
        ((*SQUARE, 1.6, "--aspect", "2"), "width and height such as 2:1"),
        ((*SQUARE, 1.6, "--aspect", "2:0"), "width and height such as 2:1"),
        ((*SQUARE, 1.6, "--aspect", "2:x"), "width and height such as 2:1"),
        ((*SQUARE, 1.6, "--centre", "middle"), "centre: 'middle' is not allowed; expected one of"),
        ((*SQUARE, 1.6, "--half", "uper"), "did you mean 'upper'?"),
        ((*SQUARE, 1.6, "--mode", "+-"), "mode: '+-'"),
        ((*SQUARE, 1.6, "--actuator-range", 3, 0, 90), "an actuator from 1 to 2"),
        ((*SQUARE, 1.6, "--actuator-range", 1, 90, 0), "a least angle below the greatest"),
        ((*SQUARE, 1.6, "--mechanism", "six-bar"), "five-bar"),
        ((*SQUARE, 1.6, "--width", 9), "millimetres from 60 to 400"),
        ((*OPTIMAL, "--rho", 0.99), "--rho: 0.99"),
        ((*OPTIMAL, "--rho", "inf"), "--rho: inf"),
        ((*OPTIMAL,), "--rho"),
        ((*OPTIMAL, "--rho", 2, "--width", 1000), "millimetres from 60 to 400"),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(map(str, value)),
)
def test_wrong_input_is_refused_and_nothing_is_written(
    refused: Refused, tmp_path: Path, arguments: tuple[object, ...], message: str
) -> None:
    output, data = tmp_path / "figure.png", tmp_path / "data.csv"
    assert message in refused("plot", *arguments, "-o", output, "--data", data)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((*SQUARE, 1.6, "--lci", 0.9), "and 0.9 is asked for"),
        ((*SQUARE, 1.6, "--actuator-range", 1, 0, 60), "deg outside of θ1 from 0 to 60 deg"),
        ((*SQUARE, 1.2, "--mode", "++/up"), "no square"),
        (
            (*CURVE, "1.2:1.4:0.1", "--actuator-range", 1, 0, 60),
            "for no ratio of links: no square",
        ),
        ((*CURVE, "1.2:1.4:0.1", "--lci", 0.999, "--mode", "++/up"), "for no ratio of links"),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(map(str, value)),
)
def test_where_there_is_no_square_nothing_is_written(
    refused: Refused, tmp_path: Path, arguments: tuple[object, ...], message: str
) -> None:
    output, data = tmp_path / "figure.png", tmp_path / "data.csv"
    assert message in refused("plot", *arguments, "-o", output, "--data", data, code=1)
    assert list(tmp_path.iterdir()) == []


def test_outputs_are_checked_before_any_work(refused: Refused, tmp_path: Path) -> None:
    output = tmp_path / "figure.png"
    for wrong in ((*CURVE, "bad"), (*SQUARE, 0.5), (*OPTIMAL, "--rho", 0.5)):
        assert ".png, .pdf, .svg" in refused("plot", *wrong, "-o", tmp_path / "figure.txt")
        assert "another file" in refused("plot", *wrong, "-o", output, "--data", output)
        assert "does not exist" in refused("plot", *wrong, "-o", tmp_path / "absent" / "figure.png")
    assert list(tmp_path.iterdir()) == []


def test_the_help_imports_nothing_heavy() -> None:
    script = (
        "import sys\n"
        "from fivebar_atlas.cli import main\n"
        "main(['plot', 'square-curve', '--help'], standalone_mode=False)\n"
        "heavy = {'numpy', 'numba', 'matplotlib', 'h5py', 'scipy'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for option in (
        "--rho",
        "--lci",
        "--actuator-range",
        "--mode",
        "--half",
        "--centre",
        "--aspect",
    ):
        assert option in done.stdout


def test_options_become_a_task() -> None:
    task = square_task(None, "pm/up", 0.4, ((1, -60.0, 240.0),), "lower", "axis", "3:2")
    assert (task.mode, task.lci_threshold, task.aspect) == ("+-/up", 0.4, 1.5)
    assert (task.half, task.centre, task.mechanism.name) == ("lower", "axis", "five-bar")
    (limit,) = task.ranges
    assert (limit.least, limit.greatest) == pytest.approx((-math.pi / 3, 4 * math.pi / 3))
    assert square_task(None, None, 0.5, (), "upper", "mic", None).mode == "+-/up"


def test_texts_become_numbers() -> None:
    assert parse_ratios("1:2:0.5") == [1.0, 1.5, 2.0]
    assert parse_aspect("16:9") == pytest.approx(16.0 / 9.0)
    five_bar = mechanisms.get("five-bar")
    assert machine_lengths(five_bar, None, (50.0, 80.0, 21.0)) == (1.0, 1.6, 0.42)
    assert machine_lengths(five_bar, 2.0, None)[2] == pytest.approx(math.sqrt(0.5))
    check_ratio(five_bar, 1.0)


def test_a_mechanism_without_an_optimal_configuration_is_named(toy: str) -> None:
    with pytest.raises(InputError, match="mechanism: 'toy'"):
        check_ratio(mechanisms.get(toy), 1.6)
