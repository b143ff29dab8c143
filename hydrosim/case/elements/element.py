"""Keys that force elements of a case file share: `breaks_at`, lengths over time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import ConfigDict, StrictStr, model_validator

from hydrosim.files.messages import Keys
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import problem
from hydrosim.scene.force import (
    Active,
    BreaksAt,
    BuildContext,
    Moment,
    build_condition,
    require_one_end,
    until_it_breaks,
)
from hydrosim.scene.signal import RecordedColumns

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


class Breaking(Element):
    """A line that may part: the end of its action, located as an event."""

    tension_channel: ClassVar[str]
    """Channel with the tension of the line."""
    breaks_at: BreaksAt | None = None
    """Tension at which the line parts, or a mapping with tension or time. Energy that it held is
    lost. Example: 8 MN."""

    @model_validator(mode="after")
    def _check_end(self) -> Self:
        require_one_end(self.breaks_at, self.active)
        return self

    def breaking(self, where: BuildContext, active: Active | None) -> Active | None:
        return until_it_breaks(active, self.breaks_at, self.tension_channel, where)
