"""Figures of the difference between a recorded channel and ours, which is ours minus recorded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from hydrosim.compare.align import ChannelPair

# Two series over the same times: correlation at lags, frequency bands, and the gain, lag and
# offset between them.

STEP_TOLERANCE = 1e-6  # of a step
EQUAL_CORRELATIONS = 0.002  # correlations that differ by less: the smaller lag is chosen


class GainLagFit(NamedTuple):
    """Fit recorded(t) = ``gain`` ours(t - ``lag``) + ``offset``. ``rest`` is the rms of the
    remainder, ``correlation`` the correlation at that lag. Each effect is the increase of the rms,
    in squares, without that gain, lag or offset."""

    gain: float
    lag: float
    offset: float
    rest: float
    correlation: float
    gain_effect: float
    lag_effect: float
    offset_effect: float


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def correlation(ours: np.ndarray, recorded: np.ndarray) -> float:
    """Pearson's correlation; 0 if either series is constant."""
    a, r = ours - ours.mean(), recorded - recorded.mean()
    size = rms(a) * rms(r)
    return float(np.mean(a * r) / size) if size > 0.0 else 0.0


def resample_evenly(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The values at the same number of evenly spaced times; by a cubic spline if they are
    uneven."""
    steps = np.diff(time)
    if np.ptp(steps) <= STEP_TOLERANCE * steps.mean():
        return values
    return scipy.interpolate.CubicSpline(time, values)(np.linspace(time[0], time[-1], time.size))


def split_bands(
    time: np.ndarray, values: np.ndarray, edges: tuple[float, float]
) -> list[np.ndarray]:
    """Three series that add up to the (even) values: slow with mean and trend, waves, and fast.
    ``edges`` between them are in rad/s."""
    even = resample_evenly(time, values)
    step = (time[-1] - time[0]) / (time.size - 1)
    ends = np.polyfit(time - time[0], even, 1)
    trend = np.polyval(ends, np.linspace(0.0, time[-1] - time[0], time.size))
    spectrum = np.fft.rfft(even - trend)
    omega = 2.0 * np.pi * np.fft.rfftfreq(time.size, step)
    waves, fast = (
        np.fft.irfft(np.where(band, spectrum, 0.0), time.size)
        for band in ((omega >= edges[0]) & (omega < edges[1]), omega >= edges[1])
    )
    return [even - waves - fast, waves, fast]


def best_lag(time: np.ndarray, ours: np.ndarray, recorded: np.ndarray, most: float) -> float:
    """Lag [s] of the recorded series behind ours with the largest correlation of either sign. Among
    equally good lags it is the smallest; ``most`` is its bound."""
    a, r = resample_evenly(time, ours), resample_evenly(time, recorded)
    step = (time[-1] - time[0]) / (time.size - 1)
    count = min(int(most / step), time.size // 2)
    rho = np.abs(_correlations(a, r, count))
    peaks = 1 + np.flatnonzero((rho[1:-1] >= rho[:-2]) & (rho[1:-1] >= rho[2:]))
    if peaks.size == 0:
        return 0.0
    left, top, right = rho[peaks - 1], rho[peaks], rho[peaks + 1]
    bend = 2.0 * top - left - right
    heights = top + np.where(
        bend > 0.0, (right - left) ** 2 / (8.0 * np.maximum(bend, 1e-300)), 0.0
    )
    good = peaks[heights >= heights.max() - EQUAL_CORRELATIONS]
    start = step * float(good[np.argmin(np.abs(good - count))] - count)
    even = np.linspace(time[0], time[-1], time.size)
    curve = scipy.interpolate.CubicSpline(even, a)

    def miss(lag: float) -> float:
        inside = _is_within_record(even, lag)
        return -abs(correlation(curve(even[inside] - lag), r[inside]))

    bounds = (start - step, start + step)
    lag = float(
        scipy.optimize.minimize_scalar(miss, bounds=bounds, options={"xatol": 1e-4 * step}).x
    )
    return lag if miss(lag) < miss(0.0) else 0.0


def fit(time: np.ndarray, ours: np.ndarray, recorded: np.ndarray, most: float) -> GainLagFit:
    """Least-squares fit over the times at which both series exist for this lag."""
    lag = best_lag(time, ours, recorded, most)
    inside = _is_within_record(time, lag)
    now, r = ours[inside], recorded[inside]
    late = now if lag == 0.0 else scipy.interpolate.CubicSpline(time, ours)(time[inside] - lag)
    gain, offset, rest = _line(late, r)
    through_zero = float(late @ r / (late @ late)) if late.any() else 0.0
    without = (
        rms(r - np.copysign(1.0, gain) * late - np.mean(r - np.copysign(1.0, gain) * late)),
        _line(now, r)[2],
        rms(r - through_zero * late),
    )
    effects = (float(np.sqrt(max(other**2 - rest**2, 0.0))) for other in without)
    return GainLagFit(gain, lag, offset, rest, correlation(late, r), *effects)


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float]:
    """Gain, offset and rms of the remainder of the line y = gain x + offset."""
    dx = x - x.mean()
    spread = float(dx @ dx)
    gain = float(dx @ y) / spread if spread > 0.0 else 0.0
    offset = float(y.mean() - gain * x.mean())
    return gain, offset, rms(y - gain * x - offset)


def _is_within_record(time: np.ndarray, lag: float) -> np.ndarray:
    """Whether each time shifted by the lag lies within the record."""
    return (time - lag >= time[0]) & (time - lag <= time[-1])


def _correlations(a: np.ndarray, r: np.ndarray, count: int) -> np.ndarray:
    """Pearson's correlation of r(i) and a(i - k) where both exist, for k from -count to count (2
    count + 1,)."""
    a, r = a - a.mean(), r - r.mean()
    k = np.arange(-count, count + 1)
    both = a.size - np.abs(k)
    in_r, in_a = np.maximum(k, 0), np.maximum(-k, 0)
    r1, r2 = _sums(r, in_r, both), _sums(r**2, in_r, both)
    a1, a2 = _sums(a, in_a, both), _sums(a**2, in_a, both)
    product = scipy.signal.correlate(r, a, method="fft")[a.size - 1 - count : a.size + count]
    spread = (r2 - r1**2 / both) * (a2 - a1**2 / both)
    least = 1e-12 * float((r @ r) * (a @ a))
    size = np.sqrt(np.where(spread > least, spread, np.inf))
    return (product - r1 * a1 / both) / size


def _sums(x: np.ndarray, first: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Sums of ``count`` entries from ``first`` on."""
    total = np.concatenate([[0.0], np.cumsum(x)])
    return total[first + count] - total[first]


BANDS = ("slow", "waves", "fast")
BAND_EDGES_RAD_S = (0.1, 2.5)  # rad/s, between them
DRIFT_END_FRACTION = 0.1  # of the time: intervals at its start and end whose means give the drift
CONSTANT_FRACTION = 1e-12  # of the largest value: smaller variation counts as constant
CONTACT_VARIABLES = ("fender_normal_force", "fender_compression")
CONTACT_FRACTION = 1e-3  # of the largest value: larger values are contact


class Figures(NamedTuple):
    """Figures of a channel, in its unit. Of the difference: ``rms``; ``relative``, which is rms
    over the ``std`` of the recording (NaN if that is constant); the largest value and its time; the
    mean. drift is the difference of both drifts from the first tenth of the time to the last. The
    last fields are the rms of the difference in each band, and the std of ours and of the recording
    there."""

    rms: float
    relative: float
    std: float
    peak: float
    peak_time: float
    mean: float
    drift: float
    correlation: float
    band_rms: tuple[float, ...]
    band_ours: tuple[float, ...]
    band_recorded: tuple[float, ...]


class ContactComparison(NamedTuple):
    """First contact [s] (NaN if there is none) and fraction of the time in contact, for both."""

    first_ours: float
    first_recorded: float
    share_ours: float
    share_recorded: float


def figures(time: np.ndarray, pair: ChannelPair, edges: tuple[float, float]) -> Figures:
    """Figures of a pair over ``time`` (n,) [s]; ``edges`` [rad/s] separate the bands."""
    difference = pair.ours - pair.recorded
    size, worst = rms(difference), int(np.argmax(np.abs(difference)))
    std = std_above_rounding(pair.recorded)
    series = (difference - difference.mean(), pair.ours, pair.recorded)
    bands = [
        tuple(float(np.std(part)) for part in split_bands(time, values, edges)) for values in series
    ]
    return Figures(
        size,
        size / std if std > 0.0 else float("nan"),
        std,
        float(np.abs(difference[worst])),
        float(time[worst]),
        float(difference.mean()),
        _drift(pair.ours) - _drift(pair.recorded),
        correlation(pair.ours, pair.recorded),
        *bands,
    )


def std_above_rounding(values: np.ndarray) -> float:
    """Standard deviation; 0 if it is only rounding."""
    std = float(np.std(values))
    return std if std > CONSTANT_FRACTION * float(np.abs(values).max()) else 0.0


def contact(time: np.ndarray, pair: ChannelPair) -> ContactComparison | None:
    """First contact and fraction of contact of a fender; None for other channels."""
    if not pair.channel.startswith(CONTACT_VARIABLES):
        return None
    touching = [x > CONTACT_FRACTION * float(np.abs(x).max()) for x in (pair.ours, pair.recorded)]
    first = [float(time[np.argmax(t)]) if t.any() else float("nan") for t in touching]
    return ContactComparison(*first, *(float(np.mean(t)) for t in touching))


def _drift(values: np.ndarray) -> float:
    """Mean over the last tenth minus mean over the first tenth."""
    count = max(1, int(DRIFT_END_FRACTION * values.size))
    return float(values[-count:].mean() - values[:count].mean())
