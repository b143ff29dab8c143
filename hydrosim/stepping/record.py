"""What is recorded of a run at every output time."""

from __future__ import annotations

from math import prod

import numpy as np

from hydrosim.forces import events, new_modes
from hydrosim.jit.kernels import assign, root
from hydrosim.rigid.kinematics import accelerations
from hydrosim.stepping.dynamics import Model, momentum, rhs, stored_energies
from hydrosim.stepping.state import RECORDS, START_SLOPE, Clock, Record
from hydrosim.waves.loads import wave_loads


def channels(model: Model) -> dict[str, tuple[int, ...]]:
    """Names and shapes of the channels of a record, in their order."""
    m = 6 * model.bodies.each.size
    return {
        "time": (),
        "elevation": (),
        "kinetic": (),
        "y": (model.size,),
        "coordinates": (m,),
        "velocity": (m,),
        **({"momentum": (m,)} if model.impulse < model.size else {}),
        "stored": (model.rows,),
        "wrench": (model.rows, m),
        **events.observed(model.elements),
    }


def new_record(model: Model, clock: Clock, accelerations: bool = False) -> Record:
    """Room for all output times, the first included, with or without ``accelerations``."""
    nt = -(-clock.points // clock.every) + 1  # the end is recorded, on an output time or not
    width = sum(prod(shape) for shape in channels(model).values())
    modes = new_modes(model)
    rates = np.zeros((nt if accelerations else 0, 6 * model.bodies.each.size))
    return Record(np.zeros((nt, width)), np.zeros((nt, *modes.shape), modes.dtype), rates)


@root
def keep(t, run):
    """Record the state and everything that follows from it, in the order of `channels`; the slope
    that is found for that begins the next step."""
    model, work, scratch, counters = run.model, run.work, run.scratch, run.counters
    y, modes, motion = run.state.y, run.state.modes, work.motion
    row, kept = run.record.channels[counters[RECORDS]], run.record.modes[counters[RECORDS]]
    m, at = 6 * model.bodies.each.size, 3 + y.size
    moving = row[at + 2 * m :]
    stored = moving[m if model.impulse < model.size else 0 :]
    wrench = stored[model.rows :]
    row[2] = stored_energies(t, y, modes, model, work, stored[: model.rows])
    if model.impulse < model.size:
        momentum(work, moving)
    rhs(t, y, modes, run.state.history, model, work, scratch.k[0])
    scratch.known[START_SLOPE] = 1
    if run.record.accelerations.size > 0:
        n, changes = model.bodies.active.size, run.record.accelerations[counters[RECORDS]]
        accelerations(scratch.k[0][n : 2 * n], model.bodies, motion, changes)
    row[0] = t
    assign(row[3:], y)
    assign(row[at:], motion.coordinates)
    assign(row[at + m :], motion.velocity)
    for r in range(model.rows):
        assign(wrench[m * r :], work.wrench[r])
    observed, reactions = wrench[m * model.rows :], work.holds.reaction
    events.observe(t, y, modes, motion, model.bodies, model.elements, reactions, observed)
    for i in range(modes.shape[0]):
        assign(kept[i], modes[i])
    row[1] = wave_loads(t, model.waves, work.blend.first, work.blend.second)
    counters[RECORDS] += 1
