"""Keys that force elements of a case file share: `active`, `breaks_at`, lengths over time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictStr,
    Tag,
    model_validator,
)

from hydrosim import scene
from hydrosim.case.signals import Harmonic, Recorded, Table, signal_of
from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import AnyQuantity, Scale, factor, problem

if TYPE_CHECKING:
    from hydrosim.elements.signal import Signal
    from hydrosim.scene import ForceElement

# `active`: from when and until when an element acts.

CHANNEL_UNITS = {
    "fender_normal_force": "N",
    "spring_tension": "N",
    "line_tension": "N",
    "fender_compression": "m",
    "strut_force": "N",
    "strut_length": "m",
    "winch_tension": "N",
    "winch_length": "m",
    "torsion_angle": "rad",
    "clearance": "m",
}
"""Of channels; those of motions are in m or rad, with their speeds per second."""
OTHERS = ("position", "velocity", "speed", "relative_speed", "tank_level")


class Event(SchemaModel):
    """That a channel of the run has been above or below a value for so long."""

    channel: StrictStr
    """Channel of the run that is watched. Example: speed.barge."""
    above: Annotated[Scale, AnyQuantity("value", "0.1 m/s")] | None = None
    """The event happens when the channel is above this value."""
    below: Annotated[Scale, AnyQuantity("value", "0.1 m/s")] | None = None
    """The event happens when the channel is below this value."""
    lasting: of.Span = 0.0
    """Time that the condition must last."""

    @model_validator(mode="after")
    def _check_value(self) -> Self:
        given = self.keys_with_value("above", "below")
        if len(given) != 1:
            raise problem(" and ".join(given) or "no value", "either above or below")
        kinds = (*OTHERS, *CHANNEL_UNITS)
        if self.channel.partition(".")[0] not in kinds:
            expected = f"one that begins with {', '.join(kinds)}"
            raise problem(f"the channel {self.channel}", expected, "as in speed.barge")
        unit, value = self._unit, self.above or self.below
        if value is not None and value.unit is not None:
            try:
                factor(value.unit, unit)
            except ValueError as error:
                expected = f"a value in {unit}, which {self.channel} has"
                raise problem(value.text, expected, str(error)) from None
        return self

    @property
    def _unit(self) -> str:
        """The unit of the channel."""
        name, _, rest = self.channel.partition(".")
        turns = rest.rpartition(".")[2] in DOFS[3:]
        speed = "/s" if name in ("velocity", "speed", "relative_speed") else ""
        return CHANNEL_UNITS.get(name, f"{'rad' if turns else 'm'}{speed}")

    def build(self) -> scene.When:
        """The condition of the scene."""
        above, below = (None if x is None else x.value for x in (self.above, self.below))
        return scene.When(0.0, self.channel, above, below, self.lasting)


class AtTime(SchemaModel):
    """A time since the start of the run."""

    time: of.Instant
    """Time since the start of the run. Example: 200 s."""

    def build(self) -> scene.When:
        """The condition of the scene."""
        return scene.When(self.time)


def form_of(value: object) -> str:
    """What a moment is given as: a time, a mapping with a time, or an event of a channel."""
    if isinstance(value, AtTime) or (isinstance(value, dict) and "time" in value):
        return "mapping"
    return "event" if isinstance(value, dict | Event) else "time"


Moment = Annotated[
    Annotated[of.Instant, Tag("time")]
    | Annotated[AtTime, Tag("mapping")]
    | Annotated[Event, Tag("event")],
    Discriminator(form_of),
]


class Active(SchemaModel):
    """The time in which an element acts; each end is a time or an event."""

    model_config = ConfigDict(populate_by_name=True)
    start: Moment | None = Field(default=None, alias="from")
    """Time or event from which the element acts."""
    until: Moment | None = None
    """Time or event until which the element acts."""

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if not self.keys_with_value("start", "until"):
            raise problem("an empty mapping", "from, until, or both")
        begin, end = (_moment_time(moment) for moment in (self.start, self.until))
        if begin is not None and end is not None and begin >= end:
            raise problem(f"from {begin:g} s until {end:g} s", "an end after the start")
        return self

    def build(self) -> scene.Active:
        """The same of the scene."""
        return scene.Active(*map(build_condition, (self.start, self.until)))


def _moment_time(moment: Any) -> float | None:
    """The time of a moment, None if it is none or waits for a channel."""
    if moment is None or isinstance(moment, Event):
        return None
    return moment.time if isinstance(moment, AtTime) else float(moment)


def build_condition(moment: Any) -> scene.When | None:
    time = _moment_time(moment)
    if time is not None:
        return scene.When(time)
    return None if moment is None else moment.build()


@dataclass(frozen=True)
class BuildContext:
    """Where something is: its ``key`` in the case file ``path``; density [kg/m^3] and gravity
    [m/s^2] of its ``water``; the ``joints`` of the case."""

    key: str
    path: Path
    water: tuple[float, float] = (1025.0, 9.81)
    joints: Mapping[str, scene.Joint] = field(default_factory=dict)


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
        active = Active.model_construct(start=self.when, until=None) if begun else self.active
        acts = self.breaking(where, active.build() if active else None)
        return replace(self.build(where), active=acts)

    def breaking(self, where: BuildContext, active: scene.Active | None) -> scene.Active | None:
        """The time in which it acts, if it may break: until then at the latest."""
        return active

    @abstractmethod
    def build(self, where: BuildContext) -> ForceElement:
        """The element of the scene; files are looked for beside the case file."""

    def with_fitted_numbers(self, where: BuildContext) -> Element:
        """The same without data in files that determine its numbers: these numbers instead."""
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        """Keys to the names of the other bodies that it acts on, these, and what leaving one out
        means."""
        yield from ()

    def recorded_series(self) -> Iterator[tuple[Keys, Recorded]]:
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

    def breaking(self, where: BuildContext, active: scene.Active | None) -> scene.Active | None:
        if self.breaks_at is None:
            return active
        given = self.breaks_at
        time = given.time if isinstance(given, Break) else None
        tension = given.tension if isinstance(given, Break) else given
        channel = f"{self.tension_channel}.{where.key.removeprefix('forces.')}"
        parts = scene.When(time) if time is not None else scene.When(0.0, channel, above=tension)
        return replace(active or scene.Active(), until=parts)


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
    if isinstance(value, Recorded) or (isinstance(value, dict) and "file" in value):
        return "recorded"
    return "harmonic" if isinstance(value, dict | Harmonic) else "length"


LengthOverTime = Annotated[
    Annotated[of.LineLength, Tag("length")]
    | Annotated[LengthTable, Tag("table")]
    | Annotated[Recorded, Tag("recorded")]
    | Annotated[Harmonic[of.Length], Tag("harmonic")],
    Discriminator(_length_form),
]


def length_signal(
    form: LengthTable | Recorded | Harmonic[float], key: str, path: Path
) -> tuple[Signal, float]:
    """The signal of a length [m], and its value at time 0. Raises as `signals.signal_of` does, and
    a problem for a length that is not always above 0."""
    from hydrosim.elements.signal import first_value, smallest_value
    from hydrosim.errors import InputError

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
