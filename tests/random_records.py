"""Random records of three hours whose largest value has known quantiles.

Records are halves of periods of six hours, made of independent complex Gaussian amplitudes on the
Fourier grid, so that energy scatters as in a Gaussian sea and nothing repeats itself. Quantiles of
the largest value are those of 20,000 other records, drawn by ``python -m benchmarks largest`` of
commit 94edf5e. They scatter by a hundredth of the standard deviation.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hydrosim.scene import Jonswap
from hydrosim.water.spectra import density

DURATION = 10800.0
MOST_PROBABLE = np.exp(-1.0)  # probability that the largest is below
Spectrum = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Kind:
    """Records in ``step`` [s] that ``draw`` makes of random numbers, (nt,): before anything is
    clipped at ``floor``. ``moments`` are their true mean and standard deviation; ``quantiles`` of
    the largest value are those of 0.05, exp(-1) and 0.95; ``slowest`` [rad/s] are the waves."""

    draw: Callable[[np.random.Generator], np.ndarray]
    step: float
    slowest: float
    moments: tuple[float, float]
    quantiles: tuple[float, float, float]
    floor: float = -np.inf

    def record(self, whole: np.ndarray) -> np.ndarray:
        """What is left of a record after clipping."""
        return np.maximum(whole, self.floor)

    def oracle(self, whole: np.ndarray) -> float:
        """The most probable maximum by one who knows the distribution but for its mean and standard
        deviation, and sees what is clipped, too."""
        mean, std = self.moments
        return float(whole.mean() + (self.quantiles[1] - mean) / std * whole.std())


class Process:
    """A Gaussian process of unit variance with a one-sided spectrum over frequencies [rad/s]."""

    def __init__(self, spectrum: Spectrum, step: float) -> None:
        self.count = 2 * round(DURATION / step)
        self.omega = 2 * np.pi * np.fft.rfftfreq(self.count, step)
        power = np.zeros(self.omega.size)
        power[1:] = spectrum(self.omega[1:])
        self.size = np.sqrt(power / power.sum())

    def amplitudes(self, random: np.random.Generator) -> np.ndarray:
        """Complex amplitudes over the frequencies."""
        parts = random.normal(size=(2, self.size.size))
        return self.size * (parts[0] + 1j * parts[1])

    def __call__(self, random: np.random.Generator) -> np.ndarray:
        whole = np.fft.irfft(self.amplitudes(random), self.count) * self.count / 2
        return whole[: self.count // 2]


@dataclass(frozen=True)
class Curved:
    """What rises with a Gaussian wave motion along a curve: its largest value is on the curve."""

    curve: Callable[[np.ndarray], np.ndarray]

    def __call__(self, random: np.random.Generator) -> np.ndarray:
        return self.curve(SEA(random))

    def kind(self, std: float, floor: float = -np.inf) -> Kind:
        """Of this standard deviation, and of no mean."""
        low, middle, high = self.curve(TOP)
        return Kind(self, 0.5, 0.45, (0.0, std), (low, middle, high), floor)


class SlowDrift:
    """A moored body of a natural ``period`` and ``damping`` ratio under a load with the square of
    the envelope of a sea of Tp 8 s (Newman's approximation with one coefficient), and ``waves``
    times the elevation. A stiffness of 1 moves it by as much as the load is."""

    def __init__(self, period: float, damping: float, step: float, waves: float = 0.0) -> None:
        self.process, self.waves = Process(jonswap(8.0), step), waves
        ratio = self.process.omega * period / (2 * np.pi)
        self.response = 1.0 / (1.0 - ratio**2 + 2j * damping * ratio)

    def __call__(self, random: np.random.Generator) -> np.ndarray:
        count = self.process.count
        both = np.zeros(count, dtype=complex)
        both[: count // 2 + 1] = self.process.amplitudes(random)
        wave = np.fft.ifft(both) * count  # with its Hilbert transform as imaginary part
        drift = np.fft.irfft(np.fft.rfft(np.abs(wave) ** 2) * self.response, count)
        return (drift + self.waves * wave.real)[: count // 2]


def jonswap(period: float, enhancement: float = 3.3) -> Spectrum:
    """JONSWAP up to 3 rad/s."""
    shape = Jonswap(significant_height=4.0, peak_period=period, peak_enhancement=enhancement)
    return lambda omega: density(shape, omega) * (omega < 3.0)


def resonant(omega: np.ndarray) -> np.ndarray:
    """A motion of 11 s and damping ratio 0.03 in JONSWAP waves of Tp 10 s."""
    ratio = omega * 11.0 / (2 * np.pi)
    return jonswap(10.0)(omega) / np.abs(1.0 - ratio**2 + 0.06j * ratio) ** 2


def moored(omega: np.ndarray) -> np.ndarray:
    """A motion of 100 s and damping ratio 0.2 in white noise."""
    ratio = omega * 100.0 / (2 * np.pi)
    return np.asarray(1.0 / np.abs(1.0 - ratio**2 + 0.4j * ratio) ** 2)


def accelerations(omega: np.ndarray) -> np.ndarray:
    """Of what follows the waves."""
    return omega**4 * jonswap(8.0, 1.0)(omega)


def sea_and_swell(omega: np.ndarray) -> np.ndarray:
    """As much of waves of Tp 6 s as of swell of 14 s: the motion of one body against another."""
    sea, swell = jonswap(6.0)(omega), jonswap(14.0, 7.0)(omega)
    return np.asarray(sea / sea.sum() + swell / swell.sum())


def slow_motion(slowest: float, fastest: float) -> Spectrum:
    """Even between two frequencies."""
    return lambda omega: ((omega > slowest) & (omega < fastest)).astype(float)


SEA = Process(jonswap(10.0), 0.5)
MOORED = Process(moored, 0.5)
CREEP = Process(slow_motion(1e-3, 1e-2), 0.5)
WEATHER = Process(slow_motion(1e-3, 2.0 * np.pi / 1800.0), 0.5)
GAUSSIAN, TOP = (0.0, 1.0), np.array([3.458, 3.762, 4.477])
PULSE = np.array([0.5, 1.0, 0.8, 0.4, 0.2, 0.1])


@dataclass(frozen=True)
class Impacts:
    """A sea with impacts of 3 s, once in so many seconds on average, of exponential sizes."""

    apart: float
    size: float

    def __call__(self, random: np.random.Generator) -> np.ndarray:
        x = SEA(random)
        hits = np.zeros(x.size)
        count = random.poisson(DURATION / self.apart)
        np.add.at(hits, random.integers(0, x.size, count), random.exponential(self.size, count))
        return x + np.convolve(hits, PULSE)[: x.size]


def crawling(random: np.random.Generator) -> np.ndarray:
    """A sea, and a slow part that is bounded."""
    return SEA(random) + 1.5 * np.tanh(2.0 * CREEP(random))


def gusting(random: np.random.Generator) -> np.ndarray:
    """A sea that waxes and wanes over half an hour and more."""
    return SEA(random) * np.exp(0.25 * WEATHER(random))


def beginning(random: np.random.Generator) -> np.ndarray:
    """A sea, and an oscillation of 80 s that dies out in ten minutes."""
    x = SEA(random)
    time = 0.5 * np.arange(x.size)
    return x + 4.0 * np.exp(-time / 300.0) * np.cos(2.0 * np.pi * time / 80.0)


def slamming(random: np.random.Generator) -> np.ndarray:
    """A sea, and half of the crests beyond two standard deviations slam, the more the higher."""
    x = SEA(random)
    above = (x[:-1] < 2.0) & (x[1:] >= 2.0)
    at = np.flatnonzero(above)
    at = at[random.random(at.size) < 0.5]
    hits = np.zeros(x.size)
    hits[at] = random.exponential(1.0, at.size)
    return x + np.convolve(hits, PULSE)[: x.size]


def with_swell(random: np.random.Generator) -> np.ndarray:
    """A sea, and a regular swell of 14 s as large as it."""
    x = SEA(random)
    phase = 2.0 * np.pi * random.random()
    return x + np.sqrt(2.0) * np.cos(2.0 * np.pi / 14.0 * 0.5 * np.arange(x.size) + phase)


def leaning_back(random: np.random.Generator) -> np.ndarray:
    """A sea, and a slow motion that comes up against a stiffening spring."""
    return 0.3 * SEA(random) + (1.0 - np.exp(-0.15 * MOORED(random))) / 0.15


def with_free_play(random: np.random.Generator) -> np.ndarray:
    """What a sea moves only beyond a standard deviation, either way, and a little of another."""
    x = SEA(random)
    return np.asarray(np.sign(x) * np.maximum(np.abs(x) - 1.0, 0.0) + 0.1 * SEA(random))


def switching(random: np.random.Generator) -> np.ndarray:
    """A sea about one of two places, at each of which it stays for two minutes on average."""
    x = SEA(random)
    switches = random.random(x.size) < 0.5 / 120.0
    return x + np.where(np.cumsum(switches) % 2 == 0, 1.5, -1.5)


def size(random: np.random.Generator) -> np.ndarray:
    """Of a motion: its absolute value."""
    return np.abs(SEA(random))


def power(random: np.random.Generator) -> np.ndarray:
    """Of a linear damper."""
    return SEA(random) ** 2


def speed(random: np.random.Generator) -> np.ndarray:
    """Of two components that are alike."""
    return np.hypot(SEA(random), SEA(random))


def with_current(random: np.random.Generator) -> np.ndarray:
    """Speed, two standard deviations of it steady along one axis."""
    return np.hypot(2.0 + SEA(random), SEA(random))


def friction(random: np.random.Generator) -> np.ndarray:
    """In slip, as large as a load that varies by 30 %, in the direction of a velocity."""
    return np.maximum(1.0 + 0.3 * SEA(random), 0.0) * np.sign(SEA(random))


STIFF = Curved(lambda z: np.sign(z) * np.abs(z) ** 1.5)
DRAG = Curved(lambda z: z * np.abs(z))
CRESTS = Curved(lambda z: z + 0.05 * (z**2 - 1.0))

KINDS = {
    "Gaussian wave motion": Kind(SEA, 0.5, 0.45, GAUSSIAN, (3.458, 3.762, 4.477)),
    "broad band": Kind(Process(jonswap(8.0, 1.0), 0.5), 0.5, 0.45, GAUSSIAN, (3.541, 3.830, 4.518)),
    "resonant, narrow band": Kind(
        Process(resonant, 0.5), 0.5, 0.45, GAUSSIAN, (3.144, 3.502, 4.323)
    ),
    "clipped contact force": Kind(SEA, 0.5, 0.45, GAUSSIAN, (3.458, 3.762, 4.477), 0.0),
    "the same, open for 84 %": Kind(SEA, 0.5, 0.45, GAUSSIAN, (3.458, 3.762, 4.477), 1.0),
    "slow drift, damping 0.2": Kind(
        SlowDrift(120.0, 0.2, 1.0), 1.0, 0.55, (2.0, 1.713), (7.754, 9.262, 13.198)
    ),
    "damping 0.1": Kind(SlowDrift(120.0, 0.1, 1.0), 1.0, 0.55, (2.0, 2.416), (9.134, 10.94, 15.52)),
    "damping 0.05": Kind(
        SlowDrift(120.0, 0.05, 1.0), 1.0, 0.55, (2.0, 3.412), (10.85, 13.03, 18.33)
    ),
    "damping 0.2, with waves": Kind(
        SlowDrift(120.0, 0.2, 1.0, 0.3), 1.0, 0.55, (2.0, 1.739), (8.142, 9.650, 13.61)
    ),
    "tension, slack for 7 %": Kind(SEA, 0.5, 0.45, GAUSSIAN, (3.458, 3.762, 4.477), -1.5),
    # std of |z|^1.5, of z |z|, of z + 0.05 (z^2 - 1)
    "stiffening contact force": STIFF.kind(np.sqrt(2.0 * np.sqrt(2.0 / np.pi)), 0.0),
    "drag force": DRAG.kind(np.sqrt(3.0)),
    "crests of second order": CRESTS.kind(np.sqrt(1.005)),
    "acceleration": Kind(Process(accelerations, 0.5), 0.5, 0.45, GAUSSIAN, (3.620, 3.902, 4.569)),
    "relative motion, two peaks": Kind(
        Process(sea_and_swell, 0.5), 0.5, 0.3, GAUSSIAN, (3.510, 3.811, 4.519)
    ),
    "size of a motion": Kind(size, 0.5, 0.45, (0.798, 0.603), (3.606, 3.909, 4.613)),
    "power": Kind(power, 0.5, 0.45, (1.0, np.sqrt(2.0)), (13.00, 15.28, 21.28)),
    "speed in a plane": Kind(speed, 0.5, 0.45, (1.253, 0.655), (4.040, 4.326, 4.999)),
    "speed with current": Kind(with_current, 0.5, 0.45, (2.272, 0.914), (5.601, 5.910, 6.614)),
    "friction in slip": Kind(friction, 0.5, 0.45, (0.0, 1.044), (1.985, 2.082, 2.306)),
}

HARD = {
    "impacts every 120 s": Impacts(120.0, 2.0),
    "every 200 s, larger": Impacts(200.0, 3.0),
    "every 300 s, smaller": Impacts(300.0, 1.5),
    "every 600 s": Impacts(600.0, 2.0),
    "every 1200 s, larger": Impacts(1200.0, 3.0),
    "bounded slow part": crawling,
    "gusts": gusting,
    "transient": beginning,
    "slamming of crests": slamming,
    "slow, leaning back": leaning_back,
    "free play": with_free_play,
    "sea and regular swell": with_swell,
    "two places": switching,
}
"""Records in steps of 0.5 s of waves above 0.45 rad/s, whose largest values are of no one law."""
