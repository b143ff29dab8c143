"""A start at rest under the loads at the start: contacts, lines and buoyancy carry all loads.

`hydrosim.linear.equilibrium` finds the position, without waves and without friction, near the
initial position of the scene. Contacts begin there with unstretched springs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.forces import without_friction
from hydrosim.forces.contact.geometry import contact_kinematics
from hydrosim.forces.contact.modes import OPEN
from hydrosim.linear.equilibrium import RESIDUAL_RTOL, equilibrium
from hydrosim.modes import MODE
from hydrosim.rigid.kinematics import place_bodies
from hydrosim.stepping.dynamics import Model, new_work
from hydrosim.stepping.names import contact_names, coordinates

if TYPE_CHECKING:
    from hydrosim.scene import Scene
    from hydrosim.stepping.state import State

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
            f" {lost.name}{_nearest(scene, model, rest.state)}; expected supports, lines or"
            " buoyancy that carry it."
        )
    return rest.state.y


def _nearest(scene: Scene, model: Model, state: State) -> str:
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
