"""The modes of all elements that have any: when they end, what follows, and what is observed.

Rows of modes are those of contact points, of springs, of flows, of guides and of triggers, one
after another; every row has as many margins, which are positive while its mode lasts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hydrosim.forces import spring, trigger
from hydrosim.forces.contact import fender, group, guide, loop, transitions
from hydrosim.forces.contact.laws import COULOMB
from hydrosim.forces.contact.tally import add_tallies
from hydrosim.jit.kernels import kernel, root
from hydrosim.tanks import pumping

if TYPE_CHECKING:
    from hydrosim.forces import Elements

HELD = 2  # directions that a point of rigid friction holds, at most
FELT = 2  # parts of y that margins of a row look at


def observed(elements: Elements) -> dict[str, tuple[int, int]]:
    """Shapes of what `observe` writes, in its order, by the unit of kinds."""
    return {
        "fender": (elements.fenders.points.size, fender.OBSERVED),
        "spring": (elements.springs.lines.size, spring.OBSERVED),
        "guide": (elements.guides.pins.size, guide.OBSERVED),
    }


@kernel
def observe(t, y, modes, motion, bodies, elements, reactions, wrench, out):
    """What is recorded of elements besides their forces, which are in ``wrench`` (rows, 6 nb), into
    ``out``, flat: see `observed`."""
    fenders = elements.fenders
    springs = elements.springs
    if fenders.points.size > 0:
        fender.observe(t, y, modes, motion, bodies, fenders, reactions, out)
    behind = fenders.points.size * fender.OBSERVED
    if springs.lines.size > 0:
        spring.observe(modes, motion, bodies, springs, out[behind:])
    if elements.guides.pins.size > 0:
        behind += springs.lines.size * spring.OBSERVED
        guide.observe(modes, motion, bodies, elements, out[behind:])


@root
def settle(t, y, modes, motion, bodies, elements, tanks):
    """Fill ``modes`` for a start from ``y``."""
    if elements.fenders.points.size > 0:
        transitions.settle(t, y, modes, motion, bodies, elements.fenders)
    if elements.springs.lines.size > 0:
        spring.settle(modes, motion, bodies, elements.springs)
    if tanks.flows.size > 0:
        pumping.settle(t, modes, tanks)
    if elements.guides.pins.size > 0:
        guide.settle(modes, motion, bodies, elements)
    if elements.triggers.each.size > 0:
        trigger.settle(t, y, modes, motion, bodies, elements, tanks)
    group.begin(t, y, modes, elements.fenders)


@kernel
def find_margins(t, y, modes, motion, bodies, elements, tanks, headings, reactions, watched, out):
    """Margins of all rows of modes into ``out``; of contact points those that are ``watched``."""
    fenders = elements.fenders
    springs = elements.springs
    transitions.margins(t, y, modes, motion, bodies, fenders, headings, reactions, watched, out)
    if springs.lines.size > 0:
        spring.margins(modes, motion, bodies, springs, out)
    if tanks.flows.size > 0:
        pumping.margins(t, y, modes, tanks, out)
    if elements.guides.pins.size > 0:
        guide.margins(modes, motion, bodies, elements, out)
    if elements.triggers.each.size > 0:
        trigger.margins(t, y, modes, motion, bodies, elements, tanks, out)


@kernel
def find_headings(t, y, modes, motion, bodies, elements, out):
    """Where all contact points slip to."""
    transitions.find_headings(t, y, modes, motion, bodies, elements.fenders, out)


@kernel
def switch(row, which, size, step, t, y, modes, motion, bodies, elements, tanks, reactions):
    """Put a row of modes into that which follows when margin ``which``, of this ``size`` before or
    after, has reached zero; what relaxes in few steps of length ``step`` is settled only later."""
    fenders = elements.fenders
    springs = elements.springs
    triggers = elements.triggers
    if is_trigger(row, elements):
        trigger.switch(row - triggers.mode, which, t, y, modes, motion, bodies, elements, tanks)
        return
    if row >= elements.guides.mode and elements.guides.pins.size > 0:
        i = row - elements.guides.mode
        guide.switch(i, which, y, modes, motion, bodies, elements)
        return
    if row >= tanks.mode and tanks.flows.size > 0:
        pumping.switch(row - tanks.mode, which, t, modes, tanks)
        return
    if row >= springs.mode and springs.lines.size > 0:
        spring.switch(row - springs.mode, which, modes, motion, bodies, springs)
        return
    i = row - fenders.mode
    transitions.switch(i, which, size, step, t, y, modes, motion, bodies, reactions, fenders)


@kernel
def is_trigger(row, elements):
    """Whether a row of modes is that of a trigger, which may change what is stored in others."""
    return elements.triggers.each.size > 0 and row >= elements.triggers.mode


@kernel
def book(row, sign, y, stored, elements):
    """Count what is ``stored`` (rows,) in the element of a trigger, in this ``sign``, as lost;
    contacts do so by themselves."""
    one = elements.triggers.each[row - elements.triggers.mode]
    if one.points == 0:
        y[elements.triggers.losses + one.row] += sign * stored[one.row]


@kernel
def felt(row, part, elements, tanks):
    """Entries of y, beyond coordinates and rates, that margins of a row look at: from, to; so many
    times as there are `FELT` parts."""
    fenders = elements.fenders
    if tanks.flows.size > 0 and tanks.mode <= row < tanks.mode + tanks.flows.size:
        return tanks.state, tanks.state + tanks.each.size
    if tanks.flows.size > 0 and is_trigger(row, elements):
        return tanks.state, tanks.state + tanks.each.size
    if row < fenders.mode or row >= fenders.mode + fenders.points.size:
        return 0, 0
    point = fenders.points[row - fenders.mode]
    if part == 0:
        k = fenders.state + fender.STATES * (row - fenders.mode)
        return k, k + fender.FELT
    if point.memory == loop.NONE:
        return 0, 0
    k = fender.memory(point, fenders) + loop.SET
    return k, k + 1


def held_points(elements: Elements) -> int:
    """Number of the points with directions of slip, or reactions of rigid friction."""
    return int(elements.fenders.points.size)


@kernel
def tally(t, y, modes, motion, bodies, elements, reactions, rates):
    """Rates of the integrals of units, where impulses are asked for."""
    add_tallies(t, y, modes, motion, bodies, elements.fenders, reactions, rates)


@kernel
def remembers(elements):
    """Whether anything keeps what only single steps know."""
    return elements.fenders.remembering > 0 or elements.fenders.groups.size > 0


@kernel
def note(t, y, modes, motion, bodies, elements):
    """Keep what only single steps know, into y."""
    transitions.note(t, y, modes, motion, bodies, elements.fenders)


@kernel
def settling(t, y, elements):
    """Whether anything still relaxes fast after an event."""
    return transitions.settling(t, y, elements.fenders)


def held_directions(elements: Elements) -> int:
    """Rows of constraints that elements ask for, at most."""
    return HELD * int((elements.fenders.points["law"] == COULOMB).sum())


@kernel
def hold(modes, motion, bodies, elements, wrench, constraints, holds):
    """Add the constraints of what elements hold; ``wrench`` (6 nb,) is scratch."""
    fender.hold_points(modes, motion, bodies, elements.fenders, wrench, constraints, holds)


@kernel
def add_reactions(modes, motion, bodies, elements, constraints, holds, wrench):
    """Reactions of what elements hold into their rows of ``wrench``."""
    fender.add_reactions(modes, motion, bodies, elements.fenders, constraints, holds, wrench)


@kernel
def break_loose(t, y, modes, motion, bodies, elements, reactions):
    """Let go the first that is held by more than it can be, if any; whether there was one."""
    return transitions.break_loose(t, y, modes, motion, bodies, elements.fenders, reactions)
