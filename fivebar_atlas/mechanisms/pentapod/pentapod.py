"""One pentapod, for scripts and notebooks."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, InvalidPoseError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray
from fivebar_atlas.mechanisms.pentapod.atlas_options import OPTIONS, AtlasOptions
from fivebar_atlas.mechanisms.pentapod.forward import ForwardDisplacement, forward_displacement
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS, PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.jacobian import (
    forward_acceleration,
    forward_velocity,
    hessians,
    inverse_acceleration,
    inverse_velocity,
    jacobian,
    jacobian_of,
    without_unit,
)
from fivebar_atlas.mechanisms.pentapod.kinematics import (
    COORDINATES,
    ConstraintSolutions,
    Limbs,
    check_poses,
    checked,
    constraint_residual,
    inverse_displacement,
    limbs,
    nearest_valid_pose,
    solve_constraint,
)
from fivebar_atlas.mechanisms.pentapod.rotations import rotation_matrices, wrapped
from fivebar_atlas.mechanisms.pentapod.singularity import Singularity, singularity
from fivebar_atlas.mechanisms.pentapod.statics import joint_forces
from fivebar_atlas.mechanisms.settings import Options
from fivebar_atlas.mechanisms.spatial import (
    REVOLUTE,
    SPHERICAL,
    Coordinate,
    Frame,
    Limb,
    Limit,
    SpatialDesign,
    SpatialJoint,
    SpatialPose,
)

# Singular values below this share of the largest are rounding.
_SINGULAR = 1e-12

_SYMBOLS = ("$X$", "$Y$", "$Z$", r"$\alpha$", r"$\beta$", r"$\gamma$")
_LIMB_NUMBERS = tuple(range(1, LIMBS + 1))
_LIMITS = (
    *(Limit(f"longest l_{i}", rf"$l_{{{i},\max}}$", "longest limb") for i in _LIMB_NUMBERS),
    *(Limit(f"shortest l_{i}", rf"$l_{{{i},\min}}$", "shortest limb") for i in _LIMB_NUMBERS),
    *(Limit(f"joint A_{i}", f"$A_{i}$", "base joint") for i in _LIMB_NUMBERS),
    *(Limit(f"joint B_{i}", f"$B_{i}$", "platform joint") for i in _LIMB_NUMBERS),
    Limit("greatest alpha", r"$\alpha_{\max}$", "range of α"),
    Limit("least alpha", r"$\alpha_{\min}$", "range of α"),
    Limit("revolute joint", "$n_6$", "revolute joint"),
    Limit("singular", r"$\det G = 0$", "singular"),
    Limit("base plane", "$Z = 0$", "base plane"),
)

_REVOLUTE_JOINT, _SINGULAR_LIMIT = (
    [limit.name for limit in _LIMITS].index(name) for name in ("revolute joint", "singular")
)


@dataclasses.dataclass(frozen=True, eq=False)
class Pentapod(SpatialDesign):
    """A 5-DOF manipulator with four SPS limbs and one SPR limb (Wang et al. 2017).

    Poses are (X, Y, Z, α, β, γ), lengths in the unit of the machine and angles in radians; methods
    take any number of them at once, shape (..., 6).

    Parameters
    ----------
    geometry
        The joints.
    home_height
        Height H of the platform at home, where p = (0, 0, H) with parallel axes.
    assumptions
        Limits of limbs and joints, pose box and characteristic length, in units of H. What it
        says of the geometry is not looked at.
    radii
        r_a and r_b, where the joints are on circles of these radii.
    unit
        Unit of lengths; empty where they are non-dimensional.

    Raises
    ------
    InputError
        If H is not above 0, or the joints do not allow the home pose.

    Examples
    --------
    >>> from fivebar_atlas import Pentapod
    >>> robot = Pentapod.from_radii(459.1, 400.0, 100.0, unit="mm")
    >>> robot.inverse_displacement(robot.home).lengths.round(1).tolist()
    [562.2, 586.9, 569.4, 556.3, 549.3]
    """

    geometry: PentapodGeometry
    home_height: float = 1.0
    assumptions: AtlasOptions = dataclasses.field(
        default_factory=lambda: AtlasOptions.chosen(_defaults())
    )
    radii: tuple[float, float] | None = None
    unit: str = ""
    set_options: Options = dataclasses.field(default_factory=lambda: _defaults())

    coordinates = tuple(
        Coordinate(name, symbol, number >= 3)
        for number, (name, symbol) in enumerate(zip(COORDINATES, _SYMBOLS, strict=True))
    )
    limits = _LIMITS

    def __post_init__(self) -> None:
        if not (math.isfinite(self.home_height) and self.home_height > 0.0):
            raise InputError("H", self.home_height, "a finite length above 0")
        try:
            check_poses(self.geometry, self.home)
        except InvalidPoseError as error:
            allowed = "joints that allow the home pose, p = (0, 0, H) with parallel axes"
            raise InputError("axis", self.geometry.axis.tolist(), allowed) from error

    @classmethod
    def from_radii(
        cls, H: float, r_a: float, r_b: float, unit: str = "", options: Options = ()
    ) -> Pentapod:
        """Return the pentapod with joints on circles, as an atlas has it.

        Parameters
        ----------
        H, r_a, r_b
            Height at home and radii of base and platform, in any one unit.
        unit
            That unit; empty where lengths are non-dimensional.
        options
            Sweep options of the pentapod; those that are not among them have their defaults.

        Raises
        ------
        InputError
            If a length is not above 0, an option is not allowed, or they make no pentapod.
        UnknownNameError
            If there is no such option.
        """
        for name, value in (("H", H), ("r_a", r_a), ("r_b", r_b)):
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(name, value, "a finite length above 0")
        from fivebar_atlas.mechanisms.pentapod.mechanism import PentapodMechanism

        complete = PentapodMechanism().complete_options(options)
        assumptions = AtlasOptions.chosen(complete)
        geometry = assumptions.geometry(r_a / H, r_b / H).scaled(H)
        return cls(geometry, H, assumptions, (r_a, r_b), unit, complete)

    @property
    def mechanism(self) -> str:
        """Name of the mechanism."""
        return "pentapod"

    @property
    def options(self) -> Options:
        """Sweep options that the design has."""
        return self.set_options

    @property
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Symbol and value of H and, where joints are on circles, r_a and r_b."""
        height = (("$H$", self.home_height),)
        if self.radii is None:
            return height
        return (*height, *zip(("$r_a$", "$r_b$"), self.radii, strict=True))

    @property
    def home(self) -> tuple[float, ...]:
        """The home pose."""
        return (0.0, 0.0, self.home_height, 0.0, 0.0, 0.0)

    @property
    def characteristic_length(self) -> float:
        """L, in the unit of lengths."""
        chosen = self.assumptions.characteristic_length
        if chosen is not None:
            return chosen * self.home_height
        return self.geometry.platform_radius if self.radii is None else self.radii[1]

    def inverse_displacement(self, poses: npt.ArrayLike) -> Limbs:
        """Return lengths and directions of the limbs (Eqs. 3-5)."""
        return inverse_displacement(self.geometry, poses)

    def forward_displacement(
        self, limb_lengths: npt.ArrayLike, starts: npt.ArrayLike | None = None
    ) -> ForwardDisplacement:
        """Return poses with given limb lengths, found from starts or from home.

        See :func:`forward.forward_displacement`.
        """
        return forward_displacement(
            self.geometry, limb_lengths, self.home if starts is None else starts
        )

    def constraint_residual(self, poses: npt.ArrayLike) -> FloatArray:
        """Return (A_5 - B_5)·n6, 0 where the revolute joint allows a pose, shape (...)."""
        return constraint_residual(self.geometry, poses)

    def solve_constraint(self, poses: npt.ArrayLike, coordinate: str) -> ConstraintSolutions:
        """Return all poses that the revolute joint allows and that differ in one coordinate.

        See :func:`kinematics.solve_constraint`.
        """
        return solve_constraint(self.geometry, poses, coordinate)

    def nearest_valid_pose(self, poses: npt.ArrayLike) -> FloatArray:
        """Return the nearest poses that the revolute joint allows, L for a radian, (..., 6)."""
        return nearest_valid_pose(self.geometry, poses, self.characteristic_length)

    def inverse_velocity(self, poses: npt.ArrayLike, twists: npt.ArrayLike) -> FloatArray:
        """Return the rates of the limb lengths for twists (v, ω), shape (..., 5) (Eq. 8)."""
        return inverse_velocity(self.geometry, poses, twists)

    def forward_velocity(self, poses: npt.ArrayLike, limb_rates: npt.ArrayLike) -> FloatArray:
        """Return twists (v, ω) for rates of the limb lengths, shape (..., 6) (Eq. 10)."""
        return forward_velocity(self.geometry, poses, limb_rates)

    def inverse_acceleration(
        self, poses: npt.ArrayLike, twists: npt.ArrayLike, accelerations: npt.ArrayLike
    ) -> FloatArray:
        """Return the second derivatives of the limb lengths, shape (..., 5) (Eqs. 13-15)."""
        return inverse_acceleration(self.geometry, poses, twists, accelerations)

    def forward_acceleration(
        self, poses: npt.ArrayLike, twists: npt.ArrayLike, limb_accelerations: npt.ArrayLike
    ) -> FloatArray:
        """Return (a, ε) for second derivatives of the limb lengths, shape (..., 6) (Eq. 15)."""
        return forward_acceleration(self.geometry, poses, twists, limb_accelerations)

    def hessians(self, poses: npt.ArrayLike) -> FloatArray:
        """Return H_1 ... H_6 for twists (v, ω), shape (..., 6, 6, 6) (Eqs. 13 and 14)."""
        return hessians(self.geometry, poses)

    def singularity(self, poses: npt.ArrayLike) -> Singularity:
        """Return how singular poses are, and of what kind, with L; see :mod:`singularity`."""
        return singularity(self.geometry, poses, self.characteristic_length)

    def jacobian(self, poses: npt.ArrayLike) -> FloatArray:
        """Return G for twists (v, L ω), shape (..., 6, 6) (Eq. 10)."""
        return without_unit(jacobian(self.geometry, poses), self.characteristic_length)

    def joint_forces(self, poses: npt.ArrayLike, loads: npt.ArrayLike) -> FloatArray:
        """Return F_1 ... F_5 and F_τ that balance loads (F, T), shape (..., 6) (Eq. 16)."""
        return joint_forces(self.geometry, poses, loads)

    def lci(self, poses: npt.ArrayLike) -> FloatArray:
        """Return the least over the largest singular value of G with L, shape (...)."""
        sizes = self._singular_values(poses)
        return np.asarray(sizes[..., -1] / sizes[..., 0])

    def least_singular_value(self, poses: npt.ArrayLike) -> FloatArray:
        """Return the least singular value of G with L, shape (...)."""
        return np.asarray(self._singular_values(poses)[..., -1])

    def largest_limb_force(self, poses: npt.ArrayLike) -> FloatArray:
        """Return the largest |F_i| of a limb for loads with |F|² + |T/L|² = 1, shape (...).

        Infinite in singular poses.
        """
        left, sizes, _ = np.linalg.svd(self.jacobian(poses))
        is_singular = sizes[..., -1] <= _SINGULAR * sizes[..., 0]
        sizes = np.where(is_singular[..., None], 1.0, sizes)
        # column i of the inverse, V Σ⁻¹ Uᵀ, is as long as row i of U Σ⁻¹
        columns = np.linalg.norm(left / sizes[..., None, :], axis=-1)
        force: FloatArray = np.where(is_singular, math.inf, columns[..., :LIMBS].max(axis=-1))
        return force

    def is_usable(self, poses: npt.ArrayLike) -> BoolArray:
        """Return which poses are within the limits of limbs, joints and α, and of home's det G.

        Shape (...). Whether the revolute joint allows them, and the pose box, are not looked at.
        """
        poses = checked("pose", poses, (6,))
        return np.asarray(np.all(self._slacks(poses) >= 0.0, axis=-1))

    def solve_alpha(self, poses: npt.ArrayLike) -> FloatArray:
        """Return poses with the α that the revolute joint asks for, on the branch of home.

        Parameters
        ----------
        poses
            Poses, shape (..., 6); their α is not looked at.

        Returns
        -------
        ndarray
            Poses, shape (..., 6), α in (-π, π]; NaN where there is none.
        """
        poses = checked("pose", poses, (6,))
        turned, room = self._with_alpha(poses)
        turned[..., 3] = np.where(room >= 0.0, turned[..., 3], math.nan)
        return turned

    def pose(self, coordinates: tuple[float, ...]) -> SpatialPose:
        """Return the mechanism in a pose.

        Raises
        ------
        InputError
            If there are not six finite coordinates, a limb has no length, or the revolute joint
            does not allow the pose; the error says by how much, and what the nearest one is.
        """
        pose = checked("pose", coordinates, (6,))
        if pose.ndim != 1:
            raise InputError("pose", pose.shape, "six coordinates")
        try:
            check_poses(self.geometry, pose)
        except InvalidPoseError as error:
            nearest = nearest_valid_pose(self.geometry, pose, self.characteristic_length)
            unit = f" {self.unit}" if self.unit else ""
            allowed = (
                f"a pose that the revolute joint allows: it is {abs(error.residual):.6g}{unit} "
                f"apart along n6; the nearest pose is {self.pose_text(nearest.tolist())}"
            )
            raise InputError("pose", self.pose_text(pose.tolist()), allowed) from None
        found = self.inverse_displacement(pose)
        rotation = rotation_matrices(pose[3:])
        ends = pose[:3] + found.arms
        joints = [
            *(
                SpatialJoint(f"$A_{i}$", place, SPHERICAL)
                for i, place in zip(_LIMB_NUMBERS, self.geometry.base, strict=True)
            ),
            *(
                SpatialJoint(f"$B_{i}$", place, SPHERICAL if i < LIMBS else REVOLUTE)
                for i, place in zip(_LIMB_NUMBERS, ends, strict=True)
            ),
        ]
        return SpatialPose(
            coordinates=tuple(pose.tolist()),
            joints=tuple(joints),
            limbs=tuple(
                Limb(f"$l_{i}$", i - 1, i - 1 + LIMBS, float(length))
                for i, length in zip(_LIMB_NUMBERS, found.lengths, strict=True)
            ),
            base=_around(self.geometry.base),
            platform=tuple(LIMBS + place for place in _around(self.geometry.platform)),
            frames=(
                Frame("$O$", ("$X$", "$Y$", "$Z$"), np.zeros(3), np.eye(3)),
                Frame("$p$", ("$x$", "$y$", "$z$"), pose[:3], rotation.T),
            ),
            axis_symbol="$n_6$",
            axis_joint=2 * LIMBS - 1,
            axis=rotation @ self.geometry.axis,
            lci=float(self.lci(pose)),
            least_singular_value=float(self.least_singular_value(pose)),
            largest_limb_force=float(self.largest_limb_force(pose)),
            characteristic_length=self.characteristic_length,
        )

    def solved(self, coordinates: tuple[float, ...], name: str) -> tuple[float, ...]:
        """Return a pose that the revolute joint allows, one coordinate solved for.

        Of two solutions the one nearer to the given value.

        Raises
        ------
        UnknownNameError
            If there is no such coordinate.
        InputError
            If no value of it will do.
        """
        found = solve_constraint(self.geometry, coordinates, name)
        if int(found.count) == 0:
            allowed = f"a pose that some {name} completes: the revolute joint allows none"
            raise InputError("pose", tuple(coordinates), allowed)
        return tuple(found.poses[0].tolist())

    def slacks(
        self, positions: FloatArray, orientation: tuple[float, float], complete: bool = False
    ) -> FloatArray:
        """Return how far positions are from every limit, with β and γ fixed and α solved for.

        Lengths of limbs and heights in units of H, joints by cosines, α in radians, det G as a
        share of that at home; unless all are wanted, that is 1 where another limit is passed.
        Where the revolute joint allows no α, the nearest to one is taken.
        """
        poses = np.zeros((*positions.shape[:-1], 6))
        poses[..., :3] = positions
        poses[..., 4:] = orientation
        turned, room = self._with_alpha(poses)
        slacks = self._slacks(turned, complete)
        slacks[..., _REVOLUTE_JOINT] = room / self.home_height
        return slacks

    def reach(self) -> tuple[FloatArray, FloatArray]:
        """Return the corners of a box, shape (3,), that no position of a workspace is outside."""
        longest = self.assumptions.limb_max * self._home_limbs.lengths
        reach = longest + np.linalg.norm(self.geometry.platform, axis=-1)
        lower = (self.geometry.base - reach[:, None]).max(axis=0)
        upper = (self.geometry.base + reach[:, None]).min(axis=0)
        lower[2] = max(lower[2], 0.0)
        return lower, upper

    @functools.cached_property
    def _home_limbs(self) -> Limbs:
        return self.inverse_displacement(self.home)

    @functools.cached_property
    def _home_slope(self) -> float:
        """Sign of the derivative of the constraint by α at home."""
        arm, axis = self.geometry.base[-1], self.geometry.axis
        return math.copysign(1.0, float(arm[1] * axis[0] - arm[0] * axis[1]))

    @functools.cached_property
    def _home_determinant(self) -> float:
        return float(np.linalg.det(jacobian(self.geometry, self.home)))

    def _singular_values(self, poses: npt.ArrayLike) -> FloatArray:
        return np.asarray(np.linalg.svd(self.jacobian(poses), compute_uv=False))

    def _with_alpha(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return poses with α solved for, and by how much there is an α: amplitude less |C|."""

        def at(alpha: float) -> FloatArray:
            moved = poses.copy()
            moved[..., 3] = alpha
            return constraint_residual(self.geometry, moved)

        # P cos α + Q sin α + C
        here, quarter, half = at(0.0), at(0.5 * math.pi), at(math.pi)
        middle = 0.5 * (here + half)
        cosine, sine = 0.5 * (here - half), quarter - middle
        amplitude: FloatArray = np.hypot(cosine, sine)
        share = -middle / np.where(amplitude > 0.0, amplitude, 1.0)
        # the derivative is -amplitude sin(α - phase): its sign tells the branch
        turn = -self._home_slope * np.arccos(np.clip(share, -1.0, 1.0))
        turned = poses.copy()
        turned[..., 3] = wrapped(np.arctan2(sine, cosine) + turn)
        return turned, amplitude - np.abs(middle)

    def _slacks(self, poses: FloatArray, complete: bool = False) -> FloatArray:
        """Return how far poses are from every limit, shape (..., limits)."""
        given, height = self.assumptions, self.home_height
        rotations = rotation_matrices(poses[..., 3:])
        found = limbs(self.geometry, poses[..., :3], rotations)
        home = self._home_limbs
        # n_i in platform axes
        inner = found.directions @ rotations
        bends: list[FloatArray] = [
            np.sum(directions * home.directions, axis=-1) - _cosine(limit)
            for directions, limit in (
                (found.directions, given.base_joint_limit),
                (inner, given.platform_joint_limit),
            )
        ]
        alpha = poses[..., 3]
        parts = [
            (given.limb_max * home.lengths - found.lengths) / height,
            (found.lengths - given.limb_min * home.lengths) / height,
            *bends,
            np.stack(
                [
                    given.box_greatest[3] - alpha,
                    alpha - given.box_least[3],
                    np.ones_like(alpha),
                    np.ones_like(alpha),
                    poses[..., 2] / height,
                ],
                axis=-1,
            ),
        ]
        slacks: FloatArray = np.concatenate(parts, axis=-1)
        # what another limit excludes need not be looked at: this takes the longest
        within = np.all(slacks >= 0.0, axis=-1) | complete
        matrices = jacobian_of(
            self.geometry,
            poses[within][..., :3],
            rotations[within],
            Limbs(found.lengths[within], found.directions[within], found.arms[within]),
        )
        slacks[within, _SINGULAR_LIMIT] = np.linalg.det(matrices) / self._home_determinant
        return slacks


def _defaults() -> Options:
    return tuple((option.name, option.default) for option in OPTIONS)


def _cosine(angle: float) -> float:
    """Return the cosine of a joint limit; below all cosines where there is none."""
    return -1.1 if angle >= math.pi else math.cos(angle)


def _around(points: FloatArray) -> tuple[int, ...]:
    """Return points in order around their middle, by the angle in the x-y plane."""
    x, y = (points - points.mean(axis=0))[:, :2].T
    return tuple(np.argsort(np.arctan2(y, x), kind="stable").tolist())
