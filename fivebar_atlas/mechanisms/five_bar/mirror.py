"""Mirror symmetry: eight mode pairs are three computations.

Mirroring y → -y takes (s1, s2) to (-s1, -s2) and up to down; mirroring x → -x, legs exchanged,
takes (s1, s2) to (-s2, -s1) and keeps up and down.
"""

from __future__ import annotations

#: s1, s2 and the sign of det B of the three classes: "+-"/up, "+-"/down and "++"/up.
CLASS_SIGNS = ((1.0, -1.0, 1.0), (1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
CLASSES = len(CLASS_SIGNS)


def canonical_class(s1: int, s2: int, assembly: int) -> tuple[int, bool, bool]:
    """Return the class of a mode pair and whether x and y are mirrored to reach it."""
    if s1 != s2:
        mirrored = s1 < 0
        return (0 if assembly * s1 > 0 else 1), False, mirrored
    mirror_y = assembly < 0
    # (+, +)/up is left as it is by no mirror and reached from (-, -)/up by x → -x
    mirror_x = (s1 < 0) != mirror_y
    return 2, mirror_x, mirror_y
