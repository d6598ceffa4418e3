"""``atlas report``: what a page has, that it needs nothing else, and what is refused."""

from __future__ import annotations

import datetime
import json
import re
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import closed_form_mechanism
import pytest
from conftest import Command
from report_page import Element, read_page

from fivebar_atlas import __version__
from fivebar_atlas.cli import main
from fivebar_atlas.cli.report import REPORTABLE
from fivebar_atlas.jit import kernel_hash
from fivebar_atlas.report.content import Picture, Report, Row, Section, Table
from fivebar_atlas.report.inline_svg import inline_svg
from fivebar_atlas.report.page import page
from fivebar_atlas.report.provenance import provenance

SIZE = (
    "size", "26", "30", "16", "--rectangle", "300x200", "--clearance", "10",
    "--encoder-resolution", "0.01", "--force", "10",
)  # fmt: skip
EVALUATE = ("evaluate", "26", "30", "16", "--mode", "+-/up", "--mode", "++/down")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a small atlas of the five-bar."""
    folder = tmp_path_factory.mktemp("report")
    return closed_form_mechanism.write(folder / "small.h5", "five-bar")


@pytest.fixture
def made(atlas: Command, tmp_path: Path) -> Callable[..., tuple[Element, dict[str, Any]]]:
    """Make a report; return its page, and the JSON that the command itself prints."""

    def make(*arguments: object) -> tuple[Element, dict[str, Any]]:
        output = tmp_path / "report.html"
        outcome = atlas("report", *arguments, "-o", output)
        assert outcome.code == 0, outcome.err
        assert outcome.out == outcome.err == ""
        found = read_page(output.read_text(encoding="utf-8"))
        printed = atlas(*arguments, "--json")
        assert printed.code == 0
        return found, json.loads(printed.out)

    return make


Made = Callable[..., tuple[Element, dict[str, Any]]]


def headings(found: Element) -> list[str]:
    return [each.text for each in found.all("h2")]


def assert_stands_alone(found: Element) -> None:
    """Assert that ids are unique, references lead somewhere, and nothing is loaded."""
    elements = found.all()
    identifiers = [e.attributes["id"] for e in elements if "id" in e.attributes]
    assert len(identifiers) == len(set(identifiers))
    for each in elements:
        assert each.tag not in ("script", "link", "iframe", "object", "embed", "base"), each.tag
        for name, value in each.attributes.items():
            value = value or ""
            assert "//" not in value or value.startswith("data:"), (each.tag, name, value)
            if name in ("href", "src"):
                is_within = value.startswith("#") and value[1:] in identifiers
                assert is_within or value.startswith("data:image/png;base64,"), value
            for target in re.findall(r"url\(([^)]*)\)", value):
                assert target[:1] == "#", target
                assert target[1:] in identifiers, target
    (style,) = found.all("style")
    assert not re.search(r"@import|url\(|https?:", style.raw_text)


def test_a_sized_machine(made: Made) -> None:
    found, document = made(*SIZE)
    assert found.all("html")[0].attributes["lang"] == "en"
    assert found.all("h1")[0].text == "Machine for a rectangle 300 x 200 mm"
    assert headings(found) == [
        "Inputs", "Choices", "Figures", "Machine", "Practical workspace", "Indices and areas",
        "Actuators", "Errors and loads", "Provenance", "Data",
    ]  # fmt: skip
    assert json.loads(found.all("details")[0].all("pre")[0].raw_text) == document
    inputs = found.section("Inputs")
    rows = inputs.rows()
    assert rows["R1 R2 R3"] == "26 30 16"
    assert rows["--rectangle"].startswith("300x200 ")
    assert set(rows) == {
        *("R1 R2 R3", "--rectangle", "--clearance", "--encoder-resolution", "--force")
    }
    words = shlex.split(inputs.all("code")[0].text)
    assert words[:-1] == ["atlas", "report", *SIZE, "-o"]
    machine = found.section("Machine").rows()
    for name in ("R1", "R2", "R3"):
        assert machine[name].startswith(f"{document[name]:.10g} mm")
    error = document["dimensional_factor_error"]
    factor = f"{document['dimensional_factor']:.10g} mm ± {error:.0e} mm"
    assert machine["Dimensional factor D"] == factor
    indices = found.section("Indices and areas").rows()
    values = document["indices"]["dimensional"]["modes"][0]
    (good,) = values["good_condition"]
    assert indices["Good-condition workspace area"] == (
        f"{good['area']:.8g} mm² | ± {good['area_error']:.1e} mm²"
    )
    (mode,) = document["indices"]["modes"]
    assert indices["Global conditioning index"] == f"{mode['gci']:.8g} | ± {mode['gci_error']:.1e}"
    error = document["positioning_error"]["value"]
    assert found.section("Errors and loads").rows()["Positioning error"].startswith(f"{error:.6g}")
    assert len(found.all("figure")) == 3
    captions = [each.text for each in found.all("figcaption")]
    assert all("mm" in caption for caption in captions)
    assert_stands_alone(found)


def test_the_shape_is_drawn_where_it_lies(made: Made) -> None:
    found, _ = made(*SIZE)
    for figure in found.all("figure")[:2]:
        drawn = {each.attributes.get("id") or "" for each in figure.all("g")}
        prefix = f"{figure.attributes['id']}-"
        assert {f"{prefix}overlay-1", f"{prefix}overlay-2", f"{prefix}overlay-points-2"} <= drawn
        caption = figure.all("figcaption")[0].text
        assert "with the rectangle 300 x 200 mm and the clearance of 10 mm" in caption


def test_an_evaluated_design(made: Made) -> None:
    found, document = made(*EVALUATE)
    assert found.all("h1")[0].text == "Design R1 = 26, R2 = 30, R3 = 16"
    design = found.section("Design").rows()
    assert design["Dimensional factor D"].startswith("24")
    for mode, scaled in zip(document["modes"], document["dimensional"]["modes"], strict=True):
        label = f"{mode['working_mode']}/{mode['assembly_mode']}"
        rows = found.section(f"Mode pair {label}").rows()
        area, error = mode["usable_workspace_area"], mode["usable_workspace_area_error"]
        assert rows["Usable workspace area"] == (
            f"{area:.8g} | ± {error:.1e} | {scaled['usable_workspace_area']:.8g}"
        )
        (good,) = mode["good_condition"]
        gci = f"{good['gci']:.8g} | ± {good['gci_error']:.1e} | "
        name = "Global conditioning index of the good-condition workspace at threshold 0.5"
        assert rows[name] == gci
    # workspace and LCI map of each mode pair, and the linkage
    assert len(found.all("figure")) == 5
    assert_stands_alone(found)


def test_figures_of_four_mode_pairs_at_most_and_a_word_on_that(made: Made) -> None:
    found, _ = made("evaluate", "1.3", "1.6", "0.1", "--mode", "all")
    assert len(found.all("figure")) == 9
    assert found.section("Choices").rows()["Mode pairs"].endswith("figures of the first 4")
    assert "Scaled by D" not in found.section("Design").text


def test_an_empty_workspace_has_loci_and_no_map(made: Made) -> None:
    found, document = made("evaluate", "1.28", "1.72", "0", "--mode", "++/up")
    assert document["modes"][0]["status"].startswith("empty")
    (figure,) = found.all("figure")
    assert figure.all("figcaption")[0].text.startswith("Figure 1. The usable workspace of ++/up")


def test_a_mechanism_in_space_has_no_figures(made: Made, toy: str) -> None:
    found, _ = made("evaluate", "1", "2", "--mechanism", toy)
    assert found.all("figure") == []
    assert "Figures" not in headings(found)


def test_an_optimum_region(made: Made, file: Path) -> None:
    conditions = ("--where", "usable_workspace_area>=24", "--where", "gci>=0.62")
    found, document = made(
        "optimum", file, *conditions, "--maximise", "gci", "--pareto", "usable_workspace_area,gci"
    )
    title = "usable workspace area ≥ 24 and global conditioning index ≥ 0.62"
    assert found.all("h1")[0].text == f"Designs with {title}"
    assert headings(found)[3:7] == [
        "Region", "Best designs of the lattice", "Best design", "Pareto front",
    ]  # fmt: skip
    region = found.section("Region").rows()
    assert region["Designs of the lattice"] == f"{document['lattice_designs']} of {len_of(file)}"
    assert region["Share of the space"] == f"{100.0 * document['region']['share']:.4g} %"
    for name, (least, greatest) in document["region"]["extent"].items():
        assert region[name] == f"{least:.4f} | {greatest:.4f}"
    best = found.section("Best design").rows()
    maximum = document["maximum"]
    value, error = maximum["values"]["gci"], maximum["errors"]["gci"]
    assert best["Global conditioning index"] == f"{value:.10g} ± {error:.1e}"
    front = found.section("Pareto front").all("tbody")[0].all("tr")
    assert len(front) == len(document["pareto"]["members"])
    assert len(found.all("figure")) == 3
    assert_stands_alone(found)


def len_of(file: Path) -> int:
    from fivebar_atlas.store import open_atlas

    with open_atlas(file) as opened:
        return len(opened)


def test_an_empty_region_says_why(made: Made, file: Path) -> None:
    found, document = made("optimum", file, "--where", "gci>0.7", "--pareto", "gci,-r3")
    assert document["conflict"] is not None
    region = found.section("Region").rows()
    assert region["Region"] == "empty: no design has gci>0.7"
    assert "the region is empty: no design has gci>0.7." in found.all("header")[0].text
    (reach,) = document["conflict"]["reaches"]
    assert region["gci>0.7, in the whole space"].startswith(f"{reach['alone']:.8g} at r1 ")
    assert "Pareto front" not in headings(found)


def test_an_optimum_without_conditions_has_maps(made: Made, file: Path) -> None:
    found, _ = made("optimum", file, "--maximise", "gci")
    (figure,) = found.all("figure")
    assert figure.all("figcaption")[0].text == "Figure 1. Atlas of the global conditioning index."


def test_provenance_and_policy(made: Made) -> None:
    found, _ = made("evaluate", "1.3", "1.6", "0.1")
    rows = found.section("Provenance").rows()
    assert rows["fivebar-atlas"] == __version__
    assert rows["Kernels"].startswith(kernel_hash())
    assert rows["Python"] == ".".join(map(str, sys.version_info[:3]))
    assert {"numpy", "numba", "matplotlib"} <= set(rows)
    computed = datetime.datetime.strptime(rows["Computed"], "%Y-%m-%d %H:%M:%S %Z")
    assert abs(datetime.datetime.now(datetime.UTC).replace(tzinfo=None) - computed).days < 1
    metas = [each.attributes for each in found.all("meta")]
    assert {
        "http-equiv": "Content-Security-Policy",
        "content": "default-src 'none'; style-src 'unsafe-inline'; img-src data:",
    } in metas
    assert any(each.get("name") == "viewport" for each in metas)


def test_the_same_run_gives_the_same_bytes_but_for_the_time(atlas: Command, tmp_path: Path) -> None:
    output = tmp_path / "design.html"
    pages = []
    for _ in range(2):
        assert atlas("report", *EVALUATE, "-o", output, "--overwrite").code == 0
        pages.append(re.sub(r"\d\d:\d\d:\d\d UTC", "time", output.read_text(encoding="utf-8")))
    assert pages[0] == pages[1]


@pytest.mark.parametrize("name", ["report.pdf", "report", "report.htm"])
def test_another_ending_is_refused(refused: Callable[..., str], tmp_path: Path, name: str) -> None:
    assert "ends in one of .html" in refused("report", *SIZE, "-o", tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_is_kept(
    refused: Callable[..., str], atlas: Command, tmp_path: Path
) -> None:
    output = tmp_path / "design.html"
    output.write_text("mine")
    assert "--overwrite" in refused("report", *EVALUATE, "-o", output)
    assert output.read_text() == "mine"
    assert atlas("report", *EVALUATE, "-o", output, "--overwrite").code == 0
    assert output.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    missing = tmp_path / "nowhere" / "design.html"
    assert "does not exist" in refused("report", *EVALUATE, "-o", missing)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("size", "26", "30", "16", "--circle", "3", "--offset", "0", "0.1"), 1, "fits at no size"),
        (("size", "26", "30", "16"), 2, "give one of --area"),
        (("evaluate", "26", "30"), 2, "3 numbers"),
        (("optimum", "nowhere.h5", "--where", "gci>1"), 2, "nowhere.h5"),
    ],
)
def test_a_run_that_fails_writes_nothing(
    refused: Callable[..., str],
    tmp_path: Path,
    arguments: tuple[str, ...],
    code: int,
    message: str,
) -> None:
    text = refused("report", *arguments, "-o", tmp_path / "report.html", code=code)
    assert message in text
    assert list(tmp_path.iterdir()) == []


def test_wrong_commands_and_options_are_refused(
    refused: Callable[..., str], tmp_path: Path
) -> None:
    assert "one of evaluate, optimum, size" in refused("report", "sise", "-o", "a.html")
    output = tmp_path / "a.html"
    assert "--json" in refused("report", "size", "1", "1", "1", "--json", "-o", output)
    assert "Missing option '-o'" in refused("report", "evaluate", "26", "30", "16")


@pytest.mark.parametrize("name", REPORTABLE)
def test_arguments_and_help_are_those_of_the_command(atlas: Command, name: str) -> None:
    context = click.Context(main)
    original = main.get_command(context, name)
    group = main.get_command(context, "report")
    assert original is not None
    assert isinstance(group, click.Group)
    reported = group.get_command(context, name)
    assert reported is not None
    outputs = {"as_json", "output", "overwrite"}
    assert {each.name for each in reported.params} - outputs == {
        each.name for each in original.params
    } - outputs
    outcome = atlas("report", name, "--help")
    assert outcome.code == 0
    assert "FILE.html" in outcome.out
    assert original.help is not None
    assert " ".join(original.help.split())[:60] in " ".join(outcome.out.split())


def test_the_group_teaches(atlas: Command) -> None:
    outcome = atlas("report", "--help")
    assert "atlas report size 26 30 16 --rectangle 300x200 -o machine.html" in outcome.out


# --- the page, and figures in it


def report_with(**parts: Any) -> Report:
    nothing = Section("Nothing")
    given: dict[str, Any] = {
        "title": "T", "summary": "S.", "command_line": "atlas", "inputs": nothing,
        "choices": nothing, "pictures": (), "sections": (), "provenance": nothing,
        "document": "{}",
    }  # fmt: skip
    return Report(**{**given, **parts})


def test_text_is_text() -> None:
    text = "a < b & \"c\" <script>alert('d')</script>"
    section = Section(
        text, (text,), (Row(text, text, text, text),), (Table((text,), ((text,),), text),)
    )
    found = read_page(
        page(
            report_with(
                title=text, summary=text, command_line=text, sections=(section,), document=text
            )
        )
    )
    assert found.all("script") == []
    assert found.all("h1")[0].text == text
    assert found.all("title")[0].text == text
    assert found.all("code")[0].text == text
    assert found.section(text).all("caption")[0].text == text
    assert found.all("details")[0].all("pre")[0].raw_text == text


def test_a_figure_brings_nothing_along_and_keeps_its_references() -> None:
    svg = """<?xml version="1.0" encoding="utf-8" standalone="no"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">
<svg xmlns:xlink="http://www.w3.org/1999/xlink" width="10pt" height="5pt" viewBox="0 0 10 5"
 xmlns="http://www.w3.org/2000/svg" version="1.1">
 <metadata><a href="http://example.org"/></metadata>
 <defs><style type="text/css">*{fill: red}</style><path id="m 1" d="M 0.1234567 1
L 2 -0.9999999"/><clipPath id="c"/></defs>
 <g id="a" clip-path="url(#c)" style="fill: url(#m 1)"><use xlink:href="#m 1" x="3.14159265"/></g>
</svg>"""
    found = read_page(inline_svg(svg, "figure-1-", "What it <shows>"))
    (root,) = found.all("svg")
    assert root.attributes == {
        "viewbox": "0 0 10 5", "role": "img", "aria-label": "What it <shows>",
    }  # fmt: skip
    tags = [each.tag for each in found.all()]
    assert tags == ["svg", "defs", "path", "clippath", "g", "use"]
    path, clip, group, use = found.all()[2:]
    assert path.attributes == {"id": "figure-1-m-1", "d": "M 0.123 1 L 2 -0.999"}
    assert clip.attributes["id"] == "figure-1-c"
    assert group.attributes["clip-path"] == "url(#figure-1-c)"
    assert group.attributes["style"] == "fill: url(#figure-1-m-1)"
    assert use.attributes == {"href": "#figure-1-m-1", "x": "3.14159265"}


def test_figures_of_one_look_have_ids_of_their_own() -> None:
    svg = '<svg xmlns="http://www.w3.org/2000/svg"><path id="m"/></svg>'
    pictures = (Picture("One.", svg), Picture("Two.", svg))
    assert_stands_alone(read_page(page(report_with(pictures=pictures))))


def test_time_is_given_in_utc() -> None:
    zone = datetime.timezone(datetime.timedelta(hours=2))
    section = provenance(datetime.datetime(2026, 7, 1, 0, 30, 0, tzinfo=zone))
    (row,) = (row for row in section.rows if row.label == "Computed")
    assert row.value == "2026-06-30 22:30:00 UTC"
