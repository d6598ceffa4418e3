"""The figures of an optimum: the region of conditions, and a Pareto front."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fivebar_atlas.store import Atlas
    from fivebar_atlas.synthesis.candidates import Candidates
    from fivebar_atlas.synthesis.conditions import Condition
    from fivebar_atlas.synthesis.pareto import ParetoFront
    from fivebar_atlas.triangulated_regions import Region


def draw_region(
    atlas: Atlas,
    region: Region,
    conditions: Sequence[Condition],
    mode: str | None,
    lci: float | None,
    **drawing: Any,
) -> Any:
    """Return the region of conditions over two quantities; ``drawing`` may have a width."""
    from fivebar_atlas.figures.atlas_figures import region_figure

    return region_figure(atlas, region, _bounds(conditions), mode, lci, **drawing)


def draw_front(
    candidates: Candidates, front: ParetoFront, in_design_space: bool, **drawing: Any
) -> Any:
    """Return the front of two quantities over their values, or in the design space."""
    from fivebar_atlas.figures.atlas_figures import front_figure

    atlas = candidates.atlas
    first, second = front.names
    # From left to right.
    order = front.values[0].argsort(kind="stable")
    members = front.values
    if in_design_space:
        members = atlas.mechanism.project(front.designs, atlas.settings.space).T
    return front_figure(
        atlas,
        (first, second),
        candidates.fulfilled,
        members[:, order],
        _bounds(candidates.conditions),
        candidates.region.region if candidates.conditions else None,
        candidates.mode,
        candidates.lci,
        in_design_space=in_design_space,
        **drawing,
    )


def _bounds(conditions: Sequence[Condition]) -> list[tuple[str, str, float]]:
    return [(each.quantity, each.operator, each.bound) for each in conditions]
