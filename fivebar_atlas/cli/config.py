"""``atlas config``: look at configurations."""

from __future__ import annotations

from typing import Any

import click

from fivebar_atlas.cli import options


@click.group(invoke_without_command=True)
@click.pass_context
def config(ctx: click.Context) -> None:
    """Look at configurations."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


@config.command()
@options.config_argument
@options.sweep_options
def show(config_path: str | None, **given: Any) -> None:
    """Print the resolved configuration as TOML: defaults, CONFIG.toml, command line."""
    from fivebar_atlas import config as configurations

    configuration = configurations.resolve(config_path, options.overrides(**given))
    click.echo(configurations.render(configuration), nl=False)
