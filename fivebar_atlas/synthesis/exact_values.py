"""Values of any designs from the mechanism itself, as functions of chart coordinates."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.executors import ThreadExecutor, usable_cores
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.normalisation import NormalisedFunction
from fivebar_atlas.mechanisms.quantities import MODE, THRESHOLD, Results
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import Atlas
from fivebar_atlas.synthesis.design_polygon import DesignPolygon

FloatArray = npt.NDArray[np.float64]

#: Relative tolerances while regions and optima are searched for, and of a first survey; where
#: values hold to the tolerance of the file only, the survey has so many times that.
SEARCH_TOLERANCE, SURVEY_TOLERANCE, _SURVEY_FACTOR = 1e-7, 1e-6, 10.0

#: How far searches stay away from what is no design.
LEAST_MARGIN = 1e-6

#: How far they stay away from a side of the design space without values, if they must further.
OPEN_MARGINS = (2e-6, 1.1e-3)

# Places along a side that are looked at.
_SHARES = (0.2, 0.5, 0.8)

# Fewer are not worth the threads.
_DESIGNS_PER_THREAD = 24


def has_exact_values(atlas: Atlas, names: Sequence[str]) -> bool:
    """Return whether no name is an error estimate, which belongs to the file alone."""
    arrays = atlas.mechanism.stored_arrays(atlas.settings)
    return not {array.name for array in arrays if array.is_error} & set(names)


@dataclasses.dataclass(frozen=True, slots=True)
class ExactValues:
    """Some quantities as functions of the place in the chart.

    Attributes
    ----------
    mechanism
        The mechanism.
    settings
        What is evaluated: one mode pair, at most one threshold, the tolerance.
    names
        Parameters and quantities, in the order of the rows of values.
    polygon
        The design space; a point outside is taken to be the nearest one in it. What is
        no design, or hardly one, has no values.
    normalised
        Those of the quantities that are normalised over the file, with its extremes.
    """

    mechanism: Mechanism
    settings: SweepSettings
    names: tuple[str, ...]
    polygon: DesignPolygon
    normalised: tuple[NormalisedFunction, ...] = ()

    @classmethod
    def of_atlas(
        cls,
        atlas: Atlas,
        names: Sequence[str],
        mode: str | None = None,
        lci: float | None = None,
        tolerance: float | None = None,
    ) -> ExactValues:
        """Return quantities of a result file, for any design of its space.

        Parameters
        ----------
        atlas
            The open result file.
        names
            Parameters and quantities.
        mode, lci
            Mode pair and LCI threshold; needed only where the file holds several and a
            quantity depends on them.
        tolerance
            Relative tolerance; that of the mechanism for optima if not given.

        Raises
        ------
        InputError
            If a name is an error companion, which belongs to the file alone, or a mode
            pair or threshold must be chosen.
        """
        mechanism = atlas.mechanism
        arrays = {array.name: array for array in mechanism.stored_arrays(atlas.settings)}
        used: set[str] = set()
        for name in names:
            if name in arrays:
                if arrays[name].is_error:
                    allowed = (
                        "a quantity or parameter where exact values are needed: error "
                        "estimates belong to the file"
                    )
                    raise InputError("quantity", name, allowed)
                used.update(arrays[name].quantity.dimensions)
        modes, thresholds = atlas.modes[:1], tuple[float, ...]()
        places: dict[str, int] = {}
        if MODE in used:
            places[MODE] = atlas.mode_index(mode)
            modes = (atlas.modes[places[MODE]],)
        if THRESHOLD in used:
            places[THRESHOLD] = atlas.lci_index(lci)
            thresholds = (atlas.lci_thresholds[places[THRESHOLD]],)
        quantities = [arrays[name].quantity for name in names if name in arrays]
        if tolerance is None:
            tolerance = mechanism.exact_tolerance or atlas.settings.tolerance
        if all(quantity.ignores_tolerance for quantity in quantities):
            tolerance = mechanism.tolerance_range[1]
        settings = dataclasses.replace(
            atlas.settings, modes=modes, lci_thresholds=thresholds, tolerance=tolerance
        )
        polygon = DesignPolygon.of_space(mechanism, settings.space)
        products = (product.quantity.name for product in mechanism.normalised)
        normalised = tuple(atlas.normalised(name).at(places) for name in products if name in names)
        return cls(mechanism, settings, tuple(dict.fromkeys(names)), polygon, normalised)

    @property
    def _mode(self) -> str | None:
        """The mode pair, None where no quantity depends on it."""
        quantities = [each for each in self.mechanism.stored_quantities if each.name in self.names]
        has_mode = any(MODE in quantity.dimensions for quantity in quantities)
        return self.settings.modes[0] if has_mode else None

    @property
    def is_exact(self) -> bool:
        """Whether values are as good as exact; if not, they hold to the tolerance of the file."""
        return self.mechanism.exact_tolerance is not None

    def inside(self) -> ExactValues:
        """Return the same without sides of the design space that have no values.

        None is the best there, and where the mechanism keeps away from them by more values
        may cost a lot.
        """
        distances = np.zeros(len(self.polygon.corners))
        polygon = self.polygon
        for distance in OPEN_MARGINS:
            along = np.roll(polygon.corners, -1, axis=0) - polygon.corners
            places = np.concatenate([polygon.corners + share * along for share in _SHARES])
            values = self.for_survey().values(places)
            missing = np.isnan(values).any(axis=0).reshape(len(_SHARES), -1).all(axis=0)
            if not missing.any():
                break
            distances[missing] = distance
            polygon = self.polygon.moved_inward(distances)
        return dataclasses.replace(self, polygon=polygon)

    def for_search(self, tolerance: float = SEARCH_TOLERANCE) -> ExactValues:
        """Return the same with a looser tolerance, several times as fast."""
        tolerance = max(self.settings.tolerance, tolerance)
        return dataclasses.replace(
            self, settings=dataclasses.replace(self.settings, tolerance=tolerance)
        )

    def for_survey(self) -> ExactValues:
        """Return the same for a first survey, again several times as fast."""
        if self.is_exact:
            return self.for_search(SURVEY_TOLERANCE)
        loosest = self.mechanism.tolerance_range[1]
        return self.for_search(min(_SURVEY_FACTOR * self.settings.tolerance, loosest))

    def designs(self, points: FloatArray) -> FloatArray:
        """Return the designs at points of the chart, shape (n, 2)."""
        return self.mechanism.unproject(self.polygon.clip(points), self.settings.space)

    def values(self, points: FloatArray) -> FloatArray:
        """Return values at points of the chart, shape (names, n)."""
        return self.values_and_errors(self.designs(points))[0]

    def values_and_errors(self, designs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return values of designs and their error estimates, each of shape (names, n).

        The error of a parameter is 0, that of a quantity without an estimate NaN. What is no
        design has no value, not even of a parameter.
        """
        exist = self.mechanism.are_designs(designs, LEAST_MARGIN, self._mode)
        if not exist.all():
            values, errors = np.full((2, len(self.names), len(designs)), np.nan)
            values[:, exist], errors[:, exist] = self.values_and_errors(designs[exist])
            return values, errors
        columns = [parameter.name for parameter in self.mechanism.parameters]
        values = np.empty((len(self.names), len(designs)))
        errors = np.zeros_like(values)
        if all(name in columns for name in self.names):
            values[:] = designs[:, [columns.index(name) for name in self.names]].T
            return values, errors
        results = dict(self._results(designs))
        for function in self.normalised:
            results.update(function.arrays(results))
        for row, name in enumerate(self.names):
            if name in columns:
                values[row] = designs[:, columns.index(name)]
                continue
            quantity = self.mechanism.quantity(name)
            values[row] = np.reshape(results[name], len(designs))
            errors[row] = np.nan
            if quantity.has_error:
                errors[row] = np.reshape(results[quantity.error_name], len(designs))
        return values, errors

    def _results(self, designs: FloatArray) -> Results:
        """Return what the mechanism computes; many designs on several threads."""
        count = min(usable_cores(), len(designs) // _DESIGNS_PER_THREAD)
        if count < 2:
            return self.mechanism.evaluate(designs, self.settings)
        # Neighbours are alike in cost, so each thread gets some of everywhere.
        shares = [range(first, len(designs), count) for first in range(count)]
        parts = dict(
            ThreadExecutor(count).run(
                lambda share: self.mechanism.evaluate(
                    designs[share.start : share.stop : share.step], self.settings
                ),
                shares,
            )
        )
        results: dict[str, npt.NDArray[Any]] = {}
        for share, part in parts.items():
            for name, values in part.items():
                if name not in results:
                    results[name] = np.empty((len(designs), *values.shape[1:]), values.dtype)
                results[name][share.start : share.stop : share.step] = values
        return results

    def gradients(self, points: FloatArray, values: FloatArray) -> FloatArray:
        """Return gradients in the chart by differences of the second order.

        Of the step the square and the tolerance over it are alike small.

        Parameters
        ----------
        points
            Points of the design space, shape (n, 2).
        values
            The values there, shape (names, n).

        Returns
        -------
        ndarray
            Shape (names, n, 2); near the border from one side.
        """
        step = self.mechanism.exact_step
        stencils = [self.polygon.directions(point, step) for point in points]
        directions = np.array([each for each, _ in stencils]).reshape(-1, 2, 2)
        central = np.array([each for _, each in stencils]).reshape(-1, 2)
        second = np.where(central, -step, 2.0 * step)[..., np.newaxis]
        places = np.stack(
            [
                points[:, np.newaxis, :] + step * directions,
                points[:, np.newaxis, :] + second * directions,
            ],
            axis=2,
        )
        around = self.for_search().values(places.reshape(-1, 2)).reshape(len(self.names), -1, 2, 2)
        one, other, here = around[..., 0], around[..., 1], values[..., np.newaxis]
        slopes = np.where(central, one - other, 4.0 * one - 3.0 * here - other) / (2.0 * step)
        # slope = direction . gradient, for two directions
        return np.linalg.solve(directions, slopes[..., np.newaxis])[..., 0]
