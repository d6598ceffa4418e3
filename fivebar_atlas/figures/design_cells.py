"""Small drawings of representative designs: which designs, and what is drawn of each.

Every coordinate is in the design's own frame and non-dimensional. Nothing here knows how, or
how large, it is drawn; :mod:`cell_atlas` does.
"""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError, UnknownNameError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.planar import PlanarDesign
from fivebar_atlas.mechanisms.settings import Options
from fivebar_atlas.output_file import atomic_output
from fivebar_atlas.planar_geometry import NamedArc

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

#: Least and largest number of drawings that can be asked for, and how many there are if not.
CELLS_RANGE = (12, 400)
DEFAULT_CELLS = 50

# Largest distance of a drawn chord from its arc, in units of D: far less than a line's width.
_DEVIATION = 1e-3
# Steps of the lattice that every sub-region, however narrow, has a design of.
_FINE = 120
# Cross products closer to zero than this are those of designs on a border.
_SLACK = 1e-9


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class CellLine:
    """A line of a drawing.

    Attributes
    ----------
    points
        Its points, shape (n, 2); of an arc they include its ends.
    arc
        The arc that it is; None for one isolated singular point.
    boundary
        Which closed boundary it is part of, ``"outline"`` or ``"hole 1"`` and so on; empty
        for loci.
    """

    points: FloatArray
    arc: NamedArc | None = None
    boundary: str = ""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class DesignCell:
    """The drawing of one design.

    Attributes
    ----------
    parameters
        The design, shape (parameters,).
    place
        Where it lies in the chart, shape (2,).
    lines
        What is drawn; nothing where the usable workspace is empty.
    """

    parameters: FloatArray
    place: FloatArray
    lines: tuple[CellLine, ...]

    @property
    def points(self) -> FloatArray:
        """All points that are drawn, shape (n, 2)."""
        return np.concatenate([np.empty((0, 2)), *(line.points for line in self.lines)])

    @property
    def isolated_points(self) -> FloatArray:
        """Singular points that no arc passes through, shape (n, 2)."""
        lone = (line.points for line in self.lines if line.arc is None)
        return np.concatenate([np.empty((0, 2)), *lone])

    @property
    def loops(self) -> tuple[FloatArray, ...]:
        """Closed boundaries as polygons, first points not repeated; the outline first."""
        found: dict[str, list[FloatArray]] = {}
        for line in self.lines:
            if line.boundary:
                found.setdefault(line.boundary, []).append(line.points[:-1])
        return tuple(np.concatenate(parts) for parts in found.values())

    def lines_of(self, kind: str) -> list[FloatArray]:
        """Return the points of all arcs of a kind of singularity."""
        return [line.points for line in self.lines if line.arc and line.arc.kind == kind]


def loci_cells(
    mechanism: Mechanism,
    space: str,
    mode: str | None = None,
    cells: int = DEFAULT_CELLS,
    options: Options = (),
) -> tuple[DesignCell, ...]:
    """Return the singular loci of representative designs.

    Parameters
    ----------
    mechanism
        The mechanism.
    space
        Name of one of its design spaces.
    mode
        A mode pair or a working mode alone, for its loci only; None for all.
    cells
        About how many designs; see :func:`representative_designs`.
    options
        Sweep options of the mechanism.

    Returns
    -------
    tuple of DesignCell
        One for each design. No lines: no point of the mode pair is regular.

    Raises
    ------
    UnknownNameError
        If there is no such design space, mode or option.
    InputError
        If the number of cells is out of range, or the mechanism does not move in a plane.
    """

    def lines(design: PlanarDesign) -> Iterator[CellLine]:
        loci = design.singular_loci(mode)
        for each in loci:
            yield CellLine(each.arc.polyline(_DEVIATION), each)
        # singular whatever the mode, but drawn only where there is something around them
        for point in design.isolated_singular_points() if loci else ():
            yield CellLine(np.array([point]))

    return _cells(mechanism, space, cells, options, lines)


def shape_cells(
    mechanism: Mechanism,
    space: str,
    mode: str,
    cells: int = DEFAULT_CELLS,
    options: Options = (),
) -> tuple[DesignCell, ...]:
    """Return the boundaries of the usable workspaces of representative designs.

    Parameters
    ----------
    mechanism
        The mechanism.
    space
        Name of one of its design spaces.
    mode
        A mode pair.
    cells
        About how many designs; see :func:`representative_designs`.
    options
        Sweep options of the mechanism.

    Returns
    -------
    tuple of DesignCell
        One for each design. No lines: the usable workspace is empty.

    Raises
    ------
    UnknownNameError
        If there is no such design space, mode pair or option.
    InputError
        If the number of cells is out of range, or the mechanism does not move in a plane.
    """
    label = mechanism.parse_mode(mode)

    def lines(design: PlanarDesign) -> Iterator[CellLine]:
        workspace = design.usable_workspace(label)
        for number, loop in enumerate(workspace.region.loops if workspace is not None else ()):
            boundary = f"hole {number}" if number else "outline"
            for each in loop.arcs:
                yield CellLine(each.arc.polyline(_DEVIATION), each, boundary)

    return _cells(mechanism, space, cells, options, lines)


def locus_mode(mechanism: Mechanism, text: str) -> str:
    """Return the canonical label of a mode pair, or of a working mode given alone.

    Raises
    ------
    UnknownNameError
        If there is neither.
    """
    pairs = [label.partition("/") for label in mechanism.modes]
    for pattern in ("{}", *dict.fromkeys("{}" + slash + assembly for _, slash, assembly in pairs)):
        try:
            label = mechanism.parse_mode(pattern.format(text))
        except UnknownNameError:
            continue
        return label if pattern == "{}" else label.partition("/")[0]
    working_modes = dict.fromkeys(working for working, slash, _ in pairs if slash)
    raise UnknownNameError("mode", text, [*mechanism.modes, *working_modes])


def representative_designs(mechanism: Mechanism, space: str, cells: int) -> FloatArray:
    """Return designs that stand for those around them: a coarse lattice over a design space.

    Parameters
    ----------
    mechanism
        The mechanism.
    space
        Name of one of its design spaces.
    cells
        Number of designs asked for.

    Returns
    -------
    ndarray
        Designs, shape (n, parameters). Their places in the chart are a triangular lattice
        whose lowest row lies on the lower side of the drawing, and whose cells therefore
        fill it. Every sub-region has a design in its interior. Among all such lattices n is
        nearest to the number asked for, where a design on a border, which stands for
        neither side of it, counts like one too few; of two as near, the one with fewer
        designs on the edge.

    Raises
    ------
    UnknownNameError
        If there is no such design space.
    InputError
        If the number is out of range.
    """
    least, greatest = CELLS_RANGE
    if not least <= cells <= greatest:
        raise InputError("cells", cells, f"an integer from {least} to {greatest}")
    space = mechanism.parse_space(space)
    chart = mechanism.chart(space)
    edge = np.stack([chart.outline, np.roll(chart.outline, -1, axis=0)], axis=1)
    fine = mechanism.project(mechanism.lattice(space, _FINE), space)
    wanted = _interiors(_sides([*chart.borders, *edge], fine))
    best: FloatArray | None = None
    best_cost = (0, 0)
    steps = 1
    while True:
        steps += 1
        lattices = _coarse_lattices(mechanism, space, steps)
        # finer ones have still more designs
        if best is not None and min(map(len, lattices)) - cells > best_cost[0]:
            return best
        for designs in lattices:
            points = mechanism.project(designs, space)
            of_borders, of_edge = _sides(chart.borders, points), _sides(edge, points)
            on_borders, on_edge = (
                int((sides == 0).any(axis=1).sum()) for sides in (of_borders, of_edge)
            )
            cost = abs(len(designs) - cells) + on_borders, on_edge
            represented = _interiors(np.hstack([of_borders, of_edge]))
            if (best is None or cost < best_cost) and represented >= wanted:
                best, best_cost = designs, cost


def write_cells(
    path: Path, mechanism: Mechanism, cells: Sequence[DesignCell], overwrite: bool = False
) -> None:
    """Write every coordinate of drawings as comma-separated text, one row a point.

    Parameters
    ----------
    path
        The file to be written.
    mechanism
        The mechanism, which names the parameters.
    cells
        The drawings.
    overwrite
        Whether a file of this name may be replaced.

    Raises
    ------
    FileUsageError, FileError
        If the file cannot be written or exists already.

    Notes
    -----
    Columns: ``cell`` (number of the drawing, from 1), the parameters, ``boundary`` (of a
    workspace: ``outline`` or ``hole 1`` and so on), ``arc`` (number of the line in the drawing,
    from 1), ``curve``, ``kind``, ``x``, ``y``. An empty drawing has one row without any of the
    last six, an isolated point neither curve nor kind. Numbers have as many digits as tell
    them apart from every other.
    """
    names = [parameter.name for parameter in mechanism.parameters]
    with (
        atomic_output(path, overwrite) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["cell", *names, "boundary", "arc", "curve", "kind", "x", "y"])
        for number, cell in enumerate(cells, start=1):
            start = [number, *cell.parameters.tolist()]
            if not cell.lines:
                writer.writerow([*start, *[""] * 6])
            for place, line in enumerate(cell.lines, start=1):
                curve = ("", "") if line.arc is None else (line.arc.name, line.arc.kind)
                writer.writerows(
                    [*start, line.boundary, place, *curve, *point] for point in line.points.tolist()
                )


def _cells(
    mechanism: Mechanism,
    space: str,
    cells: int,
    options: Options,
    lines: Callable[[PlanarDesign], Iterator[CellLine]],
) -> tuple[DesignCell, ...]:
    designs = representative_designs(mechanism, space, cells)
    return tuple(
        DesignCell(design, place, tuple(lines(mechanism.design_of(design, options))))
        for design, place in zip(designs, mechanism.project(designs, space), strict=True)
    )


def _coarse_lattices(mechanism: Mechanism, space: str, steps: int) -> tuple[FloatArray, ...]:
    """Return two lattices of twice the step, one moved along the lowest row by half a step.

    Half of the rows of a fine lattice, from the lowest on, and every second design of each,
    so that rows are staggered.
    """
    designs = mechanism.lattice(space, 2 * steps)
    points = mechanism.project(designs, space)
    _, row = np.unique(np.round(points[:, 1], 9), return_inverse=True)
    first, second = (np.sort(points[row == number, 0]) for number in (0, 1))
    if len(first) < 2 or len(second) == 0:  # all designs lie on a line
        return (designs,)
    step = first[1] - first[0]
    column = np.rint((points[:, 0] - first[0] - row * (second[0] - first[0])) / step)
    return tuple(
        designs[(row % 2 == 0) & (column.astype(np.int64) % 2 == phase)] for phase in (0, 1)
    )


def _sides(lines: Iterable[FloatArray], points: FloatArray) -> IntArray:
    """Return on which side of each straight line points lie, -1, 0 or 1, one row a point.

    Lines of more than two points are borders that cut nothing off here.
    """
    columns = [np.zeros((len(points), 0), dtype=np.int64)]
    for line in lines:
        if len(line) == 2:
            along, offset = line[1] - line[0], points - line[0]
            cross = along[0] * offset[:, 1] - along[1] * offset[:, 0]
            side = np.where(np.abs(cross) < _SLACK, 0, np.sign(cross)).astype(np.int64)
            columns.append(side[:, np.newaxis])
    return np.hstack(columns)


def _interiors(sides: IntArray) -> set[tuple[int, ...]]:
    """Return the sub-regions, as sides of the borders, with a design in the interior."""
    return {tuple(row) for row in sides[(sides != 0).all(axis=1)].tolist()}
