"""Design atlases of five-bar and related parallel manipulators.

The public Python interface:

:class:`FiveBar`
    One symmetric five-bar manipulator: positions, Jacobian matrices and LCI at points, and
    its workspaces and conditioning indices for any mode pair, its loci and outlines as arcs.
:class:`PassiveLeg`
    One manipulator with a passive leg, the same for it.
:class:`Pentapod`
    One pentapod: displacements, Jacobian matrices, forces, indices, workspace limits.
:func:`planar_design`
    One design in the unit of its machine, as figures and files of its geometry take it.
:func:`open_atlas`
    Opens a result file for reading.
:class:`AtlasError` and its subclasses
    Everything this package raises on purpose.

Importing the package imports nothing else; a name is loaded when it is first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fivebar_atlas.errors import (
        AtlasError,
        FileError,
        FileUsageError,
        InfeasiblePathError,
        InfeasibleSizeError,
        InputError,
        OutOfReachError,
        UnknownNameError,
    )
    from fivebar_atlas.mechanisms import planar_design
    from fivebar_atlas.mechanisms.five_bar.five_bar import FiveBar
    from fivebar_atlas.mechanisms.passive_leg.passive_leg import PassiveLeg
    from fivebar_atlas.mechanisms.pentapod.pentapod import Pentapod
    from fivebar_atlas.store import open_atlas

__version__ = "0.1.0"

__all__ = [
    "AtlasError",
    "FileError",
    "FileUsageError",
    "FiveBar",
    "InfeasiblePathError",
    "InfeasibleSizeError",
    "InputError",
    "OutOfReachError",
    "PassiveLeg",
    "Pentapod",
    "UnknownNameError",
    "__version__",
    "open_atlas",
    "planar_design",
]

#: Module that defines each public name.
_MODULES = {
    "AtlasError": "fivebar_atlas.errors",
    "FileError": "fivebar_atlas.errors",
    "FileUsageError": "fivebar_atlas.errors",
    "FiveBar": "fivebar_atlas.mechanisms.five_bar.five_bar",
    "InfeasiblePathError": "fivebar_atlas.errors",
    "InfeasibleSizeError": "fivebar_atlas.errors",
    "InputError": "fivebar_atlas.errors",
    "OutOfReachError": "fivebar_atlas.errors",
    "PassiveLeg": "fivebar_atlas.mechanisms.passive_leg.passive_leg",
    "Pentapod": "fivebar_atlas.mechanisms.pentapod.pentapod",
    "UnknownNameError": "fivebar_atlas.errors",
    "open_atlas": "fivebar_atlas.store",
    "planar_design": "fivebar_atlas.mechanisms",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_MODULES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
