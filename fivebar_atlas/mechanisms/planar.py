"""One design of a mechanism whose output point moves in a plane, as figures and files need it.

Everything here has the lengths of the machine: what a :class:`PlanarDesign` returns is in its
``unit``, or non-dimensional where that is empty. Angles are in radians.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Sequence

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.settings import Options
from fivebar_atlas.planar_geometry import CircleArc, NamedArc, Point, Region

#: What a joint is.
ACTUATED, PASSIVE, OUTPUT = "actuated", "passive", "output"
#: Unit of angles.
RADIANS = "rad"
#: What a link is: the fixed base, driven by an actuator, driven by other links, the platform that
#: carries the output point, or a leg of variable length that nothing drives.
BASE, CRANK, DISTAL = "base", "crank", "distal"
PLATFORM, TELESCOPE = "platform", "telescope"


@dataclasses.dataclass(frozen=True, slots=True)
class Joint:
    """A joint of a linkage in a pose.

    Attributes
    ----------
    symbol
        The field's notation as mathtext, ``"$A_1$"``.
    position
        Where it is.
    kind
        ``ACTUATED``, ``PASSIVE`` or ``OUTPUT``.
    """

    symbol: str
    position: Point
    kind: str


@dataclasses.dataclass(frozen=True, slots=True)
class Link:
    """A link of a linkage in a pose.

    Attributes
    ----------
    symbol
        The field's notation of its length as mathtext, ``"$r_1$"``; empty where it has none.
        That of a base is the distance of its joints from the origin.
    start, end
        The joints at its ends, as places in the pose's joints.
    kind
        ``BASE``, ``CRANK``, ``DISTAL``, ``PLATFORM`` or ``TELESCOPE``.
    """

    symbol: str
    start: int
    end: int
    kind: str


@dataclasses.dataclass(frozen=True, slots=True)
class Pose:
    r"""A linkage in one position.

    Attributes
    ----------
    joints, links
        The linkage.
    inputs
        Input angles in (-π, π].
    input_symbols
        Their notation as mathtext, ``r"$\theta_1$"``.
    mode
        Mode pair it is in, ``"+-/up"``; at a parallel singularity the working mode alone.
    lci
        Local conditioning index.
    """

    joints: tuple[Joint, ...]
    links: tuple[Link, ...]
    inputs: tuple[float, ...]
    input_symbols: tuple[str, ...]
    mode: str
    lci: float

    @property
    def output(self) -> Point:
        """Position of the output point."""
        return next(joint.position for joint in self.joints if joint.kind == OUTPUT)


@dataclasses.dataclass(frozen=True, slots=True)
class PathFault:
    """The first point of a path at which it cannot be followed.

    Attributes
    ----------
    segment
        Number of the straight segment it lies on, from 0; a path of one point has segment 0.
    share
        Where on the segment, from 0 to 1.
    position
        The point.
    curve, symbol, kind
        The locus that is met there: name, notation and kind of singularity. Empty where the
        path does not begin in the usable workspace for another reason.
    phrase
        What is wrong, ``{gap}`` in place of a length.
    gap, unit
        That length and its unit; 0 where there is none.
    """

    segment: int
    share: float
    position: Point
    curve: str
    symbol: str
    kind: str
    phrase: str
    gap: float = 0.0
    unit: str = ""

    @property
    def reason(self) -> str:
        """What is wrong, in words."""
        return self.phrase.format(gap=f"{self.gap:.6g} {self.unit}".rstrip())


@dataclasses.dataclass(frozen=True, slots=True)
class PathLeast:
    """Where something is least on a path, between its corners too.

    Attributes
    ----------
    value
        The least value.
    segment, share
        Number of the straight segment from 0, and where on it, from 0 to 1.
    position
        The point.
    """

    value: float
    segment: int
    share: float
    position: Point


@dataclasses.dataclass(frozen=True, slots=True)
class PathReport:
    """Whether a path of straight segments can be followed in one mode pair, and how well.

    Attributes
    ----------
    mode
        The mode pair.
    points
        Corners of the path, shape (n, 2).
    inputs
        Input angles at the corners, continuous along the path, shape (n, inputs); NaN from
        the first fault on.
    lci
        Local conditioning index at the corners, shape (n,); NaN from the first fault on.
    distances
        Distance of the corners from the nearest singular locus of the mode pair, shape (n,);
        NaN from the first fault on.
    nearest
        Name of that locus; empty from the first fault on.
    fault
        The first fault, None where the whole path can be followed.
    """

    mode: str
    points: FloatArray
    inputs: FloatArray
    lci: FloatArray
    distances: FloatArray
    nearest: tuple[str, ...]
    fault: PathFault | None

    @property
    def feasible(self) -> bool:
        """Whether the whole path, between its corners too, can be followed."""
        return self.fault is None


@dataclasses.dataclass(frozen=True, slots=True)
class OptimalConfiguration:
    """A design and a pose of it in closed form that are the best at once.

    Attributes
    ----------
    lengths
        The lengths of the mechanism, the first one 1.
    output
        Position of the output point.
    mode
        The mode pair it belongs to.
    """

    lengths: tuple[float, ...]
    output: Point
    mode: str


@dataclasses.dataclass(frozen=True)
class PlacementScan:
    """A shape that is to be placed in many designs, on samples.

    Attributes
    ----------
    mode
        Mode pair.
    lci_threshold
        Least LCI of its points.
    samples
        Points of the shape relative to its centre, shape (k, 2).
    anchors
        Positions of its centre as shares of the reach along x and y, shape (m, 2).
    limits
        For each limited input its number from 0, the middle and half the width of its range in
        radians, shape (j, 3).
    options
        Sweep options of the mechanism.
    """

    mode: str
    lci_threshold: float
    samples: FloatArray
    anchors: FloatArray
    limits: FloatArray
    options: Options = ()


@dataclasses.dataclass(frozen=True, slots=True)
class PlacedExtremes:
    """What placed shapes bring with them, in non-dimensional lengths; infinite if singular.

    Attributes
    ----------
    moves
        How far the output moves at most for input errors of 1 rad, shape (n,).
    torques
        Largest torque of an input for a unit force, shape (n,).
    lower, upper
        Corners of the box around all joints and the output, shape (n, 2).
    """

    moves: FloatArray
    torques: FloatArray
    lower: FloatArray
    upper: FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Workspace:
    """A usable workspace in the plane.

    Attributes
    ----------
    region
        Outline and holes as exact arcs.
    area
        Area as it is integrated; :attr:`Region.area` is the same by Green's theorem.
    """

    region: Region
    area: float


@dataclasses.dataclass(frozen=True, slots=True)
class OperatingLimits:
    """Least and greatest inputs over the usable workspace, for each value of a coordinate.

    Nam and Park (2006), Fig. 9.

    Attributes
    ----------
    coordinate
        The field's notation of the coordinate as mathtext, ``"$x$"``.
    coordinate_name
        What it is, in a phrase.
    unit
        Its unit: ``RADIANS`` for an angle, else that of the design's lengths.
    places
        Its values, ascending, shape (n,).
    least, greatest
        Extremes of the inputs in radians, continuous where the workspace is, shape
        (n, inputs); NaN where no point of the workspace has the coordinate.
    input_symbols
        Notation of the inputs as mathtext.
    """

    coordinate: str
    coordinate_name: str
    unit: str
    places: FloatArray
    least: FloatArray
    greatest: FloatArray
    input_symbols: tuple[str, ...]


class PlanarDesign(ABC):
    """One dimensioned design."""

    @property
    @abstractmethod
    def mechanism(self) -> str:
        """Name of the mechanism."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Symbol and value of every length of the mechanism, in its order.

        They are those of its ``proportions`` where the unit is empty, of its ``lengths``
        otherwise.
        """

    @property
    @abstractmethod
    def unit(self) -> str:
        """Unit of all lengths; empty where they are non-dimensional."""

    @property
    @abstractmethod
    def factor(self) -> float:
        """Dimensional factor D in that unit; 1 where lengths are non-dimensional."""

    @property
    def named_lengths(self) -> dict[str, float]:
        """Value of every length by its name: ``"R1"``, or ``"r1"`` where the unit is empty."""
        own = mechanisms.get(self.mechanism)
        names = [each.name for each in (own.lengths if self.unit else own.proportions)]
        values = [value for _, value in self.parameters]
        return dict(zip(names, values, strict=True))

    @property
    def options(self) -> Options:
        """Sweep options of its mechanism, all of them."""
        return ()

    @abstractmethod
    def remarks(self) -> tuple[str, ...]:
        """Return what is special about the design, in phrases: sub-region, change points."""

    @abstractmethod
    def singular_loci(self, mode: str | None = None) -> tuple[NamedArc, ...]:
        """Return the singular loci as arcs cut where they meet.

        Parameters
        ----------
        mode
            A mode pair or a working mode alone, for its loci only; None for all.

        Raises
        ------
        UnknownNameError
            If there is no such mode.
        """

    @abstractmethod
    def isolated_singular_points(self) -> tuple[Point, ...]:
        """Return singular points that no arc passes through."""

    @abstractmethod
    def usable_workspace(self, mode: str) -> Workspace | None:
        """Return the usable workspace of a mode pair, None where it is empty."""

    @abstractmethod
    def good_condition_workspace(self, lci_threshold: float, mode: str) -> tuple[Region, ...]:
        """Return the parts of the usable workspace with at least this LCI, largest first.

        Their boundary arcs are polylines whose corners lie on the level curve exactly.
        """

    @abstractmethod
    def good_condition_area(self, lci_threshold: float, mode: str) -> tuple[float, float]:
        """Return the area of the usable workspace with at least this LCI, and its error.

        Integrated, not that of the polylines above.
        """

    @abstractmethod
    def inscribed_circles(self, mode: str) -> tuple[CircleArc, ...]:
        """Return the maximal inscribed circles of the usable workspace, those there are."""

    @abstractmethod
    def lci(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return the LCI at points in a working mode; NaN out of reach."""

    @abstractmethod
    def lci_inside(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return the LCI at points of the usable workspace of a mode pair, 0 elsewhere.

        Continuous where the boundary is singular, for there LCI is 0; on a boundary that is a
        limit of a joint it falls to 0 at once.
        """

    @abstractmethod
    def inputs(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return the input angles at points in a working mode, in (-π, π].

        Shape (n, inputs) for n points; NaN out of reach.
        """

    @abstractmethod
    def joint_positions(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return all joints but the output, base joints too, at points in a working mode.

        Shape (n, joints, 2) for n points; NaN out of reach.
        """

    @abstractmethod
    def jacobian(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return J of θ' = J p' at points in a working mode, in radians per length.

        Shape (n, inputs, 2) for n points; infinite at serial singularities, NaN out of reach.
        """

    @abstractmethod
    def bounds_on_discs(
        self, x: FloatArray, y: FloatArray, radius: FloatArray, mode: str
    ) -> tuple[FloatArray, FloatArray]:
        """Return a lower bound of the LCI over discs, and how far the inputs turn at most.

        Parameters
        ----------
        x, y, radius
            Centres and radii, shape (n,) each.
        mode
            Working mode or mode pair.

        Returns
        -------
        least : ndarray
            No point of the disc has a smaller LCI, shape (n,); 0 where nothing can be said.
            Where it is positive there is no singularity in the disc.
        turns : ndarray
            Largest differences of the inputs, in radians, between a point of the disc and
            its centre, shape (n, inputs); infinite where nothing can be said.
        """

    @abstractmethod
    def largest_lci(self, mode: str) -> tuple[float, Point] | None:
        """Return the largest LCI of the usable workspace of a mode pair, and where it is.

        It may be a limit in a corner of the workspace. None where the workspace is empty.
        """

    def operating_limits(self, mode: str, count: int) -> OperatingLimits:  # noqa: ARG002
        """Return the least and the greatest inputs over the usable workspace of a mode pair.

        Parameters
        ----------
        mode
            Mode pair.
        count
            Number of values of the coordinate, at least 2.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If the mechanism has no coordinate that says what limits its inputs.
        """
        raise InputError(
            "mechanism", self.mechanism, "a mechanism with operating limits over a coordinate"
        )

    @abstractmethod
    def pose(self, x: float, y: float, mode: str) -> Pose:
        """Return the linkage with its output point at P, in a mode pair or working mode.

        Raises
        ------
        InputError
            If P cannot be reached; the message says by how much. If the mode pair is given
            and P belongs to the other assembly mode.
        """

    @abstractmethod
    def inverse_poses(self, x: float, y: float) -> tuple[Pose, ...]:
        """Return the linkage with its output point at P in every working mode.

        Raises
        ------
        InputError
            If P cannot be reached; the message says by how much.
        """

    @abstractmethod
    def forward_poses(self, inputs: Sequence[float]) -> tuple[Pose, ...]:
        """Return the linkage for given input angles in every assembly mode.

        Raises
        ------
        InputError
            If there are too few or too many inputs, or the linkage cannot be assembled; the
            message says by how much.
        """

    @abstractmethod
    def check_path(self, points: FloatArray, mode: str) -> PathReport:
        """Tell whether a path can be followed in a mode pair, exactly between its points too.

        Parameters
        ----------
        points
            Corners of the path, shape (n, 2), joined by straight segments.
        mode
            Mode pair.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If the path has no points or one that is not finite.
        """

    @abstractmethod
    def least_on_path(self, points: FloatArray, mode: str) -> tuple[PathLeast, PathLeast]:
        """Return the least LCI and the least distance from a singular locus on a path.

        Between its corners too.

        Parameters
        ----------
        points
            Corners of a path that can be followed, shape (n, 2).
        mode
            Mode pair.

        Raises
        ------
        InputError
            If the path cannot be followed: there both go to 0.
        """
