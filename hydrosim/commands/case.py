"""`hydrosim case`: print the case that repeats a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.errors import InputError


def case(
    run_file: Annotated[Path, typer.Argument(metavar="RUN.nc", help="Result of a run.")],
    number: Annotated[
        int | None,
        typer.Option("--run", help="Number of the run in a file of many runs, counted from 0."),
    ] = None,
) -> None:
    """Print the case that repeats a run, with all defaults and automatic choices written out.

    The case is in SI units and radians. It has absolute paths and the checksums of databases, so it
    can be kept anywhere: hydrosim case RUN.nc > AGAIN.yaml.
    """
    from hydrosim.compare.exact import read_result
    from hydrosim.studies.run.repeat import case_of

    result = read_result(run_file)
    try:
        text = case_of(result, number)
    except InputError as error:
        raise InputError(f"{run_file}: {error}") from None
    typer.echo(text, nl=False)
