"""``atlas evaluate``: one design."""

from __future__ import annotations

import click

from fivebar_atlas.cli import options
from fivebar_atlas.cli.evaluation_text import EvaluationText
from fivebar_atlas.cli.presentation import Run, present
from fivebar_atlas.cli.progress import note_compilation


@click.command(context_settings=options.NEGATIVE_NUMBERS)
@options.lengths_argument
@options.mechanism_option
@options.mode_option
@options.lci_option
@options.tolerance_option
@options.set_option
@options.json_option
def evaluate(
    lengths: list[float],
    mechanism: str | None,
    mode: tuple[str, ...] | None,
    lci: tuple[float, ...] | None,
    tolerance: float | None,
    set_options: dict[str, object],
    as_json: bool,
) -> None:
    """Evaluate one design, dimensional or not: workspaces, indices, circles.

    Lengths are scaled to a non-dimensional design by a dimensional factor D; both are
    reported. Lengths scale back with D, areas with its square, volumes with its cube.
    """
    from fivebar_atlas import mechanisms
    from fivebar_atlas.mechanisms.settings import SweepSettings

    chosen = mechanisms.get(mechanism or mechanisms.names()[0])
    parameters, factor = chosen.from_lengths(lengths)
    settings = SweepSettings(
        mechanism=chosen.name,
        space=chosen.spaces[0],
        resolution=chosen.resolution_range[0],
        modes=chosen.parse_modes(mode or chosen.modes[:1], "--mode"),
        lci_thresholds=chosen.default_lci_thresholds if lci is None else lci,
        tolerance=chosen.default_tolerance if tolerance is None else tolerance,
        options=options.options_of(chosen, set_options),
    )
    chosen.check_thresholds(settings.lci_thresholds, "--lci")
    chosen.check_tolerance(settings.tolerance, "--tolerance")
    note_compilation()
    results = chosen.evaluate(parameters[None, :], settings)
    text = EvaluationText(chosen, lengths, parameters, factor, settings, results)
    run = Run(
        title=text.title,
        summary=text.summary,
        document=lambda: chosen.document(parameters, factor, settings, results),
        lines=text.lines,
        sections=text.sections,
        figures=text.figures,
    )
    present(run, as_json)
