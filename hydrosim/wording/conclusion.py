"""The conclusion of a report: criteria, verdicts, largest values."""

from __future__ import annotations

from collections.abc import Iterator

import xarray as xr

from hydrosim.presentation.document import Cell, Node, Sentence, Table
from hydrosim.statistics.extremes import LAWS
from hydrosim.statistics.statistics import SIDES, statistics
from hydrosim.wording.channels import Channel, channels_of
from hydrosim.wording.criteria import criteria_nodes
from hydrosim.wording.run import verdicts
from hydrosim.wording.statistics import grown_from, has_statistics

ASK = (
    "The case asks for no criteria. Give limits with their sources under `criteria:` to have them"
    " judged here."
)


def conclusion(run: xr.Dataset) -> Iterator[Node]:
    """Criteria met or not, how far the run can be trusted, the largest values."""
    criteria = list(criteria_nodes(run))
    yield from criteria or [Sentence(ASK)]
    yield from verdicts(run)
    yield from _largest_values(run)


def _largest_values(run: xr.Dataset) -> Iterator[Node]:
    """The extreme of each channel on the side that is further from zero."""
    if not has_statistics(run):
        return
    found = statistics(run, grown_from(run))
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
