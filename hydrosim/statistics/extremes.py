"""Largest value of a record: the most probable maximum, and intervals.

The most probable maximum of a duration is the value that is exceeded once on average. The largest
value is below it with probability exp(-1). A record counts as Gaussian, clipped if it often stays
at its smallest value (a contact that opens), unless

* its third or fourth moment is not Gaussian and matters for the largest value,
* it has impacts, which have a law of their own (`hydrosim.statistics.gaussian`), or
* it is slow: more than `SLOW_FRACTION` of its variance is below the frequencies of the waves, and
  that part has too few cycles to show its moments. Slow drift is quadratic in the waves, and its
  tail is nearly exponential (Naess 1986, Applied Ocean Research 8).

Otherwise a Gumbel law is fitted to window maxima. The longer the correlation time, the fewer
windows. Fast records are first raised to the power that makes their tail exponential. That power
follows from the upcrossings of levels; if upper and lower levels differ, from the upper ones. Slow
records do not reach their tail. They are fitted as they are if they are skewed towards the largest
values, as slow drift is. Otherwise the power is between one and the value from the levels, because
slow motions by contacts have nearly Gaussian tails. A magnitude, which reaches zero and is never
negative, is fitted by its square. No law is fitted where the highest crests of a fast record are
not exponential in that power.

A law is accepted only if its fit to one half of the record allows the largest value of the other
half, both ways. No law is fitted to a slow part that oscillates between bounds, or if mean or
variance change (`hydrosim.statistics.series`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import partial
from typing import NamedTuple

import numpy as np

from hydrosim.statistics import gaussian, gumbel, series

MEMORIES_PER_WINDOW = 4  # in a window, at least
MIN_WINDOWS, MAX_WINDOWS = 8, 50  # windows
# windows: shorter windows hold too few waves for Gumbel's law
GUMBEL_WINDOWS = (8, 10, 13, 17, 22, 28, 34)
# waves in a window, at least, unless that leaves fewer windows than this
WAVES_PER_WINDOW, SUFFICIENT_WINDOWS = 70, 13
# of the variance; memories: a longer slow part shows its moments
SLOW_FRACTION, MIN_MEMORIES = 0.05, 250.0
# of the time: a record that is longer at its smallest value is clipped there
CLIPPED_FRACTION = 0.005
# of the range: maxima that differ by less are equal, as in a regular wave
EQUAL_MAXIMA_FRACTION = 1e-3
EQUAL_PERIODS_FRACTION = 0.05  # of the mean period: periods that differ by less are equal
# mean number of exceedances of the largest value, below which the law is rejected
MIN_EXCEEDANCES = 1e-4
MIN_WAVES = 20  # waves
TAIL_SHAPE_RANGE = (0.5, 4.0)  # of a tail: larger shapes are nearly cut off
GAUSSIAN_SHAPE = 2.0  # shape of a tail: slow drift has smaller shapes at often crossed levels
SLOW_SHAPE_RANGE = (2.0, 4.0)  # bounds of the shape of a slow record that is not slow drift
SHAPE_SCATTER = 1.3  # scatter of shapes: this times the shape over the root of the number of waves
NORMAL_QUANTILE = 1.645  # quantile of a normal distribution that 5 % exceed
ZERO_FRACTION = 0.02  # of the range: a magnitude comes this close to zero
# of the mean: standard deviation of a magnitude, 0.52 for two Gaussian components, 0.76 for one
MAGNITUDE_STD_RANGE = (0.48, 0.9)
# probability of the largest value of one half by the law of the other, each side
HALF_TEST_PROBABILITY = 0.0025
# mean number of exceedances of the largest value by the tail of the other waves
MIN_TAIL_EXCEEDANCES = 1e-3
MIN_SLOW_KURTOSIS = 1.9  # kurtosis of a slow part: 1.5 for a sine, 1.8 uniform, 3 normal
RECORD_ROUNDING_FRACTION = 1e-12  # of the largest value
LOWER_END_FACTOR = 1.4
"""Reach of the lower end of confidence in a slow record that leans, in a run with contacts. Slow
drift has an exponential tail, what leans on a contact a lighter one, and both look alike."""
TESTED_CRESTS = 80
"""Highest crests whose tail is tested."""
MIN_CRESTS_RATIO = 5
"""Least ratio of all crests to these."""
MAX_CREST_MISFIT = 2.2
"""Largest `exponential_misfit` of the highest crests: 1 % of records with a law exceed it."""
MAX_CLIPPED_SHAPE = 2.5
"""Largest shape of a record that is clipped. A contact that opens, with a lighter tail than a
Gaussian one, has its largest values from impacts that its crests do not show."""


class ExtremeModel(IntEnum):
    """Method of extremes, if it is one of `LAWS`; else the reason why there are none."""

    GAUSSIAN = 0
    CLIPPED_GAUSSIAN = 1
    GUMBEL = 2
    REGULAR = 3
    CONSTANT = 4
    CLIPPED = 5
    TOO_SHORT = 6
    RARE = 7
    MEAN_CHANGES = 8
    STD_CHANGES = 9
    WAVES_GROW = 10
    OPERATION = 11
    ALONE = 12
    NOT_FINITE = 13
    HALVES = 14
    BOUNDED = 15
    TRANSIENT = 16
    IMPACTS = 17
    CURVED = 18


LAWS = (
    ExtremeModel.GAUSSIAN,
    ExtremeModel.CLIPPED_GAUSSIAN,
    ExtremeModel.GUMBEL,
    ExtremeModel.IMPACTS,
)
CHANGES = (ExtremeModel.MEAN_CHANGES, ExtremeModel.STD_CHANGES)


class RecordExtremes(NamedTuple):
    """Most probable maximum with its confidence interval, and prediction interval of the largest
    value. NaN if the ``basis`` is a reason for none."""

    mpm: float
    mpm_lower: float
    mpm_upper: float
    predicted_lower: float
    predicted_upper: float
    basis: ExtremeModel

    def rescale(self, factor: float, offset: float = 0.0) -> RecordExtremes:
        """Extremes of offset + factor x; of its smallest value if the factor is negative."""
        order = [0, 1, 2, 3, 4] if factor > 0.0 else [0, 2, 1, 4, 3]
        return _extremes_from(offset + factor * np.array(self[:-1])[order], self.basis)

    def widen_lower_end(self) -> RecordExtremes:
        """Extremes whose confidence interval reaches `LOWER_END_FACTOR` times as far down."""
        return self._replace(mpm_lower=self.mpm + LOWER_END_FACTOR * (self.mpm_lower - self.mpm))


class _RecordProperties(NamedTuple):
    """Properties of a record: its length in ``memories``; whether it is ``slow``; the skewness of
    its slow part; the ``ratio`` of the exposure to its length; the probabilities of the ``ends`` of
    the prediction interval; whether the run has ``contacts``."""

    memories: float
    slow: bool
    skewness: float
    ratio: float
    contacts: bool
    ends: tuple[float, float] = gumbel.INTERVAL_ENDS

    def half_record(self) -> _RecordProperties:
        """Properties of half of the record, whose law must predict the largest value of the other
        half."""
        ends = (HALF_TEST_PROBABILITY, 1.0 - HALF_TEST_PROBABILITY)
        return self._replace(memories=0.5 * self.memories, ratio=1.0, ends=ends)

    def negative_record(self) -> _RecordProperties:
        """Properties of the record times -1."""
        return self._replace(skewness=-self.skewness)


def extremes(
    x: np.ndarray,
    step: float,
    exposure: float | None = None,
    slowest: float = 0.0,
    contacts: bool = False,
) -> tuple[RecordExtremes, RecordExtremes]:
    """Extremes of the smallest and of the largest value in an ``exposure`` [s]; default: the length
    of the record x (nt,) with time ``step`` [s]. The waves have no energy below ``slowest``
    [rad/s]. A run with ``contacts`` may lean on them."""
    reason = refusal_reason(x)
    if reason is not None:
        return undefined_extremes(reason), undefined_extremes(reason)
    middle, size = float(np.median(x)), float(np.ptp(x))
    z = (x - middle) / size
    long = series.independent_samples(z)
    changing = series.changes_of_moments(z, long)
    if any(changing):
        reason = ExtremeModel.MEAN_CHANGES if changing[0] else ExtremeModel.STD_CHANGES
        return undefined_extremes(reason), undefined_extremes(reason)
    if series.has_initial_transient(z, long):
        return undefined_extremes(ExtremeModel.TRANSIENT), undefined_extremes(
            ExtremeModel.TRANSIENT
        )
    ratio = 1.0 if exposure is None else exposure / (step * x.size)
    share, few = series.low_frequency_share(z, step, slowest)
    slow = share > SLOW_FRACTION and few < MIN_MEMORIES
    third, fourth = (
        series.skewness_and_kurtosis(series.slow_part(z, step, slowest))
        if slow
        else (np.nan, np.nan)
    )
    record = _RecordProperties(long, slow, third, ratio, contacts)
    if fourth < MIN_SLOW_KURTOSIS and not _is_regular_series(z):
        return undefined_extremes(ExtremeModel.BOUNDED), undefined_extremes(ExtremeModel.BOUNDED)
    least = _extremes_of_halves(-z, record.negative_record()).rescale(-1.0).rescale(size, middle)
    if _is_magnitude(x):
        return least, _extremes_of_squares(x, record)
    return least, _extremes_of_halves(z, record).rescale(size, middle)


def _is_magnitude(x: np.ndarray) -> bool:
    """Whether a record is a magnitude (a speed, the size of a motion): it comes close to zero, does
    not stay there, and scatters like one without a mean direction."""
    near = 0.0 <= x.min() < ZERO_FRACTION * np.ptp(x) and not _stays_at(x, x.min())
    least, most = MAGNITUDE_STD_RANGE
    return bool(near and least * x.mean() < x.std() < most * x.mean())


def _extremes_of_squares(x: np.ndarray, record: _RecordProperties) -> RecordExtremes:
    """Extremes of a magnitude. Its square is close to Gumbel's law, as the energy of a Gaussian
    motion is; so intervals are computed for the square."""
    middle, size = float(np.median(x**2)), float(np.ptp(x**2))
    extreme = _extremes_of_halves((x**2 - middle) / size, record).rescale(size, middle)
    return _extremes_from(np.sqrt(extreme[:-1]), extreme.basis)


def undefined_extremes(basis: ExtremeModel) -> RecordExtremes:
    """No extremes, with the reason."""
    return _extremes_from([np.nan] * 5, basis)


def refusal_reason(x: np.ndarray) -> ExtremeModel | None:
    """Reason why a record x (nt,) has no extremes without any fit."""
    if not np.isfinite(x).all():
        return ExtremeModel.NOT_FINITE
    if not np.ptp(x) > RECORD_ROUNDING_FRACTION * np.abs(x).max():
        return ExtremeModel.CONSTANT
    return ExtremeModel.TOO_SHORT if series.upcrossings(x - x.mean()).size <= MIN_WAVES else None


def _extremes_of_halves(x: np.ndarray, record: _RecordProperties) -> RecordExtremes:
    """Extremes by a law that also holds from one half of the record to the other."""
    extreme = _by_law(x, record)
    if extreme.basis in LAWS and not _holds_between_halves(x, record):
        return undefined_extremes(ExtremeModel.HALVES)
    return extreme


def _holds_between_halves(x: np.ndarray, record: _RecordProperties) -> bool:
    """Whether the law of each half of a record (nt,) allows the largest value of the other half. A
    half without a law of its own is not tested."""
    middle = x.size // 2
    for fitted, other in ((x[:middle], x[middle:]), (x[middle:], x[:middle])):
        law = _by_law(fitted, record.half_record())
        if law.basis not in LAWS:
            continue
        if not law.predicted_lower <= other.max() <= law.predicted_upper:
            return False
    return True


def _by_law(x: np.ndarray, record: _RecordProperties) -> RecordExtremes:
    if _is_regular_series(x):
        return _extremes_from([x.max()] * 5, ExtremeModel.REGULAR)
    if _stays_at(x, x.max()):
        return undefined_extremes(ExtremeModel.CLIPPED)
    windows = min(
        int(record.memories / MEMORIES_PER_WINDOW),
        x.size // (2 * gumbel.PARTS_PER_WINDOW),
        MAX_WINDOWS,
    )
    if windows < MIN_WINDOWS:
        return undefined_extremes(ExtremeModel.TOO_SHORT)
    count = _window_count(x, windows, record)
    clipped = _stays_at(x, x.min())
    if clipped and gumbel.sliding_maxima(x, windows).min() == x.min():
        windows //= 2
        if windows < MIN_WINDOWS or gumbel.sliding_maxima(x, windows).min() == x.min():
            return undefined_extremes(ExtremeModel.RARE)
    if not np.ptp(gumbel.sliding_maxima(x, count)) > 0.0:
        return undefined_extremes(ExtremeModel.CLIPPED)
    fit = None if record.slow else gaussian.fit_gaussian(x, record.memories, windows)
    doubted = fit is None or fit.is_doubtful() or fit.is_unlikely(x.max())
    hits = None if record.slow or clipped else gaussian.find_impacts(x)
    if hits is not None and (hits.has_highest_crests() or not doubted):
        return _extremes_of_impacts(hits, record)
    if fit is None or doubted:
        return _extremes_by_windows(x, count, record)
    return _extremes_by_law(
        fit, record, 1.0, ExtremeModel.CLIPPED_GAUSSIAN if clipped else ExtremeModel.GAUSSIAN
    )


def _stays_at(x: np.ndarray, value: float) -> bool:
    """Whether a record stays at a value for some time; it reaches its largest value at least
    once."""
    return int(np.count_nonzero(x == value)) > max(CLIPPED_FRACTION * x.size, 1)


def _window_count(x: np.ndarray, windows: int, record: _RecordProperties) -> int:
    """Number of windows for Gumbel's law. Waves come in groups, which matter less at higher levels,
    so short windows contain too few large values."""
    waves = series.upcrossings(x - x.mean()).size
    most = (
        windows if record.slow else min(windows, max(waves // WAVES_PER_WINDOW, SUFFICIENT_WINDOWS))
    )
    return max(count for count in GUMBEL_WINDOWS if count <= most)


def _extremes_by_windows(x: np.ndarray, count: int, record: _RecordProperties) -> RecordExtremes:
    """Extremes by Gumbel's law of so many windows: of x itself if it is slow, else of (x -
    origin)^shape, whose tail is exponential."""
    if record.slow:
        return _extremes_of_slow_part(x, count, record)
    tail = _upper_tail(x, series.fit_upper_tail)
    if tail.shape > TAIL_SHAPE_RANGE[1]:
        return undefined_extremes(ExtremeModel.CLIPPED)
    if np.isnan(tail.shape):
        tail = tail._replace(shape=1.0)
    elif tail.exceedances(x.max()) < MIN_TAIL_EXCEEDANCES:
        return undefined_extremes(ExtremeModel.ALONE)
    extreme = _extremes_by_tail(x, tail, count, record)
    bounded = tail.shape > MAX_CLIPPED_SHAPE and _stays_at(x, x.min())
    if extreme.basis == ExtremeModel.GUMBEL and (bounded or _is_curved(x, tail)):
        return undefined_extremes(ExtremeModel.CURVED)
    return extreme


def _is_curved(x: np.ndarray, tail: series.Tail) -> bool:
    """Whether the highest crests of a record, in the power that makes its tail exponential, are not
    exponential: a force that ends near a weight, and now and then jumps beyond it."""
    z = x - tail.origin
    crests = np.sort(series.peaks(np.sign(z) * np.abs(z) ** max(tail.shape, TAIL_SHAPE_RANGE[0])))
    if crests.size < TESTED_CRESTS * MIN_CRESTS_RATIO:
        return False
    return (
        series.exponential_misfit(crests[-TESTED_CRESTS:] - crests[-TESTED_CRESTS - 1])
        > MAX_CREST_MISFIT
    )


def _extremes_of_slow_part(x: np.ndarray, count: int, record: _RecordProperties) -> RecordExtremes:
    """Extremes by Gumbel's law of windows of a slow record. A record that is skewed towards its
    largest values is fitted as it is, because quadratic wave loads have an exponential tail. For
    other records, and for clipped ones, whose skewness says nothing, the shape may have any value
    between one (exponential) and the shape at the often crossed levels. If skewness and levels
    disagree, intervals span both."""
    exponential = partial(_extremes_by_shape, x, float(x.mean()), 1.0, 0.0, count, record)
    tail = _upper_tail(x, series.fit_tail)
    leans = record.skewness > 0.0 and not _stays_at(x, x.min())
    if np.isnan(tail.shape) or (leans and tail.shape < GAUSSIAN_SHAPE):
        return exponential().widen_lower_end() if record.contacts else exponential()
    lightest = float(np.clip(tail.shape, *SLOW_SHAPE_RANGE))
    error = (lightest - 1.0) / np.sqrt(12.0)  # standard deviation of a uniform distribution
    between = _extremes_by_shape(x, tail.origin, 0.5 * (1.0 + lightest), error, count, record)
    return _span_both(between, exponential()) if leans else between


def _span_both(first: RecordExtremes, second: RecordExtremes) -> RecordExtremes:
    """Extremes with intervals that span both, around the mean of both."""
    if ExtremeModel.ALONE in (first.basis, second.basis):
        return undefined_extremes(ExtremeModel.ALONE)
    values = np.array([first[:-1], second[:-1]])
    mpm = values[:, 0].mean()
    lower, least = values[:, [1, 3]].min(axis=0)
    upper, most = values[:, [2, 4]].max(axis=0)
    return _extremes_from([mpm, lower, upper, least, most], ExtremeModel.GUMBEL)


def _extremes_by_tail(
    x: np.ndarray, tail: series.Tail, count: int, record: _RecordProperties
) -> RecordExtremes:
    """Extremes by Gumbel's law of windows of (x - origin)^shape, with the shape of the tail."""
    shape = max(tail.shape, TAIL_SHAPE_RANGE[0])
    return _extremes_by_shape(
        x, tail.origin, shape, shape * SHAPE_SCATTER / np.sqrt(tail.crossings), count, record
    )


def _extremes_by_shape(
    x: np.ndarray, origin: float, shape: float, error: float, count: int, record: _RecordProperties
) -> RecordExtremes:
    """Extremes by Gumbel's law of windows of (x - origin)^shape. The ``error`` of the shape, a
    standard deviation, widens the intervals."""
    z = x - origin
    extreme = _gumbel_of_power(z, shape, count, record)
    if extreme is None:
        return undefined_extremes(ExtremeModel.ALONE)
    other = _gumbel_of_power(z, shape + error, count, record) if error > 0.0 else None
    if other is not None:
        off = NORMAL_QUANTILE * (other[0] - extreme[0])
        apart = extreme - extreme[0]
        extreme = extreme[0] + np.sign(apart) * np.hypot(apart, off)
    return _extremes_from(origin + extreme, ExtremeModel.GUMBEL)


def _extremes_of_impacts(hits: gaussian.ImpactPeaks, record: _RecordProperties) -> RecordExtremes:
    """Extremes by the law of impacts alone: the waves between them are far below the largest
    value."""
    law = gaussian.fit_impacts(hits)
    return (
        undefined_extremes(ExtremeModel.ALONE)
        if law is None
        else _extremes_by_law(law, record, 1.0, ExtremeModel.IMPACTS)
    )


def _gumbel_of_power(
    z: np.ndarray, shape: float, count: int, record: _RecordProperties
) -> np.ndarray | None:
    """Values (5,) by Gumbel's law of z^shape, with z from the origin of the tail; None if the
    largest value does not fit the law."""
    law = gumbel.fit_record(np.sign(z) * np.abs(z) ** shape, count, record.memories)
    if law.exceedances(z.max() ** shape, count) < MIN_EXCEEDANCES:
        return None
    values = np.array(_extremes_by_law(law, record, count, ExtremeModel.GUMBEL)[:-1])
    return np.asarray(np.sign(values) * np.abs(values) ** (1.0 / shape))


def _upper_tail(x: np.ndarray, fit: Callable[[np.ndarray, float], series.Tail]) -> series.Tail:
    """Upper tail of a record x (nt,) about its mean. If it appears nearly cut off from there, the
    origin is the median of the values above the mean. Friction in slip is an example: it is equally
    large both ways, and seldom close to its mean."""
    tail = fit(x, float(x.mean()))
    if tail.shape > TAIL_SHAPE_RANGE[1]:
        return fit(x, float(np.median(x[x > x.mean()])))
    return tail


def _is_regular_series(x: np.ndarray) -> bool:
    """Whether the largest values and the periods of all waves are equal."""
    crossings = series.upcrossings(x - x.mean())
    periods, first = np.diff(crossings), np.ceil(crossings).astype(int)
    maxima = np.maximum.reduceat(x, first)[:-1]
    alike = np.ptp(maxima) <= EQUAL_MAXIMA_FRACTION * np.ptp(x)
    return bool(alike and np.ptp(periods) <= EQUAL_PERIODS_FRACTION * periods.mean())


def _extremes_by_law(
    law: gaussian.GaussianFit | gumbel.Gumbel | gaussian.Impacts,
    record: _RecordProperties,
    count: float,
    basis: ExtremeModel,
) -> RecordExtremes:
    """Extremes by a law for the largest value in one of ``count`` windows of a record."""
    ratio = record.ratio * count
    predicted = law.prediction_interval(ratio, record.ends)
    return _extremes_from(
        [law.expected_maximum(ratio), *law.confidence_interval(ratio), *predicted], basis
    )


def _extremes_from(values: Sequence[float] | np.ndarray, basis: ExtremeModel) -> RecordExtremes:
    mpm, *ends = map(float, values)
    low, high, least, most = ends
    return RecordExtremes(mpm, low, high, least, most, basis)
