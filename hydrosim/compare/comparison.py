"""Comparison of a run and a recording, channel by channel: fits, figures, and causes in words.

Text on the difference between a recording and ours.

The recorded series is fitted as gain * ours(t - lag) + offset. First a wrong sign or unit is
recognised by the gain. Then gain, lag and offset are named, each if the fit is clearly worse
without it. If waves of the same spectrum do not correlate, the recording is another realisation. If
these waves are a small part of a series that correlates otherwise, the text says so for the waves
only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from math import inf, isnan, log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from hydrosim.compare.align import (
    ChannelPair,
    ChannelPlace,
    MappingFile,
    Overlap,
    TimeColumn,
    align,
    guess,
)
from hydrosim.files.recordings import Recording
from hydrosim.files.units import factor
from hydrosim.results.channels import match_channels, recorded_channels

if TYPE_CHECKING:
    import xarray as xr

# Two series over the same times: correlation, bands; gain, lag and offset between them.

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
    rho = np.abs(_lagged_correlations(a, r, count))
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
    gain, offset, rest = _fit_line(late, r)
    through_zero = float(late @ r / (late @ late)) if late.any() else 0.0
    without = (
        rms(r - np.copysign(1.0, gain) * late - np.mean(r - np.copysign(1.0, gain) * late)),
        _fit_line(now, r)[2],
        rms(r - through_zero * late),
    )
    effects = (float(np.sqrt(max(other**2 - rest**2, 0.0))) for other in without)
    return GainLagFit(gain, lag, offset, rest, correlation(late, r), *effects)


def _fit_line(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float]:
    """Gain, offset and rms of the remainder of the line y = gain x + offset."""
    dx = x - x.mean()
    spread = float(dx @ dx)
    gain = float(dx @ y) / spread if spread > 0.0 else 0.0
    offset = float(y.mean() - gain * x.mean())
    return gain, offset, rms(y - gain * x - offset)


def _is_within_record(time: np.ndarray, lag: float) -> np.ndarray:
    """Whether each time shifted by the lag lies within the record."""
    return (time - lag >= time[0]) & (time - lag <= time[-1])


def _lagged_correlations(a: np.ndarray, r: np.ndarray, count: int) -> np.ndarray:
    """Pearson's correlation of r(i) and a(i - k) where both exist, for k from -count to count (2
    count + 1,)."""
    a, r = a - a.mean(), r - r.mean()
    k = np.arange(-count, count + 1)
    both = a.size - np.abs(k)
    in_r, in_a = np.maximum(k, 0), np.maximum(-k, 0)
    r1, r2 = _window_sums(r, in_r, both), _window_sums(r**2, in_r, both)
    a1, a2 = _window_sums(a, in_a, both), _window_sums(a**2, in_a, both)
    product = scipy.signal.correlate(r, a, method="fft")[a.size - 1 - count : a.size + count]
    spread = (r2 - r1**2 / both) * (a2 - a1**2 / both)
    least = 1e-12 * float((r @ r) * (a @ a))
    size = np.sqrt(np.where(spread > least, spread, np.inf))
    return (product - r1 * a1 / both) / size


def _window_sums(x: np.ndarray, first: np.ndarray, count: np.ndarray) -> np.ndarray:
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
        _trend_over_series(pair.ours) - _trend_over_series(pair.recorded),
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


def _trend_over_series(values: np.ndarray) -> float:
    """Mean over the last tenth minus mean over the first tenth."""
    count = max(1, int(DRIFT_END_FRACTION * values.size))
    return float(values[-count:].mean() - values[:count].mean())


EQUAL_RMS_RATIO = 1e-3  # rms over std: smaller differences count as equal
MIN_NAMED_CORRELATION = 0.8  # correlation: below it no gain, lag or offset is named
MIN_WAVE_CORRELATION = 0.5  # correlation in the wave band: below it the waves are others
MAX_SAME_SPECTRUM_STD_RATIO = 1.5  # ratio of std in the wave band: above it the spectrum is another
MIN_WAVE_STD = 0.05  # of the std: smaller motion in the wave band counts as none
MIN_EFFECT_FRACTION = 0.3  # of the rms: an effect that is named
DOMINANT_FRACTION = 0.7  # of the mean square
UNIT_GAIN_TOLERANCE = 0.03  # relative distance of a gain from that of a unit
SERIES_ROUNDING_FRACTION = 1e-12  # of the largest value
CONFUSED_UNITS = {  # units that may be mistaken for ours
    "m": ("mm", "cm", "ft"),
    "m/s": ("mm/s", "cm/s", "km/h", "ft/s"),
    "rad": ("deg",),
    "rad/s": ("deg/s",),
    "N": ("kN", "MN", "tonne_force", "lbf"),
    "N m": ("kN*m", "MN*m", "tonne_force*m"),
    "J": ("kJ", "MJ"),
}
UNIT_WORDS = {"deg": "degrees", "rad": "radians", "tonne_force": "tonne-force"}


def diagnose(
    time: np.ndarray,
    pair: ChannelPair,
    differences: Figures,
    fitted: GainLagFit,
    edges: tuple[float, float],
    most: float,
) -> str:
    """Verdict on a pair, from its figures and its fit; lags up to ``most`` [s] are searched."""
    ours, recorded = pair.ours, pair.recorded
    largest = float(np.abs(np.concatenate([ours, recorded])).max())
    if largest == 0.0:
        return "both zero"
    if differences.peak <= 1.001 * pair.precision + SERIES_ROUNDING_FRACTION * largest:
        return f"equal to print precision ({pair.precision:.2g} {pair.unit})"
    if differences.std == 0.0 or std_above_rounding(ours) == 0.0:
        return _constant_text(pair, differences, std_above_rounding(ours))
    if differences.relative < EQUAL_RMS_RATIO:
        return f"equal within {100.0 * differences.relative:.2g} % of the std"
    other = _have_other_waves(time, pair, edges, most)
    if other and abs(fitted.correlation) < MIN_WAVE_CORRELATION:
        return "another realisation (same spectrum, no correlation): another seed?"
    if abs(fitted.correlation) < MIN_NAMED_CORRELATION:
        verdict = f"different (correlation {fitted.correlation:.2f}){_worst_band(differences)}"
    else:
        verdict = ", ".join(_describe_differences(time, pair, differences, fitted, most))
    return (
        f"{verdict}; its waves, {_share_text(differences)}, are another realisation"
        if other
        else verdict
    )


def _share_text(differences: Figures) -> str:
    """Fraction of the recorded standard deviation in the wave band."""
    return f"{100.0 * differences.band_recorded[1] / differences.std:.2g} % of the std"


def _constant_text(pair: ChannelPair, differences: Figures, ours: float) -> str:
    if differences.std == 0.0 and ours == 0.0:
        offset = float(pair.recorded.mean() - pair.ours.mean())
        return f"both constant, offset {_amount_text(offset, pair.unit)}"
    return "constant in the " + ("recording" if differences.std == 0.0 else "run")


def _have_other_waves(
    time: np.ndarray, pair: ChannelPair, edges: tuple[float, float], most: float
) -> bool:
    """Whether both have waves of the same spectrum that do not correlate at any lag."""
    a, r = (split_bands(time, x, edges)[1] for x in (pair.ours, pair.recorded))
    sizes = float(np.std(a)), float(np.std(r))
    if min(sizes) < MIN_WAVE_STD * min(np.std(pair.ours), np.std(pair.recorded)):
        return False
    if not 1.0 / MAX_SAME_SPECTRUM_STD_RATIO < sizes[0] / sizes[1] < MAX_SAME_SPECTRUM_STD_RATIO:
        return False
    even = np.linspace(time[0], time[-1], time.size)
    return abs(fit(even, a, r, most).correlation) < MIN_WAVE_CORRELATION


def _describe_differences(
    time: np.ndarray, pair: ChannelPair, differences: Figures, fitted: GainLagFit, most: float
) -> Iterator[str]:
    """Differences: sign, unit, gain, lag, offset, and the remainder."""
    sign = float(np.sign(fitted.gain))
    unit, size = _unit_taken(abs(fitted.gain), pair.unit)
    if sign < 0.0:
        yield "sign swapped"
    if unit:
        yield unit
    mended = sign * pair.recorded / size
    before = rms(mended - pair.ours)
    if before <= pair.precision / size:
        return
    if sign < 0.0 or unit:
        fitted = fit(time, pair.ours, mended, most)
    std = differences.std / size
    causes = list(_likely_causes(fitted, pair.unit, before, std))
    yield from causes
    if causes and fitted.rest > max(EQUAL_RMS_RATIO * std, MIN_EFFECT_FRACTION * before):
        yield f"{100.0 * fitted.rest / std:.3g} % of the std left"
    if not causes and before > EQUAL_RMS_RATIO * std:
        yield f"differs by {100.0 * before / std:.3g} % of the std{_worst_band(differences)}"


def _likely_causes(fitted: GainLagFit, unit: str, before: float, std: float) -> Iterator[str]:
    """Gain, lag and offset, if they matter.

    A gain of a series with a large mean is almost an offset. Each alone mends most of the
    difference, so that neither has an effect on it. Then effects are held against what the fit
    leaves, or against the ``std`` that counts as equal.
    """
    effects = (fitted.gain_effect, fitted.lag_effect, fitted.offset_effect)
    clear = MIN_EFFECT_FRACTION * before
    if max(effects) <= clear and fitted.rest < clear:
        clear = max(MIN_EFFECT_FRACTION * fitted.rest, EQUAL_RMS_RATIO * std)
    if fitted.gain_effect > clear:
        yield f"gain {fitted.gain:.4g}"
    if fitted.lag_effect > clear:
        yield f"{'late' if fitted.lag > 0.0 else 'early'} by {abs(fitted.lag):.3f} s"
    if fitted.offset_effect > clear:
        yield f"offset {_amount_text(fitted.offset, unit)}"


def _unit_taken(gain: float, ours: str) -> tuple[str, float]:
    """Mistaken unit as text, and its gain; "" and 1 if there is none."""
    for other in CONFUSED_UNITS.get(ours, ()):
        size = factor(other, ours)
        for text, expected in (
            (f"{_unit_word(other)} for {_unit_word(ours)}", 1.0 / size),
            (f"{_unit_word(ours)} for {_unit_word(other)}", size),
        ):
            if abs(log(gain / expected)) < UNIT_GAIN_TOLERANCE:
                return text, expected
    return "", 1.0


def _unit_word(unit: str) -> str:
    return UNIT_WORDS.get(unit, unit)


def _worst_band(differences: Figures) -> str:
    """Band of frequencies that holds most of the difference, if one does."""
    squares = np.square(differences.band_rms)
    squares[0] += differences.mean**2
    worst = int(np.argmax(squares))
    if squares[worst] < DOMINANT_FRACTION * squares.sum():
        return ""
    return f", mostly {('slow', 'in the wave band', 'fast')[worst]}"


def _amount_text(value: float, unit: str) -> str:
    """A value in its usual unit."""
    return f"{np.degrees(value):.3g} deg" if unit == "rad" else f"{value:.3g} {unit}"


MAX_LAG_FRACTION, MAX_LAG_S = 0.1, 60.0  # of the time, and s: largest lag of the search
MAX_SHIFT_FRACTION = 0.5  # of the time: the largest shift
MIN_SHIFT_CORRELATION = 0.9  # smallest correlation of channels from which a time shift is estimated


class ChannelResult(NamedTuple):
    """Results for a channel; ``verdict`` is a text, ``contact`` exists for fenders only."""

    pair: ChannelPair
    figures: Figures
    fit: GainLagFit
    contact: ContactComparison | None
    verdict: str

    @property
    def error(self) -> float:
        """Value that is compared with the tolerance: rms over std, or the rms for a constant
        channel."""
        return self.figures.rms if isnan(self.figures.relative) else self.figures.relative


@dataclass(frozen=True)
class Comparison:
    """Results by channel over their common ``overlap``. ``zero`` are channels that are zero in
    both. ``unused`` are columns without a channel. ``guessed`` is true without a mapping. ``shift``
    [s] was estimated and added to the recorded times; NaN if it could not be estimated."""

    results: Mapping[str, ChannelResult]
    overlap: Overlap
    edges: tuple[float, float]
    zero: Sequence[str]
    unused: Sequence[str]
    guessed: bool
    shift: float | None


def compare(
    run: xr.Dataset,
    recording: Recording,
    mapping: MappingFile | None = None,
    *,
    shift: bool = False,
    between: tuple[float, float] = (-inf, inf),
    edges: tuple[float, float] = BAND_EDGES_RAD_S,
    only: Sequence[str] = ("*",),
) -> Comparison:
    """Compare a run with a recording, by a ``mapping`` or by guesses from names and units.

    ``shift`` first estimates a shift of the recorded times. ``between`` are times [s] of the run.
    ``edges`` [rad/s] separate slow, waves and fast. ``only`` are patterns of channels. Raises
    InputError with the fault in the recording and its place.
    """
    places = guess(recording, recorded_channels(run)) if mapping is None else mapping.channels
    if not places:
        names = ", ".join(column.name for column in recording.columns)
        recording.source.wrong(
            f"found no column that matches a channel of the run, among {names}; expected at least"
            " one; assign columns to channels in a mapping (`mapping`)"
        )
    wanted = {name: places[name] for name in match_channels(places, only, "channels")}
    time = TimeColumn() if mapping is None else mapping.time
    align_at = (run, recording, wanted, time, between)
    overlap, pairs = align(*align_at)
    moved = _estimate_shift(overlap.time, pairs) if shift or time.shift else None
    if moved is not None and np.isfinite(moved):
        overlap, pairs = align(*align_at, moved)
    moving = [pair for pair in pairs if pair.ours.any() or pair.recorded.any()] or pairs
    results = {pair.channel: _compare_channel(overlap.time, pair, edges) for pair in moving}
    return Comparison(
        results,
        overlap,
        edges,
        [name for name in wanted if name not in results],
        _unused_columns(recording, places, time),
        mapping is None,
        moved,
    )


def exceeded_tolerances(
    comparison: Comparison, tolerances: Mapping[str, float]
) -> dict[str, float]:
    """``tolerances``, as for `tolerances_by_channel`, that channels exceed, by channel."""
    held = tolerances_by_channel(comparison, tolerances)
    return {
        name: limit for name, limit in held.items() if not comparison.results[name].error <= limit
    }


def tolerances_by_channel(
    comparison: Comparison, tolerances: Mapping[str, float]
) -> dict[str, float]:
    """Tolerance of each channel. ``tolerances`` are by channel or pattern; the last match applies.
    Raises InputError if one matches no channel."""
    match_channels([*comparison.results, *comparison.zero], list(tolerances), "tolerance")
    return {
        name: limit
        for pattern, limit in tolerances.items()
        for name in comparison.results
        if fnmatchcase(name, pattern)
    }


def _compare_channel(
    time: np.ndarray, pair: ChannelPair, edges: tuple[float, float]
) -> ChannelResult:
    differences = figures(time, pair, edges)
    most = min(MAX_LAG_FRACTION * float(np.ptp(time)), MAX_LAG_S)
    fitted = fit(time, pair.ours, pair.recorded, most)
    verdict = diagnose(time, pair, differences, fitted, edges, most)
    return ChannelResult(pair, differences, fitted, contact(time, pair), verdict)


def _estimate_shift(time: np.ndarray, pairs: Sequence[ChannelPair]) -> float:
    """Time shift to add to the recorded times [s]: the median over the channels that then
    correlate; NaN if none does."""
    fits = [
        fit(time, pair.ours, pair.recorded, MAX_SHIFT_FRACTION * float(np.ptp(time)))
        for pair in pairs
    ]
    lags = [-fit.lag for fit in fits if abs(fit.correlation) > MIN_SHIFT_CORRELATION]
    return float(np.median(lags)) if lags else float("nan")


def _unused_columns(
    recording: Recording, places: Mapping[str, ChannelPlace], time: TimeColumn
) -> list[str]:
    stamp = recording.time_column() if time.column is None else recording.column(time.column)
    used = [stamp, *(recording.column(place.column) for place in places.values())]
    left = [c.name for c in recording.columns if not any(c is place for place in used)]
    return [*left, *recording.left_out]
