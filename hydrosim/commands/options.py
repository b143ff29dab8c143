"""Arguments and options that several commands share, and what they must be."""

from __future__ import annotations

import os
from enum import StrEnum
from math import isfinite
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from hydrosim.errors import InputError

Choice = TypeVar("Choice", bound=StrEnum)
CaseFile = Annotated[Path, typer.Argument(metavar="CASE.yaml", help="Case file.")]
Settings = Annotated[
    list[str], typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the case.")
]


def result_path(output: Path | None, case_file: Path) -> Path:
    """Where the result goes; raises InputError before anything is computed if it cannot."""
    path = Path(f"{case_file.stem}.nc") if output is None else output
    if path.is_dir():
        raise InputError(f"--output: {path} is a directory; expected a file such as {path}/run.nc.")
    if path.suffix in (".yaml", ".yml"):
        name = f"expected netCDF, such as {case_file.stem}.nc"
        raise InputError(f"--output: {path} has the name of a case file; {name}.")
    if not path.parent.is_dir():
        raise InputError(f"--output: there is no folder {path.parent}; make it first.")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"--output: the folder {path.parent} cannot be written to.")
    return path


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


def one_of(kind: type[Choice], name: str, option: str) -> Choice:
    """The value that a ``name`` is of a ``kind``."""
    if name.strip() in set(kind):
        return kind(name.strip())
    raise InputError(f"{option}: found {name!r}; expected one of {', '.join(kind)}.")
