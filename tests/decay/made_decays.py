"""Made decays of roll: by an independent solver, as records of a basin look, with their truth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from hydrosim.decay.fit import DecayFit, fit_decays
from hydrosim.decay.record import decay_of
from hydrosim.errors import InputError

DISTURBANCES = ("none", "white", "memory", "waves")
NO_DECAYS = ("noise", "steady", "creeping", "growing")
TOLERANCE = 1e-4
"""Relative error of a fit without noise, which has intervals of no width."""


class Law(NamedTuple):
    """p1 [1/s], p2 [1/rad], p3 [s/rad^2], natural period [s], cubic restoring [1/rad^2]."""

    p1: float
    p2: float
    p3: float
    period: float
    cubic: float = 0.0

    def damping_ratio(self, amplitude: float) -> float:
        """Equivalent linear damping, of critical, at an amplitude of roll [rad]."""
        rate = 2.0 * np.pi / self.period * amplitude
        rates = self.p1 + 8.0 / (3.0 * np.pi) * self.p2 * rate + 0.75 * self.p3 * rate**2
        return float(rates * self.period / (4.0 * np.pi))


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


def wave_noise(
    rng: np.random.Generator, count: int, step: float, period: float, width: float
) -> np.ndarray:
    """Noise (n,) of standard deviation 1 with the spectrum of waves: Gaussian in the logarithm of
    frequency about 1 / ``period``, with the relative ``width``."""
    size = 4 * count
    frequency = np.fft.rfftfreq(size, step)[1:]
    power = np.exp(-0.5 * (np.log(frequency * period) / width) ** 2)
    spectrum = np.sqrt(power) * (rng.normal(size=power.size) + 1j * rng.normal(size=power.size))
    wave = np.fft.irfft(np.concatenate([[0.0], spectrum]), size)
    return np.asarray(wave[:count] / np.std(wave))


class Made(NamedTuple):
    """A made decay: its law, its times [s], its roll with noise [rad], the largest roll [rad], its
    number of periods, and the name of its disturbance. The law of what is no decay is None."""

    law: Law | None
    time: np.ndarray
    angle: np.ndarray
    size: float
    periods: float
    disturbance: str


def draw(seed: int) -> Made:
    """A random decay of 3 to 6 (half of them) or 6 to 35 periods, from 3 to 20 deg, at 5 to 50 Hz.

    Damping ratios at the largest roll are 0.5 to 4 % (linear), up to 5 % (quadratic) and 2 %
    (cubic); the restoring is linear (half of them), or its period changes by up to 5 %. The mean
    is up to 2 deg, and drifts (half of them) by up to a tenth of the largest roll, in a line or by
    a sine longer than the record. The noise is none, white (0.1 to 5 % of the largest roll), with
    a memory of 0.02 to 0.3 periods, or of waves: 0.2 to 2 % with periods of a third to twice the
    roll's.
    """
    rng = np.random.default_rng(seed)
    rate = 10.0 ** rng.uniform(np.log10(5.0), np.log10(50.0))
    period = max(10.0 ** rng.uniform(0.1, 1.2), 12.0 / rate)
    size = np.radians(rng.uniform(3.0, 20.0))
    law = _draw_law(rng, period, size)
    periods = rng.uniform(3.0, 6.0) if rng.integers(2) else rng.uniform(6.0, 35.0)
    time = np.arange(0.0, periods * period, 1.0 / rate)
    phase = rng.uniform(-0.1, 0.6)
    w = 2.0 * np.pi / period
    roll = rng.choice([-1.0, 1.0]) * roll_of(
        law, time, size * np.cos(phase), -size * w * np.sin(phase)
    )
    disturbance = str(rng.choice(DISTURBANCES))
    added = _draw_noise(rng, disturbance, time, period)
    return Made(
        law, time, roll + size * added + _draw_mean(rng, time, size), size, periods, disturbance
    )


def _draw_law(rng: np.random.Generator, period: float, size: float) -> Law:
    w = 2.0 * np.pi / period
    linear, quadratic, cubic = rng.uniform([0.005, 0.0, 0.0], [0.04, 0.05, 0.02])
    linear, quadratic, cubic = (
        (linear, 0.0, 0.0),
        (linear, quadratic, 0.0),
        (linear, 0.0, cubic),
        (linear, quadratic, cubic),
    )[rng.integers(4)]
    p2 = 2.0 * w * quadratic / (8.0 / (3.0 * np.pi) * w * size)
    p3 = 2.0 * w * cubic / (0.75 * (w * size) ** 2)
    shift = rng.uniform(-0.05, 0.05) if rng.integers(2) else 0.0
    return Law(2.0 * w * linear, p2, p3, period, -2.0 * shift / (0.75 * size**2))


def _draw_mean(rng: np.random.Generator, time: np.ndarray, size: float) -> np.ndarray:
    mean = np.full(time.size, np.radians(rng.uniform(-2.0, 2.0)))
    if rng.integers(2):
        along = (time - time[0]) / (time[-1] - time[0])
        drift = rng.uniform(-0.1, 0.1) * size
        bent = np.sin(2.0 * np.pi * (rng.uniform(0.3, 0.8) * along + rng.uniform()))
        mean += drift * (along if rng.integers(2) else bent)
    return mean


def _draw_noise(
    rng: np.random.Generator, disturbance: str, time: np.ndarray, period: float
) -> np.ndarray:
    """Noise (n,) as a share of the largest roll."""
    step = time[1] - time[0]
    if disturbance == "none":
        return np.zeros(time.size)
    if disturbance == "waves":
        length = period * 10.0 ** rng.uniform(np.log10(1.0 / 3.0), np.log10(2.0))
        waves = wave_noise(rng, time.size, step, length, rng.uniform(0.05, 0.2))
        deviation = 10.0 ** rng.uniform(np.log10(0.002), np.log10(0.02))
        return deviation * waves + 0.001 * rng.normal(size=time.size)
    memory = period * rng.uniform(0.02, 0.3) if disturbance == "memory" else 0.0
    return 10.0 ** rng.uniform(-3.0, -1.3) * noise(rng, time.size, step, memory)


def draw_no_decay(seed: int) -> Made:
    """A record that holds no decay: noise of waves alone, a steady roll, a roll that creeps back
    without a swing, a growing roll."""
    rng = np.random.default_rng(seed)
    kind = NO_DECAYS[seed % len(NO_DECAYS)]
    period = rng.uniform(4.0, 15.0)
    time = np.arange(0.0, rng.uniform(5.0, 20.0) * period, 0.1)
    size = np.radians(rng.uniform(3.0, 15.0))
    phase = 2.0 * np.pi * time / period
    if kind == "noise":
        angle = size * wave_noise(rng, time.size, 0.1, period, 0.2)
    elif kind == "steady":
        angle = size * np.cos(phase)
    elif kind == "creeping":
        angle = size * np.exp(-time / period)
    else:
        angle = 0.2 * size * np.exp(0.02 * phase) * np.cos(phase)
    white = 0.005 * size * rng.normal(size=time.size)
    return Made(None, time, angle + white, size, time[-1] / period, kind)


class Outcome(NamedTuple):
    """What became of a made decay: the message of its refusal, if any; of a fit, whether the 90 %
    intervals of p1, p2, p3, the natural period and the damping ratio in the middle of the recorded
    amplitudes hold the truth; the relative errors of the ratio for use in the middle, at half of
    the largest roll, and at the largest; the half width of the interval of the ratio, relative."""

    refusal: str
    holds: list[bool]
    errors: list[float]
    width: float


def try_fit(made: Made) -> Outcome:
    """Fit a made decay and compare it with its truth."""
    try:
        return compare(made, fit_decays([decay_of(made.time, made.angle)]))
    except InputError as error:
        return Outcome(str(error), [], [], 0.0)


def compare(made: Made, fit: DecayFit) -> Outcome:
    """A fit beside the truth. One without noise may be off by `TOLERANCE`."""
    law = made.law or Law(0.0, 0.0, 0.0, 1.0)
    middle = 0.5 * sum(fit.amplitudes)
    truth = [*law[:4], law.damping_ratio(middle)]
    ratio = fit.terms.damping_ratio(middle)
    intervals = [*map(fit.terms.interval, range(3)), fit.period, ratio]
    w = 2.0 * np.pi / law.period
    scales = [2.0 * w, 2.0 / made.size, 2.0 / (made.size**2 * w), law.period, 1.0]
    slack = TOLERANCE if made.disturbance == "none" else 0.0
    holds = [
        i.low - slack * scale <= x <= i.high + slack * scale
        for i, x, scale in zip(intervals, truth, scales, strict=True)
    ]
    errors = [
        fit.used_ratio(amplitude) / max(law.damping_ratio(amplitude), 1e-9) - 1.0
        for amplitude in (middle, 0.5 * made.size, made.size)
    ]
    return Outcome("", holds, errors, 0.5 * (ratio.high - ratio.low) / ratio.value)
