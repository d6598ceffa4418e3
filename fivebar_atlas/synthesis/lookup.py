"""One machine in an atlas: values read off between lattice designs beside the exact ones."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.quantities import Axis, Quantity, plain
from fivebar_atlas.store import Atlas
from fivebar_atlas.synthesis.design_polygon import ON_SIDE, DesignPolygon

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

# A design belongs to a triangle up to this barycentric weight outside it.
_ROUNDING = 1e-9


@dataclasses.dataclass(frozen=True, slots=True)
class Entry:
    """One stored value at one design.

    Attributes
    ----------
    quantity
        The quantity.
    labels
        Where it stands on the axes it depends on, by their names: ``{"mode": "+-/up"}``.
    interpolated
        The value by linear interpolation; the meanings at the corners for a category;
        None where a corner of the triangle has no value.
    exact, error
        The value of the design itself and its error estimate; None where there is none.
    """

    quantity: Quantity
    labels: dict[str, str]
    interpolated: float | str | None
    exact: float | str | None
    error: float | None

    @property
    def difference(self) -> float | None:
        """Interpolation error: the interpolated value minus the exact one."""
        if isinstance(self.interpolated, float) and isinstance(self.exact, float):
            return self.interpolated - self.exact
        return None

    def scaled(self, factor: float) -> tuple[float, float] | None:
        """Return interpolated and exact value of a machine with dimensional factor D.

        None for what does not depend on the size, and where a value is missing.
        """
        if not (isinstance(self.interpolated, float) and isinstance(self.exact, float)):
            return None
        scale = factor**self.quantity.length_power
        return (scale * self.interpolated, scale * self.exact) if scale != 1.0 else None


@dataclasses.dataclass(frozen=True, slots=True)
class Lookup:
    """What an atlas says of one design.

    Attributes
    ----------
    parameters, proportions, factor
        The non-dimensional design by parameter, its lengths by name, and its dimensional
        factor D.
    corners
        Designs of the lattice triangle it lies in, shape (3, parameters).
    weights
        Their barycentric weights, shape (3,).
    entries
        Every stored quantity, for every entry of its axes.
    """

    parameters: dict[str, float]
    proportions: dict[str, float]
    factor: float
    corners: FloatArray
    weights: FloatArray
    entries: tuple[Entry, ...]

    def document(self) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON."""
        return {
            **self.parameters,
            "dimensional_factor": self.factor,
            "lengths": {name: self.factor * value for name, value in self.proportions.items()},
            "corners": self.corners.tolist(),
            "weights": self.weights.tolist(),
            "values": [self._entry(entry) for entry in self.entries],
        }

    def _entry(self, entry: Entry) -> dict[str, Any]:
        scaled = entry.scaled(self.factor)
        return {
            "quantity": entry.quantity.name,
            **entry.labels,
            "interpolated": entry.interpolated,
            "exact": entry.exact,
            "error": entry.error,
            "interpolation_error": entry.difference,
            "scaled_interpolated": None if scaled is None else scaled[0],
            "scaled_exact": None if scaled is None else scaled[1],
        }


def look_up(atlas: Atlas, lengths: Sequence[float]) -> Lookup:
    """Return what an atlas says of one design, and how well.

    Parameters
    ----------
    atlas
        The open result file.
    lengths
        The lengths of the mechanism, dimensional or not.

    Returns
    -------
    Lookup
        Values by linear interpolation on the lattice triangle that contains the design,
        and exact ones with the file's mode pairs, thresholds and tolerance.

    Raises
    ------
    InputError
        If the lengths make no mechanism, or one outside the design space of the file or
        between its border and the nearest designs of the lattice.
    FileError
        If the file is damaged.
    """
    mechanism, settings = atlas.mechanism, atlas.settings
    design, factor = mechanism.from_lengths(lengths)
    point = mechanism.project(design[np.newaxis], settings.space)
    names = [parameter.name for parameter in mechanism.parameters]
    shown = ", ".join(f"{name} {value:.6g}" for name, value in zip(names, design, strict=True))
    in_space = f"a design in the {settings.space} space of the file"
    if not mechanism.are_in_space(design[np.newaxis], settings.space)[0]:
        raise InputError("design", shown, in_space)
    polygon = DesignPolygon.of_space(mechanism, settings.space)
    if not polygon.contains(point)[0]:
        sides = zip(
            polygon.names(mechanism, settings.space), polygon.distances(point)[0], strict=True
        )
        beyond = " and ".join(name for name, distance in sides if distance < -ON_SIDE)
        raise InputError("design", shown, f"{in_space}; it lies beyond {beyond}")
    triangles = mechanism.triangles(settings.space, settings.resolution)
    found, weights = _containing(
        mechanism.project(atlas.designs, settings.space), triangles, point[0]
    )
    if found < 0:
        allowed = "a design between those of the lattice, not between them and the border"
        raise InputError("design", shown, allowed)
    corners = triangles[found]
    results = mechanism.evaluate(design[np.newaxis], settings)
    for product in mechanism.normalised:
        results.update(atlas.normalised(product.quantity.name).arrays(results))
    axes = {axis.name: axis for axis in mechanism.axes(settings)}
    entries = []
    for quantity in mechanism.stored_quantities:
        stored = _rows(atlas, quantity.name, corners)
        for index, labels in _indices([axes[name] for name in quantity.dimensions[1:]]):
            exact = results[quantity.name][(0, *index)]
            place: tuple[Any, ...] = (slice(None), *index)
            values = stored[place]
            error = None
            if quantity.has_error:
                error = plain(results[quantity.error_name][(0, *index)])
            interpolated: float | str | None
            if quantity.flags is not None:
                meanings = [quantity.flags.describe(int(value)) for value in values]
                interpolated = " / ".join(dict.fromkeys(meanings))
            else:
                used = weights > 0.0
                interpolated = plain(weights[used] @ values[used])
            entries.append(
                Entry(quantity, labels, interpolated, plain(exact, quantity.flags), error)
            )
    (proportions,) = mechanism.proportions_of(design[np.newaxis])
    lengths_named = [each.name for each in mechanism.proportions]
    return Lookup(
        parameters=dict(zip(names, map(float, design), strict=True)),
        proportions=dict(zip(lengths_named, proportions.tolist(), strict=True)),
        factor=factor,
        corners=atlas.designs[corners],
        weights=weights,
        entries=tuple(entries),
    )


def _rows(atlas: Atlas, name: str, designs: IntArray) -> npt.NDArray[Any]:
    """Return the stored values of a few designs, shape (designs, ...)."""
    return np.stack([atlas.read(name, int(design)) for design in designs])


def _indices(axes: Sequence[Axis]) -> Iterator[tuple[tuple[int, ...], dict[str, str]]]:
    """Yield the index and the labels of every entry of several axes."""
    for index in itertools.product(*(range(len(axis)) for axis in axes)):
        pairs = zip(axes, index, strict=True)
        yield index, {axis.name: axis.labels[number] for axis, number in pairs}


def _containing(
    points: FloatArray, triangles: IntArray, point: FloatArray
) -> tuple[int, FloatArray]:
    """Return the triangle that contains a point and its barycentric weights; -1 if none.

    Of triangles that share the point, the one in which it lies deepest; a weight that is
    zero but for rounding is zero.
    """
    if not len(triangles):
        return -1, np.zeros(3)
    first, second, third = (points[triangles[:, corner]] for corner in range(3))
    one, other, here = second - first, third - first, point - first
    areas = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    at_second = (here[:, 0] * other[:, 1] - here[:, 1] * other[:, 0]) / areas
    at_third = (one[:, 0] * here[:, 1] - one[:, 1] * here[:, 0]) / areas
    weights = np.column_stack([1.0 - at_second - at_third, at_second, at_third])
    place = int(np.argmax(weights.min(axis=1)))
    found = weights[place]
    if found.min() < -_ROUNDING:
        return -1, found
    found = np.where(found < _ROUNDING, 0.0, found)
    return place, found / found.sum()
