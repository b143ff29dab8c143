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

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from hydrosim.elements.link.coordinate import CoordinateElement
from hydrosim.elements.link.law import ANYWHERE, Link, load_and_place
from hydrosim.jit.kernels import kernel
from hydrosim.modes import FRICTION_MARGIN, SEGMENT

STICKS, SLIPS_UP, SLIPS_DOWN = range(3)

FRICTION = np.dtype([("static", float), ("kinetic", float), ("stiffness", float)])
"""Constants of dry friction: static and kinetic force, k."""


@dataclass(frozen=True, kw_only=True)
class DryFriction(CoordinateElement, Link):
    """The ``static`` and the ``kinetic`` force [N or N m]; the ``stiffness`` [N/m or N m/rad] and
    the ``damping`` [N s/m or N m s/rad] while it sticks."""

    dimension = "dry_friction"
    columns: ClassVar = load_and_place(dimension)
    state_names: ClassVar[Sequence[str]] = ("node",)
    static: float
    kinetic: float
    stiffness: float
    damping: float = 0.0

    def law_fields(self, curve: np.ndarray) -> dict[str, Any]:
        return {
            "last": SLIPS_DOWN,
            "steepest": self.stiffness,
            "idle": SLIPS_UP,
            "idle_range": ANYWHERE,
            "stiff": STICKS,
            "stiff_range": ANYWHERE,
            "damping": self.damping,
        }

    def constants(self) -> np.ndarray:
        return np.array([(self.static, self.kinetic, self.stiffness)], dtype=FRICTION)


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
