"""Arguments and options that commands share. One name means one thing in all of them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer


def option(text: str, *names: str, metavar: str | None = None, panel: str | None = None) -> Any:
    """An option with its help; ``panel`` is the group in which the help lists it."""
    return typer.Option(*names, metavar=metavar, help=text, rich_help_panel=panel)


def argument(metavar: str, text: str) -> Any:
    return typer.Argument(metavar=metavar, help=text)


CaseFile = Annotated[Path, argument("CASE.yaml", "Case file to read.")]
StudyFile = Annotated[Path, argument("STUDY.yaml", "Study file to read.")]
RunFile = Annotated[Path, argument("RUN.nc", "Result of a run.")]
ResultFile = Annotated[
    Path, argument("RESULT.nc", "Result of any command; of an unfinished study, RUNS.nc.partial.")
]
Settings = Annotated[
    list[str],
    option(
        "Change a value of the input file: solver.step=0.05. May be repeated.",
        "--set",
        metavar="KEY=VALUE",
    ),
]
Output = Annotated[
    Path | None,
    option("File to write; it has a name by default.", "--output", "-o", metavar="FILE"),
]
Overwrite = Annotated[
    bool, option("Replace existing files of any kind; keep no earlier result.", "--overwrite")
]
Resume = Annotated[bool, option("Continue what was killed or interrupted.", "--resume")]
Plot = Annotated[bool, option("Also draw pictures.", "--plot")]
Verbose = Annotated[bool, option("Also print the details.", "--verbose", "-v")]
Workers = Annotated[
    int | None,
    typer.Option(min=1, help="Number of simultaneous runs; default: the number of cores."),
]
From = Annotated[
    str,
    option(
        'Ignore everything before this time: "10 min", or a number in seconds.',
        "--from",
        metavar="TIME",
    ),
]
To = Annotated[
    str,
    option(
        'Ignore everything after this time: "1 hour", or a number in seconds.',
        "--to",
        metavar="TIME",
    ),
]
Channels = Annotated[
    str,
    option('Channels, with commas; * matches anything: "position.*,speed.barge".', metavar="NAMES"),
]
Body = Annotated[str | None, option("Body that it is about; there is a default.", metavar="NAME")]
GivenSettings = Annotated[
    list[str],
    option(
        "Data that the file lacks, or a change of the database; KEY as under `hydrodynamics` in a"
        ' case: density="1.025 tonne/m^3", depth="30 m", symmetrise=true.',
        "--given",
        metavar="KEY=VALUE",
    ),
]
