"""Properties of an evenly spaced series: waves, peaks, memory, slow parts, stationarity.

Peaks of a record (the largest value of each wave above the mean), and their Weibull law.

    P(peak <= x) = 1 - exp(-(x / scale)^shape)

The shape is 2 if peaks follow Rayleigh's law, as in a narrow-banded Gaussian record
(Longuet-Higgins 1952). It is smaller if large peaks are more frequent.

Tests whether mean and variance of a record change over its time.

The lowest cosine coefficients of a stationary series are independent and have equal variance, for
any memory, if the record is many memories long (Mueller 2007, Journal of Econometrics 141). A
steady trend appears in the first coefficient, other trends in the first few. Without a trend, their
mean square over that of the rest has Fisher's distribution. For the variance, the series is the
logarithm of the variance of short intervals, which is nearly normal.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

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
    weights = scipy.linalg.solve_toeplitz(covariance[:-1], covariance[1:])
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


def skewness_and_kurtosis(x: np.ndarray) -> tuple[float, float]:
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
    return np.asarray(np.sqrt(2.0) * sums @ _cosine_table(count, bins).T / series.shape[-1])


def _cosine_table(count: int, bins: int) -> np.ndarray:
    return np.cos(np.pi * np.outer(np.arange(1, count + 1), (np.arange(bins) + 0.5) / bins))


def bin_sums(series: np.ndarray, bins: int) -> np.ndarray:
    """Sums of each series (..., nt) over so many intervals of equal length, or over each value if
    there are fewer."""
    bins = min(bins, series.shape[-1])
    return np.add.reduceat(series, np.arange(bins) * series.shape[-1] // bins, axis=-1)


MIN_PEAKS = 3  # peaks
LEVEL_COUNT, MIN_CROSSINGS = 40, 20  # number of levels above the mean; crossings of a used level
MIN_LOG_FALL = 0.3  # of the logarithm of a rate: lower levels are among small waves
# over the root of crossings: shapes of lower and upper levels scatter by less
SHAPE_DIFFERENCE = 4.0
NEWTON_ITERATIONS, NEWTON_TOLERANCE = 50, 1e-12  # of Newton's method
MIN_PROBABILITY = 1e-12  # least probability that is told from zero and one


class Weibull(NamedTuple):
    """Weibull law of peaks; NaN if there are too few, or all are equal."""

    shape: float
    scale: float


class Tail(NamedTuple):
    """A record rises above a level ``waves`` exp(-((level - origin) / scale)^shape) times. The
    shape is 2 for a Gaussian process about its mean, for any bandwidth. ``crossings`` is the number
    of upcrossings behind the shape."""

    origin: float
    shape: float
    scale: float
    waves: int
    crossings: int

    def exceedances(self, level: float) -> float:
        """Expected number of upcrossings of a level."""
        return float(self.waves * np.exp(-(((level - self.origin) / self.scale) ** self.shape)))


def peaks(x: np.ndarray) -> np.ndarray:
    """Largest values (n,) above the mean between successive upcrossings of it."""
    z = x - x.mean()
    first = np.ceil(upcrossings(z)).astype(int)
    return np.maximum.reduceat(z, first)[:-1] if first.size > 1 else np.zeros(0)


class _UpcrossingDecrease(NamedTuple):
    """Decrease of the logarithm of upcrossings, ``fallen``, at some levels, and the number of
    crossings of each."""

    levels: np.ndarray
    fallen: np.ndarray
    counts: np.ndarray

    def halves(self) -> tuple[_UpcrossingDecrease, _UpcrossingDecrease]:
        """The lower and the upper levels."""
        parts = [np.array_split(values, 2) for values in self]
        lower, upper = zip(*parts, strict=True)
        return _UpcrossingDecrease(*lower), _UpcrossingDecrease(*upper)

    def fits(self) -> bool:
        """Whether there are enough levels for a shape."""
        return self.levels.size >= MIN_PEAKS and float(np.ptp(self.fallen)) > 0.0

    def fit(self) -> tuple[float, float]:
        """Shape and scale of the tail."""
        weight = self.fallen * np.sqrt(self.counts)
        shape, offset = np.polyfit(np.log(self.levels), np.log(self.fallen), 1, w=weight)
        return float(shape), float(np.exp(-offset / shape))

    def tail(self, origin: float, waves: int) -> Tail:
        """Tail by all of these levels; NaN if they are too few."""
        shape, scale = self.fit() if self.fits() else (np.nan, np.nan)
        return Tail(origin, shape, scale, waves, waves)


def fit_tail(x: np.ndarray, origin: float) -> Tail:
    """Tail of a record x (nt,) above an origin, from its upcrossings of often crossed levels; NaN
    if these are too few."""
    falls, waves = _split_falls(x, origin)
    return falls.tail(origin, waves)


def fit_upper_tail(x: np.ndarray, origin: float) -> Tail:
    """`fit_tail`, but by the upper half of the levels if the shape is larger there than at the
    lower ones, repeatedly."""
    falls, waves = _split_falls(x, origin)
    tail = falls.tail(origin, waves)
    while True:
        lower, falls = falls.halves()
        if not (lower.fits() and falls.fits()):
            return tail
        shape, scale = falls.fit()
        crossings = int(falls.counts[0])
        if shape - lower.fit()[0] < SHAPE_DIFFERENCE * shape / np.sqrt(crossings):
            return tail
        tail = Tail(origin, shape, scale, waves, crossings)


def _split_falls(x: np.ndarray, origin: float) -> tuple[_UpcrossingDecrease, int]:
    """Often crossed levels above an origin, and the number of crossings of the origin."""
    z = x - origin
    levels = z.max() * np.arange(1, LEVEL_COUNT) / LEVEL_COUNT
    counts = np.array([np.count_nonzero((z[:-1] < u) & (z[1:] >= u)) for u in (0.0, *levels)])
    fallen = np.log(counts[0] / np.maximum(counts[1:], 1))
    used = (counts[1:] >= MIN_CROSSINGS) & (fallen > MIN_LOG_FALL)
    return _UpcrossingDecrease(levels[used], fallen[used], counts[1:][used]), int(counts[0])


def exponential_misfit(excesses: np.ndarray) -> float:
    """Anderson's and Darling's statistic of ``excesses`` (n,) over an exponential distribution of
    their mean (Stephens 1974, Journal of the American Statistical Association 69)."""
    count = excesses.size
    below = -np.expm1(-np.sort(excesses) / excesses.mean())
    statistic = anderson_darling(np.clip(below, MIN_PROBABILITY, 1.0 - MIN_PROBABILITY))
    return statistic * (1.0 + 0.6 / count)


def anderson_darling(below: np.ndarray) -> float:
    """Anderson's and Darling's statistic of values whose rising probabilities ``below`` (n,) by a
    law are above 0 and below 1."""
    count = below.size
    weight = 2.0 * np.arange(1, count + 1) - 1.0
    return float(-count - np.mean(weight * (np.log(below) + np.log1p(-below[::-1]))))


def fit_weibull(heights: np.ndarray) -> Weibull:
    """Maximum likelihood law of ``heights`` (n,) above zero. The shape k is the zero of sum(x^k log
    x) / sum(x^k) - 1 / k - mean(log x)."""
    if heights.size < MIN_PEAKS or not np.ptp(heights) > NEWTON_TOLERANCE * heights.max():
        return Weibull(np.nan, np.nan)
    top = float(heights.max())
    log = np.log(heights / top)
    k = float(np.pi / (np.sqrt(6.0) * log.std()))
    for _ in range(NEWTON_ITERATIONS):
        weight = np.exp(k * log)
        first, second = (np.average(log**n, weights=weight) for n in (1, 2))
        step = (first - 1.0 / k - log.mean()) / (second - first**2 + 1.0 / k**2)
        k = max(k - step, 0.2 * k)
        if abs(step) < NEWTON_TOLERANCE * k:
            break
    return Weibull(k, float(top * np.exp(k * log).mean() ** (1.0 / k)))


TREND_COEFFICIENTS = (1, 3)  # coefficients
GUST_COEFFICIENTS = 12  # coefficients of the variance: groups of waves that vary slowly
BEGINNING_PARTS = (8, 16, 32, 64)  # parts of the record, the first of which may be a transient
MIN_INTERVALS = 10  # intervals of a beginning
LOG_VARIANCE_ROUNDING = 1e-9  # logarithms of variances: smaller differences are rounding
TRANSIENT_ALARM = 1e-5  # probability of a false alarm, for independent intervals
TREND_ALARM = 0.001  # probability of a false alarm, for each trend of mean and of variance
COEFFICIENT_MEMORIES = 6  # of a memory: coefficients that are slow against it
INTERVAL_MEMORIES = 2  # memories
VARIANCE_FLOOR = 0.05  # of the variance: less in an interval does not matter


def changes_of_moments(x: np.ndarray, independent: float) -> tuple[bool, bool]:
    """Whether mean and variance of a record x (nt,) change; the record is so many times as long as
    its memory."""
    z = (x - x.mean()) / x.std()
    variance = _log_variances(z, independent)
    count = int(independent / COEFFICIENT_MEMORIES)
    return _has_trend(z, count), _has_trend(variance, count) or _has_gusts(z, independent)


def has_initial_transient(x: np.ndarray, independent: float) -> bool:
    """Whether the variance of a record x (nt,) is larger at its beginning than later, as in a
    transient. The test is Student's, on logarithms of the variance of short intervals."""
    variance = _log_variances((x - x.mean()) / x.std(), independent)
    for part in BEGINNING_PARTS:
        first = variance[: variance.size // part]
        if first.size < MIN_INTERVALS or not np.ptp(first) > LOG_VARIANCE_ROUNDING:
            continue
        test = scipy.stats.ttest_ind(
            first, variance[first.size :], equal_var=False, alternative="greater"
        )
        if test.pvalue < TRANSIENT_ALARM:
            return True
    return False


def _log_variances(z: np.ndarray, independent: float) -> np.ndarray:
    """Logarithms of the variance of z (nt,) in short intervals."""
    stretches = max(int(independent / INTERVAL_MEMORIES), 1)
    variance = bin_sums(z**2, stretches) / bin_sums(np.ones(z.size), stretches)
    return np.asarray(np.log(variance + VARIANCE_FLOOR))


def _has_trend(series: np.ndarray, count: int) -> bool:
    """Whether the first of the lowest coefficients of a series are larger than the rest."""
    squares = slow_parts(series - series.mean(), count) ** 2
    return any(
        _is_larger(squares[:first], squares[max(TREND_COEFFICIENTS) :])
        for first in TREND_COEFFICIENTS
    )


def _has_gusts(z: np.ndarray, independent: float) -> bool:
    """Whether the size of waves varies slowly. The test compares more of the lowest coefficients
    with an equal number of others, for the variance of prediction errors, which scatters least."""
    errors, _ = prediction_errors(z)
    variance = _log_variances(errors / errors.std(), independent)
    squares = slow_parts(variance - variance.mean(), int(independent / COEFFICIENT_MEMORIES)) ** 2
    return squares.size >= 2 * GUST_COEFFICIENTS and _is_larger(
        squares[:GUST_COEFFICIENTS], squares[GUST_COEFFICIENTS:]
    )


def _is_larger(first: np.ndarray, rest: np.ndarray) -> bool:
    """Whether the mean of the first squares is larger than that of the rest, by Fisher's test."""
    if rest.size == 0:
        return False
    return bool(first.mean() > scipy.stats.f.isf(TREND_ALARM, first.size, rest.size) * rest.mean())
