"""Criteria of runs: the value that is held against each limit, in one run or over a study.

A value that a run never comes to, such as that of a phase that is not reached, keeps its limit. A
stage that a run does not reach is later than any limit.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from math import inf, isnan, nan
from typing import Any, NamedTuple

import xarray as xr

from hydrosim.case.criteria import CRITERIA
from hydrosim.errors import InputError
from hydrosim.results.runs_file import COMPLETE
from hydrosim.statistics.effects import PlanRuns, combinations
from hydrosim.statistics.figures import ScalarResult, figure_of
from hydrosim.statistics.results import StageResult

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
    by_name: dict[str, list[JudgedCriterion]] = {}
    for plan in plans:
        for judged in judge_plan(plan):
            by_name.setdefault(judged.worst.name, []).append(judged)
    return [_merge_combinations(judged) for judged in by_name.values()]


def judge_plan(plan: PlanRuns) -> Iterator[JudgedCriterion]:
    """Each criterion of a plan at each combination of values of its parameters."""
    criteria = [name for name in plan.criteria if name in plan.runs]
    for values, at in combinations(plan):
        runs = plan.runs.isel(run=at)
        for name in criteria:
            yield _judge_runs(plan, values, runs, name)


def _merge_combinations(judged: Sequence[JudgedCriterion]) -> JudgedCriterion:
    """A criterion over the runs of all combinations: the one with the least margin."""
    return min(judged, key=lambda judged: _rank(judged.worst))._replace(
        runs=sum(judged.runs for judged in judged),
        met=sum(judged.met for judged in judged),
        without=sum(judged.without for judged in judged),
    )


def _rank(of: Criterion) -> float:
    """The worst has the lowest. A criterion without a value has the highest."""
    return inf if isnan(of.margin) else of.margin


def _judge_runs(
    plan: PlanRuns, values: dict[str, Any], runs: xr.Dataset, name: str
) -> JudgedCriterion:
    complete = runs.isel(run=runs.status.values == COMPLETE)
    criteria = [_criterion(plan, name, float(value)) for value in complete[name].values]
    if not criteria:
        none = _criterion(plan, name, nan)._replace(missing=NO_COMPLETE_RUN)
        return JudgedCriterion(none, plan, values, "", 0, 0, 0)
    place = min(range(len(criteria)), key=lambda k: _rank(criteria[k]))
    return JudgedCriterion(
        criteria[place],
        plan,
        values,
        str(complete.seed.values[place]) if "seed" in complete else "",
        runs=len(criteria),
        met=sum(criterion.is_met for criterion in criteria),
        without=sum(isnan(criterion.value) for criterion in criteria),
    )


def _criterion(plan: PlanRuns, name: str, value: float) -> Criterion:
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
