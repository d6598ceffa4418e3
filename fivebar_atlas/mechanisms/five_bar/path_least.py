"""Where LCI and the distance from singular loci are least on a path, between its corners too."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.five_bar.loci import Lengths
from fivebar_atlas.mechanisms.five_bar.outline import usable_workspace_of
from fivebar_atlas.mechanisms.five_bar.path import (
    boundary_distances,
    check_path,
)
from fivebar_atlas.mechanisms.five_bar.points import lci_at
from fivebar_atlas.mechanisms.mode_pairs import Signs, mode_label
from fivebar_atlas.mechanisms.paths import checked_corners, columns, least_along
from fivebar_atlas.mechanisms.planar import PathLeast


def least_on_path(
    lengths: Lengths, signs: Signs, points: npt.ArrayLike
) -> tuple[PathLeast, PathLeast]:
    """Return the least LCI and the least distance from a singular locus on a path.

    Between its corners too; parameters and exceptions are those of :func:`check_path`.

    Raises
    ------
    InputError
        If the path cannot be followed: there both go to 0.
    """
    corners = checked_corners(points)
    workspace = usable_workspace_of(lengths, signs)
    if workspace is None or check_path(lengths, signs, corners).fault is not None:
        raise InputError("points", len(corners), f"a path that {mode_label(signs)} can follow")
    return (
        least_along(corners, lambda places: _lci(lengths, signs, places)),
        least_along(corners, lambda places: boundary_distances(lengths, workspace, places)[0]),
    )


def _lci(lengths: Lengths, signs: Signs, points: FloatArray) -> FloatArray:
    """Return the LCI at points, shape (n, 2)."""
    values = np.empty(len(points))
    lci_at(*lengths, *columns(points), float(signs[0]), float(signs[1]), values)
    return values
