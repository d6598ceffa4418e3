"""What the manipulator with a passive leg offers to sweeps, files, figures and commands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.mechanisms.mode_pairs import (
    MODE_PAIRS,
    mode_and_threshold_axes,
    mode_signs,
    parse_mode_pair,
)
from fivebar_atlas.mechanisms.passive_leg import design_space
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    MODE,
    THRESHOLD,
    Axis,
    Flags,
    NormalisedProduct,
    Parameter,
    Quantity,
)
from fivebar_atlas.mechanisms.settings import Options, SweepOption, SweepSettings

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.planar import PlanarDesign

#: Why a value is not a number, or not as accurate as asked for.
STATUS = Flags(
    values=(1, 2, 4, 8),
    meanings=(
        "empty_usable_workspace",
        "degenerate_design",
        "tolerance_not_reached",
        "unbounded_manipulability",
    ),
    masks=True,
)

#: Range of the dimensional factor D; areas, which scale with its square, stay finite.
FACTOR_RANGE = (1e-100, 1e100)


class PassiveLegMechanism(Mechanism):
    """The 2-DOF manipulator with two actuated RRR legs and a passive RP leg."""

    name = "passive-leg"
    title = "2-DOF parallel manipulator with a passive leg (2-RRR + RP)"
    source = "Nam and Park 2006, Journal of Mechanical Science and Technology 20"
    parameters = (
        Parameter("r", "$r$", "1", "half the width of the moving platform"),
        Parameter("l_a", "$l_a$", "1", "lower link length"),
        Parameter("l_b", "$l_b$", "1", "upper link length"),
    )
    lengths = (Parameter("R", "$R$", "1", "half the distance of the base joints"), *parameters)
    proportions = lengths
    input_names = ("phi1", "phi2")
    factor_phrase = "R"
    design_phrase = "R = 1"
    quantities = (
        Quantity(
            "workspace_area",
            "$W_0$",
            "1",
            "area that both legs reach",
            has_error=True,
            length_power=2,
        ),
        Quantity(
            "singularity_free_workspace_area",
            "$W_s$",
            "1",
            "singularity-free workspace area, passive joints not limited",
            (DESIGN, MODE),
            has_error=True,
            length_power=2,
        ),
        Quantity(
            "usable_workspace_area",
            "$W$",
            "1",
            "usable workspace area",
            (DESIGN, MODE),
            has_error=True,
            length_power=2,
        ),
        Quantity(
            "gci",
            r"$\eta_1$",
            "1",
            "global conditioning index",
            (DESIGN, MODE),
            has_error=True,
        ),
        Quantity(
            "gmi",
            r"$\eta_2$",
            "1",
            "global manipulability index",
            (DESIGN, MODE),
            has_error=True,
            length_power=2,
        ),
        Quantity(
            "space_utilisation",
            r"$\eta_3$",
            "1",
            "space utilisation index",
            (DESIGN, MODE),
            has_error=True,
        ),
        Quantity(
            "gci_l_theta",
            r"$\eta_1^{(l,\theta)}$",
            "1",
            "global conditioning index in the (l, θ) measure",
            (DESIGN, MODE),
            has_error=True,
        ),
        Quantity(
            "gmi_l_theta",
            r"$\eta_2^{(l,\theta)}$",
            "1",
            "global manipulability index in the (l, θ) measure",
            (DESIGN, MODE),
            has_error=True,
            length_power=2,
        ),
        Quantity(
            "space_utilisation_l_theta",
            r"$\eta_3^{(l,\theta)}$",
            "1",
            "space utilisation index with the (l, θ) measure of the workspace",
            (DESIGN, MODE),
            has_error=True,
            length_power=-1,
        ),
        Quantity(
            "max_lci",
            r"$(1/\kappa)_{\max}$",
            "1",
            "largest local conditioning index",
            (DESIGN, MODE),
        ),
        Quantity(
            "max_lci_x",
            r"$x_{\max}$",
            "1",
            "x where the local conditioning index is largest",
            (DESIGN, MODE),
            length_power=1,
        ),
        Quantity(
            "max_lci_y",
            r"$y_{\max}$",
            "1",
            "y where the local conditioning index is largest",
            (DESIGN, MODE),
            length_power=1,
        ),
        Quantity(
            "status", "status", "1", "status of the computed values", (DESIGN, MODE), flags=STATUS
        ),
        Quantity(
            "good_condition_workspace_area",
            "$W_g$",
            "1",
            "good-condition workspace area",
            (DESIGN, MODE, THRESHOLD),
            has_error=True,
            length_power=2,
        ),
        Quantity(
            "good_condition_gci",
            r"$\eta_{1,g}$",
            "1",
            "global conditioning index of the good-condition workspace",
            (DESIGN, MODE, THRESHOLD),
            has_error=True,
        ),
        Quantity(
            "good_condition_gmi",
            r"$\eta_{2,g}$",
            "1",
            "global manipulability index of the good-condition workspace",
            (DESIGN, MODE, THRESHOLD),
            has_error=True,
            length_power=2,
        ),
    )
    normalised = (
        *(
            NormalisedProduct(
                Quantity(
                    f"normalised_{name}",
                    rf"$\hat\eta_{number}$",
                    "1",
                    f"{long_name}, normalised over the atlas",
                    (DESIGN, MODE),
                    has_error=True,
                ),
                (name,),
                "range",
            )
            for number, name, long_name in (
                (1, "gci", "global conditioning index"),
                (2, "gmi", "global manipulability index"),
                (3, "space_utilisation", "space utilisation index"),
            )
        ),
        NormalisedProduct(
            Quantity(
                "composed_index",
                r"$\eta$",
                "1",
                "composed design index",
                (DESIGN, MODE),
                has_error=True,
            ),
            ("gci", "gmi", "space_utilisation"),
            "range",
        ),
        NormalisedProduct(
            Quantity(
                "composed_index_l_theta",
                r"$\eta^{(l,\theta)}$",
                "1",
                "composed design index in the (l, θ) measure",
                (DESIGN, MODE),
                has_error=True,
            ),
            ("gci_l_theta", "gmi_l_theta", "space_utilisation_l_theta"),
            "range",
        ),
        NormalisedProduct(
            Quantity(
                "composed_index_of_largest",
                r"$\eta^{(\max)}$",
                "1",
                "composed design index, indices divided by their largest values",
                (DESIGN, MODE),
                has_error=True,
            ),
            ("gci", "gmi", "space_utilisation"),
            "largest",
        ),
    )
    modes = MODE_PAIRS
    spaces = (design_space.CONDITIONED,)
    slices = design_space.SLICES
    resolution_range = (2, 2000)
    default_resolution = 150
    tolerance_range = (1e-8, 1e-3)
    options = (
        SweepOption(
            "theta_limit", "deg", "largest angle of the passive leg to either side", 90.0, 1.0, 90.0
        ),
        SweepOption(
            "passive_joint_limits",
            "1",
            "whether upper links stay below the line of the platform (Eq. 13)",
            True,
        ),
    )

    def parse_mode(self, text: str) -> str:
        """Return the canonical label of a mode pair; see :func:`mode_pairs.parse_mode_pair`."""
        return parse_mode_pair(text)

    def parse_space(self, text: str, name: str = "space") -> str:
        """Return the canonical text of a space; see :func:`design_space.parse_space`."""
        return design_space.parse_space(text, name)

    def lattice(self, space: str, resolution: int) -> FloatArray:
        """Return every design of the lattice; see :func:`design_space.lattice`."""
        return design_space.lattice(space, resolution)

    def triangles(self, space: str, resolution: int) -> IntArray:
        """Return the triangulation of the lattice; see :func:`design_space.triangles`."""
        return design_space.triangles(space, resolution)

    def axes(self, settings: SweepSettings) -> tuple[Axis, ...]:
        """Return the mode axis and the threshold axis."""
        return mode_and_threshold_axes(settings.modes, settings.lci_thresholds, "-det J_x")

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Evaluate designs for every mode pair and threshold of the settings."""
        # The kernels take numba along, which only those who compute should wait for.
        from fivebar_atlas.mechanisms.passive_leg.evaluation import evaluate_designs

        chosen = dict(self.complete_options(settings.options))
        return evaluate_designs(
            np.ascontiguousarray(parameters, dtype=np.float64),
            # "+" is the clockwise elbow (Eq. 6), "up" is det J_x < 0 (Eq. 25)
            np.array([[-sign for sign in mode_signs(label)] for label in settings.modes]),
            math.radians(chosen["theta_limit"]),
            bool(chosen["passive_joint_limits"]),
            np.array(settings.lci_thresholds, dtype=np.float64),
            settings.tolerance,
        )

    def are_designs(
        self,
        parameters: FloatArray,
        margin: float = 0.0,
        mode: str | None = None,  # noqa: ARG002
    ) -> BoolArray:
        """Return which designs have links: all lengths are above 0, and the margin."""
        return np.asarray(np.all(parameters > margin, axis=1))

    def proportions_of(self, parameters: FloatArray) -> FloatArray:
        """Return R = 1 and the parameters."""
        return np.insert(parameters, 0, 1.0, axis=1)

    def moving_links(self, designs: FloatArray) -> FloatArray:
        """Return 2 (l_a + l_b), the lengths of the links of both actuated legs."""
        return np.asarray(2.0 * (designs[:, 1] + designs[:, 2]))

    def actuated_link(self, designs: FloatArray) -> FloatArray:
        """Return l_a, the length of the lower links."""
        return designs[:, 1]

    def from_lengths(self, lengths: Sequence[float]) -> tuple[FloatArray, float]:
        """Scale R, r, l_a and l_b by D = R.

        Raises
        ------
        InputError
            If a length is not finite and positive, the legs do not reach the platform in any
            pose, or R is so large or small that areas overflow.
        """
        self.check_count(lengths)
        for each, value in zip(self.lengths, lengths, strict=True):
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(each.name, value, "a finite length above 0")
        base, r, l_a, l_b = (float(value) for value in lengths)
        least, greatest = FACTOR_RANGE
        if not least <= base <= greatest:
            raise InputError("R", base, f"a length from {least:g} to {greatest:g}")
        if l_a + l_b <= abs(base - r):
            raise InputError(
                "R r l_a l_b", (base, r, l_a, l_b), "lengths with l_a + l_b above |R - r| (Eq. 14)"
            )
        return np.array([r, l_a, l_b]) / base, base

    def planar_design(
        self, lengths: Sequence[float], unit: str | None = None, options: Options = ()
    ) -> PlanarDesign:
        """Return one design for figures and files of its geometry."""
        from fivebar_atlas.mechanisms.passive_leg.passive_leg import PassiveLeg
        from fivebar_atlas.mechanisms.scaled_design import ScaledDesign

        parameters, factor = self.from_lengths(lengths)
        chosen = dict(self.complete_options(options))
        r, l_a, l_b = (float(value) for value in parameters)
        design = PassiveLeg(
            r,
            l_a,
            l_b,
            math.radians(chosen["theta_limit"]),
            bool(chosen["passive_joint_limits"]),
        )
        if unit is None:
            unit = "" if factor == 1.0 else "mm"
        return ScaledDesign(design, factor, unit) if unit else design

    def project(self, parameters: FloatArray, space: str) -> FloatArray:
        """Return the two free parameters of designs; see :func:`design_space.project`."""
        return design_space.project(parameters, space)

    def unproject(self, points: FloatArray, space: str) -> FloatArray:
        """Return designs from chart coordinates; see :func:`design_space.unproject`."""
        return design_space.unproject(points, space)

    def chart(self, space: str) -> DesignChart:
        """Return how the design space is drawn; see :func:`design_space.chart`."""
        return design_space.chart(space)
