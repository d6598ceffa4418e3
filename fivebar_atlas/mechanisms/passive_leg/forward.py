"""Forward kinematics of the manipulator with a passive leg: the sextic in its length (Sec. 3.2).

For given elbows d_i each leg's closure is linear in cos θ and sin θ, with coefficients that are
polynomials in the length l of the passive leg (Eq. 8):

    A_i - 2 B_i cos θ + 2 C_i sin θ = 0.

Solved for cos θ and sin θ, whose squares sum to 1, that is

    (A1 B2 - A2 B1)² + (A2 C1 - A1 C2)² = 4 (B2 C1 - B1 C2)²,

a sextic in l: Eq. 11, in which the paper has lost the factor 4. A pose with l < 0 is one with the
passive leg pointing the other way.
"""

from __future__ import annotations

import math

import numpy as np

from fivebar_atlas.mechanisms.arrays import FloatArray

# Newton steps that a root may take, and a step, as a share of the links, that is rounding.
_STEPS, _ROUNDING = 40, 1e-14
# Closure, as a share of the squared links, up to which a pose counts as an assembly; poses that
# are closer to each other are one.
_CLOSURE, _SAME = 1e-11, 1e-7
# How close to its root, as a share of the links, an assembly is.
_NEAR = 1e-6
# Roots whose imaginary part is less than this share of the links are tried as real ones.
_NEARLY_REAL = 1e-3


def forward_poses(
    base: float, platform: float, l_a: float, l_b: float, phi1: float, phi2: float
) -> FloatArray:
    """Return all assemblies for given input angles.

    Parameters
    ----------
    base, platform, l_a, l_b
        R, r and the lengths of the lower and the upper links.
    phi1, phi2
        Input angles in radians.

    Returns
    -------
    ndarray
        Length of the passive leg and its angle in (-π, π], one row for each assembly, at most
        six, by rising length, then by rising angle; shape (n, 2). Every row closes both legs.
    """
    scale = base + platform + l_a + l_b
    lower = l_a * np.array([[math.cos(phi1), math.sin(phi1)], [math.cos(phi2), math.sin(phi2)]])
    elbows = lower + np.array([[base, 0.0], [-base, 0.0]])
    found: list[FloatArray] = []
    for length in _lengths(elbows, platform, l_b, scale):
        for theta in _angles(elbows, platform, l_b, length):
            pose = _closed(elbows, platform, l_b, np.array([length, theta]), scale)
            if pose is None:
                continue
            if not any(_is_same(pose, other, scale) for other in found):
                found.append(pose)
            if abs(pose[0] - length) <= _NEAR * scale:  # what this root stands for
                break
    return np.array(sorted(found, key=lambda pose: (pose[0], pose[1]))).reshape(-1, 2)


def _coefficients(
    elbows: FloatArray, platform: float, l_b: float
) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Return A, B and C of both legs as polynomials in the length, highest power first."""
    return [
        (
            np.array([1.0, 0.0, x * x + y * y + platform**2 - l_b**2]),
            np.array([y, sign * platform * x]),
            np.array([x, -sign * platform * y]),
        )
        for (x, y), sign in zip(elbows, (1.0, -1.0), strict=True)
    ]


def _lengths(elbows: FloatArray, platform: float, l_b: float, scale: float) -> list[float]:
    """Return the real parts of all roots of the sextic that are nearly real."""
    # in lengths of all links together, so that coefficients are of one size
    legs = _coefficients(elbows / scale, platform / scale, l_b / scale)
    (a1, b1, c1), (a2, b2, c2) = legs
    one = np.convolve(a1, b2) - np.convolve(a2, b1)
    two = np.convolve(a2, c1) - np.convolve(a1, c2)
    det = np.convolve(b2, c1) - np.convolve(b1, c2)
    sextic = np.convolve(one, one) + np.convolve(two, two)
    sextic[2:] -= 4.0 * np.convolve(det, det)
    size = float(np.abs(sextic).max())
    if size == 0.0:
        return []
    # a leading coefficient that is nothing but rounding makes a root far away
    leading = int(np.argmax(np.abs(sextic) > _ROUNDING * size))
    roots = np.roots(sextic[leading:])
    return [float(scale * root.real) for root in roots if abs(root.imag) < _NEARLY_REAL]


def _angles(elbows: FloatArray, platform: float, l_b: float, length: float) -> list[float]:
    """Return angles to start from: where both legs close, or where one of them does."""
    rows = _coefficients(elbows, platform, l_b)
    legs = [
        ((a[0] * length + a[1]) * length + a[2], b[0] * length + b[1], c[0] * length + c[1])
        for a, b, c in rows
    ]
    (a1, b1, c1), (a2, b2, c2) = legs
    det = b2 * c1 - b1 * c2
    starts = []
    if det != 0.0:
        starts.append(math.atan2((a2 * b1 - a1 * b2) / det, (a2 * c1 - a1 * c2) / det))
    for a, b, c in legs:
        size = math.hypot(b, c)
        if size > 0.0:
            # 2 (B cos θ - C sin θ) = A
            middle = math.atan2(-c, b)
            half = math.acos(max(-1.0, min(1.0, 0.5 * a / size)))
            starts += [middle + half, middle - half]
    return starts


def _closure(
    elbows: FloatArray, platform: float, l_b: float, pose: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return |b_i - d_i|² - l_b² of both legs, and its derivatives by length and angle."""
    length, theta = pose
    c, s = math.cos(theta), math.sin(theta)
    u, w = np.array([c, s]), np.array([-s, c])
    signs = np.array([[1.0], [-1.0]])
    links = length * w + signs * platform * u - elbows
    gaps = np.sum(links * links, axis=1) - l_b * l_b
    by_length = 2.0 * links @ w
    by_angle = 2.0 * np.sum(links * (signs * platform * w - length * u), axis=1)
    return gaps, np.column_stack([by_length, by_angle])


def _closed(
    elbows: FloatArray, platform: float, l_b: float, pose: FloatArray, scale: float
) -> FloatArray | None:
    """Return the assembly that Newton's method finds from a pose, None where there is none."""
    for _ in range(_STEPS):
        gaps, slopes = _closure(elbows, platform, l_b, pose)
        (a, b), (c, d) = slopes
        det = a * d - b * c
        if det == 0.0:
            break
        step = np.array([b * gaps[1] - d * gaps[0], c * gaps[0] - a * gaps[1]]) / det
        # no farther than a fraction of the linkage at a time
        size = math.hypot(step[0] / scale, step[1])
        pose = pose + step * min(1.0, 0.3 / size if size > 0.0 else 1.0)
        if size < _ROUNDING:
            break
    gaps, _ = _closure(elbows, platform, l_b, pose)
    if not np.max(np.abs(gaps)) <= _CLOSURE * scale * scale:
        return None
    turned = math.remainder(float(pose[1]), 2.0 * math.pi)
    return np.array([pose[0], math.pi if turned == -math.pi else turned])


def _is_same(one: FloatArray, other: FloatArray, scale: float) -> bool:
    """Tell whether two poses are one but for rounding."""
    turn = abs(math.remainder(float(one[1] - other[1]), 2.0 * math.pi))
    return abs(one[0] - other[0]) <= _SAME * scale and turn <= _SAME
