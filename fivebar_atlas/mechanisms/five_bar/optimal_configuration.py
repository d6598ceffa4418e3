"""The optimal configuration of Le, Kang and Doan (2013), Eqs. 21 and 22.

In their notation l1 and l2 are the actuated and the distal links and l0 is half the distance of
the base joints: l0 = r3, l1 = r1, l2 = r2. With l0 = (l2 - l1)/√2 and the output point at
(0, (l1 + l2)/√2) the cranks stand at 135 and 45 degrees, both elbow angles and the angle between
the distal links are right angles, and the LCI is 1.
"""

from __future__ import annotations

import math

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.planar import OptimalConfiguration

#: The mode pair that the configuration belongs to: elbows outward, above the base.
MODE = "+-/up"
#: Ratio of links beyond which one of them is nothing beside the others.
LARGEST_RATIO = 1e6


def optimal_configuration(ratio: float) -> OptimalConfiguration:
    """Return the optimal configuration for a ratio of links, in lengths of the actuated link.

    Parameters
    ----------
    ratio
        ρ = l2/l1, at least 1: below, the base would have a negative length.

    Raises
    ------
    InputError
        If the ratio is below 1, above 1e6, or not a number.
    """
    if not 1.0 <= ratio <= LARGEST_RATIO:
        allowed = (
            f"a ratio l2/l1 of at least 1, for l0 = (l2 - l1)/√2, and at most {LARGEST_RATIO:g}"
        )
        raise InputError("ρ", ratio, allowed)
    return OptimalConfiguration(
        lengths=(1.0, ratio, math.sqrt(0.5) * (ratio - 1.0)),
        output=(0.0, math.sqrt(0.5) * (ratio + 1.0)),
        mode=MODE,
    )
