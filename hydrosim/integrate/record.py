"""The values of a run that are recorded at every output time, and loads in joints of trees.

Loads in the joints of trees, from Newton's law for what each of them carries.

    r = (M + A) v' - F        of every body; F: all forces but the reactions of joints of trees
    load of a joint = sum of r of its child and of all that the child carries

F has the rows of `dynamics.rhs` with the gyroscopic terms and those of the turning added mass.
"""

from __future__ import annotations

from itertools import accumulate
from math import prod
from typing import Any

import numpy as np

from hydrosim.elements import events, new_modes
from hydrosim.elements.kind import RecordedStates
from hydrosim.integrate import state
from hydrosim.integrate.dynamics import (
    Model,
    find_mass,
    momentum,
    rhs,
    stored_energies,
    subtract_gyroscopic,
    total_force,
)
from hydrosim.integrate.step import keep_reactions
from hydrosim.jit.kernels import assign, kernel, root
from hydrosim.multibody.heading import add_turning
from hydrosim.multibody.kinematics import accelerations
from hydrosim.multibody.tree import record_angles, sum_joint_loads
from hydrosim.water.loads import any_waves, wave_loads
from hydrosim.water.wind import gust_at, has_gusts


@root
def find_joint_loads(x, model, work, out):
    """Write force and moment (6,) about each joint k of trees to ``out`` from 6 k on: on the
    joint's body, in the earth frame. ``x`` (n,) are the accelerations that `rhs` has just found in
    ``work``."""
    _find_missing(x, model, work, work.total)
    sum_joint_loads(work.total, model.bodies, work.motion, out)


@kernel
def _find_missing(x, model, work, missing):
    """(M + A) v' - F (6 nb,), the wrenches that the joints of trees must give."""
    bodies = model.bodies
    motion = work.motion
    A = work.blend.added_mass if model.family.body.size > 0 else model.added_mass
    total_force(work.wrench, missing)
    subtract_gyroscopic(bodies, work.contents, motion, missing)
    if model.headings.turning.size > 0:
        add_turning(model.headings, A, bodies, motion, work.hulls, missing)
    find_mass(model, A, work)
    a = work.push
    accelerations(x, bodies, motion, a)
    for i in range(missing.size):
        missing[i] = -missing[i]
        for j in range(a.size):
            missing[i] += work.mass[i, j] * a[j]


MEMORY_SPACING = 16  # records from one with radiation states to the next


def channels(model: Model) -> dict[str, tuple[int, ...]]:
    """Names and shapes of the channels of a record, in their order."""
    m = 6 * model.bodies.each.size
    return {
        "time": (),
        "elevation": (),
        "wind": (events.wind_channels(model.elements),),
        "kinetic": (),
        "events": (),
        "y": (model.size - model.states.decay.size,),
        "coordinates": (m,),
        "velocity": (m,),
        "momentum": (m if model.impulse < model.size else 0,),
        "stored": (model.rows,),
        "wrench": (model.rows, m),
        **events.output_shapes(model.elements),
    }


def new_record(
    model: Model, clock: state.Clock, accelerations: bool = False, spacing: int = MEMORY_SPACING
) -> state.Record:
    """Room for all output times, the first included, with or without ``accelerations``. Every
    ``spacing``-th has radiation states."""
    # the end is always recorded, even between output times
    nt = -(-clock.points // clock.every) + 1
    shapes = channels(model).values()
    *places, width = accumulate(map(prod, shapes), initial=0)
    at = state.RecordColumns(*places[: len(state.RecordColumns._fields)])
    modes = new_modes(model)
    rates = np.zeros((nt if accelerations else 0, 6 * model.bodies.each.size))
    remembered = np.full(-(-nt // spacing) + 1, -1)
    return state.Record(
        at,
        np.zeros((nt, width)),
        np.zeros((nt, *modes.shape), np.int32),
        rates,
        spacing,
        remembered,
        np.zeros((remembered.size, model.states.decay.size)),
    )


def unpack_channels(
    model: Model, record: state.Record, count: int, first: int = 0
) -> dict[str, Any]:
    """Channels by name, (count - first, ...) each, of the records ``first`` <= i < ``count``. The
    states "y" are `RecordedStates`."""
    recorded = record.channels[first:count]
    values: dict[str, Any] = {}
    at = 0
    for name, shape in channels(model).items():
        width = prod(shape)
        values[name] = recorded[:, at : at + width].reshape(len(recorded), *shape)
        at += width
    values["y"] = RecordedStates(values["y"], _radiation_range(model))
    return values


def with_states(record: state.Record, count: int) -> np.ndarray:
    """Numbers, rising, of the first ``count`` records that have all states."""
    remembered = record.remembered
    return np.unique(remembered[(remembered >= 0) & (remembered < count)])


def states_at(model: Model, record: state.Record, which: np.ndarray) -> np.ndarray:
    """The states y (n, ny) of the n records ``which``, each of which has all states."""
    rows = np.array([np.flatnonzero(record.remembered == i)[0] for i in which], dtype=np.int64)
    others = record.channels[which][:, record.at.y : record.at.coordinates]
    place = _radiation_range(model)
    parts = [others[:, : place.start], record.memory[rows], others[:, place.start :]]
    return np.concatenate(parts, axis=1)


def _radiation_range(model: Model) -> slice:
    """Places of the radiation states in y."""
    return slice(model.radiation, model.radiation + model.states.decay.size)


@root
def write_record(t, run):
    """Record the state and all derived values; the slope computed for them begins the next step."""
    model = run.model
    work = run.work
    scratch = run.scratch
    counters = run.counters
    y = run.state.y
    modes = run.state.modes
    motion = work.motion
    at = run.record.at
    row = run.record.channels[counters[state.RECORDS]]
    record_modes = run.record.modes[counters[state.RECORDS]]
    stored = row[at.stored : at.wrench]
    row[at.kinetic] = stored_energies(t, y, modes, model, work, stored)
    if model.impulse < model.size:
        momentum(work, row[at.momentum :])
    rhs(t, y, modes, run.state.history, model, work, scratch.k[0])
    scratch.step_cache[state.START_SLOPE] = 1
    keep_reactions(state.AT_START, run)
    if run.record.accelerations.size > 0:
        n = model.bodies.active.size
        changes = run.record.accelerations[counters[state.RECORDS]]
        accelerations(scratch.k[0][n : 2 * n], model.bodies, motion, changes)
    row[at.time] = t
    row[at.events] = counters[state.EVENTS]
    _write_states(y, run, row[at.y :])
    assign(row[at.coordinates :], motion.coordinates)
    if model.bodies.tree.branches.size > 0:
        record_angles(model.bodies, motion, row[at.coordinates :])
    assign(row[at.velocity :], motion.velocity)
    for r in range(model.rows):
        assign(row[at.wrench + r * motion.velocity.size :], work.wrench[r])
    elements = model.elements
    observed = row[at.observed :]
    events.write_outputs(
        t, y, modes, motion, model.bodies, elements, work.holds, work.wrench, observed
    )
    if model.bodies.tree.branches.size > 0:
        n = model.bodies.active.size
        loads = observed[events.joint_output_start(elements) :]
        find_joint_loads(scratch.k[0][n : 2 * n], model, work, loads)
    for i in range(modes.shape[0]):
        assign(record_modes[i], modes[i])
    row[at.elevation] = 0.0
    if any_waves(model.waves):
        row[at.elevation] = wave_loads(t, model.waves, work.blend.first, work.blend.second)
    gusts = events.gusts_of(elements)
    if has_gusts(gusts):
        row[at.wind] = gusts.mean + gust_at(t, 0, gusts)
    counters[state.RECORDS] += 1


@kernel
def _write_states(y, run, row):
    """Write all states but those of radiation to ``row``. The latter are kept for the newest record
    and for every `Record.spacing`-th."""
    model = run.model
    record = run.record
    number = run.counters[state.RECORDS]
    first = model.radiation
    last = first + model.states.decay.size
    assign(row, y[:first])
    assign(row[first:], y[last:])
    newest = record.remembered.size - 1
    record.remembered[newest] = number
    assign(record.memory[newest], y[first:last])
    if number % record.spacing == 0:
        k = number // record.spacing
        record.remembered[k] = number
        assign(record.memory[k], y[first:last])
