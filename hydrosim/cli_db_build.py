"""`hydrosim db build`: the command."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="Hydrodynamic databases.")


@app.callback()
def databases() -> None:
    """Hydrodynamic databases."""


@app.command()
def build(
    recipe: Annotated[Path, typer.Argument(metavar="RECIPE.yaml", help="Recipe of the database.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="OUT.nc", help="Database file.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Number of processes.")] = 1,
    picture: Annotated[bool, typer.Option("--picture", help="Also draw mesh and results.")] = False,
) -> None:
    """Compute a database from a hull. It can be interrupted and goes on where it was."""
    from hydrosim.database.build.command import build_database

    for path in build_database(recipe, output, jobs, picture):
        typer.echo(f"result    {path}")
