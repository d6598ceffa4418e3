"""How a design space is drawn in the plane."""

from __future__ import annotations

import dataclasses

from fivebar_atlas.mechanisms.arrays import FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class ChartTick:
    """A tick of a chart axis: its label, its foot and the outward direction."""

    label: str
    x: float
    y: float
    dx: float
    dy: float


@dataclasses.dataclass(frozen=True, slots=True)
class ChartAxis:
    """One parameter's axis along a side of the chart.

    Attributes
    ----------
    label
        Mathtext label.
    label_x, label_y
        Where the label stands, in chart coordinates.
    rotation
        Rotation of the label in degrees.
    ticks
        The ticks, feet on the side.
    """

    label: str
    label_x: float
    label_y: float
    rotation: float
    ticks: tuple[ChartTick, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class ChartRegion:
    """A named sub-region of the design space and where its name is written."""

    name: str
    x: float
    y: float


@dataclasses.dataclass(frozen=True, slots=True)
class DesignChart:
    """How a design space is drawn in the plane (aspect ratio 1).

    Attributes
    ----------
    outline
        Closed polygon, shape (k, 2).
    axes
        One axis for each drawn parameter.
    borders
        Polylines between sub-regions, each of shape (k, 2).
    regions
        Names of the sub-regions with the places where they are written.
    fixed
        What all designs have that is not to be seen in the chart, ``"$l_a$ = 0.8"``; empty if
        there is nothing of the kind.
    """

    outline: FloatArray
    axes: tuple[ChartAxis, ...]
    borders: tuple[FloatArray, ...]
    regions: tuple[ChartRegion, ...]
    fixed: str = ""
