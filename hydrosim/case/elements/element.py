"""What every force element of a case file has."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import ConfigDict, StrictStr, model_validator

from hydrosim.case.elements.active import Active, Moment
from hydrosim.case.signals import Recorded
from hydrosim.documents.messages import Keys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim import scene
    from hydrosim.scene import ForceElement


@dataclass(frozen=True)
class BuildContext:
    """Where something is: its ``key`` in the case file ``path``; density [kg/m^3] and gravity
    [m/s^2] of its ``water``; the ``joints`` of the case."""

    key: str
    path: Path
    water: tuple[float, float] = (1025.0, 9.81)
    joints: Mapping[str, scene.Joint] = field(default_factory=dict)


def _with_example(schema: dict[str, Any], model: type[Exemplary]) -> None:
    schema["examples"] = [model.example]


class Exemplary(SchemaModel):
    """A mapping with an ``example``, which stands in its JSON schema and is built by a test."""

    model_config = ConfigDict(json_schema_extra=_with_example)
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
