"""Result files with made-up values in closed form, to test what is drawn and read from them.

The numbers mean nothing for the mechanism; they are smooth, have holes and constant parts,
and can be computed again where a test needs them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store import AtlasWriter

FloatArray = npt.NDArray[np.float64]

EMPTY, NO_LOWER_CIRCLE = 1, 16


def area(designs: FloatArray) -> FloatArray:
    """Return an area that falls off with r3 and towards short links."""
    r1, r2, r3 = designs.T
    return 12.0 * r1 * r2 * (1.0 - 0.5 * r3)


def conditioning(designs: FloatArray) -> FloatArray:
    """Return an index with one summit on r3 = 0."""
    r1, _, r3 = designs.T
    return 0.67 * np.exp(-((r1 - 1.3) ** 2) - 1.5 * r3)


def empty_designs(designs: FloatArray) -> npt.NDArray[np.bool_]:
    """Return the designs without a workspace in every mode pair but the first."""
    return designs[:, 0] > 1.9


def write(path: Path, space: str = "surrounded", resolution: int = 30, **choices: Any) -> Path:
    """Write a result file and return its path."""
    settings = SweepSettings(
        mechanism="five-bar",
        space=space,
        resolution=resolution,
        modes=choices.get("modes", ("+-/up", "++/up")),
        lci_thresholds=choices.get("lci_thresholds", (0.3, 0.5)),
        tolerance=1e-6,
    )
    mechanism = mechanisms.get(settings.mechanism)
    designs = mechanism.lattice(space, resolution)
    count = len(designs)
    arrays: dict[str, npt.NDArray[Any]] = {}
    for array in mechanism.result_arrays(settings):
        arrays[array.name] = np.zeros((count, *array.lengths), dtype=array.dtype)
    regions = designs @ np.array([1.0, -1.0, 0.0])
    arrays["sub_region"][:] = np.where(regions <= 0.0, 1, 4)
    arrays["theoretical_workspace_area"][:] = area(designs) + 1.0
    for mode in range(len(settings.modes)):
        gone = empty_designs(designs) if mode else np.zeros(count, dtype=np.bool_)
        arrays["usable_workspace_area"][:, mode] = np.where(gone, 0.0, area(designs))
        arrays["usable_workspace_area_error"][:, mode] = np.where(
            gone, 0.0, 10.0 ** (-9.0 + designs[:, 0])
        )
        arrays["gci"][:, mode] = np.where(gone, np.nan, conditioning(designs))
        arrays["gci_error"][:, mode] = np.where(gone, np.nan, 1e-9)
        arrays["max_lci"][:, mode] = np.where(gone, np.nan, np.minimum(1.0, 2.0 - designs[:, 2]))
        arrays["max_lci_y"][:, mode] = np.where(gone, np.nan, designs[:, 1] - designs[:, 0])
        arrays["mic_lower_radius"][:, mode] = np.nan
        arrays["status"][:, mode] = NO_LOWER_CIRCLE + np.where(gone, EMPTY, 0)
        for index, threshold in enumerate(settings.lci_thresholds):
            arrays["good_condition_workspace_area"][:, mode, index] = np.where(
                gone, 0.0, area(designs) * (1.0 - threshold)
            )
            arrays["good_condition_gci"][:, mode, index] = np.where(
                gone, np.nan, conditioning(designs) + 0.3 * threshold
            )
    with AtlasWriter(path, settings, designs, [(0, count)]) as writer:
        writer.add(0, arrays)
        writer.assemble()
    return path
