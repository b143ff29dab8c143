"""`hydrosim db`: print, check, convert and compute hydrodynamic databases."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from hydrosim.cli.options import GivenSettings, Overwrite, Plot, Settings
from hydrosim.cli.terminal import (
    Command,
    given_database,
    print_lines,
    print_resume_hint,
    print_status,
    progress,
    show_document,
)
from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.database.database import HydroDatabase
    from hydrosim.files.outputs import Output
    from hydrosim.scene.hydrodynamics import Given

app = typer.Typer(
    no_args_is_help=True, help="Print, check, convert and compute hydrodynamic databases."
)

STORED_STEP_S = 0.02  # that reading a stored frequency takes, at most
PICTURE_SUFFIXES = (".png", ".pdf", ".svg")
MAX_TABLE_STEPS = 1_000_000  # steps of a table

DatabaseFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="Hydrodynamic database to read.")
]


@app.command(cls=Command)
def info(file: DatabaseFile, given: GivenSettings = []) -> None:  # noqa: B006
    """Print the content of a database."""
    from hydrosim.database.load import read, recognise
    from hydrosim.report.sentences.database import contents

    asked = given_database(file, given)
    db = read(file, asked)
    show_document(contents(db, recognise(file)[0].NAME))
    print_lines(*_database_caveats(db, asked))


@app.command(cls=Command)
def check(
    file: DatabaseFile,
    strict: Annotated[
        bool, typer.Option("--strict", help="End with exit code 1 if a check fails.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="PICTURE", help="Also draw the coefficients into this file."
        ),
    ] = None,
    given: GivenSettings = [],  # noqa: B006
    overwrite: Overwrite = False,
) -> None:
    """Check a database against physical identities; draw its coefficients.

    Exit code 2 if the database is refused; 1 with --strict if a check fails.
    """
    from hydrosim.database.checks import check as findings_of
    from hydrosim.database.load import read
    from hydrosim.report.sentences.database import verdicts

    drawn = None if output is None else _picture_output(output, file, overwrite)
    asked = given_database(file, given)
    db = read(file, asked)
    findings = findings_of(db)
    refused = any(finding.is_refused for finding in findings)
    show_document(verdicts(db, findings))
    print_lines(*_database_caveats(db, asked))
    if drawn is not None:
        from hydrosim.report.charts.database import draw_database

        draw_database(db, drawn)
        print_lines(f"picture   {output}")
    if refused:
        raise typer.Exit(2)
    if strict and not all(finding.has_passed for finding in findings):
        raise typer.Exit(1)


@app.command(cls=Command)
def convert(
    file: DatabaseFile,
    out: Annotated[
        Path, typer.Argument(metavar="OUT", help="File to write; its suffix selects the format.")
    ],
    given: GivenSettings = [],  # noqa: B006
    overwrite: Overwrite = False,
) -> None:
    """Read a database of any format and write it in another, checked."""
    from hydrosim.database.load import format_of, load, set_of, write
    from hydrosim.files.arguments import output_for

    asked = given_database(file, given)
    if format_of(out) != ".nc" and asked.accept:
        raise InputError(
            f"--given accept: {out} cannot store accepted findings; expected an .nc file."
        )
    inputs = set_of(file)
    output = output_for(out, "", "database", file, inputs=inputs, overwrite=overwrite, suffix=None)
    assert output is not None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        db = load(file, asked, asked)
        files = write(db, output)
    print_lines(
        *(f"warning   {warning.message}" for warning in caught), *_database_caveats(db, asked)
    )
    print_lines(*(f"result    {path}" for path in files))


@app.command(cls=Command)
def kernel(
    file: DatabaseFile,
    until: Annotated[
        str,
        typer.Option(
            metavar="TIME", help='Last time of the table: "2 min", or a number in seconds.'
        ),
    ] = "100 s",
    every: Annotated[
        str,
        typer.Option(
            metavar="TIME", help='Time step of the table: "0.1 s", or a number in seconds.'
        ),
    ] = "0.1 s",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="TABLE.csv", help="Table to write.")
    ] = None,
    given: GivenSettings = [],  # noqa: B006
    overwrite: Overwrite = False,
) -> None:
    """Write the retardation functions as a table, and draw them."""
    from hydrosim.database.kernels import kernels, write_table
    from hydrosim.database.load import read
    from hydrosim.files.arguments import output_for, seconds
    from hydrosim.report.charts.database import draw_kernels

    end, step = seconds("until", until), seconds("every", every)
    if not (step > 0.0 and 2 <= end / step <= MAX_TABLE_STEPS):
        raise InputError(
            f"until, every: {end:g} s in steps of {step:g} s; expected 2 to"
            f" {MAX_TABLE_STEPS} steps."
        )
    name = f"{file.stem}_kernel"
    made = output_for(output or True, name, "kernel", file, overwrite=overwrite, suffix=".csv")
    assert made is not None
    page = made.output_at(made.path.with_suffix(".png"), "picture").checked_output()
    asked = given_database(file, given)
    db = read(file, asked)
    time, functions, report = kernels(db, end, step)
    write_table(db, time, functions, made)
    draw_kernels(db.attributes.get("title", file.name), time, functions, page)
    print_lines(report, *_database_caveats(db, asked), f"result    {made.path}, {page.path}")


@app.command(cls=Command)
def build(
    recipe: Annotated[Path, typer.Argument(metavar="RECIPE.yaml", help="Recipe to read.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="OUT.nc", help="Database to write.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Number of processes.")] = 1,
    plot: Plot = False,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006  typer copies it
) -> None:
    """Compute a database from a hull. After an interruption, the same command continues."""
    from hydrosim.interface.database import build_database

    with print_resume_hint("the same command"), progress("computing", "frequencies") as report:
        time_left = TimeLeft()

        def tell(done: int, total: int) -> None:
            left = time_left.update(done, total)
            report(done, total, f"{_duration_text(left)} left" if left > 0.0 else "")

        def announce(seconds: float) -> None:
            time_left.expected = seconds
            print_status(
                f"estimate  {_duration_text(seconds)} for the frequencies that are not stored yet"
            )

        files = build_database(
            recipe,
            output=output,
            workers=workers,
            plot=plot,
            overwrite=overwrite,
            settings=settings,
            progress=tell,
            announce=announce,
        )
    for path in files:
        print_lines(f"result    {path}")


class TimeLeft:
    """Time [s] that steps still take: an ``expected`` one until the first of them has been
    computed, then by their pace. Steps that are stored come first, and within no time."""

    def __init__(self, clock: Callable[[], float] = perf_counter) -> None:
        self.expected = 0.0
        self._clock = clock
        self._begun = clock()
        self._stored = 0

    def update(self, done: int, total: int) -> float:
        """Time left with so many of all steps ``done``; zero if it is not known."""
        now = self._clock()
        if (done <= self._stored + 1 and now - self._begun < STORED_STEP_S) or done == 0:
            self._begun = now
            self._stored = done
        computed = done - self._stored
        if computed == 0:
            return self.expected
        return (now - self._begun) / computed * (total - done)


def _duration_text(seconds: float) -> str:
    """ "about 40 s", "about 12 min", "about 2.1 hours"."""
    if seconds < 90.0:
        return f"about {max(seconds, 1.0):.0f} s"
    return (
        f"about {seconds / 60.0:.0f} min"
        if seconds < 5400.0
        else f"about {seconds / 3600.0:.1f} hours"
    )


def _database_caveats(db: HydroDatabase, given: Given) -> list[str]:
    """Print warnings: options that the file does not need, and values that were assumed."""
    from hydrosim.database.load import overruled_values

    lines = [
        f"warning   {db.source} has its own {name.replace('_', ' ')}; the option is ignored"
        for name in overruled_values(db, given)
    ]
    assumed = db.attributes.get("assumed")
    if assumed and "recipe" not in db.attributes:  # those of a recipe are its author's
        lines.append(
            f"warning   {db.source} lacks some data; assumed: {assumed}. If that is wrong, give"
            " the data: --given KEY=VALUE, with the keys of `hydrodynamics` in a case."
        )
    return lines


def _picture_output(path: Path, file: Path, overwrite: bool) -> Output:
    """Output for the picture of a database. Raises `InputError` if it cannot be written to
    ``path``."""
    if path.suffix not in PICTURE_SUFFIXES:
        raise InputError(f"output: found {path}; expected one of {', '.join(PICTURE_SUFFIXES)}.")
    from hydrosim.files.arguments import output_for

    picture = output_for(path, "", "picture", file, overwrite=overwrite, suffix=path.suffix)
    assert picture is not None
    return picture
