"""All friction laws with their numbers, and dispatch to the law of a point.

A new law is one file (see `law`), its line in `LAWS`, and a line in each function here where it
differs from the default. By default a law has no state, sticks as soon as slip ends, and begins
contact in slip.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from hydrosim.elements.contact import coulomb, friction_slope, frictionless, stick_slip
from hydrosim.elements.contact.law import OPEN, SLIP, STICK, Constants
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel
from hydrosim.scene.contacts import Coulomb, Frictionless, FrictionSlope, Law, StickSlip

LAWS: dict[type, ModuleType] = {
    Frictionless: frictionless,
    StickSlip: stick_slip,
    FrictionSlope: friction_slope,
    Coulomb: coulomb,
}
FRICTIONLESS, STICK_SLIP, FRICTION_SLOPE, COULOMB = range(len(LAWS))
FORGETFUL = (FRICTIONLESS, FRICTION_SLOPE)
"""Laws whose state has no meaning after a restart."""
FIELDS = ("law", *Constants._fields)
LAW = [(name, {"law": int, "node": bool}.get(name, float)) for name in FIELDS]
"""Fields of a contact point's friction."""


def constants(law: Law) -> tuple[Any, ...]:
    """Number and constants of a law, the values of `LAW`; raises InputError for an unknown law."""
    for number, (kind, home) in enumerate(LAWS.items()):
        if isinstance(law, kind):
            return (number, *home.constants(law))
    law_names = ", ".join(kind.__name__ for kind in LAWS)
    raise InputError(f"friction: found {type(law).__name__}; expected one of {law_names}.")


def break_away_stretch(law: Law, N: float) -> float:
    """Stretch [m] at which a node breaks away under ``N`` [N], at least that under 1 N; 0 without a
    node."""
    return stick_slip.break_away_stretch(law, N) if isinstance(law, StickSlip) else 0.0


@kernel
def friction(mode, load, v, s, p):
    """Friction of a point."""
    if p.law == STICK_SLIP:
        return stick_slip.friction(mode, load, v, s, p)
    if p.law == FRICTION_SLOPE:
        return friction_slope.friction(mode, load, v, s, p)
    if p.law == COULOMB:
        return coulomb.friction(mode, load, v, s, p)
    return frictionless.friction(mode, load, v, s, p)


@kernel
def margin(mode, load, v, s, heading, reaction, p):
    """Margin of a point to the end of stick or slip."""
    if p.law == STICK_SLIP:
        return stick_slip.margin(mode, load, v, s, heading, p)
    if p.law == FRICTION_SLOPE:
        return friction_slope.margin(mode, load, v, heading, p)
    if p.law == COULOMB:
        return coulomb.margin(mode, load, v, s, reaction, p)
    return frictionless.margin(mode)


@kernel
def slip_direction(load, v, s, p):
    """Vector (2,) along which a point slips: usually its velocity."""
    if p.law == STICK_SLIP:
        return stick_slip.slip_traction(load, v, s, p)
    return v


@kernel
def keeps_slip_direction(p):
    """True if the state of a point that slips is its heading."""
    return p.law in (FRICTION_SLOPE, COULOMB)


@kernel
def break_away(load, v, s, reaction, p):
    """Slip begins: the state (2,), the jump of the node, and the energy lost in it."""
    if p.law == STICK_SLIP:
        return stick_slip.break_away(load, v, s, p)
    if p.law == FRICTION_SLOPE:
        return friction_slope.break_away(v)
    if p.law == COULOMB:
        return coulomb.break_away(reaction)
    return s, 0.0, 0.0


@kernel
def end_slip(size, load, v, s, p):
    """Slip ends, by a margin that had this ``size`` before: mode and state (2,)."""
    if p.law == STICK_SLIP:
        return stick_slip.end_slip(load, v, s, p)
    if p.law == COULOMB:
        return coulomb.end_slip(size, v, s)
    return STICK, s


@kernel
def begin_contact(load, v, s, p):
    """Contact begins: mode and state (2,)."""
    if p.law == STICK_SLIP:
        return stick_slip.begin_contact(load, v, s, p)
    if p.law == FRICTION_SLOPE:
        return friction_slope.begin_contact(load, v, p)
    if p.law == COULOMB:
        return coulomb.begin_contact(v)
    return SLIP, s


@kernel
def end_contact(mode, load, v, s, p):
    """Contact ends: the state (2,), and the energy lost."""
    if p.law == STICK_SLIP:
        return stick_slip.end_contact(mode, load, v, s, p)
    return s, 0.0


@kernel
def open_node_friction(load, s, p):
    """`Friction` of the node of an open point."""
    return stick_slip.friction(OPEN, load, (0.0, 0.0), s, p)


@kernel
def reverse_load(load, s, p):
    """The stretch (2,) of a node for the same traction, when the load begins to fall or to rise."""
    return stick_slip.reverse_load(load, s, p)


@kernel
def stored_energy(mode, load, v, s, p):
    """Energy in the stretch of a node."""
    return stick_slip.stored_energy(mode, load, v, s, p) if p.node else 0.0


@kernel
def recoverable_loss(mode, load, v, s, p):
    """Part of the integrated dissipation that is still stored."""
    return stick_slip.recoverable_loss(mode, load, v, s, p) if p.node else 0.0


@kernel
def node_stretch(mode, load, v, s, p):
    """Distance (2,) of the node from the body's point."""
    return stick_slip.node_stretch(mode, load, v, s, p) if p.node else (0.0, 0.0)


def steady_slip_state(N: float, velocity: np.ndarray, p: np.void) -> Any:
    """State (2,) of a point in steady slip, to linearise about; None if it has no influence."""
    if p["law"] == STICK_SLIP:
        return stick_slip.steady_slip_stretch(N, p)
    return coulomb.slip_heading(velocity) if p["law"] == COULOMB else None


def least_slip_speed(N: float, p: np.void) -> float:
    """The speed [m/s] at which a point without a node begins to slip under ``N`` [N]."""
    return friction_slope.corner_speed(N, p) if p["law"] == FRICTION_SLOPE else 0.0
