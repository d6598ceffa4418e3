"""What the symmetric five-bar offers to sweeps, files, figures and commands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.mechanisms.five_bar import design_space
from fivebar_atlas.mechanisms.mode_pairs import (
    MODE_PAIRS,
    mode_and_threshold_axes,
    mode_signs,
    parse_mode_pair,
)
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    MODE,
    THRESHOLD,
    Axis,
    Flags,
    Parameter,
    Quantity,
    Results,
    plain,
)
from fivebar_atlas.mechanisms.settings import Options, SweepSettings

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.planar import (
        OptimalConfiguration,
        PlacedExtremes,
        PlacementScan,
        PlanarDesign,
    )

#: Why a value is not a number, or not as accurate as asked for.
STATUS = Flags(
    values=(1, 2, 4, 8, 16),
    meanings=(
        "empty_usable_workspace",
        "degenerate_design",
        "tolerance_not_reached",
        "no_upper_inscribed_circle",
        "no_lower_inscribed_circle",
    ),
    masks=True,
)


class FiveBarMechanism(Mechanism):
    """The symmetric planar 5R parallel manipulator."""

    name = "five-bar"
    title = "Symmetric planar 5R parallel manipulator (five-bar)"
    source = "Liu, Wang and Zheng 2006, Robotics and Autonomous Systems 54, 221-233"
    parameters = (
        Parameter("r1", "$r_1$", "1", "actuated link length"),
        Parameter("r2", "$r_2$", "1", "distal link length"),
        Parameter("r3", "$r_3$", "1", "half the distance of the base joints"),
    )
    factor_phrase = "(R1 + R2 + R3)/3"
    design_phrase = "r1 + r2 + r3 = 3"
    quantities = (
        Quantity(
            "sub_region",
            "sub-region",
            "1",
            "sub-region of the design space",
            flags=design_space.SUB_REGIONS,
        ),
        Quantity(
            "theoretical_workspace_area",
            "$W_t$",
            "1",
            "theoretical workspace area",
            has_error=True,
            length_power=2,
            ignores_tolerance=True,
        ),
        Quantity(
            "usable_workspace_area",
            "$W$",
            "1",
            "usable workspace area",
            (DESIGN, MODE),
            has_error=True,
            length_power=2,
            ignores_tolerance=True,
        ),
        Quantity("gci", "GCI", "1", "global conditioning index", (DESIGN, MODE), has_error=True),
        Quantity(
            "max_lci",
            r"$\mathrm{LCI}_{\max}$",
            "1",
            "largest local conditioning index",
            (DESIGN, MODE),
        ),
        Quantity(
            "max_lci_x",
            r"$x(\mathrm{LCI}_{\max})$",
            "1",
            "x where the local conditioning index is largest",
            (DESIGN, MODE),
            length_power=1,
        ),
        Quantity(
            "max_lci_y",
            r"$y(\mathrm{LCI}_{\max})$",
            "1",
            "y where the local conditioning index is largest",
            (DESIGN, MODE),
            length_power=1,
        ),
        Quantity(
            "mic_upper_radius",
            r"$r_{\mathrm{MIC}}^{+}$",
            "1",
            "radius of the upper maximal inscribed circle",
            (DESIGN, MODE),
            length_power=1,
            ignores_tolerance=True,
        ),
        Quantity(
            "mic_upper_y",
            r"$y_{\mathrm{MIC}}^{+}$",
            "1",
            "centre height of the upper maximal inscribed circle",
            (DESIGN, MODE),
            length_power=1,
            ignores_tolerance=True,
        ),
        Quantity(
            "mic_lower_radius",
            r"$r_{\mathrm{MIC}}^{-}$",
            "1",
            "radius of the lower maximal inscribed circle",
            (DESIGN, MODE),
            length_power=1,
            ignores_tolerance=True,
        ),
        Quantity(
            "mic_lower_y",
            r"$y_{\mathrm{MIC}}^{-}$",
            "1",
            "centre height of the lower maximal inscribed circle",
            (DESIGN, MODE),
            length_power=1,
            ignores_tolerance=True,
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
            r"$\mathrm{GCI}_g$",
            "1",
            "global conditioning index of the good-condition workspace",
            (DESIGN, MODE, THRESHOLD),
            has_error=True,
        ),
    )
    modes = MODE_PAIRS
    spaces = design_space.SPACES
    resolution_range = (3, 5000)

    def parse_mode(self, text: str) -> str:
        """Return the canonical label of a mode pair; see :func:`parse_mode_pair`."""
        return parse_mode_pair(text)

    def lattice(self, space: str, resolution: int) -> FloatArray:
        """Return every design of the lattice; see :func:`design_space.lattice`."""
        return design_space.lattice(space, resolution)

    def triangles(self, space: str, resolution: int) -> IntArray:
        """Return the triangulation of the lattice; see :func:`design_space.triangles`."""
        return design_space.triangles(space, resolution)

    def axes(self, settings: SweepSettings) -> tuple[Axis, ...]:
        """Return the mode axis and the threshold axis."""
        return mode_and_threshold_axes(settings.modes, settings.lci_thresholds, "det B")

    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Evaluate designs for every mode pair and threshold of the settings."""
        # The kernels take numba along, which only those who compute should wait for.
        from fivebar_atlas.mechanisms.five_bar.evaluation import evaluate_designs

        designs = np.ascontiguousarray(parameters, dtype=np.float64)
        signs = np.array([mode_signs(label) for label in settings.modes], dtype=np.int64)
        thresholds = np.array(settings.lci_thresholds, dtype=np.float64)
        results: dict[str, npt.NDArray[Any]] = dict(
            evaluate_designs(designs, signs, thresholds, settings.tolerance)
        )
        results["sub_region"] = design_space.sub_region(designs)
        return results

    def are_designs(
        self, parameters: FloatArray, margin: float = 0.0, mode: str | None = None
    ) -> BoolArray:
        """Return which designs have links: r1 and r2 are above 0, and the margin.

        In working modes "++" and "--" the base joints are apart, too: where r3 = 0, B1 = B2,
        and close to it the LCI varies over lengths of r3, which takes long to integrate.
        """
        least = np.array([margin, margin, -1.0])
        if mode is not None and mode_signs(mode)[0] == mode_signs(mode)[1]:
            least[2] = 1e3 * margin
        return np.asarray(np.all(parameters > least, axis=1))

    def from_lengths(self, lengths: Sequence[float]) -> tuple[FloatArray, float]:
        """Scale R1, R2, R3 by D = (R1 + R2 + R3)/3; see :func:`design_space.normalise`."""
        self.check_count(lengths)
        return design_space.normalise(lengths)

    def planar_design(
        self, lengths: Sequence[float], unit: str | None = None, options: Options = ()
    ) -> PlanarDesign:
        """Return one design for figures and files of its geometry."""
        from fivebar_atlas.mechanisms.five_bar.five_bar import FiveBar
        from fivebar_atlas.mechanisms.scaled_design import ScaledDesign

        self.complete_options(options)
        self.check_count(lengths)
        robot = FiveBar.from_lengths(*lengths)
        scale = robot.dimensional_factor
        if unit is None:
            unit = "" if scale == 1.0 else "mm"
        return ScaledDesign(robot, scale, unit) if unit else robot

    def optimal_configuration(self, ratio: float) -> OptimalConfiguration:
        """Return the optimal configuration of Le, Kang and Doan (2013), Eqs. 21 and 22."""
        from fivebar_atlas.mechanisms.five_bar.optimal_configuration import optimal_configuration

        return optimal_configuration(ratio)

    def scan_placements(
        self, designs: FloatArray, least: FloatArray, greatest: FloatArray, scan: PlacementScan
    ) -> FloatArray:
        """Return about the largest scale of a shape in designs; see :mod:`placement_scan`."""
        from fivebar_atlas.mechanisms.five_bar.placement_scan import largest_placements

        return largest_placements(designs, least, greatest, mode_signs(scan.mode), scan)

    def placed_extremes(
        self, designs: FloatArray, positions: FloatArray, scales: FloatArray, scan: PlacementScan
    ) -> PlacedExtremes:
        """Return what placed shapes bring with them; see :mod:`placement_scan`."""
        from fivebar_atlas.mechanisms.five_bar.placement_scan import placed_extremes

        return placed_extremes(designs, positions, scales, mode_signs(scan.mode), scan)

    def moving_links(self, designs: FloatArray) -> FloatArray:
        """Return 2 (r1 + r2), the lengths of both cranks and both distal links."""
        return np.asarray(2.0 * (designs[:, 0] + designs[:, 1]))

    def actuated_link(self, designs: FloatArray) -> FloatArray:
        """Return r1."""
        return designs[:, 0]

    def document(
        self, parameters: FloatArray, factor: float, settings: SweepSettings, results: Results
    ) -> dict[str, Any]:
        """Return everything known of one design as nested dictionaries, ready for JSON.

        Non-dimensional values come first; ``dimensional`` repeats all lengths times D and
        all areas times the square of D.
        """
        document: dict[str, Any] = {
            "r1": float(parameters[0]),
            "r2": float(parameters[1]),
            "r3": float(parameters[2]),
            "dimensional_factor": factor,
            "sub_region": design_space.SUB_REGIONS.describe(int(results["sub_region"][0])),
            **self._scaled(results, ("theoretical_workspace_area",), (0,), 1.0),
            "modes": [
                self._mode_document(results, settings, mode) for mode in range(len(settings.modes))
            ],
        }
        r1, r2, r3 = (float(value) * factor for value in parameters)
        document["dimensional"] = {
            "R1": r1,
            "R2": r2,
            "R3": r3,
            **self._scaled(results, ("theoretical_workspace_area",), (0,), factor),
            "modes": [
                self._dimensional_mode_document(results, settings, mode, factor)
                for mode in range(len(settings.modes))
            ],
        }
        return document

    def project(self, parameters: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return chart coordinates of designs; see :func:`design_space.project`."""
        return design_space.project(parameters)

    def unproject(self, points: FloatArray, space: str) -> FloatArray:  # noqa: ARG002
        """Return designs from chart coordinates; see :func:`design_space.unproject`."""
        return design_space.unproject(points)

    def chart(self, space: str) -> DesignChart:
        """Return how the design space is drawn; see :func:`design_space.chart`."""
        return design_space.chart(space)

    def _scaled(
        self, results: Results, names: Sequence[str], index: tuple[int, ...], factor: float
    ) -> dict[str, float | None]:
        """Return quantities with their errors, to the power of the factor that each has."""
        entries: dict[str, float | None] = {}
        for name in names:
            quantity = self.quantity(name)
            scale = factor**quantity.length_power
            entries[name] = plain(scale * results[name][index])
            if quantity.has_error:
                entries[quantity.error_name] = plain(scale * results[quantity.error_name][index])
        return entries

    def _good_condition(
        self, results: Results, settings: SweepSettings, mode: int, name: str, factor: float
    ) -> list[dict[str, float | None]]:
        """Return value and error of a good-condition quantity at every threshold."""
        stored = {"area": "good_condition_workspace_area", "gci": "good_condition_gci"}[name]
        entries = []
        for index in range(len(settings.lci_thresholds)):
            value, error = self._scaled(results, (stored,), (0, mode, index), factor).values()
            entries.append({name: value, f"{name}_error": error})
        return entries

    def _inscribed_circle(
        self, results: Results, mode: int, half: str, factor: float
    ) -> dict[str, float | None]:
        """Return radius and centre of an inscribed circle; its centre is on the y axis."""
        names = (f"mic_{half}_radius", f"mic_{half}_y")
        radius, y = self._scaled(results, names, (0, mode), factor).values()
        return {"radius": radius, "x": None if radius is None else 0.0, "y": y}

    def _mode_document(
        self, results: Results, settings: SweepSettings, mode: int
    ) -> dict[str, Any]:
        """Return the non-dimensional values of one mode pair."""
        working, assembly = settings.modes[mode].split("/")
        names = ("usable_workspace_area", "gci", "max_lci", "max_lci_x", "max_lci_y")
        areas = self._good_condition(results, settings, mode, "area", 1.0)
        indices = self._good_condition(results, settings, mode, "gci", 1.0)
        return {
            "working_mode": working,
            "assembly_mode": assembly,
            **self._scaled(results, names, (0, mode), 1.0),
            "good_condition": [
                {"lci_threshold": threshold, **area, **index}
                for threshold, area, index in zip(
                    settings.lci_thresholds, areas, indices, strict=True
                )
            ],
            "mic_upper": self._inscribed_circle(results, mode, "upper", 1.0),
            "mic_lower": self._inscribed_circle(results, mode, "lower", 1.0),
            "status": STATUS.describe(int(results["status"][0, mode])),
        }

    def _dimensional_mode_document(
        self, results: Results, settings: SweepSettings, mode: int, factor: float
    ) -> dict[str, Any]:
        """Return the lengths and areas of one mode pair, scaled to the machine."""
        working, assembly = settings.modes[mode].split("/")
        names = ("usable_workspace_area", "max_lci_x", "max_lci_y")
        areas = self._good_condition(results, settings, mode, "area", factor)
        return {
            "working_mode": working,
            "assembly_mode": assembly,
            **self._scaled(results, names, (0, mode), factor),
            "good_condition": [
                {"lci_threshold": threshold, **area}
                for threshold, area in zip(settings.lci_thresholds, areas, strict=True)
            ],
            "mic_upper": self._inscribed_circle(results, mode, "upper", factor),
            "mic_lower": self._inscribed_circle(results, mode, "lower", factor),
        }
