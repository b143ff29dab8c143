"""`hydrosim plot`: pictures of a run, or of a study."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.options import From, Overwrite, To, names_in, one_of, window_of
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines
from hydrosim.errors import InputError


def plot(
    run_file: Annotated[
        Path, typer.Argument(metavar="RUN.nc", help="Result of a run, or of a study.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FOLDER", help="Folder for the pictures."),
    ] = None,
    channels: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help='Channels to draw in one picture, separated by commas: "position.*.heave".',
        ),
    ] = "",
    start: From = "",
    end: To = "",
    form: Annotated[
        str, typer.Option("--format", metavar="png|svg|pdf", help="Format of the pictures.")
    ] = "png",
    overwrite: Overwrite = False,
) -> None:
    """Draw motions, forces, contact and energies of a run, or the figures of a study.

    Titles name the sea. Grey and white show the phases of the first contact that begins open. In
    long runs, bands show the smallest and largest values of each interval.
    """
    from hydrosim.commands.study import draw_runs, so_far
    from hydrosim.plot import draw
    from hydrosim.plot.draw import Format, TimeWindow, View
    from hydrosim.plot.load import open_run
    from hydrosim.results.channels import channel_names, match_channels
    from hydrosim.results.unfinished import runs_at

    folder = run_file.parent if output is None else output
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise InputError(f"{folder}: is a file; expected a folder for the pictures.")
    if output is not None and output.suffix[1:] in [*Format] and not os.path.isdir(output):
        raise InputError(
            f"--output: found {output}; expected a folder for several pictures. --format"
            f" {output.suffix[1:]} selects their format."
        )
    kind = one_of(Format, form, "--format")
    window = TimeWindow(*window_of(start, end))
    if (runs := runs_at(run_file)) is not None:
        if channels or start or end:
            raise InputError(
                f"--channels, --from, --to: {run_file} is a study, which has no time series;"
                " expected the result of a run."
            )
        print_lines(*so_far(runs))
        draw_runs(runs, folder, run_file, overwrite, kind)
        return
    dataset = open_run(run_file)
    asked = names_in(channels)
    picked = match_channels(channel_names(dataset), asked, "--channels") if asked else ()
    view = View(window, picked, kind)
    with progress("drawing"):
        pictures = draw(dataset, folder, run_file.stem, run_file, overwrite, view)
    print_lines(*(f"picture   {picture}" for picture in pictures))
