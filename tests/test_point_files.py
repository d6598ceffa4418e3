"""Points from text: what tables in use look like, and every fault by row and column."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from fivebar_atlas.errors import FileError, FileUsageError
from fivebar_atlas.point_files import read_points

POINTS = np.array([[0.5, 1.25], [-0.75, 1.5e-3], [1.0, -2.0]])


@pytest.mark.parametrize(
    "text",
    [
        "x,y\n0.5,1.25\n-0.75,1.5e-3\n1,-2\n",
        "x,y\n0.5,1.25\n-0.75,1.5e-3\n1,-2",
        "\ufeffx,y\r\n0.5,1.25\r\n-0.75,1.5e-3\r\n1,-2\r\n",
        "\n\nx,y\n\n0.5,1.25\n   \n-0.75,1.5e-3\n,\n1,-2\n\n\n",
        "x;y\n0.5;1.25\n-0.75;1.5e-3\n1;-2\n",
        "x;y\n0,5;1,25\n-0,75;1,5e-3\n1;-2\n",
        "x\ty\n0.5\t1.25\n-0.75\t1.5e-3\n1\t-2\n",
        " X , Y \n 0.5 , 1.25 \n-0.75,+1.5E-3\n1.,-2.0\n",
        "x_mm,y_mm\n0.5,1.25\n-0.75,1.5e-3\n1,-2\n",
        '"x","y"\n"0.5","1.25"\n"-0.75","1.5e-3"\n"1","-2"\n',
        "name,y,lci,x\nfirst,1.25,nan,0.5\n,1.5e-3,,-0.75\nlast,-2,0.3,1\n",
        "x,y\n0.5,1.25,,\n-0.75,1.5e-3,\n1,-2\n",
    ],
)
def test_tables_of_many_makers_give_the_same_points(tmp_path: Path, text: str) -> None:
    path = tmp_path / "points.csv"
    path.write_bytes(text.encode("utf-8"))
    np.testing.assert_array_equal(read_points(path, "mm"), POINTS)


def test_numbers_come_back_bit_for_bit(tmp_path: Path) -> None:
    points = np.random.default_rng(5).normal(size=(1000, 2)) * 10.0 ** np.arange(-5, 5).repeat(
        100
    ).reshape(-1, 1)
    path = tmp_path / "points.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["number", "x", "y"])
        writer.writerows([n, repr(float(x)), repr(float(y))] for n, (x, y) in enumerate(points))
    np.testing.assert_array_equal(read_points(path), points)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "is empty; its first line must name the columns x and y"),
        ("\n , \n", "is empty"),
        ("x,y\n\n", "has no points below its header"),
        ("a,b\n1,2\n", "has no column x or x_mm; its columns are a, b, x and y are needed"),
        ("x,z\n1,2\n", "has no column y or y_mm; its columns are x, z, x and y are needed"),
        ("x,,y_\n1,2,3\n", "has no column y or y_mm; its columns are x, (no name), y_"),
        ("1,2\n3,4\n", "has no column x or x_mm; its columns are 1, 2"),
        ("x_cm,y_cm\n1,2\n", "x and y are needed, and lengths are in mm here"),
        ("x,x_mm,y\n1,2,3\n", "has more than one column x or x_mm: x, x_mm, y"),
        ("x,y,Y\n1,2,3\n", "has more than one column y or y_mm"),
        ("x,y\n1,2\n3,four\n", "row 2 (line 3), column y: 'four' is not a number"),
        ("\nx,y\n\n1,2\n\none,4\n", "row 2 (line 6), column x: 'one' is not a number"),
        ("x_mm,y_mm\n1_0,2\n", "row 1 (line 2), column x_mm: '1_0' is not a number"),
        ("x,y\n1,2\n3\n", "row 2 (line 3), column y: there is no number"),
        ("x,y\n,2\n", "row 1 (line 2), column x: there is no number"),
        ("x,y\n1,nan\n", "row 1 (line 2), column y: 'nan' is not finite"),
        ("x,y\n-inf,2\n", "row 1 (line 2), column x: '-inf' is not finite"),
        ("x,y\n1e999,2\n", "row 1 (line 2), column x: '1e999' is not finite"),
        ("x,y\n1,5,2,5\n", "row 1 (line 2): has 4 values for 2 columns"),
        ("x;y\n1.234,5;2\n", "row 1 (line 2), column x: '1.234,5' is not a number"),
        ('x,y\n"1,2\n', "is not a table in text"),
    ],
)
def test_faults_are_named_by_row_and_column(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "points.csv"
    path.write_text(text)
    with pytest.raises(FileUsageError) as caught:
        read_points(path, "mm")
    assert str(caught.value).startswith(f"{path}: ")
    assert reason in str(caught.value)


def test_points_with_a_unit_are_refused_where_lengths_have_none(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x_mm,y_mm\n1,2\n")
    with pytest.raises(FileUsageError, match=r"has no column x; .* lengths are non-dimensional"):
        read_points(path)


def test_faults_of_files(tmp_path: Path) -> None:
    with pytest.raises(FileUsageError, match="there is no such file"):
        read_points(tmp_path / "points.csv")
    with pytest.raises(FileUsageError, match="is a folder"):
        read_points(tmp_path)
    path = tmp_path / "points.csv"
    path.write_text("x,y\n1,2\n", encoding="utf-16")
    with pytest.raises(FileUsageError, match="is not text in UTF-8"):
        read_points(path)
    with pytest.raises(FileError, match="cannot be read"):
        read_points(tmp_path / ("x" * 300))
