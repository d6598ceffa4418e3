"""Products of quantities that are normalised over all designs of an atlas, with their errors.

Nam and Park (2006), Sec. 6.1 and Eq. 31. With the extremes known, a normalised product is a
function of what the evaluator returns: for the designs of the atlas and for any others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.quantities import NormalisedProduct, Quantity, Results


class Extremes(NamedTuple):
    """Least and greatest value of a quantity over the designs of an atlas.

    Attributes
    ----------
    least, greatest
        Extremes of the finite values, shaped as the axes of the quantity after the design
        axis; NaN where there are none.
    least_error, greatest_error
        How far the true extremes are from them at most; 0 for a quantity without errors.
    """

    least: FloatArray
    greatest: FloatArray
    least_error: FloatArray
    greatest_error: FloatArray

    @classmethod
    def of_parts(cls, parts: Iterable[tuple[FloatArray, FloatArray]]) -> Extremes:
        """Return the extremes of values that come with their errors, some designs at a time.

        Each part has the design axis first. The true least value is one of those that, less
        their errors, reach down to where the lowest of them does.
        """
        least, greatest, lowest, highest = np.full((4, 1), np.nan)
        for values, errors in parts:
            finite = np.where(np.isfinite(values), values, np.nan)
            least = np.fmin(least, np.fmin.reduce(finite))
            greatest = np.fmax(greatest, np.fmax.reduce(finite))
            lowest = np.fmin(lowest, np.fmin.reduce(finite - errors))
            highest = np.fmax(highest, np.fmax.reduce(finite + errors))
        least_error = np.fmax(least - lowest, 0.0)
        return cls(least, greatest, least_error, np.fmax(highest - greatest, 0.0))

    def shaped(self, lengths: tuple[int, ...]) -> Extremes:
        """Return the same with axes of these lengths."""
        return Extremes(*(each.reshape(lengths) for each in self))

    def at(self, index: tuple[slice, ...]) -> Extremes:
        """Return those at some entries of the axes."""
        return Extremes(*(each[index] for each in self))


@dataclasses.dataclass(frozen=True, slots=True)
class NormalisedFunction:
    """A normalised product as a function of what the evaluator returns.

    Attributes
    ----------
    product
        The product.
    factors
        The quantities that are multiplied.
    extremes
        Extremes of each factor over the atlas.
    """

    product: NormalisedProduct
    factors: tuple[Quantity, ...]
    extremes: tuple[Extremes, ...]

    def at(self, places: Mapping[str, int]) -> NormalisedFunction:
        """Return the same for results with a single entry on some axes, given by its place."""
        chosen = []
        for factor, extremes in zip(self.factors, self.extremes, strict=True):
            index = (
                slice(places[name], places[name] + 1) if name in places else slice(None)
                for name in factor.dimensions[1:]
            )
            chosen.append(extremes.at(tuple(index)))
        return dataclasses.replace(self, extremes=tuple(chosen))

    def arrays(self, results: Results) -> dict[str, FloatArray]:
        """Return the product, and its error if it has one, by their names.

        Parameters
        ----------
        results
            Arrays of the factors and of their errors, the design axis first.

        Returns
        -------
        dict
            NaN where a factor does not exist for the design, and everywhere at a place of
            the other axes where the range (or the largest value) that a factor is divided by
            is not above zero by more than the errors of the extremes.

        Notes
        -----
        For g = (f - m)/s with s = M - m and errors e of f, m and M, no more than
        (e_f + |1 - g| e_m + |g| e_M)/(s - e_m - e_M) lies between g and the true one. Errors
        of products are those of all their terms, of second order too.
        """
        quantity = self.product.quantity
        value, error = np.ones((1,) * len(quantity.dimensions)), np.zeros(1)
        for factor, extremes in zip(self.factors, self.extremes, strict=True):
            # One axis for each of the product's.
            index = tuple(
                slice(None) if name in factor.dimensions else np.newaxis
                for name in quantity.dimensions
            )
            one, its_error = (each[index] for each in self._normalised(factor, extremes, results))
            error = np.abs(value) * its_error + np.abs(one) * error + error * its_error
            value = value * one
        arrays = {quantity.name: value}
        if quantity.has_error:
            arrays[quantity.error_name] = error
        return arrays

    def _normalised(
        self, factor: Quantity, extremes: Extremes, results: Results
    ) -> tuple[FloatArray, FloatArray]:
        """Return a normalised factor and its error."""
        values = results[factor.name]
        errors = results[factor.error_name] if factor.has_error else np.zeros_like(values)
        least, least_error = extremes.least, extremes.least_error
        if self.product.normalisation == "largest":
            least, least_error = np.zeros((2, *least.shape))
        span = extremes.greatest - least
        sure = span - (least_error + extremes.greatest_error)
        span, sure = (np.where(sure > 0.0, each, np.nan) for each in (span, sure))
        one = (values - least) / span
        spread = np.abs(1.0 - one) * least_error + np.abs(one) * extremes.greatest_error
        return one, (errors + spread) / sure
