"""What keeps a shape from being larger, in words: which limit, and where on the shape."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.planar_geometry import FloatArray
from fivebar_atlas.synthesis.containment import ActuatorRange, GoodCondition
from fivebar_atlas.synthesis.shapes import Shape

# How close to a side, as a share of the shape, a contact lies on it.
_ON_SIDE = 1e-6


def active_constraints(
    good: GoodCondition,
    shape: Shape,
    position: Sequence[float] | FloatArray,
    scale: float,
    contacts: FloatArray,
    tolerance: float,
    inside: bool = False,
) -> tuple[str, ...]:
    """Return the limits that hold with equality, each with where on the shape it does.

    Parameters
    ----------
    good
        What is asked of the points of the shape.
    shape
        The shape, in lengths of a machine.
    position
        Its centre in non-dimensional lengths.
    scale
        Non-dimensional length for the unit of the shape.
    contacts
        Points of the shape with a margin near zero, relative to its centre and in its lengths,
        shape (n, 2).
    tolerance
        Margins up to this hold with equality.
    inside
        Whether the points are in the interior, not on the boundary.
    """
    if not len(contacts):
        return ()
    points = np.asarray(position) + scale * contacts
    x, y = points[:, 0].copy(), points[:, 1].copy()
    limits = {"LCI": good.design.lci_inside(x, y, good.mode) - good.lci_threshold}
    inputs = good.design.inputs(x, y, good.mode)
    for each in good.ranges:
        if each.is_limiting:
            name = mechanisms.get(good.design.mechanism).input_text(each.number)
            limits.update(_ends(each, name, inputs[:, each.number - 1]))
    active = []
    for name, margins in limits.items():
        touching = contacts[margins <= tolerance]
        if inside and len(touching):
            active.append(f"{name} inside")
        elif not inside:
            active += [f"{name} at {place}" for place in _places(shape, touching)]
    return tuple(active)


def _ends(limit: ActuatorRange, name: str, inputs: FloatArray) -> dict[str, FloatArray]:
    """Return by how much values of the input of a name are inside of either end of its range."""
    middle = 0.5 * (limit.least + limit.greatest)
    half = limit.greatest - middle
    off = np.remainder(inputs - middle + np.pi, 2.0 * np.pi) - np.pi
    return {f"least {name}": half + off, f"greatest {name}": half - off}


def _places(shape: Shape, contacts: FloatArray) -> list[str]:
    """Return in words where on the box around a shape contacts are; mirrored ones together."""
    lower, upper = shape.extent
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    shares = (contacts - middle) / half
    signs = np.where(np.abs(shares) > 1.0 - _ON_SIDE, np.sign(shares), 0.0).astype(int)
    found = {(int(across), int(up)) for across, up in signs}
    vertical, lateral = {1: "upper", -1: "lower"}, {1: "right", -1: "left"}
    words = []
    for up in (1, -1):
        if {(1, up), (-1, up)} <= found:
            words.append(f"the {vertical[up]} corners")
        else:
            words += [
                f"the {vertical[up]} {lateral[across]} corner"
                for across in (-1, 1)
                if (across, up) in found
            ]
        if (0, up) in found:
            words.append(f"the {vertical[up]} side")
    if {(1, 0), (-1, 0)} <= found:
        words.append("the lateral sides")
    else:
        words += [f"the {lateral[across]} side" for across in (-1, 1) if (across, 0) in found]
    if (0, 0) in found:
        words.append("the boundary")
    return words


def joined(active: Iterable[str]) -> str:
    """Return active constraints as a phrase."""
    return ", ".join(active) or "none"
