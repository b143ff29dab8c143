"""Made decays of roll: by an independent solver, with noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from hydrosim.decay.fit import fit_decays
from hydrosim.decay.record import decay_of
from hydrosim.errors import InputError


class Law(NamedTuple):
    """p1 [1/s], p2 [1/rad], p3 [s/rad^2], natural period [s], cubic restoring [1/rad^2]."""

    p1: float
    p2: float
    p3: float
    period: float
    cubic: float = 0.0


def roll_of(law: Law, time: np.ndarray, start: float, rate: float = 0.0) -> np.ndarray:
    """Roll (n,) [rad] from a ``start`` [rad] and ``rate`` [rad/s], by DOP853."""
    p1, p2, p3, period, cubic = law
    k = (2.0 * np.pi / period) ** 2

    def slope(t: float, y: np.ndarray) -> list[float]:
        x, v = y
        return [v, -(p1 + p2 * abs(v) + p3 * v * v) * v - k * (x + cubic * x**3)]

    ends = (time[0], time[-1])
    done = solve_ivp(slope, ends, [start, rate], "DOP853", time, rtol=1e-10, atol=1e-13)
    return np.asarray(done.y[0])


def noise(rng: np.random.Generator, count: int, step: float, memory: float = 0.0) -> np.ndarray:
    """Noise (n,) of standard deviation 1, white or of correlation exp(-t / memory)."""
    white = rng.normal(size=count + 2000)
    if not memory:
        return white[2000:]
    a = np.exp(-step / memory)
    return np.asarray(lfilter([np.sqrt(1.0 - a * a)], [1.0, -a], white)[2000:])


class Made(NamedTuple):
    """A made decay: its law, its times [s], its roll with noise [rad], and the largest roll."""

    law: Law
    time: np.ndarray
    angle: np.ndarray
    size: float


def draw(seed: int) -> Made:
    """A random decay: 5 to 20 periods of 4 to 25 s, from 4 to 20 deg, with 20 to 120 values in a
    period; damping ratios of 0.5 to 4 % (linear), 0 to 5 % (quadratic) and 0 to 2 % (cubic) at the
    largest roll; noise of 0.1 to 5 % of it, half of them white, half of them with a memory of 0.02
    to 0.3 periods."""
    rng = np.random.default_rng(seed)
    period = rng.uniform(4.0, 25.0)
    w = 2.0 * np.pi / period
    size = np.radians(rng.uniform(4.0, 20.0))
    linear, quadratic, cubic = rng.uniform([0.005, 0.0, 0.0], [0.04, 0.05, 0.02])
    p2 = 2.0 * w * quadratic / (8.0 / (3.0 * np.pi) * w * size)
    p3 = 2.0 * w * cubic / (0.75 * (w * size) ** 2)
    law = Law(2.0 * w * linear, p2, p3, period)
    step = period / rng.uniform(20.0, 120.0)
    time = np.arange(0.0, rng.uniform(5.0, 20.0) * period, step)
    phase = rng.uniform(0.0, 1.0)
    roll = roll_of(law, time, size * np.cos(phase), size * w * np.sin(phase))
    deviation = size * 10.0 ** rng.uniform(-3.0, -1.3)
    memory = period * rng.uniform(0.02, 0.3) if rng.integers(2) else 0.0
    mean = np.radians(rng.uniform(-2.0, 2.0))
    angle = roll + mean + deviation * noise(rng, time.size, step, memory)
    return Made(law, time, angle, size)


def which_hold(seed: int) -> list[bool] | None:
    """Whether the 90 % intervals of p1, p2, p3, the natural period, and the damping ratio at half
    of the largest roll hold the truth of a drawn decay; None if it is refused, because its damping
    is not told from zero."""
    made = draw(seed)
    try:
        found = fit_decays([decay_of(made.time, made.angle)])
    except InputError:
        return None
    p1, p2, p3, period, _ = made.law
    w = 2.0 * np.pi / period
    rate = 0.5 * w * made.size
    ratio = (p1 + 8.0 / (3.0 * np.pi) * p2 * rate + 0.75 * p3 * rate**2) / (2.0 * w)
    intervals = [*map(found.terms.interval, range(3)), found.period]
    intervals.append(found.terms.damping_ratio(0.5 * made.size))
    truth = (p1, p2, p3, period, ratio)
    return [i.low <= x <= i.high for i, x in zip(intervals, truth, strict=True)]
