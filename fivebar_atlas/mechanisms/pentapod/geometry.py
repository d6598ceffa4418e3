"""The geometry of the pentapod: where its joints are (Wang et al. 2017, Sec. 2).

Five limbs A_i B_i of variable length: A_i is a spherical joint on the base; B_i is a spherical
joint on the platform for i = 1 ... 4 and a revolute joint for i = 5, whose axis n6 is fixed in the
platform. The fifth limb is perpendicular to that axis.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray

#: Number of limbs; the last is the one with the revolute joint.
LIMBS = 5

# Distances below this share of the platform or of the base are rounding.
_ROUNDING = 1e-12
# The mechanism of Sec. 2: links (platform, five cylinders, five rods, base), the freedoms of its
# joints (prismatic, spherical, revolute), and the spins of the SPS limbs about themselves.
_LINKS = 12
_JOINT_FREEDOMS = (1,) * 5 + (3,) * 9 + (1,)
_SPINS = 4


def mobility(
    links: int = _LINKS,
    joint_freedoms: tuple[int, ...] = _JOINT_FREEDOMS,
    common_constraints: int = 0,
    redundant_constraints: int = 0,
    redundant_freedoms: int = _SPINS,
) -> int:
    """Return the degrees of freedom by the revised Kutzbach-Grübler equation (Eq. 1).

    Parameters
    ----------
    links
        Number n of links, the base among them.
    joint_freedoms
        Freedoms f_i of each of the g joints.
    common_constraints
        λ, so that the order of the mechanism is d = 6 - λ.
    redundant_constraints
        ν.
    redundant_freedoms
        ζ, freedoms that do not move the platform.

    Returns
    -------
    int
        M = d (n - g - 1) + Σ f_i + ν - ζ. The defaults are those of the pentapod.
    """
    order = 6 - common_constraints
    closed = order * (links - len(joint_freedoms) - 1)
    return closed + sum(joint_freedoms) + redundant_constraints - redundant_freedoms


@dataclasses.dataclass(frozen=True, eq=False)
class PentapodGeometry:
    """The joints of a pentapod, in any unit of length.

    Joints need be on no circle and in no plane.

    Parameters
    ----------
    base
        A_i in the axes of the base O-XYZ, shape (5, 3).
    platform
        B_i in the axes of the platform p-xyz, shape (5, 3).
    axis
        Direction n6 of the revolute joint at B_5 in the axes of the platform, shape (3,); it is
        made a unit vector.

    Raises
    ------
    InputError
        If a shape is not as above or a number is not finite; if two joints of the base or of the
        platform are in one place; if n6 has no length; or if every pose is singular because all
        A_i are in one line (the platform turns about it), or all B_i are in one line parallel to
        n6 (likewise). The error names the input.
    """

    base: FloatArray
    platform: FloatArray
    axis: FloatArray

    def __post_init__(self) -> None:
        base = _joints("base", self.base, "A")
        platform = _joints("platform", self.platform, "B")
        axis = _numbers("axis", self.axis, (3,))
        largest = float(np.abs(axis).max())
        if largest == 0.0:
            raise InputError("axis", _shown(axis), "a direction: a vector that has a length")
        axis = axis / largest  # a square neither overflows nor vanishes
        axis = axis / np.linalg.norm(axis)
        if _line(base) is not None:
            raise InputError("base", _shown(base), "joints A_i that are not all in one line")
        line = _line(platform)
        if line is not None and np.linalg.norm(np.cross(line, axis)) <= _ROUNDING:
            raise InputError(
                "platform", _shown(platform), "joints B_i that are not all in one line along n6"
            )
        for name, value in (("base", base), ("platform", platform), ("axis", axis)):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    @classmethod
    def from_radii(
        cls,
        r_a: float,
        r_b: float,
        position_angle: float = math.pi / 5.0,
        offset: float | None = None,
        *,
        base_angle: float = math.pi / 4.0,
        axis: npt.ArrayLike | None = None,
    ) -> PentapodGeometry:
        """Return the pentapod with joints on circles (Sec. 2 and Fig. 1).

        A_1 is (W, 0, 0) and A_2 ... A_5 are on the circle of radius r_a about O, a quarter turn
        apart; B_i are on the circle of radius r_b about p, a fifth of a turn apart, B_1 at the
        position angle φ. Both circles are in the planes Z = 0 and z = 0.

        The paper says that "the other four" joints are spread uniformly, which could also mean
        that all five are, with W = r_a. It cannot: then the limbs in the pose with parallel axes
        are lines of one regulus (of a cone if φ = 0), det G = 0 whatever φ is, and the forces of
        Fig. 2(f) would be infinite.

        Parameters
        ----------
        r_a, r_b
            Radii, above 0.
        position_angle
            φ in radians. Not given in the paper; by default half of the angle between B_i.
        offset
            W, with its sign. Not given in the paper; by default r_a.
        base_angle
            Angle of A_2 from the X axis in radians. Not given in the paper; by default 45 degrees,
            which makes the base symmetric about the X axis, with A_1 in the middle of a gap.
        axis
            n6 in the axes of the platform, shape (3,). Not given in the paper; by default in the
            plane of the platform and such that the pose with parallel axes and p on the Z axis,
            in which the paper's motion begins, is one that the joint allows: perpendicular to
            A_5 - B_5 there, at any height. Where these two are in one place, along the tangent of
            the circle of B_i.

        Returns
        -------
        PentapodGeometry
            The geometry, in the unit of the radii.

        Raises
        ------
        InputError
            If a radius is not above 0, an angle or the offset is not finite, or the joints are
            none that :class:`PentapodGeometry` takes, as where A_1 is at one of the others.
        """
        for name, value in (("r_a", r_a), ("r_b", r_b)):
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(name, value, "a length above 0")
        offset = r_a if offset is None else offset
        for name, value in (
            ("position_angle", position_angle),
            ("offset", offset),
            ("base_angle", base_angle),
        ):
            if not math.isfinite(value):
                raise InputError(name, value, "a finite number")
        base = np.zeros((LIMBS, 3))
        base[0, 0] = offset
        base[1:] = _circle(r_a, base_angle, 4)
        platform = _circle(r_b, position_angle, LIMBS)
        if axis is None:
            gap = base[-1] - platform[-1]
            if np.linalg.norm(gap) <= _ROUNDING * (r_a + r_b):
                gap = platform[-1]
            axis = np.array([-gap[1], gap[0], 0.0])
        return cls(base, platform, np.asarray(axis, dtype=np.float64))

    @property
    def size(self) -> float:
        """Length by which rounding is judged: the radii of base and platform about their means."""
        return float(_radii(self.base).max() + _radii(self.platform).max())

    @property
    def platform_radius(self) -> float:
        """Root mean square distance of B_i from their mean, a natural characteristic length."""
        return math.sqrt(float(np.mean(_radii(self.platform) ** 2)))

    def scaled(self, factor: float) -> PentapodGeometry:
        """Return the geometry with all lengths times a factor above 0."""
        if not (math.isfinite(factor) and factor > 0.0):
            raise InputError("factor", factor, "a number above 0")
        return PentapodGeometry(factor * self.base, factor * self.platform, self.axis)


def _circle(radius: float, start: float, count: int) -> FloatArray:
    """Return points at equal steps of a circle about the origin in the plane z = 0."""
    angles = start + 2.0 * math.pi / count * np.arange(count)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])


def _numbers(name: str, value: npt.ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return an own array of finite numbers of this shape."""
    numbers = "finite numbers, shape (" + ", ".join(map(str, shape)) + ("," * (len(shape) == 1))
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(name, value, numbers + ")") from None
    if array.shape != shape or not np.isfinite(array).all():
        raise InputError(name, array.tolist(), numbers + ")")
    return array


def _joints(name: str, value: npt.ArrayLike, symbol: str) -> FloatArray:
    """Return five finite points, no two of them in one place."""
    points = _numbers(name, value, (LIMBS, 3))
    gaps = np.linalg.norm(points[:, None] - points[None], axis=-1)
    apart = gaps > _ROUNDING * gaps.max()
    for one in range(LIMBS):
        for other in range(one + 1, LIMBS):
            if not apart[one, other]:
                where = f"joints {symbol}_{one + 1} and {symbol}_{other + 1} in different places"
                raise InputError(name, _shown(points), where)
    return points


def _line(points: FloatArray) -> FloatArray | None:
    """Return the direction of the line that all points are in, None where there is none."""
    _, sizes, directions = np.linalg.svd(points - points.mean(axis=0))
    line: FloatArray = directions[0]
    return line if sizes[1] <= _ROUNDING * sizes[0] else None


def _radii(points: FloatArray) -> FloatArray:
    radii: FloatArray = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return radii


def _shown(array: FloatArray) -> list[object]:
    """Return an array as it is written in a message."""
    shown: list[object] = array.tolist()
    return shown
