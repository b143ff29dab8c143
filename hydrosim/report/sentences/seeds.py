"""Runs that differ in their seeds alone: where each motion lies, and extremes over seeds of every
channel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import xarray as xr

from hydrosim.files.display_units import units_of
from hydrosim.files.document_layout import text_of, value_text
from hydrosim.files.document_nodes import Between, Cell, Node, Sentence, Table, Value
from hydrosim.report.sentences.sections import MAX_TABLE_ROWS
from hydrosim.results.phases import FIGURES, STAGE_TIME
from hydrosim.statistics.effects import PlanRuns, combinations, seed_spread
from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY, VALUES_FOR_INTERVAL
from hydrosim.statistics.over_seeds import (
    GUMBEL_METHOD,
    MIN_RUNS,
    SeedExtremes,
    SmallestAndLargest,
    ends_of_channels,
    ends_of_figures,
    ends_of_motions,
    find_extremes,
)

MAX_COMBINATIONS = 5
"""Combinations of parameters that are shown."""
CLEARANCE_FIGURE = FIGURES["end_clearance"][0]
"""The only result of stages that may be negative."""
VARIED_COORDINATE = "varied"
"""Coordinate of runs: the parameter that is varied, one at a time."""
EXTREMES_METHOD_NOTE = (
    f"Intervals hold 90 %, over {MIN_RUNS} seeds or more. Where maxima follow Gumbel's law they are"
    " by it; else by the order of the runs, without a law."
)


def seed_nodes(plan: PlanRuns) -> Iterator[Node]:
    """Extremes over the seeds of each combination of the parameters of a plan without figures."""
    yield Sentence(EXTREMES_METHOD_NOTE, detail=True)
    plan_combinations = list(combinations(plan))
    for values, at in plan_combinations[:MAX_COMBINATIONS]:
        of = plan.runs.isel(run=at)
        title = named_values(plan, values)
        yield from nodes_over_seeds(of, f"{title or 'All'}: {at.size} runs")
    if len(plan_combinations) > MAX_COMBINATIONS:
        more = str(len(plan_combinations) - MAX_COMBINATIONS)
        yield Sentence("{} more combinations are in motion, in the file.", [more])


def extreme_nodes(plan: PlanRuns) -> Iterator[Node]:
    """Extremes over the seeds of figures, and of every other channel of the file."""
    plan_combinations = list(combinations(plan))
    if max((at.size for _, at in plan_combinations), default=0) < MIN_RUNS:
        text = "Most probable extremes and P90 over seeds take {} seeds or more."
        yield Sentence(text, [str(MIN_RUNS)], detail=True)
        return
    figures: list[list[Cell]] = []
    channels: list[list[Cell]] = []
    for k, (values, at) in enumerate(plan_combinations):
        of = plan.runs.isel(run=at)
        name = named_values(plan, values) or "all"
        figures += [[name, *row] for row in _rows(ends_of_figures(of, plan.figures))]
        if k < MAX_COMBINATIONS:
            channels += [
                [name, *row] for row in _rows([*ends_of_motions(of), *ends_of_channels(of)])
            ]
    yield from _tables("figure", figures, of=True)
    yield from _tables("channel", channels, of=True, detail=True)
    if figures or channels:
        yield Sentence(EXTREMES_METHOD_NOTE, detail=True)


def _tables(
    what: str, rows: list[list[Cell]], of: bool = False, detail: bool = False
) -> Iterator[Node]:
    """Two tables of extremes, of rows that begin with a name and a side; with ``of``, with what
    they are of before these."""
    if not rows:
        return
    begin = (*(("of",) if of else ()), what, "side")
    n = len(begin)
    title = "The most probable extreme of a run, and where the extreme of another run lies"
    head = (*begin, "most probable", "interval", "another run")
    yield Table(head, [row[: n + 3] for row in rows[:MAX_TABLE_ROWS]], title, detail)
    title = "P90: 90 % of runs do not exceed this largest value, or do not fall below this smallest"
    shortened = [[*row[:n], *row[n + 3 :]] for row in rows[:MAX_TABLE_ROWS]]
    yield Table((*begin, "P90", "interval", "by"), shortened, title, detail)


def nodes_over_seeds(runs: xr.Dataset, title: str = "") -> Iterator[Node]:
    """Between which values each motion is, extremes of another run, stages over runs."""
    head = ("motion", "smallest", "largest")
    moving = list(ends_of_motions(runs))
    ends: list[list[Cell]] = [
        [
            motion.name,
            Value(np.min(motion.low), motion.unit),
            Value(np.max(motion.high), motion.unit),
        ]
        for motion in moving
        if motion.low is not None and motion.high is not None
    ]
    yield Table(head, ends, title)
    yield from _tables("channel", _rows([*moving, *ends_of_channels(runs)]))
    if stages := list(_stages(runs)):
        yield Table(("stage or figure", "group", "mean", "interval", "all runs", "runs"), stages)


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


def value_of(value: object, unit: str) -> Value | str:
    """A value of a parameter: a number in its unit, or words."""
    return Value(value, unit, 6) if isinstance(value, float) else value_text(value)


def _rows(ends: Iterable[SmallestAndLargest]) -> list[list[Cell]]:
    """Extremes of channels that enough runs have values of."""
    return [row for ends in ends for row in _extremes(ends)]


def _extremes(ends: SmallestAndLargest) -> Iterator[list[Cell]]:
    """Of the smallest and of the largest value of each run."""
    for side, extreme in find_extremes(ends):
        yield [ends.name, side, *_cells(extreme, ends.unit)]


def _cells(extreme: SeedExtremes, unit: str) -> list[Cell]:
    return [
        Value(extreme.probable, unit),
        Between(*extreme.interval, unit),
        Between(*extreme.another, unit),
        Value(extreme.p90, unit),
        Between(*extreme.p90_interval, unit),
        _method(extreme),
    ]


def _method(extreme: SeedExtremes) -> str:
    """The law, or the order of the runs and what their interval of another run holds."""
    if extreme.method == GUMBEL_METHOD:
        return GUMBEL_METHOD
    held = f"interval of another run holds {100.0 * extreme.probability:.0f} %"
    more = (
        ""
        if extreme.probability >= INTERVAL_PROBABILITY
        else f"; with {VALUES_FOR_INTERVAL} runs it would hold 90 %"
    )
    return f"{extreme.method} ({held}{more})"


def _stages(runs: xr.Dataset) -> Iterator[list[Cell]]:
    """Stages and figures of each group over runs: mean with its interval, and their range."""
    for name in runs.contact_group.values if STAGE_TIME in runs else ():
        of = runs.sel(contact_group=name)
        stages = {str(s): of[STAGE_TIME].sel(stage=s) for s in of.stage.values}
        for what, values in {**stages, **{FIGURES[f][0]: of[f] for f in FIGURES}}.items():
            finite = values.values[np.isfinite(values.values)]
            if finite.size and np.ptp(finite) > 0.0:
                at = seed_spread(finite, -np.inf if what == CLEARANCE_FIGURE else 0.0)
                unit = str(values.attrs["units"])
                ends = Between(at.low, at.high, unit), Between(finite.min(), finite.max(), unit)
                yield [what, str(name), Value(at.mean, unit), *ends, str(finite.size)]
