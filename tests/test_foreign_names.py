"""A name of one mechanism that is asked of a file of another: the error names both."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import closed_form_mechanism
import pytest

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import ForeignNameError, UnknownNameError
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import Atlas, AtlasWriter, open_atlas

PARAMETERS = "r1, r2, r3"


@pytest.fixture
def file(toy: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:  # noqa: ARG001
    """Return a file of a mechanism that has the names of the five-bar, the toy being another."""
    registered = "closed_form_mechanism:ClosedFormMechanism"
    monkeypatch.setitem(mechanisms._REGISTRY, "closed-form", registered)
    return closed_form_mechanism.write(tmp_path / "closed_form.h5", resolution=12)


@pytest.fixture
def opened(file: Path) -> Iterator[Atlas]:
    with open_atlas(file) as atlas:
        yield atlas


@pytest.mark.parametrize(
    ("command", "start", "listed"),
    [
        (("optimum", "--where", "span>=1"), "--where: 'span' is a quantity of toy", PARAMETERS),
        (("optimum", "--where", "b<1"), "--where: 'b' is a parameter of toy", PARAMETERS),
        (
            ("optimum", "--where", "span_error<1"),
            "--where: 'span_error' is a quantity of toy",
            "gci_error",  # the nearest
        ),
        (("optimum", "--maximise", "gci,span"), "--maximise: 'span' is a quantity", PARAMETERS),
        (("optimum", "--pareto", "gci,-span"), "--pareto: 'span' is a quantity", PARAMETERS),
        (
            ("plot", "quantity", "span", "-o", "a.pdf"),
            "quantity: 'span' is a quantity",
            "sub_region",
        ),
        (("plot", "region", "--where", "a>1", "-o", "a.pdf"), "--where: 'a' is a parameter", "r1"),
        (("plot", "pareto", "--pareto", "gci,a", "-o", "a.pdf"), "--pareto: 'a' is", "r1"),
        (
            ("plot", "gci", "--mode", "left", "-o", "a.pdf"),
            "mode: 'left' is a mode pair of toy",
            "+-/up, +-/down",
        ),
    ],
)
def test_commands_name_both_mechanisms(
    file: Path, refused: Callable[..., str], command: tuple[str, ...], start: str, listed: str
) -> None:
    line = refused(*command, file)
    assert line.startswith(start)
    assert f" of toy; this file is of closed-form, which has {listed}" in line
    assert not Path("a.pdf").exists()


def test_python_names_both_mechanisms(opened: Atlas) -> None:
    for ask in (
        lambda: opened["span"],
        lambda: opened.select("span"),
        lambda: opened.quantity("span"),
    ):
        with pytest.raises(
            ForeignNameError, match=r"^quantity: 'span' is a quantity of toy; "
        ) as e:
            ask()
        assert (e.value.owners, e.value.own) == (["toy"], "closed-form")
        assert "gci" in e.value.known


def test_names_of_no_mechanism_are_unknown_as_ever(opened: Atlas) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'gci'") as caught:
        opened.select("gic")
    assert not isinstance(caught.value, ForeignNameError)


def test_a_name_of_several_mechanisms_names_them_all(
    toy_settings: SweepSettings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    registered = "closed_form_mechanism:ClosedFormMechanism"
    monkeypatch.setitem(mechanisms._REGISTRY, "closed-form", registered)
    toy = mechanisms.get("toy")
    designs = toy.lattice("whole", 200)
    path = tmp_path / "toy.h5"
    with AtlasWriter(path, toy_settings, designs, [(0, len(designs))]) as writer:
        writer.add(0, toy.evaluate(designs, toy_settings))
        writer.assemble()
    with open_atlas(path) as opened:
        with pytest.raises(ForeignNameError) as caught:
            opened.select("max_lci")
        assert str(caught.value).startswith(
            "quantity: 'max_lci' is a quantity of five-bar, passive-leg, "
        )
        assert "closed-form; this file is of toy, which has a, b, span" in str(caught.value)
        with pytest.raises(
            ForeignNameError, match="is a mode pair of five-bar, passive-leg, closed-form; "
        ):
            opened.mode_index("pm/up")
    renamed = caught.value.renamed("--where", "max_lci")
    assert str(renamed) == str(caught.value).replace("quantity: ", "--where: ", 1)
