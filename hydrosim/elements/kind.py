"""Kinds of units (contact points, springs, pins, flows, ...) for set-up and output.

All code outside `hydrosim.elements` loops over kinds and names none. Kernels do not use kinds: they
are plain functions of the compiled constants, called one by one in `hydrosim.elements` and
`hydrosim.elements.events`. A kind has no state and returns data alone.

Properties of few kinds have small protocols of their own: `ResetsOnRestart`, `HasMirrorSymmetry`,
`HasLinearDamping`, `HasLosses`, `HasImpulses`, `CanFail`; `hydrosim.elements.kind`.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, runtime_checkable

import numpy as np

from hydrosim.elements.layout import Layout, LinearResistance
from hydrosim.modes import MODE, MODE_COLUMNS, SEGMENT
from hydrosim.scene import ForceElement, Scene

if TYPE_CHECKING:
    from hydrosim.tanks.contents import Tanks

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


class Variable(NamedTuple):
    """Description of a variable of a result: text, units, frame; for modes their ``flags``."""

    long_name: str
    units: str
    frame: str = "none"
    flags: str = ""


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

    def coupled_states(self, p: Any) -> np.ndarray:
        """Entries (m,) of y that are its own and act on other states."""
        return np.zeros(0, dtype=np.int64)

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
    capacities = [np.nan if e.capacity is None else e.capacity for _, e in every]
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


# Modes of units in which a scene is linearised to find its largest stiffness.
#
# `hydrosim.linear.stability` analyses all units of each kind in one mode, for each of its modes,
# and single units in a mode while the other units rest.

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

    def moved_onto_segment(self, p: Any, modes: np.ndarray, bodies: Any, motion: Any) -> Any:
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
