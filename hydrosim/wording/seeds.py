"""Runs that differ in their seeds alone: where each motion lies, and extremes over seeds of every
channel."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.presentation.document import Between, Cell, Node, Sentence, Table, Value
from hydrosim.presentation.layout import text_of
from hydrosim.presentation.units import units_of
from hydrosim.results.stages import FIGURES, TIME
from hydrosim.statistics.effects import Plan, combinations, spread
from hydrosim.statistics.ends import Ends, of_channels, of_figures, of_motions
from hydrosim.statistics.gumbel import Gumbel, exceeding, fit_maxima, follows_gumbel
from hydrosim.statistics.orders import ENOUGH, find_confidence, find_prediction

RUNS = 8
"""Runs that extremes over seeds take."""
P90 = 0.9
"""Probability that the largest of a run is below."""
SHOWN = 5
"""Combinations of parameters that are shown."""
MOST = 300
"""Rows of a table."""
HOW = (
    f"Intervals hold 90 %, over {RUNS} seeds or more. Where maxima follow Gumbel's law they are by"
    " it; else by the order of the runs, without a law."
)
LAW = "Gumbel's law"
ORDER = "order of the runs"


def seed_nodes(plan: Plan) -> Iterator[Node]:
    """Extremes over the seeds of each combination of the parameters of a plan without figures."""
    yield Sentence(HOW, detail=True)
    each = list(combinations(plan))
    for values, at in each[:SHOWN]:
        of = plan.runs.isel(run=at)
        title = named_values(plan, values)
        yield from nodes_over_seeds(of, f"{title or 'All'}: {at.size} runs")
    if len(each) > SHOWN:
        more = str(len(each) - SHOWN)
        yield Sentence("{} more combinations are in motion, in the file.", [more])


def extreme_nodes(plan: Plan) -> Iterator[Node]:
    """Extremes over the seeds of figures, and of every other channel of the file."""
    each = list(combinations(plan))
    if max((at.size for _, at in each), default=0) < RUNS:
        text = "Most probable extremes and P90 over seeds take {} seeds or more."
        yield Sentence(text, [str(RUNS)], detail=True)
        return
    figures: list[list[Cell]] = []
    channels: list[list[Cell]] = []
    for k, (values, at) in enumerate(each):
        of = plan.runs.isel(run=at)
        name = named_values(plan, values) or "all"
        figures += [[name, *row] for row in _rows(of_figures(of, plan.figures))]
        if k < SHOWN:
            channels += [[name, *row] for row in _rows([*of_motions(of), *of_channels(of)])]
    yield from _tables("figure", figures, of=True)
    yield from _tables("channel", channels, of=True, detail=True)
    if figures or channels:
        yield Sentence(HOW, detail=True)


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
    yield Table(head, [row[: n + 3] for row in rows[:MOST]], title, detail)
    title = "The extreme that 90 % of runs do not exceed"
    each = [[*row[:n], *row[n + 3 :]] for row in rows[:MOST]]
    yield Table((*begin, "P90", "interval", "by"), each, title, detail)


def nodes_over_seeds(runs: xr.Dataset, title: str = "") -> Iterator[Node]:
    """Between which values each motion is, extremes of another run, stages over runs."""
    head = ("motion", "smallest", "largest")
    moving = list(of_motions(runs))
    ends: list[list[Cell]] = [
        [each.name, Value(np.min(each.low), each.unit), Value(np.max(each.high), each.unit)]
        for each in moving
        if each.low is not None and each.high is not None
    ]
    yield Table(head, ends, title)
    yield from _tables("channel", _rows([*moving, *of_channels(runs)]))
    if stages := list(_stages(runs)):
        yield Table(("stage or figure", "group", "mean", "interval", "all runs", "runs"), stages)


def named_values(plan: Plan, values: Mapping[str, object]) -> str:
    """The values of the parameters of runs, in the units that they are read in."""
    units = units_of(plan.runs.attrs)
    read = {key: text_of(value_of(value, plan.unit(key)), units) for key, value in values.items()}
    return ", ".join(f"{short(key)} {value}" for key, value in read.items())


def short(name: str) -> str:
    """The last two words of a key."""
    return " ".join(name.split(".")[-2:]).replace("_", " ")


def value_of(value: object, unit: str) -> Value | str:
    """A value of a parameter: a number in its unit, or words."""
    return Value(value, unit, 6) if isinstance(value, float) else str(value)


def _rows(each: Iterable[Ends]) -> list[list[Cell]]:
    """Extremes of channels that enough runs have values of."""
    return [row for ends in each for row in _extremes(ends)]


def _extremes(ends: Ends) -> Iterator[list[Cell]]:
    """Of the smallest and of the largest value of each run."""
    for side, sign, maxima in ends.sides():
        if maxima.size >= RUNS and np.ptp(maxima) > 0.0:
            law = fit_maxima(maxima)
            follows = follows_gumbel(maxima, law)
            by = _by_law(law, sign) if follows else _by_order(maxima, sign)
            yield [ends.name, side, *_cells(by, ends)]


def _cells(by: Extremes, ends: Ends) -> list[Cell]:
    """The figures, none of them below what the channel can be."""

    def value(x: float) -> Value:
        return Value(max(x, ends.lowest), ends.unit)

    def between(x: tuple[float, float]) -> Between:
        return Between(max(x[0], ends.lowest), max(x[1], ends.lowest), ends.unit)

    p90 = value(by.p90), between(by.p90_interval)
    return [value(by.probable), between(by.interval), between(by.another), *p90, by.method]


class Extremes(NamedTuple):
    """The most probable extreme of a run and P90, each with its interval; the interval of another
    run; by which ``method``."""

    probable: float
    interval: tuple[float, float]
    p90: float
    p90_interval: tuple[float, float]
    another: tuple[float, float]
    method: str


def _by_law(law: Gumbel, sign: float) -> Extremes:
    rare = exceeding(P90)
    return Extremes(
        sign * law.expected(1.0),
        _between(law.confidence(1.0), sign),
        sign * law.expected(rare),
        _between(law.confidence(rare), sign),
        _between(law.prediction(1.0), sign),
        LAW,
    )


def _by_order(maxima: np.ndarray, sign: float) -> Extremes:
    """By order statistics: maxima that are of several kinds (with and without an impact), or that
    something holds, follow no law of extremes."""
    most_probable = np.exp(-1.0)
    held = find_prediction(maxima)
    more = "" if maxima.size >= ENOUGH else f"; {ENOUGH} runs hold 90 %"
    return Extremes(
        sign * float(np.quantile(maxima, most_probable)),
        _between(find_confidence(maxima, most_probable), sign),
        sign * float(np.quantile(maxima, P90)),
        _between(find_confidence(maxima, P90), sign),
        _between((held.low, held.high), sign),
        f"{ORDER} ({100.0 * held.probability:.0f} %{more})",
    )


def _between(ends: Sequence[float] | np.ndarray, sign: float) -> tuple[float, float]:
    """An interval of sign x; an end that so few runs do not bound is infinite."""
    low, high = np.sort(sign * np.asarray(ends))
    return float(low), float(high)


def _stages(runs: xr.Dataset) -> Iterator[list[Cell]]:
    """Stages and figures of each group over runs: mean with its interval, and their range."""
    for name in runs.contact_group.values if TIME in runs else ():
        of = runs.sel(contact_group=name)
        stages = {str(s): of[TIME].sel(stage=s) for s in of.stage.values}
        for what, each in {**stages, **{FIGURES[f][0]: of[f] for f in FIGURES}}.items():
            known = each.values[np.isfinite(each.values)]
            if known.size and np.ptp(known) > 0.0:
                at = spread(known)
                unit = str(each.attrs["units"])
                ends = Between(at.low, at.high, unit), Between(known.min(), known.max(), unit)
                yield [what, str(name), Value(at.mean, unit), *ends, str(known.size)]
