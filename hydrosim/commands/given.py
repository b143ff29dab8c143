"""What a file does not hold, from options in the units that people write."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from pydantic_core import PydanticCustomError

from hydrosim.case.units import Quantity
from hydrosim.database.database import HydroDatabase
from hydrosim.database.given import Given
from hydrosim.errors import InputError


class _Option(NamedTuple):
    """Its name and one of its numbers; ``of_body`` are how many each body has, 0 if it is of the
    water."""

    name: str
    quantity: Quantity
    of_body: int = 0


_PLACE = Quantity("coordinate", "m", "-4.9 m")
_OPTIONS = {
    "length": _Option("--length", Quantity("length", "m", "1 m", above=0)),
    "water_density": _Option(
        "--density", Quantity("density", "kg/m^3", "1.025 tonne/m^3", above=0)
    ),
    "gravity": _Option("--gravity", Quantity("acceleration", "m/s^2", "9.81 m/s^2", above=0)),
    "water_depth": _Option("--depth", Quantity("depth", "m", "100 m", above=0, infinite=True)),
    "volume": _Option("--volume", Quantity("volume", "m^3", "1000 m^3", above=0), 1),
    "centre_of_buoyancy": _Option("--centre-of-buoyancy", _PLACE, 3),
    "centre_of_gravity": _Option("--centre-of-gravity", _PLACE, 3),
    "reference_point": _Option("--reference-point", _PLACE, 3),
}


def given(**texts: str | None) -> Given:
    """`Given` from a text for each of its fields, several numbers separated by commas; raises
    `InputError` that names the option."""
    values: dict[str, Any] = {
        key: _value(_OPTIONS[key], text) for key, text in texts.items() if text is not None
    }
    return Given(**values)


def overruled(db: HydroDatabase, given: Given) -> list[str]:
    """Names of what is ``given`` although the file says something else, which counts."""
    return [
        name
        for name in _OPTIONS
        if getattr(given, name) is not None
        and hasattr(db, name)
        and not np.array_equal(np.ravel(getattr(db, name)), np.ravel(getattr(given, name)))
    ]


def _value(option: _Option, text: str) -> float | tuple[float, ...]:
    parts = text.split(",")
    if option.of_body == 0:
        return _number(option, text)
    if len(parts) % option.of_body:
        raise InputError(
            f'{option.name}: found {len(parts)} numbers in "{text}"; expected'
            f' {option.of_body} for each body, such as "0, 0, {option.quantity.example}".'
        )
    return tuple(_number(option, part) for part in parts)


def _number(option: _Option, text: str) -> float:
    try:
        return option.quantity.read(text)
    except PydanticCustomError as error:
        raise InputError(f"{option.name}: {error.message()}.") from None
