"""The local conditioning index over a usable workspace, sampled for figures."""

from __future__ import annotations

import functools

import numpy as np

from fivebar_atlas.figures.plane_frame import bounds_of_arcs
from fivebar_atlas.level_curves import SampledField
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import Region

# Cells along the longer side of the workspace.
_CELLS = 400
# The largest value is closed in on by rasters, each of the cells around the best point so far.
_RASTER, _STEPS = 20, 8


def lci_field(design: PlanarDesign, region: Region, mode: str) -> SampledField:
    """Sample the LCI over the usable workspace of a mode pair; it is 0 outside.

    Parameters
    ----------
    design
        The design.
    region
        The usable workspace.
    mode
        The mode pair.
    """
    values = functools.partial(design.lci_inside, mode=mode)
    return SampledField.over(values, *bounds_of_arcs(region.outline.arcs), _CELLS)


def largest_lci(field: SampledField) -> float:
    """Return the largest value of a sampled field, refined from the best sample."""
    row, column = np.unravel_index(np.argmax(field.values), field.values.shape)
    best, place = float(field.values[row, column]), np.array([field.x[column], field.y[row]])
    half = np.array([field.x[1] - field.x[0], field.y[1] - field.y[0]])
    for _ in range(_STEPS):
        shares = np.linspace(-1.0, 1.0, _RASTER + 1)
        x, y = (each.ravel() for each in np.meshgrid(*(place + half * shares[:, None]).T))
        values = field.function(x, y)
        highest = int(np.argmax(values))
        if values[highest] > best:
            best, place = float(values[highest]), np.array([x[highest], y[highest]])
        half = 2.0 * half / _RASTER
    return best
