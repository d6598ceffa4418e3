"""Design atlases of five-bar and related parallel manipulators.

The public Python interface:

:class:`FiveBar`
    One symmetric five-bar manipulator: positions, Jacobian matrices and LCI at points, and
    its workspaces and conditioning indices for any mode pair.
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
        InputError,
        UnknownNameError,
    )
    from fivebar_atlas.mechanisms.five_bar.five_bar import FiveBar
    from fivebar_atlas.store import open_atlas

__version__ = "0.1.0"

__all__ = [
    "AtlasError",
    "FileError",
    "FileUsageError",
    "FiveBar",
    "InputError",
    "UnknownNameError",
    "__version__",
    "open_atlas",
]

#: Module that defines each public name.
_MODULES = {
    "AtlasError": "fivebar_atlas.errors",
    "FileError": "fivebar_atlas.errors",
    "FileUsageError": "fivebar_atlas.errors",
    "FiveBar": "fivebar_atlas.mechanisms.five_bar.five_bar",
    "InputError": "fivebar_atlas.errors",
    "UnknownNameError": "fivebar_atlas.errors",
    "open_atlas": "fivebar_atlas.store",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_MODULES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
