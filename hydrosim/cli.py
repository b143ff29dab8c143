"""The command line: thin commands over `load_case`, `simulate` and `plot`.

Exit codes: 0 done, 1 a strict check failed or a comparison is out of tolerance, 2 the input is
wrong, 3 the simulation failed, 130 interrupted.
"""

from __future__ import annotations

import atexit
import gc
import io
import os
import sys
import warnings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: more threads only wait

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from hydrosim.commands import db
from hydrosim.commands.ballast import ballast
from hydrosim.commands.case import case
from hydrosim.commands.compare import compare, record
from hydrosim.commands.compiling import announced
from hydrosim.commands.explain import explain
from hydrosim.commands.linear import linear
from hydrosim.commands.operability import operability
from hydrosim.commands.options import (
    CaseFile,
    Overwrite,
    Settings,
    numbers,
    one_of,
    placed,
    quantity,
)
from hydrosim.commands.report import report
from hydrosim.commands.schema import schema
from hydrosim.commands.statistics import statistics
from hydrosim.commands.sweep import sweep
from hydrosim.commands.terminal import printable, show
from hydrosim.errors import HydrosimError, InputError, SimulationError
from hydrosim.interrupts import taken_as_interrupts

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.case import Case
    from hydrosim.outputs import Output

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    help="Time-domain simulation of floating bodies, with exact stick-slip contact.",
)
app.add_typer(db.app, name="db")
app.command()(ballast)
app.command()(case)
app.command()(compare)
app.command()(record)
app.command()(report)
app.command()(schema)
app.command()(linear)
app.command()(operability)
app.command()(statistics)
app.command()(explain)
app.command()(sweep)
err = Console(stderr=True)


def _version(asked: bool) -> None:
    if asked:
        from hydrosim.outputs import program_version

        show(f"hydrosim {program_version()}")
        raise typer.Exit


@app.callback()
def _of_all(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    pass


# Loading makes many objects that stay: they need not be gone through for garbage all the time, nor
# at the end, where it would take a third of a second.
gc.set_threshold(50_000)
atexit.register(gc.freeze)


@app.command()
def run(
    case_file: CaseFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="RUN.nc", help="Result file.")
    ] = None,
    settings: Settings = [],  # noqa: B006  typer copies it
    plot_too: Annotated[bool, typer.Option("--plot", help="Also draw the pictures.")] = False,
    overwrite: Overwrite = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a run that was killed or interrupted.")
    ] = False,
    every: Annotated[
        float, typer.Option("--checkpoint", min=0.0, metavar="SECONDS", help="Keep it so often.")
    ] = 60.0,
) -> None:
    """Simulate a case; write netCDF and print a summary."""
    from hydrosim.case import load_case

    case = load_case(case_file, settings)
    inputs = case.inputs()
    result = placed(output, case_file.stem, "run", case_file, inputs=inputs, overwrite=overwrite)
    if plot_too:
        _planned_pictures(result)

    def simulated(case: Case, result: Output) -> xr.Dataset:
        return _simulate_with_progress(case, result, resume, every)

    _complete(case, simulated)
    _require_room(case, result.path)
    try:
        dataset = simulated(case, result)
    except SimulationError as error:
        show(f"result    {_save(error.dataset, result)}")
        raise
    path = _save(dataset, result)
    _summary(dataset, path)
    if plot_too:
        plot(path, overwrite=overwrite)
    if dataset.attrs["status"] == "interrupted":
        raise typer.Exit(130)


@app.command()
def check(
    case_file: CaseFile,
    time: Annotated[
        str, typer.Option(help='Step limits and natural periods also then: "30 min, 1 hour".')
    ] = "",
    settings: Settings = [],  # noqa: B006
) -> None:
    """Validate a case; print what the scene needs and skips, step limits and natural periods.

    Where tanks change, those are told of the start and of the end. Of a case that is driven by the
    runs of others it says which of those have to be made first.
    """
    from hydrosim.case import load_case
    from hydrosim.studies.check import survey
    from hydrosim.studies.stages import outdated

    times = [quantity("--time", part, "time", "s", "1 hour") for part in time.split(",") if time]
    case = load_case(case_file, settings)
    missing = [reason for stage in case.stages() if (reason := outdated(stage))]
    for reason in missing:
        show(f"first stage: {reason}; hydrosim run {case_file} simulates it")
    if missing:
        return
    with announced(err):
        for part in survey(case.scene(), times):
            show(part)


@app.command()
def converge(
    case_file: CaseFile,
    methods: Annotated[str, typer.Option(help="Methods, by commas.")] = "rk2,rk4,dopri5",
    steps: Annotated[str, typer.Option(help="Steps [s], by commas.")] = "0.1,0.05,0.025",
    tolerances: Annotated[str, typer.Option(help="Of adaptive methods.")] = "1e-5,1e-6,1e-7",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="STUDY.nc", help="Result file.")
    ] = None,
    overwrite: Overwrite = False,
    settings: Settings = [],  # noqa: B006
) -> None:
    """Error against run time, over methods and steps: table, picture and netCDF."""
    from hydrosim.case import load_case
    from hydrosim.commands.summary import convergence
    from hydrosim.plot.work_precision import draw_work_precision
    from hydrosim.results.output import write
    from hydrosim.scene import Method
    from hydrosim.studies.converge import converge as study_of
    from hydrosim.studies.converge import to_dataset

    chosen = [one_of(Method, name, "--methods") for name in methods.split(",")]
    all_steps, all_tolerances = numbers(steps, "--steps"), numbers(tolerances, "--tolerances")
    case, name = load_case(case_file, settings), f"{case_file.stem}_converge"
    inputs = case.inputs()
    made = placed(output, name, "convergence", case_file, inputs=inputs, overwrite=overwrite)
    page = made.at(made.path.with_suffix(".png"), "picture").checked()
    _complete(case, _simulate_with_progress)
    scene = case.scene()
    with announced(err), err.status("running") as status:
        study = study_of(scene, chosen, all_steps, all_tolerances, status.update)
    dataset = to_dataset(study, scene.title)
    write(dataset, made)
    draw_work_precision(dataset, page)
    show(convergence(study), f"result    {made.path}, {page.path}")


@app.command()
def plot(
    run_file: Annotated[
        Path, typer.Argument(metavar="RUN.nc", help="Result of a run, or of a study.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FOLDER", help="Where to put them.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Draw motions, forces, contact and energies of a run, or the figures of a study, as PNG."""
    from hydrosim.commands.study import draw_runs
    from hydrosim.plot import draw, open_run
    from hydrosim.results.runs_file import open_runs

    folder = run_file.parent if output is None else output
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; expected a folder for the pictures.")
    if (runs := open_runs(run_file)) is not None:
        draw_runs(runs, folder, run_file, overwrite)
        return
    dataset = open_run(run_file)
    for picture in draw(dataset, folder, run_file.stem, run_file, overwrite):
        show(f"picture   {picture}")


def _require_room(case: Case, path: Path) -> None:
    """Refuse a run whose result would not fit on the disk."""
    from shutil import disk_usage

    from hydrosim.compiling import sizes

    size, free = sizes.result(case.scene()), disk_usage(path.parent).free
    if size > free:
        found = f"about {sizes.shown(size)}, and {sizes.shown(free)} are free"
        raise InputError(f"--output: the result is {found}; record less often (output.step).")


def _complete(case: Case, run: Callable[[Case, Output], xr.Dataset]) -> None:
    """Make the runs that the case needs, and say so."""
    from hydrosim.studies.stages import complete

    complete(case, run, lambda text: _say(f"first stage: {text}"))


def _say(text: str) -> None:
    err.print(printable(text), markup=False, highlight=False, soft_wrap=True)


def _simulate_with_progress(
    case: Case, result: Output, resume: bool = False, every: float = 60.0
) -> xr.Dataset:
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    from hydrosim.compiling.restart import begin, opened
    from hydrosim.studies.checkpoint import Checkpoint, checkpoint_of
    from hydrosim.studies.simulation import simulate

    kept = Checkpoint(checkpoint_of(result), every, resume, _say)
    scene = opened(case.scene())
    start = begin(scene)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f} s"),
        TextColumn("{task.fields[speed]}"),
        *(TimeElapsedColumn(), TimeRemainingColumn()),
    )
    with announced(err), Progress(*columns, console=err, transient=True) as bar:
        task = bar.add_task("simulating", total=scene.duration, speed="")

        def report(time: float, steps: int) -> None:
            elapsed = bar.tasks[task].elapsed or 0.0
            speed = f"{steps / elapsed:,.0f} steps/s" if elapsed > 0.0 else ""
            bar.update(task, completed=time - start, speed=speed)

        return simulate(scene, report, kept)


def _planned_pictures(result: Output) -> None:
    """Refuses, before the run, pictures that would replace others."""
    from hydrosim.plot.pictures import planned

    planned(result.path.parent, result.path.stem, result.path, result.overwrite)


def _save(dataset: xr.Dataset, result: Output) -> Path:
    """Write a run; one that did not come to its end stands aside for one that did, and any for
    what has come there meanwhile. Its path."""
    from hydrosim.results.output import status_of, write
    from hydrosim.studies.checkpoint import checkpoint_of

    status = dataset.attrs["status"]
    better = status != "complete" and status_of(result.path) == "complete"
    place = result.aside() if better else result.settled()
    write(dataset, place)
    if status != "interrupted":
        checkpoint_of(result).clear()
    return place.path


def _summary(dataset: xr.Dataset, path: Path) -> None:
    from hydrosim.commands.summary import lines

    show(*lines(dataset), f"result    {path}")


def main() -> None:
    """Run the command line; a message meant for people ends it with its own exit code."""
    taken_as_interrupts()
    _print_anywhere()
    warnings.showwarning = lambda message, *_, **__: _say(f"warning   {message}")
    try:
        try:
            app()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:  # who reads has seen enough
        os._exit(1)
    except OSError as error:
        err.print(f"[bold red]error[/] {_plain(error)}", highlight=False, soft_wrap=True)
        os._exit(3)  # what is left to be printed cannot be
    except MemoryError:
        err.print("[bold red]error[/] there is not enough memory for this", soft_wrap=True)
        raise SystemExit(3) from None
    except HydrosimError as error:
        err.print(f"[bold red]error[/] {_plain(error)}", highlight=False, soft_wrap=True)
        raise SystemExit(error.exit_code) from None


def _print_anywhere() -> None:
    """Print what a terminal or a pipe has no character for as its number."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _plain(error: Exception) -> str:
    return printable(str(error)).replace("[", "\\[")
