"""Sentences and tables of a study: effects of parameters, criteria, and how its runs went."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files import document_nodes
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_layout import text_of
from hydrosim.report.sentences import run as run_sentences
from hydrosim.report.sentences import sections, statistics
from hydrosim.results.ledger import MAX_RESIDUAL_FRACTION, RELATIVE, reported_beyond
from hydrosim.results.runs_file import COMPLETE, DIFFERING_ATTRIBUTE, GATHERED, with_keys
from hydrosim.results.validation import DESIGN
from hydrosim.statistics import effects
from hydrosim.statistics.effects import SAMPLED_DESIGNS, Difference, EffectRow, PlanRuns
from hydrosim.statistics.figures import Criterion, JudgedCriterion, judge_plan, judge_study

if TYPE_CHECKING:
    import xarray as xr

# Figures of all plans of a study in one table: a row for each value.

MIN_FIGURES = 2
"""Figures, from which on there is one table of all."""
METHOD_NOTE = (
    "Means over seeds, and half of their 90 % intervals. Figures are of all complete runs."
)


def has_results_table(plan: PlanRuns) -> bool:
    """Whether a plan is in the one table of its study."""
    return plan.design not in SAMPLED_DESIGNS and len(plan.figures) >= MIN_FIGURES


def results_table(plans: Sequence[PlanRuns]) -> document_nodes.Nodes:
    """All figures at all values of the plans; nothing where a plan has a single figure."""
    plans_with_results = [plan for plan in plans if has_results_table(plan)]
    if not plans_with_results:
        return
    figures = plans_with_results[0].figures
    several = len(plans) > 1
    columns = [name for figure in figures for name in (figure, "±")]
    head = (*(("study",) if several else ()), "value", *columns, "runs")
    rows = [row for plan in plans_with_results for row in _plan_rows(plan, figures, several)]
    yield document_nodes.Table(head, rows[: sections.MAX_TABLE_ROWS], "All figures")
    yield document_nodes.Sentence(METHOD_NOTE)
    for name in figures:
        text = str(plans_with_results[0].runs[name].attrs.get("long_name", ""))
        yield document_nodes.Sentence("{}: {}.", [name, text], detail=True)


def _plan_rows(
    plan: PlanRuns, figures: Sequence[str], several: bool
) -> Iterator[document_nodes.Row]:
    rows_by_values: dict[str, dict[str, EffectRow]] = {}
    for row in effects.rows(plan):
        rows_by_values.setdefault(statistics.named_values(plan, row.values) or "all", {})[
            row.figure
        ] = row
    for name, by_figure in rows_by_values.items():
        runs = max(row.spread.n for row in by_figure.values())
        study: document_nodes.Row = [plan.name.replace("_", " ")] if several else []
        cells = [cell for figure in figures for cell in _mean_cells(by_figure[figure])]
        yield [*study, name, *cells, str(runs)]


def _mean_cells(row: EffectRow) -> tuple[document_nodes.Cell, document_nodes.Cell]:
    """A mean, and half of its interval; nothing where no run has a value."""
    of = row.spread
    if not of.n:
        return "none", ""
    half = 0.5 * (of.high - of.low)
    return document_nodes.Value(of.mean, row.unit), document_nodes.Value(
        half, row.unit, 2
    ) if np.isfinite(half) else ""


# Criteria of a study: the worst run against each limit, and how many runs meet it.


def study_criteria(runs: xr.Dataset, plans: Sequence[PlanRuns]) -> document_nodes.Nodes:
    """A verdict on all criteria of a study, one on each that is not met, the register with values
    of the worst run, and the criteria at each value of the parameters."""
    judged = judge_study(plans)
    if not judged:
        return
    worst = [criterion.worst for criterion in judged]
    yield _judge_runs(runs, worst)
    yield from (_broken_in(criterion, plans) for criterion in judged if not criterion.is_met)
    head = ("criterion", "worst value", "limit", "margin", "used", "")
    more = ("runs within", "worst run", "source of the limit")
    rows = [
        [
            *run_sentences.criterion_figures(criterion.worst),
            run_sentences.met_or_not(criterion.worst),
            _met_count_text(criterion),
            _place_text(criterion, plans),
            criterion.worst.source,
        ]
        for criterion in judged
    ]
    yield document_nodes.Table((*head, *more), rows, "Criteria")
    yield from (_runs_without_event(criterion) for criterion in judged if criterion.without)
    yield from _describe_by_value(plans)
    yield run_sentences.meanings(worst)


def _judge_runs(runs: xr.Dataset, worst: Sequence[Criterion]) -> document_nodes.Verdict:
    """What is not complete is not judged, so that what is met by the rest is no pass."""
    complete = int((runs.status == COMPLETE).sum())
    count = runs.sizes["run"]
    if complete == count:
        return run_sentences.criteria_verdict(worst, f" in all {count} runs")
    where = f" in the {complete} runs of {count} that are complete; the others are not judged"
    return run_sentences.criteria_verdict(worst, where, document_nodes.Outcome.WARNING)


def _broken_in(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> document_nodes.Verdict:
    place = _place_text(of, plans)
    at = f" in the worst run ({place})" if place else " in the worst run"
    return run_sentences.criterion_not_met(of.worst, at, f" {of.met} of {of.runs} runs meet it.")


def _met_count_text(of: JudgedCriterion) -> str:
    return f"{of.met}/{of.runs}"


def _place_text(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> str:
    """The plan, the values of the parameters and the seed of the worst run."""
    seed = f"seed {of.seed}" if of.seed else ""
    return ", ".join(
        filter(
            None,
            [_plan_text(of, plans), statistics.named_values(of.plan, of.values), seed],
        )
    )


def _plan_text(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> str:
    return of.plan.name.replace("_", " ") if len(plans) > 1 else ""


def _runs_without_event(of: JudgedCriterion) -> document_nodes.Sentence:
    return document_nodes.Sentence(
        "{} of {} runs never come to {} ({}). They count as runs that meet it.",
        [str(of.without), str(of.runs), of.worst.name, of.worst.what],
    )


def _describe_by_value(
    plans: Sequence[PlanRuns],
) -> Iterator[document_nodes.Table | document_nodes.Sentence]:
    """Each criterion at each value of the parameters, of plans that have values."""
    plans_by_value = [
        plan for plan in plans if plan.parameters and plan.design not in SAMPLED_DESIGNS
    ]
    judged_criteria = [judged for plan in plans_by_value for judged in judge_plan(plan)]
    judged_criteria.sort(key=lambda judged: [*plans_by_value[0].criteria].index(judged.worst.name))
    if not judged_criteria:
        return
    head = ("criterion", "at", "worst value", "margin", "", "runs within")
    rows = [_row_at(judged, plans) for judged in judged_criteria[: sections.MAX_TABLE_ROWS]]
    yield document_nodes.Table(head, rows, "Criteria at each value")
    if len(judged_criteria) > sections.MAX_TABLE_ROWS:
        more = str(len(judged_criteria) - sections.MAX_TABLE_ROWS)
        yield document_nodes.Sentence(
            "{} more rows are in the table that hydrosim show --statistics writes.", [more]
        )


def _row_at(of: JudgedCriterion, plans: Sequence[PlanRuns]) -> document_nodes.Row:
    name, worst, _, margin, _ = run_sentences.criterion_figures(of.worst)
    at = ", ".join(
        filter(None, [_plan_text(of, plans), statistics.named_values(of.plan, of.values)])
    )
    return [name, at, worst, margin, run_sentences.met_or_not(of.worst), _met_count_text(of)]


MAX_WARNINGS_TOLD = 5
"""Warnings that a summary tells."""
MAX_RUNS_NAMED = 10
"""Runs that a remark is of."""
MAX_LINES_PER_CHART = 12
"""Lines of a picture."""
INTERVALS_NOTE = (
    "The 90 % interval contains the true mean over all seeds with a probability of 90 %. The"
    ' interval "another seed" contains the value of one more seed with the same probability. Both'
    " use Student's t, which is exact if a figure is normally distributed over seeds. Intervals of"
    " figures that cannot be negative use logarithms, and stay above zero."
)


def study_document(runs: xr.Dataset) -> Document:
    """The report of a file of many runs."""
    nodes = [
        *sections.title_block(runs, sections.case_data(runs)),
        *sections.build_sections(STUDY_SECTIONS, runs),
    ]
    return Document(sections.title_of(runs), nodes, counts_by_status(runs), units_of(runs.attrs))


def study_tables(runs: xr.Dataset) -> Document:
    """Criteria, how the runs went, what they warn of and what parameters do, without the case."""
    nodes = [
        *_describe_outcome(runs),
        *_frequent_warnings(runs, MAX_WARNINGS_TOLD),
        *_describe_results(runs),
    ]
    return Document(sections.title_of(runs), nodes, units=units_of(runs.attrs))


def counts_by_status(runs: xr.Dataset) -> str:
    """How many runs came to which end."""
    ends = ", ".join(f"{number} {name}" for name, number in _outcome_counts(runs).items())
    return f"{runs.sizes['run']} runs: {ends}"


def _outcome_counts(runs: xr.Dataset) -> Counter[str]:
    return Counter(map(str, runs.status.values))


def _describe_outcome(runs: xr.Dataset) -> document_nodes.Nodes:
    """Whether criteria are met, how many runs are complete, why others are not, and what not all of
    them have."""
    if DESIGN in runs.attrs:
        yield from study_criteria(runs, effects.plans(runs))
    yield from _describe_ends(runs)
    if differ := runs.attrs.get(DIFFERING_ATTRIBUTE):
        yield document_nodes.List(
            [f"{line}." for line in differ.splitlines()],
            "Not all runs have the same names and values. What a run does not have is empty:",
        )


def _describe_ends(runs: xr.Dataset) -> document_nodes.Nodes:
    if GATHERED in runs.attrs:
        yield document_nodes.warning("So far {}.", [str(runs.attrs[GATHERED])])
        return
    complete = _outcome_counts(runs)[COMPLETE]
    count = runs.sizes["run"]
    if complete == count:
        yield document_nodes.Verdict(
            document_nodes.Outcome.GOOD, "All {} runs are complete.", [str(count)]
        )
        return
    text = "{} of {} runs are complete. Figures are of these."
    yield document_nodes.Verdict(document_nodes.Outcome.BAD, text, [str(complete), str(count)])
    yield document_nodes.List(
        _shorten_list(
            [
                _sentence_with_runs(text, run_numbers)
                for text, run_numbers in _unfinished_runs(runs).items()
            ]
        )
    )


def _unfinished_runs(runs: xr.Dataset) -> dict[str, list[int]]:
    """The numbers of the runs that are not complete, by what became of them."""
    numbers_by_text: dict[str, list[int]] = {}
    ends = zip(runs.status.values, runs.status_message.values, strict=True)
    for k, (status, message) in enumerate(ends):
        if status != COMPLETE:
            numbers_by_text.setdefault(f"{status}: {message}".removesuffix(": "), []).append(k)
    return numbers_by_text


def _sentence_with_runs(text: str, run_numbers: list[int]) -> document_nodes.Sentence:
    """A remark with the numbers of the runs that it is of."""
    named = ", ".join(map(str, run_numbers[:MAX_RUNS_NAMED])) + (
        ", ..." if len(run_numbers) > MAX_RUNS_NAMED else ""
    )
    runs = "run" if len(run_numbers) == 1 else f"{len(run_numbers)} runs:"
    return document_nodes.Sentence("{} ({} {})", [text, runs, named])


def _describe_plan(title: str, runs: xr.Dataset) -> document_nodes.Sentence:
    """How many runs there are; a single seed is named, because ``seeds: 8`` is one."""
    count = runs.sizes["run"]
    seeds = np.unique(runs.seed if "seed" in runs.coords else [])
    text = f"{count} runs" if count > 1 else "1 run"
    seed_text = f" with seed {seeds[0]}" if len(seeds) == 1 else ""
    return document_nodes.Sentence("Plan: {}, {}.", [title, text + seed_text])


def _describe_results(runs: xr.Dataset) -> document_nodes.Nodes:
    """Tables and pictures of each plan; of seeds alone what lies between them."""
    if DESIGN not in runs.attrs:
        text = "The file does not say its plan: it comes from simulate_many or an earlier version."
        yield document_nodes.Sentence(text)
        text = (
            "In Python, runs.hydrosim.to_dataframe() has a row for each run, and"
            " runs.hydrosim.extremes_over_seeds() most probable extremes."
        )
        yield document_nodes.Sentence(text)
        return
    plans = effects.plans(runs)
    yield from results_table(plans)
    for plan in plans:
        title = " ".join(f"{plan.name} {plan.design}".replace("_", " ").split())
        yield _describe_plan(title, plan.runs)
        if plan.figures:
            yield from (
                _describe_samples(plan)
                if plan.design in SAMPLED_DESIGNS
                else _describe_values(plan)
            )
            if plan.design not in SAMPLED_DESIGNS and "motion" in runs:
                yield from statistics.extreme_nodes(plan)
        elif "motion" in runs:
            yield from statistics.seed_nodes(plan)
        else:
            yield document_nodes.Sentence("The study file asks for no figures.")


def _describe_values(plan: PlanRuns) -> document_nodes.Nodes:
    rows = list(effects.rows(plan))
    names = [*dict.fromkeys(name for row in rows for name in row.values)]
    head = (
        "figure",
        *map(statistics.short_key, names),
        "mean",
        "90 % interval",
        "another seed",
        "runs",
    )
    again = has_results_table(plan)
    yield document_nodes.Table(
        head,
        [_statistic_cells(plan, row, names) for row in rows[: sections.MAX_TABLE_ROWS]],
        detail=again,
    )
    yield document_nodes.Sentence(INTERVALS_NOTE, detail=True)
    if len(rows) > sections.MAX_TABLE_ROWS:
        more = str(len(rows) - sections.MAX_TABLE_ROWS)
        yield document_nodes.Sentence(
            "{} more rows are in the table that hydrosim show --statistics writes.", [more]
        )
    if told := [
        _difference_sentence(plan, difference) for difference in _differences_of_plan(plan)
    ]:
        yield document_nodes.List(told, "What the parameters change:", detail=again)
    yield from _plan_pictures(plan, rows)


def _statistic_cells(plan: PlanRuns, row: EffectRow, names: Sequence[str]) -> document_nodes.Row:
    s = row.spread
    values = [statistics.value_of(row.values[name], plan.unit(name)) for name in names]
    mean = document_nodes.Value(s.mean, row.unit) if s.n else "no run has a value"
    interval = document_nodes.Between(s.low, s.high, row.unit)
    another = document_nodes.Between(s.another_low, s.another_high, row.unit)
    return [row.figure, *values, mean, interval, another, str(s.n)]


def _differences_of_plan(plan: PlanRuns) -> list[Difference]:
    """Differences between the ends of a parameter, of plans that have them."""
    if plan.design != "one_at_a_time" and len(plan.parameters) != 1:
        return []
    return list(effects.differences(plan))


def _difference_sentence(plan: PlanRuns, of: Difference) -> document_nodes.Sentence:
    """A change in words; its interval where there are seeds to have one of, what contacts did where
    there are contacts."""
    axis = plan.axis(of.parameter)
    at = of.spread
    ends = [
        statistics.value_of(of.low, plan.unit(axis)),
        statistics.value_of(of.high, plan.unit(axis)),
    ]
    if not at.n:
        return document_nodes.Sentence(
            "{}: no seed has a value at both ends of {}.",
            [of.figure, statistics.short_key(axis)],
        )
    text = "{} changes by {} from {} {} to {}"
    parts: list[document_nodes.Part] = [
        of.figure,
        document_nodes.Value(at.mean, of.unit),
        statistics.short_key(axis),
        *ends,
    ]
    if np.isfinite(at.low):
        text += " ({}; {} seeds, standard deviation {})"
        parts += [
            document_nodes.Between(at.low, at.high, of.unit),
            str(at.n),
            document_nodes.Value(of.std, of.unit, 2),
        ]
    else:
        text += " (one run at each end)"
    if np.isfinite(of.changed):
        text += (
            "; in {} of the seeds, contacts open, stick and slip in different orders at the two"
            " values"
        )
        parts.append(document_nodes.Value(of.changed, "share", 2))
    return document_nodes.Sentence(f"{text}.", parts)


def _plan_pictures(plan: PlanRuns, rows: Sequence[EffectRow]) -> Iterator[document_nodes.Chart]:
    """Each figure over the first parameter that is a number, a line for each value of others."""
    axis = "" if plan.design == "one_at_a_time" else numeric_axis(plan)
    for figure in plan.figures if axis else ():
        chart = effect_chart(plan, [row for row in rows if row.figure == figure], axis)
        if len(chart.lines) <= MAX_LINES_PER_CHART:
            yield chart


def numeric_axis(plan: PlanRuns) -> str:
    """The coordinate of the first parameter whose values are numbers; empty if there is none."""
    axes = (plan.axis(parameter) for parameter in plan.parameters)
    return next((axis for axis in axes if plan.runs[axis].dtype.kind in "if"), "")


def effect_chart(plan: PlanRuns, rows: Sequence[EffectRow], axis: str = "") -> document_nodes.Chart:
    """The means in the ``rows`` of a figure over the numbers of an ``axis``, a line for each
    combination of the values of other parameters. Without an axis there is one line over all
    combinations, in their order."""
    figure = rows[0].figure
    rows_by_line: dict[str, list[EffectRow]] = {}
    for row in rows:
        others = _other_parameters(plan, row, axis) if axis else ()
        rows_by_line.setdefault(", ".join(others) or figure, []).append(row)
    lines = {name: _effect_line(plan, of_line, axis) for name, of_line in rows_by_line.items()}
    return document_nodes.Chart(
        f"{figure}: means over seeds with their 90 % intervals",
        figure,
        rows[0].unit,
        lines,
        x_label=statistics.short_key(axis),
        x_unit=plan.unit(axis) if axis else "",
    )


def _other_parameters(plan: PlanRuns, row: EffectRow, axis: str) -> Iterator[str]:
    """The values of all parameters but one, as they are read."""
    units = units_of(plan.runs.attrs)
    for name, value in row.values.items():
        if name != axis:
            yield text_of(statistics.value_of(value, plan.unit(name)), units)


def _effect_line(plan: PlanRuns, rows: Sequence[EffectRow], axis: str) -> document_nodes.ChartLine:
    x = np.array([row.values[axis] for row in rows] if axis else range(len(rows)), float)
    rows = [rows[k] for k in np.argsort(x, kind="stable")]
    _, y, low, high, *wide = np.array([row.spread for row in rows], float).T
    values = [plan.runs[row.figure].values[row.runs] for row in rows]
    return document_nodes.ChartLine(y, np.sort(x), low, high, wide=np.array(wide), values=values)


def _describe_samples(plan: PlanRuns) -> document_nodes.Nodes:
    """Correlations of drawn samples, or Sobol's indices."""
    if plan.design != "sobol_indices":
        rows = [
            (f, statistics.short_key(p), document_nodes.Value(r, digits=3))
            for f, p, r in effects.correlations(plan)
        ]
        yield document_nodes.Table(("figure", "parameter", "Spearman's rank correlation"), rows)
        return
    try:
        sobol_indices = list(effects.indices(plan))
    except InputError as error:
        yield document_nodes.Verdict(document_nodes.Outcome.BAD, "{}", [str(error)])
        return
    yield document_nodes.Sentence("Sobol's indices are shares of the variance of a figure.")
    head = ("figure", "parameter", "alone", "90 % interval", "with all others", "90 % interval")
    rows_: list[document_nodes.Row] = [
        [
            e.figure,
            statistics.short_key(e.parameter),
            *_share_cells(e.first),
            *_share_cells(e.total),
        ]
        for e in sobol_indices
    ]
    yield document_nodes.Table(head, rows_)


def _share_cells(
    of: tuple[float, float, float],
) -> tuple[document_nodes.Value, document_nodes.Between]:
    return document_nodes.Value(of[0], digits=2), document_nodes.Between(of[1], of[2], digits=2)


def _describe_case(runs: xr.Dataset) -> document_nodes.Nodes:
    """The case that all have, or that of the first run; parameters and seeds vary about it."""
    yield document_nodes.Sentence(
        "The case of the first run. Parameters of the study and seeds differ in others."
    )
    first = {name: str(runs[name].values[0]) for name in ("case", "case_resolved") if name in runs}
    one_run = runs.assign_attrs(first)
    yield from sections.case_nodes(one_run, sections.case_data(one_run))


def _study_assumptions(runs: xr.Dataset) -> document_nodes.Nodes:
    """Warnings with how many runs have them, then what the runs have in common."""
    told = list(_frequent_warnings(runs, sections.MAX_TABLE_ROWS))
    yield from told or [document_nodes.Sentence("The runs hold no warnings.")]
    yield document_nodes.Sentence("The rest is the same in all complete runs.")
    yield sections.assumptions(runs)


def _frequent_warnings(runs: xr.Dataset, most: int) -> document_nodes.Nodes:
    """The most frequent warnings, each with how many runs have it."""
    if "warnings" not in runs:
        return
    lines = Counter(line for text in runs.warnings.values for line in str(text).splitlines())
    of = str(runs.sizes["run"])
    for line, n in lines.most_common(most):
        yield document_nodes.warning("{} ({} of {} runs)", [line, str(n), of])
    if len(lines) > most:
        yield document_nodes.Sentence(
            "{} more warnings are in the report.", [str(len(lines) - most)]
        )


def _describe_convergence(runs: xr.Dataset) -> document_nodes.Nodes:
    yield document_nodes.Sentence(
        "Intervals are over seeds alone. hydrosim analyse --converge compares steps and methods for"
        " the case."
    )
    yield from _measured_errors(runs)
    if "energy_residual_relative" in runs:
        worst = document_nodes.Value(float(runs.energy_residual_relative.max()), digits=2)
        rows = [
            (
                "largest residual of an energy balance",
                worst,
                document_nodes.Value(MAX_RESIDUAL_FRACTION, digits=2),
            )
        ]
        yield document_nodes.Table(("evidence", "found", "warned of beyond"), rows)


def _measured_errors(runs: xr.Dataset) -> document_nodes.Nodes:
    """Errors of motions by the steps of the solver, with the values of the runs that measured
    them."""
    measured = np.flatnonzero(runs[RELATIVE].notnull()) if RELATIVE in runs else np.zeros(0, int)
    if measured.size == 0:
        yield document_nodes.Sentence("No run measured the error by the steps of the solver.")
        return
    plans = effects.plans(runs) if DESIGN in runs.attrs else []
    axes = dict.fromkeys(plan.axis(p) for plan in plans for p in plan.parameters)
    runs = with_keys(runs)
    names = [name for name in ("seed", *axes) if name in runs and runs[name].dims == ("run",)]
    rows: list[document_nodes.Row] = []
    for run in measured:
        values = [str(runs[name].values[run]) for name in names]
        rows.append(
            [str(run), *values, document_nodes.Value(float(runs[RELATIVE].values[run]), digits=1)]
        )
    head = ("run", *map(statistics.short_key, names), "error of motions, of their range")
    yield document_nodes.Table(
        head, rows, "Errors by the steps of the solver, in runs that measured them"
    )
    yield document_nodes.Sentence(
        "A run has a warning beyond {}.", [document_nodes.Value(reported_beyond(runs), digits=1)]
    )


def _shorten_list(items: list[document_nodes.Sentence]) -> list[document_nodes.Sentence]:
    more = len(items) - sections.MAX_TABLE_ROWS
    if more <= 0:
        return items
    return [
        *items[: sections.MAX_TABLE_ROWS],
        document_nodes.Sentence("{} more are in the result file.", [str(more)]),
    ]


STUDY_SECTIONS: sections.Sections[xr.Dataset] = {
    "outcome": ("Outcome", _describe_outcome),
    "results": ("What parameters do", _describe_results),
    "case": ("Case", _describe_case),
    "assumptions": ("Assumptions and warnings", _study_assumptions),
    "convergence": ("Convergence", _describe_convergence),
}
"""Sections by name: the heading, and what gives the nodes below it."""
