"""Arguments and options that several commands share, and what they must be."""

from __future__ import annotations

import os
from collections.abc import Iterable
from enum import StrEnum
from math import inf, isfinite
from pathlib import Path
from typing import Annotated, TypeVar

import typer
from rich.console import Console

from hydrosim.errors import InputError
from hydrosim.outputs import Output

Choice = TypeVar("Choice", bound=StrEnum)
CaseFile = Annotated[Path, typer.Argument(metavar="CASE.yaml", help="The case file to read.")]
Settings = Annotated[
    list[str], typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the case.")
]
StudyFile = Annotated[Path, typer.Argument(metavar="STUDY.yaml", help="The study file to read.")]
Workers = Annotated[
    int | None,
    typer.Option(min=1, help="Make so many runs at a time; else as many as there are cores."),
]
From = Annotated[
    str,
    typer.Option("--from", metavar="TIME", help='Leave out what is before: "10 min", or seconds.'),
]
To = Annotated[
    str,
    typer.Option("--to", metavar="TIME", help='Leave out what is after: "1 hour", or seconds.'),
]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="Print the details, too.")]
Overwrite = Annotated[
    bool,
    typer.Option(
        "--overwrite",
        help="Replace files, too, that are not earlier results of the same; keep none of these.",
    ),
]


def placed(
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
    """Where ``what`` is made of ``origin`` goes: to the path that is ``given``, or else to the
    ``default`` one, from this folder on, or another if that is read. Raises InputError before
    anything is computed if it cannot go there. ``settings`` are what it is made with."""
    path = given or Path(f"{default}{suffix}")
    made = Output(path, what, origin, (origin, *inputs), overwrite, settings=settings)
    if given is None and made.reads_itself():
        made = made.at(path.with_stem(f"{path.stem}_{what}"))
        said = f"{path} is read here: the result goes to {made.path}"
        Console(stderr=True).print(said, markup=False, highlight=False, soft_wrap=True)
    if os.path.isdir(path):  # Path.is_dir raises where a name is too long
        example = path / f"{what}{suffix or '.txt'}"
        raise InputError(f"--output: {path} is a directory; expected a file, such as {example}.")
    if path.suffix in (".yaml", ".yml"):
        raise InputError(
            f"--output: {path} has the name of a case file; expected that of a result."
        )
    if suffix and path.suffix != suffix:
        raise InputError(f"--output: found {path}; expected a name that ends in {suffix}.")
    return made.checked()


def numbers(text: str, option: str, positive: bool = True) -> list[float]:
    """Numbers separated by commas."""
    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        found = [float("nan")]
    if not all(isfinite(x) and (x > 0.0 or not positive) for x in found):
        kind = "positive numbers" if positive else "numbers"
        raise InputError(f"{option}: found {text!r}; expected {kind}, as in 0.1,0.05.")
    return found


def quantity(option: str, text: str | None, what: str, unit: str, example: str) -> float:
    """A number with its unit, in SI, as a case file has it."""
    from pydantic_core import PydanticCustomError

    from hydrosim.documents.units import Quantity

    try:
        return Quantity(what, unit, example).read(text)
    except PydanticCustomError as error:
        raise InputError(f"{option}: {error.message()}.") from None


def seconds(option: str, text: str, otherwise: float) -> float:
    """A time [s] with its unit, or of a plain number in s; ``otherwise`` if nothing is given."""
    return quantity(option, text, "time", "s", "10 min") if text else otherwise


def refuse_options(context: typer.Context, used: Iterable[str], why: str) -> None:
    """Raises InputError if an option of the command is given that is not among those ``used``, by
    the names of its parameters; ``why`` ends the message."""
    given = [
        max(option.opts, key=len)
        for option in context.command.params
        if option.param_type_name == "option"
        and option.name not in used
        and getattr(context.get_parameter_source(str(option.name)), "name", "") == "COMMANDLINE"
    ]
    if given:
        raise InputError(
            f"{', '.join(given)}: found {why}; expected none of these options with it."
        )


def names_in(text: str) -> list[str]:
    """Names or patterns separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def window_of(start: str, end: str) -> tuple[float, float]:
    """The time [s] from `From` to `To`, each of which may be left out; InputError where it ends
    before it begins."""
    begin = seconds("--from", start, -inf)
    close = seconds("--to", end, inf)
    if begin > close:
        raise InputError(f"--to: found {close:g} s; expected a time after --from, {begin:g} s.")
    return begin, close


def one_of(kind: type[Choice], name: str, option: str) -> Choice:
    """The value that a ``name`` is of a ``kind``."""
    if name.strip() in set(kind):
        return kind(name.strip())
    raise InputError(f"{option}: found {name!r}; expected one of {', '.join(kind)}.")
