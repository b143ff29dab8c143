"""What a kind of unit (contact points, springs, pins, flows, ...) is, for set-up and output.

Everything outside `hydrosim.forces` loops over kinds and names none. Kernels never see a kind: they
are plain functions of the constants that it has compiled, called one by one in `hydrosim.forces`
and `hydrosim.forces.events`. A kind has no state and returns data alone.

What few kinds have is asked by small protocols of their own: `Renewing`, `Mirrored`, `Resisting`,
`Losing`, `Tallying`; `hydrosim.forces.postures`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, runtime_checkable

import numpy as np

from hydrosim.forces.layout import Layout, Resistance
from hydrosim.scene import ForceElement, Scene

if TYPE_CHECKING:
    from hydrosim.tanks.contents import Tanks

Columns = dict[str, tuple[tuple[str, ...], np.ndarray]]
"""Of variables by name the dimensions and the values."""


class Parts(Protocol):
    """What has the constants of all kinds: a model."""

    @property
    def elements(self) -> Any:
        """Those of force elements."""

    @property
    def tanks(self) -> Tanks:
        """Those of tanks that change."""


class Variable(NamedTuple):
    """What a variable of a result is: in words, its units, its frame; of modes their ``flags``."""

    long_name: str
    units: str
    frame: str = "none"
    flags: str = ""


class States(NamedTuple):
    """A block of states: of each of the ``owners`` all ``components``. ``prefix`` stands before the
    owner in names of states."""

    kind: str
    owners: Sequence[str]
    components: Sequence[str]
    prefix: str = ""


class Modes(NamedTuple):
    """Rows of modes of the units of a kind, ``size`` of them, as files have them.

    ``mode`` and ``rising`` are names of columns, "" if there is none. ``first`` and ``last`` (n,)
    are the segments of each unit, ``steepest`` (n,) their largest slope [N/m]; None if they have no
    curve, or if whatever mode is stored is possible.
    """

    size: int
    mode: str = "mode"
    rising: str = ""
    first: np.ndarray | None = None
    last: np.ndarray | None = None
    steepest: np.ndarray | None = None


NO_MODES = Modes(0)


class Kept(NamedTuple):
    """Of nt records their ``time`` (nt,), states ``y`` (nt, ny), and of the units of a kind the
    ``modes`` (nt, n, 3), what was ``observed`` (nt, n, k) and the ``tallies`` (nt, n, k)."""

    time: np.ndarray
    y: np.ndarray
    modes: np.ndarray
    observed: np.ndarray
    tallies: np.ndarray


class Kind:
    """What a kind of unit is. ``unit`` is the dimension of its units in files."""

    unit: ClassVar[str] = ""
    variables: ClassVar[Mapping[str, Variable]] = {}

    def of(self, parts: Parts) -> Any:
        """Its constants ``p`` in a model."""
        raise NotImplementedError

    def unit_names(self, scene: Scene) -> list[str]:
        """Names of its units, in their order."""
        raise NotImplementedError

    def modes(self, p: Any) -> Modes:
        """Its rows of modes."""
        return NO_MODES

    def states(self, p: Any, scene: Scene) -> Iterator[States]:
        """Its states in y, block by block."""
        return iter(())

    def felt_states(self, p: Any) -> np.ndarray:
        """Entries (m,) of y that are its own and act on others."""
        return np.zeros(0, dtype=np.int64)

    def coordinates(self, scene: Scene) -> dict[str, object]:
        """Coordinates of its ``variables``, whatever happens in a run."""
        names = self.unit_names(scene) if self.unit else []
        return {self.unit: (self.unit, names)} if names else {}

    def record(self, p: Any, bodies: Any, kept: Kept) -> Columns:
        """Values of its ``variables``, where it has units."""
        return {}


@dataclass(frozen=True)
class ElementKind(Kind):
    """A kind of force elements: the ``field`` of its constants in `Elements`, the ``classes`` of
    elements, and the function that finds the constants of those among all elements."""

    field: str
    classes: tuple[type[ForceElement], ...]
    compile: Callable[[Mapping[str, ForceElement], Layout], Any]

    def of(self, parts: Parts) -> Any:
        return getattr(parts.elements, self.field)

    def unit_names(self, scene: Scene) -> list[str]:
        every = [(n, e) for n, e in scene.forces.items() if isinstance(e, self.classes)]
        return [unit for name, e in every for unit in e.unit_names(name)]


def capacity_of(kind: ElementKind, scene: Scene) -> dict[str, object]:
    """The coordinate of what each unit may carry [N], not a number where that is not said; nothing
    if it is said of none."""
    every = [(n, e) for n, e in scene.forces.items() if isinstance(e, kind.classes)]
    count = [len(e.unit_names(name)) for name, e in every]
    known = [np.nan if e.capacity is None else e.capacity for _, e in every]
    values = np.repeat(np.array(known, float), count)
    said = {"long_name": "capacity: what the unit may carry", "units": "N"}
    found = np.isfinite(values).any()
    return {f"{kind.unit}_capacity": (kind.unit, values, said)} if found else {}


@runtime_checkable
class Renewing(Protocol):
    """A kind whose states follow from others where a run goes on from another one."""

    def forget(self, p: Any, y: np.ndarray) -> None:
        """Clear the states in ``y`` that mean nothing to its units."""

    def renew(
        self, p: Any, y: np.ndarray, anew: np.ndarray, possible: np.ndarray, known: np.ndarray
    ) -> None:
        """Take over into ``y`` what a start from there has ``anew``, of units whose stored modes
        are not ``possible`` (n,) and of states that are not ``known`` (ny,)."""


@runtime_checkable
class Mirrored(Protocol):
    """A kind whose states may break the symmetry of a scene."""

    def is_mirrored(self, p: Any, y: np.ndarray, modes: np.ndarray) -> bool:
        """Whether states and ``modes`` (rows, 3) are their own mirror image in y = 0."""


@runtime_checkable
class Resisting(Protocol):
    """A kind with damping that is linear."""

    def resistances(self, p: Any) -> Iterator[Resistance]:
        """The damping of each unit."""


@runtime_checkable
class Losing(Protocol):
    """A kind that loses energy besides what its row of forces books."""

    def losses(self, p: Any, observed: np.ndarray) -> dict[int, np.ndarray]:
        """Energy lost (nt,) [J] by row of forces, of what was ``observed`` (nt, n, k)."""


@runtime_checkable
class Tallying(Protocol):
    """A kind of which more integrals are kept, where impulses are asked for: of each unit those
    that are ``tallied``, by name."""

    tallied: ClassVar[Sequence[str]]
