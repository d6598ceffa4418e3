"""A motion to be solved: a machine, its poses with derivatives, a load and limits, from a file."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import FileUsageError, InputError, MissingInputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.motions import (
    Load,
    Motion,
    MotionFunction,
    MotionLimits,
    MotionSolver,
    SolvedMotion,
    Units,
    plain_unit,
    sampled_times,
)
from fivebar_atlas.text_tables import TextTable, read_table
from fivebar_atlas.trajectories import motion_file, sampled_functions, smooth_functions
from fivebar_atlas.trajectories.motion_file import MotionFile, key_in

#: Fewest and most samples of a motion, and how many there are where nothing is said.
FEWEST, MOST, DEFAULT = 2, 1_000_000, 1001

#: Columns of a load in a table of poses.
LOAD_NAMES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")

_LONGEST_UNIT = 16


@dataclasses.dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion and its solution.

    Attributes
    ----------
    mechanism
        What moves.
    machine
        The geometry in a line.
    solution
        Every quantity over time.
    errors
        Estimates, by what they are of, of the errors of derivatives that come from samples:
        ``"velocity of x"``. Empty where the motion is given by functions.
    error_units
        Their units.
    configuration
        The motion file with what was set besides, as TOML.
    inputs
        The files that were read.
    """

    mechanism: Mechanism
    machine: str
    solution: SolvedMotion
    errors: Mapping[str, float]
    error_units: Mapping[str, str]
    configuration: str
    inputs: tuple[Path, ...]


def solve_motion(
    path: str | os.PathLike[str], settings: Mapping[str, Any] | None = None
) -> Trajectory:
    """Read a motion file and solve the motion.

    Parameters
    ----------
    path
        A TOML file, or a CSV file of poses.
    settings
        Values by dotted key that win over those of the file.

    Raises
    ------
    FileUsageError, FileError
        If a file is missing or is not what it should be.
    InputError
        If a value is not allowed; it is named by its dotted key.
    MotionError
        If the machine cannot make the motion, or it is not smooth enough.
    """
    file, values = motion_file.read_motion_file(path, settings or {})
    reader = _Reader(file, Path(path))
    motion = reader.motion()
    solution = reader.solver.solved(
        motion, reader.load(motion.times), reader.limits(), reader.between(motion)
    )
    return Trajectory(
        reader.mechanism,
        reader.solver.description(),
        solution,
        reader.errors,
        reader.error_units,
        motion_file.rendered(values),
        reader.inputs,
    )


class _Reader:
    """What a motion file says, step by step."""

    def __init__(self, file: MotionFile, path: Path) -> None:
        self._file = file
        self._path = path
        self._source = str(path)
        self.errors: dict[str, float] = {}
        self.error_units: dict[str, str] = {}
        self._table: TextTable | None = None
        if file.mechanism is not None and file.mechanism not in mechanisms.names():
            raise UnknownNameError(self._key("mechanism"), file.mechanism, mechanisms.names())
        self.mechanism = mechanisms.get(file.mechanism or _first_that_moves())
        self._units = self._checked_units()
        length = file.characteristic_length
        if length is not None and not length > 0.0:
            raise InputError(self._key("characteristic_length"), length, "a length above 0")
        try:
            self.solver: MotionSolver = self.mechanism.motion_solver(
                file.geometry, length, self._units, lambda key: self._key(f"geometry.{key}")
            )
        except InputError as error:
            if error.name not in MotionFile.model_fields:
                raise
            raise error.renamed(self._key(error.name), error.value) from None
        self._names = [each.name for each in self.solver.coordinates]
        solve = file.motion.solve
        if solve is not None and solve not in self._names:
            raise UnknownNameError(self._key("motion.solve"), solve, self._names)
        for name in ("constraint_tolerance", "acceleration_tolerance"):
            value = getattr(file.motion, name)
            if value is not None and not value > 0.0:
                raise InputError(self._key(f"motion.{name}"), value, "a number above 0")
        self._at: Callable[[FloatArray], Motion]

    @property
    def inputs(self) -> tuple[Path, ...]:
        """The files that were read."""
        return (self._path,) if self._table is None else (self._path, self._table.path)

    def motion(self) -> Motion:
        """Return the motion at its samples."""
        section = self._file.motion
        times = self._sampled() if section.file is not None else self._given()
        motion = self._at(times)
        if section.solve is None:
            self.solver.check_constraint(motion, section.constraint_tolerance)
            return motion
        start = self._start()
        return self.solver.completed(motion, section.solve, start)

    def between(self, motion: Motion) -> MotionFunction:
        """Return the motion at any times."""
        solve = self._file.motion.solve
        if solve is None:
            return self._at
        column = self._names.index(solve)

        def at(times: FloatArray) -> Motion:
            near = float(np.interp(times[0], motion.times, motion.values[:, column]))
            return self.solver.completed(self._at(times), solve, near)

        return at

    def load(self, times: FloatArray) -> Load:
        """Return the load at the samples."""
        section = self._file.load
        wrenches = np.zeros((len(times), 6))
        table = self._table
        places = [] if table is None else self._load_places(table)
        if table is not None and places:
            for name in ("force", "moment"):
                if getattr(section, name) is not None:
                    allowed = f"no {name}: {table.path} has columns of the load"
                    raise InputError(self._key(f"load.{name}"), getattr(section, name), allowed)
            wrenches[:, [number for number, _ in places]] = table.numbers(
                [place for _, place in places]
            )
        for offset, name in ((0, "force"), (3, "moment")):
            values = getattr(section, name)
            if values is None:
                continue
            key = f"load.{name}"
            if len(values) != 3:
                raise InputError(self._key(key), values, "three components, along X, Y and Z")
            for number, value in enumerate(values):
                unit = self._units.moment if offset else self._units.force
                function = self._function(value, f"{key}.{number}", float(times[-1]), unit, False)
                wrenches[:, offset + number] = function(times)
        if len(section.point) != 3:
            raise InputError(self._key("load.point"), section.point, "three coordinates")
        x, y, z = section.point
        return Load(wrenches, (x, y, z), section.axes == "platform")

    def limits(self) -> MotionLimits:
        """Return the limits of the joints."""
        section = self._file.limits
        angles: list[float | None] = []
        for name in ("base_joint_limit", "platform_joint_limit"):
            value = getattr(section, name)
            if value is not None and not 0.0 < value <= 180.0:
                allowed = "an angle above 0 and up to 180 degrees"
                raise InputError(self._key(f"limits.{name}"), value, allowed)
            angles.append(None if value is None else math.radians(value))
        least, greatest = (
            self._lengths(name, getattr(section, name))
            for name in ("least_length", "greatest_length")
        )
        for number, (low, high) in enumerate(zip(least or (), greatest or (), strict=False)):
            if low > high:
                allowed = f"lengths up to the greatest ones, {high:g} of limb {number + 1}"
                raise InputError(self._key("limits.least_length"), low, allowed)
        return MotionLimits(least, greatest, *angles)

    def _key(self, key: str) -> str:
        return key_in(key, self._source)

    def _checked_units(self) -> Units:
        units = self._file.units
        for name in ("length", "force", "time"):
            text = getattr(units, name)
            if not (text.isprintable() and 0 < len(text.strip()) <= _LONGEST_UNIT):
                allowed = f"the name of a unit, of 1 to {_LONGEST_UNIT} printable characters"
                raise InputError(self._key(f"units.{name}"), text, allowed)
        return Units(units.length, units.force, units.time)

    def _unit(self, number: int) -> str:
        return "deg" if self.solver.coordinates[number].is_angle else self._units.length

    def _in_computations(self, values: FloatArray) -> FloatArray:
        """Return values in the units of files, shape (n, coordinates), with angles in radians."""
        scales = [math.radians(1.0) if each.is_angle else 1.0 for each in self.solver.coordinates]
        scaled: FloatArray = values * np.array(scales)
        return scaled

    def _start(self) -> float:
        """Return what the coordinate solved for is near to in the first pose."""
        number = self._names.index(self._file.motion.solve or self._names[0])
        is_angle = self.solver.coordinates[number].is_angle
        start = self._file.motion.start
        return math.radians(start) if is_angle else start

    def _given(self) -> FloatArray:
        """Take the coordinates as functions; return the times of samples."""
        section = self._file.motion
        if section.duration is None:
            expected = "how long the motion lasts; or motion.file, a table of poses"
            raise MissingInputError(self._key("motion.duration"), expected)
        if not section.duration >= 1.0 / motion_file.GREATEST:
            raise InputError(self._key("motion.duration"), section.duration, "a time above 0")
        samples = DEFAULT if section.samples is None else section.samples
        if not FEWEST <= samples <= MOST:
            allowed = f"an integer from {FEWEST} to {MOST}"
            raise InputError(self._key("motion.samples"), samples, allowed)
        for name in section.coordinates:
            if name not in self._names:
                raise UnknownNameError(self._key(f"motion.coordinates.{name}"), name, self._names)
        functions = []
        for number, name in enumerate(self._names):
            key = f"motion.coordinates.{name}"
            given = section.coordinates.get(name)
            if name == section.solve:
                if given is not None:
                    allowed = "no function: motion.solve says that it is solved for"
                    raise InputError(self._key(key), given, allowed)
                given = 0.0
            if given is None:
                expected = "a number or a function; or motion.solve, if it is to be solved for"
                raise MissingInputError(self._key(key), expected)
            functions.append(self._function(given, key, section.duration, self._unit(number), True))

        def at(times: FloatArray) -> Motion:
            orders = [
                np.column_stack([function(times, order) for function in functions])
                for order in range(3)
            ]
            return Motion(times, *(self._in_computations(each) for each in orders))

        self._at = at
        return sampled_times(section.duration, samples)

    def _function(
        self, value: object, key: str, duration: float, unit: str, smooth: bool
    ) -> smooth_functions.PiecewisePolynomial:
        """Return a function of a file as a piecewise polynomial."""
        table = motion_file.checked_function(value, key, self._source)
        try:
            if isinstance(table, float):
                return smooth_functions.constant(table, duration)
            if isinstance(table, motion_file.PolynomialTable):
                if not table.coefficients:
                    raise InputError("coefficients", [], "at least one number")
                function = smooth_functions.polynomial(table.coefficients, duration)
            elif isinstance(table, motion_file.PiecesTable):
                function = smooth_functions.pieces(table.breaks, table.coefficients)
            elif isinstance(table, motion_file.StopsTable):
                function = smooth_functions.stops(table.times, table.values)
            else:
                function = smooth_functions.spline(
                    table.times, table.values, table.degree, table.ends
                )
        except InputError as error:
            raise error.renamed(self._key(f"{key}.{error.name}"), error.value) from None
        smooth_functions.check_covers(self._key(key), function, duration)
        if smooth:
            smooth_functions.check_smooth(key, function, duration, unit, self._units.time)
        return function

    def _sampled(self) -> FloatArray:
        """Take the coordinates from a table of poses; return its times."""
        section = self._file.motion
        for name in ("duration", "samples"):
            if getattr(section, name) is not None:
                allowed = "no such key where motion.file is given: its times count"
                raise InputError(self._key(f"motion.{name}"), getattr(section, name), allowed)
        if section.coordinates:
            allowed = "no functions where motion.file is given"
            raise InputError(self._key("motion.coordinates"), list(section.coordinates), allowed)
        path = self._path.parent / str(section.file)
        wanted = [name for name in self._names if name != section.solve]
        columns = ", ".join(["t", *wanted])
        table = read_table(path, "poses", f"the columns {columns}")
        self._table = table
        places = [self._place(table, "t", self._units.time, columns)]
        for number, name in enumerate(self._names):
            if name in wanted:
                places.append(self._place(table, name, self._unit(number), columns))
        if len(table.rows) == 1:
            raise FileUsageError(path, "has no poses below its header")
        numbers = table.numbers(places)
        large = np.argwhere(np.abs(numbers) > motion_file.GREATEST)
        if len(large):
            row, column = (int(part) for part in large[0])
            raise FileUsageError(
                path,
                f"row {row + 1} (line {table.rows[row + 1][0]}), column "
                f"{table.header[places[column]]}: {numbers[row, column]:g} is too large",
            )
        times = np.ascontiguousarray(numbers[:, 0])
        back = np.flatnonzero(np.diff(times) < 1.0 / motion_file.GREATEST)
        if len(back):
            row = int(back[0]) + 2
            raise FileUsageError(
                path,
                f"row {row} (line {table.rows[row][0]}), column {table.header[places[0]]}: the "
                f"time {times[row - 1]:g} does not come after {times[row - 2]:g}",
            )
        kept = [self._names.index(name) for name in wanted]
        units = [self._unit(number) for number in kept]
        angles = [column for column, unit in enumerate(units) if unit == "deg"]
        values = numbers[:, 1:].copy()
        values[:, angles] = np.unwrap(values[:, angles], axis=0, period=360.0)
        tolerance = section.acceleration_tolerance or sampled_functions.ACCELERATION_TOLERANCE
        through = sampled_functions.through_samples(
            times, values, wanted, units, self._units.time, tolerance
        )
        time = self._units.time
        for column, (name, unit) in enumerate(zip(wanted, units, strict=True)):
            for what, each, found in (
                ("velocity", f"{unit}/{time}", through.velocity_errors),
                ("acceleration", f"{unit}/{time}²", through.acceleration_errors),
            ):
                self.errors[f"{what} of {name}"] = float(found[column])
                self.error_units[f"{what} of {name}"] = each

        def at(moments: FloatArray) -> Motion:
            orders = []
            for order in range(3):
                full = np.zeros((len(moments), len(self._names)))
                full[:, kept] = through.spline(moments, order)
                orders.append(self._in_computations(full))
            return Motion(moments, *orders)

        self._at = at
        return times

    def _place(self, table: TextTable, name: str, unit: str, columns: str) -> int:
        """Return the place of a column that must be there."""
        found = _places(table, name, unit)
        if len(found) == 1:
            return found[0]
        there = ", ".join(each or "(no name)" for each in table.header)
        if found:
            raise FileUsageError(
                table.path, f"has more than one column {name} or {name}_{unit}: {there}"
            )
        raise FileUsageError(
            table.path,
            f"has no column {name} or {name}_{unit}; its columns are {there}, and {columns} are "
            f"needed, with the units of the motion in their names if any",
        )

    def _load_places(self, table: TextTable) -> list[tuple[int, int]]:
        """Return component and place of every column of the load."""
        places = []
        for number, name in enumerate(LOAD_NAMES):
            unit = self._units.force if number < 3 else self._units.moment
            found = _places(table, name, unit)
            if len(found) > 1:
                raise FileUsageError(table.path, f"has more than one column {name}")
            others = [
                each for each in table.header if each.casefold().startswith(f"{name.casefold()}_")
            ]
            if not found and others:
                allowed = f"{name} or {name}_{plain_unit(unit, '.')}"
                raise FileUsageError(table.path, f"has the column {others[0]}; expected {allowed}")
            places += [(number, place) for place in found]
        return places

    def _lengths(self, name: str, value: Any) -> tuple[float, ...] | None:
        """Return a limit of lengths, one number or one for each limb."""
        if value is None:
            return None
        count = self.solver.limb_count
        values = value if isinstance(value, list) else [value] * count
        numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
        if len(values) != count or not numbers or not all(0.0 <= v < math.inf for v in values):
            allowed = f"a length, or a list of {count} lengths, from 0"
            raise InputError(self._key(f"limits.{name}"), value, allowed)
        return tuple(float(each) for each in values)


def _first_that_moves() -> str:
    """Return the name of the first mechanism whose motions can be solved."""
    return next(name for name in mechanisms.names() if mechanisms.get(name).has_motions)


def _places(table: TextTable, name: str, unit: str) -> list[int]:
    """Return the places of columns of a name, with its unit or without."""
    texts: Sequence[str] = (unit, plain_unit(unit), plain_unit(unit, "."), plain_unit(unit, ""))
    accepted = {name.casefold(), *(f"{name}_{text}".casefold() for text in texts)}
    return [place for place, each in enumerate(table.header) if each.casefold() in accepted]
