"""How a design, a mode and lengths are written in figures."""

from __future__ import annotations

from fivebar_atlas.mechanisms.planar import PlanarDesign

MINUS = "\N{MINUS SIGN}"
_NO_BREAK = "\N{NO-BREAK SPACE}"


def number_text(value: float, digits: int = 6) -> str:
    """Return a number with at most so many significant digits and a typographic minus."""
    return f"{value + 0.0:.{digits}g}".replace("-", MINUS)


def scientific_text(value: float, digits: int = 5) -> str:
    """Return a number with at most so many digits, one from a million as mathtext with a power."""
    if abs(value) < 1e6:
        return number_text(float(f"{value:.{digits}g}"), 7)
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return rf"${mantissa.rstrip('0').rstrip('.')} \times 10^{{{int(exponent)}}}$"


def mode_text(mode: str) -> str:
    """Return a mode pair or working mode as it is written in a title."""
    return f"mode{_NO_BREAK}{mode.replace('-', MINUS)}"


def threshold_text(threshold: float) -> str:
    """Return the condition of a good-condition workspace."""
    return f"LCI{_NO_BREAK}\N{GREATER-THAN OR EQUAL TO}{_NO_BREAK}{threshold:.10g}"


def design_text(design: PlanarDesign) -> str:
    """Return the lengths of a design with their unit; it breaks between them only."""
    return ", ".join(
        f"{symbol} = {_with_unit(number_text(value), design.unit)}".replace(" ", _NO_BREAK)
        for symbol, value in design.parameters
    )


def title_text(subject: str, design: PlanarDesign, mode: str | None = None) -> str:
    """Return the title of a figure of one design."""
    parts = [subject, design_text(design)]
    return ", ".join(parts if mode is None else [*parts, mode_text(mode)])


def length_text(length: float, unit: str, digits: int = 4) -> str:
    """Return a length with its unit, D where it is non-dimensional."""
    return f"{number_text(length, digits)} {escaped(unit) or '$D$'}".replace(" ", _NO_BREAK)


def area_text(area: float, unit: str, digits: int = 5) -> str:
    """Return an area with its unit, D² where it is non-dimensional."""
    square = f"{escaped(unit)}$^2$" if unit else "$D^2$"
    return f"{number_text(area, digits)} {square}".replace(" ", _NO_BREAK)


def point_text(point: tuple[float, float], unit: str, digits: int = 4) -> str:
    """Return coordinates with their unit; what is zero but for rounding is zero."""
    rounding = 1e-9 * max(map(abs, point))
    x, y = (number_text(part if abs(part) > rounding else 0.0, digits) for part in point)
    return _with_unit(f"({x}, {y})", unit).replace(" ", _NO_BREAK)


def coordinate_label(symbol: str, unit: str) -> str:
    """Return the label of a coordinate axis."""
    return f"{symbol} ({escaped(unit) if unit else 'in units of $D$'})"


def escaped(unit: str) -> str:
    """Return a unit as text that is not taken for mathtext."""
    return unit.replace("$", r"\$")


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {escaped(unit)}" if unit else text
