"""A rigid body, its wave loads, and its tanks and pumps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import ClassVar, Self

import numpy as np
from pydantic import StrictBool, StrictStr, model_validator

from hydrosim.dofs import DOFS
from hydrosim.files import quantities as of
from hydrosim.files.key_rules import exactly_one
from hydrosim.files.schema_class import SchemaClass, schema_class
from hydrosim.files.units import problem
from hydrosim.scene.force import LevelReached, When
from hydrosim.scene.hydrodynamics import (
    ChangedDatabase,
    Coefficients,
    Family,
    Hull,
    Hydrodynamics,
    Radiation,
    RadiationModel,
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


@dataclass(frozen=True)
class Tank:
    """A tank of a body, in the database's frame, with a fluid of this ``density`` [kg/m^3];
    ``level`` [m] is the level at the start, above the bottom."""

    name: str
    shape: TankShape
    level: float
    density: float = 1025.0
    surface: FreeSurface = FreeSurface.QUASI_STATIC
    plan: Plan | None = None


@dataclass(frozen=True)
class Pump:
    """Moves ``rate`` [kg/s] from the ``source`` to the ``target``, from ``start`` to ``stop``. Both
    are tanks of its body; None is the sea. ``start`` and ``stop`` are times [s], levels or events.
    Without ``stop`` it runs until the source is empty or the target full."""

    name: str
    rate: float
    source: str | None
    target: str | None
    start: float | LevelReached | When = 0.0
    stop: float | LevelReached | When | None = None


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


@dataclass(frozen=True)
class Body:
    """A rigid body: ``mass`` [kg] and ``inertia`` (3, 3) about the centre of gravity [kg m^2].

    ``hydrodynamics`` is a database or its file, with or without changes, a family of databases over
    the draught, which needs ``hydrostatics``, or coefficients; None makes a dry body.
    ``database_body`` is the number of the body in the database, from 1. All bodies of a database
    must be in the scene, with the same ``location``, ``heading`` and ``radiation`` (a model by name
    or with its settings). A database whose content differs from ``database_checksum`` is refused.

    ``hydrostatics`` is the closed hull that gives the buoyancy at any draught, heel and trim. None
    uses the stiffness of the database, which is valid near the position at rest.

    ``centre_of_gravity`` (3,) is in the database's frame and is the origin of the body frame.
    ``location`` (2,) places the origin of the database's frame in the earth's x, y. ``heading``
    [rad] is the direction of its x axis at rest, from which yaw counts. ``position`` and
    ``velocity`` (6,) are the initial offsets from the position at rest, along the earth's axes and
    about the body's, and their rates. ``dofs`` lists the free degrees of freedom; a body with none
    is held. ``points`` are named points in the body frame whose motions are recorded.

    ``draught`` [m] is the depth over which the mean of a current with a profile acts; None takes
    that of the hull in ``hydrostatics``.

    Mass, inertia and centre of gravity include the contents of its ``tanks`` at the start. If
    ``constant_inertia`` is true, pumping changes the weight alone.
    """

    name: str
    mass: float
    inertia: np.ndarray
    hydrodynamics: Hydrodynamics | Path | ChangedDatabase | Family | Coefficients | None = None
    centre_of_gravity: tuple[float, ...] = (0.0, 0.0, 0.0)
    location: tuple[float, ...] = (0.0, 0.0)
    heading: float = 0.0
    database_body: int = 1
    database_checksum: str | None = None
    dofs: tuple[str, ...] = DOFS
    position: tuple[float, ...] = (0.0,) * 6
    velocity: tuple[float, ...] = (0.0,) * 6
    radiation: RadiationModel | Radiation = RadiationModel.AUTOMATIC
    wave_forces: WaveForces = field(default_factory=WaveForces)
    hydrostatics: Hull | None = None
    points: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    weight: Weight = Weight.BALANCED
    tanks: tuple[Tank, ...] = ()
    pumps: tuple[Pump, ...] = ()
    constant_inertia: bool = False
    draught: float | None = None
