"""Extremes over seeds with intervals (most probable, P90), ends of channels, and tables of studies.

Maxima that follow Gumbel's law are told by it. Others are told by their order: maxima of several
kinds (with and without an impact), or that something holds, follow no law of extremes.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.files.display_units import Units, unit_of_dof, units_of
from hydrosim.files.series import unit_of
from hydrosim.files.text import escape_unprintable
from hydrosim.results.channels import lowest_value
from hydrosim.results.dataset import KIND, ResultKind
from hydrosim.results.phases import FIGURES
from hydrosim.results.runs_file import KEY, RUN
from hydrosim.results.validation import DESIGN
from hydrosim.results.variables import LABELS, LOADS, OF_CHANNEL, quantity_attributes
from hydrosim.statistics import effects, gumbel
from hydrosim.statistics.effects import EffectRow, PlanRuns, combinations, plans
from hydrosim.statistics.figures import SIDE_ATTRIBUTE, JudgedCriterion, judge_plan
from hydrosim.statistics.results import LARGEST_RESULTS, LOWEST_ATTRIBUTE
from hydrosim.statistics.statistics import CHANNEL_VARIABLES, EXTREME_SIDES, NAMED_CHANNELS

# Ends: smallest and largest value of every channel in each run of a study.

FORCE_DIMS = {f"{dim}_force": dim for dim in LOADS}
"""Statistics of forces, and the dimension of what they are of."""
SUMMARISED_SERIES = {variable for variable, *_ in CHANNEL_VARIABLES.values()}
"""Variables over time that have statistics of their own."""
MAX_SERIES_SIZE = 50_000_000
"""Values of a variable over time: of more, extremes are not looked for."""


class SmallestAndLargest(NamedTuple):
    """The smallest and the largest value (n,) of each run that has some, of a channel with an SI
    ``unit`` that is never below ``lowest``; of a figure one of them is None."""

    name: str
    unit: str
    low: np.ndarray | None
    high: np.ndarray | None
    lowest: float = -np.inf

    def sides(self) -> Iterator[tuple[str, float, np.ndarray]]:
        """What is known of its sides: name, sign, and the values times that sign."""
        for side, sign, values in zip(
            EXTREME_SIDES, (-1.0, 1.0), (self.low, self.high), strict=True
        ):
            if values is not None:
                yield side, sign, sign * values


def ends_of_motions(runs: xr.Dataset) -> Iterator[SmallestAndLargest]:
    """Of each motion that there is."""
    for body in map(str, runs.body.values):
        for dof in map(str, runs.dof.values):
            motion = runs.motion.sel(body=body, dof=dof)
            unit = unit_of_dof(dof)
            yield from _ends_if_moving(f"{body} {dof}", unit, motion)


def ends_of_channels(runs: xr.Dataset) -> Iterator[SmallestAndLargest]:
    """Of the wave, of each contact point and line, of results of contacts, of channels that are
    asked for, and of what is kept over time."""
    if "wave" in runs:
        yield from _ends_if_moving("wave elevation", "m", runs.wave)
    for name, dim in FORCE_DIMS.items():
        for label in runs[dim].values.tolist() if name in runs else []:
            title = f"{name.replace('_', ' ')} {label}"
            yield from _ends_if_moving(title, "N", runs[name].sel({dim: label}), 0.0)
    for name in LARGEST_RESULTS:
        for group in runs.contact_group.values.tolist() if name in runs else []:
            values = _finite_values(runs[name].sel(contact_group=group).values)
            title = f"{FIGURES[name][0]}, {group}"
            yield SmallestAndLargest(title, FIGURES[name][1], None, values, 0.0)
    for name in runs.channel.values.tolist() if NAMED_CHANNELS in runs else []:
        unit = str(runs["unit"].sel(channel=name).values)
        yield from _ends_if_moving(
            name, unit, runs[NAMED_CHANNELS].sel(channel=name), lowest_value(name)
        )
    yield from _ends_of_series(runs)


def ends_of_figures(runs: xr.Dataset, figures: list[str]) -> Iterator[SmallestAndLargest]:
    """Of the figures that are the largest or the smallest of something."""
    for name in figures:
        side = runs[name].attrs.get(SIDE_ATTRIBUTE)
        values = _finite_values(runs[name].values)
        unit = str(runs[name].attrs.get("units", ""))
        lowest = float(runs[name].attrs.get(LOWEST_ATTRIBUTE, -np.inf))
        if side == EXTREME_SIDES[0]:
            yield SmallestAndLargest(name, unit, values, None, lowest)
        elif side == EXTREME_SIDES[1]:
            yield SmallestAndLargest(name, unit, None, values, lowest)


def _ends_if_moving(
    name: str, unit: str, of: xr.DataArray, lowest: float = -np.inf
) -> Iterator[SmallestAndLargest]:
    """A channel by its statistics (run, statistic), if it changes."""
    figures = of.transpose(RUN, "statistic").dropna(RUN, how="all")
    if figures.sizes[RUN] and float(figures.sel(statistic="std").max()) > 0.0:
        low, high = (figures.sel(statistic=side).values for side in EXTREME_SIDES)
        yield SmallestAndLargest(name, unit, low, high, lowest)


def _ends_of_series(runs: xr.Dataset) -> Iterator[SmallestAndLargest]:
    """Of variables that are kept over time, from the start of statistics on."""
    late = runs.time.values >= float(runs.attrs.get("start", 0.0)) if "time" in runs else []
    for name, variable in runs.data_vars.items():
        if (
            "time" not in variable.dims
            or str(name) in SUMMARISED_SERIES
            or variable.size > MAX_SERIES_SIZE
        ):
            continue
        if RUN not in variable.dims or variable.dtype.kind != "f":
            continue
        late_values = variable.isel(time=late)
        low, high = late_values.min("time"), late_values.max("time")
        dims = [dim for dim in low.dims if dim != RUN]
        for labels in product(*(low[dim].values for dim in dims)):
            of = [str(label) for label in labels]
            at = dict(zip(dims, labels, strict=True))
            ends = _finite_values(low.sel(at).values), _finite_values(high.sel(at).values)
            if ends[0].size and np.ptp(np.concatenate(ends)) > 0.0:
                unit = unit_of(variable.attrs, of)
                yield SmallestAndLargest(
                    ".".join([str(name), *of]), unit, *ends, lowest_value(str(name))
                )


def _finite_values(values: np.ndarray) -> np.ndarray:
    return values[np.isfinite(values)]


MIN_RUNS = 8
"""Runs that extremes over seeds take."""
P90 = 0.9
"""Probability that the largest of a run is below, or that the smallest is above."""
GUMBEL_METHOD = "Gumbel's law"
ORDER_METHOD = "order of the runs"
EXTREME_DIM = "extreme"
COPIED_ATTRIBUTES = ("long_name", "units")
"""Attributes of parameters that columns take over."""


class SeedExtremes(NamedTuple):
    """The most probable extreme of a run and P90, each with its interval; the interval of another
    run, which holds it with a ``probability``; by which ``method``, from so many ``runs``. Of
    smallest values, 90 % of runs do not fall below P90."""

    probable: float
    interval: tuple[float, float]
    p90: float
    p90_interval: tuple[float, float]
    another: tuple[float, float]
    probability: float
    method: str
    runs: int


def find_extremes(ends: SmallestAndLargest) -> Iterator[tuple[str, SeedExtremes]]:
    """Of the smallest and of the largest value of each run: name of the side and extremes, none
    below what the channel can be. Sides of fewer than `MIN_RUNS` runs, or of equal values, have
    none."""
    for side, sign, maxima in ends.sides():
        if maxima.size >= MIN_RUNS and np.ptp(maxima) > 0.0:
            law = gumbel.fit_maxima(maxima)
            follows = gumbel.fits_gumbel(maxima, law)
            extreme = _extreme_by_law(law, sign) if follows else _extreme_by_order(maxima, sign)
            yield side, _raise_to_lowest(extreme, ends.lowest)


def extremes_over_seeds(runs: xr.Dataset) -> xr.Dataset:
    """Extremes of every motion, channel and figure in a dataset of many runs, in SI units.

    Rows are along ``extreme``: ``channel``, ``side`` ("smallest" or "largest"), ``unit``, values of
    the parameters of the study, and the number of ``runs``. ``to_dataframe()`` gives a table.
    Intervals hold 90 %; the interval of another run holds ``another_probability``. Raises
    InputError if no combination of parameters has `MIN_RUNS` runs.
    """
    rows = [
        row
        for values, group_runs in _runs_by_parameters(runs)
        for row in _series_rows(values, group_runs)
    ]
    if not rows:
        most = max(group_runs.sizes["run"] for _, group_runs in _runs_by_parameters(runs))
        raise InputError(
            f"found no channel with different extremes in {MIN_RUNS} runs of one combination of"
            f" parameters, of which there are at most {most}; run more seeds."
        )
    names = {of.attrs.get(KEY, name): str(name) for name, of in runs.coords.items()}
    columns = {
        names.get(column, column): (
            EXTREME_DIM,
            np.array([row.get(column, np.nan) for row in rows]),
            _column_attributes(names.get(column, column), runs),
        )
        for column in dict.fromkeys(column for row in rows for column in row)
    }
    return xr.Dataset(columns, attrs={KIND: ResultKind.EXTREMES.value})


def _column_attributes(name: str, runs: xr.Dataset) -> dict[str, str]:
    """What a column is, and its unit, which is in the column ``unit`` for values of channels."""
    if name in runs.variables and name not in LABELS:
        return {
            key: str(runs[name].attrs[key]) for key in COPIED_ATTRIBUTES if key in runs[name].attrs
        }
    is_value = name.startswith(("most_probable", "p90", "another"))
    units = "1" if name in ("runs", "another_probability") else OF_CHANNEL if is_value else ""
    return quantity_attributes(LABELS.get(name, name.replace("_", " ")), units)


def figures_in(runs: xr.Dataset) -> list[str]:
    """Figures that are the largest or the smallest value of each run."""
    return [
        str(name) for name, variable in runs.data_vars.items() if SIDE_ATTRIBUTE in variable.attrs
    ]


def _runs_by_parameters(runs: xr.Dataset) -> Iterator[tuple[dict[str, Any], xr.Dataset]]:
    """Runs that differ in their seeds alone, with the values of the parameters. Runs without a
    plan are one group."""
    if DESIGN not in runs.attrs:
        yield {}, runs
        return
    for plan in plans(runs):
        name = {"study": plan.name} if plan.name else {}
        for values, at in combinations(plan):
            yield name | values, plan.runs.isel(run=at)


def _series_rows(values: dict[str, Any], runs: xr.Dataset) -> Iterator[dict[str, Any]]:
    for ends in _ends_of_runs(runs):
        for side, extreme in find_extremes(ends):
            yield {
                **values,
                "channel": ends.name,
                "side": side,
                "unit": ends.unit,
                "runs": extreme.runs,
                "most_probable": extreme.probable,
                **_interval_columns("most_probable", extreme.interval),
                "p90": extreme.p90,
                **_interval_columns("p90", extreme.p90_interval),
                **_interval_columns("another", extreme.another),
                "another_probability": extreme.probability,
                "by": extreme.method,
            }


def _ends_of_runs(runs: xr.Dataset) -> Iterable[SmallestAndLargest]:
    yield from ends_of_figures(runs, figures_in(runs))
    if "motion" in runs:
        yield from ends_of_motions(runs)
        yield from ends_of_channels(runs)


def _interval_columns(name: str, interval: tuple[float, float]) -> dict[str, float]:
    low, high = interval
    return {f"{name}_low": low, f"{name}_high": high}


def _extreme_by_law(law: gumbel.Gumbel, sign: float) -> SeedExtremes:
    rare = gumbel.length_ratio(P90)
    return SeedExtremes(
        sign * law.expected_maximum(1.0),
        _signed_interval(law.confidence_interval(1.0), sign),
        sign * law.expected_maximum(rare),
        _signed_interval(law.confidence_interval(rare), sign),
        _signed_interval(law.prediction_interval(1.0), sign),
        gumbel.INTERVAL_PROBABILITY,
        GUMBEL_METHOD,
        law.windows,
    )


def _extreme_by_order(maxima: np.ndarray, sign: float) -> SeedExtremes:
    """By order statistics."""
    most_probable = np.exp(-1.0)
    held = gumbel.find_prediction(maxima)
    return SeedExtremes(
        sign * float(np.quantile(maxima, most_probable)),
        _signed_interval(gumbel.find_confidence(maxima, most_probable), sign),
        sign * float(np.quantile(maxima, P90)),
        _signed_interval(gumbel.find_confidence(maxima, P90), sign),
        _signed_interval((held.low, held.high), sign),
        held.probability,
        ORDER_METHOD,
        maxima.size,
    )


def _raise_to_lowest(extreme: SeedExtremes, lowest: float) -> SeedExtremes:
    """Extremes of which none is below the ``lowest`` value of the channel."""

    def raise_interval(interval: tuple[float, float]) -> tuple[float, float]:
        return max(interval[0], lowest), max(interval[1], lowest)

    return extreme._replace(
        probable=max(extreme.probable, lowest),
        interval=raise_interval(extreme.interval),
        p90=max(extreme.p90, lowest),
        p90_interval=raise_interval(extreme.p90_interval),
        another=raise_interval(extreme.another),
    )


def _signed_interval(ends: Sequence[float] | np.ndarray, sign: float) -> tuple[float, float]:
    """An interval of sign x; an end that so few runs do not bound is infinite."""
    low, high = np.sort(sign * np.asarray(ends))
    return float(low), float(high)


# The table of a study as comma-separated values.

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
    plan_rows = [(plan, row) for plan in plans for row in effects.rows(plan)]
    judged = {_row_key(j.plan, j.worst.name, j.values): j for p in plans for j in judge_plan(p)}
    names: dict[str, PlanRuns] = {}
    for plan, row in plan_rows:
        names |= {name: plan for name in row.values if name not in names}
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    heads = (_head_columns(name, plan, units) for name, plan in names.items())
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
    for plan, row in plan_rows:
        cells = _value_columns(plan, row, list(names), units)
        judgement = judged.get(_row_key(plan, row.figure, row.values))
        row_cells = [*cells, *_criterion_columns(judgement, units)]
        table.writerow([escape_unprintable(x) if isinstance(x, str) else x for x in row_cells])
    return text.getvalue()


def _row_key(plan: PlanRuns, figure: str, values: Mapping[str, object]) -> Hashable:
    return (plan.name, figure, *values.values())


def _criterion_columns(of: JudgedCriterion | None, units: Units) -> list[str]:
    """What a criterion comes to at values of the parameters; empty for other figures."""
    if of is None:
        return ["" for _ in CRITERION_COLUMNS]
    worst = of.worst
    factor = units.display_unit(worst.unit).factor
    numbers = (f"{factor * x:.6g}" for x in (worst.value, worst.limit, worst.margin))
    return [*numbers, str(of.met), "yes" if of.is_met else "no", worst.source]


def _head_columns(name: str, plan: PlanRuns, units: Units) -> str:
    unit = units.display_unit(plan.unit(name)).unit
    return f"{name} [{unit}]" if unit else name


def _value_columns(plan: PlanRuns, row: EffectRow, names: list[str], units: Units) -> Iterator[str]:
    yield row.plan
    for name in names:
        value = row.values.get(name, "")
        factor = units.display_unit(plan.unit(name)).factor if name in row.values else 1.0
        yield f"{factor * value:.9g}" if isinstance(value, float) else str(value)
    unit, factor = units.display_unit(row.unit)
    yield from (row.figure, unit, str(row.spread.n))
    yield from (f"{factor * value:.6g}" for value in row.spread[1:])
    yield from _extreme_columns(plan, row, factor)


def _extreme_columns(plan: PlanRuns, row: EffectRow, factor: float) -> list[str]:
    """Most probable extreme and P90 with their intervals; empty where there are none."""
    ends_of_row = ends_of_figures(plan.runs.isel(run=row.runs), [row.figure])
    extremes_found = [extremes for ends in ends_of_row for _, extremes in find_extremes(ends)]
    if not extremes_found:
        return ["" for _ in EXTREME_COLUMNS]
    extreme = extremes_found[0]
    numbers = (extreme.probable, *extreme.interval, extreme.p90, *extreme.p90_interval)
    return [*(f"{factor * number:.6g}" for number in numbers), extreme.method]
