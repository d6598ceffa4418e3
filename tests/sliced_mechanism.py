"""A mechanism of three free parameters, whose design spaces are slices: one of them is fixed.

There are more such spaces than can be listed: ``"b=0.25"`` has all designs with b = 0.25. The
quantities are linear in a and c, so that interpolation in a lattice of a slice is exact. A
machine has a fourth length A, which is 1 in every design; its name differs from that of a by
its case only.
"""

from __future__ import annotations

import re
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
    MODE,
    Axis,
    AxisColumn,
    Flags,
    Parameter,
    Quantity,
)
from fivebar_atlas.mechanisms.settings import SweepOption, SweepSettings

_SLICE = re.compile(r"([abc])=(\d*\.?\d+)")


class SlicedMechanism(Mechanism):
    """Three links of lengths from 0 to 1 beside a frame of length 1."""

    name = "sliced"
    title = "Sliced"
    source = "none"
    parameters = (
        Parameter("a", "$a$", "1", "first link"),
        Parameter("b", "$b$", "1", "second link"),
        Parameter("c", "$c$", "1", "third link"),
    )
    lengths = (Parameter("A", "$A$", "1", "frame"), *parameters)
    proportions = lengths
    input_names = ("q1", "phi2")
    factor_phrase = "A"
    design_phrase = "A = 1"
    quantities = (Quantity("stretch", "$s$", "1", "stretch", (DESIGN, MODE), length_power=1),)
    modes = ("only",)
    spaces = ("b=0.5",)
    slices = ("a=VALUE", "b=VALUE", "c=VALUE")
    resolution_range = (1, 1000)
    options = (
        SweepOption("gain", "deg", "how much all is stretched", 1.0, 0.5, 8.0),
        SweepOption("is_mirrored", "1", "whether stretches are negative", False),
    )

    def parse_mode(self, text: str) -> str:
        """Accept the one name."""
        if text not in self.modes:
            raise UnknownNameError("mode", text, self.modes)
        return text

    def parse_space(self, text: str, name: str = "space") -> str:
        """Return ``"b=0.25"`` for ``"b=.250"``."""
        found = _SLICE.fullmatch(text)
        if found is None or not float(found[2]) <= 1.0:
            raise UnknownNameError(name, text, self.slices)
        return f"{found[1]}={float(found[2])!r}"

    def proportions_of(self, parameters: FloatArray) -> FloatArray:
        """Return a frame of 1 before the links."""
        return np.insert(parameters, 0, 1.0, axis=1)

    def from_lengths(self, lengths: Sequence[float]) -> tuple[FloatArray, float]:
        """Scale by D = A."""
        self.check_count(lengths)
        frame, *links = lengths
        if not frame > 0.0:
            raise InputError("A", frame, "a length above 0")
        return np.array(links) / frame, float(frame)

    def lattice(self, space: str, resolution: int) -> FloatArray:
        """Return a square of (N + 1)² designs."""
        steps = np.arange(resolution + 1) / resolution
        points = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        return self.unproject(points, space)

    def triangles(self, space: str, resolution: int) -> IntArray:  # noqa: ARG002
        """Return two triangles for each of N² squares."""
        row = np.arange(resolution)
        corner = (row[:, None] * (resolution + 1) + row).ravel()
        above = corner + resolution + 1
        lower = np.column_stack([corner, corner + 1, above])
        upper = np.column_stack([corner + 1, above + 1, above])
        return np.concatenate([lower, upper])

    def axes(self, settings: SweepSettings) -> tuple[Axis, ...]:
        """Return the mode axis."""
        codes = np.zeros(len(settings.modes), dtype=np.int8)
        only = AxisColumn("way", codes, "1", "way", Flags((0,), self.modes))
        return (Axis(MODE, settings.modes, (only,)),)

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Return a + b² + 3 c in every mode, times the gain, mirrored or not."""
        a, b, c = parameters.T
        values = dict(self.complete_options(settings.options))
        sign = -1.0 if values["is_mirrored"] else 1.0
        stretch = sign * values["gain"] * (a + b**2 + 3.0 * c)
        return {"stretch": np.repeat(stretch[:, None], len(settings.modes), axis=1)}

    def project(self, parameters: FloatArray, space: str) -> FloatArray:
        """Return the two parameters that are free."""
        column, _ = self._fixed(space)
        return np.delete(parameters, column, axis=1)

    def unproject(self, points: FloatArray, space: str) -> FloatArray:
        """Return the two parameters with the fixed one between them."""
        column, value = self._fixed(space)
        return np.insert(points, column, value, axis=1)

    def chart(self, space: str) -> DesignChart:  # noqa: ARG002
        """Return a square."""
        outline = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        return DesignChart(outline, (), (), ())

    def _fixed(self, space: str) -> tuple[int, float]:
        """Return column and value of the parameter that is fixed."""
        name, _, value = space.partition("=")
        return "abc".index(name), float(value)
