"""Criteria of a run: a register of values, limits and margins, and whether all are met."""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import nan
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from hydrosim.case.criteria import CRITERIA
from hydrosim.errors import InputError
from hydrosim.presentation.document import (
    Cell,
    List,
    Node,
    Outcome,
    Sentence,
    Table,
    Value,
    Verdict,
)
from hydrosim.statistics.figures import Figure, figure_of
from hydrosim.statistics.results import StageResult


class Criterion(NamedTuple):
    """A criterion of a run: its ``value`` and ``limit`` in an SI ``unit``, its ``source``; why the
    run has no value, as ``missing``."""

    name: str
    what: str
    value: float
    limit: float
    unit: str
    source: str
    is_least: bool
    missing: str = ""

    @property
    def is_met(self) -> bool:
        """Whether the value keeps the limit. A run that never comes to the phase keeps it."""
        if self.missing:
            return False
        beyond = self.value < self.limit if self.is_least else self.value > self.limit
        return not beyond

    @property
    def margin(self) -> float:
        """How far the value is from the limit, negative where the limit is exceeded."""
        return self.value - self.limit if self.is_least else self.limit - self.value

    @property
    def utilisation(self) -> float:
        """The share of the limit that is used; NaN for a least value, or a limit of zero."""
        used = not self.is_least and self.limit != 0.0
        return self.value / self.limit if used else float("nan")


def criteria_of(run: xr.Dataset) -> list[Criterion]:
    """The criteria that the case of a run asks for, with what the run comes to."""
    asked = json.loads(str(run.attrs.get(CRITERIA, "[]")))
    return [_held(run, each) for each in asked]


def criteria_nodes(run: xr.Dataset) -> Iterator[Node]:
    """A verdict on all criteria, one on each that is not met, and the register."""
    found = criteria_of(run)
    if not found:
        return
    yield _verdict(found)
    yield from (_broken(each) for each in found if not each.is_met)
    head = ("criterion", "value", "limit", "margin", "used", "", "source of the limit")
    yield Table(head, [_row(each) for each in found], "Criteria")
    yield List([Sentence("{}: {}", [each.name, each.what]) for each in found], detail=True)


def _held(run: xr.Dataset, asked: dict[str, Any]) -> Criterion:
    figure = _figure(asked)
    limit = float(asked["limit"])
    fixed = (str(asked["source"]), figure.at_least)
    try:
        found = figure_of(run, figure)
    except InputError as error:
        return Criterion(figure.name, str(figure), nan, limit, "", *fixed, str(error))
    unit = str(found.attrs["units"])
    return Criterion(figure.name, str(figure), float(found), limit, unit, *fixed)


def _figure(asked: dict[str, Any]) -> Figure | StageResult:
    """What a criterion is of: a statistic of a channel, or a result of contacts."""
    name = str(asked["name"])
    if asked.get("result"):
        return StageResult(name, asked["result"], asked["group"], None, None)
    return Figure(name, asked["channel"], asked["statistic"], asked["phase"])


def _verdict(found: list[Criterion]) -> Verdict:
    met = sum(each.is_met for each in found)
    counts = [str(met), str(len(found))]
    if met < len(found):
        return Verdict(Outcome.BAD, "{} of {} criteria are met.", counts)
    used = [each for each in found if np.isfinite(each.utilisation)]
    if not used:
        return Verdict(Outcome.GOOD, "{} of {} criteria are met.", counts)
    most = max(used, key=lambda each: each.utilisation)
    share = Value(most.utilisation, "share", 3)
    text = "{} of {} criteria are met. {} uses the most of its limit: {}."
    return Verdict(Outcome.GOOD, text, [*counts, most.name, share])


def _broken(of: Criterion) -> Verdict:
    if of.missing:
        return Verdict(Outcome.BAD, "{} has no value: {}", [of.name, of.missing])
    values = [Value(of.value, of.unit), Value(of.limit, of.unit)]
    side = "at least" if of.is_least else "at most"
    return Verdict(
        Outcome.BAD,
        "{}: {} is {}; allowed is {} {}.",
        [of.name, of.what, values[0], side, values[1]],
    )


def _row(of: Criterion) -> list[Cell]:
    figures = (Value(x, of.unit) for x in (of.value, of.limit, of.margin))
    used = Value(of.utilisation, "share", 3)
    return [of.name, *figures, used, "met" if of.is_met else "NOT MET", of.source]
