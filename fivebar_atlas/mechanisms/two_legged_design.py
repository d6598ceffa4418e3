"""What one design has in common with others whose output moves in a plane on two actuated legs.

Its modes are mode pairs (:mod:`mode_pairs`); lengths are non-dimensional.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.level_curves import SampledField, level_regions
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.mode_pairs import mode_label, mode_pairs
from fivebar_atlas.mechanisms.planar import PlanarDesign, Pose, Workspace
from fivebar_atlas.planar_geometry import Point, Region

# Grid cells along a workspace from which its level curves start.
_LEVEL_CELLS = 400
# And how far the middle of a side may be from them.
_LEVEL_DEVIATION = 1e-6
# Chords of an outline leave it by no more than this where its extent is all that matters.
_OUTLINE_DEVIATION = 1e-3


class ConditionedWorkspace(Workspace):
    """A usable workspace that knows the LCI of its points."""

    @abstractmethod
    def lci(self, x: npt.ArrayLike, y: npt.ArrayLike) -> FloatArray:
        """Return the LCI at points inside, 0 elsewhere; x and y broadcast."""


class TwoLeggedDesign(PlanarDesign):
    """A non-dimensional design with two actuated legs."""

    @property
    def unit(self) -> str:
        """Empty: points and lengths are non-dimensional."""
        return ""

    @property
    def factor(self) -> float:
        """1: points and lengths are non-dimensional."""
        return 1.0

    @abstractmethod
    def usable_workspace(self, mode: str = "+-/up") -> ConditionedWorkspace | None:
        """Return the usable workspace of a mode pair, None where it is empty."""

    @abstractmethod
    def _peaks(self, mode: str) -> tuple[Point, ...]:
        """Return points where the LCI is large, around which small parts are looked for."""

    def good_condition_workspace(
        self, lci_threshold: float = 0.5, mode: str = "+-/up"
    ) -> tuple[Region, ...]:
        """Return the parts of the usable workspace with at least this LCI, largest first.

        Their boundaries are polylines with corners exactly on the level curve, or on a limit of a
        joint, and sides that leave it by some 1e-6 (Liu, Wang and Zheng 2006, Sec. 9.2, step 1;
        Fig. 13). Parts smaller than 1/400 of the workspace are found around isotropic points and
        the largest LCI; of long parts thinner than that only pieces may be. Exact areas are
        integrated: :meth:`good_condition_area`.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If the threshold is not above 0 and below 1.
        """
        check_threshold(lci_threshold)
        workspace = self.usable_workspace(mode)
        if workspace is None:
            return ()
        corners = np.concatenate(workspace.region.polygons(_OUTLINE_DEVIATION))
        field = SampledField.over(
            workspace.lci, corners.min(axis=0), corners.max(axis=0), _LEVEL_CELLS
        )
        return level_regions(
            field, lci_threshold, "LCI", r"$1/\kappa_J$", self._peaks(mode), _LEVEL_DEVIATION
        )

    def lci_inside(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-/up") -> FloatArray:
        """Return the LCI at points of the usable workspace of a mode pair, 0 elsewhere."""
        workspace = self.usable_workspace(mode)
        if workspace is None:
            return np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y)))
        return workspace.lci(x, y)


def in_mode(pose: Pose, mode: str, point: Point) -> Pose:
    """Return a pose; raise InputError if a mode pair is named and it belongs to another one."""
    signs = mode_pairs(mode)
    if len(signs) == 1 and "/" in pose.mode and pose.mode != mode_label(signs[0]):
        raise InputError("P", point, f"a point of {mode_label(signs[0])}; it is {pose.mode}")
    return pose


def two_angles(inputs: Sequence[float], names: str) -> tuple[float, float]:
    """Return two input angles; raise InputError, with their names, unless they are finite."""
    angles = tuple(float(angle) for angle in inputs)
    if len(angles) != 2 or not np.all(np.isfinite(angles)):
        raise InputError("inputs", angles, f"two finite angles {names}")
    return angles[0], angles[1]


def flat_points(
    x: npt.ArrayLike, y: npt.ArrayLike
) -> tuple[tuple[FloatArray, FloatArray], tuple[int, ...]]:
    """Return coordinates as flat arrays of one length, and their broadcast shape."""
    wide = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
    return (np.ravel(wide[0]).copy(), np.ravel(wide[1]).copy()), wide[0].shape


def flat_discs(
    x: npt.ArrayLike, y: npt.ArrayLike, radius: npt.ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return centres and radii of discs as flat arrays of one length."""
    xs, ys, radii = np.broadcast_arrays(x, y, radius)
    return (
        np.ravel(xs).astype(np.float64),
        np.ravel(ys).astype(np.float64),
        np.ravel(radii).astype(np.float64),
    )


def check_threshold(threshold: float) -> None:
    """Raise InputError unless a threshold of the LCI is above 0 and below 1."""
    if not 0.0 < threshold < 1.0:
        raise InputError("lci_threshold", threshold, "a number above 0 and below 1")
