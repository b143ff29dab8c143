"""The values of a run that are recorded at every output time."""

from __future__ import annotations

from itertools import accumulate
from math import prod

import numpy as np

from hydrosim.forces import events, new_modes
from hydrosim.jit.kernels import assign, root
from hydrosim.rigid.kinematics import accelerations
from hydrosim.stepping.dynamics import Model, momentum, rhs, stored_energies
from hydrosim.stepping.state import EVENTS, RECORDS, START_SLOPE, Clock, Places, Record
from hydrosim.waves.loads import any_waves, wave_loads


def channels(model: Model) -> dict[str, tuple[int, ...]]:
    """Names and shapes of the channels of a record, in their order."""
    m = 6 * model.bodies.each.size
    return {
        "time": (),
        "elevation": (),
        "kinetic": (),
        "events": (),
        "y": (model.size,),
        "coordinates": (m,),
        "velocity": (m,),
        "momentum": (m if model.impulse < model.size else 0,),
        "stored": (model.rows,),
        "wrench": (model.rows, m),
        **events.observed(model.elements),
    }


def new_record(model: Model, clock: Clock, accelerations: bool = False) -> Record:
    """Room for all output times, the first included, with or without ``accelerations``."""
    # the end is always recorded, even between output times
    nt = -(-clock.points // clock.every) + 1
    shapes = channels(model).values()
    *places, width = accumulate(map(prod, shapes), initial=0)
    at = Places(*places[: len(Places._fields)])
    modes = new_modes(model)
    rates = np.zeros((nt if accelerations else 0, 6 * model.bodies.each.size))
    return Record(at, np.zeros((nt, width)), np.zeros((nt, *modes.shape), modes.dtype), rates)


def unpack(model: Model, record: Record, count: int, first: int = 0) -> dict[str, np.ndarray]:
    """Channels by name, (count - first, ...) each, of the records ``first`` <= i < ``count``."""
    kept = record.channels[first:count]
    values = {}
    at = 0
    for name, shape in channels(model).items():
        width = prod(shape)
        values[name] = kept[:, at : at + width].reshape(len(kept), *shape)
        at += width
    return values


@root
def keep(t, run):
    """Record the state and all derived values; the slope computed for them begins the next step."""
    model = run.model
    work = run.work
    scratch = run.scratch
    counters = run.counters
    y = run.state.y
    modes = run.state.modes
    motion = work.motion
    at = run.record.at
    row = run.record.channels[counters[RECORDS]]
    kept = run.record.modes[counters[RECORDS]]
    stored = row[at.stored : at.wrench]
    row[at.kinetic] = stored_energies(t, y, modes, model, work, stored)
    if model.impulse < model.size:
        momentum(work, row[at.momentum :])
    rhs(t, y, modes, run.state.history, model, work, scratch.k[0])
    scratch.known[START_SLOPE] = 1
    if run.record.accelerations.size > 0:
        n = model.bodies.active.size
        changes = run.record.accelerations[counters[RECORDS]]
        accelerations(scratch.k[0][n : 2 * n], model.bodies, motion, changes)
    row[at.time] = t
    row[at.events] = counters[EVENTS]
    assign(row[at.y :], y)
    assign(row[at.coordinates :], motion.coordinates)
    assign(row[at.velocity :], motion.velocity)
    for r in range(model.rows):
        assign(row[at.wrench + r * motion.velocity.size :], work.wrench[r])
    elements = model.elements
    reactions = work.holds.reaction
    observed = row[at.observed :]
    events.observe(t, y, modes, motion, model.bodies, elements, reactions, work.wrench, observed)
    for i in range(modes.shape[0]):
        assign(kept[i], modes[i])
    row[at.elevation] = 0.0
    if any_waves(model.waves):
        row[at.elevation] = wave_loads(t, model.waves, work.blend.first, work.blend.second)
    counters[RECORDS] += 1
