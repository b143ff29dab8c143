"""Questions about a scene: their context, answers, and sizes, periods, seas and chains to judge by.

Size of a hull, from its water plane and its volume.

The water plane has the area A and the second moments S_xx and S_yy. The rectangle of length L and
breadth B with the same values has L^2 = 12 S_xx / A and B^2 = 12 S_yy / A. This is exact for a box.
The rectangle is 13 % shorter than an ellipse, and some 10 % narrower than a ship. Hulls that float
on columns fill only a small part of their rectangle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.dofs import DOFS
from hydrosim.elements.line.hang import pieces_of_segments
from hydrosim.integrate.dynamics import Model, motion_at
from hydrosim.multibody.kinematics import Motion
from hydrosim.scene.force import CHAIN, STEEL
from hydrosim.scene.scene import arrangement

if TYPE_CHECKING:
    from hydrosim.compile.compiled import DerivedData
    from hydrosim.integrate.state import State
    from hydrosim.scene import Body, Environment, Scene
    from hydrosim.scene.catenary import Catenary
    from hydrosim.water.components import WaveComponents

MOST_DIGITS = 15  # that a number of double precision has


class Query(NamedTuple):
    """Value ``found`` at a ``key`` of the case, the ``usual`` values, and ``advice`` (whole
    sentences). ``refused`` if the body cannot float, or if the run would take too long."""

    key: str
    found: str
    usual: str
    advice: str = ""
    refused: bool = False


def text_beyond(value: float, limit: float, form: str = ".3g") -> str:
    """A ``value`` beyond a ``limit`` in a ``form`` such as ".3g" or ".0%", with as many more digits
    as show that they differ."""
    digits, kind = int(form[1:-1]), form[-1]
    while digits < MOST_DIGITS and f"{value:.{digits}{kind}}" == f"{limit:.{digits}{kind}}":
        digits += 1
    return f"{value:.{digits}{kind}}"


def text_outside_range(value: float, low: float, high: float, form: str = ".3g") -> str:
    """A ``value`` below ``low`` or above ``high``, as `text_beyond` shows it."""
    return text_beyond(value, low if value < low else high, form)


@dataclass(frozen=True, eq=False)
class SceneContext:
    """Subject of all questions: a scene as compiled with its ``derived`` data, its ``sea`` as
    drawn, the ``motion`` of all bodies at the start, and the time of the ``end`` of the run
    [s]."""

    scene: Scene
    derived: DerivedData
    state: State
    sea: tuple[WaveComponents, ...]
    motion: Motion
    end: float

    def floating_bodies(self) -> Iterator[tuple[int, Body, HydroDatabase]]:
        """Wet bodies that can move: index, body, database."""
        for i, body in enumerate(self.scene.bodies):
            if body.name in self.derived.databases and body.dofs:
                yield i, body, self.derived.databases[body.name]

    def afloat(self) -> Iterator[tuple[int, Body, HydroDatabase]]:
        """`floating_bodies` bodies that no joint carries."""
        carried = arrangement(self.scene).children
        return ((i, body, db) for i, body, db in self.floating_bodies() if body.name not in carried)

    @property
    def model(self) -> Model:
        """Its constants."""
        return self.derived.model

    def centre(self, b: int) -> np.ndarray:
        """Position of the centre of gravity of body ``b`` at the start (3,) [m]."""
        moved = self.motion.coordinates[6 * b : 6 * b + 3]
        return np.asarray(self.model.bodies.each["origin"][b] + moved)

    @property
    def body_numbers(self) -> dict[str, int]:
        """Indices of the bodies, by name."""
        return {body.name: i for i, body in enumerate(self.scene.bodies)}


def describe_start(
    scene: Scene, derived: DerivedData, state: State, sea: Sequence[WaveComponents], end: float
) -> SceneContext:
    """Subject of the questions, from a scene in its ``sea``, the ``state`` at the start, and the
    time of its ``end`` [s]."""
    motion = motion_at(derived.model, state.y)
    return SceneContext(scene, derived, state, tuple(sea), motion, end)


ELLIPSE_OVER_RECTANGLE = 2.0 / np.sqrt(
    3.0
)  # axis of an ellipse over the side of the rectangle of its water plane
COMPACT = 0.8  # filled fraction of the rectangle, above which a hull counts as one closed body


class Extents(NamedTuple):
    """Rectangle of a hull's water plane in the body frame: its ``centre`` (3,), its ``half`` length
    and breadth (2,), and the fraction of it that is ``filled``. ``draught`` is the draught of
    upright sides below the water plane. All lengths in m."""

    centre: np.ndarray
    half: np.ndarray
    filled: float
    draught: float


def extents(body: Body, db: HydroDatabase) -> Extents | None:
    """Extents of a hull; None if its database does not have the data."""
    if db.hydrostatic_stiffness is None or db.volume is None or db.centre_of_buoyancy is None:
        return None
    C = db.hydrostatic_stiffness / (db.water_density * db.gravity)
    area, volume = float(C[2, 2]), float(db.volume[0])
    if area <= 0.0 or volume <= 0.0:
        return None
    height = body.centre_of_gravity[2]
    lever = volume * (db.centre_of_buoyancy[0, 2] - height)
    middle = np.array([-C[2, 4], C[2, 3]]) / area
    second = np.array([C[4, 4], C[3, 3]]) - lever - area * middle**2
    if np.any(second <= 0.0):
        return None
    half = np.sqrt(3.0 * second / area)
    centre = np.array([*middle, -height])
    return Extents(centre, half, float(area / (4.0 * np.prod(half))), volume / area)


# Natural periods of hulls for each degree of freedom by itself.


def natural_periods(about: SceneContext, i: int, body: Body, db: HydroDatabase) -> dict[str, float]:
    """Natural periods [s] of body ``i`` for each degree of freedom by itself, by name."""
    return {name: period for name, _, period in natural_inertias(about, i, body, db)}


def natural_inertias(
    about: SceneContext, i: int, body: Body, db: HydroDatabase
) -> Iterator[tuple[str, float, float]]:
    """Name, inertia with added mass [kg, kg m^2] and natural period [s] of each degree of freedom
    of body ``i`` that stiffness restores."""
    model = about.model
    moorings = model.elements.linear_moorings
    moored = [e["stiffness"] for e in moorings if e["body"] == i]
    stiffness = np.diag(sum(moored, require_array(db, "hydrostatic_stiffness")))
    added = np.diag(model.added_mass)[6 * i : 6 * i + 6]
    inertia = np.array([body.mass] * 3 + list(np.diag(body.inertia))) + added
    for dof, name in enumerate(DOFS):
        if name in body.dofs and stiffness[dof] > 0.0:
            period = float(2.0 * np.pi * np.sqrt(inertia[dof] / stiffness[dof]))
            yield name, float(inertia[dof]), period


# Heights, periods and wavelengths of drawn seas.


def height_of(sea: WaveComponents) -> float:
    """Height of a regular wave, significant height of other seas [m]."""
    if sea.omega.size == 1:
        return 2.0 * float(sea.amplitude[0])
    return 4.0 * float(np.sqrt(np.sum(sea.amplitude**2) / 2.0))


def crossing_period(sea: WaveComponents) -> float:
    """Mean zero-crossing period 2 pi sqrt(m0 / m2) [s]."""
    energy = sea.amplitude**2
    return float(2.0 * np.pi * np.sqrt(energy.sum() / np.sum(energy * sea.omega**2)))


def peak_period(sea: WaveComponents) -> float:
    """Period [s] of the mean frequency weighted by the fourth power of the amplitudes, near the
    peak."""
    weight = sea.amplitude**4
    return float(2.0 * np.pi * weight.sum() / np.sum(weight * sea.omega))


def peak_wavelength(seas: Sequence[WaveComponents]) -> float:
    """Wavelength [m] near the peak of the sea with the most energy."""
    sea = max(seas, key=lambda waves: float(np.sum(waves.amplitude**2)))
    at = int(np.argmin(np.abs(sea.omega - 2.0 * np.pi / peak_period(sea))))
    return float(2.0 * np.pi / sea.wavenumber[at])


# Segments of lines that are chain, by their weight and stiffness.

SAME_CHAIN = 0.03  # relative difference of EA


def bar_diameters(line: Catenary, water: Environment) -> Iterator[float]:
    """Bar diameters [m] of those segments of a line whose weight and EA are those of chain."""
    buoyant = water.gravity * (1.0 - water.water_density / STEEL)
    for piece in pieces_of_segments(line.segments):
        weight = piece["weight"]
        stiffness = piece["stiffness"]
        for mass_factor, stiffness_factor in CHAIN.values():
            usual = stiffness_factor * weight / (buoyant * mass_factor)
            if abs(usual - stiffness) < SAME_CHAIN * stiffness:
                yield sqrt(stiffness / stiffness_factor)
                break
