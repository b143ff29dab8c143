"""Whether the motions of a run hold more energy than anything can have given them.

What bodies hold at a time, kinetic and stored, is at most what they held at the start and what was
put in since: the work of waves, applied forces and streams, and what a prescribed normal force or a
damper in a current gave. A solution that is far beyond that is one of the numbers alone. Friction
and dampers that give energy, and steps that make it, are found here, long before numbers overflow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.forces import losses
from hydrosim.forces.layout import RADIATION
from hydrosim.stepping.names import element_of, force_names, supplies
from hydrosim.stepping.record import unpack

if TYPE_CHECKING:
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.record import Record

FAR = 10.0  # times what can be there
LEAST = 1e-3  # J/kg of all bodies, as at 0.04 m/s: less has no source worth a look


def blown_up(scene: Scene, model: Model, record: Record, first: int, count: int) -> int | None:
    """The first record, from ``first`` to ``count``, at which a run is `FAR` beyond its supply."""
    if count <= first:
        return None
    start = unpack(model, record, 1)
    values = unpack(model, record, count, first)  # no more: a run is looked at many times
    with np.errstate(over="ignore", invalid="ignore"):
        held = values["kinetic"] + values["stored"].sum(axis=1)
    works = slice(model.energy, model.energy + model.rows)
    since = values["y"][:, works] - start["y"][:, works]
    given = np.zeros(count - first)
    lost_before = losses(model, start)
    lost_besides = losses(model, values)
    for row in range(model.rows):
        if supplies(scene, row):
            given += np.maximum(since[:, row], 0.0)
        elif _may_give(scene, row):
            lost = since[:, row]
            if row in lost_besides:
                lost = lost + lost_besides[row] - lost_before[row]
            given += np.maximum(-lost, 0.0)
    least = LEAST * sum(body.mass for body in scene.bodies)
    had = abs(start["kinetic"][0] + start["stored"][0].sum())
    beyond = np.flatnonzero(held > FAR * (had + given) + least)
    return first + int(beyond[0]) if beyond.size else None


def holder(scene: Scene, model: Model, record: Record, count: int) -> str:
    """What holds most energy at the last record: the element that has stored it, or the degree of
    freedom that moves, as of a body by itself: "heave of body barge"."""
    values = unpack(model, record, count)
    stored = values["stored"][-1]
    if not stored.max() < values["kinetic"][-1]:
        return force_names(scene)[int(np.argmax(stored))]
    v = values["velocity"][-1].reshape(-1, 6)
    inertia = [[body.mass] * 3 + list(np.diag(body.inertia)) for body in scene.bodies]
    body, dof = divmod(int(np.argmax(np.sqrt(inertia) * np.abs(v))), 6)
    return f"{DOFS[dof]} of body {scene.bodies[body].name}"


def _may_give(scene: Scene, row: int) -> bool:
    """Whether a row of dissipation may be negative; memory gives back what it had at the start."""
    element = element_of(scene, row)
    if element is None:
        return row == RADIATION and scene.initial is not None
    return element.may_give() or element.active is not None  # what it holds as it begins
