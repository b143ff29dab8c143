"""`fender` in a case file; its friction laws are in `friction`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, StrictBool, StrictStr, model_validator

from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.case.elements.friction import Friction, StickSlip
from hydrosim.case.records import signal_of
from hydrosim.case.signals import NormalOverTime, Recorded
from hydrosim.documents import quantities as of
from hydrosim.documents.messages import Keys
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim import forces


class Plane(SchemaModel):
    """The other side of a contact, in the earth frame or in that of a body."""

    point: of.Point
    """A point of the plane, in the earth frame or the frame of its body."""
    normal: of.Direction
    """Direction away from the plane, to the free side. Example: [0, -1, 0]."""
    body: StrictStr | None = None
    """Body that the plane is fixed to. Without it the plane is fixed to the earth. Example:
    topside."""
    corners: tuple[of.Point, ...] = ()
    """Corners of a polygon in the plane, outside of which there is no contact."""

    @model_validator(mode="after")
    def _check_normal(self) -> Self:
        if not any(self.normal):
            raise problem("the normal [0, 0, 0]", "a direction", "point it to the free side")
        return self

    @model_validator(mode="after")
    def _check_corners(self) -> Self:
        if len({*self.corners}) < len(self.corners):
            raise problem("a corner twice", "each once", "a polygon is closed by itself")
        if len(self.corners) > 2 and not _goes_round_once(np.array(self.corners), self.normal):
            expected = "each beside the one before it, once round the polygon"
            raise problem("corners whose sides cross each other", expected, "put them in order")
        return self


def _goes_round_once(corners: np.ndarray, normal: Sequence[float]) -> bool:
    """Whether corners (n, 3) are in the order of their angles about their middle, either way."""
    across = np.delete(corners - corners.mean(axis=0), np.argmax(np.abs(normal)), axis=1)
    angle = np.arctan2(across[:, 1], across[:, 0])
    turns = np.mod(np.diff(angle, append=angle[:1]), 2.0 * np.pi).sum() / (2.0 * np.pi)
    return round(turns) in (1, len(corners) - 1)


def check_lengths(compression: Sequence[float] | None, force: Sequence[float] | None) -> None:
    """Refuses a table that has not a force for each compression."""
    if compression and force and len(compression) != len(force):
        found_text = f"{len(compression)} values in compression and {len(force)} in force"
        raise problem(found_text, "a force for each compression")


class Unloading(SchemaModel):
    """The way back along a normal curve, and the stiff line between."""

    compression: of.Compressions
    """Compressions from 0 that rise, on the way back."""
    force: of.NormalForces
    """Force at each compression on the way back."""
    stiffness: of.Stiffness
    """Stiffness of the line between the way there and the way back."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        check_lengths(self.compression, self.force)
        return self


class Normal(SchemaModel):
    """Normal force of a contact; ``total`` values are shared by the points."""

    stiffness: of.Stiffness | None = None
    """Force per compression of a linear contact."""
    compression: of.Compressions | None = None
    """Compressions from 0 that rise, for a curve."""
    force: of.NormalForces | None = None
    """Force at each compression."""
    unloading: Unloading | None = None
    """Curve of the way back, of a contact that loses energy."""
    prescribed: NormalOverTime | None = None
    """Normal force over time, whatever the compression."""
    damping: of.Damping = 0.0
    """Damping of compression."""
    total: StrictBool = False
    """Whether values are of all points together and are shared equally."""

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        given = self.keys_with_value("stiffness", "compression", "force", "prescribed")
        if given not in (["stiffness"], ["compression", "force"], ["prescribed"]):
            expected = "stiffness, or compression and force, or prescribed"
            raise problem(" and ".join(given) or "no curve", expected)
        if self.prescribed and self.damping:
            raise problem("prescribed and damping", "one of them")
        if self.unloading and (self.prescribed or self.damping):
            found_text = f"unloading and {'prescribed' if self.prescribed else 'damping'}"
            raise problem(found_text, "one of them", "the loop takes energy, and needs a curve")
        if self.force and not self.force[-1]:
            raise problem("no force at any compression", "one that rises")
        check_lengths(self.compression, self.force)
        return self

    def build(self, count: int, where: BuildContext) -> forces.Normal:
        """The normal force of each of ``count`` points."""
        from hydrosim.forces.contact.normal import NormalCurve, NormalLoop, PrescribedNormal
        from hydrosim.forces.signal import scale_signal

        share = 1.0 / count if self.total else 1.0
        if self.prescribed is not None:
            key = f"{where.key}.normal.prescribed"
            return PrescribedNormal(
                scale_signal(signal_of(self.prescribed, key, where.path, "N"), share)
            )
        if self.stiffness is not None:
            table = np.array([0.0, 1.0]), np.array([0.0, self.stiffness])
        else:
            table = np.array(self.compression), np.array(self.force)
        compression, force = table
        if self.unloading is not None:
            back = np.array(self.unloading.compression), share * np.array(self.unloading.force)
            return NormalLoop(compression, share * force, *back, share * self.unloading.stiffness)
        return NormalCurve(compression, share * force, share * self.damping)


class Fender(Element):
    """Points of a body against a plane."""

    example: ClassVar[dict[str, Any]] = {
        "type": "fender",
        "body": "barge",
        "points": [["1 m", "0.5 m", "-1 m"], ["-0.8 m", "-0.6 m", "-1.1 m"]],
        "plane": {"body": "topside", "point": [0, 0, "0.9 m"], "normal": [0, 0, 1]},
        "normal": {"stiffness": "100 kN/m", "damping": "3 kN*s/m"},
        "friction": StickSlip.example,
    }

    type: Literal["fender"]
    """Points of a body against a plane."""
    points: Annotated[tuple[of.Point, ...], AfterValidator(of.require_entries)]
    """Points in the body frame that touch the plane."""
    plane: Plane
    """The other side of the contact."""
    normal: Normal
    """Normal force of the contact."""
    friction: Friction
    """Friction law of the contact."""
    group: of.Name | None = None
    """Name of a group of contacts. Statistics of contacts are made for each group. Example:
    legs."""
    capacity: of.ReferenceForce | None = None
    """Allowable force, which statistics compare with."""

    @model_validator(mode="after")
    def _check_corners(self) -> Self:
        if self.plane.corners and self.normal.prescribed:
            raise problem("plane.corners and normal.prescribed", "one of them")
        return self

    @model_validator(mode="after")
    def _check_rate_free(self) -> Self:
        law = self.friction
        rate_free = isinstance(law, StickSlip) and not law.damping + law.slip_damping
        if rate_free and self.normal.damping:
            found_text = "normal.damping and friction without damping and slip_damping"
            raise problem(found_text, "one of the latter above 0, or no normal.damping")
        return self

    def body_references(self) -> Iterator[tuple[Keys, str | None, str]]:
        yield ("plane", "body"), self.plane.body, "a plane without body is fixed to the earth"

    def recorded_series(self) -> Iterator[tuple[Keys, Recorded]]:
        if isinstance(self.normal.prescribed, Recorded):
            yield ("normal", "prescribed"), self.normal.prescribed

    def build(self, where: BuildContext) -> forces.Fender:
        from hydrosim.forces.contact import fender, plane  # loads numba

        count = len(self.points)
        return fender.Fender(
            self.body,
            points=np.array(self.points),
            plane=plane.Plane(**dict(self.plane)),
            normal=self.normal.build(count, where),
            friction=self.friction.build(count),
            group=self.group,
            capacity=self.capacity,
        )
