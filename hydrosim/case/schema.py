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
from hydrosim.case.elements.fender import Plane
from hydrosim.case.hydrodynamics import Coefficients, Hydrodynamics, files_of
from hydrosim.case.hydrostatics import Hydrostatics
from hydrosim.case.tanks import Lightship, Pump, Tank
from hydrosim.case.waves import Waves
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import Strict
from hydrosim.documents.units import Quantity, problem
from hydrosim.dofs import DOFS
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
from hydrosim.scene.radiation import LENGTH
from hydrosim.scene.solver import ACCURACIES, ACCURACY

TURNS = frozenset(DOFS[3:])
OUTPUT_STEP = 0.5  # s, about: if the case does not say


def _in_order(dofs: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(dofs)) != len(dofs) or not set(dofs) <= set(DOFS):
        raise problem(f"[{', '.join(dofs)}]", f"any of {', '.join(DOFS)}, each once")
    return tuple(sorted(dofs, key=DOFS.index))


Dofs = Annotated[tuple[StrictStr, ...], AfterValidator(_in_order)]


class Stream(Strict):
    """Steady current or wind, and where it goes to."""

    speed: of.FlowSpeed
    heading: of.Angle = 0.0


class Environment(Strict):
    """Water, the waves on it, one mapping or a list of them, current and wind."""

    water_depth: of.Depth = np.inf
    water_density: of.Density = 1025.0
    gravity: of.Gravity = 9.81
    waves: Waves = ()
    current: Stream | None = None
    wind: Stream | None = None


class Initial(Strict):
    """Offsets from the place at rest, and velocities, at the start."""

    position: of.Offsets = (0.0,) * 6
    velocity: of.Velocities = (0.0,) * 6


class WaveForces(Strict):
    """Which wave loads act."""

    first_order: StrictBool = True
    second_order: SecondOrder = SecondOrder.NONE
    sum_frequency: StrictBool = False
    headings: Place = Place.AUTOMATIC
    position: Place = Place.AUTOMATIC


class Tabulated(Strict):
    """What all retardation functions have: how long they are, and the step of their tables."""

    length: of.Period | None = None
    step: of.Period = 0.1

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        length = LENGTH if self.length is None else self.length
        if length < 2.0 * self.step:
            found = f"length {length:g} s, step {self.step:g} s"
            raise problem(found, "a length of two steps or more")
        return self


class AutomaticRadiation(Tabulated):
    """States where their fit holds the tolerance, else the memory integral itself."""

    model: Literal["automatic"]
    tolerance: of.Tolerance = 3e-4


class StateSpaceRadiation(Tabulated):
    """A rational fit of the retardation functions."""

    model: Literal["state_space"]
    tolerance: of.Tolerance = 3e-4


class ConvolutionRadiation(Tabulated):
    """The memory integral itself."""

    model: Literal["convolution"]


class ConstantRadiation(Strict):
    """Added mass and damping of one period."""

    model: Literal["constant"]
    period: of.Period


class NoRadiation(Strict):
    """No radiation; the other keys may stay, so that one word turns it off."""

    model_config = ConfigDict(extra="ignore")
    model: Literal["none"]


def _with_model(value: Any) -> Any:
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
    _with_model,
    json_schema_input_type=Radiation | Literal["automatic", "state_space", "convolution", "none"],
)


class Body(Strict):
    """A rigid body; dry if it has no hydrodynamics."""

    mass: of.Mass | None = None
    lightship: Lightship | None = None
    hydrodynamics: Hydrodynamics | None = None
    hydrostatics: Hydrostatics = "matrix"
    database_body: Annotated[int, Field(strict=True, ge=1)] = 1
    database_checksum: StrictStr | None = None
    centre_of_gravity: of.Point | None = None
    location: of.Position = (0.0, 0.0)
    heading: of.Angle = 0.0
    radii_of_gyration: of.Radii | None = None
    inertia: of.InertiaMatrix | None = None
    mass_matrix: of.MassMatrix | None = None
    dofs: Dofs = DOFS
    initial: Initial = Initial()
    radiation: Annotated[Radiation, _MODEL] = AutomaticRadiation(model="automatic")
    wave_forces: WaveForces = WaveForces()
    weight: Weight | None = None
    tanks: dict[of.Name, Tank] = Field(default_factory=dict)
    pumps: dict[of.Name, Pump] = Field(default_factory=dict)
    constant_inertia: StrictBool = False
    points: dict[of.Name, of.Point] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check_mass(self) -> Self:
        keys = ("radii_of_gyration", "inertia", "mass_matrix")
        given = self.given(*keys)
        if self.lightship is not None:
            twice = [*self.given("mass", "centre_of_gravity"), *given]
            if twice:
                found = f"lightship and {', '.join(twice)}"
                raise problem(found, "one of them: of the ship without, or with what is in tanks")
            return self
        if self.mass is None:
            raise problem('no key "mass"', "it, or lightship")
        if len(given) > 1 or (not given and TURNS & set(self.dofs)):
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
            found = f"radiation: {self.radiation.model} of coefficients, which are constant"
            raise problem(found, "no radiation there, or a database")
        return self

    @model_validator(mode="after")
    def _check_start(self) -> Self:
        speeds = zip(DOFS, self.initial.velocity, strict=True)
        moving = [dof for dof, speed in speeds if speed and dof not in self.dofs]
        if moving:
            raise problem(f"an initial velocity in {', '.join(moving)}", "0 where `dofs` has none")
        return self


class Tolerance(Strict):
    """Error per second of a run that an adaptive method keeps to in each step."""

    relative: of.Tolerance = 1e-6
    position: of.SmallLength = 1e-6
    angle: of.SmallAngle = 1e-8


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


class Solver(Strict):
    """How time is stepped. The ``tolerance`` of ``automatic`` is the error of motions, of their
    range; that of adaptive methods is the error of each step."""

    model_config = ConfigDict(json_schema_extra=_OF_STEPS)

    method: Method = Method.RK4
    step: of.Period = 0.1
    tolerance: EitherTolerance = Tolerance()
    kinematics: Kinematics = Kinematics.EXACT
    events: StrictBool = True
    unstable: Unstable = Unstable.WARN
    linear: LinearScenes = LinearScenes.EXACT
    symmetry: Symmetry = Symmetry.USE

    @model_validator(mode="before")
    @classmethod
    def _default_tolerance(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("method") == Method.AUTOMATIC:
            return {"tolerance": ACCURACY, **data}
        return data

    @model_validator(mode="after")
    def _check_tolerance(self) -> Self:
        of_steps = isinstance(self.tolerance, Tolerance)
        if self.method == Method.AUTOMATIC and of_steps:
            found = "tolerances of each step, which method: automatic chooses itself"
            raise problem(found, "one number, the error of motions of their range: 1e-4")
        if self.method != Method.AUTOMATIC and not of_steps:
            found = f"tolerance: {self.tolerance:g} of method: {self.method}"
            raise problem(found, "method: automatic, or tolerance: {relative: 1e-6, ...}")
        return self


class Clearance(Strict):
    """The distance of a named point, "bow of barge", from another or from a plane."""

    of: StrictStr
    to: StrictStr | None = None
    plane: Plane | None = None

    @model_validator(mode="after")
    def _check_other(self) -> Self:
        if len(given := self.given("to", "plane")) != 1:
            raise problem(" and ".join(given) or "nothing to measure from", "either to or plane")
        if self.to == self.of:
            raise problem(f"the distance of {self.of} from itself", "two points")
        if self.plane and self.plane.corners:
            found = "a plane with corners"
            raise problem(found, "one without: a clearance is that from the whole plane")
        return self


class Output(Strict):
    """What is recorded: every ``step``, a multiple of the solver's, and with ``states`` all that
    another run needs to start from there; with ``impulses`` what `hydrosim explain` needs;
    ``accelerations``; the elevation at ``wave_probes``, x and y by name; the ``clearances`` of
    named points by name."""

    step: of.Period | None = None
    states: StrictBool = False
    impulses: StrictBool = False
    accelerations: StrictBool = False
    wave_probes: dict[of.Name, of.Position] = Field(default_factory=dict)
    clearances: dict[of.Name, Clearance] = Field(default_factory=dict)


class Start(Strict):
    """A run to start from, at a time of it or at its end; see `hydrosim.scene.Start`."""

    run: StrictStr
    time: of.Instant | None = None


def _begins(value: object) -> str:
    return "at_rest" if isinstance(value, str) else "of a run"


Begin = Annotated[
    Annotated[Literal["at_rest"], Tag("at_rest")] | Annotated[Start, Tag("of a run")],
    Discriminator(_begins),
]


class CaseFile(Strict):
    """A whole case file."""

    title: StrictStr
    duration: of.Period
    environment: Environment | None = None
    bodies: Annotated[dict[of.Name, Body], AfterValidator(of.some)]
    forces: dict[of.Name, AnyElement] = Field(default_factory=dict)
    solver: Solver = Solver()
    output: Output = Output()
    initial: Begin | None = None
    accept: tuple[Question, ...] = ()
    criteria: dict[of.Name, RunCriterion] = Field(default_factory=dict)
    report: Report = Report()

    @model_validator(mode="after")
    def _check_rest(self) -> Self:
        moving = [name for name, body in self.bodies.items() if any(body.initial.velocity)]
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
