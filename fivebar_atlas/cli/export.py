"""``atlas export``: a result file as a table."""

from __future__ import annotations

import click

from fivebar_atlas.cli import options


@click.command()
@options.file_argument
@click.option("-o", "--output", required=True, metavar="FILE.csv", help="Table to be written.")
@options.overwrite_option
@options.quiet_option
def export(file: str, output: str, overwrite: bool, quiet: bool) -> None:
    """Write a result file as comma-separated text, one row a design and mode.

    What depends on an LCI threshold has a column for each, such as
    good_condition_gci_lci_threshold_0.5. What does not exist is nan.
    """
    from fivebar_atlas.export import export_csv
    from fivebar_atlas.store import open_atlas

    with open_atlas(file) as atlas:
        rows = export_csv(atlas, output, overwrite)
    if not quiet:
        click.echo(f"{output}: {rows:,} rows", err=True)
