"""What a file does not hold: options of commands, in the units that people write."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from pydantic_core import PydanticCustomError

from hydrosim.case.units import Quantity
from hydrosim.database.database import HydroDatabase
from hydrosim.database.given import FrequencyColumn, Given
from hydrosim.errors import InputError


class _Numbers(NamedTuple):
    """An option of one number, or of so many for each body, separated by commas."""

    option: str
    help: str
    quantity: Quantity
    of_body: int = 0


_PLACE = Quantity("coordinate", "m", "-4.9 m")
_NUMBERS = {
    "length": _Numbers(
        "--length", "That a program divided by.", Quantity("length", "m", "1 m", above=0)
    ),
    "water_density": _Numbers(
        "--density", "Of the water.", Quantity("density", "kg/m^3", "1.025 tonne/m^3", above=0)
    ),
    "gravity": _Numbers(
        "--gravity", "Acceleration.", Quantity("acceleration", "m/s^2", "9.81 m/s^2", above=0)
    ),
    "water_depth": _Numbers(
        "--depth",
        'Of the water, or "infinite".',
        Quantity("depth", "m", "100 m", above=0, infinite=True),
    ),
    "volume": _Numbers(
        "--volume", "Displaced.", Quantity("volume", "m^3", "1000 m^3", above=0), of_body=1
    ),
    "centre_of_buoyancy": _Numbers("--centre-of-buoyancy", "x, y, z.", _PLACE, of_body=3),
    "centre_of_gravity": _Numbers("--centre-of-gravity", "x, y, z.", _PLACE, of_body=3),
    "reference_point": _Numbers("--reference-point", "x, y, z.", _PLACE, of_body=3),
}
_OTHERS = {
    "frequency_column": Annotated[
        FrequencyColumn | None, typer.Option(help="What stands for the frequency in tables.")
    ],
    "port_starboard_symmetric": Annotated[
        bool | None, typer.Option("--symmetric/--not-symmetric", help="Each body, in y = 0.")
    ],
}


def with_given(command: Callable[..., None]) -> Callable[..., None]:
    """The command with an option for each item of `Given`, all together in its last parameter,
    ``given``. Raises `InputError` that names the option."""

    @wraps(command)
    def with_options(**arguments: Any) -> None:
        values = {name: arguments.pop(name) for name in options}
        command(**arguments, given=_given(values))

    options = {
        **{
            name: Annotated[str | None, typer.Option(row.option, help=row.help)]
            for name, row in _NUMBERS.items()
        },
        **_OTHERS,
    }
    own = list(signature(command, eval_str=True).parameters.values())[:-1]
    added = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=option)
        for name, option in options.items()
    ]
    parameters = [*own, *added]
    with_options.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    with_options.__annotations__ = {p.name: p.annotation for p in parameters}
    return with_options


def overruled(db: HydroDatabase, given: Given) -> list[str]:
    """Names of what is ``given`` although the file says something else, which counts."""
    return [
        name
        for name in _NUMBERS
        if getattr(given, name) is not None
        and hasattr(db, name)
        and not np.array_equal(np.ravel(getattr(db, name)), np.ravel(getattr(given, name)))
    ]


def _given(values: dict[str, Any]) -> Given:
    read: dict[str, Any] = {
        name: _value(_NUMBERS[name], value) if name in _NUMBERS else value
        for name, value in values.items()
        if value is not None
    }
    return Given(**read)


def _value(row: _Numbers, text: str) -> float | tuple[float, ...]:
    if row.of_body == 0:
        return _number(row, text)
    parts = text.split(",")
    if len(parts) % row.of_body:
        raise InputError(
            f'{row.option}: found {len(parts)} numbers in "{text}"; expected'
            f' {row.of_body} for each body, such as "0, 0, {row.quantity.example}".'
        )
    return tuple(_number(row, part) for part in parts)


def _number(row: _Numbers, text: str) -> float:
    try:
        return row.quantity.read(text)
    except PydanticCustomError as error:
        raise InputError(f"{row.option}: {error.message()}.") from None
