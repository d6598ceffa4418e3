"""Sweeps: blocks cover the lattice, results do not depend on threads, faults are noticed."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from toy_mechanism import ToyMechanism

from fivebar_atlas import sweep
from fivebar_atlas.errors import LostBlocksError
from fivebar_atlas.executors import LostTasksError, ThreadExecutor
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.sweep import Sweep

Arrays = dict[str, npt.NDArray[Any]]


def collect(settings: SweepSettings, threads: int) -> Arrays:
    """Run a sweep and put its blocks together in the order of the designs."""
    work = Sweep(settings)
    blocks = {results.block.index: results.arrays for results in work.run(ThreadExecutor(threads))}
    assert sorted(blocks) == [block.index for block in work.blocks]
    return {
        name: np.concatenate([blocks[index][name] for index in sorted(blocks)])
        for name in blocks[0]
    }


@pytest.mark.parametrize("resolution", [2, 10, 1000, 5000, 100_000])
def test_blocks_cover_the_lattice_without_gap(toy: str, resolution: int) -> None:
    work = Sweep(SweepSettings(toy, "whole", resolution, ("left",), (), 1e-6))
    assert work.blocks[0].start == 0
    assert work.blocks[-1].stop == len(work.designs) == resolution + 1
    for number, (before, after) in enumerate(zip(work.blocks[:-1], work.blocks[1:], strict=True)):
        assert before.stop == after.start
        assert (before.index, after.index) == (number, number + 1)
    assert max(block.stop - block.start for block in work.blocks) <= 1024


def test_results_are_those_of_the_mechanism(toy_settings: SweepSettings) -> None:
    toy = ToyMechanism()
    expected = toy.evaluate(toy.lattice("whole", 200), toy_settings)
    results = collect(toy_settings, 2)
    assert set(results) == set(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(results[name], values)


def test_finished_blocks_are_left_out(toy_settings: SweepSettings) -> None:
    work = Sweep(toy_settings)
    finished = {0, 3, 4}
    run = [results.block.index for results in work.run(ThreadExecutor(2), finished)]
    assert sorted([*run, *finished]) == [block.index for block in work.blocks]


def test_integers_are_stored_in_the_declared_type(toy_settings: SweepSettings) -> None:
    assert collect(toy_settings, 1)["status"].dtype == np.int16


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda results: results.pop("share_error"), "no 'share_error'"),
        (lambda results: results.update(span=results["share"]), "'span' of shape"),
    ],
)
def test_a_mechanism_that_breaks_its_word_is_noticed(
    toy_settings: SweepSettings,
    monkeypatch: pytest.MonkeyPatch,
    change: Any,
    message: str,
) -> None:
    honest = ToyMechanism.evaluate

    def broken(self: ToyMechanism, parameters: FloatArray, settings: SweepSettings) -> Arrays:
        results = honest(self, parameters, settings)
        change(results)
        return results

    monkeypatch.setattr(ToyMechanism, "evaluate", broken)
    with pytest.raises(LostBlocksError, match=f"failed: ValueError: .*{message}"):
        list(Sweep(toy_settings).run(ThreadExecutor(1)))


@pytest.mark.slow
@pytest.mark.parametrize("space", ["surrounded", "assemblable"])
def test_five_bar_results_do_not_depend_on_threads_bit_for_bit(space: str) -> None:
    settings = SweepSettings("five-bar", space, 24, ("+-/up", "++/up", "--/down"), (0.3, 0.5), 1e-4)
    alone, together = collect(settings, 1), collect(settings, 3)
    for name, values in alone.items():
        assert values.tobytes() == together[name].tobytes(), name


@pytest.mark.slow
def test_five_bar_results_do_not_depend_on_the_other_modes_asked_for() -> None:
    settings = SweepSettings("five-bar", "surrounded", 12, ("+-/up",), (0.5,), 1e-4)
    every = dataclasses.replace(settings, modes=("++/down", "-+/down", "+-/up"))
    one, all_of_them = collect(settings, 2), collect(every, 2)
    for name, values in one.items():
        others = all_of_them[name]
        same = others if others.shape == values.shape else others[:, 2:3]
        assert values.tobytes() == same.tobytes(), name


@pytest.mark.parametrize("size", [1, 7, 1024])
def test_numbers_do_not_depend_on_the_size_of_blocks(
    monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    settings = SweepSettings("five-bar", "surrounded", 12, ("+-/up", "++/up"), (0.5,), 1e-4)
    expected = collect(settings, 2)
    monkeypatch.setattr(sweep, "_FEWEST_DESIGNS", size)
    monkeypatch.setattr(sweep, "_MOST_DESIGNS", size)
    found = collect(settings, 2)
    for name, values in expected.items():
        assert found[name].tobytes() == values.tobytes(), name


def test_blocks_that_cannot_be_computed_are_named_with_their_designs(toy: str) -> None:
    class Deadly(ThreadExecutor):
        """Everything but the second task comes back."""

        def run(self, function: Any, tasks: Any) -> Any:
            lost = []
            for number, task in enumerate(tasks):
                if number == 1:
                    lost.append(task)
                else:
                    yield task, function(task)
            raise LostTasksError(lost, "ended every worker that tried them")

    work = Sweep(SweepSettings(toy, "whole", 100, ("left",), (), 1e-6))
    found = []
    with pytest.raises(LostBlocksError) as caught:  # noqa: PT012
        for results in work.run(Deadly()):
            found.append(results.block.index)  # noqa: PERF401
    assert found == [0, *range(2, len(work.blocks))]
    block = work.blocks[1]
    assert str(caught.value) == (
        f"designs {block.start} to {block.stop - 1} "
        "(from a = 0.16, b = 0.84 to a = 0.31, b = 0.69)"
        " ended every worker that tried them"
    )


def failing_from(first: float, everywhere: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the toy mechanism fail in the block that begins with a design, or in all."""
    honest = ToyMechanism.evaluate

    def failing(self: ToyMechanism, parameters: FloatArray, settings: SweepSettings) -> Arrays:
        if everywhere or parameters[0, 0] == first:
            raise OSError(28, "No space left on device")
        return honest(self, parameters, settings)

    monkeypatch.setattr(ToyMechanism, "evaluate", failing)


def test_a_block_that_fails_is_named_and_the_others_are_computed(
    toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    work = Sweep(toy_settings)
    block = work.blocks[0]
    failing_from(work.designs[block.start][0], False, monkeypatch)
    found = []
    message = (
        rf"^designs 0 to {block.stop - 1} \(from a = 0, b = 1 to .*\) failed: "
        r"OSError: \[Errno 28\] No space left on device \(test_sweep.py, line \d+\)$"
    )
    with pytest.raises(LostBlocksError, match=message):  # noqa: PT012
        for results in work.run(ThreadExecutor(2)):
            found.append(results.block.index)  # noqa: PERF401
    assert sorted(found) == list(range(1, len(work.blocks)))


def test_a_sweep_of_which_every_block_fails_ends_early(
    toy_settings: SweepSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing_from(0.0, True, monkeypatch)
    settings = dataclasses.replace(toy_settings, resolution=10_000)
    with pytest.raises(LostBlocksError, match=r"and 3 blocks more$"):
        list(Sweep(settings).run(ThreadExecutor(1)))
