"""``atlas geometry``: loci, workspaces and circles of one design, to read and as files."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.progress import note_compilation

if TYPE_CHECKING:
    from fivebar_atlas.geometry_files.design_geometry import DesignGeometry, PlacedArc
    from fivebar_atlas.planar_geometry import Point

_DEFAULT_LCI = 0.5
_HEADINGS = ("curve", "kind", "start", "end", "length", "ends", "centre", "radius", "modes")
_GAP = "  "


def _kind(ctx: click.Context, parameter: click.Parameter, text: str) -> str:  # noqa: ARG001
    """Return the first argument, unless it is an unknown option or no kind."""
    from fivebar_atlas.geometry_files.design_geometry import check_kind

    if text.startswith("-"):
        raise options.no_such_option(ctx, text)
    check_kind(text)
    return text


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@click.argument("kind", metavar="KIND", is_eager=True, callback=_kind)
@options.design_options
@click.option(
    "--mode",
    metavar="MODE",
    help="Mode pair such as +-/up or pm/up, the first if not given; for loci a working mode "
    "alone too, and all if not given.",
)
@click.option(
    "--lci",
    type=float,
    metavar="THRESHOLD",
    help=f"LCI threshold of the good-condition workspace; {_DEFAULT_LCI:g} if not given.",
)
@options.json_option
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE.(csv|svg|dxf)",
    help="Write a file; the ending decides the format.",
)
@click.option(
    "--deviation",
    type=float,
    metavar="SHARE",
    help="Largest distance of chords and splines from the arcs, as a share of D; 1e-4 if not "
    "given.",
)
@options.overwrite_option
@options.quiet_option
def geometry(
    kind: str,
    mode: str | None,
    lci: float | None,
    as_json: bool,
    output: Path | None,
    deviation: float | None,
    overwrite: bool,
    quiet: bool,
    **design: Any,
) -> None:
    """List the exact arcs of one design, or write them as CSV, SVG or DXF.

    KIND is one of loci (singular loci), workspace (outline and holes of the usable
    workspace), good-condition (those of its part with at least an LCI) and circles (maximal
    inscribed circles).

    Circles stay circles in SVG and DXF, both in the size of the machine; CSV has a row for
    each point. Lengths have the unit of LENGTHS. The outline of a good-condition workspace
    is a polygon with corners on the level curve; atlas evaluate integrates its area. DXF
    files need the package ezdxf.
    """
    from fivebar_atlas.geometry_files.design_geometry import GOOD_CONDITION, geometry_of
    from fivebar_atlas.geometry_files.json_document import json_document
    from fivebar_atlas.geometry_files.writing import (
        DEVIATION,
        check_deviation,
        check_geometry_output,
        write_geometry,
    )

    if kind != GOOD_CONDITION and lci is not None:
        raise click.UsageError(f"--lci belongs to {GOOD_CONDITION}, not to {kind}")
    share = DEVIATION if deviation is None else deviation
    check_deviation(share, "--deviation")
    if output is not None:
        check_geometry_output(output, overwrite)
    machine = options.planar_design(**design)
    note_compilation()
    found = geometry_of(machine, kind, mode, _DEFAULT_LCI if lci is None else lci)
    if output is not None:
        write_geometry(found, output, overwrite, share)
        if not quiet:
            click.echo(f"{output}: {_contents(found)}", err=True)
    if as_json:
        document = json_document(found, share * machine.factor)
        click.echo(json.dumps(document, indent=2, allow_nan=False))
    elif output is None:
        click.echo("\n".join(_table(found)))


def _contents(found: DesignGeometry) -> str:
    """Return what was written, in a phrase."""
    count = len(found.placed_arcs())
    points = len(found.isolated_points)
    parts = [f"{found.title}, {count} {'arc' if count == 1 else 'arcs'}"]
    if points:
        parts.append(f"{points} isolated {'point' if points == 1 else 'points'}")
    return " and ".join(parts)


def _table(found: DesignGeometry) -> Iterator[str]:
    """Yield the lines of a readable table."""
    design = found.design
    unit = f" {design.unit}" if design.unit else ""
    squared = f"{unit}²" if unit else ""
    yield f"{found.title}: {found.subject}"
    factor = [f"D = {design.factor:.8g}{unit}"] if unit else []
    yield "; ".join([*factor, *design.remarks()])
    if found.is_empty:
        yield found.absence
        return
    placed = found.placed_arcs()
    if found.arcs:
        yield ""
        yield from _arc_lines(placed)
    for number, region in enumerate(found.regions, 1):
        yield ""
        count = f" {number} of {len(found.regions)}" if len(found.regions) > 1 else ""
        # a level curve is known by points
        digits = 8 if found.lci_threshold is None else 6
        yield f"region{count}: area {region.area:.{digits}g}{squared}"
        for place, loop in enumerate(region.loops):
            name = f"hole {place}" if place else "outline"
            around = math.fsum(each.arc.length() for each in loop.arcs)
            turn = "clockwise" if loop.area < 0.0 else "counter-clockwise"
            yield ""
            yield (
                f"{name}, {turn}: length {around:.{digits}g}{unit}, "
                f"encloses {abs(loop.area):.{digits}g}{squared}"
            )
            yield from _arc_lines(
                [each for each in placed if (each.region, each.boundary) == (number, name)]
            )
    if found.area is not None:
        yield ""
        green = math.fsum(region.area for region in found.regions)
        yield f"area by Green's theorem  {green:.12g}{squared}"
        yield f"area as integrated       {found.area:.12g}{squared}"
    if found.isolated_points:
        yield ""
        yield f"isolated singular points: {', '.join(map(_point, found.isolated_points))}"


def _arc_lines(placed: Iterable[PlacedArc]) -> Iterator[str]:
    """Yield a heading and a line for each arc, in columns; columns with nothing are left out."""
    rows = [_HEADINGS, *(_cells(each) for each in placed)]
    columns = [column for column in zip(*rows, strict=True) if any(column[1:])]
    widths = [max(map(len, column)) for column in columns]
    for line in zip(*columns, strict=True):
        cells = (f"{cell:{width}}" for cell, width in zip(line, widths, strict=True))
        yield _GAP.join(cells).rstrip()


def _cells(placed: PlacedArc) -> Sequence[str]:
    from fivebar_atlas.geometry_files.design_geometry import sides_text
    from fivebar_atlas.planar_geometry import CLOSED, CircleArc

    named, arc = placed.named, placed.named.arc
    # the workspace is on the left of its own boundary
    modes = sides_text(named.sides) if placed.region is None else ""
    centre, radius = "", ""
    if isinstance(arc, CircleArc):
        centre, radius = _point(arc.centre), f"{arc.radius:.7g}"
    is_closed = named.ends == (CLOSED, CLOSED)
    ends = CLOSED if is_closed else ", ".join(named.ends)
    return (
        *(named.name, named.kind, _point(arc.start), "" if is_closed else _point(arc.end)),
        *(f"{arc.length():.7g}", ends, centre, radius, modes),
    )


def _point(point: Point) -> str:
    """Return coordinates; what is zero but for rounding is zero."""
    size = max(map(abs, point))
    x, y = (0.0 if abs(part) <= 1e-13 * size else part for part in point)
    return f"({x:.7g}, {y:.7g})"
