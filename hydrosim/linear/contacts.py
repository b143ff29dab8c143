"""Linear models of contacts that are pressed where a scene is at rest.

Friction that holds is linear. A sticking contact node is the spring K2 with the damper C2 between
body and plane. A friction slope below its limit is a damper. Rigid friction is a constraint: no
motion along the plane at its point.

Friction that slips is not linear. So contacts are treated as held, as frictionless, or as open.
Constraints that leave no motion are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces import without_friction
from hydrosim.forces.contact.laws import COULOMB, FRICTIONLESS
from hydrosim.forces.contact.modes import OPEN, STICK
from hydrosim.linear.coordinates import inertia
from hydrosim.linear.freedom import find_constraint_rows, nullspace_of
from hydrosim.modes import MODE, NO_INDEX
from hydrosim.rigid.kinematics import place_bodies
from hydrosim.stepping.dynamics import Model, add_constraints, new_work
from hydrosim.stepping.state import State


class Contacts(StrEnum):
    """State of contacts that are pressed at rest: friction holds them, they slide freely, or they
    are open, as if they did not exist."""

    STUCK = "stuck"
    SLIDING = "sliding"
    OPEN = "open"


def pressed_points(model: Model, state: State) -> np.ndarray:
    """Indices (k,) of the contact points that are not open."""
    return np.flatnonzero(state.modes[: model.elements.fenders.points.size, MODE] != OPEN)


def with_contacts(
    model: Model, rest: State, contacts: Contacts, names: Sequence[str]
) -> tuple[Model, State]:
    """The model and the state at ``rest``, with its contact points, called ``names``, in the state
    ``contacts``. Raises InputError if rigid friction leaves no motion."""
    modes = rest.modes.copy()
    points = pressed_points(model, rest)
    law = model.elements.fenders.points["law"]
    if contacts == Contacts.STUCK:
        modes[points[law[points] != FRICTIONLESS], MODE] = STICK
        rigid = [names[i] for i in points[law[points] == COULOMB]]
        if rigid and not _leaves_motion(model, rest.y, modes):
            raise InputError(
                f"contacts: rigid friction (coulomb) holds {', '.join(rigid)} at rest, so that"
                " nothing can move. Use stick_slip with a stiffness, or contacts"
                f" {Contacts.SLIDING} (no friction) or {Contacts.OPEN}."
            )
        return model, rest._replace(modes=modes)
    if contacts == Contacts.OPEN:
        modes[points, MODE] = OPEN
    smooth = model._replace(elements=without_friction(model.elements))
    return smooth, rest._replace(modes=modes)


def _leaves_motion(model: Model, y: np.ndarray, modes: np.ndarray) -> bool:
    """True if constraints leave any motion."""
    freedom = nullspace_of(find_constraint_rows(model, y, modes), inertia(model, y))
    return freedom.is_unconstrained or freedom.basis.shape[1] > 0


def find_rigid_tractions(model: Model, state: State, forces: np.ndarray) -> np.ndarray:
    """Friction (..., points, 2) of all contact points along their planes, from ``forces`` (..., m)
    of constraints in a ``state``."""
    n = model.bodies.active.size
    work = new_work(model)
    place_bodies(state.y[:n], np.zeros(n), model.bodies, work.motion)
    add_constraints(state.y, state.modes, model, work)
    points = model.elements.fenders.points.size
    found = np.zeros((*forces.shape[:-1], points, 2), dtype=forces.dtype)
    for r in np.flatnonzero(work.holds.point[: forces.shape[-1]] != NO_INDEX):
        found[..., work.holds.point[r], :] += forces[..., r, None] * work.holds.direction[r]
    return found
