"""Commands of analyses: `hydrosim linear`, `line`, `ballast`, `converge` and `calibrate`."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from hydrosim.cli import terminal
from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.analysis.ballast import PumpPlan
    from hydrosim.analysis.line import StillLine
    from hydrosim.files.display_units import Units
    from hydrosim.files.outputs import Output

err = terminal.progress_console()


def linear(
    case_file: terminal.CaseFile,
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
    verbose: terminal.Verbose = False,
    overwrite: terminal.Overwrite = False,
    settings: terminal.Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Compute equilibrium without friction, natural modes, RAOs and the response in the sea; print
    tables, draw a picture, write netCDF."""
    import numpy as np

    from hydrosim.analysis.seakeeping import LinearRequest, linear_analysis
    from hydrosim.case.load import load_case
    from hydrosim.compile.compile import Radiation
    from hydrosim.linear.equilibrium import Contacts
    from hydrosim.report.charts.analysis import draw_response
    from hydrosim.report.sentences.analysis import linear_document
    from hydrosim.results.dataset import write_run

    case = load_case(case_file, settings)
    name = f"{case_file.stem}_linear"
    asked = {
        "--time": time,
        "--headings": headings,
        "--periods": periods,
        "--database": own,
        "--contacts": contacts,
    }
    made = terminal.output_for(
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
        terminal.seconds("--time", time, 0.0),
        [float(np.radians(b)) for b in terminal.numbers(headings, "--headings", positive=False)]
        if headings
        else (),
        sorted(2 * np.pi / t for t in terminal.numbers(periods, "--periods")) if periods else (),
        Radiation.DATABASE if own else Radiation.MODEL,
        contacts=terminal.one_of(Contacts, contacts, "--contacts"),
    )
    scene = case.scene()
    with made.hold_lock(), terminal.announce_compiling(err), terminal.progress("linear analysis"):
        analysis = linear_analysis(scene, wanted)
        write_run(analysis, made)
    draw_response(analysis, page)
    terminal.show_document(linear_document(analysis, raos=bool(periods)), verbose)
    terminal.print_lines(f"result    {made.path}, {page.path}")


# `hydrosim line`: offset of a mooring line's fairlead against tension and stiffness.

EXPECTED_FILE = "a case file (YAML), or an input file of MoorDyn or MoorPy"


def line(
    file: Annotated[
        Path,
        typer.Argument(metavar="CASE.yaml|FILE", help="Case, or file of MoorDyn or MoorPy."),
    ],
    name: Annotated[
        str | None,
        typer.Option("--line", metavar="NAME", help="The line; default: all at rest, and one."),
    ] = None,
    offset: Annotated[
        str | None,
        typer.Option(help='Largest offset, both ways: "20 m"; default: 10 % of the height.'),
    ] = None,
    keys: Annotated[
        bool, typer.Option("--case", help="Print the lines of the file as keys of a case.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PICTURE.png", help="Picture file to write."),
    ] = None,
    verbose: terminal.Verbose = False,
    overwrite: terminal.Overwrite = False,
    settings: terminal.Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Print and draw tension, pull, stiffness and grounded length of a mooring line over offsets of
    its fairlead, with the lines of the file at rest."""
    from hydrosim.case.lines.chains import is_mooring_file

    terminal.require_file(file, EXPECTED_FILE)
    of_others = is_mooring_file(file)
    if of_others and settings:
        raise InputError(f"--set: found a setting, and {file} is no case; expected a case.")
    if keys:
        if not of_others:
            raise InputError(f"--case: found {file}, a case; expected a file of MoorDyn or MoorPy.")
        _print_keys(file)
        return
    largest = terminal.quantity("--offset", offset, "length", "m", "20 m") if offset else None
    if largest is not None and not largest > 0.0:
        raise InputError(f"--offset: found {largest:g} m; expected a length above 0.")
    page = terminal.output_for(
        output, f"{file.stem}_line", "line", file, overwrite=overwrite, suffix=".png"
    )
    with page.hold_lock(), terminal.announce_compiling(err), terminal.progress("lines"):
        lines_to_show = _lines_of_file(file) if of_others else _lines_of_case(file, settings)
    chosen = _choose_line(file, lines_to_show.lines, name)
    shown = lines_to_show._replace(lines=[chosen] if name else lines_to_show.lines)
    _print_line(shown, chosen, largest, page, verbose)


class LinesToShow(NamedTuple):
    """The ``lines`` of a case or file with its ``title``, the ``units`` to show them in, and what
    of the file is ``left_out``."""

    title: str
    lines: list[StillLine]
    units: Units
    left_out: list[str]


def _lines_of_file(file: Path) -> LinesToShow:
    """The lines of a file of another program."""
    from hydrosim.analysis.line import lines_of_system
    from hydrosim.case.lines.chains import read_mooring_system
    from hydrosim.files.display_units import DEFAULT
    from hydrosim.files.text import Source

    system = read_mooring_system(Source(file))
    left_out = [entry.message for entry in system.left_out]
    return LinesToShow(file.name, lines_of_system(system), DEFAULT, left_out)


def _lines_of_case(file: Path, settings: list[str]) -> LinesToShow:
    """Those of a case, with its bodies as they are at the start."""
    from hydrosim.analysis.line import lines_of_case
    from hydrosim.case.load import load_case
    from hydrosim.compile.compile import compile_in_calm
    from hydrosim.files.display_units import units_of

    scene = load_case(file, settings).scene()
    lines = lines_of_case(compile_in_calm(scene))
    return LinesToShow(scene.title, lines, units_of(scene.source), [])


def _choose_line(file: Path, lines: list[StillLine], name: str | None) -> StillLine:
    """The line that is asked for, or the first."""
    lines_by_name = {line.name: line for line in lines}
    if not lines_by_name:
        raise InputError(f"{file}: found no catenary; expected one under forces.")
    if name is not None and name not in lines_by_name:
        raise InputError(f"--line: found {name}; expected one of {', '.join(lines_by_name)}.")
    return lines_by_name[name] if name is not None else lines[0]


def _print_line(
    lines_to_show: LinesToShow,
    chosen: StillLine,
    largest: float | None,
    page: Output,
    verbose: bool,
) -> None:
    from hydrosim.analysis.line import offsets_to, response
    from hydrosim.report.charts.analysis import draw_line
    from hydrosim.report.sentences.analysis import line_document

    offsets = offsets_to(largest or chosen.usual_offset())
    along, up = (response(chosen, offsets, way) for way in (False, True))
    named = f"{lines_to_show.title}: line {chosen.name}"
    draw_line(named, chosen, (along, up), page, lines_to_show.units)
    document = line_document(
        named, lines_to_show.lines, (along, up), lines_to_show.units, lines_to_show.left_out
    )
    terminal.show_document(document, verbose)
    terminal.print_lines(f"picture   {page.path}")


def _print_keys(file: Path) -> None:
    from hydrosim.case.lines.chains import case_keys

    typer.echo(case_keys(file), nl=False)


# `hydrosim ballast`: loading conditions of bodies with tanks, and pump plans.

MAX_ANGLE_RAD = 1.48  # rad (85 deg)


def ballast(
    case_file: terminal.CaseFile,
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
    verbose: terminal.Verbose = False,
    overwrite: terminal.Overwrite = False,
    settings: terminal.Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Print and draw the loading condition of bodies with tanks; plan their pumps."""
    from hydrosim.analysis.ballast import conditions, find_pump_plan
    from hydrosim.case.load import load_case
    from hydrosim.compile.compile import compile_in_calm
    from hydrosim.files.display_units import units_of
    from hydrosim.report.charts.analysis import draw_loading
    from hydrosim.report.sentences.analysis import ballast_document
    from hydrosim.tanks.contents import triggered_pumps

    case, name = load_case(case_file, settings), f"{case_file.stem}_ballast"
    page = terminal.output_for(
        *(output, name, "ballast", case_file),
        inputs=case.inputs(),
        overwrite=overwrite,
        suffix=".png",
    )
    at = terminal.quantity("--time", time, "time", "s", "1 hour")
    angle = terminal.quantity("--heel", heel, "angle", "rad", "5 deg") if heel else None
    if angle is not None and not 0.0 < abs(angle) < MAX_ANGLE_RAD:
        raise InputError(
            f"--heel: found {degrees(angle):.4g} deg; expected an angle above 0 and below 85 deg."
            ' A number without a unit is in rad: write "5 deg".'
        )
    scene = case.scene()
    having = [body.name for body in scene.bodies if body.tanks]
    if not having:
        raise InputError(
            f"{case_file}: no body has tanks; expected at least one. Add them under"
            " bodies.NAME.tanks."
        )
    if body is not None and body not in having:
        raise InputError(f"--body: found {body}; expected one of {', '.join(having)}.")
    with terminal.announce_compiling(err), terminal.progress("loading condition"):
        compiled = compile_in_calm(scene)
        conditions_found = conditions(compiled, at, angle)
        planned: PumpPlan | None = None
        if lift is not None or rise is not None:
            weight = (
                terminal.quantity("--lift", lift, "force", "N", "20000 tonne_force")
                if lift
                else None
            )
            up = terminal.quantity("--rise", rise, "length", "m", "0.5 m") if rise else 0.0
            span = terminal.quantity("--within", within, "time", "s", "1 hour")
            planned = find_pump_plan(compiled, body or having[0], span, weight, up)
    waiting = [pump.key for pump in triggered_pumps(scene)] if at > 0.0 else []
    draw_loading(conditions_found, at, page, units_of(scene.source))
    terminal.show_document(
        ballast_document(scene, conditions_found, at, angle, planned, waiting), verbose
    )
    terminal.print_lines(f"picture   {page.path}")


# `hydrosim converge`: error against run time of integration methods.


def converge(
    case_file: terminal.CaseFile,
    methods: Annotated[str, typer.Option(help="Methods, separated by commas.")] = "rk2,rk4,dopri5",
    steps: Annotated[str, typer.Option(help="Steps (s), separated by commas.")] = "0.1,0.05,0.025",
    tolerances: Annotated[
        str,
        typer.Option(help="Tolerances of methods that choose their own step, separated by commas."),
    ] = "1e-5,1e-6,1e-7",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="STUDY.nc", help="netCDF file to write."),
    ] = None,
    overwrite: terminal.Overwrite = False,
    settings: terminal.Settings = [],  # noqa: B006
) -> None:
    """Compare error and run time of methods and steps; print a table, draw it, write netCDF."""
    from hydrosim.case.load import load_case
    from hydrosim.files.display_units import unit_choice_attribute, units_of
    from hydrosim.report.charts.analysis import draw_work_precision
    from hydrosim.report.sentences.run import study_document
    from hydrosim.results.dataset import write_run
    from hydrosim.scene import Method
    from hydrosim.study.converge import converge as study_of
    from hydrosim.study.converge import to_dataset

    chosen = [terminal.one_of(Method, name, "--methods") for name in methods.split(",")]
    if Method.AUTOMATIC in chosen:
        raise InputError(
            "--methods: found automatic, which only selects one of the other methods; expected"
            " rk2, heun, rk4, dopri5 or esdirk4."
        )
    all_steps = terminal.numbers(steps, "--steps")
    all_tolerances = terminal.numbers(tolerances, "--tolerances")
    case = load_case(case_file, settings)
    name = f"{case_file.stem}_converge"
    asked = {"methods": chosen, "steps": all_steps, "tolerances": all_tolerances}
    made = terminal.output_for(
        output,
        name,
        "convergence",
        case_file,
        inputs=case.inputs(),
        overwrite=overwrite,
        settings=case.settings(asked),
    )
    page = made.output_at(made.path.with_suffix(".png"), "picture").checked_output()
    with made.hold_lock():
        terminal.run_earlier_stages(case, terminal.simulate_with_progress)
        scene = case.scene()
        with terminal.announce_compiling(err), terminal.progress("comparing") as report:

            def tell(trial: str) -> None:
                report(remark=trial)

            study = study_of(scene, chosen, all_steps, all_tolerances, tell)
        dataset = to_dataset(study, scene.title).assign_attrs(unit_choice_attribute(scene.source))
        write_run(dataset, made)
    draw_work_precision(dataset, page)
    terminal.show_document(study_document(study, scene.title, units_of(scene.source)))
    terminal.print_lines(f"result    {made.path}, {page.path}")


# `hydrosim calibrate`: roll damping from recorded decay tests.


def calibrate(
    records: Annotated[
        list[Path],
        typer.Argument(
            metavar="DECAY...", help="Recordings of decaying roll: text, netCDF, MATLAB or HDF5."
        ),
    ],
    column: Annotated[
        str, typer.Option(metavar="NAME", help="Column of the roll angle: its name or number.")
    ] = "roll",
    unit: Annotated[
        str, typer.Option(help="Unit of the column, deg or rad, if the file does not say it.")
    ] = "",
    start: terminal.From = "",
    end: terminal.To = "",
    body: Annotated[str, typer.Option(help="Body in the keys that are written.")] = "barge",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="KEYS.yaml", help="File to write the keys of a case to."
        ),
    ] = None,
    verbose: terminal.Verbose = False,
    overwrite: terminal.Overwrite = False,
) -> None:
    """Fit roll damping p1, p2, p3 and the natural period to decay tests, with 90 % intervals; draw
    the fit, and write the keys of a case."""
    from hydrosim.elements.roll_decay import fit_files
    from hydrosim.files.outputs import Output
    from hydrosim.report.charts.analysis import draw_decay
    from hydrosim.report.sentences.analysis import calibration_document, keys_of

    for path in records:
        terminal.require_file(path, "a recording of decaying roll")
    if unit not in ("", "deg", "rad"):
        raise InputError(f"--unit: found {unit!r}; expected deg or rad.")
    first = records[0]
    keys = output and Output(output, "keys", first, tuple(records), overwrite).checked_output()
    if output and output.suffix not in (".yaml", ".yml"):
        raise InputError(f"--output: found {output}; expected a name that ends in .yaml.")
    drawn = output.with_suffix(".png") if output else Path(f"{first.stem}_fit.png")
    page = Output(drawn, "picture", first, tuple(records), overwrite).checked_output()
    begin = terminal.seconds("--from", start, 0.0) if start else None
    close = terminal.seconds("--to", end, 0.0) if end else None
    with terminal.progress("fitting"):
        fit = fit_files(records, column, unit or None, begin, close)
    draw_decay(fit, page)
    terminal.show_document(calibration_document(fit), verbose)
    lines = keys_of(fit, body)
    if keys:
        with keys.write_complete() as path:
            path.write_text("\n".join([f"# {keys.mark}", *lines, ""]), encoding="utf-8")
        terminal.print_lines(f"keys      {keys.path}")
    else:
        terminal.print_lines(*lines)
    terminal.print_lines(f"picture   {page.path}")
