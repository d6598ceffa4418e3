"""Motions for tests, and an independent computation of what limbs do and bear in them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

Array = npt.NDArray[np.float64]

ROOT = Path(__file__).parent.parent
EXAMPLE = ROOT / "configs" / "motions" / "wang-2017.toml"

#: A short motion, with each kind of function, and Y solved for.
PLAIN = """
[geometry]
r_a = 400.0
r_b = 100.0

[motion]
duration = 4.0
samples = 201
solve = "y"

[motion.coordinates]
x = { kind = "polynomial", coefficients = [0.0, 0.0, 8.0, -2.0] }
z = { kind = "stops", times = [0, 2, 4], values = [500, 560, 500] }
alpha = { kind = "spline", times = [0, 2, 4], values = [0, 20, 0] }
beta = { kind = "spline", times = [0, 1, 2, 4], values = [0, 5, 8, 0], degree = 3 }
gamma = -3.0

[load]
force = [0.0, 10.0, -10.0]
moment = [10.0, 0.0, 10.0]
"""


def joints() -> tuple[Array, Array, Array]:
    """Return A_i, B_i and n6 of r_a = 400, r_b = 100 and the documented defaults."""
    base = np.zeros((5, 3))
    base[0, 0] = 400.0
    turns = np.radians([45.0, 135.0, 225.0, 315.0])
    base[1:, :2] = 400.0 * np.column_stack([np.cos(turns), np.sin(turns)])
    turns = np.radians(36.0 + 72.0 * np.arange(5))
    platform = 100.0 * np.column_stack([np.cos(turns), np.sin(turns), np.zeros(5)])
    gap = base[4] - platform[4]
    axis = np.array([-gap[1], gap[0], 0.0])
    return base, platform, axis / np.linalg.norm(axis)


def turned(columns: Any) -> Array:
    """Return the platform's rotations of a solution or a table, angles in degrees."""
    angles = np.column_stack([columns[name] for name in ("alpha", "beta", "gamma")])
    return Rotation.from_euler("ZYX", angles, degrees=True).as_matrix()


def positions(columns: Any) -> Array:
    """Return p."""
    return np.column_stack([columns[name] for name in "xyz"])


def vectors(columns: Any) -> tuple[Array, Array]:
    """Return the limbs' vectors from A_i to B_i and arms from p to B_i, shape (n, 5, 3)."""
    base, platform, _ = joints()
    arms = np.einsum("nij,kj->nki", turned(columns), platform)
    return positions(columns)[:, None] + arms - base, arms


def gaps(columns: Any) -> Array:
    """Return (A_5 - B_5)·n6."""
    limbs, _ = vectors(columns)
    axes = turned(columns) @ joints()[2]
    return -np.sum(limbs[:, 4] * axes, axis=-1)


def differences(values: Array, step: float) -> tuple[Array, Array]:
    """Return first and second derivatives of samples by central differences of sixth order.

    The three samples at each end are left out.
    """
    first = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
    second = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
    windows = np.lib.stride_tricks.sliding_window_view(values, 7, axis=0)
    return windows @ first / step, windows @ second / step**2


def named(prefix: str, columns: Any) -> Array:
    """Return the columns of the five limbs, shape (n, 5)."""
    return np.column_stack([columns[f"{prefix}{limb}"] for limb in range(1, 6)])


def smooth_poses(count: int, duration: float = 4.0) -> dict[str, Array]:
    """Return poses that keep the constraint, as columns: all but y sines, y solved for."""
    base, platform, axis = joints()
    t = np.linspace(0.0, duration, count)
    phase = 2.0 * math.pi * t / duration
    columns = {
        "t": t,
        "x": 40.0 * np.sin(phase),
        "z": 520.0 + 30.0 * np.sin(phase),
        "alpha": 8.0 * np.sin(phase),
        "beta": 6.0 * (1.0 - np.cos(phase)),
        "gamma": -5.0 * (1.0 - np.cos(phase)),
    }
    axes = turned(columns) @ axis
    rest = (
        axes @ base[4] - platform[4] @ axis - axes[:, 0] * columns["x"] - axes[:, 2] * columns["z"]
    )
    columns["y"] = rest / axes[:, 1]
    return columns


def write_poses(path: Path, columns: dict[str, Array], form: str = "%.17g") -> Path:
    """Write columns as a table."""
    names = list(columns)
    rows = np.column_stack([columns[name] for name in names])
    lines = [",".join(names), *(",".join(form % value for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
