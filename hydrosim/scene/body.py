"""A rigid body, its wave loads, and its tanks and pumps."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import (
    AfterValidator,
    Discriminator,
    Field,
    StrictBool,
    StrictStr,
    Tag,
    model_validator,
)

from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one
from hydrosim.files.messages import suggestion
from hydrosim.files.schema_class import PythonObject, ReadAs, SchemaClass, schema_class
from hydrosim.files.units import Quantity, problem
from hydrosim.scene.force import AtTime, Event, LevelReached, When, form_of
from hydrosim.scene.hydrodynamics import (
    AutomaticRadiation,
    BodyRadiation,
    ChangedDatabase,
    Coefficients,
    Family,
    Hull,
    Hydrodynamics,
)
from hydrosim.scene.plane import Plane

# Tanks, plans of their levels, and pumps.


@dataclass(frozen=True)
class Box:
    """A tank between two corners (3,) [m]; ``permeability`` is the fraction that fluid fills."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    permeability: float = 1.0


@dataclass(frozen=True, eq=False)
class TankTable:
    """A tank given by a table. At each ``level`` (n,) above its bottom [m], rising from 0, it has
    the ``volume`` (n,) of fluid [m^3], its ``centroid`` (n, 3), and the second moments xx, xy, yy
    of the free ``surface`` about its centroid (n, 3) [m^4]."""

    level: np.ndarray
    volume: np.ndarray
    centroid: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True, eq=False)
class TankMesh:
    """A tank inside the triangles ``corners`` (nt, 3, 3) [m] of a closed mesh, normals outward.
    ``permeability`` is the fraction that fluid fills; ``source`` names the mesh in messages."""

    corners: np.ndarray
    permeability: float = 1.0
    source: str = "a mesh"


TankShape = Box | TankTable | TankMesh


class FreeSurface(StrEnum):
    """Free surface of the fluid in a tank: level at all times, or fixed to the tank."""

    QUASI_STATIC = "quasi_static"
    FROZEN = "frozen"


@schema_class
class Plan(SchemaClass):
    """Levels at times; the flow between them is constant, from or to the sea. Before the first and
    after the last time there is none."""

    time: of.Times
    """Times that rise."""
    level: tuple[of.Level, ...]
    """Level of the tank at each time. Between them the flow is constant."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        if len(self.time) != len(self.level) or len(self.time) < 2:
            found_text = f"{len(self.time)} times and {len(self.level)} levels"
            raise problem(found_text, "two times or more, and a level at each")
        return self


@schema_class
class TankKeys(SchemaClass):
    """What a tank has, besides its shape."""

    density: of.Density = field(default=1025.0, kw_only=True)
    """Density of the fluid."""
    level: of.Level = field(default=0.0, kw_only=True)
    """Level of the fluid above the tank's bottom when the run starts."""
    free_surface: FreeSurface = field(default=FreeSurface.QUASI_STATIC, kw_only=True)
    """Whether the fluid's surface stays level, or is frozen to the tank."""
    plan: Plan | None = field(default=None, kw_only=True)
    """Levels at times, filled from or emptied to the sea."""


@schema_class
class Tank(TankKeys):
    """A tank of a body, in the database's frame."""

    positional: ClassVar[tuple[str, ...]] = (
        *("name", "shape", "level", "density", "free_surface", "plan"),
    )

    name: StrictStr
    """Name of the tank."""
    shape: Annotated[TankShape, PythonObject(TankShape)]
    """Its shape."""


def _flow_form(value: object) -> str:
    if isinstance(value, LevelReached) or (isinstance(value, dict) and "tank" in value):
        return "level"
    return form_of(value)


def _flow_end(end: Any) -> Any:
    """A start or a stop of a pump as a scene has it."""
    if isinstance(end, AtTime):
        return end.time
    return end.build() if isinstance(end, Event) else end


FlowEnd = Annotated[
    Annotated[of.Instant, Tag("time")]
    | Annotated[AtTime, Tag("mapping")]
    | Annotated[LevelReached, Tag("level")]
    | Annotated[Event, Tag("event")],
    Discriminator(_flow_form),
]


@schema_class
class PumpKeys(SchemaClass):
    """Moves fluid from its ``source`` to its ``target``: names of tanks of the body, or sea; from
    ``start`` to ``stop``, each a time, a level or an event."""

    source: StrictStr | None = field(kw_only=True)
    """Tank that fluid is taken from, or sea. Example: fore_sb."""
    target: StrictStr | None = field(kw_only=True)
    """Tank that fluid is pumped to, or sea. Example: sea."""
    rate: Annotated[float, Quantity("mass per time", "kg/s", "5000 tonne/hour", above=0)] = field(
        kw_only=True
    )
    """Mass of fluid per time."""
    start: Annotated[
        float | LevelReached | When, ReadAs(FlowEnd, (LevelReached, When), _flow_end)
    ] = field(default=0.0, kw_only=True)
    """Time, level or event at which the pump starts."""
    stop: Annotated[
        float | LevelReached | When | None,
        ReadAs(FlowEnd | None, (LevelReached, When), _flow_end),
    ] = field(default=None, kw_only=True)
    """Time, level or event at which the pump stops. Without it the pump stops when a tank is empty
    or full."""


@schema_class
class Pump(PumpKeys):
    """A pump of a body. Where ``source`` or ``target`` is None, it is the sea."""

    positional: ClassVar[tuple[str, ...]] = ("name", "rate", "source", "target", "start", "stop")

    name: StrictStr
    """Name of the pump."""


class SecondOrder(StrEnum):
    """Approximation of the slow second-order wave loads."""

    NONE = "none"
    MEAN_DRIFT = "mean_drift"
    NEWMAN = "newman"
    NEWMAN_SQUARE_ROOT = "newman_square_root"
    QTF = "qtf"


class Place(StrEnum):
    """Position of a body in the waves: at rest, at its slowly drifting position, or at its
    momentary position. `AUTOMATIC` selects one of the first two, see
    `hydrosim.water.displaced_loads.reference_positions`."""

    AUTOMATIC = "automatic"
    MEAN = "mean"
    SLOW = "slow"
    INSTANTANEOUS = "instantaneous"

    def describe(self, noun: str) -> str:
        """Text on a ``noun``, position or heading, of this kind."""
        forms = {
            Place.MEAN: "{} at rest",
            Place.SLOW: "slowly varying {}",
            Place.INSTANTANEOUS: "momentary {}",
        }
        return forms.get(self, "{}").format(noun)


@schema_class
class WaveForces(SchemaClass):
    """Which wave loads act. Loads from QTFs that lack headings round the circle are those at
    rest."""

    has_valid_defaults: ClassVar[bool] = True

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

    @property
    def has_loads(self) -> bool:
        """True if any wave load acts."""
        second = self.second_order != SecondOrder.NONE
        return self.first_order or second or self.sum_frequency


class Weight(StrEnum):
    """How a body's weight is carried. Either it is balanced at rest and is no force, or it is a
    force that contacts, lines and buoyancy must carry."""

    BALANCED = "balanced"
    CARRIED = "carried"


@schema_class
class Clearance(SchemaClass):
    """The distance of a named point, "bow of barge", from another or from a plane."""

    key_rules = (exactly_one("to", "plane", nothing="nothing to measure from"),)

    of: StrictStr
    """Named point of a body. Example: bow of barge."""
    to: StrictStr | None = None
    """Named point of another body that the distance is measured to. Example: leg of topside."""
    plane: Plane | None = None
    """Plane that the distance is measured to."""

    @model_validator(mode="after")
    def _check_other(self) -> Self:
        if self.to == self.of:
            raise problem(f"the distance of {self.of} from itself", "two points")
        if self.plane and self.plane.corners:
            found_text = "a plane with corners"
            raise problem(found_text, "one without: a clearance is that from the whole plane")
        return self


# Bodies.


def _order_dofs(dofs: tuple[str, ...]) -> tuple[str, ...]:
    unknown = [dof for dof in dofs if dof not in DOFS]
    if unknown or len(set(dofs)) != len(dofs):
        remedy = suggestion(unknown[0], DOFS) if unknown else ""
        raise problem(f"[{', '.join(dofs)}]", f"any of {', '.join(DOFS)}, each once", remedy)
    return tuple(sorted(dofs, key=DOFS.index))


Dofs = Annotated[tuple[StrictStr, ...], AfterValidator(_order_dofs)]


@schema_class
class Initial(SchemaClass):
    """Offsets from the place at rest, and velocities, at the start."""

    has_valid_defaults: ClassVar[bool] = True

    position: of.Offsets = (0.0,) * 6
    """Offsets from the place at rest when the run starts: six values, or some by name."""
    velocity: of.Velocities = (0.0,) * 6
    """Velocities when the run starts: six values, or some by name."""


@schema_class
class Lightship(SchemaClass):
    """The body without what is in its tanks; ``centre_of_gravity`` is in the database's frame."""

    key_rules = (
        exactly_one(
            "radii_of_gyration",
            "inertia",
            nothing="neither radii_of_gyration nor inertia",
            expected="one of radii_of_gyration, inertia",
        ),
    )

    mass: of.Mass
    """Mass without the contents of tanks."""
    centre_of_gravity: of.Point
    """Centre of gravity without the contents of tanks, in the database's frame."""
    radii_of_gyration: of.Radii | None = None
    """Radii of gyration without the contents of tanks, about that centre."""
    inertia: of.InertiaMatrix | None = None
    """Moments of inertia without the contents of tanks, about that centre."""


@schema_class
class BodyKeys(SchemaClass):
    """What a body is in a case file and in a scene."""

    mass: of.Mass | None = None
    """Mass of the body, with the contents of its tanks at the start."""
    lightship: Lightship | None = None
    """Mass properties of the body without the contents of its tanks, in place of mass and
    inertia."""
    hydrodynamics: Any = None
    """Database file, a mapping with a file and changes to it, a list of databases by draught, or
    coefficients. A body without it is dry."""
    hydrostatics: Any = None
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
    radiation: BodyRadiation = AutomaticRadiation()
    """Model of the radiation forces: a name, or a mapping with a model and its settings."""
    wave_forces: WaveForces = WaveForces()
    """Wave loads that act on the body."""
    weight: Weight | None = None
    """Whether weight and buoyancy balance at rest, or weight is a force that contacts, lines and
    buoyancy carry."""
    tanks: Any = ()
    """Tanks of the body, by name."""
    pumps: Any = ()
    """Pumps between tanks or the sea, by name."""
    constant_inertia: StrictBool = False
    """Whether mass and inertia stay as at the start while tanks are pumped, and only the weight
    changes."""
    draught: Annotated[float, Quantity("length", "m", "8 m", above=0)] | None = None
    """Draught over which the mean of a current with a profile acts. Without it, that of the hull in
    hydrostatics."""
    points: dict[of.Name, of.Point] = field(default_factory=dict)
    """Places in the body frame by name. Their motions are recorded.
    Example: {bow: [90 m, 0 m, 8 m]}."""

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
        if len(given) > 1 or (not given and {*DOFS[3:]} & {*self.dofs}):
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


def inertia_matrix(source: BodyKeys | Lightship) -> np.ndarray:
    """Inertia (3, 3) [kg m^2] of a body about its centre of gravity."""
    if source.inertia is not None:
        return np.array(source.inertia)
    if isinstance(source, BodyKeys) and source.mass_matrix is not None:
        return np.array(source.mass_matrix)[3:, 3:]
    assert source.mass is not None
    # Without free rotations any inertia will do.
    return source.mass * np.diag(np.square(source.radii_of_gyration or (1.0, 1.0, 1.0)))


InertiaArray = Annotated[
    np.ndarray, ReadAs(of.InertiaMatrix | None, np.ndarray, of.as_array_or_none)
]


@schema_class
class Body(BodyKeys):
    """A rigid body: ``mass`` [kg] and ``inertia`` (3, 3) about the centre of gravity [kg m^2].

    ``hydrodynamics`` is a database or its file, with or without changes, a family of databases over
    the draught, which needs ``hydrostatics``, or coefficients; None makes a dry body.
    ``database_body`` is the number of the body in the database, from 1. All bodies of a database
    must be in the scene, with the same ``location``, ``heading`` and ``radiation`` (a model by name
    or with its settings). A database whose content differs from ``database_checksum`` is refused.

    ``hydrostatics`` is the closed hull that gives the buoyancy at any draught, heel and trim. None
    uses the stiffness of the database, which is valid near the position at rest.

    ``location`` (2,) places the origin of the database's frame in the earth's x, y. ``position``
    and ``velocity`` (6,) are the initial offsets from the position at rest, along the earth's axes
    and about the body's, and their rates: in Python in place of ``initial``. A body without free
    ``dofs`` is held. Mass, inertia and centre of gravity include the contents of its ``tanks`` at
    the start; the ``lightship`` of a case file is not for Python.
    """

    positional: ClassVar[tuple[str, ...]] = (
        *("name", "mass", "inertia", "hydrodynamics", "centre_of_gravity", "location", "heading"),
    )

    name: StrictStr = field(kw_only=True)
    """Name of the body."""
    mass: of.Mass
    inertia: InertiaArray = None  # type: ignore[assignment]
    hydrodynamics: Annotated[
        Hydrodynamics | Path | ChangedDatabase | Family | Coefficients | None,
        ReadAs(StrictStr, lambda value: not isinstance(value, str), Path),
    ] = None
    hydrostatics: Annotated[Hull, PythonObject(Hull)] | None = None
    centre_of_gravity: of.Point = (0.0, 0.0, 0.0)
    weight: Weight = Weight.BALANCED
    tanks: tuple[Annotated[Tank, PythonObject(Tank)], ...] = ()
    pumps: tuple[Annotated[Pump, PythonObject(Pump)], ...] = ()
    position: of.Offsets = (0.0,) * 6
    """Offsets from the position at rest at the start."""
    velocity: of.Velocities = (0.0,) * 6
    """Rates of these offsets at the start."""

    @model_validator(mode="after")
    def _build_properties(self) -> Self:
        if self.lightship is not None:
            raise problem("lightship", "mass and inertia with what is in the tanks")
        inertia = inertia_matrix(self)
        of.require_inertia(inertia)
        vars(self).update(inertia=inertia, radii_of_gyration=None, mass_matrix=None)
        if self.initial != Initial():
            if any((*self.position, *self.velocity)):
                raise problem("initial, and position or velocity", "one of them")
            start = vars(self.initial)
            vars(self).update({k: start[k] for k in ("position", "velocity")}, initial=Initial())
        return self
