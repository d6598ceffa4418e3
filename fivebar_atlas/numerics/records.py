"""Work space of kernels: one structured record, passed by its address.

A kernel that is handed a tuple of arrays gets a copy of every array's descriptor with
every call, some four hundred words for a panel of rays. A record costs one pointer, and
its fields keep their names. All shapes are part of the type, so compiled code is reused.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def record_type(*fields: tuple[str, type | np.dtype[Any], tuple[int, ...]]) -> np.dtype[Any]:
    """Return an aligned structured type with fields of (name, type, shape)."""
    return np.dtype(list(fields), align=True)


def allocate_record(dtype: np.dtype[Any]) -> Any:
    """Return one zeroed record whose fields are attributes."""
    records: npt.NDArray[Any] = np.zeros(1, dtype)
    return records.view(np.recarray)[0]
