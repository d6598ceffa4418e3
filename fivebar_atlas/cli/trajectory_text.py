"""How a trajectory is presented: as lines and as JSON, when it is solved and when it is stored."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.arrays import FloatArray
    from fivebar_atlas.mechanisms.motions import Column
    from fivebar_atlas.trajectories.motion_problem import Trajectory
    from fivebar_atlas.trajectories.trajectory_file import StoredTrajectory

# Columns of this beginning of their meaning are active forces.
_ACTIVE = "active force"


def document(file: Path, solved: Trajectory) -> dict[str, Any]:
    """Return the summary of a solved motion as JSON has it."""
    units = solved.solution.units
    return {
        "file": str(file),
        "mechanism": solved.mechanism.name,
        "machine": solved.machine,
        "samples": len(solved.solution.times),
        "duration": float(solved.solution.times[-1] - solved.solution.times[0]),
        "units": {
            "length": units.length,
            "force": units.force,
            "moment": units.moment,
            "time": units.time,
            "angle": "deg",
        },
        "quantities": list(_extremes(solved.solution.times, solved.solution)),
        "largest_active_force": _largest_force(solved.solution.times, solved.solution),
        **solved.solution.facts,
        "estimated_errors": {
            name: {"value": value, "unit": solved.error_units[name]}
            for name, value in solved.errors.items()
        },
    }


def lines(file: Path, solved: Trajectory) -> Iterator[str]:
    """Yield the summary of a solved motion as lines."""
    solution = solved.solution
    time, force = solution.units.time, solution.units.force
    yield solved.mechanism.title
    yield solved.machine
    yield (
        f"{file}: {_span(solution.times, time)}; lengths in {solution.units.length}, forces in "
        f"{force}, moments in {solution.units.moment}"
    )
    yield ""
    yield from _table(solution.times, time, solution)
    yield ""
    largest = _largest_force(solution.times, solution)
    yield (
        f"largest active force   {largest['name']} = {largest['value']:.6g} {force} at "
        f"t = {largest['at']:.5g} {time} (positive pushes the platform)"
    )
    facts = solution.facts
    yield (
        f"least LCI              {facts['least_lci']:.6g} at t = {facts['least_lci_time']:.5g} "
        f"{time}, with L = {facts['characteristic_length']:.6g} {solution.units.length}"
    )
    if solved.errors:
        yield "estimated errors of derivatives from samples, at most:"
        for name, value in solved.errors.items():
            yield f"  {name:<24}{value:.2e} {solved.error_units[name]}"


def stored_document(stored: StoredTrajectory) -> dict[str, Any]:
    """Return what a trajectory file holds as JSON has it."""
    return {
        "file": str(stored.path),
        "bytes": stored.path.stat().st_size,
        "trajectory_of": stored.attributes["mechanism"],
        "machine": stored.attributes["machine"],
        "samples": len(stored.times),
        "duration": float(stored.times[-1] - stored.times[0]),
        "quantities": list(_extremes(stored.times, stored.columns)),
        "made": dict(stored.attributes),
    }


def stored_lines(stored: StoredTrajectory) -> Iterator[str]:
    """Yield what a trajectory file holds as lines."""
    yield f"{stored.path} ({stored.path.stat().st_size:,} bytes)"
    yield f"trajectory of a {stored.attributes['mechanism']}: {stored.attributes['machine']}"
    yield _span(stored.times, stored.time_unit)
    yield ""
    yield from _table(stored.times, stored.time_unit, stored.columns)
    yield ""
    yield "made by"
    for name, value in stored.attributes.items():
        first, *rest = str(value).strip().splitlines() or [""]
        yield f"  {name:21}  {first}"
        yield from (f"  {'':21}  {line}" for line in rest)


def _span(times: FloatArray, unit: str) -> str:
    """Return number and range of samples."""
    return f"{len(times):,} samples from t = {float(times[0]):g} to {float(times[-1]):g} {unit}"


def _extremes(times: FloatArray, columns: Iterable[Column]) -> Iterator[dict[str, Any]]:
    """Yield range and times of every quantity."""
    import numpy as np

    for column in columns:
        low, high = int(np.argmin(column.values)), int(np.argmax(column.values))
        yield {
            "name": column.name,
            "long_name": column.long_name,
            "unit": column.unit,
            "group": column.group,
            "least": float(column.values[low]) + 0.0,
            "least_at": float(times[low]),
            "greatest": float(column.values[high]) + 0.0,
            "greatest_at": float(times[high]),
        }


def _table(times: FloatArray, time_unit: str, columns: Iterable[Column]) -> Iterator[str]:
    """Yield the range of every quantity, a line each, by groups."""
    when = f"at t ({time_unit})"
    yield f"{'':<23}{'unit':<8}{'least':>13}{when:>12}{'greatest':>13}{when:>12}"
    group = ""
    for each in _extremes(times, columns):
        if each["group"] != group:
            group = each["group"]
            yield group
        # what is nothing but rounding is 0
        least, greatest = each["least"], each["greatest"]
        tiny = 1e-12 * max(abs(least), abs(greatest), 1e-3)
        least, greatest = (0.0 if abs(value) <= tiny else value for value in (least, greatest))
        yield (
            f"  {each['name']:<21}{each['unit']:<8}{least:>13.6g}{each['least_at']:>12.5g}"
            f"{greatest:>13.6g}{each['greatest_at']:>12.5g}"
        )


def _largest_force(times: FloatArray, columns: Iterable[Column]) -> dict[str, Any]:
    """Return the largest active force and when it is."""
    import numpy as np

    active = [column for column in columns if column.long_name.startswith(_ACTIVE)]
    values = np.array([column.values for column in active])
    limb, place = np.unravel_index(int(np.argmax(np.abs(values))), values.shape)
    return {
        "name": active[int(limb)].name,
        "value": float(values[limb, place]),
        "at": float(times[place]),
    }
