"""The case file as pydantic models: which keys there are, what they hold, what must agree.

All values are in SI and radians once validated. What concerns several parts of a case at a time is
in `hydrosim.case.checks`.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal, Self

import pydantic
from pydantic.config import JsonDict

from hydrosim import scene
from hydrosim.case.criteria import Report, RunCriterion
from hydrosim.case.hydrodynamics import Hydrodynamics, Hydrostatics, files_of
from hydrosim.case.lines.element import Lines
from hydrosim.case.tanks import TankEntry
from hydrosim.case.waves import Waves
from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import ByKind, schema_class
from hydrosim.files.units import Quantity, problem
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.contacts import Fender, Landing
from hydrosim.scene.damping import LinearDamping, QuadraticDamping, ViscousRoll
from hydrosim.scene.environment import WaterProperties
from hydrosim.scene.joint import AnyJoint
from hydrosim.scene.links import AnyCoordinateElement, Compensator, Spring, Strut, TorsionSpring
from hydrosim.scene.loads import AppliedForce, CurrentLoad, WindLoad
from hydrosim.scene.restraints import Bushing, Drive, LinearMooring
from hydrosim.scene.scene import ACCURACIES, ACCURACY, RunOutput, SolverSettings
from hydrosim.scene.winch import Winch


@schema_class
class EnvironmentEntry(WaterProperties):
    """Water, the waves on it, one mapping or a list of them, current and wind."""

    waves: Waves = ()
    """One wave train, or a list of wave trains that act together."""
    current: scene.Current | None = None
    """Steady current, uniform or over the depth. Bodies with hydrodynamics feel it, and force
    elements."""
    wind: scene.Wind | None = None
    """Wind, steady or with gusts. It acts through force elements alone."""


@schema_class
class BodyEntry(scene.BodyKeys):
    """A rigid body; dry if it has no hydrodynamics."""

    hydrodynamics: Hydrodynamics | None = None
    hydrostatics: Hydrostatics = "matrix"
    tanks: dict[of.Name, TankEntry] = field(default_factory=dict)
    pumps: dict[of.Name, scene.PumpKeys] = field(default_factory=dict)

    @pydantic.model_validator(mode="before")
    @classmethod
    def _check_kind(cls, data: Any) -> Any:
        if isinstance(data, dict) and {"type", "body"} & data.keys():
            found_text = f"a force element, type {data.get('type')}"
            raise problem(found_text, "a body", 'move it below "forces:"')
        return data

    @pydantic.model_validator(mode="after")
    def _check_place(self) -> Self:
        files = files_of(self.hydrodynamics)
        if files and self.lightship is None and self.centre_of_gravity is None:
            raise problem("no centre_of_gravity", "one, in the database's frame")
        if not files and self.database_body != 1:
            raise problem("database_body and no database", "both, or none")
        if not files and self.database_checksum is not None:
            raise problem("database_checksum and no database", "both, or none")
        model = self.radiation.model
        if isinstance(self.hydrodynamics, scene.Coefficients) and model != "automatic":
            found_text = f"radiation: {model} of coefficients, which are constant"
            raise problem(found_text, "no radiation there, or a database")
        return self

    @pydantic.model_validator(mode="after")
    def _check_waves(self) -> Self:
        """A dry body neither makes waves nor feels them."""
        if self.hydrodynamics is not None:
            return self
        if self.radiation not in (scene.AutomaticRadiation(), scene.NoRadiation()):
            raise problem("radiation of a dry body", "hydrodynamics too, or no radiation")
        if self.wave_forces.has_loads and self.wave_forces != scene.WaveForces():
            raise problem("wave_forces of a dry body", "hydrodynamics too, or no wave_forces")
        return self

    @pydantic.model_validator(mode="after")
    def _check_start(self) -> Self:
        speeds = zip(DOFS, self.initial.velocity, strict=True)
        moving = [dof for dof, speed in speeds if speed and dof not in self.dofs]
        if moving:
            raise problem(f"an initial velocity in {', '.join(moving)}", "0 where `dofs` has none")
        return self


def _form_of_tolerance(value: object) -> str:
    return "of each step" if isinstance(value, dict | scene.Tolerance) else "of motions"


MotionError = Annotated[
    float,
    Quantity("error of motions, of their range", "", "1e-4", None, *ACCURACIES),
]
EitherTolerance = Annotated[
    Annotated[scene.Tolerance, pydantic.Tag("of each step")]
    | Annotated[MotionError, pydantic.Tag("of motions")],
    pydantic.Discriminator(_form_of_tolerance),
]


_OF_STEPS: JsonDict = {
    "if": {
        "properties": {"method": {"not": {"const": scene.Method.AUTOMATIC.value}}},
        "required": ["method"],
    },
    "then": {"properties": {"tolerance": {"type": "object"}}},
}


@schema_class
class SolverEntry(SolverSettings):
    """How time is stepped. The ``tolerance`` of ``automatic`` is the error of motions, of their
    range; that of adaptive methods is the error of each step."""

    __pydantic_config__: ClassVar = pydantic.ConfigDict(json_schema_extra=_OF_STEPS)
    method: scene.Method = scene.Method.AUTOMATIC
    tolerance: EitherTolerance = ACCURACY

    @pydantic.model_validator(mode="after")
    def _set_defaults(self) -> Self:
        given = vars(self)["_keys"]
        defaults: dict[str, Any] = {}
        if "step" in given and "method" not in given:
            defaults["method"] = scene.Method.RK4
        if {**vars(self), **defaults}[
            "method"
        ] != scene.Method.AUTOMATIC and "tolerance" not in given:
            defaults["tolerance"] = scene.Tolerance()
        vars(self).update(defaults)  # the keys that are given stay those of the file
        return self

    @pydantic.model_validator(mode="after")
    def _check_tolerance(self) -> Self:
        of_steps = isinstance(self.tolerance, scene.Tolerance)
        if self.method == scene.Method.AUTOMATIC and of_steps:
            found_text = "tolerances of each step, which method: automatic chooses itself"
            raise problem(found_text, "one number, the error of motions of their range: 1e-4")
        if self.method != scene.Method.AUTOMATIC and not of_steps:
            found_text = f"tolerance: {self.tolerance:g} of method: {self.method}"
            raise problem(found_text, "method: automatic, or tolerance: {relative: 1e-6, ...}")
        return self


def _beginning_form(value: object) -> str:
    return "at_rest" if isinstance(value, str) else "of a run"


Begin = Annotated[
    Annotated[Literal["at_rest"], pydantic.Tag("at_rest")]
    | Annotated[scene.Start, pydantic.Tag("of a run")],
    pydantic.Discriminator(_beginning_form),
]


def _check_element(data: Any) -> Any:
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
    pydantic.BeforeValidator(_check_element),
]


class CaseFile(SchemaModel):
    """A whole case file."""

    title: pydantic.StrictStr
    """Title of the case, for people. Example: Barge alongside in 1.5 m waves."""
    duration: of.Period
    """Length of the run."""
    environment: EnvironmentEntry | None = None
    """Water, waves, current and wind."""
    bodies: Annotated[dict[of.Name, BodyEntry], pydantic.AfterValidator(of.require_entries)]
    """Rigid bodies by name."""
    forces: dict[of.Name, AnyElement] = pydantic.Field(default_factory=dict)
    """Force elements by name: moorings, fenders, lines, damping, loads."""
    joints: dict[of.Name, AnyJoint] = pydantic.Field(default_factory=dict)
    """Joints between bodies or to the earth, by name: hinges, balls, sliders, locks."""
    solver: SolverEntry = SolverEntry()
    """Time integration."""
    output: RunOutput = RunOutput()
    """Results that are recorded."""
    initial: Begin | None = None
    """Either at_rest, which starts in equilibrium, or a mapping with the run that this one
    continues."""
    accept: tuple[scene.Question, ...] = ()
    """Names of the questions that are answered: their values are meant as they are."""
    criteria: dict[of.Name, RunCriterion] = pydantic.Field(default_factory=dict)
    """Figures of the run with limits, by name."""
    report: Report = Report()
    """Title block of the report."""

    @pydantic.model_validator(mode="before")
    @classmethod
    def _check_kind(cls, data: Any) -> Any:
        if isinstance(data, dict) and "case" in data and "bodies" not in data:
            raise problem("a study, with the key case", "a case", "run it by hydrosim study")
        return data

    @pydantic.model_validator(mode="after")
    def _check_rest(self) -> Self:
        moving = [name for name, body in self.bodies.items() if any(body.initial.velocity)]
        moving += [name for name, joint in self.joints.items() if joint.moves]
        if self.initial == "at_rest" and moving:
            raise problem(f"initial: at_rest, and a velocity of {moving[0]}", "one of them")
        return self

    @property
    def begins(self) -> scene.Start | None:
        """The run to start from, if there is one."""
        return self.initial if isinstance(self.initial, scene.Start) else None

    @property
    def water(self) -> EnvironmentEntry:
        """The environment, or what is taken for it."""
        return self.environment or EnvironmentEntry()
