"""How time and memory of a sweep grow, what writing costs, and what a cluster adds.

Run ``python benchmarks/scaling.py`` (about 15 minutes; ``--largest 1000`` for less). Sweeps run as
users run them, each in a process of its own; times are of whole processes, kernels compiled.
"""

from __future__ import annotations

import argparse
import functools
import os
import sys
import tempfile
import time
from pathlib import Path

from fivebar_atlas.dask_executor import DaskExecutor
from fivebar_atlas.executors import ThreadExecutor, usable_cores
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import AtlasWriter
from fivebar_atlas.sweep import Sweep
from fivebar_atlas.versions import computing_versions

RESOLUTIONS = (100, 300, 600, 1000, 2000, 3000)
PROGRAM = "from fivebar_atlas.cli import main; main()"


def settings_of(resolution: int) -> SweepSettings:
    """Return the standard atlas at a resolution: "+-"/up, LCI 0.5, tolerance 1e-6."""
    return SweepSettings("five-bar", "surrounded", resolution, ("+-/up",), (0.5,), 1e-6)


def run_sweep(output: Path, resolution: int) -> tuple[float, float, float]:
    """Run a sweep as a process; return seconds, seconds of CPU, and the most memory in MB."""
    arguments = ["sweep", "--resolution", str(resolution), "-o", str(output), "--quiet"]
    began = time.monotonic()
    child = os.posix_spawn(
        sys.executable, [sys.executable, "-c", PROGRAM, *arguments], dict(os.environ)
    )
    _, status, used = os.wait4(child, 0)
    if status != 0:
        raise SystemExit(f"the sweep at N = {resolution} failed")
    # Linux counts in kB
    return time.monotonic() - began, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def growth(folder: Path, largest: int) -> None:
    """Print time, memory and size of the file for growing resolutions."""
    print(f"{'N':>6}{'designs':>12}{'time':>10}{'CPU':>10}{'memory':>12}{'file':>12}")
    run_sweep(folder / "warm.h5", 20)
    for resolution in (each for each in RESOLUTIONS if each <= largest):
        output = folder / f"{resolution}.h5"
        seconds, cpu, memory = run_sweep(output, resolution)
        designs = len(Sweep(settings_of(resolution)).designs)
        size = output.stat().st_size / 1e6
        print(
            f"{resolution:>6}{designs:>12,}{seconds:>8.1f} s{cpu:>8.1f} s{memory:>9.0f} MB"
            f"{size:>9.1f} MB",
            flush=True,
        )
        output.unlink()


def writing(folder: Path, resolution: int) -> None:
    """Print what writing takes of a sweep: blocks, checksums, compression, the file."""
    work = Sweep(settings_of(resolution))
    ranges = [(block.start, block.stop) for block in work.blocks]
    list(Sweep(settings_of(20)).run(ThreadExecutor()))
    began, spent = time.monotonic(), 0.0
    with AtlasWriter(folder / "written.h5", work.settings, work.designs, ranges) as writer:
        for results in work.run(ThreadExecutor()):
            start = time.monotonic()
            writer.add(results.block.index, results.arrays)
            spent += time.monotonic() - start
        start = time.monotonic()
        writer.assemble()
        assembling = time.monotonic() - start
    total = time.monotonic() - began
    share = 100.0 * (spent + assembling) / total
    print(
        f"N = {resolution}: {total:.2f} s, of which blocks {spent:.2f} s and the result file "
        f"{assembling:.2f} s: {share:.1f} %"
    )


def nothing(task: int) -> int:
    """Do nothing: what is left is what the scheduler takes."""
    return task


def cluster(resolution: int) -> None:
    """Print what one and two Dask workers take, beside threads."""
    settings = settings_of(resolution)
    work = Sweep(settings)
    for threads in (1, 2):
        with ThreadExecutor(threads) as executor:
            began = time.monotonic()
            blocks = sum(1 for _ in work.run(executor))
            print(f"{threads} threads: {time.monotonic() - began:.2f} s, {blocks} blocks")
    taken = {}
    probe = functools.partial(computing_versions, settings.mechanism)
    for workers in (1, 2):
        with DaskExecutor(probe, workers=workers) as executor:
            # every worker loads its kernels
            list(Sweep(settings_of(60)).run(executor))
            times = []
            for _ in range(3):
                began = time.monotonic()
                list(work.run(executor))
                times.append(time.monotonic() - began)
            taken[workers] = min(times)
            began = time.monotonic()
            list(executor.run(nothing, range(1000)))
            overhead = time.monotonic() - began
        print(
            f"{workers} Dask workers: {taken[workers]:.2f} s; {overhead:.2f} ms of overhead a "
            "block (1,000 blocks that do nothing)"
        )
    print(f"two workers are {taken[1] / taken[2]:.2f} times as fast as one")


def main() -> None:
    """Run everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--largest", type=int, default=RESOLUTIONS[-1])
    largest = parser.parse_args().largest
    print(f"{usable_cores()} cores")
    with tempfile.TemporaryDirectory() as name:
        writing(Path(name), 1000)
        cluster(600)
        growth(Path(name), largest)


if __name__ == "__main__":
    main()
