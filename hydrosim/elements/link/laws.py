"""The laws of links, by their number: one line for each law in whatever a law does."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.elements.link import dry_friction, elastic, gas, stop, tension
from hydrosim.elements.link.law import LinkClass
from hydrosim.jit.kernels import kernel
from hydrosim.modes import SEGMENT
from hydrosim.scene.links import (
    Compensator,
    DryFriction,
    GasSpring,
    Link,
    Spring,
    SpringDamper,
    Stop,
    Strut,
    TorsionSpring,
)


class LinkConstants(NamedTuple):
    """``links`` (n,) of `LINK`; the ``segments`` of their curves and the ``pieces`` of the signals
    of their lengths; constants of gas springs, stops and dry friction; the first of their rows of
    modes and of their states, and of the integrals of losses in y, row by row."""

    links: np.ndarray
    segments: np.ndarray
    pieces: np.ndarray
    gases: np.ndarray
    stops: np.ndarray
    frictions: np.ndarray
    state: int
    mode: int
    losses: int


TENSION, ELASTIC, GAS, STOP, DRY_FRICTION = range(5)
LAWS: dict[type[Link], tuple[int, LinkClass]] = {
    Spring: (TENSION, tension.SPRING),
    Compensator: (GAS, gas.COMPENSATOR),
    Strut: (ELASTIC, elastic.STRUT),
    TorsionSpring: (ELASTIC, elastic.TORSION_SPRING),
    SpringDamper: (ELASTIC, elastic.SPRING_DAMPER),
    GasSpring: (GAS, gas.GAS_SPRING),
    Stop: (STOP, stop.STOP_CLASS),
    DryFriction: (DRY_FRICTION, dry_friction.DRY_FRICTION),
}
"""By class of links, the number of its law and what that declares."""
CONSTANTS = {"gases": gas.CYLINDER, "stops": stop.STOPS, "frictions": dry_friction.FRICTION}
"""Constants of those laws that have their own, by their field in `LinkConstants`."""


@kernel
def find_loads(link, mode, s, y, p):
    """The load T of a link, and the power that it dissipates."""
    if link.law == TENSION:
        return tension.find_loads(link, mode, s, p)
    if link.law == ELASTIC:
        return elastic.find_loads(link, mode, s, p)
    if link.law == GAS:
        return gas.find_loads(link, p.gases[link.constants], mode, s)
    if link.law == STOP:
        return stop.find_loads(p.stops[link.constants], mode[SEGMENT], s.x, s.rate)
    node = y[p.state + link.state]
    return dry_friction.find_loads(link, p.frictions[link.constants], mode, s, node)


@kernel
def set_state_rates(link, mode, s, y, p, dy):
    """The rates of the states of a link that acts, in ``dy``."""
    if link.law == DRY_FRICTION:
        dy[p.state + link.state] = 0.0 if mode[SEGMENT] == dry_friction.STICKS else s.rate


@kernel
def stored_energy(link, mode, s, y, p):
    """The energy that a link stores."""
    if link.law == TENSION or link.law == ELASTIC:
        return tension.stored_energy(mode, s, p)
    if link.law == GAS:
        return gas.stored_energy(p.gases[link.constants], mode, s)
    if link.law == STOP:
        return stop.stored_energy(p.stops[link.constants], mode[SEGMENT], s.x)
    node = y[p.state + link.state]
    return dry_friction.stored_energy(p.frictions[link.constants], mode, s, node)


@kernel
def find_margins(link, mode, s, y, p, out):
    """Margins (4,) of a link by its law into ``out``."""
    if link.law == TENSION:
        tension.find_margins(link, mode, s, p, out)
    elif link.law == ELASTIC:
        elastic.find_margins(link, mode, s, p, out)
    elif link.law == GAS:
        gas.find_margins(link, p.gases[link.constants], mode, s, out)
    elif link.law == STOP:
        stop.find_margins(p.stops[link.constants], mode[SEGMENT], s.x, s.rate, out)
    else:
        node = y[p.state + link.state]
        dry_friction.find_margins(p.frictions[link.constants], mode, s, node, out)


@kernel
def transition(link, which, mode, s, y, p):
    """The next mode of a link by its law, after margin ``which`` has reached zero."""
    if link.law == TENSION:
        tension.transition(link, which, mode, s, p)
    elif link.law == ELASTIC:
        elastic.transition(mode, s, p)
    elif link.law == GAS:
        gas.transition(link, p.gases[link.constants], which, mode, s)
    elif link.law == STOP:
        of = p.stops[link.constants]
        mode[SEGMENT] = stop.next_segment(of, which, mode[SEGMENT], s.x, s.rate)
    else:
        k = p.state + link.state
        y[k], lost = dry_friction.transition(p.frictions[link.constants], mode, s, y[k])
        y[p.losses + link.row] += lost


@kernel
def set_initial_mode(link, mode, s, y, p):
    """The mode of a link that becomes active, by its law."""
    if link.law == TENSION:
        tension.set_initial_mode(link, mode, s, p)
    elif link.law == ELASTIC:
        elastic.set_initial_mode(link, mode, s, p)
    elif link.law == GAS:
        gas.set_initial_mode(link, p.gases[link.constants], mode, s)
    elif link.law == STOP:
        mode[SEGMENT] = stop.initial_segment(p.stops[link.constants], s.x, s.rate)
    else:
        mode[SEGMENT] = dry_friction.STICKS
        y[p.state + link.state] = s.x
