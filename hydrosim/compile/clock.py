"""Clock of a run: step grid, times that no step may cross, longest steps, tolerances.

Longest steps at which the limits of what holds still are compared with its loads.

A motion shows how fast its loads change, and the step follows. What holds still until its load
reaches a limit shows nothing: a point or joint in dry friction, a joint that may break. So while
anything holds, a step is at most

    h = MAX_PHASE_RAD / w

where w [rad/s] is the fastest rate of all loads over time: waves, gusts and signals. Its ends and
two points between them make a cubic of the load. Between these it is wrong by (w h)^4 / 1944 of the
amplitude of that rate, 3e-5. A peak that exceeds a limit by more is found, and located exactly.

For random waves or gusts of frequencies w_i and amplitudes a_i

    w^8 = sum a_i^2 w_i^8 / sum a_i^2

because the error of a cubic is that of the fourth derivative. Sum-frequency loads have twice that
rate. Signals that limits depend on directly, such as a prescribed normal force or the length of a
line, hold for all steps. The rate of a function of the user is unknown: it is compared once every
``solver.step``.
"""

from __future__ import annotations

from math import ceil, inf, pi
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.elements import externals_of, signals_of
from hydrosim.elements.contact import fender
from hydrosim.elements.line import drum, winch
from hydrosim.elements.signal import corners, signal_rate
from hydrosim.integrate.methods import Control
from hydrosim.integrate.state import Clock
from hydrosim.modes import NO_INDEX
from hydrosim.multibody.kinematics import are_lengths
from hydrosim.scene import Environment, Scene
from hydrosim.water.displaced_loads import STATES_PER_FOLLOWED_BODY, grid_step, steps_per_block
from hydrosim.water.wind import gust_components, mean_wind

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hydrosim.compile.compiled import Compiled
    from hydrosim.integrate.dynamics import Model

MAX_PHASE_RAD = 0.5
"""Phase of the fastest rate of loads in a step."""


def signal_step(scene: Scene) -> float:
    """Longest step [s] while nothing holds, for signals that limits depend on directly; infinite if
    there are none."""
    if not _can_shorten_steps(scene):
        return inf
    guarding = {name: e for name, e in scene.forces.items() if not e.supplies}
    return _longest_step(max((signal_rate(s) for _, s in signals_of(guarding)), default=0.0))


def held_step(compiled: Compiled) -> float:
    """Longest step [s] while anything holds; infinite if no load changes over time."""
    scene = compiled.scene
    if not _can_shorten_steps(scene):
        return inf
    rates = [signal_rate(signal) for _, signal in signals_of(scene.forces)]
    rates += _wave_rates(compiled)
    rates += _gust_rates(scene.environment)
    function_step = scene.solver.step if externals_of(scene.forces) else inf
    return min(_longest_step(max(rates, default=0.0)), function_step)


def _can_shorten_steps(scene: Scene) -> bool:
    """True if steps are cut at events, or may have any length. Equal steps without events are those
    that the scene asks for."""
    return scene.solver.events or scene.solver.method.adapts


def _longest_step(rate: float) -> float:
    return MAX_PHASE_RAD / rate if rate > 0.0 else inf


def _wave_rates(compiled: Compiled) -> Iterator[float]:
    """Rates of the seas and of their ramps."""
    sums = any(body.wave_forces.sum_frequency for body in compiled.scene.bodies)
    for waves in compiled.sea:
        rate = _common_rate(waves.omega, waves.amplitude)
        yield 2.0 * rate if sums else rate
        yield _ramp_rate(waves.ramp)


def _gust_rates(environment: Environment) -> Iterator[float]:
    """Rates of gusts and of their ramp."""
    gusts = environment.gusts
    wind = mean_wind(environment)
    if gusts is not None and wind.hour_mean != 0.0:
        waves = gust_components(gusts, wind)
        yield _common_rate(waves.omega, waves.amplitude[:, 0])
        yield _ramp_rate(gusts.ramp)


def _ramp_rate(duration: float) -> float:
    """Rate of half a cosine of this ``duration`` [s]."""
    return pi / duration if duration > 0.0 else 0.0


def _common_rate(omega: np.ndarray, amplitude: np.ndarray) -> float:
    """Rate of waves of frequencies ``omega`` (n,) [rad/s] with random phases."""
    energy = amplitude**2
    total = float(energy.sum())
    if total == 0.0:
        return 0.0
    highest = float(omega.max())  # scaled by it, no power is beyond the range of numbers
    share = float((energy * (omega / highest) ** 8).sum()) / total
    return highest * share**0.125


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
            solver.method.adapts,
            solver.tolerance.relative,
            _state_tolerances(scene, compiled.model),
        ),
        solver_step=solver.step,
    )


def _state_tolerances(scene: Scene, model: Model) -> np.ndarray:
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
    no_limit = np.full(STATES_PER_FOLLOWED_BODY - filters.size, np.inf)
    absolute[model.slow : model.draught] = np.tile([*filters, *no_limit], slow)
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
    for i, unit in enumerate(winches.each):
        winch_tolerances = absolute[winches.state + winch.WINCH_STATES * i :]
        if unit["drum"]["control"] != winch.LENGTH_CONTROL:
            winch_tolerances[[winch.WIRE_LENGTH, winch.DRUM_SPEED]] = length
        if unit["delay"] != NO_INDEX:
            a, b = unit["factors"].T
            late = absolute[delays + unit["delay"] :][: drum.DELAY_STATES]
            late[0::2] = length / b
            late[1::2] = length / (2.0 * a)
