"""The table of a study as comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Hashable, Iterator, Mapping

import xarray as xr

from hydrosim.documents.text import escape_unprintable
from hydrosim.presentation.units import Units, units_of
from hydrosim.statistics import effects
from hydrosim.statistics.criteria import JudgedCriterion, judge_plan
from hydrosim.statistics.effects import EffectRow, PlanRuns
from hydrosim.statistics.ends import ends_of_figures
from hydrosim.statistics.over_seeds import find_extremes

MEAN_COLUMNS = ("runs", "mean", "mean_low", "mean_high", "another_low", "another_high")
EXTREME_COLUMNS = (
    *("most_probable", "most_probable_low", "most_probable_high"),
    *("p90", "p90_low", "p90_high", "by"),
)
"""Extremes over seeds, of figures that are the largest or the smallest value of a run."""
CRITERION_COLUMNS = ("worst", "limit", "margin", "runs_met", "met", "source")
"""What a criterion comes to: the value of the worst run, and how many runs meet the limit."""


def as_csv(runs: xr.Dataset) -> str:
    """Text with a line for each figure of each plan at each combination of values, in the units of
    the study."""
    units = units_of(runs.attrs)
    plans = effects.plans(runs)
    each = [(plan, row) for plan in plans for row in effects.rows(plan)]
    judged = {_key(j.plan, j.worst.name, j.values): j for p in plans for j in judge_plan(p)}
    names = {name: plan for plan, row in reversed(each) for name in row.values}
    names = {name: names[name] for name in dict.fromkeys(n for _, row in each for n in row.values)}
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    heads = (_head(name, plan, units) for name, plan in names.items())
    table.writerow(
        [
            "study",
            *map(escape_unprintable, heads),
            "figure",
            "unit",
            *MEAN_COLUMNS,
            *EXTREME_COLUMNS,
            *CRITERION_COLUMNS,
        ]
    )
    for plan, row in each:
        cells = _cells(plan, row, list(names), units)
        found = judged.get(_key(plan, row.figure, row.values))
        row_cells = [*cells, *_criterion(found, units)]
        table.writerow([escape_unprintable(x) if isinstance(x, str) else x for x in row_cells])
    return text.getvalue()


def _key(plan: PlanRuns, figure: str, values: Mapping[str, object]) -> Hashable:
    return (plan.name, figure, *values.values())


def _criterion(of: JudgedCriterion | None, units: Units) -> list[str]:
    """What a criterion comes to at values of the parameters; empty for other figures."""
    if of is None:
        return ["" for _ in CRITERION_COLUMNS]
    worst = of.worst
    factor = units.display_unit(worst.unit).factor
    numbers = (f"{factor * x:.6g}" for x in (worst.value, worst.limit, worst.margin))
    return [*numbers, str(of.met), "yes" if of.is_met else "no", worst.source]


def _head(name: str, plan: PlanRuns, units: Units) -> str:
    unit = units.display_unit(plan.unit(name)).unit
    return f"{name} [{unit}]" if unit else name


def _cells(plan: PlanRuns, row: EffectRow, names: list[str], units: Units) -> Iterator[str]:
    yield row.plan
    for name in names:
        value = row.values.get(name, "")
        factor = units.display_unit(plan.unit(name)).factor if name in row.values else 1.0
        yield f"{factor * value:.9g}" if isinstance(value, float) else str(value)
    unit, factor = units.display_unit(row.unit)
    yield from (row.figure, unit, str(row.spread.n))
    yield from (f"{factor * value:.6g}" for value in row.spread[1:])
    yield from _extremes(plan, row, factor)


def _extremes(plan: PlanRuns, row: EffectRow, factor: float) -> list[str]:
    """Most probable extreme and P90 with their intervals; empty where there are none."""
    own = ends_of_figures(plan.runs.isel(run=row.runs), [row.figure])
    found = [extremes for ends in own for _, extremes in find_extremes(ends)]
    if not found:
        return ["" for _ in EXTREME_COLUMNS]
    one = found[0]
    numbers = (one.probable, *one.interval, one.p90, *one.p90_interval)
    return [*(f"{factor * number:.6g}" for number in numbers), one.method]
