"""Names of array entries (forces, coordinates, contact points, ...), and layout of the state y.

Layout of the state y: the meaning of every entry, in one table.

y is a row of blocks. Each entry of a block has a component ("surge", "slip distance") and an owner
(a body, a contact point, a tank, a row of forces). Files join both to one name. To get either, use
this module, or read `state_kind`, `state_owner` and `state_component` next to the name. For
kernels, `Model` has the offsets of blocks as numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements import ELEMENT_KINDS
from hydrosim.elements.contact import kind as contact_points
from hydrosim.elements.kind import (
    BALLAST,
    BODY_ROWS,
    JOINTS,
    RADIATION,
    WAVE_FIRST_ORDER,
    WAVE_SECOND_ORDER,
    WEIGHT,
    HasImpulses,
    has_flow,
    row_names,
)
from hydrosim.elements.link.kind import SPRING_KIND
from hydrosim.integrate.dynamics import Model
from hydrosim.scene import ForceElement, Scene, WaveForces
from hydrosim.scene.scene import arrangement, tree_joints
from hydrosim.water.displaced_loads import slow_bodies
from hydrosim.water.slow_path_loads import SLOW_STATE_NAMES

WAVE_ROWS = (BODY_ROWS[WAVE_FIRST_ORDER], BODY_ROWS[WAVE_SECOND_ORDER])


def force_names(scene: Scene) -> tuple[str, ...]:
    """Names of the rows of forces: the body's own and the elements'."""
    return row_names(scene)


def is_work_row(scene: Scene, row: int) -> bool:
    """True if the power of a row of forces is booked as work, false if as dissipation."""
    element = element_of(scene, row)
    if element is not None:
        return element.supplies
    return force_names(scene)[row] in (*WAVE_ROWS, *([WEIGHT, BALLAST] if has_flow(scene) else []))


def may_store_energy(scene: Scene, row: int) -> bool:
    """True if a row of forces may store energy."""
    name = force_names(scene)[row]
    holds = row == RADIATION or name == JOINTS or is_work_row(scene, row)
    return name == WEIGHT or not holds


def may_dissipate(scene: Scene, row: int) -> bool:
    """True if a row of forces may dissipate energy."""
    if row == RADIATION or force_names(scene)[row] in (JOINTS, *scene.joints):
        return True
    return element_of(scene, row) is not None and not is_work_row(scene, row)


def element_of(scene: Scene, row: int) -> ForceElement | None:
    """The element that owns a row of forces; None if the row belongs to a body itself."""
    return scene.forces.get(force_names(scene)[row])


def dofs_of(dofs: Sequence[int] | np.ndarray, bodies: Sequence[str]) -> str:
    """Names of DOFs, six for each of the ``bodies``: "sway, roll of a and sway, roll of b"."""
    parts = [
        f"{', '.join(DOFS[dof % 6] for dof in dofs if dof // 6 == b)} of {name}"
        for b, name in enumerate(bodies)
        if any(dof // 6 == b for dof in dofs)
    ]
    return " and ".join(parts)


class Coordinate(NamedTuple):
    """A degree of freedom of a body, or a motion of a joint."""

    dof: str
    body: str

    @property
    def name(self) -> str:
        """Name in files: "surge of barge"."""
        return f"{self.dof} of {self.body}"


def coordinates(scene: Scene) -> list[Coordinate]:
    """All free coordinates, in the order of y."""
    carried = arrangement(scene).children
    free_bodies = [body for body in scene.bodies if body.name not in carried]
    coordinate_list = [
        Coordinate(dof, body.name) for body in free_bodies for dof in DOFS if dof in body.dofs
    ]
    joints = tree_joints(scene)
    return coordinate_list + [
        Coordinate(m.name, name) for name, j in joints.items() for m in j.motions
    ]


def coordinate_at(scene: Scene, index: int) -> Coordinate:
    """The coordinate with this index in `Bodies.active`."""
    body = index // 6
    if body < len(scene.bodies):
        return Coordinate(DOFS[index % 6], scene.bodies[body].name)
    joints = [(name, m) for name, joint in tree_joints(scene).items() for m in joint.motions]
    name, motion = joints[index - 6 * len(scene.bodies)]
    return Coordinate(motion.name, name)


def coordinate_names(scene: Scene) -> list[str]:
    """Names of all free coordinates."""
    return [coordinate.name for coordinate in coordinates(scene)]


def contact_names(scene: Scene) -> list[str]:
    """Names of all contact points, "element 1", "element 2", ..."""
    return contact_points.CONTACT_KIND.unit_names(scene)


def spring_names(scene: Scene) -> list[str]:
    """Names of all springs."""
    return SPRING_KIND.unit_names(scene)


def memory_names(scene: Scene, model: Model) -> list[str]:
    """Names of the coordinates whose velocities a convolution remembers."""
    return [
        coordinate_of_dof(scene, model, dof).name for dof in np.unique(model.convolution.column)
    ]


def coordinate_of_dof(scene: Scene, model: Model, dof: int) -> Coordinate:
    """Coordinate of a body, or of the body that a member of a family belongs to."""
    body = dof // 6 - len(scene.bodies)
    owner = dof // 6 if body < 0 else model.family.owner[body]
    return Coordinate(DOFS[dof % 6], scene.bodies[owner].name)


class StateKind(StrEnum):
    """Kinds of blocks of states, except for those of units, which name their own
    (`hydrosim.elements.kind`)."""

    COORDINATE = "coordinate"
    RATE = "rate"
    RADIATION = "radiation"
    SLOW_PLACE = "slow place"
    SLOW_DRAUGHT = "slow draught"
    ENERGY = "energy"
    IMPULSE = "impulse"
    TALLY = "tally"


MOVING = (StateKind.COORDINATE, StateKind.RATE, StateKind.RADIATION)
"""States of the motion itself, which a restart must have."""
DRAUGHT_FILTERS = ("slow heave filter 1", "slow heave filter 2")


class StateEntry(NamedTuple):
    """A state: its ``component``, its owner, its ``name`` in files, and the free coordinates that
    it moves with, if any."""

    component: str
    owner: str
    name: str
    coordinates: tuple[Coordinate, ...] = ()


class StateBlock(NamedTuple):
    """States of one kind, from ``offset`` on in y."""

    kind: str
    offset: int
    entries: tuple[StateEntry, ...]


@dataclass(frozen=True)
class StateLayout:
    """The ``blocks`` of y in their order."""

    blocks: tuple[StateBlock, ...]

    def names(self) -> list[str]:
        """Names of all entries: "surge of barge", "slip distance of interface 1", ..."""
        return [entry.name for _, entry in self._all_entries()]

    def kinds(self) -> list[str]:
        """Kind of every entry."""
        return [str(kind) for kind, _ in self._all_entries()]

    def owners(self) -> list[str]:
        """Owner of every entry."""
        return [entry.owner for _, entry in self._all_entries()]

    def components(self) -> list[str]:
        """Component of every entry."""
        return [entry.component for _, entry in self._all_entries()]

    def moving(self) -> list[StateEntry]:
        """The coordinates, rates and radiation states."""
        return [entry for kind, entry in self._all_entries() if kind in MOVING]

    def entries_of(self, kind: str) -> tuple[StateEntry, ...]:
        """The entries of a kind."""
        return next((block.entries for block in self.blocks if block.kind == kind), ())

    def entry_at(self, index: int) -> tuple[str, StateEntry]:
        """Kind and entry at ``index`` in y."""
        block = next(b for b in reversed(self.blocks) if b.offset <= index and b.entries)
        return block.kind, block.entries[index - block.offset]

    def _all_entries(self) -> Iterator[tuple[str, StateEntry]]:
        return ((block.kind, entry) for block in self.blocks for entry in block.entries)


def state_layout(scene: Scene, model: Model, met: Mapping[str, WaveForces]) -> StateLayout:
    """The layout of y for a scene and its model. ``met`` has the positions where waves act, by
    body."""
    blocks = []
    offset = 0
    for kind, entries in _state_blocks(scene, model, met):
        all_entries = tuple(entries)
        blocks.append(StateBlock(kind, offset, all_entries))
        offset += len(all_entries)
    return StateLayout(tuple(blocks))


def _state_blocks(
    scene: Scene, model: Model, met: Mapping[str, WaveForces]
) -> Iterator[tuple[str, Iterable[StateEntry]]]:
    """All blocks in the order of y."""
    free = coordinates(scene)
    yield StateKind.COORDINATE, (StateEntry(q.dof, q.body, q.name, (q,)) for q in free)
    yield StateKind.RATE, (StateEntry(q.dof, q.body, f"rate of {q.name}", (q,)) for q in free)
    yield StateKind.RADIATION, _radiation_entries(scene, model)
    for kind in ELEMENT_KINDS:
        for blocks in kind.states(kind.constants_in(model), scene):
            yield blocks.kind, _entries_of_owners(blocks.owners, blocks.components, blocks.prefix)
    yield StateKind.SLOW_PLACE, _entries_of_owners(slow_bodies(scene, met), SLOW_STATE_NAMES)
    yield (StateKind.SLOW_DRAUGHT, _entries_of_owners(_family_names(scene, model), DRAUGHT_FILTERS))
    yield StateKind.ENERGY, _energy_entries(scene)
    if scene.output.impulses:
        yield StateKind.IMPULSE, _impulse_entries(scene)
        for kind in ELEMENT_KINDS:
            if isinstance(kind, HasImpulses):
                yield (
                    StateKind.TALLY,
                    _entries_of_owners(kind.unit_names(scene), kind.impulse_names),
                )


def _entries_of_owners(
    owners: Iterable[str], components: Iterable[str], kind: str = ""
) -> Iterator[StateEntry]:
    """All components of each owner."""
    parts = [*components]
    for owner in owners:
        for part in parts:
            yield StateEntry(part, owner, f"{part} of {kind}{owner}")


def _radiation_entries(scene: Scene, model: Model) -> Iterator[StateEntry]:
    """States of the memory, group by group; each belongs to some coordinates, of one body or
    several."""
    states = model.states
    family = model.family
    bodies = [body.name for body in scene.bodies]
    members = zip(family.owner, family.draught, strict=True)
    bodies += [f"{scene.bodies[b].name} at {draught:g} m" for b, draught in members]
    # the model may repeat the last DOF of a group
    groups = [[*dict.fromkeys(states.dof[a:b].tolist())] for a, b in pairwise(states.member)]
    for dofs, count in zip(groups, np.diff(states.state), strict=True):
        moved = tuple(coordinate_of_dof(scene, model, dof) for dof in dofs)
        owner = dofs_of(dofs, bodies)
        yield from (
            StateEntry(f"radiation {k + 1}", owner, f"radiation {k + 1} of {owner}", moved)
            for k in range(count)
        )


def _family_names(scene: Scene, model: Model) -> list[str]:
    """Bodies with databases over draught."""
    return [scene.bodies[b].name for b in model.family.body]


def _energy_entries(scene: Scene) -> Iterator[StateEntry]:
    """Work or loss of every row of forces, and the integral of |wave power|."""
    for row, name in enumerate(force_names(scene)):
        component = "work" if is_work_row(scene, row) else "loss"
        joined = "work of" if is_work_row(scene, row) else "loss in"
        yield StateEntry(component, name, f"{joined} {name}")
    yield StateEntry("integral of |power|", "waves", "integral of |wave power|")


def _impulse_entries(scene: Scene) -> Iterator[StateEntry]:
    """Integrals of the force of every row, and of its power, by coordinate."""
    every = [Coordinate(dof, body.name).name for body in scene.bodies for dof in DOFS]
    for what in ("impulse", "work"):
        for row in force_names(scene):
            yield from (StateEntry(what, row, f"{what} of {row} on {name}") for name in every)
