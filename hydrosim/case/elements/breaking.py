"""`breaks_at` of lines in a case file: the tension or the time at which a line parts."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar, Self

from pydantic import Discriminator, Tag, model_validator

from hydrosim import scene
from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem


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


def _form(value: object) -> str:
    return "mapping" if isinstance(value, dict | Break) else "tension"


BreaksAt = Annotated[
    Annotated[of.ReferenceForce, Tag("tension")] | Annotated[Break, Tag("mapping")],
    Discriminator(_form),
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
