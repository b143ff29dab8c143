"""Kernels of exact propagation: loads on bodies at rest, energies, records of known states."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.elements import add_given_forces
from hydrosim.elements.kind import RADIATION, WAVE_FIRST_ORDER, WAVE_SECOND_ORDER
from hydrosim.integrate.dynamics import power_of
from hydrosim.integrate.loop import check
from hydrosim.integrate.record import write_record
from hydrosim.integrate.state import IN_PROGRESS, STATUS
from hydrosim.jit.kernels import assign, clear, kernel
from hydrosim.multibody.kinematics import generalised_force
from hydrosim.water.loads import wave_loads


class Resistances(NamedTuple):
    """Terms of the powers v (B v - b) that rows of forces take at the free coordinates' rates v:
    v[``one``] ``B`` v[``other``] for each ``row`` (nb,), less v[``steady``] ``b`` for each
    ``steady_row`` (ns,)."""

    row: np.ndarray
    one: np.ndarray
    other: np.ndarray
    B: np.ndarray
    steady_row: np.ndarray
    steady: np.ndarray
    b: np.ndarray


@kernel
def sample_loads(start, step, rows, model, state, work, loads):
    """Loads of waves and applied forces on the free coordinates at start + k step, into ``loads``
    (nk, nr, n), for the ``rows`` (nr,) of forces. Bodies are at rest, as in a new ``work``."""
    bodies = model.bodies
    elements = model.elements
    wrench = work.wrench
    for k in range(loads.shape[0]):
        t = start + k * step
        for r in range(rows.size):
            clear(wrench[rows[r]])
        wave_loads(t, model.waves, wrench[WAVE_FIRST_ORDER], wrench[WAVE_SECOND_ORDER])
        add_given_forces(t, state.y, state.modes, work.motion, bodies, elements, wrench, work)
        for r in range(rows.size):
            generalised_force(bodies, work.motion, wrench[rows[r]], loads[k, r])


@kernel
def add_energies(v, memory, loads, weights, resistances, rows, energies):
    """Add to ``energies`` (nk, ne) the integrals of all powers over nk intervals, from the values
    at their nodes and ``weights`` (ni,).

    ``v`` and ``memory`` (nk, ni, n) are rates and radiation forces. ``loads`` (nodes, nr, n) belong
    to the ``rows``, of which the first two are waves. ``resistances`` take power besides.
    """
    dof_indices = resistances.one
    other = resistances.other
    row = resistances.row
    steady = resistances.steady
    steady_row = resistances.steady_row
    for k in range(energies.shape[0]):
        for i in range(weights.size):
            u = v[k, i]
            w = weights[i]
            waves = 0.0
            for r in range(rows.size):
                rate = power_of(loads[k * (weights.size - 1) + i, r], u)
                energies[k, rows[r]] += w * rate
                waves += rate if r < 2 else 0.0
            energies[k, -1] += w * abs(waves)
            energies[k, RADIATION] += w * power_of(memory[k, i], u)
            for e in range(row.size):
                energies[k, row[e]] += w * u[dof_indices[e]] * resistances.B[e] * u[other[e]]
            for e in range(steady_row.size):
                energies[k, steady_row[e]] -= w * resistances.b[e] * u[steady[e]]


@kernel
def keep_states(times, states, run):
    """Record the ``states`` (nk, ny) at ``times`` (nk,) as steps would have recorded them; stops
    early if ``counters[STATUS]`` is set."""
    for k in range(times.size):
        assign(run.state.y, states[k])
        check(run.state.y, run.model, run.counters)
        if run.counters[STATUS] != IN_PROGRESS:
            return
        write_record(times[k], run)
