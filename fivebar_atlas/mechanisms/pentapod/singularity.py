"""How near the pentapod is to a singular pose, and of what kind that is.

Where det G = 0 (Wang et al. 2017, Eq. 10) the platform can move with all limbs locked, and some
loads cannot be balanced. The paper does not look at these poses. G mixes pure numbers and
lengths, so a singular value or a condition number needs a characteristic length L: G here is that
of twists (v, L ω). Whether G is singular does not depend on L.

A limb without length, the only other singularity, is refused by everything that needs n_i.
"""

from __future__ import annotations

import dataclasses
import enum
import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS, PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.jacobian import jacobian, without_unit
from fivebar_atlas.mechanisms.pentapod.kinematics import (
    checked_length,
    nearest_valid_pose,
)

#: Singular values below this share of the largest count as 0.
RANK_TOLERANCE = 1e-9

# Poses in which a geometry is looked at that may be singular in all of them.
_TRIALS, _SEED = 8, 20170125


class Dependency(enum.IntEnum):
    """Which of the six lines of force depend on each other."""

    #: None: the pose is regular.
    NONE = 0
    #: The five limbs among themselves, whatever the constraint.
    LIMBS = 1
    #: The limbs are independent, but together they make the constraint force.
    CONSTRAINT = 2


class FreeMotion(enum.IntEnum):
    """What the platform can do with all limbs locked, to the first order."""

    #: Nothing: the pose is regular.
    NONE = 0
    #: It turns about a line.
    ROTATION = 1
    #: It moves along a line.
    TRANSLATION = 2
    #: It does both at once.
    SCREW = 3
    #: It has more than one freedom.
    SEVERAL = 4


@dataclasses.dataclass(frozen=True, eq=False)
class Singularity:
    """How singular poses are.

    Attributes
    ----------
    determinant
        det G over L³, shape (...). It changes its sign where poses are singular.
    singular_values
        Of G with L, the largest first, shape (..., 6).
    inverse_condition_number
        The smallest over the largest of them, shape (...).
    rank
        Of G, shape (...).
    dependency
        Values of :class:`Dependency`, shape (...).
    free_motion
        Values of :class:`FreeMotion`, shape (...).
    free_twist
        Unit vector (v, L ω) of the least singular value, in base axes, shape (..., 6): where the
        rank is 5, the motion with all limbs locked.
    """

    determinant: FloatArray
    singular_values: FloatArray
    inverse_condition_number: FloatArray
    rank: IntArray
    dependency: IntArray
    free_motion: IntArray
    free_twist: FloatArray


def singularity(
    geometry: PentapodGeometry,
    poses: npt.ArrayLike,
    characteristic_length: float,
    tolerance: float = RANK_TOLERANCE,
) -> Singularity:
    """Return how singular poses are, and of what kind.

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses, shape (..., 6). It is not looked at whether the revolute joint allows them.
    characteristic_length
        L, above 0, for instance :attr:`PentapodGeometry.platform_radius`.
    tolerance
        Singular values below this share of the largest count as 0, from 0 to 1. The kind of
        motion is told with the square root of it: a null vector is only that precise.

    Returns
    -------
    Singularity
        Measures and kinds.

    Raises
    ------
    InputError
        If L is not above 0, the tolerance is none, poses are not finite or of another shape, or
        a limb has no length.
    """
    length = checked_length(characteristic_length)
    if not 0.0 <= tolerance < 1.0:
        raise InputError("tolerance", tolerance, "a number from 0 to below 1")
    scaled = without_unit(jacobian(geometry, poses), length)
    _, sizes, right = np.linalg.svd(scaled)
    bound = tolerance * sizes[..., 0]
    rank = np.sum(sizes > bound[..., None], axis=-1)
    limbs = np.linalg.svd(scaled[..., :LIMBS, :], compute_uv=False)
    dependent = limbs[..., -1] <= bound
    dependency = np.where(dependent, Dependency.LIMBS, Dependency.CONSTRAINT)
    free = right[..., -1, :]
    motion = np.where(rank < 5, FreeMotion.SEVERAL, _motion(free, math.sqrt(tolerance)))
    regular = rank == 6
    return Singularity(
        determinant=np.linalg.det(scaled),
        singular_values=sizes,
        inverse_condition_number=sizes[..., -1] / sizes[..., 0],
        rank=rank,
        dependency=np.where(regular, Dependency.NONE, dependency),
        free_motion=np.where(regular, FreeMotion.NONE, motion),
        free_twist=free,
    )


def is_always_singular(geometry: PentapodGeometry) -> bool:
    """Tell whether a geometry is singular in all its poses.

    Such a geometry is of no use, although nothing about its joints need look wrong. The
    determinant is analytic on the poses that the revolute joint allows, so one that vanishes at
    several poses chosen at random vanishes everywhere.

    Parameters
    ----------
    geometry
        The joints.

    Returns
    -------
    bool
        Whether det G is 0, but for rounding, in all of a few random poses.
    """
    random = np.random.default_rng(_SEED)
    length = geometry.platform_radius
    poses = np.empty((_TRIALS, 6))
    poses[:, :3] = geometry.base.mean(axis=0) + geometry.size * random.normal(size=(_TRIALS, 3))
    poses[:, 3:] = random.uniform(-1.0, 1.0, (_TRIALS, 3))
    poses = nearest_valid_pose(geometry, poses, length)
    regular: BoolArray = singularity(geometry, poses, length).rank == 6
    return not bool(regular.any())


def _motion(twists: FloatArray, tolerance: float) -> IntArray:
    """Return the kind of motion of unit twists (v, L ω)."""
    linear, angular = twists[..., :3], twists[..., 3:]
    turning = np.linalg.norm(angular, axis=-1)
    along = np.abs(np.sum(linear * angular, axis=-1))
    # v·ω = 0: a rotation about a line, which may be far away
    rotation = np.where(along <= tolerance * turning, FreeMotion.ROTATION, FreeMotion.SCREW)
    kind: IntArray = np.where(turning <= tolerance, FreeMotion.TRANSLATION, rotation)
    return kind
