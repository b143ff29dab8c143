"""Tables of a study as text, and as comma-separated values."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from math import floor, isnan, log10

import xarray as xr

from hydrosim.statistics import effects
from hydrosim.statistics.effects import DRAWN, Difference, Plan, Row

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
    units = {name: plan.unit(name) for name in short}
    table = [_cells(row, short, units) for row in rows[:MOST]]
    yield from _aligned(table)
    if len(rows) > MOST:
        yield f"  and {len(rows) - MOST} more, see the file"
    for each in effects.differences(plan) if _differs(plan) else ():
        yield "  " + _difference(plan, each)


def _difference(plan: Plan, of: Difference) -> str:
    """A slope in words; its interval where there are seeds to have one of, what contacts did where
    there are contacts."""
    at, ends = of.spread, f"{of.low:g} to {of.high:g}"
    text = f"d {of.figure} / d {plan.short(of.parameter)}, {ends}: "
    if not at.n:
        return text + "no seed has a value at both"
    if at.n == 1:
        text += f"{at.mean:.3g} {of.unit}, of one run at each"
    else:
        sure = f"({at.low:.3g} to {at.high:.3g})"
        text += f"{at.mean:.3g} {sure} {of.unit}, std over {at.n} seeds {of.std:.2g}"
    return text if isnan(of.changed) else f"{text}; contacts went another way in {of.changed:.0%}"


def _differs(plan: Plan) -> bool:
    return plan.design == "one_at_a_time" or len(plan.parameters) == 1


def _cells(row: Row, short: Mapping[str, str], units: Mapping[str, str]) -> list[str]:
    values = [
        f"{short.get(name, name)} {_value(value)} {units.get(name, '')}".rstrip()
        for name, value in row.values.items()
    ]
    s = row.spread
    head = [", ".join(values) or "all", row.figure]
    if not s.n:
        return [*head, "no run has a value", "", "", "0 runs"]
    shown = [""] if s.n == 1 else _alike(s.mean, s.low, s.high, s.another_low, s.another_high)
    mean = f"{s.mean:.4g}" if s.n == 1 else shown[0]
    sure = f"({shown[1]} to {shown[2]})" if s.n > 1 else ""
    another = f"another {shown[3]} to {shown[4]}" if s.n > 1 else ""
    return [*head, f"{mean} {row.unit}", sure, another, f"{s.n} run{'s' if s.n > 1 else ''}"]


def _alike(*numbers: float) -> list[str]:
    """Numbers with one number of decimals, of which the largest has four digits or more; as powers
    of ten where they are very large or small."""
    most = max(map(abs, numbers))
    if most and not 1e-3 <= most < 1e7:
        return [f"{number:.3e}" for number in numbers]
    decimals = max(0, 3 - floor(log10(most))) if most else 3
    return [f"{number:.{min(decimals, 6)}f}" for number in numbers]


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
