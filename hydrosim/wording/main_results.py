"""First results of a report: criteria, the end of the run, the sea, loads, largest values."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.case.tables import plain
from hydrosim.presentation.document import Cell, Node, Outcome, Sentence, Table, Verdict
from hydrosim.statistics.extremes import LAWS
from hydrosim.statistics.orders import VALUES_FOR_INTERVAL
from hydrosim.statistics.statistics import EXTREME_SIDES
from hydrosim.wording.channels import StatisticsChannel, channels_of
from hydrosim.wording.criteria import criteria_nodes
from hydrosim.wording.run import element_verdicts, solution_verdicts, status_verdict
from hydrosim.wording.sections import lines_of

NO_CRITERIA = "The case asks for no criteria."
CRITERIA_HINT = "Limits with their sources under `criteria:` in the case are judged in the results."
ONE_SEA = (
    "These results are of one sea: one draw of random waves (seed {}). In another draw of the same"
    " spectrum, largest values, crawl and criteria come out otherwise. Decide on several draws."
)
MORE_SEAS = (
    f"For several draws, run a study with `seeds: 1-{VALUES_FOR_INTERVAL}` by"
    " `hydrosim sweep`. It judges the same limits over all of its seas."
)
WARNINGS_HINT = '{} under "Assumptions and warnings". Read {} before you use the results.'


def main_results(run: xr.Dataset) -> Iterator[Node]:
    """Criteria met or not, how the run ended, for which sea, what is doubtful, and which loads are
    too large."""
    yield from list(criteria_nodes(run)) or [Sentence(NO_CRITERIA)]
    yield status_verdict(run)
    if _is_of_random_waves(run):
        drawn = np.unique(np.atleast_1d(run.attrs.get("seeds", [])))
        yield Sentence(ONE_SEA, [", ".join(map(str, drawn))])
    yield from (each for each in solution_verdicts(run) if each.outcome is not Outcome.GOOD)
    yield from element_verdicts(run)
    if count := len(lines_of(run, "warnings")):
        words = ("A warning is", "it") if count == 1 else (f"{count} warnings are", "them")
        yield Verdict(Outcome.WARNING, WARNINGS_HINT, words)


def next_steps(run: xr.Dataset) -> Iterator[Node]:
    """Criteria and seeds that the run lacks, and how to have them."""
    if not list(criteria_nodes(run)):
        yield Sentence(CRITERIA_HINT)
    if _is_of_random_waves(run):
        yield Sentence(MORE_SEAS)


def _is_of_random_waves(run: xr.Dataset) -> bool:
    """Whether waves or gusts of the run are drawn at random."""
    water = plain(str(run.attrs.get("case_resolved", ""))).get("environment") or {}
    gusts = (water.get("wind") or {}).get("gusts")
    return bool(gusts) or any("seed" in train for train in water.get("waves") or [])


def largest_values(found: xr.Dataset) -> Iterator[Node]:
    """The extreme of each channel on the side that is further from zero."""
    rows = [_largest(found, channel) for channel in channels_of(found)]
    head = ("channel", "largest seen", "most probable", "90 % interval", "another run")
    yield Table(head, rows, "Largest values")
    yield Sentence(
        "The most probable largest value and the intervals are extremes of such a run. Channels"
        " without them are not stationary: the statistics say why."
    )


def _largest(found: xr.Dataset, channel: StatisticsChannel) -> list[Cell]:
    side = max(EXTREME_SIDES, key=lambda side: abs(channel.figure(found, side).number))
    seen = channel.figure(found, side)
    if channel.basis(found, side) not in LAWS:
        return [channel.title, seen, "", "", ""]
    likely = channel.extreme(found, side, "mpm")
    return [
        channel.title,
        seen,
        likely,
        *(channel.interval(found, side, of) for of in ("mpm", "predicted")),
    ]
