"""The base of all force elements, conditions for their action, and properties of chain."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import (
    BaseModel,
    Discriminator,
    Field,
    StrictStr,
    Tag,
    ValidationError,
    model_validator,
)

from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import at_least_one, exactly_one
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ReadAs, SchemaClass, input_error, schema_class
from hydrosim.files.units import AnyQuantity, Scale, factor, problem
from hydrosim.scene.signal import RecordedColumns

# Conditions for the start and the end of an action.


@schema_class
class LevelReached(SchemaClass):
    """When the level of a tank is above or below a height."""

    key_rules = (exactly_one("above", "below", nothing="neither", expected="one of above, below"),)

    tank: StrictStr
    """Name of a tank of the body. Example: fore_sb."""
    above: of.Level | None = None
    """The event happens when the level is above this."""
    below: of.Level | None = None
    """The event happens when the level is below this."""

    @property
    def level(self) -> float:
        """The height [m]."""
        return (self.below if self.above is None else self.above) or 0.0


@dataclass(frozen=True)
class When:
    """A ``time`` [s], or the moment when a ``channel`` has been ``above`` or ``below`` a value for
    ``lasting`` [s]. `hydrosim.elements.channel` lists the names of channels. Values are in SI, or
    texts with a unit; `InputError` for one that no case file may have. ``unit`` is that of the
    text, None without one or if the channel has one unit alone."""

    time: float = 0.0
    channel: str | None = None
    above: float | None = None
    below: float | None = None
    lasting: float = 0.0
    unit: str | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        keys = {f.name: x for f in fields(self) if (x := getattr(self, f.name)) != f.default}
        keys = keys or {"time": self.time}
        form: type[AtTime | Event] = Event if keys.keys() - {"time"} else AtTime
        readers: dict[int | str, Any] = {}
        try:
            values = form.model_validate(keys, context=readers).values()
        except ValidationError as error:
            raise input_error(error, "When", keys, readers) from None
        vars(self).update(values)

    def build(self) -> When:
        """The condition itself."""
        return self


CHANNEL_UNITS: dict[str, tuple[str, ...]] = {
    "fender_normal_force": ("N",),
    "spring_tension": ("N",),
    "line_tension": ("N",),
    "compensator_tension": ("N",),
    "fender_compression": ("m",),
    "strut_force": ("N",),
    "strut_length": ("m",),
    "winch_tension": ("N",),
    "winch_length": ("m",),
    "torsion_angle": ("rad",),
    "clearance": ("m",),
}
"""Of channels; those of motions are in m or rad, with their speeds per second."""
for _kind in ("spring_damper", "gas_spring", "stop", "dry_friction"):
    CHANNEL_UNITS |= {f"{_kind}_load": ("N", "N*m"), f"{_kind}_place": ("m", "rad")}
OTHER_CHANNELS = ("position", "velocity", "speed", "relative_speed", "tank_level")


class Event(SchemaModel):
    """That a channel of the run has been above or below a value for so long."""

    key_rules = (exactly_one("above", "below", nothing="no value"),)

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
        kinds = (*OTHER_CHANNELS, *CHANNEL_UNITS)
        if self.channel.partition(".")[0] not in kinds:
            expected = f"one that begins with {', '.join(kinds)}"
            raise problem(f"the channel {self.channel}", expected, "as in speed.barge")
        value = self.above or self.below
        if value is not None and value.unit is not None:
            self._check_unit(value.text, value.unit)
        return self

    def _check_unit(self, text: str, unit: str) -> None:
        """Raises a problem if a value in a ``unit`` is none of the channel."""
        reasons = []
        for expected in self._units:
            try:
                factor(unit, expected)
            except ValueError as error:
                reasons.append(str(error))
        if len(reasons) == len(self._units):
            expected = f"a value in {' or '.join(self._units)}, which {self.channel} has"
            raise problem(text, expected, reasons[0])

    @property
    def _units(self) -> tuple[str, ...]:
        """The unit of the channel; two if it may be along a line or about an axis."""
        name, _, rest = self.channel.partition(".")
        turns = rest.rpartition(".")[2] in DOFS[3:]
        speed = "/s" if name in ("velocity", "speed", "relative_speed") else ""
        return CHANNEL_UNITS.get(name, (f"{'rad' if turns else 'm'}{speed}",))

    def values(self) -> dict[str, Any]:
        """The fields of its condition, in SI."""
        above, below = (None if x is None else x.value for x in (self.above, self.below))
        given = self.above or self.below
        unit = given.unit if given and len(self._units) > 1 else None
        return {"above": above, "below": below, "lasting": self.lasting, "unit": unit}

    def build(self) -> When:
        """The condition of the scene."""
        sides = {"above": self.above, "below": self.below}
        given: dict[str, Any] = {k: x and (x.text or x.value) for k, x in sides.items()}
        return When(channel=self.channel, lasting=self.lasting, **given)


class AtTime(SchemaModel):
    """A time since the start of the run."""

    time: of.Instant
    """Time since the start of the run. Example: 200 s."""

    def values(self) -> dict[str, Any]:
        """The fields of its condition, in SI."""
        return {"time": self.time}

    def build(self) -> When:
        """The condition of the scene."""
        return When(self.time)


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


@schema_class
class Active(SchemaClass):
    """The time in which an element acts; each end is a time or an event. Neither occurs twice."""

    key_rules = (
        at_least_one("start", "until", nothing="an empty mapping", expected="from, until, or both"),
    )

    start: Annotated[When | None, ReadAs(Moment | None, When), Field(alias="from")] = None
    """Time or event from which the element acts."""
    until: Annotated[When | None, ReadAs(Moment | None, When)] = None
    """Time or event until which the element acts."""

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        begin, end = (_moment_time(moment) for moment in (self.start, self.until))
        if begin is not None and end is not None and begin >= end:
            raise problem(f"from {begin:g} s until {end:g} s", "an end after the start")
        return self

    @property
    def is_built(self) -> bool:
        """True if both ends are conditions."""
        return all(end is None or isinstance(end, When) for end in (self.start, self.until))

    def build(self) -> Active:
        """The same with conditions for both ends."""
        return Active(build_condition(self.start), build_condition(self.until))


def _moment_time(moment: Any) -> float | None:
    """The time of a moment, None if it is none or waits for a channel."""
    if isinstance(moment, When):
        return None if moment.channel else moment.time
    if moment is None or isinstance(moment, Event):
        return None
    return moment.time if isinstance(moment, AtTime) else float(moment)


def build_condition(moment: Any) -> When | None:
    """The condition that a moment of a file is."""
    return When(float(moment)) if isinstance(moment, float) else moment and moment.build()


@dataclass(frozen=True)
class BuildContext:
    """Where something is: its ``key`` in the case file ``path``; density [kg/m^3] and gravity
    [m/s^2] of its ``water``; the ``joints`` of the case."""

    key: str
    path: Path
    water: tuple[float, float] = (1025.0, 9.81)
    joints: Mapping[str, Any] = field(default_factory=dict)


@schema_class
class ForceElement(SchemaClass):
    """Base of the elements in `hydrosim.elements`. In examples there are a "barge" and a "topside".

    The work of an element that ``supplies`` is booked as work, otherwise as dissipation. Each
    element declares its properties in its own file. An undeclared property only costs speed.
    """

    supplies: ClassVar[bool] = False
    stream: ClassVar[str | None] = None
    """The stream of the environment, if it is one that loads the element."""
    type: str = field(default="", kw_only=True)
    """Kind of force element."""
    body: StrictStr
    """Name of the body that the element acts on. Example: barge."""
    active: Active | None = field(default=None, kw_only=True)
    """Time in which the element acts: from, until, or both."""
    when: Annotated[When | None, ReadAs(Moment | None, When)] = field(default=None, kw_only=True)
    """Time or event from which the element acts, short for active with from."""

    @model_validator(mode="after")
    def _check_active(self) -> Self:
        if self.active and self.when is not None:
            expected = "one of them: when is short for active: {from: ...}"
            raise problem("active and when", expected)
        return self

    def build_active(self, where: BuildContext) -> ForceElement:
        """The element with all that a file leaves open: the time in which it acts, its share of
        totals, the contents of files beside the case file."""
        active = self.active and self.active.build()
        if self.when is not None:
            active = Active(build_condition(self.when))
        return replace(self, active=active, when=None).with_built_parts(where)

    def is_written(self) -> bool:
        """True if a part still has the form of a file, which `build_active` makes the scene's."""
        parts = [getattr(self, field.name) for field in fields(self)]
        return (
            self.when is not None
            or not (self.active is None or self.active.is_built)
            or any(
                isinstance(x, BaseModel | RecordedColumns) or getattr(x, "total", False)
                for x in parts
            )
        )

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        """Keys to the names of the other bodies that it acts on, these, and what leaving one out
        means."""
        yield from ()

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        """Recorded series that it needs, with the keys to them."""
        yield from ()

    def check(self, name: str) -> None:
        """Raises InputError for values that no case file allows, but a scene written in Python may
        have."""

    def can_carry_weight(self) -> bool:
        """True if it can carry weight."""
        return True

    def restored_dofs(self) -> Collection[str]:
        """Degrees of freedom among surge, sway and yaw in which it restores its body towards a
        position on earth."""
        return ()

    def dragging_streams(self) -> Collection[str]:
        """The streams, current or wind, that drag its body along through it."""
        return ()

    def can_add_energy(self) -> bool:
        """True if it can give energy to the bodies, though it is booked as dissipation."""
        return False

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        """Keys and names of the other bodies that it acts on."""
        yield from ()

    def signals(self) -> Iterator[tuple[str, Any]]:
        """Keys and signals over time of its prescribed changes."""
        yield from ()

    def jumps(self) -> Iterator[tuple[str, float]]:
        """Keys of its signals at whose corners its force jumps, with the largest jump [N]."""
        yield from ()

    def unit_names(self, name: str) -> Sequence[str]:
        """Names of its parts with states or modes, for an element called ``name``."""
        return ()

    def couplings(self) -> Iterator[np.ndarray]:
        """Its matrices (6, 6) of stiffness or damping, whose entries off the diagonal couple
        the coordinates of its body."""
        yield from ()

    def mirrored_parts(self, y: float) -> Sequence[ForceElement]:
        """Parts that must each have a mirror image in the plane at ``y`` [m], with coordinates
        relative to that plane. Empty if it acts by its `couplings` alone."""
        return (self,)

    def mirror_image(self) -> ForceElement | None:
        """The mirror image of a part in the plane y = 0; None if unknown."""
        return None

    def asymmetry(self) -> str | None:
        """Any other reason, in words, why it is not its own mirror image."""
        return None

    def nonlinearity(self, name: str, turns: Turns) -> str | None:
        """Reason why its force is not linear in the motions of its body; None if it is."""
        return name


# `breaks_at`: the tension or the time at which a line parts.


class Break(SchemaModel):
    """The tension or the time at which a line parts."""

    key_rules = (exactly_one("tension", "time", nothing="an empty mapping"),)

    tension: of.ReferenceForce | None = None
    """Tension at which the line parts."""
    time: of.Instant | None = None
    """Time at which the line parts."""

    @model_validator(mode="after")
    def _check_time(self) -> Self:
        if self.time is not None and self.time < 0.0:
            raise problem(f"time {self.time:g} s", "a time of the run, 0 s or later")
        return self


def _break_form(value: object) -> str:
    return "mapping" if isinstance(value, dict | Break) else "tension"


BreaksAt = Annotated[
    Annotated[of.ReferenceForce, Tag("tension")] | Annotated[Break, Tag("mapping")],
    Discriminator(_break_form),
]


@schema_class
class BreakingElement(ForceElement):
    """A line that may part: the end of its action, located as an event."""

    tension_channel: ClassVar[str] = ""
    """Channel with the tension of the line."""
    breaks_at: BreaksAt | None = field(default=None, kw_only=True)
    """Tension at which the line parts, or a mapping with tension or time. Energy that it held is
    lost. Example: 8 MN."""

    @model_validator(mode="after")
    def _check_end(self) -> Self:
        if self.breaks_at is not None and self.active and self.active.until is not None:
            expected = "one of them: both end the action of the line"
            raise problem("breaks_at and active.until", expected)
        return self

    def build_active(self, where: BuildContext) -> ForceElement:
        built = super(BreakingElement, replace(self, breaks_at=None)).build_active(where)
        if self.breaks_at is None:
            return built
        limit = self.breaks_at
        parted = limit if isinstance(limit, Break) else Break(tension=limit)
        channel = f"{self.tension_channel}.{where.key.removeprefix('forces.')}"
        if parted.time is None:
            until = When(channel=channel, above=parted.tension)
        else:
            until = When(parted.time)
        active = replace(built.active, until=until) if built.active else Active(until=until)
        return replace(built, active=active)

    def is_written(self) -> bool:
        return self.breaks_at is not None or super().is_written()


@dataclass(frozen=True)
class Turns:
    """Rotations of a body: the ``free`` ones of its coordinates 3, 4, 5, with ``exact`` rotations
    or small angles. ``elements`` are all compiled elements, ``row`` is the row of the element in
    question."""

    free: Sequence[int]
    exact: bool
    elements: Any
    row: int


# Chain by its bar diameter d (Orcina, OrcaFlex manual, "Chain: mechanical properties"), and the
# breaking load of offshore grades (IACS UR W22),
#
#     C d^2 (44 - 0.08 d) kN,   d in mm,   C = 0.0223 (R3), 0.0249 (R3S), 0.0274 (R4), 0.0320 (R5).

STEEL = 7850.0  # kg/m^3
CHAIN = {"studless": (19.9e3, 85.4e9), "studlink": (21.9e3, 101.0e9)}
"""Mass per length over squared diameter [kg/m^3] and axial stiffness over squared diameter
[N/m^2]."""
STRONGEST = 0.0320  # C of grade R5
MAX_CURVE_POINTS = 32  # of a curve of tension over stretch


def strongest_breaking_load(diameter: float) -> float:
    """Breaking load [N] of chain of grade R5 with this bar ``diameter`` [m]."""
    d = 1e3 * diameter
    return 1e3 * STRONGEST * d**2 * (44.0 - 0.08 * d)
