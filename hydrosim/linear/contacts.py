"""Contacts that are pressed where a scene is at rest, made linear.

Friction that holds is linear: a contact node that sticks is the spring K2 with the damper C2
between body and plane, and a friction slope below its limit is a damper. Friction that slips is
not, and rigid friction holds without any motion; so contacts are taken as held by their nodes, as
without friction, or as open, and all else is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces import without_friction
from hydrosim.forces.contact.laws import COULOMB, FRICTIONLESS
from hydrosim.forces.contact.modes import OPEN, STICK
from hydrosim.modes import MODE
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.state import State


class Contacts(StrEnum):
    """What contacts that are pressed at rest do: friction holds them, they slide freely, or they
    are open, as if there were none."""

    STUCK = "stuck"
    SLIDING = "sliding"
    OPEN = "open"


def pressed(model: Model, state: State) -> np.ndarray:
    """Indices (k,) of the contact points that are not open."""
    return np.flatnonzero(state.modes[: model.elements.fenders.points.size, MODE] != OPEN)


def with_contacts(
    model: Model, rest: State, contacts: Contacts, names: Sequence[str]
) -> tuple[Model, State]:
    """The model, and the state at ``rest`` with its contact points, called ``names``, as
    ``contacts`` has them. Raises InputError where rigid friction would hold them."""
    modes, points = rest.modes.copy(), pressed(model, rest)
    law = model.elements.fenders.points["law"]
    if contacts == Contacts.STUCK:
        rigid = [names[i] for i in points[law[points] == COULOMB]]
        if rigid:
            raise InputError(
                f"contacts: rigid friction (coulomb) holds {', '.join(rigid)} at rest, and leaves"
                " no motion there to be linear. Take stick_slip with a stiffness, or contacts"
                f" {Contacts.SLIDING} (no friction) or {Contacts.OPEN}."
            )
        modes[points[law[points] != FRICTIONLESS], MODE] = STICK
        return model, rest._replace(modes=modes)
    if contacts == Contacts.OPEN:
        modes[points, MODE] = OPEN
    smooth = model._replace(elements=without_friction(model.elements))
    return smooth, rest._replace(modes=modes)
