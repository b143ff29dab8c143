"""Dry friction along a coordinate, by stick-slip with an elastic node.

    sticks:   T = k (x - z) + c x',   while |k (x - z)| < static force
    slips:    T = +- kinetic force, against the motion, while the motion goes on

z: place of the node, a state, which stands while the link sticks and then moves with it. Slip
begins at the static force and ends where x' = 0: the node is then where the spring holds the
kinetic force. Both are events.
Stored energy is that of the spring. c x'^2 is dissipated in stick, all work in slip. What the
spring loses where its force falls from the static to the kinetic one is booked as a loss.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hydrosim.elements.link.law import ANYWHERE, LinkClass, load_and_place
from hydrosim.jit.kernels import kernel
from hydrosim.modes import FRICTION_MARGIN, SEGMENT
from hydrosim.scene.links import DryFriction

STICKS, SLIPS_UP, SLIPS_DOWN = range(3)

FRICTION = np.dtype([("static", float), ("kinetic", float), ("stiffness", float)])
"""Constants of dry friction: static and kinetic force, k."""


def law_fields(friction: DryFriction, _: np.ndarray) -> dict[str, Any]:
    """Fields of `LINK` of dry friction."""
    return {
        "last": SLIPS_DOWN,
        "steepest": friction.stiffness,
        "idle": SLIPS_UP,
        "idle_range": ANYWHERE,
        "stiff": STICKS,
        "stiff_range": ANYWHERE,
        "damping": friction.damping,
    }


def constants(friction: DryFriction) -> np.ndarray:
    """Its constants (1,) of `FRICTION`."""
    return np.array([(friction.static, friction.kinetic, friction.stiffness)], dtype=FRICTION)


DRY_FRICTION = LinkClass(
    *(DryFriction, "dry_friction", load_and_place("dry_friction"), law_fields),
    constants=constants,
    state_names=("node",),
)


@kernel
def _spring_load(friction, mode, s, node):
    """The load of the spring."""
    if mode[SEGMENT] == STICKS:
        return friction.stiffness * (s.x - node)
    return friction.kinetic if mode[SEGMENT] == SLIPS_UP else -friction.kinetic


@kernel
def find_loads(link, friction, mode, s, node):
    """T, and the power that it dissipates."""
    f = _spring_load(friction, mode, s, node)
    if mode[SEGMENT] != STICKS:
        return f, f * s.rate
    lost = link.damping * s.rate
    return f + lost, lost * s.rate


@kernel
def stored_energy(friction, mode, s, node):
    """Energy of the spring."""
    f = _spring_load(friction, mode, s, node)
    return 0.5 * f * f / friction.stiffness


@kernel
def find_margins(friction, mode, s, node, out):
    """Margins (4,): the force that is left before slip, or the rate of slip."""
    if mode[SEGMENT] == STICKS:
        out[FRICTION_MARGIN] = friction.static - abs(friction.stiffness * (s.x - node))
    else:
        out[FRICTION_MARGIN] = s.rate if mode[SEGMENT] == SLIPS_UP else -s.rate


@kernel
def transition(friction, mode, s, node):
    """The next mode; returns the node, and the energy [J] that is lost."""
    f = _spring_load(friction, mode, s, node)
    if mode[SEGMENT] != STICKS:
        mode[SEGMENT] = STICKS
        return s.x - f / friction.stiffness, 0.0
    mode[SEGMENT] = SLIPS_UP if f > 0.0 else SLIPS_DOWN
    lost = 0.5 * (f * f - friction.kinetic * friction.kinetic) / friction.stiffness
    return node, lost
