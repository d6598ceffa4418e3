"""Machines for a practical workspace, searched over a whole design space and all mode pairs.

Every design of a lattice is tried with a shape at many places, on samples (the mechanism's
``scan_placements``); the best ones that are apart from one another are where
:mod:`machine_polish` starts from.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.executors import ThreadExecutor
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.planar import PlacementScan, PlanarDesign
from fivebar_atlas.mechanisms.settings import Options
from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.containment import ActuatorRange, check_ranges
from fivebar_atlas.synthesis.link_limits import LinkLimit, length_name
from fivebar_atlas.synthesis.machine_goals import Goal
from fivebar_atlas.synthesis.placement import FREE, ON_AXIS
from fivebar_atlas.synthesis.shapes import Shape

# Steps of the lattice, positions along the axis, and along x and y.
_RESOLUTION, _AXIS_POSITIONS, _FREE_POSITIONS = 96, 97, (23, 25)
# Samples of boundary and interior.
_BOUNDARY, _INTERIOR = 40, 150
# Scales, as shares of the largest one of a placement, at which goals are looked at that may gain
# from a larger machine.
_SHRINKING = (1.0, 0.85, 0.7, 0.5)
# Least scale as a share of the largest that could be.
_LEAST_SCALE = 1e-4
# Share by which limits on lengths may be missed on the lattice: no design of it may have just
# the lengths that are asked for.
_SLACK = 0.04
# Designs of one task.
_BLOCK = 256
# Starts, how far they are apart in the chart, and how much worse than the best one.
_STARTS, _APART, _WORTHWHILE = 6, 0.12, 1.6
# Values of one design that differ by less, as a share, are those of mirror images.
_SAME = 1e-3


@dataclasses.dataclass(frozen=True)
class MachineTask:
    """What a machine is to do, and what is to be smallest.

    Attributes
    ----------
    mechanism
        The mechanism.
    shape
        The practical workspace, in the unit.
    goal
        What is minimised.
    modes
        Mode pairs that are allowed.
    lci_threshold
        Least LCI throughout the shape, in (0, 1).
    placement
        ``ON_AXIS`` or ``FREE``.
    ranges, limits
        What actuators and links allow.
    unit
        Unit of lengths.
    space
        Design space that is searched; the widest one where it is empty.
    options
        Sweep options of the mechanism.

    Raises
    ------
    InputError
        If the threshold is not in (0, 1), there is no such input, no mode pair is allowed, or
        the value of an option is not.
    UnknownNameError
        If there is no such mode pair, placement, link, design space or option.
    """

    mechanism: Mechanism
    shape: Shape
    goal: Goal
    modes: tuple[str, ...]
    lci_threshold: float = 0.5
    placement: str = ON_AXIS
    ranges: tuple[ActuatorRange, ...] = ()
    limits: tuple[LinkLimit, ...] = ()
    unit: str = "mm"
    space: str = ""
    options: Options = ()

    def __post_init__(self) -> None:
        self.mechanism.check_thresholds([self.lci_threshold])
        if not self.modes:
            raise InputError("modes", self.modes, "at least one mode pair")
        for mode in self.modes:
            self.mechanism.parse_mode(mode)
        if self.placement not in (ON_AXIS, FREE):
            raise UnknownNameError("placement", self.placement, (ON_AXIS, FREE))
        space = self.mechanism.parse_space(self.space or self.mechanism.spaces[-1])
        object.__setattr__(self, "space", space)
        lattice = self.mechanism.lattice(self.space, _RESOLUTION)
        some = self.design(lattice[len(lattice) // 2])
        check_ranges(self.ranges, some, self.modes[0])
        for limit in self.limits:
            self.length_place(limit)

    def design(self, parameters: FloatArray) -> PlanarDesign:
        """Return the non-dimensional design of parameters, shape (parameters,)."""
        return self.mechanism.design_of(parameters, self.options)

    def lengths(self, parameters: FloatArray, scale: float) -> FloatArray:
        """Return the lengths of the machine with D = 1/scale, shape (lengths,)."""
        return np.asarray(self.mechanism.proportions_of(parameters[None])[0] / scale)

    def length_place(self, limit: LinkLimit) -> int:
        """Return the place of the limited length among all; raise UnknownNameError."""
        names = [each.name for each in self.mechanism.lengths]
        return names.index(length_name(limit.name, names))

    @property
    def size(self) -> float:
        """Half the longer side of the box around the shape: scales times it are lengths."""
        lower, upper = self.shape.extent
        return 0.5 * float((upper - lower).max())

    def scales(self, designs: FloatArray, slack: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return the least and the greatest scale that designs, shape (n, parameters), may have.

        A machine has the dimensional factor D = 1/scale, and lengths times D keep to the limits,
        or miss them by no more than a share of slack.
        """
        proportions = self.mechanism.proportions_of(designs)
        # whatever the mechanism, nothing is farther from the origin than all lengths together
        greatest = proportions.sum(axis=1) / self.size
        least = _LEAST_SCALE * greatest
        for limit in self.limits:
            lengths = proportions[:, self.length_place(limit)]
            if math.isfinite(limit.greatest):
                least = np.maximum(least, lengths / limit.greatest / (1.0 + slack))
            if limit.least > 0.0:
                greatest = np.minimum(greatest, lengths / limit.least * (1.0 + slack))
        return least, greatest


@dataclasses.dataclass(frozen=True)
class Start:
    """A design with a placement of the shape, found on samples.

    Attributes
    ----------
    mode
        Mode pair.
    parameters
        Non-dimensional design, shape (parameters,).
    centre
        Centre of the shape in it, shape (2,).
    scale
        1/D.
    value
        The goal.
    """

    mode: str
    parameters: FloatArray
    centre: FloatArray
    scale: float
    value: float


def find_starts(
    task: MachineTask,
    progress: Callable[[int, int], None] | None = None,
    resolution: int = _RESOLUTION,
) -> list[Start]:
    """Return the best designs of a lattice that are apart from one another, the best first.

    Parameters
    ----------
    task
        What is asked.
    progress
        Called with the designs done and all designs.
    resolution
        Lattice steps.
    """
    designs = task.mechanism.lattice(task.space, resolution)
    blocks = [(mode, start) for mode in task.modes for start in range(0, len(designs), _BLOCK)]
    samples = _samples(task.shape)
    anchors = _anchors(task.placement)
    limits = np.array(
        [
            (
                each.number - 1,
                0.5 * (each.least + each.greatest),
                0.5 * (each.greatest - each.least),
            )
            for each in task.ranges
            if each.is_limiting
        ]
    ).reshape(-1, 3)
    scans = {
        mode: PlacementScan(mode, task.lci_threshold, samples, anchors, limits, task.options)
        for mode in task.modes
    }

    def evaluate(block: tuple[str, int]) -> list[Start]:
        mode, first = block
        return _evaluate(task, designs[first : first + _BLOCK], scans[mode])

    found: dict[tuple[str, int], list[Start]] = {}
    total = len(task.modes) * len(designs)
    for block, some in ThreadExecutor().run(evaluate, blocks):
        found[block] = some
        if progress is not None:
            progress(min(len(found) * _BLOCK, total), total)
    return _apart(task, [start for block in blocks for start in found[block]])


def _samples(shape: Shape) -> FloatArray:
    """Return points of a shape, those first that are likely to be the worst."""
    boundary = shape.boundary(shape.boundary_samples(_BOUNDARY))
    far = np.argsort(-np.hypot(*(boundary - boundary.mean(axis=0)).T), kind="stable")
    return np.concatenate([boundary[far], shape.interior_samples(_INTERIOR)])


def _anchors(placement: str) -> FloatArray:
    """Return positions as shares of the reach, shape (n, 2)."""
    if placement == ON_AXIS:
        y = np.linspace(-1.0, 1.0, _AXIS_POSITIONS + 2)[1:-1]
        return np.column_stack([np.zeros(len(y)), y])
    lines = [np.linspace(-1.0, 1.0, count + 2)[1:-1] for count in _FREE_POSITIONS]
    x, y = np.meshgrid(*lines)
    return np.column_stack([x.ravel(), y.ravel()])


def _evaluate(task: MachineTask, designs: FloatArray, scan: PlacementScan) -> list[Start]:
    """Return the placements of a block of designs in one mode pair."""
    least, greatest = task.scales(designs, _SLACK)
    found = task.mechanism.scan_placements(designs, least, greatest, scan)
    shrinking = _SHRINKING if task.goal.extremes else _SHRINKING[:1]
    starts = []
    for half in range(found.shape[1]):
        rows = np.flatnonzero(found[:, half, 0] > 0.0)
        if not len(rows):
            continue
        centres = found[rows, half, 1:]
        best = np.full(len(rows), np.inf)
        scale = found[rows, half, 0].copy()
        for share in shrinking:
            scales = share * found[rows, half, 0]
            placed = task.mechanism.placed_extremes(designs[rows], centres, scales, scan)
            extremes = task.goal.on_samples(placed)
            values = np.array(
                [
                    task.goal.value(task.mechanism, *each)
                    for each in zip(designs[rows], scales, extremes, strict=True)
                ]
            )
            better = (values < best) & (scales >= least[rows])
            best, scale = np.where(better, values, best), np.where(better, scales, scale)
        starts += [
            Start(scan.mode, designs[row], centres[k], float(scale[k]), float(best[k]))
            for k, row in enumerate(rows)
            if math.isfinite(best[k])
        ]
    return starts


def _apart(task: MachineTask, starts: Sequence[Start]) -> list[Start]:
    """Return the best starts, none near a better one, and the best of every mode and half plane.

    Mirror images count as one, that of the earlier mode pair.
    """
    if not starts:
        return []
    order = sorted(
        range(len(starts)),
        key=lambda k: (round(math.log(starts[k].value) / _SAME), task.modes.index(starts[k].mode)),
    )
    points = task.mechanism.project(np.array([each.parameters for each in starts]), task.space)
    chosen: list[int] = []
    seen: set[tuple[str, bool]] = set()
    for k in order:
        start = starts[k]
        kind = (start.mode, bool(start.centre[1] >= 0.0))
        is_first = kind not in seen
        seen.add(kind)
        is_good = len(chosen) < _STARTS and start.value < _WORTHWHILE * starts[order[0]].value
        if (is_first or is_good) and not any(
            _is_near(start, starts[c], points[k] - points[c]) for c in chosen
        ):
            chosen.append(k)
    return [starts[k] for k in chosen]


def _is_near(one: Start, other: Start, gap: FloatArray) -> bool:
    """Tell whether a start leads where another one does, or to its mirror image."""
    distance = float(np.hypot(*gap))
    if distance < _APART and abs(one.value - other.value) <= 2.0 * _SAME * other.value:
        return True
    same_place = one.mode == other.mode and (one.centre[1] >= 0.0) == (other.centre[1] >= 0.0)
    return same_place and distance < _APART
