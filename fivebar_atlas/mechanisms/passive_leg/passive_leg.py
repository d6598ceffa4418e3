"""One manipulator with two RRR legs and a passive leg, for scripts and notebooks."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.mode_pairs import (
    Signs,
    mode_pairs,
    mode_signs,
    parse_mode_pair,
)
from fivebar_atlas.mechanisms.passive_leg import points
from fivebar_atlas.mechanisms.passive_leg.containment import (
    bounds_on_discs,
    bounds_on_segments,
)
from fivebar_atlas.mechanisms.passive_leg.evaluation import evaluate_designs
from fivebar_atlas.mechanisms.passive_leg.inscribed_circle import largest_circle_on_axis
from fivebar_atlas.mechanisms.passive_leg.loci import Limits, isolated_points, singular_arcs
from fivebar_atlas.mechanisms.passive_leg.operating_limits import operating_limits
from fivebar_atlas.mechanisms.passive_leg.outline import UsableWorkspace, usable_workspace_of
from fivebar_atlas.mechanisms.passive_leg.path import check_path
from fivebar_atlas.mechanisms.passive_leg.path_least import least_on_path
from fivebar_atlas.mechanisms.passive_leg.points import Lengths
from fivebar_atlas.mechanisms.passive_leg.poses import forward_poses, inverse_poses, pose_at
from fivebar_atlas.mechanisms.paths import columns
from fivebar_atlas.mechanisms.planar import (
    OperatingLimits,
    PathLeast,
    PathReport,
    Pose,
)
from fivebar_atlas.mechanisms.settings import Options
from fivebar_atlas.mechanisms.two_legged_design import (
    TwoLeggedDesign,
    check_threshold,
    flat_discs,
    flat_points,
    in_mode,
    two_angles,
)
from fivebar_atlas.planar_geometry import CircleArc, NamedArc, Point

# Tolerance of the largest LCI's surroundings and of areas.
_TOLERANCE = 1e-6
# How far l_a may be from l_b - R + r for the architecture singularity at O.
_SAME = 1e-9


@dataclasses.dataclass(frozen=True)
class PassiveLeg(TwoLeggedDesign):
    """A 2-DOF planar manipulator with two RRR legs and a passive RP leg, R = 1.

    B_1 = (1, 0) and B_2 = (-1, 0) are the actuated base joints, l_a the lower links B_i d_i and l_b
    the upper links d_i b_i. The platform b_2 b_1 has the half length r and stands across the end
    C of the passive leg O C, whose length nothing drives (Nam and Park 2006, Fig. 1). The output
    point is C. Points may be scalars or arrays, which broadcast; results have their shape, with
    NaN where a leg does not reach or the passive leg is beyond its limit.

    Mode pairs are written ``"+-/up"`` (or ``"pm/up"``): the signs of Eq. 6 for both legs, and up
    where det J_x is negative in the axes of the platform. Where only the elbows matter, ``"+-"``
    will do.

    Parameters
    ----------
    r, l_a, l_b
        Half the platform, lower and upper links, in units of R.
    theta_limit
        Largest angle of the passive leg from the y axis in radians, at most π/2.
    passive_joint_limits
        Whether workspaces end where an upper link is level with the platform (Sec. 4).

    Raises
    ------
    InputError
        If a length is not positive and finite, the limit is out of range, or the links are too
        short to be assembled.

    Examples
    --------
    >>> from fivebar_atlas import PassiveLeg
    >>> robot = PassiveLeg(1.2, 1.4, 1.2)
    >>> round(robot.usable_workspace("+-/up").area, 6)
    5.784829
    """

    r: float
    l_a: float
    l_b: float
    theta_limit: float = 0.5 * math.pi
    passive_joint_limits: bool = True

    def __post_init__(self) -> None:
        for name, length in (("r", self.r), ("l_a", self.l_a), ("l_b", self.l_b)):
            if not (math.isfinite(length) and length > 0.0):
                raise InputError(name, length, "a finite length above 0")
        if not 0.0 < self.theta_limit <= 0.5 * math.pi:
            degrees = math.degrees(self.theta_limit)
            raise InputError("theta_limit", degrees, "an angle above 0 and up to 90 deg")
        if self.l_a + self.l_b <= abs(self.r - 1.0):
            raise InputError(
                "r, l_a, l_b",
                (self.r, self.l_a, self.l_b),
                "links that join base and platform: l_a + l_b above |R - r|",
            )

    @classmethod
    def from_lengths(
        cls,
        R: float,
        r: float,
        l_a: float,
        l_b: float,
        theta_limit: float = 0.5 * math.pi,
        passive_joint_limits: bool = True,
    ) -> PassiveLeg:
        """Return the manipulator with these lengths, in any one unit, in units of R.

        Raises
        ------
        InputError
            If a length is not positive and finite, or they make no manipulator.
        """
        if not (math.isfinite(R) and R > 0.0):
            raise InputError("R", R, "a finite length above 0")
        return cls(r / R, l_a / R, l_b / R, theta_limit, passive_joint_limits)

    @property
    def mechanism(self) -> str:
        """Name of the mechanism."""
        return "passive-leg"

    @property
    def options(self) -> Options:
        """Limits of the passive leg and of the passive joints."""
        return (
            ("theta_limit", math.degrees(self.theta_limit)),
            ("passive_joint_limits", self.passive_joint_limits),
        )

    @property
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Symbol and value of R, r, l_a and l_b."""
        return tuple(zip(("$R$", "$r$", "$l_a$", "$l_b$"), self._lengths, strict=True))

    def remarks(self) -> tuple[str, ...]:
        """Return whether R - r = l_b - l_a, a singularity of the third kind, and the limits."""
        found = []
        if abs(self.l_b - self.l_a - (1.0 - self.r)) <= _SAME:
            found.append("architecture singularity at O")
        if self.theta_limit < 0.5 * math.pi:
            found.append(f"|θ| up to {math.degrees(self.theta_limit):.6g} deg")
        limits = (
            "upper links below the platform" if self.passive_joint_limits else "no joint limits"
        )
        return (*found, limits)

    def singular_loci(self, mode: str | None = None) -> tuple[NamedArc, ...]:
        """Return the singular loci as arcs cut where they meet (Sec. 5.2).

        Parameters
        ----------
        mode
            A mode pair or a working mode alone, for its loci only; None for all.

        Returns
        -------
        tuple of NamedArc
            Parts that no workspace can border on are left out. ``sides`` says for which mode pairs
            an arc is singular, and on which side of it they are.

        Raises
        ------
        UnknownNameError
            If there is no such mode.
        """
        return singular_arcs(self._lengths, self._limits, mode_pairs(mode))

    def isolated_singular_points(self) -> tuple[Point, ...]:
        """Return O, where the passive leg has no length, and points at which b_i is on B_i."""
        return isolated_points(self._lengths, self._limits)

    def usable_workspace(self, mode: str = "+-/up") -> UsableWorkspace | None:
        """Return the usable workspace of a mode pair, None where it is empty.

        The largest connected part of the poses that both legs reach, within all limits, where
        det J_x has one sign.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        """
        return _workspace(self._lengths, self._limits, mode_signs(parse_mode_pair(mode)))

    def _peaks(self, mode: str) -> tuple[Point, ...]:
        """Return where the LCI is largest."""
        largest = self.largest_lci(mode)
        return () if largest is None else (largest[1],)

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
        check_threshold(lci_threshold)
        values = self._evaluated(mode, np.array([lci_threshold]))
        area = float(values["good_condition_workspace_area"][0, 0, 0])
        return area, float(values["good_condition_workspace_area_error"][0, 0, 0])

    def inscribed_circles(self, mode: str = "+-/up") -> tuple[CircleArc, ...]:
        """Return the largest circle inside the usable workspace with its centre on the y axis.

        None in the working modes "++" and "--", whose workspaces are not symmetric.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        """
        workspace = self.usable_workspace(mode)
        signs = mode_signs(parse_mode_pair(mode))
        if workspace is None or signs[0] == signs[1]:
            return ()
        found = largest_circle_on_axis(workspace)
        return () if found is None else (found,)

    def lci(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return the local conditioning index σ_min/σ_max of J, 2-norm; 0 if singular."""
        flat, shape = flat_points(x, y)
        out = np.empty(len(flat[0]))
        points.lci_at(*self._lengths, self.theta_limit, *flat, *_elbows(mode), out)
        return out.reshape(shape)

    def inputs(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return φ1, φ2 in radians, in (-π, π], as one array of shape (..., 2) (Eq. 6)."""
        flat, shape = flat_points(x, y)
        out = np.empty((len(flat[0]), 2))
        points.inputs_at(*self._lengths, self.theta_limit, *flat, *_elbows(mode), out)
        return out.reshape(*shape, 2)

    def upper_links(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return p1, q1, p2, q2, the upper links in the axes of the platform, shape (..., 4)."""
        flat, shape = flat_points(x, y)
        out = np.empty((len(flat[0]), 4))
        points.upper_links_at(*self._lengths, self.theta_limit, *flat, *_elbows(mode), out)
        return out.reshape(*shape, 4)

    def joint_positions(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return B1, B2, O, d1, d2, b1 and b2 as one array of shape (..., 7, 2)."""
        flat, shape = flat_points(x, y)
        out = np.empty((len(flat[0]), 7, 2))
        points.joints_at(*self._lengths, self.theta_limit, *flat, *_elbows(mode), out)
        return out.reshape(*shape, 7, 2)

    def jacobian(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return J of φ' = J C' (Eq. 21), shape (..., 2, 2); infinite where a leg is straight."""
        flat, shape = flat_points(x, y)
        out = np.empty((len(flat[0]), 2, 2))
        points.jacobian_at(*self._lengths, self.theta_limit, *flat, *_elbows(mode), out)
        return out.reshape(*shape, 2, 2)

    def bounds_on_discs(
        self, x: npt.ArrayLike, y: npt.ArrayLike, radius: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return a lower bound of the LCI over discs, and how far φ1 and φ2 turn at most.

        Parameters
        ----------
        x, y, radius
            Centres and radii, which broadcast.
        mode
            Working mode, alone or as part of a mode pair.

        Returns
        -------
        least : ndarray
            No point of the disc has a smaller LCI, shape (n,); 0 where nothing can be said. Where
            it is positive there is neither a singularity nor a limit of a joint in the disc.
        turns : ndarray
            Largest differences of φ1 and φ2, in radians, between a point of the disc and its
            centre, shape (n, 2); infinite where nothing can be said.
        """
        xs, ys, radii = flat_discs(x, y, radius)
        least, turns = np.empty(len(xs)), np.empty((len(xs), 2))
        bounds_on_discs(
            *self._lengths, self.theta_limit, self.passive_joint_limits, xs, ys, radii,
            *_elbows(mode), least, turns,
        )  # fmt: skip
        return least, turns

    def bounds_on_segments(
        self, starts: FloatArray, ends: FloatArray, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return a lower bound of the LCI on segments, and how far φ1 and φ2 turn at most.

        As :meth:`bounds_on_discs`, and closer; turns are those from the middle.

        Parameters
        ----------
        starts, ends
            Ends of the segments, shape (n, 2).
        mode
            Working mode, alone or as part of a mode pair.
        """
        x, y = columns(0.5 * (starts + ends))
        dx, dy = columns(0.5 * (ends - starts))
        least, turns = np.empty(len(x)), np.empty((len(x), 2))
        bounds_on_segments(
            *self._lengths, self.theta_limit, self.passive_joint_limits, x, y, dx, dy,
            *_elbows(mode), least, turns,
        )  # fmt: skip
        return least, turns

    def largest_lci(self, mode: str = "+-/up") -> tuple[float, Point] | None:
        """Return the largest LCI of the usable workspace of a mode pair, and where it is.

        It may be a limit in a corner of the workspace. None where the workspace is empty.
        """
        values = self._evaluated(mode, np.empty(0))
        value, x, y = (float(values[name][0, 0]) for name in ("max_lci", "max_lci_x", "max_lci_y"))
        return None if math.isnan(value) else (value, (x, y))

    def operating_limits(self, mode: str = "+-/up", count: int = 181) -> OperatingLimits:
        """Return the least and the greatest φ1 and φ2 for angles of the passive leg (Fig. 9).

        Parameters
        ----------
        mode
            Mode pair.
        count
            Number of angles over the range of the passive leg, at least 2.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        """
        return operating_limits(self, parse_mode_pair(mode), count)

    def pose(self, x: float, y: float, mode: str = "+-") -> Pose:
        """Return the linkage with C at a point, in a mode pair or working mode.

        Limits of the passive joints b_i are not looked at.

        Raises
        ------
        OutOfReachError
            If a leg does not reach; the message says by how much.
        UnknownNameError
            If there is no such mode.
        InputError
            If the passive leg has no length or is beyond its limit, or an assembly mode is given
            and the pose belongs to the other one.
        """
        found = pose_at(self._lengths, self.theta_limit, x, y, *mode_pairs(mode)[0][:2])
        return in_mode(found, mode, (x, y))

    def inverse_poses(self, x: float, y: float) -> tuple[Pose, ...]:
        """Return the linkage with C at a point in all four working modes (Eq. 6).

        Raises
        ------
        OutOfReachError
            If a leg does not reach; the message says by how much.
        InputError
            If the passive leg has no length or is beyond its limit.
        """
        return inverse_poses(self._lengths, self.theta_limit, x, y)

    def forward_poses(self, inputs: Sequence[float]) -> tuple[Pose, ...]:
        """Return the linkage for φ1, φ2 in radians in every assembly (Eq. 11).

        Those with the passive leg above the base and within its limit, by its rising length.

        Raises
        ------
        InputError
            If there are not two finite angles, or there is no such assembly.
        OutOfReachError
            If the elbows are too far apart; the message says by how much.
        """
        return forward_poses(self._lengths, self.theta_limit, *two_angles(inputs, "φ1 and φ2"))

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
            Continuous input angles, LCI and distance from the boundary of the usable workspace at
            the corners, and the first fault if there is one.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If there are no points, or one is not finite.
        """
        return check_path(self, parse_mode_pair(mode), points)

    def least_on_path(
        self, points: npt.ArrayLike, mode: str = "+-/up"
    ) -> tuple[PathLeast, PathLeast]:
        """Return the least LCI and the least distance from the workspace's boundary on a path.

        Between its corners, shape (n, 2), too.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If the path cannot be followed.
        """
        return least_on_path(self, parse_mode_pair(mode), points)

    def _evaluated(self, mode: str, thresholds: FloatArray) -> dict[str, npt.NDArray[np.float64]]:
        """Return the quantities of the one mode pair."""
        s1, s2, assembly = mode_signs(parse_mode_pair(mode))
        return evaluate_designs(
            np.array([[self.r, self.l_a, self.l_b]], dtype=np.float64),
            np.array([[-s1, -s2, -assembly]]),
            self.theta_limit,
            self.passive_joint_limits,
            thresholds,
            _TOLERANCE,
        )

    @property
    def _lengths(self) -> Lengths:
        """Lengths as the kernels take them."""
        return 1.0, float(self.r), float(self.l_a), float(self.l_b)

    @property
    def _limits(self) -> Limits:
        return Limits(self.theta_limit, self.passive_joint_limits)


@functools.lru_cache(maxsize=64)
def _workspace(lengths: Lengths, limits: Limits, signs: Signs) -> UsableWorkspace | None:
    """Return a usable workspace; the last ones are kept."""
    return usable_workspace_of(lengths, limits, signs)


def _elbows(mode: str) -> tuple[float, float]:
    """Return the elbows of a working mode, given alone or as part of a mode pair."""
    s1, s2, _ = mode_pairs(mode)[0]
    return -float(s1), -float(s2)
