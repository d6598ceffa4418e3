"""Singular loci of one design, all of them or those of one mode."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.colour_bar import KeyEntry, draw_key_rows, key_rows_height
from fivebar_atlas.figures.curves import (
    draw_arcs,
    kind_entries,
    label_curves,
    marked_points,
)
from fivebar_atlas.figures.plane_frame import bounds_of_arcs, draw_origin, plane_frame
from fivebar_atlas.figures.plotted_data import PlottedData
from fivebar_atlas.figures.style import styled
from fivebar_atlas.figures.wording import mode_text, title_text
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.planar_geometry import NamedArc


def loci_figure(
    design: PlanarDesign,
    mode: str | None = None,
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the singular loci of a design.

    Parameters
    ----------
    design
        The design.
    mode
        A mode pair or a working mode alone, for its loci only; None for all.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; after Liu, Wang and Zheng 2006, Fig. 3, and with a mode one cell of
        Fig. 5. Curves have the look of their kind and their symbol on them; points where
        they touch or cross are marked. What is special about the design stands below.

    Raises
    ------
    UnknownNameError
        If there is no such mode.
    InputError
        If the width is out of range, or the linkage cannot move at all.
    """
    arcs = design.singular_loci(mode)
    notes = [] if arcs or mode is None else [f"no arcs of singular loci in {mode_text(mode)}"]
    return _drawn(design, arcs, title_text("Singular loci", design, mode), notes, width, data)


def empty_workspace_figure(
    design: PlanarDesign,
    mode: str,
    subject: str,
    *,
    width: float = style.COLUMN_WIDTH,
    data: PlottedData | None = None,
) -> Figure:
    """Draw the singular loci in place of a usable workspace that is empty, and say so.

    Parameters
    ----------
    design, mode
        The design and the mode pair.
    subject
        What was to be drawn, for the title.
    width
        Width of the figure in millimetres.
    data
        Takes what is plotted.

    Returns
    -------
    matplotlib.figure.Figure
        The figure: the loci of the mode pair, or all there are if it has none.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    InputError
        If the width is out of range, or the linkage cannot move at all.
    """
    arcs = design.singular_loci(mode)
    whose = "its" if arcs else "all"
    notes = [f"empty usable workspace in {mode_text(mode)}; {whose} singular loci are drawn"]
    shown = arcs or design.singular_loci()
    return _drawn(design, shown, title_text(subject, design, mode), notes, width, data)


def _drawn(
    design: PlanarDesign,
    arcs: Sequence[NamedArc],
    title: str,
    notes: Sequence[str],
    width: float,
    data: PlottedData | None,
) -> Figure:
    """Draw loci with their marks, their key, and notes above the key."""
    everything = arcs or design.singular_loci()
    if not everything:
        lengths = tuple(length for _, length in design.parameters)
        raise InputError("design", lengths, "lengths with which the linkage can move")
    marks = marked_points(arcs, design.isolated_singular_points())
    rows = [[KeyEntry(note, {})] for note in notes]
    rows += [[entry] for entry in kind_entries(arcs)]
    rows.append([*(each.entry for each in marks), KeyEntry(", ".join(design.remarks()), {})])
    with styled():
        bounds = bounds_of_arcs(everything)
        frame = plane_frame(bounds, design.unit, title, width, key_rows_height(rows, width))
        draw_origin(frame)
        draw_arcs(frame, arcs, "locus", data)
        for each in marks:
            each.draw(frame, data)
        label_curves(frame, arcs)
        draw_key_rows(frame, rows)
        return frame.figure
