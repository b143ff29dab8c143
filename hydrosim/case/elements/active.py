"""`active` of force elements in a case file: from when and until when they act."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Discriminator, Field, StrictStr, Tag, model_validator

from hydrosim import scene
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import AnyQuantity, Scale, factor, problem
from hydrosim.dofs import DOFS

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
        begin, end = (_time(moment) for moment in (self.start, self.until))
        if begin is not None and end is not None and begin >= end:
            raise problem(f"from {begin:g} s until {end:g} s", "an end after the start")
        return self

    def build(self) -> scene.Active:
        """The same of the scene."""
        return scene.Active(*map(build_condition, (self.start, self.until)))


def _time(moment: Any) -> float | None:
    """The time of a moment, None if it is none or waits for a channel."""
    if moment is None or isinstance(moment, Event):
        return None
    return moment.time if isinstance(moment, AtTime) else float(moment)


def build_condition(moment: Any) -> scene.When | None:
    time = _time(moment)
    if time is not None:
        return scene.When(time)
    return None if moment is None else moment.build()
