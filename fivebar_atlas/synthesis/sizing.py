"""From a non-dimensional design to a machine (Liu, Wang and Zheng 2006, Sec. 9.2).

Step 1 takes the good-condition workspace at an LCI threshold, step 2 the dimensional factor D
that a practical workspace asks for, step 3 the lengths and indices of the machine, step 4 what
its inputs run over. Beyond the paper: how far its output point is off where its encoders are,
and the torques that a force on the output point asks for.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import InfeasibleSizeError, InputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.mechanisms.quantities import Results
from fivebar_atlas.mechanisms.scaled_design import ScaledDesign
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.planar_geometry import Point, Region
from fivebar_atlas.synthesis.containment import (
    INSIDE,
    ActuatorRange,
    GoodCondition,
    check_positive,
)
from fivebar_atlas.synthesis.link_limits import LinkLimit, check_limits, length_name
from fivebar_atlas.synthesis.placement import FREE, ON_AXIS, Fit, empty_reason, fit_shape
from fivebar_atlas.synthesis.practical_workspace import (
    Field,
    InputRange,
    PracticalWorkspace,
    input_ranges,
)
from fivebar_atlas.synthesis.shapes import LENGTH_RANGE, Shape

_AREA = "good_condition_workspace_area"
# By how many radians an input may be beyond the range of its actuator: rounding.
_ROUNDING = 1e-9


@dataclasses.dataclass(frozen=True, slots=True)
class WorstCase:
    """The largest value of something over the practical workspace, and where it is.

    Attributes
    ----------
    value
        The value.
    position
        Where, in lengths of the machine.
    """

    value: float
    position: Point


@dataclasses.dataclass(frozen=True)
class Machine:
    """A design with the size that a practical workspace asks for.

    Attributes
    ----------
    good
        The non-dimensional design, mode pair, LCI threshold and actuator ranges.
    unit
        Unit of all lengths.
    factor
        Dimensional factor D.
    factor_error
        Absolute error estimate of D, where it comes from an area; otherwise by how much D is
        larger at most than the factor at which the shape touches.
    workspace
        Practical workspace in the non-dimensional design.
    shape
        Shape of the practical workspace; None where it is a good-condition workspace.
    fit
        How the shape is placed.
    parts
        Number of connected parts of the good-condition workspace.
    """

    good: GoodCondition
    unit: str
    factor: float
    factor_error: float
    workspace: PracticalWorkspace
    shape: Shape | None
    fit: Fit | None
    parts: int

    @property
    def design(self) -> ScaledDesign:
        """The machine as figures and files of its geometry take it."""
        return ScaledDesign(self.good.design, self.factor, self.unit)

    @property
    def lengths(self) -> dict[str, float]:
        """Lengths of the machine by name (step 3)."""
        proportions = _proportions(self.good.design)
        return {name: self.factor * value for name, value in proportions.items()}

    @property
    def position(self) -> Point | None:
        """Centre of the shape, in lengths of the machine."""
        if self.fit is None:
            return None
        x, y = self.fit.position
        return self.factor * x, self.factor * y

    @property
    def contacts(self) -> tuple[Point, ...]:
        """Points of the shape next to what is not good, in lengths of the machine."""
        if self.fit is None:
            return ()
        points = self.factor * np.array(self.fit.position) + self.fit.contacts
        return tuple((float(x), float(y)) for x, y in points)

    @functools.cached_property
    def evaluation(self) -> tuple[SweepSettings, Results]:
        """Indices and areas of the design, and the settings they were computed with."""
        return _evaluate(self.good)

    @functools.cached_property
    def input_ranges(self) -> tuple[InputRange, ...]:
        """What the inputs run over in the practical workspace (step 4).

        Places are in lengths of the machine.
        """
        return tuple(
            dataclasses.replace(
                each, at_least=self._out(each.at_least), at_greatest=self._out(each.at_greatest)
            )
            for each in input_ranges(self.good, self.workspace)
        )

    def positioning_error(self, resolution: float) -> WorstCase:
        """Return the largest error of the output point over the practical workspace.

        Parameters
        ----------
        resolution
            By how many radians every encoder may be off, either way. To first order the output
            point is off by J⁻¹ times these errors, and most where all have their full size.

        Raises
        ------
        InputError
            If the resolution is not positive and finite.
        """
        check_positive("encoder resolution", resolution)

        def error(points: FloatArray) -> FloatArray:
            moves = self._moves(points)
            signs = _signs(moves.shape[2])
            return np.asarray(np.linalg.norm(moves @ signs, axis=1).max(axis=1))

        return self._worst(error, resolution * self.factor)

    def joint_torque(self, force: float) -> WorstCase:
        """Return the largest torque of an actuator over the practical workspace.

        Parameters
        ----------
        force
            Size of a force on the output point, of whatever direction is worst. By virtual
            work the torques are J⁻ᵀ times the force, without weight and friction.

        Raises
        ------
        InputError
            If the force is not positive and finite.
        """
        check_positive("force", force)

        def torque(points: FloatArray) -> FloatArray:
            return np.asarray(np.linalg.norm(self._moves(points), axis=1).max(axis=1))

        return self._worst(torque, force * self.factor)

    def document(
        self, resolution: float | None = None, force: float | None = None
    ) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON.

        Parameters
        ----------
        resolution
            Encoder resolution in radians.
        force
            Force on the output point in newtons.
        """
        mechanism = mechanisms.get(self.good.design.mechanism)
        settings, results = self.evaluation
        indices = mechanism.document(
            parameters_of(self.good.design), self.factor, settings, results
        )
        document: dict[str, Any] = {
            "mechanism": mechanism.name,
            "mode": self.good.mode,
            "lci_threshold": self.good.lci_threshold,
            "unit": self.unit,
            "dimensional_factor": self.factor,
            "dimensional_factor_error": self.factor_error,
            **self.lengths,
            "good_condition_workspace_parts": self.parts,
        }
        if self.shape is not None and self.fit is not None:
            document["shape"] = {
                "name": self.shape.name,
                "clearance": self.shape.clearance,
                "centre": list(self.position or ()),
                "centre_as_given": list(self.shape.centre),
                "contacts": [list(contact) for contact in self.contacts],
                "is_proved": self.fit.proof.verdict == INSIDE,
                "squares_of_proof": self.fit.proof.squares,
            }
        document["inputs"] = [
            {
                "number": each.number,
                "least_deg": math.degrees(each.least),
                "greatest_deg": math.degrees(each.greatest),
                "is_full_turn": each.is_full_turn,
                "at_least": None if each.at_least is None else list(each.at_least),
                "at_greatest": None if each.at_greatest is None else list(each.at_greatest),
            }
            for each in self.input_ranges
        ]
        if resolution is not None:
            error = self.positioning_error(resolution)
            document["positioning_error"] = {
                "encoder_resolution_deg": math.degrees(resolution),
                "value": error.value,
                "at": list(error.position),
            }
        if force is not None:
            torque = self.joint_torque(force)
            document["joint_torque"] = {
                "force": force,
                "value": torque.value,
                "unit": f"N {self.unit}",
                "at": list(torque.position),
            }
        document["indices"] = indices
        return document

    def _moves(self, points: FloatArray) -> FloatArray:
        """Return J⁻¹ at points, shape (n, 2, inputs): how the output point follows inputs."""
        jacobian = self.good.design.jacobian(
            points[:, 0].copy(), points[:, 1].copy(), self.good.mode
        )
        return np.asarray(np.linalg.inv(jacobian), dtype=np.float64)

    def _worst(self, function: Field, scale: float) -> WorstCase:
        value, point = self.workspace.greatest(function)
        return WorstCase(scale * value, (self.factor * point[0], self.factor * point[1]))

    def _out(self, point: Point | None) -> Point | None:
        return None if point is None else (self.factor * point[0], self.factor * point[1])


def size_for_area(
    design: PlanarDesign,
    area: float,
    mode: str,
    lci_threshold: float = 0.5,
    *,
    unit: str = "mm",
    ranges: Sequence[ActuatorRange] = (),
    limits: Sequence[LinkLimit] = (),
    factor_step: float | None = None,
) -> Machine:
    """Return the machine whose good-condition workspace has an area (Eq. 34).

    Where the good-condition workspace has several parts, the largest one has that area.

    Parameters
    ----------
    design
        The non-dimensional design.
    area
        Area in squares of the unit.
    mode
        Mode pair.
    lci_threshold
        LCI threshold in (0, 1).
    unit
        Unit of lengths.
    ranges, limits
        What actuators and links allow.
    factor_step
        D is rounded up to a multiple of this; the area then is larger than asked for.

    Raises
    ------
    InputError
        If the area or the step is not positive and finite, the threshold not in (0, 1), or there
        is no such input.
    UnknownNameError
        If there is no such mode pair or link.
    InfeasibleSizeError
        If the good-condition workspace is empty, or a range or limit does not hold.

    Examples
    --------
    >>> from fivebar_atlas import planar_design
    >>> from fivebar_atlas.synthesis.sizing import size_for_area
    >>> machine = size_for_area(planar_design(1.28, 1.72, 0.0), 400.0, "+-/up")
    >>> {name: round(length, 3) for name, length in machine.lengths.items()}
    {'R1': 5.756, 'R2': 7.735, 'R3': 0.0}
    """
    check_positive("area", area)
    least, greatest = (length**2 for length in LENGTH_RANGE)
    if not least <= area <= greatest:
        raise InputError("area", area, f"an area from {least:g} to {greatest:g}")
    _check_step(factor_step)
    good = _good(design, mode, lci_threshold, ranges)
    parts = design.good_condition_workspace(lci_threshold, good.mode)
    if not parts:
        raise InfeasibleSizeError(empty_reason(good))
    whole, error = _area(good)
    share = _area_share(parts)
    largest = share * whole
    if len(parts) > 1:
        # The share comes from polygons, whose areas are off by what the chords cut off.
        error = share * error + abs(sum(part.area for part in parts) - whole)
    exact = math.sqrt(area / largest)
    factor = exact if factor_step is None else _rounded_up(exact, factor_step)
    workspace = PracticalWorkspace.of_region(good, parts[0])
    machine = Machine(
        good=good,
        unit=unit,
        factor=factor,
        factor_error=0.5 * exact * error / largest if factor_step is None else 0.0,
        workspace=workspace,
        shape=None,
        fit=None,
        parts=len(parts),
    )
    _check_lengths(machine, limits)
    _check_inputs(machine)
    return machine


def size_for_shape(
    design: PlanarDesign,
    shape: Shape,
    mode: str,
    lci_threshold: float = 0.5,
    *,
    unit: str = "mm",
    placement: str | Point = ON_AXIS,
    ranges: Sequence[ActuatorRange] = (),
    limits: Sequence[LinkLimit] = (),
    factor_step: float | None = None,
) -> Machine:
    """Return the smallest machine in which a whole shape is in good condition.

    Parameters
    ----------
    design
        The non-dimensional design.
    shape
        The shape, in the unit.
    mode
        Mode pair.
    lci_threshold
        LCI threshold in (0, 1).
    unit
        Unit of lengths.
    placement
        ``"axis"``: the centre of the shape is on the y axis. ``"free"``: it is anywhere. A
        point: it is there, in lengths of the machine.
    ranges, limits
        What actuators and links allow.
    factor_step
        D is rounded up to a multiple of this.

    Returns
    -------
    Machine
        The shape fits, which is proved, and would not at D (1 - 1e-6) unless the least length
        of a link or the step decides.

    Raises
    ------
    InputError
        If the threshold is not in (0, 1), an offset or the step is not finite, or there is no
        such input.
    UnknownNameError
        If there is no such mode pair, link or placement.
    InfeasibleSizeError
        If the shape fits at no size that is allowed; says why and what comes closest.

    Examples
    --------
    >>> from fivebar_atlas import planar_design
    >>> from fivebar_atlas.synthesis.shapes import Shape
    >>> from fivebar_atlas.synthesis.sizing import size_for_shape
    >>> design = planar_design(1.28, 1.72, 0.0)
    >>> machine = size_for_shape(design, Shape.circle(100.0), "+-/up")
    >>> round(machine.factor, 4), round(machine.position[1], 3)
    (48.8714, 75.185)
    """
    _check_step(factor_step)
    good = _good(design, mode, lci_threshold, ranges)
    if isinstance(placement, str) and placement not in (ON_AXIS, FREE):
        raise UnknownNameError("placement", placement, (ON_AXIS, FREE))
    if not isinstance(placement, str):
        if not all(map(math.isfinite, placement)):
            raise InputError("offset", placement, "two finite lengths")
        greatest = LENGTH_RANGE[1]
        if max(map(abs, placement)) > greatest:
            raise InputError("offset", placement, f"two lengths up to {greatest:g}")
    lengths = _proportions(design)
    check_limits(lengths, limits)
    least = max(
        (each.least / lengths[length_name(each.name, lengths)] for each in limits if each.least),
        default=0.0,
    )
    fit = fit_shape(good, shape, placement, least)
    if factor_step is not None:
        fit = fit_shape(good, shape, placement, _rounded_up(fit.factor, factor_step))
    workspace = PracticalWorkspace.of_shape(shape, fit.position, 1.0 / fit.factor)
    parts = design.good_condition_workspace(lci_threshold, good.mode)
    machine = Machine(
        good=good,
        unit=unit,
        factor=fit.factor,
        factor_error=fit.allowance * fit.factor,
        workspace=workspace,
        shape=shape,
        fit=fit,
        parts=len(parts),
    )
    _check_lengths(machine, limits)
    return machine


def _good(
    design: PlanarDesign, mode: str, lci_threshold: float, ranges: Sequence[ActuatorRange]
) -> GoodCondition:
    """Return what is asked of points, checked."""
    mechanism = mechanisms.get(design.mechanism)
    mechanism.check_thresholds([lci_threshold])
    if design.unit:
        raise InputError("design", design.unit, "a non-dimensional design, of unit ''")
    pair = mechanism.parse_mode(mode)
    return GoodCondition(design, pair, lci_threshold, tuple(ranges))


def _evaluate(good: GoodCondition) -> tuple[SweepSettings, Results]:
    """Return indices and areas of a design in its mode pair at its threshold."""
    mechanism = mechanisms.get(good.design.mechanism)
    settings = SweepSettings(
        mechanism=mechanism.name,
        space=mechanism.spaces[0],
        resolution=mechanism.resolution_range[0],
        modes=(good.mode,),
        lci_thresholds=(good.lci_threshold,),
        tolerance=mechanism.default_tolerance,
        options=good.design.options,
    )
    return settings, mechanism.evaluate(parameters_of(good.design)[None], settings)


def _area(good: GoodCondition) -> tuple[float, float]:
    """Return the area of the good-condition workspace and its error estimate."""
    _, results = _evaluate(good)
    quantity = mechanisms.get(good.design.mechanism).quantity(_AREA)
    return float(results[quantity.name][0, 0, 0]), float(results[quantity.error_name][0, 0, 0])


def _area_share(parts: Sequence[Region]) -> float:
    """Return which share of the area of all parts the first one has."""
    return parts[0].area / math.fsum(part.area for part in parts) if len(parts) > 1 else 1.0


def parameters_of(design: PlanarDesign) -> FloatArray:
    """Return the parameters of a non-dimensional design, shape (parameters,)."""
    lengths = [value for _, value in design.parameters]
    return mechanisms.get(design.mechanism).from_lengths(lengths)[0]


def _proportions(design: PlanarDesign) -> dict[str, float]:
    """Return the non-dimensional lengths by the names of those of a machine."""
    names = [each.name for each in mechanisms.get(design.mechanism).lengths]
    return dict(zip(names, design.named_lengths.values(), strict=True))


def _check_lengths(machine: Machine, limits: Sequence[LinkLimit]) -> None:
    """Raise InfeasibleSizeError if a length is out of its limits."""
    lengths, unit = machine.lengths, machine.unit
    check_limits(_proportions(machine.good.design), limits)
    reasons = []
    share = 1.0
    for each in limits:
        name = length_name(each.name, lengths)
        length = lengths[name]
        if length > each.greatest:
            reasons.append(f"{name} = {length:.6g} {unit} is above {each.greatest:g} {unit}")
            share = min(share, each.greatest / length)
        elif length < each.least * (1.0 - _ROUNDING):
            reasons.append(f"{name} = {length:.6g} {unit} is below {each.least:g} {unit}")
    if not reasons:
        return
    what = "the area" if machine.shape is None else f"the {machine.shape.name}"
    text = f"a machine for {what} is out of its limits: {' and '.join(reasons)}"
    if share < 1.0:
        text += f"; within them a workspace {share:.6g} times as wide has room"
    raise InfeasibleSizeError(text)


def _check_inputs(machine: Machine) -> None:
    """Raise InfeasibleSizeError if an input leaves the range of its actuator."""
    mechanism = mechanisms.get(machine.good.design.mechanism)
    reasons = []
    for limit in machine.good.ranges:
        name, asked = mechanism.input_text(limit.number), limit.text(mechanism)
        found = machine.input_ranges[limit.number - 1]
        if not limit.is_limiting:
            continue
        if found.is_full_turn:
            reasons.append(f"{asked} is asked for and {name} turns fully")
            continue
        middle = 0.5 * (limit.least + limit.greatest)
        own = 0.5 * (found.least + found.greatest)
        turn = 2.0 * math.pi * round((middle - own) / (2.0 * math.pi))
        least, greatest = found.least + turn, found.greatest + turn
        if least < limit.least - _ROUNDING or greatest > limit.greatest + _ROUNDING:
            runs = f"from {math.degrees(least):.4f} to {math.degrees(greatest):.4f} deg"
            reasons.append(f"{asked} is asked for and {name} runs {runs}")
    if reasons:
        raise InfeasibleSizeError(
            f"no size: inputs over the good-condition workspace do not depend on it, "
            f"{' and '.join(reasons)}"
        )


def _check_step(step: float | None) -> None:
    if step is not None:
        check_positive("factor step", step)
        least, greatest = LENGTH_RANGE
        if not least <= step <= greatest:
            raise InputError("factor step", step, f"a length from {least:g} to {greatest:g}")


def _rounded_up(factor: float, step: float) -> float:
    """Return the least multiple of a step that is not below a factor."""
    # a round step is a decimal number, whose multiples are quotients of whole numbers
    count = math.ceil(factor / step)
    return count / (1.0 / step) if step < 1.0 else count * step


def _signs(count: int) -> FloatArray:
    """Return all combinations of signs but for those that are others turned, as columns."""
    numbers = np.arange(2 ** (count - 1))
    rows = [np.ones(len(numbers)), *(1.0 - 2.0 * (numbers >> k & 1) for k in range(count - 1))]
    return np.array(rows)
