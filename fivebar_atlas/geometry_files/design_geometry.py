"""What is written of one design: arcs and regions with their places, and what is said of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import UnknownNameError
from fivebar_atlas.mechanisms.planar import ACTUATED, PlanarDesign
from fivebar_atlas.planar_geometry import (
    BOTH,
    CLOSED,
    LEFT,
    RIGHT,
    FloatArray,
    NamedArc,
    Point,
    Region,
)

LOCI, WORKSPACE, GOOD_CONDITION, CIRCLES = "loci", "workspace", "good-condition", "circles"
#: Kinds of geometry, and what each is.
KINDS = {
    LOCI: "singular loci",
    WORKSPACE: "usable workspace",
    GOOD_CONDITION: "good-condition workspace",
    CIRCLES: "maximal inscribed circles",
}

# Grids on which the largest LCI is looked for: lines each way; zooms, each by this factor.
_FIRST_LINES, _LINES, _ZOOMS, _ZOOM = 401, 21, 24, 0.4
# Chords leave curves by no more than this share of D where only their extent is wanted.
_EXTENT_DEVIATION = 1e-6


@dataclasses.dataclass(frozen=True, slots=True)
class PlacedArc:
    """An arc and what it is part of.

    Attributes
    ----------
    number
        Number among all arcs of the geometry, from 1.
    named
        The arc.
    region
        Number of the region that it bounds, from 1; None where it bounds none.
    boundary
        ``"outline"``, or ``"hole 1"`` and so on; empty where it bounds no region.
    """

    number: int
    named: NamedArc
    region: int | None
    boundary: str


@dataclasses.dataclass(frozen=True, slots=True)
class DesignGeometry:
    """Geometry of one design, in its lengths.

    Attributes
    ----------
    kind
        One of ``KINDS``.
    design
        The design.
    mode
        Mode pair, or working mode alone; None for all.
    lci_threshold
        Threshold of the good-condition workspace; None for everything else.
    arcs
        Arcs that bound no region here: loci, circles.
    regions
        Regions, their arcs in order and tagged with the mode pair.
    isolated_points
        Singular points that no arc passes through.
    base_joints
        The actuated joints on the base.
    area
        Area as it is integrated, where it is.
    absence
        Why there is nothing, in a phrase; empty where there is something.
    """

    kind: str
    design: PlanarDesign
    mode: str | None
    lci_threshold: float | None = None
    arcs: tuple[NamedArc, ...] = ()
    regions: tuple[Region, ...] = ()
    isolated_points: tuple[Point, ...] = ()
    base_joints: tuple[Point, ...] = ()
    area: float | None = None
    absence: str = ""

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to write."""
        return not (self.arcs or self.regions or self.isolated_points)

    @property
    def title(self) -> str:
        """What it is, in a phrase: ``"usable workspace of +-/up"``."""
        mode = "" if self.mode is None else f" of {self.mode}"
        level = "" if self.lci_threshold is None else f", LCI at least {self.lci_threshold:g}"
        return f"{KINDS[self.kind]}{mode}{level}"

    @property
    def subject(self) -> str:
        """The design in a phrase: ``"five-bar R1 = 26 mm, R2 = 30 mm, R3 = 16 mm"``."""
        lengths = (
            f"{name} = {length:.8g} {self.design.unit}".rstrip()
            for name, length in self.design.named_lengths.items()
        )
        return f"{self.design.mechanism} {', '.join(lengths)}"

    def placed_arcs(self) -> tuple[PlacedArc, ...]:
        """Return all arcs, those of regions boundary by boundary in order."""
        rows: list[tuple[NamedArc, int | None, str]] = [(each, None, "") for each in self.arcs]
        for number, region in enumerate(self.regions, 1):
            for place, loop in enumerate(region.loops):
                rows.extend(
                    (each, number, f"hole {place}" if place else "outline") for each in loop.arcs
                )
        return tuple(PlacedArc(number, *row) for number, row in enumerate(rows, 1))

    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Return the corners of the upright box around everything, shape (2,) each."""
        deviation = _EXTENT_DEVIATION * self.design.factor
        points = [each.named.arc.polyline(deviation) for each in self.placed_arcs()]
        points.append(np.array([*self.isolated_points, *self.base_joints]).reshape(-1, 2))
        line = np.concatenate(points)
        return line.min(axis=0), line.max(axis=0)


def check_kind(kind: str) -> None:
    """Raise UnknownNameError unless there is geometry of this kind."""
    if kind not in KINDS:
        raise UnknownNameError("KIND", kind, KINDS)


def geometry_of(
    design: PlanarDesign, kind: str, mode: str | None = None, lci_threshold: float = 0.5
) -> DesignGeometry:
    """Return geometry of a design.

    Parameters
    ----------
    design
        The design.
    kind
        One of ``KINDS``.
    mode
        For loci a mode pair, a working mode alone, or None for all; otherwise a mode pair,
        the mechanism's first one if None.
    lci_threshold
        For the good-condition workspace, above 0 and below 1.

    Raises
    ------
    UnknownNameError
        If there is no such kind or mode.
    InputError
        If the threshold is out of range.
    """
    check_kind(kind)
    if kind == LOCI:
        found = _loci(design, mode)
    else:
        mechanism = mechanisms.get(design.mechanism)
        label = mechanism.modes[0] if mode is None else mechanism.parse_mode(mode)
        if kind == WORKSPACE:
            found = _workspace(design, label)
        elif kind == GOOD_CONDITION:
            mechanism.check_thresholds([lci_threshold], "lci_threshold")
            found = _good_condition(design, label, lci_threshold)
        else:
            found = _circles(design, label)
    return dataclasses.replace(found, base_joints=_base_joints(found))


def sides_text(sides: Mapping[str, str]) -> str:
    """Return which mode pairs lie on which side: ``"left: +-/up ++/up; right: +-/down"``.

    Never begins with a sign, which a spreadsheet would take for a formula.
    """
    parts = []
    for side in (LEFT, RIGHT, BOTH):
        pairs = [pair for pair, where in sides.items() if where == side]
        if pairs:
            parts.append(f"{side}: {' '.join(pairs)}")
    return "; ".join(parts)


def _loci(design: PlanarDesign, mode: str | None) -> DesignGeometry:
    label = None if mode is None else _any_mode(design, mode)
    arcs = design.singular_loci(label)
    points = design.isolated_singular_points()
    absence = ""
    if not arcs and not points:
        of_mode = "" if label is None else f" of {label}"
        absence = f"there are no arcs of singular loci{of_mode} ({'; '.join(design.remarks())})"
    return DesignGeometry(LOCI, design, label, arcs=arcs, isolated_points=points, absence=absence)


def _any_mode(design: PlanarDesign, mode: str) -> str:
    """Return the canonical label of a mode pair or of a working mode alone."""
    mechanism = mechanisms.get(design.mechanism)
    if "/" in mode:
        return mechanism.parse_mode(mode)
    assembly = mechanism.modes[0].partition("/")[2]
    try:
        return mechanism.parse_mode(f"{mode}/{assembly}").partition("/")[0]
    except UnknownNameError:
        alone = dict.fromkeys(pair.partition("/")[0] for pair in mechanism.modes)
        raise UnknownNameError("mode", mode, [*alone, *mechanism.modes]) from None


def _workspace(design: PlanarDesign, mode: str) -> DesignGeometry:
    found = design.usable_workspace(mode)
    if found is None:
        return DesignGeometry(WORKSPACE, design, mode, area=0.0, absence=_emptiness(mode))
    return DesignGeometry(
        WORKSPACE,
        design,
        mode,
        regions=(_tagged(found.region, mode),),
        isolated_points=design.isolated_singular_points(),
        area=found.area,
    )


def _good_condition(design: PlanarDesign, mode: str, threshold: float) -> DesignGeometry:
    parts = design.good_condition_workspace(threshold, mode)
    absence = ""
    if not parts:
        largest = design.largest_lci(mode)
        absence = _emptiness(mode)
        if largest is not None:
            absence = _low_condition(threshold, mode, largest[0])
    return DesignGeometry(
        GOOD_CONDITION,
        design,
        mode,
        threshold,
        regions=tuple(_tagged(part, mode) for part in parts),
        area=design.good_condition_area(threshold, mode)[0],
        absence=absence,
    )


def _low_condition(threshold: float, mode: str, largest: float) -> str:
    """Return why there is no good-condition workspace in a usable workspace."""
    where = f"in the usable workspace of {mode}"
    if largest < threshold:
        return f"LCI reaches {threshold:g} nowhere {where}; the largest is {largest:.4g}"
    return f"LCI reaches {threshold:g} {where} only in parts too small to be outlined"


def _circles(design: PlanarDesign, mode: str) -> DesignGeometry:
    arcs = []
    for circle in design.inscribed_circles(mode):
        place = "upper" if circle.centre[1] > 0.0 else "lower"
        name, symbol = f"MIC_{place}", f"MIC ({place})"
        arcs.append(NamedArc(name, symbol, "inscribed circle", circle, (CLOSED, CLOSED)))
    absence = ""
    if not arcs:
        is_empty = design.usable_workspace(mode) is None
        absence = _emptiness(mode) if is_empty else f"{mode} has no maximal inscribed circle"
    return DesignGeometry(CIRCLES, design, mode, arcs=tuple(arcs), absence=absence)


def _emptiness(mode: str) -> str:
    return f"the usable workspace of {mode} is empty"


def _tagged(region: Region, mode: str) -> Region:
    """Return a region whose arcs say which mode pair has it on their left."""

    def tagged(arcs: Sequence[NamedArc]) -> tuple[NamedArc, ...]:
        return tuple(dataclasses.replace(each, sides={mode: LEFT}) for each in arcs)

    outline, *holes = (dataclasses.replace(loop, arcs=tagged(loop.arcs)) for loop in region.loops)
    return Region(outline, tuple(holes))


def _base_joints(geometry: DesignGeometry) -> tuple[Point, ...]:
    """Return where the actuated joints are; they are the same in every pose."""
    placed = geometry.placed_arcs()
    if not placed:
        return ()
    ((x, y),) = placed[0].named.arc.points(np.array([0.5]))
    joints = geometry.design.inverse_poses(float(x), float(y))[0].joints
    return tuple(dict.fromkeys(joint.position for joint in joints if joint.kind == ACTUATED))
