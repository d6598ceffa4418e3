"""What holds on whole discs, not only at points: bounds of the LCI and of the input angles.

Over a disc of radius h about P every distance d_i = |P - A_i| changes by at most h. With
W_i = (2 r1 r2 sin β_i)² = ((r1 + r2)² - d_i²)(d_i² - (r1 - r2)²), which is concave in d_i²,
that bounds the sines of the elbow angles from both sides. The component of P' along the crank
is r2 δ_i' sin β_i, and that along the distal link is r1 θ_i' sin β_i, up to signs: a distal
link turns by no more than h / (r2 sin β_i) and a crank by no more than h / (r1 sin β_i), with
the least sine of the disc. So

    2 / (κ + 1/κ) = 2 |sin γ| / (sin β1 / sin β2 + sin β2 / sin β1)

is bounded from below by the least value of either factor, and where the bound is positive the
disc holds no singularity. Bounds hold but for rounding, some 1e-15.
"""

from __future__ import annotations

import numpy as np

from fivebar_atlas.mechanisms.base import FloatArray
from fivebar_atlas.mechanisms.five_bar.loci import Lengths


def bounds_on_discs(
    lengths: Lengths, x: FloatArray, y: FloatArray, radius: FloatArray, s1: float, s2: float
) -> tuple[FloatArray, FloatArray]:
    """Return a lower bound of the LCI over discs, and how far the inputs turn at most in them.

    Parameters
    ----------
    lengths
        Non-dimensional r1, r2, r3.
    x, y, radius
        Centres and radii, shape (n,) each.
    s1, s2
        Working mode as ±1.

    Returns
    -------
    least : ndarray
        No point of the disc has a smaller LCI, shape (n,); 0 where nothing can be said. Where
        it is positive det B has one sign in the disc.
    turns : ndarray
        Largest difference of θ1 and θ2, in radians, between a point of the disc and its
        centre, shape (n, 2); infinite where nothing can be said.
    """
    r1, r2, r3 = lengths
    largest, smallest = (r1 + r2) ** 2, (r1 - r2) ** 2

    def squared(reach2: FloatArray) -> FloatArray:
        return (largest - reach2) * (reach2 - smallest)

    least_sines, greatest_sines, links = [], [], []
    for base, sign in ((-r3, s1), (r3, s2)):
        u = x - base
        reach2 = u * u + y * y
        reach = np.sqrt(reach2)
        near = np.maximum(reach - radius, 0.0) ** 2
        far = (reach + radius) ** 2
        ends = squared(near), squared(far)
        peak = np.clip(r1 * r1 + r2 * r2, near, far)
        least_sines.append(np.sqrt(np.maximum(np.minimum(*ends), 0.0)))
        greatest_sines.append(np.sqrt(np.maximum(squared(peak), 0.0)))
        # the distal link, times twice the squared distance
        along = reach2 + (r2 - r1) * (r2 + r1)
        across = sign * np.sqrt(np.maximum(squared(reach2), 0.0))
        links.append((along * u + across * y, along * y - across * u))
    (v1x, v1y), (v2x, v2y) = links
    gamma = np.arctan2(np.abs(v1x * v2y - v1y * v2x), np.abs(v1x * v2x + v1y * v2y))
    (low_1, low_2), (high_1, high_2) = least_sines, greatest_sines
    with np.errstate(divide="ignore", invalid="ignore"):
        distal_turn = 2.0 * r1 * radius * (1.0 / low_1 + 1.0 / low_2)
        turns = 2.0 * r2 * radius[:, None] / np.column_stack([low_1, low_2])
        share = [2.0 * a * b / (a * a + b * b) for a, b in ((low_1, high_2), (low_2, high_1))]
    is_regular = (low_1 > 0.0) & (low_2 > 0.0) & (distal_turn < gamma)
    ratio = np.where(
        is_regular, np.minimum(*share) * np.sin(np.where(is_regular, gamma - distal_turn, 0.0)), 0.0
    )
    return (
        # c of 2 c / (1 + c²), in the form that loses no digits
        ratio / (1.0 + np.sqrt((1.0 - ratio) * (1.0 + ratio))),
        np.where(is_regular[:, None], turns, np.inf),
    )
