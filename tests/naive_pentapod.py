"""The pentapod in obvious NumPy, and a reference of its atlas.

Nothing is imported from the package, and no formula of it is used: joints are points, limbs are
lines between them, and what the atlas integrates is counted at points of its own.

Conventions. Four limbs S-P-S and a fifth S-P-R: A_i on the base, B_i = p + R b_i on the platform,
R = Rz(α) Ry(β) Rx(γ). The revolute joint at B_5 turns about n6, fixed in the platform, so that limb
5 stays perpendicular to it: (A_5 - B_5)·n6 = 0. Forces act along the lines of the limbs, and the
constraint force through A_5 along n6; the rows of G are the Plücker coordinates of these six lines
about p. Home is p = (0, 0, 1) with R = 1: lengths are in units of the height H there.

The atlas of a design (r_a, r_b). A pose of the box is given by X, Y, Z, β and γ; α follows from the
constraint, on the branch that goes through home. It is usable if α exists and is in its range,
limb lengths and joint angles are within limits, and det G has the sign it has at home.

``box_indices``
    Means over the box from points of a Kronecker sequence, shifted at random; the standard error is
    that of the shifts.
``workspace_volume``
    The same for the positions that all limbs reach.
``extremes``
    The worst of many points, improved by SLSQP within the limits.

References
----------
Wang, Zhao, Huang, Li, Zhang, Zhang, "Kinematics and statics analyses of a parallel manipulator with
five active limbs", ICIC Express Letters 11 (2017).
"""

import dataclasses
import itertools
import json
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Found = dict[str, tuple[float, float]]

HOME = np.array([0.0, 0.0, 1.0])


# --------------------------------------------------------------------------------------------------
# The machine and its poses
# --------------------------------------------------------------------------------------------------


class Machine(NamedTuple):
    """Joint centres of base and platform, and n6 in the axes of the platform; or many machines."""

    base: Array  # (..., 5, 3)
    platform: Array  # (..., 5, 3)
    axis: Array  # (..., 3)


@dataclasses.dataclass(frozen=True)
class Task:
    """What an atlas assumes, in degrees and units of H; the names are those of its options."""

    position_angle: float = 36.0
    base_angle: float = 45.0
    offset: float = 1.0
    axis_angle: float = 0.0
    characteristic_length: float = 0.25
    platform_radius_as_length: bool = False
    x_min: float = -0.25
    x_max: float = 0.25
    y_min: float = -0.25
    y_max: float = 0.25
    z_min: float = 0.85
    z_max: float = 1.15
    alpha_min: float = -30.0
    alpha_max: float = 30.0
    beta_min: float = -20.0
    beta_max: float = 20.0
    gamma_min: float = -20.0
    gamma_max: float = 20.0
    limb_min: float = 0.7
    limb_max: float = 1.3
    base_joint_limit: float = 45.0
    platform_joint_limit: float = 45.0

    def machine(self, r_a: float, r_b: float) -> Machine:
        """Place the joints of a design."""
        turns = math.radians(self.base_angle) + 0.5 * math.pi * np.arange(4)
        base = np.vstack([[self.offset * r_a, 0.0, 0.0], r_a * around(turns)])
        turns = math.radians(self.position_angle) + 0.4 * math.pi * np.arange(5)
        platform = r_b * around(turns)
        limb = HOME + platform[4] - base[4]
        across = np.array([-limb[1], limb[0], 0.0])
        if math.hypot(limb[0], limb[1]) < 1e-12:
            across = np.array([-platform[4, 1], platform[4, 0], 0.0])
        across /= np.linalg.norm(across)
        tilt = math.radians(self.axis_angle)
        along = limb / np.linalg.norm(limb)
        axis = math.cos(tilt) * across + math.sin(tilt) * np.cross(along, across)
        return Machine(base, platform, axis)

    def length(self, r_b: float) -> float:
        """Give the characteristic length of a design."""
        return r_b if self.platform_radius_as_length else self.characteristic_length

    def range_of(self, name: str) -> tuple[float, float]:
        """Give the range of a coordinate; angles in radians."""
        unit = 1.0 if name in "xyz" else math.radians(1.0)
        return unit * getattr(self, f"{name}_min"), unit * getattr(self, f"{name}_max")


def around(turns: Array) -> Array:
    """Give points of the unit circle in the plane of x and y."""
    return np.column_stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)])


def rotation(alpha: ArrayLike, beta: ArrayLike, gamma: ArrayLike) -> Array:
    """Multiply the elementary rotations Rz(α) Ry(β) Rx(γ)."""
    angles = np.broadcast_arrays(*(np.asarray(each, float) for each in (alpha, beta, gamma)))
    product = np.broadcast_to(np.eye(3), (*angles[0].shape, 3, 3))
    for angle, (i, j) in zip(angles, ((0, 1), (2, 0), (1, 2)), strict=True):
        turn = np.zeros((*angle.shape, 3, 3))
        turn[...] = np.eye(3)
        turn[..., i, i] = turn[..., j, j] = np.cos(angle)
        turn[..., j, i] = np.sin(angle)
        turn[..., i, j] = -turn[..., j, i]
        product = product @ turn
    return product


def turned(matrix: Array, vectors: Array) -> Array:
    """Turn vectors, one of each matrix or one of all."""
    return np.asarray(np.einsum("...ij,...j->...i", matrix, vectors))


def dot(one: Array, other: Array) -> Array:
    """Scalar product of vectors stored along the last axis."""
    return np.asarray(np.sum(one * other, axis=-1))


def limb_vectors(m: Machine, position: Array, matrix: Array) -> Array:
    """Vectors from A_i to B_i, shape (..., 5, 3)."""
    arms = np.einsum("...ij,...kj->...ki", matrix, m.platform)
    return position[..., None, :] + arms - m.base


def limb_lengths(m: Machine, position: Array, matrix: Array) -> Array:
    """Limb lengths, shape (..., 5)."""
    return np.linalg.norm(limb_vectors(m, position, matrix), axis=-1)


def constraint(m: Machine, position: Array, matrix: Array) -> Array:
    """Component of A_5 - B_5 along the revolute axis."""
    gap = -limb_vectors(m, position, matrix)[..., 4, :]
    return dot(gap, turned(matrix, m.axis))


def solved_alpha(
    m: Machine, position: Array, beta: ArrayLike, gamma: ArrayLike, side: float
) -> tuple[Array, Array]:
    """Angle α that the constraint leaves, and how far it is from not existing.

    With q = A_5 - p and n6 = Rz(α) u the constraint is q·n6 = b_5·a: seen along Z, the angle from q
    to n6 has the cosine c = (b_5·a - q_z u_z)/(|q_xy| |u_xy|). Of the two angles that is taken in
    which n6 is on the side of q that is given, +1 counter-clockwise. The second result is 1 - c²; α
    is the nearest thing to a solution where that is negative.
    """
    q = m.base[..., 4, :] - position
    u = turned(rotation(0.0, beta, gamma), m.axis)
    reach = np.hypot(q[..., 0], q[..., 1]) * np.hypot(u[..., 0], u[..., 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = (dot(m.platform[..., 4, :], m.axis) - q[..., 2] * u[..., 2]) / reach
    cosine = np.where(reach > 0.0, cosine, np.inf)
    turn = np.arctan2(q[..., 1], q[..., 0]) - np.arctan2(u[..., 1], u[..., 0])
    alpha = turn + side * np.arccos(np.clip(cosine, -1.0, 1.0))
    wrapped = math.pi - np.mod(math.pi - alpha, 2.0 * math.pi)
    return wrapped, 1.0 - cosine**2


def home_side(m: Machine) -> float:
    """Side of A_5 - p, seen along Z, on which n6 is at home; 0 if the two are in line."""
    q = m.base[4] - HOME
    return float(np.sign(q[0] * m.axis[1] - q[1] * m.axis[0]))


def jacobian(m: Machine, position: Array, matrix: Array) -> Array:
    """Plücker coordinates, direction and moment about p, of the lines of the six forces."""
    limbs = limb_vectors(m, position, matrix)
    directions = limbs / np.linalg.norm(limbs, axis=-1, keepdims=True)
    axis = np.broadcast_to(turned(matrix, m.axis)[..., None, :], directions[..., :1, :].shape)
    lines = np.concatenate([directions, axis], axis=-2)
    # any point of a line gives its moment; A_i is one of all, A_5 also of the last
    points = m.base[..., [0, 1, 2, 3, 4, 4], :] - position[..., None, :]
    return np.concatenate([lines, np.cross(points, lines)], axis=-1)


def homogeneous(matrices: Array, length: float) -> Array:
    """Measure moments in units of force times a length."""
    return matrices / np.repeat([1.0, length], 3)


class Conditioning(NamedTuple):
    """What the atlas says of single poses."""

    lci: Array
    least: Array  # singular value
    force: Array  # largest limb force for a unit wrench


def conditioning(matrices: Array) -> Conditioning:
    """Evaluate homogeneous Jacobian matrices, (..., 6, 6); forces are infinite if singular."""
    values = np.linalg.svd(matrices, compute_uv=False)
    regular = values[..., -1] > 0.0
    inverse = np.linalg.inv(np.where(regular[..., None, None], matrices, np.eye(6)))
    forces = np.linalg.norm(inverse[..., :5], axis=-2).max(axis=-1)
    return Conditioning(
        values[..., -1] / values[..., 0], values[..., -1], np.where(regular, forces, np.inf)
    )


# --------------------------------------------------------------------------------------------------
# Limits
# --------------------------------------------------------------------------------------------------


class Poses(NamedTuple):
    """Poses that keep the constraint, or come nearest to it."""

    position: Array  # (n, 3)
    matrix: Array  # (n, 3, 3)
    margins: Array  # (n, 23), none negative within all limits but that of det G


def poses_of(task: Task, m: Machine, coordinates: Array) -> Poses:
    """Solve for α in poses given by X, Y, Z, β, γ, shape (n, 5), and measure limits."""
    position = coordinates[:, :3]
    beta, gamma = coordinates[:, 3], coordinates[:, 4]
    alpha, exists = solved_alpha(m, position, beta, gamma, home_side(m))
    matrix = rotation(alpha, beta, gamma)
    limbs = limb_vectors(m, position, matrix)
    lengths = np.linalg.norm(limbs, axis=-1)
    at_home = HOME + m.platform - m.base
    strokes = lengths / np.linalg.norm(at_home, axis=-1)
    axes = at_home / np.linalg.norm(at_home, axis=-1, keepdims=True)
    directions = limbs / lengths[..., None]
    in_platform = np.einsum("nji,nkj->nki", matrix, directions)
    least, greatest = task.range_of("alpha")
    margins = [
        exists[:, None],
        np.stack([alpha - least, greatest - alpha], axis=-1),
        strokes - task.limb_min,
        task.limb_max - strokes,
        dot(directions, axes) - math.cos(math.radians(task.base_joint_limit)),
        dot(in_platform, axes) - math.cos(math.radians(task.platform_joint_limit)),
    ]
    return Poses(position, matrix, np.concatenate(margins, axis=-1))


def home_sign(m: Machine) -> float:
    """Sign of det G at home."""
    return float(np.sign(np.linalg.det(jacobian(m, HOME, np.eye(3)))))


def home_indices(task: Task, r_a: float, r_b: float) -> Conditioning:
    """Evaluate the home pose."""
    m = task.machine(r_a, r_b)
    return conditioning(homogeneous(jacobian(m, HOME, np.eye(3)), task.length(r_b)))


# --------------------------------------------------------------------------------------------------
# Means and shares
# --------------------------------------------------------------------------------------------------


def kronecker(count: int, dimension: int, shift: Array) -> Array:
    """Points k (1/g, 1/g², ...) + shift modulo 1, g the root of g^(d+1) = g + 1 above 1."""
    g = optimize.brentq(lambda x: x ** (dimension + 1) - x - 1.0, 1.0, 2.0, xtol=1e-15)
    steps = g ** -np.arange(1.0, dimension + 1.0)
    return np.mod(np.arange(count)[:, None] * steps + shift, 1.0)


def mapped(task: Task, unit: Array) -> Array:
    """Map the unit cube to the box of X, Y, Z, β, γ."""
    ends = np.array([task.range_of(name) for name in ("x", "y", "z", "beta", "gamma")])
    return ends[:, 0] + (ends[:, 1] - ends[:, 0]) * unit


def box_indices(
    task: Task,
    r_a: float,
    r_b: float,
    thresholds: Sequence[float] = (),
    *,
    points: int = 4096,
    shifts: int = 16,
    seed: int = 1,
) -> Found:
    """Evaluate means and shares of the box.

    Returns
    -------
    dict
        Name to value and standard error; names of thresholds as ``"good_condition_gci 0.2"``. Means
        over no pose are NaN.
    """
    m, length = task.machine(r_a, r_b), task.length(r_b)
    sign = home_sign(m)
    random = np.random.default_rng(seed)
    sums: dict[str, list[float]] = {}
    for _ in range(shifts):
        coordinates = mapped(task, kronecker(points, 5, random.random(5)))
        poses = poses_of(task, m, coordinates)
        within = np.all(poses.margins >= 0.0, axis=1)
        matrices = jacobian(m, poses.position[within], poses.matrix[within])
        matrices = matrices[sign * np.linalg.det(matrices) > 0.0]
        values = conditioning(homogeneous(matrices, length))
        found = {"usable_share": len(matrices), "gci": values.lci.sum()}
        found["mean_least_singular_value"] = values.least.sum()
        for t in thresholds:
            good = values.lci >= t
            found[f"good_condition_share {t:g}"] = np.count_nonzero(good)
            found[f"good_condition_gci {t:g}"] = values.lci[good].sum()
        for name, value in found.items():
            sums.setdefault(name, []).append(float(value) / points)
    of = {"gci": "usable_share", "mean_least_singular_value": "usable_share"}
    of |= {f"good_condition_gci {t:g}": f"good_condition_share {t:g}" for t in thresholds}
    return {name: _ratio(each, sums.get(of.get(name, ""))) for name, each in sums.items()}


def _ratio(parts: list[float], wholes: list[float] | None) -> tuple[float, float]:
    """Mean of independent parts, or ratio of two means, and its standard error."""
    upper = np.array(parts)
    lower = np.ones_like(upper) if wholes is None else np.array(wholes)
    if lower.mean() == 0.0:
        return math.nan, math.nan
    value = upper.mean() / lower.mean()
    rest = (upper - value * lower) / lower.mean()
    return float(value), float(rest.std(ddof=1) / math.sqrt(len(rest)))


def bounding_box(task: Task, m: Machine) -> tuple[Array, Array]:
    """Corners of a box that holds every p which all limbs reach, above the base."""
    at_home = np.linalg.norm(HOME + m.platform - m.base, axis=1)
    reach = (task.limb_max * at_home + np.linalg.norm(m.platform, axis=1))[:, None]
    low, high = (m.base - reach).max(axis=0), (m.base + reach).min(axis=0)
    low[2] = max(low[2], 0.0)
    return low, np.maximum(low, high)


def workspace_volume(
    task: Task, r_a: float, r_b: float, *, points: int = 2**16, shifts: int = 16, seed: int = 2
) -> tuple[float, float]:
    """Volume of the usable positions with β = γ = 0, and its standard error."""
    m = task.machine(r_a, r_b)
    sign = home_sign(m)
    low, high = bounding_box(task, m)
    random = np.random.default_rng(seed)
    volumes = []
    for _ in range(shifts):
        unit = kronecker(points, 3, random.random(3))
        coordinates = np.hstack([low + (high - low) * unit, np.zeros((points, 2))])
        poses = poses_of(task, m, coordinates)
        within = np.all(poses.margins >= 0.0, axis=1)
        matrices = jacobian(m, poses.position[within], poses.matrix[within])
        inside = np.count_nonzero(sign * np.linalg.det(matrices) > 0.0)
        volumes.append(float(np.prod(high - low)) * inside / points)
    return _ratio(volumes, None)


# --------------------------------------------------------------------------------------------------
# Extremes
# --------------------------------------------------------------------------------------------------


class Extremes(NamedTuple):
    """The worst usable poses that a search finds."""

    least_singular_value: float
    largest_limb_force: float
    least_determinant: float  # of G times its sign at home, over all poses within other limits


def extremes(
    task: Task,
    r_a: float,
    r_b: float,
    *,
    points: int = 20000,
    starts: int = 4,
    seed: int = 3,
) -> Extremes:
    """Search the box for the worst poses: the worst points, each improved within the limits."""
    m, length = task.machine(r_a, r_b), task.length(r_b)
    sign = home_sign(m)
    unit = kronecker(points, 5, np.random.default_rng(seed).random(5))
    unit = np.vstack([unit, list(itertools.product((0.0, 0.5, 1.0), repeat=5))])

    def matrices_at(u: Array) -> Array:
        poses = poses_of(task, m, mapped(task, u))
        return homogeneous(jacobian(m, poses.position, poses.matrix), length)

    def determinant(u: Array) -> Array:
        return np.asarray(sign * np.linalg.det(matrices_at(u)))

    def least(u: Array) -> Array:
        """Give the least singular value with the sign of det G."""
        matrices = matrices_at(u)
        side = np.sign(sign * np.linalg.det(matrices))
        return np.asarray(side * np.linalg.svd(matrices, compute_uv=False)[:, -1])

    def ease(u: Array) -> Array:
        """Give 1 over the largest limb force, with the sign of det G."""
        matrices = matrices_at(u)
        side = np.sign(sign * np.linalg.det(matrices))
        return np.asarray(side / conditioning(matrices).force)

    within = np.all(poses_of(task, m, mapped(task, unit)).margins >= 0.0, axis=1)
    found = [_worst(task, m, f, unit[within], starts) for f in (least, ease, determinant)]
    return Extremes(found[0], 1.0 / found[1] if found[1] > 0.0 else math.nan, found[2])


def _worst(
    task: Task, m: Machine, function: Callable[[Array], Array], points: Array, starts: int
) -> float:
    """Least value of a function within limits; NaN without a point."""
    if not len(points):
        return math.nan
    values = function(points)
    best = float(values.min())
    bounds = [(0.0, 1.0)] * 5
    # a margin that no rounding takes below zero
    spare = 1e-9

    def margins(u: Array) -> Array:
        return np.asarray(poses_of(task, m, mapped(task, u[None])).margins[0] - spare)

    for start in _apart(points[np.argsort(values)], starts):
        result = optimize.minimize(
            lambda u: float(function(u[None])[0]),
            start,
            method="SLSQP",
            bounds=bounds,
            constraints={"type": "ineq", "fun": margins},
            options={"maxiter": 200, "ftol": 1e-12},
        )
        end = np.clip(result.x, 0.0, 1.0)
        if np.all(margins(end) >= -spare):
            best = min(best, float(function(end[None])[0]))
    return best


def _apart(points: Array, count: int) -> Iterator[Array]:
    """Give the first points of which none is close to an earlier one."""
    taken: list[Array] = []
    for point in points:
        if all(np.abs(point - other).max() > 0.2 for other in taken):
            taken.append(point)
            yield point
        if len(taken) == count:
            return


# --------------------------------------------------------------------------------------------------
# Motions
# --------------------------------------------------------------------------------------------------

#: Weights of central differences of eighth order, first and second derivative, at -4 ... 4.
FIRST = np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / 840.0
SECOND = np.array([-9, 128, -1008, 8064, -14350, 8064, -1008, 128, -9]) / 5040.0


def derivatives(function: Callable[[Array], Array], step: Array) -> tuple[Array, Array]:
    """First and second time derivative at t = 0, by central differences of eighth order.

    Parameters
    ----------
    function
        From times, one of each case, shape (..., n), to values of shape (..., n, more).
    step
        Step of each case, shape (..., n).
    """
    samples = [function(k * step) for k in range(-4, 5)]
    width = step.reshape(step.shape + (1,) * (samples[0].ndim - step.ndim))
    first = sum(w * each for w, each in zip(FIRST, samples, strict=True)) / width
    # of the differences to the middle, whose rounding is less
    second = sum(w * (each - samples[4]) for w, each in zip(SECOND, samples, strict=True))
    return np.asarray(first), np.asarray(second / width**2)


@dataclasses.dataclass(frozen=True)
class Motions:
    """Motions of machines that keep the constraint.

    The Euler angles and a point q are parabolas in t; p is the point nearest to q in which limb 5
    is perpendicular to n6. Rows of the coefficients are those of 1, t and t²/2.
    """

    machines: Machine  # (n, ...)
    points: Array  # (3, ..., n, 3), of q
    angles: Array  # (3, ..., n, 3), radians

    def pose(self, time: Array) -> tuple[Array, Array]:
        """Positions p and matrices R at times, one of each motion, shape (..., n)."""
        t = time[..., None]
        q, angles = (x[0] + t * x[1] + 0.5 * t**2 * x[2] for x in (self.points, self.angles))
        matrix = rotation(*np.moveaxis(angles, -1, 0))
        off = constraint(self.machines, q, matrix)
        return q + off[..., None] * turned(matrix, self.machines.axis), matrix

    def lengths(self, time: Array) -> Array:
        """Limb lengths at times."""
        return limb_lengths(self.machines, *self.pose(time))

    def steps(self) -> Array:
        """Give steps, short against the times in which a limb or an angle changes by itself."""
        now = np.zeros(self.points.shape[1:-1])
        tiny = np.full_like(now, 1e-4)
        speeds = derivatives(lambda t: limb_vectors(self.machines, *self.pose(t)), tiny)[0]
        shortest = self.lengths(now).min(axis=-1) / np.linalg.norm(speeds, axis=-1).max(axis=-1)
        return np.asarray(0.01 * np.minimum(1.0, shortest))

    def twists(self) -> tuple[Array, Array]:
        """Twists (v, ω) and accelerations (a, ε) at t = 0, by differences."""
        step = self.steps()
        linear = derivatives(lambda t: self.pose(t)[0], step)
        first, second = derivatives(lambda t: self.pose(t)[1], step)
        back = self.pose(np.zeros_like(step))[1].swapaxes(-1, -2)
        # Ṙ Rᵀ is the cross product with ω, R̈ Rᵀ that with ε and twice that with ω
        spin = first @ back
        bend = second @ back - spin @ spin
        return tuple(
            np.concatenate(
                [
                    straight,
                    np.stack([each[..., 2, 1], each[..., 0, 2], each[..., 1, 0]], axis=-1),
                ],
                axis=-1,
            )
            for straight, each in zip(linear, (spin, bend), strict=True)
        )  # type: ignore[return-value]


# --------------------------------------------------------------------------------------------------
# Reference values of the tests
# --------------------------------------------------------------------------------------------------

REFERENCE = Path(__file__).parent / "baselines" / "pentapod_reference.json"

#: Designs and tasks that differ in everything the atlas may choose.
CASES: dict[str, tuple[float, float, dict[str, float | bool]]] = {
    "standard": (0.8, 0.3, {}),
    "small platform": (0.9, 0.15, {}),
    "wide platform": (0.5, 1.2, {}),
    "wide base": (1.9, 0.6, {}),
    "own length": (1.1, 0.45, {"platform_radius_as_length": True}),
    "long length": (0.7, 0.9, {"characteristic_length": 1.0}),
    "wide limits": (
        1.0,
        0.4,
        {
            "limb_min": 0.3,
            "limb_max": 3.0,
            "base_joint_limit": 180.0,
            "platform_joint_limit": 180.0,
            "alpha_min": -180.0,
            "alpha_max": 180.0,
        },
    ),
    "narrow limits": (
        0.9,
        0.5,
        {
            "limb_min": 0.92,
            "limb_max": 1.08,
            "base_joint_limit": 15.0,
            "platform_joint_limit": 12.0,
            "alpha_min": -10.0,
            "alpha_max": 8.0,
        },
    ),
    "tilted axis": (0.8, 0.4, {"axis_angle": 40.0}),
    "tilted back": (1.2, 0.3, {"axis_angle": -25.0, "position_angle": 10.0}),
    "offset": (0.9, 0.35, {"offset": -0.6, "base_angle": 30.0, "position_angle": -20.0}),
    "no rotation": (
        0.8,
        0.3,
        {"beta_min": 0.0, "beta_max": 0.0, "gamma_min": 0.0, "gamma_max": 0.0},
    ),
    "one height": (1.0, 0.3, {"z_min": 1.1, "z_max": 1.1, "beta_min": 5.0, "beta_max": 25.0}),
    "wide box": (
        0.6,
        0.25,
        {
            "x_min": -0.6,
            "x_max": 0.6,
            "y_min": -0.6,
            "y_max": 0.6,
            "z_min": 0.5,
            "z_max": 1.5,
            "alpha_min": -90.0,
            "alpha_max": 90.0,
            "beta_min": -40.0,
            "beta_max": 40.0,
            "gamma_min": -40.0,
            "gamma_max": 40.0,
        },
    ),
    "far box": (0.8, 0.3, {"x_min": 0.3, "x_max": 0.6, "y_min": 0.2, "y_max": 0.5}),
}
THRESHOLDS = (0.015, 0.025)


def reference(name: str, scale: int) -> dict[str, list[float]]:
    """Evaluate one of the cases with a number of points; value and standard error."""
    r_a, r_b, options = CASES[name]
    task = Task(**options)  # type: ignore[arg-type]
    found = box_indices(task, r_a, r_b, THRESHOLDS, points=scale * 4096, shifts=32)
    found["workspace_volume"] = workspace_volume(task, r_a, r_b, points=scale * 2**15, shifts=32)
    worst = extremes(task, r_a, r_b, points=20000, starts=8)
    return {
        **{key: list(value) for key, value in found.items()},
        **{key: [value, 0.0] for key, value in worst._asdict().items()},
    }


def read_reference_file() -> dict[str, Found]:
    """Read the reference values: case to name to value and standard error, NaN where none."""
    cases = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return {
        case: {
            name: tuple(math.nan if each is None else float(each) for each in pair)
            for name, pair in values.items()
        }
        for case, values in cases.items()
    }


def main() -> None:
    """Write the reference values; ten minutes."""
    cases = {
        case: {
            name: [None if math.isnan(each) else each for each in pair]
            for name, pair in reference(case, 16).items()
        }
        for case in CASES
    }
    REFERENCE.write_text(json.dumps(cases, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
