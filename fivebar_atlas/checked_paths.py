"""What is said of a path that a linkage is to follow: in a phrase, as JSON, as a table.

Points are numbered from 1, as in the rows of a file. Where a path is closed, its last corner
is point 1 again.
"""

from __future__ import annotations

import csv
import dataclasses
import functools
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fivebar_atlas import mechanisms
from fivebar_atlas.closed_paths import closed, path_lengths
from fivebar_atlas.errors import InfeasiblePathError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.planar import PathFault, PathLeast, PathReport, PlanarDesign
from fivebar_atlas.mechanisms.quantities import plain
from fivebar_atlas.output_file import atomic_output
from fivebar_atlas.planar_geometry import LIMIT, Region


@dataclasses.dataclass(frozen=True)
class CheckedPath:
    """A path with what is known of following it.

    Attributes
    ----------
    design
        The design.
    report
        What :meth:`PlanarDesign.check_path` says of it.
    is_closed
        Whether the last corner is the first one again.
    """

    design: PlanarDesign
    report: PathReport
    is_closed: bool

    @classmethod
    def of(cls, design: PlanarDesign, points: FloatArray, mode: str, close: bool) -> CheckedPath:
        """Check a path.

        Parameters
        ----------
        design
            The design.
        points
            Corners, shape (n, 2).
        mode
            Mode pair.
        close
            Whether the path goes back from the last corner to the first.

        Raises
        ------
        UnknownNameError
            If there is no such mode pair.
        InputError
            If the path has no points or one that is not finite.
        """
        corners = closed(points) if close else points
        return cls(design, design.check_path(corners, mode), close)

    def require_feasible(self, numbered: bool = True) -> None:
        """Raise InfeasiblePathError with the first fault unless the path can be followed.

        Parameters
        ----------
        numbered
            Whether the points of the path have numbers that mean something to its maker.
        """
        if self.report.fault is not None:
            text = self._fault_text(self.report.fault, numbered)
            raise InfeasiblePathError(f"the path is {text}")

    @property
    def verdict(self) -> str:
        """``"feasible"``, or the first fault: where it is, the locus that is met, the reason."""
        fault = self.report.fault
        return "feasible" if fault is None else self._fault_text(fault, numbered=True)

    @property
    def input_texts(self) -> tuple[str, ...]:
        """Inputs as they are written in text: ``"θ1"``."""
        mechanism = mechanisms.get(self.design.mechanism)
        return tuple(
            mechanism.input_text(number + 1) for number in range(self.report.inputs.shape[1])
        )

    @property
    def lengths(self) -> FloatArray:
        """Length of the way to every corner, shape (n,)."""
        return path_lengths(self.report.points)

    def number(self, corner: int) -> int:
        """Return the number of the point at a corner, counted from 0."""
        last = len(self.report.points) - 1
        return 1 if self.is_closed and corner == last else corner + 1

    def turns(self) -> tuple[int, ...] | None:
        """Return the full turns of every input; None for what is not closed or not feasible."""
        if not self.is_closed or not self.report.feasible:
            return None
        gained = self.report.inputs[-1] - self.report.inputs[0]
        return tuple(round(float(angle)) for angle in gained / (2.0 * math.pi))

    @functools.cached_property
    def extremes(self) -> tuple[PathLeast, PathLeast] | None:
        """Least LCI and least distance on the whole path; None where it cannot be followed."""
        if not self.report.feasible:
            return None
        return self.design.least_on_path(self.report.points, self.report.mode)

    def least(self, values: FloatArray) -> int | None:
        """Return the corner where a value of the report is least, None where there is none."""
        return None if np.all(np.isnan(values)) else int(np.nanargmin(values))

    def document(self) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON.

        Returns
        -------
        dict
            Lengths in ``unit``, angles in degrees; what does not exist is None.
        """
        report, fault = self.report, self.report.fault
        corners = self._corners()
        turns = self.turns()
        document: dict[str, Any] = {
            "mechanism": self.design.mechanism,
            "mode": report.mode,
            "unit": self.design.unit,
            **self.design.named_lengths,
            "dimensional_factor": self.design.factor,
            "remarks": list(self.design.remarks()),
            "closed": self.is_closed,
            "path_length": float(self.lengths[-1]),
            "feasible": report.feasible,
            "fault": None,
            "turns": None if turns is None else list(turns),
        }
        if fault is not None:
            document["fault"] = {
                "after_point": fault.segment + 1,
                "share_of_segment": fault.share,
                "x": fault.position[0],
                "y": fault.position[1],
                "curve": fault.curve or None,
                "kind": fault.kind or None,
                "reason": fault.reason,
            }
        document["least_lci"] = document["least_distance"] = None
        if self.extremes is not None:
            for key, least in zip(("least_lci", "least_distance"), self.extremes, strict=True):
                document[key] = {
                    "value": least.value,
                    "after_point": least.segment + 1,
                    "share_of_segment": least.share,
                    "x": least.position[0],
                    "y": least.position[1],
                }
        document["points"] = corners
        return document

    def write_csv(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Write the table of points as comma-separated text.

        Parameters
        ----------
        path
            The file to be written.
        overwrite
            Whether a file of this name may be replaced.

        Raises
        ------
        FileUsageError
            If the file exists already (without ``overwrite``) or its folder does not.
        FileError
            If it cannot be written.

        Notes
        -----
        One row a corner. Lengths have their unit in the name of the column, unless they are
        non-dimensional. Numbers have as many digits as tell them apart from every other; from
        the first fault on they are ``nan``.
        """
        with (
            atomic_output(Path(path), overwrite) as temporary,
            temporary.open("w", encoding="utf-8", newline="") as file,
        ):
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self._columns())
            writer.writerows(self._rows())

    def _fault_text(self, fault: PathFault, numbered: bool) -> str:
        """Return a fault in words."""
        x, y = fault.position
        place = f"({x:.9g}, {y:.9g}) {self.design.unit}".rstrip()
        kind = f" (singularity: {fault.kind})" if fault.kind not in ("", LIMIT) else ""
        where = f" {self._whereabouts(fault)}," if numbered else ""
        return f"not feasible{where} at {place}: {fault.reason}{kind}"

    def _whereabouts(self, fault: PathFault) -> str:
        """Return the points next to a fault."""
        before, after = self.number(fault.segment), self.number(fault.segment + 1)
        if fault.share in (0.0, 1.0):
            return f"at point {after if fault.share else before}"
        return f"between point {before} and point {after}"

    def _columns(self) -> list[str]:
        unit = f"_{self.design.unit}" if self.design.unit else ""
        angles = [f"{name}_deg" for name in mechanisms.get(self.design.mechanism).input_names]
        return [
            *("point", f"x{unit}", f"y{unit}", f"path_length{unit}"),
            *(*angles, "lci", f"distance{unit}", "nearest_locus"),
        ]

    def _rows(self) -> Iterator[list[Any]]:
        report = self.report
        numbers = np.column_stack(
            [
                *(report.points, self.lengths, np.degrees(report.inputs)),
                *(report.lci, report.distances),
            ]
        )
        for corner, row in enumerate(numbers.tolist()):
            yield [self.number(corner), *map(repr, row), report.nearest[corner]]

    def _corners(self) -> list[dict[str, Any]]:
        """Return what is known of every corner."""
        report = self.report
        return [
            {
                "point": self.number(corner),
                "x": plain(x),
                "y": plain(y),
                "path_length": plain(length),
                "inputs_deg": plain(np.degrees(report.inputs[corner])),
                "lci": plain(report.lci[corner]),
                "distance": plain(report.distances[corner]),
                "nearest_locus": report.nearest[corner] or None,
            }
            for corner, ((x, y), length) in enumerate(zip(report.points, self.lengths, strict=True))
        ]


def usable_region(design: PlanarDesign, mode: str) -> Region:
    """Return the usable workspace of a mode pair as a region.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    InfeasiblePathError
        If it is empty.
    """
    workspace = design.usable_workspace(mode)
    if workspace is None:
        raise InfeasiblePathError(f"the usable workspace of {mode} is empty: there are no paths")
    return workspace.region
