"""State at the start of a run: at rest with offsets, under loads, or the state of an earlier run.

At rest under loads, `hydrosim.linear.equilibrium` finds the position near the initial one, without
waves and without friction. Contacts begin there with unstretched springs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compile import restart
from hydrosim.compile.closed_joints import keep_independent_rows, start_followers
from hydrosim.compile.drives import follow_at
from hydrosim.dofs import DOFS
from hydrosim.elements import new_modes, without_friction
from hydrosim.elements.contact.geometry import contact_kinematics
from hydrosim.elements.contact.law import OPEN
from hydrosim.elements.events import set_initial_modes
from hydrosim.errors import InputError
from hydrosim.integrate.draught_interpolation import steady_filters
from hydrosim.integrate.dynamics import Model, motion_at, new_work
from hydrosim.integrate.names import StateLayout, contact_names, coordinates
from hydrosim.integrate.state import State
from hydrosim.linear.equilibrium import RESIDUAL_RTOL, equilibrium
from hydrosim.modes import MODE
from hydrosim.multibody.kinematics import Bodies, Motion, place_bodies
from hydrosim.water import radiation
from hydrosim.water.displaced_loads import grid_step
from hydrosim.water.slow_path_loads import first_states

if TYPE_CHECKING:
    from hydrosim.scene import Scene, WaveForces

# Start at rest under loads: contacts, lines and buoyancy carry all of them.

PROMISE = "found at_rest"
AT_REST_ATOL_M = 1e-6  # m


def states_at_rest(scene: Scene, model: Model, state: State) -> np.ndarray:
    """States (ny,) at rest near ``state``, without the states of contacts.

    Raises InputError if there is no such position, and names the load that nothing carries.
    """
    weight = sum(body.mass for body in scene.bodies) * scene.environment.gravity
    smooth = model._replace(elements=without_friction(model.elements))
    try:
        rest = equilibrium(smooth, state, 0.0, weight)
    except InputError as error:
        remedy = (
            "Supports carry loads along their axis. Place them on both sides of the centre"
            " of gravity."
        )
        raise InputError(f"initial: {PROMISE}; {error} {remedy}") from None
    if np.abs(rest.drift).max(initial=0.0) > RESIDUAL_RTOL * weight:
        worst = int(np.abs(rest.drift).argmax())
        lost = coordinates(scene)[worst]
        unit = "N" if lost.dof in DOFS[:3] else "N m"
        raise InputError(
            f"initial: {PROMISE}, and nothing carries {rest.drift[worst]:.4g} {unit} in"
            f" {lost.name}{_nearest_note(scene, model, rest.state)}; expected supports, lines or"
            " buoyancy that carry it."
        )
    return rest.state.y


def _nearest_note(scene: Scene, model: Model, state: State) -> str:
    """Text on the nearest open contact, for a body that hovers over it."""
    fenders = model.elements.fenders
    motion = new_work(model).motion
    n = model.bodies.active.size
    place_bodies(state.y[:n], np.zeros(n), model.bodies, motion)
    gaps = {
        name: -contact_kinematics(point, model.bodies, motion).compression
        for name, point, mode in zip(
            contact_names(scene), fenders.points, state.modes[fenders.mode :], strict=False
        )
        if mode[MODE] == OPEN
    }
    if not gaps:
        return ""
    name = min(gaps, key=gaps.__getitem__)
    if gaps[name] < AT_REST_ATOL_M:
        return f" (the nearest contact, {name}, touches but does not carry in that direction)"
    return (
        f" (the nearest open contact, {name}, is {gaps[name]:.3g} m away: move the body towards"
        " it by this distance with its initial.position)"
    )


def first_state(scene: Scene, model: Model) -> State:
    """State of a start from rest with the scene's offsets and velocities, or at the equilibrium
    near them if the scene asks for it."""
    bodies = model.bodies
    n = model.bodies.active.size
    y = np.zeros(model.size)
    y[:n] = np.concatenate([bodies.locked, bodies.tree.start[:, 0]])[bodies.active]
    tanks = model.tanks
    y[tanks.state : tanks.state + tanks.each.size] = tanks.each["first_volume"]
    modes = new_modes(model)
    motion = new_work(model).motion
    y[model.draught : model.energy] = steady_filters(model.family, bodies.locked)
    speeds = np.concatenate([b.velocity for b in scene.bodies])
    y[n : 2 * n] = _start_rates(bodies, motion, y[:n], speeds)
    follow_at(0.0, y, model)
    place_bodies(y[:n], y[n : 2 * n], bodies, motion)
    set_initial_modes(0.0, y, modes, motion, bodies, model.elements, tanks)
    state = State(y, modes, _start_history(scene, model))
    keep_independent_rows(model, state)
    start_followers(model, state)
    if scene.at_rest:
        y[:] = states_at_rest(scene, model, state)
        follow_at(0.0, y, model)
        place_bodies(y[:n], y[n : 2 * n], bodies, motion)
        set_initial_modes(0.0, y, modes, motion, bodies, model.elements, tanks)
        start_followers(model, state)
    return state


def start_of(scene: Scene, model: Model, layout: StateLayout, fresh: State) -> State:
    """State that a scene of `open_start` starts from. ``fresh`` is its `first_state`, ``layout`` is
    the layout of y.

    Raises InputError if the run to start from does not fit the scene.
    """
    if scene.initial is None:
        return fresh
    restart.check_fit(scene, model, layout)
    return restart.resumed_state(scene, model, layout, fresh)


def with_slow_places(
    scene: Scene, model: Model, met: Mapping[str, WaveForces], state: State
) -> State:
    """The state with slow positions in waves of bodies that have always moved as they do now. Slow
    positions of an earlier run are kept. ``met`` has the positions where waves act, by body."""
    if not model.following.slow.any() or restart.has_slow_places(scene, met):
        return state
    y = state.y.copy()
    motion = motion_at(model, y)
    places = first_states(
        model.following, motion.coordinates, motion.rate, restart.start_time(scene)
    )
    y[model.slow : model.draught] = places
    return state._replace(y=y)


def _start_rates(bodies: Bodies, motion: Motion, q: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Rates of the free coordinates for given velocities (6 nb,). Rates of angles are E^-1
    omega."""
    place_bodies(q, np.zeros_like(q), bodies, motion)
    rates = velocity.astype(float).copy()
    for b in range(bodies.each.size if bodies.exact else 0):
        angles = slice(6 * b + 3, 6 * b + 6)  # those of jointed bodies are not used
        rates[angles] = np.linalg.solve(motion.rate_map[b], velocity[angles])
    return np.concatenate([rates, bodies.tree.start[:, 1]])[bodies.active]


def _start_history(scene: Scene, model: Model) -> radiation.VelocityHistory:
    """Arrays for the memory of a convolution."""
    own_dofs = model.bodies.each.size + model.family.owner.size
    return radiation.new_history(model.convolution, 6 * own_dofs, grid_step(scene))
