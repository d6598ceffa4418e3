"""Root finding by brackets, one step at a time, for kernels.

A jitted function handed to another one misses numba's cache in every new process. So these
are single steps: the caller evaluates its own function, by name and for many brackets at
once, between them.

The method is Chandrupatla's, "A new hybrid quadratic/bisection algorithm for finding the
zero of a nonlinear function without using derivatives", Adv. Eng. Softw. 28 (1997),
145-149: inverse quadratic interpolation where it is safe, bisection elsewhere. It does not
stall at roots next to a turning point, where secant rules do.

Two roots on either side of a turning point have no bracket until the turning point is near enough
that the sign there shows them: golden sections walk down to it.
"""

from __future__ import annotations

from fivebar_atlas.jit import kernel

#: Share that tells that a root is found.
FOUND = -1.0
# Share of an interval at which its first golden section is.
_GOLDEN = 0.381966011250105


@kernel
def first_share(f1: float, f2: float) -> float:
    """Return where to look first in a bracket, as a share of the way from point 1 to 2.

    The secant point, kept in the inner nine tenths.
    """
    return min(max(f1 / (f1 - f2), 0.05), 0.95)


@kernel
def next_share(
    x1: float, f1: float, x2: float, f2: float, x3: float, f3: float, tolerance: float
) -> float:
    """Return where to look next, as a share of the way from point 1 to 2, or FOUND.

    Parameters
    ----------
    x1, f1
        The newest point and its value.
    x2, f2
        The other end of the bracket, where the value has the opposite sign.
    x3, f3
        The point that was given up last.
    tolerance
        Length of the bracket at which the root counts as found.
    """
    if f1 == 0.0 or abs(x2 - x1) <= tolerance:
        return FOUND
    least = 0.5 * tolerance / abs(x2 - x1)
    share = 0.5
    if f3 != f2 and f3 != f1:
        xi = (x1 - x2) / (x3 - x2)
        phi = (f1 - f2) / (f3 - f2)
        if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
            alpha = (x3 - x1) / (x2 - x1)
            share = f1 / (f2 - f1) * f3 / (f2 - f3) + alpha * f1 / (f3 - f1) * f2 / (f3 - f2)
    return min(max(share, least), 1.0 - least)


@kernel
def first_sections(left: float, right: float) -> tuple[float, float]:
    """Return the two golden sections of an interval, the left one first."""
    section = left + _GOLDEN * (right - left)
    return section, left + right - section


@kernel
def next_section(
    step: int, left: float, right: float, x1: float, y1: float, x2: float, y2: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return the interval about a turning point for a step, and where to look in it.

    Parameters
    ----------
    step
        Number of the step: in the first two, 0 and 1, the interval stays as it is.
    left, right
        Ends of the interval.
    x1, y1, x2, y2
        Its golden sections, the left one first, and the values there.

    Returns
    -------
    left, right, x1, y1, x2, y2
        The same for this step, about the lesser of the two values.
    trial
        The section, x1 or x2, whose value is to be evaluated now.
    """
    if step == 0:
        return left, right, x1, y1, x2, y2, x1
    if step == 1:
        return left, right, x1, y1, x2, y2, x2
    if y1 < y2:
        section = left + x2 - x1
        return left, x2, section, y1, x1, y1, section
    section = x1 + right - x2
    return x1, right, x2, y2, section, y2, section
