"""Loading conditions of bodies with tanks: what they weigh, how they float, how stable they are.

At rest without waves, weight and buoyancy balance with all else that holds the bodies; from the
stiffness K there, the metacentric heights K / (m g), which free surfaces have lowered by J / m
(`forces.weight`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hydrosim.compiling.compiled import Compiled
from hydrosim.forces.ballast.loading import Loading, at_start, loaded
from hydrosim.forces.ballast.pieces import LEVEL, at
from hydrosim.forces.ballast.shapes import capacity, pieces
from hydrosim.forces.ballast.tanks import changing
from hydrosim.forces.ballast.timeline import follow
from hydrosim.linear.equilibrium import equilibrium
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import STATIC
from hydrosim.scene import Body, Tank
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.state import State


class TankState(NamedTuple):
    """A tank with its ``level`` [m], the ``mass`` [kg] in it, and how far it is ``filled``."""

    tank: Tank
    level: float
    mass: float
    filled: float


@dataclass(frozen=True)
class Condition:
    """A body with what is in its ``tanks``: its ``loading`` in the database's frame and that of the
    ``lightship``; its ``position`` (6,) at rest; ``metacentric`` heights [m] of heel and trim (NaN
    where it cannot turn), and the ``loss`` by free surfaces in them."""

    body: Body
    loading: Loading
    lightship: Loading
    tanks: tuple[TankState, ...]
    position: np.ndarray
    metacentric: np.ndarray
    loss: np.ndarray


class Afloat(NamedTuple):
    """All bodies at rest: ``position`` (nb, 6), and the stiffness K (6 nb, 6 nb), zero where a
    coordinate is locked."""

    position: np.ndarray
    stiffness: np.ndarray


def volumes_at(compiled: Compiled, time: float) -> np.ndarray:
    """Volumes (nt,) [m^3] in the tanks that change, at a time [s], before any of them runs over."""
    p = compiled.model.elements.tanks
    return follow(p, max(time, 1e-9)).at(time) if p.each.size else np.zeros(0)


def pumped(compiled: Compiled, time: float) -> State:
    """The state of the start with what is in the tanks at a time [s]."""
    state, p = compiled.first_state(), compiled.model.elements.tanks
    state.y[p.state : p.state + p.each.size] = volumes_at(compiled, time)
    return state


def afloat(compiled: Compiled, volume: np.ndarray, time: float = 0.0) -> Afloat:
    """The bodies at rest with so much in their tanks. Raises InputError if they are at rest
    nowhere."""
    model, state, scene = _still(compiled.model), compiled.first_state(), compiled.scene
    p, n = model.elements.tanks, model.bodies.active.size
    state.y[p.state : p.state + p.each.size] = volume
    state.y[n : 2 * n] = 0.0
    weight = sum(body.mass for body in scene.bodies) * scene.environment.gravity
    rest = equilibrium(model, state, time, weight)
    linear = linearise(rest.model, rest.state, time=time)
    K = np.zeros((6 * len(scene.bodies),) * 2)
    K[np.ix_(linear.active, linear.active)] = linear.dynamic_stiffness(np.array([STATIC]))[0].real
    return Afloat(rest.position, K)


def _still(model: Model) -> Model:
    """The model with nothing flowing."""
    p = model.elements.tanks
    rates = p.rates.copy()
    rates["rate"] = 0.0
    return model._replace(elements=model.elements._replace(tanks=p._replace(rates=rates)))


def conditions(compiled: Compiled, time: float = 0.0) -> list[Condition]:
    """Of all bodies with tanks, at a time [s]. Raises InputError where there is no rest."""
    volume, scene = volumes_at(compiled, time), compiled.scene
    found = afloat(compiled, volume, time)
    moved = iter(volume)
    each = []
    for b, body in enumerate(scene.bodies):
        own = {tank.name: float(next(moved)) for tank in changing(body)}
        held = [(t, own.get(t.name, v)) for t, v in at_start(body.tanks)]
        if held:
            angles = slice(6 * b + 3, 6 * b + 5)
            stiffness = np.diag(found.stiffness)[angles]
            g = scene.environment.gravity
            each.append(_condition(body, held, found.position[b], stiffness / g))
    return each


def _condition(
    body: Body, held: Sequence[tuple[Tank, float]], position: np.ndarray, righting: np.ndarray
) -> Condition:
    empty = loaded(
        body.mass, body.centre_of_gravity, np.array(body.inertia), at_start(body.tanks), -1.0
    )
    full = loaded(empty.mass, empty.centre, empty.inertia, held)
    free = np.array([dof in body.dofs for dof in ("roll", "pitch")])
    return Condition(
        body,
        full,
        empty,
        tuple(_tank_state(tank, volume) for tank, volume in held),
        position,
        np.where(free, righting / full.mass, np.nan),
        full.surface[[2, 0]] / full.mass,
    )


def _tank_state(tank: Tank, volume: float) -> TankState:
    level = at(pieces(tank.shape, np.zeros(3)), volume)[LEVEL]
    whole = capacity(tank.shape)
    return TankState(tank, float(level), tank.density * volume, volume / whole)
