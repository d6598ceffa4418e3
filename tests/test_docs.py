"""The documentation says what is so: links resolve, examples run, commands and names exist."""

from __future__ import annotations

import doctest
import importlib
import math
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import click
import pytest
import yaml

import fivebar_atlas
from fivebar_atlas import config, mechanisms
from fivebar_atlas.cli import main
from fivebar_atlas.mechanisms.settings import SweepSettings

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted(DOCS.glob("*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
FIVE_BAR = mechanisms.get("five-bar")


def identify(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path, *languages: str) -> list[str]:
    """Return the contents of the fenced code blocks of some languages."""
    found = FENCE.findall(page.read_text(encoding="utf-8"))
    return [text for language, text in found if language in languages]


def shell_lines(page: Path) -> list[str]:
    """Return the command lines of a page, continued lines joined, prompts removed."""
    text = "".join(blocks(page, "sh", "console")).replace("\\\n", " ")
    lines = text.splitlines()
    if blocks(page, "sh"):
        return [line.removeprefix("$ ") for line in lines if line]
    return [line.removeprefix("$ ") for line in lines if line.startswith("$ ")]


def leaf_commands(command: click.Command, path: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Yield the words of every command that does something."""
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            inner = command.get_command(context, name)
            assert inner is not None
            yield from leaf_commands(inner, (*path, name))
    else:
        yield path


def find_command(words: list[str]) -> tuple[click.Command, list[str]]:
    """Return the command that words name, and the words after its name."""
    command: click.Command = main
    rest = words[1:]
    while isinstance(command, click.Group) and rest:
        inner = command.get_command(click.Context(command), rest[0])
        assert inner is not None, f"{shlex.join(words)}: there is no command {rest[0]!r}"
        command, rest = inner, rest[1:]
    return command, rest


@pytest.mark.parametrize("page", PAGES, ids=identify)
def test_links_to_files_resolve(page: Path) -> None:
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = unquote(target).partition("#")
        file = page.parent / name if name else page
        if "_generated" in file.parts:
            continue  # made when the documentation is built, which fails without it
        assert file.exists(), f"{identify(page)} links to {target}"
        if anchor:
            headings = re.findall(r"^#+ (.+)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            slugs = [re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings]
            assert anchor in slugs, f"{identify(page)} links to {target}"


def test_labels_referred_to_exist() -> None:
    known: list[str] = []
    for page in DOCS.glob("*.md"):
        known += re.findall(r"^\(([\w-]+)\)=$", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(known) == len(set(known)), "a label is defined twice"
    referred = 0
    for page in DOCS.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\{ref\}`(?:[^`<]*<)?([\w-]+)>?`", text):
            assert target in known, f"{identify(page)} refers to {target}"
            referred += 1
        for target in re.findall(r"\{doc\}`(?:[^`<]*<)?([\w/-]+)>?`", text):
            assert (DOCS / f"{target}.md").exists(), f"{identify(page)} refers to {target}"
    assert referred


def test_every_page_is_in_the_index() -> None:
    listed = re.findall(r"^([a-z_]+)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.M)
    assert sorted(listed) == sorted(page.stem for page in DOCS.glob("*.md") if page.stem != "index")


@pytest.fixture
def small_atlas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make the file that the examples open, coarse, where they look for it."""
    monkeypatch.chdir(tmp_path)
    main(
        ["sweep", "--resolution", "12", "--tolerance", "1e-4", "--quiet", "-o", "paper.h5"],
        standalone_mode=False,
    )
    return tmp_path / "paper.h5"


@pytest.mark.parametrize(
    "page", [page for page in PAGES if blocks(page, "python", "pycon")], ids=identify
)
@pytest.mark.usefixtures("small_atlas")
def test_python_examples_give_what_they_show(page: Path) -> None:
    # The examples of a page share their names, as they would for a reader who types them.
    names: dict[str, object] = {}
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    for text in blocks(page, "python", "pycon"):
        test = doctest.DocTestParser().get_doctest(text, names, identify(page), str(page), 0)
        assert test.examples, f"{identify(page)} has Python that is not an example:\n{text}"
        report: list[str] = []
        runner.run(test, out=report.append, clear_globs=False)
        names = test.globs
        assert not report, "".join(report)


@pytest.mark.parametrize("name", sorted(set(fivebar_atlas.__all__) - {"__version__"}))
@pytest.mark.usefixtures("small_atlas")
def test_examples_in_docstrings_give_what_they_show(name: str) -> None:
    public = getattr(fivebar_atlas, name)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    report: list[str] = []
    for test in doctest.DocTestFinder().find(public, name, globs={name: public}):
        runner.run(test, out=report.append)
    assert not report, "".join(report)


@pytest.mark.parametrize("page", PAGES, ids=identify)
def test_commands_and_options_exist(page: Path) -> None:
    for line in shell_lines(page):
        words = shlex.split(line, comments=True)
        if words[:1] != ["atlas"] or words[1:2] == ["--help"]:
            continue
        command, rest = find_command(words)
        assert not isinstance(command, click.Group), f"{identify(page)}: {line} does nothing"
        known = {name for parameter in command.params for name in parameter.opts} | {"--help"}
        for word in rest:
            if re.match(r"--?[a-z]", word):
                assert word in known, f"{identify(page)}: {line}"


def test_readme_targets_exist_in_the_makefile() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"^([a-z-]+):.*## ", makefile, re.MULTILINE)
    used = [shlex.split(line) for line in shell_lines(ROOT / "README.md")]
    made = [words for words in used if words[:1] == ["make"]]
    assert made
    for words in made:
        goals = [word for word in words[1:] if "=" not in word]
        assert goals
        assert set(goals) <= set(targets)
        for name, _, value in (word.partition("=") for word in words[1:] if "=" in word):
            assert re.search(rf"^{name} \?=", makefile, re.MULTILINE)
            if name == "CONFIGS":
                assert (ROOT / value).exists()


def test_command_reference_has_every_command() -> None:
    text = (DOCS / "commands.md").read_text(encoding="utf-8")
    directive = re.compile(r"\.\. click:: ([\w.]+):(\w+)\n   :prog: (.+)\n(   :nested: full\n)?")
    documented: set[tuple[str, ...]] = set()
    for module, name, program, nested in directive.findall(text):
        words = tuple(program.split())
        command = getattr(importlib.import_module(module), name)
        assert find_command(list(words)) == (command, [])
        documented |= set(leaf_commands(command, words)) if nested else {words}
    assert documented == set(leaf_commands(main, ("atlas",)))


def table_rows(page: Path, heading: str) -> list[list[str]]:
    """Return the cells of the first table below a heading."""
    text = page.read_text(encoding="utf-8").split(f"{heading}\n", 1)[1]
    lines = text.split("|---", 1)[1].split("\n")[1:]
    rows = []
    for line in lines:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def test_format_describes_every_result_and_no_other() -> None:
    settings = SweepSettings("five-bar", "surrounded", 3, ("+-/up",), (0.5,), 1e-6)
    stored = {}
    for array in FIVE_BAR.result_arrays(settings):
        kind = str(array.dtype)
        if array.quantity.flags is not None and not array.is_error:
            kind += " mask" if array.quantity.flags.masks else " flag"
        stored[f"`{array.name}`"] = [", ".join(array.quantity.dimensions), kind]
    rows = table_rows(DOCS / "format.md", "### Results of the five-bar")
    assert {name: [dimensions, kind] for name, dimensions, kind, _ in rows} == stored


def test_format_describes_every_axis_column_and_parameter() -> None:
    settings = SweepSettings("five-bar", "surrounded", 3, ("+-/up",), (0.5,), 1e-6)
    stored = {f"`{p.name}`": ["design", "float64"] for p in FIVE_BAR.parameters}
    for axis in FIVE_BAR.axes(settings):
        for column in axis.columns:
            kind = str(column.values.dtype) + (" flag" if column.flags else "")
            stored[f"`{column.name}`"] = [axis.name, kind]
    rows = table_rows(DOCS / "format.md", "### Describing the axes")
    assert {name: [dimensions, kind] for name, dimensions, kind, _ in rows} == stored


def test_format_describes_every_flag_and_status_bit() -> None:
    settings = SweepSettings("five-bar", "surrounded", 3, ("+-/up",), (0.5,), 1e-6)
    flags = {q.name: q.flags for q in FIVE_BAR.quantities if q.flags is not None}
    for axis in FIVE_BAR.axes(settings):
        flags |= {c.name: c.flags for c in axis.columns if c.flags is not None}
    status = flags.pop("status")
    rows = table_rows(DOCS / "format.md", "## Flags")
    described = {
        name.strip("`"): [
            (int(value), meaning) for value, meaning in re.findall(r"(-?\d+): `([^`]+)`", text)
        ]
        for name, text in rows
    }
    assert described == {
        name: list(zip(each.values, each.meanings, strict=True)) for name, each in flags.items()
    }
    bits = [
        (int(bit), meaning.strip("`"))
        for bit, meaning, _ in table_rows(DOCS / "format.md", "### Status bits")
    ]
    assert bits == list(zip(status.values, status.meanings, strict=True))


def test_format_describes_every_attribute(small_atlas: Path) -> None:
    import h5py

    rows = table_rows(DOCS / "format.md", "## Root attributes")
    with h5py.File(small_atlas) as file:
        assert {name.strip("`") for name, _, _ in rows} == set(file.attrs)
        rows = table_rows(DOCS / "format.md", "### Attributes of a dataset")
        described = set(re.findall(r"`(\w+)`", " ".join(row[0] for row in rows)))
        used = {name for dataset in file.values() for name in dataset.attrs}
    # What HDF5 itself writes for dimension scales.
    used -= {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"}
    assert used == described


def test_algorithm_page_gives_the_constants_of_the_program() -> None:
    from fivebar_atlas.mechanisms.five_bar import indices, panels, rays

    text = " ".join((DOCS / "algorithm.md").read_text(encoding="utf-8").split())
    orders = panels.ALONG_ORDERS
    assert f"Of {len(orders)} Gauss–Kronrod pairs, with {orders[0]} to {orders[-1]} Gauss" in text
    assert f"a pair with {rays.ACROSS_ORDER} Gauss nodes runs across each" in text
    assert f"within {panels.MAX_PANELS} panels" in text
    assert f"is {indices.SAFETY:g} times the sum over all panels" in text
    assert f"above $10^{{{math.log10(indices.COARSEST):g}}}$ is worked at" in text
    assert panels.ALONG_GAIN == panels.LCI_GAIN
    assert f"with $g = {panels.ALONG_GAIN:g}$ along rays" in text
    assert f"and $g = {panels.LEVEL_GAIN:g}$" in text


def test_configuration_page_lists_every_key_and_its_default(tmp_path: Path) -> None:
    page = DOCS / "configuration.md"
    rows = table_rows(page, "# Configuration")
    sections = {"sweep": config.SweepSection, "run": config.RunSection}
    known = {"mechanism"} | {
        f"{table}.{key}" for table, model in sections.items() for key in model.model_fields
    }
    assert {row[0].strip("`") for row in rows} == known
    (example,) = blocks(page, "toml")
    file = tmp_path / "example.toml"
    file.write_text(example, encoding="utf-8")
    # The example spells out the defaults.
    assert config.resolve(file).settings == config.resolve().settings


def test_versions_agree() -> None:
    version = fivebar_atlas.__version__
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert project["version"] == version
    assert citation["version"] == version
    assert f"## [{version}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", fivebar_atlas.__all__)
def test_public_names_can_be_imported(name: str) -> None:
    assert getattr(fivebar_atlas, name) is not None


def test_api_page_has_every_public_name() -> None:
    text = (DOCS / "api.md").read_text(encoding="utf-8")
    for name in set(fivebar_atlas.__all__) - {"__version__"}:
        assert re.search(rf"\b{name}$", text, re.MULTILINE), name


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = (
        "import sys, fivebar_atlas\n"
        "print([m for m in ('numpy', 'numba', 'h5py', 'matplotlib', 'pydantic', 'click')"
        " if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_unknown_public_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'SixBar'"):
        _ = fivebar_atlas.SixBar
