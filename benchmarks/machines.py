"""The best machine for a rectangle, beside a random search of 100,000 designs."""

from __future__ import annotations

import time

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.planar import PlacementScan
from fivebar_atlas.synthesis.best_machines import best_machines
from fivebar_atlas.synthesis.machine_goals import goal_named
from fivebar_atlas.synthesis.machine_search import MachineTask
from fivebar_atlas.synthesis.shapes import Shape

_DESIGNS, _POSITIONS = 100_000, 401


def random_search(task: MachineTask, seed: int) -> float:
    """Return the best value of random designs of the design space, on samples of the shape."""
    rng = np.random.default_rng(seed)
    wanted = rng.random((4 * _DESIGNS, 2)) * [3.0, 1.5]
    designs = np.column_stack([wanted[:, 0], 3.0 - wanted.sum(axis=1), wanted[:, 1]])
    designs = designs[(designs > 0.0).all(axis=1)][:_DESIGNS]
    shape = task.shape
    samples = np.concatenate(
        [shape.boundary(shape.boundary_samples(80)), shape.interior_samples(400)]
    )
    heights = np.linspace(-1.0, 1.0, _POSITIONS + 2)[1:-1]
    anchors = np.column_stack([np.zeros(_POSITIONS), heights])
    links = task.mechanism.moving_links(designs)
    best = np.inf
    least, greatest = task.scales(designs)
    for mode in task.modes:
        scan = PlacementScan(mode, task.lci_threshold, samples, anchors, np.empty((0, 3)))
        # only what would be better
        floors = np.maximum(least, links / best)
        scales = task.mechanism.scan_placements(designs, floors, greatest, scan)[..., 0].max(axis=1)
        found = scales > 0.0
        best = min(best, float(np.min(links[found] / scales[found], initial=np.inf)))
    return best


def bench_machines() -> None:
    """Print times and values of the search and of a random one."""
    five_bar = mechanisms.get("five-bar")
    task = MachineTask(
        five_bar, Shape.rectangle(300.0, 200.0), goal_named("links"), five_bar.modes, 0.5
    )
    best_machines(task, 1)  # compiles
    print("\nBest machine for a rectangle of 300 x 200 mm, LCI >= 0.5, smallest sum of links")
    start = time.perf_counter()
    best = best_machines(task, 3)[0]
    print(
        f"  search, three machines, proved     {time.perf_counter() - start:6.2f} s"
        f"{best.value:14.6f} mm"
    )
    start = time.perf_counter()
    value = random_search(task, 1)
    print(
        f"  {_DESIGNS} random designs, one core  {time.perf_counter() - start:6.2f} s"
        f"{value:14.6f} mm, on samples"
    )
