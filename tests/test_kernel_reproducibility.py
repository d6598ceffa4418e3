"""The same sources give the same numbers, bit for bit, whatever the process did before."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

# Evaluates designs of every sub-region and prints a hash of all results. Given "before",
# other kernels are used first, which compiles or loads them on their own.
SCRIPT = """
import hashlib, os, sys
from fivebar_atlas import mechanisms
from fivebar_atlas.mechanisms.settings import (SweepSettings)

os.environ["NUMBA_CACHE_DIR"] = sys.argv[1]
if sys.argv[2] == "before":
    import numpy as np
    from fivebar_atlas.mechanisms.five_bar import evaluation
    scratch = evaluation.allocate_scratch()
    row = np.empty(evaluation.FIXED + 4)
    evaluation.evaluate_class(
        scratch, 1.1, 1.2, 0.7, 1.0, -1.0, 1.0, np.array([0.5]), 1e-4, row
    )
settings = SweepSettings("five-bar", "surrounded", 24, ("+-/up", "++/down"), (0.5,), 1e-4)
mechanism = mechanisms.get("five-bar")
results = mechanism.evaluate(mechanism.lattice("surrounded", 24), settings)
digest = hashlib.sha256()
for name in sorted(results):
    digest.update(results[name].tobytes())
print(digest.hexdigest())
"""


@pytest.mark.slow
def test_compiled_and_loaded_kernels_agree_bit_for_bit(
    start: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    cache = tmp_path / "cache"
    hashes = {}
    for state, what in [
        ("compiled", "alone"),
        ("loaded", "alone"),
        ("loaded after others", "before"),
    ]:
        out, message = start(SCRIPT, cache, what).communicate(timeout=500)
        assert out, message
        hashes[state] = out.split()[-1]
    assert len(set(hashes.values())) == 1, hashes
