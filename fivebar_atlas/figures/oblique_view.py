"""A chart and heights above it, or bodies in space, seen obliquely in parallel projection."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.charts import ChartAxis, ChartRegion, ChartTick, DesignChart

FloatArray = npt.NDArray[np.float64]

#: Lowest and highest elevation: flatter, or steeper, there is nothing to see of one of both.
ELEVATION_RANGE = (5.0, 80.0)
AZIMUTH_RANGE = (-360.0, 360.0)


@dataclasses.dataclass(frozen=True, slots=True)
class ObliqueView:
    """From where a chart is seen.

    Attributes
    ----------
    elevation
        Angle of the line of sight above the plane of the chart, in degrees.
    azimuth
        Direction in which the viewer stands, in degrees counter-clockwise from the x axis of
        the chart: -90 is in front of its lower side.

    Raises
    ------
    InputError
        If an angle is out of range.
    """

    elevation: float
    azimuth: float

    def __post_init__(self) -> None:
        for name, angle, (least, greatest) in (
            ("elevation", self.elevation, ELEVATION_RANGE),
            ("azimuth", self.azimuth, AZIMUTH_RANGE),
        ):
            if not least <= angle <= greatest:
                raise InputError(name, angle, f"degrees from {least:g} to {greatest:g}")

    @property
    def _towards(self) -> FloatArray:
        """Direction in the chart towards the viewer."""
        turn = math.radians(self.azimuth)
        return np.array([math.cos(turn), math.sin(turn)])

    def nearness(self, points: FloatArray) -> FloatArray:
        """Return how near points of the chart, shape (..., 2), are to the viewer.

        What stands above the chart hides what is less near and nothing else.
        """
        return np.asarray(points @ self._towards)

    def place(self, points: FloatArray, heights: FloatArray | float = 0.0) -> FloatArray:
        """Return where points are seen, shape (..., 2).

        Parameters
        ----------
        points
            Points of the chart, shape (..., 2).
        heights
            What their places are raised by, shape (...): heights as they are seen, shorter
            than true ones by the cosine of the elevation.
        """
        x, y = self._towards
        across = points @ np.array([-y, x])
        up = heights - math.sin(math.radians(self.elevation)) * self.nearness(points)
        return np.stack([across, up], axis=-1)

    def project(self, points: FloatArray) -> FloatArray:
        """Return where points of space, shape (..., 3), are seen, shape (..., 2), to scale."""
        heights = math.cos(math.radians(self.elevation)) * points[..., 2]
        return self.place(points[..., :2], heights)

    def depth(self, points: FloatArray) -> FloatArray:
        """Return how near points of space, shape (..., 3), are to the viewer, shape (...)."""
        up = math.radians(self.elevation)
        return np.asarray(
            math.cos(up) * self.nearness(points[..., :2]) + math.sin(up) * points[..., 2]
        )

    def chart(self, chart: DesignChart) -> DesignChart:
        """Return a chart as it is seen."""
        return DesignChart(
            outline=self.place(chart.outline),
            axes=tuple(self._axis(axis) for axis in chart.axes),
            borders=tuple(self.place(border) for border in chart.borders),
            regions=tuple(
                ChartRegion(region.name, *self._pair(region.x, region.y))
                for region in chart.regions
            ),
            fixed=chart.fixed,
        )

    def _axis(self, axis: ChartAxis) -> ChartAxis:
        ticks = []
        for tick in axis.ticks:
            x, y = self._pair(tick.x, tick.y)
            dx, dy = self._pair(tick.dx, tick.dy)
            length = math.hypot(dx, dy)
            ticks.append(ChartTick(tick.label, x, y, dx / length, dy / length))
        turn = math.radians(axis.rotation)
        dx, dy = self._pair(math.cos(turn), math.sin(turn))
        # read from left to right, upright from below
        rotation = math.degrees(math.atan2(dy, dx))
        rotation -= 180.0 * round(rotation / 180.0)
        x, y = self._pair(axis.label_x, axis.label_y)
        return ChartAxis(axis.label, x, y, rotation, tuple(ticks))

    def _pair(self, x: float, y: float) -> tuple[float, float]:
        across, up = self.place(np.array([x, y])).tolist()
        return across, up
