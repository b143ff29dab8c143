"""Lengths over time in a case file: a table, a recorded series, or a sine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import AfterValidator, Discriminator, Tag, model_validator

from hydrosim.case.signals import Harmonic, Recorded, Table
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim.forces.signal import Signal


class LengthTable(SchemaModel):
    """Straight lines between the lengths at some times, constant outside."""

    time: of.Times
    """Times that rise."""
    length: Annotated[tuple[of.LineLength, ...], AfterValidator(of.require_entries)]
    """Length at each time, with straight lines between."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        if len(self.time) != len(self.length):
            found_text = f"{len(self.time)} times and {len(self.length)} lengths"
            raise problem(found_text, "a length for each time")
        return self


def _form(value: object) -> str:
    """Which of the forms a length has."""
    if isinstance(value, LengthTable) or (isinstance(value, dict) and "time" in value):
        return "table"
    if isinstance(value, Recorded) or (isinstance(value, dict) and "file" in value):
        return "recorded"
    return "harmonic" if isinstance(value, dict | Harmonic) else "length"


LengthOverTime = Annotated[
    Annotated[of.LineLength, Tag("length")]
    | Annotated[LengthTable, Tag("table")]
    | Annotated[Recorded, Tag("recorded")]
    | Annotated[Harmonic[of.Length], Tag("harmonic")],
    Discriminator(_form),
]


def length_signal(
    form: LengthTable | Recorded | Harmonic[float], key: str, path: Path
) -> tuple[Signal, float]:
    """The signal of a length [m], and its value at time 0. Raises as `records.signal_of` does, and
    a problem for a length that is not always above 0."""
    from hydrosim.case.records import signal_of
    from hydrosim.errors import InputError
    from hydrosim.forces.signal import first_value, smallest_value

    same: Table[float] | Recorded | Harmonic[float]
    if isinstance(form, LengthTable):
        same = Table[float].model_construct(time=form.time, force=form.length)
    else:
        same = form
    signal = signal_of(same, key, path, "m")
    shortest = smallest_value(signal)
    if not shortest > 0.0:
        raise InputError(
            f"{path}: {key}: found a length that falls to {shortest:g} m; expected one that is"
            " always above 0."
        )
    return signal, first_value(signal)
