"""Winches of a scene, whose physics is in `hydrosim.elements.line.winch`: `winch` in a file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace
from math import inf
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, StrictStr, Tag, model_validator

from hydrosim.files import quantities as of
from hydrosim.files.key_rules import value_for_each_time
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ReadAs, SchemaClass, schema_class
from hydrosim.files.units import problem
from hydrosim.scene import signal
from hydrosim.scene.force import BreakingElement, BuildContext, ForceElement
from hydrosim.scene.links import TwoPointElement

MIN_WIRE_FRACTION = 0.01  # of the wire: a compensation without a stroke ends there
DRUM = "drum: {shortest: 10 m, longest: 200 m}"


@schema_class
class Drum(SchemaClass):
    """The ends of a drum, as lengths of wire off it without load."""

    shortest: of.LineLength
    """Length off the drum when it is full."""
    longest: of.LineLength
    """Length off the drum when it is empty."""

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        if self.longest <= self.shortest:
            found_text = f"shortest {self.shortest:g} m and longest {self.longest:g} m"
            raise problem(found_text, "a longest length above the shortest")
        return self


@schema_class
class DrumFriction(SchemaClass):
    """Friction of a drum, as parts of the set tension."""

    has_valid_defaults = True
    heave_in: Annotated[of.Factor, Field(alias="in")] = 0.0
    """Friction while the drum heaves in: it begins below (1 - in) times the tension."""
    pay_out: Annotated[of.Factor, Field(alias="out")] = 0.0
    """Friction while the drum pays out: it begins above (1 + out) times the tension."""


class SpeedTable(SchemaModel):
    """Straight lines between the speeds at some times, constant outside."""

    key_rules = (value_for_each_time("speed"),)
    time: of.Times
    """Times that rise."""
    speed: Annotated[tuple[of.Speed, ...], AfterValidator(of.require_entries)]
    """Speed of pay-out at each time, negative to heave in."""


def _speed_form(value: object) -> str:
    """Which of the forms a speed has."""
    if isinstance(value, SpeedTable) or (isinstance(value, dict) and "time" in value):
        return "table"
    if isinstance(value, signal.RecordedColumns) or (isinstance(value, dict) and "file" in value):
        return "recorded"
    return "harmonic" if isinstance(value, dict | signal.HarmonicEntry) else "speed"


SpeedOverTime = Annotated[
    Annotated[of.Speed, Tag("speed")]
    | Annotated[SpeedTable, Tag("table")]
    | Annotated[signal.RecordedColumns, Tag("recorded")]
    | Annotated[signal.HarmonicEntry[of.Speed], Tag("harmonic")],
    Discriminator(_speed_form),
]


@schema_class
class Compensation(SchemaClass):
    """Active heave compensation: the drum pays out what a point rises, and heaves in what it
    falls."""

    point: StrictStr
    """Named point whose rise the drum follows. Example: crane tip of vessel."""
    gain: of.Factor = 1.0
    """Part of the rise that is paid out."""
    delay: of.Span = 0.0
    """Time after which the drum knows the rise."""
    speed: of.TopSpeed | None = None
    """Largest speed of the drum. Without it, any speed."""
    stroke: of.LineLength | None = None
    """Largest change of length, half of it to each side. Without it, any change."""


@schema_class
class Winch(TwoPointElement, BreakingElement):
    """A wire from a point of a body to an anchor, on the earth or on another body, with a drum that
    changes its length."""

    tension_channel: ClassVar[str] = "winch_tension"
    example: ClassVar[dict[str, Any]] = {
        "type": "winch",
        "body": "barge",
        "point": ["0.4 m", "-0.3 m", "0.8 m"],
        "anchor": ["0.5 m", "0.2 m", "5 m"],
        "anchor_body": "topside",
        "stiffness": "300 kN",
        "damping": "0.02 s",
        "length": "2.7 m",
        "speed": {"time": ["0 s", "10 s"], "speed": ["0 m/s", "0.5 m/s"]},
        "drum": {"shortest": "1 m", "longest": "20 m"},
    }

    type: Literal["winch"] = field(default="winch", kw_only=True)
    """A wire whose length a drum changes. A tugger is a winch with tension and dead_band."""
    stiffness: of.AxialStiffness
    """Axial stiffness EA of the wire: tension per strain."""
    damping: of.Span = field(default=0.0, kw_only=True)
    """Damping of the wire: tension per rate of strain, over the stiffness."""
    length: Annotated[
        signal.Signal | float | None,
        ReadAs(signal.LengthOverTime | None, (signal.Signal, NoneType)),
    ] = None
    """Length of wire off the drum without load: a table, recorded series or sine over time, or the
    length at the start. Without it, the wire has the set tension at rest."""
    tension: of.ReferenceForce | None = field(default=None, kw_only=True)
    """Tension that the drum keeps."""
    speed: Annotated[
        signal.Signal | float | None,
        ReadAs(SpeedOverTime | None, (signal.Signal, NoneType)),
    ] = field(default=None, kw_only=True)
    """Largest speed of the drum, with tension. Else its speed of pay-out: a number, a table,
    recorded series or sine over time."""
    dead_band: of.Factor = field(default=0.0, kw_only=True)
    """Part of the tension, to each side, by which it may deviate before the drum turns."""
    friction: DrumFriction = field(default=DrumFriction(), kw_only=True)
    """Friction of the drum with tension."""
    acceleration: of.Acceleration | None = field(default=None, kw_only=True)
    """Acceleration of the drum with tension. Without it, the drum changes its speed at once."""
    drum: Drum | None = field(default=None, kw_only=True)
    """Lengths of wire at which the drum is full and empty."""
    compensation: Compensation | None = field(default=None, kw_only=True)
    """Active heave compensation."""
    rated_load: of.ReferenceForce | None = field(default=None, kw_only=True)
    """Largest tension that the drum is made for. Statistics compare with it."""
    capacity: of.ReferenceForce | None = field(default=None, kw_only=True)
    """Allowable tension, which statistics compare with. Without it, the rated_load."""

    @model_validator(mode="after")
    def _check_control(self) -> Self:
        signal.require_length(self.length)
        given = [key for key in ("tension", "compensation") if getattr(self, key) is not None]
        if self.speed is not None and self.tension is None:
            given.append("speed")
        if self.length is not None and not isinstance(self.length, float):
            given.append("length over time")
        if len(given) != 1:
            given_keys = " and ".join(given) or "a winch that nothing drives"
            expected = "one of tension, speed, compensation, or length over time"
            raise problem(given_keys, expected, "a wire of constant length is a spring")
        if self.tension is None:
            self._check_untense(given[0])
        else:
            self._check_tension()
        if "length over time" not in given:
            self._check_drum(given[0])
        return self

    def _check_untense(self, control: str) -> None:
        """Refuse keys of tension control, and a missing length."""
        if "length" not in control and self.length is None:
            raise problem("no length", "the length of wire off the drum at the start")
        if self.dead_band or self.acceleration or any(self._frictions()):
            raise problem(
                f"dead_band, friction or acceleration with {control}",
                "them with tension alone",
                "remove them",
            )
        if "length" in control and self.drum is not None:
            raise problem("drum and a length over time", "one of them", "remove drum")
        if "compensation" in control and self.drum is not None:
            raise problem("drum and compensation", "one of them", "use compensation.stroke")

    def _check_tension(self) -> None:
        """Refuse a set tension that no drum could keep."""
        assert self.tension is not None
        inwards, outwards = self._frictions()
        if not isinstance(self.speed, float) or self.speed <= 0.0:
            found_text = "no speed" if self.speed is None else "a speed that is not above 0"
            raise problem(
                f"tension and {found_text}", "the largest speed of the drum: speed: 0.3 m/s"
            )
        if self.dead_band + inwards >= 1.0:
            found_text = (
                f"a dead_band and friction in of {self.dead_band + inwards:g} of the tension"
            )
            raise problem(found_text, "less than 1: else the drum never heaves in")
        if self.acceleration and not self.dead_band + inwards + outwards:
            remedy = "give a dead_band; else it would never come to rest"
            raise problem("acceleration without dead_band or friction", "a dead_band", remedy)
        most = self.tension * (1.0 + self.dead_band + outwards)
        if self.rated_load is not None and self.rated_load < most:
            found_text = f"a rated_load of {self.rated_load:g} N, and paying out at {most:g} N"
            raise problem(found_text, "a rated_load of the tension at which it pays out, or more")

    def _check_drum(self, control: str) -> None:
        """Refuse a drum without ends, or with a length beyond them."""
        if control == "compensation":
            self._check_stroke()
            return
        if self.drum is None:
            raise problem(f"{control} and no drum", f"the ends of the drum: {DRUM}")
        shortest, longest = self.drum.shortest, self.drum.longest
        if isinstance(self.length, float) and not shortest <= self.length <= longest:
            found_text = f"length {self.length:g} m and a drum from {shortest:g} to {longest:g} m"
            raise problem(found_text, "a length within")
        fixed = isinstance(self.speed, float) and self.speed == 0.0
        if fixed or (isinstance(self.speed, SpeedTable) and not any(self.speed.speed)):
            raise problem("a speed of 0", "one that is not 0", "a winch that stands is a spring")

    def _check_stroke(self) -> None:
        """Refuse a stroke that heaves in all of the wire."""
        stroke = self.compensation.stroke if self.compensation else None
        if stroke is not None and isinstance(self.length, float) and self.length <= 0.5 * stroke:
            found_text = f"a stroke of {stroke:g} m and {self.length:g} m of wire"
            raise problem(
                found_text, "a wire longer than half of the stroke, which it may heave in"
            )

    def _frictions(self) -> tuple[float, float]:
        return self.friction.heave_in, self.friction.pay_out

    def recorded_series(self) -> Iterator[tuple[Keys, signal.RecordedColumns]]:
        for key in ("length", "speed"):
            if isinstance(form := getattr(self, key), signal.RecordedColumns):
                yield (key,), form

    def is_written(self) -> bool:
        rated_alone = self.rated_load is not None and self.capacity is None
        steady = self.tension is None and isinstance(self.speed, float)
        return rated_alone or steady or super().is_written()

    def with_built_parts(self, where: BuildContext) -> Self:
        """The same with its length and its speed of pay-out as signals, if they change."""
        length: Any = self.length
        speed: Any = self.speed
        if not isinstance(length, float | signal.Signal | None):
            length = signal.length_signal(length, f"{where.key}.length", where.path)
        if self.tension is None and speed is not None:
            speed = speed_signal(speed, f"{where.key}.speed", where.path)
        return replace(self, length=length, speed=speed, capacity=self.capacity or self.rated_load)

    @property
    def ends(self) -> tuple[float, float]:
        """The shortest and the longest length off the drum [m]."""
        if self.drum is not None:
            return self.drum.shortest, self.drum.longest
        if not isinstance(self.length, float):
            return 0.0, inf
        stroke = self.compensation.stroke if self.compensation else None
        if stroke is None:
            return MIN_WIRE_FRACTION * self.length, inf
        return self.length - 0.5 * stroke, self.length + 0.5 * stroke

    def can_add_energy(self) -> bool:
        """A drum that heaves in gives energy."""
        return True

    def signals(self) -> Iterator[tuple[str, Any]]:
        for key in ("length", "speed"):
            if isinstance(over_time := getattr(self, key), signal.Signal):
                yield key, over_time

    def jumps(self) -> Iterator[tuple[str, float]]:
        if self.damping and isinstance(self.length, signal.Table):
            size = self.stiffness * self.damping / float(self.length.value.min())
            yield "length", size * signal.largest_corner(self.length)

    def mirror_image(self) -> ForceElement | None:
        if self.compensation is not None:  # its point is known by name alone
            return None
        return super().mirror_image()


def speed_signal(form: Any, key: str, path: Path) -> signal.Signal:
    """The signal of a speed [m/s]. Raises as `hydrosim.scene.signal.signal_of`."""
    if isinstance(form, signal.Signal):
        return form
    if isinstance(form, float):
        return signal.constant(form)
    if isinstance(form, SpeedTable):
        return signal.Table(np.array(form.time), np.array(form.speed))
    return signal.signal_of(form, key, path, "m/s")
