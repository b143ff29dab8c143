"""What an evenly spaced series is like: waves, memory, slow parts, scatter of its means."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

SMOOTHED = 4  # neighbours in the spectrum
BINS = 1024  # of a series whose slow parts are asked for
PREDICTED_BY = 16  # values of a wave, by which the next one is foretold
NOISE = 1e-3  # of the variance: without any, smooth motions are foretold too well
# coefficients
LEAST = 12
MOST = 48


def upcrossings(x: np.ndarray) -> np.ndarray:
    """Where x rises through zero, in steps, by linear interpolation."""
    before = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    return np.asarray(before + x[before] / (x[before] - x[before + 1]))


def memories(x: np.ndarray) -> float:
    """How many times as long as its memory a record x (nt,) is, the memory being the integral of
    the squared autocorrelation: the variance is known to sqrt(2 / memories) of itself."""
    return _memories(spectrum(x))


def _memories(power: np.ndarray) -> float:
    width = power.size // SMOOTHED * SMOOTHED
    smooth = power[:width].reshape(-1, SMOOTHED).mean(axis=1)
    # the mean square of a periodogram is twice that of what it scatters about
    return float(2.0 * (1.0 + 1.0 / SMOOTHED) * smooth.sum() ** 2 * SMOOTHED / (smooth**2).sum())


def prediction_errors(x: np.ndarray) -> tuple[np.ndarray, int]:
    """What each value of x (nt,), in so many steps, is off its linear prediction from those of one
    wave before it, by the equations of Yule and Walker (Box and Jenkins 1976, Time Series Analysis,
    section 3.2); and the number of steps. Zero of the first wave."""
    z = x - x.mean()
    stride = max(round(z.size / (PREDICTED_BY * max(upcrossings(z).size, 1))), 1)
    z = z[::stride]
    power = np.abs(np.fft.rfft(z, 2 * z.size)) ** 2
    covariance = np.fft.irfft(power)[: PREDICTED_BY + 1]
    covariance[0] *= 1.0 + NOISE
    weights = solve_toeplitz(covariance[:-1], covariance[1:])
    errors = lfilter(np.concatenate([[1.0], -weights]), 1.0, z)
    errors[:PREDICTED_BY] = 0.0
    return np.asarray(errors), stride


def below(x: np.ndarray, step: float, frequency: float) -> tuple[float, float]:
    """Share of the variance of x (nt,) below a ``frequency`` [rad/s], and how many times as long as
    its memory the record is of that part."""
    power = spectrum(x)
    omega = 2.0 * np.pi * np.fft.rfftfreq(x.size, step)[1:]
    slow = power[omega < frequency]
    if slow.size < SMOOTHED or not slow.sum() > 0.0:
        return 0.0, 0.0
    return float(slow.sum() / power.sum()), _memories(slow)


def slow_part(x: np.ndarray, step: float, frequency: float) -> np.ndarray:
    """What of x (nt,) is below a ``frequency`` [rad/s], its mean left out."""
    coefficients = np.fft.rfft(x - x.mean())
    coefficients[2.0 * np.pi * np.fft.rfftfreq(x.size, step) >= frequency] = 0.0
    return np.fft.irfft(coefficients, x.size)


def moments(x: np.ndarray) -> tuple[float, float]:
    """The skewness and the kurtosis of x (nt,): 0 and 3 of a normal distribution."""
    z = x - x.mean()
    size = np.sqrt(np.mean(z**2))
    return float(np.mean(z**3) / size**3), float(np.mean(z**4) / size**4)


def lowest_frequency(x: np.ndarray, step: float, share: float = 0.01) -> float:
    """The frequency [rad/s] below which a ``share`` of the variance of x (nt,) is."""
    power = np.cumsum(spectrum(x))
    at = int(np.searchsorted(power, share * power[-1]))
    return float(2.0 * np.pi * np.fft.rfftfreq(x.size, step)[1:][at])


def spectrum(x: np.ndarray) -> np.ndarray:
    """Squared Fourier coefficients of x (nt,), its mean left out, tapered at both ends."""
    taper = np.sin(np.pi * (np.arange(x.size) + 0.5) / x.size)
    return np.asarray(np.abs(np.fft.rfft(taper * (x - x.mean()))[1:]) ** 2)


def scatter(series: np.ndarray, independent: float) -> np.ndarray:
    """Draws (..., count) of what the mean of each series (..., nt) is off, which is so many times
    as long as its memory: as many cosine coefficients as are slow against it (Lazarus et al. 2018,
    Journal of Business and Economic Statistics 36)."""
    return slow_parts(series, int(independent ** (2.0 / 3.0) / 3.0))


def slow_parts(series: np.ndarray, count: int) -> np.ndarray:
    """The lowest cosine coefficients (..., count) of each series (..., nt), of `LEAST` to `MOST`:
    of one that is stationary they are independent, and scatter as its mean does (Mueller 2007,
    Journal of Econometrics 141)."""
    sums = binned(series, BINS)
    bins = sums.shape[-1]
    count = int(np.clip(count, LEAST, max(min(MOST, bins // 2), 1)))
    return np.asarray(np.sqrt(2.0) * sums @ _cosines(count, bins).T / series.shape[-1])


def _cosines(count: int, bins: int) -> np.ndarray:
    return np.cos(np.pi * np.outer(np.arange(1, count + 1), (np.arange(bins) + 0.5) / bins))


def binned(series: np.ndarray, bins: int) -> np.ndarray:
    """Sums of each series (..., nt) over so many stretches of equal length, or over each value if
    there are fewer."""
    bins = min(bins, series.shape[-1])
    return np.add.reduceat(series, np.arange(bins) * series.shape[-1] // bins, axis=-1)
