"""What the pentapod offers to sweeps, files, figures and commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.mechanisms.motions import MotionSolver, Units
from fivebar_atlas.mechanisms.pentapod import design_space
from fivebar_atlas.mechanisms.pentapod.atlas_options import OPTIONS, AtlasOptions
from fivebar_atlas.mechanisms.pentapod.motion import PentapodMotionSolver
from fivebar_atlas.mechanisms.pentapod.motion_geometry import geometry_from_table
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    THRESHOLD,
    Axis,
    AxisColumn,
    Flags,
    Parameter,
    Quantity,
)
from fivebar_atlas.mechanisms.settings import Options, SweepSettings

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.spatial import SpatialDesign

#: The only mode: poses without a singular one between them and home, as far as a sign tells.
HOME_ASSEMBLY = "home"

#: Why a value is not a number, or not as accurate as asked for.
STATUS = Flags(
    values=(1, 2, 4, 8, 16),
    meanings=(
        "no_usable_pose",
        "degenerate_design",
        "gci_tolerance_not_reached",
        "share_tolerance_not_reached",
        "singular_poses",
    ),
    masks=True,
)

#: Range of the dimensional factor D; volumes, which scale with its cube, stay finite.
FACTOR_RANGE = (1e-100, 1e100)


class PentapodMechanism(Mechanism):
    """The 5-DOF manipulator with four SPS limbs and one SPR limb."""

    name = "pentapod"
    title = "5-DOF parallel manipulator with four SPS limbs and one SPR limb (pentapod)"
    source = "Wang et al. 2017, ICIC Express Letters 11"
    parameters = (
        Parameter("r_a", "$r_a$", "1", "radius of the base joints"),
        Parameter("r_b", "$r_b$", "1", "radius of the platform joints"),
    )
    lengths = (Parameter("H", "$H$", "1", "height of the platform at home"), *parameters)
    proportions = lengths
    factor_phrase = "H"
    design_phrase = "H = 1"
    quantities = (
        Quantity(
            "gci",
            "GCI",
            "1",
            "global conditioning index",
            has_error=True,
        ),
        Quantity(
            "mean_least_singular_value",
            r"$\bar\sigma_6$",
            "1",
            "mean of the least singular value of G",
            has_error=True,
        ),
        Quantity(
            "usable_share",
            "$w$",
            "1",
            "usable share of the pose box",
            has_error=True,
        ),
        Quantity(
            "workspace_volume",
            "$V$",
            "1",
            "workspace volume at the fixed orientation β = γ = 0",
            has_error=True,
            length_power=3,
        ),
        Quantity(
            "least_singular_value",
            r"$\sigma_{6,\min}$",
            "1",
            "least singular value of G over the usable poses, found by search",
        ),
        Quantity(
            "largest_limb_force",
            r"$F_{\max}$",
            "1",
            "largest limb force for a unit wrench over the usable poses, found by search",
        ),
        Quantity(
            "home_lci",
            r"$(1/\kappa)_0$",
            "1",
            "local conditioning index at home",
            ignores_tolerance=True,
        ),
        Quantity(
            "home_least_singular_value",
            r"$\sigma_{6,0}$",
            "1",
            "least singular value of G at home",
            ignores_tolerance=True,
        ),
        Quantity(
            "home_largest_limb_force",
            "$F_0$",
            "1",
            "largest limb force for a unit wrench at home",
            ignores_tolerance=True,
        ),
        Quantity("status", "status", "1", "status of the computed values", flags=STATUS),
        Quantity(
            "good_condition_share",
            "$w_g$",
            "1",
            "good-condition share of the pose box",
            (DESIGN, THRESHOLD),
            has_error=True,
        ),
        Quantity(
            "good_condition_gci",
            r"GCI$_g$",
            "1",
            "global conditioning index of the good-condition poses",
            (DESIGN, THRESHOLD),
            has_error=True,
        ),
    )
    modes = (HOME_ASSEMBLY,)
    mode_phrase = "mode"
    usable_phrase = "usable pose"
    region_quantities = ("usable_share", "gci")
    spaces = (design_space.RADII,)
    resolution_range = (2, 1000)
    default_resolution = 40
    tolerance_range = (1e-5, 1e-1)
    default_tolerance = 1e-3
    # means over points: values of designs next to each other differ by their errors, too
    exact_tolerance = None
    exact_step = 1e-2
    # with the constraint's row in G no design has much more than 0.03
    default_lci_thresholds = (0.02,)
    # the points of integration
    computed_with = ("scipy",)
    options = OPTIONS

    def parse_mode(self, text: str) -> str:
        """Return ``"home"``, the only mode; raise UnknownNameError for any other."""
        if text.strip().lower() != HOME_ASSEMBLY:
            raise UnknownNameError("mode", text, self.modes)
        return HOME_ASSEMBLY

    def complete_options(
        self,
        given: Mapping[str, object] | Options = (),
        named: Callable[[str], str] = str,
    ) -> Options:
        """Return every sweep option; the ends of ranges must be in order, too.

        Raises
        ------
        UnknownNameError
            If there is no such option.
        InputError
            If a value has the wrong type or is out of range, or a least value is above its
            greatest.
        """
        options = super().complete_options(given, named)
        try:
            AtlasOptions.chosen(options)
        except InputError as error:
            least, values = error.name, dict(options)
            greatest = least.removesuffix("min") + "max"
            if least in dict(given) or greatest not in dict(given):
                raise error.renamed(named(least), error.value) from None
            allowed = f"a number of {least}, {values[least]:g}, or more"
            raise InputError(named(greatest), values[greatest], allowed) from None
        return options

    def lattice(self, space: str, resolution: int) -> FloatArray:  # noqa: ARG002
        """Return every design of the lattice; see :func:`design_space.lattice`."""
        return design_space.lattice(resolution)

    def triangles(self, space: str, resolution: int) -> IntArray:  # noqa: ARG002
        """Return the triangulation of the lattice; see :func:`design_space.triangles`."""
        return design_space.triangles(resolution)

    def axes(self, settings: SweepSettings) -> tuple[Axis, ...]:
        """Return the threshold axis: there is one mode only."""
        thresholds = settings.lci_thresholds
        column = AxisColumn(
            "lci_threshold",
            np.array(thresholds, dtype=np.float64),
            "1",
            "least local conditioning index of the good-condition poses",
        )
        return (Axis(THRESHOLD, tuple(f"{value!r}" for value in thresholds), (column,)),)

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Evaluate designs for every threshold of the settings."""
        # The kernels take numba along, which only those who compute should wait for.
        from fivebar_atlas.mechanisms.pentapod.evaluation import evaluate_designs

        return evaluate_designs(
            np.ascontiguousarray(parameters, dtype=np.float64),
            AtlasOptions.chosen(self.complete_options(settings.options)),
            np.array(settings.lci_thresholds, dtype=np.float64),
            settings.tolerance,
        )

    def motion_solver(
        self,
        geometry: Mapping[str, object],
        characteristic_length: float | None,
        units: Units,
        named: Callable[[str], str] = str,
    ) -> MotionSolver:
        """Return one pentapod that moves; L is its r_b where nothing is said.

        r_b of joints on no circle is the root mean square distance of B_i from their mean.
        """
        joints = geometry_from_table(geometry, named)
        length = joints.platform_radius if characteristic_length is None else characteristic_length
        return PentapodMotionSolver(joints, length, units)

    def are_designs(
        self,
        parameters: FloatArray,
        margin: float = 0.0,
        mode: str | None = None,  # noqa: ARG002
    ) -> BoolArray:
        """Return which designs have a base and a platform: radii above 0, and the margin."""
        return np.asarray(np.all(parameters > margin, axis=1))

    def proportions_of(self, parameters: FloatArray) -> FloatArray:
        """Return H = 1 and the parameters."""
        return np.insert(parameters, 0, 1.0, axis=1)

    def from_lengths(self, lengths: Sequence[float]) -> tuple[FloatArray, float]:
        """Scale H, r_a and r_b by D = H.

        Raises
        ------
        InputError
            If a length is not finite and positive, or H is so large or small that volumes
            overflow.
        """
        self.check_count(lengths)
        for each, value in zip(self.lengths, lengths, strict=True):
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(each.name, value, "a finite length above 0")
        height, r_a, r_b = (float(value) for value in lengths)
        least, greatest = FACTOR_RANGE
        if not least <= height <= greatest:
            raise InputError("H", height, f"a length from {least:g} to {greatest:g}")
        return np.array([r_a, r_b]) / height, height

    def spatial_design(
        self, lengths: Sequence[float], unit: str | None = None, options: Options = ()
    ) -> SpatialDesign:
        """Return one design for figures."""
        from fivebar_atlas.mechanisms.pentapod.pentapod import Pentapod

        parameters, factor = self.from_lengths(lengths)
        if unit is None:
            unit = "" if factor == 1.0 else "mm"
        if not unit:
            factor = 1.0
        r_a, r_b = (factor * float(value) for value in parameters)
        return Pentapod.from_radii(factor, r_a, r_b, unit, options)

    def project(self, parameters: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return r_a and r_b, the coordinates of the chart."""
        return parameters

    def unproject(self, points: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return designs from chart coordinates, which they are."""
        return points

    def chart(self, space: str) -> DesignChart:  # noqa: ARG002
        """Return how the design space is drawn; see :func:`design_space.chart`."""
        return design_space.chart()
