"""Criteria of a study: the worst of its runs held against each limit, and how many runs meet it, in
the words of `hydrosim.wording.criteria`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import xarray as xr

from hydrosim.presentation.document import Cell, Node, Outcome, Sentence, Table, Verdict
from hydrosim.results.runs_file import COMPLETE
from hydrosim.statistics.criteria import Criterion, JudgedCriterion, judge_plan, judge_study
from hydrosim.statistics.effects import SAMPLED_DESIGNS, PlanRuns
from hydrosim.wording.criteria import (
    criteria_verdict,
    criterion_figures,
    criterion_not_met,
    meanings,
    met_or_not,
)
from hydrosim.wording.sections import MAX_TABLE_ROWS
from hydrosim.wording.seeds import named_values


def study_criteria(runs: xr.Dataset, plans: Sequence[PlanRuns]) -> Iterator[Node]:
    """A verdict on all criteria of a study, one on each that is not met, the register with values
    of the worst run, and the criteria at each value of the parameters."""
    found = judge_study(plans)
    if not found:
        return
    worst = [each.worst for each in found]
    yield _verdict(runs, worst)
    yield from (_broken_in(each, plans) for each in found if not each.is_met)
    head = ("criterion", "worst value", "limit", "margin", "used", "")
    more = ("runs within", "worst run", "source of the limit")
    rows = [
        [
            *criterion_figures(each.worst),
            met_or_not(each.worst),
            _share(each),
            _place(each, plans),
            each.worst.source,
        ]
        for each in found
    ]
    yield Table((*head, *more), rows, "Criteria")
    yield from (_runs_without_event(each) for each in found if each.without)
    yield from _by_value(plans)
    yield meanings(worst)


def _verdict(runs: xr.Dataset, worst: Sequence[Criterion]) -> Verdict:
    """What is not complete is not judged, so that what is met by the rest is no pass."""
    complete = int((runs.status == COMPLETE).sum())
    count = runs.sizes["run"]
    if complete == count:
        return criteria_verdict(worst, f" in all {count} runs")
    where = f" in the {complete} runs of {count} that are complete; the others are not judged"
    return criteria_verdict(worst, where, Outcome.WARNING)


def _broken_in(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> Verdict:
    place = _place(of, plans)
    at = f" in the worst run ({place})" if place else " in the worst run"
    return criterion_not_met(of.worst, at, f" {of.met} of {of.runs} runs meet it.")


def _share(of: JudgedCriterion) -> str:
    return f"{of.met}/{of.runs}"


def _place(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> str:
    """The plan, the values of the parameters and the seed of the worst run."""
    seed = f"seed {of.seed}" if of.seed else ""
    return ", ".join(filter(None, [_plan(of, plans), named_values(of.plan, of.values), seed]))


def _plan(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> str:
    return of.plan.name.replace("_", " ") if len(plans) > 1 else ""


def _runs_without_event(of: JudgedCriterion) -> Sentence:
    return Sentence(
        "{} of {} runs never come to {} ({}). They count as runs that meet it.",
        [str(of.without), str(of.runs), of.worst.name, of.worst.what],
    )


def _by_value(plans: Sequence[PlanRuns]) -> Iterator[Table | Sentence]:
    """Each criterion at each value of the parameters, of plans that have values."""
    own = [plan for plan in plans if plan.parameters and plan.design not in SAMPLED_DESIGNS]
    each = [judged for plan in own for judged in judge_plan(plan)]
    each.sort(key=lambda judged: [*own[0].criteria].index(judged.worst.name))
    if not each:
        return
    head = ("criterion", "at", "worst value", "margin", "", "runs within")
    rows = [_row_at(judged, plans) for judged in each[:MAX_TABLE_ROWS]]
    yield Table(head, rows, "Criteria at each value")
    if len(each) > MAX_TABLE_ROWS:
        more = str(len(each) - MAX_TABLE_ROWS)
        yield Sentence("{} more rows are in the table that hydrosim statistics writes.", [more])


def _row_at(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> list[Cell]:
    name, worst, _, margin, _ = criterion_figures(of.worst)
    at = ", ".join(filter(None, [_plan(of, plans), named_values(of.plan, of.values)]))
    return [name, at, worst, margin, met_or_not(of.worst), _share(of)]
