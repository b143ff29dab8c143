"""Kernels of `exact`: loads at rest on a grid of times, and records of states that are known."""

from __future__ import annotations

from hydrosim.forces import APPLIED, applied_force
from hydrosim.forces.layout import WAVE_FIRST_ORDER, WAVE_SECOND_ORDER
from hydrosim.kernels import assign, clear, kernel
from hydrosim.run import check, keep
from hydrosim.stepper import RUNNING, STATUS
from hydrosim.waves.loads import wave_loads


@kernel
def sample_loads(start, step, rows, model, state, work, loads):
    """What waves and applied forces do on the free coordinates at start + k step, into ``loads``
    (nk, nr, n), for the ``rows`` (nr,) of forces and bodies at rest as ``work`` has them when new.
    """
    bodies, elements, wrench = model.bodies, model.elements, work.wrench
    for k in range(loads.shape[0]):
        t = start + k * step
        clear(wrench.reshape(wrench.size))
        wave_loads(t, model.waves, wrench[WAVE_FIRST_ORDER], wrench[WAVE_SECOND_ORDER])
        applied_force.add_force(
            *(t, state.y, state.modes, work.motion, bodies),
            *(elements[APPLIED], wrench, work.rate, work.total),
        )
        for r in range(rows.size):
            for j in range(bodies.active.size):
                loads[k, r, j] = wrench[rows[r], bodies.active[j]]


@kernel
def keep_states(times, states, model, state, work, scratch, record, counters):
    """Record the ``states`` (nk, ny) at ``times`` (nk,), as steps to there would have been; stops
    where ``counters[STATUS]`` says why."""
    for k in range(times.size):
        assign(state.y, states[k])
        check(state.y, model.bodies, counters)
        if counters[STATUS] != RUNNING:
            return
        keep(times[k], model, state, work, scratch, record, counters)
