"""What is done to a database on its way to another file: options, as the keys of a case."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from hydrosim.errors import InputError

if TYPE_CHECKING:
    from hydrosim.scene import Changes

T = TypeVar("T")


def changes_of(
    accept: str | None,
    frequencies: str | None,
    without: str | None,
    symmetrise: bool,
    bodies_apart: bool,
) -> Changes:
    """The changes that texts of the command line ask for; raises `InputError` that names one."""
    from hydrosim.documents.quantities import FREQUENCY_OR_ZERO
    from hydrosim.scene import Changes, Without

    range_ = _items("--frequencies", frequencies, FREQUENCY_OR_ZERO.read)
    if range_ and (len(range_) != 2 or not range_[0] < range_[1]):
        raise InputError(
            f'--frequencies: found "{frequencies}"; expected the lowest and the highest, such as'
            ' "0, 3 rad/s".'
        )
    return Changes(
        accept=_items("--accept", accept, str),
        frequencies=(range_[0], range_[1]) if range_ else None,
        symmetrise=symmetrise,
        without=_items("--without", without, Without),
        bodies_apart=bodies_apart,
    )


def _items(option: str, text: str | None, read: Callable[[str], T]) -> tuple[T, ...]:
    """What stands between commas."""
    from pydantic_core import PydanticCustomError

    parts = [part.strip() for part in (text or "").split(",") if part.strip()]
    try:
        return tuple(read(part) for part in parts)
    except PydanticCustomError as error:
        raise InputError(f"{option}: {error.message()}.") from None
    except ValueError:
        raise InputError(f'{option}: found "{text}"; expected drift, qtf or loads.') from None
