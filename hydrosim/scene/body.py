"""A rigid body, and how waves load it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.scene.hydrodynamics import ChangedDatabase, Coefficients, Family, Hull, Hydrodynamics
from hydrosim.scene.radiation import Radiation, RadiationModel
from hydrosim.scene.tanks import Pump, Tank


class SecondOrder(StrEnum):
    """Approximation of the slow second-order wave loads."""

    NONE = "none"
    MEAN_DRIFT = "mean_drift"
    NEWMAN = "newman"
    NEWMAN_SQUARE_ROOT = "newman_square_root"
    QTF = "qtf"


class Place(StrEnum):
    """Where the waves meet a body: at rest, at the place that it has slowly moved to, or where it
    is at the time; `AUTOMATIC` is one of the first two, see `hydrosim.waves.places`."""

    AUTOMATIC = "automatic"
    MEAN = "mean"
    SLOW = "slow"
    INSTANTANEOUS = "instantaneous"


@dataclass(frozen=True)
class WaveForces:
    """Which wave loads act on a body: of first order, slow ones of second order, and those at
    the sums of the waves' frequencies.

    ``headings`` and ``position`` say whether loads of both orders are those of the body at rest, or
    follow its yaw, and its place, see `Place`; those of QTFs that are not known for headings all
    round are those at rest.
    """

    first_order: bool = True
    second_order: SecondOrder = SecondOrder.NONE
    sum_frequency: bool = False
    headings: Place = Place.AUTOMATIC
    position: Place = Place.AUTOMATIC

    @property
    def any(self) -> bool:
        """Whether there are any."""
        second = self.second_order != SecondOrder.NONE
        return self.first_order or second or self.sum_frequency


class Weight(StrEnum):
    """What carries a body: nothing need, for its weight is balanced at rest and no force; or
    contacts, lines and buoyancy, for it is a force of its own."""

    BALANCED = "balanced"
    CARRIED = "carried"


@dataclass(frozen=True)
class Clearance:
    """Distance ``of`` a named point ("bow of barge") ``to`` another; or from a plane through
    ``place`` with a ``normal``, in the earth frame or that of ``body``."""

    of: str
    to: str | None = None
    place: tuple[float, ...] = (0.0, 0.0, 0.0)
    normal: tuple[float, ...] = (0.0, 0.0, 1.0)
    body: str | None = None


@dataclass(frozen=True)
class Body:
    """A rigid body: ``mass`` [kg] and ``inertia`` (3, 3) about the centre of gravity [kg m^2].

    ``hydrodynamics`` is a database or its file, changed or not, a family of them over the draught,
    which needs ``hydrostatics``, or coefficients; None makes a dry body. ``database_body`` says
    which of the database's bodies it is, from 1; all of them are in the scene, at one ``location``
    and with one ``heading`` and one ``radiation``, a model by name or with its settings. A database
    of another content than ``database_checksum`` is refused.
    ``hydrostatics`` is the closed hull whose buoyancy is taken at any draught, heel and trim; None
    takes the stiffness of the database, which holds about the place at rest.
    ``centre_of_gravity`` (3,) is in the database's frame and is the body frame's origin.
    ``location`` (2,) places the origin of the database's frame in the earth's x, y; ``heading``
    [rad] is where its x axis points to at rest, from which yaw is counted. ``position`` and
    ``velocity`` (6,) are the initial offsets from the place at rest, along the earth's axes and
    about the body's, and their rates; ``dofs`` not named are locked, and a body without any is
    held. ``points`` are places in the body frame by name, whose motions are recorded.

    What is in its ``tanks`` at the start is part of its mass and inertia, and so is its centre of
    gravity then. ``constant_inertia`` leaves mass and inertia as they are then, whatever is pumped:
    the weight alone changes.
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
