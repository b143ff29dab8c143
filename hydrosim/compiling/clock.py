"""Step grid of a run, times that no step may cross, and tolerances."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.load_rates import held_step, signal_step
from hydrosim.forces import signals_of
from hydrosim.forces.contact import fender
from hydrosim.forces.line import delay, winch
from hydrosim.forces.signal import corners
from hydrosim.integrate import Control
from hydrosim.modes import NO_INDEX
from hydrosim.rigid.free import are_lengths
from hydrosim.stepping.clock import Clock
from hydrosim.waves.displaced_loads import STATES_PER_FOLLOWED_BODY
from hydrosim.waves.wave_reference import grid_step, steps_per_block

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model


def compile_clock(compiled: Compiled) -> Clock:
    """Step grid, output times on it, times that no step may cross, and tolerances."""
    scene = compiled.scene
    begin = compiled.begin
    solver = scene.solver
    step = grid_step(scene)
    # a run that starts on the grid of a run from 0 keeps that grid, so that its steps are the same
    passed = round(begin / step)
    on_grid = abs(passed * step - begin) <= 1e-9 * step * max(passed, 1)
    ramps = [w.ramp for w in scene.environment.waves]
    if (gusts := scene.environment.gusts) is not None:
        ramps.append(gusts.ramp)
    tables = [corners(signal) for _, signal in signals_of(scene.forces)]
    breakpoints = np.unique(np.concatenate([ramps, *tables]))
    return Clock(
        start=0.0 if on_grid else begin,
        first=passed if on_grid else 0,
        step=step,
        end=begin + scene.duration,
        points=ceil(scene.duration / step - 1e-9),
        every=round(scene.output_step / step),
        block=steps_per_block(scene) if compiled.model.following.slow.any() else 0,
        breakpoints=breakpoints[(breakpoints > begin) & (breakpoints < begin + scene.duration)],
        events=solver.events,
        signal_step=signal_step(scene),
        held_step=held_step(compiled),
        control=Control(
            solver.method.adapts, solver.tolerance.relative, _tolerances(scene, compiled.model)
        ),
        solver_step=solver.step,
    )


def _tolerances(scene: Scene, model: Model) -> np.ndarray:
    """Absolute tolerance of every state (ny,). Radiation states get the tolerance of velocities
    times their steady response to a velocity. Springs of contact nodes get the tolerance of the
    friction force that they make. Slip distances, headings held in a step and energies do not
    count."""
    tolerance = scene.solver.tolerance
    n = model.bodies.active.size
    states = model.states
    absolute = np.full(model.size, np.inf)
    place = np.where(are_lengths(model.bodies), tolerance.position, tolerance.angle)
    absolute[:n] = absolute[n : 2 * n] = place
    by_dof = np.tile(np.repeat([tolerance.position, tolerance.angle], 3), len(scene.bodies))
    by_dof = np.concatenate([by_dof, np.tile(by_dof[:6], model.family.owner.size)])
    for g, first in enumerate(states.state[:-1]):
        members = states.dof[states.member[g] : states.member[g + 1]]
        size = states.state[g + 1] - first
        B = states.B[states.matrix[g] :][: members.size * size].reshape(members.size, size)
        reach = by_dof[members] @ np.abs(B) / -states.decay[first : first + size]
        absolute[model.radiation + first :][:size] = reach
    slow = (model.draught - model.slow) // STATES_PER_FOLLOWED_BODY
    filters = np.repeat([tolerance.position, tolerance.position, tolerance.angle], 3)
    known = np.full(STATES_PER_FOLLOWED_BODY - filters.size, np.inf)
    absolute[model.slow : model.draught] = np.tile([*filters, *known], slow)
    absolute[model.draught : model.energy] = tolerance.position
    fenders = model.elements.fenders
    for i, reach in enumerate(fenders.points["reach"]):
        stretch = min(tolerance.position, tolerance.relative * reach) if reach else np.inf
        absolute[fenders.state + fender.CONTACT_STATES * i :][: fender.FELT_STATES] = stretch
    _tolerate_drums(absolute, model, tolerance.position)
    return absolute


def _tolerate_drums(absolute: np.ndarray, model: Model, length: float) -> None:
    """Lengths off drums, and speeds of drums, get the tolerance of a ``length``. States of a delay
    get what makes such an error in the delayed length."""
    winches = model.elements.winches
    delays = winches.state + winch.WINCH_STATES * winches.each.size
    for i, one in enumerate(winches.each):
        own = absolute[winches.state + winch.WINCH_STATES * i :]
        if one["drum"]["control"] != winch.LENGTH_CONTROL:
            own[[winch.WIRE_LENGTH, winch.DRUM_SPEED]] = length
        if one["delay"] != NO_INDEX:
            a, b = one["factors"].T
            late = absolute[delays + one["delay"] :][: delay.DELAY_STATES]
            late[0::2] = length / b
            late[1::2] = length / (2.0 * a)
