"""Runs that differ in their seeds alone: where each motion lies, and extremes over seeds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr

from hydrosim.presentation.document import Between, Cell, Node, Sentence, Table, Value
from hydrosim.presentation.layout import text_of
from hydrosim.presentation.units import units_of
from hydrosim.results.stages import FIGURES, TIME
from hydrosim.statistics.effects import Plan, combinations, spread
from hydrosim.statistics.gumbel import Gumbel, exceeding, fit_maxima, follows_gumbel
from hydrosim.statistics.orders import ENOUGH, find_confidence, find_prediction
from hydrosim.statistics.statistics import SIDES
from hydrosim.wording.run import unit_of

RUNS = 8
"""Runs that extremes over seeds take."""
P90 = 0.9
"""Probability that the largest of a run is below."""
SHOWN = 5
"""Combinations of parameters that are shown."""
LAW = "Gumbel's law"
ORDER = "order of the runs"


def seed_nodes(plan: Plan) -> Iterator[Node]:
    """Extremes over the seeds of each combination of the parameters of a plan."""
    yield Sentence(
        f"Intervals hold 90 %, over {RUNS} seeds or more. Where maxima follow Gumbel's law they are"
        " by it; else by the order of the runs, without a law.",
        detail=True,
    )
    each = list(combinations(plan))
    for values, at in each[:SHOWN]:
        of = plan.runs.isel(run=at)
        title = named_values(plan, values)
        yield from nodes_over_seeds(of, f"{title or 'All'}: {at.size} runs")
    if len(each) > SHOWN:
        more = str(len(each) - SHOWN)
        yield Sentence("{} more combinations are in motion, in the file.", [more])


def nodes_over_seeds(runs: xr.Dataset, title: str = "") -> Iterator[Node]:
    """Between which values each motion is, extremes of another run, stages over runs."""
    moving = list(_moving(runs))
    head = ("motion", "smallest", "largest")
    ends: list[list[Cell]] = [
        [name, Value(low.min(), unit), Value(high.max(), unit)] for name, unit, low, high in moving
    ]
    yield Table(head, ends, title)
    rows = [row for each in moving if each[2].size >= RUNS for row in _extremes(*each)]
    if rows:
        title = "The most probable extreme of a run, and where the extreme of another run lies"
        probable = ("motion", "side", "most probable", "interval", "another run")
        yield Table(probable, [row[:5] for row in rows], title)
        rare = ("motion", "side", "P90", "interval", "by")
        title = "The extreme that 90 % of runs do not exceed"
        yield Table(rare, [[*row[:2], *row[5:]] for row in rows], title)
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


def _moving(runs: xr.Dataset) -> Iterator[tuple[str, str, np.ndarray, np.ndarray]]:
    """Name, unit, smallest and largest value of each run, of each motion that there is."""
    for body in map(str, runs.body.values):
        for dof in map(str, runs.dof.values):
            motion = runs.motion.sel(body=body, dof=dof).dropna("run", how="all")
            if motion.sizes["run"] and float(motion.sel(statistic="std").max()) > 0.0:
                low, high = (motion.sel(statistic=side).values for side in SIDES)
                yield f"{body} {dof}", unit_of(dof), low, high


def _extremes(name: str, unit: str, low: np.ndarray, high: np.ndarray) -> Iterator[list[Cell]]:
    """Of the smallest and of the largest value of each run."""
    for side, maxima, sign in zip(SIDES, (-low, high), (-1.0, 1.0), strict=True):
        if np.ptp(maxima) > 0.0:
            law = fit_maxima(maxima)
            follows = follows_gumbel(maxima, law)
            cells = _by_law(law, sign, unit) if follows else _by_order(maxima, sign, unit)
            yield [name, side, *cells]


def _by_law(law: Gumbel, sign: float, unit: str) -> list[Cell]:
    rare = exceeding(P90)
    return [
        Value(sign * law.expected(1.0), unit),
        _between(law.confidence(1.0), sign, unit),
        _between(law.prediction(1.0), sign, unit),
        Value(sign * law.expected(rare), unit),
        _between(law.confidence(rare), sign, unit),
        LAW,
    ]


def _by_order(maxima: np.ndarray, sign: float, unit: str) -> list[Cell]:
    """By order statistics: maxima that are of several kinds (with and without an impact), or that
    something holds, follow no law of extremes."""
    most_probable = np.exp(-1.0)
    held = find_prediction(maxima)
    more = "" if maxima.size >= ENOUGH else f"; {ENOUGH} runs hold 90 %"
    return [
        Value(sign * float(np.quantile(maxima, most_probable)), unit),
        _between(find_confidence(maxima, most_probable), sign, unit),
        _between((held.low, held.high), sign, unit),
        Value(sign * float(np.quantile(maxima, P90)), unit),
        _between(find_confidence(maxima, P90), sign, unit),
        f"{ORDER} ({100.0 * held.probability:.0f} %{more})",
    ]


def _between(ends: Sequence[float] | np.ndarray, sign: float, unit: str) -> Between:
    """An interval of sign x; an end that so few runs do not bound is infinite."""
    low, high = np.sort(sign * np.asarray(ends))
    return Between(float(low), float(high), unit)


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
