"""Memory of a group of contacts: touching, carrying and letting go.

A group has a memory if its stages are asked for: a contact names its group, is a landing, or
touches a body without water that carries its own weight. Its states in y change at events and at
the ends of steps, so that they do not depend on the output step. The impulse is an integral.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from hydrosim.elements.contact.law import OPEN
from hydrosim.jit.kernels import clear, kernel
from hydrosim.modes import MODE, NO_INDEX

GROUP_STATE_NAMES = (
    *("impulse", "load", "largest load", "first contact", "first open", "last open"),
    *("closings", "closing speed", "largest force"),
    *("recontacts", "recontact speed", "recontact force"),
)
"""States of each group. Loads: integral of its normal forces [N s], their sum at the end of a step
[N], and the largest sum. Times [s], `NEVER` before: first contact, first time that all were open
after they carried `CARRIED_SHARE`, and last time that all were open. Contacts: number of closings,
their largest speed [m/s] and the largest force of one contact [N]; the same since all were open."""
GROUP_STATES = len(GROUP_STATE_NAMES)
GROUP_IMPULSE, GROUP_LOAD, LARGEST_LOAD, FIRST_CONTACT, FIRST_OPEN, LAST_OPEN, CLOSINGS = range(7)
# the last two are counted from closings and recontacts
RECONTACTS = CLOSINGS + 3
SPEED_ENTRY = 1
FORCE_ENTRY = 2
NEVER = -1.0
CARRIED_SHARE = 0.5  # of the weight: a group that has carried this much has let go when it is open
GROUP = np.dtype([("first", int), ("index", int), ("weight", float)])
"""Its first state among those of contacts, its index among all groups of contacts, and the weight
[N] that it carries or takes, or 0."""


class Member(Protocol):
    """Data that a group needs of an element of contacts, see `fender.Contact`."""

    remembers: ClassVar[bool]

    @property
    def body(self) -> str:
        """The name of the body it acts on."""

    @property
    def group(self) -> str | None:
        """Name under which its contacts are analysed together; None stands for the element's
        name."""

    def connected_bodies(self) -> Iterator[tuple[str, str | None]]:
        """Keys and names of the other bodies that it acts on."""


def compile_groups(
    contacts: Mapping[str, Member], carried: Mapping[str, float], first: int
) -> np.ndarray:
    """Constants (n,) of `GROUP` of all groups of ``contacts`` with a memory. Their states follow
    those of contacts from ``first`` on. ``carried`` [N] are the weights of bodies."""
    asked: dict[str, bool] = {}
    weight: dict[str, float] = {}
    for element, e in contacts.items():
        name = e.group or element
        between = [e.body, *(other for _, other in e.connected_bodies() if other)]
        weight[name] = max(weight.get(name, 0.0), *(carried.get(body, 0.0) for body in between))
        asked[name] = asked.get(name, False) or e.remembers or e.group is not None
    those = [(k, name) for k, name in enumerate(asked) if asked[name] or weight[name]]
    rows = [(first + GROUP_STATES * g, k, weight[name]) for g, (k, name) in enumerate(those)]
    return np.array(rows, dtype=GROUP)


class GroupMemory(NamedTuple):
    """A group with a memory: its index ``group`` among all groups of contacts, its ``weight`` [N]
    or 0, and its states ``y`` (nt, `GROUP_STATES`)."""

    group: int
    weight: float
    y: np.ndarray


@kernel
def first_state(g, p):
    """First entry in y of the memory of group ``g``."""
    return p.state + p.groups[g].first


@kernel
def initialise_groups(t, y, modes, p):
    """Initialise the memory of all groups from the present contacts."""
    for g in range(p.groups.size):
        k = first_state(g, p)
        clear(y[k : k + GROUP_STATES])
        y[k + FIRST_CONTACT] = NEVER if _is_open(g, modes, p) else t
        y[k + FIRST_OPEN] = y[k + LAST_OPEN] = NEVER


@kernel
def _is_open(g, modes, p):
    for i in range(p.points.size):
        if p.points[i].group == g and modes[p.mode + i, MODE] != OPEN:
            return False
    return True


@kernel
def record_closing(t, speed, y, point, p):
    """Record that a point has closed with this ``speed``."""
    if point.group == NO_INDEX:
        return
    k = first_state(point.group, p)
    if y[k + FIRST_CONTACT] == NEVER:
        y[k + FIRST_CONTACT] = t
    _count_closing(speed, y[k + CLOSINGS :])
    if y[k + FIRST_OPEN] != NEVER:
        _count_closing(speed, y[k + RECONTACTS :])


@kernel
def _count_closing(speed, x):
    x[0] += 1.0
    x[SPEED_ENTRY] = max(x[SPEED_ENTRY], speed)


@kernel
def record_opening(t, y, modes, point, p):
    """Record that a point has opened."""
    if point.group == NO_INDEX or not _is_open(point.group, modes, p):
        return
    k = first_state(point.group, p)
    y[k + LAST_OPEN] = t
    if (
        y[k + FIRST_OPEN] == NEVER
        and y[k + LARGEST_LOAD] >= CARRIED_SHARE * p.groups[point.group].weight
    ):
        y[k + FIRST_OPEN] = t


@kernel
def add_load(N, dy, point, p):
    """Add the normal force of a point to the rate of its group's impulse."""
    if point.group != NO_INDEX:
        dy[first_state(point.group, p) + GROUP_IMPULSE] += N


@kernel
def clear_loads(y, p):
    """Set the loads of all groups to zero, before they are summed again."""
    for g in range(p.groups.size):
        y[first_state(g, p) + GROUP_LOAD] = 0.0


@kernel
def add_to_load(N, y, point, p):
    """Add the normal force of a point to its group's load; keep the largest values."""
    k = first_state(point.group, p)
    y[k + GROUP_LOAD] += N
    y[k + LARGEST_LOAD] = max(y[k + LARGEST_LOAD], y[k + GROUP_LOAD])
    _raise_largest(N, y[k + CLOSINGS :])
    if y[k + FIRST_OPEN] != NEVER:
        _raise_largest(N, y[k + RECONTACTS :])


@kernel
def _raise_largest(N, x):
    x[FORCE_ENTRY] = max(x[FORCE_ENTRY], N)
