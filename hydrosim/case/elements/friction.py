"""Friction laws of fenders in a case file, one class each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Discriminator, StrictBool, model_validator

from hydrosim.case.elements.element import Exemplary
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import SchemaModel
from hydrosim.documents.units import problem

if TYPE_CHECKING:
    from hydrosim import forces


def _check_coefficients(static: float, kinetic: float) -> None:
    if static < kinetic:
        raise problem(f"static {static:g}, kinetic {kinetic:g}", "static >= kinetic")


class LoadPowers(SchemaModel):
    """Powers of the normal force over a ``reference`` that the coefficients go with; a ``total``
    reference is shared by the points, as the coefficients are."""

    reference: of.ReferenceForce
    """Normal force at which the coefficients are as given."""
    stiffness: of.Power
    """Power of the normal force that the stiffness goes with."""
    damping: of.Power = 0.0
    """Power of the normal force that the damping goes with."""
    slip_damping: of.Power = 0.0
    """Power of the normal force that the slip damping goes with."""

    @model_validator(mode="after")
    def _check_powers(self) -> Self:
        if max(self.damping, self.slip_damping) > self.stiffness:
            found_text = f"damping {self.damping:g}, slip_damping {self.slip_damping:g}"
            expected = f"no more than that of the stiffness, {self.stiffness:g}"
            raise problem(
                found_text, expected, "else the node stiffens without bound as the load goes"
            )
        return self


class StickSlip(Exemplary):
    """The thesis' new friction model; ``total`` values are shared by the points."""

    example: ClassVar[dict[str, Any]] = {
        "law": "stick_slip",
        "static": 0.4,
        "kinetic": 0.3,
        "stiffness": "200 kN/m",
        "damping": "10 kN*s/m",
    }

    law: Literal["stick_slip"]
    """Stick-slip friction with an elastic contact node."""
    static: of.Factor
    """Friction coefficient at which sticking ends."""
    kinetic: of.Factor
    """Friction coefficient while slipping."""
    stiffness: of.Stiffness
    """Tangential stiffness K2 of the contact."""
    damping: of.Damping = 0.0
    """Tangential damping C2 of the contact."""
    slip_damping: of.Damping = 0.0
    """Damping C3 of the slip velocity."""
    load: LoadPowers | None = None
    """Powers of the normal force that stiffness and damping go with."""
    total: StrictBool = False
    """Whether values are of all points together and are shared equally."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        if self.load and not self.damping + self.slip_damping:
            found_text = "load without damping and slip_damping"
            raise problem(found_text, "one of the latter above 0, or no load")
        return self

    def build(self, count: int) -> forces.StickSlip:
        """The law of each of ``count`` points."""
        from hydrosim.forces.contact.stick_slip import LoadPowers as Powers
        from hydrosim.forces.contact.stick_slip import StickSlip as Built

        share, load = 1.0 / count if self.total else 1.0, None
        if self.load is not None:
            powers = (self.load.stiffness, self.load.damping, self.load.slip_damping)
            load = Powers(share * self.load.reference, *powers)
        stiffness, damping = share * self.stiffness, share * self.damping
        slip_damping = share * self.slip_damping
        return Built(self.static, self.kinetic, stiffness, damping, slip_damping, load)


class Coulomb(Exemplary):
    """Rigid friction: what sticks does not move."""

    example: ClassVar[dict[str, Any]] = {"law": "coulomb", "static": 0.4, "kinetic": 0.3}

    law: Literal["coulomb"]
    """Rigid friction: a contact that sticks does not move."""
    static: of.Factor
    """Friction coefficient at which sticking ends."""
    kinetic: of.Factor
    """Friction coefficient while slipping."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        return self

    def build(self, count: int) -> forces.Coulomb:
        """The law of each of ``count`` points."""
        from hydrosim.forces.contact.coulomb import Coulomb as Built

        return Built(self.static, self.kinetic)


class FrictionSlope(Exemplary):
    """aNySIM's friction model; a ``total`` slope is shared by the points."""

    example: ClassVar[dict[str, Any]] = {
        "law": "friction_slope",
        "coefficient": 0.3,
        "slope": "40 kN*s/m",
    }

    law: Literal["friction_slope"]
    """Friction that rises with velocity up to the full value, as in aNySIM."""
    coefficient: of.Factor
    """Friction coefficient."""
    slope: of.Slope
    """Friction force per velocity while below the full value."""
    total: StrictBool = False
    """Whether the slope is of all points together and is shared equally."""

    def build(self, count: int) -> forces.FrictionSlope:
        """The law of each of ``count`` points."""
        from hydrosim.forces.contact.friction_slope import FrictionSlope as Built

        return Built(self.coefficient, (1.0 / count if self.total else 1.0) * self.slope)


class Frictionless(Exemplary):
    """No friction; the other keys may stay, so that one word turns the friction of a case off."""

    model_config = ConfigDict(extra="ignore")
    example: ClassVar[dict[str, Any]] = {"law": "none"}
    law: Literal["none"]
    """No friction."""

    def build(self, count: int) -> forces.Frictionless:
        """The law of each of ``count`` points."""
        from hydrosim.forces.contact.frictionless import Frictionless as Built

        return Built()


Friction = Annotated[StickSlip | Coulomb | FrictionSlope | Frictionless, Discriminator("law")]
