"""Names of what is in the arrays: rows of forces, coordinates, contact points, entries of y."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.forces import Contact, Spring
from hydrosim.forces.ballast.events import triggered_pumps
from hydrosim.forces.ballast.tanks import flow_names, tank_names
from hydrosim.forces.contact import fender, tally
from hydrosim.forces.contact.fender import STATE_NAMES
from hydrosim.forces.contact.group import STATE_NAMES as OF_GROUP
from hydrosim.forces.contact.loop import STATE_NAMES as REMEMBERED
from hydrosim.forces.layout import (
    BALLAST,
    RADIATION,
    ROWS,
    WAVE_FIRST_ORDER,
    WAVE_SECOND_ORDER,
    WEIGHT,
    has_flow,
    row_names,
)
from hydrosim.scene import ForceElement, Scene
from hydrosim.stepping.dynamics import Model
from hydrosim.waves import slow_bodies
from hydrosim.waves.slow import NAMES as SLOW_NAMES

WAVES = (ROWS[WAVE_FIRST_ORDER], ROWS[WAVE_SECOND_ORDER])
MOVING = (*(f"{dof} of " for dof in DOFS), "rate of ", "radiation ")
"""Beginnings of the names of states that are not of contact points or energies."""


def force_names(scene: Scene) -> tuple[str, ...]:
    """Names of the rows of forces: the body's own and the elements'."""
    return row_names(scene)


def supplies(scene: Scene, row: int) -> bool:
    """True if what a row of forces does is booked as work, false if as dissipation."""
    element = element_of(scene, row)
    if element is not None:
        return element.supplies
    return force_names(scene)[row] in (*WAVES, *([WEIGHT, BALLAST] if has_flow(scene) else []))


def stores(scene: Scene, row: int) -> bool:
    """True if a row of forces may store energy."""
    return force_names(scene)[row] == WEIGHT or not (row == RADIATION or supplies(scene, row))


def loses(scene: Scene, row: int) -> bool:
    """True if a row of forces may take energy for good."""
    return row == RADIATION or (element_of(scene, row) is not None and not supplies(scene, row))


def element_of(scene: Scene, row: int) -> ForceElement | None:
    """The element whose row of forces it is; None if it is one of the bodies' own."""
    return scene.forces.get(force_names(scene)[row])


def dofs_of(dofs: Sequence[int] | np.ndarray, bodies: Sequence[str]) -> str:
    """Names of DOFs, six for each of the ``bodies``: "sway, roll of a and sway, roll of b"."""
    parts = [
        f"{', '.join(DOFS[dof % 6] for dof in dofs if dof // 6 == b)} of {name}"
        for b, name in enumerate(bodies)
        if any(dof // 6 == b for dof in dofs)
    ]
    return " and ".join(parts)


def coordinate_names(scene: Scene) -> list[str]:
    """Names of all free coordinates, "surge of barge", ..."""
    return [f"{dof} of {b.name}" for b in scene.bodies for dof in DOFS if dof in b.dofs]


def fender_names(scene: Scene) -> list[str]:
    """Names of all contact points, "element 1", "element 2", ..."""
    return _units(scene, Contact)


def remembering_names(scene: Scene, model: Model) -> list[str]:
    """Names of the contact points that remember how they were pressed."""
    names = fender_names(scene)
    return [names[i] for i in fender.which_remember(model.elements.fenders)]


def contact_groups(scene: Scene) -> list[str]:
    """Name of the group of each contact point: that of its element if it does not say another."""
    return [
        element.group or name
        for name, element in scene.forces.items()
        if isinstance(element, Contact)
        for _ in element.unit_names(name)
    ]


def group_names(scene: Scene, model: Model) -> list[str]:
    """Names of the groups of contacts that remember their stages."""
    names = [*dict.fromkeys(contact_groups(scene))]
    return [names[k] for k in model.elements.fenders.groups["index"]]


def spring_names(scene: Scene) -> list[str]:
    """Names of all springs."""
    return _units(scene, Spring)


def capacities(scene: Scene, kind: type[ForceElement]) -> np.ndarray:
    """What each unit of a kind of elements may carry [N]; NaN where that is not said."""
    each = [
        (e.capacity, len(e.unit_names(n))) for n, e in scene.forces.items() if isinstance(e, kind)
    ]
    known = [np.nan if capacity is None else capacity for capacity, _ in each]
    return np.repeat(np.array(known, float), [count for _, count in each])


def guide_names(scene: Scene) -> list[str]:
    """Names of the contact points that a wall holds sideways."""
    walled = ((name, e) for name, e in scene.forces.items() if getattr(e, "wall", None))
    return [unit for name, e in walled for unit in e.unit_names(name)]


def trigger_names(scene: Scene) -> list[str]:
    """Names of the elements that are active for a time only, and of pumps that wait for events."""
    named = [name for name, element in scene.forces.items() if element.active is not None]
    flows = flow_names(scene)
    return [*named, *(flows[pump.flow] for pump in triggered_pumps(scene))]


def _units(scene: Scene, kind: type[ForceElement]) -> list[str]:
    each = ((name, e) for name, e in scene.forces.items() if isinstance(e, kind))
    return [unit for name, e in each for unit in e.unit_names(name)]


def state_names(scene: Scene, model: Model) -> list[str]:
    """Names of all entries of y: coordinates, their rates, "radiation 1 of heave, pitch of barge",
    "slip distance of interface 1", "work of lift", "loss in mooring", ..."""
    return [
        *moving_names(scene, model),
        *(f"{what} of {name}" for name in fender_names(scene) for what in STATE_NAMES),
        *(f"{what} of {name}" for name in remembering_names(scene, model) for what in REMEMBERED),
        *(f"{what} of group {name}" for name in group_names(scene, model) for what in OF_GROUP),
        *(f"volume of {name}" for name in tank_names(scene)),
        *(f"time since {name} may act or end" for name in trigger_names(scene)),
        *slow_names(scene),
        *draught_names(scene, model),
        *(
            f"{'work of' if supplies(scene, row) else 'loss in'} {name}"
            for row, name in enumerate(force_names(scene))
        ),
        "integral of |wave power|",
        *(_impulse_names(scene) if scene.output_impulses else ()),
    ]


def _impulse_names(scene: Scene) -> Iterator[str]:
    """Names of the integrals of forces and their powers, and of what contact points did."""
    coordinates = [f"{dof} of {b.name}" for b in scene.bodies for dof in DOFS]
    for what in ("impulse", "work"):
        for row in force_names(scene):
            yield from (f"{what} of {row} on {name}" for name in coordinates)
    for name in fender_names(scene):
        yield from (f"tally {k + 1} of {name}" for k in range(tally.SIZE))


def slow_names(scene: Scene) -> list[str]:
    """Names of the states of slow places in waves."""
    return [f"{what} of {body.name}" for body in slow_bodies(scene) for what in SLOW_NAMES]


def draught_names(scene: Scene, model: Model) -> list[str]:
    """Names of the filters of slow draughts."""
    owners = [scene.bodies[b].name for b in model.family.body]
    return [f"slow heave filter {k} of {name}" for name in owners for k in (1, 2)]


def moving_names(scene: Scene, model: Model) -> dict[str, list[str]]:
    """Names of the first entries of y, coordinates, rates and radiation, and of the coordinates
    that each belongs to."""
    coordinates = coordinate_names(scene)
    return {
        **{name: [name] for name in coordinates},
        **{f"rate of {name}": [name] for name in coordinates},
        **_radiation_names(scene, model),
    }


def memory_names(scene: Scene, model: Model) -> list[str]:
    """Names of the coordinates whose velocities a convolution remembers."""
    return [_coordinate(scene, model, dof) for dof in np.unique(model.convolution.column)]


def _radiation_names(scene: Scene, model: Model) -> dict[str, list[str]]:
    states, family, bodies = model.states, model.family, [body.name for body in scene.bodies]
    members = zip(family.owner, family.draught, strict=True)
    bodies += [f"{scene.bodies[b].name} at {draught:g} m" for b, draught in members]
    # the model may repeat the last DOF of a group
    groups = [[*dict.fromkeys(states.dof[a:b].tolist())] for a, b in pairwise(states.member)]
    return {
        f"radiation {k + 1} of {dofs_of(dofs, bodies)}": [
            _coordinate(scene, model, dof) for dof in dofs
        ]
        for dofs, count in zip(groups, np.diff(states.state), strict=True)
        for k in range(count)
    }


def _coordinate(scene: Scene, model: Model, dof: int) -> str:
    """Of a body, or of the one that a member of a family is for."""
    body = dof // 6 - len(scene.bodies)
    owner = dof // 6 if body < 0 else model.family.owner[body]
    return f"{DOFS[dof % 6]} of {scene.bodies[owner].name}"
