"""The errors a user can cause or meet, as types.

Every error carries a finished, one-sentence message and the exit code that the
command line returns for it: 2 where the input was wrong, 1 where the work failed.
Nothing here knows the command line; it only says what went wrong.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

# Names that a message has at most, and those of more that are nearest to what was given.
_MANY, _NEAREST, _LIKENESS = 12, 5, 0.5


class AtlasError(Exception):
    """Base of everything this package raises on purpose.

    Attributes
    ----------
    exit_code
        Exit code of the process when the error reaches the command line.
    """

    exit_code = 1


class InputError(AtlasError, ValueError):
    """A value given by the user is not allowed.

    Parameters
    ----------
    name
        Name of the input as the user wrote it (an option, an argument, a dotted key).
    value
        The value that was given.
    allowed
        What would have been allowed, as a phrase: ``"a number from 1e-10 to 1e-3"``.
    """

    exit_code = 2

    def __init__(self, name: str, value: Any, allowed: str) -> None:
        super().__init__(f"{name}: {value!r} is not allowed; expected {allowed}")
        self.name = name
        self.value = value
        self.allowed = allowed

    def renamed(self, name: str, value: Any) -> InputError:
        """Return the same error for a value under another name, as the user wrote both."""
        return InputError(name, value, self.allowed)


class MissingInputError(InputError):
    """A value that must be given is not."""

    def __init__(self, name: str, expected: str) -> None:
        super().__init__(name, None, expected)
        self.args = (f"{name} is missing; expected {expected}",)

    def renamed(self, name: str, value: Any) -> InputError:  # noqa: ARG002
        """Return the same error for an input under another name."""
        return MissingInputError(name, self.allowed)


class UnknownNameError(InputError):
    """A name is not among those there are; the nearest known one is offered.

    Parameters
    ----------
    name, value
        As for :class:`InputError`.
    known
        Names that there are.
    listed_by
        What lists them all, ``"'atlas mechanisms five-bar'"``: of many names the message then has
        only the nearest ones. Empty where nothing else does.
    """

    def __init__(self, name: str, value: str, known: Iterable[str], listed_by: str = "") -> None:
        known = list(known)
        near = difflib.get_close_matches(str(value), known, n=1)
        hint = f" (did you mean {near[0]!r}?)" if near else ""
        super().__init__(name, value, f"one of {_names(value, known, listed_by)}{hint}")
        self.known = known
        self.listed_by = listed_by

    def renamed(self, name: str, value: Any) -> InputError:
        """Return the same error for a value under another name, as the user wrote both."""
        return UnknownNameError(name, value, self.known, self.listed_by)


class ForeignNameError(UnknownNameError):
    """A name that is not among those of the mechanism of a file, but one of another mechanism.

    Parameters
    ----------
    name, value, known
        As for :class:`UnknownNameError`.
    kind
        What the name is there: ``"quantity"``, ``"parameter"`` or ``"mode pair"``.
    owners
        The mechanisms whose name it is.
    own
        The mechanism of the file.
    listed_by
        As for :class:`UnknownNameError`.
    """

    def __init__(
        self,
        name: str,
        value: str,
        known: Iterable[str],
        kind: str,
        owners: Sequence[str],
        own: str,
        listed_by: str = "",
    ) -> None:
        super().__init__(name, value, known, listed_by)
        self.kind, self.owners, self.own = kind, owners, own
        self.args = (
            f"{name}: {value!r} is a {kind} of {', '.join(owners)}; this file is of {own}, "
            f"which has {_names(value, self.known, listed_by)}",
        )

    def renamed(self, name: str, value: Any) -> InputError:
        """Return the same error for a value under another name, as the user wrote both."""
        kind, owners, own = self.kind, self.owners, self.own
        return ForeignNameError(name, value, self.known, kind, owners, own, self.listed_by)


def _names(value: str, known: Sequence[str], listed_by: str) -> str:
    """Return known names in a line: all, or of many those nearest to what was given."""
    if not listed_by or len(known) <= _MANY:
        return ", ".join(known)
    near = difflib.get_close_matches(str(value), known, _NEAREST, _LIKENESS)
    shown = near or known[:_NEAREST]
    return f"{', '.join(shown)} and {len(known) - len(shown)} more that {listed_by} lists"


class OutOfReachError(InputError):
    """A point that a linkage does not reach, or inputs for which it cannot be assembled.

    Parameters
    ----------
    name
        Name of the input, ``"P"``.
    value
        The coordinates or the angles.
    allowed
        What would have been allowed, ``{gap}`` in place of the length that is missing.
    gap
        That length.
    unit
        Its unit; empty where it is non-dimensional.
    """

    def __init__(
        self, name: str, value: tuple[float, ...], allowed: str, gap: float, unit: str = ""
    ) -> None:
        length = f"{gap:.6g} {unit}".rstrip()
        super().__init__(name, value, allowed.format(gap=length))
        self.gap = gap
        self._template = allowed

    def scaled(self, factor: float, unit: str, scale_value: bool) -> OutOfReachError:
        """Return the same error with lengths times a factor, in a unit."""
        value = tuple(factor * part for part in self.value) if scale_value else self.value
        return OutOfReachError(self.name, value, self._template, factor * self.gap, unit)


class InvalidPoseError(InputError):
    """A pose that a passive joint does not allow.

    Parameters
    ----------
    name
        Name of the input, ``"pose"``.
    value
        Coordinates of the pose.
    residual
        By how much the joint is torn apart, a length.
    index
        Which of the poses it is, the first of them.
    """

    def __init__(
        self, name: str, value: tuple[float, ...], residual: float, index: tuple[int, ...]
    ) -> None:
        where = f"{name}{list(index)}" if index else name
        allowed = f"a pose that the passive joint allows; there it is {residual:.6g} apart"
        super().__init__(where, value, allowed)
        self.residual = residual
        self.index = index


class SingularPoseError(AtlasError):
    """A pose in which the inputs do not determine the motion or the forces.

    Parameters
    ----------
    index
        Which of the poses it is, the first of them; empty where there is only one.
    ratio
        Smallest over largest singular value of the Jacobian there.
    """

    def __init__(self, index: tuple[int, ...], ratio: float) -> None:
        where = f"pose {list(index)}" if index else "the pose"
        super().__init__(f"{where} is singular: the Jacobian has σ_min/σ_max = {ratio:.3g}")
        self.index = index
        self.ratio = ratio


class InfeasiblePathError(AtlasError):
    """A path that a linkage cannot follow in one mode pair."""


class MotionError(AtlasError):
    """A motion that a mechanism cannot make, or that is not smooth enough to be solved.

    Parameters
    ----------
    what
        What is wrong, where and by how much, as a sentence.
    time
        The time of it, in the unit of the motion; None where it is not one time.
    """

    exit_code = 2

    def __init__(self, what: str, time: float | None = None) -> None:
        super().__init__(what)
        self.time = time


class InfeasibleSizeError(AtlasError):
    """A practical workspace that no size of a machine has, or none within its limits."""


class NoDesignError(AtlasError):
    """Conditions that no design fulfils, where there is nothing to show without one."""


class FileError(AtlasError):
    """A file cannot be read, is not what it should be, or cannot be written.

    Parameters
    ----------
    path
        The file or folder.
    reason
        What is wrong with it and what to do, as a phrase.
    """

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(f"{path}: {reason}")
        self.path = str(path)
        self.reason = reason


class FileUsageError(FileError):
    """A file was named that cannot be meant: missing input, output that exists already."""

    exit_code = 2


class ClusterError(AtlasError):
    """A cluster cannot be used, or its workers cannot do the work; the message says why."""


class MissingExtraError(AtlasError):
    """A package that is not installed is needed.

    Parameters
    ----------
    purpose
        What needs it, as a phrase.
    extra
        The extra of this package that installs it.
    """

    exit_code = 2

    def __init__(self, purpose: str, extra: str) -> None:
        super().__init__(f"{purpose} needs the extra: pip install 'fivebar-atlas[{extra}]'")


class LostBlocksError(AtlasError):
    """Blocks of a sweep that cannot be computed; the message names their designs and says why."""
