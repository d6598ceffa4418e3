"""The designs of a lattice under conditions, and the best of them by exact values."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import NoDesignError
from fivebar_atlas.store import Atlas
from fivebar_atlas.synthesis.conditions import Condition, rounded_margins
from fivebar_atlas.synthesis.design_polygon import ON_SIDE, DesignPolygon
from fivebar_atlas.synthesis.exact_values import ExactValues, has_exact_values
from fivebar_atlas.synthesis.maximise import Optimum, local_maxima, maximise
from fivebar_atlas.synthesis.objectives import Objective
from fivebar_atlas.synthesis.optimum_region import OptimumRegion, optimum_region
from fivebar_atlas.synthesis.refined_region import (
    RefinedRegion,
    outline_error,
    refine,
)

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

# Starts of a search: so many summits of the lattice, designs that are best, and corners of
# the region.
_SUMMITS = 12
_DESIGNS = 200
_CORNERS = 100


class Candidates:
    """The designs of a result file that fulfil conditions.

    Parameters
    ----------
    atlas
        The open result file.
    conditions
        The conditions; none means all designs.
    mode, lci
        Mode pair and LCI threshold of the quantities that depend on them; needed only
        where the file holds several.

    Raises
    ------
    UnknownNameError
        If a condition names something that is neither a quantity nor a parameter.
    InputError
        If a mode pair or threshold is not in the file or must be chosen.
    FileError
        If the file is damaged.
    """

    def __init__(
        self,
        atlas: Atlas,
        conditions: Sequence[Condition],
        mode: str | None = None,
        lci: float | None = None,
    ) -> None:
        self.atlas = atlas
        self.conditions = tuple(conditions)
        self.mode = mode
        self.lci = lci
        self.region: OptimumRegion = optimum_region(atlas, conditions, mode, lci)

    @functools.cached_property
    def points(self) -> FloatArray:
        """Designs of the lattice in the chart, shape (designs, 2)."""
        return self.charted(self.atlas.designs)

    @functools.cached_property
    def triangles(self) -> IntArray:
        """Triangulation of the lattice, shape (triangles, 3)."""
        settings = self.atlas.settings
        return self.atlas.mechanism.triangles(settings.space, settings.resolution)

    @functools.cached_property
    def spacing(self) -> float:
        """Distance of neighbouring designs of the lattice in the chart."""
        ends = self.points[self.triangles[:1]] if len(self.triangles) else self.points[None, :2]
        return float(np.max(np.linalg.norm(np.diff(ends, axis=1), axis=2), initial=0.0))

    @functools.cached_property
    def fulfilled(self) -> BoolArray:
        """Which designs of the lattice fulfil all conditions, shape (designs,)."""
        fulfilled = np.ones(len(self.atlas), dtype=np.bool_)
        for condition in self.conditions:
            fulfilled &= condition.holds(self.values((condition.quantity,))[0])
        return fulfilled

    @property
    def is_empty(self) -> bool:
        """Whether no design at all fulfils the conditions, on the lattice or between."""
        return self.region.region.is_empty and self.region.lattice_designs == 0

    @property
    def margins(self) -> FloatArray:
        """Margins of the conditions at the designs, shape (conditions, designs)."""
        rows = [
            rounded_margins(condition, self.values((condition.quantity,))[0])
            for condition in self.conditions
        ]
        return np.array(rows).reshape(len(rows), len(self.atlas))

    @property
    def scales(self) -> FloatArray:
        """The scale of each condition's margin, shape (conditions,)."""
        scales = [
            condition.scale(self.values((condition.quantity,))[0]) for condition in self.conditions
        ]
        return np.array(scales)

    def charted(self, designs: FloatArray) -> FloatArray:
        """Return the points of designs, shape (n, parameters), in the chart of the file's space."""
        return self.atlas.mechanism.project(designs, self.atlas.settings.space)

    def uncharted(self, points: FloatArray) -> FloatArray:
        """Return the designs at points of the chart of the file's space, shape (n, 2)."""
        return self.atlas.mechanism.unproject(points, self.atlas.settings.space)

    def values(self, names: Sequence[str]) -> FloatArray:
        """Return stored values, shape (names, designs)."""
        rows = [self.atlas.select(name, self.mode, self.lci) for name in names]
        return np.array(rows, dtype=np.float64).reshape(len(rows), len(self.atlas))

    def errors(self, names: Sequence[str]) -> FloatArray:
        """Return stored error estimates, shape (names, designs).

        0 for parameters, NaN for what has no estimate.
        """
        parameters = [parameter.name for parameter in self.atlas.mechanism.parameters]
        rows = []
        for name in names:
            companion = f"{name}_error"
            if name in parameters:
                rows.append(np.zeros(len(self.atlas)))
            elif companion in self.atlas.names:
                rows.append(self.atlas.select(companion, self.mode, self.lci))
            else:
                rows.append(np.full(len(self.atlas), np.nan))
        return np.array(rows, dtype=np.float64).reshape(len(rows), len(self.atlas))

    def exact(self, names: Sequence[str] = ()) -> ExactValues:
        """Return exact values of the conditions' quantities and of others."""
        quantities = [condition.quantity for condition in self.conditions]
        return ExactValues.of_atlas(self.atlas, [*quantities, *names], self.mode, self.lci)

    def interpolation_error(self) -> float:
        """Return the largest relative error of interpolated bounds on the outline.

        NaN where a condition is on an error estimate, which has no exact value.
        """
        if not has_exact_values(self.atlas, [each.quantity for each in self.conditions]):
            return float("nan")
        if self.region.region.is_empty or not self.conditions:
            return 0.0
        return outline_error(
            self.region.region,
            self.conditions,
            self.triangles,
            self.points,
            self.margins,
            self.scales,
            self.exact(),
        )

    def refined(self) -> RefinedRegion:
        """Return the region between the true level sets; see :func:`refine`."""
        return refine(
            self.region.region,
            self.conditions,
            self.triangles,
            self.points,
            self.margins,
            self.scales,
            self.exact(),
        )

    def refined_extent(self, outline: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Return the range of every parameter under the conditions, by exact values.

        Parameters
        ----------
        outline
            The loops of a refined region.

        Returns
        -------
        least, greatest
            Shape (parameters,).
        """
        mechanism = self.atlas.mechanism
        corners = np.concatenate([np.empty((0, 2)), *outline])
        # Like the region, it ends where the lattice does.
        polygon = DesignPolygon.of_lattice(self.points, self.triangles)
        ends = np.full((2, len(mechanism.parameters)), np.nan)
        for column, parameter in enumerate(mechanism.parameters):
            exact = dataclasses.replace(self.exact([parameter.name]), polygon=polygon)
            along = self.uncharted(corners)[:, column]
            of_space = self.uncharted(polygon.corners)[:, column]
            for row, sign in enumerate((-1.0, 1.0)):
                furthest = int(np.argmax(sign * along))
                if sign * along[furthest] >= np.max(sign * of_space) - ON_SIDE:
                    ends[row, column] = along[furthest]
                    continue
                found = maximise(
                    exact,
                    Objective((parameter.name,), (sign,)),
                    self.conditions,
                    self.scales,
                    corners[[furthest]],
                    trials=False,
                )
                # A corner misses a bound by its residual, a design that was found by none.
                ends[row, column] = along[furthest] if found is None else sign * found.value
        return ends[0], ends[1]

    def starts(self, values: FloatArray) -> FloatArray:
        """Return where to look for the largest value, points of the chart, shape (n, 2).

        Designs that no neighbour surpasses, the best designs, and corners of the region
        where the interpolated value is largest.

        Parameters
        ----------
        values
            What is to be large, at every design of the lattice.
        """
        tops = local_maxima(values, self.fulfilled, self.triangles, _SUMMITS)
        usable = np.flatnonzero(self.fulfilled & np.isfinite(values))
        best = usable[np.argsort(-values[usable], kind="stable")][:_DESIGNS]
        parts = [self.points[tops], self.points[best]]
        region = self.region.region
        if len(region.corner_triangles):
            vertices = self.triangles[region.corner_triangles]
            interpolated = np.einsum("cv,cv->c", region.corner_weights, values[vertices])
            interpolated = np.where(np.isfinite(interpolated), interpolated, -np.inf)
            best = np.argsort(-interpolated, kind="stable")[:_CORNERS]
            places = np.einsum(
                "cv,cvx->cx", region.corner_weights[best], self.points[vertices[best]]
            )
            parts.append(places)
        return np.vstack(parts)

    def normalised(self, objective: Objective) -> Objective:
        """Return an objective normalised by the designs of the lattice that fulfil all.

        Where none does, by all designs.

        Raises
        ------
        NoDesignError
            If no design has a value of every quantity.
        """
        values = self.values(objective.names)
        exists = np.isfinite(values).all(axis=0)
        if not exists.any():
            names = " and ".join(objective.names)
            raise NoDesignError(f"no design of the file has a value of {names}")
        chosen = exists & self.fulfilled
        return objective.normalised(values[:, chosen if chosen.any() else exists])

    def best_designs(self, objective: Objective, count: int) -> IntArray:
        """Return the designs of the lattice with the largest objective, best first."""
        total = objective.value(self.values(objective.names))
        usable = np.flatnonzero(self.fulfilled & np.isfinite(total))
        return usable[np.argsort(-total[usable], kind="stable")][:count]

    def maximise(
        self, objective: Objective, *, near: Sequence[FloatArray] = (), trials: bool = True
    ) -> Optimum | None:
        """Return the best design under the conditions by exact values; see :func:`maximise`.

        Parameters
        ----------
        objective
            What is to be large, normalised if it is a sum.
        near
            Further designs to start from.
        trials
            Whether to search around the best point by trial at the end.
        """
        total = objective.value(self.values(objective.names))
        finite = total[np.isfinite(total)]
        span = float(np.ptp(finite)) if len(finite) else 0.0
        starts = [self.starts(total), *map(self.charted, near)]
        return maximise(
            self.exact(objective.names),
            objective,
            self.conditions,
            self.scales,
            np.vstack(starts),
            span or 1.0,
            spacing=self.spacing,
            trials=trials,
        )
