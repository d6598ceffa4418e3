"""What must be the same on two machines, or in two runs, for numbers to be the same."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable

#: Packages on whose version every number depends.
_COMPUTED_WITH = ("numba", "numpy")


def computing_versions(packages: Iterable[str] = ()) -> dict[str, str]:
    """Return the hash of the kernels and the versions of what computes with them.

    Parameters
    ----------
    packages
        Further packages on whose versions the numbers depend.
    """
    from fivebar_atlas import jit

    found = {"kernel_hash": jit.kernel_hash()}
    for package in (*_COMPUTED_WITH, *packages):
        found[f"{package}_version"] = importlib.metadata.version(package)
    return found
