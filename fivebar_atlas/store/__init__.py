"""The result file: its HDF5 format, written whole or not at all, and read lazily.

The format is described in ``docs/format.md``; only this package knows HDF5.
"""

from __future__ import annotations

from fivebar_atlas.store.merging import merge
from fivebar_atlas.store.provenance import FORMAT, FORMAT_VERSION
from fivebar_atlas.store.reading import Atlas, open_atlas
from fivebar_atlas.store.writing import AtlasWriter, is_complete

__all__ = [
    "FORMAT",
    "FORMAT_VERSION",
    "Atlas",
    "AtlasWriter",
    "is_complete",
    "merge",
    "open_atlas",
]
