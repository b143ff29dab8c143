"""`hydrosim linear`: rest, natural modes, RAOs and the response in the sea of a case."""

from __future__ import annotations

from math import degrees, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from hydrosim.commands.compiling import announced
from hydrosim.commands.options import CaseFile, Settings, numbers, result_path
from hydrosim.commands.terminal import show

if TYPE_CHECKING:
    import xarray as xr

err = Console(stderr=True)


def linear(
    case_file: CaseFile,
    time: Annotated[float, typer.Option(help="Of the applied forces [s].")] = 0.0,
    headings: Annotated[
        str | None, typer.Option(help="Of the RAOs [deg], by commas; else the sea's.")
    ] = None,
    periods: Annotated[
        str | None, typer.Option(help="Of the RAOs [s], by commas; else the databases'.")
    ] = None,
    own: Annotated[
        bool, typer.Option("--database", help="Added mass and damping of the databases.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="LINEAR.nc", help="Result file.")
    ] = None,
    settings: Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Place at rest without friction, natural modes, RAOs, response in the sea: tables, picture and
    netCDF."""
    import numpy as np

    from hydrosim.case import load_case
    from hydrosim.plot.response import draw_response
    from hydrosim.results.output import write
    from hydrosim.studies.response import Radiation
    from hydrosim.studies.seakeeping import Wanted, linear_analysis

    path = result_path(output, case_file.with_stem(f"{case_file.stem}_linear"))
    wanted = Wanted(
        time,
        [float(np.radians(b)) for b in numbers(headings, "--headings", positive=False)]
        if headings
        else (),
        sorted(2 * np.pi / t for t in numbers(periods, "--periods")) if periods else (),
        Radiation.DATABASE if own else Radiation.MODEL,
    )
    scene = load_case(case_file, settings).scene()
    with announced(err), err.status("linear analysis"):
        found = linear_analysis(scene, wanted)
    write(found, path)
    draw_response(found, path.with_suffix(".png"))
    show(*tables(found), f"result    {path}, {path.with_suffix('.png')}")


def tables(found: xr.Dataset) -> list[Table]:
    """What of a linear analysis goes on the terminal."""
    motions = Table(title=f"{found.title}: motions [m, deg]")
    for name in ("body", "dof", "at rest", "mean drift", "std in sea", "maximum in sea", "Tz [s]"):
        motions.add_column(name.replace("[", "\\["), justify="left" if name == "body" else "right")
    for body in found.body.values:
        for dof in found.dof.values:
            at = found.sel(body=body, dof=dof)
            turns = dof in ("roll", "pitch", "yaw")
            names = ("position_at_rest", "mean_drift_offset", "response_std", "response_maximum")
            figures = [_figure(at, name, turns) for name in names]
            motions.add_row(str(body), str(dof), *figures, _figure(at, "response_period", False))
    modes = Table(title="Natural modes")
    for name in ("mode", "natural period [s]", "damped period [s]", "damping ratio"):
        modes.add_column(name.replace("[", "\\["), justify="left" if name == "mode" else "right")
    for mode in found.mode.values:
        at = found.sel(mode=mode)
        figures = [f"{float(at[name]):.3f}" for name in ("natural_period", "damped_period")]
        modes.add_row(str(mode), *figures, f"{float(at.damping_ratio):.4f}")
    return [motions, modes]


def _figure(at: xr.Dataset, name: str, turns: bool) -> str:
    if name not in at:
        return ""
    value = float(at[name])
    value = degrees(value) if turns else value
    return "" if isnan(value) else f"{value:.4g}"
