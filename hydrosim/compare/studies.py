"""Two sets of runs against each other: two versions, two methods, or a campaign of tests.

Each channel is a number of each run: its figures, its place at the end, statistics of its motions
and forces. Runs of the same parameters and seeds are pairs, in the same waves, and it is their
differences that are tested (Student's t); else the two sets are independent (Welch's t). Many
channels are looked at together: a channel differs if it does at `LEVEL` after Holm (1979,
Scandinavian Journal of Statistics 6), so that by chance one or more of all are named that often.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy import stats

from hydrosim.compare.circumstances import codes_apart, durations_apart, is_code
from hydrosim.documents.series import unit_of
from hydrosim.errors import InputError
from hydrosim.results.runs_file import RUN
from hydrosim.statistics.gumbel import INTERVAL

LEVEL = 0.05
FEWEST = 3  # runs that a test needs
KINDS = {True: "pairs in the same waves", False: "independent runs"}
STATISTICS = ("mean", "std", "smallest", "largest")
APART = {"seed", "solver_steps", "solver_events", "energy_residual_relative", "contact_sequence"}


class Found(NamedTuple):
    """A channel: means of both, the mean difference ours less theirs with its interval, the
    probability of such a one by chance, whether it counts as different, and its ``values`` in the
    runs of ours and of theirs (n,)."""

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


class Comparison(NamedTuple):
    """All channels; of how many runs, ``paired`` or not; where they differ the ``durations`` of
    ours and of theirs in words, and the names of ``codes``, which are not tested."""

    channels: list[Found]
    ours: int
    theirs: int
    paired: bool
    durations: tuple[str, ...] = ()
    codes: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """What the runs of both sets are to each other."""
        if not self.durations:
            return KINDS[self.paired]
        kind = "pairs of the same seeds" if self.paired else KINDS[False]
        return f"{kind}, but of other durations: ours {' and theirs '.join(self.durations)}"


def compare_studies(ours: xr.Dataset, theirs: xr.Dataset) -> Comparison:
    """Channel by channel what differs between two sets of runs; InputError where they have no
    channel in common, or too few runs."""
    pairs = _pairs(ours, theirs)
    if pairs is not None:
        ours, theirs = (
            each.isel({RUN: at}) for each, at in zip((ours, theirs), pairs, strict=True)
        )
    else:
        _refuse_pooled(ours, theirs)
    paired = pairs is not None
    known = dict(_channels(theirs))
    found = [
        _tested(name, values, known[name], paired)
        for name, values in _channels(ours)
        if name in known
    ]
    tested = [each for each in found if each is not None]
    if not tested:
        raise InputError(
            f"compare: found no channel that {FEWEST} runs or more of both have; expected two files"
            " of runs of one kind of case (hydrosim sweep)."
        )
    sizes = ours.sizes[RUN], theirs.sizes[RUN]
    durations, codes = (f(ours, theirs, paired) for f in (durations_apart, codes_apart))
    return Comparison(_marked(tested), *sizes, paired, durations, codes)


def _pairs(ours: xr.Dataset, theirs: xr.Dataset) -> tuple[list[int], list[int]] | None:
    """The runs that have the same seed and parameters; None if there is no such key, or a set has
    one of them twice."""
    shared = [str(n) for n in ours.coords if n in theirs.coords and ours[n].dims == (RUN,)]
    names = [name for name in shared if name != RUN and theirs[name].dims == (RUN,)]
    if "seed" not in names:
        return None
    one, other = (
        {key: k for k, key in enumerate(zip(*(of[n].values.tolist() for n in names), strict=True))}
        for of in (ours, theirs)
    )
    both = [key for key in one if key in other]
    if len(one) < ours.sizes[RUN] or len(other) < theirs.sizes[RUN] or len(both) < FEWEST:
        return None
    return [one[key] for key in both], [other[key] for key in both]


def _refuse_pooled(*sets: xr.Dataset) -> None:
    """Runs of other parameters are no runs of other seeds."""
    for runs in sets:
        for name in map(str, runs.coords):
            varied = runs[name].dims == (RUN,) and name not in (RUN, "seed")
            if varied and np.unique(runs[name].values.astype(str)).size > 1:
                raise InputError(
                    f"compare: found runs of several values of {name}, which the two files do not"
                    " share seed by seed; expected the same parameters and seeds in both, or one"
                    " combination of parameters in each."
                )


def _channels(runs: xr.Dataset) -> Iterator[tuple[str, xr.DataArray]]:
    """All numbers of a run by name: "crawl", "motion.barge.surge.largest"."""
    for name, variable in runs.data_vars.items():
        others = [str(dim) for dim in variable.dims if dim != RUN]
        kept = RUN in variable.dims and variable.dtype.kind == "f" and name not in APART
        if not kept or is_code(variable) or {"time", "frequency", "extreme"} & {*others}:
            continue
        values = variable
        if "statistic" in others:
            values = variable.sel(statistic=[s for s in STATISTICS if s in variable.statistic])
        labels = [values[dim].values.tolist() for dim in others]
        for at in product(*labels):
            one = values.sel(dict(zip(others, at, strict=True)))
            unit = unit_of(one.attrs, [*map(str, at)])
            yield ".".join(map(str, (name, *at))), one.assign_attrs(units=unit)


def _tested(name: str, ours: xr.DataArray, theirs: xr.DataArray, paired: bool) -> Found | None:
    values = a, b = ours.values.astype(float), theirs.values.astype(float)
    if paired:
        known = np.isfinite(a) & np.isfinite(b)
        a, b = a[known], b[known]
    a, b = a[np.isfinite(a)], b[np.isfinite(b)]
    if min(a.size, b.size) < FEWEST:
        return None
    difference = float(a.mean() - b.mean())
    spread = np.ptp(a - b) if paired else np.ptp(a) + np.ptp(b)
    if spread == 0.0:
        low = high = difference
        chance = 1.0 if difference == 0.0 else 0.0
    else:
        test = stats.ttest_rel(a, b) if paired else stats.ttest_ind(a, b, equal_var=False)
        low, high = test.confidence_interval(INTERVAL)
        chance = float(test.pvalue)
    unit = str(ours.attrs.get("units", ""))
    means, ends = (float(a.mean()), float(b.mean())), (float(low), float(high))
    return Found(name, unit, *means, difference, *ends, chance, False, values)


def _marked(found: list[Found]) -> list[Found]:
    """Those that differ are marked, by Holm's procedure."""
    order = np.argsort([each.chance for each in found])
    differs = np.zeros(len(found), dtype=bool)
    for rank, k in enumerate(order):
        if found[k].chance > LEVEL / (len(found) - rank):
            break
        differs[k] = True
    return [each._replace(differs=bool(d)) for each, d in zip(found, differs, strict=True)]
