"""Mode pairs of manipulators with two actuated legs: ``"+-/up"`` as signs, and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fivebar_atlas.errors import UnknownNameError
from fivebar_atlas.mechanisms.quantities import MODE, THRESHOLD, Axis, AxisColumn, Flags

#: Working mode and assembly mode as ±1.
Signs = tuple[int, int, int]

#: Codes of the columns that name a mode pair. An assembly mode is the sign of a determinant.
WORKING_MODES = Flags(values=(0, 1, 2, 3), meanings=("+-", "-+", "++", "--"))
ASSEMBLY_MODES = Flags(values=(1, -1), meanings=("up", "down"))

#: All mode pairs, working mode by working mode.
MODE_PAIRS = tuple(
    f"{working}/{assembly}"
    for working in WORKING_MODES.meanings
    for assembly in ASSEMBLY_MODES.meanings
)

_LETTERS = str.maketrans("pm−", "+--")
_SIGN = {1: "+", -1: "-"}


def parse_mode_pair(text: str) -> str:
    """Return the canonical label of a mode pair.

    Parameters
    ----------
    text
        Working mode and assembly mode, ``"+-/up"`` or in letters ``"pm/up"``, in either case.

    Raises
    ------
    UnknownNameError
        If there is no such mode pair.
    """
    working, slash, assembly = text.strip().lower().partition("/")
    label = working.translate(_LETTERS) + slash + assembly
    if label not in MODE_PAIRS:
        raise UnknownNameError("mode", text, MODE_PAIRS)
    return label


def mode_signs(label: str) -> Signs:
    """Return the signs of a canonical label: of both legs and of the assembly mode."""
    working, _, assembly = label.partition("/")
    s1, s2 = (1 if sign == "+" else -1 for sign in working)
    return s1, s2, ASSEMBLY_MODES.values[ASSEMBLY_MODES.meanings.index(assembly)]


def mode_label(signs: Signs) -> str:
    """Return a mode pair as it is written, ``"+-/up"``."""
    assembly = ASSEMBLY_MODES.meanings[ASSEMBLY_MODES.values.index(signs[2])]
    return f"{_SIGN[signs[0]]}{_SIGN[signs[1]]}/{assembly}"


def mode_pairs(mode: str | None) -> tuple[Signs, ...]:
    """Return all mode pairs, the two of a working mode, or the one that is named.

    Raises
    ------
    UnknownNameError
        If there is no such mode.
    """
    if mode is None:
        labels = MODE_PAIRS
    elif "/" in mode:
        labels = (parse_mode_pair(mode),)
    else:
        try:
            labels = tuple(parse_mode_pair(f"{mode}/{name}") for name in ASSEMBLY_MODES.meanings)
        except UnknownNameError:
            raise UnknownNameError("mode", mode, WORKING_MODES.meanings) from None
    return tuple(mode_signs(label) for label in labels)


def mode_and_threshold_axes(
    labels: Sequence[str], thresholds: Sequence[float], determinant: str
) -> tuple[Axis, Axis]:
    """Return the axes of results that run over mode pairs and LCI thresholds.

    Parameters
    ----------
    labels
        Canonical labels of mode pairs.
    thresholds
        LCI thresholds.
    determinant
        What the sign of the assembly mode is that of, such as ``"det B"``.
    """
    pairs = [label.split("/") for label in labels]
    mode = Axis(
        name=MODE,
        labels=tuple(labels),
        columns=(
            _flag_column("working_mode", "working mode", WORKING_MODES, [p[0] for p in pairs]),
            _flag_column(
                "assembly_mode",
                f"assembly mode, the sign of {determinant}",
                ASSEMBLY_MODES,
                [p[1] for p in pairs],
            ),
        ),
    )
    threshold = Axis(
        name=THRESHOLD,
        labels=tuple(f"{value!r}" for value in thresholds),
        columns=(
            AxisColumn(
                "lci_threshold",
                np.array(thresholds, dtype=np.float64),
                "1",
                "least local conditioning index of the good-condition workspace",
            ),
        ),
    )
    return mode, threshold


def _flag_column(name: str, long_name: str, flags: Flags, meanings: Sequence[str]) -> AxisColumn:
    """Return the column of an axis that holds one code for each meaning."""
    codes = [flags.values[flags.meanings.index(meaning)] for meaning in meanings]
    return AxisColumn(name, np.array(codes, dtype=np.int8), "1", long_name, flags)
