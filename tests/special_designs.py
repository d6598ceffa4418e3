"""Designs at which loci meet, coincide or pass through the origin; names of mode pairs."""

from __future__ import annotations

import itertools
import math

import numpy as np

Design = tuple[float, float, float]


def label(s1: int, s2: int, assembly: int) -> str:
    """Return a mode pair as the arcs name it."""
    return f"{'+' if s1 > 0 else '-'}{'+' if s2 > 0 else '-'}/{'up' if assembly > 0 else 'down'}"


def lattice(steps: int) -> list[Design]:
    """Return the assemblable designs whose lengths are multiples of 3/steps."""
    return [
        (3.0 * i / steps, 3.0 * j / steps, 3.0 * k / steps)
        for i, j in itertools.product(range(1, steps), repeat=2)
        for k in (steps - i - j,)
        if 0 <= 2 * k <= steps
    ]


def special_designs() -> list[Design]:
    """Return designs at which loci meet, coincide or pass through the origin.

    Not those with r3 = r1 + r2, which reach a single point.
    """
    rng = np.random.default_rng(50)
    found = lattice(12)
    for u, v in rng.uniform(0.15, 1.5, (8, 2)):
        hypotenuse = math.hypot(u, v)
        for lengths in (
            (u, v, u), (u, v, v), (u, u, v), (u, v, 0.0), (u, u + v, v), (u + v, u, v),
            (hypotenuse, u, v), (u, hypotenuse, v), (u, v, hypotenuse),
        ):  # fmt: skip
            r1, r2, r3 = (3.0 * float(length) / float(sum(lengths)) for length in lengths)
            if r3 <= 1.5:
                found.append((r1, r2, r3))
    return [(r1, r2, r3) for r1, r2, r3 in found if r1 + r2 - r3 > 1e-9]
