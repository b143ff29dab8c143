"""Extremes over seeds: the most probable extreme of a run, and P90, with their intervals.

Maxima that follow Gumbel's law are told by it. Others are told by their order: maxima of several
kinds (with and without an impact), or that something holds, follow no law of extremes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.results.validation import DESIGN
from hydrosim.results.variables import LABELS
from hydrosim.statistics.effects import combinations, plans
from hydrosim.statistics.ends import (
    SmallestAndLargest,
    ends_of_channels,
    ends_of_figures,
    ends_of_motions,
)
from hydrosim.statistics.figures import SIDE_ATTRIBUTE
from hydrosim.statistics.gumbel import (
    INTERVAL_PROBABILITY,
    Gumbel,
    fit_maxima,
    follows_gumbel,
    length_ratio,
)
from hydrosim.statistics.orders import find_confidence, find_prediction

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
            law = fit_maxima(maxima)
            follows = follows_gumbel(maxima, law)
            found = _by_law(law, sign) if follows else _by_order(maxima, sign)
            yield side, _raise_to_lowest(found, ends.lowest)


def extremes_over_seeds(runs: xr.Dataset) -> xr.Dataset:
    """Extremes of every motion, channel and figure in a dataset of many runs, in SI units.

    Rows are along ``extreme``: ``channel``, ``side`` ("smallest" or "largest"), ``unit``, values of
    the parameters of the study, and the number of ``runs``. ``to_dataframe()`` gives a table.
    Intervals hold 90 %; the interval of another run holds ``another_probability``. Raises
    InputError if no combination of parameters has `MIN_RUNS` runs.
    """
    rows = [row for values, own in _groups(runs) for row in _rows(values, own)]
    if not rows:
        most = max(own.sizes["run"] for _, own in _groups(runs))
        raise InputError(
            f"found no channel with different extremes in {MIN_RUNS} runs of one combination of"
            f" parameters, of which there are at most {most}; run more seeds."
        )
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {
        name: (
            EXTREME_DIM,
            np.array([row.get(name, np.nan) for row in rows]),
            _column_attributes(name, runs),
        )
        for name in names
    }
    return xr.Dataset(columns)


def _column_attributes(name: str, runs: xr.Dataset) -> dict[str, str]:
    """What a column is, and its unit, which is in the column ``unit`` for values of channels."""
    if name in runs.variables and name not in LABELS:
        return {
            key: str(runs[name].attrs[key]) for key in COPIED_ATTRIBUTES if key in runs[name].attrs
        }
    said = {"long_name": LABELS.get(name, name.replace("_", " "))}
    if name in ("runs", "another_probability"):
        return {**said, "units": "1"}
    is_value = name.startswith(("most_probable", "p90", "another"))
    return {**said, "comment": "each in the unit of its channel"} if is_value else said


def figures_in(runs: xr.Dataset) -> list[str]:
    """Figures that are the largest or the smallest value of each run."""
    return [str(name) for name, each in runs.data_vars.items() if SIDE_ATTRIBUTE in each.attrs]


def _groups(runs: xr.Dataset) -> Iterator[tuple[dict[str, Any], xr.Dataset]]:
    """Runs that differ in their seeds alone, with the values of the parameters. Runs without a
    plan are one group."""
    if DESIGN not in runs.attrs:
        yield {}, runs
        return
    for plan in plans(runs):
        name = {"study": plan.name} if plan.name else {}
        for values, at in combinations(plan):
            yield name | values, plan.runs.isel(run=at)


def _rows(values: dict[str, Any], runs: xr.Dataset) -> Iterator[dict[str, Any]]:
    for ends in _ends_of_runs(runs):
        for side, found in find_extremes(ends):
            yield {
                **values,
                "channel": ends.name,
                "side": side,
                "unit": ends.unit,
                "runs": found.runs,
                "most_probable": found.probable,
                **_interval_columns("most_probable", found.interval),
                "p90": found.p90,
                **_interval_columns("p90", found.p90_interval),
                **_interval_columns("another", found.another),
                "another_probability": found.probability,
                "by": found.method,
            }


def _ends_of_runs(runs: xr.Dataset) -> Iterable[SmallestAndLargest]:
    yield from ends_of_figures(runs, figures_in(runs))
    if "motion" in runs:
        yield from ends_of_motions(runs)
        yield from ends_of_channels(runs)


def _interval_columns(name: str, interval: tuple[float, float]) -> dict[str, float]:
    low, high = interval
    return {f"{name}_low": low, f"{name}_high": high}


def _by_law(law: Gumbel, sign: float) -> SeedExtremes:
    rare = length_ratio(P90)
    return SeedExtremes(
        sign * law.expected_maximum(1.0),
        _signed_interval(law.confidence(1.0), sign),
        sign * law.expected_maximum(rare),
        _signed_interval(law.confidence(rare), sign),
        _signed_interval(law.prediction(1.0), sign),
        INTERVAL_PROBABILITY,
        GUMBEL_METHOD,
        law.windows,
    )


def _by_order(maxima: np.ndarray, sign: float) -> SeedExtremes:
    """By order statistics."""
    most_probable = np.exp(-1.0)
    held = find_prediction(maxima)
    return SeedExtremes(
        sign * float(np.quantile(maxima, most_probable)),
        _signed_interval(find_confidence(maxima, most_probable), sign),
        sign * float(np.quantile(maxima, P90)),
        _signed_interval(find_confidence(maxima, P90), sign),
        _signed_interval((held.low, held.high), sign),
        held.probability,
        ORDER_METHOD,
        maxima.size,
    )


def _raise_to_lowest(found: SeedExtremes, lowest: float) -> SeedExtremes:
    """Extremes of which none is below the ``lowest`` value of the channel."""

    def raise_interval(interval: tuple[float, float]) -> tuple[float, float]:
        return max(interval[0], lowest), max(interval[1], lowest)

    return found._replace(
        probable=max(found.probable, lowest),
        interval=raise_interval(found.interval),
        p90=max(found.p90, lowest),
        p90_interval=raise_interval(found.p90_interval),
        another=raise_interval(found.another),
    )


def _signed_interval(ends: Sequence[float] | np.ndarray, sign: float) -> tuple[float, float]:
    """An interval of sign x; an end that so few runs do not bound is infinite."""
    low, high = np.sort(sign * np.asarray(ends))
    return float(low), float(high)
