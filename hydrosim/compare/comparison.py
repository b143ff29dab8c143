"""`compare`: a run and a recording, channel by channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from math import inf, isnan
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.compare.align import ChannelPair, Overlap, align
from hydrosim.compare.diagnosis import diagnose
from hydrosim.compare.figures import BAND_EDGES_RAD_S, ContactComparison, Figures, contact, figures
from hydrosim.compare.guess import guess
from hydrosim.compare.mapping import ChannelPlace, MappingFile, TimeColumn
from hydrosim.compare.signals import GainLagFit, fit
from hydrosim.recordings import Recording
from hydrosim.results.channels import match_channels, recorded_channels

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
            " one; assign columns to channels in a mapping (--mapping)"
        )
    wanted = {name: places[name] for name in match_channels(places, only, "--channels")}
    time = TimeColumn() if mapping is None else mapping.time
    align_at = (run, recording, wanted, time, between)
    overlap, pairs = align(*align_at)
    moved = _shift(overlap.time, pairs) if shift or time.shift else None
    if moved is not None and np.isfinite(moved):
        overlap, pairs = align(*align_at, moved)
    moving = [pair for pair in pairs if pair.ours.any() or pair.recorded.any()] or pairs
    results = {pair.channel: _result(overlap.time, pair, edges) for pair in moving}
    return Comparison(
        results,
        overlap,
        edges,
        [name for name in wanted if name not in results],
        _unused_columns(recording, places, time),
        mapping is None,
        moved,
    )


def exceeded_tolerances(found: Comparison, tolerances: Mapping[str, float]) -> dict[str, float]:
    """``tolerances``, as for `by_channel`, that channels exceed, by channel."""
    held = by_channel(found, tolerances)
    return {name: limit for name, limit in held.items() if not found.results[name].error <= limit}


def by_channel(found: Comparison, tolerances: Mapping[str, float]) -> dict[str, float]:
    """Tolerance of each channel. ``tolerances`` are by channel or pattern; the last match applies.
    Raises InputError if one matches no channel."""
    match_channels([*found.results, *found.zero], list(tolerances), "--tolerance")
    return {
        name: limit
        for pattern, limit in tolerances.items()
        for name in found.results
        if fnmatchcase(name, pattern)
    }


def _result(time: np.ndarray, pair: ChannelPair, edges: tuple[float, float]) -> ChannelResult:
    found = figures(time, pair, edges)
    most = min(MAX_LAG_FRACTION * float(np.ptp(time)), MAX_LAG_S)
    fitted = fit(time, pair.ours, pair.recorded, most)
    verdict = diagnose(time, pair, found, fitted, edges, most)
    return ChannelResult(pair, found, fitted, contact(time, pair), verdict)


def _shift(time: np.ndarray, pairs: Sequence[ChannelPair]) -> float:
    """Time shift to add to the recorded times [s]: the median over the channels that then
    correlate; NaN if none does."""
    fits = [
        fit(time, pair.ours, pair.recorded, MAX_SHIFT_FRACTION * float(np.ptp(time)))
        for pair in pairs
    ]
    lags = [-found.lag for found in fits if abs(found.correlation) > MIN_SHIFT_CORRELATION]
    return float(np.median(lags)) if lags else float("nan")


def _unused_columns(
    recording: Recording, places: Mapping[str, ChannelPlace], time: TimeColumn
) -> list[str]:
    stamp = recording.time_column() if time.column is None else recording.column(time.column)
    used = [stamp, *(recording.column(place.column) for place in places.values())]
    left = [c.name for c in recording.columns if not any(c is one for one in used)]
    return [*left, *recording.left_out]
