"""The mechanisms, by name. A new one is a new folder and one line in ``_REGISTRY``."""

from __future__ import annotations

import functools
import importlib

from fivebar_atlas.errors import UnknownNameError
from fivebar_atlas.mechanisms.base import Mechanism

_REGISTRY = {
    "five-bar": "fivebar_atlas.mechanisms.five_bar.mechanism:FiveBarMechanism",
}


def names() -> tuple[str, ...]:
    """Return the names of all mechanisms, the default first."""
    return tuple(_REGISTRY)


@functools.cache
def get(name: str) -> Mechanism:
    """Return the mechanism of this name; its module is imported on first use.

    Raises
    ------
    UnknownNameError
        If there is no mechanism of this name.
    """
    if name not in _REGISTRY:
        raise UnknownNameError("mechanism", name, _REGISTRY)
    module, _, attribute = _REGISTRY[name].partition(":")
    mechanism: Mechanism = getattr(importlib.import_module(module), attribute)()
    return mechanism
