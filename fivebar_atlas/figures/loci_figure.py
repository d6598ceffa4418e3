"""Singular loci of one design, all of them or those of one mode."""

from __future__ import annotations

from matplotlib.figure import Figure

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
        If the width is out of range.
    """
    arcs = design.singular_loci(mode)
    marks = marked_points(arcs, design.isolated_singular_points())
    bounds = bounds_of_arcs(arcs or design.singular_loci())
    rows = [[entry] for entry in kind_entries(arcs)]
    if mode is not None and not arcs:
        rows.append([KeyEntry(f"no singular loci in {mode_text(mode)}", {})])
    rows.append([*(each.entry for each in marks), KeyEntry(", ".join(design.remarks()), {})])
    with styled():
        title = title_text("Singular loci", design, mode)
        frame = plane_frame(bounds, design.unit, title, width, key_rows_height(rows, width))
        draw_origin(frame)
        draw_arcs(frame, arcs, "locus", data)
        for each in marks:
            each.draw(frame, data)
        label_curves(frame, arcs)
        draw_key_rows(frame, rows)
        return frame.figure
