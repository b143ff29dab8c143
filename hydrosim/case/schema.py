"""The case file as pydantic models: which keys there are, what they hold, what must agree.

All values are in SI and radians once validated. What concerns several parts of a case at a time is
in `hydrosim.case.checks`.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
import pydantic
from pydantic.config import JsonDict

from hydrosim import scene
from hydrosim.case.criteria import Report, RunCriterion
from hydrosim.case.elements import AnyElement
from hydrosim.case.hydrodynamics import Hydrodynamics, Hydrostatics, files_of
from hydrosim.case.streams import Current, Wind
from hydrosim.case.tanks import Lightship, PumpEntry, TankEntry
from hydrosim.case.waves import Waves
from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.messages import suggestion
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.schema_class import schema_class
from hydrosim.files.units import Quantity, problem
from hydrosim.scene.environment import WaterProperties
from hydrosim.scene.joint import AnyJoint
from hydrosim.scene.scene import ACCURACIES, ACCURACY, SolverSettings

ROTATION_DOFS = frozenset(DOFS[3:])
OUTPUT_STEP = 0.5  # s, about: if the case does not say


def _order_dofs(dofs: tuple[str, ...]) -> tuple[str, ...]:
    unknown = [dof for dof in dofs if dof not in DOFS]
    if unknown or len(set(dofs)) != len(dofs):
        remedy = suggestion(unknown[0], DOFS) if unknown else ""
        raise problem(f"[{', '.join(dofs)}]", f"any of {', '.join(DOFS)}, each once", remedy)
    return tuple(sorted(dofs, key=DOFS.index))


Dofs = Annotated[tuple[pydantic.StrictStr, ...], pydantic.AfterValidator(_order_dofs)]


@schema_class
class EnvironmentEntry(WaterProperties):
    """Water, the waves on it, one mapping or a list of them, current and wind."""

    waves: Waves = ()
    """One wave train, or a list of wave trains that act together."""
    current: Current | None = None
    """Steady current, uniform or over the depth. Bodies with hydrodynamics feel it, and force
    elements."""
    wind: Wind | None = None
    """Wind, steady or with gusts. It acts through force elements alone."""


class Initial(SchemaModel):
    """Offsets from the place at rest, and velocities, at the start."""

    position: of.Offsets = (0.0,) * 6
    """Offsets from the place at rest when the run starts: six values, or some by name."""
    velocity: of.Velocities = (0.0,) * 6
    """Velocities when the run starts: six values, or some by name."""


class NoRadiation(SchemaModel):
    """No radiation; the other keys may stay, so that one word turns it off."""

    model_config = pydantic.ConfigDict(extra="ignore")
    model: Literal["none"]
    """No radiation forces."""


def _require_model(value: Any) -> Any:
    return {"model": value} if isinstance(value, str) else value


Radiation = Annotated[
    scene.AutomaticRadiation
    | scene.StateSpaceRadiation
    | scene.ConvolutionRadiation
    | scene.ConstantRadiation
    | NoRadiation,
    pydantic.Discriminator("model"),
]


_MODEL = pydantic.BeforeValidator(
    _require_model,
    json_schema_input_type=Radiation | Literal["automatic", "state_space", "convolution", "none"],
)


class BodyEntry(SchemaModel):
    """A rigid body; dry if it has no hydrodynamics."""

    mass: of.Mass | None = None
    """Mass of the body, with the contents of its tanks at the start."""
    lightship: Lightship | None = None
    """Mass properties of the body without the contents of its tanks, in place of mass and
    inertia."""
    hydrodynamics: Hydrodynamics | None = None
    """Database file, a mapping with a file and changes to it, a list of databases by draught, or
    coefficients. A body without it is dry."""
    hydrostatics: Hydrostatics = "matrix"
    """Source of buoyancy: the stiffness matrix of the database, or a closed hull for any draught,
    heel and trim."""
    database_body: Annotated[int, pydantic.Field(strict=True, ge=1)] = 1
    """Number of this body in a database of several bodies. Example: 2."""
    database_checksum: pydantic.StrictStr | None = None
    """Checksum that the database must have. Another database is refused. Example: 8c1f0a2b."""
    centre_of_gravity: of.Point | None = None
    """Centre of gravity in the frame of the database. It is the origin of the body frame."""
    location: of.Position = (0.0, 0.0)
    """Place x, y of the database's origin in the earth frame. Example: [120 m, 0 m]."""
    heading: of.Angle = 0.0
    """Direction of the body's x axis at rest, counter-clockwise from the x axis of the earth. Yaw
    is counted from it."""
    radii_of_gyration: of.Radii | None = None
    """Radii of gyration about the centre of gravity for roll, pitch and yaw."""
    inertia: of.InertiaMatrix | None = None
    """Moments of inertia about the centre of gravity: three by name, or a 3 x 3 matrix."""
    mass_matrix: of.MassMatrix | None = None
    """Full 6 x 6 mass matrix about the centre of gravity."""
    dofs: Dofs = DOFS
    """Degrees of freedom that may move. Others are locked; an empty list holds the body. Example:
    [surge, heave, pitch]."""
    initial: Initial = Initial()
    """Offsets and velocities when the run starts."""
    radiation: Annotated[Radiation, _MODEL] = scene.AutomaticRadiation()
    """Model of the radiation forces: a name, or a mapping with a model and its settings."""
    wave_forces: scene.WaveForces = scene.WaveForces()
    """Wave loads that act on the body."""
    weight: scene.Weight | None = None
    """Whether weight and buoyancy balance at rest, or weight is a force that contacts, lines and
    buoyancy carry."""
    tanks: dict[of.Name, TankEntry] = pydantic.Field(default_factory=dict)
    """Tanks of the body, by name."""
    pumps: dict[of.Name, PumpEntry] = pydantic.Field(default_factory=dict)
    """Pumps between tanks or the sea, by name."""
    constant_inertia: pydantic.StrictBool = False
    """Whether mass and inertia stay as at the start while tanks are pumped, and only the weight
    changes."""
    draught: Annotated[float, Quantity("length", "m", "8 m", above=0)] | None = None
    """Draught over which the mean of a current with a profile acts. Without it, that of the hull in
    hydrostatics."""
    points: dict[of.Name, of.Point] = pydantic.Field(default_factory=dict)
    """Places in the body frame by name. Their motions are recorded.
    Example: {bow: [90 m, 0 m, 8 m]}."""

    @pydantic.model_validator(mode="before")
    @classmethod
    def _check_kind(cls, data: Any) -> Any:
        if isinstance(data, dict) and {"type", "body"} & data.keys():
            found_text = f"a force element, type {data.get('type')}"
            raise problem(found_text, "a body", 'move it below "forces:"')
        return data

    @pydantic.model_validator(mode="after")
    def _check_mass(self) -> Self:
        keys = ("radii_of_gyration", "inertia", "mass_matrix")
        given = self.keys_with_value(*keys)
        if self.lightship is not None:
            twice = [*self.keys_with_value("mass", "centre_of_gravity"), *given]
            if twice:
                found_text = f"lightship and {', '.join(twice)}"
                raise problem(
                    found_text, "one of them: of the ship without, or with what is in tanks"
                )
            return self
        if self.mass is None:
            raise problem('no key "mass"', "it, or lightship")
        if len(given) > 1 or (not given and ROTATION_DOFS & set(self.dofs)):
            raise problem(" and ".join(given) or "none", f"one of {', '.join(keys)}")
        if self.mass_matrix is not None:
            self._check_mass_matrix(np.array(self.mass_matrix))
        return self

    def _check_mass_matrix(self, matrix: np.ndarray) -> None:
        assert self.mass is not None
        wanted = np.zeros((6, 6))
        wanted[:3, :3] = self.mass * np.eye(3)
        wanted[3:, 3:] = matrix[3:, 3:]
        if not np.allclose(matrix, wanted, rtol=1e-6, atol=1e-6 * self.mass):
            raise problem(
                "a mass_matrix that is not of this mass about its centre of gravity",
                f"{self.mass:g} kg in surge, sway and heave, not coupled to the rotations",
                "refer it to centre_of_gravity, or give inertia instead",
            )

    @pydantic.model_validator(mode="after")
    def _check_place(self) -> Self:
        files = files_of(self.hydrodynamics)
        if files and self.lightship is None and self.centre_of_gravity is None:
            raise problem("no centre_of_gravity", "one, in the database's frame")
        if not files and self.database_body != 1:
            raise problem("database_body and no database", "both, or none")
        if not files and self.database_checksum is not None:
            raise problem("database_checksum and no database", "both, or none")
        constant = isinstance(self.hydrodynamics, scene.Coefficients)
        if constant and not isinstance(self.radiation, scene.AutomaticRadiation):
            found_text = f"radiation: {self.radiation.model} of coefficients, which are constant"
            raise problem(found_text, "no radiation there, or a database")
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


class OutputEntry(SchemaModel):
    """What is recorded: every ``step``, a multiple of the solver's, and with ``states`` all that
    another run needs to start from there; with ``impulses`` what `hydrosim show --why` needs;
    ``accelerations``; the elevation at ``wave_probes``, x and y by name; the ``clearances`` of
    named points by name."""

    step: of.Period | None = None
    """Time between records, a multiple of the step of the solver. Without it about 0.5 s."""
    states: pydantic.StrictBool = False
    """Whether all states are recorded, so that another run can start from any record."""
    impulses: pydantic.StrictBool = False
    """Whether impulses of forces are recorded, for hydrosim show --why."""
    accelerations: pydantic.StrictBool = False
    """Whether accelerations are recorded."""
    wave_probes: dict[of.Name, of.Position] = pydantic.Field(default_factory=dict)
    """Places x, y by name where the wave elevation is recorded. Example: {bow: [90 m, 0 m]}."""
    clearances: dict[of.Name, scene.Clearance] = pydantic.Field(default_factory=dict)
    """Distances by name that are recorded."""


def _beginning_form(value: object) -> str:
    return "at_rest" if isinstance(value, str) else "of a run"


Begin = Annotated[
    Annotated[Literal["at_rest"], pydantic.Tag("at_rest")]
    | Annotated[scene.Start, pydantic.Tag("of a run")],
    pydantic.Discriminator(_beginning_form),
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
    output: OutputEntry = OutputEntry()
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
    def output_step(self) -> float:
        """Time between records [s]: about `OUTPUT_STEP` if the case does not say."""
        step = self.solver.step
        return self.output.step or step * max(1, round(OUTPUT_STEP / step))

    @property
    def water(self) -> EnvironmentEntry:
        """The environment, or what is taken for it."""
        return self.environment or EnvironmentEntry()
