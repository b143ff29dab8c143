"""Loading conditions of bodies with tanks: weight, flotation and stability.

At rest without waves, weight and buoyancy balance all other loads that hold the bodies. Metacentric
heights are those of weight and buoyancy alone, K / (m g), with the stiffness K in heel or trim at
constant displacement. They include the loss J / m by free surfaces (`forces.weight`), with the
second moments J of the surfaces at rest. These values are slopes at rest, even if a surface soon
meets bottom or top. Beyond that angle less is lost: at a heel phi, the loss is the moment over m g
sin(phi), a secant. With the stiffness of lines and contacts, the heights describe the stability of
the body as it is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compiling.derived import facts_of
from hydrosim.errors import InputError
from hydrosim.forces import without_friction
from hydrosim.forces.layout import HYDROSTATIC, WEIGHT, row_names
from hydrosim.linear.coordinates import STEP, without_waves
from hydrosim.linear.equilibrium import WIDE, equilibrium, stiffness_of
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import STATIC
from hydrosim.scene import FreeSurface
from hydrosim.studies.ballast.surfaces import FreeSurfaces
from hydrosim.tanks.contents import changing_tanks
from hydrosim.tanks.loading import Loading, at_start, body_without, loaded_body
from hydrosim.tanks.pieces import FLUID_LEVEL, quantities_at
from hydrosim.tanks.shapes import capacity, heel_and_trim, pieces
from hydrosim.tanks.timeline import integrate_tanks

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Body, Scene, Tank
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state import State


MIN_DIFFERENCE_STEP = 1e-8  # m, rad: finer differences are lost in rounding


class TankState(NamedTuple):
    """A tank with its ``level`` [m], the ``mass`` [kg] in it, the fraction ``filled``, and the
    ``reach`` (2,) of its free surface: heel and trim [rad] at which it meets bottom or top."""

    tank: Tank
    level: float
    mass: float
    filled: float
    reach: np.ndarray


@dataclass(frozen=True)
class Condition:
    """A body with its ``tanks``: its ``loading`` in the database's frame, that of the
    ``lightship``, and its ``position`` (6,) at rest. ``metacentric`` heights [m] are for heel and
    trim (NaN if it cannot turn), ``loss`` is the part lost by free surfaces, ``held`` are the
    heights as it is held. ``secant`` is the loss at a heel (NaN if none is requested, or if the
    body cannot heel)."""

    body: Body
    loading: Loading
    lightship: Loading
    tanks: tuple[TankState, ...]
    position: np.ndarray
    metacentric: np.ndarray
    loss: np.ndarray
    held: np.ndarray
    secant: float


class FloatingEquilibrium(NamedTuple):
    """All bodies at rest: ``position`` (nb, 6), and the stiffness K (6 nb, 6 nb), zero for locked
    coordinates. One K is that of all loads, the other, ``floating``, that of weight and buoyancy
    alone."""

    position: np.ndarray
    stiffness: np.ndarray
    floating: np.ndarray


def volumes_at(compiled: Compiled, time: float) -> np.ndarray:
    """Volumes (nt,) [m^3] in the changing tanks at a time [s], before any of them overflows."""
    p = compiled.model.tanks
    return integrate_tanks(p, max(time, 1e-9)).volumes_at(time) if p.each.size else np.zeros(0)


def state_with_contents_at(compiled: Compiled, time: float) -> State:
    """State at the start with the tank contents at a time [s]."""
    state = compiled.first_state()
    p = compiled.model.tanks
    state.y[p.state : p.state + p.each.size] = volumes_at(compiled, time)
    return state


def with_contents_at(compiled: Compiled, time: float) -> Compiled:
    """Scene without waves, with its tank contents at a time [s] and, if there is an equilibrium,
    with its bodies and their slow draught there. The linearisation is about this state. The table
    of wave loads along a slow path covers only the block that contains the state."""
    state = state_with_contents_at(compiled, time)
    scene = compiled.scene
    waveless = without_waves(compiled.model)
    no_flows = _without_flows(waveless)
    frictionless = no_flows._replace(elements=without_friction(no_flows.elements))
    weight = sum(body.mass for body in scene.bodies) * scene.environment.gravity
    n = frictionless.bodies.active.size
    slow = slice(frictionless.draught, frictionless.energy)
    y = state.y.copy()
    y[n : 2 * n] = 0.0
    try:
        rest = equilibrium(
            frictionless, state._replace(y=y, modes=state.modes.copy()), time, weight
        )
        y[:n] = rest.state.y[:n]
        y[slow] = rest.state.y[slow]
    except InputError:
        y[:n] = state.y[:n]
        y[slow] = state.y[slow]
    facts = facts_of(scene, compiled.wet, waveless)
    return replace(compiled, facts=facts, state=state._replace(y=y))


def floating_equilibrium(
    compiled: Compiled, volume: np.ndarray, time: float = 0.0, within: float = np.inf
) -> FloatingEquilibrium:
    """Equilibrium with these tank contents, and the stiffness there, by differences ``within`` an
    angle [rad]. Raises InputError if there is no equilibrium."""
    model = _without_flows(compiled.model)
    state = compiled.first_state()
    scene = compiled.scene
    p = model.tanks
    n = model.bodies.active.size
    state.y[p.state : p.state + p.each.size] = volume
    state.y[n : 2 * n] = 0.0
    weight = sum(body.mass for body in scene.bodies) * scene.environment.gravity
    rest = equilibrium(model, state, time, weight)
    step = max(0.25 * within, MIN_DIFFERENCE_STEP)
    linear = linearise(rest.model, rest.state, time=time, step=min(step, STEP))
    rows = [k for k, row in enumerate(row_names(scene)) if k == HYDROSTATIC or row == WEIGHT]
    each = (
        linear.dynamic_stiffness(np.array([STATIC]))[0].real,
        stiffness_of(rest, rows, min(step, WIDE)),
    )
    whole = [np.zeros((6 * len(scene.bodies),) * 2) for _ in each]
    for K, own in zip(whole, each, strict=True):
        free = linear.active[linear.active < len(K)]  # joints have no loading condition
        K[np.ix_(free, free)] = own[: free.size, : free.size]
    return FloatingEquilibrium(rest.position, *whole)


def _without_flows(model: Model) -> Model:
    """Model without flows."""
    p = model.tanks
    rates = p.rates.copy()
    rates["rate"] = 0.0
    return model._replace(tanks=p._replace(rates=rates))


def conditions(compiled: Compiled, time: float = 0.0, heel: float | None = None) -> list[Condition]:
    """Conditions of all bodies with tanks at a time [s], with the loss by free surfaces at a
    ``heel`` [rad]. Raises InputError if there is no equilibrium."""
    volume = volumes_at(compiled, time)
    scene = compiled.scene
    contents = _contents(scene, volume)
    tanks = [[_tank_state(*item) for item in held] for held in contents]
    found = floating_equilibrium(compiled, volume, time, _least_reach([*chain(*tanks)]))
    surfaces = FreeSurfaces(compiled, volume, found.position)
    each = []
    for b, (body, held) in enumerate(zip(scene.bodies, contents, strict=True)):
        if held:
            g = scene.environment.gravity
            k = 6 * b + np.array([2, 3, 4])
            righting = [_righting(K[np.ix_(k, k)]) / g for K in (found.floating, found.stiffness)]
            lost = surfaces.slopes(b)
            lever = np.nan if heel is None else surfaces.lever(b, heel) / np.sin(heel)
            own = found.position[b]
            each.append(_condition(body, held, tanks[b], own, righting, lost, lever))
    return each


def _contents(scene: Scene, volume: np.ndarray) -> list[list[tuple[Tank, float]]]:
    """Tanks of each body with the volumes [m^3] in them; ``volume`` (nt,) are those of the changing
    tanks."""
    moved = iter(volume)
    each = []
    for body in scene.bodies:
        own = {tank.name: float(next(moved)) for tank in changing_tanks(body)}
        each.append([(tank, own.get(tank.name, v)) for tank, v in at_start(body.tanks)])
    return each


def _least_reach(tanks: Sequence[TankState]) -> float:
    """Smallest angle [rad] at which a free surface meets bottom or top; infinite if none does.
    Empty and full tanks have none."""
    angles = np.array([tank.reach for tank in tanks])
    return float(angles[angles > 0.0].min(initial=np.inf))


def _righting(K: np.ndarray) -> np.ndarray:
    """Stiffness in roll and pitch (2,) from that in heave, roll and pitch, (3, 3), with heave at
    constant displacement."""
    follows = K[0, 1:] * K[1:, 0] / K[0, 0] if K[0, 0] > 0.0 else np.zeros(2)
    return np.asarray(np.diag(K)[1:] - follows)


def _condition(
    body: Body,
    contents: Sequence[tuple[Tank, float]],
    tanks: Sequence[TankState],
    position: np.ndarray,
    righting: Sequence[np.ndarray],
    lost: np.ndarray,
    lever: float,
) -> Condition:
    empty = body_without(body, at_start(body.tanks))
    full = loaded_body(empty.mass, empty.centre, empty.inertia, contents)
    free = np.array([dof in body.dofs for dof in ("roll", "pitch")])
    return Condition(
        body,
        full,
        empty,
        tuple(tanks),
        position,
        np.where(free, righting[0] / full.mass, np.nan),
        lost / full.mass,
        np.where(free, righting[1] / full.mass, np.nan),
        lever / full.mass,
    )


def _tank_state(tank: Tank, volume: float) -> TankState:
    level = quantities_at(pieces(tank.shape, np.zeros(3)), volume)[FLUID_LEVEL]
    whole = capacity(tank.shape)
    free = tank.surface == FreeSurface.QUASI_STATIC
    reach = heel_and_trim(tank.shape, np.array([volume]))[0] if free else np.full(2, np.nan)
    return TankState(tank, float(level), tank.density * volume, volume / whole, reach)
