"""Several figures of all plans of a study in one table: a row for each value, a column for each
figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hydrosim.presentation.document import Cell, Node, Sentence, Table, Value
from hydrosim.statistics import effects
from hydrosim.statistics.effects import SAMPLED_DESIGNS, EffectRow, PlanRuns
from hydrosim.wording.sections import MAX_TABLE_ROWS
from hydrosim.wording.seeds import named_values

MIN_FIGURES = 2
"""Figures, from which on there is one table of all."""
METHOD_NOTE = (
    "Means over seeds, and half of their 90 % intervals. Figures are of all complete runs."
)


def has_results_table(plan: PlanRuns) -> bool:
    """Whether a plan is in the one table of its study."""
    return plan.design not in SAMPLED_DESIGNS and len(plan.figures) >= MIN_FIGURES


def results_table(plans: Sequence[PlanRuns]) -> Iterator[Node]:
    """All figures at all values of the plans; nothing where a plan has a single figure."""
    own = [plan for plan in plans if has_results_table(plan)]
    if not own:
        return
    figures = own[0].figures
    several = len(plans) > 1
    columns = [name for figure in figures for name in (figure, "±")]
    head = (*(("study",) if several else ()), "value", *columns, "runs")
    rows = [row for plan in own for row in _of_plan(plan, figures, several)]
    yield Table(head, rows[:MAX_TABLE_ROWS], "All figures")
    yield Sentence(METHOD_NOTE)
    for name in figures:
        text = str(own[0].runs[name].attrs.get("long_name", ""))
        yield Sentence("{}: {}.", [name, text], detail=True)


def _of_plan(plan: PlanRuns, figures: Sequence[str], several: bool) -> Iterator[list[Cell]]:
    found: dict[str, dict[str, EffectRow]] = {}
    for row in effects.rows(plan):
        found.setdefault(named_values(plan, row.values) or "all", {})[row.figure] = row
    for name, by_figure in found.items():
        runs = max(row.spread.n for row in by_figure.values())
        study: list[Cell] = [plan.name.replace("_", " ")] if several else []
        cells = [cell for figure in figures for cell in _cells(by_figure[figure])]
        yield [*study, name, *cells, str(runs)]


def _cells(row: EffectRow) -> tuple[Cell, Cell]:
    """A mean, and half of its interval; nothing where no run has a value."""
    of = row.spread
    if not of.n:
        return "none", ""
    half = 0.5 * (of.high - of.low)
    return Value(of.mean, row.unit), Value(half, row.unit, 2) if np.isfinite(half) else ""
