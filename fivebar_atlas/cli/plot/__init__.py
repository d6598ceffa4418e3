"""``atlas plot``: figures, one sub-command for each kind.

A new kind is a function in one of the modules here that opens what it shows, calls one
function of ``figures`` and saves what that returns.
"""

from fivebar_atlas.cli.plot import (  # noqa: F401  their kinds are registered
    cells,
    design,
    square,
    stored,
)
from fivebar_atlas.cli.plot.group import plot

__all__ = ["plot"]
