"""The conclusion of a report: criteria, the sea they hold for, verdicts, largest values."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.case.tables import plain
from hydrosim.presentation.document import Cell, Node, Sentence, Table
from hydrosim.statistics.extremes import LAWS
from hydrosim.statistics.orders import ENOUGH
from hydrosim.statistics.statistics import SIDES
from hydrosim.wording.channels import Channel, channels_of
from hydrosim.wording.criteria import criteria_nodes
from hydrosim.wording.run import verdicts

ASK = (
    "The case asks for no criteria. Give limits with their sources under `criteria:` to have them"
    " judged here."
)


ONE_SEA = (
    "These results are of one sea: one draw of random waves (seed {}). In another draw of the same"
    " spectrum, largest values, crawl and criteria come out otherwise. Before you decide, run a"
    f" study with `seeds: 1-{ENOUGH}` by `hydrosim sweep`, which judges the same limits over all"
    " of its seas."
)


def conclusion(run: xr.Dataset) -> Iterator[Node]:
    """Criteria met or not, for which sea, and how far the run can be trusted."""
    criteria = list(criteria_nodes(run))
    yield from criteria or [Sentence(ASK)]
    yield from _one_sea(run)
    yield from verdicts(run)


def _one_sea(run: xr.Dataset) -> Iterator[Node]:
    """That the run is of one sea, where its waves or its gusts are drawn at random."""
    water = plain(str(run.attrs.get("case_resolved", ""))).get("environment") or {}
    gusts = (water.get("wind") or {}).get("gusts")
    if gusts or any("seed" in train for train in water.get("waves") or []):
        drawn = np.unique(np.atleast_1d(run.attrs.get("seeds", [])))
        yield Sentence(ONE_SEA, [", ".join(map(str, drawn))])


def largest_values(found: xr.Dataset) -> Iterator[Node]:
    """The extreme of each channel on the side that is further from zero."""
    rows = [_largest(found, channel) for channel in channels_of(found)]
    head = ("channel", "largest seen", "most probable", "90 % interval", "another run")
    yield Table(head, rows, "Largest values")
    yield Sentence(
        "The most probable largest value and the intervals are extremes of such a run. Channels"
        " without them are not stationary: the statistics say why."
    )


def _largest(found: xr.Dataset, channel: Channel) -> list[Cell]:
    side = max(SIDES, key=lambda side: abs(channel.figure(found, side).number))
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
