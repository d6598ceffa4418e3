"""A sweep: a design space cut into blocks, the blocks evaluated, their results yielded.

Knows no file and no terminal. Which designs make up a block depends on the settings
alone, so a sweep can be interrupted and go on with the blocks that are missing.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Container, Iterator
from typing import Any

import numpy.typing as npt

from fivebar_atlas import mechanisms
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

# So many blocks are named where some could not be computed.
_SHOWN = 5


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
        if len(parts) == 2 and all(part.isascii() and part.isdecimal() for part in parts):
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
    """What was computed for a block: one array for each quantity and error companion."""

    block: Block
    arrays: dict[str, npt.NDArray[Any]]


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

    def run(self, executor: Executor, finished: Container[int] = ()) -> Iterator[BlockResults]:
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
            After all other blocks, if some ended every process they were computed in.
        ValueError
            If the mechanism does not return what it declares.
        """
        evaluate = functools.partial(_evaluate, self.settings)
        remaining = (
            _Work(block, self.designs[block.start : block.stop])
            for block in self.blocks
            if block.index not in finished
        )
        try:
            for work, arrays in executor.run(evaluate, remaining):
                yield BlockResults(work.block, arrays)
        except LostTasksError as error:
            raise LostBlocksError(self._lost(error)) from None

    def _lost(self, error: LostTasksError) -> str:
        """Return which blocks could not be computed, and why."""
        names = [parameter.name for parameter in self.mechanism.parameters]
        shown = []
        for work in error.tasks[:_SHOWN]:
            first, last = (
                ", ".join(f"{n} = {v:g}" for n, v in zip(names, work.designs[k], strict=True))
                for k in (0, -1)
            )
            block = work.block
            shown.append(f"designs {block.start} to {block.stop - 1} (from {first} to {last})")
        more = len(error.tasks) - len(shown)
        rest = f" and {more} blocks more" if more else ""
        return f"{'; '.join(shown)}{rest}: {error.reason}; everything else is finished and kept"


@dataclasses.dataclass(frozen=True, eq=False)
class _Work:
    """A block with its designs, shape (designs, parameters): all that computing it needs."""

    block: Block
    designs: FloatArray


def _evaluate(settings: SweepSettings, work: _Work) -> dict[str, npt.NDArray[Any]]:
    """Return the results of a block, in the types and shapes declared."""
    mechanism = mechanisms.get(settings.mechanism)
    results = mechanism.evaluate(work.designs, settings)
    arrays: dict[str, npt.NDArray[Any]] = {}
    for array in mechanism.result_arrays(settings):
        if array.name not in results:
            raise ValueError(f"{mechanism.name} returned no {array.name!r}")
        values = results[array.name]
        shape = (len(work.designs), *array.lengths)
        if values.shape != shape:
            raise ValueError(
                f"{mechanism.name} returned {array.name!r} of shape {values.shape}; "
                f"declared is {shape}"
            )
        arrays[array.name] = values.astype(array.dtype, casting="same_kind", copy=False)
    return arrays
