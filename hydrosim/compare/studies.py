"""Comparison of two sets of runs: two versions, two methods, or a campaign of tests.

Each channel is a number of each run: its figures, its final position, statistics of its motions and
forces. Runs of the same parameters and seeds are pairs, in the same waves, and their differences
are tested (Student's t). Otherwise the two sets are independent (Welch's t). A channel differs if
it does at `SIGNIFICANCE_LEVEL` after Holm (1979, Scandinavian Journal of Statistics 6). So
`SIGNIFICANCE_LEVEL` is the probability that chance names one or more of all channels.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from hydrosim.errors import InputError
from hydrosim.files.series import unit_of
from hydrosim.results.ledger import RELATIVE
from hydrosim.results.runs_file import RUN, with_keys
from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY

if TYPE_CHECKING:
    import xarray as xr

# Differences that are not tested: durations, and codes such as the basis of extremes.

CASE = "case_resolved"
DURATION = re.compile(r"^duration: (\S+)$", re.MULTILINE)


def is_code(variable: xr.DataArray) -> bool:
    """Whether values are codes for words (CF conventions 1.11, section 3.5), which have no mean."""
    return "flag_values" in variable.attrs or str(variable.name).endswith("_basis")


def codes_apart(ours: xr.Dataset, theirs: xr.Dataset, paired: bool) -> tuple[str, ...]:
    """Codes that differ in a pair of runs. If runs are not ``paired``, codes whose sets of values
    differ."""
    both = [name for name in map(str, ours.data_vars) if name in theirs and is_code(ours[name])]
    return tuple(n for n in both if _values_differ(ours[n].values, theirs[n].values, paired))


def durations_apart(ours: xr.Dataset, theirs: xr.Dataset, paired: bool) -> tuple[str, ...]:
    """Durations of ours and theirs as text, if they differ and both files state them."""
    first, second = _run_durations(ours), _run_durations(theirs)
    if not first.size or not second.size or not _values_differ(first, second, paired):
        return ()
    return _range_text(first), _range_text(second)


def _values_differ(ours: np.ndarray, theirs: np.ndarray, paired: bool) -> bool:
    if not paired:
        ours, theirs = np.unique(ours), np.unique(theirs)
    return not np.array_equal(ours, theirs, equal_nan=True)


def _run_durations(runs: xr.Dataset) -> np.ndarray:
    """Duration of each run [s] (n,) from its case; empty if a case does not state it."""
    cases = runs[CASE].values.tolist() if CASE in runs and runs[CASE].dims == (RUN,) else []
    matches = [DURATION.search(case) for case in cases]
    return np.array([float(match[1]) for match in matches if match] if all(matches) else [])


def _range_text(durations: np.ndarray) -> str:
    low, high = durations.min(), durations.max()
    return f"{low:g} s" if low == high else f"{low:g} to {high:g} s"


SIGNIFICANCE_LEVEL = 0.05
MIN_RUNS = 3  # runs that a test needs
PAIRING_TEXTS = {True: "pairs in the same waves", False: "independent runs"}
STATISTICS = ("mean", "std", "smallest", "largest")
IGNORED_FIELDS = {
    *("seed", "solver_steps", "solver_events", "energy_residual_relative", "contact_sequence"),
    RELATIVE,
}


class ChannelDifference(NamedTuple):
    """A channel: means of both; the mean difference, ours minus theirs, with its interval; the
    probability of such a difference by chance; whether it counts as different; and its ``values``
    in the runs of ours and of theirs (n,)."""

    channel: str
    unit: str
    ours: float
    theirs: float
    difference: float
    low: float
    high: float
    chance: float
    differs: bool
    values: tuple[np.ndarray, np.ndarray]


class StudyComparison(NamedTuple):
    """All channels, and the numbers of runs, ``paired`` or not. ``durations`` of ours and of theirs
    are texts if they differ. ``codes`` are the names of codes that differ, which are not tested."""

    channels: list[ChannelDifference]
    ours: int
    theirs: int
    paired: bool
    durations: tuple[str, ...] = ()
    codes: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """Relation of the runs of both sets."""
        if not self.durations:
            return PAIRING_TEXTS[self.paired]
        kind = "pairs of the same seeds" if self.paired else PAIRING_TEXTS[False]
        return f"{kind}, but of different durations: ours {' and theirs '.join(self.durations)}"


def compare_studies(ours: xr.Dataset, theirs: xr.Dataset) -> StudyComparison:
    """Differences between two sets of runs, channel by channel. Raises InputError if they have no
    channel in common, or too few runs."""
    ours, theirs = with_keys(ours), with_keys(theirs)
    pairs = _pair_runs(ours, theirs)
    if pairs is not None:
        ours, theirs = (
            study.isel({RUN: at}) for study, at in zip((ours, theirs), pairs, strict=True)
        )
    else:
        _refuse_pooled(ours, theirs)
    paired = pairs is not None
    their_channels = dict(_numbers_of_run(theirs))
    tests = [
        _test_channel(name, values, their_channels[name], paired)
        for name, values in _numbers_of_run(ours)
        if name in their_channels
    ]
    tested = [test for test in tests if test is not None]
    if not tested:
        raise InputError(
            f"compare: found no recorded number that at least {MIN_RUNS} runs of each file have;"
            " expected two files of `hydrosim study` with the same bodies and the same figures."
        )
    sizes = ours.sizes[RUN], theirs.sizes[RUN]
    durations, codes = (f(ours, theirs, paired) for f in (durations_apart, codes_apart))
    return StudyComparison(_mark_differences(tested), *sizes, paired, durations, codes)


def _pair_runs(ours: xr.Dataset, theirs: xr.Dataset) -> tuple[list[int], list[int]] | None:
    """Pairs of runs with the same seed and parameters; None if there is no such key, or if one
    occurs twice in a set."""
    shared = [str(n) for n in ours.coords if n in theirs.coords and ours[n].dims == (RUN,)]
    names = [name for name in shared if name != RUN and theirs[name].dims == (RUN,)]
    if "seed" not in names:
        return None
    first, second = (
        {key: k for k, key in enumerate(zip(*(of[n].values.tolist() for n in names), strict=True))}
        for of in (ours, theirs)
    )
    both = [key for key in first if key in second]
    if len(first) < ours.sizes[RUN] or len(second) < theirs.sizes[RUN] or len(both) < MIN_RUNS:
        return None
    return [first[key] for key in both], [second[key] for key in both]


def _refuse_pooled(*sets: xr.Dataset) -> None:
    """Refuse sets whose runs differ in parameters, because these are not other seeds."""
    for runs in sets:
        for name in map(str, runs.coords):
            varied = runs[name].dims == (RUN,) and name != RUN and not name.startswith("seed")
            if varied and np.unique(runs[name].values.astype(str)).size > 1:
                raise InputError(
                    f"compare: found runs with several values of {name}, which the two files do"
                    " not share seed by seed; expected the same parameters and seeds in both, or"
                    " one combination of parameters in each."
                )


def _numbers_of_run(runs: xr.Dataset) -> Iterator[tuple[str, xr.DataArray]]:
    """All numbers of a run by name, such as "crawl" and "motion.barge.surge.largest"."""
    for name, variable in runs.data_vars.items():
        others = [str(dim) for dim in variable.dims if dim != RUN]
        is_compared = (
            RUN in variable.dims and variable.dtype.kind == "f" and name not in IGNORED_FIELDS
        )
        if not is_compared or is_code(variable) or {"time", "frequency", "extreme"} & {*others}:
            continue
        values = variable
        if "statistic" in others:
            values = variable.sel(statistic=[s for s in STATISTICS if s in variable.statistic])
        labels = [values[dim].values.tolist() for dim in others]
        for at in product(*labels):
            series = values.sel(dict(zip(others, at, strict=True)))
            unit = unit_of(series.attrs, [*map(str, at)])
            yield ".".join(map(str, (name, *at))), series.assign_attrs(units=unit)


def _test_channel(
    name: str, ours: xr.DataArray, theirs: xr.DataArray, paired: bool
) -> ChannelDifference | None:
    values = a, b = ours.values.astype(float), theirs.values.astype(float)
    if paired:
        is_paired = np.isfinite(a) & np.isfinite(b)
        a, b = a[is_paired], b[is_paired]
    a, b = a[np.isfinite(a)], b[np.isfinite(b)]
    if min(a.size, b.size) < MIN_RUNS:
        return None
    difference = float(a.mean() - b.mean())
    spread = np.ptp(a - b) if paired else np.ptp(a) + np.ptp(b)
    if spread == 0.0:
        low = high = difference
        chance = 1.0 if difference == 0.0 else 0.0
    else:
        test = (
            scipy.stats.ttest_rel(a, b) if paired else scipy.stats.ttest_ind(a, b, equal_var=False)
        )
        low, high = test.confidence_interval(INTERVAL_PROBABILITY)
        chance = float(test.pvalue)
    unit = str(ours.attrs.get("units", ""))
    means, ends = (float(a.mean()), float(b.mean())), (float(low), float(high))
    return ChannelDifference(name, unit, *means, difference, *ends, chance, False, values)


def _mark_differences(tests: list[ChannelDifference]) -> list[ChannelDifference]:
    """Channels with those marked that differ, by Holm's procedure."""
    order = np.argsort([test.chance for test in tests])
    differs = np.zeros(len(tests), dtype=bool)
    for rank, k in enumerate(order):
        if tests[k].chance > SIGNIFICANCE_LEVEL / (len(tests) - rank):
            break
        differs[k] = True
    return [test._replace(differs=bool(d)) for test, d in zip(tests, differs, strict=True)]
