"""The five-bar's design space with quantities in closed form, for what exact values lead to.

``usable_workspace_area`` and ``gci`` are those of ``closed_form_atlas``, at every design and
not only in a file; ``max_lci`` has a kink. Everything else is zero. ``composed_index`` is the
product of the first two, normalised over the file.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import closed_form_atlas
import numpy as np
import numpy.typing as npt

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray
from fivebar_atlas.mechanisms.five_bar.mechanism import FiveBarMechanism
from fivebar_atlas.mechanisms.quantities import DESIGN, MODE, NormalisedProduct, Quantity
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import AtlasWriter


def kink(designs: FloatArray) -> FloatArray:
    """Return a pyramid with its top at r1 = 1.217, r3 = 0.1234."""
    r1, _, r3 = designs.T
    return 1.0 - np.abs(r1 - 1.217) - 2.0 * np.abs(r3 - 0.1234)


class ClosedFormMechanism(FiveBarMechanism):
    """A five-bar whose quantities are simple functions."""

    name = "closed-form"
    normalised = (
        NormalisedProduct(
            Quantity(
                "composed_index",
                r"$\eta$",
                "1",
                "composed design index",
                (DESIGN, MODE),
                has_error=True,
            ),
            ("usable_workspace_area", "gci"),
            "range",
        ),
    )

    def are_designs(
        self,
        parameters: FloatArray,
        margin: float = 0.0,  # noqa: ARG002
        mode: str | None = None,  # noqa: ARG002
    ) -> BoolArray:
        """Return all: the functions are defined on the border, too."""
        return np.ones(len(parameters), dtype=np.bool_)

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Return closed forms in every mode pair."""
        results: dict[str, npt.NDArray[Any]] = {
            array.name: np.zeros((len(parameters), *array.lengths), dtype=array.dtype)
            for array in self.result_arrays(settings)
        }
        results["usable_workspace_area"][:] = closed_form_atlas.area(parameters)[:, np.newaxis]
        results["gci"][:] = closed_form_atlas.conditioning(parameters)[:, np.newaxis]
        results["max_lci"][:] = kink(parameters)[:, np.newaxis]
        results["gci_error"][:] = settings.tolerance
        return results


def write(path: Path, name: str = "closed-form", resolution: int = 60) -> Path:
    """Write a result file of a mechanism, this or another, which must be registered."""
    settings = SweepSettings(name, "surrounded", resolution, ("+-/up",), (0.5,), 1e-6)
    mechanism = mechanisms.get(name)
    designs = mechanism.lattice(settings.space, resolution)
    with AtlasWriter(path, settings, designs, [(0, len(designs))]) as writer:
        writer.add(0, mechanism.evaluate(designs, settings))
        writer.assemble()
    return path
