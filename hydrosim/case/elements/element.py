"""Keys that force elements of a case file share: `breaks_at`, lengths over time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import AfterValidator, ConfigDict, Discriminator, StrictStr, Tag, model_validator

from hydrosim.files import quantities as of
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import problem
from hydrosim.scene.force import Active, BuildContext, Moment, When, build_condition
from hydrosim.scene.signal import (
    HarmonicEntry,
    RecordedColumns,
    Signal,
    TableOverTime,
    signal_of,
    smallest_value,
)

if TYPE_CHECKING:
    from hydrosim.scene import ForceElement


def _add_example(schema: dict[str, Any], model: type[Exemplary]) -> None:
    schema["examples"] = [model.example]


class Exemplary(SchemaModel):
    """A mapping with an ``example``, which stands in its JSON schema and is built by a test."""

    model_config = ConfigDict(json_schema_extra=_add_example)
    example: ClassVar[dict[str, Any]] = {}


class Element(Exemplary):
    """A force element on a ``body``; in examples there are a "barge" and a "topside"."""

    stream: ClassVar[str | None] = None
    """The stream of the environment, if it is one that loads the element."""
    type: str
    """Kind of force element."""
    body: StrictStr
    """Name of the body that the element acts on. Example: barge."""
    active: Active | None = None
    """Time in which the element acts: from, until, or both."""
    when: Moment | None = None
    """Time or event from which the element acts, short for active with from."""

    @model_validator(mode="after")
    def _check_active(self) -> Self:
        if self.active and self.when is not None:
            expected = "one of them: when is short for active: {from: ...}"
            raise problem("active and when", expected)
        return self

    def build_active(self, where: BuildContext) -> ForceElement:
        """The element of the scene, with the time in which it acts."""
        begun = self.when is not None
        active = Active(build_condition(self.when)) if begun else self.active
        acts = self.breaking(where, active.build() if active else None)
        return replace(self.build(where), active=acts)

    def breaking(self, where: BuildContext, active: Active | None) -> Active | None:
        """The time in which it acts, if it may break: until then at the latest."""
        return active

    @abstractmethod
    def build(self, where: BuildContext) -> ForceElement:
        """The element of the scene; files are looked for beside the case file."""

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        """Keys to the names of the other bodies that it acts on, these, and what leaving one out
        means."""
        yield from ()

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        """Recorded series that it needs, with the keys to them."""
        yield from ()


# `breaks_at`: the tension or the time at which a line parts.


class Break(SchemaModel):
    """The tension or the time at which a line parts."""

    tension: of.ReferenceForce | None = None
    """Tension at which the line parts."""
    time: of.Instant | None = None
    """Time at which the line parts."""

    @model_validator(mode="after")
    def _check_one(self) -> Self:
        given = self.keys_with_value("tension", "time")
        if len(given) != 1:
            raise problem(" and ".join(given) or "an empty mapping", "either tension or time")
        return self


def _break_form(value: object) -> str:
    return "mapping" if isinstance(value, dict | Break) else "tension"


BreaksAt = Annotated[
    Annotated[of.ReferenceForce, Tag("tension")] | Annotated[Break, Tag("mapping")],
    Discriminator(_break_form),
]


class Breaking(Element):
    """A line that may part: the end of its action, located as an event."""

    tension_channel: ClassVar[str]
    """Channel with the tension of the line."""
    breaks_at: BreaksAt | None = None
    """Tension at which the line parts, or a mapping with tension or time. Energy that it held is
    lost. Example: 8 MN."""

    @model_validator(mode="after")
    def _check_end(self) -> Self:
        if self.breaks_at is not None and self.active and self.active.until is not None:
            expected = "one of them: both end the action of the line"
            raise problem("breaks_at and active.until", expected)
        return self

    def breaking(self, where: BuildContext, active: Active | None) -> Active | None:
        if self.breaks_at is None:
            return active
        given = self.breaks_at
        time = given.time if isinstance(given, Break) else None
        tension = given.tension if isinstance(given, Break) else given
        channel = f"{self.tension_channel}.{where.key.removeprefix('forces.')}"
        parts = When(time) if time is not None else When(0.0, channel, above=tension)
        return replace(active, until=parts) if active else Active(until=parts)


# Lengths over time: a table, a recorded series, or a sine.


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


def _length_form(value: object) -> str:
    """Which of the forms a length has."""
    if isinstance(value, LengthTable) or (isinstance(value, dict) and "time" in value):
        return "table"
    if isinstance(value, RecordedColumns) or (isinstance(value, dict) and "file" in value):
        return "recorded"
    return "harmonic" if isinstance(value, dict | HarmonicEntry) else "length"


LengthOverTime = Annotated[
    Annotated[of.LineLength, Tag("length")]
    | Annotated[LengthTable, Tag("table")]
    | Annotated[RecordedColumns, Tag("recorded")]
    | Annotated[HarmonicEntry[of.Length], Tag("harmonic")],
    Discriminator(_length_form),
]


def length_signal(
    form: LengthTable | RecordedColumns | HarmonicEntry[float], key: str, path: Path
) -> tuple[Signal, float]:
    """The signal of a length [m], and its value at time 0. Raises as `signals.signal_of` does, and
    a problem for a length that is not always above 0."""
    from hydrosim.elements.signal import first_value  # loads numba
    from hydrosim.errors import InputError

    same: TableOverTime[float] | RecordedColumns | HarmonicEntry[float]
    if isinstance(form, LengthTable):
        same = TableOverTime[float].model_construct(time=form.time, force=form.length)
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
