"""One symmetric five-bar manipulator, for scripts and notebooks."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.five_bar import points
from fivebar_atlas.mechanisms.five_bar.containment import bounds_on_discs
from fivebar_atlas.mechanisms.five_bar.design_space import (
    OUTSIDE,
    SUB_REGIONS,
    normalise,
    sub_region,
)
from fivebar_atlas.mechanisms.five_bar.isotropy import MAX_ISOTROPIC, isotropic_points
from fivebar_atlas.mechanisms.five_bar.loci import isolated_points, singular_arcs
from fivebar_atlas.mechanisms.five_bar.mechanism import FiveBarMechanism
from fivebar_atlas.mechanisms.five_bar.outline import UsableWorkspace, usable_workspace_of
from fivebar_atlas.mechanisms.five_bar.path import check_path
from fivebar_atlas.mechanisms.five_bar.path_least import least_on_path
from fivebar_atlas.mechanisms.five_bar.poses import forward_poses, inverse_poses, pose_at
from fivebar_atlas.mechanisms.five_bar.singularity import change_point_cases
from fivebar_atlas.mechanisms.five_bar.workspace import theoretical_area
from fivebar_atlas.mechanisms.mode_pairs import (
    ASSEMBLY_MODES,
    mode_pairs,
    mode_signs,
)
from fivebar_atlas.mechanisms.planar import PathLeast, PathReport, Pose
from fivebar_atlas.mechanisms.settings import (
    DEFAULT_LCI_THRESHOLDS,
    DEFAULT_TOLERANCE,
    SweepSettings,
)
from fivebar_atlas.mechanisms.two_legged_design import (
    TwoLeggedDesign,
    flat_discs,
    flat_points,
    in_mode,
    two_angles,
)
from fivebar_atlas.planar_geometry import CircleArc, NamedArc, Point

_MECHANISM = FiveBarMechanism()
#: How far r1 + r2 + r3 may be from 3.
_SUM_SLACK = 1e-9


@dataclasses.dataclass(frozen=True)
class FiveBar(TwoLeggedDesign):
    """A symmetric planar 5R parallel manipulator in non-dimensional form.

    A1 = (-r3, 0) and A2 = (r3, 0) are the base joints, r1 the actuated links A_iB_i and r2
    the distal links B_iP. Points and lengths are non-dimensional throughout; times
    ``dimensional_factor`` they are those of the machine. Points may be scalars or arrays,
    which broadcast; results have their shape, with NaN where P is out of reach.

    Mode pairs are written ``"+-/up"`` (or ``"pm/up"``): the sides of the two elbows and the
    sign of det B. Where only the elbows matter, ``"+-"`` will do.

    Parameters
    ----------
    r1, r2, r3
        Non-dimensional lengths, r1 + r2 + r3 = 3 (Liu, Wang and Zheng 2006, Eq. 30).
    dimensional_factor
        D of Eq. 28; 1 unless the manipulator was made from lengths.

    Raises
    ------
    InputError
        If a length is not positive (r3 may be 0) and finite, the sum is not 3, or the links
        are too short to be assembled.

    Examples
    --------
    >>> from fivebar_atlas import FiveBar
    >>> robot = FiveBar.from_lengths(26, 30, 16)
    >>> robot.dimensional_factor, robot.sub_region
    (24.0, 'Va')
    >>> round(float(robot.lci(0.0, 1.5, "+-")), 6)
    0.460911
    >>> values = robot.evaluate("+-/up", lci_thresholds=[0.5])
    >>> round(values["gci"], 4), values["status"]
    (0.3742, 'ok')
    """

    r1: float
    r2: float
    r3: float
    dimensional_factor: float = 1.0

    def __post_init__(self) -> None:
        lengths = (self.r1, self.r2, self.r3)
        normalise(lengths)
        if abs(sum(lengths) - 3.0) > _SUM_SLACK:
            raise InputError(
                "r1 + r2 + r3",
                sum(lengths),
                "a sum of 3; FiveBar.from_lengths scales lengths of any size",
            )

    @classmethod
    def from_lengths(cls, R1: float, R2: float, R3: float) -> FiveBar:
        """Return the manipulator with these lengths, in any one unit (Eqs. 28, 29).

        Raises
        ------
        InputError
            If a length is not positive (R3 may be 0) and finite, or the links are too short
            to be assembled.
        """
        design, factor = normalise((R1, R2, R3))
        r1, r2, r3 = (float(r) for r in design)
        return cls(r1, r2, r3, factor)

    @property
    def lengths(self) -> tuple[float, float, float]:
        """R1, R2, R3, the lengths times the dimensional factor."""
        factor = self.dimensional_factor
        return factor * self.r1, factor * self.r2, factor * self.r3

    @property
    def sub_region(self) -> str:
        """Sub-region of the design space: IVa, Va, Vb, IVb, or outside the surrounded space."""
        return SUB_REGIONS.describe(int(sub_region(self._design)[0]))

    @property
    def change_point_cases(self) -> str:
        """Letters (a) to (f) of the conditions for singularities of the third kind."""
        return change_point_cases(self.r1, self.r2, self.r3)

    @property
    def mechanism(self) -> str:
        """Name of the mechanism."""
        return _MECHANISM.name

    @property
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Symbol and value of r1, r2 and r3."""
        symbols = (parameter.symbol for parameter in _MECHANISM.parameters)
        return tuple(zip(symbols, self._lengths, strict=True))

    def remarks(self) -> tuple[str, ...]:
        """Return sub-region and conditions for singularities of the third kind, in words."""
        cases = self.change_point_cases
        is_outside = int(sub_region(self._design)[0]) == OUTSIDE
        place = "workspace not surrounded" if is_outside else f"sub-region {self.sub_region}"
        found = [place]
        if set(cases) - {"f"}:
            found.append(f"change-point manipulator ({', '.join(sorted(set(cases) - {'f'}))})")
        if "f" in cases:
            found.append("singular throughout in ++ and −− (f)")
        return tuple(found)

    @property
    def theoretical_workspace_area(self) -> float:
        """Area that both legs reach, in closed form."""
        return theoretical_area(self.r1, self.r2, self.r3)

    def inverse_kinematics(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return the input angles θ1, θ2 in radians, in (-π, π] (Eqs. 6, 7)."""
        flat, shape = flat_points(x, y)
        theta1, theta2 = np.empty_like(flat[0]), np.empty_like(flat[0])
        points.inverse_at(*self._lengths, *flat, *_working_mode(mode), theta1, theta2)
        return theta1.reshape(shape), theta2.reshape(shape)

    def forward_kinematics(
        self, theta1: npt.ArrayLike, theta2: npt.ArrayLike, assembly_mode: str = "up"
    ) -> tuple[FloatArray, FloatArray]:
        """Return P = (x, y) for input angles in radians (Eqs. 8 to 12).

        NaN where the linkage cannot be assembled, or P is free because B1 = B2.
        """
        flat, shape = flat_points(theta1, theta2)
        x, y = np.empty_like(flat[0]), np.empty_like(flat[0])
        points.forward_at(*self._lengths, *flat, _assembly_mode(assembly_mode), x, y)
        return x.reshape(shape), y.reshape(shape)

    def elbows(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return B1 and B2, each of shape (..., 2)."""
        flat, shape = flat_points(x, y)
        out = np.empty((len(flat[0]), 4))
        points.elbows_at(*self._lengths, *flat, *_working_mode(mode), out)
        return out[:, :2].reshape(*shape, 2), out[:, 2:].reshape(*shape, 2)

    def jacobian_matrices(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return A and B of A θ' = B p' (Eqs. 15, 18, 19), each of shape (..., 2, 2)."""
        flat, shape = flat_points(x, y)
        out = np.empty((len(flat[0]), 6))
        points.matrices_at(*self._lengths, *flat, *_working_mode(mode), out)
        a = np.zeros((len(out), 2, 2))
        a[:, 0, 0], a[:, 1, 1] = out[:, 0], out[:, 1]
        return a.reshape(*shape, 2, 2), out[:, 2:].reshape(*shape, 2, 2)

    def jacobian(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return J = A⁻¹ B (Eq. 20), shape (..., 2, 2); infinite at serial singularities."""
        a, b = self.jacobian_matrices(x, y, mode)
        diagonal = np.diagonal(a, axis1=-2, axis2=-1)[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(b / diagonal)

    def lci(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return the local conditioning index σ_min/σ_max of J, 2-norm; 0 if singular."""
        flat, shape = flat_points(x, y)
        out = np.empty_like(flat[0])
        points.lci_at(*self._lengths, *flat, *_working_mode(mode), out)
        return out.reshape(shape)

    def assembly_mode(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return the sign of det B: 1 up, -1 down, 0 parallel singular."""
        _, b = self.jacobian_matrices(x, y, mode)
        return np.asarray(np.sign(b[..., 0, 0] * b[..., 1, 1] - b[..., 0, 1] * b[..., 1, 0]))

    def singularity(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-", tolerance: float = 1e-9
    ) -> IntArray:
        """Return the kinds of singularity at points as bits (Sec. 4).

        1 and 2: leg 1 or 2 stretched or folded (first kind); 4: B1 and B2 coincide, 8: B1, P
        and B2 in line (second kind); a sum of both is of the third kind. 0 where regular,
        -1 where P is out of reach. ``tolerance`` bounds |sin β_i| and |sin γ|.
        """
        flat, shape = flat_points(x, y)
        out = np.empty(len(flat[0]), dtype=np.int64)
        points.singularity_at(*self._lengths, *flat, *_working_mode(mode), tolerance, out)
        return out.reshape(shape)

    def singular_loci(self, mode: str | None = None) -> tuple[NamedArc, ...]:
        """Return the singular loci as exact arcs, cut where they meet (Sec. 4, 6; Figs. 3, 5).

        Parameters
        ----------
        mode
            A mode pair or a working mode alone, for its loci only; None for all.

        Returns
        -------
        tuple of NamedArc
            Parts of reach circles that the other leg does not reach are left out. ``sides``
            says for which mode pairs an arc is singular, and on which side of it they are.

        Raises
        ------
        UnknownNameError
            If there is no such mode.
        """
        return singular_arcs(self._lengths, mode_pairs(mode))

    def isolated_singular_points(self) -> tuple[Point, ...]:
        """Return the base joints where r1 = r2: there C_1i and C_2i are points."""
        return isolated_points(self._lengths)

    def usable_workspace(self, mode: str = "+-/up") -> UsableWorkspace | None:
        """Return the usable workspace of a mode pair (Sec. 7), None where it is empty.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        """
        return _workspace(self._lengths, mode_signs(_MECHANISM.parse_mode(mode)))

    def good_condition_area(
        self, lci_threshold: float = 0.5, mode: str = "+-/up"
    ) -> tuple[float, float]:
        """Return the area of the usable workspace with at least this LCI, and its error.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If the threshold is not above 0 and below 1.
        """
        (found,) = self.evaluate(mode, [lci_threshold])["good_condition"]
        return found["area"], found["area_error"]

    def _peaks(self, mode: str) -> tuple[Point, ...]:
        """Return the isotropic points of a working mode, and where the LCI is largest."""
        found = np.empty((MAX_ISOTROPIC, 2))
        count = isotropic_points(*self._lengths, *_working_mode(mode), found)
        largest = self.largest_lci(mode)
        isotropic = [(float(x), float(y)) for x, y in found[:count]]
        return (*isotropic, *(() if largest is None else (largest[1],)))

    def inscribed_circles(self, mode: str = "+-/up") -> tuple[CircleArc, ...]:
        """Return the maximal inscribed circles with centres on the y axis, upper one first.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        """
        values = self.evaluate(mode, (), _MECHANISM.tolerance_range[1])
        circles = (values["mic_upper"], values["mic_lower"])
        return tuple(
            CircleArc.whole((0.0, circle["y"]), circle["radius"])
            for circle in circles
            if circle["radius"] is not None
        )

    def inputs(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return θ1, θ2 in radians, in (-π, π], as one array of shape (..., 2)."""
        return np.stack(self.inverse_kinematics(x, y, mode), axis=-1)

    def joint_positions(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return A1, A2, B1 and B2 as one array of shape (..., 4, 2)."""
        b1, b2 = self.elbows(x, y, mode)
        bases = (np.broadcast_to((base, 0.0), b1.shape) for base in (-self.r3, self.r3))
        return np.stack([*bases, b1, b2], axis=-2)

    def bounds_on_discs(
        self, x: npt.ArrayLike, y: npt.ArrayLike, radius: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return a lower bound of the LCI over discs, and how far θ1 and θ2 turn at most.

        Parameters
        ----------
        x, y, radius
            Centres and radii, which broadcast.
        mode
            Working mode, alone or as part of a mode pair.

        Returns
        -------
        least : ndarray
            No point of the disc has a smaller LCI, shape (n,); 0 where nothing can be said.
            Where it is positive there is no singularity in the disc.
        turns : ndarray
            Largest differences of θ1 and θ2, in radians, between a point of the disc and its
            centre, shape (n, 2); infinite where nothing can be said.
        """
        xs, ys, radii = flat_discs(x, y, radius)
        least, turns = np.empty(len(xs)), np.empty((len(xs), 2))
        bounds_on_discs(*self._lengths, xs, ys, radii, *_working_mode(mode), least, turns)
        return least, turns

    def largest_lci(self, mode: str = "+-/up") -> tuple[float, Point] | None:
        """Return the largest LCI of the usable workspace of a mode pair, and where it is.

        It may be a limit in a corner of the workspace. None where the workspace is empty.
        """
        values = self.evaluate(mode, (), _MECHANISM.tolerance_range[1])
        if values["max_lci"] is None:
            return None
        return values["max_lci"], (values["max_lci_x"], values["max_lci_y"])

    def pose(self, x: float, y: float, mode: str = "+-") -> Pose:
        """Return the linkage with its output point at P, in a mode pair or working mode.

        Raises
        ------
        OutOfReachError
            If P cannot be reached; the message says by how much.
        UnknownNameError
            If there is no such mode.
        InputError
            If an assembly mode is given and P belongs to the other one.
        """
        found = pose_at(self._lengths, x, y, *mode_pairs(mode)[0][:2])
        return in_mode(found, mode, (x, y))

    def inverse_poses(self, x: float, y: float) -> tuple[Pose, ...]:
        """Return the linkage with its output point at P in all four working modes (Eq. 7).

        Raises
        ------
        OutOfReachError
            If P cannot be reached; the message says by how much.
        """
        return inverse_poses(self._lengths, x, y)

    def forward_poses(self, inputs: Sequence[float]) -> tuple[Pose, ...]:
        """Return the linkage for θ1, θ2 in radians, assembled up and down (Eq. 12).

        Raises
        ------
        InputError
            If there are not two finite angles.
        OutOfReachError
            If the linkage cannot be assembled; the message says by how much.
        """
        return forward_poses(self._lengths, *two_angles(inputs, "θ1 and θ2"))

    def check_path(self, points: npt.ArrayLike, mode: str = "+-/up") -> PathReport:
        """Tell whether a path of straight segments can be followed, exactly between its points.

        Parameters
        ----------
        points
            Corners of the path, shape (n, 2).
        mode
            Mode pair that is kept throughout.

        Returns
        -------
        PathReport
            Continuous input angles, LCI and distance from the nearest locus at the corners,
            and the first fault if there is one.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If there are no points, or one is not finite.
        """
        signs = mode_signs(_MECHANISM.parse_mode(mode))
        return check_path(self._lengths, signs, np.asarray(points, dtype=np.float64))

    def least_on_path(
        self, points: npt.ArrayLike, mode: str = "+-/up"
    ) -> tuple[PathLeast, PathLeast]:
        """Return the least LCI and the least distance from a singular locus on a path.

        Between its corners, shape (n, 2), too.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If the path cannot be followed: there both go to 0.
        """
        signs = mode_signs(_MECHANISM.parse_mode(mode))
        return least_on_path(self._lengths, signs, np.asarray(points, dtype=np.float64))

    def evaluate(
        self,
        mode: str = "+-/up",
        lci_thresholds: Sequence[float] = DEFAULT_LCI_THRESHOLDS,
        tolerance: float = DEFAULT_TOLERANCE,
    ) -> dict[str, Any]:
        """Return workspace areas, indices, inscribed circles and errors of one mode pair.

        Parameters
        ----------
        mode
            Mode pair.
        lci_thresholds
            Thresholds of good-condition workspaces, each in (0, 1).
        tolerance
            Relative tolerance of integrated values, 1e-10 to 1e-3.

        Returns
        -------
        dict
            The entries of a mode in ``atlas evaluate --json``, non-dimensional; None for
            what does not exist, explained by ``status``.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If a threshold or the tolerance is out of range.
        """
        thresholds = tuple(float(threshold) for threshold in lci_thresholds)
        _MECHANISM.check_thresholds(thresholds, "lci_thresholds")
        _MECHANISM.check_tolerance(tolerance, "tolerance")
        settings = SweepSettings(
            mechanism=_MECHANISM.name,
            space=_MECHANISM.spaces[0],
            resolution=_MECHANISM.resolution_range[0],
            modes=(_MECHANISM.parse_mode(mode),),
            lci_thresholds=thresholds,
            tolerance=tolerance,
        )
        results = _MECHANISM.evaluate(self._design, settings)
        document = _MECHANISM.document(self._design[0], self.dimensional_factor, settings, results)
        values: dict[str, Any] = document["modes"][0]
        return values

    @property
    def _lengths(self) -> tuple[float, float, float]:
        """Lengths as the kernels take them."""
        return float(self.r1), float(self.r2), float(self.r3)

    @property
    def _design(self) -> FloatArray:
        """The design as one row of a parameter array."""
        return np.array([self._lengths])


@functools.lru_cache(maxsize=64)
def _workspace(
    lengths: tuple[float, float, float], signs: tuple[int, int, int]
) -> UsableWorkspace | None:
    """Return a usable workspace; the last ones are kept."""
    return usable_workspace_of(lengths, signs)


def _working_mode(mode: str) -> tuple[float, float]:
    """Return the signs of a working mode, given alone or as part of a mode pair."""
    label = _MECHANISM.parse_mode(mode if "/" in mode else f"{mode}/up")
    s1, s2, _ = mode_signs(label)
    return float(s1), float(s2)


def _assembly_mode(mode: str) -> float:
    """Return the sign of an assembly mode, given alone or as part of a mode pair."""
    name = mode.rpartition("/")[2].strip().lower()
    if name not in ASSEMBLY_MODES.meanings:
        raise UnknownNameError("assembly_mode", mode, ASSEMBLY_MODES.meanings)
    return float(ASSEMBLY_MODES.values[ASSEMBLY_MODES.meanings.index(name)])
