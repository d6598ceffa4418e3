"""Geometry as CSV, SVG and DXF: files are read back and their arcs, lengths and areas compared."""

from __future__ import annotations

import csv
import dataclasses
import itertools
import json
import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf.document import Drawing
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import ellipe

from fivebar_atlas import FiveBar, mechanisms
from fivebar_atlas.errors import FileError, FileUsageError, InputError, UnknownNameError
from fivebar_atlas.geometry_files import json_document as json_module
from fivebar_atlas.geometry_files.csv_points import csv_text
from fivebar_atlas.geometry_files.design_geometry import (
    DesignGeometry,
    geometry_of,
    sides_text,
)
from fivebar_atlas.geometry_files.json_document import json_document
from fivebar_atlas.geometry_files.svg_drawing import cubics, svg_text
from fivebar_atlas.geometry_files.writing import write_geometry
from fivebar_atlas.planar_geometry import (
    Arc,
    CircleArc,
    PolylineArc,
)

Array = NDArray[np.float64]
FIVE_BAR = mechanisms.get("five-bar")
DEVIATION = 1e-4
SVG = "{http://www.w3.org/2000/svg}"
#: Lengths of machines in all sub-regions, change points and degenerate ones among them.
DESIGNS = [
    (1.2, 1.0, 0.8),
    (1.3, 1.6, 0.1),
    (1.28, 1.72, 0),
    (1.08, 1.25, 0.67),
    (26, 30, 16),
    (1, 1, 1),
    (1.5, 1.5, 0),
    (0.5, 1.6, 0.9),
    (1.9, 0.6, 0.5),
    (1.0, 0.7, 1.3),
]


def geometry(
    lengths: tuple[float, float, float],
    kind: str,
    mode: str | None = None,
    lci: float = 0.5,
    unit: str | None = None,
) -> DesignGeometry:
    return geometry_of(FIVE_BAR.planar_design(lengths, unit), kind, mode, lci)


def random_cases(count: int) -> Iterator[tuple[tuple[float, float, float], str]]:
    """Yield lengths of assemblable machines in millimetres, and mode pairs."""
    rng = np.random.default_rng(20061)
    while count:
        r1, r2, r3 = (float(r) for r in rng.dirichlet([1.0, 1.0, 1.0]))
        if r3 < r1 + r2:
            count -= 1
            yield (90.0 * r1, 90.0 * r2, 90.0 * r3), str(rng.choice(FIVE_BAR.modes))


# Lengths of arcs


def test_length_of_an_ellipse_and_across_a_corner() -> None:
    """Of an arc only points and ends are asked for."""

    def quarter(shares: Array) -> Array:
        angles = 0.5 * np.pi * shares
        return np.column_stack([2.0 * np.cos(angles), np.sin(angles)])

    def corner(shares: Array) -> Array:
        """From (0, 0) to (1, 0) to (1, 1); the corner at a share that no halving meets."""
        return np.column_stack([np.minimum(3.0 * shares, 1.0), np.maximum(0.0, 1.5 * shares - 0.5)])

    ellipse: Any = SimpleNamespace(points=quarter, start=(2.0, 0.0), end=(0.0, 1.0))
    assert Arc.length(ellipse) == pytest.approx(2.0 * ellipe(0.75), rel=1e-12)
    bent: Any = SimpleNamespace(points=corner, start=(0.0, 0.0), end=(1.0, 1.0))
    assert Arc.length(bent) == pytest.approx(2.0, rel=1e-11)


def test_length_of_circle_arcs_by_halving_and_in_closed_form() -> None:
    arc = CircleArc.of_angles((0.3, -2.0), 1.7, 0.4, -2.9)
    assert arc.length() == pytest.approx(1.7 * 2.9, rel=1e-15)
    assert Arc.length(arc) == pytest.approx(1.7 * 2.9, rel=1e-12)
    assert Arc.length(CircleArc.whole((0.0, 0.0), 0.2)) == pytest.approx(0.4 * np.pi, rel=1e-12)
    assert Arc.length(arc.scaled(24.0)) == pytest.approx(24.0 * 1.7 * 2.9, rel=1e-12)


def test_length_of_polylines() -> None:
    corners = np.random.default_rng(1).normal(size=(50, 2))
    assert PolylineArc(corners).length() == pytest.approx(shapely.LineString(corners).length)


@pytest.mark.parametrize("lengths", [(1.2, 1.0, 0.8), (1.08, 1.25, 0.67), (1.0, 1.3, 0.7)])
def test_length_of_coupler_curves(lengths: tuple[float, float, float]) -> None:
    """C_col in polar form from |w| = sqrt(r1² - ρ²), w ⟂ P, |w + (r3, 0)| = r2."""
    r1, r2, r3 = lengths

    def speed(phi: float, branch: int) -> float:
        s, c = math.sin(phi), math.cos(phi)
        root = math.sqrt(r2**2 - r3**2 * c**2)
        w = r3 * s + branch * root
        slope = r3 * c + branch * r3**2 * s * c / root
        return math.hypot(math.sqrt(r1**2 - w**2), w * slope / math.sqrt(r1**2 - w**2))

    compared = 0
    for named in FiveBar.from_lengths(*lengths).singular_loci("+-"):
        if named.name != "C_col":
            continue
        line = named.arc.polyline(1e-6)
        angles = np.unwrap(np.arctan2(line[:, 1], line[:, 0]))
        x, y = line[len(line) // 2]
        s, c = math.sin(angles[len(line) // 2]), math.cos(angles[len(line) // 2])
        branch = min(
            (1, -1),
            key=lambda sign: abs(
                r1**2 - (r3 * s + sign * math.sqrt(r2**2 - r3**2 * c**2)) ** 2 - x * x - y * y
            ),
        )
        expected, error = quad(
            speed, angles[0], angles[-1], (branch,), epsabs=0, epsrel=1e-11, limit=400
        )
        assert error < 1e-9
        assert named.arc.length() == pytest.approx(abs(expected), rel=1e-9)
        compared += 1
    assert compared


# What is written


@pytest.mark.parametrize("lengths", DESIGNS)
def test_base_joints_are_half_the_base_from_the_middle(lengths: tuple[float, ...]) -> None:
    for kind in ("loci", "workspace", "circles"):
        found = geometry(lengths, kind)
        joints = (
            [] if found.is_empty else [(-lengths[2], 0.0), (lengths[2], 0.0)][lengths[2] == 0 :]
        )
        assert [tuple(point) for point in found.base_joints] == [
            pytest.approx(joint, rel=1e-14) for joint in joints
        ]


def test_boundaries_are_in_order_and_say_whose_they_are() -> None:
    found = geometry((26, 30, 16), "workspace", "pm/up")
    placed = found.placed_arcs()
    assert found.mode == "+-/up"
    assert [each.number for each in placed] == list(range(1, 8))
    assert [(each.region, each.boundary) for each in placed] == [
        *[(1, "outline")] * 3,
        *[(1, "hole 1")] * 4,
    ]
    for each in placed:
        assert each.named.sides == {"+-/up": "left"}
    for name in ("outline", "hole 1"):
        arcs = [each.named.arc for each in placed if each.boundary == name]
        for one, two in itertools.pairwise([*arcs, arcs[0]]):
            assert one.end == two.start


def test_loci_of_a_working_mode_are_named_canonically() -> None:
    found = geometry((1.2, 1.0, 0.8), "loci", "pm")
    assert found.mode == "+-"
    assert {pair.partition("/")[0] for arc in found.arcs for pair in arc.sides} == {"+-"}
    assert geometry((1.2, 1.0, 0.8), "loci").mode is None


def test_good_condition_areas_are_integrated_and_outlined() -> None:
    for lengths in ((1.28, 1.72, 0), (1.2, 1.0, 0.8), (1.3, 1.6, 0.1), (26, 30, 16)):
        for threshold in (0.3, 0.5, 0.9):
            found = geometry(lengths, "good-condition", lci=threshold, unit="")
            robot = FiveBar.from_lengths(*lengths)
            (exact,) = robot.evaluate("+-/up", [threshold], 1e-8)["good_condition"]
            assert found.area == pytest.approx(exact["area"], rel=1e-5)
            area = sum(region.area for region in found.regions)
            assert area == pytest.approx(exact["area"], rel=2e-3, abs=1e-5)


def test_sides_never_begin_like_a_formula() -> None:
    sides = {"+-/up": "left", "--/up": "left", "+-/down": "right", "-+/up": "both"}
    assert sides_text(sides) == "left: +-/up --/up; right: +-/down; both: -+/up"
    assert sides_text({}) == ""


def test_what_is_not_there_is_explained() -> None:
    for kind in ("workspace", "good-condition", "circles"):
        found = geometry((1.28, 1.72, 0), kind, "++/up")
        assert found.is_empty
        assert found.absence == "the usable workspace of ++/up is empty"
    low = geometry((1.0, 0.7, 1.3), "good-condition", "++/down", 0.9)
    largest = FiveBar.from_lengths(1.0, 0.7, 1.3).evaluate("++/down", [])["max_lci"]
    assert low.is_empty
    assert low.absence.startswith("LCI reaches 0.9 nowhere in the usable workspace of ++/down; ")
    assert float(low.absence.rpartition(" ")[2]) == pytest.approx(largest, rel=0.01)
    corner = geometry((1.0, 0.7, 1.3), "good-condition", lci=0.83)
    assert corner.is_empty
    assert corner.absence.endswith("only in parts too small to be outlined")
    assert "no arcs of singular loci of ++" in geometry((1.28, 1.72, 0), "loci", "++").absence


@pytest.mark.parametrize(
    ("kind", "mode", "known"),
    [
        ("locus", None, "loci, workspace, good-condition, circles"),
        ("loci", "+*", "+-, -+, ++, --, +-/up"),
        ("loci", "+-/upp", "+-/up"),
        ("workspace", "+-", "+-/up"),
    ],
)
def test_unknown_names_are_refused(kind: str, mode: str | None, known: str) -> None:
    with pytest.raises(UnknownNameError, match=re.escape(known)):
        geometry((1.2, 1.0, 0.8), kind, mode)


def test_thresholds_are_checked() -> None:
    with pytest.raises(InputError, match="above 0 and below 1"):
        geometry((1.2, 1.0, 0.8), "good-condition", lci=1.0)


# CSV


def read_csv(text: str) -> tuple[list[str], list[dict[str, str]]]:
    header, *rows = csv.reader(text.splitlines())
    assert all(len(row) == len(header) for row in rows)
    return header, [dict(zip(header, row, strict=True)) for row in rows]


def lines_of(rows: list[dict[str, str]], suffix: str = "") -> dict[int, Array]:
    """Return the points of every arc."""
    return {
        int(number): np.array([[float(r[f"x{suffix}"]), float(r[f"y{suffix}"])] for r in part])
        for number, part in itertools.groupby(rows, key=lambda row: row["arc"])
    }


@pytest.mark.parametrize("deviation", [1e-2, 1e-4, 1e-6])
def test_csv_points_lie_on_the_arcs_and_their_chords_near(deviation: float) -> None:
    found = geometry((26, 30, 16), "loci")
    header, rows = read_csv(csv_text(found, 24.0 * deviation))
    assert header == [
        *("arc", "curve", "kind", "region", "boundary", "start", "end", "modes"),
        *("centre_x_mm", "centre_y_mm", "radius_mm", "x_mm", "y_mm"),
    ]
    lines = lines_of(rows, "_mm")
    assert list(lines) == [each.number for each in found.placed_arcs()]
    circles = 0
    for number, part in itertools.groupby(rows, key=lambda row: row["arc"]):
        first = next(part)
        named = found.arcs[int(number) - 1]
        line = lines[int(number)]
        assert (first["curve"], first["kind"]) == (named.name, named.kind)
        assert (first["start"], first["end"]) == named.ends
        assert first["modes"] == sides_text(named.sides)
        assert (tuple(line[0]), tuple(line[-1])) == (named.arc.start, named.arc.end)
        if first["radius_mm"] == "nan":
            between = 0.5 * (line[:-1] + line[1:])
            assert named.arc.nearest(line)[0].max() < 1e-8
            assert named.arc.nearest(between)[0].max() <= 24.0 * deviation * 1.0001
            continue
        circles += 1
        centre = np.array([float(first["centre_x_mm"]), float(first["centre_y_mm"])])
        radius = float(first["radius_mm"])
        np.testing.assert_allclose(np.hypot(*(line - centre).T), radius, rtol=1e-13)
        half = 0.5 * np.hypot(*np.diff(line, axis=0).T)
        sagitta = radius - np.sqrt(radius**2 - half**2)
        assert sagitta.max() <= 24.0 * deviation
    assert circles == 22


def test_csv_boundaries_enclose_the_workspace() -> None:
    for lengths, mode in random_cases(40):
        found = geometry(lengths, "workspace", mode)
        if found.is_empty:
            continue
        _, rows = read_csv(csv_text(found, 3e-4))
        boundaries = {
            name: np.array([[float(row["x_mm"]), float(row["y_mm"])] for row in part])
            for name, part in itertools.groupby(rows, key=lambda row: row["boundary"])
        }
        assert next(iter(boundaries)) == "outline"
        polygon = shapely.Polygon(boundaries.pop("outline"), boundaries.values())
        assert found.area is not None
        assert polygon.area == pytest.approx(found.area, abs=3e-4 * polygon.length)


def test_csv_of_a_good_condition_workspace_has_the_radii_of_the_level() -> None:
    """At r3 = 0 the level 0.5 is two circles, tan ψ = 1/2 and 2 (Fig. 13)."""
    r1, r2 = 1.28, 1.72
    middle, half = 2.0 * r2 / math.sqrt(5.0), math.sqrt(r1**2 - r2**2 / 5.0)
    header, rows = read_csv(csv_text(geometry((r1, r2, 0), "good-condition"), DEVIATION))
    assert header[-2:] == ["x", "y"]
    for boundary, radius in (("outline", middle + half), ("hole 1", middle - half)):
        line = np.array([[float(r["x"]), float(r["y"])] for r in rows if r["boundary"] == boundary])
        assert len(line) > 100
        np.testing.assert_allclose(np.hypot(*line.T), radius, rtol=1e-12)
    # as printed
    assert (middle - half, middle + half) == pytest.approx((0.5154, 2.5614), abs=1.1e-4)
    assert {row["curve"] for row in rows} == {"LCI = 0.5"}


def test_csv_of_a_machine_is_that_of_the_design_times_its_factor() -> None:
    tables = [
        read_csv(csv_text(geometry((26, 30, 16), "loci", unit=unit), factor * DEVIATION))
        for unit, factor in (("mm", 24.0), ("", 1.0))
    ]
    assert [header[-1] for header, _ in tables] == ["y_mm", "y"]
    machine, design = lines_of(tables[0][1], "_mm"), lines_of(tables[1][1])
    assert machine.keys() == design.keys()
    for number, line in design.items():
        np.testing.assert_allclose(machine[number], 24.0 * line, rtol=1e-12, atol=1e-12)


def test_csv_has_isolated_points_and_no_formulas() -> None:
    _, rows = read_csv(csv_text(geometry((1.1, 1.1, 0.8), "loci"), DEVIATION))
    points = [row for row in rows if row["curve"] == "isolated point"]
    assert [(float(row["x"]), float(row["y"])) for row in points] == [(-0.8, 0.0), (0.8, 0.0)]
    for row in rows:
        for cell in row.values():
            assert cell[:1] not in "+=@" or cell == ""
            assert not cell.startswith("-") or math.isfinite(float(cell))
        assert "-0.0" not in row.values()


# SVG


@dataclasses.dataclass(frozen=True)
class Step:
    """One command of a path: where it starts and ends, and what lies between."""

    kind: str
    start: complex
    end: complex
    middle: tuple[float, ...] = ()

    @property
    def area(self) -> float:
        """½ ∫ (x dy - y dx), by the formulas of circle segments and of Bézier cubics."""

        def cross(p: complex, q: complex) -> float:
            return (p.conjugate() * q).imag

        chord = 0.5 * cross(self.start, self.end)
        if self.kind == "A":
            radius, turn = self.middle[0], 1.0 if self.middle[4] else -1.0
            assert (self.middle[1], self.middle[2], self.middle[3]) == (radius, 0.0, 0.0)
            sweep = 2.0 * math.asin(0.5 * abs(self.end - self.start) / radius)
            return chord + turn * 0.5 * radius**2 * (sweep - math.sin(sweep))
        if self.kind == "C":
            p, r = self.start, self.end
            a, b = complex(*self.middle[:2]), complex(*self.middle[2:])
            return 0.05 * (
                6.0 * cross(p, a)
                + 3.0 * cross(p, b)
                + cross(p, r)
                + 3.0 * cross(a, b)
                + 3.0 * cross(a, r)
                + 6.0 * cross(b, r)
            )
        return chord

    def points(self, shares: Array) -> Array:
        """Points of a cubic."""
        p, r = self.start, self.end
        a, b = complex(*self.middle[:2]), complex(*self.middle[2:])
        s, t = 1.0 - shares, shares
        z = s**3 * p + 3.0 * s**2 * t * a + 3.0 * s * t**2 * b + t**3 * r
        return np.column_stack([z.real, z.imag])


def steps_of(path: str) -> list[list[Step]]:
    """Parse path data with absolute M, L, A, C and Z into closed or open runs."""
    runs: list[list[Step]] = []
    numbers = {"M": 2, "L": 2, "A": 7, "C": 6, "Z": 0}
    place = first = 0j
    tokens = path.split()
    while tokens:
        kind = tokens.pop(0)
        values = [float(tokens.pop(0)) for _ in range(numbers[kind])]
        end = complex(*values[-2:]) if values else first
        if kind == "M":
            runs.append([])
            first = end
        elif end != place or kind != "Z":
            runs[-1].append(Step(kind, place, end, tuple(values[:-2])))
        place = end
    return runs


def drawn(found: DesignGeometry, deviation: float = DEVIATION) -> ElementTree.Element:
    return ElementTree.fromstring(svg_text(found, deviation))


def test_svg_regions_have_the_area_of_the_workspace() -> None:
    """Circle arcs to rounding, C_col within the deviation; holes turn the other way."""
    exact = 0
    for lengths, mode in [*((each, "+-/up") for each in DESIGNS), *random_cases(30)]:
        found = geometry(lengths, "workspace", mode, unit="mm")
        if found.is_empty:
            continue
        (path,) = drawn(found, 1e-5).findall(f".//{SVG}path[@id='region_1']")
        runs = steps_of(path.attrib["d"])
        for run in runs:
            assert run[-1].end == run[0].start
        (region,) = found.regions
        assert len(runs) == len(region.loops)
        has_spline = any(step.kind == "C" for run in runs for step in run)
        exact += not has_spline
        around = sum(arc.arc.length() for arc in region.arcs)
        for run, loop in zip(runs, region.loops, strict=True):
            area = math.fsum(step.area for step in run)
            slack = 1e-5 * around if has_spline else 1e-9 * region.area
            assert area == pytest.approx(loop.area, abs=slack)
    assert exact >= 3


@pytest.mark.parametrize("deviation", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("lengths", [(1.2, 1.0, 0.8), (0.9, 0.8, 1.3), (1, 1, 1), (1.0, 1.3, 0.7)])
def test_splines_follow_the_coupler_curve(
    lengths: tuple[float, float, float], deviation: float
) -> None:
    compared = 0
    shares = np.linspace(0.0, 1.0, 31)
    for named in geometry(lengths, "loci").arcs:
        if named.name != "C_col":
            continue
        found = cubics(named.arc, deviation)
        assert (tuple(found[0][0]), tuple(found[-1][3])) == (named.arc.start, named.arc.end)
        for one, two in itertools.pairwise(found):
            assert tuple(one[3]) == tuple(two[0])
        steps = [
            Step("C", complex(*p), complex(*r), (*a.tolist(), *b.tolist())) for p, a, b, r in found
        ]
        points = np.concatenate([step.points(shares) for step in steps])
        assert named.arc.nearest(points)[0].max() <= 1.05 * deviation
        length = np.hypot(*np.diff(points, axis=0).T).sum()
        assert length == pytest.approx(named.arc.length(), rel=0.02 + deviation)
        compared += 1
    assert compared


def test_svg_groups_name_curves_and_kinds() -> None:
    found = geometry((26, 30, 16), "loci")
    root = drawn(found, 1e-3)
    groups = {group.attrib["id"]: group for group in root.iter(f"{SVG}g")}
    names = ["C_1o", "C_1i", "C_2o", "C_2i", "C_coin_up", "C_coin_down", "C_col"]
    assert [name for name in groups if name.startswith("C_")] == names
    assert [groups[name].attrib["class"] for name in names] == [
        *["serial"] * 4,
        *["parallel folded"] * 2,
        "parallel extended",
    ]
    paths = [path for name in names for path in groups[name].findall(f"{SVG}path")]
    assert [path.attrib["data-modes"] for path in paths] == [
        sides_text(named.sides) for named in found.arcs
    ]
    for path, named in zip(paths, found.arcs, strict=True):
        (run,) = steps_of(path.attrib["d"])
        ends = (run[0].start, run[-1].end)
        assert ends == (complex(*named.arc.start), complex(*named.arc.end))
        assert (path.attrib["data-start"], path.attrib["data-end"]) == named.ends
    identifiers = [element.attrib["id"] for element in root.iter() if "id" in element.attrib]
    assert len(set(identifiers)) == len(identifiers)
    circles = groups["base_joints"].findall(f"{SVG}circle")
    assert [(float(c.attrib["cx"]), float(c.attrib["cy"])) for c in circles] == [(-16, 0), (16, 0)]


@pytest.mark.parametrize(
    ("unit", "millimetres"),
    [("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", 25.4), ("furlong", 50.0 / 24.0), ("", 50.0)],
)
def test_svg_has_the_size_of_the_machine(unit: str, millimetres: float) -> None:
    found = geometry((26, 30, 16), "workspace", unit=unit)
    root = drawn(found)
    left, top, width, height = (float(part) for part in root.attrib["viewBox"].split())
    for side, extent in (("width", width), ("height", height)):
        assert root.attrib[side].endswith("mm")
        assert float(root.attrib[side][:-2]) == pytest.approx(millimetres * extent, rel=1e-8)
    # upside down, with everything inside and little room around
    low, high = found.extent()
    assert left < low[0] < high[0] < left + width
    assert top < -high[1] < -low[1] < top + height
    assert max(width, height) < 1.1 * max(high - low)
    group = root.find(f"{SVG}g")
    assert group is not None
    assert group.attrib["transform"] == "scale(1,-1)"
    description = root.findtext(f"{SVG}desc") or ""
    assert ("50 mm on paper" in description) == (unit in ("", "furlong"))
    assert "sub-region Va" in description


def test_svg_circles_and_strange_units() -> None:
    found = geometry((26, 30, 16), "circles", unit='<"&>')
    root = drawn(found)
    assert '<"&>' in (root.findtext(f"{SVG}title") or "")
    for name, named in zip(("MIC_upper", "MIC_lower"), found.arcs, strict=True):
        (path,) = root.findall(f".//{SVG}g[@id='{name}']/{SVG}path")
        (run,) = steps_of(path.attrib["d"])
        assert isinstance(named.arc, CircleArc)
        assert math.fsum(step.area for step in run) == pytest.approx(
            math.pi * named.arc.radius**2, rel=1e-12
        )
        assert path.attrib["d"].endswith("Z")


def test_svg_of_level_curves_keeps_their_corners() -> None:
    found = geometry((1.2, 1.0, 0.8), "good-condition")
    root = drawn(found)
    assert len(found.regions) == 3
    for number, region in enumerate(found.regions, 1):
        (path,) = root.findall(f".//{SVG}path[@id='region_{number}']")
        (run,) = steps_of(path.attrib["d"])
        arc = region.arcs[0].arc
        assert isinstance(arc, PolylineArc)
        assert [(step.end.real, step.end.imag) for step in run] == [
            tuple(corner) for corner in arc.corners[1:].tolist()
        ]


# DXF


def read_dxf(found: DesignGeometry, tmp_path: Path, deviation: float = DEVIATION) -> Drawing:
    """Write a drawing, read it back, and let ezdxf look for faults."""
    path = tmp_path / "drawing.dxf"
    write_geometry(found, path, overwrite=True, deviation=deviation)
    document = ezdxf.readfile(path)
    audit = document.audit()
    assert not audit.has_errors
    assert not audit.has_fixes
    return document


def tags_of(entity: Any) -> dict[str, str]:
    return dict(tag.value.split("=", 1) for tag in entity.get_xdata("FIVEBAR_ATLAS"))


def ends_and_area(entity: Any) -> tuple[complex, complex, float]:
    """Return start, end and ½ ∫ (x dy - y dx) of an ARC, a CIRCLE or an LWPOLYLINE."""
    if entity.dxftype() == "CIRCLE":
        start = complex(entity.dxf.center.x + entity.dxf.radius, entity.dxf.center.y)
        return start, start, math.pi * entity.dxf.radius**2
    if entity.dxftype() == "ARC":
        centre, radius = complex(entity.dxf.center.x, entity.dxf.center.y), entity.dxf.radius
        first = math.radians(entity.dxf.start_angle)
        sweep = math.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360.0)
        start, end = (
            centre + radius * complex(math.cos(angle), math.sin(angle))
            for angle in (first, first + sweep)
        )
        chord = (centre.conjugate() * (end - start)).imag
        return start, end, 0.5 * (radius**2 * sweep + chord)
    points = [complex(x, y) for x, y in entity.get_points("xy")]
    if entity.closed:
        points.append(points[0])
    area = 0.5 * math.fsum((p.conjugate() * q).imag for p, q in itertools.pairwise(points))
    return points[0], points[-1], area


def test_dxf_entities_are_the_arcs(tmp_path: Path) -> None:
    found = geometry((26, 30, 16), "loci")
    document = read_dxf(found, tmp_path)
    entities = [e for e in document.modelspace() if e.dxftype() != "POINT"]
    kinds = {"C_col": "LWPOLYLINE"}
    assert [(e.dxf.layer, e.dxftype()) for e in entities] == [
        (named.name, kinds.get(named.name, "ARC")) for named in found.arcs
    ]
    for entity, named in zip(entities, found.arcs, strict=True):
        start, end, area = ends_and_area(entity)
        tags = tags_of(entity)
        assert (tags["curve"], tags["kind"]) == (named.name, named.kind)
        assert (tags["start"], tags["end"]) == named.ends
        assert tags["modes"] == sides_text(named.sides)
        assert start == pytest.approx(complex(*named.arc.start), abs=1e-12 * 56.0)
        assert end == pytest.approx(complex(*named.arc.end), abs=1e-12 * 56.0)
        slack = 1e-11 if entity.dxftype() == "ARC" else 24.0 * DEVIATION
        assert area == pytest.approx(
            named.arc.swept_area(), abs=slack * max(1.0, named.arc.length())
        )
    points = [e for e in document.modelspace() if e.dxftype() == "POINT"]
    assert [(e.dxf.layer, e.dxf.location.x, e.dxf.location.y) for e in points] == [
        ("BASE_JOINTS", -16.0, 0.0),
        ("BASE_JOINTS", 16.0, 0.0),
    ]


def test_dxf_layers_say_what_kind_of_curve_they_hold(tmp_path: Path) -> None:
    document = read_dxf(geometry((26, 30, 16), "loci"), tmp_path)
    layers = {layer.dxf.name: layer for layer in document.layers}
    looks = {}
    for name, kind in (
        ("C_1o", "serial"),
        ("C_2i", "serial"),
        ("C_coin_up", "parallel, folded"),
        ("C_coin_down", "parallel, folded"),
        ("C_col", "parallel, extended"),
    ):
        layer = layers[name]
        assert layer.description == kind
        assert layer.dxf.linetype in document.linetypes
        looks.setdefault(kind, set()).add((layer.dxf.color, layer.dxf.linetype))
    assert all(len(look) == 1 for look in looks.values())
    assert len({next(iter(look)) for look in looks.values()}) == 3


def test_dxf_groups_are_the_boundaries(tmp_path: Path) -> None:
    """The entities of a group, in their order, close up and enclose the area."""
    cases = [*((each, "+-/up") for each in DESIGNS), *random_cases(25)]
    compared = 0
    for lengths, mode in cases:
        found = geometry(lengths, "workspace", mode, unit="mm")
        if found.is_empty:
            continue
        factor = found.design.factor
        document = read_dxf(found, tmp_path, 1e-5)
        names_of = {e.dxf.handle: name for name, group in document.groups for e in group}
        groups: dict[str, list[Any]] = {}
        for entity in document.modelspace():
            if entity.dxftype() != "POINT":
                groups.setdefault(names_of[entity.dxf.handle], []).append(entity)
        (region,) = found.regions
        names = ["OUTLINE_1", *(f"HOLE_1_{number + 1}" for number in range(len(region.holes)))]
        assert list(groups) == names
        numbers: list[int] = []
        for name, loop in zip(names, region.loops, strict=True):
            turned = []
            for entity, named in zip(groups[name], loop.arcs, strict=True):
                numbers.append(int(tags_of(entity)["arc"]))
                start, end, area = ends_and_area(entity)
                clockwise = isinstance(named.arc, CircleArc) and named.arc.sweep < 0.0
                side = "right" if clockwise else "left"
                assert tags_of(entity)["modes"] == f"{side}: {mode}"
                assert tags_of(entity)["start"] == named.ends[1 if clockwise else 0]
                turned.append((end, start, -area) if clockwise else (start, end, area))
            for (_, end, _), (start, _, _) in itertools.pairwise([*turned, turned[0]]):
                assert abs(end - start) < 2e-9 * factor
            area = math.fsum(area for _, _, area in turned)
            around = sum(named.arc.length() for named in loop.arcs)
            assert area == pytest.approx(loop.area, abs=1e-5 * factor * around)
            compared += 1
        assert numbers == list(range(1, len(numbers) + 1))
    assert compared > 30


def test_dxf_circles_level_curves_and_points(tmp_path: Path) -> None:
    found = geometry((1.28, 1.72, 0), "loci")
    entities = list(read_dxf(found, tmp_path).modelspace())
    assert sorted((e.dxf.layer, e.dxf.radius) for e in entities if e.dxftype() == "CIRCLE") == [
        ("C_1i", pytest.approx(0.44)),
        ("C_1o", 3.0),
        ("C_2i", pytest.approx(0.44)),
        ("C_2o", 3.0),
    ]
    good = geometry((1.28, 1.72, 0), "good-condition")
    lines = list(read_dxf(good, tmp_path).modelspace().query("LWPOLYLINE"))
    assert [line.closed for line in lines] == [True, True]
    assert {line.dxf.layer for line in lines} == {"LCI_0.5"}
    area = math.fsum(ends_and_area(line)[2] for line in lines)
    assert area == pytest.approx(19.77874, abs=2e-5)
    points = read_dxf(geometry((1.5, 1.5, 0), "loci"), tmp_path).modelspace().query("POINT")
    assert [(p.dxf.layer, tuple(p.dxf.location)) for p in points] == [
        ("ISOLATED_POINTS", (0.0, 0.0, 0.0)),
        ("BASE_JOINTS", (0.0, 0.0, 0.0)),
    ]


@pytest.mark.parametrize(
    ("unit", "code"), [("mm", 4), ("cm", 5), ("m", 6), ("in", 1), ("furlong", 0), ("", 0)]
)
def test_dxf_header_has_the_unit(unit: str, code: int, tmp_path: Path) -> None:
    found = geometry((26, 30, 16), "workspace", unit=unit)
    document = read_dxf(found, tmp_path)
    assert document.dxfversion == "AC1024"
    assert document.header["$INSUNITS"] == code
    properties = dict(document.header.custom_vars.properties)
    assert properties["Unit"] == (unit or "non-dimensional")
    assert float(properties["D"]) == (24.0 if unit else 1.0)
    low, high = found.extent()
    np.testing.assert_allclose(document.header["$EXTMIN"][:2], low)
    np.testing.assert_allclose(document.header["$EXTMAX"][:2], high)


# Files


@pytest.mark.parametrize("form", ["csv", "svg", "dxf"])
@pytest.mark.parametrize("kind", ["loci", "workspace", "good-condition", "circles"])
def test_two_writes_give_equal_bytes(form: str, kind: str, tmp_path: Path) -> None:
    before = ezdxf.options.write_fixed_meta_data_for_testing
    written = []
    for name in ("one", "two"):
        path = tmp_path / f"{name}.{form.upper()}"
        write_geometry(geometry((26, 30, 16), kind), path)
        written.append(path.read_bytes())
    assert written[0] == written[1]
    assert b"\r" not in written[0]
    assert ezdxf.options.write_fixed_meta_data_for_testing == before
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"one.{form.upper()}",
        f"two.{form.upper()}",
    ]


def test_nothing_is_written_where_there_is_nothing(tmp_path: Path) -> None:
    path = tmp_path / "empty.svg"
    with pytest.raises(FileError, match=r"nothing to write: the usable workspace of \+\+/up is e"):
        write_geometry(geometry((1.28, 1.72, 0), "workspace", "++/up"), path)
    assert not path.exists()


def test_files_are_not_overwritten_unasked(tmp_path: Path) -> None:
    path = tmp_path / "there.csv"
    path.write_text("mine")
    found = geometry((26, 30, 16), "circles")
    with pytest.raises(FileUsageError, match="--overwrite"):
        write_geometry(found, path)
    assert path.read_text() == "mine"
    write_geometry(found, path, overwrite=True)
    assert path.read_text() == csv_text(found, 24.0 * DEVIATION)


def test_wrong_endings_and_deviations_are_refused(tmp_path: Path) -> None:
    found = geometry((26, 30, 16), "circles")
    with pytest.raises(InputError, match=re.escape("one of .csv, .svg, .dxf")):
        write_geometry(found, tmp_path / "drawing.stl")
    for deviation in (0.0, 1e-9, 0.2, -1.0, math.nan):
        with pytest.raises(InputError, match=r"from 1e-08 to 0\.1"):
            write_geometry(found, tmp_path / "points.csv", deviation=deviation)
    assert not list(tmp_path.iterdir())


def test_without_ezdxf_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    found = geometry((26, 30, 16), "circles")
    with pytest.raises(FileError, match=re.escape("pip install 'fivebar-atlas[cad]'")) as caught:
        write_geometry(found, tmp_path / "drawing.dxf")
    assert caught.value.exit_code == 1
    write_geometry(found, tmp_path / "points.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["points.csv"]


# JSON


def keys_of(document: Any) -> Iterator[str]:
    """Yield all keys, but not the mode pairs."""
    if isinstance(document, dict):
        for key, value in document.items():
            yield key
            if key != "modes":
                yield from keys_of(value)
    elif isinstance(document, list):
        for value in document:
            yield from keys_of(value)


def test_json_keys_are_those_documented() -> None:
    documented = set(re.findall(r"``(\w+)``", json_module.__doc__ or "")) | {"R2", "R3"}
    found: set[str] = set()
    for kind in ("loci", "workspace", "good-condition", "circles"):
        document = json_document(geometry((26, 30, 16), kind), 24.0 * DEVIATION)
        json.dumps(document, allow_nan=False)
        found.update(keys_of(document))
    assert found <= documented
    assert documented - found == {"r1"}


def outlined_area(boundary: dict[str, Any]) -> float:
    """Return the area that a boundary of the document encloses, from its arcs alone."""
    total = []
    for arc in boundary["arcs"]:
        if arc["circle"] is None:
            x, y = np.array(arc["points"]).T
            total.append(0.5 * math.fsum(x[:-1] * y[1:] - x[1:] * y[:-1]))
            continue
        (a, b), radius = arc["circle"]["centre"], arc["circle"]["radius"]
        (x0, y0), (x1, y1) = arc["start"], arc["end"]
        total.append(0.5 * (radius**2 * arc["circle"]["sweep"] + a * (y1 - y0) - b * (x1 - x0)))
    return math.fsum(total)


def test_json_has_both_areas_and_boundaries_in_order() -> None:
    document = json_document(geometry((26, 30, 16), "workspace"), 24e-6)
    assert (document["unit"], document["dimensional_factor"]) == ("mm", 24.0)
    assert (document["R1"], document["R2"], document["R3"]) == pytest.approx((26, 30, 16))
    assert document["remarks"] == ["sub-region Va"]
    integrated = FiveBar.from_lengths(26, 30, 16).evaluate("+-/up", [])["usable_workspace_area"]
    assert document["area"]["green"] == pytest.approx(24.0**2 * integrated, rel=1e-8)
    assert document["area"]["integrated"] == pytest.approx(document["area"]["green"], rel=1e-9)
    (region,) = document["regions"]
    boundaries = [region["outline"], *region["holes"]]
    assert [len(boundary["arcs"]) for boundary in boundaries] == [3, 4]
    for boundary in boundaries:
        assert outlined_area(boundary) == pytest.approx(
            boundary["area"], abs=24e-6 * boundary["length"]
        )
    assert region["area"] == pytest.approx(boundaries[0]["area"] + boundaries[1]["area"])
    assert boundaries[1]["area"] < 0.0


def test_json_remarks_and_isolated_points() -> None:
    document = json_document(geometry((1.5, 1.5, 0), "loci"), DEVIATION)
    assert document["isolated_points"] == [[0.0, 0.0]]
    assert any("change-point" in remark and "d, e" in remark for remark in document["remarks"])
    assert document["area"] is None
    empty = json_document(geometry((1.28, 1.72, 0), "workspace", "++/up"), DEVIATION)
    assert empty["regions"] == []
    assert empty["area"] == {"green": 0.0, "integrated": 0.0}
    assert empty["absence"] == "the usable workspace of ++/up is empty"


def test_inscribed_circles_are_those_of_the_evaluator() -> None:
    document = json_document(geometry((26, 30, 16), "circles"), 24.0 * DEVIATION)
    values = FiveBar.from_lengths(26, 30, 16).evaluate("+-/up", [])
    for arc, name in zip(document["arcs"], ("mic_upper", "mic_lower"), strict=True):
        assert arc["curve"] == name.replace("mic", "MIC")
        assert arc["circle"]["radius"] == pytest.approx(24.0 * values[name]["radius"], rel=1e-9)
        assert arc["circle"]["centre"] == pytest.approx([0.0, 24.0 * values[name]["y"]])
        assert arc["length"] == pytest.approx(2.0 * math.pi * arc["circle"]["radius"])
