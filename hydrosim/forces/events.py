"""The modes of all elements that have any: when they end, what follows, and what is observed.

Rows of modes are those of contact points, then of springs, then of flows; every row has as many
margins, which are positive while its mode lasts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hydrosim.forces import spring
from hydrosim.forces.ballast import flows
from hydrosim.forces.contact import fender, transitions
from hydrosim.forces.contact.laws import COULOMB
from hydrosim.jit.kernels import kernel, root

if TYPE_CHECKING:
    from hydrosim.forces import Elements

HELD = 2  # directions that a point of rigid friction holds, at most


def observed(elements: Elements) -> dict[str, tuple[int, int]]:
    """Shapes of what `observe` writes, in its order, by kind."""
    return {
        "fenders": (elements.fenders.points.size, fender.OBSERVED),
        "springs": (elements.springs.lines.size, spring.OBSERVED),
    }


@kernel
def observe(t, y, modes, motion, bodies, elements, reactions, out):
    """What is recorded of elements besides their forces, into ``out``, flat: see `observed`."""
    fenders, springs = elements.fenders, elements.springs
    fender.observe(t, y, modes, motion, bodies, fenders, reactions, out)
    spring.observe(modes, motion, bodies, springs, out[fenders.points.size * fender.OBSERVED :])


@root
def settle(t, y, modes, motion, bodies, elements):
    """Fill ``modes`` for a start from ``y``."""
    transitions.settle(t, y, modes, motion, bodies, elements.fenders)
    spring.settle(modes, motion, bodies, elements.springs)
    if elements.tanks.flows.size > 0:
        flows.settle(t, modes, elements.tanks)


@kernel
def find_margins(t, y, modes, motion, bodies, elements, headings, reactions, watched, out):
    """Margins of all rows of modes into ``out``; of contact points those that are ``watched``."""
    fenders, springs = elements.fenders, elements.springs
    transitions.margins(t, y, modes, motion, bodies, fenders, headings, reactions, watched, out)
    if springs.lines.size > 0:
        spring.margins(modes, motion, bodies, springs, out)
    if elements.tanks.flows.size > 0:
        flows.margins(t, y, modes, elements.tanks, out)


@kernel
def find_headings(t, y, modes, motion, bodies, elements, out):
    """Where all contact points slip to."""
    transitions.find_headings(t, y, modes, motion, bodies, elements.fenders, out)


@kernel
def switch(row, which, size, step, t, y, modes, motion, bodies, elements, reactions):
    """Put a row of modes into that which follows when margin ``which``, of this ``size`` before or
    after, has reached zero; what relaxes in few steps of length ``step`` is settled only later."""
    fenders, springs = elements.fenders, elements.springs
    if row >= elements.tanks.mode and elements.tanks.flows.size > 0:
        flows.switch(row - elements.tanks.mode, which, modes, elements.tanks)
        return
    if row >= springs.mode and springs.lines.size > 0:
        spring.switch(row - springs.mode, which, modes, motion, bodies, springs)
        return
    i = row - fenders.mode
    transitions.switch(i, which, size, step, t, y, modes, motion, bodies, reactions, fenders)


@kernel
def felt(row, elements):
    """Entries of y, beyond coordinates and rates, that margins of a row look at: from, to."""
    fenders, tanks = elements.fenders, elements.tanks
    if row >= tanks.mode and tanks.flows.size > 0:
        return tanks.state, tanks.state + tanks.each.size
    if row < fenders.mode or row >= fenders.mode + fenders.points.size:
        return 0, 0
    k = fenders.state + fender.STATES * (row - fenders.mode)
    return k, k + fender.FELT


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
