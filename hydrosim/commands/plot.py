"""`hydrosim plot`: pictures of a run, or of a study."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import Overwrite
from hydrosim.commands.terminal import show
from hydrosim.errors import InputError


def plot(
    run_file: Annotated[
        Path, typer.Argument(metavar="RUN.nc", help="The result of a run, or of a study.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FOLDER", help="Put the pictures there."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Draw motions, forces, contact and energies of a run, or the figures of a study, as PNG."""
    from hydrosim.commands.study import draw_runs
    from hydrosim.plot import draw, open_run
    from hydrosim.results.growing import runs_at

    folder = run_file.parent if output is None else output
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; expected a folder for the pictures.")
    if (runs := runs_at(run_file)) is not None:
        draw_runs(runs, folder, run_file, overwrite)
        return
    dataset = open_run(run_file)
    for picture in draw(dataset, folder, run_file.stem, run_file, overwrite):
        show(f"picture   {picture}")
