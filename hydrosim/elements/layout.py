"""Data for every force element when a scene is compiled: indices into the arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.dofs import about_z
from hydrosim.multibody.tree import NO_TREE, Tree
from hydrosim.scene import Clearance, ForceElement, Joint, Scene, Weight
from hydrosim.scene.scene import arrangement, tree_joints

if TYPE_CHECKING:
    from hydrosim.tanks.contents import TriggeredPump
    from hydrosim.water.current import TabulatedCurrent
    from hydrosim.water.wind import MeanWind

HYDROSTATIC, RADIATION, WAVE_FIRST_ORDER, WAVE_SECOND_ORDER = range(4)
BODY_ROWS = ("hydrostatic", "radiation", "wave_first_order", "wave_second_order")
JOINTS = "joints"
WEIGHT = "weight"
BALLAST = "ballast"


def row_names(scene: Scene) -> tuple[str, ...]:
    """Names of all rows of forces: bodies, elements, joints in whose motions forces act, the weight
    if any body carries its own, the flow in and out of tanks, and joints that are constraints."""
    carried = any(body.weight == Weight.CARRIED for body in scene.bodies)
    extra_rows = [*([WEIGHT] if carried else []), *([BALLAST] if has_flow(scene) else [])]
    extra_rows += [JOINTS] if constraint_names(scene) else []
    return (*BODY_ROWS, *scene.forces, *acting_joints(scene), *extra_rows)


def acting_joints(scene: Scene) -> tuple[str, ...]:
    """Names of the joints of trees in whose motions springs, damping, stops or friction act."""
    joints = tree_joints(scene) if scene.joints else {}
    return tuple(name for name, j in joints.items() if any(r.acts for r in j.resistances))


def constraint_names(scene: Scene) -> tuple[str, ...]:
    """Names of the joints that are constraints: loops, and locks."""
    if not scene.joints:
        return ()
    joint_tree = arrangement(scene)
    return (*joint_tree.loops, *joint_tree.passing)


def carried_weights(scene: Scene) -> dict[str, float]:
    """The weight [N] of bodies without water that carry their own weight, such as a topside."""
    return {
        body.name: body.mass * scene.environment.gravity
        for body in scene.bodies
        if body.weight == Weight.CARRIED and body.hydrodynamics is None
    }


def has_flow(scene: Scene) -> bool:
    """True if the contents of any tank change."""
    return any(body.pumps or any(t.plan for t in body.tanks) for body in scene.bodies)


class UncoupledResonance(NamedTuple):
    """Values per DOF (6,) along the body's axes at rest, with w_n^2 = k / (m + a(w_n)) and no
    coupling: the ``stiffness`` k, hydrostatics included, and the ``mass`` m + a(w_n)."""

    stiffness: np.ndarray
    mass: np.ndarray


class RollMode(NamedTuple):
    """Natural mode of roll of a body, per unit of roll: ``frequency`` [rad/s], ``mass`` [kg m^2]
    with the added mass (`hydrosim.compile.roll_mode`), and ``damping`` [N m s/rad] by
    radiated waves, both at that frequency."""

    frequency: float
    mass: float
    damping: float


class LinearResistance(NamedTuple):
    """A ``row`` of forces that takes the power v (B v - b) at the velocity v (6,) of a ``body``:
    ``B`` (6, 6) and ``b`` (6,). Or v (1,) is the rate of a free ``coordinate``. Or v (12,) are the
    velocities of the ``body`` and of the ``other``."""

    row: int
    body: int
    B: np.ndarray
    b: np.ndarray
    coordinate: int = -1
    other: int = -1


class BodyAtRest(NamedTuple):
    """A body of a joint: its ``number``, the place of its centre of gravity [m] and its ``heading``
    [rad] at rest."""

    number: int
    origin: tuple[float, ...]
    heading: float


class JoinedBodies(NamedTuple):
    """The bodies of a joint at rest (``to`` is None for the earth); ``exact`` as in `Bodies`."""

    body: BodyAtRest
    to: BodyAtRest | None
    exact: bool


@dataclass(frozen=True)
class Layout:
    """Indices of bodies by name, rows of forces by element name, and properties that elements need.

    ``current_profile`` is the current over the depth, ``wind`` the mean wind over the height.
    ``resonance`` (body, stiffness (6,)) returns the `UncoupledResonance` of a body with this
    additional stiffness along its axes at rest; ``roll_mode`` (body, stiffness (6, 6)) returns its
    `RollMode`.
    ``heading`` [rad] is the heading of each body at rest,
    ``weight`` [N] its weight. ``step`` [s] is the step of a method with equal steps, which cannot
    follow faster processes; 0 for other methods. ``events`` is true if steps end at events.

    ``tank_names`` names the tanks that change, ``flow`` is the row of forces of flows, ``pumps``
    begin or end by events. ``carried`` [N] is the weight of bodies without water that carry their
    own weight. ``joints`` are all joints of the scene, ``constraints`` the bodies of those that are
    constraints, ``joint_row`` is their row of forces; ``tree`` are the constants of the others.
    ``active`` are the free coordinates as in `Bodies`.
    ``origin`` [m] is the centre of gravity of each body at rest. ``points`` are body and place of
    each named point, for the ``clearances``. ``depth`` [m] and ``water_density`` [kg/m^3] are of
    the water. ``draught`` [m] is that of each body at rest, None if unknown.
    """

    body: dict[str, int]
    row: dict[str, int]
    current_profile: TabulatedCurrent
    wind: MeanWind
    resonance: Callable[[int, np.ndarray], UncoupledResonance]
    roll_mode: Callable[[int, np.ndarray], RollMode]
    heading: tuple[float, ...]
    weight: tuple[float, ...] = ()
    step: float = 0.0
    events: bool = True
    flow: int = 0
    tank_names: tuple[str, ...] = ()
    pumps: tuple[TriggeredPump, ...] = ()
    carried: Mapping[str, float] = field(default_factory=dict)
    joints: Mapping[str, Joint] = field(default_factory=dict)
    constraints: Mapping[str, JoinedBodies] = field(default_factory=dict)
    joint_row: int = 0
    tree: Tree = NO_TREE
    origin: tuple[np.ndarray, ...] = ()
    points: Mapping[str, tuple[int, tuple[float, ...]]] = field(default_factory=dict)
    clearances: Mapping[str, Clearance] = field(default_factory=dict)
    depth: float = inf
    water_density: float = 1025.0
    draught: tuple[float | None, ...] = ()
    active: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def draught_of(self, body: str) -> float | None:
        """Draught [m] of a body at rest, None if unknown."""
        return self.draught[self.body[body]] if self.draught else None

    def place_at_rest(self, body: str | None, point: Sequence[float]) -> np.ndarray:
        """Position (3,) in the earth frame of a ``point`` of a body at rest, or of the earth."""
        if body is None:
            return np.asarray(point, float)
        b = self.body[body]
        return np.asarray(np.add(self.origin[b], about_z(self.heading[b]) @ point))

    def axes_from(self, body: str, to: str | None) -> np.ndarray:
        """Matrix (3, 3) that turns vectors from the frame of ``body`` to that of ``to``, or to the
        earth frame, with both bodies at rest."""
        there = 0.0 if to is None else self.heading[self.body[to]]
        return about_z(self.heading[self.body[body]] - there)


def axes_at_rest(heading: float) -> np.ndarray:
    """Matrix (6, 6) that turns displacements from the axes of a body at rest, with this
    ``heading``, to the coordinates: translations along the earth's axes, angles about the
    body's."""
    axes = np.eye(6)
    axes[:3, :3] = about_z(heading)
    return axes


def unit_ranges(
    elements: Mapping[str, ForceElement], kind: type[ForceElement]
) -> dict[str, tuple[int, int]]:
    """Range of the units of each element among all units of a kind: first, and one after the
    last."""
    ranges = {}
    first = 0
    for name, element in elements.items():
        if isinstance(element, kind):
            end = first + len(element.unit_names(name))
            ranges[name] = (first, end)
            first = end
    return ranges
