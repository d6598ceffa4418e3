"""What an atlas of the pentapod assumes beyond r_a and r_b: geometry, pose box, limits.

Lengths are in units of the home height H, so designs are pairs (r_a, r_b) with H = 1. The home pose
is p = (0, 0, H) with parallel axes, in which the motion of Wang et al. (2017) begins.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.pentapod.geometry import PentapodGeometry
from fivebar_atlas.mechanisms.settings import Options, SweepOption

#: Home pose (X, Y, Z, α, β, γ) with H = 1.
HOME = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)

# Coordinates of a pose with their unit, and what an atlas takes for their ranges.
_BOX = (
    ("x", "H", -0.25, 0.25),
    ("y", "H", -0.25, 0.25),
    ("z", "H", 0.85, 1.15),
    ("alpha", "deg", -30.0, 30.0),
    ("beta", "deg", -20.0, 20.0),
    ("gamma", "deg", -20.0, 20.0),
)
_PHRASES = {"x": "X", "y": "Y", "z": "Z", "alpha": "α", "beta": "β", "gamma": "γ"}
# Farthest that a position may be from the base, in units of H.
_FARTHEST = 10.0


def _range_options(name: str, unit: str, least: float, greatest: float) -> tuple[SweepOption, ...]:
    """Return the two options for the range of a coordinate of the pose box."""
    # β = ±90 deg makes α and γ one
    bounds = {"alpha": 180.0, "beta": 89.0, "gamma": 180.0}
    bound = bounds.get(name, _FARTHEST)
    low = 1e-3 if name == "z" else -bound
    phrase = _PHRASES[name]
    return (
        SweepOption(f"{name}_min", unit, f"least {phrase} of the pose box", least, low, bound),
        SweepOption(
            f"{name}_max", unit, f"greatest {phrase} of the pose box", greatest, low, bound
        ),
    )


#: Sweep options of the pentapod.
OPTIONS = (
    SweepOption("position_angle", "deg", "position angle φ of B_1", 36.0, -180.0, 180.0),
    SweepOption("base_angle", "deg", "angle of A_2 from the X axis", 45.0, -180.0, 180.0),
    SweepOption("offset", "r_a", "offset W of A_1 = (W, 0, 0)", 1.0, -10.0, 10.0),
    SweepOption(
        "axis_angle",
        "deg",
        "turn of n6 about limb 5 at home, from where it is parallel to the base",
        0.0,
        -180.0,
        180.0,
    ),
    SweepOption("characteristic_length", "H", "characteristic length L", 0.25, 1e-3, 1e3),
    SweepOption(
        "platform_radius_as_length",
        "1",
        "whether L is r_b of each design instead",
        False,
    ),
    *(option for each in _BOX for option in _range_options(*each)),
    SweepOption(
        "limb_min", "1", "least length of a limb, as a share of its length at home", 0.7, 0.0, 1.0
    ),
    SweepOption(
        "limb_max", "1", "greatest length of a limb, as a share of that at home", 1.3, 1.0, 100.0
    ),
    SweepOption(
        "base_joint_limit", "deg", "largest turn of n_i from home, in the base", 45.0, 1.0, 180.0
    ),
    SweepOption(
        "platform_joint_limit",
        "deg",
        "largest turn of n_i from home, in the platform",
        45.0,
        1.0,
        180.0,
    ),
)


@dataclasses.dataclass(frozen=True, slots=True)
class AtlasOptions:
    """The sweep options in the units of computations: lengths in H, angles in radians.

    Attributes
    ----------
    position_angle, base_angle, axis_angle
        Angles of the geometry.
    offset
        W as a share of r_a.
    characteristic_length
        L; None where it is r_b.
    box_least, box_greatest
        Ranges of X, Y, Z, α, β, γ; that of α bounds the angle that is solved for.
    limb_min, limb_max
        Range of limb lengths as shares of those at home.
    base_joint_limit, platform_joint_limit
        Largest angles between n_i and its direction at home, in base and in platform axes.
    """

    position_angle: float
    base_angle: float
    axis_angle: float
    offset: float
    characteristic_length: float | None
    box_least: tuple[float, ...]
    box_greatest: tuple[float, ...]
    limb_min: float
    limb_max: float
    base_joint_limit: float
    platform_joint_limit: float

    @classmethod
    def chosen(cls, options: Options) -> AtlasOptions:
        """Return complete sweep options in the units of computations.

        Parameters
        ----------
        options
            All of :data:`OPTIONS`, checked one by one.

        Raises
        ------
        InputError
            If the least value of a coordinate is above its greatest.
        """
        values = {name: float(value) for name, value in options}
        for name, *_ in _BOX:
            least, greatest = values[f"{name}_min"], values[f"{name}_max"]
            if least > greatest:
                raise InputError(f"{name}_min", least, f"a number up to {name}_max, {greatest:g}")
        scales = [math.radians(1.0) if unit == "deg" else 1.0 for _, unit, _, _ in _BOX]
        box = zip((name for name, *_ in _BOX), scales, strict=True)
        ranges = [(k * values[f"{name}_min"], k * values[f"{name}_max"]) for name, k in box]
        own_length = bool(values["platform_radius_as_length"])
        return cls(
            position_angle=math.radians(values["position_angle"]),
            base_angle=math.radians(values["base_angle"]),
            axis_angle=math.radians(values["axis_angle"]),
            offset=values["offset"],
            characteristic_length=None if own_length else values["characteristic_length"],
            box_least=tuple(least for least, _ in ranges),
            box_greatest=tuple(greatest for _, greatest in ranges),
            limb_min=values["limb_min"],
            limb_max=values["limb_max"],
            base_joint_limit=math.radians(values["base_joint_limit"]),
            platform_joint_limit=math.radians(values["platform_joint_limit"]),
        )

    def length(self, r_b: float) -> float:
        """Return the characteristic length of a design."""
        return r_b if self.characteristic_length is None else self.characteristic_length

    def geometry(self, r_a: float, r_b: float) -> PentapodGeometry:
        """Return the joints of a design.

        Raises
        ------
        InputError
            If they make no pentapod, as where A_1 is at one of the others.
        """
        level = PentapodGeometry.from_radii(
            r_a, r_b, self.position_angle, self.offset * r_a, base_angle=self.base_angle
        )
        if self.axis_angle == 0.0:
            return level
        limb = np.array(HOME[:3]) + level.platform[-1] - level.base[-1]
        limb /= np.linalg.norm(limb)
        # n6 is perpendicular to the limb at home, so that the turn is in a plane
        axis = math.cos(self.axis_angle) * level.axis + math.sin(self.axis_angle) * np.cross(
            limb, level.axis
        )
        return PentapodGeometry(level.base, level.platform, axis)


def home_pose() -> FloatArray:
    """Return the home pose, shape (6,)."""
    return np.array(HOME)
