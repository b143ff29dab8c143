"""Criteria of a run: a register of values, limits and margins, and whether all are met."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite, isinf

import xarray as xr

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
from hydrosim.statistics.criteria import Criterion, criteria_of


def criteria_nodes(run: xr.Dataset) -> Iterator[Node]:
    """A verdict on all criteria of a run, one on each that is not met, and the register."""
    found = criteria_of(run)
    if not found:
        return
    yield criteria_verdict(found)
    yield from (criterion_not_met(each) for each in found if not each.is_met)
    head = ("criterion", "value", "limit", "margin", "used", "", "source of the limit")
    rows = [[*criterion_figures(each), met_or_not(each), each.source] for each in found]
    yield Table(head, rows, "Criteria")
    yield meanings(found)


def criteria_verdict(
    found: Sequence[Criterion], where: str = "", best: Outcome = Outcome.GOOD
) -> Verdict:
    """How many criteria are met ``where``; the ``best`` outcome if all are."""
    met = sum(each.is_met for each in found)
    counts = [str(met), str(len(found))]
    text = f"{{}} of {{}} criteria are met{where}."
    if met < len(found):
        return Verdict(Outcome.BAD, text, counts)
    used = [each for each in found if isfinite(each.utilisation)]
    if not used:
        return Verdict(best, text, counts)
    most = max(used, key=lambda each: each.utilisation)
    share = Value(most.utilisation, "share", 3)
    text += " {} uses the most of its limit: {}."
    return Verdict(best, text, [*counts, most.name, share])


def criterion_not_met(of: Criterion, at: str = "", more: str = "") -> Verdict:
    """What a criterion comes to ``at`` a place, what is allowed, and ``more``."""
    if of.missing:
        return Verdict(Outcome.BAD, "{} has no value: {}", [of.name, of.missing])
    side = "at least" if of.is_least else "at most"
    return Verdict(
        Outcome.BAD,
        "{}: {} is {}{}; allowed is {} {}.{}",
        [of.name, of.what, _value(of), at, side, Value(of.limit, of.unit), more],
    )


def criterion_figures(of: Criterion) -> list[Cell]:
    """Name, value, limit, margin, and the share of the limit that is used."""
    limit, margin = (Value(number, of.unit) for number in (of.limit, of.margin))
    return [of.name, _value(of), limit, margin, Value(of.utilisation, "share", 3)]


def _value(of: Criterion) -> Value | str:
    return "never" if isinf(of.value) else Value(of.value, of.unit)


def met_or_not(of: Criterion) -> str:
    """The verdict in a table."""
    return "met" if of.is_met else "NOT MET"


def meanings(found: Sequence[Criterion]) -> List:
    """What each criterion is of, for readers who ask for more."""
    return List([Sentence("{}: {}", [each.name, each.what]) for each in found], detail=True)
