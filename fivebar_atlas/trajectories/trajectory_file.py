"""The file of a trajectory: its HDF5 format and its table in text.

The format is described in ``docs/trajectory.md``; of trajectories, this is the only module that
knows HDF5.
"""

from __future__ import annotations

import dataclasses
import datetime
import importlib.metadata
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fivebar_atlas import __version__
from fivebar_atlas.errors import FileError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.motions import Column, plain_unit
from fivebar_atlas.output_file import atomic_output
from fivebar_atlas.store.opening import check_version, open_hdf5, plain_attribute, reading
from fivebar_atlas.store.seal import seal

if TYPE_CHECKING:
    from fivebar_atlas.trajectories.motion_problem import Trajectory

FORMAT = "fivebar-atlas-trajectory"
FORMAT_VERSION = 1

#: Name of the dimension and of its coordinate.
TIME = "t"

# Values of a chunk, and digits in text: enough for a double.
_CHUNK, _DIGITS = 16384, 17


@dataclasses.dataclass(frozen=True, eq=False)
class StoredTrajectory:
    """What is in a trajectory file.

    Attributes
    ----------
    path
        The file.
    times, time_unit
        Shape (n,).
    columns
        Every other quantity.
    attributes
        Root attributes: how it was made.
    """

    path: Path
    times: FloatArray
    time_unit: str
    columns: tuple[Column, ...]
    attributes: Mapping[str, Any]

    def __getitem__(self, name: str) -> FloatArray:
        for column in self.columns:
            if column.name == name:
                return column.values
        raise KeyError(name)


def write_trajectory(
    trajectory: Trajectory, path: Path, overwrite: bool = False, command_line: str = ""
) -> None:
    """Write a trajectory as HDF5; the file appears whole or not at all.

    Parameters
    ----------
    trajectory
        The trajectory.
    path
        The file.
    overwrite
        Whether an existing file may be replaced.
    command_line
        The command, for the record.

    Raises
    ------
    FileUsageError, FileError
        If the file cannot be written or exists already.
    """
    import h5py

    # made in memory: HDF5 ends the process where the disk is full
    picture = io.BytesIO()
    solution = trajectory.solution
    with h5py.File(picture, "w") as target:
        target.attrs.update(_attributes(trajectory, command_line))
        options: dict[str, Any] = {
            "chunks": (min(len(solution.times), _CHUNK),),
            "compression": "gzip",
            "compression_opts": 1,
            "shuffle": True,
            "fletcher32": True,
            "track_times": False,
        }
        scale = target.create_dataset(TIME, data=solution.times, **options)
        scale.make_scale(TIME)
        scale.attrs["units"] = solution.units.time
        scale.attrs["long_name"] = "time"
        for column in solution:
            dataset = target.create_dataset(column.name, data=column.values, **options)
            dataset.dims[0].attach_scale(scale)
            dataset.attrs["units"] = plain_unit(column.unit)
            dataset.attrs["long_name"] = column.long_name
            dataset.attrs["symbol"] = column.symbol
            dataset.attrs["group"] = column.group
            for what in ("velocity", "acceleration"):
                error = trajectory.errors.get(f"{what} of {column.name}")
                if error is not None:
                    dataset.attrs[f"{what}_error"] = error
    seal(picture)
    with atomic_output(path, overwrite) as temporary:
        temporary.write_bytes(picture.getbuffer())


def write_table(trajectory: Trajectory, path: Path, overwrite: bool = False) -> None:
    """Write a trajectory as comma-separated values, names and units in the header.

    The same names as in the HDF5 file, each with its unit: ``l1_mm``, ``v1_mm/s``. What is
    written can be read again as a table of poses with a load.

    Parameters
    ----------
    trajectory
        The trajectory.
    path
        The file.
    overwrite
        Whether an existing file may be replaced.

    Raises
    ------
    FileUsageError, FileError
        If the file cannot be written or exists already.
    """
    solution = trajectory.solution
    header = [f"{TIME}_{solution.units.time}", *(_heading(column) for column in solution)]
    table = np.column_stack([solution.times, *(column.values for column in solution)])
    line = ",".join([f"%.{_DIGITS}g"] * len(header))
    rows = (line % tuple(row) for row in (table + 0.0).tolist())
    text = "\n".join([",".join(header), *rows, ""])
    with atomic_output(path, overwrite) as temporary:
        temporary.write_bytes(text.encode())


def read_trajectory(path: str | os.PathLike[str]) -> StoredTrajectory:
    """Read a trajectory file.

    Raises
    ------
    FileUsageError
        If there is no such file.
    FileError
        If it is no trajectory, is damaged, or of a newer format.
    """
    path = Path(path)
    file, attributes = open_hdf5(path)
    with file:
        if attributes.get("format") != FORMAT:
            raise FileError(path, "is no file written by atlas trajectory")
        check_version(path, attributes, FORMAT_VERSION)
        with reading(path):
            names = str(attributes["columns"]).split()
            columns = tuple(_column(name, file[name].attrs, file[name][()]) for name in names)
            unit = str(plain_attribute(file[TIME].attrs["units"]))
            return StoredTrajectory(path, file[TIME][()], unit, columns, attributes)


def _attributes(trajectory: Trajectory, command_line: str) -> dict[str, Any]:
    """Return the root attributes."""
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "Conventions": "CF-1.10",
        "mechanism": trajectory.mechanism.name,
        "package_version": __version__,
        "numpy_version": importlib.metadata.version("numpy"),
        "scipy_version": importlib.metadata.version("scipy"),
        "configuration": trajectory.configuration,
        "machine": trajectory.machine,
        "columns": " ".join(column.name for column in trajectory.solution),
        **trajectory.solution.facts,
        "command_line": command_line,
        "created": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
    }


def _column(name: str, attributes: Mapping[str, Any], values: FloatArray) -> Column:
    """Return a stored column."""
    symbol, unit, long_name, group = (
        str(plain_attribute(attributes[key])) for key in ("symbol", "units", "long_name", "group")
    )
    return Column(name, symbol, unit, long_name, group, values)


def _heading(column: Column) -> str:
    """Return name and unit of a column."""
    return column.name if column.unit == "1" else f"{column.name}_{plain_unit(column.unit, '.')}"
