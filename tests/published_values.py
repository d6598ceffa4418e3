"""Values printed in papers, and the computation of ours through the public interface.

The data are in ``published/*.yaml``; the tests and the validation page read them here.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

from fivebar_atlas import FiveBar, mechanisms
from fivebar_atlas.mechanisms.pentapod import geometry, kinematics, statics
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.synthesis.containment import ActuatorRange
from fivebar_atlas.synthesis.largest_square import SquareTask, unit_design
from fivebar_atlas.synthesis.least_lci import least_lci
from fivebar_atlas.synthesis.shapes import Shape
from fivebar_atlas.synthesis.square_curve import (
    SquareCurve,
    ratios_between,
    square_curve,
    tied_square,
)

FOLDER = Path(__file__).parent / "published"

REPRODUCED = "reproduced"
LAST_DIGIT_DIFFERS = "last_digit_differs"
NOT_REPRODUCED = "not_reproduced"

_LENGTHS = ("r1", "r2", "r3")

Results = dict[str, npt.NDArray[np.float64]]


@dataclasses.dataclass(frozen=True)
class PublishedValue:
    """One printed value.

    Attributes
    ----------
    identity
        Short name of the entry.
    where
        Where in the paper it is printed.
    says
        What it is the value of.
    printed
        The digits as printed, the two ends of a printed range, or of the range in which a
        claim holds.
    claim
        What the paper says in words, None where it prints a number.
    verdict
        What becomes of it: one of the three verdicts.
    explanation
        Why, where there is something to say.
    exact
        Our value to the digits that independent methods agree on, None where not known.
    computation
        What is computed, and from what.
    mode
        The mode pair.
    paper
        Authors and year of the paper.
    """

    identity: str
    where: str
    says: str
    printed: str | list[str]
    claim: str | None
    verdict: str
    explanation: str
    exact: str | None
    computation: dict[str, Any]
    mode: str
    paper: str = ""

    def compute(self) -> float:
        """Return our value."""
        kind = next(iter(self.computation))
        return _COMPUTATIONS[kind](mode=self.mode, **self.computation)

    def judge(self, ours: float) -> str:
        """Return the verdict that our value deserves; NaN, where there is none, never agrees."""
        if math.isnan(ours):
            return NOT_REPRODUCED
        if not isinstance(self.printed, str):
            low, high = (float(end) for end in self.printed)
            return REPRODUCED if low <= ours <= high else NOT_REPRODUCED
        printed = Decimal(self.printed)
        unit = Decimal(1).scaleb(int(printed.as_tuple().exponent))
        units = abs(Decimal(ours).quantize(unit) - printed) / unit
        return {0: REPRODUCED, 1: LAST_DIGIT_DIFFERS}.get(int(units), NOT_REPRODUCED)


def load() -> list[PublishedValue]:
    """Return every published value of every paper, those of a paper together."""
    values = []
    for file in sorted(FOLDER.glob("*.yaml")):
        data = yaml.safe_load(file.read_text(encoding="utf-8"))
        values += [
            PublishedValue(
                identity=entry["id"],
                where=entry["where"],
                says=entry["says"],
                printed=entry.get("printed") or entry["holds_between"],
                claim=entry.get("claim"),
                verdict=entry["verdict"],
                explanation=entry["explanation"],
                exact=entry.get("exact"),
                computation=entry["compute"],
                mode=data["mode"],
                paper=data["paper"],
            )
            for entry in data["values"]
        ]
    return values


def _quantity(
    *, quantity: str, design: list[float], mode: str, lci_threshold: float = 0.5
) -> float:
    return _of_one(FiveBar(*design), quantity, mode, lci_threshold)


def _of_one(manipulator: FiveBar, quantity: str, mode: str, lci_threshold: float = 0.5) -> float:
    values = manipulator.evaluate(mode, [lci_threshold], tolerance=1e-9)
    (good,) = values["good_condition"]
    values |= {"good_condition_workspace_area": good["area"], "good_condition_gci": good["gci"]}
    return float(values[quantity])


def _lci_radius(*, lci_radius: str, design: list[float], lci_threshold: float, mode: str) -> float:
    """Return where LCI passes the threshold along the y axis, by bisection."""
    manipulator = FiveBar(*design)

    def above(y: float) -> bool:
        return float(manipulator.lci(0.0, y, mode)) >= lci_threshold

    r1, r2, _ = design
    # On the edge r3 = 0 the LCI vanishes on both circles and is isotropic between them.
    ring = r2 / math.sqrt(2) + math.sqrt(r1**2 - r2**2 / 2)
    inside, outside = {
        "inner": (r2 / math.sqrt(2) - math.sqrt(r1**2 - r2**2 / 2), abs(r1 - r2)),
        "outer": (ring, r1 + r2),
    }[lci_radius]
    assert above(inside)
    while abs(inside - outside) > 1e-12:
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if above(middle) else (inside, middle)
    return 0.5 * (inside + outside)


@functools.cache
def _lattice(resolution: int, mode: str) -> tuple[npt.NDArray[np.float64], Results]:
    """Return the designs of the surrounded space, and their results to four digits."""
    mechanism = mechanisms.get("five-bar")
    settings = SweepSettings("five-bar", "surrounded", resolution, (mode,), (), 1e-4)
    designs = mechanism.lattice(settings.space, settings.resolution)
    results = mechanism.evaluate(designs, settings)
    return designs, {name: results[name][:, 0] for name in ("usable_workspace_area", "gci")}


def _largest_over_lattice(*, largest_over_lattice: str, resolution: int, mode: str) -> float:
    return float(np.nanmax(_lattice(resolution, mode)[1][largest_over_lattice]))


def _place_of_largest(*, place_of_largest: str, length: str, resolution: int, mode: str) -> float:
    designs, results = _lattice(resolution, mode)
    return float(designs[np.nanargmax(results[place_of_largest]), _LENGTHS.index(length)])


def _region_bound(
    *, region_bound: str, length: str, area: float, gci: float, resolution: int, mode: str
) -> float:
    """Return a bound of the lattice designs that fulfil both conditions, NaN without any."""
    designs, results = _lattice(resolution, mode)
    inside = (results["usable_workspace_area"] > area) & (results["gci"] > gci)
    values = designs[inside, _LENGTHS.index(length)]
    if not len(values):
        return math.nan
    return float(values.min() if region_bound == "least" else values.max())


def _sizing(
    *, sizing: str, area: float, design: list[float], lci_threshold: float, mode: str
) -> float:
    own = _quantity(
        quantity="good_condition_workspace_area",
        design=design,
        mode=mode,
        lci_threshold=lci_threshold,
    )
    factor = math.sqrt(area / own)
    return factor * dict(zip(("D", "R1", "R2", "R3"), (1.0, *design), strict=True))[sizing]


def _machine(*, machine: str, lengths: list[float], mode: str) -> float:
    manipulator = FiveBar.from_lengths(*lengths)
    factor = manipulator.dimensional_factor
    if machine == "D":
        return factor
    if machine in _LENGTHS:
        return float(getattr(manipulator, machine))
    if machine == "usable_workspace_area":
        return factor**2 * _of_one(manipulator, machine, mode)
    raise ValueError(f"there is no computation of {machine!r}")


def _task(mode: str, lci_threshold: float, actuator_range: list[float]) -> SquareTask:
    """Return the task of a square with one range for both inputs."""
    ranges = tuple(
        ActuatorRange(number, *(math.radians(end) for end in actuator_range)) for number in (1, 2)
    )
    return SquareTask(mechanisms.get("five-bar"), mode, lci_threshold, ranges)


def _optimal_configuration(*, optimal_configuration: str, ratio: float, mode: str) -> float:
    optimal = mechanisms.get("five-bar").optimal_configuration(ratio)
    pose = mechanisms.get("five-bar").planar_design(optimal.lengths).pose(*optimal.output, mode)
    return float(getattr(pose, optimal_configuration))


def _largest_square(
    *,
    largest_square: str,
    ratio: float,
    lci_threshold: float,
    actuator_range: list[float],
    mode: str,
) -> float:
    square = tied_square(_task(mode, lci_threshold, actuator_range), ratio)
    return float(getattr(square, largest_square))


@functools.cache
def _curve(least: float, greatest: float, lci_threshold: float, mode: str) -> SquareCurve:
    """Return the curve for the ranges of Le, Kang and Doan."""
    return square_curve(
        _task(mode, lci_threshold, [-60.0, 240.0]), ratios_between(least, greatest, 0.05)
    )


def _best_square(
    *,
    best_square: str,
    between: list[float],
    lci_threshold: float,
    actuator_range: list[float],
    mode: str,
) -> float:
    assert actuator_range == [-60.0, 240.0]
    largest = _curve(*between, lci_threshold, mode).largest
    assert largest is not None
    return float(getattr(largest, best_square))


def _in_the_square(
    *,
    in_the_square: str,
    ratio: float,
    mode: str,
    side: float | None = None,
    lci_threshold: float = 0.5,
    actuator_range: Sequence[float] = (-60.0, 240.0),
) -> float:
    """Return the least or the largest LCI in a square about the centre of the largest one."""
    square = tied_square(_task(mode, lci_threshold, [*actuator_range]), ratio)
    design, factor = unit_design(square.task.mechanism, square.lengths)
    scale = (square.side if side is None else side) / factor
    x, y = (part / factor for part in square.centre)
    if in_the_square == "least_lci":
        return least_lci(design, mode, Shape.rectangle(1.0, 1.0), (x, y), scale).value
    found = design.largest_lci(mode)
    assert found is not None
    value, place = found
    assert max(abs(place[0] - x), abs(place[1] - y)) <= 0.5 * scale
    return value


def _pentapod_mobility(*, pentapod_mobility: str, mode: str) -> float:  # noqa: ARG001
    return geometry.mobility()


def _start_height(
    *,
    start_height: int,
    radii: list[float],
    limb_length: float,
    mode: str,  # noqa: ARG001
) -> float:
    """Return the height of the platform at which a limb has a length, with parallel axes."""
    pose = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    limbs = kinematics.inverse_displacement(PentapodGeometry.from_radii(*radii), pose)
    # the limb is this far out, and 1 high in this pose
    out = limbs.lengths[start_height - 1] ** 2 - 1.0
    return math.sqrt(limb_length**2 - out)


def _force_ratio(
    *,
    force_ratio: float,
    height: float,
    radii: list[float],
    mode: str,  # noqa: ARG001
) -> float:
    """Return the largest active force at a Y over that on the Z axis, for the printed wrench."""
    pentapod = PentapodGeometry.from_radii(*radii)
    poses = np.array([[0.0, y, height, 0.0, 0.0, 0.0] for y in (force_ratio, 0.0)])
    poses = kinematics.solve_constraint(pentapod, poses, "alpha").poses[:, 0]
    wrench = [0.0, 10.0, -10.0, 10.0, 0.0, 10.0]
    far, near = np.abs(statics.joint_forces(pentapod, poses, wrench)[:, :5]).max(axis=1)
    return float(far / near)


@functools.cache
def _pentapod_lattice(resolution: int, mode: str) -> float:
    """Return the largest GCI of the lattice."""
    mechanism = mechanisms.get("pentapod")
    settings = SweepSettings("pentapod", "radii", resolution, (mode,), (), 1e-2)
    results = mechanism.evaluate(mechanism.lattice("radii", resolution), settings)
    return float(np.nanmax(results["gci"]))


def _gci_ratio(*, gci_ratio: list[float], resolution: int, mode: str) -> float:
    """Return the largest GCI of the lattice over that of a machine H, r_a, r_b."""
    mechanism = mechanisms.get("pentapod")
    design, _ = mechanism.from_lengths(gci_ratio)
    settings = SweepSettings("pentapod", "radii", resolution, (mode,), (), 1e-3)
    own = mechanism.evaluate(design[None], settings)["gci"]
    return _pentapod_lattice(resolution, mode) / float(own[0])


_COMPUTATIONS: dict[str, Callable[..., float]] = {
    "quantity": _quantity,
    "lci_radius": _lci_radius,
    "largest_over_lattice": _largest_over_lattice,
    "place_of_largest": _place_of_largest,
    "region_bound": _region_bound,
    "sizing": _sizing,
    "machine": _machine,
    "optimal_configuration": _optimal_configuration,
    "largest_square": _largest_square,
    "best_square": _best_square,
    "in_the_square": _in_the_square,
    "pentapod_mobility": _pentapod_mobility,
    "start_height": _start_height,
    "force_ratio": _force_ratio,
    "gci_ratio": _gci_ratio,
}
