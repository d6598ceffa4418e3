"""Everything ``atlas optimum`` finds out about a result file, and how it is written down."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.quantities import MODE, THRESHOLD
from fivebar_atlas.store import Atlas
from fivebar_atlas.synthesis.candidates import Candidates
from fivebar_atlas.synthesis.conditions import Condition
from fivebar_atlas.synthesis.design_polygon import DesignPolygon
from fivebar_atlas.synthesis.empty_region import Conflict, explain_emptiness
from fivebar_atlas.synthesis.maximise import Optimum
from fivebar_atlas.synthesis.objectives import Objective
from fivebar_atlas.synthesis.pareto import Directions, ParetoFront, pareto_front, polished_front
from fivebar_atlas.synthesis.refined_region import RefinedRegion

FloatArray = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True)
class OptimumStudy:
    """The region of conditions in a result file, and what was looked for in it.

    Attributes
    ----------
    candidates
        The designs and the conditions.
    best
        How many of the best designs of the lattice are listed for each purpose.
    interpolation_error
        Largest relative error of the region's interpolated bounds, NaN where unknown.
    refined, refined_least, refined_greatest
        The region between true level sets and the range of every parameter in it; None
        where not asked for or empty.
    objective, maximum
        What was maximised, normalised, and the best design; None where not asked for
        or not found.
    front, is_polished
        The Pareto front, and whether it consists of exact values.
    conflict
        Why the region is empty; None where it is not.
    """

    candidates: Candidates
    best: int
    interpolation_error: float
    refined: RefinedRegion | None
    refined_least: FloatArray | None
    refined_greatest: FloatArray | None
    objective: Objective | None
    maximum: Optimum | None
    front: ParetoFront | None
    is_polished: bool
    conflict: Conflict | None

    @property
    def atlas(self) -> Atlas:
        """The result file."""
        return self.candidates.atlas

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(parameter.name for parameter in self.atlas.mechanism.parameters)

    @property
    def shown(self) -> tuple[str, ...]:
        """Quantities in conditions, objective and front, parameters left out."""
        names = [condition.quantity for condition in self.candidates.conditions]
        names += self.objective.names if self.objective else ()
        names += self.front.names if self.front else ()
        return tuple(name for name in dict.fromkeys(names) if name not in self.parameters)

    def table(self) -> list[list[Any]]:
        """Return a header and one row for each member of the front.

        Where no front was asked for, for each design of the lattice that fulfils all
        conditions.
        """
        if self.front is not None:
            names, designs = self.front.names, self.front.designs
            values, errors = self.front.values, self.front.errors
        else:
            chosen = self.candidates.fulfilled
            names, designs = self.shown, self.atlas.designs[chosen]
            values = self.candidates.values(names)[:, chosen]
            errors = self.candidates.errors(names)[:, chosen]
        listed = [place for place, name in enumerate(names) if name not in self.parameters]
        with_error = [place for place in listed if f"{names[place]}_error" in self.atlas.names]
        header = [*self.parameters]
        columns = [*designs.T]
        for place in listed:
            header.append(names[place])
            columns.append(values[place])
            if place in with_error:
                header.append(f"{names[place]}_error")
                columns.append(errors[place])
        rows = np.array(columns).reshape(len(columns), -1).T.tolist()
        return [header, *([repr(value) for value in row] for row in rows)]

    def document(self) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON."""
        candidates = self.candidates
        return {
            "mechanism": self.atlas.mechanism.name,
            "space": self.atlas.settings.space,
            **self._selection(),
            "conditions": [str(condition) for condition in candidates.conditions],
            "designs": len(self.atlas),
            "lattice_designs": candidates.region.lattice_designs,
            "region": self._region(),
            "refined": self._refined(),
            "best": self._best(),
            "maximum": self._maximum(),
            "pareto": self._front(),
            "conflict": self._conflict(),
        }

    def _selection(self) -> dict[str, Any]:
        """Return the mode pair and the threshold of what depends on them."""
        atlas, candidates = self.atlas, self.candidates
        used: set[str] = set()
        for array in atlas.mechanism.stored_arrays(atlas.settings):
            if array.name in self.shown:
                used.update(array.quantity.dimensions)
        mode = atlas.modes[atlas.mode_index(candidates.mode)] if MODE in used else None
        threshold = None
        if THRESHOLD in used:
            threshold = atlas.lci_thresholds[atlas.lci_index(candidates.lci)]
        return {"mode": mode, "lci_threshold": threshold}

    def _extent(self, least: FloatArray, greatest: FloatArray) -> dict[str, list[float | None]]:
        pairs = zip(self.parameters, least, greatest, strict=True)
        return {name: [_plain(low), _plain(high)] for name, low, high in pairs}

    def _outline(self, loops: Sequence[FloatArray]) -> list[list[list[float]]]:
        mechanism, space = self.atlas.mechanism, self.atlas.settings.space
        outlines: list[list[list[float]]] = [
            mechanism.unproject(loop, space).tolist() for loop in loops
        ]
        return outlines

    def _region(self) -> dict[str, Any]:
        found = self.candidates.region
        return {
            "is_empty": found.region.is_empty,
            "share": found.share,
            "extent": self._extent(found.least, found.greatest),
            "interpolation_error": _plain(self.interpolation_error),
            "outline": self._outline(found.region.loops),
        }

    def _refined(self) -> dict[str, Any] | None:
        if self.refined is None or self.refined_least is None or self.refined_greatest is None:
            return None
        whole = DesignPolygon.of_space(self.atlas.mechanism, self.atlas.settings.space).area
        return {
            "share": self.refined.area / whole,
            "share_error": self.refined.area_error / whole,
            "residual": self.refined.residual,
            "unmoved": self.refined.unmoved,
            "extent": self._extent(self.refined_least, self.refined_greatest),
            "outline": self._outline(self.refined.loops),
        }

    def _row(self, design: FloatArray, values: FloatArray, errors: FloatArray) -> dict[str, Any]:
        return {
            "design": dict(zip(self.parameters, map(float, design), strict=True)),
            "values": dict(zip(self.shown, map(_plain, values), strict=True)),
            "errors": dict(zip(self.shown, map(_plain, errors), strict=True)),
        }

    def _best(self) -> list[dict[str, Any]]:
        """Return the best designs of the lattice, by the objective or by each condition."""
        purposes: list[Objective] = []
        if self.objective is not None:
            purposes = [self.objective]
        else:
            for condition in self.candidates.conditions:
                if condition.quantity not in self.parameters:
                    sign = 1.0 if condition.operator[0] == ">" else -1.0
                    purposes.append(Objective((condition.quantity,), (sign,)))
        if not purposes or not self.best or not self.shown:
            return []
        values, errors = self.candidates.values(self.shown), self.candidates.errors(self.shown)
        return [
            {
                "for": str(purpose),
                **self._row(self.atlas.designs[place], values[:, place], errors[:, place]),
            }
            for purpose in dict.fromkeys(purposes)
            for place in self.candidates.best_designs(purpose, self.best)
        ]

    def _maximum(self) -> dict[str, Any] | None:
        objective, found = self.objective, self.maximum
        if objective is None:
            return None
        ranges = {}
        if objective.is_sum:
            spans = zip(objective.least, objective.greatest, strict=True)
            ranges = dict(zip(objective.names, map(list, spans), strict=True))
        document: dict[str, Any] = {
            "objective": str(objective),
            "normalised_by": ranges,
            "design": None,
        }
        if found is None:
            return document
        exact = self.candidates.exact(self.shown)
        design = exact.designs(found.point[np.newaxis])
        values, errors = exact.values_and_errors(design)
        rows = [exact.names.index(name) for name in self.shown]
        lattice = self.candidates.best_designs(objective, 1)
        at_lattice = None
        if len(lattice):
            stored = self.candidates.values(objective.names)[:, lattice[0]]
            at_lattice = float(objective.value(stored))
        return {
            **document,
            **self._row(design[0], values[rows, 0], errors[rows, 0]),
            "value": found.value,
            "lattice_value": at_lattice,
            "active": [str(condition) for condition in found.active],
            "borders": list(found.borders),
            "is_attained": found.is_attained,
        }

    def _front(self) -> dict[str, Any] | None:
        front = self.front
        if front is None:
            return None
        ways = {1.0: "large", -1.0: "small"}
        listed = [place for place, name in enumerate(front.names) if name not in self.parameters]
        names = [front.names[place] for place in listed]
        return {
            "directions": {
                name: ways[sign] for name, sign in zip(front.names, front.signs, strict=True)
            },
            "polished": self.is_polished,
            "candidates": front.candidates,
            "members": [
                {
                    "design": dict(zip(self.parameters, map(float, design), strict=True)),
                    "values": dict(
                        zip(names, map(_plain, front.values[listed, place]), strict=True)
                    ),
                    "errors": dict(
                        zip(names, map(_plain, front.errors[listed, place]), strict=True)
                    ),
                }
                for place, design in enumerate(front.designs)
            ],
        }

    def _conflict(self) -> dict[str, Any] | None:
        if self.conflict is None:
            return None

        def place(design: FloatArray | None) -> dict[str, float] | None:
            if design is None:
                return None
            return dict(zip(self.parameters, map(float, design), strict=True))

        return {
            "conditions": [str(condition) for condition in self.conflict.conditions],
            "is_met": self.conflict.is_met,
            "reaches": [
                {
                    "condition": str(reach.condition),
                    "alone": reach.alone,
                    "alone_design": place(reach.alone_design),
                    "alone_is_attained": reach.alone_is_attained,
                    "among": reach.among,
                    "among_design": place(reach.among_design),
                    "among_is_attained": reach.among_is_attained,
                }
                for reach in self.conflict.reaches
            ],
        }


def study_optimum(
    atlas: Atlas,
    conditions: Sequence[Condition],
    mode: str | None = None,
    lci: float | None = None,
    *,
    refine: bool = False,
    objective: Objective | None = None,
    directions: Directions = (),
    polish: bool = False,
    best: int = 3,
) -> OptimumStudy:
    """Find the region of conditions and what is asked for in it.

    Parameters
    ----------
    atlas
        The open result file.
    conditions
        The conditions; none means all designs.
    mode, lci
        Mode pair and LCI threshold of the quantities that depend on them; needed only
        where the file holds several.
    refine
        Whether to move the outline onto the true level sets.
    objective
        What to maximise.
    directions
        The quantities of a Pareto front.
    polish
        Whether to move the front onto the true front.
    best
        How many of the best designs of the lattice to list.

    Raises
    ------
    UnknownNameError
        If there is no such quantity or mode pair.
    InputError
        If a mode pair or threshold is not in the file or must be chosen, or exact values
        of an error estimate would be needed.
    FileError
        If the file is damaged.
    """
    candidates = Candidates(atlas, conditions, mode, lci)
    if refine or objective is not None:
        # Says at once where there are no exact values.
        candidates.exact(objective.names if objective is not None else ())
    conflict = explain_emptiness(candidates) if candidates.is_empty else None
    refined, least, greatest = None, None, None
    if refine and not candidates.region.region.is_empty:
        refined = candidates.refined()
        least, greatest = candidates.refined_extent(refined.loops)
    maximum = None
    if objective is not None:
        objective = candidates.normalised(objective)
        met = [] if conflict is None else conflict.met_designs
        if conflict is None or met:
            maximum = candidates.maximise(objective, near=met)
    front = pareto_front(candidates, directions) if directions else None
    if front is not None and polish:
        front = polished_front(candidates, front)
    if refined is not None:
        error = refined.interpolation_error
    else:
        error = candidates.interpolation_error()
    return OptimumStudy(
        candidates=candidates,
        best=best,
        interpolation_error=error,
        refined=refined,
        refined_least=least,
        refined_greatest=greatest,
        objective=objective,
        maximum=maximum,
        front=front,
        is_polished=front is not None and polish,
        conflict=conflict,
    )


def _plain(value: float) -> float | None:
    return float(value) + 0.0 if np.isfinite(value) else None
