"""What a designer minimises: links, footprint, positioning error, torque.

Every goal is a function of the design, of the scale 1/D at which the practical workspace lies
in it, and of *extremes*: the largest values over the practical workspace of some functions of
the output point. A search can take an extreme for a variable that is nowhere exceeded.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod

import numpy as np

from fivebar_atlas.errors import UnknownNameError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.planar import PlacedExtremes, PlanarDesign
from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.containment import check_positive

# Stands for what is infinite.
_SINGULAR = 1e100


class Goal(ABC):
    """Something that is to be as small as it can be."""

    #: Name on the command line, and what it is in a phrase.
    name: str
    long_name: str
    #: Power of the length unit that it has; its unit is that times ``factor_unit``.
    length_power: int = 1
    factor_unit: str = ""
    #: For every function the number of the extreme that it bounds.
    bounded: tuple[int, ...] = ()

    @abstractmethod
    def value(
        self, mechanism: Mechanism, parameters: FloatArray, scale: float, extremes: FloatArray
    ) -> float:
        """Return the goal of one placement.

        Parameters
        ----------
        mechanism
            The mechanism.
        parameters
            Non-dimensional design, shape (parameters,).
        scale
            1/D.
        extremes
            Largest values of the functions, shape (extremes,), non-dimensional.
        """

    def functions(
        self,
        design: PlanarDesign,  # noqa: ARG002
        mode: str,  # noqa: ARG002
        points: FloatArray,
    ) -> FloatArray:
        """Return the functions whose largest values are the extremes.

        Parameters
        ----------
        design, mode
            Non-dimensional design and mode pair.
        points
            Output points, shape (n, 2).

        Returns
        -------
        ndarray
            Shape (functions, n); function k bounds the extreme ``bounded[k]``.
        """
        return np.empty((0, len(points)))

    def function(
        self, number: int, design: PlanarDesign, mode: str, points: FloatArray
    ) -> FloatArray:
        """Return one of these functions at output points, shape (n,)."""
        return np.asarray(self.functions(design, mode, points)[number])

    def on_samples(self, placed: PlacedExtremes) -> FloatArray:
        """Return the extremes of placements that were looked at on samples, shape (n, k)."""
        return np.empty((len(placed.moves), 0))

    @property
    def extremes(self) -> int:
        """Number of extremes."""
        return len(set(self.bounded))

    def unit(self, length: str) -> str:
        """Return the unit where lengths have one."""
        power = {1: length, 2: f"{length}²"}[self.length_power]
        return f"{self.factor_unit} {power}".strip()


class LinkSum(Goal):
    """Lengths of all moving links together."""

    name = "links"
    long_name = "sum of the moving links"

    def value(
        self,
        mechanism: Mechanism,
        parameters: FloatArray,
        scale: float,
        extremes: FloatArray,  # noqa: ARG002
    ) -> float:
        """Return D times the sum of the design."""
        return float(mechanism.moving_links(parameters[None])[0]) / scale


class ActuatedLink(Goal):
    """Length of the actuated link."""

    name = "actuated-link"
    long_name = "length of the actuated link"

    def value(
        self,
        mechanism: Mechanism,
        parameters: FloatArray,
        scale: float,
        extremes: FloatArray,  # noqa: ARG002
    ) -> float:
        """Return D times that of the design."""
        return float(mechanism.actuated_link(parameters[None])[0]) / scale


class Footprint(Goal):
    """Area of the box around all joints, in all poses, and the practical workspace."""

    name = "footprint"
    long_name = "area of the box around linkage and practical workspace"
    length_power = 2
    bounded = (0, 1, 2, 3)

    def value(
        self,
        mechanism: Mechanism,  # noqa: ARG002
        parameters: FloatArray,  # noqa: ARG002
        scale: float,
        extremes: FloatArray,
    ) -> float:
        """Return width times height."""
        right, left, above, below = extremes
        return float((right + left) * (above + below)) / scale**2

    def functions(self, design: PlanarDesign, mode: str, points: FloatArray) -> FloatArray:
        """Return how far joints and output reach to the right, left, up and down."""
        x, y = points[:, 0].copy(), points[:, 1].copy()
        joints = design.joint_positions(x, y, mode)
        places = np.concatenate([joints, points[:, None]], axis=1)
        greatest, least = places.max(axis=1), places.min(axis=1)
        return np.stack([greatest[:, 0], -least[:, 0], greatest[:, 1], -least[:, 1]])

    def on_samples(self, placed: PlacedExtremes) -> FloatArray:
        """Return the ends of the boxes."""
        lower, upper = placed.lower, placed.upper
        return np.stack([upper[:, 0], -lower[:, 0], upper[:, 1], -lower[:, 1]], axis=1)


@dataclasses.dataclass(frozen=True)
class PositioningError(Goal):
    """Worst positioning error, to first order.

    Attributes
    ----------
    resolution
        By how many radians every encoder may be off, either way.

    Raises
    ------
    InputError
        If the resolution is not positive and finite.
    """

    resolution: float
    name = "error"
    long_name = "worst positioning error"
    bounded = (0, 0)

    def __post_init__(self) -> None:
        check_positive("encoder resolution", self.resolution)

    def value(
        self,
        mechanism: Mechanism,  # noqa: ARG002
        parameters: FloatArray,  # noqa: ARG002
        scale: float,
        extremes: FloatArray,
    ) -> float:
        """Return the largest move of the output."""
        return float(self.resolution * extremes[0] / scale)

    def functions(self, design: PlanarDesign, mode: str, points: FloatArray) -> FloatArray:
        """Return the moves for errors of the same and of opposite signs."""
        one, two = _columns(design, mode, points)
        return np.stack([np.hypot(*(one + two)), np.hypot(*(one - two))])

    def on_samples(self, placed: PlacedExtremes) -> FloatArray:
        """Return the largest moves."""
        return placed.moves[:, None]


@dataclasses.dataclass(frozen=True)
class JointTorque(Goal):
    """Worst torque of an actuator, by virtual work.

    Attributes
    ----------
    force
        Size of a force on the output point in newtons, of whatever direction is worst.

    Raises
    ------
    InputError
        If the force is not positive and finite.
    """

    force: float
    name = "torque"
    long_name = "worst joint torque"
    factor_unit = "N"
    bounded = (0, 0)

    def __post_init__(self) -> None:
        check_positive("force", self.force)

    def value(
        self,
        mechanism: Mechanism,  # noqa: ARG002
        parameters: FloatArray,  # noqa: ARG002
        scale: float,
        extremes: FloatArray,
    ) -> float:
        """Return the largest torque."""
        return float(self.force * extremes[0] / scale)

    def functions(self, design: PlanarDesign, mode: str, points: FloatArray) -> FloatArray:
        """Return the torques of both actuators for a unit force."""
        one, two = _columns(design, mode, points)
        return np.stack([np.hypot(*one), np.hypot(*two)])

    def on_samples(self, placed: PlacedExtremes) -> FloatArray:
        """Return the largest torques."""
        return placed.torques[:, None]


def _columns(design: PlanarDesign, mode: str, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the columns of J⁻¹ at points, shape (2, n) each; huge where J is singular."""
    (a, b), (c, d) = design.jacobian(points[:, 0].copy(), points[:, 1].copy(), mode).transpose(
        1, 2, 0
    )
    with np.errstate(all="ignore"):
        det = a * d - b * c
        columns = np.stack([d, -c]) / det, np.stack([-b, a]) / det
    # far more than any regular point has, and finite, so that sums are
    one, two = (np.nan_to_num(each, nan=_SINGULAR, posinf=_SINGULAR) for each in columns)
    return one, two


GOALS = tuple(
    each.name for each in (LinkSum, Footprint, PositioningError, JointTorque, ActuatedLink)
)
#: Encoder resolution in radians and force in newtons where none is given; they scale a goal.
DEFAULT_RESOLUTION, DEFAULT_FORCE = 1e-4, 1.0


def goal_named(
    name: str,
    resolution: float = DEFAULT_RESOLUTION,
    force: float = DEFAULT_FORCE,
    option: str = "goal",
) -> Goal:
    """Return a goal by its name.

    Parameters
    ----------
    name
        One of ``GOALS``.
    resolution
        Encoder resolution in radians, for the positioning error.
    force
        Force in newtons, for the joint torque.
    option
        Name of the input in errors.

    Raises
    ------
    UnknownNameError
        If there is no such goal.
    InputError
        If resolution or force are not positive and finite.
    """
    made: tuple[Goal, ...] = (
        LinkSum(),
        Footprint(),
        PositioningError(resolution),
        JointTorque(force),
        ActuatedLink(),
    )
    if name not in GOALS:
        raise UnknownNameError(option, name, GOALS)
    return made[GOALS.index(name)]
