"""Longest steps at which the limits of what holds still are compared with its loads.

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

from math import inf, pi
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.forces import externals_of, signals_of
from hydrosim.forces.signal import signal_rate
from hydrosim.streams.gusts import gust_components
from hydrosim.streams.wind import mean_wind

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Environment, Scene

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
