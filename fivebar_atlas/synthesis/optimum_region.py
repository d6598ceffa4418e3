"""The optimum region: all designs that fulfil several conditions at once.

Between the designs of the lattice every quantity is taken to be linear on the triangles
of the lattice, as in the contour maps; for that interpolation the region is exact.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.store import Atlas
from fivebar_atlas.synthesis.conditions import Condition, check_conditions, condition_margins
from fivebar_atlas.triangulated_regions import Region, region_where

FloatArray = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class OptimumRegion:
    """The designs that fulfil several conditions.

    Attributes
    ----------
    conditions
        The conditions.
    region
        The region in chart coordinates.
    share
        Its part of the area of the design space in the chart.
    least, greatest
        Range of every parameter in it, shape (parameters,); NaN where it is empty.
    lattice_designs
        Number of designs of the lattice that fulfil all conditions.
    """

    conditions: tuple[Condition, ...]
    region: Region
    share: float
    least: FloatArray
    greatest: FloatArray
    lattice_designs: int


def optimum_region(
    atlas: Atlas,
    conditions: Sequence[Condition],
    mode: str | None = None,
    lci: float | None = None,
) -> OptimumRegion:
    """Return the designs of an atlas that fulfil all conditions.

    Parameters
    ----------
    atlas
        The open result file.
    conditions
        The conditions; none means all designs.
    mode, lci
        Mode pair and LCI threshold of the quantities that depend on them; needed only
        where the file holds several.

    Returns
    -------
    OptimumRegion
        The region; empty where nothing, or nothing but a line or a point, fulfils them.

    Raises
    ------
    UnknownNameError
        If a condition names something that is neither a quantity nor a parameter.
    InputError
        If a mode pair or threshold is not in the file or must be chosen.
    FileError
        If the file is damaged.
    """
    check_conditions(conditions, atlas)
    if mode is not None:
        atlas.mode_index(mode)
    if lci is not None:
        atlas.mechanism.check_thresholds([lci])
        atlas.lci_index(lci)
    mechanism, settings = atlas.mechanism, atlas.settings
    points = mechanism.project(atlas.designs, settings.space)
    triangles = mechanism.triangles(settings.space, settings.resolution)
    margins = condition_margins(conditions, atlas, mode, lci)
    region = region_where(points, triangles, margins)
    least, greatest = region.extent(triangles, atlas.designs)
    fulfilled = np.ones(len(atlas.designs), dtype=np.bool_)
    for condition in conditions:
        fulfilled &= condition.holds(atlas.select(condition.quantity, mode, lci))
    return OptimumRegion(
        conditions=tuple(conditions),
        region=region,
        share=region.area / _polygon_area(mechanism.chart(settings.space).outline),
        least=least,
        greatest=greatest,
        lattice_designs=int(np.count_nonzero(fulfilled)),
    )


def _polygon_area(corners: FloatArray) -> float:
    x, y = corners.T
    return float(abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2.0)
