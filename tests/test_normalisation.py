"""Products of quantities normalised over an atlas: their values, errors and extremes, stored.

The expected values are computed here in NumPy from what the evaluator returns.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import closed_form_atlas
import h5py
import numpy as np
import numpy.typing as npt
import pytest
import xarray
from conftest import Command
from test_store import write
from toy_mechanism import ToyMechanism

from fivebar_atlas import mechanisms, open_atlas, store
from fivebar_atlas.errors import FileError, UnknownNameError
from fivebar_atlas.mechanisms.normalisation import Extremes, NormalisedFunction
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import Atlas, assembly, guarded_file

FloatArray = npt.NDArray[np.float64]
TOY = ToyMechanism()


def by_range(values: FloatArray) -> FloatArray:
    """Normalise along the designs: (f - min f)/(max f - min f)."""
    least, greatest = np.nanmin(values, axis=0), np.nanmax(values, axis=0)
    return np.asarray((values - least) / (greatest - least))


@pytest.fixture
def output(tmp_path: Path, toy_settings: SweepSettings) -> Path:
    return write(tmp_path / "toy.h5", toy_settings)


@pytest.fixture
def results(toy_settings: SweepSettings) -> dict[str, Any]:
    return TOY.evaluate(TOY.lattice("whole", 200), toy_settings)


@pytest.mark.parametrize("name", [*mechanisms.names(), "toy"])
def test_declarations_fit_the_factors(toy: str, name: str) -> None:  # noqa: ARG001
    """Axes and errors of products are those of their factors, and names are not used twice."""
    mechanism = mechanisms.get(name)
    evaluated = {quantity.name: quantity for quantity in mechanism.quantities}
    for product in mechanism.normalised:
        factors = [evaluated[factor] for factor in product.factors]
        assert all(factor.flags is None for factor in factors)
        dimensions = {name for factor in factors for name in factor.dimensions}
        assert set(product.quantity.dimensions) == dimensions
        assert product.quantity.has_error == all(factor.has_error for factor in factors)
        assert product.quantity.length_power == 0
    names = [quantity.name for quantity in mechanism.stored_quantities]
    assert len(set(names)) == len(names)


def test_file_holds_the_normalised_values(output: Path, results: dict[str, Any]) -> None:
    span, share = by_range(results["span"]), by_range(results["share"])
    with open_atlas(output) as opened:
        assert {"normalised_span", "composed", "composed_error", "relative"} <= set(opened.names)
        np.testing.assert_allclose(opened["normalised_span"], span, rtol=1e-14)
        assert (opened["normalised_span"].min(), opened["normalised_span"].max()) == (0.0, 1.0)
        composed = span[:, None, None] * share
        assert np.isnan(composed[0]).all()
        np.testing.assert_allclose(opened["composed"], composed, rtol=1e-13, atol=1e-16)
        # of the second mode pair, the first has no value above zero to be divided by
        left = results["sweep_area"][:, 1]
        relative = results["span"] / results["span"].max() * left / np.nanmax(left)
        np.testing.assert_allclose(opened.select("relative", "left"), relative, rtol=1e-14)
        assert np.isnan(opened.select("relative", "right")).all()
        np.testing.assert_array_equal(
            opened.select("composed", "left", 0.5), opened["composed"][:, 1, 1]
        )


def test_file_says_how_it_is_normalised(output: Path, results: dict[str, Any]) -> None:
    with h5py.File(output) as file:
        attributes = dict(file["composed"].attrs)
        relative = dict(file["relative"].attrs)
    assert attributes["normalisation"] == "range"
    assert attributes["factors"] == "span share"
    assert attributes["ancillary_variables"] == "composed_error"
    assert attributes["span_least"] == [results["span"].min()]
    assert attributes["span_greatest"] == [1.0]
    share = results["share"]
    np.testing.assert_array_equal(attributes["share_least"], np.nanmin(share, axis=0).ravel())
    np.testing.assert_array_equal(attributes["share_greatest"], np.nanmax(share, axis=0).ravel())
    assert (relative["normalisation"], relative["factors"]) == ("largest", "span sweep_area")
    with xarray.open_dataset(output, engine="h5netcdf") as dataset:
        assert dataset["composed"].attrs["share_greatest"].shape == (6,)


def test_many_designs_are_read_back_in_parts(
    output: Path, tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The extremes of parts are those of the whole, to the last bit of what follows."""
    monkeypatch.setattr(assembly, "_SLAB_DESIGNS", 7)
    parts = write(tmp_path / "parts.h5", toy_settings)
    with open_atlas(output) as one, open_atlas(parts) as other:
        for name in one.names:
            assert one[name].tobytes() == other[name].tobytes()


def test_blocks_hold_no_normalised_values(
    tmp_path: Path, toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An interrupted sweep goes on as before: nothing is normalised until all is there."""
    output, reference = tmp_path / "toy.h5", write(tmp_path / "reference.h5", toy_settings)
    monkeypatch.setattr(store.AtlasWriter, "assemble", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write(output, toy_settings)
    monkeypatch.undo()
    monkeypatch.setitem(mechanisms._REGISTRY, "toy", "toy_mechanism:ToyMechanism")
    write(output, toy_settings, resume=True)
    with open_atlas(output) as one, open_atlas(reference) as other:
        for name in one.names:
            assert one[name].tobytes() == other[name].tobytes()


def interrupt(writer: Any) -> None:
    assert writer.finished
    raise KeyboardInterrupt


def function_of(values: dict[str, FloatArray], normalisation: str) -> NormalisedFunction:
    """Return the composed index of the toy with the extremes of these values."""
    product = next(each for each in TOY.normalised if each.quantity.name == "composed")
    product = type(product)(product.quantity, product.factors, normalisation)  # type: ignore[arg-type]
    factors = tuple(TOY.quantity(name) for name in product.factors)
    extremes = tuple(
        Extremes.of_parts([(values[name], values[f"{name}_error"])]) for name in product.factors
    )
    return NormalisedFunction(product, factors, extremes)


@pytest.mark.parametrize("normalisation", ["range", "largest"])
@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.05])
def test_errors_bound_what_errors_of_the_factors_do(normalisation: str, size: float) -> None:
    """Whatever the true factors are within their errors, the true product is within its."""
    rng = np.random.default_rng(3)
    span, share = rng.uniform(1.0, 2.0, 12), rng.uniform(1.0, 2.0, (12, 2, 3))
    share[3, 1] = np.nan
    values = {
        "span": span,
        "span_error": size * rng.uniform(0.0, 1.0, span.shape),
        "share": share,
        "share_error": size * rng.uniform(0.0, 1.0, share.shape),
    }
    computed = function_of(values, normalisation).arrays(values)
    normalised = by_range if normalisation == "range" else lambda f: f / np.nanmax(f, axis=0)
    largest = 0.0
    for _ in range(2000):
        true = {}
        for name in ("span", "share"):
            # mostly at the ends of the intervals, where the product is furthest off
            shares = np.sign(rng.normal(size=values[name].shape))
            true[name] = values[name] + shares * values[f"{name}_error"]
        product = normalised(true["span"])[:, None, None] * normalised(true["share"])
        share_of_error = np.abs(product - computed["composed"]) / computed["composed_error"]
        largest = max(largest, np.nanmax(share_of_error))
    assert 0.4 < largest <= 1.0 + 1e-5


def test_what_is_the_same_everywhere_cannot_be_normalised_by_its_range() -> None:
    values = {
        "span": np.array([1.0, 2.0, 3.0]),
        "span_error": np.zeros(3),
        "share": np.array([0.5, 0.5 + 1e-9, 0.5])[:, None, None] * np.ones((3, 2, 3)),
        "share_error": np.full((3, 2, 3), 1e-8),
    }
    values["share"][:, 1, 2] = [0.0, 0.5, 1.0]
    computed = function_of(values, "range").arrays(values)
    exists = np.zeros((3, 2, 3), dtype=np.bool_)
    exists[:, 1, 2] = True
    np.testing.assert_array_equal(np.isfinite(computed["composed"]), exists)
    np.testing.assert_array_equal(np.isfinite(computed["composed_error"]), exists)
    assert computed["composed"][:, 1, 2].tolist() == [0.0, 0.25, 1.0]


def test_infinite_values_are_no_extremes() -> None:
    values = np.array([np.inf, 2.0, np.nan, 5.0, -np.inf])
    extremes = Extremes.of_parts([(values[:2], np.zeros(2)), (values[2:], np.zeros(3))])
    assert [each.item() for each in extremes] == [2.0, 5.0, 0.0, 0.0]


# In the closed form


def composed(designs: FloatArray, atlas: Atlas) -> FloatArray:
    """Return the composed index of designs with the extremes over an atlas."""
    value = np.ones(len(designs))
    for factor in (closed_form_atlas.area, closed_form_atlas.conditioning):
        stored = factor(atlas.designs)
        value *= (factor(designs) - stored.min()) / (stored.max() - stored.min())
    return value


def test_between_designs_the_extremes_are_those_of_the_file(
    closed_form: Atlas, atlas: Command
) -> None:
    outcome = atlas("lookup", 1.234, 1.5, 0.266, closed_form.path, "--json")
    entries = {each["quantity"]: each for each in json.loads(outcome.out)["values"]}
    entry = entries["composed_index"]
    expected = composed(np.array([[1.234, 1.5, 0.266]]), closed_form)[0]
    assert entry["exact"] == pytest.approx(expected, rel=1e-12)
    assert entry["interpolated"] == pytest.approx(expected, abs=1e-3)
    assert 1e-7 < entry["error"] < 1e-5


def test_the_best_composed_index_is_found_between_designs(
    closed_form: Atlas, atlas: Command
) -> None:
    outcome = atlas("optimum", closed_form.path, "--maximise", "composed_index", "--json")
    assert outcome.code == 0, outcome.err
    maximum = json.loads(outcome.out)["maximum"]
    r1 = np.linspace(0.5, 2.5, 200_001)
    along_axis = np.column_stack([r1, 3.0 - r1, np.zeros_like(r1)])
    assert maximum["value"] == pytest.approx(composed(along_axis, closed_form).max(), abs=1e-9)
    best = along_axis[composed(along_axis, closed_form).argmax()]
    assert list(maximum["design"].values()) == pytest.approx(best, abs=1e-4)


def test_conditions_and_fronts_may_use_it(closed_form: Atlas, atlas: Command) -> None:
    outcome = atlas(
        *("optimum", closed_form.path, "--where", "composed_index>=0.8"),
        *("--pareto", "composed_index,max_lci", "--refine", "--json"),
    )
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    expected = composed(closed_form.designs, closed_form)
    assert document["lattice_designs"] == np.count_nonzero(expected >= 0.8) > 10
    # the region is refined with exact values between the designs
    corners = np.random.default_rng(5).dirichlet((1.0, 1.0, 1.0), 400_000)
    designs = corners @ np.array([[3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [1.0, 1.0, 1.0]])
    share = np.mean(composed(designs, closed_form) >= 0.8)
    assert document["refined"]["share"] == pytest.approx(share, rel=0.02)
    for member in document["pareto"]["members"]:
        design = np.array([list(member["design"].values())])
        assert member["values"]["composed_index"] == pytest.approx(composed(design, closed_form)[0])


def test_everything_that_reads_an_atlas_knows_it(
    closed_form: Atlas, atlas: Command, tmp_path: Path
) -> None:
    info = json.loads(atlas("info", closed_form.path, "--json").out)
    (entry,) = [each for each in info["quantities"] if each["name"] == "composed_index"]
    values = composed(closed_form.designs, closed_form)
    assert entry["greatest"] == pytest.approx(values.max())
    assert entry["normalisation"] == "range"
    assert entry["factors"] == ["usable_workspace_area", "gci"]
    table = tmp_path / "table.csv"
    assert atlas("export", closed_form.path, "-o", table).code == 0
    header, first, *_ = table.read_text().splitlines()
    row = dict(zip(header.split(","), first.split(","), strict=True))
    assert float(row["composed_index"]) == pytest.approx(values[0])
    assert float(row["composed_index_error"]) == closed_form["composed_index_error"][0, 0]
    figure = tmp_path / "figure.svg"
    assert atlas("plot", "quantity", "composed_index", closed_form.path, "-o", figure).code == 0
    assert "Composed design index" in figure.read_text()


def test_one_design_alone_has_none(closed_form: Atlas) -> None:
    mechanism = closed_form.mechanism
    design, factor = mechanism.from_lengths((1.2, 1.5, 0.3))
    results = mechanism.evaluate(design[None], closed_form.settings)
    assert "composed_index" not in results
    document = mechanism.document(design, factor, closed_form.settings, results)
    assert "composed_index" not in json.dumps(document)


def test_unknown_and_damaged_products_are_refused(output: Path) -> None:
    with (
        open_atlas(output) as opened,
        pytest.raises(UnknownNameError, match="normalised_span, composed, relative"),
    ):
        opened.normalised("span")
    with h5py.File(output, "a") as file:
        file["composed"].attrs["share_least"] = np.zeros(5)
        del file["relative"].attrs["span_greatest"]
    with open_atlas(output) as opened:
        for name in ("composed", "relative"):
            with pytest.raises(FileError, match="is damaged"):
                opened.normalised(name)


@pytest.mark.parametrize("share", [0.5, 0.6, 0.7, 0.8, 0.9])
def test_disk_that_fills_up_while_products_are_written(
    output: Path,
    toy_settings: SweepSettings,
    monkeypatch: pytest.MonkeyPatch,
    share: float,
) -> None:
    """What was never written is not read back."""
    honest, size = guarded_file.GuardedFile.write, output.stat().st_size

    def failing(file: Any, data: Any) -> int:
        if file.tell() > share * size and file._fault is None:
            file._fault = OSError(28, "as if")
        return honest(file, data)

    monkeypatch.setattr(guarded_file.GuardedFile, "write", failing)
    monkeypatch.setattr(assembly, "_SLAB_DESIGNS", 20)
    with pytest.raises(FileError, match="no space left on the disk; all finished blocks are kept"):
        write(output, toy_settings, overwrite=True)


def test_no_threshold_leaves_nothing_to_normalise(toy: str, tmp_path: Path) -> None:
    settings = SweepSettings(toy, "whole", 40, ("left",), (), 1e-6)
    with open_atlas(write(tmp_path / "none.h5", settings)) as opened:
        assert opened["composed"].shape == (41, 1, 0)
        assert opened.normalised("composed").extremes[1].least.shape == (1, 0)
        assert math.isclose(opened["normalised_span"].max(), 1.0)
