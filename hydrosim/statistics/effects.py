"""Effects of the parameters of a study on its figures: tables over seeds, differences, Sobol's
indices.

Means have two 90 % intervals by Student's t: a confidence interval for the true mean, and a
prediction interval for one more seed. Both are exact if the figure is normal over seeds:

    mean +- t s / sqrt(n),     mean +- t s sqrt(1 + 1/n)

A figure that cannot be negative, such as a largest force, is not normal where these reach below
zero. Its intervals are on logarithms, by the delta method for the mean, and by Student's t of the
logarithms x of the values for another seed:

    mean exp(+- t s / (mean sqrt(n))),     exp(mean_x +- t s_x sqrt(1 + 1/n))

If a value is zero it has no logarithm. Then the second is Student's, and ends at zero.

Differences between two values of a parameter are taken seed by seed, in the same waves.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy

from hydrosim.errors import InputError
from hydrosim.files.display_units import CYCLES_SUFFIX
from hydrosim.results.runs_file import GATHERED, with_keys
from hydrosim.results.validation import DESIGN
from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY
from hydrosim.statistics.results import LOWEST_ATTRIBUTE

if TYPE_CHECKING:
    import xarray as xr

CYCLIC = "cyclic"
BOOTSTRAP_SEED = 1  # so that intervals of the same runs are the same
"""Attribute of coordinates that are frequencies of waves, or densities over these."""
SAMPLED_DESIGNS = ("latin_hypercube", "sobol", "sobol_indices")


class PlanRuns(NamedTuple):
    """A plan of a study, with its ``runs``: its ``name`` and ``design``, the keys of its
    ``parameters``, the requested ``figures``, and what is asked of those that are ``criteria``:
    limit, source, whether the limit is the least, and whether what never comes is too late."""

    name: str
    design: str
    parameters: Mapping[str, list[str]]
    figures: list[str]
    samples: int | None
    runs: xr.Dataset
    criteria: Mapping[str, Mapping[str, Any]] = MappingProxyType({})

    def short(self, parameter: str) -> str:
        """Last two words of the key, or the name of a linked parameter."""
        return " ".join(self.axis(parameter).split(".")[-2:]).replace("_", " ")

    def axis(self, parameter: str) -> str:
        """Coordinate of the values of a parameter: their names, or the first key."""
        return parameter if parameter in self.runs else self.parameters[parameter][0]

    def unit(self, name: str) -> str:
        """Unit of the values of a coordinate, empty if there is none."""
        attributes = self.runs[name].attrs
        unit = str(attributes.get("units", "")).removeprefix("1")
        return f"{unit}{CYCLES_SUFFIX}" if CYCLIC in attributes else unit


class SeedSpread(NamedTuple):
    """A figure over ``n`` seeds: its mean, the confidence interval of the mean, and the prediction
    interval of one more seed."""

    n: int
    mean: float
    low: float
    high: float
    another_low: float
    another_high: float


class EffectRow(NamedTuple):
    """A figure at ``values`` of the parameters, by coordinate."""

    plan: str
    values: dict[str, Any]
    figure: str
    unit: str
    spread: SeedSpread
    runs: np.ndarray


class Difference(NamedTuple):
    """Change of a figure from a ``low`` to a ``high`` value of a parameter: mean over seeds and its
    standard deviation. The last field is the fraction of seeds in which contacts changed mode
    differently."""

    parameter: str
    figure: str
    unit: str
    low: float
    high: float
    spread: SeedSpread
    std: float
    changed: float


class SobolIndex(NamedTuple):
    """Sobol's indices of a parameter for a figure, with intervals: its fraction of the variance
    alone, and with all interactions."""

    parameter: str
    figure: str
    first: tuple[float, float, float]
    total: tuple[float, float, float]


def plans(runs: xr.Dataset) -> list[PlanRuns]:
    """Plans of a file of runs. Raises InputError if it has none, or not their parameters."""
    source = runs.encoding.get("source", "the file")
    if DESIGN not in runs.attrs:
        raise InputError(
            f"{source}: has no attribute design, so its runs do"
            " not come from a study file of this version. Run the study again with hydrosim"
            " sweep."
        )
    runs = with_keys(runs)
    design = json.loads(runs.attrs[DESIGN])
    plan_runs = []
    for name, plan in design["plans"].items():
        runs_of_study = runs.isel(run=(runs["study"].values == name)) if name else runs
        figures = [figure for figure in design["figures"] if figure in runs]
        parts = plan["parameters"], figures, plan["samples"], runs_of_study
        plan_runs.append(PlanRuns(name, plan["design"], *parts, design.get("criteria", {})))
        if absent := [
            axis for axis in map(plan_runs[-1].axis, plan["parameters"]) if axis not in runs
        ]:
            raise InputError(f"{source}: found no variable {absent[0]}; the file was changed.")
    return plan_runs


def seed_spread(values: np.ndarray, lowest: float = -np.inf) -> SeedSpread:
    """Statistics of values (n,) without those that are NaN, which are never below the ``lowest``, 0
    or -inf; NaN if too few are left."""
    x = values[np.isfinite(values)]
    if x.size < 2:
        return SeedSpread(x.size, float(x[0]) if x.size else np.nan, *[np.nan] * 4)
    mean = float(x.mean())
    sure = _student_deviation(x) * x.size**-0.5
    other = _student_deviation(x) * (1.0 + 1.0 / x.size) ** 0.5
    if x.min() < lowest or lowest < 0.0 or mean == 0.0:
        return SeedSpread(x.size, mean, mean - sure, mean + sure, mean - other, mean + other)
    wide = np.exp(sure / mean)
    another = _another_interval(x) if x.min() > 0.0 else (max(mean - other, 0.0), mean + other)
    return SeedSpread(x.size, mean, mean / wide, mean * wide, *another)


def _student_deviation(x: np.ndarray) -> float:
    """Standard deviation (n,) times Student's t."""
    quantile = float(scipy.special.stdtrit(x.size - 1, 0.5 + 0.5 * INTERVAL_PROBABILITY))
    return quantile * float(x.std(ddof=1))


def _another_interval(x: np.ndarray) -> tuple[float, float]:
    """The interval of another value beside positive ones (n,), by their logarithms."""
    logarithms = np.log(x)
    middle = float(logarithms.mean())
    wide = _student_deviation(logarithms) * (1.0 + 1.0 / x.size) ** 0.5
    return float(np.exp(middle - wide)), float(np.exp(middle + wide))


def combinations(plan: PlanRuns) -> Iterator[tuple[dict[str, Any], np.ndarray]]:
    """Values of the parameters, by coordinate, with the indices (n,) of the runs of the plan that
    have them, in order."""
    names = [*dict.fromkeys(plan.axis(parameter) for parameter in plan.parameters)]
    names += ["varied"] if plan.design == "one_at_a_time" else []
    value_rows = list(zip(*(plan.runs[name].values.tolist() for name in names), strict=True))
    value_rows = value_rows or [()] * plan.runs.sizes["run"]
    places: dict[tuple[Any, ...], list[int]] = {}
    for k, values in enumerate(value_rows):
        places.setdefault(values, []).append(k)
    for values, at in places.items():
        yield dict(zip(names, values, strict=True)), np.array(at)


def rows(plan: PlanRuns) -> Iterator[EffectRow]:
    """Each figure at each combination of values, over seeds, in the order of the runs."""
    figures = {figure: plan.runs[figure].load() for figure in plan.figures}
    for values, at in combinations(plan):
        for figure, of in figures.items():
            unit = str(of.attrs.get("units", ""))
            lowest = float(of.attrs.get(LOWEST_ATTRIBUTE, -np.inf))
            yield EffectRow(plan.name, values, figure, unit, seed_spread(of.values[at], lowest), at)


def differences(plan: PlanRuns) -> Iterator[Difference]:
    """Effects in a plan that varies one parameter at a time, or only one parameter: each figure,
    from the smallest to the largest value of each numeric parameter."""
    for parameter, keys in plan.parameters.items():
        values, runs = plan.runs[keys[0]].values, plan.runs
        if plan.design == "one_at_a_time":
            varies_parameter = np.isin(runs["varied"].values, [parameter, ""])
            runs, values = runs.isel(run=varies_parameter), values[varies_parameter]
        if values.dtype.kind not in "if" or np.unique(values).size < 2:
            continue
        low, high = float(values.min()), float(values.max())
        ends = [_index_by_seed(runs, np.flatnonzero(values == end)) for end in (low, high)]
        seeds = [seed for seed in ends[0] if seed in ends[1]]
        pairs = np.array([[end[seed] for seed in seeds] for end in ends], dtype=np.int64)
        for figure in plan.figures:
            first, last = runs[figure].values[pairs]
            change = last - first
            unit = str(runs[figure].attrs.get("units", ""))
            finite = change[np.isfinite(change)]
            std = float(np.std(finite, ddof=1)) if finite.size > 1 else np.nan
            changed = _changed_fraction(runs, pairs)
            yield Difference(parameter, figure, unit, low, high, seed_spread(change), std, changed)


def _index_by_seed(runs: xr.Dataset, at: np.ndarray) -> dict[str, int]:
    """Index of each seed among the runs ``at``."""
    seeds = runs.seed.values[at].tolist() if "seed" in runs else [0] * at.size
    return {str(seed): k for seed, k in zip(seeds, at.tolist(), strict=True)}


def _changed_fraction(runs: xr.Dataset, pairs: np.ndarray) -> float:
    """Fraction of ``pairs`` (2, n) of runs whose contacts changed mode differently."""
    if "contact_sequence" not in runs:
        return np.nan
    first, last = runs.contact_sequence.values[pairs].astype(float)
    is_finite = np.isfinite(first) & np.isfinite(last)  # failed runs have none
    return float(np.mean((first != last)[is_finite])) if is_finite.any() else np.nan


def _missing_value_remedy(runs: xr.Dataset) -> str:
    """Remedy if some runs have no value."""
    if GATHERED in runs.attrs:
        return f"The study is unfinished ({runs.attrs[GATHERED]}): wait for the other runs."
    return "Choose ranges in which no run fails."


def indices(plan: PlanRuns) -> Iterator[SobolIndex]:
    """Sobol's indices of the mean over seeds, by the estimators of Saltelli et al. (2010) and
    Jansen, with bootstrap intervals (BCa, Efron 1987). Raises InputError if some run failed."""
    n, d = int(plan.samples or 0), len(plan.parameters)
    for figure in plan.figures:
        values = plan.runs[figure].values.reshape(n * (d + 2), -1).mean(axis=1)
        if not np.isfinite(values).all():
            raise InputError(
                f"{figure}: has no value in {np.sum(~np.isfinite(values))} of {values.size}"
                " samples; expected a value in each, because Sobol's indices need all."
                f" {_missing_value_remedy(plan.runs)}"
            )
        # scipy's own bootstrap of these indices takes no seed
        values -= values[: 2 * n].mean()
        sets = values[:n], values[n : 2 * n], values[2 * n :].reshape(d, n)
        shares = _sobol_shares(sets, np.arange(n))
        interval = scipy.stats.bootstrap(
            [np.arange(n)],
            partial(_sobol_shares, sets),
            confidence_level=INTERVAL_PROBABILITY,
            random_state=BOOTSTRAP_SEED,
        ).confidence_interval
        for k, parameter in enumerate(plan.parameters):
            first, total = (
                (float(shares[i, k]), float(interval.low[i, k]), float(interval.high[i, k]))
                for i in range(2)
            )
            yield SobolIndex(parameter, figure, first, total)


def _sobol_shares(sets: tuple[np.ndarray, ...], chosen: np.ndarray, axis: int = -1) -> np.ndarray:
    """First and total indices (2, d, ...) of the ``chosen`` samples (..., n) of three ``sets``: A
    (n,), B (n,) and, for each of d parameters, A with that of B (d, n)."""
    A, B, AB = (values[..., chosen] for values in sets)
    variance = np.var([A, B], axis=(0, -1))
    first = np.mean(B * (AB - A), axis=-1) / variance
    total = 0.5 * np.mean((A - AB) ** 2, axis=-1) / variance
    return np.stack([first, total])


def correlations(plan: PlanRuns) -> Iterator[tuple[str, str, float]]:
    """Spearman's rank correlation of each figure with each parameter of a plan of samples."""
    for figure in plan.figures:
        y = plan.runs[figure].values
        is_finite = np.isfinite(y)
        for parameter in plan.parameters:
            x = plan.runs[plan.axis(parameter)].values
            yield (
                figure,
                parameter,
                float(scipy.stats.spearmanr(x[is_finite], y[is_finite]).statistic),
            )
