"""What a user would write instead: one design on a dense NumPy grid, vectorised.

LCI in closed form on n x n cell centres, the largest connected component by labelling.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage


def evaluate(
    r1: float, r2: float, r3: float, s1: int, s2: int, assembly: int, threshold: float, n: int
) -> tuple[float, float, float]:
    """Return usable workspace area, GCI and good-condition workspace area."""
    reach = r1 + r2
    width, height = reach - r3, np.sqrt(reach**2 - r3**2)
    step = (2.0 * np.arange(n) + 1.0) / n - 1.0
    x, y = np.meshgrid(width * step, height * step)
    cell = 4.0 * width * height / n**2
    inside = np.ones_like(x, dtype=bool)
    sines, links = [], []
    with np.errstate(invalid="ignore", divide="ignore"):
        for base, sign in ((-r3, s1), (r3, s2)):
            u = x - base
            d2 = u * u + y * y
            square = (reach**2 - d2) * (d2 - (r1 - r2) ** 2)
            inside &= square > 0.0
            four_areas = np.sqrt(np.maximum(square, 0.0))
            along = 0.5 * (d2 + r2 * r2 - r1 * r1) / d2
            across = 0.5 * sign * four_areas / d2
            sines.append(four_areas)
            links.append((along * u + across * y, along * y - across * u))
        (ax, ay), (bx, by) = links
        det_b = ax * by - ay * bx
        inside &= assembly * det_b > 0.0
        labels, count = ndimage.label(inside)
        if count == 0:
            return 0.0, np.nan, 0.0
        sizes = np.bincount(labels.ravel())
        sizes[0] = 0
        usable = labels == np.argmax(sizes)
        t = 2.0 * sines[0] * sines[1] * np.abs(det_b) / r2**2
        s = sines[0] ** 2 + sines[1] ** 2
        lci = (t / (s + np.sqrt(np.maximum(s * s - t * t, 0.0))))[usable]
    return usable.sum() * cell, float(lci.mean()), float((lci >= threshold).sum() * cell)
