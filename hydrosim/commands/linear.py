"""`hydrosim linear`: equilibrium, natural modes, RAOs and the response in the sea of a case."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hydrosim.commands.compiling import announce_compiling
from hydrosim.commands.options import (
    CaseFile,
    Overwrite,
    Settings,
    Verbose,
    numbers,
    one_of,
    output_for,
    seconds,
)
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines, progress_console, show_document

err = progress_console()


def linear(
    case_file: CaseFile,
    time: Annotated[
        str,
        typer.Option(
            metavar="TIME", help='Time at which applied forces and tanks are evaluated: "10 min".'
        ),
    ] = "0 s",
    headings: Annotated[
        str | None,
        typer.Option(
            help="Headings of the RAOs (deg), separated by commas; default: those of the sea."
        ),
    ] = None,
    periods: Annotated[
        str | None,
        typer.Option(
            help="Periods of the RAOs (s), separated by commas; default: those of the databases."
        ),
    ] = None,
    own: Annotated[
        bool,
        typer.Option(
            "--database",
            help="Use added mass and damping of the databases instead of the radiation model.",
        ),
    ] = False,
    contacts: Annotated[
        str,
        typer.Option(
            help="State of contacts that are pressed at rest: stuck, sliding (without friction)"
            " or open."
        ),
    ] = "stuck",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="LINEAR.nc", help="netCDF file to write."),
    ] = None,
    verbose: Verbose = False,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Compute equilibrium without friction, natural modes, RAOs and the response in the sea; print
    tables, draw a picture, write netCDF."""
    import numpy as np

    from hydrosim.case.load import load_case
    from hydrosim.compiling.compile import Radiation
    from hydrosim.linear.contacts import Contacts
    from hydrosim.plot.response import draw_response
    from hydrosim.results.netcdf import write_run
    from hydrosim.studies.linear.seakeeping import LinearRequest, linear_analysis
    from hydrosim.wording.linear import linear_document

    case = load_case(case_file, settings)
    name = f"{case_file.stem}_linear"
    asked = {
        "--time": time,
        "--headings": headings,
        "--periods": periods,
        "--database": own,
        "--contacts": contacts,
    }
    made = output_for(
        output,
        name,
        "linear",
        case_file,
        inputs=case.inputs(),
        overwrite=overwrite,
        settings=case.settings(asked),
    )
    page = made.output_at(made.path.with_suffix(".png"), "picture").checked_output()
    wanted = LinearRequest(
        seconds("--time", time, 0.0),
        [float(np.radians(b)) for b in numbers(headings, "--headings", positive=False)]
        if headings
        else (),
        sorted(2 * np.pi / t for t in numbers(periods, "--periods")) if periods else (),
        Radiation.DATABASE if own else Radiation.MODEL,
        contacts=one_of(Contacts, contacts, "--contacts"),
    )
    scene = case.scene()
    with made.hold_lock(), announce_compiling(err), progress("linear analysis"):
        found = linear_analysis(scene, wanted)
        write_run(found, made)
    draw_response(found, page)
    show_document(linear_document(found, raos=bool(periods)), verbose)
    print_lines(f"result    {made.path}, {page.path}")
