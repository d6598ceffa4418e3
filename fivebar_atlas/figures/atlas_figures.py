"""Figures of a result file: which kind of map each stored quantity is drawn as.

These functions take an open result file; the maps themselves take arrays.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from fivebar_atlas.errors import InputError
from fivebar_atlas.figures import style
from fivebar_atlas.figures.category_map import category_map, magnitude_map
from fivebar_atlas.figures.charted_designs import ChartedDesigns
from fivebar_atlas.figures.contour_map import contour_map
from fivebar_atlas.figures.oblique_view import ObliqueView
from fivebar_atlas.figures.pareto_figure import pareto_designs_figure, pareto_figure
from fivebar_atlas.figures.region_map import Layer, region_map
from fivebar_atlas.figures.surface_map import DEFAULT_AZIMUTH, DEFAULT_ELEVATION, surface_map
from fivebar_atlas.mechanisms.quantities import MODE, THRESHOLD, Flags, Quantity, ResultArray
from fivebar_atlas.store import Atlas
from fivebar_atlas.triangulated_regions import Region

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

#: The quantity that explains every value that is not a number.
STATUS = "status"

# How the meaning of a status begins that says there is no workspace.
_EMPTY = "empty"
_MINUS = "\N{MINUS SIGN}"
_SIGNS = {
    ">=": "\N{GREATER-THAN OR EQUAL TO}",
    "<=": "\N{LESS-THAN OR EQUAL TO}",
    ">": ">",
    "<": "<",
}
_UNITS = {0: "dimensionless", 1: "in units of $D$", 2: "in units of $D^2$"}


def quantity_figure(
    atlas: Atlas,
    name: str,
    mode: str | None = None,
    lci: float | None = None,
    *,
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw one stored quantity over the design space.

    Parameters
    ----------
    atlas
        The open result file.
    name
        Name of a quantity or of an error companion.
    mode
        A stored mode pair; needed only where the file holds several.
    lci
        A stored LCI threshold; needed only where the file holds several.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        Contours of a quantity, orders of magnitude of an error, colours of a category.

    Raises
    ------
    UnknownNameError
        If there is no such quantity or mode pair.
    InputError
        If the mode pair or the threshold is not stored or must be chosen, or the width is
        out of range.
    FileError
        If the file is damaged.
    """
    array = stored_array(atlas, name)
    quantity = array.quantity
    values = atlas.select(name, mode, lci)
    designs = charted_designs(atlas)
    title = title_of(atlas, array, mode, lci)
    if quantity.flags is not None:
        return category_map(designs, values.astype(np.int64), quantity.flags, title, width=width)
    values = np.where(without_workspace(atlas, quantity, mode), np.nan, values)
    draw = magnitude_map if array.is_error else contour_map
    missing = why_missing(atlas, quantity, values, mode, lci)
    return draw(designs, values, title, label_of(array), missing=missing, width=width)


def surface_figure(
    atlas: Atlas,
    name: str,
    mode: str | None = None,
    lci: float | None = None,
    *,
    elevation: float = DEFAULT_ELEVATION,
    azimuth: float = DEFAULT_AZIMUTH,
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw one stored quantity as a surface above the design space, contours on its floor.

    Parameters
    ----------
    atlas, name, mode, lci, width
        As in :func:`quantity_figure`; the quantity is no category.
    elevation, azimuth
        From where it is seen, in degrees, as in :class:`ObliqueView`.

    Returns
    -------
    matplotlib.figure.Figure
        Heights of a quantity, orders of magnitude of an error.

    Raises
    ------
    UnknownNameError
        If there is no such quantity or mode pair.
    InputError
        If the quantity is a category, the mode pair or the threshold is not stored or must be
        chosen, or an angle or the width is out of range.
    FileError
        If the file is damaged.
    """
    view = ObliqueView(elevation, azimuth)
    array = stored_array(atlas, name)
    quantity = array.quantity
    if quantity.flags is not None:
        raise InputError("quantity", name, "a quantity of numbers; a category has no height")
    values = atlas.select(name, mode, lci)
    values = np.where(without_workspace(atlas, quantity, mode), np.nan, values)
    missing = why_missing(atlas, quantity, values, mode, lci)
    return surface_map(
        charted_designs(atlas),
        values,
        title_of(atlas, array, mode, lci),
        label_of(array),
        quantity.symbol,
        view=view,
        magnitudes=array.is_error,
        missing=missing,
        width=width,
    )


def region_figure(
    atlas: Atlas,
    region: Region,
    conditions: Sequence[tuple[str, str, float]],
    mode: str | None = None,
    lci: float | None = None,
    *,
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw an optimum region over two quantities: how large workspaces are, and how good.

    Parameters
    ----------
    atlas
        The open result file.
    region
        The region, in chart coordinates.
    conditions
        What bounds it: name of a quantity or parameter, operator, number.
    mode, lci
        Mode pair and LCI threshold, as in :func:`quantity_figure`.
    width
        Width of the figure in millimetres.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; an empty region is said to be empty.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair, or the mechanism has no such quantities.
    InputError
        If the mode pair is not stored or must be chosen, or the width is out of range.
    FileError
        If the file is damaged.
    """
    layers = []
    reasons = []
    for name in atlas.mechanism.region_quantities:
        array = stored_array(atlas, name)
        values = atlas.select(name, mode, lci)
        values = np.where(without_workspace(atlas, array.quantity, mode), np.nan, values)
        layers.append(Layer(values, label_of(array)))
        reasons.append(why_missing(atlas, array.quantity, values, mode, lci))
    parameters = [parameter.name for parameter in atlas.mechanism.parameters]
    bounded = [stored_array(atlas, name) for name, _, _ in conditions if name not in parameters]
    parts = ["Optimum region", *([_mode_part(atlas, mode)] if atlas.mechanism.has_modes else [])]
    if any(THRESHOLD in array.quantity.dimensions for array in bounded):
        parts.append(_threshold_part(atlas, lci))
    parts += _option_parts(atlas)
    return region_map(
        charted_designs(atlas),
        layers[0],
        layers[1],
        region,
        [condition_text(atlas, *condition) for condition in conditions],
        ", ".join(parts),
        missing=reasons[0],
        width=width,
    )


def front_figure(
    atlas: Atlas,
    names: tuple[str, str],
    fulfilled: BoolArray,
    front: FloatArray,
    conditions: Sequence[tuple[str, str, float]],
    region: Region | None,
    mode: str | None = None,
    lci: float | None = None,
    *,
    in_design_space: bool = False,
    width: float = style.COLUMN_WIDTH,
) -> Figure:
    """Draw the Pareto front of two quantities, over their values or in the design space.

    Parameters
    ----------
    atlas
        The open result file.
    names
        The two quantities or parameters.
    fulfilled
        Which designs fulfil the conditions, shape (designs,).
    front
        The members, the first quantity rising, shape (2, members): both quantities, or in
        the design space their chart coordinates.
    conditions
        The conditions: name, operator, number.
    region
        Where they hold, in chart coordinates; None without conditions.
    mode, lci
        Mode pair and LCI threshold, as in :func:`quantity_figure`.
    in_design_space
        Whether to draw the design space.
    width
        Width of the figure in millimetres.

    Raises
    ------
    UnknownNameError
        If there is no such quantity or mode pair.
    InputError
        If the mode pair or the threshold is not stored or must be chosen, or the width is
        out of range.
    FileError
        If the file is damaged.
    """
    texts = [condition_text(atlas, *condition) for condition in conditions]
    parts = ["Pareto front", *_chosen_parts(atlas, names, mode, lci), *_option_parts(atlas)]
    title = ", ".join(parts)
    if in_design_space:
        first, second = (_symbol(atlas, name) for name in names)
        return pareto_designs_figure(
            charted_designs(atlas), region, front.T, (first, second), texts, title, width=width
        )
    values = np.array([atlas.select(name, mode, lci) for name in names])
    labels = (_label(atlas, names[0]), _label(atlas, names[1]))
    fixed = charted_designs(atlas).chart.fixed
    whole = ", ".join([title, fixed] if fixed else [title])
    return pareto_figure(values, fulfilled, front, labels, texts, whole, width=width)


def _chosen_parts(
    atlas: Atlas, names: Sequence[str], mode: str | None, lci: float | None
) -> list[str]:
    """Return mode pair and threshold as a title gives them, as far as quantities need them."""
    arrays = {array.name: array for array in atlas.mechanism.stored_arrays(atlas.settings)}
    used = {axis for name in names if name in arrays for axis in arrays[name].quantity.dimensions}
    parts = [_mode_part(atlas, mode)] if MODE in used else []
    return [*parts, _threshold_part(atlas, lci)] if THRESHOLD in used else parts


def _label(atlas: Atlas, name: str) -> str:
    """Return name, symbol and unit of a parameter or quantity."""
    for parameter in atlas.mechanism.parameters:
        if parameter.name == name:
            unit = "" if parameter.unit == "1" else f" ({parameter.unit})"
            return f"{parameter.long_name} {parameter.symbol}{unit}"
    return label_of(stored_array(atlas, name))


def _symbol(atlas: Atlas, name: str) -> str:
    for parameter in atlas.mechanism.parameters:
        if parameter.name == name:
            return parameter.symbol
    return stored_array(atlas, name).quantity.symbol


def charted_designs(atlas: Atlas) -> ChartedDesigns:
    """Return the designs of a result file with their triangulation and chart."""
    settings = atlas.settings
    return ChartedDesigns.of_lattice(atlas.mechanism, settings.space, settings.resolution)


def stored_array(atlas: Atlas, name: str) -> ResultArray:
    """Return what is known of a quantity or error companion.

    Raises
    ------
    UnknownNameError
        If the file holds nothing of this name; it lists what it holds.
    """
    arrays = {array.name: array for array in atlas.mechanism.stored_arrays(atlas.settings)}
    if name not in arrays:
        raise atlas.unknown("quantity", name, arrays)
    return arrays[name]


def title_of(atlas: Atlas, array: ResultArray, mode: str | None, lci: float | None) -> str:
    """Return the title of a map: what it shows, for which mode pair, threshold and options."""
    text = array.quantity.long_name
    if array.is_error:
        text = f"error of the {text}"
    # A letter that begins the name is a symbol and keeps its case.
    is_symbol = text[1:2] == " "
    parts = [text if is_symbol else text[:1].upper() + text[1:]]
    if MODE in array.quantity.dimensions:
        parts.append(_mode_part(atlas, mode))
    if THRESHOLD in array.quantity.dimensions:
        parts.append(_threshold_part(atlas, lci))
    return ", ".join([*parts, *_option_parts(atlas)])


def label_of(array: ResultArray) -> str:
    """Return name, symbol and unit of a quantity, for a colour bar."""
    quantity = array.quantity
    unit = quantity.unit
    if unit == "1":
        # Non-dimensional lengths and areas are those of a machine with D = 1.
        unit = _UNITS.get(quantity.length_power, f"in units of $D^{{{quantity.length_power}}}$")
    return f"{array.long_name} {quantity.symbol} ({unit})"


def condition_text(atlas: Atlas, name: str, operator: str, bound: float) -> str:
    """Return a condition as it is written in a figure: symbol, sign and number."""
    symbols = {parameter.name: parameter.symbol for parameter in atlas.mechanism.parameters}
    if name not in symbols:
        array = stored_array(atlas, name)
        symbol = array.quantity.symbol
        symbols[name] = f"error of {symbol}" if array.is_error else symbol
    number = f"{bound:.10g}".replace("-", _MINUS)
    return f"{symbols[name]} {_SIGNS[operator]} {number}"


def without_workspace(atlas: Atlas, quantity: Quantity, mode: str | None) -> BoolArray:
    """Return the designs for which there is no workspace, shape (designs,).

    Their area is 0, but nothing leads from there to the areas around: they are drawn as
    what they are and not interpolated.
    """
    flags, status = _status(atlas, quantity, mode)
    bits = [
        bit
        for bit, meaning in zip(flags.values, flags.meanings, strict=True)
        if meaning.startswith(_EMPTY)
    ]
    return np.asarray((status & sum(bits)) != 0)


def why_missing(
    atlas: Atlas, quantity: Quantity, values: FloatArray, mode: str | None, lci: float | None
) -> str:
    """Return what all designs without a value have in common.

    Parameters
    ----------
    atlas
        The open result file.
    quantity
        The quantity.
    values
        Its values, shape (designs,), NaN where there is none.
    mode, lci
        The mode pair and the threshold.

    Returns
    -------
    str
        The first meaning their status shares; ``"no value"`` where it does not say.
    """
    if THRESHOLD in quantity.dimensions:
        # Empty workspaces among them: there, too, no point reaches the threshold.
        return f"no {atlas.mechanism.usable_phrase} with {_threshold_part(atlas, lci)}"
    flags, status = _status(atlas, quantity, mode)
    gone = np.isnan(values)
    shared = int(np.bitwise_and.reduce(status[gone])) if gone.any() else 0
    for bit, meaning in zip(flags.values, flags.meanings, strict=True):
        if shared & bit:
            return meaning.replace("_", " ")
    return "no value"


def _status(atlas: Atlas, quantity: Quantity, mode: str | None) -> tuple[Flags, IntArray]:
    """Return the status of every design, as bits; 0 where it does not tell of the quantity."""
    for each in atlas.mechanism.quantities:
        applies = each.name == STATUS and set(each.dimensions) <= set(quantity.dimensions)
        if applies and each.flags is not None and each.flags.masks:
            return each.flags, atlas.select(STATUS, mode).astype(np.int64)
    return Flags((), (), masks=True), np.zeros(len(atlas.designs), dtype=np.int64)


def _mode_part(atlas: Atlas, mode: str | None) -> str:
    label = atlas.modes[0] if mode is None else atlas.mechanism.parse_mode(mode)
    return "mode\N{NO-BREAK SPACE}" + label.replace("-", _MINUS)


def _option_parts(atlas: Atlas) -> list[str]:
    """Return the options that differ from what a sweep has where nothing is said."""
    text = atlas.mechanism.options_text(atlas.settings.options, but_defaults=True)
    return [text] if text else []


def _threshold_part(atlas: Atlas, lci: float | None) -> str:
    threshold = atlas.lci_thresholds[0] if lci is None else lci
    return f"LCI {_SIGNS['>=']} {threshold:g}".replace(" ", "\N{NO-BREAK SPACE}")
