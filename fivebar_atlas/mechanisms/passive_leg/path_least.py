"""Where LCI and the distance from the boundary are least on a path, between its corners too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.passive_leg.path import boundary_distances, check_path
from fivebar_atlas.mechanisms.paths import checked_corners, columns, least_along
from fivebar_atlas.mechanisms.planar import PathLeast

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.passive_leg.passive_leg import PassiveLeg


def least_on_path(
    design: PassiveLeg, mode: str, points: npt.ArrayLike
) -> tuple[PathLeast, PathLeast]:
    """Return the least LCI and the least distance from the workspace's boundary on a path.

    Between its corners too; parameters and exceptions are those of :func:`check_path`.

    Raises
    ------
    InputError
        If the path cannot be followed.
    """
    corners = checked_corners(points)
    workspace = design.usable_workspace(mode)
    if workspace is None or check_path(design, mode, corners).fault is not None:
        raise InputError("points", len(corners), f"a path that {mode} can follow")
    return (
        least_along(corners, lambda places: design.lci(*columns(places), mode)),
        least_along(corners, lambda places: boundary_distances(design, workspace, places)[0]),
    )
