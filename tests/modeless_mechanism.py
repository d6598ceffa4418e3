"""A mechanism without modes: its quantities run over designs and thresholds only.

Two parameters from 0 to 1, quantities in closed form. A machine has three lengths, the first of
which is D; volumes scale with its cube.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    THRESHOLD,
    Axis,
    AxisColumn,
    Flags,
    Parameter,
    Quantity,
)
from fivebar_atlas.mechanisms.settings import SweepSettings


class ModelessMechanism(Mechanism):
    """A frame of height 1 and two links."""

    name = "modeless"
    title = "Modeless"
    source = "none"
    parameters = (
        Parameter("a", "$a$", "1", "first link"),
        Parameter("b", "$b$", "1", "second link"),
    )
    lengths = (Parameter("T", "$T$", "1", "frame"), *parameters)
    proportions = lengths
    factor_phrase = "T"
    design_phrase = "T = 1"
    quantities = (
        Quantity("room", "$v$", "1", "room", has_error=True, length_power=3),
        Quantity("merit", "$m$", "1", "merit"),
        Quantity("status", "status", "1", "status", flags=Flags((1,), ("short",), masks=True)),
        Quantity("good_room", "$g$", "1", "good room", (DESIGN, THRESHOLD), has_error=True),
    )
    modes = ("only",)
    mode_phrase = "mode"
    usable_phrase = "place"
    region_quantities = ("room", "merit")
    default_lci_thresholds = (0.25,)
    spaces = ("square",)
    resolution_range = (1, 1000)
    default_resolution = 8

    def parse_mode(self, text: str) -> str:
        """Accept the one name."""
        if text not in self.modes:
            raise UnknownNameError("mode", text, self.modes)
        return text

    def proportions_of(self, parameters: FloatArray) -> FloatArray:
        """Return a frame of 1 before the links."""
        return np.insert(parameters, 0, 1.0, axis=1)

    def from_lengths(self, lengths: Sequence[float]) -> tuple[FloatArray, float]:
        """Scale by D = T."""
        self.check_count(lengths)
        frame, *links = lengths
        if not frame > 0.0:
            raise InputError("T", frame, "a length above 0")
        return np.array(links) / frame, float(frame)

    def lattice(self, space: str, resolution: int) -> FloatArray:  # noqa: ARG002
        """Return a square of (N + 1)² designs."""
        steps = np.arange(resolution + 1) / resolution
        return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)

    def triangles(self, space: str, resolution: int) -> IntArray:  # noqa: ARG002
        """Return two triangles for each of N² squares."""
        row = np.arange(resolution)
        corner = (row[:, None] * (resolution + 1) + row).ravel()
        above = corner + resolution + 1
        lower = np.column_stack([corner, corner + 1, above])
        upper = np.column_stack([corner + 1, above + 1, above])
        return np.concatenate([lower, upper])

    def axes(self, settings: SweepSettings) -> tuple[Axis, ...]:
        """Return the threshold axis alone."""
        levels = np.array(settings.lci_thresholds)
        column = AxisColumn("level", levels, "1", "level")
        return (Axis(THRESHOLD, tuple(f"{value!r}" for value in levels.tolist()), (column,)),)

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Return a room of 1 + a + b, a merit 1 - (a - 0.7)² - (b - 0.4)², and their product."""
        a, b = parameters.T
        room, merit = 1.0 + a + b, 1.0 - (a - 0.7) ** 2 - (b - 0.4) ** 2
        levels = np.array(settings.lci_thresholds)
        return {
            "room": room,
            "room_error": settings.tolerance * room,
            "merit": merit,
            "status": np.where(a < 0.1, 1, 0),
            "good_room": room[:, None] * (1.0 - levels),
            "good_room_error": settings.tolerance * room[:, None] * np.ones(len(levels)),
        }

    def project(self, parameters: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return the parameters themselves."""
        return parameters.copy()

    def unproject(self, points: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return the chart coordinates themselves."""
        return points.copy()

    def chart(self, space: str) -> DesignChart:  # noqa: ARG002
        """Return a square."""
        outline = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        return DesignChart(outline, (), (), ())
