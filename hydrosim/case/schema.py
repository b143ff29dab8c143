"""The case file as pydantic models: which keys there are, what they hold, what must agree.

All values are in SI and radians once validated. What concerns several parts of a case at a time is
in `hydrosim.case.checks`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictBool,
    StrictStr,
    Tag,
    model_validator,
)
from pydantic.config import JsonDict

from hydrosim.case.criteria import Report, RunCriterion
from hydrosim.case.elements import AnyElement
from hydrosim.case.hydrodynamics import Coefficients, Hydrodynamics, Hydrostatics, files_of
from hydrosim.case.joints import AnyJoint
from hydrosim.case.streams import Current, Wind
from hydrosim.case.tanks import Lightship, Pump, Tank
from hydrosim.case.waves import Waves
from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.messages import suggestion
from hydrosim.files.quantities import SchemaModel
from hydrosim.files.units import Quantity, problem
from hydrosim.scene import (
    Kinematics,
    LinearScenes,
    Method,
    Place,
    Question,
    SecondOrder,
    Symmetry,
    Unstable,
    Weight,
)
from hydrosim.scene.contacts import Plane
from hydrosim.scene.hydrodynamics import LENGTH
from hydrosim.scene.scene import ACCURACIES, ACCURACY

ROTATION_DOFS = frozenset(DOFS[3:])
OUTPUT_STEP = 0.5  # s, about: if the case does not say


def _order_dofs(dofs: tuple[str, ...]) -> tuple[str, ...]:
    unknown = [dof for dof in dofs if dof not in DOFS]
    if unknown or len(set(dofs)) != len(dofs):
        remedy = suggestion(unknown[0], DOFS) if unknown else ""
        raise problem(f"[{', '.join(dofs)}]", f"any of {', '.join(DOFS)}, each once", remedy)
    return tuple(sorted(dofs, key=DOFS.index))


Dofs = Annotated[tuple[StrictStr, ...], AfterValidator(_order_dofs)]


class Environment(SchemaModel):
    """Water, the waves on it, one mapping or a list of them, current and wind."""

    water_depth: of.Depth = np.inf
    """Depth of the water, or infinite."""
    water_density: of.Density = 1025.0
    """Density of the water."""
    gravity: of.Gravity = 9.81
    """Acceleration of gravity."""
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


class WaveForces(SchemaModel):
    """Which wave loads act."""

    first_order: StrictBool = True
    """Whether first-order wave loads act."""
    second_order: SecondOrder = SecondOrder.NONE
    """Approximation of the slow second-order wave loads."""
    sum_frequency: StrictBool = False
    """Whether second-order loads at the sums of wave frequencies act."""
    headings: Place = Place.AUTOMATIC
    """Whether wave loads follow the yaw of the body: mean (its heading at rest), slow or
    instantaneous."""
    position: Place = Place.AUTOMATIC
    """Whether wave loads follow the place of the body: mean (its place at rest), slow or
    instantaneous."""


class Tabulated(SchemaModel):
    """What all retardation functions have: how long they are, and the step of their tables."""

    length: of.Period | None = None
    """Length of the retardation functions. Without it they are 100 s long, or as long as the
    frequencies of the database resolve."""
    step: of.Period = 0.1
    """Time step of the tables of the retardation functions. It is not the step of the run."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        length = LENGTH if self.length is None else self.length
        if length < 2.0 * self.step:
            found_text = f"length {length:g} s, step {self.step:g} s"
            raise problem(found_text, "a length of two steps or more")
        return self


class AutomaticRadiation(Tabulated):
    """States where their fit holds the tolerance, else the memory integral itself."""

    model: Literal["automatic"]
    """States where their fit is within the tolerance, the memory integral elsewhere."""
    tolerance: of.Tolerance = 3e-4
    """Largest error of the fit, relative to the largest diagonal entries."""


class StateSpaceRadiation(Tabulated):
    """A rational fit of the retardation functions."""

    model: Literal["state_space"]
    """A rational fit of the retardation functions."""
    tolerance: of.Tolerance = 3e-4
    """Largest error of the fit, relative to the largest diagonal entries."""


class ConvolutionRadiation(Tabulated):
    """The memory integral itself."""

    model: Literal["convolution"]
    """The memory integral itself."""


class ConstantRadiation(SchemaModel):
    """Added mass and damping of one period."""

    model: Literal["constant"]
    """Added mass and damping of one period, without memory."""
    period: of.Period
    """Wave period whose added mass and damping are used."""


class NoRadiation(SchemaModel):
    """No radiation; the other keys may stay, so that one word turns it off."""

    model_config = ConfigDict(extra="ignore")
    model: Literal["none"]
    """No radiation forces."""


def _require_model(value: Any) -> Any:
    return {"model": value} if isinstance(value, str) else value


Radiation = Annotated[
    AutomaticRadiation
    | StateSpaceRadiation
    | ConvolutionRadiation
    | ConstantRadiation
    | NoRadiation,
    Discriminator("model"),
]


_MODEL = BeforeValidator(
    _require_model,
    json_schema_input_type=Radiation | Literal["automatic", "state_space", "convolution", "none"],
)


class Body(SchemaModel):
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
    database_body: Annotated[int, Field(strict=True, ge=1)] = 1
    """Number of this body in a database of several bodies. Example: 2."""
    database_checksum: StrictStr | None = None
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
    radiation: Annotated[Radiation, _MODEL] = AutomaticRadiation(model="automatic")
    """Model of the radiation forces: a name, or a mapping with a model and its settings."""
    wave_forces: WaveForces = WaveForces()
    """Wave loads that act on the body."""
    weight: Weight | None = None
    """Whether weight and buoyancy balance at rest, or weight is a force that contacts, lines and
    buoyancy carry."""
    tanks: dict[of.Name, Tank] = Field(default_factory=dict)
    """Tanks of the body, by name."""
    pumps: dict[of.Name, Pump] = Field(default_factory=dict)
    """Pumps between tanks or the sea, by name."""
    constant_inertia: StrictBool = False
    """Whether mass and inertia stay as at the start while tanks are pumped, and only the weight
    changes."""
    draught: Annotated[float, Quantity("length", "m", "8 m", above=0)] | None = None
    """Draught over which the mean of a current with a profile acts. Without it, that of the hull in
    hydrostatics."""
    points: dict[of.Name, of.Point] = Field(default_factory=dict)
    """Places in the body frame by name. Their motions are recorded.
    Example: {bow: [90 m, 0 m, 8 m]}."""

    @model_validator(mode="before")
    @classmethod
    def _check_kind(cls, data: Any) -> Any:
        if isinstance(data, dict) and {"type", "body"} & data.keys():
            found_text = f"a force element, type {data.get('type')}"
            raise problem(found_text, "a body", 'move it below "forces:"')
        return data

    @model_validator(mode="after")
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

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        files = files_of(self.hydrodynamics)
        if files and self.lightship is None and self.centre_of_gravity is None:
            raise problem("no centre_of_gravity", "one, in the database's frame")
        if not files and self.database_body != 1:
            raise problem("database_body and no database", "both, or none")
        if not files and self.database_checksum is not None:
            raise problem("database_checksum and no database", "both, or none")
        constant = isinstance(self.hydrodynamics, Coefficients)
        if constant and not isinstance(self.radiation, AutomaticRadiation):
            found_text = f"radiation: {self.radiation.model} of coefficients, which are constant"
            raise problem(found_text, "no radiation there, or a database")
        return self

    @model_validator(mode="after")
    def _check_start(self) -> Self:
        speeds = zip(DOFS, self.initial.velocity, strict=True)
        moving = [dof for dof, speed in speeds if speed and dof not in self.dofs]
        if moving:
            raise problem(f"an initial velocity in {', '.join(moving)}", "0 where `dofs` has none")
        return self


class Tolerance(SchemaModel):
    """Error per second of a run that an adaptive method keeps to in each step."""

    relative: of.Tolerance = 1e-6
    """Relative error per second."""
    position: of.SmallLength = 1e-6
    """Absolute error of positions per second."""
    angle: of.SmallAngle = 1e-8
    """Absolute error of angles per second."""


def _form_of_tolerance(value: object) -> str:
    return "of each step" if isinstance(value, dict | Tolerance) else "of motions"


MotionError = Annotated[
    float,
    Quantity("error of motions, of their range", "", "1e-4", None, *ACCURACIES),
]
EitherTolerance = Annotated[
    Annotated[Tolerance, Tag("of each step")] | Annotated[MotionError, Tag("of motions")],
    Discriminator(_form_of_tolerance),
]


_OF_STEPS: JsonDict = {
    "if": {
        "properties": {"method": {"not": {"const": Method.AUTOMATIC.value}}},
        "required": ["method"],
    },
    "then": {"properties": {"tolerance": {"type": "object"}}},
}


class Solver(SchemaModel):
    """How time is stepped. The ``tolerance`` of ``automatic`` is the error of motions, of their
    range; that of adaptive methods is the error of each step."""

    model_config = ConfigDict(json_schema_extra=_OF_STEPS)

    method: Method = Method.AUTOMATIC
    """Time integration method. The methods automatic, dopri5 and esdirk4 choose their own steps.
    If a step is given and no method, the method is rk4."""
    step: of.Period = 0.1
    """Time step. A method that chooses its own steps begins with it."""
    tolerance: EitherTolerance = ACCURACY
    """Error of motions relative to their range, of method automatic; a mapping of errors of each
    step, of dopri5 and esdirk4."""
    kinematics: Kinematics = Kinematics.EXACT
    """Whether rotations are exact or small angles throughout."""
    events: StrictBool = True
    """Whether steps end where a contact changes its mode. Without it results are for comparison
    only."""
    unstable: Unstable = Unstable.WARN
    """Whether a time step above the stable limit gives a warning or an error."""
    linear: LinearScenes = LinearScenes.EXACT
    """Whether a linear scene is propagated exactly or stepped as any other."""
    symmetry: Symmetry = Symmetry.USE
    """Whether a scene that is its own mirror image is solved in its plane of symmetry."""

    @model_validator(mode="after")
    def _set_defaults(self) -> Self:
        given = {*self.model_fields_set}
        defaults: dict[str, Any] = {}
        if "step" in given and "method" not in given:
            defaults["method"] = Method.RK4
        if {**vars(self), **defaults}["method"] != Method.AUTOMATIC and "tolerance" not in given:
            defaults["tolerance"] = Tolerance()
        vars(self).update(defaults)  # the keys that are given stay those of the file
        return self

    @model_validator(mode="after")
    def _check_tolerance(self) -> Self:
        of_steps = isinstance(self.tolerance, Tolerance)
        if self.method == Method.AUTOMATIC and of_steps:
            found_text = "tolerances of each step, which method: automatic chooses itself"
            raise problem(found_text, "one number, the error of motions of their range: 1e-4")
        if self.method != Method.AUTOMATIC and not of_steps:
            found_text = f"tolerance: {self.tolerance:g} of method: {self.method}"
            raise problem(found_text, "method: automatic, or tolerance: {relative: 1e-6, ...}")
        return self


class Clearance(SchemaModel):
    """The distance of a named point, "bow of barge", from another or from a plane."""

    of: StrictStr
    """Named point of a body. Example: bow of barge."""
    to: StrictStr | None = None
    """Named point of another body that the distance is measured to. Example: leg of topside."""
    plane: Plane | None = None
    """Plane that the distance is measured to."""

    @model_validator(mode="after")
    def _check_other(self) -> Self:
        if len(given := self.keys_with_value("to", "plane")) != 1:
            raise problem(" and ".join(given) or "nothing to measure from", "either to or plane")
        if self.to == self.of:
            raise problem(f"the distance of {self.of} from itself", "two points")
        if self.plane and self.plane.corners:
            found_text = "a plane with corners"
            raise problem(found_text, "one without: a clearance is that from the whole plane")
        return self


class Output(SchemaModel):
    """What is recorded: every ``step``, a multiple of the solver's, and with ``states`` all that
    another run needs to start from there; with ``impulses`` what `hydrosim explain` needs;
    ``accelerations``; the elevation at ``wave_probes``, x and y by name; the ``clearances`` of
    named points by name."""

    step: of.Period | None = None
    """Time between records, a multiple of the step of the solver. Without it about 0.5 s."""
    states: StrictBool = False
    """Whether all states are recorded, so that another run can start from any record."""
    impulses: StrictBool = False
    """Whether impulses of forces are recorded, for hydrosim explain."""
    accelerations: StrictBool = False
    """Whether accelerations are recorded."""
    wave_probes: dict[of.Name, of.Position] = Field(default_factory=dict)
    """Places x, y by name where the wave elevation is recorded. Example: {bow: [90 m, 0 m]}."""
    clearances: dict[of.Name, Clearance] = Field(default_factory=dict)
    """Distances by name that are recorded."""


class Start(SchemaModel):
    """A run to start from, at a time of it or at its end."""

    run: StrictStr
    """Result file of the run that this one continues. Example: first.nc."""
    time: of.Instant | None = None
    """Time of that run at which this one begins. Without it that is its end."""


def _beginning_form(value: object) -> str:
    return "at_rest" if isinstance(value, str) else "of a run"


Begin = Annotated[
    Annotated[Literal["at_rest"], Tag("at_rest")] | Annotated[Start, Tag("of a run")],
    Discriminator(_beginning_form),
]


class CaseFile(SchemaModel):
    """A whole case file."""

    title: StrictStr
    """Title of the case, for people. Example: Barge alongside in 1.5 m waves."""
    duration: of.Period
    """Length of the run."""
    environment: Environment | None = None
    """Water, waves, current and wind."""
    bodies: Annotated[dict[of.Name, Body], AfterValidator(of.require_entries)]
    """Rigid bodies by name."""
    forces: dict[of.Name, AnyElement] = Field(default_factory=dict)
    """Force elements by name: moorings, fenders, lines, damping, loads."""
    joints: dict[of.Name, AnyJoint] = Field(default_factory=dict)
    """Joints between bodies or to the earth, by name: hinges, balls, sliders, locks."""
    solver: Solver = Solver()
    """Time integration."""
    output: Output = Output()
    """Results that are recorded."""
    initial: Begin | None = None
    """Either at_rest, which starts in equilibrium, or a mapping with the run that this one
    continues."""
    accept: tuple[Question, ...] = ()
    """Names of the questions that are answered: their values are meant as they are."""
    criteria: dict[of.Name, RunCriterion] = Field(default_factory=dict)
    """Figures of the run with limits, by name."""
    report: Report = Report()
    """Title block of the report."""

    @model_validator(mode="before")
    @classmethod
    def _check_kind(cls, data: Any) -> Any:
        if isinstance(data, dict) and "case" in data and "bodies" not in data:
            raise problem("a study, with the key case", "a case", "run it by hydrosim sweep")
        return data

    @model_validator(mode="after")
    def _check_rest(self) -> Self:
        moving = [name for name, body in self.bodies.items() if any(body.initial.velocity)]
        moving += [name for name, joint in self.joints.items() if joint.moves]
        if self.initial == "at_rest" and moving:
            raise problem(f"initial: at_rest, and a velocity of {moving[0]}", "one of them")
        return self

    @property
    def begins(self) -> Start | None:
        """The run to start from, if there is one."""
        return self.initial if isinstance(self.initial, Start) else None

    @property
    def output_step(self) -> float:
        """Time between records [s]: about `OUTPUT_STEP` if the case does not say."""
        step = self.solver.step
        return self.output.step or step * max(1, round(OUTPUT_STEP / step))

    @property
    def water(self) -> Environment:
        """The environment, or what is taken for it."""
        return self.environment or Environment()
