"""Motions of mechanisms: poses over time, and what joints do and bear in them.

A mechanism whose output is a body with several coordinates offers a :class:`MotionSolver`
(``Mechanism.motion_solver``). Files, figures and commands know only what is declared here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Protocol

import numpy as np

from fivebar_atlas.mechanisms.arrays import FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Units:
    """Names of the units of a motion; numbers are never converted but for angles.

    Attributes
    ----------
    length, force, time
        Any names: the numbers of a motion are in these units, and so are the results.
    """

    length: str = "mm"
    force: str = "N"
    time: str = "s"

    @property
    def moment(self) -> str:
        """Unit of moments: that of forces times that of lengths."""
        return f"{self.force}·{self.length}"


@dataclasses.dataclass(frozen=True, slots=True)
class Coordinate:
    """One coordinate of a pose.

    Attributes
    ----------
    name
        Name in files, ``"alpha"``.
    symbol
        The field's notation as mathtext.
    is_angle
        Whether it is an angle: in degrees in files, in radians in computations.
    long_name
        What it is, in a phrase.
    """

    name: str
    symbol: str
    is_angle: bool
    long_name: str


@dataclasses.dataclass(frozen=True, eq=False)
class Motion:
    """Poses over time, with their derivatives.

    Attributes
    ----------
    times
        Rising, shape (n,).
    values, rates, accelerations
        Coordinates and their first and second derivatives by time, angles in radians, shape
        (n, coordinates).
    """

    times: FloatArray
    values: FloatArray
    rates: FloatArray
    accelerations: FloatArray

    def __len__(self) -> int:
        return len(self.times)

    def taken(self, numbers: Sequence[int] | slice) -> Motion:
        """Return some of the samples."""
        return Motion(
            self.times[numbers],
            self.values[numbers],
            self.rates[numbers],
            self.accelerations[numbers],
        )


#: Coordinates at any times: what a solver asks for between the samples.
MotionFunction = Callable[[FloatArray], Motion]


@dataclasses.dataclass(frozen=True, eq=False)
class Load:
    """What acts on the moving body.

    Attributes
    ----------
    wrenches
        Force and moment, shape (n, 6), one for each sample.
    point
        Where the force acts, in the axes of the body, shape (3,); the moment is about it.
    turns_with_body
        Whether force and moment are given in the axes of the body, not of the base.
    """

    wrenches: FloatArray
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turns_with_body: bool = False


@dataclasses.dataclass(frozen=True, slots=True)
class MotionLimits:
    """What joints allow; None where nothing is said.

    Attributes
    ----------
    least_lengths, greatest_lengths
        Of the limbs, one number each.
    base_joint_limit, platform_joint_limit
        Largest angles, in radians, between a limb and its direction in the first pose of the
        motion, in the axes of the base and of the moving body.
    """

    least_lengths: tuple[float, ...] | None = None
    greatest_lengths: tuple[float, ...] | None = None
    base_joint_limit: float | None = None
    platform_joint_limit: float | None = None


@dataclasses.dataclass(frozen=True, eq=False)
class Column:
    """One quantity over the time of a motion.

    Attributes
    ----------
    name
        Name in files, ``"l1"``.
    symbol
        The field's notation as mathtext.
    unit
        Unit, ``"1"`` for a pure number; angles are in degrees.
    long_name
        What it is, in a phrase.
    group
        What is drawn together, ``"limb lengths"``.
    values
        Shape (n,).
    """

    name: str
    symbol: str
    unit: str
    long_name: str
    group: str
    values: FloatArray


@dataclasses.dataclass(frozen=True, eq=False)
class SolvedMotion:
    """Everything that is known of a motion.

    Attributes
    ----------
    times
        Shape (n,).
    columns
        The quantities, without the time.
    units
        Names of the units.
    facts
        Numbers of the motion as a whole, by name: the least LCI between the samples, for
        instance.
    """

    times: FloatArray
    columns: tuple[Column, ...]
    units: Units
    facts: Mapping[str, float]

    @property
    def groups(self) -> tuple[str, ...]:
        """The groups, in their order."""
        return tuple(dict.fromkeys(column.group for column in self.columns))

    def of_group(self, group: str) -> tuple[Column, ...]:
        """Return the columns of a group."""
        return tuple(column for column in self.columns if column.group == group)

    def __getitem__(self, name: str) -> FloatArray:
        for column in self.columns:
            if column.name == name:
                return column.values
        raise KeyError(name)

    def __iter__(self) -> Iterator[Column]:
        return iter(self.columns)


class MotionSolver(Protocol):
    """One machine that moves."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates of a pose, one more than there are freedoms."""
        ...

    @property
    def limb_count(self) -> int:
        """How many limbs have a length."""
        ...

    def description(self) -> str:
        """Return the geometry in a line."""
        ...

    def completed(self, motion: Motion, solve: str, start: float) -> Motion:
        """Return a motion with one coordinate solved for, continuously.

        Parameters
        ----------
        motion
            The motion; what it has of that coordinate is not looked at.
        solve
            Name of the coordinate.
        start
            What it is near to in the first pose, radians or a length; it decides which solution
            is taken where there are several.

        Raises
        ------
        MotionError
            Where there is no solution, or it is not continuous.
        """
        ...

    def check_constraint(self, motion: Motion, tolerance: float | None) -> None:
        """Raise MotionError at the first pose that the joints do not allow.

        Parameters
        ----------
        motion
            The motion.
        tolerance
            How far joints may be apart, a length; None for little more than rounding.
        """
        ...

    def solved(
        self, motion: Motion, load: Load, limits: MotionLimits, between: MotionFunction
    ) -> SolvedMotion:
        """Return what the limbs do and bear.

        Parameters
        ----------
        motion
            A motion that the joints allow.
        load
            What acts on the body.
        limits
            What joints allow.
        between
            The same motion at any times from the first to the last, to look between samples.

        Raises
        ------
        MotionError
            Where a pose is singular, between samples too, or a limit is exceeded.
        """
        ...


def sampled_times(duration: float, samples: int) -> FloatArray:
    """Return times from 0 to the duration, in equal steps."""
    times: FloatArray = np.linspace(0.0, duration, samples)
    return times


def plain_unit(unit: str, times: str = " ") -> str:
    """Return a unit without raised digits and dots: ``"mm/s2"``, ``"N mm"``."""
    return unit.replace("²", "2").replace("·", times)
