"""A small mechanism with closed-form quantities, to test everything above mechanisms.

Two parameters a + b = 1, two modes, three design-dependent shapes of quantities. Nothing
above ``mechanisms/`` may need more than what is declared here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import UnknownNameError
from fivebar_atlas.mechanisms.arrays import FloatArray, IntArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    MODE,
    THRESHOLD,
    Axis,
    AxisColumn,
    Flags,
    NormalisedProduct,
    Parameter,
    Quantity,
)
from fivebar_atlas.mechanisms.settings import SweepSettings

SIDES = Flags(values=(0, 1), meanings=("left", "right"))
STATUS = Flags(values=(1, 2), meanings=("no_span", "short_link"), masks=True)


class ToyMechanism(Mechanism):
    """Two links in a row."""

    name = "toy"
    title = "Toy"
    source = "none"
    parameters = (
        Parameter("a", "$a$", "1", "first link"),
        Parameter("b", "$b$", "1", "second link"),
    )
    quantities = (
        Quantity("span", "$s$", "m", "span", has_error=True, length_power=1),
        Quantity("sweep_area", "$S$", "m2", "swept area", (DESIGN, MODE), length_power=2),
        Quantity("share", "$h$", "1", "share", (DESIGN, MODE, THRESHOLD), has_error=True),
        Quantity("status", "status", "1", "status", (DESIGN, MODE), flags=STATUS),
    )
    normalised = (
        NormalisedProduct(
            Quantity("normalised_span", r"$\hat{s}$", "1", "normalised span", has_error=True),
            ("span",),
            "range",
        ),
        NormalisedProduct(
            Quantity(
                "composed",
                r"$\eta$",
                "1",
                "composed index",
                (DESIGN, MODE, THRESHOLD),
                has_error=True,
            ),
            ("span", "share"),
            "range",
        ),
        NormalisedProduct(
            Quantity("relative", "$q$", "1", "relative area", (DESIGN, MODE)),
            ("span", "sweep_area"),
            "largest",
        ),
    )
    modes = ("left", "right")
    spaces = ("whole", "half")
    resolution_range = (2, 10_000_000)

    def parse_mode(self, text: str) -> str:
        """Accept the two names."""
        if text not in self.modes:
            raise UnknownNameError("mode", text, self.modes)
        return text

    def lattice(self, space: str, resolution: int) -> FloatArray:
        """All (i, N - i) / N."""
        self.parse_space(space)
        steps = np.arange(resolution + 1 if space == "whole" else resolution // 2 + 1)
        return np.column_stack([steps, resolution - steps]) / float(resolution)

    def triangles(self, space: str, resolution: int) -> IntArray:  # noqa: ARG002
        """Return none: the designs lie on a line."""
        return np.empty((0, 3), dtype=np.int64)

    def axes(self, settings: SweepSettings) -> tuple[Axis, ...]:
        """Modes and thresholds."""
        sides = np.array([self.modes.index(mode) for mode in settings.modes], dtype=np.int8)
        thresholds = np.array(settings.lci_thresholds)
        return (
            Axis(MODE, settings.modes, (AxisColumn("side", sides, "1", "side", SIDES),)),
            Axis(
                THRESHOLD,
                tuple(f"{value!r}" for value in settings.lci_thresholds),
                (AxisColumn("level", thresholds, "1", "level"),),
            ),
        )

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Return closed forms, with a hole (NaN, status 1) where a = 0."""
        a, b = parameters.T
        signs = np.array([1.0 if mode == "left" else -1.0 for mode in settings.modes])
        area = np.where(a > 0.0, a * np.sin(b) + a * a, np.nan)[:, None] * signs
        levels = np.array(settings.lci_thresholds)
        status = np.where(a == 0.0, 1, 0) + np.where(b < 0.1, 2, 0)
        return {
            "span": np.hypot(a, b),
            "span_error": 1e-16 * (a + b),
            "sweep_area": area,
            "share": area[:, :, None] * levels,
            "share_error": np.abs(area[:, :, None]) * 1e-16 * np.ones(len(levels)),
            "status": np.repeat(status[:, None], len(signs), axis=1),
        }

    def project(self, parameters: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return the parameters themselves."""
        return parameters.copy()

    def unproject(self, points: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return the chart coordinates themselves."""
        return points.copy()

    def chart(self, space: str) -> DesignChart:
        """Return an outline and nothing else."""
        self.parse_space(space)
        return DesignChart(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), (), (), ())
