"""The case file as pydantic models: which keys there are, what they hold, what must agree.

All values are in SI and radians once validated. What concerns several parts of a case at a time is
in `hydrosim.case.checks`.
"""

from __future__ import annotations

import re
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
    model_validator,
)

from hydrosim.case.signals import Forces, NormalOverTime
from hydrosim.case.waves import Waves
from hydrosim.documents import quantities as of
from hydrosim.documents.quantities import Strict, as_matrix
from hydrosim.documents.units import problem
from hydrosim.dofs import DOFS
from hydrosim.scene import Kinematics, LinearScenes, Method, Place, SecondOrder, Symmetry, Unstable

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
TURNS = frozenset(DOFS[3:])


def _named(name: str) -> str:
    if not NAME.fullmatch(name):
        raise problem(f'the name "{name}"', "letters, digits and _, beginning with a letter")
    return name


def _in_order(dofs: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(dofs)) != len(dofs) or not set(dofs) <= set(DOFS):
        raise problem(f"[{', '.join(dofs)}]", f"any of {', '.join(DOFS)}, each once")
    return tuple(sorted(dofs, key=DOFS.index))


Name = Annotated[str, AfterValidator(_named)]
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
    headings: Place = Place.MEAN
    position: Place = Place.MEAN


class Tabulated(Strict):
    """What all retardation functions have: how long they are, and the step of their tables."""

    length: of.Period = 80.0
    step: of.Period = 0.1

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        if self.length < 2.0 * self.step:
            found = f"length {self.length:g} s, step {self.step:g} s"
            raise problem(found, "a length of two steps or more")
        return self


class StateSpaceRadiation(Tabulated):
    """A rational fit of the retardation functions."""

    model: Literal["state_space"]
    tolerance: of.Tolerance = 1e-3


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
    StateSpaceRadiation | ConvolutionRadiation | ConstantRadiation | NoRadiation,
    Discriminator("model"),
]


class Body(Strict):
    """A rigid body; dry if it has no hydrodynamics."""

    mass: of.Mass
    hydrodynamics: StrictStr | None = None
    database_body: Annotated[int, Field(strict=True, ge=1)] = 1
    centre_of_gravity: of.Point | None = None
    location: of.Position = (0.0, 0.0)
    radii_of_gyration: of.Vector[of.Radius] | None = None
    inertia: of.InertiaMatrix | None = None
    mass_matrix: of.MassMatrix | None = None
    dofs: Dofs = DOFS
    initial: Initial = Initial()
    radiation: Annotated[Radiation, BeforeValidator(_with_model)] = StateSpaceRadiation(
        model="state_space"
    )
    wave_forces: WaveForces = WaveForces()

    @model_validator(mode="after")
    def _check_mass(self) -> Self:
        keys = ("radii_of_gyration", "inertia", "mass_matrix")
        given = self.given(*keys)
        if len(given) > 1 or (not given and TURNS & set(self.dofs)):
            raise problem(" and ".join(given) or "none", f"one of {', '.join(keys)}")
        if self.mass_matrix is not None:
            self._check_mass_matrix(np.array(self.mass_matrix))
        return self

    def _check_mass_matrix(self, matrix: np.ndarray) -> None:
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
        if self.hydrodynamics is not None and self.centre_of_gravity is None:
            raise problem("no centre_of_gravity", "one, in the database's frame")
        if self.hydrodynamics is None and "database_body" in self.model_fields_set:
            raise problem("database_body and no hydrodynamics", "both, or none")
        return self

    @model_validator(mode="after")
    def _check_start(self) -> Self:
        speeds = zip(DOFS, self.initial.velocity, strict=True)
        moving = [dof for dof, speed in speeds if speed and dof not in self.dofs]
        if moving:
            raise problem(f"an initial velocity in {', '.join(moving)}", "0 where `dofs` has none")
        return self


class LinearMooring(Strict):
    """Spring and damper at a body's centre of gravity: per DOF, or full 6 x 6 matrices; the
    stiffness may be what gives a DOF a natural period."""

    type: Literal["linear_mooring"]
    body: StrictStr
    stiffness: of.StiffnessMatrix | None = None
    natural_period: of.PerDof[of.Period, of.Period] | None = None
    damping: of.DampingMatrix | None = None
    damping_ratio: of.PerDof[of.Factor, of.Factor] | None = None

    @property
    def diagonal(self) -> tuple[np.ndarray, np.ndarray]:
        """Stiffness and natural period (6,) per DOF, 0 where none is given."""
        stiffness = np.zeros(6) if self.stiffness is None else np.diag(as_matrix(self.stiffness))
        period = np.zeros(6) if self.natural_period is None else self.natural_period.values()
        return stiffness, np.array(period)

    @model_validator(mode="after")
    def _check_stiffness(self) -> Self:
        if self.stiffness is None and self.natural_period is None:
            raise problem("no stiffness", "stiffness, natural_period, or both")
        twice = [dof for dof, k, t in zip(DOFS, *self.diagonal, strict=True) if k and t]
        if twice:
            found = f"both stiffness and natural_period in {', '.join(twice)}"
            raise problem(found, "one of them in each DOF")
        return self

    @model_validator(mode="after")
    def _check_damping(self) -> Self:
        if self.damping is not None and self.damping_ratio is not None:
            raise problem("damping and damping_ratio", "one of them, or none", "remove one")
        if self.damping_ratio is not None:
            ratios = zip(DOFS, self.damping_ratio.values(), *self.diagonal, strict=True)
            without = [dof for dof, ratio, k, period in ratios if ratio and not (k or period)]
            if without:
                raise problem(
                    f"a damping_ratio in {', '.join(without)} where stiffness is 0",
                    "stiffness there (the ratio is to critical damping on it)",
                    "give damping instead",
                )
        return self


class LinearDamping(Strict):
    """Damping in the body's axes: per DOF, a full 6 x 6 matrix, or of critical."""

    type: Literal["linear_damping"]
    body: StrictStr
    damping: of.DampingMatrix | None = None
    damping_ratio: of.PerDof[of.Factor, of.Factor] | None = None
    relative_to_current: StrictBool = False

    @model_validator(mode="after")
    def _check_damping(self) -> Self:
        given = self.given("damping", "damping_ratio")
        if len(given) != 1:
            raise problem(" and ".join(given) or "none", "either damping or damping_ratio")
        return self


class QuadraticDamping(Strict):
    """Damping with the squared velocity, in the body's axes: per DOF, or a full 6 x 6 matrix."""

    type: Literal["quadratic_damping"]
    body: StrictStr
    damping: of.QuadraticMatrix


class StreamLoad(Strict):
    """Load by coefficients over the heading of a stream: all round, or from 0 to 180 deg for a body
    that is its own mirror image."""

    body: StrictStr
    point: of.Point = (0.0, 0.0, 0.0)
    headings: of.Headings
    surge: of.StreamForces | None = None
    sway: of.StreamForces | None = None
    yaw: of.StreamMoments | None = None

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        given = self.given("surge", "sway", "yaw")
        if not given:
            raise problem("no coefficients", "those of one or more of surge, sway, yaw")
        for dof in given:
            if len(getattr(self, dof)) != len(self.headings):
                found = f"{len(getattr(self, dof))} values in {dof} and {len(self.headings)}"
                raise problem(f"{found} in headings", "a value for each heading")
        self._check_ends()
        return self

    def _check_ends(self) -> None:
        if not self.is_half:
            return
        for dof in self.given("sway", "yaw"):
            first, *_, last = getattr(self, dof)
            if first or last:
                found = f"{first:g} at 0 and {last:g} at 180 deg in {dof}"
                expected = "0 at both, as for a body that is its own mirror image"
                raise problem(found, expected, "give the headings of the whole circle")

    @property
    def is_half(self) -> bool:
        """True if the headings are those of half a circle."""
        return self.headings[-1] <= np.pi * (1.0 + 1e-9)


class CurrentLoad(StreamLoad):
    """Load of the current."""

    type: Literal["current_load"]


class WindLoad(StreamLoad):
    """Load of the wind."""

    type: Literal["wind_load"]


class AppliedForce(Strict):
    """A force and moment on a point of a body over time; lists are over the element's ``time``."""

    type: Literal["applied_force"]
    body: StrictStr
    frame: Literal["earth", "body"] = "earth"
    point: of.Point = (0.0, 0.0, 0.0)
    time: of.Times | None = None
    force: Forces

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        forces = zip(DOFS, self.force.values(absent=None), strict=True)
        lists = {dof: values for dof, values in forces if isinstance(values, tuple)}
        count = len(self.time or (0.0,))
        for dof, values in lists.items():
            if len(values) != count:
                raise problem(
                    f"{len(values)} values in force.{dof} and {count} in time",
                    "a value at each time, or one value and no time",
                )
        if self.time and not lists:
            raise problem("time and no list over it", "a list of forces, or no time")
        return self


class Plane(Strict):
    """The other side of a contact, in the earth frame or in that of a body."""

    point: of.Point
    normal: of.Direction
    body: StrictStr | None = None

    @model_validator(mode="after")
    def _check_normal(self) -> Self:
        if not any(self.normal):
            raise problem("the normal [0, 0, 0]", "a direction", "point it to the free side")
        return self


class Normal(Strict):
    """Normal force of a fender; ``total`` values are shared by the points."""

    stiffness: of.Stiffness | None = None
    compression: of.Compressions | None = None
    force: of.NormalForces | None = None
    prescribed: NormalOverTime | None = None
    damping: of.Damping = 0.0
    total: StrictBool = False

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        given = self.given("stiffness", "compression", "force", "prescribed")
        if given not in (["stiffness"], ["compression", "force"], ["prescribed"]):
            expected = "stiffness, or compression and force, or prescribed"
            raise problem(" and ".join(given) or "no curve", expected)
        if self.prescribed and self.damping:
            raise problem("prescribed and damping", "one of them")
        if self.compression and self.force and len(self.compression) != len(self.force):
            found = f"{len(self.compression)} values in compression and {len(self.force)} in force"
            raise problem(found, "a force for each compression")
        if self.force and not self.force[-1]:
            raise problem("no force at any compression", "one that rises")
        return self


def _check_coefficients(static: float, kinetic: float) -> None:
    if static < kinetic:
        raise problem(f"static {static:g}, kinetic {kinetic:g}", "static >= kinetic")


class LoadPowers(Strict):
    """Powers of the normal force over a ``reference`` that the coefficients go with; a ``total``
    reference is shared by the points, as the coefficients are."""

    reference: of.ReferenceForce
    stiffness: of.Power
    damping: of.Power = 0.0
    slip_damping: of.Power = 0.0

    @model_validator(mode="after")
    def _check_powers(self) -> Self:
        if max(self.damping, self.slip_damping) > self.stiffness:
            found = f"damping {self.damping:g}, slip_damping {self.slip_damping:g}"
            expected = f"no more than that of the stiffness, {self.stiffness:g}"
            raise problem(found, expected, "else the node stiffens without bound as the load goes")
        return self


class StickSlip(Strict):
    """The thesis' new friction model; ``total`` values are shared by the points."""

    law: Literal["stick_slip"]
    static: of.Factor
    kinetic: of.Factor
    stiffness: of.Stiffness
    damping: of.Damping = 0.0
    slip_damping: of.Damping = 0.0
    load: LoadPowers | None = None
    total: StrictBool = False

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        if self.load and not self.damping + self.slip_damping:
            found = "load without damping and slip_damping"
            raise problem(found, "one of the latter above 0, or no load")
        return self


class Coulomb(Strict):
    """Rigid friction: what sticks does not move."""

    law: Literal["coulomb"]
    static: of.Factor
    kinetic: of.Factor

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        _check_coefficients(self.static, self.kinetic)
        return self


class FrictionSlope(Strict):
    """aNySIM's friction model; a ``total`` slope is shared by the points."""

    law: Literal["friction_slope"]
    coefficient: of.Factor
    slope: of.Slope
    total: StrictBool = False


class Frictionless(Strict):
    """No friction; the other keys may stay, so that one word turns the friction of a case off."""

    model_config = ConfigDict(extra="ignore")
    law: Literal["none"]


Friction = Annotated[StickSlip | Coulomb | FrictionSlope | Frictionless, Discriminator("law")]


class Fender(Strict):
    """Points of a body against a plane."""

    type: Literal["fender"]
    body: StrictStr
    points: Annotated[tuple[of.Point, ...], AfterValidator(of.some)]
    plane: Plane
    normal: Normal
    friction: Friction

    @model_validator(mode="after")
    def _check_rate_free(self) -> Self:
        law = self.friction
        rate_free = isinstance(law, StickSlip) and not law.damping + law.slip_damping
        if rate_free and self.normal.damping:
            found = "normal.damping and friction without damping and slip_damping"
            raise problem(found, "one of the latter above 0, or no normal.damping")
        return self


class Curve(Strict):
    """Tension of a spring over its extension."""

    extension: of.Extensions
    tension: of.NormalForces

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        if len(self.extension) != len(self.tension):
            found = f"{len(self.extension)} values in extension and {len(self.tension)} in tension"
            raise problem(found, "a tension for each extension")
        if not self.tension[-1]:
            raise problem("no tension at any extension", "one that rises")
        return self


class Spring(Strict):
    """A line from a point of a body to an anchor, on the earth or on another body."""

    type: Literal["spring"]
    body: StrictStr
    point: of.Point
    anchor: of.Point
    anchor_body: StrictStr | None = None
    length: of.LineLength
    stiffness: of.Stiffness | None = None
    curve: Curve | None = None
    damping: of.Damping = 0.0

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        given = self.given("stiffness", "curve")
        if len(given) != 1:
            raise problem(" and ".join(given) or "no curve", "either stiffness or curve")
        first = self.curve.extension[0] if self.curve else 0.0
        if self.length + first <= 0.0:
            found = f"length {self.length:g} m and a first extension of {first:g} m"
            expected = "a line that is slack where its ends meet"
            raise problem(found, expected, "begin the curve above -length")
        return self


Element = Annotated[
    LinearMooring
    | AppliedForce
    | Fender
    | Spring
    | LinearDamping
    | QuadraticDamping
    | CurrentLoad
    | WindLoad,
    Discriminator("type"),
]


class Tolerance(Strict):
    """Error per step that an adaptive method keeps to."""

    relative: of.Tolerance = 1e-6
    position: of.SmallLength = 1e-6
    angle: of.SmallAngle = 1e-8


class Solver(Strict):
    """How time is stepped."""

    method: Method = Method.RK4
    step: of.Period = 0.1
    tolerance: Tolerance = Tolerance()
    kinematics: Kinematics = Kinematics.EXACT
    events: StrictBool = True
    unstable: Unstable = Unstable.WARN
    linear: LinearScenes = LinearScenes.EXACT
    symmetry: Symmetry = Symmetry.USE


class Output(Strict):
    """What is recorded: every ``step``, a multiple of the solver's, and with ``states`` all that
    another run needs to start from there; the elevation at ``wave_probes``, x and y by name."""

    step: of.Period | None = None
    states: StrictBool = False
    wave_probes: dict[Name, of.Position] = Field(default_factory=dict)


class Start(Strict):
    """A run to start from, at a time of it or at its end; see `hydrosim.scene.Start`."""

    run: StrictStr
    time: of.Instant | None = None


class CaseFile(Strict):
    """A whole case file."""

    title: StrictStr
    duration: of.Period
    environment: Environment | None = None
    bodies: Annotated[dict[Name, Body], AfterValidator(of.some)]
    forces: dict[Name, Element] = Field(default_factory=dict)
    solver: Solver = Solver()
    output: Output = Output()
    initial: Start | None = None
