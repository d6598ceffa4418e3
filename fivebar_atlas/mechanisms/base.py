"""What a mechanism offers to everything above it.

A mechanism is a folder with a :class:`Mechanism` in it and one line in the registry
(``mechanisms/__init__.py``). Sweeps, files, figures and commands know only what is
declared here: parameters, quantities with units, the axes a quantity runs over, a design
lattice, a batch evaluator and a chart to draw the design space on.
"""

from __future__ import annotations

import dataclasses
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray
from fivebar_atlas.mechanisms.charts import DesignChart
from fivebar_atlas.mechanisms.quantities import (
    DESIGN,
    MODE,
    Axis,
    NormalisedProduct,
    Parameter,
    Quantity,
    ResultArray,
    Results,
    plain,
)
from fivebar_atlas.mechanisms.settings import (
    DEFAULT_LCI_THRESHOLDS,
    Options,
    SweepOption,
    SweepSettings,
)

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.motions import MotionSolver, Units
    from fivebar_atlas.mechanisms.planar import (
        OptimalConfiguration,
        PlacedExtremes,
        PlacementScan,
        PlanarDesign,
    )
    from fivebar_atlas.mechanisms.spatial import SpatialDesign


# Up to this difference of every parameter designs are the same.
_SAME_DESIGN = 1e-9
# More options than this are not listed in a line.
_MANY_OPTIONS = 8


class Mechanism(ABC):
    """A mechanism: a design space, its modes, its quantities and their evaluator."""

    #: Name on the command line and in files.
    name: str
    #: Full name for titles and help.
    title: str
    #: The paper the definitions come from.
    source: str
    #: Design parameters, in the order of the columns of a parameter array.
    parameters: tuple[Parameter, ...]
    #: What the dimensional factor D is in lengths of a machine, ``"(R1 + R2 + R3)/3"``, and what
    #: therefore holds of a design, ``"r1 + r2 + r3 = 3"``; empty where designs have no scale.
    factor_phrase: str = ""
    design_phrase: str = ""
    #: Names of the input angles, in letters that a file may have: Greek ones by their names.
    input_names: tuple[str, ...] = ("theta1", "theta2")
    #: Everything the evaluator computes, error companions not listed separately.
    quantities: tuple[Quantity, ...]
    #: What an atlas has besides, from the quantities of all its designs.
    normalised: tuple[NormalisedProduct, ...] = ()
    #: Canonical labels of all mode pairs, the default first.
    modes: tuple[str, ...]
    #: What one of them is called.
    mode_phrase: str = "mode pair"
    #: What an index is averaged over, as in "no workspace with LCI ≥ 0.5".
    usable_phrase: str = "workspace"
    #: The two quantities over which an optimum region is drawn: how large, and how good.
    region_quantities: tuple[str, str] = ("usable_workspace_area", "gci")
    #: Names of the design spaces, the default first and the widest last.
    spaces: tuple[str, ...]
    #: How further spaces are written that are too many for a list, ``"l_a=VALUE"``;
    #: :meth:`parse_space` knows them.
    slices: tuple[str, ...] = ()
    #: Least and largest lattice resolution.
    resolution_range: tuple[int, int]
    #: Lattice resolution where nothing is said.
    default_resolution: int = 300
    #: Tightest and loosest tolerance.
    tolerance_range: tuple[float, float] = (1e-10, 1e-3)
    #: Tolerance where nothing is said.
    default_tolerance: float = 1e-6
    #: Relative tolerance of the values that optima are computed from; None where nothing tighter
    #: than that of the file is within reach.
    exact_tolerance: float | None = 1e-9
    #: Difference of designs over which slopes of values stand out from their errors.
    exact_step: float = 1e-4
    #: LCI thresholds where nothing is said.
    default_lci_thresholds: tuple[float, ...] = DEFAULT_LCI_THRESHOLDS
    #: Packages besides NumPy and Numba whose version the numbers depend on.
    computed_with: tuple[str, ...] = ()
    #: What else a sweep may choose, beyond space, mode pairs, thresholds and tolerance.
    options: tuple[SweepOption, ...] = ()

    def input_text(self, number: int) -> str:
        """Return an input, counted from 1, as it is written in text: ``"θ1"``."""
        name = self.input_names[number - 1]
        letter = name.rstrip("0123456789")
        try:
            greek = unicodedata.lookup(f"GREEK SMALL LETTER {letter}")
        except KeyError:
            return name
        return greek + name.removeprefix(letter)

    @property
    def has_modes(self) -> bool:
        """Whether any quantity depends on the mode; if none does, results have no such axis."""
        return any(MODE in quantity.dimensions for quantity in self.stored_quantities)

    @property
    def listed_by(self) -> str:
        """The command that lists parameters, options and quantities."""
        return f"'atlas mechanisms {self.name}'"

    @property
    def listed_names(self) -> tuple[str, ...]:
        """What it lists of an atlas: parameters, quantities and error estimates."""
        stored = self.stored_quantities
        errors = (each.error_name for each in stored if each.has_error)
        return (*(p.name for p in self.parameters), *(q.name for q in stored), *errors)

    @property
    def proportions(self) -> tuple[Parameter, ...]:
        """The lengths of a non-dimensional design; here its parameters.

        A mechanism may have more, such as one that is 1 in every design; it then says with
        :meth:`proportions_of` what they are.
        """
        return self.parameters

    @property
    def lengths(self) -> tuple[Parameter, ...]:
        """The lengths of a machine, in the order in which they are given: D times proportions.

        Here they have the names and symbols of the proportions in capital letters.
        """
        return tuple(
            dataclasses.replace(each, name=each.name.upper(), symbol=each.symbol.upper())
            for each in self.proportions
        )

    def proportions_of(self, parameters: FloatArray) -> FloatArray:
        """Return the proportions, shape (n, lengths), of designs, shape (n, parameters).

        A linear function, constant terms included.
        """
        return parameters

    @abstractmethod
    def parse_mode(self, text: str) -> str:
        """Return the canonical label of a mode pair; raise UnknownNameError."""

    @abstractmethod
    def lattice(self, space: str, resolution: int) -> FloatArray:
        """Return every design of the lattice, shape (designs, parameters), in a fixed order."""

    @abstractmethod
    def triangles(self, space: str, resolution: int) -> IntArray:
        """Return the triangulation of the lattice, indices of shape (triangles, 3)."""

    @abstractmethod
    def axes(self, settings: SweepSettings) -> tuple[Axis, ...]:
        """Return the non-design axes of the results, in the order of the dimensions."""

    @abstractmethod
    def evaluate(
        self, parameters: FloatArray, settings: SweepSettings
    ) -> dict[str, npt.NDArray[Any]]:
        """Evaluate designs; releases the GIL while it computes.

        Parameters
        ----------
        parameters
            Designs, shape (designs, parameters).
        settings
            Modes, thresholds, tolerance and options (see :meth:`complete_options`); space
            and resolution are not used.

        Returns
        -------
        dict
            One array for every quantity and every error companion, with the shape of the
            quantity's dimensions. What does not exist is NaN and explained by ``status``.
        """

    def are_designs(
        self,
        parameters: FloatArray,
        margin: float = 0.0,  # noqa: ARG002
        mode: str | None = None,  # noqa: ARG002
    ) -> BoolArray:
        """Return which points of a design space, borders included, make a mechanism.

        Parameters
        ----------
        parameters
            Shape (n, parameters).
        margin
            How far a parameter must be from where there is none.
        mode
            Mode pair in which they must not be degenerate, if any.

        Returns
        -------
        ndarray
            Shape (n,); here, where a mechanism does not say otherwise, all of them.
        """
        return np.ones(len(parameters), dtype=np.bool_)

    @abstractmethod
    def project(self, parameters: FloatArray, space: str) -> FloatArray:
        """Return coordinates in the chart of a design space, shape (n, 2), of designs in it.

        What tells designs from those of other spaces, such as a parameter that is fixed, is
        not looked at: :meth:`are_in_space` does.
        """

    @abstractmethod
    def unproject(self, points: FloatArray, space: str) -> FloatArray:
        """Return designs, shape (n, parameters), at points of a space's chart, shape (n, 2).

        The inverse of :meth:`project`, which is linear. What lies on a border of a design
        space, up to rounding, is a design that can be evaluated.
        """

    def are_in_space(self, parameters: FloatArray, space: str) -> BoolArray:
        """Return which designs, shape (n, parameters), the chart of a space has, shape (n,).

        Whether they lie within its outline is not looked at.
        """
        back = self.unproject(self.project(parameters, space), space)
        return np.asarray(np.all(np.abs(back - parameters) <= _SAME_DESIGN, axis=1))

    @abstractmethod
    def chart(self, space: str) -> DesignChart:
        """Return how the design space is drawn; its outline is convex."""

    @property
    def stored_quantities(self) -> tuple[Quantity, ...]:
        """Everything an atlas has: what the evaluator computes, then normalised products."""
        return (*self.quantities, *(product.quantity for product in self.normalised))

    def result_arrays(self, settings: SweepSettings) -> tuple[ResultArray, ...]:
        """Return what :meth:`evaluate` returns: every quantity, errors after their values."""
        return self._arrays(self.quantities, settings)

    def stored_arrays(self, settings: SweepSettings) -> tuple[ResultArray, ...]:
        """Return what an atlas has: the same, then the normalised products."""
        return self._arrays(self.stored_quantities, settings)

    def _arrays(
        self, quantities: Sequence[Quantity], settings: SweepSettings
    ) -> tuple[ResultArray, ...]:
        lengths = {axis.name: len(axis) for axis in self.axes(settings)}
        arrays: list[ResultArray] = []
        for quantity in quantities:
            shape = tuple(lengths[name] for name in quantity.dimensions if name != DESIGN)
            arrays.append(
                ResultArray(quantity.name, quantity, shape, quantity.dtype, quantity.long_name)
            )
            if quantity.has_error:
                phrase = f"absolute error estimate of the {quantity.long_name}"
                arrays.append(
                    ResultArray(quantity.error_name, quantity, shape, np.dtype(np.float64), phrase)
                )
        return tuple(arrays)

    def parse_space(self, text: str, name: str = "space") -> str:
        """Return the canonical text of a design space; raise UnknownNameError.

        A mechanism with more spaces than it can list, such as slices, overrides this.
        """
        if text not in self.spaces:
            raise UnknownNameError(name, text, self.spaces)
        return text

    def check_resolution(self, resolution: int, name: str = "resolution") -> None:
        """Raise InputError unless a lattice of this resolution can be swept."""
        least, greatest = self.resolution_range
        if not least <= resolution <= greatest:
            raise InputError(name, resolution, f"an integer from {least} to {greatest}")

    def check_tolerance(self, tolerance: float, name: str = "tolerance") -> None:
        """Raise InputError unless the tolerance can be asked for."""
        least, greatest = self.tolerance_range
        if not least <= tolerance <= greatest:
            raise InputError(name, tolerance, f"a number from {least:g} to {greatest:g}")

    def check_thresholds(self, thresholds: Sequence[float], name: str = "lci") -> None:
        """Raise InputError unless the thresholds lie between 0 and 1 and differ."""
        for threshold in thresholds:
            if not 0.0 < threshold < 1.0:
                raise InputError(name, threshold, "a number above 0 and below 1")
        if len(set(thresholds)) < len(thresholds):
            raise InputError(name, list(thresholds), "thresholds of which none is given twice")

    def complete_options(
        self,
        given: Mapping[str, object] | Options = (),
        named: Callable[[str], str] = str,
    ) -> Options:
        """Return every sweep option: those given, checked, and the defaults of the others.

        Parameters
        ----------
        given
            Options by name.
        named
            Returns what an option is called in messages.

        Raises
        ------
        UnknownNameError
            If there is no such option.
        InputError
            If the mechanism has no options at all, or a value has the wrong type or is out of
            range.
        """
        values = dict(given)
        known = [option.name for option in self.options]
        for name in values:
            if not known:
                allowed = f"no option: the mechanism {self.name} has none"
                raise InputError(named(name), name, allowed)
            if name not in known:
                raise UnknownNameError(named(name), name, known, self.listed_by)
        return tuple(
            (option.name, option.check(values[option.name], named(option.name)))
            if option.name in values
            else (option.name, option.default)
            for option in self.options
        )

    def options_text(self, options: Options, but_defaults: bool = False) -> str:
        """Return sweep options in a line: ``"theta_limit = 60 deg"``; empty if there are none.

        Those that have their default value may be left out. Where there are many options these
        are not listed in any case, but said to have it.
        """
        values = dict(self.complete_options(options))
        are_many = len(self.options) > _MANY_OPTIONS
        parts = [
            f"{each.name} = {each.shown(values[each.name])}"
            for each in self.options
            if not ((but_defaults or are_many) and values[each.name] == each.default)
        ]
        if are_many and not but_defaults and len(parts) < len(self.options):
            parts.append("all other options by default" if parts else "all options by default")
        return ", ".join(parts)

    def from_lengths(self, lengths: Sequence[float]) -> tuple[FloatArray, float]:
        """Return one design as non-dimensional parameters and its dimensional factor D.

        Parameters
        ----------
        lengths
            One number for each of ``lengths``, dimensional or not.

        Returns
        -------
        parameters : ndarray
            Shape (parameters,).
        factor : float
            Multiplying lengths by it gives the machine; here, where a mechanism does not
            say how its lengths scale, 1.

        Raises
        ------
        InputError
            If the numbers are not finite, too many or too few, or make no mechanism.
        """
        self.check_count(lengths)
        for length, value in zip(self.proportions, lengths, strict=True):
            if not np.isfinite(value):
                raise InputError(length.name, value, "a finite number")
        return np.array(lengths, dtype=np.float64), 1.0

    def planar_design(
        self,
        lengths: Sequence[float],  # noqa: ARG002
        unit: str | None = None,  # noqa: ARG002
        options: Options = (),  # noqa: ARG002
    ) -> PlanarDesign:
        """Return one design for figures and files of its geometry.

        Parameters
        ----------
        lengths
            One number for each of ``lengths``.
        unit
            Unit of the lengths; ``""`` for the non-dimensional design, whatever the lengths.
            Where nothing is said it is mm, or ``""`` if the lengths are non-dimensional
            already (D = 1).
        options
            Sweep options of the mechanism; those that are not among them have their defaults.

        Raises
        ------
        InputError
            If the lengths make no mechanism, or its output does not move in a plane.
        """
        raise self._without("a mechanism whose output point moves in a plane", "planar_design")

    @property
    def has_motions(self) -> bool:
        """Whether there is a :meth:`motion_solver`."""
        return type(self).motion_solver is not Mechanism.motion_solver

    def motion_solver(
        self,
        geometry: Mapping[str, object],  # noqa: ARG002
        characteristic_length: float | None,  # noqa: ARG002
        units: Units,  # noqa: ARG002
        named: Callable[[str], str] = str,  # noqa: ARG002
    ) -> MotionSolver:
        """Return one machine that solves motions of its moving body.

        Parameters
        ----------
        geometry
            What the machine is, by name: numbers and lists, angles in degrees.
        characteristic_length
            Length by which turns are judged; the machine's own where nothing is said.
        units
            Names of the units.
        named
            Returns what an input is called in messages.

        Raises
        ------
        InputError
            If the geometry makes no machine, or the mechanism has no such motions.
        """
        raise InputError("mechanism", self.name, "a mechanism whose platform moves in space")

    def spatial_design(
        self,
        lengths: Sequence[float],  # noqa: ARG002
        unit: str | None = None,  # noqa: ARG002
        options: Options = (),  # noqa: ARG002
    ) -> SpatialDesign:
        """Return one design whose platform moves in space, for figures.

        Parameters
        ----------
        lengths, unit, options
            As in :meth:`planar_design`.

        Raises
        ------
        InputError
            If the lengths make no mechanism, or its output moves in a plane.
        """
        raise InputError("mechanism", self.name, "a mechanism whose platform moves in space")

    @property
    def is_spatial(self) -> bool:
        """Whether there is a :meth:`spatial_design`."""
        return type(self).spatial_design is not Mechanism.spatial_design

    def design_of(self, parameters: FloatArray, options: Options = ()) -> PlanarDesign:
        """Return the non-dimensional design of parameters, shape (parameters,).

        Raises
        ------
        InputError
            As :meth:`planar_design`.
        """
        (lengths,) = self.proportions_of(parameters[np.newaxis])
        return self.planar_design(lengths.tolist(), "", options)

    def optimal_configuration(self, ratio: float) -> OptimalConfiguration:  # noqa: ARG002
        """Return the optimal configuration in closed form for a ratio of second to first length.

        Raises
        ------
        InputError
            If the ratio is out of range, or the mechanism has no such configuration.
        """
        needed = "a mechanism with an optimal configuration in closed form"
        raise self._without(needed, "optimal_configuration")

    def scan_placements(
        self,
        designs: FloatArray,  # noqa: ARG002
        least: FloatArray,  # noqa: ARG002
        greatest: FloatArray,  # noqa: ARG002
        scan: PlacementScan,  # noqa: ARG002
    ) -> FloatArray:
        """Return about the largest scale of a shape in designs, and where; releases the GIL.

        Parameters
        ----------
        designs
            Designs, shape (n, parameters).
        least, greatest
            Range of scales that is wanted, shape (n,).
        scan
            The shape, what is asked of its points and where it may be.

        Returns
        -------
        ndarray
            Scale and position of the centre in non-dimensional lengths, for the best
            placement in each of some parts of the plane, such as above the base and below it,
            shape (n, parts, 3); scale 0 where there is none. What holds between samples is not
            looked at.

        Raises
        ------
        InputError
            If the designs of the mechanism cannot be searched for a shape.
        """
        needed = "a mechanism whose designs can be searched for a shape"
        raise self._without(needed, "scan_placements")

    def placed_extremes(
        self,
        designs: FloatArray,  # noqa: ARG002
        positions: FloatArray,  # noqa: ARG002
        scales: FloatArray,  # noqa: ARG002
        scan: PlacementScan,  # noqa: ARG002
    ) -> PlacedExtremes:
        """Return what placed shapes bring with them, on their samples.

        Parameters
        ----------
        designs, positions, scales
            Placements, shapes (n, parameters), (n, 2) and (n,).
        scan
            The shape and the mode pair.

        Raises
        ------
        InputError
            If the designs of the mechanism cannot be searched for a shape.
        """
        needed = "a mechanism whose designs can be searched for a shape"
        raise self._without(needed, "placed_extremes")

    def moving_links(self, designs: FloatArray) -> FloatArray:  # noqa: ARG002
        """Return the lengths of all moving links together, shape (n,), for designs.

        Raises
        ------
        InputError
            If the mechanism has no such sum.
        """
        raise self._without("a mechanism of links of constant length", "moving_links")

    def actuated_link(self, designs: FloatArray) -> FloatArray:  # noqa: ARG002
        """Return the length of the actuated link, shape (n,), of designs.

        Raises
        ------
        InputError
            If the mechanism has no such link, or several of different lengths.
        """
        raise self._without("a mechanism with one length of actuated links", "actuated_link")

    def _without(self, needed: str, method: str) -> InputError:
        """Return the error for what a mechanism does not have, with those that do."""
        from fivebar_atlas import mechanisms

        own = getattr(Mechanism, method)
        able = [
            name
            for name in mechanisms.names()
            if getattr(type(mechanisms.get(name)), method) is not own
        ]
        return InputError("mechanism", self.name, f"{needed}: {', '.join(able)}")

    def check_count(self, lengths: Sequence[float]) -> None:
        """Raise InputError unless there is one number for each of ``lengths``."""
        if len(lengths) != len(self.proportions):
            names = " ".join(each.name for each in self.proportions)
            raise InputError("design", list(lengths), f"{len(self.proportions)} numbers: {names}")

    def document(
        self, parameters: FloatArray, factor: float, settings: SweepSettings, results: Results
    ) -> dict[str, Any]:
        """Return everything known of one design as nested dictionaries, ready for JSON.

        Parameters
        ----------
        parameters, factor
            What :meth:`from_lengths` returned.
        settings
            What the results were computed with.
        results
            What :meth:`evaluate` returned for the one design.

        Returns
        -------
        dict
            Numbers, texts, lists and dictionaries; what does not exist is None. Values are those
            of the non-dimensional design; ``dimensional`` has the lengths of the machine, and
            again what has a power of D.
        """
        document: dict[str, Any] = {
            parameter.name: float(value)
            for parameter, value in zip(self.parameters, parameters, strict=True)
        }
        document["dimensional_factor"] = factor
        if self.options:
            document["options"] = dict(self.complete_options(settings.options))
        for axis in self.axes(settings):
            document[axis.name] = list(axis.labels)
        for quantity in self.quantities:
            document[quantity.name] = plain(results[quantity.name][0], quantity.flags)
            if quantity.has_error:
                document[quantity.error_name] = plain(results[quantity.error_name][0])
        (proportions,) = self.proportions_of(parameters[np.newaxis])
        dimensional: dict[str, Any] = {
            each.name: factor * float(value)
            for each, value in zip(self.lengths, proportions, strict=True)
        }
        for quantity in self.quantities:
            scale = factor**quantity.length_power
            if quantity.length_power:
                dimensional[quantity.name] = plain(scale * results[quantity.name][0])
            if quantity.length_power and quantity.has_error:
                dimensional[quantity.error_name] = plain(scale * results[quantity.error_name][0])
        document["dimensional"] = dimensional
        return document

    def quantity(self, name: str) -> Quantity:
        """Return the quantity of this name; raise UnknownNameError."""
        for quantity in self.stored_quantities:
            if quantity.name == name:
                return quantity
        known = [quantity.name for quantity in self.stored_quantities]
        raise UnknownNameError("quantity", name, known, self.listed_by)

    def kind_of(self, name: str) -> str:
        """Return what a name is here: quantity, parameter or mode; empty if it is nothing."""
        if any(name in (each.name, each.error_name) for each in self.stored_quantities):
            return "quantity"
        if any(name == each.name for each in self.parameters):
            return "parameter"
        try:
            self.parse_mode(name)
        except UnknownNameError:
            return ""
        return self.mode_phrase

    def parse_modes(self, texts: Sequence[str], name: str = "mode") -> tuple[str, ...]:
        """Return canonical labels, ``"all"`` expanded and repetitions dropped."""
        labels: list[str] = []
        for text in texts:
            try:
                labels.extend(self.modes if text == "all" else [self.parse_mode(text)])
            except UnknownNameError:
                # Under the name that the user gave the value by.
                raise UnknownNameError(name, text, [*self.modes, "all"]) from None
        if not labels:
            raise InputError(name, list(texts), f"at least one {self.mode_phrase}")
        return tuple(dict.fromkeys(labels))
