"""Speed and accuracy, side by side with what a user would write instead.

Run ``make bench``. Everything is measured in one run on this machine; times are the best of
several repetitions, errors are against values computed at tolerance 1e-10, which the last
section checks against an independent method.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))
import machines
import numpy_grid
import passive_leg
import pentapod

from fivebar_atlas import FiveBar, mechanisms
from fivebar_atlas.executors import ThreadExecutor
from fivebar_atlas.mechanisms.five_bar.evaluation import evaluate_designs
from fivebar_atlas.mechanisms.five_bar.outline import usable_workspace_of
from fivebar_atlas.mechanisms.five_bar.points import lci_at
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.sweep import Sweep

Values = dict[str, npt.NDArray[Any]]

ROOT = Path(__file__).parent.parent
MODE = np.array([[1, -1, 1]])
THRESHOLD = 0.5
QUANTITIES = ("usable_workspace_area", "gci", "good_condition_workspace_area")
EDGE_CASES = [
    (1.28, 1.72, 0.0), (1.5, 1.5, 0.0), (1.8, 1.2, 0.0), (1.3, 1.6, 0.1), (1.08, 1.25, 0.67),
    (1.0, 1.0, 1.0), (1.0, 1.5, 0.5), (1.5, 1.0, 0.5), (1.2, 1.2, 0.6), (1.5, 0.75, 0.75),
    (0.75, 1.5, 0.75), (1.3, 1.7 - 1e-5, 1e-5), (1.3, 1.69, 0.01), (2.9, 0.06, 0.04),
]  # fmt: skip


def best_time(function: Callable[[], object], repetitions: int) -> float:
    """Return the shortest of several times, in seconds."""
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def surrounded_designs(count: int, seed: int) -> npt.NDArray[np.float64]:
    """Return random designs of the surrounded space and the edge cases."""
    rng = np.random.default_rng(seed)
    designs = rng.dirichlet([1.0, 1.0, 1.0], 20 * count) * 3.0
    inside = (designs[:, 0] >= designs[:, 2]) & (designs[:, 1] >= designs[:, 2])
    return np.vstack([designs[inside][:count], EDGE_CASES])


def evaluate(designs: npt.NDArray[np.float64], tolerance: float) -> Values:
    """Evaluate everything for one mode pair and one threshold."""
    return evaluate_designs(designs, MODE, np.array([THRESHOLD]), tolerance)


def largest_error(values: list[npt.NDArray[Any]], exact: Values) -> float:
    """Return the largest error of the quantities, each relative to its largest value."""
    worst = 0.0
    for name, value in zip(QUANTITIES, values, strict=True):
        reference = exact[name].ravel()[: len(value)]
        worst = max(worst, float(np.nanmax(np.abs(value - reference) / np.nanmax(reference))))
    return worst


def bench_kernels(designs: npt.NDArray[np.float64], exact: Values) -> dict[float, float]:
    """Print time and error at three tolerances; return µs a design by tolerance."""
    print(f"\nOne core, +-/up, one threshold, {len(designs)} designs of the surrounded space")
    print("  tolerance   µs a design   largest true error   largest stated error")
    times = {}
    for tolerance in (1e-3, 1e-6, 1e-8):
        evaluate(designs[:2], tolerance)
        times[tolerance] = best_time(lambda t=tolerance: evaluate(designs, t), 5) / len(designs)
        values = evaluate(designs, tolerance)
        error = largest_error([values[name].ravel() for name in QUANTITIES], exact)
        stated = max(
            float(np.nanmax(values[f"{name}_error"]) / np.nanmax(values[name]))
            for name in QUANTITIES
        )
        print(f"  {tolerance:9.0e} {1e6 * times[tolerance]:13.1f} {error:20.1e} {stated:22.1e}")
    return {tolerance: 1e6 * seconds for tolerance, seconds in times.items()}


def bench_grid(designs: npt.NDArray[np.float64], exact: Values, ours: dict[float, float]) -> None:
    """Print time and error of a NumPy grid, and the ratio to ours at no larger error."""
    print("\nThe same on a dense NumPy grid (vectorised closed form, labelling; no circles)")
    print("  points      µs a design   largest true error   ours, at less error   ratio")
    for n, count in ((200, 60), (1000, 20)):
        # the edge cases are at the end, the first designs are random
        some = designs[:count]
        rows = []
        start = time.perf_counter()
        for r1, r2, r3 in some:
            rows.append(numpy_grid.evaluate(r1, r2, r3, 1, -1, 1, THRESHOLD, n))
        seconds = (time.perf_counter() - start) / count
        error = largest_error(list(np.array(rows).T), exact)
        time_of_ours = ours[1e-3]
        print(
            f"  {n:4d} x {n:4d} {1e6 * seconds:13.0f} {error:20.1e}"
            f" {time_of_ours:17.1f} µs {1e6 * seconds / time_of_ours:9.0f}"
        )


def bench_threads() -> None:
    """Print how a sweep gains from a second thread, and the standard atlas."""
    mechanism = mechanisms.get("five-bar")
    print("\nSweeps, +-/up, one threshold, tolerance 1e-6")
    for resolution in (100, 300):
        settings = SweepSettings("five-bar", "surrounded", resolution, ("+-/up",), (0.5,), 1e-6)
        count = len(mechanism.lattice("surrounded", resolution))
        rates = []
        for threads in (1, 2):

            def run(settings: SweepSettings = settings, threads: int = threads) -> None:
                for _ in Sweep(settings).run(ThreadExecutor(threads)):
                    pass

            seconds = best_time(run, 2)
            rates.append(count / seconds)
            print(
                f"  N = {resolution}, {count} designs, {threads} thread(s):"
                f" {seconds:6.2f} s, {rates[-1]:7.0f} designs/s"
            )
        print(f"  second thread gains a factor {rates[1] / rates[0]:.2f}")


_COUNT = """
import sys
import numpy as np
from fivebar_atlas.mechanisms.five_bar import evaluation, panels
points = 0
piece = panels._piece
def counted(*arguments):
    global points
    points += int(arguments[9])
    return piece(*arguments)
panels._piece = counted
designs = np.array(eval(sys.argv[1]))
evaluation.evaluate_designs(designs, np.array([[1, -1, 1]]), np.array([0.5]), 1e-6)
print(points / len(designs))
"""


def bench_lci_kernel(designs: npt.NDArray[np.float64], microseconds: float) -> None:
    """Print the LCI kernel's time a point and its share of a design's time at 1e-6.

    The points are counted by running a few designs as plain Python.
    """
    x, y = np.linspace(-1.0, 1.0, 160_000), np.linspace(1.0, 2.0, 160_000)
    out = np.empty_like(x)
    design = (1.3, 1.6, 0.1)
    lci_at(*design, x, y, 1.0, -1.0, out)
    seconds = best_time(lambda: lci_at(*design, x, y, 1.0, -1.0, out), 9)
    some = [[float(r) for r in row] for row in designs[:10]]
    counted = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", _COUNT, repr(some)],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    points = float(counted.stdout)
    nanoseconds = 1e9 * seconds / len(x)
    own = best_time(lambda: evaluate(designs[:10], 1e-6), 9) / 10 * 1e6
    print("\nLCI kernel")
    print(f"  {nanoseconds:.2f} ns a point (map of 400 x 400 points: {1e3 * seconds:.2f} ms)")
    print(f"  {points:.0f} points a design at 1e-6 (10 designs, {own:.0f} µs each):")
    print(f"  {points * nanoseconds / 1e3:.0f} µs, {points * nanoseconds / 10 / own:.0f} % of it")
    print(f"  (all designs: {microseconds:.0f} µs)")


_SYNTHESIS = (
    "optimum FILE --where gci>=0.62 --maximise gci",
    "optimum FILE --where gci>=0.62 --refine",
    "size 26 30 16 --rectangle 300x200",
    "size 26 30 16 --rectangle 300x200 --free --clearance 5",
    "design --rectangle 300x200 -q",
    "square -q",
)
_FIGURES = (
    "mechanism 1.2 1 0.8", "loci 1.2 1 0.8", "workspace 1.2 1 0.8", "good-condition 1.28 1.72 0",
    "lci 1.28 1.72 0", "loci-atlas --cells 60", "shape-atlas --cells 60",
)  # fmt: skip


def bench_start_up() -> None:
    """Print how long commands take as processes."""
    print("\nStart-up, whole processes")
    atlas = [sys.executable, "-c", "from fivebar_atlas.cli import main; main()"]
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}

        def run(*arguments: str) -> Callable[[], object]:
            return lambda: subprocess.run(
                [*atlas, *arguments], env=environment, capture_output=True, check=True
            )

        print(f"  atlas --help                      {best_time(run('--help'), 5):6.2f} s")
        command = ("evaluate", "26", "30", "16", "--json")
        print(f"  atlas evaluate, kernels compiled  {best_time(run(*command), 1):6.2f} s")
        print(f"  atlas evaluate, kernels cached    {best_time(run(*command), 5):6.2f} s")
        result = f"{folder}/paper.h5"
        run("sweep", str(ROOT / "configs" / "paper.toml"), "-o", result, "--quiet")()
        for what in _SYNTHESIS:
            work = run(*what.replace("FILE", result).split())
            work()  # compiles what evaluating does not need
            print(f"  {'atlas ' + what:62} {best_time(work, 3):6.2f} s")
        for what in _FIGURES:
            drawing = run("plot", *what.split(), "-o", f"{folder}/figure.png", "--overwrite")
            drawing()  # compiles what evaluating does not need
            print(f"  {'atlas plot ' + what:33} {best_time(drawing, 5):6.2f} s")


def bench_geometry() -> None:
    """Print how long loci, outlines and paths take, kernels compiled."""
    print("\nGeometry of one design, one core")
    robot = FiveBar(1.2, 1.0, 0.8)
    lengths = (1.2, 1.0, 0.8)
    turns = np.linspace(0.0, 2.0 * np.pi, 10_000)
    circle = np.column_stack([0.8 * np.cos(turns), 0.8 * np.sin(turns) - 1.0])
    for what, work in (
        ("all singular loci", lambda: robot.singular_loci()),
        ("outline of a usable workspace", lambda: usable_workspace_of(lengths, (1, -1, 1))),
        ("boundary at LCI >= 0.1", lambda: robot.good_condition_workspace(0.1)),
        ("path of 10,000 points, checked", lambda: robot.check_path(circle)),
    ):
        work()
        print(f"  {what:33} {1e3 * best_time(work, 5):8.2f} ms")


def check_accuracy() -> None:
    """Print how errors compare with an independent reference, if its cases are there."""
    path = ROOT / "tests" / "published" / "reference_cases.json"
    if not path.exists():
        print("\nNo reference cases: run benchmarks/make_reference_cases.py")
        return
    cases = json.loads(path.read_text())["cases"]
    print(f"\nAgainst an independent reference, {len(cases)} random (design, mode pair) cases")
    print("  tolerance   cases with an error above the stated one   above the tolerance")
    for tolerance in (1e-3, 1e-6, 1e-8):
        dishonest = beyond = 0
        for case in cases:
            flags = compare(case, tolerance)
            dishonest += flags[0]
            beyond += flags[1]
        share = 100.0 * (1.0 - dishonest / len(cases))
        print(f"  {tolerance:9.0e} {dishonest:25d} ({share:.2f} % hold) {beyond:21d}")


def compare(case: dict[str, Any], tolerance: float) -> tuple[bool, bool]:
    """Return whether any error exceeds the stated one, and whether any the tolerance."""
    values = evaluate_designs(
        np.array([[case["r1"], case["r2"], case["r3"]]]),
        np.array([[case["s1"], case["s2"], case["assembly"]]]),
        np.array([case["threshold"]]),
        tolerance,
    )
    dishonest = beyond = False
    reached = not int(values["status"][0, 0]) & 4
    for ours, theirs in (
        ("usable_workspace_area", "usable_workspace_area"),
        ("gci", "gci"),
        ("good_condition_workspace_area", "good_condition_area"),
        ("good_condition_gci", "good_condition_gci"),
    ):
        value, error = float(values[ours].ravel()[0]), float(values[f"{ours}_error"].ravel()[0])
        if case[theirs] is None or np.isnan(value):
            continue
        # the reference has an error of its own, and both round
        doubt = case[f"{theirs}_error"] + 1e-13
        difference = abs(value - case[theirs])
        dishonest |= difference > error + doubt
        beyond |= reached and difference > tolerance * abs(case[theirs]) + doubt
    return dishonest, beyond


def main() -> None:
    """Run all benchmarks."""
    designs = surrounded_designs(300, 20060323)
    exact = evaluate(designs, 1e-10)
    ours = bench_kernels(designs, exact)
    bench_grid(designs, exact, ours)
    bench_threads()
    bench_lci_kernel(designs, ours[1e-6])
    bench_geometry()
    bench_start_up()
    machines.bench_machines()
    passive_leg.bench_passive_leg()
    pentapod.bench_pentapod()
    check_accuracy()


if __name__ == "__main__":
    main()
