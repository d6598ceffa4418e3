"""Largest squares as text, as sections of a report and as JSON."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from fivebar_atlas.cli.machine_text import text_line
from fivebar_atlas.cli.presentation import Captioned, Row, Section, Table, titled
from fivebar_atlas.cli.square_figures import draw_curve, draw_optimal_configuration, draw_square

if TYPE_CHECKING:
    from fivebar_atlas.synthesis.largest_square import Square, SquareTask
    from fivebar_atlas.synthesis.least_lci import LeastLci
    from fivebar_atlas.synthesis.square_curve import SquareCurve
    from fivebar_atlas.synthesis.square_gains import Gain

# What Le, Kang and Doan (2013), Sec. IV, print as the optimum of their example.
_PRINTED_RATIO, _PRINTED_SIDE = 1.9721, 1.3142
# Half a unit of its last digit.
_PRINTED_ACCURACY = 5e-5
# Share within which a ratio is the end of a range.
_END = 1e-7
# A coordinate in lengths of the actuated link that is nothing but rounding.
_ROUNDING = 1e-7
# Share within which the square reaches its side, for the proof.
_ALLOWANCE = 1e-9


@dataclasses.dataclass(frozen=True)
class SquareText:
    """One largest square as it is written down.

    Attributes
    ----------
    square
        The square, of a side above 0.
    length
        Length of the actuated link.
    unit
        Its unit; empty where there is none.
    """

    square: Square
    length: float
    unit: str

    @property
    def title(self) -> str:
        """What was found."""
        return f"Largest {self.noun} workspace"

    @property
    def noun(self) -> str:
        """What it is called: a square, or a rectangle."""
        return "square" if self.square.task.aspect == 1.0 else "rectangle"

    @property
    def summary(self) -> str:
        """The result in a sentence."""
        task = self.square.task
        return (
            f"The LCI is at least {task.lci_threshold:g} in a whole {self.noun} of "
            f"{self._size}, in the mode pair {task.mode}."
        )

    @functools.cached_property
    def least(self) -> LeastLci:
        """The least LCI over the square."""
        from fivebar_atlas.synthesis.largest_square import unit_design
        from fivebar_atlas.synthesis.least_lci import least_lci

        square = self.square
        design, factor = unit_design(square.task.mechanism, square.lengths)
        x, y = square.centre
        return least_lci(
            design,
            square.task.mode,
            square.task.shape,
            (x / factor, y / factor),
            square.side * (1.0 - _ALLOWANCE) / factor,
        )

    def document(self) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON."""
        return {**task_document(self.square.task, self.length, self.unit), **self.values()}

    def values(self) -> dict[str, Any]:
        """Return what was found, without what was asked."""
        square, scale = self.square, self.length
        circle = square.circle
        return {
            "ratio": square.ratio,
            "l1": scale,
            "l2": scale * square.lengths[1],
            "l0": scale * square.lengths[2],
            "side": scale * square.side,
            "width": scale * square.width,
            "height": scale * square.height,
            "centre": [scale * part for part in square.centre],
            "mode": square.task.mode,
            "inscribed_circle": None
            if circle is None
            else {
                "radius": scale * circle.radius,
                "centre": [scale * part for part in circle.centre],
            },
            "active": list(square.active),
            "contacts": [[scale * part for part in contact] for contact in square.contacts],
            "least_lci": self.least.value,
            "least_lci_bound": self.least.bound,
            "is_proved": square.proof is not None and square.proof.verdict == "inside",
        }

    def lines(self) -> Iterator[str]:
        """Yield the lines of a readable report."""
        for row in (*task_rows(self.square.task), *self.rows()):
            yield text_line(row.label, row.value, row.error)

    def rows(self) -> Iterator[Row]:
        """Yield what is known of the square."""
        square = self.square
        lengths = (self.length * each for each in square.lengths)
        l1, l2, l0 = (f"{each:.10g}" for each in lengths)
        yield Row("ratio ρ = l2/l1", f"{square.ratio:.10g}")
        yield Row("l1, l2, l0", f"{l1}, {l2}, {l0} {self.unit}".rstrip())
        if square.task.aspect == 1.0:
            yield Row("side a", self._length(square.side), f"± {_ALLOWANCE:.0e} of it")
        else:
            size = f"{self._length(square.width)} x {self._length(square.height)}"
            yield Row("width x height", size, f"± {_ALLOWANCE:.0e} of it")
        yield Row("centre", self._place(square.centre))
        if square.circle is not None:
            circle = square.circle
            text = f"radius {self._length(circle.radius)} about {self._place(circle.centre)}"
            yield Row("maximal inscribed circle", text)
        yield Row("active", ", ".join(square.active) or "none")
        for contact in square.contacts:
            yield Row("contact", self._place(contact))
        least, place = self.least, self.least.position
        factor = square.task.mechanism.from_lengths(square.lengths)[1]
        at = self._place((factor * place[0], factor * place[1]))
        below = max(least.value - least.bound, 0.0)
        yield Row("least LCI", f"{least.value:.10g} at {at}", f"- {below:.0e}")
        if square.proof is not None:
            shown = f"proved with {square.proof.squares} squares"
            yield Row("containment", shown if square.proof.verdict == "inside" else "not proved")

    def sections(self) -> list[Section]:
        """Return choices and square as sections of a report."""
        return [
            Section("Choices", rows=titled(task_rows(self.square.task))),
            Section(f"The {self.noun}", rows=titled(self.rows())),
        ]

    def figures(self) -> list[Captioned]:
        """Return the LCI in the square and the machine in its optimal configuration."""
        square = self.square
        text = (
            f"The {self.noun}, the maximal inscribed circle and the local conditioning index (LCI) "
            "in them, in lengths of the actuated link."
        )
        return [Captioned(text, lambda: draw_square(square))]

    @property
    def _size(self) -> str:
        if self.square.task.aspect == 1.0:
            return f"side {self._length(self.square.side, 7)}"
        return f"{self._length(self.square.width, 7)} x {self._length(self.square.height, 7)}"

    def _length(self, value: float, digits: int = 10) -> str:
        return f"{self.length * value:.{digits}g} {self.unit}".rstrip()

    def _place(self, point: tuple[float, float]) -> str:
        x, y = (self.length * (0.0 if abs(part) < _ROUNDING else part) for part in point)
        return f"({x:.8g}, {y:.8g}) {self.unit}".rstrip()


@dataclasses.dataclass(frozen=True)
class SquareCurveText:
    """Largest squares over a range of ratios as they are written down.

    Attributes
    ----------
    curve
        The squares, with a largest one.
    gains
        What is gained where something is free; empty where nothing was asked.
    length, unit
        Length of the actuated link and its unit.
    """

    curve: SquareCurve
    gains: list[Gain]
    length: float
    unit: str

    @property
    def title(self) -> str:
        """What was found."""
        return f"{self._best.title} over the ratio of links"

    @property
    def summary(self) -> str:
        """The result in a sentence."""
        best = self._best
        return f"{best.summary} The ratio of links that has it is ρ = {best.square.ratio:.7g}."

    def document(self) -> dict[str, Any]:
        """Return everything as nested dictionaries, ready for JSON."""
        curve, scale = self.curve, self.length
        document: dict[str, Any] = {
            **task_document(self._task, self.length, self.unit),
            "ratios": [square.ratio for square in curve.squares],
            "sides": [scale * square.side for square in curve.squares],
            "pieces": [
                {"from": piece.start, "to": piece.end, "active": list(piece.active)}
                for piece in curve.pieces
            ],
            "largest": {**self._best.values(), "is_kink": curve.is_kink},
            "printed": None,
            "gains": [
                {
                    "free": gain.name,
                    "gain": gain.gain,
                    **SquareText(gain.square, self.length, self.unit).values(),
                }
                for gain in self.gains
            ],
        }
        if self._at_printed is not None:
            document["printed"] = {
                "ratio": _PRINTED_RATIO,
                "side": _PRINTED_SIDE,
                "own_side_at_that_ratio": self._at_printed,
                "is_reproduced": self._is_reproduced,
            }
        return document

    def table(self) -> list[list[Any]]:
        """Return the curve as a table, the head first."""
        suffix = f"_{self.unit}" if self.unit else ""
        rows: list[list[Any]] = [["ratio", f"side{suffix}", f"centre_y{suffix}", "active"]]
        for square in self.curve.squares:
            values = [square.ratio, self.length * square.side, self.length * square.centre[1]]
            rows.append([*(repr(value) for value in values), "; ".join(square.active)])
        return rows

    def lines(self) -> Iterator[str]:
        """Yield the lines of a readable report."""
        for row in task_rows(self._task):
            yield text_line(row.label, row.value, row.error)
        yield ""
        yield f"{'ρ from':>14}{'to':>14}  active"
        for piece in self.curve.pieces:
            active = ", ".join(piece.active) or "no square"
            yield f"{piece.start:>14.9f}{piece.end:>14.9f}  {active}"
        yield ""
        yield self._heading
        for row in self._best.rows():
            yield text_line(row.label, row.value, row.error)
        if self._at_printed is not None:
            yield ""
            for row in self._printed_rows():
                yield text_line(row.label, row.value, row.error)
        if self.gains:
            yield ""
            yield f"{'what is free':<30}{'side':>14}{'gain':>12}{'ρ':>12}{'l0/l1':>12}  with"
            for gain in self.gains:
                square = gain.square
                yield (
                    f"{gain.name:<30}{self.length * square.side:>14.8g}{_percent(gain.gain):>12}"
                    f"{square.ratio:>12.5g}{square.lengths[2]:>12.5g}  {_remark(gain)}"
                )

    def sections(self) -> list[Section]:
        """Return choices, pieces, the largest square and gains as sections of a report."""
        pieces = Table(
            ("ρ from", "to", "Active"),
            tuple(
                (f"{each.start:.9f}", f"{each.end:.9f}", ", ".join(each.active) or "no square")
                for each in self.curve.pieces
            ),
        )
        found = [
            Section("Choices", rows=titled(task_rows(self._task))),
            Section("Pieces", tables=(pieces,)),
            Section(f"The largest {self._best.noun}", rows=titled(self._best.rows())),
        ]
        if self._at_printed is not None:
            found.append(Section("Printed values", rows=titled(self._printed_rows())))
        if self.gains:
            table = Table(
                ("What is free", "Side", "Gain", "ρ", "l0/l1", "With"),
                tuple(
                    (
                        gain.name,
                        f"{self.length * gain.square.side:.8g} {self.unit}".rstrip(),
                        _percent(gain.gain),
                        f"{gain.square.ratio:.5g}",
                        f"{gain.square.lengths[2]:.5g}",
                        _remark(gain),
                    )
                    for gain in self.gains
                ),
            )
            found.append(Section("Gains", tables=(table,)))
        return found

    def figures(self) -> list[Captioned]:
        """Return the curve, and the figures of the largest square."""
        curve, task = self.curve, self._task
        text = f"Side of the largest {self._best.noun} over the ratio of links, by what limits it."
        optimal = (
            "The linkage in its optimal configuration (Eqs. 21 and 22) at the best ratio, in "
            "lengths of the actuated link."
        )
        ratio = self._best.square.ratio
        return [
            Captioned(text, lambda: draw_curve(task, curve)),
            *self._best.figures(),
            Captioned(optimal, lambda: draw_optimal_configuration(task.mechanism, ratio)),
        ]

    @property
    def _task(self) -> SquareTask:
        return self.curve.squares[0].task

    @property
    def _heading(self) -> str:
        """What kind of a largest value it is."""
        if self.curve.is_kink:
            return "largest, where two pieces meet"
        if self._is_at_end:
            return "largest, at an end of the range of ratios: beyond it there may be larger ones"
        return "largest"

    @property
    def _is_at_end(self) -> bool:
        ratio = self._best.square.ratio
        ends = (self.curve.squares[0].ratio, self.curve.squares[-1].ratio)
        return any(abs(ratio - end) < _END * ratio for end in ends)

    @functools.cached_property
    def _best(self) -> SquareText:
        assert self.curve.largest is not None
        return SquareText(self.curve.largest, self.length, self.unit)

    @functools.cached_property
    def _at_printed(self) -> float | None:
        """The side at the printed ratio, where the problem is that of the paper."""
        from fivebar_atlas.synthesis.square_curve import tied_square

        task = self._task
        is_example = (task.mode, task.lci_threshold, task.aspect, task.centre, task.half) == (
            task.mechanism.modes[0],
            0.5,
            1.0,
            "mic",
            "upper",
        )
        ranges = {
            (round(math.degrees(each.least)), round(math.degrees(each.greatest)))
            for each in task.ranges
        }
        covers = self.curve.squares[0].ratio < _PRINTED_RATIO < self.curve.squares[-1].ratio
        if not is_example or not ranges <= {(-60, 240)} or not covers:
            return None
        return tied_square(task, _PRINTED_RATIO, is_proved=False).side

    @property
    def _is_reproduced(self) -> bool:
        side, best = self._at_printed, self._best.square
        assert side is not None
        is_side = abs(side - _PRINTED_SIDE) <= _PRINTED_ACCURACY
        return is_side and abs(best.ratio - _PRINTED_RATIO) <= _PRINTED_ACCURACY

    def _printed_rows(self) -> Iterator[Row]:
        """Yield the printed values beside ours, and the verdict."""
        side = self._at_printed
        assert side is not None
        best = self._best.square
        yield Row("printed optimum", f"ρ = {_PRINTED_RATIO}, a/l1 = {_PRINTED_SIDE}")
        yield Row("ours at that ratio", f"a/l1 = {side:.7f}")
        if not self._is_at_end:
            yield Row("ours at best", f"ρ = {best.ratio:.7f}, a/l1 = {best.side:.7f}")
        verdict = "reproduced" if self._is_reproduced else "not reproduced"
        if best.side > side:
            where = "smaller" if best.ratio < _PRINTED_RATIO else "larger"
            verdict += f": there are larger squares at {where} ratios"
        yield Row("verdict", verdict)


def task_document(task: SquareTask, length: float, unit: str) -> dict[str, Any]:
    """Return what was asked of a square, ready for JSON."""
    return {
        "mechanism": task.mechanism.name,
        "mode_asked": task.mode,
        "lci_threshold": task.lci_threshold,
        "aspect": task.aspect,
        "centre_asked": task.centre,
        "half": task.half,
        "actuator_ranges_deg": [
            [each.number, math.degrees(each.least), math.degrees(each.greatest)]
            for each in task.ranges
        ],
        "actuated_link": length,
        "unit": unit,
    }


def task_rows(task: SquareTask) -> Iterator[Row]:
    """Yield what was asked of a square."""
    yield Row("mode pair", task.mode)
    yield Row("least LCI γ", f"{task.lci_threshold:g}")
    half = f"{task.half} half"
    where = "maximal inscribed circle" if task.centre == "mic" else "y axis, wherever it is best"
    yield Row("centre of the square", f"{where}, {half}")
    if task.aspect != 1.0:
        yield Row("width : height", f"{task.aspect:g}")
    for each in task.ranges:
        yield Row("actuator range", each.text(task.mechanism))


def _remark(gain: Gain) -> str:
    """Return what tells the square of a gain from others."""
    task, (_, y) = gain.square.task, gain.square.centre
    aspect = "" if task.aspect == 1.0 else f", width : height {task.aspect:.4g}"
    return f"{task.mode}, centre at {y:.4g} l1{aspect}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.4f} %"
