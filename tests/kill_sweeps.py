"""Kills sweeps of the toy at random moments and resumes them: ``kill_sweeps.py FOLDER N``.

Sweeps are forks of this process, which has loaded everything: only so do a hundred take seconds.
Prints, as JSON, how many were killed at work, how many had kept blocks, how many had their result
already, and how many were complete and the same, byte for byte of data, after ``--resume``.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from pathlib import Path
from typing import Any

import h5py
import numpy.typing as npt
import toy_mechanism

from fivebar_atlas import config, executors, mechanisms, store, sweep  # noqa: F401  loaded once
from fivebar_atlas.cli import main
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.settings import SweepSettings

TOY = ("--mechanism", "toy", "--resolution", "200", "--mode", "all", "--lci", "0.25")
BLOCK_SECONDS = 0.004


class SlowToy(toy_mechanism.ToyMechanism):
    """The toy mechanism, with blocks that take a while."""

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Evaluate a block, slowly."""
        time.sleep(BLOCK_SECONDS)
        return super().evaluate(parameters, settings)


def start(output: Path, *more: str) -> int:
    """Start a sweep in a fork; return its process number."""
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        main(
            ["sweep", *TOY, "--threads", "2", "--quiet", "-o", str(output), *more],
            standalone_mode=False,
        )
        code = 0
    finally:
        os._exit(code)


def finish(child: int) -> None:
    """Wait for a sweep that must succeed."""
    _, status = os.waitpid(child, 0)
    if status != 0:
        raise SystemExit(f"a sweep ended with status {status}")


def data(path: Path) -> dict[str, bytes]:
    """Return the bytes of all datasets."""
    with h5py.File(path) as file:
        return {name: file[name][...].tobytes() for name in file}


def kill_and_resume(folder: Path, count: int) -> dict[str, int]:
    """Do it so many times; count what happened."""
    mechanisms._REGISTRY["toy"] = "kill_sweeps:SlowToy"
    began = time.monotonic()
    finish(start(folder / "whole.h5"))
    duration = time.monotonic() - began
    expected = data(folder / "whole.h5")
    moments = random.Random(0)
    found = {"killed": 0, "kept_blocks": 0, "had_result": 0, "same": 0}
    for number in range(count):
        output = folder / f"{number}.h5"
        child = start(output)
        time.sleep(moments.uniform(0.0, 1.1 * duration))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        found["killed"] += os.WIFSIGNALED(status)
        found["kept_blocks"] += any(folder.glob(f"{output.name}.partial/block-??????"))
        if output.exists():  # the name is given to whole files only
            found["had_result"] += 1
            if data(output) != expected:
                raise SystemExit(f"kill {number}: a damaged file has the final name")
        finish(start(output, "--resume"))
        found["same"] += data(output) == expected
        output.unlink()
    left = [path.name for path in folder.iterdir() if path.name != "whole.h5"]
    if left:
        raise SystemExit(f"left: {', '.join(left)}")
    return found


if __name__ == "__main__":
    print(json.dumps(kill_and_resume(Path(sys.argv[1]), int(sys.argv[2]))))
