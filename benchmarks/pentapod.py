"""The atlas of the pentapod, beside a Monte Carlo in NumPy."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from fivebar_atlas import mechanisms
from fivebar_atlas.executors import ThreadExecutor
from fivebar_atlas.mechanisms.pentapod.atlas_options import AtlasOptions, home_pose
from fivebar_atlas.mechanisms.pentapod.evaluation import evaluate_designs
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.sweep import Sweep

Array = npt.NDArray[np.float64]

_DESIGNS = 12
_NAMES = ("gci", "usable_share")


def monte_carlo(
    r_a: float, r_b: float, options: AtlasOptions, count: int, seed: int
) -> tuple[float, float]:
    """Return GCI and usable share from random poses and batches of singular values."""
    geometry = options.geometry(r_a, r_b)
    a, b, axis = geometry.base, geometry.platform, geometry.axis
    random = np.random.default_rng(seed)
    least, greatest = np.array(options.box_least), np.array(options.box_greatest)
    pose = least + random.random((count, 6)) * (greatest - least)
    sb, cb, sg, cg = (f(pose[:, k]) for k in (4, 5) for f in (np.sin, np.cos))
    turned = sg * axis[1] + cg * axis[2]
    w = np.stack([cb * axis[0] + sb * turned, cg * axis[1] - sg * axis[2]], axis=-1)
    q = a[-1] - pose[:, :3]
    p1 = np.sum(q[:, :2] * w, axis=1)
    p2 = q[:, 1] * w[:, 0] - q[:, 0] * w[:, 1]
    constant = q[:, 2] * (cb * turned - sb * axis[0]) - b[-1] @ axis
    square = p1 * p1 + p2 * p2
    branch = np.sign(a[-1, 1] * axis[0] - a[-1, 0] * axis[1])
    with np.errstate(invalid="ignore"):
        root = branch * np.sqrt(square - constant**2)
        pose[:, 3] = np.arctan2(-constant * p2 - root * p1, -constant * p1 + root * p2)
        pose = pose[(pose[:, 3] >= least[3]) & (pose[:, 3] <= greatest[3])]
    home_vectors = home_pose()[:3] + b - a
    home_lengths = np.linalg.norm(home_vectors, axis=1)
    home = home_vectors / home_lengths[:, None]

    def limbs(pose: Array) -> tuple[Array, Array, Array, Array]:
        (ca, cb, cg), (sa, sb, sg) = np.cos(pose[:, 3:]).T, np.sin(pose[:, 3:]).T
        rows = [
            [ca * cb, ca * sb * sg - sa * cg, ca * sb * cg + sa * sg],
            [sa * cb, sa * sb * sg + ca * cg, sa * sb * cg - ca * sg],
            [-sb, cb * sg, cb * cg],
        ]
        rotations = np.moveaxis(np.array(rows), -1, 0)
        arms = np.einsum("nij,kj->nki", rotations, b)
        vectors = pose[:, None, :3] + arms - a
        lengths = np.linalg.norm(vectors, axis=-1)
        return rotations, arms, vectors / lengths[..., None], lengths

    def jacobians(pose: Array, rotations: Array, arms: Array, directions: Array) -> Array:
        n6 = rotations @ axis
        forces = np.concatenate([directions, n6[:, None]], axis=1)
        points = np.concatenate([arms, (a[-1] - pose[:, :3])[:, None]], axis=1)
        return np.concatenate([forces, np.cross(points, forces) / options.length(r_b)], axis=-1)

    rotations, arms, directions, lengths = limbs(pose)
    usable = np.all(
        (lengths >= options.limb_min * home_lengths) & (lengths <= options.limb_max * home_lengths),
        axis=1,
    )
    inside = np.einsum("nij,nki->nkj", rotations, directions)
    for each, limit in (
        (directions, options.base_joint_limit),
        (inside, options.platform_joint_limit),
    ):
        usable &= np.all(np.sum(each * home, axis=-1) >= np.cos(limit), axis=1)
    g = jacobians(pose[usable], rotations[usable], arms[usable], directions[usable])
    at_home = home_pose()[None]
    sign = np.sign(np.linalg.det(jacobians(at_home, *limbs(at_home)[:3])))
    g = g[np.sign(np.linalg.det(g)) == sign]
    sizes = np.linalg.svd(g, compute_uv=False)
    return float(np.mean(sizes[:, -1] / sizes[:, 0])), len(g) / count


def bench_pentapod() -> None:
    """Print times and errors of designs and of the whole atlas."""
    mechanism = mechanisms.get("pentapod")
    options = AtlasOptions.chosen(mechanism.complete_options())
    designs = 0.3 + 1.7 * np.random.default_rng(2017).random((_DESIGNS, 2))
    none = np.empty(0)

    def evaluated(tolerance: float) -> Array:
        results = evaluate_designs(designs, options, none, tolerance)
        return np.array([results[name] for name in _NAMES]).T

    def errors(values: Array) -> str:
        gaps = np.abs(values - exact)
        gaps[:, 0] /= exact[:, 0]
        one, other = gaps.max(axis=0)
        return f"largest errors: GCI {one:.1e} relative, share {other:.1e}"

    exact = evaluated(1e-4)  # compiles
    print(f"\nPentapod, {_DESIGNS} designs, GCI, usable share, volume and extremes, one core")
    for tolerance in (1e-2, 1e-3):
        start = time.perf_counter()
        values = evaluated(tolerance)
        seconds = (time.perf_counter() - start) / _DESIGNS
        print(f"  tolerance {tolerance:.0e}    {1e3 * seconds:9.1f} ms a design, {errors(values)}")
    print("  GCI and usable share only, by Monte Carlo and batches of numpy.linalg.svd")
    for count in (10_000, 100_000):
        start = time.perf_counter()
        values = np.array([monte_carlo(*design, options, count, 1) for design in designs])
        seconds = (time.perf_counter() - start) / _DESIGNS
        print(f"  {count:7d} poses      {1e3 * seconds:9.1f} ms a design, {errors(values)}")
    for thresholds in ((), (0.02,)):
        settings = SweepSettings(
            "pentapod", "radii", 40, ("home",), thresholds, 1e-3, mechanism.complete_options()
        )
        for threads in (1, 2):
            start = time.perf_counter()
            results = list(Sweep(settings).run(ThreadExecutor(threads)))
            seconds = time.perf_counter() - start
            status = np.concatenate([each.arrays["status"] for each in results])
            short, shares = (np.mean(status & bit > 0) for bit in (4, 8))
            print(
                f"  atlas of 41 x 41 designs at 1e-3, {len(thresholds)} thresholds,"
                f" {threads} thread(s): {seconds:6.1f} s;"
                f" not reached: GCI {short:.1%}, shares {shares:.1%}"
            )
