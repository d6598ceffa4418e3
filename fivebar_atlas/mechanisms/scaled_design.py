"""A non-dimensional design as a machine: all lengths times the dimensional factor D."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InputError, OutOfReachError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.planar import (
    RADIANS,
    OperatingLimits,
    PathLeast,
    PathReport,
    PlanarDesign,
    Pose,
    Workspace,
)
from fivebar_atlas.mechanisms.settings import Options
from fivebar_atlas.planar_geometry import CircleArc, NamedArc, Point, Region


class ScaledDesign(PlanarDesign):
    """A non-dimensional design as the machine with lengths times the dimensional factor.

    Parameters
    ----------
    design
        The non-dimensional design.
    factor
        Dimensional factor D, positive.
    unit
        Unit of D.
    """

    def __init__(self, design: PlanarDesign, factor: float, unit: str) -> None:
        self._design = design
        self._factor = factor
        self._unit = unit

    @property
    def mechanism(self) -> str:
        """Name of the mechanism."""
        return self._design.mechanism

    @property
    def unit(self) -> str:
        """Unit of all lengths."""
        return self._unit

    @property
    def factor(self) -> float:
        """Dimensional factor D in that unit."""
        return self._factor

    @property
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Symbol and length of every length of the machine."""
        return tuple(
            (each.symbol, self.factor * value)
            for each, (_, value) in zip(self._own.lengths, self._design.parameters, strict=True)
        )

    @property
    def options(self) -> Options:
        """Sweep options of its mechanism."""
        return self._design.options

    def remarks(self) -> tuple[str, ...]:
        """Return what is special about the design."""
        return self._design.remarks()

    def singular_loci(self, mode: str | None = None) -> tuple[NamedArc, ...]:
        """Return the singular loci as arcs cut where they meet."""
        return tuple(each.scaled(self.factor) for each in self._design.singular_loci(mode))

    def isolated_singular_points(self) -> tuple[Point, ...]:
        """Return singular points that no arc passes through."""
        return tuple(self._out(point) for point in self._design.isolated_singular_points())

    def usable_workspace(self, mode: str) -> Workspace | None:
        """Return the usable workspace of a mode pair, None where it is empty."""
        found = self._design.usable_workspace(mode)
        if found is None:
            return None
        return Workspace(found.region.scaled(self.factor), self.factor**2 * found.area)

    def good_condition_workspace(self, lci_threshold: float, mode: str) -> tuple[Region, ...]:
        """Return the parts of the usable workspace with at least this LCI, largest first."""
        parts = self._design.good_condition_workspace(lci_threshold, mode)
        return tuple(part.scaled(self.factor) for part in parts)

    def good_condition_area(self, lci_threshold: float, mode: str) -> tuple[float, float]:
        """Return the area of the usable workspace with at least this LCI, and its error."""
        area, error = self._design.good_condition_area(lci_threshold, mode)
        return self.factor**2 * area, self.factor**2 * error

    def inscribed_circles(self, mode: str) -> tuple[CircleArc, ...]:
        """Return the maximal inscribed circles of the usable workspace, those there are."""
        return tuple(circle.scaled(self.factor) for circle in self._design.inscribed_circles(mode))

    def lci(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return the LCI at points in a working mode; NaN out of reach."""
        return self._design.lci(np.divide(x, self.factor), np.divide(y, self.factor), mode)

    def lci_inside(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return the LCI at points of the usable workspace of a mode pair, 0 elsewhere."""
        x, y = np.divide(x, self.factor), np.divide(y, self.factor)
        return self._design.lci_inside(x, y, mode)

    def inputs(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return the input angles at points in a working mode, in (-π, π]."""
        return self._design.inputs(np.divide(x, self.factor), np.divide(y, self.factor), mode)

    def joint_positions(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return all joints but the output at points in a working mode."""
        x, y = np.divide(x, self.factor), np.divide(y, self.factor)
        return np.asarray(self.factor * self._design.joint_positions(x, y, mode))

    def jacobian(self, x: FloatArray, y: FloatArray, mode: str) -> FloatArray:
        """Return J of θ' = J p' at points in a working mode, in radians per length."""
        x, y = np.divide(x, self.factor), np.divide(y, self.factor)
        return np.asarray(self._design.jacobian(x, y, mode) / self.factor)

    def bounds_on_discs(
        self, x: FloatArray, y: FloatArray, radius: FloatArray, mode: str
    ) -> tuple[FloatArray, FloatArray]:
        """Return a lower bound of the LCI over discs, and how far the inputs turn at most."""
        return self._design.bounds_on_discs(
            np.divide(x, self.factor), np.divide(y, self.factor), radius / self.factor, mode
        )

    def largest_lci(self, mode: str) -> tuple[float, Point] | None:
        """Return the largest LCI of the usable workspace of a mode pair, and where it is."""
        found = self._design.largest_lci(mode)
        return None if found is None else (found[0], self._out(found[1]))

    def operating_limits(self, mode: str, count: int) -> OperatingLimits:
        """Return the least and the greatest inputs over the usable workspace of a mode pair."""
        limits = self._design.operating_limits(mode, count)
        if limits.unit == RADIANS:
            return limits
        return dataclasses.replace(limits, unit=self.unit, places=self.factor * limits.places)

    def pose(self, x: float, y: float, mode: str) -> Pose:
        """Return the linkage with its output point at P, in a mode pair or working mode."""
        with self._in_this_unit(scale_value=True):
            return self._pose(self._design.pose(x / self.factor, y / self.factor, mode))

    def inverse_poses(self, x: float, y: float) -> tuple[Pose, ...]:
        """Return the linkage with its output point at P in every working mode."""
        with self._in_this_unit(scale_value=True):
            poses = self._design.inverse_poses(x / self.factor, y / self.factor)
            return tuple(self._pose(pose) for pose in poses)

    def forward_poses(self, inputs: Sequence[float]) -> tuple[Pose, ...]:
        """Return the linkage for given input angles in every assembly mode."""
        with self._in_this_unit(scale_value=False):
            return tuple(self._pose(pose) for pose in self._design.forward_poses(inputs))

    def check_path(self, points: FloatArray, mode: str) -> PathReport:
        """Tell whether a path can be followed in a mode pair, exactly between its points too."""
        points = np.array(points, dtype=np.float64)
        report = self._design.check_path(points / self.factor, mode)
        fault = report.fault
        if fault is not None:
            fault = dataclasses.replace(
                fault,
                position=self._out(fault.position),
                gap=self.factor * fault.gap,
                unit=self.unit,
            )
        return dataclasses.replace(
            report,
            points=points,
            distances=self.factor * report.distances,
            fault=fault,
        )

    def least_on_path(self, points: FloatArray, mode: str) -> tuple[PathLeast, PathLeast]:
        """Return the least LCI and the least distance from a singular locus on a path."""
        lci, distance = self._design.least_on_path(np.divide(points, self.factor), mode)
        return (
            dataclasses.replace(lci, position=self._out(lci.position)),
            dataclasses.replace(
                distance,
                value=self.factor * distance.value,
                position=self._out(distance.position),
            ),
        )

    @property
    def _own(self) -> Mechanism:
        return mechanisms.get(self.mechanism)

    def _out(self, point: Point) -> Point:
        return self.factor * point[0], self.factor * point[1]

    def _pose(self, pose: Pose) -> Pose:
        joints = tuple(
            dataclasses.replace(joint, position=self._out(joint.position)) for joint in pose.joints
        )
        own = zip(self._own.proportions, self._own.lengths, strict=True)
        symbols = {one.symbol: other.symbol for one, other in own}
        links = tuple(
            dataclasses.replace(link, symbol=symbols.get(link.symbol, link.symbol))
            for link in pose.links
        )
        return dataclasses.replace(pose, joints=joints, links=links)

    @contextmanager
    def _in_this_unit(self, scale_value: bool) -> Iterator[None]:
        """Tell what is out of reach in the lengths of the machine."""
        try:
            yield
        except OutOfReachError as error:
            raise error.scaled(self.factor, self.unit, scale_value) from None
        except InputError as error:
            if not scale_value or error.name != "P":
                raise
            value = tuple(self.factor * part for part in error.value)
            raise InputError("P", value, error.allowed) from None
