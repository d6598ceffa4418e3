"""Motions of the pentapod: limb lengths, their derivatives and forces over time.

Wang et al. 2017: displacement by Eqs. 2-5, velocities by Eqs. 8-10, accelerations by Eqs. 13-15,
active and constraint forces by Eq. 16. The constraint of the fifth limb, which the paper does not
write down, is that of :mod:`kinematics`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from fivebar_atlas.errors import InputError, MotionError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray
from fivebar_atlas.mechanisms.motions import (
    Column,
    Coordinate,
    Load,
    Motion,
    MotionFunction,
    MotionLimits,
    SolvedMotion,
    Units,
)
from fivebar_atlas.mechanisms.pentapod.geometry import LIMBS, PentapodGeometry
from fivebar_atlas.mechanisms.pentapod.jacobian import (
    jacobian_of,
    quadratic_terms_of,
    without_unit,
)
from fivebar_atlas.mechanisms.pentapod.kinematics import (
    COORDINATES,
    Limbs,
    limbs,
    nearest_valid_pose,
    residual,
    solve_constraint,
)
from fivebar_atlas.mechanisms.pentapod.rotations import (
    angular_acceleration,
    angular_velocity,
    rotation_matrices,
)
from fivebar_atlas.mechanisms.pentapod.singularity import (
    RANK_TOLERANCE,
    Dependency,
    FreeMotion,
    singularity,
)

#: Names of the groups of columns, in the order of Fig. 2 (a)-(f); then the load and the indices.
DISPLACEMENTS = "displacements"
ANGLES = "angles"
LENGTHS = "limb lengths"
VELOCITIES = "limb velocities"
ACCELERATIONS = "limb accelerations"
FORCES = "active and constraint forces"
LOAD = "load"
INDICES = "indices"

#: Residual of the constraint, as a share of the size of the geometry, that a pose may have where
#: nothing is said.
TOLERANCE = 1e-6

_SYMBOLS = ("$X$", "$Y$", "$Z$", r"$\alpha$", r"$\beta$", r"$\gamma$")
_PHRASES = (
    "X of the platform's origin p in base axes",
    "Y of the platform's origin p in base axes",
    "Z of the platform's origin p in base axes",
    "turn α of the platform about Z",
    "turn β of the platform about the turned Y",
    "turn γ of the platform about the twice turned X",
)
_LOAD_NAMES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")

# Limbs shorter than this share of the size have no direction.
_SHORT = 1e-13
# A coordinate is not determined where the constraint's derivative by it is a smaller share of
# what it can be.
_LEVEL = 1e-9
# Characteristic lengths farther from that of the platform than this factor say nothing.
_FARTHEST_LENGTH = 1e6
# The least LCI between samples is closed in on: places a round, and rounds.
_PLACES, _ROUNDS = 41, 3
_BISECTIONS = 60


@dataclasses.dataclass(frozen=True, eq=False)
class _Postures:
    """What follows from poses: p, R, the limbs and G for twists (v, L ω)."""

    positions: FloatArray
    rotations: FloatArray
    limbs: Limbs
    scaled: FloatArray


class PentapodMotionSolver:
    """One pentapod that moves.

    Parameters
    ----------
    geometry
        The joints.
    characteristic_length
        L, for LCI and least singular value.
    units
        Names of the units.

    Raises
    ------
    InputError
        If L is a million times larger or smaller than the platform.
    """

    coordinates = tuple(
        Coordinate(name, symbol, number >= 3, phrase)
        for number, (name, symbol, phrase) in enumerate(
            zip(COORDINATES, _SYMBOLS, _PHRASES, strict=True)
        )
    )
    limb_count = LIMBS

    def __init__(
        self, geometry: PentapodGeometry, characteristic_length: float, units: Units
    ) -> None:
        radius = geometry.platform_radius
        least, greatest = radius / _FARTHEST_LENGTH, radius * _FARTHEST_LENGTH
        if not least <= characteristic_length <= greatest:
            allowed = f"a length from {least:g} to {greatest:g}"
            raise InputError("characteristic_length", characteristic_length, allowed)
        self.geometry = geometry
        self.characteristic_length = characteristic_length
        self.units = units

    def description(self) -> str:
        """Return the distances of the joints from the origins, and n6, in a line."""
        radii = []
        for symbol, joints in (("A", self.geometry.base), ("B", self.geometry.platform)):
            away = np.linalg.norm(joints, axis=1)
            low, high = (f"{value:.6g}" for value in (away.min(), away.max()))
            span = low if low == high else f"{low} to {high}"
            radii.append(f"{symbol}_i {span} {self.units.length} from the origin")
        axis = ", ".join(f"{value + 0.0:.4f}" for value in self.geometry.axis)
        length = f"L = {self.characteristic_length:.6g} {self.units.length}"
        return f"{'; '.join(radii)}; n6 = ({axis}); {length}"

    def completed(self, motion: Motion, solve: str, start: float) -> Motion:
        """Return a motion with one coordinate solved for; see :class:`MotionSolver`.

        The constraint is linear in a coordinate of p. In an angle it has up to two solutions:
        the one near ``start`` in the first pose is followed. As long as they do not meet, the
        sign of the constraint's derivative tells them apart.
        """
        column = COORDINATES.index(solve)
        values, rates, accelerations = (
            each.copy() for each in (motion.values, motion.rates, motion.accelerations)
        )
        values[:, column] = start
        solutions = solve_constraint(self.geometry, values, solve)
        free = np.flatnonzero(solutions.free)
        if len(free):
            self._fail(
                motion, int(free[0]), f"the constraint of limb {LIMBS} holds for every {solve}"
            )
        none = np.flatnonzero(solutions.count == 0)
        if len(none):
            number = int(none[0])
            gap = self._least_gap(values[number], column)
            self._fail(
                motion,
                number,
                f"no {solve} keeps the constraint of limb {LIMBS}, (A_5 - B_5)·n6 = 0: it is "
                f"{gap:.6g} {self.units.length} apart at best, in {len(none)} of {len(motion)} "
                "samples",
            )
        candidates = solutions.poses
        slopes = self._gradient(candidates)[..., column]
        way = math.copysign(1.0, float(slopes[0, 0]))
        with np.errstate(invalid="ignore"):
            chosen = np.argmax(slopes * way > 0.0, axis=-1)
        rows = np.arange(len(motion))
        slope = slopes[rows, chosen]
        reach = self.geometry.size if column >= 3 else 1.0
        lost = np.flatnonzero(~(slope * way > _LEVEL * reach))
        if len(lost):
            self._fail(
                motion,
                int(lost[0]),
                f"{solve} is not determined by the constraint of limb {LIMBS} there, so that it "
                "cannot go on continuously; solve for another coordinate",
            )
        found = candidates[rows, chosen, column]
        values[:, column] = np.unwrap(found) if column >= 3 else found
        gradient = self._gradient(values)
        rates[:, column] = 0.0
        rates[:, column] = -np.sum(gradient * rates, axis=-1) / slope
        accelerations[:, column] = 0.0
        rest = self._constraint_acceleration(values, rates, accelerations)
        accelerations[:, column] = -rest / slope
        return Motion(motion.times, values, rates, accelerations)

    def check_constraint(self, motion: Motion, tolerance: float | None) -> None:
        """Raise MotionError at the worst pose that the revolute joint does not allow."""
        allowed = TOLERANCE * self.geometry.size if tolerance is None else tolerance
        gaps = residual(
            self.geometry, motion.values[:, :3], rotation_matrices(motion.values[:, 3:])
        )
        torn = np.flatnonzero(np.abs(gaps) > allowed)
        if not len(torn):
            return
        first, worst = int(torn[0]), int(np.argmax(np.abs(gaps)))
        unit = self.units.length
        nearest = nearest_valid_pose(
            self.geometry, motion.values[first], self.characteristic_length
        )
        self._fail(
            motion,
            first,
            f"the pose breaks the constraint of limb {LIMBS}: (A_5 - B_5)·n6 = {gaps[first]:.6g} "
            f"{unit}, and {allowed:.3g} {unit} is tolerated; the nearest pose that keeps it is "
            f"{self._pose_text(nearest)}; {len(torn)} of {len(motion)} samples break it, the worst "
            f"by {abs(gaps[worst]):.6g} {unit} at {self._when(motion.times[worst])}",
        )

    def solved(
        self, motion: Motion, load: Load, limits: MotionLimits, between: MotionFunction
    ) -> SolvedMotion:
        """Return what the limbs do and bear; see :class:`MotionSolver`."""
        postures = self._postures(motion)
        sizes = np.linalg.svd(postures.scaled, compute_uv=False)
        lci: FloatArray = sizes[:, -1] / sizes[:, 0]
        determinants = np.linalg.det(postures.scaled)
        least_time, least_lci = self._check_regular(motion, lci, determinants, between)
        self._check_limits(motion, postures, limits)
        length = self.characteristic_length
        twists = self._twists(motion)
        units = np.repeat([1.0, length], 3)
        rates = _times(postures.scaled, twists * units)
        turns = angular_acceleration(
            motion.values[:, 3:], motion.rates[:, 3:], motion.accelerations[:, 3:]
        )
        accelerations = np.concatenate([motion.accelerations[:, :3], length * turns], axis=1)
        second = _times(postures.scaled, accelerations) + quadratic_terms_of(
            self.geometry, postures.positions, postures.rotations, postures.limbs, twists
        )
        wrenches = _at_origin(load, postures.rotations)
        right = -wrenches / units
        forces = np.linalg.solve(np.swapaxes(postures.scaled, -1, -2), right[..., None])[..., 0]
        columns = [
            *self._pose_columns(motion),
            *self._limb_columns("l", "l", LENGTHS, "length of limb", "", postures.limbs.lengths),
            *self._limb_columns("v", r"\dot l", VELOCITIES, "velocity of limb", "/{time}", rates),
            *self._limb_columns(
                "a", r"\ddot l", ACCELERATIONS, "acceleration of limb", "/{time}²", second
            ),
            *self._force_columns(forces),
            *self._load_columns(wrenches),
            Column("lci", r"$1/\kappa$", "1", "local conditioning index", INDICES, lci),
            Column(
                "least_singular_value",
                r"$\sigma_6$",
                "1",
                "least singular value of G with its last three columns over L",
                INDICES,
                np.ascontiguousarray(sizes[:, -1], dtype=np.float64),
            ),
        ]
        facts = {
            "characteristic_length": length,
            "determinant_sign": float(np.sign(determinants[0])),
            "least_lci": least_lci,
            "least_lci_time": least_time,
        }
        return SolvedMotion(motion.times, tuple(columns), self.units, facts)

    def _postures(self, motion: Motion) -> _Postures:
        """Return what follows from poses; refuse those in which a limb has no length."""
        positions, rotations = motion.values[:, :3], rotation_matrices(motion.values[:, 3:])
        found = limbs(self.geometry, positions, rotations)
        short = np.argwhere(found.lengths <= _SHORT * self.geometry.size)
        if len(short):
            number, limb = (int(part) for part in short[0])
            self._fail(motion, number, f"limb {limb + 1} has no length: A and B are in one place")
        rows = jacobian_of(self.geometry, positions, rotations, found)
        return _Postures(
            positions, rotations, found, without_unit(rows, self.characteristic_length)
        )

    def _twists(self, motion: Motion) -> FloatArray:
        """Return (v, ω)."""
        turns = angular_velocity(motion.values[:, 3:], motion.rates[:, 3:])
        return np.concatenate([motion.rates[:, :3], turns], axis=1)

    def _gradient(self, poses: FloatArray) -> FloatArray:
        """Return less the derivatives of the constraint by the coordinates, shape (..., 6)."""
        rotations = rotation_matrices(poses[..., 3:])
        axis = rotations @ self.geometry.axis
        moment = np.cross(self.geometry.base[-1] - poses[..., :3], axis)
        ours = [axis[..., number] for number in range(3)]
        for number in range(3):
            rates = np.zeros(3)
            rates[number] = 1.0
            turn = angular_velocity(poses[..., 3:], np.broadcast_to(rates, poses[..., 3:].shape))
            ours.append(np.sum(moment * turn, axis=-1))
        return np.stack(ours, axis=-1)

    def _constraint_acceleration(
        self, values: FloatArray, rates: FloatArray, accelerations: FloatArray
    ) -> FloatArray:
        """Return less the second derivative of the constraint by time, shape (n,)."""
        positions, rotations = values[:, :3], rotation_matrices(values[:, 3:])
        found = limbs(self.geometry, positions, rotations)
        row = jacobian_of(self.geometry, positions, rotations, found)[:, -1]
        twists = np.concatenate(
            [rates[:, :3], angular_velocity(values[:, 3:], rates[:, 3:])], axis=1
        )
        turns = angular_acceleration(values[:, 3:], rates[:, 3:], accelerations[:, 3:])
        second = np.concatenate([accelerations[:, :3], turns], axis=1)
        terms = quadratic_terms_of(self.geometry, positions, rotations, found, twists)
        rest: FloatArray = np.sum(row * second, axis=-1) + terms[:, -1]
        return rest

    def _least_gap(self, pose: FloatArray, column: int) -> float:
        """Return the least |(A_5 - B_5)·n6| over all values of one coordinate."""
        tried = np.repeat(pose[None], 3601, axis=0)
        if column >= 3:
            tried[:, column] = np.linspace(-math.pi, math.pi, len(tried))
        gaps = residual(self.geometry, tried[:, :3], rotation_matrices(tried[:, 3:]))
        return float(np.abs(gaps).min())

    def _check_regular(
        self, motion: Motion, lci: FloatArray, determinants: FloatArray, between: MotionFunction
    ) -> tuple[float, float]:
        """Refuse singular poses, between samples too; return when LCI is least, and that LCI."""
        singular = lci <= RANK_TOLERANCE
        first = len(motion)
        if singular.any():
            first = int(np.argmax(singular))
        changes = np.flatnonzero(np.sign(determinants[1:]) * np.sign(determinants[:-1]) < 0.0)
        if len(changes) and int(changes[0]) + 1 <= first:
            place = int(changes[0])
            time = self._root(motion, place, determinants, between)
            self._fail_singular(
                between(np.array([time])), f"between samples {place} and {place + 1}"
            )
        if first < len(motion):
            self._fail_singular(motion.taken([first]), f"sample {first}")
        return self._least_between(motion, lci, between)

    def _root(
        self, motion: Motion, place: int, determinants: FloatArray, between: MotionFunction
    ) -> float:
        """Return when det G is 0 between two samples."""
        low, high = float(motion.times[place]), float(motion.times[place + 1])
        start = determinants[place]
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            value = np.linalg.det(self._postures(between(np.array([middle]))).scaled)[0]
            low, high = (middle, high) if value * start > 0.0 else (low, middle)
        return 0.5 * (low + high)

    def _least_between(
        self, motion: Motion, lci: FloatArray, between: MotionFunction
    ) -> tuple[float, float]:
        """Return when LCI is least next to the sample where it is least, and what it is there."""
        place = int(np.argmin(lci))
        least, when = float(lci[place]), float(motion.times[place])
        low = float(motion.times[max(place - 1, 0)])
        high = float(motion.times[min(place + 1, len(motion) - 1)])
        for _ in range(_ROUNDS):
            times = np.linspace(low, high, _PLACES)
            sizes = np.linalg.svd(self._postures(between(times)).scaled, compute_uv=False)
            values = sizes[:, -1] / sizes[:, 0]
            best = int(np.argmin(values))
            if values[best] < least:
                least, when = float(values[best]), float(times[best])
            low, high = float(times[max(best - 1, 0)]), float(times[min(best + 1, _PLACES - 1)])
        if least <= RANK_TOLERANCE:
            self._fail_singular(between(np.array([when])), f"next to sample {place}")
        return when, least

    def _fail_singular(self, motion: Motion, where: str) -> None:
        """Raise the error that says when a pose is singular, and how."""
        # A root of det G is only so precise: what the last singular value is taken for 0 by
        found = singularity(
            self.geometry, motion.values[0], self.characteristic_length, math.sqrt(RANK_TOLERANCE)
        )
        depends = {
            Dependency.LIMBS: "the forces of the five limbs depend on each other",
            Dependency.CONSTRAINT: "the limbs' forces can make up the constraint force",
        }.get(Dependency(int(found.dependency)), "det G = 0")
        free = {
            FreeMotion.ROTATION: "turn about a line",
            FreeMotion.TRANSLATION: "move along a line",
            FreeMotion.SCREW: "move as a screw",
        }.get(FreeMotion(int(found.free_motion)), "move in several ways")
        time = float(motion.times[0])
        raise MotionError(
            f"the motion goes through a singular pose at {self._when(time)} ({where}): "
            f"{self._pose_text(motion.values[0])}; {depends}, and the platform can {free} with all "
            "limbs locked",
            time,
        )

    def _check_limits(self, motion: Motion, postures: _Postures, limits: MotionLimits) -> None:
        """Raise MotionError where strokes or joint angles are exceeded."""
        lengths = postures.limbs.lengths
        unit = self.units.length
        faults: list[tuple[int, str]] = []
        for limb in range(LIMBS):
            for bounds, way, words in (
                (limits.least_lengths, -1.0, ("shorter", "least")),
                (limits.greatest_lengths, 1.0, ("longer", "greatest")),
            ):
                if bounds is None:
                    continue
                excess = way * (lengths[:, limb] - bounds[limb])
                faults += self._fault(
                    motion,
                    excess > 0.0,
                    excess,
                    f"limb {limb + 1} is {words[0]} than its {words[1]} length "
                    f"{bounds[limb]:.6g} {unit}",
                    lambda row, limb=limb: f"{lengths[row, limb]:.6g} {unit}",  # type: ignore[misc]
                )
        own = postures.limbs.directions @ postures.rotations
        for name, directions, limit in (
            ("base", postures.limbs.directions, limits.base_joint_limit),
            ("platform", own, limits.platform_joint_limit),
        ):
            if limit is None:
                continue
            chords = np.linalg.norm(directions - directions[0], axis=-1)
            angles = 2.0 * np.arcsin(np.minimum(0.5 * chords, 1.0))
            for limb in range(LIMBS):
                faults += self._fault(
                    motion,
                    angles[:, limb] > limit,
                    angles[:, limb],
                    f"limb {limb + 1} is turned from its first direction in the {name} by more "
                    f"than {math.degrees(limit):.6g} deg",
                    lambda row, angles=angles, limb=limb: (  # type: ignore[misc]
                        f"{math.degrees(angles[row, limb]):.6g} deg"
                    ),
                )
        if faults:
            faults.sort(key=lambda fault: fault[0])
            first = float(motion.times[faults[0][0]])
            raise MotionError("; ".join(text for _, text in faults), first)

    def _fault(
        self,
        motion: Motion,
        over: BoolArray,
        excess: FloatArray,
        what: str,
        shown: Callable[[int], str],
    ) -> list[tuple[int, str]]:
        """Return the first sample and the words for a limit, none where it is kept."""
        rows = np.flatnonzero(over)
        if not len(rows):
            return []
        first, last, worst = int(rows[0]), int(rows[-1]), int(np.argmax(excess))
        text = (
            f"{what} in {len(rows)} of {len(motion)} samples, first at "
            f"{self._when(motion.times[first])} (sample {first}), last at "
            f"{self._when(motion.times[last])}, worst {shown(worst)} at "
            f"{self._when(motion.times[worst])}"
        )
        return [(first, text)]

    def _fail(self, motion: Motion, number: int, what: str) -> None:
        """Raise the error for one sample."""
        time = float(motion.times[number])
        raise MotionError(f"at {self._when(time)} (sample {number}): {what}", time)

    def _when(self, time: float) -> str:
        return f"t = {float(time):.6g} {self.units.time}"

    def _pose_text(self, pose: FloatArray) -> str:
        """Return a pose with names and units; what is rounding is 0."""
        rounding = _SHORT * np.repeat([self.geometry.size, 1.0], 3)
        pose = np.where(np.abs(pose) > rounding, pose, 0.0)
        shown = [*pose[:3], *np.degrees(pose[3:])]
        return ", ".join(
            f"{each.name} = {value + 0.0:.8g} {'deg' if each.is_angle else self.units.length}"
            for each, value in zip(self.coordinates, shown, strict=True)
        )

    def _pose_columns(self, motion: Motion) -> list[Column]:
        return [
            Column(
                each.name,
                each.symbol,
                "deg" if each.is_angle else self.units.length,
                each.long_name,
                ANGLES if each.is_angle else DISPLACEMENTS,
                np.degrees(values) if each.is_angle else values,
            )
            for each, values in zip(self.coordinates, motion.values.T, strict=True)
        ]

    def _limb_columns(
        self, name: str, symbol: str, group: str, phrase: str, by: str, values: FloatArray
    ) -> list[Column]:
        unit = self.units.length + by.format(time=self.units.time)
        return [
            Column(
                f"{name}{limb}",
                f"${symbol}_{limb}$",
                unit,
                f"{phrase} {limb}",
                group,
                np.ascontiguousarray(values[:, limb - 1]),
            )
            for limb in range(1, LIMBS + 1)
        ]

    def _force_columns(self, forces: FloatArray) -> list[Column]:
        force = self.units.force
        active = [
            Column(
                f"F{limb}",
                f"$F_{limb}$",
                force,
                f"active force of limb {limb} on the platform, positive where it pushes",
                FORCES,
                np.ascontiguousarray(forces[:, limb - 1]),
            )
            for limb in range(1, LIMBS + 1)
        ]
        constraint = Column(
            "F_tau",
            r"$F_\tau$",
            force,
            f"constraint force of limb {LIMBS} on the platform along n6, through A_{LIMBS}",
            FORCES,
            np.ascontiguousarray(forces[:, LIMBS]),
        )
        return [*active, constraint]

    def _load_columns(self, wrenches: FloatArray) -> list[Column]:
        return [
            Column(
                name,
                f"${name[-2]}_{name[-1].upper()}$",
                self.units.force if number < 3 else self.units.moment,
                f"{'force' if number < 3 else 'moment about p'} on the platform along "
                f"{name[-1].upper()} of the base",
                LOAD,
                np.ascontiguousarray(wrenches[:, number]),
            )
            for number, name in enumerate(_LOAD_NAMES)
        ]


def _at_origin(load: Load, rotations: FloatArray) -> FloatArray:
    """Return force and moment about p in base axes, shape (n, 6)."""
    force, moment = load.wrenches[:, :3], load.wrenches[:, 3:]
    if load.turns_with_body:
        force, moment = _times(rotations, force), _times(rotations, moment)
    arm = rotations @ np.array(load.point)
    return np.concatenate([force, moment + np.cross(arm, force)], axis=1)


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    product: FloatArray = (matrices @ vectors[..., None])[..., 0]
    return product
