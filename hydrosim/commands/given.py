"""What a file does not hold: options of commands, in the units that people write."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.scene.given import FrequencyColumn, Given


class _Numbers(NamedTuple):
    """An option of one number, or of so many for each body, separated by commas: what it is, its
    SI unit and an example."""

    option: str
    help: str
    what: str
    unit: str
    example: str
    of_body: int = 0


_PLACE = ("Give x, y, z (m).", "coordinate", "m", "-4.9 m", 3)
_NUMBERS = {
    "length": _Numbers("--length", "Undo a division by this length (m).", "length", "m", "1 m"),
    "water_density": _Numbers(
        "--density",
        "Give the density of the water (kg/m^3).",
        "density",
        "kg/m^3",
        "1.025 tonne/m^3",
    ),
    "gravity": _Numbers(
        "--gravity",
        "Give the acceleration of gravity (m/s^2).",
        "acceleration",
        "m/s^2",
        "9.81 m/s^2",
    ),
    "water_depth": _Numbers(
        "--depth", 'Give the depth of the water (m), or "infinite".', "depth", "m", "100 m"
    ),
    "volume": _Numbers(
        "--volume", "Give the displaced volume (m^3).", "volume", "m^3", "1000 m^3", 1
    ),
    "centre_of_buoyancy": _Numbers("--centre-of-buoyancy", *_PLACE),
    "centre_of_gravity": _Numbers("--centre-of-gravity", *_PLACE),
    "reference_point": _Numbers("--reference-point", *_PLACE),
}
_OPTIONS: dict[str, Any] = {
    **{
        name: Annotated[str | None, typer.Option(row.option, help=row.help)]
        for name, row in _NUMBERS.items()
    },
    "frequency_column": Annotated[
        str | None, typer.Option(help="Say what tables have: period, frequency or a wavenumber.")
    ],
    "draught": Annotated[
        str | None, typer.Option(help="Take this one of several draughts in the file, by its name.")
    ],
    "port_starboard_symmetric": Annotated[
        bool | None,
        typer.Option(
            "--symmetric/--not-symmetric", help="Say whether each body is its own mirror image."
        ),
    ],
}


def with_given(command: Callable[..., None]) -> Callable[..., None]:
    """The command with an option for each item of `Given`, all together in its last parameter,
    ``given``. Raises `InputError` that names the option."""

    @wraps(command)
    def with_options(**arguments: Any) -> None:
        values = {name: arguments.pop(name) for name in _OPTIONS}
        command(**arguments, given=_given(values))

    known = signature(command, eval_str=True, locals={"Given": object}).parameters.values()
    own = [one for one in known if one.name != "given"]
    added = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=option)
        for name, option in _OPTIONS.items()
    ]
    with_options.__signature__ = Signature([*own, *added])  # type: ignore[attr-defined]
    with_options.__annotations__ = {one.name: one.annotation for one in (*own, *added)}
    return with_options


def _given(values: dict[str, Any]) -> Given:
    from hydrosim.scene.given import Given

    readers: dict[str, Callable[[Any], Any]] = {
        "frequency_column": _column,
        "draught": str,
        "port_starboard_symmetric": bool,
    }
    read: dict[str, Any] = {
        name: _numbers(_NUMBERS[name], value) if name in _NUMBERS else readers[name](value)
        for name, value in values.items()
        if value is not None
    }
    return Given(**read)


def _column(text: str) -> FrequencyColumn:
    from hydrosim.scene.given import FrequencyColumn

    if text not in set(FrequencyColumn):
        expected = ", ".join(FrequencyColumn)
        raise InputError(f'--frequency-column: found "{text}"; expected one of {expected}.')
    return FrequencyColumn(text)


def _numbers(row: _Numbers, text: str) -> float | tuple[float, ...]:
    if row.of_body == 0:
        return _number(row, text)
    parts = text.split(",")
    if len(parts) % row.of_body:
        raise InputError(
            f'{row.option}: found {len(parts)} numbers in "{text}"; expected'
            f' {row.of_body} for each body, such as "0, 0, {row.example}".'
        )
    return tuple(_number(row, part) for part in parts)


def _number(row: _Numbers, text: str) -> float:
    from pydantic_core import PydanticCustomError

    from hydrosim.documents.units import Quantity

    above = None if row.what == "coordinate" else 0.0
    infinite = row.what == "depth"
    quantity = Quantity(row.what, row.unit, row.example, above=above, infinite=infinite)
    try:
        return quantity.read(text)
    except PydanticCustomError as error:
        raise InputError(f"{row.option}: {error.message()}.") from None
