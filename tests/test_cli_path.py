"""``atlas path``: reports against closed forms, faults at known places, exit codes."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import naive
import numpy as np
import pytest
from conftest import Command

RING = (1.28, 1.72, 0)
MACHINE = (26, 30, 16)
D = 24.0


def written(path: Path, points: Sequence[Sequence[float]], header: str = "x,y") -> Path:
    """Write points to a file."""
    path.write_text("\n".join([header, *(f"{x!r},{y!r}" for x, y in points)]) + "\n")
    return path


def circle(radius: float, count: int, centre: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    angles = 2.0 * np.pi * np.arange(count) / count
    return np.array(centre) + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def document(atlas: Command, *arguments: object, code: int = 0) -> dict[str, Any]:
    """Run the command for JSON, in which NaN and infinity must not occur."""
    outcome = atlas("path", *arguments, "--json")
    assert outcome.code == code, outcome
    assert outcome.err == ""

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    parsed: dict[str, Any] = json.loads(outcome.out, parse_constant=refuse)
    return parsed


def test_circle_about_the_origin_against_the_closed_form(atlas: Command, tmp_path: Path) -> None:
    """With r3 = 0 everything depends on the radius, and inputs turn with P."""
    r1, r2, _ = RING
    rho = 1.5
    points = written(tmp_path / "points.csv", circle(rho, 30).tolist())
    found = document(atlas, *RING, points, "--closed")
    psi = math.acos((rho**2 + r2**2 - r1**2) / (2 * rho * r2))
    alpha = math.degrees(math.acos((rho**2 + r1**2 - r2**2) / (2 * rho * r1)))
    assert found["feasible"] is True
    assert found["fault"] is None
    assert found["closed"] is True
    assert found["turns"] == [1, 1]
    assert (found["unit"], found["mode"], found["dimensional_factor"]) == ("", "+-/up", 1.0)
    assert (found["r1"], found["r2"], found["r3"]) == RING
    assert found["path_length"] == pytest.approx(30 * 2 * rho * math.sin(math.pi / 30))
    assert len(found["points"]) == 31
    for number, point in enumerate(found["points"]):
        assert point["point"] == number % 30 + 1
        assert point["lci"] == pytest.approx(min(math.tan(psi), 1.0 / math.tan(psi)))
        assert point["inputs_deg"] == pytest.approx([12 * number + alpha, 12 * number - alpha])
        assert point["distance"] == pytest.approx(rho - (r2 - r1))
        assert point["nearest_locus"] in ("C_1i", "C_2i")
        assert point["path_length"] == pytest.approx(number / 30 * found["path_length"])


def test_dimensional_path_agrees_with_the_oracle(atlas: Command, tmp_path: Path) -> None:
    points = D * np.array([[-0.4, 1.5], [0.2, 1.8], [0.6, 1.2], [0.0, 1.1]])
    file = written(tmp_path / "points.csv", points.tolist(), "x_mm,y_mm")
    found = document(atlas, *MACHINE, file)
    assert (found["unit"], found["dimensional_factor"]) == ("mm", D)
    assert (found["R1"], found["R2"], found["R3"]) == pytest.approx(MACHINE)
    lengths = np.array(MACHINE) / D
    for point, (x, y) in zip(found["points"], points, strict=True):
        assert (point["x"], point["y"]) == (x, y)
        for leg, (base, sign) in enumerate([(-MACHINE[2], 1), (MACHINE[2], -1)]):
            angle = math.radians(point["inputs_deg"][leg])
            bx, by = base + MACHINE[0] * math.cos(angle), MACHINE[0] * math.sin(angle)
            assert math.hypot(x - bx, y - by) == pytest.approx(MACHINE[1])
            assert sign * ((x - base) * by - y * (bx - base)) > 0.0
        assert point["lci"] == pytest.approx(naive.lci(*lengths, x / D, y / D, 1, -1))
        reach = [math.hypot(x + 16, y), math.hypot(x - 16, y)]
        assert 0.0 < point["distance"] <= 56 - max(reach) + 1e-9
    for key, of_points in (("least_lci", "lci"), ("least_distance", "distance")):
        least = found[key]["value"]
        assert 0.0 < least <= min(point[of_points] for point in found["points"])
    assert found["turns"] is None


def test_non_dimensional_path_is_the_same_times_the_factor(atlas: Command, tmp_path: Path) -> None:
    points = circle(0.3, 12, (0.1, 1.4))
    small = document(
        atlas,
        *MACHINE,
        written(tmp_path / "small.csv", points.tolist()),
        "--non-dimensional",
        "--closed",
    )
    large = document(
        atlas, *MACHINE, written(tmp_path / "large.csv", (D * points).tolist()), "--closed"
    )
    assert (small["unit"], large["unit"]) == ("", "mm")
    assert small["turns"] == large["turns"] == [0, 0]
    for one, other in zip(small["points"], large["points"], strict=True):
        assert other["inputs_deg"] == pytest.approx(one["inputs_deg"])
        assert other["lci"] == pytest.approx(one["lci"])
        assert other["distance"] == pytest.approx(D * one["distance"])
        assert other["nearest_locus"] == one["nearest_locus"]


def test_segment_that_leaves_the_workspace_between_feasible_points(
    atlas: Command, tmp_path: Path
) -> None:
    """A chord through the hole of an annulus meets its rim where geometry says."""
    file = written(tmp_path / "points.csv", [(1.5, 1.0), (1.5, 0.3), (-1.5, 0.3), (-1.5, 1)])
    found = document(atlas, *RING, file, code=1)
    assert found["feasible"] is False
    fault = found["fault"]
    hole = 1.72 - 1.28
    x = math.sqrt(hole**2 - 0.3**2)
    assert fault["after_point"] == 2
    assert fault["share_of_segment"] == pytest.approx((1.5 - x) / 3.0)
    assert (fault["x"], fault["y"]) == pytest.approx((x, 0.3))
    assert fault["curve"] in ("C_1i", "C_2i")
    assert fault["kind"] == "serial"
    assert "folded" in fault["reason"]
    assert [point["lci"] is None for point in found["points"]] == [False, False, True, True]
    assert found["points"][2]["inputs_deg"] == [None, None]
    assert found["points"][3]["nearest_locus"] is None
    outcome = atlas("path", *RING, file)
    assert outcome.code == 1
    *_, last = outcome.out.splitlines()
    assert last.startswith(f"not feasible between point 2 and point 3, at ({x:.9g}, 0.3): meets ")
    assert last.endswith("is folded (singularity: serial)")


def test_fault_on_the_way_back_to_the_first_point(atlas: Command, tmp_path: Path) -> None:
    corners = circle(1.5, 4)[:3]  # the closing segment goes through the origin
    file = written(tmp_path / "points.csv", corners.tolist())
    assert document(atlas, *RING, file)["feasible"] is True
    found = document(atlas, *RING, file, "--closed", code=1)
    assert found["fault"]["after_point"] == 3
    assert "between point 3 and point 1, at (-0.44, " in atlas("path", *RING, file, "--closed").out


def test_path_that_cannot_begin(atlas: Command, tmp_path: Path) -> None:
    file = written(tmp_path / "points.csv", [(0.0, 100.0), (0.0, 30.0)])
    found = document(atlas, *MACHINE, file, code=1)
    assert found["fault"]["curve"] is None
    assert found["least_lci"] is None
    outcome = atlas("path", *MACHINE, file)
    assert "not feasible at point 1, at (0, 100) mm: P is out of reach of leg" in outcome.out
    assert "nan" not in outcome.out


def test_path_changes_with_the_mode(atlas: Command, tmp_path: Path) -> None:
    file = written(tmp_path / "points.csv", [(0.0, 40.0), (10.0, 38.0)])
    image = written(tmp_path / "image.csv", [(0.0, -40.0), (10.0, -38.0)])
    one = document(atlas, *MACHINE, file)
    other = document(atlas, *MACHINE, image, "--mode", "mp/down")
    assert other["mode"] == "-+/down"
    for point, mirrored in zip(one["points"], other["points"], strict=True):
        assert mirrored["inputs_deg"] == pytest.approx([-angle for angle in point["inputs_deg"]])
        assert mirrored["distance"] == pytest.approx(point["distance"])
    assert document(atlas, *MACHINE, file, "--mode", "-+/up", code=1)["fault"] is not None


def test_table_says_the_same(atlas: Command, tmp_path: Path) -> None:
    file = written(tmp_path / "points.csv", circle(0.3 * D, 40, (0.0, 1.4 * D)).tolist())
    found = document(atlas, *MACHINE, file)
    outcome = atlas("path", *MACHINE, file)
    assert outcome.code == 0
    assert outcome.err == ""
    lines = outcome.out.splitlines()
    assert max(len(line) for line in lines) <= 80
    first = next(place for place, line in enumerate(lines) if line.startswith("point")) + 2
    for line, point in zip(lines[first : first + 40], found["points"], strict=True):
        number, *values, nearest = line.split()
        assert (int(number), nearest) == (point["point"], point["nearest_locus"])
        expected = [point["x"], point["y"], *point["inputs_deg"], point["lci"], point["distance"]]
        assert [float(value) for value in values] == pytest.approx(expected, abs=6e-3, rel=1e-4)
    least = found["least_lci"]
    assert f"LCI        least {least['value']:.4f} (" in outcome.out
    assert lines[-1] == "feasible"


def test_long_table_is_printed_where_it_is_asked_for(atlas: Command, tmp_path: Path) -> None:
    file = written(tmp_path / "points.csv", circle(1.5, 41).tolist())
    short, long = atlas("path", *RING, file), atlas("path", *RING, file, "--all-points")
    assert len(long.out.splitlines()) == len(short.out.splitlines()) + 44
    assert short.out.splitlines()[-1] == long.out.splitlines()[-1] == "feasible"
    closed = atlas("path", *RING, file, "--closed").out
    assert "41 points, closed" in closed
    assert closed.count("+1 full turn\n") == 2


def test_report_has_all_digits_and_is_itself_a_table_of_points(
    atlas: Command, tmp_path: Path
) -> None:
    points = (D * circle(0.31, 7, (0.1, 1.37))).tolist()
    file, report = written(tmp_path / "points.csv", points), tmp_path / "report.csv"
    assert atlas("path", *MACHINE, file, "-o", report).code == 0
    found = document(atlas, *MACHINE, file)
    with report.open(newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert list(rows[0]) == [
        *("point", "x_mm", "y_mm", "path_length_mm", "theta1_deg", "theta2_deg"),
        *("lci", "distance_mm", "nearest_locus"),
    ]
    for row, point in zip(rows, found["points"], strict=True):
        *values, nearest = row.values()
        expected = [point["point"], point["x"], point["y"], point["path_length"]]
        expected += [*point["inputs_deg"], point["lci"], point["distance"]]
        assert [float(value) for value in values] == expected
        assert nearest == point["nearest_locus"]
    assert document(atlas, *MACHINE, report) == found


def test_report_of_a_path_that_is_not_feasible(atlas: Command, tmp_path: Path) -> None:
    file = written(tmp_path / "points.csv", [(1.5, 0.3), (-1.5, 0.3)])
    report = tmp_path / "report.csv"
    assert atlas("path", *RING, file, "-o", report).code == 1
    assert report.read_text().splitlines()[2] == "2,-1.5,0.3,3.0,nan,nan,nan,nan,"


def test_one_point_is_a_path(atlas: Command, tmp_path: Path) -> None:
    file = written(tmp_path / "points.csv", [(0.0, 1.5)])
    for closing in ((), ("--closed",)):
        found = document(atlas, *RING, file, *closing)
        assert found["feasible"] is True
        assert found["path_length"] == 0.0
        (point,) = found["points"]
        assert point["point"] == 1
        assert "1 point" in atlas("path", *RING, file, *closing).out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((26, 30, 16), "Missing argument 'POINTS.csv'"),
        ((), "Missing argument 'POINTS.csv'"),
        ((26, 30, "points.csv"), "expected 3 numbers: r1 r2 r3"),
        ((26, 30, 16, 5, "points.csv"), "expected 3 numbers"),
        ((26, 30, "x", "points.csv"), "'x' is not a number"),
        ((-26, 30, 16, "points.csv"), "R1: -26.0 is not allowed"),
        ((26, 30, 16, "points.csv", "--closd"), "No such option '--closd'"),
        ((26, 30, 16, "--closd", "points.csv"), "No such option '--closd'"),
        ((26, 30, 16, "points.csv", "--mode", "+-"), "'+-' is not allowed; expected one of"),
        ((26, 30, 16, "other.csv"), "other.csv: there is no such file"),
        ((26, 30, 16, "points.csv", "--unit", "cm"), "has no column x or x_cm"),
        ((1.28, 1.72, 0, "points.csv"), "lengths are non-dimensional here"),
        ((26, 30, 16, "points.csv", "-o", "points.csv"), "is the input"),
        ((26, 30, 16, "points.csv", "-o", "no/report.csv"), "the folder no does not exist"),
        ((26, 30, 16, "bad.csv", "-o", "report.csv"), "row 1 (line 2), column y: 'b' is not"),
    ],
)
def test_wrong_inputs_are_named(
    refused: Callable[..., str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[object, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "points.csv", [(0.0, 40.0)], "x_mm,y_mm")
    (tmp_path / "bad.csv").write_text("x,y\n1,b\n")
    assert message in refused("path", *arguments)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.csv", "points.csv"]


def test_the_points_are_not_overwritten_by_what_is_said_of_them(
    refused: Callable[..., str], tmp_path: Path
) -> None:
    points = tmp_path / "points.csv"
    points.write_text("x,y\n0,40\n5,41\n")
    line = refused("path", 26, 30, 16, points, "-o", points, "--overwrite")
    assert line == f"{points}: is the input; the output needs another name"
    film = tmp_path / "film.gif"
    for data in (points, tmp_path / "." / "points.csv"):
        line = refused(
            "animate", 26, 30, 16, "--points", points, "--data", data, "-o", film, "--overwrite"
        )
        assert line.endswith("is the input; the output needs another name")
    assert points.read_text() == "x,y\n0,40\n5,41\n"
    assert not film.exists()


def test_least_values_are_those_between_points_too(atlas: Command, tmp_path: Path) -> None:
    # the chord passes just above C_col, far from both of its ends
    file = written(tmp_path / "points.csv", [(-28.0, 22.5), (28.0, 22.5)])
    outcome = atlas("path", *MACHINE, file, "--json")
    assert outcome.code == 0
    found = json.loads(outcome.out)
    x = np.linspace(-28.0, 28.0, 20001)
    dense = naive.lci(*(length / D for length in MACHINE), x / D, np.full_like(x, 22.5 / D), 1, -1)
    assert found["least_lci"]["value"] == pytest.approx(dense.min(), rel=1e-6)
    assert found["least_lci"]["x"] == pytest.approx(0.0, abs=1e-3)
    # at the top of C_col B1P B2 is level, its middle at √(R1² - (R3 - R2)²)
    top = math.sqrt(26.0**2 - (16.0 - 30.0) ** 2)
    assert found["least_distance"]["value"] == pytest.approx(22.5 - top, rel=1e-9)
    assert found["least_distance"]["share_of_segment"] == pytest.approx(0.5, abs=1e-4)


def test_a_path_with_a_fault_has_no_least_values(atlas: Command, tmp_path: Path) -> None:
    file = written(tmp_path / "points.csv", [(0.0, 40.0), (0.0, 20.0)])
    outcome = atlas("path", *MACHINE, file, "--json")
    assert outcome.code == 1
    found = json.loads(outcome.out)
    assert found["least_lci"] is None
    assert found["least_distance"] is None
    assert "least" not in atlas("path", *MACHINE, file).out
