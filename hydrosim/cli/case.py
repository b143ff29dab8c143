"""Commands on cases: `hydrosim new`, `check`, `analyse` and `decay`."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from hydrosim.cli import options, terminal
from hydrosim.cli.options import argument, option
from hydrosim.errors import InputError

SEA = "Sea and water"


def new(
    context: typer.Context,
    path: Annotated[
        Path | None, argument("CASE.yaml", "Case to write; with --example a folder.")
    ] = None,
    length: Annotated[
        str | None, option('Length on the waterline: "180 m", or metres.', metavar="LENGTH")
    ] = None,
    beam: Annotated[str | None, option("Beam on the waterline.", metavar="LENGTH")] = None,
    draught: Annotated[str | None, option("Draught.", metavar="LENGTH")] = None,
    block_coefficient: Annotated[
        str | None, option("Displaced volume over length x beam x draught; default: 1.")
    ] = None,
    displacement: Annotated[
        str | None, option('Displaced mass instead: "79000 tonne".', metavar="MASS")
    ] = None,
    kg: Annotated[
        str | None,
        option("Centre of gravity above the keel; default: the draught.", metavar="LENGTH"),
    ] = None,
    water_depth: Annotated[
        str | None, option('Depth, or "infinite", the default.', metavar="LENGTH", panel=SEA)
    ] = None,
    significant_height: Annotated[
        str | None, option("Significant height; default: 1.5 m.", metavar="LENGTH", panel=SEA)
    ] = None,
    peak_period: Annotated[
        str | None, option("Peak period; default: 8 s.", metavar="TIME", panel=SEA)
    ] = None,
    database: Annotated[
        Path | None, option("Database to use; without it a recipe is written.", metavar="FILE")
    ] = None,
    example: Annotated[
        str | None,
        option("Write this example with its databases instead; list: print names.", metavar="NAME"),
    ] = None,
    schema: Annotated[
        str | None,
        option("Print a JSON schema for editors: case, study or recipe.", metavar="KIND"),
    ] = None,
) -> None:
    """Write a commented case of a barge from its main particulars.

    Numbers are in SI or carry a unit, as in --length "590 ft". Comments in the case say what was
    assumed. Files that exist are not replaced.
    """
    from hydrosim.files.arguments import one_of
    from hydrosim.interface import new as writing

    given = terminal.given_options(context)
    if schema is not None:
        _refuse_others(given, "schema")
        kind = one_of(writing.FileKind, schema, "schema")
        typer.echo(json.dumps(writing.schema_of(kind)))
        return
    if example is not None:
        _refuse_others(given, "example", "path")
        if example == "list":
            terminal.print_lines(*writing.example_names())
            return
        cases = writing.write_example(example, path or Path())
        terminal.print_lines(*(f"case      {case}" for case in cases))
        terminal.print_lines(f"about     {cases[0].with_name('README.md')}")
        return
    missing = [name for name in ("length", "beam", "draught") if name not in given]
    if missing or path is None:
        raise InputError(
            f"{', '.join(missing) or 'CASE.yaml'}: found none; expected CASE.yaml, `length`, `beam`"
            " and `draught`, or `example` or `schema`."
        )
    files = writing.write_new_case(given.pop("path"), **given)
    names = ("case", "recipe")[: len(files)]
    terminal.print_lines(*(f"{name:10s}{file}" for name, file in zip(names, files, strict=True)))
    builds = [f"hydrosim db build {shlex.quote(str(file))}" for file in files[1:]]
    check_it = f"hydrosim check {shlex.quote(str(files[0]))}"
    terminal.print_lines(f"next      {'; '.join([check_it, *builds])}")


def _refuse_others(given: dict[str, Any], *names: str) -> None:
    if others := [name for name in given if name not in names]:
        raise InputError(f"{', '.join(others)}: not possible with `{names[0]}`. Leave it out.")


def check(
    case_file: options.CaseFile,
    time: Annotated[
        str,
        option('Also print step limits and periods at these times: "30 min, 1 hour".'),
    ] = "",
    verbose: options.Verbose = False,
    settings: options.Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Validate a case; print verdicts, step limits and natural periods.

    --verbose adds the data that the scene uses and the data that it ignores. If the case needs
    results of other cases that were not run yet, the command names them and stops. Exit code 1: a
    verdict is "failed", such as a step that is unstable.
    """
    from hydrosim.case.load import load_case
    from hydrosim.files.arguments import quantity
    from hydrosim.files.document_nodes import Outcome, Verdict
    from hydrosim.report.sentences.check import check_document
    from hydrosim.simulation import outdated_reason

    times = [quantity("time", part, "time", "s", "1 hour") for part in time.split(",") if time]
    case = load_case(case_file, settings)
    missing = [reason for stage in case.stages() if (reason := outdated_reason(stage))]
    for reason in missing:
        terminal.print_lines(f"first stage: {reason}; hydrosim run {case_file} simulates it")
    if missing:
        return

    with terminal.computing("checking") as report:

        def report_items(items: Sequence[Any], what: str) -> Iterator[Any]:
            for k, item in enumerate(items):
                report(k, len(items), f"step limits by {what}")
                yield item

        document = check_document(case.scene(), times, report_items)
    terminal.show_document(document, verbose)
    if any(isinstance(node, Verdict) and node.outcome is Outcome.BAD for node in document.nodes):
        raise typer.Exit(1)


LINEAR, LINE, BALLAST = "Linear analysis, the default", "Mooring line", "Ballast"
CONVERGE = "Methods and steps"


def analyse(
    context: typer.Context,
    file: Annotated[Path, argument("CASE.yaml", "Case, or file of MoorDyn or MoorPy.")],
    time: Annotated[
        str | None,
        option('Time of loads and tanks: "10 min"; default: 0 s.', metavar="TIME", panel=LINEAR),
    ] = None,
    headings: Annotated[
        str | None, option("Headings of RAOs (deg), with commas; default: the sea.", panel=LINEAR)
    ] = None,
    periods: Annotated[
        str | None, option("Periods of RAOs (s); default: those of databases.", panel=LINEAR)
    ] = None,
    database: Annotated[
        bool,
        option(
            "Added mass and damping of databases, not of the model.", "--database", panel=LINEAR
        ),
    ] = False,
    contacts: Annotated[
        str | None,
        option("Contacts pressed at rest: stuck (default), sliding or open.", panel=LINEAR),
    ] = None,
    line: Annotated[
        str | None,
        option("Analyse this mooring line; all: the first.", metavar="NAME", panel=LINE),
    ] = None,
    offset: Annotated[
        str | None,
        option(
            'Largest offset of the fairlead: "20 m"; default: 10 % of the height.',
            metavar="LENGTH",
            panel=LINE,
        ),
    ] = None,
    ballast: Annotated[
        bool, option("Loading condition at --time; plan of pumps.", "--ballast", panel=BALLAST)
    ] = False,
    lift: Annotated[
        str | None,
        option('Weight to be lifted off: "20000 tonne_force".', metavar="FORCE", panel=BALLAST),
    ] = None,
    rise: Annotated[
        str | None, option('Rise of the body: "0.5 m".', metavar="LENGTH", panel=BALLAST)
    ] = None,
    within: Annotated[
        str | None,
        option("Longest duration of the plan; default: 1 hour.", metavar="TIME", panel=BALLAST),
    ] = None,
    heel: Annotated[
        str | None,
        option('Loss of GM by free surfaces at: "5 deg".', metavar="ANGLE", panel=BALLAST),
    ] = None,
    body: Annotated[
        str | None,
        option("Body of the plan; default: the first with tanks.", metavar="NAME", panel=BALLAST),
    ] = None,
    converge: Annotated[
        bool, option("Error and run time of methods and steps.", "--converge", panel=CONVERGE)
    ] = False,
    methods: Annotated[
        str | None, option("Methods; default: rk2,rk4,dopri5.", panel=CONVERGE)
    ] = None,
    steps: Annotated[str | None, option("Steps (s); default: 0.1,0.05,0.025.", panel=CONVERGE)] = (
        None
    ),
    tolerances: Annotated[
        str | None, option("Of adaptive methods; default: 1e-5,1e-6,1e-7.", panel=CONVERGE)
    ] = None,
    output: options.Output = None,
    verbose: options.Verbose = False,
    overwrite: options.Overwrite = False,
    settings: options.Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Analyse a case without a run: modes, RAOs, response in the sea.

    The equilibrium is without friction. --line, --ballast and --converge analyse a mooring line,
    the loading condition, or methods and steps instead. Tables are printed, a picture and netCDF
    are written.
    """
    from hydrosim.case.load import load_case
    from hydrosim.files.arguments import require_file
    from hydrosim.interface import analyse as analysing

    require_file(file, analysing.EXPECTED_FILE)
    case: Any = file
    if not analysing.is_file_of_lines(file):
        case = load_case(file, settings)
    elif settings:
        raise InputError(f"--set: found a setting, and {file} is no case; expected a case.")
    given = terminal.given_options(context, "file", "verbose", "settings")
    given["output"] = output or True
    if converge:
        terminal.run_earlier_stages(case, terminal.simulate_with_progress)
    with terminal.computing("analysing") as report:
        result = analysing.analyse(case, **given, progress=lambda what: report(remark=what))
    terminal.show_result(result, verbose)


def decay(
    records: Annotated[
        list[Path],
        argument("DECAY...", "Recordings of decaying roll: text, netCDF, MATLAB or HDF5."),
    ],
    column: Annotated[
        str, option("Column of the roll angle: its name or number.", metavar="NAME")
    ] = "roll",
    unit: Annotated[str, option("deg or rad, if the file does not say it.")] = "",
    start: options.From = "",
    end: options.To = "",
    body: Annotated[str, option("Body in the keys that are written.", metavar="NAME")] = "barge",
    output: Annotated[
        Path | None,
        option("File to write the keys of a case to.", "--output", "-o", metavar="KEYS.yaml"),
    ] = None,
    verbose: options.Verbose = False,
    overwrite: options.Overwrite = False,
) -> None:
    """Fit roll damping and natural period to recorded decay tests.

    The command prints p1, p2, p3 with 90 % intervals, draws the fit, and writes the keys of a case.
    """
    from hydrosim.interface.analyse import fit_decay

    with terminal.progress("fitting"):
        result = fit_decay(
            records,
            column=column,
            unit=unit,
            start=start,
            end=end,
            body=body,
            output=output or True,
            overwrite=overwrite,
        )
    terminal.show_result(result, verbose)
