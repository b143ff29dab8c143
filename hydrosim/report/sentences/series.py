"""Why a body moved, and runs over their seeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.files import document_nodes
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_layout import text_of, value_text
from hydrosim.report.sentences.sections import MAX_TABLE_ROWS, title_of
from hydrosim.results import phases
from hydrosim.statistics import explain, over_seeds
from hydrosim.statistics.effects import PlanRuns, combinations, seed_spread
from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY, VALUES_FOR_INTERVAL

if TYPE_CHECKING:
    import xarray as xr

# Why a body moved: figures by span of time; of many runs means with 90 % intervals.

SLIP_ROWS = {
    "mean N in slip": ("slip_mean_load", "N"),
    "mean direction d": ("slip_mean_direction", ""),
    "Cov(N, d)": ("slip_covariance", "N"),
    "mean N, slip towards +": ("load_ahead", "N"),
    "mean N, slip towards -": ("load_astern", "N"),
    "slip towards +": ("slip_ahead", "m"),
    "slip towards -": ("slip_astern", "m"),
}
"""What is said of the slip of a point: the variable and its SI unit."""
CONTACT_MODE_ROWS = {
    "share of time": ("mode_share", "share"),
    "moved": ("mode_moved", "m"),
    "work of friction": ("mode_work", "J"),
}


class ExplainedFigure(NamedTuple):
    """A figure by its name: ``values`` (span,) or (run, span) in an SI ``unit``."""

    name: str
    values: xr.DataArray
    unit: str = ""


def explanation_document(
    run: xr.Dataset, parts: Mapping[str, xr.Dataset], body: str, direction: str
) -> Document:
    """The explanation of a run, or of each combination of parameters of many runs by its name."""
    nodes: list[document_nodes.Node] = []
    for title, explanations in parts.items():
        nodes += [document_nodes.Heading(title)] if title else []
        nodes += explanation(explanations, body, direction)
    return Document(title_of(run), nodes, units=units_of(run.attrs))


def explanation(explanations: xr.Dataset, body: str, direction: str) -> document_nodes.Nodes:
    """The balance of mean forces on a body in a direction; what the friction of each group of
    contacts comes from; how its points slip, and what they do in each mode."""
    explanations = explanations.sel(span=reported_spans(explanations))
    yield _table(
        f"{body} in {direction}", _balance_figures(explanations.sel(body=body, dof=direction))
    )
    if "friction_part" in explanations:
        for group in dict.fromkeys(explanations.fender_group.values.ravel()):
            group_explanations = explanations.sel(
                fender=explanations.fender_group == group,
                direction=explain.DIRECTION_AXES[direction],
            )
            group_explanations = group_explanations.sel(
                span=_spans_of_group(explanations, str(group))
            )
            if group_explanations.friction_part.fillna(0.0).any():
                yield _table(
                    f"mean friction of {group} in {direction}",
                    _friction_figures(group_explanations),
                )
                yield _table(
                    f"mean of the points of {group} in {direction}",
                    _point_figures(group_explanations),
                )
    yield _closing_sentence(explanations)


def _table(title: str, rows: Iterator[ExplainedFigure]) -> document_nodes.Table:
    figures = list(rows)
    spans = explain.stages_with_values(figures[0].values)
    table = [
        [row.name, *(mean_cell(row.values.sel(span=s), row.unit) for s in spans)] for row in figures
    ]
    return document_nodes.Table((title, *spans), table)


def mean_cell(values: xr.DataArray, unit: str) -> document_nodes.Cell:
    """A number, or of many ``run`` their mean and its interval; nothing where there is none."""
    x = np.atleast_1d(values.values)
    x = x[np.isfinite(x)]
    if x.size == 0:
        return ""
    of = seed_spread(x)
    if "run" in values.dims and x.size > 1:
        return document_nodes.Sentence(
            "{} ({})",
            [document_nodes.Value(of.mean, unit), document_nodes.Between(of.low, of.high, unit)],
        )
    return document_nodes.Value(of.mean + 0.0, unit)


def _spans_of_group(explanations: xr.Dataset, group: str) -> list[str]:
    """The spans that are not those of other groups."""
    return [
        s for s in map(str, explanations.span.values) if ": " not in s or s.startswith(f"{group}: ")
    ]


def reported_spans(explanations: xr.Dataset) -> list[str]:
    """All spans but the phases of groups of contacts that go through no operation."""
    there = {
        str(s)
        for s in explanations.span.values
        if explanations.span_end.sel(span=s).notnull().any()
    }
    names = [str(s) for s in explanations.span.values]
    return [
        s
        for s in names
        if _phase_number(s) is None or phases.is_operation(_phases_beside(s, there))
    ]


def _phase_number(span: str) -> int | None:
    """The phase that a span is; none if it is no phase."""
    name = span.rpartition(": ")[2]
    return explain.EXPLAINED_PHASES.index(name) if name in explain.EXPLAINED_PHASES else None


def _phases_beside(span: str, there: set[str]) -> Iterator[int]:
    """The phases of the same group of contacts, among the spans that are ``there``."""
    prefix = span.removesuffix(span.rpartition(": ")[2])
    yield from (
        k for k, phase in enumerate(explain.EXPLAINED_PHASES) if f"{prefix}{phase}" in there
    )


def _balance_figures(explanations: xr.Dataset) -> Iterator[ExplainedFigure]:
    """Times, displacements, mean forces by what exerts them."""
    yield ExplainedFigure("duration", explanations.span_end - explanations.span_begin, "s")
    yield ExplainedFigure("displacement", explanations.displacement, "m")
    for name in explain.significant_entries(explanations.mean_force, "force"):
        yield ExplainedFigure(
            f"mean force, {name.replace('_', ' ')}", explanations.mean_force.sel(force=name), "N"
        )
    yield ExplainedFigure("change of momentum", explanations.momentum_rate, "N")


def _friction_figures(explanations: xr.Dataset) -> Iterator[ExplainedFigure]:
    """Mean friction of a group, by what it comes from."""
    part = explanations.friction_part.sum("fender").where(explanations.span_end.notnull())
    for name in explain.FRICTION_PARTS:
        if name != explain.OTHER or name in explain.significant_entries(part, "part"):
            yield ExplainedFigure(name, part.sel(part=name), "N")
    yield ExplainedFigure("sum", part.sum("part", skipna=False), "N")


def _point_figures(explanations: xr.Dataset) -> Iterator[ExplainedFigure]:
    """How a point of the group slips, on average, and what it does in each mode."""
    for mode in map(str, explanations.contact_mode.values):
        of = explanations.sel(contact_mode=mode)
        for name, (variable, unit) in CONTACT_MODE_ROWS.items():
            yield ExplainedFigure(f"{mode}: {name}", of[variable].mean("fender"), unit)
    for name, (variable, unit) in SLIP_ROWS.items():
        yield ExplainedFigure(name, explanations[variable].mean("fender"), unit)


def _closing_sentence(explanations: xr.Dataset) -> document_nodes.Sentence:
    """How far works and impulses do not add up, the worst of all bodies, spans and runs."""
    missed = float(np.abs(explanations.unbalanced.sel(dof=list(explain.DIRECTION_AXES))).max())
    done = float(np.abs(explanations.force_work).sum(["body", "dof", "force"]).max())
    missing = float(np.abs(explanations.work_missing).max())
    return document_nodes.Sentence(
        "Impulses of all forces add up to the change of momentum, but for a mean force of {}. Works"
        " add up to the change of kinetic energy, but for {} of {}.",
        [
            document_nodes.Value(missed, "N", 1),
            document_nodes.Value(missing, "J", 2),
            document_nodes.Value(done, "J", 2),
        ],
        detail=True,
    )


# Runs that differ in their seeds alone: ranges of motions, extremes of channels.

MAX_COMBINATIONS = 5
"""Combinations of parameters that are shown."""
CLEARANCE_FIGURE = phases.FIGURES["end_clearance"][0]
"""The only result of stages that may be negative."""
VARIED_COORDINATE = "varied"
"""Coordinate of runs: the parameter that is varied, one at a time."""
EXTREMES_METHOD_NOTE = (
    f"Intervals hold 90 %, over {over_seeds.MIN_RUNS} seeds or more. Where maxima"
    " follow Gumbel's law they are"
    " by it; else by the order of the runs, without a law."
)


def seed_nodes(plan: PlanRuns) -> document_nodes.Nodes:
    """Extremes over the seeds of each combination of the parameters of a plan without figures."""
    yield document_nodes.Sentence(EXTREMES_METHOD_NOTE, detail=True)
    plan_combinations = list(combinations(plan))
    for values, at in plan_combinations[:MAX_COMBINATIONS]:
        of = plan.runs.isel(run=at)
        title = named_values(plan, values)
        yield from nodes_over_seeds(of, f"{title or 'All'}: {at.size} runs")
    if len(plan_combinations) > MAX_COMBINATIONS:
        more = str(len(plan_combinations) - MAX_COMBINATIONS)
        yield document_nodes.Sentence("{} more combinations are in motion, in the file.", [more])


def extreme_nodes(plan: PlanRuns) -> document_nodes.Nodes:
    """Extremes over the seeds of figures, and of every other channel of the file."""
    plan_combinations = list(combinations(plan))
    if max((at.size for _, at in plan_combinations), default=0) < over_seeds.MIN_RUNS:
        text = "Most probable extremes and P90 over seeds take {} seeds or more."
        yield document_nodes.Sentence(text, [str(over_seeds.MIN_RUNS)], detail=True)
        return
    figures: list[document_nodes.Row] = []
    channels: list[document_nodes.Row] = []
    for k, (values, at) in enumerate(plan_combinations):
        of = plan.runs.isel(run=at)
        name = named_values(plan, values) or "all"
        figures += [
            [name, *row]
            for row in _extremes_over_runs(over_seeds.ends_of_figures(of, plan.figures))
        ]
        if k < MAX_COMBINATIONS:
            channels += [
                [name, *row]
                for row in _extremes_over_runs(
                    [*over_seeds.ends_of_motions(of), *over_seeds.ends_of_channels(of)]
                )
            ]
    yield from _extreme_tables("figure", figures, of=True)
    yield from _extreme_tables("channel", channels, of=True, detail=True)
    if figures or channels:
        yield document_nodes.Sentence(EXTREMES_METHOD_NOTE, detail=True)


def _extreme_tables(
    what: str, rows: list[document_nodes.Row], of: bool = False, detail: bool = False
) -> document_nodes.Nodes:
    """Two tables of extremes, of rows that begin with a name and a side; with ``of``, with what
    they are of before these."""
    if not rows:
        return
    begin = (*(("of",) if of else ()), what, "side")
    n = len(begin)
    title = "The most probable extreme of a run, and where the extreme of another run lies"
    head = (*begin, "most probable", "interval", "another run")
    yield document_nodes.Table(head, [row[: n + 3] for row in rows[:MAX_TABLE_ROWS]], title, detail)
    title = "P90: 90 % of runs do not exceed this largest value, or do not fall below this smallest"
    shortened = [[*row[:n], *row[n + 3 :]] for row in rows[:MAX_TABLE_ROWS]]
    yield document_nodes.Table((*begin, "P90", "interval", "by"), shortened, title, detail)


def nodes_over_seeds(runs: xr.Dataset, title: str = "") -> document_nodes.Nodes:
    """Between which values each motion is, extremes of another run, stages over runs."""
    head = ("motion", "smallest", "largest")
    moving = list(over_seeds.ends_of_motions(runs))
    ends: list[document_nodes.Row] = [
        [
            motion.name,
            document_nodes.Value(np.min(motion.low), motion.unit),
            document_nodes.Value(np.max(motion.high), motion.unit),
        ]
        for motion in moving
        if motion.low is not None and motion.high is not None
    ]
    yield document_nodes.Table(head, ends, title)
    yield from _extreme_tables(
        "channel", _extremes_over_runs([*moving, *over_seeds.ends_of_channels(runs)])
    )
    if stages := list(_stage_rows(runs)):
        yield document_nodes.Table(
            ("stage or figure", "group", "mean", "interval", "all runs", "runs"), stages
        )


def named_values(plan: PlanRuns, values: Mapping[str, object]) -> str:
    """The values of the parameters of runs, in the units that they are read in; of one parameter at
    a time, the one that is varied."""
    varied = str(values.get(VARIED_COORDINATE, ""))
    if VARIED_COORDINATE in values and not varied:
        return "the case"
    names = [plan.axis(varied)] if varied else [*values]
    units = units_of(plan.runs.attrs)
    read = {name: text_of(value_of(values[name], plan.unit(name)), units) for name in names}
    return ", ".join(f"{short_key(name)} {value}" for name, value in read.items())


def short_key(name: str) -> str:
    """The last two words of a key."""
    return " ".join(name.split(".")[-2:]).replace("_", " ")


def value_of(value: object, unit: str) -> document_nodes.Value | str:
    """A value of a parameter: a number in its unit, or words."""
    return document_nodes.Value(value, unit, 6) if isinstance(value, float) else value_text(value)


def _extremes_over_runs(
    ends: Iterable[over_seeds.SmallestAndLargest],
) -> list[document_nodes.Row]:
    """Extremes of channels that enough runs have values of."""
    return [row for ends in ends for row in _extreme_rows(ends)]


def _extreme_rows(ends: over_seeds.SmallestAndLargest) -> Iterator[document_nodes.Row]:
    """Of the smallest and of the largest value of each run."""
    for side, extreme in over_seeds.find_extremes(ends):
        yield [ends.name, side, *_extreme_cells(extreme, ends.unit)]


def _extreme_cells(extreme: over_seeds.SeedExtremes, unit: str) -> document_nodes.Row:
    return [
        document_nodes.Value(extreme.probable, unit),
        document_nodes.Between(*extreme.interval, unit),
        document_nodes.Between(*extreme.another, unit),
        document_nodes.Value(extreme.p90, unit),
        document_nodes.Between(*extreme.p90_interval, unit),
        _method_text(extreme),
    ]


def _method_text(extreme: over_seeds.SeedExtremes) -> str:
    """The law, or the order of the runs and what their interval of another run holds."""
    if extreme.method == over_seeds.GUMBEL_METHOD:
        return over_seeds.GUMBEL_METHOD
    held = f"interval of another run holds {100.0 * extreme.probability:.0f} %"
    more = (
        ""
        if extreme.probability >= INTERVAL_PROBABILITY
        else f"; with {VALUES_FOR_INTERVAL} runs it would hold 90 %"
    )
    return f"{extreme.method} ({held}{more})"


def _stage_rows(runs: xr.Dataset) -> Iterator[document_nodes.Row]:
    """Stages and figures of each group over runs: mean with its interval, and their range."""
    for name in runs.contact_group.values if phases.STAGE_TIME in runs else ():
        of = runs.sel(contact_group=name)
        stages = {str(s): of[phases.STAGE_TIME].sel(stage=s) for s in of.stage.values}
        for what, values in {
            **stages,
            **{phases.FIGURES[f][0]: of[f] for f in phases.FIGURES},
        }.items():
            finite = values.values[np.isfinite(values.values)]
            if finite.size and np.ptp(finite) > 0.0:
                at = seed_spread(finite, -np.inf if what == CLEARANCE_FIGURE else 0.0)
                unit = str(values.attrs["units"])
                ends = (
                    document_nodes.Between(at.low, at.high, unit),
                    document_nodes.Between(finite.min(), finite.max(), unit),
                )
                yield [
                    what,
                    str(name),
                    document_nodes.Value(at.mean, unit),
                    *ends,
                    str(finite.size),
                ]
