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

from typing import Annotated

import typer
from rich.console import Console

from hydrosim.commands import db
from hydrosim.commands.ballast import ballast
from hydrosim.commands.case import case
from hydrosim.commands.check import check
from hydrosim.commands.compare import compare, record
from hydrosim.commands.converge import converge
from hydrosim.commands.example import example
from hydrosim.commands.explain import explain
from hydrosim.commands.export import export
from hydrosim.commands.linear import linear
from hydrosim.commands.operability import operability
from hydrosim.commands.plot import plot
from hydrosim.commands.replay import replay
from hydrosim.commands.report import report
from hydrosim.commands.run import run
from hydrosim.commands.schema import schema
from hydrosim.commands.statistics import statistics
from hydrosim.commands.sweep import sweep
from hydrosim.commands.terminal import printable, say, show
from hydrosim.errors import HydrosimError
from hydrosim.interrupts import taken_as_interrupts

# in the order of `hydrosim --help`: first what is asked of a case, then of runs, then of files
COMMANDS = (
    *(check, run, linear, ballast, converge),
    *(plot, report, replay, statistics, explain, export, compare, record, case),
    *(sweep, operability, schema, example),
)

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Time-domain simulation of floating bodies, with exact stick-slip contact.",
)
for command in COMMANDS:
    app.command()(command)
app.add_typer(db.app, name="db")
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


def main() -> None:
    """Run the command line; a message meant for people ends it with its own exit code."""
    taken_as_interrupts()
    _print_anywhere()
    warnings.showwarning = lambda message, *_, **__: say(f"warning   {message}")
    try:
        try:
            app(prog_name="hydrosim")
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
