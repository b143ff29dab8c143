"""Kinds of units (contact points, springs, flows, ...): layout of arrays, mode sets, output.

All code outside `hydrosim.elements` loops over kinds and names none. Kernels do not use kinds: they
are plain functions of the compiled constants, called one by one in `hydrosim.elements` and
`hydrosim.elements.events`. A kind has no state and returns data alone.

Properties of few kinds have small protocols of their own: `ResetsOnRestart`, `HasCoupledStates`,
`HasMirrorSymmetry`, `HasLinearDamping`, `HasLosses`, `HasImpulses`, `CanFail`.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, runtime_checkable

import numpy as np

from hydrosim.dofs import about_z
from hydrosim.modes import MODE, MODE_COLUMNS, SEGMENT
from hydrosim.multibody.tree import NO_TREE, Tree, coordinate_places
from hydrosim.scene import Clearance, ForceElement, Joint, Scene, Weight
from hydrosim.scene.scene import arrangement, tree_joints

if TYPE_CHECKING:
    from hydrosim.tanks.contents import Tanks, TriggeredPump
    from hydrosim.water.current import TabulatedCurrent
    from hydrosim.water.wind import MeanWind

# Layout: indices into the arrays, for every element when a scene is compiled.

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

    def coordinate_of_motion(self, joint: str, motion: str) -> tuple[int, int, int]:
        """The free coordinate of a ``motion`` of a ``joint`` of a tree, its move and the axis of
        that."""
        places = coordinate_places(self.tree)
        trees = [name for name in self.joints if name not in self.constraints]
        before = sum(len(self.joints[name].motions) for name in trees[: trees.index(joint)])
        names = [m.name for m in self.joints[joint].motions]
        coordinate = min(places) + before + names.index(motion)
        return coordinate, *places[coordinate]

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


Columns = dict[str, tuple[tuple[str, ...], np.ndarray]]
"""Variables by name, with their dimensions and values."""


class KindConstants(Protocol):
    """An object with the constants of all kinds, such as a model."""

    @property
    def elements(self) -> Any:
        """Constants of force elements."""

    @property
    def tanks(self) -> Tanks:
        """Constants of tanks that change."""


class ElementLoads(NamedTuple):
    """What elements add to: the ``wrench`` (rows, 6 nb) of every row of forces, its work or
    dissipation ``rate`` (rows,), and the rates ``dy`` of the states y."""

    wrench: np.ndarray
    rate: np.ndarray
    dy: np.ndarray


class Topic(IntEnum):
    """What the chart of a variable is about, in the order of charts. Charts before `CLEARANCES` are
    the overview of a run, those from `DETAILS` on are folded on pages."""

    MOTIONS = 0
    WATER = 10
    CONTACTS = 20
    TENSIONS = 30
    JOINTS = 40
    DRIVES = 50
    COORDINATES = 60
    LINKS = 70
    CAPACITIES = 80
    CLEARANCES = 90
    DETAILS = 100
    END = 200


class ChartHint(NamedTuple):
    """The chart of a variable: its ``title``, the ``quantity`` beside its axis, and its ``rank``,
    which is its `Topic` plus its place there. Without a title there is none, but the summary of the
    variable stands at its rank."""

    title: str
    quantity: str
    rank: int


NO_CHART = ChartHint("", "", Topic.END)


class SummaryColumn(NamedTuple):
    """A column of the summary of a run: its ``heading``, and the ``figure`` over time that stands
    below it for each unit, a name in `report.sentences.run.FIGURES`. It is a figure of another
    ``variable`` if one is named."""

    heading: str
    figure: str
    variable: str = ""


class Variable(NamedTuple):
    """Description of a variable of a result: text, units, frame; for modes their ``flags``.

    The ``summary`` are columns of a table of its units, which are called ``row_label`` there, if
    not as their dimension. ``lowest`` is a lower bound of all values. A variable ``is_load`` if
    capacities and the colours of a replay are about it. One that ``is_detail`` is no channel unless
    it is asked for.
    """

    long_name: str
    units: str
    frame: str = "none"
    flags: str = ""
    chart: ChartHint = NO_CHART
    summary: Sequence[SummaryColumn] = ()
    lowest: float = -inf
    is_load: bool = False
    is_detail: bool = False
    row_label: str = ""


def tension_variable(
    long_name: str,
    frame: str,
    title: str,
    place: int,
    summary: Sequence[SummaryColumn],
    row_label: str = "",
) -> Variable:
    """The tension [N] of a kind of lines, in the ``place`` of its chart among those of tensions.
    The ``summary`` are columns after those of start and mean."""
    columns = (SummaryColumn("tension at the start", "at the start"), SummaryColumn("mean", "mean"))
    chart = ChartHint(title, "tension", Topic.TENSIONS + place)
    hints = chart, (*columns, *summary), 0.0
    return Variable(long_name, "N", frame, "", *hints, is_load=True, row_label=row_label)


def range_columns(quantity: str) -> tuple[SummaryColumn, ...]:
    """Mean and ends of a ``quantity`` of both signs, in a summary."""
    ends = (SummaryColumn("smallest", "smallest"), LARGEST)
    return SummaryColumn(f"mean {quantity}", "mean"), *ends


LARGEST = SummaryColumn("largest", "largest")
SLACK_SHARE = SummaryColumn("slack", "share of zeros")


class StateBlocks(NamedTuple):
    """A block of states: all ``components`` of each of the ``owners``. ``prefix`` precedes the
    owner in names of states."""

    kind: str
    owners: Sequence[str]
    components: Sequence[str]
    prefix: str = ""


class ModeRows(NamedTuple):
    """Rows of modes of the ``size`` units of a kind, as stored in files.

    ``mode`` and ``rising`` are names of columns, "" if there is none. ``first`` and ``last`` (n,)
    are the segments of each unit, ``steepest`` (n,) their largest slope [N/m]. They are None if the
    units have no curve, or if every stored mode is possible.
    """

    size: int
    mode: str = "mode"
    rising: str = ""
    first: np.ndarray | None = None
    last: np.ndarray | None = None
    steepest: np.ndarray | None = None


NO_MODES = ModeRows(0)

UNIT_ROW = np.dtype([("kind", int), ("unit", int), ("trigger", int)])
"""A row of modes: the number of its kind (`events.ROW_KINDS`), that of the unit among those of its
kind, and the trigger that starts and ends its action, `NO_INDEX` if none."""


@dataclass(frozen=True, eq=False)
class RecordedStates:
    """States y of nt records, without the radiation states: only few records have these.

    ``values`` (nt, n) are the other states, in the order of y; ``radiation`` are the places of the
    radiation states in y.
    """

    values: np.ndarray
    radiation: slice

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, places: slice) -> np.ndarray:
        """The states (nt, k) at these places in y, none of which is a radiation state."""
        missing = self.radiation.stop - self.radiation.start
        first, last, _ = places.indices(self.values.shape[1] + missing)
        if last <= self.radiation.start or missing == 0:
            return self.values[:, first:last]
        if first < self.radiation.stop:
            raise IndexError("not every record has the radiation states")
        return self.values[:, first - missing : last - missing]


class UnitRecord(NamedTuple):
    """nt records: their ``time`` (nt,), states ``y``, and for the units of a kind the
    ``modes`` (nt, n, 3), the values ``observed`` (nt, n, k) and the ``tallies`` (nt, n, k)."""

    time: np.ndarray
    y: RecordedStates
    modes: np.ndarray
    observed: np.ndarray
    tallies: np.ndarray


class UnitKind:
    """A kind of unit. ``unit`` is the dimension of its units in files."""

    unit: ClassVar[str] = ""
    variables: ClassVar[Mapping[str, Variable]] = {}

    def constants_in(self, parts: KindConstants) -> Any:
        """Constants ``p`` of the kind in a model."""
        raise NotImplementedError

    def unit_names(self, scene: Scene) -> list[str]:
        """Names of its units, in their order."""
        raise NotImplementedError

    def modes(self, p: Any) -> ModeRows:
        """Its rows of modes."""
        return NO_MODES

    def states(self, p: Any, scene: Scene) -> Iterator[StateBlocks]:
        """Its states in y, block by block."""
        return iter(())

    def coordinates(self, scene: Scene) -> dict[str, object]:
        """Coordinates of its ``variables``, which do not depend on the run."""
        names = self.unit_names(scene) if self.unit else []
        return {self.unit: (self.unit, names)} if names else {}

    def record(self, p: Any, bodies: Any, unit_record: UnitRecord) -> Columns:
        """Values of its ``variables``, if it has units."""
        return {}


@dataclass(frozen=True)
class ElementKind(UnitKind):
    """A kind of force elements: the ``field`` of its constants in `Elements`, the ``classes`` of
    elements, and the function that compiles their constants."""

    field: str
    classes: tuple[type[ForceElement], ...]
    compile: Callable[[Mapping[str, ForceElement], Layout], Any]

    def constants_in(self, parts: KindConstants) -> Any:
        return getattr(parts.elements, self.field)

    def replaced_in(self, elements: Any, p: Any) -> Any:
        """The ``elements`` with the constants ``p`` of this kind."""
        return elements._replace(**{self.field: p})

    def unit_names(self, scene: Scene) -> list[str]:
        every = elements_of(scene, self.classes)
        return [unit for name, e in every for unit in e.unit_names(name)]


def elements_of(scene: Scene, classes: Any) -> list[tuple[str, ForceElement]]:
    """The elements of a scene of these ``classes``, with their names."""
    return [(n, e) for n, e in scene.forces.items() if isinstance(e, classes)]


def capacity_of(unit: str, every: Sequence[tuple[str, ForceElement]]) -> dict[str, object]:
    """The coordinate of the allowable load [N] of each ``unit`` of the elements ``every``, NaN
    where none is given; empty if no unit has one."""
    count = [len(e.unit_names(name)) for name, e in every]
    capacities = [getattr(e, "capacity", None) or np.nan for _, e in every]
    values = np.repeat(np.array(capacities, float), count)
    description = {"long_name": "capacity: allowable force", "units": "N"}
    has_capacity = np.isfinite(values).any()
    return {f"{unit}_capacity": (unit, values, description)} if has_capacity else {}


@runtime_checkable
class ResetsOnRestart(Protocol):
    """A kind with states that must be derived anew when a run continues another one."""

    def clear_unused_states(self, p: Any, y: np.ndarray) -> None:
        """Clear the states in ``y`` that have no meaning for its units."""

    def renew(
        self,
        p: Any,
        y: np.ndarray,
        anew: np.ndarray,
        possible: np.ndarray,
        known_states: np.ndarray,
    ) -> None:
        """Copy the initial values ``anew`` into ``y`` for units whose stored modes are not
        ``possible`` (n,) and for states that are not ``known_states`` (ny,)."""


@runtime_checkable
class HasCoupledStates(Protocol):
    """A kind with states that act on other states."""

    def coupled_states(self, p: Any) -> np.ndarray:
        """Entries (m,) of y that are its own and act on other states."""


@runtime_checkable
class HasMirrorSymmetry(Protocol):
    """A kind whose states may break the symmetry of a scene."""

    def is_mirrored(self, p: Any, y: np.ndarray, modes: np.ndarray) -> bool:
        """True if states and ``modes`` (rows, 3) are mirror symmetric about y = 0."""


@runtime_checkable
class HasLinearDamping(Protocol):
    """A kind with linear damping."""

    def resistances(self, p: Any) -> Iterator[LinearResistance]:
        """The damping of each unit."""


@runtime_checkable
class HasLosses(Protocol):
    """A kind that loses energy beyond the dissipation booked in its row of forces."""

    def losses(self, p: Any, observed: np.ndarray) -> dict[int, np.ndarray]:
        """Energy lost (nt,) [J] by row of forces, from the values ``observed`` (nt, n, k)."""


@runtime_checkable
class HasImpulses(Protocol):
    """A kind with additional integrals, if impulses are asked for: ``tallied`` are their names for
    each unit."""

    impulse_names: ClassVar[Sequence[str]]


@runtime_checkable
class CanFail(Protocol):
    """A kind with units that end a run where their force is not defined."""

    def undefined_units(self, p: Any, modes: np.ndarray) -> Iterator[tuple[int, str]]:
        """The units whose force is not defined in these ``modes`` (n, 3), each with the reason."""


# Sets of modes in which `hydrosim.linear.stability` linearises a scene.

LINEARISATION_DEPTH = (
    0.01  # m: the compression beyond the start of a piece at which units are linearised
)


class ModeSet(NamedTuple):
    """Units of a kind in given ``modes`` (n, 3), with a description in words, "" for the default
    posture."""

    text: str
    modes: np.ndarray


class KindWithModeSets(ElementKind):
    """A kind whose units have several postures, each with a stiffness of its own."""

    def mode_sets(self, p: Any) -> Sequence[ModeSet]:
        """All units in one mode, for each mode; the posture at rest comes first."""
        raise NotImplementedError

    def one_unit_active(
        self, p: Any, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[ModeSet]:
        """One of the units ``which`` alone in a mode, for each of them."""
        return iter(())

    def equivalence_keys(self, p: Any) -> Sequence[Hashable]:
        """For each unit, all properties that set its stiffness and damping, except its position."""
        return []

    def rates(self, p: Any, bodies: Any, motion: Any) -> np.ndarray:
        """Velocities (n, k) at all units, in their directions."""
        return np.zeros((0, 0))

    def moved_onto_segment(
        self, p: Any, modes: np.ndarray, bodies: Any, motion: Any, y: np.ndarray
    ) -> Any:
        """The constants with every unit on the piece of its curve given by ``modes``, at its
        position and in its direction, wherever the bodies are."""
        return p

    def time_of_largest_load(self, p: Any) -> float:
        """Time of the largest prescribed load [s]; 0 if nothing is prescribed."""
        return 0.0

    def sliding_speed(self, p: Any, modes: np.ndarray, time: float) -> float:
        """Speed [m/s] at which slipping units certainly slip; 0 if none slips."""
        return 0.0

    def set_steady_slip(
        self, p: Any, modes: np.ndarray, time: float, bodies: Any, motion: Any, y: np.ndarray
    ) -> None:
        """Put the states of slipping units in ``y`` into steady slip."""

    def idle_states(self, p: Any, modes: np.ndarray) -> np.ndarray:
        """States (m,) that act on nothing in these ``modes``."""
        return np.zeros(0, dtype=np.int64)


def rest_at_first(first: np.ndarray, mode: int) -> np.ndarray:
    """Modes (n, 3) of units in a ``mode``, on the ``first`` (n,) segment of each."""
    modes = np.zeros((len(first), MODE_COLUMNS), dtype=np.int64)
    modes[:, MODE] = mode
    modes[:, SEGMENT] = first
    return modes


def with_mode_of_unit(rest: np.ndarray, modes: np.ndarray, i: int) -> np.ndarray:
    """Modes (n, 3) of units at ``rest``, except unit ``i``."""
    changed_modes = rest.copy()
    changed_modes[i] = modes[i]
    return changed_modes


def steepest_segment(segments: np.ndarray, first: int, last: int) -> int:
    """The steepest of the segments ``first`` to ``last``."""
    return first + int(np.argmax(segments["slope"][first : last + 1]))
