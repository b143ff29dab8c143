"""What a group of contacts remembers of how it touched, carried and let go.

It does so if its stages are asked for: if a contact of it names its group, is a landing, or touches
a body without water that carries its own weight. Its states in y change at events and at the ends
of steps, so that nothing depends on how often a run is recorded; the impulse is an integral.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from hydrosim.forces.contact.modes import OPEN
from hydrosim.jit.kernels import clear, kernel
from hydrosim.modes import MODE

STATE_NAMES = (
    *("impulse", "load", "largest load", "first contact", "first open", "last open"),
    *("closings", "closing speed", "largest force"),
    *("recontacts", "recontact speed", "recontact force"),
)
"""Of each group: the integral of its normal forces [N s], the sum of them at the end of a step [N]
and the largest so far; times [s], `NEVER` before: of the first contact, of when all were open after
they carried `CARRIES`, and of when all were open last; how often contacts closed, the largest speed
at which one did [m/s] and the largest force of one [N]; the same since all were open."""
STATES = len(STATE_NAMES)
IMPULSE, LOAD, MOST, FIRST, OPENED, LAST, CLOSINGS = range(7)
# the last two are counted from closings and recontacts
AGAIN = CLOSINGS + 3
SPEED = 1
FORCE = 2
NEVER = -1.0
NONE = -1
CARRIES = 0.5  # of the weight: a group that has carried so much has let go when it is open
GROUP = np.dtype([("first", int), ("index", int), ("weight", float)])
"""The first of its states among those of contacts, which of all groups of contacts it is, and the
weight [N] that it carries or takes, or 0."""


class Member(Protocol):
    """What a group must know of an element of contacts, see `fender.Contact`."""

    remembers: ClassVar[bool]

    @property
    def body(self) -> str:
        """The name of the body it acts on."""

    @property
    def group(self) -> str | None:
        """What its contacts are looked at together as, if not as the element."""

    def others(self) -> Iterator[tuple[str, str | None]]:
        """Keys and names of the other bodies that it acts on."""


def remembering(
    contacts: Mapping[str, Member], carried: Mapping[str, float], first: int
) -> np.ndarray:
    """Those (n,) of `GROUP` of all groups of ``contacts`` that remember; their states come from
    ``first`` on after those of contacts. ``carried`` [N] are the weights of bodies."""
    asked: dict[str, bool] = {}
    weight: dict[str, float] = {}
    for element, e in contacts.items():
        name = e.group or element
        between = [e.body, *(other for _, other in e.others() if other)]
        weight[name] = max(weight.get(name, 0.0), *(carried.get(body, 0.0) for body in between))
        asked[name] = asked.get(name, False) or e.remembers or e.group is not None
    those = [(k, name) for k, name in enumerate(asked) if asked[name] or weight[name]]
    rows = [(first + STATES * g, k, weight[name]) for g, (k, name) in enumerate(those)]
    return np.array(rows, dtype=GROUP)


class Remembered(NamedTuple):
    """A group that remembers: which ``group`` of all groups of contacts it is, its ``weight`` [N]
    or 0, and its states ``y`` (nt, `STATES`)."""

    group: int
    weight: float
    y: np.ndarray


@kernel
def first_state(g, p):
    """The first entry in y of what group ``g`` remembers."""
    return p.state + p.groups[g].first


@kernel
def begin(t, y, modes, p):
    """All groups begin as they are."""
    for g in range(p.groups.size):
        k = first_state(g, p)
        clear(y[k : k + STATES])
        y[k + FIRST] = NEVER if _is_open(g, modes, p) else t
        y[k + OPENED] = y[k + LAST] = NEVER


@kernel
def _is_open(g, modes, p):
    for i in range(p.points.size):
        if p.points[i].group == g and modes[p.mode + i, MODE] != OPEN:
            return False
    return True


@kernel
def closed(t, speed, y, point, p):
    """A point has closed with this ``speed``."""
    if point.group == NONE:
        return
    k = first_state(point.group, p)
    if y[k + FIRST] == NEVER:
        y[k + FIRST] = t
    _count(speed, y[k + CLOSINGS :])
    if y[k + OPENED] != NEVER:
        _count(speed, y[k + AGAIN :])


@kernel
def _count(speed, x):
    x[0] += 1.0
    x[SPEED] = max(x[SPEED], speed)


@kernel
def opened(t, y, modes, point, p):
    """A point has opened."""
    if point.group == NONE or not _is_open(point.group, modes, p):
        return
    k = first_state(point.group, p)
    y[k + LAST] = t
    if y[k + OPENED] == NEVER and y[k + MOST] >= CARRIES * p.groups[point.group].weight:
        y[k + OPENED] = t


@kernel
def add_load(N, dy, point, p):
    """The normal force of a point as part of the rate of its group's impulse."""
    if point.group != NONE:
        dy[first_state(point.group, p) + IMPULSE] += N


@kernel
def put_down(y, p):
    """No group carries anything: loads are added up anew."""
    for g in range(p.groups.size):
        y[first_state(g, p) + LOAD] = 0.0


@kernel
def note(N, y, point, p):
    """Add the normal force of a point to its group's load; keep what is largest."""
    k = first_state(point.group, p)
    y[k + LOAD] += N
    y[k + MOST] = max(y[k + MOST], y[k + LOAD])
    _raise(N, y[k + CLOSINGS :])
    if y[k + OPENED] != NEVER:
        _raise(N, y[k + AGAIN :])


@kernel
def _raise(N, x):
    x[FORCE] = max(x[FORCE], N)
