"""Force elements of case files, one file each: keys, what must agree, what is built."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator

from hydrosim.case.elements.catenary import CatenaryEntry, Lines
from hydrosim.files.schema_class import ByKind
from hydrosim.files.units import problem
from hydrosim.scene.contacts import Fender, Landing
from hydrosim.scene.damping import LinearDamping, QuadraticDamping, ViscousRoll
from hydrosim.scene.links import AnyCoordinateElement, Compensator, Spring, Strut, TorsionSpring
from hydrosim.scene.loads import AppliedForce, CurrentLoad, WindLoad
from hydrosim.scene.restraints import Bushing, Drive, LinearMooring
from hydrosim.scene.winch import Winch


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
    | CatenaryEntry
    | Lines
    | Strut
    | TorsionSpring
    | AnyCoordinateElement
    | Bushing
    | LinearDamping
    | QuadraticDamping
    | ViscousRoll
    | CurrentLoad
    | WindLoad
    | Winch
    | Compensator
    | Drive,
    ByKind("type"),
    BeforeValidator(_check_kind),
]
