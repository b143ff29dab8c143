"""Force elements of case files, one file each: keys, what must agree, what is built."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator

from hydrosim.case.elements.applied_force import AppliedForce
from hydrosim.case.elements.bushing import Bushing
from hydrosim.case.elements.catenary import Catenary
from hydrosim.case.elements.compensator import Compensator
from hydrosim.case.elements.drive import Drive
from hydrosim.case.elements.element import BuildContext, Element
from hydrosim.case.elements.fender import Fender
from hydrosim.case.elements.landing import Landing
from hydrosim.case.elements.linear_damping import LinearDamping
from hydrosim.case.elements.linear_mooring import LinearMooring
from hydrosim.case.elements.lines import Lines
from hydrosim.case.elements.quadratic_damping import QuadraticDamping
from hydrosim.case.elements.spring import Spring
from hydrosim.case.elements.stream_load import CurrentLoad, WindLoad
from hydrosim.case.elements.strut import Strut
from hydrosim.case.elements.torsion_spring import TorsionSpring
from hydrosim.case.elements.viscous_roll import ViscousRoll
from hydrosim.case.elements.winch import Winch
from hydrosim.documents.units import problem


def _check_kind(data: Any) -> Any:
    if isinstance(data, dict) and "mass" in data and "type" not in data:
        raise problem("a body, with a mass", "a force element", 'move it below "bodies:"')
    return data


AnyElement = Annotated[
    LinearMooring
    | AppliedForce
    | Fender
    | Landing
    | Spring
    | Catenary
    | Lines
    | Strut
    | TorsionSpring
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
