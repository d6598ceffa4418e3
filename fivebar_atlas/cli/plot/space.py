"""Figures of one design whose platform moves in space: a pose, and its workspace."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.plot.group import check_outputs
from fivebar_atlas.errors import InputError

if TYPE_CHECKING:
    from fivebar_atlas.figures.oblique_view import ObliqueView
    from fivebar_atlas.mechanisms.spatial import SpatialDesign

#: Options of figures in space; those of the same name in the plane come first.
view_option = click.option(
    "--view",
    nargs=2,
    type=float,
    metavar="AZIMUTH ELEVATION",
    help="In space: from where it is seen, in degrees; azimuth from the X axis.",
)
pose_option = click.option(
    "--pose",
    nargs=6,
    type=float,
    metavar="X Y Z ALPHA BETA GAMMA",
    help="In space: the pose, angles in degrees; home if not given.",
)
solve_option = click.option(
    "--solve",
    metavar="NAME",
    help="In space: coordinate that is solved for, so that the joints allow the pose.",
)
section_option = click.option(
    "--section",
    "sections",
    multiple=True,
    metavar="AXIS=VALUE",
    help="In space: section to draw, such as z=1.1; repeatable for one axis.",
)
surface_option = click.option(
    "--surface", is_flag=True, help="In space: draw the surface instead of sections."
)
orientation_option = click.option(
    "--orientation",
    nargs=2,
    type=float,
    metavar="BETA GAMMA",
    help="In space: the two angles that are fixed, in degrees; 0 0 if not given.",
)

# Sections that are drawn if none is named, as shares of the height at home.
_SECTIONS = (0.85, 1.0, 1.15)
_NO_WORKSPACE = "an orientation at which there is a workspace"


def is_spatial(mechanism: str | None) -> bool:
    """Return whether the platform of a mechanism, the first if none is named, moves in space."""
    from fivebar_atlas import mechanisms

    return mechanisms.get(mechanism or mechanisms.names()[0]).is_spatial


def refuse(given: Mapping[str, Any], where: str) -> None:
    """Raise UsageError if an option was given that is for other mechanisms."""
    for option, value in given.items():
        if value not in (None, (), False):
            raise click.UsageError(f"{option} is for mechanisms that move in {where}")


def draw_pose(
    pose: tuple[float, ...] | None,
    solve: str | None,
    view: tuple[float, float] | None,
    **choices: Any,
) -> None:
    """Draw a mechanism in a pose."""
    from fivebar_atlas.figures.spatial_linkage_figure import spatial_linkage_figure

    if solve is not None and pose is None:
        raise click.UsageError("--solve completes a --pose")

    def make(design: SpatialDesign, **drawing: Any) -> Any:
        coordinates = design.home if pose is None else _coordinates(design, pose)
        typed = None if pose is None else " ".join(f"{value:g}" for value in pose)
        with options.as_typed({"pose": ("--pose", typed), "coordinate": ("--solve", solve)}):
            if solve is not None:
                coordinates = design.solved(coordinates, solve)
            found = design.pose(coordinates)
        return spatial_linkage_figure(design, found, view=_view(view), **drawing)

    _draw(make, **choices)


def draw_workspace(
    sections: tuple[str, ...],
    surface: bool,
    orientation: tuple[float, float] | None,
    view: tuple[float, float] | None,
    **choices: Any,
) -> None:
    """Draw sections of a workspace, or its surface."""
    from fivebar_atlas.figures.spatial_workspace_figure import section_figure, surface_figure
    from fivebar_atlas.spatial_workspace import section_of, surface_of

    if surface and sections:
        raise click.UsageError("--surface and --section exclude each other")
    if view is not None and not surface:
        raise click.UsageError("--view is for --surface")
    angles = (0.0, 0.0) if orientation is None else orientation
    if not all(math.isfinite(angle) and abs(angle) <= 180.0 for angle in angles):
        raise InputError("--orientation", orientation, "two angles from -180 to 180 degrees")
    turned = (math.radians(angles[0]), math.radians(angles[1]))

    def make(design: SpatialDesign, **drawing: Any) -> Any:
        if surface:
            found = surface_of(design, turned)
            if found is None:
                raise InputError("--orientation", angles, _NO_WORKSPACE)
            return surface_figure(design, found, turned, view=_view(view), **drawing)
        chosen = [_section(text) for text in sections]
        if not chosen:
            chosen = [(2, share * design.home[2]) for share in _SECTIONS]
        if len({axis for axis, _ in chosen}) > 1:
            raise InputError("--section", ", ".join(sections), "sections across one axis only")
        parts = [section_of(design, axis, value, turned) for axis, value in chosen]
        if not sections and not any(part.outlines for part in parts):
            raise InputError("--orientation", angles, _NO_WORKSPACE)
        return section_figure(design, parts, turned, **drawing)

    _draw(make, **choices)


def _coordinates(design: SpatialDesign, pose: tuple[float, ...]) -> tuple[float, ...]:
    """Return a pose as it was typed with its angles in radians."""
    return tuple(
        math.radians(value) if coordinate.is_angle else value
        for coordinate, value in zip(design.coordinates, pose, strict=True)
    )


def _section(text: str) -> tuple[int, float]:
    """Return axis and value of a section."""
    from fivebar_atlas.spatial_workspace import AXES

    axis, _, value = (part.strip() for part in text.partition("="))
    try:
        place = float(value)
    except ValueError:
        place = math.nan
    if axis.lower() not in AXES or not math.isfinite(place):
        raise InputError("--section", text, "x, y or z and a value, such as z=1.1")
    return AXES.index(axis.lower()), place


def _view(view: tuple[float, float] | None) -> ObliqueView | None:
    """Return from where it is seen."""
    from fivebar_atlas.figures.oblique_view import ObliqueView

    if view is None:
        return None
    azimuth, elevation = view
    shown = f"{azimuth:g} {elevation:g}"
    with options.as_typed({"azimuth": ("--view", shown), "elevation": ("--view", shown)}):
        return ObliqueView(elevation, azimuth)


def _draw(
    make: Any,
    output: Path,
    data: Path | None,
    width: float,
    overwrite: bool,
    lengths: list[float],
    mechanism: str | None,
    unit: str | None,
    non_dimensional: bool,
    set_options: Mapping[str, object],
) -> None:
    """Draw and save one figure and the points in it."""
    from fivebar_atlas import mechanisms
    from fivebar_atlas.figures.drawing_area import check_width
    from fivebar_atlas.figures.plotted_data import PlottedData, save_outputs

    check_outputs(output, data, overwrite)
    check_width(width)
    if non_dimensional and unit:
        raise click.UsageError("--unit and --non-dimensional exclude each other")
    options.check_unit(unit)
    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    design = chosen.spatial_design(
        lengths, "" if non_dimensional else unit, options.options_of(chosen, set_options)
    )
    plotted = PlottedData(dimensions=3)
    figure = make(design, width=width, data=plotted)
    save_outputs(figure, output, plotted, data, design.unit, overwrite)
