"""The atlas of the manipulator with a passive leg, beside a dense NumPy grid."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from fivebar_atlas import mechanisms
from fivebar_atlas.executors import ThreadExecutor
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.sweep import Sweep

_DESIGNS = 40
_NAMES = ("usable_workspace_area", "gci", "good_condition_workspace_area")


def on_a_grid(
    r: float, l_a: float, l_b: float, threshold: float, n: int
) -> tuple[float, float, float]:
    """Return area, GCI and good-condition area in "+-/up" on n x n cells of l and θ."""
    step = (np.arange(n) + 0.5) / n
    theta, length = np.meshgrid(np.pi * (step - 0.5), (l_a + l_b + 1.0) * step)
    cell = length * np.pi * (l_a + l_b + 1.0) / n**2
    c, s = np.cos(theta), np.sin(theta)
    inside = np.ones_like(c, dtype=bool)
    links, rates = [], []
    with np.errstate(invalid="ignore", divide="ignore"):
        for side in (1.0, -1.0):
            e, f = side * (r - c), length + side * s
            d2 = e * e + f * f
            areas = ((l_a + l_b) ** 2 - d2) * (d2 - (l_a - l_b) ** 2)
            inside &= areas > 0.0
            along = 0.5 * (d2 + l_a**2 - l_b**2) / d2
            across = -0.5 * side * np.sqrt(np.maximum(areas, 0.0)) / d2
            a, b = along * e - across * f, along * f + across * e
            links.append((e - a, f - b))
            rates.append(a * (f - b) - b * (e - a))
            inside &= f - b > 0.0
        (p1, q1), (p2, q2) = links
        row1 = ((p1 - q1 * r / length) / rates[0], q1 / rates[0])
        row2 = ((p2 + q2 * r / length) / rates[1], q2 / rates[1])
        det_x = (p1 - q1 * r / length) * q2 - q1 * (p2 + q2 * r / length)
        inside &= det_x < 0.0
        t = 2.0 * np.abs(row1[0] * row2[1] - row1[1] * row2[0])
        total = row1[0] ** 2 + row1[1] ** 2 + row2[0] ** 2 + row2[1] ** 2
        lci = t / (total + np.sqrt(np.maximum(total * total - t * t, 0.0)))
    labels, _ = ndimage.label(inside)
    sizes = np.bincount(labels.ravel(), cell.ravel())
    sizes[0] = 0.0
    usable = labels == np.argmax(sizes)
    area = float(cell[usable].sum())
    good = usable & (lci >= threshold)
    return area, float((cell * lci)[usable].sum()) / area, float(cell[good].sum())


def _seconds(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def bench_passive_leg() -> None:
    """Print times and errors of designs and of the whole atlas."""
    mechanism = mechanisms.get("passive-leg")
    rng = np.random.default_rng(2006)
    ratios = 0.5 + 1.5 * rng.random((_DESIGNS, 2))
    designs = mechanism.unproject(ratios, "conditioned")

    def evaluated(tolerance: float) -> list[npt.NDArray[np.float64]]:
        settings = SweepSettings("passive-leg", "conditioned", 2, ("+-/up",), (0.5,), tolerance)
        results = mechanism.evaluate(designs, settings)
        return [results[name].ravel() for name in _NAMES]

    def largest_error(values: npt.NDArray[np.float64]) -> float:
        return max(
            float(np.max(np.abs(mine - its)) / np.max(its))
            for mine, its in zip(values.T, exact, strict=True)
        )

    exact = evaluated(1e-8)  # compiles
    print(f"\nManipulator with a passive leg, {_DESIGNS} designs, +-/up, one threshold, one core")
    for tolerance in (1e-3, 1e-4, 1e-6):
        seconds = min(_seconds(functools.partial(evaluated, tolerance)) for _ in range(3))
        error = largest_error(np.array(evaluated(tolerance)).T)
        print(
            f"  tolerance {tolerance:.0e}     {1e6 * seconds / _DESIGNS:9.0f} µs a design,"
            f" largest error {error:.1e}"
        )
    for n in (200, 1000):
        start = time.perf_counter()
        values = [on_a_grid(*design, 0.5, n) for design in designs]
        seconds = time.perf_counter() - start
        print(
            f"  NumPy grid {n:4d} x {n:<4d} {1e6 * seconds / _DESIGNS:9.0f} µs a design,"
            f" largest error {largest_error(np.array(values)):.1e}"
        )
    settings = SweepSettings("passive-leg", "conditioned", 150, ("+-/up",), (0.5,), 1e-4)
    for threads in (1, 2):
        executor = ThreadExecutor(threads)
        seconds = _seconds(lambda: list(Sweep(settings).run(executor)))  # noqa: B023
        print(f"  atlas of 151 x 151 designs at 1e-4, {threads} thread(s): {seconds:6.2f} s")
