"""`hydrosim ballast`: loading conditions of bodies with tanks, and pump plans."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.commands.compiling import announce_compiling
from hydrosim.commands.options import CaseFile, Overwrite, Settings, Verbose, output_for, quantity
from hydrosim.commands.progress import progress
from hydrosim.commands.terminal import print_lines, progress_console, show_document
from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.studies.ballast.ballasting import PumpPlan

err = progress_console()
MAX_ANGLE_RAD = 1.48  # rad (85 deg)


def ballast(
    case_file: CaseFile,
    time: Annotated[
        str, typer.Option(help='Time of the loading condition: "1 hour", or a number in seconds.')
    ] = "0 s",
    lift: Annotated[
        str | None,
        typer.Option(help='Plan for this weight to be lifted off (N): "20000 tonne_force".'),
    ] = None,
    rise: Annotated[
        str | None, typer.Option(help='Plan for a rise of the body by this height (m): "0.5 m".')
    ] = None,
    within: Annotated[
        str, typer.Option(help='Longest duration of the plan: "1 hour", or a number in seconds.')
    ] = "1 hour",
    heel: Annotated[
        str | None,
        typer.Option(help='Also print the loss of GM by free surfaces at this heel: "5 deg".'),
    ] = None,
    body: Annotated[
        str | None,
        typer.Option(help="Body that the plan is for; default: the first body with tanks."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PICTURE.png", help="Picture file to write."),
    ] = None,
    verbose: Verbose = False,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Print and draw the loading condition of bodies with tanks; plan their pumps."""
    from hydrosim.case.load import load_case
    from hydrosim.compiling.compile import compile_in_calm
    from hydrosim.plot.loading import draw_loading
    from hydrosim.presentation.units import units_of
    from hydrosim.studies.ballast.ballasting import find_pump_plan
    from hydrosim.studies.ballast.loading import conditions
    from hydrosim.tanks.events import triggered_pumps
    from hydrosim.wording.ballast import ballast_document

    case, name = load_case(case_file, settings), f"{case_file.stem}_ballast"
    page = output_for(
        *(output, name, "ballast", case_file),
        inputs=case.inputs(),
        overwrite=overwrite,
        suffix=".png",
    )
    at = quantity("--time", time, "time", "s", "1 hour")
    angle = quantity("--heel", heel, "angle", "rad", "5 deg") if heel else None
    if angle is not None and not 0.0 < abs(angle) < MAX_ANGLE_RAD:
        raise InputError(
            f"--heel: found {degrees(angle):.4g} deg; expected an angle above 0 and below 85 deg."
            ' A number without a unit is in rad: write "5 deg".'
        )
    scene = case.scene()
    having = [each.name for each in scene.bodies if each.tanks]
    if not having:
        raise InputError(
            f"{case_file}: no body has tanks; expected at least one. Add them under"
            " bodies.NAME.tanks."
        )
    if body is not None and body not in having:
        raise InputError(f"--body: found {body}; expected one of {', '.join(having)}.")
    with announce_compiling(err), progress("loading condition"):
        compiled = compile_in_calm(scene)
        found = conditions(compiled, at, angle)
        planned: PumpPlan | None = None
        if lift is not None or rise is not None:
            weight = quantity("--lift", lift, "force", "N", "20000 tonne_force") if lift else None
            up = quantity("--rise", rise, "length", "m", "0.5 m") if rise else 0.0
            span = quantity("--within", within, "time", "s", "1 hour")
            planned = find_pump_plan(compiled, body or having[0], span, weight, up)
    waiting = [pump.key for pump in triggered_pumps(scene)] if at > 0.0 else []
    draw_loading(found, at, page, units_of(scene.source))
    show_document(ballast_document(scene, found, at, angle, planned, waiting), verbose)
    print_lines(f"picture   {page.path}")
