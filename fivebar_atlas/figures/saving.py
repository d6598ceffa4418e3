"""Figures to files: PNG, PDF or SVG by the ending, the same bytes every time.

Nothing in a file depends on when, where or by whom it was written; two runs on the same
data with the same versions of matplotlib and of this package give identical files.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from fivebar_atlas.figures import style
from fivebar_atlas.output_file import atomic_output, check_output, checked_ending

#: Metadata of each format: what would carry a date is left out.
_METADATA: dict[str, dict[str, Any]] = {
    "png": {},
    "pdf": {"CreationDate": None},
    "svg": {"Date": None},
}

FORMATS = tuple(_METADATA)


def check_figure_output(path: Path, overwrite: bool = False) -> None:
    """Refuse an output that cannot be written, before the figure is made.

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
        If the folder is missing or not writable, or the file exists already.
    """
    checked_ending(path, FORMATS)
    check_output(path, overwrite)


def save_figure(
    figure: Figure, path: Path, overwrite: bool = False, resolution: float = style.RESOLUTION
) -> None:
    """Write a figure; a file appears whole under its name or not at all.

    Parameters
    ----------
    figure
        The figure.
    path
        The file; its ending decides the format.
    overwrite
        Whether an existing file may be replaced.
    resolution
        Dots per inch of a PNG file.

    Raises
    ------
    InputError
        If the ending is not that of a format.
    FileUsageError, FileError
        If the file cannot be written or exists already.
    """
    check_figure_output(path, overwrite)
    picture = rendered(figure, checked_ending(path, FORMATS), resolution)
    with atomic_output(path, overwrite) as temporary:
        temporary.write_bytes(picture)


def rendered(figure: Figure, form: str, resolution: float = style.RESOLUTION) -> bytes:
    """Return a figure as the bytes of a file.

    Parameters
    ----------
    figure
        The figure.
    form
        One of ``FORMATS``.
    resolution
        Dots per inch of a PNG file.
    """
    picture = io.BytesIO()
    with style.styled():
        figure.savefig(picture, format=form, dpi=resolution, metadata=_METADATA[form])
    return picture.getvalue()
