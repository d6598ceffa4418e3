"""The manipulator with a passive leg in obvious NumPy, and a reference of its indices.

Nothing is imported from the package, and no formula of it is used: joints and links are vectors in
x and y, elbows come from ``atan2`` and ``acos``, the Jacobian matrices are those printed. There are
two evaluations of one design in one mode pair:

``grid_indices``
    Dense cells in length and angle of the passive leg, connected components by labelling. Three to
    four digits.
``reference_indices``
    Columns of constant angle, exact to eight digits and more, with error estimates; some seconds.

Conventions. R = 1; base joints B1 = (1, 0) and B2 = (-1, 0); the passive leg stands on O, has the
length l and the angle θ, C = l w with w = (-sin θ, cos θ); platform joints b1 = C + r u and
b2 = C - r u with u = (cos θ, sin θ). Leg i closes with the lower link l_a from B_i to d_i and the
upper link l_b from d_i to b_i. A mode pair is written ``"+-/up"``. Sign i of the working mode is
the root in Eq. 6, "+" the clockwise elbow for the directed line from B_i to b_i: "+-" has both
elbows outward (Fig. 1). "up" is det J_x < 0. At a regular pose of the standard configuration both
upper links point up, and det J_x is negative.

Regions. Reachable: l > 0, abs(θ) <= theta_limit, and both legs reach. Usable: of the parts of it,
connected in the plane of l and θ, where det J_x has the sign of the mode and, with
``passive_joint_limits``, both upper links keep below the platform's line (n_i · w > 0 for
n_i = b_i - d_i), the one of the largest planar area; of two mirror images that with θ < 0. A
boundary where det J_x = 0 makes the global manipulability index infinite, for it is the mean of
1/abs(det J_x) times something that does not vanish there.

Two measures. Planar area dA = l dl dθ; names ending in ``_l_theta`` are those in dl dθ.

References
----------
Nam, Park, "Kinematics and Optimization of 2-DOF Parallel Manipulator with Revolute Actuators and a
Passive Leg", Journal of Mechanical Science and Technology 20 (2006) 828-839.
"""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from reference import NODES, find_roots, gauss_kronrod, golden_maxima
from scipy import ndimage, optimize

Array = NDArray[np.float64]
Index = NDArray[np.int_]
Mask = NDArray[np.bool_]

MODE_PAIRS = tuple(f"{w}/{a}" for w in ("+-", "-+", "++", "--") for a in ("up", "down"))

EPS = float(np.finfo(float).eps)


# --------------------------------------------------------------------------------------------------
# Kinematics in x and y
# --------------------------------------------------------------------------------------------------


class Machine(NamedTuple):
    """A design in a mode pair."""

    r: float
    l_a: float
    l_b: float
    signs: tuple[int, int]  # of the working mode
    assembly: int  # +1 "up", -1 "down"
    limited: bool  # whether upper links keep below the platform's line

    @property
    def longest(self) -> float:
        """Upper bound of the length of the passive leg."""
        return self.l_a + self.l_b + self.r + 1.0


def machine(r: float, l_a: float, l_b: float, mode: str, limited: bool) -> Machine:
    """Read a mode pair such as ``"+-/up"``."""
    if mode not in MODE_PAIRS:
        raise ValueError(f"mode is {mode!r}, must be one of {', '.join(MODE_PAIRS)}")
    working, assembly = mode.split("/")
    first, second = (1 if sign == "+" else -1 for sign in working)
    up = 1 if assembly == "up" else -1
    return Machine(float(r), float(l_a), float(l_b), (first, second), up, limited)


def cross(a: Array, b: Array) -> Array:
    """Plane cross product of vectors stored along the last axis."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def dot(a: Array, b: Array) -> Array:
    """Scalar product of vectors stored along the last axis."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]


def base_joints() -> tuple[Array, Array]:
    """Give the fixed joints B1 and B2."""
    return np.array([1.0, 0.0]), np.array([-1.0, 0.0])


def platform_axes(theta: ArrayLike) -> tuple[Array, Array]:
    """Give u along the platform and w along the passive leg, xy along the last axis."""
    c, s = np.cos(theta), np.sin(theta)
    return np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)


def platform_joints(r: float, length: ArrayLike, theta: ArrayLike) -> tuple[Array, Array]:
    """Give b1 and b2 of a pose, xy along the last axis."""
    length, theta = np.broadcast_arrays(np.asarray(length, float), np.asarray(theta, float))
    u, w = platform_axes(theta)
    middle = length[..., None] * w
    return middle + r * u, middle - r * u


def reached(m: Machine, length: ArrayLike, theta: ArrayLike) -> Mask:
    """Tell whether both legs reach a pose."""
    inside: Any = True
    for b, foot in zip(platform_joints(m.r, length, theta), base_joints(), strict=True):
        reach = np.hypot(*np.moveaxis(b - foot, -1, 0))
        inside &= (abs(m.l_a - m.l_b) <= reach) & (reach <= m.l_a + m.l_b)
    return np.asarray(inside)


def inverse_kinematics(m: Machine, length: ArrayLike, theta: ArrayLike) -> tuple[Array, Array]:
    """Input angles of a pose in a working mode.

    The law of cosines in the triangle B_i d_i b_i, which solves Eqs. 2 and 3 without the half-angle
    substitution of Eqs. 4 to 6. Radians, not reduced to one turn; a leg out of reach is taken as
    stretched or folded, so that boundaries found to rounding do no harm.
    """
    angles = []
    joints = zip(platform_joints(m.r, length, theta), base_joints(), m.signs, strict=True)
    for b, foot, sign in joints:
        v = b - foot
        reach = np.hypot(v[..., 0], v[..., 1])
        with np.errstate(invalid="ignore", divide="ignore"):
            cosine = ((m.l_a - m.l_b) * (m.l_a + m.l_b) / reach + reach) / (2.0 * m.l_a)
        # a leg of no length, l_a = l_b, may point anywhere
        cosine = np.where(reach > 0.0, np.clip(cosine, -1.0, 1.0), 0.0)
        angles.append(np.arctan2(v[..., 1], v[..., 0]) - sign * np.arccos(cosine))
    return angles[0], angles[1]


class Pose(NamedTuple):
    """What the vector equations say of poses in a working mode; shapes are those of the poses."""

    q1: Array  # n_i · w, how far the upper links keep below the platform's line
    q2: Array
    det_q: tuple[Array, Array]  # diagonal of J_q (Eq. 19)
    rows: tuple[Array, Array]  # rows of l J_x (Eq. 20 times l), xy along the last axis
    det_x: Array  # l det J_x (Eq. 24 but for a factor)


def pose(m: Machine, length: ArrayLike, theta: ArrayLike) -> Pose:
    """Evaluate Eqs. 16 to 20; l J_x instead of J_x, which has a pole at l = 0."""
    length, theta = np.broadcast_arrays(np.asarray(length, float), np.asarray(theta, float))
    u, w = platform_axes(theta)
    links, diagonal, rows = [], [], []
    joints = zip(
        platform_joints(m.r, length, theta),
        base_joints(),
        inverse_kinematics(m, length, theta),
        (1.0, -1.0),
        strict=True,
    )
    for b, foot, phi, side in joints:
        lower = m.l_a * np.stack([np.cos(phi), np.sin(phi)], axis=-1)
        n = b - foot - lower
        links.append(n)
        # l_a (-X sin φ + Y cos φ)
        diagonal.append(cross(lower, n))
        # X + Z cos θ and Y + Z sin θ with Z = r n·w / (-l)
        rows.append(length[..., None] * n - side * m.r * dot(n, w)[..., None] * u)
    q1, q2 = (dot(n, w) for n in links)
    # Expanded; the cross product of the rows would cancel where l is small.
    det_x = length * cross(links[0], links[1]) - 2.0 * m.r * q1 * q2
    return Pose(q1, q2, (diagonal[0], diagonal[1]), (rows[0], rows[1]), det_x)


def jacobian(m: Machine, length: ArrayLike, theta: ArrayLike) -> Array:
    """Jacobian J = inv(J_q) J_x of Eq. 21, from the velocity of C to the input rates.

    Shape (..., 2, 2); not finite where J_q is singular or the passive leg has no length.
    """
    p = pose(m, length, theta)
    length = np.asarray(length, float)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):
        rows = [
            row / (length * diagonal[..., None])
            for row, diagonal in zip(p.rows, p.det_q, strict=True)
        ]
    return np.stack(rows, axis=-2)


def conditioning(m: Machine, length: ArrayLike, theta: ArrayLike) -> tuple[Array, Array]:
    """LCI, σ_min/σ_max of J in the 2-norm, and manipulability, abs(det J_q / det J_x).

    With J = [[a, b], [c, d]] the singular values are the half sum and the half difference of
    hypot(a + d, c - b) and hypot(a - d, c + b). The LCI is zero at any singularity, the
    manipulability zero where J_q and infinite where J_x is singular.
    """
    p = pose(m, length, theta)
    j1, j2 = p.det_q
    # J times l det J_q, which is finite and has the same LCI
    a, b = np.moveaxis(p.rows[0] * j2[..., None], -1, 0)
    c, d = np.moveaxis(p.rows[1] * j1[..., None], -1, 0)
    largest = np.hypot(a + d, c - b) + np.hypot(a - d, c + b)
    det_q = np.abs(j1 * j2)
    with np.errstate(invalid="ignore", divide="ignore"):
        lci = 4.0 * np.abs(length) * np.abs(p.det_x) * det_q / largest**2
        manipulability = det_q * np.abs(length) / np.abs(p.det_x)
    return np.where(largest > 0.0, lci, 0.0), manipulability


def permitted(m: Machine, length: ArrayLike, theta: ArrayLike) -> Mask:
    """Tell where a pose in reach is regular, of the right assembly mode and within limits."""
    p = pose(m, length, theta)
    inside = -m.assembly * p.det_x > 0.0
    if m.limited:
        inside &= (p.q1 > 0.0) & (p.q2 > 0.0)
    return np.asarray(inside)


def physical_size(r: float, l_a: float, l_b: float) -> float:
    """S of Eq. 30, the size of the mechanism with stretched legs; NaN if it has none."""
    squared = (l_a + l_b) ** 2 - (1.0 - r) ** 2
    return (r + 1.0) * math.sqrt(squared) if squared > 0.0 else math.nan


# --------------------------------------------------------------------------------------------------
# Dense cells
# --------------------------------------------------------------------------------------------------


class Cells(NamedTuple):
    """Centres of cells in length and angle, and their sizes."""

    length: Array  # shape (n, 1)
    theta: Array  # shape (2 n,)
    planar: Array  # l dl dθ, shape (n, 1)
    flat: float  # dl dθ


def cells_of(m: Machine, limit: float, n: int) -> Cells:
    """Cells, n lengths by 2 n angles, of the box around the reachable workspace.

    With as many angles as lengths, parts that touch in a point at l = 0 may look like one.
    """
    # no pose has l + abs(sin θ) > l_a + l_b
    step, turn = (m.l_a + m.l_b) / n, limit / n
    length = (step * (np.arange(n) + 0.5))[:, None]
    theta = turn * (np.arange(2 * n) + 0.5 - n)
    return Cells(length, theta, length * step * turn, step * turn)


def usable_mask(m: Machine, cells: Cells) -> tuple[Mask, Mask]:
    """Reachable and usable workspace on cells, each indexed ``[length, theta]``."""
    reachable = reached(m, cells.length, cells.theta)
    labels, count = ndimage.label(reachable & permitted(m, cells.length, cells.theta))
    if count == 0:
        return reachable, np.zeros_like(reachable)
    weights = np.broadcast_to(cells.planar, labels.shape).ravel()
    areas = np.bincount(labels.ravel(), weights)
    areas[0] = 0.0
    turned = np.bincount(labels.ravel(), weights * np.tile(cells.theta, cells.length.size))
    # of components of one size the one most to the right
    ties = np.nonzero(areas > areas.max() * (1.0 - 1e-9))[0]
    return reachable, np.asarray(labels == ties[np.argmin(turned[ties])])


def meets_singularity(m: Machine, cells: Cells, reachable: Mask, usable: Mask) -> bool:
    """Tell whether det J_x changes its sign between a usable cell and a neighbour within limits."""
    p = pose(m, cells.length, cells.theta)
    beyond = reachable & (-m.assembly * p.det_x < 0.0)
    if m.limited:
        beyond &= (p.q1 > 0.0) & (p.q2 > 0.0)
    return bool((ndimage.binary_dilation(usable) & beyond).any())


def _sum_and_mean(weight: Array, value: Array, region: Mask) -> tuple[float, float, float, float]:
    """Area of cells with its error, and the mean of a value over them with its error.

    The errors are what comes of a third of a cell that is wrong at random all along the border.
    """
    share, value = weight[region], value[region]
    border = (region & ~ndimage.binary_erosion(region))[region]
    total = float(share.sum())
    if total == 0.0:
        return 0.0, 0.0, math.nan, math.nan
    mean = float(share @ value) / total
    doubt = share[border], share[border] * (value[border] - mean) / total
    area_error, error = (0.3 * math.sqrt(float(each @ each)) for each in doubt)
    return total, area_error, mean, error


def _of_cells(
    m: Machine, limit: float, thresholds: Sequence[float], n: int
) -> dict[str, tuple[float, float]]:
    """Every quantity, and what is known of its error from one grid."""
    cells = cells_of(m, limit, n)
    reachable, usable = usable_mask(m, cells)
    lci, manipulability = conditioning(m, cells.length, cells.theta)
    singular = meets_singularity(m, cells, reachable, usable)
    regions = [("usable_workspace_area", "gci", "gmi", usable)]
    for t in thresholds:
        names = _names_of(t)
        regions.append((*names, usable & (lci >= t)))
    found = {}
    for suffix, size in (("", cells.planar), ("_l_theta", np.full_like(cells.planar, cells.flat))):
        weight = np.broadcast_to(size, lci.shape)
        found[f"workspace_area{suffix}"] = _sum_and_mean(weight, lci, reachable)[:2]
        for area, gci, gmi, region in regions:
            for name, value in ((gci, lci), (gmi, manipulability)):
                total, area_error, mean, error = _sum_and_mean(weight, value, region)
                found[area + suffix] = total, area_error
                found[name + suffix] = mean, error
        if singular:
            found[f"gmi{suffix}"] = math.inf, 0.0
    found["max_lci"] = math.nan, math.nan
    if usable.any():
        at = np.unravel_index(np.argmax(np.where(usable, lci, -1.0)), lci.shape)
        # the apex of a cone may be half a cell away, each way
        around = np.pad(lci, 1, mode="edge")[at[0] : at[0] + 3, at[1] : at[1] + 3]
        slopes = np.abs(np.diff(around[:, 1])).max() + np.abs(np.diff(around[1])).max()
        found["max_lci"] = float(lci[at]), float(slopes)
    return found


def grid_indices(
    r: float,
    l_a: float,
    l_b: float,
    mode: str = "+-/up",
    *,
    theta_limit: float = 90.0,
    passive_joint_limits: bool = True,
    thresholds: Sequence[float] = (),
    n: int = 1000,
) -> dict[str, float]:
    """Evaluate one design in one mode pair from dense cells.

    Parameters
    ----------
    r, l_a, l_b : float
        Platform, lower and upper link, with R = 1.
    mode : str
        Mode pair, such as ``"+-/up"``.
    theta_limit : float
        Largest angle of the passive leg in degrees, at most 90.
    passive_joint_limits : bool
        Whether both upper links have to keep below the platform's line.
    thresholds : sequence of float
        LCI thresholds of the good-condition workspace.
    n : int
        Lengths; there are twice as many angles.

    Returns
    -------
    dict
        The keys of `reference_indices`, without ``runner_up_area``. Error estimates are three
        times the largest difference from three coarser grids. Slivers and necks thinner than a cell
        are beyond it, and so are singularities closer than a cell to another boundary.
    """
    m = machine(r, l_a, l_b, mode, passive_joint_limits)
    limit = math.radians(theta_limit)
    # the quotients are not those of small numbers, lest boundaries meet all grids alike
    fine, *coarse = (
        _of_cells(m, limit, thresholds, k) for k in (n, round(0.73 * n), round(0.61 * n), n // 2)
    )
    result = {}
    for name, (value, doubt) in fine.items():
        result[name] = value
        others = [other[name][0] for other in coarse]
        spread = 0.0 if math.isinf(value) else max(abs(value - other) for other in others)
        result[f"{name}_error"] = max(doubt, 3.0 * spread)
    _add_utilisation(result, physical_size(r, l_a, l_b))
    return result


def _names_of(threshold: float) -> tuple[str, str, str]:
    """Names of area and means over the part with an LCI of a threshold."""
    area, gci, gmi = (f"good_condition_{name}_{threshold:g}" for name in ("area", "gci", "gmi"))
    return area, gci, gmi


def _add_utilisation(result: dict[str, Any], size: float) -> None:
    """Add usable area over physical size (Eq. 30), in both measures, with errors."""
    for suffix in ("", "_l_theta"):
        for end in ("", "_error"):
            area = result[f"usable_workspace_area{suffix}{end}"]
            result[f"space_utilisation{suffix}{end}"] = area / size


# --------------------------------------------------------------------------------------------------
# Reference: columns of constant angle
# --------------------------------------------------------------------------------------------------

# What bounds an interval of lengths. Of two curves of one leg at one place the first is taken.
ZERO, OUTER1, OUTER2, INNER1, INNER2, LEVEL1, LEVEL2, SINGULAR = range(8)
#: Intervals of lengths that are shorter are rounding.
SHORTEST = 1e-13
#: Strips of angles that are narrower are rounding, where several curves meet.
NARROWEST = 1e-10
#: Parts that hang together over less are two.
THINNEST = 1e-7
#: With l_b - l_a = R - r the curves of `candidates` meet at l = θ = 0, where rounding decides on
#: their order. Columns closer to the axis are taken to be those at this angle, an error of its
#: square.
CORE = 1e-6


class Column(NamedTuple):
    """Usable lengths at one angle, of all components."""

    kinds: tuple[tuple[int, int], ...]  # what bounds each interval below and above
    low: Array
    high: Array


class Settings(NamedTuple):
    """How finely to look, and how exactly to integrate."""

    columns: int  # over the whole range of angles
    samples: int  # along an interval of lengths
    rtol: float


def cluster(t: ArrayLike) -> Array:
    """Map [0, 1] onto itself so that square roots at both ends become polynomials."""
    t = np.asarray(t, float)
    return t * t * (3.0 - 2.0 * t)


def rounding(theta: Array) -> Array:
    """Lengths that are nothing but rounding; more next to the axis, where l_a - l_b = r - R."""
    return np.maximum(SHORTEST, 1e-15 / np.abs(theta))


def candidates(m: Machine, theta: Array) -> tuple[Array, Array]:
    """Lengths at which a leg may be stretched or folded, or an upper link along the platform.

    Each is one at which a point of the platform's line is on a circle around B_i: b_i on those of
    radius l_a + l_b and abs(l_a - l_b), b_i + l_b u and b_i - l_b u, where d_i would be, on that of
    radius l_a. With the angle given each is the root of a quadratic equation in the length.

    Returns
    -------
    length, kind : ndarray
        Shape (n, k), by rising length, NaN where there is none; at first a length of zero.
    """
    u, w = platform_axes(theta)
    lengths, kinds = [np.zeros_like(theta)], [ZERO]
    for leg, foot in enumerate(base_joints()):
        side = 1.0 - 2.0 * leg
        curves = [
            (side * m.r, m.l_a + m.l_b, (OUTER1, OUTER2)[leg]),
            (side * m.r, abs(m.l_a - m.l_b), (INNER1, INNER2)[leg]),
            (side * m.r + m.l_b, m.l_a, (LEVEL1, LEVEL2)[leg]),
            (side * m.r - m.l_b, m.l_a, (LEVEL1, LEVEL2)[leg]),
        ]
        for along, radius, kind in curves:
            start = along * u - foot
            middle = -dot(start, w)
            with np.errstate(invalid="ignore"):
                half = np.sqrt((radius - cross(start, w)) * (radius + cross(start, w)))
            lengths += [middle - half, middle + half]
            kinds += [kind, kind]
    length = np.stack(lengths, axis=1)
    length[:, 1:][length[:, 1:] <= rounding(theta)[:, None]] = np.nan
    order = np.argsort(length, axis=1, kind="stable")
    return np.take_along_axis(length, order, axis=1), np.array(kinds)[order]


def sign_changes(
    f: Callable[[Index, Array], Array], low: Array, high: Array, samples: int
) -> tuple[Index, Array]:
    """Where f changes its sign on intervals, also twice between two samples.

    Parameters
    ----------
    f : callable
        Of indices of intervals and places on them, arrays of one shape.
    low, high : ndarray
        Ends of the intervals, shape (n,).
    samples : int
        Samples on each interval; the extrema between them that are closest to zero are found.

    Returns
    -------
    row, place : ndarray
        Interval and place of each change, by rising interval, then place.
    """
    n = low.size
    t = np.tile(cluster(np.linspace(0.0, 1.0, samples)), (n, 1))
    x = low[:, None] + (high - low)[:, None] * t
    row = np.broadcast_to(np.arange(n)[:, None], x.shape)
    value = f(row, x)
    towards = np.abs(value)
    left, middle, right = towards[:, :-2], towards[:, 1:-1], towards[:, 2:]
    # worth following if a multiple of what a parabola adds would reach zero
    dip = (middle <= left) & (middle <= right) & (3.0 * middle < left + right)
    dip &= np.sign(value[:, 2:]) == np.sign(value[:, :-2])
    i, j = np.nonzero(dip)
    j += 1
    if i.size:
        side = np.sign(value[i, j])
        lowest, _ = golden_maxima(lambda y: -side * f(i, y), x[i, j - 1], x[i, j + 1], 30)
        x = np.concatenate([x.ravel(), lowest])
        row = np.concatenate([row.ravel(), i])
        order = np.lexsort((x, row))
        x, row = x[order], row[order]
        value = f(row, x)
    x, row, value = x.ravel(), row.ravel(), value.ravel()
    k = np.nonzero((row[1:] == row[:-1]) & ((value[1:] > 0.0) != (value[:-1] > 0.0)))[0]
    row = row[k]
    if not row.size:
        return row, x[k]
    return row, find_roots(lambda y: f(row, y), x[k], x[k + 1], value[k], value[k + 1])


def columns(m: Machine, theta: Array, samples: int) -> list[Column]:
    """Usable lengths at each of some angles."""
    length, kind = candidates(m, theta)
    low, high = length[:, :-1], length[:, 1:]
    with np.errstate(invalid="ignore"):
        wide = high - low > SHORTEST
    i, j = np.nonzero(wide)
    middle = (low[i, j] + high[i, j]) / 2.0
    at = pose(m, middle, theta[i])
    fits = reached(m, middle, theta[i])
    if m.limited:
        fits &= (at.q1 > 0.0) & (at.q2 > 0.0)
    i, j = i[fits], j[fits]
    low, high = low[i, j], high[i, j]
    below, above = kind[i, j], kind[i, j + 1]

    def signed(row: Index, at: Array) -> Array:
        return -m.assembly * pose(m, at, theta[i[row]]).det_x

    row, root = sign_changes(signed, low, high, samples)
    # a change at an end itself is rounding, as at l = 0 with r = l_a = l_b = 1
    least = rounding(theta[i[row]])
    inner = (root - low[row] > least) & (high[row] - root > least)
    row, root = row[inner], root[inner]
    # from every end and root to the next one
    owner = np.concatenate([np.arange(i.size), row, np.arange(i.size)])
    cut = np.concatenate([low, root, high])
    name = np.concatenate([below, np.full(row.size, SINGULAR), above])
    order = np.lexsort((cut, owner))
    owner, cut, name = owner[order], cut[order], name[order]
    k = np.nonzero((owner[1:] == owner[:-1]) & (cut[1:] - cut[:-1] > SHORTEST))[0]
    k = k[signed(owner[k], (cut[k] + cut[k + 1]) / 2.0) > 0.0]
    found: list[list[tuple[float, float, int, int]]] = [[] for _ in theta]
    for column, a, b, first, last in zip(
        i[owner[k]], cut[k], cut[k + 1], name[k], name[k + 1], strict=True
    ):
        pieces = found[column]
        # candidates that are none in this working mode part nothing
        if pieces and pieces[-1][1] == a and SINGULAR not in (first, pieces[-1][3]):
            start, _, before, _ = pieces.pop()
            pieces.append((start, float(b), before, int(last)))
        else:
            pieces.append((float(a), float(b), int(first), int(last)))
    return [
        Column(
            tuple((piece[2], piece[3]) for piece in pieces),
            np.array([piece[0] for piece in pieces]),
            np.array([piece[1] for piece in pieces]),
        )
        for pieces in found
    ]


@dataclass(frozen=True)
class Strip:
    """Angles between which the same curves bound the usable lengths, in the same order."""

    left: float
    right: float
    first: Column  # just inside the left end
    last: Column  # just inside the right end

    @property
    def number(self) -> int:
        """How many intervals of lengths there are."""
        return len(self.first.kinds)

    def place(self, t: Array) -> Array:
        """Angle at t in [0, 1], clustered at both ends, and no closer than CORE to the axis."""
        theta = self.left + (self.right - self.left) * cluster(t)
        return np.where(np.abs(theta) < CORE, CORE * np.sign(self.left + self.right), theta)


def angles_to_look_at(m: Machine, limit: float, number: int) -> Array:
    """Angles from -limit to limit at which to look for changes.

    Evenly spaced ones, and ones on both sides of those at which a quadratic equation of
    `candidates` gets or loses its solutions, or one at which a leg may have no length.
    """
    places = np.array([m.r])
    for along, radius in ((m.r, m.l_a + m.l_b), (m.r, m.l_a - m.l_b)):
        places = np.append(places, [along - radius, along + radius])
    for along in (m.r + m.l_b, m.r - m.l_b):
        places = np.append(places, [along - m.l_a, along + m.l_a])
    special = np.arccos(places[np.abs(places) <= 1.0])
    special = np.concatenate([special, -special, [0.0]])
    near = np.concatenate([special + shift for shift in (-1e-3, -1e-6, 1e-6, 1e-3)])
    even = limit * (2.0 * (np.arange(number) + 0.5) / number - 1.0)
    ends = limit * np.array([-1.0, 1.0]) * (1.0 - 1e-9)
    theta = np.unique(np.concatenate([even, near, ends, [-CORE, CORE]]))
    return theta[(np.abs(theta) < limit) & (np.abs(theta) >= CORE)]


def find_changes(
    m: Machine, theta: Array, seen: Sequence[Column], samples: int
) -> list[tuple[float, Column, float, Column]]:
    """Halve brackets in which the kinds of ends change.

    Returns
    -------
    list
        The angle before and the one after each change, each with its column, by rising angle.
    """
    changes = []
    brackets = [
        (a, one, b, other)
        for (a, one), (b, other) in pairwise(zip(theta.tolist(), seen, strict=True))
        if one.kinds != other.kinds
    ]
    while brackets:
        a = np.array([bracket[0] for bracket in brackets])
        b = np.array([bracket[2] for bracket in brackets])
        before = [bracket[1] for bracket in brackets]
        after = [bracket[3] for bracket in brackets]
        for _ in range(55):
            middle = (a + b) / 2.0
            for k, here in enumerate(columns(m, middle, samples)):
                if here.kinds == before[k].kinds:
                    a[k], before[k] = middle[k], here
                else:
                    b[k], after[k] = middle[k], here
        found = list(zip(a.tolist(), before, b.tolist(), after, strict=True))
        changes += found
        # another change between the one found and the end of the bracket
        brackets = [
            (change[2], change[3], bracket[2], bracket[3])
            for change, bracket in zip(found, brackets, strict=True)
            if change[3].kinds != bracket[3].kinds and bracket[2] - change[2] > 1e-12
        ]
    return sorted(changes, key=lambda change: change[0])


def pinches(m: Machine, theta: Array, seen: Sequence[Column], samples: int) -> Array:
    """Angles at which an interval of lengths shrinks to nothing and grows again.

    So do those from l = 0 in the working modes "++" and "--", where both upper links are along the
    platform: at l = 0 the mechanism is its own image turned by 180 degrees.
    """
    found = []
    for k in range(1, len(seen) - 1):
        kinds = seen[k].kinds
        if not kinds or seen[k - 1].kinds != kinds or seen[k + 1].kinds != kinds:
            continue
        left, middle, right = (each.high - each.low for each in seen[k - 1 : k + 2])
        for j in np.nonzero((middle <= left) & (middle <= right) & (3 * middle < left + right))[0]:

            def thinness(x: Array, j: int = int(j), kinds: object = kinds) -> Array:
                widths = [
                    each.high[j] - each.low[j] if each.kinds == kinds else 0.0
                    for each in columns(m, x, samples)
                ]
                return -np.array(widths)

            place, thin = golden_maxima(thinness, theta[k - 1 : k], theta[k + 1 : k + 2], 60)
            if thin[0] > -THINNEST:
                found.append(float(place[0]))
    return np.array(sorted(found))


def strips_of(m: Machine, limit: float, theta: Array, samples: int) -> list[Strip]:
    """Cut the range of angles at changes, at pinches, and where integrands have kinks."""
    strips = []
    turn = np.array([math.acos(m.r)] if m.r < 1.0 else [])  # where a leg may have no length
    for sign in (-1.0, 1.0):
        side = theta[np.sign(theta) == sign]
        seen = columns(m, side, samples)
        left, right = sorted([0.0, sign * limit])
        starts, ends = [(left, seen[0])], []
        for a, before, b, after in find_changes(m, side, seen, samples):
            ends.append((a, before))
            starts.append((b, after))
        ends.append((right, seen[-1]))
        cuts = np.concatenate([pinches(m, side, seen, samples), sign * turn])
        for (a, first), (b, last) in zip(starts, ends, strict=True):
            for cut in np.sort(cuts[(cuts > a + 1e-8) & (cuts < b - 1e-8)]):
                before, after = columns(m, cut + np.array([-1e-9, 1e-9]), samples)
                if before.kinds == after.kinds == first.kinds:
                    strips.append(Strip(a, float(cut), first, before))
                    a, first = float(cut), after
            strips.append(Strip(a, b, first, last))
    return [strip for strip in strips if strip.right - strip.left > NARROWEST]


@dataclass(frozen=True)
class Component:
    """A connected part: intervals of lengths, each of a strip."""

    cells: tuple[tuple[int, int], ...]  # strip, and interval in it
    area: float
    turned: float  # integral of θ over it


def components(strips: Sequence[Strip], m: Machine, samples: int) -> list[Component]:
    """Join intervals of neighbouring strips that meet, and give each part its area."""
    starts = np.cumsum([0, *(strip.number for strip in strips)])
    parent = list(range(int(starts[-1])))

    def root(k: int) -> int:
        while parent[k] != k:
            k = parent[k]
        return k

    for n, (left, right) in enumerate(pairwise(strips)):
        one, other = left.last, right.first
        # what shrinks to nothing at the axis is of the order of CORE next to it
        least = 100.0 * CORE if right.left == 0.0 else THINNEST
        for j in range(left.number):
            for k in range(right.number):
                shared = min(one.high[j], other.high[k]) - max(one.low[j], other.low[k])
                if shared > least:
                    parent[root(int(starts[n]) + j)] = root(int(starts[n + 1]) + k)

    area, turned = np.zeros(len(parent)), np.zeros(len(parent))
    node, weight = np.polynomial.legendre.leggauss(24)
    t, weight = (node + 1.0) / 2.0, weight / 2.0
    for n, strip in enumerate(strips):
        width = strip.right - strip.left
        theta = strip.place(t)
        for x, share, column in zip(
            theta, width * weight * 6.0 * t * (1.0 - t), columns(m, theta, samples), strict=True
        ):
            if len(column.kinds) == strip.number:
                piece = share * (column.high**2 - column.low**2) / 2.0
                area[starts[n] : starts[n + 1]] += piece
                turned[starts[n] : starts[n + 1]] += x * piece
    groups: dict[int, list[tuple[int, int]]] = {}
    for n, strip in enumerate(strips):
        for j in range(strip.number):
            groups.setdefault(root(int(starts[n]) + j), []).append((n, j))
    result = []
    for cells in groups.values():
        at = [int(starts[n]) + j for n, j in cells]
        result.append(Component(tuple(cells), float(area[at].sum()), float(turned[at].sum())))
    return sorted(result, key=lambda component: -component.area)


# --------------------------------------------------------------------------------------------------
# Reference: integrals
# --------------------------------------------------------------------------------------------------


def level_pieces(
    m: Machine, theta: Array, low: Array, high: Array, level: float, samples: int
) -> tuple[Index, Array, Array, Mask]:
    """Cut intervals of lengths where the LCI crosses a level.

    Returns
    -------
    row, low, high, good : ndarray
        Interval that each piece is of, its ends, and whether the LCI is at least the level there.
    """
    n = low.size

    def excess(row: Index, length: Array) -> Array:
        return conditioning(m, length, theta[row])[0] - level

    row, root = sign_changes(excess, low, high, samples)
    owner = np.concatenate([np.arange(n), row, np.arange(n)])
    cut = np.concatenate([low, root, high])
    order = np.lexsort((cut, owner))
    owner, cut = owner[order], cut[order]
    k = np.nonzero((owner[1:] == owner[:-1]) & (cut[1:] > cut[:-1]))[0]
    owner, a, b = owner[k], cut[k], cut[k + 1]
    return owner, a, b, np.asarray(excess(owner, (a + b) / 2.0) >= 0.0)


def along_columns(
    m: Machine, theta: Array, low: Array, high: Array, tolerance: Array, finite: bool
) -> tuple[Array, Array]:
    """Integrals along columns of 1, the LCI and the manipulability, times l dl, then times dl.

    Parameters
    ----------
    theta, low, high : ndarray
        Angle and ends of each column, shape (n,).
    tolerance : ndarray
        Of each of the six integrals along a column, absolute.
    finite : bool
        Whether the manipulability has an integral; else it counts as zero.

    Returns
    -------
    value, error : ndarray
        Shape (n, 6).
    """
    n = theta.size
    value, error = np.zeros((n, 6)), np.zeros((n, 6))
    row = np.arange(n)
    a, b = np.zeros(n), np.ones(n)
    for depth in range(45):
        t = a[:, None] + (b - a)[:, None] * NODES
        width = (high - low)[row][:, None]
        # from the nearer end, so that ends keep their digits
        far = t > 0.5
        length = np.where(
            far,
            high[row][:, None] - width * cluster(1.0 - t),
            low[row][:, None] + width * cluster(t),
        )
        lci, manipulability = conditioning(m, length, theta[row][:, None])
        manipulability = np.where(np.isfinite(manipulability) & finite, manipulability, 0.0)
        flat = np.stack([np.ones_like(lci), lci, manipulability], axis=-1)
        flat *= (width * 6.0 * t * (1.0 - t))[..., None]
        both = np.concatenate([flat * length[..., None], flat], axis=-1)
        part, doubt = gauss_kronrod(both, b - a)
        done = np.all(doubt <= tolerance * (b - a)[:, None], axis=1) | (depth == 44)
        np.add.at(value, row[done], part[done])
        np.add.at(error, row[done], doubt[done])
        if done.all():
            break
        middle = ((a + b) / 2.0)[~done]
        row = np.tile(row[~done], 2)
        a, b = np.concatenate([a[~done], middle]), np.concatenate([middle, b[~done]])
    return value, error


def integrals(
    m: Machine,
    strips: Sequence[Strip],
    component: Component,
    thresholds: Sequence[float],
    settings: Settings,
) -> tuple[Array, Array]:
    """Integrals over the usable workspace and the parts of it with an LCI of each threshold.

    Returns
    -------
    value, error : ndarray
        Shape (1 + number of thresholds, 6), as in `along_columns`.
    """
    finite = not is_singular(strips, component)
    cells: dict[int, list[int]] = {}
    for n, j in component.cells:
        cells.setdefault(n, []).append(j)
    # roughly; the tolerance of columns is below that of strips
    tolerance = settings.rtol * max(component.area, 1e-12) * np.ones(6)
    shape = (1 + len(thresholds), 6)
    value, error = np.zeros(shape), np.zeros(shape)
    panels = [(n, 0.0, 1.0) for n in cells]
    for depth in range(40):
        who, at, low, high, theta = [], [], [], [], []
        for k, (n, a, b) in enumerate(panels):
            t = a + (b - a) * NODES
            angles = strips[n].place(t)
            share = (strips[n].right - strips[n].left) * 6.0 * t * (1.0 - t)
            for i, column in enumerate(columns(m, angles, settings.samples)):
                for j in _intervals(column, strips[n], cells[n]):
                    who.append((k, i))
                    at.append(share[i])
                    theta.append(angles[i])
                    low.append(column.low[j])
                    high.append(column.high[j])
        lengths = np.array(low), np.array(high)
        angle, weight = np.array(theta), np.array(at)[:, None]
        panel, node = np.array(who).T
        span = max(float(np.ptp([strips[n].left for n in cells])), 1.0)
        fine = 0.01 * tolerance / span
        summed = np.zeros((len(panels), NODES.size, *shape))
        inner = np.zeros_like(summed)
        one, doubt = along_columns(m, angle, *lengths, fine, finite)
        np.add.at(summed[:, :, 0], (panel, node), weight * one)
        np.add.at(inner[:, :, 0], (panel, node), weight * doubt)
        for level, threshold in enumerate(thresholds, start=1):
            row, a_piece, b_piece, good = level_pieces(
                m, angle, *lengths, threshold, settings.samples
            )
            row, a_piece, b_piece = row[good], a_piece[good], b_piece[good]
            one, doubt = along_columns(m, angle[row], a_piece, b_piece, fine, True)
            np.add.at(summed[:, :, level], (panel[row], node[row]), weight[row] * one)
            np.add.at(inner[:, :, level], (panel[row], node[row]), weight[row] * doubt)
        part, outer = gauss_kronrod(summed, np.array([b - a for _, a, b in panels]))
        within, _ = gauss_kronrod(inner, np.array([b - a for _, a, b in panels]))
        share = np.array([math.sqrt(b - a) for _, a, b in panels])
        done = np.all(outer <= tolerance * share[:, None, None], axis=(1, 2)) | (depth == 39)
        value += part[done].sum(axis=0)
        error += outer[done].sum(axis=0) + within[done].sum(axis=0)
        panels = [
            half
            for (n, a, b), good in zip(panels, done, strict=True)
            if not good
            for half in ((n, a, (a + b) / 2.0), (n, (a + b) / 2.0, b))
        ]
        if not panels:
            break
    return value, error


def _intervals(column: Column, strip: Strip, wanted: Sequence[int]) -> list[int]:
    """Which intervals of a column are those of the strip that are wanted.

    Next to the ends of a strip rounding may join or drop one; then those that overlap the nearest
    known column.
    """
    if column.kinds == strip.first.kinds:
        return list(wanted)
    known = strip.first
    return [
        k
        for k in range(len(column.kinds))
        if any(
            min(column.high[k], known.high[j]) > max(column.low[k], known.low[j]) for j in wanted
        )
    ]


def is_singular(strips: Sequence[Strip], component: Component) -> bool:
    """Tell whether a curve on which det J_x = 0 bounds a component."""
    return any(SINGULAR in strips[n].first.kinds[j] for n, j in component.cells)


def largest_lci(m: Machine, strips: Sequence[Strip], component: Component, samples: int) -> float:
    """Least upper bound of the LCI over a component, found by a simplex from the best samples.

    On the axis, which columns only come close to, it is sought on its own.
    """
    t = cluster((np.arange(40) + 0.5) / 40)
    starts: list[tuple[float, float, float, int, int]] = []
    found = 0.0
    for n, j in component.cells:
        strip = strips[n]
        for x, column in zip(t, columns(m, strip.place(t), samples), strict=True):
            if column.kinds == strip.first.kinds:
                length = column.low[j] + t * (column.high[j] - column.low[j])
                lci = conditioning(m, length, strip.place(np.array([x])))[0]
                best = int(np.argmax(lci))
                starts.append((float(lci[best]), float(x), float(t[best]), n, j))
        for end, column in ((strip.left, strip.first), (strip.right, strip.last)):
            if end == 0.0:
                found = max(found, _largest_on_axis(m, column.low[j], column.high[j]))
    starts.sort(reverse=True)
    for _, x, y, n, j in starts[:3]:
        if found > 1.0 - 1e-9:  # no more than 1
            break
        strip = strips[n]

        def shortfall(place: Array, strip: Strip = strip, j: int = j) -> float:
            share = np.clip(place, 0.0, 1.0)
            theta = strip.place(share[:1])
            (column,) = columns(m, theta, samples)
            if column.kinds != strip.first.kinds:
                return 0.0
            length = column.low[j] + share[1] * (column.high[j] - column.low[j])
            return -float(conditioning(m, length, theta[0])[0])

        simplex = np.array([[x, y], [x + 0.02, y], [x, y + 0.02]])
        least = optimize.minimize(
            shortfall,
            simplex[0],
            method="Nelder-Mead",
            options={"initial_simplex": simplex, "xatol": 1e-9, "fatol": 1e-13, "maxiter": 250},
        )
        found = max(found, -float(least.fun))
    return found


def _largest_on_axis(m: Machine, low: float, high: float) -> float:
    def lci(length: Array) -> Array:
        return conditioning(m, length, np.zeros_like(length))[0]

    length = low + (high - low) * cluster(np.linspace(0.0, 1.0, 400)[1:-1])
    value = lci(length)
    k = int(np.clip(np.argmax(value), 1, length.size - 2))
    a, b = length[k - 1 : k], length[k + 1 : k + 2]
    _, highest = golden_maxima(lci, a, b, 60)
    return max(float(value.max()), float(highest[0]))


def reachable_areas(m: Machine, limit: float) -> Array:
    """Area of the reachable workspace, l dl dθ and dl dθ, by closed forms along each column."""
    places = np.array(
        [m.r - m.l_a - m.l_b, m.r - abs(m.l_a - m.l_b), m.r, m.r + abs(m.l_a - m.l_b)]
    )
    # where a stretched leg is at l = 0, too: r² - 2 r cos θ + 1 = (l_a ± l_b)²
    zeros = (m.r**2 + 1.0 - np.array([m.l_a + m.l_b, m.l_a - m.l_b]) ** 2) / (2.0 * m.r)
    places = np.concatenate([places, zeros])
    turns = np.arccos(places[np.abs(places) <= 1.0])
    edges = np.unique(np.concatenate([[0.0, limit], turns[turns < limit]]))
    node, weight = np.polynomial.legendre.leggauss(200)
    t = (node + 1.0) / 2.0
    total = np.zeros(2)
    for a, b in pairwise(edges):
        theta = a + (b - a) * cluster(t)
        length, _ = candidates(m, theta)
        low, high = length[:, :-1], length[:, 1:]
        with np.errstate(invalid="ignore"):
            inside = (high > low) & reached(m, (low + high) / 2.0, theta[:, None])
        low, high = np.where(inside, low, 0.0), np.where(inside, high, 0.0)
        share = (b - a) * 3.0 * weight * t * (1.0 - t)
        total += 2.0 * np.array(
            [share @ ((high**2 - low**2) / 2.0).sum(axis=1), share @ (high - low).sum(axis=1)]
        )
    return total


def reference_indices(
    r: float,
    l_a: float,
    l_b: float,
    mode: str = "+-/up",
    *,
    theta_limit: float = 90.0,
    passive_joint_limits: bool = True,
    thresholds: Sequence[float] = (),
    rtol: float = 1e-10,
) -> dict[str, Any]:
    """Evaluate one design in one mode pair to many digits.

    Parameters
    ----------
    r, l_a, l_b : float
        Platform, lower and upper link, with R = 1.
    mode : str
        Mode pair, such as ``"+-/up"``.
    theta_limit : float
        Largest angle of the passive leg in degrees, at most 90.
    passive_joint_limits : bool
        Whether both upper links have to keep below the platform's line.
    thresholds : sequence of float
        LCI thresholds of the good-condition workspace.
    rtol : float
        Tolerance of each integral, relative to the usable area.

    Returns
    -------
    dict
        ``workspace_area`` of the reachable workspace; of the usable one ``usable_workspace_area``,
        ``gci``, ``gmi`` and ``space_utilisation``; for each threshold t ``good_condition_area_t``,
        ``good_condition_gci_t`` and ``good_condition_gmi_t``; all these also with the suffix
        ``_l_theta``, and to each of them an ``..._error``. ``max_lci``, a least upper bound.
        ``runner_up_area`` is the area of the second largest part: where it equals the largest, two
        mirror images tie. Means over nothing are NaN.
    """
    m = machine(r, l_a, l_b, mode, passive_joint_limits)
    limit = math.radians(theta_limit)
    runs = [
        _run(m, limit, thresholds, Settings(number, samples, tolerance))
        for number, samples, tolerance in ((500, 97, rtol), (331, 64, 10.0 * rtol))
    ]
    fine, coarse = runs
    result: dict[str, Any] = {}
    for name, (value, doubt) in fine.items():
        other = coarse[name][0]
        result[name] = value
        if value == other or (math.isnan(value) and math.isnan(other)):
            result[f"{name}_error"] = doubt
        else:
            result[f"{name}_error"] = max(doubt, abs(value - other))
    _add_utilisation(result, physical_size(r, l_a, l_b))
    return result


def _run(
    m: Machine, limit: float, thresholds: Sequence[float], settings: Settings
) -> dict[str, tuple[float, float]]:
    """Every quantity with the error that its quadrature estimates."""
    areas = reachable_areas(m, limit)
    strips = strips_of(m, limit, angles_to_look_at(m, limit, settings.columns), settings.samples)
    parts = components(strips, m, settings.samples)
    found = {}
    shape = (1 + len(thresholds), 6)
    value, error = np.zeros(shape), np.zeros(shape)
    singular, highest, runner_up = False, math.nan, 0.0
    if parts:
        ties = [part for part in parts if part.area > parts[0].area * (1.0 - 1e-9)]
        best = min(ties, key=lambda part: part.turned)
        runner_up = parts[1].area if len(parts) > 1 else 0.0
        value, error = integrals(m, strips, best, thresholds, settings)
        singular = is_singular(strips, best)
        highest = largest_lci(m, strips, best, settings.samples)
    names = [("usable_workspace_area", "gci", "gmi"), *(_names_of(t) for t in thresholds)]
    for k, suffix in enumerate(("", "_l_theta")):
        found[f"workspace_area{suffix}"] = float(areas[k]), 1e-13 * float(areas[k])
        for level in range(1 + len(thresholds)):
            area, gci, gmi = names[level]
            total, doubt = value[level, 3 * k], error[level, 3 * k]
            found[area + suffix] = float(total), float(doubt)
            for name, column in ((gci, 1), (gmi, 2)):
                if total <= 0.0:
                    found[name + suffix] = math.nan, math.nan
                elif level == 0 and column == 2 and singular:
                    found[name + suffix] = math.inf, 0.0
                else:
                    mean = value[level, 3 * k + column] / total
                    share = error[level, 3 * k + column] + mean * doubt
                    found[name + suffix] = float(mean), float(share / total)
    found["max_lci"] = highest, 1e-8
    found["runner_up_area"] = runner_up, 1e-9
    return found


# --------------------------------------------------------------------------------------------------
# Reference values on file
# --------------------------------------------------------------------------------------------------

REFERENCE_FILE = Path(__file__).parent / "baselines" / "passive_leg_reference.json"

#: Designs of the file: of l_a = l_b - 1 + r and others, all mode pairs but mirror images.
CASES: tuple[dict[str, Any], ...] = (
    {"design": (1.2, 1.4, 1.2)},
    {"design": (1.2, 1.4, 1.2), "theta_limit": 60.0, "thresholds": (0.5,)},
    {"design": (0.9, 1.1, 1.2), "thresholds": (0.3,)},
    {"design": (1.2, 1.1, 0.9), "thresholds": (0.3, 0.7)},
    {"design": (1.0, 1.0, 1.0)},
    {"design": (2.0, 1.5, 0.5), "passive_joint_limits": False},
    {"design": (0.6, 0.8, 1.2), "theta_limit": 45.0},
    {"design": (1.5, 0.8, 1.3), "thresholds": (0.4,)},
    {"design": (1.5, 0.8, 1.3), "passive_joint_limits": False},
    {"design": (0.7, 1.6, 1.5)},
    {"design": (0.7, 1.6, 1.5), "passive_joint_limits": False},
    {"design": (1.3, 0.9, 1.6), "mode": "+-/down", "passive_joint_limits": False},
    {"design": (0.8, 1.2, 1.0), "mode": "-+/up", "passive_joint_limits": False},
    {"design": (1.4, 0.9, 1.2), "mode": "-+/down", "passive_joint_limits": False},
    {"design": (1.0, 1.7, 1.1), "mode": "++/up"},
    {"design": (1.2, 1.0, 0.8), "mode": "++/up", "passive_joint_limits": False},
    {"design": (0.7, 1.4, 0.9), "mode": "--/down", "passive_joint_limits": False},
)


def options_of(case: dict[str, Any]) -> dict[str, Any]:
    """Everything of a case but the design, as keyword arguments, with the defaults."""
    options: dict[str, Any] = {
        "mode": "+-/up",
        "theta_limit": 90.0,
        "passive_joint_limits": True,
        "thresholds": (),
    }
    return {name: case.get(name, default) for name, default in options.items()}


def write_reference_file(path: Path = REFERENCE_FILE) -> None:
    """Compute all cases and write them; a minute. NaN is null, infinity the text "inf"."""
    cases = []
    for case in CASES:
        options = options_of(case)
        values = {
            name: None if math.isnan(value) else "inf" if math.isinf(value) else value
            for name, value in reference_indices(*case["design"], **options).items()
        }
        cases.append({"design": case["design"], **options, "values": values})
    text = {
        "description": (
            "Computed by tests/naive_passive_leg.py, reference_indices, not printed anywhere; "
            "design: r, l_a, l_b with R = 1; *_error: absolute error estimate"
        ),
        "cases": cases,
    }
    path.write_text(json.dumps(text, indent=1) + "\n")


def read_reference_file(path: Path = REFERENCE_FILE) -> list[dict[str, Any]]:
    """Read the cases back, each with ``design``, the options and ``values``, all floats."""
    cases: list[dict[str, Any]] = json.loads(path.read_text())["cases"]
    for case in cases:
        case["values"] = {
            name: math.nan if value is None else float(value)
            for name, value in case["values"].items()
        }
    return cases


if __name__ == "__main__":
    write_reference_file()
