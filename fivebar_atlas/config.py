"""Sweep configurations: TOML files, overrides, and the resolved configuration as text.

A configuration has two parts. ``mechanism`` and ``[sweep]`` determine the numbers; they
make up :class:`SweepSettings`, are stored in every result file as canonical TOML, and
their hash decides whether a sweep may be resumed. ``[run]`` says how the work is done and
does not enter the numbers.
"""

from __future__ import annotations

import dataclasses
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from fivebar_atlas import mechanisms
from fivebar_atlas.errors import FileError, FileUsageError, InputError, UnknownNameError
from fivebar_atlas.mechanisms.base import Mechanism
from fivebar_atlas.mechanisms.settings import Options, SweepSettings

#: Far above any machine's number of cores, so that a slip of the keyboard is caught.
MOST_THREADS = 1024

#: Where blocks of designs can be computed, the default first.
EXECUTORS = ("threads", "dask")

_STRICT = ConfigDict(strict=True, extra="forbid", frozen=True)

# What a value of the wrong type should have been, by pydantic's name of the fault.
_EXPECTED = {
    "int_type": "an integer",
    "float_type": "a number",
    "string_type": "a text in quotation marks",
    "list_type": "a list in square brackets",
    "model_type": "a table",
    "dict_type": "a table",
}


class SweepSection(BaseModel):
    """The table ``[sweep]``: what is computed."""

    model_config = _STRICT

    resolution: int | None = None
    space: str | None = None
    mode: list[str] | None = None
    lci: list[float] | None = None
    tolerance: float | None = None
    options: dict[str, Any] | None = None


class RunSection(BaseModel):
    """The table ``[run]``: how the work is done."""

    model_config = _STRICT

    threads: int | None = None
    output: str | None = None
    executor: str | None = None
    scheduler: str | None = None
    scheduler_file: str | None = None


class ConfigurationFile(BaseModel):
    """A configuration file, its values not yet checked against the mechanism."""

    model_config = _STRICT

    mechanism: str | None = None
    sweep: SweepSection = SweepSection()
    run: RunSection = RunSection()


@dataclasses.dataclass(frozen=True, slots=True)
class Overrides:
    """Values given on the command line; None where the file or the default counts."""

    mechanism: str | None = None
    resolution: int | None = None
    space: str | None = None
    mode: tuple[str, ...] | None = None
    lci: tuple[float, ...] | None = None
    tolerance: float | None = None
    options: Mapping[str, object] | None = None
    threads: int | None = None
    output: str | None = None
    executor: str | None = None
    scheduler: str | None = None
    scheduler_file: str | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class Configuration:
    """A resolved configuration.

    Attributes
    ----------
    settings
        What is computed.
    threads
        Number of threads, None for one a core.
    output
        Result file, None where none was named.
    executor
        Where blocks are computed, one of :data:`EXECUTORS`.
    scheduler, scheduler_file
        Address of a Dask scheduler, or the file that it is in; both None for a cluster of this
        machine.
    """

    settings: SweepSettings
    threads: int | None = None
    output: Path | None = None
    executor: str = EXECUTORS[0]
    scheduler: str | None = None
    scheduler_file: str | None = None


def load(path: str | os.PathLike[str]) -> ConfigurationFile:
    """Read a configuration file; its keys and types are checked, its values not yet.

    Parameters
    ----------
    path
        A TOML file.

    Returns
    -------
    ConfigurationFile
        The values that the file gives.

    Raises
    ------
    FileUsageError
        If there is no such file, or it is not TOML; the message names line and column.
    FileError
        If it cannot be read.
    UnknownNameError
        If a key is unknown; the nearest known one is offered.
    InputError
        If a value has the wrong type.
    """
    try:
        text = Path(path).read_bytes().decode()
    except FileNotFoundError:
        raise FileUsageError(path, "there is no such file") from None
    except IsADirectoryError:
        raise FileUsageError(path, "is a folder, not a configuration file") from None
    except UnicodeDecodeError as error:
        raise FileUsageError(path, f"is not TOML: {error}") from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from None
    return _parse(text, str(path))


def resolve(
    path: str | os.PathLike[str] | None = None, overrides: Overrides | None = None
) -> Configuration:
    """Merge defaults, a configuration file and the command line, the latter winning.

    Parameters
    ----------
    path
        Configuration file, None for none.
    overrides
        Values from the command line.

    Returns
    -------
    Configuration
        Every value checked against the mechanism.

    Raises
    ------
    AtlasError
        As :func:`load`, and InputError or UnknownNameError where a value is not allowed;
        the message names the option, or the dotted key and the file.
    """
    file = load(path) if path is not None else ConfigurationFile()
    return _merge(file, str(path), overrides or Overrides())


def settings_from_text(text: str, source: str) -> SweepSettings:
    """Return the settings that :func:`render_settings` wrote.

    Parameters
    ----------
    text
        TOML text.
    source
        Where the text comes from, for messages.

    Raises
    ------
    AtlasError
        If the text is not a valid configuration.
    """
    return _merge(_parse(text, source), source, Overrides()).settings


def render_settings(settings: SweepSettings) -> str:
    """Return the settings as canonical TOML: equal settings give equal text.

    Options of the mechanism have a table of their own, all of them; without any there is none.
    """
    options = mechanisms.get(settings.mechanism).complete_options(settings.options)
    table = "".join(f"{name} = {_toml_value(value)}\n" for name, value in options)
    modes = ", ".join(_toml_text(label) for label in settings.modes)
    thresholds = ", ".join(repr(float(value)) for value in settings.lci_thresholds)
    return (
        f"mechanism = {_toml_text(settings.mechanism)}\n"
        "\n"
        "[sweep]\n"
        f"resolution = {settings.resolution}\n"
        f"space = {_toml_text(settings.space)}\n"
        f"mode = [{modes}]\n"
        f"lci = [{thresholds}]\n"
        f"tolerance = {float(settings.tolerance)!r}\n"
    ) + (f"\n[sweep.options]\n{table}" if table else "")


def render(configuration: Configuration) -> str:
    """Return a resolved configuration as TOML that gives the same when it is read."""
    lines = ["", "[run]"]
    if configuration.threads is None:
        lines.append("# threads: not set, one for each core")
    else:
        lines.append(f"threads = {configuration.threads}")
    if configuration.output is None:
        lines.append("# output: not set, to be given as -o FILE.h5")
    else:
        lines.append(f"output = {_toml_text(str(configuration.output))}")
    if configuration.executor != EXECUTORS[0]:
        lines.append(f"executor = {_toml_text(configuration.executor)}")
    named = {
        "scheduler": configuration.scheduler,
        "scheduler_file": configuration.scheduler_file,
    }
    lines.extend(f"{key} = {_toml_text(text)}" for key, text in named.items() if text is not None)
    return render_settings(configuration.settings) + "\n".join(lines) + "\n"


def _parse(text: str, source: str) -> ConfigurationFile:
    """Return the values of a TOML text, keys and types checked."""
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FileUsageError(source, f"is not TOML: {error}") from None
    _check_keys(values, source)
    try:
        return ConfigurationFile.model_validate(values)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        expected = _EXPECTED.get(fault["type"], fault["msg"])
        raise InputError(_name(fault["loc"], source), fault["input"], expected) from None


def _name(location: tuple[int | str, ...], source: str) -> str:
    """Return how a value of a file is named in messages: its dotted key and the file."""
    key = ".".join(str(part) for part in location)
    return f"{key} in {source}"


def _check_keys(values: dict[str, Any], source: str) -> None:
    """Raise UnknownNameError at the first key that is not known."""
    known = list(_dotted_keys(ConfigurationFile))
    for key, value in values.items():
        if key not in ConfigurationFile.model_fields:
            # A key may have been meant for a table, a table only to be one.
            tables = list(ConfigurationFile.model_fields)
            raise UnknownNameError(source, key, tables if isinstance(value, dict) else known)
        if not isinstance(value, dict):
            continue
        for name in (f"{key}.{inner}" for inner in value):
            if name not in known:
                raise UnknownNameError(source, name, known)


def _dotted_keys(model: type[BaseModel]) -> Iterator[str]:
    """Yield the dotted keys of a model."""
    for key, field in model.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from (f"{key}.{inner}" for inner in _dotted_keys(field.annotation))
        else:
            yield key


def _without_overridden(run: RunSection, overrides: Overrides) -> RunSection:
    """Return what a file says of running, without what a choice on the command line replaces."""
    dropped: tuple[str, ...] = ()
    if overrides.scheduler is not None or overrides.scheduler_file is not None:
        dropped = ("executor", "scheduler", "scheduler_file")
    elif overrides.executor is not None:
        dropped = ("scheduler", "scheduler_file") if overrides.executor != EXECUTORS[1] else ()
    return run.model_copy(update=dict.fromkeys(dropped))


def _merge(file: ConfigurationFile, source: str, overrides: Overrides) -> Configuration:
    """Return the configuration, each value checked under the name the user gave it by."""

    def pick(key: str, given: Any, from_file: Any, default: Any) -> tuple[Any, str]:
        if given is not None:
            return given, f"--{key.replace('_', '-')}"
        if from_file is not None:
            table = "run." if key in RunSection.model_fields else "sweep."
            return from_file, _name((("" if key == "mechanism" else table) + key,), source)
        return default, key

    sweep, run = file.sweep, file.run
    chosen, name = pick("mechanism", overrides.mechanism, file.mechanism, mechanisms.names()[0])
    if chosen not in mechanisms.names():
        raise UnknownNameError(name, chosen, mechanisms.names())
    mechanism: Mechanism = mechanisms.get(chosen)

    default = mechanism.default_resolution
    resolution, name = pick("resolution", overrides.resolution, sweep.resolution, default)
    mechanism.check_resolution(resolution, name)

    space, name = pick("space", overrides.space, sweep.space, mechanism.spaces[0])
    space = mechanism.parse_space(space, name)

    texts, name = pick("mode", overrides.mode, sweep.mode, mechanism.modes[:1])
    modes = mechanism.parse_modes(texts, name)

    usual = mechanism.default_lci_thresholds
    thresholds, name = pick("lci", overrides.lci, sweep.lci, usual)
    mechanism.check_thresholds(thresholds, name)

    default_tolerance = mechanism.default_tolerance
    tolerance, name = pick("tolerance", overrides.tolerance, sweep.tolerance, default_tolerance)
    mechanism.check_tolerance(tolerance, name)

    options = _options(mechanism, overrides.options, sweep.options, source)

    threads, name = pick("threads", overrides.threads, run.threads, None)
    if threads is not None and not 1 <= threads <= MOST_THREADS:
        raise InputError(name, threads, f"an integer from 1 to {MOST_THREADS}")

    output, name = pick("output", overrides.output, run.output, None)
    if output is not None and not output.strip():
        raise InputError(name, output, "the path of a result file")

    run = _without_overridden(run, overrides)
    executor, name = pick("executor", overrides.executor, run.executor, None)
    scheduler, address = pick("scheduler", overrides.scheduler, run.scheduler, None)
    given = overrides.scheduler_file
    scheduler_file, file_name = pick("scheduler_file", given, run.scheduler_file, None)
    if scheduler is not None and scheduler_file is not None:
        raise InputError(file_name, scheduler_file, f"no file beside {address}")
    if executor is None:
        # a scheduler is one of Dask
        is_named = scheduler is not None or scheduler_file is not None
        executor = EXECUTORS[1] if is_named else EXECUTORS[0]
    if executor not in EXECUTORS:
        raise UnknownNameError(name, executor, EXECUTORS)
    if executor != EXECUTORS[1]:
        for text, what in ((scheduler, address), (scheduler_file, file_name)):
            if text is not None:
                raise InputError(what, text, f"no scheduler with the executor {executor}")

    return Configuration(
        settings=SweepSettings(
            mechanism=chosen,
            space=space,
            resolution=resolution,
            modes=modes,
            lci_thresholds=tuple(float(value) for value in thresholds),
            tolerance=float(tolerance),
            options=options,
        ),
        threads=threads,
        output=None if output is None else Path(output),
        executor=executor,
        scheduler=scheduler,
        scheduler_file=scheduler_file,
    )


def _options(
    mechanism: Mechanism,
    given: Mapping[str, object] | None,
    from_file: Mapping[str, object] | None,
    source: str,
) -> Options:
    """Return all options of a mechanism, each one checked under the name it was given by."""
    given = given or {}

    def named(name: str) -> str:
        return f"--set {name}" if name in given else _name(("sweep", "options", name), source)

    # together: the ends of a range may come from either
    return mechanism.complete_options({**(from_file or {}), **given}, named)


def _toml_value(value: float | bool) -> str:
    """Return a number or a truth value as TOML."""
    return str(value).lower() if isinstance(value, bool) else repr(float(value))


def _toml_text(text: str) -> str:
    """Return a text as a TOML basic string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    plain = "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped)
    return f'"{plain}"'
