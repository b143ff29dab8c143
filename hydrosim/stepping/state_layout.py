"""What every entry of the state y is: the one table of its layout.

y is a row of blocks. Each entry of a block has a component ("surge", "slip distance") and an owner
(a body, a contact point, a tank, a row of forces). Files spell both as one name; whoever needs
either asks here, or reads `state_kind`, `state_owner` and `state_component` beside the name.
`Model` has the offsets of blocks as numbers, for kernels.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.forces.ballast.tanks import tank_names
from hydrosim.forces.contact import fender, group, loop, tally
from hydrosim.scene import Scene
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.names import (
    Coordinate,
    coordinate_of,
    coordinates,
    dofs_of,
    fender_names,
    force_names,
    group_names,
    remembering_names,
    supplies,
    trigger_names,
)
from hydrosim.waves import slow_bodies
from hydrosim.waves.slow import NAMES as SLOW_NAMES


class Kind(StrEnum):
    """What a block of states is."""

    COORDINATE = "coordinate"
    RATE = "rate"
    RADIATION = "radiation"
    CONTACT = "contact point"
    CLOSINGS = "closings"
    GROUP = "contact group"
    TANK = "tank"
    TRIGGER = "trigger"
    SLOW_PLACE = "slow place"
    SLOW_DRAUGHT = "slow draught"
    ENERGY = "energy"
    IMPULSE = "impulse"
    TALLY = "tally"


MOVING = (Kind.COORDINATE, Kind.RATE, Kind.RADIATION)
"""States of the motion itself, which a restart must have."""
DRAUGHT_FILTERS = ("slow heave filter 1", "slow heave filter 2")


class Entry(NamedTuple):
    """A state: its ``component``, whose it is, its ``name`` in files, and the free coordinates that
    it moves with, if any."""

    component: str
    owner: str
    name: str
    coordinates: tuple[Coordinate, ...] = ()


class Block(NamedTuple):
    """States of one kind, from ``offset`` on in y."""

    kind: Kind
    offset: int
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class StateLayout:
    """The ``blocks`` of y in their order."""

    blocks: tuple[Block, ...]

    def names(self) -> list[str]:
        """Names of all entries: "surge of barge", "slip distance of interface 1", ..."""
        return [entry.name for _, entry in self._all()]

    def kinds(self) -> list[str]:
        """Kind of every entry."""
        return [str(kind) for kind, _ in self._all()]

    def owners(self) -> list[str]:
        """Whose every entry is."""
        return [entry.owner for _, entry in self._all()]

    def components(self) -> list[str]:
        """Component of every entry."""
        return [entry.component for _, entry in self._all()]

    def moving(self) -> list[Entry]:
        """The coordinates, rates and radiation states."""
        return [entry for kind, entry in self._all() if kind in MOVING]

    def of(self, kind: Kind) -> tuple[Entry, ...]:
        """The entries of a kind."""
        return next((block.entries for block in self.blocks if block.kind == kind), ())

    def at(self, index: int) -> tuple[Kind, Entry]:
        """Kind and entry of place ``index`` in y."""
        block = next(b for b in reversed(self.blocks) if b.offset <= index and b.entries)
        return block.kind, block.entries[index - block.offset]

    def _all(self) -> Iterator[tuple[Kind, Entry]]:
        return ((block.kind, entry) for block in self.blocks for entry in block.entries)


def state_layout(scene: Scene, model: Model) -> StateLayout:
    """The layout of y for a scene and its model."""
    blocks = []
    offset = 0
    for kind, entries in _blocks(scene, model):
        found = tuple(entries)
        blocks.append(Block(kind, offset, found))
        offset += len(found)
    return StateLayout(tuple(blocks))


def _blocks(scene: Scene, model: Model) -> Iterator[tuple[Kind, Iterable[Entry]]]:
    """All blocks in the order of y."""
    free = coordinates(scene)
    yield Kind.COORDINATE, (Entry(q.dof, q.body, q.name, (q,)) for q in free)
    yield Kind.RATE, (Entry(q.dof, q.body, f"rate of {q.name}", (q,)) for q in free)
    yield Kind.RADIATION, _radiation(scene, model)
    yield Kind.CONTACT, _each(fender_names(scene), fender.STATE_NAMES)
    yield Kind.CLOSINGS, _each(remembering_names(scene, model), loop.STATE_NAMES)
    yield Kind.GROUP, _each(group_names(scene, model), group.STATE_NAMES, "group ")
    yield Kind.TANK, _each(tank_names(scene), ("volume",))
    yield Kind.TRIGGER, (_trigger(name) for name in trigger_names(scene))
    yield Kind.SLOW_PLACE, _each([body.name for body in slow_bodies(scene)], SLOW_NAMES)
    yield (
        Kind.SLOW_DRAUGHT,
        _each(_families(scene, model), ("slow heave filter 1", "slow heave filter 2")),
    )
    yield Kind.ENERGY, _energies(scene)
    if scene.output_impulses:
        yield Kind.IMPULSE, _impulses(scene)
        yield Kind.TALLY, _each(fender_names(scene), [f"tally {k + 1}" for k in range(tally.SIZE)])


def _each(owners: Iterable[str], components: Iterable[str], kind: str = "") -> Iterator[Entry]:
    """All components of each owner."""
    parts = [*components]
    for owner in owners:
        for part in parts:
            yield Entry(part, owner, f"{part} of {kind}{owner}")


def _radiation(scene: Scene, model: Model) -> Iterator[Entry]:
    """States of the memory, group by group: each is of some coordinates, of one body or several."""
    states, family, bodies = model.states, model.family, [body.name for body in scene.bodies]
    members = zip(family.owner, family.draught, strict=True)
    bodies += [f"{scene.bodies[b].name} at {draught:g} m" for b, draught in members]
    # the model may repeat the last DOF of a group
    groups = [[*dict.fromkeys(states.dof[a:b].tolist())] for a, b in pairwise(states.member)]
    for dofs, count in zip(groups, np.diff(states.state), strict=True):
        moved = tuple(coordinate_of(scene, model, dof) for dof in dofs)
        owner = dofs_of(dofs, bodies)
        yield from (
            Entry(f"radiation {k + 1}", owner, f"radiation {k + 1} of {owner}", moved)
            for k in range(count)
        )


def _trigger(name: str) -> Entry:
    return Entry("time since", name, f"time since {name} may act or end")


def _families(scene: Scene, model: Model) -> list[str]:
    """Bodies with databases over draught."""
    return [scene.bodies[b].name for b in model.family.body]


def _energies(scene: Scene) -> Iterator[Entry]:
    """Work or loss of every row of forces, and the measure of what waves exchange."""
    for row, name in enumerate(force_names(scene)):
        component = "work" if supplies(scene, row) else "loss"
        joined = "work of" if supplies(scene, row) else "loss in"
        yield Entry(component, name, f"{joined} {name}")
    yield Entry("integral of |power|", "waves", "integral of |wave power|")


def _impulses(scene: Scene) -> Iterator[Entry]:
    """Integrals of the force of every row, and of its power, by coordinate."""
    every = [Coordinate(dof, body.name).name for body in scene.bodies for dof in DOFS]
    for what in ("impulse", "work"):
        for row in force_names(scene):
            yield from (Entry(what, row, f"{what} of {row} on {name}") for name in every)
