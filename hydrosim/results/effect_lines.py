"""Tables of a study as text, and as comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence

import xarray as xr

from hydrosim.results import effects
from hydrosim.results.effects import DRAWN, Plan, Row

MOST = 60  # rows of a table on the screen
COLUMNS = ("runs", "mean", "mean_low", "mean_high", "another_low", "another_high")


def study_lines(runs: xr.Dataset) -> Iterator[str]:
    """All tables of the study that a file of ``runs`` is of: means with their intervals by value,
    differences, Sobol's indices or correlations. Raises InputError where it is of none."""
    for plan in effects.plans(runs):
        title = f"{plan.name}, {plan.design}" if plan.name else plan.design
        yield f"{title.replace('_', ' ')}: {plan.runs.sizes['run']} runs"
        if not plan.figures:
            yield "  no figures were asked for"
        elif plan.design in DRAWN:
            yield from _of_samples(plan)
        else:
            yield from _of_values(plan)


def as_csv(runs: xr.Dataset) -> str:
    """Each figure of each plan at each combination of values, a line each."""
    rows = [row for plan in effects.plans(runs) for row in effects.rows(plan)]
    names = [*dict.fromkeys(name for row in rows for name in row.values)]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["study", *names, "figure", "unit", *COLUMNS])
    for row in rows:
        values = [row.values.get(name, "") for name in names]
        numbers = [f"{value:.6g}" for value in row.spread]
        table.writerow([row.plan, *values, row.figure, row.unit, *numbers])
    return text.getvalue()


def _of_values(plan: Plan) -> Iterator[str]:
    rows = list(effects.rows(plan))
    yield "  mean with its 90 % interval, and between which values another seed is by 90 %"
    short = {plan.axis(parameter): plan.short(parameter) for parameter in plan.parameters}
    table = [_cells(row, short) for row in rows[:MOST]]
    yield from _aligned(table)
    if len(rows) > MOST:
        yield f"  and {len(rows) - MOST} more, see the file"
    for each in effects.differences(plan) if _differs(plan) else ():
        at = each.spread
        yield (
            f"  d {each.figure} / d {plan.short(each.parameter)}, {each.low:g} to {each.high:g}:"
            f" {at.mean:.3g} ({at.low:.3g} to {at.high:.3g}) {each.unit}, std over {at.n} seeds"
            f" {each.std:.2g}; contacts went another way in {each.changed:.0%} of them"
        )


def _differs(plan: Plan) -> bool:
    return plan.design == "one_at_a_time" or len(plan.parameters) == 1


def _cells(row: Row, short: Mapping[str, str]) -> list[str]:
    values = [f"{short.get(name, name)} {_value(value)}" for name, value in row.values.items()]
    s = row.spread
    sure = f"({s.low:.3f} to {s.high:.3f})" if s.n > 1 else ""
    another = f"another {s.another_low:.3f} to {s.another_high:.3f}" if s.n > 1 else ""
    head = [", ".join(values) or "all", row.figure]
    return [*head, f"{s.mean:.3f} {row.unit}", sure, another, f"{s.n} runs"]


def _value(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _of_samples(plan: Plan) -> Iterator[str]:
    if plan.design == "sobol_indices":
        yield "  share of the variance alone, and with all others, with 90 % intervals"
        table = [
            [each.figure, each.parameter, *map(_share, (each.first, each.total))]
            for each in effects.indices(plan)
        ]
    else:
        yield "  Spearman's rank correlation"
        table = [[f, p, f"{r:+.2f}"] for f, p, r in effects.correlations(plan)]
    yield from _aligned(table)


def _share(of: tuple[float, float, float]) -> str:
    return f"{of[0]:.2f} ({of[1]:.2f} to {of[2]:.2f})"


def _aligned(table: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for row in table:
        yield "  " + "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
