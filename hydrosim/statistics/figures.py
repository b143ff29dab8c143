"""Figures of a run (one number each), mean forces from impulses, and criteria of runs.

A figure is a statistic of a channel over the whole run or in one phase:

    end, change             the last value; the last minus the first
    end_absolute            magnitude of the last value, of a position from the place at rest
    change_absolute         magnitude of the last minus the first: the crawl, wherever it began
    mean                    of the recorded values; of a force, by its impulse if they differ
    std                     of the recorded values
    smallest, largest       of the recorded values
    largest_absolute        largest magnitude

`hydrosim.statistics.results` has figures that are no statistic of a channel.

Of criteria, a value that a run never comes to, such as that of a phase that is not reached, keeps
its limit. A stage that a run does not reach is later than any limit.

Mean forces from impulses, for runs that record them.

A force that chatters, or peaks between two output times, has a different mean in the records than
over the time. Its impulse, an integral over the solver's own steps, gives the true mean. It
replaces the mean of the records if both differ by more than `MEAN_DIFFERENCE_FRACTION` of the
force's standard deviation.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from math import inf, isnan, nan
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from hydrosim.case.criteria import CRITERIA
from hydrosim.errors import InputError
from hydrosim.results.channels import channel_series, lowest_value
from hydrosim.results.phases import Phase
from hydrosim.results.runs_file import COMPLETE
from hydrosim.statistics.effects import PlanRuns, combinations
from hydrosim.statistics.results import LOWEST_ATTRIBUTE, RunResults, StageResult

if TYPE_CHECKING:
    import xarray as xr

MEAN_DIFFERENCE_FRACTION = 0.01
FENDER_NORMAL_FORCE = "fender_normal_force"


def means_between_records(run: xr.Dataset, name: str, values: np.ndarray) -> np.ndarray | None:
    """Means (nt,) of a force channel ``name`` since the previous record, NaN at the first; None if
    their mean agrees with that of the recorded ``values`` (nt,)."""
    impulse = _impulse_of_channel(run, name)
    if impulse is None or values.size < 2:
        return None
    time = run.time.values
    means = np.diff(impulse) / np.diff(time)
    recorded = np.trapezoid(values, time) / (time[-1] - time[0])
    true = (impulse[-1] - impulse[0]) / (time[-1] - time[0])
    if abs(recorded - true) <= MEAN_DIFFERENCE_FRACTION * values.std():
        return None
    return np.append(np.nan, means)


def _impulse_of_channel(run: xr.Dataset, name: str) -> np.ndarray | None:
    """Time integral (nt,) of a force channel, if the run has it."""
    kind, _, of = name.partition(".")
    if kind == FENDER_NORMAL_FORCE and "contact_impulse" in run:
        fenders = (
            [of] if of in run.fender.values else run.fender.values[run.fender_group.values == of]
        )
        impulse = run.contact_impulse.sel(fender=fenders).transpose("time", ...)
        return np.asarray(impulse.values.reshape(run.sizes["time"], -1).sum(axis=1))
    if kind.startswith("force_") and "impulse" in run:
        force, body, dof = kind.removeprefix("force_"), *of.split(".")
        return np.asarray(run.impulse.sel(force=force, body=body, dof=dof).values)
    return None


Statistic = Callable[[np.ndarray], float]
STATISTICS: dict[str, Statistic] = {
    "end": lambda x: x[-1],
    "end_absolute": lambda x: abs(x[-1]),
    "change": lambda x: x[-1] - x[0],
    "change_absolute": lambda x: abs(x[-1] - x[0]),
    "mean": np.mean,
    "std": np.std,
    "smallest": np.min,
    "largest": np.max,
    "largest_absolute": lambda x: np.abs(x).max(),
}
SIDE_ATTRIBUTE = "side"  # attribute of figures that are the largest or the smallest of something
STATISTIC_SIDES = {"largest": "largest", "largest_absolute": "largest", "smallest": "smallest"}
MAGNITUDE_STATISTICS = ("end_absolute", "change_absolute", "std", "largest_absolute")
"""Statistics that are never negative."""
STATISTIC_WORDS = {
    "end_absolute": "magnitude at the end",
    "change_absolute": "magnitude of the change",
    "largest_absolute": "largest magnitude",
}
"""Statistics whose names are not words."""
PHASES_BY_NAME = {phase.name.lower().replace("_", " "): phase for phase in Phase}


class RequestedStatistic(Protocol):
    """A number that is asked of each run, under a ``name``."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def channel(self) -> str:
        """The channel that it is of, "" if of none."""

    @property
    def statistic(self) -> str:
        """The statistic of the channel, "" if of none."""

    @property
    def phase(self) -> str | None:
        """The phase of the operation that it is of, if not of all times."""

    @property
    def start(self) -> float:
        """The time [s] from which on it is taken."""

    @property
    def needs_impulses(self) -> bool:
        """Whether a run must record impulses."""

    @property
    def is_late_if_missing(self) -> bool:
        """Whether a run without it has not come to it yet."""

    @property
    def at_least(self) -> bool:
        """Whether a limit is the least that it may be, unless said otherwise."""

    @property
    def is_even(self) -> bool:
        """Whether it is the same of a scene and of its mirror image about the x axis, if it is of
        no channel."""

    @property
    def elements(self) -> tuple[str, ...]:
        """The groups of contacts or force elements that it is of, if it is of no channel."""

    def evaluate(self, results: RunResults) -> xr.DataArray:
        """The number, with its unit."""


class ScalarResult(NamedTuple):
    """A requested figure: a ``statistic`` of a ``channel`` in a phase of the operation of any group
    of contacts, or over all times from ``start`` [s] on."""

    name: str
    channel: str
    statistic: str
    phase: str | None = None
    start: float = 0.0

    @property
    def needs_impulses(self) -> bool:
        """Whether a run must record impulses."""
        return False

    @property
    def is_late_if_missing(self) -> bool:
        """Whether a run without it has not come to it yet."""
        return False

    @property
    def is_even(self) -> bool:
        """That depends on the channel."""
        return False

    @property
    def elements(self) -> tuple[str, ...]:
        """It is of a channel."""
        return ()

    @property
    def at_least(self) -> bool:
        """Whether a limit is the least that it may be, unless said otherwise."""
        return self.statistic == "smallest"

    def __str__(self) -> str:
        text = f"{STATISTIC_WORDS.get(self.statistic, self.statistic)} of {self.channel}"
        return f"{text} while {self.phase}" if self.phase else text

    def evaluate(self, results: RunResults) -> xr.DataArray:
        """The number, with its unit; NaN where the run is never in that phase. Raises InputError
        where the run has no such channel or no contacts whose phases there could be."""
        import xarray as xr  # slow to load, and few runs have such a result

        run = results.run
        values, unit = channel_series(run, self.channel)
        times = _times(run, self)
        if self.statistic == "mean":
            means = means_between_records(run, self.channel, values)
            if means is not None:
                values = means
                times &= ~np.isnan(means)
        within = values[times]
        number = float(STATISTICS[self.statistic](within)) if within.size else np.nan
        attributes = {"long_name": str(self), "units": unit}
        return xr.DataArray(number, attrs={**attributes, **_side(self), **_lower_bound(self)})


def _side(of: ScalarResult) -> dict[str, str]:
    return (
        {SIDE_ATTRIBUTE: STATISTIC_SIDES[of.statistic]} if of.statistic in STATISTIC_SIDES else {}
    )


def _lower_bound(of: ScalarResult) -> dict[str, float]:
    """What the number cannot be below: a magnitude, or a value of a channel that is one."""
    if of.statistic in MAGNITUDE_STATISTICS:
        return {LOWEST_ATTRIBUTE: 0.0}
    lowest = lowest_value(of.channel)
    return {LOWEST_ATTRIBUTE: lowest} if of.statistic != "change" and np.isfinite(lowest) else {}


def figure_of(run: xr.Dataset, figure: RequestedStatistic) -> xr.DataArray:
    """The number that is asked of a run, with its unit."""
    return figure.evaluate(RunResults(run))


def _times(run: xr.Dataset, figure: ScalarResult) -> np.ndarray:
    late = run.time.values >= figure.start
    if figure.phase is None:
        return np.asarray(late)
    if "contact_phase" not in run:
        raise InputError(
            f"found phase {figure.phase}; expected a run with contacts: phases are stages of"
            f" contact ({', '.join(PHASES_BY_NAME)}). Leave the phase out."
        )
    phases = run.contact_phase.transpose("time", "contact_group").values
    return np.asarray(late & np.any(phases == PHASES_BY_NAME[figure.phase], axis=1))


# Criteria of runs: the value held against each limit, in one run or over a study.

NO_COMPLETE_RUN = "no run is complete"


class Criterion(NamedTuple):
    """A criterion: its ``value`` and ``limit`` in an SI ``unit``, its ``source``; why there is no
    value, as ``missing``."""

    name: str
    what: str
    value: float
    limit: float
    unit: str
    source: str
    is_least: bool
    missing: str = ""

    @property
    def is_met(self) -> bool:
        """Whether the value keeps the limit."""
        if self.missing:
            return False
        beyond = self.value < self.limit if self.is_least else self.value > self.limit
        return not beyond

    @property
    def margin(self) -> float:
        """How far the value is from the limit, negative where the limit is exceeded."""
        return self.value - self.limit if self.is_least else self.limit - self.value

    @property
    def utilisation(self) -> float:
        """The share of the limit that is used; NaN for a least value, or a limit of zero."""
        used = not self.is_least and self.limit != 0.0
        return self.value / self.limit if used else nan


class JudgedCriterion(NamedTuple):
    """A criterion over runs of a ``plan``. The ``worst`` is that of the run with the ``seed``, at
    the ``values`` of the parameters. Of the complete ``runs``, so many ``met`` the limit, and so
    many are ``without`` a value."""

    worst: Criterion
    plan: PlanRuns
    values: dict[str, Any]
    seed: str
    runs: int
    met: int
    without: int

    @property
    def is_met(self) -> bool:
        """Whether every complete run meets it."""
        return self.worst.is_met


def criteria_of(run: xr.Dataset) -> list[Criterion]:
    """The criteria that the case of a run asks for, with what the run comes to."""
    asked = json.loads(str(run.attrs.get(CRITERIA, "[]")))
    return [_criterion_in_run(run, criterion) for criterion in asked]


def judge_study(plans: Sequence[PlanRuns]) -> list[JudgedCriterion]:
    """Each criterion of a study over all of its runs."""
    judged = [criterion for plan in plans for criterion in judge_plan(plan)]
    names = dict.fromkeys(criterion.worst.name for criterion in judged)
    return [_merge_combinations([j for j in judged if j.worst.name == name]) for name in names]


def judge_plan(plan: PlanRuns) -> Iterator[JudgedCriterion]:
    """Each criterion of a plan at each combination of values of its parameters."""
    criteria = [name for name in plan.criteria if name in plan.runs]
    for values, at in combinations(plan):
        runs = plan.runs.isel(run=at)
        for name in criteria:
            yield _judge_runs(plan, values, runs, name)


def _merge_combinations(judged: Sequence[JudgedCriterion]) -> JudgedCriterion:
    """A criterion over the runs of all combinations: the one with the least margin."""
    return min(judged, key=lambda judged: _rank_of_criterion(judged.worst))._replace(
        runs=sum(judged.runs for judged in judged),
        met=sum(judged.met for judged in judged),
        without=sum(judged.without for judged in judged),
    )


def _rank_of_criterion(of: Criterion) -> float:
    """The worst has the lowest. A criterion without a value has the highest."""
    return inf if isnan(of.margin) else of.margin


def _judge_runs(
    plan: PlanRuns, values: dict[str, Any], runs: xr.Dataset, name: str
) -> JudgedCriterion:
    complete = runs.isel(run=runs.status.values == COMPLETE)
    criteria = [_evaluate_criterion(plan, name, float(value)) for value in complete[name].values]
    if not criteria:
        none = _evaluate_criterion(plan, name, nan)._replace(missing=NO_COMPLETE_RUN)
        return JudgedCriterion(none, plan, values, "", 0, 0, 0)
    place = min(range(len(criteria)), key=lambda k: _rank_of_criterion(criteria[k]))
    return JudgedCriterion(
        criteria[place],
        plan,
        values,
        str(complete.seed.values[place]) if "seed" in complete else "",
        runs=len(criteria),
        met=sum(criterion.is_met for criterion in criteria),
        without=sum(isnan(criterion.value) for criterion in criteria),
    )


def _evaluate_criterion(plan: PlanRuns, name: str, value: float) -> Criterion:
    """A criterion with the value of one run."""
    asked = plan.criteria[name]
    of = plan.runs[name].attrs
    never = asked["never_is_late"] and isnan(value)
    return Criterion(
        name,
        str(of.get("long_name", name)),
        inf if never else value,
        float(asked["limit"]),
        str(of.get("units", "")),
        str(asked["source"]),
        bool(asked["at_least"]),
    )


def _criterion_in_run(run: xr.Dataset, asked: dict[str, Any]) -> Criterion:
    figure = figure_asked(asked)
    limit = float(asked["limit"])
    fixed = (str(asked["source"]), figure.at_least)
    try:
        figure_value = figure_of(run, figure)
    except InputError as error:
        return Criterion(figure.name, str(figure), nan, limit, "", *fixed, str(error))
    unit = str(figure_value.attrs["units"])
    return Criterion(figure.name, str(figure), float(figure_value), limit, unit, *fixed)


def figure_asked(asked: dict[str, Any]) -> ScalarResult | StageResult:
    """What a criterion of a case is of: a statistic of a channel, or a result of contacts."""
    name = str(asked["name"])
    if asked.get("result"):
        return StageResult(name, asked["result"], asked["group"], None, None)
    return ScalarResult(name, asked["channel"], asked["statistic"], asked["phase"])
