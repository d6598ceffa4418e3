"""Motion files: TOML with a machine, a motion and a load; its keys and types.

The format is described in ``docs/trajectory.md``. Values that need the mechanism, such as the
names of coordinates, are looked at by :mod:`fivebar_atlas.trajectories.motion_problem`.
"""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from fivebar_atlas.errors import (
    FileError,
    FileUsageError,
    InputError,
    MissingInputError,
    UnknownNameError,
)

_STRICT = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

#: Numbers farther from 0 than this are mistakes; squares of what is made of them are still numbers.
GREATEST = 1e30

# What a value of the wrong type should have been, by pydantic's name of the fault.
_EXPECTED = {
    "int_type": "an integer",
    "float_type": "a number",
    "finite_number": "a finite number",
    "string_type": "a text in quotation marks",
    "list_type": "a list in square brackets",
    "model_type": "a table",
    "dict_type": "a table",
    "bool_type": "true or false",
}


class UnitsSection(BaseModel):
    """The table ``[units]``: what the numbers are in; angles are always in degrees."""

    model_config = _STRICT

    length: str = "mm"
    force: str = "N"
    time: str = "s"


class MotionSection(BaseModel):
    """The table ``[motion]``: how long, how finely, and which coordinate is solved for."""

    model_config = _STRICT

    duration: float | None = None
    samples: int | None = None
    file: str | None = None
    solve: str | None = None
    start: float = 0.0
    constraint_tolerance: float | None = None
    acceleration_tolerance: float | None = None
    coordinates: dict[str, Any] = {}


class LoadSection(BaseModel):
    """The table ``[load]``: force and moment on the platform."""

    model_config = _STRICT

    force: list[Any] | None = None
    moment: list[Any] | None = None
    point: list[float] = [0.0, 0.0, 0.0]
    axes: Literal["base", "platform"] = "base"


class LimitsSection(BaseModel):
    """The table ``[limits]``: what the joints allow."""

    model_config = _STRICT

    least_length: Any = None
    greatest_length: Any = None
    base_joint_limit: float | None = None
    platform_joint_limit: float | None = None


class MotionFile(BaseModel):
    """A motion file, its values not yet checked against the mechanism."""

    model_config = _STRICT

    mechanism: str | None = None
    characteristic_length: float | None = None
    units: UnitsSection = UnitsSection()
    geometry: dict[str, Any] = {}
    motion: MotionSection
    load: LoadSection = LoadSection()
    limits: LimitsSection = LimitsSection()


class PolynomialTable(BaseModel):
    """``kind = "polynomial"``: c0 + c1 t + c2 t² + ..."""

    model_config = _STRICT

    kind: Literal["polynomial"]
    coefficients: list[float]


class PiecesTable(BaseModel):
    """``kind = "pieces"``: a polynomial in the time since the last break, for each piece."""

    model_config = _STRICT

    kind: Literal["pieces"]
    breaks: list[float]
    coefficients: list[list[float]]


class SplineTable(BaseModel):
    """``kind = "spline"``: the spline through points."""

    model_config = _STRICT

    kind: Literal["spline"]
    times: list[float]
    values: list[float]
    degree: int = 5
    ends: Literal["not-a-knot", "natural", "clamped"] = "clamped"


class StopsTable(BaseModel):
    """``kind = "stops"``: from point to point with the least jerk, at rest at each."""

    model_config = _STRICT

    kind: Literal["stops"]
    times: list[float]
    values: list[float]


Table = TypeVar("Table", bound=BaseModel)

FunctionTable = PolynomialTable | PiecesTable | SplineTable | StopsTable
_KINDS: dict[str, type[PolynomialTable | PiecesTable | SplineTable | StopsTable]] = {
    "polynomial": PolynomialTable,
    "pieces": PiecesTable,
    "spline": SplineTable,
    "stops": StopsTable,
}


def read_motion_file(
    path: str | os.PathLike[str], settings: Mapping[str, Any]
) -> tuple[MotionFile, dict[str, Any]]:
    """Read a motion file; its keys and types are checked.

    Parameters
    ----------
    path
        A TOML file, or a CSV file of poses, which stands for ``motion.file``.
    settings
        Values by dotted key that win over those of the file.

    Returns
    -------
    MotionFile
        The values.
    dict
        The same as plain tables, for the record.

    Raises
    ------
    FileUsageError
        If there is no such file, it is not TOML, or its name ends otherwise.
    FileError
        If it cannot be read.
    UnknownNameError
        If a key is unknown; the nearest known one is offered.
    InputError
        If a value has the wrong type or a key is missing.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending == ".csv":
        if not path.exists():
            raise FileUsageError(path, "there is no such file")
        values: dict[str, Any] = {"motion": {"file": path.name}}
    elif ending == ".toml":
        values = _toml(path)
    else:
        raise FileUsageError(path, "is neither a .toml file of a motion nor a .csv file of poses")
    for key, value in settings.items():
        _set(values, key, value)
    _check_sizes(values, "", str(path))
    return checked_table(MotionFile, values, "", str(path)), values


def checked_function(value: object, name: str, source: str) -> float | FunctionTable:
    """Return a function of time as it stands in a file: a number, or a table with a kind.

    Parameters
    ----------
    value
        What the file has.
    name
        Its dotted key.
    source
        The file, for messages.

    Raises
    ------
    UnknownNameError
        If there is no such kind, or a key is unknown.
    InputError
        If it is neither, or a value has the wrong type.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        number = float(value)
        if number - number != 0.0:
            raise InputError(key_in(name, source), value, "a finite number")
        return number
    kinds = ", ".join(f'"{kind}"' for kind in _KINDS)
    if not isinstance(value, dict):
        raise InputError(key_in(name, source), value, f"a number, or a table with a kind: {kinds}")
    kind = value.get("kind")
    if kind is None:
        raise MissingInputError(key_in(f"{name}.kind", source), f"a kind of function: {kinds}")
    if not isinstance(kind, str) or kind not in _KINDS:
        raise UnknownNameError(key_in(f"{name}.kind", source), str(kind), _KINDS)
    return checked_table(_KINDS[kind], value, name, source)


def checked_table(model: type[Table], values: Mapping[str, Any], name: str, source: str) -> Table:
    """Return a table of a file as a model, each fault named by its dotted key."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join([*([name] if name else []), *map(str, fault["loc"])])
        if fault["type"] == "extra_forbidden":
            raise UnknownNameError(
                key_in(key, source), str(fault["loc"][-1]), _known(model, fault["loc"][:-1])
            ) from None
        if fault["type"] == "missing":
            raise MissingInputError(key_in(key, source), "a value for this key") from None
        expected = _EXPECTED.get(fault["type"], fault["msg"])
        raise InputError(key_in(key, source), fault["input"], expected) from None


def key_in(key: str, source: str) -> str:
    """Return how a value of a file is named in messages: its dotted key and the file.

    A table of poses has no keys: where it stands for a motion file, all are set besides.
    """
    if source.lower().endswith(".csv"):
        return f"--set {key}"
    return f"{key} in {source}"


def rendered(values: Mapping[str, Any]) -> str:
    """Return plain tables as TOML."""
    return "".join(_lines(values, ""))


def _known(model: type[BaseModel], location: Sequence[int | str]) -> list[str]:
    """Return the keys of a model, or of one within."""
    for part in location:
        inner = model.model_fields[str(part)].annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            model = inner
    return list(model.model_fields)


def _toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file."""
    try:
        text = path.read_bytes().decode()
    except (FileNotFoundError, NotADirectoryError):
        raise FileUsageError(path, "there is no such file") from None
    except IsADirectoryError:
        raise FileUsageError(path, "is a folder, not a motion file") from None
    except UnicodeDecodeError as error:
        raise FileUsageError(path, f"is not TOML: {error}") from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from None
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FileUsageError(path, f"is not TOML: {error}") from None


def _check_sizes(value: object, key: str, source: str) -> None:
    """Raise InputError at the first number, however deep, that is too large to compute with."""
    if isinstance(value, dict | list):
        inner = value.items() if isinstance(value, dict) else enumerate(value)
        for name, each in inner:
            _check_sizes(each, f"{key}.{name}" if key else str(name), source)
    elif isinstance(value, int | float) and GREATEST < abs(value) < math.inf:
        raise InputError(key_in(key, source), value, f"a number up to {GREATEST:g} in size")


def _set(values: dict[str, Any], key: str, value: object) -> None:
    """Set a value by its dotted key."""
    *tables, last = key.split(".")
    place = values
    for table in tables:
        inner = place.setdefault(table, {})
        if not isinstance(inner, dict):
            raise InputError(f"--set {key}", value, f"a key of a table; {table} is a value")
        place = inner
    place[last] = value


def _lines(values: Mapping[str, Any], table: str) -> list[str]:
    """Return the lines of a table and of those within."""
    plain = {key: value for key, value in values.items() if not isinstance(value, dict)}
    inner = {key: value for key, value in values.items() if isinstance(value, dict)}
    lines = [f"{key} = {_value(value)}\n" for key, value in plain.items()]
    if table and (lines or not inner):
        lines.insert(0, f"\n[{table}]\n")
    for key, value in inner.items():
        lines += _lines(value, f"{table}.{key}" if table else key)
    return lines


def _value(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped) + '"'
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_value(each)}" for key, each in value.items()) + "}"
    return repr(value)
