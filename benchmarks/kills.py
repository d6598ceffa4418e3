"""Kill a sweep at random moments, go on with it, and compare the files: ``python kills.py 100``.

Each time a sweep is started, killed (SIGKILL, as the power or a scheduler's time limit would) at a
moment drawn evenly over the time that it takes, and completed with ``--resume``; its data must then
be those of a sweep that nobody disturbed, bit for bit. Before the second run the name of the
result must be free, or hold a whole file.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py

_SWEEP = ("--resolution", "100", "--tolerance", "1e-5", "--mode", "all", "--lci", "0.5")


def command(output: Path, *more: str) -> list[str]:
    """Return the command line of a sweep."""
    program = "from fivebar_atlas.cli import main; main()"
    return [sys.executable, "-c", program, "sweep", *_SWEEP, "-o", str(output), *more]


def data(path: Path) -> dict[str, bytes]:
    """Return the bytes of all datasets."""
    with h5py.File(path) as file:
        return {name: file[name][...].tobytes() for name in file}


def kill_once(output: Path, after: float) -> bool:
    """Kill a sweep after so many seconds; return whether it was still at work."""
    with subprocess.Popen(
        command(output), stderr=subprocess.DEVNULL, start_new_session=True
    ) as run:
        try:
            run.wait(after)
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)
            return True
    return False


def main() -> None:
    """Run the kills and print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=100)
    parser.add_argument("--seed", type=int, default=0)
    choice = parser.parse_args()
    moments = random.Random(choice.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run(command(folder / "warm.h5"), check=True, stderr=subprocess.DEVNULL)
        began = time.monotonic()
        subprocess.run(command(folder / "whole.h5"), check=True, stderr=subprocess.DEVNULL)
        duration = time.monotonic() - began
        expected = data(folder / "whole.h5")
        killed = resumed = same = 0
        for number in range(choice.count):
            output = folder / f"{number}.h5"
            at_work = kill_once(output, moments.uniform(0.0, duration))
            killed += at_work
            if output.exists() and data(output) != expected:
                raise SystemExit(f"kill {number}: a damaged file has the final name")
            resumed += output.with_name(f"{output.name}.partial").exists()
            subprocess.run(command(output, "--resume"), check=True, stderr=subprocess.DEVNULL)
            same += data(output) == expected
            left = [path.name for path in folder.glob(f"*{number}.h5?*")]
            if left:
                raise SystemExit(f"kill {number}: {', '.join(left)} is left")
            output.unlink()
    print(f"{choice.count} sweeps of {duration:.1f} s, {killed} killed at work")
    print(f"{resumed} had begun to compute; {same} complete and bit-identical after --resume")
    if same != choice.count:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
