"""What a figure shows as numbers: every plotted coordinate, one row each."""

from __future__ import annotations

import csv
import dataclasses
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from fivebar_atlas.figures.saving import save_figure
from fivebar_atlas.output_file import atomic_output
from fivebar_atlas.planar_geometry import FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class PlottedPart:
    """One line, outline or set of points of a figure.

    Attributes
    ----------
    element
        What it is, ``"locus"``.
    curve, kind
        Name of the curve and what happens on it; empty where that means nothing.
    points
        Coordinates, shape (n, 2), or (n, 3) in space.
    values
        A value at each of them, shape (n,); NaN where there is none.
    """

    element: str
    curve: str
    kind: str
    points: FloatArray
    values: FloatArray


@dataclasses.dataclass(slots=True)
class PlottedData:
    """The parts of a figure in the order in which they are drawn.

    Attributes
    ----------
    parts
        The parts.
    units
        Units of x and y where they are no lengths; None where they are.
    dimensions
        Number of coordinates of a point.
    """

    parts: list[PlottedPart] = dataclasses.field(default_factory=list)
    units: tuple[str, str] | None = None
    dimensions: int = 2

    def add(
        self,
        element: str,
        points: FloatArray | Sequence[Sequence[float]],
        curve: str = "",
        kind: str = "",
        values: FloatArray | float = math.nan,
    ) -> None:
        """Record a part; one value stands for all of its points."""
        places = np.asarray(points, dtype=np.float64).reshape(-1, self.dimensions)
        wide = np.broadcast_to(np.asarray(values, dtype=np.float64), len(places))
        self.parts.append(PlottedPart(element, curve, kind, places, wide))

    def rows(self) -> Iterator[tuple[object, ...]]:
        """Yield element, number of the part, curve, kind, coordinates and value of points."""
        for number, part in enumerate(self.parts, start=1):
            for point, value in zip(part.points.tolist(), part.values.tolist(), strict=True):
                known = "" if math.isnan(value) else value
                yield part.element, number, part.curve, part.kind, *point, known

    def write(self, path: Path, unit: str, overwrite: bool = False) -> None:
        """Write the rows as comma-separated values with a header.

        Parameters
        ----------
        path
            The file.
        unit
            Unit of lengths, for the names of the columns of coordinates; empty where they are
            non-dimensional.
        overwrite
            Whether an existing file may be replaced.

        Raises
        ------
        FileUsageError, FileError
            If the file cannot be written or exists already.
        """
        units = (unit,) * self.dimensions if self.units is None else self.units
        named = zip("xyz"[: self.dimensions], units, strict=True)
        places = (f"{name}_{each}" if each else name for name, each in named)
        header = ("element", "part", "curve", "kind", *places, "value")
        with (
            atomic_output(path, overwrite) as temporary,
            temporary.open("w", encoding="utf-8", newline="") as file,
        ):
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(header)
            writer.writerows(self.rows())


def save_outputs(
    figure: Figure,
    output: Path,
    data: PlottedData,
    data_path: Path | None,
    unit: str,
    overwrite: bool,
) -> None:
    """Write a figure and, where that is wanted, what it shows as numbers.

    Raises
    ------
    FileUsageError, FileError
        If a file cannot be written or exists already.
    """
    if data_path is not None:
        data.write(data_path, unit, overwrite)
    save_figure(figure, output, overwrite)
