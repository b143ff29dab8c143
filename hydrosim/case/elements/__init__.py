"""Force elements of case files, one file each: keys, what must agree, what is built."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator

from hydrosim.case.elements.catenary import Catenary, Lines
from hydrosim.case.elements.damping import LinearDamping, QuadraticDamping, ViscousRoll
from hydrosim.case.elements.drive import Drive
from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.case.elements.loads import AppliedForce, CurrentLoad, LinearMooring, WindLoad
from hydrosim.case.elements.springs import Bushing, SpringEntry, StrutEntry, TorsionSpringEntry
from hydrosim.case.elements.winch import Winch
from hydrosim.files.units import problem
from hydrosim.scene.contacts import Fender, Landing
from hydrosim.scene.links import Compensator, DryFriction, GasSpring, SpringDamper, Stop


def _check_kind(data: Any) -> Any:
    if isinstance(data, dict) and "mass" in data and "type" not in data:
        raise problem("a body, with a mass", "a force element", 'move it below "bodies:"')
    return data


AnyElement = Annotated[
    LinearMooring
    | AppliedForce
    | Fender
    | Landing
    | SpringEntry
    | Catenary
    | Lines
    | StrutEntry
    | TorsionSpringEntry
    | SpringDamper
    | GasSpring
    | Stop
    | DryFriction
    | Bushing
    | LinearDamping
    | QuadraticDamping
    | ViscousRoll
    | CurrentLoad
    | WindLoad
    | Winch
    | Compensator
    | Drive,
    Discriminator("type"),
    BeforeValidator(_check_kind),
]
