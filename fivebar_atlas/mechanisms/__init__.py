"""The mechanisms, by name. A new one is a new folder and one line in ``_REGISTRY``."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from fivebar_atlas.errors import ForeignNameError, UnknownNameError
from fivebar_atlas.mechanisms.base import Mechanism

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.planar import PlanarDesign

_REGISTRY = {
    "five-bar": "fivebar_atlas.mechanisms.five_bar.mechanism:FiveBarMechanism",
    "passive-leg": "fivebar_atlas.mechanisms.passive_leg.mechanism:PassiveLegMechanism",
    "pentapod": "fivebar_atlas.mechanisms.pentapod.mechanism:PentapodMechanism",
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


def unknown_name(
    mechanism: Mechanism, name: str, value: str, known: Iterable[str]
) -> UnknownNameError:
    """Return the error for a name that is not among those known of the mechanism of a file.

    It says of which mechanism it is a quantity, a parameter or a mode pair, if it is of another
    one only: the mechanism itself may have it, too, and in the wrong place, such as a category.
    """
    others = {each: get(each).kind_of(value) for each in names() if each != mechanism.name}
    owners = {each: kind for each, kind in others.items() if kind}
    # what is known here, too, is only not what was asked for
    known = list(known)
    listed_by = mechanism.listed_by if set(known) <= set(mechanism.listed_names) else ""
    if not owners or mechanism.kind_of(value):
        return UnknownNameError(name, value, known, listed_by)
    kind = next(iter(owners.values()))
    alike = [each for each, other in owners.items() if other == kind]
    return ForeignNameError(name, value, known, kind, alike, mechanism.name, listed_by)


def planar_design(
    *lengths: float,
    unit: str | None = None,
    mechanism: str | None = None,
    options: Mapping[str, float | bool] | None = None,
) -> PlanarDesign:
    """Return one design, in the unit of its machine, for figures and files of its geometry.

    Parameters
    ----------
    *lengths
        The lengths of the mechanism: R1, R2, R3 of a five-bar.
    unit
        Unit of the lengths; ``""`` for the non-dimensional design, whatever the lengths.
        Where nothing is said it is mm, or ``""`` if the lengths are non-dimensional already.
    mechanism
        Name of the mechanism; the five-bar where nothing is said.
    options
        Sweep options of the mechanism by name; those that are not among them have their
        defaults.

    Raises
    ------
    UnknownNameError
        If there is no such mechanism or option.
    InputError
        If the lengths make no mechanism, its output does not move in a plane, or the value of
        an option is not allowed.

    Examples
    --------
    >>> from fivebar_atlas import planar_design
    >>> machine = planar_design(26, 30, 16)
    >>> round(machine.usable_workspace("+-/up").area, 2), machine.unit
    (5371.36, 'mm')
    >>> machine.check_path([[0.0, 36.0], [10.0, 36.0]], "+-/up").feasible
    True
    """
    chosen = get(mechanism or names()[0])
    return chosen.planar_design(lengths, unit, chosen.complete_options(options or {}))
