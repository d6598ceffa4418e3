"""A sweep: a design space cut into blocks, the blocks evaluated, their results yielded.

Knows no file and no terminal. Which designs make up a block depends on the settings
alone, so a sweep can be interrupted and go on with the blocks that are missing.
"""

from __future__ import annotations

import dataclasses
import functools
import traceback
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy.typing as npt

from fivebar_atlas import jit, mechanisms
from fivebar_atlas.errors import InputError, LostBlocksError
from fivebar_atlas.executors import Executor, LostTasksError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.settings import SweepSettings

# A sweep has about this many blocks, for smooth progress, as long as a block is neither so
# small that handling it costs more than computing it, nor so large that an interruption
# loses much work.
_BLOCKS = 128
_FEWEST_DESIGNS = 16
_MOST_DESIGNS = 1024

# No sweep has more parts than that many digits can say.
_MOST_DIGITS = 9

# So many blocks are named where some could not be computed; and so many failures without a
# single block that can be computed end the sweep.
_SHOWN, _MOST_FAILURES = 5, 8


@dataclasses.dataclass(frozen=True, slots=True)
class Shard:
    """One of several parts of a sweep, for machines that know nothing of each other.

    Attributes
    ----------
    number
        Which part it is, from 1.
    count
        How many parts there are.
    """

    number: int
    count: int

    @classmethod
    def parse(cls, text: str, name: str = "shard") -> Shard:
        """Return the shard that a text such as ``"2/3"`` stands for.

        Raises
        ------
        InputError
            Under this name, if it stands for none.
        """
        parts = [part.strip() for part in text.split("/")]
        if len(parts) == 2 and all(
            part.isascii() and part.isdecimal() and len(part) <= _MOST_DIGITS for part in parts
        ):
            number, count = map(int, parts)
            if 1 <= number <= count:
                return cls(number, count)
        raise InputError(name, text, "i/n, the i-th of n parts, with i from 1 to n: 2/3")

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


@dataclasses.dataclass(frozen=True, slots=True)
class Block:
    """A run of consecutive designs of the lattice.

    Attributes
    ----------
    index
        Number of the block among those of the sweep or its part, from 0.
    start, stop
        Its designs, as a half-open range of lattice indices.
    """

    index: int
    start: int
    stop: int


@dataclasses.dataclass(frozen=True, slots=True)
class BlockResults:
    """What was computed for a block.

    Attributes
    ----------
    block
        The block.
    arrays
        One array for each quantity and error companion.
    processor
        What computed it, see :func:`fivebar_atlas.jit.processor`.
    """

    block: Block
    arrays: dict[str, npt.NDArray[Any]]
    processor: str


class Sweep:
    """All designs of one sweep, and their blocks.

    Parameters
    ----------
    settings
        What to compute; checked settings, as a resolved configuration holds them.
    shard
        Which part of it, if not all. Parts are disjoint and together everything; every n-th
        block is in one, so that designs that take long are spread over them.

    Attributes
    ----------
    settings
        What to compute.
    mechanism
        The mechanism.
    designs
        Every design of the lattice, shape (designs, parameters).
    blocks
        The blocks of the sweep or its part, in the order of the designs.

    Raises
    ------
    InputError
        If there are more shards than blocks.
    """

    def __init__(self, settings: SweepSettings, shard: Shard | None = None) -> None:
        self.settings = settings
        self.mechanism: Mechanism = mechanisms.get(settings.mechanism)
        self.designs: FloatArray = self.mechanism.lattice(settings.space, settings.resolution)
        count = len(self.designs)
        size = min(max(-(-count // _BLOCKS), _FEWEST_DESIGNS), _MOST_DESIGNS)
        starts = range(0, count, size)
        if shard is not None:
            if shard.count > len(starts):
                allowed = f"at most {len(starts)} parts: the sweep has as many blocks of designs"
                raise InputError("shard", str(shard), allowed)
            starts = starts[shard.number - 1 :: shard.count]
        self.blocks = tuple(
            Block(index, start, min(start + size, count)) for index, start in enumerate(starts)
        )

    @property
    def count(self) -> int:
        """Number of designs in the blocks."""
        return sum(block.stop - block.start for block in self.blocks)

    def run(self, executor: Executor, finished: Collection[int] = ()) -> Iterator[BlockResults]:
        """Evaluate blocks and yield each as soon as it is finished, in any order.

        Parameters
        ----------
        executor
            Where the blocks are evaluated.
        finished
            Indices of blocks to leave out.

        Yields
        ------
        BlockResults
            One for each remaining block. The numbers depend on the settings only, neither
            on the executor nor on the order.

        Raises
        ------
        LostBlocksError
            After all other blocks, if some ended every process they were computed in, or
            computing them failed.
        """
        evaluate = functools.partial(_evaluate, self.settings)
        remaining = (
            _Work(block, self.designs[block.start : block.stop])
            for block in self.blocks
            if block.index not in finished
        )
        lost: list[tuple[_Work, str]] = []
        some_are_finished = bool(finished)
        try:
            for work, found in executor.run(evaluate, remaining):
                if isinstance(found, str):
                    lost.append((work, found))
                    if len(lost) >= _MOST_FAILURES and not some_are_finished:
                        break
                    continue
                some_are_finished = True
                yield BlockResults(work.block, *found)
        except LostTasksError as error:
            lost += [(work, error.reason) for work in error.tasks]
        if lost:
            raise LostBlocksError(self._lost(lost))

    def _lost(self, lost: Sequence[tuple[_Work, str]]) -> str:
        """Return which blocks could not be computed, and why."""
        names = [parameter.name for parameter in self.mechanism.parameters]
        shown = []
        for work, reason in lost[:_SHOWN]:
            first, last = (
                ", ".join(f"{n} = {v:g}" for n, v in zip(names, work.designs[k], strict=True))
                for k in (0, -1)
            )
            block = work.block
            shown.append(
                f"designs {block.start} to {block.stop - 1} (from {first} to {last}) {reason}"
            )
        more = len(lost) - len(shown)
        return "; ".join(shown) + (f"; and {more} blocks more" if more else "")


@dataclasses.dataclass(frozen=True, eq=False)
class _Work:
    """A block with its designs, shape (designs, parameters): all that computing it needs."""

    block: Block
    designs: FloatArray


def _evaluate(
    settings: SweepSettings, work: _Work
) -> tuple[dict[str, npt.NDArray[Any]], str] | str:
    """Return the results of a block and what computed them, or why there are none."""
    try:
        return _results(settings, work.designs), jit.processor()
    except Exception as error:
        # Whatever it is, the other blocks are to be computed and kept.
        *_, frame = traceback.extract_tb(error.__traceback__)
        said = " ".join(f"{type(error).__name__}: {error}".split()).rstrip(": ")
        return f"failed: {said} ({Path(frame.filename).name}, line {frame.lineno})"


def _results(settings: SweepSettings, designs: FloatArray) -> dict[str, npt.NDArray[Any]]:
    """Return the results of designs, in the types and shapes declared."""
    mechanism = mechanisms.get(settings.mechanism)
    results = mechanism.evaluate(designs, settings)
    arrays: dict[str, npt.NDArray[Any]] = {}
    for array in mechanism.result_arrays(settings):
        if array.name not in results:
            raise ValueError(f"{mechanism.name} returned no {array.name!r}")
        values = results[array.name]
        shape = (len(designs), *array.lengths)
        if values.shape != shape:
            raise ValueError(
                f"{mechanism.name} returned {array.name!r} of shape {values.shape}; "
                f"declared is {shape}"
            )
        arrays[array.name] = values.astype(array.dtype, casting="same_kind", copy=False)
    return arrays
