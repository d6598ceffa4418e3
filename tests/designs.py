"""Random designs and mode pairs for tests, seeded by the caller."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

Case = tuple[tuple[float, float, float], tuple[int, int, int]]

MODES = [(s1, s2, assembly) for s1 in (1, -1) for s2 in (1, -1) for assembly in (1, -1)]


def random_design(rng: np.random.Generator, surrounded: bool = False) -> tuple[float, float, float]:
    """Return a design drawn uniformly from the assemblable or the surrounded space."""
    while True:
        r1, r2, r3 = 3.0 * rng.dirichlet([1.0, 1.0, 1.0])
        if r3 <= 1.5 and (not surrounded or (r1 >= r3 and r2 >= r3)):
            return float(r1), float(r2), float(r3)


def random_cases(seed: int, count: int) -> Iterator[Case]:
    """Yield assemblable designs with mode pairs."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        mode = MODES[rng.integers(len(MODES))]
        yield random_design(rng), mode


def random_reachable_point(
    rng: np.random.Generator, r1: float, r2: float, r3: float
) -> tuple[float, float]:
    """Return a point inside the theoretical workspace, drawn by its distances from the base."""
    outer, inner = r1 + r2, abs(r1 - r2)
    for _ in range(100_000):
        d1 = rng.uniform(max(inner, 2.0 * r3 - outer), outer)
        d2 = rng.uniform(max(inner, abs(2.0 * r3 - d1)), min(outer, 2.0 * r3 + d1))
        if d2 <= inner:
            continue
        x = (d1 - d2) * (d1 + d2) / (4.0 * r3)
        height2 = (d1 - x - r3) * (d1 + x + r3)
        if height2 > 0.0:
            return float(x), float(rng.choice([-1.0, 1.0]) * np.sqrt(height2))
    raise AssertionError(f"no point found for {r1}, {r2}, {r3}")
