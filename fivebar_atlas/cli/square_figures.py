"""The figures of the largest square: over the ratio of links, of one machine, and its optimum."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any

from fivebar_atlas.errors import InfeasibleSizeError

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.base import Mechanism
    from fivebar_atlas.synthesis.largest_square import Square, SquareTask
    from fivebar_atlas.synthesis.square_curve import SquareCurve

#: Unit of lengths in these figures and their data: the actuated link.
LINK_UNIT = "l1"


def draw_curve(task: SquareTask, curve: SquareCurve, **drawing: Any) -> Any:
    """Return the side over the ratio of links; ``drawing`` may have a width and data.

    Raises
    ------
    InfeasibleSizeError
        If there is no square for any ratio.
    """
    from fivebar_atlas.figures.square_curve_figure import square_curve_figure
    from fivebar_atlas.synthesis.active_constraints import joined
    from fivebar_atlas.synthesis.largest_square import why_none
    from fivebar_atlas.synthesis.square_curve_lines import curve_lines

    if curve.largest is None:
        raise InfeasibleSizeError(f"for no ratio of links: {why_none(curve.squares[0])}")
    lines = curve_lines(task, curve)
    shown = [line for line in lines if line.active]
    kinks = [
        (float(before.points[-1, 0]), float(before.points[-1, 1]))
        for before, after in itertools.pairwise(lines)
        if before.active and after.active
    ]
    remarks = [
        rf"no {_name(task)} for $\rho$ from {line.points[0, 0]:.6g} to {line.points[-1, 0]:.6g}"
        for line in lines
        if not line.active
    ]
    label = "side of the largest square $a/l_1$"
    if task.aspect != 1.0:
        label = "root of the area of the largest rectangle $a/l_1$"
    return square_curve_figure(
        [(joined(line.active), line.points) for line in shown],
        kinks,
        (curve.largest.ratio, curve.largest.side),
        _title(task),
        label,
        remarks,
        **drawing,
    )


def draw_square(square: Square, **drawing: Any) -> Any:
    """Return the LCI in a square, which there is; ``drawing`` may have a width and data."""
    from fivebar_atlas.figures.square_figure import SquareDrawing, square_figure
    from fivebar_atlas.figures.wording import number_text
    from fivebar_atlas.synthesis.active_constraints import joined

    task = square.task
    design = task.mechanism.planar_design(square.lengths, LINK_UNIT)
    _, second, third = square.lengths
    lengths = rf"$\rho = l_2/l_1$ = {number_text(second)}, $l_0/l_1$ = {number_text(third, 5)}"
    return square_figure(
        design,
        task.mode,
        task.lci_threshold,
        SquareDrawing(
            name=_name(task),
            width=square.width,
            height=square.height,
            centre=square.centre,
            contacts=square.contacts,
            active=joined(square.active),
            circle=square.circle,
        ),
        f"{_title(task)}, {lengths}",
        **drawing,
    )


def draw_optimal_configuration(mechanism: Mechanism, ratio: float, **drawing: Any) -> Any:
    """Return the optimal configuration of a ratio; ``drawing`` may have a width and data."""
    from fivebar_atlas.figures.optimal_configuration_figure import optimal_configuration_figure

    optimal = mechanism.optimal_configuration(ratio)
    design = mechanism.planar_design(optimal.lengths, LINK_UNIT)
    pose = design.pose(*optimal.output, optimal.mode)
    return optimal_configuration_figure(pose, ratio, **drawing)


def _name(task: SquareTask) -> str:
    """Return what the shape is called."""
    return "square" if task.aspect == 1.0 else "rectangle"


def _title(task: SquareTask) -> str:
    """Return what is asked of a square, as the beginning of a title."""
    from fivebar_atlas.figures.wording import mode_text, number_text, threshold_text
    from fivebar_atlas.synthesis.largest_square import AXIS, LOWER

    parts = [f"Largest {_name(task)}"]
    if task.aspect != 1.0:
        parts[0] += f" of aspect {number_text(task.aspect)}"
    if task.centre == AXIS:
        parts.append("centre anywhere on the axis")
    if task.half == LOWER:
        parts.append("below the base")
    parts += [threshold_text(task.lci_threshold), mode_text(task.mode)]
    for each in task.ranges:
        least, greatest = (number_text(math.degrees(end)) for end in (each.least, each.greatest))
        parts.append(rf"$\theta_{{{each.number}}}$ from {least}° to {greatest}°")
    return ", ".join(parts)
