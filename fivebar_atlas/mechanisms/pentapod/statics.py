"""Forces in the limbs of the pentapod and in its revolute joint (Wang et al. 2017, Sec. 3.3).

Weight and friction are left out. The load (F, T) acts on the platform at p, in base axes.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.jacobian import check_regular, jacobian, without_unit
from fivebar_atlas.mechanisms.pentapod.kinematics import check_poses, checked


def joint_forces(
    geometry: PentapodGeometry, poses: npt.ArrayLike, loads: npt.ArrayLike
) -> FloatArray:
    """Return the active forces and the constraint force that balance a load (Eq. 16).

    (F_1, ..., F_5, F_τ) = -G⁻ᵀ (F, T).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses that the revolute joint allows, shape (..., 6).
    loads
        (F, T), shape (..., 6): the force, and the moment about p in its unit times that of
        lengths.

    Returns
    -------
    ndarray
        Shape (..., 6). Limb i pushes the platform with F_i along n_i, so a positive force is one
        of a limb under compression; the fifth limb also pushes it with F_τ along n6, on a line
        through A_5.

    Raises
    ------
    SingularPoseError
        If a pose is singular.
    InvalidPoseError
        If the revolute joint does not allow a pose.
    InputError
        If something is not finite or of another shape, or a limb has no length.
    """
    poses = check_poses(geometry, poses)
    loads = checked("load", loads, (6,), like=poses)
    length = geometry.platform_radius
    scaled = without_unit(jacobian(geometry, poses), length)
    check_regular(scaled)
    right = -loads / np.repeat([1.0, length], 3)
    forces: FloatArray = np.linalg.solve(np.swapaxes(scaled, -1, -2), right[..., None])[..., 0]
    return forces


def balanced_load(
    geometry: PentapodGeometry, poses: npt.ArrayLike, forces: npt.ArrayLike
) -> FloatArray:
    """Return the load that given forces in the joints balance, -Gᵀ (F_1, ..., F_5, F_τ).

    Parameters
    ----------
    geometry
        The joints.
    poses
        Poses that the revolute joint allows, shape (..., 6).
    forces
        Shape (..., 6), signs as in :func:`joint_forces`.

    Returns
    -------
    ndarray
        (F, T), shape (..., 6).

    Raises
    ------
    InvalidPoseError
        If the revolute joint does not allow a pose.
    InputError
        If something is not finite or of another shape, or a limb has no length.
    """
    poses = check_poses(geometry, poses)
    forces = checked("force", forces, (6,), like=poses)
    product: FloatArray = np.swapaxes(jacobian(geometry, poses), -1, -2) @ forces[..., None]
    return -product[..., 0]
