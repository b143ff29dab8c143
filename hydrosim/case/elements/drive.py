"""`drive` in a case file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, StrictStr, Tag, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one, value_for_each_time
from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import problem
from hydrosim.scene.signal import HarmonicEntry, RecordedColumns, only_forms, read_record

if TYPE_CHECKING:
    from hydrosim.elements.drive import Drive as Built
    from hydrosim.scene.signal import Signal


class OffsetTable(SchemaModel):
    """A smooth curve through the offsets at some times, which never overshoots."""

    key_rules = (value_for_each_time("offset"),)

    time: Annotated[of.Times, AfterValidator(of.require_two_entries)]
    """Times that rise, from the start of the run to its end."""
    offset: Annotated[tuple[of.Length, ...], AfterValidator(of.require_entries)]
    """Offset at each time. Equal neighbours are a rest."""


class AngleTable(SchemaModel):
    """A smooth curve through the angles at some times, which never overshoots."""

    key_rules = (value_for_each_time("angle"),)

    time: Annotated[of.Times, AfterValidator(of.require_two_entries)]
    """Times that rise, from the start of the run to its end."""
    angle: Annotated[tuple[of.Angle, ...], AfterValidator(of.require_entries)]
    """Angle at each time. Equal neighbours are a rest."""


def _form_tag(value: object) -> str:
    """Which of the forms a motion has."""
    if isinstance(value, OffsetTable | AngleTable) or (isinstance(value, dict) and "time" in value):
        return "table"
    if isinstance(value, RecordedColumns) or (isinstance(value, dict) and "file" in value):
        return "recorded"
    return "harmonic"


OffsetOverTime = Annotated[
    Annotated[OffsetTable, Tag("table")]
    | Annotated[RecordedColumns, Tag("recorded")]
    | Annotated[HarmonicEntry[of.Length], Tag("harmonic")],
    Discriminator(_form_tag),
    only_forms("offset", "m", OffsetTable, RecordedColumns, HarmonicEntry),
]
AngleOverTime = Annotated[
    Annotated[AngleTable, Tag("table")]
    | Annotated[RecordedColumns, Tag("recorded")]
    | Annotated[HarmonicEntry[of.Angle], Tag("harmonic")],
    Discriminator(_form_tag),
    only_forms("angle", "deg", AngleTable, RecordedColumns, HarmonicEntry),
]


class DriveEntry(Element):
    """Prescribed motion of a degree of freedom of a body, or of a motion of a joint."""

    key_rules = (exactly_one("offset", "angle", nothing="no motion"),)

    example: ClassVar[dict[str, Any]] = {
        "type": "drive",
        "body": "barge",
        "dof": "heave",
        "offset": {"amplitude": "0.5 m", "period": "8 s"},
    }

    type: Literal["drive"]
    """A motion over time, with the force that it takes."""
    body: StrictStr | None = None  # type: ignore[assignment]
    """Body that it moves; else give joint. Example: barge."""
    dof: StrictStr | None = None
    """Degree of freedom of the body that it moves. Example: heave."""
    joint: StrictStr | None = None
    """Joint that it moves, in place of body and dof. Example: crane."""
    motion: StrictStr | None = None
    """Motion of the joint that it moves. Without it, the only one. Example: angle."""
    offset: OffsetOverTime | None = None
    """Offset from the place at rest: a table, a recorded series or a sine."""
    angle: AngleOverTime | None = None
    """Angle from the place at rest: a table, a recorded series or a sine."""

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        wanted = "either body and dof, or joint"
        if (self.body is None) == (self.joint is None):
            both = "body and joint" if self.body else "neither body nor joint"
            raise problem(both, wanted)
        if (self.body is None) != (self.dof is None):
            raise problem("dof without body" if self.dof else "body without dof", wanted)
        if self.motion is not None and self.joint is None:
            raise problem("motion without joint", wanted)
        return self

    def recorded_series(self) -> Iterator[tuple[Keys, RecordedColumns]]:
        for key, form in (("offset", self.offset), ("angle", self.angle)):
            if isinstance(form, RecordedColumns):
                yield (key,), form

    def build(self, where: BuildContext) -> Built:
        from hydrosim.elements.drive import Drive as Built

        signal = self._signal(where)
        key = "offset" if self.offset is not None else "angle"
        if self.joint is None:
            assert self.body is not None
            assert self.dof is not None
            return Built(self.body, dof=self.dof, position=signal, quantity=key)
        joint = where.joints.get(self.joint)
        names = [motion.name for motion in joint.motions] if joint else []
        motion = self.motion or (names[0] if len(names) == 1 else "")
        body = joint.body if joint else ""  # `checks` refuses unknown joints
        return Built(body, dof=motion, position=signal, joint=self.joint, quantity=key)

    def _signal(self, where: BuildContext) -> Signal:
        from hydrosim.scene import signal

        key, form = ("offset", self.offset) if self.offset is not None else ("angle", self.angle)
        if isinstance(form, HarmonicEntry):
            mean = form.mean or 0.0
            return signal.Harmonic(form.amplitude, form.period, mean, form.phase)
        if isinstance(form, RecordedColumns):
            unit = "m" if key == "offset" else "rad"
            series = read_record(form, f"{where.key}.{key}", where.path, unit)
            return signal.Recorded(series.time, series.value)
        assert form is not None
        values = form.offset if isinstance(form, OffsetTable) else form.angle
        return signal.SmoothTable(np.array(form.time), np.array(values))
