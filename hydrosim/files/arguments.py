"""Arguments of commands and of functions of Python: numbers with units, names, times, outputs.

A function raises InputError that begins with the name of the argument, as "offset: found". The
command line turns that name into the option, "--offset", and so it does with names in `backticks`.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from enum import StrEnum
from math import inf, isfinite
from pathlib import Path
from typing import Any, TypeVar

from pydantic_core import PydanticCustomError

from hydrosim.errors import InputError
from hydrosim.files.outputs import Output
from hydrosim.files.units import Quantity

Choice = TypeVar("Choice", bound=StrEnum)
Amount = str | float
"""A number in SI, or a text with a unit such as "10 min"."""
Target = str | os.PathLike[str] | bool | None
"""File to write; True for the name that the command gives it, None to write none."""
Names = str | Sequence[str]
"""Names or patterns: a list, or a text with commas between them."""


def require_file(path: Path, expected: str) -> None:
    """Raises InputError if there is nothing at ``path``. It comes before messages about results,
    which have their names from the input."""
    if not os.path.exists(path):
        raise InputError(f"{path}: there is no such file; expected {expected}.")


def output_for(
    target: Target,
    default: str,
    what: str,
    origin: Path,
    *,
    inputs: Iterable[Path] = (),
    overwrite: bool = False,
    suffix: str | None = ".nc",
    settings: str = "",
) -> Output | None:
    """Output for a result ``what`` ("run") that is made of the file ``origin``; None if none is
    asked for. Its path is the ``target``, or else ``default`` in the current folder, or a free name
    if the program reads that file. Raises InputError before any computation if the path cannot be
    written. ``settings`` are the settings of the result."""
    if target is None or target is False:
        return None
    path = Path(f"{default}{suffix}") if target is True else Path(target)
    output = Output(path, what, origin, (origin, *inputs), overwrite, "output", settings)
    if target is True and output.is_own_input():
        output = output.output_at(path.with_stem(f"{path.stem}_{what}"))
        warnings.warn(f"{path} is an input here; the result goes to {output.path}", stacklevel=2)
    if os.path.isdir(path):  # Path.is_dir raises where a name is too long
        example = path / f"{what}{suffix or '.txt'}"
        raise InputError(f"output: {path} is a directory; expected a file, such as {example}.")
    if path.suffix in (".yaml", ".yml"):
        raise InputError(
            f"output: {path} has the name of a case file; expected the name of a result."
        )
    if suffix and path.suffix != suffix:
        raise InputError(f"output: found {path}; expected a name that ends in {suffix}.")
    return output.checked_output()


def picture_beside(output: Output | None) -> Output | None:
    """Output for the picture of a result, beside it."""
    if output is None:
        return None
    return output.output_at(output.path.with_suffix(".png"), "picture").checked_output()


def lock_of(output: Output | None) -> AbstractContextManager[None]:
    """The lock of an output, if there is one."""
    return nullcontext() if output is None else output.hold_lock()


def numbers(values: Amount | Sequence[float], name: str, positive: bool = True) -> list[float]:
    """Numbers of an argument: a list, a number, or a text with commas."""
    parts = values.split(",") if isinstance(values, str) else values
    try:
        numbers_given = [float(x) for x in (parts if isinstance(parts, Sequence) else [parts])]
    except (ValueError, TypeError):
        numbers_given = [float("nan")]
    if not all(isfinite(x) and (x > 0.0 or not positive) for x in numbers_given):
        kind = "positive numbers" if positive else "numbers"
        raise InputError(f"{name}: found {values!r}; expected {kind}, such as 0.1,0.05.")
    return numbers_given


def quantity(name: str, value: Amount, what: str, unit: str, example: str, **bounds: Any) -> float:
    """Value in SI of a number with a unit, written as in a case file, within the ``bounds`` of a
    `Quantity`."""
    try:
        return Quantity(what, unit, example, **bounds).read(value)
    except PydanticCustomError as error:
        raise InputError(f"{name}: {error.message()}.") from None


def seconds(name: str, value: Amount | None, otherwise: float = 0.0) -> float:
    """Time [s] of a number with a unit, or of a plain number in s; ``otherwise`` without one."""
    if value is None or value == "":
        return otherwise
    return quantity(name, value, "time", "s", "10 min")


def names_in(names: Names | None) -> list[str]:
    """Names or patterns of a list, or of a text with commas between them."""
    parts = names.split(",") if isinstance(names, str) else names or ()
    return [name.strip() for name in parts if name.strip()]


def window_of(start: Amount | None, end: Amount | None) -> tuple[float, float]:
    """Start and end [s] of a time window, each of which may be left out. Raises InputError if the
    end is not after the start."""
    begin = seconds("start", start, -inf)
    close = seconds("end", end, inf)
    if begin > close:
        raise InputError(
            f"end: found {close:g} s; expected a time after `start`, which is {begin:g} s."
        )
    return begin, close


def one_of(kind: type[Choice], value: str, name: str) -> Choice:
    """Member of the enumeration ``kind`` with this ``value``."""
    if value.strip() in set(kind):
        return kind(value.strip())
    raise InputError(f"{name}: found {value!r}; expected one of {', '.join(kind)}.")
