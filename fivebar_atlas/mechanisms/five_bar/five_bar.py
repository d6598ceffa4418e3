"""One symmetric five-bar manipulator, for scripts and notebooks."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.base import (
    DEFAULT_LCI_THRESHOLDS,
    DEFAULT_TOLERANCE,
    FloatArray,
    IntArray,
    SweepSettings,
)
from fivebar_atlas.mechanisms.five_bar import points
from fivebar_atlas.mechanisms.five_bar.design_space import SUB_REGIONS, normalise, sub_region
from fivebar_atlas.mechanisms.five_bar.mechanism import (
    ASSEMBLY_MODES,
    FiveBarMechanism,
    mode_signs,
)
from fivebar_atlas.mechanisms.five_bar.singularity import change_point_cases
from fivebar_atlas.mechanisms.five_bar.workspace import theoretical_area

_MECHANISM = FiveBarMechanism()
#: How far r1 + r2 + r3 may be from 3.
_SUM_SLACK = 1e-9


@dataclasses.dataclass(frozen=True)
class FiveBar:
    """A symmetric planar 5R parallel manipulator in non-dimensional form.

    A1 = (-r3, 0) and A2 = (r3, 0) are the base joints, r1 the actuated links A_iB_i and r2
    the distal links B_iP. Points and lengths are non-dimensional throughout; times
    ``dimensional_factor`` they are those of the machine. Points may be scalars or arrays,
    which broadcast; results have their shape, with NaN where P is out of reach.

    Mode pairs are written ``"+-/up"`` (or ``"pm/up"``): the sides of the two elbows and the
    sign of det B. Where only the elbows matter, ``"+-"`` will do.

    Parameters
    ----------
    r1, r2, r3
        Non-dimensional lengths, r1 + r2 + r3 = 3 (Liu, Wang and Zheng 2006, Eq. 30).
    dimensional_factor
        D of Eq. 28; 1 unless the manipulator was made from lengths.

    Raises
    ------
    InputError
        If a length is not positive (r3 may be 0) and finite, the sum is not 3, or the links
        are too short to be assembled.

    Examples
    --------
    >>> from fivebar_atlas import FiveBar
    >>> robot = FiveBar.from_lengths(26, 30, 16)
    >>> robot.dimensional_factor, robot.sub_region
    (24.0, 'Va')
    >>> round(float(robot.lci(0.0, 1.5, "+-")), 6)
    0.460911
    >>> values = robot.evaluate("+-/up", lci_thresholds=[0.5])
    >>> round(values["gci"], 4), values["status"]
    (0.3742, 'ok')
    """

    r1: float
    r2: float
    r3: float
    dimensional_factor: float = 1.0

    def __post_init__(self) -> None:
        lengths = (self.r1, self.r2, self.r3)
        normalise(lengths)
        if abs(sum(lengths) - 3.0) > _SUM_SLACK:
            raise InputError(
                "r1 + r2 + r3",
                sum(lengths),
                "a sum of 3; FiveBar.from_lengths scales lengths of any size",
            )

    @classmethod
    def from_lengths(cls, R1: float, R2: float, R3: float) -> FiveBar:
        """Return the manipulator with these lengths, in any one unit (Eqs. 28, 29).

        Raises
        ------
        InputError
            If a length is not positive (R3 may be 0) and finite, or the links are too short
            to be assembled.
        """
        design, factor = normalise((R1, R2, R3))
        r1, r2, r3 = (float(r) for r in design)
        return cls(r1, r2, r3, factor)

    @property
    def lengths(self) -> tuple[float, float, float]:
        """R1, R2, R3, the lengths times the dimensional factor."""
        factor = self.dimensional_factor
        return factor * self.r1, factor * self.r2, factor * self.r3

    @property
    def sub_region(self) -> str:
        """Sub-region of the design space: IVa, Va, Vb, IVb, or outside the surrounded space."""
        return SUB_REGIONS.describe(int(sub_region(self._design)[0]))

    @property
    def change_point_cases(self) -> str:
        """Letters (a) to (f) of the conditions for singularities of the third kind."""
        return change_point_cases(self.r1, self.r2, self.r3)

    @property
    def theoretical_workspace_area(self) -> float:
        """Area that both legs reach, in closed form."""
        return theoretical_area(self.r1, self.r2, self.r3)

    def inverse_kinematics(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return the input angles θ1, θ2 in radians, in (-π, π] (Eqs. 6, 7)."""
        flat, shape = _points(x, y)
        theta1, theta2 = np.empty_like(flat[0]), np.empty_like(flat[0])
        points.inverse_at(*self._lengths, *flat, *_working_mode(mode), theta1, theta2)
        return theta1.reshape(shape), theta2.reshape(shape)

    def forward_kinematics(
        self, theta1: npt.ArrayLike, theta2: npt.ArrayLike, assembly_mode: str = "up"
    ) -> tuple[FloatArray, FloatArray]:
        """Return P = (x, y) for input angles in radians (Eqs. 8 to 12).

        NaN where the linkage cannot be assembled, or P is free because B1 = B2.
        """
        flat, shape = _points(theta1, theta2)
        x, y = np.empty_like(flat[0]), np.empty_like(flat[0])
        points.forward_at(*self._lengths, *flat, _assembly_mode(assembly_mode), x, y)
        return x.reshape(shape), y.reshape(shape)

    def elbows(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return B1 and B2, each of shape (..., 2)."""
        flat, shape = _points(x, y)
        out = np.empty((len(flat[0]), 4))
        points.elbows_at(*self._lengths, *flat, *_working_mode(mode), out)
        return out[:, :2].reshape(*shape, 2), out[:, 2:].reshape(*shape, 2)

    def jacobian_matrices(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-"
    ) -> tuple[FloatArray, FloatArray]:
        """Return A and B of A θ' = B p' (Eqs. 15, 18, 19), each of shape (..., 2, 2)."""
        flat, shape = _points(x, y)
        out = np.empty((len(flat[0]), 6))
        points.matrices_at(*self._lengths, *flat, *_working_mode(mode), out)
        a = np.zeros((len(out), 2, 2))
        a[:, 0, 0], a[:, 1, 1] = out[:, 0], out[:, 1]
        return a.reshape(*shape, 2, 2), out[:, 2:].reshape(*shape, 2, 2)

    def jacobian(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return J = A⁻¹ B (Eq. 20), shape (..., 2, 2); infinite at serial singularities."""
        a, b = self.jacobian_matrices(x, y, mode)
        diagonal = np.diagonal(a, axis1=-2, axis2=-1)[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(b / diagonal)

    def lci(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return the local conditioning index σ_min/σ_max of J, 2-norm; 0 if singular."""
        flat, shape = _points(x, y)
        out = np.empty_like(flat[0])
        points.lci_at(*self._lengths, *flat, *_working_mode(mode), out)
        return out.reshape(shape)

    def assembly_mode(self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-") -> FloatArray:
        """Return the sign of det B: 1 up, -1 down, 0 parallel singular."""
        _, b = self.jacobian_matrices(x, y, mode)
        return np.asarray(np.sign(b[..., 0, 0] * b[..., 1, 1] - b[..., 0, 1] * b[..., 1, 0]))

    def singularity(
        self, x: npt.ArrayLike, y: npt.ArrayLike, mode: str = "+-", tolerance: float = 1e-9
    ) -> IntArray:
        """Return the kinds of singularity at points as bits (Sec. 4).

        1 and 2: leg 1 or 2 stretched or folded (first kind); 4: B1 and B2 coincide, 8: B1, P
        and B2 in line (second kind); a sum of both is of the third kind. 0 where regular,
        -1 where P is out of reach. ``tolerance`` bounds |sin β_i| and |sin γ|.
        """
        flat, shape = _points(x, y)
        out = np.empty(len(flat[0]), dtype=np.int64)
        points.singularity_at(*self._lengths, *flat, *_working_mode(mode), tolerance, out)
        return out.reshape(shape)

    def evaluate(
        self,
        mode: str = "+-/up",
        lci_thresholds: Sequence[float] = DEFAULT_LCI_THRESHOLDS,
        tolerance: float = DEFAULT_TOLERANCE,
    ) -> dict[str, Any]:
        """Return workspace areas, indices, inscribed circles and errors of one mode pair.

        Parameters
        ----------
        mode
            Mode pair.
        lci_thresholds
            Thresholds of good-condition workspaces, each in (0, 1).
        tolerance
            Relative tolerance of integrated values, 1e-10 to 1e-3.

        Returns
        -------
        dict
            The entries of a mode in ``atlas evaluate --json``, non-dimensional; None for
            what does not exist, explained by ``status``.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If a threshold or the tolerance is out of range.
        """
        thresholds = tuple(float(threshold) for threshold in lci_thresholds)
        _MECHANISM.check_thresholds(thresholds, "lci_thresholds")
        _MECHANISM.check_tolerance(tolerance, "tolerance")
        settings = SweepSettings(
            mechanism=_MECHANISM.name,
            space=_MECHANISM.spaces[0],
            resolution=_MECHANISM.resolution_range[0],
            modes=(_MECHANISM.parse_mode(mode),),
            lci_thresholds=thresholds,
            tolerance=tolerance,
        )
        results = _MECHANISM.evaluate(self._design, settings)
        document = _MECHANISM.document(self._design[0], self.dimensional_factor, settings, results)
        values: dict[str, Any] = document["modes"][0]
        return values

    @property
    def _lengths(self) -> tuple[float, float, float]:
        """Lengths as the kernels take them."""
        return float(self.r1), float(self.r2), float(self.r3)

    @property
    def _design(self) -> FloatArray:
        """The design as one row of a parameter array."""
        return np.array([self._lengths])


def _points(
    x: npt.ArrayLike, y: npt.ArrayLike
) -> tuple[tuple[FloatArray, FloatArray], tuple[int, ...]]:
    """Return two inputs as flat arrays of one length, and their broadcast shape."""
    wide = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
    return (np.ravel(wide[0]).copy(), np.ravel(wide[1]).copy()), wide[0].shape


def _working_mode(mode: str) -> tuple[float, float]:
    """Return the signs of a working mode, given alone or as part of a mode pair."""
    label = _MECHANISM.parse_mode(mode if "/" in mode else f"{mode}/up")
    s1, s2, _ = mode_signs(label)
    return float(s1), float(s2)


def _assembly_mode(mode: str) -> float:
    """Return the sign of an assembly mode, given alone or as part of a mode pair."""
    name = mode.rpartition("/")[2].strip().lower()
    if name not in ASSEMBLY_MODES.meanings:
        raise UnknownNameError("assembly_mode", mode, ASSEMBLY_MODES.meanings)
    return float(ASSEMBLY_MODES.values[ASSEMBLY_MODES.meanings.index(name)])
