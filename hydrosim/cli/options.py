"""Arguments and options that several commands share, and their validation."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Sequence
from enum import StrEnum
from functools import wraps
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer
from rich.console import Console

from hydrosim.errors import InputError
from hydrosim.files.outputs import Output

if TYPE_CHECKING:
    from hydrosim.scene import ChangedDatabase

Choice = TypeVar("Choice", bound=StrEnum)
CaseFile = Annotated[Path, typer.Argument(metavar="CASE.yaml", help="Case file to read.")]
Settings = Annotated[
    list[str],
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a value of the input file: solver.step=0.05. May be repeated.",
    ),
]
StudyFile = Annotated[Path, typer.Argument(metavar="STUDY.yaml", help="Study file to read.")]
Workers = Annotated[
    int | None,
    typer.Option(min=1, help="Number of simultaneous runs; default: the number of cores."),
]
From = Annotated[
    str,
    typer.Option(
        "--from",
        metavar="TIME",
        help='Ignore everything before this time: "10 min", or a number in seconds.',
    ),
]
To = Annotated[
    str,
    typer.Option(
        "--to",
        metavar="TIME",
        help='Ignore everything after this time: "1 hour", or a number in seconds.',
    ),
]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Also print the details.")]
Overwrite = Annotated[
    bool,
    typer.Option("--overwrite", help="Replace existing files of any kind; keep no earlier result."),
]


def require_file(path: Path, expected: str) -> None:
    """Raises InputError if there is nothing at ``path``. It comes before messages about results,
    which have their names from the input."""
    if not os.path.exists(path):
        raise InputError(f"{path}: there is no such file; expected {expected}.")


def output_for(
    given: Path | None,
    default: str,
    what: str,
    origin: Path,
    *,
    inputs: Iterable[Path] = (),
    overwrite: bool = False,
    suffix: str | None = ".nc",
    settings: str = "",
) -> Output:
    """Output for a result ``what`` ("run") that is made of the file ``origin``. Its path is
    ``given``, or else ``default`` in the current folder, or a free name if the program reads that
    file. Raises InputError before any computation if the path cannot be written. ``settings`` are
    the settings of the result."""
    path = given or Path(f"{default}{suffix}")
    made = Output(path, what, origin, (origin, *inputs), overwrite, settings=settings)
    if given is None and made.reads_itself():
        made = made.output_at(path.with_stem(f"{path.stem}_{what}"))
        text = f"{path} is an input here; the result goes to {made.path}"
        Console(stderr=True).print(text, markup=False, highlight=False, soft_wrap=True)
    if os.path.isdir(path):  # Path.is_dir raises where a name is too long
        example = path / f"{what}{suffix or '.txt'}"
        raise InputError(f"--output: {path} is a directory; expected a file, such as {example}.")
    if path.suffix in (".yaml", ".yml"):
        raise InputError(
            f"--output: {path} has the name of a case file; expected the name of a result."
        )
    if suffix and path.suffix != suffix:
        raise InputError(f"--output: found {path}; expected a name that ends in {suffix}.")
    return made.checked_output()


def numbers(text: str, option: str, positive: bool = True) -> list[float]:
    """Numbers of an option, separated by commas. Raises InputError that names the option."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = [float("nan")]
    if not all(isfinite(x) and (x > 0.0 or not positive) for x in values):
        kind = "positive numbers" if positive else "numbers"
        raise InputError(f"{option}: found {text!r}; expected {kind}, such as 0.1,0.05.")
    return values


def quantity(option: str, text: str | None, what: str, unit: str, example: str) -> float:
    """Value in SI of a number with a unit, written as in a case file."""
    from pydantic_core import PydanticCustomError

    from hydrosim.files.units import Quantity

    try:
        return Quantity(what, unit, example).read(text)
    except PydanticCustomError as error:
        raise InputError(f"{option}: {error.message()}.") from None


def seconds(option: str, text: str, otherwise: float) -> float:
    """Time [s] of a number with a unit, or of a plain number in s; ``otherwise`` without a text."""
    return quantity(option, text, "time", "s", "10 min") if text else otherwise


def refuse_options(context: typer.Context, used: Iterable[str], why: str) -> None:
    """Raises InputError if an option of the command is given that is not in ``used`` (names of
    parameters). ``why`` ends the message."""
    given = [
        max(option.opts, key=len)
        for option in context.command.params
        if option.param_type_name == "option"
        and option.name not in used
        and getattr(context.get_parameter_source(str(option.name)), "name", "") == "COMMANDLINE"
    ]
    if given:
        these = "this option" if len(given) == 1 else "these options"
        raise InputError(f"{', '.join(given)}: not possible with {why}. Leave {these} out.")


def names_in(text: str) -> list[str]:
    """Names or patterns, separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def window_of(start: str, end: str) -> tuple[float, float]:
    """Times [s] of `From` and `To`, each of which may be left out. Raises InputError if the end is
    not after the start."""
    begin = seconds("--from", start, -inf)
    close = seconds("--to", end, inf)
    if begin > close:
        raise InputError(
            f"--to: found {close:g} s; expected a time after --from, which is {begin:g} s."
        )
    return begin, close


def one_of(kind: type[Choice], name: str, option: str) -> Choice:
    """Member of the enumeration ``kind`` with this ``name``. Raises InputError that names the
    option."""
    if name.strip() in set(kind):
        return kind(name.strip())
    raise InputError(f"{option}: found {name!r}; expected one of {', '.join(kind)}.")


# `--given KEY=VALUE`: data that a database's file lacks, and changes of the database.

GivenSettings = Annotated[
    list[str],
    typer.Option(
        "--given",
        metavar="KEY=VALUE",
        help="Data that the file lacks, or a change of the database; KEY as under"
        ' `hydrodynamics` in a case: density="1.025 tonne/m^3", depth="30 m",'
        " symmetrise=true.",
    ),
]


def given_database(file: Path, given: Sequence[str]) -> ChangedDatabase:
    """Database in a ``file``, with the ``given`` texts KEY=VALUE, whose keys are those under
    `hydrodynamics` in a case. Raises InputError that names the option."""
    from hydrosim.case.hydrodynamics import DatabaseFile
    from hydrosim.files.layers import apply_setting
    from hydrosim.files.messages import validate_document
    from hydrosim.files.yaml_nodes import COMMAND_LINE_PREFIX, compose_nodes

    document = compose_nodes(json.dumps({"file": str(file)}), COMMAND_LINE_PREFIX)
    assert document is not None
    for setting in given:
        if setting.partition("=")[0].strip() == "file":
            raise InputError(
                f"{COMMAND_LINE_PREFIX}{setting}: found file; expected another key. The file is"
                " the argument."
            )
        document = apply_setting(document, setting, COMMAND_LINE_PREFIX)
    return validate_document(document, DatabaseFile).build(lambda _: file)


# Commands that show results, which are files that people pass on and change.

MISSING_VARIABLE = re.compile(
    r"No variable named '(\w+)'|'Dataset' object has no attribute '(\w+)'"
)
"""What xarray says of a variable that a dataset lacks."""


def tells_absent_variables(command: Callable[..., Any]) -> Callable[..., Any]:
    """A ``command`` that shows a result, and refuses one that lacks a variable it needs."""

    @wraps(command)
    def show(**given: Any) -> Any:
        try:
            return command(**given)
        except (KeyError, AttributeError) as error:
            absent = MISSING_VARIABLE.search(str(error))
            if absent is None:
                raise
            path = next(value for value in given.values() if isinstance(value, Path))
            from hydrosim.results.validation import CHANGED_FILE_HINT  # loads the models of cases

            problem_text = f"found no variable {absent[1] or absent[2]}, which this page needs"
            raise InputError(f"{path}: {problem_text}. {CHANGED_FILE_HINT}") from error

    return show
