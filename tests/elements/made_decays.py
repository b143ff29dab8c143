"""Made decays of roll: by an independent solver, as records of a basin look, with their truth."""

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from hydrosim.elements.decay_records import decay_of
from hydrosim.elements.roll_decay import DecayFit, fit_decays
from hydrosim.errors import InputError

DISTURBANCES = ("none", "white", "memory", "waves")
NAMES = ("p1", "p2", "p3", "natural period", "damping ratio in the middle of the amplitudes")
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


def roll_of(
    law: Law, time: np.ndarray, start: float, rate: float = 0.0, force: float = 0.0
) -> np.ndarray:
    """Roll (n,) [rad] from a ``start`` [rad] and ``rate`` [rad/s], by DOP853. A regular wave,
    0.7 % shorter than the natural period, has a ``force`` that heels to this angle [rad]."""
    p1, p2, p3, period, cubic = law
    k = (2.0 * np.pi / period) ** 2

    def slope(t: float, y: np.ndarray) -> list[float]:
        x, v = y
        wave = force * np.cos(np.sqrt(k) * 1.0067 * t + 0.8)
        return [v, -(p1 + p2 * abs(v) + p3 * v * v) * v - k * (x + cubic * x**3) + k * wave]

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
    rng: np.random.Generator,
    count: int,
    step: float,
    period: float,
    width: float,
    natural: float = 0.0,
) -> np.ndarray:
    """Noise (n,) of standard deviation 1 with the spectrum of waves: Gaussian in the logarithm of
    frequency about 1 / ``period``, with the relative ``width``; or that of a body in them with
    that ``natural`` period, if it is not zero, and 5 % of damping."""
    size = 4 * count
    frequency = np.fft.rfftfreq(size, step)[1:]
    power = np.exp(-0.5 * (np.log(frequency * period) / width) ** 2)
    ratio = frequency * natural
    power /= (1.0 - ratio**2) ** 2 + (0.1 * ratio) ** 2
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
    """A random decay of 3 to 40 periods, from 2 to 25 deg, at 5 to 100 Hz, from any phase.

    The damping ratio of the largest roll is 0.5 to 8 %, in any shares of linear, quadratic and
    cubic. The restoring is linear (half of them), or its period changes by up to 5 %. The mean is
    up to 3 deg, and drifts (half of them) by up to a tenth of the largest roll: in a line, as it
    settles, or by a sine longer than the record. The noise is one of `DISTURBANCES`.
    """
    rng = np.random.default_rng(seed)
    rate = 5.0 * 20.0 ** rng.uniform()
    period = max(rng.uniform(2.0, 15.0), 10.0 / rate)
    size = np.radians(rng.uniform(2.0, 25.0))
    law = _draw_law(rng, period, size)
    periods = 3.0 * (40.0 / 3.0) ** rng.uniform()
    time = np.arange(0.0, periods * period, 1.0 / rate)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    w = 2.0 * np.pi / period
    roll = roll_of(law, time, size * np.cos(phase), -size * w * np.sin(phase))
    disturbance = DISTURBANCES[seed % len(DISTURBANCES)]
    added = size * _draw_noise(rng, disturbance, time, law) + _draw_mean(rng, time, size)
    return Made(law, time, roll + added, size, periods, disturbance)


def _draw_law(rng: np.random.Generator, period: float, size: float) -> Law:
    w = 2.0 * np.pi / period
    ratio = 0.005 * 16.0 ** rng.uniform()
    linear, quadratic, cubic = 2.0 * w * ratio * rng.dirichlet([0.7, 0.7, 0.7])
    p2 = quadratic / (8.0 / (3.0 * np.pi) * w * size)
    p3 = cubic / (0.75 * (w * size) ** 2)
    shift = rng.uniform(-0.05, 0.05) if rng.integers(2) else 0.0
    return Law(linear, p2, p3, period, -2.0 * shift / (0.75 * size**2))


def _draw_mean(rng: np.random.Generator, time: np.ndarray, size: float) -> np.ndarray:
    mean = np.full(time.size, np.radians(rng.uniform(-3.0, 3.0)))
    if rng.integers(2):
        along = time / time[-1]
        settling = np.exp(-along / rng.uniform(0.3, 1.0))
        wander = np.sin(2.0 * np.pi * (rng.uniform(0.3, 0.8) * along + rng.uniform()))
        drifts = (along, settling, wander)
        mean += rng.uniform(-0.1, 0.1) * size * drifts[rng.integers(3)]
    return mean


def _draw_noise(
    rng: np.random.Generator, disturbance: str, time: np.ndarray, law: Law
) -> np.ndarray:
    """Noise (n,) as a share of the largest roll: white or with a memory, or of waves in the basin
    that calm down, with periods of half to twice the roll's, to which the body resonates."""
    step = time[1]
    if disturbance == "none":
        return np.zeros(time.size)
    if disturbance == "waves":
        length = law.period * 2.0 ** rng.uniform(-1.0, 1.0)
        waves = wave_noise(rng, time.size, step, length, rng.uniform(0.1, 0.3), law.period)
        calming = np.exp(-time / time[-1] * rng.uniform(0.0, 1.0))
        return 0.002 * 10.0 ** rng.uniform() * waves * calming + 0.001 * rng.normal(size=time.size)
    memory = law.period * rng.uniform(0.02, 0.3) if disturbance == "memory" else 0.0
    return 10.0 ** rng.uniform(-3.0, -1.3) * noise(rng, time.size, step, memory)


def draw_no_decay(seed: int) -> Made:
    """Noise of waves alone, a steady roll, one that creeps back without a swing, a growing one."""
    rng = np.random.default_rng(seed)
    kind = NO_DECAYS[seed % len(NO_DECAYS)]
    period = rng.uniform(4.0, 15.0)
    time = np.arange(0.0, rng.uniform(3.0, 40.0) * period, 0.1)
    size = np.radians(rng.uniform(3.0, 15.0))
    phase = 2.0 * np.pi * time / period + rng.uniform(0.0, 2.0 * np.pi)
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
    intervals of `NAMES` hold the truth, and the relative error of the damping for use at the
    amplitude in the middle of the recorded ones."""

    refusal: str
    holds: list[bool]
    error: float


def try_fit(made: Made) -> Outcome:
    """Fit a made decay and compare it with its truth."""
    try:
        return compare(made, fit_decays([decay_of(made.time, made.angle)]))
    except InputError as error:
        return Outcome(str(error), [], 0.0)


def compare(made: Made, fit: DecayFit) -> Outcome:
    """A fit beside the truth. One without noise may be off by `TOLERANCE`."""
    law = made.law or Law(0.0, 0.0, 0.0, 1.0)
    middle = 0.5 * sum(fit.amplitudes)
    ratio = law.damping_ratio(middle)
    truth = [*law[:4], ratio]
    intervals = [*map(fit.terms.interval, range(3)), fit.period, fit.terms.damping_ratio(middle)]
    w = 2.0 * np.pi / law.period
    scales = [2.0 * w, 2.0 / made.size, 2.0 / (made.size**2 * w), law.period, 1.0]
    slack = TOLERANCE if made.disturbance == "none" else 0.0
    holds = [
        i.low - slack * scale <= x <= i.high + slack * scale
        for i, x, scale in zip(intervals, truth, scales, strict=True)
    ]
    return Outcome("", holds, fit.used_ratio(middle) / ratio - 1.0 if ratio else np.inf)
