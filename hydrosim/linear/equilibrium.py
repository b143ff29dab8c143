"""Where a scene is at rest, without stepping it there.

Zero velocities, no first-order waves and no friction: with friction there is a continuum of places
at rest, and which of them a run ends in is decided by its history. The free coordinates q are those
where the generalised loads vanish,

    Q(q) = S^T F(q, q' = 0) = 0,

found by Newton's method with K = -dQ/dq by central differences. Contacts and slack lines are looked
at anew in every iteration; directions without stiffness stay where they are (least norm).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrosim.errors import InputError
from hydrosim.forces.events import settle
from hydrosim.rigid import generalised_force, place_bodies
from hydrosim.stepping.dynamics import Model, Work, add_forces, new_work, total_force
from hydrosim.stepping.state import State

ITERATIONS = 100
SMALL = 1e-5  # m, rad: of the central differences
FLAT = 1e-12  # of the largest singular value of K: there is no stiffness
ENOUGH = 1e-9  # of the weight: a residual that counts as rest


@dataclass(frozen=True)
class Rest:
    """A ``state`` at rest of the frictionless ``model`` at ``time`` [s], and the largest load
    there over the ``weight`` [N] (moments: over weight times 1 m)."""

    model: Model
    state: State
    time: float
    residual: float

    @property
    def position(self) -> np.ndarray:
        """Displacements of all bodies, (nb, 6)."""
        bodies = self.model.bodies
        found = bodies.locked.copy()
        found[bodies.active] = self.state.y[: bodies.active.size]
        return found.reshape(-1, 6)


def equilibrium(model: Model, state: State, time: float, weight: float) -> Rest:
    """The place at rest near ``state`` of a ``model`` without friction and first-order waves, under
    the forces of ``time`` [s]; ``weight`` [N] is that of all bodies.

    Raises InputError if there is none, with the loads that are left.
    """
    work, n = new_work(model), model.bodies.active.size
    q = state.y[:n].copy()
    load = _load(q, time, model, state, work)
    for _ in range(ITERATIONS):
        if np.abs(load).max() <= 1e-3 * ENOUGH * weight:
            break
        step = np.linalg.lstsq(_stiffness(q, time, model, state, work), load, rcond=FLAT)[0]
        q, load = _shortened(q, step, load, time, model, state, work)
    residual = float(np.abs(load).max() / weight)
    if not residual <= ENOUGH:
        raise InputError(
            f"equilibrium at {time:g} s: none found; at the best place the loads left are"
            f" {residual:.1e} of the weight. Look for a force that nothing balances, or start"
            " nearer to rest (initial.position)."
        )
    return Rest(model, state._replace(y=_at(q, state)), time, residual)


def _at(q: np.ndarray, state: State) -> np.ndarray:
    y = np.zeros_like(state.y)
    y[: q.size] = q
    return y


def _load(q: np.ndarray, time: float, model: Model, state: State, work: Work) -> np.ndarray:
    """Generalised loads (n,) at rest at ``q`` (n,); contacts are made as the place has it."""
    y, load = _at(q, state), np.zeros(q.size)
    place_bodies(q, np.zeros(q.size), model.bodies, work.motion)
    settle(time, y, state.modes, work.motion, model.bodies, model.elements)
    add_forces(time, y, state.modes, state.history, model, work, np.zeros_like(y))
    total_force(work.wrench, work.total)
    generalised_force(model.bodies, work.motion, work.total, load)
    return load


def _stiffness(q: np.ndarray, time: float, model: Model, state: State, work: Work) -> np.ndarray:
    """-dQ/dq, (n, n)."""
    columns = []
    for shift in SMALL * np.eye(q.size):
        ahead, behind = (_load(q + s, time, model, state, work) for s in (shift, -shift))
        columns.append((behind - ahead) / (2.0 * SMALL))
    return np.stack(columns, axis=1)


def _shortened(
    q: np.ndarray,
    step: np.ndarray,
    load: np.ndarray,
    time: float,
    model: Model,
    state: State,
    work: Work,
) -> tuple[np.ndarray, np.ndarray]:
    """The step, halved until the loads become less; the last one tried if they never do."""
    size = np.linalg.norm(load)
    for halvings in range(30):
        trial = q + step / 2.0**halvings
        found = _load(trial, time, model, state, work)
        if np.linalg.norm(found) < size:
            break
    return trial, found
