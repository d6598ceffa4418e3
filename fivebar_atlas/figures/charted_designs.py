"""The designs of a lattice and where they lie in the chart: what every map is drawn on."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.charts import DesignChart

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@dataclasses.dataclass(frozen=True, slots=True)
class ChartedDesigns:
    """Designs of a lattice with their triangulation and their places in a chart.

    Attributes
    ----------
    parameters
        Designs, shape (n, parameters).
    points
        Their chart coordinates, shape (n, 2).
    triangles
        Triangulation of the lattice, indices of shape (m, 3).
    chart
        How the design space is drawn.
    """

    parameters: FloatArray
    points: FloatArray
    triangles: IntArray
    chart: DesignChart

    @classmethod
    def of_lattice(cls, mechanism: Mechanism, space: str, resolution: int) -> ChartedDesigns:
        """Return the designs of the lattice of a design space, in the lattice's order.

        Parameters
        ----------
        mechanism
            The mechanism.
        space
            Canonical text of one of its design spaces.
        resolution
            Number of lattice steps N.

        Raises
        ------
        UnknownNameError
            If the mechanism has no such design space.
        """
        parameters = mechanism.lattice(space, resolution)
        return cls(
            parameters=parameters,
            points=mechanism.project(parameters, space),
            triangles=mechanism.triangles(space, resolution),
            chart=mechanism.chart(space),
        )

    def check(self, values: npt.NDArray[Any]) -> None:
        """Raise InputError unless there is one value for each design."""
        if values.shape != (len(self.points),):
            allowed = f"one value for each of {len(self.points)} designs"
            raise InputError("values", values.shape, allowed)
