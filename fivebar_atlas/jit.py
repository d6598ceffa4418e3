"""The only place that names numba flags and the folder of compiled kernels.

numba keys a cached kernel by the source file that defines it. A kernel that calls one
in another file would therefore be served stale after that other file changed. Here the
cache folder is keyed by a hash of *all* kernel sources instead; the same hash is stored
in every result file.
"""

from __future__ import annotations

import functools
import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

#: Reassociation lets sums vectorise; NaN and infinity keep their meaning (no ``nnan``).
FASTMATH = frozenset({"contract", "arcp", "nsz", "reassoc"})

_PACKAGE = Path(__file__).parent
_SOURCES = ("jit.py", "numerics/*.py", "mechanisms/*/*.py")
_MARK = b"@kernel"
#: Room that compiled kernels need, in bytes.
_ROOM = 32 << 20


@functools.cache
def kernel_hash() -> str:
    """Return a short SHA-256 over the sources of all kernels.

    Returns
    -------
    str
        Sixteen hexadecimal digits; they change whenever a file with a kernel in it does.
    """
    digest = hashlib.sha256()
    for pattern in _SOURCES:
        for source in sorted(_PACKAGE.glob(pattern)):
            text = source.read_bytes()
            if _MARK in text:
                digest.update(source.relative_to(_PACKAGE).as_posix().encode())
                digest.update(text)
    return digest.hexdigest()[:16]


@functools.cache
def processor() -> str:
    """Return what kernels are compiled for: another one may round differently.

    Returns
    -------
    str
        Name of the processor, as LLVM calls it, and a hash of its instruction sets:
        ``"znver3-5d41402a"``; ``"interpreted"`` where ``NUMBA_DISABLE_JIT`` is set.
    """
    from numba.core.registry import cpu_target

    config: Any = numba.config
    if config.DISABLE_JIT:
        return "interpreted"
    # the same that numba keys its own cache by
    _, name, features = cpu_target.target_context.codegen().magic_tuple()
    return f"{name}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"


@functools.cache
def cache_folder() -> Path | None:
    """Return the folder of compiled kernels, or None where nothing can be written.

    ``NUMBA_CACHE_DIR`` is respected; otherwise the folder lies below the user's cache
    directory (``XDG_CACHE_HOME``, by default ``~/.cache``).
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        base = Path(chosen)
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    folder = base / "fivebar-atlas" / f"{kernel_hash()}-numba{numba.__version__}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            # A quota that is met while a kernel is kept would end the program.
            if not any(folder.rglob("*.nbi")):
                file.write(bytes(_ROOM))
    except OSError:
        return None
    return folder


def has_compiled_kernels() -> bool:
    """Tell whether kernels of these sources have been compiled before and kept."""
    folder = cache_folder()
    return folder is not None and any(folder.rglob("*.nbi"))


def kernel(function: Kernel) -> Kernel:
    """Compile a kernel: no exceptions from arithmetic, no GIL, cached between processes.

    Parameters
    ----------
    function
        Plain Python function on scalars and arrays, first run with concrete types.

    Returns
    -------
    Kernel
        The compiled dispatcher, or the function itself where ``NUMBA_DISABLE_JIT`` is set.

    Notes
    -----
    Kernels are inlined into the kernels that call them, whose loops can then vectorise.
    One that is not exists twice, as compiled on its own and as optimised again inside
    its caller, and the two differ in the last digits; which of them is called depends
    on whether the process has compiled the caller or loaded it from the cache, and on
    what else it has loaded. Inlined, the same sources give the same results, bit for
    bit, in every process.
    """
    folder = cache_folder()
    config: Any = numba.config  # its entries are made at run time
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(folder) if folder else previous
    try:
        compiled = numba.njit(
            cache=folder is not None,
            nogil=True,
            forceinline=True,
            error_model="numpy",
            fastmath=set(FASTMATH),
        )(function)
    finally:
        config.CACHE_DIR = previous
    return cast(Kernel, compiled)
