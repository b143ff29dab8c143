"""`hydrosim ballast`: the loading condition of bodies with tanks, and plans of their pumps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape
from rich.table import Table

from hydrosim.commands.compiling import announced
from hydrosim.commands.options import CaseFile, Overwrite, Settings, placed, quantity
from hydrosim.commands.terminal import progress_console, show
from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.studies.ballast.ballasting import Plan
    from hydrosim.studies.ballast.loading import Condition

err = progress_console()
STEEPEST = 1.48  # rad (85 deg)
SMALL = 2e-3  # rad (0.1 deg): a heel that any body has
ROWS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def ballast(
    case_file: CaseFile,
    time: Annotated[
        str, typer.Option(help='Show the loading condition at this time: "1 hour", or seconds.')
    ] = "0 s",
    lift: Annotated[
        str | None, typer.Option(help='Plan to take out this weight (N): "20000 tonne_force".')
    ] = None,
    rise: Annotated[
        str | None, typer.Option(help='Plan to rise by this much (m): "0.5 m".')
    ] = None,
    within: Annotated[
        str, typer.Option(help='Let the plan take at most this time: "1 hour", or seconds.')
    ] = "1 hour",
    heel: Annotated[
        str | None,
        typer.Option(help='Print what free surfaces take of GM at this heel, too: "5 deg".'),
    ] = None,
    body: Annotated[str | None, typer.Option(help="Plan for this body.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="PICTURE.png", help="Draw it there.")
    ] = None,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Print and draw the loading condition of bodies with tanks; plan their pumps."""
    from hydrosim.case.load import load_case
    from hydrosim.compiling.compile import compile_in_calm
    from hydrosim.plot.loading import draw_loading
    from hydrosim.studies.ballast.ballasting import plan
    from hydrosim.studies.ballast.loading import conditions
    from hydrosim.tanks.events import triggered_pumps

    case, name = load_case(case_file, settings), f"{case_file.stem}_ballast"
    page = placed(
        *(output, name, "ballast", case_file),
        inputs=case.inputs(),
        overwrite=overwrite,
        suffix=".png",
    )
    at = quantity("--time", time, "time", "s", "1 hour")
    angle = quantity("--heel", heel, "angle", "rad", "5 deg") if heel else None
    if angle is not None and not 0.0 < abs(angle) < STEEPEST:
        raise InputError(
            f"--heel: found {degrees(angle):.4g} deg; expected more than 0 and less than 85 deg."
            " A number without a unit is in rad."
        )
    scene = case.scene()
    having = [each.name for each in scene.bodies if each.tanks]
    if not having:
        raise InputError(f"{case_file}: no body has tanks; expected some, see bodies.NAME.tanks.")
    if body is not None and body not in having:
        raise InputError(f"--body: found {body}; expected one of {', '.join(having)}.")
    with announced(err), err.status("loading condition"):
        compiled = compile_in_calm(scene)
        found = conditions(compiled, at, angle)
        lines: list[Table | str] = [table for each in found for table in tables(each, at, angle)]
        if lift is not None or rise is not None:
            weight = quantity("--lift", lift, "force", "N", "20000 tonne_force") if lift else None
            up = quantity("--rise", rise, "length", "m", "0.5 m") if rise else 0.0
            span = quantity("--within", within, "time", "s", "1 hour")
            lines.append(_planned(plan(compiled, body or having[0], span, weight, up)))
    waiting = [pump.key for pump in triggered_pumps(scene)] if at > 0.0 else []
    if waiting:
        lines.append(f"taken as not begun, since events decide: {', '.join(waiting)}")
    lines += _shallow(found)
    lines += [] if angle is None else _upright(found, angle)
    draw_loading(found, at, page)
    show(*lines, f"picture   {page.path}")


def tables(found: Condition, time: float, angle: float | None = None) -> Iterator[Table]:
    """What a body weighs and how it floats, with what free surfaces take at an ``angle`` of heel
    [rad]; its tanks; its mass matrix."""
    import numpy as np

    loading, at = found.loading, found.position
    yield _table(
        f"{found.body.name} at {time:g} s",
        ["", "mass [t]", "x [m]", "y [m]", "z [m]"],
        [
            [what, f"{x.mass / 1e3:.1f}", *(f"{c:.3f}" for c in x.centre)]
            for what, x in (("lightship", found.lightship), ("with its tanks", loading))
        ],
    )
    heel, trim = np.degrees(at[3:5])
    asked = [] if angle is None else [f"taken at {np.degrees(angle):g} deg of heel"]
    yield _table(
        "At rest",
        ["heave [m]", "heel [deg]", "trim [deg]"],
        [[f"{at[2]:.4f}", f"{heel:.4f}", f"{trim:.4f}"]],
    )
    secants = [np.array([found.secant, np.nan]) for _ in asked]
    heights = np.transpose([found.metacentric, found.loss, *secants, found.held])
    yield _table(
        "Metacentric heights at rest [m]",
        ["", "GM", "taken by free surfaces", *asked, "with lines and contacts"],
        [
            [of, *(f"{x:.3f}" if np.isfinite(x) else "" for x in row)]
            for of, row in zip(("heel", "trim"), heights, strict=True)
        ],
    )
    yield _table(
        "Tanks",
        ["", "level [m]", "mass [t]", "filled", "free to a heel [deg]", "to a trim [deg]"],
        [
            [
                t.tank.name,
                f"{t.level:.3f}",
                f"{t.mass / 1e3:.1f}",
                f"{t.filled:.1%}",
                *("" if np.isnan(x) else _angle(x) for x in t.reach),
            ]
            for t in found.tanks
        ],
    )
    matrix = loading._replace(centre=loading.centre - np.array(found.body.centre_of_gravity)).matrix
    yield _table(
        "Mass matrix about the body's origin [kg, kg m, kg m^2]",
        ["", *ROWS],
        [[dof, *map(_short, row)] for dof, row in zip(ROWS, matrix, strict=True)],
    )


def _upright(found: Sequence[Condition], angle: float) -> Iterator[str]:
    """Remarks on tables, whose walls are upright also where the surface meets bottom or top."""
    from hydrosim.scene import TankTable

    for each in found:
        for t in each.tanks:
            if isinstance(t.tank.shape, TankTable) and abs(angle) > t.reach[0]:
                yield (
                    f"bodies.{each.body.name}.tanks.{t.tank.name}: a table has upright walls at"
                    f" every heel, but its surface meets bottom or top at {degrees(t.reach[0]):.3g}"
                    " deg: it takes less than is printed. Give it as a box or a mesh."
                )


def _planned(plan: Plan) -> Table:
    runs = zip(plan.pumps, plan.rate, plan.mass, strict=True)
    rows = [[name, f"{3.6 * rate:.1f}", f"{mass / 1e3:.1f}"] for name, rate, mass in runs]
    heave, heel, trim = plan.position[0, 2:5]
    at = f"heave {heave:.4f} m, heel {degrees(heel):.1e} deg, trim {degrees(trim):.1e} deg"
    title = f"Plan of {plan.within:g} s; at rest then: {at}"
    return _table(title, ["pump", "rate [t/hour]", "mass [t]"], rows)


def _shallow(found: Sequence[Condition]) -> Iterator[str]:
    """Remarks on free surfaces that meet bottom or top at once: GM is another beyond."""
    for each in found:
        for t in each.tanks:
            if 0.0 < t.reach[0] < SMALL:
                yield (
                    f"bodies.{each.body.name}.tanks.{t.tank.name}: its surface meets bottom or top"
                    f" at {_angle(t.reach[0])} deg of heel. GM is the slope at rest; at a larger"
                    " heel its free surface takes less: see --heel."
                )


def _angle(value: float) -> str:
    """An angle [rad] in degrees, to a hundredth or to two digits."""
    angle = degrees(value)
    return f"{angle:.2f}" if angle >= 0.1 or angle == 0.0 else f"{angle:.2g}"


def _short(value: float) -> str:
    return f"{value:.4g}".replace("e+0", "e").replace("e+", "e")


def _table(title: str, columns: list[str], rows: list[list[str]]) -> Table:
    table = Table(title=escape(title))
    for k, name in enumerate(columns):
        table.add_column(escape(name), justify="right" if k else "left")
    for row in rows:
        table.add_row(*map(escape, row))
    return table
