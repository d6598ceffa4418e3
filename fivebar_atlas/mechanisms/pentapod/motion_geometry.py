"""The geometry of a pentapod as the table of a motion file has it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from fivebar_atlas.errors import InputError, MissingInputError, UnknownNameError
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.singularity import is_always_singular

# The two ways to say where joints are; n6 may be given with both.
_RADII = ("r_a", "r_b", "position_angle", "offset", "base_angle")
_JOINTS = ("base", "platform")
_AXIS = "axis"


def geometry_from_table(
    table: Mapping[str, object], named: Callable[[str], str] = str
) -> PentapodGeometry:
    """Return the geometry that a table describes.

    Parameters
    ----------
    table
        Either radii, ``r_a`` and ``r_b``, with ``position_angle`` and ``base_angle`` in degrees
        and ``offset`` (see :meth:`PentapodGeometry.from_radii` for their defaults), or joints,
        ``base`` and ``platform``, five points each, with ``axis``; ``axis`` may be given with
        radii, too.
    named
        Returns what a key is called in messages.

    Raises
    ------
    UnknownNameError
        If a key is unknown.
    InputError
        If a key is missing, both ways are mixed, a value has the wrong type, or the joints make
        no pentapod, or one that is singular in all poses.
    """
    for key in table:
        if key not in (*_RADII, *_JOINTS, _AXIS):
            raise UnknownNameError(named(key), key, (*_RADII, *_JOINTS, _AXIS))
    by_joints = [key for key in _JOINTS if key in table]
    by_radii = [key for key in _RADII if key in table]
    if by_joints and by_radii:
        allowed = f"no such key where {by_joints[0]} is given: joints or radii, not both"
        raise InputError(named(by_radii[0]), table[by_radii[0]], allowed)
    needed = (*_JOINTS, _AXIS) if by_joints else ("r_a", "r_b")
    for key in needed:
        if key not in table:
            raise MissingInputError(named(key), _expected(key))
    try:
        geometry = _from_joints(table, named) if by_joints else _from_radii(table, named)
    except InputError as error:
        # joints that follow from radii are none of the table's
        if error.name in table:
            raise error.renamed(named(error.name), error.value) from None
        if error.name not in (*_JOINTS, _AXIS):
            raise
        given = {key: table[key] for key in by_radii}
        raise InputError(named("r_a"), given, error.allowed) from None
    if is_always_singular(geometry):
        raise InputError(
            named(needed[0]),
            table[needed[0]],
            "joints that do not make every pose singular, as these do",
        )
    return geometry


def _from_radii(table: Mapping[str, object], named: Callable[[str], str]) -> PentapodGeometry:
    numbers = {key: _number(table[key], named(key), key) for key in _RADII if key in table}
    angles = {
        key: math.radians(numbers[key])
        for key in ("position_angle", "base_angle")
        if key in numbers
    }
    return PentapodGeometry.from_radii(
        numbers["r_a"],
        numbers["r_b"],
        offset=numbers.get("offset"),
        axis=_points(table[_AXIS], named(_AXIS), _AXIS) if _AXIS in table else None,
        **angles,
    )


def _from_joints(table: Mapping[str, object], named: Callable[[str], str]) -> PentapodGeometry:
    base, platform, axis = (_points(table[key], named(key), key) for key in (*_JOINTS, _AXIS))
    return PentapodGeometry(base, platform, axis)


def _number(value: object, name: str, key: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(name, value, _expected(key))
    return float(value)


def _points(
    value: object, name: str, key: str
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return a list of numbers, or of lists of numbers, as an array."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(name, value, _expected(key)) from None
    if array.shape != ((3,) if key == _AXIS else (5, 3)):
        raise InputError(name, value, _expected(key))
    return array


def _expected(key: str) -> str:
    """Return what a key must be, as a phrase."""
    if key == _AXIS:
        return "the direction n6 in the axes of the platform, three numbers"
    if key == "base":
        return "the joints A_1 to A_5, five lists of three numbers"
    if key == "platform":
        return "the joints B_1 to B_5 in the axes of the platform, five lists of three numbers"
    return "a number, " + ("in degrees" if key.endswith("angle") else "a length")
