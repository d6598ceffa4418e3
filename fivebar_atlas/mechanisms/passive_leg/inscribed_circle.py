"""The largest circle inside a symmetric workspace with its centre on the y axis."""

from __future__ import annotations

import numpy as np

from fivebar_atlas.mechanisms.passive_leg.outline import UsableWorkspace
from fivebar_atlas.planar_geometry import CircleArc

# Centres that are tried along the axis, first and around the best one; times that is done, each
# time between the neighbours of the best one.
_FIRST, _AROUND, _ZOOMS = 257, 17, 14


def largest_circle_on_axis(workspace: UsableWorkspace) -> CircleArc | None:
    """Return the circle, None where the axis does not pass through the workspace.

    Parameters
    ----------
    workspace
        A usable workspace that is symmetric about the y axis. Its centre is found to some 1e-12
        of the workspace's height; of two largest circles one is returned.
    """
    heights = np.concatenate([each.arc.polyline(0.1)[:, 1] for each in workspace.region.arcs])
    low, high, count = float(heights.min()), float(heights.max()), _FIRST
    best: tuple[float, float] | None = None
    for _ in range(_ZOOMS):
        y = np.linspace(low, high, count + 2)[1:-1]
        inside = workspace.contains(np.zeros(len(y)), y)
        if not inside.any():
            break
        points = np.column_stack([np.zeros(len(y)), y])
        gaps = np.where(inside, workspace.region.boundary_distance(points)[0], 0.0)
        place = int(np.argmax(gaps))
        if best is None or gaps[place] > best[0]:
            best = float(gaps[place]), float(y[place])
        step = (high - low) / (count + 1)
        low, high, count = float(y[place]) - step, float(y[place]) + step, _AROUND
    return None if best is None else CircleArc.whole((0.0, best[1]), best[0])
