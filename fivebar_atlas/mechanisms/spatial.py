"""One design of a mechanism whose platform moves in space, as figures and commands need it.

Everything here has the lengths of the machine: they are in its ``unit``, or non-dimensional where
that is empty. Angles are in radians.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.settings import Options

#: What a joint is.
SPHERICAL, REVOLUTE, UNIVERSAL = "spherical", "revolute", "universal"


@dataclasses.dataclass(frozen=True, slots=True)
class Coordinate:
    """A coordinate of a pose.

    Attributes
    ----------
    name
        Its name in commands and files, ``"alpha"``.
    symbol
        The field's notation as mathtext.
    is_angle
        Whether it is an angle; a length otherwise.
    """

    name: str
    symbol: str
    is_angle: bool


@dataclasses.dataclass(frozen=True, eq=False)
class SpatialJoint:
    """A joint in a pose: notation as mathtext, position of shape (3,), and what it is."""

    symbol: str
    position: FloatArray
    kind: str


@dataclasses.dataclass(frozen=True, slots=True)
class Limb:
    """A limb of variable length: notation, the places of its joints, and its length."""

    symbol: str
    start: int
    end: int
    length: float


@dataclasses.dataclass(frozen=True, eq=False)
class Frame:
    """Axes of coordinates: notations of origin and axes, origin (3,), directions as rows."""

    symbol: str
    axes: tuple[str, str, str]
    origin: FloatArray
    directions: FloatArray


@dataclasses.dataclass(frozen=True, eq=False)
class SpatialPose:
    """A mechanism in one position.

    Attributes
    ----------
    coordinates
        The pose, in the order of the design's coordinates.
    joints, limbs
        The mechanism; the first joint of a limb is on the base.
    base, platform
        Corners of both bodies as places of joints, in order around.
    frames
        That of the base, then that of the platform.
    axis_symbol, axis_joint, axis
        Notation, joint and direction of the axis of a revolute joint.
    lci, least_singular_value, largest_limb_force
        Indices in this pose; the force is infinite in a singular one.
    characteristic_length
        Length L that makes turns and moments comparable with displacements and forces in them.
    """

    coordinates: tuple[float, ...]
    joints: tuple[SpatialJoint, ...]
    limbs: tuple[Limb, ...]
    base: tuple[int, ...]
    platform: tuple[int, ...]
    frames: tuple[Frame, Frame]
    axis_symbol: str
    axis_joint: int
    axis: FloatArray
    lci: float
    least_singular_value: float
    largest_limb_force: float
    characteristic_length: float

    @property
    def points(self) -> FloatArray:
        """Positions of all joints, shape (n, 3)."""
        return np.array([joint.position for joint in self.joints])


@dataclasses.dataclass(frozen=True, slots=True)
class Limit:
    """What can bound a workspace: name, ``"longest l_3"``, notation of what it is of, and kind."""

    name: str
    symbol: str
    kind: str


class SpatialDesign(ABC):
    """One design of a mechanism whose platform moves in space.

    Attributes
    ----------
    unit
        Unit of lengths, empty where they are non-dimensional.
    coordinates
        Coordinates of a pose.
    limits
        What can bound a workspace, in the order of the last axis of :meth:`slacks`.
    """

    unit: str
    coordinates: tuple[Coordinate, ...]
    limits: tuple[Limit, ...]

    def pose_text(self, coordinates: Sequence[float]) -> str:
        """Return a pose as text: ``"10 0 459.1 mm, 0 0 -12 deg"``."""
        lengths, angles = [], []
        for coordinate, value in zip(self.coordinates, coordinates, strict=True):
            if coordinate.is_angle:
                angles.append(f"{math.degrees(value) + 0.0:.8g}")
            else:
                lengths.append(f"{value + 0.0:.8g}")
        unit = f" {self.unit}" if self.unit else ""
        return f"{' '.join(lengths)}{unit}, {' '.join(angles)} deg"

    @property
    @abstractmethod
    def mechanism(self) -> str:
        """Name of the mechanism."""

    @property
    @abstractmethod
    def options(self) -> Options:
        """Sweep options of the mechanism that the design has."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Symbol and value of every length that makes up the design."""

    @property
    @abstractmethod
    def home(self) -> tuple[float, ...]:
        """Coordinates of the home pose."""

    @abstractmethod
    def pose(self, coordinates: tuple[float, ...]) -> SpatialPose:
        """Return the mechanism in a pose.

        Raises
        ------
        InputError
            If there are not as many finite coordinates as there must be, or a joint does not
            allow the pose; the error says by how much, and what the nearest one is.
        """

    @abstractmethod
    def solved(self, coordinates: tuple[float, ...], name: str) -> tuple[float, ...]:
        """Return a pose that the joints allow, one coordinate solved for near its given value.

        Raises
        ------
        UnknownNameError
            If there is no such coordinate.
        InputError
            If no value of it will do.
        """

    @abstractmethod
    def slacks(
        self, positions: FloatArray, orientation: tuple[float, float], complete: bool = False
    ) -> FloatArray:
        """Return how far positions are from every limit of the workspace at an orientation.

        Parameters
        ----------
        positions
            Positions of the platform's origin, shape (..., 3).
        orientation
            The two angles that are fixed; the third follows from the joints.
        complete
            Whether also those are computed that do not matter, since another limit is passed.

        Returns
        -------
        ndarray
            Shape (..., limits), continuous: positive within a limit, 0 on it. A position is in
            the workspace where all are positive.
        """

    @abstractmethod
    def reach(self) -> tuple[FloatArray, FloatArray]:
        """Return the corners of a box, shape (3,), that no position of a workspace is outside."""
