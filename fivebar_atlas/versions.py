"""What must be the same on two machines, or in two runs, for numbers to be the same."""

from __future__ import annotations

import functools
import hashlib
import importlib
import inspect
from collections.abc import Iterator
from pathlib import Path

from fivebar_atlas import mechanisms

#: Packages on whose version every number depends.
_COMPUTED_WITH = ("numba", "numpy")

_PACKAGE = Path(__file__).parent
#: What every mechanism computes with, apart from its own folder.
_SHARED = ("jit.py", "numerics/*.py", "mechanisms/*.py")


def computing_versions(mechanism: str) -> dict[str, str]:
    """Return hashes of the sources and versions of the packages that numbers depend on.

    They are those that this process has loaded, whatever has been installed since.

    Parameters
    ----------
    mechanism
        Name of the mechanism they are computed for.

    Raises
    ------
    UnknownNameError
        If there is no mechanism of this name.
    """
    from fivebar_atlas import jit  # which loads numba: reading files must not wait for that

    packages = (*_COMPUTED_WITH, *mechanisms.get(mechanism).computed_with)
    return {
        "kernel_hash": jit.kernel_hash(),
        "source_hash": source_hash(mechanism),
        **{f"{each}_version": str(importlib.import_module(each).__version__) for each in packages},
    }


@functools.cache
def source_hash(mechanism: str) -> str:
    """Return a short SHA-256 over the sources that the numbers of a mechanism depend on.

    These are its own folder and what all mechanisms share: more than the kernels, whose hash
    decides only whether compiled code can be used again.

    Parameters
    ----------
    mechanism
        Name of the mechanism.

    Returns
    -------
    str
        Sixteen hexadecimal digits; they change whenever one of the files does.
    """
    digest = hashlib.sha256()
    for source in _sources(mechanism):
        digest.update(f"{source.parent.name}/{source.name}\n".encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _sources(mechanism: str) -> Iterator[Path]:
    """Yield the files that the numbers of a mechanism depend on, always in one order."""
    for pattern in _SHARED:
        yield from sorted(_PACKAGE.glob(pattern))
    own = Path(inspect.getfile(type(mechanisms.get(mechanism))))
    is_package = (own.parent / "__init__.py").exists()
    yield from sorted(own.parent.glob("*.py")) if is_package else [own]
