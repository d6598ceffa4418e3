"""What the numbers of a report depend on: versions, kernels, machine, time."""

from __future__ import annotations

import datetime
import importlib.metadata
import platform

from fivebar_atlas import __version__
from fivebar_atlas.jit import kernel_hash
from fivebar_atlas.report.content import Row, Section

_LIBRARIES = ("numpy", "numba", "matplotlib")


def provenance(time: datetime.datetime) -> Section:
    """Return what the numbers depend on.

    Parameters
    ----------
    time
        When they were computed, with its time zone.
    """
    utc = time.astimezone(datetime.UTC)
    libraries = (Row(name, importlib.metadata.version(name)) for name in _LIBRARIES)
    return Section(
        "Provenance",
        ("The same command with these versions gives the same numbers.",),
        (
            Row("fivebar-atlas", __version__),
            Row("Kernels", kernel_hash(), note="hash of the sources of all kernels"),
            Row("Python", platform.python_version()),
            *libraries,
            Row("Machine", f"{platform.system()} {platform.machine()}"),
            Row("Computed", utc.strftime("%Y-%m-%d %H:%M:%S UTC")),
        ),
    )
