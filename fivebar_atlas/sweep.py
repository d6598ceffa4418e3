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
from fivebar_atlas.executors import Executor
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.quantities import ResultArray
from fivebar_atlas.mechanisms.settings import SweepSettings

# A sweep has about this many blocks, for smooth progress, as long as a block is neither so
# small that handling it costs more than computing it, nor so large that an interruption
# loses much work.
_BLOCKS = 128
_FEWEST_DESIGNS = 16
_MOST_DESIGNS = 1024


@dataclasses.dataclass(frozen=True, slots=True)
class Block:
    """A run of consecutive designs of the lattice.

    Attributes
    ----------
    index
        Number of the block, from 0.
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

    Attributes
    ----------
    settings
        What to compute.
    mechanism
        The mechanism.
    designs
        Every design of the lattice, shape (designs, parameters).
    blocks
        The blocks, in the order of the designs.
    """

    def __init__(self, settings: SweepSettings) -> None:
        self.settings = settings
        self.mechanism: Mechanism = mechanisms.get(settings.mechanism)
        self.designs: FloatArray = self.mechanism.lattice(settings.space, settings.resolution)
        count = len(self.designs)
        size = min(max(-(-count // _BLOCKS), _FEWEST_DESIGNS), _MOST_DESIGNS)
        self.blocks = tuple(
            Block(index, start, min(start + size, count))
            for index, start in enumerate(range(0, count, size))
        )

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
        ValueError
            If the mechanism does not return what it declares.
        """
        declared = self.mechanism.result_arrays(self.settings)
        evaluate = functools.partial(self._evaluate, declared=declared)
        remaining = (block for block in self.blocks if block.index not in finished)
        for block, arrays in executor.run(evaluate, remaining):
            yield BlockResults(block, arrays)

    def _evaluate(
        self, block: Block, declared: tuple[ResultArray, ...]
    ) -> dict[str, npt.NDArray[Any]]:
        """Return the results of a block, in the types and shapes declared."""
        designs = self.designs[block.start : block.stop]
        results = self.mechanism.evaluate(designs, self.settings)
        arrays: dict[str, npt.NDArray[Any]] = {}
        for array in declared:
            if array.name not in results:
                raise ValueError(f"{self.mechanism.name} returned no {array.name!r}")
            values = results[array.name]
            shape = (len(designs), *array.lengths)
            if values.shape != shape:
                raise ValueError(
                    f"{self.mechanism.name} returned {array.name!r} of shape {values.shape}; "
                    f"declared is {shape}"
                )
            arrays[array.name] = values.astype(array.dtype, casting="same_kind", copy=False)
        return arrays
