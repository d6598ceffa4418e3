"""Geometry to files: CSV, SVG or DXF by the ending, the same bytes every time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fivebar_atlas.errors import FileError, InputError
from fivebar_atlas.geometry_files.csv_points import csv_text
from fivebar_atlas.geometry_files.design_geometry import DesignGeometry
from fivebar_atlas.geometry_files.dxf_drawing import dxf_text
from fivebar_atlas.geometry_files.svg_drawing import svg_text
from fivebar_atlas.output_file import atomic_output, check_output, checked_ending

_DXF = "dxf"
_WRITERS: dict[str, Callable[[DesignGeometry, float], str]] = {
    "csv": csv_text,
    "svg": svg_text,
    _DXF: dxf_text,
}
FORMATS = tuple(_WRITERS)

#: Largest distance of chords and splines from the arcs, as a share of D.
DEVIATION = 1e-4
DEVIATION_RANGE = (1e-8, 0.1)


def check_geometry_output(path: Path, overwrite: bool = False) -> None:
    """Refuse an output that cannot be written, before there is anything to write.

    Parameters
    ----------
    path
        The file.
    overwrite
        Whether an existing file may be replaced.

    Raises
    ------
    InputError
        If the ending is not that of a format.
    FileUsageError, FileError
        If the folder is missing or not writable, the file exists already, or what the
        format needs is not installed.
    """
    ending = checked_ending(path, FORMATS)
    check_output(path, overwrite)
    if ending == _DXF:
        try:
            import ezdxf  # noqa: F401
        except ImportError:
            reason = "DXF files need ezdxf, which pip install 'fivebar-atlas[cad]' installs"
            raise FileError(path, reason) from None


def check_deviation(deviation: float, name: str = "deviation") -> None:
    """Raise InputError unless points can be as close to arcs as this share of D."""
    least, greatest = DEVIATION_RANGE
    if not least <= deviation <= greatest:
        raise InputError(name, deviation, f"a number from {least:g} to {greatest:g}")


def write_geometry(
    geometry: DesignGeometry, path: Path, overwrite: bool = False, deviation: float = DEVIATION
) -> None:
    """Write geometry to a file, which appears whole under its name or not at all.

    Parameters
    ----------
    geometry
        What is written.
    path
        The file; its ending decides the format.
    overwrite
        Whether an existing file may be replaced.
    deviation
        Largest distance from the arcs of what stands for them, as a share of D: of chords
        in CSV; in DXF and SVG circle arcs are exact, of polylines and splines for other
        curves. Level curves are given by the points that are known of them.

    Raises
    ------
    InputError
        If the ending is not that of a format, or the deviation out of range.
    FileUsageError, FileError
        If the file cannot be written or exists already, or there is nothing to write.
    """
    check_geometry_output(path, overwrite)
    check_deviation(deviation)
    if geometry.is_empty:
        raise FileError(path, f"there is nothing to write: {geometry.absence}")
    text = _WRITERS[checked_ending(path, FORMATS)](geometry, deviation * geometry.design.factor)
    with atomic_output(path, overwrite) as temporary:
        temporary.write_bytes(text.encode())
