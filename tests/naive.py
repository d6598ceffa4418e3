"""The five-bar mechanism in obvious NumPy: slow, dense, and independent of the package.

Everything here is written the way a reader would write it first: angles by ``atan2`` and
``acos``, the Jacobian matrices as printed, the conditioning index from a singular value
decomposition, regions as masks on a dense grid, connected components by labelling. Nothing is
imported from the package, so that the two can be compared.

Conventions. ``r1`` is the actuated link, ``r2`` the distal link, ``r3`` half the base, with
``A1 = (-r3, 0)`` and ``A2 = (r3, 0)``. The working mode is ``(s1, s2)``, each +1 or -1, with
``s_i = sign(cross(P - A_i, B_i - A_i))``. The assembly mode is +1 ("up") or -1 ("down"), the sign
of ``det B = cross(P - B1, P - B2)``.

Accuracy. A mask of n x n cells gives areas to about 1/n**1.5 and radii to one cell.

References
----------
Liu, Wang, Zheng, "Optimum design of the 5R symmetrical parallel manipulator with a surrounded and
good-condition workspace", Robotics and Autonomous Systems 54 (2006) 221-233.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def cross(a: Array, b: Array) -> Array:
    """Plane cross product of vectors stored along the last axis."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def base_joints(r3: float) -> tuple[Array, Array]:
    """Give the fixed joints A1 and A2."""
    return np.array([-r3, 0.0]), np.array([r3, 0.0])


def inverse_kinematics(
    r1: float, r2: float, r3: float, x: ArrayLike, y: ArrayLike, s1: int, s2: int
) -> tuple[Array, Array]:
    """Actuator angles of a position in a working mode.

    Parameters
    ----------
    r1, r2, r3 : float
        Actuated link, distal link, half the base.
    x, y : array_like
        Position of P, any common shape.
    s1, s2 : {+1, -1}
        Working mode.

    Returns
    -------
    theta1, theta2 : ndarray
        Angles in radians, not reduced to one turn; NaN out of reach.

    Notes
    -----
    The law of cosines in the triangle A_i B_i P, which solves Eqs. 4 and 5 without the half-angle
    substitution of Eqs. 6 and 7.
    """
    p = np.stack(np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float)), axis=-1)
    angles = []
    for a, s in zip(base_joints(r3), (s1, s2), strict=True):
        v = p - a
        d = np.hypot(v[..., 0], v[..., 1])
        with np.errstate(invalid="ignore", divide="ignore"):
            opening = np.arccos((r1**2 + d**2 - r2**2) / (2 * r1 * d))
        angles.append(np.arctan2(v[..., 1], v[..., 0]) + s * opening)
    return angles[0], angles[1]


def elbows_of_angles(
    r1: float, r3: float, theta1: ArrayLike, theta2: ArrayLike
) -> tuple[Array, Array]:
    """Elbows B1 and B2 from the actuator angles (Eq. 2), xy along the last axis."""
    a1, a2 = base_joints(r3)
    b1 = a1 + r1 * np.stack([np.cos(theta1), np.sin(theta1)], axis=-1)
    b2 = a2 + r1 * np.stack([np.cos(theta2), np.sin(theta2)], axis=-1)
    return b1, b2


def elbows(
    r1: float, r2: float, r3: float, x: ArrayLike, y: ArrayLike, s1: int, s2: int
) -> tuple[Array, Array]:
    """Elbows B1 and B2 of a position in a working mode; NaN out of reach.

    Parameters and shapes as in `inverse_kinematics`; the results carry xy along the last axis.
    """
    return elbows_of_angles(r1, r3, *inverse_kinematics(r1, r2, r3, x, y, s1, s2))


def forward_kinematics(
    r1: float, r2: float, r3: float, theta1: ArrayLike, theta2: ArrayLike, assembly: int
) -> tuple[Array, Array]:
    """Position of P from the actuator angles, as an intersection of two circles.

    Parameters
    ----------
    r1, r2, r3 : float
        Actuated link, distal link, half the base.
    theta1, theta2 : array_like
        Actuator angles in radians.
    assembly : {+1, -1}
        Sign of det B at the wanted intersection.

    Returns
    -------
    x, y : ndarray
        NaN where the circles do not meet, or where the elbows coincide.

    Notes
    -----
    With e the unit vector from B1 to B2, n the same turned by +90 degrees, D = abs(B2 - B1) and
    P = (B1 + B2)/2 + k n, cross(P - B1, P - B2) = k D: the sign of k is the assembly mode.
    """
    b1, b2 = elbows_of_angles(r1, r3, theta1, theta2)
    b12 = b2 - b1
    distance = np.hypot(b12[..., 0], b12[..., 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        k = assembly * np.sqrt(r2**2 - (distance / 2) ** 2) / distance
    x = (b1[..., 0] + b2[..., 0]) / 2 - k * b12[..., 1]
    y = (b1[..., 1] + b2[..., 1]) / 2 + k * b12[..., 0]
    return x, y


def matrix_a(
    r1: float, r3: float, x: ArrayLike, y: ArrayLike, theta1: ArrayLike, theta2: ArrayLike
) -> Array:
    """Matrix A of Eq. 18, shape (..., 2, 2)."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    a11 = y * np.cos(theta1) - (x + r3) * np.sin(theta1)
    a22 = y * np.cos(theta2) + (r3 - x) * np.sin(theta2)
    zero = np.zeros_like(a11)
    return r1 * np.stack([np.stack([a11, zero], -1), np.stack([zero, a22], -1)], -2)


def matrix_b(
    r1: float, r3: float, x: ArrayLike, y: ArrayLike, theta1: ArrayLike, theta2: ArrayLike
) -> Array:
    """Matrix B of Eq. 19, shape (..., 2, 2)."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    b11 = x + r3 - r1 * np.cos(theta1)
    b12 = y - r1 * np.sin(theta1)
    b21 = x - r3 - r1 * np.cos(theta2)
    b22 = y - r1 * np.sin(theta2)
    return np.stack([np.stack([b11, b12], -1), np.stack([b21, b22], -1)], -2)


def det_b(r1: float, r2: float, r3: float, x: ArrayLike, y: ArrayLike, s1: int, s2: int) -> Array:
    """Evaluate det B = cross(P - B1, P - B2), whose sign is the assembly mode; NaN out of reach."""
    b1, b2 = elbows(r1, r2, r3, x, y, s1, s2)
    p = np.stack(np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float)), axis=-1)
    return cross(p - b1, p - b2)


def jacobian(
    r1: float, r2: float, r3: float, x: ArrayLike, y: ArrayLike, s1: int, s2: int
) -> Array:
    """Jacobian J = inv(A) B of Eq. 20, from the velocity of P to the actuator rates.

    Shape (..., 2, 2); NaN out of reach, not finite where A is singular.
    """
    theta1, theta2 = inverse_kinematics(r1, r2, r3, x, y, s1, s2)
    a = matrix_a(r1, r3, x, y, theta1, theta2)
    b = matrix_b(r1, r3, x, y, theta1, theta2)
    with np.errstate(invalid="ignore", divide="ignore"):
        # A is diagonal, so its inverse divides the rows of B.
        return b / np.stack([a[..., 0, 0], a[..., 1, 1]], axis=-1)[..., None]


def lci(r1: float, r2: float, r3: float, x: ArrayLike, y: ArrayLike, s1: int, s2: int) -> Array:
    """Local conditioning index, sigma_min / sigma_max of J in the 2-norm.

    Parameters and shapes as in `inverse_kinematics`. Zero where A is singular, NaN out of reach.
    """
    j = jacobian(r1, r2, r3, x, y, s1, s2).reshape(-1, 2, 2)
    value = np.where(np.isnan(j).all(axis=(1, 2)), np.nan, 0.0)
    finite = np.isfinite(j).all(axis=(1, 2))
    sigma = np.linalg.svd(j[finite], compute_uv=False)
    value[finite] = sigma[:, 1] / sigma[:, 0]
    return value.reshape(np.broadcast(np.asarray(x), np.asarray(y)).shape)


def grid(r1: float, r2: float, r3: float, n: int) -> tuple[Array, Array]:
    """Cell centres, n each way, of the box around the theoretical workspace.

    Returns the abscissae and the ordinates; masks are indexed ``[iy, ix]``.
    """
    reach = r1 + r2
    width = max(reach - r3, 0.0)
    height = np.sqrt(max(reach**2 - r3**2, 0.0))
    t = (2 * np.arange(n) + 1) / n - 1
    return width * t, height * t


def theoretical_workspace_mask(r1: float, r2: float, r3: float, n: int) -> Mask:
    """Cells of `grid` whose centre both legs reach."""
    x, y = np.meshgrid(*grid(r1, r2, r3, n))
    d1 = np.hypot(x + r3, y)
    d2 = np.hypot(x - r3, y)
    low, high = abs(r1 - r2), r1 + r2
    return (low < d1) & (d1 < high) & (low < d2) & (d2 < high)


def usable_workspace_mask(
    r1: float, r2: float, r3: float, s1: int, s2: int, assembly: int, n: int
) -> Mask:
    """Usable workspace on the cells of `grid`, shape (n, n), indexed ``[iy, ix]``.

    The cells inside the theoretical workspace where det B has the sign ``assembly``, of which the
    4-connected component of the most cells is taken. Slivers and necks thinner than a cell are
    beyond it.
    """
    mask = theoretical_workspace_mask(r1, r2, r3, n)
    x, y = np.meshgrid(*grid(r1, r2, r3, n))
    mask[mask] = assembly * det_b(r1, r2, r3, x[mask], y[mask], s1, s2) > 0
    labels, count = ndimage.label(mask)
    if count == 0:
        return mask
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return np.asarray(labels == np.argmax(sizes))


def maximal_inscribed_circle(x: Array, y: Array, mask: Mask, half: int) -> tuple[float, float]:
    """Largest disc in the mask with its centre on the y axis, by brute force.

    Parameters
    ----------
    x, y : ndarray
        Cell centres, as from `grid`.
    mask : ndarray of bool
        Region, indexed ``[iy, ix]``.
    half : {+1, -1}
        Centres with y >= 0 or with y <= 0.

    Returns
    -------
    radius, centre_y : float
        Good to about one cell; (0, NaN) if the region leaves that half of the axis free.
    """
    n = len(x)
    dx, dy = x[1] - x[0], y[1] - y[0]
    # A frame of outside cells stands for everything beyond the box.
    x = np.concatenate([[x[0] - dx], x, [x[-1] + dx]])
    y = np.concatenate([[y[0] - dy], y, [y[-1] + dy]])
    mask = np.pad(mask, 1)
    iy, ix = np.nonzero(ndimage.binary_dilation(mask) & ~mask)
    on_axis = mask[:, (n + 1) // 2] & mask[:, n // 2 + 1]
    centres = y[on_axis & (half * y >= 0)]
    if centres.size == 0:
        return 0.0, np.nan
    radii = np.array([np.hypot(x[ix], y[iy] - c).min() for c in centres])
    best = np.argmax(radii)
    return max(float(radii[best] - (dx + dy) / 4), 0.0), float(centres[best])


def evaluate(
    r1: float,
    r2: float,
    r3: float,
    s1: int,
    s2: int,
    assembly: int,
    thresholds: Iterable[float] = (0.5,),
    n: int = 1001,
) -> dict[str, Any]:
    """Every quantity of one design in one mode pair, from one dense grid.

    Parameters
    ----------
    r1, r2, r3 : float
        Actuated link, distal link, half the base.
    s1, s2 : {+1, -1}
        Working mode.
    assembly : {+1, -1}
        Assembly mode, the sign of det B.
    thresholds : iterable of float
        LCI thresholds of the good-condition workspace.
    n : int
        Cells each way.

    Returns
    -------
    dict
        ``theoretical_workspace_area``, ``usable_workspace_area``, ``gci``, ``max_lci``,
        ``max_lci_x``, ``max_lci_y``, ``mic_upper_radius``, ``mic_upper_y``, ``mic_lower_radius``,
        ``mic_lower_y``, and the dictionaries ``good_condition_area`` and ``good_condition_gci``
        keyed by threshold. Means over an empty region are NaN.
    """
    x, y = grid(r1, r2, r3, n)
    cell = (x[1] - x[0]) * (y[1] - y[0])
    mask = usable_workspace_mask(r1, r2, r3, s1, s2, assembly, n)
    px, py = (axis[mask] for axis in np.meshgrid(x, y))
    index = lci(r1, r2, r3, px, py, s1, s2)

    def mean(values: Array) -> float:
        return float(values.mean()) if values.size else np.nan

    best = int(np.argmax(index)) if index.size else None
    upper = maximal_inscribed_circle(x, y, mask, +1)
    lower = maximal_inscribed_circle(x, y, mask, -1)
    good = {t: index[index >= t] for t in thresholds}
    return {
        "theoretical_workspace_area": float(theoretical_workspace_mask(r1, r2, r3, n).sum() * cell),
        "usable_workspace_area": float(mask.sum() * cell),
        "gci": mean(index),
        "max_lci": np.nan if best is None else float(index[best]),
        "max_lci_x": np.nan if best is None else float(px[best]),
        "max_lci_y": np.nan if best is None else float(py[best]),
        "mic_upper_radius": upper[0],
        "mic_upper_y": upper[1],
        "mic_lower_radius": lower[0],
        "mic_lower_y": lower[1],
        "good_condition_area": {t: float(part.size * cell) for t, part in good.items()},
        "good_condition_gci": {t: mean(part) for t, part in good.items()},
    }


def coupler_error(r1: float, r2: float, r3: float, x: ArrayLike, y: ArrayLike) -> Array:
    """How far the cranks are from fitting if B1, P and B2 lie in line, P in the middle.

    Parameters
    ----------
    r1, r2, r3 : float
        Actuated link, distal link, half the base.
    x, y : array_like
        Positions of P, shape (n,).

    Returns
    -------
    ndarray
        The least max(abs(abs(B1 - A1) - r1), abs(abs(B2 - A2) - r1)) found over all directions
        of the line, shape (n,). Zero on the locus of the stretched distal links.

    Notes
    -----
    With B1 = P - r2 e and B2 = P + r2 e the direction of e is the only unknown. The two errors
    are brought down together by Gauss-Newton steps from the four best of 48 directions.
    """
    p = np.stack([np.asarray(x, float), np.asarray(y, float)], axis=-1)[:, None]
    a1, a2 = base_joints(r3)

    def errors(angle: Array) -> tuple[Array, Array]:
        e = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        turn = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
        legs = np.stack([p - r2 * e - a1, p + r2 * e - a2])
        lengths = np.maximum(np.linalg.norm(legs, axis=-1), 1e-300)
        rates = r2 * np.stack([-1.0, 1.0])[:, None, None] * (legs * turn).sum(axis=-1) / lengths
        return lengths - r1, rates

    angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)[None] + np.zeros((len(p), 1))
    best = np.argsort((errors(angle)[0] ** 2).sum(axis=0), axis=1)[:, :4]
    angle = np.take_along_axis(angle, best, axis=1)
    for _ in range(25):
        error, rate = errors(angle)
        step = (error * rate).sum(axis=0) / np.maximum((rate * rate).sum(axis=0), 1e-30)
        angle = angle - np.clip(step, -0.1, 0.1)
    return np.asarray(np.abs(errors(angle)[0]).max(axis=0).min(axis=1))


def parallel_singular_points(
    r1: float, r2: float, r3: float, s1: int, s2: int, n: int
) -> tuple[Array, Array]:
    """Points where det B changes its sign along the lines of `grid`, by bisection.

    Parameters
    ----------
    r1, r2, r3 : float
        Actuated link, distal link, half the base.
    s1, s2 : {+1, -1}
        Working mode.
    n : int
        Lines each way; what changes twice between two neighbours is not seen.

    Returns
    -------
    x, y : ndarray
        The points. Neighbours with a place out of reach between them are left out.
    """
    x, y = np.meshgrid(*grid(r1, r2, r3, n))
    value = det_b(r1, r2, r3, x, y, s1, s2)
    lows, highs = [], []
    for along_x in (True, False):
        low = (slice(None), slice(None, -1)) if along_x else (slice(None, -1), slice(None))
        high = (slice(None), slice(1, None)) if along_x else (slice(1, None), slice(None))
        with np.errstate(invalid="ignore"):
            changes = value[low] * value[high] < 0.0
        lows.append(np.stack([x[low][changes], y[low][changes]], axis=-1))
        highs.append(np.stack([x[high][changes], y[high][changes]], axis=-1))
    low, high = np.concatenate(lows), np.concatenate(highs)
    sign = np.sign(det_b(r1, r2, r3, low[:, 0], low[:, 1], s1, s2))
    reached = np.ones(len(low), bool)
    for _ in range(60):
        middle = (low + high) / 2
        middle_value = det_b(r1, r2, r3, middle[:, 0], middle[:, 1], s1, s2)
        reached &= ~np.isnan(middle_value)
        same = (sign * middle_value > 0.0)[:, None]
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    middle = ((low + high) / 2)[reached]
    return middle[:, 0], middle[:, 1]


def theoretical_boundary(r1: float, r2: float, r3: float, n: int) -> tuple[Array, Array]:
    """Points of the reach circles that the other leg reaches, n evenly spread on each circle."""
    turn = 2 * np.pi * (np.arange(n) + 0.5) / n
    low, high = abs(r1 - r2), r1 + r2
    points = []
    for base in (-r3, r3):
        for radius in (low, high):
            x, y = base + radius * np.cos(turn), radius * np.sin(turn)
            other = np.hypot(x + base, y)
            kept = (low <= other) & (other <= high)
            points.append(np.stack([x[kept], y[kept]]))
    x, y = np.concatenate(points, axis=1)
    return x, y


def locus_tangent(r1: float, r2: float, r3: float, name: str, x: float, y: float) -> Array:
    """Give a unit vector along a singular locus at a point of it, up to its sign.

    Parameters
    ----------
    r1, r2, r3 : float
        Actuated link, distal link, half the base.
    name : str
        "C_1o", "C_1i", "C_2o", "C_2i", "C_coin_up", "C_coin_down" or "C_col".
    x, y : float
        The point.

    Notes
    -----
    Normal to the gradient of the implicit equation: that of a circle, or for "C_col" the sextic
    (r1^2 + r3^2 - r2^2 - rho^2)^2 rho^2 = 4 r3^2 y^2 (r1^2 - rho^2).
    """
    if name == "C_col":
        rho2, k = x * x + y * y, r1**2 + r3**2 - r2**2
        by_rho2 = (k - rho2) ** 2 - 2.0 * (k - rho2) * rho2 + 4.0 * r3**2 * y * y
        gradient = np.array(
            [2.0 * x * by_rho2, 2.0 * y * by_rho2 - 8.0 * r3**2 * y * (r1**2 - rho2)]
        )
    elif name.startswith("C_coin"):
        height = np.sqrt(r1**2 - r3**2)
        gradient = np.array([x, y - height if name == "C_coin_up" else y + height])
    else:
        gradient = np.array([x + r3 if name[2] == "1" else x - r3, y])
    return np.array([-gradient[1], gradient[0]]) / np.hypot(*gradient)


def distance_to_polyline(points: Array, corners: Array) -> Array:
    """Distances of points, shape (n, 2), from the segments between corners, shape (m, 2)."""
    start, along = corners[:-1], np.diff(corners, axis=0)
    square = (along**2).sum(axis=1)
    offset = points[:, None] - start
    share = (offset * along).sum(axis=2) / np.where(square > 0.0, square, 1.0)
    gap = offset - np.clip(share, 0.0, 1.0)[:, :, None] * along
    return np.asarray(np.sqrt((gap**2).sum(axis=2)).min(axis=1))
