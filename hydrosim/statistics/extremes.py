"""The largest value of a record: the most probable one, and between which values it will lie.

The most probable maximum of a time is the value that is exceeded once on average in it, below which
the largest is with the probability exp(-1). A record is taken for Gaussian, clipped where it often
stays at its smallest value (a contact that opens), unless

* its third or fourth moment says otherwise and matters for the largest value,
* there are impacts, which have a law of their own (`hydrosim.statistics.impacts`), or
* it is slow: more than `SLOW` of its variance is below the frequencies of the waves, and that part
  has too few cycles to show its moments. Slow drift is quadratic in the waves, its tail nearly
  exponential (Naess 1986, Applied Ocean Research 8).

Then extremes are Gumbel's over windows of the record, the fewer the longer it remembers: over
windows of that power of it which makes the tail exponential, as its upcrossings of levels say, the
upper ones where they differ. Levels of a slow record do not reach its tail: it is as it is where it
leans to its larger values, as slow drift does; else the power is between one and what levels say
(what contacts move slowly has nearly Gaussian tails). Of a magnitude, which comes down to zero and
is never below, that is taken of the square.

A law is believed only if, fitted to one half of the record, it lets the largest value of the other
half happen, both ways. There is none of a slow part that goes to and fro between bounds, or where
mean or variance change (`hydrosim.statistics.stationarity`).
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
from hydrosim.statistics.peaks import Tail, fit_tail, fit_upper_tail
from hydrosim.statistics.series import below, memories, moments, slow_part, upcrossings
from hydrosim.statistics.stationarity import begins_larger, changes

MEMORIES = 4  # in a window, at least
LEAST, MOST = 8, 50  # windows
GUMBEL = (8, 10, 13, 17, 22, 28, 34)  # windows: shorter ones hold too few waves for Gumbel's law
WAVES, ENOUGH = 70, 13  # waves in a window, at least, if there are so many windows
SLOW, FEW = 0.05, 250.0  # of the variance; memories of that part: more show their moments
CLIPPED = 0.005  # of the time: what is at the smallest value for longer is clipped there
ALIKE = 1e-3  # of the range: maxima that differ by less are one, as those of a regular wave
PERIODIC = 0.05  # of the mean period: the same of periods
UNLIKELY = 1e-4  # times that a largest value is exceeded on average: less, and it is of no law
FEWEST = 20  # waves
SHAPES = (0.5, 4.0)  # of a tail: lighter ones are nearly cut off
GAUSSIAN = 2.0  # shape of a tail: often crossed levels of slow drift have less
LIGHTEST = (2.0, 4.0)  # shape that the tail may have of a slow record that is no slow drift
OFF = 1.3  # times the shape over the root of the number of waves: the scatter of shapes
NORMAL = 1.645  # 5 % of a normal distribution are beyond
NEAR = 0.02  # of the range: a magnitude comes so near to zero
SPREAD = 0.48, 0.9  # of the mean: std of a magnitude, 0.52 of two Gaussian components, 0.76 of one
RARELY = 0.0025  # probability of a largest value of one half by the law of the other, on each side
UNEXPECTED = 1e-3  # times that the largest value is expected by the tail of the many
BOUNDED = 1.9  # kurtosis of a slow part: 1.5 of a sine, 1.8 of an even distribution, 3 of a normal
ROUNDING = 1e-12  # of the largest value


class Basis(IntEnum):
    """What extremes are by, if it is one of `LAWS`; else why there are none."""

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


LAWS = (Basis.GAUSSIAN, Basis.CLIPPED_GAUSSIAN, Basis.GUMBEL, Basis.IMPACTS)
CHANGES = (Basis.MEAN_CHANGES, Basis.STD_CHANGES)


class Extremes(NamedTuple):
    """Most probable maximum with its confidence interval; prediction interval of the largest; NaN
    where the ``basis`` says that there are none."""

    mpm: float
    mpm_lower: float
    mpm_upper: float
    predicted_lower: float
    predicted_upper: float
    basis: Basis

    def scaled(self, factor: float, offset: float = 0.0) -> Extremes:
        """Of offset + factor x: of its smallest value, if the factor is negative."""
        order = [0, 1, 2, 3, 4] if factor > 0.0 else [0, 2, 1, 4, 3]
        return _of(offset + factor * np.array(self[:-1])[order], self.basis)


class _Record(NamedTuple):
    """What is known of a record: how many ``memories`` it is long, whether it is ``slow``, and the
    skewness of its slow part; an exposure of ``ratio`` times its length; the probabilities of the
    ``ends`` of the prediction interval."""

    memories: float
    slow: bool
    skewness: float
    ratio: float
    ends: tuple[float, float] = ENDS

    def half(self) -> _Record:
        """Half of the record, whose law is to predict the largest value of the other half."""
        ends = (RARELY, 1.0 - RARELY)
        return self._replace(memories=0.5 * self.memories, ratio=1.0, ends=ends)

    def reversed(self) -> _Record:
        """Of the record times -1."""
        return self._replace(skewness=-self.skewness)


def extremes(
    x: np.ndarray, step: float, exposure: float | None = None, slowest: float = 0.0
) -> tuple[Extremes, Extremes]:
    """Of the smallest and of the largest value in an ``exposure`` [s], by default the length of the
    record x (nt,) in ``step`` [s]; the waves have no energy below ``slowest`` [rad/s]."""
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
    record = _Record(long, slow, third, ratio)
    if fourth < BOUNDED and not _regular(z):
        return none(Basis.BOUNDED), none(Basis.BOUNDED)
    least = _of_largest(-z, record.reversed()).scaled(-1.0).scaled(size, middle)
    if _is_magnitude(x):
        return least, _of_squares(x, record)
    return least, _of_largest(z, record).scaled(size, middle)


def _is_magnitude(x: np.ndarray) -> bool:
    """True of a record that comes down to zero, does not stay there, and scatters as one without a
    mean direction: a speed, the size of a motion."""
    near = 0.0 <= x.min() < NEAR * np.ptp(x) and not _stays(x, x.min())
    least, most = SPREAD
    return bool(near and least * x.mean() < x.std() < most * x.mean())


def _of_squares(x: np.ndarray, record: _Record) -> Extremes:
    """Of the largest value of a magnitude: its square is near to Gumbel's law, as the energy of a
    Gaussian motion is, and so are its intervals."""
    middle, size = float(np.median(x**2)), float(np.ptp(x**2))
    found = _of_largest((x**2 - middle) / size, record).scaled(size, middle)
    return _of(np.sqrt(found[:-1]), found.basis)


def none(basis: Basis) -> Extremes:
    """No extremes, and why."""
    return _of([np.nan] * 5, basis)


def trivial(x: np.ndarray) -> Basis | None:
    """Why a record x (nt,) has no extremes that need be looked for."""
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
    """Whether the law of each half of a record (nt,) lets the largest value of the other happen. A
    half that has no law by itself says nothing."""
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
    """Whether a record is at a value for a while: at its largest every record is once."""
    return int(np.count_nonzero(x == value)) > max(CLIPPED * x.size, 1)


def _count(x: np.ndarray, windows: int, record: _Record) -> int:
    """Windows of Gumbel's law, of so many at most: those of waves come in groups, which count for
    less the higher the level is, so that short windows see large values too seldom."""
    waves = upcrossings(x - x.mean()).size
    most = windows if record.slow else min(windows, max(waves // WAVES, ENOUGH))
    return max(count for count in GUMBEL if count <= most)


def _by_windows(x: np.ndarray, count: int, record: _Record) -> Extremes:
    """By Gumbel's law of so many windows: of x itself if it is slow, else of (x - origin)^shape,
    whose tail is exponential."""
    if record.slow:
        return _by_slow_part(x, count, record)
    tail = _tail(x, fit_upper_tail)
    if tail.shape > SHAPES[1]:
        return none(Basis.CLIPPED)
    if np.isnan(tail.shape):
        tail = tail._replace(shape=1.0)
    elif tail.exceedances(x.max()) < UNEXPECTED:
        return none(Basis.ALONE)
    return _by_tail(x, tail, count, record)


def _by_slow_part(x: np.ndarray, count: int, record: _Record) -> Extremes:
    """By Gumbel's law of windows of a slow record: of x itself where it leans to its larger values,
    as what is quadratic in the waves does. Of what leans the other way, and of what is clipped,
    where that says nothing, the tail may have any shape from exponential to that of the levels
    that are often crossed. Where leaning and levels do not agree, intervals span both."""
    exponential = partial(_by_shape, x, float(x.mean()), 1.0, 0.0, count, record)
    tail = _tail(x, fit_tail)
    leans = record.skewness > 0.0 and not _stays(x, x.min())
    if np.isnan(tail.shape) or (leans and tail.shape < GAUSSIAN):
        return exponential()
    lightest = float(np.clip(tail.shape, *LIGHTEST))
    error = (lightest - 1.0) / np.sqrt(12.0)  # of an even distribution
    between = _by_shape(x, tail.origin, 0.5 * (1.0 + lightest), error, count, record)
    return _spanning(between, exponential()) if leans else between


def _spanning(first: Extremes, second: Extremes) -> Extremes:
    """Intervals that span those of both, about the middle of both."""
    if Basis.ALONE in (first.basis, second.basis):
        return none(Basis.ALONE)
    values = np.array([first[:-1], second[:-1]])
    mpm = values[:, 0].mean()
    lower, least = values[:, [1, 3]].min(axis=0)
    upper, most = values[:, [2, 4]].max(axis=0)
    return _of([mpm, lower, upper, least, most], Basis.GUMBEL)


def _by_tail(x: np.ndarray, tail: Tail, count: int, record: _Record) -> Extremes:
    """By Gumbel's law of windows of (x - origin)^shape."""
    shape = max(tail.shape, SHAPES[0])
    return _by_shape(x, tail.origin, shape, shape * OFF / np.sqrt(tail.crossings), count, record)


def _by_shape(
    x: np.ndarray, origin: float, shape: float, error: float, count: int, record: _Record
) -> Extremes:
    """By Gumbel's law of windows of (x - origin)^shape. The ``error`` of the shape, a standard
    deviation, widens intervals."""
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
    """By the law of impacts alone: the waves between them are far below the largest."""
    law = fit_impacts(hits)
    return none(Basis.ALONE) if law is None else _by(law, record, 1.0, Basis.IMPACTS)


def _of_power(z: np.ndarray, shape: float, count: int, record: _Record) -> np.ndarray | None:
    """Figures (5,) by Gumbel's law of z^shape, z being from the origin of the tail; None where the
    largest value is not of it."""
    law = fit_record(np.sign(z) * np.abs(z) ** shape, count, record.memories)
    if law.exceedances(z.max() ** shape, count) < UNLIKELY:
        return None
    values = np.array(_by(law, record, count, Basis.GUMBEL)[:-1])
    return np.asarray(np.sign(values) * np.abs(values) ** (1.0 / shape))


def _tail(x: np.ndarray, fit: Callable[[np.ndarray, float], Tail]) -> Tail:
    """The upper tail of a record x (nt,): about its mean, or, if it is nearly cut off as seen from
    there, about the middle of what is above: friction in slip is as large one way as the other, and
    seldom near its mean."""
    tail = fit(x, float(x.mean()))
    if tail.shape > SHAPES[1]:
        return fit(x, float(np.median(x[x > x.mean()])))
    return tail


def _regular(x: np.ndarray) -> bool:
    """True if the largest values and the periods of all waves are alike."""
    crossings = upcrossings(x - x.mean())
    periods, first = np.diff(crossings), np.ceil(crossings).astype(int)
    maxima = np.maximum.reduceat(x, first)[:-1]
    alike = np.ptp(maxima) <= ALIKE * np.ptp(x)
    return bool(alike and np.ptp(periods) <= PERIODIC * periods.mean())


def _by(law: Gaussian | Gumbel | Impacts, record: _Record, count: float, basis: Basis) -> Extremes:
    """Extremes by a law of one of ``count`` windows of a record."""
    ratio = record.ratio * count
    predicted = law.prediction(ratio, record.ends)
    return _of([law.expected(ratio), *law.confidence(ratio), *predicted], basis)


def _of(values: Sequence[float] | np.ndarray, basis: Basis) -> Extremes:
    mpm, *ends = map(float, values)
    low, high, least, most = ends
    return Extremes(mpm, low, high, least, most, basis)
