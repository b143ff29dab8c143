"""Largest value of a record: the most probable maximum, and intervals.

The most probable maximum of a duration is the value that is exceeded once on average. The largest
value is below it with probability exp(-1). A record counts as Gaussian, clipped if it often stays
at its smallest value (a contact that opens), unless

* its third or fourth moment is not Gaussian and matters for the largest value,
* it has impacts, which have a law of their own (`hydrosim.statistics.impacts`), or
* it is slow: more than `SLOW` of its variance is below the frequencies of the waves, and that part
  has too few cycles to show its moments. Slow drift is quadratic in the waves, and its tail is
  nearly exponential (Naess 1986, Applied Ocean Research 8).

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
variance change (`hydrosim.statistics.stationarity`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum
from functools import partial
from typing import NamedTuple

import numpy as np

from hydrosim.statistics.gaussian import Gaussian, fit_gaussian
from hydrosim.statistics.gumbel import ENDS, SLIDE, Gumbel, fit_record, sliding
from hydrosim.statistics.impacts import Hits, Impacts, find_impacts, fit_impacts
from hydrosim.statistics.peaks import (
    Tail,
    exponential_misfit,
    fit_tail,
    fit_upper_tail,
    peaks,
)
from hydrosim.statistics.series import below, memories, moments, slow_part, upcrossings
from hydrosim.statistics.stationarity import begins_larger, changes

MEMORIES = 4  # in a window, at least
LEAST, MOST = 8, 50  # windows
GUMBEL = (8, 10, 13, 17, 22, 28, 34)  # windows: shorter windows hold too few waves for Gumbel's law
WAVES, ENOUGH = 70, 13  # waves in a window, at least, unless that leaves fewer windows than this
SLOW, FEW = 0.05, 250.0  # of the variance; memories: a longer slow part shows its moments
CLIPPED = 0.005  # of the time: a record that is longer at its smallest value is clipped there
ALIKE = 1e-3  # of the range: maxima that differ by less are equal, as in a regular wave
PERIODIC = 0.05  # of the mean period: periods that differ by less are equal
UNLIKELY = 1e-4  # mean number of exceedances of the largest value, below which the law is rejected
FEWEST = 20  # waves
SHAPES = (0.5, 4.0)  # of a tail: larger shapes are nearly cut off
GAUSSIAN = 2.0  # shape of a tail: slow drift has smaller shapes at often crossed levels
LIGHTEST = (2.0, 4.0)  # bounds of the shape of a slow record that is not slow drift
OFF = 1.3  # scatter of shapes: this times the shape over the root of the number of waves
NORMAL = 1.645  # quantile of a normal distribution that 5 % exceed
NEAR = 0.02  # of the range: a magnitude comes this close to zero
# of the mean: standard deviation of a magnitude, 0.52 for two Gaussian components, 0.76 for one
SPREAD = (0.48, 0.9)
RARELY = 0.0025  # probability of the largest value of one half by the law of the other, each side
UNEXPECTED = 1e-3  # mean number of exceedances of the largest value by the tail of the other waves
BOUNDED = 1.9  # kurtosis of a slow part: 1.5 for a sine, 1.8 uniform, 3 normal
ROUNDING = 1e-12  # of the largest value
LOWER_END = 1.4
"""Reach of the lower end of confidence in a slow record that leans, in a run with contacts. Slow
drift has an exponential tail, what leans on a contact a lighter one, and both look alike."""
CRESTS = 80
"""Highest crests whose tail is tested."""
SHARE_OF_CRESTS = 5
"""Least ratio of all crests to these."""
MISFIT = 2.2
"""Largest `exponential_misfit` of the highest crests: 1 % of records with a law exceed it."""
LIGHTEST_CLIPPED = 2.5
"""Largest shape of a record that is clipped. A contact that opens, with a lighter tail than a
Gaussian one, has its largest values from impacts that its crests do not show."""


class Basis(IntEnum):
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


LAWS = (Basis.GAUSSIAN, Basis.CLIPPED_GAUSSIAN, Basis.GUMBEL, Basis.IMPACTS)
CHANGES = (Basis.MEAN_CHANGES, Basis.STD_CHANGES)


class Extremes(NamedTuple):
    """Most probable maximum with its confidence interval, and prediction interval of the largest
    value. NaN if the ``basis`` is a reason for none."""

    mpm: float
    mpm_lower: float
    mpm_upper: float
    predicted_lower: float
    predicted_upper: float
    basis: Basis

    def scaled(self, factor: float, offset: float = 0.0) -> Extremes:
        """Extremes of offset + factor x; of its smallest value if the factor is negative."""
        order = [0, 1, 2, 3, 4] if factor > 0.0 else [0, 2, 1, 4, 3]
        return _of(offset + factor * np.array(self[:-1])[order], self.basis)

    def doubting_low(self) -> Extremes:
        """Extremes whose confidence interval reaches `LOWER_END` times as far down."""
        return self._replace(mpm_lower=self.mpm + LOWER_END * (self.mpm_lower - self.mpm))


class _Record(NamedTuple):
    """Properties of a record: its length in ``memories``; whether it is ``slow``; the skewness of
    its slow part; the ``ratio`` of the exposure to its length; the probabilities of the ``ends`` of
    the prediction interval; whether the run has ``contacts``."""

    memories: float
    slow: bool
    skewness: float
    ratio: float
    contacts: bool
    ends: tuple[float, float] = ENDS

    def half(self) -> _Record:
        """Properties of half of the record, whose law must predict the largest value of the other
        half."""
        ends = (RARELY, 1.0 - RARELY)
        return self._replace(memories=0.5 * self.memories, ratio=1.0, ends=ends)

    def reversed(self) -> _Record:
        """Properties of the record times -1."""
        return self._replace(skewness=-self.skewness)


def extremes(
    x: np.ndarray,
    step: float,
    exposure: float | None = None,
    slowest: float = 0.0,
    contacts: bool = False,
) -> tuple[Extremes, Extremes]:
    """Extremes of the smallest and of the largest value in an ``exposure`` [s]; default: the length
    of the record x (nt,) with time ``step`` [s]. The waves have no energy below ``slowest``
    [rad/s]. A run with ``contacts`` may lean on them."""
    said = trivial(x)
    if said is not None:
        return none(said), none(said)
    middle, size = float(np.median(x)), float(np.ptp(x))
    z = (x - middle) / size
    long = memories(z)
    changing = changes(z, long)
    if any(changing):
        said = Basis.MEAN_CHANGES if changing[0] else Basis.STD_CHANGES
        return none(said), none(said)
    if begins_larger(z, long):
        return none(Basis.TRANSIENT), none(Basis.TRANSIENT)
    ratio = 1.0 if exposure is None else exposure / (step * x.size)
    share, few = below(z, step, slowest)
    slow = share > SLOW and few < FEW
    third, fourth = moments(slow_part(z, step, slowest)) if slow else (np.nan, np.nan)
    record = _Record(long, slow, third, ratio, contacts)
    if fourth < BOUNDED and not _regular(z):
        return none(Basis.BOUNDED), none(Basis.BOUNDED)
    least = _of_largest(-z, record.reversed()).scaled(-1.0).scaled(size, middle)
    if _is_magnitude(x):
        return least, _of_squares(x, record)
    return least, _of_largest(z, record).scaled(size, middle)


def _is_magnitude(x: np.ndarray) -> bool:
    """Whether a record is a magnitude (a speed, the size of a motion): it comes close to zero, does
    not stay there, and scatters like one without a mean direction."""
    near = 0.0 <= x.min() < NEAR * np.ptp(x) and not _stays(x, x.min())
    least, most = SPREAD
    return bool(near and least * x.mean() < x.std() < most * x.mean())


def _of_squares(x: np.ndarray, record: _Record) -> Extremes:
    """Extremes of a magnitude. Its square is close to Gumbel's law, as the energy of a Gaussian
    motion is; so intervals are computed for the square."""
    middle, size = float(np.median(x**2)), float(np.ptp(x**2))
    found = _of_largest((x**2 - middle) / size, record).scaled(size, middle)
    return _of(np.sqrt(found[:-1]), found.basis)


def none(basis: Basis) -> Extremes:
    """No extremes, with the reason."""
    return _of([np.nan] * 5, basis)


def trivial(x: np.ndarray) -> Basis | None:
    """Reason why a record x (nt,) has no extremes without any fit."""
    if not np.isfinite(x).all():
        return Basis.NOT_FINITE
    if not np.ptp(x) > ROUNDING * np.abs(x).max():
        return Basis.CONSTANT
    return Basis.TOO_SHORT if upcrossings(x - x.mean()).size <= FEWEST else None


def _of_largest(x: np.ndarray, record: _Record) -> Extremes:
    """Extremes by a law that also holds from one half of the record to the other."""
    found = _by_law(x, record)
    if found.basis in LAWS and not _holds_between_halves(x, record):
        return none(Basis.HALVES)
    return found


def _holds_between_halves(x: np.ndarray, record: _Record) -> bool:
    """Whether the law of each half of a record (nt,) allows the largest value of the other half. A
    half without a law of its own is not tested."""
    middle = x.size // 2
    for fitted, other in ((x[:middle], x[middle:]), (x[middle:], x[:middle])):
        law = _by_law(fitted, record.half())
        if law.basis not in LAWS:
            continue
        if not law.predicted_lower <= other.max() <= law.predicted_upper:
            return False
    return True


def _by_law(x: np.ndarray, record: _Record) -> Extremes:
    if _regular(x):
        return _of([x.max()] * 5, Basis.REGULAR)
    if _stays(x, x.max()):
        return none(Basis.CLIPPED)
    windows = min(int(record.memories / MEMORIES), x.size // (2 * SLIDE), MOST)
    if windows < LEAST:
        return none(Basis.TOO_SHORT)
    count = _count(x, windows, record)
    clipped = _stays(x, x.min())
    if clipped and sliding(x, windows).min() == x.min():
        windows //= 2
        if windows < LEAST or sliding(x, windows).min() == x.min():
            return none(Basis.RARE)
    if not np.ptp(sliding(x, count)) > 0.0:
        return none(Basis.CLIPPED)
    fit = None if record.slow else fit_gaussian(x, record.memories, windows)
    doubted = fit is None or fit.doubtful() or fit.unlikely(x.max())
    hits = None if record.slow or clipped else find_impacts(x)
    if hits is not None and (hits.lead() or not doubted):
        return _by_impacts(hits, record)
    if fit is None or doubted:
        return _by_windows(x, count, record)
    return _by(fit, record, 1.0, Basis.CLIPPED_GAUSSIAN if clipped else Basis.GAUSSIAN)


def _stays(x: np.ndarray, value: float) -> bool:
    """Whether a record stays at a value for some time; it reaches its largest value at least
    once."""
    return int(np.count_nonzero(x == value)) > max(CLIPPED * x.size, 1)


def _count(x: np.ndarray, windows: int, record: _Record) -> int:
    """Number of windows for Gumbel's law. Waves come in groups, which matter less at higher levels,
    so short windows contain too few large values."""
    waves = upcrossings(x - x.mean()).size
    most = windows if record.slow else min(windows, max(waves // WAVES, ENOUGH))
    return max(count for count in GUMBEL if count <= most)


def _by_windows(x: np.ndarray, count: int, record: _Record) -> Extremes:
    """Extremes by Gumbel's law of so many windows: of x itself if it is slow, else of (x -
    origin)^shape, whose tail is exponential."""
    if record.slow:
        return _by_slow_part(x, count, record)
    tail = _tail(x, fit_upper_tail)
    if tail.shape > SHAPES[1]:
        return none(Basis.CLIPPED)
    if np.isnan(tail.shape):
        tail = tail._replace(shape=1.0)
    elif tail.exceedances(x.max()) < UNEXPECTED:
        return none(Basis.ALONE)
    found = _by_tail(x, tail, count, record)
    bounded = tail.shape > LIGHTEST_CLIPPED and _stays(x, x.min())
    if found.basis == Basis.GUMBEL and (bounded or _is_curved(x, tail)):
        return none(Basis.CURVED)
    return found


def _is_curved(x: np.ndarray, tail: Tail) -> bool:
    """Whether the highest crests of a record, in the power that makes its tail exponential, are not
    exponential: a force that ends near a weight, and now and then jumps beyond it."""
    z = x - tail.origin
    crests = np.sort(peaks(np.sign(z) * np.abs(z) ** max(tail.shape, SHAPES[0])))
    if crests.size < CRESTS * SHARE_OF_CRESTS:
        return False
    return exponential_misfit(crests[-CRESTS:] - crests[-CRESTS - 1]) > MISFIT


def _by_slow_part(x: np.ndarray, count: int, record: _Record) -> Extremes:
    """Extremes by Gumbel's law of windows of a slow record. A record that is skewed towards its
    largest values is fitted as it is, because quadratic wave loads have an exponential tail. For
    other records, and for clipped ones, whose skewness says nothing, the shape may have any value
    between one (exponential) and the shape at the often crossed levels. If skewness and levels
    disagree, intervals span both."""
    exponential = partial(_by_shape, x, float(x.mean()), 1.0, 0.0, count, record)
    tail = _tail(x, fit_tail)
    leans = record.skewness > 0.0 and not _stays(x, x.min())
    if np.isnan(tail.shape) or (leans and tail.shape < GAUSSIAN):
        return exponential().doubting_low() if record.contacts else exponential()
    lightest = float(np.clip(tail.shape, *LIGHTEST))
    error = (lightest - 1.0) / np.sqrt(12.0)  # standard deviation of a uniform distribution
    between = _by_shape(x, tail.origin, 0.5 * (1.0 + lightest), error, count, record)
    return _spanning(between, exponential()) if leans else between


def _spanning(first: Extremes, second: Extremes) -> Extremes:
    """Extremes with intervals that span both, around the mean of both."""
    if Basis.ALONE in (first.basis, second.basis):
        return none(Basis.ALONE)
    values = np.array([first[:-1], second[:-1]])
    mpm = values[:, 0].mean()
    lower, least = values[:, [1, 3]].min(axis=0)
    upper, most = values[:, [2, 4]].max(axis=0)
    return _of([mpm, lower, upper, least, most], Basis.GUMBEL)


def _by_tail(x: np.ndarray, tail: Tail, count: int, record: _Record) -> Extremes:
    """Extremes by Gumbel's law of windows of (x - origin)^shape, with the shape of the tail."""
    shape = max(tail.shape, SHAPES[0])
    return _by_shape(x, tail.origin, shape, shape * OFF / np.sqrt(tail.crossings), count, record)


def _by_shape(
    x: np.ndarray, origin: float, shape: float, error: float, count: int, record: _Record
) -> Extremes:
    """Extremes by Gumbel's law of windows of (x - origin)^shape. The ``error`` of the shape, a
    standard deviation, widens the intervals."""
    z = x - origin
    found = _of_power(z, shape, count, record)
    if found is None:
        return none(Basis.ALONE)
    other = _of_power(z, shape + error, count, record) if error > 0.0 else None
    if other is not None:
        off = NORMAL * (other[0] - found[0])
        apart = found - found[0]
        found = found[0] + np.sign(apart) * np.hypot(apart, off)
    return _of(origin + found, Basis.GUMBEL)


def _by_impacts(hits: Hits, record: _Record) -> Extremes:
    """Extremes by the law of impacts alone: the waves between them are far below the largest
    value."""
    law = fit_impacts(hits)
    return none(Basis.ALONE) if law is None else _by(law, record, 1.0, Basis.IMPACTS)


def _of_power(z: np.ndarray, shape: float, count: int, record: _Record) -> np.ndarray | None:
    """Values (5,) by Gumbel's law of z^shape, with z from the origin of the tail; None if the
    largest value does not fit the law."""
    law = fit_record(np.sign(z) * np.abs(z) ** shape, count, record.memories)
    if law.exceedances(z.max() ** shape, count) < UNLIKELY:
        return None
    values = np.array(_by(law, record, count, Basis.GUMBEL)[:-1])
    return np.asarray(np.sign(values) * np.abs(values) ** (1.0 / shape))


def _tail(x: np.ndarray, fit: Callable[[np.ndarray, float], Tail]) -> Tail:
    """Upper tail of a record x (nt,) about its mean. If it appears nearly cut off from there, the
    origin is the median of the values above the mean. Friction in slip is an example: it is equally
    large both ways, and seldom close to its mean."""
    tail = fit(x, float(x.mean()))
    if tail.shape > SHAPES[1]:
        return fit(x, float(np.median(x[x > x.mean()])))
    return tail


def _regular(x: np.ndarray) -> bool:
    """Whether the largest values and the periods of all waves are equal."""
    crossings = upcrossings(x - x.mean())
    periods, first = np.diff(crossings), np.ceil(crossings).astype(int)
    maxima = np.maximum.reduceat(x, first)[:-1]
    alike = np.ptp(maxima) <= ALIKE * np.ptp(x)
    return bool(alike and np.ptp(periods) <= PERIODIC * periods.mean())


def _by(law: Gaussian | Gumbel | Impacts, record: _Record, count: float, basis: Basis) -> Extremes:
    """Extremes by a law for the largest value in one of ``count`` windows of a record."""
    ratio = record.ratio * count
    predicted = law.prediction(ratio, record.ends)
    return _of([law.expected(ratio), *law.confidence(ratio), *predicted], basis)


def _of(values: Sequence[float] | np.ndarray, basis: Basis) -> Extremes:
    mpm, *ends = map(float, values)
    low, high, least, most = ends
    return Extremes(mpm, low, high, least, most, basis)
