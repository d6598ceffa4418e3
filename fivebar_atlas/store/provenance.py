"""How a result file was made: its root attributes, written and read."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from fivebar_atlas import __version__, mechanisms
from fivebar_atlas.errors import AtlasError, FileError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.settings import SweepSettings
from fivebar_atlas.store.opening import check_version
from fivebar_atlas.versions import computing_versions

FORMAT = "fivebar-atlas"
FORMAT_VERSION = 1
#: What a file with a part of an atlas says it is.
PART_FORMAT = "fivebar-atlas-part"


def identity(settings: SweepSettings) -> dict[str, str]:
    """Return what must be the same for numbers to be the same, bit for bit."""
    from fivebar_atlas import config

    return {
        "configuration": config.render_settings(settings),
        **computing_versions(settings.mechanism),
    }


def provenance(settings: SweepSettings, command_line: str) -> dict[str, Any]:
    """Return the root attributes."""
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "mechanism": settings.mechanism,
        "package_version": __version__,
        **identity(settings),
        "command_line": command_line,
        "created": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
    }


def joined(processors: Iterable[str]) -> str:
    """Return the root attribute that names all processors that computed the blocks of a file."""
    return ", ".join(sorted(set(processors)))


def part_attributes(part: str, designs: int) -> dict[str, Any]:
    """Return the root attributes that tell a part from an atlas.

    Parameters
    ----------
    part
        Label of the part, ``"2/3"``: the second of three.
    designs
        Number of designs of the whole sweep.
    """
    return {"format": PART_FORMAT, "part": part, "sweep_designs": designs}


def interpret(
    path: Path, attributes: Mapping[str, Any], expected: str = FORMAT
) -> tuple[Mechanism, SweepSettings]:
    """Return mechanism and settings of a file from its root attributes.

    Raises
    ------
    FileError
        If the file is not what is expected, of a newer format, or its settings cannot be read.
    """
    from fivebar_atlas import config

    found = attributes.get("format")
    if found != expected:
        if found == PART_FORMAT:
            part = f"holds part {attributes.get('part')} of an atlas"
            raise FileError(path, f"{part}; atlas merge puts all parts together")
        if found == f"{FORMAT}-trajectory":
            raise FileError(path, "is a trajectory, not an atlas; 'atlas info' says what is in it")
        if found == FORMAT:
            raise FileError(path, "holds a whole atlas, not a part of one")
        raise FileError(path, "is an HDF5 file, but not one written by atlas sweep")
    check_version(path, attributes, FORMAT_VERSION)
    try:
        settings = config.settings_from_text(str(attributes.get("configuration")), str(path))
        return mechanisms.get(settings.mechanism), settings
    except AtlasError as error:
        raise FileError(path, f"holds a configuration that cannot be read: {error}") from None
