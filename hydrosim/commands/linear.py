"""`hydrosim linear`: rest, natural modes, RAOs and the response in the sea of a case."""

from __future__ import annotations

from math import degrees, isfinite, isnan, pi
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape
from rich.table import Table

from hydrosim.commands.compiling import announced
from hydrosim.commands.options import (
    CaseFile,
    Overwrite,
    Settings,
    numbers,
    one_of,
    placed,
    seconds,
)
from hydrosim.commands.terminal import progress_console, show

if TYPE_CHECKING:
    import xarray as xr

err = progress_console()
TURNS = ("roll", "pitch", "yaw")
ROUNDING = 1e-10  # m, deg, s: it is zero
# coordinates of a mode that are told; shares of energy that are not
SHOWN = 3
LITTLE = 0.05


def linear(
    case_file: CaseFile,
    time: Annotated[
        str,
        typer.Option(metavar="TIME", help='Take applied forces and tanks at this time: "10 min".'),
    ] = "0 s",
    headings: Annotated[
        str | None,
        typer.Option(help="Compute RAOs for these headings (deg), by commas; else the sea's."),
    ] = None,
    periods: Annotated[
        str | None,
        typer.Option(help="Compute RAOs at these periods (s), by commas; else the databases'."),
    ] = None,
    own: Annotated[
        bool, typer.Option("--database", help="Use added mass and damping as databases have them.")
    ] = False,
    contacts: Annotated[
        str,
        typer.Option(help="Take contacts pressed at rest as stuck, sliding (no friction) or open."),
    ] = "stuck",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="LINEAR.nc", help="Where to write the result."),
    ] = None,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Compute the place at rest without friction, natural modes, RAOs and the response in the sea;
    print tables, draw a picture, write netCDF."""
    import numpy as np

    from hydrosim.case.load import load_case
    from hydrosim.compiling.compile import Radiation
    from hydrosim.linear.contacts import Contacts
    from hydrosim.plot.response import draw_response
    from hydrosim.results.netcdf import write
    from hydrosim.studies.linear.seakeeping import Wanted, linear_analysis

    case = load_case(case_file, settings)
    name = f"{case_file.stem}_linear"
    asked = {
        "--time": time,
        "--headings": headings,
        "--periods": periods,
        "--database": own,
        "--contacts": contacts,
    }
    made = placed(
        output,
        name,
        "linear",
        case_file,
        inputs=case.inputs(),
        overwrite=overwrite,
        settings=case.settings(asked),
    )
    page = made.at(made.path.with_suffix(".png"), "picture").checked()
    wanted = Wanted(
        seconds("--time", time, 0.0),
        [float(np.radians(b)) for b in numbers(headings, "--headings", positive=False)]
        if headings
        else (),
        sorted(2 * np.pi / t for t in numbers(periods, "--periods")) if periods else (),
        Radiation.DATABASE if own else Radiation.MODEL,
        contacts=one_of(Contacts, contacts, "--contacts"),
    )
    scene = case.scene()
    with made.held(), announced(err), err.status("linear analysis"):
        found = linear_analysis(scene, wanted)
        write(found, made)
    draw_response(found, page)
    shown = [*tables(found), *(rao_tables(found) if periods else [])]
    remarks = [f"remark    {line}" for line in found.attrs["remarks"].splitlines()]
    show(*shown, *remarks, f"result    {made.path}, {page.path}")


def tables(found: xr.Dataset) -> list[Table]:
    """What of a linear analysis goes on the terminal: motions, then modes."""
    return [_motions(found), _modes(found)]


def _motions(found: xr.Dataset) -> Table:
    columns = {"at rest": "position_at_rest", "mean drift": "mean_drift_offset"}
    if "response_std" in found:
        columns |= {"std in sea": "response_std", "maximum in sea": "response_maximum"}
        columns |= {"Tz [s]": "response_period"}
    waves = range(found.sizes.get("wave", 0))
    regular = [_wave(found, k) for k in waves]
    title = f"{found.title}: motions [m, deg]{', amplitude and phase [deg]' if regular else ''}"
    table = _table(title, ["body"], ["dof", *columns, *regular])
    for body in found.body.values:
        for dof in found.dof.values:
            at = found.sel(body=body, dof=dof)
            figures = [_figure(at, name, dof in TURNS) for name in columns.values()]
            for k in waves:
                figures.append(_harmonic(at.isel(wave=k), "regular", dof in TURNS))
            table.add_row(str(body), str(dof), *figures)
    return table


def _wave(found: xr.Dataset, k: int) -> str:
    at = found.isel(wave=k)
    return f"wave of {float(at.wave_period):g} s to {degrees(float(at.wave_heading)):g} deg"


def _modes(found: xr.Dataset) -> Table:
    periods = ["natural period [s]", "damped period [s]", "damping ratio"]
    table = _table("Natural modes", ["mode"], [*periods, "moves"])
    for mode in found.mode.values:
        at = found.sel(mode=mode)
        table.add_row(str(mode), *_decay(at), _moves(at))
    return table


def _decay(at: xr.Dataset) -> list[str]:
    """Periods and damping of a mode, or what it is instead."""
    kind = str(at.mode_kind.values)
    natural = float(at.natural_period)
    if kind == "free":
        return ["free", "", ""]
    period = f"{natural:.3f}" if isfinite(natural) else "none"
    if kind != "oscillating":
        return [period, kind, ""]
    return [period, f"{float(at.damped_period):.3f}", f"{float(at.damping_ratio):.4f}"]


def _moves(at: xr.Dataset) -> str:
    """The coordinates that have most of the energy of a mode."""
    share = at.mode_share.stack(coordinate=("body", "dof"))
    largest = share.sortby(share, ascending=False)[:SHOWN]
    several = at.body.size > 1
    return ", ".join(
        f"{f'{body} ' if several else ''}{dof} {float(value):.0%}"
        for (body, dof), value in zip(largest.coordinate.values, largest.values, strict=True)
        if value >= LITTLE
    )


def rao_tables(found: xr.Dataset) -> list[Table]:
    """RAOs over the period, a table for each body and heading; motions that no wave excites are
    left out."""
    each = [found.sel(body=body, heading=h) for body in found.body.values for h in found.heading]
    return [_raos(at) for at in each]


def _raos(at: xr.Dataset) -> Table:
    moving = [str(d) for d in at.dof.values if float(at.rao_amplitude.sel(dof=d).max()) > 0.0]
    units = [f"{dof} [{'deg' if dof in TURNS else 'm'}/m]" for dof in moving]
    waves = f"waves to {degrees(float(at.heading)):g} deg"
    title = f"RAOs of {at.body.values}, {waves}: amplitude and phase [deg]"
    table = _table(title, [], ["period [s]", *units])
    for omega in at.frequency.values[::-1]:
        here = at.sel(frequency=omega)
        figures = [_harmonic(here.sel(dof=dof), "rao", dof in TURNS) for dof in moving]
        table.add_row(f"{2 * pi / omega:.3f}", *figures)
    return table


def _harmonic(at: xr.Dataset, name: str, turns: bool) -> str:
    """Amplitude and phase lead in degrees; no phase of what does not move."""
    size = float(at[f"{name}_amplitude"])
    phase = float(at[f"{name}_phase"])
    return f"{degrees(size) if turns else size:.4g}, {degrees(phase):.0f}" if size else "0"


def _table(title: str, left: list[str], right: list[str]) -> Table:
    table = Table(title=escape(title))
    for name in (*left, *right):
        table.add_column(escape(name), justify="left" if name in (*left, "moves") else "right")
    return table


def _figure(at: xr.Dataset, name: str, turns: bool) -> str:
    value = float(at[name])
    value = degrees(value) if turns and name != "response_period" else value
    if isnan(value):
        return ""
    return f"{value:.4g}" if abs(value) > ROUNDING else "0"
