"""The figures of one design that a report shows, with their captions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fivebar_atlas.cli.presentation import Captioned

if TYPE_CHECKING:
    from fivebar_atlas.figures.overlays import Overlay
    from fivebar_atlas.mechanisms.planar import PlanarDesign
    from fivebar_atlas.planar_geometry import Point


def workspace(design: PlanarDesign, mode: str, overlays: Sequence[Overlay] = ()) -> Captioned:
    """Return the figure of the usable workspace of a mode pair, empty or not.

    Parameters
    ----------
    design
        The design.
    mode
        The mode pair.
    overlays
        What is drawn into it.
    """

    def draw() -> Any:
        from fivebar_atlas.figures.workspace_figure import workspace_figure

        return workspace_figure(design, mode, overlays=overlays)

    if design.usable_workspace(mode) is None:
        return Captioned(f"The usable workspace of {mode} is empty; these are its loci.", draw)
    text = f"Usable workspace of {mode}, the singularities that bound it, and the linkage in it"
    return Captioned(_caption(text, design, overlays), draw)


def lci_map(
    design: PlanarDesign,
    mode: str,
    lci_threshold: float | None = None,
    overlays: Sequence[Overlay] = (),
) -> Captioned:
    """Return the figure of the LCI over the usable or the good-condition workspace.

    Parameters
    ----------
    design
        The design.
    mode
        The mode pair.
    lci_threshold
        Threshold of the good-condition workspace; None for the usable workspace.
    overlays
        What is drawn into it.
    """

    def draw() -> Any:
        from fivebar_atlas.figures.lci_figure import lci_figure

        return lci_figure(design, mode, lci_threshold, overlays=overlays)

    text = f"Local conditioning index (LCI) over the usable workspace of {mode}"
    if lci_threshold is not None:
        text = f"Where the local conditioning index (LCI) of {mode} is at least {lci_threshold:g}"
    return Captioned(_caption(text, design, overlays), draw)


def linkage(design: PlanarDesign, mode: str, at: Point | None = None) -> Captioned:
    """Return the figure of the linkage in a pose.

    Parameters
    ----------
    design
        The design.
    mode
        The mode pair, with a usable workspace.
    at
        Where the output point is; None for a place well inside the usable workspace.
    """

    def draw() -> Any:
        from fivebar_atlas.figures.linkage import sample_pose
        from fivebar_atlas.figures.linkage_figure import linkage_figure

        if at is not None:
            return linkage_figure(design, [design.pose(*at, mode)])
        found = design.usable_workspace(mode)
        assert found is not None
        return linkage_figure(design, [sample_pose(design, found.region, mode)])

    return Captioned(_caption(f"The linkage in {mode} in one of its positions", design), draw)


def _caption(text: str, design: PlanarDesign, overlays: Sequence[Overlay] = ()) -> str:
    """Return a caption that says what is drawn into the figure, and the unit."""
    within = " and the ".join(overlay.label for overlay in overlays)
    within = f", with the {within}" if within else ""
    return f"{text}{within}." + (f" Lengths are in {design.unit}." if design.unit else "")
