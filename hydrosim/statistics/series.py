"""Properties of an evenly spaced series: waves, memory, slow parts, scatter of its mean."""

from __future__ import annotations

import numpy as np
import scipy
from scipy.linalg import solve_toeplitz

SMOOTHING_NEIGHBOURS = 4  # neighbours in the spectrum
SERIES_BINS = 1024  # of a series whose slow parts are computed
PREDICTED_BY = 16  # values of a wave that predict the next one
NOISE_FRACTION = 1e-3  # of the variance: without noise, predictions of smooth motions are too good
# coefficients
MIN_COEFFICIENTS = 12
MAX_COEFFICIENTS = 48


def upcrossings(x: np.ndarray) -> np.ndarray:
    """Upcrossings of zero, in steps, by linear interpolation."""
    before = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    return np.asarray(before + x[before] / (x[before] - x[before + 1]))


def independent_samples(x: np.ndarray) -> float:
    """Length of a record x (nt,) in memories. The memory is the integral of the squared
    autocorrelation. The relative error of the variance is sqrt(2 / memories)."""
    return _samples_of_spectrum(spectrum(x))


def _samples_of_spectrum(power: np.ndarray) -> float:
    width = power.size // SMOOTHING_NEIGHBOURS * SMOOTHING_NEIGHBOURS
    smooth = power[:width].reshape(-1, SMOOTHING_NEIGHBOURS).mean(axis=1)
    # the mean square of a periodogram is twice the square of its expectation
    return float(
        2.0
        * (1.0 + 1.0 / SMOOTHING_NEIGHBOURS)
        * smooth.sum() ** 2
        * SMOOTHING_NEIGHBOURS
        / (smooth**2).sum()
    )


def prediction_errors(x: np.ndarray) -> tuple[np.ndarray, int]:
    """Errors of the linear prediction of each value of x (nt,) from the values of one wave before
    it, and the number of steps ahead. The equations are those of Yule and Walker (Box and Jenkins
    1976, Time Series Analysis, section 3.2). Errors are zero for the first wave."""
    z = x - x.mean()
    stride = max(round(z.size / (PREDICTED_BY * max(upcrossings(z).size, 1))), 1)
    z = z[::stride]
    power = np.abs(np.fft.rfft(z, 2 * z.size)) ** 2
    covariance = np.fft.irfft(power)[: PREDICTED_BY + 1]
    covariance[0] *= 1.0 + NOISE_FRACTION
    weights = solve_toeplitz(covariance[:-1], covariance[1:])
    errors = scipy.signal.lfilter(np.concatenate([[1.0], -weights]), 1.0, z)
    errors[:PREDICTED_BY] = 0.0
    return np.asarray(errors), stride


def low_frequency_share(x: np.ndarray, step: float, frequency: float) -> tuple[float, float]:
    """Fraction of the variance of x (nt,) below a ``frequency`` [rad/s], and the length of the
    record in memories of that part."""
    power = spectrum(x)
    omega = 2.0 * np.pi * np.fft.rfftfreq(x.size, step)[1:]
    slow = power[omega < frequency]
    if slow.size < SMOOTHING_NEIGHBOURS or not slow.sum() > 0.0:
        return 0.0, 0.0
    return float(slow.sum() / power.sum()), _samples_of_spectrum(slow)


def slow_part(x: np.ndarray, step: float, frequency: float) -> np.ndarray:
    """Part of x (nt,) below a ``frequency`` [rad/s], without its mean."""
    coefficients = np.fft.rfft(x - x.mean())
    coefficients[2.0 * np.pi * np.fft.rfftfreq(x.size, step) >= frequency] = 0.0
    return np.fft.irfft(coefficients, x.size)


def moments(x: np.ndarray) -> tuple[float, float]:
    """Skewness and kurtosis of x (nt,): 0 and 3 for a normal distribution."""
    z = x - x.mean()
    size = np.sqrt(np.mean(z**2))
    return float(np.mean(z**3) / size**3), float(np.mean(z**4) / size**4)


def lowest_frequency(x: np.ndarray, step: float, share: float = 0.01) -> float:
    """Frequency [rad/s] below which x (nt,) has a ``share`` of its variance."""
    power = np.cumsum(spectrum(x))
    at = int(np.searchsorted(power, share * power[-1]))
    return float(2.0 * np.pi * np.fft.rfftfreq(x.size, step)[1:][at])


def spectrum(x: np.ndarray) -> np.ndarray:
    """Squared Fourier coefficients of x (nt,), without its mean, tapered at both ends."""
    taper = np.sin(np.pi * (np.arange(x.size) + 0.5) / x.size)
    return np.asarray(np.abs(np.fft.rfft(taper * (x - x.mean()))[1:]) ** 2)


def scatter(series: np.ndarray, independent: float) -> np.ndarray:
    """Draws (..., count) of the error of the mean of each series (..., nt), which is so many times
    as long as its memory. They are the cosine coefficients that are slow against the memory
    (Lazarus et al. 2018, Journal of Business and Economic Statistics 36)."""
    return slow_parts(series, int(independent ** (2.0 / 3.0) / 3.0))


def slow_parts(series: np.ndarray, count: int) -> np.ndarray:
    """Lowest cosine coefficients (..., count) of each series (..., nt), from `MIN_COEFFICIENTS` to
    `MAX_COEFFICIENTS`. For a stationary series they are independent, and scatter as its mean does
    (Mueller 2007, Journal of Econometrics 141)."""
    sums = bin_sums(series, SERIES_BINS)
    bins = sums.shape[-1]
    count = int(np.clip(count, MIN_COEFFICIENTS, max(min(MAX_COEFFICIENTS, bins // 2), 1)))
    return np.asarray(np.sqrt(2.0) * sums @ _cosines(count, bins).T / series.shape[-1])


def _cosines(count: int, bins: int) -> np.ndarray:
    return np.cos(np.pi * np.outer(np.arange(1, count + 1), (np.arange(bins) + 0.5) / bins))


def bin_sums(series: np.ndarray, bins: int) -> np.ndarray:
    """Sums of each series (..., nt) over so many intervals of equal length, or over each value if
    there are fewer."""
    bins = min(bins, series.shape[-1])
    return np.add.reduceat(series, np.arange(bins) * series.shape[-1] // bins, axis=-1)
