"""Test whether the motions of a run hold more energy than any source can have given.

The kinetic and stored energy of bodies is at most their energy at the start plus the energy
supplied since. Supplies are the work of waves, applied forces and streams, and energy from a
prescribed normal force or a damper in a current. A solution far beyond this bound is a numerical
artefact. The test finds friction and dampers that add energy, and unstable steps, long before
numbers overflow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.forces import losses
from hydrosim.forces.layout import RADIATION
from hydrosim.stepping.names import element_of, force_names, is_work_row
from hydrosim.stepping.record import unpack_channels

if TYPE_CHECKING:
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.record import Record

MAX_ENERGY_RATIO = 10.0  # times the possible energy
MIN_TESTED_ENERGY = 1e-3  # J/kg of all bodies, as at 0.04 m/s: less energy is not tested


def find_blow_up(scene: Scene, model: Model, record: Record, first: int, count: int) -> int | None:
    """First record, from ``first`` to ``count``, at which the energy is `MAX_ENERGY_RATIO`
    times its supply."""
    if count <= first:
        return None
    start = unpack_channels(model, record, 1)
    # only these records, because a run is tested many times
    values = unpack_channels(model, record, count, first)
    with np.errstate(over="ignore", invalid="ignore"):
        held = values["kinetic"] + values["stored"].sum(axis=1)
    works = slice(model.energy, model.energy + model.rows)
    since = values["y"][works] - start["y"][works]
    given = np.zeros(count - first)
    lost_before = losses(model, start)
    lost_besides = losses(model, values)
    for row in range(model.rows):
        if is_work_row(scene, row):
            given += np.maximum(since[:, row], 0.0)
        elif _can_add_energy(scene, row):
            lost = since[:, row]
            if row in lost_besides:
                lost = lost + lost_besides[row] - lost_before[row]
            given += np.maximum(-lost, 0.0)
    least = MIN_TESTED_ENERGY * sum(body.mass for body in scene.bodies)
    had = abs(start["kinetic"][0] + start["stored"][0].sum())
    beyond = np.flatnonzero(held > MAX_ENERGY_RATIO * (had + given) + least)
    return first + int(beyond[0]) if beyond.size else None


def largest_energy_holder(scene: Scene, model: Model, record: Record, count: int) -> str:
    """Name of the part with most energy at the last record: an element that stores it, or a degree
    of freedom of a single body, such as "heave of body barge"."""
    values = unpack_channels(model, record, count)
    stored = values["stored"][-1]
    if not stored.max() < values["kinetic"][-1]:
        return force_names(scene)[int(np.argmax(stored))]
    v = values["velocity"][-1].reshape(-1, 6)
    inertia = [[body.mass] * 3 + list(np.diag(body.inertia)) for body in scene.bodies]
    body, dof = divmod(int(np.argmax(np.sqrt(inertia) * np.abs(v))), 6)
    return f"{DOFS[dof]} of body {scene.bodies[body].name}"


def _can_add_energy(scene: Scene, row: int) -> bool:
    """Whether a row of dissipation may be negative; radiation memory returns energy that it had at
    the start."""
    element = element_of(scene, row)
    if element is None:
        return row == RADIATION and scene.initial is not None
    return (
        element.can_add_energy() or element.active is not None
    )  # energy that it holds at the start
